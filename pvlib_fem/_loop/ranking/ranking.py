"""How much of the remaining error each absent effect could explain."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.special import fdtrc, stdtrit

from pvlib_fem._loop.regression.design import Column, Design
from pvlib_fem._loop.regression.evidence import Evidence
from pvlib_fem._statistics.weekly_sums import given_first
from pvlib_fem.effects._effect import Effect
from pvlib_fem.reasons import Because, Reason, because

if TYPE_CHECKING:
    from pvlib_fem._loop.selection.choice import Score
    from pvlib_fem._loop.selection.dictionary import Candidate
    from pvlib_fem._loop.selection.single_effects import Selection

POWER = 0.8  # chance to see an effect of the minimum detectable size
LARGEST = 1e3  # standard errors, beyond which no size would be seen
UNSEEN = 1e-6  # of a column's square: its residual given others, by rounding
SEEN = 0.95  # probability from which an effect is there
TIED = 0.85  # share of its part that another explains, too


@dataclass(frozen=True, eq=False)
class Row:
    """Gain of one candidate given the effects of a model."""

    effect: Effect
    score: "Score"
    p_value: float  # for this candidate alone
    detectable: float  # minimum detectable gain [K]
    rows: int  # on which its drivers are there
    ties: tuple[str, ...]  # other candidates that explain as much
    note: Because | None

    @property
    def gain(self) -> float:
        """Root of the fall of the mean square on weeks left out, with its sign. [K]"""
        return float(np.copysign(np.sqrt(abs(self.score.fall)), self.score.fall))

    def content(self) -> dict[str, Any]:
        """The row of the table."""
        return {
            "gain": self.gain,
            "p_value": self.p_value,
            "coefficients": self.score.coefficients,
            "stderr": self.score.errors,
            "physical": self.score.possible,
            "minimum_detectable": self.detectable,
            "rows": self.rows,
            "ties": self.ties,
            "note": "" if self.note is None else str(self.note),
        }


def ranked(
    selection: "Selection",
    evidence: Evidence,
    given: Sequence[Column],
    days: int,
    taken: Collection[str] = (),
) -> tuple[dict[str, Row], dict[str, Because]]:
    """
    All candidates given what a model has, and those that could not be weighed.

    Parameters
    ----------
    selection : Selection
    evidence : Evidence
    given : sequence of int or Changed
        Columns given which each is weighed.
    days : int
        That count.
    taken : sequence of str
        Effects that the model has.

    Returns
    -------
    dict of Row, dict of Because
    """
    design, failed = selection.design.at(given), dict(evidence.failed)
    rows: dict[str, Row] = {}
    there: list[tuple[Candidate, np.ndarray]] = []
    for one in selection.with_same_law(selection.candidates(given, taken)):
        squares = design.whole([*given, *one.columns])
        size = len(one.columns)
        own = np.diag(squares)[-size:]
        remainder = np.diag(given_first(squares, len(given)))[1:]
        if not (own > 0).all():
            failed[one.name] = because(Reason.ADDS_NOTHING)
        elif (remainder < UNSEEN * own).any():
            failed[one.name] = because(Reason.COLLINEAR)
        else:
            there.append((one, remainder / design.count))
    names = {one.name for one, _ in there}
    for effect in design.changing:
        if effect.name not in names and effect.name not in {*taken}:
            failed.setdefault(effect.name, because(Reason.NO_DATE))
    others = [one for one, _ in there]
    falls = selection.in_sample(others, given)
    for place, (one, remainder) in enumerate(there):
        score = selection.score(one, given)
        before = rows.get(one.name)  # a trend of another part of the record
        if before is not None and before.score.fall >= score.fall:
            continue
        size = len(score.estimate)
        null = score.null + np.diag(np.diag(score.null)) * 1e-9
        statistic = score.seen @ np.linalg.solve(null, score.seen)
        scale = design.scales(one.columns)
        errors = np.sqrt(np.diag(null)) * scale * np.sqrt(remainder)
        detectable = errors_needed(one, design, score) * float(errors.max())
        rows[one.name] = Row(
            one.effect,
            score,
            float(fdtrc(size, score.freedom, max(statistic / size, 0.0))),
            float(detectable),
            evidence.known.get(one.name, len(evidence.rows)),
            equal_candidates(selection, place, others, falls, given),
            reason_against(
                one.effect, score, evidence, days, selection.criteria.min_days
            ),
        )
    return rows, failed


def errors_needed(one: "Candidate", design: Design, score: "Score") -> float:
    """Standard errors that its size needs to be seen, with the stated power."""
    rows = one.rows(design).values()
    way = np.sqrt(np.diag(score.null) / len(rows))
    least = one.size_seen(rows, way, score.null, score.freedom, SEEN)
    return min(least, LARGEST) + float(stdtrit(score.freedom, POWER))


def equal_candidates(
    selection: "Selection",
    place: int,
    candidates: Sequence["Candidate"],
    falls: np.ndarray,
    given: Sequence[Column],
) -> tuple[str, ...]:
    """
    Other candidates that explain as much as one, given which it has little left.

    ``falls`` has what each of them explains; ``place`` is that of the one.
    """
    one, own = candidates[place], falls[place]
    score = selection.score(one, given)
    least = selection.criteria.min_hint_reduction**2
    if not score.possible or own < least or score.probability < SEEN:
        return ()
    names = []
    for other, fall in zip(candidates, falls):
        if other.name == one.name or fall < TIED * own:
            continue
        shared = selection.alike(one, other, given)
        if shared >= TIED and selection.score(other, given).possible:
            names.append(other.name)
    return tuple(names)


def reason_against(
    effect: Effect, score: "Score", evidence: Evidence, days: int, least: int
) -> Because | None:
    """Why a candidate is no cause, if there is such a reason."""
    if not score.possible and score.fall > 0:
        there = {key.split(".")[0] for key in evidence.base}
        if effect.confounder or there & {*effect.confused_with}:
            return because(Reason.ANOTHER_CONFOUNDER)
        if "p_dc_per_area" in effect.drivers:  # power measures irradiance, too
            return because(Reason.SUSPECT_IRRADIANCE)
        return because(Reason.SUSPECT_SENSOR)
    if days < least:
        return because(Reason.TOO_SHORT, days=days, least=least)
    if "source" in effect.settings:
        return because(Reason.SOURCE, source=effect.settings["source"])
    return None
