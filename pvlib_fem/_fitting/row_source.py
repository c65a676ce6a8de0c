"""Sources of rows for a fit: a model is solved on them block by block."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from pvlib_fem import scores
from pvlib_fem._fitting.daily import DailySums
from pvlib_fem._record.inputs import Record
from pvlib_fem._statistics.clusters import (
    cluster_sums_of,
    date_starts,
    joined_products,
    products_by_day,
)
from pvlib_fem._statistics.leastsquares import Normal, products
from pvlib_fem._thermal.compiled import AT_ONCE, solve_compiled, uses_compiled_loops
from pvlib_fem._thermal.model import BLOCK, ThermalModel, blocks

EVERY, FEWEST = 8, 4  # a search begins on every eighth block, if that makes four


@dataclass(frozen=True, eq=False)
class BlockSolution:
    """Temperature and slopes of a model on the rows of a block that count."""

    measured: np.ndarray  # [°C]
    temperature: np.ndarray  # [°C]
    slopes: Mapping  # by parameter
    dates: np.ndarray  # day of each row, from 1970-01-01
    whole: np.ndarray  # temperature of all rows

    def columns(self, names: Sequence) -> Any:
        """Some of the slopes, then the residual."""
        slopes = (self.slopes[name] for name in names)
        rows = len(self.measured)
        columns = (np.broadcast_to(slope, rows) for slope in slopes)
        return [*columns, self.measured - self.temperature]

    def products(self, names: list) -> np.ndarray:
        """Sums of products of some of the slopes and the residual over all rows."""
        return products(self.columns(names))

    def by_day(
        self, names: tuple, into: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Dates and daily sums of products; ``into`` takes the temperature."""
        if into is not None:
            into[:] = self.whole
        return products_by_day(self.columns(names), self.dates)


def answer_of(
    temperature: np.ndarray,
    slopes: dict,
    counts: np.ndarray,
    measured: np.ndarray,
    dates: np.ndarray,
) -> BlockSolution:
    """The answer on the rows that count, from that on all rows of a block."""
    rows = np.flatnonzero(counts)
    slopes = {n: s[rows] if np.ndim(s) else s for n, s in slopes.items()}
    return BlockSolution(
        measured[rows], temperature[rows], slopes, dates[rows], temperature
    )


@dataclass(frozen=True, eq=False)
class Compiled:
    """Products of slopes and residual on a block, from the compiled loops."""

    model: ThermalModel
    given: tuple  # inputs, coefficients and past
    counts: np.ndarray
    measured: np.ndarray  # of all rows of the block
    dates: np.ndarray  # of all rows of the block

    def products_by_part(
        self, names: Sequence, firsts: np.ndarray | tuple = (), into: Any = None
    ) -> np.ndarray:
        """Products over parts that start at 0 and ``firsts``; ``into``: temperature."""
        edges = np.array([0, *firsts, len(self.counts)], dtype=np.int64)
        seen = self.counts, self.measured
        total = solve_compiled(*[self.model, *self.given, seen, edges, into])
        parameters = list(self.model.parameters)
        kept = [*(parameters.index(name) for name in names), -1]
        return total[:, kept][:, :, kept]

    def products(self, names: list) -> np.ndarray:
        return self.products_by_part(names).sum(axis=0)

    def by_day(
        self, names: tuple, into: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        rows = np.flatnonzero(self.counts)
        dates = self.dates[rows]
        first, _ = date_starts(dates)
        total = self.products_by_part(names, rows[first][1:], into)
        return dates[first], total[: len(first)]


@dataclass(frozen=True, eq=False)
class EvalRequest:
    """A model to solve in a pass over a source, and the rows to sum over."""

    model: ThermalModel
    coefficients: dict
    rows: str = "train"  # key of a mask of the source
    wanted: bool = True  # whether slopes are computed


@dataclass(frozen=True, eq=False)
class Part:
    """Consecutive rows, and masks of the rows that count for each purpose."""

    measured: np.ndarray
    dates: np.ndarray
    counts: Mapping  # masks of the rows, by purpose

    def solve(self, model: ThermalModel, given: tuple, which: str, quick: bool) -> Any:
        """Temperature and slopes of a model on the rows that count."""
        counts = self.counts[which]
        if quick:
            return Compiled(model, given, counts, self.measured, self.dates)
        return answer_of(*model.solve_block(*given), counts, self.measured, self.dates)


class Source:
    """
    Rows of a fit, in memory or in files, that a pass yields part by part.

    A source has ``count``, the number of fitted rows, ``step`` and ``wind`` of the
    record, ``winds`` of the fitted rows, ``some_wind`` of its first rows, :meth:`quick`
    and :meth:`parts`.
    """

    if TYPE_CHECKING:

        @property
        def count(self) -> int: ...

        @property
        def step(self) -> float: ...

        @property
        def wind(self) -> float: ...

        @property
        def winds(self) -> Any: ...

        @property
        def some_wind(self) -> np.ndarray: ...

    def uses_compiled_loops(self, model: ThermalModel) -> bool:
        """Whether the compiled loops can solve a model with known terms."""
        raise NotImplementedError

    def parts(self, requests: Any) -> Any:
        """
        Consecutive parts of the rows, with the input of each requested model.

        Parameters
        ----------
        requests : dict of EvalRequest

        Yields
        ------
        Part, dict
            The model, and a tuple of inputs, coefficients and past, by the request's
            key.
        """
        raise NotImplementedError

    def sums(self, requests: Any, names: dict) -> Any:
        """:class:`Normal` of several models by some of their coefficients each."""
        total = {key: np.zeros((len(names[key]) + 1,) * 2) for key in requests}
        for part, given in self.parts(requests):
            for key, (model, own) in given.items():
                answer = part.solve(
                    model, own, requests[key].rows, self.uses_compiled_loops(model)
                )
                total[key] += answer.products(names[key])
        return {key: Normal.from_products(matrix) for key, matrix in total.items()}

    def scores_and_sums(
        self,
        requests: Any,
        last: str,
        names: tuple,
        temperature: np.ndarray | None = None,
    ) -> tuple[pd.DataFrame, DailySums]:
        """
        Scores of several models, and daily sums of one of them.

        Parameters
        ----------
        requests : dict of EvalRequest
        last : hashable
            Key of the model of the daily sums.
        names : tuple of str
            Coefficients of that model that vary.
        temperature : array, optional
            Takes the temperature of all rows by that model. [°C]

        Returns
        -------
        DataFrame, DailySums
        """
        tallies, by_day, end = {key: scores.new_error_sums() for key in requests}, [], 0
        for part, given in self.parts(requests):
            first, end = end, end + len(part.dates)
            train, test = part.counts["train"], part.counts["test"]
            rows = {"train": np.flatnonzero(train), "test": np.flatnonzero(test)}
            for key, (model, own) in given.items():
                quick = self.uses_compiled_loops(model)
                if key == last:
                    modelled = np.empty(len(part.dates))
                    answer = part.solve(model, own, "train", quick)
                    by_day.append(answer.by_day(names, modelled))
                    if temperature is not None:
                        temperature[first:end] = modelled
                else:
                    modelled = temperature_of(model, own, quick, train | test)
                error = part.measured - modelled
                for which, at in rows.items():
                    tallies[key][which].add(error[at])
        sums = cluster_sums_of(*joined_products(by_day), self.count)
        return scores.score_table(tallies), DailySums(names, sums, self.winds)


def temperature_of(
    model: Any, given: Any, quick: bool | None, counts: Any = None
) -> np.ndarray:
    """
    Temperature of a part of the rows, continued from the part before.

    Parameters
    ----------
    model : ThermalModel
        With known terms, as :meth:`ThermalModel.knowing` gives them.
    given : tuple
        Inputs of the part, coefficients, and the past, which is updated.
    quick : bool
        Whether the compiled loops solve it.
    counts : numpy.ndarray of bool, shape (rows,), optional
        Rows whose temperature is used, by default all; the compiled loops give 0 in the
        others.

    Returns
    -------
    numpy.ndarray, shape (rows,)
        Temperature of the module. [°C]
    """
    if not quick:
        return model.solve_block(*given, wanted=False)[0]
    temperature = np.zeros(len(given[0].index))
    seen = None if counts is None else (counts, np.nan)
    solve_compiled(*[model, *given, seen], into=temperature)
    return temperature


@dataclass(frozen=True, eq=False)
class Rows(Source):
    """A record in memory, and a mask of the rows that count."""

    record: Record
    counts: np.ndarray  # mask
    divided: dict = field(default_factory=dict, repr=False)  # by the size of a part

    @cached_property
    def count(self) -> Any:
        """How many rows count."""
        return int(np.count_nonzero(self.counts))

    @cached_property
    def step(self) -> Any:
        """Usual time between rows. [s]"""
        return self.record.inputs.step

    @property
    def wind(self) -> Any:
        """Mean wind speed of the record. [m/s]"""
        return self.record.inputs.mean("wind_speed")

    @cached_property
    def winds(self) -> Any:
        """Mean and spread of the wind over sunny rows that count. [m/s]"""
        wind = self.record["wind_speed"][self.counts]
        weight = self.record["poa_global"][self.counts] ** 2
        total = max(weight.sum(), np.finfo(float).tiny)
        # not by BLAS, whose last bits depend on the number of threads
        mean = (weight * wind).sum() / total
        return float(mean), float(np.sqrt((weight * (wind - mean) ** 2).sum() / total))

    @property
    def some_wind(self) -> np.ndarray:
        """Wind of the rows. [m/s]"""
        return self.record["wind_speed"]

    @property
    def row_masks(self) -> dict:
        """Masks of the rows, by purpose."""
        return {"train": self.counts}

    def uses_compiled_loops(self, model: ThermalModel) -> bool:
        """Whether the compiled loops can solve a model with known terms."""
        return uses_compiled_loops(len(self.record.index), model.effects)

    def parts(self, requests: Any) -> Any:
        """The record in blocks; see :meth:`Source.parts`."""
        inputs, dates, kept = self.record.inputs, self.record.dates, self.row_masks
        pasts = {key: one.model.past(inputs) for key, one in requests.items()}
        known = {
            key: one.model.with_known_terms(inputs, one.coefficients, one.wanted)
            for key, one in requests.items()
        }
        size = len(inputs.index)
        if not all(map(self.uses_compiled_loops, known.values())):
            size = BLOCK
        elif len(requests) > 1 or inputs.columns.narrow or known_effects(known):
            size = AT_ONCE  # terms and widened columns would take too much memory
        for block, part in self.in_blocks(size):
            given = {
                key: (known[key].on_rows(block), (part, one.coefficients, pasts[key]))
                for key, one in requests.items()
            }
            counts = {which: rows[block] for which, rows in kept.items()}
            yield Part(part["temp_module"], dates[block], counts), given

    def thinned(self) -> "Rows | None":
        """
        Every eighth block, for the start of a search; None if there are few.

        The blocks are joined to a record with gaps.
        """
        rows = np.arange(len(self.record.index))
        parts = [rows[part] for part in blocks(len(rows))[::EVERY]]
        if len(parts) < FEWEST:
            return None
        some = np.concatenate(parts)
        counts = self.counts[some]
        if 2 * EVERY * np.count_nonzero(counts) < self.count:
            return None
        inputs = self.record.inputs.at_rows(some)
        return Rows(replace(self.record, inputs=inputs), counts)

    def in_blocks(self, size: int) -> list:
        """The blocks of a size with their inputs, cached for all passes."""
        if size not in self.divided:
            places = blocks(len(self.record.index), size)
            self.divided[size] = [(p, self.record.inputs.part(p)) for p in places]
        return self.divided[size]


def known_effects(models: dict) -> bool:
    return any(model.effects for model in models.values())


def daily_sums(
    model: ThermalModel,
    coefficients: dict,
    source: Rows,
    at_bound: tuple,
    into: np.ndarray | None = None,
) -> DailySums:
    """
    Daily sums at a minimum, from one pass over a source.

    Parameters
    ----------
    model : ThermalModel
        The fitted model.
    coefficients : dict
        Of all its parameters, at the minimum.
    source : Rows
        The rows that count.
    at_bound : tuple of str
        Coefficients that are held fixed.
    into : numpy.ndarray, shape (rows,), optional
        Takes the temperature of all rows. [°C]

    Returns
    -------
    DailySums
        Of the free coefficients that are not at a bound.
    """
    names = tuple(name for name in model.free if name not in at_bound)
    sums_by_part, end = [], 0
    for part, given in source.parts({"": EvalRequest(model, coefficients)}):
        first, end = end, end + len(part.dates)
        known, own = given[""]
        answer = part.solve(known, own, "train", source.uses_compiled_loops(known))
        sums_by_part.append(
            answer.by_day(names, None if into is None else into[first:end])
        )
    dates, sums = joined_products(sums_by_part)
    return DailySums(names, cluster_sums_of(dates, sums, source.count), source.winds)
