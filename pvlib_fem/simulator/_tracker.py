"""A single-axis tracker, and the days on which it is stuck."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import pvlib
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from pvlib_fem.simulator._site import Site


@dataclass(frozen=True)
class Stuck:
    """
    Days on which a row of a tracker does not turn.

    Parameters
    ----------
    start, end : str
        First day, and the first day after it.
    angle : float
        Rotation about the axis, as pvlib's ``tracker_theta``: with an axis from north
        to south (``axis_azimuth=180``), east is negative. [°]
    """

    start: str = "2023-07-03"
    end: str = "2023-07-17"
    angle: float = -35.0

    def __post_init__(self) -> None:
        if not pd.Timestamp(self.start) < pd.Timestamp(self.end):
            raise ValueError(f"start = {self.start!r} is not before end = {self.end!r}")

    def during(self, times: pd.DatetimeIndex) -> np.ndarray:
        """Whether each time is on one of its days."""
        first, last = (pd.Timestamp(day, tz=times.tz) for day in (self.start, self.end))
        return (times >= first) & (times < last)


@dataclass(frozen=True)
class Tracker:
    """
    A single-axis tracker as `pvlib.tracking.singleaxis` has it, level at night.

    Rows do not shade each other: without ``backtrack`` a low sun still reaches all.

    Parameters
    ----------
    axis_tilt, axis_azimuth : float
        Orientation of the axis; azimuth from north, clockwise. [°]
    max_angle : float
        Largest rotation to either side. [°]
    gcr : float
        Width of a row over the distance of rows. [-]
    backtrack : bool
        Whether rows turn back from a low sun so that they do not shade each other.
    stuck : Stuck
        When and where it is stuck, if ``tracker_stuck`` (the row of the modules)
        or ``tracker_stuck_sensor`` (that of the irradiance sensor) is on.
    """

    axis_tilt: float = 0.0
    axis_azimuth: float = 180.0
    max_angle: float = 60.0
    gcr: float = 0.35
    backtrack: bool = True
    stuck: Stuck = field(default_factory=Stuck)

    def __post_init__(self) -> None:
        if isinstance(self.stuck, Mapping):  # from a record's attrs
            object.__setattr__(self, "stuck", Stuck(**self.stuck))

    def rotation(self, weather: pd.DataFrame) -> np.ndarray:
        """Rotation about the axis, 0 at night. [°]"""
        turned = pvlib.tracking.singleaxis(
            90.0 - weather["elevation"].to_numpy(),
            weather["azimuth"].to_numpy(),
            self.axis_tilt,
            self.axis_azimuth,
            self.max_angle,
            self.backtrack,
            self.gcr,
        )
        return np.nan_to_num(turned["tracker_theta"])

    def plane(self, angle: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Tilt and azimuth of rows that are rotated by an angle. [°]"""
        angles = pvlib.tracking.calc_surface_orientation(
            angle, self.axis_tilt, self.axis_azimuth
        )
        return angles["surface_tilt"], angles["surface_azimuth"]


def orientation(
    weather: pd.DataFrame, site: "Site", stuck: float = 0.0
) -> tuple[float | np.ndarray, float | np.ndarray]:
    """
    Tilt and azimuth of a plane at a site: numbers, or rows of a tracker.

    Parameters
    ----------
    weather : pandas.DataFrame, shape (rows, columns)
        Result of `weather`, with the position of the sun.
    site : Site
        With a fixed plane or a tracker.
    stuck : float, default 0
        Weight of the angle of the days on which the tracker is stuck, on these days; 0
        is a tracker that turns. [-]

    Returns
    -------
    tilt, azimuth : float or numpy.ndarray, shape (rows,)
        Azimuth from north, clockwise. [°]

    Raises
    ------
    ValueError
        If a fixed plane is to be stuck.
    """
    tracker = site.tracker
    if tracker is None:
        if stuck:
            raise ValueError(
                "a fixed plane is never stuck; give the site a Tracker, or set "
                "tracker_stuck and tracker_stuck_sensor to 0"
            )
        return site.surface_tilt, site.surface_azimuth
    angle = tracker.rotation(weather)
    if stuck:
        away = tracker.stuck.angle - angle
        angle = (
            angle + stuck * tracker.stuck.during(pd.DatetimeIndex(weather.index)) * away
        )
    return tracker.plane(angle)
