"""The response of a record's own model to an effect, put into its measured columns."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from pvlib_fem.drivers import needed_for
from pvlib_fem.effects import EFFECTS, find
from pvlib_fem.loop.witness import showing
from pvlib_fem.quality.clock import Clock
from pvlib_fem.quality.lag import retimed
from pvlib_fem.record.checks import Record
from pvlib_fem.record.columns import printable
from pvlib_fem.thermal.model import ThermalModel


@dataclass(frozen=True, eq=False)
class Injector:
    """A record as its loop left it, and what an effect adds to it."""

    model: ThermalModel
    coefficients: dict
    record: Record  # checked, in one standard time
    kept: np.ndarray  # rows of the user's frame that it has
    clock: Clock  # of the module's logger
    witnesses: tuple
    own: dict  # effects of the user's own, by name

    @classmethod
    def of(cls, search, loop):
        """The injector of a search that is done."""
        case = search.case
        own = {e.name: e for e in case.wanted if e.name not in EFFECTS}
        model, coefficients = loop.fit.thermal_model, loop.fit.coefficients
        return cls(
            replace(model, base=model.base or coefficients),
            coefficients,
            loop.fit.record,
            case.kept,
            search.clock,
            case.witnesses,
            own,
        )

    def effect(self, injection):
        """The effect, with its dates."""
        name = injection.effect
        return self.own.get(name) or find({"name": name, **injection.settings})

    def response(self, injection):
        """What it adds to the module's temperature, memory and wind with it. [K]"""
        effect = self.effect(injection)
        record = self.record
        if effect.prepare:
            there = replace(self.model, effects=(effect,)).with_drivers(record.inputs)
            rows = np.ones(len(record.index), dtype=bool)
            effect = effect.prepare(there.columns, rows)
        # over gaps of its drivers as where it is weighed: the next value stands
        filled = {
            name: pd.Series(record[name]).bfill().ffill().to_numpy()
            for name in needed_for(effect.drivers)
            if name in record.inputs.columns
        }
        model = replace(self.model, effects=(*self.model.effects, effect))
        inputs = model.with_drivers(record.having(filled).inputs)
        own = injection.coefficients
        with_it, without = (
            model.temperature(inputs, {**self.coefficients, **part})
            for part in (own, effect.start)
        )
        change = np.nan_to_num(with_it - without)
        if self.clock.fault:
            seconds = record.inputs.seconds
            change = np.nan_to_num(retimed(seconds, change, -self.clock.at(seconds)))
        return change

    def into(self, data, injection):
        """A frame with the effect in it, and in the columns that see the same."""
        data, effect = data.copy(), self.effect(injection)
        labels = {printable(label): label for label in data}
        add(data, labels["temp_module"], self.kept, self.response(injection))
        if effect.channel:
            (change,) = injection.coefficients.values()
            seen = {n: data[labels[n]].to_numpy(float) for n in self.witnesses}
            seen = {name: values[self.kept] for name, values in seen.items()}
            how = (effect, change, self.coefficients)
            for name, values in showing(self.record, seen, *how).items():
                add(data, labels[name], self.kept, values - seen[name])
        return data


def add(data, label, rows, values):
    """Add to some rows of a column, in place."""
    column = data[label].to_numpy(float).copy()
    column[rows] += values
    data[label] = column
