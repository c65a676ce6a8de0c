"""Predict the size from which the loop's selection should find an effect."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pvlib_fem._loop.design import Design
from pvlib_fem._loop.dictionary import Candidate, Changed
from pvlib_fem._loop.divided_record import Case
from pvlib_fem._loop.ranking import squares_given_others
from pvlib_fem._loop.refits import Fits, Step
from pvlib_fem._loop.selection import Selection, selected
from pvlib_fem._loop.threads import one_blas_thread
from pvlib_fem._recovery.draw import Draw, dated_draws, same_days, with_ways
from pvlib_fem._recovery.inject import readable
from pvlib_fem.effects._effect import Effect
from pvlib_fem.reasons import Because, Reason, because

GROWS = 1.6  # factor from one size to the next, until the effect is selected
HALVINGS = 4  # bisections between the last size not selected and the first selected
LEAST = 1.0  # first size, in standard errors


def predictions(
    case: Case, step: Step, draws: int, seed: int, effect: Effect
) -> tuple[list[tuple[Draw, float, float]], Because | None]:
    """
    Draws of an effect with the sizes from which each should be found, or why none.

    The effect is added to the last model's remaining error, to first order, with
    increasing size until the selection chooses it, or a set with it, on about its
    dates.

    Parameters
    ----------
    case : Case
        The record of the loop.
    step : Step
        The last step of the loop.
    draws, seed : int
        Number of draws, and seed of the random numbers.
    effect : Effect
        Without dates.

    Returns
    -------
    list of (Draw, float, float), and Because or None
        Draw, predicted size, and estimate of the effect in the record itself.
    """
    with one_blas_thread():
        fits = Fits(case)
        days = np.unique(case.record.dates[case.searched])
        planned, why = dated_draws(
            effect, days, case.criteria.min_days_each_side, draws, seed
        )
        if why is not None:
            return [], why
        there = {one.name for one in step.model.effects if not one.sensor_fault}
        wanted = [one for one in case.wanted if one.name not in there]
        evidence = fits.gathered(step, wanted)
        name = effect.sensor_fault or effect.name
        if effect.name in evidence.failed or name in evidence.failed:
            return [], evidence.failed.get(effect.name) or evidence.failed[name]
        record = fits.ready["coarse"][1]
        design = Design.from_evidence(evidence, record, drivers=case.drivers)
        selection = Selection(design, case.criteria)
        looks = [Look(selection, candidate_of(design, draw)) for draw in planned]
        for look in looks:
            if not look.seen:
                return [], because(Reason.COLLINEAR)
        scores = [selection.score(look.one, [*design.base]) for look in looks]
        errors = [dict.fromkeys(effect.rows(), 0.0) | one.errors for one in scores]
        numbered = [
            replace(draw, effect=look.one.effect) for draw, look in zip(planned, looks)
        ]
        drawn_sizes = []
        for draw in with_ways(numbered, errors, seed):
            look, score = looks[draw.number], scores[draw.number]
            given = (draw.way, days, step.coefficients)
            draw = replace(draw, readable=readable(draw.effect, *given))
            least = LEAST * float(np.linalg.norm(score.stderr))
            own = sum(v * p for v, p in zip(score.estimate, draw.way.values()))
            drawn_sizes.append((draw, look.size(draw, least), float(own)))
        return drawn_sizes, None


def candidate_of(design: Design, draw: Draw) -> Candidate:
    """A draw as a candidate of the design."""
    effect = draw.effect
    if effect.sensor_fault:
        columns = (
            Changed.from_effect(design.sensor_faults[effect.sensor_fault], effect),
        )
    else:
        effect = design.effects.get(effect.name, effect)
        columns = design.own[effect.name]
    return Candidate(effect, columns, 0.0)


@dataclass(frozen=True, eq=False)
class Look:
    """Selection on a record with an added effect of some size."""

    selection: Selection
    one: Candidate

    @property
    def seen(self) -> bool:
        """Whether the effect is not collinear with the fitted coefficients."""
        design, size = self.selection.design, len(self.one.columns)
        squares = design.whole([*design.base, *self.one.columns])
        return bool(
            (
                squares_given_others(squares, size) > 1e-6 * np.diag(squares)[-size:]
            ).all()
        )

    def size(self, draw: Draw, least: float) -> float:
        """The least size at which the effect is found, or NaN."""
        return threshold(lambda size: self.is_found(draw, size), least, draw.most)

    def is_found(self, draw: Draw, size: float) -> bool:
        """Whether the effect is found at a size."""
        parts = [size * part for part in draw.way.values()]
        design = self.selection.design.adding(dict(zip(self.one.columns, parts)))
        selection, choices = selected(design, self.selection.criteria)
        for choice in selection.with_members(choices):
            mine = choice.members.get(self.one.name)
            if mine is None:
                continue
            if on_same_days(mine.effect, self.one.effect, design.dates):
                return True
        return False


def on_same_days(one: Effect, other: Effect, days: np.ndarray) -> bool:
    """Whether two effects of a name are on about the same days, if they have any."""
    return not other.sensor_fault or same_days(other, one, days)


def threshold(passes: Callable, least: float, most: float) -> float:
    """The size from which a test passes; NaN if it fails up to the largest size."""
    size, before = least, least
    while size <= most and not passes(size):
        before, size = size, GROWS * size
    if size > most:
        return np.nan
    for _ in range(HALVINGS):
        middle = np.sqrt(before * size)
        before, size = (before, middle) if passes(middle) else (middle, size)
    return float(size)
