"""Checks of what comes in: its times, their order, its numbers."""

import numbers
import re
from decimal import Decimal
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._spelling import ShellText, refusal

DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+")
SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
#: months of autumn on either side of the equator, and hours, in which it ends
SUMMER_TIME_ENDS = (3, 4, 9, 10, 11), (23, 0, 1, 2, 3)
LOCALIZED = ShellText(
    "data.tz_localize('Europe/Berlin', ambiguous='infer') (--tz Europe/Berlin)",
    "--tz Europe/Berlin",
)
KEEP_ONE = ShellText(
    "keep one, for example with data[~data.index.duplicated()]",
    "give --drop-doubled to keep the first",
)


def common_index(series: dict) -> Any:
    """
    The one index of several series.

    Parameters
    ----------
    series : dict of Series
        By the names of the message.

    Returns
    -------
    DatetimeIndex, other Index or None
        Index of the first series; None without any.

    Raises
    ------
    ValueError
        If a series is empty, or the indexes or their zones differ.
    """
    if not series:
        return None
    if empty := [name for name, one in series.items() if not len(one)]:
        raise ValueError(f"{empty[0]} is empty; give at least one row")
    (first, one), *others = series.items()
    for name, other in others:
        if other.index.equals(one.index):
            continue
        zones = [getattr(s.index, "tz", None) for s in (one, other)]
        if (zones[0] is None) != (zones[1] is None):
            raise ValueError(
                f"the times of {first} have zone {zones[0]}, those of {name} "
                f"{zones[1]}; give both a zone (tz_localize) or neither"
            )
        if zones[0] != zones[1] and len(other) == len(one):
            raise ValueError(
                f"the times of {first} are in {zones[0]}, those of {name} in "
                f"{zones[1]}; bring them to one zone, for example with "
                f"tz_convert({str(zones[0])!r})"
            )
        raise ValueError(
            f"{name} and {first} have different indexes: they part at "
            f"{first_difference(one.index, other.index)}; align them first, for "
            "example as columns of one DataFrame"
        )
    return one.index


def first_difference(one: pd.DatetimeIndex, other: pd.DatetimeIndex) -> pd.Timestamp:
    shared = min(len(one), len(other))
    unequal = np.flatnonzero(np.asarray(one[:shared] != other[:shared]))
    at = unequal[0] if len(unequal) else shared - 1
    return one[at]


def as_times(times: np.ndarray, rows: int) -> Any:
    """
    Times of arrays as an index.

    Parameters
    ----------
    times : DatetimeIndex or array, shape (rows,)
        Datetimes, or numbers. [s]
    rows : int

    Returns
    -------
    Index

    Raises
    ------
    ValueError
        If there are not as many times as rows.
    """
    times = pd.Index(times)
    if len(times) != rows:
        raise ValueError(f"times has {len(times)} entries for {rows} samples")
    return times


def plain_steps(
    index: pd.Index | None, rows: int, step: float | None, purpose: str, series: dict
) -> Any:
    """
    Steps of rows without datetimes: from ``step``, or from times as numbers.

    Parameters
    ----------
    index : Index or None
        Times as numbers [s] or timedeltas; None where arrays have none.
    rows : int
    step : float or None
        Even step; numbers in ``index`` count only without it. [s]
    purpose : str
        What needs the steps, for the message.
    series : dict of Series
        Columns that bring ``index``; without ``step`` they are refused, by the first.

    Returns
    -------
    index : Index
    steps : float or array, shape (rows,)
        Time since the row before, in ``unit``; an array has 0 in the first row.
    unit : float
        1. [s]

    Raises
    ------
    ValueError
        If there is no step and no time, the step is not positive and finite, or times
        are NaN or do not rise.
    """
    if step is not None:
        if not (is_number(step) and 0 < step < np.inf):
            raise ValueError(f"step = {step} must be a positive number of seconds")
        return (pd.RangeIndex(rows) if index is None else index), float(step), 1.0
    if index is None:
        raise ValueError(
            f"{purpose} needs the time step of arrays: give step in seconds, or "
            "Series with a DatetimeIndex"
        )
    if series:
        words = no_datetimes(next(iter(series)), index)
        raise ValueError(f"{words}, or give step in seconds")
    if isinstance(index, pd.TimedeltaIndex):
        index = index.total_seconds()
    seconds = as_numbers("times", index.to_numpy(), index)
    if np.isnan(seconds).any():
        at = int(np.argmax(np.isnan(seconds)))
        raise ValueError(f"times has no number (NaN) at row {at}; drop such rows")
    steps = np.diff(seconds, prepend=seconds[0])
    check_order(steps, index, "times")
    return index, steps, 1.0


def no_datetimes(name: str, index: Any) -> str:
    """
    Message for a Series whose index has no times, with the remedy.

    Parameters
    ----------
    name : str
        Of the Series.
    index : Index

    Returns
    -------
    str
    """
    remedy = "set one with pd.to_datetime"
    if isinstance(index, pd.TimedeltaIndex):
        remedy = "add the time of its start, as pd.Timestamp('2023-06-01') + index"
    return f"{name} has no DatetimeIndex but a {type(index).__name__}; {remedy}"


def datetime_steps(index: Any, name: str) -> Any:
    """
    Steps of a DatetimeIndex, as whole counts of its own resolution.

    Parameters
    ----------
    index : DatetimeIndex
        At least one time.
    name : str
        What holds the times, for messages.

    Returns
    -------
    steps : float or array of int, shape (rows,)
        Time since the row before, in ``unit``; one number where all are equal, and an
        array has 0 in the first row.
    unit : float
        Resolution of the index. [s]

    Raises
    ------
    ValueError
        If a time is NaT, or times do not rise.
    """
    if index.hasnans:
        raise ValueError(
            f"{name} has no time (NaT) at row {int(np.argmax(index.isna()))}; drop "
            "such rows"
        )
    unit = SECONDS[index.unit]
    tick = isinstance(index.freq, pd.offsets.Tick) and index.freq.n > 0
    # a day of the calendar, which pandas 2 has among its ticks, may have 23 h
    if tick and not isinstance(index.freq, pd.offsets.Day):
        return pd.Timedelta(index.freq) / pd.Timedelta(seconds=1) / unit, unit
    count = instants(index).view("i8")
    steps = np.empty(len(count), dtype="i8")
    steps[0] = 0
    np.subtract(count[1:], count[:-1], out=steps[1:])
    check_order(steps, index, name)
    if len(steps) > 1 and steps[1:].min() == steps[1:].max():
        return float(steps[1]), unit
    return steps, unit


def instants(index: Any) -> np.ndarray:
    """
    The times as numpy has them, in UTC where they have a zone.

    Parameters
    ----------
    index : DatetimeIndex

    Returns
    -------
    array of datetime64, shape (rows,)
        Naive times are unchanged.
    """
    return (index if index.tz is None else index.tz_convert(None)).to_numpy()


def dates_of(index: Any) -> np.ndarray:
    """
    Calendar day of each time in its own zone.

    Parameters
    ----------
    index : DatetimeIndex

    Returns
    -------
    array of int32, shape (rows,)
        Days since 1970-01-01.
    """
    offset = None if index.tz is None else index.tz.utcoffset(None)
    if offset is None:  # no zone, or one of several offsets
        local = index.tz_localize(None).to_numpy()
    else:
        local = instants(index) + np.timedelta64(offset)
    return local.astype("datetime64[D]").astype(np.int32)


def usual_step(index: Any) -> float:
    """
    Median time between neighbouring times.

    Parameters
    ----------
    index : DatetimeIndex

    Returns
    -------
    float
        NaN of fewer than two times. [s]
    """
    steps = np.diff(instants(index))
    if not len(steps):
        return np.nan
    even = (steps == steps[0]).all()  # as most are, which is soon seen
    steps = (steps[:1] if even else steps) / np.timedelta64(1, "s")
    return float(np.median(steps))


def check_order(steps: np.ndarray, index: pd.Index, name: str) -> None:
    """
    Refuse times that do not rise.

    Parameters
    ----------
    steps : array, shape (rows,)
        Time since the row before, in any unit; the first is not looked at.
    index : Index
        The times, for the message.
    name : str
        What holds the times.

    Raises
    ------
    ValueError
        If a time comes twice or after a later one; at the end of summer time the
        message names the zone as the remedy.
    """
    if len(steps) < 2 or steps[1:].min() > 0:
        return
    at = 1 + int(np.argmax(steps[1:] <= 0))
    if ends_summer_time(steps, index, at):
        raise refusal(
            f"{name} goes back from {index[at - 1]} to {index[at]} (row {at}), as the "
            "clock does at the end of summer time: leave the rows in their order, "
            "since sorting mixes the hour that comes twice, and give the times their "
            "zone, for example with ",
            LOCALIZED,
        )
    if steps[at] == 0:
        twice = f"{name} has the time {index[at]} twice (row {at}); "
        raise refusal(twice, KEEP_ONE)
    raise refusal(
        f"{name} is not sorted: {index[at]} (row {at}) comes after {index[at - 1]}; ",
        ShellText("use data.sort_index()", "give --sort"),
    )


def ends_summer_time(steps: np.ndarray, index: pd.Index, at: int) -> bool:
    """Whether times without a zone go back by an hour, but for a step, in autumn."""
    if not isinstance(index, pd.DatetimeIndex) or index.tz is not None:
        return False
    usual = np.median(steps[1:]) * SECONDS[index.unit]
    back = usual - (index[at] - index[at - 1]).total_seconds()
    months, hours = SUMMER_TIME_ENDS
    autumn = index[at].month in months and index[at].hour in hours
    return autumn and abs(back - 3600.0) < usual / 2


def as_numbers(name: str, value: Any, index: Any) -> np.ndarray:
    """
    A column in double precision.

    Parameters
    ----------
    name : str
        For the message.
    value : Series, array or number
        Numbers, of any type that numpy or pandas has; a masked value is NaN.
    index : Index or tuple
        Times of the rows, for the message; an empty one gives the number of the row.

    Returns
    -------
    array of float64, shape (rows,)
        A number has shape ().

    Raises
    ------
    ValueError
        If a value is infinite or no number, with its time.
    """
    return as_given(name, value, index).astype(float, copy=False)


def as_given(name: str, value: Any, index: pd.Index | tuple) -> np.ndarray:
    """
    A column of numbers, single precision kept.

    Parameters
    ----------
    name : str
        For the message.
    value : Series, array or number
        Numbers, of any type that numpy or pandas has; a masked value is NaN.
    index : Index or tuple
        Times of the rows, for the message; an empty one gives the number of the row.

    Returns
    -------
    array, shape (rows,)
        In float32 if it is given so, else in float64; a number has shape ().

    Raises
    ------
    ValueError
        If a value is infinite or no number, with its time.
    """
    if np.ma.isMaskedArray(value):
        value = np.ma.filled(value.astype(float), np.nan)
    values = value.to_numpy() if isinstance(value, pd.Series) else np.asarray(value)
    if values.dtype.kind in "mMc":  # times, spans of time and complex numbers
        raise not_a_number(name, values.astype(object), 0, index)
    if values.dtype.kind not in "fiub":
        for at, entry in enumerate(np.atleast_1d(values)):
            if not (isinstance(entry, (numbers.Real, Decimal)) or pd.isna(entry)):
                raise not_a_number(name, np.atleast_1d(values), at, index)
        values = np.where(pd.isna(values), np.nan, values)
    if values.dtype != np.float32:
        values = values.astype(float, copy=False)
    # an infinity or NaN in the column shows in its sum, which is one fast pass
    if not np.isfinite(values.sum()):
        infinite = np.isinf(values)
        if infinite.any():
            raise refusal(
                f"{name} is infinite at {at_time(index, int(np.argmax(infinite)))}; ",
                ShellText(
                    "replace it with NaN", "give --missing INF or --missing -INF"
                ),
            )
    return values


def not_a_number(name: str, values: Any, row: Any, index: Any) -> ValueError:
    """The error of text in a column, of which one bad entry makes all of it text."""
    words = [entry if isinstance(entry, str) else "0" for entry in values]
    numeric = pd.to_numeric(pd.Series(words, dtype=object), errors="coerce")
    bad = np.flatnonzero(numeric.isna())
    row = int(bad[0]) if len(bad) else row
    entry, what = values[row], "not a number"
    if not isinstance(entry, str):
        return ValueError(
            f"{name} holds {entry!r} at {at_time(index, row)}, which is {what}; give "
            "a column of numbers"
        )
    remedy = "pd.to_numeric(column, errors='coerce')"
    option = "give --missing TEXT for a text that stands for a missing value"
    if not len(bad):
        what, remedy = "a number as text", "pd.to_numeric(column)"
        option = "write it as a number"
    elif DECIMAL_COMMA.fullmatch(entry.strip()):
        what, remedy = "a number with a decimal comma", "column.str.replace(',', '.')"
        remedy += " before pd.to_numeric, or read the file with decimal=','"
        option = "give --decimal ,"
    return refusal(
        f"{name} holds {entry!r} at {at_time(index, row)}, which is {what}; ",
        ShellText(f"clean the column, for example with {remedy}", option),
    )


def is_number(value: Any) -> bool:
    """
    Whether a value is one real number and no duration, which numpy takes for one.

    Parameters
    ----------
    value : object

    Returns
    -------
    bool
    """
    return isinstance(value, numbers.Real) and not isinstance(value, np.timedelta64)


def at_time(index: Any, row: int) -> str:
    """
    Where a row is, as a message names it.

    Parameters
    ----------
    index : Index or tuple
        Times of the rows; may be empty.
    row : int
        Number of the row, from 0.

    Returns
    -------
    str
        Such as ``"2023-06-01 12:00:00 (row 720)"``.
    """
    timed = len(index) > row and not isinstance(index, pd.RangeIndex)
    return f"{index[row]} (row {row})" if timed else f"row {row}"
