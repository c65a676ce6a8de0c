"""Close the loop: from the residual to the missing effects, and their gain."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any, cast

import numpy as np
import pandas as pd
from pvlib.location import Location
from pvlib.pvsystem import AbstractMount

from pvlib_fem._findings import CORRECTED, Check, Correction, Finding, Verdict
from pvlib_fem._fitting.parquet_fit import given_days, in_files
from pvlib_fem._fitting.stand_ins import stand_in_names
from pvlib_fem._former_names import arguments_in_new_names, keys_in_new_names
from pvlib_fem._loop.assemble import loop_of_search
from pvlib_fem._loop.choice import Choice
from pvlib_fem._loop.conclude import check_of_bounds, finding_of, hint_of
from pvlib_fem._loop.correct_clock import module_clock
from pvlib_fem._loop.corrected_times import Times
from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._loop.cross_checks import (
    cross_checked,
    log_likelihoods,
    log_likelihoods_of_sizes,
)
from pvlib_fem._loop.design import Changed
from pvlib_fem._loop.divided_record import Case
from pvlib_fem._loop.edge_weeks import by_power, edge_weeks
from pvlib_fem._loop.hourly_tangents import design_of_evidence
from pvlib_fem._loop.leaks import leaks
from pvlib_fem._loop.loop_files import Reading
from pvlib_fem._loop.loop_result import Loop
from pvlib_fem._loop.noise import with_outside
from pvlib_fem._loop.parquet_loop import OwnSteps, in_means
from pvlib_fem._loop.planes import with_given
from pvlib_fem._loop.prepare import is_before_the_sun, prepared_case
from pvlib_fem._loop.progress import stage_reporter
from pvlib_fem._loop.reference_faults import reference_faults
from pvlib_fem._loop.references import DailyDeviation, daily_deviations
from pvlib_fem._loop.refits import Fits, Step
from pvlib_fem._loop.replacements import NOTHING, Replacements
from pvlib_fem._loop.selection import (
    MOST,
    Selection,
    ShownChange,
    selected,
    shown_by,
    with_best_odds,
)
from pvlib_fem._loop.tangents import Evidence
from pvlib_fem._loop.threads import one_blas_thread
from pvlib_fem._record.checks import dates_of
from pvlib_fem._record.column_names import printable, with_aliases
from pvlib_fem._record.parquet import ParquetRecord, as_source, is_data_set
from pvlib_fem._spelling import written_argument
from pvlib_fem._thermal.model import ThermalModel
from pvlib_fem._thermal.steady_models import SteadyModel, steady_model
from pvlib_fem.drivers import checked_place
from pvlib_fem.drivers._mounts import plane_of_rows
from pvlib_fem.drivers._planes import ByColumns
from pvlib_fem.drivers._transposition import check_transposition
from pvlib_fem.effects import EffectLike
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import is_dated
from pvlib_fem.quality._module_lag import Clock
from pvlib_fem.reasons import Because, Reason, because
from pvlib_fem.types import FilePath

LONGWAVE = "radiative_loss"  # of every module: in the base model, and no finding
MOST_ROUNDS = 8  # of linearisations


@arguments_in_new_names({"min_gain": "min_rmse_reduction"})
def close_loop(
    data: pd.DataFrame | ParquetRecord | FilePath,
    model: str = "faiman",
    location: Location | None = None,
    surface_tilt: float | pd.Series | None = None,
    surface_azimuth: float | pd.Series | None = None,
    holdout: pd.Series | None = None,
    min_rmse_reduction: float | None = None,
    effects: EffectLike | Iterable[EffectLike] | None = None,
    check_units: bool = True,
    criteria: Criteria | None = None,
    fixed: Mapping[str, float] | None = None,
    progress: Callable[[str], object] | bool | None = None,
    transposition: str | None = None,
    stand_ins: str | Iterable[str] = (),
    mount: AbstractMount | None = None,
) -> Loop:
    """
    Trace the residual of a fit to the physical effects that the model misses.

    The weeks of a record are divided once. On *fitting* weeks the model is fitted and
    linearised, and the remaining error is described by single effects: each is one
    effect of the catalogue, one column of the user's own, or one fault of an
    instrument from a date on. An effect is there where its gain on weeks left out in
    turn is material, its size is possible, and its probability is at least
    ``criteria.min_probability``. Each has the probabilities of all candidates that
    would explain the same, with that of a cause outside the catalogue among them. One
    candidate with ``criteria.min_probability`` is *identified*; else the finding is
    *ambiguous*, with the smallest set of candidates that has it together. The model is
    fitted with all of them and linearised anew until nothing changes. The *test*
    weeks, of which no decision sees the module's temperature, give the errors that are
    reported.

    Parameters
    ----------
    data : DataFrame, str, path-like or ParquetRecord
        With a DatetimeIndex and the columns ``poa_global`` [W/m²], ``temp_air``
        [°C], ``wind_speed`` [m/s], without which ``model`` is ``"ross"`` or
        ``"noct"``, ``temp_module`` [°C], and any of
        ``wind_direction`` [° from north], ``relative_humidity`` [%],
        ``longwave_down`` (or ``ir_down``) [W/m²], ``precipitation`` [mm/h],
        ``power_dc`` or ``power_ac`` [W] of a module or a plant, ``p_dc_per_area`` [W
        per m² of module], ``snow_depth`` [cm], ``poa_rear`` [W/m²], irradiance on the
        rear side. Every other numeric column is a candidate driver of its own,
        ``driver:<column>``. Or Parquet files of such a record, as :func:`fit_fem` takes
        them: the loop is then of means over ``criteria.search_step``, and ``own_steps``
        its last model fitted to the record's own steps, which have to confirm each
        finding.
    model : str, default "faiman"
        A steady model by name, as in :func:`pvlib_fem.fit_fem`.
    location : pvlib.location.Location, optional
        With both angles below, effects that follow the sun can be tested.
    surface_tilt, surface_azimuth : float or Series, optional
        Of the module; azimuth from north, clockwise. If they change with time, they are
        Series, or columns of ``data`` with these names. Where a location is given and
        neither of them, they are estimated from the light of clear days. [°]
    holdout : Series of bool, optional
        The test rows, or days of a record in files. By default every fifth week, or
        every other day of a record below five weeks.
    min_rmse_reduction : float, optional
        Short for ``criteria=Criteria(min_rmse_reduction=...)``: reduction of the RMSE
        below which nothing is added to the model. [K]
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
    transposition : str, optional
        Where there is no ``poa_global``, the model of the sky by which it is made of
        ``ghi`` [W/m²], ``"perez"`` or ``"haydavies"``, as
        :func:`pvlib_fem.transpose_record` does, also in files. ``predict`` does so,
        too.
    stand_ins : str or sequence of str, optional
        Second sources that stand in for air temperature or wind where these are
        missing, such as ``temp_air_2``, as :func:`pvlib_fem.fill_record` does.
        ``predict`` does so, too. Without it a second source is a cross-check alone. In
        files one stands in only for a column that is missing.
    mount : pvlib.pvsystem.SingleAxisTrackerMount, optional
        A tracker, instead of the two angles. By night, and wherever ``get_orientation``
        gives no angles, the modules are horizontal.

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
    How it decides is in :doc:`/design`. Where a driver is missing, rows do not count
    for its effect; nothing is filled in.

    Below ``criteria.min_days`` no effect is added.

    If the fitting weeks show a standstill of a tracker that may begin or end in a test
    week, and there is no power, that week becomes a fitting week, except where
    ``holdout`` is given. A note says so.

    References
    ----------
    .. [1] A. C. Cameron and D. L. Miller, "A Practitioner's Guide to
       Cluster-Robust Inference", J. Human Resources 50, 317-372, 2015.
       :doi:`10.3368/jhr.50.2.317`
    .. [2] G. Wang, A. Sarkar, P. Carbonetto and M. Stephens, "A simple new approach
       to variable selection in regression, with application to genetic fine mapping",
       J. R. Stat. Soc. B 82, 1273-1300, 2020. :doi:`10.1111/rssb.12388`
    .. [3] J. Wakefield, "Bayes factors for genome-wide association studies: comparison
       with P-values", Genet. Epidemiol. 33, 79-86, 2009. :doi:`10.1002/gepi.20359`

    Examples
    --------
    >>> import pvlib_fem as fem
    >>> data = fem.simulator.record(effects=fem.simulator.PHYSICS, days=70, step=600)
    >>> loop = fem.close_loop(data[["poa_global", "temp_air", "wind_speed",
    ...                             "temp_module"]])
    >>> sorted(loop.weeks.unique())
    ['fitting', 'test']
    """
    criteria = criteria or Criteria()
    if min_rmse_reduction is not None:
        criteria = replace(criteria, min_rmse_reduction=min_rmse_reduction)
    place = checked_place(location, surface_tilt, surface_azimuth, mount)
    how: dict[str, Any] = dict(
        holdout=holdout,
        effects=effects,
        check_units=check_units,
        fixed=keys_in_new_names(fixed) if fixed else fixed,
        criteria=criteria,
    )
    if transposition:
        frame = isinstance(data, pd.DataFrame)
        check_transposition(
            transposition, plane_of_rows(data, place) if frame else place
        )
    calm = not steady_model(model).takes_wind
    instead = Replacements.of_arguments(transposition, stand_ins, calm)
    return finished_search(data, model, place, progress, instead, **how)[1]


def finished_search(
    data: pd.DataFrame | ParquetRecord | FilePath,
    model: str,
    place: dict[str, Any],
    progress: Callable[[str], object] | bool | None,
    instead: Replacements = NOTHING,
    **how: Any,
) -> tuple["Search", Loop]:
    """
    A finished search, and the loop that it gives.

    Parameters
    ----------
    data, model, progress
        See :func:`close_loop`.
    place : dict
        From :func:`pvlib_fem.drivers.checked_place`.
    instead : Replacements, optional
    **how
        Further arguments of :func:`pvlib_fem._loop.prepare.prepared_case`.

    Returns
    -------
    Search, Loop
    """
    given = {n: written_argument(v) for n, v in (how | instead.arguments).items()}
    # LAPACK's last bits depend on the number of threads, and its matrices here are
    # small
    with one_blas_thread(), stage_reporter(progress) as report:
        own: OwnSteps | None = None
        replaced: dict[str, Any] = {}
        steady = steady_model(model)
        plain = ThermalModel(steady, "balance")
        if is_data_set(data):
            if isinstance(place["mount"], ByColumns):
                raise ValueError(
                    "surface_tilt and surface_azimuth as Series do not go with files; "
                    "write them into the files as columns"
                )
            report("reading the files")
            source, criteria = as_source(data), how["criteria"]
            source, replaced = instead.of_files(source, place, criteria.limits)
            instead = Replacements(calm=instead.calm)
            frame, screened = in_means(in_files(source, plain), criteria)
            own = OwnSteps(screened)
            if how["holdout"] is not None:
                days = np.isin(dates_of(frame.index), given_days(how["holdout"]))
                how["holdout"] = pd.Series(days, frame.index)
        else:  # anything but a frame is refused below
            frame = cast(pd.DataFrame, data)
        others = stand_in_names(instead.stand_ins)
        plain.refuse_without_wind({**with_aliases(frame, ()), **others})
        frame, site = with_given(frame, place)
        spared: list[int] = []
        while True:
            report("checking the record")
            case = prepared_case(frame, site, **how, instead=instead, spared=spared)
            search = Search(Fits(case), report, own=own)
            last, base = search.run(steady)
            if how["holdout"] is not None:
                break
            more = edge_weeks(search.case, last.model.effects, len(spared))
            if not len(more):
                break
            spared = sorted({*spared, *more.tolist()})
        report("measuring the errors of the test weeks")
        loop = loop_of_search(search, last, base)
        if own is not None:
            loop = own.confirmed(loop)
    case = search.case
    index = cast(pd.DatetimeIndex, frame.index)  # else it had been refused
    times = Times.from_indices(index, case.kept, case.whole.index, search.clock)
    if own is None:
        sky = instead.transposition if case.transposed else ""
        replaced = {"transposition": sky, "stand_ins": case.standing}
    reading = Reading(rows=len(frame.index), notes=notes_of(frame))
    return search, replace(
        loop,
        given=given,
        times=times,
        reading=reading,
        standings=case.standings,
        detachments=case.detachments,
        **replaced,
    )


def notes_of(data: pd.DataFrame) -> list[str]:
    """What was done to data as they were read, where a function noted it."""
    notes = data.attrs.get("notes", ())
    return [printable(one) for one in notes] if isinstance(notes, list | tuple) else []


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
    choices: dict[str, Choice] = field(default_factory=dict)  # of each finding
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
                refined = this.selection.refined([*this.choices])
                this = replace(this, choices=tuple(refined))
            if this.chosen in settled:
                break
            self.report(f"fitting {', '.join(this.names) or 'no further effect'}")
            fit = self.with_effects(plain, this.choices)
            bound = {*fit.at_bound}
            out = [
                one.top.name for one in this.choices if {*one.top.effect.rows()} & bound
            ]
            if out:  # the smallest, which may be there for what another is not
                self.closed |= {out[-1]}
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
        evidence = self.fits.gathered(step, wanted, self.located)
        self.located |= evidence.effects
        lifted = [e for e in step.model.effects if e.name not in self.usual]
        record = self.fits.ready["coarse"][1]
        design = design_of_evidence(
            evidence, record, case.drivers, lifted, step.coefficients
        )
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
            design, case.criteria, closed, begin, self.shown_changes, likelihoods
        )
        # the design has the hourly means of its columns, which are large
        evidence = replace(evidence, columns={})
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
            others = [*reported, *others]
            one, effect, finding = self.described(this, chosen[0], others)
            reported.append(one.as_first)
            chosen = chosen[1:]
            if one.first != one.top.name:
                chosen = selection.kept_beside(chosen, reported)
            self.choices[finding.effect] = one
            self.effects[finding.effect] = effect
            if not finding.added:
                self.refused.append(finding)
                continue
            model = replace(step.model, effects=(*step.model.effects, effect))
            fit = self.fits.fitted(model, step, finding.coefficients, whole=False)
            check, why = check_of_bounds(finding.coefficients, fit)
            if not check.passed:
                self.refuse(finding, check, why)
                continue
            if size := one.joint_size(effect.name, fit.coefficients):
                model = replace(model, held={**model.held, **size})
                fit = self.fits.fitted(model, step, size, whole=False)
            step = self.steps[f"+{finding.effect}"] = fit
            self.findings.append(finding)
        if self.findings:
            step = self.on_own_steps(step)
            self.steps[f"+{self.findings[-1].effect}"] = step
        return step

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
        return daily_deviations(self.case)

    @cached_property
    def shown(self) -> list[tuple[DailyDeviation, dict[str, ShownChange]]]:
        """Changes that each reference shows, which no round alters."""
        limits = self.case.criteria
        return [(one, shown_by(one, limits)) for one in self.references]

    @cached_property
    def shown_changes(self) -> dict[str, ShownChange]:
        """Changes that any reference shows, by name."""
        return with_best_odds(changes for _, changes in self.shown)

    def reference_faults(self, findings: Iterable[Finding]) -> list[str]:
        """Second sensors and plants that have changed, and not what they check."""
        if self.last is None:
            return []
        return [*reference_faults(self.last, self.shown, findings)]

    def weighed(
        self, this: Round, choice: Choice, others: Sequence[Choice]
    ) -> tuple[Choice, list[DailyDeviation]]:
        """A choice given others with its probabilities, and the references so given."""
        selection = this.selection
        one = selection.weighed(choice, others)
        references = [reference.given(others) for reference in self.references]
        logs = log_likelihoods(references, one, this.coefficients)
        given, limits = selection.given(others), self.case.criteria
        return with_outside(selection.design, one, given, limits, logs), references

    def described(
        self, this: Round, choice: Choice, others: Sequence[Choice]
    ) -> tuple[Choice, Effect, Finding]:
        """A choice given others with its probabilities, its effect, the finding."""
        selection, case = this.selection, self.case
        one, references = self.weighed(this, choice, others)
        effect = selection.dated(one, one.first, selection.given(others))
        if effect.turns:
            size = float(one.scores[one.first].estimate[0])
            effect = by_power(case, effect, size)
        one = cross_checked(references, one, effect, this.coefficients)
        return one, effect, finding_of(one, effect, case, selection.least)

    def hints(self, this: Round) -> Iterator[tuple[Finding, Effect]]:
        """
        Further single effects that are not in the model, each given all before it.

        They are chosen and weighed as those of the model, by lower criteria, so that
        one cause is one hint, whatever else may be it. What a second sensor or power
        shows is a hint of any gain.
        """
        limits, least = self.case.criteria, this.selection.least
        further = replace(this.selection, criteria=limits.for_hints)
        for finding in (*self.findings, *self.refused):
            further.closed |= {*finding.candidates}
        reported = [one.as_first for one in self.choices.values()]
        while len(reported) < MOST:
            best = further.best_shown(reported) or further.best(reported)
            if best is None:
                break
            fall = further.in_sample([best.top], further.given(reported))[0]
            one, effect, finding = self.described(this, best, reported)
            fitted = float(np.sqrt(fall))
            yield hint_of(finding, best.score, fitted, least, limits), effect
            reported.append(one.as_first)
            further.closed |= {*finding.candidates}

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
