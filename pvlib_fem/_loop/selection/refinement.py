"""Other choices than those selected: one time profile can stand for two."""

from collections.abc import Iterable, Iterator, Sequence

from pvlib_fem._loop.selection.choice import Choice
from pvlib_fem._loop.selection.dictionary import Candidate, log_odds
from pvlib_fem._loop.selection.single_effects import BETTER, SWEEPS, Selection
from pvlib_fem._statistics.extremes import largest_first
from pvlib_fem._statistics.weekly_sums import held_out


def refined(selection: Selection, choices: list[Choice]) -> list[Choice]:
    """
    The choices, or others that explain more, as far as these are tried.

    What they explain by each effect more has to be material, and so what is lost by
    one less. Of as many effects, those with fewer dates need no margin.

    Parameters
    ----------
    selection : Selection
    choices : list of Choice
        That it selected.

    Returns
    -------
    list of Choice
    """
    least = remaining(selection, choices)
    for _ in range(SWEEPS):
        for other, better in alternatives(selection, choices):
            more = (len(other) - len(choices)) * selection.least
            if not more and dates_of(other) >= dates_of(choices):
                more = better
            less = remaining(selection, other)
            if less < least - more:
                choices, least = other, less
                break
        else:
            break
    return choices


def remaining(selection: Selection, choices: Sequence[Choice]) -> float:
    """Mean square on weeks left out in turn, given some choices. [K²]"""
    given = selection.given(choices)
    design = selection.design.at(given)
    return held_out(design.by_week(given), design.folds) / design.count


def alternatives(
    selection: Selection, choices: list[Choice]
) -> Iterator[tuple[list[Choice], float]]:
    """
    Other choices, and by how much they have to be better. [K²]

    One time profile can stand for two, such as a temporary change for a trend and a
    step. So each change is omitted, the others are made anew without its time
    profile, and then with it, as the refinement of SuSiE does (Zou et al., 2022).
    Two changes can also hide each other, such as a trend until a sensor is cleaned.
    """
    for one in choices:
        if one.top.effect.sensor_fault:
            profile = one.top.time_profile
            others = [other for other in choices if other is not one]
            others = selection.run(others, profile)
            better = (BETTER - 1.0) * one.fall
            yield selection.run(others), better
            for pair in hidden_pairs(selection, others, profile):
                yield selection.run([*others, *pair]), better
    for pair in hidden_pairs(selection, choices):
        yield selection.run([*choices, *pair]), 0.0


def hidden_pairs(
    selection: Selection, choices: list[Choice], without: str = ""
) -> Iterator[list[Choice]]:
    """
    Two changes, of which the first is not sure alone, and both are together.

    The odds of both are those of the first alone times those of the second given
    it.
    """
    given = selection.given(choices)
    others = selection.candidates(given, selection.taken(choices), without)
    others = [one for one in others if one.effect.sensor_fault]
    falls = selection.in_sample(others, given)
    firsts: dict[str, Candidate] = {}
    for i in largest_first(falls):
        if falls[i] >= selection.least:
            firsts.setdefault(others[i].time_profile, others[i])
    needed = log_odds(selection.criteria.min_probability)
    for one in firsts.values():
        alone = selection.score(one, given)
        if not alone.possible or alone.fall < selection.least:
            continue
        second = selection.best([*choices, Choice(one, alone)], without=without)
        if second is None:
            continue
        both = log_odds(alone.probability) + log_odds(second.score.probability)
        beside = selection.score(one, selection.given([*choices, second]))
        if selection.holds(beside) and both >= needed:
            yield [Choice(one, beside), second]


def dates_of(choices: Iterable[Choice]) -> int:
    """Number of dates of some choices that were searched for."""
    return sum(one.top.dates for one in choices)
