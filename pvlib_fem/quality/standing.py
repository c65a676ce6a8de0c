"""Repetitions of one value in a record that is read in blocks."""

from dataclasses import dataclass, field

import numpy as np

from pvlib_fem.quality.limits import POSSIBLE, Limits
from pvlib_fem.quality.stuck import DRIVERS, STILL, seen_by, still_driver
from pvlib_fem.relaxation import relax

#: what each column is seen by, and the margin within its repetitions
SEEN_BY = {
    "temp_module": (("felt", ""), ("temp_air", "")),
    "poa_global": (
        ("over", ""),
        ("warmth", "farthest_clock"),
        ("temp_module", "farthest_clock"),
    ),
    "temp_air": (("temp_module", ""),),
}


def frozen(clean, standing, rests, limits):
    """
    Spans of rows in which a sensor of a record in files stands still, by column.

    Parameters
    ----------
    clean : CleanRecord
    standing : dict of Runs
        Long repetitions of each column.
    rests : dict
        Value at which each sensor rests.
    limits : Limits
    """
    found, left = {}, [name for name in STILL if len(standing[name].first)]
    while left:
        seen = Extents.of(clean, {name: standing[name] for name in left}, limits)
        for name in list(left):
            runs = standing[name]
            kept = STILL[name](runs, seen.taker(name, limits), seen.steps, limits)
            left.remove(name)
            if kept.any():
                found[name] = spans_of(runs, kept)
                # a module that stands still is no witness of what moves it
                clean = clean.lacking({name: found[name]})
                break
    for name in [name for name in DRIVERS if name in standing]:
        runs = standing[name]
        kept = still_driver(name, runs, rests[name], limits)
        if kept.any():
            found[name] = spans_of(runs, kept)
    return found


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
        for name, runs in standing.items():
            for key in SEEN_BY[name]:
                found.bounds[name, *key] = np.full((3, len(runs.first)), np.nan)
        if found.bounds:
            for block in clean.blocks(tuple(POSSIBLE)):
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
        for name, runs in self.standing.items():
            end = runs.last >= block.start
            near = np.flatnonzero(end & (runs.first < block.start + len(block)))
            for i in near:
                for other, margin in SEEN_BY[name]:
                    inner = getattr(self.limits, margin) if margin else 0.0
                    rows = self.rows(block, count, runs, i, inner)
                    merge(self.bounds[name, other, margin], i, columns[other][rows])

    @staticmethod
    def rows(block, count, runs, i, margin):
        """Rows of a block that lie in the i-th repetition, within a margin."""
        first = max(runs.first[i] - block.start, 0)
        last = min(runs.last[i] + 1 - block.start, len(block))
        if margin:
            unit = block.inputs.unit
            seconds = (count[first:last] - runs.begin[i]) * unit
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
        memory = self.limits.still_time / 5 / block.inputs.unit
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
