"""The largest of many gains, and Student's t as a normal deviate."""

from typing import Any

import numpy as np
from scipy.special import ndtri, stdtr

ALIKE = 1e-9  # relative difference up to which two gains count as equal


def as_normal(statistic: Any, draws: Any) -> Any:
    """
    Normal deviate with the tail probability of a value of Student's t.

    Parameters
    ----------
    statistic : float
        Value of t.
    draws : float
        Degrees of freedom; need not be whole.

    Returns
    -------
    float
        It has the sign of the statistic.
    """
    return float(-ndtri(stdtr(draws, -statistic)))


def rounded_argmax(gains: Any) -> int:
    """
    Place of the first gain that equals the largest within rounding errors.

    Without data an edge may be anywhere, and rounding errors must not choose the place.

    Parameters
    ----------
    gains : array, any shape
        Gains without NaN.

    Returns
    -------
    int
        Place in the flattened array.
    """
    gains = np.ravel(gains)
    most = gains.max()
    return int(np.argmax(gains >= most - ALIKE * abs(most)))


def largest_first(gains: np.ndarray) -> np.ndarray:
    """
    Places of some gains, the largest first, and equal ones in their order.

    Parameters
    ----------
    gains : array, shape (gains,)
        Gains without NaN, which are equal up to rounding errors of the largest.

    Returns
    -------
    array of int, shape (gains,)
    """
    unit = ALIKE * max(np.abs(gains).max(initial=0.0), 1e-300)
    return np.argsort(-np.round(gains / unit), kind="stable")
