"""The site of a record, from its times and a few numbers."""

from typing import Any
from zoneinfo import available_timezones

import pandas as pd
from pvlib.location import Location
from pvlib.pvsystem import SingleAxisTrackerMount


def site_of(
    index: pd.DatetimeIndex,
    latitude: Any,
    longitude: Any,
    surface_tilt: Any = None,
    surface_azimuth: Any = None,
    **tracker: Any,
) -> dict:
    """
    Location and plane as arguments of the loop; None for unknown numbers.

    Of a tracker what is None is as pvlib has it; without any number there is none.
    """
    known = {name: value for name, value in tracker.items() if value is not None}
    return {
        "location": None if latitude is None else location(index, latitude, longitude),
        "surface_tilt": surface_tilt,
        "surface_azimuth": surface_azimuth,
        "mount": SingleAxisTrackerMount(**known) if known else None,
    }


def location(index: pd.DatetimeIndex, latitude: Any, longitude: Any) -> Any:
    """The location of a record, in its time zone or in local standard time."""
    tz = str(index.tz) if getattr(index, "tz", None) is not None else ""
    if not tz:
        tz = standard_zone(longitude)
    elif tz not in available_timezones():  # an offset, which is no zone
        tz = "UTC"
    return Location(latitude, longitude, tz=tz)


def in_local_days(data: Any, longitude: Any, known_zone: Any) -> pd.DataFrame:
    """UTC times in the standard time of the longitude, if the zone is not known."""
    if longitude is None or known_zone or str(data.index.tz) != "UTC":
        return data
    return data.tz_convert(standard_zone(longitude))


def standard_zone(longitude: Any) -> Any:
    """Standard time by the longitude alone."""
    return f"Etc/GMT{-round(longitude / 15):+d}"  # this zone's sign is reversed
