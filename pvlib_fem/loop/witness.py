"""
What else in a record vouches for an instrument, or speaks against a change of it.

Columns that see what an instrument should see, the sky and the weather themselves, and
the nights, in which an offset is there and a gain is not.
"""

from dataclasses import dataclass

import numpy as np

from pvlib_fem.effects.courses import COURSES, alike, is_dated, known_within, weights_of
from pvlib_fem.effects.instruments import COVERS, OFFSETS
from pvlib_fem.findings import NIGHT, OUTPUT, Opinion, Witness
from pvlib_fem.loop.comparisons import (
    FEWEST_MONTHS,
    HALF,
    MONTH,
    OUTAGE,
    SLACK,
    compared,
    opinion_of,
)

BETTER = 10.0  # of twice a log-likelihood, by which one course beats another


@dataclass(frozen=True)
class Hearing:
    """What is left of a class when its witnesses have been heard."""

    candidates: tuple  # the first is taken
    witnesses: tuple = ()
    agreed: bool = False  # whether a witness speaks for what is left


def hearing(comparisons, also, candidates, rivals, effects, weights, coefficients):
    """
    Ask all witnesses about the candidates of a class.

    One that a witness contradicts is none; if witnesses agree with some, only those
    are left, and what may lie on the instrument. ``rivals`` are further ones that
    explain less, as another course of the same channel, and come in where a witness
    agrees with them. ``also`` are witnesses by candidate that vouch for no single
    instrument: they count beside no other.
    """
    changes = [n for n in (*candidates, *rivals) if n in weights and effects[n].channel]
    vouch = {}
    for name in changes:
        (size,), (error,) = (
            part.values() for part in (weights[name].coefficients, weights[name].stderr)
        )
        heard = (c.of(effects[name], size, error, coefficients) for c in comparisons)
        vouch[name] = [one for one in heard if one is not None]
    said = {n: [*vouch.get(n, ()), *also.get(n, ())] for n in (*candidates, *vouch)}
    against = [n for n, heard in said.items() if any_is(Opinion.CONTRADICTS, heard)]

    def agreeing(heard):
        names = [n for n in heard if any_is(Opinion.AGREES, heard[n])]
        return [name for name in names if name not in against]

    vouched = agreeing(vouch)
    mine = {n: also[n] for n in candidates if n in also and n in weights}
    if agreed := vouched or agreeing(mine):
        best = courses(comparisons, agreed, effects)
        channel = effects[best[0]].channel
        others = [
            n for n in candidates if n in agreed and effects[n].channel != channel
        ]
        kept = asked = (*best, *others)
        if channel == "sensitivity":
            lying = COVERS if {*COVERS} <= {*alike(effects[best[0]])} else ()
            kept = (*kept, *(name for name in candidates if name in lying))
    else:
        asked = candidates
        kept = [name for name in candidates if name not in against]
        if not any(name in weights for name in kept):  # none that could be added
            kept = candidates
        kept = sorted(kept, key=lambda name: name not in weights)
    witnesses = tuple(one for name in asked for one in said.get(name, ()))
    return Hearing(tuple(kept), witnesses, bool(vouched))


def any_is(opinion, witnesses):
    return any(one.opinion is opinion for one in witnesses)


def outages(case, effect):
    """
    Whether the plant fed while something was so for a while, of each power.

    What is not fed heats the modules, as irradiance that the sensor does not see.
    """
    if OUTPUT not in alike(effect):
        return {}
    heard = []
    for name in filter(OUTAGE.serves, case.witnesses):
        one = compared(OUTAGE, case, name, case.record[name], np.isfinite)
        if one is None or not np.ptp(weights := weights_of(effect, one.days)) > 0:
            continue
        _, error, _ = one.along(weights)
        inside, outside = (one.apart[weights == there].mean() for there in (1.0, 0.0))
        size = float(inside / outside - 1.0)
        opinion = opinion_of(size, -1.0, error)
        heard.append(Witness(name, OUTPUT, size, error, -1.0, opinion))
    return {OUTPUT: heard} if heard else {}


def nights(found, names, dark, given):
    """
    What each offset among some changes is by night, beside what it is by day.

    An offset shows by night, a gain does not, and would be an offset by day alone.
    """
    heard = {}
    for name in (n for n in names if n in found.effects):
        effect = found.effects[name]
        if effect.channel not in OFFSETS or name in found.partial:
            continue
        (row,) = effect.rows().values()
        parted = found.parted(name, dark, given)
        if parted is None:
            continue
        (size, expected), covariance = parted
        ways = np.array([1.0, -HALF])
        apart = np.sqrt(ways @ covariance @ ways)
        opinion = opinion_of(size, expected, apart, SLACK * expected)
        size, error = float(size), float(np.sqrt(covariance[0, 0]))
        # the same residual, whose error knows no more of other models
        said = (size, error, float(expected), opinion, row.unit)
        heard[name] = [Witness(NIGHT, name, *said)]
    return heard


def courses(comparisons, agreed, effects):
    """
    Of candidates of one channel those whose course witnesses follow best.

    Beside them stands another course of the channel that witnesses follow better: what
    the record shows along one may be the rest of another. So does one that they follow
    nearly as well, where the record knows no date to the month, as of what is slow. And
    every course does, where they clearly follow steps of one or two other dates: the
    record shows several changes as one, or a step where something ends.
    """
    channel = effects[agreed[0]].channel
    asked = [one for one in comparisons if channel in one.comparison.shows]
    every = [n for n, e in effects.items() if e.channel == channel and is_dated(e)]
    if not asked:  # the nights follow no course
        return tuple(name for name in agreed if name in every)
    days = np.unique(np.concatenate([one.days for one in asked]))
    dates = np.arange(days[0], days[-1], MONTH)[FEWEST_MONTHS:-FEWEST_MONTHS]
    followed, steps = 0.0, 0.0
    for one in asked:
        weights = [weights_of(effects[name], one.days) for name in every]
        lacks, by_two = one.misfits(weights, dates)
        followed, steps = followed + lacks, steps + by_two
    left = dict(zip(every, followed))
    best = min((name for name in agreed if name in left), key=left.get)
    known = known_within(effects[best], MONTH)
    room = {name: 0.0 if known and name not in agreed else BETTER for name in left}
    near = [n for n in left if n != best and left[n] < left[best] + room[n]]
    if np.min(steps, initial=np.inf) + BETTER < left[best]:
        near += [f"{channel}_{course.name}" for course in COURSES]
    return tuple(dict.fromkeys((best, *near)))
