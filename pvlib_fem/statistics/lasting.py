"""What an error that lasts from day to day adds to errors by the day."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from pvlib_fem.statistics.clusters import ClusterSums

LONGEST = 0.5  # of the days: a longer memory is no other than a constant
TOLD = 0.1  # of the days: how long a longer memory is, they do not tell


@dataclass(frozen=True, eq=False)
class Lasting:
    """What an error that lasts adds to the variance of each coefficient."""

    variance: np.ndarray
    memory: float  # days after which 1/e of it is left
    days: int  # that tell so

    @property
    def known(self):
        """Whether the days are enough to tell how long it lasts."""
        return self.memory <= TOLD * self.days


def lasting(sums: ClusterSums) -> Lasting:
    r"""
    The variance that errors by the day lack, since one day resembles the next.

    The residual is taken to have a part along one coefficient, which on day
    :math:`t` is off by :math:`u_t`, with a correlation :math:`m^{|t-s|}` between two
    days: an offset of the sensor that comes and goes, or a gain. It moves a minimum by
    :math:`A_t u_t`, where :math:`A_t` are the day's products with that coefficient, by
    the inverse of the whole normal matrix. Leaving out days one by one has each of
    these by itself (:meth:`ClusterSums.by_day`). What lacks are their products,

    .. math:: \gamma \sum_{t \neq s} A_t A_s m^{|t-s|}

    The coefficient is the one along which the residual lasts most, and :math:`m` the
    correlation of one day's score with the next, less its bias :math:`-(1 + 3m)/n` in
    a series of n [1]_. Days follow each other as they were fitted. Nothing is taken
    off where one day has the other sign of the next.

    Parameters
    ----------
    sums : ClusterSums
        About a minimum.

    References
    ----------
    .. [1] M. G. Kendall, "Note on bias in the estimation of autocorrelation",
       Biometrika 41, 403-404, 1954. :doi:`10.1093/biomet/41.3-4.403`
    """
    normals, scores = sums.sums[:, :-1, :-1], sums.sums[:, :-1, -1]
    days, inverse = len(scores), np.linalg.inv(normals.sum(axis=0))
    told = np.einsum("dii->di", normals)
    # as many kelvins as each day has of an error along each coefficient
    size = np.sqrt(told)
    along = np.divide(scores, size, out=np.zeros_like(scores), where=size > 0.0)
    squares = np.maximum((along**2).sum(axis=0), np.finfo(float).tiny)
    found = (along[1:] * along[:-1]).sum(axis=0) / squares * days / (days - 1)
    most = np.exp(-1.0 / (LONGEST * days))
    found = np.clip(found + (1.0 + 3.0 * found) / days, 0.0, most)
    place = int(np.argmax(found * squares))
    memory, told = found[place], told[:, place]
    # what the minimum has taken of it is lacking in the residual
    free = told.sum() - between(told, memory) / told.sum()
    size = squares[place] / max(free, told.sum() / days)
    moved = normals[:, place] @ inverse
    added = size * (between(moved, memory) - (moved**2).sum(axis=0))
    variance = np.maximum(added, 0.0) / sums.scale**2
    return Lasting(variance, -1.0 / np.log(memory) if memory > 0.0 else 0.0, days)


def between(columns, memory):
    """Sum of the products of all pairs of days, each by the memory between them."""
    carried = lfilter([1.0], [1.0, -memory], columns, axis=0)
    return (columns * (2.0 * carried - columns)).sum(axis=0)
