"""What other columns say of an instrument that has changed."""

from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pvlib
import pytest
import study_instruments
from pvlib.location import Location
from scipy.signal import lfilter
from test_instruments import DATES, closed, dated, half_a_year, with_change  # noqa: F401
from test_selection import START, clock, offsets

from pvlib_fem import close_loop, simulator
from pvlib_fem._findings import CheckOutcome, Finding, Verdict
from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._loop.references.comparisons import COMPARISONS, SKY, USUAL_WIND
from pvlib_fem._loop.references.cross_checks import (
    cross_checked,
    log_likelihoods,
    log_likelihoods_of_sizes,
    outcome_of,
)
from pvlib_fem._loop.references.deviations import (
    DailyDeviation,
    daily_deviations,
    usual_days,
)
from pvlib_fem._loop.references.joint_dates import date_costs, weighed_by_references
from pvlib_fem._loop.references.reference_faults import given_others
from pvlib_fem._loop.references.shown_changes import (
    shown_by,
    with_best_odds,
    with_own,
)
from pvlib_fem._loop.selection.choice import Choice, Sized
from pvlib_fem._loop.selection.dictionary import OF_A_PART, Candidate
from pvlib_fem._loop.selection.rivals import weighed
from pvlib_fem._record.column_names import COLUMNS, is_cross_check, is_power, twin_of
from pvlib_fem._stored import Stored, as_json
from pvlib_fem.effects import CHANGES, EFFECTS
from pvlib_fem.effects._time_profiles import weights_of


def with_power(data, step, **more):
    """The record with power and second sensors, which know of no change."""
    random = np.random.default_rng(5)
    share = 1.0 + random.normal(0.0, 0.02, len(data))
    warm = data["temp_module"] - 25.0
    power = 5000.0 * data["poa_global"] / 1000.0 * (1.0 - 0.004 * warm) * share
    return data.assign(power_ac=power, **more)


def after(data):
    return (data.index >= "2023-09-15").astype(float)


def test_power_names_the_irradiance_sensor_or_the_light(half_a_year):  # noqa: F811
    """It reads a tenth less from a date on, or the modules get a tenth more light."""
    data, _ = with_change(half_a_year)
    data = with_power(data, 0.1)
    data["poa_global"] /= 1.0 + 0.1 * after(data)
    first = closed(data).finding_objects[0]
    assert first.candidates == ("irradiance_sensor_step", "module_irradiance_step")
    assert first.verdict is Verdict.AMBIGUOUS
    one, other = (first.probabilities[name] for name in first.candidates)
    # of more light on the modules the temperature tells the size with a larger error
    assert one > other > 0.3
    (check,) = (one for one in first.cross_checks if one.effect == first.effect)
    assert check.column == "power_ac" and check.outcome is CheckOutcome.AGREES
    assert check.size == pytest.approx(np.log(1.1), abs=3 * check.stderr + 0.005)
    assert "power_ac and the sensor differ" in first.why


def test_two_columns_of_power_are_evidence_once(half_a_year):  # noqa: F811
    """Power before and after the inverters is that of the same modules."""
    data, _ = with_change(half_a_year)
    data = with_power(data, 0.1)
    data["poa_global"] /= 1.0 + 0.1 * after(data)
    one, two = (
        closed(frame).finding_objects[0]
        for frame in (data, data.assign(power_dc=1.05 * data["power_ac"]))
    )
    assert one.candidates == two.candidates
    assert two.probabilities == pytest.approx(one.probabilities, abs=1e-6)
    assert two.coefficients == pytest.approx(one.coefficients, rel=1e-6)
    assert two.stderr == pytest.approx(one.stderr, rel=1e-6)
    columns = {check.column for check in two.cross_checks}
    assert columns >= {"power_ac", "power_dc"}


def test_a_threshold_decides_only_whether_a_finding_is_in_the_model(half_a_year):  # noqa: F811
    """What it keeps out is one hint, with the causes and checks of the finding."""
    data, _ = with_change(half_a_year)
    data = with_power(data, 0.1)
    data["poa_global"] /= 1.0 + 0.1 * after(data)
    found = closed(data).finding_objects[0]
    strict = closed(data, min_rmse_reduction=1.5 * found.gain)
    (hint,) = (f for f in strict.finding_objects if {*f.candidates} & {*CHANGES})
    assert hint.verdict is Verdict.HINT and hint.because.reason.name == "NOT_MATERIAL"
    assert hint.candidates == found.candidates
    (agrees,) = (c for c in hint.cross_checks if c.effect == found.effect)
    assert agrees.column == "power_ac" and agrees.outcome is CheckOutcome.AGREES
    assert "power_ac and the sensor differ" in hint.why
    (row,) = (r for r in strict.statements.itertuples() if r.cause == hint.effect)
    assert "power_ac" in row.certainty and row.verdict == "hint"


def test_a_second_sensor_names_the_light_on_the_modules(half_a_year):  # noqa: F811
    """Modules are washed, and no reading changes."""
    data, _ = with_change(half_a_year, "module_irradiance_step")
    random = np.random.default_rng(2).normal(0.0, 0.01, len(data))
    data = with_power(data, 0.1).assign(
        poa_global_2=data["poa_global"] * (1.0 + random)
    )
    data["power_ac"] *= 1.0 + 0.1 * after(data)
    loop = closed(data)
    first = loop.finding_objects[0]
    assert first.effect == "module_irradiance_step"
    assert first.verdict is Verdict.IDENTIFIED
    outcomes = {(one.column, one.effect): one.outcome for one in first.cross_checks}
    assert outcomes["power_ac", first.effect] is CheckOutcome.AGREES
    (check,) = (one for one in first.cross_checks if one.effect == first.effect)
    assert check.reads.endswith("% more")  # light on the modules, not the reading
    low, high = first.ranges["module_irradiance_step.change"]
    assert low <= 0.1 <= high
    assert "the modules receive" in loop.statements["text"].iloc[0]
    assert loop.corrected(data).data["poa_global"].equals(data["poa_global"])


def test_a_second_sensor_has_a_part_in_the_size(half_a_year):  # noqa: F811
    """A better contact hides a third of the change from the temperature."""
    contact = {"module_sensor_contact_step": 0.03}
    data, _ = with_change(half_a_year, *contact, **contact)
    random = np.random.default_rng(2).normal(0.0, 0.01, len(data))
    data["poa_global_2"] = data["poa_global"] * (1.0 + random)
    data["poa_global"] /= 1.0 - 0.1 * after(data)
    loop = closed(data)
    first = loop.finding_objects[0]
    assert first.effect == "irradiance_sensor_step"
    key = "irradiance_sensor_step.change"
    (check,) = (one for one in first.cross_checks if one.effect == first.effect)
    assert check.outcome is CheckOutcome.AGREES
    by_temperature = np.expm1(check.expected)
    assert by_temperature > -0.085
    assert first.coefficients[key] == pytest.approx(-0.1, abs=0.002)
    assert first.stderr[key] < 0.002
    low, high = first.ranges[key]
    assert low < -0.1 < high
    # the rest of the model is fitted given it, and the record corrected by it
    assert loop.fit.fixed == {key: first.coefficients[key]}
    (note,) = (one for one in loop.fit.notes if "held" in one and key in one)
    assert "poa_global_2" in note
    corrected = loop.corrected(data, resolve=first.effect).data["poa_global"]
    clean = data["poa_global"] * (1.0 + first.coefficients[key] * after(data))
    pd.testing.assert_series_equal(corrected, clean, check_names=False)


def test_a_copy_of_a_sensor_is_no_surer_than_a_thousandth(half_a_year):  # noqa: F811
    """Its deviation has no noise at all."""
    data, _ = with_change(half_a_year)
    data["temp_air_2"] = data["temp_air"].round(1)
    data["temp_air"] = data["temp_air_2"] + 2.0 * after(data)
    first = closed(data).finding_objects[0]
    assert first.effect == "air_offset_step"
    (value,), (error,) = first.coefficients.values(), first.stderr.values()
    assert value == pytest.approx(-2.0, abs=1e-3)
    assert error == pytest.approx(2e-3, rel=0.1)


def season_or_drift(
    other, taken=(), light=lambda effect: np.zeros(365), size=0.12, z_score=10.0
):
    """
    What power says of a sensor that fades, and of an effect without a date.

    By power it fades by 0.12 a year, and by the fit by a size with its error.
    """
    days = np.arange(19000, 19365)
    noise = np.random.default_rng(3).normal(0.0, 0.02, len(days))
    apart = np.log1p(0.12 * (days - days[0]) / 365.25) + noise
    (power,) = (one for one in COMPARISONS if one.ages)
    reference = DailyDeviation(power, "power_dc", days, apart, light)
    other, drift = EFFECTS[other], EFFECTS["irradiance_sensor_drift"]
    members = {one.name: Candidate(one, (1,), 0.0) for one in (other, drift)}
    choice = Choice(
        members[other.name],
        SimpleNamespace(),
        members,
        {
            name: SimpleNamespace(
                estimate=np.array([size]), stderr=np.array([abs(size) / z_score])
            )
            for name in members
        },
        {other.name: 0.9, drift.name: 0.1},
        taken=frozenset(taken),
    )
    logs = log_likelihoods([reference], choice, {})
    return logs[drift.name] - logs[other.name]


def test_power_decides_between_a_season_and_a_sensor_that_fades():
    """Whichever explains more of the temperature, unless the sensor is explained."""
    assert season_or_drift("season") > 2.5
    assert season_or_drift("season", ["irradiance_sensor_drift"]) == 0.0


def test_power_decides_also_for_a_size_that_the_fit_hardly_knows():
    """Power shows half as much again, which is no error of a size that is uncertain."""
    sure, unsure = (
        season_or_drift("season", size=0.06, z_score=z) for z in (50.0, 2.5)
    )
    assert sure < 1.0 and unsure > sure + 1.0


def test_a_second_sensor_is_compared_along_a_fault_that_it_would_show():
    """Of a sensor that steps, where the temperature looks like less wind for a time."""
    days = np.arange(19000, 19365)
    noise = np.random.default_rng(3).normal(0.0, 0.01, len(days))
    steps = np.log1p(0.1) * (days >= 19200) + noise
    second = next(one for one in COMPARISONS if "irradiance_sensor" in one.shows)
    reference = DailyDeviation(second, "poa_global_2", days, steps, None)
    date, end = (str(np.datetime64(day, "D")) for day in (19200, 19300))
    wind = CHANGES["anemometer_episode"].make(start=date, end=end)
    sensor = CHANGES["irradiance_sensor_step"].make(at=date)
    weights = {wind.name: 0.9, sensor.name: 0.1}
    size, stderr = np.array([0.08]), np.array([0.02])
    score = SimpleNamespace(estimate=size, stderr=stderr)
    members = {one.name: Candidate(one, (1,), 0.0) for one in (wind, sensor)}
    scores = dict.fromkeys(members, score)
    choice = Choice(members[wind.name], score, members, scores, weights)
    logs = log_likelihoods([reference], choice, {})
    assert logs[sensor.name] - logs[wind.name] > 2.5


def deviation_of(column, apart):
    """A reference that deviates from day to day by so much."""
    days = 19000 + np.arange(len(apart))
    comparison = next(one for one in COMPARISONS if one.serves(column))
    return DailyDeviation(comparison, column, days, apart, lambda effect: days)


@pytest.mark.parametrize("off", [-6, -1, 0, 4, 30])
def test_a_sharp_reference_refuses_no_change_for_a_date_some_days_off(off):
    """A step of ten times the noise; a month is no error of a date."""
    days = 19000 + np.arange(400)
    light = next(one for one in COMPARISONS if one.serves("poa_global_2"))
    noise = noise_of(4, days, 0.01)

    def squares(apart, profile, **dates):
        reference = DailyDeviation(light, "poa_global_2", days, apart, None)
        dates = {n: str(np.datetime64(19000 + d, "D")) for n, d in dates.items()}
        effect = CHANGES[f"irradiance_sensor_{profile}"].make(**dates)
        whole = reference.along(weights_of(effect, days))[2]
        return float(whole @ whole), float(np.square(reference.beside(effect)).sum())

    step = noise - 0.1 * (days >= 19200)
    best, _ = squares(step, "step", at=200)
    whole, rest = squares(step, "step", at=200 + off)
    if abs(off) <= 7:
        assert rest == pytest.approx(best, rel=0.01)
        assert not off or whole > 1.1 * rest
    else:
        assert rest > 2.0 * best
    # each of the two dates of a temporary change has an error of its own
    episode = noise - 0.1 * ((days >= 19200) & (days < 19260))
    best, _ = squares(episode, "episode", start=200, end=260)
    _, rest = squares(episode, "episode", start=200 + off, end=260 - off // 2)
    if abs(off) <= 7:
        assert rest == pytest.approx(best, rel=0.01)
    else:
        assert rest > 1.5 * best


@pytest.mark.parametrize(
    ("column", "fault", "noise"),
    [
        ("poa_global_2", "irradiance_sensor", 0.01),
        ("wind_speed_2", "anemometer", 0.05),
        ("temp_air_2", "air_offset", 0.2),
        ("temp_module_2", "module_sensor_contact", 0.02),
    ],
)
def test_a_second_sensor_shows_a_change_on_its_day(column, fault, noise):
    """A step of four times the noise of a day; noise and a season show none."""
    at, off = int(np.random.default_rng(7).integers(100, 300)), []
    for seed in range(10):
        days = np.arange(400)
        apart = lfilter([np.sqrt(0.75)], [1.0, -0.5], noise_of(seed, days, noise))
        assert shown_changes([deviation_of(column, apart)]) == {}
        season = apart + 5.0 * noise * np.cos(2.0 * np.pi * days / 365.25)
        assert shown_changes([deviation_of(column, season[:330])]) == {}
        stepped = apart - 4.0 * noise * (days >= at)
        (one,) = shown_changes([deviation_of(column, stepped)]).values()
        assert one.effect.name == f"{fault}_step"
        at_day = np.datetime64(one.effect.settings["at"])
        off.append(abs(np.datetime64(19000 + at, "D") - at_day).astype(int))
    assert off.count(0) >= 8 and max(off) <= 2  # of 60 others 58 are on the day


@pytest.mark.parametrize("days", [400, 730])
@pytest.mark.parametrize("begin", [0.3, 0.55, 0.7])
def test_a_second_sensor_shows_a_temporary_change_beside_a_season(days, begin):
    """It is forty times the noise: the same season of another year is not taken."""
    noise, days = noise_of(4, np.arange(days), 0.02), np.arange(days)
    first = int(begin * len(days))
    season = 0.1 * np.cos(2.0 * np.pi * days / 365.25)
    apart = noise + season - 0.8 * ((days >= first) & (days < first + 50))
    shown = shown_changes([deviation_of("temp_air_2", apart)])
    (one,) = shown.values()
    assert one.effect.name == "air_offset_episode"
    dates = [np.datetime64(19000 + day, "D") for day in (first, first + 50)]
    found = [np.datetime64(one.effect.settings[name]) for name in ("start", "end")]
    assert dates == found


def test_the_size_of_a_step_of_a_reference_is_that_beside_its_trend():
    """It gets dirty by 5 % a year, and steps by 10 %."""
    days = np.arange(600)
    apart = noise_of(5, days, 0.005) - 0.05 * days / 365.25 - 0.1 * (days >= 250)
    reference = deviation_of("poa_global_2", apart)
    shown = shown_by(reference, Criteria())
    assert {*shown} == {"irradiance_sensor_step", "irradiance_sensor_drift"}
    step = shown["irradiance_sensor_step"].effect
    alone = given_others(reference, shown, step.name)
    size, error, _ = alone.along(weights_of(step, alone.days))
    assert size == pytest.approx(-0.1, abs=3.0 * error) and error < 0.005


def test_a_second_change_is_not_confirmed_by_what_shows_the_first():
    """A trend from about the same day on deviates along with a step."""
    days = np.arange(400)
    apart = noise_of(2, days, 0.01) - 0.12 * (days >= 110)
    reference = deviation_of("poa_global_2", apart)
    step, drift = (
        CHANGES[name].make(**dates)
        for name, dates in (
            ("irradiance_sensor_step", {"at": "2022-04-28"}),
            ("irradiance_sensor_drift", {"start": "2022-04-21"}),
        )
    )
    assert weights_of(step, reference.days).sum() == (days >= 110).sum()
    chosen = Choice(Candidate(step, (1,), 0.0), SimpleNamespace())
    weights = weights_of(drift, reference.days)
    alone, error, _ = reference.along(weights)
    assert abs(alone) > 3.0 * error
    beside, error, _ = reference.given([chosen]).along(weights)
    assert abs(beside) < 3.0 * error and abs(beside) < 0.1 * abs(alone)
    # which takes all of the step's own deviation
    assert not reference.given([chosen]).sees(weights_of(step, reference.days))


def test_a_reference_says_how_likely_sizes_of_several_changes_are():
    """Of a sensor that reads 10 % less from a day on."""
    days = np.arange(400)
    apart = noise_of(2, days, 0.01) + np.log1p(0.1) * (days >= 110)
    power = deviation_of("power_ac", apart)
    step, light, other, contact = (
        CHANGES[name].make(at="2022-04-28")
        for name in (
            "irradiance_sensor_step",
            "module_irradiance_step",
            "time_constant_step",
            "module_sensor_contact_step",
        )
    )

    def logs(*changes):
        return log_likelihoods_of_sizes([power], {}, changes)

    right, wrong, nothing = (
        logs([Sized(step, size, 0.1)])[0] for size in (0.1, -0.27, 1e-9)
    )
    # which is neither that of the other sign nor nothing
    assert 5.0 < right < 8.0 and abs(wrong) < 0.1 and abs(nothing) < 0.1
    steady = deviation_of("power_ac", noise_of(2, days, 0.01))
    assert log_likelihoods_of_sizes([steady], {}, [[Sized(step, 0.1, 0.1)]])[0] < -2.0
    # the other faults of a law share the likelihood, and power shows no contact
    assert logs([Sized(step, 0.1, 0.1), Sized(light, 0.1, 0.1)]) == [
        pytest.approx(right, abs=0.2)
    ]
    assert logs([Sized(contact, 0.1, 0.1)]) == [0.0]
    half = np.log((np.exp(right) + 1.0) / 2.0)
    faults = [Sized(step, 0.1, 0.1), Sized(contact, 0.1, 0.1)]
    assert logs(faults) == [pytest.approx(half)]
    # one that power does not show takes nothing of a step, and a trend after it does
    sized = Sized(step, 0.1, 0.1)
    assert logs([sized], [Sized(other, 0.2, 0.1)]) == [right, 0.0]
    drift = CHANGES["irradiance_sensor_drift"].make(start="2022-04-28")
    (alone,) = logs([Sized(drift, 0.15, 0.1)])
    of_step, of_drift = logs([sized], [Sized(drift, 0.15, 0.1)])
    assert alone > 2.0 and of_drift < 0.0 < of_step


@pytest.mark.parametrize("at, start", [(60, "2022-08-10"), (120, "2022-07-10")])
def test_a_step_that_power_shows_confirms_no_trend(at, start):
    """With the year taken off, a step in spring is much like a trend from summer on."""
    days = np.arange(365)
    apart = noise_of(2, days, 0.01) - np.log1p(0.1) * (days >= at)
    power, sky = deviation_of("power_ac", apart), deviation_of(SKY, apart)
    pairs = with_own([power, sky], Criteria())
    assert [*pairs[0][1]] == ["irradiance_sensor_step"] and pairs[1][1] == {}
    drift = Sized(CHANGES["irradiance_sensor_drift"].make(start=start), -0.25, 0.1)
    step = Sized(pairs[0][0].own[0], -0.1, 0.1)
    for reference, (given, _) in zip((power, sky), pairs):
        assert given.own == (step.effect,)
        before, after = (
            log_likelihoods_of_sizes([one], {}, [[drift]])[0]
            for one in (reference, given)
        )
        assert before > 0.0 > after
        # which is as sure of the step as before
        assert log_likelihoods_of_sizes([given], {}, [[step]]) == (
            log_likelihoods_of_sizes([reference], {}, [[step]])
        )


def test_light_on_the_rear_may_show_nothing_in_power():
    """A brighter ground heats modules of one face; a sensor that reads less cannot."""
    days = np.arange(400)
    noise = noise_of(2, days, 0.01)
    sensor, light = (
        Sized(CHANGES[f"{name}_step"].make(at="2022-04-28"), 0.1, 0.1)
        for name in ("irradiance_sensor", "module_irradiance")
    )

    def log(apart, one):
        return log_likelihoods_of_sizes([deviation_of("power_ac", apart)], {}, [[one]])

    assert log(noise, sensor)[0] < -3.0
    assert log(noise, light)[0] == pytest.approx(np.log(0.5), abs=0.1)
    stepped = noise + np.log1p(0.1) * (days >= 110)
    assert log(stepped, light)[0] == pytest.approx(log(stepped, sensor)[0], abs=0.5)
    # another law: heat of the rear stays when the front receives more
    more = noise + 1.4 * np.log1p(0.1) * (days >= 110)
    assert log(more, light)[0] > log(more, sensor)[0] + 0.5


def test_power_has_worse_odds_than_a_second_sensor():
    """A plant's power also changes by its modules and inverters."""
    noise = noise_of(1, np.arange(400), 0.01)
    stepped = noise - 0.1 * (np.arange(400) >= 150)
    light, power = (
        shown_changes([deviation_of(column, stepped)]).values()
        for column in ("poa_global_2", "power_ac")
    )
    (light,), (power,) = light, power
    assert light.effect.settings == power.effect.settings
    assert light.log_odds == 0.0
    assert np.exp(power.log_odds) == pytest.approx(Criteria().prior_odds)
    both = [deviation_of(name, stepped) for name in ("power_ac", "poa_global_2")]
    (one,) = shown_changes(both).values()
    assert one.log_odds == 0.0


def test_references_decide_between_a_trend_of_the_record_and_of_a_part():
    """By the temperature, it ends where another change hides what follows."""
    (days, hours), random = clock(730), np.random.default_rng(6)
    every, fades = np.arange(730), np.arange(730) / 365.25
    rest = days / 365.25 - 1.2 * (days >= 500) + noise_of(7, days, 0.5)
    selection = offsets(rest, days, hours)
    base = [*selection.design.base]
    (step,) = (c for c in selection.candidates(base) if c.time_profile == "step")
    choice = Choice(step, selection.score(step, base))
    (dark,) = (one for one in COMPARISONS if "module_offset" in one.shows)

    def trend_by(apart):
        apart = random.normal(0.0, 0.05, len(every)) - apart
        second = DailyDeviation(dark, "temp_module_2", START + every, apart, None)
        one, _ = weighed_by_references(selection, choice, [], [second], {})
        return one.members["module_offset_drift"]

    assert weighed(selection, choice, []).members["module_offset_drift"].dates
    assert trend_by(fades).effect.settings == {"since": "2023-01-01"}
    assert trend_by(np.where(every < 500, fades, 0.0)).time_profile == OF_A_PART


def test_a_change_at_the_dates_of_a_reference_is_a_rival():
    """By the temperature, a trend is most like a step between two others."""
    (days, hours), every = clock(730), np.arange(730)
    rest = 1.0 * (days >= 250) + 1.1 * (days >= 480) + noise_of(7, days, 0.5)
    selection = offsets(rest, days, hours)
    base = [*selection.design.base]
    (trend,) = (c for c in selection.candidates(base) if c.time_profile == "drift")
    choice = Choice(trend, selection.score(trend, base))
    (dark,) = (one for one in COMPARISONS if "module_offset" in one.shows)

    def step_by(day, size):
        apart = noise_of(6, every, 0.05) - size * (every >= day)
        second = DailyDeviation(dark, "temp_module_2", START + every, apart, None)
        informed = replace(selection, shown=shown_changes([second]))
        one, _ = weighed_by_references(informed, choice, [], [second], {})
        return one.members["module_offset_step"].effect.settings["at"]

    assert step_by(250, 1.0) == "2023-09-08"
    # a reference that shows what the temperature does not is no better date
    plain = weighed(selection, choice, []).members["module_offset_step"]
    assert step_by(100, 0.02) == plain.effect.settings["at"] != "2023-09-08"


def test_a_change_of_the_model_is_not_tried_again():
    """A reference shows it, and another change of that sensor is weighed given it."""
    (days, hours), every = clock(730), np.arange(730)
    rest = 1.0 * (days >= 250) + 1.0 * (days >= 480) + noise_of(7, days, 0.5)
    selection = offsets(rest, days, hours)
    (dark,) = (one for one in COMPARISONS if "module_offset" in one.shows)
    apart = noise_of(6, every, 0.05) - 1.0 * (every >= 250)
    second = DailyDeviation(dark, "temp_module_2", START + every, apart, None)
    selection = replace(selection, shown=shown_changes([second]))
    base = [*selection.design.base]
    (first,) = selection.shown_candidates()
    there = Choice(first, selection.score(first, base))
    given = selection.given([there])
    (other,) = (c for c in selection.candidates(given) if c.time_profile == "step")
    choice = Choice(other, selection.score(other, given))
    one, _ = weighed_by_references(selection, choice, [there], [second], {})
    step = one.members["module_offset_step"].effect
    assert step.settings["at"] == "2024-04-25"


@pytest.mark.parametrize("profile", ["step", "episode", "drift"])
def test_a_reference_that_shows_a_change_narrows_its_dates(profile):
    """It is sharper than the temperature, which alone knows the date to some weeks."""
    (days, hours), every = clock(730), np.arange(730)
    dates = {
        "step": {"at": "2023-09-08"},
        "episode": {"start": "2023-09-08", "end": "2024-03-01"},
        "drift": {"start": "2023-09-08"},
    }[profile]
    change = CHANGES[f"module_offset_{profile}"].make(**dates)
    rest = 0.8 * weights_of(change, START + days) + noise_of(7, days, 1.0)
    selection = offsets(rest, days, hours)
    base = [*selection.design.base]
    top = selection.candidate_of(change)
    (dark,) = (one for one in COMPARISONS if "module_offset" in one.shows)

    def days_of(size):
        apart = noise_of(6, every, 0.02) - size * weights_of(change, START + every)
        second = DailyDeviation(dark, "temp_module_2", START + every, apart, None)
        choice = weighed(selection, Choice(top, selection.score(top, base)), [])
        choice = replace(choice, probabilities={change.name: 1.0})
        choice = cross_checked([second], choice, change, {})
        costs = date_costs([second], change)
        found = selection.dated(choice, change.name, base, costs).settings
        begin, first, last = (
            np.datetime64(date)
            for date in (found.get("at") or found["start"], *found["between"])
        )
        assert first <= np.datetime64("2023-09-08") <= last
        assert first <= begin <= last
        return int((last - first).astype(int))

    alone, narrow = days_of(0.0), days_of(0.8)
    assert narrow <= 0.3 * alone


def test_a_step_that_power_and_a_clear_sky_date_is_no_dirt():
    """The temperature alone prefers the trend of another sensor."""
    _, data, (world, sensor, course, size, (day, _), _) = study_instruments.made(61042)
    assert (sensor, course) == ("irradiance_sensor", "step")
    loop = close_loop(data, check_units=False, **world.place)
    (step,) = (f for f in loop.finding_objects if f.effect == f"{sensor}_step")
    assert step.verdict is Verdict.IDENTIFIED
    assert [*step.coefficients.values()] == pytest.approx([size], abs=0.02)
    first = (data.index[0] + pd.Timedelta(days=day)).ceil("D")  # the first whole day
    assert step.place.startswith(f"{first:%Y-%m-%d}")
    added = [f for f in loop.finding_objects if f.added]
    assert all(check.passed for f in added for check in f.checks)


def test_a_step_is_a_rival_of_a_trend_on_the_day_that_power_shows():
    """The temperature dates it a month late, where power refuses it."""
    _, data, (world, sensor, course, *_) = study_instruments.made(63092)
    assert (sensor, course) == ("irradiance_sensor", "step")
    loop = close_loop(data, check_units=False, **world.place)
    (found,) = (f for f in loop.finding_objects if f"{sensor}_step" in f.candidates)
    assert found.verdict is Verdict.AMBIGUOUS
    assert [*found.candidates] == [f"{sensor}_drift", f"{sensor}_step"]


def shown_changes(references):
    """Changes that any reference shows, by name."""
    return with_best_odds(shown for _, shown in with_own(references, Criteria()))


def noise_of(seed, days, size):
    return np.random.default_rng(seed).normal(0.0, size, len(days))


def test_a_change_that_a_second_sensor_shows_is_a_hint(half_a_year):  # noqa: F811
    """It is too small for the module temperature alone."""
    data, _ = with_change(half_a_year, noise=1.0)
    sensor = data["poa_global"]
    second = sensor * (1.0 + noise_of(2, sensor, 0.01))
    data["poa_global"] = sensor / (1.0 + 0.03 * after(data))
    assert not any("irradiance_sensor_step" in f.candidates for f in hints_of(data))
    (hint,) = (
        f
        for f in hints_of(data.assign(poa_global_2=second))
        if "irradiance_sensor_step" in f.candidates
    )
    assert hint.effect == "irradiance_sensor_step" and "2023-09-15" in hint.place
    (check,) = (c for c in hint.cross_checks if c.effect == hint.effect)
    assert check.outcome is not CheckOutcome.CONTRADICTS
    assert check.size == pytest.approx(np.log(1.03), abs=0.003)


def test_a_change_that_power_shows_is_a_hint(half_a_year):  # noqa: F811
    """It is too small for the module temperature alone."""
    data, _ = with_change(half_a_year, noise=1.0)
    data = with_power(data, 0.0)
    data["poa_global"] /= 1.0 + 0.03 * after(data)
    names = {"irradiance_sensor_step", "module_irradiance_step"}
    without = hints_of(data.drop(columns="power_ac"))
    assert not any(names & {*f.candidates} for f in without)
    (hint,) = (f for f in hints_of(data) if names & {*f.candidates})
    assert hint.effect in names and hint.place.startswith("2023-09-15")


def test_a_plant_that_loses_a_string_is_no_fault_of_the_sensor(
    half_a_year,  # noqa: F811
):
    """Power is a tenth less from a date on, and the module temperature the same."""
    data, _ = with_change(half_a_year, noise=1.2)
    data = with_power(data, 0.0)
    data["power_ac"] *= 1.0 - 0.1 * after(data)
    names = {"irradiance_sensor_step", "module_irradiance_step"}
    loop = closed(data)
    assert not any(names & {*f.candidates} for f in loop.finding_objects)
    (note,) = (note for note in loop.notes if note.startswith("power_ac has changed"))
    assert "2023-09-15 on: at the same irradiance it is 10.4 ± 0.2 % less, but" in note
    assert "check modules, strings and inverters" in note


@pytest.mark.parametrize(
    ("column", "words"),
    [
        ("poa_global_2", "by poa_global_2 poa_global reads 3."),
        ("power_ac", "at the same irradiance power is 3."),
    ],
)
def test_a_deviation_that_the_temperature_cannot_assign_has_a_note(
    half_a_year,  # noqa: F811
    column,
    words,
):
    """A change of 3 % in a module temperature whose error is ten times its own."""
    data, _ = with_change(half_a_year, noise=6.0)
    powered = with_power(data, 0.0)
    light = data["poa_global"] * (1.0 + noise_of(2, data["poa_global"], 0.01))
    second = powered["power_ac"] if column == "power_ac" else light
    loop = closed(data.assign(**{column: second}))
    assert not any("deviate" in note for note in loop.notes)
    loop = closed(data.assign(**{column: second * (1.0 + 0.035 * after(data))}))
    assert not any({*f.candidates} & {*CHANGES} for f in loop.finding_objects)
    (note,) = (note for note in loop.notes if "deviate" in note)
    assert note.startswith(f"{column} and poa_global deviate, from 2023-09-15 on: ")
    assert words in note and "which cannot tell" in note and "check both" in note


@pytest.mark.parametrize(
    ("usual", "second", "words"),
    [
        ("poa_global", lambda values, on: values * (1.0 - 0.1 * on), "% more"),
        ("temp_air", lambda values, on: values - 2.0 * on, "K more"),
    ],
)
def test_a_second_sensor_that_changes_is_named(
    half_a_year,  # noqa: F811
    usual,
    second,
    words,
):
    """The module temperature follows the usual one."""
    data, _ = with_change(half_a_year)
    noisy = data[usual] * (1.0 + noise_of(2, data[usual], 0.01))
    named = f"{usual}_2 has changed, from 2023-09-1"
    still = closed(data.assign(**{f"{usual}_2": noisy}))
    assert not any("has changed" in note for note in still.notes)
    loop = closed(data.assign(**{f"{usual}_2": second(noisy, after(data))}))
    (note,) = (note for note in loop.notes if "has changed" in note)
    assert note.startswith(named) and words in note.split(", but")[0]
    assert f"check the sensor of {usual}_2" in note
    changed = data.assign(
        **{f"{usual}_2": noisy, usual: second(data[usual], after(data))}
    )
    assert not any(named in note for note in closed(changed).notes)


def hints_of(data):
    return [f for f in closed(data).finding_objects if f.verdict is Verdict.HINT]


def test_soiling_shows_where_its_light_does():
    """It speaks as well for dirt that gathers as for a sensor that fades as much."""
    years = np.arange(365) / 365.25
    even = season_or_drift("soiling", light=lambda effect: years)
    assert abs(even) < 0.5 < season_or_drift("soiling")


def test_dirt_is_compared_by_the_light_that_it_takes_each_day():
    """Of a sensor that rain washes: given that, nothing confirms a trend in summer."""
    days = np.arange(400)
    dirt = np.where((days >= 120) & (days < 220), days - 120, days % 20)
    noise, rate = noise_of(2, days, 0.01), 0.002

    def compared(column, apart, *changes):
        (comparison,) = (one for one in COMPARISONS if one.serves(column))
        one = DailyDeviation(comparison, column, 19000 + days, apart, lambda _: dirt)
        return log_likelihoods_of_sizes([one], {}, [[one] for one in changes])

    dirty = noise + np.log1p(rate * dirt)
    sensor, module = (Sized(EFFECTS["soiling"], size, 0.1) for size in (rate, -rate))
    summer = {"start": "2022-05-09", "end": "2022-08-17"}
    drift = Sized(CHANGES["irradiance_sensor_drift"].make(**summer), 0.73, 0.1)
    for column in ("power_ac", SKY):
        assert compared(column, dirty, sensor)[0] > 5.0
        assert compared(column, noise, sensor)[0] < -2.0
        (alone,), (_, given) = (
            compared(column, dirty, *changes) for changes in ([drift], [sensor, drift])
        )
        assert alone > 2.0 and given < 0.0
    # dirt on the modules shows in power alone
    washed = noise + np.log1p(-rate * dirt)
    assert compared("power_ac", washed, module)[0] > 5.0
    assert compared(SKY, washed, module)[0] == pytest.approx(0.0, abs=1e-9)


def test_a_standstill_is_compared_by_the_light_that_it_takes_each_day():
    """Under clouds modules miss nothing, and their light is estimated badly."""
    days = np.arange(300)
    stands = (days >= 120) & (days < 150)
    clear = stands & (days % 3 == 0)
    light = np.where(clear, -0.25, 0.0) + 0.05 * (stands & ~clear)
    apart = noise_of(2, days, 0.01) + np.log1p(np.where(clear, -0.25, 0.0))
    (power,) = (one for one in COMPARISONS if one.ages)
    reference = DailyDeviation(power, "power_dc", 19000 + days, apart, lambda _: light)
    dates = (str(np.datetime64(19000 + day, "D")) for day in (120, 150))
    stuck = EFFECTS["tracker_stuck"].make(*dates)
    shown = reference.shown(stuck, [Sized(stuck, 1.0, 0.1)], {})
    assert shown.size == pytest.approx(shown.expected[stuck.name], rel=0.1)
    assert -0.2 < shown.size < -0.1 and shown.error < 0.02
    of_sizes = partial(log_likelihoods_of_sizes, [reference], {})
    right, half = (of_sizes([[Sized(stuck, n, 0.1)]])[0] for n in (1.0, 0.5))
    assert right > 5.0 and right > half + 2.0


@pytest.mark.parametrize(
    "switch, device", [("soiling_sensor", "the sensor reads"), ("soiling", "receive")]
)
def test_power_confirms_where_dirt_is_and_how_fast_it_gathers(switch, device):
    """0.6 % a day until it rains, with power as a column that no fit has used."""
    forms = simulator.Forms(cleaning="rain", washed_by=(5.0, 6.0))
    site = simulator.Site(rain_days=0.15, forms=forms)
    effects = simulator.PHYSICS | {switch: 2.0}
    data = simulator.record(site, effects, days=300, step=1800.0, seed=11)
    loop = close_loop(
        data,
        location=Location(site.latitude, site.longitude),
        surface_tilt=site.surface_tilt,
        surface_azimuth=site.surface_azimuth,
    )
    (one,) = (f for f in loop.finding_objects if f.effect == "soiling")
    assert one.verdict is Verdict.IDENTIFIED
    (check,) = (c for c in one.cross_checks if c.column == "p_dc_per_area")
    assert check.outcome is CheckOutcome.AGREES and check.unit == "-/day"
    size = 0.006 * np.sign(one.coefficients["soiling.per_day"])
    assert check.size == pytest.approx(size, rel=0.2)
    assert device in str(check) and "less a day" in str(check)


def test_power_speaks_for_the_irradiance_sensor_where_the_mounting_changed(
    half_a_year,  # noqa: F811
):
    data, _ = with_change(half_a_year, "mounting_step")
    loop = closed(with_power(data, 0.0))
    first = loop.finding_objects[0]
    assert first.verdict is Verdict.AMBIGUOUS
    assert "mounting_step" in first.candidates
    assert "irradiance_sensor_step" not in first.candidates
    outcomes = {
        (o.effect, o.outcome) for o in first.cross_checks if o.column == "power_ac"
    }
    # more light on the rear alone would show nothing, either
    assert outcomes == {
        ("irradiance_sensor_step", CheckOutcome.CONTRADICTS),
        ("module_irradiance_step", CheckOutcome.CANNOT_TELL),
    }
    assert "power_ac contradicts" in loop.report()
    assert "driver:power_ac" not in loop.ranking.index


@pytest.mark.parametrize(
    ("usual", "column", "sensor_fault", "size"),
    [
        ("poa_global", "poa_global_2", "irradiance_sensor", 0.1),
        ("wind_speed", "wind_speed_mast", "anemometer", 3.0),
        ("temp_air", "temp_air_2", "air_offset", 1.5),
        ("temp_module", "temp_module_2", "module_sensor_contact", -0.15),
        ("temp_module", "temp_module_2", "module_offset", 1.5),
    ],
)
def test_a_second_sensor_names_the_first(
    half_a_year,  # noqa: F811
    usual,
    column,
    sensor_fault,
    size,
):
    """The twin sees what was there; the usual column what its sensor made of it."""
    data, _ = with_change(half_a_year)
    random = np.random.default_rng(2)
    twin = data[usual] * (1.0 + random.normal(0.0, 0.01, len(data)))
    there, air = after(data), data["temp_air"]
    if sensor_fault == "module_offset":
        data[usual] = data[usual] + size * there
    elif usual == "temp_module":
        data[usual] = air + (data[usual] - air) * (1.0 + size * there)
    elif usual == "temp_air":
        data[usual] = data[usual] - size * there
    else:
        share = size / 6.84 if usual == "wind_speed" else size  # of Faiman's u1
        data[usual] = data[usual] / (1.0 + share * there)
    first = closed(data.assign(**{column: twin})).finding_objects[0]
    assert (
        first.effect == f"{sensor_fault}_step" and first.verdict is Verdict.IDENTIFIED
    )
    mine = {one.outcome for one in first.cross_checks if one.effect == first.effect}
    assert mine == {CheckOutcome.AGREES}


def test_a_finding_keeps_its_cross_checks_in_a_file(half_a_year):  # noqa: F811
    data, _ = with_change(half_a_year, "mounting_step")
    first = closed(with_power(data, 0.0)).finding_objects[0]
    content = as_json(first)
    assert (
        Stored(content, "loop.json").whole(Finding).cross_checks == first.cross_checks
    )


@pytest.mark.parametrize(
    ("name", "usual", "power"),
    [
        ("poa_global_2", "poa_global", False),
        ("poa_modelled", "poa_global", False),
        ("temp_module_16", "temp_module", False),
        ("poa_global", None, False),
        ("poa_rear_2", None, False),
        ("poa_direct", None, False),
        ("poa_sky_diffuse", None, False),
        ("poa_direct_original", None, False),
        ("power_ac", None, True),
        ("p_dc_per_area", None, True),
        ("power", None, True),
        ("precipitation", None, False),
        ("pressure", None, False),
    ],
)
def test_a_name_says_what_a_column_cross_checks(name, usual, power):
    assert twin_of(name) == usual and is_power(name) == power
    assert is_cross_check(name) == (
        usual is not None or (power and name != "p_dc_per_area")
    )


PLACE = Location(40.0, -105.0, "Etc/GMT+7", 1700.0)


def under_clouds(fading=0.0, tilt=20.0, late=0, seed=0):
    """Two hourly years below a sky of which two days in three have clouds."""
    index = pd.date_range("2021-01-01", periods=2 * 8760, freq="1h")
    sun = PLACE.get_solarposition(index.tz_localize(PLACE.tz))
    air = pvlib.atmosphere.get_relative_airmass(sun["apparent_zenith"])
    clear = pvlib.clearsky.ineichen(sun["apparent_zenith"], air, 2.5, PLACE.altitude)
    poa = pvlib.irradiance.get_total_irradiance(
        tilt,
        180.0,
        sun["apparent_zenith"],
        sun["azimuth"],
        clear["dni"],
        clear["ghi"],
        clear["dhi"],
        albedo=0.2,
    )["poa_global"].fillna(0.0)
    random = np.random.default_rng(seed)
    cloudy = random.uniform(size=731) < 0.67
    passing = (
        1.0 - random.uniform(0.1, 0.9, len(index)) * cloudy[np.arange(len(index)) // 24]
    )
    years = np.arange(len(index)) / 8766.0
    values = poa.to_numpy() * passing / (1.0 + fading * years)
    return pd.Series(np.roll(values, late), index)


def asked(poa, wind, place=PLACE, angles=(None, None), late=0.0, searched=None, **more):
    """All comparisons of a record with that irradiance and that wind."""
    dates = (poa.index.normalize() - pd.Timestamp(0)).days.to_numpy()
    columns = {"poa_global": poa.to_numpy(), "wind_speed": wind, **more}
    names = ("location", "surface_tilt", "surface_azimuth", "mount")
    places = dict(zip(names, (place, *angles, None)))

    class Record(dict):
        index, dates, absent = poa.index, None, ()

    record = Record(columns)
    record.dates = dates
    others = tuple(name for name in more if not name.startswith("temp"))
    case = SimpleNamespace(
        record=record, cross_check_columns=others, place=places, late=late
    )
    case.searched = np.ones(len(poa), dtype=bool) if searched is None else searched
    return {one.column: one for one in daily_deviations(case)}


@pytest.mark.parametrize("fading", [0.0, 0.15])
@pytest.mark.parametrize(
    ("angles", "late"), [((None, None), 0), ((20.0, 180.0), 0), ((None, None), 1)]
)
def test_a_clear_sky_shows_what_a_sensor_fades(fading, angles, late):
    """With angles and without, by a clock that is right or an hour late."""
    poa = under_clouds(fading, late=late)
    found = asked(poa, np.full(len(poa), 2.0), angles=angles)[SKY]
    years = (found.days - found.days[0]) / 365.2425
    size, error, _ = found.along(years)
    assert size == pytest.approx(np.log1p(2.0 * fading) / 2.0, abs=0.015)
    assert error > 0.01  # two years: turbidity alone could do as much
    wanted = dated("irradiance_sensor_drift", since="2021-01-01")
    outcome = outcome_of(size, found.expected(wanted, 0.15, years, {}), error)
    assert outcome is (CheckOutcome.AGREES if fading else CheckOutcome.CONTRADICTS)
    if not fading:
        little = found.expected(wanted, 0.03, years, {})
        assert outcome_of(size, little, error) is CheckOutcome.CANNOT_TELL


@pytest.mark.parametrize(
    ("size", "outcome"),
    [
        (0.0, "contradicts"),
        (0.05, "cannot tell"),
        (0.1, "agrees"),
        (0.3, "cannot tell"),
    ],
)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_reading_far_beyond_the_expected_one_does_not_agree(size, outcome, sign):
    """Three times as much has another cause, or a further one."""
    assert outcome_of(sign * size, sign * 0.1, 0.01) is CheckOutcome(outcome)


def test_what_needs_no_module_is_compared_on_all_weeks():
    """Its temperature on the weeks of the test is for the test alone."""
    poa = under_clouds()
    wind = np.random.default_rng(1).uniform(1.0, 4.0, len(poa))
    searched = np.arange(len(poa)) // (24 * 7) % 5 != 4
    more = {"poa_global_2": poa.to_numpy(), "power_ac": 5.0 * poa.to_numpy()}
    more["temp_module"] = np.where(searched, 25.0 + 0.03 * poa, np.nan)
    known = asked(poa, wind, searched=searched, **more)
    more["temp_module"] = 25.0 + 0.03 * poa.to_numpy()
    found = asked(poa, wind, searched=searched, **more)
    out = np.unique(np.flatnonzero(~searched) // 24) + found[USUAL_WIND].days[0]
    for name in (SKY, USUAL_WIND, "poa_global_2"):
        assert np.isin(out, found[name].days).mean() > 0.1  # clear days are few
    assert not np.isin(out, found["power_ac"].days).any()
    for name, one in found.items():
        np.testing.assert_array_equal(one.apart, known[name].apart)


def test_without_a_place_no_clear_sky_is_asked():
    poa = under_clouds()
    assert SKY not in asked(poa, np.full(len(poa), 2.0), place=None)


def test_what_changes_for_a_while_is_no_outlier_however_sharp_a_comparison():
    """A dozen standard errors for three weeks; snow, whose days differ, is one."""
    random = np.random.default_rng(0)
    values = random.normal(0.05, 0.01, 260)
    values[40:61] -= 0.12
    snow = np.arange(80, 100)
    values[snow] -= random.uniform(0.1, 2.0, len(snow))
    values[70] = np.nan
    kept = usual_days(values)
    assert not kept[70]
    assert kept[snow].sum() <= 2
    assert np.delete(kept, [70, *snow]).mean() > 0.98


def test_the_days_next_to_a_sharp_step_are_usual():
    """A step of twenty standard errors would be a day early without the last one."""
    values = np.random.default_rng(1).normal(0.0, 0.005, 300)
    for at in (60, 200):
        changed = values - 0.1 * (np.arange(300) >= at)
        assert usual_days(changed)[at - 4 : at + 4].all()


def test_a_change_hides_no_outliers():
    """Single days that are ten standard errors off, and a change of two months."""
    random = np.random.default_rng(0)
    values = random.normal(0.0, 0.01, 260)
    values[100:160] -= 0.12
    odd = np.arange(5, 260, 25)
    values[odd] -= 0.1 + 0.3 * random.random(len(odd))
    kept = usual_days(values)
    assert not kept[odd].any()
    assert np.delete(kept, odd).mean() > 0.98


def test_days_without_power_are_not_compared():
    """No irradiance sensor reads half or twice of what it is; two thirds can be."""
    poa = under_clouds()
    days = (poa.index.normalize() - pd.Timestamp(0)).days.to_numpy()
    off, changed = (
        (days >= days[0] + 150) & (days < days[0] + 170),
        days > days[-1] - 200,
    )
    power = poa * np.where(off, 0.05, 1.0) * np.where(changed, 0.65, 1.0)
    power *= 1.0 + noise_of(3, power, 0.03)
    warm = np.full(len(poa), 25.0)
    found = asked(poa, warm / 10.0, power_ac=power.to_numpy(), temp_module=warm)
    compared = np.unique(days[poa > 200.0])
    kept = np.isin(compared, found["power_ac"].days)
    assert not np.isin(days[off], found["power_ac"].days).any()
    assert kept[~np.isin(compared, days[off])].mean() > 0.98


def test_what_differs_from_year_to_year_is_in_the_error():
    """A step and a drift of a series that forgets over a year, drawn often."""
    days = np.arange(0, 4 * 365, 7) + 18_000
    comparison = next(c for c in COMPARISONS if c.serves(USUAL_WIND))
    apart_ = np.abs(np.subtract.outer(days, days))
    root = np.linalg.cholesky(np.exp(-apart_ / 365.25) + 1e-9 * np.eye(len(days)))
    random = np.random.default_rng(4)
    for weights in (days > days[100], days / 365.25):
        found = DailyDeviation(comparison, USUAL_WIND, days, np.zeros(len(days)), None)
        columns = [np.ones(len(days)), *found.year(), np.asarray(weights, dtype=float)]
        table = np.column_stack(columns)
        draws = comparison.wanders * root @ random.normal(size=(len(days), 2000))
        spread = (np.linalg.pinv(table)[-1] @ draws).std()
        assert np.sqrt(found.wandering(table)) == pytest.approx(spread, rel=0.1)


def test_the_usual_wind_names_an_anemometer_and_clears_it(half_a_year):  # noqa: F811
    """Half of the wind is lost from a date on, or the mounting changes."""
    data, _ = with_change(half_a_year)
    data["wind_speed"] /= 1.0 + 1.0 * after(data)
    first = closed(data).finding_objects[0]
    assert first.effect == "anemometer_step" and first.verdict is Verdict.IDENTIFIED
    said = {(one.column, one.outcome) for one in first.cross_checks}
    assert said == {(USUAL_WIND, CheckOutcome.AGREES)}
    assert "usual wind and the sensor differ" in first.why


def test_what_a_class_shares_with_the_model_is_not_fitted_twice():
    """Snow is in the model when an episode of the sensor is found in addition."""
    data, _, (world, *_) = study_instruments.made(11001)
    loop = close_loop(data, check_units=False, **world.place)
    names = [effect.name for effect in loop.fit.effects]
    assert "snow" in names and len(names) == len({*names})


@pytest.mark.parametrize("own_logger", [False, True])
def test_power_of_a_logger_that_is_off_is_held_to_the_right_time(own_logger):
    """Power agrees with a sensor that fades, whichever logger wrote it."""
    effects = simulator.PHYSICS | {"clock_shift": 0.0 if own_logger else 60.0}
    how = {"days": 400, "step": 1800.0, "start": "2022-01-01", "seed": 3}
    data = simulator.record(effects=effects, **how)
    years = (data.index - data.index[0]).days / 365.25
    power = 5000.0 * data["p_dc_per_area"]
    data = data[list(COLUMNS)].assign(power_dc=power)
    data["poa_global"] *= 1.0 - 0.1 * years
    if own_logger:
        data["temp_module"] = data["temp_module"].shift(2)
    loop = close_loop(data)
    assert loop.corrections[0].applied
    (drift,) = (
        f for f in loop.finding_objects if f.effect == "irradiance_sensor_drift"
    )
    (one,) = (w for w in drift.cross_checks if w.column == "power_dc")
    assert one.outcome is CheckOutcome.AGREES and one.size == pytest.approx(
        0.1, abs=0.03
    )
    actions = loop.corrected(data).actions
    retimed = {*actions["column"][actions["cause"] == "clock_shift"]}
    assert retimed == {"temp_module"} | ({"power_dc"} if not own_logger else set())


@pytest.mark.parametrize("days", [60, 120, 365])
@pytest.mark.parametrize("memory", [0.0, 0.8, 0.9])
def test_the_error_of_a_deviation_is_that_of_noise_that_lasts(days, memory):
    """Also of a record of two months, whose weather repeats from day to day."""
    random = np.random.default_rng(0)
    after = (np.arange(days) >= days // 2).astype(float)
    found = []
    for _ in range(200):
        white = random.standard_normal(days + 100)
        noise = lfilter([np.sqrt(1.0 - memory**2)], [1.0, -memory], white)[100:]
        one = DailyDeviation(COMPARISONS[0], "", 19_000 + np.arange(days), noise, dict)
        found.append(one.along(after)[:2])
    sizes, errors = np.array(found).T
    # two months of noise that remembers ten days are few draws
    least = 0.55 if memory * (days < 100) > 0.8 else 0.7
    assert least < np.sqrt(np.mean(errors**2) / np.mean(sizes**2)) < 1.25
