"""
A cause outside the catalogue that follows the same inputs: how probable it is.

A true effect is the same under all conditions in which it acts. What only stands for
something unknown is not: once the unknown may differ from one condition to the next
(random effects of tables), little of it is left.
"""

from dataclasses import dataclass, replace

import numpy as np

from pvlib_fem.drivers import needed_for
from pvlib_fem.findings import OUTSIDE
from pvlib_fem.loop.design import FEWEST_WEEKS
from pvlib_fem.record.columns import COLUMNS, GEOMETRY
from pvlib_fem.statistics.weekly import LeastSquares, products

TINY = 1e-100  # density of what is as far as anything
BINS = 8  # of a driver, with equal numbers of cells
AZIMUTH, ELEVATION = 12.0, 6.0  # degrees of sun position
FAR = 0.35  # spread of the part that is left of what stands for something unknown
ALIKE = 0.1  # of unknown causes that follow a driver, as alike as its effect
REFLECTION = 0.5  # of what takes light from a sensor and not from the module


@dataclass(frozen=True)
class Beyond:
    """Prior of a cause outside the catalogue, for a kind of candidates."""

    odds: float  # probability that it is what the inputs follow
    alike: float  # probability that it follows them exactly as the candidate


def prior_of(effect, outside):
    """The prior of a cause outside the catalogue as a rival of an effect."""
    if effect.settings.get("sensor"):  # a reflection onto the module looks the same
        return Beyond(REFLECTION, 1.0)
    own = {*needed_for(effect.drivers)} - {*COLUMNS[:3], *GEOMETRY}
    if effect.channel or (own and not effect.confounder):
        return Beyond(outside, ALIKE)
    # what follows the sun and the usual inputs alone may be anything that does
    return Beyond(outside, 1.0)


def with_outside(design, choice, given, criteria, logs=None):
    """
    The choice with the probability of each member and of a cause outside.

    Parameters
    ----------
    design : Design
    choice : Choice
        With members and their weights.
    given : sequence
        Columns of the base and of the other choices.
    criteria : Criteria
    logs : dict, optional
        Log-likelihoods by references of each member, and of :data:`OUTSIDE`.
    """
    logs = logs or dict.fromkeys([*choice.members, OUTSIDE], 0.0)
    most = max(logs.values())
    times = {name: float(np.exp(log - most)) for name, log in logs.items()}
    mine, outside, spread = {}, 0.0, {}
    for name, one in choice.members.items():
        weight = choice.weights[name] * times[name]
        prior = prior_of(one.effect, criteria.outside)
        inside, beyond, spread[name] = likelihoods(
            design, one, given, criteria.law_error
        )
        mine[name] = weight * (1.0 - prior.odds) * inside
        unknown = prior.alike * inside + (1.0 - prior.alike) * beyond
        if prior.alike == 1.0:
            unknown += max(beyond - inside, 0.0)
        outside += choice.weights[name] * times[OUTSIDE] * prior.odds * unknown
    total = sum(mine.values()) + outside
    probabilities = {n: p / total for n, p in mine.items()}
    probabilities[OUTSIDE] = outside / total
    return replace(choice, probabilities=probabilities, spread=spread)


def likelihoods(design, one, given, law):
    """
    How likely its size within tables is, of it and of something unknown.

    By the table that speaks most against it; and the largest share by which a table
    changes its size, beyond the error of that.
    """
    worst, spread = None, 0.0
    for groups in tables(design, one.effect):
        found = kept(design, one, given, groups)
        if found is None:
            continue
        share, error = found
        spread = max(spread, abs(share - 1.0) - error)
        true = density(share - 1.0, np.hypot(error, law))
        other = density(share, np.hypot(error, FAR))
        if worst is None or true / other < worst[0] / worst[1]:
            worst = true, other
    return *(worst or (1.0, 1.0)), spread


def density(distance, width):
    return max(float(np.exp(-0.5 * (distance / width) ** 2) / width), TINY)


def kept(design, one, given, groups):
    """Share of its size that is left within groups of a table, and its error."""
    columns = [*given, *(c for c in one.columns if c not in given)]
    values = np.column_stack([design.cells[:, 0], *(design.values(c) for c in columns)])
    count = np.bincount(groups, design.rows)
    within = values.copy()
    for i in range(values.shape[1]):
        means = np.bincount(groups, values[:, i] * design.rows) / count
        within[:, i] -= means[groups]
    starts = np.append(design.first[design.clusters], len(design.rows))
    size = len(one.columns)
    plain = LeastSquares(design.by_week(columns), size)
    other = LeastSquares(products(within, design.rows, starts), size)
    before = np.diag(plain.whole)[-size:]
    after = np.diag(other.whole)[-size:]
    if (after < 1e-3 * before).any():
        return None
    # along the estimate, in the metric of what it explains
    metric = plain.whole[-size:, -size:] @ plain.estimate
    length = metric @ plain.estimate
    if not length > 0:
        return None
    share = float(metric @ other.estimate / length)
    shifts = other.shifts @ metric / length - share * (plain.shifts @ metric / length)
    weeks = len(shifts)
    error = np.sqrt((weeks - 1) / weeks * np.square(shifts - shifts.mean()).sum())
    return share, float(error)


def tables(design, effect):
    """Group of each cell, by each table of unknown structure."""
    places = design.places
    own = {*effect.drivers, *needed_for(effect.drivers)}
    usual = {
        name: binned(places[name], places["poa_global"] > 0.0)
        for name in ("poa_global", "wind_speed", "temp_air")
    }
    hour, month = places["hour"].astype(int), places["month"].astype(int)
    yield grouped(hour, month)
    yield grouped(hour, places["weekend"].astype(int))
    light, wind, air = usual.values()
    yield grouped(light, wind)
    yield grouped(light, air)
    yield grouped(wind, air)
    if "solar_azimuth" in places and "solar_zenith" in places:
        up = places["solar_zenith"] < 90.0
        azimuth = np.where(up, places["solar_azimuth"] // AZIMUTH, -1).astype(int)
        height = np.where(up, places["solar_zenith"] // ELEVATION, -1).astype(int)
        yield grouped(azimuth + 1, height + 1)
    if not effect.channel and len(design.clusters) >= FEWEST_WEEKS:
        weeks = np.zeros(len(design.dates), dtype=int)
        weeks[design.clusters[1:]] = 1
        lengths = np.diff(design.first, append=len(design.days))
        yield np.repeat(np.cumsum(weeks), lengths)
    skip = {*usual, *own, "hour", "month", "weekend"}
    skip |= {"solar_azimuth", "solar_zenith", "aoi"}
    for name, values in places.items():
        if name in skip or np.ptp(values) == 0:
            continue
        yield grouped(binned(values), hour // 2)


def binned(values, some=None):
    """Bins with equal numbers of cells; a value that is common has its own."""
    some = np.ones(len(values), dtype=bool) if some is None else some
    if some.any():
        common = np.median(values[some])
        if (values[some] == common).mean() > 1.0 / BINS:
            some = some & (values != common)
    if some.sum() < BINS:
        return some.astype(int)
    edges = np.quantile(values[some], np.linspace(0.0, 1.0, BINS + 1)[1:-1])
    found = np.searchsorted(np.unique(edges), values, side="right") + 1
    return np.where(some, found, 0)


def grouped(one, other):
    """Number of each pair of bins that occurs."""
    pairs = one.astype(np.int64) * 1000 + other
    return np.unique(pairs, return_inverse=True)[1]
