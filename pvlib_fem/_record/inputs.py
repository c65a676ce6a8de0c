"""Columns on common times, checked once: what all else works on."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.checks import (
    as_given,
    as_numbers,
    as_times,
    common_index,
    dates_of,
    datetime_steps,
    no_datetimes,
    plain_steps,
)
from pvlib_fem._record.column_names import STATED, known_values


@dataclass(frozen=True, eq=False)
class Times:
    """What follows from the times of some rows alone, found once for all columns."""

    index: pd.Index
    steps: np.ndarray | float
    unit: float

    @cached_property
    def seconds(self) -> np.ndarray:
        """Time of each row since the first. [s]"""
        if np.ndim(self.steps) == 0:
            return np.arange(len(self.index)) * (self.steps * self.unit)
        steps = np.array(self.steps, dtype=float)
        steps[0] = 0.0
        return np.cumsum(steps) * self.unit

    @cached_property
    def dates(self) -> np.ndarray:
        """Calendar day of each row in the record's own zone, from 1970-01-01."""
        return dates_of(self.index)

    @cached_property
    def runs(self) -> Any:
        """First row of each run of rows of one date, and the date."""
        other = self.dates[1:] != self.dates[:-1]
        first = np.concatenate(([0], np.flatnonzero(other) + 1))[: len(self.dates)]
        return first, self.dates[first]


class Columns(Mapping):
    """
    Columns by name, kept as they were given and read in double precision.

    What is in single precision would take twice its memory again if all of it were
    widened: rows are taken first, and the requested ones are widened.

    Parameters
    ----------
    given : mapping of array
    """

    def __init__(self, given: Mapping) -> None:
        own = given.given if isinstance(given, Columns) else given
        self.given: dict[str, np.ndarray] = {**own}

    def __getitem__(self, name: str) -> np.ndarray:
        return self.given[name].astype(float, copy=False)

    def __contains__(self, name: object) -> bool:
        return name in self.given

    def __iter__(self) -> Iterator[str]:
        return iter(self.given)

    def __len__(self) -> int:
        return len(self.given)

    def __or__(self, more: "dict | Columns") -> "Columns":
        """The columns, with others that replace them or are added."""
        return Columns(self.given | Columns(more).given)

    @property
    def narrow(self) -> bool:
        """Whether any is to be widened where it is read."""
        return any(values.dtype != float for values in self.given.values())

    def only(self, names: Any) -> Any:
        """Some of them, in that order."""
        return Columns({name: self.given[name] for name in names})

    def at_rows(self, rows: Any) -> "Columns":
        """Some rows of each."""
        return Columns({name: values[rows] for name, values in self.given.items()})

    def put(self, value: float, rows: dict) -> "Columns":
        """The columns with a value in some of their rows, by name."""
        given = {name: self.given[name] for name in rows}
        return self | {
            name: np.where(rows[name], values.dtype.type(value), values)
            for name, values in given.items()
        }


@dataclass(frozen=True, eq=False)
class Inputs:
    """Columns on common times, ready for the kernel."""

    columns: Any  # Columns, or a mapping from which they are made
    steps: Any  # float or array: time since the row before, in units
    unit: float  # seconds in one unit of ``steps``
    index: pd.Index
    is_series: bool
    times: Any = field(default=None, repr=False)  # Times, made where they are None

    def __post_init__(self) -> None:
        if not isinstance(self.columns, Columns):
            object.__setattr__(self, "columns", Columns(self.columns))
        times = self.times
        # those of other columns are kept, where they are of the same rows
        of_others = times and times.index is self.index and times.steps is self.steps
        if not of_others:
            times = Times(self.index, self.steps, self.unit)
            object.__setattr__(self, "times", times)

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[name]

    @cached_property
    def cache(self) -> dict:
        """What was found of the columns, by what it is, so that it is found once."""
        return {}

    def mean(self, name: str) -> float:
        """Mean of what there is of a column."""
        if name not in self.cache:
            self.cache[name] = float(np.nanmean(self[name]))
        return self.cache[name]

    @property
    def step(self) -> Any:
        """Usual time between rows; NaN of a single one. [s]"""
        if np.ndim(self.steps) == 0:
            return self.steps * self.unit
        return (
            float(np.median(self.steps[1:])) * self.unit
            if len(self.steps) > 1
            else np.nan
        )

    @property
    def seconds(self) -> np.ndarray:
        """Time of each row since the first. [s]"""
        return self.times.seconds

    def part(self, rows: Any) -> "Inputs":
        """The inputs of a slice of the rows."""
        steps = self.steps if np.ndim(self.steps) == 0 else self.steps[rows]
        return self.by_steps(rows, steps)

    def at_rows(self, rows: np.ndarray) -> "Inputs":
        """The inputs of some rows, each as long after the one before as it was."""
        if np.ndim(self.steps) == 0:
            steps = self.steps * np.diff(rows, prepend=rows[0] - 1)
        else:
            steps = np.diff(np.cumsum(self.steps)[rows], prepend=0.0)
        return self.by_steps(rows, steps)

    def by_steps(self, rows: np.ndarray, steps: float | np.ndarray) -> "Inputs":
        """The inputs of some rows, with the time between them."""
        columns = self.columns.at_rows(rows)
        return Inputs(columns, steps, self.unit, self.index[rows], self.is_series)

    def only(self, names: Sequence) -> Any:
        """The inputs with some of their columns, in that order."""
        return replace(self, columns=self.columns.only(names))

    def having(self, columns: Any) -> "Inputs":
        """The inputs with other values of some columns, or with more of them."""
        return replace(self, columns=self.columns | columns)

    def frame(self) -> pd.DataFrame:
        """The columns as a frame, in double precision."""
        return pd.DataFrame(dict(self.columns), self.index)

    def restore(
        self, values: np.ndarray, name: str | None = None
    ) -> np.ndarray | pd.Series:
        """Give values back in the form the input came in."""
        return pd.Series(values, self.index, name=name) if self.is_series else values

    def resume(self, initial: Any) -> Any:
        """State to carry on from, and the steps counted from its time."""
        if initial is None:
            return None, self.steps
        if isinstance(initial, pd.Series):
            initial = self.past(initial)
            since = self.index[0] - initial.index[-1]
            if not since > pd.Timedelta(0):
                raise ValueError(
                    f"initial is at {initial.index[-1]}, not before the first sample "
                    f"at {self.index[0]}; carry the state from earlier rows"
                )
            steps = np.array(np.broadcast_to(self.steps, len(self.index)), dtype=float)
            steps[0] = since.total_seconds() / self.unit
            return float(as_numbers("initial", initial, initial.index)[-1]), steps
        if np.ndim(self.steps):
            raise ValueError(
                "initial is a number, but the steps are uneven; give the output of "
                "the record before as a Series, which brings its time"
            )
        if not np.isfinite(initial):
            raise ValueError(
                f"initial = {initial} must be a finite number; drop it to start anew"
            )
        return float(initial), self.steps

    def past(self, initial: pd.Series) -> pd.Series:
        """The facts of a Series that goes before, with times that can be compared."""
        initial = initial.dropna()
        if initial.empty:
            raise ValueError("initial holds no value; drop it to start anew")
        times = initial.index
        if not isinstance(self.index, pd.DatetimeIndex):
            raise ValueError(
                "initial is a Series, but values bring no times; give the "
                "state as a number"
            )
        if not isinstance(times, pd.DatetimeIndex):
            raise ValueError(
                f"initial has no DatetimeIndex but a {type(times).__name__}; set one "
                "with pd.to_datetime"
            )
        if (times.tz is None) != (self.index.tz is None):
            raise ValueError(
                f"initial has times in zone {times.tz}, values in {self.index.tz}; "
                "give both a zone or neither"
            )
        datetime_steps(times, "initial")  # refuses what is not sorted
        return initial


@dataclass(frozen=True, eq=False)
class Record:
    """A measured record that has passed its checks."""

    inputs: Inputs
    missing: dict[str, int]  # NaN by column
    impossible: dict[str, int]  # values not used, by column
    clipped: int  # negative irradiance, set to 0
    absent: tuple = ()  # columns that nobody measured, which hold 0
    stated: tuple = ()  # columns whose unit a header or the user states

    @property
    def index(self) -> Any:
        return self.inputs.index

    def __getitem__(self, name: str) -> np.ndarray:
        return self.inputs.columns[name]

    @property
    def days(self) -> np.ndarray:
        """Number of each row's day among the days that are there, from 0."""
        return pd.factorize(self.dates)[0]

    @property
    def dates(self) -> np.ndarray:
        """Calendar day of each row in the record's own zone, from 1970-01-01."""
        return self.inputs.times.dates

    def rows_by_date(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Dates in order, and how many of some rows each has."""
        first, dates = self.inputs.times.runs
        days, place = np.unique(dates, return_inverse=True)
        edges = pairwise([*first.tolist(), len(rows)])
        counts = [np.count_nonzero(rows[start:end]) for start, end in edges]
        return days, np.bincount(place, counts).astype(int)

    def of_dates(self, dates: np.ndarray) -> np.ndarray:
        """Booleans of the rows of some dates."""
        first, days = self.inputs.times.runs
        return np.repeat(np.isin(days, dates), np.diff(first, append=len(self.dates)))

    def count_days(self, rows: np.ndarray) -> int:
        """How many days some rows are of."""
        return int(np.count_nonzero(self.rows_by_date(rows)[1]))

    def only(self, names: Sequence) -> Any:
        """The record with some of its columns."""
        inputs = self.inputs.only(names)
        missing = {n: rows for n, rows in self.missing.items() if n in inputs.columns}
        return replace(self, inputs=inputs, missing=missing)

    def having(self, columns: dict | Columns) -> "Record":
        """The record with other values of some columns, or with more of them."""
        return replace(self, inputs=self.inputs.having(columns))

    def lacking(self, rows: dict) -> "Record":
        """The record with NaN in some rows of its columns, by name."""
        return self.put(np.nan, rows)

    def put(self, value: float, rows: dict) -> "Record":
        """The record with a value in some rows of its columns, by name."""
        columns = self.inputs.columns.put(value, rows)
        return replace(self, inputs=replace(self.inputs, columns=columns))

    def complete_rows(self, names: list) -> np.ndarray:
        """Rows that have all of some columns."""
        key = "rows", *names
        if key not in self.inputs.cache:
            rows = np.ones(len(self.index), dtype=bool)
            for name in names:
                rows &= known_values(name, self[name], self["poa_global"])
            rows.flags.writeable = False  # it is the same for all who ask
            self.inputs.cache[key] = rows
        return self.inputs.cache[key]

    def rows(self, holdout: pd.Series) -> np.ndarray:
        """Boolean array of a user's choice of rows."""
        if not isinstance(holdout, pd.Series) or holdout.dtype != bool:
            raise ValueError("holdout must be a boolean Series, True where held out")
        if not holdout.index.equals(self.index):
            raise ValueError("holdout and the record have different indexes")
        return holdout.to_numpy()


def read(
    columns: dict,
    step: float | None = None,
    times: Any = None,
    purpose: str = "this model",
) -> "Inputs":
    """
    Bring series, arrays and numbers onto common times.

    Parameters
    ----------
    columns : dict
        Name to Series, array or number; at least one is not a number. Their
        values may be NaN, not infinite.
    step : float, optional
        Even time step of arrays. [s]
    times : DatetimeIndex or array, shape (rows,), optional
        Times of arrays: datetimes, or numbers. [s]
    purpose : str
        What needs the columns, for the messages.

    Returns
    -------
    Inputs
        Numbers are columns of one value.

    Raises
    ------
    ValueError
        Naming the column, the first offending time and the remedy.
    """
    series = {k: v for k, v in columns.items() if isinstance(v, pd.Series)}
    lengths = {k: len(v) for k, v in columns.items() if np.ndim(v)}
    if not lengths:
        raise ValueError(
            f"{purpose} needs a series, not single numbers: what a module does now "
            "depends on what it went through before; give Series with a "
            "DatetimeIndex, or arrays with step"
        )
    for name, value in columns.items():
        if np.ndim(value) > 1:
            raise ValueError(f"{name} has {np.ndim(value)} dimensions; give one column")
    if len(set(lengths.values())) > 1:
        raise ValueError(
            f"the lengths differ: {lengths}; give all columns the same rows"
        )
    rows = next(iter(lengths.values()))
    if rows == 0:
        raise ValueError(f"{next(iter(lengths))} is empty; give at least one row")
    index = common_index(series)
    if index is None and times is not None:
        index = as_times(times, rows)
    elif times is not None:
        raise ValueError("a Series brings its own times; drop the argument times")
    if index is None or not isinstance(index, pd.DatetimeIndex):
        index, steps, unit = plain_steps(index, rows, step, purpose, series)
    else:
        if step is not None:
            raise ValueError(
                f"step = {step}, but the times are given already; drop step"
            )
        steps, unit = datetime_steps(index, next(iter(series), "times"))
    checked = {
        name: np.broadcast_to(as_given(name, value, index), rows)
        for name, value in columns.items()
    }
    return Inputs(checked, steps, unit, index, bool(series))


def as_record(
    poa_global: pd.Series | None,
    temp_air: pd.Series | None,
    wind_speed: pd.Series | None,
    temp_module: pd.Series | None,
    **drivers: pd.Series,
) -> Record:
    """
    The columns on their common times, as they are.

    Parameters
    ----------
    poa_global, temp_air, wind_speed, temp_module : Series
        On one DatetimeIndex. [W/m²], [°C], [m/s], [°C] ``wind_speed`` may be None: then
        it is 0, for models that do not depend on it. ``attrs["stated"]`` has names of
        columns whose unit is stated.
    **drivers : Series
        Further columns.

    Returns
    -------
    Record
        Nothing is screened: no value is impossible or clipped.

    Raises
    ------
    ValueError
        If a column is no Series on the common DatetimeIndex, holds no value or an
        infinity, or times do not rise.
    """
    columns = {
        "poa_global": poa_global,
        "temp_air": temp_air,
        "wind_speed": wind_speed,
        "temp_module": temp_module,
        **drivers,
    }
    absent = ("wind_speed",) if wind_speed is None else ()
    measured = {n: column for n, column in columns.items() if n not in absent}
    stated = []
    for name, column in measured.items():
        if not isinstance(column, pd.Series):
            raise ValueError(
                f"{name} is a {type(column).__name__}; a fit needs Series with a "
                "DatetimeIndex, since days are held out"
            )
        if not isinstance(column.index, pd.DatetimeIndex):
            raise ValueError(no_datetimes(name, column.index))
        stated += [name] * (name in column.attrs.get(STATED, ()))
    calm = dict.fromkeys(absent, 0.0)
    inputs = read(columns | calm, purpose="fit_fem")
    missing = {n: int(np.count_nonzero(np.isnan(inputs[n]))) for n in measured}
    for name, rows in missing.items():
        if rows == len(inputs.index):
            raise ValueError(
                f"{name} holds no value from {inputs.index[0]} to "
                f"{inputs.index[-1]}; check the column's name and the logger"
            )
    inputs = Inputs(inputs.columns, inputs.steps, inputs.unit, inputs.index, True)
    return Record(inputs, missing, {}, 0, absent, tuple(stated))


def with_columns(record: Record, columns: dict) -> Record:
    """
    The record with further columns.

    Parameters
    ----------
    record : Record
    columns : dict of Series
        By name, each on the index of the record.

    Returns
    -------
    Record
        Their missing values are counted.
    """
    arrays = {name: column.to_numpy(float) for name, column in columns.items()}
    missing = {name: int(np.isnan(values).sum()) for name, values in arrays.items()}
    missing = {**record.missing, **missing}
    return replace(record, inputs=record.inputs.having(arrays), missing=missing)
