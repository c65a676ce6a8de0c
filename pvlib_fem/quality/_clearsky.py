"""What a clear sky would give an irradiance sensor on the clearest days."""

import numpy as np
import pandas as pd
from pvlib.location import Location

from pvlib_fem.quality._plane import at_rows, clear_days

SHARE = 0.2  # of each month's days that are looked at
SHAPE = 0.1  # of the day's mean, root mean square, by which a clear day may differ
FLAT = (0.0, 180.0)  # where the angles are not known: the season is taken out anyway


def clear_sky(
    poa_global: np.ndarray,
    index: pd.DatetimeIndex,
    location: Location,
    angles: tuple | None = None,
    late: float = 0.0,
) -> np.ndarray:
    """
    Irradiance of a clear sky on the clear days of a record, NaN in all other rows.

    Parameters
    ----------
    poa_global : array, shape (rows,)
        [W/m²]
    index : DatetimeIndex, shape (rows,)
        Without a zone in standard time at the location.
    location : pvlib.location.Location
        Of the sensor.
    angles : tuple of float or array, optional
        Tilt and azimuth of the sensor; a flat one where they are not known, arrays of
        one that moves. [°]
    late : float
        By how much the rows' times are late. [s]

    Returns
    -------
    array, shape (rows,)
        [W/m²]

    Notes
    -----
    Of each month of each year the fifth of the days with most light for the sun's
    height is looked at; those are clear whose values, in order of size, are those of a
    clear sky (Ineichen and Perez [1]_) but for a factor. So neither a sensor that
    fades nor a clock that is late changes which days are clear. The sky's turbidity is
    the same all the time: the ratio to what was measured has the season in it, and
    the years.

    References
    ----------
    .. [1] P. Ineichen and R. Perez, "A new airmass independent formulation for the
       Linke turbidity coefficient", Solar Energy 73, 151-157, 2002, as in
       :func:`pvlib.clearsky.ineichen`. :doi:`10.1016/S0038-092X(02)00045-2`
    """
    clear_poa, local = np.full(len(index), np.nan), index.tz_localize(None)
    months = np.asarray(12 * local.year + local.month)
    looked = clear_days(poa_global, index, location, late, months, SHARE)
    if looked is None:
        return clear_poa
    rows, sky = looked
    modelled = sky.on_plane(at_rows(angles or FLAT, rows))
    clear = shape_deviation(sky.poa, modelled, sky.day) < SHAPE
    clear_poa[rows] = np.where(clear[sky.day], modelled, np.nan)
    return clear_poa


def shape_deviation(
    poa: np.ndarray, modelled: np.ndarray, day: np.ndarray
) -> np.ndarray:
    """Relative RMS of each day between ordered values, after scaling by a factor."""
    one, other = (values[np.lexsort((values, day))] for values in (poa, modelled))
    # sorted by day, too
    day = np.sort(day)
    times = np.bincount(day, one) / np.maximum(np.bincount(day, other), 1e-9)
    square = np.bincount(day, (one - times[day] * other) ** 2) / np.bincount(day)
    mean = np.bincount(day, one) / np.bincount(day)
    return np.sqrt(square) / np.maximum(mean, 1e-9)
