"""How light each time of each day is: what is day by it, and what is night."""

import numpy as np
import pandas as pd
from scipy.ndimage import maximum_filter1d

from pvlib_fem._record.clean import CleanRecord
from pvlib_fem.quality._limits import Limits

#: at the equator, and anywhere in winter, the day ends within that from noon [days]
HALF_DAY = 0.25
NEAR = 3  # parts of a day on either side that are taken with one
LIT = 0.25  # share of their rows from which they are lit
FEWEST = 3  # days around that have rows then


class LightTable:
    """
    How light each time of each day is, from blocks of a record.

    Parameters
    ----------
    days : array of int, shape (days,)
        Sorted days with rows, since 1970-01-01.
    limits : Limits
        ``daylight_tolerance`` is the length of a part of the day.
    """

    def __init__(self, days: np.ndarray, limits: Limits) -> None:
        self.limits = limits
        self.parts = int(np.ceil(86400.0 / limits.daylight_tolerance))
        self.days = days
        self.row = packed(days, max(limits.noon_window, limits.daylight_window))
        shape = self.row[-1] + 1, self.parts
        self.known, self.lit, self.sum = (np.zeros(shape) for _ in "abc")

    def places(self, index: pd.DatetimeIndex) -> np.ndarray:
        """Day and time of day of each row, as one number."""
        day, part = slots(index, self.limits)
        return self.row[np.searchsorted(self.days, day)] * self.parts + part

    def add(self, index: pd.DatetimeIndex, poa: np.ndarray) -> None:
        """Look at the next rows."""
        there = np.isfinite(poa)
        place, poa = self.places(index)[there], poa[there]
        weights = None, poa > self.limits.min_light, poa
        for table, weight in zip((self.known, self.lit, self.sum), weights):
            sums = np.bincount(place, weight, table.size)
            table += sums.reshape(table.shape)

    @property
    def mean(self) -> np.ndarray:
        """Mean irradiance; 0 where nothing is known. [W/m²]"""
        return self.sum / np.maximum(self.known, 1.0)

    def sunny(self) -> np.ndarray:
        """Whether one of the days around is sunny then, by that number."""
        days = 2 * self.limits.daylight_window + 1
        most = maximum_filter1d(self.mean, days, axis=0, mode="constant")
        return (most > self.limits.min_sunny_irradiance).ravel()

    def dark(self) -> np.ndarray:
        """Whether light is an accident then, by that number."""
        known, lit = with_adjacent(self.known), with_adjacent(self.lit)
        there = known > 0
        lit = there & (lit > LIT * known)
        # a clock that was set for some days has many such nights, and its own are lit
        seldom = (
            share_around(lit, there, self.limits.noon_window)
            <= self.limits.max_lit_night_share
        )
        seldom &= share_around(lit, there, self.limits.daylight_window) < 0.5
        return (seldom & self.far_from_noon()).ravel()

    def far_from_noon(self) -> np.ndarray:
        """Whether a time of a day is more than a quarter of a day from its noon."""
        part = (np.arange(self.parts) + 0.5) / self.parts
        turn = sums_around(self.mean, self.limits.noon_window) @ np.exp(
            2j * np.pi * part
        )
        noon = np.angle(turn) / (2.0 * np.pi)
        far = np.abs((part - noon[:, None] + 0.5) % 1.0 - 0.5)
        return far > HALF_DAY + 1.0 / self.parts


def slots(index: pd.DatetimeIndex, limits: Limits) -> tuple[np.ndarray, np.ndarray]:
    """
    Number of each row's day, and of its part of the day.

    Parameters
    ----------
    index : pandas.DatetimeIndex, shape (rows,)
        Of a zone the wall times count.
    limits : Limits
        ``daylight_tolerance`` is the length of a part.

    Returns
    -------
    day : numpy.ndarray of int, shape (rows,)
        Days since 1970-01-01.
    part : numpy.ndarray of int, shape (rows,)
        From 0 at midnight.
    """
    local = (index if index.tz is None else index.tz_localize(None)).to_numpy()
    counts = local.view("i8")
    length = np.timedelta64(1, "D") // np.timedelta64(1, index.unit)
    day = counts // length
    part = limits.daylight_tolerance * length / 86400.0
    return day, ((counts - day * length) / part).astype(int)


def packed(days: np.ndarray, side: int) -> np.ndarray:
    """
    Number days anew, with gaps no longer than a window reaches.

    A table of these numbers has few rows for a record with a stray time, which can be
    millennia from all others.

    Parameters
    ----------
    days : numpy.ndarray of int, shape (n,)
        Sorted days, such as those of :func:`slots`.
    side : int
        Days on each side of a window. [days]

    Returns
    -------
    numpy.ndarray of int, shape (n,)
        From 0. Days that are up to ``side`` days apart stay so, and others are at least
        one more.
    """
    gaps = np.diff(days, prepend=days[:1])
    return np.cumsum(np.minimum(gaps, side + 1))


def with_adjacent(table: np.ndarray) -> np.ndarray:
    """Sums of a time of day and of the adjacent ones."""
    flat = np.cumsum(np.pad(table.ravel(), (NEAR + 1, NEAR)))
    return (flat[2 * NEAR + 1 :] - flat[: -2 * NEAR - 1]).reshape(table.shape)


def sums_around(table: np.ndarray, side: int) -> np.ndarray:
    """Sums over some days before and after, and the day itself."""
    whole = np.cumsum(np.pad(table, ((side + 1, side), (0, 0))), axis=0)
    return whole[2 * side + 1 :] - whole[: -2 * side - 1]


def share_around(lit: np.ndarray, there: np.ndarray, side: int) -> np.ndarray:
    """Share of lit ones of the days around, each without itself; NaN of few."""
    number = sums_around(there.astype(float), side) - there
    many = sums_around(lit.astype(float), side) - lit
    return np.divide(
        many, number, out=np.full(lit.shape, np.nan), where=number >= FEWEST
    )


def light_by_night(
    clean: CleanRecord, days: np.ndarray, step: float, limits: Limits
) -> list:
    """
    Rows of light by night, each with its time and value, of a record's blocks.

    Parameters
    ----------
    clean : CleanRecord
        With ``poa_global``.
    days : array of int, shape (days,)
        Sorted days with rows, since 1970-01-01.
    step : float
        Usual time between rows; none is found where it is long. [s]
    limits : Limits
        Thresholds of light by night.

    Returns
    -------
    list of tuple of array, shape (n,)
        Numbers, times and values [W/m²] of the rows of each block; empty without any.
    """
    if step > limits.max_noon_step:
        return []
    nights = LightTable(days, limits)
    for block in clean.blocks(("poa_global",)):
        nights.add(block.index, block["poa_global"])
    dark, parts = nights.dark(), []
    if not (nights.lit.ravel()[dark] > 0).any():
        return []
    for block in clean.blocks(("poa_global",)):
        poa = block["poa_global"]
        rows = np.flatnonzero(poa > limits.min_light)
        rows = rows[dark[nights.places(block.index[rows])]]
        parts.append((rows + block.start, block.times[rows], poa[rows]))
    return parts
