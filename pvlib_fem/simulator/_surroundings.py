"""
Causes around the module: heat, light, air, wind and readings.

All but the lake are not in the catalogue of effects.

Each law has the name of its switch and returns amplitude 1. A site's hours, directions
and limits are drawn from the weather's seed, with separate random numbers for each law.
"""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from scipy.ndimage import uniform_filter1d

from pvlib_fem.simulator._constants import (
    DAY,
    even_step,
    first_order_response,
    hour_and_day,
    random_stream,
    season_wave,
    times_of,
)

if TYPE_CHECKING:
    from pvlib_fem.simulator._site import Site

#: what a cause adds in each row, in a weather at a site
Law = Callable[[pd.DataFrame, "Site"], np.ndarray]
LOW_SUN, HIGH_SUN = 8.0, 40.0  # °, where a façade mirrors the sun onto a module


def random_of_law(weather: pd.DataFrame, name: str) -> np.random.Generator:
    """Random numbers of one law at one site."""
    return random_stream(weather.attrs.get("seed", 0), name)


def angular_distance(angle: np.ndarray, centre: float) -> np.ndarray:
    """Distance of angles from another. [°]"""
    return np.abs((angle - centre + 180.0) % 360.0 - 180.0)


def within_hours(weather: pd.DataFrame, begin: float, length: float) -> np.ndarray:
    """Rows within some hours of the day."""
    hour = hour_and_day(times_of(weather))[0]
    return (hour >= begin) & (hour < begin + length)


def warm_rows(weather: pd.DataFrame, site: "Site", share: float) -> np.ndarray:
    """Rows with air above the annual mean by a share of the annual amplitude."""
    limit = site.temp_mean + share * site.temp_amplitude
    return weather["temp_air"].to_numpy() > limit


def hours_of_sun(weather: pd.DataFrame) -> np.ndarray:
    """Time since sunrise, 0 at night. [h]"""
    rows = np.arange(len(weather))
    dark = weather["elevation"].to_numpy() <= 0
    return (
        (rows - np.maximum.accumulate(rows * dark))
        * even_step(times_of(weather))
        / 3600
    )


def reflection(weather: pd.DataFrame, site: "Site") -> np.ndarray:
    """
    Sun reflected by a façade near the module, which its sensor does not see. [W/m²]

    Coated glass reflects 10 to 30 % of the sun; here the module gets 20 % of the beam.
    """
    random = random_of_law(weather, "reflection")
    azimuth, elevation = (weather[n].to_numpy() for n in ("azimuth", "elevation"))
    low = (elevation > LOW_SUN) & (elevation < HIGH_SUN)
    equator = 180.0 if site.latitude >= 0.0 else 0.0
    low = np.flatnonzero(low & (angular_distance(azimuth, equator) < 90.0))
    if not len(low):  # no hours with such sun
        return np.zeros(len(weather))
    place = random.choice(low)
    width, height = random.uniform(15.0, 30.0), random.uniform(8.0, 15.0)
    there = angular_distance(azimuth, azimuth[place]) < width
    there &= np.abs(elevation - elevation[place]) < height
    return 0.2 * weather["dni"].to_numpy() * there


def plume(weather: pd.DataFrame, site: "Site") -> np.ndarray:
    """
    Exhaust air in wind from one direction. [W/m²]

    Air is 2 K warmer, at 25 W/(m² K) of both faces.
    """
    random = random_of_law(weather, "plume")
    direction = weather["wind_direction"].to_numpy()
    centre = random.choice(direction)
    return 50.0 * (angular_distance(direction, centre) < random.uniform(20.0, 35.0))


def puddles(weather: pd.DataFrame, site: "Site") -> np.ndarray:
    """
    Wet ground behind the module, for half a day to two days after rain. [W/m²]

    Wet ground is 10 to 15 K colder in full sun than dry ground. The back loses
    6 W/(m² K) of that by longwave, and some more by its air.
    """
    dries = random_of_law(weather, "puddles").uniform(12.0, 40.0)  # h
    rows = np.arange(len(weather))
    rain = weather["precipitation"].to_numpy() > 0
    last = np.maximum.accumulate(np.where(rain, rows, -np.inf))
    wet = np.exp((last - rows) * even_step(times_of(weather)) / 3600.0 / dries)
    return -0.1 * weather["ghi"].to_numpy() * wet


def sea_breeze(weather: pd.DataFrame, site: "Site") -> np.ndarray:
    """
    Sea breeze that reaches the module but not the station. [K]

    Air behind its front is colder by some kelvin: S. T. K. Miller et al., Rev. Geophys.
    41, 1011 (2003), :doi:`10.1029/2003RG000124`. It blows on sunny days of the warm
    half year.
    """
    random = random_of_law(weather, "sea_breeze")
    hours = within_hours(weather, random.uniform(10.0, 13.0), random.uniform(5.0, 8.0))
    sun = first_order_response(
        weather["ghi"].to_numpy(), 3 * 3600 / even_step(times_of(weather))
    )
    warm = season_wave(site, hour_and_day(times_of(weather))[1]) < 0
    return -3.0 * (hours & warm & (sun > 300.0))


def misters(weather: pd.DataFrame, site: "Site") -> np.ndarray:
    """
    Nozzles of a barn or a terrace that cool the module's air in heat. [K]

    Fog systems remove 30 to 60 % of the wet-bulb depression, which is two thirds of air
    temperature minus dew point; a module nearby gets half of that.
    """
    random = random_of_law(weather, "misters")
    hours = within_hours(weather, random.uniform(8.0, 12.0), random.uniform(6.0, 10.0))
    dry = (weather["temp_air"] - weather["temp_dew"]).to_numpy()
    return -0.15 * dry * (hours & warm_rows(weather, site, random.uniform(0.2, 0.7)))


def fog(weather: pd.DataFrame, site: "Site") -> np.ndarray:
    """
    Dew on the glass after a humid night, dried by the sun. [W/m²]

    A night deposits 0.1 to 0.3 mm (J. L. Monteith and M. H. Unsworth, "Principles of
    environmental physics"); 80 W/m² over 2 h evaporate 0.24 mm.
    """
    lasts = random_of_law(weather, "fog").uniform(2.0, 4.0)  # h
    humid = (weather["relative_humidity"].to_numpy() > 85.0).astype(float)
    damp = first_order_response(humid, 3 * 3600 / even_step(times_of(weather)))
    since = hours_of_sun(weather)
    return -80.0 * damp * ((since > 0) & (since < lasts))


def inverter_hall(weather: pd.DataFrame, site: "Site") -> np.ndarray:
    """
    Exhaust of inverters by their power, if it is warm enough for the fans. [W/m²]

    Air is 3 K warmer, at 25 W/(m² K) of both faces.
    """
    share = random_of_law(weather, "inverter_hall").uniform(0.1, 0.6)
    power = np.minimum(weather["ghi"].to_numpy() / 850.0, 1.0)
    return 75.0 * power * warm_rows(weather, site, share)


def compost(weather: pd.DataFrame, site: "Site") -> np.ndarray:
    """
    A heap that is turned once in 1 to 3 months and cools for weeks. [W/m²]

    Windrows keep 55 °C for 15 days (40 CFR 503, appendix B): 40 K above air at
    6 W/(m² K), and the module's view factor is a quarter.
    """
    random = random_of_law(weather, "compost")
    day = np.arange(len(weather)) * even_step(times_of(weather)) / DAY
    gaps = random.uniform(30.0, 90.0, 2 + int(day[-1] / 30.0))
    turned = np.concatenate(([0.0], np.cumsum(gaps))) - random.uniform(0.0, 30.0)
    age = day - turned[np.searchsorted(turned, day, side="right") - 1]
    return 60.0 * (1 - np.exp(-age)) * np.exp(-age / random.uniform(8.0, 15.0))


def lorries(weather: pd.DataFrame, site: "Site") -> np.ndarray:
    """
    Share of the wind that parked lorries block on workdays. [-]

    A dense wall blocks half of it within five heights: G. M. Heisler and D. R.
    DeWalle, Agric. Ecosyst. Environ. 22-23, 41 (1988). A row with gaps blocks less.
    """
    random = random_of_law(weather, "lorries")
    hours = within_hours(weather, random.uniform(5.0, 9.0), random.uniform(8.0, 11.0))
    return 0.3 * (hours & (times_of(weather).day_of_week.to_numpy() < 5))


def charger(weather: pd.DataFrame, site: "Site") -> np.ndarray:
    """
    Error of a logger's cold junction that is warm while its battery charges. [K]

    The battery charges from sunrise until the night's use is replaced. 3 W in a box of
    0.5 m² that loses 5 W/(m² K) give 1.2 K.
    """
    share = random_of_law(weather, "charger").uniform(0.2, 0.35)
    step, since = even_step(times_of(weather)), hours_of_sun(weather)
    night = (weather["elevation"].to_numpy() <= 0).astype(float)
    night = 24.0 * uniform_filter1d(night, max(round(DAY / step), 1), mode="nearest")
    return 1.2 * first_order_response(
        (since > 0) & (since < share * night), 1200 / step
    )


def frozen_contact(weather: pd.DataFrame, site: "Site") -> np.ndarray:
    """
    Share of the over-temperature that a contact loses while it is frozen. [-]

    With shrunk glue a sensor partly reads the air, as after a failed fixing.
    """
    limit = random_of_law(weather, "frozen_contact").uniform(0.0, 4.0)  # °C
    return 0.2 * (weather["temp_air"].to_numpy() < limit)


def water(weather: pd.DataFrame, site: "Site") -> np.ndarray:
    """
    A lake below the module, by 6 W/(m² K) of radiation and 2 of air. [W/m²]

    The surface of mixed water loses 30 W/(m² K), and sun warms it by 0.01 K/(W/m²): J.
    E. Edinger et al., Water Resources Research 4, 1137 (1968),
    :doi:`10.1029/WR004i005p01137`. It is 2 to 10 m deep, and the year before was the
    same.
    """
    depth = random_of_law(weather, "water").uniform(2.0, 10.0)  # m
    lag = depth * 4.2e6 / 30.0 / even_step(times_of(weather))
    air, ghi = (weather[name].to_numpy() for name in ("temp_air", "ghi"))
    warmed = np.tile(air + 0.01 * ghi, 2)
    return 8.0 * (first_order_response(warmed, lag)[len(air) :] - air)


#: laws by the changed quantity: heat on the glass and behind it, light on the module,
#: its air, the wind there (share lost), its sensor's reading, its contact (share lost)
GLASS = {"fog": fog}
BACK = {
    "plume": plume,
    "puddles": puddles,
    "inverter_hall": inverter_hall,
    "compost": compost,
}
LIGHT = {"reflection": reflection}
AIR = {"sea_breeze": sea_breeze, "misters": misters}
WIND = {"lorries": lorries}
READING = {"charger": charger}
CONTACT = {"frozen_contact": frozen_contact}
#: a law behind it that is in the catalogue
LAKE = {"water": water}


def sum_of_laws(
    laws: Mapping[str, Law],
    weather: pd.DataFrame,
    site: "Site",
    on: Mapping[str, float],
) -> float | np.ndarray:
    """
    Sum of the laws that are on.

    Parameters
    ----------
    laws : dict of callable
        Laws of one changed quantity by their switch, such as ``BACK``.
    weather : pandas.DataFrame, shape (rows, columns)
        Result of `weather`.
    site : Site
        The site.
    on : dict of float
        Amplitudes by switch.

    Returns
    -------
    float or numpy.ndarray, shape (rows,)
        In the unit of the laws; the number 0 if none is on.
    """
    some = [on[name] * law(weather, site) for name, law in laws.items() if on[name]]
    return sum(some, start=0.0)
