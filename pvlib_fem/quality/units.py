"""Drivers in another unit, or not what their name says."""

import numpy as np

from pvlib_fem.record.checks import POSSIBLE

LEAST = 5  # values, of which the largest tells of a unit
MOST = 0.01  # share of odd values that is still an accident


def doubtful(columns) -> dict[str, str]:
    """
    Drivers that look to be in another unit, or not what their name says.

    The four columns that every fit needs are checked by ``records.measured``.

    Parameters
    ----------
    columns : mapping
        Name to values, as pvlib names them, among them ``poa_global`` [W/m²].

    Returns
    -------
    dict
        Name to one line with the remedy; such a column should not be used.

    Examples
    --------
    >>> doubtful({"relative_humidity": [0.4, 0.9]})["relative_humidity"]
    'relative_humidity is 0.9 at most, a fraction; multiply it by 100 for %'
    """
    columns = {name: np.asarray(values, float) for name, values in columns.items()}
    found = {}
    for name, values in columns.items():
        seen = values[np.isfinite(values)]
        if name in POSSIBLE or not len(seen):
            continue
        kind = "temp_" if name.startswith("temp_") else name
        reason = DOUBTS[kind](seen) if kind in DOUBTS else ""
        if name == "p_dc" and "poa_global" in columns:
            reason = power_doubt(values, columns["poa_global"])
        if reason:
            found[name] = f"{name} {reason}"
    return found


def share(odd):
    return np.mean(odd) > MOST


def humidity_doubt(seen):
    if seen.max() <= 1.5:
        return f"is {seen.max():.2g} at most, a fraction; multiply it by 100 for %"
    if share((seen < 0) | (seen > 110)):
        return f"goes from {seen.min():.3g} to {seen.max():.3g}; it should be in %"
    return ""


def longwave_doubt(seen):
    if share((seen < 100) | (seen > 550)):
        return (
            f"has a median of {np.median(seen):.0f} W/m², and skies send 100 to 550; a "
            "pyrgeometer's net signal needs the σT⁴ of its body added"
        )
    return ""


def direction_doubt(seen):
    if seen.max() <= 6.3 and len(seen) > LEAST:
        return f"is {seen.max():.2g} at most, radians; use np.degrees"
    if share((seen < 0) | (seen > 360)):
        return f"goes from {seen.min():.0f} to {seen.max():.0f}°; use it modulo 360"
    return ""


def rain_doubt(seen):
    if (seen < 0).any():
        return f"is {seen.min():.3g} at least; a counter needs its resets taken out"
    return ""


def snow_doubt(seen):
    if share(seen < 0):
        return f"is {seen.min():.3g} at least; set the zero of the gauge"
    return ""


def kelvin_doubt(seen):
    if np.median(seen) > 150:
        return f"has a median of {np.median(seen):.0f}, kelvin; subtract 273.15"
    return ""


def power_doubt(power, poa):
    """A module gives a quarter of its light at most; 0.4 leaves room for sensors."""
    sunny = (poa > 200) & np.isfinite(power)
    ratio = np.median(power[sunny] / poa[sunny]) if sunny.any() else 0.0
    if ratio > 0.4:
        return (
            f"is {ratio:.2g} of poa_global, and no module gives 0.4; divide W by the "
            "area of the modules for W/m²"
        )
    return ""


#: what to ask of a driver by its name
DOUBTS = {
    "relative_humidity": humidity_doubt,
    "longwave_down": longwave_doubt,
    "wind_direction": direction_doubt,
    "precipitation": rain_doubt,
    "snow_depth": snow_doubt,
    "temp_": kelvin_doubt,
}
