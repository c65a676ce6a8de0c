"""Longwave exchange, which grows with the fourth power of temperature."""

import numpy as np

from pvlib_fem.drivers._sky_deficit import STEFAN_BOLTZMANN, ZERO_CELSIUS
from pvlib_fem.effects._effect import Effect, Parameter, Terms

USUAL = 298.15  # K, temperature at which the steady model already includes it


def terms(temp_base: np.ndarray, temp_air: np.ndarray, *, share: float) -> Terms:
    r"""
    Loss by longwave exchange with surroundings at air temperature, above 25 °C [1]_.

    .. math::

        \mathrm{loss} = \mathrm{share} \cdot \sigma
        ((\mathrm{temp\_air} + \mathrm{temp\_base})
        (\mathrm{temp\_air}^2 + \mathrm{temp\_base}^2) - 4 \cdot 298.15^3)

    Temperatures are in kelvin. ``share`` is the emissivity of both faces over
    the absorbed share of irradiance, about (0.88 + 0.85)/0.72. Every module has this
    loss.

    References
    ----------
    .. [1] F. P. Incropera et al., "Fundamentals of Heat and Mass Transfer",
       section 1.2: the coefficient of radiation, ε·σ·(T₁ + T₂)·(T₁² + T₂²).
    """
    air = temp_air + ZERO_CELSIUS
    module = temp_base + ZERO_CELSIUS
    exchange = (air + module) * (air**2 + module**2) - 4.0 * USUAL**3
    return Terms(loss=share * STEFAN_BOLTZMANN * exchange)


EFFECT = Effect(
    "radiative_loss",
    terms,
    {"share": Parameter(0.0, 0.0, 3.5, "-")},
    confounder=True,
    title="radiative heat loss that grows with temperature",
    decided_by="warm days in winter and cold ones in summer",
    confused_with=(
        "season",
        "temperature_gain",
        "natural_convection",
        "poa_misalignment",
        "an efficiency that falls as the module warms",
    ),
)
