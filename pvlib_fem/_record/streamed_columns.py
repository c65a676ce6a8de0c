"""Columns that rows make of themselves and of the hours before, block by block."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.inputs import Inputs


@dataclass(frozen=True, eq=False)
class StreamedColumns:
    """
    Columns that files do not hold, made of each row and of those shortly before it.

    Attributes
    ----------
    names : tuple of str
    made_of : tuple of str
        Columns of the record.
    make : callable
        Inputs with the columns, of inputs with what they are made of.
    reach : float
        How far back a row looks. [s]
    """

    names: tuple
    made_of: tuple
    make: Callable
    reach: float

    def begun(self) -> "Tail":
        """What follows the blocks of a record from the first on."""
        return Tail(self)


@dataclass(eq=False)
class Tail:
    """The last rows of the blocks that have gone by."""

    of: StreamedColumns
    columns: Any = None  # dict of array, None before the first block
    steps: Any = None  # array [s]

    def at(self, inputs: Inputs) -> dict:
        """The columns in the rows of the next block."""
        columns = {name: inputs[name] for name in self.of.made_of}
        steps = np.asarray(inputs.steps * inputs.unit, dtype=float)
        if self.columns is not None:
            columns = {n: np.append(self.columns[n], own) for n, own in columns.items()}
            steps = np.append(self.steps, steps)
        self.keep(columns, steps)
        rows = pd.RangeIndex(len(steps))
        if len(steps) > 1 and steps[1:].min() == steps[1:].max():
            steps = float(steps[1])
        made = self.of.make(Inputs(columns, steps, 1.0, rows, True), self.of.names)
        return {name: made[name][-len(inputs.index) :] for name in self.of.names}

    def keep(self, columns: dict, steps: np.ndarray) -> None:
        """Keep the rows that the next block looks back to."""
        ago = np.cumsum(steps[:0:-1])  # of all rows but the last, the latest first
        first = len(steps) - 1 - np.searchsorted(ago, self.of.reach, side="right")
        self.columns = {name: own[first:].copy() for name, own in columns.items()}
        self.steps = steps[first:].copy()
