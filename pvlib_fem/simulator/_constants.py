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


def stream(seed: int, purpose: str) -> np.random.Generator:
    """Random numbers of one purpose, independent of all others."""
    return np.random.default_rng([seed, zlib.crc32(purpose.encode())])


def wander(random: np.random.Generator, rows: int, lag: float) -> np.ndarray:
    """Ornstein-Uhlenbeck noise of unit variance, correlated over ``lag`` rows."""
    decay = np.exp(-1.0 / lag)
    source = random.standard_normal(rows)
    source[1:] *= np.sqrt(1.0 - decay**2)
    return lfilter([1.0], [1.0, -decay], source)


def lagged(values: np.ndarray, lag: float) -> np.ndarray:
    """First-order response with a time constant of ``lag`` rows, from steady state."""
    decay = np.exp(-1.0 / lag)
    return lfilter([1.0 - decay], [1.0, -decay], values, zi=[decay * values[0]])[0]


def clock(times: pd.DatetimeIndex) -> tuple[np.ndarray, np.ndarray]:
    """Hour of the day and day of the year, both with their fraction."""
    hour = (times - times.normalize()).total_seconds().to_numpy() / 3600.0
    return hour, times.day_of_year.to_numpy() + hour / 24.0


def winter(site: "Site", day: np.ndarray) -> np.ndarray:
    """1 in midwinter, −1 in midsummer."""
    return np.sign(site.latitude or 1.0) * np.cos(2 * np.pi * (day - 15) / 365.25)


def times_of(rows: pd.DataFrame) -> pd.DatetimeIndex:
    """The times of rows."""
    return pd.DatetimeIndex(rows.index)


def seconds(times: pd.DatetimeIndex) -> float:
    """The even step of a time axis. [s]"""
    steps = np.diff(times.asi8)
    if len(steps) == 0 or (steps != steps[0]).any():
        raise ValueError("weather is not on even steps; resample it first")
    return (times[1] - times[0]).total_seconds()
