"""Soiling and snow on a module, in several formulations.

Each function is named as in `pvlib_fem.simulator._submodels.RIVALS`.
"""

import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import pvlib
from scipy.ndimage import uniform_filter1d

from pvlib_fem.simulator._constants import DAY, even_step, times_of
from pvlib_fem.simulator._tracker import orientation

if TYPE_CHECKING:
    from pvlib_fem.simulator._site import Site

SNOW_BELOW = 0.5  # °C
PER_DAY, DIRTIEST = 0.003, 0.15  # share of light: lost each day, and at most
PARTICLES = 60e-6, 200e-6  # g/m³ below 2.5 and 10 µm, of a dry and busy place
FUSION = 3.34e5  # J/kg
DEGREE_DAY = 4.0  # mm of water per day and K
TAKEN = 0.35  # share of sunlight that snow absorbs


def dirt(weather: pd.DataFrame, site: "Site") -> np.ndarray:
    """
    Share of light lost by soiling.

    Parameters
    ----------
    weather : pandas.DataFrame, shape (rows, columns)
        Result of `weather`.
    site : Site
        Its form of ``cleaning`` is used.

    Returns
    -------
    numpy.ndarray, shape (rows,)
        0 if clean. [-]
    """
    return DIRT[site.forms.cleaning](weather, site)


def rain_of_step(weather: pd.DataFrame) -> pd.Series:
    """Rain of each step. [mm]"""
    return weather["precipitation"] * even_step(times_of(weather)) / 3600.0


def rain(weather: pd.DataFrame, site: "Site") -> np.ndarray:
    """0.3 % per day since the last rain of ``washed_by`` [mm, h]."""
    enough, hours = site.forms.washed_by
    step, rows = even_step(times_of(weather)), np.arange(len(weather))
    total = np.cumsum(rain_of_step(weather).to_numpy())
    before = np.concatenate((np.zeros(round(hours * 3600 / step)), total))[: len(rows)]
    washed = np.maximum.accumulate(np.where(total - before > enough, rows, 0))
    return np.minimum(PER_DAY * (rows - washed) * step / DAY, DIRTIEST)


def kimber(weather: pd.DataFrame, site: "Site") -> np.ndarray:
    """`pvlib.soiling.kimber`: 6 mm in 24 h clean; no soiling for two weeks after."""
    return pvlib.soiling.kimber(
        rain_of_step(weather).tz_localize(None),  # it needs times without a zone
        soiling_loss_rate=PER_DAY,
        max_soiling=DIRTIEST,
    ).to_numpy()


def hsu(weather: pd.DataFrame, site: "Site") -> np.ndarray:
    """`pvlib.soiling.hsu`: settling mass; 1 mm in an hour cleans."""
    tilt, _ = orientation(weather, site)
    ratio = pvlib.soiling.hsu(rain_of_step(weather), 1.0, tilt, *PARTICLES)
    return 1.0 - ratio.to_numpy()


def snowfall(weather: pd.DataFrame) -> np.ndarray:
    """Water that falls as snow; 1 mm of it is 1 cm of snow. [mm/h]"""
    cold = weather["temp_air"].to_numpy() < SNOW_BELOW
    return weather["precipitation"].to_numpy() * cold


def bounded_store(change: np.ndarray) -> np.ndarray:
    """A store that is never below zero: its sum less the lowest sum so far."""
    total = np.cumsum(change)
    return total - np.minimum(np.minimum.accumulate(total), 0.0)


def snow_depth(weather: pd.DataFrame) -> np.ndarray:
    """
    Depth of snow on the ground, which melts by degree-days.

    Parameters
    ----------
    weather : pandas.DataFrame, shape (rows, columns)
        Result of `weather`.

    Returns
    -------
    numpy.ndarray, shape (rows,)
        [cm]
    """
    melt = DEGREE_DAY * np.maximum(weather["temp_air"].to_numpy(), 0.0) / 24.0
    return bounded_store(
        (snowfall(weather) - melt) * even_step(times_of(weather)) / 3600.0
    )


def ground_albedo(
    weather: pd.DataFrame, site: "Site", on: Mapping[str, float]
) -> np.ndarray:
    """
    Albedo of the ground: 0.65 where there is more than 1 cm of snow.

    Parameters
    ----------
    weather : pandas.DataFrame, shape (rows, columns)
        Result of `weather`.
    site : Site
        With the albedo without snow.
    on : dict of float
        Amplitudes by switch; that of ``snow`` scales the change.

    Returns
    -------
    numpy.ndarray, shape (rows,)
        [-]
    """
    white = np.clip(on["snow"] * (snow_depth(weather) > 1.0), 0.0, 1.0)
    return site.albedo + white * (0.65 - site.albedo)


def snow_cover(weather: pd.DataFrame, site: "Site") -> np.ndarray:
    """
    Share of the module under snow.

    Parameters
    ----------
    weather : pandas.DataFrame, shape (rows, columns)
        Result of `weather`.
    site : Site
        Its form of ``snow`` is used.

    Returns
    -------
    numpy.ndarray, shape (rows,)
        From 0 to 1; of ``"sliding"`` booleans. [-]
    """
    return COVER[site.forms.snow](weather, site)


def sliding(weather: pd.DataFrame, site: "Site") -> np.ndarray:
    """
    All of it slides where air is warmer than −G/80 for two hours of day.

    B. Marion et al., Solar Energy 97, 112 (2013),
    :doi:`10.1016/j.solener.2013.07.029`, who have it slide by parts.
    """
    step, rows = even_step(times_of(weather)), np.arange(len(weather))
    air, sun = weather["temp_air"].to_numpy(), weather["ghi"].to_numpy()
    slides = ((air > sun / -80.0) & (sun > 50.0)).astype(float)
    slides = uniform_filter1d(slides, round(7200 / step)) > 0.99
    fell, slid = (
        np.maximum.accumulate(np.where(event, rows, -1))
        for event in (snowfall(weather) > 0.3, slides)
    )
    return fell > slid


def coverage_nrel(weather: pd.DataFrame, site: "Site") -> np.ndarray:
    """Share of the module under snow that slides off gradually, by pvlib."""
    depth = snowfall(weather) * even_step(times_of(weather)) / 3600.0
    with warnings.catch_warnings():
        # pvlib 0.16 asks pandas in a way that pandas 3 warns of
        warnings.filterwarnings("ignore", ".*BaseOffset")
        return pvlib.snow.coverage_nrel(
            pd.Series(depth, weather.index),
            weather["ghi"],
            weather["temp_air"],
            orientation(weather, site)[0],
        ).to_numpy()


def melting(weather: pd.DataFrame, site: "Site") -> np.ndarray:
    """
    It stays where it fell and melts by sunlight and degree-days, 1 mm covers all.

    A degree-day factor of 4 mm is a loss of 15.5 W m⁻² K⁻¹ to the air.
    """
    to_air = DEGREE_DAY * FUSION / DAY
    gain = TAKEN * weather["ghi"].to_numpy() + to_air * weather["temp_air"].to_numpy()
    melt = 3600.0 * np.maximum(gain, 0.0) / FUSION
    depth = bounded_store(
        (snowfall(weather) - melt) * even_step(times_of(weather)) / 3600.0
    )
    return np.minimum(depth, 1.0)


DIRT = {law.__name__: law for law in (rain, kimber, hsu)}
COVER = {law.__name__: law for law in (sliding, coverage_nrel, melting)}
