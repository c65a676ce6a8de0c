"""Irradiance on modules and sensor, as shown by a plant's power."""

from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.column_names import kind_of_power, known_values
from pvlib_fem._record.inputs import Inputs
from pvlib_fem.drivers._lagged_inputs import times_on_own_clock
from pvlib_fem.drivers._water import FROST
from pvlib_fem.power import PowerRelation, days_of, fit_power_arrays

LEAST = 50.0  # W/m², least irradiance for a comparison with power
NONE = 0.02  # of the usual power per irradiance; less counts as no power
MISSING = 0.15  # of irradiance; a larger difference from power is significant
SPREADS = 4.0  # of the relation; a larger difference is as rare as 6 in 100,000
THAW = 10.0  # °C, air temperature at which no snow stays on a module in daytime
BEFORE = "24h"  # time before an hour in which frost counts
PAUSE = 3.0 * 86400.0  # s without light or values that end a stretch


def frost_past_day(temp_air: np.ndarray, inputs: Inputs) -> np.ndarray:
    """
    Whether snow may lie on the module: air below 2.4 °C within the past day. [-]

    Parameters
    ----------
    temp_air : array, shape (rows,)
        [°C]
    inputs : Inputs
        For the times.

    Returns
    -------
    array of float, shape (rows,)
        1 or 0; NaN where ``temp_air`` is.
    """
    times = pd.to_timedelta(inputs.seconds, unit="s")
    coldest = pd.Series(temp_air, times).rolling(BEFORE).min().to_numpy()
    return np.where(np.isnan(temp_air), np.nan, coldest < FROST)


def power_off(
    poa_global: np.ndarray,
    temp_air: np.ndarray,
    frost_past_day: np.ndarray,
    power: np.ndarray,
    inputs: Inputs,
    *,
    scale: float = np.nan,
) -> np.ndarray:
    """
    Whether a plant gives no power, for another reason than snow. [-]

    Such rows have more than 50 W/m² and less than 2 % of the usual power, by ``scale``
    [W per W/m²]. A stretch of these rows, over nights, is not snow if the air reaches
    10 °C in it, or without frost before and during it.
    """
    if np.isnan(scale):
        scale = usual_scale(poa_global, power)
    known = known_values("power_dc", power, poa_global) & np.isfinite(poa_global)
    light = np.flatnonzero(known & (poa_global > LEAST) & np.isfinite(temp_air))
    none = power[light] < NONE * scale * poa_global[light]
    seconds = inputs.seconds[light]
    breaks = np.diff(none, prepend=True) | (np.diff(seconds, prepend=0.0) > PAUSE)
    stretch = np.cumsum(breaks)
    off = np.zeros(len(poa_global))
    if len(light):
        size = stretch[-1] + 1
        warm, icy = np.full(size, -np.inf), np.zeros(size)
        np.maximum.at(warm, stretch, temp_air[light])
        np.maximum.at(icy, stretch, frost_past_day[light])
        snow = (warm < THAW) & (icy > 0.0)
        off[light] = none & ~snow[stretch]
    return np.where(known & np.isfinite(temp_air), off, np.nan)


def usual_scale(poa_global: np.ndarray, power: np.ndarray) -> float:
    """Upper quartile of power per irradiance of bright rows."""
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = (power / poa_global)[poa_global > 2.0 * LEAST]
    ratio = ratio[np.isfinite(ratio)]
    return float(np.quantile(ratio, 0.75)) if len(ratio) else np.inf


def light_shown(
    relation: PowerRelation,
    poa_global: np.ndarray,
    temp_module: np.ndarray,
    power: np.ndarray,
    day: np.ndarray | pd.Index,
) -> np.ndarray:
    """
    Irradiance by power; at the power limit at least that of the sensor. [W/m²]

    Parameters
    ----------
    relation : PowerRelation
    poa_global : array, shape (rows,)
        [W/m²]
    temp_module : array, shape (rows,)
        [°C]
    power : array, shape (rows,)
        In the unit of the relation.
    day : array or Index, shape (rows,)
        Time since 1970-01-01. [days]

    Returns
    -------
    array, shape (rows,)
    """
    shown = relation.light(power, temp_module, day)
    at_limit = power >= (1.0 - NONE) * relation.limit
    return np.where(at_limit, np.fmax(shown, poa_global), shown)


def irradiance_by_both(
    poa_global: np.ndarray,
    temp_base: np.ndarray,
    power: np.ndarray,
    inputs: Inputs,
    relation: PowerRelation | None,
) -> tuple[np.ndarray, np.ndarray]:
    """
    Irradiance by the sensor and by power; equal where they agree. [W/m²]

    They agree if they differ by less than 50 W/m², 15 % or four spreads of the
    relation, at the limit of the plant, and in the dark.
    """
    index = times_on_own_clock(inputs, "what a plant should give")
    day = days_of(index)
    if relation is None:
        relation = fit_power_arrays(poa_global, temp_base, power, day)
    shown = light_shown(relation, poa_global, temp_base, power, day)
    dark = known_values("power_dc", power, poa_global) & np.isnan(power)
    shown = np.where(dark, poa_global, shown)
    return poa_global, np.where(
        irradiances_agree(poa_global, shown, relation.spread), poa_global, shown
    )


def irradiances_agree(seen: np.ndarray, shown: np.ndarray, spread: float) -> np.ndarray:
    """
    Whether irradiances by the sensor and by power agree.

    Parameters
    ----------
    seen, shown : array, shape (rows,)
        Irradiance by the sensor and by power. [W/m²]
    spread : float
        Relative spread of :class:`~pvlib_fem.power.PowerRelation`. [-]

    Returns
    -------
    array of bool, shape (rows,)
        True up to a difference of 50 W/m², of 15 % or of four spreads; False where one
        is NaN.
    """
    most = max(MISSING, SPREADS * spread) * np.fmax(seen, shown)
    return np.abs(shown - seen) <= np.maximum(most, LEAST)


def lost_irradiance(seen: np.ndarray, shown: np.ndarray) -> np.ndarray:
    r"""
    Irradiance that modules lose, if power shows less than the sensor. [W/m²]

    With a share :math:`p` of the power, the share of irradiance is :math:`\sqrt p`.

    Parameters
    ----------
    seen, shown : array, shape (rows,)
        Irradiance by the sensor and by power. [W/m²]

    Returns
    -------
    array, shape (rows,)
        At least 0.
    """
    remaining = np.sqrt(np.clip(shown / np.maximum(seen, LEAST), 0.0, 1.0))
    return np.where(shown >= seen, 0.0, seen * (1.0 - remaining))


def light_lost(
    poa_global: np.ndarray,
    temp_base: np.ndarray,
    power: np.ndarray,
    power_off: np.ndarray,
    inputs: Inputs,
    *,
    relation: PowerRelation | None = None,
) -> np.ndarray:
    r"""
    Irradiance that covered modules lose, by their power. [W/m²]

    Power falls faster than irradiance if a part of a string is covered: with a share
    :math:`p` of the power, the share of irradiance is :math:`\sqrt p`. If all modules
    are covered evenly, the loss is up to twice as much.
    """
    seen, shown = irradiance_by_both(poa_global, temp_base, power, inputs, relation)
    return lost_irradiance(seen, shown) * (1.0 - power_off)


def light_unseen(
    poa_global: np.ndarray,
    temp_base: np.ndarray,
    power: np.ndarray,
    inputs: Inputs,
    *,
    relation: PowerRelation | None = None,
) -> np.ndarray:
    """Irradiance by power minus that of the sensor, if positive. [W/m²]"""
    seen, shown = irradiance_by_both(poa_global, temp_base, power, inputs, relation)
    return np.maximum(shown - seen, 0.0)


def light_unused(
    poa_global: np.ndarray,
    temp_base: np.ndarray,
    frost_past_day: np.ndarray,
    power: np.ndarray,
    power_off: np.ndarray,
    inputs: Inputs,
    *,
    relation: PowerRelation | None = None,
) -> np.ndarray:
    """
    Irradiance that is not converted to power, for example by curtailment. [W/m²]

    It is 0 without any power, and where snow may lie.
    """
    seen, shown = irradiance_by_both(poa_global, temp_base, power, inputs, relation)
    return np.maximum(seen - shown, 0.0) * (1.0 - power_off) * (1.0 - frost_past_day)


def of_column(power: Any) -> Any:
    """
    The drivers that are computed from a column of power, by name.

    Parameters
    ----------
    power : str
        ``power_dc``, ``p_dc_per_area`` or ``power_ac``.

    Returns
    -------
    dict
        Columns and function of each driver, as in :data:`~pvlib_fem.drivers.DERIVED`.
    """
    kind = kind_of_power(power)
    usual = ("poa_global", "temp_base")
    off = f"power_off{kind}"
    return {
        off: (("poa_global", "temp_air", "frost_past_day", power), power_off),
        f"light_lost{kind}": ((*usual, power, off), light_lost),
        f"light_unseen{kind}": ((*usual, power), light_unseen),
        f"light_unused{kind}": ((*usual, "frost_past_day", power, off), light_unused),
    }
