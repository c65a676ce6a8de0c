"""Errors that repeat without a known cause, as predictions have them."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
import pandas as pd

from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem._record.inputs import Inputs, read
from pvlib_fem._spelling import no_columns
from pvlib_fem._statistics.axes import CLOCK, Axis, calendar_of
from pvlib_fem._statistics.tables import Table, cell_numbers
from pvlib_fem._thermal.model import as_in_a_fit
from pvlib_fem.drivers import derive_drivers, underived


@dataclass(frozen=True, eq=False)
class Pattern:
    """A repeatable error without a known cause."""

    #: bins of one or two drivers: the clock, the calendar, columns, and past means of
    #: irradiance and air minus the present
    axes: tuple[Axis, ...]
    #: mean error in each cell, shrunk by its uncertainty; the last axis varies fastest
    #: [K]
    means: tuple[float, ...] = field(repr=False)
    zone: str = ""  # of hours and months; "" for times without one

    def __post_init__(self) -> None:  # what a file may have wrong
        cells = int(np.prod([len(axis.labels) for axis in self.axes]))
        if len(self.means) != cells:
            raise ValueError(f"it has {len(self.means)} means for {cells} cells")
        for axis in self.axes:
            if not axis.column and axis.name not in CLOCK:
                raise ValueError(f"{axis.name} is none of {', '.join(CLOCK)}")
            if axis.cuts and len(axis.cuts) != axis.known - 1:
                raise ValueError(
                    f"{axis.name} has {len(axis.cuts)} cuts for {axis.known} bins"
                )
            if list(axis.cuts) != sorted(axis.cuts):
                raise ValueError(f"the cuts of {axis.name} do not rise")

    @classmethod
    def from_table(cls, table: Table, index: pd.DatetimeIndex) -> Self:
        """The pattern of a table of a record with these times."""
        own = tuple(replace(axis, bins=np.zeros(0, dtype=int)) for axis in table.axes)
        zone = "" if index.tz is None else str(index.tz)
        return cls(own, tuple((table.shares * table.means).tolist()), zone)

    @property
    def name(self) -> str:
        """Names of its axes."""
        return " × ".join(axis.name for axis in self.axes)

    @property
    def drivers(self) -> list[str]:
        """Drivers that it needs, without clock and calendar."""
        return [axis.column for axis in self.axes if axis.column]

    def at(self, inputs: Inputs) -> np.ndarray:
        """Error at some times; 0 where a driver is missing. [K]"""
        calendar = calendar_of(self.local(inputs.index))
        cells = [
            axis.numbers(inputs[axis.column] if axis.column else calendar[axis.name])
            for axis in self.axes
        ]
        known = np.all([cell >= 0 for cell in cells], axis=0)
        bins = (replace(axis, bins=cell) for axis, cell in zip(self.axes, cells))
        groups, _ = cell_numbers(tuple(bins))
        return np.where(known, np.array(self.means)[np.where(known, groups, 0)], 0.0)

    def local(self, index: pd.Index) -> pd.Index:
        """Some times by the clock of the record."""
        if isinstance(index, pd.DatetimeIndex) and index.tz is not None and self.zone:
            return index.tz_convert(self.zone)
        return index


def drivers_of(patterns: tuple[Pattern, ...]) -> list[str]:
    """
    Drivers that some patterns need, each once.

    Parameters
    ----------
    patterns : tuple of Pattern
        Unexplained patterns of a loop.

    Returns
    -------
    list of str
        Names of measured columns, and of drivers that are computed from them.
    """
    return list(dict.fromkeys(name for one in patterns for name in one.drivers))


def errors_by(
    patterns: tuple[Pattern, ...],
    columns: Mapping[str, pd.Series | None],
    fallback: bool,
) -> pd.DataFrame:
    """
    Error by each pattern at the times of some columns.

    Parameters
    ----------
    patterns : tuple of Pattern
    columns : dict of Series
        ``poa_global``, ``temp_air``, ``wind_speed`` (or None), and what else the
        patterns need.
    fallback : bool
        Leave out patterns whose columns are missing.

    Returns
    -------
    DataFrame
        A column for each pattern. [K]

    Raises
    ------
    ValueError
        If a column is missing, and there is no fallback.
    """
    there = {name: column for name, column in columns.items() if column is not None}
    if fallback:
        patterns = tuple(
            one for one in patterns if {*underived(one.drivers)} <= {*there}
        )
    if lacking := [n for n in underived(drivers_of(patterns)) if n not in there]:
        raise ValueError(
            f"{no_columns(lacking)}, which unexplained patterns of this loop depend "
            f"on; give {'it' if len(lacking) == 1 else 'them'}, or patterns=False for "
            "a prediction without them"
        )
    if not patterns:
        return pd.DataFrame(index=there["poa_global"].index)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the model has warned of impossible values
        inputs = as_in_a_fit(read({COLUMNS[2]: 0.0, **there}, purpose="a pattern"))
    inputs = derive_drivers(inputs, drivers_of(patterns))
    return pd.DataFrame({one.name: one.at(inputs) for one in patterns}, inputs.index)
