"""Electrical power that leaves the module and does not heat it."""

from functools import partial

import numpy as np

from pvlib_fem.effect import Effect, Parameter, Terms

GAMMA = -0.0035  # 1/K, of crystalline silicon's power
MISSING = 0.15  # of the expected power, from which it is curtailed
BRIGHT = 300.0  # W/m², where power tells of efficiency
RESISTANCE = 0.03  # K m²/W, of a module whose temperature is not asked


def terms(p_dc, *, share):
    """
    Heat that leaves as electricity, and stays when it is curtailed [1]_.

    ``share`` is 1 over the absorbed share of irradiance, 1.2 to 1.5. The mean
    efficiency is in the coefficients of the law; what is seen is its change, by
    curtailment, clipping or outage.

    References
    ----------
    .. [1] The balance of :func:`pvlib.temperature.pvsyst_cell`, where irradiance
       heats by absorption · (1 - efficiency).
    """
    return Terms(heat=-share * p_dc)


def curtailed(poa_global, temp_air, p_dc, *, share, efficiency):
    """
    The same of the power that is missing only.

    Power is an irradiance sensor, too: what it knows of the other sensor's errors
    would be taken for heat. Beyond 15 % less than expected it is curtailed.
    """
    cell = temp_air + RESISTANCE * poa_global
    expected = efficiency * poa_global * (1.0 + GAMMA * (cell - 25.0))
    missing = expected - p_dc
    return Terms(heat=share * np.where(missing > MISSING * expected, missing, 0.0))


def below(efficiency):
    """The effect of power below that of a module of this efficiency. [-]"""
    return Effect(
        "electrical_output",
        partial(curtailed, efficiency=efficiency),
        EFFECT.parameters,
        columns=("poa_global", "temp_air", "p_dc"),
        settings={"efficiency": efficiency},
    )


def of_record(record, rows):
    """The effect with the efficiency of a record's uncurtailed rows."""
    bright = rows & (record["poa_global"] > BRIGHT)
    poa, air, power = (record[n][bright] for n in ("poa_global", "temp_air", "p_dc"))
    usual = poa * (1.0 + GAMMA * (air + RESISTANCE * poa - 25.0))
    # curtailment is rarer than three hours in four, and only ever downwards
    return below(float(np.quantile(power / usual, 0.75)) if bright.any() else 0.0)


EFFECT = Effect("electrical_output", terms, {"share": Parameter(0.0, 0.0, 4.0, "-")})
