"""Drivers in another unit, or not what their name says."""

import numpy as np

from pvlib_fem.quality.limits import Limits
from pvlib_fem.record.checks import POSSIBLE


def doubtful(columns, limits=None) -> dict[str, str]:
    """
    Drivers that look to be in another unit, or not what their name says.

    The four columns that every fit needs are checked by ``records.measured``.

    Parameters
    ----------
    columns : mapping
        Name to values, as pvlib names them, among them ``poa_global`` [W/m²].
    limits : Limits, optional

    Returns
    -------
    dict
        Name to one line with the remedy; such a column should not be used.

    Examples
    --------
    >>> doubtful({"relative_humidity": [0.4, 0.9]})["relative_humidity"]
    'relative_humidity is 0.9 at most, a fraction; multiply it by 100 for %'
    """
    limits = limits or Limits()
    columns = {name: np.asarray(values, float) for name, values in columns.items()}
    found = {}
    for name, values in columns.items():
        seen = values[np.isfinite(values)]
        if name in POSSIBLE or not len(seen):
            continue
        kind = "temp_" if name.startswith("temp_") else name
        reason = DOUBTS[kind](seen, limits) if kind in DOUBTS else ""
        if name == "p_dc" and "poa_global" in columns:
            reason = power_doubt(values, columns["poa_global"], limits)
        if reason:
            found[name] = f"{name} {reason}"
    return found


def often(odd, limits):
    return np.mean(odd) > limits.odd_share


def humidity_doubt(seen, limits):
    if seen.max() <= limits.largest_fraction:
        return f"is {seen.max():.2g} at most, a fraction; multiply it by 100 for %"
    if often((seen < 0) | (seen > limits.largest_humidity), limits):
        return f"goes from {seen.min():.3g} to {seen.max():.3g}; it should be in %"
    return ""


def longwave_doubt(seen, limits):
    low, high = limits.least_longwave, limits.most_longwave
    if often((seen < low) | (seen > high), limits):
        return (
            f"has a median of {np.median(seen):.0f} W/m², and skies send {low:g} to "
            f"{high:g}; a pyrgeometer's net signal needs the σT⁴ of its body added"
        )
    return ""


def direction_doubt(seen, limits):
    if seen.max() <= limits.largest_radians and len(seen) > limits.few_values:
        return f"is {seen.max():.2g} at most, radians; use np.degrees"
    if often((seen < 0) | (seen > 360), limits):
        return f"goes from {seen.min():.0f} to {seen.max():.0f}°; use it modulo 360"
    return ""


def rain_doubt(seen, limits):
    if (seen < 0).any():
        return f"is {seen.min():.3g} at least; a counter needs its resets taken out"
    return ""


def snow_doubt(seen, limits):
    if often(seen < 0, limits):
        return f"is {seen.min():.3g} at least; set the zero of the gauge"
    return ""


def kelvin_doubt(seen, limits):
    if np.median(seen) > limits.least_kelvin:
        return f"has a median of {np.median(seen):.0f}, kelvin; subtract 273.15"
    return ""


def power_doubt(power, poa, limits):
    """A module gives a quarter of its light at most; 0.4 leaves room for sensors."""
    sunny = (poa > limits.sunny) & np.isfinite(power)
    ratio = np.median(power[sunny] / poa[sunny]) if sunny.any() else 0.0
    if ratio > limits.most_efficiency:
        return (
            f"is {ratio:.2g} of poa_global, and no module gives "
            f"{limits.most_efficiency:g}; divide W by the area of the modules for W/m²"
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
