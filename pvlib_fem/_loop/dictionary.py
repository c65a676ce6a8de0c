"""What may be in the remaining error: effects, and changes at the dates that show."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Self, cast

import numpy as np

from pvlib_fem._statistics.weekly_sums import coefficients_from, with_ridge
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import date_text, day_number, time_profile_of

if TYPE_CHECKING:
    from pvlib_fem._loop.design import Design

RARE = {"air_elsewhere": 0.05}  # times the odds of others
GRID = 60  # dates between which temporary changes are looked for first
USUAL = 2.0  # times the median of the daily residuals: beyond it a day counts less
UNSEEN = 1e-6  # of a column's square: less of it is nothing given the others
MOST_SURE = 6.0  # standard errors, beyond which a date is not surer
LIKELY = 3.84  # twice the log-likelihood by which 95 % of dates are as good
DATED = {"step": 1, "episode": 2, "drift": 0}  # dates of a change


@dataclass(frozen=True)
class Changed:
    """A column of the design times the weight that an effect has on each day."""

    place: int  # of the column
    effect: Effect = field(compare=False)  # with its dates
    key: str = ""  # its name and dates

    @classmethod
    def from_effect(cls, place: int, effect: Effect) -> Self:
        return cls(place, effect, f"{effect.name} {sorted(effect.settings.items())}")


#: a column of the design by its place, or one times the weights of a change
Column = int | Changed


def place_of(column: Column) -> int:
    """
    Place in the design of a column, or of the one that a change is a part of.

    Parameters
    ----------
    column : int or Changed
        A column of the design, or one times the weights of a change.

    Returns
    -------
    int
    """
    return column if isinstance(column, int) else column.place


@dataclass(frozen=True)
class Candidate:
    """An effect, or a change at its dates, with its columns of the design."""

    effect: Effect
    columns: tuple[Column, ...]
    log_prior: float  # logarithm of its prior odds
    #: hypotheses of dates from which this one was taken, as a logarithm
    log_dates: float = 0.0

    @property
    def name(self) -> str:
        return self.effect.name

    @property
    def change(self) -> Changed:
        """The only column of a candidate that has a sensor fault."""
        (column,) = self.columns
        return cast(Changed, column)

    def beyond(self, given: Sequence[Column]) -> list[Column]:
        """Columns that are not given already."""
        return [column for column in self.columns if column not in given]


def without_dates(design: "Design", prior: float) -> Iterator[Candidate]:
    """
    Candidates that have no date.

    Parameters
    ----------
    design : Design
        Hourly tangents of all effects.
    prior : float
        Prior odds of any one effect. [-]

    Yields
    ------
    Candidate
    """
    for name, columns in design.own.items():
        odds = np.log(prior * RARE.get(name, 1.0))
        yield Candidate(design.effects[name], columns, float(odds))


def dated_candidates(
    design: "Design", given: Sequence[Column], side: int, prior: float
) -> Iterator[Candidate]:
    """
    Changes at the dates that the remaining error given some columns shows best.

    Parameters
    ----------
    design : Design
    given : sequence of int or Changed
        Columns.
    side : int
        Days with rows that there have to be on both sides of a date.
    prior : float
        Odds that any one change is there, at some date.

    Yields
    ------
    Candidate
    """
    days = len(design.dates)
    if days <= 2 * side:
        return
    scan = Scan.from_design(design, given, side)
    for sensor_fault, place in design.sensor_faults.items():
        changes = {
            time_profile_of(effect): effect
            for effect in design.changing
            if effect.sensor_fault == sensor_fault
        }
        if not changes:
            continue
        for time_profile, dates in scan.along(place, *possible_signs(changes)).items():
            if time_profile not in changes:
                continue
            effect = changes[time_profile].dates(**dates)
            many = DATED[time_profile]
            log_dates = many * np.log(days) - (np.log(2.0) if many == 2 else 0.0)
            yield Candidate(
                effect,
                (Changed.from_effect(place, effect),),
                float(np.log(prior)),
                float(log_dates),
            )


def possible_signs(changes: Mapping[str, Effect]) -> tuple[float, float]:
    """Least and largest size that a sensor fault can have, as signs."""
    (row,) = next(iter(changes.values())).parameters.values()
    return np.sign(row.lower), np.sign(row.upper)


@dataclass(frozen=True, eq=False)
class Scan:
    """Daily products with the residual given some columns, summed up to each date."""

    design: "Design"
    given: list[Column]
    side: int
    solved: np.ndarray  # coefficients of the columns
    root: np.ndarray  # of the inverse of their products
    trust: np.ndarray  # of each day, 1 for usual ones

    @classmethod
    def from_design(cls, design: "Design", given: Sequence[Column], side: int) -> Self:
        columns = [*given]
        whole, trust = design.whole(columns), day_weights(design, columns)
        inverse = np.linalg.inv(np.linalg.cholesky(with_ridge(whole[1:, 1:])))
        return cls(design, columns, side, coefficients_from(whole), inverse.T, trust)

    def square_falls(self, parts: np.ndarray, low: float, high: float) -> np.ndarray:
        """Fall of the sum of squares by a column of such sums, with a possible sign."""
        score, square, shared = parts[..., 0], parts[..., 1], parts[..., 2:]
        beyond = square - np.square(shared).sum(axis=-1)
        allowed = (score > 0) & (high > 0) | (score < 0) & (low < 0)
        good = allowed & (beyond > UNSEEN * np.maximum(square, 1e-12))
        return np.where(good, score**2 / np.where(good, beyond, 1.0), 0.0)

    def sums(self, place: int) -> np.ndarray:
        """
        Products of a column with the remaining error and others, before each day.

        Returns
        -------
        array, shape (days + 1, columns + 2)
            With the remaining error, with itself, and with the given columns, of which
            each is independent of the others.
        """
        rows = self.design.by_day(place, self.given) * self.trust[:, None]
        scores = rows[:, 0] - rows[:, 1:] @ self.solved
        squares = self.design.daily[:, place, place] * self.trust
        table = np.column_stack([scores, squares, rows[:, 1:] @ self.root])
        return np.vstack([np.zeros(table.shape[1]), np.cumsum(table, axis=0)])

    def along(self, place: int, low: float, high: float) -> dict[str, dict[str, str]]:
        """
        Dates of the best step and temporary change of a column, and of a trend.

        Parameters
        ----------
        place : int
            Of the column.
        low, high : float
            Signs of the least and the largest size that it can have.

        Returns
        -------
        dict of dict
            By time profile, its dates by name.
        """
        days, sums = len(self.design.dates), self.sums(place)

        def square_falls(parts: np.ndarray) -> np.ndarray:
            return self.square_falls(parts, low, high)

        side, dates = self.side, self.design.dates
        profiles = {"drift": {"since": date_text(dates[0])}}
        starts = np.arange(side, days - side + 1)
        if len(starts):
            falls = square_falls(sums[-1] - sums[starts])
            at = starts[int(np.argmax(falls))]
            if falls.max() > 0:
                profiles["step"] = {"at": date_text(dates[at])}
        ends = self.pair(sums, square_falls)
        if ends is not None:
            first, last = ends
            start, end = date_text(dates[first]), date_text(dates[last - 1] + 1)
            profiles["episode"] = {"start": start, "end": end}
        return profiles

    def pair(
        self, sums: np.ndarray, square_falls: Callable[[np.ndarray], np.ndarray]
    ) -> tuple[int, int] | None:
        """First day and the day after the last of the best temporary change."""
        side, days = self.side, len(self.design.dates)
        grid = np.unique(np.linspace(0, days, min(GRID, days)).astype(int))
        pairs = grid[np.column_stack(np.triu_indices(len(grid), 1))]
        length = pairs[:, 1] - pairs[:, 0]
        # enough days have to be there without it, too; and one that begins or ends
        # with the record is a step
        inside = (pairs[:, 0] >= side) & (pairs[:, 1] <= days - side)
        pairs = pairs[(length >= side) & (length <= days - side) & inside]
        if not len(pairs):
            return None
        falls = square_falls(sums[pairs[:, 1]] - sums[pairs[:, 0]])
        if not falls.max() > 0:
            return None
        low, high = pairs[int(np.argmax(falls))]
        for _ in range(3):
            lows = np.arange(side, high - side + 1)
            low = lows[int(np.argmax(square_falls(sums[high] - sums[lows])))]
            highs = np.arange(low + side, days - side + 1)
            high = highs[int(np.argmax(square_falls(sums[highs] - sums[low])))]
        return int(low), int(high)


def first_days(
    design: "Design", one: Candidate, given: Sequence[Column], side: int, errors: float
) -> Effect:
    """
    The change with the days between which it may have begun.

    Parameters
    ----------
    design : Design
    one : Candidate
        With a date.
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
    effect, dates, days = one.effect, one.effect.settings, design.dates
    begin = dates.get("at") or dates.get("start")
    if begin is None:
        return effect
    scan = Scan.from_design(design, given, side)
    sums, last = scan.sums(one.change.place), len(days)
    if "end" in dates:
        last = int(np.searchsorted(days, day_number(dates["end"])))
    starts = np.arange(1, max(last, 2))
    falls = scan.square_falls(sums[last] - sums[starts], -1.0, 1.0)
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


def day_weights(design: "Design", given: Sequence[Column]) -> np.ndarray:
    """Weight of each day: less where the residual of some columns is large."""
    rest = design.residual_given(given)
    squares = np.add.reduceat(rest**2 * design.rows, design.first)
    remaining = np.sqrt(squares / np.add.reduceat(design.rows, design.first))
    most = USUAL * np.median(remaining)
    return np.where(remaining > most, most / np.maximum(remaining, 1e-12), 1.0)
