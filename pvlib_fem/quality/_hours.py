"""Days, offsets and words of a clock that is off."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem.quality._onset import DAY


def hours_of(blocks: list, changes: list) -> tuple:
    """From when on [s] the clock is by how many hours [s] off its standard time."""
    if not changes:
        return ()
    hours = [(-np.inf, 0.0)]
    for change in changes:
        hours.append((change["seconds"], hours[-1][1] + change["by"]))
    # standard time is where the clock is least wrong
    ends = [start for start, _ in hours[1:]] + [np.inf]
    wrong = [
        abs(
            np.mean(
                [b["late"] for b in blocks if start <= b["seconds"] < end] or np.inf
            )
        )
        for (start, _), end in zip(hours, ends)
    ]
    standard = hours[int(np.argmin(wrong))][1]
    return tuple((start, late - standard) for start, late in hours)


def side_of(late: float) -> Any:
    """Say on which side of correct times the timestamps of a clock are."""
    return "ahead of" if late > 0 else "behind"


def offsets(hours: tuple, seconds: np.ndarray | pd.Series) -> np.ndarray:
    """How far the clock is off at times from the record's start. [s]"""
    late = np.zeros(len(seconds))
    for start, offset in hours:
        late[np.asarray(seconds) >= start] = offset
    return late


def day_of(origin: pd.Timestamp, seconds: float | np.ndarray) -> pd.Timestamp:
    """The day that begins nearest to a time."""
    return days_of(origin, [seconds])[0]


def days_of(origin: pd.Timestamp, seconds: list | np.ndarray) -> pd.DatetimeIndex:
    """The days that begin nearest to some times."""
    # of whole seconds, which reach further than the nanoseconds of a number
    half_on = np.round(np.asarray(seconds, dtype=float) + DAY / 2).astype("m8[s]")
    return (origin + pd.TimedeltaIndex(half_on)).normalize()


def listed(jumps: Any, most: int = 4) -> str:
    """Sizes of jumps and their dates in words; of many the first, last and number."""
    if len(jumps) <= most:
        return ", ".join(f"{by / 60:+.0f} min on {day.date()}" for day, by in jumps)
    sizes = sorted({abs(by) / 60 for _, by in jumps})
    ends = f"{sizes[0]:.0f}" + (f" to {sizes[-1]:.0f}" if len(sizes) > 1 else "")
    return f"{ends} min {len(jumps)} times {span(jumps)}"


def span(jumps: Sequence) -> str:
    return f"from {jumps[0][0].date()} to {jumps[-1][0].date()}"
