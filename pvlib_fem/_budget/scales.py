"""Split a residual by time scale: nested means of weeks, days and hours."""

import numpy as np

from pvlib_fem._statistics.clusters import calendar_weeks

HOURS = 24
#: largest distance between neighbours, in usual steps
NEAR = 1.5
#: parts of a mean square, from the slowest to the fastest
WEEKS, DAYS, HOURLY, MINUTES, WHITE = SCALES = (
    "from week to week",
    "from day to day",
    "within the day",
    "within the hour",
    "from row to row",
)


def by_scale(
    residual: np.ndarray,
    dates: np.ndarray,
    hours: np.ndarray,
    seconds: np.ndarray,
    step: float,
) -> dict:
    """
    Mean square of a residual by time scale; the parts add up exactly.

    The parts are means of calendar weeks, of days minus their week's mean, of hours
    minus their day's mean, and of rows minus their hour's mean. They are weighted by
    their rows, so they are orthogonal also with gaps. White noise contributes to each
    part in proportion to its number of means. These contributions are moved to the part
    that changes from row to row.

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
        Mean square [K²] by scale, from the slowest to the fastest. The first scale
        holds the mean and periods longer than two weeks, of which a mean over seven
        days keeps at least half.
    """
    rows = len(residual)
    if rows == 0:
        return dict.fromkeys(SCALES, 0.0)
    dates = np.asarray(dates, dtype=np.int64)
    blocks = (calendar_weeks(dates), dates, dates * HOURS + hours)
    means = [block_means(residual, block) for block in blocks]
    squares = [size @ mean**2 for mean, size, _ in means] + [residual @ residual]
    counts = [len(size) for _, size, _ in means] + [rows]
    mean_squares = np.diff(squares, prepend=0.0).clip(min=0.0) / rows
    mean, _, place = means[1]
    white = white_noise(residual - mean[place], seconds, step)
    noise = np.minimum(white * np.diff(counts, prepend=0) / rows, mean_squares)
    return dict(zip(SCALES, map(float, (*(mean_squares - noise), noise.sum()))))


def block_means(
    values: np.ndarray, block: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean and number of rows of each block, and the place of each row's block."""
    place = np.unique(block, return_inverse=True)[1]
    size = np.bincount(place)
    return np.bincount(place, values) / size, size, place


def white_noise(values: np.ndarray, seconds: np.ndarray, step: float) -> float:
    """Mean square of the part without autocorrelation."""
    square = values @ values / len(values)
    one, two = (lagged_product(values, seconds, step, lag) for lag in (1, 2))
    # the autocovariance falls by a constant factor from row to row
    kept = one**2 / two if one > two > 0.0 else one
    return float(square - np.clip(kept, 0.0, square))


def lagged_product(
    values: np.ndarray, seconds: np.ndarray, step: float, lag: int
) -> float:
    """Mean product of values so many rows apart."""
    near = seconds[lag:] - seconds[:-lag] <= NEAR * step * lag
    if not near.any():
        return 0.0
    return float(np.mean(values[lag:][near] * values[:-lag][near]))
