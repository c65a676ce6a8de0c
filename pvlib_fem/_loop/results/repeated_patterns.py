"""Unexplained but repeatable patterns: tables of the residual of the last step."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from pvlib_fem._loop.results.predicted_patterns import Pattern, drivers_of
from pvlib_fem._record.column_names import COLUMNS, GEOMETRY, is_power
from pvlib_fem._record.inputs import Record
from pvlib_fem._statistics.axes import PAST, SINCE_RAIN, Axis, axes, calendar_of
from pvlib_fem._statistics.clusters import week_numbers
from pvlib_fem._statistics.hourly_means import Hours
from pvlib_fem._statistics.tables import Cells, Table, largest_table
from pvlib_fem.drivers import derive_drivers, underived

if TYPE_CHECKING:
    from pvlib_fem._loop.preparation.divided_record import Case
    from pvlib_fem._loop.regression.refits import Fits, Step

SUN = GEOMETRY[:2]
CYCLES = 2  # times that each table is estimated again, given all others


def repeated_tables(fits: "Fits", step: "Step", least: float) -> list[Table]:
    """
    Tables of the residual of a step on the fitting weeks, the strongest first.

    Tables of clock, calendar, present columns and hours since rain come first, then
    tables of their residual with the past of irradiance and air. Each is estimated
    given all others (backfitting [1]_).

    Parameters
    ----------
    fits : Fits
        Fits of the loop, with its case.
    step : Step
        The last one.
    least : float
        Variance that is material. [K²]

    Returns
    -------
    list of Table

    References
    ----------
    .. [1] A. Buja, T. Hastie and R. Tibshirani, "Linear smoothers and additive models",
       Ann. Statist. 17, 453-510, 1989. :doi:`10.1214/aos/1176347115`
    """
    case = fits.case
    record, model = fits.prepared(case.record, step.model)
    error = record["temp_module"] - model.temperature(record.inputs, step.coefficients)
    rows = np.flatnonzero(case.searched & np.isfinite(error))
    hours = Hours.from_record(record, rows)
    rest, dates = hours.means(error[rows]), record.dates[rows][hours.first]
    own = list(axes(places_of(record, rows, hours, case.drivers), dates))
    usual = [axis for axis in own if axis.name not in {*GEOMETRY, *PAST}]
    past = [axis for axis in own if axis.name in PAST]
    sun = tuple(axis for axis in own if axis.name in SUN)
    present = [*axes_and_pairs(usual), *([sun] if len(sun) == len(SUN) else [])]
    late = [kind for kind in axes_and_pairs([*usual, *past]) if {*kind} & {*past}]
    weeks = week_numbers(dates)
    cells: list[Cells] = []
    tables: list[Table] = []
    for kinds in (present, late):
        new = [Cells.from_axes(kind, hours.count, weeks) for kind in kinds]
        while (table := largest_table(new, rest, least)) is not None:
            (own_cells,) = (one for one in new if one.axes == table.axes)
            new.remove(own_cells)
            cells.append(own_cells)
            tables.append(table)
            rest = rest - table.values
            for i in [*range(len(tables))] * CYCLES if len(tables) > 1 else []:
                rest = rest + tables[i].values
                tables[i] = cells[i].table(rest)
                rest = rest - tables[i].values
    return tables


def axes_and_pairs(axes: Sequence[Axis]) -> list[tuple[Axis, ...]]:
    """Each axis, and each pair of axes."""
    return [*((one,) for one in axes), *combinations(axes, 2)]


def places_of(
    record: Record, rows: np.ndarray, hours: Hours, drivers: tuple
) -> dict[str, np.ndarray]:
    """Mean of each driver in cells of an hour, NaN with no value, and the calendar."""
    past = [*PAST, SINCE_RAIN] if "precipitation" in drivers else [*PAST]
    inputs = derive_drivers(record.inputs, past)
    names = {*COLUMNS[:3], *GEOMETRY, *drivers, *past} & {*inputs.columns}
    # predictions from weather have no power
    names = {name for name in names if not is_power(name)}
    columns = {name: inputs[name][rows] for name in sorted(names)}
    known = {n: column for n, column in columns.items() if np.isfinite(column).any()}
    return hours.means_of_drivers(known) | calendar_of(record.index[rows][hours.first])


def with_patterns(case: "Case", step: "Step", patterns: tuple[Pattern, ...]) -> "Step":
    """
    The step with the errors by some patterns in its temperature.

    Parameters
    ----------
    case : Case
        Record of the step, on its own steps.
    step : Step
        The last one.
    patterns : tuple of Pattern
        Patterns of its residual.

    Returns
    -------
    Step
    """
    drivers = drivers_of(patterns)
    record = case.placed_for(case.whole, underived(drivers))
    inputs = derive_drivers(record.inputs, drivers)
    added = np.sum([one.at(inputs) for one in patterns], axis=0)
    return replace(step, temperature=step.temperature + added)
