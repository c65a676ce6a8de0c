"""Electrical power that leaves the module and does not heat it."""

from dataclasses import replace
from functools import partial

import numpy as np

from pvlib_fem.effects.effect import Effect, Parameter, Terms

GAMMA = -0.0035  # 1/K, of crystalline silicon's power
MISSING = 0.15  # of the expected power, from which it is curtailed
BRIGHT = 300.0  # W/m², where power tells of efficiency
RESISTANCE = 0.03  # K m²/W, of a module whose temperature is not asked


def terms(p_dc, *, share):
    r"""
    Heat that leaves as electricity, and stays when it is curtailed [1]_.

    .. math:: \mathrm{heat} = -\mathrm{share} \cdot \mathrm{p\_dc}

    ``share`` is 1 over the absorbed share of irradiance, 1.2 to 1.5. The mean
    efficiency is in the coefficients of the steady model; what is seen is its
    change, by curtailment, clipping or outage.

    References
    ----------
    .. [1] The balance of :func:`pvlib.temperature.pvsyst_cell`, where irradiance
       heats by absorption · (1 - efficiency).
    """
    return Terms(heat=-share * p_dc)


def curtailed(poa_global, temp_air, p_dc, snow_cover=0.0, *, share, efficiency):
    r"""
    The same of the power that is missing only.

    .. math:: \mathrm{heat} = \mathrm{share} \cdot (\mathrm{expected} - \mathrm{p\_dc})

    where ``p_dc`` is more than 15 % below ``expected``, that of ``efficiency`` at
    ``temp_air`` + 0.03 K m²/W · ``poa_global`` with -0.35 %/K, and no snow lies;
    elsewhere 0. Power is an irradiance sensor, too: what it knows of the other
    sensor's errors would be taken for heat. Under snow it is the light that is
    missing. Where the loss grows with over-temperature, which the equation does not
    know, ``share`` comes out low: by 10 to 20 % in simulated physics, most on roofs.
    """
    cell = temp_air + RESISTANCE * poa_global
    expected = efficiency * poa_global * (1.0 + GAMMA * (cell - 25.0))
    missing = np.where(snow_cover > 0.0, 0.0, expected - p_dc)
    return Terms(heat=share * np.where(missing > MISSING * expected, missing, 0.0))


def below(efficiency, snow=False):
    """
    The effect of power below that of a module of this efficiency. [-]

    With ``snow`` it needs the depth of snow, too, and leaves covered rows out.
    """
    columns = ("poa_global", "temp_air", "p_dc", *(["snow_cover"] if snow else []))
    return replace(
        EFFECT,
        terms=partial(curtailed, efficiency=efficiency),
        columns=columns,
        settings={"efficiency": efficiency, "snow": snow},
        prepare=None,
    )


def of_record(columns, rows):
    """The effect with the efficiency of a record's uncurtailed rows."""
    bright = rows & (columns["poa_global"] > BRIGHT)
    poa, air, power = (columns[n][bright] for n in ("poa_global", "temp_air", "p_dc"))
    usual = poa * (1.0 + GAMMA * (air + RESISTANCE * poa - 25.0))
    snow = "snow_depth" in columns
    if not bright.any():
        return below(0.0, snow)
    share = power / usual
    # curtailment is rarer than three hours in four, and only ever downwards
    full = share > (1.0 - MISSING) * np.quantile(share, 0.75)
    return below(float(np.median(share[full])), snow)


EFFECT = Effect(
    "electrical_output",
    terms,
    {"share": Parameter(0.0, 0.0, 4.0, "-")},
    decided_by="the inverter's log of limits and outages",
    confused_with=(
        "snow",
        "natural_convection",
        "an error of the irradiance sensor, which power measures, too",
    ),
    make=below,
    prepare=of_record,
)
