"""The variance that correlation between days adds to errors clustered by day."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from pvlib_fem._statistics.clusters import ClusterSums

LONGEST = 0.5  # share of the days; a longer memory looks like a constant
KNOWN = 0.1  # longest memory that can be estimated, as a share of the days


@dataclass(frozen=True, eq=False)
class DailyMemory:
    """The variance to add to each coefficient, and the duration of the error."""

    variance: np.ndarray
    memory: float  # days after which the correlation has fallen to 1/e
    days: int  # number of days from which the memory is estimated

    @property
    def known(self) -> bool:
        """Whether there are enough days to estimate the memory."""
        return self.memory <= KNOWN * self.days


def daily_memory(sums: ClusterSums) -> DailyMemory:
    r"""
    Estimate the variance that correlation between days adds to daily clustered errors.

    Part of the residual is an error :math:`u_t` of one coefficient on day :math:`t`,
    such as an offset of the sensor that comes and goes. Two days have the correlation
    :math:`m^{|t-s|}`. The error moves the minimum by :math:`A_t u_t`; :math:`A_t` are
    the day's products of all columns with that coefficient's, times the inverse of the
    whole normal matrix. The jackknife over days (:meth:`ClusterSums.by_day`) has the
    square of each :math:`A_t u_t`. This function has their products,

    .. math:: \gamma \sum_{t \neq s} A_t A_s m^{|t-s|}

    where :math:`\gamma` is the variance of :math:`u`. The coefficient is the one with
    the most correlated scores. :math:`m` is the correlation of each day's score with
    the next, less the bias :math:`-(1 + 3m)/n` of a series of n days [1]_. Days follow
    each other in the order in which they were fitted. A negative correlation reduces
    no error.

    Parameters
    ----------
    sums : ClusterSums
        Sums about a minimum.

    Returns
    -------
    DailyMemory

    References
    ----------
    .. [1] M. G. Kendall, "Note on bias in the estimation of autocorrelation",
       Biometrika 41, 403-404, 1954. :doi:`10.1093/biomet/41.3-4.403`
    """
    normals, scores = sums.sums[:, :-1, :-1], sums.sums[:, :-1, -1]
    days, inverse = len(scores), np.linalg.inv(normals.sum(axis=0))
    squared = np.einsum("dii->di", normals)  # per day and column
    size = np.sqrt(squared)
    along = np.divide(scores, size, out=np.zeros_like(scores), where=size > 0.0)
    squares = np.maximum((along**2).sum(axis=0), np.finfo(float).tiny)
    correlations = (along[1:] * along[:-1]).sum(axis=0) / squares * days / (days - 1)
    most = np.exp(-1.0 / (LONGEST * days))
    correlations = np.clip(correlations + (1.0 + 3.0 * correlations) / days, 0.0, most)
    place = int(np.argmax(correlations * squares))
    memory, weight = correlations[place], squared[:, place]
    # the fit has already removed the mean of the error from the residual
    free = weight.sum() - correlated_sum(weight, memory) / weight.sum()
    gamma = squares[place] / max(free, weight.sum() / days)
    moved = normals[:, place] @ inverse
    added = gamma * (correlated_sum(moved, memory) - (moved**2).sum(axis=0))
    variance = np.maximum(added, 0.0) / sums.scale**2
    return DailyMemory(variance, -1.0 / np.log(memory) if memory > 0.0 else 0.0, days)


def correlated_sum(columns: np.ndarray, memory: float) -> float | np.ndarray:
    """Sum of products of all pairs of days, weighted by their correlation."""
    carried = lfilter([1.0], [1.0, -memory], columns, axis=0)
    return (columns * (2.0 * carried - columns)).sum(axis=0)
