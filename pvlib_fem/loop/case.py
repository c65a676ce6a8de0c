"""A user's frame as the loop takes it: checked, corrected, split."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from pvlib_fem.drivers import geometry
from pvlib_fem.effects.candidates import candidates
from pvlib_fem.loop.criteria import Criteria
from pvlib_fem.paper.filters import counted
from pvlib_fem.quality.check import check
from pvlib_fem.quality.clock import Clock
from pvlib_fem.record.checks import Record, measured
from pvlib_fem.record.columns import COLUMNS, filled, usable_drivers, with_aliases
from pvlib_fem.record.resampling import coarse, covered
from pvlib_fem.statistics.axes import axes
from pvlib_fem.statistics.clusters import FOLDS, calendar_weeks

SEALED = 5  # of this many weeks one is sealed
FEWEST_DAYS = 2 * FOLDS  # open ones, below which none is left out
FEWEST_SEALED_WEEKS = 5  # weeks below which every other day is sealed instead
WORTH_SAYING = 120.0  # s that a clock may be off unseen
OFF_THE_SUN = ("file_shift", "file_dst")  # faults with which the sun is elsewhere


@dataclass(frozen=True, eq=False)
class Case:
    """
    A record, which of its rows may be looked at when, and what may explain it.

    The search goes over coarse steps, of which five minutes lose nothing that an
    effect would show; every fit ends on the record's own.
    """

    whole: Record
    record: Record  # on coarse steps
    seen: np.ndarray  # rows of the whole that count
    sealed: np.ndarray  # rows of the whole that nothing looks at before the end
    drivers: tuple
    wanted: tuple  # effects whose drivers are there
    untestable: dict
    site: dict
    clock: Clock
    notes: tuple = field(default=())

    @property
    def train(self):
        return self.seen & ~self.sealed

    @property
    def test(self):
        return self.seen & self.sealed

    @cached_property
    def open(self):
        """Rows of the coarse record that the search may look at."""
        columns = self.record.inputs.columns
        seen = np.asarray(counted(columns, with_night=True))
        seen &= covered(self.seen, self.whole, self.record)
        return seen & ~covered(self.sealed, self.whole, self.record)

    @property
    def days(self):
        """Days that count."""
        return len(np.unique(self.whole.dates[self.seen]))

    @property
    def open_days(self):
        return len(np.unique(self.record.dates[self.open]))

    @property
    def divisible(self):
        """Whether there are days to leave out in turn."""
        return self.open_days >= FEWEST_DAYS

    @cached_property
    def axes(self):
        """All ways to sort the open rows."""
        # power follows the light itself, and would sort by what it should tell
        names = sorted({*self.drivers, *COLUMNS[:3]} - {"p_dc"})
        record, rows = self.record, self.open
        columns = {name: record[name][rows] for name in names}
        return list(axes(record.index[rows], record.dates[rows], columns, Criteria()))

    @cached_property
    def folds(self):
        """Group of weeks of each open row."""
        weeks = calendar_weeks(self.record.dates[self.open])
        return np.unique(weeks, return_inverse=True)[1] % FOLDS

    def corrected(self):
        """The case with the module's record re-timed."""
        columns = dict(self.whole.inputs.columns)
        seconds = self.whole.inputs.seconds
        columns["temp_module"] = self.clock.corrected(seconds, columns["temp_module"])
        if "p_dc" in columns:
            moved = self.clock.corrected(seconds, columns["p_dc"])
            columns["p_dc"] = follows(columns["poa_global"], columns["p_dc"], moved)
        whole = replace(self.whole, inputs=replace(self.whole.inputs, columns=columns))
        return divided(whole, replace(self, clock=Clock()), self.sealed)


def prepared(data, site, holdout, effects, check_units=True):
    """Everything checked that comes in."""
    columns = with_aliases(data)
    usual = [columns.pop(name) for name in COLUMNS]
    drivers, refused = usable_drivers(columns, usual)
    record = measured(*usual, check_units, **filled(drivers))
    health = check(record, **site)
    doubts = {f"units:{name}" for name in health.doubtful}  # said with the refused
    notes = [
        f"{line}; corrected" if name in health.clock.faults else line
        for name, line in health.faults.items()
        if name not in doubts
    ]
    notes += health.unchecked
    for name, reason in health.doubtful.items():
        drivers.pop(name, None)
        refused[name] = reason
    sun = geometry(record.index, **site)
    if off := [name for name in OFF_THE_SUN if name in health.faults]:
        sun = {}
        notes.append(f"no effect that needs the sun is tried: {off[0]}")
    places = {name: column.to_numpy() for name, column in sun.items()}
    kept = {n: c for n, c in record.inputs.columns.items() if n not in refused}
    module = np.where(health.mask, np.nan, record["temp_module"])
    columns = {**kept, **places, "temp_module": module}
    inputs = replace(record.inputs, columns=columns)
    record = replace(record, inputs=inputs)
    wanted, untestable = candidates({**drivers, **sun}, refused, effects)
    if health.clock.limit > WORTH_SAYING and not health.clock.fault:
        untestable["clock_shift"] = (
            f"rows so far apart show it from {health.clock.limit / 60:.2g} min only"
        )
    notes += [f"{reason}: not used" for name, reason in refused.items()]
    case = Case(
        record,
        record,
        ~health.mask,
        np.zeros(len(health.mask), dtype=bool),
        tuple(drivers),
        tuple(wanted),
        untestable,
        site if sun else dict.fromkeys(site),
        health.clock,
        tuple(notes),
    )
    return divided(record, case, holdout)


def divided(whole, case, holdout):
    """The case with this record, its coarse steps and its sealed rows."""
    seen = np.asarray(counted(whole.inputs.columns, with_night=True)) & case.seen
    sealed = holdout
    if not isinstance(holdout, np.ndarray):
        sealed = sealed_rows(whole, seen, holdout)
    short = coarse(whole)
    if short is not whole:
        # the sun is where it is, and nothing is averaged over a horizon
        places = geometry(short.index, **case.site)
        places = {name: column.to_numpy() for name, column in places.items()}
        inputs = replace(short.inputs, columns={**short.inputs.columns, **places})
        short = replace(short, inputs=inputs)
    return replace(case, whole=whole, record=short, seen=seen, sealed=sealed)


def sealed_rows(record, seen, holdout):
    """Rows that nothing looks at before the end."""
    if holdout is not None:
        return record.rows(holdout)
    weeks = np.unique(calendar_weeks(record.dates), return_inverse=True)[1]
    if weeks.max() + 1 >= FEWEST_SEALED_WEEKS:
        return weeks % SEALED == SEALED // 2
    days = record.days
    if len(np.unique(days[seen])) < 2:
        return np.zeros(len(seen), dtype=bool)
    return days % 2 == 1


def follows(poa_global, *columns):
    """The column whose changes follow those of irradiance best."""
    change = np.diff(poa_global)

    def likeness(column):
        other = np.diff(column)
        both = np.isfinite(change) & np.isfinite(other)
        return change[both] @ other[both] / np.sqrt(other[both] @ other[both] + 1e-12)

    return max(columns, key=likeness)
