"""Columns that say nothing between times further apart than the record's rows."""

from collections.abc import Iterator
from itertools import product

import numpy as np

from pvlib_fem._record.inputs import Inputs
from pvlib_fem.quality._values import changes

COLUMNS = (
    "poa_global",
    "temp_air",
    "wind_speed",
    "relative_humidity",
    "longwave_down",
    "wind_direction",
)
PERIODS = (6.0 * 3600.0, 3.0 * 3600.0, 3600.0, 1800.0)  # s
FEWEST_ROWS = 3  # in each of them
FEWEST = 20  # periods from which to the next the column moves
MOST = 20.0 * 86400.0  # s of a record that are looked at
SHARE = 0.99  # of the rows that follow the ends of their period


def interpolated_columns(inputs: Inputs) -> Iterator[str]:
    """
    Report columns whose values are further apart than the rows.

    Such a column keeps a value for 30 min to 6 h, or is a straight line between
    values that far apart. The first 20 days are tested.

    Parameters
    ----------
    inputs : Inputs
        The record's columns; those without an entry in ``COLUMNS`` are not tested.

    Yields
    ------
    str
        A sentence for each column.
    """
    step = inputs.step
    if not step > 0:
        return
    rows = slice(0, int(np.searchsorted(inputs.seconds, MOST)))
    seconds = inputs.seconds[rows]
    periods = [period for period in PERIODS if period >= FEWEST_ROWS * step]
    for name in (name for name in COLUMNS if name in inputs.columns):
        if filling := filling_of(inputs[name][rows], seconds, step, periods):
            words, period = filling
            yield (
                f"{name} {words.format(period / 60)}, and rows are {step / 60:.2g} "
                "min apart: what it does in between is not in the record; give "
                "that of a sensor at the site, or means over that time"
            )


def filling_of(
    values: np.ndarray, seconds: np.ndarray, step: float, periods: list
) -> tuple[str, float] | None:
    """How a column is filled between values a period apart, in words, and which one."""
    there = np.isfinite(values)
    values, seconds = values[there], seconds[there]
    if len(values) < FEWEST * FEWEST_ROWS:
        return None
    least = changes(values).min(initial=np.inf)
    fine = 1.02 * least + 1e-6 * np.ptp(values)  # both ends are rounded
    change = np.abs(np.diff(values, prepend=values[0]))
    bend = np.abs(np.diff(values, n=2, prepend=values[0], append=values[-1]))
    forms = [
        ("keeps a value for {:.0f} min", change, constant_between),
        ("is a straight line between values {:.0f} min apart", bend, straight_between),
    ]
    still = {words: np.mean(ends <= 2.0 * fine) for words, ends, _ in forms}
    for period, (words, ends, between_knots) in product(periods, forms):
        if still[words] < SHARE * (1.0 - 2.0 * step / period):
            continue
        knots = ends_of_periods(seconds, ends, step, period)
        moves = np.abs(np.diff(values[knots])) > 3.0 * fine
        if np.count_nonzero(moves) < FEWEST:
            continue
        apart = np.abs(values - between_knots(values, seconds, knots))
        if np.mean(apart <= fine) >= SHARE:
            return words, period
    return None


def constant_between(
    values: np.ndarray, seconds: np.ndarray, knots: np.ndarray
) -> np.ndarray:
    """Values that stay from each knot to the next."""
    return values[knots][np.searchsorted(knots, np.arange(len(values)), "right") - 1]


def straight_between(
    values: np.ndarray, seconds: np.ndarray, knots: np.ndarray
) -> np.ndarray:
    """Values on straight lines from each knot to the next."""
    return np.interp(seconds, seconds[knots], values[knots])


def ends_of_periods(
    seconds: np.ndarray, ends: np.ndarray, step: float, period: float
) -> np.ndarray:
    """Rows at which a period ends: where within it most changes, or bends."""
    phase = np.rint(seconds % period / step).astype(int)
    first = np.argmax(np.bincount(phase, ends)) * step
    number = np.floor((seconds - first) / period + 0.5 * step / period)
    return np.flatnonzero(np.diff(number, prepend=number[0] - 1.0))
