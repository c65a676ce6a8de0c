"""Zones by the dates on which their clocks move."""

from collections.abc import Iterator
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any
from zoneinfo import TZPATH

import numpy as np
import pandas as pd
from pvlib.location import Location

TABLE = "zone1970.tab"  # of the tz database: a zone's own place, among others


def transitions(
    index: pd.DatetimeIndex, zone: str
) -> Iterator[tuple[pd.Timestamp, float]]:
    """
    Times, in standard time, at which a zone's clock moves in a record.

    Parameters
    ----------
    index : pandas.DatetimeIndex, shape (rows,)
        Times of the record; of a zone of their own the wall times count.
    zone : str
        Name in the tz database.

    Yields
    ------
    tuple of pandas.Timestamp and float
        Standard time of the zone, without one, and by how much its clock moves
        then, positive forward. [s]
    """
    ends = wall_time(index[0]), wall_time(index[-1])
    # the ends are not in universal time, which is less than a day from theirs
    day = pd.Timedelta(days=1)
    days = pd.date_range(
        ends[0].floor("D") - day, ends[1] + 2 * day, freq="D", tz="UTC"
    )
    offset = zone_offsets(days, zone)
    for at in np.flatnonzero(np.diff(offset)).tolist():
        hours = days[at] + pd.to_timedelta(np.arange(25), unit="h")
        hour = int(np.argmax(zone_offsets(hours, zone) != offset[at]))
        time = wall_time(hours[hour]) + pd.Timedelta(seconds=float(offset.min()))
        if ends[0] < time < ends[1]:
            yield time, float(offset[at + 1] - offset[at])


def zone_offsets(utc: pd.DatetimeIndex, zone: str) -> np.ndarray:
    """
    Clock of a zone less universal time.

    Parameters
    ----------
    utc : pandas.DatetimeIndex, shape (times,)
        In UTC.
    zone : str
        Name in the tz database.

    Returns
    -------
    numpy.ndarray, shape (times,)
        Positive east of Greenwich. [s]
    """
    local = utc.tz_convert(zone).tz_localize(None)
    return (local - utc.tz_localize(None)).total_seconds().to_numpy()


def wall_time(time: Any) -> Any:
    """
    Wall time without its zone.

    Parameters
    ----------
    time : pandas.Timestamp or pandas.DatetimeIndex
        With a zone or without.

    Returns
    -------
    pandas.Timestamp or pandas.DatetimeIndex
        Of the same kind and shape.
    """
    return time.tz_localize(None)


def zones_around(
    location: Location, time: pd.Timestamp, offset: float | pd.Index
) -> Iterator[str]:
    """
    Zones of a standard time that move their clocks, the nearest place first.

    Parameters
    ----------
    location : pvlib.location.Location
        From which distances are taken.
    time : pandas.Timestamp
        In the year whose clocks count.
    offset : float
        Standard time less universal time. [s]

    Yields
    ------
    str
        Name in the tz database.
    """
    year = pd.date_range(f"{time.year}-01-01", periods=12, freq="MS", tz="UTC")
    near = sorted(
        zone_places().items(), key=lambda item: angular_distance(location, item[1])
    )
    for zone, _ in near:
        moves = zone_offsets(year, zone)
        if moves.min() == offset < moves.max():
            yield zone


@cache
def zone_places() -> dict[str, tuple[float, float]]:
    """Latitude and longitude of each zone's own place, in degrees."""
    coordinates = {}
    for line in zone_table().splitlines():
        if line and not line.startswith("#"):
            _, place, zone = line.split("\t")[:3]
            cut = max(place.rfind("+"), place.rfind("-"))
            coordinates[zone] = degrees(place[:cut], 2), degrees(place[cut:], 3)
    return coordinates


def zone_table() -> str:
    """The table of places, of the system or of the package tzdata; or none."""
    for folder in TZPATH:
        if (path := Path(folder) / TABLE).is_file():
            return path.read_text(encoding="utf-8")
    try:
        return (files("tzdata.zoneinfo") / TABLE).read_text(encoding="utf-8")
    except (ModuleNotFoundError, FileNotFoundError):
        return ""


def degrees(text: str, whole: int) -> float:
    """±DDMM or ±DDDMMSS as degrees."""
    sign, digits = (-1 if text[0] == "-" else 1), text[1:]
    minutes = float(digits[whole : whole + 2]) + float(digits[whole + 2 :] or 0) / 60
    return sign * (float(digits[:whole]) + minutes / 60)


def angular_distance(location: Location, place: tuple) -> float:
    """Of two places, in radians."""
    (a, b), (c, d) = np.radians([(location.latitude, location.longitude), place])
    cosine = np.sin(a) * np.sin(c) + np.cos(a) * np.cos(c) * np.cos(b - d)
    return np.arccos(np.clip(cosine, -1.0, 1.0))
