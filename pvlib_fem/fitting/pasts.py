"""What drivers remember, for a record of which one block is known at a time."""

from dataclasses import dataclass, field

import numpy as np

from pvlib_fem.drivers import (
    behind,
    completed,
    lost_without,
    remembered,
    short_memory,
)
from pvlib_fem.record.alongside import Alongside
from pvlib_fem.record.checks import datetime_steps
from pvlib_fem.record.inputs import Inputs
from pvlib_fem.record.trailing import Trailing

MEANS = 60.0  # s of the shortest steps of which all are held
FORGOTTEN = 20.0  # memories after which less than a millionth is left


@dataclass(frozen=True, eq=False)
class Held:
    """Some columns of all rows, where these are no more than means would be."""

    names: tuple
    index: list = field(default_factory=list)
    columns: list = field(default_factory=list)

    @classmethod
    def of(cls, drivers, usual):
        """Those behind drivers that remember, if the usual step is no shorter."""
        return cls(tuple(behind(of_means(drivers))) if usual >= MEANS else ())

    def add(self, block):
        """Add the rows of a block."""
        if self.names:
            self.index.append(block.index)
            self.columns.append([block[name] for name in self.names])

    def inputs(self):
        """The columns of all rows; None without any."""
        if not self.names:
            return None
        index = self.index[0].append(self.index[1:])
        steps, unit = datetime_steps(index, "times")
        columns = dict(zip(self.names, map(np.concatenate, zip(*self.columns))))
        return Inputs(columns, steps, unit, index, True)


def with_a_past(inputs, drivers):
    """Drivers that remember, of the rows as they are read where they soon forget."""
    names = remembered(drivers)
    if short := [name for name in names if short_memory(name)]:
        reach = FORGOTTEN * max(map(short_memory, short))
        yield Trailing(tuple(short), tuple(behind(short)), completed, reach)
    if long := of_means(drivers):
        made_of = {name: lost_without(name) for name in long}
        yield Alongside.of(completed(inputs, long), long, made_of)


def of_means(drivers):
    """Drivers that remember for so long that they are of means of short steps."""
    return [name for name in remembered(drivers) if not short_memory(name)]


def means_note(target, files):
    """What the drivers that remember are of, where that is not the rows."""
    if files.step >= MEANS or not of_means(target.effect_drivers):
        return []
    effects = ", ".join(e.name for e in target.effects if of_means(e.drivers))
    step = files.means.inputs.step
    return [f"what happened hours before is of means over {step:g} s, for {effects}"]
