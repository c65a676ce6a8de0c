"""
How the fault of an instrument is taken out of the column that it is in.

In the equation of the model a fault is a sum of further terms. Solved for the reading
of a sound instrument, the equation gives the corrected column.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from pvlib_fem._report.formatting import with_error
from pvlib_fem.effects._effect import Effect, Terms
from pvlib_fem.effects._time_profiles import (
    date_text,
    dates_in_words,
    day_number,
    is_dated,
    is_drift,
    time_profile_of,
    years_to_end,
)

RANGE = "90 % range"
SHARE = 100.0  # %


def sound_irradiance(columns: dict, terms: Terms, coefficients: dict) -> np.ndarray:
    """Irradiance with which the model needs no further heat. [W/m²]"""
    return columns["poa_global"] + terms.heat


def sound_wind(columns: dict, terms: Terms, coefficients: dict) -> np.ndarray:
    """Wind with which a loss of ``u0 + u1 · wind_speed`` needs no more. [m/s]"""
    return columns["wind_speed"] + terms.loss / coefficients["u1"]


def sound_air(columns: dict, terms: Terms, coefficients: dict) -> np.ndarray:
    """Air temperature, of terms whose ``air_base`` is 1. [°C]"""
    return columns["temp_air"] + terms.heat + terms.offset


def sound_module(columns: dict, terms: Terms, coefficients: dict) -> np.ndarray:
    """Reading of a module's sensor that is attached and calibrated as before. [°C]"""
    zero = columns["temp_air"] + coefficients["bias"]
    over = columns["temp_module"] - terms.offset - zero
    return zero + over / (1.0 + terms.gain)


#: column: what a sound instrument would have read
SOUND = {
    "poa_global": sound_irradiance,
    "wind_speed": sound_wind,
    "temp_air": sound_air,
    "temp_module": sound_module,
}


def unchanged(size: float, coefficients: dict) -> float:
    return size


def opposite(size: float, coefficients: dict) -> float:
    return -size


def over_wind(size: float, coefficients: dict) -> float:
    return size / coefficients["u1"]


def inverse(size: float, coefficients: dict) -> float:
    return 1.0 / (1.0 + size) - 1.0


@dataclass(frozen=True)
class Repair:
    """What the correction of one kind of fault does, and how it is put."""

    column: str
    device: str
    low: str  # what is wrong where the correction adds
    high: str  # what is wrong where it takes off
    size: Callable  # coefficient and those of the fit to what is added
    of: str  # what that is a share of, or where it holds
    unit: str = "-"

    def added(
        self, fault: Any, coefficients: dict
    ) -> tuple[float, float, float, float]:
        """What is added, its standard error and its range."""
        (key,) = fault.effect.rows()
        size, error = fault.coefficients[key], fault.stderr.get(key, np.nan)
        ends = fault.ranges.get(key, (np.nan, np.nan))
        value, up, down, *ends = (
            self.size(one, coefficients)
            for one in (size, size + error, size - error, *ends)
        )
        return value, 0.5 * abs(up - down), *sorted(ends)


SENSOR, READING = "the irradiance sensor", "of the reading"
ANEMOMETER, SHIELD = "the anemometer", "the air temperature sensor"
CONTACT = "the module temperature sensor"
LESS, MORE = "reads less", "reads more"
COLD, WARM = "reads too cold", "reads too warm"
#: what the faults of instruments are, by sensor fault or by the name of the effect
REPAIRS = {
    "irradiance_sensor": Repair("poa_global", SENSOR, LESS, MORE, unchanged, READING),
    "soiling": Repair(
        "poa_global",
        SENSOR,
        "soils between rains",
        "",
        unchanged,
        "of the reading for each day since rain",
    ),
    "anemometer": Repair("wind_speed", ANEMOMETER, LESS, MORE, over_wind, READING),
    "anemometer_stall": Repair(
        "wind_speed",
        ANEMOMETER,
        "turns too little in light wind",
        "",
        over_wind,
        "of the difference between 1.5 m/s and the reading",
    ),
    "air_offset": Repair("temp_air", SHIELD, COLD, WARM, unchanged, "", "K"),
    "air_sensor_shield": Repair(
        "temp_air",
        SHIELD,
        f"{COLD} in sun",
        f"{WARM} in sun",
        opposite,
        "at 1000 W/m²",
        "K",
    ),
    "air_shield": Repair(
        "temp_air",
        SHIELD,
        "",
        f"{WARM} in sun and calm",
        opposite,
        "at 1000 W/m² without wind",
        "K",
    ),
    "module_sensor_contact": Repair(
        "temp_module",
        CONTACT,
        "reads less of the over-temperature",
        "reads more of the over-temperature",
        inverse,
        "of the over-temperature that it reads",
    ),
    "module_offset": Repair("temp_module", CONTACT, COLD, WARM, opposite, "", "K"),
}


def repair_of(effect: Effect) -> Any:
    """
    The correction of the fault that an effect is.

    Parameters
    ----------
    effect : Effect

    Returns
    -------
    Repair or None
        None for an effect that is no fault of an instrument.
    """
    return REPAIRS.get(effect.sensor_fault or effect.name)


def obstacle(fault: Any, repair: Repair, coefficients: dict) -> str:
    """
    Why a fault cannot be taken out; "" if it can.

    Parameters
    ----------
    fault : Fault
    repair : Repair or None
    coefficients : dict
        Of the loop's fit.

    Returns
    -------
    str
    """
    if repair is None:
        return "it is no wrong reading of an instrument, so that no column is changed"
    if repair.column == "wind_speed" and not coefficients.get("u1", 0.0) > 0.0:
        return (
            "the loss of this steady model is not proportional to wind; close the loop "
            "with model='faiman'"
        )
    if fault.name == "soiling" and not fault.coefficients["soiling.per_day"] > 0.0:
        return "the module soils and not the sensor, so that no column is changed"
    return ""


def unit_added(effect: Effect, repair: Repair) -> str:
    """
    Unit of what is added.

    Parameters
    ----------
    effect : Effect
    repair : Repair
        From :func:`repair_of`.

    Returns
    -------
    str
        ``"K"`` or ``"-"``; of a trend ``"K/year"`` or ``"1/year"``; of soiling
        ``"1/day"``.
    """
    if effect.name == "soiling":
        return "1/day"
    drifts = is_drift(effect)
    if repair.unit == "K":
        return "K/year" if drifts else "K"
    return "1/year" if drifts else "-"


def ends_within(effect: Effect, first: str, last: str) -> tuple[str, str]:
    """
    First and last day of a correction within a record.

    Parameters
    ----------
    effect : Effect
    first, last : str
        First and last day of the record, ``YYYY-MM-DD``.

    Returns
    -------
    tuple of str
        Without dates of its own, those of the record.
    """
    dates = effect.settings if is_dated(effect) else {}
    start = dates.get("at") or dates.get("start") or dates.get("since") or first
    end = dates.get("end")
    return start, date_text(day_number(end) - 1) if end else last


def time_in_words(effect: Effect) -> str:
    """The dates of a fault in words."""
    words = dates_in_words(effect.settings) if is_dated(effect) else ""
    return {
        "step": f"from {words} on",
        "drift": f"increasingly from {words}"
        if years_to_end(effect)
        else f"from year to year since {words}",
        "episode": f"from {words}",
        "": "in the whole record",
    }[time_profile_of(effect)]


def sentence(effect: Effect, repair: Repair, added: tuple) -> str:
    """
    What was wrong, and what is added, in words.

    Parameters
    ----------
    effect : Effect
    repair : Repair
        From :func:`repair_of`.
    added : tuple of float
        From :meth:`Repair.added`: value, standard error, and low and high end of the
        range, in K or as a share of the reading, of a trend per year.

    Returns
    -------
    str
    """
    what = repair.low if added[0] > 0 else repair.high
    times, unit = (1.0, "K") if repair.unit == "K" else (SHARE, "%")
    years = years_to_end(effect)  # of a trend that ends, what it reaches
    value, error, low, high = (times * (years or 1.0) * n for n in added)
    each = " for each year" if is_drift(effect) and not years else ""
    size = f"{'up to ' if years else ''}{with_error(value, error)} {unit}"
    quantity = f" {repair.of}" if repair.of else ""
    ends = f" ({RANGE} {low:.3g} to {high:.3g} {unit})" if np.isfinite(low) else ""
    return (
        f"{repair.column}: {repair.device} {what} {time_in_words(effect)}. "
        f"Added: {size}{quantity}{each}{ends}."
    )
