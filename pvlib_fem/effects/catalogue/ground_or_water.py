"""Ground or water near the modules that follows the air by days or weeks."""

from functools import partial

import numpy as np

from pvlib_fem.drivers import Driver
from pvlib_fem.effects._effect import Effect, Parameter, Terms
from pvlib_fem.effects._scans import best_setting


def terms(temp_air: np.ndarray, air_of_weeks: np.ndarray, *, exchange: float) -> Terms:
    r"""
    Heat exchange with a mass that follows the air by days or weeks [1]_.

    .. math::

        \mathrm{heat} = \mathrm{exchange} \cdot
        (\mathrm{air\_of\_weeks} - \mathrm{temp\_air})

    The mass is water below floating modules, or deep ground. It is colder than the air
    in spring and on warm days, and warmer in autumn and on cold days. The scan takes
    the time constant that the record shows.

    References
    ----------
    .. [1] J. E. Edinger, D. W. Duttweiler and J. C. Geyer, "The response of water
       temperatures to meteorological conditions", Water Resources Research 4, 1137
       (1968), :doi:`10.1029/WR004i005p01137`: a first-order response. Its time
       constant is the heat capacity over the exchange of the surface, 5 days for 3 m
       of mixed water at 30 W/(m² K), and 16 days for 10 m.
    """
    return Terms(heat=exchange * (air_of_weeks - temp_air))


def of_memory(memory: float = 16.0) -> Effect:
    """The effect of a mass with a time constant of ``memory`` days."""
    return EFFECT.unscanned.made(memory=memory)


def every_memory(temp_air: np.ndarray, *means: np.ndarray, **exchange: float) -> Terms:
    """Masses with each of the time constants."""
    pairs = zip(means, exchange.values())
    # a slope has one of them
    flows = sum(size * (mean - temp_air) for mean, size in pairs if size)
    return Terms(heat=flows + 0.0 * temp_air)


MEMORIES = (4.0, 8.0, 16.0, 32.0)  # days
EXCHANGE = Parameter(0.0, 0.0, 20.0, "W/(m² K)")
EFFECT = Effect(
    "ground_or_water",
    terms,
    {"exchange": EXCHANGE},
    confounder=True,
    title="heat exchange with ground or water that follows the air by weeks",
    decided_by="a temperature sensor in the water, or in the ground below the modules",
    confused_with=(
        "temperature_gain",
        "thermal_storage",
        "season",
        "sky_radiation",
        "an offset of a thermometer that drifts",
    ),
    make=of_memory,
    scan=partial(
        best_setting,
        parameter="ground_or_water.exchange",
        settings=[{"memory": days} for days in MEMORIES],
        make=of_memory,
    ),
    scanned_from=Effect(
        "ground_or_water",
        every_memory,
        {f"exchange_{i}": EXCHANGE for i in range(len(MEMORIES))},
        columns=(
            "temp_air",
            *(Driver("air_of_weeks", memory=days) for days in MEMORIES),
        ),
    ),
)
