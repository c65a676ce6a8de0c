"""References that have changed, where the module's temperature shows no change."""

from collections.abc import Iterable, Iterator, Mapping
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from pvlib_fem._findings import CheckOutcome, CrossCheck, Finding
from pvlib_fem._loop.cross_checks import outcome_of
from pvlib_fem._loop.references import DailyDeviation, kind
from pvlib_fem._record.column_names import twin_of
from pvlib_fem.effects import EFFECTS
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import dates_in_words, is_drift, weights_of

if TYPE_CHECKING:
    from pvlib_fem._loop.close import Round
    from pvlib_fem._loop.selection import ShownChange

LIGHT = "module_irradiance_step"  # what power shows, in words


def reference_faults(
    this: "Round",
    shown: Iterable[tuple[DailyDeviation, Mapping[str, "ShownChange"]]],
    findings: Iterable[Finding],
) -> Iterator[str]:
    """
    Second sensors and plants that have changed, in words.

    A second sensor or power deviates from an instrument from a date on, by a size that
    the module temperature contradicts. So the instrument has not changed.

    Parameters
    ----------
    this : Round
        The last one.
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
    suspected = {kind(EFFECTS[name]) for name in names if name in EFFECTS}
    # by day and by night one sensor is compared in two ways
    by_column = sorted(shown, key=lambda one: one[0].column)
    for _, some in groupby(by_column, key=lambda one: one[0].column):
        mine = [*some]
        if suspected & {name for one, _ in mine for name in one.comparison.shows}:
            continue
        found = [
            words
            for reference, changes in mine
            for change in changes.values()
            # power and sensors fade by themselves, and get dirty
            if not is_drift(change.effect)
            for words in contradicted(this, reference, change.effect)
        ]
        if found:
            yield max(found)[1]


def contradicted(
    this: "Round", reference: DailyDeviation, effect: Effect
) -> Iterator[tuple[float, str]]:
    """
    The change of a reference, if the temperature contradicts its instrument's.

    With its ratio to its standard error.
    """
    choice = this.selection.alone(effect, this.selection.given(this.choices))
    if choice is None:
        return
    weights = weights_of(effect, reference.days)
    size, stderr, _ = reference.along(weights)
    estimate = float(choice.score.estimate[0])
    seen, more = (
        reference.expected(effect, value, weights, this.coefficients)
        for value in (estimate, estimate * (1.0 + choice.size_error(effect.name)))
    )
    error = abs(more - seen)
    outcome = outcome_of(seen, size, float(np.hypot(stderr, error)))
    if outcome is CheckOutcome.CONTRADICTS:
        usual = twin_of(reference.column)
        name = effect.name if usual else LIGHT
        by_reference, by_module = (
            CrossCheck(reference.column, name, *numbers, 0.0, outcome, unit).reads
            for unit in [reference.comparison.unit]
            for numbers in ((size, stderr), (seen, error))
        )
        dates = dates_in_words(effect.settings)
        words = sentence(reference.column, usual, dates, by_reference, by_module)
        yield abs(size) / stderr, words


def sentence(
    column: str, usual: str | None, dates: str, by_reference: str, by_module: str
) -> str:
    """What has changed, when, by how much, and what to look at."""
    begin = f"{column} has changed, from {dates} on: "
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
