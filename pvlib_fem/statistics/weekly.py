"""Least squares of a few columns from sums of their products by the week."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

RIDGE = 1e-9  # of a column's square: what a record does not determine stays 0
MOST_MEMORY = 0.9  # from one week to the next; more cannot be told from a trend


def products(cells, rows, ends):
    """Sums of products of all columns between each end and the next."""
    weighted = cells * np.sqrt(rows)[:, None]
    size = cells.shape[1]
    found = np.empty((len(ends) - 1, size, size))
    for i, (low, high) in enumerate(pairwise(ends)):
        part = weighted[low:high]
        np.matmul(part.T, part, out=found[i])
    return found


@dataclass(frozen=True, eq=False)
class LeastSquares:
    """
    Least squares of some columns, with errors by the week.

    ``weekly`` has products by the week, of the residual first and the last ``size``
    columns as those that are asked about.
    """

    weekly: np.ndarray
    size: int

    @cached_property
    def whole(self):
        return self.weekly.sum(axis=0)

    @cached_property
    def solved(self):
        """All coefficients."""
        return solve(self.whole)

    @property
    def estimate(self):
        return self.solved[-self.size :]

    @cached_property
    def shifts(self):
        """By how much the estimate moves when each week is left out."""
        left = self.whole - self.weekly
        scores = self.weekly[:, 1:, 0] - self.weekly[:, 1:, 1:] @ self.solved
        found = np.linalg.solve(steady(left[:, 1:, 1:]), scores[..., None])[..., 0]
        return -found[:, -self.size :]

    @cached_property
    def covariance(self):
        """Of the estimate, by the jackknife over weeks and their memory."""
        shifts, weeks = self.shifts - self.shifts.mean(axis=0), len(self.weekly)
        # collinear columns shift together
        plain = steady((weeks - 1) / weeks * shifts.T @ shifts)
        along = shifts @ np.linalg.solve(plain, self.estimate)
        memory = 0.0
        if weeks > 3 and along @ along > 0:
            memory = float(along[1:] @ along[:-1] / (along @ along))
        memory = min(max(memory, 0.0), MOST_MEMORY)
        return plain * (1.0 + memory) / (1.0 - memory)

    @cached_property
    def freedom(self):
        """Effective number of weeks that tell of it, less one."""
        beside = np.linalg.solve(
            steady(self.whole[1:, 1:])[: -self.size, : -self.size],
            self.whole[1 : -self.size, -self.size :],
        )
        mix = np.vstack([-beside, np.eye(self.size)])
        told = np.einsum("iq,wij,jq->w", mix, self.weekly[:, 1:, 1:], mix)
        told = np.maximum(told, 0.0)
        many = told.sum() ** 2 / max((told**2).sum(), 1e-300)
        return max(many - 1.0, 1.0)


def solve(whole):
    """Coefficients by sums of products of which the first row is the residual's."""
    return np.linalg.solve(steady(whole[..., 1:, 1:]), whole[..., 1:, 0, None])[..., 0]


def steady(squares):
    """Products of which those that the record does not determine stay 0."""
    diagonal = np.abs(np.einsum("...ii->...i", squares))
    ridge = RIDGE * (diagonal + 1e-3 * diagonal.max(axis=-1, keepdims=True)) + 1e-30
    return squares + ridge[..., None] * np.eye(squares.shape[-1])


def fall(whole, size):
    """Fall of the sum of squares by the last columns, from sums of products."""
    return left(whole[..., : -size or None, : -size or None]) - left(whole)


def left(whole):
    """Sum of squares that some columns leave."""
    found = solve(whole)
    return whole[..., 0, 0] - np.einsum("...i,...i->...", found, whole[..., 1:, 0])


def alike(whole, size, rival):
    """
    Share of the part that some columns explain which the last ones would explain.

    Parameters
    ----------
    whole : array
        Sums of products of the residual, columns that are given, ``size`` columns, and
        the ``rival`` last ones.
    """
    own = whole.shape[-1] - 1 - size - rival
    squares = steady(whole[..., 1:, 1:])
    cross = squares[..., :own, own:]
    beside = np.linalg.solve(squares[..., :own, :own], cross)
    beyond = squares[..., own:, own:] - np.swapaxes(cross, -1, -2) @ beside
    scores = whole[..., 1 + own :, 0]
    scores = scores - np.einsum("...gi,...g->...i", beside, whole[..., 1 : 1 + own, 0])
    mine, theirs = beyond[..., :size, :size], beyond[..., size:, size:]
    found = np.linalg.solve(mine, scores[..., :size, None])
    seen = beyond[..., size:, :size] @ found
    explained = (seen * np.linalg.solve(theirs, seen)).sum(axis=(-2, -1))
    return explained / np.maximum((found * (mine @ found)).sum(axis=(-2, -1)), 1e-300)


def held_out(weekly, folds):
    """Sum of squares on groups of weeks that are left out in turn."""
    parts = np.einsum("fw,wij->fij", folds, weekly)
    found = solve(parts.sum(axis=0) - parts)
    crossed = np.einsum("fi,fi->f", found, parts[:, 1:, 0])
    squared = np.einsum("fi,fij,fj->f", found, parts[:, 1:, 1:], found)
    return float((parts[:, 0, 0] - 2.0 * crossed + squared).sum())
