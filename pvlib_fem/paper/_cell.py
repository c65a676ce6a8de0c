"""Cell temperature from the temperature at the back of a module."""

from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._relaxation import ewm
from pvlib_fem.paper._estimators import MIN_POINTS, Estimate, regression_line


def cell_from_back(
    temp_back: pd.Series | np.ndarray,
    poa_global: pd.Series | np.ndarray,
    k_bs_c: float,
    tau: float,
    **timing: Any,
) -> pd.Series | np.ndarray:
    """
    Cell temperature from the back of a module, ``T_back + k_BS-C·G_EWM`` (Eq. 35).

    Parameters
    ----------
    temp_back : Series or array
        [°C]
    poa_global : Series or array
        [W/m²]
    k_bs_c : float
        Back-to-cell resistance. [K m²/W]
    tau : float
        Thermal time constant. [s]
    **timing
        ``step`` or ``times`` of arrays, see :func:`pvlib_fem.ewm`.

    Returns
    -------
    Series or array
        [°C]
    """
    return temp_back + k_bs_c * ewm(poa_global, tau, **timing)


def k_bs_c(
    temp_cell: pd.Series,
    temp_back: pd.Series,
    poa_global: pd.Series,
    tau: float,
    min_points: int = MIN_POINTS,
) -> Estimate:
    """
    Back-to-cell resistance: slope of T_cell - T_back over smoothed irradiance.

    Parameters
    ----------
    temp_cell, temp_back, poa_global : Series
        [°C], [°C], [W/m²]
    tau : float
        Thermal time constant. [s]
    min_points : int, default 10
        Least number of rows above 20 W/m².

    Returns
    -------
    Estimate
        [K m²/W]

    Raises
    ------
    ValueError
        If there are too few rows.
    """
    poa = ewm(poa_global, tau)
    difference = temp_cell - temp_back
    seen = (poa > 20) & difference.notna()
    if seen.sum() < min_points:
        raise ValueError(
            f"k_BS-C needs {min_points} rows and has {int(seen.sum())}: smoothed "
            "irradiance above 20 W/m² and both temperatures measured"
        )
    slope, _ = regression_line(poa[seen], difference[seen], intercept=False)
    return Estimate(slope, "K m²/W", int(seen.sum()))
