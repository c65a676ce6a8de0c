"""The angles of a plane that moves, by the rows of a record."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from pvlib.pvsystem import SingleAxisTrackerMount
from pvlib.tracking import calc_surface_orientation

from pvlib_fem._record.checks import as_numbers
from pvlib_fem._record.column_names import GEOMETRY, ROTATION, printable

TILT, AZIMUTH = ANGLES = GEOMETRY[2:]


@dataclass(frozen=True, eq=False)
class ByColumns:
    """
    A plane that moves, by its angles at some times.

    Attributes
    ----------
    index : DatetimeIndex
    columns : dict of array
        ``surface_tilt``, ``surface_azimuth``, or both. [°]
    described : pvlib.pvsystem.SingleAxisTrackerMount or None
        The tracker whose rotations were recorded.
    """

    index: pd.DatetimeIndex
    columns: dict
    described: SingleAxisTrackerMount | None = None

    def get_orientation(self, solar_zenith: Any, solar_azimuth: np.ndarray) -> Any:
        """The angles at the times of a Series, as of any mount of pvlib."""
        return self.at(solar_zenith.index)

    def at(self, index: pd.DatetimeIndex) -> Any:
        """
        The angles at other times: of a row its own, between rows interpolated.

        Tilt and azimuth are interpolated together, as the normal of the plane. There
        are none between rows that are further apart than twice the usual step.
        """
        own, wanted = (i.as_unit("ns").asi8 for i in (self.index, index))
        if len(own) == len(wanted) and (own == wanted).all():
            return dict(self.columns)
        after = np.clip(np.searchsorted(own, wanted), 1, max(len(own) - 1, 1))
        before, after = np.clip([after - 1, after], 0, len(own) - 1)
        apart = own[after] - own[before]
        share = (wanted - own[before]) / np.maximum(apart, 1)
        usual = np.median(np.diff(own)) if len(own) > 1 else 0.0
        far = (apart > 2.0 * usual) | (share < 0.0) | (share > 1.0)
        angles = {}
        between = interpolated_angles(self.columns, before, after, share)
        for name, values in between.items():
            values = np.where(far, np.nan, values)
            for at, exact in ((before, 0.0), (after, 1.0)):
                values = np.where(share == exact, self.columns[name][at], values)
            angles[name] = values
        return angles


def interpolated_angles(columns: Any, before: Any, after: Any, share: Any) -> Any:
    """Angles part of the way from some rows to others, the shorter way round."""
    size = len(next(iter(columns.values())))
    others = {TILT: np.full(size, 90.0), AZIMUTH: np.zeros(size)}
    normal = normals(*(columns.get(name, others[name]) for name in ANGLES))
    mean = (1.0 - share) * normal[:, before] + share * normal[:, after]
    angles = dict(zip(ANGLES, angles_of(*mean)))
    # a plane that is stuck keeps its angles, to the last digit
    same = np.all([v[before] == v[after] for v in columns.values()], axis=0)
    return {n: np.where(same, v[before], angles[n]) for n, v in columns.items()}


def normals(tilt: Any, azimuth: Any) -> Any:
    """
    Normals of planes by their angles.

    Parameters
    ----------
    tilt, azimuth : float or array, shape (planes,)
        Azimuth clockwise from north. [°]

    Returns
    -------
    array, shape (3, planes)
        Components to north, to east and up, of length 1; shape (3,) for numbers.
    """
    tilt, turn = np.radians(tilt), np.radians(azimuth)
    return np.array(
        [np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)]
    )


def angles_of(north: Any, east: Any, up: Any) -> Any:
    """
    Tilt and azimuth of a normal of any length.

    Parameters
    ----------
    north, east, up : float or array, shape (planes,)
        Components of the normal.

    Returns
    -------
    tuple of float or array, shape (planes,)
        Tilt from 0 to 180°, azimuth clockwise from north from 0 to 360°. [°]
    """
    tilt = np.degrees(np.arctan2(np.hypot(north, east), up))
    return tilt, np.degrees(np.arctan2(east, north)) % 360.0


def by_rotation(data: Any, mount: Any) -> Any:
    """
    A described tracker at the rotations of a record, None without that column.

    Parameters
    ----------
    data : DataFrame
        A record, perhaps with ``tracker_theta``. [°]
    mount : SingleAxisTrackerMount, other mount or None
        Only of a tracker with one axis the rotations give the plane.

    Returns
    -------
    ByColumns or None

    Raises
    ------
    ValueError
        If a rotation is no number, or not from -180 to 180°.
    """
    own = [label for label in data if printable(label) == ROTATION]
    if not own or not isinstance(mount, SingleAxisTrackerMount):
        return None
    theta = floats(ROTATION, data[own[0]])
    if (off := theta.abs() > 180.0).any():
        at = int(np.argmax(off.to_numpy()))
        raise ValueError(
            f"{ROTATION} is {theta.iloc[at]:g}° at {theta.index[at]}; it is from -180 "
            f"to 180°; {missing_remedy(theta.iloc[at])}"
        )
    return ByColumns(data.index, angles_of_rotation(theta.to_numpy(), mount), mount)


def floats(name: str, column: Any) -> Any:
    """
    A column of angles as floats; ValueError with its name for other content.

    Parameters
    ----------
    name : str
    column : Series, shape (rows,)
        Angles. [°]

    Returns
    -------
    Series, shape (rows,)
    """
    return pd.Series(as_numbers(name, column, column.index), column.index)


def angles_of_rotation(theta: Any, mount: Any) -> Any:
    """
    Tilt and azimuth of a tracker at some rotations. [°]

    Parameters
    ----------
    theta : array, shape (rows,)
        Rotations about the axis, as :func:`pvlib.tracking.calc_surface_orientation` has
        their sign. [°]
    mount : SingleAxisTrackerMount

    Returns
    -------
    dict of array, shape (rows,)
        ``surface_tilt`` and ``surface_azimuth``.
    """
    with np.errstate(invalid="ignore"):
        angles = calc_surface_orientation(theta, mount.axis_tilt, mount.axis_azimuth)
    return {name: np.asarray(angles[name], dtype=float) for name in ANGLES}


def missing_remedy(value: Any) -> Any:
    """
    The remedy where a number may stand for a missing value.

    Parameters
    ----------
    value : float
        The number.

    Returns
    -------
    str
        End of an error message.
    """
    return f"a code for missing values has to be missing (--missing {value:g})"
