"""Close the loop: from the residual to the missing effect, and what it was worth."""

from collections.abc import Callable, Iterable, Mapping
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import pandas as pd
from pvlib.location import Location

from pvlib_fem.drivers import checked_place
from pvlib_fem.effects import EffectLike
from pvlib_fem.effects.courses import changes_of, is_drift, same_course
from pvlib_fem.findings import CORRECTED, Verdict, vouched
from pvlib_fem.loop.confirm import bounds, confirmed, refused
from pvlib_fem.loop.correct import module_clock
from pvlib_fem.loop.criteria import Criteria
from pvlib_fem.loop.evidence import Evidence
from pvlib_fem.loop.files import OwnSteps, in_means, on_days
from pvlib_fem.loop.leaks import leaks
from pvlib_fem.loop.outcome import outcome
from pvlib_fem.loop.prepare import another_plane, is_before_the_sun, prepared
from pvlib_fem.loop.progress import telling
from pvlib_fem.loop.propose import Proposals, choices_of
from pvlib_fem.loop.ranges import everywhere
from pvlib_fem.loop.result import Loop
from pvlib_fem.loop.rules import in_the_end, weighed
from pvlib_fem.loop.steps import Fits, Step
from pvlib_fem.loop.threads import one_blas_thread
from pvlib_fem.quality.clock import Clock
from pvlib_fem.reasons import Reason, because
from pvlib_fem.record.parquet import ParquetRecord, as_source, is_data_set
from pvlib_fem.report.page import said_of
from pvlib_fem.thermal.steady import steady_model
from pvlib_fem.types import FilePath


def close_loop(
    data: pd.DataFrame | ParquetRecord | FilePath,
    model: str = "faiman",
    location: Location | None = None,
    surface_tilt: float | None = None,
    surface_azimuth: float | None = None,
    holdout: pd.Series | None = None,
    min_gain: float | None = None,
    effects: EffectLike | Iterable[EffectLike] | None = None,
    check_units: bool = True,
    criteria: Criteria | None = None,
    fixed: Mapping[str, float] | None = None,
    progress: Callable[[str], object] | bool | None = None,
) -> Loop:
    """
    Trace what a fit leaves to the physical effects that the model lacks.

    The weeks of a record are divided once. On *fitting* weeks the model is fitted,
    and every effect that has its driver is weighed by what it would explain on
    fitting weeks left out in turn, conditional on the tangents of all fitted
    coefficients and on the confounders that any misfit leaves. One is proposed where
    its gain is material, no accident among all that are tried, of a possible size,
    and not better explained by structure of unknown cause. Confounders alone come
    after, as classes. A proposal is fitted with all others, and kept unless the
    *choosing* weeks contradict it. The *test* weeks, of which no decision sees the
    module's temperature, give the errors that are told.

    Parameters
    ----------
    data : DataFrame, str, path-like or ParquetRecord
        With a DatetimeIndex and the columns ``poa_global`` [W/m²], ``temp_air``
        [°C], ``wind_speed`` [m/s], ``temp_module`` [°C], and any of
        ``wind_direction`` [° from north], ``relative_humidity`` [%],
        ``longwave_down`` (or ``ir_down``) [W/m²], ``precipitation`` [mm/h],
        ``p_dc`` [W per m² of module], ``snow_depth`` [cm]. Every other numeric
        column is a candidate driver of its own, ``driver:<column>``. Or Parquet
        files of such a record, as :func:`fit_fem` takes them: the loop is then of means
        over ``criteria.search_step``, and ``own_steps`` its last model fitted to the
        record's own steps, which have to confirm each finding.
    model : str, default "faiman"
        A steady model by name, as in :func:`pvlib_fem.fit_fem`.
    location : pvlib.location.Location, optional
        With both angles below, effects that follow the sun can be tested.
    surface_tilt, surface_azimuth : float, optional
        Of the module; azimuth from north, clockwise. Where a location is given and
        neither of them, they are estimated from the light of clear days. [°]
    holdout : Series of bool, optional
        The test rows, or days of a record in files. By default every fifth week, or
        every other day of a record below five weeks.
    min_gain : float, optional
        Short for ``criteria=Criteria(min_gain=...)``: gain below which nothing is
        added to the model. [K]
    effects : str, Effect, or sequence of these, optional
        Effects to try; by default all, and the user's own columns.
    check_units : bool, default True
        Refuse columns that look to be in another unit.
    criteria : Criteria, optional
        Thresholds other than the usual.
    fixed : dict, optional
        Coefficients that are held, as ``{"tau": 378}``.
    progress : callable or True, optional
        Called with a few words at the beginning of each stage; True shows them on one
        line. The log ``pvlib_fem`` has them at its level INFO.

    Returns
    -------
    Loop

    Raises
    ------
    ValueError
        If the record is unusable: times, columns, units; the message names the
        column, the value and the remedy.

    Notes
    -----
    How it decides, step by step, is in :doc:`/design`. Where a driver lacks, rows do
    not count for its effect; nothing is filled in.

    Of few weeks the choosing and the test weeks leave little to fit: below 60 days
    there are no choosing weeks, and no effect is added.

    References
    ----------
    .. [1] A. C. Cameron and D. L. Miller, "A Practitioner's Guide to
       Cluster-Robust Inference", J. Human Resources 50, 317-372, 2015.
       :doi:`10.3368/jhr.50.2.317`
    .. [2] A. Chernozhukov et al., "Double/debiased machine learning", Econometrics
       J. 21, C1-C68, 2018: what others explain is taken out before an effect is
       weighed. :doi:`10.1111/ectj.12097`

    Examples
    --------
    >>> import pvlib_fem as fem
    >>> data = fem.simulator.record(effects=fem.simulator.PHYSICS, days=70, step=600)
    >>> loop = fem.close_loop(data[["poa_global", "temp_air", "wind_speed",
    ...                             "temp_module"]])
    >>> sorted(loop.weeks.unique())
    ['choosing', 'fitting', 'test']
    """
    criteria = criteria or Criteria()
    if min_gain is not None:
        criteria = replace(criteria, min_gain=min_gain)
    place = (location, surface_tilt, surface_azimuth)
    how: dict[str, Any] = dict(
        holdout=holdout, effects=effects, check_units=check_units
    )
    how |= {"fixed": fixed, "criteria": criteria}
    return searched(data, model, place, progress, **how)[1]


def searched(data, model, place, progress, **how):
    """A search that is done, and the loop that came of it."""
    site = checked_place(*place)
    given = {name: said_of(value) for name, value in how.items()}
    # LAPACK's last bits depend on the number of threads, and its matrices here are
    # small
    with one_blas_thread(), telling(progress) as tell:
        own = None
        if is_data_set(data):
            tell("reading the files")
            data, screened = in_means(as_source(data), how["criteria"])
            own = OwnSteps(screened)
            if how["holdout"] is not None:
                how["holdout"] = on_days(how["holdout"], data.index)
        tell("checking the record")
        search = Search(Fits(prepared(data, site, **how)), tell, own=own)
        ended = search.run(steady_model(model))
        tell("measuring the errors of the test weeks")
        found = outcome(search, *ended)
        if own is not None:
            found = own.told(found)
    return search, replace(found, given=given)


@dataclass(eq=False)
class Search:
    """A case, and what was found in it so far."""

    fits: Fits
    tell: object
    steps: dict = field(default_factory=dict)
    findings: list = field(default_factory=list)
    vetoed: dict = field(default_factory=dict)  # what a fit spoke against, by name
    doubted: tuple = ()  # effects that are no more tried, changes on their date
    start: Step | None = None  # the one without effects from which the search begins
    before: dict = field(default_factory=dict)  # steps and findings before each finding
    corrections: list = field(default_factory=list)
    untestable: dict = field(default_factory=dict)
    aside: dict = field(default_factory=dict)  # checks of what waits, by name
    clock: Clock = field(default_factory=Clock)  # by which the module's was set right
    own: OwnSteps | None = None  # of files, of which the case has means
    left: Evidence | None = None  # of all that the last step lacks

    @property
    def case(self):
        return self.fits.case

    def run(self, steady):
        """The last step, and the name of the one before all effects."""
        self.untestable |= self.case.untestable
        self.corrections += self.case.corrections
        self.tell("fitting the model without effects")
        self.steps |= self.fits.bases(steady)
        base = self.fits.better(self.steps)
        step = raw = self.steps[base] = self.steps[base].as_base()
        if self.case.clock.fault:
            self.tell("correcting the clock")
            case = self.case
            self.fits, step, correction = module_clock(case, self.fits, raw, Fits)
            self.corrections.append(correction)
            if correction.applied:
                self.clock = case.clock
                self.steps[CORRECTED] = step
        self.start = step
        self.leave_out_leaks(step)
        step = self.rounds(step)
        while doubted := self.doubtful(step, self.left) or self.contradicted(step):
            step = self.rounds(self.gone_back(step, *doubted))
        return step, base

    def rounds(self, step):
        """The step when no effect is found any more; what it leaves is kept."""
        self.left, limits = None, self.case.criteria
        for turn in range(limits.rounds if self.case.divisible else 0):
            self.tell(f"weighing effects, round {turn + 1}")
            self.left = self.evidence(step)
            last, step = step, self.further(step, self.left)
            if step is last:
                break
            step = self.on_own_steps(self.within_bounds(step))
            self.fits.let_go("whole")
        if self.left is None and self.case.divisible:
            self.left = self.evidence(step)  # what is told is of the model that is told
        return step

    def further(self, step, found):
        """The last step that holds, of those with what one more round proposes."""
        done = {n for finding in self.findings for n in finding.candidates}
        done |= self.closed
        dated = changes_of((*step.model.effects, *self.doubted))
        beside = (step.coefficients, dated)
        proposals = Proposals(self.case, found, frozenset(done), *beside)
        new, self.aside = proposals.run(), proposals.aside
        choices = [[*choices_of(finding, proposals.found)] for finding in new]
        del found, proposals  # as large as what is fitted
        names = ", ".join(f.effect for f in new if f.added)
        self.tell(f"fitting {names or 'no further effect'}")
        return self.added(new, choices, step)

    def on_own_steps(self, step):
        """The last step, fitted to the record's own steps, and with its own base."""
        model = step.model.rebased(step.coefficients)
        if self.case.record is not self.case.whole or model is not step.model:
            step = self.fits.fitted(model, step, step.coarse)
            self.steps[list(self.steps)[-1]] = step
        return step

    def evidence(self, step):
        """Evidence of all that a step lacks."""
        there = {effect.name for effect in step.model.effects}
        # a confounder that is no more tried is the rival of the others all the same
        there |= {e.name for e in self.doubted if not e.confounder} & self.closed
        limits = self.case.criteria
        wanted = [effect for effect in self.case.wanted if effect.name not in there]
        found = self.fits.gathered(step, wanted)
        scanned = {e.name: e for e in wanted if is_before_the_sun(e)}
        names = [name for name in scanned if name in found.effects]
        weights, least = weighed(found, names, found.confounders), limits.hint_gain
        shown = [scanned[name] for name, w in weights.items() if w.gain >= least]
        if shown and self.another_plane is not None:
            # before another plane an obstacle has no place
            for effect in shown:
                why = because(Reason.ANOTHER_PLANE, plane=str(self.another_plane))
                self.untestable[effect.name] = why
                self.fits.case = self.case.without(effect)
            return self.evidence(step)
        return found

    @property
    def closed(self):
        """
        Names of what is no more tried, since it was nothing beside another effect.

        Of a change that has dates another date may be tried, once: else the search
        might go back from one to the next for long.
        """
        names = [effect.name for effect in self.doubted]
        dated = [e.name for e in self.doubted if e.channel and not is_drift(e)]
        return {name for name in names if name not in dated or names.count(name) > 1}

    @cached_property
    def another_plane(self):
        """The plane of the light, where that is not the stated one; asked for once."""
        return another_plane(self.case)

    def leave_out_leaks(self, base):
        """Drop columns of the user's own that hold the answer."""
        case, limits = self.case, self.case.criteria
        own = {e.column: e for e in case.wanted if e.column}
        if not own:
            return
        temperature = base.model.temperature(case.record.inputs, base.coefficients)
        for name in leaks(case.record, case.searched, temperature, list(own), limits):
            effect = own[name]
            self.untestable[effect.name] = because(Reason.LEAK, column=name)
            case = case.without(effect)
        self.fits.case = case

    def added(self, new, choices, step):
        """The last step that holds, of those with one more effect each."""
        for finding, own in zip(new, choices):
            if finding.verdict != Verdict.SUGGESTIVE:
                finding, attempt = self.tried(own, step)
                if not finding.added:
                    # beside effects that come later it may hold
                    self.vetoed[finding.effect] = finding
                    continue
                self.left = None  # it is of another model now
                so_far = (self.steps, self.findings, self.vetoed)
                self.before[finding.effect] = tuple(map(copy, so_far))
                self.steps.pop(f"+{finding.effect}", None)  # the last one comes last
                step = self.steps[f"+{finding.effect}"] = attempt
                self.vetoed.pop(finding.effect, None)
            self.findings.append(finding)
        return step

    def within_bounds(self, step):
        """The step without findings that beside later ones are more than can be."""
        there = {effect.name for effect in step.model.effects}
        for finding in [f for f in self.findings if f.effect in there]:
            check, why = bounds(finding.coefficients, step)
            if not check.passed:
                step = self.removed(finding, check, why, step)
        return step

    def doubtful(self, step, found):
        """
        The first finding that does not stand in the last model, or None.

        Beside all that came later it is no more material, or it is near nothing beside
        an effect that was not found. With the check of that and its reason. Of the
        latter confounders, which stand for each other, are not asked: they are told as
        classes. Nor is a change that witnesses agree with, who know nothing of these
        models.
        """
        if found is None:
            return None
        effects = {effect.name: effect for effect in step.model.effects}
        added = [f for f in self.findings if f.effect in effects]
        asked = {f.effect: f for f in added if not vouched(f)}
        checks = [*in_the_end(asked, found, step).items()]
        others = everywhere(added, found, step).items()
        checks += [one for one in others if not effects[one[0]].confounder]
        for name, (check, why) in checks:
            if name in asked and not check.passed:
                return asked[name], check, why
        return None

    def contradicted(self, step):
        """The first finding that the own steps of files speak against, or None."""
        if self.own is None:
            return None
        self.tell("fitting the record's own steps")
        fitting, falls = self.case.fitting, []
        for finding in self.findings:
            if after := self.steps.get(f"+{finding.effect}"):
                before = self.step_before(finding)
                fall = before.error(fitting) ** 2 - after.error(fitting) ** 2
                falls.append((finding, fall))
        inputs = self.fits.prepared(self.case.whole, step.model)[0].inputs
        corrected = any(one.applied for one in self.corrections)
        return self.own.against(self.case, step, inputs, corrected, falls)

    def gone_back(self, step, finding, check, why):
        """The step before a finding, on which later ones stand; it is no more tried."""
        effects = {effect.name: effect for effect in step.model.effects}
        self.steps, self.findings, self.vetoed = map(copy, self.before[finding.effect])
        self.vetoed[finding.effect] = refused(finding, check, why)
        self.doubted += (effects[finding.effect],)
        last = self.step_before(finding)
        return self.on_own_steps(last) if last.model.effects else last

    def step_before(self, finding):
        """The step on which a finding was tried."""
        # before the first effect the last of the steps is the other of the two dynamics
        steps, *_ = self.before[finding.effect]
        later = [one for name, one in steps.items() if name[0] in "+-"]
        return later[-1] if later else self.start

    def removed(self, finding, check, why, step):
        """The step without a finding, which does not pass a check after all."""
        self.findings.remove(finding)
        self.vetoed[finding.effect] = refused(finding, check, why)
        effects = tuple(e for e in step.model.effects if e.name != finding.effect)
        model = replace(step.model, effects=effects)
        fit = self.fits.fitted(model, step, step.coarse, whole=False)
        self.steps[f"- {finding.effect}"] = fit
        return fit

    def tried(self, choices, step):
        """
        A finding and its fit, by the first of its candidates that holds.

        Changes are large, and a tangent is a poor judge of which comes nearest: those
        that come and go alike are fitted, too, and one that leaves less by what is
        material is taken.
        """
        tries, held = [], []
        there = {effect.name for effect in step.model.effects}
        for mine, effect in choices:
            if effect.name in there:
                continue
            if held and not same_course(held[0][1].model.effects[-1], effect):
                continue
            larger = replace(step.model, effects=(*step.model.effects, effect))
            fit = self.fits.fitted(larger, step, mine.coefficients, whole=False)
            stderr = self.fits.errors(fit)
            tries.append((confirmed(mine, self.case, step, fit, stderr), fit))
            if tries[-1][0].added:
                held.append(tries[-1])
                if not effect.channel:
                    break
        if not held:
            return tries[0]
        left = [fit.error(self.case.fitting) ** 2 for _, fit in held]
        nearest = left.index(min(left))
        material = left[0] - left[nearest] > self.case.criteria.min_gain**2
        return held[nearest if material else 0]
