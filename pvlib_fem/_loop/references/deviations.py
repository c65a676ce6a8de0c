"""How references deviate from an instrument, from day to day."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Self, cast

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from pvlib_fem._loop.references.comparisons import (
    COMPARISONS,
    SKY,
    USUAL_WIND,
    ComparedRecord,
    Comparison,
    kind,
    size_error,
)
from pvlib_fem._loop.selection.change_sums import UNSEEN
from pvlib_fem._loop.selection.noise import density
from pvlib_fem._record.column_names import is_power
from pvlib_fem._record.inputs import Record
from pvlib_fem._statistics.clusters import WEEK, date_starts, week_numbers
from pvlib_fem._statistics.weekly_sums import LeastSquares, products
from pvlib_fem.drivers import derive_drivers
from pvlib_fem.drivers._mounts import angles_at
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import (
    is_compared,
    is_dated,
    is_drift,
    weights_of,
)
from pvlib_fem.quality._clearsky import clear_sky

if TYPE_CHECKING:
    from pvlib_fem._loop.preparation.divided_record import Case
    from pvlib_fem._loop.selection.choice import Choice, Sized

FADES = 0.005  # of power by a module that ages; up to twice as much, or none [1/year]
MONTH = 4 * WEEK  # days that are one draw of the weather
YEAR = 365.25  # days, over which weather forgets what it was
DAYS_OFF = 7  # by which the dates of a change may be off, where profiles are compared
SUREST = 1e-3  # relative error of a size by a reference, and no less
MOST_TURNS, CLOSE = 10, 1e-4  # of a size by a reference, and relative change to end
NEIGHBOURS = 4  # compared days before and after one that may be as it is
OUTLIER = 4.0  # interquartile ranges by which snow, a fault or clipped power differ


@dataclass(frozen=True)
class Shown:
    """How something deviates along a time profile, and what was to be expected."""

    size: float
    error: float  # standard error of the size
    expected: dict[str, float]  # by each candidate, of the size that it has in the fit
    #: relative standard errors of these: of a thermal coefficient, and of that size [-]
    slack: dict[str, float]
    aged: float  # by how much it fades by itself
    unseen: frozenset[str] = frozenset()  # names of which it may show nothing

    def likelihood(self, value: float, spread: float = 0.0) -> float:
        """The density of the size where a value with a standard error is expected."""
        error = np.hypot(self.error, self.aged)
        return float(density(self.size + self.aged - value, np.hypot(error, spread)))


@dataclass(frozen=True, eq=False)
class DailyDeviation:
    """Daily deviation of two columns."""

    comparison: Comparison
    column: str
    days: np.ndarray  # since 1970-01-01
    apart: np.ndarray
    #: of an effect, more light on the modules for one unit of its size [-]
    light: Callable[[Effect], np.ndarray]
    others: tuple[np.ndarray, ...] = ()  # daily columns of changes that are known
    #: of its evidence; columns of power are of the same modules and count once together
    weight: float = 1.0
    #: changes that second sensors and power show by themselves, with their dates
    own: tuple[Effect, ...] = ()

    @cached_property
    def usual(self) -> list[np.ndarray]:
        """Daily columns of usual variation, and of changes that are known."""
        return [np.ones(len(self.days)), *self.year(), *self.others]

    def given(self, choices: Iterable["Choice"]) -> Self:
        """
        The deviation given the changes of other choices.

        A second change is another one: else a trend in addition to a step would seem
        to be confirmed by what shows the step. One that is not weighed yet may be one.
        """
        shows = self.comparison.shows
        effects = (
            one.top.effect
            for one in choices
            if not one.members or kind(one.top.effect) in shows
        )
        return self.given_effects(filter(is_compared, effects))

    def given_effects(self, effects: Iterable[Effect]) -> Self:
        """The deviation given some changes."""
        profiles = map(self.profile, effects)
        others = [one for one in profiles if np.ptp(one) > 0]
        return self.given_columns(others) if others else self

    def profile(self, effect: Effect) -> np.ndarray:
        """
        Its part of each day.

        Of dirt it is the light that it takes, per unit, and of a standstill that light
        relative to a usual day of it: under clouds the modules miss little.
        """
        if effect.sensor_fault:
            return weights_of(effect, self.days)
        light = self.light(effect)
        return light / usual_light(light) if is_dated(effect) else light

    def change(self, effect: Effect, size: float) -> np.ndarray:
        """What an effect of a size changes on each day: a reading, or the light."""
        sensor = effect.sensor_fault
        return size * (weights_of(effect, self.days) if sensor else self.light(effect))

    def given_columns(self, others: Iterable[np.ndarray]) -> Self:
        """The deviation given some daily columns."""
        more = tuple(others)
        key = tuple(column.tobytes() for column in more)
        if key not in self.derived:
            self.derived[key] = replace(self, others=(*self.others, *more))
        return self.derived[key]

    @cached_property
    def derived(self) -> dict[tuple[bytes, ...], Self]:
        """The deviation given some daily columns, made once."""
        return {}

    @cached_property
    def changes(self) -> dict[tuple[bytes, bytes], tuple[float, float, np.ndarray]]:
        """What :meth:`along` returns, made once."""
        return {}

    @cached_property
    def basis(self) -> np.ndarray:
        """Orthonormal columns of usual variation."""
        return np.linalg.qr(np.column_stack(self.usual))[0]

    def beyond(self, column: np.ndarray) -> np.ndarray:
        """What of a daily column usual variation does not explain."""
        return column - self.basis @ (self.basis.T @ column)

    @cached_property
    def beyond_usual(self) -> np.ndarray:
        """The deviation that usual variation does not explain."""
        return self.beyond(self.apart)

    def along(
        self,
        weights: np.ndarray,
        values: np.ndarray | None = None,
    ) -> tuple[float, float, np.ndarray]:
        """
        The change along a time profile, its error, and the residual.

        It is a change of the deviation, or of other daily ``values``. Its error is that
        of a change of the module's temperature: by weeks and their memory.
        """
        values = self.apart if values is None else values
        key = weights.tobytes(), values.tobytes()
        if key in self.changes:
            return self.changes[key]
        table = np.column_stack([values, *self.usual, weights])
        edges = np.append(0, date_starts(week_numbers(self.days))[1])
        fit = LeastSquares(products(table, np.ones(len(table)), edges), 1)
        residual = table @ np.append(1.0, -fit.solved)
        variance = float(np.squeeze(fit.by_all_weeks()[0]))
        error = np.sqrt(variance + self.wandering(table[:, 1:]))
        self.changes[key] = float(fit.estimate[0]), float(error), residual
        return self.changes[key]

    def wandering(self, table: np.ndarray) -> float:
        """Variance of the last coefficient by what differs from year to year."""
        if not (size := self.comparison.wanders):
            return 0.0
        months, place = np.unique(self.days // MONTH, return_inverse=True)
        share = np.bincount(place, np.linalg.pinv(table)[-1])
        apart = MONTH * np.abs(np.subtract.outer(months, months))
        return size**2 * (share @ np.exp(-apart / YEAR) @ share)

    def year(self, least: int = 0) -> Iterator[np.ndarray]:
        """What comes back with the year, of records that are long enough, at least."""
        years, least = np.ptp(self.days) / YEAR, least or self.comparison.wanders > 0
        angle = 2.0 * np.pi * self.days / YEAR
        for harmonic in range(1, 1 + min(max(round(years), least), 2)):
            yield np.cos(harmonic * angle)
            yield np.sin(harmonic * angle)

    def sees(self, weights: np.ndarray) -> bool:
        """Whether a time profile differs from usual variation and known changes."""
        beyond = self.beyond(weights)
        return bool(beyond @ beyond > UNSEEN * (weights @ weights))

    def profiles(self, effects: Iterable[Effect]) -> Iterator[tuple[str, float]]:
        """Log-likelihood of each time profile compared with the best of them."""
        sensor_faults: dict[str, list[Effect]] = {}
        for effect in effects:
            sensor_faults.setdefault(effect.sensor_fault, []).append(effect)
        for same in sensor_faults.values():
            residuals = {}
            for effect in same:
                rest = self.beside(effect)
                if rest is not None:
                    residuals[effect.name] = rest
            squares = {name: float(rest @ rest) for name, rest in residuals.items()}
            if len(squares) < 2:
                continue
            best = min(squares, key=squares.__getitem__)
            draws = 0.5 * independent_months(residuals[best], self.days // MONTH)
            for name, square in squares.items():
                yield name, draws * float(np.log(squares[best] / square))

    def beside(self, effect: Effect) -> np.ndarray | None:
        """
        The residual given a time profile, whose dates may be some days off.

        A sharp reference would refuse a change for its date otherwise. None where it
        has no days before or after.
        """
        begin = self.days[0] - DAYS_OFF
        calendar = np.arange(begin, self.days[-1] + DAYS_OFF + 1)
        weights, place = weights_of(effect, calendar), self.days - begin
        moved = weights[place]
        if not np.ptp(moved) > 0:
            return None
        middle = self.days[moved != 0].mean()
        basis, rest = self.basis, self.beyond_usual
        offsets = np.arange(-DAYS_OFF, DAYS_OFF + 1)
        explained = np.zeros(len(rest))
        for dates in (self.days < middle, self.days >= middle):  # first and last date
            there = np.where(dates, weights[place - offsets[:, None]], moved)
            beyond = there - there @ basis @ basis.T
            squares = np.square(beyond).sum(axis=1)
            squares[squares <= UNSEEN * np.square(there).sum(axis=1)] = np.inf
            part = beyond @ rest
            best = int(np.argmax(part**2 / squares))
            moved = there[best]
            explained = beyond[best] * part[best] / squares[best]
        return rest - explained

    def costs(self, effects: Sequence[Effect]) -> np.ndarray:
        """Twice the log-likelihood by which each change is worse than the best."""

        def rest(effect: Effect) -> np.ndarray:
            weights = self.profile(effect)
            beyond = self.beyond(weights)
            square = beyond @ beyond
            if square <= UNSEEN * (weights @ weights):
                return self.beyond_usual
            return self.beyond_usual - (beyond @ self.beyond_usual) / square * beyond

        least = SUREST**2 * np.square(self.beyond_usual).sum() or 1.0  # of a copy
        squares = [max(float(np.square(rest(one)).sum()), least) for one in effects]
        best = int(np.argmin(squares))
        draws = independent_months(rest(effects[best]), self.days // MONTH)
        return self.weight * draws * np.log(np.array(squares) / squares[best])

    def concerns(self, effect: Effect) -> bool:
        """Whether it would show something of a change."""
        return kind(effect) in self.comparison.shows and is_compared(effect)

    def concerned(self, choice: "Choice") -> list[str]:
        """Members of a choice of which it would show something."""
        members = choice.members.items()
        return [n for n, m in members if kind(m.effect) in self.comparison.shows]

    def shown(
        self,
        first: Effect,
        several: Sequence["Sized"],
        coefficients: Mapping[str, float],
    ) -> Shown | None:
        """
        Its deviation along the profile of an effect, and what candidates would make it.

        None where it shows nothing.
        """
        weights = self.profile(first)
        if not several or not self.sees(weights):
            return None
        size, error, _ = self.along(weights)
        expected, slack = {}, {}
        for effect, of_fit, relative in several:
            name = effect.name
            expected[name] = self.expected(effect, of_fit, weights, coefficients)
            slack[name] = float(np.hypot(size_error(effect), relative))
        aged = FADES if self.comparison.ages and is_drift(first) else 0.0
        faults = self.comparison.unseen
        unseen = frozenset(
            one.effect.name for one in several if kind(one.effect) in faults
        )
        return Shown(size, error, expected, slack, aged, unseen)

    def relative_size(
        self,
        one: "Sized",
        first: Effect,
        shown: Shown,
        coefficients: Mapping[str, float],
    ) -> tuple[float, float]:
        """The size of a change by what is shown, relative to the fit, and its error."""
        effect, size, _ = one
        weights = self.profile(first)
        ratio, value = 1.0, shown.expected[effect.name]
        # the logarithm of a ratio is not proportional to it
        for _ in range(MOST_TURNS):
            slope, before = ratio / value, ratio
            ratio = slope * shown.size
            if abs(ratio - before) < CLOSE * abs(ratio):
                break
            value = self.expected(effect, ratio * size, weights, coefficients)
            if not value:
                break
        return ratio, max(abs(slope) * shown.error, SUREST)

    def expected(
        self,
        effect: Effect,
        size: float,
        along: np.ndarray,
        coefficients: Mapping[str, float],
    ) -> float:
        """The deviation that a change of a size would make along a time profile."""
        change = self.change(effect, size)
        shows = self.comparison.shows[kind(effect)]
        with np.errstate(invalid="ignore", divide="ignore"):
            shown = shows(change, coefficients)
        if not np.isfinite(shown).all():
            return 0.0
        beyond = self.beyond(along)
        return float(shown @ beyond / (along @ beyond))


def usual_light(light: np.ndarray) -> float:
    """Root mean square on the days that have some, with the sign of their sum."""
    own = light[light != 0.0]
    return float(np.copysign(np.sqrt(np.mean(own**2)), own.sum())) if len(own) else 1.0


def independent_months(values: np.ndarray, months: np.ndarray) -> float:
    """Number of months less what each remembers of the one before."""
    _, place = np.unique(months, return_inverse=True)
    means = np.bincount(place, values) / np.bincount(place)
    memory = 0.0
    if len(means) > 3 and np.ptp(means) > 0:
        memory = max(float(np.corrcoef(means[1:], means[:-1])[0, 1]), 0.0)
    return len(means) * (1.0 - memory) / (1.0 + memory)


def compared_columns(case: "Case") -> dict[str, np.ndarray]:
    """All that is compared with instruments, by name: columns, sky and weather."""
    record, location = case.record, case.place["location"]
    columns = {name: record[name] for name in case.cross_check_columns}
    if "wind_speed" not in record.absent:
        columns[USUAL_WIND] = np.ones(len(record.index))
    if location is not None:
        angles = angles_at(record.index, case.place, case.late)
        poa, index = record["poa_global"], record.index
        columns[SKY] = clear_sky(poa, index, location, angles, case.late)
    return columns


def daily_deviations(case: "Case") -> list[DailyDeviation]:
    """
    All comparisons that a case has enough days for.

    Parameters
    ----------
    case : Case
        Record and site of a loop.

    Returns
    -------
    list of DailyDeviation
        One for each comparison and column that serves it.
    """
    columns, at = compared_columns(case), (case.record, case.searched)
    found = [
        one
        for comparison in COMPARISONS
        for name in filter(comparison.serves, columns)
        if (one := daily_deviation(comparison, *at, name, columns[name])) is not None
    ]
    powers = [one for one in found if is_power(one.column)]
    return [replace(o, weight=1.0 / len(powers)) if o in powers else o for o in found]


def daily_deviation(
    comparison: Comparison,
    record: ComparedRecord,
    searched: np.ndarray,
    name: str,
    values: np.ndarray,
) -> DailyDeviation | None:
    """
    One comparison, on days that are near the others.

    Parameters
    ----------
    comparison : Comparison
    record : ComparedRecord
    searched : array of bool, shape (rows,)
        Rows of which the module's temperature may be looked at.
    name : str
        Of what is compared with an instrument.
    values : array, shape (rows,)

    Returns
    -------
    DailyDeviation or None
        None where there are too few days.
    """
    one, other = comparison.parts(record, values)
    kept = comparison.rows(record) & np.isfinite(one + other)
    if comparison.module:  # whose temperature in other weeks is for the test
        kept &= searched
    days, place = np.unique(record.dates[kept], return_inverse=True)
    if len(days) < comparison.fewest:
        return None
    sums = [np.bincount(place, column[kept]) for column in (one, other)]
    deviation = comparison.differ(sums[0], sums[1])
    near = usual_days(deviation, comparison.most)
    if near.sum() < comparison.fewest:
        return None

    known: dict[str, np.ndarray] = {}  # by an effect with its settings

    def light(effect: Effect) -> np.ndarray:
        key = f"{effect.name} {effect.settings}"
        if key not in known:
            # only the record of a loop has candidates
            inputs = derive_drivers(cast(Record, record).inputs, effect.drivers)
            terms = effect.at(inputs.columns, dict.fromkeys(effect.rows(), 1.0))
            heat = np.broadcast_to(terms.heat, len(kept))
            more, whole = (
                np.bincount(place, np.nan_to_num(column[kept]))
                for column in (heat, record["poa_global"])
            )
            known[key] = (more / np.maximum(whole, 1e-9))[near]
        return known[key]

    return DailyDeviation(comparison, name, days[near], deviation[near], light)


def usual_days(values: np.ndarray, most: float = np.inf) -> np.ndarray:
    """
    Days that are near most others, or near those before or after them, but one.

    What changes for a while stays, however sharp the comparison is, and snow, whose
    days differ from each other, goes. So does what is further from the median than
    ``most``, as days on which snow or an outage leaves hardly any power.
    """
    known = np.isfinite(values)
    if known.sum() <= NEIGHBOURS:
        return np.zeros(len(values), dtype=bool)
    there = values[known]
    middle = np.median(there)
    windows = sliding_window_view(np.pad(there, NEIGHBOURS, mode="reflect"), NEIGHBOURS)
    sides = windows[: -NEIGHBOURS - 1], windows[NEIGHBOURS + 1 :]  # before and after
    apart = [there[:, None] - side for side in sides]
    # from day to day, since a change widens the range of all days
    low, high = np.quantile(apart, [0.25, 0.75])
    far = OUTLIER * max(high - low, 1e-9)
    # one side is enough: the last day before a step is near no day after it
    near = (np.abs(apart) <= far).sum(axis=2)
    around = near.max(axis=0) >= NEIGHBOURS - 1
    kept = known.copy()
    away = np.abs(there - middle)
    kept[known] = ((away <= far) | around) & (away <= most)
    return kept
