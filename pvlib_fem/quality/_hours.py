"""Days, offsets and words of a clock that is off."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from pvlib_fem.quality._onset import DAY

MOST = 4  # jumps that are listed one by one


def hours_of(blocks: list, changes: list) -> tuple:
    """
    From when on a clock is by how many hours off its standard time.

    Standard time is the stretch in which the clock is least wrong.

    Parameters
    ----------
    blocks : list of dict
        From :func:`measured_blocks`: ``seconds`` of each block's middle, from the
        record's first row, and ``late``, by how much its clock is late. [s]
    changes : list of dict
        In order: ``seconds`` of each jump, and ``by``, its size, positive to later
        stamps. [s]

    Returns
    -------
    tuple of tuple
        Begin of each stretch, the first at −∞, and how late the clock is then
        [s]; empty without changes.
    """
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


def side_of(late: float) -> str:
    """
    Say on which side of correct times the timestamps of a clock are.

    Parameters
    ----------
    late : float
        Positive if the stamp is later than the truth. [s]

    Returns
    -------
    str
        ``"ahead of"`` or ``"behind"``.
    """
    return "ahead of" if late > 0 else "behind"


def offsets(hours: tuple, seconds: np.ndarray | pd.Series) -> np.ndarray:
    """
    How late a clock is at each of some times, by its hours.

    Parameters
    ----------
    hours : tuple of tuple
        From :func:`hours_of`; none is a clock without jumps.
    seconds : numpy.ndarray or pandas.Series, shape (rows,)
        Times since the record's first row. [s]

    Returns
    -------
    numpy.ndarray, shape (rows,)
        Positive is late. [s]
    """
    late = np.zeros(len(seconds))
    for start, offset in hours:
        late[np.asarray(seconds) >= start] = offset
    return late


def day_of(origin: pd.Timestamp, seconds: float | np.ndarray) -> pd.Timestamp:
    """
    Begin of a day that is nearest to a time.

    Parameters
    ----------
    origin : pandas.Timestamp
        First row of the record.
    seconds : float
        Time since the origin. [s]

    Returns
    -------
    pandas.Timestamp
        Midnight in the zone of the origin.
    """
    return days_of(origin, [seconds])[0]


def days_of(origin: pd.Timestamp, seconds: list | np.ndarray) -> pd.DatetimeIndex:
    """
    Begin of the day that is nearest to each of some times.

    Parameters
    ----------
    origin : pandas.Timestamp
        First row of the record.
    seconds : list or numpy.ndarray, shape (times,)
        Times since the origin. [s]

    Returns
    -------
    pandas.DatetimeIndex, shape (times,)
        Midnights in the zone of the origin.
    """
    # of whole seconds, which reach further than the nanoseconds of a number
    half_on = np.round(np.asarray(seconds, dtype=float) + DAY / 2).astype("m8[s]")
    return (origin + pd.TimedeltaIndex(half_on)).normalize()


def listed_jumps(jumps: Sequence) -> str:
    """
    Sizes of jumps and their dates in words; of many the first, last and number.

    Parameters
    ----------
    jumps : sequence of tuple
        First day after each jump, a ``Timestamp``, and its size. [s]

    Returns
    -------
    str
        Sizes in minutes.
    """
    if len(jumps) <= MOST:
        return ", ".join(f"{by / 60:+.0f} min on {day.date()}" for day, by in jumps)
    sizes = sorted({abs(by) / 60 for _, by in jumps})
    ends = f"{sizes[0]:.0f}" + (f" to {sizes[-1]:.0f}" if len(sizes) > 1 else "")
    return f"{ends} min {len(jumps)} times {date_span(jumps)}"


def date_span(jumps: Sequence) -> str:
    """
    First and last date of some jumps in words.

    Parameters
    ----------
    jumps : sequence of tuple
        As of :func:`listed_jumps`, one at least.

    Returns
    -------
    str
        ``"from 2023-03-26 to 2023-10-29"``.
    """
    return f"from {jumps[0][0].date()} to {jumps[-1][0].date()}"
