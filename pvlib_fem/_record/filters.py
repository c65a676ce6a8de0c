"""Rows that count: the paper's filters by day and by night."""

from typing import Any

import numpy as np

from pvlib_fem._record.column_names import COLUMNS, DAYLIGHT
from pvlib_fem._record.inputs import Columns
from pvlib_fem.types import Numeric, Rows


def usable(temp_air: Numeric, wind_speed: Numeric) -> Rows:
    """
    Rows inside the paper's limits for all data.

    0 to 25 m/s and -20 to 60 °C of air.

    Parameters
    ----------
    temp_air : numeric
        [°C]
    wind_speed : numeric
        [m/s]

    Returns
    -------
    boolean
        In the form of the input; False where one is NaN.
    """
    return (wind_speed >= 0) & (wind_speed <= 25) & (temp_air >= -20) & (temp_air <= 60)


def daytime(
    poa_global: Numeric, temp_air: Numeric, wind_speed: Numeric, temp_module: Numeric
) -> Rows:
    """
    Rows of daytime data: usable, more than 20 W/m², module at 0 to 80 °C.

    The lower limit leaves out modules under snow.

    Parameters
    ----------
    poa_global, temp_air, wind_speed, temp_module : numeric
        [W/m²], [°C], [m/s], [°C]

    Returns
    -------
    boolean
        In the form of the input; False where one is NaN.
    """
    return (
        usable(temp_air, wind_speed)
        & (poa_global > DAYLIGHT)
        & (temp_module >= 0)
        & (temp_module <= 80)
    )


def night(
    poa_global: Numeric, temp_air: Numeric, wind_speed: Numeric, temp_module: Numeric
) -> Rows:
    """
    Rows of night data, which show a bias: below 20 W/m², module at -20 to 80 °C.

    Parameters
    ----------
    poa_global, temp_air, wind_speed, temp_module : numeric
        [W/m²], [°C], [m/s], [°C]

    Returns
    -------
    boolean
        In the form of the input; False where one is NaN.
    """
    return (
        usable(temp_air, wind_speed)
        & (poa_global < DAYLIGHT)
        & (temp_module >= -20)
        & (temp_module <= 80)
    )


def counted(columns: Columns, with_night: bool = False) -> Any:
    """
    Rows whose residual counts in a fit: daytime, and by choice the night.

    Parameters
    ----------
    columns : mapping
        The usual four by name. Where it has ``snow_depth``, modules below 0 °C
        by day need not be left out with the night.
    with_night : bool, default False

    Returns
    -------
    boolean
    """
    usual = [columns[name] for name in COLUMNS]
    seen = daytime(*usual)
    if with_night:
        seen = seen | night(*usual)
        if "snow_depth" in columns:
            seen = seen | frozen(columns)
    return seen


def frozen(columns: Columns) -> Any:
    """
    Rows with the module below 0 °C, which may be under snow by day.

    Parameters
    ----------
    columns : mapping
        The usual four by name.

    Returns
    -------
    boolean
        True from -20 °C on, by day and by night.
    """
    poa, air, wind, module = (columns[name] for name in COLUMNS)
    cold = (module >= -20) & (module < 0)
    return usable(air, wind) & cold & np.isfinite(poa)  # of any light, but a known one
