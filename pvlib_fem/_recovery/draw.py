"""Draw the injections: effects, dates and signs."""

import inspect
import json
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from pvlib_fem._converter import AnyFloat
from pvlib_fem._findings import Finding
from pvlib_fem._loop.preparation.divided_record import Case
from pvlib_fem._loop.results.loop_result import Loop
from pvlib_fem._stored import as_json
from pvlib_fem.effects import EFFECTS, find, several
from pvlib_fem.effects._effect import Effect, Parameter
from pvlib_fem.effects._time_profiles import (
    date_text,
    dates_in_words,
    is_drift,
    time_profile_of,
    weights_of,
)
from pvlib_fem.reasons import Because, Reason, because

EDGE = 0.1  # share of the days at either end of the record in which no date is drawn
LONGEST = 0.25  # largest length of an episode, as a share of the days
SAME = 0.5  # share of common days above which two stretches are one event


@dataclass(frozen=True)
class Injection:
    """
    An effect of known size that is added to a record.

    Attributes
    ----------
    effect : str
    draw : int
        Number of the draw of dates and signs.
    settings : dict
        Its dates, or other settings of the effect.
    coefficients : dict
        Coefficients by their names in a model.
    size : float
        Root of the sum of their squares; for one coefficient its absolute value.
    predicted : float
        Size from which it should be found; NaN if no possible size should be.
    own : float
        Estimate of this effect, with this sign, in the record itself. It adds to the
        injected size in each coefficient that is found.
    """

    effect: str
    draw: int
    settings: dict
    coefficients: dict[str, float]
    size: float
    predicted: AnyFloat
    own: float

    @property
    def key(self) -> str:
        """A text that identifies the injection, exact to the bit."""
        return json.dumps(as_json([self.effect, self.settings, self.coefficients]))

    @property
    def multiple(self) -> float:
        """Size over predicted size, both of which are rounded; NaN without one."""
        return round(self.size / self.predicted, 4)

    @property
    def dates(self) -> str:
        """Its dates in words."""
        return dates_in_words(self.settings)


@dataclass(frozen=True, eq=False)
class Draw:
    """An effect with its dates, and the direction of its coefficients."""

    effect: Effect
    number: int
    way: dict = field(default_factory=dict)  # unit vector of the coefficients
    readable: float = np.inf  # largest size with which the instrument still reads
    #: of its coefficients, by the record: what a trend becomes is bounded, too
    bounds: Mapping[str, Parameter] = field(default_factory=dict)

    def of_size(self, size: float, predicted: float, own: float) -> Injection:
        """The injection of a size."""
        coefficients = {n: to_six_digits(size * part) for n, part in self.way.items()}
        numbers = map(to_six_digits, (size, predicted, own))
        settings = dict(self.effect.settings)
        return Injection(
            self.effect.name, self.number, settings, coefficients, *numbers
        )

    @property
    def most(self) -> float:
        """The largest size that its bounds and its instrument allow."""
        rows = self.bounds or self.effect.rows()
        ends = {n: rows[n].upper if part > 0 else rows[n].lower for n, part in self}
        return min(self.readable, *(ends[name] / part for name, part in self))

    def __iter__(self) -> Iterator:
        return ((name, part) for name, part in self.way.items() if part)


def to_six_digits(value: float) -> float:
    """Round to six digits: readable, and equal on every computer."""
    return float(f"{value:.6g}")


def injectable_effects(
    case: Case, loop: Loop, effects: list | str | None
) -> tuple[list[Effect], dict[str, str]]:
    """
    Effects that can be injected, and for other effects the reason why not.

    Parameters
    ----------
    case : Case
        The record, with the effects that its loop tests.
    loop : Loop
        Of the record itself.
    effects : str, Effect, sequence of these, or None
        Effects to inject; None for all of the catalogue.

    Returns
    -------
    injectable : list of Effect
        Without dates.
    notes : dict of str
        Effect to reason.
    """
    wanted = {effect.name: effect for effect in case.wanted}
    there = {name for f in loop.finding_objects if f.added for name in f.candidates}
    usual = {effect.name for effect in loop.fit.effects}
    if effects is None:
        names = [name for name in wanted if name in EFFECTS]
    else:
        names = [find(effect).name for effect in several(effects)]
    injectable: list[Effect] = []
    notes: dict[str, Because | str] = {}
    if effects is None:
        notes |= case.untestable
    for name in names:
        if name not in wanted:
            notes[name] = case.untestable.get(name, f"the loop does not try {name}")
        elif name in there:
            notes[name] = "the record itself shows it, or cannot tell it from what is"
        elif name in usual:
            notes[name] = "the model without findings has it"
        elif wanted[name].turns:
            notes[name] = "it has dates and a plane, which are not drawn"
        elif wanted[name].scan is None:
            injectable.append(wanted[name])
        elif needs_nothing(wanted[name].make):
            injectable.append(wanted[name].make())
        else:
            notes[name] = "it has a place in the sky, which is not drawn"
    return injectable, {name: str(why) for name, why in notes.items()}


def needs_nothing(make: Any) -> bool:
    """Whether all settings that a scan would find have defaults."""
    rows = inspect.signature(make).parameters.values()
    return all(row.default is not row.empty for row in rows)


def dated_draws(
    effect: Effect, days: np.ndarray, side: int, draws: int, seed: int
) -> tuple[list["Draw"], Because | None]:
    """
    Draws of an effect with dates but without directions, or why there is no date.

    Parameters
    ----------
    effect : Effect
        Without dates.
    days : numpy.ndarray of int, shape (days,)
        Days of the fitting weeks that have rows, from 1970-01-01.
    side : int
        Least number of days on either side of a date.
    draws, seed : int
        Number of draws, and seed of the random numbers.

    Returns
    -------
    list of Draw, Because or None
    """
    random = generator(effect, seed)
    if not effect.sensor_fault:
        return [Draw(effect, number) for number in range(draws)], None
    drawn = DATES[time_profile_of(effect)]
    dates = [drawn(days, side, random) for _ in range(draws)]
    if None in dates:
        return [], because(Reason.NO_DATE)
    return [Draw(effect.make(**one), number) for number, one in enumerate(dates)], None


def generator(effect: Effect, seed: int) -> np.random.Generator:
    """Random numbers of an effect, independent of the other effects."""
    return np.random.default_rng([seed, zlib.crc32(effect.name.encode())])


def drawn_step(days: np.ndarray, side: int, random: np.random.Generator) -> dict | None:
    """A date with enough days on either side."""
    edge = max(side, int(EDGE * len(days)))
    if len(days) <= 2 * edge:
        return None
    return {"at": date_text(days[random.integers(edge, len(days) - edge)])}


def drawn_episode(days: np.ndarray, side: int, random: np.random.Generator) -> Any:
    """A stretch whose length is uniform in its logarithm."""
    most = int(LONGEST * len(days))
    if most <= 2 * side:
        return None
    length = int(np.exp(random.uniform(np.log(2 * side), np.log(most))))
    start = random.integers(side, len(days) - side - length)
    return {"start": date_text(days[start]), "end": date_text(days[start + length])}


def drawn_drift(
    days: np.ndarray, side: int, random: np.random.Generator
) -> dict[str, str]:
    """A trend from the first day on."""
    return {"since": date_text(days[0])}


DATES = {"step": drawn_step, "episode": drawn_episode, "drift": drawn_drift}


def with_ways(draws: list, errors: list, seed: int) -> list:
    """
    The draws with random directions of their coefficients, without duplicates.

    Coefficients are random in units of their standard errors. A coefficient that cannot
    be negative is positive.

    Parameters
    ----------
    draws : list of Draw
        Without directions.
    errors : list of dict
        Standard error of each coefficient, for each draw.
    seed : int
        Of the random numbers.

    Returns
    -------
    list of Draw
        ``way`` is a unit vector of the coefficients in their own units.
    """
    directed, seen = [], set()
    for draw, error in zip(draws, errors):
        random = generator(draw.effect, seed + 1 + draw.number)
        rows = draw.effect.rows()
        signs = {n: -1.0 if random.random() < 0.5 else 1.0 for n in rows}
        if len(rows) > 1:
            signs = {name: random.standard_normal() for name in rows}
        for name, row in rows.items():
            if row.lower >= row.start or row.upper <= row.start:
                sign = 1.0 if row.upper > row.start else -1.0
                signs[name] = sign * abs(signs[name])
        way = {name: signs[name] * error[name] for name in rows}
        length = np.sqrt(sum(part**2 for part in way.values()))
        way = {name: float(part / length) for name, part in way.items()}
        key = (str(draw.effect.settings), *(way.items()))
        if key not in seen:
            seen.add(key)
            directed.append(replace(draw, way=way))
    return directed


def holds_truth(
    finding: Finding, effect: Effect, effects: dict, days: np.ndarray
) -> bool:
    """
    Whether a finding holds the true effect; a fault also on about its days.

    Parameters
    ----------
    finding : Finding
        With its candidates.
    effect : Effect
        The true effect, with its dates.
    effects : dict of Effect
        Effects of the fitted model by name, with their dates.
    days : numpy.ndarray of int, shape (days,)
        Days of the record since 1970-01-01.

    Returns
    -------
    bool
        Dates are compared if the finding's leading candidate has the same time profile.
    """
    if effect.name not in finding.candidates:
        return False
    leading = effects[finding.effect]
    if not (effect.sensor_fault and leading.sensor_fault):
        return True
    if time_profile_of(leading) != time_profile_of(effect):
        return True
    return same_days(effect, leading, days)


def same_days(one: Effect, other: Effect, days: np.ndarray) -> bool:
    """
    Whether two changes with one time profile are on mostly the same days.

    Parameters
    ----------
    one, other : Effect
        Sensor faults, with their dates.
    days : numpy.ndarray of int, shape (days,)
        Days of the record since 1970-01-01.

    Returns
    -------
    bool
        True if half of the days of either are days of both, and for trends always.
    """
    if is_drift(one):
        return True
    a, b = (weights_of(effect, days) > 0.0 for effect in (one, other))
    return bool((a & b).sum() >= SAME * (a | b).sum())
