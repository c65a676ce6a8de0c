"""A file that keeps daylight-saving time, brought back to standard time."""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from pvlib_fem.quality.limits import Limits
from pvlib_fem.quality.noon import solar_noon_shift


@dataclass(frozen=True, eq=False)
class Daylight:
    """What explains a file's jumps by an hour, from :func:`daylight_saving`."""

    zone: str  # that explains them; "" if none does
    line: str  # what was found, or why not and the remedy
    index: pd.DatetimeIndex  # standard time of the rows that are kept
    kept: np.ndarray  # rows whose time is known
    before: float = np.nan  # daily noon less the sun's, root mean square [min]
    after: float = np.nan  # the same by the corrected times [min]
    transitions: tuple = field(default=())  # (time in standard time, seconds)

    @property
    def explained(self) -> bool:
        return bool(self.zone)

    def corrected(self, data):
        """A Series or DataFrame of the file by standard time, without lost rows."""
        return data[self.kept].set_axis(self.index)


def daylight_saving(
    poa_global,
    index,
    noon,
    location,
    surface_tilt=None,
    surface_azimuth=None,
    limits=None,
) -> Daylight:
    """
    Bring a file that keeps daylight-saving time back to standard time.

    Parameters
    ----------
    poa_global : array
        Irradiance in the plane of the array. [W/m²]
    index : DatetimeIndex
        What the file calls its times, without a zone or in a zone of no daylight
        saving.
    noon : SolarNoon
        From :func:`solar_noon_shift`, with this location.
    location : pvlib.location.Location
        Its ``tz`` is the zone that is tried.
    surface_tilt, surface_azimuth : float, optional
        Of the plane; horizontal where they are not known. [°]
    limits : Limits, optional

    Returns
    -------
    Daylight
        ``index`` is in the zone of the given one, or without one as that is.
        Where nothing is explained it is the given one, and ``line`` says why.

    Notes
    -----
    The zone explains the jumps if there are two at least, each is one of its
    transitions by sign and date, and no transition lacks that the record could
    show. One jump alone may be a clock that was set.

    By the zone's clock an hour is left out in spring: rows that a file has in it
    have no time. An hour comes twice in autumn: where a file has it twice, the
    first is summer time; where it has it once, which one is not known. Such rows
    are left out, and ``line`` counts them.
    """
    limits = limits or Limits()
    zone = str(location.tz)
    if reason := unexplained(index, noon, zone, limits):
        return as_it_is(index, reason)
    standard, kept = standard_index(index, zone)
    place = (location, surface_tilt, surface_azimuth, limits)
    then = solar_noon_shift(np.asarray(poa_global)[kept], standard, *place)
    before, after = (root_mean_square(found.days) / 60 for found in (noon, then))
    numbers = f"the day's light is {after:.0f} min off the sun, and was {before:.0f}"
    if then.jumps or not after < before:
        return as_it_is(index, f"by {zone}, {numbers}: {remedy(zone)}")
    line = (
        f"the file keeps daylight-saving time as {zone} has it; brought to standard "
        f"time, {numbers} (root mean square)"
    )
    if lost := int((~kept).sum()):
        line += f"; {lost} rows of the hours that it skips or has twice are left out"
    changes = tuple(transitions(index, zone))
    return Daylight(zone, line, standard, kept, before, after, changes)


def as_it_is(index, reason):
    return Daylight("", reason, index, np.ones(len(index), dtype=bool))


def root_mean_square(days):
    return float(np.sqrt(np.mean(days.to_numpy() ** 2)))


def unexplained(index, noon, zone, limits):
    """Why the zone does not explain the jumps; "" if it does."""
    if not noon.jumps:
        return "no jump by an hour was found: nothing is to be corrected"
    if index.tz is not None and list(transitions(index, str(index.tz))):
        return (
            f"the file's times have the zone {index.tz}, which takes daylight saving "
            "out, and yet the day's light moves by an hour: the file may have kept "
            f"standard time; give its times {standard_zone(index)} instead"
        )
    due = list(transitions(index, zone))
    if not due:
        return (
            f"{zone} has no daylight saving in this record: give the location the "
            "zone of the place as its tz, such as Europe/Berlin"
        )
    if len(noon.jumps) < 2:
        return (
            "one jump alone may be a clock that was set, and is not corrected: "
            + remedy(zone)
        )
    return mismatch(noon, due, zone, limits)


def mismatch(noon, due, zone, limits):
    """Which jump is none of the zone's, or which of those lacks; "" if none."""
    left = list(due)
    for (day, by), (earliest, latest) in zip(noon.jumps, noon.within):
        near = [t for t in left if same(t, by, earliest, latest)]
        if not near:
            return (
                f"the jump by {by / 60:+.0f} min on {day.date()} is none of {zone}, "
                f"which has {said(due)}: give the location the zone whose clock the "
                "file keeps as its tz, or set its times to standard time"
            )
        left.remove(near[0])
    if missed := [t for t in left if visible(t[0], noon.days, limits)]:
        return (
            f"{zone} has {said(missed)}, and the day's light does not move then: "
            + remedy(zone)
        )
    return ""


def remedy(zone):
    return (
        f"if the file keeps the clock of {zone}, give its times that zone "
        "(tz_localize, or --tz), or else set them to standard time"
    )


def said(changes):
    return ", ".join(f"{by / 60:+.0f} min on {time.date()}" for time, by in changes)


def same(transition, by, earliest, latest):
    """Whether a jump may be this transition: days begin up to half a day off."""
    time, due = transition
    day = pd.Timedelta(days=1)
    first, last = plain(earliest) - day, plain(latest) + day
    return due == by and first <= time.normalize() <= last


def visible(time, days, limits):
    """Whether enough days on both sides of a time would have shown a jump."""
    day, side = pd.DatetimeIndex([plain(d) for d in days.index]), limits.noon_side
    at = int(day.searchsorted(time))
    if not side // 2 <= at <= len(day) - side // 2:
        return False
    around = day[max(at - side, 0) : at + side]
    return around[-1] - around[0] <= pd.Timedelta(days=limits.noon_gap)


def plain(time):
    return time.tz_localize(None)


def transitions(index, zone):
    """Times, in standard time, at which a zone's clock moves in a record. [s]"""
    ends = plain(index[0]), plain(index[-1])
    # the ends are not in universal time, which is less than a day from theirs
    day = pd.Timedelta(days=1)
    hours = pd.date_range(ends[0].floor("h") - day, ends[1] + day, freq="h", tz="UTC")
    offset = offsets(hours, zone)
    for at in np.flatnonzero(np.diff(offset)):
        time = plain(hours[at + 1]) + pd.Timedelta(seconds=float(offset.min()))
        if ends[0] < time < ends[1]:
            yield time, float(offset[at + 1] - offset[at])


def offsets(utc, zone):
    """A zone's clock less universal time. [s]"""
    local = utc.tz_convert(zone).tz_localize(None)
    return (local - utc.tz_localize(None)).total_seconds().to_numpy()


def standard_index(index, zone):
    """Wall times of a zone as standard time, and which rows have one."""
    wall = index.tz_localize(None)
    first = ~wall.duplicated()  # of an hour that comes twice, summer time is first
    local = wall.tz_localize(zone, ambiguous=first, nonexistent="NaT")
    sure = wall.tz_localize(zone, ambiguous="NaT", nonexistent="NaT").notna()
    kept = local.notna() & (sure | wall.duplicated(keep=False))
    utc = local[kept].tz_convert("UTC")
    standard = pd.Timedelta(seconds=float(offsets(utc, zone).min()))
    times = utc.tz_localize(None) + standard
    return times if index.tz is None else times.tz_localize(index.tz), kept


def standard_zone(index):
    """The fixed zone of the same standard time."""
    hours = offsets(index.tz_convert("UTC"), str(index.tz)).min() / 3600
    return f"Etc/GMT{-hours:+.0f}" if hours == round(hours) else "that of standard time"
