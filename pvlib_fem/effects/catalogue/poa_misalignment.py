"""An irradiance sensor in another plane than the module."""

import numpy as np

from pvlib_fem.effects._effect import Effect, Parameter, Terms


def terms(
    beam_by_tilt: np.ndarray,
    beam_by_azimuth: np.ndarray,
    *,
    tilt: float,
    azimuth: float,
) -> Terms:
    r"""
    Difference of beam irradiance between the module and a misaligned sensor [1]_.

    .. math::

        \mathrm{heat} = \mathrm{tilt} \cdot \mathrm{beam\_by\_tilt}
        + \mathrm{azimuth} \cdot \mathrm{beam\_by\_azimuth}

    ``tilt`` and ``azimuth`` are the angles of the module minus the stated angles, which
    are assumed for the sensor. The equation is of first order in both. On a tracker
    ``tilt`` is the rotation about its axis, and ``azimuth`` that about the vertical.

    References
    ----------
    .. [1] J. A. Duffie and W. A. Beckman, "Solar Engineering of Thermal
       Processes", section 1.6, from which the slopes are derived.
    """
    return Terms(heat=tilt * beam_by_tilt + azimuth * beam_by_azimuth)


EFFECT = Effect(
    "poa_misalignment",
    terms,
    {
        "tilt": Parameter(0.0, -10.0, 10.0, "°"),
        "azimuth": Parameter(0.0, -20.0, 20.0, "°"),
    },
    confounder=True,
    geometric=True,
    title="an irradiance sensor in another plane than the modules",
    decided_by="an inclinometer, or irradiance before and after noon on clear days",
    confused_with=(
        "season",
        "rear_irradiance",
        "thermal_storage",
        "shading",
        "a clock that is late",
    ),
)
