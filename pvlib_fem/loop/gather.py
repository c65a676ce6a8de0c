"""Evidence for effects that a fitted model lacks, from one pass over a record."""

from dataclasses import fields, replace

import numpy as np
import pandas as pd

from pvlib_fem.drivers import needed_for
from pvlib_fem.effects.effect import Terms
from pvlib_fem.loop.evidence import Evidence
from pvlib_fem.reasons import Reason, because
from pvlib_fem.relaxation import relax
from pvlib_fem.statistics.clusters import calendar_weeks


def gather(
    model, coefficients, record, seen, candidates, criteria, family, fixed=()
) -> Evidence:
    """
    Evidence for candidates beside a model at its minimum.

    Parameters
    ----------
    model : ThermalModel
    coefficients : dict
        All of the model's.
    record : Record
        With every measured driver of the candidates.
    seen : array of bool
        Rows that count. Where a driver lacks they do not count for its effect.
    candidates : sequence of Effect
    criteria : Criteria
    family : int
        Number of hypotheses.
    fixed : sequence of str
        Coefficients that are held, or at a bound, where they stay.
    """
    also, own, failed, effects = {}, {}, {}, {}
    model = replace(model, base=model.base or coefficients)
    inputs = model.with_base(model.with_drivers(record.inputs))
    scans = {}
    for effect in candidates:
        try:
            if effect.prepare:
                effect = effect.prepare(inputs.columns, seen)
            wide = effect.scanned_from or effect
            inputs = replace(model, effects=(wide,)).with_drivers(inputs)
            start = {key: row.start for key, row in wide.rows().items()}
            slopes = wide.slopes(inputs.columns, start)
        except Exception as error:  # whatever an effect does, the others go on
            words = f"{type(error).__name__}: {error}"
            failed[effect.name] = because(Reason.BROKEN, error=words)
            continue
        if effect.scan:
            scans[effect.name] = effect.scan
        also |= {key: held(slope) for key, slope in slopes.items()}
        own[effect.name], effects[effect.name] = tuple(slopes), wide
    temperature, slopes = model.slopes(inputs, coefficients, also=also)
    base = [name for name in model.free if name not in fixed]
    more = misfits(temperature - coefficients["bias"], record)
    slopes = {**slopes, **more}
    rows = np.flatnonzero(seen & np.isfinite(temperature))
    columns = {
        name: np.ascontiguousarray(slopes[name][rows]) for name in (*base, *more, *also)
    }
    partial = {}
    for name, effect in list(effects.items()):
        known = record.known(needed_for(effect.drivers))[rows]
        if not all(np.isfinite(columns[key][known]).all() for key in own[name]):
            failed[name] = because(Reason.NOT_A_NUMBER)
            for key in own.pop(name):
                del columns[key]
            del effects[name]
        elif not known.all():
            partial[name] = known
            for key in own[name]:
                columns[key] = np.where(known, columns[key], np.nan)
    found = Evidence(
        columns,
        (record["temp_module"] - temperature)[rows],
        record.dates[rows],
        rows,
        tuple(base),
        tuple(more),
        own,
        effects,
        failed,
        partial,
        family,
        criteria,
    )
    for name, scan in scans.items():
        if name in effects:
            found = narrowed(found, name, scan, model, coefficients, inputs)
    return found


def held(terms):
    """
    Terms over gaps as the kernel takes them: the next sample counts for all of it.

    So the rows after a gap have a memory; those in it do not count.
    """
    columns = (getattr(terms, column.name) for column in fields(terms))
    return Terms(
        *(
            pd.Series(column).bfill().ffill().to_numpy()
            if np.ndim(column) and np.isnan(column).any()
            else column
            for column in columns
        )
    )


def narrowed(found, name, scan, model, coefficients, inputs):
    """The evidence with an effect only where a scan of what is left shows it."""
    keys, known = found.own[name], found.partial.get(name)
    rows = found.rows if known is None else found.rows[known]
    some = slice(None) if known is None else known
    places = {n: inputs[n][rows] for n in found.effects[name].drivers}
    without = found.without(name)
    names = list(found.columns)
    given = [names[i] for i in found.places(without.confounders)]
    tangents = {key: found.columns[key][some] for key in (*keys, *given)}
    rest = without.rest(without.confounders)[some]
    weeks = calendar_weeks(found.dates[some])
    effect = scan(rest, tangents, places, weeks, found.criteria)
    if effect is None:
        failed = {**found.failed, name: because(Reason.NO_WINDOW)}
        return replace(without, failed=failed)
    start = {row: table.start for row, table in effect.rows().items()}
    there = replace(model, effects=(effect,)).with_drivers(inputs).columns
    also = {key: held(slope) for key, slope in effect.slopes(there, start).items()}
    slopes = model.slopes(inputs, coefficients, also=also)[1]
    better = without
    for key in start:
        column = np.ascontiguousarray(slopes[key][found.rows])
        if known is not None:
            column = np.where(known, column, np.nan)
        better = better.with_column(key, column)
    return replace(
        better,
        own={**better.own, name: tuple(start)},
        effects={**better.effects, name: effect},
        partial=better.partial | ({} if known is None else {name: known}),
        ready=better.ready if known is None else {},
    )


def misfits(temperature, record):
    """
    What a misshapen steady model leaves beside the confounders that are effects.

    Functions of the usual inputs alone, which every cause without a driver of
    its own shares: curvature in the over-temperature, its fall with air
    temperature, a slower mass, and a record that is late.
    """
    air, hour = record["temp_air"], 3600.0 / record.inputs.unit
    over = temperature - air
    known = np.nan_to_num(over)
    steps = np.maximum(record.inputs.steps, 1.0)  # the first has no row before it
    columns = {
        "curved": over * np.sqrt(np.abs(over)),
        "warm": over * (air - np.nanmean(air)),
        "slow": relax(known, record.inputs.steps, hour) - over,
        "late": np.nan_to_num(np.diff(temperature, prepend=temperature[:1]) / steps),
    }
    return {f"misfit:{name}": column for name, column in columns.items()}
