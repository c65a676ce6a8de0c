"""The plane of an irradiance sensor, from its clearest days."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
import pvlib
from pvlib.location import Location
from scipy.optimize import least_squares

from pvlib_fem._record.checks import usual_step
from pvlib_fem.drivers import sun

FEWEST_DAYS = 60  # of a record
CLEAREST = 0.1  # share of each month's days that may be clear
KEPT = 0.5  # share of those of which the shape is kept
FINE = 900.0  # s, between rows: the sun's way needs no more
LOWEST = 70.0  # ° from the vertical, beyond which hills may hide the sun
TURBIDITY = 3.0  # Linke's, of a clear day in the mean; the scale of each year is free
ALBEDO = 0.2
ABOVE = 1361.0  # W/m², of the sun above the air
WHOLE = 0.9  # share of a day's light rows that are there
GROUPS = 10  # of days, each left out in turn
LEAST_ERROR = 5.0  # °, of a clear sky and a transposition that are no more than models
MOST_ERROR = 8.0  # °, above which the angles are not known
MOST_RESIDUAL = 0.12  # of the clear irradiance, root mean square
CLEARLY = 0.5  # of the deviation from a moving plane, below which a fixed one is it
SURE = 3.0  # errors by which two planes have to part to be two
STARTS = [(tilt, turn) for tilt in (10.0, 35.0, 60.0) for turn in range(0, 360, 45)]


@dataclass(frozen=True)
class Plane:
    """Angles of a plane, from :func:`plane_of`. [°]"""

    surface_tilt: float
    surface_azimuth: float
    tilt_error: float
    azimuth_error: float
    days: int  # clear days of which they are

    @property
    def angles(self) -> dict[str, float]:
        """Both by their names."""
        names = ("surface_tilt", "surface_azimuth")
        return {name: getattr(self, name) for name in names}

    def is_another(self, surface_tilt: float, surface_azimuth: float) -> bool:
        """Whether it is surely not the plane of these angles."""
        stated = np.array([surface_tilt, surface_azimuth])
        apart = angle_differences(stated - [*self.angles.values()])
        return bool((np.abs(apart) > SURE * np.array(self.errors)).any())

    @property
    def errors(self) -> tuple[float, float]:
        return self.tilt_error, self.azimuth_error

    def __str__(self) -> str:
        azimuth = round(self.surface_azimuth) % 360
        return (
            f"tilt {self.surface_tilt:.0f} ± {self.tilt_error:.0f}°, azimuth "
            f"{azimuth} ± {self.azimuth_error:.0f}° clockwise from north, by the light "
            f"of {self.days} clear days"
        )


def plane_of(
    poa_global: np.ndarray | pd.Series,
    index: pd.DatetimeIndex,
    location: Location,
    late: float = 0.0,
) -> Plane | None:
    """
    Tilt and azimuth that the irradiance of clear days has.

    Parameters
    ----------
    poa_global : array, shape (rows,)
        [W/m²]
    index : DatetimeIndex, shape (rows,)
        Without a zone in standard time at the location.
    location : pvlib.location.Location
        Of the sensor.
    late : float
        By how much the rows' times are late, as the middle of the light has it. [s]

    Returns
    -------
    Plane or None
        None where the record is too short, or its clear days leave the angles open by
        more than 8°.

    Notes
    -----
    Of each month the tenth of the days with most light is compared with a clear sky
    (Ineichen and Perez [1]_) on any plane (Hay and Davies [2]_), and the half of these
    that has its shape is kept. The scale of that sky is free, once from year to year
    and once from day to day: air that is more turbid makes the plane steeper by the
    year and flatter by the day. The angles are the mean of both, and half of the
    difference is their error, unless leaving out a tenth of the days in turn moves them
    by more, and 5° at least. Of a file whose rows are means to another edge it knows
    nothing: half an hour turns the plane by 7° and more.

    References
    ----------
    .. [1] P. Ineichen and R. Perez, "A new airmass independent formulation for the
       Linke turbidity coefficient", Solar Energy 73, 151-157, 2002, as in
       :func:`pvlib.clearsky.ineichen`. :doi:`10.1016/S0038-092X(02)00045-2`
    .. [2] J. E. Hay and J. A. Davies, "Calculations of the solar radiation incident on
       an inclined surface", Proc. First Canadian Solar Radiation Data Workshop, 59,
       1980, as in :func:`pvlib.irradiance.haydavies`.
    """
    if len(index) > 1:
        every = slice(None, None, max(int(FINE // usual_step(index)), 1))
        poa_global, index = poa_global[every], index[every]
    local = index.tz_localize(None)
    looked = clear_days(poa_global, index, location, late, np.asarray(local.month))
    if looked is None:
        return None
    rows, sky = looked
    # the scale of a clear day, free for each year or day: for each year the sun's
    # way through the seasons counts, and what its air does; for each day its shape
    both = [sky.scaled_by(by).plane() for by in (np.asarray(local.year)[rows], sky.day)]
    angles, errors, residuals = (np.array(part) for part in zip(*both))
    apart = angle_differences(angles[1] - angles[0])
    tilt, turn = (angles[0] + apart / 2.0).tolist()
    errors = np.maximum(errors.max(axis=0), np.abs(apart) / 2.0)
    errors = np.maximum(errors, LEAST_ERROR).tolist()
    steep = max(np.sin(np.radians(tilt)), 0.1)  # a flat plane has no azimuth
    if (
        max(errors[0], errors[1] * steep) > MOST_ERROR
        or residuals.max() > MOST_RESIDUAL
    ):
        return None
    return Plane(tilt, turn % 360.0, errors[0], errors[1], int(sky.day.max()) + 1)


def fixed_rather(
    angles: Any,
    poa_global: Any,
    index: pd.DatetimeIndex,
    location: Location,
    late: float = 0.0,
) -> tuple[float, float] | None:
    """
    The fixed plane that the light of clear days has, rather than one that moves.

    Parameters
    ----------
    angles : tuple
        Tilt and azimuth of the plane that moves, numbers or arrays of shape (rows,).
        [°]
    poa_global, index, location, late
        As in :func:`plane_of`.

    Returns
    -------
    tuple of float, or None
        Tilt and azimuth, if they leave less than half of the deviation. [°]
    """
    months = np.asarray(index.tz_localize(None).month)
    looked = clear_days(poa_global, index, location, late, months)
    if looked is None:
        return None
    rows, sky = looked
    best = tuple(sky.best().tolist())
    fixed, moving = (sky.least_residual(a) for a in (best, at_rows(angles, rows)))
    return (best[0], best[1] % 360.0) if fixed < CLEARLY * moving else None


def at_rows(angles: tuple, rows: np.ndarray) -> tuple[float, float]:
    """
    Angles of a plane at some rows.

    Parameters
    ----------
    angles : tuple of float or numpy.ndarray, shape (rows,)
        Tilt and azimuth; a number is the same in all rows. [°]
    rows : numpy.ndarray of int or bool
        Rows that are taken.

    Returns
    -------
    tuple of float or numpy.ndarray
        Numbers as they are, arrays at these rows. [°]
    """
    return tuple(a if np.ndim(a) == 0 else np.asarray(a)[rows] for a in angles)


def clear_days(
    poa_global: np.ndarray | pd.Series,
    index: pd.DatetimeIndex,
    location: Any,
    late: float,
    months: np.ndarray,
    share: float = CLEAREST,
) -> "tuple[np.ndarray, Sky] | None":
    """
    Rows of the days with most light of each month, and a clear sky over them.

    Light is the sum of a day's irradiance, divided by that of the cosine of the zenith.

    Parameters
    ----------
    poa_global : numpy.ndarray or pandas.Series, shape (rows,)
        [W/m²]
    index : pandas.DatetimeIndex, shape (rows,)
        Without a zone in standard time at the location.
    location : pvlib.location.Location
        Of the sensor.
    late : float
        By how much the rows' times are late. [s]
    months : numpy.ndarray of int, shape (rows,)
        Groups of days that are compared, such as months of the year.
    share : float, default 0.1
        Share of each group's days that are taken, two days at least. [-]

    Returns
    -------
    tuple of numpy.ndarray and Sky, or None
        Numbers of these days' rows with the sun above 20°, shape (n,), and the sky over
        them. None of a record with less than 60 whole days.
    """
    poa = np.asarray(poa_global, dtype=float)
    place = sun(index - pd.Timedelta(seconds=late), location)
    zenith, azimuth = (place[name].to_numpy() for name in place.columns)
    up, there = zenith < LOWEST, np.asarray(index.tz_localize(None).normalize())
    light = up & np.isfinite(poa)
    days = clearest(poa, zenith, up, light, there, months, share)
    if days is None:
        return None
    rows = np.flatnonzero(light & np.isin(there, days))
    of_rows = (column[rows] for column in (poa, zenith, azimuth, there))
    return rows, Sky.from_rows(*[*of_rows, location])


def angle_differences(angles: np.ndarray) -> np.ndarray:
    """Differences of tilt and azimuth, the short way round."""
    tilt, turn = angles.T
    return np.array([tilt, (turn + 180.0) % 360.0 - 180.0]).T


def clearest(
    poa: np.ndarray,
    zenith: np.ndarray,
    up: np.ndarray,
    light: np.ndarray,
    there: np.ndarray,
    months: np.ndarray,
    share: float,
) -> np.ndarray | None:
    """The days of each month with most light for the sun's elevation, or None."""
    frame = pd.DataFrame(
        {
            "day": there,
            "month": months,
            "up": up,
            "light": light,
            "poa": np.where(light, poa, 0.0),
            "high": np.where(up, np.cos(np.radians(zenith)), 0.0),
        }
    )
    sums = frame.groupby("day").agg(
        {"month": "first", "up": "sum", "light": "sum", "poa": "sum", "high": "sum"}
    )
    sums = sums[(sums["light"] >= WHOLE * sums["up"]) & (sums["high"] > 0)]
    if len(sums) < FEWEST_DAYS:
        return None
    ratio = sums["poa"] / sums["high"]
    rank = ratio.groupby(sums["month"]).rank(ascending=False, pct=True)
    least = ratio.groupby(sums["month"]).rank(ascending=False) <= 2
    return sums.index[(rank <= share) | least].to_numpy()


@dataclass(frozen=True, eq=False)
class Sky:
    """A clear sky over some rows, and what was measured."""

    poa: np.ndarray
    beam: np.ndarray  # normal
    sky: np.ndarray
    ground: np.ndarray
    zenith: np.ndarray  # [rad]
    azimuth: np.ndarray  # [rad]
    day: np.ndarray  # number of each row's day
    scale: np.ndarray  # number of each row's scale

    @classmethod
    def from_rows(
        cls,
        poa: np.ndarray,
        zenith: np.ndarray,
        azimuth: np.ndarray,
        day: np.ndarray,
        location: Location,
    ) -> "Sky":
        """The clear sky of some rows."""
        air = pvlib.atmosphere.get_relative_airmass(zenith)
        pressure = pvlib.atmosphere.alt2pres(location.altitude)
        air = pvlib.atmosphere.get_absolute_airmass(air, pressure)
        clear = pvlib.clearsky.ineichen(zenith, air, TURBIDITY, location.altitude)
        day = np.unique(day, return_inverse=True)[1]
        return cls(
            poa,
            np.asarray(clear["dni"]),
            np.asarray(clear["dhi"]),
            ALBEDO * np.asarray(clear["ghi"]),
            np.radians(zenith),
            np.radians(azimuth),
            day,
            day,
        )

    def scaled_by(self, groups: np.ndarray) -> "Sky":
        """The clear sky with a scale for each group of rows."""
        return replace(self, scale=np.unique(groups, return_inverse=True)[1])

    def plane(self) -> tuple[np.ndarray, np.ndarray, float]:
        """The angles, their errors, and the relative residual of the irradiance."""
        best = self.best()
        sky = self.rows(np.isin(self.day, self.nearest(best)))
        angles = sky.search(best)
        folds = sky.day % GROUPS
        others = [sky.rows(folds != fold).search(angles) for fold in range(GROUPS)]
        apart = angle_differences(np.array(others) - angles)
        errors = np.sqrt((GROUPS - 1) / GROUPS * (apart**2).sum(axis=0))
        return angles, errors, np.sqrt(np.mean(sky.residual(angles) ** 2))

    def rows(self, kept: np.ndarray) -> "Sky":
        """The clear sky of some rows."""
        return Sky(*(column[kept] for column in vars(self).values()))

    def on_plane(self, angles: np.ndarray | tuple) -> np.ndarray:
        """The irradiance of the clear sky on a plane, or on one for each row. [W/m²]"""
        tilt, turn = (np.radians(angle) for angle in angles)
        ahead = np.cos(self.zenith) * np.cos(tilt) + np.sin(self.zenith) * np.sin(
            tilt
        ) * np.cos(self.azimuth - turn)
        ahead, view = np.maximum(ahead, 0.0), (1.0 + np.cos(tilt)) / 2.0
        around = self.beam / ABOVE  # share of the sky's light that is near the sun
        lit = around * ahead / np.cos(self.zenith) + (1.0 - around) * view
        return self.beam * ahead + self.sky * lit + self.ground * (1.0 - view)

    def residual(self, angles: np.ndarray | tuple) -> np.ndarray:
        """Residual of each row in a plane, as a share of the mean irradiance."""
        modelled = self.on_plane(angles)
        squares = np.bincount(self.scale, modelled**2)
        times = np.bincount(self.scale, modelled * self.poa) / np.maximum(squares, 1e-9)
        return (self.poa - times[self.scale] * modelled) / self.poa.mean()

    def search(self, start: np.ndarray | tuple) -> np.ndarray:
        """The angles with the least residual, searched from a start. [°]"""
        solution = least_squares(
            self.residual,
            start,
            bounds=([0.0, -np.inf], [90.0, np.inf]),
            loss="soft_l1",
            f_scale=0.05,
            x_scale=[10.0, 10.0],
        )
        return solution.x

    def best(self) -> np.ndarray:
        """The angles with the least residual of all."""
        starts = sorted(
            STARTS, key=lambda one: float(np.abs(self.residual(one)).mean())
        )
        ends = [self.search(start) for start in starts[:3]]
        return min(ends, key=lambda one: float(np.abs(self.residual(one)).mean()))

    def by_day(self, angles: np.ndarray) -> np.ndarray:
        """Mean square residual of each day in a plane."""
        residual = self.residual(angles)
        return np.bincount(self.day, residual**2) / np.bincount(self.day)

    def least_residual(self, angles: Any) -> float:
        """RMS residual in a plane, of the days that fit it best."""
        return float(np.sqrt(np.sort(self.by_day(angles))[: self.most].mean()))

    def nearest(self, angles: np.ndarray) -> np.ndarray:
        """Days whose shape is that of a clear sky in the plane."""
        by_day = self.by_day(angles)
        return np.argsort(by_day, kind="stable")[: self.most]

    @property
    def most(self) -> int:
        """Number of days that are kept."""
        return max(int(KEPT * (self.day.max() + 1)), 20)
