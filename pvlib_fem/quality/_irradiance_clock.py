"""The clock of a second irradiance sensor against the first."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from pvlib_fem._record.checks import instants, usual_step
from pvlib_fem.quality._hours import days_of, listed_jumps, side_of
from pvlib_fem.quality._jumps import jumps_of, median_change
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._noon import light_of_days, with_nights
from pvlib_fem.quality._onset import DAY, solar_midnight


@dataclass(frozen=True, eq=False)
class IrradianceClock:
    """The clock of a second irradiance against the first, from :func:`twin_clock`."""

    late: float  # median of the days; NaN where no day has both [s]
    stderr: float  # [s]
    days: pd.Series  # for each day [s]
    jumps: tuple = ()  # (first day after it, seconds)
    line: str = ""  # what is wrong with it; "" where nothing is


def twin_clock(
    poa_global: np.ndarray,
    other: np.ndarray,
    index: pd.DatetimeIndex,
    limits: Limits | None = None,
) -> IrradianceClock:
    """
    By how much one irradiance is ahead of another, by the middle of their light.

    Parameters
    ----------
    poa_global, other : array, shape (rows,)
        Irradiance of two sensors, in any planes. [W/m²]
    index : DatetimeIndex, shape (rows,)
        Times of both.
    limits : Limits, optional
        The thresholds.

    Returns
    -------
    IrradianceClock
        ``line`` speaks of half an hour and more, which no plane does to the edges of
        the light, and of jumps by as much: there the two have not one clock.
    """
    limits = limits or Limits()
    times = instants(index)
    seconds = (times - times[0]) / np.timedelta64(1, "s")
    if len(seconds) < 2 or seconds[-1] < limits.min_record:
        return IrradianceClock(np.nan, np.nan, pd.Series(dtype=float))
    step, dark = usual_step(index), solar_midnight(seconds, poa_global)
    noons = []
    for one in (poa_global, other):
        light = with_nights(seconds - dark, np.asarray(one, dtype=float), limits)
        day, middle, _ = light_of_days(seconds - dark, light, step, limits)
        noons.append(pd.Series(middle, day))
    apart = (noons[1] - noons[0]).dropna()
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
    return IrradianceClock(float(late), float(stderr), days, jumps, line)
