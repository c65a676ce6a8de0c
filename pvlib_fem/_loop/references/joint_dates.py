"""Rivals of a choice, at the dates that are best by temperature and references."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from pvlib_fem._loop.references.cross_checks import (
    ODD,
    log_likelihood,
    log_likelihoods,
    ways,
)
from pvlib_fem._loop.references.deviations import DailyDeviation
from pvlib_fem._loop.selection.change_dates import Costs, Scan
from pvlib_fem._loop.selection.change_sums import PROFILE_ERROR, dates_cost
from pvlib_fem._loop.selection.dictionary import OF_A_PART
from pvlib_fem._loop.selection.rivals import alone, weighed
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import is_drift

if TYPE_CHECKING:
    from pvlib_fem._loop.selection.choice import Choice
    from pvlib_fem._loop.selection.dictionary import Candidate
    from pvlib_fem._loop.selection.single_effects import Selection


def weighed_by_references(
    selection: "Selection",
    choice: "Choice",
    others: Sequence["Choice"],
    references: Sequence[DailyDeviation],
    coefficients: Mapping[str, float],
) -> tuple["Choice", dict[str, float]]:
    """
    A choice with its rivals, and their log-likelihoods by references.

    The dates by which the temperature shows a change best may be of another one, or be
    refused by a reference. So each is compared at the dates that are best by both.

    Parameters
    ----------
    selection : Selection
    choice : Choice
        With its best candidate alone.
    others : sequence of Choice
        Choices that are given.
    references : sequence of DailyDeviation
        Given the others.
    coefficients : dict
        Of the fitted model.

    Returns
    -------
    Choice, dict of float
        See :func:`log_likelihoods`.
    """
    one = weighed(selection, choice, others)
    dated = at_best_dates(selection, one, others, references, coefficients)
    if dated:
        top = dated.get(one.top.name, one.top)
        score = selection.score(top, selection.given(others))
        choice = replace(choice, top=top, score=score)
        one = weighed(selection, choice, others, [*dated.values()])
    return one, log_likelihoods(references, one, coefficients)


def at_best_dates(
    selection: "Selection",
    choice: "Choice",
    others: Sequence["Choice"],
    references: Sequence[DailyDeviation],
    coefficients: Mapping[str, float],
) -> dict[str, "Candidate"]:
    """
    Members of a choice that have better dates by references, at these, by name.

    A trend of the whole record, and the dates that a reference shows, are tried too.
    """
    given = selection.given(others)
    known = [one for one in selection.candidates(given) if is_whole_trend(one)]
    known = [*selection.with_same_law(known), *selection.shown_candidates()]
    known = [one for one in known if one.beyond(given)]
    scan = selection.scan(given)
    (most,) = selection.in_sample([choice.top], given)
    sure = min(choice.score.z_score, 1.0 / PROFILE_ERROR)
    best = {}
    for name, one in choice.members.items():
        concerned = [by for by in references if by.concerns(one.effect)]
        costs = date_costs(concerned, one.effect)
        if costs is None or not one.effect.sensor_fault:
            continue
        dated = [one, *(other for other in known if other.name == name)]
        tried = [*dated, *moved(selection, scan, dated, costs)]
        if len(tried) == 1:
            continue
        falls = selection.in_sample(tried, given)
        logs = 0.5 * (sure**2 * falls / most - costs([other.effect for other in tried]))
        logs -= [dates_cost(other.dates, sure) for other in tried]
        for i, other in enumerate(tried):
            it = other.effect
            with_size = alone(selection, it, given)
            sized = [with_size.sized(name)] if with_size else []
            logs[i] += sum(
                by.weight * log_likelihood(ways(by, it), it, sized, coefficients)
                for by in concerned
            )
        if at := int(np.argmax(logs)):
            best[name] = tried[at]
    return best


def is_whole_trend(one: "Candidate") -> bool:
    """Whether a candidate is a trend of the whole record."""
    return is_drift(one.effect) and one.time_profile != OF_A_PART


def moved(
    selection: "Selection",
    scan: Scan,
    candidates: Sequence["Candidate"],
    costs: Costs,
) -> Iterator["Candidate"]:
    """Each of some candidates at better dates, if there are any."""
    for one in candidates:
        z_score = selection.score(one, scan.given).z_score
        effect = scan.at_best_dates(one.change, z_score, costs)
        if effect.settings != one.effect.settings:
            columns = selection.design.columns_of(effect)
            other = replace(candidates[0], effect=effect, columns=columns)
            if other.beyond(scan.given):
                yield other


def date_costs(references: Sequence[DailyDeviation], effect: Effect) -> "Costs | None":
    """
    How much worse changes are by references than the best of them.

    A reference may show something else, so that it makes no date impossible.

    Parameters
    ----------
    references : sequence of DailyDeviation
    effect : Effect
        A change.

    Returns
    -------
    callable or None
        Of changes like the effect that differ in their dates. None if no reference
        would show it.
    """
    concerned = [one for one in references if one.concerns(effect)]
    if not concerned:
        return None
    return lambda effects: np.sum([costs_by(one, effects) for one in concerned], axis=0)


def costs_by(reference: DailyDeviation, effects: Sequence[Effect]) -> np.ndarray:
    """Costs of changes, with the probability that it shows something else."""
    likelihoods = np.exp(-0.5 * reference.costs(effects))
    return -2.0 * np.log((1.0 - ODD) * likelihoods + ODD)
