"""A file whose clock jumps, by daylight saving or by a hand, brought to one clock."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
import pandas as pd
from pvlib.location import Location

from pvlib_fem.quality._clock_changes import (
    transitions,
    wall_time,
    zone_offsets,
    zones_around,
)
from pvlib_fem.quality._hours import MOST, date_span, listed_jumps, offsets
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._noon import SolarNoon, solar_noon_shift, universal
from pvlib_fem.quality._onset import DAY

#: of a file
Data = TypeVar("Data", pd.DataFrame, pd.Series)


@dataclass(frozen=True, eq=False)
class Daylight:
    """What explains the jumps of a file's clock, from :func:`daylight_saving`."""

    zone: str  # whose daylight saving it keeps; "" if it keeps none
    line: str  # what was found, or why not and the remedy
    index: pd.DatetimeIndex  # standard time of the rows that are kept
    kept: np.ndarray  # rows whose time is known
    before: float = np.nan  # daily noon less the sun's, root mean square [min]
    after: float = np.nan  # the same by the corrected times [min]
    transitions: tuple = ()  # of the zone: (time in standard time, seconds)
    jumps: tuple = ()  # others that were taken out: (first day after it, seconds)
    jumps_kept: tuple = ()  # others that were not taken out
    brief: str = ""  # the line's part on what was found and done
    evidence: str = ""  # the rest of the line

    @property
    def explained(self) -> bool:
        return bool(self.zone or self.jumps)

    @property
    def fault(self) -> str:
        """What is corrected, or, where nothing is, what is not."""
        if self.zone:
            return "file_dst+file_jump" if self.jumps else "file_dst"
        return "file_jump"

    def corrected(self, data: Data) -> Data:
        """A Series or DataFrame of the file by one clock, without lost rows."""
        return data[self.kept].set_axis(self.index)


def daylight_saving(
    poa_global: np.ndarray,
    index: pd.DatetimeIndex,
    noon: SolarNoon,
    location: Location,
    surface_tilt: float | None = None,
    surface_azimuth: float | None = None,
    limits: Limits | None = None,
    mount: Any = None,
) -> Daylight:
    """
    Bring a file whose clock jumps to one clock, its standard time.

    Parameters
    ----------
    poa_global : array, shape (rows,)
        Irradiance in the plane of the array. [W/m²]
    index : DatetimeIndex, shape (rows,)
        What the file calls its times, without a zone or in a zone of no daylight
        saving.
    noon : SolarNoon
        From :func:`solar_noon_shift`, with this location.
    location : pvlib.location.Location
        Its ``tz`` is the zone that is tried; where that has no daylight saving, as
        UTC, all zones of the same standard time are, the nearest place first.
    surface_tilt, surface_azimuth : float, optional
        Of the plane; horizontal where they are not known. [°]
    limits : Limits, optional
        The thresholds.
    mount : pvlib.pvsystem.AbstractMount, optional
        Of a plane that moves.

    Returns
    -------
    Daylight
        ``index`` is in the zone of the given one, or without one as that is.
        Where nothing is explained it is the given one, and ``line`` says why.

    Notes
    -----
    A zone explains jumps if two at least are its transitions by sign and date, and
    none of its transitions lacks that the record could show. By its clock an hour is
    left out in spring: rows that a file has in it have no time. An hour comes twice in
    autumn: where a file has it twice, the first is summer time; where it has it once,
    which one is not known. Such rows are dropped, and ``line`` counts them.

    Any other jump is of a clock that was set. Between two of them the rows move as a
    whole, to where the clock fits the sun best; those within a day of the night, or
    the nights, in which it may have been are dropped. The light decides whether
    either step holds: it must move less often, and be nearer to the sun. What still
    moves is in ``jumps_kept``.
    """
    limits = limits or Limits()
    if reason := why_no_zone(index, noon):
        return as_it_is(index, reason, noon)
    place = (location, surface_tilt, surface_azimuth, limits, mount)
    poa = np.asarray(poa_global)
    kept, now, words, due = np.ones(len(index), dtype=bool), noon, [], ()
    times = index
    zone, why = zone_of(index, noon, location, limits)
    if zone:
        then, there = standard_index(index, zone)
        moved = solar_noon_shift(poa[there], then, *place)
        if fits_sun_better(moved, now):
            times, kept, now, due = then, there, moved, tuple(transitions(index, zone))
            words.append(
                f"keeps the clock of {zone}, {changes_text(due)}: brought to standard "
                "time"
            )
        else:
            zone, why = "", f"by {zone} the day's light is no nearer to the sun"
    taken = ()
    if now.jumps:
        then, there = by_segments(times, now)
        moved = solar_noon_shift(poa[kept][there], then, *place)
        if fits_sun_better(moved, now):
            words.append(
                f"is {of_segments(now)}, where its clock was set"
                f"{why and f' ({why})'}: brought to one clock"
            )
            taken = tuple(jump for jump in now.jumps if jump not in moved.jumps)
            times, now = then, moved
            kept[kept] = there
    if not words:
        return as_it_is(index, f"{why or 'no zone fits'}; {REMEDY}", noon)
    brief = f"the file {', and '.join(words)}"
    evidence = evidence_of(noon, now, int((~kept).sum()))
    line = brief + evidence
    before, after = (root_mean_square(shift.days) / 60 for shift in (noon, now))
    return Daylight(
        zone, line, times, kept, before, after, due, taken, now.jumps, brief, evidence
    )


REMEDY = "set the times to one clock, such as standard time"


def as_it_is(index: pd.DatetimeIndex, reason: str, noon: SolarNoon) -> Daylight:
    kept = np.ones(len(index), dtype=bool)
    return Daylight("", reason, index, kept, jumps_kept=noon.jumps)


def fits_sun_better(then: SolarNoon, now: SolarNoon) -> bool:
    """Whether fewer jumps remain, and the light is nearer to the sun."""
    near = root_mean_square(then.days) < root_mean_square(now.days)
    return len(then.jumps) < len(now.jumps) and near


def evidence_of(noon: SolarNoon, now: SolarNoon, lost: int) -> str:
    """What the corrected times gain and lose, in words."""
    before, after = (root_mean_square(shift.days) / 60 for shift in (noon, now))
    line = (
        f"; the day's light is {after:.0f} min off the sun, and was {before:.0f} (root "
        "mean square)"
    )
    if lost:
        line += f"; {lost:,} rows around the changes have no sure time and are left out"
    if now.jumps:
        line += (
            f"; it still moves by {listed_jumps(now.jumps)}, so that the times from "
            f"{now.jumps[0][0].date()} on are not sure: {REMEDY}"
        )
    return line


def root_mean_square(days: pd.Series) -> float:
    return float(np.sqrt(np.mean(days.to_numpy() ** 2)))


def why_no_zone(index: pd.DatetimeIndex, noon: SolarNoon) -> str:
    """Why no zone is tried; "" if zones are tried."""
    if not noon.jumps:
        return "no jump of the light was found: nothing is to be corrected"
    if index.tz is not None and list(transitions(index, str(index.tz))):
        return (
            f"the file's times have the zone {index.tz}, which takes daylight saving "
            "out, and yet the day's light moves by an hour: the file may have kept "
            f"standard time; give its times {standard_zone(index)} instead"
        )
    return ""


def zone_of(
    index: pd.DatetimeIndex, noon: SolarNoon, location: Location, limits: Limits
) -> tuple[str, str]:
    """The zone that explains two jumps or more, or "" and what speaks against one."""
    own = str(location.tz)
    if due := list(transitions(index, own)):
        why = against_zone(due, own, noon, limits)
        return ("", why) if why else (own, "")
    origin = universal(index[0], location)
    offset = (wall_time(index[0]) - origin).total_seconds()
    for zone in zones_around(location, origin, offset):
        if not against_zone(list(transitions(index, zone)), zone, noon, limits):
            return zone, ""
    return "", ""


def against_zone(due: list, zone: str, noon: SolarNoon, limits: Any) -> str:
    """What speaks against a zone whose clock moves on these dates; "" if nothing."""
    unmatched, matched = list(due), 0
    for (_, by), within in zip(noon.jumps, noon.within):
        for transition in [
            t for t in unmatched if may_be_transition(*[t, by, *within, limits])
        ][:1]:
            unmatched.remove(transition)
            matched += 1
    if matched < 2:
        on = "none of its dates" if not matched else "one of its dates alone"
        return f"{zone} has {changes_text(due)}, and the day's light moves on {on}"
    if missed := [t for t in unmatched if visible(t[0], noon.days, limits)]:
        return (
            f"{zone} has {changes_text(missed)}, and the day's light does not move then"
        )
    return ""


def by_segments(
    index: pd.DatetimeIndex, noon: SolarNoon
) -> tuple[pd.DatetimeIndex, np.ndarray]:
    """Times with each stretch between two jumps moved as a whole, and sure rows."""
    seconds = (index - index[0]).total_seconds().to_numpy()
    kept = np.ones(len(index), dtype=bool)
    for first, last in noon.unsure:
        # a day's light is off by an hour by weather, too, now and then
        kept &= (seconds < first - DAY) | (seconds > last + DAY)
    late = offsets(noon.hours, seconds[kept])
    return index[kept] - pd.to_timedelta(late, unit="s"), kept


def of_segments(noon: SolarNoon) -> str:
    """How far each stretch was off, in words."""
    parts, hours = [], noon.hours
    days = [day.date() for day, _ in noon.jumps]
    for i, (_, late) in enumerate(hours):
        if late:
            way = "ahead" if late > 0 else "behind"
            since = f" from {days[i - 1]}" if i else ""
            until = f" until {days[i]}" if i < len(days) else " on"
            parts.append(f"{abs(late) / 60:.0f} min {way}{since}{until}")
    if len(parts) > MOST:
        worst = max(abs(late) for _, late in hours) / 60
        return f"off by {worst:.0f} min at most, with jumps {date_span(noon.jumps)}"
    return ", ".join(parts)


def changes_text(due: Sequence) -> str:
    """The changes of a zone's clock in words."""
    if len(due) <= MOST:
        return listed_jumps(due)
    return f"{len(due)} changes {date_span(due)}"


def may_be_transition(
    transition: tuple,
    by: float,
    earliest: pd.Timestamp,
    latest: pd.Timestamp,
    limits: Limits,
) -> bool:
    """
    Whether a jump may be this transition.

    Days begin up to half a day off, and the light of rows of hours tells an hour to
    half of it.
    """
    time, due = transition
    day = pd.Timedelta(days=1)
    first, last = wall_time(earliest) - day, wall_time(latest) + day
    return (
        abs(by - due) < limits.daylight_tolerance and first <= time.normalize() <= last
    )


def visible(time: pd.Timestamp, days: pd.Series, limits: Limits) -> bool:
    """Whether enough days on both sides of a time would have shown a jump."""
    day, side = pd.DatetimeIndex([wall_time(d) for d in days.index]), limits.noon_window
    at = int(day.searchsorted(time))
    if not side // 2 <= at <= len(day) - side // 2:
        return False
    around = day[max(at - side, 0) : at + side]
    return around[-1] - around[0] <= pd.Timedelta(days=4 * side)


def standard_index(
    index: pd.DatetimeIndex, zone: str
) -> tuple[pd.DatetimeIndex, np.ndarray]:
    """Wall times of a zone as standard time, and which rows have one."""
    wall = index.tz_localize(None)
    first = ~wall.duplicated()  # of an hour that comes twice, summer time is first
    local = wall.tz_localize(zone, ambiguous=first, nonexistent="NaT")
    sure = wall.tz_localize(zone, ambiguous="NaT", nonexistent="NaT").notna()
    kept = local.notna() & (sure | wall.duplicated(keep=False))
    utc = local[kept].tz_convert("UTC")
    standard = pd.Timedelta(seconds=float(zone_offsets(utc, zone).min()))
    times = utc.tz_localize(None) + standard
    return times if index.tz is None else times.tz_localize(index.tz), kept


def standard_zone(index: pd.DatetimeIndex) -> str:
    """The fixed zone of the same standard time."""
    hours = zone_offsets(index.tz_convert("UTC"), str(index.tz)).min() / 3600
    return f"Etc/GMT{-hours:+.0f}" if hours == round(hours) else "that of standard time"
