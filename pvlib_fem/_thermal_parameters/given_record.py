"""The record that some rows need: the fit's own, or a given one."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.column_names import COLUMNS, with_aliases
from pvlib_fem._record.filters import counted
from pvlib_fem._record.inputs import Inputs, Record, as_record
from pvlib_fem._translation import QUANTILES, USUAL_WINDS
from pvlib_fem.quality._screen import screened

NEEDED = "needs the record; give data"


@dataclass(frozen=True, eq=False)
class Measured:
    """
    A checked record and its rows.

    Attributes
    ----------
    fit : FemFit
    record : Record
    counts, out : array of bool
        Masks of rows that count in a fit, and of held-out rows.
    """

    fit: Any
    record: Record
    counts: np.ndarray
    out: np.ndarray

    @property
    def step(self) -> Any:
        return self.record.inputs.step

    @property
    def dates(self) -> np.ndarray:
        return self.record.dates

    @property
    def wind(self) -> float:
        return float(np.nanmean(self.record["wind_speed"]))

    def series(self, name: str) -> pd.Series:
        return pd.Series(self.record[name], self.record.index, name=name)

    @cached_property
    def winds(self) -> np.ndarray:
        """
        Representative winds of the record with equal weights. [m/s]

        They are quantiles over the rows that count, weighted by irradiance squared, as
        in least squares of the temperature.
        """
        poa = self.record["poa_global"][self.counts]
        wind = self.record["wind_speed"][self.counts]
        order = np.argsort(wind)
        weight = np.cumsum(poa[order] ** 2)
        unknown = "wind_speed" in self.record.absent
        if unknown or not len(wind) or not weight[-1] > 0.0:
            return USUAL_WINDS
        return wind[order][np.searchsorted(weight, QUANTILES * weight[-1])]

    @cached_property
    def inputs(self) -> Inputs:
        """The inputs of the record, completed by the drivers of the fit's effects."""
        return self.fit.thermal_model.with_drivers(self.record.inputs)

    @cached_property
    def modelled(self) -> tuple[np.ndarray, np.ndarray, dict]:
        """Temperature of the fit, and the steady temperature with its slopes."""
        model = self.fit.thermal_model
        completed = model.completed(self.fit.coefficients)
        without_memory = replace(model, dynamics="steady")
        steady, slopes = without_memory.slopes(self.inputs, completed)
        own = [*model.steady_model.parameters, "bias"]
        free = {name: slopes[name] for name in own if name not in model.held}
        return model.temperature(self.inputs, completed), steady, free

    @cached_property
    def known_effects(self) -> Any:
        """Cache of :meth:`effects`, by the coefficients."""
        return {}

    def effects(self, coefficients: Any) -> Any:
        """
        Mean steady temperature that the effects add on fitted rows. [K]

        It is weighted by irradiance squared, as in least squares of the
        over-temperature.
        """
        model, key = self.fit.thermal_model, tuple(coefficients.values())
        if not model.effects:
            return 0.0
        if key not in self.known_effects:
            completed = model.completed(coefficients)
            steady = replace(model, dynamics="steady")
            plain = replace(steady, effects=())
            added, without = (
                m.temperature(self.inputs, completed) for m in (steady, plain)
            )
            weight = self.record["poa_global"][self.counts] ** 2
            change = (added - without)[self.counts]
            self.known_effects[key] = float(np.average(change, weights=weight))
        return self.known_effects[key]


def measured_of(
    fit: Any, data: pd.DataFrame | None, out_of: Callable, holdout: Any = None
) -> Measured | None:
    """
    Check the given record or that of a fit; None without both.

    Parameters
    ----------
    fit : FemFit
    data : DataFrame or None
    out_of : callable
        Function from a record, its fitted rows and ``holdout`` to the held-out rows.
    holdout : Series of bool or None

    Returns
    -------
    Measured or None

    Raises
    ------
    ValueError
        If a column is missing, or ``holdout`` is given without a record.
    """
    model = fit.thermal_model
    if data is None:
        if holdout is not None:
            raise ValueError(
                "holdout is for data; the fit's own record keeps its held-out days"
            )
        if fit.record is None:
            return None
        record, out = fit.record, fit.holdout.to_numpy()
    else:
        columns = with_aliases(data, (*model.usual, "temp_module", *model.drivers))
        usual = [columns.get(name) for name in COLUMNS]
        drivers = {name: columns[name] for name in model.drivers}
        record, _ = screened(as_record(*usual, **drivers))
        out = None
    counts = counted(record.inputs.columns, fit.night)
    counts = counts & record.complete_rows(model.drivers)
    if out is None:
        out = out_of(record, counts, holdout)
    return Measured(fit, record, counts, out)
