"""The middle of each day's light, of irradiance or power with gaps by night."""

from typing import Any

import numpy as np
import pandas as pd
from pvlib.location import Location

from pvlib_fem._record.checks import usual_step
from pvlib_fem.detect._checked_series import seconds_of
from pvlib_fem.quality._hours import days_of
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._noon import due_light, light_of_days, universal
from pvlib_fem.quality._onset import DAY, solar_midnight

BEST = 0.995  # quantile that stands for full light
FULL = 1000.0  # W/m², at full light


def noons(
    values: np.ndarray,
    index: pd.DatetimeIndex,
    location: Location,
    plane: tuple = (None, None, None),
    label: str = "left",
) -> Any:
    """
    How much later than due the middle of each day's light is.

    Parameters
    ----------
    values : array
        Irradiance or power, in any unit.
    index : DatetimeIndex
    location : pvlib.location.Location
    plane : tuple, default (None, None, None)
        Tilt and azimuth [°], and the mount of a plane that moves.
    label : str, default "left"
        Where the time of a row is in the interval of which it is the mean.

    Returns
    -------
    Series
        For each day. [min]

    Raises
    ------
    ValueError
        If the values are negative where they should be light.
    """
    limits, step = Limits(), usual_step(index)
    if not step > 0.0:  # of a single row
        return pd.Series(dtype=float)
    seconds, values = regular(seconds_of(index), values, step)
    full = np.nanquantile(values, BEST) if np.isfinite(values).any() else 0.0
    if np.nansum(values) < 0.0 and -np.nanquantile(values, 1.0 - BEST) > full:
        raise ValueError(
            f"light is negative, down to {np.nanmin(values):g}; if a meter counts what "
            "a plant feeds as negative, turn its sign, else give rows of whole days"
        )
    if not full > 0.0:
        return pd.Series(dtype=float)
    light = values * (FULL / full)
    middle_of_row = {"left": step / 2.0, "center": 0.0, "right": -step / 2.0}[label]
    dark = solar_midnight(seconds, light)
    if dark > middle_of_row:  # the first row is of the day before
        dark -= DAY
    light = with_dark_nights(seconds - dark, light, limits)
    day, middle, _ = light_of_days(seconds - dark + middle_of_row, light, step, limits)
    begins = pd.Timedelta(seconds=dark)
    origin, start = universal(index[0], location) + begins, index[0] + begins
    due, _ = due_light(origin, day, location, plane, limits, start)
    late = middle - due
    late = (late + DAY / 2) % DAY - DAY / 2
    known = np.isfinite(late)
    dates = days_of(index[0], dark + day[known] * DAY)
    late = pd.Series(late[known] / 60.0, dates.tz_localize(None))
    return late[~late.index.duplicated()]


def regular(
    seconds: np.ndarray, values: np.ndarray, step: float
) -> tuple[np.ndarray, np.ndarray]:
    """The record at regular times, with NaN in missing rows."""
    place = np.round(seconds / step).astype(int)
    if (np.diff(place) == 1).all():
        return seconds, values
    times = np.arange(place[-1] + 1) * step
    filled = np.full(len(times), np.nan)
    times[place], filled[place] = seconds, values
    return times, filled


def with_dark_nights(
    seconds: np.ndarray, light: np.ndarray, limits: Limits
) -> np.ndarray:
    """
    The record with 0 for missing values at night.

    Rows next to the first and the last light stay as they are: where they lack, the
    edge of that day's light is not known.
    """
    day, row = np.floor(seconds / DAY).astype(int), np.arange(len(light))
    lit = np.flatnonzero(light > limits.min_light)
    first, last = np.full(day.max() + 1, -1), np.full(day.max() + 1, len(light))
    first[day[lit[::-1]]] = lit[::-1]
    last[day[lit]] = lit
    outside = (row < first[day] - 1) | (row > last[day] + 1)
    return np.where(outside & np.isnan(light), 0.0, light)
