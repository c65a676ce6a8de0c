"""What an effect may need beside the measured columns, computed from them."""

import numpy as np

from pvlib_fem.relaxation import relax

STEFAN_BOLTZMANN = 5.670374419e-8  # W/(m² K⁴), CODATA 2018
ZERO_CELSIUS = 273.15  # K
YEAR = 365.2425 * 86400.0  # s
DRYING = 900.0  # s that a film of water keeps its memory of rain
CLEANING = 1.0  # mm of rain in an hour that clean a module


def sky_deficit(longwave_down, temp_air, seconds):
    """Longwave that the sky lacks beside a black body at air temperature. [W/m²]"""
    return STEFAN_BOLTZMANN * (temp_air + ZERO_CELSIUS) ** 4 - longwave_down


def wetness(precipitation, seconds):
    """Share of a module that is wet: 1 in rain, and drying after it. [-]"""
    falling = np.where(np.isnan(precipitation), np.nan, precipitation > 0)
    return np.minimum(1.0, 3.0 * relax(falling * 1.0, steps_of(seconds), DRYING))


def days_since_rain(precipitation, seconds):
    """Time since rain that cleans, or since the record began. [days]"""
    rain = np.nan_to_num(precipitation)
    hourly = relax(rain, steps_of(seconds), 3600.0)  # mm/h over about an hour
    last = np.where(hourly >= CLEANING, seconds, seconds[0])
    return (seconds - np.maximum.accumulate(last)) / 86400.0


def years(seconds):
    """Time since the record began. [years]"""
    return (seconds - seconds[0]) / YEAR


def steps_of(seconds):
    return np.diff(seconds, prepend=seconds[0])


#: name: (measured columns that it needs, how to compute it from them)
DERIVED = {
    "sky_deficit": (("longwave_down", "temp_air"), sky_deficit),
    "wetness": (("precipitation",), wetness),
    "days_since_rain": (("precipitation",), days_since_rain),
    "years": ((), years),
}

USUAL = ("poa_global", "temp_air", "wind_speed")
#: other names that pvlib has for a column
ALIASES = {"ir_down": "longwave_down"}


def needed_for(names):
    """Measured columns behind drivers beside the usual three, each once."""
    columns = []
    for name in names:
        for column in DERIVED.get(name, ((name,),))[0]:
            if column not in (*USUAL, *columns):
                columns.append(column)
    return columns


def completed(columns, names, seconds):
    """The columns with those drivers that are derived from them."""
    columns = dict(columns)
    for name in names:
        if name in DERIVED and name not in columns:
            needs, compute = DERIVED[name]
            columns[name] = compute(*(columns[n] for n in needs), seconds)
    return columns
