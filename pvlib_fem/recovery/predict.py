"""From what size on an effect should be found: the loop's own rules, to first order."""

from dataclasses import dataclass, replace

import numpy as np

from pvlib_fem.effects.courses import weights_of
from pvlib_fem.loop.evidence import Evidence, Weight
from pvlib_fem.loop.propose import all_pass, material, rules
from pvlib_fem.recovery.draw import course_of, drawn, with_ways
from pvlib_fem.statistics.changes import Daily

GROWS = 1.3  # from one size to the next, until the rules are passed
HALVINGS = 5  # between the last size that does not pass and the first that does
LEAST = 0.25  # of the standard errors, where sizes begin
SAME = 0.5  # of the days that two stretches have together: of the same event


def predictions(search, step, effect, draws, seed):
    """
    Draws of an effect with the sizes from which each should be found, or why none.

    The loop's first look is taken at the last residual of the record with more and
    more of the effect: its date is searched in sums by the day, and it has to pass
    the rules of size, chance and bounds. All of that follows from the sums alone.

    Parameters
    ----------
    search : Search
        That is done.
    step : Step
        Its last one.
    effect : Effect
    draws, seed : int

    Returns
    -------
    list of (Draw, float, float), and Because or None
        The last of the three is what the record itself has of it, the same way.
    """
    case, fits = search.case, search.fits
    days = np.unique(case.record.dates[case.searched])
    planned, why = drawn(effect, days, case.criteria.change_side, draws, seed)
    if why is not None:
        return [], why
    others = [e for e in case.wanted if e.confounder and e.name != effect.name]
    others = [e for e in others if e.name not in {m.name for m in step.model.effects}]
    if not effect.channel:
        found = fits.gathered(step, [*others, effect])
        labels = [effect.name] * len(planned)
        # what it takes from the record is in it now
        effect = found.effects.get(effect.name, effect)
        planned = [replace(draw, effect=effect) for draw in planned]
    else:
        labels = [f"{effect.name} {draw.number}" for draw in planned]
        dated = [replace(d.effect, name=n) for d, n in zip(planned, labels)]
        found = fits.gathered(step, [*others, effect.scanned_from, *dated])
    given = () if effect.confounder else tuple(found.confounders)
    looks = [Look(found, name, effect, given) for name in labels]
    weights = [look.weight for look in looks]
    for weight, name in zip(weights, labels):
        if not isinstance(weight, Weight):
            return [], found.failed.get(name, weight)
    names = [*effect.rows()]
    errors = [dict(zip(names, weight.stderr.values())) for weight in weights]
    ready = with_ways(planned, errors, seed)
    return [(draw, *looks[draw.number].sizes(draw)) for draw in ready], None


@dataclass(frozen=True, eq=False)
class Look:
    """The first look that the loop would take at one effect."""

    found: Evidence
    name: str  # in the evidence
    effect: object
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

    def sizes(self, draw):
        """From which it passes, NaN where none does, and what the record has of it."""
        values = self.weight.coefficients.values()
        own = sum(value * part for value, part in zip(values, draw.way.values()))
        return self.size(draw), own

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
        floor = material(more, self.given, more.criteria)
        return weight.gain > 0 and all_pass(rules(more, weight, floor))

    def dated(self, more, draw):
        """Whether sums by the day show its dates."""
        wide = self.effect.name
        sums, (column,) = more.sums([wide]), more.own[wide]
        daily = Daily.of(sums, more.order[column], more.places(more.confounders))
        dates = course_of(self.effect).find(daily, more.criteria)
        if dates is None:
            return False
        return same_days(draw.effect, self.effect.make(**dates), sums.dates)


def same_days(one, other, days):
    """Whether two changes of one course are on the same days, but for a part."""
    if course_of(one).name == "drift":
        return True
    a, b = (weights_of(effect, days) > 0.0 for effect in (one, other))
    return bool((a & b).sum() >= SAME * (a | b).sum())


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
