"""A second, independent generator: `pvlib.temperature.fuentes`."""

import numpy as np
import pandas as pd
import pvlib

from pvlib_fem.simulator._deposits import ground_albedo, snow_cover
from pvlib_fem.simulator._forcing import (
    AT_MODULE,
    EFFICIENCY,
    electrical_output,
    light,
    undeclared_heats,
    wind_scatter,
)
from pvlib_fem.simulator._schedules import curtailed_hours
from pvlib_fem.simulator._site import Site
from pvlib_fem.simulator._surroundings import AIR, sum_of_laws
from pvlib_fem.simulator._switches import Effects, amplitudes
from pvlib_fem.simulator._tracker import orientation

ABSORPTION = 0.83  # share of sunlight that is heat, pvlib's default
INSTALLED = {"rack": 45.0, "roof": 49.0}  # °C, installed NOCT of PVWatts
HEIGHT = 9.144 * AT_MODULE**5  # m, at which v·(height/9.144)^0.2 is our module's wind

#: switches that this model always includes, and switches that it cannot have
INSIDE = ("radiative_loss", "natural_convection", "wind_shape")
NO_PLACE = ("sky_radiation", "wind_direction", "rain", "dew", "thermal_storage")


def fuentes(weather: pd.DataFrame, site: Site, effects: Effects) -> pd.DataFrame:
    """
    Temperature of a module by M. K. Fuentes, SAND85-0330 (1987), in the same weather.

    Effects on the light of a module change the model's irradiance. Heat sources and
    curtailed output are converted to equivalent irradiance. The model's absorption is
    constant, so ``conversion`` changes only the power, and its sky temperature depends
    on the air. A tracker's natural convection is that of its mean tilt.

    Parameters
    ----------
    weather, site, effects
        See `simulate`. Switches `INSIDE` must be 1, and switches `NO_PLACE` 0.

    Returns
    -------
    DataFrame
        ``temp_back`` and ``temp_cell``, which are equal [°C], ``p_dc_per_area``,
        ``poa_global`` (input of the model [W/m²]).

    Raises
    ------
    ValueError
        If the model does not have a switch.
    """
    on = amplitudes(effects)
    wrong = [name for name in INSIDE if on[name] != 1.0]
    wrong += [name for name in NO_PLACE if on[name] != 0.0]
    if wrong:
        raise ValueError(
            f"fuentes cannot follow {', '.join(wrong)}; set {', '.join(INSIDE)} to 1 "
            f"and {', '.join(NO_PLACE)} to 0, or take generator='nodes'"
        )
    covered = on["snow"] * snow_cover(weather, site)
    sun, rear = light(weather, site, on, covered, ground_albedo(weather, site, on))
    idle = on["electrical_output"] * curtailed_hours(weather)
    front, back = undeclared_heats(weather, site, on)
    heat = front + back + rear + EFFICIENCY * sun * idle
    poa = pd.Series(sun + heat / ABSORPTION, weather.index)
    speed = weather["wind_speed"] * wind_scatter(weather, site, on)
    tilt, _ = orientation(weather, site, on["tracker_stuck"])
    module = pvlib.temperature.fuentes(
        poa,
        weather["temp_air"] + sum_of_laws(AIR, weather, site, on),
        speed,
        INSTALLED[site.mounting],
        module_height=HEIGHT,
        absorption=ABSORPTION,
        surface_tilt=float(np.mean(tilt)),
    )
    constant, slope = electrical_output(sun, idle, on)
    power = np.asarray(constant + slope * module)
    columns = dict(
        temp_back=module, temp_cell=module, p_dc_per_area=power, poa_global=poa
    )
    return pd.DataFrame(columns, index=weather.index)
