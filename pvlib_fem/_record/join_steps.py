"""Columns of longer steps joined to a record of shorter ones."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pvlib_fem._record.checks import instants
from pvlib_fem._record.inputs import Inputs

ROUND = ("solar_azimuth",)  # columns that begin anew after a turn of 360°


@dataclass(frozen=True, eq=False)
class JoinedColumns:
    """
    Columns that files do not hold, at times further apart; straight lines between.

    A missing value is interpolated from those before and after it. A column is missing
    in rows without the values that it is made of, as in memory.

    Attributes
    ----------
    start : datetime64
    columns : dict of tuple
        By name, times since the start [s] and values. What turns goes on past 360°,
        the shorter way from one to the next.
    made_of : dict of tuple
        Columns of the record, by those without which they are not known.
    """

    start: np.datetime64
    columns: dict = field(repr=False)
    made_of: dict = field(default_factory=dict, repr=False)

    @classmethod
    def from_inputs(
        cls, inputs: Inputs, names: list, made_of: dict | None = None
    ) -> Any:
        """
        The columns of some inputs.

        Raises
        ------
        ValueError
            If one of them has no value.
        """
        start = instants(inputs.index[:1])[0]
        seconds, columns, made_of = since(start, inputs.index), {}, made_of or {}
        for name in names:
            there = np.isfinite(inputs[name])
            if not there.any():
                behind = ", ".join(made_of.get(name, ())) or name
                raise ValueError(
                    f"{name} is not known: no mean over {inputs.step:g} s has enough "
                    f"values of {behind}; fill these between their readings, or leave "
                    "the effect out"
                )
            values = inputs[name][there]
            if name in ROUND:
                values = np.unwrap(values, period=360.0)
            columns[name] = seconds if there.all() else seconds[there], values
        return cls(start, columns, made_of)

    def begun(self) -> "JoinedColumns":
        """What follows the blocks of a record from the first on."""
        return self

    def at(self, inputs: Inputs) -> dict:
        """The columns at the times of other inputs."""
        wanted, columns = since(self.start, inputs.index), {}
        for name, (seconds, values) in self.columns.items():
            columns[name] = np.interp(wanted, seconds, values)
            if name in ROUND:
                columns[name] %= 360.0
            for needed in self.made_of.get(name, ()):
                columns[name][np.isnan(inputs[needed])] = np.nan
        return columns


def since(start: np.datetime64, index: Any) -> np.ndarray:
    """Times since a first one. [s]"""
    return (instants(index) - start) / np.timedelta64(1, "s")
