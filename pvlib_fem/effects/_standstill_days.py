"""
Sums of days, by which the days of a tracker that does not turn are found.

A standstill changes light by its direction: at some hours all of the beam is missing,
at the hour at which the tracker passes the angle nothing, and under clouds little. A
cover, as snow, takes light evenly, until it slides off or from when it falls. What a
cover of the same day explains as well is no evidence of a standstill.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pvlib_fem._statistics.extremes import as_normal, rounded_argmax

SIZES = (0.7, 1.3)  # shares: it stands as a whole, and the light is estimated
SHORTEST = 2  # days: the size that one shows has to hold on another
EVERY = 60  # days, up to which each length is tried
LONGER = 1.1  # ratio of longer lengths
LONGEST = 0.2  # of the days of a record
UNSEEN = 1e-6  # of a column's square; a smaller independent part counts as zero
NOTHING = 1.0  # twice the log-likelihood below which days at an edge show nothing
AS_GOOD = 3.84  # twice the log-likelihood by which 95 % of dates are as good
MOST_SURE = 6.0  # standard errors, beyond which a date is not surer
MOST_MEMORY = 0.99  # correlation of successive weeks
WEEK, FEWEST = 7, 8  # days of which others are compared, and how many of these
SECONDS, HOURS = 86400, 24  # of a day
Day = int | np.ndarray  # number of a day among those that have rows, or of several


@dataclass(frozen=True, eq=False)
class Sums:
    """
    Sums of products of the part of a response that is looked at, before each day.

    Attributes
    ----------
    score : array, shape (days + 1,)
        With the residual.
    square : array, shape (days + 1,)
        With itself.
    known : array, shape (columns, days + 1)
        With the coefficients of the fit.
    taken : array, shape (columns, days + 1)
        Products of the whole response with them, of which they have taken a part.
    """

    score: np.ndarray
    square: np.ndarray
    known: np.ndarray
    taken: np.ndarray

    def between(self, first: Day, last: Day) -> "Sums":
        """The sums from one day until another, which is the first one after."""
        every = (part[..., last] - part[..., first] for part in vars(self).values())
        return Sums(*every)

    @property
    def square_given_fit(self) -> np.ndarray:
        """Of the part without what the coefficients explain of it. [K²]"""
        return independent_part(
            self.square - np.sum(self.known**2, axis=0), self.square
        )

    @property
    def response(self) -> np.ndarray:
        """Score for a whole response of size 1 that the fit did not know. [K²]"""
        kept = self.square - np.sum(self.known * self.taken, axis=0)
        return independent_part(kept, self.square)

    def reductions(self, first: Day, last: Day) -> np.ndarray:
        """Fall of the sum of squares if it is from one day until another. [K²]"""
        there = self.between(first, last)
        size = ratio(there.score, there.response)
        possible = (size > SIZES[0]) & (size < SIZES[1])
        return np.where(possible, size * there.score, 0.0)


def ratio(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Ratio of two arrays; 0 where the other one is not positive."""
    one, other = np.asarray(one), np.asarray(other)
    return np.divide(one, other, out=np.zeros_like(one), where=other > 0.0)


def without_covers(
    tangent: np.ndarray, even: np.ndarray, covers: np.ndarray
) -> np.ndarray:
    """
    The part of a response that no even loss of light explains within a cover.

    Parameters
    ----------
    tangent, even : array, shape (rows,)
        Response to a standstill, and to light that is lost evenly. [K]
    covers : array of int, shape (rows,)
        From :meth:`Days.covers`.

    Returns
    -------
    array, shape (rows,)
        [K]
    """
    both, square = (np.bincount(covers, even * one) for one in (tangent, even))
    return tangent - ratio(both, square)[covers] * even


def sum_inflation(memory: float, count: float) -> float:
    """
    Variance of a sum of correlated values, divided by that of independent ones.

    Parameters
    ----------
    memory : float
        Correlation of successive values of a first-order autoregression.
    count : float
        Number of values, at least 1; need not be whole.

    Returns
    -------
    float
        From 1 of a single value to (1 + memory) / (1 - memory) of many.
    """
    lags = np.arange(1, int(np.ceil(count)))
    return float(1.0 + 2.0 * np.sum((1.0 - lags / count) * memory**lags))


def independent_part(independent: np.ndarray, square: np.ndarray) -> np.ndarray:
    """The independent part of a square; a small one counts as zero."""
    kept = independent > UNSEEN * np.maximum(square, 1e-12)
    return np.where(kept, independent, 0.0)


@dataclass(frozen=True, eq=False)
class Days:
    """Daily sums of products with the residual and the coefficients of a fit."""

    rest: np.ndarray
    basis: np.ndarray  # rows by orthonormal columns
    times: np.ndarray  # of each row [s]
    first: np.ndarray  # row of each day
    dates: np.ndarray

    @classmethod
    def from_rows(cls, rest: np.ndarray, basis: np.ndarray, day: np.ndarray) -> "Days":
        times = np.round(np.asarray(day) * SECONDS).astype(int)
        dates = times // SECONDS
        first = np.flatnonzero(np.diff(dates, prepend=dates[:1] - 1))
        return cls(rest, basis, times, first, dates[first])

    @property
    def lengths(self) -> np.ndarray:
        """Numbers of days that are tried."""
        most = int(LONGEST * len(self.dates))
        count = max(int(np.log(max(most / EVERY, 1.0)) / np.log(LONGER)), 0)
        longer = EVERY * LONGER ** np.arange(1, count + 1)
        every = np.arange(SHORTEST, min(EVERY, most) + 1)
        return np.unique(np.append(every, longer.astype(int)))

    def covers(self, even: np.ndarray) -> np.ndarray:
        """
        Number of the cover of each row: until an hour of its day, or from it on.

        The hour is that at which two even losses of light explain most of the day.

        Parameters
        ----------
        even : array, shape (rows,)
            Response to light that is lost evenly. [K]

        Returns
        -------
        array of int, shape (rows,)
        """
        day = np.repeat(
            np.arange(len(self.dates)), np.diff(self.first, append=len(even))
        )
        hour = self.times % SECONDS * HOURS // SECONDS
        shape = len(self.dates), HOURS
        score, square = (
            np.bincount(day * HOURS + hour, even * one, minlength=np.prod(shape))
            .reshape(shape)
            .cumsum(axis=1)
            for one in (self.rest, even)
        )
        explained = ratio(score**2, square)
        explained += ratio((score[:, -1:] - score) ** 2, square[:, -1:] - square)
        return 2 * day + (hour > np.argmax(explained, axis=1)[day])

    def sums(self, tangent: np.ndarray, part: np.ndarray | None = None) -> Sums:
        """Sums of products of a tangent, or of a part of it, before each day."""
        taken = self.before(self.basis.T * tangent)
        if part is None:
            part, known = tangent, taken
        else:
            known = self.before(self.basis.T * part)
        score, square = self.before([part * self.rest, part**2])
        return Sums(score, square, known, taken)

    def before(self, products: Sequence[np.ndarray] | np.ndarray) -> np.ndarray:
        """Sums of some products before each day, and of all."""
        daily = np.add.reduceat(np.asarray(products), self.first, axis=1)
        return np.pad(daily, [(0, 0), (1, 0)]).cumsum(axis=1)

    def best(self, total: Sums, lengths: np.ndarray) -> tuple[float, int, int]:
        """The best standstill of some lengths: its fall, first day, first day after."""
        best = (0.0, 0, 0)
        for length in lengths.tolist():
            first = np.arange(len(self.dates) - length + 1)
            reductions = total.reductions(first, first + length)
            at = rounded_argmax(reductions)
            if reductions[at] > best[0]:
                best = float(reductions[at]), at, at + length
        return best

    def errors(self, total: Sums, first: int, last: int) -> float:
        """
        Size in standard errors, from the size of the same plane on other days.

        The errors are of weeks. Those of successive weeks are correlated: a sum of a
        few weeks varies more than weeks without memory, but less than a long one.

        Parameters
        ----------
        total : Sums
        first, last : int
            Numbers of the first day, and of the first day after it.
        """
        length = min(last - first, WEEK)
        before = np.arange(first - length, -1, -length)[::-1]
        others = np.append(before, np.arange(last, len(self.dates) - length, length))
        each, own = total.between(others, others + length), total.between(first, last)
        # without what the coefficients have taken of the standstill
        taken = ratio(own.score, own.response) * (own.taken @ each.known)
        chance = ratio(each.score + taken, np.sqrt(each.square_given_fit))
        if len(others) < FEWEST or not chance.any():
            return 0.0
        memory = np.clip(np.corrcoef(chance[1:], chance[:-1])[0, 1], 0.0, MOST_MEMORY)
        wider = sum_inflation(float(memory), (last - first) / length)
        noise = np.sqrt(own.square_given_fit * wider * np.mean(chance**2))
        # of squares, the correlation is the square (Bartlett 1946)
        draws = len(others) * (1.0 - memory**2) / (1.0 + memory**2)
        return as_normal(ratio(own.score, noise), max(float(draws), 1.0))

    def edges(
        self, total: Sums, first: int, last: int, errors: float
    ) -> tuple[int, int, tuple[int, int], tuple[int, int]]:
        """
        The first day, the first day after it, and the intervals of both.

        Days at an edge that show nothing, as dull ones, are not in it: beyond them may
        be days without rows, as those of test weeks, of which nothing is known.
        """
        begins, ends = np.arange(last), np.arange(first + 1, len(self.dates) + 1)
        reductions = total.reductions(begins, np.full(len(begins), last))
        shortfall = 1.0 - reductions / reductions.max()
        start = int(self.dates[begins[shortfall * errors**2 <= NOTHING][-1]])
        good = begins[shortfall * min(errors, MOST_SURE) ** 2 <= AS_GOOD]
        before = self.dates[good[0] - 1] + 1 if good[0] else self.dates[0]
        began = int(before), int(self.dates[good[-1]])
        reductions = total.reductions(np.full(len(ends), first), ends)
        shortfall = 1.0 - reductions / reductions.max()
        end = int(self.dates[ends[shortfall * errors**2 <= NOTHING][0] - 1]) + 1
        good = ends[shortfall * min(errors, MOST_SURE) ** 2 <= AS_GOOD]
        after = np.append(self.dates, self.dates[-1] + 1)[good[-1]]
        ended = int(self.dates[good[0] - 1]) + 1, int(after)
        return start, max(end, start + 1), began, ended
