"""Noise of means over stretches of hours, and what the rest of the day explains."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

NORMAL = 1.4826  # standard deviation over median absolute deviation
FEWEST_HOURS = 2  # of a day beside a stretch, for a mean of them
FEWEST_DAYS = 30  # with the same hours: a standard deviation is then within 15 %


def spread_of(values: np.ndarray) -> float:
    """Standard deviation by the median absolute deviation."""
    return NORMAL * float(np.median(np.abs(values - np.median(values))))


@dataclass(frozen=True, eq=False)
class Noise:
    """Noise of means over hours."""

    values: np.ndarray
    known: dict = field(default_factory=dict)

    def std_of_mean(self, hours: int) -> float:
        """Standard deviation of a mean over so many hours, by the median."""
        if hours not in self.known:
            self.known[hours] = np.inf
            if len(self.values) > hours:
                total = np.concatenate(([0.0], np.cumsum(self.values)))
                self.known[hours] = spread_of((total[hours:] - total[:-hours]) / hours)
        return self.known[hours]


@dataclass(frozen=True, eq=False)
class DayNoise:
    """
    A residual by day and hour, whose errors last for hours and days.

    Attributes
    ----------
    values : array
        Residual of each hour with light. [K]
    number : array of int
        Number of the hour, since 1970-01-01.
    usual : array of bool
        Hours on which nothing is suspected.
    """

    values: np.ndarray
    number: np.ndarray
    usual: np.ndarray

    @cached_property
    def noise(self) -> Noise:
        """Noise of hours in a row."""
        return Noise(self.values)

    @cached_property
    def days(self) -> np.ndarray:
        """Usual hours in a table of days by hours of the day; else NaN. [K]"""
        rows, clock = self.row, self.number % 24
        table = np.full((rows.max() + 1, 24), np.nan)
        table[rows[self.usual], clock[self.usual]] = self.values[self.usual]
        return table

    @cached_property
    def row(self) -> np.ndarray:
        """Row of each hour in the table of days."""
        return np.unique(self.number // 24, return_inverse=True)[1]

    def beyond(self, some: slice) -> tuple[float, float]:
        """
        Mean of a stretch of hours of one day beyond its expectation, and its noise.

        The mean of the usual hours of the same day gives the expectation, in the
        proportion that the same hours of other days have. Their deviations from it are
        the noise. With too few such hours or days, the expectation is 0. [K]
        """
        size, hours = float(self.values[some].mean()), self.number[some] % 24
        table, own = self.days, self.days[self.row[some.start]]
        same = table[:, hours].mean(axis=1)
        rest = np.setdiff1d(np.flatnonzero(np.isfinite(own)), hours)
        if len(rest) >= FEWEST_HOURS:
            around = table[:, rest].mean(axis=1)
            there = np.isfinite(same + around)
            if there.sum() >= FEWEST_DAYS:
                same, around = same[there], around[there]
                share = float(same @ around / (around @ around))
                expected = share * float(own[rest].mean())
                return size - expected, spread_of(same - share * around)
        same = same[np.isfinite(same)]
        if len(same) >= FEWEST_DAYS:
            return size, spread_of(same)
        return size, self.noise.std_of_mean(some.stop - some.start)
