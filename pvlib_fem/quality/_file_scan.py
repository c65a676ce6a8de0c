"""What one pass over a record in files shows of its times and columns."""

from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pvlib_fem._record.checks import datetime_steps
from pvlib_fem._record.clean import NONE, CleanRecord, rows_in_spans
from pvlib_fem._record.inputs import Inputs
from pvlib_fem._record.parquet import Block, ParquetRecord
from pvlib_fem._record.ranges import NO_CODE, as_codes, possible_range
from pvlib_fem._statistics.clusters import date_starts
from pvlib_fem.quality._limits import DRIVERS, FASTEST, POSSIBLE, Limits
from pvlib_fem.quality._outliers import (
    is_switch,
    jumps,
    lone_zeros,
    mean_spacing,
    returns,
)
from pvlib_fem.quality._repetitions import Repetitions, whole_run
from pvlib_fem.quality._stray_times import stray_side

#: columns of which single values are compared with those before and after
RETURNING = (*FASTEST, "poa_global")
SOME = 1 << 20  # rows from which the usual values of a column are taken


@dataclass(eq=False)
class Column:
    """One column of a record so far."""

    name: str
    limits: Limits
    unit: float  # of the times [s]
    missing: int = 0
    known: int = 0  # values that stand for one
    low: float = np.inf  # of those that can be
    high: float = -np.inf
    least: float = np.inf  # of those that stand for one, possible or not
    size: float = 0.0  # largest of those that stand for one, without its sign
    odd: dict = field(default_factory=dict)  # kind to parts of row, time and value
    zeros: list = field(default_factory=list)  # parts of what lone_zeros has
    tail: tuple = ()  # the last values that are there, with their rows and times
    repetitions: Repetitions | None = None

    def __post_init__(self) -> None:
        if self.name in (*POSSIBLE, *DRIVERS):
            self.repetitions = Repetitions(self.name, self.limits, self.unit)

    def add(self, values: np.ndarray, start: int, times: np.ndarray) -> np.ndarray:
        """Look at the next rows; what stands for a value of them comes back."""
        low, high = np.fmin.reduce(values), np.fmax.reduce(values)
        self.missing += (lacking := int(np.isnan(values).sum()))
        bounds = possible_range(self.name)
        least, most = bounds[:2] if bounds else NO_CODE
        held = possible_ones = values
        if low < least or high > most:
            rows = np.flatnonzero((values < least) | (values > most))
            code = as_codes(values[rows])[0]
            self.note("fill value", rows[code], values, start, times)
            if bounds:
                held = with_gaps(values, rows[code])
                lacking += int(code.sum())
                self.note("out of range", rows[~code], values, start, times)
                possible_ones = with_gaps(values, rows)
            low, high = np.fmin.reduce(possible_ones), np.fmax.reduce(possible_ones)
        self.known += len(values) - lacking
        self.low, self.high = np.fmin(self.low, low), np.fmax(self.high, high)
        least = np.fmin.reduce(held)
        self.least = np.fmin(self.least, least)
        largest = max(np.fmax.reduce(held), -least)
        self.size = np.fmax(self.size, largest)
        if self.name in RETURNING:
            self.accidents(possible_ones, start, times)
        if self.repetitions is not None:
            clip = self.name == "poa_global" and low < 0
            still = np.maximum(possible_ones, 0.0) if clip else possible_ones
            self.repetitions.add(still, start, times)
        return held

    def note(
        self,
        kind: str,
        rows: np.ndarray,
        values: np.ndarray,
        start: int,
        times: np.ndarray,
    ) -> None:
        if len(rows):
            part = rows + start, times[rows], values[rows]
            self.odd.setdefault(kind, []).append(part)

    def rows_of(self, kind: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rows, times and values of one kind of fault."""
        parts = self.odd.get(kind, [])
        if not parts:
            return np.empty(0, int), np.empty(0, int), np.empty(0)
        rows, times, values = map(np.concatenate, zip(*parts))
        rows, first = np.unique(rows.astype(int), return_index=True)
        return rows, times[first], values[first]

    def accidents(self, values: np.ndarray, start: int, times: np.ndarray) -> None:
        """Values that jump and return, some perhaps in the blocks before."""
        rows = np.arange(start, start + len(values))
        new = values, rows, times
        if np.isnan(values.sum()):
            there = np.flatnonzero(np.isfinite(values))
            new = values[there], rows[there], times[there]
        if not len(new[0]):
            return
        least, size = self.limits.min_spike, self.limits.max_accident_rows + 1
        before = [part[-1:] for part in self.tail] or [new[0][:1]]
        steep = self.name in FASTEST
        steep = steep and np.abs(np.diff(new[0], prepend=before[0])).max() > least
        zero = any((part[0] == 0).any() for part in (new, self.tail) if part)
        both = new
        if self.tail and (steep or zero or len(new[0]) < size):
            both = [np.concatenate(parts) for parts in zip(self.tail, new)]
        if steep:
            x, rows, count = both
            seconds = (count - count[0]) * self.unit
            spiked = jumps(self.name, x, seconds, self.limits)
            if spiked.any():
                part = rows[spiked], count[spiked], x[spiked]
                self.odd.setdefault("spike", []).append(part)
        if zero:
            self.add_zeros(*both)
        self.tail = tuple(part[-self.limits.max_accident_rows - 1 :] for part in both)

    def add_zeros(self, x: np.ndarray, rows: np.ndarray, count: np.ndarray) -> None:
        """Zeros that the values around do not lead to, a part for each row."""
        first, number, depth = lone_zeros(self.name, x, self.limits)
        took = (count[first + number] - count[first - 1]) * self.unit
        for i in range(self.limits.max_accident_rows if len(first) else 0):
            more = number > i
            at = first[more] + i
            part = rows[at], count[at], number[more], depth[more], took[more]
            self.zeros.append(part)

    def zeros_within(self, step: float) -> tuple:
        """
        Lone zeros of usual steps: rows, times, zeros of the stretch and their depth.

        At most one row is missing around them, and no evening or morning is.
        """
        if not self.zeros:
            return tuple(np.empty(0, kind) for kind in (int, int, int, float))
        rows, times, number, depth, took = map(np.concatenate, zip(*self.zeros))
        rows, one = np.unique(rows, return_index=True)
        near = took[one] <= self.longest_return(number[one], step)
        return rows[near], *(part[one][near] for part in (times, number, depth))

    def longest_return(self, rows: Any, step: float) -> Any:
        """Time between the values around a stretch of rows, one of them missing. [s]"""
        return np.minimum((rows + 2) * step, self.limits.stale_air_window)

    def improbable(
        self, zeros: tuple, clean: CleanRecord, sample: np.ndarray, step: float
    ) -> np.ndarray:
        """
        Lone zeros of a temperature that hardly were measured, as booleans.

        ``zeros`` are their numbers and depths, from :meth:`zeros_within`.
        A temperature has no favourite near 0. So readings other than 0 to which it
        jumped and returned tell how often it did so to 0 itself: they lie up to half
        the depth of a zero from 0, and half as deep as it. There are as many of them
        for each zero as readings fit in between, ``depth / spacing``; one more than
        were seen is expected. Of zeros of half to twice the depth
        ``max_accident_share`` may have been measured, and of ``max_accident_rows``
        none. At least ``min_known_values`` readings have to fit in between.
        """
        number, depth = zeros
        limits, result = self.limits, np.zeros(len(number), dtype=bool)
        least = mean_spacing(sample)
        for rows in np.unique(number):
            these = np.flatnonzero(number == rows)
            these = these[np.argsort(depth[these])]
            far = depth[these]
            others = np.zeros(len(far) + 1)
            for x, count in self.stretches(clean, rows):
                nearest, deep = returns(x, rows)
                took = (count[rows + 1 :] - count[: -rows - 1]) * self.unit
                some = (nearest <= deep) & (took <= self.longest_return(rows, step))
                # depths from twice its distance from 0 to twice its own depth
                begin = np.searchsorted(far, 2.0 * nearest[some], "left")
                end = np.searchsorted(far, 2.0 * deep[some], "right")
                others += np.bincount(begin, minlength=len(far) + 1)
                others -= np.bincount(end, minlength=len(far) + 1)
            others = np.cumsum(others)[:-1]
            seen = np.searchsorted(far, 2.0 * far, "right")
            seen = seen - np.searchsorted(far, far / 2.0, "left")
            seen = seen / rows
            expected = (others + 1.0) * least / far
            sure = (others == 0) | (seen > limits.max_accident_rows)
            sure &= far >= limits.min_known_values * least
            sure &= expected <= limits.max_accident_share * seen
            result[these] = sure
        return result

    def stretches(self, clean: CleanRecord, rows: int) -> Iterator:
        """Values that are there and their times, with those that windows go on from."""
        tail: tuple = ()
        for block in clean.blocks((self.name,)):
            there = np.isfinite(block[self.name])
            both = new = block[self.name][there], block.times[there]
            if tail:
                both = tuple(np.concatenate(parts) for parts in zip(tail, new))
            if len(both[0]) > rows + 1:
                yield both
            tail = tuple(part[-rows - 1 :] for part in both)

    @property
    def never_moves(self) -> bool:
        """Whether it has one value only, whatever is missing."""
        if self.name == "poa_global":
            return max(self.low, 0.0) == max(self.high, 0.0)
        return self.low == self.high

    def beyond(
        self, clean: CleanRecord, sample: np.ndarray, factor: float, fewest: int
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """
        Rows of one or two values that are ``factor`` times as large as all else.

        Only where the sample leaves it open, another pass over the record decides.
        """
        none = np.empty(0, int), np.empty(0, int), np.empty(0)
        limits, sizes = self.limits, np.abs(sample[np.isfinite(sample)])
        near = sizes * factor >= self.size
        # what the sample has of them twice too often is no share that is in doubt
        if not self.size or near.mean() > 2.0 * limits.max_accident_share:
            return none
        if is_switch(sizes[~near], limits):
            return none
        parts, rest = [], 0.0
        for block in clean.blocks((self.name,)):
            size = np.abs(block[self.name])
            rows = np.flatnonzero(size * factor >= self.size)
            parts.append(
                (rows + block.start, block.times[rows], block[self.name][rows])
            )
            size[rows] = np.nan
            rest = np.fmax(rest, np.fmax.reduce(size))
        rows, times, values = map(np.concatenate, zip(*parts))
        if len(rows) > limits.max_accident_share * self.known:
            return none
        codes, counts = np.unique(values, return_counts=True)
        far = (np.abs(values) >= factor * rest).all()
        if not far or len(codes) > 2 or (counts < fewest).any():
            return none
        return rows, times, values


def with_gaps(values: np.ndarray, rows: np.ndarray) -> np.ndarray:
    values = np.array(values)
    values[rows] = np.nan
    return values


@dataclass(eq=False)
class Look:
    """A record so far: its times, its columns, and some of its rows."""

    columns: dict
    clean: CleanRecord  # of which it is
    every: int  # of the rows one is in the sample
    unit: float
    rows: int = 0
    ends: tuple = ()  # first and last time
    steps: Counter = field(default_factory=Counter)
    gaps: list = field(default_factory=list)  # row, time before and after
    sample: list = field(default_factory=list)
    taken: tuple | None = None  # the record of which they are one, and they
    days: set = field(default_factory=set)

    @classmethod
    def from_record(
        cls, clean: CleanRecord, limits: Limits, known: "Look | None" = None
    ) -> Any:
        """
        What a pass over a record shows.

        A column that the record of a ``known`` look has as well is not read again.
        """
        look, seen = None, {} if known is None else known.shared_with(clean)
        for block in clean.blocks():
            if look is None:
                unit = block.inputs.unit
                columns = {n: Column(n, limits, unit) for n in clean.names}
                every = max(1, -(-len(clean) // SOME))
                look = cls({**columns, **seen}, clean, every, unit)
            look.add(block, limits, seen)
        return look

    def shared_with(self, clean: CleanRecord) -> dict:
        """Columns that another record has as well, without a value for none."""
        return {
            name: one
            for name, one in self.columns.items()
            if name in clean.names
            and "fill value" not in one.odd
            and clean.shares(name, self.clean)
        }

    def add(self, block: Block, limits: Limits, seen: Collection = ()) -> None:
        times, steps = block.times, block.inputs.steps
        self.ends = (*self.ends[:1], times[-1]) if self.ends else (times[0], times[-1])
        long = np.flatnonzero(steps * self.unit > limits.min_stray_gap)
        self.gaps += [(block.start + i, times[i] - steps[i], times[i]) for i in long]
        first = int(block.start == 0)
        count_steps(self.steps, steps[first:])
        first_rows, _ = date_starts(block.dates)
        self.days.update(block.dates[first_rows].tolist())
        some = slice(-block.start % self.every, None, self.every)
        kept = {}
        for name, column in self.columns.items():
            values = block[name]
            if name not in seen:
                values = column.add(values, block.start, times)
            kept[name] = values[some].copy()
        self.sample.append((times[some], kept))
        self.rows += len(block)

    @property
    def step(self) -> float:
        """Median step. [s]"""
        return round(median(self.steps) * self.unit, 9)  # in µs 240 s are 3e-14 more

    def refuse_gaps(self, limits: Limits, source: ParquetRecord) -> None:
        """Refuse rows that are years from all others."""
        for row, *ends in self.gaps:
            start, before, after = map(source.time_at, (self.ends[0], *ends))
            words = stray_side(row, self.rows, start, before, after, limits)
            if words:
                raise ValueError(words)

    def sampled(self, clean: CleanRecord) -> Inputs:
        """Every so many rows of a record, as they are screened so far."""
        if self.taken is None:
            times, kept = zip(*self.sample)
            index = clean.source.index(np.concatenate(times))
            columns = {n: np.concatenate([part[n] for part in kept]) for n in kept[0]}
            how = *datetime_steps(index, "the time"), index, True
            self.sample, self.taken = [], (None, Inputs(columns, *how))
        before, inputs = self.taken
        if before is not clean:
            rows, columns = np.arange(len(inputs.index)) * self.every, {}
            for name in self.columns:
                holes = clean.holes_of(name)
                if holes is not (NONE if before is None else before.holes_of(name)):
                    lost = rows_in_spans(holes, rows)
                    columns[name] = np.where(lost, np.nan, inputs[name])
            if clean.clip and (inputs["poa_global"] < 0).any():
                poa = columns.get("poa_global", inputs["poa_global"])
                columns["poa_global"] = np.maximum(poa, 0.0)
            self.taken = clean, inputs.having(columns) if columns else inputs
        return self.taken[1]

    def forget(self) -> None:
        """Let go of those rows, which what follows would keep."""
        self.sample, self.taken = [], None

    def repetitions(self, rests: dict) -> dict:
        """Long repetitions of each column, by where its sensor rests."""
        runs = {}
        for name, column in self.columns.items():
            if column.repetitions is None:
                continue
            if not column.never_moves:
                runs[name] = column.repetitions.runs(rests[name])
            elif name in POSSIBLE:  # another may be a number that stands for all
                runs[name] = whole_run(*[column.low, self.rows, *self.ends, self.unit])
        return runs


def count_steps(counts: dict, steps: np.ndarray) -> None:
    """
    Add how often each of some steps is there.

    Parameters
    ----------
    counts : collections.Counter
        Step to number of rows; changed in place.
    steps : numpy.ndarray, shape (rows,)
        Time of each row since the one before, as counts of the index's unit.
    """
    if not len(steps):
        return
    if steps.min() == steps.max():
        counts[int(steps[0])] += len(steps)
        return
    for step, number in zip(*np.unique(steps, return_counts=True)):
        counts[int(step)] += int(number)


def median(counts: dict) -> float:
    """
    Median of values by how often they are there.

    Parameters
    ----------
    counts : dict
        Value to number of rows.

    Returns
    -------
    float
        In the unit of the values; NaN without any.
    """
    if not counts:
        return np.nan
    values = np.array(sorted(counts))
    number = np.cumsum([counts[value] for value in values.tolist()])
    middle = np.searchsorted(number, [(number[-1] - 1) // 2, number[-1] // 2], "right")
    return float(values[middle].mean())
