"""
How something comes and goes: from a date on, slowly, or for a while.

What happens to an instrument or a mounting is an effect of constant size (its
*channel*) along a course. A course is written once, and goes with every channel.
"""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from pvlib_fem.effects.effect import Effect, Parameter, Terms

YEAR = 365.2425  # days


def number(date):
    """Days of a date since 1970-01-01."""
    try:
        return (pd.Timestamp(date) - pd.Timestamp(0)) / pd.Timedelta("1D")
    except (TypeError, ValueError) as error:
        words = f"{date!r} is no date; give one such as '2012-04-01'"
        raise ValueError(words) from error


def written(day):
    """The date of a number of days since 1970-01-01."""
    return f"{pd.Timestamp(0) + pd.Timedelta(days=int(day)):%Y-%m-%d}"


def step(at, between=None):
    """From a date on. ``between`` two dates it may as well have begun."""
    first = number(at)
    return lambda day: (day >= first).astype(float)


def episode(start, end, between=None):
    """From a date until another, at which it is over."""
    first, last = number(start), number(end)
    if not first < last:
        raise ValueError(f"start = {start!r} is not before end = {end!r}")
    return lambda day: ((day >= first) & (day < last)).astype(float)


def drift(since=None):
    """Slowly, more by the same from year to year."""
    first = None if since is None else number(since)
    return lambda day: (day - (day[0] if first is None else first)) / YEAR


@dataclass(frozen=True)
class Course:
    """A way to come and go: its weight by day, and its words."""

    name: str
    weight: Callable  # its dates, to a function of the day
    size: str  # what a coefficient is called
    unit: str = ""
    most: float = 1.0  # share of the channel's bounds that are its own

    def name_of(self, channel):
        """The name of a channel's change along it."""
        return f"{channel.name}_{self.name}"

    def lacks(self, dates):
        """Dates that it needs and that are not given."""
        taken = inspect.signature(self.weight).parameters.values()
        return [p.name for p in taken if p.default is p.empty and p.name not in dates]


COURSES = (
    Course("step", step, "change"),
    Course("drift", drift, "per_year", "/year", 0.5),
    Course("episode", episode, "change"),
)


@dataclass(frozen=True, eq=False)
class Along:
    """Terms of a channel, by the weight that its course has on each day."""

    channel: Effect
    course: Course
    dates: Mapping

    @property
    def __doc__(self):
        return self.channel.terms.__doc__

    @property
    def __signature__(self):
        """That of the channel's own terms, with the day and the course's size."""
        own = inspect.signature(self.channel.terms).parameters.values()
        size = {next(iter(self.channel.parameters)): self.course.size}
        day = inspect.Parameter("day", inspect.Parameter.POSITIONAL_OR_KEYWORD)
        return inspect.Signature(
            [day, *(p.replace(name=size.get(p.name, p.name)) for p in own)]
        )

    def __call__(self, day, *drivers, **given):
        if missing := self.course.lacks(self.dates):
            name = self.course.name_of(self.channel)
            raise ValueError(
                f"{name} has no date; give {' and '.join(missing)}, as {{'name': "
                f"'{name}', '{missing[0]}': '2012-04-01'}}"
            )
        weight = self.course.weight(**self.dates)(np.asarray(day, dtype=float))
        given[next(iter(self.channel.parameters))] = given.pop(self.course.size)
        return Terms().plus(self.channel.terms(*drivers, **given), weight)


@dataclass(frozen=True, eq=False)
class Dated:
    """Makes the effect of a channel along a course of its dates."""

    channel: Effect
    course: Course

    @property
    def __signature__(self):
        return inspect.signature(self.course.weight)

    def __call__(self, **dates):
        if not self.course.lacks(dates):
            self.course.weight(**dates)  # refuses what is no date
        return replace(
            self.undated(),
            terms=Along(self.channel, self.course, dates),
            settings=dates,
            source=told(dates),
            dates=None,
            scanned_from=None,
        )

    def undated(self):
        """The effect as it stands in the registry: its dates are to be found."""
        channel, course = self.channel, self.course
        (row,), name = channel.parameters.values(), course.name_of(channel)
        bounds = row.lower * course.most, row.upper * course.most
        unit = f"{row.unit}{course.unit}".replace("-/", "1/")
        return replace(
            channel,
            name=name,
            terms=Along(channel, course, {}),
            parameters={course.size: Parameter(row.start, *bounds, unit)},
            columns=("day", *channel.drivers),
            channel=channel.name,
            make=self,
            dates=self,
            scanned_from=replace(channel, name=name),
        )


def told(dates):
    """Dates in words."""
    if "end" in dates:
        words = f"{dates['start']} until {dates['end']}"
    else:
        words = dates.get("at") or dates.get("since") or ""
    low, high = dates.get("between") or (None, None)
    return words + (f" ({low} to {high})" if low != high else "")


def weights_of(effect, days):
    """Weight of each day, from 1970-01-01, of an effect along a course."""
    return effect.terms.course.weight(**effect.terms.dates)(np.asarray(days) + 0.5)


def is_drift(effect):
    """Whether an effect's course is one that grows from year to year."""
    return effect.terms.course.name == "drift"


def interval(effect):
    """Days between which a change may have begun; None of what grows from the first."""
    dates = effect.settings
    begin = dates.get("at") or dates.get("start")
    if begin is None:
        return None
    return tuple(number(day) for day in dates.get("between") or (begin, begin))


def along_all(channel):
    """A channel along every course, as effects of the registry."""
    return tuple(Dated(channel, course).undated() for course in COURSES)
