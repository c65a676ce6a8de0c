"""
Time profiles of faults: a step at a date, a trend, or a temporary change.

A fault of a sensor or a mounting is an effect of constant size (its *channel*) times a
time profile (its *course*). Each course is defined once and applies to every channel.
"""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
import pandas as pd

from pvlib_fem.effects._effect import Effect, Parameter, Terms

YEAR = 365.2425  # days


def number(date: str) -> float:
    """Days of a date since 1970-01-01."""
    try:
        return (pd.Timestamp(date) - pd.Timestamp(0)) / pd.Timedelta("1D")
    except (TypeError, ValueError) as error:
        words = f"{date!r} is no date; give one such as '2012-04-01'"
        raise ValueError(words) from error


def written(day: float) -> str:
    """The date of a number of days since 1970-01-01."""
    return f"{pd.Timestamp(0) + pd.Timedelta(days=int(day)):%Y-%m-%d}"


def step(at: str, between: Any = None) -> Callable:
    """From a date on. ``between`` is the interval of possible dates."""
    first = number(at)
    return lambda day: (day >= first).astype(float)


def episode(start: str, end: str, between: Any = None) -> Callable:
    """From a date until another date, which is the first day after it."""
    first, last = number(start), number(end)
    if not first < last:
        raise ValueError(f"start = {start!r} is not before end = {end!r}")
    return lambda day: ((day >= first) & (day < last)).astype(float)


def drift(since: str | None = None) -> Callable:
    """A linear increase, by 1 per year."""
    first = None if since is None else number(since)
    return lambda day: (day - (day[0] if first is None else first)) / YEAR


@dataclass(frozen=True)
class TimeProfile:
    """A time profile: its weight by day, and names of its coefficient."""

    name: str
    weight: Callable  # from dates to a function of the day
    size: str  # name of the coefficient
    unit: str = ""
    most: float = 1.0  # factor of the channel's bounds

    def name_of(self, channel: Effect) -> str:
        """The name of a channel's change with this profile."""
        return f"{channel.name}_{self.name}"

    def missing(self, dates: Mapping) -> list:
        """Names of required dates that are not given."""
        taken = inspect.signature(self.weight).parameters.values()
        return [p.name for p in taken if p.default is p.empty and p.name not in dates]


COURSES = (
    TimeProfile("step", step, "change"),
    TimeProfile("drift", drift, "per_year", "/year", 0.5),
    TimeProfile("episode", episode, "change"),
)


@dataclass(frozen=True, eq=False)
class ScaledTerms:
    """Terms of a channel, scaled by the weight of its course on each day."""

    channel: Effect
    course: TimeProfile
    dates: Mapping

    @property
    def __doc__(self) -> str | None:  # type: ignore[override]  # that of each channel
        return self.channel.terms.__doc__

    @property
    def __signature__(self) -> Any:
        """Signature of the channel's terms, with the day and the course's size."""
        own = inspect.signature(self.channel.terms).parameters.values()
        size = {next(iter(self.channel.parameters)): self.course.size}
        day = inspect.Parameter("day", inspect.Parameter.POSITIONAL_OR_KEYWORD)
        return inspect.Signature(
            [day, *(p.replace(name=size.get(p.name, p.name)) for p in own)]
        )

    def __call__(self, day: pd.Index, *drivers: np.ndarray, **given: float) -> Terms:
        if missing := self.course.missing(self.dates):
            name = self.course.name_of(self.channel)
            raise ValueError(
                f"{name} has no date; give {' and '.join(missing)}, as {{'name': "
                f"'{name}', '{missing[0]}': '2012-04-01'}}"
            )
        weight = self.course.weight(**self.dates)(np.asarray(day, dtype=float))
        given[next(iter(self.channel.parameters))] = given.pop(self.course.size)
        return Terms().plus(self.channel.terms(*drivers, **given), weight)


@dataclass(frozen=True, eq=False)
class DatedChange:
    """Function that makes the effect of a channel along a course with given dates."""

    channel: Effect
    course: TimeProfile

    @property
    def __signature__(self) -> Any:
        return inspect.signature(self.course.weight)

    def __call__(self, **dates: str) -> Effect:
        if not self.course.missing(dates):
            self.course.weight(**dates)  # refuses invalid dates
        return replace(
            self.undated(),
            terms=ScaledTerms(self.channel, self.course, dates),
            settings=dates,
            source=dates_in_words(dates),
            dates=None,
            scanned_from=None,
        )

    def undated(self) -> Effect:
        """The effect without dates, as in the registry; a search finds the dates."""
        channel, course = self.channel, self.course
        (row,), name = channel.parameters.values(), course.name_of(channel)
        bounds = row.lower * course.most, row.upper * course.most
        unit = f"{row.unit}{course.unit}".replace("-/", "1/")
        return replace(
            channel,
            name=name,
            terms=ScaledTerms(channel, course, {}),
            parameters={course.size: Parameter(row.start, *bounds, unit)},
            columns=("day", *channel.drivers),
            channel=channel.name,
            make=self,
            dates=self,
            scanned_from=replace(channel, name=name),
        )


def dates_in_words(dates: Mapping) -> str:
    """Dates of a change in words."""
    if "end" in dates:
        words = f"{dates['start']} until {dates['end']}"
    else:
        words = dates.get("at") or dates.get("since") or ""
    low, high = dates.get("between") or (None, None)
    return words + (f" ({low} to {high})" if low != high else "")


def scaled_terms(effect: Effect) -> ScaledTerms:
    """Terms of an effect that has a channel."""
    return cast(ScaledTerms, effect.terms)


def weights_of(effect: Effect, days: np.ndarray) -> np.ndarray:
    """Weight of each day, from 1970-01-01, of an effect along a course."""
    middle = np.asarray(days) + 0.5
    if effect.channel:
        terms = scaled_terms(effect)
        return terms.course.weight(**terms.dates)(middle)
    return episode(effect.settings["start"], effect.settings["end"])(middle)


def is_dated(effect: Effect) -> bool:
    """Whether an effect acts from a date on, or until one."""
    return bool(effect.channel) or "start" in effect.settings


def course_of(effect: Effect) -> str:
    """How a fault comes and goes: ``"step"``, ``"drift"``, ``"episode"`` or ``""``."""
    if effect.channel:
        return scaled_terms(effect).course.name
    return "episode" if is_dated(effect) else ""


def is_drift(effect: Effect) -> bool:
    """Whether an effect's time profile is a trend."""
    return course_of(effect) == "drift"


def interval(effect: Effect) -> tuple[float, ...] | None:
    """Days between which a change began; None for a trend over the whole record."""
    dates = effect.settings
    begin = dates.get("at") or dates.get("start")
    if begin is None:
        return None
    return tuple(number(day) for day in dates.get("between") or (begin, begin))


def along_all(channel: Effect) -> tuple[Effect, ...]:
    """The effects of a channel with every time profile."""
    return tuple(DatedChange(channel, course).undated() for course in COURSES)
