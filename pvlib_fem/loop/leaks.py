"""Columns of a user's own that hold the answer."""

import numpy as np
import pandas as pd

from pvlib_fem.record.columns import COLUMNS
from pvlib_fem.statistics.clusters import FEWEST_DAYS, day_errors

BEYOND = 0.5  # of what is left of a column without the temperature, with it
SAME = 0.15  # by which it may follow what a model leaves otherwise than the rest
SURE = 5.0  # standard errors by which it has to follow that
SOME = 20_000  # rows that are enough to compare columns


def leaks(record, seen, modelled, names, criteria):
    """
    Columns that are the module temperature, or made from it.

    One is so if the measured temperature, as it is, a little before and after and
    smoothed, foretells it far better than all that a model knows (:func:`foretold`), or
    if it follows what a model leaves of the temperature by as much for each kelvin as
    what the model gives (:func:`of_one_piece`).

    Parameters
    ----------
    record : Record
    seen : array of bool
        Rows that may be looked at.
    modelled : array
        Temperature of the module by the model without effects. [°C]
    names : sequence of str
    criteria : Criteria
    """
    module = pd.Series(record["temp_module"]).interpolate(limit_direction="both")
    rows = np.flatnonzero(seen & np.isfinite(modelled))[1:-1]
    rows = rows[:: max(1, len(rows) // SOME)]
    usual = [np.ones(len(rows)), *(record[name][rows] for name in COLUMNS[:3])]
    usual = np.column_stack(usual)
    near = [module, module.shift(1), module.shift(-1), module.rolling(5, 1).mean()]
    near = np.column_stack([column.to_numpy()[rows] for column in near])
    model, dates = modelled[rows], record.dates[rows]
    for name in names:
        column = record[name][rows]
        known = np.isfinite(column)
        parts = (part[known] for part in (column, usual, model, near, dates))
        column, *others, days = parts
        if foretold(column, *others, criteria) or of_one_piece(
            column, *others, days, criteria
        ):
            yield name


def foretold(column, usual, model, near, criteria):
    """Whether the temperature leaves little of a column, and the model much."""
    without = np.column_stack([usual, model])
    before = unexplained(column, without)
    after = unexplained(column, np.column_stack([without, near]))
    return after < criteria.leak and after < BEYOND * before


def unexplained(column, others):
    """Share of a column's variance that others leave."""
    found = np.linalg.lstsq(others, column, rcond=None)[0]
    return np.var(column - others @ found) / max(np.var(column), 1e-300)


def of_one_piece(column, usual, model, near, days, criteria):
    """
    Whether a column takes the temperature as one piece.

    A model divides it into what it gives and what it leaves. What is made from the
    temperature, however noisy and with whatever of the usual columns taken off,
    follows both parts alike; a cause of what is left knows nothing of the model's part.
    """
    if len(np.unique(days)) < FEWEST_DAYS:
        return False
    # the whole beside the model's part: a piece takes nothing of that part more
    columns = [*usual.T, near[:, 0], model]
    found = np.linalg.lstsq(np.column_stack(columns), column, rcond=None)[0]
    left = column - np.column_stack(columns) @ found
    try:
        covariance = day_errors(columns, left, days)
    except np.linalg.LinAlgError:
        return False
    slope, beyond = abs(found[-2]), abs(found[-1])
    slope_error, beyond_error = np.sqrt(np.diag(covariance))[-2:]
    most = SAME * slope
    return slope > SURE * slope_error and beyond < most and beyond_error < most
