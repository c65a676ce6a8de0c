"""Cross-checks of the candidates of a choice, by how they deviate from references."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from pvlib_fem._findings import OUTSIDE, CheckOutcome, CrossCheck
from pvlib_fem._loop.references.comparisons import SLACK
from pvlib_fem._loop.references.deviations import DailyDeviation, Shown
from pvlib_fem._loop.selection.choice import SizeByReference, Sized
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import (
    is_compared,
    is_dated,
    is_drift,
    time_profile_of,
    years_to_end,
)

if TYPE_CHECKING:
    from pvlib_fem._loop.selection.choice import Choice

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
                several = [*map(choice.sized, names)]
                given = ways(one, own)
                log = log_likelihood(given, own, several, coefficients, any_size)
                logs[name] += one.weight * log
    return logs


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
            first = faults[mine[0]].effect
            known = [*ways(given, first)]
            for i in mine:
                log = log_likelihood(known, first, [faults[i]], coefficients)
                each[i] += reference.weight * log
        logs.append(float(np.logaddexp.reduce(each) - np.log(len(each))))
    return logs


def ways(
    reference: DailyDeviation, effect: Effect
) -> Iterator[tuple[float, DailyDeviation]]:
    """
    The deviation, and given what references show, each with the log weight of it.

    An effect may be what a reference shows by itself, or come in addition to it. Else a
    step in winter would seem to confirm a trend from summer on.

    Parameters
    ----------
    reference : DailyDeviation
        With what it shows by itself.
    effect : Effect
        Along whose time profile it is looked at.

    Yields
    ------
    float, DailyDeviation
    """
    own, profile = map(time_profile_of, reference.own), time_profile_of(effect)
    if not reference.own or not profile or profile in own:
        yield 0.0, reference
        return
    yield -0.5 * float(reference.costs([effect, *reference.own])[0]), reference
    yield 0.0, reference.given_effects(reference.own)


def log_likelihood(
    given: Iterable[tuple[float, DailyDeviation]],
    first: Effect,
    several: Sequence[Sized],
    coefficients: Mapping[str, float],
    any_size: bool = False,
) -> float:
    """
    Log-likelihood by a reference, compared with one that shows nothing.

    Parameters
    ----------
    given : iterable of (float, DailyDeviation)
        The reference, from :func:`ways`.
    first : Effect
        Along whose time profile it is.
    several : sequence of Sized
        Of one candidate, if its size is expected.
    coefficients : dict
        Of the fitted model.
    any_size : bool, optional
        Whether a deviation of any size is as good as those expected.

    Returns
    -------
    float
    """
    logs = [
        log_weight + likelihood_ratio(one.shown(first, several, coefficients), any_size)
        for log_weight, one in given
    ]
    return float(np.logaddexp.reduce(logs))


def best_way(
    reference: DailyDeviation,
    first: Effect,
    one: Sized,
    coefficients: Mapping[str, float],
) -> DailyDeviation:
    """The deviation, or that given what references show, by the likelier of both."""

    def log_of(way: tuple[float, DailyDeviation]) -> float:
        log_weight, given = way
        return log_weight + likelihood_ratio(given.shown(first, [one], coefficients))

    return max(ways(reference, first), key=log_of)[1]


def likelihood_ratio(shown: Shown | None, any_size: bool = False) -> float:
    """Logarithm of the likelihood of what is shown, by that of nothing."""
    if shown is None:
        return 0.0
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
        several = [*map(choice.sized, alike)]
        if several:
            one = best_way(one, first, several[0], coefficients)
        shown = one.shown(first, several, coefficients)
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
