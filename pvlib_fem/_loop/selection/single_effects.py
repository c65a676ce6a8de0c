"""Selection of candidates by the remaining error: which single effects there are."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._loop.regression.design import Changed, Column, Design
from pvlib_fem._loop.selection.change_dates import Costs, Scan
from pvlib_fem._loop.selection.change_sums import PROFILE_ERROR, UNSEEN, dates_cost
from pvlib_fem._loop.selection.choice import Choice, Score, ShownChange, Sized
from pvlib_fem._loop.selection.dictionary import (
    Candidate,
    all_candidates,
    within_bounds,
)
from pvlib_fem._loop.selection.noise import random_effects
from pvlib_fem._statistics.extremes import ALIKE, largest_first
from pvlib_fem._statistics.tables import Table
from pvlib_fem._statistics.weekly_sums import (
    LeastSquares,
    common_share,
    given_first,
    held_out,
    with_ridge,
)
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._instruments import INERTIA
from pvlib_fem.effects._time_profiles import follows_sun_alone, is_compared

BETTER = 1.02  # times as much as another explains a candidate has to, to replace it
MOST_SHOWN = 5.0  # log-likelihood by all references that one candidate adds or takes
SWEEPS = 4  # times that every choice is made anew given the others
MOST = 10  # effects in one model
#: part of the error of a law that looks like one other fault: it has several shapes
ONE_FAULT = 0.5
#: log-likelihood by references of each of several changes, given all others
Likelihoods = Callable[[Sequence[Sequence[Sized]]], Sequence[float]]


def selected(
    design: Design,
    criteria: Criteria,
    closed: frozenset[str],
    begin: Sequence[Choice],
    shown: Mapping[str, ShownChange],
    likelihoods: Likelihoods,
    error: float | None = None,
) -> tuple["Selection", list[Choice]]:
    """
    A selection and its choices, given the noise that remains.

    Parameters
    ----------
    design : Design
    criteria : Criteria
    closed : frozenset of str
        Names that are not to be taken.
    begin : sequence of Choice
        Choices from which the selection begins, perhaps of another design.
    shown : dict of ShownChange
        Changes that a second sensor or power shows, by name.
    likelihoods : callable
        Log-likelihoods by references of several changes and their sizes.
    error : float, optional
        Mean square error of the model without effects, if the design is of a model with
        some. [K²]

    Returns
    -------
    Selection, list of Choice
        Before other choices are tried by :func:`.refined`.
    """
    selection = Selection(design, criteria, closed, (), shown, likelihoods, error)
    choices = selection.run(placed_choices(design, begin, closed))
    given = selection.given(choices)
    if noise := random_effects(design.at(given), given, selection.least):
        selection = replace(selection, noise=noise, scores={})
        choices = selection.run(choices)
    return selection, choices


def placed_choices(
    design: Design, choices: Iterable[Choice], closed: frozenset[str]
) -> list[Choice]:
    """Choices with their columns of a design, as far as it has them."""
    placed = []
    for one in choices:
        effect = design.effects.get(one.top.name, one.top.effect)
        columns = design.columns_of(effect)
        if columns and effect.name not in closed:
            top = replace(one.top, effect=effect, columns=columns)
            placed.append(replace(one, top=top))
    return placed


@dataclass(eq=False)
class Selection:
    """Single effects, each given all others, as far as they are material and sure."""

    design: Design
    criteria: Criteria
    closed: frozenset[str] = frozenset()  # names that are not to be taken
    #: random effects, by which the certainty is computed
    noise: tuple[Table, ...] = ()
    #: changes that a second sensor or power shows, by name
    shown: Mapping[str, ShownChange] = field(default_factory=dict)
    likelihoods: Likelihoods | None = None
    #: mean square error without effects, if the design is of a model with some [K²]
    error: float | None = None
    #: candidates given some columns, and what each explains
    known: dict[frozenset[Column], list[Candidate]] = field(default_factory=dict)
    scores: dict[tuple, Score] = field(default_factory=dict)
    #: log-likelihoods by references of the changes among some columns
    logs: dict[frozenset[Column], dict[Column, float]] = field(default_factory=dict)
    #: what each change among some columns explains
    explained: dict[tuple[Column, ...], dict[Changed, float]] = field(
        default_factory=dict
    )
    #: what :meth:`seen` has made
    whitened: dict[Design, Design] = field(default_factory=dict, init=False)

    def seen(self, given: Collection[Column]) -> Design:
        """The design given some columns as generalised least squares sees it."""
        design = self.design.at(given)
        if design not in self.whitened:
            self.whitened[design] = design.whitened(self.noise)
        return self.whitened[design]

    def run(self, choices: Sequence[Choice] = (), without: str = "") -> list[Choice]:
        """All choices, the largest first, beginning with some; one profile left out."""
        settled = self.settled([*choices], without)
        seen: set[frozenset[Column]] = set()
        while True:
            grown = self.grown(settled, without)
            if len(grown) == len(settled):
                break
            settled = self.settled(grown, without)
            key = frozenset(c for one in settled for c in one.top.columns)
            if key in seen:  # one that comes lets another go, in turn
                break
            seen.add(key)
        return sorted(settled, key=lambda one: -one.fall)

    def grown(self, choices: list[Choice], without: str) -> list[Choice]:
        """Some choices, and all that are best given those before."""
        while len(choices) < MOST:
            best = self.best(choices, without=without)
            if best is None:
                break
            choices = [*choices, best]
        return choices

    def kept_beside(
        self, choices: Sequence[Choice], reported: Sequence[Choice]
    ) -> list[Choice]:
        """Choices that still explain something given those reported and all others."""
        kept = [*choices]
        for one in choices:
            others = [other for other in kept if other is not one]
            score = self.score(one.top, self.given([*reported, *others]))
            again = [replace(one, score=score)] if self.holds(score) else []
            at = kept.index(one)
            kept = [*kept[:at], *again, *kept[at + 1 :]]
        return kept

    def settled(self, choices: list[Choice], without: str) -> list[Choice]:
        """The choices when none is better replaced, or removed, given the others."""
        for _ in range(SWEEPS):
            changed = False
            for i in range(len(choices) - 1, -1, -1):
                mine = choices[i]
                others = [*choices[:i], *choices[i + 1 :]]
                now = self.score(mine.top, self.given(others))
                holds = self.holds(now)
                least = BETTER * self.worth(mine.top, now) if holds else 0.0
                better = self.best(others, least, without)
                if better is not None:
                    changed = changed or better.top.columns != mine.top.columns
                    choices = [*choices[:i], better, *choices[i + 1 :]]
                elif holds:
                    choices[i] = replace(mine, score=now)
                else:
                    choices, changed = others, True
            if not changed:
                break
        return choices

    def dated(
        self,
        choice: Choice,
        name: str,
        given: Sequence[Column],
        costs: Costs | None = None,
    ) -> Effect:
        """The change of a member, with the days between which its date is."""
        one, score = choice.members[name], choice.scores[name]
        return self.scan(given).first_days(one.change, score.z_score, costs)

    def scan(self, given: Sequence[Column]) -> Scan:
        """The search for dates given some columns."""
        return Scan.from_design(
            self.design.at(given), given, self.criteria.min_days_each_side
        )

    def given(self, choices: Iterable[Choice]) -> list[Column]:
        """Columns of the base and of some choices."""
        return [*self.design.base, *(c for one in choices for c in one.top.columns)]

    def candidates(
        self,
        given: Sequence[Column],
        taken: Iterable[str] = (),
        without: str = "",
    ) -> list[Candidate]:
        """Candidates given some columns, but taken names and one time profile."""
        key = frozenset(given)
        if key not in self.known:
            limits = self.criteria.min_days_each_side, self.criteria.prior_odds
            found = all_candidates(self.design.at(given), given, *limits)
            self.known[key] = self.with_shown([*found], given)
        closed = {*taken, *self.closed}
        others = [one for one in self.known[key] if one.name not in closed]
        return [one for one in others if not without or one.time_profile != without]

    def with_shown(
        self, found: list[Candidate], given: Sequence[Column]
    ) -> list[Candidate]:
        """Candidates, with those that a reference shows instead of worse ones."""
        for one in self.shown_candidates():
            same = [one, *(other for other in found if other.name == one.name)]
            shares = [worth_share(other, 1.0 / PROFILE_ERROR) for other in same]
            if not np.argmax(self.in_sample(same, given) * shares):
                found = [one, *(other for other in found if other.name != one.name)]
        return found

    def shown_candidates(self) -> Iterator[Candidate]:
        """Changes at the dates that a second sensor or power shows."""
        for effect, odds in self.shown.values():
            if (one := self.candidate_of(effect, odds)) is not None:
                yield one

    def candidate_of(self, effect: Effect, odds: float = 0.0) -> Candidate | None:
        """A change at known dates, with the log odds of it; None without a column."""
        prior = float(np.log(self.criteria.prior_odds))
        columns = self.design.columns_of(effect)
        if not columns:
            return None
        return Candidate(effect, columns, prior, prior - odds, dates_known=True)

    def with_same_law(self, candidates: Iterable[Candidate]) -> Iterator[Candidate]:
        """
        Candidates, each followed by other faults along its column on the same days.

        Temperature cannot tell such faults apart, so that one of them is searched for.
        References may.
        """
        for one in candidates:
            yield one
            for effect in self.design.of_same_law(one.effect):
                if effect.name not in self.closed:
                    columns = self.design.columns_of(effect)
                    yield replace(one, effect=effect, columns=columns)

    def taken(self, choices: Iterable[Choice]) -> frozenset[str]:
        """Names of some choices, and of other faults of the same law."""
        tops = (one.top for one in choices)
        return frozenset(one.name for one in self.with_same_law(tops))

    def best(
        self,
        choices: Sequence[Choice],
        least: float = 0.0,
        without: str = "",
    ) -> Choice | None:
        """
        The choice that is worth most given others, and more than that, or None.

        Of candidates that are worth the same, the first in the order of the dictionary
        is taken: rounding errors must not choose.
        """
        given = self.given(choices)
        best: Choice | None = None
        others = self.candidates(given, self.taken(choices), without)
        falls, most = self.in_sample(others, given), least
        # on weeks left out it seldom explains more than on those that are fitted
        bounds = falls * [worth_share(one, 1.0 / PROFILE_ERROR) for one in others]
        if self.likelihoods is not None:
            bounds += falls * self.nat * MOST_SHOWN
        for i in largest_first(bounds):
            if bounds[i] < most:
                break
            if falls[i] < self.least * self.acting(others[i]):
                continue
            score = self.score(others[i], given)
            worth = self.worth(others[i], score)
            if self.holds(score) and worth > most * (1.0 + ALIKE):
                best, most = Choice(others[i], score), worth
        return best

    def worth(self, one: Candidate, score: Score) -> float:
        """
        What a candidate explains, less what its dates cost, by references, too. [K²]

        Laws are compared by their error, as in the posterior, and so are references.
        """
        sure = min(score.z_score, 1.0 / PROFILE_ERROR)
        return score.fall * (worth_share(one, sure) + self.nat * score.shown)

    @property
    def nat(self) -> float:
        """Share of what a law explains that is one unit of its log-likelihood."""
        return 2.0 * self.criteria.law_error**2

    def best_shown(self, choices: Sequence[Choice]) -> Choice | None:
        """A change that a reference and the temperature show, or None."""
        given, closed = self.given(choices), self.closed | self.taken(choices)
        for one in self.shown_candidates():
            if one.name not in closed and one.beyond(given):
                score = self.score(one, given)
                there = score.probability >= self.criteria.min_probability
                if score.possible and there and score.fall > 0.0:
                    return Choice(one, score)
        return None

    @cached_property
    def least(self) -> float:
        """Fall of the mean square that is material. [K²]"""
        error, limits = self.error, self.criteria
        if error is None:
            error = self.design.at(self.design.base).base_error
        return max(limits.min_rmse_reduction**2, limits.min_error_share * error)

    def holds(self, score: Score) -> bool:
        """Whether it is possible, there and material."""
        there = score.probability >= self.criteria.min_probability
        return score.possible and there and score.fall >= self.least * score.acting

    def acting(self, one: Candidate) -> float:
        """Share of the record on which it acts: of days, if it is an event."""
        return self.design.acting(one.columns) if one.effect.turns else 1.0

    def in_sample(
        self, candidates: Sequence[Candidate], given: Sequence[Column]
    ) -> np.ndarray:
        """Fall of the mean square on the fitted weeks, by each candidate. [K²]"""
        design, size = self.design.at(given), len(given)
        falls = np.zeros(len(candidates))
        plain = [i for i, one in enumerate(candidates) if not one.effect.sensor_fault]
        places = dict.fromkeys(c for i in plain for c in candidates[i].columns)
        order = {c: i + 1 for i, c in enumerate(c for c in places if c not in given)}
        whole = design.whole([*given, *order])
        beyond = given_first(whole, size)
        for i in plain:
            at = [order[c] for c in candidates[i].columns if c in order]
            score = beyond[at, 0]
            falls[i] = score @ np.linalg.solve(beyond[np.ix_(at, at)], score)
        if dated := [i for i, one in enumerate(candidates) if one.effect.sensor_fault]:
            rows = np.array([design.row(candidates[i].change, given) for i in dated])
            base = with_ridge(whole[1 : size + 1, 1 : size + 1])
            mine = np.linalg.solve(base, rows[:, 1:-1].T)
            scores = rows[:, 0] - whole[0, 1 : size + 1] @ mine
            squares = rows[:, -1] - np.einsum("ij,ji->i", rows[:, 1:-1], mine)
            seen = squares > UNSEEN * rows[:, -1]
            falls[dated] = np.where(seen, scores**2 / np.where(seen, squares, 1.0), 0.0)
        return falls / design.count

    def alike(self, one: Candidate, other: Candidate, given: Sequence[Column]) -> float:
        """Share of what a candidate explains that another explains as well."""
        own, rival = one.beyond(given), other.beyond(given)
        whole = self.design.at(given).whole([*given, *own, *rival])
        return float(common_share(whole, len(own), len(rival)))

    def score(self, one: Candidate, given: Sequence[Column]) -> Score:
        """What a candidate explains given some columns."""
        key = one.columns, frozenset(given)
        if key in self.scores:
            return self.scores[key]
        design = self.design.at(given).fit_for([one.effect])
        own = one.beyond(given)
        weekly = design.by_week([*given, *own])
        size = len(own)
        plain, scale = LeastSquares(weekly, size), design.scales(own)
        unit = np.outer(scale, scale)
        estimate, covariance = plain.estimate / scale, plain.covariance / unit
        # sizes are those of the refit; whether there is one, of whitened columns
        whitened = plain
        if self.noise:
            whole = self.seen(given).fit_for([one.effect])
            whitened = LeastSquares(whole.by_week([*given, *own]), size)
        if one.effect.sensor_fault:
            # other dates are no placebo of a date: whatever is slow has some
            null, freedom = whitened.by_all_weeks()
            part, more = self.given_laws(one.change, given, float(null[0, 0]))
        else:
            null, freedom = self.seen(given).placebo(given, own, whitened)
            part, more = 1.0, 1.0
        rows = one.rows(design)
        null = more * null / unit
        seen = part * whitened.estimate / scale
        fits = within_bounds(rows.values(), estimate, np.sqrt(np.diag(covariance)))
        gain, acting = self.gain(one, given, weekly), self.acting(one)
        shown = beside = 0.0
        if fits and gain > 0.0:
            shown, beside = self.shown_with(one, given)
        # those that gave a change its dates are in its odds already
        new = beside if one.dates_known else shown
        there = one.existence(rows.values(), seen, null, freedom, new)
        self.scores[key] = Score(
            tuple(rows),
            gain,
            estimate,
            covariance,
            there,
            fits,
            seen,
            null,
            freedom,
            acting,
            shown,
        )
        return self.scores[key]

    def gain(
        self, one: Candidate, given: Sequence[Column], weekly: np.ndarray
    ) -> float:
        """
        Fall of the mean square on weeks left out in turn, by a candidate. [K²]

        What follows the sun alone, such as an obstacle, is searched for given all
        functions of the usual inputs, and also counts given them: an angle of incidence
        looks much like some window of the sky. ``weekly`` has the products of the
        given columns and its own.
        """
        design = self.design.at(given).fit_for([one.effect])
        own = one.beyond(given)
        if follows_sun_alone(one.effect):
            shapes = design.confounders_beyond(given)
            weekly = design.by_week([*given, *shapes, *own])
        inner = weekly[:, : -len(own), : -len(own)]
        fall = held_out(inner, design.folds) - held_out(weekly, design.folds)
        return fall / design.count

    def given_laws(
        self, change: Changed, given: Sequence[Column], noise: float
    ) -> tuple[float, float]:
        """
        Factors of the estimate of a change and its variance by the errors of laws.

        The law of a fault has a relative error. The error that remains has the dates of
        the fault and may look like another one: it is a random effect along the column
        of the change on those dates. The law of the module has one, too: one heat
        capacity stands for glass, frame and whatever warms behind the module, of which
        weather and season show other parts. Part of that looks like a change of the
        heat capacity from a date on, and two faults on one date may add up to one.
        ``noise`` is the variance of the estimate without these.
        """
        design = self.design.at(given)
        laws = {
            Changed.from_effect(change.place, one.effect): square
            for one, square in self.squares(given).items()
            if one.place != change.place and square > 0.0
        }
        slow = [
            Changed.from_effect(design.sensor_faults[name], change.effect)
            for name in INERTIA
            if name in design.sensor_faults
        ]
        if not laws and not slow:
            return 1.0, 1.0
        whole = design.whole([*given, *laws, *slow, change])
        beyond = given_first(whole, len(given))
        law, own = beyond[1:-1, 1:-1], beyond[1:-1, -1]
        # inverse variances of the sizes of these random effects, relative to the law's
        sizes = np.diag(law)[: len(laws)] / np.fromiter(laws.values(), float)
        capacities = [design.strength(c) / design.scale[c.place] ** 2 for c in slow]
        inverse = np.append(sizes, capacities) / self.law_variance
        prior = noise * beyond[-1, -1] * inverse
        share = np.linalg.solve(law + np.diag(prior), own)
        square = beyond[-1, -1] - share @ own
        score, more = beyond[0, 1:-1] @ share, beyond[-1, -1] / square
        part = 1.0 - score / beyond[0, -1] if beyond[0, -1] else 1.0
        return float(more * part), float(more)

    @property
    def law_variance(self) -> float:
        """Relative variance of a law, by that part of its error that is one fault."""
        return (ONE_FAULT * self.criteria.law_error) ** 2

    def squares(self, given: Sequence[Column]) -> dict[Changed, float]:
        """Sum of squares that each change among some columns explains."""
        key = tuple(given)
        if key not in self.explained:
            changes = [one for one in given if isinstance(one, Changed)]
            if changes:
                whole = self.design.at(given).whole(given)
                inverse = np.linalg.inv(with_ridge(whole[1:, 1:]))
                falls = (inverse @ whole[1:, 0]) ** 2 / np.diag(inverse)
            self.explained[key] = {c: float(falls[given.index(c)]) for c in changes}
        return self.explained[key]

    def shown_with(
        self, one: Candidate, given: Sequence[Column]
    ) -> tuple[float, float]:
        """
        By how much a candidate increases the log-likelihood of references.

        Of all effects that they may show, and of those that are given. References are
        not independent of each other, so that each counts as ``MOST_SHOWN`` at most.
        """
        before = sum(self.logs_by_references(given).values())
        after = self.logs_by_references([*given, *one.beyond(given)])
        own = sum(log for column, log in after.items() if column in one.columns)
        more = np.array([sum(after.values()), sum(after.values()) - own]) - before
        shown, beside = np.clip(more, -MOST_SHOWN, MOST_SHOWN).tolist()
        return shown, beside

    def logs_by_references(self, columns: Sequence[Column]) -> dict[Column, float]:
        """
        Log-likelihood by references of each effect that they show, by first column.

        Its size is that of least squares of all columns: where another effect would
        alter it, references may contradict both.
        """
        key = frozenset(columns)
        if self.likelihoods is None or key in self.logs:
            return self.logs.get(key, {})
        effects = self.compared_effects(columns)
        if not effects:
            return {}
        others = [one for one in columns if one not in effects]
        weekly = self.design.at(columns).by_week([*others, *effects])
        fit = LeastSquares(weekly, len(effects))
        scale = self.design.scales([*effects])
        sizes = fit.estimate / scale
        errors = np.sqrt(np.diag(fit.covariance)) / scale
        sized = [
            [
                Sized.from_errors(effect, float(size), float(error))
                for effect in (one, *self.design.of_same_law(one))
            ]
            for one, size, error in zip(effects.values(), sizes, errors)
        ]
        self.logs[key] = dict(zip(effects, self.likelihoods(sized)))
        return self.logs[key]

    def compared_effects(self, columns: Sequence[Column]) -> dict[Column, Effect]:
        """Effects that references may show among some columns, by the first column."""
        found: dict[Column, Effect] = {
            one: one.effect for one in columns if isinstance(one, Changed)
        }
        for name, (first, *_) in self.design.own.items():
            effect = self.design.effects[name]
            if first in columns and is_compared(effect):
                found[first] = effect
        return found


def worth_share(one: Candidate, sure: float) -> float:
    """
    Share of what a candidate explains beyond the cost of its dates.

    It is the scale of the posterior among time profiles: half of the squared standard
    errors are the logarithm of the likelihood of all that it explains.
    """
    cost = dates_cost(one.dates, sure)
    return 1.0 - 2.0 * cost / max(sure, 1e-12) ** 2
