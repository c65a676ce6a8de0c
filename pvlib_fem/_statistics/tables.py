"""
Tables of the remaining error as random effects: unexplained but repeatable patterns.

Each cell of a table, such as an hour of a month, has a mean of its own. The variance
between cells is estimated from products of different weeks in the same cell, so an
error of one week alone does not contribute.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

PAIR_GAIN = 1.2  # least ratio of the variance of a table of two axes to one of one
SURE = 3.0  # least ratio of a variance to its standard error
STRONG_CELL = 0.5  # share of the largest mean above which a cell is strong
PLACE_SHARE = 0.92  # share of the squares of strong cells in the reported range


@dataclass(frozen=True, eq=False)
class Table:
    """A random effect of the remaining error."""

    axes: tuple  # one or two
    groups: np.ndarray = field(repr=False)  # cell of each value
    variance: float  # between the cells [K²]
    errors: float  # ratio of the variance to its standard error [-]
    means: np.ndarray = field(repr=False)  # of each cell [K]
    shares: np.ndarray = field(repr=False)  # shrinkage factor of each mean [-]
    rows: np.ndarray = field(repr=False)  # number of each cell

    @property
    def values(self) -> np.ndarray:
        """Best linear prediction of each value. [K]"""
        return (self.shares * self.means)[self.groups]

    @property
    def free(self) -> np.ndarray:
        """Share of the mean of each cell that whitening removes."""
        return 1.0 - np.sqrt(1.0 - self.shares)

    @property
    def gain(self) -> float:
        """Standard deviation between cells: the error that the table explains. [K]"""
        return float(np.sqrt(self.variance))

    @cached_property
    def top(self) -> np.ndarray:
        """Mask of the strong cells that have the prevailing sign."""
        means, rows = self.shares * self.means, self.rows
        strong = np.abs(means) >= STRONG_CELL * np.abs(means).max()
        squares = np.where(strong, means**2 * rows, 0.0)
        return strong & ((means > 0) == (squares @ np.sign(means) >= 0))

    @property
    def size(self) -> float:
        """Mean remaining error where it is strongest. [K]"""
        top = self.rows * self.top
        return float(top @ self.means / max(top.sum(), 1.0))

    def along_axes(self, cells: np.ndarray) -> list[np.ndarray]:
        """Sums of a value of each cell by the bins of each axis."""
        table = cells.reshape([len(axis.labels) for axis in self.axes])
        places = range(table.ndim)
        return [table.sum(axis=tuple(j for j in places if j != i)) for i in places]

    @cached_property
    def runs(self) -> list[np.ndarray]:
        """Bins of the strongest cells along each axis."""
        # a temporary error leaves a residual of the other sign elsewhere
        squares = np.where(self.top, (self.shares * self.means) ** 2 * self.rows, 0.0)
        return [
            axis.strongest(along, PLACE_SHARE)
            for axis, along in zip(self.axes, self.along_axes(squares))
        ]

    @property
    def drivers(self) -> tuple[str, ...]:
        return tuple(axis.name for axis in self.axes)

    @property
    def name(self) -> str:
        return " × ".join(self.drivers)

    @property
    def ranges(self) -> dict:
        """From and to, by driver."""
        return {axis.name: axis.ends(run) for axis, run in zip(self.axes, self.runs)}

    @property
    def where(self) -> str:
        """The ranges in words, without those of all rows."""
        words = [
            axis.words(run)
            for axis, run, rows in zip(self.axes, self.runs, self.along_axes(self.rows))
            if np.delete(rows, run).any()
        ]
        if len(words) == 2 and all(one.startswith("where ") for one in words):
            words = [f"{words[0]}, and", words[1].removeprefix("where ")]
        return " ".join(words) or f"spread over {' and '.join(self.drivers)}"


@dataclass(frozen=True, eq=False)
class Cells:
    """Cells of some axes by week, for the tables of many remaining errors."""

    axes: tuple
    place: np.ndarray = field(repr=False)  # week and cell of each value as one number
    rows: np.ndarray = field(repr=False)  # number behind each value
    number: np.ndarray = field(repr=False)  # of rows in each cell
    squares: np.ndarray = field(repr=False)  # of that in each week, summed over weeks
    weeks: int  # number of weeks

    @classmethod
    def from_axes(cls, axes: tuple, rows: np.ndarray, weeks: np.ndarray) -> "Cells":
        """Cells of axes; each value, in order of time, has its rows and its week."""
        groups, count = cell_numbers(axes)
        size = int(weeks[-1]) + 1
        place = (weeks * count + groups).astype(np.int32)
        held = np.bincount(place, rows, size * count).reshape(-1, count)
        squares = np.square(held).sum(axis=0)
        return cls(tuple(axes), place, rows, held.sum(axis=0), squares, size)

    def table(self, rest: np.ndarray) -> Table:
        """The table of a remaining error, in order of time. [K]"""
        rows, number, count = self.rows, self.number, len(self.number)
        rest = rest - rest @ rows / rows.sum()
        sums = np.bincount(self.place, rest * rows, self.weeks * count)
        sums = sums.reshape(-1, count)
        # mean product of two weeks per cell, weighted by the cell's share of rows
        alike = number**2 - self.squares
        weight = number / number.sum() / np.where(alike > 0, alike, np.inf)
        shared = (sums * weight) @ sums.T
        crossed = shared.sum() - np.trace(shared)
        spread = np.square(shared).sum() - np.square(np.diag(shared)).sum()
        variance = max(crossed, 0.0)
        errors = crossed / np.sqrt(2.0 * spread) if spread > 0 else 0.0
        noise = np.square(sums).sum() - variance * self.squares.sum()
        noise = max(noise / number.sum(), 1e-12)
        shares = variance * number / (variance * number + noise)
        means = sums.sum(axis=0) / np.maximum(number, 1.0)
        groups = self.place % count
        return Table(
            self.axes, groups, float(variance), float(errors), means, shares, number
        )


def cell_numbers(axes: tuple) -> tuple[np.ndarray, int]:
    """
    Number of each value's cell on one or two axes, and the number of cells.

    Parameters
    ----------
    axes : tuple of Axis
        One or two axes of the same values.

    Returns
    -------
    groups : array of int, shape (values,)
        The second axis varies fastest.
    count : int
        Number of cells, also of empty ones.
    """
    if len(axes) == 1:
        return axes[0].bins, len(axes[0].labels)
    one, two = axes
    wide = len(two.labels)
    return one.bins * wide + two.bins, len(one.labels) * wide


def largest_table(kinds: list[Cells], rest: np.ndarray, least: float) -> Table | None:
    """
    The table with the largest significant and material variance.

    A table of two axes must have clearly more variance than the best of one axis,
    because it always contains that.

    Parameters
    ----------
    kinds : list of Cells
        Cells of the tables to compare.
    rest : array, shape (values,)
        Remaining error, in order of time. [K]
    least : float
        Least variance between cells that is material. [K²]

    Returns
    -------
    Table or None
        None if no table is significant and material.
    """
    best: dict[int, Table] = {}
    for cells in kinds:
        table, size = cells.table(rest), len(cells.axes)
        beaten = size in best and best[size].variance >= table.variance
        if table.errors >= SURE and table.variance >= least and not beaten:
            best[size] = table
    one, two = best.get(1), best.get(2)
    if one is None or two is None:
        return one or two
    return two if two.variance > PAIR_GAIN * one.variance else one
