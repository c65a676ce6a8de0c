"""A logger's file, or several, as a frame in the package's names."""

import io
import re
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import pandas as pd

from pvlib_fem._record.checks import usual_step
from pvlib_fem._record.column_names import STATED, renamed
from pvlib_fem._record.file_times import in_order, with_time_index
from pvlib_fem._record.header_units import (
    QUANTITIES,
    converted_column,
    own_unit,
    stated_columns,
    stated_unit,
    unit_of,
    usual_name_of,
)
from pvlib_fem._record.joining import joined_tables, stacked_tables
from pvlib_fem._record.kept_rows import refuse_unknown, ungraded, with_good_rows
from pvlib_fem._record.labels import flat_header, with_flat_labels
from pvlib_fem._record.layout import (
    COMMENT,
    EXCEL,
    PARQUET,
    SPACES,
    TIME,
    Layout,
    layout_of,
    left_out_units,
)
from pvlib_fem._record.long_tables import wide_table
from pvlib_fem._record.numbers import refuse_text, ungrouped, unmarked
from pvlib_fem._spelling import UNCHECKED, ShellText, did_you_mean, refusal
from pvlib_fem.types import FilePath

#: what pandas says of a line with too many columns
LONG_LINE = re.compile(r"Expected (\d+) fields in line (\d+), saw (\d+)")
MOST_SWELLING = 200  # times its size, to which a packed record unpacks
MOST_CELLS = 200_000_000  # of a sheet: each takes some 50 bytes while it is read

MISSING = ("NAN",)  # as TOA5 writes it, in addition to what pandas knows


def read_file(
    file: FilePath | Sequence[FilePath],
    columns: Mapping[str, str] | None = None,
    convert_units: bool | Mapping[str, str] = False,
    check_units: bool = True,
    module_area: float | None = None,
    **layout: Any,
) -> pd.DataFrame:
    """
    A logger's file as a frame with a DatetimeIndex and the package's names.

    Parameters
    ----------
    file : str, path-like or list of these
        CSV, Excel (``pip install 'pvlib_fem[excel]'``) or Parquet. Several are joined
        on the times of the one with the longest step: a row gets of another file the
        nearest row, and of one with far shorter steps the means over the step that
        ends there, but module temperatures and angles of the plane as they are then.
    columns : dict, optional
        Package's name to the file's, as ``{"poa_global": "Irr (W/m2)"}``. Other
        columns keep their names.
    convert_units : bool or dict, default False
        Convert columns whose headers name another unit, such as ``Wind (mph)``; or
        the units by the package's names, as ``{"wind_speed": "mph"}``.
    check_units : bool, default True
        Refuse a column whose header names another unit, where it is not converted.
    module_area : float, optional
        Area of the modules whose power is in W, kW or MW. [m²]
    **layout
        ``time``: column of the times, or those of their parts, such as a date and a
        time of day; by default the first. ``time_format``, default ISO 8601; ``unix``,
        ``unix-ms``, ``excel`` and ``matlab`` are counts. ``tag``, ``value``: columns of
        a table with a row for each reading, of which each tag becomes a column. ``tz``:
        the zone of naive times, in which those that its clock skips are left out, or
        that into which others are brought. ``sep``, ``decimal``, ``encoding`` of CSV.
        ``thousands``: what stands between the thousands of numbers. ``skip_rows``: how
        many lines stand before the header; ``skip_lines``: the numbers of the lines to
        leave out, from 0, which ``skip_rows`` takes as a list, too; ``header_rows``:
        how many lines the header has, whose labels are joined, as ``met_RH``;
        ``skip_end``: how many lines stand after the last row, such as totals. ``sheet``
        of a workbook. ``missing``: texts that stand for a missing value. ``keep``:
        texts such as ``"Quality=Good"``, of which a row has to have one in that column;
        others are left out and counted. ``sort``: put the rows in the order of their
        times. ``drop_doubled``: of rows with the same time keep the first.
        ``drop_untimed``: leave out rows that hold no time, such as a header in the
        middle of a file.

    Returns
    -------
    DataFrame
        What was done in addition to reading is in ``.attrs["notes"]``, the unit that
        each column was converted from in ``.attrs["converted"]``, and the columns whose
        unit a header or ``convert_units`` states in ``.attrs["stated"]``.

    Raises
    ------
    ValueError
        If the file, its times, a column or a unit are not as said; the message names
        the option of the command ``pvlib-fem`` that helps, which is the keyword here.
    TypeError
        If a keyword is none of these.
    """
    given = [file] if isinstance(file, str | PathLike) else file
    files = [Path(one) for one in given]
    for name in ("time", "missing", "keep"):
        if isinstance(layout.get(name), str):
            layout[name] = (layout[name],)
        elif name in layout:
            layout[name] = tuple(layout[name])
    how = [layout_of(layout)] * len(files)
    units = {} if isinstance(convert_units, bool) else convert_units
    convert = convert_units is True
    return frame(files, how, columns or {}, convert, units, check_units, module_area)


def frame(
    files: Sequence,
    layouts: list,
    columns: Mapping,
    convert: bool = False,
    units: Mapping | None = None,
    check_units: bool = True,
    module_area: float | None = None,
) -> pd.DataFrame:
    """
    Read files as one table in the package's names and units.

    Parameters
    ----------
    files : sequence of Path, or of lists of Path
        A list holds pieces of one logger, which follow each other in time; entries are
        joined on common times.
    layouts : list of Layout
        One for each entry of ``files``.
    columns : dict of str
        Package's name to the file's.
    convert : bool, default False
        Convert columns whose headers name another unit.
    units : dict of str, optional
        Package's name to the unit from which a column is converted.
    check_units : bool, default True
        Refuse a column whose header names another unit, where it is not converted.
    module_area : float, optional
        Area of the modules whose power is in W, kW or MW. [m²]

    Returns
    -------
    DataFrame
        With a DatetimeIndex; ``.attrs`` has ``"notes"``, a sentence each,
        ``"converted"``, the former unit by column, and ``"stated"``, the columns whose
        unit a header or ``units`` states.

    Raises
    ------
    ValueError
        If a file, its times, a column or a unit are not as stated.
    """
    tables, names, notes, headers, lines = [], [], [], [], []
    for file, layout in zip(files, layouts):
        pieces = file if isinstance(file, list) else [file]
        read = []
        for one in pieces:
            data = plain_table(one, layout)
            headers.append(data.columns)
            data = with_good_rows(
                data, layout.keep, marked := [*ungraded(data, layout)]
            )
            data, lost = with_time_index(by_tag(data, layout), layout, one.name)
            read.append(data)
            notes += [f"{one.name}: {note}" for note in marked + lost]
        data, name = stacked_tables(read, [one.name for one in pieces], layout.sort)
        data, done = in_order(data, layout.sort, layout.drop_doubled)
        tables.append(data)
        names.append(name)
        lines.append({} if layout.tag else left_out_units(pieces[0], layout))
        notes += [f"{name}: {note}" for note in done]
    for layout in layouts:
        refuse_unknown(layout.keep, headers)
    data, done = joined_tables(tables, names, columns)
    # amounts of a step are of that of their own file
    spans = [(usual_step(table.index) / 3600.0, table) for table in tables]
    hours = dict(zip(data, (span for span, table in spans for _ in table)))
    cells = [units.get(str(c)) for table, units in zip(tables, lines) for c in table]
    below = {str(column): cell for column, cell in zip(data, cells) if cell}
    absent = [column for column in columns.values() if column not in data]
    if absent:
        raise ValueError(
            f"{' and '.join(names)} has no column "
            f"{', '.join(absent)}{did_you_mean(absent, data.columns)}; it has "
            f"{', '.join(map(str, data.columns))}"
        )
    columns = columns | renamed({*data, *columns} - {*columns.values()})
    headers = {name: name for name in data.columns} | columns
    data = with_mapped_names(data, columns)
    for name in QUANTITIES:
        if name in data:
            refuse_text(data[name], name)
    data, file_units = in_units(
        data, headers, convert, units or {}, check_units, module_area, hours, below
    )
    done += [f"{n} converted from {u} to {own_unit(n)}" for n, u in file_units.items()]
    stated = sorted({*stated_columns(headers, below), *(units or {}), *file_units})
    data.attrs |= {"notes": notes + done, "converted": file_units, STATED: stated}
    return data


def file_table(file: Path, layout: Layout) -> pd.DataFrame:
    """
    A file's columns; of a table with a row for each reading those of its tags.

    Parameters
    ----------
    file : Path
    layout : Layout

    Returns
    -------
    DataFrame
        The times are still columns, or the index of a Parquet file.

    Raises
    ------
    ValueError
        If the file cannot be read so, or its tags make no columns.
    """
    return by_tag(with_good_rows(plain_table(file, layout), layout.keep, []), layout)


def by_tag(data: pd.DataFrame, layout: Layout) -> pd.DataFrame:
    """A table as it is, or with a column for each tag."""
    if not layout.tag:
        return data
    return wide_table(data, layout.tag, layout.value or "value", layout.time)


def plain_table(file: Any, layout: Any) -> pd.DataFrame:
    """A file's columns as they are."""
    suffix = file.suffix.lower()
    if suffix == ".gz":
        refuse_swelling(file)
    if suffix in PARQUET:
        try:
            return without_codes(with_flat_labels(pd.read_parquet(file)))
        except ImportError as error:
            raise ValueError(
                "reading Parquet needs pyarrow: pip install 'pvlib_fem[parquet]'"
            ) from error
    missing = [*MISSING, *layout.missing]
    skip = layout.skip_rows
    skip = skip if isinstance(skip, int) else list(skip)
    how = {"skiprows": skip, "na_values": missing}
    if layout.header_rows > 1:
        how["header"] = list(range(layout.header_rows))
    if suffix in EXCEL:
        end = layout.skip_end
        data = workbook(file, sheet_name=layout.sheet, skipfooter=end, **how)
    else:
        data = csv_table(file, layout, **how)
    times = layout.time or tuple(data.columns[:1])
    marked = [name for name in texts(data) if name not in times]
    if marked and layout.missing:
        marks = layout.missing, layout.decimal
        data = data.assign(**{name: unmarked(data[name], *marks) for name in marked})
    if not layout.thousands and layout.decimal == ".":
        return data
    signs = layout.thousands, layout.decimal
    return data.assign(**{name: ungrouped(data[name], *signs) for name in marked})


def without_codes(data: pd.DataFrame) -> pd.DataFrame:
    """The table with texts and numbers where a Parquet file has codes for them."""
    coded = data.select_dtypes("category").astype(object).infer_objects()
    return data.assign(**{str(name): column for name, column in coded.items()})


def refuse_swelling(file: Any) -> None:
    """Refuse a packed file of which little on disk takes all memory, before it does."""
    with open(file, "rb") as packed:
        size = packed.seek(0, io.SEEK_END)
        packed.seek(max(size - 4, 0))
        content = int.from_bytes(packed.read(4), "little")  # as gzip says it
    if content > MOST_SWELLING * size:
        raise ValueError(
            f"{file.name} has {size:,} bytes and unpacks to {content:,}, as no "
            "measured record does; if it is one, unpack it first"
        )


def refuse_wide(file: Path) -> None:
    """Refuse a workbook whose cells reach so far that no memory holds them."""
    import openpyxl

    book = openpyxl.load_workbook(file, read_only=True)
    try:
        reach = [(s.title, s.max_row or 0, s.max_column or 0) for s in book.worksheets]
    finally:
        book.close()
    for name, rows, columns in reach:
        if rows * columns > MOST_CELLS:
            raise TooLarge(
                f"sheet {name!r} of {file.name} reaches to row {rows:,} and column "
                f"{columns:,}; delete the cells beyond the table, or save it as CSV"
            )


class TooLarge(ValueError):
    """A file that would take all memory."""


def texts(data: pd.DataFrame) -> list[str]:
    """
    Names of the columns of text.

    Parameters
    ----------
    data : DataFrame

    Returns
    -------
    list of str
    """
    kinds = pd.api.types
    return [
        name
        for name, column in data.items()
        if kinds.is_object_dtype(column) or kinds.is_string_dtype(column)
    ]


def workbook(file: Any, **how: Any) -> pd.DataFrame:
    try:
        if file.suffix.lower() in (".xlsx", ".xlsm"):
            refuse_wide(file)
        data = pd.read_excel(file, **how)
    except TooLarge:
        raise
    except ImportError as error:
        raise ValueError(
            f"reading {file.suffix} needs another package ({error.name or error}): "
            "pip install 'pvlib_fem[excel]' reads .xlsx; save others as that"
        ) from error
    except (ValueError, KeyError, OSError) as error:
        if "Worksheet" in str(error):
            raise ValueError(f"{file.name}: {error}; give --sheet NAME") from error
        raise ValueError(f"{file.name} is no workbook that can be read") from error
    except Exception as error:  # of the package that reads it: a broken archive
        raise ValueError(f"{file.name} is no workbook that can be read") from error
    return flat_header(data).dropna(axis="columns", how="all")


def csv_table(file: Path, layout: Any, **how: Any) -> pd.DataFrame:
    """A CSV file; what makes it no table says which option may."""
    if len(layout.decimal) != 1 or not layout.decimal.isascii():
        raise ValueError(
            f"--decimal {layout.decimal!r}: the decimal sign of {file.name} has to be "
            "one sign of ASCII; the usual ones are '.' and ','"
        )
    how |= {"sep": layout.sep, "decimal": layout.decimal, "encoding": layout.encoding}
    how |= {"skipinitialspace": True, "low_memory": False}
    try:
        source = without_end(file, layout) if layout.skip_end else file
        if layout.sep == SPACES:
            source, how["sep"] = without_comments(source, layout.encoding), r"\s+"
        data = flat_header(pd.read_csv(source, **how))
    except UnicodeDecodeError as error:
        raise ValueError(
            f"{file.name} is not in {layout.encoding} ({error.reason} at byte "
            f"{error.start}); give --encoding, such as latin-1, or cp932 for Japanese"
        ) from error
    except LookupError as error:
        raise ValueError(
            f"--encoding {layout.encoding}: there is no such encoding; usual ones are "
            "utf-8, latin-1 and utf-16"
        ) from error
    except pd.errors.EmptyDataError as error:
        raise ValueError(
            f"{file.name} has no line left after those that --skip-rows leaves out"
            if layout.skip_rows
            else f"{file.name} is empty"
        ) from error
    except pd.errors.ParserError as error:
        odd = LONG_LINE.search(str(error))
        which, leave = "its lines differ in their number of columns", ""
        if odd and layout.sep != SPACES:  # lines are counted with their comments
            before, line, found = map(int, odd.groups())
            which = f"line {line} has {found} columns, and those before it {before}"
            if before > 1 and not layout.skip_rows:  # else the header comes later
                leave = f"--skip-lines {line - 1} to leave it out, "
        raise ValueError(
            f"{file.name} is no table with the separator {layout.sep!r}: {which}; give "
            f"{leave}--skip-rows for lines before the header, or --sep"
        ) from error
    if data.shape[1] == 1:
        raise ValueError(
            f"{file.name} has the one column {data.columns[0]!r}; give --sep, such as "
            "';', and --skip-rows for lines before the header"
        )
    if len(data) == 0:
        raise ValueError(f"{file.name} has a header and no row")
    refuse_row(data, file)
    return data


def refuse_row(data: pd.DataFrame, file: Path) -> None:
    """Refuse a file that begins with a row where names should be."""
    first, *others = data.columns
    numbers = [pd.to_numeric(re.sub(r"\.\d+$", "", c), errors="coerce") for c in others]
    if TIME.fullmatch(first) and pd.notna(numbers).mean() > 0.5:
        raise ValueError(
            f"{file.name} has no header: it begins with {first!r}, {others[0]!r}; "
            "write a line of names above it, such as time,poa_global,temp_air,"
            "wind_speed,temp_module"
        )


def without_end(file: Any, layout: Layout) -> io.StringIO:
    """The text of a file without its last lines; empty ones do not count."""
    lines = file.read_text(layout.encoding).rstrip().split("\n")
    return io.StringIO("\n".join(lines[: -layout.skip_end]))


def without_comments(source: Any, encoding: Any) -> io.StringIO:
    """The text of a file without the signs before the lines above its table."""
    if isinstance(source, Path):
        source = io.StringIO(source.read_text(encoding))
    return io.StringIO("".join(line.lstrip(COMMENT) for line in source))


def with_mapped_names(data: pd.DataFrame, columns: dict) -> pd.DataFrame:
    """The table in the package's names."""
    # a mapped column takes the name, whatever else the file calls by it, and leaves
    # its own, under which it would be one more driver
    taken = {name: data[column] for name, column in columns.items()}
    return data.drop(columns=list(dict.fromkeys(columns.values()))).assign(**taken)


def in_units(
    data: pd.DataFrame,
    headers: dict,
    convert: bool,
    units: Mapping,
    check_units: bool,
    module_area: float | None,
    hours: dict,
    below: Mapping,
) -> tuple[pd.DataFrame, dict]:
    """Columns in the package's units, if that is requested, and their own units."""
    requested = {name: unit_of(name, unit) for name, unit in units.items()}
    if absent := [name for name in requested if name not in data]:
        raise ValueError(
            f"there is no column {absent[0]} to convert"
            f"{did_you_mean(absent[0], data.columns)}; name it with --map "
            f"{absent[0]}=COLUMN"
        )
    done = {}
    for name, header in headers.items():
        # of a second sensor with no name of its own, temp_module_f, the end is no unit
        second = name not in QUANTITIES and name not in requested and name == header
        cell = below.get(header, "")
        if usual_name_of(name) is None or (second and not cell):
            continue
        own = own_unit(name)
        unit = requested.get(name) or stated_unit(name, str(header), cell)
        if unit in (None, own):
            continue
        if name in requested or convert:
            given = data[name], name, unit, hours[header], module_area
            column = converted_column(*given)
            data = data.assign(**{name: column})
            done[name] = unit
        elif check_units:
            below_it = stated_unit(name, "", cell) == unit
            where = "line below the header" if below_it else "header"
            raise refusal(
                f"the {where} {header!r} names {unit}, and {name} has to be in {own}; "
                "give ",
                ShellText("convert_units=True (--convert)", "--convert"),
                " to convert it, or ",
                UNCHECKED,
                " if it is in that unit already",
            )
    return data, done
