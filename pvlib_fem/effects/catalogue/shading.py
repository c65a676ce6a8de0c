"""An obstacle between the sun and the module, or its irradiance sensor."""

from dataclasses import replace
from functools import partial

import numpy as np

from pvlib_fem.drivers.solar import beam_around
from pvlib_fem.effects.effect import Effect, Parameter, Terms
from pvlib_fem.effects.windows import find_windows, orthonormal

FAINT = 1e-3  # of the largest response to a clear sky, below which there is no sun


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


def scan(rest, tangents, columns, weeks, least):
    """
    Windows of the sky where what is left of a fit follows the beam.

    Before the module or before the sensor, whichever takes more of what is left.
    Where the sun stood whose beam is in the temperature is the mean place over the
    memory of the module.

    Parameters
    ----------
    rest : array
        What a fit leaves. [K]
    tangents : dict of array
        Responses of the temperature to :data:`EVERYWHERE`'s parameters, and those
        of all that it is weighed beside. [K]
    columns : mapping
    weeks : array of int
    least : float
        Gain that each window has to take. [K]

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
    found = {
        sensor: find_windows(rest, tangent, basis, sun, weeks, sign, least, rows)
        for sensor, tangent, sign in (
            (False, own["share"], 1.0),
            (True, own["unseen"], -1.0),
        )
    }
    sensor = found[True][0] > found[False][0]
    windows = found[sensor][1]
    return within(windows, sensor=sensor) if windows else None


def everywhere(
    beam,
    beam_around,
    beam_clear,
    sun_north,
    sun_east,
    solar_zenith,
    *,
    share,
    unseen,
    clear,
    north,
    east,
    up,
):
    """Loss of all beam, as it is and as expected, and where the sun stands."""
    place = clear + north * sun_north + east * sun_east + up * (90.0 - solar_zenith)
    return Terms(heat=beam_clear * place - share * beam - unseen * beam_around)


#: all of the sky, from which the scan takes windows
EVERYWHERE = Effect(
    "shading",
    everywhere,
    {
        name: Parameter(0.0, -1.0, 1.0, "-")
        for name in ("share", "unseen", "clear", "north", "east", "up")
    },
)
#: low sun in the east; where an obstacle really stands, a scan of windows shows
EFFECT = replace(
    within([(60.0, 180.0, 0.0, 15.0)]), make=within, scan=scan, scanned_from=EVERYWHERE
)
