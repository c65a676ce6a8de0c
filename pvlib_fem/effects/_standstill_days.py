"""
Sums of days, by which the days of a tracker that does not turn are found.

A standstill changes light by its direction: at some hours all of the beam is missing,
at the hour at which the tracker passes the angle nothing, and under clouds little. What
light that is lost evenly explains as well, as under snow that has not slid off, is no
evidence of a standstill.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pvlib_fem._statistics.extremes import as_normal, rounded_argmax

SIZES = (0.7, 1.3)  # shares: it stands as a whole, and the light is estimated
POSSIBLE = (0.5, 1.5)  # shares beyond which it is something else
SHORTEST = 3  # days
EVERY = 60  # days, up to which each length is tried
LONGER = 1.1  # ratio of longer lengths
LONGEST = 0.2  # of the days of a record
UNSEEN = 1e-6  # of a column's square; a smaller independent part counts as zero
NOTHING = 1.0  # twice the log-likelihood below which days at an edge show nothing
AS_GOOD = 3.84  # twice the log-likelihood by which 95 % of dates are as good
MOST_SURE = 6.0  # standard errors, beyond which a date is not surer
WEEK, FEWEST = 7, 8  # days of which others are compared, and how many of these
Day = int | np.ndarray  # number of a day among those that have rows, or of several


@dataclass(frozen=True, eq=False)
class Sums:
    """
    Sums of products before each day: of a standstill, and of an even loss of light.

    Attributes
    ----------
    scores : array, shape (2, days + 1)
        With the residual.
    squares : array, shape (3, days + 1)
        Of the standstill with itself and with the even loss, and of that with itself.
    known : array, shape (2, columns, days + 1)
        With the coefficients of the fit.
    """

    scores: np.ndarray
    squares: np.ndarray
    known: np.ndarray

    def between(self, first: Day, last: Day) -> "Sums":
        """The sums from one day until another, which is the first one after."""
        every = (part[..., last] - part[..., first] for part in vars(self).values())
        return Sums(*every)

    @property
    def given_fit(self) -> np.ndarray:
        """The squares, given the fit."""
        stands, even = self.known
        products = stands * stands, stands * even, even * even
        return self.squares - np.array([np.sum(one, axis=0) for one in products])

    @property
    def plain(self) -> tuple[np.ndarray, np.ndarray]:
        """Products of the standstill with residual and itself, given the fit."""
        return self.scores[0], independent_part(self.given_fit[0], self.squares[0])

    @property
    def directed(self) -> tuple[np.ndarray, np.ndarray]:
        """Products with residual and itself, given an even loss of light, too."""
        own, both, even = self.given_fit
        even = independent_part(even, self.squares[2])
        alike = np.divide(both, even, out=np.zeros_like(even), where=even > 0.0)
        score = self.scores[0] - alike * self.scores[1]
        return score, independent_part(own - alike * both, self.squares[0])


def independent_part(independent: np.ndarray, square: np.ndarray) -> np.ndarray:
    """The independent part of a square; a small one counts as zero."""
    kept = independent > UNSEEN * np.maximum(square, 1e-12)
    return np.where(kept, independent, 0.0)


def square_reductions(
    score: np.ndarray, square: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """
    Fall of the sum of squares by a standstill, and its size.

    Parameters
    ----------
    score, square : array
        Its products with the residual and with itself. [K²]

    Returns
    -------
    fall, size : array
        [K²], [-]
    """
    score, square = np.asarray(score), np.asarray(square)
    size = np.divide(score, square, out=np.zeros_like(score), where=square > 0.0)
    likely = np.clip(size, *SIZES)
    most = 2.0 * likely * score - likely**2 * square
    return np.where((size > POSSIBLE[0]) & (size < POSSIBLE[1]), most, 0.0), size


@dataclass(frozen=True, eq=False)
class Days:
    """Daily sums of products with the residual and the coefficients of a fit."""

    rest: np.ndarray
    even: np.ndarray  # response to an even loss of light
    basis: np.ndarray  # rows by orthonormal columns
    first: np.ndarray  # row of each day
    dates: np.ndarray

    @classmethod
    def from_rows(
        cls, rest: np.ndarray, even: np.ndarray, basis: np.ndarray, day: np.ndarray
    ) -> "Days":
        dates = np.floor(day).astype(int)
        first = np.flatnonzero(np.diff(dates, prepend=dates[:1] - 1))
        return cls(rest, even, basis, first, dates[first])

    @property
    def lengths(self) -> np.ndarray:
        """Numbers of days that are tried."""
        most = int(LONGEST * len(self.dates))
        count = max(int(np.log(max(most / EVERY, 1.0)) / np.log(LONGER)), 0)
        longer = EVERY * LONGER ** np.arange(1, count + 1)
        every = np.arange(SHORTEST, min(EVERY, most) + 1)
        return np.unique(np.append(every, longer.astype(int)))

    def sums(self, tangent: np.ndarray) -> Sums:
        """Sums of products of a tangent, and of an even loss, before each day."""
        even = self.even
        return Sums(
            self.before([tangent * self.rest, even * self.rest]),
            self.before([tangent**2, tangent * even, even**2]),
            np.stack([self.before(self.basis.T * one) for one in (tangent, even)]),
        )

    def before(self, products: Sequence[np.ndarray] | np.ndarray) -> np.ndarray:
        """Sums of some products before each day, and of all."""
        daily = np.add.reduceat(np.asarray(products), self.first, axis=1)
        return np.pad(daily, [(0, 0), (1, 0)]).cumsum(axis=1)

    def best(self, total: Sums, lengths: np.ndarray) -> tuple[float, int, int]:
        """
        The best standstill of some lengths: its fall, first day, first day after.

        Light that is lost evenly, by snow or dirt, is no evidence of a standstill.
        """
        best = (0.0, 0, 0)
        for length in lengths.tolist():
            first = np.arange(len(self.dates) - length + 1)
            reductions, _ = square_reductions(
                *total.between(first, first + length).directed
            )
            at = rounded_argmax(reductions)
            if reductions[at] > best[0]:
                best = float(reductions[at]), at, at + length
        return best

    def errors(self, total: Sums, first: int, last: int, way: str) -> float:
        """
        Size in standard errors, from the size of the same plane on other days.

        The errors are of weeks, with the correlation of successive ones.

        Parameters
        ----------
        total : Sums
        first, last : int
            Numbers of the first day, and of the first day after it.
        way : str
            ``"plain"``, or ``"directed"`` for the size given an even loss of light.
        """
        length = min(last - first, WEEK)
        before = np.arange(first - length, -1, -length)[::-1]
        others = np.append(before, np.arange(last, len(self.dates) - length, length))
        each, own = total.between(others, others + length), total.between(first, last)
        score, square = getattr(own, way)
        _, size = square_reductions(score, square)
        # without what the coefficients have taken of the standstill
        taken = np.einsum("c,sco->so", own.known[0], each.known)
        each = Sums(each.scores + size * taken, each.squares, each.known)
        scores, squares = getattr(each, way)
        chance = scores / np.sqrt(np.maximum(squares, 1e-300))
        if len(others) < FEWEST or not chance.any():
            return 0.0
        memory = max(float(np.corrcoef(chance[1:], chance[:-1])[0, 1]), 0.0)
        wider = (1.0 + memory) / max(1.0 - memory, 1e-3)
        noise = np.sqrt(max(float(square), 1e-300) * wider * np.mean(chance**2))
        return as_normal(score / noise, max(len(others) / wider, 1.0))

    def edges(
        self, total: Sums, first: int, last: int, errors: float
    ) -> tuple[int, int, tuple[int, int], tuple[int, int]]:
        """
        The first day, the first day after it, and the intervals of both.

        Days at an edge that show nothing, as dull ones, are not in it: beyond them may
        be days without rows, as those of test weeks, of which nothing is known.
        """
        begins, ends = np.arange(last), np.arange(first + 1, len(self.dates) + 1)
        reductions, _ = square_reductions(
            *total.between(begins, np.full(len(begins), last)).plain
        )
        shortfall = 1.0 - reductions / reductions.max()
        start = int(self.dates[begins[shortfall * errors**2 <= NOTHING][-1]])
        good = begins[shortfall * min(errors, MOST_SURE) ** 2 <= AS_GOOD]
        before = self.dates[good[0] - 1] + 1 if good[0] else self.dates[0]
        began = int(before), int(self.dates[good[-1]])
        reductions, _ = square_reductions(
            *total.between(np.full(len(ends), first), ends).plain
        )
        shortfall = 1.0 - reductions / reductions.max()
        end = int(self.dates[ends[shortfall * errors**2 <= NOTHING][0] - 1]) + 1
        good = ends[shortfall * min(errors, MOST_SURE) ** 2 <= AS_GOOD]
        after = np.append(self.dates, self.dates[-1] + 1)[good[-1]]
        ended = int(self.dates[good[0] - 1]) + 1, int(after)
        return start, max(end, start + 1), began, ended
