"""Vapour, light and longwave of the air, in rival formulations.

Each function is named as in `pvlib_fem.simulator._submodels.RIVALS`.
"""

import numpy as np
from pvlib import irradiance

from pvlib_fem.simulator._constants import SOLAR_CONSTANT, ZERO

MEAN_DISTANCE = 94  # day of the year with the sun at its mean distance

#: a [Pa], b, c [°C] of a·exp(b·t/(c + t)), saturation over water at t °C. Magnus: WMO
#: Guide 8, pvlib's; Tetens: O. Tetens, Z. Geophys. 6, 297 (1930); Buck: A. L. Buck,
#: J. Appl. Meteorol. 20, 1527 (1981); Clausius and Clapeyron: with a constant latent
#: heat, whose b is L/(R_v T_0), L = 2.501 MJ/kg, R_v = 461.5 J/(kg K).
VAPOUR = {
    "magnus": (611.2, 17.62, 243.12),
    "tetens": (610.78, 17.27, 237.3),
    "buck": (611.21, 17.502, 240.97),
    "clausius_clapeyron": (611.2, 2.501e6 / (461.5 * ZERO), ZERO),
}


def vapour(celsius: np.ndarray, form: str = "magnus") -> np.ndarray:
    """
    Saturation vapour pressure over water.

    Parameters
    ----------
    celsius : numpy.ndarray, shape (rows,)
        Temperature; a dew point gives the vapour pressure of the air. [°C]
    form : str, default "magnus"
        Key of ``VAPOUR``.

    Returns
    -------
    numpy.ndarray, shape (rows,)
        [Pa]
    """
    a, b, c = VAPOUR[form]
    return a * np.exp(b * celsius / (c + celsius))


def diffuse_share(form: str, ghi: np.ndarray, elevation: np.ndarray) -> np.ndarray:
    """
    Diffuse fraction of global irradiance by one of pvlib's models.

    Parameters
    ----------
    form : str
        Name of the model in `pvlib.irradiance`, see ``RIVALS["diffuse"]``.
    ghi : numpy.ndarray, shape (rows,)
        Global horizontal irradiance. [W/m²]
    elevation : numpy.ndarray, shape (rows,)
        Of the sun. [°]

    Returns
    -------
    numpy.ndarray, shape (rows,)
        1 without irradiance. [-]
    """
    # pvlib has its own solar constant, and clearness is all that counts
    extra = irradiance.get_extra_radiation(MEAN_DISTANCE)
    light = ghi * extra / SOLAR_CONSTANT
    shares = getattr(irradiance, form)(light, 90.0 - elevation, MEAN_DISTANCE)
    return np.divide(shares["dhi"], light, out=np.ones_like(light), where=light > 0)


def berdahl_martin(
    celsius: np.ndarray, dew: np.ndarray, pressure: np.ndarray, hour: np.ndarray
) -> np.ndarray:
    """P. Berdahl and M. Martin, Solar Energy 32, 663 (1984).

    :doi:`10.1016/0038-092X(84)90144-0`.
    """
    emissivity = 0.711 + 0.0056 * dew + 0.000073 * dew**2
    return emissivity + 0.013 * np.cos(2 * np.pi * hour / 24)


def prata(
    celsius: np.ndarray, dew: np.ndarray, pressure: np.ndarray, hour: np.ndarray
) -> np.ndarray:
    """A. J. Prata, Q. J. R. Meteorol. Soc. 122, 1127 (1996).

    :doi:`10.1002/qj.49712253306`: precipitable water 46.5 e/T, e in hPa.
    """
    water = 46.5 * pressure / 100.0 / (celsius + ZERO)
    return 1.0 - (1.0 + water) * np.exp(-np.sqrt(1.2 + 3.0 * water))


def brunt(
    celsius: np.ndarray, dew: np.ndarray, pressure: np.ndarray, hour: np.ndarray
) -> np.ndarray:
    """D. Brunt, Q. J. R. Meteorol. Soc. 58, 389 (1932).

    :doi:`10.1002/qj.49705824704`: 0.52 + 0.065 √e, e in hPa.
    """
    return 0.52 + 0.065 * np.sqrt(pressure / 100.0)


def brutsaert(
    celsius: np.ndarray, dew: np.ndarray, pressure: np.ndarray, hour: np.ndarray
) -> np.ndarray:
    """W. Brutsaert, Water Resour. Res. 11, 742 (1975).

    :doi:`10.1029/WR011i005p00742`: 1.24 (e/T)^(1/7), e in hPa.
    """
    return 1.24 * (pressure / 100.0 / (celsius + ZERO)) ** (1 / 7)


def idso_jackson(
    celsius: np.ndarray, dew: np.ndarray, pressure: np.ndarray, hour: np.ndarray
) -> np.ndarray:
    """S. B. Idso and R. D. Jackson, J. Geophys. Res. 74, 5397 (1969).

    :doi:`10.1029/JC074i023p05397`: of air temperature alone.
    """
    return 1.0 - 0.261 * np.exp(-7.77e-4 * celsius**2)


EMISSIVITIES = {
    law.__name__: law for law in (berdahl_martin, prata, brunt, brutsaert, idso_jackson)
}
