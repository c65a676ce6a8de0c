"""Columns in another unit, or not what their name says."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
import pandas as pd
from scipy.stats import binom

from pvlib_fem._record.header_units import (
    AMOUNTS,
    UNITS,
    ForeignUnit,
    SwappedTemperatures,
    named_unit,
    own_unit,
    usual_name_of,
)
from pvlib_fem._record.inputs import Columns, Inputs
from pvlib_fem._record.ranges import RANGES, Range, range_of
from pvlib_fem._spelling import UNCHECKED, ShellText, refusal, spelled
from pvlib_fem.quality._hours import side_of
from pvlib_fem.quality._interpolated import interpolated_columns
from pvlib_fem.quality._lag import Lag, coarse_lag, retimed
from pvlib_fem.quality._limits import (
    EFFICIENCY,
    GAIN,
    POSSIBLE,
    Limits,
)
from pvlib_fem.quality._onset import HOUR
from pvlib_fem.quality._values import FEW

#: gain of over-temperature with irradiance [K m²/W]: of °F, and what no mounting shows
#: even in °F, so that irradiance is at fault
FAHRENHEIT, NO_MOUNTING = 0.075, 0.12
APART = 12.0  # K by night, more than any sky or sensor takes a module from the air
CONVERT = "Convert it first"
ENOUGH = 20_000  # rows that tell units
#: W/m² that a record of days reaches where its unit is right, and that few rows pass
DIM, BRIGHT = 500.0, 1500.0


def doubtful(columns: Columns, limits: Limits | None = None) -> dict[str, str]:
    """
    Drivers that look to be in another unit, or not what their name says.

    The four columns that every fit needs are checked by :func:`refuse_units`.

    Parameters
    ----------
    columns : mapping
        Name to values, as pvlib names them, among them ``poa_global`` [W/m²].
    limits : Limits, optional
        The thresholds.

    Returns
    -------
    dict
        Name to what is odd about it, with the remedy; it should not be used.

    Examples
    --------
    >>> reasons = doubtful({"relative_humidity": [0.4, 0.9]})
    >>> reasons["relative_humidity"].partition(" (")[0]
    'is 0.9 at most, a fraction; multiply it by 100 for %'
    """
    limits = limits or Limits()
    reasons = {}
    for name in columns:
        if name in POSSIBLE:
            continue
        values = np.asarray(columns[name], float)
        seen = values[np.isfinite(values)]
        if not len(seen):
            continue
        kind = "temp_" if name.startswith("temp_") else name
        known, check = range_of(name), UNIT_CHECKS.get(kind)
        reason = check(seen, known, limits) if check else ""
        if name == "p_dc_per_area" and "poa_global" in columns:
            reason = check_power(
                values, np.asarray(columns["poa_global"], float), limits
            )
        if reason:
            reasons[name] = reason
    return reasons


def refuse_doubtful(columns: Columns, limits: Limits) -> None:
    """
    Refuse drivers that look to be in another unit.

    Parameters
    ----------
    columns : Columns
        As of :func:`doubtful`.
    limits : Limits
        The thresholds.

    Raises
    ------
    ValueError
        That names each such driver, with the remedy.
    """
    if reasons := doubtful(columns, limits):
        lines = [f"{name} {reason}" for name, reason in reasons.items()]
        raise refusal("; ".join(lines), "; if the unit is right, give ", UNCHECKED)


def often(odd: np.ndarray, limits: Limits) -> bool:
    return np.mean(odd) > limits.max_accident_share


def unit_of_driver(
    name: str, values: np.ndarray | pd.Series, limits: Limits | None = None
) -> str:
    """
    The unit in which a driver looks to be, by its values.

    Parameters
    ----------
    name : str
        Driver; only ``relative_humidity`` and ``wind_direction`` show their unit.
    values : numpy.ndarray or pandas.Series, shape (rows,)
        The column.
    limits : Limits, optional
        ``min_known_values``, which a direction needs at least.

    Returns
    -------
    str
        ``"fraction"`` or ``"rad"``; ``""`` where nothing speaks against %, or °.
    """
    limits, values = limits or Limits(), np.asarray(values, float)
    seen, known = values[np.isfinite(values)], range_of(name)
    if not len(seen) or known is None:
        return ""
    if name == "relative_humidity" and 100.0 * seen.max() <= known.most:
        return "fraction"
    circle = round(np.degrees(seen.max())) <= known.most  # 2π may be rounded to 6.3
    if name == "wind_direction" and circle and len(seen) >= limits.min_known_values:
        return "rad"
    return ""


def options_of(column: Any, name: str, values: Any) -> list[str]:
    """
    Options that read a column of a file as what it looks like, in its unit.

    Parameters
    ----------
    column : str
        Label in the file, which may name the unit.
    name : str
        What the column looks like, as the package names it.
    values : pandas.Series or numpy.ndarray, shape (rows,)
        The column, which may show the unit.

    Returns
    -------
    list of str
        ``--map``, and ``--unit`` where the unit is not the package's own, each with its
        value.
    """
    known = usual_name_of(name) is not None
    named = named_unit(name, str(column)) if known else None
    unit = named or unit_of_driver(name, values)
    own = known and unit == own_unit(name)
    options = ["--map", f"{name}={column}"]
    return options + ["--unit", f"{name}={unit}"] * bool(unit and not own)


def check_humidity(seen: np.ndarray, known: Range, limits: Limits) -> str:
    if unit := unit_of_driver("relative_humidity", seen, limits):
        return (
            f"is {seen.max():.2g} at most, a fraction; multiply it by 100 for % "
            f"(--unit relative_humidity={unit})"
        )
    if often((seen < known.least) | (seen > known.most), limits):
        return f"goes from {seen.min():.3g} to {seen.max():.3g}; it should be in %"
    return ""


def check_longwave(seen: np.ndarray, known: Range, limits: Limits) -> str:
    odd = (seen < known.least) | (seen > known.most)
    if often(odd, limits):
        return (
            f"is outside the {known.least:g} to {known.most:g} W/m² that skies send in "
            f"{100 * np.mean(odd):.0f} % of its rows, from {seen.min():.0f} to "
            f"{seen.max():.0f}; a pyrgeometer's net signal needs the σT⁴ of its body "
            "added"
        )
    return ""


def check_direction(seen: np.ndarray, known: Range, limits: Limits) -> str:
    if unit := unit_of_driver("wind_direction", seen, limits):
        return (
            f"is {seen.max():.2g} at most, radians; multiply it by 57.3 for ° "
            f"(--unit wind_direction={unit})"
        )
    if often((seen < known.least) | (seen > known.most), limits):
        return f"goes from {seen.min():.0f} to {seen.max():.0f}°; use it modulo 360"
    return ""


def check_rain(seen: np.ndarray, known: Range, limits: Limits) -> str:
    if (seen < known.least).any():
        return f"is {seen.min():.3g} at least; a counter needs its resets taken out"
    change = np.diff(seen)
    rises, falls = np.count_nonzero(change > 0), np.count_nonzero(change < 0)
    # a rate rises and falls, and keeps its value at 0 alone
    chance = binom.cdf(falls, rises + falls, 0.5)
    if chance < limits.max_stuck_chance and np.median(change[seen[1:] > 0]) == 0:
        return (
            f"rises in {rises:,} rows and falls in {falls:,}, as a counter does; write "
            "what fell in each step, such as rain.diff().clip(lower=0)"
        )
    return ""


def check_snow(seen: np.ndarray, known: Range, limits: Limits) -> str:
    if often(seen < known.least, limits):
        return f"is {seen.min():.3g} at least; set the zero of the gauge"
    return ""


def check_kelvin(seen: np.ndarray, known: Range, limits: Limits) -> str:
    if np.median(seen) > known.most:
        return f"has a median of {np.median(seen):.0f}, kelvin; subtract 273.15"
    return ""


def check_power(power: np.ndarray, poa: np.ndarray, limits: Limits) -> str:
    """What is odd of power by irradiance, in the sun."""
    sunny = (poa > limits.min_sunny_irradiance) & np.isfinite(power)
    if not sunny.any():
        return ""
    least, most = EFFICIENCY
    shares = power[sunny] / poa[sunny]
    ratio, best = np.median(shares), np.quantile(shares, 0.99)
    if 0.0 < best < least:
        return (
            f"is {best:.2g} of poa_global at its best, kW; multiply it by 1000, and "
            "divide it by the area of the modules for W/m² (--unit p_dc_per_area=kW "
            "--module-area AREA), or name it power_dc"
        )
    if ratio > most:
        return (
            f"is {ratio:.2g} of poa_global, and no module gives {most:g}; divide W by "
            "the area of the modules for W/m² (--unit p_dc_per_area=W --module-area "
            "AREA), or name it power_dc"
        )
    return ""


#: checks of a driver by its name
UNIT_CHECKS = {
    "relative_humidity": check_humidity,
    "longwave_down": check_longwave,
    "wind_direction": check_direction,
    "precipitation": check_rain,
    "snow_depth": check_snow,
    "temp_": check_kelvin,
}


@dataclass(frozen=True)
class Signs:
    """What the laws of heat say of the units of the four columns, together."""

    bright: float  # irradiance, its largest but one row in a thousand
    slope: float  # of over-temperature by irradiance, in the sun
    sunny: float  # median over-temperature there
    night: float  # in the dark; NaN without nights
    cold: float  # air temperature, 1 % of the rows are below
    usual: float  # its median
    hot: float  # 99 % of the rows are below
    strong: float  # wind, 95 % of the rows are below
    wind: float  # mean wind; NaN without any
    effect: float  # fall of the over-temperature for each unit of wind [-]


#: by the inputs they are of, since a screening and its notes both ask for them
KNOWN = WeakKeyDictionary()


def record_signs(inputs: Inputs) -> Signs:
    """The signs of a record, or None where it is too short or dark for any."""
    if inputs not in KNOWN:
        KNOWN[inputs] = signs_of(inputs)
    return KNOWN[inputs]


def signs_of(inputs: Inputs) -> Signs | None:
    """The signs, from the columns; of a long record from some rows."""
    some = slice(None, None, max(1, len(inputs.index) // ENOUGH))
    few = inputs.columns.at_rows(some)
    poa, air, wind, module = (few[name] for name in POSSIBLE)
    over = module - air
    seen = np.isfinite(poa) & np.isfinite(over)
    bright = np.nanpercentile(poa, 99.9) if seen.sum() >= 100 else 0.0
    if bright <= 0:
        return None
    sunny = seen & (poa > 0.2 * bright)
    dark = seen & (poa < 0.02 * bright)
    ratio = over[sunny] / poa[sunny]
    windy = np.isfinite(wind[sunny]) & (ratio > 0)
    cold, usual, hot = np.nanpercentile(air, [1, 50, 99])
    return Signs(
        bright,
        slope_of(over[sunny], poa[sunny]),
        float(np.median(over[sunny])),
        np.median(over[dark]) if dark.sum() >= 20 else np.nan,
        cold,
        usual,
        hot,
        np.nanpercentile(wind, 95) if np.isfinite(wind).any() else 0.0,
        np.nanmean(wind) if np.isfinite(wind).any() else np.nan,
        -slope_of(np.log(ratio[windy]), wind[sunny][windy]),
    )


@dataclass(frozen=True)
class UnitDoubt:
    """What looks wrong in some columns, and what to do if it is."""

    what: str
    remedy: str
    right: str = "the unit is"
    columns: tuple = ()  # those in another unit, or swapped
    unit: str = ""  # that can be converted
    why: str = ""
    possible: bool = False  # whether the values can be in the package's unit, too

    def error(self) -> ValueError:
        """The error that refuses the record."""
        way_round = f"; if {self.right} right, give "
        words = spelled(self.what, ". ", self.remedy, way_round, UNCHECKED)
        if not self.columns:
            return ValueError(words)
        if not self.unit:
            return SwappedTemperatures(words, self.why)
        return ForeignUnit(words, self.columns, self.unit, self.why)


def foreign(unit: str, why: str, *columns: str) -> UnitDoubt:
    """The suspicion that columns are in another unit."""
    options = " ".join(f"--unit {name}={unit}" for name in columns)
    it, look = ("them", "look") if len(columns) > 1 else ("it", "looks")
    return UnitDoubt(
        f"{' and '.join(columns)} {look} to be in {unit}: {why}",
        ShellText(CONVERT, f"Give {options} to convert {it}"),
        columns=columns,
        unit=unit,
        why=why,
    )


def refuse_units(
    inputs: Inputs,
    limits: Limits,
    late: bool = False,
    stated: Collection[str] = (),
) -> None:
    """
    Refuse a column that looks to be in another unit, or not what its name says.

    The thermal laws tie the columns together: over-temperature follows
    irradiance with 10 to 60 mK/(W/m²), a module at night is within some kelvin
    of the air, and wind changes the resistance by 4 to 20 % per m/s.

    Parameters
    ----------
    inputs : Inputs
        With the four columns that every fit needs.
    limits : Limits
        The thresholds.
    late : bool, default False
        Accept a module whose clock is off by hours, where its units are right.
    stated : collection of str, default ()
        Columns whose unit a header or the user states: they are refused only if their
        values are impossible in it.

    Raises
    ------
    ForeignUnit
        If the unit of a column is another one that can be converted.
    SwappedTemperatures
        If ``temp_air`` and ``temp_module`` are exchanged.
    ValueError
        If a column is a copy, its unit is uncertain, or a clock is off by hours.
    """
    odd, off = suspected(inputs, record_signs(inputs), limits)
    if odd and odd.possible and {*odd.columns} <= {*stated}:
        odd = None
    if odd or (off and not late):
        raise (odd or of_hours(off)).error()


def suspected(inputs: Inputs, evidence: Signs | None, limits: Limits) -> tuple:
    """What looks wrong by one clock, and how far the module's is off for that."""
    if not (odd := evidence and suspicion(inputs, evidence)):
        return None, None
    if (off := module_lag(inputs, limits)) is None:
        return odd, None
    retimed_inputs = in_step(inputs, off)
    evidence = record_signs(retimed_inputs)
    return evidence and suspicion(retimed_inputs, evidence), off


def of_hours(off: Any) -> UnitDoubt:
    """The suspicion that the module's clock is off by hours."""
    hours = f"{abs(off.late) / HOUR:.3g} h"
    fix = "Subtract" if off.late > 0 else "Add"
    return UnitDoubt(
        f"timestamps of temp_module run {hours} {side_of(off.late)} those of "
        "poa_global",
        f"{fix} {hours} {'from' if off.late > 0 else 'to'} its times, or give the "
        "record to close_loop, which does",
        "that is",
    )


def module_lag(inputs: Any, limits: Any) -> Lag | None:
    """
    By how many steps the module's clock is off.

    Parameters
    ----------
    inputs : Inputs
        With ``poa_global``, ``temp_air`` and ``temp_module``.
    limits : Limits
        Thresholds of the clock.

    Returns
    -------
    Lag or None
        None where the clock is right, or cannot be checked.
    """
    columns = (inputs[name] for name in ("poa_global", "temp_air", "temp_module"))
    lateness = coarse_lag(*[inputs.seconds, *columns, limits])
    return lateness if lateness and lateness.late else None


def in_step(inputs: Inputs, off: Lag) -> Inputs:
    """
    The inputs with the module by the clock of the irradiance.

    Parameters
    ----------
    inputs : Inputs
        With ``temp_module``.
    off : Lag
        From :func:`module_lag`.

    Returns
    -------
    Inputs
        ``temp_module`` is NaN beyond the ends.
    """
    module = retimed(inputs.seconds, inputs["temp_module"], off.late)
    return inputs.having({"temp_module": module})


def is_copy(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two columns are copies of each other, as far as both are there."""
    for some in (slice(FEW), slice(None)):  # of most records a few rows tell
        both = np.isfinite(one[some]) & np.isfinite(other[some])
        if (one[some][both] != other[some][both]).any():
            return False
    return bool(both.any())


def suspicion(inputs: Inputs, evidence: Signs) -> UnitDoubt | None:
    """What the signs of a record say of a copy, swapped columns or another unit."""
    bright, slope, night, hot = (
        evidence.bright,
        evidence.slope,
        evidence.night,
        evidence.hot,
    )
    air, module = inputs["temp_air"], inputs["temp_module"]
    if is_copy(air, module):
        return UnitDoubt(
            "temp_module is a copy of temp_air, row by row",
            "Name the column of the module's own sensor",
            "that is",
        )
    if slope < -GAIN[0] and evidence.sunny < 0:
        why = (
            f"in the sun temp_module is {-evidence.sunny:.0f} K below temp_air, and "
            "falls as irradiance grows"
        )
        return UnitDoubt(
            f"temp_air and temp_module look swapped: {why}",
            "Exchange the columns",
            "they are",
            ("temp_air", "temp_module"),
            why=why,
        )
    if bright < 3.0 and slope > 1.0:
        why = f"its largest values are {bright:.2f}"
        return foreign("kW/m²", why, "poa_global")
    if slope > NO_MOUNTING and bright < DIM:
        return of_light(inputs, bright, slope)
    if abs(night) > APART:
        return of_difference(inputs, night)
    if hot > 57.0 or slope > FAHRENHEIT:
        unit = "K" if evidence.usual > 200.0 else "°F"
        why = (
            f"the air reaches {hot:.0f} and the module gains {1000 * slope:.0f} per "
            "1000 W/m²"
        )
        if bright < DIM:
            return UnitDoubt(
                f"temp_air and temp_module look to be in {unit} (or poa_global in "
                f"another unit than W/m²): {why}",
                CONVERT,
            )
        return foreign(unit, why, "temp_air", "temp_module")
    # in m/s, a site that windy has an effect of 5 % per m/s and more
    weak = 0.004 < evidence.effect < 0.005 * (evidence.strong - 6.0)
    if evidence.strong > 18.0 or (evidence.strong > 12.0 and weak):
        why = (
            f"5 % of it is above {evidence.strong:.0f}, and one unit of it changes the "
            f"over-temperature by {100 * evidence.effect:.1f} %"
        )
        return replace(foreign("km/h", why, "wind_speed"), possible=True)
    return None


def of_light(inputs: Inputs, bright: float, slope: float) -> UnitDoubt:
    """The suspicion that irradiance is in another unit, or an amount of each step."""
    why = (
        f"its largest values are {bright:.0f}, and for each of them the module gains "
        f"{slope:.2f} K, where W/m² gain 0.01 to 0.06 K"
    )
    least, most = GAIN
    fits = []
    for unit, (factor, _) in UNITS["irradiance"].items():
        factor /= inputs.step / HOUR if unit in AMOUNTS["irradiance"] else 1.0
        if DIM <= factor * bright <= BRIGHT and least <= slope / factor <= most:
            fits.append(unit)
    unit = fits[0] if len(fits) == 1 else ""
    options = " or ".join(f"--unit poa_global={u}" for u in fits or ("UNIT",))
    return UnitDoubt(
        "poa_global looks to be in another unit than W/m² (mW/cm², or J/cm² or Wh/m² "
        f"of each step): {why}",
        ShellText(CONVERT, f"Give {options} to convert it"),
        columns=("poa_global",) if unit else (),
        unit=unit,
        why=why,
    )


@dataclass(frozen=True)
class Reading:
    """What would make two temperatures that do not go together ones that can be."""

    name: str  # the column
    unit: str
    twice: bool  # whether it was converted from that unit twice, or is in it still

    def in_celsius(self, values: np.ndarray) -> np.ndarray:
        """The column as it would be in °C."""
        factor, offset = UNITS["temperature"][self.unit]
        return (values - offset) / factor if self.twice else factor * values + offset

    def __str__(self) -> str:
        if self.twice:
            return f"{self.name} may have been converted from {self.unit} twice"
        return f"{self.name} may be in {self.unit}"

    @property
    def undone(self) -> ShellText:
        """What to do if it is so."""
        if self.twice:
            return ShellText(*2 * [f"Undo one conversion of {self.name}"])
        return ShellText(
            f"Convert {self.name}", f"Give --unit {self.name}={self.unit} to convert it"
        )


#: every reading that there may be
READINGS = [
    Reading(name, unit, twice)
    for twice in (False, True)
    for name in ("temp_air", "temp_module")
    for unit in ("°F", "K")
]


def believable(evidence: Any) -> bool:
    """Whether the signs of a record are those of air and a module in °C."""
    low, most = RANGES["temp_air"].low, RANGES["temp_air"].most
    least, steepest = GAIN
    return (
        abs(evidence.night) <= APART
        and least <= evidence.slope <= steepest
        and low <= evidence.cold <= evidence.hot <= most
    )


def of_difference(inputs: Inputs, night: Any) -> UnitDoubt:
    """
    The suspicion of two temperatures that are too far apart by night.

    The difference alone does not say which of them is wrong: all readings are tried
    that would make a record of it that can be.
    """
    names = "temp_air", "temp_module"
    readings = [
        one
        for one in READINGS
        if believable(
            signs_of(inputs.having({one.name: one.in_celsius(inputs[one.name])}))
        )
    ]
    high, low = ("module", "air") if night > 0 else ("air", "module")
    why = f"at night it is {abs(night):.0f} above {low}"
    if [(one.name, one.twice) for one in readings] == [(f"temp_{high}", False)]:
        return foreign(readings[0].unit, why, readings[0].name)
    ends = {name: np.nanpercentile(inputs[name], [1, 99]) for name in names}
    seen = [f"{n} is {low:.0f} to {high:.0f}" for n, (low, high) in ends.items()]
    may = " or ".join(map(str, readings)) or "no unit of one of them explains that"
    return UnitDoubt(
        f"temp_air and temp_module do not go together: at night temp_{high} is "
        f"{abs(night):.0f} above temp_{low}, and in 98 % of the rows "
        f"{' and '.join(seen)}; {may}",
        ShellText(
            " or ".join(one.undone for one in readings) or "Look at both columns",
            " or ".join(one.undone.shell for one in readings) or "Look at both columns",
        ),
        "both are",
    )


def oddities(
    inputs: Inputs,
    limits: Limits | None = None,
    absent: tuple = (),
    timed: bool = False,
) -> Iterator[str]:
    """
    What looks odd in the columns but may be so.

    Parameters
    ----------
    inputs : Inputs
        With the four columns that every fit needs.
    limits : Limits, optional
        The thresholds.
    absent : tuple of str, default ()
        Columns that were not measured, which hold 0.
    timed : bool, default False
        Whether the clock of the module's logger has been checked already.

    Yields
    ------
    str
        A sentence each.
    """
    yield from interpolated_columns(inputs)
    limits, evidence = limits or Limits(), record_signs(inputs)
    if evidence is None:
        return
    odd, off = suspected(inputs, evidence, limits)
    if odd:
        yield odd.what
        return
    if off or not timed:
        off = off or module_lag(inputs, limits)
        if off and abs(off.late) >= HOUR:
            late = of_hours(off)
            yield (
                f"{late.what}, which a fit takes for a part of its time constant or "
                f"capacity. {late.remedy}; if they are of two files, give --tz for each"
            )
            return
    if evidence.hot > RANGES["temp_air"].most:
        yield (
            f"temp_air is above {evidence.hot:.0f} °C in 1 % of the rows, which few "
            "places reach: is it in °F, or in the sun?"
        )
    if "wind_speed" in absent:
        yield (
            "there is no wind_speed: coefficients hold for the winds of the record, "
            "and what the wind changes is in the error"
        )
    elif evidence.wind == evidence.strong:
        yield (
            f"wind_speed is {evidence.wind:g} m/s in all rows, so that nothing can be "
            "said of the wind's coefficient"
        )
    elif (
        evidence.wind > RANGES["wind_speed"].most
        and inputs.seconds[-1] > limits.min_record
    ):
        yield (
            f"wind_speed is {evidence.wind:.1f} m/s in the mean, more than near the "
            "ground of most sites: is it in mph or km/h, or from a mast?"
        )
    least, most = GAIN
    if not least < evidence.slope < most:
        yield (
            f"the module gains {1000 * evidence.slope:.0f} K per 1000 W/m², and "
            f"mountings gain {1000 * least:.0f} to {1000 * most:.0f} K: "
            "look at the units of both, at where the sensors are, and at shade"
        )


def slope_of(y: np.ndarray, x: np.ndarray) -> float:
    """Slope of the regression line, 0 where there is none."""
    if len(x) < 20 or np.ptp(x) == 0:
        return 0.0
    x = x - x.mean()
    return float(x @ (y - y.mean()) / (x @ x))
