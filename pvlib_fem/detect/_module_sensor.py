"""A module's temperature sensor that has come off."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from pvlib_fem._record.checks import dates_of as numbers_of
from pvlib_fem.detect._changes import dates_of
from pvlib_fem.detect._checked_series import checked_series
from pvlib_fem.detect._path import Law, most_probable
from pvlib_fem.quality._limits import GAIN

SUNNY = 200.0  # W/m², above which a module is warmer than the air
FEWEST = 5  # sunny days
LASTS = 10  # days of a level that is the attached sensor's
HALF = 0.5  # of the attached sensor's over-temperature, below which it has come off
LOWEST = 1e-3  # K m²/W, what stands for none
LAW = Law(
    np.arange(-4.0, 1.0, 0.1),  # logarithms
    odds=1e-4,
    accident=0.1,
    least=0.1,
    fine=0.05,
    memory=2.0,
    swing=0.2,
)


@dataclass(frozen=True, eq=False)
class DetachedSensor:
    """
    Days on which a module's sensor is off, from :func:`detached_module_sensor`.

    Attributes
    ----------
    detached : Series of bool
        For each sunny day.
    over_temperature : Series
        Over-temperature by irradiance of each day. [K m²/W]
    attached : float
        Resistance of the attached sensor; NaN if it never is attached. [K m²/W]
    """

    detached: pd.Series
    over_temperature: pd.Series
    attached: float

    def __str__(self) -> str:
        if not self.detached.any():
            return "attached all the time"
        edges = np.flatnonzero(self.detached.astype(int).diff().fillna(1.0))
        parts = self.detached.iloc[edges]
        words = {True: "detached", False: "attached"}
        return "\n".join(
            f"{day:%Y-%m-%d}  {words[bool(off)]}" for day, off in parts.items()
        )


def detached_module_sensor(
    temp_module: pd.Series, temp_air: pd.Series, poa_global: pd.Series
) -> DetachedSensor:
    """
    Days on which a sensor reads the air instead of the module behind which it was.

    Parameters
    ----------
    temp_module, temp_air : Series
        [°C]
    poa_global : Series
        [W/m²]

    Returns
    -------
    DetachedSensor

    Raises
    ------
    TypeError
        If a column is no Series with a DatetimeIndex.
    ValueError
        If indexes differ, or fewer than five days have sun above 200 W/m².

    Notes
    -----
    The over-temperature by irradiance of each day (Ross's coefficient [1]_) has a level
    that changes seldom. A sensor has come off where that is below half of the highest
    level that lasts ten days, or below 0.008 K m²/W, which is less than any mounting
    has. A module under snow for weeks looks the same.

    References
    ----------
    .. [1] R. G. Ross, "Flat-plate photovoltaic array design optimization", 14th IEEE
       Photovoltaic Specialists Conference, 1126-1132, 1980.

    Examples
    --------
    >>> from pvlib_fem import detect, simulator
    >>> data = simulator.record(days=90, step=3600, start="2023-04-01")
    >>> off = data["temp_air"].where(data.index >= "2023-06-01", data["temp_module"])
    >>> print(detect.detached_module_sensor(off, data["temp_air"], data["poa_global"]))
    2023-04-01  attached
    2023-06-01  detached
    """
    index, (module, air, poa) = checked_series(
        temp_module=temp_module, temp_air=temp_air, poa_global=poa_global
    )
    rows = (poa > SUNNY) & np.isfinite(module + air)
    days, place = np.unique(numbers_of(index)[rows], return_inverse=True)
    if len(days) < FEWEST:
        raise ValueError(
            f"{len(days)} days have sun above {SUNNY:.0f} W/m² and both temperatures, "
            f"and at least {FEWEST} are needed; give a longer record"
        )
    over = np.bincount(place, (module - air)[rows]) / np.bincount(place, poa[rows])
    logs = np.log(np.maximum(over, LOWEST))
    middle = np.median(logs)
    path = most_probable(days, logs - middle, LAW)
    residual = logs - path.usual - path.level
    levels, lasts = np.unique(path.level, return_counts=True)
    height = {
        one: float(np.exp(np.median((residual + path.usual + one)[path.level == one])))
        for one in levels
    }
    long = [
        one for one, number in zip(levels, lasts) if number >= min(LASTS, len(days))
    ]
    best = max((height[one] for one in long), default=np.nan)
    least = np.fmax(GAIN[0], HALF * best)
    off = {one: height[one] < least for one in levels}
    dates = dates_of(days)
    return DetachedSensor(
        pd.Series([off[one] for one in path.level], dates, dtype=bool),
        pd.Series(over, dates),
        float(best) if best >= GAIN[0] else np.nan,
    )
