"""The fits of a case, one step after the other, and their residuals."""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from pvlib_fem import scores
from pvlib_fem._fitting.daily import DailySums, standard_errors
from pvlib_fem._fitting.fit_stages import minimise
from pvlib_fem._fitting.rounded_wind import COARSE, recorded_step, with_rounding
from pvlib_fem._fitting.row_source import Rows, daily_sums
from pvlib_fem._fitting.search import (
    checked_fixed,
    linearised_effects,
    natural_coefficients,
)
from pvlib_fem._loop.preparation.divided_record import BASES, Case
from pvlib_fem._loop.regression.gather import Linearisation
from pvlib_fem._record.inputs import Inputs, Record
from pvlib_fem._spelling import FIXED, refusal
from pvlib_fem._statistics.clusters import FOLDS, days_of_folds
from pvlib_fem._statistics.weekly_sums import held_out
from pvlib_fem._thermal.model import MEMORY, WIND, ThermalModel
from pvlib_fem._thermal.steady_models import SteadyModel
from pvlib_fem.drivers import MODELLED, derive_drivers, is_modelled, underived
from pvlib_fem.effects._effect import Effect, LinearisedEffect

ROUGH, CLOSE = 1e-7, 1e-3  # relative fall of the cost that ends a coarse, a full fit
FROZEN: Mapping[str, float] = MappingProxyType({})
MEMORIES = {*MEMORY["ewm"], *MEMORY["balance"]}
#: an effect, and the same as a table of a record if it is linear
Tabled = tuple[Effect, Effect | LinearisedEffect]
Ready = tuple[Mapping[str, float] | None, Record, dict[str, Tabled]]


@dataclass(frozen=True, eq=False)
class Step:
    """A fitted model, and its temperature of every row."""

    model: ThermalModel
    coefficients: dict[str, float]
    searched: dict[str, float]
    coarse: dict[str, float]  # where the search ended on coarse steps
    at_bound: tuple[str, ...]
    converged: bool
    temperature: np.ndarray  # NaN where a driver is missing
    measured: np.ndarray
    daily: DailySums | None = None  # of the fitted rows, where effects were fitted

    def as_base(self) -> "Step":
        """The step by which effects know the temperature of the module."""
        return replace(self, model=replace(self.model, base=self.coefficients))

    def error(self, rows: np.ndarray) -> float:
        """Root mean square error on some rows. [K]"""
        return scores.rmse(self.measured[rows], self.temperature[rows])


@dataclass(eq=False)
class Fits:
    """Fits to one case, which share its drivers and the tables of its effects."""

    case: Case
    #: by record: the base of a model, the record with drivers, and its effects' tables
    ready: dict[str, Ready] = field(default_factory=dict)

    def bases(self, steady_model: SteadyModel) -> dict[str, Step]:
        """
        Fits without any effect, by name.

        It is a ValueError if there are no more fitting rows than coefficients.
        """
        case = self.case
        step: Step | None = None
        steps: dict[str, Step] = {}
        rows = min(int(case.searched.sum()), int(case.fitting.sum()))
        least = len(ThermalModel(steady_model, "balance").parameters)
        if rows <= least:
            held = f"{int(case.test.sum()):,} rows that count are test rows"
            raise ValueError(
                f"the loop needs more than {least} fitting rows that count and has "
                f"{rows}: {'; '.join([held, *case.notes])}; give a longer record, or "
                "another holdout"
            )
        check_held(steady_model, case)
        for name, dynamics in BASES.items():
            model = ThermalModel(steady_model, dynamics, held=case.fixed)
            step = self.fitted(model, step, biased=name != "steady")
            steps[name] = step
        return steps

    def better(self, steps: Mapping[str, Step]) -> str:
        """The better dynamics, on fitting weeks left out in turn, to first order."""
        names = ["fem", "balance"]
        # with a fixed memory there is no choice
        if memory := MEMORIES & {*self.case.fixed}:
            names = [n for n in names if memory <= {*MEMORY[BASES[n]]}]
        if self.case.divisible:
            error = {n: self.cross_validated(steps[n]) for n in names}
        else:
            error = {n: steps[n].error(self.case.fitting) for n in names}
        return min(error, key=error.__getitem__)

    def fitted(
        self,
        model: ThermalModel,
        before: Step | None = None,
        start: Mapping[str, float] = FROZEN,
        biased: bool = True,
        whole: bool = True,
    ) -> Step:
        """
        One step: least squares over the fitting rows, the coarse ones first.

        What short steps change of a coarse minimum is nearly the same in the step
        ``before``: it is where their fit begins, and without ``whole`` it is taken as
        it is. Coefficients of ``start`` are tried first, where they give a temperature.
        """
        case = self.case
        table = {name: row.start for name, row in model.parameters.items()}
        at = {**table, **(before.coarse if before else {})}
        record, tabled = self.prepared(case.record, model)
        rows = case.searched & record.complete_rows(model.drivers)
        # a tangent may lead where there is no temperature
        tried = tabled.temperature(
            record.inputs, natural_coefficients(model, {**at, **start})[0]
        )
        if np.isfinite(tried[rows]).all():
            at = {**at, **start}
        minimum, at = minimise(tabled, Rows(record, rows), at, biased, ROUGH)
        coarse, source = at, None
        if case.record is not case.whole:
            if before:
                change = {n: v - before.coarse[n] for n, v in before.searched.items()}
                at = {n: v + change.get(n, 0.0) for n, v in at.items()}
            record, tabled = self.prepared(case.whole, model)
            if whole:
                rows = case.fitting & record.complete_rows(model.drivers)
                source = Rows(record, rows)
                minimum, at = minimise(tabled, source, at, biased, CLOSE)
        names = model.free[: len(minimum.x)]
        bound = tuple(n for n, there in zip(names, minimum.at_bound) if there)
        coefficients, daily = natural_coefficients(model, at)[0], None
        if source is not None and model.effects:
            # of which all is at hand, and may be let go
            temperature = np.empty(len(record.index))
            daily = daily_sums(tabled, coefficients, source, bound, temperature)
        else:
            temperature = tabled.temperature(record.inputs, coefficients)
        known = record.complete_rows(model.drivers)
        return Step(
            model,
            coefficients,
            at,
            coarse,
            bound,
            minimum.converged,
            temperature if known.all() else np.where(known, temperature, np.nan),
            case.whole["temp_module"],
            daily,
        )

    def daily(self, step: Step) -> DailySums:
        """Daily sums of a step's fitted rows, on the record's own steps."""
        if step.daily is not None:
            return step.daily
        return self.sums(step, self.case.whole, self.case.fitting)

    def errors(self, step: Step, daily: DailySums, notes: list) -> dict:
        """Standard errors of a step's coefficients, by its daily sums."""
        stderr = standard_errors(step.model, daily, step.at_bound, notes)
        if recorded_step(self.case.whole[WIND]) < COARSE:
            return stderr
        rows, model = self.rows(step, self.case.whole, self.case.fitting)
        return with_rounding(rows, model, step.coefficients, stderr, notes)

    def cross_validated(self, step: Step) -> float:
        """Square error of a step on fitting weeks left out in turn. [K²]"""
        sums = self.sums(step, self.case.record, self.case.searched).sums
        folds = days_of_folds(sums.dates) == np.arange(FOLDS)[:, None]
        # the residual is the first column there
        return held_out(np.roll(sums.sums, 1, axis=(1, 2)), folds.astype(float))

    def sums(self, step: Step, record: Record, counts: np.ndarray) -> DailySums:
        """Daily sums of the rows of a record that count and that a step knows."""
        rows, tabled = self.rows(step, record, counts)
        return daily_sums(tabled, step.coefficients, rows, step.at_bound)

    def rows(
        self, step: Step, record: Record, counts: np.ndarray
    ) -> tuple[Rows, ThermalModel]:
        """The rows that count and that a step knows, and its model as tables."""
        record, tabled = self.prepared(record, step.model)
        return Rows(record, counts & record.complete_rows(step.model.drivers)), tabled

    def prepared(
        self, record: Record, model: ThermalModel
    ) -> tuple[Record, ThermalModel]:
        """A record with what a model needs, and the model's effects as tables."""
        case = self.case
        place = "coarse" if record is case.record else "whole"
        base, larger, tabled = self.ready.get(place, (None, record, {}))
        if base is not model.base:
            larger = without_base(larger)
            tabled = {
                n: one for n, one in tabled.items() if not is_modelled(one[0].drivers)
            }
        larger = case.placed_for(larger, model.drivers)
        for effect in model.effects:
            if effect.name in tabled and tabled[effect.name][0] is effect:
                continue
            made = with_drivers(larger, model, effect)
            tabled[effect.name] = (effect, *linearised_effects((effect,), made))
            columns = made.inputs.columns
            if place == "whole" and tabled[effect.name][1] is not effect:
                # the table replaces its drivers, which are as many rows again
                columns = columns.only([n for n in MODELLED if n in columns])
            larger = larger.having(columns)
        self.ready[place] = (model.base, larger, tabled)
        effects = tuple(tabled[effect.name][1] for effect in model.effects)
        return larger, replace(model, effects=effects)

    def linearisation(self, step: Step, candidates: Sequence[Effect]) -> Linearisation:
        """A step on the coarse fitting rows, with the drivers of some candidates."""
        case = self.case
        self.prepared(case.record, step.model)
        base, record, tabled = self.ready["coarse"]
        # the next round needs these, too
        record = replace(record, inputs=with_measured(record.inputs, candidates))
        self.ready["coarse"] = base, record, tabled
        return Linearisation(
            step.model,
            step.coefficients,
            record,
            case.searched & record.complete_rows(step.model.drivers),
            step.at_bound,
            case.criteria.min_hint_reduction,
        )

    def forget_coarse(self) -> None:
        """Let go of the coarse record with the drivers of all that was tried."""
        self.ready.pop("coarse", None)


def with_drivers(record: Record, model: ThermalModel, effect: Effect) -> Record:
    """A record with the drivers of an effect of a model."""
    inputs, alone = record.inputs, replace(model, effects=(effect,))
    if needed := {*MODELLED} & {*underived(effect.drivers)}:
        inputs = model.with_base(inputs, needed)  # by all effects that the model has
    return replace(record, inputs=alone.with_drivers(inputs))


def without_base(record: Record) -> Record:
    """A record without what follows from the model without effects."""
    return record.only([n for n in record.inputs.columns if not is_modelled([n])])


def with_measured(inputs: Inputs, effects: Iterable[Effect]) -> Inputs:
    """Inputs with those drivers of effects that follow from measured columns alone."""
    for effect in effects:
        wide = effect.scanned_from or effect
        names = [name for name in wide.drivers if not is_modelled([name])]
        with suppress(Exception):  # which is reported where the effect is tested
            inputs = derive_drivers(inputs, names)
    return inputs


def check_held(steady_model: SteadyModel, case: Case) -> None:
    """Refuse coefficients to hold that are of no model, or of two dynamics."""
    if {*case.fixed} >= MEMORIES:
        raise refusal(
            FIXED,
            f" has {' and '.join(sorted(MEMORIES))}, which belong to two kinds of "
            "dynamics; hold one of them",
        )
    dynamics = "balance" if {*MEMORY["balance"]} & {*case.fixed} else "ewm"
    checked_fixed(ThermalModel(steady_model, dynamics, case.wanted), case.fixed)
