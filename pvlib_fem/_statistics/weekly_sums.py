"""Least squares of a few columns from weekly sums of their products."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

#: one sum of squares, or one of each of several matrices
Squares = np.float64 | np.ndarray
RIDGE = 1e-9  # of a column's square: an undetermined coefficient stays 0
SOME = 1e-9  # of the square of a column in the largest week, to count as present
MOST_MEMORY = 0.9  # autocorrelation of weeks above which it looks like a trend


def products(cells: np.ndarray, rows: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """
    Sums of products of all columns between each end and the next.

    Parameters
    ----------
    cells : array, shape (cells, columns)
        Means over the rows of each cell.
    rows : array, shape (cells,)
        Number of rows of each cell.
    ends : array of int, shape (days + 1,)
        First cell of each day, and the number of cells.

    Returns
    -------
    array, shape (days, columns, columns)
    """
    weighted = cells * np.sqrt(rows)[:, None]
    size = cells.shape[1]
    sums = np.empty((len(ends) - 1, size, size))
    for i, (low, high) in enumerate(pairwise(ends)):
        part = weighted[low:high]
        np.matmul(part.T, part, out=sums[i])
    return sums


def products_with(
    cells: np.ndarray, others: np.ndarray, rows: np.ndarray, ends: np.ndarray
) -> np.ndarray:
    """
    Sums of products of some columns with others between each end and the next.

    Parameters
    ----------
    cells, others : array, shape (cells, columns)
        Means over the rows of each cell.
    rows, ends : array
        As of :func:`products`.

    Returns
    -------
    array, shape (days, columns, columns of the others)
    """
    weighted = cells * rows[:, None]
    sums = np.empty((len(ends) - 1, cells.shape[1], others.shape[1]))
    for i, (low, high) in enumerate(pairwise(ends)):
        np.matmul(weighted[low:high].T, others[low:high], out=sums[i])
    return sums


def effective_number(weights: np.ndarray) -> float:
    """
    Effective number of draws with some weights (Kish, 1965).

    Parameters
    ----------
    weights : array, shape (draws,)
        Such as squares of each week, of which a few may have nearly all.

    Returns
    -------
    float
        The number of draws if they are alike; 0 if all are 0.
    """
    return float(weights.sum() ** 2 / max((weights**2).sum(), 1e-300))


def effective_length(draws: np.ndarray) -> float:
    """
    Effective number of draws of a mean square, if successive draws are alike.

    It is the number of draws, divided by the sum of their squared autocorrelations over
    all lags (Bayley and Hammersley, 1946, :doi:`10.2307/2983560`). The noise of sample
    autocorrelations is in that sum, so that the number is about half of the true one,
    which is on the safe side.

    Parameters
    ----------
    draws : array, shape (draws,)

    Returns
    -------
    float
        The number of draws if all are 0.
    """
    count = len(draws)
    power = np.abs(np.fft.rfft(draws, 2 * count)) ** 2
    lags = np.fft.irfft(power)[:count]
    squares = (lags[1:] / max(lags[0], 1e-300)) ** 2
    return count / (1.0 + 2.0 * float(squares.sum()))


@dataclass(frozen=True, eq=False)
class LeastSquares:
    """
    Least squares of some columns, with errors clustered by week.

    ``weekly`` has weekly sums of products. The first column is the residual; the last
    ``size`` columns are the tested ones.
    """

    weekly: np.ndarray
    size: int

    @cached_property
    def whole(self) -> np.ndarray:
        return self.weekly.sum(axis=0)

    @cached_property
    def solved(self) -> np.ndarray:
        """All coefficients."""
        return coefficients_from(self.whole)

    @property
    def estimate(self) -> np.ndarray:
        return self.solved[-self.size :]

    @cached_property
    def scores(self) -> np.ndarray:
        """Products of all columns with the residual of the fit, by week."""
        return self.weekly[:, 1:, 0] - self.weekly[:, 1:, 1:] @ self.solved

    @cached_property
    def shifts(self) -> np.ndarray:
        """Change of the estimate without each week in turn."""
        squares = with_ridge(self.whole[1:, 1:] - self.weekly[:, 1:, 1:])
        changes = np.linalg.solve(squares, self.scores[..., None])[..., 0]
        return -changes[:, -self.size :]

    @cached_property
    def covariance(self) -> np.ndarray:
        """Covariance of the estimate by the jackknife over autocorrelated weeks."""
        shifts, weeks = self.shifts - self.shifts.mean(axis=0), len(self.weekly)
        # collinear columns shift together
        plain = with_ridge((weeks - 1) / weeks * shifts.T @ shifts)
        along = shifts @ np.linalg.solve(plain, self.estimate)
        return plain * memory_factor(along)

    @cached_property
    def mix(self) -> np.ndarray:
        """The tested columns without what the others explain of them."""
        projection = np.linalg.solve(
            with_ridge(self.whole[1:, 1:])[: -self.size, : -self.size],
            self.whole[1 : -self.size, -self.size :],
        )
        return np.vstack([-projection, np.eye(self.size)])

    @cached_property
    def weights(self) -> np.ndarray:
        """Square of these columns in each week."""
        squares = np.einsum("iq,wij,jq->w", self.mix, self.weekly[:, 1:, 1:], self.mix)
        return np.maximum(squares, 0.0)

    @cached_property
    def freedom(self) -> float:
        """Effective number of weeks that determine the estimate, minus one."""
        return max(effective_number(self.weights) - 1.0, 1.0)

    def by_all_weeks(self) -> tuple[np.ndarray, float]:
        """
        Variance of a single tested column with the noise of all weeks, and its freedom.

        A change that lasts for a few weeks has few scores of its own, and their spread
        is a poor estimate of the noise ("few treated clusters": Conley and Taber, 2011,
        :doi:`10.1162/REST_a_00049`). Noise of the same kind gives each week's score a
        variance in proportion to the square of the column in that week. So every week
        in which the column differs from what the others explain estimates the noise.
        The two estimates are averaged by their freedom, as those of similar samples are
        (Smyth, 2004, :doi:`10.2202/1544-6115.1027`).
        """
        known = self.weights > SOME * self.weights.max()
        along = (self.scores @ self.mix)[known, 0] / np.sqrt(self.weights[known])
        many = max(len(along) - 1.0, 1.0)
        pooled = along @ along / many / self.weights.sum() * memory_factor(along)
        return self.averaged(pooled, many)

    def averaged(
        self, other: float | np.ndarray, many: float
    ) -> tuple[np.ndarray, float]:
        """The covariance, averaged with another estimate by their freedom, and both."""
        few = self.freedom
        return (many * other + few * self.covariance) / (many + few), many + few


def memory_factor(scores: np.ndarray) -> float:
    """Factor of a variance of means for the memory of scores of successive weeks."""
    memory, power = 0.0, scores @ scores
    if len(scores) > 3 and power > 0:
        memory = float(scores[1:] @ scores[:-1] / power)
    memory = min(max(memory, 0.0), MOST_MEMORY)
    return (1.0 + memory) / (1.0 - memory)


def coefficients_from(whole: np.ndarray) -> np.ndarray:
    """
    Coefficients from sums of products; the first row is that of the residual.

    Parameters
    ----------
    whole : array, shape (..., columns + 1, columns + 1)

    Returns
    -------
    array, shape (..., columns)
    """
    return np.linalg.solve(with_ridge(whole[..., 1:, 1:]), whole[..., 1:, 0, None])[
        ..., 0
    ]


def least_squares_coefficients(columns: np.ndarray, table: np.ndarray) -> np.ndarray:
    """
    Coefficients of a least-squares fit of columns to each column of a table.

    Parameters
    ----------
    columns, table : array, shape (rows, columns)

    Returns
    -------
    array, shape (columns, columns of the table)
        What the rows do not determine is 0.
    """
    squares = columns.T @ columns
    size = np.sqrt(np.diag(squares))
    size[size == 0.0] = 1.0
    inner = squares / np.outer(size, size) + RIDGE * np.eye(len(size))
    return np.linalg.solve(inner, columns.T @ table / size[:, None]) / size[:, None]


def with_ridge(squares: np.ndarray) -> np.ndarray:
    """
    Products with a ridge, so that undetermined coefficients stay 0.

    Parameters
    ----------
    squares : array, shape (..., columns, columns)
        Products of columns.

    Returns
    -------
    array, shape (..., columns, columns)
    """
    squares = squares.copy()
    diagonal = np.einsum("...ii->...i", squares)  # which changes with it
    size = np.abs(diagonal)
    diagonal += RIDGE * (size + 1e-3 * size.max(axis=-1, keepdims=True)) + 1e-30
    return squares


def given_first(whole: np.ndarray, first: int) -> np.ndarray:
    """
    Products of the residual and the last columns, given the first ones.

    Parameters
    ----------
    whole : array, shape (..., columns + 1, columns + 1)
        Sums of products; the first row is that of the residual.
    first : int
        Number of first columns, which explain a part of all others.

    Returns
    -------
    array, shape (..., columns + 1 - first, columns + 1 - first)
        The residual is first again. Columns have a ridge, as by :func:`with_ridge`.
    """
    squares = whole.copy()
    squares[..., 1:, 1:] = with_ridge(whole[..., 1:, 1:])
    rest = np.r_[0, first + 1 : whole.shape[-1]]
    cross = squares[..., 1 : first + 1, rest]
    explained = np.linalg.solve(squares[..., 1 : first + 1, 1 : first + 1], cross)
    return squares[..., rest[:, None], rest] - np.swapaxes(cross, -1, -2) @ explained


def fall_of_squares(whole: np.ndarray, size: int) -> Squares:
    """
    Decrease of the sum of squares by the last columns.

    Parameters
    ----------
    whole : array, shape (..., columns + 1, columns + 1)
        Sums of products; the first row is that of the residual.
    size : int
        Number of last columns.

    Returns
    -------
    float, or array of shape (...)
        In the unit of the residual, squared.
    """
    without = whole[..., : -size or None, : -size or None]
    return residual_squares(without) - residual_squares(whole)


def residual_squares(whole: np.ndarray) -> Squares:
    """Residual sum of squares of some columns."""
    sizes = coefficients_from(whole)
    return whole[..., 0, 0] - np.einsum("...i,...i->...", sizes, whole[..., 1:, 0])


def common_share(whole: np.ndarray, size: int, rival: int) -> Squares:
    """
    Share of what some columns explain that the last columns explain as well.

    The rest of it is what these columns still explain given the last ones
    (commonality analysis).

    Parameters
    ----------
    whole : array, shape (..., columns + 1, columns + 1)
        Sums of products of the residual, given columns, ``size`` columns, and the
        ``rival`` last columns.
    size, rival : int

    Returns
    -------
    float, or array of one value for each matrix
        From 0 to 1.
    """
    end = whole.shape[-1] - rival
    theirs = [*range(end - size), *range(end, end + rival), *range(end - size, end)]
    alone = fall_of_squares(whole[..., :end, :end], size)
    given_theirs = fall_of_squares(whole[..., theirs, :][..., theirs], size)
    return np.clip(1.0 - given_theirs / np.maximum(alone, 1e-300), 0.0, 1.0)


def held_out(weekly: np.ndarray, folds: np.ndarray) -> float:
    """
    Residual sum of squares by cross-validation over groups of weeks.

    Parameters
    ----------
    weekly : array, shape (weeks, columns + 1, columns + 1)
        Sums of products; the first row is that of the residual.
    folds : array, shape (groups, weeks)
        1 where a week is in a group, else 0.

    Returns
    -------
    float
        Over all groups, in the unit of the residual, squared.
    """
    parts = np.einsum("fw,wij->fij", folds, weekly)
    sizes = coefficients_from(parts.sum(axis=0) - parts)
    crossed = np.einsum("fi,fi->f", sizes, parts[:, 1:, 0])
    squared = np.einsum("fi,fij,fj->f", sizes, parts[:, 1:, 1:], sizes)
    return float((parts[:, 0, 0] - 2.0 * crossed + squared).sum())
