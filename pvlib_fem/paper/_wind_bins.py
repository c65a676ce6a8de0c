"""The paper's effective maximum wind, and convection by wind."""

import numpy as np
import pandas as pd

from pvlib_fem._thermal.steady_models import CLIP
from pvlib_fem.paper._estimators import INTERVAL, MIN_POINTS, Estimate
from pvlib_fem.types import Numeric

WINDS = 0.99  # share of the averages below the maximum, the package's choice


def wind_max(
    wind_speed: pd.Series,
    share: float = WINDS,
    interval: str = INTERVAL,
    min_points: int = MIN_POINTS,
) -> Estimate:
    """
    Effective maximum wind of a site: nearly all averages are below.

    The paper takes it from the distribution of wind speeds (Fig. 4): 6 to 8 m/s for
    averages over five minutes, and clips WM2 at 8.

    Parameters
    ----------
    wind_speed : Series
        Wind speed with a DatetimeIndex. [m/s]
    share : float, default 0.99
        Share of the averages; the paper gives no number.
    interval : str, default "5min"
        Length of an average.
    min_points : int, default 10
        Least number of averages.

    Returns
    -------
    Estimate
        [m/s]

    Raises
    ------
    ValueError
        If there are too few averages, or ``share`` is out of range.
    """
    if not 0 < share <= 1:
        raise ValueError(f"share = {share} must be above 0 and at most 1")
    means = wind_speed.resample(interval).mean().dropna()
    if len(means) < min_points:
        raise ValueError(
            f"the effective maximum wind needs {min_points} averages over {interval} "
            f"and has {len(means)}; give a longer record"
        )
    return Estimate(float(means.quantile(share)), "m/s", len(means))


def convection(
    wind_speed: Numeric, k_w: float, wind_speed_max: float = CLIP
) -> Numeric:
    r"""
    Convective heat transfer of WM2, :math:`h = 1/(k_W\,WS)`, as in Eq. 20.

    The paper's h is not a loss in parallel to others: 1/h is the reduction of the
    module's resistance by wind, so h is infinite in calm air.

    Parameters
    ----------
    wind_speed : numeric
        [m/s]
    k_w : float
        The ``value`` of :func:`k_w`. [K m s/W]
    wind_speed_max : float, default 8
        Wind speed beyond which more wind has no influence. [m/s]

    Returns
    -------
    numeric
        [W/(m² K)]

    Raises
    ------
    ValueError
        If ``k_w`` is not positive.

    Examples
    --------
    >>> print(round(convection(4.0, k_w=0.0025)))
    100
    """
    if not k_w > 0:
        raise ValueError(f"k_w = {k_w} must be positive: wind cools")
    with np.errstate(divide="ignore"):
        return 1.0 / (k_w * np.minimum(wind_speed, wind_speed_max))
