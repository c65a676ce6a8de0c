"""Simulate a PV module outdoors from first principles, to test models and diagnoses.

There are three layers, each with its own random numbers: the `weather` of a `Site`,
the module in it (`simulate`: nodes in W/m², T⁴ radiation, TARP and MoWiTT
convection, water, snow, ground), and the sensors and loggers (`measure`). Every
effect is a switch with an amplitude, 0 for off and 1 for its nominal size. So two
runs that differ in one switch differ by that effect only. The simulator shares no
code with the models of this package: layers are from [1]_, mounting from [2]_, sun
and clear sky from [3]_, wet bulb from [4]_. If the literature has several
formulations of a law (convection, emissivity of the sky, soiling, snow, ...), a site's
`Forms` name one of them; `drawn` selects them at random.

`fuentes`, pvlib's model, is an alternative to `simulate`.

References
----------
.. [1] B. Herteleer et al., 2022, :doi:`10.22541/au.166922866.68736478`, layers
   and heat capacities of a module.
.. [2] NREL System Advisor Model, ``lib_cec6par.cpp``: mounting, emissivities.
.. [3] J. W. Spencer, "Fourier series representation of the position of the sun",
   Search 2, 172 (1971); B. Haurwitz, J. Meteorol. 2, 154 (1945); A. B. Meinel and
   M. P. Meinel, "Applied solar energy", 1976, for the clear beam.
.. [4] R. Stull, J. Appl. Meteorol. Climatol. 50, 2267 (2011),
   :doi:`10.1175/JAMC-D-11-0143.1`, wet-bulb temperature.
"""

from collections.abc import Iterable, Iterator
from dataclasses import asdict, replace
from typing import Any

import pandas as pd

from pvlib_fem.simulator._fuentes_world import fuentes
from pvlib_fem.simulator._loggers import measure
from pvlib_fem.simulator._module import simulate
from pvlib_fem.simulator._random_forms import drawn
from pvlib_fem.simulator._site import ALBUQUERQUE, RHINE, Site
from pvlib_fem.simulator._submodels import RIVALS, Days, Forms, Minutes, Obstacle
from pvlib_fem.simulator._switches import (
    LINEAR,
    OUTDOORS,
    PHYSICS,
    SWITCHES,
    UNITS,
    Effects,
)
from pvlib_fem.simulator._synthetic_weather import weather
from pvlib_fem.simulator._tracker import Stuck, Tracker

__all__ = [
    "ALBUQUERQUE",
    "GENERATORS",
    "LINEAR",
    "OUTDOORS",
    "PHYSICS",
    "RHINE",
    "RIVALS",
    "SWITCHES",
    "UNITS",
    "Days",
    "Forms",
    "Minutes",
    "Obstacle",
    "Site",
    "Stuck",
    "Tracker",
    "difference",
    "drawn",
    "fuentes",
    "measure",
    "record",
    "records",
    "simulate",
    "weather",
]


#: simulations of the module
GENERATORS = {"nodes": simulate, "fuentes": fuentes}


def record(
    site: Site = RHINE,
    effects: Effects = OUTDOORS,
    days: float = 365,
    step: float = 60.0,
    seed: int = 0,
    **options: Any,
) -> pd.DataFrame:
    """
    A simulated record, with the truth in its ``attrs``.

    Parameters
    ----------
    site : Site
        The site.
    effects : dict
        Switches and amplitudes; `LINEAR`, `PHYSICS`, `OUTDOORS` or your own, as
        ``OUTDOORS | {"soiling": 1.0}``.
    days, step, seed
        See `weather`.
    **options
        ``start`` of `weather`, ``noise`` of `measure`; ``forms`` instead of the site's,
        a `Forms` or the result of `drawn`; ``generator``, one of `GENERATORS`:
        ``"nodes"``, which is `simulate` and the default, or ``"fuentes"``.

    Returns
    -------
    DataFrame
        Columns of `measure`. ``.attrs`` holds ``site`` (with its ``forms``),
        ``effects``, ``seed``, ``generator``.

    Examples
    --------
    >>> data = record(effects=PHYSICS | {"sky_radiation": 1.0}, days=2)
    >>> list(data)[:4]
    ['poa_global', 'temp_air', 'wind_speed', 'temp_module']
    >>> data.attrs["effects"]["sky_radiation"]
    1.0
    """
    return next(records(site, [effects], days, step, seed, **options))


def records(
    site: Site,
    scenarios: Iterable[Effects],
    days: float = 365,
    step: float = 60.0,
    seed: int = 0,
    start: str = "2023-01-01",
    noise: float = 1,
    forms: Forms | None = None,
    generator: str = "nodes",
) -> Iterator[pd.DataFrame]:
    """
    Yield records of several scenarios in one weather.

    Parameters
    ----------
    site : Site
        The site.
    scenarios : iterable of dict
        Switches and amplitudes of each record, see `record`.
    days, step, start, seed
        See `weather`.
    noise : float, default 1
        See `measure`.
    forms : Forms, optional
        Instead of the site's.
    generator : str, default "nodes"
        One of `GENERATORS`.

    Yields
    ------
    DataFrame
        See `record`.

    Raises
    ------
    ValueError
        If the generator is unknown, or an argument of `weather` is out of range.
    """
    if generator not in GENERATORS:
        raise ValueError(
            f"generator = {generator!r}; it is {' or '.join(map(repr, GENERATORS))}"
        )
    site = site if forms is None else replace(site, forms=forms)
    sky = weather(site, days, step, start, seed)
    for effects in scenarios:
        truth = GENERATORS[generator](sky, site, effects)
        data = measure(sky, truth, site, effects, seed, noise)
        data.attrs = {"site": asdict(site), "effects": dict(effects)}
        data.attrs |= {"seed": seed, "generator": generator}
        yield data


def difference(on: pd.DataFrame, off: pd.DataFrame) -> pd.DataFrame:
    """
    Size of an effect by column, from two records that differ in it.

    Parameters
    ----------
    on, off : DataFrame
        Records with and without the effect, with the same times and columns.

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
