"""Drivers that depend on wind direction."""

import numpy as np

from pvlib_fem._record.inputs import Inputs


def wind_north(
    wind_speed: np.ndarray, wind_direction: np.ndarray, inputs: Inputs
) -> np.ndarray:
    """
    Component of the wind from the north. [m/s]

    Parameters
    ----------
    wind_speed : array, shape (rows,)
        [m/s]
    wind_direction : array, shape (rows,)
        Where the wind comes from, clockwise from north. [°]
    inputs : Inputs
        Not used.

    Returns
    -------
    array, shape (rows,)
    """
    return wind_speed * np.cos(np.radians(wind_direction))


def wind_east(
    wind_speed: np.ndarray, wind_direction: np.ndarray, inputs: Inputs
) -> np.ndarray:
    """
    Component of the wind from the east. [m/s]

    Parameters
    ----------
    wind_speed : array, shape (rows,)
        [m/s]
    wind_direction : array, shape (rows,)
        Where the wind comes from, clockwise from north. [°]
    inputs : Inputs
        Not used.

    Returns
    -------
    array, shape (rows,)
    """
    return wind_speed * np.sin(np.radians(wind_direction))
