"""Inputs of the module that do not depend on its temperature."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from pvlib_fem.simulator._air import VAPOUR, vapour
from pvlib_fem.simulator._constants import (
    DAY,
    SIGMA,
    ZERO,
    even_step,
    first_order_response,
    hour_and_day,
    season_wave,
    times_of,
)
from pvlib_fem.simulator._convection import FORCED, NATURAL
from pvlib_fem.simulator._deposits import SNOW_BELOW, dirt, ground_albedo, snow_cover
from pvlib_fem.simulator._ground import beam_transmittance, plane
from pvlib_fem.simulator._schedules import curtailed_hours, undeclared_heat
from pvlib_fem.simulator._surroundings import (
    AIR,
    BACK,
    GLASS,
    LAKE,
    LIGHT,
    WIND,
    sum_of_laws,
)
from pvlib_fem.simulator._tracker import orientation

if TYPE_CHECKING:
    from pvlib_fem.simulator._site import Site

IN_GLASS, IN_CELL = 0.03, 0.89  # share of sunlight; together τα = 0.92, as [2]_
REAR_ABSORPTANCE = 0.6  # of a light back sheet with cells behind it
EFFICIENCY, GAMMA, LOW_LIGHT = 0.20, -0.0035, 0.03  # crystalline silicon; 1, 1/K, 1
EMISSIVITY = np.array([[0.88], [0.85]])  # front, back: pvlib's faiman_rad, [2]_
MEET = 3.0  # m/s, where its straight line meets the forced convection
AT_MODULE = 0.85  # wind at the module over wind at the mast
SHELTER = 0.30  # wind from behind is slower by that, from the front faster
CHANNEL = 0.3  # speed behind a roof module, share of the wind along it [2]_

# ground of a rack and roof under a module; surface layer of some centimetres
SURFACE = {
    "rack": dict(capacity=9e4, lit=0.6, module=0.4, loss=9.0, cavity=0.0),
    "roof": dict(capacity=9e4, lit=0.0, module=1.0, loss=4.0, cavity=0.5),
}
TO_DEEP = 4.0  # W m⁻² K⁻¹, to the layer below, which follows the air of three days
GROUND_EMISSIVITY = 0.93
HEAT_OF_WATER = 4186.0  # J kg⁻¹ K⁻¹
SNOW_CONTACT = 40.0  # W m⁻² K⁻¹, of some centimetres on the glass


def fresnel(cosine: np.ndarray, index: float = 1.526) -> np.ndarray:
    """Transmittance of a glass face over that at normal incidence."""
    inside = np.sqrt(1.0 - (1.0 - cosine**2) / index**2)
    across = ((cosine - index * inside) / (cosine + index * inside)) ** 2
    along = ((inside - index * cosine) / (inside + index * cosine)) ** 2
    normal = 1.0 - ((index - 1.0) / (index + 1.0)) ** 2
    return (1.0 - (across + along) / 2) / normal


def light(
    weather: pd.DataFrame,
    site: "Site",
    on: Mapping[str, float],
    covered: np.ndarray,
    albedo: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """
    Irradiance through the glass, and heat that the back absorbs. [W/m²]

    Parameters
    ----------
    weather : DataFrame, shape (rows, columns)
        Result of `weather`.
    site : Site
        The site.
    on : dict of float
        Amplitudes by switch, see `amplitudes`.
    covered : array, shape (rows,)
        Share of the module under snow. [-]
    albedo : array, shape (rows,)
        Of the ground. [-]

    Returns
    -------
    sun, rear : array, shape (rows,)
        Light through the glass, and heat that the back absorbs. [W/m²]
    """
    tilt, azimuth = orientation(weather, site, on["tracker_stuck"])
    beam, sky, ground, cosine = plane(
        weather, tilt, azimuth, albedo, site.forms.transposition
    )
    beam = beam * beam_transmittance(weather, site, on["shading"])
    sun = beam * (1 + on["incidence_angle"] * (fresnel(cosine) - 1))
    sun += (sky + ground) * (1 + on["incidence_angle"] * (0.955 - 1))
    sun += sum_of_laws(LIGHT, weather, site, on)
    sun *= 1 - on["soiling"] * dirt(weather, site)
    sun *= 1 - 0.95 * np.minimum(covered, 1)
    sun *= 1 + 0.04 * on["season"] * season_wave(
        site, hour_and_day(times_of(weather))[1]
    )
    tilt = np.cos(np.radians(tilt))
    rear = 0.7 * albedo * weather["ghi"].to_numpy() * (1 + tilt) / 2  # 0.7: own shade
    rear += weather["dhi"].to_numpy() * (1 - tilt) / 2
    open_back = site.mounting == "rack"
    return sun, REAR_ABSORPTANCE * on["rear_irradiance"] * open_back * rear


def wind_scatter(
    weather: pd.DataFrame, site: "Site", on: Mapping[str, float]
) -> np.ndarray:
    """
    Wind at the module over its expectation from the mast, 1 on average.

    Parameters
    ----------
    weather : pandas.DataFrame, shape (rows, columns)
        Result of `weather`.
    site : Site
        The site.
    on : dict of float
        Amplitudes by switch.

    Returns
    -------
    numpy.ndarray, shape (rows,)
        Factor of the wind speed; obstacles to the wind lower it. [-]
    """
    scatter = 0.3 * on["wind_scatter"]
    ratio = np.exp(scatter * weather["scatter"].to_numpy() - scatter**2 / 2)
    return ratio * np.maximum(1 - sum_of_laws(WIND, weather, site, on), 0.0)


def undeclared_heats(
    weather: pd.DataFrame, site: "Site", on: Mapping[str, float]
) -> tuple[np.ndarray, np.ndarray]:
    """
    Heat of undeclared sources on the glass and on the back.

    Parameters
    ----------
    weather : pandas.DataFrame, shape (rows, columns)
        Result of `weather`.
    site : Site
        With the timetables.
    on : dict of float
        Amplitudes by switch.

    Returns
    -------
    front, back : numpy.ndarray, shape (rows,)
        Positive if the module is warmed. [W/m²]
    """
    air = weather["temp_air"].to_numpy()
    front, back = undeclared_heat(times_of(weather), air, on, site.forms)
    front = front + sum_of_laws(GLASS, weather, site, on)
    return front, back + sum_of_laws(BACK | LAKE, weather, site, on)


def electrical_output(
    sun: np.ndarray, idle: np.ndarray, on: Mapping[str, float]
) -> tuple[np.ndarray, np.ndarray]:
    """
    Power as constant + slope·T_cell, with T_cell in °C. [W/m², W/(m² K)]

    Parameters
    ----------
    sun : array, shape (rows,)
        Irradiance through the glass. [W/m²]
    idle : array, shape (rows,)
        Share of the output that is curtailed. [-]
    on : dict of float
        Amplitudes by switch.

    Returns
    -------
    constant, slope : array, shape (rows,)
        The slope is 0 or negative.
    """
    full = EFFICIENCY * sun * (1 - idle)
    low = on["conversion"] * LOW_LIGHT * np.log(np.clip(sun, 10.0, None) / 1000.0)
    slope = on["conversion"] * GAMMA * full
    return full * (1 + low) - 25.0 * slope, slope


def forced_convection(
    weather: pd.DataFrame, site: "Site", on: Mapping[str, float], calm: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Forced convection of both faces: the form's, and a linear approximation."""
    law = FORCED[site.forms.forced]
    tilt, azimuth = orientation(weather, site, on["tracker_stuck"])
    around = np.radians(weather["wind_direction"].to_numpy() - azimuth)
    facing = on["wind_direction"] * np.cos(around)
    if site.tracker is not None:  # which has no front while it is level
        facing = facing * np.sin(np.radians(tilt))
    local = (
        AT_MODULE * weather["wind_speed"].to_numpy() * wind_scatter(weather, site, on)
    )
    local *= np.maximum(1 + SHELTER * facing, 0.0)
    speed, facing = np.array([local, local]), np.array([facing, -facing])
    luff = 0.5 + 0.5 * facing  # share of windward
    if site.mounting == "roof":
        along = np.abs(np.cos(around)) - 2 / np.pi  # less its mean over directions
        share = np.maximum(2 / np.pi + on["wind_direction"] * along, 0.0)
        speed[1] *= CHANNEL * share
        facing[1] = luff[1] = 0.0
    rise = (np.hypot(calm, law(MEET, 0.5)) - calm) / MEET
    straight = (1 - on["wind_shape"]) * rise * speed * (1 + 0.5 * facing)
    return np.asarray(law(speed, luff)), straight


def wet_bulb(celsius: np.ndarray, humidity: np.ndarray) -> np.ndarray:
    """Stull's fit [4]_. [°C]"""
    return (
        celsius * np.arctan(0.151977 * np.sqrt(humidity + 8.313659))
        + np.arctan(celsius + humidity)
        - np.arctan(humidity - 1.676331)
        + 0.00391838 * humidity**1.5 * np.arctan(0.023101 * humidity)
        - 4.686035
    )


def forcing(
    weather: pd.DataFrame, site: "Site", on: Mapping[str, float]
) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """
    All inputs of the module that do not depend on its temperature.

    Parameters
    ----------
    weather : DataFrame, shape (rows, columns)
        Result of `weather`, on even steps.
    site : Site
        The site.
    on : dict of float
        Amplitudes by switch.

    Returns
    -------
    surfaces : dict
        Constants of the ground, law of natural convection, and numbers of the
        saturation vapour pressure.
    series : dict of array
        Inputs over time, with rows as the last axis; before it an axis for the front
        and the back where the faces differ.
    """
    celsius, step = weather["temp_air"].to_numpy(), even_step(times_of(weather))
    ghi = weather["ghi"].to_numpy()
    air = celsius + ZERO + sum_of_laws(AIR, weather, site, on)  # where the module is
    leaning, _ = orientation(weather, site, on["tracker_stuck"])
    tilt, rack = np.cos(np.radians(leaning)), site.mounting == "rack"
    covered = on["snow"] * snow_cover(weather, site)
    albedo = ground_albedo(weather, site, on)
    sun, rear = light(weather, site, on, covered, albedo)

    idle = on["electrical_output"] * curtailed_hours(weather)
    constant, slope = electrical_output(sun, idle, on)
    # longwave: all exchange is with black surroundings at air temperature; what
    # the sky is colder than that is a sink that the module does not change
    black = SIGMA * air**4
    cold = on["sky_radiation"] * (black - weather["longwave_down"].to_numpy())
    up, down = (1 + tilt) / 2, (1 - tilt) / 2
    to_sky = both_faces(up, down if rack else 0.0)
    to_ground = both_faces(down, up if rack else 1.0)
    front, back = undeclared_heats(weather, site, on)
    heat = np.array([IN_GLASS * sun + front, rear + back])
    # rain is at the wet-bulb temperature, snow not above 0 °C
    fluid = weather["precipitation"].to_numpy() * (celsius >= SNOW_BELOW) / 3600.0
    shed, held = on["rain"] * HEAT_OF_WATER * fluid, SNOW_CONTACT * covered
    wet = wet_bulb(celsius, weather["relative_humidity"].to_numpy()) + ZERO
    natural = NATURAL[site.forms.natural]
    even = np.full((2, len(weather)), site.forms.calm_excess)
    calm = natural(leaning)(even)
    forced, straight = forced_convection(weather, site, on, calm)
    ground = SURFACE[site.mounting]
    # heat of the ground minus its loss with air at 0 K
    lit = ground["lit"] * (1 - albedo) * ghi + ground["loss"] * air
    lit += TO_DEEP * first_order_response(air, 3 * DAY / step)
    lit += GROUND_EMISSIVITY * (1 - ground["module"]) * (black - cold)
    surfaces = dict(natural=natural, saturation=VAPOUR[site.forms.vapour])
    series = dict(
        air=air,
        heat=heat - EMISSIVITY * to_sky * cold,
        cell=IN_CELL * sun,
        output=constant - slope * ZERO,  # of a cell in kelvin
        slope=slope,
        forced=forced**2,
        straight=straight,
        drain=shed + held,
        cooler=shed * wet + held * np.minimum(air, ZERO),
        vapour=vapour(weather["temp_dew"].to_numpy(), site.forms.vapour),
        capture=fluid * (on["rain"] > 0),
        lit=lit,
        calm=calm,
        tilt=np.broadcast_to(leaning, len(weather)),
        view=np.broadcast_to(EMISSIVITY * SIGMA * to_ground, calm.shape),
    )
    return surfaces | ground, series


def both_faces(front: float | np.ndarray, back: float | np.ndarray) -> np.ndarray:
    """A number, or one for each row, of both faces."""
    return np.array(np.broadcast_arrays(*np.atleast_1d(front, back)))
