"""Bounded nonlinear least squares on an exact Jacobian."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

STEPS = 60  # Gauss-Newton steps before it gives up
HALVINGS = 12
BLOCK = 200_000  # multiplications of a product below which BLAS has one thread
DONE = 1e-9  # relative step that ends it
FLAT = 1e-10  # relative fall of the cost that ends it: far below any error of x


@dataclass(frozen=True)
class Minimum:
    """Where the sum of squares is least, and how the search ended."""

    x: np.ndarray
    converged: bool
    at_bound: np.ndarray  # booleans


def gauss_newton(evaluate, start, lower, upper, steps=STEPS, flat=FLAT):
    """
    Minimise the sum of squares of ``evaluate(x) -> (residual, jacobian)``.

    Every step solves the bounded linear problem on the square root of the
    small normal matrix, so a long record costs one pass a step. The residual
    is measured minus modelled; the Jacobian that of the model, a matrix or a
    function that makes its columns, called only where a step begins. ``flat`` is
    the relative fall of the cost that ends the search.
    """
    lower, upper = np.asarray(lower, float), np.asarray(upper, float)
    x = np.clip(np.asarray(start, float), lower, upper)
    residual, jacobian = evaluate(x)
    cost = squares(residual)
    converged = not len(x)  # with nothing to vary it is there
    for _ in range(0 if converged else steps):
        step = bounded_step(jacobian, residual, lower - x, upper - x)
        for halving in range(HALVINGS):
            new = np.clip(x + step / 2**halving, lower, upper)
            new_residual, new_jacobian = evaluate(new)
            new_cost = squares(new_residual)
            if new_cost <= cost:
                break
        else:
            # no shorter step is better either: at a minimum only rounding is left
            converged = new_cost <= cost * (1.0 + DONE)
            break
        small = np.abs(new - x) <= DONE * (np.abs(x) + 1e-3 * (upper - lower))
        converged = small.all() or cost - new_cost <= flat * cost
        x, residual, jacobian, cost = new, new_residual, new_jacobian, new_cost
        if converged:
            break
    margin = 1e-6 * (upper - lower)
    at_bound = (x <= lower + margin) | (x >= upper - margin)
    return Minimum(x, bool(converged), at_bound)


def bounded_step(jacobian, residual, lower, upper):
    """Best linear step within bounds, from the scaled normal matrix."""
    if callable(jacobian):
        jacobian = jacobian()
    normal, gradient = normal_equations(jacobian, residual)
    scale = np.sqrt(np.diag(normal))
    scale[scale == 0] = 1.0
    values, vectors = np.linalg.eigh(normal / np.outer(scale, scale))
    # directions that the record does not determine are left where they are
    known = values > 1e-12 * values[-1]
    root = np.sqrt(values[known])
    matrix = root[:, None] * vectors[:, known].T
    right = vectors[:, known].T @ (gradient / scale) / root
    low, high = lower * scale, upper * scale
    free = high > low
    step = np.zeros(len(scale))
    if free.any():
        bounds = (np.minimum(low, 0.0)[free], np.maximum(high, 0.0)[free])
        step[free] = lsq_linear(matrix[:, free], right, bounds, method="bvls").x
    return step / scale


def squares(residual):
    return np.einsum("i,i->", residual, residual)


def normal_equations(jacobian, residual):
    """J'J and J'r of a matrix or of columns."""
    columns = list(jacobian.T) if isinstance(jacobian, np.ndarray) else jacobian
    both = products([*columns, residual])
    return both[:-1, :-1], both[:-1, -1]


def products(columns, rows=slice(None)):
    """
    Products of all columns with each other: the same bits on any number of cores.

    Block by block, each too small for BLAS to start threads, which would cost more
    than they bring on matrices this narrow, and far more on a busy machine.
    """
    start, end, _ = rows.indices(len(columns[0]))
    size = len(columns)
    total, block = np.zeros((size, size)), max(BLOCK // size**2, 8)
    for first in range(start, end, block):
        part = slice(first, min(first + block, end))
        one = np.stack([column[part] for column in columns])
        # a product with a copy, since BLAS threads that of a matrix with itself
        total += one @ np.ascontiguousarray(one.T)
    return total
