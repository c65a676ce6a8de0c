"""An obstacle between the sun and the module, or its irradiance sensor."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from pvlib_fem._statistics.leastsquares import orthonormal
from pvlib_fem.drivers._solar import beam_around
from pvlib_fem.effects._effect import Effect, Parameter, Terms
from pvlib_fem.effects._windows import find_windows

FAINT = 1e-3  # of the largest response to a clear sky; below it there is no sun


def terms(
    beam: np.ndarray,
    solar_azimuth: np.ndarray,
    solar_zenith: np.ndarray,
    *,
    share: float,
    windows: tuple,
) -> Terms:
    r"""
    Beam that a module loses while the sun is in one of some windows of the sky [1]_.

    .. math::

        \mathrm{heat} = -\mathrm{share} \cdot \mathrm{beam}
        \cdot \mathrm{inside}(\mathrm{solar\_azimuth}, \mathrm{solar\_zenith})

    ``inside`` is 1 while the sun is in one of the ``windows``, else 0.

    References
    ----------
    .. [1] The loss of beam irradiance behind a horizon, as in pvlib's gallery
       example "Simple irradiance adjustment for horizon shading".
    """
    return Terms(heat=-share * beam * within_any(windows, solar_azimuth, solar_zenith))


def unseen(
    beam: Any,
    beam_clear: Any,
    elapsed: Any,
    solar_azimuth: np.ndarray,
    solar_zenith: np.ndarray,
    *,
    share: float,
    windows: Any,
) -> Any:
    r"""
    Beam that a shaded irradiance sensor does not measure and the module receives.

    .. math::

        \mathrm{heat} = -\mathrm{share} \cdot \mathrm{beam\_around}
        \cdot \mathrm{inside}(\mathrm{solar\_azimuth}, \mathrm{solar\_zenith})

    ``share`` is negative, -1.5 to 0: the module is warmer than by the sensor's reading.
    ``beam_around`` is the expected beam from the hours before and after, without those
    in the windows.
    """
    inside = within_any(windows, solar_azimuth, solar_zenith)
    expected = beam_around(beam, beam_clear, elapsed, seen=~inside)
    return Terms(heat=-share * expected * inside)


def within_any(
    windows: tuple, solar_azimuth: np.ndarray, solar_zenith: np.ndarray
) -> Any:
    """Mask of rows with the sun in one of the windows."""
    inside = np.zeros(np.shape(solar_azimuth), dtype=bool)
    for start, end, low, high in windows:
        width = (end - start) % 360.0 or 360.0  # a window may contain north
        across = (solar_azimuth - start) % 360.0 < width
        elevation = 90.0 - solar_zenith
        inside |= across & (elevation >= low) & (elevation < high)
    return inside


def window_effect(windows: Sequence, sensor: bool = False) -> Effect:
    """
    The effect of an obstacle that covers some windows of the sky.

    Parameters
    ----------
    windows : sequence
        Tuples ``(azimuth_from, azimuth_to, elevation_from, elevation_to)``, azimuth
        clockwise from north. [°]
    sensor : bool, default False
        Whether the obstacle shades the irradiance sensor. Then the missing beam is
        estimated from the hours before and after.

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
    # above 1, because the beam is estimated
    bounds = (-1.5, 0.0) if sensor else (-1.3, 1.3)
    lights = ("beam", "beam_clear", "elapsed") if sensor else ("beam",)
    lost = partial(unseen if sensor else terms, windows=windows)
    lost.__doc__ = lost.func.__doc__  # instead of functools.partial's
    return Effect(
        "shading",
        lost,
        {"share": Parameter(0.0, *bounds, "-")},
        columns=(*lights, "solar_azimuth", "solar_zenith"),
        unseen_light=sensor,
        geometric=True,
        title="shade on the modules or on the irradiance sensor",
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


def scan(
    rest: np.ndarray, tangents: dict, columns: dict, weeks: np.ndarray, least: float
) -> Any:
    """
    Windows of the sky in which the residual is proportional to the beam.

    The obstacle is in front of the module or of the sensor, whichever explains more of
    the residual. The solar position is averaged over the time constant of the module,
    because the temperature responds to past beam.

    Parameters
    ----------
    rest : array
        Residual of a fit. [K]
    tangents : dict of array
        Responses of the temperature to :data:`EVERYWHERE`'s parameters, and to all
        fitted coefficients. [K]
    columns : mapping
    weeks : array of int
    least : float
        Least gain of each window. [K]

    Returns
    -------
    Effect or None
    """
    keys = EVERYWHERE.rows()
    own = dict(zip(EVERYWHERE.parameters, (tangents[key] for key in keys)))
    lit = np.flatnonzero(own["clear"] > FAINT * own["clear"].max())
    others = [column for name, column in tangents.items() if name not in keys]
    basis, rows = orthonormal(others, lit), len(rest)
    own = {name: column[lit] for name, column in own.items()}
    azimuth = np.degrees(np.arctan2(own["east"], own["north"])) % 360.0
    sun = azimuth, own["up"] / own["clear"]
    rest, weeks = rest[lit], weeks[lit]
    windows_by_kind = {
        sensor: find_windows(rest, tangent, basis, sun, weeks, sign, least, rows)
        for sensor, tangent, sign in (
            (False, own["share"], 1.0),
            (True, own["unseen"], -1.0),
        )
    }
    sensor = windows_by_kind[True][0] > windows_by_kind[False][0]
    windows = windows_by_kind[sensor][1]
    return window_effect(windows, sensor=sensor) if windows else None


def everywhere(
    beam: np.ndarray,
    beam_around: np.ndarray,
    beam_clear: np.ndarray,
    sun_north: np.ndarray,
    sun_east: np.ndarray,
    solar_zenith: np.ndarray,
    *,
    share: float,
    unseen: float,
    clear: float,
    north: float,
    east: float,
    up: float,
) -> Terms:
    """Loss of all beam, estimated and expected, and the solar position."""
    place = clear + north * sun_north + east * sun_east + up * (90.0 - solar_zenith)
    return Terms(heat=beam_clear * place - share * beam - unseen * beam_around)


#: the whole sky, in which the scan finds windows
EVERYWHERE = Effect(
    "shading",
    everywhere,
    {
        name: Parameter(0.0, -1.0, 1.0, "-")
        for name in ("share", "unseen", "clear", "north", "east", "up")
    },
)
#: low sun in the east as a default; a scan finds the windows of a real obstacle
EFFECT = replace(
    window_effect([(60.0, 180.0, 0.0, 15.0)]),
    make=window_effect,
    scan=scan,
    scanned_from=EVERYWHERE,
)
