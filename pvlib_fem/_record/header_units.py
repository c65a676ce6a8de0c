"""Units as a header names them, and what makes the package's own of them."""

import re
from collections.abc import Mapping

import numpy as np
import pandas as pd
from scipy import constants

from pvlib_fem._record.column_names import is_other_light, is_power, twin_of
from pvlib_fem._record.ranges import as_codes, possible_range
from pvlib_fem._spelling import ShellText, did_you_mean, refusal

FAHRENHEIT = constants.degree_Fahrenheit  # K
INCH = 1000.0 * constants.inch  # mm
#: column: what it is, under the package's names
QUANTITIES = {
    "poa_global": "irradiance",
    "ghi": "irradiance",
    "dni": "irradiance",
    "dhi": "irradiance",
    "poa_rear": "irradiance",
    "temp_air": "temperature",
    "wind_speed": "speed",
    "temp_module": "temperature",
    "wind_direction": "angle",
    "relative_humidity": "share",
    "longwave_down": "irradiance",
    "precipitation": "rain",
    "p_dc_per_area": "power per area",
    "power_dc": "power",
    "power_ac": "power",
    "snow_depth": "depth",
}
#: quantity: unit to the factor and the offset that make the first one of it
UNITS = {
    "irradiance": {
        "W/m²": (1.0, 0.0),
        "kW/m²": (1000.0, 0.0),
        "mW/cm²": (10.0, 0.0),
        "Wh/m²": (1.0, 0.0),
        "kWh/m²": (1000.0, 0.0),
        "J/cm²": (1e4 / constants.hour, 0.0),
        "kJ/m²": (1e3 / constants.hour, 0.0),
        "MJ/m²": (1e6 / constants.hour, 0.0),
    },
    "temperature": {
        "°C": (1.0, 0.0),
        "°F": (FAHRENHEIT, -32.0 * FAHRENHEIT),
        "K": (1.0, -constants.zero_Celsius),
    },
    "speed": {
        "m/s": (1.0, 0.0),
        "km/h": (constants.kmh, 0.0),
        "mph": (constants.mph, 0.0),
        "kn": (constants.knot, 0.0),
        "ft/s": (constants.foot, 0.0),
    },
    "angle": {"°": (1.0, 0.0), "rad": (1.0 / constants.degree, 0.0)},
    "share": {"%": (1.0, 0.0), "fraction": (100.0, 0.0)},
    "rain": {
        "mm/h": (1.0, 0.0),
        "in/h": (INCH, 0.0),
        "mm": (1.0, 0.0),
        "in": (INCH, 0.0),
    },
    "power per area": {
        "W/m²": (1.0, 0.0),
        "kW/m²": (1000.0, 0.0),
        "W": (1.0, 0.0),
        "kW": (1000.0, 0.0),
        "MW": (1e6, 0.0),
        "mW": (1e-3, 0.0),
    },
    "power": {
        "W": (1.0, 0.0),
        "kW": (1000.0, 0.0),
        "MW": (1e6, 0.0),
        "mW": (1e-3, 0.0),
        "Wh": (1.0, 0.0),
        "kWh": (1000.0, 0.0),
        "MWh": (1e6, 0.0),
    },
    "depth": {
        "cm": (1.0, 0.0),
        "mm": (0.1, 0.0),
        "m": (100.0, 0.0),
        "in": (INCH / 10.0, 0.0),
    },
}
#: quantities whose units stand for each other where people write them: a column of
#: light in W or one of a temperature in ° is none of another quantity
ALIKE = (
    ("irradiance", "power per area", "power"),
    ("temperature", "angle"),
    ("rain", "depth"),
)
#: units of what no column of the package holds, as :func:`plain_unit` leaves them
FOREIGN = ("mv", "µv", "uv", "ma", "hz", "hpa", "kpa", "mbar", "lux", "klux", "lx")
#: what falls in one step, of which its length makes a rate
AMOUNTS = {
    "rain": ("mm", "in"),
    "irradiance": ("Wh/m²", "kWh/m²", "J/cm²", "kJ/m²", "MJ/m²"),
    "power": ("Wh", "kWh", "MWh"),
}
#: spans over which a header may state what falls, such as mm/10min [h]
SPANS = {"s": 1.0 / 3600.0, "min": 1.0 / 60.0, "h": 1.0, "d": 24.0}
#: power of all modules, of which their area makes a density
WHOLE = ("W", "kW", "MW", "mW")
#: other spellings, as :func:`plain_unit` leaves them
SPELLINGS = {
    "W/m²": ("w/m2", "wm2", "wm-2", "w/sqm", "watt/m2", "watts/m2"),
    "kW/m²": ("kw/m2", "kwm2", "kwm-2", "kw/sqm"),
    "mW/cm²": ("mw/cm2", "mwcm2"),
    "Wh/m²": ("wh/m2", "whm2", "wh/sqm"),
    "kWh/m²": ("kwh/m2", "kwhm2", "kwh/sqm"),
    "J/cm²": ("j/cm2", "jcm2"),
    "kJ/m²": ("kj/m2", "kjm2"),
    "MJ/m²": ("mj/m2", "mjm2"),
    "°C": ("°c", "℃", "c", "degc", "celsius", "degreesc", "deg.c"),
    "°F": ("°f", "℉", "f", "degf", "fahrenheit", "degreesf", "deg.f"),
    "K": ("k", "kelvin", "degk"),
    "m/s": ("m/s", "ms", "ms-1", "mps", "m/sec", "meters/second", "metres/second"),
    "km/h": ("km/h", "kmh", "kph", "kmph", "kmh-1", "km/hr", "kilometers/hour"),
    "mph": ("mph", "mi/h", "miles/h", "mi/hr", "miles/hour"),
    "kn": ("kn", "kt", "kts", "knot", "knots"),
    "ft/s": ("ft/s", "fts", "fps"),
    "°": ("°", "deg", "degrees", "degree", "°n"),
    "rad": ("rad", "radian", "radians"),
    "%": ("%", "pct", "percent", "%rh"),
    "fraction": ("fraction", "0-1", "0..1"),
    "mm/h": ("mm/h", "mmh", "mm/hr", "mmh-1"),
    "in/h": ("in/h", "in/hr", "inch/h"),
    "mm": ("mm",),
    "in": ("in", "inch", "inches"),
    "W": ("w", "watt", "watts"),
    "kW": ("kw", "kilowatt", "kilowatts"),
    "MW": ("mw", "megawatt", "megawatts"),
    "mW": ("milliwatt", "milliwatts"),
    "Wh": ("wh",),
    "kWh": ("kwh",),
    "MWh": ("mwh",),
    "cm": ("cm",),
    "m": ("m",),
}
WORDS = ("in", "m", "deg")  # units in brackets, words of a name elsewhere


class ForeignUnit(ValueError):
    """``columns`` that look to be in another ``unit``, and ``why``."""

    def __init__(
        self, message: str, columns: tuple = (), unit: str = "", why: str = ""
    ) -> None:
        super().__init__(message)
        self.columns, self.unit, self.why = columns, unit, why


class SwappedTemperatures(ValueError):
    """The temperatures of air and module look to be each other's, and ``why``."""

    def __init__(self, message: str, why: str = "") -> None:
        super().__init__(message)
        self.why = why


def usual_name_of(name: str) -> str | None:
    """
    The column of :data:`QUANTITIES` whose units a column has.

    Parameters
    ----------
    name : str
        Package's name of a column, or another with such a form, as ``temp_air_2``.

    Returns
    -------
    str or None
        None for a column of no known quantity.
    """
    if name in QUANTITIES:
        return name
    if is_other_light(name):
        return "poa_global"
    return "power_ac" if is_power(name) else twin_of(name)


def units_of(name: str) -> dict:
    """Units that a column can have, with factors and offsets; the package's first."""
    return UNITS[QUANTITIES[usual_name_of(name) or name]]


def of_any_unit(name: str) -> tuple[float, float]:
    """
    Least and most that a column can read in any of its units.

    Parameters
    ----------
    name : str
        Column of a known quantity, with a possible range.

    Returns
    -------
    low, high : float
        Numbers without a unit: the lowest and the highest of all units.
    """
    low, high, _ = possible_range(name)
    ways = units_of(name).values()
    ends = [[(end - offset) / factor for end in (low, high)] for factor, offset in ways]
    return min(map(min, ends)), max(map(max, ends))


def own_unit(name: str) -> str:
    """
    The unit in which the package has a column.

    Parameters
    ----------
    name : str
        Column of a known quantity.

    Returns
    -------
    str
        Such as ``"W/m²"``.
    """
    return next(iter(units_of(name)))


def unit_of(name: str, text: str) -> str:
    """
    A unit as somebody writes it, under the package's spelling.

    Parameters
    ----------
    name : str
        Package's name of the column that is in it.
    text : str
        Such as ``"w/m2"`` or ``"degF"``.

    Returns
    -------
    str
        Such as ``"W/m²"`` or ``"°F"``.

    Raises
    ------
    ValueError
        If the column cannot be in that unit.
    """
    if usual_name_of(name) is None:
        raise ValueError(
            f"{name} has no unit that could be converted"
            f"{did_you_mean(name, QUANTITIES)}; those that have one are "
            f"{', '.join(QUANTITIES)}, and second sensors such as temp_air_2"
        )
    known = units_of(name)
    for unit in known:
        if is_spelled(text, unit):
            return unit
    amount, span, hours = over_a_span(text)
    for unit in AMOUNTS.get(QUANTITIES[usual_name_of(name) or name], ()):
        if hours and is_spelled(amount, unit):
            return f"{unit}/{span}"
    raise ValueError(f"{name} cannot be in {text!r}; it may be in {', '.join(known)}")


def named_unit(name: str, header: str) -> str | None:
    """
    The unit that a header names for a column.

    Parameters
    ----------
    name : str
        Package's name of the column.
    header : str
        Such as ``"Wind (mph)"`` or ``"Wind mph"``; brackets are looked at first.

    Returns
    -------
    str or None
        In the package's spelling; None without a unit that the column can be in.
    """
    bare = re.sub(r"[\[({][^\])}]*[\])}]", " ", header)
    words = [
        word for word in re.split(r"[\s_,;:]+", bare) if plain_unit(word) not in WORDS
    ]
    inside = [part for text in bracketed(header) for part in re.split("[,;]", text)]
    # the first word is the column's name, and a unit of two lines is the last one
    for text in (*inside, *words[:0:-1]):
        try:
            return unit_of(name, text)
        except ValueError:
            continue
    return None


def stated_unit(name: str, header: str, below: str = "") -> str | None:
    """
    The unit that a file states for a column.

    Parameters
    ----------
    name : str
        Package's name of the column.
    header : str
        Its header.
    below : str, default ""
        Its cell in a line of units below the header, which is surer than the header.

    Returns
    -------
    str or None
        In the package's spelling; None without a unit that the column can be in.
    """
    try:
        return unit_of(name, below)
    except ValueError:
        return named_unit(name, header)


def stated_columns(
    headers: Mapping[str, str], below: Mapping[str, str] | None = None
) -> list[str]:
    """
    Columns of which a file states that they are in the package's own unit.

    Parameters
    ----------
    headers : dict of str
        By the package's name; a column that is called so names no unit.
    below : dict of str, optional
        Cells of a line of units below the header, by header.

    Returns
    -------
    list of str
        Names of the package.
    """
    units = below or {}
    return [
        name
        for name, header in headers.items()
        if (name != header or header in units)
        and usual_name_of(name) is not None
        and stated_unit(name, header, units.get(header, "")) == own_unit(name)
    ]


def in_other_unit(name: str, header: str, below: str = "") -> bool:
    """
    Whether a header names a unit in brackets that the column of a name cannot have.

    Parameters
    ----------
    name : str
        Package's name, which ``header`` may be of.
    header : str
        Such as ``"SWD [W/m²]"``, which is no direction of the wind.
    below : str, default ""
        Unit that a line below the header gives.

    Returns
    -------
    bool
        False for a unit that is not known, or of a like quantity: light in W.
    """
    if named_unit(name, header) is not None:
        return False
    own = QUANTITIES[usual_name_of(name) or name]
    alike = next((some for some in ALIKE if own in some), (own,))
    texts = [part for text in bracketed(header) for part in re.split("[,;]", text)]
    for text in (*texts, below):
        of = [q for q in UNITS if any(is_spelled(text, unit) for unit in UNITS[q])]
        ambiguous = plain_unit(text) in WORDS
        if plain_unit(text) in FOREIGN or (
            of and not ambiguous and not {*of} & {*alike}
        ):
            return True
    return False


def bracketed(header: str) -> list[str]:
    """What stands in brackets in a header."""
    return re.findall(r"[\[({]([^\])}]*)[\])}]", header)


def is_spelled(text: str, unit: str) -> bool:
    """
    Whether a text is one of the spellings of a unit.

    A text with the letters of a unit is that unit: mW is a thousandth of a watt, while
    mw, which names no prefix, is a million.
    """
    if text.strip() in SPELLINGS:
        return text.strip() == unit
    return plain_unit(text) in (plain_unit(unit), *SPELLINGS[unit])


def over_a_span(text: str) -> tuple[str, str, float]:
    """Amount, span and hours of a unit such as mm/10min; no hours if it has no span."""
    parts = re.fullmatch(r"(.+?)(?:/|per)(\d*)(s|min|h|d)", plain_unit(text))
    if parts is None:
        return text, "", 0.0
    amount, count, span = parts.groups()
    return amount, count + span, int(count or 1) * SPANS[span]


def plain_unit(text: str) -> str:
    """A unit without case, spaces and signs that only look."""
    text = text.strip().lower()
    for sign, letter in (
        ("²", "2"),
        ("㎡", "m2"),
        ("º", "°"),
        ("⁻¹", "-1"),
        ("−", "-"),
    ):
        text = text.replace(sign, letter)
    return re.sub(r"[\s^*·]", "", text)


def converted_column(
    column: pd.Series,
    name: str,
    unit: str,
    hours: float | None = None,
    area: float | None = None,
) -> pd.Series:
    """
    A column in the package's unit.

    Parameters
    ----------
    column : Series
    name : str
        Under the package's names.
    unit : str
        In which it is, as ``"mph"``.
    hours : float, optional
        Length of a step, for rain or light as an amount. [h]
    area : float, optional
        Of the modules, for power that is not per area. [m²]

    Returns
    -------
    Series
        A code such as -9999 stays as it is, so that a screening knows it.

    Raises
    ------
    ValueError
        If the column cannot be in that unit, or the area is needed and not given.
    """
    unit, name = unit_of(name, unit), usual_name_of(name) or name
    known = units_of(name)
    if unit not in known:  # an amount over a span of its own
        unit, hours = unit.rsplit("/", 1)[0], over_a_span(unit)[2]
    factor, offset = known[unit]
    if unit in AMOUNTS.get(QUANTITIES[name], ()):
        if not (hours and hours > 0.0):
            raise ValueError(
                f"{name} is in {unit} of each step, and a single row has no step; give "
                f"more rows, or a unit with the time, such as {unit}/10min"
            )
        factor /= hours
    if name == "p_dc_per_area" and unit in WHOLE:
        if area is None:
            raise refusal(
                f"p_dc_per_area is in {unit}, and W per m² of module are needed; name "
                "it power_dc, or give the area of the modules, ",
                ShellText("module_area=120 (--module-area 120)", "--module-area 120"),
            )
        factor /= area
    if (factor, offset) == (1.0, 0.0):
        return column
    new = factor * column + offset
    return new.mask(stands_for_none(name, column) & impossible_rows(name, new), column)


def stands_for_none(name: str, column: pd.Series) -> np.ndarray:
    """Rows of a logger's codes, which have no unit and so stay as they are."""
    values = column.to_numpy(float, na_value=np.nan)
    return as_codes(values)[0] & impossible_rows(name, column)


def impossible_rows(name: str, column: pd.Series) -> np.ndarray:
    """Rows of values that the column cannot hold."""
    bounds, values = possible_range(name), column.to_numpy(float, na_value=np.nan)
    if bounds is None:  # as of power, which an inverter draws little of by night
        return values < 0
    low, high, _ = bounds
    return (values < low) | (values > high)
