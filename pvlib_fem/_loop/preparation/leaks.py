"""
Columns of a user's own that are made from the module's temperature.

A model splits the temperature `T` into what it explains, `M`, and the remaining error,
`r = T - M`. A cause of `r` does not depend on `M` beyond any function of the usual
inputs. A column made from `T` depends on both, by the same coefficient. A second sensor
of the same module depends on both, too. But the noise of the first sensor is in `r`
and not in the second, so its coefficient of `r` is less than that of `M`. If a cause
depends on `M`, its coefficient of `r` is more: of what it adds to `T`, most is in `r`.
"""

from collections.abc import Iterable, Iterator

import numpy as np

from pvlib_fem._record.column_names import COLUMNS, DAYLIGHT
from pvlib_fem._record.inputs import Record
from pvlib_fem._relaxation import relax
from pvlib_fem._statistics.clusters import FEWEST_DAYS, FOLDS, days_of_folds
from pvlib_fem._statistics.weekly_sums import least_squares_coefficients

SURE = 3.0  # standard errors between days by which one description has to be better
SOME = 20_000  # rows that are enough to compare columns
LATE = 7200.0  # s, up to which a temperature is taken at every step
LATER = (9000.0, 10800.0)  # s, beyond it
SHORT = 300.0  # s, of a step at least
SMOOTH = np.array([60.0, 180.0]) * 60.0  # s, time constants of smoothed temperatures
MEMORY = np.array([15.0, 60.0, 180.0]) * 60.0  # s, of smoothed inputs
LEAST = 1e-12  # of a column's square: less of it on a day is rounding
#: coefficients of the residual relative to the model's part: without noise of the
#: module's sensor, and with noise of up to three quarters of the residual's variance
SECOND = (1.0, 0.5, 0.25)
#: the same of causes that look like a module's temperature
CAUSE = (2.0, 4.0)
KNOTS = np.linspace(0.0, 1.0, 6)[1:-1]  # quantiles at which splines of inputs bend


def leaks(
    record: Record,
    seen: np.ndarray,
    modelled: np.ndarray,
    names: Iterable[str],
    least: float,
) -> Iterator[str]:
    """
    Columns that are the module temperature, or made from it.

    Each is described by smooth functions of the usual inputs, now and smoothed over
    minutes to hours, and by one of these, at several lags: what the model explains of
    the temperature, the residual, or the temperature as a whole, with the residual at
    full size or at less. A column is made from the temperature if the whole describes
    it better than either part does, and the whole with more of the residual does not
    describe it much better. So a column that a cause drives stays, and so does one that
    the weather alone drives.

    Parameters
    ----------
    record : Record
    seen : array of bool, shape (rows,)
        Rows that may be looked at.
    modelled : array, shape (rows,)
        Temperature of the module by the model without effects. [°C]
    names : sequence of str
    least : float
        ``min_leak_difference`` of the criteria. [-]

    Yields
    ------
    str
    """
    both = seen & np.isfinite(modelled) & np.isfinite(record["temp_module"])
    rows = np.flatnonzero(both)
    rows = rows[:: max(1, len(rows) // SOME)]
    if len(np.unique(record.dates[rows])) < FEWEST_DAYS:
        return
    measured = np.where(both, record["temp_module"], np.nan)
    scale = np.mean(measured[both]), max(np.std(measured[both]), 1e-300)
    whole = temperature_forms(record, measured, rows, *scale)
    model = temperature_forms(record, np.where(both, modelled, np.nan), rows, *scale)
    usual, dates = input_functions(record, rows), record.dates[rows]
    # electrical power falls with temperature by irradiance, and may still be a cause
    power = record["poa_global"][rows] * record["temp_module"][rows]
    usual = np.column_stack([usual, power])
    for name in names:
        column = record[name]
        some = (np.isfinite(column) & ~resting_rows(column, record["poa_global"]))[rows]
        parts = (part[some] for part in (usual, whole, model, dates))
        if is_one_piece(column[rows][some], *parts, most=least):
            yield name


def temperature_forms(
    record: Record,
    temperature: np.ndarray,
    rows: np.ndarray,
    centre: float,
    spread: float,
) -> np.ndarray:
    """A temperature at some rows: at several lags, smoothed, and to higher powers."""
    seconds, inputs = record.inputs.seconds, record.inputs
    known = np.isfinite(temperature)
    at, values = seconds[known], (temperature[known] - centre) / spread
    now = np.interp(seconds, at, values)
    step = max(inputs.step, SHORT)
    lags = [*np.arange(-step, LATE + step, step), *LATER]
    columns = [np.interp(seconds[rows] - lag, at, values) for lag in lags]
    columns += [relax(now, inputs.steps, s / inputs.unit)[rows] for s in SMOOTH]
    return np.column_stack([*columns, now[rows] ** 2, now[rows] ** 3])


def input_functions(record: Record, rows: np.ndarray) -> np.ndarray:
    """Smooth functions of each usual input at some rows, now and smoothed in time."""
    inputs, columns = record.inputs, [np.ones(len(rows))]
    for name in COLUMNS[:3]:
        known = np.isfinite(record[name])
        values = record[name][known]
        now = np.interp(inputs.seconds, inputs.seconds[known], values)
        columns += [np.log1p(np.maximum(now[rows], 0.0))]
        columns += splines(now[rows])
        for memory in MEMORY:
            columns += splines(relax(now, inputs.steps, memory / inputs.unit)[rows])
    return np.column_stack(columns)


def splines(values: np.ndarray) -> list[np.ndarray]:
    """
    A basis of quadratic splines of a column.

    Parameters
    ----------
    values : array, shape (rows,)

    Returns
    -------
    list of array, shape (rows,)
    """
    values = (values - values.mean()) / max(values.std(), 1e-300)
    knots = np.unique(np.quantile(values, KNOTS))
    return [values, values**2, *(np.maximum(values - k, 0.0) ** 2 for k in knots)]


def resting_rows(column: np.ndarray, poa_global: np.ndarray) -> np.ndarray:
    """
    Rows of a column at its most frequent value through a night, as a voltage of 0.

    These rows do not depend on a temperature, and the jump in the morning is large.
    """
    finite = column[np.isfinite(column)]
    values, counts = np.unique(finite, return_counts=True)
    if len(values) == len(finite):
        return np.zeros(len(column), dtype=bool)
    still = column == values[counts.argmax()]
    run = np.cumsum(np.diff(still, prepend=still[:1]))
    return still & np.isin(run, run[poa_global < DAYLIGHT])


def is_one_piece(
    column: np.ndarray,
    usual: np.ndarray,
    whole: np.ndarray,
    model: np.ndarray,
    dates: np.ndarray,
    most: float,
) -> bool:
    """
    Whether a column follows the modelled temperature and the residual as one sum.

    Noise of the module's sensor may be in the residual, and noise of its own in the
    column. ``usual``, ``whole`` and ``model`` are functions of the usual inputs, of the
    temperature and of the model's part, shape (rows, functions). ``most`` is the share
    of what the remaining error describes of the column, that the sum with more of the
    residual may describe beyond the sum.
    """
    if len(np.unique(dates)) < FEWEST_DAYS or not np.std(column) > 0:
        return False
    column = (column - column.mean()) / column.std()
    table = np.column_stack([column, model, whole - model])
    table -= usual @ least_squares_coefficients(usual, table)
    column, model, rest = np.split(table, [1, 1 + model.shape[1]], axis=1)
    folds = days_of_folds(dates)
    by_model, by_rest, by_parts, *by_sums = (
        held_out(column[:, 0], others, folds)
        for others in (
            model,
            rest,
            np.hstack([model, rest]),
            *(model + share * rest for share in (*SECOND, *CAUSE)),
        )
    )
    by_whole = min(by_sums[: len(SECOND)], key=np.sum)
    by_more = min(by_sums[len(SECOND) :], key=np.sum)
    beyond = by_whole.sum() - by_more.sum()
    return (
        is_less(by_whole, by_model, dates)
        and is_less(by_whole, by_rest, dates)
        and bool(beyond < most * (by_model.sum() - by_parts.sum()))
    )


def held_out(column: np.ndarray, others: np.ndarray, folds: np.ndarray) -> np.ndarray:
    """Squared errors of a regression on groups of weeks that it was not fitted to."""
    squares = np.empty(len(column))
    for fold in range(FOLDS):
        out = folds == fold
        sizes = least_squares_coefficients(others[~out], column[~out, None])
        squares[out] = (column[out] - (others[out] @ sizes)[:, 0]) ** 2
    return squares


def is_less(one: np.ndarray, other: np.ndarray, dates: np.ndarray) -> bool:
    """Whether squares are surely less than others, by their ratio on each day."""
    day = np.unique(dates, return_inverse=True)[1]
    ratio = np.log((np.bincount(day, other) + LEAST) / (np.bincount(day, one) + LEAST))
    return bool(ratio.mean() > SURE * ratio.std() / np.sqrt(len(ratio)))
