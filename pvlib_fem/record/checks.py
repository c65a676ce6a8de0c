"""Check what comes in, once and in one place: times, columns, units, ranges."""

import numbers
import re
from dataclasses import dataclass, field, replace
from decimal import Decimal
from functools import cached_property

import numpy as np
import pandas as pd

from pvlib_fem.spelling import Spelled, refusal

DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+")
SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
#: months of autumn on either side of the equator, and hours, in which it ends
SUMMER_TIME_ENDS = (3, 4, 9, 10, 11), (23, 0, 1, 2, 3)
LOCALIZED = Spelled(
    "data.tz_localize('Europe/Berlin', ambiguous='infer') (--tz Europe/Berlin)",
    "--tz Europe/Berlin",
)
KEEP_ONE = Spelled(
    "keep one, for example with data[~data.index.duplicated()]",
    "give --drop-doubled to keep the first",
)


@dataclass(frozen=True, eq=False)
class Times:
    """What follows from the times of some rows alone, found once for all columns."""

    index: pd.Index
    steps: np.ndarray | float
    unit: float

    @cached_property
    def seconds(self):
        """Time of each row since the first. [s]"""
        steps = np.array(np.broadcast_to(self.steps, len(self.index)), dtype=float)
        steps[0] = 0.0
        return np.cumsum(steps) * self.unit

    @cached_property
    def dates(self):
        """Calendar day of each row in the record's own zone, from 1970-01-01."""
        return dates_of(self.index)

    @cached_property
    def runs(self):
        """First row of each run of rows of one date, and the date."""
        first = np.flatnonzero(np.diff(self.dates, prepend=self.dates[:1] - 1))
        return first, self.dates[first]


@dataclass(frozen=True, eq=False)
class Inputs:
    """Columns on common times, ready for the kernel."""

    columns: dict[str, np.ndarray]
    steps: np.ndarray | float  # time since the row before, in units
    unit: float  # seconds in one unit of ``steps``
    index: pd.Index
    is_series: bool
    times: Times | None = field(default=None, repr=False)

    def __post_init__(self):
        times = self.times
        # those of other columns are kept, where they are of the same rows
        of_others = times and times.index is self.index and times.steps is self.steps
        if not of_others:
            times = Times(self.index, self.steps, self.unit)
            object.__setattr__(self, "times", times)

    def __getitem__(self, name):
        return self.columns[name]

    @property
    def step(self):
        """Usual time between rows; NaN of a single one. [s]"""
        if np.ndim(self.steps) == 0:
            return self.steps * self.unit
        return (
            float(np.median(self.steps[1:])) * self.unit
            if len(self.steps) > 1
            else np.nan
        )

    @property
    def seconds(self):
        """Time of each row since the first. [s]"""
        return self.times.seconds

    def part(self, rows):
        """The inputs of a slice of the rows."""
        steps = self.steps if np.ndim(self.steps) == 0 else self.steps[rows]
        columns = {name: values[rows] for name, values in self.columns.items()}
        return Inputs(columns, steps, self.unit, self.index[rows], self.is_series)

    def restore(self, values, name=None):
        """Give values back in the form the input came in."""
        return pd.Series(values, self.index, name=name) if self.is_series else values

    def resume(self, initial):
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

    def past(self, initial):
        """What is known of a Series that goes before, in times that can be told."""
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

    @property
    def index(self):
        return self.inputs.index

    def __getitem__(self, name):
        return self.inputs.columns[name]

    @property
    def days(self):
        """Number of each row's day among the days that are there, from 0."""
        return pd.factorize(self.dates)[0]

    @property
    def dates(self):
        """Calendar day of each row in the record's own zone, from 1970-01-01."""
        return self.inputs.times.dates

    def rows_by_date(self, rows):
        """Dates in order, and how many of some rows each has."""
        first, dates = self.inputs.times.runs
        days, place = np.unique(dates, return_inverse=True)
        counts = np.add.reduceat(rows, first, dtype=int)
        return days, np.bincount(place, counts).astype(int)

    def of_dates(self, dates):
        """Booleans of the rows of some dates."""
        first, days = self.inputs.times.runs
        return np.repeat(np.isin(days, dates), np.diff(first, append=len(self.dates)))

    def count_days(self, rows):
        """How many days some rows are of."""
        return int(np.count_nonzero(self.rows_by_date(rows)[1]))

    def only(self, names):
        """The same record with some of its columns."""
        inputs = {name: self.inputs.columns[name] for name in names}
        missing = {name: n for name, n in self.missing.items() if name in inputs}
        inputs = replace(self.inputs, columns=inputs)
        return replace(self, inputs=inputs, missing=missing)

    def having(self, columns):
        """The same record with other values of some columns, or with more of them."""
        columns = {**self.inputs.columns, **columns}
        return replace(self, inputs=replace(self.inputs, columns=columns))

    def lacking(self, rows):
        """The same record with NaN in some rows of its columns, by name."""
        return self.having({n: np.where(at, np.nan, self[n]) for n, at in rows.items()})

    def known(self, names):
        """Rows that have all of some columns."""
        rows = np.ones(len(self.index), dtype=bool)
        for name in names:
            rows &= np.isfinite(self[name])
        return rows

    def rows(self, holdout):
        """Boolean array of a user's choice of rows."""
        if not isinstance(holdout, pd.Series) or holdout.dtype != bool:
            raise ValueError("holdout must be a boolean Series, True where held out")
        if not holdout.index.equals(self.index):
            raise ValueError("holdout and the record have different indexes")
        return holdout.to_numpy()


def read(columns, step=None, times=None, purpose="this model"):
    """
    Bring series, arrays and numbers onto common times.

    Parameters
    ----------
    columns : dict
        Name to Series, array or number; at least one is not a number. Their
        values may be NaN, not infinite.
    step : float, optional
        Even time step of arrays. [s]
    times : DatetimeIndex or array, optional
        Times of arrays: datetimes, or numbers. [s]
    purpose : str
        Who asks, for the messages.

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
        name: np.broadcast_to(as_numbers(name, value, index), rows)
        for name, value in columns.items()
    }
    return Inputs(checked, steps, unit, index, bool(series))


def common_index(series):
    """The one index of several series, or None without any."""
    if not series:
        return None
    (first, one), *others = series.items()
    for name, other in others:
        if other.index.equals(one.index):
            continue
        zones = [getattr(s.index, "tz", None) for s in (one, other)]
        if (zones[0] is None) != (zones[1] is None):
            raise ValueError(
                f"the times of {first} have zone {zones[0]}, those of {name} "
                f"{zones[1]}; give both a zone (tz_localize) or neither"
            )
        if zones[0] != zones[1] and len(other) == len(one):
            raise ValueError(
                f"the times of {first} are in {zones[0]}, those of {name} in "
                f"{zones[1]}; bring them to one zone, for example with "
                f"tz_convert({str(zones[0])!r})"
            )
        raise ValueError(
            f"{name} and {first} have different indexes: they part at "
            f"{first_difference(one.index, other.index)}; align them first, for "
            "example as columns of one DataFrame"
        )
    return one.index


def first_difference(one, other):
    shared = min(len(one), len(other))
    unequal = np.flatnonzero(np.asarray(one[:shared] != other[:shared]))
    at = unequal[0] if len(unequal) else shared - 1
    return one[at]


def as_times(times, rows):
    times = pd.Index(times)
    if len(times) != rows:
        raise ValueError(f"times has {len(times)} entries for {rows} samples")
    return times


def plain_steps(index, rows, step, purpose, series):
    """Steps of rows without datetimes: from ``step``, or numbers in seconds."""
    if step is not None:
        if not (isinstance(step, numbers.Real) and 0 < step < np.inf):
            raise ValueError(f"step = {step} must be a positive number of seconds")
        return (pd.RangeIndex(rows) if index is None else index), float(step), 1.0
    if index is None:
        raise ValueError(
            f"{purpose} needs the time step of arrays: give step in seconds, or "
            "Series with a DatetimeIndex"
        )
    if series:
        words = no_datetimes(next(iter(series)), index)
        raise ValueError(f"{words}, or give step in seconds")
    if isinstance(index, pd.TimedeltaIndex):
        index = index.total_seconds()
    seconds = as_numbers("times", index.to_numpy(), index)
    if np.isnan(seconds).any():
        at = int(np.argmax(np.isnan(seconds)))
        raise ValueError(f"times has no number (NaN) at row {at}; drop such rows")
    steps = np.diff(seconds, prepend=seconds[0])
    check_order(steps, index, "times")
    return index, steps, 1.0


def no_datetimes(name, index):
    """What to do about a Series whose index holds no times."""
    remedy = "set one with pd.to_datetime"
    if isinstance(index, pd.TimedeltaIndex):
        remedy = "add the time of its start, as pd.Timestamp('2023-06-01') + index"
    return f"{name} has no DatetimeIndex but a {type(index).__name__}; {remedy}"


def datetime_steps(index, name):
    """Steps of a DatetimeIndex, as whole counts of its own resolution."""
    if index.hasnans:
        raise ValueError(
            f"{name} has no time (NaT) at row {int(np.argmax(index.isna()))}; drop "
            "such rows"
        )
    unit = SECONDS[index.unit]
    if isinstance(index.freq, pd.offsets.Tick) and index.freq.n > 0:
        return pd.Timedelta(index.freq) / pd.Timedelta(seconds=1) / unit, unit
    count = instants(index).view("i8")
    steps = np.empty(len(count), dtype="i8")
    steps[0] = 0
    np.subtract(count[1:], count[:-1], out=steps[1:])
    check_order(steps, index, name)
    if len(steps) > 1 and steps[1:].min() == steps[1:].max():
        return float(steps[1]), unit
    return steps, unit


def instants(index):
    """The times as numpy has them, in UTC where they have a zone."""
    return (index if index.tz is None else index.tz_convert(None)).to_numpy()


def dates_of(index):
    """Calendar day of each time in its own zone, from 1970-01-01."""
    offset = None if index.tz is None else index.tz.utcoffset(None)
    if offset is None:  # no zone, or one of several offsets
        local = index.tz_localize(None).to_numpy()
    else:
        local = instants(index) + np.timedelta64(offset)
    return local.astype("datetime64[D]").astype(np.int32)


def usual_step(index):
    """Median time between some times; NaN of fewer than two. [s]"""
    steps = np.diff(instants(index)) / np.timedelta64(1, "s")
    return float(np.median(steps)) if len(steps) else np.nan


def check_order(steps, index, name):
    if len(steps) < 2 or steps[1:].min() > 0:
        return
    at = 1 + int(np.argmax(steps[1:] <= 0))
    if ends_summer_time(steps, index, at):
        raise refusal(
            f"{name} goes back from {index[at - 1]} to {index[at]} (row {at}), as the "
            "clock does at the end of summer time: leave the rows in their order, "
            "since sorting mixes the hour that comes twice, and give the times their "
            "zone, for example with ",
            LOCALIZED,
        )
    if steps[at] == 0:
        twice = f"{name} has the time {index[at]} twice (row {at}); "
        raise refusal(twice, KEEP_ONE)
    raise refusal(
        f"{name} is not sorted: {index[at]} (row {at}) comes after {index[at - 1]}; ",
        Spelled("use data.sort_index()", "give --sort"),
    )


def ends_summer_time(steps, index, at):
    """Whether times without a zone go back by an hour, but for a step, in autumn."""
    if not isinstance(index, pd.DatetimeIndex) or index.tz is not None:
        return False
    usual = np.median(steps[1:]) * SECONDS[index.unit]
    back = usual - (index[at] - index[at - 1]).total_seconds()
    months, hours = SUMMER_TIME_ENDS
    autumn = index[at].month in months and index[at].hour in hours
    return autumn and abs(back - 3600.0) < usual / 2


def as_numbers(name, value, index):
    """Floats of one column; text and infinities are refused by name and time."""
    if np.ma.isMaskedArray(value):
        value = value.astype(float).filled(np.nan)
    values = value.to_numpy() if isinstance(value, pd.Series) else np.asarray(value)
    if values.dtype.kind not in "fiub":
        for at, entry in enumerate(np.atleast_1d(values)):
            if not (isinstance(entry, (numbers.Real, Decimal)) or pd.isna(entry)):
                raise not_a_number(name, np.atleast_1d(values), at, index)
        values = np.where(pd.isna(values), np.nan, values)
    values = values.astype(float, copy=False)
    # an infinity or NaN in the column shows in its sum, which is one fast pass
    if not np.isfinite(values.sum()):
        infinite = np.isinf(values)
        if infinite.any():
            raise ValueError(
                f"{name} is infinite at {at_time(index, int(np.argmax(infinite)))}; "
                "replace it with NaN"
            )
    return values


def not_a_number(name, values, row, index):
    """The error of text in a column, of which one bad entry makes all of it text."""
    words = [entry if isinstance(entry, str) else "0" for entry in values]
    numeric = pd.to_numeric(pd.Series(words, dtype=object), errors="coerce")
    bad = np.flatnonzero(numeric.isna())
    row = int(bad[0]) if len(bad) else row
    entry, what = values[row], "not a number"
    remedy = "pd.to_numeric(column, errors='coerce')"
    option = "give --missing TEXT for a text that stands for a missing value"
    if not len(bad):
        what, remedy = "a number as text", "pd.to_numeric(column)"
        option = "write it as a number"
    elif isinstance(entry, str) and DECIMAL_COMMA.fullmatch(entry.strip()):
        what, remedy = "a number with a decimal comma", "column.str.replace(',', '.')"
        remedy += " before pd.to_numeric, or read the file with decimal=','"
        option = "give --decimal ,"
    return refusal(
        f"{name} holds {entry!r} at {at_time(index, row)}, which is {what}; ",
        Spelled(f"clean the column, for example with {remedy}", option),
    )


def at_time(index, row):
    return f"{index[row]} (row {row})" if len(index) > row else f"row {row}"


def as_record(poa_global, temp_air, wind_speed, temp_module, **drivers):
    """The columns on their common times, as they are."""
    columns = {
        "poa_global": poa_global,
        "temp_air": temp_air,
        "wind_speed": wind_speed,
        "temp_module": temp_module,
        **drivers,
    }
    for name, column in columns.items():
        if not isinstance(column, pd.Series):
            raise ValueError(
                f"{name} is a {type(column).__name__}; a fit needs Series with a "
                "DatetimeIndex, since days are held out"
            )
        if not isinstance(column.index, pd.DatetimeIndex):
            raise ValueError(no_datetimes(name, column.index))
    inputs = read(columns, purpose="fit_fem")
    for name in columns:
        if np.isnan(inputs[name]).all():
            raise ValueError(
                f"{name} holds no value from {inputs.index[0]} to "
                f"{inputs.index[-1]}; check the column's name and the logger"
            )
    missing = {n: int(np.count_nonzero(np.isnan(inputs[n]))) for n in columns}
    inputs = Inputs(inputs.columns, inputs.steps, inputs.unit, inputs.index, True)
    return Record(inputs, missing, {}, 0)


def with_columns(record, columns):
    """The record with further columns, which stand on its index."""
    arrays = {name: column.to_numpy(float) for name, column in columns.items()}
    missing = {name: int(np.isnan(values).sum()) for name, values in arrays.items()}
    inputs = replace(record.inputs, columns={**record.inputs.columns, **arrays})
    return replace(record, inputs=inputs, missing={**record.missing, **missing})
