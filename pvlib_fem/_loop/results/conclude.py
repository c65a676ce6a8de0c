"""Findings: single effects, hints, unexplained patterns, and what was not seen."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from pvlib_fem._findings import (
    OUTSIDE,
    SNOW,
    Check,
    CheckOutcome,
    Finding,
    Kind,
    Member,
    Verdict,
)
from pvlib_fem._loop.criteria import HALF, Criteria
from pvlib_fem._loop.references.comparisons import REFERENCE_ERROR, size_error
from pvlib_fem._record.column_names import GEOMETRY
from pvlib_fem.drivers import needed_for
from pvlib_fem.effects import EFFECTS
from pvlib_fem.effects._effect import Effect, Parameter, deciding_measurements
from pvlib_fem.effects._time_profiles import dates_in_words, is_dated, is_drift
from pvlib_fem.reasons import Because, Reason, because

if TYPE_CHECKING:
    from pvlib_fem._fitting.fem_fit import FemFit
    from pvlib_fem._loop.preparation.divided_record import Case
    from pvlib_fem._loop.ranking.ranking import Row
    from pvlib_fem._loop.regression.refits import Step
    from pvlib_fem._loop.selection.choice import Choice, Score
    from pvlib_fem._statistics.tables import Table

NINETY = 1.645  # standard errors in half a range that holds 90 %


def finding_of(
    choice: "Choice",
    effect: Effect,
    case: "Case",
    floor: float,
) -> Finding:
    """
    A single effect as a finding, by its credible set.

    Parameters
    ----------
    choice : Choice
        With the probabilities of its members, and their cross-checks.
    effect : Effect
        The most probable member, with the days between which its date is.
    case : Case
    floor : float
        Fall of the mean square that is material. [K²]

    Returns
    -------
    Finding
    """
    limits = case.criteria
    credible = choice.credible_names(limits.min_probability)
    names = (effect.name, *(n for n in credible if n not in (effect.name, OUTSIDE)))
    # those of the best candidate: that there is one is not a question of which it is
    score, gain = choice.score, float(np.sqrt(choice.fall))
    untested, snow = choice.untested, choice.probabilities.get(SNOW, 0.0)
    why = because(Reason.GAINED, gain=gain)
    verdict = Verdict.IDENTIFIED if credible == [effect.name] else Verdict.AMBIGUOUS
    checks = [
        check_of_existence(score.probability, limits.min_probability),
        check_of_gain(gain, floor * score.acting),
    ]
    if verdict is Verdict.AMBIGUOUS:
        measurements = deciding_measurements(choice.effects_of(names))
        if measurements:
            decided = because(Reason.WOULD_DECIDE, measurements=measurements)
            why = replace(why, also=(decided,))
    # a model with the sensor's fault is right for other light on the modules, too
    if untested > HALF and not effect.unseen_light:
        verdict, words = Verdict.HINT, "cause outside the catalogue"
        why = because(Reason.OUTSIDE, chance=untested)
        if snow > 0.5 * untested:
            words = f"snow or a {words}"
            why = because(Reason.SNOW, chance=untested)
        checks.append(Check(words, "outside_probability", untested, HALF, most=True))
    elif not case.enough:
        verdict = Verdict.HINT
        check, why = too_short(case)
        checks.append(check)
    if agree := [
        one.column
        for one in choice.cross_checks
        if one.effect == effect.name and one.outcome is CheckOutcome.AGREES
    ]:
        agreed = because(Reason.CORROBORATED, columns=agree)
        why = replace(why, also=(*why.also, agreed))
    return Finding(
        effect=effect.name,
        candidates=names,
        verdict=verdict,
        gain=gain,
        coefficients=choice.coefficients(effect.name),
        stderr=choice.errors(effect.name),
        because=why,
        checks=tuple(checks),
        kind=Kind.of(effect),
        place=dates_in_words(effect.settings) if is_dated(effect) else "",
        cross_checks=choice.cross_checks,
        probabilities=choice.probabilities,
        members={
            name: member_of(choice, name, limits)
            for name in names[1:]
            if name in EFFECTS and name in choice.members
        },
    )


def check_of_existence(probability: float, least: float) -> Check:
    """The check that there probably is such an effect."""
    name = "probability that there is such an effect"
    return Check(name, "min_probability", probability, least)


def check_of_gain(gain: float, least: float) -> Check:
    """The check of a gain [K], by the fall of the mean square that is material [K²]."""
    return Check("gain", "min_rmse_reduction", gain, float(np.sqrt(least)), unit="K")


def too_short(case: "Case") -> tuple[Check, Because]:
    """The check that a record has enough days for a name, and why it fails."""
    days, least = case.days, case.criteria.min_days
    check = Check("days", "min_days", days, least)
    return check, because(Reason.TOO_SHORT, days=days, least=least)


def member_of(choice: "Choice", name: str, criteria: Criteria) -> Member:
    """Coefficients and dates of a candidate, instead of the most probable one."""
    effect = choice.members[name].effect
    # a record may not determine all coefficients of an effect
    values, errors = choice.coefficients(name), choice.errors(name)
    ranges = {
        key: range_of(key, value, errors[key], choice, name, criteria)
        for key, value in values.items()
    }
    return Member(dict(effect.settings), values, errors, ranges)


def range_of(
    key: str,
    value: float,
    error: float,
    choice: "Choice",
    name: str,
    criteria: Criteria,
) -> tuple[float, float]:
    """
    A range of a coefficient that holds 90 %, within its bounds.

    It has the errors of the fit and of the law, and the difference from generalised
    least squares: of a model that is right, two estimates agree (Hausman, 1978,
    :doi:`10.2307/1913827`). That of a change also has the difference and the error of
    its size given all confounders; that of a trend reaches beyond its sizes over its
    dates. References that show it have a part in the size, so that the errors of the
    temperature and of its law count less. To the mean with one that may show something
    else the range reaches.
    """
    effect, score = choice.members[name].effect, choice.scores[name]
    law = relative_error(effect, criteria)
    at, part, other = score.keys.index(key), 1.0, value
    ends = [value * one for one in choice.spreads.get(name, ())]
    beside = choice.confounded.get(name)
    if at == 0 and (shown := choice.by_reference.get(name)):
        if shown.shows_it:  # the errors by confounders are in that of the size
            part, other, beside = 1.0 - shown.share, float(score.estimate[0]), None
            # of a trend a reference knows the size, and its dates no better
            if not is_drift(effect):
                law = float(np.hypot(part * law, shown.share * REFERENCE_ERROR))
        else:
            ends.append(value * shown.mean)
    halves = [
        NINETY * error,
        NINETY * law * value,
        part * (float(score.seen[at]) - other),
    ]
    if beside:
        halves += [beside[0], NINETY * beside[1]]
    return range_around(value, halves, effect.rows()[key], ends)


def range_around(
    value: float, halves: Iterable[float], row: Parameter, ends: Iterable[float] = ()
) -> tuple[float, float]:
    """
    A range around a value, within the bounds of a coefficient.

    ``halves`` are independent half-widths, ``ends`` other values that it may have.
    """
    ends = [value, *ends]
    below, above = value - min(ends), max(ends) - value
    low = value - float(np.linalg.norm([*halves, below]))
    high = value + float(np.linalg.norm([*halves, above]))
    return max(low, row.lower), min(high, row.upper)


def in_the_model(
    finding: Finding,
    choice: "Choice",
    fit: "Step",
    stderr: Mapping[str, float],
    criteria: Criteria,
) -> Finding:
    """
    The finding with the coefficients of the last fit, and ranges that hold 90 %.

    Parameters
    ----------
    finding : Finding
        Finding that is in the model.
    choice : Choice
        From which it was made.
    fit : Step
        The last one.
    stderr : dict
        Standard errors of the coefficients of that fit.
    criteria : Criteria
        Relative errors of laws.

    Returns
    -------
    Finding
        A coefficient at its bound, or without a standard error, has no range.
    """
    values = {key: fit.coefficients[key] for key in finding.coefficients}
    errors = {key: stderr[key] for key in finding.coefficients}
    for key in choice.joint_size(finding.effect, values):  # which is held
        errors[key] = choice.errors(finding.effect)[key]
    ranges = {
        key: range_of(key, value, errors[key], choice, finding.effect, criteria)
        for key, value in values.items()
        if key not in fit.at_bound and errors[key] > 0
    }
    return replace(finding, coefficients=values, stderr=errors, ranges=ranges)


def relative_error(effect: Effect, criteria: Criteria) -> float:
    """
    Relative error of a coefficient by its law, or by that of the thermal model.

    A fault with dates, as a sensor's or a standstill of a tracker, has no law of its
    own: the same plant without it is the comparison.
    """
    if is_dated(effect):
        return size_error(effect)
    return criteria.shape_error if effect.confounder else criteria.law_error


def check_of_bounds(
    names: Iterable[str], step: "Step | FemFit"
) -> tuple[Check, Because]:
    """
    The check that none of some coefficients is at a bound, and why it fails.

    Parameters
    ----------
    names : iterable of str
    step : Step or FemFit
        The refit.

    Returns
    -------
    Check, Because
    """
    bound = sorted({*names} & {*step.at_bound})
    return (
        Check("coefficients at a bound", "", len(bound), 0, most=True),
        because(Reason.AT_BOUND, coefficient=", ".join(bound)),
    )


def if_material(
    finding: Finding, score: "Score", fitted: float, floor: float, criteria: Criteria
) -> Finding:
    """
    A finding; one that is not material or sure enough for the model as a hint.

    Parameters
    ----------
    finding : Finding
    score : Score
        Of its candidate, given all others.
    fitted : float
        Its gain on the weeks that are fitted. [K]
    floor : float
        Fall of the mean square that is material. [K²]
    criteria : Criteria

    Returns
    -------
    Finding
        A hint with the check that keeps it out of the model.
    """
    if finding.verdict is Verdict.HINT:
        return finding
    failed = why_not_in_model(score, fitted, floor * score.acting, criteria)
    if failed is None:
        return finding
    check, why = failed
    why = replace(why, also=finding.because.also)
    return replace(finding, verdict=Verdict.HINT, because=why, checks=(check,))


def why_not_in_model(
    score: "Score", fitted: float, least: float, criteria: Criteria
) -> tuple[Check, Because] | None:
    """The check that keeps a possible effect out of the model, and why, or None."""
    check = check_of_gain(float(np.sqrt(score.fall)), least)
    if not check.passed:
        return check, because(Reason.NOT_MATERIAL, least=check.threshold)
    chance, sure = score.probability, criteria.min_probability
    check = check_of_existence(chance, sure)
    if not check.passed:
        return check, because(Reason.NOT_SURE, chance=chance, least=sure)
    check = check_of_gain(fitted, least)
    if not check.passed:
        why = because(Reason.NOT_MATERIAL_FITTED, gain=fitted, least=check.threshold)
        return replace(check, name="gain on the weeks that are fitted"), why
    return None


def pattern_findings(tables: Iterable["Table"], least: float) -> list[Finding]:
    """
    Tables of unexplained patterns as findings.

    Parameters
    ----------
    tables : sequence of Table
    least : float
        Variance that was material. [K²]

    Returns
    -------
    list of Finding
        In the order of the tables.
    """
    return [
        Finding(
            effect=table.name,
            candidates=table.drivers,
            verdict=Verdict.UNEXPLAINED,
            gain=table.gain,
            coefficients={"mean": table.size},
            stderr={},
            because=because(Reason.UNEXPLAINED, gain=table.gain, where=table.where),
            checks=(check_of_gain(table.gain, least),),
            kind=Kind.STRUCTURE,
            where=table.ranges,
            place=table.where,
        )
        for table in tables
    ]


def not_seen(
    case: "Case",
    rows: Mapping[str, "Row"],
    failed: Mapping[str, Because],
    findings: Sequence[Finding],
    whole: float,
) -> Iterator[tuple[str, Because]]:
    """
    Why this record could not see what it did not show, by name.

    Parameters
    ----------
    case : Case
    rows : dict of Row
        The ranking, by name of the effect.
    failed : dict of Because
        Reasons of those that are in no ranking.
    findings : sequence of Finding
    whole : float
        Error of the model without effects, which no gain exceeds. [K]

    Yields
    ------
    str, Because
    """
    reported = {name for finding in findings for name in finding.candidates}
    wanted = {effect.name: effect for effect in case.wanted}
    for name, why in failed.items():
        columns = better_sources(wanted[name]) if name in wanted else []
        if columns:
            yield name, because(Reason.STAND_IN, columns=columns)
        elif why.reason is not Reason.NO_DATE:  # tried, and there is no such change
            yield name, why
    for name, row in rows.items():
        if columns := better_sources(row.effect):
            yield name, because(Reason.STAND_IN, columns=columns)
        elif name in reported:
            continue
        elif row.note is not None and not row.score.possible and row.gain > 0:
            yield name, row.note
        elif row.effect.sensor_fault and not is_drift(row.effect):
            continue  # of its dates only the best one was weighed
        elif row.detectable > whole:
            yield name, because(Reason.COLLINEAR)
        elif row.detectable > case.criteria.min_rmse_reduction:
            yield name, because(Reason.DETECTABLE, gain=row.detectable)


def better_sources(effect: Effect) -> list[str]:
    """Columns with which it would have a driver, where it stands in without one."""
    forms = EFFECTS.get(effect.name, effect).forms
    driven = [form for form in forms if not form.confounder]
    # one without a source is no stand-in
    if not effect.confounder or not driven or "source" not in effect.settings:
        return []
    needed = [name for form in driven for name in needed_for(form.drivers)]
    return sorted({*needed} - {*GEOMETRY})
