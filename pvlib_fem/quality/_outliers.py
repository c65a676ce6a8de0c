"""What a column cannot have measured, seen from the column alone."""

import numpy as np
import pandas as pd

from pvlib_fem._record.checks import dates_of
from pvlib_fem._record.ranges import possible_range
from pvlib_fem.quality._limits import FASTEST, Limits


def codes_apart(codes: np.ndarray, rest: np.ndarray, limits: Limits) -> np.ndarray:
    """
    Codes in a column of unknown range that are no values.

    Parameters
    ----------
    codes : numpy.ndarray, shape (codes,)
        Values of the column that are codes of some logger.
    rest : numpy.ndarray, shape (rows,)
        Its other values, without NaN.
    limits : Limits
        A positive code is ``min_fill_ratio`` times as large as all of these, in size,
        and they are no switch; a negative one is ``min_fill_ratio`` times below the
        lowest, or below 0.

    Returns
    -------
    numpy.ndarray
        Some of the codes; all of them if there is no other value.
    """
    if not len(rest):
        return codes
    low, high = rest.min(), rest.max()
    above = codes >= limits.min_fill_ratio * max(abs(low), abs(high))
    above &= not is_switch(rest, limits)  # a switch may be on at any number
    below = (codes < 0) & (codes <= limits.min_fill_ratio * min(low, 0.0))
    return codes[above | below]


def is_switch(values: np.ndarray, limits: Limits) -> bool:
    """
    Whether a column has so few different values that it is a switch.

    Parameters
    ----------
    values : numpy.ndarray, shape (rows,)
        Without NaN; 20,000 of them at least are compared.
    limits : Limits
        A switch has less than ``min_known_values``.

    Returns
    -------
    bool
        True of a switch.
    """
    some = values[:: max(1, len(values) // 20_000)]
    return len(np.unique(some)) < limits.min_known_values


def out_of_range(name: str, values: np.ndarray) -> np.ndarray:
    """
    Rows of values that no sensor can have measured.

    Parameters
    ----------
    name : str
        Column, as pvlib names it.
    values : numpy.ndarray, shape (rows,)
        In the unit of the package.

    Returns
    -------
    numpy.ndarray of bool, shape (rows,)
        False for NaN, and for all rows of a column whose range is not known.
    """
    bounds = possible_range(name)
    if bounds is None:
        return np.zeros(len(values), dtype=bool)
    return rows_outside(values, *bounds[:2])


def rows_outside(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """
    Rows of values below one bound or above the other.

    Parameters
    ----------
    values : numpy.ndarray, shape (rows,)
        In any unit.
    low, high : float
        Bounds, which are allowed.

    Returns
    -------
    numpy.ndarray of bool, shape (rows,)
        False for NaN.
    """
    # of most columns the two ends tell, in a fraction of the time
    if len(values) and np.fmin.reduce(values) >= low and np.fmax.reduce(values) <= high:
        return np.zeros(len(values), dtype=bool)
    return (values < low) | (values > high)


#: ends of a column at which its sensor, or a logger, may stop: most, and least. Light
#: and wind have their least of themselves
ENDS = {
    "poa_global": (1.0,),
    "wind_speed": (1.0,),
    "temp_air": (1.0, -1.0),
    "temp_module": (1.0, -1.0),
}


def range_ends(
    name: str, values: np.ndarray, index: pd.Index, limits: Limits
) -> list[float]:
    """
    Values beyond which a column does not go, since its sensor's range ends there.

    There it stays, on several days, and is more often at that one value than anywhere
    near it. What is measured has a tail instead.

    Parameters
    ----------
    name : str
        Column; those without an entry in ``ENDS`` have no end.
    values : numpy.ndarray, shape (rows,)
        The column, or evenly taken rows of it.
    index : pandas.DatetimeIndex, shape (rows,)
        Its times.
    limits : Limits
        ``min_known_values`` rows on ``min_range_end_days`` days at least.

    Returns
    -------
    list of float
        The largest value, the smallest, both or none.
    """
    ends = []
    for way in ENDS.get(name, ()):
        most = (np.fmax if way > 0 else np.fmin).reduce(values)
        at = values == most
        rows = np.count_nonzero(at)
        if rows < limits.min_known_values:
            continue
        size, most = way * values, way * most
        if len(np.unique(dates_of(index[at]))) < limits.min_range_end_days:
            continue
        below = size[size < most]
        if is_switch(values[np.isfinite(values)], limits) or not len(below):
            continue
        # a coarse sensor has its next value further away
        near = min(most - limits.max_accident_share * (most - below.min()), below.max())
        if rows > np.count_nonzero(below >= near):
            ends.append(float(way * most))
    return ends


def at_end(
    name: str,
    values: np.ndarray,
    seconds: np.ndarray,
    ends: list,
    limits: Limits,
    since: float = -np.inf,
) -> np.ndarray:
    """
    Rows of values at such ends, and rows that the module remembers them in.

    What light, air and wind were while they stayed is not known, and the module still
    has it when they are back.

    Parameters
    ----------
    name : str
        Column; of ``temp_module`` only the values at the ends count.
    values : numpy.ndarray, shape (rows,)
        The column, or a block of it.
    seconds : numpy.ndarray, shape (rows,)
        Times of its rows. [s]
    ends : list of float
        From :func:`range_ends`.
    limits : Limits
        ``response_time`` is the memory of the module.
    since : float, default -inf
        When the column was at an end before the first row, on the scale of
        ``seconds``. [s]

    Returns
    -------
    numpy.ndarray of bool, shape (rows,)
        True where the value is not to be used.
    """
    rows = np.isin(values, ends)
    if name == "temp_module" or not ends:
        return rows
    last = np.maximum.accumulate(np.where(rows, seconds, since))
    return seconds - last <= limits.response_time


def most_jump(name: str, time: np.ndarray, limits: Limits) -> np.ndarray:
    """Change there and back within a time that may be, half of it there."""
    most = limits.min_spike + FASTEST[name] * time / 2.0
    if name == "temp_air":
        short = time <= limits.stale_air_window
        return np.where(short, np.minimum(most, 2.0 * limits.min_spike), np.inf)
    return most


def jumps(
    name: str, values: np.ndarray, seconds: np.ndarray, limits: Limits
) -> np.ndarray:
    """
    Rows that lie on one side of those before and after by more than can be.

    The longer the time between those two, the more can be.

    Parameters
    ----------
    name : str
        ``"temp_air"`` or ``"temp_module"``.
    values : numpy.ndarray, shape (rows,)
        Temperatures. [°C]
    seconds : numpy.ndarray, shape (rows,)
        Times of the rows. [s]
    limits : Limits
        ``min_spike``, ``stale_air_window`` and ``max_accident_rows``, the most rows of
        one jump.

    Returns
    -------
    numpy.ndarray of bool, shape (rows,)
        False for NaN, which are skipped.
    """
    result = np.zeros(len(values), dtype=bool)
    known = np.isfinite(values)
    x = values if known.all() else values[known]
    # no jump there and back without one there, of which there are few
    step, least = np.diff(x), limits.min_spike
    begin = np.flatnonzero(rows_outside(step, -least, least))
    if not len(begin):
        return result
    there = np.flatnonzero(known)
    for rows in range(1, limits.max_accident_rows + 1):
        begin = begin[begin + rows + 1 < len(x)]
        first, end = x[begin], begin + rows + 1
        limit = most_jump(name, seconds[there[end]] - seconds[there[begin]], limits)
        inner = x[begin[:, None] + np.arange(1, rows + 1)]
        up = inner.min(axis=1) - np.maximum(first, x[end]) > limit
        down = np.minimum(first, x[end]) - inner.max(axis=1) > limit
        for i in range(rows):
            result[there[begin[up | down] + 1 + i]] = True
    return result


def lone_zeros(name: str, values: np.ndarray, limits: Limits) -> tuple:
    """
    Rows of exactly 0, to which the values before and after do not lead.

    Parameters
    ----------
    name : str
        Column; irradiance has ``min_bright_irradiance`` on both sides, a temperature
        is ``temperature_tolerance`` above 0 or below it on both.
    values : numpy.ndarray, shape (rows,)
        Without NaN.
    limits : Limits
        Both thresholds, and ``max_accident_rows``, the most zeros in a row.

    Returns
    -------
    first, rows : numpy.ndarray of int, shape (zeros,)
        Place of the first 0 of each stretch, and the number of them.
    depth : numpy.ndarray, shape (zeros,)
        Distance of 0 from the nearer one of the values on both sides.
    """
    edges = np.flatnonzero(np.diff(values == 0, prepend=False, append=False))
    first, end = edges[::2], edges[1::2]
    inner = (first > 0) & (end < len(values))
    inner &= end - first <= limits.max_accident_rows
    first, end = first[inner], end[inner]
    before, after = values[first - 1], values[end]
    depth = np.minimum(np.abs(before), np.abs(after))
    if name == "poa_global":
        kept = np.minimum(before, after) >= limits.min_bright_irradiance
    else:
        kept = (before * after > 0) & (depth >= limits.temperature_tolerance)
    return first[kept], (end - first)[kept], depth[kept]


def returns(values: np.ndarray, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """
    How far each stretch of rows lies on one side of the rows before and after.

    Parameters
    ----------
    values : numpy.ndarray, shape (n,)
        Without NaN.
    rows : int
        Length of a stretch.

    Returns
    -------
    farthest : numpy.ndarray, shape (n - rows - 1,)
        Largest value of each stretch without its sign, of the one that begins in the
        second row first; infinite for a stretch that has a 0.
    depth : numpy.ndarray, shape (n - rows - 1,)
        Distance from the nearer one of the two rows; negative between them.
    """
    n = len(values) - rows - 1
    inner = np.stack([values[i : i + n] for i in range(1, rows + 1)])
    low, high = inner.min(axis=0), inner.max(axis=0)
    before, after = values[:n], values[rows + 1 :]
    up, down = low - np.maximum(before, after), np.minimum(before, after) - high
    farthest = np.where((inner == 0).any(axis=0), np.inf, np.maximum(high, -low))
    return farthest, np.maximum(up, down)


def mean_spacing(values: np.ndarray) -> float:
    """
    Mean distance between the values that a column has.

    Parameters
    ----------
    values : numpy.ndarray, shape (rows,)
        The column, or evenly taken rows of it.

    Returns
    -------
    float
        In the unit of the column; infinite for a single value.
    """
    known = np.unique(values[np.isfinite(values)])
    return float(np.ptp(known)) / (len(known) - 1) if len(known) > 1 else np.inf
