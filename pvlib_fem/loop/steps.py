"""The fits of a case, one step after the other, and what each leaves."""

from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np
import pandas as pd

from pvlib_fem import scores
from pvlib_fem.fitting.fit import errors, minimise, natural, tables
from pvlib_fem.loop.case import Case
from pvlib_fem.loop.evidence import gather
from pvlib_fem.record.columns import DAYLIGHT
from pvlib_fem.thermal.model import ThermalModel

ROUGH, CLOSE = 1e-7, 1e-3  # relative fall of the cost that ends a coarse, a full fit
FROZEN = MappingProxyType({})
SCORES = [
    f"{name}_{part}" for part in ("train", "test") for name in ("rmse", "mae", "mbe")
]
BASES = {"steady": "steady", "fem": "ewm", "balance": "balance"}


@dataclass(frozen=True, eq=False)
class Step:
    """A fitted model, and what it says of every row."""

    model: ThermalModel
    coefficients: dict
    searched: dict
    coarse: dict  # where the search ended on coarse steps
    at_bound: tuple
    converged: bool
    temperature: np.ndarray
    measured: np.ndarray

    def as_base(self):
        """The same, by which effects know the temperature of the module."""
        return replace(self, model=replace(self.model, base=self.coefficients))

    def error(self, rows):
        return scores.rmse(self.measured[rows], self.temperature[rows])


@dataclass(eq=False)
class Fits:
    """Fits to one case, which share its drivers and the tables of its effects."""

    case: Case
    ready: dict = field(default_factory=dict)  # by record: it, with drivers, tables

    def bases(self, steady_model):
        """Fits without any effect, by name."""
        case, step, steps = self.case, None, {}
        rows = min(int(case.open.sum()), int(case.train.sum()))
        least = len(ThermalModel(steady_model, "balance").parameters)
        if rows <= least:
            held = f"{int(case.test.sum()):,} rows that count are held out"
            raise ValueError(
                f"the loop needs more than {least} open rows that count and has "
                f"{rows}: {'; '.join([held, *case.notes])}; give a longer record, or "
                "another holdout"
            )
        for name, dynamics in BASES.items():
            model = ThermalModel(steady_model, dynamics)
            step = self.fitted(model, step, biased=name != "steady")
            steps[name] = step
        return steps

    def better(self, steps):
        """The better dynamics, on weeks left out in turn, to first order."""
        if self.case.divisible:
            left = {n: self.gathered(steps[n], []).left() for n in ("fem", "balance")}
        else:
            left = {n: steps[n].error(self.case.train) for n in ("fem", "balance")}
        return steps[min(left, key=left.get)].as_base()

    def fitted(self, model, before=None, start=FROZEN, biased=True, whole=True):
        """
        One step: least squares over the open rows, the coarse ones first.

        What short steps change of a coarse minimum is nearly the same in the step
        ``before``: it is where their fit begins, and without ``whole`` it is taken
        as it is.
        """
        case = self.case
        table = {name: row.start for name, row in model.parameters.items()}
        at = {**table, **(before.coarse if before else {})}
        record, tabled = self.prepared(case.record, model)
        # a tangent may lead where there is no temperature
        tried = tabled.temperature(record.inputs, natural(model, {**at, **start})[0])
        if np.isfinite(tried[case.open]).all():
            at = {**at, **start}
        minimum, at = minimise(tabled, record, case.open, at, biased, ROUGH)
        coarse = at
        if case.record is not case.whole:
            if before:
                change = {n: v - before.coarse[n] for n, v in before.searched.items()}
                at = {n: v + change.get(n, 0.0) for n, v in at.items()}
            record, tabled = self.prepared(case.whole, model)
            if whole:
                minimum, at = minimise(tabled, record, case.train, at, biased, CLOSE)
        names = model.free[: len(minimum.x)]
        coefficients = natural(model, at)[0]
        return Step(
            model,
            coefficients,
            at,
            coarse,
            tuple(n for n, bound in zip(names, minimum.at_bound) if bound),
            minimum.converged,
            tabled.temperature(record.inputs, coefficients),
            case.whole["temp_module"],
        )

    def errors(self, step):
        """Standard errors of a step's coefficients, by the day on coarse steps."""
        record, tabled = self.prepared(self.case.record, step.model)
        found = natural(step.model, step.coarse)[0]
        return errors(tabled, record, self.case.open, found, step.at_bound, [])

    def prepared(self, record, model):
        """A record with a model's drivers, and the model's effects as tables."""
        key = id(record)
        _, larger, known = self.ready.get(key, (record, record, {}))
        larger = with_drivers(larger, model)
        for effect in model.effects:
            if effect.name not in known or known[effect.name][0] is not effect:
                known[effect.name] = (effect, *tables((effect,), larger))
        # the record itself is kept, so that no other can take its number
        self.ready[key] = (record, larger, known)
        effects = tuple(known[effect.name][1] for effect in model.effects)
        return larger, replace(model, effects=effects)

    def gathered(self, step, candidates):
        """Evidence of some effects beside a step, on the open coarse rows."""
        case = self.case
        return gather(
            step.model,
            step.coefficients,
            self.prepared(case.record, step.model)[0],
            case.open,
            candidates,
            step.at_bound,
        )


def error_table(case, steps):
    """Errors of each step on the open and the sealed rows."""
    poa = pd.Series(case.whole["poa_global"], case.whole.index)
    sunny = case.whole["poa_global"] > DAYLIGHT
    rows = {}
    for name, step in steps.items():
        module, modelled = step.measured, step.temperature
        row = {
            f"{score.__name__}_{part}": score(module[at], modelled[at])
            for part, at in (("train", case.train), ("test", case.test))
            for score in (scores.rmse, scores.mae, scores.mbe)
        }
        row["rmse_test_day"] = step.error(case.test & sunny)
        row["rmse_test_night"] = step.error(case.test & ~sunny)
        known = pd.Series(np.where(case.test, module, np.nan), poa.index)
        energy = scores.energy_error(poa, known, pd.Series(modelled, poa.index))
        row["energy_error_test"] = energy.performance_ratio
        rows[name] = row
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("step")


def with_drivers(record, model):
    return replace(record, inputs=model.with_drivers(record.inputs))
