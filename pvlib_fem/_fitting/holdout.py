"""The days that are held out of a fit."""

import numpy as np
import pandas as pd

from pvlib_fem._record.inputs import Record
from pvlib_fem._statistics.clusters import calendar_weeks

NONE_OUT = "no row that counts is held out: test scores are NaN"


def held_out(
    record: Record, filtered: np.ndarray, holdout: pd.Series | None, notes: list
) -> np.ndarray:
    """
    Mask of the held-out rows: the given ones, or the default.

    Parameters
    ----------
    record : Record
        The record.
    filtered : numpy.ndarray of bool, shape (rows,)
        Rows that count.
    holdout : pandas.Series of bool, shape (rows,), or None
        Rows that a user chose.
    notes : list of str
        A note is appended if no row that counts is held out.

    Returns
    -------
    numpy.ndarray of bool, shape (rows,)
        True for held-out rows, also if they do not count.

    Raises
    ------
    ValueError
        If ``holdout`` is no boolean Series with the index of the record.
    """
    if holdout is not None:
        out = record.rows(holdout)
    else:
        dates, rows = record.rows_by_date(filtered)
        out = record.of_dates(dates[days_out(dates, rows)])
    if not (filtered & out).any():
        notes.append(NONE_OUT)
    return out


def days_out(dates: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """
    Mask of the days that are held out by default.

    These are weekend days if two weekends have rows that count, else every other day.

    Parameters
    ----------
    dates : numpy.ndarray of int, shape (days,)
        Days since 1970-01-01, in order.
    rows : numpy.ndarray of int, shape (days,)
        Number of rows that count, per day.

    Returns
    -------
    numpy.ndarray of bool, shape (days,)
        No day if no row would be fitted.
    """
    weekend = (dates + 3) % 7 >= 5  # 1970-01-01 was a Thursday
    weeks = calendar_weeks(dates)
    two = len(np.unique(weeks[weekend & (rows > 0)])) >= 2
    out = weekend if two else np.arange(len(dates)) % 2 == 1
    return out if rows[~out].any() else np.zeros(len(dates), dtype=bool)
