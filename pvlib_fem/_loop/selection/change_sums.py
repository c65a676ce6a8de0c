"""Sums of daily products, by which changes between any two days are compared."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pvlib_fem._statistics.extremes import rounded_argmax
from pvlib_fem.effects._time_profiles import YEAR

#: dates between which temporary changes, and trends that end, are looked for first
GRID, SPARSE = 60, 30
SHORTEST = 7  # days of a temporary change: a week
UNSEEN = 1e-6  # of a column's square: less of it is nothing given the others
#: relative error of a time profile: no sensor fades along an exact line
PROFILE_ERROR = 0.1
MOST_RESETS, RESETS_A_YEAR = 12, 2  # of a trend
AGES = 13  # of a trend on the first day of a record, that are tried
DAYS_ALIKE = 8.0 / 3.0  # over z²: share of a record's dates that are as good as one


@dataclass(frozen=True)
class Span:
    """Days of a change, as places, and how far it lets the sum of squares fall."""

    first: int
    last: int  # first day after it
    fall: float
    resets: tuple[int, ...] = ()  # days on which a trend begins again from 0
    before: float = 0.0  # years before the record in which it began

    def dates(self, days: int) -> int:
        """Number of its dates that were looked for in a record of so many days."""
        ends = int(self.first > 0) + int(self.last < days)
        return ends + len(self.resets) + int(self.before > 0.0)


@dataclass(frozen=True, eq=False)
class ChangeSums:
    """Sums of daily products of a column, of which each change takes a part."""

    #: products with the remaining error, with itself, and with the given columns, of
    #: which each is independent of the others, shape (days, columns + 2)
    table: np.ndarray
    years: np.ndarray  # begin of each day since the first one
    low: float  # sign of the least size that the change can have
    high: float  # and of the largest

    @cached_property
    def sums(self) -> np.ndarray:
        """Sums before each day."""
        return before_each(self.table)

    @cached_property
    def moments(self) -> tuple[np.ndarray, np.ndarray]:
        """Sums before each day, plain and times years; squares times years squared."""
        middle = self.years[:, None] + 0.5 / YEAR
        squares = self.table[:, 1:2] * middle**2
        both = np.stack([self.sums, before_each(self.table * middle)], axis=1)
        return both, before_each(squares)[:, 0]

    def constant(self, first: np.ndarray, last: np.ndarray) -> np.ndarray:
        """Falls of the sum of squares by changes from some days until before others."""
        return self.square_falls(self.sums[last] - self.sums[first])

    def linear(self, first: np.ndarray, last: np.ndarray) -> np.ndarray:
        """Falls of the sum of squares by trends from some days until before others."""
        return self.square_falls(self.increase(first, last))

    def increase(
        self, first: np.ndarray, last: np.ndarray, before: float | np.ndarray = 0.0
    ) -> np.ndarray:
        """Sums of a trend from some days until before others, begun years before."""
        begin, (both, squares) = self.years[first][:, None] - before, self.moments
        between = both[last] - both[first]
        plain, mean = between[:, 0], between[:, 1]
        parts = mean - begin * plain
        begin, square = begin[..., 0], squares[last] - squares[first]
        parts[..., 1] = square - begin * (2.0 * mean[:, 1] - begin * plain[:, 1])
        return parts

    def simplest(self, spans: Sequence[Span]) -> Span:
        """The span that explains most, less what its dates cost."""
        most, sure = max(max(one.fall for one in spans), 1e-12), 1.0 / PROFILE_ERROR

        def worth(one: Span) -> float:
            cost = dates_cost(one.dates(len(self.table)), sure)
            return 0.5 * sure**2 * one.fall / most - cost

        return max(spans, key=worth)

    def with_resets(self, side: int) -> Span | None:
        """
        The best trend of the whole record that begins again from 0 at some dates.

        Dates are added one by one, each where it explains most, at least ``side`` days
        apart. Of these trends, the simplest is taken.
        """
        days = len(self.table)
        grid = np.unique(np.linspace(0, days, min(GRID, days)).astype(int))
        span, spans = Span(0, days, 0.0), []
        for _ in range(min(MOST_RESETS, int(self.years[-1] * RESETS_A_YEAR))):
            place = self.best_reset(span, grid, side)
            if place is None:
                break
            span = self.begun_before(tuple(sorted([*span.resets, place])))
            spans.append(span)
        if not spans:
            return None
        span = self.in_place(self.simplest(spans), side)
        if len(span.resets) == 1:
            return span
        fewer = [without(span.resets, one) for one in span.resets]
        return self.simplest([span, *map(self.begun_before, fewer)])

    def teeth(self, resets: Sequence[int], before: float | np.ndarray) -> np.ndarray:
        """Sums of a trend with some resets, begun some years before the record."""
        edges = np.array([0, *resets, len(self.table)])
        first = self.increase(edges[:1], edges[1:2], np.asarray(before)[..., None])
        return first + self.increase(edges[1:-1], edges[2:]).sum(axis=0)

    def best_reset(self, span: Span, some: np.ndarray, side: int) -> int | None:
        """The day at which one more reset of a trend explains most, or None."""
        edges = np.array([0, *span.resets, len(self.table)])
        after = np.searchsorted(edges, some, side="right")
        within = after < len(edges)
        some, low, high = some[within], edges[after[within] - 1], edges[after[within]]
        far = (some - low >= side) & (high - some >= side)
        some, low, high = some[far], low[far], high[far]
        if not len(some):
            return None
        before = np.where(low == 0, span.before, 0.0)[:, None]
        parts = self.teeth(span.resets, span.before) - self.increase(low, high, before)
        parts = parts + self.increase(low, some, before) + self.increase(some, high)
        return int(some[np.argmax(self.square_falls(parts))])

    def begun_before(self, resets: tuple[int, ...]) -> Span:
        """A trend with some resets, as old on the first day as explains most."""
        edges = np.array([0, *resets, len(self.table)])
        longest = np.diff(edges).max() / YEAR
        before = longest * np.linspace(0.0, 1.0, AGES)
        falls = self.square_falls(self.teeth(resets, before[:, None])[:, 0])
        at = rounded_argmax(falls)
        return Span(0, len(self.table), float(falls[at]), resets, float(before[at]))

    def in_place(self, span: Span, side: int) -> Span:
        """The trend with each reset where it explains most given the others."""
        every = np.arange(len(self.table))
        for _ in range(2):
            before = span
            for reset in span.resets:
                others = without(span.resets, reset)
                left = replace(span, resets=others)
                near = every[abs(every - reset) <= len(every) // GRID + 1]
                place = self.best_reset(left, near, side)
                if place is not None:
                    span = replace(span, resets=tuple(sorted([*others, place])))
            span = self.begun_before(span.resets)
            if span.resets == before.resets:
                break
        return span

    def square_falls(self, parts: np.ndarray) -> np.ndarray:
        """Fall of the sum of squares by a column of such sums, with a possible sign."""
        return parts[..., 0] * self.sizes(parts)

    def sizes(self, parts: np.ndarray) -> np.ndarray:
        """Size of a change along a column of such sums; 0 if its sign is impossible."""
        score, square, shared = parts[..., 0], parts[..., 1], parts[..., 2:]
        beyond = square - np.einsum("...i,...i->...", shared, shared)
        allowed = (score > 0) & (self.high > 0) | (score < 0) & (self.low < 0)
        good = allowed & (beyond > UNSEEN * np.maximum(square, 1e-12))
        return np.where(good, score / np.where(good, beyond, 1.0), 0.0)

    def best(
        self,
        falls: Callable[[np.ndarray, np.ndarray], np.ndarray],
        first: np.ndarray,
        last: np.ndarray,
    ) -> Span:
        """The best of some changes by :meth:`constant` or :meth:`linear`."""
        each = falls(first, last)
        at = int(np.argmax(each))
        begin, end = (days[at if len(days) > 1 else 0] for days in (first, last))
        return Span(int(begin), int(end), float(each[at]))

    def inside(
        self,
        falls: Callable[[np.ndarray, np.ndarray], np.ndarray],
        side: int,
        least: int,
        many: int,
    ) -> Span | None:
        """
        The best change that begins and ends within the record, or None.

        Before and after it are ``side`` days at least, and within it ``least``.
        ``many`` dates are tried first.
        """
        days = len(self.table)
        grid = np.unique(np.linspace(0, days, min(many, days)).astype(int))
        first, last = grid[np.column_stack(np.triu_indices(len(grid), 1))].T
        length = last - first
        # enough days have to be there without it, too; and one that begins or ends
        # with the record is a step
        good = (first >= side) & (last <= days - side)
        good &= (length >= least) & (length <= days - side)
        if not good.any():
            return None
        span = self.best(falls, first[good], last[good])
        if not span.fall > 0:
            return None
        for _ in range(3):
            before = span
            firsts = np.arange(side, span.last - least + 1)
            span = self.best(falls, firsts, np.array([span.last]))
            lasts = np.arange(span.first + least, days - side + 1)
            span = self.best(falls, np.array([span.first]), lasts)
            if span == before:
                break
        return span


def without(resets: tuple[int, ...], reset: int) -> tuple[int, ...]:
    """Some resets without one of them."""
    return tuple(one for one in resets if one != reset)


def before_each(table: np.ndarray) -> np.ndarray:
    """Sums of the rows of a table before each row, and of all."""
    return np.vstack([np.zeros(table.shape[1]), np.cumsum(table, axis=0)])


def dates_cost(dates: int, sure: float) -> float:
    """
    What dates cost: minus the logarithm of the share of dates that are as good.

    Away from its date a step loses what it explains in proportion to the days, so that
    of the days on one side a share of 8/z² is as good, by Laplace.

    Parameters
    ----------
    dates : int
        Number of dates.
    sure : float
        Standard errors z by which the size differs from nothing.

    Returns
    -------
    float
    """
    return dates * max(float(np.log(sure**2 / DAYS_ALIKE)), 0.0)
