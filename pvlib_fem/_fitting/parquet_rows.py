"""A record in files as the source of a fit: each pass solves several models."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._fitting.pass_state import (
    BlockRows,
    Gaps,
    by_day,
    rows_that_count,
    with_even_steps,
)
from pvlib_fem._fitting.row_source import EvalRequest, Part, Source, temperature_of
from pvlib_fem._fitting.streamed_lags import MEANS, Held, with_a_past
from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem._record.file_summary import Summary, digest_of
from pvlib_fem._record.inputs import Inputs, Record
from pvlib_fem._record.parquet import ParquetRecord
from pvlib_fem._record.resampling import Sums
from pvlib_fem._thermal.compiled import AT_ONCE, uses_compiled_loops
from pvlib_fem._thermal.model import BLOCK, ThermalModel, blocks
from pvlib_fem._thermal.response import Past
from pvlib_fem.drivers import is_modelled
from pvlib_fem.quality._parquet_screen import Screened, screened_blocks

PRESENT = 0.5  # share of the rows of a longer step that must not be missing


@dataclass(frozen=True, eq=False)
class Files(Source):
    """A screened record in files, and statistics from one pass over it."""

    screened: Screened
    night: bool
    drivers: tuple
    wind: float  # mean [m/s]
    usual: dict  # median step between rows that have some columns, in units
    dates: np.ndarray  # of all days
    rows: np.ndarray  # rows that count, per day
    light: np.ndarray  # daily sums of irradiance squared, also times wind and wind²
    means: Record  # on longer steps
    seen: dict  # masks, dates and steps of a block, by its first row
    out: np.ndarray = field(default_factory=lambda: np.zeros(0, int))  # dates held out

    @property
    def clean(self) -> Any:
        return self.screened.record

    @property
    def step(self) -> float:
        """Usual time between rows. [s]"""
        return self.screened.look.step

    @cached_property
    def summary(self) -> "FileSummary":
        """Size, times and gaps of the record."""
        look, source = self.screened.look, self.clean.source
        first, last = map(source.time_at, look.ends)
        names = tuple(n for n in self.clean.names if n not in source.absent)
        missing, faults = self.screened.missing, self.screened.impossible
        summary = FileSummary(
            rows=look.rows,
            days=len(self.dates),
            start=first,
            end=last,
            step=self.step,
            columns=names,
            missing={n: rows for n, rows in missing.items() if n in names},
            impossible={n: rows for n, rows in faults.items() if n in names},
            clipped=self.screened.clipped,
            sha256="",
        )
        vars(summary).pop("sha256")  # computed on access: it takes passes of its own
        vars(summary)["record"] = self.clean
        return summary

    def without(self, dates: np.ndarray) -> "Files":
        """The source with some days held out."""
        return replace(self, out=np.unique(dates))

    @cached_property
    def fitted(self) -> np.ndarray:
        """Mask of the days that are not held out."""
        return ~np.isin(self.dates, self.out)

    @property
    def count(self) -> int:
        """How many rows are fitted."""
        return int(self.rows[self.fitted].sum())

    @property
    def winds(self) -> Any:
        """Mean and spread of the wind over sunny fitted rows. [m/s]"""
        total, wind, squares = self.light[self.fitted].sum(axis=0)
        total = max(total, np.finfo(float).tiny)
        mean = wind / total
        return float(mean), float(np.sqrt(max(squares / total - mean**2, 0.0)))

    @property
    def some_wind(self) -> np.ndarray:
        """Wind of the first block. [m/s]"""
        return next(iter(self.clean.blocks()))["wind_speed"]

    def past(self, model: ThermalModel) -> Past:
        """The state before the first row of the record."""
        return Past(self.usual[self.drivers if model.drivers else ()])

    def parts(self, requests: Any) -> Any:
        """The record in parts of its blocks; see :meth:`Source.parts`."""
        pasts = {key: self.past(one.model) for key, one in requests.items()}
        bases = Bases(self, requests.values())
        for start, inputs in self.inputs(requests.values()):
            rows, dates = self.block_masks(start, len(inputs.index))
            for piece in blocks(len(inputs.index), self.at_once):
                here = bases.added_to(inputs.part(piece))
                given = {}
                for key, one in requests.items():
                    own = one.model.with_drivers(here), one.coefficients
                    known = one.model.with_known_terms(*own, one.wanted)
                    given[key] = known, (*own, pasts[key])
                counts = {which: at[piece] for which, at in rows.items()}
                yield Part(here["temp_module"], dates[piece], counts), given

    @property
    def at_once(self) -> int:
        """Rows that are solved at a time."""
        return AT_ONCE if uses_compiled_loops(len(self.clean), ()) else BLOCK

    def uses_compiled_loops(self, model: ThermalModel) -> bool:
        """Whether the compiled loops can solve a model with known terms."""
        return uses_compiled_loops(len(self.clean), model.effects)

    def held_out(self, dates: np.ndarray) -> np.ndarray:
        """Mask of held-out rows, by their dates."""
        return self.days_out[dates - self.dates[0]]

    @cached_property
    def days_out(self) -> np.ndarray:
        """Whether each day from the first to the last is held out."""
        days = np.arange(self.dates[0], self.dates[-1] + 1)
        return np.isin(days, self.out)

    def residuals(self, model: ThermalModel, coefficients: dict) -> Iterator:
        """Times and residual of all rows, block by block."""
        request, past = EvalRequest(model, coefficients), self.past(model)
        bases = Bases(self, [request])
        for block in self.clean.blocks():
            inputs, temperatures = with_even_steps(block), []
            for part in blocks(len(block), self.at_once):
                here = bases.added_to(inputs.part(part))
                own = model.with_drivers(here), coefficients
                known = model.with_known_terms(*own, False)
                given = (*own, past)
                temperatures.append(
                    temperature_of(known, given, self.uses_compiled_loops(known))
                )
            yield block.index, block["temp_module"] - np.concatenate(temperatures)

    def inputs(self, requests: Iterable) -> Iterator:
        """First row and inputs of all blocks, without times if nothing needs them."""
        sparse = all(seen.steps is not None for seen in self.seen.values())
        if not sparse or any(one.model.effects for one in requests):
            for block in self.clean.blocks():
                yield block.start, with_even_steps(block)
            return
        unit = self.screened.look.unit
        for start, columns in self.clean.values():
            rows = len(columns["poa_global"])
            steps = self.seen[start].steps_of(rows)
            yield start, Inputs(columns, steps, unit, pd.RangeIndex(rows), True)

    def block_masks(self, start: int, rows: int) -> tuple[dict, np.ndarray]:
        """Masks of the rows of a block by purpose, and their dates."""
        complete, counts, dates = self.seen[start].masks(rows)
        fitted = ~self.held_out(dates)
        kept = {"complete": complete & fitted, "train": counts & fitted}
        return kept | {"test": counts & ~fitted}, dates


class FileSummary(Summary):
    """A summary that computes its hash on access."""

    record: Any

    @cached_property
    def sha256(self) -> str:
        return digest_of(self.columns, self.record.blocks)


class Bases:
    """The temperature of the base model, continued from part to part."""

    def __init__(self, files: Files, requests: Iterable) -> None:
        models = (one.model for one in requests)
        needing = [model for model in models if is_modelled(model.effect_drivers)]
        self.model = needing[0] if needing else None
        if self.model:
            self.plain = replace(self.model, effects=(), base=None)
            self.past = files.past(self.plain)

    def added_to(self, inputs: Inputs) -> Inputs:
        """The inputs, completed by the columns of the base model."""
        if self.model is None:
            return inputs
        base = self.model.completed(self.model.base)
        temperature = self.plain.solve_block(inputs, base, self.past, wanted=False)[0]
        return self.model.based(inputs, temperature)


def screened_for(
    source: ParquetRecord,
    target: ThermalModel,
    limits: Any = None,
    check_units: bool = True,
) -> Screened:
    """
    The screened record of a fit in files.

    Parameters
    ----------
    source : ParquetRecord
        The files.
    target : ThermalModel
        The model to fit.
    limits : Limits, optional
        Thresholds of the screening.
    check_units : bool, default True
        Refuse columns that look to be in another unit.

    Returns
    -------
    Screened
        With the usual four columns and the drivers of the model.

    Raises
    ------
    ValueError
        If a column is missing, an effect uses the hours around a row, or the record
        is unusable.
    """
    refuse_memory(target)
    source.needing((*COLUMNS, *target.drivers))
    return screened_blocks(source, target.drivers, limits, check_units)


def first_pass(screened: Any, target: ThermalModel, night: bool) -> Files:
    """
    A screened record in files with statistics from one more pass.

    Parameters
    ----------
    screened : Screened
        From :func:`screened_for`.
    target : ThermalModel
        The model to fit.
    night : bool
        Whether night rows count, too.

    Returns
    -------
    Files
        Without held-out days. Its ``means`` are over a minute, or two usual steps if
        these are longer.
    """
    drivers = tuple(target.drivers)
    usual = screened.look.step if len(screened.record) > 1 else MEANS
    step = max(MEANS, 2.0 * usual)
    sums = Sums(step, PRESENT * step / usual)
    gaps = {(): Gaps(), drivers: Gaps()}
    wind, table, seen = np.zeros(2), {}, {}
    held = Held.for_drivers(target.effect_drivers, usual)
    for block in screened.record.blocks():
        sums.add(block.index, block.inputs.columns)
        held.add(block)
        for names, gap in gaps.items():
            columns = [block[name] for name in (*COLUMNS[:3], *names)]
            gap.add(columns, block.inputs.steps)
        speed = block["wind_speed"]
        there = np.isfinite(speed)
        wind += speed[there].sum(), there.sum()
        rows, dates = rows_that_count(block, night, drivers), block.dates
        complete = np.isfinite(sum(block[name] for name in COLUMNS))
        seen[block.start] = BlockRows.from_masks(
            complete, rows, dates, with_even_steps(block).steps
        )
        by_day(table, dates, rows, block["poa_global"] ** 2, speed)
    totals = np.array([table[date] for date in sorted(table)]).reshape(-1, 4)
    inputs = sums.inputs()
    absent = screened.record.source.absent
    missing = {n: rows for n, rows in screened.missing.items() if n not in absent}
    means = Record(inputs, missing, {}, 0, absent)
    for own in with_a_past(held.inputs() or inputs, target.effect_drivers):
        screened = replace(screened, record=screened.record.with_columns(own))
    return Files(
        screened,
        night,
        drivers,
        float(wind[0] / max(wind[1], 1)),
        {names: gap.usual for names, gap in gaps.items()},
        np.array(sorted(table)),
        totals[:, 0].astype(int),
        totals[:, 1:],
        means,
        seen,
    )


def refuse_memory(target: ThermalModel) -> None:
    """Refuse effects whose terms use the hours around a row."""
    for effect in target.effects:
        if "elapsed" in effect.drivers:
            raise ValueError(
                f"{effect.name} uses the hours around each row, and a block of a file "
                "may not have them; fit it to a DataFrame, for example of means over "
                "longer steps"
            )
