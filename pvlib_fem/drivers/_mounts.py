"""The plane of the modules: fixed, turned by a tracker, or by columns of a record."""

from dataclasses import fields
from numbers import Real
from typing import Any

import numpy as np
import pandas as pd
from pvlib.location import Location
from pvlib.pvsystem import FixedMount, SingleAxisTrackerMount

from pvlib_fem._record.column_names import GEOMETRY, printable
from pvlib_fem._spelling import ShellText, refusal
from pvlib_fem.drivers._planes import (
    ANGLES,
    AZIMUTH,
    TILT,
    ByColumns,
    by_rotation,
    floats,
    missing_remedy,
    normals,
)
from pvlib_fem.drivers._solar import sun

PLANE = (*ANGLES, "mount")  # of a place, in addition to its location
BY_COLUMNS = "columns"  # the mount of a result, of which each record has the angles
#: numbers of a tracker by pvlib's names, with their ranges
TRACKER = {
    "axis_tilt": (0.0, 90.0),
    "axis_azimuth": (-360.0, 360.0),
    "max_angle": (0.0, 180.0),
    "gcr": (0.01, 1.0),
}
STOW = 0.0  # ° of tilt, and of azimuth, by night where a tracker has no angles
RANGES = {TILT: (0.0, 180.0), AZIMUTH: (0.0, 360.0)}  # °
TURNED = (
    "if it is the rotation of a tracker, call it tracker_theta, and describe the "
    "tracker's axis (mount=, --axis-azimuth)"
)
FROM_SOUTH = "azimuths are from north, clockwise: to one from south add 180"
LEFT_OUT = ShellText("mount", "--axis-tilt, --axis-azimuth, --max-angle, --gcr")
NUMBERS = ShellText("surface_tilt and surface_azimuth", "--tilt and --azimuth")
WHERE = ShellText("location", "--lat and --lon")
FLAT = 0.01  # relative mean square of normals along an axis to which they are vertical
LEVEL = 0.02  # horizontal part of a normal, below which a plane is level
AHEAD = 0.2  # of the mean normal, from which a plane faces one side more than another


def geometry(
    index: Any,
    location: Location | None = None,
    surface_tilt: float | None = None,
    surface_azimuth: float | None = None,
    mount: Any = None,
    late: float = 0.0,
) -> dict:
    """
    Columns of solar position and module plane, as far as they are known.

    Parameters
    ----------
    index : DatetimeIndex
        Times; without a zone as in :func:`sun`.
    location : pvlib.location.Location, optional
    surface_tilt, surface_azimuth : float, optional
        Angles of a fixed plane. [°]
    mount : pvlib.pvsystem.AbstractMount or ByColumns, optional
        A plane that moves; a tracker needs the location.
    late : float, default 0
        By how much the times are late; columns of a record are as late. [s]

    Returns
    -------
    dict of Series
        ``solar_zenith``, ``solar_azimuth``, ``surface_tilt`` and ``surface_azimuth`` on
        ``index``, without those that are not known. [°]

    Raises
    ------
    ValueError
        If the mount is ``"columns"``: then each record has to have the angles.
    """
    columns, then = {}, index - pd.Timedelta(seconds=late) if late else index
    if location is not None:
        columns |= dict(sun(then, location).set_axis(index))
    for name, value in zip(ANGLES, (surface_tilt, surface_azimuth)):
        if value is not None:
            # a view of one number
            everywhere = np.broadcast_to(float(value), len(index))
            columns[name] = pd.Series(everywhere, index, copy=False)
    if mount is not None:
        moving = plane_angles(mount, then, location, index)
        columns |= {name: pd.Series(v, index) for name, v in moving.items()}
    return columns


def plane_angles(
    mount: Any, index: pd.DatetimeIndex, location: Location, own: Any = None
) -> Any:
    """
    Angles of a plane that moves, horizontal by night where it has none. [°]

    Parameters
    ----------
    mount : pvlib.pvsystem.AbstractMount
    index : DatetimeIndex
    location : pvlib.location.Location or None
    own : DatetimeIndex, optional
        The same times as the record of a :class:`ByColumns` has them.

    Returns
    -------
    dict of array
    """
    if mount == BY_COLUMNS:
        raise ValueError(
            "the modules turn, and the data have no columns of their angles; add "
            "surface_tilt and surface_azimuth [°]"
        )
    if location is None:
        return mount.at(index if own is None else own)
    where = sun(index, location, refraction=True).set_axis(
        index if own is None else own
    )
    zenith, azimuth = (where[name] for name in GEOMETRY[:2])
    angles = mount.get_orientation(zenith, azimuth)
    return by_night({n: angles[n] for n in ANGLES if n in angles}, zenith)


def by_night(angles: Any, solar_zenith: np.ndarray | pd.Series) -> Any:
    """
    Angles, of a level plane where they are missing by night. [°]

    Parameters
    ----------
    angles : dict of array, shape (rows,)
        Tilt and azimuth by name. [°]
    solar_zenith : array or Series, shape (rows,)
        [°]

    Returns
    -------
    dict of array, shape (rows,)
        NaN where an angle is missing by day.
    """
    night, filled = np.asarray(solar_zenith) > 90.0, {}
    for name, values in angles.items():
        values = np.asarray(values, dtype=float)
        filled[name] = np.where(night & np.isnan(values), STOW, values)
    return filled


def angles_at(index: pd.DatetimeIndex, place: dict, late: float = 0.0) -> Any:
    """
    Tilt and azimuth of a place at some times. [°]

    Parameters
    ----------
    index : DatetimeIndex
    place : dict
        From :func:`checked_place`.
    late : float, default 0
        By how much the times are late; columns of a record are as late. [s]

    Returns
    -------
    tuple of float or array, shape (rows,), or None
        Numbers for a fixed plane, None without a location or an angle.

    Raises
    ------
    ValueError
        If the mount is ``"columns"``: then each record has to have the angles.
    """
    if place["location"] is None:
        return None
    mount, angles = place["mount"], {name: place[name] for name in ANGLES}
    if mount is not None:
        sure = index - pd.Timedelta(seconds=late)
        angles |= plane_angles(mount, sure, place["location"], index)
    if any(angle is None for angle in angles.values()):
        return None
    return tuple(angles.values())


def is_known(place: dict) -> bool:
    """
    Whether solar position and plane are known.

    Parameters
    ----------
    place : dict
        From :func:`checked_place`.

    Returns
    -------
    bool
    """
    moving = place["mount"]
    columns = moving.columns if isinstance(moving, ByColumns) else moving and ANGLES
    return place["location"] is not None and all(
        place[name] is not None or name in (columns or ()) for name in ANGLES
    )


def checked_place(
    location: Location | None,
    surface_tilt: Any = None,
    surface_azimuth: Any = None,
    mount: Any = None,
) -> dict:
    """
    The arguments of a place as a dict.

    Parameters
    ----------
    location : pvlib.location.Location or None
    surface_tilt : float or Series, optional
        From 0 to 180°; a Series has the times of the record. [°]
    surface_azimuth : float or Series, optional
        Clockwise from north: a number from -360 to 360°, a Series from 0 to 360°. [°]
    mount : pvlib.pvsystem.FixedMount, SingleAxisTrackerMount or ByColumns, optional
        Instead of both angles.

    Returns
    -------
    dict
        ``location``, ``surface_tilt``, ``surface_azimuth`` and ``mount``, None for what
        is not known. For angles that are Series the mount is a :class:`ByColumns`, and
        for a fixed mount the angles are numbers.

    Raises
    ------
    ValueError
        If an argument is invalid, or both a mount and an angle are given.
    """
    if location is not None and not isinstance(location, Location):
        example = ", ".join(map(str, np.ravel(location))) if np.ndim(location) else "…"
        raise ValueError(
            f"location is {location!r}; give pvlib.location.Location({example}), with "
            "tz= where the times have no zone"
        )
    angles = {TILT: surface_tilt, AZIMUTH: surface_azimuth}
    given = [name for name, value in angles.items() if value is not None]
    if mount is not None and given:
        raise refusal(
            f"{given[0]} and a mount are given; leave out ", NUMBERS, ", or ", LEFT_OUT
        )
    if isinstance(mount, FixedMount):
        return checked_place(location, mount.surface_tilt, mount.surface_azimuth)
    if mount is not None:
        check_mount(mount, location)
    series = {n: v for n, v in angles.items() if isinstance(v, pd.Series)}
    for name, value in angles.items():
        if name in series:
            series[name] = checked_column(name, value)
        elif value is not None:
            check_number(name, value)
    if series:
        mount = by_series(series)
        angles |= dict.fromkeys(series)
    return {"location": location, **angles, "mount": mount}


def plane_of_rows(data: Any, place: dict) -> dict:
    """
    A place with the angles of a record's rows, if it has these columns.

    Parameters
    ----------
    data : DataFrame
        A record, perhaps with ``surface_tilt`` and ``surface_azimuth``, or with
        ``tracker_theta``. [°]
    place : dict
        From :func:`checked_place`.

    Returns
    -------
    dict
        The place that was given if no such column is there, otherwise a place whose
        mount is a :class:`ByColumns`.

    Raises
    ------
    ValueError
        If an angle is out of its range.
    """
    own = {printable(label): label for label in data if printable(label) in ANGLES}
    if not own:
        turned = by_rotation(data, place["mount"])
        return place if turned is None else {**place, "mount": turned}
    columns = {name: checked_column(name, data[label]) for name, label in own.items()}
    if place["mount"] is not None:
        place = {**place, **dict.fromkeys(ANGLES)}
    mount = ByColumns(data.index, {n: c.to_numpy() for n, c in columns.items()})
    return {**place, **dict.fromkeys(columns), "mount": mount}


def check_number(name: str, value: float) -> None:
    """Refuse an angle that is no number, or none of its range."""
    if not isinstance(value, Real) or not np.isfinite(value):
        what = repr(value) if np.ndim(value) == 0 else f"a {type(value).__name__}"
        raise ValueError(
            f"{name} is {what}; give one number of degrees, a Series at the times of "
            "the record, or leave it out"
        )
    low, high = RANGES[name]
    low = -high if name == AZIMUTH else low  # a number to the west may be negative
    if not low <= value <= high:
        raise ValueError(f"{name} is {value:g}°; it is from {low:g} to {high:g}°")


def checked_column(name: Any, column: Any) -> Any:
    """
    The angles of a column as floats.

    Parameters
    ----------
    name : str
        ``surface_tilt`` or ``surface_azimuth``.
    column : Series, shape (rows,)
        NaN where the angle is not known. [°]

    Returns
    -------
    Series of float, shape (rows,)

    Raises
    ------
    ValueError
        If an angle is no number, a tilt not from 0 to 180°, or an azimuth not from 0
        to 360°.
    """
    values, (low, high) = floats(name, column), RANGES[name]
    if (off := (values < low) | (values > high)).any():
        at = int(np.argmax(off.to_numpy()))
        what = TURNED if name == TILT else FROM_SOUTH
        what = what if abs(values.iloc[at]) <= high else missing_remedy(values.iloc[at])
        raise ValueError(
            f"{name} is {values.iloc[at]:g}° at {column.index[at]}; it is from {low:g} "
            f"to {high:g}°, and missing where it is not known; {what}"
        )
    return values


def by_series(series: Any) -> Any:
    """A plane by Series of angles at the same times."""
    first, *others = series.values()
    if not isinstance(first.index, pd.DatetimeIndex) or any(
        not other.index.equals(first.index) for other in others
    ):
        raise ValueError(
            f"{' and '.join(series)} as Series need the times of the record, a "
            "DatetimeIndex"
        )
    return ByColumns(
        first.index, {n: column.to_numpy() for n, column in series.items()}
    )


def check_mount(mount: Any, location: Location) -> None:
    """Refuse what is no tracker of pvlib, and one of which the sun is not known."""
    if not isinstance(mount, (SingleAxisTrackerMount, ByColumns)):
        raise ValueError(
            f"mount is {mount!r}; give pvlib.pvsystem.SingleAxisTrackerMount(…), and "
            "angles of any other as surface_tilt and surface_azimuth, Series or columns"
        )
    if location is None:
        raise refusal("a tracker follows the sun: give ", WHERE)
    if isinstance(mount, ByColumns):
        return
    for name, (low, high) in TRACKER.items():
        # rotations to either side may differ
        value: Any
        for value in np.ravel(getattr(mount, name)):
            least = -high if name == "max_angle" and np.ndim(mount.max_angle) else low
            real = isinstance(value, Real)
            if not (real and least <= value <= high):
                raise ValueError(
                    f"mount.{name} is {value}; it is from {least:g} to {high:g}"
                )


def axis_of(place: dict) -> Any:
    """
    Azimuth of the axis about which a plane turns, None if it turns about none.

    Of columns it is the direction to which all normals are perpendicular. Of its ends
    it is the one from which a plane that faces one side, as one whose tilt is changed
    with the seasons, is steeper at positive angles, otherwise the southern one.

    Parameters
    ----------
    place : dict
        From :func:`checked_place`.

    Returns
    -------
    float or None
        Clockwise from north, from 0 to 360° if it is from columns. [°]
    """
    mount = getattr(place["mount"], "described", None) or place["mount"]
    if isinstance(mount, SingleAxisTrackerMount):
        return float(mount.axis_azimuth)
    if not isinstance(mount, ByColumns) or {*mount.columns} != {*ANGLES}:
        return None
    normal = normals(*(mount.columns[name] for name in ANGLES))
    # without the nights of a tracker with a tilted axis, which are level
    normal = normal[:, np.hypot(*normal[:2]) > LEVEL]
    sizes, ways = np.linalg.eigh(normal @ normal.T / max(normal.shape[1], 1))
    north, east, up = ways[:, 0]
    if sizes[0] > FLAT * sizes[1] or abs(up) > np.hypot(north, east):
        return None
    azimuth = np.degrees(np.arctan2(east, north)) % 360.0
    ahead = np.radians(azimuth + 90.0)
    faces = np.array([np.cos(ahead), np.sin(ahead)]) @ normal[:2].mean(axis=1)
    # just off the east, so that no rounding error turns an axis from east to west
    turned = faces < 0.0 if abs(faces) > AHEAD else np.cos(np.radians(azimuth - 1)) > 0
    return float((azimuth + 180.0 * turned) % 360.0)


def mount_content(mount: Any) -> Any:
    """
    A mount for a file.

    Parameters
    ----------
    mount : SingleAxisTrackerMount, ByColumns, str or None
        A string is the content itself.

    Returns
    -------
    dict, str or None
        The numbers of a tracker by name; ``"columns"`` for angles by rows, which are
        not stored.
    """
    if mount is None or mount == BY_COLUMNS:
        return mount
    if isinstance(mount, ByColumns):
        return BY_COLUMNS
    return {f.name: getattr(mount, f.name) for f in fields(mount)}


def without_rows(place: dict) -> dict:
    """
    A place without the angles of a record's rows, which each record has.

    Parameters
    ----------
    place : dict
        From :func:`checked_place`.

    Returns
    -------
    dict
        Its mount is the tracker whose rotations were recorded, or ``"columns"``; a
        place without a :class:`ByColumns` is returned as it is.
    """
    if not isinstance(place["mount"], ByColumns):
        return place
    return {**place, "mount": place["mount"].described or BY_COLUMNS}


def mount_from(content: Any) -> Any:
    """
    The mount of a part of a file.

    Parameters
    ----------
    content : dict, str or None
        From :func:`mount_content`.

    Returns
    -------
    SingleAxisTrackerMount, str or None
    """
    if content is None or content == BY_COLUMNS:
        return content
    angle = content["max_angle"]
    angle = tuple(angle) if isinstance(angle, list) else angle
    return SingleAxisTrackerMount(**{**content, "max_angle": angle})
