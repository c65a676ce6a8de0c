"""The days that are held out of a fit."""

import numpy as np
import pandas as pd

from pvlib_fem._record.inputs import Record
from pvlib_fem._statistics.clusters import calendar_weeks

NONE_OUT = "no row that counts is held out: test scores are NaN"


def held_out(
    record: Record, filtered: np.ndarray, holdout: pd.Series | None, notes: list
) -> np.ndarray:
    """Mask of the held-out rows: the given ones, or the default."""
    if holdout is not None:
        out = record.rows(holdout)
    else:
        dates, rows = record.rows_by_date(filtered)
        out = record.of_dates(dates[days_out(dates, rows)])
    if not (filtered & out).any():
        notes.append(NONE_OUT)
    return out


def days_out(dates: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Mask of the days held out by default, by their dates and rows that count."""
    weekend = (dates + 3) % 7 >= 5  # 1970-01-01 was a Thursday
    weeks = calendar_weeks(dates)
    two = len(np.unique(weeks[weekend & (rows > 0)])) >= 2
    out = weekend if two else np.arange(len(dates)) % 2 == 1
    return out if rows[~out].any() else np.zeros(len(dates), dtype=bool)
