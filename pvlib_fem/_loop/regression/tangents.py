"""Tangents of a fitted model and of absent effects, row by row."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np
import pandas as pd

from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem._record.inputs import Inputs, Record
from pvlib_fem._relaxation import FADED, relax
from pvlib_fem._statistics.clusters import calendar_weeks
from pvlib_fem._statistics.weekly_sums import least_squares_coefficients
from pvlib_fem._thermal.model import ThermalModel
from pvlib_fem.drivers import derive_drivers, needed_for, own_columns
from pvlib_fem.effects._effect import Effect, Terms, linearised
from pvlib_fem.effects._time_profiles import scaled_terms, weights_of
from pvlib_fem.reasons import Because, Reason, because

FEW = 18  # effects of which the tangents are made at a time
#: of a step, from which a module temperature is not its mean but that of its end, which
#: is half a step early
EARLY = 0.125


@dataclass(frozen=True, eq=False)
class Evidence:
    """Tangents of a fitted model and of absent effects, and the remaining error."""

    #: a tangent of each coefficient, misfit and effect on ``rows``; NaN where the
    #: driver of an effect is missing [K per unit of the coefficient]
    columns: dict[str, np.ndarray] = field(repr=False)
    residual: np.ndarray = field(repr=False)  # measured minus modelled on ``rows`` [K]
    #: the same with what the model's changes of sensors and mounting explain [K]
    with_changes: np.ndarray = field(repr=False)
    dates: np.ndarray = field(repr=False)  # day of each of the rows, from 1970-01-01
    rows: np.ndarray = field(repr=False)  # of the record that count
    base: tuple[str, ...]  # the fitted coefficients
    #: columns of errors of the steady model's shape: functions of the usual inputs,
    #: which count for no effect
    misfits: tuple[str, ...]
    #: columns of each effect
    own: dict[str, tuple[str, ...]] = field(default_factory=dict)
    effects: dict[str, Effect] = field(default_factory=dict)
    #: effects that could not be tried
    failed: dict[str, Because] = field(default_factory=dict)
    #: of each effect, on how many of the rows its drivers are known
    known: dict[str, int] = field(default_factory=dict)
    #: changes whose dates are to be found, each with the column that it scales
    changing: tuple[tuple[Effect, str], ...] = ()

    def with_effect(
        self, effect: Effect, columns: dict[str, np.ndarray], known: np.ndarray
    ) -> "Evidence":
        """The evidence with the tangents of one more effect, on its known rows."""
        # an absent cause, such as snow that never stays, is not tested
        columns = {n: c for n, c in columns.items() if c[known].any()} or columns
        return replace(
            self,
            columns=self.columns | unknown_columns(columns, known),
            own=self.own | {effect.name: tuple(columns)},
            effects=self.effects | {effect.name: effect},
            known=self.known | {effect.name: int(known.sum())},
        )

    def with_changes_along(
        self,
        time_profiles: Iterable[Effect],
        columns: dict[str, np.ndarray],
        known: np.ndarray,
    ) -> "Evidence":
        """The evidence with the one tangent of a fault, which its changes scale."""
        (column,) = columns
        return replace(
            self,
            columns=self.columns | unknown_columns(columns, known),
            changing=(*self.changing, *((one, column) for one in time_profiles)),
        )

    def column_of_fault(self, sensor_fault: str) -> str | None:
        """The column that changes of a sensor fault scale, or None."""
        same = (c for one, c in self.changing if one.sensor_fault == sensor_fault)
        return next(same, None)

    @cached_property
    def without_shape(self) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """
        Both residuals given all functions of the usual inputs, and those.

        The first is that of the model, the second has what changes explain.
        """
        shapes = [n for n, effect in self.effects.items() if effect.confounder]
        names = [*self.base, *self.misfits, *(c for n in shapes for c in self.own[n])]
        table = np.column_stack([np.nan_to_num(self.columns[n]) for n in names])
        both = np.column_stack([self.residual, self.with_changes])
        both = both - table @ least_squares_coefficients(table, both)
        return both.T, {n: self.columns[n] for n in names}


def unknown_columns(
    columns: dict[str, np.ndarray], known: np.ndarray
) -> dict[str, np.ndarray]:
    """Columns that are unknown on some rows."""
    if known.all():
        return columns
    return {name: np.where(known, column, np.nan) for name, column in columns.items()}


def gather_evidence(
    model: ThermalModel,
    coefficients: dict[str, float],
    record: Record,
    seen: np.ndarray,
    candidates: Iterable[Effect],
    fixed: Collection[str],
    least: float,
    located: Mapping[str, Effect],
) -> Evidence:
    """
    Evidence for candidates given a model at its minimum.

    Parameters
    ----------
    model : ThermalModel
        Model with the effects that are fitted.
    coefficients : dict
        All of the model's.
    record : Record
        With every measured driver of the candidates.
    seen : array of bool, shape (rows,)
        Rows that count. Where a driver is missing they do not count for its effect.
    candidates : sequence of Effect
        Effects that are not in the model.
    fixed : sequence of str
        Coefficients that are held, or at a bound, where they stay.
    least : float
        Gain from which the edges of an obstacle before the sun are fitted. [K]
    located : dict of Effect
        Where scans of other models found effects, by name: another effect of this model
        may explain what they found.

    Returns
    -------
    Evidence
        Tangents of the model and of the candidates, and the residual.
    """
    # coefficients of its effects as they are fitted now
    model = replace(model, base={**coefficients, **(model.base or {})})
    inputs = model.with_base(model.with_drivers(record.inputs), ["temp_base"])
    inputs = model.based(inputs, inputs["temp_base"])
    inputs, tried, failed = ready_effects(model, inputs, seen, candidates)
    temperature = model.temperature(inputs, coefficients)
    rows = np.flatnonzero(seen & np.isfinite(temperature))
    # two tangents that contain a change in part would explain it between them
    changes = [effect for effect in model.effects if effect.sensor_fault]
    without_faults = replace(
        model, effects=tuple(e for e in model.effects if not e.sensor_fault)
    )
    at = Tangents.from_model(without_faults, inputs, coefficients, rows)
    before = (
        without_faults.temperature(inputs, coefficients) if changes else temperature
    )
    evidence = evidence_of_model(at, fixed, record, rows, temperature, before)
    evidence = replace(evidence, failed=failed)
    every = tangents(tried, failed, inputs, at)
    evidence, scanned = with_tangents(evidence, every, record)
    evidence = with_scanned(evidence, scanned, model, inputs, at, located, least)
    return with_secants(evidence, changes, without_faults, inputs, coefficients, before)


def evidence_of_model(
    at: "Tangents",
    fixed: Collection[str],
    record: Record,
    rows: np.ndarray,
    temperature: np.ndarray,
    before: np.ndarray,
) -> Evidence:
    """
    Evidence of the coefficients and misfits of a model, without candidates.

    Of two temperatures [°C], ``before`` is that without changes of sensors.
    """
    own = at.slopes()
    base = [n for n in at.model.free if n not in fixed and own[n].any()]
    wrong = shape_errors(before - at.coefficients["bias"], record, rows)
    residual = (record["temp_module"] - temperature)[rows]
    columns = {name: own[name] for name in base} | wrong
    if early := early_errors(before, record, rows, columns, residual):
        wrong, columns = wrong | early, columns | early
    return Evidence(
        columns,
        residual,
        (record["temp_module"] - before)[rows],
        record.dates[rows],
        rows,
        tuple(base),
        tuple(wrong),
    )


class Scanned(NamedTuple):
    """A wide effect with its tangents, of which a scan takes the effect."""

    scan: Callable
    wide: Effect
    own: dict[str, np.ndarray]
    known: np.ndarray  # rows on which its drivers are known


def with_tangents(
    evidence: Evidence,
    every: Iterable[tuple["Tried", dict[str, np.ndarray]]],
    record: Record,
) -> tuple[Evidence, list[Scanned]]:
    """The evidence with the tangents of all that is tried, and what is scanned."""
    scanned: list[Scanned] = []
    for one, own in every:
        known = record.complete_rows(needed_for(one.wide.drivers))[evidence.rows]
        if not all(np.isfinite(column[known]).all() for column in own.values()):
            why = because(Reason.NOT_A_NUMBER)
            evidence.failed.update(dict.fromkeys(one.names, why))
        elif one.scan:
            scanned.append(Scanned(one.scan, one.wide, own, known))
        elif one.time_profiles:
            evidence = evidence.with_changes_along(one.time_profiles, own, known)
        else:
            evidence = evidence.with_effect(one.wide, own, known)
    return evidence, scanned


def with_scanned(
    evidence: Evidence,
    scanned: Sequence[Scanned],
    model: ThermalModel,
    inputs: Inputs,
    at: "Tangents",
    located: Mapping[str, Effect],
    least: float,
) -> Evidence:
    """
    The evidence with the effects that scans of the remaining error find.

    Functions of the usual inputs are scanned first: an obstacle is searched for given
    these.
    """
    for shapes in (True, False):
        unlocated = evidence
        for one in scanned:
            name, not_found = one.wide.name, one.wide.not_found
            if one.wide.confounder is not shapes:
                continue
            narrow = narrowed(unlocated, one, model, inputs, at, least)
            narrow = narrow or located.get(name)
            if narrow is None:
                evidence.failed[name] = because(not_found)
                continue
            there = replace(model, effects=(narrow,)).with_drivers(inputs)
            for _, own in tangents([Tried(narrow)], evidence.failed, there, at):
                evidence = evidence.with_effect(narrow, own, one.known)
    return evidence


def narrowed(
    evidence: Evidence,
    scanned: Scanned,
    model: ThermalModel,
    inputs: Inputs,
    at: "Tangents",
    least: float,
) -> Effect | None:
    """The effect that a scan finds; if that has a scan, what this finds near it."""
    found = located_effect(evidence, scanned, inputs, least)
    if found is None or not found.scan:
        return found
    wide = found.scanned_from or found
    there = replace(model, effects=(wide,)).with_drivers(inputs)
    for _, own in tangents([Tried(wide)], evidence.failed, there, at):
        again = Scanned(found.scan, wide, own, scanned.known)
        return narrowed(evidence, again, model, there, at, least)
    return None


def with_secants(
    evidence: Evidence,
    changes: Iterable[Effect],
    model: ThermalModel,
    inputs: Inputs,
    coefficients: dict[str, float],
    before: np.ndarray,
) -> Evidence:
    """
    The evidence with the response to each change in the model in place of its tangent.

    The model is that without changes, and ``before`` its temperature. [°C]
    """
    columns = dict(evidence.columns)
    for effect in changes:
        column = evidence.column_of_fault(effect.sensor_fault)
        if column is not None and coefficients[next(iter(effect.rows()))]:
            dates = evidence.dates
            response = secant(model, inputs, effect, coefficients, dates, before)
            unknown = np.isnan(columns[column])
            columns[column] = np.where(unknown, np.nan, response[evidence.rows])
    return replace(evidence, columns=columns)


def secant(
    model: ThermalModel,
    inputs: Inputs,
    effect: Effect,
    coefficients: dict[str, float],
    dates: np.ndarray,
    before: np.ndarray,
) -> np.ndarray:
    """
    Effect of a change in the model on the temperature, per unit of its size. [K]

    The tangent is too small for a large change: a third less loss warms by a half. The
    model is that without changes, and ``before`` its temperature. [°C]
    """
    sensor_fault, (size,) = scaled_terms(effect).sensor_fault, effect.rows()
    weights = weights_of(effect, dates)
    there = coefficients[size] * float(np.mean(weights[weights > 0.0]))
    (row,) = sensor_fault.rows()
    with_it = replace(model, effects=(*model.effects, sensor_fault))
    return (with_it.temperature(inputs, {**coefficients, row: there}) - before) / there


@dataclass(frozen=True, eq=False)
class Tried:
    """What is tried first of an effect, or of a fault along its time profiles."""

    wide: Effect
    scan: Callable | None = None  # that takes the effect from the wide one
    time_profiles: tuple[Effect, ...] = ()  # whose dates are to be found

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

    Of a few at a time terms and slopes are held on many rows. ``failed`` takes the
    reasons of those whose terms raise an error.
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
            yield one, {key: slopes.pop(key) for key in one.wide.rows()}


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


def located_effect(
    evidence: Evidence, scanned: Scanned, inputs: Inputs, least: float
) -> Effect | None:
    """
    The effect where a scan of the remaining error shows it, or None.

    A change that is in the model may stand for an effect with a driver of its own, such
    as a trend for dirt since the last rain. So this is searched in both together.
    """
    scan, wide, own, known = scanned
    drivers = wide.drivers
    places = {name: inputs[name][evidence.rows[known]] for name in drivers}
    (rest, with_changes), shapes = evidence.without_shape
    if own_columns(drivers):
        rest = with_changes
    # of a shape whose driver is missing, as in the residual
    columns = {key: np.nan_to_num(c[known]) for key, c in (own | shapes).items()}
    weeks = calendar_weeks(evidence.dates[known])
    return scan(rest[known], columns, places, weeks, least)


def shape_errors(
    temperature: np.ndarray, record: Record, rows: np.ndarray
) -> dict[str, np.ndarray]:
    """
    Errors of a misshapen steady model at some rows, given other confounders.

    Functions of the usual inputs alone, which every cause without a driver of its own
    shares: curvature in the over-temperature, its fall with air temperature, a slower
    mass, a record that is late, and a sky that follows the air. The temperature [°C] is
    that without bias and without changes of instruments.
    """
    air, hour = record["temp_air"], 3600.0 / record.inputs.unit
    over = temperature - air
    slow = relax(np.nan_to_num(over), record.inputs.steps, hour)[rows]
    late = slope_from_before(temperature, record)
    over = over[rows]
    columns = {
        "curved": over * np.sqrt(np.abs(over)),
        "warm": over * (air[rows] - np.nanmean(air)),
        "slow": slow - over,
        "late": np.nan_to_num(late[rows]),
        "air": air[rows] - np.nanmean(air),
    }
    return {f"misfit:{name}": column for name, column in columns.items()}


def early_errors(
    temperature: np.ndarray,
    record: Record,
    rows: np.ndarray,
    others: dict[str, np.ndarray],
    residual: np.ndarray,
) -> dict[str, np.ndarray]:
    """
    Error of a module temperature at the end of each step, whose irradiance is a mean.

    It is half a step early, by the slope to the next row. Where all columns are means,
    it is not early, and there is no such error.
    """
    after = np.append(slope_from_before(temperature, record)[1:], 0.0)
    early = np.nan_to_num(after[rows])
    table = np.column_stack([np.nan_to_num(c) for c in (*others.values(), early)])
    size = least_squares_coefficients(table, residual[:, None])[-1, 0]
    if size < EARLY * np.median(unit_steps(record)):
        return {}
    return {"misfit:early": early}


def slope_from_before(temperature: np.ndarray, record: Record) -> np.ndarray:
    """Change of a temperature from the row before, per unit of the record's steps."""
    return np.diff(temperature, prepend=temperature[:1]) / unit_steps(record)


def unit_steps(record: Record) -> np.ndarray:
    """Steps of a record; the first row has none before it."""
    return np.maximum(record.inputs.steps, 1.0)
