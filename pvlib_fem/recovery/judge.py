"""What a loop made of a record with an effect in it, beside what it says without."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from pvlib_fem.findings import Verdict
from pvlib_fem.loop.close import close_loop
from pvlib_fem.recovery.draw import Injection, holds
from pvlib_fem.stored import Stored

INTERVAL = 1.96  # standard errors of 95 %


@dataclass(frozen=True)
class Outcome:
    """
    What became of an injection.

    Attributes
    ----------
    injection : Injection
    found : bool
        Whether a finding that was added to the model names it, or holds it in its
        class; of a change with dates, about the same days.
    named, first : bool
        Whether it is named; whether it is the first of all that the record itself
        does not show.
    told : tuple of str
        Findings that the record itself does not show, each with its candidates and
        dates.
    wrong : tuple of str
        Of those, names without the truth among their candidates.
    misled : tuple of str
        Of those, classes without it.
    lost : tuple of str
        Findings of the record itself that are no longer there.
    ratio : float
        Coefficient over truth, along the truth; NaN where it is not in the model.
    covered, in_range : float
        Whether the truth is within 1.96 standard errors, and within the finding's
        range; of several coefficients the share, NaN where there is none.
    half_range : float
        Half the width of that range over the truth, in the mean of several.
    refused : str
        Why the loop did not take the record, if it did not.
    """

    injection: Injection
    found: bool = False
    named: bool = False
    first: bool = False
    told: tuple = ()
    wrong: tuple = ()
    misled: tuple = ()
    lost: tuple = ()
    ratio: float = np.nan
    covered: float = np.nan
    in_range: float = np.nan
    half_range: float = np.nan
    refused: str = ""

    @classmethod
    def stored(cls, content: Stored) -> Self:
        """The outcome of a part of a file."""
        flags, texts = ("found", "named", "first"), ("told", "wrong", "misled", "lost")
        numbers = ("ratio", "covered", "in_range", "half_range")
        own: dict[str, Any] = {name: content.flag(name) for name in flags}
        own |= {name: content.texts(name) for name in texts}
        own |= {name: content.number(name, unknown=True) for name in numbers}
        injection = Injection.stored(content.part("injection"))
        return cls(injection, **own, refused=content.text("refused"))


def recovered(data, injector, baseline, how, injection):
    """
    Put an effect into a record, close the loop, and see what it says.

    Parameters
    ----------
    data : DataFrame
    injector : Injector
    baseline : tuple of Finding
        What the loop finds in the record itself.
    how : dict
        Arguments of the loop.
    injection : Injection
    """
    try:
        loop = close_loop(injector.into(data, injection), **how)
    except ValueError as error:
        return Outcome(injection, refused=str(error))
    return judged(injection, injector.effect(injection), loop, baseline)


def judged(injection, effect, loop, baseline):
    """What a loop's findings are beside the truth and those of the record itself."""
    before = [f for f in baseline if f.added]
    added = [f for f in loop.findings if f.added]
    effects = {e.name: e for e in loop.fit.effects}
    days = np.unique(loop.fit.record.dates)
    # nothing that the record itself shows is put in: a class that holds it is of it,
    # though it holds something that the record shows, too
    right = [f for f in added if holds(f, effect, effects, days)]
    new = [f for f in added if f in right or not any(same(f, one) for one in before)]
    others = [f for f in new if effect.name not in f.candidates]
    names = [f.effect for f in others if f.verdict is Verdict.NAMED]
    classes = [words(f) for f in others if f.verdict is Verdict.CLASS]
    lost = [words(f) for f in before if not any(same(f, other) for other in added)]
    sizes = {}
    if right and right[0].effect == effect.name:
        sizes = beside(right[0], injection.coefficients)
    return Outcome(
        injection,
        found=bool(right),
        named=any(f.verdict is Verdict.NAMED for f in right),
        first=bool(right) and right[0] is new[0],
        told=tuple(", ".join(filter(None, (words(f), f.place))) for f in new),
        wrong=tuple(names),
        misled=tuple(classes),
        lost=tuple(lost),
        **sizes,
    )


def same(one, other):
    """Whether two findings share a candidate."""
    return not {*one.candidates}.isdisjoint(other.candidates)


def words(finding):
    return " | ".join(finding.candidates)


def beside(finding, truth):
    """Coefficients of a finding beside the true ones."""
    values, errors = finding.coefficients, finding.stderr
    square = sum(value**2 for value in truth.values())
    along = sum(values[name] * value for name, value in truth.items())
    within = [
        abs(values[n] - value) <= INTERVAL * errors[n] for n, value in truth.items()
    ]
    # what is held has no range, and what does not act has no truth to be beside
    known = [(finding.ranges[n], v) for n, v in truth.items() if n in finding.ranges]
    inside = [low <= value <= high for (low, high), value in known]
    halves = [(high - low) / 2.0 / abs(v) for (low, high), v in known if v != 0.0]
    return {
        "ratio": float(along / square),
        "covered": float(np.mean(within)),
        "in_range": float(np.mean(inside)) if inside else np.nan,
        "half_range": float(np.mean(halves)) if halves else np.nan,
    }
