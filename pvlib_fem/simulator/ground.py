"""Light on a plane, and what lies on it and around: dirt, snow, an obstacle."""

import numpy as np
from scipy.ndimage import uniform_filter1d

from pvlib_fem.simulator.site import DAY, seconds

SNOW_BELOW = 0.5  # °C


def plane(weather, tilt, azimuth, albedo):
    """Beam, sky and ground light on a plane, isotropic; cosine of incidence."""
    up, side = np.radians(weather["elevation"].to_numpy()), np.radians(tilt)
    around = np.radians(weather["azimuth"].to_numpy() - azimuth)
    cosine = np.sin(up) * np.cos(side) + np.cos(up) * np.sin(side) * np.cos(around)
    cosine = np.where(up > 0, np.maximum(cosine, 0.0), 0.0)
    sky = weather["dhi"].to_numpy() * (1 + np.cos(side)) / 2
    ground = albedo * weather["ghi"].to_numpy() * (1 - np.cos(side)) / 2
    return weather["dni"].to_numpy() * cosine, sky, ground, cosine


def behind_obstacle(weather):
    """Where the sun stands behind the obstacle on the horizon."""
    azimuth, elevation = weather["azimuth"].to_numpy(), weather["elevation"].to_numpy()
    return (azimuth >= 108) & (azimuth <= 135) & (elevation < 28)


def dirt(weather):
    """Share of light lost to dirt: 0.3 % a day since 1 mm of rain in 3 h; ≤ 15 %."""
    step, rows = seconds(weather.index), np.arange(len(weather))
    fallen = np.cumsum(weather["precipitation"].to_numpy()) * step / 3600.0
    before = np.concatenate((np.zeros(round(3 * 3600 / step)), fallen))[: len(rows)]
    washed = np.maximum.accumulate(np.where(fallen - before > 1.0, rows, 0))
    return np.minimum(0.003 * (rows - washed) * step / DAY, 0.15)


def snowpack(weather):
    """Depth of snow on the ground [cm], and where it covers the module."""
    step, rows = seconds(weather.index), np.arange(len(weather))
    air, sun = weather["temp_air"].to_numpy(), weather["ghi"].to_numpy()
    falling = weather["precipitation"].to_numpy() * (air < SNOW_BELOW)
    melt = 4.0 * np.maximum(air, 0.0) / 24.0  # mm/h: 4 mm per day and K
    # a store that is never below zero: its sum less the lowest sum so far
    total = np.cumsum((falling - melt) * step / 3600.0)
    depth = total - np.minimum(np.minimum.accumulate(total), 0.0)
    # snow slides where the air is warmer than −G/80 [7]_, for two hours of day
    slides = ((air > sun / -80.0) & (sun > 50.0)).astype(float)
    slides = uniform_filter1d(slides, round(7200 / step)) > 0.99
    fell, slid = (
        np.maximum.accumulate(np.where(event, rows, -1))
        for event in (falling > 0.3, slides)
    )
    return depth, fell > slid  # 1 mm of water is 1 cm of snow


def bright(weather, site, on):
    """Albedo of the ground: 0.65 where there is more than 1 cm of snow."""
    white = np.clip(on["snow"] * (snowpack(weather)[0] > 1.0), 0.0, 1.0)
    return site.albedo + white * (0.65 - site.albedo)
