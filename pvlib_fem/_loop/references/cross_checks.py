"""Cross-checks of the candidates of a choice, by how they deviate from references."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from pvlib_fem._findings import OUTSIDE, CheckOutcome, CrossCheck
from pvlib_fem._loop.references.comparisons import SLACK
from pvlib_fem._loop.references.deviations import DailyDeviation, Shown
from pvlib_fem._loop.selection.choice import SizeByReference, Sized
from pvlib_fem._loop.selection.dictionary import OF_A_PART
from pvlib_fem._loop.selection.rivals import weighed
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import (
    is_compared,
    is_dated,
    is_drift,
    time_profile_of,
    years_to_end,
)

if TYPE_CHECKING:
    from pvlib_fem._loop.selection.change_dates import Costs
    from pvlib_fem._loop.selection.choice import Choice
    from pvlib_fem._loop.selection.dictionary import Candidate
    from pvlib_fem._loop.selection.single_effects import Selection

HALF = 0.5  # of what is expected: less is nearer to nothing
SURE = 2.0  # standard errors
WORTH = 0.05  # probability of a member from which its cross-checks are reported
DIGITS = 9  # of what is expected
ODD = 0.02  # probability that a reference shows something else than any candidate
#: odds that a reference shows nothing of a change that it may not show
UNSEEN_ODDS = 0.5


def log_likelihoods(
    references: Sequence[DailyDeviation],
    choice: "Choice",
    coefficients: Mapping[str, float],
) -> dict[str, float]:
    """
    Log-likelihoods of the members of a choice, and of a cause outside, by references.

    Each is compared with a reference that shows nothing along the time profile of the
    member, of dirt along the light that it takes each day, or along that of the best
    member with one. A cause that is in no instrument predicts nothing. An effect by a
    power predicts any deviation that this power may show, and so does a cause outside
    that looks like it. Time profiles of one instrument are compared by the residual of
    the reference given each.

    Parameters
    ----------
    references : sequence of DailyDeviation
    choice : Choice
    coefficients : dict
        Of the fitted model.

    Returns
    -------
    dict of float
        By name, with :data:`~pvlib_fem._findings.OUTSIDE` among them.
    """
    logs = dict.fromkeys([*choice.members, OUTSIDE], 0.0)
    first = compared_along(choice)
    if first is None:
        return logs
    for one in references:
        concerned = one.concerned(choice)
        effects = {name: choice.members[name].effect for name in concerned}
        dated = {name: effect for name, effect in effects.items() if is_dated(effect)}
        for name, worse in one.profiles(dated.values()):
            logs[name] += one.weight * worse
        for name in logs:
            # an imitation of an effect by this power shows in it, too
            member = choice.top if name == OUTSIDE else choice.members[name]
            any_size = member.effect.settings.get("source") == one.column
            # what is a choice of its own has its deviation there
            if any_size or (name in effects and name not in choice.taken):
                own = effects.get(name, first)
                names = [name] if name in effects else concerned
                shown = one.shown(own, [*map(choice.sized, names)], coefficients)
                if shown is not None:
                    logs[name] += one.weight * log_likelihood(shown, any_size)
    return logs


def weighed_by_references(
    selection: "Selection",
    choice: "Choice",
    others: Sequence["Choice"],
    references: Sequence[DailyDeviation],
    coefficients: Mapping[str, float],
) -> tuple["Choice", dict[str, float]]:
    """
    A choice with its rivals, and their log-likelihoods by references.

    The dates of a rival are those by which it explains most of the temperature, and
    these may be of another change: a trend that ends with it, or a step at another
    date. A trend of the whole record, and a change at the dates that references show,
    are the rivals instead if these make them more probable.

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
    logs = log_likelihoods(references, one, coefficients)
    if not any(reference.concerned(one) for reference in references):
        return one, logs
    best: list[Candidate] = []
    for more in other_dates(selection, one, others):
        instead = [*more, *best]
        other = weighed(selection, choice, others, instead)
        by_other = log_likelihoods(references, other, coefficients)
        names = [rival.name for rival in selection.with_same_law(more)]
        if odds_of(names, other, by_other) > odds_of(names, one, logs):
            one, logs, best = other, by_other, instead
    return one, logs


def other_dates(
    selection: "Selection", choice: "Choice", others: Sequence["Choice"]
) -> Iterator[list["Candidate"]]:
    """Rivals of a choice at other dates: whole trends, and what references show."""
    closed, given = selection.taken([choice, *others]), selection.given(others)
    parts = {n for n, one in choice.members.items() if one.time_profile == OF_A_PART}
    found = selection.candidates(given, closed, without=OF_A_PART)
    whole = [one for one in found if one.name in parts and is_drift(one.effect)]
    there = [*choice.members.values()]
    shown = [one for one in selection.shown_candidates() if one not in there]
    shown = [one for one in shown if one.name not in closed]
    yield from filter(None, (whole, shown))


def odds_of(names: Sequence[str], choice: "Choice", logs: Mapping[str, float]) -> float:
    """Odds of some members of a choice against all others, by references, too."""
    most = max(logs.values())
    shares = {n: w * np.exp(logs[n] - most) for n, w in choice.weights.items()}
    mine = sum(shares.get(name, 0.0) for name in names)
    return float(mine / max(sum(shares.values()) - mine, 1e-300))


def log_likelihoods_of_sizes(
    references: Sequence[DailyDeviation],
    coefficients: Mapping[str, float],
    changes: Sequence[Sequence[Sized]],
) -> list[float]:
    """
    Log-likelihood by references of each of several changes, given all others.

    Parameters
    ----------
    references : sequence of DailyDeviation
    coefficients : dict
        Of the fitted model.
    changes : sequence of sequences of Sized
        Of each, the faults between which the temperature cannot decide. Its likelihood
        is their mean.

    Returns
    -------
    list of float
    """
    logs = []
    for faults in changes:
        others = [
            one.effect for other in changes if other is not faults for one in other
        ]
        each = np.zeros(len(faults))
        for reference in references:
            mine = [i for i, one in enumerate(faults) if reference.concerns(one.effect)]
            if not mine:
                continue
            given = reference.given_effects(filter(reference.concerns, others))
            # faults of one law have the same dates, along which it deviates once
            first, several = faults[mine[0]].effect, [faults[i] for i in mine]
            shown = given.shown(first, several, coefficients)
            if shown is None:
                continue
            for i, (name, value) in zip(mine, shown.expected.items()):
                alone = replace(shown, expected={name: value})
                each[i] += reference.weight * log_likelihood(alone, False)
        logs.append(float(np.logaddexp.reduce(each) - np.log(len(each))))
    return logs


def log_likelihood(shown: Shown, any_size: bool) -> float:
    """
    Log-likelihood of what is shown, compared with a reference that shows nothing.

    It is that of a deviation of the expected size, or of any size.
    """
    most = max(abs(value) for value in shown.expected.values())
    anything = shown.likelihood(0.0, most)
    likely = anything
    if not any_size:
        ((name, value),) = shown.expected.items()
        likely = shown.likelihood(value, shown.slack[name] * value)
        if name in shown.unseen:
            likely += UNSEEN_ODDS * shown.likelihood(0.0)
    likelihoods = np.array([likely, shown.likelihood(0.0)])
    likelihoods = (1.0 - ODD) * likelihoods + ODD * anything
    return float(np.subtract(*np.log(likelihoods)))


def shows_it(shown: Shown, name: str) -> bool:
    """Whether a deviation is rather that of a member than one of any other size."""
    value = shown.expected[name]
    likely = shown.likelihood(value, shown.slack[name] * value)
    anything = shown.likelihood(0.0, value)
    return bool((1.0 - ODD) * likely > ODD * anything)


def compared_along(choice: "Choice") -> Effect | None:
    """
    The best member with a time profile; None if the choice is not compared.

    What is a choice of its own has its deviation there.
    """
    free = [name for name in choice.weights if name not in choice.taken]
    free.sort(key=lambda name: -choice.weights[name])
    effects = (choice.members[name].effect for name in free)
    return next(filter(is_compared, (choice.top.effect, *effects)), None)


def cross_checked(
    references: Sequence[DailyDeviation],
    choice: "Choice",
    first: Effect,
    coefficients: Mapping[str, float],
) -> "Choice":
    """
    A choice with what each reference shows along the time profile of the first.

    Parameters
    ----------
    references : sequence of DailyDeviation
    choice : Choice
        With the probabilities of its members.
    first : Effect
        The most probable member.
    coefficients : dict
        Of the fitted model.

    Returns
    -------
    Choice
        With its cross-checks, and with the sizes of members by references.
    """
    checks: list[CrossCheck] = []
    sizes: dict[str, list[SizeByReference]] = {}
    for one in references if is_compared(first) else ():
        alike = [
            name
            for name in one.concerned(choice)
            if time_profile_of(choice.members[name].effect) == time_profile_of(first)
            and max(choice.probabilities[name], choice.weights[name]) >= WORTH
        ]
        alike.sort(key=lambda name: name != first.name)
        shown = one.shown(first, [*map(choice.sized, alike)], coefficients)
        if shown is None:
            continue
        size, aged = shown.size, shown.aged
        years = years_to_end(first)  # of a trend that ends, what it reaches
        unit = one.comparison.unit + ("/year" if is_drift(first) and not years else "")
        unit += "/day" if first.loses_light else ""
        times = years or 1.0
        told: set[tuple[float, CheckOutcome]] = set()
        for name in alike:
            value = shown.expected[name] - aged
            error = float(np.hypot(shown.error, aged / SURE))
            outcome = outcome_of(size, value, error, shown.slack[name])
            contradicted = outcome is CheckOutcome.CONTRADICTS
            if contradicted and name in shown.unseen:
                outcome = CheckOutcome.CANNOT_TELL
            # a trend of power may be its own, and is what a record is corrected for;
            # dirt by the days since rain is a law with an error, in both alike
            if value and not aged and not contradicted and is_dated(first):
                mine = choice.sized(name)
                ratio, off = one.relative_size(mine, first, shown, coefficients)
                off /= np.sqrt(one.weight)
                slack, its = shown.slack[name], shows_it(shown, name)
                by_it = SizeByReference((one.column,), ratio, off, slack, its)
                sizes.setdefault(name, []).append(by_it)
            same = round(shown.expected[name], DIGITS), outcome
            if same in told:  # of the same law
                continue
            told.add(same)
            numbers = (times * size, times * shown.error, times * value)
            checks.append(CrossCheck(one.column, name, *numbers, outcome, unit))
    joint = {name: SizeByReference.of_all(several) for name, several in sizes.items()}
    return replace(choice, cross_checks=tuple(checks), by_reference=joint)


def date_costs(
    references: Sequence[DailyDeviation], choice: "Choice", name: str
) -> "Costs | None":
    """
    How much worse each of some changes is by references than the best of them.

    Parameters
    ----------
    references : sequence of DailyDeviation
    choice : Choice
        With the sizes of its members by references.
    name : str
        Of a member that is a change.

    Returns
    -------
    callable or None
        Of changes like the member that differ in their dates. None if no reference
        shows the member.
    """
    effect, joint = choice.members[name].effect, choice.joint(name)
    if joint is None:
        return None
    showing = [one for one in references if one.column in joint.columns]
    showing = [one for one in showing if one.concerns(effect)]
    return lambda effects: np.sum([one.costs(effects) for one in showing], axis=0)


def outcome_of(
    size: float, expected: float, error: float, slack: float = SLACK
) -> CheckOutcome:
    """
    Whether a size is significantly nearer to the expected one than to 0.

    A size that is significantly nearer to twice the expected one has another cause, or
    a further one: it cannot tell.

    Parameters
    ----------
    size, expected : float
        Deviation along a time profile, and the one that a cause would make.
    error : float
        Standard error of the size.
    slack : float, optional
        Relative error of what is expected. [-]

    Returns
    -------
    CheckOutcome
    """
    if expected == 0.0:
        return CheckOutcome.CANNOT_TELL
    ratio = size / expected
    sure = SURE * np.hypot(error, HALF * slack * expected) / abs(expected)
    if ratio < HALF - sure:
        return CheckOutcome.CONTRADICTS
    if HALF + sure < ratio < 2.0 - HALF + sure:
        return CheckOutcome.AGREES
    return CheckOutcome.CANNOT_TELL
