"""
What is compared with an instrument: power, second sensors, a clear sky, usual wind.

If the instrument has changed and not the quantity, the two deviate along the same
time profile; where the change is elsewhere, they do not.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Protocol, cast

import numpy as np
import pandas as pd
from numpy.lib.stride_tricks import sliding_window_view

from pvlib_fem._findings import OUTSIDE, CheckOutcome, CrossCheck
from pvlib_fem._loop.noise import density
from pvlib_fem._record.column_names import is_power, twin_of
from pvlib_fem._record.inputs import Record
from pvlib_fem._statistics.clusters import WEEK, cluster_sums
from pvlib_fem.drivers import derive_drivers
from pvlib_fem.drivers._mounts import angles_at
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import (
    is_dated,
    is_drift,
    time_profile_of,
    weights_of,
    years_to_end,
)
from pvlib_fem.quality._clearsky import clear_sky

if TYPE_CHECKING:
    from pvlib_fem._loop.divided_record import Case
    from pvlib_fem._loop.selection import Choice

BRIGHT = 200.0  # W/m², above which light is compared
BREEZE = 1.0  # m/s, above which wind is
GAMMA = -0.004  # 1/K, of power: crystalline silicon, as PVWatts has it
SLACK = 0.15  # of what is expected: a thermal coefficient is no better than that
FADES = 0.005  # of power by a module that ages; up to twice as much, or none [1/year]
HALF = 0.5  # of what is expected: less is nearer to nothing
SURE = 2.0  # standard errors
FEWEST_DAYS = 40  # on which both are there
FEWEST_CLEAR = 20  # clear days, since most of the noise is in the others
MONTH = 4 * WEEK  # days that are one draw of the weather
YEAR = 365.25  # days, over which weather forgets what it was
NEIGHBOURS = 4  # compared days before and after one that may be as it is
OUTLIER = 4.0  # interquartile ranges from the median: snow, a fault, clipped power
HAZE = 0.02  # of a clear sky's light, from year to year: aerosol and water [-]
WINDINESS = 0.1  # of the mean wind, from season to season and from year to year [-]
WORTH = 0.05  # probability of a member from which its cross-checks are reported
ODD = 0.05  # probability that a reference shows something else than any candidate
SKY, USUAL_WIND = "clear sky", "usual wind"  # no names of columns


class ComparedRecord(Protocol):
    """What a comparison reads of a record."""

    @property
    def index(self) -> pd.DatetimeIndex: ...

    @property
    def dates(self) -> np.ndarray: ...

    def __getitem__(self, name: str) -> np.ndarray: ...


class ComparedCase(Protocol):
    """A record, and which of its rows may be looked at."""

    @property
    def record(self) -> ComparedRecord: ...

    @property
    def searched(self) -> np.ndarray: ...


#: a record and the column to two columns, whose daily sums are compared
Parts = Callable[[ComparedRecord, np.ndarray], tuple[np.ndarray, np.ndarray]]
#: a change of an instrument and the fit's coefficients to the deviation that it makes
Shows = Callable[[np.ndarray, Mapping[str, float]], np.ndarray]


@dataclass(frozen=True)
class Comparison:
    """How something is compared with an instrument, and what a change would show."""

    serves: Callable[[str], bool]  # whether what has that name can be so compared
    rows: Callable[[ComparedRecord], np.ndarray]  # that are compared
    parts: Parts
    #: daily sums to the deviation of the two
    differ: Callable[[np.ndarray, np.ndarray], np.ndarray]
    shows: dict[str, Shows]  # by sensor fault, or effect
    unit: str = "-"
    ages: bool = False  # whether it fades by itself
    wanders: float = 0.0  # by how much it differs from year to year by itself
    fewest: int = FEWEST_DAYS
    module: bool = False  # whether the module's temperature is in it


def always(record: ComparedRecord) -> np.ndarray:
    return np.ones(len(record.index), dtype=bool)


def bright(record: ComparedRecord) -> np.ndarray:
    """
    Rows on which light is compared.

    Parameters
    ----------
    record : ComparedRecord
        Record with ``poa_global``. [W/m²]

    Returns
    -------
    array of bool, shape (rows,)
        True above 200 W/m².
    """
    return record["poa_global"] > BRIGHT


def dark(record: ComparedRecord) -> np.ndarray:
    return record["poa_global"] <= 0.0


def windy(record: ComparedRecord) -> np.ndarray:
    return record["wind_speed"] > BREEZE


def called(name: str) -> Callable[[str], bool]:
    """Whether something is that one."""
    return lambda other: other == name


def twin(usual: str) -> Callable[[str], bool]:
    """Whether a column is a second sensor of that one."""
    return lambda name: twin_of(name) == usual


def paired_with(usual: str) -> Parts:
    """The column, and the usual column of the instrument."""
    return lambda record, values: (values, record[usual])


def per_irradiance(
    record: ComparedRecord, values: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Power at 25 °C, and the irradiance."""
    return values / (1.0 + GAMMA * (record["temp_module"] - 25.0)), record["poa_global"]


def air_difference(
    record: ComparedRecord, values: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """How much warmer its air is."""
    return values - record["temp_air"], np.ones(len(values))


def air_by_irradiance(
    record: ComparedRecord, values: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The deviation for each 1000 W/m²."""
    return values - record["temp_air"], record["poa_global"] / 1000.0


def over_temperatures(
    record: ComparedRecord, values: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Over-temperatures of both sensors."""
    return values - record["temp_air"], record["temp_module"] - record["temp_air"]


def module_difference(
    record: ComparedRecord, values: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """How much more the other sensor of the module reads."""
    return values - record["temp_module"], np.ones(len(values))


def log_ratio(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.log(one / other)


def of_wind(change: np.ndarray, coefficients: Mapping[str, float]) -> np.ndarray:
    """The share that wind is read less, where each m/s of it has so much more loss."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.log1p(change / coefficients.get("u1", np.inf))


LIGHT: dict[str, Shows] = {"irradiance_sensor": lambda change, _: np.log1p(change)}
#: modules in another plane than the sensor, whose own light is as it should be
STUCK: dict[str, Shows] = {"tracker_stuck": lambda change, _: np.log1p(change)}
WIND: dict[str, Shows] = {"anemometer": of_wind}
AIR: dict[str, Shows] = {"air_offset": lambda change, _: change}
SHELTER: dict[str, Shows] = {"air_sensor_shield": lambda change, _: -change}
CONTACT: dict[str, Shows] = {
    "module_sensor_contact": lambda change, _: -np.log1p(change)
}
OFFSET: dict[str, Shows] = {"module_offset": lambda change, _: -change}

COMPARISONS = (
    Comparison(
        is_power,
        bright,
        per_irradiance,
        log_ratio,
        LIGHT | STUCK,
        ages=True,
        module=True,
    ),
    Comparison(
        called(SKY),
        bright,
        paired_with("poa_global"),
        log_ratio,
        LIGHT,
        wanders=HAZE,
        fewest=FEWEST_CLEAR,
    ),
    Comparison(
        called(USUAL_WIND),
        always,
        paired_with("wind_speed"),
        log_ratio,
        WIND,
        wanders=WINDINESS,
    ),
    Comparison(twin("poa_global"), bright, paired_with("poa_global"), log_ratio, LIGHT),
    Comparison(twin("wind_speed"), windy, paired_with("wind_speed"), log_ratio, WIND),
    Comparison(twin("temp_air"), dark, air_difference, np.divide, AIR, "K"),
    Comparison(twin("temp_air"), bright, air_by_irradiance, np.divide, SHELTER, "K"),
    Comparison(
        twin("temp_module"), bright, over_temperatures, log_ratio, CONTACT, module=True
    ),
    Comparison(
        twin("temp_module"),
        dark,
        module_difference,
        np.divide,
        OFFSET,
        "K",
        module=True,
    ),
)


@dataclass(frozen=True, eq=False)
class DailyDeviation:
    """Daily deviation of two columns."""

    comparison: Comparison
    column: str
    days: np.ndarray  # since 1970-01-01
    apart: np.ndarray
    #: of an effect of a size, more light on the modules [-]
    light: Callable[[Effect, float], np.ndarray] | None = None

    @cached_property
    def usual(self) -> list[np.ndarray]:
        """Daily columns of usual variation."""
        return [np.ones(len(self.days)), *self.year()]

    def along(
        self,
        weights: np.ndarray,
        values: np.ndarray | None = None,
        others: Sequence[np.ndarray] = (),
    ) -> tuple[float, float, np.ndarray]:
        """
        The change along a time profile given others, its error, and the residual.

        Parameters
        ----------
        weights : array, shape (days,)
            The time profile.
        values : array, shape (days,), optional
            By default the deviation.
        others : sequence of array, shape (days,)
            Further time profiles.

        Returns
        -------
        size, error : float
        residual : array, shape (days,)
        """
        values = self.apart if values is None else values
        columns = [*self.usual, *others, weights]
        sums = cluster_sums(columns, values, self.days)
        sums = replace(sums, weeks=sums.weeks * WEEK // MONTH)
        kept = list(range(len(columns)))
        sizes = sums.solve(kept) / sums.scale
        variance = sums.covariance(kept)[-1, -1] / sums.scale[-1] ** 2
        table = np.column_stack(columns)
        error = np.sqrt(variance + self.wandering(table))
        return float(sizes[-1]), float(error), values - table @ sizes

    def wandering(self, table: np.ndarray) -> float:
        """Variance of the last coefficient by what differs from year to year."""
        if not (size := self.comparison.wanders):
            return 0.0
        months, place = np.unique(self.days // MONTH, return_inverse=True)
        share = np.bincount(place, np.linalg.pinv(table)[-1])
        apart = MONTH * np.abs(np.subtract.outer(months, months))
        return size**2 * (share @ np.exp(-apart / YEAR) @ share)

    def year(self) -> Iterator[np.ndarray]:
        """What comes back with the year, of records that are long enough."""
        years, least = np.ptp(self.days) / YEAR, self.comparison.wanders > 0
        angle = 2.0 * np.pi * self.days / YEAR
        for harmonic in range(1, 1 + min(max(int(years), least), 2)):
            yield np.cos(harmonic * angle)
            yield np.sin(harmonic * angle)

    def profiles(self, effects: Iterable[Effect]) -> Iterator[tuple[str, float]]:
        """Log-likelihood of each time profile compared with the best of them."""
        sensor_faults: dict[str, list[Effect]] = {}
        for effect in effects:
            sensor_faults.setdefault(effect.sensor_fault, []).append(effect)
        for same in sensor_faults.values():
            residuals = {}
            for effect in same:
                weights = weights_of(effect, self.days)
                if np.ptp(weights) > 0:
                    residuals[effect.name] = self.along(weights)[2]
            squares = {name: float(rest @ rest) for name, rest in residuals.items()}
            if len(squares) < 2:
                continue
            best = min(squares, key=squares.__getitem__)
            draws = 0.5 * independent_months(residuals[best], self.days // MONTH)
            for name, square in squares.items():
                yield name, draws * float(np.log(squares[best] / square))

    def concerned(self, choice: "Choice") -> list[str]:
        """Members of a choice of which it would show something."""
        members = choice.members.items()
        return [n for n, m in members if kind(m.effect) in self.comparison.shows]

    def shown(
        self,
        choice: "Choice",
        first: Effect,
        names: Sequence[str],
        coefficients: Mapping[str, float],
    ) -> tuple[float, float, dict[str, float], float] | None:
        """
        Its deviation along the profile of an effect, and what members would make it.

        Parameters
        ----------
        choice : Choice
        first : Effect
            With the time profile.
        names : sequence of str
            Of members of the choice.
        coefficients : dict
            Of the fitted model.

        Returns
        -------
        tuple or None
            The deviation, its error, by name what each member would make it, and by how
            much it ages by itself; None where it shows nothing.
        """
        weights = weights_of(first, self.days)
        if not names or not np.ptp(weights) > 0:
            return None
        size, error, residual = self.along(weights)
        if (
            not first.sensor_fault
        ):  # of days or weeks, which are less than a draw of months
            error = by_accident(weights > 0.0, residual)
        expected = {
            name: self.expected(
                choice.members[name].effect,
                float(choice.scores[name].estimate[0]),
                weights,
                coefficients,
            )
            for name in names
        }
        aged = FADES if self.comparison.ages and is_drift(first) else 0.0
        return size, error, expected, aged

    def expected(
        self,
        effect: Effect,
        size: float,
        along: np.ndarray,
        coefficients: Mapping[str, float],
    ) -> float:
        """
        The deviation that a change would make along a time profile.

        Parameters
        ----------
        effect : Effect
            The change.
        size : float
            Its coefficient.
        along : array, shape (days,)
            The time profile.
        coefficients : dict
            Of the fitted model.
        """
        shows = self.comparison.shows.get(kind(effect))
        if shows is None:
            return 0.0
        if effect.sensor_fault:
            change = size * weights_of(effect, self.days)
        elif self.light is not None:
            change = self.light(effect, size)
        else:  # of columns without a record
            return 0.0
        with np.errstate(invalid="ignore", divide="ignore"):
            shown = shows(change, coefficients)
        return self.along(along, shown)[0] if np.isfinite(shown).all() else 0.0


def by_accident(there: np.ndarray, residual: np.ndarray) -> float:
    """Root mean square of the mean residual of as many other days in a row."""
    first, length = int(np.argmax(there)), int(there.sum())
    sums = np.append(0.0, np.cumsum(residual))
    means = (sums[length:] - sums[:-length]) / length
    begins = np.arange(len(means))
    others = means[(begins + length <= first) | (begins >= first + length)]
    return float(np.sqrt(np.mean(others**2))) if len(others) else np.inf


def independent_months(values: np.ndarray, months: np.ndarray) -> float:
    """Number of months less what each remembers of the one before."""
    _, place = np.unique(months, return_inverse=True)
    means = np.bincount(place, values) / np.bincount(place)
    memory = 0.0
    if len(means) > 3 and np.ptp(means) > 0:
        memory = max(float(np.corrcoef(means[1:], means[:-1])[0, 1]), 0.0)
    return len(means) * (1.0 - memory) / (1.0 + memory)


def outcome_of(size: float, expected: float, error: float) -> CheckOutcome:
    """
    Whether a size is significantly nearer to the expected one than to 0.

    A size that is significantly nearer to twice the expected one has another cause, or
    a further one: it cannot tell.
    """
    if expected == 0.0:
        return CheckOutcome.CANNOT_TELL
    ratio = size / expected
    sure = SURE * np.hypot(error, HALF * SLACK * expected) / abs(expected)
    if ratio < HALF - sure:
        return CheckOutcome.CONTRADICTS
    if HALF + sure < ratio < 2.0 - HALF + sure:
        return CheckOutcome.AGREES
    return CheckOutcome.CANNOT_TELL


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
    columns = compared_columns(case)
    return [
        one
        for comparison in COMPARISONS
        for name in filter(comparison.serves, columns)
        if (one := daily_deviation(comparison, case, name, columns[name])) is not None
    ]


def daily_deviation(
    comparison: Comparison, case: ComparedCase, name: str, values: np.ndarray
) -> DailyDeviation | None:
    """
    One comparison, on days that are near the others.

    Parameters
    ----------
    comparison : Comparison
    case : Case
    name : str
        Of what is compared with an instrument.
    values : array, shape (rows,)

    Returns
    -------
    DailyDeviation or None
        None where there are too few days.
    """
    record = case.record
    one, other = comparison.parts(record, values)
    kept = comparison.rows(record) & np.isfinite(one + other)
    if comparison.module:  # whose temperature in other weeks is for the test
        kept &= case.searched
    days, place = np.unique(record.dates[kept], return_inverse=True)
    if len(days) < comparison.fewest:
        return None
    sums = [np.bincount(place, column[kept]) for column in (one, other)]
    deviation = comparison.differ(sums[0], sums[1])
    near = usual_days(deviation)
    if near.sum() < comparison.fewest:
        return None

    def light(effect: Effect, size: float) -> np.ndarray:
        # only the record of a loop has candidates
        columns = derive_drivers(cast(Record, record).inputs, effect.drivers).columns
        terms = effect.at(columns, dict.fromkeys(effect.rows(), size))
        heat = np.broadcast_to(terms.heat, len(kept))
        more, whole = (
            np.bincount(place, np.nan_to_num(column[kept]))
            for column in (heat, record["poa_global"])
        )
        return (more / np.maximum(whole, 1e-9))[near]

    return DailyDeviation(comparison, name, days[near], deviation[near], light)


def kind(effect: Effect) -> str:
    """What a comparison knows an effect by."""
    return effect.sensor_fault or effect.name


def usual_days(values: np.ndarray) -> np.ndarray:
    """
    Days that are near most others, or near those around them.

    What changes for a while stays, however sharp the comparison is, and snow, whose
    days differ from each other, goes.
    """
    known = np.isfinite(values)
    if known.sum() <= NEIGHBOURS:
        return np.zeros(len(values), dtype=bool)
    there = values[known]
    low, middle, high = np.quantile(there, [0.25, 0.5, 0.75])
    near = sliding_window_view(
        np.pad(there, NEIGHBOURS, mode="reflect"), 2 * NEIGHBOURS + 1
    )
    around = np.median(np.delete(near, NEIGHBOURS, axis=1), axis=1)
    away = np.minimum(np.abs(there - middle), np.abs(there - around))
    kept = known.copy()
    kept[known] = away <= OUTLIER * max(high - low, 1e-9)
    return kept


def log_likelihoods(
    references: Sequence[DailyDeviation],
    choice: "Choice",
    coefficients: Mapping[str, float],
) -> dict[str, float]:
    """
    Log-likelihoods of the members of a choice, and of a cause outside, by references.

    The deviation of a reference along the time profile of the best dated member is
    compared with the deviation that each member predicts. A cause that is in no
    instrument predicts none. An effect by a power predicts any that this power may
    show, and so does a cause outside that looks like it. Time profiles of one
    instrument are compared by the residual of the reference given each.

    Parameters
    ----------
    references : sequence of DailyDeviation
    choice : Choice
    coefficients : dict
        Of the fitted model.

    Returns
    -------
    dict of float
        By name, with :data:`~pvlib_fem._findings.OUTSIDE` among them.
    """
    first = compared_along(choice)
    logs = dict.fromkeys([*choice.members, OUTSIDE], 0.0)
    if first is None:
        return logs
    for one in references:
        names = one.concerned(choice)
        shown = one.shown(choice, first, names, coefficients)
        if shown is None:
            continue
        for name, worse in one.profiles([choice.members[n].effect for n in names]):
            logs[name] += worse
        size, error, expected, aged = shown
        expected = dict.fromkeys(logs, 0.0) | expected
        broad = np.hypot(max(abs(value) for value in expected.values()), error)
        anything = density(size, broad)
        for name, value in expected.items():
            own = np.sqrt(error**2 + (SLACK * value) ** 2 + aged**2)
            likely = density(size - value + aged, own)
            # an imitation of an effect by this power shows in it, too
            member = choice.top if name == OUTSIDE else choice.members[name]
            if member.effect.settings.get("source") == one.column:
                likely = anything
            logs[name] += float(np.log((1.0 - ODD) * likely + ODD * anything))
    return logs


def is_compared(effect: Effect) -> bool:
    """
    Whether a choice, of which an effect is the best, is compared with references.

    Parameters
    ----------
    effect : Effect

    Returns
    -------
    bool
        True if it has a time profile, or follows a power.
    """
    return is_dated(effect) or is_power(effect.settings.get("source", ""))


def compared_along(choice: "Choice") -> Effect | None:
    """The best member with a time profile; None if the choice is not compared."""
    if not is_compared(choice.top.effect):
        return None
    names = sorted(choice.weights, key=lambda name: -choice.weights[name])
    effects = (choice.members[name].effect for name in names)
    return next(filter(is_dated, (choice.top.effect, *effects)), None)


def cross_checks(
    references: Sequence[DailyDeviation],
    choice: "Choice",
    first: Effect,
    coefficients: Mapping[str, float],
) -> tuple[CrossCheck, ...]:
    """
    What each reference shows along the time profile of the first, by instrument.

    Parameters
    ----------
    references : sequence of DailyDeviation
    choice : Choice
        With the probabilities of its members.
    first : Effect
        The most probable member.
    coefficients : dict
        Of the fitted model.

    Returns
    -------
    tuple of CrossCheck
    """
    checks: list[CrossCheck] = []
    for one in references if is_dated(first) else ():
        alike = [
            name
            for name in one.concerned(choice)
            if time_profile_of(choice.members[name].effect) == time_profile_of(first)
            and max(choice.probabilities[name], choice.weights[name]) >= WORTH
        ]
        shown = one.shown(choice, first, alike, coefficients) if alike else None
        if shown is None:
            continue
        size, error, expected, aged = shown
        years = years_to_end(first)  # of a trend that ends, what it reaches
        unit = one.comparison.unit + ("/year" if is_drift(first) and not years else "")
        times = years or 1.0
        for name in alike:
            value = expected[name] - aged
            outcome = outcome_of(size, value, float(np.hypot(error, aged / SURE)))
            numbers = (times * size, times * error, times * value)
            checks.append(CrossCheck(one.column, name, *numbers, outcome, unit))
    return tuple(checks)
