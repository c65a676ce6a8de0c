"""
How far coefficients may lie from where they were fitted, by the other models that a
record leaves possible.

The error of a coefficient is its scatter between weeks under one model. Beside it
stand models in which another finding is not there, in which a member of its class is in
its place, which have one more effect or misfit, or any means in the cells of what no
effect explains. All are linear algebra on sums by the day, at no further fit. How much
is not known is judged by what is [1]_.

References
----------
.. [1] C. Cinelli and C. Hazlett, "Making sense of sensitivity: extending omitted
   variable bias", J. R. Stat. Soc. B 82, 39-67, 2020: what is not measured, judged by
   what is. :doi:`10.1111/rssb.12348`
"""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import stdtrit

from pvlib_fem.effects import CHANGES
from pvlib_fem.effects.effect import deciding
from pvlib_fem.effects.instruments import LIT
from pvlib_fem.findings import OUTPUT, Check, Verdict, vouched
from pvlib_fem.loop.evidence import UNSEEN
from pvlib_fem.reasons import Reason, because
from pvlib_fem.statistics.clusters import ClusterSums, cluster_sums
from pvlib_fem.statistics.tables import Structure

LEVEL = 0.95  # of the interval by each of the models


def with_ranges(findings, found, step, tables):
    """
    The findings that are in the model, with ranges of their coefficients.

    A range reaches as far to either side as the most distant end of the intervals of
    all models lies to one: what is not known may pull either way, and as hard as what
    is known. It ends where a coefficient cannot be, and of a change that witnesses
    agree with at the last of their own intervals. A name of which nothing is there in
    the cells of a table is a class.

    Parameters
    ----------
    findings : list of Finding
    found : Evidence
        Beside the last step.
    step : Step
    tables : list of Structure
        What no effect explains.

    Returns
    -------
    list of Finding
    """
    added = [finding for finding in findings if finding.added]
    if not added:
        return findings
    reach, unknown = dict.fromkeys(found.base, 0.0), {}
    own = {f.effect: {*own_of(found, f)} for f in added}
    fitted = np.array([step.coefficients[name] for name in found.base])
    for model, mine, moves, half in moved(found, models(added, found, step, tables)):
        for i, ends in zip(mine, np.abs(moves) + half):
            reach[found.base[i]] = max(reach[found.base[i]], float(ends))
        if model.table:
            nothing = np.sign(fitted[mine]) * (fitted[mine] + moves) <= half
            lost = {i for i, none in zip(mine, nothing) if none}
            # what is held, or at a bound, has no place
            names = [name for name, places in own.items() if places and places <= lost]
            unknown |= dict.fromkeys(names, model.table)
    findings = [ranged(f, step, reach) if f.added else f for f in findings]
    return [of_the_unknown(f, step, unknown.get(f.effect)) for f in findings]


def of_the_unknown(finding, step, table):
    """A name as a class where nothing of it is there in the cells of the unknown."""
    if finding.verdict is not Verdict.NAMED or table is None:
        return finding
    (effect,) = (e for e in step.model.effects if e.name == finding.effect)
    columns, words = list(table.drivers), deciding([effect])
    why = because(Reason.WITHIN_UNKNOWN, drivers=columns, measurements=words)
    return replace(finding, verdict=Verdict.CLASS, because=why)


def everywhere(added, found, step):
    """
    By finding, the check that beside no other effect it is near nothing, and why it is.

    Of several coefficients one that is apart from nothing will do. Confounders are not
    asked, beside all of which it was weighed. Nor are changes of an instrument, which
    come after what follows a column, and of which one says what has changed, and not
    whether; nor power of what takes light, which power follows as the module does.
    """
    fitted = np.array([step.coefficients[name] for name in found.base])
    effects = found.effects.items()
    others = [n for n, e in effects if not e.confounder and n not in CHANGES]
    own, nearest = {f.effect: own_of(found, f) for f in added}, {}
    for model, mine, moves, half in moved(found, larger(added, found, step, others)):
        value = fitted[mine] + moves
        apart = (np.abs(value) / half).tolist(), value.tolist(), half.tolist()
        lit = LIT if model.more == OUTPUT else ()
        for effect in (name for name in own if name not in lit):
            here = [
                (times, model.more, found.base[i], *rest)
                for i, times, *rest in zip(mine, *apart)
                if i in own[effect]
            ]
            if here:
                farthest = max(here)
                nearest[effect] = min(nearest.get(effect, farthest), farthest)
    return {effect: distance(*one) for effect, one in nearest.items()}


def distance(times, other, name, value, half):
    """The check of a coefficient beside another effect, and why it fails."""
    return (
        Check("times its interval from nothing beside others", "", times, 1),
        because(
            Reason.ELSEWHERE, other=other, coefficient=name, value=value, half=half
        ),
    )


@dataclass(frozen=True, eq=False)
class Model:
    """Another model that the record leaves possible, by sums and their columns."""

    sums: ClusterSums = field(repr=False)
    kept: list  # columns that it has
    more: str = ""  # the effect or misfit that it has beside
    silent: tuple = ()  # columns of which it says nothing
    table: Structure | None = None  # of what is unknown, within whose cells it looks


def moved(found, others):
    """
    Of each of some models what it says of the coefficients that are fitted.

    The model, the places of which it says something, by how much they move from where
    they are, and half of their intervals.
    """
    base = found.places(())
    start = found.sums(()).solve(base) / found.sums(()).scale[base]
    for model in others:
        mine = [i for i in base if i in model.kept and i not in model.silent]
        shift, half = solved(model.sums, model.kept, mine)
        yield model, mine, shift - start[mine], half


def solved(sums, kept, wanted):
    """Shift of some of the columns of a model, and half of their interval."""
    own, sums = [kept.index(place) for place in wanted], sums.of(kept)
    every = [*range(len(kept))]
    shift, scale = sums.solve(every), sums.scale
    error = np.sqrt(np.diag(sums.covariance(every)))
    times = stdtrit(max(len(sums.clusters) - 1, 1), 0.5 + LEVEL / 2.0)  # Student's
    return (shift / scale)[own], (times * error / scale)[own]


def models(added, found, step, tables):
    """All models that a record leaves possible beside the one that is told."""
    base = found.places(())
    yield Model(found.sums(()), base)
    yield from larger(added, found, step, (*found.misfits, *found.effects))
    for finding in added:
        own = own_of(found, finding)
        without = np.zeros(len(found.columns))
        for place in own:
            without[place] = -step.coefficients[found.base[place]]
        kept = [place for place in base if place not in own]
        yield Model(found.sums(()).about(without), kept)
        for name in found.effects.keys() & same(finding, found, step):
            sums, places = beside(found, [name], kept)
            yield Model(sums.about(without), places, name)
    columns = {e.name: e.column for e in step.model.effects}
    for table in tables:
        # in cells of a column, what does no more than follow it is hardly to be seen
        silent = [f for f in added if columns[f.effect] in table.drivers]
        own = own_of(found, *silent)
        yield Model(within(found, table.bins), base, silent=own, table=table)


def larger(added, found, step, names):
    """Models with one more effect or misfit each."""
    for name in names:
        silent = [f for f in added if name in same(f, found, step)]
        sums, places = beside(found, [name], found.places(()))
        yield Model(sums, places, name, own_of(found, *silent))


def same(finding, found, step):
    """Effects that may be the same cause: its class, and what is never told from it."""
    (effect,) = (e for e in step.model.effects if e.name == finding.effect)
    if not effect.channel:
        return {*finding.candidates}
    channels = {effect.channel, *effect.kin}  # along any course
    alike = [name for name, e in found.effects.items() if e.channel in channels]
    return {*finding.candidates, *alike}


def own_of(found, *findings):
    """Places of what some findings have in the base."""
    names = {name for finding in findings for name in finding.coefficients}
    return [i for i in found.places(()) if found.base[i] in names]


def beside(found, names, kept):
    """Sums of the rows on which some effects are known, and columns with theirs."""
    sums, places = found.sums(names), list(kept)
    for place in found.places(names)[len(found.base) :]:
        if sums.given(place, []) > 0 and sums.given(place, places) > UNSEEN:
            places.append(place)
    return sums, places


def within(found, bins):
    """Sums of the fitted columns about their means in each cell of a table."""
    size = np.maximum(np.bincount(bins), 1)

    def about(column):
        return column - (np.bincount(bins, column) / size)[bins]

    limits = found.criteria.folds, found.criteria.fewest_clusters
    columns = [about(found.columns[name]) for name in found.base]
    return cluster_sums(columns, about(found.residual), found.dates, *limits)


def ranged(finding, step, reach):
    """The finding with the ranges of those coefficients that were fitted."""
    rows, found = step.model.parameters, {}
    for name in finding.coefficients:
        if name in reach:
            value, row = step.coefficients[name], rows[name]
            low, high = value - reach[name], value + reach[name]
            if seen := vouched(finding):
                low, high = max(low, min(*seen, value)), min(high, max(*seen, value))
            found[name] = (max(low, row.lower), min(high, row.upper))
    return replace(finding, ranges=found)
