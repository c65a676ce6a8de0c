"""References that have changed, where the module's temperature shows no change."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import groupby

import numpy as np

from pvlib_fem._findings import CheckOutcome, CrossCheck, Finding
from pvlib_fem._loop.references.comparisons import kind
from pvlib_fem._loop.references.cross_checks import outcome_of
from pvlib_fem._loop.references.deviations import DailyDeviation
from pvlib_fem._loop.selection.choice import Choice, ShownChange
from pvlib_fem._record.column_names import twin_of
from pvlib_fem.effects import EFFECTS
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import dates_in_words, is_drift, weights_of

SizeOf = Callable[[Effect], Choice | None]
LIGHT = "module_irradiance_step"  # what power shows, in words


def reference_faults(
    by_module: SizeOf,
    coefficients: Mapping[str, float],
    shown: Iterable[tuple[DailyDeviation, Mapping[str, ShownChange]]],
    findings: Iterable[Finding],
) -> Iterator[str]:
    """
    Second sensors and plants that have changed, or may have, in words.

    A second sensor or power deviates from an instrument from a date on. If the module
    temperature contradicts that size, the instrument has not changed. If it cannot
    tell, either may have.

    Parameters
    ----------
    by_module : callable
        A change with its size by the module temperature, or None.
    coefficients : dict
        Of the fitted model.
    shown : iterable of (DailyDeviation, dict of ShownChange)
        Changes that each reference shows, by name.
    findings : iterable of Finding
        All, hints among them. If one of these may be a fault of the instrument, the
        reference is not named.

    Yields
    ------
    str
    """
    names = {name for one in findings for name in one.candidates}
    effects = [EFFECTS[name] for name in names if name in EFFECTS]
    # what comes and goes with the weather is no change from a date on
    suspected = {kind(one) for one in effects if one.sensor_fault or one.turns}
    # by day and by night one sensor is compared in two ways
    by_column = sorted(shown, key=lambda one: one[0].column)
    for _, some in groupby(by_column, key=lambda one: one[0].column):
        mine = [*some]
        if suspected & {name for one, _ in mine for name in one.comparison.shows}:
            continue
        found = [
            words
            for reference, changes in mine
            for name, change in changes.items()
            # power and sensors fade by themselves, and get dirty
            if not is_drift(change.effect)
            for words in unexplained(
                by_module,
                coefficients,
                given_others(reference, changes, name),
                change,
            )
        ]
        if found:
            yield max(found)[-1]


def given_others(
    reference: DailyDeviation, changes: Mapping[str, ShownChange], name: str
) -> DailyDeviation:
    """A reference given the changes that it shows, but one."""
    others = (one.effect for other, one in changes.items() if other != name)
    return reference.given_effects(others)


def unexplained(
    by_module: SizeOf,
    coefficients: Mapping[str, float],
    reference: DailyDeviation,
    change: ShownChange,
) -> Iterator[tuple[bool, float, str]]:
    """
    The change of a reference that is no finding.

    With whether the temperature contradicts that its instrument has changed, and with
    its ratio to its standard error.
    """
    effect = change.effect
    choice = by_module(effect)
    weights = weights_of(effect, reference.days)
    if choice is None or not reference.sees(weights):
        return
    size, stderr, _ = reference.along(weights)
    estimate = float(choice.score.estimate[0])
    seen, more = (
        reference.expected(effect, value, weights, coefficients)
        for value in (estimate, estimate * (1.0 + choice.sized(effect.name).error))
    )
    error = abs(more - seen)
    outcome = outcome_of(seen, size, float(np.hypot(stderr, error)))
    usual = twin_of(reference.column)
    name = effect.name if usual else LIGHT
    sizes = (
        CrossCheck(reference.column, name, *numbers, 0.0, outcome, unit).reads
        for unit in [reference.comparison.unit]
        for numbers in ((size, stderr), (seen, error))
    )
    contradicted = outcome is CheckOutcome.CONTRADICTS
    dates = dates_in_words(effect.settings)
    dates = dates if "until" in dates else f"{dates} on"
    words = sentence if contradicted else undecided_sentence
    said = words(reference.column, usual, dates, *sizes)
    yield contradicted, abs(size) / stderr, said


def sentence(
    column: str, usual: str | None, dates: str, by_reference: str, by_module: str
) -> str:
    """What has changed, when, by how much, and what to look at."""
    begin = f"{column} has changed, from {dates}: "
    if usual is None:
        return (
            f"{begin}at the same irradiance it is {by_reference}, but by the module "
            f"temperature the modules receive {by_module}; check modules, strings and "
            "inverters"
        )
    return (
        f"{begin}by it {usual} reads {by_reference}, but by the module temperature "
        f"{by_module}; check the sensor of {column}"
    )


def undecided_sentence(
    column: str, usual: str | None, dates: str, by_reference: str, by_module: str
) -> str:
    """What deviates, since when, by how much, and what to look at."""
    if usual is None:
        return (
            f"{column} and poa_global deviate, from {dates}: at the same irradiance "
            f"power is {by_reference}. By the module temperature the modules receive "
            f"{by_module}, which cannot tell whether the plant or the irradiance "
            "sensor has changed; check both"
        )
    return (
        f"{column} and {usual} deviate, from {dates}: by {column} {usual} reads "
        f"{by_reference}, by the module temperature {by_module}, which cannot tell "
        "which of the two has changed; check both sensors"
    )
