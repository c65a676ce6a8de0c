"""A shield that the sun warms, and the air temperature sensor in it."""

import numpy as np

from pvlib_fem.effects._effect import Effect, Parameter, Terms


def terms(
    poa_global: np.ndarray, wind_speed: np.ndarray, *, warm: float, calm: float = 1.2
) -> Terms:
    r"""
    Air that is measured too warm in sun and calm [1]_.

    .. math::

        \mathrm{offset} = -\mathrm{warm} \cdot \mathrm{poa\_global} / 1000
        \cdot \exp(-\mathrm{wind\_speed} / \mathrm{calm})

    ``warm`` is the error at 1000 W/m² without wind: 2 to 4 K in a shield that is
    not aspirated. ``calm`` is the wind at which it has fallen to a third. [m/s]

    References
    ----------
    .. [1] R. Nakamura and L. Mahrt, "Air Temperature Measurement Errors in
       Naturally Ventilated Radiation Shields", J. Atmos. Oceanic Technol. 22,
       1046 (2005), :doi:`10.1175/JTECH1762.1`.
    """
    still = np.exp(-wind_speed / calm)
    return Terms(offset=-warm * poa_global / 1000.0 * still)


EFFECT = Effect(
    "air_shield",
    terms,
    {"warm": Parameter(0.0, 0.0, 6.0, "K")},
    confounder=True,
    title="an air temperature sensor heated by the sun in calm air",
    decided_by="a second, aspirated air temperature sensor",
    confused_with=(
        "wind_shape",
        "natural_convection",
        "poa_misalignment",
        "season",
        "the steady model's coefficients, which absorb most of it",
    ),
)
