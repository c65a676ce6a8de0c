"""Predict the size from which the loop's selection should find an effect."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pvlib_fem._loop.criteria import HALF
from pvlib_fem._loop.preparation.divided_record import Case
from pvlib_fem._loop.references.comparisons import kind
from pvlib_fem._loop.references.cross_checks import log_likelihoods_of_sizes
from pvlib_fem._loop.references.deviations import DailyDeviation, daily_deviations
from pvlib_fem._loop.references.joint_dates import weighed_by_references
from pvlib_fem._loop.references.shown_changes import with_best_odds, with_own
from pvlib_fem._loop.regression.design import Changed, Column, Design
from pvlib_fem._loop.regression.refits import Step
from pvlib_fem._loop.search import Round
from pvlib_fem._loop.selection.choice import Choice
from pvlib_fem._loop.selection.dictionary import Candidate
from pvlib_fem._loop.selection.noise import with_outside
from pvlib_fem._loop.selection.refinement import refined
from pvlib_fem._loop.selection.rivals import OVERLAP
from pvlib_fem._loop.selection.single_effects import Selection, selected
from pvlib_fem._loop.threads import one_blas_thread
from pvlib_fem._recovery.draw import Draw, dated_draws, same_days, with_ways
from pvlib_fem._recovery.inject import readable, whole_of
from pvlib_fem._statistics.weekly_sums import given_first
from pvlib_fem.effects._effect import Effect
from pvlib_fem.reasons import Because, Reason, because

GROWS = 1.6  # factor from one size to the next, until the effect is selected
HALVINGS = 4  # bisections between the last size not selected and the first selected
LEAST = 1.0  # first size, in standard errors


def predictions(
    case: Case, last: Round | None, step: Step, draws: int, seed: int, effect: Effect
) -> tuple[list[tuple[Draw, float, float]], Because | None]:
    """
    Draws of an effect with the sizes from which each should be found, or why none.

    The effect is added to the last model's remaining error, to first order in what it
    changes, with increasing size until the selection finds it, or a set with it, on
    about its dates, among all that the record itself shows.

    Parameters
    ----------
    case : Case
        The record of the loop.
    last : Round or None
        The last selection of the loop, if there was one.
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
        days = np.unique(case.record.dates[case.searched])
        planned, why = dated_draws(
            effect, days, case.criteria.min_days_each_side, draws, seed
        )
        if why is not None:
            return [], why
        if last is None:
            return [(draw, np.nan, np.nan) for draw in planned], None
        failed = last.evidence.failed
        for name in (effect.name, effect.sensor_fault):
            if name in failed:
                return [], failed[name]
        selection = last.selection
        references = daily_deviations(case) if effect.sensor_fault else []
        looks = [
            Look(
                selection,
                last.choices,
                candidate_of(selection.design, draw),
                step.coefficients,
                references,
            )
            for draw in planned
        ]
        if not all(look.seen for look in looks):
            return [], because(Reason.COLLINEAR)
        scores = [selection.score(one.one, one.given) for one in looks]
        errors = [dict.fromkeys(effect.rows(), 0.0) | one.errors for one in scores]
        numbered = [
            replace(
                draw, effect=look.one.effect, bounds=look.one.rows(selection.design)
            )
            for draw, look in zip(planned, looks)
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
    if not effect.sensor_fault:
        effect = design.effects.get(effect.name, effect)
    return Candidate(effect, design.columns_of(effect), 0.0)


@dataclass(frozen=True, eq=False)
class Look:
    """Selection on a record with an added effect of some size."""

    selection: Selection
    choices: tuple[Choice, ...]  # that the record itself shows
    one: Candidate
    coefficients: dict[str, float]  # of the loop's model
    references: list[DailyDeviation]

    @property
    def given(self) -> list[Column]:
        """Columns of the base, and of what else the record itself shows."""
        return self.selection.given(
            other for other in self.choices if other.top.name != self.one.name
        )

    @property
    def seen(self) -> bool:
        """Whether the effect is not collinear with the fitted coefficients."""
        design, size = self.selection.design, len(self.one.columns)
        squares = design.whole([*design.base, *self.one.columns])
        remainder = np.diag(given_first(squares, len(design.base)))[1:]
        return bool((remainder > 1e-6 * np.diag(squares)[-size:]).all())

    def size(self, draw: Draw, least: float) -> float:
        """The least size at which the effect is found, or NaN."""
        return threshold(lambda size: self.is_found(draw, size), least, draw.most)

    def is_found(self, draw: Draw, size: float) -> bool:
        """Whether the effect is found at a size."""
        parts = [size * part for part in draw.way.values()]
        added = np.sum([*map(self.residual_of, self.one.columns, parts)], axis=0)
        design = self.selection.design.adding(added)
        limits, closed = self.selection.criteria, self.selection.closed
        selection = Selection(design, limits, closed)
        (fall,) = selection.in_sample([self.one], self.given)
        if fall < OVERLAP * selection.least:
            return False  # too small for any set
        seen = (self.shown_by(one, sum(parts)) for one in self.references)
        pairs = with_own(seen, limits)
        references = [one for one, _ in pairs]
        shown = with_best_odds(changes for _, changes in pairs)
        selection, choices = selected(
            design,
            limits,
            closed,
            self.choices,
            shown,
            partial(log_likelihoods_of_sizes, references, self.coefficients),
        )
        choices = refined(selection, choices)
        for i, one in enumerate(choices):
            others = [*choices[:i], *choices[i + 1 :]]
            compared = [one.given(others) for one in references]
            given_all = others, compared, self.coefficients
            choice, logs = weighed_by_references(selection, one, *given_all)
            mine = choice.members.get(self.one.name)
            if mine is None or not on_same_days(
                mine.effect, self.one.effect, design.dates
            ):
                continue
            given = selection.given(others)
            choice = with_outside(design.at(given), choice, given, limits, logs)
            if self.one.name in choice.credible_names(limits.min_probability):
                known = choice.untested <= HALF
                return known or self.one.effect.unseen_light
        return False

    def residual_of(self, column: Column, size: float) -> np.ndarray:
        """
        Residual by a coefficient, in the cells of the design. [K]

        The residual is in proportion to the faulty reading.
        """
        design = self.selection.design
        (scale,) = design.scales([column])
        added = size * scale * design.values(column)
        whole = whole_of(self.one.effect.sensor_fault, self.coefficients)
        if whole is not None and isinstance(column, Changed):
            added = added / (1.0 + size * design.weight(column) / whole)
        return added

    def shown_by(self, reference: DailyDeviation, size: float) -> DailyDeviation:
        """What a reference shows when the sensor has the fault, or dirt, too."""
        effect = self.one.effect
        shows = reference.comparison.shows.get(kind(effect))
        if shows is None or effect.turns:
            return reference
        change = shows(reference.change(effect, size), self.coefficients)
        return replace(reference, apart=reference.apart + change)


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
