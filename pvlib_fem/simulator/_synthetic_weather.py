"""Synthetic weather of a climate, minute by minute."""

import numpy as np
import pandas as pd
from pvlib.atmosphere import rh_from_tdew
from scipy.ndimage import uniform_filter1d
from scipy.signal import lfilter
from scipy.special import gamma, ndtr

from pvlib_fem.simulator._air import (
    EMISSIVITIES,
    VAPOUR,
    diffuse_share,
    vapour,
)
from pvlib_fem.simulator._constants import (
    DAY,
    SIGMA,
    SOLAR_CONSTANT,
    ZERO,
    first_order_response,
    hour_and_day,
    random_stream,
    season_wave,
    wander,
)
from pvlib_fem.simulator._site import Site


def weather(
    site: Site,
    days: float = 365,
    step: float = 60.0,
    start: str = "2023-01-01",
    seed: int = 0,
) -> pd.DataFrame:
    """
    Synthetic weather of a climate, determined by site, seed and step.

    Parameters
    ----------
    site : Site
        The site, with its climate.
    days : float
        Length of the record. [days]
    step : float
        Time between rows. [s]
    start : str
        First day, in local standard time.
    seed : int
        Of the random numbers.

    Returns
    -------
    DataFrame
        ``ghi``, ``dni``, ``dhi`` [W/m²], ``temp_air``, ``temp_dew`` [°C],
        ``relative_humidity`` [%], ``wind_speed`` [m/s], ``wind_direction`` [°],
        ``precipitation`` [mm/h of water, snow included], ``longwave_down`` [W/m²],
        ``cloud`` [0…1], ``elevation``, ``azimuth`` of the sun [°], ``scatter``
        (of the wind between mast and module, sd 1). A row's weather holds over
        the step that ends at its time.

    Raises
    ------
    ValueError
        If the step is longer than an hour, or the record shorter than two.

    Notes
    -----
    Shares, spreads and memories are choices of this generator, made to look like
    1-min records of mid-latitudes: sky regimes by a Markov chain of hours, clouds
    and gaps of Pareto duration, wind by its Weibull quantiles.
    """
    if not 0 < step <= 3600 or days * DAY < 2 * step:
        raise ValueError(f"step = {step} s must be within an hour and {days} days")
    rows, minute, hourly = round(days * DAY / step), 60.0 / step, 3600.0 / step
    spacing = pd.Timedelta(seconds=step)
    times = pd.date_range(start, periods=rows, freq=spacing, tz=site.tz)
    hour, day = hour_and_day(times)
    elevation, azimuth = sun_position(times, site)

    hours = (np.arange(rows) / hourly).astype(int)
    season = season_wave(site, day[0] + np.arange(hours[-1] + 1) / 24)
    sky = regimes(site, season, random_stream(seed, "sky"))[hours]
    rain, onset = rainfall(site, sky, days, minute, random_stream(seed, "rain"))
    share = [
        first_order_response((sky == kind).astype(float), 8 * minute)
        for kind in range(3)
    ]
    index = clear_sky_index(share, minute, random_stream(seed, "cloud"))
    ghi, dni, dhi = irradiance(elevation, index, site.forms.diffuse)
    random = random_stream(seed, "cover")
    cover = 0.03 * share[0] + 0.5 * share[1] + 0.95 * share[2]
    cover = first_order_response(cover, 20 * minute) + 0.06 * wander(
        random, rows, 2 * hourly
    )
    cloud = np.clip(cover, 0.0, 1.0)

    random = random_stream(seed, "air")
    clearness = 1.0 - first_order_response(cloud, 10 * hourly)
    temp_air = (
        site.temp_mean
        - site.temp_amplitude * season_wave(site, day)
        + 3.5 * wander(random, rows, 72 * hourly)
        + (1.5 + 5.5 * clearness) * np.cos(2 * np.pi * (hour - 15) / 24)
        + 0.4 * wander(random, rows, 30 * minute)
        + 0.12 * wander(random, rows, 3 * minute)  # turbulence
        - outflow(onset, minute, random)
    )
    random = random_stream(seed, "humidity")
    dryness = np.exp(0.4 * wander(random, rows, 48 * hourly)) * (0.6 + 0.8 * clearness)
    temp_dew = first_order_response(temp_air, 24 * hourly)
    temp_dew -= np.minimum(site.dew_depression * dryness, 25.0)
    temp_dew += 0.8 * wander(random, rows, 4 * hourly)
    damp = uniform_filter1d((rain > 0).astype(float), round(2 * hourly))
    temp_dew += np.minimum(3.0 * damp, 1.0) * np.maximum(temp_air - 0.6 - temp_dew, 0.0)
    temp_dew = np.minimum(temp_dew, temp_air - 0.2)

    speed, direction, scatter = wind(site, hour, minute, random_stream(seed, "wind"))
    saturation = VAPOUR[site.forms.vapour]
    pressure = vapour(temp_dew, site.forms.vapour)
    law = EMISSIVITIES[site.forms.emissivity]
    emissivity = law(temp_air, temp_dew, pressure, hour)
    emissivity += (1.0 - emissivity) * 0.84 * cloud  # of low cloud bases
    columns = {
        "ghi": ghi,
        "dni": dni,
        "dhi": dhi,
        "temp_air": temp_air,
        "temp_dew": temp_dew,
        "relative_humidity": rh_from_tdew(temp_air, temp_dew, saturation),
        "wind_speed": speed,
        "wind_direction": direction,
        "precipitation": rain,
        "longwave_down": emissivity * SIGMA * (temp_air + ZERO) ** 4,
        "cloud": cloud,
        "elevation": elevation,
        "azimuth": azimuth,
        "scatter": scatter,
    }
    frame = pd.DataFrame(columns, index=times)
    frame.attrs = {"seed": seed}
    return frame


def sun_position(times: pd.DatetimeIndex, site: Site) -> tuple[np.ndarray, np.ndarray]:
    """
    Elevation and azimuth of the sun, Spencer [3]_; no refraction.

    Parameters
    ----------
    times : pandas.DatetimeIndex, shape (rows,)
        In local standard time.
    site : Site
        With latitude and longitude.

    Returns
    -------
    elevation : numpy.ndarray, shape (rows,)
        Negative at night. [°]
    azimuth : numpy.ndarray, shape (rows,)
        From north, clockwise. [°]
    """
    hour, day = hour_and_day(times)
    angle = 2 * np.pi * (day - 1) / 365.0
    waves = [f(n * angle) for n in (1, 2, 3) for f in (np.cos, np.sin)]
    tilt = [-0.399912, 0.070257, -0.006758, 0.000907, -0.002697, 0.00148]
    declination = 0.006918 + sum(a * wave for a, wave in zip(tilt, waves))
    equation = [0.001868, -0.032077, -0.014615, -0.040849]
    minutes = 229.18 * (0.000075 + sum(a * wave for a, wave in zip(equation, waves)))
    solar = hour - site.utc_offset + site.longitude / 15.0 + minutes / 60.0
    turn, north = np.pi / 12 * (solar - 12.0), np.radians(site.latitude)
    up = np.sin(north) * np.sin(declination)
    up += np.cos(north) * np.cos(declination) * np.cos(turn)
    azimuth = np.arctan2(
        np.sin(turn),
        np.cos(turn) * np.sin(north) - np.tan(declination) * np.cos(north),
    )
    return np.degrees(np.arcsin(np.clip(up, -1, 1))), np.degrees(azimuth) + 180.0


def regimes(site: Site, cold: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Clear, broken or overcast (0, 1, 2) in each hour: a Markov chain."""
    clear = np.clip(site.clear_share - 0.08 * cold, 0.05, 0.9)
    overcast = 0.47 * (1.0 - clear)
    broken = 1.0 - clear - overcast
    # 0.06 an hour out of broken to either side; the way back keeps the shares
    leave_clear, leave_overcast = 0.06 * broken / clear, 0.06 * broken / overcast
    draws = random.random(len(cold) + 1)
    state = int(np.searchsorted([clear[0], clear[0] + broken[0]], draws[-1]))
    sky = np.empty(len(cold), dtype=np.int8)
    for i, draw in enumerate(draws[:-1]):
        if state == 1:
            state = 0 if draw < 0.06 else 2 if draw > 0.94 else 1
        elif draw < (leave_clear[i] if state == 0 else leave_overcast[i]):
            state = 1
        sky[i] = state
    return sky


def rainfall(
    site: Site, sky: np.ndarray, days: float, minute: float, random: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Rain events under cloud [mm/h] and their onsets; ``sky`` clears after some."""
    rain, onset = np.zeros(len(sky)), np.zeros(len(sky))
    under = np.flatnonzero(sky == 2)
    for _ in range(round(1.6 * site.rain_days * days)):
        place, soon, wait = random.random(3)
        length = max(round((8 + random.exponential(45)) * minute), 1)
        strength = random.exponential(2.5)
        pulse = random.gamma(2.0, 0.5, length)
        if not len(under):
            continue
        begin = under[int(place * len(under))]
        event = slice(begin, begin + length)
        rain[event] = strength * pulse[: len(rain[event])]
        sky[event] = 2
        onset[begin] = strength
        if soon < 0.35:  # the sun comes back while the glass is wet
            back = begin + length + round(30 * wait * minute)
            sky[back : back + round(120 * minute)] = 1
    return rain, onset


def clear_sky_index(
    share: list[np.ndarray], minute: float, random: np.random.Generator
) -> np.ndarray:
    """Global irradiance relative to a clear sky, from the shares of the regimes."""
    rows = len(share[0])
    clear = 1.0 + 0.02 * wander(random, rows, 20 * minute)
    overcast = 0.32 + 0.16 * wander(random, rows, 240 * minute)
    overcast += 0.05 * wander(random, rows, 15 * minute)
    # clouds and gaps take turns; durations are Pareto, from 3.5 and 2.5 min
    spells = int(rows / (2.5 * minute)) + 2
    shortest = np.where(np.arange(spells) % 2, 2.5, 3.5) * minute
    spells = np.minimum(shortest * (1 + random.pareto(1.5, spells)), 90 * minute)
    turn = np.searchsorted(np.cumsum(spells), np.arange(rows), side="right")
    shadow = 0.38 + 0.1 * wander(random, rows, 30 * minute)
    gap = 1.03 + 0.04 * wander(random, rows, 6 * minute)  # clouds nearby reflect
    broken = first_order_response(np.where(turn % 2, gap, shadow), 1.7 * minute)
    index = share[0] * clear + share[1] * broken + share[2] * overcast
    return np.clip(index, 0.05, 1.25)


def irradiance(
    elevation: np.ndarray, index: np.ndarray, form: str
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Global, beam and diffuse: Haurwitz, Meinel [3]_ and the form's. [W/m²]"""
    up = np.maximum(np.sin(np.radians(elevation)), 1e-3)
    day = elevation > 0
    ghi = np.where(day, index * 1098.0 * up * np.exp(-0.057 / up), 0.0)
    mass = 1.0 / np.maximum(up, 0.03)
    beam = SOLAR_CONSTANT * 0.7 ** (mass**0.678)
    share = diffuse_share(form, ghi, elevation)
    dni = np.where(day, np.minimum((1.0 - share) * ghi / up, beam), 0.0)
    return ghi, dni, ghi - dni * up * day


def outflow(
    onset: np.ndarray, minute: float, random: np.random.Generator
) -> np.ndarray:
    """Cold air before a shower: 2 to 6 K within minutes, gone after hours. [K]"""
    drop = random.uniform(2.0, 6.0, len(onset)) * (onset > 4.0)
    slow, fast = np.exp(-1 / (90 * minute)), np.exp(-1 / (5 * minute))
    return lfilter([1.0], [1.0, -slow], drop) - lfilter([1.0], [1.0, -fast], drop)


def wind(
    site: Site, hour: np.ndarray, minute: float, random: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Speed at the mast, direction, and the scatter of the wind at the module."""
    rows = len(hour)
    waves = ((0.65, 14 * 60), (0.55, 90), (0.40, 8), (0.33, 1.2))
    level = sum(a * wander(random, rows, lag * minute) for a, lag in waves)
    level += 0.35 * np.cos(2 * np.pi * (hour - 14) / 24)
    chance = ndtr(level / np.sqrt(0.994 + 0.35**2 / 2))
    # Weibull of shape 2 by its quantiles
    scale = site.wind_mean / gamma(1.5)
    speed = scale * np.sqrt(-np.log(np.maximum(1.0 - chance, 1e-12)))
    sector = first_order_response(wander(random, rows, 40 * 60 * minute), 60 * minute)
    direction = 225.0 + 80.0 * np.tanh(2.0 * sector)
    direction += 35.0 * wander(random, rows, 300 * minute)
    direction += 18.0 * wander(random, rows, 10 * minute)
    direction += 8.0 * random.standard_normal(rows)
    return speed, direction % 360.0, wander(random, rows, 8 * minute)
