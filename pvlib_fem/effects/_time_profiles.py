"""
Time profiles of faults: a step at a date, a trend, or a temporary change.

A fault of a sensor or a mounting is an effect of constant size times a time profile.
Each time profile is defined once and applies to every fault.
"""

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, cast

import numpy as np
import pandas as pd

from pvlib_fem.drivers import own_columns
from pvlib_fem.effects._effect import Effect, Parameter, Terms

YEAR = 365.2425  # days
SEASON = 0.25  # years, in which a trend that began may reach the bounds of its fault


def day_number(date: str) -> float:
    """
    Days of a date since 1970-01-01.

    Parameters
    ----------
    date : str
        A date, perhaps with a time, without a zone.

    Returns
    -------
    float

    Raises
    ------
    ValueError
        If it is no date.
    """
    try:
        return parsed_day(date)
    except (TypeError, ValueError) as error:
        words = f"{date!r} is no date; give one such as '2012-04-01'"
        raise ValueError(words) from error


@lru_cache(maxsize=4096, typed=True)  # a search asks for the same dates again and again
def parsed_day(date: str) -> float:
    """Days of a date since 1970-01-01, or an error."""
    days = (pd.Timestamp(date) - pd.Timestamp(0)) / pd.Timedelta("1D")
    if pd.isna(days):  # of "NaT", or an empty text
        raise ValueError("no date")
    return float(days)


def date_text(day: float) -> str:
    """
    The date of a number of days since 1970-01-01.

    Parameters
    ----------
    day : float
        A fraction is dropped.

    Returns
    -------
    str
        ``YYYY-MM-DD``
    """
    return str(np.datetime64(int(day), "D"))


def step(at: str, between: Any = None) -> Callable:
    """From a date on. ``between`` is the interval of possible dates."""
    first = day_number(at)
    return lambda day: (day >= first).astype(float)


def episode(start: str, end: str, between: Any = None) -> Callable:
    """From a date until another date, which is the first day after it."""
    first, last = day_number(start), day_number(end)
    if not first < last:
        raise ValueError(f"start = {start!r} is not before end = {end!r}")
    return lambda day: ((day >= first) & (day < last)).astype(float)


def drift(
    since: str | None = None,
    start: str | None = None,
    end: str | None = None,
    resets: Sequence[str] = (),
    between: Any = None,
) -> Callable:
    """
    A linear increase by 1 per year, which is 0 at ``since``, or on the first day.

    With ``start`` it begins there, and there is none of it before. At each of
    ``resets`` it begins again from 0, as of a sensor that is cleaned; one before the
    first day says since when it has increased there. ``end`` is the first day after it,
    as of a sensor that is replaced. ``between`` is the interval of possible dates of
    the start.
    """
    if since is not None and start is not None:
        raise ValueError(
            f"since = {since!r} and start = {start!r}: give start if the trend begins "
            "there, or since if it is 0 there and goes on before"
        )
    zero = start if start is not None else since
    first = None if zero is None else day_number(zero)
    last = np.inf if end is None else day_number(end)
    if first is not None and not first < last:
        name = "since" if start is None else "start"
        raise ValueError(f"{name} = {zero!r} is not before end = {end!r}")
    if isinstance(resets, str):
        raise ValueError(f"resets = {resets!r} is one date; give a list of dates")
    again = np.sort([day_number(date) for date in resets])
    if start is not None and len(again) and not again[0] > day_number(start):
        raise ValueError(
            f"the first of resets = {resets!r} is not after start = {start!r}"
        )
    if len(again) and not again[-1] < last:
        raise ValueError(f"the last of resets = {resets!r} is not before end = {end!r}")

    def weight(day: np.ndarray) -> np.ndarray:
        zeros = np.append(day[0] if first is None else first, again)
        years = (day - zeros[np.searchsorted(again, day, side="right")]) / YEAR
        if start is not None:
            years = np.maximum(years, 0.0)
        return np.where(day < last, years, 0.0)

    return weight


def zeros_of(dates: Mapping) -> list[str]:
    """
    Dates on which a trend begins, and begins again from 0.

    A reset before the date on which it would be 0 takes its place.
    """
    resets = sorted(dates.get("resets", ()), key=day_number)
    begin = dates.get("start") or dates.get("since")
    if begin and not (resets and day_number(resets[0]) <= day_number(begin)):
        return [begin, *resets]
    return resets


def years_of_increase(dates: Mapping) -> float | None:
    """
    Most years in which a trend increases until it begins again, or ends.

    Parameters
    ----------
    dates : mapping
        Of a trend.

    Returns
    -------
    float or None
        None for a trend that does neither.
    """
    ends = [dates["end"]] if "end" in dates else []
    days = [day_number(date) for date in (*zeros_of(dates), *ends)]
    return float(np.diff(days).max()) / YEAR if len(days) > 1 else None


@dataclass(frozen=True)
class TimeProfile:
    """A time profile: its weight by day, and names of its coefficient."""

    name: str
    weight: Callable  # from dates to a function of the day
    size: str  # name of the coefficient
    unit: str = ""
    years: float = 0.0  # in which a trend may reach the fault's bounds

    def name_of(self, sensor_fault: Effect) -> str:
        """The name of a sensor fault with this time profile."""
        return f"{sensor_fault.name}_{self.name}"

    @cached_property
    def required(self) -> tuple[str, ...]:
        """Names of the dates that it has to have."""
        taken = inspect.signature(self.weight).parameters.values()
        return tuple(p.name for p in taken if p.default is p.empty)

    def missing(self, dates: Mapping) -> list:
        """Names of required dates that are not given."""
        return [name for name in self.required if name not in dates]

    def share_of_bounds(self, dates: Mapping) -> float:
        """The fault's bounds times this are those of the size. [-] or [1/year]"""
        if not self.years:
            return 1.0
        years = years_of_increase(dates)
        if years is None:
            return 1.0 / (SEASON if "start" in dates else self.years)
        return 1.0 / min(self.years, years)


TIME_PROFILES = (
    TimeProfile("step", step, "change"),
    TimeProfile("drift", drift, "per_year", "/year", years=2.0),
    TimeProfile("episode", episode, "change"),
)


@dataclass(frozen=True, eq=False)
class ScaledTerms:
    """Terms of a sensor fault, scaled by the weight of its time profile on each day."""

    sensor_fault: Effect
    time_profile: TimeProfile
    dates: Mapping

    @property
    def __doc__(self) -> str | None:  # type: ignore[override]  # that of each sensor fault
        return self.sensor_fault.terms.__doc__

    @property
    def __signature__(self) -> Any:
        """Signature of the fault's terms, with the day and the size."""
        own = inspect.signature(self.sensor_fault.terms).parameters.values()
        size = {next(iter(self.sensor_fault.parameters)): self.time_profile.size}
        day = inspect.Parameter("day", inspect.Parameter.POSITIONAL_OR_KEYWORD)
        return inspect.Signature(
            [day, *(p.replace(name=size.get(p.name, p.name)) for p in own)]
        )

    def __call__(self, day: pd.Index, *drivers: np.ndarray, **given: float) -> Terms:
        if missing := self.time_profile.missing(self.dates):
            name = self.time_profile.name_of(self.sensor_fault)
            raise ValueError(
                f"{name} has no date; give {' and '.join(missing)}, as {{'name': "
                f"'{name}', '{missing[0]}': '2012-04-01'}}"
            )
        weight = self.time_profile.weight(**self.dates)(np.asarray(day, dtype=float))
        given[next(iter(self.sensor_fault.parameters))] = given.pop(
            self.time_profile.size
        )
        return Terms().plus(self.sensor_fault.terms(*drivers, **given), weight)


@dataclass(frozen=True, eq=False)
class DatedChange:
    """Function that makes the effect of a fault, with a time profile and its dates."""

    sensor_fault: Effect
    time_profile: TimeProfile

    @property
    def __signature__(self) -> Any:
        return inspect.signature(self.time_profile.weight)

    def __call__(self, **dates: Any) -> Effect:
        dates = {n: tuple(v) if isinstance(v, list) else v for n, v in dates.items()}
        if not self.time_profile.missing(dates):
            self.time_profile.weight(**dates)  # refuses invalid dates
        return replace(
            self.with_bounds(dates),
            settings=dates,
            source=dates_in_words(dates),
            dates=None,
            scanned_from=None,
        )

    def without_dates(self) -> Effect:
        """The effect without dates, as in the registry; a search finds the dates."""
        return self.with_bounds({})

    def with_bounds(self, dates: Mapping) -> Effect:
        """The effect with the bounds that its size has with some dates."""
        sensor_fault, time_profile = self.sensor_fault, self.time_profile
        (row,), name = (
            sensor_fault.parameters.values(),
            time_profile.name_of(sensor_fault),
        )
        share = time_profile.share_of_bounds(dates)
        bounds = row.lower * share, row.upper * share
        unit = f"{row.unit}{time_profile.unit}".replace("-/", "1/")
        return replace(
            sensor_fault,
            name=name,
            terms=ScaledTerms(sensor_fault, time_profile, dates),
            parameters={time_profile.size: Parameter(row.start, *bounds, unit)},
            columns=("day", *sensor_fault.drivers),
            sensor_fault=sensor_fault.name,
            make=self,
            dates=self,
            scanned_from=replace(sensor_fault, name=name),
        )


def dates_in_words(dates: Mapping) -> str:
    """
    Dates of a change in words.

    Parameters
    ----------
    dates : mapping of str
        ``at`` or ``since``, or ``start`` and ``end``; perhaps ``resets``, and
        ``between`` and ``ended``, pairs of dates of the first and the end.

    Returns
    -------
    str
        The first day, the days between which it is in brackets, those on which a trend
        begins again, and the last day, likewise; "" without a date.
    """
    begin, *resets = [dates["at"]] if "at" in dates else zeros_of(dates) or [""]
    words = begin + or_between(dates.get("between"))
    if resets:
        words += f", again from zero on {in_a_row(resets)}"
        words += "," if "end" in dates else ""
    if "end" not in dates:
        return words
    last = [last_day(day) for day in dates.get("ended") or ()]
    return f"{words} until {last_day(dates['end'])}{or_between(last)}"


def or_between(days: Sequence[str] | None) -> str:
    """The days between which a date is, in brackets; "" where it is sure."""
    low, high = days or (None, None)
    return f" ({low} to {high})" if low != high else ""


def in_a_row(dates: Sequence[str]) -> str:
    """Dates in words, the last after "and"."""
    *others, last = dates
    return f"{', '.join(others)} and {last}" if others else last


def last_day(end: str) -> str:
    """The day before an end, which is the first day or moment after a change."""
    return date_text(np.ceil(day_number(end)) - 1)


def scaled_terms(effect: Effect) -> ScaledTerms:
    """
    Terms of an effect that is a sensor fault with a time profile.

    Parameters
    ----------
    effect : Effect
        Its ``sensor_fault`` is not "".

    Returns
    -------
    ScaledTerms
    """
    return cast(ScaledTerms, effect.terms)


def rows_reaching(effect: Effect, most: float) -> dict[str, Parameter]:
    """
    Rows of a change whose largest weight in a record is so much.

    Parameters
    ----------
    effect : Effect
        Its ``sensor_fault`` is not "".
    most : float
        Largest weight. [-], of a trend [years]

    Returns
    -------
    dict of Parameter
        Of its coefficient: what it becomes has the bounds of the fault.
    """
    scaled, ((name, row),) = scaled_terms(effect), effect.rows().items()
    (own,) = scaled.sensor_fault.parameters.values()
    share = scaled.time_profile.share_of_bounds(scaled.dates)
    times = min(share, 1.0 / most) if most > 0.0 else share
    return {name: replace(row, lower=own.lower * times, upper=own.upper * times)}


def weights_of(effect: Effect, days: np.ndarray) -> np.ndarray:
    """
    Weight of each day in the time profile of a dated effect.

    Parameters
    ----------
    effect : Effect
        See :func:`is_dated`.
    days : array of int, shape (days,)
        Since 1970-01-01.

    Returns
    -------
    array of float, shape (days,)
        1 or 0 for a step or a temporary change; for a trend, years since its begin,
        which by default is the first of the days, and 0 after its end.
    """
    middle = np.asarray(days) + 0.5
    if effect.sensor_fault:
        terms = scaled_terms(effect)
        return terms.time_profile.weight(**terms.dates)(middle)
    return episode(effect.settings["start"], effect.settings["end"])(middle)


def is_dated(effect: Effect) -> bool:
    """
    Whether an effect acts from a date on, or until one.

    Parameters
    ----------
    effect : Effect

    Returns
    -------
    bool
    """
    return bool(effect.sensor_fault) or "start" in effect.settings


def follows_sun_alone(effect: Effect) -> bool:
    """
    Whether an effect has neither dates nor a measured driver of its own.

    Parameters
    ----------
    effect : Effect

    Returns
    -------
    bool
    """
    own = effect.column or effect.confounder or own_columns(effect.drivers)
    return not own and not is_dated(effect)


def is_compared(effect: Effect) -> bool:
    """
    Whether references can deviate along the days of an effect.

    Parameters
    ----------
    effect : Effect

    Returns
    -------
    bool
        True if it has dates, and if it loses light day by day, as dirt does.
    """
    return is_dated(effect) or effect.loses_light


def time_profile_of(effect: Effect) -> str:
    """
    Name of the time profile of an effect.

    Parameters
    ----------
    effect : Effect

    Returns
    -------
    str
        ``"step"``, ``"drift"``, ``"episode"``, or "" for an effect without dates.
    """
    if effect.sensor_fault:
        return scaled_terms(effect).time_profile.name
    return "episode" if is_dated(effect) else ""


def is_drift(effect: Effect) -> bool:
    """
    Whether an effect's time profile is a trend.

    Parameters
    ----------
    effect : Effect

    Returns
    -------
    bool
    """
    return time_profile_of(effect) == "drift"


def years_to_end(effect: Effect) -> float | None:
    """
    Years in which a trend grows, if it has an end.

    Parameters
    ----------
    effect : Effect

    Returns
    -------
    float or None
        None for other effects, and for a trend that goes on.
    """
    return years_of_increase(effect.settings) if is_drift(effect) else None


def along_all(sensor_fault: Effect) -> tuple[Effect, ...]:
    """
    The effects of a sensor fault with every time profile.

    Parameters
    ----------
    sensor_fault : Effect
        Of constant size, with one parameter.

    Returns
    -------
    tuple of Effect
        Without dates.
    """
    return tuple(
        DatedChange(sensor_fault, time_profile).without_dates()
        for time_profile in TIME_PROFILES
    )
