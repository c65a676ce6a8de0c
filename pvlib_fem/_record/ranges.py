"""What columns can hold, and what loggers write for no value."""

from typing import Any, NamedTuple

import numpy as np


class Range(NamedTuple):
    """What a column can hold; a fact of sensors and of weather, not a threshold."""

    low: float  # that a sensor can have measured
    high: float
    unit: str
    least: float = -np.inf  # of the quantity itself, if that identifies its unit
    most: float = np.inf


#: by column: what a sensor can read, with room for its errors, and what the quantity is
RANGES = {
    # a pyranometer radiates to the sky by night; 2000 W/m² is more than the edge of any
    # cloud gives (Gueymard, 2017, doi:10.1016/j.solener.2017.05.004: 1900 in seconds)
    **dict.fromkeys(
        ("poa_global", "poa_rear", "ghi", "dni", "dhi", "poa_direct", "poa_diffuse"),
        Range(-30.0, 2000.0, "W/m²"),
    ),
    # in 1 % of the rows few places are above 50 °C: Kuwait's summer has 49 °C
    "temp_air": Range(-60.0, 100.0, "°C", most=50.0),
    "temp_module": Range(-60.0, 100.0, "°C"),
    # the median of another temperature is above 150 in kelvin alone
    "temp_": Range(-100.0, 200.0, "°C", most=150.0),
    # near the ground few sites on land have a mean above 5.5 m/s
    "wind_speed": Range(0.0, 60.0, "m/s", most=5.5),
    "wind_direction": Range(-360.0, 720.0, "°", 0.0, 360.0),
    # sensors in fog read above 100 %
    "relative_humidity": Range(-5.0, 110.0, "%", 0.0, 110.0),
    # σT⁴ of −100 and 60 °C; what skies send is that of −60 to 40 °C
    "longwave_down": Range(50.0, 700.0, "W/m²", 100.0, 550.0),
    # the most that fell in a minute is 38 mm (World Meteorological Organization)
    "precipitation": Range(0.0, 2500.0, "mm/h", 0.0),
    # the deepest that was measured is 11.8 m
    "snow_depth": Range(-50.0, 1500.0, "cm", 0.0),
    # by the area of the modules, in a bright second
    "p_dc_per_area": Range(-50.0, 1000.0, "W/m²"),
}

#: what loggers and files write for "no value", and the ends of whole numbers of 16 bits
CODES = np.array(
    [
        *(sign * n for sign in (1, -1) for n in (999, 9999, 99999, 999999, 6999, 7999)),
        *(sign * n for sign in (1, -1) for n in (999.9, 9999.9, 888, 8888)),
        *(999.99, -999.99, -99, -99.9, -99.99, -9998, -888.8),
        *(sign * 32767 * 10.0**-n for sign in (1, -1) for n in range(3)),
        *(-32768 * 10.0**-n for n in range(3)),
        *(65535 * 10.0**-n for n in range(3)),
    ]
)

NO_CODE = -98.0, 327.0  # between which there is none


def as_codes(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    Which of some values are a logger's codes, and how it writes them.

    Parameters
    ----------
    values : array, shape (rows,)
        In any unit; may be NaN.

    Returns
    -------
    code : array of bool, shape (rows,)
    rounded : array, shape (rows,)
        The values with two decimals.
    """
    rounded = np.round(values, 2)
    return np.isin(rounded, CODES) & (np.abs(values - rounded) < 1e-4), rounded


def range_of(name: str) -> Any:
    """
    What a column can hold.

    Parameters
    ----------
    name : str
        Package's name; other temperatures begin with ``temp_``.

    Returns
    -------
    Range or None
        None for a column of which nothing is known.
    """
    other = RANGES["temp_"] if name.startswith("temp_") else None
    return RANGES.get(name, other)


def possible_range(name: str) -> tuple[float, float, str] | None:
    """
    Least and most that a sensor can read.

    Parameters
    ----------
    name : str
        Package's name; other temperatures begin with ``temp_``.

    Returns
    -------
    (float, float, str) or None
        Least, most and their unit; None for a column of which nothing is known.
    """
    known_range = range_of(name)
    return known_range and known_range[:3]
