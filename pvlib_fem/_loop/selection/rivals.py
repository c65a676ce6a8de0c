"""What else a choice may be: its rivals, and the sizes of all of them."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from pvlib_fem._loop.regression.design import Column
from pvlib_fem._loop.selection.change_sums import PROFILE_ERROR
from pvlib_fem._loop.selection.choice import Choice
from pvlib_fem._loop.selection.posterior import posterior
from pvlib_fem._loop.selection.single_effects import Selection
from pvlib_fem._statistics.weekly_sums import LeastSquares
from pvlib_fem.effects._effect import Effect

if TYPE_CHECKING:
    from pvlib_fem._loop.selection.dictionary import Candidate

OVERLAP = 0.3  # share of the best one's part, from which another is its rival
DOUBT = 0.5  # probability below which another is no rival


def weighed(
    selection: Selection,
    choice: Choice,
    others: Sequence[Choice],
    instead: Sequence["Candidate"] = (),
) -> Choice:
    """
    A choice with its rivals, by how much of its part each explains.

    Parameters
    ----------
    selection : Selection
    choice : Choice
        With its best candidate alone.
    others : sequence of Choice
        Choices that are given.
    instead : sequence of Candidate, optional
        Rivals instead of those with the same name that the temperature shows best.

    Returns
    -------
    Choice
        With the probability of each of its members, without that of a cause outside.
    """
    top = choice.top
    given = selection.given(others)
    searched = {top.name: top}
    # a change that is in the model may be the cause of other days, too
    taken = selection.taken(others)
    replaced = {one.name for one in instead}
    found = selection.candidates(given)
    rivals = [*instead, *(one for one in found if one.name not in replaced)]
    rivals = [one for one in rivals if one.beyond(given)]
    # the others may explain more of its part than those given which it was found
    mine, *falls = selection.in_sample([top, *rivals], given)
    rivals = [one for one, fall in zip(rivals, falls) if fall >= OVERLAP * mine]
    for one in rivals:
        if selection.alike(top, one, given) >= OVERLAP:
            score = selection.score(one, given)
            if score.possible and score.probability >= DOUBT:
                searched.setdefault(one.name, one)
    # a fault may have another time profile than the one that looks like the best
    # candidate, and references compare them
    faults = {one.effect.sensor_fault for one in searched.values()} - {""}
    for one in rivals:
        if one.effect.sensor_fault in faults and selection.score(one, given).possible:
            searched.setdefault(one.name, one)
    # references can date other faults of a law otherwise
    alike = selection.with_same_law(searched.values())
    members = {one.name: searched.get(one.name, one) for one in alike}
    parts = {name: selection.score(one, given) for name, one in members.items()}
    sure = min(choice.score.z_score, 1.0 / PROFILE_ERROR)
    design = selection.design.at(given)
    weights = posterior(design, selection.criteria, members, given, top, sure)
    choice = replace(
        choice, members=members, scores=parts, weights=weights, taken=taken
    )
    return replace(
        choice,
        spreads=spreads(selection, choice, given),
        confounded=confounded(selection, choice, given),
    )


def alone(
    selection: Selection, effect: Effect, given: Sequence[Column]
) -> Choice | None:
    """
    A change at known dates as the only member of a choice.

    Parameters
    ----------
    selection : Selection
    effect : Effect
    given : sequence of column
        Of the design.

    Returns
    -------
    Choice or None
        None if the given columns explain it.
    """
    one = selection.candidate_of(effect)
    if one is None or not one.beyond(given):
        return None
    score = selection.score(one, given)
    choice = Choice(one, score, {one.name: one}, {one.name: score})
    return replace(choice, confounded=confounded(selection, choice, given))


def confounded(
    selection: Selection, choice: Choice, given: Sequence[Column]
) -> dict[str, tuple[float, float]]:
    """
    Sizes of the changes of a choice given all confounders of the catalogue.

    Any module may have these, also where they are not material: heat of the ground
    and light from it differ before and after a date, as they do with the season.
    """
    design = selection.design.at(given)
    found = {}
    for name, one in choice.members.items():
        if one.effect.sensor_fault:
            columns = [*given, *design.confounders_beyond(given), one.change]
            fit = LeastSquares(design.by_week(columns), 1)
            (scale,) = design.scales([one.change])
            shift = fit.estimate[0] / scale - choice.scores[name].estimate[0]
            error = np.sqrt(fit.covariance[0, 0]) / scale
            found[name] = float(shift), float(error)
    return found


def spreads(
    selection: Selection, choice: Choice, given: Sequence[Column]
) -> dict[str, tuple[float, float]]:
    """Least and largest size over its dates of each member that has some."""
    faults = [one for one in choice.members.values() if one.effect.sensor_fault]
    if not faults:
        return {}
    scan = selection.scan(given)
    return {
        one.name: scan.sizes_over_dates(one.change, choice.scores[one.name].z_score)
        for one in faults
    }
