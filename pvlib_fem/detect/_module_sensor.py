"""A module's temperature sensor that has come off."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from pvlib_fem._record.checks import dates_of as numbers_of
from pvlib_fem.detect._changes import dates_of
from pvlib_fem.detect._checked_series import checked_series
from pvlib_fem.quality._detached_sensor import (
    FEWEST,
    HALF,
    SUNNY,
    THAWED,
    detached_days,
    sunny_days,
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
        If indexes differ, or fewer than five days have sun above 200 W/m² and a module
        above 3 °C.

    Notes
    -----
    The over-temperature by irradiance of each day (Ross's coefficient [1]_) has a level
    that changes seldom. A sensor has come off where that is below half of the highest
    level that lasts ten days, or below 0.008 K m²/W, which is less than any mounting
    has. Rows with a module below 3 °C do not count, since one under snow looks the
    same. :func:`pvlib_fem.close_loop` makes this check itself, by stricter rules.

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
    sunny = sunny_days(module, air, poa, numbers_of(index))
    days = sunny.days
    if len(days) < FEWEST:
        raise ValueError(
            f"{len(days)} days have sun above {SUNNY:.0f} W/m², a module above "
            f"{THAWED:.0f} °C and both temperatures, and at least {FEWEST} are needed; "
            "give a longer record"
        )
    off, attached = detached_days(days, sunny.rise, HALF)
    dates = dates_of(days)
    return DetachedSensor(
        pd.Series(off, dates, dtype=bool), pd.Series(sunny.rise, dates), attached
    )
