"""A Parquet data set as a record that is read block by block, in the order of time."""

import itertools
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self, TypeGuard

import numpy as np
import pandas as pd

from pvlib_fem._record.checks import (
    SECONDS,
    as_numbers,
    check_order,
    dates_of,
    instants,
)
from pvlib_fem._record.column_names import COLUMNS, SERVED, of_horizontal, twin_of
from pvlib_fem._record.file_times import zoned
from pvlib_fem._record.footers import (
    common_columns,
    common_times,
    footers_of,
    found_files,
    in_order,
    parquet_file,
    times_of,
)
from pvlib_fem._record.header_units import (
    QUANTITIES,
    named_unit,
    own_unit,
    stated_columns,
    usual_name_of,
)
from pvlib_fem._record.inputs import Columns, Inputs
from pvlib_fem._record.parquet_times import in_file, on_the_clock
from pvlib_fem._spelling import refusal
from pvlib_fem._stored import replacing
from pvlib_fem.types import FilePath

ROWS = 1 << 18  # of a block: some megabytes


@dataclass(frozen=True, eq=False)
class Block:
    """Rows that follow each other, and where in the record they stand."""

    inputs: Inputs  # the first step is that since the block before; 0 of the first
    start: int  # number of the first row
    file: str

    def __getitem__(self, name: str) -> np.ndarray:
        return self.inputs.columns[name]

    def __len__(self) -> int:
        return len(self.inputs.index)

    @property
    def index(self) -> Any:
        return self.inputs.index

    @cached_property
    def times(self) -> Any:
        """Times as counts of the unit since 1970, in UTC where they have a zone."""
        return instants(self.index).view("i8")

    @cached_property
    def dates(self) -> np.ndarray:
        """Calendar day of each row in the record's zone, from 1970-01-01."""
        ends = self.index[[0, -1]]
        offsets = [
            local - utc for local, utc in zip(ends.tz_localize(None), utc_of(ends))
        ]
        if offsets[0] != offsets[1] or ends[1] - ends[0] > pd.Timedelta("7D"):
            return dates_of(self.index)
        # of a stretch without a change of the clock only its midnights are looked for
        first, last = dates_of(ends)
        days = np.arange(first, last + 1, dtype=np.int32)
        midnights = pd.DatetimeIndex(days[1:].astype("M8[D]").astype("M8[ns]"))
        utc_midnights = instants(midnights - offsets[0]).astype(
            f"M8[{self.index.unit}]"
        )
        edges = np.searchsorted(self.times, utc_midnights.view("i8"))
        return np.repeat(days, np.diff([0, *edges, len(self)]))


@dataclass(frozen=True, eq=False)
class Made:
    """
    A column that is computed from others of the files, block by block.

    Attributes
    ----------
    name : str
    needs : dict of str
        The package's names of those to the files'.
    function : callable
        Of their values by the package's names, and the times, to the column's values.
    """

    name: str
    needs: dict
    function: Callable[[dict, pd.DatetimeIndex], np.ndarray]


@dataclass(frozen=True, eq=False)
class ParquetRecord:
    """
    A record in Parquet files that is never held in memory as a whole.

    From :func:`pvlib_fem.open_parquet`. ``fit_fem`` takes it instead of the
    columns, and ``len(record)`` is its number of rows.

    Attributes
    ----------
    files : tuple of str
        In the order of their times.
    columns : dict of str
        The package's names to those of the files, of all columns of numbers.
    tz : str or None
        Zone of days and hours.
    """

    files: tuple
    columns: dict
    tz: str | None
    time: str
    unit: str  # of the times
    groups: tuple
    partial: dict  # why a column that some files have cannot be read, by name
    naive: bool  # whether the files' times have no zone
    filesystem: Any = None  # of pyarrow; None for local files
    absent: tuple = ()  # columns that nobody measured, which hold 0
    notes: tuple = ()  # rows without a time, which are dropped, and what is made
    made: Made | None = None  # a column that no file has

    def __len__(self) -> int:
        return sum(group.rows for group in self.groups)

    @property
    def ends(self) -> tuple[pd.Timestamp, pd.Timestamp]:
        """First and last time, in the record's zone."""
        ends = pd.DatetimeIndex([self.groups[0].first, self.groups[-1].last])
        return tuple(in_zone(ends, self.tz, self.naive, np.array([False, True])))

    @property
    def stated(self) -> tuple[str, ...]:
        """Columns whose headers name the package's own unit."""
        return tuple(stated_columns(self.columns))

    def __repr__(self) -> str:
        first, last = self.ends
        return (
            f"ParquetRecord: {len(self.files)} files, {len(self):,} rows, {first} to "
            f"{last}; {', '.join(self.columns)}"
        )

    def time_at(self, count: int) -> pd.Timestamp:
        """The time of a count of the unit since 1970, in the record's zone."""
        return self.index(np.array([count]))[0]

    def index(self, counts: np.ndarray) -> pd.DatetimeIndex:
        """The times of counts of the unit since 1970, in the record's zone."""
        return times_of_counts(counts, self.unit, self.tz)

    def without(self, name: str) -> Self:
        """The record with 0 for a column that no file has."""
        if name in self.columns or name in self.partial:
            return self
        return replace(self, absent=(*self.absent, name))

    def needing(self, names: Iterable[str]) -> Self:
        """The record, if all files have columns of some names."""
        for name in names:
            if name in self.partial:
                raise ValueError(self.partial[name])
        there = {*self.columns, *self.absent}
        if self.made is not None:
            there.add(self.made.name)
        if missing := [name for name in names if name not in there]:
            others = [n for n in self.columns if twin_of(n) == missing[0] in SERVED]
            other = repr(self.columns[others[0]]) if others else "..."
            raise refusal(
                f"{self.files[0]} has no column{'s' * (len(missing) > 1)} "
                f"{', '.join(missing)}; it has "
                f"{', '.join(self.columns)}; name a column with columns="
                f"{{{missing[0]!r}: {other}}}",
                *of_horizontal(missing, self.columns),
            )
        return self

    def blocks(
        self, names: Iterable[str] = COLUMNS, rows: int | None = None
    ) -> Iterator[Block]:
        """
        The record in blocks of rows, its columns as float64.

        Parameters
        ----------
        names : sequence of str
            Columns, by the package's names.
        rows : int, optional
            Most that a block has.

        Raises
        ------
        ValueError
            If times do not rise, or a column holds an infinity; the message names
            the file.
        """
        self.needing(names)
        made = self.made if self.made and self.made.name in names else None
        wanted = {n: self.columns[n] for n in names if n in self.columns}
        if made:
            wanted = made.needs | wanted
        start, before = 0, None
        for file, batch, late in self.batches([self.time, *wanted.values()], rows):
            try:
                index = self.times(batch.column(self.time), late)
                count = instants(index).view("i8")
                steps = np.diff(count, prepend=count[:1] if before is None else before)
                if before is not None and steps[0] <= 0:
                    raise ValueError(f"the time {index[0]} comes after later ones")
                check_order(steps, index, "the time")
                columns = {
                    name: as_numbers(name, numpy_values(batch.column(column)), index)
                    for name, column in wanted.items()
                }
                if made:
                    columns[made.name] = made.function(columns, index)
                    columns = {n: columns[n] for n in names if n in columns}
                columns |= self.nothing(names, batch)
            except ValueError as error:
                raise ValueError(f"{file}: {error}") from error
            unit = SECONDS[index.unit]
            inputs = Inputs(Columns(columns), steps, unit, index, True)
            yield Block(inputs, start, file)
            start, before = start + len(index), count[-1]

    def values(
        self, names: Iterable[str] = COLUMNS, rows: int | None = None
    ) -> Iterator[tuple[int, dict]]:
        """First row and columns of the same blocks, without their times."""
        if self.made and self.made.name in names:  # of the times, too
            for block in self.blocks(names, rows):
                yield block.start, dict(block.inputs.columns)
            return
        wanted = {n: self.columns[n] for n in names if n not in self.absent}
        start = 0
        for _, batch, _ in self.batches([*wanted.values()], rows):
            columns = {
                name: float_column(batch, column) for name, column in wanted.items()
            }
            yield start, columns | self.nothing(names, batch)
            start += batch.num_rows

    def nothing(self, names: Iterable[str], batch: Any) -> dict[str, np.ndarray]:
        """Columns that no file has, of the rows of a batch."""
        rows = batch.num_rows
        return {name: np.zeros(rows) for name in names if name in self.absent}

    def batches(
        self, columns: list, rows: int | None
    ) -> Iterator[tuple[str, Any, np.ndarray]]:
        """Files and batches in the order of time; rows that a clock shows again."""
        for file, some in itertools.groupby(self.groups, lambda group: group.file):
            groups, start = list(some), 0
            dropped, late = in_file(groups)
            numbers = [group.number for group in groups]
            how = dict(batch_size=rows or ROWS, row_groups=numbers, columns=columns)
            with parquet_file(file, self.filesystem) as opened:
                for batch in opened.iter_batches(**how):
                    here = np.arange(start, start + batch.num_rows)
                    start += batch.num_rows
                    if len(dropped):
                        here = here[kept := ~np.isin(here, dropped)]
                        batch = batch.filter(kept)
                    if batch.num_rows:
                        yield file, batch, np.isin(here, late)

    def times(self, column: Any, late: np.ndarray) -> pd.DatetimeIndex:
        """A column of times as an index in the record's zone."""
        stamps = column.to_numpy(zero_copy_only=False).astype(f"M8[{self.unit}]")
        index = pd.DatetimeIndex(stamps, name="time")
        return in_zone(index, self.tz, self.naive, late)


def open_parquet(
    data: FilePath | Any,
    columns: Mapping[str, str] | None = None,
    time: str | None = None,
    tz: str | None = None,
    check_units: bool = True,
    drop_untimed: bool = False,
) -> ParquetRecord:
    """
    A Parquet data set of any size as a record for a fit, which reads it in blocks.

    Parameters
    ----------
    data : str, path-like, list of these, or pyarrow.dataset.Dataset
        A file or some, a folder, of which all ``.parquet`` files below it count, or a
        pattern such as ``"plant/2024-*.parquet"``; or a Dataset of pyarrow, for other
        places and partitions. Takes ``pip install 'pvlib_fem[parquet]'``.
    columns : dict, optional
        Package's name to the files', as ``{"poa_global": "Irr"}``. Other columns keep
        their names.
    time : str, optional
        Column of the times; by default the index that pandas stored, or else the first
        column of timestamps.
    tz : str, optional
        Zone of naive times, or that into which others are brought. Rows at times that
        its clock skips are dropped, and those of an hour that it shows twice and the
        files have once; ``record.notes`` count them.
    check_units : bool, default True
        Refuse a column whose header names another unit.
    drop_untimed : bool, default False
        Leave out rows that hold no time; ``record.notes`` count them.

    Returns
    -------
    ParquetRecord

    Raises
    ------
    ValueError
        If there is no file, one has other columns or types of these, or no times, or
        the times of two overlap; the message names the file.

    Notes
    -----
    Files are brought into the order of their times, whatever their names; hours
    that lack are gaps, as in a DataFrame. Of the files only footers are read here,
    and the times of row groups in which the clock of ``tz`` changes or times lack.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import pvlib_fem as fem
    >>> folder, data = Path(tempfile.mkdtemp()), fem.datasets.synthetic(days=4)
    >>> for day, part in data.groupby(data.index.date):
    ...     part.to_parquet(folder / f"{day}.parquet")
    >>> record = fem.open_parquet(folder)
    >>> len(record.files), len(record), record.tz
    (4, 5760, 'Etc/GMT+7')
    """
    files, filesystem = found_files(data)
    footers = [*footers_of(files, filesystem, time)]
    if not footers:
        more = f" and {len(files) - 1:,} other files" if len(files) > 1 else ""
        raise ValueError(f"no row is in {files[0]}{more}; give files with rows")
    footers.sort(key=lambda footer: min(group.first for group in footer.groups))
    zone, unit = common_times(footers)
    if tz is not None:
        zoned(pd.DatetimeIndex([], tz="UTC"), tz)  # which refuses what is no zone
    names, partial = common_columns(footers, columns or {})
    if check_units:
        refuse_headers(names)
    groups = in_order([group for footer in footers for group in footer.groups])

    def read(group: Any) -> Any:
        return times_of(group, footers[0].time, filesystem)

    groups, notes = on_the_clock(groups, read, None if zone else tz, drop_untimed)
    ordered = tuple(dict.fromkeys(group.file for group in groups))
    own = footers[0].time, unit, tuple(groups), partial, zone is None, filesystem
    return ParquetRecord(ordered, names, tz or zone, *own, notes=tuple(notes))


def is_data_set(data: object) -> TypeGuard[ParquetRecord | FilePath]:
    """
    Whether an argument names Parquet files, rather than being columns.

    Parameters
    ----------
    data : object

    Returns
    -------
    bool
        True for a text, a path, a :class:`ParquetRecord` and a Dataset of pyarrow.
    """
    kinds = str, os.PathLike, ParquetRecord
    return isinstance(data, kinds) or hasattr(data, "get_fragments")


def as_source(data: ParquetRecord | FilePath) -> ParquetRecord:
    """
    A data set as it is opened, if it is not yet.

    Parameters
    ----------
    data : ParquetRecord, str, path-like or pyarrow.dataset.Dataset

    Returns
    -------
    ParquetRecord

    Raises
    ------
    ValueError
        If it cannot be opened, see :func:`open_parquet`.
    """
    return data if isinstance(data, ParquetRecord) else open_parquet(data)


def refuse_headers(names: dict) -> None:
    """Refuse a column whose header names another unit."""
    for name, header in names.items():
        if usual_name_of(name) is None or (name not in QUANTITIES and name == header):
            continue
        unit = named_unit(name, str(header))
        if unit not in (None, own_unit(name)):
            raise ValueError(
                f"the header {header!r} names {unit}, and {name} has to be in "
                f"{own_unit(name)}; convert the files, or give check_units=False if "
                "it is in that unit already"
            )


def utc_of(index: pd.DatetimeIndex) -> pd.DatetimeIndex:
    return index if index.tz is None else index.tz_convert(None)


def write_parquet(path: FilePath, blocks: Iterable[tuple], name: str) -> None:
    """
    Write a column of blocks of times and values as one file, whole or not at all.

    Parameters
    ----------
    path : str or path-like
    blocks : iterable of tuple
        DatetimeIndex and values, an array of shape (rows,), of each block in the order
        of time.
    name : str
        Of the column.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    with replacing(path) as whole:
        writer = None
        for index, values in blocks:
            data = pd.DataFrame({name: values}, index.rename("time"))
            table = pa.Table.from_pandas(data)
            writer = writer or pq.ParquetWriter(whole, table.schema)
            writer.write_table(table)
        if writer is not None:
            writer.close()


def times_of_counts(counts: Any, unit: str, tz: Any) -> pd.DatetimeIndex:
    """
    The times of counts since 1970.

    Parameters
    ----------
    counts : array of int, shape (rows,)
        In UTC, or without a zone.
    unit : str
        What is counted, such as ``"ns"``.
    tz : str or tzinfo, optional
        Zone of the times.

    Returns
    -------
    DatetimeIndex, length rows
    """
    times = np.asarray(counts, dtype="i8").view(f"M8[{unit}]")
    return in_zone(pd.DatetimeIndex(times), tz)


def in_zone(
    index: pd.DatetimeIndex, tz: Any, naive: bool = False, late: Any = None
) -> Any:
    """Instants in a zone, or naive times of it, some for the second time."""
    if tz is None:
        return index
    if naive:
        return index.tz_localize(tz, ambiguous=~late)
    return index.tz_localize("UTC").tz_convert(tz)


def float_column(batch: Any, column: str) -> np.ndarray:
    """A column that has been looked at, as float64."""
    return numpy_values(batch.column(column)).astype(float, copy=False)


def numpy_values(column: Any) -> np.ndarray:
    """A column of numbers as numpy has it, NaN where it has none."""
    if str(column.type).startswith("decimal"):
        column = column.cast("float64")
    return column.to_numpy(zero_copy_only=False)
