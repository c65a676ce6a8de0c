"""The files of a Parquet data set: what their footers say, and their order in time."""

import glob
import itertools
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import pandas as pd

from pvlib_fem._record.checks import SECONDS
from pvlib_fem._record.column_names import by_own_names, printable
from pvlib_fem._record.layout import PARQUET
from pvlib_fem._spelling import did_you_mean


@dataclass(frozen=True)
class RowGroup:
    """A part of a file that is read by itself, and the times that it has."""

    file: str
    number: int
    rows: int
    first: pd.Timestamp  # of its rows, in UTC
    last: pd.Timestamp
    nulls: int = 0  # rows that hold no time
    dropped: tuple = ()  # rows that are not read, since they have none
    late: tuple = ()  # rows that a clock shows for the second time


@dataclass(frozen=True, eq=False)
class Footer:
    """What one file says of itself."""

    file: str
    schema: Any  # of pyarrow
    time: str
    groups: tuple

    @property
    def names(self) -> str:
        return ", ".join(self.schema.names)

    def kind(self, name: str) -> Any:
        """Type of a column, None if it is missing."""
        return self.schema.field(name).type if name in self.schema.names else None


def found_files(data: Any) -> tuple[list, None]:
    """
    Files of a Parquet data set, and where they are.

    Parameters
    ----------
    data : str, path-like, list of these, or pyarrow.dataset.Dataset
        A file, a folder with its subfolders, a pattern, or files by name.

    Returns
    -------
    files : list of str
        In the order of a list or Dataset, else sorted by name.
    filesystem : pyarrow.fs.FileSystem or None
        None for local files.

    Raises
    ------
    ValueError
        If there is no Parquet file, or the Dataset has no files.
    """
    if hasattr(data, "get_fragments"):
        if not getattr(data, "files", None):
            raise ValueError(
                f"data is a {type(data).__name__} without files; write it as Parquet"
            )
        return list(data.files), data.filesystem
    if isinstance(data, list | tuple):
        return [str(file) for file in data], None
    path = Path(data)
    files = [path] if path.is_file() else []
    if path.is_dir():
        files = [p for p in path.rglob("*") if p.suffix.lower() in PARQUET]
        if not files:
            raise ValueError(without_parquet(path))
    files = files or [Path(p) for p in glob.glob(str(data), recursive=True)]
    if not files:
        raise ValueError(
            f"no Parquet file is in {data}; give a file, a folder of .parquet files or "
            "a pattern such as 'plant/*.parquet'"
        )
    return sorted(map(str, files)), None


def without_parquet(folder: Any) -> str:
    """What was looked for in a folder, and what is there instead."""
    kinds = Counter(p.suffix.lower() for p in folder.rglob("*") if p.is_file())
    there = ", ".join(
        f"{n:,} {kind or 'without an ending'}" for kind, n in kinds.items()
    )
    return (
        f"no Parquet file is in {folder}: none in it and its subfolders ends with "
        f"{' or '.join(PARQUET)}; its files: {there or 'none'}. Give files of another "
        "kind by their names"
    )


def parquet_file(file: str, filesystem: Any) -> Any:
    """
    One file, opened; of it only the footer is read.

    Parameters
    ----------
    file : str
    filesystem : pyarrow.fs.FileSystem or None
        None for local files.

    Returns
    -------
    pyarrow.parquet.ParquetFile
        To be closed, as by ``with``.

    Raises
    ------
    ValueError
        If pyarrow is not installed, or the file is no Parquet.
    """
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError as error:
        raise ValueError(
            "reading Parquet needs pyarrow: pip install 'pvlib_fem[parquet]'"
        ) from error
    try:
        return pq.ParquetFile(file, filesystem=filesystem)
    except (pa.ArrowInvalid, OSError) as error:
        raise ValueError(f"{file} is no Parquet file that can be read") from error


def footers_of(files: list, filesystem: Any, time: str | None) -> Iterator[Footer]:
    """
    Footers of the files that have rows.

    Parameters
    ----------
    files : list of str
    filesystem : pyarrow.fs.FileSystem or None
        None for local files.
    time : str or None
        Column of the times of all files; by default the index that pandas stored in the
        first file, or else its first column of timestamps.

    Yields
    ------
    Footer

    Raises
    ------
    ValueError
        If a file cannot be read, or has no such column of timestamps.
    """
    for file in files:
        with parquet_file(file, filesystem) as opened:
            if not opened.metadata.num_rows:
                continue
            schema = opened.schema_arrow
            time = time or time_column(schema, file)
            kind = schema.field(time).type if time in schema.names else None
            if not str(kind).startswith("timestamp"):
                what = "no" if kind is None else f"{kind}s as the"
                raise ValueError(
                    f"{file} has {what} column of times {time!r}; its columns are "
                    f"{', '.join(schema.names)}"
                )
            yield Footer(file, schema, time, tuple(groups_of(file, opened, time)))


def time_column(schema: Any, file: str) -> str:
    """The column of times: pandas' index, or the first of timestamps."""
    stored = (schema.pandas_metadata or {}).get("index_columns", [])
    stamps = [field.name for field in schema if str(field.type).startswith("timestamp")]
    for name in (*(n for n in stored if isinstance(n, str)), *stamps):
        if name in stamps:
            return name
    raise ValueError(
        f"{file} has no column of timestamps; it has {', '.join(schema.names)}; write "
        "it from a DataFrame with a DatetimeIndex"
    )


def common_times(footers: list) -> tuple[str, str]:
    """
    Zone of the first file, and the finest unit of all.

    Parameters
    ----------
    footers : list of Footer
        At least one.

    Returns
    -------
    tz : str or None
        None where the times have no zone.
    unit : str
        ``"s"``, ``"ms"``, ``"us"`` or ``"ns"``.

    Raises
    ------
    ValueError
        If some files have times with a zone, and others without.
    """
    first, *others = footers
    kinds = [footer.kind(footer.time) for footer in footers]
    for footer, kind in zip(others, kinds[1:]):
        if (kind.tz is None) != (kinds[0].tz is None):
            raise ValueError(
                f"the times of {first.file} have zone {kinds[0].tz}, those of "
                f"{footer.file} {kind.tz}; write all with a zone or without"
            )
    finest = list(reversed(SECONDS)).index
    return kinds[0].tz, min((kind.unit for kind in kinds), key=finest)


def common_columns(footers: list, columns: Mapping) -> tuple[dict, dict]:
    """
    Columns of numbers that all files have, by the package's names.

    Parameters
    ----------
    footers : list of Footer
        At least one.
    columns : dict of str
        Package's name to the files', of those that are mapped.

    Returns
    -------
    common : dict of str
        Package's name to the files'.
    partial : dict of str
        Package's name to why a column cannot be read: a file has none, or no numbers.

    Raises
    ------
    ValueError
        If one that was named is not in the first file.
    """
    first = footers[0]
    for column in columns.values():
        if column not in first.schema.names:
            raise ValueError(
                f"{first.file} has no column {column}"
                f"{did_you_mean(column, first.schema.names)}; it has {first.names}"
            )
    theirs = dict.fromkeys(name for one in footers for name in one.schema.names)
    names = {
        printable(name): name
        for name in theirs
        if name != first.time and name not in columns.values()
    }
    names = by_own_names(names)
    common, partial = {}, {}
    for name, column in (names | columns).items():
        odd = [one for one in footers if not is_number(one.kind(column))]
        if not odd:
            common[name] = column
            continue
        kind = odd[0].kind(column)
        what = "no column" if kind is None else f"{kind}s in"
        others = f", as {len(odd) - 1} others do" if len(odd) > 1 else ""
        partial[name] = (
            f"{odd[0].file} has {what} {column!r}{others}, which needs numbers in all "
            f"{len(footers)} files; the columns of that file are {odd[0].names}"
        )
    return common, partial


def groups_of(file: Any, opened: Any, time: str) -> Iterator[RowGroup]:
    """The row groups of one file, with their first and last times."""
    place = opened.schema_arrow.names.index(time)
    for number in range(opened.num_row_groups):
        meta = opened.metadata.row_group(number)
        if not meta.num_rows:
            continue
        known = meta.column(place).statistics if nothing_nested(opened) else None
        if known is None or not (known.has_min_max and known.has_null_count):
            column = opened.read_row_group(number, columns=[time]).column(time)
            times, nulls = pd.Series(column.to_numpy()), column.null_count
            first, last = times.min(), times.max()
        else:
            first, last, nulls = known.min, known.max, known.null_count
        if nulls < meta.num_rows:
            ends = in_utc(first), in_utc(last)
            yield RowGroup(file, number, meta.num_rows, *ends, nulls)


def times_of(group: Any, time: Any, filesystem: Any) -> Any:
    """
    The times of a row group as they are.

    Parameters
    ----------
    group : RowGroup
    time : str
        Column of the times.
    filesystem : pyarrow.fs.FileSystem or None
        None for local files.

    Returns
    -------
    array of datetime64, shape (rows,)
        In UTC where they have a zone; NaT where there is none.
    """
    with parquet_file(group.file, filesystem) as opened:
        column = opened.read_row_group(group.number, columns=[time]).column(time)
    return column.to_numpy()


def nothing_nested(opened: Any) -> bool:
    """Whether the columns stand in a file as they do in its schema."""
    return opened.metadata.num_columns == len(opened.schema_arrow.names)


def in_utc(time: datetime) -> pd.Timestamp:
    time = pd.Timestamp(time)
    return time if time.tz is None else time.tz_convert(None)


def in_order(groups: list) -> tuple:
    """
    Sort row groups by their times.

    Parameters
    ----------
    groups : list of RowGroup

    Returns
    -------
    tuple of RowGroup

    Raises
    ------
    ValueError
        If the times of two overlap; the message names the files.
    """
    groups = tuple(sorted(groups, key=lambda group: (group.first, group.last)))
    for one, other in itertools.pairwise(groups):
        if other.first > one.last:
            continue
        if one.file == other.file:
            raise ValueError(
                f"{one.file} is not sorted: rows from {other.first} on stand beside "
                f"others up to {one.last} (UTC, or as they are without a zone); sort "
                "it by time"
            )
        raise ValueError(
            f"{other.file} begins at {other.first}, where {one.file} goes on until "
            f"{one.last} (UTC, or as they are without a zone): keep one of the two, or "
            "each time once"
        )
    return groups


def is_number(kind: Any) -> bool:
    """Whether a type of pyarrow holds numbers."""
    numbers = ("int", "uint", "float", "double", "half", "bool", "decimal")
    return str(kind).startswith(numbers)
