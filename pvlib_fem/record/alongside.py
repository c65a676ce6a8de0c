"""Columns of longer steps beside a record of shorter ones."""

from dataclasses import dataclass, field

import numpy as np

from pvlib_fem.record.checks import instants

ROUND = ("solar_azimuth",)  # columns that begin anew after a turn of 360°


@dataclass(frozen=True, eq=False)
class Alongside:
    """
    Columns that files do not hold, at times further apart; straight lines between.

    Attributes
    ----------
    start : datetime64
    seconds : array
        Times since the start. [s]
    columns : dict of array
        What turns goes on past 360°, the shorter way from one to the next.
    """

    start: np.datetime64
    seconds: np.ndarray = field(repr=False)
    columns: dict = field(repr=False)

    @classmethod
    def of(cls, inputs, names):
        """Those columns of some inputs."""
        columns = {name: inputs[name] for name in names}
        turning = {n: np.unwrap(columns[n], period=360.0) for n in ROUND if n in names}
        start = instants(inputs.index[:1])[0]
        return cls(start, since(start, inputs.index), columns | turning)

    def at(self, index):
        """The columns at other times."""
        wanted = since(self.start, index)
        found = {
            name: np.interp(wanted, self.seconds, values)
            for name, values in self.columns.items()
        }
        return found | {n: found[n] % 360.0 for n in ROUND if n in found}


def since(start, index):
    """Times since a first one. [s]"""
    return (instants(index) - start) / np.timedelta64(1, "s")
