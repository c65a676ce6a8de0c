"""A record on longer steps, for what does not need short ones."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.checks import instants, usual_step
from pvlib_fem._record.column_names import ANGLES, GEOMETRY, ROTATION
from pvlib_fem._record.inputs import Columns, Inputs, Record

#: where a plane stands at the end of a step: of east and west there is no mean
AT_END = (*GEOMETRY[2:], ROTATION)


def coarse(record: Record, step: float = 300.0, present: float = 0.5) -> Record:
    """
    The record in means over longer steps, or as it is where they are long enough.

    An input is held over the step that ends at its sample, so inputs are means up
    to a time, and the module's temperature is the mean around it. Angles of the plane
    are those at the end of a step.

    Parameters
    ----------
    record : Record
    step : float, default 300
        Length of the longer steps, counted from midnight UTC before the first row. [s]
    present : float, default 0.5
        Share of a step's rows that have to be there; else the mean is NaN. [-]

    Returns
    -------
    Record
        ``record`` itself if its median step is more than half of ``step``, or it has
        one row.
    """
    usual = usual_step(record.index)
    if not usual <= step / 2.0:  # or of one row
        return record
    sums = Sums(step, present * step / usual)
    sums.add(record.index, record.inputs.columns)
    return replace(record, inputs=sums.inputs())


@dataclass(eq=False)
class Sums:
    """Sums of the rows at each of some longer steps, as far as rows were added."""

    step: float  # [s]
    least: float  # rows of a step that have to be there
    day: np.datetime64 | None = None  # on which the record begins, in UTC
    zone: Any = None
    first: int = 0  # number of the first step since then
    there: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=bool))
    sums: dict = field(default_factory=dict)  # column to sums and counts
    ends: dict = field(default_factory=dict)  # column to values at the ends of steps

    def add(self, index: pd.DatetimeIndex, columns: dict | Columns) -> None:
        """Add rows, each block of them later than those before."""
        at = instants(index)
        if self.day is None:
            self.day, self.zone = at[0].astype("datetime64[D]"), index.tz
        since = (at - self.day) / np.timedelta64(1, "s")
        until = np.ceil(since / self.step - 1e-9).astype(int)
        around = np.floor(since / self.step + 0.5 - 1e-9).astype(int)
        if not len(self.there):
            self.first = until[0]
        # the last half step has a label of its own
        size = until[-1] - self.first + 2
        self.there = grown_array(self.there, size)
        self.there[until - self.first] = True
        until, around = self.places(until), self.places(around)
        for name, values in columns.items():
            places = around if name == "temp_module" else until
            if name in AT_END:
                self.end(name, values, *places, size)
            elif name in ANGLES:
                turned = np.radians(values)
                self.put((name, "east"), np.sin(turned), *places, size)
                self.put((name, "north"), np.cos(turned), *places, size)
            else:
                self.put((name, ""), values, *places, size)

    def places(self, number: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First row of each step, whose rows follow each other, and its place."""
        first = np.flatnonzero(np.diff(number, prepend=number[0] - 1))
        at = number[first] - self.first
        return first, at + (at < 0)

    def put(
        self,
        key: tuple,
        values: np.ndarray,
        first: np.ndarray,
        at: np.ndarray,
        size: int,
    ) -> None:
        """Add values of one column at the places of their steps."""
        sums, counts = self.sums.get(key, (np.zeros(0), np.zeros(0)))
        sums, counts = grown_array(sums, size), grown_array(counts, size)
        missing = np.isnan(values)
        if missing.any():
            values = np.where(missing, 0.0, values)
            number = np.add.reduceat(~missing, first, dtype=float)
        else:
            number = np.diff(first, append=len(values))
        part = slice(at[0], at[-1] + 1)
        counts[part] += np.bincount(at - at[0], number)
        sums[part] += np.bincount(at - at[0], np.add.reduceat(values, first))
        self.sums[key] = sums, counts

    def end(self, name: str, values: Any, first: Any, at: Any, size: int) -> None:
        """Take the last value of one column in each step."""
        last = np.append(first[1:], len(values)) - 1
        ends = self.ends.get(name, np.zeros(0))
        ends = np.append(ends, np.full(max(size - len(ends), 0), np.nan))
        ends[at] = values[last]
        self.ends[name] = ends

    def means(self, key: tuple) -> np.ndarray:
        sums, counts = (part[: len(self.there)][self.there] for part in self.sums[key])
        enough = counts >= max(1.0, self.least)
        return np.where(enough, sums / np.maximum(counts, 1), np.nan)

    def inputs(self) -> Inputs:
        """The means as columns on the times at which their steps end."""
        columns = {}
        for name, part in self.sums:
            if part == "north":
                continue
            values = self.means((name, part))
            if part == "east":
                north = self.means((name, "north"))
                values = np.degrees(np.arctan2(values, north)) % 360.0
            columns[name] = values
        for name, values in self.ends.items():
            columns[name] = values[: len(self.there)][self.there]
        labels = self.first + np.flatnonzero(self.there)
        index = pd.DatetimeIndex(self.day + (labels * self.step * 1e9).astype("m8[ns]"))
        if self.zone is not None:
            index = index.tz_localize("UTC").tz_convert(self.zone)
        gaps = np.diff(labels, prepend=labels[0]).astype(float)
        steps = 1.0 if (gaps[1:] == 1.0).all() else gaps
        return Inputs(columns, steps, self.step, index, True)


def grown_array(values: np.ndarray, size: int) -> np.ndarray:
    """An array with room for more."""
    if size <= len(values):
        return values
    more = max(size, 2 * len(values)) - len(values)
    return np.concatenate([values, np.zeros(more, values.dtype)])


def covered_rows(
    masks: tuple, record: Record, other: Record
) -> list | tuple[np.ndarray, np.ndarray]:
    """
    Rows of the coarse record in whose step each of some masks holds for any row.

    Parameters
    ----------
    masks : sequence of array of bool, shape (rows,)
        On the rows of ``record``.
    record : Record
    other : Record
        The coarse one, or ``record`` itself.

    Returns
    -------
    sequence of array of bool, shape (coarse rows,)
        One for each mask; ``masks`` themselves if the records are the same.
    """
    if other is record:
        return masks
    # how many rows are over at the end of each step; what is later is of none
    over = np.searchsorted(instants(record.index), instants(other.index), "right")
    counts = (np.concatenate(([0], np.cumsum(mask)))[over] for mask in masks)
    return [np.diff(count, prepend=0) > 0 for count in counts]
