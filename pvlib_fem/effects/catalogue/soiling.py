"""Soiling between rains, of the module or of the irradiance sensor."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from pvlib_fem.drivers import Driver
from pvlib_fem.effects._effect import Effect, Parameter, Terms
from pvlib_fem.effects._scans import best_of


def terms(
    poa_global: np.ndarray, days_since_rain: np.ndarray, *, per_day: float
) -> Terms:
    r"""
    Irradiance lost by soiling of the sensor, minus that lost by the module's [1]_.

    .. math::

        \mathrm{heat} = \mathrm{per\_day} \cdot \mathrm{days\_since\_rain}
        \cdot \mathrm{poa\_global}

    It is positive if the sensor soils (it reads low, and the module is warmer than
    modelled), and negative if the module does. Constant soiling is in the coefficients
    of the steady model. Which rain cleans differs from site to site: 1 mm in an hour
    [2]_, 6 mm in a day and two weeks without dust after it [1]_. The scan takes the one
    that the record shows, first of a grid, then near that.

    References
    ----------
    .. [1] A. Kimber et al., "The Effect of Soiling on Large Grid-Connected
       Photovoltaic Systems in California and the Southwest Region of the United
       States", WCPEC 2006, :doi:`10.1109/WCPEC.2006.279690`, as in
       :func:`pvlib.soiling.kimber`, which has 0.15 % per day.
    .. [2] M. Coello and L. Boyle, "Simple Model for Predicting Time Series Soiling
       of Photovoltaic Panels", IEEE J. Photovoltaics 9, 1382 (2019),
       :doi:`10.1109/JPHOTOV.2019.2919628`, as in :func:`pvlib.soiling.hsu`.
    """
    return Terms(heat=per_day * days_since_rain * poa_global)


def soiling_by_rain(
    cleaning: float = 1.0,
    within: float = 3.0,
    dirtiest: float = 60.0,
    grace: float = 0.0,
) -> Effect:
    """
    The effect of soiling that ``cleaning`` mm of rain ``within`` hours wash off.

    It begins ``grace`` days after that rain, and is constant ``dirtiest`` days later.
    Kimber's values are 6 mm in 24 h, and 14 days of grace.
    """
    rain = {"cleaning": cleaning, "within": within}
    return SOILING.made(**rain, dirtiest=dirtiest, grace=grace)


def constant(
    poa_global: np.ndarray, precipitation: np.ndarray, *, even: float
) -> Terms:
    """Constant soiling; the scan derives the days since each rain that may clean."""
    return Terms(heat=even * poa_global)


def scan(
    rest: np.ndarray,
    tangents: dict,
    columns: Mapping[str, np.ndarray],
    weeks: np.ndarray,
    least: float,
    *,
    rains: Sequence[Mapping[str, float]],
    make: Callable,
) -> Effect:
    """
    The effect with that of several rains which explains most of a residual.

    Dirt changes from day to day, and a module follows within minutes. So the response
    to it is that to constant soiling, times its amount, with an error below 2 %.
    """
    even = tangents["soiling.even"]
    mine = (even * columns[since(rain)] for rain in rains)
    best = best_of(mine, [*tangents.values()], rest, either_sign=True)
    return make(**rains[best])


def since(rain: Mapping[str, float]) -> Driver:
    """The days since such a rain."""
    return Driver("days_since_rain", **rain)


#: amounts of rain that may clean [mm]
AMOUNTS = (0.5, 1.0, 2.0, 4.0, 6.0, 9.0, 12.0)
#: hours in which it falls, and days after it without dust: the hour of Coello and
#: Boyle, showers, and the day of Kimber et al., also with their days of grace
SPANS = ((1.0, 0.0), (3.0, 0.0), (6.0, 0.0), (12.0, 0.0), (24.0, 0.0), (24.0, 14.0))
RAINS = tuple(
    {"cleaning": amount, "within": within, "grace": grace}
    for within, grace in SPANS
    for amount in AMOUNTS
)
#: hours that are tried with rains near one of these
NEAR = {
    1.0: (1.0, 2.0),
    3.0: (2.0, 3.0, 4.5),
    6.0: (4.5, 6.0, 9.0),
    12.0: (9.0, 12.0, 18.0),
    24.0: (18.0, 24.0),
}
#: from one of the amounts to the next: which rains are enough is a matter of 1 mm
STEPS = 8
SOILING = Effect(
    "soiling",
    terms,
    {"per_day": Parameter(0.0, -0.01, 0.01, "1/day")},
    title="soiling between rains",
    decided_by="a cleaning of the sensor and, on another day, of the module",
    confused_with=(
        "season",
        "irradiance_sensor_drift",
        "natural_convection",
        "poa_misalignment",
        "the steady model's coefficients, if soiling is constant",
        "ground or a roof that is wet and cold after rain, and dries",
    ),
    loses_light=True,
    imitable=True,  # ground dries, and gets warmer, by the time since rain
)


def near(cleaning: float, within: float, grace: float) -> Effect:
    """Soiling of which a scan looks for the rain that cleans near that of the grid."""
    grid = [0.0, *AMOUNTS, 2.0 * AMOUNTS[-1]]
    at = grid.index(cleaning)
    around = np.interp(
        np.arange(1, 2 * STEPS) / STEPS, [0.0, 1.0, 2.0], grid[at - 1 : at + 2]
    )
    rains = [
        {"cleaning": amount, "within": hours, "grace": grace}
        for hours in NEAR[within]
        for amount in around.round(3).tolist()
    ]
    return scanned_over(rains, soiling_by_rain)


def scanned_over(rains: Sequence[Mapping[str, float]], make: Callable) -> Effect:
    """Soiling of which a scan looks for the rain that cleans among some."""
    wide = Effect(
        "soiling",
        constant,
        {"even": Parameter(0.0, -1.0, 1.0, "-")},
        columns=("poa_global", "precipitation"),
    )
    scanned = partial(scan, rains=rains, make=make)
    return replace(SOILING, make=soiling_by_rain, scan=scanned, scanned_from=wide)


EFFECT = scanned_over(RAINS, near)
