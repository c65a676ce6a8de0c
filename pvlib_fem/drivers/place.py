"""Where a record is from, of what its file and a few numbers say."""

from zoneinfo import available_timezones

from pvlib.location import Location


def site_of(index, latitude, longitude, surface_tilt, surface_azimuth):
    """The place as the loop takes it; None stands for what nobody told."""
    return {
        "location": None if latitude is None else location(index, latitude, longitude),
        "surface_tilt": surface_tilt,
        "surface_azimuth": surface_azimuth,
    }


def location(index, latitude, longitude):
    """Where the record is from, in its zone or in local standard time."""
    tz = str(index.tz) if getattr(index, "tz", None) is not None else ""
    if not tz:
        tz = standard_zone(longitude)
    elif tz not in available_timezones():  # an offset, which is no zone
        tz = "UTC"
    return Location(latitude, longitude, tz=tz)


def in_local_days(data, longitude, told):
    """Instants in UTC, of which nobody told the zone, with the days of their place."""
    if longitude is None or told or str(data.index.tz) != "UTC":
        return data
    return data.tz_convert(standard_zone(longitude))


def standard_zone(longitude):
    """Standard time by the longitude alone."""
    return f"Etc/GMT{-round(longitude / 15):+d}"  # this zone's sign is reversed
