"""Dates of steps, trends and temporary changes that the remaining error shows best."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Self

import numpy as np

from pvlib_fem._statistics.extremes import rounded_argmax
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
MOST_RESETS, RESETS_A_YEAR = 12, 2  # of a trend
AGES = 13  # of a trend on the first day of a record, that are tried
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
    if not effect.sensor_fault:
        return 0
    resets = len(effect.settings.get("resets", ()))
    return sum(name in effect.settings for name in DATES) + resets


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
                yield "step", {"at": self.date_at(step.first)}
            trends.append(sums.best(sums.linear, some, last))
            trends.append(sums.best(sums.linear, np.array([0]), some))
        episode = sums.inside(sums.constant, side, GRID)
        if episode is not None:
            start, end = self.date_at(episode.first), self.date_at(episode.last)
            yield "episode", {"start": start, "end": end}
        inside = sums.inside(sums.linear, side, SPARSE)
        trends += [inside] if inside else []
        sawtooth = sums.with_resets(side)
        trends += [sawtooth] if sawtooth else []
        trend = simplest(trends, days)
        if trend.dates(days):
            begin = {"start" if trend.first else "since": self.date_at(trend.first)}
            end = {"end": self.date_at(trend.last)} if trend.last < days else {}
            yield "drift", begin | self.resets_of(trend) | end
        yield "drift", {"since": date_text(dates[0])}

    def resets_of(self, span: "Span") -> dict[str, tuple[str, ...]]:
        """Dates on which a trend begins again, perhaps of one before the record."""
        first, resets = self.design.dates[0], []
        if span.before:
            resets.append(date_text(first - round(span.before * YEAR)))
        resets += map(self.date_at, span.resets)
        return {"resets": tuple(resets)} if resets else {}

    def date_at(self, place: int) -> str:
        """
        The day on which something begins that the day at a place is the first to show.

        The days before it may have no rows that are fitted, as those of test weeks. It
        began on any of them, and in the middle is closest to all.
        """
        dates = self.design.dates
        if not 0 < place < len(dates):
            return date_text(dates[0] if place == 0 else dates[-1] + 1)
        return date_text((dates[place - 1] + 1 + dates[place]) // 2)


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
        return self.square_falls(self.increase(first, last))

    def increase(
        self, first: np.ndarray, last: np.ndarray, before: float | np.ndarray = 0.0
    ) -> np.ndarray:
        """Sums of a trend from some days until before others, begun years before."""
        begin, (means, squares) = self.years[first][:, None] - before, self.moments
        plain, mean = self.sums[last] - self.sums[first], means[last] - means[first]
        parts = mean - begin * plain
        square = (squares[last] - squares[first])[:, None]
        own = square - begin * (2.0 * mean[:, 1:2] - begin * plain[:, 1:2])
        return np.concatenate([parts[..., :1], own, parts[..., 2:]], axis=-1)

    def with_resets(self, side: int) -> Span | None:
        """
        The best trend of the whole record that begins again from 0 at some dates.

        Dates are added one by one, each where it explains most. Of these trends, the
        simplest is taken.

        Parameters
        ----------
        side : int
            Least number of days between two dates.
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
        span = self.in_place(simplest(spans, days), side)
        if len(span.resets) == 1:
            return span
        fewer = [without(span.resets, one) for one in span.resets]
        return simplest([span, *map(self.begun_before, fewer)], days)

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
            for reset in span.resets:
                others = without(span.resets, reset)
                left = replace(span, resets=others)
                near = every[abs(every - reset) <= len(every) // GRID + 1]
                place = self.best_reset(left, near, side)
                if place is not None:
                    span = replace(span, resets=tuple(sorted([*others, place])))
            span = self.begun_before(span.resets)
        return span

    def square_falls(self, parts: np.ndarray) -> np.ndarray:
        """Fall of the sum of squares by a column of such sums, with a possible sign."""
        return parts[..., 0] * self.sizes(parts)

    def sizes(self, parts: np.ndarray) -> np.ndarray:
        """Size of a change along a column of such sums; 0 if its sign is impossible."""
        score, square, shared = parts[..., 0], parts[..., 1], parts[..., 2:]
        beyond = square - np.square(shared).sum(axis=-1)
        allowed = (score > 0) & (self.high > 0) | (score < 0) & (self.low < 0)
        good = allowed & (beyond > UNSEEN * np.maximum(square, 1e-12))
        return np.where(good, score / np.where(good, beyond, 1.0), 0.0)

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


def sizes_over_dates(
    design: "Design",
    change: "Changed",
    given: Sequence["Column"],
    side: int,
    errors: float,
) -> tuple[float, float]:
    """
    Least and largest size of a trend, averaged over its dates, by its own size.

    A trend of half a record is much like one of all of it with half the slope. Each has
    the probability of its likelihood; trends of the whole record, and of a part of it,
    are as probable before. Between these sizes are 90 %.

    Parameters
    ----------
    design, change, given, side, errors
        See :func:`first_days`.

    Returns
    -------
    tuple of float
        1 and 1 for other changes, and for a trend between two dates or with resets.
    """
    dates, days = change.effect.settings, len(design.dates)
    if not is_drift(change.effect) or "resets" in dates:
        return 1.0, 1.0
    first, last = 0, days
    if "start" in dates:
        first = int(np.searchsorted(design.dates, day_number(dates["start"])))
    if "end" in dates:
        last = int(np.searchsorted(design.dates, day_number(dates["end"])))
    some = np.arange(side, days - side + 1)
    if not len(some) or (first > 0 and last < days):
        return 1.0, 1.0
    sums = Scan.from_design(design, given, side).sums(change.place)
    whole, zero = np.full(len(some), days), np.zeros(len(some), dtype=int)
    parts = sums.increase(
        np.concatenate([[first, 0], some, zero]),
        np.concatenate([[last, days], whole, some]),
    )
    falls, sizes = sums.square_falls(parts), sums.sizes(parts)
    if not falls[0] > 0.0:
        return 1.0, 1.0
    sure = min(errors, 1.0 / PROFILE_ERROR)
    logs = 0.5 * sure**2 * falls[1:] / falls[0]
    logs[1:] -= np.log(2.0 * len(some))
    weights, ratios = np.exp(logs - logs.max()), sizes[1:] / sizes[0]
    order = np.argsort(ratios)
    share = np.cumsum(weights[order]) / weights.sum()
    low, high = ratios[order[np.searchsorted(share, [0.05, 0.95])]]
    return min(float(low), 1.0), max(float(high), 1.0)


def day_weights(design: "Design", given: Sequence["Column"]) -> np.ndarray:
    """Weight of each day: less where the residual of some columns is large."""
    rest = design.residual_given(given)
    squares = np.add.reduceat(rest**2 * design.rows, design.first)
    remaining = np.sqrt(squares / np.add.reduceat(design.rows, design.first))
    most = USUAL * np.median(remaining)
    return np.where(remaining > most, most / np.maximum(remaining, 1e-12), 1.0)
