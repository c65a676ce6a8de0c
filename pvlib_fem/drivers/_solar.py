"""The solar position, and irradiance on a plane."""

from typing import Any

import numpy as np
import pandas as pd
from pvlib import irradiance
from pvlib.location import Location

from pvlib_fem._record.inputs import Inputs
from pvlib_fem._relaxation import relax
from pvlib_fem.drivers._lagged_inputs import HOUR, backwards

SOLAR_CONSTANT = 1361.0  # W/m²
HALVINGS = 12  # bisections of the clearness: to 1/4096
ALBEDO = 0.2  # of unknown ground
AROUND = 2.0 * HOUR  # time constant of the mean sky before and after
SUN_GRID = "5min"  # step over which the sun's path is almost straight


def sun(
    index: pd.DatetimeIndex, location: Location, refraction: bool = False
) -> pd.DataFrame:
    """
    Solar position at each time; a year of minutes takes 0.2 s.

    pvlib's ephemeris is computed every five minutes and interpolated as a unit vector.
    The result is within 0.02° of pvlib's default algorithm; with refraction, within
    0.1° of it above the horizon and 0.6° below.

    Parameters
    ----------
    index : DatetimeIndex
        Times. Times without a zone are in the standard time of ``location.tz``, in
        Ireland in winter time; if that is UTC, pvlib's default, in the standard time of
        the longitude, a whole hour every 15°.
    location : pvlib.location.Location
    refraction : bool, default False
        Give the apparent zenith, which trackers follow.

    Returns
    -------
    DataFrame
        ``solar_zenith``, without refraction by default, and ``solar_azimuth``, on
        ``index``. [°]

    Raises
    ------
    TypeError
        If ``index`` is no DatetimeIndex.
    ValueError
        If it is empty or has no time (NaT) in a row.
    """
    if not isinstance(index, pd.DatetimeIndex):
        raise TypeError(
            f"index is a {type(index).__name__}; give the times as a DatetimeIndex"
        )
    if index.empty:
        raise ValueError("index is empty; give at least one time")
    if index.hasnans:
        at = int(np.argmax(index.isna()))
        raise ValueError(f"index has no time (NaT) at row {at}; drop such rows")
    times = index if index.tz is not None else standard_time(index, location)
    utc = times.tz_convert("UTC")
    grid = pd.date_range(
        utc.min().floor(SUN_GRID), utc.max().ceil(SUN_GRID), freq=SUN_GRID
    )
    if len(grid) > len(utc):  # few rows over a long time
        grid = utc
    positions = location.get_solarposition(grid, method="ephemeris")
    if refraction:
        positions["zenith"] = positions["apparent_zenith"]
    if len(grid) == len(utc) and (grid == utc).all():  # no interpolation
        places = {f"solar_{n}": positions[n].to_numpy() for n in ("zenith", "azimuth")}
        return pd.DataFrame(places, index=index)
    zenith, azimuth = np.radians(positions["zenith"]), np.radians(positions["azimuth"])
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


def standard_time(index: pd.DatetimeIndex, location: Location) -> pd.DatetimeIndex:
    """
    Times without a zone as the local standard time of a location.

    Parameters
    ----------
    index : DatetimeIndex
        Without a zone, at least one.
    location : pvlib.location.Location
        If its zone is UTC, pvlib's default, the standard time is that of the longitude.

    Returns
    -------
    DatetimeIndex
        In UTC.
    """
    offset = pd.Timedelta(hours=round(location.longitude / 15.0))
    if str(location.tz) != "UTC":
        january: Any = pd.Timestamp(index[0].year, 1, 1, tz=location.tz)
        # Irish winter time is, by law, an hour less than the standard time; a logger
        # that ignores summer time keeps it
        offset = january.utcoffset() - max(january.dst(), pd.Timedelta(0))
    return (index - offset).tz_localize("UTC")


def aoi_projection(
    solar_zenith: np.ndarray,
    solar_azimuth: np.ndarray,
    surface_tilt: np.ndarray,
    surface_azimuth: np.ndarray,
    inputs: Inputs,
) -> np.ndarray:
    """
    Cosine of the angle of incidence, negative behind the module. [-]

    Parameters
    ----------
    solar_zenith, solar_azimuth : array, shape (rows,)
        Position of the sun, azimuth clockwise from north. [°]
    surface_tilt, surface_azimuth : array, shape (rows,)
        Angles of the plane, azimuth clockwise from north. [°]
    inputs : Inputs
        Not used.

    Returns
    -------
    array, shape (rows,)
    """
    plane = surface_tilt, surface_azimuth
    return irradiance.aoi_projection(*plane, solar_zenith, solar_azimuth)


def diffuse_share(clearness: np.ndarray) -> np.ndarray:
    """
    Diffuse fraction of global irradiance, by clearness [1]_. [-]

    References
    ----------
    .. [1] D. G. Erbs, S. A. Klein and J. A. Duffie, Solar Energy 28, 293 (1982),
       :doi:`10.1016/0038-092X(82)90302-4`, as in :func:`pvlib.irradiance.erbs`.
    """
    # with the sun overhead, the ratio of irradiances is the clearness
    above = irradiance.get_extra_radiation(1)
    ghi = np.maximum(clearness, 1e-9) * above
    return irradiance.erbs(ghi, np.zeros_like(ghi), 1)["dhi"] / ghi


#: diffuse fraction at all clearness values of the bisection
DIFFUSE = diffuse_share(np.linspace(0.0, 1.0, 2**HALVINGS + 1))


def clearness(
    poa_global: np.ndarray,
    solar_zenith: np.ndarray,
    surface_tilt: np.ndarray,
    aoi_projection: np.ndarray,
    inputs: Inputs,
) -> np.ndarray:
    """
    Share of extraterrestrial irradiance that arrives, 0 at night. [-]

    With a beam by :func:`diffuse_share`, an isotropic sky and reflection from the
    ground, it gives the measured irradiance in the plane.

    Parameters
    ----------
    poa_global : array, shape (rows,)
        [W/m²]
    solar_zenith, surface_tilt : array, shape (rows,)
        [°]
    aoi_projection : array, shape (rows,)
        [-]
    inputs : Inputs
        Not used.

    Returns
    -------
    array, shape (rows,)
        From 0 to 1; NaN where an input is.
    """
    up = np.cos(np.radians(solar_zenith))
    # NaN where an input is NaN
    clearness_index = 0.0 * (poa_global + up + aoi_projection)
    by_day = np.flatnonzero((up > 0) & (poa_global > 0) & np.isfinite(clearness_index))
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
    clearness_index[by_day] = low + width / 2.0
    return clearness_index


def on_plane(
    clearness: np.ndarray,
    solar_zenith: np.ndarray,
    solar_azimuth: np.ndarray,
    surface_tilt: float,
    surface_azimuth: float,
) -> np.ndarray:
    """
    Irradiance of a sky in any plane, as :func:`clearness` has it. [W/m²]

    Parameters
    ----------
    clearness : array, shape (rows,)
        [-]
    solar_zenith, solar_azimuth : array, shape (rows,)
        Position of the sun, azimuth clockwise from north. [°]
    surface_tilt, surface_azimuth : float or array, shape (rows,)
        Angles of the plane, azimuth clockwise from north. [°]

    Returns
    -------
    array, shape (rows,)
        0 with the sun below the horizon.
    """
    up = np.maximum(np.cos(np.radians(solar_zenith)), 0.0)
    plane = surface_tilt, surface_azimuth
    ahead = irradiance.aoi_projection(*plane, solar_zenith, solar_azimuth)
    view = (1.0 + np.cos(np.radians(surface_tilt))) / 2.0  # of the sky
    diffuse = diffuse_share(clearness)
    light = (1.0 - diffuse) * np.maximum(ahead, 0.0) + diffuse * up * view
    light = light + ALBEDO * up * (1.0 - view)
    return SOLAR_CONSTANT * clearness * np.where(up > 0.0, light, 0.0)


def beam(
    poa_global: np.ndarray,
    clearness: np.ndarray,
    aoi_projection: np.ndarray,
    inputs: Inputs,
) -> np.ndarray:
    """
    Beam irradiance in the plane of the module, by :func:`clearness`. [W/m²]

    Parameters
    ----------
    poa_global : array, shape (rows,)
        Upper limit of the beam. [W/m²]
    clearness, aoi_projection : array, shape (rows,)
        [-]
    inputs : Inputs
        Not used.

    Returns
    -------
    array, shape (rows,)
    """
    direct = clearness * (1.0 - diffuse_share(clearness)) * SOLAR_CONSTANT
    return np.minimum(direct * np.maximum(aoi_projection, 0.0), poa_global)


def sun_north(solar_azimuth: np.ndarray, inputs: Inputs) -> np.ndarray:
    """
    Northward component of the direction to the sun on the horizon. [-]

    Parameters
    ----------
    solar_azimuth : array, shape (rows,)
        Clockwise from north. [°]
    inputs : Inputs
        Not used.

    Returns
    -------
    array, shape (rows,)
        From -1 to 1.
    """
    return np.cos(np.radians(solar_azimuth))


def sun_east(solar_azimuth: np.ndarray, inputs: Inputs) -> np.ndarray:
    """
    Eastward component of the direction to the sun on the horizon. [-]

    Parameters
    ----------
    solar_azimuth : array, shape (rows,)
        Clockwise from north. [°]
    inputs : Inputs
        Not used.

    Returns
    -------
    array, shape (rows,)
        From -1 to 1.
    """
    return np.sin(np.radians(solar_azimuth))


def beam_clear(
    solar_zenith: np.ndarray, aoi_projection: np.ndarray, inputs: Inputs
) -> np.ndarray:
    """
    Beam in the plane under a clear sky [1]_. [W/m²]

    Parameters
    ----------
    solar_zenith : array, shape (rows,)
        [°]
    aoi_projection : array, shape (rows,)
        [-]
    inputs : Inputs
        Not used.

    Returns
    -------
    array, shape (rows,)

    References
    ----------
    .. [1] ASHRAE Handbook of Fundamentals, clear-day beam A·exp(-B/sin h), with
       the means over the months, A = 1160 W/m² and B = 0.175.
    """
    up = np.cos(np.radians(solar_zenith))
    clear = np.where(up > 0, 1160.0 * np.exp(-0.175 / np.maximum(up, 0.02)), 0.0)
    return clear * np.maximum(aoi_projection, 0.0)


def beam_around(
    beam: np.ndarray,
    beam_clear: np.ndarray,
    elapsed: np.ndarray,
    inputs: Inputs | None = None,
    seen: float = 1.0,
) -> np.ndarray:
    """
    Beam in the plane, expected from the hours before and after. [W/m²]

    It is the clear-sky beam times the share of it that was measured in those hours,
    weighted by ``seen``. So it includes beam that a shaded irradiance sensor misses.

    Parameters
    ----------
    beam, beam_clear : array, shape (rows,)
        Beam in the plane, by the sensor and under a clear sky. [W/m²]
    elapsed : array, shape (rows,)
        Time since the record began. [s]
    inputs : Inputs, optional
        Not used.
    seen : float or array, shape (rows,), default 1
        Weight of each row. [-]

    Returns
    -------
    array, shape (rows,)
    """
    steps = np.diff(elapsed, prepend=elapsed[:1])
    there, whole = (
        relax(column, steps, AROUND) + backwards(column, steps, AROUND)
        for column in (beam * seen, beam_clear * seen + 0.0 * beam)
    )
    return beam_clear * np.minimum(there / np.maximum(whole, 1.0), 1.0)


def ghi_estimated(
    clearness: np.ndarray, solar_zenith: np.ndarray, inputs: Inputs
) -> np.ndarray:
    """
    Global horizontal irradiance, by :func:`clearness`. [W/m²]

    Parameters
    ----------
    clearness : array, shape (rows,)
        [-]
    solar_zenith : array, shape (rows,)
        [°]
    inputs : Inputs
        Not used.

    Returns
    -------
    array, shape (rows,)
    """
    up = np.maximum(np.cos(np.radians(solar_zenith)), 0.0)
    return SOLAR_CONSTANT * clearness * up


def beam_by_tilt(
    beam: np.ndarray,
    aoi_projection: np.ndarray,
    solar_zenith: np.ndarray,
    solar_azimuth: np.ndarray,
    surface_tilt: np.ndarray,
    surface_azimuth: np.ndarray,
    inputs: Inputs,
    *,
    axis_azimuth: Any = None,
) -> np.ndarray:
    """
    Additional beam on a plane that is one degree steeper. [W/(m² °)]

    A plane that turns about an axis leans one degree further to the side to which a
    positive rotation turns it: to the west, if ``axis_azimuth`` is 180°.

    Parameters
    ----------
    beam : array, shape (rows,)
        Beam in the plane. [W/m²]
    aoi_projection : array, shape (rows,)
        [-]
    solar_zenith, solar_azimuth, surface_tilt, surface_azimuth : array, shape (rows,)
        Sun and plane, azimuths clockwise from north. [°]
    inputs : Inputs
        Not used.
    axis_azimuth : float, optional
        Azimuth of the axis; None for a plane that does not turn. [°]

    Returns
    -------
    array, shape (rows,)
    """
    zenith, tilt = np.radians(solar_zenith), np.radians(surface_tilt)
    aside = 1.0
    if axis_azimuth is None:
        around = np.radians(solar_azimuth - surface_azimuth)
    else:
        around = np.radians(solar_azimuth - (axis_azimuth + 90.0))
        aside = np.cos(np.radians(surface_azimuth - (axis_azimuth + 90.0)))
    slope = np.sin(zenith) * np.cos(tilt) * np.cos(around)
    slope = slope - np.cos(zenith) * np.sin(tilt) * aside
    return beam * np.radians(slope) / np.maximum(aoi_projection, 0.1)


def beam_by_azimuth(
    beam: np.ndarray,
    aoi_projection: np.ndarray,
    solar_zenith: np.ndarray,
    solar_azimuth: np.ndarray,
    surface_tilt: np.ndarray,
    surface_azimuth: np.ndarray,
    inputs: Inputs,
) -> np.ndarray:
    """
    Additional beam on a plane turned clockwise by one degree. [W/(m² °)]

    Parameters
    ----------
    beam : array, shape (rows,)
        Beam in the plane. [W/m²]
    aoi_projection : array, shape (rows,)
        [-]
    solar_zenith, solar_azimuth, surface_tilt, surface_azimuth : array, shape (rows,)
        Sun and plane, azimuths clockwise from north. [°]
    inputs : Inputs
        Not used.

    Returns
    -------
    array, shape (rows,)
    """
    around = np.radians(solar_azimuth - surface_azimuth)
    slope = np.sin(np.radians(solar_zenith)) * np.sin(np.radians(surface_tilt))
    slope = slope * np.sin(around)
    return beam * np.radians(slope) / np.maximum(aoi_projection, 0.1)
