"""What structure of unknown cause, sorted into tables, says against an effect."""

from dataclasses import dataclass

import numpy as np

from pvlib_fem.drivers import needed_for
from pvlib_fem.findings import Check
from pvlib_fem.loop.rules import beside, material
from pvlib_fem.record.checks import usual_step
from pvlib_fem.statistics.tables import find_structure
from pvlib_fem.statistics.timetables import timetables


def without_of(found, name):
    """Columns that a rival table may not use: the effect's own."""
    own = found.effects[name].drivers
    return [*own, *needed_for(own)]


def against(found, name, given, table, spill=0.0):
    """
    Whether an effect holds against the strongest table of unknown structure.

    It does where the table is not material, where the effect leaves little of the
    table, or keeps enough of its own beside it. Also the table's square.
    """
    criteria, without = found.criteria, beside(found, name, given)
    floor = material(found, without, spill)
    if table is None or table.gain**2 < floor:
        return (), 0.0
    wider = found.with_column("unknown", table.values)
    # several confounders together may make what none of them makes alone
    with_it = found.confounders if found.effects[name].confounder else [name]
    left = wider.gain("unknown", [*given, *with_it]) / table.gain**2
    share = wider.gain(name, [*given, "unknown"]) / found.gain(name, given)
    keeps = wider.gain(name, [*without, "unknown"])
    explains = Check(
        f"share left of the table by {table.name}",
        "structure_left",
        left,
        max(criteria.structure_left, floor / table.gain**2),
        most=True,
    )
    stands = Check(
        f"share kept given the table by {table.name}",
        "structure_keeps",
        share if keeps >= floor else 0.0,
        criteria.structure_keeps,
    )
    # either will do
    best = explains if explains.passed and not stands.passed else stands
    return (best,), table.gain**2


@dataclass(frozen=True, eq=False)
class Sorting:
    """Ways to sort some rows: by clock, calendar, drivers and timetables."""

    axes: list
    rows: np.ndarray
    folds: np.ndarray
    seconds: np.ndarray
    step: float

    def of(self, rows):
        """The same for fewer rows."""
        if len(rows) == len(self.rows):
            return self
        kept = np.isin(self.rows, rows, assume_unique=True)
        axes = [axis.of(kept) for axis in self.axes]
        return Sorting(axes, rows, self.folds[kept], self.seconds[kept], self.step)


def sorting(case, found, given):
    """All ways to sort the rows of the evidence."""
    record, rows = case.record, found.rows
    kept = np.isin(np.flatnonzero(case.searched), rows, assume_unique=True)
    axes, folds = [axis.of(kept) for axis in case.axes], case.folds[kept]
    seconds = record.inputs.seconds[rows]
    step = usual_step(record.index[rows])
    times = (seconds, record.dates[rows], folds, step)
    axes += timetables(found.rest(given), *times, case.criteria)
    return Sorting(axes, rows, folds, seconds, step)


def structure(case, found, given, by, without=()):
    """The strongest table of what is left."""
    by = by.of(found.rows)
    how = (by.axes, by.step, case.criteria, without)
    return find_structure(found.rest(given), by.seconds, by.folds, *how)
