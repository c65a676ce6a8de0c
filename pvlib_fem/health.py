"""Faults of sensors and loggers, found before any model is fitted.

What is checked needs no thermal model: a sensor that stands still while the others
move, a file whose noon is at one o'clock, a module that answers before the sun asks
(`clock`), a driver in another unit.
"""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd
import pvlib

from pvlib_fem.clock import (
    DAY,
    HOUR,
    Clock,
    clock_shift,
    day_of,
    hours_of,
    night,
    offsets,
)
from pvlib_fem.drivers import standard_time
from pvlib_fem.records import POSSIBLE, instants
from pvlib_fem.relaxation import ewm

TAU = 378.0  # s, a module's memory: what irradiance it has felt
LEAST = 5  # rows that are the same
HALF_HOUR, NIGHT, CALM = 1800.0, 3 * HOUR, 3 * DAY  # s
FELT = 100.0  # W/m², 2 to 6 K of a module
FINE = 0.1  # K; a coarser sensor may stand still for that much longer
WARMED = 10.0  # K of over-temperature, which takes some 300 W/m²
LIGHT = 20.0  # W/m², above what a thermopile reads at night
BRIGHT = 100.0  # W/m², a day that gets less has no clear edges
JUMP = (2700.0, 4500.0)  # s, 60 ± 15 min
#: s, what a turned plane, a horizon or averages of an hour may do to a noon
OFF_NOON = 1800.0
SIDE = 10  # days on each side of a change
MOST = 0.01  # share of odd values that is still an accident


@dataclass(frozen=True, eq=False)
class SolarNoon:
    """How late a whole file is by the sun, from :func:`solar_noon_shift`."""

    late: float  # outside daylight saving; NaN without a location [s]
    days: pd.Series  # by the day: the middle of its light, less what is due [s]
    jumps: tuple  # (first day after it, seconds)
    faults: dict  # name: one line


@dataclass(frozen=True, eq=False)
class Health:
    """What is wrong with a record before anything is fitted, from :func:`check`."""

    mask: np.ndarray  # True: a row that must not be used
    stuck: dict[str, int]  # rows by column
    clock: Clock
    noon: SolarNoon
    doubtful: dict[str, str]  # drivers that must not be used, and why
    faults: dict[str, str] = field(default_factory=dict)  # name: one line

    @property
    def unchecked(self) -> tuple:
        """What could not be checked, one line each."""
        return () if self.clock.fault else tuple(filter(None, (self.clock.why,)))

    @property
    def notes(self) -> tuple:
        """One line each, with its remedy: the faults, and what was not checked."""
        return (*self.faults.values(), *self.unchecked)


def check(record, location=None, surface_tilt=None, surface_azimuth=None) -> Health:
    """
    Find faults of sensors and loggers in a measured record.

    Parameters
    ----------
    record : Record
        From ``records.measured``, with the drivers that are to be used.
    location : pvlib.location.Location, optional
        For :func:`solar_noon_shift`.
    surface_tilt, surface_azimuth : float, optional
        Of the irradiance sensor. [°]

    Returns
    -------
    Health
        ``faults`` by name: ``stuck``, ``clock_shift``, ``clock_drift``, ``dst``,
        ``file_shift``, ``file_dst``, ``units:<column>``. ``mask`` has the rows of
        stuck sensors; a clock is corrected by ``clock.corrected``.
    """
    frozen = stuck(record)
    mask = np.any(list(frozen.values()), axis=0)
    clock = clock_shift(record, skip=mask)
    noon = solar_noon_shift(
        record["poa_global"], record.index, location, surface_tilt, surface_azimuth
    )
    doubts = doubtful(record.inputs.columns)
    faults = {"stuck": stuck_line(record, frozen)} if mask.any() else {}
    faults |= clock.faults | noon.faults
    faults |= {f"units:{name}": line for name, line in doubts.items()}
    counts = {name: int(rows.sum()) for name, rows in frozen.items()}
    return Health(mask, counts, clock, noon, doubts, faults)


def stuck(record) -> dict[str, np.ndarray]:
    """
    Rows in which a sensor stands still while what moves it moves.

    A value that repeats for more than 30 min and 5 rows is no sign by itself: a
    night is still, a calm is long. It counts where

    * ``temp_module`` has felt irradiance change by 100 W/m², or the air by 1 K and
      more over 3 h; at 0 °C, where snow melts, only after a day, and at a resolution
      coarser than 0.1 K after that much longer than 30 min;
    * ``temp_air`` has seen irradiance change by 300 W/m² and the module by 10 K
      for 3 h;
    * ``poa_global`` stays while the module's over-temperature changes by 10 K, in the
      dark (20 W/m²) for more than a day;
    * ``wind_speed`` is not 0 for 6 h, or 0 for three days.

    Parameters
    ----------
    record : Record
        From ``records.measured``.

    Returns
    -------
    dict
        Column to an array of booleans.

    Notes
    -----
    Only the resolution of the columns enters; a smooth column cannot repeat.
    """
    seconds = record.inputs.seconds
    poa, air, wind, module = (record[name] for name in POSSIBLE)
    felt = ewm(pd.Series(poa, record.index), TAU).to_numpy()

    def rows(values, judge):
        first, count = runs(values)
        last = first + count - 1
        lasts = seconds[last] - seconds[first]
        some = (count > LEAST) & (lasts > HALF_HOUR) & np.isfinite(values[first])
        first, last, lasts = first[some], last[some], lasts[some]
        spread = lambda other: extent(other, first, last)  # noqa: E731
        return between(first, last, judge(values[first], lasts, spread), len(values))

    step = resolution(air) + resolution(module)
    return {
        "poa_global": rows(
            poa,
            lambda v, t, of: (of(module - air) > WARMED) & ((v > LIGHT) | (t > DAY)),
        ),
        "temp_air": rows(
            air, lambda v, t, of: (t > NIGHT) & (of(poa) > 300) & (of(module) > WARMED)
        ),
        "wind_speed": rows(wind, lambda v, t, of: t > np.where(v > 0, 2 * NIGHT, CALM)),
        "temp_module": rows(
            module,
            lambda v, t, of: (
                ((of(felt) > FELT) | ((t > NIGHT) & (of(air) > 1.0 + 2 * step)))
                & ((np.abs(v) > 0.5) | (t > DAY))
                & (t > HALF_HOUR * resolution(module) / FINE)
            ),
        ),
    }


def runs(values):
    """First row and length of each run of one value; a NaN is a run of its own."""
    first = np.flatnonzero(np.concatenate(([True], values[1:] != values[:-1])))
    return first, np.diff(first, append=len(values))


def extent(values, first, last):
    """Largest less smallest value from each first to its last row; 0 without one."""
    if not len(first):
        return np.zeros(0)
    # reduceat takes pairs of rows and what is between the pairs, which is left out
    pairs = np.column_stack((first, last)).ravel()
    low = np.fmin.reduceat(values, pairs)[::2]
    return np.nan_to_num(np.fmax.reduceat(values, pairs)[::2] - low)


def between(first, last, kept, rows):
    """Booleans that are True in the kept runs."""
    edge = np.zeros(rows + 1, dtype=int)
    edge[first[kept]] += 1
    edge[last[kept] + 1] -= 1
    return np.cumsum(edge[:-1]) > 0


def resolution(values):
    """Smallest change of a column; 0 of one that never changes."""
    change = np.abs(np.diff(values))
    return float(change[change > 1e-9].min(initial=np.inf)) % np.inf


def stuck_line(record, frozen):
    lines = []
    for name, rows in frozen.items():
        if rows.any():
            at = int(np.argmax(rows))
            lines.append(
                f"{name} stands still at {record[name][at]:g} from {record.index[at]} "
                f"on, {rows.sum()} rows in all"
            )
    return "; ".join(lines) + ": they are not used; look at sensor and logger"


def solar_noon_shift(
    poa_global, index, location=None, surface_tilt=None, surface_azimuth=None
) -> SolarNoon:
    """
    How late a whole file is, by the middle of each day's light.

    Parameters
    ----------
    poa_global : array
        Irradiance in the plane of the array. [W/m²]
    index : DatetimeIndex
        Without a zone it is read as standard time at ``location``.
    location : pvlib.location.Location, optional
        Without it only jumps of an hour are seen, no constant shift.
    surface_tilt, surface_azimuth : float, optional
        Of the plane; horizontal where they are not known. [°]

    Returns
    -------
    SolarNoon
        ``faults`` may have ``file_dst``, for jumps by 60 ± 15 min from the ten days
        before to the ten after, and ``file_shift``, for more than half an hour.

    Notes
    -----
    The middle between first and last light, 20 W/m², needs no clear sky: clouds
    move either end by some minutes and both alike. A plane turned by 5° moves
    the noon of its energy by 20 min, but the edges of its light hardly.
    """
    times = instants(index)
    seconds = (times - times[0]) / np.timedelta64(1, "s")
    if len(seconds) < 2 or seconds[-1] < 2 * DAY:
        return SolarNoon(np.nan, pd.Series(dtype=float), (), {})
    step, dark = np.median(np.diff(seconds)), night(seconds, poa_global)
    day, middle = middles(seconds - dark, np.asarray(poa_global), step)
    if location is not None:
        origin = universal(index[0], location) + pd.Timedelta(seconds=dark)
        late = middle - due(origin, day, location, surface_tilt, surface_azimuth)
        middle = (late + DAY / 2) % DAY - DAY / 2
    when = dark + (day + 0.5) * DAY
    changes = steps_of_an_hour(day, middle)
    for change in changes:
        change["seconds"] = dark + change["day"] * DAY
    blocks = [dict(seconds=t, late=late) for t, late in zip(when, middle)]
    hours = hours_of(blocks, changes)
    late = np.nan
    if location is not None and len(day):
        late = float(np.median(middle - offsets(hours, when)))
    jumps = tuple((day_of(index[0], c["seconds"]), c["by"]) for c in changes)
    days = pd.Series(middle, [day_of(index[0], t - DAY / 2) for t in when])
    return SolarNoon(late, days, jumps, noon_faults(late, jumps, step))


def noon_faults(late, jumps, step):
    faults = {}
    if abs(late) > OFF_NOON + step / 2:
        faults["file_shift"] = (
            f"the day's light is {abs(late) / 60:.0f} min too "
            f"{'late' if late > 0 else 'early'} for the location: the times are in "
            "another zone than they say, or longitude has the wrong sign; a time "
            "without a zone is read as standard time at the location's tz, or by its "
            "longitude where that is UTC"
        )
    if jumps:
        dates = ", ".join(f"{by / 60:+.0f} min on {day.date()}" for day, by in jumps)
        faults["file_dst"] = (
            f"the day's light moves by {dates}: the file keeps daylight-saving time; "
            "give its index that zone (tz_localize), or keep standard time"
        )
    return faults


def middles(seconds, poa, step):
    """Days that are whole, and the middle of the light of each. [s of its day]"""
    if not len(lit := np.flatnonzero(poa > LIGHT)):
        return np.zeros(0, dtype=int), np.zeros(0)
    day = (seconds // DAY).astype(int)
    rows = np.bincount(day, np.isfinite(poa))
    of_lit, first = np.unique(day[lit], return_index=True)
    last = np.append(first[1:], len(lit)) - 1
    highest = np.maximum.reduceat(poa[lit], first)
    # what is lost of a day may be its first or last light
    whole = (highest > BRIGHT) & (rows[of_lit] > 0.98 * DAY / step)
    middle = (seconds[lit[first]] + seconds[lit[last]]) / 2 - of_lit * DAY
    return of_lit[whole], middle[whole]


def universal(time, location):
    """A time in UTC; without a zone, it is standard time at the location."""
    if time.tz is not None:
        return time.tz_convert("UTC").tz_localize(None)
    return standard_time(pd.DatetimeIndex([time]), location)[0].tz_localize(None)


def due(origin, days, location, surface_tilt, surface_azimuth):
    """The middle of the light that a half-clear sky gives on those days. [s]"""
    if not len(days):
        return np.zeros(0)
    some = np.unique(np.append(days[::5], days[-1]))
    seconds = (some[:, None] * DAY + np.arange(0.0, DAY, 300.0)).ravel()
    times = (origin + pd.to_timedelta(seconds, unit="s")).tz_localize("UTC")
    sun = location.get_solarposition(times, method="ephemeris")
    ghi = 0.6 * pvlib.clearsky.haurwitz(sun["zenith"])["ghi"]
    parts = pvlib.irradiance.erbs(ghi, sun["zenith"], times)
    poa = pvlib.irradiance.get_total_irradiance(
        0.0 if surface_tilt is None else surface_tilt,
        180.0 if surface_azimuth is None else surface_azimuth,
        sun["zenith"],
        sun["azimuth"],
        parts["dni"],
        ghi,
        parts["dhi"],
    )["poa_global"]
    # each day by itself and from dark to dark, wherever its own midnight is
    poa = poa.to_numpy()
    dark = round(night(seconds, poa) / 300.0)
    poa = np.roll(poa.reshape(len(some), -1), -dark, axis=1).ravel()
    day, middle = middles(seconds, poa, 300.0)
    if not len(day):
        return np.full(len(days), np.nan)
    return np.interp(days, day, middle + 300.0 * dark)


def steps_of_an_hour(day, middle):
    """Days at which the middle of the light moves by an hour for good."""
    found = []
    for i in range(SIDE // 2, len(day) - SIDE // 2 + 1):
        sides = middle[max(i - SIDE, 0) : i], middle[i : i + SIDE]
        if day[min(i + SIDE, len(day)) - 1] - day[max(i - SIDE, 0)] > 4 * SIDE:
            continue
        centres = [np.median(side) for side in sides]
        by = centres[1] - centres[0]
        if not JUMP[0] < abs(by) < JUMP[1]:
            continue
        rough = sum(np.abs(side - c).mean() for side, c in zip(sides, centres))
        found.append(dict(day=int(day[i]), by=float(np.sign(by) * HOUR), rough=rough))
    # neighbours see the same step; it is where both sides are the most even
    groups = []
    for step in found:
        if groups and step["day"] - groups[-1][-1]["day"] <= SIDE:
            groups[-1].append(step)
        else:
            groups.append([step])
    return [min(group, key=lambda step: step["rough"]) for group in groups]


def doubtful(columns) -> dict[str, str]:
    """
    Drivers that look to be in another unit, or not what their name says.

    The four columns that every fit needs are checked by ``records.measured``.

    Parameters
    ----------
    columns : mapping
        Name to values, as pvlib names them, among them ``poa_global`` [W/m²].

    Returns
    -------
    dict
        Name to one line with the remedy; such a column should not be used.

    Examples
    --------
    >>> doubtful({"relative_humidity": [0.4, 0.9]})["relative_humidity"]
    'relative_humidity is 0.9 at most, a fraction; multiply it by 100 for %'
    """
    columns = {name: np.asarray(values, float) for name, values in columns.items()}
    found = {}
    for name, values in columns.items():
        seen = values[np.isfinite(values)]
        if name in POSSIBLE or not len(seen):
            continue
        kind = "temp_" if name.startswith("temp_") else name
        reason = DOUBTS[kind](seen) if kind in DOUBTS else ""
        if name == "p_dc" and "poa_global" in columns:
            reason = power_doubt(values, columns["poa_global"])
        if reason:
            found[name] = f"{name} {reason}"
    return found


def share(odd):
    return np.mean(odd) > MOST


def humidity_doubt(seen):
    if seen.max() <= 1.5:
        return f"is {seen.max():.2g} at most, a fraction; multiply it by 100 for %"
    if share((seen < 0) | (seen > 110)):
        return f"goes from {seen.min():.3g} to {seen.max():.3g}; it should be in %"
    return ""


def longwave_doubt(seen):
    if share((seen < 100) | (seen > 550)):
        return (
            f"has a median of {np.median(seen):.0f} W/m², and skies send 100 to 550; a "
            "pyrgeometer's net signal needs the σT⁴ of its body added"
        )
    return ""


def direction_doubt(seen):
    if seen.max() <= 6.3 and len(seen) > LEAST:
        return f"is {seen.max():.2g} at most, radians; use np.degrees"
    if share((seen < 0) | (seen > 360)):
        return f"goes from {seen.min():.0f} to {seen.max():.0f}°; use it modulo 360"
    return ""


def rain_doubt(seen):
    if (seen < 0).any():
        return f"is {seen.min():.3g} at least; a counter needs its resets taken out"
    return ""


def kelvin_doubt(seen):
    if np.median(seen) > 150:
        return f"has a median of {np.median(seen):.0f}, kelvin; subtract 273.15"
    return ""


def power_doubt(power, poa):
    """A module gives a quarter of its light at most; 0.4 leaves room for sensors."""
    sunny = (poa > 200) & np.isfinite(power)
    ratio = np.median(power[sunny] / poa[sunny]) if sunny.any() else 0.0
    if ratio > 0.4:
        return (
            f"is {ratio:.2g} of poa_global, and no module gives 0.4; divide W by the "
            "area of the modules for W/m²"
        )
    return ""


#: what to ask of a driver by its name
DOUBTS = {
    "relative_humidity": humidity_doubt,
    "longwave_down": longwave_doubt,
    "wind_direction": direction_doubt,
    "precipitation": rain_doubt,
    "snow_depth": rain_doubt,
    "temp_": kelvin_doubt,
}
