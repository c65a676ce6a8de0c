"""What trees know of a record: its columns, their past, the hour and the date."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from pvlib.location import Location

from pvlib_fem._record.column_names import (
    ANGLES,
    COLUMNS,
    GEOMETRY,
    is_power,
    twin_of,
)
from pvlib_fem._record.inputs import Record
from pvlib_fem.drivers import geometry
from pvlib_fem.reasons import Reason

USUAL = ("poa_global", "temp_air")  # in all trees; without them nothing is left
BACK = (1, 2, 3)  # steps, of values that are past
WINDOWS = ("1h", "6h", "24h")  # of means of the past, where they are longer than a step
POWER, WIND, OTHER = "power", "wind", "other columns"
PAST, CLOCK, DATE = "past values", "hour and season", "date"


def features(record: Record, loop: Any, rows: np.ndarray) -> tuple[dict, dict]:
    """
    Columns of the trees on some rows, and the names of each group.

    No column is the module's temperature: neither that itself, nor a second sensor of
    it, nor a column that the loop found to be made from it.

    Parameters
    ----------
    record : Record
    loop : Loop
        For its location, and for columns that are made from the temperature.
    rows : array of int, shape (rows,)
        Positions in the record.

    Returns
    -------
    columns : dict of array, shape (rows,)
    groups : dict of set of str
        Names of columns by group; the usual columns are in none.
    """
    leaks = {
        why.values["column"]
        for reason in loop.untestable.values()
        for why in reason.all
        if why.reason is Reason.LEAK
    }
    none = {COLUMNS[3], *GEOMETRY, *leaks, *record.absent}
    columns, groups = {}, {PAST: set()}
    for name in record.inputs.columns:
        if name in none or twin_of(name) == COLUMNS[3]:
            continue
        past = dict(past_of(name, record, rows))
        columns |= {name: np.asarray(record[name], dtype=float)[rows], **past}
        groups[PAST] |= {*past}
        if name not in USUAL:
            groups.setdefault(group_of(name), set()).update({name, *past})
    clock = {n: values[rows] for n, values in clock_of(record, loop.place["location"])}
    date = {DATE: record.inputs.seconds[rows]}
    groups |= {CLOCK: {*clock}, DATE: {*date}}
    return {**columns, **clock, **date}, groups


def group_of(name: str) -> str:
    """The group of a column by its name."""
    if is_power(name) or name == "p_dc_per_area":
        return POWER
    blows = name in ("wind_speed", "wind_direction") or twin_of(name) == "wind_speed"
    return WIND if blows else OTHER


def past_of(name: str, record: Record, rows: np.ndarray) -> Iterator:
    """Values some steps before, and means of the time before, without the present."""
    values, seconds = np.asarray(record[name], dtype=float), record.inputs.seconds
    step = record.inputs.step
    for back in BACK:
        at = np.maximum(rows - back, 0)
        near = (rows >= back) & (seconds[rows] - seconds[at] < (back + 0.5) * step)
        yield f"{name}, {back} before", np.where(near, values[at], np.nan)
    series = pd.Series(values, pd.to_datetime(seconds, unit="s"))
    for window in WINDOWS:
        if pd.Timedelta(window).total_seconds() > step:
            means = past_means(series, window, name in ANGLES)
            yield f"{name}, {window} before", means.to_numpy()[rows]


def past_means(values: pd.Series, window: str, circular: bool) -> pd.Series:
    """Means of the time before each row; of directions, that of vectors."""
    if circular:
        turned = np.radians(values)
        east, north = (past_means(f(turned), window, False) for f in (np.sin, np.cos))
        return pd.Series(np.degrees(np.arctan2(east, north)), values.index) % 360.0
    return values.rolling(window, closed="left").mean()


def clock_of(record: Record, location: Location | None) -> Iterator:
    """Hour, day of the week and of the year, and where the sun stands."""
    times = record.index
    yield "hour", np.asarray(times.hour + times.minute / 60.0)
    yield "weekday", np.asarray(times.day_of_week)
    yield "season", np.asarray(times.day_of_year)
    for name, place in geometry(times, location).items():
        yield name, place.to_numpy()
