"""Repetitions of one value in a record that is read in blocks."""

from dataclasses import dataclass, field

import numpy as np

from pvlib_fem.quality.limits import Limits
from pvlib_fem.quality.stuck import DRIVERS, STILL, Runs, seen_by
from pvlib_fem.record.clean import spans
from pvlib_fem.relaxation import relax


@dataclass(eq=False)
class Standing:
    """Long repetitions of a column's value so far, and the one that may go on."""

    limits: Limits
    unit: float  # of the times [s]
    found: list = field(default_factory=list)  # value, first and last row and time
    last: tuple | None = None  # the same of the last

    def add(self, values, start, times):
        """Look at the next rows, the first of which is row ``start``."""
        edges = np.flatnonzero(values[1:] != values[:-1]) + 1
        edges = np.concatenate(([0], edges, [len(values)]))
        many = np.flatnonzero(np.diff(edges) > self.limits.still_rows)
        # the first may go on, and the last, whatever their length
        for i in np.union1d(many, [0, len(edges) - 2]):
            first, last = edges[i], edges[i + 1] - 1
            run = values[first], first + start, last + start, times[first], times[last]
            if first == 0 and self.last is not None:
                if run[0] == self.last[0]:
                    run = (*self.last[:2], run[2], self.last[3], run[4])
                else:
                    self.keep(self.last)
            if last == len(values) - 1:
                self.last = run
            else:
                self.keep(run)

    def keep(self, run):
        if run[2] - run[1] < self.limits.still_rows:
            return
        if (run[4] - run[3]) * self.unit > self.limits.still_time:
            self.found.append(run)

    def runs(self):
        """All of them, with the times of their first rows."""
        if self.last is not None:
            self.keep(self.last)
            self.last = None
        return table(self.found, self.unit)


def table(found, unit):
    """Runs of a list of value, first and last row and time, and their times."""
    value, first, last, begin, end = np.array(found, dtype=float).reshape(-1, 5).T
    rows = first.astype(int), last.astype(int)
    begin, end = (np.array([run[at] for run in found], dtype=np.int64) for at in (3, 4))
    return Runs(value, *rows, (end - begin) * unit), begin


#: what each column is seen by, and the margin within its repetitions
SEEN_BY = {
    "temp_module": (("felt", ""), ("temp_air", "")),
    "poa_global": (
        ("over", ""),
        ("warmth", "farthest_clock"),
        ("temp_module", "farthest_clock"),
    ),
    "temp_air": (("poa_global", ""), ("temp_module", "")),
    "wind_speed": (),
}


def frozen(clean, standing, limits):
    """
    Spans of rows in which a sensor of a record in files stands still, by column.

    Parameters
    ----------
    clean : CleanRecord
    standing : dict of (Runs, array)
        Long repetitions of each column, and the times at which they begin.
    limits : Limits
    """
    found, left = {}, [name for name in STILL if len(standing[name][0].first)]
    while left:
        seen = Extents.of(clean, {name: standing[name] for name in left}, limits)
        for name in list(left):
            runs, _ = standing[name]
            kept = STILL[name](runs, seen.taker(name, limits), seen.steps, limits)
            left.remove(name)
            if kept.any():
                found[name] = spans_of(runs, kept)
                # a module that stands still is no witness of what moves it
                clean = clean.lacking({name: found[name]})
                break
    for name in [name for name in DRIVERS if name in standing]:
        runs, _ = standing[name]
        kept = DRIVERS[name](runs, limits)
        if kept.any():
            found[name] = spans_of(runs, kept)
    return found


@dataclass(eq=False)
class Calm:
    """Rows at 0 for longer than a calm lasts, of which gaps take no time."""

    usual: float  # step [s]
    limits: Limits
    found: list = field(default_factory=list)  # rows
    begin: int | None = None  # time of the first of them
    last: int | None = None  # time of the last row that is there
    open: list = field(default_factory=list)  # rows of the one that may go on
    time: float = 0.0  # that it has lasted [s]

    @classmethod
    def of(cls, clean, usual, limits):
        """Spans of such rows of the wind in a record, and when they begin."""
        calm = cls(usual, limits)
        for block in clean.blocks(("wind_speed",)):
            calm.add(block["wind_speed"], block.start, block.times, block.inputs.unit)
        calm.over()
        return spans(np.concatenate(calm.found or [[]])), calm.begin

    def add(self, values, start, times, unit):
        there = np.flatnonzero(np.isfinite(values))
        if not len(there):
            return
        times = times[there]
        first = times[0] if self.last is None else self.last
        steps = np.minimum(np.diff(times, prepend=first) * unit, self.usual)
        self.last, rows = times[-1], there + start
        zero, lasted = values[there] == 0, steps.cumsum()
        edges = np.append(np.flatnonzero(np.diff(zero, prepend=not zero[0])), len(zero))
        long = lasted[edges[1:] - 1] - lasted[edges[:-1]] > self.limits.calm
        # the first may go on from the rows before, the last in those that follow
        for i in np.union1d(np.flatnonzero(long), [0, len(edges) - 2]):
            if i or not zero[0]:
                self.over()
            if not zero[edges[i]]:
                continue
            part = slice(edges[i], edges[i + 1])
            self.time += steps[part][0 if self.open else 1 :].sum()
            self.open.append((rows[part], times[edges[i]]))

    def over(self):
        """Keep the one that has ended, if it has lasted."""
        if self.time > self.limits.calm and self.open:
            self.found += [rows for rows, _ in self.open]
            self.begin = self.open[0][1] if self.begin is None else self.begin
        self.open, self.time = [], 0.0


def spans_of(runs, kept):
    return np.column_stack([runs.first[kept], runs.last[kept] + 1])


@dataclass(eq=False)
class Extents:
    """Least and largest value of other columns in repetitions of some."""

    standing: dict
    limits: Limits
    steps: dict  # smallest change of both temperatures
    bounds: dict = field(default_factory=dict)  # least, largest, and the last value
    before: dict = field(default_factory=dict)
    felt: float | None = None
    since: float = 0.0

    @classmethod
    def of(cls, clean, standing, limits):
        """The extents over a record, from one pass."""
        steps = dict.fromkeys(("temp_air", "temp_module"), np.inf)
        found = cls(standing, limits, steps)
        for name, (runs, _) in standing.items():
            for key in SEEN_BY[name]:
                found.bounds[name, *key] = np.full((3, len(runs.first)), np.nan)
        if found.bounds:
            for block in clean.blocks(tuple(STILL)):
                found.add(block)
        found.steps = {n: s if s < np.inf else 0.0 for n, s in found.steps.items()}
        return found

    def add(self, block):
        columns = dict(block.inputs.columns)
        others = {other for _, other, _ in self.bounds}
        if "felt" in others:
            columns["felt"] = self.as_felt(block)
            for name in self.steps:
                self.resolve(name, columns[name])
        for name in {"over", "warmth"} & others:
            columns[name] = seen_by(name, columns)
        count = block.times
        for name, (runs, begin) in self.standing.items():
            end = runs.last >= block.start
            near = np.flatnonzero(end & (runs.first < block.start + len(block)))
            for i in near:
                for other, margin in SEEN_BY[name]:
                    inner = getattr(self.limits, margin) if margin else 0.0
                    rows = self.rows(block, count, runs, begin, i, inner)
                    merge(self.bounds[name, other, margin], i, columns[other][rows])

    @staticmethod
    def rows(block, count, runs, begin, i, margin):
        """Rows of a block that lie in the i-th repetition, within a margin."""
        first = max(runs.first[i] - block.start, 0)
        last = min(runs.last[i] + 1 - block.start, len(block))
        if margin:
            unit = block.inputs.unit
            seconds = (count[first:last] - begin[i]) * unit
            end = np.searchsorted(seconds, runs.time[i] - margin, "right")
            return slice(first + np.searchsorted(seconds, margin), first + end)
        return slice(first, last)

    def as_felt(self, block):
        """Irradiance as the module feels it, carried on from the blocks before."""
        poa, steps = block["poa_global"], block.inputs.steps.astype(float)
        there = np.flatnonzero(np.isfinite(poa))
        if not len(there):
            self.since += steps.sum()
            return poa
        steps[0] += self.since
        self.since = steps[there[-1] + 1 :].sum()
        memory = self.limits.felt_memory / block.inputs.unit
        felt = relax(poa, steps, memory, self.felt)
        self.felt = felt[there[-1]]
        return felt

    def resolve(self, name, values):
        """Smallest change of a column so far."""
        change = np.abs(np.diff(values, prepend=self.before.get(name, np.nan)))
        self.before[name] = values[-1]
        change = change[change > 1e-9]
        if len(change):
            self.steps[name] = min(self.steps[name], float(change.min()))

    def taker(self, name, limits):
        """What tells the extent of another column in repetitions of one."""

        def extent(other, margin=0.0):
            key = name, other, "farthest_clock" if margin else ""
            low, high, _ = self.bounds[key]
            return np.nan_to_num(high - low)

        return extent


def merge(bounds, i, values):
    """
    Take further values into the least and largest of the i-th repetition.

    Its last row is left out, as it is in memory: it waits until another comes.
    """
    if not len(values):
        return
    before = np.append(bounds[:, i], values[:-1])
    bounds[:, i] = np.fmin.reduce(before), np.fmax.reduce(before), values[-1]


def never_moving(value, rows, first, last, unit):
    """The one repetition of a column that never moves."""
    return table([(value, 0, rows - 1, first, last)], unit)
