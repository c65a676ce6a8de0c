"""Compare the findings of a loop with an injected effect and with the baseline."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._converter import AnyFloat
from pvlib_fem._findings import Finding, Verdict
from pvlib_fem._former_names import fields_in_new_names
from pvlib_fem._loop.close import close_loop
from pvlib_fem._recovery.draw import Injection, holds_truth
from pvlib_fem.effects._effect import Effect

INTERVAL = 1.96  # standard errors of 95 %


@fields_in_new_names({"named": "identified", "told": "reported"})
@dataclass(frozen=True)
class Outcome:
    """
    Result of an injection.

    Attributes
    ----------
    injection : Injection
    found : bool
        Whether a finding in the model has it among its candidates; a fault with dates
        also on about the same days.
    identified, first : bool
        Whether it is identified; whether it is the first finding that the record itself
        does not show.
    reported : tuple of str
        Findings that the record itself does not show, each with its candidates and
        dates.
    wrong : tuple of str
        Identified causes among these findings that are not the truth.
    misled : tuple of str
        Ambiguous ones among these findings without the truth among their candidates.
    lost : tuple of str
        Findings of the record itself that are no longer there.
    ratio : float
        Found coefficients over true ones, projected on these; NaN if not in the model.
    covered, in_range : float
        Whether the truth is within 1.96 standard errors, and within the finding's
        range; for several coefficients the share, NaN without any.
    half_range : float
        Half the width of that range relative to the truth, averaged over coefficients.
    refused : str
        Why the loop refused the record; empty if it did not.
    """

    injection: Injection
    found: bool = False
    identified: bool = False
    first: bool = False
    reported: tuple[str, ...] = ()
    wrong: tuple[str, ...] = ()
    misled: tuple[str, ...] = ()
    lost: tuple[str, ...] = ()
    ratio: AnyFloat = np.nan
    covered: AnyFloat = np.nan
    in_range: AnyFloat = np.nan
    half_range: AnyFloat = np.nan
    refused: str = ""

    @property
    def key(self) -> str:
        """Key of its injection."""
        return self.injection.key


def recovered(
    data: pd.DataFrame, injector: Any, baseline: tuple, how: dict, injection: Injection
) -> Outcome:
    """
    Add an effect to a record, close the loop, and judge its findings.

    Parameters
    ----------
    data : DataFrame
        The record.
    injector : Injector
        Of the same record.
    baseline : tuple of Finding
        Findings of the loop on the record itself.
    how : dict
        Arguments of the loop.
    injection : Injection
        The effect, with its dates and size.

    Returns
    -------
    Outcome
        ``refused`` if the loop raises a ValueError.
    """
    try:
        loop = close_loop(injector.into(data, injection), **how)
    except ValueError as error:
        return Outcome(injection, refused=str(error))
    return judged(injection, injector.effect(injection), loop, baseline)


def judged(injection: Injection, effect: Effect, loop: Any, baseline: tuple) -> Outcome:
    """The outcome of an injection, from the truth and the baseline's findings."""
    before = [f for f in baseline if f.added]
    added = [f for f in loop.finding_objects if f.added]
    effects = {e.name: e for e in loop.fit.effects}
    days = np.unique(loop.fit.record.dates)
    # effects of the baseline are never injected, so an ambiguous finding with the
    # injected effect counts as found, even if it also has an effect of the baseline
    right = [f for f in added if holds_truth(f, effect, effects, days)]
    new = [
        f
        for f in added
        if f in right or not any(share_candidate(f, one) for one in before)
    ]
    others = [f for f in new if effect.name not in f.candidates]
    names = [f.effect for f in others if f.verdict is Verdict.IDENTIFIED]
    sets = [candidates_text(f) for f in others if f.verdict is Verdict.AMBIGUOUS]
    lost = [
        candidates_text(f)
        for f in before
        if not any(share_candidate(f, other) for other in added)
    ]
    sizes = {}
    if right and right[0].effect == effect.name:
        sizes = accuracy(right[0], injection.coefficients)
    return Outcome(
        injection,
        found=bool(right),
        identified=any(f.verdict is Verdict.IDENTIFIED for f in right),
        first=bool(right) and right[0] is new[0],
        reported=tuple(
            ", ".join(filter(None, (candidates_text(f), f.place))) for f in new
        ),
        wrong=tuple(names),
        misled=tuple(sets),
        lost=tuple(lost),
        **sizes,
    )


def share_candidate(one: Finding, other: Finding) -> bool:
    """Whether two findings share a candidate."""
    return not {*one.candidates}.isdisjoint(other.candidates)


def candidates_text(finding: Finding) -> str:
    return " | ".join(finding.candidates)


def accuracy(finding: Finding, truth: dict) -> dict:
    """Ratio, coverage and range of a finding's coefficients, given the true ones."""
    values, errors = finding.coefficients, finding.stderr
    square = sum(value**2 for value in truth.values())
    along = sum(values[name] * value for name, value in truth.items())
    within = [
        abs(values[n] - value) <= INTERVAL * errors[n] for n, value in truth.items()
    ]
    # a held coefficient has no range, and a true 0 has no relative width
    known = [(finding.ranges[n], v) for n, v in truth.items() if n in finding.ranges]
    inside = [low <= value <= high for (low, high), value in known]
    halves = [(high - low) / 2.0 / abs(v) for (low, high), v in known if v != 0.0]
    return {
        "ratio": float(along / square),
        "covered": float(np.mean(within)),
        "in_range": float(np.mean(inside)) if inside else np.nan,
        "half_range": float(np.mean(halves)) if halves else np.nan,
    }
