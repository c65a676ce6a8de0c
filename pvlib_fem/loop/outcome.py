"""What a search came to, as a finished thing."""

from dataclasses import replace

import numpy as np
import pandas as pd

from pvlib_fem import scores
from pvlib_fem.effects.courses import changes_of
from pvlib_fem.fitting.daily import errors
from pvlib_fem.fitting.fit import finished
from pvlib_fem.loop.budget import budget_of, episodes_of
from pvlib_fem.loop.case import BASES
from pvlib_fem.loop.ranges import with_ranges
from pvlib_fem.loop.remains import hints, not_seen, tables_left, unexplained
from pvlib_fem.loop.result import Loop
from pvlib_fem.loop.structure import sorting
from pvlib_fem.loop.table import Ranking, table_of
from pvlib_fem.loop.weeks import Part, named
from pvlib_fem.loop.weights import as_row, ranked
from pvlib_fem.reasons import Reason, because
from pvlib_fem.record.columns import DAYLIGHT

SCORES = [
    f"{name}_{part}" for part in ("train", "test") for name in ("rmse", "mae", "mbe")
]


def outcome(search, last, base):
    """All that was found, as a finished thing."""
    case, found, notes = search.case, search.left, []
    if case.record is not case.whole:
        search.fits.let_go("coarse")
    record = case.placed_for(case.whole, last.model)
    at_bound, daily = last.at_bound, search.fits.daily(last)
    stderr = errors(last.model, daily, at_bound, notes)
    table = error_table(case, search.steps)
    fit = finished(
        last.model,
        record,
        last.temperature,
        (case.fitting, case.test, case.parts == Part.TEST),
        (last.coefficients, stderr, at_bound, last.converged),
        scores=table[SCORES].rename_axis(None),
        notes=tuple(notes),
        method="least_squares",
        night=True,
        daily=daily,
    )
    findings = [with_errors(f, last, stderr) for f in search.findings]
    findings += search.vetoed.values()
    ranking, more, unseen = left_over(search, found, findings, last)
    raw = search.steps[base]
    before = pd.Series(raw.measured - raw.temperature, record.index)
    stretches = episodes_of(case, last)
    # of the two dynamics the loop went on with one
    path = [n for n in search.steps if n not in BASES or n in ("steady", base)]
    budget = budget_of(case, search.steps, path, table, more, stretches)
    return Loop(
        findings=tuple(more),
        corrections=tuple(search.corrections),
        table=table,
        base=base,
        last=list(table.index)[-1] if last is not search.steps[base] else base,
        untestable=search.untestable | unseen,
        ranking=ranking,
        fit=fit,
        notes=case.notes,
        place=case.place,
        residual_before=before.rename("residual"),
        weeks=pd.Series(named(case.parts), record.index, name="weeks"),
        plain=(search.steps[base].model, search.start.coefficients),
        criteria=case.criteria,
        family=case.family.physics,
        weighed=found is not None,
        budget=budget,
        episodes=stretches,
    )


def left_over(search, found, findings, last):
    """The ranking, all findings with their ranges, and what was not to be seen."""
    case = search.case
    if found is None:
        days, least = case.fitting_days, case.criteria.fewest_fitting_days
        few = because(Reason.FEW_FITTING_DAYS, days=days, least=least)
        return table_of({}), findings, {effect.name: few for effect in case.wanted}
    rows = ranked(found, case.days)
    told = (case, found, rows)
    by = sorting(case, found, [])
    changes = changes_of(last.model.effects)
    findings = [*findings, *hints(*told, findings, search.aside, changes)]
    tables = [*tables_left(case, found, by)]
    findings += [unexplained(*table) for table in tables]
    findings = with_ranges(findings, found, last, [table for table, _ in tables])
    unseen = dict(not_seen(case, found, rows, findings))
    table = table_of({name: as_row(*row) for name, row in rows.items()})
    table = table.sort_values("gain", ascending=False, kind="stable")
    return Ranking(table), findings, unseen


def with_errors(finding, last, stderr):
    """The finding with the coefficients of the last fit, where it is in it."""
    if finding.effect not in {effect.name for effect in last.model.effects}:
        return finding
    return replace(
        finding,
        coefficients={k: last.coefficients[k] for k in finding.coefficients},
        stderr={k: stderr[k] for k in finding.stderr},
    )


def error_table(case, steps):
    """Errors of each step on fitting and test rows, on those that all steps know."""
    everywhere = np.all([np.isfinite(s.temperature) for s in steps.values()], axis=0)
    parts = {"train": case.fitting & everywhere, "test": case.test & everywhere}
    parts = {name: np.flatnonzero(rows) for name, rows in parts.items()}
    sunny = case.whole["poa_global"][parts["test"]] > DAYLIGHT
    light = scores.kilowatt_hours(case.whole.inputs)[parts["test"]]
    rows = {}
    for name, step in steps.items():
        left = {p: step.measured[at] - step.temperature[at] for p, at in parts.items()}
        test = left["test"]
        rows[name] = {
            **scores.of(left["train"], "train"),
            **scores.of(test, "test"),
            "rmse_test_day": scores.of(test[sunny], "day")["rmse_day"],
            "rmse_test_night": scores.of(test[~sunny], "night")["rmse_night"],
            "energy_error_test": scores.energy_of(light, -test).performance_ratio,
        }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("step")
