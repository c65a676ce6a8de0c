"""Dates of steps, trends and temporary changes that the remaining error shows best."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Self

import numpy as np

from pvlib_fem._statistics.weekly_sums import coefficients_from, with_ridge
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import YEAR, date_text, day_number, is_drift

if TYPE_CHECKING:
    from pvlib_fem._loop.design import Changed, Column, Design

#: dates between which temporary changes, and trends that end, are looked for first
GRID, SPARSE = 60, 30
USUAL = 2.0  # times the median of the daily residuals: beyond it a day counts less
UNSEEN = 1e-6  # of a column's square: less of it is nothing given the others
MOST_SURE = 6.0  # standard errors, beyond which a date is not surer
#: relative error of a time profile: no sensor fades along an exact line
PROFILE_ERROR = 0.1
DAYS_ALIKE = 8.0 / 3.0  # over z²: share of a record's dates that are as good as one
DATES = "at", "start", "end"  # names of dates in the settings of a change
LIKELY = 3.84  # twice the log-likelihood by which 95 % of dates are as good


def number_of_dates(effect: Effect) -> int:
    """
    Number of dates of a change that were searched for.

    Parameters
    ----------
    effect : Effect
        Any; without a time profile it has none.

    Returns
    -------
    int
    """
    return sum(name in effect.settings for name in DATES if effect.sensor_fault)


@dataclass(frozen=True, eq=False)
class Scan:
    """Daily products with the residual given some columns, summed up to each date."""

    design: "Design"
    given: list["Column"]
    side: int
    solved: np.ndarray  # coefficients of the columns
    root: np.ndarray  # of the inverse of their products
    trust: np.ndarray  # of each day, 1 for usual ones

    @classmethod
    def from_design(
        cls, design: "Design", given: Sequence["Column"], side: int
    ) -> Self:
        columns = [*given]
        whole, trust = design.whole(columns), day_weights(design, columns)
        inverse = np.linalg.inv(np.linalg.cholesky(with_ridge(whole[1:, 1:])))
        return cls(design, columns, side, coefficients_from(whole), inverse.T, trust)

    def sums(self, place: int, low: float = -1.0, high: float = 1.0) -> "ChangeSums":
        """
        Products of a column with the remaining error and others, before each day.

        Parameters
        ----------
        place : int
            Of the column.
        low, high : float
            Signs of the least and the largest size that it can have.
        """
        rows = self.design.by_day(place, self.given) * self.trust[:, None]
        scores = rows[:, 0] - rows[:, 1:] @ self.solved
        squares = self.design.daily[:, place, place] * self.trust
        table = np.column_stack([scores, squares, rows[:, 1:] @ self.root])
        years = (self.design.dates - self.design.dates[0]) / YEAR
        return ChangeSums(table, years, low, high)

    def along(
        self, place: int, low: float, high: float
    ) -> Iterator[tuple[str, dict[str, str]]]:
        """
        Dates of the best step, temporary change and trends of a column.

        Parameters
        ----------
        place : int
            Of the column.
        low, high : float
            Signs of the least and the largest size that it can have.

        Yields
        ------
        time_profile : str
        dates : dict of str
            By name. There is always a trend of the whole record, and before it one of
            a part of it, if that explains more than its dates cost.
        """
        days, dates, side = len(self.design.dates), self.design.dates, self.side
        sums, last = self.sums(place, low, high), np.array([days])
        some = np.arange(side, days - side + 1)
        trends = [sums.best(sums.linear, np.array([0]), last)]
        if len(some):
            step = sums.best(sums.constant, some, last)
            if step.fall > 0:
                yield "step", {"at": date_text(dates[step.first])}
            trends.append(sums.best(sums.linear, some, last))
            trends.append(sums.best(sums.linear, np.array([0]), some))
        episode = sums.inside(sums.constant, side, GRID)
        if episode is not None:
            start = date_text(dates[episode.first])
            yield "episode", {"start": start, "end": self.day_after(episode)}
        inside = sums.inside(sums.linear, side, SPARSE)
        trend = simplest([*trends, inside] if inside else trends, days)
        if trend.dates(days):
            begin = {"start" if trend.first else "since": date_text(dates[trend.first])}
            end = {"end": self.day_after(trend)} if trend.last < days else {}
            yield "drift", begin | end
        yield "drift", {"since": date_text(dates[0])}

    def day_after(self, span: "Span") -> str:
        """The first day after the days of a change."""
        return date_text(self.design.dates[span.last - 1] + 1)


@dataclass(frozen=True)
class Span:
    """Days of a change, as places, and how far it lets the sum of squares fall."""

    first: int
    last: int  # first day after it
    fall: float

    def dates(self, days: int) -> int:
        """Number of its ends that are within a record of so many days."""
        return int(self.first > 0) + int(self.last < days)


def simplest(spans: Sequence[Span], days: int) -> Span:
    """The span that explains most, less what its dates cost."""
    most, sure = max(max(one.fall for one in spans), 1e-12), 1.0 / PROFILE_ERROR

    def worth(one: Span) -> float:
        return 0.5 * sure**2 * one.fall / most - dates_cost(one.dates(days), sure)

    return max(spans, key=worth)


@dataclass(frozen=True, eq=False)
class ChangeSums:
    """
    Sums of daily products of a column, of which changes between any days take parts.

    Attributes
    ----------
    table : array, shape (days, columns + 2)
        Products with the remaining error, with itself, and with the given columns, of
        which each is independent of the others.
    years : array, shape (days,)
        Begin of each day since the first one.
    low, high : float
        Signs of the least and the largest size that the change can have.
    """

    table: np.ndarray
    years: np.ndarray
    low: float
    high: float

    @cached_property
    def sums(self) -> np.ndarray:
        """Sums before each day."""
        return before_each(self.table)

    @cached_property
    def moments(self) -> tuple[np.ndarray, np.ndarray]:
        """Sums before each day times years, and of squares times years squared."""
        middle = self.years[:, None] + 0.5 / YEAR
        squares = self.table[:, 1:2] * middle**2
        return before_each(self.table * middle), before_each(squares)[:, 0]

    def constant(self, first: np.ndarray, last: np.ndarray) -> np.ndarray:
        """Falls of the sum of squares by changes from some days until before others."""
        return self.square_falls(self.sums[last] - self.sums[first])

    def linear(self, first: np.ndarray, last: np.ndarray) -> np.ndarray:
        """Falls of the sum of squares by trends from some days until before others."""
        begin, (means, squares) = self.years[first], self.moments
        plain, mean = self.sums[last] - self.sums[first], means[last] - means[first]
        parts = mean - begin[:, None] * plain
        square = squares[last] - squares[first]
        parts[:, 1] = square - begin * (2.0 * mean[:, 1] - begin * plain[:, 1])
        return self.square_falls(parts)

    def square_falls(self, parts: np.ndarray) -> np.ndarray:
        """Fall of the sum of squares by a column of such sums, with a possible sign."""
        score, square, shared = parts[..., 0], parts[..., 1], parts[..., 2:]
        beyond = square - np.square(shared).sum(axis=-1)
        allowed = (score > 0) & (self.high > 0) | (score < 0) & (self.low < 0)
        good = allowed & (beyond > UNSEEN * np.maximum(square, 1e-12))
        return np.where(good, score**2 / np.where(good, beyond, 1.0), 0.0)

    def best(
        self,
        falls: Callable[[np.ndarray, np.ndarray], np.ndarray],
        first: np.ndarray,
        last: np.ndarray,
    ) -> Span:
        """
        The best of some changes.

        Parameters
        ----------
        falls : callable
            :meth:`constant` or :meth:`linear`.
        first, last : array of int
            Of each change, or one for all.
        """
        first, last = np.broadcast_arrays(first, last)
        each = falls(first, last)
        at = int(np.argmax(each))
        return Span(int(first[at]), int(last[at]), float(each[at]))

    def inside(
        self,
        falls: Callable[[np.ndarray, np.ndarray], np.ndarray],
        side: int,
        many: int,
    ) -> Span | None:
        """
        The best change that begins and ends within the record, or None.

        Parameters
        ----------
        falls : callable
            :meth:`constant` or :meth:`linear`.
        side : int
            Least number of days of it, and before and after it.
        many : int
            Dates that are tried first.
        """
        days = len(self.table)
        grid = np.unique(np.linspace(0, days, min(many, days)).astype(int))
        first, last = grid[np.column_stack(np.triu_indices(len(grid), 1))].T
        length = last - first
        # enough days have to be there without it, too; and one that begins or ends
        # with the record is a step
        good = (first >= side) & (last <= days - side)
        good &= (length >= side) & (length <= days - side)
        if not good.any():
            return None
        span = self.best(falls, first[good], last[good])
        if not span.fall > 0:
            return None
        for _ in range(3):
            firsts = np.arange(side, span.last - side + 1)
            span = self.best(falls, firsts, np.array([span.last]))
            lasts = np.arange(span.first + side, days - side + 1)
            span = self.best(falls, np.array([span.first]), lasts)
        return span


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


def first_days(
    design: "Design",
    change: "Changed",
    given: Sequence["Column"],
    side: int,
    errors: float,
) -> Effect:
    """
    The change with the days between which it may have begun.

    Parameters
    ----------
    design : Design
    change : Changed
        With its dates.
    given : sequence of int or Changed
        Columns given which it is there.
    side : int
        Days with rows that there have to be on both sides of a date.
    errors : float
        Standard errors by which its size differs from nothing.

    Returns
    -------
    Effect
    """
    effect, dates, days = change.effect, change.effect.settings, design.dates
    begin = dates.get("at") or dates.get("start")
    if begin is None:
        return effect
    sums = Scan.from_design(design, given, side).sums(change.place)
    falls_of = sums.linear if is_drift(effect) else sums.constant
    last = len(days)
    if "end" in dates:
        last = int(np.searchsorted(days, day_number(dates["end"])))
    starts = np.arange(1, max(last, 2))
    falls = falls_of(starts, np.full(len(starts), last))
    best = int(np.searchsorted(days, day_number(begin)))
    most = max(falls[min(max(best - 1, 0), len(falls) - 1)], 1e-12)
    # the difference to the best date's part, in standard errors of that part
    worse = (1.0 - falls / most) * min(errors, MOST_SURE) ** 2
    good = np.append(starts[worse <= LIKELY], best)
    # the days with rows around a date may not be neighbours
    between = [
        date_text(days[good.min() - 1] + 1),
        date_text(days[min(good.max(), len(days) - 1)]),
    ]
    return effect.make(**{**dates, "between": between})


def day_weights(design: "Design", given: Sequence["Column"]) -> np.ndarray:
    """Weight of each day: less where the residual of some columns is large."""
    rest = design.residual_given(given)
    squares = np.add.reduceat(rest**2 * design.rows, design.first)
    remaining = np.sqrt(squares / np.add.reduceat(design.rows, design.first))
    most = USUAL * np.median(remaining)
    return np.where(remaining > most, most / np.maximum(remaining, 1e-12), 1.0)
