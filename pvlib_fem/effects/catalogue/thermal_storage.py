"""A second, slower mass: a roof, the ground, a frame."""

import numpy as np

from pvlib_fem.effects._effect import Effect, Parameter, Terms


def terms(
    poa_stored_1h: np.ndarray,
    poa_stored_3h: np.ndarray,
    air_stored: np.ndarray,
    *,
    hour: float,
    three_hours: float,
    air: float,
) -> Terms:
    r"""
    Heat that a slow mass stores in the morning and releases in the evening [1]_.

    .. math::

        \mathrm{heat} = \mathrm{hour} \cdot \mathrm{poa\_stored\_1h}
        + \mathrm{three\_hours} \cdot \mathrm{poa\_stored\_3h}
        + \mathrm{air} \cdot \mathrm{air\_stored}

    ``hour`` and ``three_hours`` are shares of irradiance, by the time constant of the
    mass; ``air`` is its heat exchange with the module per kelvin of change of the air.

    References
    ----------
    .. [1] P. Bacher and H. Madsen, "Identifying suitable models for the heat
       dynamics of buildings", Energy and Buildings 43, 1511 (2011),
       :doi:`10.1016/j.enbuild.2011.02.005`: models of one mass and of more.
    """
    return Terms(
        heat=hour * poa_stored_1h + three_hours * poa_stored_3h + air * air_stored
    )


EFFECT = Effect(
    "thermal_storage",
    terms,
    {
        "hour": Parameter(0.0, -0.1, 0.8, "-"),
        "three_hours": Parameter(0.0, -0.1, 0.8, "-"),
        "air": Parameter(0.0, -5.0, 20.0, "W/(m² K)"),
    },
    confounder=True,
    title="heat stored behind the modules",
    decided_by="a temperature sensor on the roof or in the cavity behind",
    confused_with=(
        "poa_misalignment",
        "natural_convection",
        "season",
        "temperature_gain",
        "a clock that is late",
        "the capacity, or the time constant",
    ),
)
