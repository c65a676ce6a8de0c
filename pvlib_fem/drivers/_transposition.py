"""Irradiance in the plane of the module from horizontal irradiance."""

from typing import Any

import numpy as np
import pandas as pd
from pvlib import atmosphere, irradiance

from pvlib_fem._spelling import ShellText, refusal
from pvlib_fem.drivers._mounts import angles_at, is_known
from pvlib_fem.drivers._solar import ALBEDO, sun

#: models of the diffuse sky on a tilted plane, as pvlib names them
TRANSPOSITIONS = ("perez", "haydavies")
PARTS = ("dni", "dhi")  # components of global irradiance
PLACE = ShellText(
    "location, surface_tilt and surface_azimuth", "--lat, --lon, --tilt and --azimuth"
)


def check_transposition(name: str, place: dict) -> None:
    """
    Refuse an unknown model of the sky, or an incomplete place.

    Parameters
    ----------
    name : str
        One of :data:`TRANSPOSITIONS`.
    place : dict
        From :func:`pvlib_fem.drivers.checked_place`.

    Raises
    ------
    ValueError
        If the name is another one, or the location or the plane is not known.
    """
    if name not in TRANSPOSITIONS:
        raise ValueError(
            f"transposition is {name!r}; it is {' or '.join(map(repr, TRANSPOSITIONS))}"
        )
    if not is_known(place):
        raise refusal("a transposition needs the plane of the module: give ", PLACE)


def in_plane(
    columns: Any, index: Any, place: dict, transposition: Any, late: float = 0.0
) -> Any:
    """
    Irradiance in the plane of the module from global horizontal irradiance. [W/m²]

    Beam and diffuse are the measured ``dni`` and ``dhi`` if both are given, otherwise
    from Erbs' correlation [1]_. The sky model is that of Perez [2]_ or of Hay and
    Davies [3]_, and the ground has an albedo of 0.2. All functions are pvlib's.

    Parameters
    ----------
    columns : mapping of Series or array
        ``ghi``, and perhaps ``dni`` and ``dhi``. [W/m²]
    index : DatetimeIndex
        Times of the solar position.
    place : dict
        From :func:`pvlib_fem.drivers.checked_place`.
    transposition : str
        One of :data:`TRANSPOSITIONS`.
    late : float, default 0
        By how much the times are after the sun's, as of means by their end. [s]

    Returns
    -------
    Series
        NaN where a column is.

    References
    ----------
    .. [1] D. G. Erbs, S. A. Klein and J. A. Duffie, Solar Energy 28, 293 (1982),
       :doi:`10.1016/0038-092X(82)90302-4`
    .. [2] R. Perez et al., Solar Energy 44, 271 (1990),
       :doi:`10.1016/0038-092X(90)90055-H`
    .. [3] J. E. Hay and J. A. Davies, Proc. First Canadian Solar Radiation Data
       Workshop, 59 (1980)
    """
    then = index - pd.Timedelta(seconds=late) if late else index
    where = sun(then, place["location"]).set_axis(index)
    zenith, azimuth = where["solar_zenith"], where["solar_azimuth"]
    ghi = pd.Series(np.asarray(columns["ghi"], float), index).clip(lower=0.0)
    if is_split(columns):
        dni, dhi = (pd.Series(np.asarray(columns[n], float), index) for n in PARTS)
    else:
        components = irradiance.erbs(ghi, zenith, index)
        dni, dhi = components["dni"], components["dhi"]
    plane = angles_at(index, place, late)
    with np.errstate(invalid="ignore", divide="ignore"):
        parts = irradiance.get_total_irradiance(
            *plane,
            zenith,
            azimuth,
            dni,
            ghi,
            dhi,
            dni_extra=irradiance.get_extra_radiation(index),
            airmass=atmosphere.get_relative_airmass(zenith),
            albedo=ALBEDO,
            model=transposition,
        )
    # before sunrise the irradiance is isotropic
    up = np.cos(np.radians(plane[0]))
    twilight = ghi * ((1.0 + up) / 2.0 + ALBEDO * (1.0 - up) / 2.0)
    total = parts["poa_global"].where(zenith < 90.0, twilight)
    total = total.fillna(twilight).clip(lower=0.0)
    known = np.isfinite(ghi) & np.isfinite(dni) & np.isfinite(dhi)
    return total.where(known).rename("poa_global")


def is_split(columns: Any) -> Any:
    """
    Whether the columns have both beam and diffuse irradiance.

    Parameters
    ----------
    columns : collection of str
        Names of columns, or a mapping by them.

    Returns
    -------
    bool
    """
    return all(name in columns for name in PARTS)
