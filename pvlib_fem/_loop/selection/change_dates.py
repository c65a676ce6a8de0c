"""Dates of steps, trends and temporary changes that the remaining error shows best."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Self

import numpy as np

from pvlib_fem._loop.selection.change_sums import (
    GRID,
    SHORTEST,
    SPARSE,
    ChangeSums,
    Span,
)
from pvlib_fem._statistics.weekly_sums import coefficients_from, with_ridge
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import YEAR, date_text, day_number, is_drift

if TYPE_CHECKING:
    from pvlib_fem._loop.regression.design import Changed, Column, Design

USUAL = 2.0  # times the median of the daily residuals: beyond it a day counts less
MOST_SURE = 6.0  # standard errors, beyond which a date is not surer
LIKELY = 3.84  # twice the log-likelihood by which 95 % of dates are as good
DATES = "at", "start", "end"  # names of dates in the settings of a change
SWEEPS = 2  # times that each of several dates is searched for given the others
#: of changes, twice the log-likelihood by which each is worse than the best of them
Costs = Callable[[Sequence[Effect]], np.ndarray]


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
        whole, trust = design.whole(columns), np.ones(len(design.dates))
        if design.outliers:
            trust = day_weights(design, columns)
        inverse = np.linalg.inv(np.linalg.cholesky(with_ridge(whole[1:, 1:])))
        return cls(design, columns, side, coefficients_from(whole), inverse.T, trust)

    def sums(self, place: int, low: float = -1.0, high: float = 1.0) -> ChangeSums:
        """
        Products of a column with the remaining error and others, before each day.

        ``low`` and ``high`` are signs of the least and the largest size of a change.
        """
        rows = self.design.by_day(place, self.given) * self.trust[:, None]
        scores = rows[:, 0] - rows[:, 1:] @ self.solved
        squares = self.design.daily(place)[:, place] * self.trust
        table = np.column_stack([scores, squares, rows[:, 1:] @ self.root])
        years = (self.design.dates - self.design.dates[0]) / YEAR
        return ChangeSums(table, years, low, high)

    def along(
        self, place: int, low: float, high: float
    ) -> Iterator[tuple[str, dict[str, str]]]:
        """
        Time profile and dates of a column's best step, temporary change and trends.

        There is always a trend of the whole record, and before it one of a part of it,
        if that explains more than its dates cost. ``low`` and ``high`` as in
        :meth:`sums`.
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
        episode = sums.inside(sums.constant, side, min(SHORTEST, side), GRID)
        if episode is not None:
            start, end = self.date_at(episode.first), self.date_at(episode.last)
            yield "episode", {"start": start, "end": end}
        inside = sums.inside(sums.linear, side, side, SPARSE)
        trends += [inside] if inside else []
        sawtooth = sums.with_resets(side)
        trends += [sawtooth] if sawtooth else []
        trend = sums.simplest(trends)
        if trend.dates(days):
            begin = {"start" if trend.first else "since": self.date_at(trend.first)}
            end = {"end": self.date_at(trend.last)} if trend.last < days else {}
            yield "drift", begin | self.resets_of(trend) | end
        yield "drift", {"since": date_text(dates[0])}

    def resets_of(self, span: Span) -> dict[str, tuple[str, ...]]:
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

    def sizes_over_dates(self, change: "Changed", errors: float) -> tuple[float, float]:
        """
        Least and largest size of a trend, averaged over its dates, by its own size.

        A trend of half a record is much like one of all of it with half the slope. Each
        has the probability of its likelihood; trends of the whole record, and of a part
        of it, are as probable before. Between these sizes are 90 %. By ``errors``
        standard errors its own size differs from nothing. Other changes, and a trend
        between two dates or with resets, have 1 and 1.
        """
        days = len(self.design.dates)
        first, last = places_in(self.design.dates, change.effect)
        some = np.arange(self.side, days - self.side + 1)
        between = first > 0 and last < days
        plain = is_drift(change.effect) and "resets" not in change.effect.settings
        if not plain or between or not len(some):
            return 1.0, 1.0
        sums = self.sums(change.place)
        whole, zero = np.full(len(some), days), np.zeros(len(some), dtype=int)
        parts = sums.increase(
            np.concatenate([[first, 0], some, zero]),
            np.concatenate([[last, days], whole, some]),
        )
        falls, sizes = sums.square_falls(parts), sums.sizes(parts)
        if not falls[0] > 0.0:
            return 1.0, 1.0
        sure = min(errors, MOST_SURE)
        logs = 0.5 * sure**2 * falls[1:] / falls[0]
        logs[1:] -= np.log(2.0 * len(some))
        weights, ratios = np.exp(logs - logs.max()), sizes[1:] / sizes[0]
        order = np.argsort(ratios)
        share = np.cumsum(weights[order]) / weights.sum()
        low, high = ratios[order[np.searchsorted(share, [0.05, 0.95])]]
        return min(float(low), 1.0), max(float(high), 1.0)

    def at_best_dates(self, change: "Changed", errors: float, costs: Costs) -> Effect:
        """
        The change with each of its dates where it is best by ``costs``, too.

        By ``errors`` standard errors its size differs from nothing.
        """
        effect = change.effect
        if "resets" in effect.settings:
            return effect
        sums = self.sums(change.place, *signs_of(effect))
        for _ in range(SWEEPS):
            before = effect.settings
            for name in [name for name in DATES if name in effect.settings]:
                effect = DateSearch(self, sums, effect, name, errors, costs).best()
            if effect.settings == before:
                break
        return effect

    def first_days(
        self, change: "Changed", errors: float, costs: Costs | None = None
    ) -> Effect:
        """
        The change with the days between which it may have begun.

        By ``errors`` standard errors its size differs from nothing. With ``costs``,
        these are those that are as good by them, too.
        """
        effect, days = change.effect, self.design.dates
        names = [name for name in ("at", "start") if name in effect.settings]
        if not names:
            return effect
        sums = self.sums(change.place)
        search = DateSearch(self, sums, effect, names[0], errors, costs)
        starts = np.arange(1, max(search.places[1], 2))
        good = np.append(starts[search.worse(starts) <= LIKELY], search.place)
        joint = search.jointly_worse(good)
        good = good[joint - joint.min() <= LIKELY]
        # the days with rows around a date may not be neighbours
        between = [
            date_text(days[good.min() - 1] + 1),
            date_text(days[min(good.max(), len(days) - 1)]),
        ]
        return effect.make(**{**effect.settings, "between": between})


@dataclass(frozen=True, eq=False)
class DateSearch:
    """A change, and how good other days are for one of its dates."""

    scan: Scan
    sums: ChangeSums
    effect: Effect
    name: str  # of the date
    errors: float  # standard errors by which its size differs from nothing
    costs: Costs | None = None

    @cached_property
    def places(self) -> tuple[int, int]:
        """Place of its first day, and of the first one after it."""
        return places_in(self.scan.design.dates, self.effect)

    @property
    def place(self) -> int:
        """Place of the date."""
        return self.places[self.name == "end"]

    def falls(self, some: np.ndarray) -> np.ndarray:
        """Falls of the sum of squares with the date at some places."""
        first, last = (np.full(len(some), place) for place in self.places)
        between = (first, some) if self.name == "end" else (some, last)
        trend = is_drift(self.effect)
        return (self.sums.linear if trend else self.sums.constant)(*between)

    def worse(self, some: np.ndarray) -> np.ndarray:
        """Twice the log-likelihood by which the date is better than some places."""
        most = max(float(self.falls(np.array([self.place]))[0]), 1e-12)
        # the difference to the date's part, in standard errors of that part
        return (1.0 - self.falls(some) / most) * min(self.errors, MOST_SURE) ** 2

    def jointly_worse(self, some: np.ndarray) -> np.ndarray:
        """Twice the log-likelihood with the costs, which are 0 at the best place."""
        costs = self.costs([self.at(place) for place in some]) if self.costs else 0.0
        return self.worse(some) + costs

    def at(self, place: int) -> Effect:
        """The change with the date at a place."""
        if place == self.place:
            return self.effect
        date = {self.name: self.scan.date_at(place)}
        return self.effect.make(**{**self.effect.settings, **date})

    def best(self) -> Effect:
        """The change with the best date: of some all over the record, then near it."""
        days, side = len(self.scan.design.dates), self.scan.side
        least = side if is_drift(self.effect) else min(SHORTEST, side)
        first, last = self.places
        every = np.arange(side, last - (least if last < days else side) + 1)
        if self.name == "end":
            every = np.arange(first + (least if first else side), days - side + 1)
        apart = len(every) // GRID + 1
        place = self.best_of(self.place, every[::apart])
        near = every[abs(every - place) < apart]
        return self.at(self.best_of(place, near))

    def best_of(self, place: int, others: np.ndarray) -> int:
        """The best of some places; of as good ones, the first."""
        some = np.append(place, others)
        return int(some[np.argmin(self.jointly_worse(some))])


def signs_of(effect: Effect) -> tuple[float, float]:
    """
    Signs of the least and the largest size that a change can have.

    Parameters
    ----------
    effect : Effect

    Returns
    -------
    float, float
    """
    (row,) = effect.parameters.values()
    return float(np.sign(row.lower)), float(np.sign(row.upper))


def places_in(days: np.ndarray, effect: Effect) -> tuple[int, int]:
    """Places among some days of the first day of a change, and of that after it."""
    dates = effect.settings
    begin, end = dates.get("at") or dates.get("start"), dates.get("end")
    first = 0 if begin is None else int(np.searchsorted(days, day_number(begin)))
    last = len(days) if end is None else int(np.searchsorted(days, day_number(end)))
    return first, last


def day_weights(design: "Design", given: Sequence["Column"]) -> np.ndarray:
    """Weight of each day: less where the residual of some columns is large."""
    rest = design.residual_given(given)
    squares = np.add.reduceat(rest**2 * design.rows, design.first)
    remaining = np.sqrt(squares / np.add.reduceat(design.rows, design.first))
    most = USUAL * np.median(remaining)
    return np.where(remaining > most, most / np.maximum(remaining, 1e-12), 1.0)
