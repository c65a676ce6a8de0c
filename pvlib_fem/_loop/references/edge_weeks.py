"""
Changes that begin or end in a test week, and standstills of which one has a part.

No decision sees the module temperature of those weeks. Power is seen: it falls by the
light that modules miss while they are stuck, and so shows at which days it begins and
ends. A test week becomes a fitting week if a standstill may begin or end in it and
there is no power, or if power shows one that hardly any other week has. The fitting
weeks and power alone decide that, so what stays of the test weeks is as unseen as
before. A change of a sensor whose date is sure to a few days, but for a test week in
which it is, makes that a fitting week as well: else days without the fault would be
corrected.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from pvlib_fem._loop.preparation.divided_record import Case
from pvlib_fem._loop.references.comparisons import GAMMA, bright
from pvlib_fem._statistics.clusters import calendar_weeks
from pvlib_fem.drivers import derive_drivers
from pvlib_fem.drivers._plant_irradiance import light_shown
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._standstill_days import SHORTEST
from pvlib_fem.effects._time_profiles import date_text, day_number
from pvlib_fem.power import fit_power_arrays

WARMS = 0.03  # K/(W/m²), of a module over the air: its power needs no more
AROUND = 30  # days before and after, that power is compared with
REACH = 10  # days: a test week, and dull days next to it
FEWEST = 8  # of those
MAD = 1.4826  # median absolute deviation of a normal quantity to its sd
LEAST = 0.03  # by which power for the light differs between dull and clear days [-]
FAR = 4.0  # standard deviations, from which power shows something else
SURE = 6.0  # twice the log-likelihood from which a day is said to be one
MOST = 0.5  # of the test days, that may become fitting days


def edge_weeks(case: Case, effects: Sequence[Effect], before: int) -> np.ndarray:
    """
    Test days of weeks that are needed for a change or a standstill.

    In these a change begins or ends; or a standstill may, unknown to power; or one that
    power shows has almost all of its days in them, and the model has none.

    Parameters
    ----------
    case : Case
    effects : sequence of Effect
        Of the fitted model.
    before : int
        Number of test days that became fitting days already.

    Returns
    -------
    array of int
        Days since 1970-01-01; none if they are more than half of the test days.
    """
    test = np.unique(case.whole.dates[case.held_out])
    needed = np.zeros(len(test), dtype=bool)
    found = [one for one in effects if one.turns]
    for effect in found:
        for name in ("between", "ended"):
            needed |= days_within(test, effect.settings.get(name, (0, 0)))
    needed &= np.isin(test, without_power(case))
    changes = [one for one in effects if one.sensor_fault]
    fitting = np.unique(case.record.dates[case.searched]) if changes else test[:0]
    for effect in changes:
        needed |= of_its_dates(effect, test, fitting)
    if not found:
        for dates in hidden_standstills(case):
            needed |= days_within(test, dates)
    weeks = calendar_weeks(test)
    days = test[np.isin(weeks, weeks[needed])]
    return days if len(days) + before <= MOST * (len(test) + before) else test[:0]


def days_within(days: np.ndarray, dates: tuple) -> np.ndarray:
    """Whether days are from the first date on, and before the last one."""
    first, last = map(day_number, dates)
    return (days >= first) & (days < last)


def of_its_dates(effect: Effect, test: np.ndarray, fitting: np.ndarray) -> np.ndarray:
    """
    Whether test days are those between which a change begins or ends.

    They are if they are more than the fitting days on which it may have begun.
    """
    settings = effect.settings
    needed = np.zeros(len(test), dtype=bool)
    if "between" not in settings:  # a trend of the whole record
        return needed
    unsure = days_within(fitting, settings["between"]).sum()
    for name in {"at", "start", "end"} & {*settings}:
        place = np.searchsorted(fitting, day_number(settings[name]))
        if 0 < place < len(fitting):
            unseen = (test > fitting[place - 1]) & (test < fitting[place])
            needed |= unseen & (unseen.sum() > unsure)
    return needed


def hidden_standstills(case: Case) -> Iterator[tuple[Any, Any]]:
    """
    Dates of standstills that power shows, and fewer than two fitting days.

    They are the first day and the first day after it, as texts.
    """
    fitting = np.unique(case.record.dates[case.searched & bright(case.record)])
    for effect in case.wanted:
        if effect.turns and effect.prepare:  # and has no given dates
            found = standstill_by_power(case, effect)
            dates = (found.settings["start"], found.settings["end"]) if found else ()
            if dates and days_within(fitting, dates).sum() < SHORTEST:
                yield dates


def standstill_by_power(case: Case, effect: Effect) -> Effect | None:
    """
    A standstill that a power shows, or None.

    The light by power minus that on the sensor is searched as the remaining error of
    the temperature is: what a cover explains as well is no standstill.
    """
    record = case.record
    light = bright(record)
    if not case.powers:
        return None
    try:
        inputs = derive_drivers(record.inputs, ["day"])
        ready = effect.prepare(inputs.columns, np.ones_like(light))
        inputs = derive_drivers(inputs, ready.scanned_from.drivers)
    except ValueError:  # the plane is fixed
        return None
    wide = ready.scanned_from
    light &= replace(record, inputs=inputs).complete_rows(wide.drivers)
    poa, day = inputs["poa_global"], inputs["day"]
    module = inputs["temp_air"] + WARMS * poa
    for name in case.powers:
        try:
            relation = fit_power_arrays(poa, module, inputs[name], day)
        except ValueError:  # there is hardly any power
            continue
        by_power = light_shown(relation, poa, module, inputs[name], day)
        known = light & np.isfinite(by_power)
        columns = {key: inputs[key][known] for key in wide.drivers}
        tangents = {
            key: wide.at(columns, {**wide.start, key: 1.0}).heat for key in wide.rows()
        }
        tangents["poa_global"] = poa[known]
        weeks = calendar_weeks(record.dates[known])
        least = relation.spread * np.sqrt(np.mean(poa[known] ** 2))
        rest = (by_power - poa)[known]
        if (found := ready.scan(rest, tangents, columns, weeks, least)) is not None:
            return found
    return None


def without_power(case: Case) -> np.ndarray:
    """Days with light, and without a value of power in it."""
    record = case.record
    light = bright(record)
    shown = np.zeros_like(light)
    for name in case.powers:
        shown |= np.isfinite(record[name])
    return np.setdiff1d(record.dates[light], record.dates[light & shown])


def by_power(case: Case, effect: Effect, size: float) -> Effect:
    """
    A standstill with the days of test weeks at its edges on which power shows it.

    Parameters
    ----------
    case : Case
    effect : Effect
        With the first and the last day that the fitting weeks show.
    size : float
        Its fitted coefficient.

    Returns
    -------
    Effect
    """
    settings = dict(effect.settings)
    start, end = (int(day_number(settings[name])) for name in ("start", "end"))
    before = max(start - REACH, int(case.record.dates[0]))
    after = min(end + REACH, int(case.record.dates[-1]) + 1)
    wide = settings | {"start": date_text(before), "end": date_text(after)}
    gains = daily_gains(case, effect.make(**wide), size, (before, after))
    days_before, days_after = range(start - 1, before - 1, -1), range(end, after)
    first = start - likeliest_length([gains.get(day, 0.0) for day in days_before])
    last = end + likeliest_length([gains.get(day, 0.0) for day in days_after])
    if (first, last) == (start, end):
        return effect
    return effect.make(**settings | {"start": date_text(first), "end": date_text(last)})


def likeliest_length(gains: list[float]) -> int:
    """The number of days from an edge on that are most likely, if that is sure."""
    sums = np.cumsum([0.0, *gains])
    return int(np.argmax(sums)) if sums.max() > SURE else 0


def daily_gains(
    case: Case, effect: Effect, size: float, within: tuple[int, int]
) -> dict[int, float]:
    """
    Twice the log-likelihood of each day, by power, that the modules stand on it.

    The effect is a standstill of the fitted size over all days that may be of it.
    ``within`` has the first of these days, and the first after them, from 1970-01-01.
    """
    record = case.record
    total: dict[int, float] = {}
    columns = derive_drivers(record.inputs, effect.drivers).columns
    heat = np.nan_to_num(effect.at(columns, dict.fromkeys(effect.rows(), size)).heat)
    poa = record["poa_global"]
    warm = 1.0 + GAMMA * (record["temp_air"] + WARMS * poa - 25.0)
    for name in case.powers:
        kept = bright(record) & np.isfinite(record[name] + warm)
        every, place = np.unique(record.dates[kept], return_inverse=True)
        power, light, more = (
            np.bincount(place, column[kept])
            for column in (record[name], warm * poa, heat)
        )
        plain = np.bincount(place, poa[kept])
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.log(power / light)
        expected = np.log1p(np.maximum(more / plain, -0.99))
        there = np.isfinite(ratio)
        near = (every >= within[0] - AROUND) & (every < within[1] + AROUND)
        other = near & there & ((every < within[0]) | (every >= within[1]))
        if other.sum() < FEWEST:
            continue
        usual = np.median(ratio[other])
        spread = max(MAD * np.median(np.abs(ratio[other] - usual)), LEAST)
        apart, needed = (ratio - usual) / spread, expected / spread
        # a day that is far from both, as one of an outage, shows neither
        usually, stuck = (np.minimum(a**2, FAR**2) for a in (apart, apart - needed))
        gains = usually - stuck
        for day, gain in zip(every[there].tolist(), gains[there].tolist()):
            total[day] = total.get(day, 0.0) + gain
    return total
