"""The rows of a record that a search looks at, answered block by block."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from pvlib_fem import scores
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
class Asked:
    """A model that is to be answered in a pass, and over which rows."""

    model: ThermalModel
    coefficients: dict
    rows: str = "train"  # of those that a source has
    wanted: bool = True  # whether slopes are


@dataclass(frozen=True, eq=False)
class Part:
    """Rows that follow each other, and which of them count for what."""

    measured: np.ndarray
    dates: np.ndarray
    counts: Mapping  # booleans of the rows, by what they count for

    def answered(self, model, given, which, quick):
        """What a model says of those of the rows that count."""
        counts = self.counts[which]
        if quick:
            return Compiled(model, given, counts, self.measured, self.dates)
        return answer_of(*model.answer(*given), counts, self.measured, self.dates)


class Source:
    """
    Rows that a fit asks for part by part, one pass over all of them at a time.

    Whether they are held in memory or read from files, of a source are known
    ``count``, the rows that are fitted, ``step`` and ``wind`` of the record and
    ``winds`` of the fitted rows, :meth:`quick` and :meth:`parts`.
    """

    count: int
    step: float
    wind: float
    winds: tuple

    def quick(self, model):
        """Whether the compiled loops answer a model that is known on a part."""
        raise NotImplementedError

    def parts(self, asked):
        """
        Parts of the rows, one after the other, with what models are given there.

        Parameters
        ----------
        asked : dict of Asked

        Yields
        ------
        Part, dict
            Of model, and of inputs, coefficients and what was before, by who asked.
        """
        raise NotImplementedError

    def sums(self, asked, names):
        """:class:`Normal` of several models by some of their coefficients each."""
        total = {key: np.zeros((len(names[key]) + 1,) * 2) for key in asked}
        for part, given in self.parts(asked):
            for key, (model, own) in given.items():
                answer = part.answered(model, own, asked[key].rows, self.quick(model))
                total[key] += answer.products(names[key])
        return {key: Normal.of(found) for key, found in total.items()}

    def ends(self, asked, last, names, temperature=None):
        """
        Scores of several models, and sums by the day of the last of them.

        Parameters
        ----------
        asked : dict of Asked
        last : hashable
            The one of the sums.
        names : tuple of str
            Its coefficients that vary.
        temperature : array, optional
            Takes that of all rows by the last model. [°C]

        Returns
        -------
        DataFrame, DailySums
        """
        tallies, by_day, end = {key: scores.tallying() for key in asked}, [], 0
        for part, given in self.parts(asked):
            first, end = end, end + len(part.dates)
            train, test = part.counts["train"], part.counts["test"]
            rows = {"train": np.flatnonzero(train), "test": np.flatnonzero(test)}
            for key, (model, own) in given.items():
                quick = self.quick(model)
                if key == last:
                    found = np.empty(len(part.dates))
                    answer = part.answered(model, own, "train", quick)
                    by_day.append(answer.by_day(names, found))
                    if temperature is not None:
                        temperature[first:end] = found
                else:
                    found = temperature_of(model, own, quick, train | test)
                error = part.measured - found
                for which, at in rows.items():
                    tallies[key][which].add(error[at])
        sums = cluster_sums_of(*joined(by_day), self.count)
        return scores.scored(tallies), DailySums(names, sums, self.winds)


def temperature_of(model, given, quick, counts=None):
    """Temperature of a part's rows, or of those that count, from those before. [°C]"""
    if not quick:
        return model.answer(*given, wanted=False)[0]
    found = np.zeros(len(given[0].index))
    answered(model, *given, None if counts is None else (counts, np.nan), into=found)
    return found


@dataclass(frozen=True, eq=False)
class Rows(Source):
    """Rows that count of a record that is held in memory."""

    record: Record
    counts: np.ndarray  # booleans
    divided: dict = field(default_factory=dict, repr=False)  # by the size of a part

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

    @property
    def kept(self):
        """Booleans of the rows, by what they count for."""
        return {"train": self.counts}

    def quick(self, model):
        """Whether the compiled loops answer a model that is known on a part."""
        return fast(len(self.record.index), model.effects)

    def parts(self, asked):
        """The record in blocks; see :meth:`Source.parts`."""
        inputs, dates, kept = self.record.inputs, self.record.dates, self.kept
        pasts = {key: one.model.past(inputs) for key, one in asked.items()}
        known = {
            key: one.model.knowing(inputs, one.coefficients, one.wanted)
            for key, one in asked.items()
        }
        size = len(inputs.index)
        if not all(map(self.quick, known.values())):
            size = BLOCK
        elif len(asked) > 1 or inputs.columns.narrow or known_effects(known):
            size = AT_ONCE  # but for terms and columns to be widened, all at once
        for block, part in self.in_blocks(size):
            given = {
                key: (known[key].on(block), (part, one.coefficients, pasts[key]))
                for key, one in asked.items()
            }
            counts = {which: rows[block] for which, rows in kept.items()}
            yield Part(part["temp_module"], dates[block], counts), given

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

    def in_blocks(self, size):
        """The blocks of a size with their inputs, which are the same in every pass."""
        if size not in self.divided:
            places = blocks(len(self.record.index), size)
            self.divided[size] = [(p, self.record.inputs.part(p)) for p in places]
        return self.divided[size]


def known_effects(models):
    return any(model.effects for model in models.values())


def normal_sums(model, coefficients, source, names) -> Normal:
    """Squares and products of slopes and residual, from one pass over a source."""
    return source.sums({"": Asked(model, coefficients)}, {"": names})[""]


def daily_sums(model, coefficients, source, at_bound, into=None) -> DailySums:
    """
    The sums of a minimum by the day, from one pass over a source.

    Where it is given, ``into`` takes the temperature of all rows.
    """
    names = tuple(name for name in model.free if name not in at_bound)
    found, end = [], 0
    for part, given in source.parts({"": Asked(model, coefficients)}):
        first, end = end, end + len(part.dates)
        known, own = given[""]
        answer = part.answered(known, own, "train", source.quick(known))
        found.append(answer.by_day(names, None if into is None else into[first:end]))
    dates, sums = joined(found)
    return DailySums(names, cluster_sums_of(dates, sums, source.count), source.winds)
