"""On which time scales a residual lives: means of weeks, days and hours, nested."""

import numpy as np

from pvlib_fem.statistics.clusters import calendar_weeks

HOURS = 24
#: longest distance of neighbours, in usual steps
NEAR = 1.5
#: parts of a mean square from the slowest to the fastest, by what they change with
WEEKS, DAYS, HOURLY, MINUTES, WHITE = SCALES = (
    "from week to week",
    "from day to day",
    "within the day",
    "within the hour",
    "from row to row",
)


def by_scale(residual, dates, hours, seconds, step):
    """
    Mean square of a residual by time scale, which adds up exactly.

    Means of calendar weeks, of days about their week's, of hours about their day's
    and rows about their hour's are orthogonal, each by the rows that it has, so that
    gaps do no harm. White noise is in all of them, by their numbers of means: that
    much of each is told as what changes from row to row.

    Parameters
    ----------
    residual : array
        [K]
    dates : array of int
        Calendar day of each row, from 1970-01-01.
    hours : array of int
        Hour of the day of each row.
    seconds : array
        Time of each row. [s]
    step : float
        Usual time between rows. [s]

    Returns
    -------
    dict
        Scale, from the slowest to the fastest, to mean square. [K²] The first holds
        the mean and what is slower than two weeks, for which a mean of seven days
        stands by half and more.
    """
    rows = len(residual)
    if rows == 0:
        return dict.fromkeys(SCALES, 0.0)
    dates = np.asarray(dates, dtype=np.int64)
    blocks = (calendar_weeks(dates), dates, dates * HOURS + hours)
    means = [blocked(residual, block) for block in blocks]
    squares = [size @ mean**2 for mean, size, _ in means] + [residual @ residual]
    counts = [len(size) for _, size, _ in means] + [rows]
    found = np.diff(squares, prepend=0.0).clip(min=0.0) / rows
    mean, _, place = means[1]
    white = white_noise(residual - mean[place], seconds, step)
    noise = np.minimum(white * np.diff(counts, prepend=0) / rows, found)
    return dict(zip(SCALES, map(float, (*(found - noise), noise.sum()))))


def blocked(values, block):
    """Mean and number of rows of each block, and the place of each row's block."""
    place = np.unique(block, return_inverse=True)[1]
    size = np.bincount(place)
    return np.bincount(place, values) / size, size, place


def white_noise(values, seconds, step):
    """Mean square of what has no memory from one row to the next."""
    square = values @ values / len(values)
    one, two = (lagged(values, seconds, step, lag) for lag in (1, 2))
    # what is remembered falls by a constant share from row to row
    kept = one**2 / two if one > two > 0.0 else one
    return float(square - np.clip(kept, 0.0, square))


def lagged(values, seconds, step, lag):
    """Mean product of neighbours so many rows apart."""
    near = seconds[lag:] - seconds[:-lag] <= NEAR * step * lag
    if not near.any():
        return 0.0
    return float(np.mean(values[lag:][near] * values[:-lag][near]))
