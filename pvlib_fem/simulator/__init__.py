"""A PV module outdoors, simulated from first principles, to test what explains it.

Three layers, each with its own random numbers: the `weather` of a `Site`, the
module in it (`simulate`: nodes in W/m², T⁴ radiation, TARP and MoWiTT convection,
water, snow, ground) and the sensors and loggers that watch (`measure`). Every
effect is a switch with an amplitude, 0 for off and 1 for its nominal size, so
that two runs which differ in one switch differ by that effect only. Nothing here
comes from the models of this package: convection is from [1]_, layers from [2]_,
mounting from [3]_, sun and sky from [4]_ and [5]_, wet bulb from [6]_, snow from [7]_.

References
----------
.. [1] EnergyPlus Engineering Reference, outside surface heat balance: TARP
   (Walton 1983) and MoWiTT (Yazdanian and Klems 1994) convection.
.. [2] B. Herteleer et al., 2022, :doi:`10.22541/au.166922866.68736478`, layers
   and heat capacities of a module.
.. [3] NREL System Advisor Model, ``lib_cec6par.cpp``: mounting, emissivities.
.. [4] J. W. Spencer, "Fourier series representation of the position of the sun",
   Search 2, 172 (1971); B. Haurwitz, J. Meteorol. 2, 154 (1945); A. B. Meinel and
   M. P. Meinel, "Applied solar energy", 1976, for the clear beam; D. Erbs et al.,
   Solar Energy 28, 293 (1982), :doi:`10.1016/0038-092X(82)90302-4`.
.. [5] P. Berdahl and M. Martin, Solar Energy 32, 663 (1984),
   :doi:`10.1016/0038-092X(84)90144-0`, emissivity of the clear sky.
.. [6] R. Stull, J. Appl. Meteorol. Climatol. 50, 2267 (2011),
   :doi:`10.1175/JAMC-D-11-0143.1`, wet-bulb temperature.
.. [7] B. Marion et al., "Measured and modeled photovoltaic system energy losses
   from snow for Colorado and Wisconsin locations", Solar Energy 97, 112 (2013).
"""

from dataclasses import asdict

import pandas as pd

from pvlib_fem.simulator.module import simulate
from pvlib_fem.simulator.sensors import measure
from pvlib_fem.simulator.site import ALBUQUERQUE, RHINE, Site
from pvlib_fem.simulator.sky import weather
from pvlib_fem.simulator.switches import LINEAR, OUTDOORS, PHYSICS, SWITCHES, UNITS

__all__ = [
    "ALBUQUERQUE",
    "LINEAR",
    "OUTDOORS",
    "PHYSICS",
    "RHINE",
    "SWITCHES",
    "UNITS",
    "Site",
    "difference",
    "measure",
    "record",
    "records",
    "simulate",
    "weather",
]


def record(site=RHINE, effects=OUTDOORS, days=365, step=60.0, seed=0, **options):
    """
    A record as a user would have it, and the truth in its ``attrs``.

    Parameters
    ----------
    site : Site
    effects : dict
        Switches and amplitudes; `LINEAR`, `PHYSICS`, `OUTDOORS` or one's own, as
        ``OUTDOORS | {"soiling": 1.0}``.
    days, step, seed
        As in `weather`.
    **options
        ``start`` as in `weather`, ``noise`` as in `measure`.

    Returns
    -------
    DataFrame
        As `measure` gives it. ``.attrs`` holds ``site``, ``effects``, ``seed``.

    Examples
    --------
    >>> data = record(effects=PHYSICS | {"sky_radiation": 1.0}, days=2)
    >>> list(data)[:4]
    ['poa_global', 'temp_air', 'wind_speed', 'temp_module']
    >>> data.attrs["effects"]["sky_radiation"]
    1.0
    """
    return next(records(site, [effects], days, step, seed, **options))


def records(site, scenarios, days=365, step=60.0, seed=0, start="2023-01-01", noise=1):
    """Records of several scenarios in one weather, one after the other."""
    sky = weather(site, days, step, start, seed)
    for effects in scenarios:
        truth = simulate(sky, site, effects)
        data = measure(sky, truth, site, effects, seed, noise)
        data.attrs = {"site": asdict(site), "effects": dict(effects), "seed": seed}
        yield data


def difference(on: pd.DataFrame, off: pd.DataFrame) -> pd.DataFrame:
    """
    Size of an effect: two records that differ in it, column by column.

    Returns
    -------
    DataFrame
        ``mean``, ``sd``, ``day``, ``night`` (sd by day, ``poa_global`` above 20
        W/m², and by night) for each column, in its unit.
    """
    change, sunny = on - off, off["poa_global"] > 20.0
    return pd.DataFrame(
        {
            "mean": change.mean(),
            "sd": change.std(),
            "day": change[sunny].std(),
            "night": change[~sunny].std(),
        }
    )
