"""The rows of a record that a search looks at, answered block by block."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from pvlib_fem.fitting.daily import DailySums
from pvlib_fem.record.inputs import Record
from pvlib_fem.statistics.clusters import (
    cluster_sums_of,
    joined,
    products_by_day,
    starts,
)
from pvlib_fem.statistics.leastsquares import Normal, products
from pvlib_fem.thermal.compiled import AT_ONCE, answered, fast
from pvlib_fem.thermal.model import BLOCK, ThermalModel, blocks
from pvlib_fem.thermal.response import Past

EVERY, FEWEST = 8, 4  # a search begins on each eighth block, where there are four


@dataclass(frozen=True, eq=False)
class Answer:
    """What a model says of some rows that count, one after the other."""

    measured: np.ndarray  # [°C]
    temperature: np.ndarray  # [°C]
    slopes: Mapping  # by parameter
    dates: np.ndarray  # day of each row, from 1970-01-01
    whole: np.ndarray | None = None  # temperature of the other rows, too

    def columns(self, names):
        """Some of the slopes, and what is left, side by side."""
        slopes = (self.slopes[name] for name in names)
        rows = len(self.measured)
        columns = (np.broadcast_to(slope, rows) for slope in slopes)
        return [*columns, self.measured - self.temperature]

    def products(self, names):
        """Products of some of the slopes, and of what is left, over all rows."""
        return products(self.columns(names))

    def by_day(self, names):
        """The dates, and the same products over each."""
        return products_by_day(self.columns(names), self.dates)

    def with_temperature(self, names):
        """Temperature of all rows, and dates and products by the day."""
        return self.whole, *self.by_day(names)


@dataclass(frozen=True, eq=False)
class Compiled:
    """The same, asked for in products alone and answered by the compiled loops."""

    model: ThermalModel
    given: tuple  # inputs, coefficients and past
    counts: np.ndarray
    measured: np.ndarray  # of all rows of the block
    dates: np.ndarray  # of the rows that count

    def summed(self, names, firsts=(), into=None):
        """Products over parts that begin at some rows; where it goes, temperature."""
        edges = np.array([0, *firsts, len(self.counts)], dtype=np.int64)
        seen = self.counts, self.measured
        total = answered(self.model, *self.given, seen, edges, into)
        parameters = list(self.model.parameters)
        kept = [*(parameters.index(name) for name in names), -1]
        return total[:, kept][:, :, kept]

    def products(self, names):
        return self.summed(names).sum(axis=0)

    def by_day(self, names):
        return self.with_temperature(names)[1:]

    def with_temperature(self, names):
        """Temperature of all rows, and dates and products by the day."""
        first, _ = starts(self.dates)
        rows = np.flatnonzero(self.counts)[first]
        found = np.empty(len(self.counts))
        total = self.summed(names, rows[1:], found)
        return found, self.dates[first], total[: len(first)]


@dataclass(frozen=True, eq=False)
class Rows:
    """
    Rows that count of a record that is held in memory.

    A fit asks for no more than ``count``, ``step``, ``wind``, ``winds`` and
    :meth:`answers`, one pass each, so that another source of rows need not hold them.
    """

    record: Record
    counts: np.ndarray  # booleans
    parts: dict = field(default_factory=dict, repr=False)  # by their size
    usual: dict = field(default_factory=dict, repr=False)  # step, by the drivers

    @cached_property
    def count(self):
        """How many rows count."""
        return int(np.count_nonzero(self.counts))

    @cached_property
    def step(self):
        """Usual time between rows. [s]"""
        return self.record.inputs.step

    @cached_property
    def wind(self):
        """Mean wind speed of the record. [m/s]"""
        return float(np.nanmean(self.record["wind_speed"]))

    @cached_property
    def winds(self):
        """Mean wind and its spread over rows that count, where the sun is. [m/s]"""
        wind = self.record["wind_speed"][self.counts]
        weight = self.record["poa_global"][self.counts] ** 2
        total = max(weight.sum(), np.finfo(float).tiny)
        mean = weight @ wind / total
        return float(mean), float(np.sqrt(weight @ (wind - mean) ** 2 / total))

    def answers(self, model, coefficients) -> Iterator[Answer | Compiled]:
        """What a model says of the rows that count, carried on over all others."""
        inputs, drivers = self.record.inputs, tuple(model.drivers)
        if drivers not in self.usual:
            self.usual[drivers] = model.past(inputs).usual
        known, past = model.knowing(inputs, coefficients), None
        quick = fast(len(inputs.index), known.effects)
        size = AT_ONCE if quick else BLOCK
        for block, part, rows, measured, dates in self.divided(size):
            if past is None:
                past = Past(self.usual[drivers])
            here, given = known.on(block), (part, coefficients, past)
            if quick:
                yield Compiled(here, given, self.counts[block], measured, dates)
                continue
            temperature, slopes = here.answer(*given)
            slopes = {n: s[rows] if np.ndim(s) else s for n, s in slopes.items()}
            found = measured[rows], temperature[rows], slopes, dates
            yield Answer(*found, temperature)

    def thinned(self):
        """
        Some of the blocks, where a search of many may begin, or None of few.

        One after the other, as of a record with gaps.
        """
        rows = np.arange(len(self.record.index))
        parts = [rows[part] for part in blocks(len(rows))[::EVERY]]
        if len(parts) < FEWEST:
            return None
        some = np.concatenate(parts)
        counts = self.counts[some]
        if 2 * EVERY * np.count_nonzero(counts) < self.count:
            return None
        inputs = self.record.inputs.taken(some)
        return Rows(replace(self.record, inputs=inputs), counts)

    def divided(self, size):
        """The blocks of a size with what is the same in every pass."""
        if size not in self.parts:
            places = blocks(len(self.record.index), size)
            self.parts[size] = [*map(self.part, places)]
        return self.parts[size]

    def part(self, block):
        """A block with what is the same in every pass."""
        record, rows = self.record, np.flatnonzero(self.counts[block])
        measured = np.array(record["temp_module"][block])
        part, dates = record.inputs.part(block), record.dates[block][rows]
        return block, part, rows, measured, dates


def normal_sums(model, coefficients, source, names) -> Normal:
    """Squares and products of slopes and residual, from one pass over a source."""
    answers = source.answers(model, coefficients)
    return Normal.of(sum(answer.products(names) for answer in answers))


def daily_sums(model, coefficients, source, at_bound) -> DailySums:
    """The sums of a minimum by the day, from one pass over a source."""
    return with_temperature(model, coefficients, source, at_bound)[1]


def with_temperature(model, coefficients, source, at_bound):
    """Temperature of all rows at a minimum, and sums by the day of those that count."""
    names = tuple(name for name in model.free if name not in at_bound)
    answers = source.answers(model, coefficients)
    temperature, *found = zip(*(answer.with_temperature(names) for answer in answers))
    sums = cluster_sums_of(*joined(zip(*found)), source.count)
    return np.concatenate(temperature), DailySums(names, sums, source.winds)
