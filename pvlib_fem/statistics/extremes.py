"""The largest of many, and how sure it is."""

import numpy as np
from scipy.special import ndtri, stdtr

ALIKE = 1e-9  # of a gain, by which no other is larger


def as_normal(statistic, draws):
    """Standard errors of the normal law with the chance of Student's by few draws."""
    return float(-ndtri(stdtr(draws, -statistic)))


def largest(gains):
    """
    Place of the first gain that is as large as any but for rounding.

    Where nothing was to be seen an edge may stand anywhere, and the last bits of a sum
    are not to say where.
    """
    gains = np.ravel(gains)
    most = gains.max()
    return int(np.argmax(gains >= most - ALIKE * abs(most)))
