"""How a file is written: as given, or by its first lines."""

import codecs
import csv
import itertools
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import pandas as pd

from pvlib_fem._record.labels import joined_labels, merged
from pvlib_fem._record.numbers import NUMBERS
from pvlib_fem._record.time_formats import ISO
from pvlib_fem._spelling import did_you_mean

EXCEL = (".xlsx", ".xlsm", ".xls", ".xlsb", ".ods")
PARQUET = (".parquet", ".pq")
SOME = 200_000  # characters that are looked at
LINES = 200
SEPARATORS = (",", ";", "\t", "|")
SPACES = " "  # one or more of them
SKIP_LINES = "skip_lines"  # option for the numbers of lines, else a form of skip_rows
COMMENT = "# "  # before the lines above a table of these
FOLLOWING = 5  # rows after the first that have to look like it
TIME = re.compile(r"\d{1,4}[-/.:]\d{1,2}([-/.:]\d{1,4})?[\d\sT:.,Z+-]*([aApP][mM])?")
#: what Windows writes in western and central Europe, Turkey, Japan and China
WINDOWS = ("cp1252", "cp1250", "cp1254", "cp932", "gbk")
CELL_ENDS = re.compile(r"[;,|\t\n\"]")
BOMS = {
    codecs.BOM_UTF8: "utf-8",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}


@dataclass(frozen=True)
class Layout:
    """How a file is written, see :func:`pvlib_fem.read_file`."""

    time: tuple[str, ...] = ()
    time_format: str = ISO
    tag: str = ""
    value: str = ""
    tz: str | None = None
    sep: str = ","
    decimal: str = "."
    thousands: str = ""
    encoding: str = "utf-8"
    skip_rows: int | tuple[int, ...] = 0
    header_rows: int = 1
    skip_end: int = 0
    sheet: str | int = 0
    missing: tuple[str, ...] = ()
    keep: tuple[str, ...] = ()
    sort: bool = False
    drop_doubled: bool = False
    drop_untimed: bool = False


def layout_of(given: Mapping[str, Any]) -> Layout:
    """
    A layout by its fields, or with the option of the command for the numbers of lines.

    Parameters
    ----------
    given : dict
        Fields of `Layout`; ``skip_lines``, a number or some, is ``skip_rows`` with
        the numbers of the lines to leave out.

    Returns
    -------
    Layout

    Raises
    ------
    TypeError
        If there is no such field.
    ValueError
        If ``skip_rows`` and ``skip_lines`` are both given.
    """
    names = [*(one.name for one in fields(Layout)), SKIP_LINES]
    if unknown := [name for name in given if name not in names]:
        raise TypeError(
            f"there is no argument {unknown[0]!r}{did_you_mean(unknown[0], names)}; "
            f"a file is read by {', '.join(names)}"
        )
    given = dict(given)
    if (lines := given.pop(SKIP_LINES, None)) is not None:
        if "skip_rows" in given:
            raise ValueError(
                "skip_rows and skip_lines are both given; give one of them, where "
                "skip_lines=[0, 1] is the same as skip_rows=2"
            )
        given["skip_rows"] = (lines,) if isinstance(lines, int) else tuple(lines)
    return Layout(**given)


def found_layout(
    file: Path, layout: Any = None, known: Callable[[str], str | None] = lambda _: None
) -> tuple[Layout, dict]:
    """
    How a file seems to be written.

    Parameters
    ----------
    file : Path
    layout : Layout, optional
        What is known, in the fields that are not looked for.
    known : callable, optional
        The package's name of a cell, or None, by which encodings are compared.

    Returns
    -------
    Layout, dict
        Separator, decimal sign, encoding, lines to leave out and sheet; and the units
        that a line below the header gives, by column.
    """
    layout = layout or Layout()
    if file.suffix.lower() in PARQUET:
        return layout, {}
    if file.suffix.lower() in EXCEL:
        sheets = pd.read_excel(file, sheet_name=None, header=None, nrows=LINES)
        name, rows = max(
            ((name, text_rows(sheet)) for name, sheet in sheets.items()),
            key=lambda sheet: likeness(sheet[1], "."),
        )
        header, units = header_lines(rows, ".")
        first = name == next(iter(sheets))
        return replace(layout, sheet=0 if first else name, **header), units
    encoding = encoding_of(file, layout.encoding, known)
    with open(file, encoding=encoding, newline="", errors="replace") as opened:
        lines = opened.read(SOME).removeprefix("\ufeff").splitlines()[:LINES]
    ways = [
        (likeness(rows, decimal), sep, decimal, rows)
        for sep in SEPARATORS
        for rows in [list(csv.reader(lines, delimiter=sep))]
        for decimal in NUMBERS
        if sep != decimal or '"' in "".join(lines)
    ]
    if not any(like for like, *_ in ways):  # columns that spaces hold apart
        rows = [line.lstrip(COMMENT).split() for line in lines]
        ways = [(likeness(rows, sign), SPACES, sign, rows) for sign in NUMBERS]
    _, sep, decimal, rows = max(ways, key=lambda way: way[0])
    header, units = header_lines(rows, decimal)
    how = dict(sep=sep, decimal=decimal, encoding=encoding)
    return replace(layout, **how, **header), units


def encoding_of(file: Path, given: str, known: Callable[[str], str | None]) -> str:
    """
    What the bytes can be: UTF-8 or UTF-16, else as given or as Windows writes.

    Of what Windows writes in different countries, that in which most names are known.
    """
    with open(file, "rb") as opened:
        start = opened.read(SOME)
    for mark, name in BOMS.items():
        if start.startswith(mark):
            return name
    utf = Layout.encoding  # signs that are not of ASCII are by chance never that
    for name in (given, utf) if start.isascii() else (utf, given):
        try:
            codecs.getincrementaldecoder(name)().decode(start)
        except (UnicodeDecodeError, LookupError):
            continue
        return name

    def names(encoding: str) -> int:
        cells = {*CELL_ENDS.split(start.decode(encoding, errors="replace"))}
        words = (cell for cell in cells if any(map(str.isalpha, cell)))
        return sum(known(word) is not None for word in words)

    return max(WINDOWS, key=names)


def text_rows(sheet: pd.DataFrame) -> list[list[str]]:
    """Rows of a sheet as text."""
    text = sheet.astype(object).where(sheet.notna(), "")
    return [[str(cell) for cell in row] for row in text.to_numpy()]


def is_number_cell(cell: str, decimal: str) -> bool:
    return NUMBERS[decimal].fullmatch(cell.strip()) is not None


def is_logger_cell(cell: str, decimal: str) -> bool:
    """Whether a cell is what a logger's row is made of."""
    if any(is_number_cell(cell, sign) for sign in NUMBERS):  # 13.5 is no time, either
        return is_number_cell(cell, decimal)
    return TIME.fullmatch(cell.strip()) is not None


def is_data(row: list, width: int, decimal: str) -> bool:
    """Whether a row has a logger's values."""
    filled = [cell for cell in row if cell.strip()]
    seen = sum(is_logger_cell(cell, decimal) for cell in filled)
    return len(row) == width and seen >= 2 and seen >= 0.5 * len(filled)


def width_of(rows: list) -> int:
    """Number of columns that the later rows have."""
    later = [len(row) for row in rows[len(rows) // 2 :]]
    return max(set(later), key=later.count) if later else 0


def likeness(rows: list, decimal: str) -> float:
    """How much rows look like a table: its cells that have a meaning."""
    width = width_of(rows)
    if width < 2:
        return 0.0
    later = [row for row in rows[len(rows) // 2 :] if len(row) == width]
    filled = [cell for row in later for cell in row if cell.strip()]
    return (
        sum(is_logger_cell(cell, decimal) for cell in filled)
        / max(len(filled), 1)
        * len(later)
    )


def header_lines(rows: list, decimal: str) -> tuple[dict, dict]:
    """The header and lines to leave out, and the units that one of these gives."""
    width = width_of(rows)
    data = [is_data(row, width, decimal) for row in rows]
    first = next(
        (
            i
            for i in range(len(rows))
            if data[i]
            and sum(data[i : i + FOLLOWING]) >= 0.8 * len(data[i : i + FOLLOWING])
        ),
        None,
    )
    if not first:  # no table, or no header
        return {}, {}
    above = [i for i in range(first) if len(rows[i]) == width]
    if not above:
        return {}, {}
    header = header_of(rows, above)
    skipped = tuple(i for i in range(first) if i not in header)
    units = below_header(rows[:first], header)
    skip = header[0] if skipped == tuple(range(header[0])) else skipped
    return dict(skip_rows=skip, header_rows=len(header)), units


def below_header(rows: list, header: list[int]) -> dict[str, str]:
    """The cells of the line below the header, by the column of the header."""
    names = joined_labels(merged([rows[i] for i in header]))
    below = [row for row in rows[header[-1] + 1 :] if len(row) == len(names)]
    cells = zip(names, below[0]) if below else ()
    return {column: cell.strip() for column, cell in cells if cell.strip()}


def left_out_units(file: Path, layout: Layout) -> dict[str, str]:
    """
    Cells of the line below the header, where the layout leaves that line out.

    Parameters
    ----------
    file : Path
    layout : Layout
        With the lines to leave out by their numbers.

    Returns
    -------
    dict of str
        By column: the units of a TOA5 file, or whatever stands there.
    """
    skipped, suffix = layout.skip_rows, file.suffix.lower()
    if isinstance(skipped, int) or not skipped or suffix in PARQUET:
        return {}
    many = min(max(skipped) + 1, LINES)
    if suffix in EXCEL:
        first = pd.read_excel(file, sheet_name=layout.sheet, header=None, nrows=many)
        rows = text_rows(first)
    else:
        with open(file, encoding=layout.encoding, errors="replace") as opened:
            lines = [line.strip("\r\n") for line in itertools.islice(opened, many)]
        lines[0] = lines[0].removeprefix("\ufeff")
        rows = [*csv.reader(lines, delimiter=layout.sep, skipinitialspace=True)]
        if layout.sep == SPACES:
            rows = [line.lstrip(COMMENT).split() for line in lines]
    kept = [i for i in range(len(rows)) if i not in skipped and any(rows[i])]
    header, data = kept[: layout.header_rows], kept[layout.header_rows :]
    if len(header) < layout.header_rows:
        return {}
    return below_header(rows[: (data or [many])[0]], header)


def header_of(rows: list, above: list) -> list[int]:
    """
    Lines that make the header: one whose names differ, or some that do so joined.

    Parameters
    ----------
    rows : list of list of str
    above : list of int
        Lines above the data that have a cell for each column.
    """
    best = max(above, key=lambda i: (len({c for c in rows[i] if c.strip()}), -i))
    place = above.index(best)
    upward = [above[start : place + 1] for start in range(place, -1, -1)]
    for lines in (*upward, above[place : place + 2]):
        names = joined_labels(merged([rows[i] for i in lines]))
        if len({*names}) == len(names):
            return lines
    return [best]
