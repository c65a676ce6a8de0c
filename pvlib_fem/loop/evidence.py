"""What absent effects would explain, from one pass over a record."""

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from scipy.stats import f as fisher

from pvlib_fem.loop.criteria import Criteria
from pvlib_fem.relaxation import relax
from pvlib_fem.statistics.clusters import DailySums, calendar_weeks, daily_sums

POWER = 2.8  # errors that a coefficient needs to be seen 4 times in 5 at 5 %
RIVAL = 0.6  # share of the best gain from which a candidate is a rival
TIED = 0.15  # share of its own gain that is left beside a rival it is tied with
#: the same of shapes, which the sun drives all alike
LIKE, ALIKE = 0.35, 0.4
SLACK = 0.35  # of a bound, by which a tangent may miss it where a refit would not
NOWHERE = "nothing is left that a window of the sky would explain"
UNSEEN = 1e-6  # of a column: below this nothing is left of it beside others


@dataclass(frozen=True, eq=False)
class Evidence:
    """
    Tangents of a fitted model and of effects that it lacks, and what is left.

    ``base`` are the fitted coefficients, ``own`` has the columns of each effect,
    and ``shapes`` are columns of what a misshapen model leaves.
    """

    columns: dict = field(repr=False)
    residual: np.ndarray = field(repr=False)
    dates: np.ndarray = field(repr=False)
    seen: np.ndarray = field(repr=False)  # rows of the record that count
    base: tuple
    shapes: tuple
    own: dict
    effects: dict
    failed: dict
    sums: DailySums = field(repr=False)

    @property
    def clusters(self):
        return len(self.sums.by_cluster)

    def places(self, names):
        """Columns of the base and of some effects or columns, each once."""
        wanted = list(self.base)
        for name in names:
            wanted += [n for n in self.own.get(name, (name,)) if n not in wanted]
        order = {name: i for i, name in enumerate(self.columns)}
        return [order[name] for name in wanted]

    @property
    def nuisances(self):
        """Shapes, as columns and as effects, which no driver is credited with."""
        own = [name for name, effect in self.effects.items() if effect.confounder]
        return [*self.shapes, *own]

    def left(self, beside=()):
        """Held-out mean square with the base and these. [K²]"""
        return self.sums.left(self.places(beside))

    def gain(self, name, beside=()):
        """Fall of the held-out mean square that it brings beside others. [K²]"""
        return self.left(beside) - self.left([*beside, name])

    def with_column(self, name, values):
        """The same with one more column, which no effect owns."""
        columns, rest = list(self.columns.values()), (self.residual, self.dates)
        sums = self.sums.with_column(columns, *rest, values)
        return replace(self, columns={**self.columns, name: values}, sums=sums)

    def rest(self, beside=()):
        """Residual that the base and these leave, row by row. [K]"""
        kept = self.places(beside)
        found = self.sums.solve(kept) / self.sums.scale[kept]
        names = list(self.columns)
        rest = self.residual.copy()
        for place, value in zip(kept, found):
            rest -= value * self.columns[names[place]]
        return rest

    def weigh(self, name, beside=()):
        """One row of a ranking: what an effect would explain beside others."""
        effect = self.effects[name]
        beside = [other for other in beside if other != name]
        nuisance = self.places(beside)
        kept = self.places([*beside, name])
        own = kept[len(nuisance) :]
        if not all(self.sums.beside(column, []) > 0 for column in own):
            return {"note": "it adds nothing in this record's weather"}
        beyond = np.array([self.sums.beside(column, nuisance) for column in own])
        if (beyond < UNSEEN).any():
            return {"note": "the record cannot tell it from the fitted coefficients"}
        step = self.sums.solve(kept)[len(nuisance) :]
        covariance = self.sums.covariance(kept)[len(nuisance) :, len(nuisance) :]
        error = np.sqrt(np.diag(covariance))
        scale, rows = self.sums.scale[own], effect.rows()
        coefficients = dict(zip(rows, (step / scale).tolist()))
        near = 2.0 * error / scale
        physical = all(
            row.lower - max(n, SLACK * abs(row.lower))
            <= coefficients[key]
            <= row.upper + max(n, SLACK * abs(row.upper))
            for (key, row), n in zip(rows.items(), near)
        )
        change = self.sums.left(nuisance) - self.sums.left(kept)
        freedom = max(self.clusters - 1, 1)
        statistic = step @ np.linalg.solve(covariance, step) / len(own)
        return {
            "gain": float(np.sign(change) * np.sqrt(abs(change))),
            "p_value": float(fisher.sf(statistic, len(own), freedom)),
            "coefficients": coefficients,
            "stderr": dict(zip(rows, (error / scale).tolist())),
            "physical": physical,
            "detectable": float(POWER * (error * beyond).max()),
        }

    def ties(self, name, gains, beside=()):
        """Rivals beside which an effect has nothing left to explain."""
        own = max(gains[name], 0.0) ** 2
        beside = [other for other in beside if other != name]
        rival, tied = (LIKE, ALIKE) if self.effects[name].confounder else (RIVAL, TIED)
        rivals = [
            other
            for other, gain in gains.items()
            if other != name and max(gain, 0.0) ** 2 >= rival * own > 0.0
        ]
        return tuple(
            other for other in rivals if self.gain(name, [*beside, other]) < tied * own
        )


def gather(model, coefficients, record, seen, candidates, fixed=(), criteria=None):
    """
    Evidence for candidates beside a model at its minimum.

    Parameters
    ----------
    model : ThermalModel
    coefficients : dict
        All of the model's.
    record : Record
        With every driver of the candidates, without gaps.
    seen : array of bool
        Rows that count.
    candidates : sequence of Effect
    fixed : sequence of str
        Coefficients at a bound, which stay there.
    criteria : Criteria, optional
    """
    also, own, failed, effects = {}, {}, {}, {}
    model = replace(model, base=model.base or coefficients)
    inputs = model.with_base(model.with_drivers(record.inputs))
    scanned = {}
    for effect in candidates:
        try:
            if effect.prepare:
                effect = effect.prepare(inputs.columns, seen)
            if effect.scan:
                scanned[effect.name] = effect.scan
                effect = effect.scanned_from or effect
            inputs = replace(model, effects=(effect,)).with_drivers(inputs)
            start = {key: row.start for key, row in effect.rows().items()}
            slopes = effect.slopes(inputs.columns, start)
        except Exception as error:  # whatever an effect does, the others go on
            failed[effect.name] = f"{type(error).__name__}: {error}"
            continue
        also |= slopes
        own[effect.name], effects[effect.name] = tuple(slopes), effect
    temperature, slopes = model.slopes(inputs, coefficients, also=also)
    base = [name for name in model.free if name not in fixed]
    more = shapes(temperature - coefficients["bias"], record)
    slopes = {**slopes, **more}
    seen = seen & np.isfinite(temperature)
    wanted = [*base, *more, *also]
    columns = {name: np.ascontiguousarray(slopes[name][seen]) for name in wanted}
    for name in list(own):
        if not all(np.isfinite(columns[key]).all() for key in own[name]):
            failed[name] = "it is not a number in all rows"
            for key in own.pop(name):
                del columns[key]
            del effects[name]
    residual = (record["temp_module"] - temperature)[seen]
    dates = record.dates[seen]
    sums = daily_sums(list(columns.values()), residual, dates)
    names = (tuple(base), tuple(more))
    found = Evidence(columns, residual, dates, seen, *names, own, effects, failed, sums)
    scanned = {name: scan for name, scan in scanned.items() if name in effects}
    for name, scan in scanned.items():
        scan = partial(scan, criteria=criteria or Criteria())
        found = narrowed(found, name, scan, model, coefficients, inputs, seen)
    return found


def narrowed(found, name, scan, model, coefficients, inputs, seen):
    """The evidence with an effect only where a scan of what is left shows it."""
    keys = found.own[name]
    places = {n: inputs[n][seen] for n in found.effects[name].drivers}
    names = list(found.columns)
    beside = [names[i] for i in found.places(found.nuisances)]
    tangents = {key: found.columns[key] for key in (*keys, *beside)}
    weeks = calendar_weeks(found.dates)
    without = replace(
        found,
        columns={n: c for n, c in found.columns.items() if n not in keys},
        own={n: k for n, k in found.own.items() if n != name},
        effects={n: e for n, e in found.effects.items() if n != name},
        sums=found.sums.of([i for i, n in enumerate(found.columns) if n not in keys]),
    )
    effect = scan(found.rest(found.nuisances), tangents, places, weeks)
    if effect is None:
        return replace(without, failed={**found.failed, name: NOWHERE})
    inputs = replace(model, effects=(effect,)).with_drivers(inputs)
    start = {row: table.start for row, table in effect.rows().items()}
    also = effect.slopes(inputs.columns, start)
    slopes = model.slopes(inputs, coefficients, also=also)[1]
    better = without
    for key in also:
        better = better.with_column(key, np.ascontiguousarray(slopes[key][seen]))
    return replace(
        better,
        own={**better.own, name: tuple(also)},
        effects={**better.effects, name: effect},
    )


def shapes(temperature, record):
    """
    What a misshapen model leaves beside the shapes that are effects.

    Functions of the usual inputs alone, which every cause without a driver of
    its own shares: curvature in the over-temperature, its fall with air
    temperature, a slower mass, and a record that is late.
    """
    air, hour = record["temp_air"], 3600.0 / record.inputs.unit
    over = temperature - air
    known = np.nan_to_num(over)
    steps = np.maximum(record.inputs.steps, 1.0)  # the first has no row before it
    columns = {
        "curved": over * np.sqrt(np.abs(over)),
        "warm": over * (air - np.nanmean(air)),
        "slow": relax(known, record.inputs.steps, hour) - over,
        "late": np.nan_to_num(np.diff(temperature, prepend=temperature[:1]) / steps),
    }
    return {f"shape:{name}": column for name, column in columns.items()}
