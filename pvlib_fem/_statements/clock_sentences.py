"""Clocks that are off as statements: by how much, which way, and how to set them."""

import numpy as np

from pvlib_fem._findings import Correction
from pvlib_fem._statements.statement import Statement

LOGGER, FILE = "clock of the module's logger", "clock of the file"
PLACE = "given place"
APPLIED = "Corrected for this analysis"
#: of a fault: the device, and what to do where no size says it better
ACTIONS = {
    "clock_shift": (LOGGER, "Set the clock of the module's logger"),
    "clock_drift": (LOGGER, "Synchronise the clock of the module's logger"),
    "dst": (LOGGER, "Keep the module's logger on standard time"),
    "file_shift": (FILE, "State the time zone that the file is in, or the location"),
    "file_dst": (FILE, "Keep the logger on standard time, or state its time zone"),
    "file_jump": (FILE, "Synchronise the logger's clock"),
    "file_latitude": (PLACE, "State the latitude with its sign, or look at the dates"),
    "file_plane": (PLACE, "Check the angles, the latitude, and how the sensor stands"),
}


def clock_statement(correction: Correction) -> Statement:
    """
    A fault of a clock as a statement.

    Parameters
    ----------
    correction : Correction

    Returns
    -------
    Statement
        ``value`` is positive where timestamps run ahead.
    """
    faults = correction.fault.split("+")
    device, action = ACTIONS[faults[0]]
    key = next(iter(correction.values), "")
    value = correction.values.get(key, np.nan)
    error = correction.stderr.get(key, np.nan)
    if faults == ["clock_shift"]:
        way = "back" if value > 0 else "forward"
        action += f" {way} by {abs(value):.3g} min"
    values = correction.because.all[0].values
    text = values["fault"]
    certainty = APPLIED if correction.applied else f"Not corrected: {values['remedy']}"
    return Statement(
        cause=correction.fault,
        device=device,
        verdict="corrected" if correction.applied else "not corrected",
        text=f"{text[:1].upper()}{text[1:]}",
        action=action,
        certainty=certainty,
        gain=gain_of(correction),
        value=value,
        error=error,
        unit="s/day" if key == "drift" else "min",
    )


def gain_of(correction: Correction) -> float:
    """By how much the correction lowers the error. [K]"""
    if correction.unit != "K" or not correction.applied:
        return np.nan
    fall = correction.before**2 - correction.after**2
    return float(np.sqrt(max(fall, 0.0)))
