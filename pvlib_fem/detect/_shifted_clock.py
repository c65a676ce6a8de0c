"""Shifts of a record's clock, by irradiance or power."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from pvlib.location import Location
from pvlib.pvsystem import AbstractMount

from pvlib_fem._record.checks import usual_step
from pvlib_fem._statistics.changing_level import Path
from pvlib_fem.detect._checked_series import checked_series
from pvlib_fem.detect._daily_clock import GRID, MEMORY, clock_of
from pvlib_fem.detect._daily_noon import noons
from pvlib_fem.drivers import checked_place
from pvlib_fem.drivers._mounts import PLANE
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._stray_times import refuse_stray

LABELS = ("left", "center", "right")
FEWEST = 10  # days with light
ZONE = 60.0  # min, by which zones differ
SLACK = 30.0  # min, that plane, horizon and inverter may be off all the time
NEAR = 5.0  # min, from a multiple of 15 min within which a size is that
SURE = 3.0  # errors of a size by which it is not


@dataclass(frozen=True, eq=False)
class TimeShifts:
    """
    How the clock of a record was off on each day, from :func:`time_shifts`.

    Attributes
    ----------
    minutes : Series
        For each day: how far the timestamps are ahead of correct ones, negative if
        they are behind; NaN where too few days have light. [min]
    jumps : tuple
        First day of each other clock, and by how much it is ahead of the one before.
        [min]
    within : tuple
        First and last day on which each jump may be: the days from the last light by
        the clock before to the first by the other.
    middle : Series
        For each day with light: how much later than due its middle is. [min]
    usual : float
        What of that is the plane's, the horizon's or the inverter's. [min]
    noise : float
        Mean deviation of the middle of one day. [min]
    """

    minutes: pd.Series
    jumps: tuple
    within: tuple
    middle: pd.Series
    usual: float
    noise: float

    @property
    def shifted(self) -> pd.Series:
        """Whether the clock is off on each day."""
        return self.minutes.fillna(0.0) != 0.0

    def __str__(self) -> str:
        if self.minutes.isna().all():
            return f"fewer than {FEWEST} days have light from dark to dark: no clock"
        days = np.append(0, np.flatnonzero(self.minutes.diff().fillna(0.0)))
        parts = self.minutes.iloc[days]
        return "\n".join(f"{d:%Y-%m-%d}  {by:+.0f} min" for d, by in parts.items())


def time_shifts(
    light: pd.Series,
    location: Location,
    surface_tilt: float | pd.Series | None = None,
    surface_azimuth: float | pd.Series | None = None,
    label: str = "left",
    mount: AbstractMount | None = None,
) -> TimeShifts:
    """
    Days on which the clock of a record is off, and by how much.

    Parameters
    ----------
    light : Series
        Irradiance or power, in any unit and positive by day; what a plant uses by night
        is negative. Times without a zone are local standard time.
    location : pvlib.location.Location
    surface_tilt, surface_azimuth : float or Series, optional
        Of the plane; a flat one by default. [°]
    label : str, default "left"
        Which end of its interval names the mean in a row, as in
        :py:meth:`pandas.DataFrame.resample`; ``"center"`` also for single values.
    mount : pvlib.pvsystem.SingleAxisTrackerMount, optional
        Of modules on a tracker, instead of the angles.

    Returns
    -------
    TimeShifts

    Raises
    ------
    TypeError
        If ``light`` is no Series with a DatetimeIndex.
    ValueError
        If its times are not in order, a few are years from all others, its values are
        no numbers or negative by day, or ``label`` is unknown.

    Notes
    -----
    The middle between first and last light needs no clear sky, and a turned plane
    hardly moves it. It is that of :func:`screen_record`, with 2 % of full light as the
    edge. Its difference from the sun's is the sum of a clock, on a grid of 15 min, of
    what comes back with the year (5 min for each of two harmonics), of a constant, and
    of Laplace's noise. A clock is set anew on a day with a chance of 1e-4, by an hour
    with 1e-3; the most probable clock of all days together is Viterbi's path [1]_.

    A constant within half an hour is the plane's, beyond it whole hours are the
    clock's: of two clocks, the one kept for longer within half an hour of the sun is
    the correct one. Rows of an hour hardly show a shift by 15 min.

    References
    ----------
    .. [1] G. D. Forney, "The Viterbi algorithm", Proc. IEEE 61, 268-278, 1973.
       :doi:`10.1109/PROC.1973.9030`

    Examples
    --------
    >>> from pvlib.location import Location
    >>> from pvlib_fem import detect, simulator
    >>> site = simulator.RHINE
    >>> data = simulator.record(days=90, step=900)
    >>> place = Location(site.latitude, site.longitude, tz=site.tz)
    >>> poa = data["poa_global"].copy()
    >>> poa.loc["2023-02-20":] = poa.shift(3)  # 45 min ahead
    >>> print(detect.time_shifts(poa, place, label="center"))
    2023-01-01  +0 min
    2023-02-20  +45 min
    """
    if label not in LABELS:
        raise ValueError(f"label = {label!r}; it is {', '.join(map(repr, LABELS))}")
    if location is None:
        raise ValueError("location is None; give a pvlib.location.Location")
    place = checked_place(location, surface_tilt, surface_azimuth, mount)
    index, (values,) = checked_series(light=light)
    refuse_stray(index, Limits())
    plane = tuple(place[name] for name in PLANE)
    middle = noons(values, index, location, plane, label)
    local = index.tz_localize(None).normalize()
    dates = pd.date_range(local[0], local[-1], freq="D") if len(local) else local
    if len(middle) < FEWEST:
        nothing = pd.Series(np.nan, dates)
        return TimeShifts(nothing, (), (), middle, np.nan, np.nan)
    day = ((middle.index - middle.index[0]) / pd.Timedelta("1D")).to_numpy().astype(int)
    path = clock_of(day, middle.to_numpy(), usual_step(index) / 60.0)
    minutes, usual = sized_shift(path, middle.to_numpy())
    by_day = pd.Series(minutes, middle.index).reindex(dates, method="nearest")
    change = by_day.diff().fillna(0.0)
    jumps = tuple((day, float(by)) for day, by in change[change != 0.0].items())
    new = np.flatnonzero(np.diff(minutes)) + 1
    next_day = pd.Timedelta(days=1)
    within = tuple((middle.index[i - 1] + next_day, middle.index[i]) for i in new)
    return TimeShifts(by_day, jumps, within, middle, usual, path.noise)


def sized_shift(path: Path, middle: np.ndarray) -> tuple[np.ndarray, float]:
    """How far each day's clock is ahead of the sun's, and what is usual. [min]"""
    residual = middle - path.usual - path.level
    clocks, days = np.unique(path.level, return_counts=True)
    level = clocks + np.median(path.usual)
    near = np.abs(level) <= SLACK
    base = int(np.argmax(np.where(near, days, days / days.sum())))
    zone = 0.0 if near[base] else ZONE * round(level[base] / ZONE)
    off = np.median(residual[path.level == clocks[base]])
    minutes = np.zeros(len(middle))
    for clock, number in zip(clocks, days):
        rows = path.level == clock
        rest = float(np.median(residual[rows]) - off)
        error = path.noise * np.sqrt(MEMORY * (1.0 / number + 1.0 / days[base]))
        whole = abs(rest) <= max(NEAR, SURE * error) or abs(rest) > GRID
        size = clock - clocks[base] + (0.0 if whole else round(rest))
        minutes[rows] = size + zone
    return minutes, float(level[base] + off - zone)
