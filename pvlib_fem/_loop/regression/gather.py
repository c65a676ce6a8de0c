"""Evidence for candidates given a fitted model, row by row."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace

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
from pvlib_fem.effects._time_profiles import scaled_terms, weights_of
from pvlib_fem.reasons import Reason, because


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
    evidence = Scans(model, inputs, at, least).added(evidence, scanned, located)
    return with_secants(evidence, changes, without_faults, inputs, coefficients, before)


def evidence_of_model(
    at: Tangents,
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
