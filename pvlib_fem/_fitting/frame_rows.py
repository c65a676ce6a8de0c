"""A record in memory as the source of a fit."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._fitting.daily import DailySums
from pvlib_fem._fitting.fem_fit import FemFit, of_rows
from pvlib_fem._fitting.fit_stages import flatness, minima, minimise
from pvlib_fem._fitting.holdout import held_out
from pvlib_fem._fitting.row_source import Rows
from pvlib_fem._fitting.search import natural_coefficients, with_tables
from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem._record.filters import counted
from pvlib_fem._record.inputs import Record, as_record
from pvlib_fem._statistics.leastsquares import Minimum
from pvlib_fem._thermal.model import ThermalModel
from pvlib_fem.quality._screen import screened
from pvlib_fem.quality._unit_checks import oddities

ROUGHER = 1e-5  # relative fall of the cost that ends a search on a part of the rows


@dataclass(frozen=True, eq=False)
class Frame(Rows):
    """A record in memory; its ``counts`` are the fitted rows."""

    test: np.ndarray = field(kw_only=True)  # rows that count and are held out
    out: np.ndarray = field(kw_only=True)  # all rows that are held out
    night: bool = field(default=False, kw_only=True)

    kind = FemFit

    @classmethod
    def from_record(
        cls, record: Record, counts: np.ndarray, out: np.ndarray, night: bool = False
    ) -> "Frame":
        """The source of a record, by masks of rows that count and are held out."""
        return cls(record, counts & ~out, test=counts & out, out=out, night=night)

    @cached_property
    def row_masks(self) -> dict:
        """Masks of the rows, by purpose."""
        complete = np.isfinite(sum(self.record[name] for name in COLUMNS)) & ~self.out
        return {"train": self.counts, "test": self.test, "complete": complete}

    def search_start(self, target: ThermalModel) -> dict:
        """Start of the first step's search."""
        return {name: row.start for name, row in target.parameters.items()}

    def minima(
        self, steps: list, start: dict, final: bool
    ) -> tuple[dict, Minimum, dict]:
        """
        Models and coefficients of some steps, the last minimum, and the next start.

        Each step begins at the minimum before it. The shift from one step to the next
        is nearly equal on a part of the rows, so steps without effects are searched on
        a part first.
        """
        flat, whole = flatness(steps, final), self.rows_for(steps[-1][1])
        stages, thin, some, before = {}, start, None, None
        for name, model, which, biased in steps:
            if which != before:
                some = None if model.effects else self.thinned_rows(which)
                before = which
            if some:
                last, (_, thin) = thin, minimise(model, some, thin, biased, ROUGHER)
                start = {n: value + thin[n] - last[n] for n, value in start.items()}
            step = (name, with_tables(model, whole.record), which, biased)
            minimum, start = minima(whole, [step], {name: start}, flat)[name]
            stages[name] = (model, natural_coefficients(model, start)[0])
        return stages, minimum, start

    def thinned_rows(self, which: str) -> Any:
        """A part of the rows that count for a purpose; None if they are few."""
        return Rows(self.record, self.row_masks[which]).thinned()

    def rows_for(self, model: ThermalModel) -> "Frame":
        """The source, completed by the drivers of a model's effects."""
        if not model.effects:
            return self
        inputs = model.with_drivers(self.record.inputs)
        return replace(self, record=replace(self.record, inputs=inputs), divided={})

    def result_parts(
        self, requests: dict, last: str, names: tuple
    ) -> tuple[DailySums, dict]:
        """Daily sums of the last step, and the attributes of a result from the rows."""
        whole, temperature = (
            self.rows_for(requests[last].model),
            np.empty(len(self.counts)),
        )
        table, daily = whole.scores_and_sums(requests, last, names, temperature)
        own = of_rows(whole.record, temperature, self.counts, self.test, self.out)
        return daily, {**own, "scores": table}

    def notes(self, target: ThermalModel) -> list:
        """Notes on results that do not come from the rows: none."""
        return []


def as_frame(
    columns: list,
    drivers: dict,
    target: ThermalModel,
    holdout: pd.Series | None,
    night: bool,
    limits: Any,
    check_units: bool,
) -> tuple[Frame, list]:
    """
    A user's columns as the source of a fit, and notes on them.

    Parameters
    ----------
    columns : list of pandas.Series, shape (rows,)
        ``poa_global`` [W/m²], ``temp_air`` [°C], ``wind_speed`` [m/s] and
        ``temp_module`` [°C], with a DatetimeIndex. ``wind_speed`` may be None for a
        model without wind.
    drivers : dict of pandas.Series, shape (rows,)
        Columns that the effects need, by name.
    target : ThermalModel
        The model to fit.
    holdout : pandas.Series of bool, shape (rows,), or None
        Rows to hold out; None for the default.
    night : bool
        Whether night rows count, too.
    limits : Limits or None
        Thresholds of the screening; None for the defaults.
    check_units : bool
        Refuse columns that look to be in another unit.

    Returns
    -------
    Frame, list of str
        The screened record, and notes on faults and oddities.

    Raises
    ------
    ValueError
        If the record is unusable, or ``holdout`` has other rows.
    """
    record, faults = screened(as_record(*columns, **drivers), limits, check_units)
    counts = counted(record.inputs.columns, night)
    counts &= record.complete_rows(target.drivers)
    notes = [*faults.notes, *oddities(record.inputs, limits, record.absent)]
    out = held_out(record, counts, holdout, notes)
    return Frame.from_record(record, counts, out, night), notes
