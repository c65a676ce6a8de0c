"""A record less what was not measured, which is known by its rows alone."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np
import pandas as pd

from pvlib_fem._record.checks import SECONDS, instants
from pvlib_fem._record.inputs import Inputs
from pvlib_fem._record.parquet import ROWS, Block, ParquetRecord, times_of_counts

NONE = np.empty((0, 2), dtype=np.int64)


class BlockColumns(Protocol):
    """Columns of one block after the other."""

    def at(self, inputs: Inputs) -> dict[str, np.ndarray]:
        """The columns in the rows of the next block."""
        ...


class AddedColumns(Protocol):
    """Columns that files do not hold."""

    def begun(self) -> BlockColumns:
        """The columns of the blocks of a record, from the first on."""
        ...


class FrameRecord:
    """
    A record in memory, read in blocks as a :class:`ParquetRecord` is.

    Parameters
    ----------
    inputs : Inputs
        With times.
    """

    files = ("",)

    def __init__(self, inputs: Inputs) -> None:
        self.inputs = inputs

    def __len__(self) -> int:
        return len(self.inputs.index)

    def shares(self, name: str, other: "FrameRecord") -> bool:
        """Whether another record has the same column, at the same times."""
        mine, its = self.inputs.columns.given, other.inputs.columns.given
        same = name in its and mine[name] is its[name]
        return same and self.inputs.index is other.inputs.index

    @cached_property
    def counts(self) -> np.ndarray:
        """Times as counts of the index's unit since 1970."""
        return instants(self.inputs.index).view("i8")

    def time_at(self, count: int) -> pd.Timestamp:
        """The time of such a count."""
        return self.index(np.array([count]))[0]

    def index(self, counts: Any) -> Any:
        """The times of such counts."""
        whole: Any = self.inputs.index
        return times_of_counts(counts, whole.unit, whole.tz)

    def blocks(self, names: tuple, rows: int = ROWS) -> Iterator:
        """The columns of some names, in blocks of rows."""
        columns = self.inputs.columns.only(names)
        whole: Any = self.inputs.index
        unit = SECONDS[whole.unit]
        for start in range(0, len(self), rows):
            some = slice(start, start + rows)
            counts = self.counts[some]
            before = self.counts[max(start - 1, 0)]
            steps = np.diff(counts, prepend=before)
            part = Inputs(columns.at_rows(some), steps, unit, whole[some], True)
            yield Block(part, start, "")

    def values(self, names: Any) -> Iterator:
        """First row and columns of the same blocks, without their times."""
        for block in self.blocks(names):
            yield block.start, dict(block.inputs.columns)


@dataclass(frozen=True, eq=False)
class CleanRecord:
    """A :class:`ParquetRecord`, or one in memory, with NaN for values at fault."""

    source: ParquetRecord | FrameRecord
    names: tuple
    holes: dict = field(default_factory=dict)  # column to spans of rows, see spans
    clip: bool = False  # whether negative irradiance is 0
    added: tuple = ()  # Alongside and Trailing: columns that the files do not hold

    def __len__(self) -> int:
        return len(self.source)

    def lacking(self, rows: dict) -> "CleanRecord":
        """The record without further spans of rows, by column."""
        both = {
            name: joined_spans(self.holes_of(name), more) for name, more in rows.items()
        }
        return replace(self, holes=self.holes | both)

    def clipped(self) -> "CleanRecord":
        """The record with 0 instead of negative irradiance."""
        return replace(self, clip=True)

    def with_columns(self, more: AddedColumns) -> "CleanRecord":
        """The record with columns that the files do not hold."""
        return replace(self, added=(*self.added, more))

    def holes_of(self, name: str) -> np.ndarray:
        """Spans of rows of a column that were found at fault."""
        return self.holes.get(name, NONE)

    def shares(self, name: str, other: "CleanRecord") -> bool:
        """Whether another record has the same column, less the same rows."""
        if self.holes_of(name) is not other.holes_of(name):
            return False
        if self.clip != other.clip or self.added != other.added:
            return False
        one, its = self.source, other.source
        if isinstance(one, FrameRecord) and isinstance(its, FrameRecord):
            return one.shares(name, its)
        return one is its

    def blocks(self, names: tuple | None = None) -> Iterator[Block]:
        """
        The record in blocks, as it is screened.

        What the files do not hold is there where no names are given.
        """
        added = [more.begun() for more in self.added] if names is None else []
        for block in self.source.blocks(self.names if names is None else names):
            columns = self.cleaned(block.inputs.columns, block.start, len(block))
            inputs = replace(block.inputs, columns=columns)
            for more in added:
                inputs = inputs.having(more.at(inputs))
            yield replace(block, inputs=inputs)

    def values(self) -> Iterator[tuple[int, dict]]:
        """First row and columns of the same blocks, without their times."""
        for start, columns in self.source.values(self.names):
            yield start, self.cleaned(columns, start, len(columns[self.names[0]]))

    def cleaned(self, columns: Any, start: int, rows: int) -> dict[str, np.ndarray]:
        """Columns of a block as they are screened."""
        columns = dict(columns)
        for name, values in columns.items():
            holes = spans_within(self.holes_of(name), start, rows)
            if len(holes):
                columns[name] = values = np.array(values)
            for first, end in holes:
                values[first:end] = np.nan
        if self.clip and "poa_global" in columns:
            columns["poa_global"] = np.maximum(columns["poa_global"], 0.0)
        return columns


def spans(rows: list | np.ndarray, start: int = 0) -> np.ndarray:
    """
    Runs of rows that follow each other.

    Parameters
    ----------
    rows : array of int, shape (rows,)
        Numbers of rows, in order.
    start : int, default 0
        Added to each number.

    Returns
    -------
    array of int, shape (spans, 2)
        First row of each run, and one after its last.
    """
    rows = np.asarray(rows, dtype=np.int64)
    if not len(rows):
        return NONE
    ends = np.flatnonzero(np.diff(rows) > 1)
    first, last = rows[np.append(0, ends + 1)], rows[np.append(ends, len(rows) - 1)]
    return np.column_stack([first, last + 1]) + start


def joined_spans(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Spans of both, in order."""
    both = np.concatenate([one, other])
    return both[np.argsort(both[:, 0], kind="stable")]


def united_spans(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """
    Spans of both, which may overlap, as spans that do not.

    Parameters
    ----------
    one, other : array of int, shape (spans, 2)
        Not both empty, see :func:`spans`.

    Returns
    -------
    array of int, shape (spans, 2)
        In order.
    """
    both = joined_spans(one, other)
    ends = np.maximum.accumulate(both[:, 1])
    first = np.flatnonzero(np.append(True, both[1:, 0] > ends[:-1]))
    return np.column_stack([both[first, 0], np.append(ends[first[1:] - 1], ends[-1])])


def count_rows(some: np.ndarray) -> int:
    """
    Number of rows in spans that do not overlap.

    Parameters
    ----------
    some : array of int, shape (spans, 2)
        See :func:`spans`.

    Returns
    -------
    int
    """
    return int((some[:, 1] - some[:, 0]).sum())


def spans_within(some: np.ndarray, start: int, rows: int) -> np.ndarray:
    """Parts of spans within a block, counted from its first row."""
    if not len(some):
        return some
    near = some[(some[:, 1] > start) & (some[:, 0] < start + rows)]
    return np.clip(near - start, 0, rows)


def spans_mask(some: np.ndarray, rows: int) -> np.ndarray:
    """
    Booleans of the rows of a record, True in spans.

    Parameters
    ----------
    some : array of int, shape (spans, 2)
        See :func:`spans`.
    rows : int
        Number of rows of the record.

    Returns
    -------
    array of bool, shape (rows,)
    """
    mask = np.zeros(rows, dtype=bool)
    for first, end in some:
        mask[first:end] = True
    return mask


def rows_in_spans(some: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """
    Whether each of some rows is in a span.

    Parameters
    ----------
    some : array of int, shape (spans, 2)
        In order, not overlapping, see :func:`spans`.
    rows : array of int, shape (rows,)
        Numbers of rows, in any order.

    Returns
    -------
    array of bool, shape (rows,)
    """
    if not len(some):
        return np.zeros(len(rows), dtype=bool)
    place = np.searchsorted(some[:, 0], rows, side="right") - 1
    return (place >= 0) & (rows < some[place, 1])
