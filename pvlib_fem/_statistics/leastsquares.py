"""Bounded nonlinear least squares on an exact Jacobian; products of columns."""

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import lsq_linear

STEPS = 60  # Gauss-Newton steps before the search gives up
MOST_TAKEN = 2.0 / 3.0  # of a positive variable in one step
HALVINGS = 12
STACKED = 8  # blocks of columns that are stacked at a time
DEPENDENT = 1e-6  # relative size of the independent part of a column that has none
BLOCK = 200_000  # multiplications of a product below which BLAS uses one thread
DONE = 1e-9  # relative step that ends the search
FLAT = 1e-13  # relative decrease of the cost that ends it: seven digits of x, or more
NEXT = 1e-1  # share of ``flat`` that the step after a last unevaluated one may promise


@dataclass(frozen=True)
class Minimum:
    """Place of the least sum of squares, and the state at the end of the search."""

    x: np.ndarray
    converged: bool
    at_bound: np.ndarray  # booleans


@dataclass(frozen=True, eq=False)
class Normal:
    """Sums at a place of a search; J is the Jacobian and r the residual."""

    squares: float  # r'r
    normal: np.ndarray  # J'J
    gradient: np.ndarray  # J'r

    @classmethod
    def from_products(cls, total: np.ndarray) -> "Normal":
        """From the products of all slopes and, last, the residual."""
        return cls(float(total[-1, -1]), total[:-1, :-1], total[:-1, -1])

    def by(self, chain: np.ndarray) -> "Normal":
        """The sums for other variables, by the matrix of the chain rule."""
        normal = chain.T @ self.normal @ chain
        return Normal(self.squares, normal, chain.T @ self.gradient)

    def fall(self, step: np.ndarray) -> float:
        """Decrease of the sum of squares by a step, to first order."""
        return float(2.0 * self.gradient @ step - step @ self.normal @ step)


def minima_of(searches: dict, evaluate: Callable) -> dict:
    """
    Run several searches to their ends.

    Parameters
    ----------
    searches : dict of generator
        Searches by name, see :func:`descent`.
    evaluate : callable
        Takes the points of all searches that have not ended, a dict of array, and
        returns the :class:`Normal` of each, by the same names.

    Returns
    -------
    dict of Minimum
        By the name of the search.
    """
    minima, points = {}, {}
    answers = dict.fromkeys(searches)
    while answers:
        for name, answer in answers.items():
            try:
                points[name] = searches[name].send(answer)
            except StopIteration as end:
                points.pop(name, None)
                minima[name] = end.value
        answers = evaluate(points) if points else {}
    return minima


def descent(
    start: Sequence | np.ndarray,
    lower: Sequence | np.ndarray,
    upper: Sequence | np.ndarray,
    steps: int = STEPS,
    flat: float = FLAT,
    positive: Sequence | np.ndarray = (),
) -> Generator[np.ndarray, Normal, Minimum]:
    """
    Search for the least sum of squares, as a generator.

    It yields each place, and the caller sends its :class:`Normal`. So several searches
    can share a pass, see :func:`minima_of`. Every step solves the bounded linear
    problem on the square root of the small normal matrix, so a step costs one pass over
    the record. The residual is measured minus modelled; the slopes are those of the
    model.

    Parameters
    ----------
    start : sequence of float, length variables
        First place, in the unit of each variable; it is moved into the bounds.
    lower, upper : sequence of float, length variables
        Bounds.
    steps : int, default 60
        Most steps of the search.
    flat : float, default 1e-13
        Relative decrease of the sum of squares that ends the search. A last step that
        promises no more than that is taken without evaluation.
    positive : sequence of bool, length variables, optional
        Variables of which a step takes two thirds at most, since nothing has a slope
        by what is nearly 0.

    Returns
    -------
    Minimum
        At the end of the search.

    Yields
    ------
    array, shape (variables,)
        Place to evaluate.

    Receives
    --------
    Normal
        Sums of the residual and its slopes there.
    """
    lower, upper = np.asarray(lower, float), np.asarray(upper, float)
    x = np.clip(np.asarray(start, float), lower, upper)
    converged = not len(x)  # nothing varies
    at: Any = None if converged else (yield x)
    before, enough = np.inf, NEXT * flat if flat > FLAT else 0.0
    for _ in range(0 if converged else steps):
        down = lower - x
        if len(positive):
            down = np.where(positive, np.maximum(down, -MOST_TAKEN * x), down)
        step = bounded_step(at, down, upper - x)
        fall = at.fall(step) / max(at.squares, np.finfo(float).tiny)
        next_fall = fall * fall / before if np.isfinite(before) else np.inf
        if 0.0 <= fall <= flat or 0.0 <= next_fall < enough:
            x, converged = np.clip(x + step, lower, upper), True
            break
        before = fall
        for halving in range(HALVINGS):
            new = np.clip(x + step / 2**halving, lower, upper)
            there = yield new
            if there.squares <= at.squares:
                break
        else:
            # no shorter step is better: at a minimum the difference is rounding
            converged = there.squares <= at.squares * (1.0 + DONE)
            break
        small = np.abs(new - x) <= DONE * (np.abs(x) + 1e-3 * (upper - lower))
        converged = small.all() or at.squares - there.squares <= flat * at.squares
        x, at = new, there
        if converged:
            break
    margin = 1e-6 * (upper - lower)
    at_bound = (x <= lower + margin) | (x >= upper - margin)
    return Minimum(x, bool(converged), at_bound)


def bounded_step(at: Normal, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Best linear step within bounds, from the scaled normal matrix."""
    scale = np.sqrt(np.diag(at.normal))
    nothing = scale == 0
    scale[nothing] = 1.0
    values, vectors = np.linalg.eigh(at.normal / np.outer(scale, scale))
    # the step has no component in undetermined directions
    known = values > 1e-12 * values[-1]
    root = np.sqrt(values[known])
    matrix = root[:, None] * vectors[:, known].T
    right = vectors[:, known].T @ (at.gradient / scale) / root
    low, high = lower * scale, upper * scale
    step = vectors[:, known] @ (right / root)
    step[nothing] = 0.0  # exactly
    if ((low <= step) & (step <= high)).all():
        return step / scale
    free = high > low
    step = np.zeros(len(scale))
    if free.any():
        bounds = (np.minimum(low, 0.0)[free], np.maximum(high, 0.0)[free])
        step[free] = lsq_linear(matrix[:, free], right, bounds, method="bvls").x
    return step / scale


def products(columns: list, rows: Any = slice(None)) -> np.ndarray:
    """
    Products of all pairs of columns, with the same bits on any number of cores.

    The blocks are so small that BLAS starts no threads. On such narrow matrices threads
    would cost more time than they save, most of all on a busy machine.

    Parameters
    ----------
    columns : list of array, shape (rows,)
        Columns of equal length.
    rows : slice, optional
        Rows to sum over; by default all.

    Returns
    -------
    array, shape (columns, columns)
    """
    start, end, _ = rows.indices(len(columns[0]))
    size = len(columns)
    total, block = np.zeros((size, size)), max(BLOCK // size**2, 8)
    for first in range(start, end, STACKED * block):
        part = slice(first, min(first + STACKED * block, end))
        table = np.concatenate([column[part] for column in columns]).reshape(size, -1)
        for one in np.split(table, range(block, table.shape[1], block), axis=1):
            # multiply by a copy: BLAS uses threads for a matrix times itself
            total += one @ np.ascontiguousarray(one.T)
    return total


def orthonormal(columns: list, rows: Any = slice(None)) -> np.ndarray:
    """
    Some rows of an orthonormal basis of the span of columns.

    Parameters
    ----------
    columns : list of array, shape (all rows,)
    rows : slice or array of int, optional
        Rows to return, by default all. The columns are orthonormal over all rows.

    Returns
    -------
    array, shape (rows, rank)
        Columns that depend on others within rounding errors add none.
    """
    # from the small matrix of their products, in one pass over the rows
    total = products(columns)
    sizes = np.sqrt(np.diag(total))
    there = np.flatnonzero(sizes > 0)
    total = total[np.ix_(there, there)] / np.outer(sizes[there], sizes[there])
    squares, turns = np.linalg.eigh(total)
    kept = squares > DEPENDENT**2 * squares[-1]
    some = np.array([columns[place][rows] for place in there])
    some /= sizes[there][:, None]
    return ((turns[:, kept] / np.sqrt(squares[kept])).T @ some).T
