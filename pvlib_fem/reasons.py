"""Why something was or was not found: typed, and put into words here alone."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any


class Reason(Enum):
    """A reason; its value is the sentence, with places for the numbers behind it."""

    # a column that is not used
    NOT_NUMERIC = "{column} is not numeric"
    INFINITE = "{column} is infinite at {time}"
    EMPTY = "{column} holds no value"
    MISSING = "{share:.0%} of {column} is missing"
    CONSTANT = "{column} is constant"
    COPY = "{column} is a copy of {other}"
    DOUBTFUL = "{column} {doubt}"
    ORIGINAL = "{column} is as it was measured, before a correction"
    TAKEN = (
        "{column} is the name of a driver that is computed here; rename the column to "
        "have it tried"
    )
    LEAK = (
        "{column} is the module temperature itself, or made from it; a second sensor "
        "at the module is a cross-check under the name temp_module_2"
    )

    OUTPUT = (
        "{column} looks like {name}: {evidence}, so it is an output of the modules and "
        "no cause of their temperature; if it is their power, rename it ({options})"
    )

    # an effect that could not be weighed, or not be seen
    LACKS = "no {columns}"
    LACKS_ALL = "no {columns: or }"
    FEW_FITTING_DAYS = "at least {least} fitting days are needed (here {days})"
    FEW_DAYS = "at least {least} days are needed (here {days})"
    COARSE_CLOCK = (
        "with rows this far apart, clock offsets of the module's logger below "
        "{minutes:.2g} min cannot be detected"
    )
    OFF_THE_SUN = "the clock of the file does not fit the sun at the location"
    ESTIMATED = "the angles of the plane are estimated: give them"
    ANOTHER_PLANE = (
        "the irradiance is not of the stated plane: it has {plane}; look at how its "
        "sensor stands, and at the angles that are given"
    )
    ADDS_NOTHING = "it adds nothing in this record's weather"
    COLLINEAR = "the record cannot tell it from the fitted coefficients"
    NOT_A_NUMBER = "it is not a number in all rows with its columns"
    BROKEN = "{error}"
    NO_DATE = "the remaining error shows no date at which it begins"
    NO_WINDOW = "the remaining error follows no obstacle in front of the sun"
    NO_STANDSTILL = "the remaining error shows no days on which the tracker is stuck"
    NO_STORAGE = "the remaining error follows no mass that stores heat"
    NO_AXIS = "the plane of the modules does not turn about an axis"
    STAND_IN = "no {columns: or }: only an estimate from the usual inputs was tried"
    DETECTABLE = "this record shows it only from {gain:.2g} K on"
    ANOTHER_CONFOUNDER = (
        "its fitted size is physically impossible: another cause follows the same "
        "columns"
    )
    SUSPECT_SENSOR = "its fitted size is physically impossible: check its sensor"
    SUSPECT_IRRADIANCE = (
        "its fitted size is physically impossible: check the irradiance sensor"
    )
    SOURCE = "from {source}"

    # a finding
    GAINED = "reduces the cross-validated error by {gain:.2f} K"
    CORROBORATED = "{columns: and } and the sensor differ along the same time profile"
    WOULD_DECIDE = "{measurements:; or } would decide"
    TOO_SHORT = "at least {least} days are needed to identify a cause (here {days})"
    AT_BOUND = "fitted with all others, {coefficient} ends at the bound of its range"
    UNSURE = "fitted with all others, {coefficient} is {value:.2g} ± {error:.2g}"
    OUTSIDE = (
        "the error follows these inputs, and not by this law under all conditions: a "
        "cause outside the catalogue is more probable ({chance})"
    )
    SNOW = (
        "only hours in which snow can lie show it, so that snow or ice is as "
        "probable ({chance})"
    )
    LESS_ON_OWN_STEPS = (
        "on the record's own steps the error falls by {gain:.2f} K, in means by "
        "{means:.2f} K"
    )
    NOT_SURE = (
        "the probability that there is such an effect is {chance:.1%}; {least:.0%} is "
        "required"
    )
    NOT_MATERIAL = "below the {least:.2f} K that are material"
    NOT_MATERIAL_FITTED = (
        "below the {least:.2f} K that are material on the weeks that are fitted "
        "({gain:.3f} K)"
    )
    UNEXPLAINED = (
        "{gain:.2f} K of the error is {where}; no effect and no column explains it"
    )

    # a correction
    CORRECTED = "{fault}"
    ONE_CLOCK = "{fault}{evidence}"
    NOT_CORRECTED = "{fault}; not corrected: {remedy}"


class Names(tuple):
    """Names, joined by the format's own words."""

    def __format__(self, words: str) -> str:
        return (words or ", ").join(map(str, self))


class Chance(float):
    """A probability in percent, never rounded to none or all."""

    def __format__(self, digits: str) -> str:
        return super().__format__(digits) if digits else in_percent(self)


def in_percent(probability: float) -> str:
    """
    Write a probability, which is never 0 or 100 % of what is estimated.

    Parameters
    ----------
    probability : float
        From 0 to 1.

    Returns
    -------
    str
        Such as 97 %, and > 99 % or < 1 % at the ends.
    """
    percent = round(100.0 * probability)
    if percent == 100:
        return "> 99 %"
    return f"{percent} %" if percent else "< 1 %"


@dataclass(frozen=True)
class Because:
    """
    A reason and its numbers; ``str`` puts it into words.

    Attributes
    ----------
    reason : Reason
    values : dict
        The numbers and names of its sentence.
    also : tuple of Because
        Further reasons for the same.
    """

    reason: Reason
    values: Mapping = field(default_factory=dict)
    also: tuple = ()

    @property
    def all(self) -> tuple:
        """It and the further ones."""
        return (self, *(one for more in self.also for one in more.all))

    def content(self) -> list:
        """The reason for a file."""
        return [
            {"reason": one.reason.name, **one.values, "words": one.sentence()}
            for one in self.all
        ]

    @classmethod
    def stored(cls, contents: list) -> "Because":
        """Read a reason from :meth:`content`."""
        unknown = {None: float("nan"), "inf": float("inf"), "-inf": -float("inf")}
        reasons = []
        for one in contents:
            if one["reason"] not in Reason.__members__:
                raise ValueError(f"{one['reason']} is none of the reasons")
            values = {
                # a list of names has no other meaning
                key: value if isinstance(value, list) else unknown.get(value, value)
                for key, value in one.items()
                if key not in ("reason", "words")
            }
            reasons.append(because(Reason[one["reason"]], **values))
        reason = joined_reasons(reasons)
        str(reason)  # a value that its sentence cannot have is refused here
        return reason

    def __hash__(self) -> int:
        return hash(str(self))

    def sentence(self) -> str:
        """The reason as a sentence, with its values."""
        words = self.reason.value.format(**self.values)
        return re.sub(r"(?<=\d)%", " %", words)  # Python's format has no space

    def __str__(self) -> str:
        return "; ".join(one.sentence() for one in self.all)


def because(reason: Reason, /, **values: Any) -> Because:
    """
    A reason with the values of its sentence.

    Parameters
    ----------
    reason : Reason
    **values
        By the names in the sentence: numbers, texts, or lists of names, which become
        :class:`Names`.

    Returns
    -------
    Because
    """
    for name, value in values.items():
        if isinstance(value, (list, tuple)):
            values[name] = Names(value)
        elif name == "chance":
            values[name] = Chance(value)
    return Because(reason, values)


def joined_reasons(reasons: list) -> Because:
    """
    Join several reasons for one fact.

    Parameters
    ----------
    reasons : list of Because
        At least one.

    Returns
    -------
    Because
        The first; the others are in ``also``.
    """
    first, *others = reasons
    return Because(first.reason, first.values, (*first.also, *others))
