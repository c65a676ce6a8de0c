"""A record that is held in memory, as a fit asks for its rows."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pvlib_fem import scores
from pvlib_fem.fitting.result import FemFit, of_rows
from pvlib_fem.fitting.rows import Rows, daily_sums
from pvlib_fem.fitting.search import natural, with_tables
from pvlib_fem.fitting.stages import flatness, held_out, last, minimise
from pvlib_fem.quality.screen import screened
from pvlib_fem.quality.units import oddities
from pvlib_fem.record.columns import COLUMNS
from pvlib_fem.record.filters import counted
from pvlib_fem.record.inputs import Record, as_record
from pvlib_fem.thermal.model import ALONE, blocks

ROUGHER = 1e-5  # relative fall of the cost that ends a search on a part of the rows


@dataclass(frozen=True, eq=False)
class Frame:
    """A record in memory: which of its rows count, and which are held out."""

    record: Record
    counts: np.ndarray  # booleans
    out: np.ndarray  # booleans
    night: bool = False

    kind = FemFit

    @cached_property
    def train(self):
        """Rows that are fitted."""
        return self.counts & ~self.out

    @cached_property
    def complete(self):
        """Rows with all four columns that are not held out."""
        return np.isfinite(sum(self.record[name] for name in COLUMNS)) & ~self.out

    @property
    def count(self):
        """How many rows are fitted."""
        return int(np.count_nonzero(self.train))

    @property
    def step(self):
        """Usual time between rows. [s]"""
        return self.record.inputs.step

    @property
    def wind(self):
        """Mean wind speed of the record. [m/s]"""
        return self.record.inputs.mean("wind_speed")

    def begun(self, target):
        """Where the search of the first step begins."""
        return {name: row.start for name, row in target.parameters.items()}

    def minima(self, steps, start, final):
        """
        Each of some steps of a fit, the last minimum, and where a next one begins.

        One begins where the other ends. What a step changes is nearly the same on a
        part of the rows, on which the first are searched before.
        """
        flat, model = flatness(steps, final), steps[-1][1]
        record = self.known(model) if model.effects else self.record
        stages, thin, source, some = {}, start, None, None
        for name, model, which, biased in steps:
            rows = getattr(self, which)
            if source is None or source.counts is not rows:
                source = Rows(record, rows)
                some = None if model.effects else source.thinned()
            if some:
                before, (_, thin) = thin, minimise(model, some, thin, biased, ROUGHER)
                start = {n: value + thin[n] - before[n] for n, value in start.items()}
            tabled = with_tables(model, record)
            minimum, start = minimise(tabled, source, start, biased, flat[name])
            stages[name] = (model, natural(model, start)[0])
        return stages, minimum, start

    def known(self, model):
        """The record with all drivers of a model's effects."""
        return replace(self.record, inputs=model.with_drivers(self.record.inputs))

    def ended(self, target, stages, at_bound):
        """Sums by the day of the last step, and what a result has of the rows."""
        whole = replace(self, record=self.known(target)) if target.effects else self
        temperature = np.empty(len(self.record.index))
        source = Rows(whole.record, whole.train)
        daily = daily_sums(target, last(stages)[1], source, at_bound, temperature)
        return daily, whole.result(stages, temperature)

    def result(self, stages, temperature):
        """What a result has of the rows, from the temperature by the last step."""
        test = self.counts & self.out
        table = score_table(self.record, stages, temperature, self.train, test)
        own = of_rows(self.record, temperature, self.train, test, self.out)
        return {**own, "scores": table}

    def notes(self, target):
        """What of the answers is not of the rows: nothing."""
        return []


def as_frame(columns, drivers, target, holdout, night, limits, check_units):
    """A user's columns as a source of rows for a model, and notes on them."""
    record, faults = screened(as_record(*columns, **drivers), limits, check_units)
    counts = counted(record.inputs.columns, night)
    counts &= record.known(target.drivers)
    notes = [*faults.notes, *oddities(record.inputs, limits)]
    out = held_out(record, counts, holdout, notes)
    return Frame(record, counts, out, night), notes


def score_table(record, stages, temperature, train, test):
    """RMSE, MAE and MBE of every stage, of which the last has that temperature."""
    kept = {"train": train, "test": test}
    tallies = {name: scores.tallying() for name in stages}
    *before, final = stages
    given = [(name, *stages[name]) for name in before]
    counts = train | test
    found = {n: m.in_blocks(record.inputs, own, counts) for n, m, own in given}
    measured = record["temp_module"]
    # block by block, so that all find the columns in the cache
    for block in blocks(len(record.index), ALONE):
        rows = {part: np.flatnonzero(rows[block]) for part, rows in kept.items()}
        modelled = {name: next(one) for name, one in found.items()}
        modelled[final] = temperature[block]
        for name, own in modelled.items():
            error = measured[block] - own
            for part, some in rows.items():
                tallies[name][part].add(error[some])
    return scores.scored(tallies)
