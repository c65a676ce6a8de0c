"""Rows in which a logger wrote 0 into all columns."""

from collections.abc import Callable, Sequence

import numpy as np

from pvlib_fem._record.clean import CleanRecord
from pvlib_fem.quality._limits import POSSIBLE


def all_zero_rows(
    clean: CleanRecord, names: Sequence[str], margin: Callable[[str], float]
) -> tuple[np.ndarray, np.ndarray]:
    """
    Rows of exactly 0 in all of the usual columns, to which no temperature leads.

    On a calm night at 0 °C a coarse logger measures them. Then both temperatures are
    near 0 before them, or after.

    Parameters
    ----------
    clean : CleanRecord
        With all of the usual columns. A missing value does not speak against a row, as
        long as one of both temperatures is 0.
    names : sequence of str
        Of both temperatures.
    margin : callable
        Of a name: how far from 0 the temperature may be in the row before, or after.
        [K]

    Returns
    -------
    rows, times : numpy.ndarray of int, shape (rows,)
        Numbers of the rows, and counts of the index's unit since 1970.
    """
    parts = []
    for block in clean.blocks(tuple(POSSIBLE)):
        zero = np.any([block[name] == 0 for name in names], axis=0)
        if zero.any():
            for name in POSSIBLE:
                zero &= (block[name] == 0) | np.isnan(block[name])
        near = zero.copy()
        near[1:] |= zero[:-1]
        near[:-1] |= zero[1:]
        near[[0, -1]] = True  # next to rows of another block
        some = np.flatnonzero(near)
        temps = [np.abs(block[name][some]) for name in names]
        parts.append((some + block.start, block.times[some], zero[some], *temps))
    rows, times, zero, *temps = map(np.concatenate, zip(*parts))
    if not zero.any():
        return rows[zero], times[zero]
    edges = np.flatnonzero(np.diff(zero, prepend=False, append=False))
    first, end = edges[::2], edges[1::2]
    away = np.zeros(len(first), dtype=bool)
    for name, temp in zip(names, temps):
        around = np.concatenate([[np.nan], temp, [np.nan]])
        away |= np.fmin(around[first], around[end + 1]) > margin(name)
    kept = np.repeat(away, end - first)
    return rows[zero][kept], times[zero][kept]
