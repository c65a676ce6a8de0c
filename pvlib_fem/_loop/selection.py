"""Selection of candidates by the remaining error: which single effects there are."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pvlib_fem._loop.change_dates import Scan
from pvlib_fem._loop.change_sums import PROFILE_ERROR, UNSEEN, dates_cost
from pvlib_fem._loop.choice import Choice, Score, Sized
from pvlib_fem._loop.criteria import TINY, Criteria
from pvlib_fem._loop.design import Changed, Column, Design
from pvlib_fem._loop.dictionary import (
    Candidate,
    all_candidates,
    log_odds,
    within_bounds,
)
from pvlib_fem._loop.noise import random_effects
from pvlib_fem._loop.posterior import posterior
from pvlib_fem._record.column_names import is_power, twin_of
from pvlib_fem._statistics.extremes import ALIKE, largest_first
from pvlib_fem._statistics.tables import Table
from pvlib_fem._statistics.weekly_sums import (
    LeastSquares,
    explainable_share,
    given_first,
    held_out,
    with_ridge,
)
from pvlib_fem.effects import CHANGES
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import is_dated

if TYPE_CHECKING:
    from pvlib_fem._loop.references import DailyDeviation

BETTER = 1.02  # times as much as another explains a candidate has to, to replace it
OVERLAP = 0.3  # share of the best one's part, from which another is its rival
DOUBT = 0.5  # probability below which another is no rival
MOST_SHOWN = 5.0  # log-likelihood by all references that one candidate adds or takes
SWEEPS = 4  # times that every choice is made anew given the others
MOST = 10  # effects in one model
#: log-likelihood by references of each of several changes, given all others
Likelihoods = Callable[[Sequence[Sequence[Sized]]], Sequence[float]]


def selected(
    design: Design,
    criteria: Criteria,
    closed: frozenset[str],
    begin: Sequence[Choice],
    shown: Mapping[str, "ShownChange"],
    likelihoods: Likelihoods,
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

    Returns
    -------
    Selection, list of Choice
        Before other choices are tried by :meth:`Selection.refined`.
    """
    selection = Selection(design, criteria, closed, (), shown, likelihoods)
    choices = selection.run(placed_choices(design, begin, closed))
    given = selection.given(choices)
    if noise := random_effects(design, given, selection.least):
        selection = replace(selection, noise=noise, known={}, scores={})
        choices = selection.run(choices)
    return selection, choices


class ShownChange(NamedTuple):
    """A change with its dates, by which a reference deviates from an instrument."""

    effect: Effect
    #: logarithm of the odds that it is the instrument that has changed
    log_odds: float


def shown_changes(
    references: Iterable["DailyDeviation"], criteria: Criteria
) -> dict[str, ShownChange]:
    """
    Changes by which second sensors and power deviate from instruments, with dates.

    Parameters
    ----------
    references : iterable of DailyDeviation
        Of all that is compared with instruments.
    criteria : Criteria
        Of the loop. A change of any size counts.

    Returns
    -------
    dict of ShownChange
        By name. If several references show one, it is that with the best odds.
    """
    return with_best_odds(shown_by(one, criteria) for one in references)


def shown_by(reference: "DailyDeviation", criteria: Criteria) -> dict[str, ShownChange]:
    """
    Changes by which a second sensor or power deviates from an instrument, with dates.

    They are selected as those of the module temperature, from the daily deviation of
    the two. The temperature decides which of the two has changed. The odds of a second
    sensor are even. A plant's power also changes by its modules and inverters, so that
    the odds are those of any effect.

    Parameters
    ----------
    reference : DailyDeviation
    criteria : Criteria
        Of the loop. A change of any size counts.

    Returns
    -------
    dict of ShownChange
        By name.
    """
    if twin_of(reference.column) is not None:
        odds = 0.0
    elif is_power(reference.column):
        odds = float(np.log(criteria.prior_odds))
    else:
        return {}
    faults, days = reference.comparison.shows, reference.days
    changing = [e for e in CHANGES.values() if e.sensor_fault in faults]
    always = np.ones(len(days))
    # in another plane, a second sensor of light differs with the season
    columns = enumerate([always, *reference.year(least=1)])
    usual = {str(i): column for i, column in columns}
    design = Design.of_columns(reference.apart, usual, always, days, changing)
    # outliers were left out, and compared with its noise a change would be one
    design = replace(design, outliers=False)
    limits = replace(criteria, min_rmse_reduction=TINY, min_error_share=TINY)
    effects = [choice.top.effect for choice in Selection(design, limits).run()]
    return {effect.name: ShownChange(effect, odds) for effect in effects}


def with_best_odds(
    shown: Iterable[Mapping[str, ShownChange]],
) -> dict[str, ShownChange]:
    """
    Changes that several references show, each with the best of its odds.

    Parameters
    ----------
    shown : iterable of dict of ShownChange
        By name, of each reference.

    Returns
    -------
    dict of ShownChange
        Of the same odds the first.
    """
    best: dict[str, ShownChange] = {}
    for some in shown:
        for name, change in some.items():
            if name not in best or change.log_odds > best[name].log_odds:
                best[name] = change
    return best


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
    #: candidates given some columns, and what each explains
    known: dict[frozenset[Column], list[Candidate]] = field(default_factory=dict)
    scores: dict[tuple, Score] = field(default_factory=dict)
    #: log-likelihoods by references of the changes among some columns
    logs: dict[frozenset[Column], dict[Column, float]] = field(default_factory=dict)

    @cached_property
    def seen(self) -> Design:
        """The design as generalised least squares sees it."""
        return self.design.whitened(self.noise)

    def run(self, choices: Sequence[Choice] = (), without: str = "") -> list[Choice]:
        """All choices, the largest first, beginning with some; one profile left out."""
        settled = self.settled([*choices], without)
        seen: set[frozenset[Column]] = set()
        while len(settled) < MOST:
            best = self.best(settled, without=without)
            if best is None:
                break
            settled = self.settled([*settled, best], without)
            key = frozenset(c for one in settled for c in one.top.columns)
            if key in seen:  # one that comes lets another go, in turn
                break
            seen.add(key)
        return sorted(settled, key=lambda one: -one.fall)

    def refined(self, choices: list[Choice]) -> list[Choice]:
        """
        The choices, or others that explain more, as far as these are tried.

        What they explain by each effect more has to be material, and so what is lost by
        one less. Of as many effects, those with fewer dates need no margin.
        """
        remaining = self.remaining(choices)
        for _ in range(SWEEPS):
            for other, better in self.alternatives(choices):
                more = (len(other) - len(choices)) * self.least
                if not more and dates_of(other) >= dates_of(choices):
                    more = better
                less = self.remaining(other)
                if less < remaining - more:
                    choices, remaining = other, less
                    break
            else:
                break
        return choices

    def remaining(self, choices: Sequence[Choice]) -> float:
        """Mean square on weeks left out in turn, given some choices. [K²]"""
        weekly = self.design.by_week(self.given(choices))
        return held_out(weekly, self.design.folds) / self.design.count

    def alternatives(
        self, choices: list[Choice]
    ) -> Iterator[tuple[list[Choice], float]]:
        """
        Other choices, and by how much they have to be better. [K²]

        One time profile can stand for two, such as a temporary change for a trend and a
        step. So each change is left out, the others are made anew without its time
        profile, and then with it, as the refinement of SuSiE does (Zou et al., 2022).
        Two changes can also hide each other, such as a trend until a sensor is cleaned.
        """
        for one in choices:
            if one.top.effect.sensor_fault:
                profile = one.top.time_profile
                others = [other for other in choices if other is not one]
                others = self.run(others, profile)
                better = (BETTER - 1.0) * one.fall
                yield self.run(others), better
                for pair in self.hidden_pairs(others, profile):
                    yield self.run([*others, *pair]), better
        for pair in self.hidden_pairs(choices):
            yield self.run([*choices, *pair]), 0.0

    def hidden_pairs(
        self, choices: list[Choice], without: str = ""
    ) -> Iterator[list[Choice]]:
        """
        Two changes, of which the first is not sure alone, and both are together.

        The odds of both are those of the first alone times those of the second given
        it.
        """
        given = self.given(choices)
        others = self.candidates(given, self.taken(choices), without)
        others = [one for one in others if one.effect.sensor_fault]
        falls = self.in_sample(others, given)
        firsts: dict[str, Candidate] = {}
        for i in largest_first(falls):
            if falls[i] >= self.least:
                firsts.setdefault(others[i].time_profile, others[i])
        for one in firsts.values():
            alone = self.score(one, given)
            if not alone.possible or alone.fall < self.least:
                continue
            second = self.best([*choices, Choice(one, alone)], without=without)
            if second is None:
                continue
            both = log_odds(alone.probability) + log_odds(second.score.probability)
            beside = self.score(one, self.given([*choices, second]))
            if self.holds(beside) and both >= log_odds(self.criteria.min_probability):
                yield [Choice(one, beside), second]

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

    def dated(self, choice: Choice, name: str, given: Sequence[Column]) -> Effect:
        """The effect of a member, with the days between which its date is."""
        one, score = choice.members[name], choice.scores[name]
        if not one.effect.sensor_fault:
            return one.effect
        return self.scan(given).first_days(one.change, score.z_score)

    def scan(self, given: Sequence[Column]) -> Scan:
        """The search for dates given some columns."""
        return Scan.from_design(self.design, given, self.criteria.min_days_each_side)

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
            found = all_candidates(self.design, given, *limits)
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

    def alone(self, effect: Effect, given: Sequence[Column]) -> Choice | None:
        """A change at known dates as the only member of a choice, or None."""
        one = self.candidate_of(effect)
        if one is None or not one.beyond(given):
            return None
        score = self.score(one, given)
        choice = Choice(one, score, {one.name: one}, {one.name: score})
        return replace(choice, confounded=self.confounded(choice, given))

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
        given = self.given(choices)
        for one in self.shown_candidates():
            if one.name not in self.closed and one.beyond(given):
                score = self.score(one, given)
                there = score.probability >= self.criteria.min_probability
                if score.possible and there and score.fall > 0.0:
                    return Choice(one, score)
        return None

    @cached_property
    def least(self) -> float:
        """Fall of the mean square that is material. [K²]"""
        mean = held_out(self.design.by_week(self.design.base), self.design.folds)
        limits = self.criteria
        return max(
            limits.min_rmse_reduction**2,
            limits.min_error_share * mean / self.design.count,
        )

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
        design, size, falls = self.design, len(given), np.zeros(len(candidates))
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
        """Share of the part of a candidate that another would explain as well."""
        own, rival = one.beyond(given), other.beyond(given)
        whole = self.design.whole([*given, *own, *rival])
        return float(explainable_share(whole, len(own), len(rival)))

    def score(self, one: Candidate, given: Sequence[Column]) -> Score:
        """What a candidate explains given some columns."""
        key = one.columns, frozenset(given)
        if key in self.scores:
            return self.scores[key]
        design, own = self.design.fit_for([one.effect]), one.beyond(given)
        weekly = design.by_week([*given, *own])
        size = len(own)
        inner = weekly[:, :-size, :-size]
        gain = held_out(inner, design.folds) - held_out(weekly, design.folds)
        plain, scale = LeastSquares(weekly, size), design.scales(own)
        unit = np.outer(scale, scale)
        estimate, covariance = plain.estimate / scale, plain.covariance / unit
        # sizes are those of the refit; whether there is one, of whitened columns
        whitened = plain
        if self.noise:
            whole = self.seen.fit_for([one.effect])
            whitened = LeastSquares(whole.by_week([*given, *own]), size)
        if one.effect.sensor_fault:
            # other dates are no placebo of a date: whatever is slow has some
            null, freedom = whitened.by_all_weeks()
        else:
            null, freedom = self.seen.placebo(given, own, whitened)
        rows, null = one.rows(design), null / unit
        seen = whitened.estimate / scale
        fits = within_bounds(rows.values(), estimate, np.sqrt(np.diag(covariance)))
        gain, acting = gain / design.count, self.acting(one)
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

    def shown_with(
        self, one: Candidate, given: Sequence[Column]
    ) -> tuple[float, float]:
        """
        By how much a candidate increases the log-likelihood of references.

        Of all effects with dates, and of those that are given. References are not
        independent of each other, so that each counts as ``MOST_SHOWN`` at most.
        """
        before = sum(self.logs_by_references(given).values())
        after = self.logs_by_references([*given, *one.beyond(given)])
        own = sum(log for column, log in after.items() if column in one.columns)
        more = np.array([sum(after.values()), sum(after.values()) - own]) - before
        shown, beside = np.clip(more, -MOST_SHOWN, MOST_SHOWN).tolist()
        return shown, beside

    def logs_by_references(self, columns: Sequence[Column]) -> dict[Column, float]:
        """
        Log-likelihood by references of each effect with dates, by its first column.

        Its size is that of least squares of all columns: where another effect would
        alter it, references may contradict both.
        """
        key = frozenset(columns)
        if self.likelihoods is None or key in self.logs:
            return self.logs.get(key, {})
        effects = self.dated_effects(columns)
        if not effects:
            return {}
        others = [one for one in columns if one not in effects]
        fit = LeastSquares(self.design.by_week([*others, *effects]), len(effects))
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

    def dated_effects(self, columns: Sequence[Column]) -> dict[Column, Effect]:
        """Effects with dates among some columns, by the first column of each."""
        found: dict[Column, Effect] = {
            one: one.effect for one in columns if isinstance(one, Changed)
        }
        for name, (first, *_) in self.design.own.items():
            effect = self.design.effects[name]
            if first in columns and is_dated(effect):
                found[first] = effect
        return found

    def weighed(self, choice: Choice, others: Sequence[Choice]) -> Choice:
        """A choice with its rivals, by how much of its part each explains."""
        top = choice.top
        given = self.given(others)
        searched = {top.name: top}
        # a change that is in the model may be the cause of other days, too
        taken = self.taken(others)
        rivals = [one for one in self.candidates(given) if one.beyond(given)]
        falls = zip(rivals, self.in_sample(rivals, given))
        rivals = [one for one, fall in falls if fall >= OVERLAP * choice.fall]
        for one in rivals:
            if self.alike(top, one, given) >= OVERLAP:
                score = self.score(one, given)
                if score.possible and score.probability >= DOUBT:
                    searched.setdefault(one.name, one)
        # a fault may have another time profile than the one that looks like the best
        # candidate, and references compare them
        faults = {one.effect.sensor_fault for one in searched.values()} - {""}
        for one in rivals:
            if one.effect.sensor_fault in faults and self.score(one, given).possible:
                searched.setdefault(one.name, one)
        members = {one.name: one for one in self.with_same_law(searched.values())}
        parts = {name: self.score(one, given) for name, one in members.items()}
        sure = min(choice.score.z_score, 1.0 / PROFILE_ERROR)
        weights = posterior(self.design, self.criteria, members, given, top, sure)
        choice = replace(
            choice, members=members, scores=parts, weights=weights, taken=taken
        )
        return replace(
            choice,
            spreads=self.spreads(choice, given),
            confounded=self.confounded(choice, given),
        )

    def confounded(
        self, choice: Choice, given: Sequence[Column]
    ) -> dict[str, tuple[float, float]]:
        """
        Sizes of the changes of a choice given all confounders of the catalogue.

        Any module may have these, also where they are not material: heat of the ground
        and light from it differ before and after a date, as they do with the season.
        """
        design = self.design
        further = [
            column
            for name, columns in design.own.items()
            for column in columns
            if design.effects[name].confounder and column not in given
        ]
        found = {}
        for name, one in choice.members.items():
            if one.effect.sensor_fault:
                columns = [*given, *further, one.change]
                fit = LeastSquares(design.by_week(columns), 1)
                (scale,) = design.scales([one.change])
                shift = fit.estimate[0] / scale - choice.scores[name].estimate[0]
                error = np.sqrt(fit.covariance[0, 0]) / scale
                found[name] = float(shift), float(error)
        return found

    def spreads(
        self, choice: Choice, given: Sequence[Column]
    ) -> dict[str, tuple[float, float]]:
        """Least and largest size over its dates of each member that has some."""
        faults = [one for one in choice.members.values() if one.effect.sensor_fault]
        if not faults:
            return {}
        scan = self.scan(given)
        return {
            one.name: scan.sizes_over_dates(one.change, choice.scores[one.name].z_score)
            for one in faults
        }


def worth_share(one: Candidate, sure: float) -> float:
    """
    Share of what a candidate explains beyond the cost of its dates.

    It is the scale of the posterior among time profiles: half of the squared standard
    errors are the logarithm of the likelihood of all that it explains.
    """
    cost = dates_cost(one.dates, sure)
    return 1.0 - 2.0 * cost / max(sure, 1e-12) ** 2


def dates_of(choices: Iterable[Choice]) -> int:
    """Number of dates of some choices that were searched for."""
    return sum(one.top.dates for one in choices)
