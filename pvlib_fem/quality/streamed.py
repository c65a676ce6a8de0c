"""The screening of a record that is read in blocks: the same rows as in memory."""

from collections import Counter, namedtuple
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from pvlib_fem.quality.limits import POSSIBLE, Limits, possible
from pvlib_fem.quality.look import Look
from pvlib_fem.quality.outliers import apart, at_end, is_light, range_ends, slots
from pvlib_fem.quality.screen import KINDS, empty_error, refuse_share, sentence
from pvlib_fem.quality.standing import frozen
from pvlib_fem.quality.stuck import (
    becalmed,
    frozen_error,
    may_rest,
    rest_of,
    standing_line,
)
from pvlib_fem.quality.units import doubtful, oddities, refuse_doubtful, refuse_units
from pvlib_fem.quality.values import never_moves
from pvlib_fem.record.clean import CleanRecord, size, spans, united
from pvlib_fem.record.columns import COLUMNS, GEOMETRY

PARTS = 1000  # of a day, more than there are

#: what was found of one kind in one column, as Faults.counts has it
Found = namedtuple("Found", "column kind rows first value")


@dataclass(frozen=True, eq=False)
class Screened:
    """A record in files without what was not measured, and what that was."""

    record: CleanRecord
    look: Look
    found: tuple = ()  # of Found
    odd: tuple = ()  # what looks odd without being at fault
    missing: dict = field(default_factory=dict)
    clipped: int = 0

    @property
    def notes(self):
        return (*map(sentence, self.found), *self.odd)

    @property
    def impossible(self):
        """Rows of each column that were not measured, those that repeat aside."""
        counts = Counter()
        for one in self.found:
            counts[one.column] += one.rows if one.kind != "stuck" else 0
        return {name: counts[name] for name in self.record.names}


def screened_blocks(source, drivers=(), limits=None, check_units=True, needed=None):
    """
    A record in files without what was not measured, from few passes over them.

    By the rules of :func:`pvlib_fem.quality.screen.screened`, of which those that ask
    what is usual in a column (its unit, codes where its range is not known) are
    answered by a million of its rows, evenly taken.

    Parameters
    ----------
    source : ParquetRecord
    drivers : sequence of str
        Columns beside the usual four.
    limits : Limits, optional
    check_units : bool, default True
        Refuse columns that look to be in another unit.
    needed : sequence of str, optional
        Columns that have to hold a value, by default all.

    Returns
    -------
    Screened

    Raises
    ------
    ValueError
        As :func:`pvlib_fem.quality.screen.screened`.
    """
    clean = CleanRecord(source, (*COLUMNS, *drivers))
    needed = clean.names if needed is None else needed
    return Screening(clean, limits or Limits(), needed).run(check_units)


@dataclass(eq=False)
class Screening:
    """A record less what was found in it so far."""

    clean: CleanRecord
    limits: Limits
    needed: tuple
    look: Look | None = None
    found: dict = field(default_factory=dict)  # kind to column to spans of rows
    first: dict = field(default_factory=dict)  # time and value of the first of them

    def run(self, check_units):
        """All rules, in the order in which a record in memory has them."""
        clean, limits = self.clean, self.limits
        self.look = Look.of(clean, limits)
        self.look.refuse_gaps(limits, clean.source)
        missing = {name: one.missing for name, one in self.look.columns.items()}
        self.refuse_nothing(missing)
        self.fills()
        sample = self.look.sampled(self.clean)
        if check_units:
            refuse_units(sample, limits)
        doubts = doubtful(sample.columns, limits)
        clipped = self.negative_by_day()
        for kind in ("out of range", "spike"):
            for name, one in self.ruled(doubts):
                self.note(kind, name, *one.of(kind))
        for name, one in self.ruled(doubts):
            if possible(name) is None:  # of which a lone one is a spike
                lone = one.beyond(self.clean, sample[name], limits.far**3, 1)
                self.note("spike", name, *lone)
        self.refuse_impossible()
        self.ends(doubts)
        self.clean = self.clean.clipped()
        self.standing()
        sample = self.look.sampled(self.clean)
        if check_units:
            refuse_doubtful(sample.columns, limits)
        found, odd = tuple(self.told()), tuple(oddities(sample, limits))
        self.look.sample.clear()  # which a fit would keep
        return Screened(self.clean, self.look, found, odd, missing, clipped)

    def ruled(self, doubts=()):
        """Columns that the rules are asked of."""
        for name, one in self.look.columns.items():
            if name not in doubts and name not in GEOMETRY:
                yield name, one

    def note(self, kind, name, rows, times, values):
        """Take rows of one kind out of a column, with what is said of the first."""
        if len(rows):
            at = int(np.argmin(rows))
            time = self.clean.source.at(times[at])
            self.take(kind, name, spans(np.sort(rows)), time, values[at])

    def take(self, kind, name, rows, time, value):
        before = self.found.setdefault(kind, {}).get(name)
        if before is None or rows[0, 0] < before[0, 0]:
            self.first[kind, name] = time, float(value)
        both = rows if before is None else united(before, rows)
        self.found[kind][name] = both
        self.clean = self.clean.lacking({name: rows})

    def look_again(self):
        """The look at what is left, where a rule took what others would see."""
        self.look = Look.of(self.clean, self.limits)

    def refuse_nothing(self, missing):
        """Refuse a column without a value."""
        at, rows = self.clean.source.at, self.look.rows
        if empty := [name for name in self.needed if missing[name] == rows]:
            first, last = map(at, self.look.ends)
            raise ValueError(
                f"{empty[0]} holds no value from {first} to {last}; check the column's "
                "name and the logger"
            )

    def fills(self):
        """Values that stand for none: codes, and what repeats far beyond all else."""
        limits, again = self.limits, False
        sample = self.look.sampled(self.clean)
        for name, one in self.ruled():
            rows, times, values = one.of("fill value")
            rest = sample[name]
            if possible(name) is None and len(rows):
                rounded = np.round(values, 2)
                rest = rest[np.isfinite(rest) & ~np.isin(rest, values)]
                codes = apart(np.unique(rounded), rest, limits)
                kept = np.isin(rounded, codes)
                rows, times, values = rows[kept], times[kept], values[kept]
                again |= len(rows) > 0
            self.note("fill value", name, rows, times, values)
            if not one.known:
                continue
            far = one.beyond(self.clean, rest, limits.far**2, limits.few_rows)
            self.note("fill value", name, *far)
            again |= len(far[0]) > 0
        if again:
            self.look_again()
        for row in self.told():
            if row.column in POSSIBLE and not self.look.columns[row.column].known:
                raise empty_error(row)

    def negative_by_day(self):
        """Take negative irradiance by day out; rows of it by night come back."""
        if not self.look.columns["poa_global"].least < 0:
            return 0
        light, below = self.light(), [0]
        parts = []
        for block in self.clean.blocks(("poa_global",)):
            poa = block["poa_global"]
            rows = np.flatnonzero(poa < 0)
            below.append(len(rows))
            if light and len(rows):
                day, slot = slots(block.index[rows], self.limits)
                rows = rows[np.isin(day * PARTS + slot, list(light))]
                parts.append((rows + block.start, block.times[rows], poa[rows]))
        if parts and sum(len(rows) for rows, *_ in parts):
            self.note(
                "negative by day", "poa_global", *map(np.concatenate, zip(*parts))
            )
            self.look_again()
        rows = size(self.found.get("negative by day", {}).get("poa_global", spans([])))
        outside = self.look.columns["poa_global"].of("out of range")[2]
        return sum(below) - rows - int((outside < 0).sum())

    def light(self):
        """Parts of days that are light on the days around, as numbers."""
        sums, counts, negative = Counter(), Counter(), set()
        for block in self.clean.blocks(("poa_global",)):
            poa = block["poa_global"]
            day, slot = slots(block.index, self.limits)
            keys, place = np.unique(day * PARTS + slot, return_inverse=True)
            there = poa >= 0
            total = np.bincount(place[there], poa[there], len(keys))
            number = np.bincount(place[there], minlength=len(keys))
            for key, one, many in zip(keys.tolist(), total, number):
                sums[key] += one
                counts[key] += many
            negative.update(keys[np.unique(place[poa < 0])].tolist())
        keys = np.array(sorted(sums))
        mean = [sums[k] / counts[k] if counts[k] else np.nan for k in keys.tolist()]
        days = [keys // PARTS, keys % PARTS]
        usual = pd.Series(mean, days).unstack()  # noqa: PD010  of an index
        light = is_light(usual, *days, self.limits)
        return set(keys[light].tolist()) & negative

    def ends(self, doubts):
        """Take out what is at the end of a sensor's range."""
        sample, again = self.look.sampled(self.clean), False
        for name, _ in self.ruled(doubts):
            ends = range_ends(name, sample[name], sample.index, self.limits)
            parts, since = [], -np.inf  # when it was there last
            for block in self.clean.blocks((name,)) if ends else ():
                values, since_first = block[name], block.times - self.look.ends[0]
                seconds = since_first * self.look.unit
                given = name, values, seconds, ends, self.limits, since
                rows = np.flatnonzero(at_end(*given))
                parts.append((rows + block.start, block.times[rows], values[rows]))
                there = np.isin(values, ends)
                since = max(since, seconds[there].max(initial=since))
            if parts:
                self.note("end of range", name, *map(np.concatenate, zip(*parts)))
                again = True
        if again:
            self.look_again()

    def refuse_impossible(self):
        """Refuse a record of which too much cannot be, or is negative by day."""
        for name in POSSIBLE:
            kinds = "out of range", "negative by day"
            there = [kind for kind in kinds if name in self.found.get(kind, {})]
            if not there:
                continue
            found = {kind: self.found[kind][name] for kind in there}
            total = self.look.columns[name].known
            total += size(found.get("negative by day", spans([])))
            share = sum(map(size, found.values())) / max(total, 1)
            first = min(found, key=lambda kind, found=found: found[kind][0, 0])
            time, value = self.first[first, name]
            refuse_share(name, share, value, time, self.limits)

    def standing(self):
        """Take out sensors that stand still."""
        clean, columns = self.clean, self.look.columns
        sample = self.look.sampled(clean)
        rests = {n: rest_of(n, sample[n], self.limits) for n in clean.names}
        runs = self.look.standing(rests)
        found, wind = frozen(clean, runs, rests, self.limits), columns["wind_speed"]
        if wind.never_moves:  # a number that stands for all wind
            found.pop("wind_speed", None)
        if whole := [n for n in found if n in POSSIBLE and columns[n].never_moves]:
            first, last = map(clean.source.at, self.look.ends)
            values = {name: max(columns[name].low, 0.0) for name in whole}
            lines = [standing_line(n, v, first, last) for n, v in values.items()]
            raise frozen_error(whole[0], lines)
        for name, rows in found.items():
            one = runs[name]
            at = int(np.flatnonzero(one.first == rows[0, 0])[0])
            time = clean.source.at(one.begin[at])
            self.take("stuck", name, rows, time, one.value[at])
        wind, rest = sample["wind_speed"], rests["wind_speed"]
        usual = self.look.step * self.look.every
        if not never_moves(wind) and may_rest(wind, rest, 2.0 * usual, self.limits):
            self.calm(clean, rest)

    def calm(self, clean, rest):
        """Take out an anemometer that stands at rest for longer than a calm."""

        def blocks():
            for block in clean.blocks(("wind_speed",)):
                values, unit = block["wind_speed"], block.inputs.unit
                yield values, block.start, block.times, unit

        parts = [*becalmed(blocks, self.look.step, rest, self.limits)]
        if sum(len(rows) for rows, *_ in parts):
            self.note("stuck", "wind_speed", *map(np.concatenate, zip(*parts)))

    def told(self):
        """What was found, in the order of kinds and columns."""
        for kind in KINDS:
            for name in self.clean.names:
                if name in self.found.get(kind, {}):
                    rows = size(self.found[kind][name])
                    yield Found(name, kind, rows, *self.first[kind, name])
