"""
Each cause as a clause: which device does what, in which direction and by how much.

A correction adds to a reading what its instrument reads too little. A statement is of
the reading: it has the other sign, and as a share it is the inverse.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TypedDict

import numpy as np

from pvlib_fem._correction.faults import Fault
from pvlib_fem._correction.repairs import (
    SHARE,
    ends_within,
    repair_of,
    unit_added,
)
from pvlib_fem._findings import Finding, Member
from pvlib_fem._report.formatting import with_error
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._standstill import in_words
from pvlib_fem.effects._time_profiles import (
    YEAR,
    day_number,
    is_dated,
    is_drift,
    time_profile_of,
    years_to_end,
)

MODEL, MODULES = "model", "modules"
PER_YEAR = " each year"
#: what has coefficients, standard errors and ranges
Numbers = Finding | Member


@dataclass(frozen=True)
class Clause:
    """A cause in words, without its dates, and its numbers."""

    device: str
    words: str
    action: str = ""
    value: float = np.nan
    error: float = np.nan
    low: float = np.nan
    high: float = np.nan
    unit: str = ""
    since: str = ""
    until: str = ""
    time_profile: str = ""


class Estimate(TypedDict, total=False):
    """The numbers of a clause; empty where an effect has no or several coefficients."""

    value: float
    error: float
    low: float
    high: float
    unit: str


@dataclass(frozen=True)
class ReadingWords:
    """What an instrument does where it reads less or more; ``{}`` is the size."""

    less: str
    more: str
    action: str
    unsized: str = ""  # where the size is in no unit of the reading


IRRADIANCE = "Clean and recalibrate the irradiance sensor"
ANEMOMETER = "Check the anemometer's bearing and surroundings, or recalibrate it"
SHIELD = "Check the radiation shield of the air temperature sensor"
#: by sensor fault, or by the name of the effect
READS = {
    "irradiance_sensor": ReadingWords(
        "reads {} less", "reads {} more", IRRADIANCE, "has changed"
    ),
    "anemometer": ReadingWords(
        "reads {} less", "reads {} more", ANEMOMETER, "has changed"
    ),
    "anemometer_stall": ReadingWords(
        "reads too little in light wind",
        "reads too much in light wind",
        ANEMOMETER,
        "reads too little in light wind",
    ),
    "air_offset": ReadingWords(
        "reads {} too low",
        "reads {} too high",
        "Recalibrate the air temperature sensor",
    ),
    "air_sensor_shield": ReadingWords(
        "reads {} too low in full sun (at 1000 W/m²)",
        "reads {} too high in full sun (at 1000 W/m²)",
        SHIELD,
    ),
    "air_shield": ReadingWords(
        "reads {} too low in sun and calm air",
        "reads {} too high in sun and calm air (at 1000 W/m², without wind)",
        SHIELD,
    ),
    "module_sensor_contact": ReadingWords(
        "shows {} less of the temperature rise of the module over air",
        "shows {} more of the temperature rise of the module over air",
        "Check how the module temperature sensor is attached",
    ),
    "module_offset": ReadingWords(
        "reads {} too low",
        "reads {} too high",
        "Recalibrate the module temperature sensor",
    ),
}
SIDES = (
    *("north", "north-east", "east", "south-east"),
    *("south", "south-west", "west", "north-west"),
)


def clause_of(
    effect: Effect,
    numbers: Numbers,
    coefficients: Mapping[str, float],
    first: str,
    last: str,
) -> Clause:
    """
    A cause as a clause.

    Parameters
    ----------
    effect : Effect
    numbers : Finding or Member
        Coefficients, standard errors and ranges.
    coefficients : dict
        Coefficients of the fit, by which a loss becomes a wind speed.
    first, last : str
        Days of the record.

    Returns
    -------
    Clause
    """
    kind = effect.sensor_fault or effect.name
    if effect.column:
        clause = of_column(effect, numbers)
    elif kind in READS:
        clause = of_instrument(effect, numbers, coefficients, first, last)
    elif kind in SPECIAL:
        clause = SPECIAL[kind](effect, numbers)
    else:
        clause = of_model(effect, numbers)
    return dated_clause(clause, effect, first, last)


def dated_clause(clause: Clause, effect: Effect, first: str, last: str) -> Clause:
    """The clause with the dates of its effect."""
    if not is_dated(effect):
        return clause
    since, until = ends_within(effect, first, last)
    profile = time_profile_of(effect)
    if not is_drift(effect) and not effect.settings:  # a hint has no dates
        since, until = "", last
    until = "" if until == last else until
    return replace(clause, since=since, until=until, time_profile=profile)


def of_instrument(
    effect: Effect,
    numbers: Numbers,
    coefficients: Mapping[str, float],
    first: str,
    last: str,
) -> Clause:
    """What an instrument reads beyond the truth."""
    kind, repair = effect.sensor_fault or effect.name, repair_of(effect)
    reads = READS[kind]
    (key,) = effect.rows()
    if key not in numbers.coefficients or (
        repair.column == "wind_speed" and not coefficients.get("u1", 0.0) > 0.0
    ):
        words = f"{repair.device} {reads.unsized or 'has changed'}"
        return Clause(without_article(repair.device), words, reads.action)
    added = repair.added(Fault.from_finding(effect, numbers), coefficients)
    since, until = ends_within(effect, first, last)
    years = (day_number(until) - day_number(since)) / YEAR if is_drift(effect) else 1.0
    years = years_to_end(effect) or max(years, 1e-9)
    value, error, low, high = reading_of(added, repair.unit, years)
    unit = unit_added(effect, repair).replace("1/", "%/").replace("-", "%")
    if years_to_end(effect):  # its size is what it reaches
        value, error, low, high = (years * n for n in (value, error, low, high))
        unit = unit.removesuffix("/year")
    size = f"{with_error(abs(value), error)} {'K' if repair.unit == 'K' else '%'}"
    size, each = size_in_time(effect, size)
    words = f"{repair.device} {reads.less if value < 0 else reads.more}".format(size)
    words += each
    device = without_article(repair.device)
    return Clause(device, words, reads.action, value, error, low, high, unit)


def size_in_time(effect: Effect, size: str) -> tuple[str, str]:
    """A size in words, and what follows the clause that has it."""
    if years_to_end(effect):
        return f"up to {size}", ", increasing day by day"
    return size, PER_YEAR if is_drift(effect) else ""


def without_article(device: str) -> str:
    """A device without its article."""
    return device.removeprefix("the ")


def reading_of(
    added: tuple[float, float, float, float], unit: str, years: float
) -> tuple[float, float, float, float]:
    """
    What is read beyond the truth, of what is to be added to the reading.

    Of a trend it is the mean slope of the reading over the record; of one by which
    nothing would be left to read, the slope at its start.
    """
    value, error, low, high = added
    if unit == "K":
        return -value, error, -high, -low

    def read(share: float) -> float:
        remaining = 1.0 + share * years
        return SHARE * (-share if remaining <= 0.0 else (1.0 / remaining - 1.0) / years)

    half = 0.5 * abs(read(value + error) - read(value - error))
    return read(value), half, read(high), read(low)


def only_size(effect: Effect, numbers: Numbers, times: float = 1.0) -> Estimate:
    """The only coefficient of an effect with its error and range."""
    keys = [key for key in effect.rows() if key in numbers.coefficients]
    if len(keys) != 1:
        return {}
    (key,) = keys
    low, high = numbers.ranges.get(key, (np.nan, np.nan))
    error = numbers.stderr.get(key, np.nan)
    return Estimate(
        value=times * numbers.coefficients[key],
        error=times * error,
        low=times * low,
        high=times * high,
        unit=effect.rows()[key].unit if times == 1.0 else "%",
    )


def absolute_size(estimate: Estimate) -> str:
    """The absolute size with its error."""
    unit = "" if estimate["unit"] == "-" else f" {estimate['unit']}"
    return f"{with_error(abs(estimate['value']), estimate['error'])}{unit}"


def of_model(effect: Effect, numbers: Numbers) -> Clause:
    """An effect that is missing from the model."""
    words = f"{effect.title or effect.name} is missing from the model"
    return Clause(MODEL, words, **only_size(effect, numbers))


def of_column(effect: Effect, numbers: Numbers) -> Clause:
    """A column of the user's own that the error follows."""
    estimate = only_size(effect, numbers)
    words = f"the error follows the column {effect.column}"
    if estimate:
        size = with_error(estimate["value"], estimate["error"])
        words += f", by {size} {estimate['unit']}"
    action = f"Find out how {effect.column} heats or cools the modules"
    return Clause(effect.column, words, action, **estimate)


def share_clause(effect: Effect, numbers: Numbers) -> Clause:
    """A cause whose only coefficient is a share of what its words name."""
    device, words, ways, action = OF_SHARE[effect.sensor_fault or effect.name]
    years = years_to_end(effect)
    estimate = only_size(effect, numbers, SHARE * (years or 1.0))
    way = ways[not estimate or estimate["value"] > 0]
    size, each = size_in_time(effect, absolute_size(estimate)) if estimate else ("", "")
    if is_drift(effect) and not years:
        estimate["unit"] = "%/year"
    words = words.format(f"{size} {way}".strip(), each)
    return Clause(device, words, action, **estimate)


def hours_clause(effect: Effect, numbers: Numbers) -> Clause:
    """A cause that acts for hours, whose words have no size."""
    return Clause(*FOR_HOURS[effect.name], **only_size(effect, numbers))


def soiling(effect: Effect, numbers: Numbers) -> Clause:
    if not (estimate := only_size(effect, numbers, SHARE)):
        words = "dirt gathers between rains on the irradiance sensor or the modules"
        return Clause("irradiance sensor or modules", words)
    estimate["unit"] = "%/day"
    sensor = estimate["value"] > 0
    size = f"{with_error(abs(estimate['value']), estimate['error'])} %"
    known = effect.constants
    rain = f"a rain of {known['cleaning']:g} mm in {known['within']:g} h"
    each = f"with each day since {rain}"
    if known["grace"]:
        each = f"each day, from {known['grace']:g} days after {rain} on"
    rest = f"another {size} by soiling {each}"
    if sensor:
        device, words = "irradiance sensor", f"the irradiance sensor loses {rest}"
    else:
        device, words = MODULES, f"the modules lose {rest}"
    estimate["value"] = -abs(estimate["value"])
    estimate["low"], estimate["high"] = sorted(
        -abs(end) if np.isfinite(end) else np.nan
        for end in (estimate["low"], estimate["high"])
    )
    return Clause(device, words, f"Clean the {device}", **estimate)


def shading(effect: Effect, numbers: Numbers) -> Clause:
    windows = effect.settings.get("windows", ())
    where = " and ".join(
        f"azimuth {a:.0f}° to {b:.0f}°, elevation {c:.0f}° to {d:.0f}°"
        for a, b, c, d in windows
    )
    estimate = only_size(effect, numbers)
    if effect.settings.get("sensor"):
        device, words = "irradiance sensor", "the irradiance sensor is shaded"
    elif estimate and estimate["value"] < 0:
        device = MODULES
        words = "the modules receive more beam irradiance than the irradiance sensor"
    else:
        device, words = MODULES, "the modules are shaded"
    action = f"Look from the {device} for an obstacle or a reflecting surface there"
    return Clause(device, f"{words} while the sun is at {where}", action, **estimate)


def poa_misalignment(effect: Effect, numbers: Numbers) -> Clause:
    if "axis_azimuth" in effect.settings:
        return on_a_tracker(effect, numbers)
    parts = []
    for key, more, less in (
        ("tilt", "steeper", "flatter"),
        ("azimuth", "west", "east"),
    ):
        if (angle := angle_of(f"{effect.name}.{key}", numbers)) is None:
            continue
        way = more if angle[0] > 0 else less
        way = way if key == "tilt" else f"further {way}"
        parts.append(f"{angle[1]} {way}")
    way = " and ".join(parts) or "in another plane"
    words = f"the modules stand {way} than the irradiance sensor"
    action = "Measure the tilt and azimuth of the irradiance sensor and the modules"
    return Clause("irradiance sensor", words, action)


def on_a_tracker(effect: Effect, numbers: Numbers) -> Clause:
    """What turns about an axis is off by an angle about it, or about the vertical."""
    parts = []
    if angle := angle_of(f"{effect.name}.tilt", numbers):
        side = effect.settings["axis_azimuth"] + (90.0 if angle[0] > 0 else -90.0)
        side = SIDES[round(side / 45.0) % 8]
        parts.append(f"by {angle[1]} to the {side} about the axis of the tracker")
    if angle := angle_of(f"{effect.name}.azimuth", numbers):
        way = "clockwise" if angle[0] > 0 else "anticlockwise"
        parts.append(f"by {angle[1]} {way} about the vertical")
    way = " and ".join(parts)
    words = f"the modules are turned {way}, relative to the irradiance sensor"
    action = "Measure the angles of the irradiance sensor and the modules at one time"
    return Clause("irradiance sensor", words, action)


def angle_of(name: str, numbers: Numbers) -> tuple[float, str] | None:
    """An angle, and its size with its error in words; None if it is not known."""
    if name not in numbers.coefficients:
        return None
    value, error = numbers.coefficients[name], numbers.stderr.get(name, np.nan)
    return value, f"{with_error(abs(value), error)}°"


def temperature_gain(effect: Effect, numbers: Numbers) -> Clause:
    estimate = only_size(effect, numbers)
    words = "the module temperature sensor has another slope than the air's"
    if estimate:
        more = "more" if estimate["value"] > 0 else "less"
        words = (
            f"the module temperature sensor reads {absolute_size(estimate)} K {more} "
            "for each kelvin of air temperature"
        )
    action = "Recalibrate the module temperature sensor"
    return Clause("module temperature sensor", words, action, **estimate)


def snow(effect: Effect, numbers: Numbers) -> Clause:
    words = "snow covers the modules, and less of it the irradiance sensor"
    return Clause(MODULES, words, "Check the modules on days after snow")


def tracker_stuck(effect: Effect, numbers: Numbers) -> Clause:
    plane = (effect.settings[name] for name in ("surface_tilt", "surface_azimuth"))
    where = in_words(*plane)
    words = f"the modules were stuck {where}, while the irradiance sensor moved"
    action = "Check the drive of the tracker"
    return Clause("tracker", words, action, **only_size(effect, numbers))


#: by sensor fault: device, words with a size and what follows it, ways, and action
OF_SHARE = {
    "mounting": (
        "mounting",
        "the modules lose {} heat to the air{}",
        ("less", "more"),
        "Inspect the mounting, and what was built or grew around the modules",
    ),
    "module_irradiance": (
        MODULES,
        "the modules receive {} irradiance{}, at the same sensor reading",
        ("less", "more"),
        "Look for dirt on the modules, their cleaning, and changes of the ground or "
        "surfaces around them",
    ),
    "time_constant": (
        "module temperature sensor or loggers",
        "the measured module temperature follows irradiance with a time constant that "
        "is {}{}",
        ("shorter", "longer"),
        "Check how the module temperature sensor is attached, and the averages and "
        "clocks of the loggers",
    ),
}
#: by name of the effect: device, words and action
FOR_HOURS = {
    "modules_covered": (
        MODULES,
        "snow, leaves or shade cover the modules for hours, and power and temperature "
        "are both low",
        "Look up the hours of loop.events in the site's log",
    ),
    "sensor_covered": (
        "irradiance sensor",
        "snow, leaves or shade cover the irradiance sensor for hours, and power and "
        "temperature are both high for what it reads",
        "Look from the irradiance sensor for what covers or shades it, and from the "
        "modules for a reflecting surface",
    ),
    "outage": (
        "plant",
        "the modules are warmer for hours in which the plant gives no power",
        "Look up the hours of loop.events in the inverter's log",
    ),
}
#: causes whose words have a direction of their own
SPECIAL = {
    **dict.fromkeys(OF_SHARE, share_clause),
    **dict.fromkeys(FOR_HOURS, hours_clause),
    "soiling": soiling,
    "shading": shading,
    "poa_misalignment": poa_misalignment,
    "temperature_gain": temperature_gain,
    "snow": snow,
    "tracker_stuck": tracker_stuck,
}
