"""Is the whole file late? The middle of each day's light against the sun's."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
import pvlib

from pvlib_fem.drivers import standard_time
from pvlib_fem.quality.clock import HOUR, day_of, hours_of, offsets
from pvlib_fem.quality.limits import Limits
from pvlib_fem.quality.onset import DAY, night
from pvlib_fem.record.checks import instants


@dataclass(frozen=True, eq=False)
class SolarNoon:
    """How late a whole file is by the sun, from :func:`solar_noon_shift`."""

    late: float  # outside daylight saving; NaN without a location [s]
    days: pd.Series  # by the day: the middle of its light, less what is due [s]
    jumps: tuple  # (first day after it, seconds)
    faults: dict  # name: one line
    why: str = ""  # what was not looked for


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
    the noon of its energy by 20 min, but the edges of its light hardly.
    """
    limits = limits or Limits()
    times = instants(index)
    seconds = (times - times[0]) / np.timedelta64(1, "s")
    if len(seconds) < 2 or seconds[-1] < limits.shortest_record:
        return SolarNoon(np.nan, pd.Series(dtype=float), (), {})
    step, dark = np.median(np.diff(seconds)), night(seconds, poa_global)
    day, middle = middles(seconds - dark, np.asarray(poa_global), step, limits)
    if location is not None:
        origin = universal(index[0], location) + pd.Timedelta(seconds=dark)
        late = middle - due(
            origin, day, location, surface_tilt, surface_azimuth, limits
        )
        middle = (late + DAY / 2) % DAY - DAY / 2
    when = dark + (day + 0.5) * DAY
    changes = steps_of_an_hour(day, middle, limits)
    for change in changes:
        change["seconds"] = dark + change["day"] * DAY
    blocks = [dict(seconds=t, late=late) for t, late in zip(when, middle)]
    hours = hours_of(blocks, changes)
    late = np.nan
    if location is not None and len(day):
        late = float(np.median(middle - offsets(hours, when)))
    jumps = tuple((day_of(index[0], c["seconds"]), c["by"]) for c in changes)
    days = pd.Series(middle, [day_of(index[0], t - DAY / 2) for t in when])
    return SolarNoon(late, days, jumps, noon_faults(late, jumps, step, limits))


def noon_faults(late, jumps, step, limits):
    faults = {}
    if abs(late) > limits.off_noon + step / 2:
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


def middles(seconds, poa, step, limits):
    """Days that are whole, and the middle of the light of each. [s of its day]"""
    if not len(lit := np.flatnonzero(poa > limits.light)):
        return np.zeros(0, dtype=int), np.zeros(0)
    day = (seconds // DAY).astype(int)
    rows = np.bincount(day, np.isfinite(poa))
    of_lit, first = np.unique(day[lit], return_index=True)
    last = np.append(first[1:], len(lit)) - 1
    highest = np.maximum.reduceat(poa[lit], first)
    # what is lost of a day may be its first or last light
    whole = (highest > limits.bright) & (rows[of_lit] > limits.whole_day * DAY / step)
    middle = (seconds[lit[first]] + seconds[lit[last]]) / 2 - of_lit * DAY
    return of_lit[whole], middle[whole]


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
    found, side = [], limits.noon_side
    for i in range(side // 2, len(day) - side // 2 + 1):
        sides = middle[max(i - side, 0) : i], middle[i : i + side]
        if day[min(i + side, len(day)) - 1] - day[max(i - side, 0)] > 4 * side:
            continue
        centres = [np.median(part) for part in sides]
        by = centres[1] - centres[0]
        if abs(abs(by) - HOUR) >= limits.noon_slack:
            continue
        rough = sum(np.abs(part - c).mean() for part, c in zip(sides, centres))
        found.append(dict(day=int(day[i]), by=float(np.sign(by) * HOUR), rough=rough))
    # neighbours see the same step; it is where both sides are the most even
    groups = []
    for step in found:
        if groups and step["day"] - groups[-1][-1]["day"] <= side:
            groups[-1].append(step)
        else:
            groups.append([step])
    return [min(group, key=lambda step: step["rough"]) for group in groups]
