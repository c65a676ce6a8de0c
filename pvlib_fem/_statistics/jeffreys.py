"""Intervals of shares and of counts, by Jeffreys' prior."""

import numpy as np
from scipy.special import betaincinv, gammaincinv


def share_between(count: int, of: int, tail: float = 0.05) -> tuple[float, float]:
    """
    Ends of the interval of a proportion, by Jeffreys' prior [1]_.

    Parameters
    ----------
    count, of : int
        Number of successes and of trials; with no trial the interval is 0 to 1.
    tail : float, default 0.05
        Probability beyond either end. The lower end is 0 without a success, and the
        upper end is 1 without a failure, as in [1]_.

    Returns
    -------
    (float, float)
        Lower and upper end. [-]

    References
    ----------
    .. [1] L. D. Brown, T. T. Cai and A. DasGupta, "Interval estimation for a binomial
       proportion", Statistical Science 16, 101-133, 2001, eq. 3.1.2.
       :doi:`10.1214/ss/1009213286`
    """
    rest = of - count
    ends = betaincinv(count + 0.5, rest + 0.5, [tail, 1.0 - tail])
    return float(ends[0]) if count else 0.0, float(ends[1]) if rest else 1.0


def rate_between(count: int, of: int, tail: float = 0.05) -> tuple[float, float]:
    """
    Ends of the interval of a mean count per record, by Jeffreys' prior.

    Parameters
    ----------
    count, of : int
        Number of events and of records; with no record the interval is 0 to infinity.
    tail : float, default 0.05
        Probability beyond either end. The lower end is 0 for a count of 0.

    Returns
    -------
    (float, float)
        Lower and upper end. [1/record]
    """
    if not of:
        return 0.0, np.inf
    low, high = gammaincinv(count + 0.5, [tail, 1.0 - tail]) / of
    return float(low) if count else 0.0, float(high)
