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
    times : array of datetime64
    columns : dict of array
    """

    times: np.ndarray
    columns: dict = field(repr=False)

    @classmethod
    def of(cls, inputs, names):
        """Those columns of some inputs."""
        return cls(instants(inputs.index), {name: inputs[name] for name in names})

    def at(self, index):
        """The columns at other times."""
        start = self.times[0]
        known, wanted = (
            (times - start) / np.timedelta64(1, "s")
            for times in (self.times, instants(index))
        )
        return {
            name: between(wanted, known, values, name in ROUND)
            for name, values in self.columns.items()
        }


def between(wanted, known, values, turns):
    """Values between others; of what turns the shorter way round."""
    if not turns:
        return np.interp(wanted, known, values)
    return np.interp(wanted, known, np.unwrap(values, period=360.0)) % 360.0
