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

    Parameters
    ----------
    index : DatetimeIndex
        Times of the record; its zone becomes that of the location.
    latitude, longitude : float or None
        North and east are positive; there is no location without a latitude. [°]
    surface_tilt, surface_azimuth : float, optional
        Angles of a fixed plane. [°]
    **tracker : float or None
        Numbers of :class:`pvlib.pvsystem.SingleAxisTrackerMount` by name.

    Returns
    -------
    dict
        ``location``, ``surface_tilt``, ``surface_azimuth`` and ``mount``.
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
    """
    UTC times in the standard time of the longitude, if the zone is not known.

    Parameters
    ----------
    data : DataFrame
    longitude : float or None
        East is positive. [°]
    known_zone : str or None
        The zone of the times, where the user gives it.

    Returns
    -------
    DataFrame
        With times in another zone, or unchanged.
    """
    if longitude is None or known_zone or str(data.index.tz) != "UTC":
        return data
    return data.tz_convert(standard_zone(longitude))


def standard_zone(longitude: Any) -> Any:
    """Standard time by the longitude alone."""
    return f"Etc/GMT{-round(longitude / 15):+d}"  # this zone's sign is reversed
