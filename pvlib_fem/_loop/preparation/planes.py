"""The plane of the modules by columns of a record: fixed, or one that moves."""

from typing import Any, cast

import numpy as np
import pandas as pd

from pvlib_fem._record.column_names import (
    ROTATION,
    printable,
    refuse_no_frame,
    with_aliases,
)
from pvlib_fem._spelling import did_you_mean
from pvlib_fem.drivers._mounts import (
    PLANE,
    checked_column,
    checked_place,
)
from pvlib_fem.drivers._planes import ANGLES, AZIMUTH, TILT, ByColumns, by_rotation

PLACE = ("location", *PLANE)  # arguments of a place
FIXED = 1.0  # ° within which a plane is one and the same


def plane_of_columns(
    data: pd.DataFrame, site: dict[str, Any]
) -> tuple[pd.DataFrame, dict[str, Any]]:
    """
    Take the plane of the modules from a record's columns.

    Parameters
    ----------
    data : DataFrame
        May have ``surface_tilt`` and ``surface_azimuth``, as pvlib's trackers do. [°]
    site : dict
        From :func:`pvlib_fem.drivers.checked_place`, without Series, which
        :func:`with_given` makes columns.

    Returns
    -------
    DataFrame
        The record without these columns.
    dict
        The site: with the angles of a fixed plane, or, of one that moves, a
        :class:`~pvlib_fem.drivers._planes.ByColumns`.

    Raises
    ------
    ValueError
        If a plane is given and the columns have another, or their angles are none.
    """
    own = [label for label in data if printable(label) in ANGLES]
    columns = with_aliases(data[own], ()) if own else {}
    columns = {n: checked_column(n, c) for n, c in columns.items() if c.notna().any()}
    known = {name: column.dropna().to_numpy() for name, column in columns.items()}
    data = data.drop(columns=own)
    own = [label for label in data if printable(label) == ROTATION]
    rotates = any(data[label].notna().any() for label in own)
    turned = by_rotation(data, site["mount"]) if rotates and not known else None
    if turned is not None:
        return data.drop(columns=own), {**site, "mount": turned}
    if known and site["mount"] is not None:
        raise ValueError(
            f"the tracker is described, and data have the column {min(known)}; drop "
            "that column, or leave the description out"
        )
    for name, values in known.items():
        refuse_other(name, values, site[name])
    if not known:
        return data, site
    if is_moving(known):
        columns = {name: column.to_numpy() for name, column in columns.items()}
        # a record without times is refused where its columns are read
        mount = ByColumns(cast(pd.DatetimeIndex, data.index), columns)
        return data, {**site, **dict.fromkeys(columns), "mount": mount}
    angles = {name: float(np.median(values)) for name, values in known.items()}
    return data, {**site, **{n: v for n, v in angles.items() if site[n] is None}}


def with_given(
    data: pd.DataFrame, site: dict[str, Any]
) -> tuple[pd.DataFrame, dict[str, Any]]:
    """
    The record with angles that are given as Series, and the site without.

    Parameters
    ----------
    data : DataFrame
        Record of the user.
    site : dict
        From :func:`pvlib_fem.drivers.checked_place`.

    Returns
    -------
    DataFrame
        With the angles as columns. [°]
    dict
        The site, without a mount if it was these angles.

    Raises
    ------
    ValueError
        If data are no frame, have a column of that name, or other times.
    """
    refuse_no_frame(data)
    mount = site["mount"]
    if not isinstance(mount, ByColumns):
        return data, site
    for name in mount.columns:
        if name in map(printable, data):
            raise ValueError(
                f"{name} is given, and data have a column of that name; drop one"
            )
    if not mount.index.equals(data.index):
        raise ValueError(
            f"{' and '.join(mount.columns)} have {len(mount.index):,} times from "
            f"{mount.index[0]} on, and data {len(data):,} from {data.index[0]} on; "
            "give Series at the times of the data"
        )
    return data.assign(**mount.columns), {**site, "mount": None}


def with_series(
    data: pd.DataFrame, place: dict[str, Any]
) -> tuple[pd.DataFrame, dict[str, Any]]:
    """
    Data with the angles of a place that are Series as columns, and the others.

    Parameters
    ----------
    data : DataFrame
        Record of the user; a column of the name of such an angle is replaced.
    place : dict
        Some of the arguments of :func:`pvlib_fem.drivers.checked_place`.

    Returns
    -------
    DataFrame
        With the angles as columns. [°]
    dict
        The arguments that are no Series.

    Raises
    ------
    ValueError
        If data are no frame, or have other times than a Series; or if an argument is
        none of a place.
    """
    refuse_no_frame(data)
    if unknown := [name for name in place if name not in PLACE]:
        raise ValueError(
            f"{unknown[0]} is no argument of a place{did_you_mean(unknown, PLACE)}; "
            f"they are {', '.join(PLACE)}"
        )
    series = {n: v for n, v in place.items() if isinstance(v, pd.Series)}
    if not series:
        return data, place
    own = [label for label in data if printable(label) in series]
    site = {"mount": checked_place(None, **series)["mount"]}
    data = with_given(data.drop(columns=own), site)[0]
    return data, {n: v for n, v in place.items() if n not in series}


def is_same_plane(
    data: pd.DataFrame, place: dict[str, Any], known: dict[str, Any]
) -> bool:
    """
    Whether rows have the place and the plane of a record.

    Parameters
    ----------
    data : DataFrame
        The rows, perhaps with the angles of their plane. [°]
    place : dict
        Arguments of :func:`pvlib_fem.drivers.checked_place` that are given for them.
    known : dict
        The place of the record.

    Returns
    -------
    bool
        True for rows without angles and arguments, for angles within 1° of those of
        the record, and for any angles if the plane of the record moves.
    """
    if not all(is_same(name, value, known[name]) for name, value in place.items()):
        return False
    if known["mount"] is not None:
        return True
    own = {printable(label): data[label] for label in data}
    return all(is_same(name, own[name], known[name]) for name in ANGLES if name in own)


def is_same(name: str, value: Any, known: Any) -> bool:
    """Whether an argument of a place, or a column of angles, is that of a record."""
    if known is None or value is None:
        return value is known
    if name in ANGLES:
        values = np.asarray(pd.Series(value).astype(float))
        apart = np.abs(angle_differences(name, values - known))
        return not (apart > FIXED).any()
    if name == "location":
        ends = [(one.latitude, one.longitude) for one in (value, known)]
        return ends[0] == ends[1]
    return value == known


def refuse_other(name: str, values: np.ndarray, given: float | None) -> None:
    """Refuse a column that has other angles than the one that is given."""
    if given is None:
        return
    apart = np.abs(angle_differences(name, values - given))
    if apart.max() <= FIXED:
        return
    raise ValueError(
        f"{name} is given as {given:g}°, and the column {name} has {values.min():.3g} "
        f"to {values.max():.3g}°, up to {apart.max():.0f}° from it; leave the argument "
        "out (--tilt and --azimuth), or drop the columns"
    )


def angle_differences(name: str, angles: np.ndarray) -> np.ndarray:
    """Differences of angles; those of an azimuth within half a turn."""
    return (angles + 180.0) % 360.0 - 180.0 if name == AZIMUTH else angles


def is_moving(known: dict[str, np.ndarray]) -> bool:
    """Whether a plane moves."""
    if TILT in known and known[TILT].max() <= FIXED:  # then no azimuth matters
        known = {name: values for name, values in known.items() if name != AZIMUTH}
    return any(
        np.abs(angle_differences(name, values - values[0])).max() > FIXED
        for name, values in known.items()
    )
