"""Rounds of linearisation and selection, until nothing changes."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from pvlib_fem._findings import CORRECTED, Check, Correction, Finding, Verdict
from pvlib_fem._loop.preparation.divided_record import Case
from pvlib_fem._loop.preparation.leaks import leaks
from pvlib_fem._loop.preparation.prepare import is_before_the_sun
from pvlib_fem._loop.references.cross_checks import (
    cross_checked,
    log_likelihoods_of_sizes,
)
from pvlib_fem._loop.references.deviations import DailyDeviation, daily_deviations
from pvlib_fem._loop.references.edge_weeks import by_power
from pvlib_fem._loop.references.joint_dates import (
    date_costs,
    weighed_by_references,
)
from pvlib_fem._loop.references.reference_faults import reference_faults
from pvlib_fem._loop.references.shown_changes import with_best_odds, with_own
from pvlib_fem._loop.regression.correct_clock import module_clock
from pvlib_fem._loop.regression.design import Changed
from pvlib_fem._loop.regression.evidence import Evidence
from pvlib_fem._loop.regression.hourly_tangents import design_of_evidence, with_added
from pvlib_fem._loop.regression.refits import Fits, Step
from pvlib_fem._loop.results.conclude import check_of_bounds, finding_of, if_material
from pvlib_fem._loop.results.parquet_loop import OwnSteps
from pvlib_fem._loop.selection.choice import Choice, ShownChange
from pvlib_fem._loop.selection.noise import with_outside
from pvlib_fem._loop.selection.refinement import refined
from pvlib_fem._loop.selection.rivals import alone
from pvlib_fem._loop.selection.single_effects import MOST, Selection, selected
from pvlib_fem._thermal.steady_models import SteadyModel
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import is_dated
from pvlib_fem.quality._module_lag import Clock
from pvlib_fem.reasons import Because, Reason, because

LONGWAVE = "radiative_loss"  # of every module: in the base model, and no finding
MOST_ROUNDS = 8  # of linearisations


@dataclass(frozen=True, eq=False)
class Round:
    """What one linearisation chose, and from what."""

    evidence: Evidence
    selection: Selection
    choices: tuple[Choice, ...]
    coefficients: Mapping[str, float]  # of the linearised model

    @property
    def names(self) -> list[str]:
        return [one.top.name for one in self.choices]

    @property
    def chosen(self) -> frozenset[str]:
        """
        The chosen columns by name, and changes with their dates.

        The places of columns differ between linearisations.
        """
        names = self.selection.design.names
        columns = [column for one in self.choices for column in one.top.columns]
        return frozenset(c.key if isinstance(c, Changed) else names[c] for c in columns)


@dataclass(eq=False)
class Search:
    """A case, and what was found in it so far."""

    fits: Fits
    report: Callable[[str], None]
    steps: dict[str, Step] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)
    #: findings that are not in the model
    refused: list[Finding] = field(default_factory=list)
    #: of each finding in the model
    choices: dict[str, Choice] = field(default_factory=dict)
    #: of all findings so far, with their dates
    effects: dict[str, Effect] = field(default_factory=dict)
    #: names that a refit or the own steps contradict
    closed: frozenset[str] = frozenset()
    #: the one without effects from which the search begins
    start: Step = field(init=False, repr=False)
    corrections: list[Correction] = field(default_factory=list)
    clock: Clock = field(default_factory=Clock)  # by which the module's was set right
    untestable: dict[str, Because] = field(default_factory=dict)
    own: OwnSteps | None = None  # of files, of which the case has means
    usual: frozenset[str] = frozenset()  # names of effects that are no findings
    #: effects as the last round that found their place or time has them, by name
    located: dict[str, Effect] = field(default_factory=dict)
    last: Round | None = None  # that which chose what is in the model
    error: float | None = None  # mean square error without effects [K²]

    @property
    def case(self) -> Case:
        return self.fits.case

    def run(self, steady: SteadyModel) -> tuple[Step, str]:
        """The last step, and the name of the one before all effects."""
        self.untestable |= self.case.untestable
        self.corrections += self.case.corrections
        self.report("fitting the model without effects")
        self.steps |= self.fits.bases(steady)
        base = self.fits.better(self.steps)
        # the last row of all is the final model's, also without an effect
        step = raw = self.steps.pop(base).as_base()
        self.steps[base] = step
        if self.case.clock.fault:
            self.report("correcting the clock")
            self.fits, step, clock, correction = module_clock(self.fits, raw)
            if correction is not None:
                self.corrections.append(correction)
                self.clock = clock
                self.steps[CORRECTED] = step
        self.start = step
        self.leave_out_leaks(step)
        if not self.case.divisible:
            return step, base
        step = self.with_usual(step)
        base = next((n for n in reversed(self.steps) if n[0] == "+"), base)
        so_far = dict(self.steps)
        while True:
            self.steps = dict(so_far)
            last = self.converged(step)
            if (against := self.contradicted(last)) is None:
                return last, base
            finding, check, why = against
            self.closed |= {finding.effect}
            self.refuse(finding, check, why)

    def refuse(self, finding: Finding, check: Check, why: Because) -> None:
        """Take a finding as a hint, since it does not pass a check after all."""
        checks = (*finding.checks, check)
        hint = replace(finding, verdict=Verdict.HINT, because=why, checks=checks)
        self.refused.append(hint)

    def with_usual(self, step: Step) -> Step:
        """The step with what every module has, and with effects that are held."""
        fixed = {*self.case.fixed}
        effects = [e for e in self.case.wanted if e.rows() and {*e.rows()} <= fixed]
        for one in self.case.wanted:
            if one.name == LONGWAVE and self.case.enough and one not in effects:
                effects.append(one)
        for effect in effects:
            model = replace(step.model, effects=(*step.model.effects, effect))
            fit = self.on_own_steps(self.fits.fitted(model, step, whole=False))
            if not {*fit.at_bound} & {*effect.rows()}:
                step = self.steps[f"+{effect.name}"] = fit
        self.usual = frozenset(effect.name for effect in step.model.effects)
        return step

    def converged(self, plain: Step) -> Step:
        """The last step, when one more linearisation chooses the same effects."""
        step = plain
        begin: tuple[Choice, ...] = ()
        seen: set[frozenset[str]] = set()
        for turn in range(MOST_ROUNDS):
            self.report(f"weighing effects, round {turn + 1}")
            this = self.round(step, begin)
            # the plain model is that of no effects
            settled = {*seen, frozenset()} if step is plain else seen
            if this.chosen in settled:
                choices = refined(this.selection, [*this.choices])
                this = replace(this, choices=tuple(choices))
            if this.chosen in settled:
                break
            self.report(f"fitting {', '.join(this.names) or 'no further effect'}")
            fit = self.with_effects(plain, this.choices)
            bound = {*fit.at_bound}
            out = [one.top for one in this.choices if {*one.top.effect.rows()} & bound]
            if out:  # the smallest, which may be there for what another is not
                self.closed |= {out[-1].name}
                _, why = check_of_bounds(out[-1].effect.rows(), fit)
                self.untestable[out[-1].name] = why
                continue
            seen.add(this.chosen)
            step, begin = fit, this.choices
        self.last = this
        return self.with_findings(plain, this)

    def round(self, step: Step, begin: Sequence[Choice]) -> Round:
        """
        The selection by the remaining error of a step without its effects.

        It begins with the choices of the round before.
        """
        case = self.case
        there = {e.name for e in step.model.effects if not e.sensor_fault}
        wanted = [effect for effect in case.wanted if effect.name not in there]
        at = self.fits.linearisation(step, wanted)
        evidence = at.evidence(wanted, self.located)
        self.located |= evidence.effects
        lifted = [e for e in step.model.effects if e.name not in self.usual]
        design = design_of_evidence(
            evidence, at.record, case.drivers, step.coefficients, lifted
        )
        if self.error is None:  # the first model is that without effects
            self.error = design.base_error
        # the design has the hourly means of its columns, which are large
        evidence = replace(evidence, columns={})
        each = at.without_each(lifted, evidence)
        design = with_added(design, at.record, step.coefficients, lifted, each)
        closed = self.closed
        names = [e.name for e in case.wanted if is_before_the_sun(e)]
        names = [name for name in names if name in design.own]
        if names and case.another_plane is not None:
            why = because(Reason.ANOTHER_PLANE, plane=str(case.another_plane))
            # before another plane an obstacle has no place
            self.untestable |= dict.fromkeys(names, why)
            closed = closed | {*names}
        likelihoods = partial(
            log_likelihoods_of_sizes, self.references, step.coefficients
        )
        selection, choices = selected(
            design,
            case.criteria,
            closed,
            begin,
            self.shown_changes,
            likelihoods,
            self.error,
        )
        return Round(evidence, selection, tuple(choices), step.coefficients)

    def leave_out_leaks(self, base: Step) -> None:
        """Drop columns of the user's own that hold the answer."""
        case = self.case
        own = {e.column: e for e in case.wanted if e.column}
        if not own:
            return
        temperature = base.model.temperature(case.record.inputs, base.coefficients)
        least = case.criteria.min_leak_difference
        for name in leaks(case.record, case.searched, temperature, list(own), least):
            effect = own[name]
            self.untestable[effect.name] = because(Reason.LEAK, column=name)
            case = case.without(effect)
        self.fits.case = case

    def with_effects(self, plain: Step, choices: Sequence[Choice]) -> Step:
        """The model with the best member of each choice, fitted on coarse steps."""
        if not choices:
            return plain
        effects = tuple(one.top.effect for one in choices)
        model = replace(plain.model, effects=(*plain.model.effects, *effects))
        start: dict[str, float] = {}
        for one in choices:
            start |= one.score.coefficients
        fit = self.fits.fitted(model, plain, start, whole=False)
        return replace(fit, model=model.rebased(fit.coefficients))

    def with_findings(self, plain: Step, this: Round) -> Step:
        """The last step, with the findings that are in it one after the other."""
        selection = this.selection
        self.findings, self.choices = [], {}
        self.refused = [f for f in self.refused if f.effect in self.closed]
        chosen = [one for one in this.choices if one.top.name not in self.closed]
        known = self.by_references(this, chosen)
        step = plain
        reported: list[Choice] = []
        while chosen:
            others = [known.get(one.top.name, one) for one in chosen[1:]]
            one, effect, finding = self.described(this, chosen[0], [*reported, *others])
            reported.append(one.as_first)
            chosen = chosen[1:]
            if one.first != one.top.name:
                chosen = selection.kept_beside(chosen, reported)
            step = self.with_finding(step, finding, effect, one)
        step = self.with_further(step, this, reported)
        if self.findings:
            step = self.on_own_steps(step)
            self.steps[f"+{self.findings[-1].effect}"] = step
        return step

    def with_finding(
        self, step: Step, finding: Finding, effect: Effect, choice: Choice
    ) -> Step:
        """A step with one finding more, unless it is a hint or ends at a bound."""
        self.effects[finding.effect] = effect
        if not finding.added:
            self.refused.append(finding)
            return step
        model = replace(step.model, effects=(*step.model.effects, effect))
        fit = self.fits.fitted(model, step, finding.coefficients, whole=False)
        check, why = check_of_bounds(finding.coefficients, fit)
        if not check.passed:
            self.refuse(finding, check, why)
            return step
        if size := choice.joint_size(effect.name, fit.coefficients):
            model = replace(model, held={**model.held, **size})
            fit = self.fits.fitted(model, step, size, whole=False)
        self.steps[f"+{finding.effect}"] = fit
        self.findings.append(finding)
        self.choices[finding.effect] = choice
        return fit

    def with_further(self, step: Step, this: Round, reported: Sequence[Choice]) -> Step:
        """
        The step with further findings, and further hints, each given all before it.

        They are chosen and weighed as those of the model, by lower criteria, so that
        one cause is one hint, whatever else may be it. What a second sensor or power
        shows is a hint of any gain. Those that pass the criteria of the model are in
        it. There can be some: a choice may be reported as another member than the one
        that was selected, which explained more of what others can.
        """
        limits, least = self.case.criteria, this.selection.least
        further = replace(this.selection, criteria=limits.for_hints)
        for finding in (*self.findings, *self.refused):
            further.closed |= self.closed_by(finding)
        reported = [*reported]
        while len(reported) < MOST:
            best = further.best_shown(reported) or further.best(reported)
            if best is None:
                break
            fall = further.in_sample([best.top], further.given(reported))[0]
            one, effect, finding = self.described(this, best, reported)
            fitted = float(np.sqrt(fall))
            finding = if_material(finding, best.score, fitted, least, limits)
            reported.append(one.as_first)
            step = self.with_finding(step, finding, effect, one)
            further.closed |= self.closed_by(finding)
        return step

    def closed_by(self, finding: Finding) -> frozenset[str]:
        """
        Names of candidates of a finding that are no further finding or hint.

        Another candidate of one in the model may be there as well, but for changes,
        which share its dates.
        """
        choice = self.choices.get(finding.effect)
        if choice is None:
            return frozenset(finding.candidates)
        effects = choice.effects_of(finding.candidates)
        changes = (one.name for one in effects if is_dated(one))
        return frozenset({*changes, finding.effect})

    def by_references(self, this: Round, chosen: Sequence[Choice]) -> dict[str, Choice]:
        """
        Choices with the member that references make the most probable, by first name.

        What a reference shows of one change depends on which others it shows, so that
        these have to be known before.
        """
        if not self.references or sum(is_dated(one.top.effect) for one in chosen) < 2:
            return {}
        known = {one.top.name: one for one in chosen}
        for name, one in known.items():
            others = [other for other in known.values() if other is not one]
            known[name] = self.weighed(this, one, others)[0].as_first
        return known

    @cached_property
    def references(self) -> list[DailyDeviation]:
        """What candidates are compared with."""
        return [one for one, _ in self.shown]

    @cached_property
    def shown(self) -> list[tuple[DailyDeviation, dict[str, ShownChange]]]:
        """Changes that each reference shows, which no round alters."""
        return with_own(daily_deviations(self.case), self.case.criteria)

    @cached_property
    def shown_changes(self) -> dict[str, ShownChange]:
        """Changes that any reference shows, by name."""
        return with_best_odds(changes for _, changes in self.shown)

    @property
    def in_model(self) -> list[Choice]:
        """Choices of the findings in the model, each with the reported cause."""
        return [self.choices[finding.effect].as_first for finding in self.findings]

    def reference_faults(self, findings: Iterable[Finding]) -> list[str]:
        """Second sensors and plants that have changed, and not what they check."""
        if self.last is None:
            return []
        selection, coefficients = self.last.selection, self.last.coefficients
        by_module = partial(alone, selection, given=selection.given(self.in_model))
        return [*reference_faults(by_module, coefficients, self.shown, findings)]

    def weighed(
        self, this: Round, choice: Choice, others: Sequence[Choice]
    ) -> tuple[Choice, list[DailyDeviation]]:
        """A choice given others with its probabilities, and the references so given."""
        selection = this.selection
        references = [reference.given(others) for reference in self.references]
        given_all = others, references, this.coefficients
        one, logs = weighed_by_references(selection, choice, *given_all)
        given, limits = selection.given(others), self.case.criteria
        design = selection.design.at(given)
        return with_outside(design, one, given, limits, logs), references

    def described(
        self, this: Round, choice: Choice, others: Sequence[Choice]
    ) -> tuple[Choice, Effect, Finding]:
        """A choice given others with its probabilities, its effect, the finding."""
        selection, case, own = this.selection, self.case, this.coefficients
        one, references = self.weighed(this, choice, others)
        effect = one.members[one.first].effect
        if effect.turns:
            size = float(one.scores[one.first].estimate[0])
            effect = by_power(case, effect, size)
        one = cross_checked(references, one, effect, own)
        if effect.sensor_fault:
            costs = date_costs(references, effect)
            effect = selection.dated(one, effect.name, selection.given(others), costs)
        return one, effect, finding_of(one, effect, case, selection.least)

    def on_own_steps(self, step: Step) -> Step:
        """A step fitted to the record's own steps, and with its own base."""
        model = step.model.rebased(step.coefficients)
        if self.case.record is self.case.whole and model is step.model:
            return step
        return self.fits.fitted(model, step, step.coarse)

    def contradicted(self, step: Step) -> tuple[Finding, Check, Because] | None:
        """The first finding that a fit to the files' own steps contradicts, or None."""
        if self.own is None:
            return None
        self.report("fitting the record's own steps")
        fitting, steps = self.case.fitting, [*self.steps]
        falls: list[tuple[Finding, float]] = []
        for finding in self.findings:
            at = steps.index(f"+{finding.effect}")
            before, after = (self.steps[steps[i]] for i in (at - 1, at))
            fall = before.error(fitting) ** 2 - after.error(fitting) ** 2
            falls.append((finding, fall))
        inputs = self.fits.prepared(self.case.whole, step.model)[0].inputs
        corrected = any(one.applied for one in self.corrections)
        return self.own.against(self.case, step, inputs, corrected, falls)
