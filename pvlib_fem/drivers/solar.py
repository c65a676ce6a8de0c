"""The place of the sun, and its light on a plane."""

from numbers import Real

import numpy as np
import pandas as pd
from pvlib import irradiance
from pvlib.location import Location

from pvlib_fem.drivers.memory import HOUR, backwards
from pvlib_fem.record.columns import GEOMETRY
from pvlib_fem.relaxation import relax

SOLAR_CONSTANT = 1361.0  # W/m²
HALVINGS = 12  # of the range of the clearness: to 1/4096
ALBEDO = 0.2  # of ground of which nothing is known
AROUND = 2.0 * HOUR  # over which the sky before and after is looked at
SUN_GRID = "5min"  # over which the sun moves as good as straight


def sun(index: pd.DatetimeIndex, location: Location) -> pd.DataFrame:
    """
    Place of the sun at each time, quickly: a year of minutes in 0.2 s.

    pvlib's ephemeris every five minutes, and straight between as a unit vector;
    within 0.02° of pvlib's default algorithm.

    Parameters
    ----------
    index : DatetimeIndex
        With a zone, or without one in local standard time: that of
        ``location.tz``, and where this is UTC, pvlib's default, that of the
        longitude, a whole hour every 15°.
    location : pvlib.location.Location

    Returns
    -------
    DataFrame
        ``solar_zenith`` without refraction and ``solar_azimuth``, on ``index``.
        [°]
    """
    times = index if index.tz is not None else standard_time(index, location)
    utc = times.tz_convert("UTC")
    grid = pd.date_range(
        utc.min().floor(SUN_GRID), utc.max().ceil(SUN_GRID), freq=SUN_GRID
    )
    if len(grid) > len(utc):  # few rows over a long time
        grid = utc
    found = location.get_solarposition(grid, method="ephemeris")
    if len(grid) == len(utc) and (grid == utc).all():  # no time is between two of it
        places = {f"solar_{n}": found[n].to_numpy() for n in ("zenith", "azimuth")}
        return pd.DataFrame(places, index=index)
    zenith, azimuth = np.radians(found["zenith"]), np.radians(found["azimuth"])
    at, knots = (t.as_unit("ns").asi8.astype(float) for t in (utc, grid))
    north, east, up = (
        np.interp(at, knots, part.to_numpy())
        for part in (
            np.sin(zenith) * np.cos(azimuth),
            np.sin(zenith) * np.sin(azimuth),
            np.cos(zenith),
        )
    )
    return pd.DataFrame(
        {
            "solar_zenith": np.degrees(np.arctan2(np.hypot(north, east), up)),
            "solar_azimuth": np.degrees(np.arctan2(east, north)) % 360.0,
        },
        index=index,
    )


def standard_time(index, location):
    """Times without a zone as the local standard time of a location."""
    offset = pd.Timedelta(hours=round(location.longitude / 15.0))
    if str(location.tz) != "UTC":
        january = pd.Timestamp(index[0].year, 1, 1, tz=location.tz)
        offset = january.utcoffset() - january.dst()
    return (index - offset).tz_localize("UTC")


def checked_place(location, surface_tilt, surface_azimuth):
    """The arguments of a place as a dict, refused by name where they are no place."""
    if location is not None and not isinstance(location, Location):
        example = ", ".join(map(str, np.ravel(location))) if np.ndim(location) else "…"
        raise ValueError(
            f"location is {location!r}; give pvlib.location.Location({example}), with "
            "tz= where the times have no zone"
        )
    angles = {"surface_tilt": surface_tilt, "surface_azimuth": surface_azimuth}
    for name, value in angles.items():
        if value is None:
            continue
        if not isinstance(value, Real) or not np.isfinite(value):
            what = repr(value) if np.ndim(value) == 0 else f"a {type(value).__name__}"
            raise ValueError(
                f"{name} is {what}; give one number of degrees, or leave it out"
            )
    return {"location": location, **angles}


def geometry(index, location=None, surface_tilt=None, surface_azimuth=None):
    """Columns of the sun's and the module's place, as far as they are known."""
    columns = {}
    if location is not None:
        columns |= dict(sun(index, location))
    for name, value in zip(GEOMETRY[2:], (surface_tilt, surface_azimuth)):
        if value is not None:
            # one number, in the memory of one
            everywhere = np.broadcast_to(float(value), len(index))
            columns[name] = pd.Series(everywhere, index, copy=False)
    return columns


def aoi_projection(solar_zenith, solar_azimuth, surface_tilt, surface_azimuth, inputs):
    """Cosine of the angle of incidence, negative behind the module. [-]"""
    plane = surface_tilt, surface_azimuth
    return irradiance.aoi_projection(*plane, solar_zenith, solar_azimuth)


def diffuse_share(clearness):
    """
    Share of diffuse in global irradiance, by clearness [1]_. [-]

    References
    ----------
    .. [1] D. G. Erbs, S. A. Klein and J. A. Duffie, Solar Energy 28, 293 (1982),
       :doi:`10.1016/0038-092X(82)90302-4`, as in :func:`pvlib.irradiance.erbs`.
    """
    # of a sun overhead the irradiance is the clearness
    above = irradiance.get_extra_radiation(1)
    ghi = np.maximum(clearness, 1e-9) * above
    return irradiance.erbs(ghi, np.zeros_like(ghi), 1)["dhi"] / ghi


#: the same on all that the halvings of the clearness come to
DIFFUSE = diffuse_share(np.linspace(0.0, 1.0, 2**HALVINGS + 1))


def clearness(poa_global, solar_zenith, surface_tilt, aoi_projection, inputs):
    """
    Share of the sunlight above the air that arrives, 0 at night. [-]

    That of which a beam by :func:`diffuse_share`, an isotropic sky and the ground
    make the measured irradiance in the plane.
    """
    up = np.cos(np.radians(solar_zenith))
    found = 0.0 * (poa_global + up + aoi_projection)  # keeps what is unknown so
    by_day = np.flatnonzero((up > 0) & (poa_global > 0) & np.isfinite(found))
    measured = poa_global[by_day] / SOLAR_CONSTANT
    beam = np.maximum(aoi_projection[by_day], 0.0)
    view = (1.0 + np.cos(np.radians(surface_tilt))) / 2.0  # of the sky
    sky, ground = (up * view)[by_day], (ALBEDO * up * (1.0 - view))[by_day]
    low, width = np.zeros(len(by_day)), 1.0
    for _ in range(HALVINGS):
        width = width / 2.0
        middle = low + width
        diffuse = DIFFUSE[(middle * (len(DIFFUSE) - 1)).astype(int)]
        light = middle * (beam + diffuse * (sky - beam) + ground)
        low += width * (light < measured)
    found[by_day] = low + width / 2.0
    return found


def beam(poa_global, clearness, aoi_projection, inputs):
    """Beam irradiance in the plane of the module, by :func:`clearness`. [W/m²]"""
    direct = clearness * (1.0 - diffuse_share(clearness)) * SOLAR_CONSTANT
    return np.minimum(direct * np.maximum(aoi_projection, 0.0), poa_global)


def sun_north(solar_azimuth, inputs):
    """How far in the north the sun stands, of its place around. [-]"""
    return np.cos(np.radians(solar_azimuth))


def sun_east(solar_azimuth, inputs):
    """The same in the east. [-]"""
    return np.sin(np.radians(solar_azimuth))


def beam_clear(solar_zenith, aoi_projection, inputs):
    """
    Beam in the plane under a clear sky [1]_. [W/m²]

    References
    ----------
    .. [1] ASHRAE Handbook of Fundamentals, clear-day beam A·exp(-B/sin h), with
       the means of the months, 1160 W/m² and 0.175.
    """
    up = np.cos(np.radians(solar_zenith))
    clear = np.where(up > 0, 1160.0 * np.exp(-0.175 / np.maximum(up, 0.02)), 0.0)
    return clear * np.maximum(aoi_projection, 0.0)


def beam_around(beam, beam_clear, elapsed, inputs=None, seen=1.0):
    """
    Beam in the plane as the hours around let expect it. [W/m²]

    That of the clear sky times the share of it that was there before and after,
    where it was ``seen``: what an irradiance sensor in the shade does not see.
    """
    steps = np.diff(elapsed, prepend=elapsed[:1])
    there, whole = (
        relax(column, steps, AROUND) + backwards(column, steps, AROUND)
        for column in (beam * seen, beam_clear * seen + 0.0 * beam)
    )
    return beam_clear * np.minimum(there / np.maximum(whole, 1.0), 1.0)


def ghi_estimated(clearness, solar_zenith, inputs):
    """Global horizontal irradiance, by :func:`clearness`. [W/m²]"""
    up = np.maximum(np.cos(np.radians(solar_zenith)), 0.0)
    return SOLAR_CONSTANT * clearness * up


def beam_by_tilt(
    beam,
    aoi_projection,
    solar_zenith,
    solar_azimuth,
    surface_tilt,
    surface_azimuth,
    inputs,
):
    """What a plane steeper by a degree would see more of the beam. [W/(m² °)]"""
    zenith, tilt = np.radians(solar_zenith), np.radians(surface_tilt)
    around = np.radians(solar_azimuth - surface_azimuth)
    slope = np.sin(zenith) * np.cos(tilt) * np.cos(around)
    slope = slope - np.cos(zenith) * np.sin(tilt)
    return beam * np.radians(slope) / np.maximum(aoi_projection, 0.1)


def beam_by_azimuth(
    beam,
    aoi_projection,
    solar_zenith,
    solar_azimuth,
    surface_tilt,
    surface_azimuth,
    inputs,
):
    """What a plane turned clockwise by a degree would see more. [W/(m² °)]"""
    around = np.radians(solar_azimuth - surface_azimuth)
    slope = np.sin(np.radians(solar_zenith)) * np.sin(np.radians(surface_tilt))
    slope = slope * np.sin(around)
    return beam * np.radians(slope) / np.maximum(aoi_projection, 0.1)
