"""In which zone a clock may be, by the hours that it shows twice and by the sun."""

from datetime import timedelta
from typing import Any

import numpy as np
import pandas as pd

#: zones of different summer times, the most usual first of those of one rule
SUMMER = (
    "Europe/Berlin",
    "Europe/London",
    "Europe/Athens",
    "America/New_York",
    "America/Chicago",
    "America/Denver",
    "America/Los_Angeles",
    "America/Halifax",
    "America/Santiago",
    "Australia/Sydney",
    "Australia/Adelaide",
    "Pacific/Auckland",
)
OFF = 1.5  # hours by which noon may be off before the clock is not local


def zone_of(
    index: Any, longitude: float | None, irradiance: np.ndarray | None, doubts: list
) -> str | None:
    """
    The zone of times without one, where they show it.

    Parameters
    ----------
    index : DatetimeIndex
        In the order of the file.
    longitude : float or None
        Of the site. [°]
    irradiance : array or None
        [W/m²]
    doubts : list of str
        Takes what a person should look at.

    Returns
    -------
    str or None
    """
    index = index.tz_localize(None)
    if zones := of_summer_time(index):
        zone = zones[0]
        if longitude is not None:
            zone = min(
                zones, key=lambda name: abs(standard_offset(name) - longitude / 15)
            )
        elif len(zones) > 1:
            doubts.append(
                f"an hour comes twice, as in the zone {zone}, and as in "
                f"{', '.join(zones[1:4])}: give that of the site"
            )
        return zone
    noon = noon_of(index, irradiance)
    if noon is None:
        return None
    if longitude is None:
        if abs(noon - 12.5) > OFF + 0.5:
            hour = f"{int(noon):02d}:{int(noon % 1 * 60):02d}"
            doubts.append(
                f"the irradiance is highest around {hour}, so the times are not local: "
                "give --tz UTC if they are in UTC, or the zone that they are in"
            )
        return None
    if abs(noon - 12.0) <= OFF:
        return None  # local standard time, which is what is taken without a zone
    ahead = round(noon - 12.0 + longitude / 15.0)  # of the clock, before UTC
    ahead += 24 * (ahead < -12) - 24 * (ahead > 14)  # zones end there
    return "UTC" if ahead == 0 else f"Etc/GMT{-ahead:+d}"


def zone_of_offsets(clock: Any, instants: Any) -> str | None:
    """
    The zone of a clock that changes its distance from UTC.

    Parameters
    ----------
    clock : DatetimeIndex, shape (rows,)
        What it showed, without a zone.
    instants : DatetimeIndex, shape (rows,)
        When that was, with any zone.

    Returns
    -------
    str or None
        None where the distance is always equal, or is of no zone of :data:`SUMMER`.
    """
    if (clock - instants.tz_convert(None)).nunique() < 2:
        return None
    for zone in SUMMER:
        if (instants.tz_convert(zone).tz_localize(None) == clock).all():
            return zone
    return None


def of_summer_time(index: Any) -> list[str]:
    """Zones in which the clock goes back at the times at which this one does."""
    steps = np.diff(index.to_numpy()) / np.timedelta64(1, "h")
    usual = np.median(steps[steps > 0]) if (steps > 0).any() else 0.0
    back = np.flatnonzero((steps < 0) & (np.abs(steps - usual + 1.0) < 0.51))
    if not len(back) or (steps <= 0).sum() > len(back):
        return []
    return [zone for zone in SUMMER if all(goes_back(index[i], zone) for i in back)]


def goes_back(time: Any, zone: Any) -> bool:
    """Whether the clock of a zone goes back within the hour around a time."""
    before, after = time - timedelta(hours=2), time + timedelta(hours=2)
    if pd.isna(time):
        return False
    local = pd.DatetimeIndex([before, time, after]).tz_localize(
        zone, ambiguous=np.ones(3, dtype=bool), nonexistent="shift_forward"
    )
    twice = pd.DatetimeIndex([time]).tz_localize(
        zone, ambiguous="NaT", nonexistent="shift_forward"
    )
    ahead = [one.utcoffset() or timedelta() for one in local]
    return bool(twice.isna()[0]) and ahead[0] > ahead[2]


def standard_offset(zone: Any) -> float:
    """
    Hours by which a zone's standard time is before UTC.

    Parameters
    ----------
    zone : str or tzinfo

    Returns
    -------
    float
        Positive east of Greenwich. [h]
    """
    year = pd.DatetimeIndex(["2024-01-01", "2024-07-01"]).tz_localize(zone)
    offsets = [time.utcoffset() or timedelta() for time in year]
    return min(offsets).total_seconds() / 3600.0


def noon_of(index: pd.DatetimeIndex, irradiance: np.ndarray | None) -> float | None:
    """The hour around which the irradiance lies, or None where it does not tell."""
    if irradiance is None or len(index) < 100:
        return None
    seen = np.isfinite(irradiance) & (irradiance > 0) & np.asarray(index.notna())
    weight = np.where(seen, irradiance, 0.0)
    if not weight.sum() > 0:
        return None
    hour = np.nan_to_num(np.asarray(index.hour + index.minute / 60.0, dtype=float))
    turn = np.exp(2j * np.pi * hour / 24.0) @ weight / weight.sum()
    if abs(turn) < 0.3:
        return None
    return float(np.angle(turn) * 24.0 / (2 * np.pi) % 24.0)
