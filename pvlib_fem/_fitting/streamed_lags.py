"""Lagged drivers of a record that is read block by block."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pvlib_fem._record.checks import datetime_steps
from pvlib_fem._record.inputs import Inputs
from pvlib_fem._record.join_steps import JoinedColumns
from pvlib_fem._record.parquet import Block
from pvlib_fem._record.streamed_columns import StreamedColumns
from pvlib_fem._thermal.model import ThermalModel
from pvlib_fem.drivers import (
    derive_drivers,
    drivers_with_memory,
    lost_without,
    short_memory,
    underived,
)

MEANS = 60.0  # s, shortest step of a record whose rows are all held
FORGOTTEN = 20.0  # time constants after which the weight is below a millionth


@dataclass(frozen=True, eq=False)
class Held:
    """Some columns of all rows, for records with steps of a minute or more."""

    names: tuple
    index: list = field(default_factory=list)
    columns: list = field(default_factory=list)

    @classmethod
    def for_drivers(cls, drivers: list, usual: float) -> "Held":
        """The columns that lagged drivers need; none if the usual step is shorter."""
        return cls(tuple(underived(of_means(drivers))) if usual >= MEANS else ())

    def add(self, block: Block) -> None:
        """Add the rows of a block."""
        if self.names:
            self.index.append(block.index)
            self.columns.append([block[name] for name in self.names])

    def inputs(self) -> Inputs | None:
        """The columns of all rows; None if no columns are held."""
        if not self.names:
            return None
        index = self.index[0].append(self.index[1:])
        steps, unit = datetime_steps(index, "times")
        columns = dict(zip(self.names, map(np.concatenate, zip(*self.columns))))
        return Inputs(columns, steps, unit, index, True)


def with_a_past(inputs: Inputs, drivers: list) -> Iterator:
    """
    Lagged drivers, as columns that the files do not hold.

    Parameters
    ----------
    inputs : Inputs
        Rows of the record, or means over longer steps, for drivers with a long memory.
    drivers : list of str
        Drivers of the effects, lagged or not.

    Yields
    ------
    StreamedColumns or JoinedColumns
        Drivers with a short memory, computed from the rows block by block; and those
        with a long memory, from ``inputs``.
    """
    names = drivers_with_memory(drivers)
    memories = {name: short_memory(name) or 0.0 for name in names}
    if short := [name for name, memory in memories.items() if memory]:
        reach = FORGOTTEN * max(memories[name] for name in short)
        yield StreamedColumns(
            tuple(short), tuple(underived(short)), derive_drivers, reach
        )
    if long := of_means(drivers):
        made_of = {name: lost_without(name) for name in long}
        yield JoinedColumns.from_inputs(derive_drivers(inputs, long), long, made_of)


def of_means(drivers: list) -> list:
    """Lagged drivers with a memory so long that means of short steps suffice."""
    return [name for name in drivers_with_memory(drivers) if not short_memory(name)]


def means_note(target: ThermalModel, files: Any) -> list:
    """
    A note on lagged drivers that are computed from means instead of rows.

    Parameters
    ----------
    target : ThermalModel
        The fitted model.
    files : Files
        Its source.

    Returns
    -------
    list of str
        One note, or none.
    """
    if files.step >= MEANS or not of_means(target.effect_drivers):
        return []
    effects = ", ".join(e.name for e in target.effects if of_means(e.drivers))
    step = files.means.inputs.step
    return [f"the hours before each row are means over {step:g} s, for {effects}"]
