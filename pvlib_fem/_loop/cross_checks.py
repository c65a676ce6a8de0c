"""Cross-checks of the candidates of a choice, by how they deviate from references."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pvlib_fem._findings import OUTSIDE, CheckOutcome, CrossCheck
from pvlib_fem._loop.comparisons import SLACK
from pvlib_fem._loop.noise import density
from pvlib_fem._loop.references import DailyDeviation
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import (
    is_dated,
    is_drift,
    time_profile_of,
    years_to_end,
)

if TYPE_CHECKING:
    from pvlib_fem._loop.selection import Choice

HALF = 0.5  # of what is expected: less is nearer to nothing
SURE = 2.0  # standard errors
WORTH = 0.05  # probability of a member from which its cross-checks are reported
DIGITS = 9  # of what is expected
ODD = 0.05  # probability that a reference shows something else than any candidate


def log_likelihoods(
    references: Sequence[DailyDeviation],
    choice: "Choice",
    coefficients: Mapping[str, float],
) -> dict[str, float]:
    """
    Log-likelihoods of the members of a choice, and of a cause outside, by references.

    The deviation of a reference along the time profile of the best dated member that it
    would show is compared with the deviation that each member predicts. A cause that is
    in no instrument predicts none. An effect by a power predicts any that this power
    may show, and so does a cause outside that looks like it. Time profiles of one
    instrument are compared by the residual of the reference given each.

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
    for one in references:
        names = one.concerned(choice)
        first = compared_along(choice, names)
        shown = first and one.shown(choice, first, names, coefficients)
        if not shown:
            continue
        dated = [n for n in names if is_dated(choice.members[n].effect)]
        for name, worse in one.profiles([choice.members[n].effect for n in dated]):
            logs[name] += worse
        size, error, aged = shown.size, shown.error, shown.aged
        expected = dict.fromkeys(logs, 0.0) | shown.expected
        broad = np.hypot(max(abs(value) for value in expected.values()), error)
        anything = density(size, broad)
        likelihoods = {
            name: density(
                size - value + aged,
                np.sqrt(error**2 + (shown.slack.get(name, 0.0) * value) ** 2 + aged**2),
            )
            for name, value in expected.items()
        }
        for name, likely in likelihoods.items():
            # an imitation of an effect by this power shows in it, too
            member = choice.top if name == OUTSIDE else choice.members[name]
            if member.effect.settings.get("source") == one.column:
                likely = anything
            logs[name] += float(np.log((1.0 - ODD) * likely + ODD * anything))
    return logs


def compared_along(choice: "Choice", names: Sequence[str]) -> Effect | None:
    """
    The best member with a time profile; None if the choice is not compared.

    It is one of those that a reference would show, by name, if any of these has a time
    profile. What is a choice of its own has its deviation there.
    """
    free = [name for name in choice.weights if name not in choice.taken]
    free.sort(key=lambda name: -choice.weights[name])
    effects = (choice.members[name].effect for name in free)
    dated = [*filter(is_dated, (choice.top.effect, *effects))]
    own = [one for one in dated if one.name in names]
    return next(iter([*own, *dated]), None)


def cross_checks(
    references: Sequence[DailyDeviation],
    choice: "Choice",
    first: Effect,
    coefficients: Mapping[str, float],
) -> tuple[CrossCheck, ...]:
    """
    What each reference shows along the time profile of the first, by instrument.

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
    tuple of CrossCheck
    """
    checks: list[CrossCheck] = []
    for one in references if is_dated(first) else ():
        alike = [
            name
            for name in one.concerned(choice)
            if time_profile_of(choice.members[name].effect) == time_profile_of(first)
            and max(choice.probabilities[name], choice.weights[name]) >= WORTH
        ]
        alike.sort(key=lambda name: name != first.name)
        shown = one.shown(choice, first, alike, coefficients)
        if shown is None:
            continue
        size, aged = shown.size, shown.aged
        years = years_to_end(first)  # of a trend that ends, what it reaches
        unit = one.comparison.unit + ("/year" if is_drift(first) and not years else "")
        times = years or 1.0
        told: set[float] = set()
        for name in alike:
            if (same := round(shown.expected[name], DIGITS)) in told:  # of the same law
                continue
            told.add(same)
            value = shown.expected[name] - aged
            error = float(np.hypot(shown.error, aged / SURE))
            outcome = outcome_of(size, value, error, shown.slack[name])
            numbers = (times * size, times * shown.error, times * value)
            checks.append(CrossCheck(one.column, name, *numbers, outcome, unit))
    return tuple(checks)


def outcome_of(
    size: float, expected: float, error: float, slack: float = SLACK
) -> CheckOutcome:
    """
    Whether a size is significantly nearer to the expected one than to 0.

    A size that is significantly nearer to twice the expected one has another cause, or
    a further one: it cannot tell. ``slack`` is the relative error of what is expected.
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
