"""Masks and steps of blocks that serve all passes over files, and sums of one pass."""

from collections import Counter
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from pvlib_fem._record.filters import counted
from pvlib_fem._record.inputs import Inputs
from pvlib_fem._record.parquet import Block
from pvlib_fem._relaxation import steps_across
from pvlib_fem.quality._file_scan import count_steps, median

OTHERS = 0.02  # largest share of unusual steps in a block that is stored sparsely


@dataclass(frozen=True, eq=False)
class BlockRows:
    """Masks, dates and steps of a block, packed, for every pass."""

    complete: np.ndarray  # rows with all four columns, as bits
    counts: np.ndarray  # rows whose residual counts, as bits
    days: np.ndarray
    rows: np.ndarray  # number of rows per day
    steps: tuple | None  # usual step, places and values of others; None if too many

    @classmethod
    def from_masks(
        cls, complete: np.ndarray, counts: np.ndarray, dates: np.ndarray, steps: Any
    ) -> "BlockRows":
        edges = np.flatnonzero(np.diff(dates)) + 1
        days, rows = dates[[0, *edges]], np.diff([0, *edges, len(dates)])
        usual = float(np.median(steps))
        others = np.flatnonzero(np.broadcast_to(steps, len(dates)) != usual)
        sparse = None
        if len(others) <= OTHERS * len(dates):
            sparse = usual, others, steps[others] if len(others) else others
        return cls(np.packbits(complete), np.packbits(counts), days, rows, sparse)

    def steps_of(self, rows: int) -> float | np.ndarray:
        """Steps of the rows, or one even step."""
        usual, others, values = self.steps
        if not len(others):
            return usual
        steps = np.full(rows, usual)
        steps[others] = values
        return steps

    def masks(self, rows: int) -> tuple:
        """Masks of complete rows and of rows that count, and the dates of the rows."""
        bits = (np.unpackbits(b, count=rows) for b in (self.complete, self.counts))
        return *(b.view(bool) for b in bits), np.repeat(self.days, self.rows)


@dataclass(eq=False)
class Gaps:
    """Running histogram of the steps between rows that have some columns."""

    steps: Counter = field(default_factory=Counter)
    since: float = 0.0
    begun: bool = False

    def add(self, columns: list, steps: np.ndarray) -> None:
        there = np.flatnonzero(np.isfinite(sum(columns)))
        if not len(there):
            self.since += steps.sum()
            return
        between = steps_across(steps, there)
        between[0] += self.since
        self.since = steps[there[-1] + 1 :].sum()
        count_steps(self.steps, between[0 if self.begun else 1 :])
        self.begun = True

    @property
    def usual(self) -> float:
        return median(self.steps) if self.steps else 0.0


def rows_that_count(block: Block, night: bool, drivers: tuple) -> np.ndarray:
    """
    Mask of the rows whose residual counts.

    Parameters
    ----------
    block : Block
        With the usual four columns and the drivers.
    night : bool
        Whether night rows count, too.
    drivers : tuple of str
        Columns that must have a value, in addition to the usual four.

    Returns
    -------
    numpy.ndarray of bool, shape (rows,)
        Of the rows of the block.
    """
    rows = np.array(counted(block.inputs.columns, night))
    for name in drivers:
        rows &= np.isfinite(block[name])
    return rows


def by_day(
    table: dict,
    dates: np.ndarray,
    rows: np.ndarray,
    light: np.ndarray,
    wind: np.ndarray,
) -> None:
    """
    Add rows that count, and sums of their irradiance and wind, to daily totals.

    Parameters
    ----------
    table : dict of numpy.ndarray, shape (4,)
        By date: number of rows, and sums of ``light``, ``light * wind`` and
        ``light * wind**2``; changed in place. Days without rows that count have 0.
    dates : numpy.ndarray of int, shape (rows,)
        Days since 1970-01-01, in order.
    rows : numpy.ndarray of bool, shape (rows,)
        Rows that count.
    light : numpy.ndarray, shape (rows,)
        Irradiance squared. [W²/m⁴]
    wind : numpy.ndarray, shape (rows,)
        Wind speed. [m/s]
    """
    place, size = dates - dates[0], int(dates[-1] - dates[0]) + 1
    there = np.bincount(place, minlength=size)
    place, light, wind = place[rows], light[rows], wind[rows]
    weights = None, light, light * wind, light * wind**2
    sums = np.stack([np.bincount(place, weight, size) for weight in weights])
    for day in np.flatnonzero(there):
        date = int(dates[0] + day)
        table[date] = table.get(date, 0.0) + sums[:, day]


def with_even_steps(block: Block) -> Inputs:
    """
    Inputs of a block; equal steps become one number.

    Parameters
    ----------
    block : Block
        Its steps are integers, shape (rows,).

    Returns
    -------
    Inputs
        ``steps`` is a float, or an array of shape (rows,), in the same unit. The first
        row of the record has the step of the second.
    """
    steps = block.inputs.steps.astype(float)
    if block.start == 0 and len(steps) > 1:
        steps[0] = steps[1]  # the first row has no row before it
    if len(steps) and steps.min() == steps.max() and steps[0] > 0:
        return replace(block.inputs, steps=float(steps[0]))
    return replace(block.inputs, steps=steps)
