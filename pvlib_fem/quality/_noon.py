"""Is the whole file late? The middle of each day's light against the sun's."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import pvlib
from pvlib.location import Location

from pvlib_fem._record.checks import instants, usual_step
from pvlib_fem.drivers import standard_time
from pvlib_fem.drivers._mounts import geometry, plane_angles
from pvlib_fem.drivers._planes import ANGLES
from pvlib_fem.quality._hours import day_of, days_of, listed_jumps, offsets, side_of
from pvlib_fem.quality._jumps import jumps_of, whole_hours
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._onset import DAY, HOUR, solar_midnight

#: standard time lasts 18 weeks and more between two summers
SHORTEST = pd.Timedelta(weeks=17)
SHORTEST_STEP = 300.0  # s; the light shows the middle of longer ones
#: correlation of the length of days with that at the location, below which its latitude
#: has the wrong sign; weather and hills leave it above 0
REVERSED = -0.5


@dataclass(frozen=True, eq=False)
class SolarNoon:
    """How late a whole file is by the sun, from :func:`solar_noon_shift`."""

    late: float  # outside daylight saving; NaN without a location [s]
    days: pd.Series  # for each day: the middle of its light, less that of the sun [s]
    jumps: tuple  # (first day after it, seconds)
    faults: dict  # name: one line
    why: str = ""  # what was not looked for
    within: tuple = ()  # (earliest, latest) day of each jump
    unsure: tuple = ()  # (begin, end) of the nights it may be in, from the start [s]
    hours: tuple = ()  # (from here on [s], late by that [s])

    def label(self, index: pd.Index) -> float:
        """From the middle of its step to the time of a row, if times are right."""
        return 0.0 if self.faults else label_by_sun(self.late, usual_step(index))


def solar_noon_shift(
    poa_global: np.ndarray,
    index: pd.DatetimeIndex,
    location: Location | None = None,
    surface_tilt: float | None = None,
    surface_azimuth: float | None = None,
    limits: Limits | None = None,
    mount: Any = None,
) -> SolarNoon:
    """
    How late a whole file is, by the middle of each day's light.

    Parameters
    ----------
    poa_global : array, shape (rows,)
        Irradiance in the plane of the array. [W/m²]
    index : DatetimeIndex, shape (rows,)
        Without a zone it is read as standard time at ``location``.
    location : pvlib.location.Location, optional
        Without it only jumps of an hour are seen, no constant shift.
    surface_tilt, surface_azimuth : float, optional
        Of the plane; horizontal where they are not known. [°]
    limits : Limits, optional
        The thresholds.
    mount : pvlib.pvsystem.AbstractMount, optional
        Of a plane that moves.

    Returns
    -------
    SolarNoon
        ``faults`` may have ``file_dst``, for jumps by an hour, ``file_jump``, for one
        or for others, ``file_shift``, for more than half an hour, and
        ``file_latitude``, for long days where those of the location are short.

    Notes
    -----
    The middle between first and last light, 20 W/m², needs no clear sky: clouds
    move either end by some minutes and both alike. A plane turned by 5° moves
    the noon of its energy by 20 min, but the edges of its light hardly. An edge is
    taken between two rows, so that it does not move by whole steps; where rows are
    further apart than an hour that is too coarse to look for jumps, and ``why``
    says so.

    A jump is of the median from the ten days before to the ten after, by half an hour
    at least. Within 15 min of whole hours it is those; any other has to hold over 30
    days. Where a file has no rows by night, missing rows outside its days are dark.
    """
    limits = limits or Limits()
    times = instants(index)
    seconds = (times - times[0]) / np.timedelta64(1, "s")
    if len(seconds) < 2 or seconds[-1] < limits.min_record:
        return SolarNoon(np.nan, pd.Series(dtype=float), (), {})
    step, dark = usual_step(index), solar_midnight(seconds, poa_global)
    poa = with_nights(seconds - dark, np.asarray(poa_global, dtype=float), limits)
    day, middle, length = light_of_days(seconds - dark, poa, step, limits)
    place_faults = {}
    if location is not None:
        origin = universal(index[0], location) + pd.Timedelta(seconds=dark)
        plane = (surface_tilt, surface_azimuth, mount)
        start = index[0] + pd.Timedelta(seconds=dark)
        due, due_length = due_light(origin, day, location, plane, limits, start)
        middle = (middle - due + DAY / 2) % DAY - DAY / 2
        place_faults = latitude_fault(length, due_length, location)
    when = dark + (day + 0.5) * DAY
    why, changes = "", []
    if step <= limits.max_noon_step:
        changes = jumps_of(day, middle, limits, apart=location is not None)
    else:
        why = (
            f"no jump of the whole file by an hour was looked for: rows are "
            f"{step / 60:.0f} min apart"
        )
    for change in changes:
        change["seconds"] = dark + change["day"] * DAY
    hours = levels(when, middle, changes, limits)
    late = np.nan
    if location is not None and len(day):
        late = float(np.median(middle - offsets(hours, when)))
    jumps = tuple((day_of(index[0], c["seconds"]), c["by"]) for c in changes)
    days = pd.Series(middle, days_of(index[0], when - DAY / 2))
    within = tuple(
        tuple(day_of(index[0], dark + d * DAY) for d in c["within"]) for c in changes
    )
    faults = noon_faults(late, jumps, step, limits) | place_faults
    unsure = tuple(tuple(dark + d * DAY for d in c["within"]) for c in changes)
    return SolarNoon(late, days, jumps, faults, why, within, unsure, hours)


def label_by_sun(late: float, step: float) -> float:
    """
    From the middle of its step to the time of a row, in steps.

    A mean over a step has the time at which the step begins, or ends, or its middle.
    Hills and clouds move the middle of the light by minutes, so that it does not show
    which it is of steps of 5 min and less.

    Parameters
    ----------
    late : float
        Of :class:`SolarNoon`. [s]
    step : float
        Usual time between rows. [s]

    Returns
    -------
    float
        -0.5, 0 or 0.5; 0 where either is NaN.
    """
    if not (step > SHORTEST_STEP and np.isfinite(late)):
        return 0.0
    return float(np.sign(np.round(2.0 * late / step))) / 2.0 + 0.0


def label_lines(label: float) -> Iterator[str]:
    """
    A line on rows that have the time at which their step ends or begins.

    Parameters
    ----------
    label : float
        From :func:`label_by_sun`. [steps]

    Yields
    ------
    str
        Nothing where rows have the middle of their steps.
    """
    if label:
        at, way = ("ends", "earlier") if label > 0 else ("begins", "later")
        yield (
            f"by the middle of the day's light each row is a mean over the step that "
            f"{at} at its time: the sun is taken half a step {way}"
        )


def geometry_of_means(
    light: np.ndarray,
    index: pd.DatetimeIndex,
    place: dict[str, Any],
    limits: Limits | None = None,
) -> tuple[dict[str, pd.Series], list[str]]:
    """
    Columns of sun and plane at the middle of steps, if rows are means over them.

    Parameters
    ----------
    light : array, shape (rows,)
        Irradiance in the plane. [W/m²]
    index : DatetimeIndex, shape (rows,)
    place : dict
        From :func:`pvlib_fem.drivers.checked_place`.
    limits : Limits, optional
        The thresholds.

    Returns
    -------
    dict of Series, list of str
        As :func:`pvlib_fem.drivers._mounts.geometry`, and a line on such means.
    """
    label = 0.0
    if place["location"] is not None:
        label = solar_noon_shift(light, index, **place, limits=limits).label(index)
    late = lateness_of(label, index)
    return geometry(index, **place, late=late), [*label_lines(label)]


def lateness_of(label: float, index: pd.Index) -> float:
    """
    By how much the times of rows are after the middle of their steps. [s]

    Parameters
    ----------
    label : float
        From :func:`label_by_sun`. [steps]
    index : Index
        Times of the rows.

    Returns
    -------
    float
        0 of a single row, and of an index without times.
    """
    if not label or len(index) < 2 or not isinstance(index, pd.DatetimeIndex):
        return 0.0
    return label * usual_step(index)


def levels(
    when: np.ndarray, middle: np.ndarray, changes: list, limits: Limits
) -> tuple:
    """From when on [s] the clock is how far [s] off where it is least wrong."""
    if not changes:
        return ()
    starts = [-np.inf, *(change["seconds"] for change in changes)]
    parts = np.searchsorted(starts, when, side="right") - 1
    level = np.array([np.median(middle[parts == i]) for i in range(len(starts))])
    level -= level[np.argmin(np.abs(level))]
    # neighbours that differ by what is no jump are one clock, uneven by its sun
    small = np.abs(level) < limits.daylight_tolerance
    late = [whole_hours(by, limits) or 60.0 * round(by / 60) for by in level]
    return tuple(zip(starts, np.where(small, 0.0, late)))


def latitude_fault(
    length: np.ndarray, due: np.ndarray, location: Location
) -> dict[str, str]:
    """Whether days are long where those of the location are short, in seconds."""
    if not len(length) or np.ptp(due) < HOUR or not np.ptp(length):
        return {}
    if np.corrcoef(length, due)[0, 1] > REVERSED:
        return {}
    return {
        "file_latitude": (
            "days of the file are long where those at latitude "
            f"{location.latitude:g}° are short: the latitude has the wrong sign "
            "(south is negative), or the dates are wrong"
        )
    }


def noon_faults(
    late: float, jumps: tuple, step: float, limits: Limits
) -> dict[str, str]:
    faults = {}
    if abs(late) > limits.daylight_tolerance + step / 2:
        faults["file_shift"] = (
            f"timestamps of the file run {abs(late) / 60:.0f} min {side_of(late)} the "
            "sun at the location: they are in another zone than stated, or the "
            "longitude has the wrong sign (times without a zone are read as standard "
            "time in the location's tz, or by its longitude where that is UTC)"
        )
    if not jumps:
        return faults
    moves = f"the day's light moves by {listed_jumps(jumps)}"
    hours = [day for day, by in jumps if abs(by) == HOUR]
    if len(hours) > 1 and hours[-1] - hours[0] > SHORTEST:
        faults["file_dst"] = (
            f"{moves}: the file keeps daylight-saving time; give its times that zone "
            "(tz_localize, or --tz), or keep standard time"
        )
    else:
        faults["file_jump"] = (
            f"{moves}: the clock of the file was set then; bring its times to one clock"
        )
    return faults


def with_nights(seconds: np.ndarray, poa: np.ndarray, limits: Limits) -> np.ndarray:
    """
    Irradiance with 0 before and after each day, in a file without nights.

    Parameters
    ----------
    seconds : numpy.ndarray, shape (rows,)
        Times since a midnight by the sun, at which days begin. [s]
    poa : numpy.ndarray, shape (rows,)
        Irradiance. [W/m²]
    limits : Limits
        ``min_light``, ``min_night`` and ``max_accident_share``, the share of the rows
        of night with a value from which the file has nights.

    Returns
    -------
    numpy.ndarray, shape (rows,)
        ``poa`` itself where the file has nights. Otherwise 0 for NaN outside the light
        of each day; a day without light stays as it is. [W/m²]
    """
    whole = np.floor(seconds / DAY)  # twice as fast as // and %
    deep = np.abs(seconds - whole * DAY - DAY / 2) > (DAY - limits.min_night) / 2
    if not deep.any() or np.isfinite(poa[deep]).mean() > limits.max_accident_share:
        return poa
    day, row = whole.astype(int), np.arange(len(poa))
    lit = np.flatnonzero(poa > limits.min_light)
    first, last = np.full(day.max() + 1, len(poa)), np.full(day.max() + 1, -1)
    np.minimum.at(first, day[lit], lit)
    np.maximum.at(last, day[lit], lit)
    outside = (row < first[day]) | (row > last[day])
    # a day that is lost as a whole stays so
    return np.where(outside & np.isnan(poa) & (last[day] >= 0), 0.0, poa)


def light_of_days(
    seconds: np.ndarray, poa: np.ndarray, step: float, limits: Limits
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    Middle and length of the light of each whole day.

    Parameters
    ----------
    seconds : numpy.ndarray, shape (rows,)
        Times since a midnight by the sun, at which days begin. [s]
    poa : numpy.ndarray, shape (rows,)
        Irradiance. [W/m²]
    step : float
        Usual time between rows. [s]
    limits : Limits
        ``min_light``, ``min_bright_irradiance``, ``min_night`` and
        ``max_accident_share``, the share of a day that may be missing.

    Returns
    -------
    day : numpy.ndarray of int, shape (days,)
        Numbers of the whole days, from 0.
    middle : numpy.ndarray, shape (days,)
        Half way between first and last light, from the begin of its day. [s]
    length : numpy.ndarray, shape (days,)
        From first to last light. [s]
    """
    if not len(lit := np.flatnonzero(poa > limits.min_light)):
        return np.zeros(0, dtype=int), np.zeros(0), np.zeros(0)
    day = np.floor(seconds / DAY).astype(int)
    rows = np.bincount(day, np.isfinite(poa))
    lit = lit[longest_light(day[lit], seconds[lit], limits)]
    of_lit, first = np.unique(day[lit], return_index=True)
    last = np.append(first[1:], len(lit)) - 1
    highest = np.maximum.reduceat(poa[lit], first)
    rise, fall = (
        edge(seconds, poa, lit[at], way, limits) for at, way in ((first, -1), (last, 1))
    )
    # what is lost of a day may be its first or last light
    lost = 1.0 - rows[of_lit] * step / DAY
    whole = (highest > limits.min_bright_irradiance) & (
        lost < limits.max_accident_share
    )
    whole &= DAY - (fall - rise) > limits.min_night  # False where one is NaN
    middle = (rise + fall) / 2 - of_lit * DAY
    return of_lit[whole], middle[whole], (fall - rise)[whole]


def longest_light(day: np.ndarray, seconds: np.ndarray, limits: Limits) -> np.ndarray:
    """Lit rows of the longest part of each day's light, of those a night apart."""
    new = np.diff(seconds) > limits.min_night
    new |= np.diff(day) > 0
    part = np.append(0, np.cumsum(new))
    rows = np.bincount(part)
    starts = np.flatnonzero(np.append(True, new))
    of_day = day[starts]
    order = np.lexsort((rows, of_day))  # of each day the longest is the last
    last = np.append(np.diff(of_day[order]) > 0, True)
    return np.isin(part, order[last])


def edge(
    seconds: np.ndarray, poa: np.ndarray, lit: np.ndarray, way: int, limits: Limits
) -> np.ndarray:
    """When light begins or ends, between a lit row and the adjacent dark one. [s]"""
    dark = np.clip(lit + way, 0, len(poa) - 1)
    change, rest = poa[lit] - poa[dark], poa[lit] - limits.min_light
    there = poa[dark] <= limits.min_light  # no edge in a polar day, nor next to a gap
    part = np.divide(rest, change, out=np.full(len(lit), np.nan), where=there)
    return seconds[lit] + part * (seconds[dark] - seconds[lit])


def universal(time: pd.Timestamp, location: Location) -> pd.Timestamp:
    """
    A time in UTC.

    Parameters
    ----------
    time : pandas.Timestamp
        Without a zone it is standard time at the location.
    location : pvlib.location.Location
        Used for a time without a zone.

    Returns
    -------
    pandas.Timestamp
        In UTC, without a zone.
    """
    if time.tz is not None:
        return time.tz_convert("UTC").tz_localize(None)
    return standard_time(pd.DatetimeIndex([time]), location)[0].tz_localize(None)


def due_light(
    origin: pd.Timestamp,
    days: np.ndarray,
    location: Location,
    plane: tuple,
    limits: Limits,
    start: pd.Timestamp,
) -> tuple[np.ndarray, np.ndarray]:
    """
    Middle and length of the light that a half-clear sky gives on some days.

    Parameters
    ----------
    origin : Timestamp
        In UTC, without a zone: midnight by the sun, from which days are counted.
    days : numpy.ndarray of int, shape (days,)
        Numbers of the days, in order. Each fifth is computed, and those between are
        interpolated.
    location : pvlib.location.Location
        Of the sensor.
    plane : tuple
        Tilt and azimuth [°], None where they are not known, and a mount or None.
    limits : Limits
        Thresholds of :func:`light_of_days`.
    start : Timestamp
        The origin as the record has it.

    Returns
    -------
    middle, length : numpy.ndarray, shape (days,)
        The middle is from the begin of each day; NaN if no day has an edge of light.
        [s]
    """
    if not len(days):
        return np.zeros(0), np.zeros(0)
    some = np.unique(np.append(days[::5], days[-1]))
    seconds = (some[:, None] * DAY + np.arange(0.0, DAY, 300.0)).ravel()
    times = (origin + pd.to_timedelta(seconds, unit="s")).tz_localize("UTC")
    sun = location.get_solarposition(times, method="ephemeris")
    ghi = 0.6 * pvlib.clearsky.haurwitz(sun["zenith"])["ghi"].to_numpy()
    zenith, azimuth = sun["zenith"].to_numpy(), sun["azimuth"].to_numpy()
    parts = pvlib.irradiance.erbs(ghi, zenith, times)
    *angles, mount = plane
    tilt, turn = (usual if a is None else a for a, usual in zip(angles, (0.0, 180.0)))
    if mount is not None:
        own = times if start.tz else start + pd.to_timedelta(seconds, unit="s")
        mount_angles = plane_angles(mount, times, location, own)
        tilt = np.nan_to_num(mount_angles.get(ANGLES[0], tilt))
        turn = np.nan_to_num(mount_angles.get(ANGLES[1], turn), nan=180.0)
    poa = pvlib.irradiance.get_total_irradiance(
        tilt,
        turn,
        zenith,
        azimuth,
        parts["dni"],
        ghi,
        parts["dhi"],
    )["poa_global"]
    # each day by itself and from dark to dark, wherever its own midnight is
    poa = np.asarray(poa)
    dark = round(solar_midnight(seconds, poa) / 300.0)
    poa = np.roll(poa.reshape(len(some), -1), -dark, axis=1).ravel()
    day, middle, length = light_of_days(seconds, poa, 300.0, limits)
    if not len(day):
        return np.full(len(days), np.nan), np.full(len(days), np.nan)
    middle = np.interp(days, day, middle + 300.0 * dark)
    return middle, np.interp(days, day, length)
