"""A record on longer steps, for what does not need short ones."""

from dataclasses import replace

import numpy as np
import pandas as pd

from pvlib_fem.record.checks import Inputs, instants, usual_step

ANGLES = ("wind_direction", "solar_azimuth", "surface_azimuth")


def coarse(record, step=300.0, present=0.5):
    """
    The record in means over longer steps, or as it is where they are long enough.

    An input is held over the step that ends at its sample, so inputs are means up
    to a time, and the module's temperature is the mean around it. ``present`` is the
    share of a step's rows that have to be there.

    Returns
    -------
    Record
    """
    usual = usual_step(record.index)
    if not usual <= step / 2.0:  # or of one row
        return record
    at = instants(record.index)
    since = (at - at[0].astype("datetime64[D]")) / np.timedelta64(1, "s")
    until = np.ceil(since / step - 1e-9).astype(int)
    around = np.floor(since / step + 0.5 - 1e-9).astype(int)
    labels = np.unique(until)
    least = max(1.0, present * step / usual)  # rows of a step
    columns = {}
    for name, values in record.inputs.columns.items():
        place = around if name == "temp_module" else until
        columns[name] = means(values, place, labels, least, name in ANGLES)
    times = at[0].astype("datetime64[D]") + (labels * step * 1e9).astype("m8[ns]")
    index = pd.DatetimeIndex(times)
    if record.index.tz is not None:
        index = index.tz_localize("UTC").tz_convert(record.index.tz)
    gaps = np.diff(labels, prepend=labels[0]).astype(float)
    steps = 1.0 if (gaps[1:] == 1.0).all() else gaps
    return replace(record, inputs=Inputs(columns, steps, step, index, True))


def means(values, place, labels, least, angle):
    """Means of the rows at each label, NaN where too few are there."""
    if angle:
        turned = np.radians(values)
        east, north = (
            means(part, place, labels, least, False)
            for part in (np.sin(turned), np.cos(turned))
        )
        return np.degrees(np.arctan2(east, north)) % 360.0
    there = ~np.isnan(values)
    first = labels[0]
    size = labels[-1] - first + 2  # the last half step has a label of its own
    at = place - first + (place < first)
    counts = np.bincount(at, there, size)
    sums = np.bincount(at, np.where(there, values, 0.0), size)
    kept = labels - first
    enough = counts[kept] >= least
    return np.where(enough, sums[kept] / np.maximum(counts[kept], 1), np.nan)


def covered(mask, record, other):
    """Rows of the coarse record in whose step the mask holds for any row."""
    if other is record:
        return mask
    at, ends = instants(record.index), instants(other.index)
    place = np.searchsorted(ends, at)
    counts = np.bincount(place[mask & (place < len(ends))], minlength=len(ends))
    return counts > 0
