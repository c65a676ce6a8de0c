"""A seasonal change of any cause."""

import numpy as np

from pvlib_fem.effects._effect import Effect, Parameter, Terms


def terms(
    poa_global: np.ndarray, day_angle: np.ndarray, *, winter: float, spring: float
) -> Terms:
    r"""
    Share of irradiance that varies with the season [1]_.

    .. math::

        \mathrm{heat} = (\mathrm{winter} \cdot \cos(\mathrm{day\_angle})
        + \mathrm{spring} \cdot \sin(\mathrm{day\_angle}))
        \cdot \mathrm{poa\_global}

    ``winter`` is the change at the turn of the year, when it is winter north of
    the equator, and ``spring`` the change on the first of April. Albedo, longwave loss,
    a wrong tilt and a drift within one year have this signature.

    References
    ----------
    .. [1] F. P. Incropera et al., "Fundamentals of Heat and Mass Transfer",
       section 1.2: radiation as 4·ε·σ·T³, 1 % more per kelvin. That is 0.2 to 0.3 %
       of the whole loss, and a seasonal change of ±0.03 for a year of ±10 K.
    """
    swing = winter * np.cos(day_angle) + spring * np.sin(day_angle)
    return Terms(heat=swing * poa_global)


EFFECT = Effect(
    "season",
    terms,
    {
        "winter": Parameter(0.0, -0.2, 0.2, "-"),
        "spring": Parameter(0.0, -0.2, 0.2, "-"),
    },
    confounder=True,
    title="a seasonal change of the absorbed irradiance",
    decided_by="a second year, or an albedometer",
    confused_with=(
        "poa_misalignment",
        "rear_irradiance",
        "temperature_gain",
        "irradiance_sensor_drift",
        "soiling",
    ),
)
