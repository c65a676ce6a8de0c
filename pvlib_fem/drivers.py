"""What an effect may need beside the measured columns, computed from them.

A driver is computed by a function of its columns and, last, of the
:class:`~pvlib_fem.records.Inputs` that they stand in, which bring the times.
"""

from dataclasses import replace

import numpy as np
import pandas as pd

from pvlib_fem.record.columns import GEOMETRY
from pvlib_fem.relaxation import relax

__all__ = ["sun"]

STEFAN_BOLTZMANN = 5.670374419e-8  # W/(m² K⁴), CODATA 2018
ZERO_CELSIUS = 273.15  # K
HOUR = 3600.0  # s
YEAR = 365.2425 * 86400.0  # s
DRYING = 1800.0  # s that a film of water keeps its memory of rain
SOAKED = 5.0  # times that memory at which a module is all wet
CLEANING = 1.0  # mm of rain that clean a module
SHOWER = 3.0 * HOUR  # s over which they fall
DIRTIEST = 60.0  # days after which dirt gathers no more
RESISTANCE = 0.025  # K m²/W, of a module that is not asked
SOLAR_CONSTANT = 1361.0  # W/m²
HALVINGS = 12  # of the range of the clearness: to 1/4096
ALBEDO = 0.2  # of ground of which nothing is known
CLOUD_BASE = 0.84  # emissivity of low cloud bases beside what the clear sky lacks
CLOUD_MEMORY = 3.0 * HOUR  # how long a sky stays what it was
AROUND = 2.0 * HOUR  # over which the sky before and after is looked at
LOW_SUN = 5.0  # ° of elevation below which irradiance says little of clouds
SNOWFALL = 0.5  # cm of growth in about an hour, half a step of the usual gauge
SUN_GRID = "5min"  # over which the sun moves as good as straight


def sun(index, location):
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


def geometry(index, location=None, surface_tilt=None, surface_azimuth=None):
    """Columns of the sun's and the module's place, as far as they are known."""
    columns = {}
    if location is not None:
        columns |= dict(sun(index, location))
    for name, value in zip(GEOMETRY[2:], (surface_tilt, surface_azimuth)):
        if value is not None:
            columns[name] = pd.Series(value, index, dtype=float)
    return columns


def aoi_projection(solar_zenith, solar_azimuth, surface_tilt, surface_azimuth, inputs):
    """Cosine of the angle of incidence, negative behind the module. [-]"""
    zenith, tilt = np.radians(solar_zenith), np.radians(surface_tilt)
    around = np.radians(solar_azimuth - surface_azimuth)
    across = np.sin(zenith) * np.sin(tilt) * np.cos(around)
    return np.clip(np.cos(zenith) * np.cos(tilt) + across, -1.0, 1.0)


def diffuse_share(clearness):
    """
    Share of diffuse in global irradiance, by clearness [1]_. [-]

    References
    ----------
    .. [1] D. G. Erbs, S. A. Klein and J. A. Duffie, Solar Energy 28, 293 (1982),
       :doi:`10.1016/0038-092X(82)90302-4`, as in :func:`pvlib.irradiance.erbs`.
    """
    k = clearness
    middle = 0.9511 + k * (-0.1604 + k * (4.388 + k * (-16.638 + k * 12.336)))
    return np.where(k <= 0.22, 1.0 - 0.09 * k, np.where(k <= 0.8, middle, 0.165))


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
        diffuse = diffuse_share(middle)
        light = middle * (beam + diffuse * (sky - beam) + ground)
        low += width * (light < measured)
    found[by_day] = low + width / 2.0
    return found


def beam(poa_global, clearness, aoi_projection, inputs):
    """Beam irradiance in the plane of the module, by :func:`clearness`. [W/m²]"""
    direct = clearness * (1.0 - diffuse_share(clearness)) * SOLAR_CONSTANT
    return np.minimum(direct * np.maximum(aoi_projection, 0.0), poa_global)


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


def elapsed(inputs):
    """Time since the record began. [s]"""
    return inputs.seconds


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


def black_body(temp_air):
    """Longwave of a black body at air temperature. [W/m²]"""
    return STEFAN_BOLTZMANN * (temp_air + ZERO_CELSIUS) ** 4


def sky_deficit(longwave_down, temp_air, inputs):
    """Longwave that the sky lacks beside a black body at air temperature. [W/m²]"""
    return black_body(temp_air) - longwave_down


def saturation(celsius):
    """Saturation vapour pressure over water, by Magnus. [hPa]"""
    return 6.112 * np.exp(17.62 * celsius / (243.12 + celsius))


def moist_emissivity(relative_humidity, temp_air):
    """
    Emissivity of the clear sky, by the vapour at the ground [1]_. [-]

    References
    ----------
    .. [1] A. J. Prata, "A new long-wave formula for estimating downward
       clear-sky radiation at the surface", Q. J. R. Meteorol. Soc. 122, 1127
       (1996), :doi:`10.1002/qj.49712253306`.
    """
    vapour = relative_humidity / 100.0 * saturation(temp_air)
    water = 46.5 * vapour / (temp_air + ZERO_CELSIUS)  # g/cm² above
    return 1.0 - (1.0 + water) * np.exp(-np.sqrt(1.2 + 3.0 * water))


def sky_deficit_moist(relative_humidity, temp_air, inputs):
    """
    :func:`sky_deficit` of a clear sky, from humidity. [W/m²]

    By :func:`moist_emissivity`.
    """
    emissivity = moist_emissivity(relative_humidity, temp_air)
    return (1.0 - emissivity) * black_body(temp_air)


def sky_deficit_humid(sky_deficit_moist, cloud_share, inputs):
    """:func:`sky_deficit` from humidity and the clouds of the day. [W/m²]"""
    return (1.0 - CLOUD_BASE * cloud_share) * sky_deficit_moist


def sky_deficit_clouds(sky_deficit_air, cloud_share, inputs):
    """:func:`sky_deficit` from air temperature and the clouds of the day. [W/m²]"""
    return (1.0 - CLOUD_BASE * cloud_share) * sky_deficit_air


def sky_deficit_air(temp_air, inputs):
    """
    :func:`sky_deficit` of a clear sky, from air temperature alone [1]_. [W/m²]

    References
    ----------
    .. [1] W. C. Swinbank, "Long-wave radiation from clear skies", Q. J. R.
       Meteorol. Soc. 89, 339 (1963), :doi:`10.1002/qj.49708938105`.
    """
    emissivity = 9.365e-6 * (temp_air + ZERO_CELSIUS) ** 2
    return (1.0 - emissivity) * black_body(temp_air)


def cloud_share(clearness, solar_zenith, inputs):
    """
    Share of the sky under cloud, carried from each day through the night. [-]

    By day what lacks of the light of a clear sky [1]_, of which an overcast one
    lets a quarter through [2]_.

    References
    ----------
    .. [1] B. Haurwitz, "Insolation in Relation to Cloudiness and Cloud Density",
       J. Meteorol. 2, 154 (1945), as in :func:`pvlib.clearsky.haurwitz`.
    .. [2] F. Kasten and G. Czeplak, Solar Energy 24, 177 (1980),
       :doi:`10.1016/0038-092X(80)90391-6`.
    """
    up = np.maximum(np.cos(np.radians(solar_zenith)), 0.01)
    clear = 1098.0 / SOLAR_CONSTANT * np.exp(-0.059 / up)
    cloudy = np.clip((1.0 - clearness / clear) / 0.75, 0.0, 1.0)
    seen = np.where(np.isnan(clearness), np.nan, solar_zenith < 90.0 - LOW_SUN)
    # nothing seen for long: half, at the weight of a moment
    weight = smoothed(seen, inputs, CLOUD_MEMORY) + 1e-6
    return (smoothed(seen * cloudy, inputs, CLOUD_MEMORY) + 0.5e-6) / weight


def wetness(precipitation, inputs):
    """Share of a module that is wet: 1 in rain, and drying after it. [-]"""
    falling = np.where(np.isnan(precipitation), np.nan, precipitation > 0)
    return np.minimum(1.0, SOAKED * smoothed(falling, inputs, DRYING))


def film_vapour(wetness, relative_humidity, temp_air, irradiance_smoothed, inputs):
    """Vapour pressure of a wet module above that of the air, times wetness. [hPa]"""
    warm = temp_air + RESISTANCE * irradiance_smoothed
    above = saturation(warm) - relative_humidity / 100.0 * saturation(temp_air)
    return wetness * np.maximum(above, 0.0)


def days_since_rain(precipitation, inputs):
    """
    Time since it rained 1 mm, or the record began, two months at most [1]_. [days]

    References
    ----------
    .. [1] M. Coello and L. Boyle, "Simple Model for Predicting Time Series Soiling
       of Photovoltaic Panels", IEEE J. Photovoltaics 9, 1382 (2019),
       :doi:`10.1109/JPHOTOV.2019.2919628`: 1 mm cleans, as in
       :func:`pvlib.soiling.hsu`.
    """
    seconds = inputs.seconds
    rain = np.nan_to_num(precipitation)
    hours = np.diff(seconds, prepend=seconds[0]) / HOUR
    fallen = np.cumsum(rain * hours)
    shower = fallen - np.interp(seconds - SHOWER, seconds, fallen, left=0.0)
    cleans = (rain > 0) & (shower >= CLEANING)
    last = np.maximum.accumulate(np.where(cleans, seconds, seconds[0]))
    return np.minimum((seconds - last) / 86400.0, DIRTIEST)


def snow_cover(snow_depth, temp_air, poa_global, inputs):
    """
    Whether snow lies on the module, by its depth on the ground [1]_. [-]

    From when it last grew until the sun, above 50 W/m², and air warmer than
    −G/80 have let it slide for an hour and a half.

    References
    ----------
    .. [1] B. Marion et al., "Measured and modeled photovoltaic system energy
       losses from snow for Colorado and Wisconsin locations", Solar Energy 97,
       112 (2013), :doi:`10.1016/j.solener.2013.07.029`, as in
       :func:`pvlib.snow.coverage_nrel`.
    """
    known = 0.0 * (snow_depth + temp_air + poa_global)
    depth = np.nan_to_num(snow_depth)
    grows = depth - smoothed(depth, inputs, HOUR) > SNOWFALL
    warm = (temp_air > poa_global / -80.0) & (poa_global > 50.0)
    slides = smoothed(warm * 1.0, inputs, HOUR) > 1.0 - np.exp(-1.5)
    rows = np.arange(len(depth))
    grew, slid = (
        np.maximum.accumulate(np.where(event, rows, -1)) for event in (grows, slides)
    )
    return known + (grew > slid)


def smoothed(column, inputs, memory):
    """A column through a first-order memory. [s]"""
    column = np.asarray(column, dtype=float)
    return relax(column, inputs.steps, memory / inputs.unit)


def backwards(column, steps, memory):
    """A column through a first-order memory of what comes after."""
    turned = np.append(steps[:1], steps[:0:-1])
    return relax(np.ascontiguousarray(column[::-1]), turned, memory)[::-1]


def stored(memory):
    """The driver that a column's memory lags behind the column: 0 when settled."""

    def lag(column, inputs):
        return smoothed(column, inputs, memory) - column

    lag.__doc__ = (
        f"Mean of the past {memory / HOUR:g} h, weighted by age, beyond what is now. "
        "[unit of the column]"
    )
    return lag


def irradiance_smoothed(poa_global, inputs):
    """Irradiance as a module's temperature follows it. [W/m²]"""
    return smoothed(poa_global, inputs, 600.0)


def years(inputs):
    """Time since the record began. [years]"""
    seconds = inputs.seconds
    return (seconds - seconds[0]) / YEAR


def day_angle(inputs):
    """Angle of the year, 0 on the first of January. [rad]"""
    if not isinstance(inputs.index, pd.DatetimeIndex):
        raise ValueError(
            "the season needs the date, and the columns bring no DatetimeIndex; give "
            "them as Series with one"
        )
    days = inputs.index.day_of_year.to_numpy() - 1.0
    return 2.0 * np.pi * days / 365.25


#: name: (columns that it needs, how to compute it from them and the times)
DERIVED = {
    "aoi_projection": (GEOMETRY, aoi_projection),
    "clearness": (
        ("poa_global", "solar_zenith", "surface_tilt", "aoi_projection"),
        clearness,
    ),
    "beam": (("poa_global", "clearness", "aoi_projection"), beam),
    "beam_clear": (("solar_zenith", "aoi_projection"), beam_clear),
    "elapsed": ((), elapsed),
    "beam_around": (("beam", "beam_clear", "elapsed"), beam_around),
    "ghi_estimated": (("clearness", "solar_zenith"), ghi_estimated),
    "beam_by_tilt": (("beam", "aoi_projection", *GEOMETRY), beam_by_tilt),
    "beam_by_azimuth": (("beam", "aoi_projection", *GEOMETRY), beam_by_azimuth),
    "sky_deficit": (("longwave_down", "temp_air"), sky_deficit),
    "sky_deficit_moist": (("relative_humidity", "temp_air"), sky_deficit_moist),
    "cloud_share": (("clearness", "solar_zenith"), cloud_share),
    "sky_deficit_humid": (("sky_deficit_moist", "cloud_share"), sky_deficit_humid),
    "sky_deficit_air": (("temp_air",), sky_deficit_air),
    "sky_deficit_clouds": (("sky_deficit_air", "cloud_share"), sky_deficit_clouds),
    "film_vapour": (
        ("wetness", "relative_humidity", "temp_air", "irradiance_smoothed"),
        film_vapour,
    ),
    "wetness": (("precipitation",), wetness),
    "days_since_rain": (("precipitation",), days_since_rain),
    "snow_cover": (("snow_depth", "temp_air", "poa_global"), snow_cover),
    "irradiance_smoothed": (("poa_global",), irradiance_smoothed),
    "poa_stored_1h": (("poa_global",), stored(HOUR)),
    "poa_stored_3h": (("poa_global",), stored(3.0 * HOUR)),
    "air_stored": (("temp_air",), stored(3.0 * HOUR)),
    "years": ((), years),
    "day_angle": ((), day_angle),
}

#: measured columns: what they are, and their unit
MEASURED = {
    "poa_global": "Irradiance in the plane of the module. [W/m²]",
    "temp_air": "Air temperature. [°C]",
    "wind_speed": "Wind speed. [m/s]",
    "wind_direction": "Where the wind comes from, clockwise from north. [°]",
    "relative_humidity": "Relative humidity. [%]",
    "longwave_down": "Longwave irradiance from the sky, ``ir_down`` in pvlib. [W/m²]",
    "precipitation": "Rate of precipitation, as water. [mm/h]",
    "snow_depth": "Depth of snow on the ground. [cm]",
    "p_dc": "DC power for each square metre of module. [W/m²]",
    "solar_zenith": "Angle of the sun from the vertical. [°]",
    "solar_azimuth": "Where the sun stands, clockwise from north. [°]",
    "surface_tilt": "Tilt of the module from horizontal. [°]",
    "surface_azimuth": "Where the module faces, clockwise from north. [°]",
}
USUAL = ("poa_global", "temp_air", "wind_speed")


def needed_for(names):
    """Measured columns behind drivers beside the usual three, each once."""
    columns = []
    for name in names:
        behind = needed_for(DERIVED[name][0]) if name in DERIVED else [name]
        columns += [n for n in behind if n not in (*USUAL, *columns)]
    return columns


def completed(inputs, names):
    """The inputs with those drivers, and what is behind them, derived."""
    for name in names:
        if name in DERIVED and name not in inputs.columns:
            needs, compute = DERIVED[name]
            inputs = completed(inputs, needs)
            found = compute(*(inputs[n] for n in needs), inputs)
            inputs = replace(inputs, columns={**inputs.columns, name: found})
    return inputs
