"""Irradiance on a plane, and obstacles before it."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from pvlib import irradiance
from pvlib.atmosphere import get_relative_airmass

from pvlib_fem.simulator._constants import SOLAR_CONSTANT

if TYPE_CHECKING:
    from pvlib_fem.simulator._site import Site
    from pvlib_fem.simulator._submodels import Obstacle


def plane(
    weather: pd.DataFrame,
    tilt: float | np.ndarray,
    azimuth: float | np.ndarray,
    albedo: np.ndarray,
    form: str,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """
    Beam, sky and ground irradiance on a plane, and the cosine of incidence.

    Parameters
    ----------
    weather : DataFrame, shape (rows, columns)
        Result of `weather`.
    tilt, azimuth : float or array, shape (rows,)
        Of the plane. [°]
    albedo : array, shape (rows,)
        Of the ground. [-]
    form : str
        Model of the sky diffuse irradiance, see `Forms`.

    Returns
    -------
    beam, sky, ground : array, shape (rows,)
        [W/m²]
    cosine : array, shape (rows,)
        Of the angle of incidence of the beam, 0 behind the plane and at night.
    """
    elevation = weather["elevation"].to_numpy()
    cosine = irradiance.aoi_projection(
        tilt, azimuth, 90.0 - elevation, weather["azimuth"].to_numpy()
    )
    cosine = np.where(elevation > 0, np.maximum(cosine, 0.0), 0.0)
    sky = sky_diffuse(form, weather, tilt, azimuth)
    ground = irradiance.get_ground_diffuse(tilt, weather["ghi"].to_numpy(), albedo)
    return weather["dni"].to_numpy() * cosine, sky, ground, cosine


def sky_diffuse(
    form: str,
    weather: pd.DataFrame,
    tilt: float | np.ndarray,
    azimuth: float | np.ndarray,
) -> np.ndarray:
    """Sky diffuse irradiance on a plane by one of pvlib's models. [W/m²]"""
    zenith = 90.0 - weather["elevation"].to_numpy()
    diffuse = irradiance.get_sky_diffuse(
        tilt,
        azimuth,
        zenith,
        weather["azimuth"].to_numpy(),
        *(weather[name].to_numpy() for name in ("dni", "ghi", "dhi")),
        dni_extra=SOLAR_CONSTANT,
        airmass=get_relative_airmass(zenith),
        model=form,
    )
    return np.where(weather["dhi"] > 0, np.maximum(np.nan_to_num(diffuse), 0.0), 0.0)


def blocked_share(weather: pd.DataFrame, obstacles: "Iterable[Obstacle]") -> np.ndarray:
    """Share of the beam that obstacles block; the largest share if they overlap."""
    azimuth, elevation = weather["azimuth"].to_numpy(), weather["elevation"].to_numpy()
    share = np.zeros(len(weather))
    for one in obstacles:
        across = (azimuth - one.azimuth + 180.0) % 360.0 - 180.0
        knots = np.linspace(-one.width / 2, one.width / 2, len(one.heights))
        below = np.interp(across, knots, one.heights) - elevation
        inside = np.minimum(one.width / 2 - np.abs(across), below)  # ° from an edge
        dark = np.clip(inside / one.blur + 0.5, 0, 1) if one.blur else inside >= 0
        share = np.maximum(share, one.covers * dark)
    return share


def beam_transmittance(
    weather: pd.DataFrame, site: "Site", amplitude: float
) -> np.ndarray:
    """
    Share of the beam that obstacles transmit.

    Parameters
    ----------
    weather : pandas.DataFrame, shape (rows, columns)
        Result of `weather`.
    site : Site
        With the obstacles.
    amplitude : float
        Factor of the share that they block. [-]

    Returns
    -------
    numpy.ndarray, shape (rows,)
        1 without shade. [-]
    """
    return 1 - np.minimum(amplitude * blocked_share(weather, site.forms.obstacles), 1)
