"""
What is compared with an instrument: power, second sensors, a clear sky, usual wind.

Where the instrument has changed and not what it measures, the two part along the same
course; where the change is elsewhere, they do not.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from pvlib_fem.effects.courses import is_drift, weights_of
from pvlib_fem.findings import Opinion, Witness
from pvlib_fem.quality.clearsky import clear_sky
from pvlib_fem.record.columns import is_power, twin_of
from pvlib_fem.statistics.changes import UNSEEN, gained_by_two
from pvlib_fem.statistics.clusters import WEEK, cluster_sums, starts

BRIGHT = 200.0  # W/m², above which light is compared
BREEZE = 1.0  # m/s, above which wind is
GAMMA = -0.004  # 1/K, of power: crystalline silicon, as PVWatts has it
SLACK = 0.15  # of what is expected: a thermal coefficient is no better than that
FADES = 0.005  # of power by a module that ages; up to twice as much, or none [1/year]
HALF = 0.5  # of what is expected: less is nearer to nothing
SURE = 2.0  # standard errors
SIDES = (-SURE, SURE)
FEWEST_DAYS = 40  # on which both are there
FEWEST_CLEAR = 20  # clear days, since most of the noise is in the others
FEWEST_MONTHS = 4  # of which a memory from one to the next can be told
MONTH = 4 * WEEK  # days that are one draw of the weather
YEAR = 365.25  # days, over which weather forgets what it was
NEIGHBOURS = 4  # compared days before and after one that may be as it is
OUTLIER = 4.0  # interquartile ranges from the median: snow, a fault, clipped power
HAZE = 0.02  # of a clear sky's light, from year to year: aerosol and water [-]
WINDINESS = 0.1  # of the mean wind, from season to season and from year to year [-]
SKY, USUAL_WIND = "clear sky", "usual wind"  # no names of columns


@dataclass(frozen=True)
class Comparison:
    """How something is compared with an instrument, and what a change would show."""

    serves: Callable  # whether what has that name can be so compared
    rows: Callable  # record to the rows that are compared
    parts: Callable  # record and the column to two columns, whose sums are compared
    differ: Callable  # those sums by the day to how far the two are apart
    shows: dict  # channel: its change and the fit's coefficients to what is shown
    unit: str = "-"
    ages: bool = False  # whether it fades by itself
    wanders: float = 0.0  # by how much it differs from year to year by itself
    fewest: int = FEWEST_DAYS
    module: bool = False  # whether the module's temperature is in it


def always(record):
    return np.ones(len(record.index), dtype=bool)


def bright(record):
    return record["poa_global"] > BRIGHT


def dark(record):
    return record["poa_global"] <= 0.0


def windy(record):
    return record["wind_speed"] > BREEZE


def called(name):
    """Whether something is that one."""
    return lambda other: other == name


def twin(usual):
    """Whether a column is a second sensor of that one."""
    return lambda name: twin_of(name) == usual


def beside(usual):
    """The column itself, and the usual one."""
    return lambda record, values: (values, record[usual])


def power(record, values):
    """Power at 25 °C, and the irradiance."""
    return values / (1.0 + GAMMA * (record["temp_module"] - 25.0)), record["poa_global"]


def warmer(record, values):
    """How much warmer its air is."""
    return values - record["temp_air"], np.ones(len(values))


def warmed(record, values):
    """The same, for each 1000 W/m²."""
    return values - record["temp_air"], record["poa_global"] / 1000.0


def over(record, values):
    """Over-temperatures of both sensors."""
    return values - record["temp_air"], record["temp_module"] - record["temp_air"]


def logs(one, other):
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.log(one / other)


def shares(one, other):
    """The ratio, of what it usually is."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = one / other
    return ratio / np.nanmedian(ratio)


def of_wind(change, coefficients):
    """The share that wind is read less, where each m/s of it has so much more loss."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.log1p(change / coefficients.get("u1", np.inf))


LIGHT = {"sensitivity": lambda change, _: np.log1p(change)}
WIND = {"wind_gain": of_wind}
AIR = {"air_offset": lambda change, _: change}
SHELTER = {"air_shelter": lambda change, _: -change}
CONTACT = {"contact": lambda change, _: -np.log1p(change)}

COMPARISONS = (
    Comparison(is_power, bright, power, logs, LIGHT, ages=True, module=True),
    Comparison(
        called(SKY),
        bright,
        beside("poa_global"),
        logs,
        LIGHT,
        wanders=HAZE,
        fewest=FEWEST_CLEAR,
    ),
    Comparison(
        called(USUAL_WIND),
        always,
        beside("wind_speed"),
        logs,
        WIND,
        wanders=WINDINESS,
    ),
    Comparison(twin("poa_global"), bright, beside("poa_global"), logs, LIGHT),
    Comparison(twin("wind_speed"), windy, beside("wind_speed"), logs, WIND),
    Comparison(twin("temp_air"), dark, warmer, np.divide, AIR, "K"),
    Comparison(twin("temp_air"), bright, warmed, np.divide, SHELTER, "K"),
    Comparison(twin("temp_module"), bright, over, logs, CONTACT, module=True),
)


#: whether the plant fed, which is no change of an instrument
OUTAGE = Comparison(is_power, bright, power, shares, {}, module=True)


@dataclass(frozen=True, eq=False)
class Apart:
    """How far two columns are apart, by the day."""

    comparison: Comparison
    column: str
    days: np.ndarray  # since 1970-01-01
    apart: np.ndarray
    known: tuple = ()  # changes that are in the model

    def beside(self, changes):
        """The same, where some changes are known."""
        shows = self.comparison.shows
        return replace(self, known=tuple(c for c in changes if c.channel in shows))

    @cached_property
    def usual(self):
        """What comes and goes of itself, or is known, by the day."""
        known = (weights_of(effect, self.days) for effect in self.known)
        usual = [np.ones(len(self.days)), *self.year()]
        return [*usual, *(w for w in known if np.ptp(w) > 0)]

    def along(self, weights, values=None):
        """The change along a course, its error, and what it leaves."""
        values = self.apart if values is None else values
        columns = [*self.usual, weights]
        sums = cluster_sums(columns, values, self.days)
        sums = replace(sums, weeks=sums.weeks * WEEK // MONTH)
        kept = list(range(len(columns)))
        found = sums.solve(kept) / sums.scale
        variance = sums.covariance(kept)[-1, -1] / sums.scale[-1] ** 2
        table = np.column_stack(columns)
        error = np.sqrt(variance + self.wandering(table))
        left = values - table @ found
        return float(found[-1]), float(error), left

    def misfits(self, courses, dates):
        """
        Twice the log-likelihood that courses lack, and that steps at two dates lack.

        By months and the memory of what the best of all leaves: part of a change that
        is left would be remembered for long.

        Parameters
        ----------
        courses : array
            Weights by the day, a row for each.
        dates : array
            Of steps, in days since 1970-01-01.

        Returns
        -------
        array, array
            By course; by both dates, of which twice the same one is one step.
        """
        basis = np.linalg.qr(np.column_stack(self.usual))[0]
        rows = np.vstack([courses, self.days >= dates[:, None]]).astype(float)
        rest, own = (v - (v @ basis) @ basis.T for v in (self.apart, rows))
        sizes = np.square(own).sum(axis=1)
        # a course that is usual, or known, takes nothing
        own[sizes <= UNSEEN * np.square(rows).sum(axis=1)] = 0.0
        own, steps = own[: len(courses)], own[len(courses) :]
        alone, pairs = taken(rest, own), taken_by_two(rest, steps)
        best = own[[np.argmax(alone)]]
        if np.max(pairs, initial=0.0) > np.max(alone):
            best = steps[[*np.unravel_index(np.argmax(pairs), pairs.shape)]]
        left = rest - best.T @ np.linalg.lstsq(best.T, rest, rcond=None)[0]
        first, _ = starts(self.days // MONTH)
        means = np.add.reduceat(left, first) / np.diff(first, append=len(left))
        memory = 0.0
        if len(means) >= FEWEST_MONTHS and np.ptp(means) > 0:
            memory = max(remembered(means), 0.0)
        draws = len(means) * (1.0 - memory) / (1.0 + memory)
        whole = rest @ rest
        # of what follows a course to the last digit rounding is left
        floor = max(UNSEEN**2 * whole, np.finfo(float).tiny)
        lacks = (np.maximum(whole - part, floor) / len(rest) for part in (alone, pairs))
        return tuple(draws * np.log(one) for one in lacks)

    def wandering(self, table):
        """Variance of the last coefficient by what differs from year to year."""
        if not (size := self.comparison.wanders):
            return 0.0
        months, place = np.unique(self.days // MONTH, return_inverse=True)
        share = np.bincount(place, np.linalg.pinv(table)[-1])
        apart = MONTH * np.abs(np.subtract.outer(months, months))
        return size**2 * (share @ np.exp(-apart / YEAR) @ share)

    def year(self):
        """What comes back with the year, of records that are long enough."""
        years, least = np.ptp(self.days) / YEAR, self.comparison.wanders > 0
        angle = 2.0 * np.pi * self.days / YEAR
        for harmonic in range(1, 1 + min(max(int(years), least), 2)):
            yield np.cos(harmonic * angle)
            yield np.sin(harmonic * angle)

    def of(self, effect, coefficient, stderr, coefficients):
        """What it says of an effect of that size, or None."""
        shows = self.comparison.shows.get(effect.channel)
        if shows is None:
            return None
        weights = weights_of(effect, self.days)
        if not np.ptp(weights) > 0:
            return None
        size, error, _ = self.along(weights)
        with np.errstate(invalid="ignore"):
            shown = shows(coefficient * weights, coefficients)
        expected = self.along(weights, shown)[0] if np.isfinite(shown).all() else 0.0
        if expected == 0.0:
            return None
        aged = FADES if self.comparison.ages and is_drift(effect) else 0.0
        error_or_age = np.hypot(error, aged / SURE)
        own = np.hypot(error_or_age, SLACK * expected)
        ends = (coefficient * (size + aged + side * own) / expected for side in SIDES)
        low, high = sorted(ends)
        doubt = expected * np.hypot(SLACK, stderr / coefficient)
        expected = float(expected - aged)
        opinion = opinion_of(size, expected, error_or_age, doubt)
        unit = self.comparison.unit + ("/year" if is_drift(effect) else "")
        said = (size, error, expected, opinion, unit, float(low), float(high))
        return Witness(self.column, effect.name, *said)


def taken(rest, columns):
    """What each column takes of a sum of squares."""
    sizes = np.square(columns).sum(axis=1)
    products = columns @ rest
    return np.divide(products**2, sizes, out=np.zeros(len(sizes)), where=sizes > 0)


def taken_by_two(rest, columns):
    """What each two columns take together, and what one takes twice the same."""
    both, products, alone = columns @ columns.T, columns @ rest, taken(rest, columns)
    sizes = np.diag(both)
    pairs = [np.meshgrid(part, part) for part in (products, sizes)]
    together = gained_by_two(*pairs, both, UNSEEN * np.outer(sizes, sizes))
    return np.maximum(together, np.maximum.outer(alone, alone))


def remembered(means):
    """Correlation of each with the one before."""
    return float(np.corrcoef(means[1:], means[:-1])[0, 1])


def opinion_of(size, expected, error, doubt=0.0):
    """
    Whether a size is what is expected, or nearer to nothing, as far as is sure.

    ``error`` is that of the size, ``doubt`` that of what is expected, of which half
    parts the two.
    """
    beyond = (size - HALF * expected) / expected
    sure = SURE * np.hypot(error, HALF * doubt) / abs(expected)
    if beyond > sure:
        return Opinion.AGREES
    return Opinion.CONTRADICTS if beyond < -sure else Opinion.CANNOT_TELL


def heard_of(case):
    """All that is compared with instruments, by name: columns, sky and weather."""
    record = case.record
    found = {name: record[name] for name in case.witnesses}
    found[USUAL_WIND] = np.ones(len(record.index))
    if case.place["location"] is not None:
        place = list(case.place.values())
        angles = None if None in place[1:] else tuple(place[1:])
        how = (record.index, place[0], angles, case.late)
        found[SKY] = clear_sky(record["poa_global"], *how)
    return found


def apart(case):
    """All comparisons that some rows of a record allow."""
    columns = heard_of(case)
    return [
        one
        for comparison in COMPARISONS
        for name in filter(comparison.serves, columns)
        if (one := compared(comparison, case, name, columns[name])) is not None
    ]


def compared(comparison, case, name, values, near=None):
    """One comparison, on days that are ``near`` the others, or None."""
    record = case.record
    one, other = comparison.parts(record, values)
    kept = comparison.rows(record) & np.isfinite(one + other)
    if comparison.module:  # whose other weeks are for choosing and for the test
        kept &= case.searched
    days, place = np.unique(record.dates[kept], return_inverse=True)
    if len(days) < comparison.fewest:
        return None
    sums = (np.bincount(place, column[kept]) for column in (one, other))
    found = comparison.differ(*sums)
    near = (near or usual)(found)
    if near.sum() < comparison.fewest:
        return None
    return Apart(comparison, name, days[near], found[near])


def usual(values):
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
