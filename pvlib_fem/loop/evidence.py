"""What absent effects would explain of what a fit leaves, and with what error."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.special import fdtrc, stdtrit

from pvlib_fem.effects.courses import weights_of
from pvlib_fem.loop.criteria import Criteria
from pvlib_fem.loop.family import Family
from pvlib_fem.reasons import Because, Reason, because
from pvlib_fem.statistics.changes import Daily
from pvlib_fem.statistics.clusters import ClusterSums, cluster_sums, root, starts

UNSEEN = 1e-6  # of a column: what rounding leaves of it beside others


@dataclass(frozen=True)
class Weight:
    """What an effect would explain, given others: one row of a ranking."""

    gain: float  # root of the fall of the held-out mean square; negative: a rise [K]
    p_value: float  # for this candidate alone
    coefficients: dict
    stderr: dict
    possible: bool  # whether the coefficients are within the effect's bounds
    minimum_detectable: float  # minimum detectable gain [K]
    rows: int  # on which its drivers are there
    family: int = 1  # hypotheses among which its chance is counted


@dataclass(frozen=True, eq=False)
class Evidence:
    """
    Tangents of a fitted model and of effects that it lacks, and what is left.

    Attributes
    ----------
    columns : dict of array
        A tangent of each coefficient, misfit and effect, on ``rows``; NaN where
        the driver of an effect lacks. [K per unit of the coefficient]
    residual : array
        Measured minus modelled on ``rows``. [K]
    dates : array of int
        Day of each of the rows, from 1970-01-01.
    rows : array of int
        Those of the record that count.
    base : tuple of str
        The fitted coefficients.
    misfits : tuple of str
        What a misshapen steady model leaves: functions of the usual inputs, with
        which no effect is credited.
    own : dict
        Names of the columns of each effect.
    effects : dict of Effect
    failed : dict of Because
        Effects that could not be weighed.
    partial : dict of array
        Of effects whose drivers lack somewhere: which of the rows are known.
    family : Family
        Numbers of hypotheses among which a chance is counted.
    criteria : Criteria
    snowy : array of bool, optional
        Of the rows, those with snow on the ground, as far as that is measured.
    changing : tuple of (Effect, str)
        Changes whose dates are to be found, each with its column as in :meth:`along`.
    """

    columns: dict = field(repr=False)
    residual: np.ndarray = field(repr=False)
    dates: np.ndarray = field(repr=False)
    rows: np.ndarray = field(repr=False)
    base: tuple
    misfits: tuple
    own: dict = field(default_factory=dict)
    effects: dict = field(default_factory=dict)
    failed: dict = field(default_factory=dict)
    partial: dict = field(default_factory=dict)
    family: Family = field(default_factory=Family)
    criteria: Criteria = field(default_factory=Criteria)
    snowy: np.ndarray | None = field(default=None, repr=False)
    changing: tuple = ()
    ready: dict = field(repr=False, default_factory=dict)  # sums by what is partial

    def sums(self, names) -> ClusterSums:
        """Sums over the rows on which all of some effects are known."""
        lacking = frozenset(name for name in names if name in self.partial)
        if lacking not in self.ready:
            columns, rest = list(self.columns.values()), [self.residual, self.dates]
            if lacking:
                known = np.all([self.partial[name] for name in lacking], axis=0)
                columns = [column[known] for column in columns]
                rest = [part[known] for part in rest]
            # of effects that are not asked for, gaps may be anything
            columns = [np.nan_to_num(c) if self.partial else c for c in columns]
            residual, dates = rest
            limits = self.criteria.folds, self.criteria.fewest_clusters
            self.ready[lacking] = cluster_sums(columns, residual, dates, *limits)
        return self.ready[lacking]

    @cached_property
    def order(self):
        """Place of each column in the sums."""
        return {name: i for i, name in enumerate(self.columns)}

    def places(self, names):
        """Columns of the base and of some effects or columns, each once."""
        wanted = dict.fromkeys(self.base)
        for name in names:
            wanted |= dict.fromkeys(self.own.get(name, (name,)))
        return [self.order[name] for name in wanted]

    @property
    def confounders(self):
        """Misfits and effects of the usual inputs, which no driver is credited with."""
        own = [name for name, effect in self.effects.items() if effect.confounder]
        return [*self.misfits, *own]

    def left(self, given=()):
        """Held-out mean square with the base and these. [K²]"""
        return self.sums(given).left(self.places(given))

    def gain(self, name, given=()):
        """Fall of the held-out mean square that it brings, given others. [K²]"""
        both = [*given, name]
        sums = self.sums(both)
        change = sums.left(self.places(given)) - sums.left(self.places(both))
        return change * sums.rows / len(self.rows)

    def with_column(self, name, values):
        """The same with one more column, which no effect owns."""
        columns, ready = {**self.columns, name: values}, {}
        if not self.partial:
            old, rest = list(self.columns.values()), (self.residual, self.dates)
            ready = {frozenset(): self.sums([]).with_column(old, *rest, values)}
        return replace(self, columns=columns, ready=ready)

    def adding(self, coefficients):
        """The same of a residual that has so much of some columns more than it has."""
        residual = self.residual.copy()
        for name, value in coefficients.items():
            residual += value * np.nan_to_num(self.columns[name])
        columns = {self.order[name]: value for name, value in coefficients.items()}
        ready = {key: sums.adding(columns) for key, sums in self.ready.items()}
        return replace(self, residual=residual, ready=ready)

    def lacking(self, effect, coefficients):
        """The same of a model that has all but one of its effects, to weigh that."""
        keys = tuple(key for key in effect.rows() if key in self.order)
        found = self.adding({key: coefficients[key] for key in keys})
        return replace(
            found,
            base=tuple(name for name in self.base if name not in keys),
            own={**self.own, effect.name: keys},
            effects={**self.effects, effect.name: effect},
        )

    def with_effect(self, effect, columns, known):
        """The same with the tangents of one more effect, on the rows it is known."""
        # of what is nowhere to be seen, as snow that never stays, nothing is asked
        columns = {n: c for n, c in columns.items() if c[known].any()} or columns
        found = self.on_some(effect.name, columns, known)
        return replace(
            found,
            own={**self.own, effect.name: tuple(columns)},
            effects={**self.effects, effect.name: effect},
        )

    def on_some(self, name, columns, known):
        """The same with more columns, on the rows on which they are known."""
        partial = {} if known.all() else {name: known}
        if partial:
            columns = {n: np.where(known, c, np.nan) for n, c in columns.items()}
        found = self
        if self.ready and not partial:
            for name, column in columns.items():
                found = found.with_column(name, column)
        return replace(
            found,
            columns={**found.columns, **columns},
            partial=self.partial | partial,
            ready={} if partial else {**found.ready},
        )

    def along(self, changes):
        """
        The same with changes of which columns are the tangents while they are whole.

        The module's memory at their dates is left out, which is minutes of years: so
        their products follow from those of the columns, at no pass over the rows.

        Parameters
        ----------
        changes : list of (Effect, str)
            Each with its column.
        """
        if not changes:
            return self
        first, ends = starts(self.dates)
        days, rows = self.dates[first], ends - first
        columns, own, partial = {}, {}, {}
        for effect, column in changes:
            (name,) = own[effect.name] = tuple(effect.rows())
            columns[name] = self.columns[column] * np.repeat(
                weights_of(effect, days), rows
            )
            if column in self.partial:
                partial[effect.name] = self.partial[column]
        places = [self.order[column] for _, column in changes]
        ready = {}
        for lacking, sums in ({} if partial else self.ready).items():
            weights = [weights_of(effect, sums.dates) for effect, _ in changes]
            ready[lacking] = sums.along(places, np.transpose(weights))
        return replace(
            self,
            columns=self.columns | columns,
            own=self.own | own,
            effects=self.effects | {effect.name: effect for effect, _ in changes},
            partial=self.partial | partial,
            ready=ready,
        )

    def without(self, names):
        """The same without some effects, and without their columns."""
        names = {*names} & {*self.effects}
        gone = {column for name in names for column in self.own[name]}
        columns = {n: column for n, column in self.columns.items() if n not in gone}
        places = [self.order[name] for name in columns]
        own, effects, partial = (
            {n: part for n, part in parts.items() if n not in names}
            for parts in (self.own, self.effects, self.partial)
        )
        ready = {
            key: sums.of(places)
            for key, sums in self.ready.items()
            if names.isdisjoint(key)
        }
        parts = dict(columns=columns, own=own, effects=effects, partial=partial)
        return replace(self, **parts, ready=ready)

    def shown(self, changing, given):
        """
        Changes with the dates that what is left beside some effects shows.

        Those that show none are not among them. Each has its column, as in
        :meth:`along`.
        """
        daily = self.daily(sorted({column for _, column in changing}), given)
        dated = [(e.dates.found(daily[c], self.criteria), c) for e, c in changing]
        return [(effect, column) for effect, column in dated if effect is not None]

    def daily(self, columns, given=()):
        """Products by the day of columns along which something may change, by name."""
        places, daily = self.places(given), {}
        for name in columns:
            daily[name] = Daily.of(self.sums([name, *given]), self.order[name], places)
        side = self.criteria.change_side
        fading = [one.step_that_fades(side) for one in daily.values()]
        sloped = max(fading, default=0.0)
        return {name: replace(one, sloped=sloped) for name, one in daily.items()}

    def on_rows_of(self, name):
        """The same on the rows on which an effect is known."""
        if name not in self.partial:
            return self
        known = self.partial[name]
        others = {n: k[known] for n, k in self.partial.items()}
        return replace(
            self,
            columns={n: column[known] for n, column in self.columns.items()},
            residual=self.residual[known],
            dates=self.dates[known],
            rows=self.rows[known],
            snowy=None if self.snowy is None else self.snowy[known],
            partial={n: k for n, k in others.items() if not k.all()},
            ready={},
        )

    def rest(self, given=()):
        """Residual that the base and these leave, row by row. [K]"""
        kept, sums = self.places(given), self.sums(given)
        found = sums.solve(kept) / sums.scale[kept]
        names = list(self.columns)
        rest = self.residual.copy()
        for place, value in zip(kept, found):
            rest -= value * self.columns[names[place]]
        return rest

    @cached_property
    def weights(self):
        """What was weighed so far, by name and what was given."""
        return {}

    def weigh(self, name, given=()) -> Weight | Because:
        """What an effect would explain, given others, or why that cannot be said."""
        asked = name, tuple(other for other in given if other != name)
        if asked not in self.weights:  # several stages ask for it
            self.weights[asked] = self.weight(*asked)
        return self.weights[asked]

    def weight(self, name, given):
        """The same, of others that it is not among."""
        sums, nuisance = self.sums([*given, name]), self.places(given)
        kept = self.places([*given, name])
        own = kept[len(nuisance) :]
        if not all(sums.given(column, []) > 0 for column in own):
            return because(Reason.ADDS_NOTHING)
        beyond = np.array([sums.given(column, nuisance) for column in own])
        if (beyond < UNSEEN).any():
            return because(Reason.COLLINEAR)
        solved, covariance = self.solved(name, sums, kept)
        step = solved[len(nuisance) :]
        covariance = covariance[len(nuisance) :, len(nuisance) :]
        error = np.sqrt(np.diag(covariance))
        freedom = max(len(sums.clusters) - 1, 1)
        statistic = step @ np.linalg.solve(covariance, step) / len(own)
        # the law of Fisher, which rounding must not ask below nothing
        chance = float(fdtrc(len(own), freedom, max(statistic, 0.0)))
        share = np.sqrt(sums.rows / len(self.rows))
        rows, scale = self.effects[name].rows(), sums.scale[own]
        keys = {key: rows[key] for key in self.own[name]}
        family = self.family.of(self.effects[name])
        coefficients = dict(zip(keys, (step / scale).tolist()))
        stderr = dict(zip(keys, (error / scale).tolist()))
        return Weight(
            gain=root(self.gain(name, given)),
            p_value=min(1.0, chance * self.effects[name].choices),
            coefficients=coefficients,
            stderr=stderr,
            possible=self.possible(keys, coefficients, stderr),
            minimum_detectable=float(
                share * self.visible(freedom, family) * (error * beyond).max()
            ),
            rows=sums.rows,
            family=family,
        )

    def solved(self, name, sums, kept):
        """
        Best coefficients of an effect and of others, and their covariance.

        A change is there on each of its days, so that none which is left by much is to
        rule. Physics may be on few days, and those are left by much without it.
        """
        if self.effects[name].channel:
            sums, kept = sums.reweighted(kept), [*range(len(kept))]
        return sums.solve(kept), sums.covariance(kept)

    def parted(self, name, there, given):
        """
        What an effect of one tangent is on some rows and on the others, by itself each.

        With the covariance of the two; None where the tangent is nothing on either.
        """
        column = self.columns[self.own[name][0]]
        both = {"there": np.where(there, column, 0.0)}
        both["elsewhere"] = column - both["there"]
        if not all(np.ptp(part) > 0 for part in both.values()):
            return None
        found = self
        for part, values in both.items():
            found = found.with_column(part, values)
        sums, kept = found.sums(given), found.places([*given, *both])
        scale = sums.scale[kept[-2:]]
        covariance = sums.covariance(kept)[-2:, -2:] / np.outer(scale, scale)
        return sums.solve(kept)[-2:] / scale, covariance

    def possible(self, keys, coefficients, stderr):
        """Whether coefficients are in their bounds, as far as a tangent can say."""

        def slack(bound, error):
            most = self.criteria.bound_slack * abs(bound)
            return max(self.criteria.bound_errors * error, most)

        return all(
            row.lower - slack(row.lower, stderr[key])
            <= coefficients[key]
            <= row.upper + slack(row.upper, stderr[key])
            for key, row in keys.items()
        )

    def visible(self, freedom, family):
        """Standard errors that an effect needs to be seen, with the stated power."""
        seen = 1.0 - self.criteria.chance / family / 2.0
        return float(stdtrit(freedom, [seen, self.criteria.power]).sum())  # Student's

    def chance(self, weight):
        """Chance that any of its family looks as good by accident."""
        return min(1.0, weight.p_value * weight.family)

    def ties(self, name, gains, given=()):
        """Rivals given which an effect has nothing left to explain."""
        own = max(gains[name], 0.0) ** 2
        given = [other for other in given if other != name]
        limits = self.criteria
        rival, tied = (limits.rival, limits.tied)
        if self.effects[name].confounder:
            rival, tied = limits.confounder_rival, limits.confounder_tied
        rivals = [
            other
            for other, gain in gains.items()
            if other != name and max(gain, 0.0) ** 2 >= rival * own > 0.0
        ]
        return tuple(
            other for other in rivals if self.gain(name, [*given, other]) < tied * own
        )
