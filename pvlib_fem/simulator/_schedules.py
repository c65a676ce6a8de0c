"""Scheduled activities around a module."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from pvlib_fem.simulator._constants import hour_and_day, random_stream, times_of
from pvlib_fem.simulator._submodels import Days, Forms, Minutes

PLAIN = Forms()


def curtailed_hours(weather: pd.DataFrame) -> np.ndarray:
    """
    Hours without output: midday, most often on weekends in spring.

    Parameters
    ----------
    weather : pandas.DataFrame, shape (rows, columns)
        Result of `weather`; the seed in its ``attrs`` determines the days.

    Returns
    -------
    numpy.ndarray of bool, shape (rows,)
        True without output.
    """
    times, seed = times_of(weather), weather.attrs.get("seed", 0)
    weekend = times.day_of_week.to_numpy() >= 5
    spring = (times.month.to_numpy() >= 3) & (times.month.to_numpy() <= 6)
    odds = np.where(weekend, 0.25, 0.08) + np.where(spring, 0.3, 0.0)
    days = times.day_of_year.to_numpy() - 1
    draw, first, last = random_stream(seed, "curtailment").random((3, 366))[:, days]
    hour, _ = hour_and_day(times)
    return (draw < odds) & (hour >= 9.5 + 2 * first) & (hour < 13.5 + 2.5 * last)


def undeclared_heat(
    times: pd.DatetimeIndex,
    air: np.ndarray,
    on: Mapping[str, float],
    forms: Forms = PLAIN,
) -> tuple[np.ndarray, np.ndarray]:
    """
    Heat of scheduled and neighbouring sources, on glass and back. [W/m²]

    Parameters
    ----------
    times : DatetimeIndex, shape (rows,)
        In local standard time.
    air : array, shape (rows,)
        Air temperature. [°C]
    on : dict of float
        Amplitudes by switch.
    forms : Forms, optional
        With the timetables.

    Returns
    -------
    front, back : array, shape (rows,)
        Positive if the module is warmed.
    """
    hour, month = hour_and_day(times)[0], times.month.to_numpy()
    weekend = times.day_of_week.to_numpy() >= 5
    exhaust = 120.0 * (weekend & (hour >= 9) & (hour < 16))
    chiller = 100.0 * np.clip((air - 18.0) / 10.0, 0.0, 1.0)
    chiller *= (month >= 6) & (month <= 8) & (hour >= 13) & (hour < 19)
    animals = 50.0 * (((hour >= 20) | (hour < 6)) & ((month <= 4) | (month >= 10)))
    watered = on_its_day(times, forms.watering) & (month >= 4) & (month <= 9)
    back = on["weekend_exhaust"] * exhaust + on["chiller"] * chiller
    back = back + on["fan"] * 100.0 * is_running(times, forms.fan)
    return on["irrigation"] * -150.0 * watered, back + on["shelter"] * animals


def on_its_day(times: pd.DatetimeIndex, timetable: Days) -> np.ndarray:
    """Whether a timetable of days has something on, in local standard time."""
    day = local_units(times, "D")
    hour, _ = hour_and_day(times)
    some = [(hour >= first) & (hour < last) for first, last in timetable.hours]
    return np.any(some, axis=0) & (day % timetable.every == timetable.phase)


def is_running(times: pd.DatetimeIndex, timetable: Minutes) -> np.ndarray:
    """Whether a timetable of minutes has something on, in local standard time."""
    minute = local_units(times, "s") / 60.0
    return (minute - timetable.phase) % timetable.period < timetable.on


def local_units(times: pd.DatetimeIndex, unit: str) -> np.ndarray:
    """Whole units since 1970-01-01 in local time."""
    return times.tz_localize(None).to_numpy().astype(f"datetime64[{unit}]").astype(int)
