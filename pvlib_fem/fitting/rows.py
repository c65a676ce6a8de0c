"""The rows of a record that a search looks at, answered block by block."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from pvlib_fem.fitting.daily import DailySums
from pvlib_fem.record.checks import Record
from pvlib_fem.statistics.clusters import cluster_sums_of, sums_by_day
from pvlib_fem.statistics.leastsquares import Normal, products
from pvlib_fem.thermal.model import blocks
from pvlib_fem.thermal.response import Past

EVERY, FEWEST = 8, 6  # a search begins on each eighth block, where there are six such


@dataclass(frozen=True, eq=False)
class Answer:
    """What a model says of some rows that count, one after the other."""

    measured: np.ndarray  # [°C]
    temperature: np.ndarray  # [°C]
    slopes: Mapping  # by parameter
    dates: np.ndarray  # day of each row, from 1970-01-01

    @property
    def residual(self):
        return self.measured - self.temperature

    def columns(self, names):
        """Some of the slopes, and what is left, side by side."""
        slopes = (self.slopes[name] for name in names)
        rows = len(self.measured)
        return [*(np.broadcast_to(slope, rows) for slope in slopes), self.residual]


@dataclass(frozen=True, eq=False)
class Rows:
    """
    Rows that count of a record that is held in memory.

    A fit asks for no more than ``step``, ``wind``, ``winds`` and :meth:`answers`, one
    pass each, so that another source of rows need not hold them.
    """

    record: Record
    counts: np.ndarray  # booleans
    every: int = 1  # of how many blocks it has one
    parts: list = field(default_factory=list, repr=False)
    usual: dict = field(default_factory=dict, repr=False)  # step, by the drivers

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

    def answers(self, model, coefficients, wanted=True) -> Iterator[Answer]:
        """What a model says of the rows that count, carried on over all others."""
        inputs, drivers = self.record.inputs, tuple(model.drivers)
        if drivers not in self.usual:
            self.usual[drivers] = model.past(inputs).usual
        known, past = model.knowing(inputs, coefficients, wanted), None
        for block, part, rows, measured, dates in self.divided():
            if past is None or self.every > 1:
                past = Past(self.usual[drivers])
            here = known.on(block)
            temperature, slopes = here.answer(part, coefficients, past, wanted)
            slopes = {n: s[rows] if np.ndim(s) else s for n, s in slopes.items()}
            yield Answer(measured, temperature[rows], slopes, dates)

    def thinned(self):
        """Some of the blocks, where a search of many may begin, or None of few."""
        parts = blocks(len(self.record.index))[::EVERY]
        share = sum(np.count_nonzero(self.counts[rows]) for rows in parts)
        if len(parts) < FEWEST or 2 * EVERY * share < np.count_nonzero(self.counts):
            return None
        return replace(self, every=EVERY, parts=[])

    def divided(self):
        """The blocks with what is the same in every pass."""
        if not self.parts:
            record = self.record
            for block in blocks(len(record.index))[:: self.every]:
                rows = np.flatnonzero(self.counts[block])
                measured = record["temp_module"][block][rows]
                part, dates = record.inputs.part(block), record.dates[block][rows]
                self.parts.append((block, part, rows, measured, dates))
        return self.parts


def normal_sums(model, coefficients, source, names) -> Normal:
    """Squares and products of slopes and residual, from one pass over a source."""
    total = sum(
        products(answer.columns(names))
        for answer in source.answers(model, coefficients)
        if len(answer.measured)
    )
    return Normal.of(total)


def daily_sums(model, coefficients, source, at_bound) -> DailySums:
    """The sums of a minimum by the day, from one pass over a source."""
    names = tuple(name for name in model.free if name not in at_bound)
    by_day = sums_by_day(
        (answer.columns(names), answer.dates)
        for answer in source.answers(model, coefficients)
    )
    return DailySums(names, cluster_sums_of(by_day), source.winds)
