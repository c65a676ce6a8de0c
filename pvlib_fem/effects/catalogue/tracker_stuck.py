"""A tracker whose modules are stuck while the irradiance sensor moves."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._statistics.leastsquares import orthonormal
from pvlib_fem.drivers._solar import on_plane
from pvlib_fem.effects._effect import Effect, Parameter, Terms
from pvlib_fem.effects._standstill import find_standstill, rotations
from pvlib_fem.effects._time_profiles import date_text, day_number
from pvlib_fem.reasons import Reason

DRIVERS = ("poa_global", "clearness", "solar_zenith", "solar_azimuth", "day")


def terms(
    poa_global: np.ndarray,
    clearness: np.ndarray,
    solar_zenith: np.ndarray,
    solar_azimuth: np.ndarray,
    day: pd.Index,
    *,
    share: float,
    plane: tuple,
    dates: tuple,
) -> Terms:
    r"""
    Light on modules that are stuck, minus that on a sensor that moves [1]_.

    .. math::

        \mathrm{heat} = \mathrm{share} \cdot \mathrm{stands}(\mathrm{day}) \cdot
        [\mathrm{light}(\mathrm{clearness}, \mathrm{solar\_zenith},
        \mathrm{solar\_azimuth}) - \mathrm{poa\_global}]

    ``stands`` is 1 on the days on which the tracker is stuck, else 0. ``light`` is
    the irradiance of the same sky in the ``plane`` in which it stands. ``share`` is
    about 1 if all of the module stands there.

    References
    ----------
    .. [1] W. F. Marion and A. P. Dobos, "Rotation angle for the optimum tracking of
       one-axis trackers", NREL/TP-6A20-58891, 2013, :doi:`10.2172/1089596`, for the
       plane of a rotation, as in :func:`pvlib.tracking.calc_surface_orientation`.
    """
    light = on_plane(clearness, solar_zenith, solar_azimuth, *plane)
    heat = share * standstill_mask(day, dates) * (light - poa_global)
    return Terms(heat=heat)


def standstill_mask(day: pd.Index, dates: tuple) -> np.ndarray:
    """1 on the days from one until the other, which is the first one after."""
    first, last = dates
    return ((day >= first) & (day < last)).astype(float)


def standstill_effect(
    start: Any = None,
    end: Any = None,
    surface_tilt: float = 0.0,
    surface_azimuth: float = 180.0,
    between: Any = None,
    ended: Any = None,
) -> Any:
    """
    The effect of a tracker that is stuck.

    Parameters
    ----------
    start, end : str, optional
        First day, and the first day after it; by default the whole record.
    surface_tilt, surface_azimuth : float, optional
        Where it stands; by default level. [°]
    between : tuple of str, optional
        Days between which it may have begun.
    ended : tuple of str, optional
        Interval of ``end``.

    Returns
    -------
    Effect
    """
    dates = (
        -np.inf if start is None else day_number(start),
        np.inf if end is None else day_number(end),
    )
    if not dates[0] < dates[1]:
        raise ValueError(f"start = {start!r} is not before end = {end!r}")
    plane = float(surface_tilt), float(surface_azimuth)
    light = partial(terms, plane=plane, dates=dates)
    light.__doc__ = terms.__doc__  # instead of functools.partial's
    settings = dict(start=start, end=end) | dict(
        surface_tilt=plane[0], surface_azimuth=plane[1]
    )
    for name, days in {"between": between, "ended": ended}.items():
        if days is not None:
            settings[name] = tuple(days)
    return Effect(
        "tracker_stuck",
        light,
        # above 1, because the light is estimated
        {"share": Parameter(0.0, 0.0, 1.5, "-")},
        columns=DRIVERS,
        title="modules that are stuck while the tracker of the sensor moves",
        decided_by="a look at the tracker, or at the angles that its drive reports",
        settings={k: v for k, v in settings.items() if v is not None},
        source="the light in the plane in which it stands",
        confused_with=(
            "irradiance_sensor_episode",
            "poa_misalignment",
            "shading",
            "modules_covered",
        ),
        make=standstill_effect,
        not_found=Reason.NO_STANDSTILL,
        turns=True,
    )


class AllDays:
    """Heat of modules that stand in each of some planes, or lose light evenly."""

    def __init__(self, planes: Any) -> None:
        self.planes = planes

    def __call__(
        self,
        poa_global: np.ndarray,
        clearness: Any,
        solar_zenith: np.ndarray,
        solar_azimuth: np.ndarray,
        day: Any,
        evenly: Any,
        **sizes: Any,
    ) -> Any:
        """Terms of the planes, each with its share, on all days."""
        heat = 0.0 * clearness - evenly * poa_global
        for plane, size in zip(self.planes, sizes.values()):
            if size != 0.0:
                light = on_plane(clearness, solar_zenith, solar_azimuth, *plane)
                heat = heat + size * (light - poa_global)
        return Terms(heat=heat)


def of_record(columns: Any, rows: Any) -> Any:
    """The effect that is searched in the planes that a record's tracker has."""
    tilt, turn = (columns[name][rows] for name in ("surface_tilt", "surface_azimuth"))
    axis, angles = rotations(tilt, turn)
    planes = axis.planes(angles)
    names = [*(f"plane_{i}" for i in range(len(planes))), "evenly"]
    wide = Effect(
        EFFECT.name,
        AllDays(planes),
        {name: Parameter(0.0, -1.0, 1.0, "-") for name in names},
        columns=DRIVERS,
        not_found=EFFECT.not_found,
    )
    scan = partial(scan_axis, axis=axis, angles=angles, wide=wide)
    return replace(EFFECT, prepare=None, scan=scan, scanned_from=wide)


def scan_axis(
    rest: np.ndarray,
    tangents: dict,
    columns: Any,
    weeks: np.ndarray,
    least: float,
    *,
    axis: Any,
    angles: Any,
    wide: Any,
) -> Any:
    """The effect at the angle and the dates that the residual shows, or None."""
    keys = [*wide.rows()]
    others = [column for name, column in tangents.items() if name not in keys]
    *own, even = (tangents[key] for key in keys)
    basis = orthonormal(others)
    best = find_standstill(rest, own, even, angles, basis, columns["day"], least)
    if best is None:
        return None
    angle, start, end, *intervals = best
    ((tilt, turn),) = axis.planes(np.array([angle])).round(1).tolist()
    between, ended = ([date_text(day) for day in days] for days in intervals)
    return standstill_effect(
        date_text(start), date_text(end), tilt, turn, between, ended
    )


#: level on all days as a default; a record's orientations have the planes to try
EFFECT = replace(standstill_effect(), prepare=of_record)
