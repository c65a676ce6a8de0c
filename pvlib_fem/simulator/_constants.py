"""Common functions of all layers: constants, random numbers, lags, clocks."""

import zlib
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from scipy.signal import lfilter

if TYPE_CHECKING:
    from pvlib_fem.simulator._site import Site

SIGMA = 5.670374419e-8  # W m⁻² K⁻⁴
ZERO = 273.15  # 0 °C [K]
DAY = 86400.0  # s
SOLAR_CONSTANT = 1361.0  # W/m²; this world's sun is always at its mean distance


def random_stream(seed: int, purpose: str) -> np.random.Generator:
    """
    Random numbers of one purpose, independent of all others.

    Parameters
    ----------
    seed : int
        Of the weather or the record.
    purpose : str
        Name of the purpose, such as ``"rain"``.

    Returns
    -------
    numpy.random.Generator
        In its initial state.
    """
    return np.random.default_rng([seed, zlib.crc32(purpose.encode())])


def wander(random: np.random.Generator, rows: int, lag: float) -> np.ndarray:
    """
    Ornstein-Uhlenbeck noise of unit variance.

    Parameters
    ----------
    random : numpy.random.Generator
        Source of the noise.
    rows : int
        Number of values.
    lag : float
        Time constant of its autocorrelation. [rows]

    Returns
    -------
    numpy.ndarray, shape (rows,)
        With a mean of 0. [-]
    """
    decay = np.exp(-1.0 / lag)
    source = random.standard_normal(rows)
    source[1:] *= np.sqrt(1.0 - decay**2)
    return lfilter([1.0], [1.0, -decay], source)


def first_order_response(values: np.ndarray, lag: float) -> np.ndarray:
    """
    First-order response, from steady state.

    Parameters
    ----------
    values : numpy.ndarray, shape (rows,)
        Input in any unit.
    lag : float
        Time constant. [rows]

    Returns
    -------
    numpy.ndarray, shape (rows,)
        In the unit of the input.
    """
    decay = np.exp(-1.0 / lag)
    return lfilter([1.0 - decay], [1.0, -decay], values, zi=[decay * values[0]])[0]


def hour_and_day(times: pd.DatetimeIndex) -> tuple[np.ndarray, np.ndarray]:
    """
    Hour of the day and day of the year, both with their fraction.

    Parameters
    ----------
    times : pandas.DatetimeIndex, shape (rows,)
        In local standard time.

    Returns
    -------
    hour : numpy.ndarray, shape (rows,)
        From 0 to below 24. [h]
    day : numpy.ndarray, shape (rows,)
        1 at the begin of January 1st. [days]
    """
    hour = (times - times.normalize()).total_seconds().to_numpy() / 3600.0
    return hour, times.day_of_year.to_numpy() + hour / 24.0


def season_wave(site: "Site", day: np.ndarray) -> np.ndarray:
    """
    Season as a wave: 1 in midwinter, −1 in midsummer.

    Parameters
    ----------
    site : Site
        Its latitude has the hemisphere.
    day : numpy.ndarray, shape (rows,)
        Day of the year. [days]

    Returns
    -------
    numpy.ndarray, shape (rows,)
        [-]
    """
    return np.sign(site.latitude or 1.0) * np.cos(2 * np.pi * (day - 15) / 365.25)


def times_of(rows: pd.DataFrame) -> pd.DatetimeIndex:
    """
    The times of rows.

    Parameters
    ----------
    rows : pandas.DataFrame, shape (rows, columns)
        With a DatetimeIndex, such as the result of `weather`.

    Returns
    -------
    pandas.DatetimeIndex, shape (rows,)
        Its index.
    """
    return pd.DatetimeIndex(rows.index)


def even_step(times: pd.DatetimeIndex) -> float:
    """
    The even step of a time axis.

    Parameters
    ----------
    times : pandas.DatetimeIndex, shape (rows,)
        Two times at least.

    Returns
    -------
    float
        [s]

    Raises
    ------
    ValueError
        If the steps are uneven.
    """
    steps = np.diff(times.asi8)
    if len(steps) == 0 or (steps != steps[0]).any():
        raise ValueError("weather is not on even steps; resample it first")
    return (times[1] - times[0]).total_seconds()
