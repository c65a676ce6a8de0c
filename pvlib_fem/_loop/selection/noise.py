"""
Undeclared causes: random effects, and the probability of a cause outside.

Patterns that repeat from week to week are random effects of tables, by which the
columns are whitened. A true effect has the same size under all conditions in which it
acts, and no residual along its own drivers. An effect that replaces an unknown cause
loses its size within those tables, or has a residual as large as what it explains.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from pvlib_fem._findings import OUTSIDE, SNOW
from pvlib_fem._record.column_names import COLUMNS, GEOMETRY
from pvlib_fem._statistics.axes import CLOCK, Axis, sorted_by
from pvlib_fem._statistics.tables import (
    Cells,
    Table,
    cell_numbers,
    largest_table,
)
from pvlib_fem._statistics.weekly_sums import LeastSquares, products_with
from pvlib_fem.drivers import MODELLED, needed_for, own_columns
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._instruments import INERTIA, OF_NO_COEFFICIENT, OFFSETS
from pvlib_fem.effects._time_profiles import weights_of

if TYPE_CHECKING:
    from pvlib_fem._loop.criteria import Criteria
    from pvlib_fem._loop.regression.design import Column, Design
    from pvlib_fem._loop.selection.choice import Choice
    from pvlib_fem._loop.selection.dictionary import Candidate

Kind = tuple[Axis, ...]  # axes of a table
#: values of cells to the mean of each one's group
Means = Callable[[np.ndarray], np.ndarray]
DIGITS = 9  # of a probability
TINY = 1e-100  # density of what is as far as anything
FAR = 0.35  # spread of the part of an effect that holds under other conditions
POSITION = ("solar_azimuth", "solar_zenith")  # of the sun
#: axes of the tables in which an effect has to have the same size
PAIRS = (
    ("hour", "month"),
    ("hour", "weekend"),
    ("poa_global", "wind_speed"),
    ("poa_global", "temp_air"),
    ("wind_speed", "temp_air"),
    POSITION,
)
MOST_TABLES = 3  # of random effects
ALIKE = 0.1  # of other causes, as alike as an effect whose law they would break
#: probability that the modules have more light by a reflection, not the sensor less by
#: shade; below a half, since its law is the same, so that a model with it is right in
#: either case
REFLECTED = 0.45
AIR = "air_offset"  # of the thermometer that shows the frost
SEEN = 1e-4  # of a column's square: with less of it nothing is seen
EVEN = 0.5  # probability that a change is snow or ice, if both explain it alike


def prior_of(effect: Effect, outside: float) -> tuple[float, float]:
    """Probability of a cause outside as a rival, and that it looks alike."""
    if effect.unseen_light:  # a reflection onto the modules looks the same
        return REFLECTED, 1.0
    # heat along a user's column is no law that another cause would break, and all that
    # stores heat near the modules makes them slower, some of it for a season
    slower = effect.sensor_fault in INERTIA
    if effect.column or effect.imitable or slower:
        return outside, 1.0
    dated = effect.sensor_fault or effect.turns  # a fault of one device from a date on
    if dated or (own_columns(effect.drivers) and not effect.confounder):
        return outside, ALIKE
    # what follows the sun and the usual inputs alone may be anything that does
    return outside, 1.0


def by_snow(
    design: "Design",
    choice: "Choice",
    name: str,
    given: Sequence["Column"],
    law: float,
) -> float:
    """
    Probability that a member that is a change is snow or ice on modules or sensors.

    These last until they melt: of a change of a sensor or mounting, the same size
    remains without the hours in which snow can lie, and of snow nothing does. Snow
    alters light, wind and the loss of heat, as most faults do. An offset is the same
    by day and night, as one in ten causes may be that snow brings. A fault of the air
    sensor alters in which hours snow can lie.
    """
    one = choice.members[name]
    fault = one.effect.sensor_fault
    if not fault:
        return 0.0
    if fault == AIR:
        shift = choice.scores[name].estimate[0] * design.weight(one.change)
        rows = design.without_snow(shift)
    else:
        rows = design.rows_without_snow
    if rows is None:
        return 0.0
    free = replace(design, rows=rows)
    # what the instrument has had all the time is no change
    every = [*dict.fromkeys([*given, one.change.place]), one.change]
    columns = [design.cells[:, 0], *map(design.values, every)]
    plain = LeastSquares(design.by_week(every), 1)
    other = LeastSquares(free.weekly_products(np.array(columns).T), 1)
    (size,), (remains,) = plain.estimate, other.estimate
    device = snow = 1.0
    if other.weights.sum() > SEEN * plain.weights.sum() and size:
        variance = other.by_all_weeks()[0][0, 0]
        width = float(np.hypot(np.sqrt(variance), law * size))
        device, snow = density(remains - size, width), density(remains, width)
    snow *= EVEN * (ALIKE if fault in OFFSETS else 1.0)
    return snow / (snow + (1.0 - EVEN) * device)


def with_outside(
    design: "Design",
    choice: "Choice",
    given: Sequence["Column"],
    criteria: "Criteria",
    logs: Mapping[str, float] | None = None,
) -> "Choice":
    """
    The choice with the probability of each member, of snow and of a cause outside.

    Parameters
    ----------
    design : Design
    choice : Choice
        With members and their weights.
    given : sequence of int or Changed
        Columns of the base and of the other choices.
    criteria : Criteria
    logs : dict, optional
        Log-likelihoods by references of each member, and of :data:`OUTSIDE`.

    Returns
    -------
    Choice
    """
    logs = logs or dict.fromkeys([*choice.members, OUTSIDE], 0.0)
    most = max(logs.values())
    times = {name: float(np.exp(log - most)) for name, log in logs.items()}
    tables: dict[bool, WithinCells] = {}  # by whether days are the draws
    mine, outside, snow = {}, 0.0, 0.0
    for name, one in choice.members.items():
        weight = choice.weights[name] * times[name]
        odds, alike = prior_of(one.effect, criteria.outside_probability)
        icy = by_snow(design, choice, name, given, criteria.law_error)
        own = design.fit_for([one.effect])
        within = tables.setdefault(own.daily_draws, WithinCells(own, given))
        sizes = remaining_shares(one, within)
        rest = law_misfits(own, one, given, choice.fall)
        inside, beyond = likelihoods(sizes, rest, criteria.law_error)
        mine[name] = weight * (1.0 - odds) * (1.0 - icy) * inside
        unknown = alike * inside + (1.0 - alike) * beyond
        if alike == 1.0:  # all of them look as this one, or worse
            unknown = max(inside, beyond)
        weight = choice.weights[name] * times[OUTSIDE]
        outside += weight * odds * (1.0 - icy) * unknown
        snow += weight * icy * inside
    mine[OUTSIDE] = outside
    if snow:
        mine[SNOW] = mine.get(SNOW, 0.0) + snow
    mine = with_special_cases(choice, mine)
    total = sum(mine.values())
    # rounding errors must not choose among causes that are equally probable
    probabilities = {n: float(round(p / total, DIGITS)) for n, p in mine.items()}
    order = sorted(probabilities.items(), key=lambda item: -item[1])
    return replace(choice, probabilities=dict(order))


def with_special_cases(
    choice: "Choice", probabilities: Mapping[str, float]
) -> dict[str, float]:
    """
    Probabilities, of which a general cause has those of its special cases.

    Snow on the modules is one of the covers that power shows. If it is the less
    probable of the two, it is no other cause; else it is the more precise one.
    """
    found = dict(probabilities)
    for name in [name for name in found if name != OUTSIDE]:
        (effect,) = choice.effects_of([name])
        if found.get(effect.kind_of, 0.0) > found[name]:
            found[effect.kind_of] += found[name]
            found[name] = 0.0
    return {n: p for n, p in found.items() if p or n in choice.members}


def remaining_shares(
    one: "Candidate", tables: "WithinCells"
) -> list[tuple[float, float]]:
    """Share of its size that remains under other conditions, with its error."""
    design, given = tables.design, tables.given
    own = one.beyond(given)
    plain = LeastSquares(design.by_week([*given, *own]), len(own))
    kinds = tables_met(design, one.effect)
    others = [tables.products(own, kind) for kind in kinds]
    if one.effect.sensor_fault in OF_NO_COEFFICIENT:
        # what the instrument has had all the time is no change
        others.append(design.by_week([*given, one.change.place, *own]))
    every = (remaining_share(plain, LeastSquares(other, len(own))) for other in others)
    return [share for share in every if share is not None]


def law_misfits(
    design: "Design", one: "Candidate", given: Sequence["Column"], fall: float
) -> list[float]:
    """
    Residual of a law along its own drivers, relative to what the best law explains.

    Roots of mean squares, along the measured drivers and along its own columns; of a
    law of geometry, along the position of the sun; of a change, along the hours of the
    day; of a standstill, what its days have more than other days. The residual of a law
    is no larger than its relative error. That of an unknown cause, which follows the
    same drivers in another shape, is as large as what it explains.
    """
    a_shape = one.effect.confounder and not one.effect.geometric
    if a_shape or not fall > 0.0:
        return []
    rest = design.residual_given([*given, *one.beyond(given)])
    if one.effect.turns:
        return [float(np.sqrt(more_on_its_days(design, one.effect, rest) / fall))]
    if one.effect.sensor_fault:
        tables = [of_hours(design, one, rest)]
    else:
        drivers, derived = one.effect.drivers, design.derived
        mine = own_columns(drivers)
        axes = [axis for axis in design.axes.values() if axis.column in mine]
        columns = [derived[name] for name in drivers if name in derived]
        columns += map(design.values, one.columns) if mine else []
        axes += filter(None, (sorted_by("", column) for column in columns))
        kinds: list[Kind] = [(axis,) for axis in axes]
        if one.effect.geometric:
            kinds.append(tuple(design.axes[n] for n in POSITION if n in design.axes))
        weeks = design.rows, design.weeks
        tables = [Cells.from_axes(kind, *weeks).table(rest) for kind in kinds if kind]
    # by a standard error less: no more than is sure
    sure = [t.variance * max(1.0 - 1.0 / max(t.errors, 1.0), 0.0) for t in tables]
    return [float(np.sqrt(variance / fall)) for variance in sure]


def more_on_its_days(design: "Design", effect: Effect, rest: np.ndarray) -> float:
    """
    Mean square residual that the days of an effect have more than other days. [K²]

    A standstill can be of a few days, in which no hour repeats often enough for a
    table. If it is not what these days have, they keep a residual of their own. A
    standard error is taken off, so that no more counts than is sure.
    """
    squares, rows = (
        np.add.reduceat(column, design.first)
        for column in (rest**2 * design.rows, design.rows)
    )
    there = weights_of(effect, design.dates) > 0.0
    usual = squares[~there].sum() / max(rows[~there].sum(), 1.0)
    more, count = (squares - usual * rows)[there], int(there.sum())
    error = np.sqrt(np.square(more - more.mean()).sum() * count / max(count - 1, 1))
    return max(float(more.sum() - error), 0.0) / design.count


def of_hours(design: "Design", one: "Candidate", rest: np.ndarray) -> Table:
    """
    Table by hour of the residual of a change, on days with more and with less of it.

    A sensor that has changed deviates by its law at every hour. Heat that comes and
    goes with a season does so at its own hours. What an hour has on all days is not of
    the change.
    """
    hour = design.axes["hour"]
    weight = design.weight(one.change)
    much = (weight > weight @ design.rows / design.count).astype(int)
    side = Axis("change", much, ((0, 0), (1, 1)))
    rest = rest - group_means(hour.bins, design.rows)(rest)
    return Cells.from_axes((hour, side), design.rows, design.weeks).table(rest)


def likelihoods(
    sizes: Sequence[tuple[float, float]], rest: Sequence[float], law: float
) -> tuple[float, float]:
    """
    How likely sizes within tables and misfits are, by a law and by something unknown.

    What is unknown follows other inputs, or the same drivers in another shape: one as
    often as the other. Of tables, and of misfits, the largest evidence against the law
    counts. A misfit is evidence against this law, and not for something unknown against
    other members, which may have none.
    """
    within = [
        (density(share - 1.0, np.hypot(s, law)), density(share, np.hypot(s, FAR)))
        for share, s in sizes
    ]
    shapes = [(density(misfit, law), density(misfit, 1.0)) for misfit in rest]
    (inside, other), (shape, another) = (
        min(seen, key=lambda pair: pair[0] / pair[1], default=(1.0 / law, 1.0 / law))
        for seen in (within, shapes)
    )
    against = another / shape
    unknown = [other] * bool(within) + [inside * against] * bool(shapes)
    scale = law / max(against, 1.0)
    return scale * inside, scale * float(np.mean(unknown or [inside]))


def density(distance: float, width: float) -> float:
    """
    Density of a normal distribution, up to a factor, and not zero.

    Parameters
    ----------
    distance : float
        Distance from the mean.
    width : float
        Standard deviation, in the same unit.

    Returns
    -------
    float
    """
    return max(float(np.exp(-0.5 * (distance / width) ** 2) / width), TINY)


def group_means(groups: np.ndarray, rows: np.ndarray) -> Means:
    """A function from values, each the mean of some rows, to the mean of its group."""
    count = np.maximum(np.bincount(groups, rows), 1.0)
    return lambda values: (np.bincount(groups, values * rows) / count)[groups]


@dataclass(eq=False)
class WithinCells:
    """Products of columns less their means in the cells of tables."""

    design: "Design"
    given: Sequence["Column"]  # of the base and of other choices
    known: dict[Kind, tuple[Means, np.ndarray, np.ndarray]] = field(
        default_factory=dict
    )

    def parts(self, kind: Kind) -> tuple[Means, np.ndarray, np.ndarray]:
        """
        Means in the cells of a table, and columns less theirs with their products.

        These are the residual and the given columns, shape (cells, columns). Without an
        axis, the groups are weeks.
        """
        if kind not in self.known:
            design = self.design
            groups = cell_numbers(kind)[0] if kind else design.weeks
            mean = group_means(groups, design.rows)
            columns = [design.cells[:, 0], *map(design.values, self.given)]
            table = np.array([one - mean(one) for one in columns]).T
            self.known[kind] = mean, table, design.weekly_products(table)
        return self.known[kind]

    def products(self, own: Sequence["Column"], kind: Kind) -> np.ndarray:
        """
        Weekly products of the residual, the given columns and those of an effect.

        A change counts as far as its weight differs within a group. Variation of the
        sensor's column within a group is no evidence of a change.
        """
        design, (mean, given, among) = self.design, self.parts(kind)
        columns = []
        for column in own:
            values = design.values(column)
            if not isinstance(column, int):
                means = mean(design.weight(column))
                values = values - means * design.cells[:, column.place]
            columns.append(values - mean(values))
        mine = np.array(columns).T
        crossed = products_with(mine, given, design.rows, design.edges)
        above = np.concatenate([among, np.swapaxes(crossed, 1, 2)], axis=2)
        below = np.concatenate([crossed, design.weekly_products(mine)], axis=2)
        return np.concatenate([above, below], axis=1)


def remaining_share(
    plain: LeastSquares, other: LeastSquares
) -> tuple[float, float] | None:
    """Share of its size that remains in another fit, and its error."""
    size = plain.size
    before, after = (np.diag(one.whole)[-size:] for one in (plain, other))
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


def tables_met(design: "Design", effect: Effect) -> Iterator[Kind]:
    """
    Each table of unknown structure that an effect meets; () for weeks.

    What is a function of the usual inputs has no other conditions within the cells of
    these: what remains there is the error of its law.
    """
    usual = {*COLUMNS[:3]}
    own = usual if {*effect.drivers} <= {*usual, *MODELLED} else set()
    axes = {name: axis for name, axis in design.axes.items() if name not in own}
    yield from usual_tables(axes)
    if not effect.sensor_fault and design.has_weeks:
        yield ()
    skip = {
        *usual,
        *effect.drivers,
        *needed_for(effect.drivers),
        *CLOCK,
        *GEOMETRY,
    }
    for name, axis in design.axes.items():
        if axis.column not in skip and name not in skip:
            yield (axis, design.axes["hour"])


def usual_tables(axes: Mapping[str, Axis]) -> list[Kind]:
    """Axes of the tables over clock and calendar, usual inputs, the sun's position."""
    kinds = [tuple(axes[name] for name in pair if name in axes) for pair in PAIRS]
    return [kind for kind in dict.fromkeys(kinds) if kind]


def random_effects(
    design: "Design", given: Sequence["Column"], least: float
) -> tuple[Table, ...]:
    """
    Tables of the residual given some columns: the largest, then that of the rest.

    Parameters
    ----------
    design : Design
    given : sequence of int or Changed
        Columns.
    least : float
        Variance that is material. [K²]

    Returns
    -------
    tuple of Table
    """
    kinds = [
        Cells.from_axes(kind, design.rows, design.weeks)
        for kind in usual_tables(design.axes)
    ]
    rest = design.residual_given(given)
    tables: list[Table] = []
    while len(tables) < MOST_TABLES:
        table = largest_table(kinds, rest, least)
        if table is None:
            break
        rest = rest - table.values
        tables.append(table)
    return tuple(tables)
