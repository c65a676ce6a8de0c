"""
Least squares of any columns from one pass over a record.

The products of all columns are summed per day. From these small matrices follow
solutions for subsets of columns, cross-validation over folds of days, and errors
clustered by week.
"""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
from scipy.sparse import csr_array

from pvlib_fem._statistics.leastsquares import BLOCK, products

FOLDS = 5
WEEK = 7  # days that stay together in a fold
FEWEST_CLUSTERS = 8  # with fewer weeks, errors are clustered by day
FEWEST_DAYS = 5  # with fewer days, the spread between days gives no error
AT_ONCE = 1 << 12  # rows of short days whose products are computed together
RIDGE = 1e-9  # of a column's square: an undetermined coefficient stays 0


@dataclass(frozen=True, eq=False)
class ClusterSums:
    """
    Daily sums of products of columns; the last column is the residual.

    Columns are scaled to a mean square of 1; ``scale`` reverses that.
    """

    sums: np.ndarray  # days, columns + 1, columns + 1
    scale: np.ndarray
    rows: int
    folds: np.ndarray  # of each day
    weeks: np.ndarray  # of each day, in order
    dates: np.ndarray  # of each day, from 1970-01-01
    fewest: int = FEWEST_CLUSTERS

    @property
    def days(self) -> int:
        return len(self.sums)

    @cached_property
    def whole(self) -> np.ndarray:
        return self.sums.sum(axis=0)

    @cached_property
    def by_fold(self) -> np.ndarray:
        folds = np.unique(self.folds)
        return np.array([self.sums[self.folds == n].sum(axis=0) for n in folds])

    @cached_property
    def clusters(self) -> np.ndarray:
        """First day of each cluster: a week with its weather, or a day if few weeks."""
        weeks, first = np.unique(self.weeks, return_index=True)
        return np.arange(self.days) if len(weeks) < self.fewest else first

    @cached_property
    def by_cluster(self) -> np.ndarray:
        """Sums per cluster."""
        if len(self.clusters) == self.days:
            return self.sums
        # three times as fast as np.add.reduceat
        ends, days = np.append(self.clusters, self.days), np.arange(self.days)
        weeks = csr_array((np.ones(self.days), days, ends))
        sums = weeks @ self.sums.reshape(self.days, -1)
        return sums.reshape(-1, *self.sums.shape[1:])

    def of_columns(self, kept: list | np.ndarray) -> "ClusterSums":
        """Sums of some columns and the residual."""
        sums = submatrices(self.sums, [*kept, self.sums.shape[1] - 1])
        return replace(self, sums=sums, scale=self.scale[kept])

    def on(self, days: np.ndarray) -> "ClusterSums":
        """Sums of some days, by their places."""
        picked = {name: getattr(self, name)[days] for name in ("folds", "weeks")}
        return replace(self, sums=self.sums[days], **picked)

    def solve(self, kept: list) -> np.ndarray:
        """Best coefficients of the kept columns."""
        return ridged(self.whole[kept][:, kept], self.whole[kept, -1])

    @cached_property
    def validated(self) -> dict:
        """Cache of :meth:`cross_validated`, by the kept columns."""
        return {}

    def cross_validated(self, kept: Any) -> float:
        """Cross-validated mean square of the residual with the kept columns."""
        kept = tuple(kept)
        if kept not in self.validated:  # many candidates share the other columns
            self.validated[kept] = self.losses(list(kept), self.by_fold) / self.rows
        return self.validated[kept]

    def losses(self, kept: list, parts: np.ndarray) -> float:
        """Residual sum of squares over the parts, each by a solution of the others."""
        parts = submatrices(parts, [*kept, -1])
        rest = submatrices(self.whole[None], [*kept, -1]) - parts
        solutions = ridged(rest[:, :-1, :-1], rest[:, :-1, -1])
        inner = np.einsum("fi,fij,fj->f", solutions, parts[:, :-1, :-1], solutions)
        crossed = np.einsum("fi,fi->f", solutions, parts[:, :-1, -1])
        return float((parts[:, -1, -1] - 2.0 * crossed + inner).sum())

    def covariance(self, kept: list) -> np.ndarray:
        """Covariance of the solution by the jackknife over weeks (CR3)."""
        sums = self.by_cluster
        normals = submatrices(sums, kept)
        whole = normals.sum(axis=0)
        inverse = np.linalg.inv(whole + ridge(whole))
        scores = sums[:, kept, -1] - normals @ self.solve(kept)
        return jackknife_covariance(normals, scores, inverse)

    def by_day(self) -> np.ndarray:
        """Covariance at a minimum of all columns by the jackknife over days."""
        normals, scores = self.sums[:, :-1, :-1], self.sums[:, :-1, -1]
        inverse = np.linalg.inv(normals.sum(axis=0))
        covariance = jackknife_covariance(normals, scores, inverse)
        return covariance / np.outer(self.scale, self.scale)


def submatrices(sums: np.ndarray, columns: list) -> np.ndarray:
    """
    Copy of the products of some columns, in the given order.

    Parameters
    ----------
    sums : array, shape (matrices, columns, columns)
        Products of all columns.
    columns : list of int
        Places of the columns; negative ones count from the end.

    Returns
    -------
    array, shape (matrices, len(columns), len(columns))
    """
    columns = np.asarray(columns) % sums.shape[-1]
    places = columns[:, None] * sums.shape[-1] + columns
    return sums.reshape(len(sums), -1).take(places, axis=1)


def root_of_decrease(square: Any) -> Any:
    """
    Root of a decrease of the mean square; negative for an increase.

    It is rounded to 1 µK, so that rounding errors do not decide between equal values.

    Parameters
    ----------
    square : float
        Decrease of the mean square. [K²]

    Returns
    -------
    float
        [K]
    """
    return round(float(np.sign(square) * np.sqrt(abs(square))), 6)


def cluster_sums(
    columns: list,
    residual: np.ndarray | pd.Series,
    dates: np.ndarray,
    folds: int = FOLDS,
    fewest: int = FEWEST_CLUSTERS,
) -> ClusterSums:
    """
    Sum the products of columns over each date, in order.

    The columns are stacked a day at a time, so a long record needs no second copy of
    them.

    Parameters
    ----------
    columns : list of array, shape (rows,)
        Columns of the regression.
    residual : array, shape (rows,)
        Becomes the last column of the products.
    dates : array of int, shape (rows,)
        Day of each row, from 1970-01-01, in order.
    folds : int, default 5
        Number of groups of weeks for cross-validation.
    fewest : int, default 8
        With fewer weeks, errors are clustered by day.

    Returns
    -------
    ClusterSums
    """
    by_day = products_by_day([*columns, residual], dates)
    return cluster_sums_of(*by_day, len(residual), folds, fewest)


def cluster_sums_of(
    days: np.ndarray,
    sums: np.ndarray,
    rows: int,
    folds: int = FOLDS,
    fewest: int = FEWEST_CLUSTERS,
) -> ClusterSums:
    """
    :class:`ClusterSums` from daily products of columns.

    Parameters
    ----------
    days : array of int, shape (days,)
        Each day once, from 1970-01-01, in order.
    sums : array, shape (days, columns + 1, columns + 1)
        Products of the columns and, last, of the residual, over each day.
    rows : int
        Number of rows of all days.
    folds : int, default 5
        Number of groups of weeks for cross-validation.
    fewest : int, default 8
        With fewer weeks, errors are clustered by day.

    Returns
    -------
    ClusterSums
    """
    scale = np.sqrt(np.einsum("dii->i", sums)[:-1] / rows)
    scale[scale == 0] = 1.0
    scales = np.append(scale, 1.0)
    sums = sums / np.outer(scales, scales)
    of_day = days_of_folds(days, folds)
    return ClusterSums(sums, scale, rows, of_day, calendar_weeks(days), days, fewest)


def products_by_day(columns: list, dates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    The dates of some rows, and products of columns over each date.

    Parameters
    ----------
    columns : list of array, shape (rows,)
        Columns, such as slopes and a residual.
    dates : array of int, shape (rows,)
        Day of each row, from 1970-01-01, in order.

    Returns
    -------
    dates : array of int, shape (days,)
        Each day once.
    products : array, shape (days, columns, columns)
        Sums over the rows of each day.
    """
    first, ends = date_starts(dates)
    size, rows = len(columns), np.diff(first, append=len(dates))
    daily = np.empty((len(first), size, size))
    # consecutive short days with equal numbers of rows are computed together
    edges = np.flatnonzero(np.diff(rows, prepend=0, append=0))
    for start, end in pairwise(edges):
        length = rows[start]
        most = max(AT_ONCE // length, 1) if length * size**2 <= BLOCK else 1
        for day in range(start, end, most):
            stop = day + int(np.minimum(most, end - day))
            days, part = slice(day, stop), slice(first[day], ends[stop - 1])
            daily[days] = (
                products(columns, part) if most == 1 else of_days(columns, part, length)
            )
    return dates[first], daily


def of_days(columns: list, rows: Any, length: int) -> np.ndarray:
    """Products of columns over days of equal length, with the bits of single days."""
    table = np.stack([column[rows] for column in columns])
    days = table.reshape(len(columns), -1, length).transpose(1, 0, 2)
    return np.ascontiguousarray(days) @ np.ascontiguousarray(days.transpose(0, 2, 1))


def joined_products(parts: list) -> tuple[np.ndarray, np.ndarray]:
    """
    Dates and products of consecutive blocks, with each date once.

    Parameters
    ----------
    parts : list of (array, array)
        Dates and products of each block, see :func:`products_by_day`; a day may be in
        several blocks.

    Returns
    -------
    dates : array of int, shape (days,)
        Each day once.
    products : array, shape (days, columns, columns)
        Sums over the rows of each day.
    """
    days, sums = zip(*parts)
    days, sums = np.concatenate(days), np.concatenate(sums)
    first, _ = date_starts(days)
    return days[first], np.add.reduceat(sums, first, axis=0)


def days_of_folds(dates: np.ndarray, folds: int = FOLDS) -> np.ndarray:
    """
    Fold of each date: whole weeks in turn, or days if there are few weeks.

    Parameters
    ----------
    dates : array of int, shape (days,)
        Days from 1970-01-01.
    folds : int, default 5
        Number of folds.

    Returns
    -------
    array of int, shape (days,)
        From 0 to ``folds - 1``.
    """
    grouped = calendar_weeks(dates) if np.ptp(dates) >= folds * WEEK else dates
    return np.unique(grouped, return_inverse=True)[1] % folds


def date_starts(dates: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """
    First row of each date, and the row after its last.

    Parameters
    ----------
    dates : array of int, shape (rows,)
        Day of each row, in order.

    Returns
    -------
    first : array of int, shape (days,)
        First row of each day.
    ends : list of int, length days
        Row after the last of each day.
    """
    if not len(dates):
        return np.zeros(0, int), []
    # a repeated hour at midnight stays with the day that has begun
    first = np.flatnonzero(np.diff(dates, prepend=dates[0] - 1) > 0)
    return first, [*first[1:], len(dates)]


def calendar_weeks(dates: np.ndarray) -> np.ndarray:
    """
    Number of each date's ISO week; 1970-01-01 was a Thursday.

    Parameters
    ----------
    dates : array of int, shape (n,)
        Days from 1970-01-01.

    Returns
    -------
    array of int, shape (n,)
        Weeks from Monday to Sunday; that of 1970-01-01 is 0.
    """
    return (np.asarray(dates) + 3) // WEEK


def jackknife_covariance(
    normals: np.ndarray, scores: np.ndarray, inverse: np.ndarray
) -> np.ndarray:
    """
    Covariance of a solution by the jackknife over clusters, CR3 [1]_.

    To first order, it follows from the normal matrices and scores of the clusters
    and the inverse of the whole normal matrix.

    Parameters
    ----------
    normals : array, shape (clusters, columns, columns)
        Products of the columns in each cluster.
    scores : array, shape (clusters, columns)
        Products of the columns with the residual of the solution in each cluster.
    inverse : array, shape (columns, columns)
        Inverse of the sum of ``normals``.

    Returns
    -------
    array, shape (columns, columns)

    References
    ----------
    .. [1] A. C. Cameron and D. L. Miller, "A Practitioner's Guide to
       Cluster-Robust Inference", J. Human Resources 50, 317-372, 2015, section
       VI.B. :doi:`10.3368/jhr.50.2.317`
    """
    complement = np.eye(len(inverse)) - normals @ inverse
    shifts = np.linalg.solve(complement, scores[..., None])[..., 0] @ inverse
    return (len(scores) - 1) / len(scores) * shifts.T @ shifts


def day_errors(
    columns: list, residual: np.ndarray | pd.Series, days: np.ndarray
) -> np.ndarray:
    """
    Covariance at a minimum, robust to autocorrelation within a day.

    Parameters
    ----------
    columns : list of array, shape (rows,)
        Slopes of the model along its coefficients.
    residual : array, shape (rows,)
        Measured minus modelled at the minimum, in the unit of the measurement.
    days : array of int, shape (rows,)
        Day of each row, from 1970-01-01, in order.

    Returns
    -------
    array, shape (columns, columns)
        Covariance of the coefficients by the jackknife over days.
    """
    return cluster_sums(columns, residual, days).by_day()


def ridged(normal: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solution of one or more systems of normal equations."""
    if right.shape[-1] == 0:
        return right
    return np.linalg.solve(normal + ridge(normal), right[..., None])[..., 0]


def ridge(normal: np.ndarray) -> np.ndarray:
    """A small ridge that keeps the system regular if a column is zero."""
    size, count = np.diagonal(normal, axis1=-2, axis2=-1), normal.shape[-1]
    size = RIDGE * (size + size.sum(axis=-1, keepdims=True) / count)
    return size[..., None] * identity(count)


@lru_cache(maxsize=256)  # thousands of small systems are solved
def identity(size: int) -> np.ndarray:
    matrix = np.eye(size)
    matrix.flags.writeable = False
    return matrix
