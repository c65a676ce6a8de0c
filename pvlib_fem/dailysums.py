"""
Least squares of any columns from one pass over a record.

The products of all columns are summed by the day. Subsets of columns, folds of
days left out, errors by the day and what one column adds beside others are then
sums of small matrices.
"""

from dataclasses import dataclass

import numpy as np

FOLDS = 5
WEEK = 7  # days that stay together in a fold
RIDGE = 1e-9  # of a column's square: what a record does not determine stays 0


@dataclass(frozen=True, eq=False)
class DailySums:
    """
    Products of columns, and of the residual as the last of them, by the day.

    Columns are scaled to a mean square of 1; ``scale`` leads back.
    """

    sums: np.ndarray  # days, columns + 1, columns + 1
    scale: np.ndarray
    rows: int
    folds: np.ndarray  # of each day

    @property
    def days(self):
        return len(self.sums)

    def solve(self, kept, days=slice(None)):
        """Best coefficients of the kept columns, over some days."""
        normal = self.sums[days].sum(axis=0)
        return ridged(normal[np.ix_(kept, kept)], normal[kept, -1])

    def left(self, kept, days=slice(None)):
        """Mean square that the kept columns leave on days that did not solve them."""
        total = 0.0
        for fold in range(FOLDS):
            out = self.folds == fold
            found = self.solve(kept, ~out)
            sums = self.sums[out].sum(axis=0)
            total += sums[-1, -1] - 2.0 * found @ sums[kept, -1]
            total += found @ sums[np.ix_(kept, kept)] @ found
        return total / self.rows

    def covariance(self, kept):
        """Covariance of the solution from leaving out each day in turn (CR3)."""
        normals = self.sums[:, kept][:, :, kept]
        whole = normals.sum(axis=0)
        inverse = np.linalg.inv(whole + RIDGE * np.diag(np.diag(whole)))
        scores = self.sums[:, kept, -1] - normals @ self.solve(kept)
        return days_left_out(normals, scores, inverse)

    def beside(self, column, kept):
        """Root mean square of a column that the kept ones do not explain."""
        normal = self.sums.sum(axis=0)
        explained = ridged(normal[np.ix_(kept, kept)], normal[kept, column])
        square = normal[column, column] - explained @ normal[kept, column]
        return np.sqrt(max(square, 0.0) / self.rows)


def daily_sums(columns, residual, dates):
    """Sum the products of columns (rows by columns) over each date, in order."""
    scale = np.sqrt(np.einsum("ij,ij->j", columns, columns) / len(residual))
    scale[scale == 0] = 1.0
    both = np.column_stack([columns / scale, residual])
    days, first = np.unique(dates, return_index=True)
    ends = [*first[1:], len(residual)]
    sums = np.stack([both[a:b].T @ both[a:b] for a, b in zip(first, ends)])
    elapsed = days - days[0]
    # whole weeks in turn, or days where there are few weeks
    length = WEEK if elapsed[-1] >= FOLDS * WEEK else 1
    return DailySums(sums, scale, len(residual), elapsed // length % FOLDS)


def days_left_out(normals, scores, inverse):
    """
    Covariance of a solution from its spread when each day in turn is left out.

    To first order, from the normal matrices and scores of the days and the
    inverse of the whole normal matrix: the jackknife over clusters, CR3 [1]_.

    References
    ----------
    .. [1] A. C. Cameron and D. L. Miller, "A Practitioner's Guide to
       Cluster-Robust Inference", J. Human Resources 50, 317-372, 2015, section
       VI.B. :doi:`10.3368/jhr.50.2.317`
    """
    left_out = np.eye(len(inverse)) - normals @ inverse
    shifts = np.linalg.solve(left_out, scores[..., None])[..., 0] @ inverse
    return (len(scores) - 1) / len(scores) * shifts.T @ shifts


def day_errors(jacobian, residual, days):
    """Covariance of a minimum that survives autocorrelation within a day."""
    sums = daily_sums(jacobian, residual, days)
    normals, scores = sums.sums[:, :-1, :-1], sums.sums[:, :-1, -1]
    inverse = np.linalg.inv(normals.sum(axis=0))
    covariance = days_left_out(normals, scores, inverse)
    return covariance / np.outer(sums.scale, sums.scale)


def ridged(normal, right):
    return np.linalg.solve(normal + RIDGE * np.diag(np.diag(normal)), right)
