"""What to add next: the effect that explains most, unless something unknown does."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

from pvlib_fem.effects import EFFECTS, PHYSICS
from pvlib_fem.effects.courses import (
    alike,
    is_drift,
    is_step,
    known_within,
    once_more,
    same_course,
    same_date,
)
from pvlib_fem.effects.effect import deciding
from pvlib_fem.findings import Check, Finding, Kind, Opinion, Verdict
from pvlib_fem.loop.case import Case
from pvlib_fem.loop.comparisons import MONTH, apart
from pvlib_fem.loop.evidence import Evidence, Weight
from pvlib_fem.loop.rules import Weighing, all_pass, gaining, has_driver, weighed
from pvlib_fem.loop.structure import against, sorting, structure, without_of
from pvlib_fem.loop.witness import Hearing, hearing, nights, outages
from pvlib_fem.reasons import Reason, because


@dataclass(eq=False)
class Proposals:
    """
    Findings of one round, the best first: drivers, then confounders.

    Forward selection: the best that is material, possible and no accident, until
    none is. What structure of unknown cause explains better waits beside it.
    """

    case: Case
    found: Evidence
    done: frozenset  # names that earlier findings hold already
    coefficients: Mapping  # of the model beside which all are weighed
    changes: tuple = ()  # effects of the model which have a date
    new: list = field(default_factory=list)
    aside: dict = field(default_factory=dict)  # what unknown structure explains better

    def run(self):
        """The findings, which the fits have yet to confirm."""
        effects = self.found.effects
        driven = [n for n, e in effects.items() if has_driver(e)]
        others = [n for n, effect in effects.items() if effect.confounder]
        self.select(driven, self.found.confounders)
        # weather comes in stretches, too: what follows a column comes before a date
        given = [*self.found.confounders, *self.names]
        if self.new:
            self.found = self.dated_beside(self.found, given)
        self.select(self.changing, given)
        # what changes for good may look like a season, and is not to be lost beside it
        self.select(others, self.names, self.lasting())
        return self.new

    @property
    def changing(self):
        """Names of all changes that have a date."""
        return [n for n, effect in self.found.effects.items() if effect.channel]

    def dated_beside(self, found, given, kept=()):
        """
        The evidence with changes at the dates that show beside what is found by now.

        Where something is unknown that grows or begins later, it moves the dates of
        others. Those of what is kept, or in a class, stay.
        """
        kept = {*kept, *(name for finding in self.new for name in finding.candidates)}
        movable = [
            (e, c) for e, c in found.changing if e.name not in kept and not is_drift(e)
        ]
        changes = found.shown(movable, given)

        names = [effect.name for effect, _ in movable]
        return self.both(found, lambda one: one.without(names).along(changes))

    def both(self, found, change):
        """What a change makes of the evidence, and of it with what is unknown."""
        bare, self.found = self.found, change(self.found)
        # columns are as long as the record: once, where none is unknown
        return self.found if found is bare else change(found)

    def lasting(self):
        """
        Drifts and steps that a confounder may stand for, of no date of another change.

        Steps that no date shows beside all confounders are dated beside what is in the
        model and what is found in this round. The two dates of an episode are in
        whatever a season leaves.
        """
        there = self.known
        dated = self.found.shown(self.undated(is_step), self.names)
        dated = [(e, c) for e, c in dated if not once_more(e, there)]
        effects = [self.found.effects[n] for n in self.changing]
        lasting = [e for e in effects if is_drift(e) or is_step(e)]
        lasting = [e.name for e in lasting if not once_more(e, there)]
        self.found = self.found.along(dated)
        return [*lasting, *(effect.name for effect, _ in dated)]

    def undated(self, fits):
        """Changes whose date did not show and does not yet, of a kind, and columns."""
        there = self.found.effects
        return [
            (e, c) for e, c in self.found.changing if fits(e) and e.name not in there
        ]

    @property
    def names(self):
        """Those of the new findings."""
        return [finding.effect for finding in self.new]

    @property
    def known(self):
        """Changes of the model, and those found in this round."""
        new = (self.found.effects[name] for name in self.names)
        return (*self.changes, *(effect for effect in new if effect.channel))

    @cached_property
    def sorting(self):
        """All ways to sort the rows, found once a round."""
        return sorting(self.case, self.found, self.found.confounders)

    def select(self, names, given, alike=()):
        """Add findings of some names, one after the other; others may look alike."""
        limits, found = self.case.criteria, self.found
        given, unknowns, spill, lost = list(given), 0, 0.0, set()
        # what cannot be told from a finding is no finding of its own
        gone = {*self.done, *(n for f in self.new for n in f.candidates)}
        gone -= {e.name for e, _ in found.changing if self.again(e)}
        names = [n for n in names if n not in gone]
        while names:
            # what is left of a change on its own date is no change of its own: that
            # says which member of its class is nearer, which no residual decides
            names = [n for n in names if not once_more(found.effects[n], self.known)]
            weighing = Weighing.of(found, names, given, spill, lost)
            best, sure = weighing.best, weighing.sure
            if sure and (others := self.of_its_date(found.effects[best])):
                # whatever channel shows a date, all are asked what they have of it
                found = self.both(found, partial(Evidence.along, changes=others))
                names += [effect.name for effect, _ in others]
                continue
            best = best if sure else weighing.hidden
            if best is None:
                break
            without = without_of(found, best)
            table = structure(self.case, found, given, self.sorting, without)
            if not sure and (table is None or table.gain < weighing.weights[best].gain):
                break  # nothing unknown hides it
            checks, explained = against(found, best, given, table, spill)
            if sure and all_pass(checks):
                name, told = self.taken(weighing, checks, alike)
                given.append(name)
                found, gone = found.on_rows_of(name), gone | told
                if found.effects[name].channel:
                    found = self.dated_beside(found, given, gone)
                    names = self.changing
                names = [n for n in names if n not in gone]
                continue
            if unknowns == limits.most_structures:
                break
            if not all_pass(checks) and has_driver(found.effects[best]):
                # most of what it explained is the unknown's, and what is left of it no
                # cause of its own in this round, but in a class
                lost.add(best)
            unknowns += 1
            self.aside[best] = (*weighing.asked[best], *checks)
            spill = max(spill, limits.structure_spill * explained)
            found = found.with_column(f"unknown:{unknowns}", table.values)
            given.append(f"unknown:{unknowns}")

    def taken(self, weighing, checks, alike):
        """The name of the best one, now a finding, and all that is told with it."""
        found, ties = weighing.found, self.tied(weighing, alike)
        heard = self.heard(weighing, ties)
        name, *others = heard.candidates
        gain = weighing.asked[name][0].statistic
        weight = replace(weighing.weights[name], gain=gain)
        checks = (*weighing.asked[weighing.best], *checks)
        self.new.append(proposed(self.case, found, weight, heard, checks))
        # along another course what was alike is another question
        told = [n for n in (weighing.best, *ties) if answers(found, name, n)]
        return name, {name, *others, *told}

    def of_its_date(self, effect):
        """Other channels along the course of a change, whose own date did not show."""
        if not effect.channel:
            return []
        others = self.undated(lambda other: same_course(effect, other))
        return [(one.make(**effect.settings), column) for one, column in others]

    def tied(self, weighing, alike):
        """What cannot be told from the best one."""
        found, best, weights = weighing.found, weighing.best, weighing.weights
        given = weighing.given
        # of its rivals no more is asked than of physics
        possible = [n for n, w in weights.items() if w.possible]
        chances = {n: found.chance(weights[n]) for n in possible}
        most = found.criteria.chance
        near = gaining(weights, (n for n in possible if chances[n] <= most))
        ties = found.ties(best, near | self.rivals(found, alike, given), given)
        unsure = (n for n in near if unsure_beside(found, best, n, given))
        ties = tuple(dict.fromkeys([*ties, *unsure]))
        return (*ties, *slow_ones(found, (best, *ties), weights))

    def rivals(self, found, names, given):
        """Gains of those names that are open and possible, as of a class."""
        taken = {n for finding in self.new for n in finding.candidates}
        names = [name for name in names if name not in {*self.done, *taken}]
        weights = weighed(found, names, given)
        return gaining(weights, (n for n, w in weights.items() if w.possible))

    @cached_property
    def comparisons(self):
        """What other columns have to say of the instruments."""
        return apart(self.case)

    def heard(self, weighing, ties):
        """The class of the best one, when its witnesses have been heard."""
        found, weights, good = weighing.found, weighing.weights, weighing.good
        best = weighing.best
        candidates = (best, *ties)
        kin = (n for n in self.kin(found, candidates) if can_be(weights.get(n)))
        candidates = tuple(dict.fromkeys([*candidates, *kin]))
        if not found.effects[best].channel:
            return Hearing(candidates)
        least = self.case.criteria.rival * good[best] ** 2
        channel = found.effects[best].channel
        rivals = [
            name
            for name, gain in good.items()
            if found.effects[name].channel
            and name not in candidates
            # along which course an instrument changed is for what vouches for it
            and (gain**2 >= least or found.effects[name].channel == channel)
        ]
        dark = self.case.record["poa_global"][found.rows] <= 0.0
        given = [*found.confounders, *self.names]
        also = nights(found, [*candidates, *rivals], dark, given)
        also |= outages(self.case, found.effects[best])
        how = (found.effects, weights, self.coefficients)
        # what is found before it is known to a witness, too
        comparisons = [one.beside(self.known) for one in self.comparisons]
        return hearing(comparisons, also, candidates, rivals, *how)

    def kin(self, found, candidates):
        """
        What no record by itself tells from those of a class.

        Of changes the channels that a better model would tell apart, along the same
        course, and effects that could not be tried for want of a column. Of others what
        is in the model along the same driver, whose law may be another.
        """
        effects = [found.effects[name] for name in candidates]
        fitted = [n for n in PHYSICS if n in self.done or n in self.names]
        for effect in (e for e in effects if e.name in PHYSICS and not e.confounder):
            drivers = PHYSICS[effect.name].drivers
            yield from (n for n in fitted if PHYSICS[n].drivers == drivers)
        for effect in (effect for effect in effects if effect.channel):
            course, again = effect.name.removeprefix(effect.channel), self.again(effect)
            names = (f"{channel}{course}" for channel in effect.kin)
            yield from (name for name in names if again or name not in self.done)
            # one that is in the model may leave something, as snow that melts does
            there = {*self.case.untestable, *self.done, *self.names}
            yield from (name for name in alike(effect) if name in there)

    def again(self, effect):
        """Whether what is in a class may come once more: it has another date."""
        return bool(effect.channel) and not is_drift(effect)


def can_be(weight):
    """Whether something that could not be weighed, or has a possible size."""
    return weight is None or weight.possible


def answers(found, name, other):
    """Whether one of a class, once it is taken, leaves no other of it to ask for."""
    one, two = found.effects[name], found.effects[other]
    return not (one.channel and two.channel) or same_course(one, two)


def unsure_beside(found, name, other, given):
    """Whether a change is within its error of nothing beside another of its date."""
    one, two = found.effects[name], found.effects[other]
    if name == other or not one.channel or not two.channel or not same_date(one, two):
        return False
    weight = found.weigh(name, [*given, other])
    if not isinstance(weight, Weight):
        return True
    (size,), (error,) = weight.coefficients.values(), weight.stderr.values()
    return abs(size) < found.criteria.bound_errors * error


def slow_ones(found, candidates, weights):
    """
    Drifts that explain nearly as much as steps of the same channels.

    Of steps whose date is not known to the month: what is told as one of them may have
    come slowly.
    """
    first = found.effects[candidates[0]]
    if not (first.channel and is_step(first)) or known_within(first, MONTH):
        return []
    channels = {found.effects[n].channel for n in candidates}
    least = found.criteria.rival * weights[first.name].gain ** 2
    gains = gaining(weights, (n for n, w in weights.items() if w.possible))
    return [
        name
        for name, gain in gains.items()
        if name not in candidates
        and found.effects[name].channel in channels
        and is_drift(found.effects[name])
        and gain**2 >= least
    ]


def proposed(case, found, weight, heard, checks):
    """The finding of an effect that passes all checks."""
    name, *ties = heard.candidates
    effects = [found.effects[n] for n in heard.candidates if n in found.effects]
    if not case.enough:
        least = case.criteria.enough_days
        verdict = Verdict.SUGGESTIVE
        why = because(Reason.TOO_SHORT, days=case.days, least=least)
        checks = (*checks, Check("days", "enough_days", case.days, least))
    elif effects[0].confounder or ties or (effects[0].channel and not heard.agreed):
        # what witnesses agree with is told from the others by what tells of those
        asked = [EFFECTS[n] for n in ties if n in EFFECTS] if heard.agreed else []
        verdict = Verdict.CLASS
        measurements = deciding(asked or effects)
        why = because(Reason.WOULD_DECIDE, measurements=measurements)
    else:
        verdict = Verdict.NAMED
        why = because(Reason.GAINED, gain=weight.gain, chance=found.chance(weight))
        if heard.agreed:
            agree = [o for o in heard.witnesses if o.opinion is Opinion.AGREES]
            columns = list(dict.fromkeys(one.column for one in agree))
            why = because(Reason.WITNESSED, gain=weight.gain, columns=columns)
    return Finding(
        name,
        (name, *ties),
        verdict,
        weight.gain,
        weight.coefficients,
        weight.stderr,
        why,
        checks,
        Kind.of(effects[0]),
        place=dated(effects[0]),
        witnesses=heard.witnesses,
    )


def dated(effect):
    """The dates of a change in words, and of other effects nothing."""
    return effect.source if effect.channel else ""


def choices_of(finding, found):
    """A finding by each of its candidates that has weight, with its effect."""
    for name in finding.candidates:
        mine = renamed(finding, found, name)
        if mine is not None:
            yield mine, found.effects[name]


def renamed(finding, found, name, given=()):
    """A class by another of its candidates, or None where that has no weight."""
    if name == finding.effect:
        return finding
    if name not in found.effects:  # it stands in the class, and could not be tried
        return None
    weight = found.weigh(name, given)
    if not isinstance(weight, Weight):
        return None
    return replace(
        finding,
        effect=name,
        candidates=(name, *(n for n in finding.candidates if n != name)),
        coefficients=weight.coefficients,
        stderr=weight.stderr,
        place=dated(found.effects[name]),
    )
