"""A record in files less what was not measured, which is known by its rows alone."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from pvlib_fem.record.parquet import Block, ParquetRecord

NONE = np.empty((0, 2), dtype=np.int64)


@dataclass(frozen=True, eq=False)
class CleanRecord:
    """A :class:`ParquetRecord` with NaN where a value is at fault."""

    source: ParquetRecord
    names: tuple
    holes: dict = field(default_factory=dict)  # column to spans of rows, see spans
    clip: bool = False  # whether negative irradiance is 0
    beside: tuple = ()  # of Alongside and Trailing: columns that the files do not hold

    def __len__(self):
        return len(self.source)

    def lacking(self, rows):
        """The same without further spans of rows, by column."""
        both = {name: joined(self.of(name), more) for name, more in rows.items()}
        return replace(self, holes=self.holes | both)

    def clipped(self):
        """The same with 0 where irradiance is below it."""
        return replace(self, clip=True)

    def with_columns(self, more):
        """The same with columns that the files do not hold."""
        return replace(self, beside=(*self.beside, more))

    def of(self, name):
        return self.holes.get(name, NONE)

    def blocks(self, names=None) -> Iterator[Block]:
        """
        The record in blocks, as it is screened.

        What the files do not hold is there where no names are given.
        """
        beside = [more.begun() for more in self.beside] if names is None else []
        for block in self.source.blocks(self.names if names is None else names):
            columns = self.cleaned(block.inputs.columns, block.start, len(block))
            inputs = replace(block.inputs, columns=columns)
            for more in beside:
                inputs = inputs.having(more.at(inputs))
            yield replace(block, inputs=inputs)

    def values(self) -> Iterator[tuple[int, dict]]:
        """First row and columns of the same blocks, without their times."""
        for start, columns in self.source.values(self.names):
            yield start, self.cleaned(columns, start, len(columns[self.names[0]]))

    def cleaned(self, columns, start, rows):
        """Columns of a block as they are screened."""
        columns = dict(columns)
        for name, values in columns.items():
            for first, end in within(self.of(name), start, rows):
                columns[name] = values = np.array(values)
                values[first:end] = np.nan
        if self.clip and "poa_global" in columns:
            columns["poa_global"] = np.maximum(columns["poa_global"], 0.0)
        return columns


def spans(rows, start=0):
    """Rows that are there, by first and one after the last of those that join."""
    rows = np.asarray(rows, dtype=np.int64)
    if not len(rows):
        return NONE
    ends = np.flatnonzero(np.diff(rows) > 1)
    first, last = rows[np.append(0, ends + 1)], rows[np.append(ends, len(rows) - 1)]
    return np.column_stack([first, last + 1]) + start


def joined(one, other):
    """Spans of both, in order."""
    both = np.concatenate([one, other])
    return both[np.argsort(both[:, 0], kind="stable")]


def united(one, other):
    """Spans of both, which may overlap, as spans that do not."""
    both = joined(one, other)
    ends = np.maximum.accumulate(both[:, 1])
    first = np.flatnonzero(np.append(True, both[1:, 0] > ends[:-1]))
    return np.column_stack([both[first, 0], np.append(ends[first[1:] - 1], ends[-1])])


def size(some):
    """Number of rows in spans that do not overlap."""
    return int((some[:, 1] - some[:, 0]).sum())


def within(some, start, rows):
    """Those parts of spans that lie in a block, counted from its first row."""
    if not len(some):
        return some
    near = some[(some[:, 1] > start) & (some[:, 0] < start + rows)]
    return np.clip(near - start, 0, rows)


def covered(some, rows):
    """Whether each of some rows is in a span; spans do not overlap."""
    if not len(some):
        return np.zeros(len(rows), dtype=bool)
    place = np.searchsorted(some[:, 0], rows, side="right") - 1
    return (place >= 0) & (rows < some[place, 1])
