"""What was done to the data before any fit, with the number of rows."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from pvlib_fem._findings import Correction
from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem._record.file_summary import Summary

if TYPE_CHECKING:
    from pvlib_fem._loop.results.loop_result import Loop

#: step, column, number of rows, and what was done
Treatment = tuple[str, str, int | None, str]


def treatment(loop: "Loop") -> list[Treatment]:
    """
    Steps from the data as they were given to the rows that count.

    Parameters
    ----------
    loop : Loop

    Returns
    -------
    list of (str, str, int or None, str)
        Step, column, number of rows (None where it is unknown), and what was done.
    """
    return [
        *given_rows(loop),
        *clock_treatment(loop),
        *columns_made(loop),
        *detached_rows(loop),
        *screened_values(loop.fit.summary),
        *kept_rows(loop),
    ]


def given_rows(loop: "Loop") -> Iterator[Treatment]:
    """Rows as they were given, and what was done as they were read."""
    if rows := loop.reading.get("rows"):
        yield "given", "all", rows, "rows of the data"
    for note in loop.reading.get("notes", ()):
        yield "reading", "", None, note


def clock_treatment(loop: "Loop") -> Iterator[Treatment]:
    """Clocks that were corrected, or not, and rows whose time is unknown."""
    for one in loop.corrections:
        columns = ", ".join(one.columns)
        words = one.why if one.applied else f"not corrected: {one.why}"
        what = "place" if one.of_place else "clock"
        yield what, columns, shifted_rows(loop, one) if one.applied else 0, words
    rows = loop.reading.get("rows")
    if rows and (lost := rows - loop.fit.summary.rows):
        yield "clock", "all", lost, "left out, since their time is unknown"


def shifted_rows(loop: "Loop", correction: Correction) -> int | None:
    """Rows that a correction of a clock moves; None without the rows."""
    record, times = loop.fit.record, loop.times
    if record is None or times is None:
        return None
    if correction.columns != ("all",):
        late = times.module.late_at(record.inputs.seconds)
        return int(np.count_nonzero(late[np.isfinite(record["temp_module"])]))
    index = record.index.tz_localize(None)
    added = np.zeros(len(index))
    for time, seconds in times.offsets:
        begin = np.datetime64(time) + np.timedelta64(int(seconds), "s")
        added[index >= begin] = seconds
    return int(np.count_nonzero(added))


def columns_made(loop: "Loop") -> Iterator[Treatment]:
    """Columns that were made from others, or filled from them."""
    rows = loop.fit.summary.rows
    if loop.transposition:
        there = rows - loop.fit.summary.missing.get("poa_global", 0)
        words = f"transposed from ghi by the model {loop.transposition}"
        yield "made", "poa_global", there, words
    for one in loop.stand_ins:
        words = f"filled where it is missing by {one.factor:.3g} × {one.column}"
        words += f" {one.offset:+.2f} K" if one.offset else ""
        yield "filled", one.usual, None, words


def detached_rows(loop: "Loop") -> Iterator[Treatment]:
    """Rows in which the module's temperature sensor had come off."""
    for one in loop.detachments:
        yield "sensor", "temp_module", one.rows, f"the sensor is off {one.when}"


def screened_values(record: Summary) -> Iterator[Treatment]:
    """
    Values that are missing, impossible or set to zero, by column of a summary.

    Parameters
    ----------
    record : Summary
        Summary of the rows.

    Yields
    ------
    (str, str, int, str)
        Step, column, number of rows, and what was done.
    """
    for name, count in record.missing.items():
        impossible = record.impossible.get(name, 0)
        if impossible:
            yield "screening", name, impossible, "impossible, not used"
        if count:
            yield "screening", name, count, "missing"
    if record.clipped:
        yield "screening", "poa_global", record.clipped, "below zero, set to 0"


def kept_rows(loop: "Loop") -> Iterator[Treatment]:
    """Rows that are left, by their use."""
    residual = loop.fit.residual
    if residual is not None:
        unknown = int(residual.isna().sum())
        if unknown:
            columns = ", ".join(n for n in COLUMNS if n in loop.fit.summary.columns)
            words = "without a residual: a value is missing or is not used"
            yield "rows", columns, unknown, words
    for name, rows in loop.week_rows.items():
        yield "rows", "all", rows, f"in {name} weeks"
