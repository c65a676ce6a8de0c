"""Is the whole file late? The middle of each day's light against the sun's."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
import pvlib

from pvlib_fem.drivers import standard_time
from pvlib_fem.quality.clock import HOUR, day_of, hours_of, offsets
from pvlib_fem.quality.limits import Limits
from pvlib_fem.quality.onset import DAY, night
from pvlib_fem.record.checks import instants, usual_step


@dataclass(frozen=True, eq=False)
class SolarNoon:
    """How late a whole file is by the sun, from :func:`solar_noon_shift`."""

    late: float  # outside daylight saving; NaN without a location [s]
    days: pd.Series  # by the day: the middle of its light, less what is due [s]
    jumps: tuple  # (first day after it, seconds)
    faults: dict  # name: one line
    why: str = ""  # what was not looked for
    within: tuple = ()  # (earliest, latest) day of each jump


def solar_noon_shift(
    poa_global,
    index,
    location=None,
    surface_tilt=None,
    surface_azimuth=None,
    limits=None,
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
    limits : Limits, optional

    Returns
    -------
    SolarNoon
        ``faults`` may have ``file_dst``, for jumps by 60 ± 15 min from the ten days
        before to the ten after, and ``file_shift``, for more than half an hour.

    Notes
    -----
    The middle between first and last light, 20 W/m², needs no clear sky: clouds
    move either end by some minutes and both alike. A plane turned by 5° moves
    the noon of its energy by 20 min, but the edges of its light hardly. An edge is
    taken between two rows, so that it does not move by whole steps; where rows are
    further apart than an hour that is too coarse to look for jumps, and ``why``
    says so.
    """
    limits = limits or Limits()
    times = instants(index)
    seconds = (times - times[0]) / np.timedelta64(1, "s")
    if len(seconds) < 2 or seconds[-1] < limits.shortest_record:
        return SolarNoon(np.nan, pd.Series(dtype=float), (), {})
    step, dark = usual_step(index), night(seconds, poa_global)
    day, middle = middles(seconds - dark, np.asarray(poa_global), step, limits)
    if location is not None:
        origin = universal(index[0], location) + pd.Timedelta(seconds=dark)
        late = middle - due(
            origin, day, location, surface_tilt, surface_azimuth, limits
        )
        middle = (late + DAY / 2) % DAY - DAY / 2
    when = dark + (day + 0.5) * DAY
    why, changes = "", []
    if step <= limits.coarsest_noon:
        changes = steps_of_an_hour(day, middle, limits)
    else:
        why = (
            f"no jump of the whole file by an hour was looked for: rows are "
            f"{step / 60:.0f} min apart"
        )
    for change in changes:
        change["seconds"] = dark + change["day"] * DAY
    blocks = [dict(seconds=t, late=late) for t, late in zip(when, middle)]
    hours = hours_of(blocks, changes)
    late = np.nan
    if location is not None and len(day):
        late = float(np.median(middle - offsets(hours, when)))
    jumps = tuple((day_of(index[0], c["seconds"]), c["by"]) for c in changes)
    days = pd.Series(middle, [day_of(index[0], t - DAY / 2) for t in when])
    within = tuple(
        tuple(day_of(index[0], dark + d * DAY) for d in c["within"]) for c in changes
    )
    faults = noon_faults(late, jumps, step, limits)
    return SolarNoon(late, days, jumps, faults, why, within)


def noon_faults(late, jumps, step, limits):
    faults = {}
    if abs(late) > limits.off_noon + step / 2:
        faults["file_shift"] = (
            f"the clock of the file is off: the day's light comes and goes "
            f"{abs(late) / 60:.0f} min too {'late' if late > 0 else 'early'} for the "
            "location, so the times are in another zone than they say, or longitude "
            "has the wrong sign (times without a zone are read as standard time in the "
            "location's tz, or by its longitude where that is UTC)"
        )
    if jumps:
        dates = ", ".join(f"{by / 60:+.0f} min on {day.date()}" for day, by in jumps)
        why = "the file keeps daylight-saving time"
        if len(jumps) == 1:
            why += ", or its clock was set"
        faults["file_dst"] = (
            f"the day's light moves by {dates}: {why}; give its times that zone "
            "(tz_localize, or --tz), or keep standard time"
        )
    return faults


def middles(seconds, poa, step, limits):
    """Days that are whole, and the middle of the light of each. [s of its day]"""
    if not len(lit := np.flatnonzero(poa > limits.light)):
        return np.zeros(0, dtype=int), np.zeros(0)
    day = (seconds // DAY).astype(int)
    rows = np.bincount(day, np.isfinite(poa))
    of_lit, first = np.unique(day[lit], return_index=True)
    last = np.append(first[1:], len(lit)) - 1
    highest = np.maximum.reduceat(poa[lit], first)
    rise, fall = (
        edge(seconds, poa, lit[at], way, limits) for at, way in ((first, -1), (last, 1))
    )
    # what is lost of a day may be its first or last light
    whole = (highest > limits.bright) & (rows[of_lit] > limits.whole_day * DAY / step)
    whole &= DAY - (fall - rise) > limits.shortest_night  # False where one is NaN
    return of_lit[whole], ((rise + fall) / 2 - of_lit * DAY)[whole]


def edge(seconds, poa, lit, way, limits):
    """When light begins or ends, between a lit row and the dark one beside it. [s]"""
    dark = np.clip(lit + way, 0, len(poa) - 1)
    change, rest = poa[lit] - poa[dark], poa[lit] - limits.light
    there = poa[dark] <= limits.light  # no edge in a polar day, nor beside a gap
    part = np.divide(rest, change, out=np.full(len(lit), np.nan), where=there)
    return seconds[lit] + part * (seconds[dark] - seconds[lit])


def universal(time, location):
    """A time in UTC; without a zone, it is standard time at the location."""
    if time.tz is not None:
        return time.tz_convert("UTC").tz_localize(None)
    return standard_time(pd.DatetimeIndex([time]), location)[0].tz_localize(None)


def due(origin, days, location, surface_tilt, surface_azimuth, limits):
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
    day, middle = middles(seconds, poa, 300.0, limits)
    if not len(day):
        return np.full(len(days), np.nan)
    return np.interp(days, day, middle + 300.0 * dark)


def steps_of_an_hour(day, middle, limits):
    """Days at which the middle of the light moves by an hour for good."""
    fewest = max(limits.noon_side // 2, 1)
    tried = range(fewest, len(day) - fewest + 1)
    found = filter(None, (step_at(i, day, middle, limits) for i in tried))
    # neighbours see the same step; it is where both sides are the most even
    groups = []
    for step in found:
        if groups and step["day"] - groups[-1][-1]["day"] <= limits.noon_side:
            groups[-1].append(step)
        else:
            groups.append([step])
    return [evenest(group, limits) for group in groups]


def step_at(i, day, middle, limits):
    """A step of an hour before the i-th day, or None."""
    first, last = max(i - limits.noon_side, 0), i + limits.noon_side
    sides = middle[first:i], middle[i:last]
    around = day[first:last]
    before, after = (np.median(side) for side in sides)
    if around[-1] - around[0] > limits.noon_gap:
        return None
    if abs(abs(after - before) - HOUR) >= limits.noon_slack:
        return None
    rough = np.array([np.abs(s - c).mean() for s, c in zip(sides, (before, after))])
    # of medians of normal deviates: π/2 of a mean deviation over the root of n
    error = np.pi / 2 * np.hypot(*(rough / np.sqrt([len(side) for side in sides])))
    if abs(after - before) < limits.sure * error:
        return None
    by = float(np.sign(after - before) * HOUR)
    return dict(day=int(day[i]), before=int(day[i - 1]), by=by, rough=rough.sum())


def evenest(group, limits):
    """The step with the most even sides, and the days that it may be on."""
    best = min(group, key=lambda step: step["rough"])
    # where noise has exponential tails, e times less likely for each mean deviation
    scale = max(best["rough"] / 2, limits.noon_error) / limits.noon_side
    near = [s for s in group if s["rough"] - best["rough"] <= limits.sure * scale]
    return best | dict(within=(near[0]["before"] + 1, near[-1]["day"]))
