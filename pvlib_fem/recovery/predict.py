"""From what size on an effect should be found: the loop's own rules, to first order."""

from dataclasses import dataclass, replace

import numpy as np

from pvlib_fem.effects.courses import changes_of
from pvlib_fem.effects.effect import Effect
from pvlib_fem.loop.evidence import Evidence, Weight
from pvlib_fem.loop.gather import gather
from pvlib_fem.loop.propose import Proposals
from pvlib_fem.loop.rules import all_pass, rules
from pvlib_fem.loop.steps import Fits, Step
from pvlib_fem.loop.threads import one_blas_thread
from pvlib_fem.recovery.draw import Draw, course_of, drawn, holds, same_days, with_ways
from pvlib_fem.recovery.inject import READS, readable, reading
from pvlib_fem.statistics.changes import Daily

GROWS = 1.3  # from one size to the next, until the rules are passed
HALVINGS = 5  # between the last size that does not pass and the first that does
LEAST = 0.25  # of the standard errors, where sizes begin


def predictions(case, step, done, draws, seed, effect):
    """
    Draws of an effect with the sizes from which each should be found, or why none.

    Two looks are taken at the record's last residual with more and more of the effect,
    both to first order. The first is cheap, since all follows from sums by the day: its
    date has to be found, and the rules of size, chance and bounds to be passed. From
    that size on the loop makes a round of proposals, with all rivals, witnesses and
    unknown structure, until one of them holds it.

    Parameters
    ----------
    case : Case
    step : Step
        The last one.
    done : frozenset of str
        What the record's own findings hold.
    draws, seed : int
    effect : Effect

    Returns
    -------
    list of (Draw, float, float), and Because or None
        The last of the three is what the record itself has of it, the same way.
    """
    with one_blas_thread():
        fits = Fits(case)
        days = np.unique(case.record.dates[case.searched])
        planned, why = drawn(effect, days, case.criteria.change_side, draws, seed)
        if why is not None:
            return [], why
        looks = looked(fits, step, effect, planned)
        for look in looks:
            if not isinstance(look.weight, Weight):
                return [], look.weight
        names = [*effect.rows()]
        errors = [dict(zip(names, look.weight.stderr.values())) for look in looks]
        planned = [replace(d, effect=look.effect) for d, look in zip(planned, looks)]
        found = []
        for draw in with_ways(planned, errors, seed):
            look, given = looks[draw.number], (draw.way, days, step.coefficients)
            draw = replace(draw, readable=readable(draw.effect, *given))
            size = Round(fits, step, done, look, draw).size(look.size(draw))
            found.append((draw, size, look.own(draw)))
        return found, None


def looked(fits, step, effect, planned):
    """A look at each draw of an effect, beside all confounders."""
    there = {effect.name for effect in step.model.effects} | {effect.name}
    others = [e for e in fits.case.wanted if e.confounder and e.name not in there]
    if not effect.channel:
        found = fits.gathered(step, [*others, effect])
        # what it takes from the record is in it now
        effects = [found.effects.get(effect.name, effect)] * len(planned)
        names = [effect.name] * len(planned)
    else:
        names = [f"{effect.name} {draw.number}" for draw in planned]
        dated = [replace(d.effect, name=name) for d, name in zip(planned, names)]
        found = fits.gathered(step, [*others, effect.scanned_from, *dated])
        effects = [draw.effect for draw in planned]
    given = () if effect.confounder else tuple(found.confounders)
    return [Look(found, name, one, given) for name, one in zip(names, effects)]


@dataclass(frozen=True, eq=False)
class Look:
    """The first look that the loop would take at one effect."""

    found: Evidence
    name: str  # in the evidence
    effect: Effect
    given: tuple

    @property
    def weight(self):
        """What it explains of the record as it is."""
        if self.name in self.found.failed:
            return self.found.failed[self.name]
        return self.found.weigh(self.name, self.given)

    def coefficients(self, way, size):
        """So much of the effect, by the columns of the evidence."""
        return dict(zip(self.found.own[self.name], (size * p for p in way.values())))

    def own(self, draw):
        """What the record itself has of it, the same way."""
        values = self.weight.coefficients.values()
        return sum(value * part for value, part in zip(values, draw.way.values()))

    def size(self, draw):
        """The least size that passes and the record itself does not, or NaN."""
        weight = self.weight
        least = LEAST * np.linalg.norm(list(weight.stderr.values()))
        size = threshold(lambda s: self.passes(draw, s), least, draw.most)
        if size != least:
            return size
        # what is there passes by itself, and was refused for another reason
        without = {name: -value for name, value in weight.coefficients.items()}
        bare = replace(self, found=self.found.adding(without))
        return threshold(lambda s: bare.passes(draw, s), least, draw.most)

    def passes(self, draw, size):
        """Whether so much of it would pass."""
        more = self.found.adding(self.coefficients(draw.way, size))
        if self.effect.channel and not self.dated(more, draw):
            return False
        weight = more.weigh(self.name, self.given)
        asked = rules(more, self.name, weight, self.given)
        return weight.gain > 0 and all_pass(asked)

    def dated(self, more, draw):
        """Whether sums by the day show its dates."""
        wide = self.effect.name  # the channel without a course
        sums, (column,) = more.sums([wide]), more.own[wide]
        daily = Daily.of(sums, more.order[column], more.places(more.confounders))
        dates = course_of(self.effect).find(daily, more.criteria)
        if dates is None:
            return False
        return same_days(draw.effect, self.effect.make(**dates), sums.dates)


@dataclass(frozen=True, eq=False)
class Round:
    """A round of the loop's proposals, on a record with so much of an effect."""

    fits: Fits
    step: Step
    done: frozenset
    look: Look
    draw: Draw

    def size(self, size):
        """The least size from that one on with which it is proposed, or NaN."""
        while size <= self.draw.most:
            if self.proposes(size):
                return float(size)
            size *= GROWS
        return np.nan

    def proposes(self, size):
        """Whether so much of it is in any of the proposals."""
        case, step = self.fits.case, self.step
        record = self.fits.prepared(case.record, step.model)[0]
        record = record.having(self.moved(record, size))
        case = replace(case, record=record)
        there = {effect.name for effect in step.model.effects}
        wanted = [effect for effect in case.wanted if effect.name not in there]
        seen = case.searched & record.known(step.model.drivers)
        how = (case.criteria, case.family, step.at_bound)
        found = gather(step.model, step.coefficients, record, seen, wanted, *how)
        told = (step.coefficients, changes_of(step.model.effects))
        proposals = Proposals(case, found, self.done, *told)
        new, effects = proposals.run(), proposals.found.effects
        days = np.unique(record.dates)
        return any(holds(f, self.look.effect, effects, days) for f in new)

    def moved(self, record, size):
        """Columns of the record with so much of it."""
        look = self.look
        coefficients = look.coefficients(self.draw.way, size)
        if look.effect.channel in READS:
            (change,) = coefficients.values()
            return reading(record, look.effect, change, self.step.coefficients)
        module = record["temp_module"].copy()
        for name, value in coefficients.items():
            module[look.found.rows] += value * np.nan_to_num(look.found.columns[name])
        return {"temp_module": module}


def threshold(passes, least, most):
    """The size from which something passes, NaN where none does up to the most."""
    size, before = least, least
    while size <= most and not passes(size):
        before, size = size, GROWS * size
    if size > most:
        return np.nan
    for _ in range(HALVINGS):
        middle = np.sqrt(before * size)
        before, size = (before, middle) if passes(middle) else (middle, size)
    return float(size)
