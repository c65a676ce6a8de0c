"""Evidence for candidates given a fitted model, row by row."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from pvlib_fem._loop.regression.evidence import Evidence
from pvlib_fem._loop.regression.misfits import early_errors, shape_errors
from pvlib_fem._loop.regression.scans import Scanned, Scans
from pvlib_fem._loop.regression.tangents import (
    Tangents,
    Tried,
    ready_effects,
    tangents,
)
from pvlib_fem._record.inputs import Inputs, Record
from pvlib_fem._thermal.model import ThermalModel
from pvlib_fem.drivers import needed_for
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import (
    follows_sun_alone,
    scaled_terms,
    weights_of,
)
from pvlib_fem.reasons import Reason, because


@dataclass(frozen=True, eq=False)
class Linearisation:
    """
    A model at its minimum, and the rows on which its tangents are made.

    Attributes
    ----------
    model : ThermalModel
        Model with the effects that are fitted.
    coefficients : dict
        All of the model's.
    record : Record
        With every measured driver of the candidates.
    seen : ndarray of bool, shape (rows,)
        Rows that count. Where a driver is missing they do not count for its effect.
    fixed : sequence of str
        Coefficients that are held, or at a bound, where they stay.
    least : float
        Gain from which the edges of an obstacle before the sun are fitted. [K]
    """

    model: ThermalModel
    coefficients: dict[str, float]
    record: Record
    seen: np.ndarray
    fixed: Collection[str]
    least: float

    def evidence(
        self, candidates: Iterable[Effect], located: Mapping[str, Effect]
    ) -> Evidence:
        """
        Tangents of the model and of candidates, and the residual.

        Candidates are not in the model. ``located`` are effects where scans of other
        models found them, by name: another effect of this model may explain what they
        found.
        """
        coefficients, record = self.coefficients, self.record
        # coefficients of its effects as they are fitted now
        base = {**coefficients, **(self.model.base or {})}
        model = replace(self.model, base=base)
        inputs = model.with_base(model.with_drivers(record.inputs), ["temp_base"])
        inputs = model.based(inputs, inputs["temp_base"])
        inputs, tried, failed = ready_effects(model, inputs, self.seen, candidates)
        temperature = model.temperature(inputs, coefficients)
        rows = np.flatnonzero(self.seen & np.isfinite(temperature))
        # two tangents that contain a change or an obstacle in part would explain it
        # between them
        changes = [effect for effect in model.effects if effect.sensor_fault]
        obstacles = [*filter(follows_sun_alone, model.effects)]
        with_obstacles = without(changes, model)
        plain = without(obstacles, with_obstacles)
        at = Tangents.from_model(plain, inputs, coefficients, rows)
        own, explained, before = at.slopes(), temperature, temperature
        if changes:
            explained = before = with_obstacles.temperature(inputs, coefficients)
        if obstacles:
            there = Tangents.from_model(with_obstacles, inputs, coefficients, rows)
            own = there.slopes() | own
            before = plain.temperature(inputs, coefficients)
        free = [name for name in with_obstacles.free if name not in self.fixed]
        of_model = {name: own[name] for name in free if own[name].any()}
        measured = record["temp_module"]
        residuals = (measured - temperature)[rows], (measured - explained)[rows]
        bias = coefficients["bias"]
        evidence = evidence_of_model(of_model, record, rows, residuals, before, bias)
        heat_alone = frozenset(
            effect.name
            for effect in model.effects
            if not effect.at(inputs.columns, coefficients).follows_temperature
        )
        evidence = replace(evidence, failed=failed, heat_alone=heat_alone)
        every = tangents(tried, failed, inputs, at)
        evidence, scanned = with_tangents(evidence, every, record)
        scans = Scans(model, inputs, at, self.least)
        evidence = scans.added(evidence, scanned, located)
        return with_secants(evidence, changes, plain, inputs, coefficients, before)

    def without_each(
        self, effects: Iterable[Effect], evidence: Evidence
    ) -> Iterator[tuple[Effect, Evidence]]:
        """
        Each of some effects with the evidence by the model without it.

        Effects that no tangent contains are skipped. The candidates are the effect
        itself and all of the ``evidence`` by the whole model, where that found them,
        but for tangents that stay the same.
        """
        there = {effect.sensor_fault for effect in self.model.effects}
        seen = np.zeros_like(self.seen)
        seen[evidence.rows] = True
        for one in effects:
            if one.sensor_fault or follows_sun_alone(one):
                continue
            same = evidence.heat_alone if one.name in evidence.heat_alone else ()
            found = [e for name, e in evidence.effects.items() if name not in same]
            changing = [
                effect
                for effect, column in evidence.changing
                if column not in same or effect.sensor_fault in there
            ]
            candidates = [
                replace(effect.unscanned, prepare=None) for effect in (one, *found)
            ]
            other = replace(self, model=without([one], self.model), seen=seen)
            yield one, other.evidence([*candidates, *changing], {})


def without(effects: Collection[Effect], model: ThermalModel) -> ThermalModel:
    """A model without some of its effects."""
    kept = tuple(one for one in model.effects if one not in effects)
    return replace(model, effects=kept)


def evidence_of_model(
    base: dict[str, np.ndarray],
    record: Record,
    rows: np.ndarray,
    residuals: tuple[np.ndarray, np.ndarray],
    before: np.ndarray,
    bias: float,
) -> Evidence:
    """
    Evidence of the coefficients and misfits of a model, without candidates.

    The first of two residuals is that of the model, the second has what its changes
    explain. [K] ``before`` is its temperature without changes and obstacles. [°C]
    """
    residual, with_changes = residuals
    wrong = shape_errors(before - bias, record, rows)
    columns = base | wrong
    if early := early_errors(before, record, rows, columns, residual):
        wrong, columns = wrong | early, columns | early
    dates = record.dates[rows]
    return Evidence(
        columns, residual, with_changes, dates, rows, tuple(base), tuple(wrong)
    )


def with_tangents(
    evidence: Evidence,
    every: Iterable[tuple[Tried, dict[str, np.ndarray]]],
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
        if one.heat_alone:
            names = one.wide.name, *one.wide.rows()
            evidence = replace(evidence, heat_alone=evidence.heat_alone.union(names))
    return evidence, scanned


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

    The model is that without changes and obstacles, and ``before`` its temperature.
    [°C]
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
    model is that without it, and ``before`` its temperature. [°C]
    """
    sensor_fault, (size,) = scaled_terms(effect).sensor_fault, effect.rows()
    weights = weights_of(effect, dates)
    there = coefficients[size] * float(np.mean(weights[weights > 0.0]))
    (row,) = sensor_fault.rows()
    with_it = replace(model, effects=(*model.effects, sensor_fault))
    return (with_it.temperature(inputs, {**coefficients, row: there}) - before) / there
