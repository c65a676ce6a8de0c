"""Days on which irradiance is that of a plane that stands, while a record's turns."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from pvlib.location import Location

from pvlib_fem.drivers import sun
from pvlib_fem.effects._standstill import in_words, rotations
from pvlib_fem.effects._time_profiles import date_text, dates_in_words
from pvlib_fem.quality._plane import WHOLE, Sky, at_rows

LOWEST = 80.0  # ° from the vertical: in winter the sun of high latitudes is no higher
CLEAR = 0.1  # of a day's irradiance, root mean square, by which a clear day may differ
BETTER = 4.0  # times as much as in its own plane a day leaves in one that is not
FEWEST = 2  # clear days in one plane
ALIKE = 10.0  # ° within which planes of several days are one
HAZES = 1.0, 2.0, 4.0  # times the light of a clear sky without its sun
FEWEST_ROWS = 10  # of a day with the sun up
BETWEEN = np.linspace(0.0, 1.0, 11)  # of the way from a plane to the next


@dataclass(frozen=True)
class Standing:
    """
    Days on which the irradiance is that of a plane that is stuck.

    Attributes
    ----------
    start, end : str
        First day, and the first day after it.
    between : tuple of str
        Days between which it began: after one with light of the plane that turns, and
        up to the first clear day.
    surface_tilt, surface_azimuth : float
        Where it stands. [°]
    days : int
        Clear days that show it.
    before, after : float
        What a clear sky in the described plane, and in this one, leaves of these days:
        root mean square as a share of that of the irradiance. [-]
    """

    start: str
    end: str
    between: tuple[str, ...]
    surface_tilt: float
    surface_azimuth: float
    days: int
    before: float
    after: float

    @property
    def when(self) -> str:
        """Its days in words."""
        return dates_in_words({**asdict(self), "between": self.between})

    def __str__(self) -> str:
        return (
            f"from {self.when} the irradiance sensor was stuck "
            f"{in_words(self.surface_tilt, self.surface_azimuth)}, while the record "
            f"describes a plane that turns: on {self.days} clear days a clear sky in "
            f"the described plane leaves {100 * self.before:.0f} % of the irradiance, "
            f"and in that one {100 * self.after:.0f} %; effects of the plane have its "
            "angles"
        )

    def rows(self, index: pd.DatetimeIndex) -> np.ndarray:
        """Rows of some times on its days."""
        local = index.tz_localize(None)
        first, last = pd.Timestamp(self.start), pd.Timestamp(self.end)
        return np.asarray((local >= first) & (local < last))

    def put_into(self, angles: dict[str, np.ndarray], index: pd.DatetimeIndex) -> None:
        """Replace angles of a plane by its own, on its days."""
        rows = self.rows(index)
        for name, values in angles.items():
            values[rows] = getattr(self, name)


def standing_of(
    poa_global: Any,
    index: pd.DatetimeIndex,
    location: Location,
    angles: tuple,
    late: float = 0.0,
) -> tuple[Standing, ...]:
    """
    Days on which an irradiance sensor does not follow the plane that is described.

    On a clear day irradiance has the shape of a clear sky in the sensor's plane. If
    that is not the plane that turns, but one of its angles at which it stands, and in
    the same one on several days without a clear day of the other between them, the
    sensor was stuck.

    Parameters
    ----------
    poa_global : array, shape (rows,)
        [W/m²]
    index : DatetimeIndex, shape (rows,)
        Without a zone in standard time at the location.
    location : pvlib.location.Location
        Of the sensor.
    angles : tuple of array, shape (rows,)
        Tilt and azimuth of the described plane. [°]
    late : float
        By how much the rows' times are late. [s]

    Returns
    -------
    tuple of Standing
    """
    poa = np.asarray(poa_global, dtype=float)
    try:
        axis, turns = rotations(*(np.asarray(angle, dtype=float) for angle in angles))
    except ValueError:  # nothing that turns
        return ()
    place = sun(index - pd.Timedelta(seconds=late), location)
    zenith, azimuth = (place[name].to_numpy() for name in place.columns)
    up = zenith < LOWEST
    dates = np.asarray(index.tz_localize(None).normalize().as_unit("s").asi8) // 86400
    light = np.flatnonzero(up & np.isfinite(poa + angles[0] + angles[1]))
    first = dates.min()
    counts, there = (
        np.bincount(dates[rows] - first, minlength=int(np.ptp(dates)) + 1)
        for rows in (np.flatnonzero(up), light)
    )
    whole = (there >= WHOLE * counts) & (there >= FEWEST_ROWS)
    rows = light[whole[dates[light] - first]]
    if not len(rows):
        return ()
    days = np.unique(dates[rows])
    sky = Sky.from_rows(poa[rows], zenith[rows], azimuth[rows], dates[rows], location)
    moving = residual_by_day(sky, at_rows(angles, rows))
    best, at = nearest_by_day(sky, axis.planes(turns), turns)
    stands = (best < CLEAR) & (moving > np.maximum(CLEAR, BETTER * best))
    moves = moving < CLEAR
    return tuple(
        described_standing(sky, axis, days, some, at, moving, *edges)
        for some, *edges in standstill_runs(days, stands, moves, at)
    )


def skies_with_haze(sky: Any) -> list:
    """The clear sky with more diffuse light: that of dusty air has several times it."""
    return [replace(sky, sky=haze * sky.sky) for haze in HAZES]


def residual_by_day(sky: Any, plane: Any) -> np.ndarray:
    """Least relative residual of each day against clear skies in a plane. [-]"""
    least = np.inf
    for one in skies_with_haze(sky):
        light = one.on_plane(plane)
        columns = sky.poa**2, light**2, sky.poa * light
        sums = (np.bincount(sky.day, column) for column in columns)
        least = np.minimum(least, relative_residual(*sums))
    return np.asarray(least)


def relative_residual(whole: Any, square: Any, both: Any) -> np.ndarray:
    """Residual of a light with a scale of its own, by the sums of their products."""
    square_residual = whole - both**2 / np.maximum(square, 1e-9)
    return np.sqrt(np.maximum(square_residual, 0.0) / np.maximum(whole, 1e-9))


def nearest_by_day(sky: Any, planes: Any, turns: Any) -> tuple[Any, Any]:
    """
    Least relative residual of each day in any plane of an axis, and the rotation.

    Of the clear skies with more and less haze the best one of each day counts.

    Parameters
    ----------
    sky : Sky
    planes : array, shape (planes, 2)
        Tilt and azimuth of each. [°]
    turns : array, shape (planes,)
        Rotation of each about the axis. [°]

    Returns
    -------
    residual, turn : array, shape (days,)
        [-], [°]
    """
    each = [nearest_of_one(one, planes, turns) for one in skies_with_haze(sky)]
    residuals, at = map(np.array, zip(*each))
    best = np.argmin(residuals, axis=0), np.arange(residuals.shape[1])
    return residuals[best], at[best]


def nearest_of_one(sky: Any, planes: Any, turns: Any) -> tuple[Any, Any]:
    """
    :func:`nearest_by_day` against one clear sky.

    Between two planes the light is linear in the rotation. A clear day 5° from the
    nearest plane that is tried would leave as much as a day that is not clear.
    """

    def by_day(column: Any) -> np.ndarray:
        return np.bincount(sky.day, column)

    whole = by_day(sky.poa**2)
    best, at = np.full(len(whole), np.inf), np.full(len(whole), turns[0])
    light = sky.on_plane(planes[0])
    square, both = by_day(light**2), by_day(sky.poa * light)
    for i, plane in enumerate(planes[1:]):
        after = sky.on_plane(plane)
        crossed = by_day(light * after)
        squares, boths = by_day(after**2), by_day(sky.poa * after)
        for share in BETWEEN:
            rest = 1.0 - share
            products = rest**2 * square + 2.0 * rest * share * crossed
            products += share**2 * squares
            residual = relative_residual(whole, products, rest * both + share * boths)
            turn = rest * turns[i] + share * turns[i + 1]
            at = np.where(residual < best, turn, at)
            best = np.minimum(residual, best)
        light, square, both = after, squares, boths
    return best, at


def standstill_runs(days: Any, stands: Any, moves: Any, at: Any) -> Iterator:
    """Groups of days that stand in one plane, and the clear days that move around."""
    some: list[int] = []
    last = days[0] - 1
    for i in range(len(days) + 1):
        ends = i == len(days) or moves[i]
        other = not ends and stands[i] and some and abs(at[i] - at[some[-1]]) > ALIKE
        if (ends or other) and some:
            after = days[i] if i < len(days) else days[-1] + 1
            if len(some) >= FEWEST:
                yield some, last, after
            last = days[some[-1]]
            some = []
        if i < len(days) and moves[i]:
            last = days[i]
        elif i < len(days) and stands[i]:
            some = [*some, i]


def described_standing(
    sky: Any,
    axis: Any,
    days: Any,
    some: Any,
    at: Any,
    moving: Any,
    last: Any,
    after: Any,
) -> Standing:
    """The days, and the plane that leaves least of them."""
    there = np.isin(sky.day, some)
    part = sky.rows(there)
    middle = float(np.median(at[some]))
    near = np.arange(middle - ALIKE, middle + ALIKE + 0.5)
    planes = axis.planes(near)
    residuals = [np.sqrt(np.mean(residual_by_day(part, p)[some] ** 2)) for p in planes]
    tilt, turn = planes[int(np.argmin(residuals))].round(1).tolist()
    first, end = days[some[0]], days[some[-1]] + 1
    # in the middle of the days that show neither
    begin = int(last + 1 + first + 1) // 2
    return Standing(
        start=date_text(begin),
        end=date_text(int(end + after) // 2),
        between=(date_text(last + 1), date_text(first)),
        surface_tilt=tilt,
        surface_azimuth=turn,
        days=len(some),
        before=float(np.sqrt(np.mean(moving[some] ** 2))),
        after=float(min(residuals)),
    )
