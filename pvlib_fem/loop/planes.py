"""The plane of the modules by columns of a record: fixed, or one that moves."""

import numpy as np

from pvlib_fem.reasons import Reason, because
from pvlib_fem.record.columns import GEOMETRY, numeric, printable, with_aliases

TILT, AZIMUTH = ANGLES = GEOMETRY[2:]
FIXED = 1.0  # ° within which a plane is one and the same


def plane_of_columns(data, site):
    """
    Take the plane of the modules from a record's columns.

    Parameters
    ----------
    data : DataFrame
        May have ``surface_tilt`` and ``surface_azimuth``, as pvlib's trackers do. [°]
    site : dict
        ``location``, ``surface_tilt`` and ``surface_azimuth``, as they are given.

    Returns
    -------
    dict
        The site, with the angles of a fixed plane.
    Because or None
        Of a plane that moves: why effects that depend on it are not tested.

    Raises
    ------
    ValueError
        If angles are given and the columns have others.
    """
    own = [label for label in data if printable(label) in ANGLES]
    columns = numeric(with_aliases(data[own], ())) if own else {}
    known = {name: column.dropna().to_numpy() for name, column in columns.items()}
    known = {name: values for name, values in known.items() if len(values)}
    for name, values in known.items():
        refuse_other(name, values, site[name])
    if not known:
        return site, None
    if (name := moving(known)) is not None:
        low, high = known[name].min(), known[name].max()
        return {**site, **dict.fromkeys(ANGLES)}, because(
            Reason.MOVING_PLANE, column=name, low=float(low), high=float(high)
        )
    angles = {name: float(np.median(values)) for name, values in known.items()}
    return {**site, **{n: v for n, v in angles.items() if site[n] is None}}, None


def refuse_other(name, values, given):
    """Refuse a column that has other angles than the one that is given."""
    if given is None or (apart := np.abs(turned(name, values - given))).max() <= FIXED:
        return
    raise ValueError(
        f"{name} is given as {given:g}°, and the column {name} has {values.min():.3g} "
        f"to {values.max():.3g}°, up to {apart.max():.0f}° from it; leave the argument "
        "out (--tilt and --azimuth), or drop the columns"
    )


def turned(name, angles):
    """Differences of angles; those of an azimuth within half a turn."""
    return (angles + 180.0) % 360.0 - 180.0 if name == AZIMUTH else angles


def moving(known):
    """The column by which a plane moves, or None of a fixed one."""
    for name, values in known.items():
        level = name == AZIMUTH and TILT in known and known[TILT].max() <= FIXED
        if np.abs(turned(name, values - values[0])).max() > FIXED and not level:
            return name
    return None
