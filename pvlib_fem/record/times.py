"""The times of a file: of one column or of two, in a zone, in their order."""

import datetime
import numbers
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

import numpy as np
import pandas as pd

ISO = "ISO8601"
UNIX = "unix"  # seconds since 1970 in UTC
AFTER = 3  # lines that a table may have after its last row, such as totals


def timed(data, layout, name):
    """The table on its times."""
    time = list(layout.time)
    if isinstance(data.index, pd.DatetimeIndex) and time in ([], [data.index.name]):
        data = data.rename_axis("time")
    else:
        time = time or [data.columns[0]]
        if absent := [column for column in time if column not in data]:
            raise ValueError(
                f"{name} has no column {', '.join(absent)} for the times; it has "
                f"{', '.join(map(str, data.columns))}"
            )
        index = times(data[time], layout.time_format)
        data = data.drop(columns=time).set_index(index)
    if layout.tz is not None:
        data.index = zoned(data.index, layout.tz)
    return data


def times(columns, time_format=ISO):
    """
    Times of a column, or of a date and a time of day; the first bad one is named.

    Parameters
    ----------
    columns : DataFrame
        One column, or two that make the time when a space joins them.
    time_format : str

    Returns
    -------
    DatetimeIndex
    """
    name = " and ".join(f"{name!r}" for name in columns)
    column = joined(columns)
    if pd.api.types.is_numeric_dtype(column):
        if time_format == UNIX:
            return pd.DatetimeIndex(
                pd.to_datetime(column, unit="s", utc=True), name="time"
            )
        if time_format == ISO:
            raise ValueError(
                f"column {name} should hold the times and holds numbers; name the "
                "right one with --time COLUMN, or give --time-format unix for seconds "
                "since 1970 in UTC, %Y%m%d%H%M for such as 202406012130"
            )
        column = column.map(as_text)
    how = {"format": time_format, "errors": "coerce"}
    try:
        parsed = pd.to_datetime(column, **how)
        mixed = parsed.dtype == object  # as older pandas says it
    except ValueError:
        mixed = True
    if mixed:  # offsets that change, as with daylight saving time
        parsed = pd.to_datetime(column, utc=True, **how)
    if parsed.isna().any():
        row = int(parsed.isna().to_numpy().argmax())
        several = " (joined by a space)" if columns.shape[1] > 1 else ""
        after = len(parsed) - row
        if row and after <= AFTER and parsed[row:].isna().all():
            last = f"the last {after} rows are" if after > 1 else "the last row is"
            raise ValueError(
                f"column {name}{several} holds no time in row {row}: "
                f"{column.iloc[row]!r}; give --skip-end {after} if {last} no "
                "measurement, such as a total"
            )
        raise ValueError(
            f"column {name}{several} holds no time of the format {time_format} in row "
            f"{row}: {column.iloc[row]!r}; give --time-format, such as "
            "'%d/%m/%Y %H:%M', or name the column of times with --time COLUMN"
        )
    return pd.DatetimeIndex(parsed, name="time")


def joined(columns):
    """A column as it is, or the text of a date and a time of day."""
    first, *others = (column for _, column in columns.items())
    if not others:
        return first
    text = [column.map(as_text).str.zfill(4) for column in others]  # 930 is 09:30
    return first.map(as_text).str.cat(text, sep=" ")


def as_text(value):
    """A cell of a date or of a time as text; a date without its empty midnight."""
    if isinstance(value, datetime.datetime):
        bare = value.time() == datetime.time(0)
        return str(value.date()) if bare else value.isoformat(sep=" ")
    if isinstance(value, numbers.Real) and value == value and value == int(value):
        return str(int(value))
    return str(value).strip()


def zoned(index, tz):
    """Times in a zone: naive ones are taken as local in it."""
    try:
        ZoneInfo(tz)
    except (ZoneInfoNotFoundError, ValueError, OSError) as error:
        raise ValueError(
            f"--tz {tz}: there is no such zone; zones are called such as "
            "Europe/Brussels, or Etc/GMT-1 for one hour east of Greenwich"
        ) from error
    if index.tz is not None:
        return index.tz_convert(tz)
    try:
        # the hour that an autumn has twice is told by the order of its rows
        return index.tz_localize(tz, ambiguous="infer")
    except Exception as error:  # of pandas' own, or of the zones' library
        at = in_no_zone(index, tz)
        skipped = (
            f"{at} does not exist there, since the clock skips that hour in spring"
            if at is not None
            else "the hour that comes twice in autumn is in the file once only"
        )
        raise ValueError(
            f"--tz {tz}: {skipped}; loggers mostly keep standard time, for example "
            "--tz Etc/GMT-1 for one hour east of Greenwich"
        ) from error


def in_no_zone(index, tz):
    """The first time that a clock in a zone never shows, if there is one."""
    first = np.ones(len(index), dtype=bool)
    there = index.tz_localize(tz, ambiguous=first, nonexistent="NaT")
    return index[there.isna()][0] if there.hasnans else None


def in_order(data, sort=False, drop_doubled=False):
    """Rows in the order of their times, each time once, where that is asked for."""
    notes = []
    if sort and not data.index.is_monotonic_increasing:
        moved = int((np.diff(data.index.asi8) < 0).sum())
        data = data.sort_index(kind="stable")
        notes.append(f"rows sorted by time: it went back {moved:,} times")
    if drop_doubled and data.index.has_duplicates:
        twice = data.index.duplicated()
        data = data[~twice]
        notes.append(f"rows whose time was there already, left out: {twice.sum():,}")
    return data, notes
