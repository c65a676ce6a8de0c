"""First-order relaxation on uneven steps: the kernel of every dynamic response.

The exact response of a first-order system to an input held constant over each
step is ``y[i] = decay[i]*y[i-1] + (1 - decay[i])*x[i]`` with
``decay = exp(-step/tau)``: a lower bidiagonal linear system, which BLAS solves.
"""

from functools import wraps
from typing import Any

import numpy as np
import pandas as pd
from scipy.linalg.blas import dtbsv

from pvlib_fem._record.inputs import Inputs, read
from pvlib_fem.types import Numeric, Times

# rows solved at a time: all arrays stay in the cache, and the matrix product is smaller
# than one for which BLAS starts threads, which would cost more time than they save
BLOCK = 1 << 14
WIDE = 16  # rows that one matrix product solves, where all steps are even
FORGOTTEN = 5.0  # time constants after which a gap has erased the past
FADED = 37.0  # time constants after which the past is below the rounding error


def ewm(
    values: Numeric,
    tau: Numeric,
    times: Times | None = None,
    step: float | None = None,
    adjust: bool = False,
    initial: float | pd.Series | None = None,
) -> pd.Series | np.ndarray:
    r"""
    Exponential weighted mean: the exact first-order response to a signal.

    A signal that is held constant over each step :math:`\Delta t`, seen through
    a time constant :math:`\tau` [1]_:

    .. math::

        y_i = e^{-\Delta t_i/\tau} y_{i-1} + (1 - e^{-\Delta t_i/\tau}) x_i

    Parameters
    ----------
    values : Series or 1-D array
        The signal. [any unit]
    tau : float or array
        Time constant, one number or one for each sample. [s]
    times : DatetimeIndex or array, optional
        Time of each sample when ``values`` is an array: datetimes, or numbers.
        [s]
    step : float, optional
        Even time step, instead of ``times``. [s]
    adjust : bool, default False
        Divide by the sum of the weights so far, as
        ``pandas.Series.ewm(alpha=1 - exp(-step/tau), adjust=True)`` and the listing
        in [1]_ do. Only the start-up differs.
    initial : float or Series, optional
        State to continue from: the output of the record before. A Series has
        a time; a number counts as one ``step`` before the first sample. Without it
        the response starts at the first sample.

    Returns
    -------
    Series or array
        Smoothed signal, in the unit and with the index of ``values``. It is
        NaN where ``values`` is NaN, and only there.

    Raises
    ------
    ValueError
        If the times are missing, unsorted or duplicate, ``tau`` is not
        positive, ``values`` is not a numeric series, or ``initial`` is no finite
        number before them.

    Notes
    -----
    Over a gap or a NaN the state relaxes towards the next sample by the true
    duration. After a gap longer than 5 ``tau`` it starts anew; a step counts
    as a gap if it is longer than twice the median step of the record.
    ``pandas.Series.ewm(times=...)`` weights samples and not durations, so it differs
    from this response on uneven steps.

    References
    ----------
    .. [1] B. Herteleer et al., "Investigating methods to improve photovoltaic
       thermal models at second-to-minute timescales", 2022, Eqs. 24 to 27.
       :doi:`10.22541/au.166922866.68736478`

    Examples
    --------
    >>> ewm([0.0, 1000.0, 1000.0], tau=378.0, step=60.0).round(1)
    array([  0. , 146.8, 272. ])
    """
    inputs = read({"values": values}, step=step, times=times, purpose="ewm")
    smooth = smoothed(inputs, "values", tau, adjust, initial)
    return inputs.restore(smooth, getattr(values, "name", None))


def smoothed(
    inputs: Inputs,
    name: str,
    tau: float | np.ndarray | pd.Series,
    adjust: bool = False,
    initial: Any = None,
) -> np.ndarray:
    """
    A column of checked inputs seen through a time constant. [s]

    Parameters
    ----------
    inputs : Inputs
        Columns and their times.
    name : str
        The column. [any unit]
    tau : float, array or Series, shape (rows,)
        Time constant. [s]
    adjust, initial
        See :func:`ewm`.

    Returns
    -------
    array, shape (rows,)
        NaN where the column is. [unit of the column]

    Raises
    ------
    ValueError
        If ``tau`` is not positive or has another length or index, or ``initial`` is
        invalid or given together with ``adjust``.
    """
    other = isinstance(tau, pd.Series) and not tau.index.equals(inputs.index)
    if other and inputs.is_series:
        raise ValueError("tau and the signal have different indexes; align them first")
    tau = time_constant(tau, len(inputs.index)) / inputs.unit
    if adjust and initial is not None:
        raise ValueError(
            "initial does not go with adjust=True: the paper's weights start at the "
            "first sample; use adjust=False to carry a state"
        )
    state, steps = inputs.resume(initial)
    if adjust:
        return weighted_mean(inputs[name], steps, tau)
    return relax(inputs[name], steps, tau, state)


def time_constant(
    tau: float | np.ndarray | pd.Series, rows: int, name: str = "tau"
) -> float | np.ndarray:
    """Check a time constant: positive, a number or one for each row. [s]"""
    given = np.ma.asarray(tau)
    try:
        values = np.ma.filled(given.astype(float), np.nan)
    except (TypeError, ValueError):
        values = None
    if values is None or given.dtype.kind == "m":
        raise ValueError(
            f"{name} is a {type(tau).__name__}; give seconds as numbers, such as "
            "pd.Timedelta('6min').total_seconds()"
        )
    if values.ndim and values.shape != (rows,):
        raise ValueError(
            f"{name} has {values.size} values for {rows} samples; give one number, "
            "or one for each sample"
        )
    if not (values > 0).all():
        worst = values if values.ndim == 0 else values[~(values > 0)][0]
        raise ValueError(f"{name} = {worst} must be positive [s]")
    return float(values) if values.ndim == 0 else values


def over_nan(solve: Any) -> Any:
    """Decorate a solver: it gets the rows without NaN and the steps between them."""

    @wraps(solve)
    def solved(
        target: np.ndarray,
        steps: float | np.ndarray,
        tau: float | np.ndarray,
        *state: float | None,
    ) -> np.ndarray:
        if not np.isnan(target.sum()):  # one fast pass; infinities are refused before
            return solve(target, steps, tau, *state)
        valid = np.flatnonzero(~np.isnan(target))
        if not len(valid):
            return solve(target, steps, tau, *state)
        # the sample and the tau at the end of a step apply to the whole step
        steps, tau = steps_across(steps, valid), rows_of(tau, valid)
        response = solve(target[valid], steps, tau, *state)
        result = np.full((*response.shape[:-1], len(target)), np.nan)
        result[..., valid] = response
        return result

    return solved


@over_nan
def relax(
    target: np.ndarray,
    steps: float | np.ndarray,
    tau: float | np.ndarray,
    state: float | None = None,
) -> np.ndarray:
    """
    Response to ``target`` on any steps, with gaps and NaN.

    Parameters
    ----------
    target : array, shape (rows,)
        Value held over the step that ends at each row. [any unit]
    steps : float or array, shape (rows,)
        Time since the row before, one number if even.
    tau : float or array, shape (rows,)
        Time constant, in the unit of ``steps``.
    state : float, optional
        Response at the start of the first step. By default the response starts at the
        first value, and the first step is ignored.

    Returns
    -------
    array, shape (rows,)
        NaN where ``target`` is, and only there. [unit of ``target``]
    """
    state = target[0] if state is None else state
    rate = -1.0 / tau
    if np.ndim(steps) == 0 and np.ndim(tau) == 0:
        return relax_even(target, np.exp(steps * rate), state)
    rows = len(target)
    limit = gap_limit(steps, tau)
    result = np.empty(rows)
    decay = np.empty(min(rows, BLOCK))
    band = np.empty((2, len(decay)), order="F")
    for start in range(0, rows, BLOCK):
        block = slice(start, min(start + BLOCK, rows))
        x, y = target[block], result[block]
        decay = decay[: len(x)]
        np.multiply(rows_of(steps, block), rows_of(rate, block), out=decay)
        np.exp(decay, out=decay)
        if limit is not None:
            decay[rows_of(steps, block) > rows_of(limit, block)] = 0.0
        np.multiply(decay, x, out=y)
        np.subtract(x, y, out=y)
        respond(decay, y, state, band)
        state = y[-1]
    return result


def relax_even(
    target: np.ndarray, decay: float | np.ndarray, state: float
) -> np.ndarray:
    """Response on even steps: one matrix product solves sixteen rows."""
    result = np.empty(len(target))
    age = np.arange(WIDE)[None, :] - np.arange(WIDE)[:, None]
    weights = np.where(age >= 0, (1.0 - decay) * decay ** np.abs(age), 0.0)
    fading = decay ** np.arange(1, WIDE + 1)
    past = np.empty((min(len(target), BLOCK) // WIDE, WIDE))
    for start in range(0, len(target), BLOCK):
        x, y = target[start : start + BLOCK], result[start : start + BLOCK]
        whole = len(x) // WIDE * WIDE
        wide = y[:whole].reshape(-1, WIDE)
        np.matmul(x[:whole].reshape(-1, WIDE), weights, out=wide)
        ends = respond(np.full(len(wide), fading[-1]), wide[:, -1].copy(), state)
        carried = np.concatenate(([state], ends))[:-1, None]
        wide += np.multiply(carried, fading, out=past[: len(wide)])
        state = ends[-1] if whole else state
        rest = x[whole:] * (1.0 - decay)
        if len(rest):
            y[whole:] = respond(np.full(len(rest), decay), rest, state)
    return result


def respond(
    decay: np.ndarray,
    source: np.ndarray,
    state: float = 0.0,
    band: np.ndarray | None = None,
) -> np.ndarray:
    """
    Solve ``y[i] - decay[i]*y[i-1] = source[i]``, ``y[-1] = state``, in place.

    Parameters
    ----------
    decay : array, shape (rows,)
        Weight of the row before. [-]
    source : array of float, shape (rows,)
        Overwritten by the solution.
    state : float, default 0
        Solution at the row before the first.
    band : array, shape (2, at least rows), optional
        Memory to use again, in Fortran order.

    Returns
    -------
    array, shape (rows,)
        The array ``source``.
    """
    if not len(source):
        return source
    source[0] += decay[0] * state
    return solve(banded(decay, band), source)


def banded(decay: np.ndarray, band: np.ndarray | None = None) -> np.ndarray:
    """
    The system of :func:`respond` in BLAS' band form; the diagonal of 1 is unread.

    Parameters
    ----------
    decay : array, shape (rows,)
        Weight of the row before; the first value is not used. [-]
    band : array, shape (2, at least rows), optional
        Memory to use again, in Fortran order.

    Returns
    -------
    array, shape (2, rows)
        For :func:`solve`.
    """
    rows = len(decay)
    band = np.empty((2, rows), order="F") if band is None else band[:, :rows]
    np.negative(decay[1:], out=band[1, :-1])
    return band


def solve(band: np.ndarray, source: np.ndarray) -> np.ndarray:
    """
    Solve a banded system in place; one band serves several sources.

    Parameters
    ----------
    band : array, shape (2, rows)
        From :func:`banded`.
    source : array of float, shape (rows,)
        Right-hand side; overwritten by the solution.

    Returns
    -------
    array, shape (rows,)
        The solution.
    """
    return dtbsv(1, band, source, lower=1, diag=1, overwrite_x=1)


@over_nan
def weighted_mean(
    target: np.ndarray, steps: float | np.ndarray, tau: float
) -> np.ndarray:
    """Mean of all samples so far by exponential weights, as pandas' ``adjust=True``."""
    decay = decays(steps, tau, len(target))
    band = banded(decay)
    return solve(band, target.copy()) / solve(band, np.ones(len(target)))


def decays(steps: float | np.ndarray, tau: float, rows: int) -> np.ndarray:
    """Weight of the past at each row: ``exp(-steps/tau)``, 0 at the start."""
    decay = np.exp(np.broadcast_to(-steps / tau, rows))
    limit = gap_limit(steps, tau)
    if limit is not None:
        decay[steps > limit] = 0.0
    decay[0] = 0.0
    return decay


def gap_limit(steps: Any, tau: float | np.ndarray, usual: float | None = None) -> Any:
    """
    Step beyond which the past is forgotten; None if no step is that long.

    Parameters
    ----------
    steps : float or array, shape (rows,)
        Time since the row before, one number if even.
    tau : float or array, shape (rows,)
        Time constant, in the unit of ``steps``.
    usual : float, optional
        Median step of the record, if ``steps`` are a part of it.

    Returns
    -------
    float or array, shape (rows,), or None
        The larger of five time constants and two median steps. [unit of ``steps``]
    """
    limit = FORGOTTEN * tau
    if np.ndim(steps) == 0 or not (steps.max() > np.min(limit)):
        return None
    # a record in which every step is that long has no gaps, only a long step
    return np.maximum(limit, 2.0 * (median_step(steps) if usual is None else usual))


def median_step(steps: Any) -> float:
    """
    Median of the steps between rows; the first row has no step before it.

    Parameters
    ----------
    steps : array, shape (rows,)
        Time since the row before.

    Returns
    -------
    float
        0 for a single row. [unit of ``steps``]
    """
    return float(np.median(steps[1:])) if len(steps) > 1 else 0.0


def usual_step(columns: list, steps: float | np.ndarray) -> float:
    """
    Median step between the rows on which none of the columns is missing.

    Parameters
    ----------
    columns : list of array, shape (rows,)
        At least one.
    steps : float or array, shape (rows,)
        Time since the row before, one number if even.

    Returns
    -------
    float
        0 if at most one of several rows is complete. [unit of ``steps``]
    """
    if np.ndim(steps) == 0 and np.isfinite(sum(column.sum() for column in columns)):
        return float(steps)
    there = np.all([np.isfinite(column) for column in columns], axis=0)
    missing = len(there) - np.count_nonzero(there)
    # with even steps, more than half of the rows have to end a gap to change the median
    if np.ndim(steps) == 0 and missing <= len(there) / 3:
        return float(steps)
    if not missing:
        return median_step(steps)
    return median_step(steps_across(steps, np.flatnonzero(there)))


def steps_across(steps: Any, valid: np.ndarray) -> np.ndarray:
    """
    Steps between the ``valid`` rows, across the other rows.

    Parameters
    ----------
    steps : float or array, shape (rows,)
        Time since the row before, one number if even.
    valid : array of int, shape (valid,)
        Positions of the rows, ascending.

    Returns
    -------
    array, shape (valid,)
        Time since the valid row before; of the first, since the row before the record.
        [unit of ``steps``]
    """
    if np.ndim(steps) == 0 or not len(valid):
        return np.diff(valid, prepend=-1) * (steps if np.ndim(steps) == 0 else 0.0)
    first = np.concatenate(([0], valid[:-1] + 1))
    return np.add.reduceat(steps[: valid[-1] + 1], first)


def rows_of(values: Any, rows: Any) -> float | np.ndarray:
    """
    Some rows of an array; a number is returned as it is.

    Parameters
    ----------
    values : float or array, shape (rows,)
    rows : slice, array of int, or array of bool, shape (rows,)

    Returns
    -------
    float or array
    """
    return values if np.ndim(values) == 0 else values[rows]
