"""The registry of derived drivers: the columns and the function of each.

The function of a driver takes its columns and, last, the
:class:`~pvlib_fem._record.inputs.Inputs` that hold them, with the times. Its
keyword-only arguments are constants that a user can set.
"""

import inspect
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

from pvlib_fem._record.column_names import GEOMETRY, PLANT_POWER, kind_of_power
from pvlib_fem._record.inputs import Inputs
from pvlib_fem.drivers._lagged_inputs import (
    HOUR,
    air_of_weeks,
    day,
    day_angle,
    elapsed,
    past_minus_present,
    weighted_past,
)
from pvlib_fem.drivers._plant_irradiance import frost_past_day, of_column
from pvlib_fem.drivers._sky_deficit import (
    cloud_share,
    sky_deficit,
    sky_deficit_air,
    sky_deficit_clouds,
    sky_deficit_humid,
    sky_deficit_moist,
)
from pvlib_fem.drivers._solar import (
    aoi_projection,
    beam,
    beam_around,
    beam_by_azimuth,
    beam_by_tilt,
    beam_clear,
    clearness,
    ghi_estimated,
    sun_east,
    sun_north,
)
from pvlib_fem.drivers._water import (
    days_since_rain,
    film_vapour,
    hours_since_rain,
    snow_cover,
    snow_left,
    wetness,
)
from pvlib_fem.drivers._wind_components import wind_east, wind_north

#: name: (columns that it needs, function of these and the times)
DERIVED = {
    "aoi_projection": (GEOMETRY, aoi_projection),
    "clearness": (
        ("poa_global", "solar_zenith", "surface_tilt", "aoi_projection"),
        clearness,
    ),
    "beam": (("poa_global", "clearness", "aoi_projection"), beam),
    "beam_clear": (("solar_zenith", "aoi_projection"), beam_clear),
    "elapsed": ((), elapsed),
    "beam_around": (("beam", "beam_clear", "elapsed"), beam_around),
    "ghi_estimated": (("clearness", "solar_zenith"), ghi_estimated),
    "beam_by_tilt": (("beam", "aoi_projection", *GEOMETRY), beam_by_tilt),
    "beam_by_azimuth": (("beam", "aoi_projection", *GEOMETRY), beam_by_azimuth),
    "sky_deficit": (("longwave_down", "temp_air"), sky_deficit),
    "sky_deficit_moist": (("relative_humidity", "temp_air"), sky_deficit_moist),
    "cloud_share": (("clearness", "solar_zenith"), cloud_share),
    "sky_deficit_humid": (("sky_deficit_moist", "cloud_share"), sky_deficit_humid),
    "sky_deficit_air": (("temp_air",), sky_deficit_air),
    "sky_deficit_clouds": (("sky_deficit_air", "cloud_share"), sky_deficit_clouds),
    "film_vapour": (
        ("wetness", "relative_humidity", "temp_air", "temp_base"),
        film_vapour,
    ),
    "wetness": (("precipitation",), wetness),
    "days_since_rain": (("precipitation",), days_since_rain),
    "hours_since_rain": (("precipitation",), hours_since_rain),
    "snow_cover": (("snow_depth", "temp_air", "poa_global"), snow_cover),
    "snow_left": (("snow_cover", "snow_depth", "temp_air", "poa_global"), snow_left),
    "frost_past_day": (("temp_air",), frost_past_day),
    **{n: made for power in PLANT_POWER for n, made in of_column(power).items()},
    "poa_past_1h": (("poa_global",), weighted_past(HOUR)),
    "poa_past_3h": (("poa_global",), weighted_past(3.0 * HOUR)),
    "air_past": (("temp_air",), weighted_past(3.0 * HOUR)),
    "air_of_weeks": (("temp_air",), air_of_weeks),
    "poa_stored_1h": (("poa_past_1h", "poa_global"), past_minus_present),
    "poa_stored_3h": (("poa_past_3h", "poa_global"), past_minus_present),
    "air_stored": (("air_past", "temp_air"), past_minus_present),
    "wind_north": (("wind_speed", "wind_direction"), wind_north),
    "wind_east": (("wind_speed", "wind_direction"), wind_east),
    "sun_north": (("solar_azimuth",), sun_north),
    "sun_east": (("solar_azimuth",), sun_east),
    "day": ((), day),
    "day_angle": ((), day_angle),
}

#: measured columns: description and unit
MEASURED = {
    "poa_global": "Irradiance in the plane of the module. [W/m²]",
    "temp_air": "Air temperature. [°C]",
    "wind_speed": "Wind speed. [m/s]",
    "wind_direction": "Direction that the wind comes from, clockwise from north. [°]",
    "relative_humidity": "Relative humidity. [%]",
    "longwave_down": "Longwave irradiance from the sky, ``ir_down`` in pvlib. [W/m²]",
    "poa_rear": "Irradiance on the rear side of the module. [W/m²]",
    "precipitation": "Rate of precipitation, as water. [mm/h]",
    "snow_depth": "Depth of snow on the ground. [cm]",
    "p_dc_per_area": "DC power for each square metre of module. [W/m²]",
    "power_dc": "DC power of a module or a plant. [W]",
    "power_ac": "AC power of a module or a plant. [W]",
    "solar_zenith": "Angle of the sun from the vertical. [°]",
    "solar_azimuth": "Azimuth of the sun, clockwise from north. [°]",
    "surface_tilt": "Tilt of the module from horizontal. [°]",
    "surface_azimuth": "Azimuth of the module, clockwise from north. [°]",
}
USUAL = ("poa_global", "temp_air", "wind_speed")

#: modelled columns: description and unit
MODELLED = {
    "temp_base": "Temperature of the module by the model without effects. [°C]",
    "loss_base": "Loss by the model without effects. [W/(m² K)]",
    "air_base": "Heat for each K of warmer air, by the fitted model. [W/(m² K)]",
    "capacity_base": "Heat capacity by the fitted model. [J/(m² K)]",
}


class Driver(str):
    """
    A derived driver with constants of its own.

    Parameters
    ----------
    name : str
        Name in :data:`DERIVED`.
    **settings : float
        Constants of its function, or of a function that computes one of its columns.

    Examples
    --------
    >>> Driver("days_since_rain", cleaning=6.0, within=24.0)
    'days_since_rain(cleaning=6, within=24)'
    """

    def __new__(cls, name: Any, **settings: Any) -> Any:
        given = ", ".join(f"{key}={value:g}" for key, value in settings.items())
        driver: Any = super().__new__(cls, f"{name}({given})" if given else name)
        driver.name, driver.settings = name, settings
        return driver


def constants(name: str) -> dict[str, float]:
    """
    Constants of a driver and of the drivers that it needs, with their values.

    Parameters
    ----------
    name : str or Driver

    Returns
    -------
    dict
        Value by name of the constant; empty for a column that is not derived. A
        :class:`Driver` has its own values.
    """
    values = dict(getattr(name, "settings", {}))
    if (name := getattr(name, "name", name)) not in DERIVED:
        return {}
    needs, compute = DERIVED[name]
    for needed in needs:
        values = {**constants(needed), **values}
    return {**own_constants(compute), **values}


def own_constants(function: Callable, besides: Any = ()) -> dict:
    """
    Keyword-only arguments of a function, with their defaults.

    Parameters
    ----------
    function : callable
    besides : collection of str, optional
        Arguments that are no constants.

    Returns
    -------
    dict
        Default by name of the argument.
    """
    taken = after_the_star(function)
    return {name: value for name, value in taken.items() if name not in besides}


@lru_cache(maxsize=256)  # a signature takes as long as a short column
def after_the_star(function: Callable) -> dict:
    taken = inspect.signature(function).parameters.values()
    return {p.name: p.default for p in taken if p.kind is p.KEYWORD_ONLY}


def with_constants(name: str, settings: dict) -> str:
    """
    A driver with its own constants among some settings.

    Parameters
    ----------
    name : str or Driver
    settings : dict
        Values by name; those of other drivers are ignored.

    Returns
    -------
    str or Driver
        The name as it was given if no setting is of this driver.
    """
    own = {key: value for key, value in settings.items() if key in constants(name)}
    if not own:
        return name
    own = {**getattr(name, "settings", {}), **own}
    return Driver(getattr(name, "name", name), **own)


def made_of(name: str) -> tuple[list, Callable, dict]:
    """Columns, function and constants of a derived driver."""
    settings = getattr(name, "settings", {})
    needs, compute = DERIVED[getattr(name, "name", name)]
    needs = [with_constants(needed, settings) for needed in needs]
    own = {key: settings[key] for key in own_constants(compute) if key in settings}
    return needs, compute, own


def is_derived(name: str) -> bool:
    """
    Whether a driver is computed from measured columns.

    Parameters
    ----------
    name : str or Driver

    Returns
    -------
    bool
    """
    return getattr(name, "name", name) in DERIVED


#: whether there is no power, by the name of each column of it
POWER_OFF = tuple(f"power_off{kind_of_power(power)}" for power in PLANT_POWER)
#: drivers of a row that depend on rows hours or weeks before or after it
REMEMBERED = (
    *("beam_around", "cloud_share", "wetness", "days_since_rain"),
    *("snow_cover", "snow_left", "poa_past_1h", "poa_past_3h", "air_past"),
    *("air_of_weeks", "frost_past_day", *POWER_OFF),
)

#: drivers of these with a memory of hours, and the constant that sets it [s]
SHORT = {"wetness": "drying"}
#: drivers of these that are known in rows without their columns
THROUGHOUT = ("days_since_rain", "frost_past_day", *POWER_OFF)


def drivers_with_memory(names: Sequence) -> list[str]:
    """
    Drivers among these, or needed by them, that depend on other rows.

    Parameters
    ----------
    names : sequence of str or Driver

    Returns
    -------
    list of str or Driver
        Each once.
    """
    drivers = []
    for name in filter(is_derived, names):
        known = getattr(name, "name", name) in REMEMBERED
        more = [name] if known else drivers_with_memory(made_of(name)[0])
        drivers += [one for one in more if one not in drivers]
    return drivers


def underived(names: Sequence) -> list[str]:
    """
    Underived columns that drivers need, each once.

    Parameters
    ----------
    names : sequence of str or Driver
        Columns that are not derived are returned as they are.

    Returns
    -------
    list of str
        Measured and modelled columns, and the user's own.
    """
    columns = []
    for name in names:
        needed = underived(made_of(name)[0]) if is_derived(name) else [name]
        columns += [n for n in needed if n not in columns]
    return columns


def short_memory(name: str) -> float | None:
    """
    Time constant of a driver with a memory of hours; None for others. [s]

    Parameters
    ----------
    name : str or Driver

    Returns
    -------
    float or None
        In s.
    """
    constant = SHORT.get(getattr(name, "name", name))
    return constants(name)[constant] if constant else None


def lost_without(name: str) -> tuple[str, ...]:
    """
    Columns without which a row has no value of a derived driver.

    Parameters
    ----------
    name : str or Driver

    Returns
    -------
    tuple of str
        Empty for a driver that is known in all rows.
    """
    return () if getattr(name, "name", name) in THROUGHOUT else tuple(underived([name]))


def is_modelled(names: Sequence[str]) -> bool:
    """
    Whether any driver depends on a result of the model without effects.

    Parameters
    ----------
    names : sequence of str or Driver

    Returns
    -------
    bool
    """
    return not {*MODELLED}.isdisjoint(underived(names))


def needed_for(names: Sequence) -> list[str]:
    """
    Measured columns that drivers need in addition to the usual three.

    Parameters
    ----------
    names : sequence of str or Driver

    Returns
    -------
    list of str
        Columns other than irradiance, air temperature and wind speed, each once.
    """
    return [name for name in underived(names) if name not in (*USUAL, *MODELLED)]


def own_columns(names: Sequence) -> set[str]:
    """
    Measured columns that drivers need beyond the usual three and the sun.

    Parameters
    ----------
    names : sequence of str or Driver

    Returns
    -------
    set of str
    """
    return {*needed_for(names)} - {*GEOMETRY}


def derive_drivers(inputs: Inputs, names: Sequence) -> Inputs:
    """
    The inputs, completed by derived drivers and the columns that they need.

    Parameters
    ----------
    inputs : Inputs
        With the columns of :func:`underived`.
    names : sequence of str or Driver
        Columns that are not derived, or that are there, are not computed.

    Returns
    -------
    Inputs
        All columns have shape (rows,).

    Raises
    ------
    KeyError
        If a column is missing.
    """
    for name in names:
        if is_derived(name) and name not in inputs.columns:
            needs, compute, own = made_of(name)
            inputs = derive_drivers(inputs, needs)
            values = compute(*(inputs[n] for n in needs), inputs, **own)
            inputs = inputs.having({name: values})
    return inputs
