"""Evidence for effects that a fitted model lacks, from one pass over a record."""

from dataclasses import fields, replace

import numpy as np
import pandas as pd

from pvlib_fem.drivers import needed_for
from pvlib_fem.effects.effect import Terms
from pvlib_fem.loop.evidence import Evidence
from pvlib_fem.reasons import Reason, because
from pvlib_fem.relaxation import relax
from pvlib_fem.statistics.changes import Daily
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
    family : Family
        Number of hypotheses.
    fixed : sequence of str
        Coefficients that are held, or at a bound, where they stay.
    """
    model = replace(model, base=model.base or coefficients)
    inputs = model.with_base(model.with_drivers(record.inputs))
    inputs, effects, failed = ready(model, inputs, seen, candidates)
    also = {key: own for *_, terms in effects.values() for key, own in terms.items()}
    temperature, slopes = model.slopes(inputs, coefficients, also=also)
    base = [name for name in model.free if name not in fixed]
    more = misfits(temperature - coefficients["bias"], record)
    rows = np.flatnonzero(seen & np.isfinite(temperature))

    def tangents(slopes, names):
        return {name: np.ascontiguousarray(slopes[name][rows]) for name in names}

    found = Evidence(
        tangents({**slopes, **more}, (*base, *more)),
        (record["temp_module"] - temperature)[rows],
        record.dates[rows],
        rows,
        tuple(base),
        tuple(more),
        family=family,
        criteria=criteria,
    )

    def larger(found, wide, effect, known, none):
        """The same with an effect that its scan has found, or why there is none."""
        if effect is None:
            failed[wide.name] = none
            return found
        there = replace(model, effects=(effect,)).with_drivers(inputs)
        terms = terms_of(effect, there.columns)
        slopes = model.slopes(inputs, coefficients, wanted=False, also=terms)[1]
        return found.with_effect(effect, tangents(slopes, terms), known)

    scanned = []
    for name, (effect, search, terms) in effects.items():
        known = record.known(needed_for(effect.drivers))[rows]
        own = tangents(slopes, terms)
        if not all(np.isfinite(column[known]).all() for column in own.values()):
            failed[name] = because(Reason.NOT_A_NUMBER)
        elif search:
            scanned.append((effect, search, own, known))
        else:
            found = found.with_effect(effect, own, known)
    for wide, search, own, known in scanned:
        if search.scan:
            effect = narrowed(found, search, wide, own, known, inputs)
            found = larger(found, wide, effect, known, because(Reason.NO_WINDOW))
    daily = {}  # products by the day of a channel, which all its courses share
    dated = [one for one in scanned if not one[1].scan]
    for wide, search, own, known in dated:
        if search.channel not in daily:
            daily[search.channel] = Daily.of(*found.beside(wide, own, known))
    fading = (one.step_that_fades(criteria.change_side) for one in daily.values())
    sloped = max(fading, default=0.0)
    for wide, search, _, known in dated:
        of_channel = replace(daily[search.channel], sloped=sloped)
        effect = search.dates.found(of_channel, criteria)
        found = larger(found, wide, effect, known, because(Reason.NO_DATE))
    return replace(found, failed=failed)


def ready(model, inputs, seen, candidates):
    """
    Inputs with the drivers of all effects, those with search and terms, and why not.

    An effect that is scanned enters as the wide one from which its scan takes it.
    """
    effects, failed = {}, {}
    for effect in candidates:
        try:
            if effect.prepare:
                effect = effect.prepare(inputs.columns, seen)
            wide = effect.scanned_from or effect
            inputs = replace(model, effects=(wide,)).with_drivers(inputs)
            search = effect if effect.scan or effect.dates else None
            effects[effect.name] = wide, search, terms_of(wide, inputs.columns)
        except Exception as error:  # whatever an effect does, the others go on
            words = f"{type(error).__name__}: {error}"
            failed[effect.name] = because(Reason.BROKEN, error=words)
    return inputs, effects, failed


def terms_of(effect, columns):
    """Slopes of an effect's terms from where it adds nothing."""
    slopes = effect.slopes(columns, effect.start)
    return {key: held(slope) for key, slope in slopes.items()}


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


def narrowed(found, search, wide, own, known, inputs):
    """The effect where a scan of what is left shows it, or None."""
    places = {name: inputs[name][found.rows[known]] for name in wide.drivers}
    names, given = list(found.columns), found.places(found.confounders)
    tangents = own | {names[i]: found.columns[names[i]] for i in given}
    if not known.all():
        tangents = {key: column[known] for key, column in tangents.items()}
    rest = found.rest(found.confounders)[known]
    weeks = calendar_weeks(found.dates[known])
    return search.scan(rest, tangents, places, weeks, found.criteria)


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
