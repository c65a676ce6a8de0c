"""An obstacle between the sun and the module, or its irradiance sensor."""

from dataclasses import replace
from functools import partial

import numpy as np
from scipy.ndimage import binary_propagation, label

from pvlib_fem.drivers.solar import beam_around
from pvlib_fem.effects.effect import Effect, Parameter, Terms

ACROSS, UP = 9.0, 4.0  # ° of azimuth and elevation of a cell
AROUND = 40  # cells round the horizon
FEWEST = 0.005  # of the median cell's squares, below which a cell is not judged
ERRORS = 3.0  # of a cell's share, from week to week, from which it shows
BESIDE = 1.5  # the same of a cell that touches one that shows
ALIKE = 0.5  # of a group's share, from which a cell that touches it belongs to it
LEAST = 0.1  # share of lost beam that counts


def terms(beam, solar_azimuth, solar_zenith, *, share, windows):
    r"""
    Beam that a module loses while the sun stands in one of some windows [1]_.

    .. math::

        \mathrm{heat} = -\mathrm{share} \cdot \mathrm{beam}
        \cdot \mathrm{inside}(\mathrm{solar\_azimuth}, \mathrm{solar\_zenith})

    ``inside`` is 1 while the sun stands in one of the ``windows``, else 0.

    References
    ----------
    .. [1] The loss of beam irradiance behind a horizon, as in pvlib's gallery
       example "Simple irradiance adjustment for horizon shading".
    """
    return Terms(heat=-share * beam * within_any(windows, solar_azimuth, solar_zenith))


def unseen(beam, beam_clear, elapsed, solar_azimuth, solar_zenith, *, share, windows):
    r"""
    The same of the irradiance sensor, which reads less than the module gets.

    .. math::

        \mathrm{heat} = -\mathrm{share} \cdot \mathrm{beam\_around}
        \cdot \mathrm{inside}(\mathrm{solar\_azimuth}, \mathrm{solar\_zenith})

    ``share`` is negative, -1.5 to 0: the module is warmer than the sensor lets
    expect. ``beam_around`` is the beam that the hours around let expect, those in
    the windows left out.
    """
    inside = within_any(windows, solar_azimuth, solar_zenith)
    expected = beam_around(beam, beam_clear, elapsed, seen=~inside)
    return Terms(heat=-share * expected * inside)


def within_any(windows, solar_azimuth, solar_zenith):
    """Rows at which the sun stands in one of the windows."""
    inside = np.zeros(np.shape(solar_azimuth), dtype=bool)
    for start, end, low, high in windows:
        width = (end - start) % 360.0 or 360.0  # a window may contain north
        across = (solar_azimuth - start) % 360.0 < width
        elevation = 90.0 - solar_zenith
        inside |= across & (elevation >= low) & (elevation < high)
    return inside


def within(windows, sensor=False):
    """
    The effect of an obstacle that covers some windows of the sky.

    Parameters
    ----------
    windows : sequence
        Each ``(azimuth_from, azimuth_to, elevation_from, elevation_to)``, azimuth
        clockwise from north. [°]
    sensor : bool, default False
        Whether the obstacle shades the irradiance sensor: then the beam that it
        does not see is taken from the hours around.

    Returns
    -------
    Effect
    """
    windows = tuple(tuple(float(edge) for edge in window) for window in windows)
    if wrong := [w for w in windows if len(w) != 4 or not w[2] < w[3]]:
        raise ValueError(
            f"{wrong[0]} is no window of the sky; give azimuth_from, azimuth_to, "
            "elevation_from, elevation_to, the latter the higher"
        )
    # more than all of the beam, as the beam is estimated
    bounds = (-1.5, 0.0) if sensor else (-1.3, 1.3)
    lights = ("beam", "beam_clear", "elapsed") if sensor else ("beam",)
    lost = partial(unseen if sensor else terms, windows=windows)
    lost.__doc__ = lost.func.__doc__  # else that of all partials
    return Effect(
        "shading",
        lost,
        {"share": Parameter(0.0, *bounds, "-")},
        columns=(*lights, "solar_azimuth", "solar_zenith"),
        decided_by="a look at the horizon, or a photograph of it",
        settings={"windows": windows, "sensor": sensor},
        source="a window of the sky, before the " + ("sensor" if sensor else "module"),
        confused_with=(
            "poa_misalignment",
            "incidence_angle",
            "thermal_storage",
            "dew after sunrise",
            "a clock that is late",
        ),
    )


def scan(rest, lost, columns, weeks, criteria):
    """
    Windows of the sky where what is left of a fit follows the beam.

    Cells of the sky whose share of the beam shows from week to week, with those
    that touch them, of shade on the module or on the sensor, whichever shows more.

    Parameters
    ----------
    rest : array
        What a fit leaves. [K]
    lost : dict
        Response of the temperature to the loss of all beam, by :data:`EVERYWHERE`'s
        parameters. [K]
    columns : mapping
        ``solar_azimuth`` and ``solar_zenith`` of these rows. [°]
    weeks : array of int
    criteria : object

    Returns
    -------
    Effect or None
    """
    module, dark = shaded(rest, lost["shading.share"], columns, weeks, 1.0)
    sensor, blind = shaded(rest, lost["shading.unseen"], columns, weeks, -1.0)
    if max(module, sensor) == 0.0:
        return None
    windows = runs(blind if sensor > module else dark)
    return within(tuple(windows), sensor=bool(sensor > module))


def shaded(rest, lost, columns, weeks, sign):
    """Gain of the best group of cells where beam is lost, or gained, and which."""
    elevation = 90.0 - columns["solar_zenith"]
    sunny = np.flatnonzero((elevation > 0) & (lost < 0))
    bands = int(np.ceil(90.0 / UP))
    if len(sunny) == 0:
        return 0.0, np.zeros((bands, AROUND), dtype=bool)
    across = (columns["solar_azimuth"][sunny] % 360.0 // ACROSS).astype(int)
    cell = (elevation[sunny] // UP).astype(int) * AROUND + across
    week = np.unique(weeks[sunny], return_inverse=True)[1]
    shape = (week.max() + 1, AROUND * bands)
    size = shape[0] * shape[1]
    place, x = week * shape[1] + cell, lost[sunny]
    products = np.bincount(place, rest[sunny] * x, size).reshape(shape)
    squares = np.bincount(place, x * x, size).reshape(shape)
    whole = squares.sum(axis=0)
    known = whole > FEWEST * np.median(whole[whole > 0])
    share = np.divide(products.sum(axis=0), whole, out=0.0 * whole, where=known)
    error = np.sqrt(((products - share * squares) ** 2).sum(axis=0))
    sure = np.abs(products.sum(axis=0)) / np.maximum(error, 1e-12)
    likely = known & (sign * share > LEAST) & (sure > BESIDE)
    shows = likely & (sure > ERRORS)
    cells = (likely, shows, share, whole)
    return touching(*(column.reshape(-1, AROUND) for column in cells))


def touching(likely, shows, share, whole):
    """
    Of groups of cells that touch, that with the largest gain, and which it is.

    A group is cells that show, and likely ones around them with half its share.
    """
    best = (0.0, np.zeros_like(likely))
    # azimuth is a circle: the sky twice, side by side, keeps groups whole
    twice = label(np.hstack([shows, shows]))[0]
    for number in range(1, twice.max() + 1):
        group = (twice == number).reshape(len(likely), 2, -1).any(axis=1)
        mean = abs((share * whole)[group].sum() / whole[group].sum())
        alike = likely & (np.abs(share) > ALIKE * mean)
        around, allowed = (np.hstack([a] * 3) for a in (group & alike, alike))
        wide = binary_propagation(around, mask=allowed)
        group = wide.reshape(len(likely), 3, -1).any(axis=1)
        gain = (share**2 * whole)[group].sum()
        if gain > best[0]:
            best = (gain, group)
    return best


def runs(marked):
    """Windows of a group of cells: in each band of elevation its runs of azimuth."""
    for band, row in enumerate(marked):
        edges = np.flatnonzero(np.diff(np.concatenate(([0], row, [0]))))
        for start, end in zip(edges[::2], edges[1::2]):
            yield (start * ACROSS, end * ACROSS, band * UP, (band + 1) * UP)


def both(beam, beam_around, solar_azimuth, solar_zenith, *, share, unseen):
    """Loss of all beam, as it is and as the hours around let expect it."""
    return Terms(heat=-share * beam - unseen * beam_around)


#: all of the sky, from which the scan takes windows
EVERYWHERE = Effect(
    "shading",
    both,
    {
        "share": Parameter(0.0, -1.0, 1.0, "-"),
        "unseen": Parameter(0.0, -1.5, 0.0, "-"),
    },
)
#: low sun in the east; where an obstacle really stands, a scan of windows shows
EFFECT = replace(
    within([(60.0, 180.0, 0.0, 15.0)]), make=within, scan=scan, scanned_from=EVERYWHERE
)
