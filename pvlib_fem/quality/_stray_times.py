"""Rows whose time is years from all others."""

from typing import Any

import numpy as np

from pvlib_fem._record.checks import instants
from pvlib_fem.quality._limits import Limits


def refuse_stray(index: Any, limits: Any) -> None:
    """
    Refuse rows that are years from all others: their time is not theirs.

    Parameters
    ----------
    index : pandas.DatetimeIndex, shape (rows,)
        Sorted times of a record.
    limits : Limits
        ``min_stray_gap`` and ``max_accident_share``.

    Raises
    ------
    ValueError
        If there are such rows.
    """
    if sentences := stray_rows(index, limits):
        raise ValueError(sentences[0])


def stray_rows(index: Any, limits: Limits) -> list[str]:
    """
    Say which rows are years from all others.

    Parameters
    ----------
    index : pandas.DatetimeIndex, shape (rows,)
        Sorted times of a record.
    limits : Limits
        ``min_stray_gap`` and ``max_accident_share``.

    Returns
    -------
    list of str
        A sentence for each gap with few rows on one side.
    """
    # in ns too long a gap overflows
    gap = np.timedelta64(int(limits.min_stray_gap), "s")
    times = instants(index)
    if times[-1] - times[0] <= gap:
        return []
    sentences = (
        stray_side(at, len(index), index[0], index[at - 1], index[at], limits)
        for at in np.flatnonzero(np.diff(times) > gap) + 1
    )
    return [*filter(None, sentences)]


def stray_side(
    at: Any, total: Any, start: Any, before: Any, after: Any, limits: Limits
) -> str:
    """
    Say which rows are on one side of a gap, if they are few.

    Parameters
    ----------
    at : int
        First row after the gap.
    total : int
        Number of rows.
    start, before, after : pandas.Timestamp
        Times of the first row, and of the rows on either side of the gap.
    limits : Limits
        ``max_accident_share`` of the rows, or one row, are few.

    Returns
    -------
    str
        Empty if they are not few.
    """
    early = at <= total / 2
    rows = at if early else total - at
    if rows > max(limits.max_accident_share * total, 1):
        return ""
    ends = after.to_datetime64(), before.to_datetime64()
    years = (ends[0] - ends[1]) / np.timedelta64(31_556_952, "s")
    return (
        f"{'the row' if rows == 1 else f'{rows} rows'} at {start if early else after} "
        f"{'is' if rows == 1 else 'are'} {years:.0f} years "
        f"{'before' if early else 'after'} all others, which "
        f"{'begin' if early else 'end'} at {after if early else before}:"
        " a logger that lost its clock; drop such rows, or correct their times"
    )
