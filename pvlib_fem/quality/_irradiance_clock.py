"""The clock of a second irradiance sensor, or of power, against the first."""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import pandas as pd

from pvlib_fem._record.checks import instants, usual_step
from pvlib_fem.quality._hours import days_of, listed_jumps, side_of
from pvlib_fem.quality._jumps import jumps_of, median_change
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._noon import light_of_days, with_nights
from pvlib_fem.quality._onset import DAY, solar_midnight

HIGH = 0.999  # quantile by which a power has the unit of irradiance


@dataclass(frozen=True, eq=False)
class IrradianceClock:
    """The clock of another column against the first, from :func:`twin_clock`."""

    late: float  # median of the days; NaN where no day has both [s]
    stderr: float  # [s]
    days: pd.Series  # for each day [s]
    jumps: tuple = ()  # (first day after it, seconds)
    line: str = ""  # what is wrong with it; "" where nothing is
    #: rows of the days on which it is off by half an hour and more
    off: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=bool))


def twin_clock(
    poa_global: np.ndarray,
    other: np.ndarray,
    index: pd.DatetimeIndex,
    limits: Limits | None = None,
) -> IrradianceClock:
    """
    By how much one irradiance is ahead of another, by both edges of their light.

    Parameters
    ----------
    poa_global, other : array, shape (rows,)
        Irradiance of two sensors, in any planes, or a power. [W/m², any unit]
    index : DatetimeIndex, shape (rows,)
        Times of both.
    limits : Limits, optional
        The thresholds.

    Returns
    -------
    IrradianceClock
        ``line`` speaks of half an hour and more, which no plane does to the edges of
        the light, and of jumps by as much: there the two have not one clock.

    Notes
    -----
    A clock that is off moves the first and the last light of a day alike. What covers
    one of both until noon moves one of them, and the threshold of an inverter moves
    them apart. So a day counts with the smaller of both moves, and not at all where
    they differ in sign.
    """
    limits = limits or Limits()
    times = instants(index)
    seconds = (times - times[0]) / np.timedelta64(1, "s")
    if len(seconds) < 2 or seconds[-1] < limits.min_record:
        return IrradianceClock(np.nan, np.nan, pd.Series(dtype=float))
    step, dark = usual_step(index), solar_midnight(seconds, poa_global)
    edges = []
    for one in (poa_global, as_irradiance(other, poa_global)):
        light = with_nights(seconds - dark, np.asarray(one, dtype=float), limits)
        day, middle, length = light_of_days(seconds - dark, light, step, limits)
        both = {"rise": middle - length / 2.0, "fall": middle + length / 2.0}
        edges.append(pd.DataFrame(both, day))
    moves = (edges[1] - edges[0]).dropna()
    alike = np.sign(moves["rise"]) == np.sign(moves["fall"])
    apart = (np.sign(moves["rise"]) * moves.abs().min(axis=1)).where(alike, 0.0)
    if len(apart) < limits.noon_window:
        return IrradianceClock(np.nan, np.nan, pd.Series(dtype=float))
    number, middle = apart.index.to_numpy(), apart.to_numpy()
    noon_jumps = (
        jumps_of(number, middle, limits) if step <= limits.max_noon_step else []
    )
    dates = days_of(index[0], dark + number * DAY)
    jumps = tuple((dates[jump["at"]], jump["by"]) for jump in noon_jumps)
    days = pd.Series(middle, dates)
    late, stderr, _ = median_change(np.zeros(1), days.to_numpy())
    begins = [0, *(jump["at"] for jump in noon_jumps), len(number)]
    off = np.zeros(len(index), dtype=bool)
    of_row = np.floor((seconds - dark) / DAY)
    for first, end in pairwise(begins):
        if abs(np.median(middle[first:end])) > limits.daylight_tolerance:
            since = number[first] if first else -np.inf
            until = number[end] if end < len(number) else np.inf
            off |= (of_row >= since) & (of_row < until)
    parts = []
    if abs(late) > limits.daylight_tolerance:
        error = max(stderr / 60, 1)
        parts.append(
            f"run {abs(late) / 60:.0f} ± {error:.0f} min {side_of(late)} those of "
            "poa_global"
        )
    if jumps:
        parts.append(f"jump against those of poa_global by {listed_jumps(jumps)}")
    line = " and ".join(parts)
    return IrradianceClock(float(late), float(stderr), days, jumps, line, off)


def as_irradiance(other: np.ndarray, poa_global: np.ndarray) -> np.ndarray:
    """A column in the unit of the irradiance with the same high values. [W/m²]"""
    other = np.asarray(other, dtype=float)
    if not np.isfinite(other).any():
        return other
    high = np.nanquantile(other, HIGH)
    return other * (np.nanquantile(poa_global, HIGH) / high) if high > 0 else other
