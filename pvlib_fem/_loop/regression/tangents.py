"""Slopes of a model's temperature by its parameters, and by those of other effects."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Self

import numpy as np
import pandas as pd

from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem._record.inputs import Inputs
from pvlib_fem._relaxation import FADED
from pvlib_fem._thermal.model import ThermalModel
from pvlib_fem.drivers import derive_drivers, is_modelled
from pvlib_fem.effects._effect import Effect, Terms, linearised
from pvlib_fem.reasons import Because, Reason, because

FEW = 18  # effects of which the tangents are made at a time


@dataclass(frozen=True, eq=False)
class Tried:
    """What is tried first of an effect, or of a fault along its time profiles."""

    wide: Effect
    scan: Callable | None = None  # that takes the effect from the wide one
    time_profiles: tuple[Effect, ...] = ()  # whose dates are to be found
    heat_alone: bool = False  # or an offset, by measured drivers alone

    @property
    def names(self) -> list[str]:
        return [one.name for one in self.time_profiles or (self.wide,)]


def ready_effects(
    model: ThermalModel, inputs: Inputs, seen: np.ndarray, candidates: Iterable[Effect]
) -> tuple[Inputs, list[Tried], dict[str, Because]]:
    """
    Inputs with the drivers of all effects, what is tried of them, and why not.

    An effect that is scanned enters as the wide one from which its scan takes it, and
    all time profiles of a sensor fault as one constant fault, with those of other
    faults that have the same terms.

    Parameters
    ----------
    model : ThermalModel
    inputs : Inputs
    seen : array of bool, shape (rows,)
        Rows that count.
    candidates : iterable of Effect

    Returns
    -------
    Inputs, list of Tried, dict of Because
        The last by name of an effect that cannot be tried.
    """
    tried: dict[Any, Tried] = {}
    failed: dict[str, Because] = {}
    for effect in candidates:
        try:
            if effect.prepare:
                dated = derive_drivers(inputs, ["day"])
                effect = effect.prepare(dated.columns, seen)
            wide = effect
            if effect.scanned_from:
                wide = replace(effect.scanned_from, confounder=effect.confounder)
            key = wide.terms if effect.dates else effect.name
            if effect.dates and key in tried:
                time_profiles = (*tried[key].time_profiles, effect)
                tried[key] = replace(tried[key], time_profiles=time_profiles)
                continue
            wide = replace(wide, name=effect.sensor_fault) if effect.dates else wide
            inputs = replace(model, effects=(wide,)).with_drivers(inputs)
            time_profiles = (effect,) if effect.dates else ()
            tried[key] = Tried(wide, effect.scan, time_profiles)
        except Exception as error:  # whatever an effect does, the others go on
            failed[effect.name] = reason_of_error(error)
    return inputs, [*tried.values()], failed


def reason_of_error(error: Exception) -> Because:
    """Why an effect cannot be tried that raises an error of its own."""
    return because(Reason.BROKEN, error=f"{type(error).__name__}: {error}")


@dataclass(frozen=True, eq=False)
class Tangents:
    """Slopes of a model's temperature at some rows, from these and earlier rows."""

    model: ThermalModel  # which knows its effects on those that are read
    inputs: Inputs  # of those
    coefficients: dict[str, float]
    read: np.ndarray  # rows of the record
    places: np.ndarray  # of the requested rows among them

    @classmethod
    def from_model(
        cls,
        model: ThermalModel,
        inputs: Inputs,
        coefficients: dict[str, float],
        rows: np.ndarray,
    ) -> Self:
        """The tangents of a model at some rows, which are in order."""
        model = model.with_known_terms(inputs, coefficients)
        reach = FADED * model.longest_time_constant(inputs, coefficients)
        read = rows_within_reach(rows, inputs.seconds, reach)
        names = (*COLUMNS[:3], *model.drivers)
        inputs = inputs.only(names).at_rows(read)
        places = np.searchsorted(read, rows)
        return cls(model.on_rows(read), inputs, coefficients, read, places)

    def slopes(self, also: Mapping[str, Terms] | None = None) -> dict[str, np.ndarray]:
        """
        By the model's own parameters, or by further terms of all rows of the record.

        They are by name, on the requested rows.
        """
        wanted, further = also is None, also or {}
        terms = {
            name: gapless_terms(one.part(self.read)) for name, one in further.items()
        }
        slopes = self.model.slopes(self.inputs, self.coefficients, wanted, terms)[1]
        names = [*slopes] if wanted else terms
        return {name: slopes.pop(name)[self.places] for name in names}


def rows_within_reach(
    rows: np.ndarray, seconds: np.ndarray, reach: float
) -> np.ndarray:
    """Some rows, and those before each that are no older than so long. [s]"""
    ahead = np.full(len(seconds), np.inf)
    ahead[rows] = seconds[rows]
    ahead = np.minimum.accumulate(ahead[::-1])[::-1]
    return np.flatnonzero(ahead - seconds <= reach)


def tangents(
    tried: Sequence[Tried], failed: dict[str, Because], inputs: Inputs, at: Tangents
) -> Iterator[tuple[Tried, dict[str, np.ndarray]]]:
    """
    What is tried with the tangents of its parameters, one by one.

    Of a few at a time terms and slopes are held on many rows.

    Parameters
    ----------
    tried : sequence of Tried
    failed : dict of Because
        Takes the reasons of those whose terms raise an error.
    inputs : Inputs
        With the drivers of all.
    at : Tangents
        Of the model.

    Yields
    ------
    Tried, dict of array
        Its tangents by name of the parameter. [K per unit]
    """
    for first in range(0, len(tried), FEW):
        terms: dict[str, Terms] = {}
        there: list[Tried] = []
        for one in tried[first : first + FEW]:
            try:
                # slopes from where it adds nothing
                linear = linearised(one.wide, inputs.columns)
                terms |= linear.slopes(inputs.columns, one.wide.start)
                there.append(one)
            except Exception as error:
                failed |= dict.fromkeys(one.names, reason_of_error(error))
        slopes = at.slopes(terms)
        for one in there:
            keys = [*one.wide.rows()]
            own = {key: slopes.pop(key) for key in keys}
            scaled = any(terms[key].follows_temperature for key in keys)
            heat = not scaled and not is_modelled(one.wide.drivers)
            yield replace(one, heat_alone=heat), own


def gapless_terms(terms: Terms) -> Terms:
    """
    Terms over gaps as the kernel takes them: the next sample counts for all of it.

    So the rows after a gap have a memory; those in it do not count.
    """
    return Terms(
        *(gapless_column(getattr(terms, column.name)) for column in fields(terms))
    )


def gapless_column(column: np.ndarray | float) -> np.ndarray | float:
    """A column of terms with the next number in each gap, at its end the last one."""
    if not np.ndim(column) or not np.isnan(column).any():
        return column
    return pd.Series(column).bfill().ffill().to_numpy()
