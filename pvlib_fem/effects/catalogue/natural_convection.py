"""Natural convection at a warm module."""

import numpy as np

from pvlib_fem.effects._effect import Effect, Parameter, Terms


def terms(
    temp_base: np.ndarray, temp_air: np.ndarray, wind_speed: np.ndarray, *, free: float
) -> Terms:
    r"""
    Loss that grows with over-temperature in calm air [1]_.

    .. math::

        \mathrm{loss} = \mathrm{free} \cdot
        \frac{\sqrt[3]{|\mathrm{temp\_base} - \mathrm{temp\_air}| / 15} - 1}
        {\sqrt{1 + \mathrm{wind\_speed}^2}}

    Natural convection grows with the third root of over-temperature. ``free`` is the
    convection of both faces at 15 K, which the steady model already includes. At a tilt
    of 35°, TARP's 9.482/(7.283 - cos) above and 1.810/(1.382 + cos) below give 5.6
    W/(m² K), or 7.5 relative to incident irradiance. Natural and forced convection add
    as squares; at 1 m/s they are about equal.

    References
    ----------
    .. [1] U.S. Department of Energy, "EnergyPlus Engineering Reference", outside
       surface heat balance: TARP (Walton 1983), and the sum of squares of
       MoWiTT and DOE-2.
    """
    warmer = np.cbrt(np.abs(temp_base - temp_air) / 15.0) - 1.0
    return Terms(loss=free * warmer / np.hypot(1.0, wind_speed))


EFFECT = Effect(
    "natural_convection",
    terms,
    {"free": Parameter(0.0, 0.0, 30.0, "W/(m² K)")},
    confounder=True,
    title="natural convection in calm air",
    decided_by="a second module at open circuit, and wind measured at the module",
    confused_with=(
        "wind_shape",
        "air_shield",
        "season",
        "poa_misalignment",
        "temperature_gain",
        "an efficiency that falls as the module warms",
        "an irradiance sensor that is not linear",
    ),
)
