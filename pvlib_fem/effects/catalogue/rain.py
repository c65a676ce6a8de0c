"""A film of water that cools a module, in rain and while it dries."""

from dataclasses import replace

import numpy as np

from pvlib_fem.effects._effect import Effect, Parameter, Terms


def terms(wetness: np.ndarray, *, film: float) -> Terms:
    r"""
    Loss by evaporation, modelled as an additional loss to the air [1]_.

    .. math:: \mathrm{loss} = \mathrm{film} \cdot \mathrm{wetness}

    ``film`` is the latent loss of a wet face per kelvin of over-temperature: 10 to
    40 W/(m² K) at a warm module in air of 70 % relative humidity.

    References
    ----------
    .. [1] Lewis's relation, h/(rho·c_p·Le^(2/3)) for the transfer of vapour: F. P.
       Incropera et al., "Fundamentals of Heat and Mass Transfer", section 6.7.
    """
    return Terms(loss=film * wetness)


def evaporation(film_vapour: np.ndarray, *, film: float) -> Terms:
    r"""
    Loss by evaporation from vapour pressure, for records with humidity.

    .. math:: \mathrm{heat} = -\mathrm{film} \cdot \mathrm{film\_vapour}

    The vapour pressure is that at the temperature of the wet module. ``film`` is
    Lewis's 0.622·L/(c_p·p), 1.5 K/hPa, times the convection of one face, over the
    absorbed share of irradiance: 10 to 60 W/(m² hPa).
    """
    return Terms(heat=-film * film_vapour)


FROM_WETNESS = Effect(
    "rain",
    terms,
    {"film": Parameter(0.0, 0.0, 1000.0, "W/(m² K)")},
    title="cooling by evaporating rain",
    decided_by="a wetness sensor on the module",
    confused_with=(
        "sky_radiation",
        "soiling",
        "snow",
        "the time constant, where irradiance falls as the rain comes",
        "air that turns cold before the rain",
    ),
)
FROM_HUMIDITY = replace(
    FROM_WETNESS,
    terms=evaporation,
    parameters={"film": Parameter(0.0, 0.0, 200.0, "W/(m² hPa)")},
    settings={"source": "humidity"},
    source="humidity",
)
#: by the known quantities of the air, the best first
EFFECT = replace(FROM_WETNESS, variants=(FROM_HUMIDITY, FROM_WETNESS))
