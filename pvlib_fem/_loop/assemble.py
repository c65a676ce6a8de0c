"""What a search came to, as a finished thing."""

from collections.abc import Iterator, Mapping

import numpy as np
import pandas as pd

from pvlib_fem import scores
from pvlib_fem._budget.error_budget import budget_of, episodes_of
from pvlib_fem._findings import PREDICTED, Finding
from pvlib_fem._fitting.least_squares_fit import fit_result
from pvlib_fem._loop.preparation.divided_record import BASES, FEWEST_FITTING_DAYS, Case
from pvlib_fem._loop.ranking.ranking import ranked
from pvlib_fem._loop.ranking.ranking_table import Ranking, table_of
from pvlib_fem._loop.references.power_events import events_of
from pvlib_fem._loop.regression.refits import Step
from pvlib_fem._loop.results.conclude import in_the_model, not_seen, pattern_findings
from pvlib_fem._loop.results.loop_result import Loop
from pvlib_fem._loop.results.predicted_patterns import Pattern
from pvlib_fem._loop.results.repeated_patterns import repeated_tables, with_patterns
from pvlib_fem._loop.search import Search
from pvlib_fem._record.column_names import DAYLIGHT
from pvlib_fem._statistics.tables import Table
from pvlib_fem.drivers._mounts import without_rows
from pvlib_fem.reasons import Because, Reason, because

SCORES = [
    f"{name}_{part}" for part in ("train", "test") for name in ("rmse", "mae", "mbe")
]


def loop_of_search(search: Search, last: Step, base: str) -> Loop:
    """
    All that was found, as a finished thing.

    Parameters
    ----------
    search : Search
        After its run.
    last : Step
        The model of the result.
    base : str
        Name of the step before all effects.

    Returns
    -------
    Loop
    """
    case = search.case
    notes: list[str] = []
    record = case.placed_for(case.whole, last.model.drivers)
    at_bound, daily = last.at_bound, search.fits.daily(last)
    stderr = search.fits.errors(last, daily, notes)
    notes += held_notes(search)
    tables = repeatable_tables(search, last)
    search.fits.forget_coarse()
    patterns = tuple(Pattern.from_table(table, record.index) for table in tables)
    steps = dict(search.steps)
    if patterns and case.enough:
        steps[PREDICTED] = with_patterns(case, last, patterns)
    table = error_table(case, steps)
    fit = fit_result(
        last.model,
        record,
        last.temperature,
        (case.fitting, case.test, case.held_out),
        (last.coefficients, stderr, at_bound, last.converged),
        scores=table.loc[[*search.steps], SCORES].rename_axis(None),
        notes=tuple(notes),
        method="least_squares",
        night=True,
        daily=daily,
    )
    findings = [
        in_the_model(f, search.choices[f.effect], last, stderr, case.criteria)
        for f in search.findings
    ]
    findings = [*findings, *search.refused]
    ranking, more, unseen = rank_remaining(search, findings, tables)
    raw = search.start
    first = search.steps[base]
    before = pd.Series(first.measured - first.temperature, record.index)
    stretches = episodes_of(case, last)
    shown = events_of(search.fits, last)
    # of the two dynamics the loop went on with one
    dynamics = next(n for n, how in BASES.items() if how == raw.model.dynamics)
    path = [n for n in search.steps if n not in BASES or n in ("steady", dynamics)]
    budget = budget_of(case, search.steps, path, table, more, stretches)
    return Loop(
        finding_objects=tuple(more),
        corrections=tuple(search.corrections),
        table=table,
        base=base,
        last=list(search.steps)[-1] if last is not search.steps[base] else base,
        untestable=search.untestable | unseen,
        ranking=ranking,
        fit=fit,
        notes=(*case.notes, *steps_notes(search), *search.reference_faults(more)),
        place=without_rows(case.place),
        residual_before=before.rename("residual"),
        weeks=pd.Series(kinds_of_weeks(case.held_out), record.index, name="weeks"),
        plain=(raw.model, raw.coefficients),
        criteria=case.criteria,
        weighed=search.last is not None,
        budget=budget,
        episodes=stretches,
        events=shown,
        patterns=patterns if PREDICTED in steps else (),
        hint_effects=tuple(search.effects[f.effect] for f in search.refused),
        label=case.label,
    )


def kinds_of_weeks(held_out: np.ndarray) -> "pd.Categorical[str]":
    """What each row was for, by whether it is of a test week."""
    names = pd.Index(["fitting", "test"])
    kinds = pd.Categorical.from_codes(held_out.astype(np.int8), names)
    return kinds.remove_unused_categories()


def held_notes(search: Search) -> Iterator[str]:
    """Which coefficients references have a part in, so that the fit holds them."""
    for finding in search.findings:
        if joint := search.choices[finding.effect].joint(finding.effect):
            key, *_ = finding.coefficients
            yield (
                f"{key} is held: it is the mean of its sizes by temp_module and by "
                f"{' and '.join(joint.columns)}, weighted by their variances"
            )


def steps_notes(search: Search) -> list[str]:
    """A module temperature at the end of steps whose irradiance is a mean, in words."""
    if search.last is None or "misfit:early" not in search.last.evidence.misfits:
        return []
    return [
        "temp_module is half a step ahead: it looks like the value at the end of each "
        "step, where poa_global is a mean; record the mean of both, and the error is "
        "smaller"
    ]


def repeatable_tables(search: Search, last: Step) -> list[Table]:
    """Tables of the residual of the last step, where there are enough days."""
    if search.last is None or (search.findings and not search.case.enough):
        return []
    return repeated_tables(search.fits, last, search.last.selection.least)


def rank_remaining(
    search: Search, findings: list[Finding], tables: list[Table]
) -> tuple[Ranking, list[Finding], dict[str, Because]]:
    """Ranking, all findings, and why other effects could not be seen."""
    case, this = search.case, search.last
    if this is None:
        days, least = case.fitting_days, FEWEST_FITTING_DAYS
        few = because(Reason.FEW_FITTING_DAYS, days=days, least=least)
        return table_of({}), findings, {effect.name: few for effect in case.wanted}
    selection, taken = this.selection, [f.effect for f in findings if f.added]
    given = selection.given(search.in_model)
    rows, failed = ranked(selection, this.evidence, given, case.days, taken)
    floor = selection.least
    shown = [*findings, *pattern_findings(tables, floor)]
    whole = search.start.error(case.fitting)
    unseen = dict(not_seen(case, rows, failed, shown, whole))
    table = table_of(
        {n: {"note": str(why)} for n, why in failed.items()}
        | {name: row.content() for name, row in rows.items()}
    )
    table = table.sort_values("gain", ascending=False, kind="stable")
    return Ranking(table), shown, unseen


def error_table(case: Case, steps: Mapping[str, Step]) -> pd.DataFrame:
    """Errors of each step on fitting and test rows, on those that all steps know."""
    everywhere = np.all([np.isfinite(s.temperature) for s in steps.values()], axis=0)
    masks = {"train": case.fitting & everywhere, "test": case.test & everywhere}
    parts = {name: np.flatnonzero(mask) for name, mask in masks.items()}
    sunny = case.whole["poa_global"][parts["test"]] > DAYLIGHT
    light = scores.kilowatt_hours(case.whole.inputs)[parts["test"]]
    rows = {}
    for name, step in steps.items():
        residual = step.measured - step.temperature
        test = residual[parts["test"]]
        rows[name] = {
            **scores.scores_of(residual[parts["train"]], "train"),
            **scores.scores_of(test, "test"),
            "rmse_test_day": scores.scores_of(test[sunny], "day")["rmse_day"],
            "rmse_test_night": scores.scores_of(test[~sunny], "night")["rmse_night"],
            "energy_error_test": scores.energy_of(light, -test).performance_ratio,
        }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("step")
