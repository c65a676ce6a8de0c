"""
Least squares of any columns from one pass over a record.

The products of all columns are summed per day. From these small matrices follow
solutions for subsets of columns, cross-validation over folds of days, and errors
clustered by week.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pandas as pd
from scipy.sparse import csr_array

from pvlib_fem._statistics.leastsquares import products

FOLDS = 5  # groups of weeks, or days, that are held out in turn
WEEK = 7  # days that stay together in a fold
FEWEST_CLUSTERS = 8  # with fewer weeks, errors are clustered by day
FEWEST_DAYS = 5  # with fewer days, the spread between days gives no error


@dataclass(frozen=True, eq=False)
class ClusterSums:
    """
    Daily sums of products of columns; the last column is the residual.

    Columns are scaled to a mean square of 1; ``scale`` reverses that.
    """

    sums: np.ndarray  # days, columns + 1, columns + 1
    scale: np.ndarray
    dates: np.ndarray  # of each day, from 1970-01-01, in order

    @property
    def days(self) -> int:
        return len(self.sums)

    @cached_property
    def whole(self) -> np.ndarray:
        return self.sums.sum(axis=0)

    @cached_property
    def by_week(self) -> np.ndarray:
        """Sums per week, with its weather; per day where weeks are few."""
        first, ends = date_starts(week_numbers(self.dates))
        if len(first) == self.days:
            return self.sums
        # three times as fast as np.add.reduceat
        weeks = csr_array((np.ones(self.days), np.arange(self.days), [0, *ends]))
        sums = weeks @ self.sums.reshape(self.days, -1)
        return sums.reshape(-1, *self.sums.shape[1:])

    def of_columns(self, kept: list | np.ndarray) -> "ClusterSums":
        """Sums of some columns and the residual."""
        sums = submatrices(self.sums, [*kept, self.sums.shape[1] - 1])
        return replace(self, sums=sums, scale=self.scale[kept])

    def on(self, days: np.ndarray) -> "ClusterSums":
        """Sums of some days, by their places."""
        return replace(self, sums=self.sums[days], dates=self.dates[days])

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


def cluster_sums(
    columns: list,
    residual: np.ndarray | pd.Series,
    dates: np.ndarray,
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

    Returns
    -------
    ClusterSums
    """
    by_day = products_by_day([*columns, residual], dates)
    return cluster_sums_of(*by_day, len(residual))


def cluster_sums_of(
    days: np.ndarray,
    sums: np.ndarray,
    rows: int,
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

    Returns
    -------
    ClusterSums
    """
    scale = np.sqrt(np.einsum("dii->i", sums)[:-1] / rows)
    scale[scale == 0] = 1.0
    scales = np.append(scale, 1.0)
    sums = sums / np.outer(scales, scales)
    return ClusterSums(sums, scale, days)


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
    each = [products(columns, slice(*edges)) for edges in zip(first, ends)]
    return dates[first], np.array(each).reshape(-1, len(columns), len(columns))


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


def days_of_folds(dates: np.ndarray) -> np.ndarray:
    """
    Fold of each date: whole weeks in turn, or days if there are few weeks.

    Parameters
    ----------
    dates : array of int, shape (days,)
        Days from 1970-01-01.

    Returns
    -------
    array of int, shape (days,)
        From 0 to ``FOLDS - 1``.
    """
    grouped = calendar_weeks(dates) if np.ptp(dates) >= FOLDS * WEEK else dates
    return np.unique(grouped, return_inverse=True)[1] % FOLDS


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


def week_numbers(dates: np.ndarray) -> np.ndarray:
    """
    Number of the week of each date, from 0; of the day where weeks are few.

    Parameters
    ----------
    dates : array of int, shape (n,)

    Returns
    -------
    array of int, shape (n,)
    """
    weeks = np.unique(calendar_weeks(dates), return_inverse=True)[1]
    few = weeks.max() + 1 < FEWEST_CLUSTERS
    return np.unique(dates, return_inverse=True)[1] if few else weeks


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
