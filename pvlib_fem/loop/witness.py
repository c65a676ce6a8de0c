"""
What else in a record vouches for an instrument, or speaks against a change of it.

A witness is a column that sees what an instrument should see: power and a second
sensor. Where the instrument has changed and not what it measures, the two part along
the same course; where the change is elsewhere, they do not.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pvlib_fem.effects.courses import is_drift, weights_of
from pvlib_fem.findings import Opinion, Witness
from pvlib_fem.record.columns import is_power, twin_of
from pvlib_fem.statistics.clusters import WEEK, cluster_sums

BRIGHT = 200.0  # W/m², above which light is compared
BREEZE = 1.0  # m/s, above which wind is
GAMMA = -0.004  # 1/K, of power: crystalline silicon, as PVWatts has it
SLACK = 0.15  # of what is expected: a thermal coefficient is no better than that
FADES = 0.005  # of power by a module that ages; up to twice as much, or none [1/year]
HALF = 0.5  # of what is expected: less is nearer to nothing
SURE = 2.0  # standard errors
FEWEST_DAYS = 40  # on which both are there
MONTH = 4 * WEEK  # days that are one draw of the weather
OUTLIER = 4.0  # interquartile ranges from the median: snow, a fault, clipped power
BETTER = 10.0  # of twice a log-likelihood, by which one course beats another


@dataclass(frozen=True)
class Comparison:
    """How a column is compared with an instrument, and what a change would show."""

    serves: Callable  # whether a column of that name can be so compared
    rows: Callable  # record to the rows that are compared
    parts: Callable  # record and the column to two columns, whose sums are compared
    differ: Callable  # those sums by the day to how far the two are apart
    shows: dict  # channel: its change and the fit's coefficients to what is shown
    moved: Callable | None  # the column and what is shown to one that shows it
    unit: str = "-"
    ages: bool = False  # whether it fades by itself


def bright(record):
    return record["poa_global"] > BRIGHT


def dark(record):
    return record["poa_global"] <= 0.0


def windy(record):
    return record["wind_speed"] > BREEZE


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


def times(values, shown, record):
    """A column that is by so much the logarithm larger."""
    return values * np.exp(shown)


def plus(values, shown, record):
    return values + shown


def plus_sun(values, shown, record):
    """A column that is by so much warmer for each 1000 W/m²."""
    return values + shown * np.nan_to_num(record["poa_global"]) / 1000.0


def of_wind(change, coefficients):
    """The share that wind is read less, where each m/s of it has so much more loss."""
    return np.log1p(change / coefficients.get("u1", np.inf))


LIGHT = {"sensitivity": lambda change, _: np.log1p(change)}
WIND = {"wind_gain": of_wind}
AIR = {"air_offset": lambda change, _: change}
SHELTER = {"air_shelter": lambda change, _: -change}
CONTACT = {"contact": lambda change, _: -np.log1p(change)}

COMPARISONS = (
    Comparison(is_power, bright, power, logs, LIGHT, times, ages=True),
    Comparison(twin("poa_global"), bright, beside("poa_global"), logs, LIGHT, times),
    Comparison(twin("wind_speed"), windy, beside("wind_speed"), logs, WIND, times),
    Comparison(twin("temp_air"), dark, warmer, np.divide, AIR, plus, "K"),
    Comparison(twin("temp_air"), bright, warmed, np.divide, SHELTER, plus_sun, "K"),
    # where the module's own sensor changes, a second one stays
    Comparison(twin("temp_module"), bright, over, logs, CONTACT, None),
)


@dataclass(frozen=True, eq=False)
class Apart:
    """How far two columns are apart, by the day."""

    comparison: Comparison
    column: str
    days: np.ndarray  # since 1970-01-01
    apart: np.ndarray

    def along(self, weights, values=None):
        """The change along a course, its error, and the mean square that it leaves."""
        values = self.apart if values is None else values
        columns = [np.ones(len(self.days)), *self.year(), weights]
        sums = cluster_sums(columns, values, self.days)
        sums = replace(sums, weeks=sums.weeks * WEEK // MONTH)
        kept = list(range(len(columns)))
        found = sums.solve(kept) / sums.scale
        error = np.sqrt(sums.covariance(kept)[-1, -1]) / sums.scale[-1]
        left = values - np.column_stack(columns) @ found
        return float(found[-1]), float(error), float(np.mean(left**2))

    def year(self):
        """What comes back with the year, of records that are long enough."""
        years = np.ptp(self.days) / 365.25
        angle = 2.0 * np.pi * self.days / 365.25
        for harmonic in range(1, 1 + min(int(years), 2)):
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
        doubt = [error, SLACK * expected, expected * stderr / coefficient]
        if self.comparison.ages and is_drift(effect):
            expected, doubt = expected - FADES, [*doubt, FADES / SURE]
        if expected == 0.0:
            return None
        share = size / expected
        doubt = SURE * np.linalg.norm(doubt) / abs(expected)
        opinion = Opinion.CANNOT_TELL
        if share - doubt > HALF:
            opinion = Opinion.AGREES
        elif share + doubt < HALF:
            opinion = Opinion.CONTRADICTS
        unit = self.comparison.unit + ("/year" if is_drift(effect) else "")
        sizes = (size, error, float(expected))
        return Witness(self.column, effect.name, *sizes, opinion, unit)


def showing(record, columns, effect, change, coefficients):
    """
    Columns that see an instrument, as they are where it changes by so much.

    Parameters
    ----------
    record : Record
    columns : dict of array
        Those that vouch for instruments, on the rows of the record.
    effect : Effect
    change : float
        Its coefficient.
    coefficients : dict
        Of the fit.

    Returns
    -------
    dict of array
        Those that are others.
    """
    found = {}
    for comparison in COMPARISONS:
        shows = comparison.shows.get(effect.channel)
        if shows is None or comparison.moved is None:
            continue
        shown = shows(change * weights_of(effect, record.dates), coefficients)
        for name in filter(comparison.serves, columns):
            found[name] = comparison.moved(columns[name], shown, record)
    return found


def apart(record, rows, names):
    """All comparisons that some rows of a record allow."""
    found = []
    for comparison in COMPARISONS:
        for name in filter(comparison.serves, names):
            one, other = comparison.parts(record, record[name])
            kept = rows & comparison.rows(record) & np.isfinite(one + other)
            days, place = np.unique(record.dates[kept], return_inverse=True)
            if len(days) < FEWEST_DAYS:
                continue
            sums = (np.bincount(place, column[kept]) for column in (one, other))
            values = comparison.differ(*sums)
            near = usual(values)
            if near.sum() >= FEWEST_DAYS:
                found.append(Apart(comparison, name, days[near], values[near]))
    return found


def usual(values):
    """Days that are near the others."""
    known = np.isfinite(values)
    low, middle, high = np.quantile(values[known], [0.25, 0.5, 0.75])
    return known & (np.abs(values - middle) <= OUTLIER * max(high - low, 1e-9))


@dataclass(frozen=True)
class Hearing:
    """What is left of a class when its witnesses have been heard."""

    candidates: tuple  # the first is taken
    witnesses: tuple = ()
    agreed: bool = False  # whether a witness speaks for what is left


def hearing(comparisons, candidates, rivals, effects, weights, coefficients):
    """
    Ask all witnesses about the candidates of a class.

    One that a witness contradicts is none; if witnesses agree with some, only those
    are left. ``rivals`` are further ones that explain less, as another course of the
    same channel, and come in where a witness agrees with them.
    """
    said = dict.fromkeys(candidates, ())
    changes = [n for n in (*candidates, *rivals) if n in weights and effects[n].channel]
    for name in changes:
        (size,), (error,) = (
            part.values() for part in (weights[name].coefficients, weights[name].stderr)
        )
        heard = (c.of(effects[name], size, error, coefficients) for c in comparisons)
        said[name] = [one for one in heard if one is not None]
    opinions = {name: {one.opinion for one in heard} for name, heard in said.items()}
    against = [n for n, all_ in opinions.items() if Opinion.CONTRADICTS in all_]
    agreed = [
        name
        for name, all_ in opinions.items()
        if Opinion.AGREES in all_ and name not in against
    ]
    if agreed:
        best = courses(comparisons, agreed, effects)
        channel = effects[best[0]].channel
        others = [
            n for n in candidates if n in agreed and effects[n].channel != channel
        ]
        kept = asked = (*best, *others)
    else:
        asked = candidates
        kept = [name for name in candidates if name not in against]
        if not any(name in weights for name in kept):  # none that could be added
            kept = candidates
        kept = sorted(kept, key=lambda name: name not in weights)
    witnesses = tuple(one for name in asked for one in said[name])
    return Hearing(tuple(kept), witnesses, bool(agreed))


def courses(comparisons, agreed, effects):
    """Of candidates of one channel those whose course witnesses follow best."""
    channel, left = effects[agreed[0]].channel, {}
    asked = [one for one in comparisons if channel in one.comparison.shows]
    for name in (n for n in agreed if effects[n].channel == channel):
        squares = [one.along(weights_of(effects[name], one.days))[2] for one in asked]
        months = [len(np.unique(one.days // MONTH)) for one in asked]
        left[name] = float(np.dot(months, np.log(squares)))
    best = min(left, key=left.get)
    near = [n for n in left if n != best and left[n] < left[best] + BETTER]
    return (best, *near)
