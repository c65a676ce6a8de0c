"""Rows of Parquet files that hold no time, or none that their zone's clock shows."""

import itertools
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.file_times import naive_in_zone, once_only, skipped
from pvlib_fem._spelling import ShellText, refusal

DAY = pd.Timedelta(days=1)
NEAR = pd.Timedelta(hours=3)  # so that an hour in two row groups is seen as a whole


def on_the_clock(
    groups: tuple, times_of: Callable, tz: str | None = None, drop_untimed: bool = False
) -> tuple[list, list]:
    """
    Row groups with the rows that have no time, and what is said of these.

    Only the times of groups that lack some are read, and of those in which the clock
    of a zone changes.

    Parameters
    ----------
    groups : sequence of RowGroup
    times_of : callable
        The times of a row group, as an array.
    tz : str, optional
        Zone of times that have none.
    drop_untimed : bool
        Leave out rows that hold no time.

    Returns
    -------
    list of RowGroup, list of str

    Raises
    ------
    ValueError
        If rows hold no time and are not to be left out.
    """
    notes, timed = [], list(groups)
    if untimed := [group for group in groups if group.nulls]:
        rows = sum(group.nulls for group in untimed)
        if not drop_untimed:
            first = untimed[0]
            raise refusal(
                f"{first.nulls:,} rows of {first.file} have no time; give ",
                ShellText("drop_untimed=True (--drop-untimed)", "--drop-untimed"),
                " to leave such rows out",
            )
        timed = [without_nulls(group, times_of) for group in groups]
        timed = [group for group in timed if group.rows]
        notes.append(
            f"rows without a time, left out: {rows:,}, the first in {untimed[0].file}"
        )
    if tz is None:
        return timed, notes
    runs, localized, pairs = [], [], clock_change_hours(timed, tz)
    for near, run in itertools.groupby(timed, lambda group: meets_change(group, pairs)):
        run = list(run)
        if near:
            run, *rows = in_the_zone(run, times_of, tz)
            localized.append(rows)
        runs += run
    if localized:
        index, there, once = (np.concatenate(part) for part in zip(*localized))
        index = pd.DatetimeIndex(index)
        notes += [*skipped(index, tz, there), *once_only(index, tz, once)]
    return [group for group in runs if group.rows], notes


def clock_change_hours(groups: Any, tz: Any) -> Any:
    """The hours around the changes of a zone's clock, as pairs of its own times."""
    first = min(group.first for group in groups).normalize() - DAY
    last = max(group.last for group in groups).normalize() + DAY
    noons = pd.date_range(first, last, freq="D") + DAY / 2
    how: dict[str, Any] = dict(ambiguous=np.ones(len(noons), dtype=bool))
    how["nonexistent"] = "shift_forward"
    ahead = (noons - noons.tz_localize(tz, **how).tz_convert(None)).to_numpy()
    at = np.flatnonzero(np.diff(ahead))
    return [(noons[i] - NEAR, noons[i + 1] + NEAR) for i in at.tolist()]


def meets_change(group: Any, pairs: Any) -> bool:
    return any(group.first <= end and begin <= group.last for begin, end in pairs)


def without_nulls(group: Any, times_of: Any) -> Any:
    if not group.nulls:
        return group
    missing = np.isnat(times_of(group))
    dropped = tuple(np.flatnonzero(missing).tolist())
    return replace(group, rows=group.rows - len(dropped), dropped=dropped)


def in_the_zone(run: Any, times_of: Any, tz: str) -> Any:
    """Row groups that follow each other, and their times in a zone."""
    times = [times_of(group) for group in run]
    kept = [~np.isnat(part) for part in times]
    index = pd.DatetimeIndex(np.concatenate([t[k] for t, k in zip(times, kept)]))
    local, there, once = naive_in_zone(index, tz)
    good = there & ~once
    early = index[good].tz_localize(tz, ambiguous=np.ones(good.sum(), dtype=bool))
    late = np.zeros(len(index), dtype=bool)
    late[good] = np.asarray(local != early)
    zoned, start = [], 0
    for group, part, had in zip(run, times, kept):
        rows = slice(start, start + had.sum())
        start = rows.stop
        has, second = np.array(had), np.zeros(len(had), dtype=bool)
        has[had], second[had] = good[rows], late[rows]
        ends = part[has] if has.any() else part[had]
        zoned.append(
            replace(
                group,
                rows=int(has.sum()),
                first=pd.Timestamp(ends.min()),
                last=pd.Timestamp(ends.max()),
                dropped=tuple(np.flatnonzero(~has).tolist()),
                late=tuple(np.flatnonzero(second).tolist()),
            )
        )
    return zoned, index.to_numpy(), there, once


def in_file(groups: list) -> tuple[np.ndarray, np.ndarray]:
    """
    Rows of a file that are not read, and rows that a clock shows again.

    Parameters
    ----------
    groups : list of RowGroup
        Of one file, in its order.

    Returns
    -------
    dropped, late : array of int
        Numbers of the rows in the file, counted from the first row of ``groups``.
    """
    dropped, late, start = [], [], 0
    for group in groups:
        dropped += [start + row for row in group.dropped]
        late += [start + row for row in group.late]
        start += group.rows + len(group.dropped)
    return np.array(dropped, dtype=int), np.array(late, dtype=int)
