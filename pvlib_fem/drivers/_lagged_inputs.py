"""Lagged columns, and time as a driver."""

from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.inputs import Inputs
from pvlib_fem._relaxation import relax

HOUR = 3600.0  # s
DAY = 24.0 * HOUR
YEAR = 365.0 * DAY


def smoothed(column: np.ndarray, inputs: Inputs, memory: float) -> np.ndarray:
    """
    First-order response to a column, with a time constant in s.

    Parameters
    ----------
    column : array, shape (rows,)
        In any unit.
    inputs : Inputs
        For the steps.
    memory : float
        Time constant. [s]

    Returns
    -------
    array, shape (rows,)
        NaN where the column is. [unit of the column]
    """
    column = np.asarray(column, dtype=float)
    return relax(column, inputs.steps, memory / inputs.unit)


def backwards(column: np.ndarray, steps: np.ndarray, memory: float) -> np.ndarray:
    """
    First-order response to a column backwards in time.

    Parameters
    ----------
    column : array, shape (rows,)
        In any unit.
    steps : array, shape (rows,)
        Time since the row before. [s]
    memory : float
        Time constant. [s]

    Returns
    -------
    array, shape (rows,)
        Weighted mean of each row and the rows after it. [unit of the column]
    """
    turned = np.append(steps[:1], steps[:0:-1])
    return relax(np.ascontiguousarray(column[::-1]), turned, memory)[::-1]


def weighted_past(memory: float) -> Any:
    """
    The driver that is the weighted past of a column.

    Parameters
    ----------
    memory : float
        Time constant. [s]

    Returns
    -------
    callable
        Function of a column, shape (rows,), and its inputs; see :func:`smoothed`.
    """

    def mean(column: np.ndarray, inputs: Inputs) -> np.ndarray:
        return smoothed(column, inputs, memory)

    mean.__doc__ = (
        f"Mean of the past {memory / HOUR:g} h, weighted by age. [unit of the column]"
    )
    return mean


def air_of_weeks(
    temp_air: np.ndarray, inputs: Inputs, *, memory: float = 16.0
) -> np.ndarray:
    """
    Air temperature of the past days or weeks, weighted by age. [°C]

    The year before the record is taken to be like its own first year. A record below a
    year begins with the weighted mean of what comes.

    Parameters
    ----------
    temp_air : array, shape (rows,)
        [°C]
    inputs : Inputs
        For the times.
    memory : float, default 16
        Time constant. [days]

    Returns
    -------
    array, shape (rows,)
        NaN where ``temp_air`` is.
    """
    temp_air = np.asarray(temp_air, dtype=float)
    steps, length = inputs.steps, memory * DAY / inputs.unit
    to_come = backwards(temp_air, np.broadcast_to(steps, len(temp_air)), length)
    known = np.flatnonzero(~np.isnan(to_come))
    if not len(known):
        return to_come
    past = relax(temp_air, steps, length, to_come[known[0]])
    since = inputs.seconds[known]
    year_on = known[since >= since[0] + YEAR]
    return relax(temp_air, steps, length, past[year_on[0]]) if len(year_on) else past


def past_minus_present(
    mean: np.ndarray, column: np.ndarray, inputs: Inputs
) -> np.ndarray:
    """
    Mean of the past, weighted by age, minus the present. [unit of the column]

    Parameters
    ----------
    mean : array, shape (rows,)
        From :func:`weighted_past`. [unit of the column]
    column : array, shape (rows,)
        In any unit.
    inputs : Inputs
        Not used.

    Returns
    -------
    array, shape (rows,)
    """
    return mean - column


def elapsed(inputs: Inputs) -> np.ndarray:
    """
    Time since the record began. [s]

    Parameters
    ----------
    inputs : Inputs

    Returns
    -------
    array, shape (rows,)
    """
    return inputs.seconds


def day(inputs: Inputs) -> pd.Index:
    """
    Time since 1970-01-01 by the record's own clock. [days]

    Parameters
    ----------
    inputs : Inputs

    Returns
    -------
    Index of float, shape (rows,)

    Raises
    ------
    ValueError
        If the inputs have no dates.
    """
    times = times_on_own_clock(inputs, "what changes with time")
    return (times - pd.Timestamp(0)) / pd.Timedelta("1D")


def day_angle(inputs: Inputs) -> np.ndarray:
    """
    Angle of the year, 0 on the first of January. [rad]

    Parameters
    ----------
    inputs : Inputs

    Returns
    -------
    array, shape (rows,)

    Raises
    ------
    ValueError
        If the inputs have no dates.
    """
    days = times_on_own_clock(inputs, "the season").day_of_year.to_numpy() - 1.0
    return 2.0 * np.pi * days / 365.25


def times_on_own_clock(inputs: Inputs, what: str) -> pd.DatetimeIndex:
    """
    The times of a record on its own clock.

    Parameters
    ----------
    inputs : Inputs
    what : str
        Subject of the error message.

    Returns
    -------
    DatetimeIndex, shape (rows,)
        Without a zone.

    Raises
    ------
    ValueError
        If the inputs have no DatetimeIndex.
    """
    if not isinstance(inputs.index, pd.DatetimeIndex):
        raise ValueError(
            f"{what} needs the date, and the columns have no DatetimeIndex; give "
            "them as Series with one"
        )
    return inputs.index.tz_localize(None)
