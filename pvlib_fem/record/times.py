"""The times of a file: of one column or of two, in a zone, in their order."""

import datetime
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

import numpy as np
import pandas as pd

ISO = "ISO8601"


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
    column = columns.iloc[:, 0] if columns.shape[1] == 1 else joined(columns)
    if pd.api.types.is_numeric_dtype(column):
        raise ValueError(
            f"column {name} should hold the times and holds numbers; name the right "
            "one with --time COLUMN"
        )
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
        raise ValueError(
            f"column {name}{several} holds no time of the format {time_format} in row "
            f"{row}: {column.iloc[row]!r}; give --time-format, such as "
            "'%d/%m/%Y %H:%M', or name the column of times with --time COLUMN"
        )
    return pd.DatetimeIndex(parsed, name="time")


def joined(columns):
    """Text of a date and a time of day, which a table may hold as such."""
    text = [column.map(as_text) for _, column in columns.items()]
    return text[0].str.cat(text[1:], sep=" ")


def as_text(value):
    """A cell of a date or of a time as text; a date without its empty midnight."""
    if isinstance(value, datetime.datetime):
        bare = value.time() == datetime.time(0)
        return str(value.date()) if bare else value.isoformat(sep=" ")
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
