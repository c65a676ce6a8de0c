"""The longwave deficit of the sky, measured or estimated."""

from typing import Any

import numpy as np
import pandas as pd
from pvlib.clearsky import haurwitz

from pvlib_fem._record.inputs import Inputs
from pvlib_fem.drivers._lagged_inputs import HOUR, smoothed
from pvlib_fem.drivers._solar import SOLAR_CONSTANT
from pvlib_fem.drivers._water import saturation

STEFAN_BOLTZMANN = 5.670374419e-8  # W/(m² K⁴), CODATA 2018
ZERO_CELSIUS = 273.15  # K
LOW_SUN = 5.0  # ° of elevation below which irradiance does not show clouds


def black_body(temp_air: np.ndarray) -> np.ndarray:
    """Longwave of a black body at air temperature. [W/m²]"""
    return STEFAN_BOLTZMANN * (temp_air + ZERO_CELSIUS) ** 4


def sky_deficit(
    longwave_down: np.ndarray, temp_air: np.ndarray, inputs: Inputs
) -> np.ndarray:
    """
    Longwave of a black body at air temperature minus that of the sky. [W/m²]

    Parameters
    ----------
    longwave_down : array, shape (rows,)
        Longwave irradiance from the sky. [W/m²]
    temp_air : array, shape (rows,)
        [°C]
    inputs : Inputs
        Not used.

    Returns
    -------
    array, shape (rows,)
        Positive where the sky is colder than the air.
    """
    return black_body(temp_air) - longwave_down


def moist_emissivity(relative_humidity: np.ndarray, temp_air: np.ndarray) -> np.ndarray:
    """
    Emissivity of the clear sky, from vapour pressure at the ground [1]_. [-]

    References
    ----------
    .. [1] A. J. Prata, "A new long-wave formula for estimating downward
       clear-sky radiation at the surface", Q. J. R. Meteorol. Soc. 122, 1127
       (1996), :doi:`10.1002/qj.49712253306`.
    """
    vapour = relative_humidity / 100.0 * saturation(temp_air)
    water = 46.5 * vapour / (temp_air + ZERO_CELSIUS)  # g/cm² above
    return 1.0 - (1.0 + water) * np.exp(-np.sqrt(1.2 + 3.0 * water))


def sky_deficit_moist(
    relative_humidity: np.ndarray, temp_air: np.ndarray, inputs: Inputs
) -> np.ndarray:
    """
    :func:`sky_deficit` of a clear sky, from humidity. [W/m²]

    The emissivity is that of :func:`moist_emissivity`.

    Parameters
    ----------
    relative_humidity : array, shape (rows,)
        [%]
    temp_air : array, shape (rows,)
        [°C]
    inputs : Inputs
        Not used.

    Returns
    -------
    array, shape (rows,)
    """
    emissivity = moist_emissivity(relative_humidity, temp_air)
    return (1.0 - emissivity) * black_body(temp_air)


def sky_deficit_humid(
    sky_deficit_moist: np.ndarray,
    cloud_share: np.ndarray,
    inputs: Inputs,
    *,
    cloud_base: float = 0.84,
) -> np.ndarray:
    """
    :func:`sky_deficit` from humidity and the clouds of the day. [W/m²]

    Parameters
    ----------
    sky_deficit_moist : array, shape (rows,)
        Deficit of a clear sky. [W/m²]
    cloud_share : array, shape (rows,)
        Share of the sky under cloud. [-]
    inputs : Inputs
        Not used.
    cloud_base : float, default 0.84
        Share of the clear-sky deficit that low clouds close. [-]

    Returns
    -------
    array, shape (rows,)
    """
    return (1.0 - cloud_base * cloud_share) * sky_deficit_moist


def sky_deficit_clouds(
    sky_deficit_air: Any, cloud_share: Any, inputs: Inputs, *, cloud_base: float = 0.84
) -> Any:
    """
    :func:`sky_deficit` from air temperature and the clouds of the day. [W/m²]

    Parameters
    ----------
    sky_deficit_air : array, shape (rows,)
        Deficit of a clear sky. [W/m²]
    cloud_share : array, shape (rows,)
        Share of the sky under cloud. [-]
    inputs : Inputs
        Not used.
    cloud_base : float, default 0.84
        Share of the clear-sky deficit that low clouds close. [-]

    Returns
    -------
    array, shape (rows,)
    """
    return (1.0 - cloud_base * cloud_share) * sky_deficit_air


def sky_deficit_air(temp_air: np.ndarray, inputs: Inputs) -> np.ndarray:
    """
    :func:`sky_deficit` of a clear sky, from air temperature alone [1]_. [W/m²]

    Parameters
    ----------
    temp_air : array, shape (rows,)
        [°C]
    inputs : Inputs
        Not used.

    Returns
    -------
    array, shape (rows,)

    References
    ----------
    .. [1] W. C. Swinbank, "Long-wave radiation from clear skies", Q. J. R.
       Meteorol. Soc. 89, 339 (1963), :doi:`10.1002/qj.49708938105`.
    """
    emissivity = 9.365e-6 * (temp_air + ZERO_CELSIUS) ** 2
    return (1.0 - emissivity) * black_body(temp_air)


def cloud_share(
    clearness: np.ndarray,
    solar_zenith: np.ndarray,
    inputs: Inputs,
    *,
    cloud_memory: float = 3.0,
) -> np.ndarray:
    """
    Share of the sky under cloud, carried from each day through the night. [-]

    In daytime it follows from irradiance relative to a clear sky [1]_; an overcast
    sky transmits a quarter [2]_.

    Parameters
    ----------
    clearness : array, shape (rows,)
        From :func:`pvlib_fem.drivers._solar.clearness`. [-]
    solar_zenith : array, shape (rows,)
        [°]
    inputs : Inputs
        For the steps.
    cloud_memory : float, default 3
        Time constant. [h]

    Returns
    -------
    array, shape (rows,)
        From 0 to 1; NaN where ``clearness`` is.

    References
    ----------
    .. [1] B. Haurwitz, "Insolation in Relation to Cloudiness and Cloud Density",
       J. Meteorol. 2, 154 (1945), as in :func:`pvlib.clearsky.haurwitz`.
    .. [2] F. Kasten and G. Czeplak, Solar Energy 24, 177 (1980),
       :doi:`10.1016/0038-092X(80)90391-6`.
    """
    clear = haurwitz(pd.Series(solar_zenith))["ghi"].to_numpy()
    light = SOLAR_CONSTANT * clearness * np.cos(np.radians(solar_zenith))
    cloudy = np.clip((1.0 - light / np.maximum(clear, 0.1)) / 0.75, 0.0, 1.0)
    seen = np.where(np.isnan(clearness), np.nan, solar_zenith < 90.0 - LOW_SUN)
    # after a long time without sun the share tends to one half
    weight = smoothed(seen, inputs, cloud_memory * HOUR) + 1e-6
    return (smoothed(seen * cloudy, inputs, cloud_memory * HOUR) + 0.5e-6) / weight
