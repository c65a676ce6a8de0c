"""A record that is held in memory, as a fit asks for its rows."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from pvlib_fem.fitting.holdout import held_out
from pvlib_fem.fitting.result import FemFit, of_rows
from pvlib_fem.fitting.rows import Rows
from pvlib_fem.fitting.search import natural, with_tables
from pvlib_fem.fitting.stages import flatness, minima, minimise
from pvlib_fem.quality.screen import screened
from pvlib_fem.quality.units import oddities
from pvlib_fem.record.columns import COLUMNS
from pvlib_fem.record.filters import counted
from pvlib_fem.record.inputs import as_record

ROUGHER = 1e-5  # relative fall of the cost that ends a search on a part of the rows


@dataclass(frozen=True, eq=False)
class Frame(Rows):
    """A record in memory, whose ``counts`` are the rows that are fitted."""

    test: np.ndarray = field(kw_only=True)  # rows that count and are held out
    out: np.ndarray = field(kw_only=True)  # all that are held out
    night: bool = field(default=False, kw_only=True)

    kind = FemFit

    @classmethod
    def of(cls, record, counts, out, night=False):
        """A record, which of its rows count, and which are held out."""
        return cls(record, counts & ~out, test=counts & out, out=out, night=night)

    @cached_property
    def kept(self):
        """Booleans of the rows, by what they count for."""
        complete = np.isfinite(sum(self.record[name] for name in COLUMNS)) & ~self.out
        return {"train": self.counts, "test": self.test, "complete": complete}

    def begun(self, target):
        """Where the search of the first step begins."""
        return {name: row.start for name, row in target.parameters.items()}

    def minima(self, steps, start, final):
        """
        Each of some steps of a fit, the last minimum, and where a next one begins.

        One begins where the other ends. What a step changes is nearly the same on a
        part of the rows, on which the first are searched before.
        """
        flat, whole = flatness(steps, final), self.known(steps[-1][1])
        stages, thin, some, before = {}, start, None, None
        for name, model, which, biased in steps:
            if which != before:
                some = None if model.effects else self.thin(which)
                before = which
            if some:
                last, (_, thin) = thin, minimise(model, some, thin, biased, ROUGHER)
                start = {n: value + thin[n] - last[n] for n, value in start.items()}
            step = (name, with_tables(model, whole.record), which, biased)
            minimum, start = minima(whole, [step], {name: start}, flat)[name]
            stages[name] = (model, natural(model, start)[0])
        return stages, minimum, start

    def thin(self, which):
        """Some of the rows that count for something, or None of few."""
        return Rows(self.record, self.kept[which]).thinned()

    def known(self, model):
        """The same with all drivers of a model's effects."""
        if not model.effects:
            return self
        inputs = model.with_drivers(self.record.inputs)
        return replace(self, record=replace(self.record, inputs=inputs), divided={})

    def ended(self, asked, last, names):
        """Sums by the day of the last step, and what a result has of the rows."""
        whole, temperature = self.known(asked[last].model), np.empty(len(self.counts))
        table, daily = whole.ends(asked, last, names, temperature)
        own = of_rows(whole.record, temperature, self.counts, self.test, self.out)
        return daily, {**own, "scores": table}

    def notes(self, target):
        """What of the answers is not of the rows: nothing."""
        return []


def as_frame(columns, drivers, target, holdout, night, limits, check_units):
    """A user's columns as a source of rows for a model, and notes on them."""
    record, faults = screened(as_record(*columns, **drivers), limits, check_units)
    counts = counted(record.inputs.columns, night)
    counts &= record.known(target.drivers)
    notes = [*faults.notes, *oddities(record.inputs, limits, record.absent)]
    out = held_out(record, counts, holdout, notes)
    return Frame.of(record, counts, out, night), notes
