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

EVERY, FEWEST = 8, 4  # a search begins on each eighth block, where there are four


@dataclass(frozen=True, eq=False)
class Answer:
    """What a model says of some rows that count, one after the other."""

    measured: np.ndarray  # [°C]
    temperature: np.ndarray  # [°C]
    slopes: Mapping  # by parameter
    dates: np.ndarray  # day of each row, from 1970-01-01
    whole: np.ndarray  # temperature of the other rows, too

    @property
    def rows(self):
        """How many rows the block has."""
        return len(self.whole)

    def columns(self, names):
        """Some of the slopes, and what is left, side by side."""
        slopes = (self.slopes[name] for name in names)
        rows = len(self.measured)
        columns = (np.broadcast_to(slope, rows) for slope in slopes)
        return [*columns, self.measured - self.temperature]

    def products(self, names):
        """Products of some of the slopes, and of what is left, over all rows."""
        return products(self.columns(names))

    def by_day(self, names, into=None):
        """The dates, and the same products over each; where it goes, temperature."""
        if into is not None:
            into[:] = self.whole
        return products_by_day(self.columns(names), self.dates)


def answer_of(temperature, slopes, counts, measured, dates):
    """What a model says of all rows of a block, of those that count."""
    rows = np.flatnonzero(counts)
    slopes = {n: s[rows] if np.ndim(s) else s for n, s in slopes.items()}
    return Answer(measured[rows], temperature[rows], slopes, dates[rows], temperature)


@dataclass(frozen=True, eq=False)
class Compiled:
    """The same, asked for in products alone and answered by the compiled loops."""

    model: ThermalModel
    given: tuple  # inputs, coefficients and past
    counts: np.ndarray
    measured: np.ndarray  # of all rows of the block
    dates: np.ndarray  # of all rows, too

    @property
    def rows(self):
        return len(self.counts)

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

    def by_day(self, names, into=None):
        rows = np.flatnonzero(self.counts)
        dates = self.dates[rows]
        first, _ = starts(dates)
        total = self.summed(names, rows[first][1:], into)
        return dates[first], total[: len(first)]


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

    @cached_property
    def count(self):
        """How many rows count."""
        return int(np.count_nonzero(self.counts))

    @cached_property
    def step(self):
        """Usual time between rows. [s]"""
        return self.record.inputs.step

    @property
    def wind(self):
        """Mean wind speed of the record. [m/s]"""
        return self.record.inputs.mean("wind_speed")

    @cached_property
    def winds(self):
        """Mean wind and its spread over rows that count, where the sun is. [m/s]"""
        wind = self.record["wind_speed"][self.counts]
        weight = self.record["poa_global"][self.counts] ** 2
        total = max(weight.sum(), np.finfo(float).tiny)
        # no products of BLAS, whose bits depend on its threads
        mean = (weight * wind).sum() / total
        return float(mean), float(np.sqrt((weight * (wind - mean) ** 2).sum() / total))

    def answers(self, model, coefficients) -> Iterator[Answer | Compiled]:
        """What a model says of the rows that count, carried on over all others."""
        inputs, past = self.record.inputs, model.past(self.record.inputs)
        known = model.knowing(inputs, coefficients)
        rows, size = len(inputs.index), BLOCK
        if quick := fast(rows, known.effects):
            # but for terms of effects, and columns to be widened, loops need no room
            size = AT_ONCE if known.effects or inputs.columns.narrow else rows
        for block, part in self.divided(size):
            here, given = known.on(block), (part, coefficients, past)
            seen = self.counts[block], part["temp_module"], self.record.dates[block]
            if quick:
                yield Compiled(here, given, *seen)
            else:
                temperature, slopes = here.answer(*given)
                yield answer_of(temperature, slopes, *seen)

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
        """The blocks of a size with their inputs, which are the same in every pass."""
        if size not in self.parts:
            places = blocks(len(self.record.index), size)
            self.parts[size] = [(p, self.record.inputs.part(p)) for p in places]
        return self.parts[size]


def normal_sums(model, coefficients, source, names) -> Normal:
    """Squares and products of slopes and residual, from one pass over a source."""
    answers = source.answers(model, coefficients)
    return Normal.of(sum(answer.products(names) for answer in answers))


def daily_sums(model, coefficients, source, at_bound, into=None) -> DailySums:
    """
    The sums of a minimum by the day, from one pass over a source.

    Where it is given, ``into`` takes the temperature of all rows.
    """
    names = tuple(name for name in model.free if name not in at_bound)
    found, end = [], 0
    for answer in source.answers(model, coefficients):
        first, end = end, end + answer.rows
        found.append(answer.by_day(names, None if into is None else into[first:end]))
    dates, sums = joined(found)
    return DailySums(names, cluster_sums_of(dates, sums, source.count), source.winds)
