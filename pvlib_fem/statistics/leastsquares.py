"""Bounded nonlinear least squares on an exact Jacobian."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

STEPS = 60  # Gauss-Newton steps before it gives up
HALVINGS = 12
BESIDE = 8  # blocks of columns that are put side by side at a time
BLOCK = 200_000  # multiplications of a product below which BLAS has one thread
DONE = 1e-9  # relative step that ends it
FLAT = 1e-13  # relative fall of the cost that ends it: seven digits of x, or more
NEXT = 1e-1  # of a rougher end: what the step after an unseen one may promise


@dataclass(frozen=True)
class Minimum:
    """Where the sum of squares is least, and how the search ended."""

    x: np.ndarray
    converged: bool
    at_bound: np.ndarray  # booleans


@dataclass(frozen=True, eq=False)
class Normal:
    """Sums about a place of a search, of J the slopes and r what is left."""

    squares: float  # r'r
    normal: np.ndarray  # J'J
    gradient: np.ndarray  # J'r

    @classmethod
    def of(cls, total):
        """From the products of all slopes, and of what is left as the last."""
        return cls(float(total[-1, -1]), total[:-1, :-1], total[:-1, -1])

    def by(self, chain):
        """The same by other variables, whose slopes are mixed by a matrix."""
        normal = chain.T @ self.normal @ chain
        return Normal(self.squares, normal, chain.T @ self.gradient)

    def fall(self, step):
        """What the sum of squares loses by a step, were the slopes to stay."""
        return float(2.0 * self.gradient @ step - step @ self.normal @ step)


def normal(residual, jacobian):
    """Those sums of a residual and the matrix of its slopes."""
    return Normal.of(products([*jacobian.T, residual]))


def minimum_of(search, evaluate):
    """What a search ends with that is sent what ``evaluate`` makes of its points."""
    return minima_of({"": search}, lambda asked: {"": evaluate(asked[""])})[""]


def minima_of(searches, evaluate):
    """
    What each of several searches ends with, by its name.

    Those that have not ended are answered together: ``evaluate`` takes their points by
    name, and gives what each is sent.
    """
    found, asked = {}, {}
    answers = dict.fromkeys(searches)
    while answers:
        for name, answer in answers.items():
            try:
                asked[name] = searches[name].send(answer)
            except StopIteration as end:
                asked.pop(name, None)
                found[name] = end.value
        answers = evaluate(asked) if asked else {}
    return found


def descent(start, lower, upper, steps=STEPS, flat=FLAT):
    """
    A search for the least sum of squares, as a generator.

    It yields each place and is sent its :class:`Normal`, so that several searches can
    share a pass; :func:`minimum_of` runs one. Every step solves the bounded linear
    problem on the square root of the small normal matrix, so a long record costs one
    pass a step. The residual is measured minus modelled; the slopes are those of the
    model. ``flat`` is the relative fall of the cost that ends the search: a last step
    that promises no more than that is taken unseen.
    """
    lower, upper = np.asarray(lower, float), np.asarray(upper, float)
    x = np.clip(np.asarray(start, float), lower, upper)
    converged = not len(x)  # with nothing to vary it is there
    at = None if converged else (yield x)
    before, enough = np.inf, NEXT * flat if flat > FLAT else 0.0
    for _ in range(0 if converged else steps):
        step = bounded_step(at, lower - x, upper - x)
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
            # no shorter step is better either: at a minimum only rounding is left
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


def bounded_step(at, lower, upper):
    """Best linear step within bounds, from the scaled normal matrix."""
    scale = np.sqrt(np.diag(at.normal))
    nothing = scale == 0
    scale[nothing] = 1.0
    values, vectors = np.linalg.eigh(at.normal / np.outer(scale, scale))
    # directions that the record does not determine are left where they are
    known = values > 1e-12 * values[-1]
    root = np.sqrt(values[known])
    matrix = root[:, None] * vectors[:, known].T
    right = vectors[:, known].T @ (at.gradient / scale) / root
    low, high = lower * scale, upper * scale
    step = vectors[:, known] @ (right / root)
    step[nothing] = 0.0  # and no rounding
    if ((low <= step) & (step <= high)).all():
        return step / scale
    free = high > low
    step = np.zeros(len(scale))
    if free.any():
        bounds = (np.minimum(low, 0.0)[free], np.maximum(high, 0.0)[free])
        step[free] = lsq_linear(matrix[:, free], right, bounds, method="bvls").x
    return step / scale


def products(columns, rows=slice(None)):
    """
    Products of all columns with each other: the same bits on any number of cores.

    Block by block, each too small for BLAS to start threads, which would cost more
    than they bring on matrices this narrow, and far more on a busy machine.
    """
    start, end, _ = rows.indices(len(columns[0]))
    size = len(columns)
    total, block = np.zeros((size, size)), max(BLOCK // size**2, 8)
    for first in range(start, end, BESIDE * block):
        part = slice(first, min(first + BESIDE * block, end))
        table = np.concatenate([column[part] for column in columns]).reshape(size, -1)
        for one in np.split(table, range(block, table.shape[1], block), axis=1):
            # a product with a copy, since BLAS threads that of a matrix with itself
            total += one @ np.ascontiguousarray(one.T)
    return total
