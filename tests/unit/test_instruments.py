"""Instruments and mountings that change: from a date on, slowly, for a while."""

import json
import pickle
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import study_instruments
from conftest import COLUMNS, DRIVERS
from pvlib.location import Location
from test_effects import coefficients, model_with

import pvlib_fem as fem
from pvlib_fem import datasets, simulator
from pvlib_fem._findings import Verdict
from pvlib_fem._loop.assemble import rank_remaining
from pvlib_fem._loop.close import finished_search
from pvlib_fem._loop.references.edge_weeks import of_its_dates
from pvlib_fem._thermal.model import ThermalModel
from pvlib_fem._thermal.steady_models import STEADY_MODELS
from pvlib_fem.effects import CHANGES, EFFECTS, SENSOR_FAULTS, find
from pvlib_fem.effects._time_profiles import YEAR, date_text, day_number, weights_of

#: sizes that are found outdoors
SIZES = {
    "irradiance_sensor": 0.1,
    "module_irradiance": 0.1,
    "module_sensor_contact": -0.15,
    "mounting": -0.15,
    "anemometer": 3.0,
    "anemometer_stall": 4.0,
    "air_offset": 1.0,
    "air_sensor_shield": 2.0,
    "module_offset": 1.0,
    "time_constant": 2.0,
}
#: dates amid the record of ``years``
DATES = {
    "step": {"at": "2023-09-15"},
    "drift": {"since": "2023-06-01"},
    "episode": {"start": "2023-08-01", "end": "2023-10-20"},
}
every = pytest.mark.parametrize("name", CHANGES)


def time_profile(name):
    return name.rsplit("_", 1)[1]


def size(name):
    (row,) = CHANGES[name].parameters.values()
    return float(
        np.clip(SIZES[name.rsplit("_", 1)[0]], 0.8 * row.lower, 0.8 * row.upper)
    )


def dated(name, **dates):
    return find({"name": name, **(dates or DATES[time_profile(name)])})


@pytest.fixture(scope="module")
def half_a_year():
    """Two hundred days at half an hour, whose sensor has an error of hours."""
    return datasets.synthetic(200, 1800, seed=3, noise=0).tz_localize(None)


def with_change(data, *names, seed=0, noise=0.4, **sizes):
    """The record whose module answers changes of some names."""
    effects = tuple(map(dated, names))
    model = ThermalModel(STEADY_MODELS["faiman"], "balance", effects)
    values = coefficients("balance")
    for name, effect in zip(names, effects):
        (key,) = effect.rows()
        values[key] = sizes.get(name, size(name))
        if effect.sensor_fault == "anemometer":  # so much less is read of the same wind
            days = (data.index.normalize() - pd.Timestamp(0)).days
            less = 1.0 + values[key] * weights_of(effect, days) / values["u1"]
            data = data.assign(wind_speed=data["wind_speed"] / less)
    module = model.predict(*(data[n] for n in DRIVERS), values)
    random = np.random.default_rng(seed).normal(0.0, noise, len(data))
    rest = pd.Series(random, data.index).ewm(halflife=4).mean() * 2.0
    return data[list(DRIVERS)].assign(temp_module=module + rest), values


@every
def test_before_and_after_its_course_a_change_is_nothing_and_all(half_a_year, name):
    """An episode of all days is the fault itself; at its start nothing is added."""
    sensor_fault = next(c for c in SENSOR_FAULTS if name.rsplit("_", 1)[0] == c.name)
    usual = [half_a_year[n] for n in DRIVERS]
    plain = model_with("balance").predict(*usual, coefficients("balance"))

    def answer(effect, value):
        model = ThermalModel(STEADY_MODELS["faiman"], "balance", (effect,))
        (key,) = effect.rows()
        return model.predict(*usual, {**coefficients("balance"), key: value})

    np.testing.assert_allclose(answer(dated(name), 0.0), plain, rtol=1e-12)
    found = answer(dated(name), size(name))
    if time_profile(name) == "drift":
        year = answer(dated(name, since="2022-06-01"), size(name))
        whole = answer(sensor_fault, size(name))
        at = pd.Timestamp("2023-06-01 18:00")
        assert year[at] - plain[at] == pytest.approx(whole[at] - plain[at], rel=0.02)
        return
    first = day_number(next(iter(DATES[time_profile(name)].values())))
    before = (half_a_year.index - pd.Timestamp(0)) / pd.Timedelta("1D") < first
    np.testing.assert_allclose(found[before], plain[before], rtol=1e-12)
    whole = answer(sensor_fault, size(name))
    inside = slice("2023-09-20", "2023-10-15")  # beyond the module's memory
    np.testing.assert_allclose(found[inside], whole[inside], atol=1e-6)


@every
def test_a_change_of_known_dates_is_fitted(half_a_year, name):
    data, values = with_change(half_a_year, name)
    fit = fem.fit_fem(
        *(data[n] for n in COLUMNS),
        model="faiman",
        dynamics="balance",
        night=True,
        effects=[dated(name)],
    )
    (key,) = dated(name).rows()
    assert abs(fit.coefficients[key] - values[key]) < 4 * fit.stderr[key]


@pytest.mark.parametrize("size", [-0.2, 0.2, 0.4])
@pytest.mark.parametrize("name", ["module_sensor_contact_step", "mounting_step"])
def test_a_share_is_one_of_what_was_there_before(half_a_year, name, size):
    """Of the model's own over-temperature or loss, by a fit and by the loop."""
    data, values = with_change(half_a_year, name, **{name: size})
    usual = [data[n] for n in COLUMNS]
    how = dict(model="faiman", dynamics="balance", night=True)
    fit = fem.fit_fem(*usual, **how, effects=[dated(name)])
    loop = closed(data, effects=[name])
    assert loop.effects == [name]
    for one in (fit, loop.fit):
        (key,) = dated(name).rows()
        assert abs(one.coefficients[key] - size) < 4 * one.stderr[key]
        assert one.coefficients["u0"] == pytest.approx(values["u0"], rel=0.01)


@every
def test_it_is_found_again_by_its_name_and_its_dates(name):
    effect = dated(name)
    again = find(json.loads(json.dumps(effect.spec)))
    assert again.settings == effect.settings and again.rows() == effect.rows()
    assert pickle.loads(pickle.dumps(effect)).spec == effect.spec


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ({"name": "module_sensor_contact_step", "at": "April"}, "'April' is no date"),
        (
            {"name": "module_sensor_contact_step", "on": "2012-04-01"},
            "has no setting on",
        ),
        (
            {
                "name": "module_sensor_contact_episode",
                "start": "2012-04-02",
                "end": "2012-04-01",
            },
            "is not before end",
        ),
    ],
)
def test_dates_that_are_none_are_refused(spec, words):
    with pytest.raises(ValueError, match=words):
        find(spec)


def test_a_step_without_its_date_says_how_to_give_it(half_a_year):
    with pytest.raises(
        ValueError, match="module_sensor_contact_step has no date; give at, as"
    ):
        fem.fit_fem(
            *(half_a_year[n] for n in COLUMNS),
            model="faiman",
            effects="module_sensor_contact_step",
        )


def closed(data, **options):
    return fem.close_loop(data, check_units=False, **options)


@pytest.mark.parametrize("sensor_fault", SIZES)
def test_a_step_is_found_with_its_date(half_a_year, sensor_fault):
    name = f"{sensor_fault}_step"
    data, _ = with_change(half_a_year, name)
    loop = closed(data)
    first = loop.finding_objects[0]
    assert first.added and name in first.candidates
    changes = [n for n in first.candidates if n in CHANGES]
    assert {time_profile(n) for n in changes} == {"step"}
    effect = next(e for e in loop.fit.effects if e.name == first.effect)
    low, high = effect.settings["between"]
    assert low <= "2023-09-15" <= high
    assert day_number(high) - day_number(low) < 30


def test_a_logger_that_begins_to_average_is_no_other_mounting_and_contact():
    """
    Both would have to cancel by day to leave only what is late.

    Three quarters of the record are after the change, so the fit without it has the
    time constant of that part.
    """
    data = datasets.synthetic(240, 600, seed=3, noise=0).tz_localize(None)
    data, _ = with_change(data, noise=0.2)
    day = "2023-08-01"
    mean = data["temp_module"].rolling(6, min_periods=1).mean()
    data["temp_module"] = data["temp_module"].where(data.index < day, mean)
    loop = closed(data)
    assert loop.effects == ["time_constant_step"]
    (effect,) = (e for e in loop.fit.effects if e.sensor_fault)
    low, high = effect.settings["between"]
    assert low <= day <= high and day_number(high) - day_number(low) < 10
    # a mean over six rows is 25 minutes older; the module takes capacity/loss
    values = loop.fit.coefficients
    longer = values["time_constant_step.change"] * values["capacity"]
    loss = values["u0"] + values["u1"] * data["wind_speed"].mean()
    assert values["capacity"] == pytest.approx(17e3, rel=0.05)
    assert longer / loss == pytest.approx(25 * 60, rel=0.15)
    (statement,) = loop.statement_objects
    assert str(statement).startswith(f"From {effect.settings['at']} ")
    assert "a time constant that is" in str(statement) and "longer" in str(statement)


def test_a_stalled_anemometer_is_not_lost_in_the_shape_of_the_model():
    """From a day on its cups do not turn in winds below 1.8 m/s."""
    data = datasets.synthetic(400, 3600, seed=3, noise=0).tz_localize(None)
    data, _ = with_change(data)
    wind, day = data["wind_speed"], "2023-08-15"
    data["wind_speed"] = wind.where((wind >= 1.8) | (data.index < day), 0.0)
    loop = closed(data)
    first = loop.finding_objects[0]
    assert first.added and "anemometer_stall_step" in first.candidates
    (effect,) = (e for e in loop.fit.effects if e.name == "anemometer_stall_step")
    low, high = effect.settings["between"]
    assert low <= day <= high and day_number(high) - day_number(low) < 70


def of_a_world(seed, *change):
    """The loop of a record with full physics and a change of one sensor."""
    _, data, (world, *drawn) = study_instruments.made(seed)
    assert drawn[:2] == [*change]
    data = data.drop(columns="p_dc_per_area", errors="ignore")
    return fem.close_loop(data, check_units=False, **world.place)


def test_a_short_fault_is_no_other_one():
    """A pyranometer reads a seventh more for two months: found as that, or not."""
    loop = of_a_world(21037, "irradiance_sensor", "episode")
    for found in loop.finding_objects:
        if found.added and {*found.candidates} & {*CHANGES}:
            assert "irradiance_sensor_episode" in found.candidates


@pytest.mark.parametrize("size", [-11.0, 4.0])
def test_two_weeks_of_a_thermometer_are_found(size):
    """And what they would hide otherwise, such as the sky."""
    data = simulator.record(effects=simulator.OUTDOORS, days=365, step=900, seed=5)
    days = data.loc["2023-05-01":"2023-05-14"].index
    data.loc[days, "temp_air"] += size
    loop = fem.close_loop(data)
    assert "sky_radiation" in loop.effects
    (found,) = (
        f
        for f in loop.finding_objects
        if f.added and "air_offset_episode" in f.candidates
    )
    settings = next(e for e in loop.fit.effects if e.name == found.effect).settings
    # the week before is a test week, which is fitted for the date to be sure
    assert settings["start"] == "2023-05-01" and settings["end"] == "2023-05-15"
    assert "the week from 2023-04-24 on is fitted" in "\n".join(loop.notes)
    assert loop.table["rmse_test"].iloc[-1] < 0.8 * loop.table["rmse_test"][loop.base]
    if found.effect == "air_offset_episode":
        (change,) = found.coefficients.values()
        assert change == pytest.approx(-size, rel=0.15)


@pytest.mark.parametrize(
    "between, needed", [("2023-05-02", 7), ("2023-05-07", 7), ("2023-05-08", 0)]
)
def test_a_test_week_is_fitted_for_a_date_that_is_sure_without_it(between, needed):
    """It began on one of its seven days, or on fewer of those after it."""
    days = np.arange(day_number("2023-01-02"), day_number("2023-12-31"))
    week = (days >= day_number("2023-04-24")) & (days < day_number("2023-05-01"))
    effect = CHANGES["air_offset_episode"].make(
        start="2023-04-27", end="2023-06-10", between=("2023-04-24", between)
    )
    found = of_its_dates(effect, days[week], days[~week])
    assert found.sum() == needed


def test_snow_under_a_low_sun_is_not_named_an_obstacle():
    """
    At 56° north the sun of midwinter crosses a window of the sky that no other sees.

    What snow takes then is not there on the days of that window that have no snow.
    """
    loop = of_a_world(21036, "module_sensor_contact", "episode")
    named = {f.effect for f in loop.finding_objects if f.verdict is Verdict.IDENTIFIED}
    assert "shading" not in named


def test_an_episode_is_no_step(half_a_year):
    data, _ = with_change(half_a_year, "module_offset_episode")
    first = closed(data).finding_objects[0]
    assert first.added and "module_offset_episode" in first.candidates
    assert "module_offset_step" not in first.candidates


def test_a_drift_over_years_is_no_step():
    data = datasets.synthetic(800, 3600, seed=3, noise=0).tz_localize(None)
    data, _ = with_change(data, "irradiance_sensor_drift", irradiance_sensor_drift=0.08)
    first = closed(data).finding_objects[0]
    assert first.added and "irradiance_sensor_drift" in first.candidates
    assert "irradiance_sensor_step" not in first.candidates


#: a trend of some weeks, after which the sensor is cleaned or replaced
TOOTH = {"start": "2023-07-20", "end": "2023-10-05"}


def test_a_trend_with_dates_is_zero_before_and_after_them():
    effect = dated("irradiance_sensor_drift", **TOOTH)
    days = np.arange(day_number("2023-07-10"), day_number("2023-10-15"))
    weights = weights_of(effect, days)
    first, last = (day_number(date) for date in TOOTH.values())
    inside = (days >= first) & (days < last)
    assert not weights[~inside].any()
    np.testing.assert_allclose(np.diff(weights[inside]), 1.0 / YEAR)
    assert weights[inside][0] == pytest.approx(0.5 / YEAR)
    with pytest.raises(ValueError, match="start = '2023-10-05' is not before end"):
        dated("irradiance_sensor_drift", start="2023-10-05", end="2023-07-20")
    with pytest.raises(ValueError, match="give start if the trend begins there"):
        dated("irradiance_sensor_drift", since="2023-07-20", start="2023-08-05")


@pytest.mark.parametrize("days", [30, 365, 3000])
def test_a_trend_may_reach_the_bounds_of_its_fault_by_its_end(days):
    """In two years, if it lasts for longer or has no end."""
    end = date_text(day_number("2023-01-01") + days)
    (fault,) = (one for one in SENSOR_FAULTS if one.name == "irradiance_sensor")
    (of_fault,) = fault.parameters.values()
    dates = {"start": "2023-01-01", "end": end}
    (row,) = dated("irradiance_sensor_drift", **dates).parameters.values()
    years = min(days / YEAR, 2.0)
    assert row.upper == pytest.approx(of_fault.upper / years)
    assert row.lower == pytest.approx(of_fault.lower / years)


@pytest.mark.parametrize(
    "sensor_fault", ["irradiance_sensor", "air_offset", "module_offset"]
)
def test_a_trend_until_a_sensor_is_cleaned_is_found_with_its_dates(
    half_a_year, sensor_fault
):
    name = f"{sensor_fault}_drift"
    effect = dated(name, **TOOTH)
    (key,) = effect.rows()
    model = ThermalModel(STEADY_MODELS["faiman"], "balance", (effect,))
    years = (day_number(TOOTH["end"]) - day_number(TOOTH["start"])) / YEAR
    values = coefficients("balance") | {key: 1.5 * SIZES[sensor_fault] / years}
    module = model.predict(*(half_a_year[n] for n in DRIVERS), values)
    random = np.random.default_rng(7).normal(0.0, 0.4, len(module))
    loop = closed(half_a_year[list(DRIVERS)].assign(temp_module=module + random))
    (found,) = (f for f in loop.finding_objects if f.added)
    assert name in found.candidates
    assert {time_profile(n) for n in found.candidates if n in CHANGES} == {"drift"}
    settings = found.members[name].settings if found.effect != name else None
    settings = settings or next(
        e.settings for e in loop.fit.effects if e.name == found.effect
    )
    ends = day_number(settings["end"]) - day_number(TOOTH["end"])
    assert abs(ends) <= 5
    assert abs(day_number(settings["start"]) - day_number(TOOTH["start"])) <= 21


RESETS = ("2023-04-20", "2023-12-10", "2024-07-01")


def test_a_trend_begins_again_from_zero_at_its_resets():
    effect = dated("irradiance_sensor_drift", since="2023-01-01", resets=[*RESETS])
    days = np.arange(day_number("2023-01-01"), day_number("2024-12-31"))
    zeros = np.array([day_number(date) for date in ("2023-01-01", *RESETS)])
    last = zeros[np.searchsorted(zeros, days, side="right") - 1]
    np.testing.assert_allclose(weights_of(effect, days), (days + 0.5 - last) / YEAR)
    assert find({"name": effect.name, **effect.settings}).settings == effect.settings


def test_a_reset_before_the_record_says_since_when_a_trend_has_increased():
    dates = {"since": "2023-01-01", "resets": ("2022-09-10", "2023-06-10")}
    effect = dated("irradiance_sensor_drift", **dates)
    (begin,) = weights_of(effect, np.array([day_number("2023-01-01")]))
    ago = day_number("2023-01-01") - day_number("2022-09-10")
    assert begin == pytest.approx((ago + 0.5) / YEAR)
    assert effect.source == "2022-09-10, again from zero on 2023-06-10"
    # it reaches the bounds of its fault in the longest time without a reset
    (row,) = effect.parameters.values()
    (fault,) = (one for one in SENSOR_FAULTS if one.name == "irradiance_sensor")
    (of_fault,) = fault.parameters.values()
    assert row.upper == pytest.approx(of_fault.upper * YEAR / 273.0)


@pytest.mark.parametrize(
    ("dates", "words"),
    [
        ({"resets": "2023-04-20"}, "is one date; give a list of dates"),
        ({"resets": ["April"]}, "'April' is no date"),
        ({"start": "2023-05-01", "resets": RESETS}, "is not after start"),
        ({"end": "2024-06-01", "resets": RESETS}, "is not before end"),
    ],
)
def test_resets_that_are_no_dates_of_a_trend_are_refused(dates, words):
    with pytest.raises(ValueError, match=words):
        dated("irradiance_sensor_drift", **dates)


@pytest.mark.parametrize("sensor_fault", ["irradiance_sensor", "module_offset"])
def test_a_sensor_that_is_cleaned_several_times_has_one_trend(sensor_fault):
    weather = datasets.synthetic(730, 3600, noise=0).tz_localize(None)
    weather.index = pd.date_range("2023-01-01", periods=len(weather), freq="h")
    name = f"{sensor_fault}_drift"
    effect = dated(name, since="2023-01-01", resets=RESETS)
    (key,) = effect.rows()
    model = ThermalModel(STEADY_MODELS["faiman"], "balance", (effect,))
    values = coefficients("balance") | {key: 2.0 * SIZES[sensor_fault]}
    module = model.predict(*(weather[n] for n in DRIVERS), values)
    random = np.random.default_rng(7).normal(0.0, 0.4, len(module))
    record = weather[list(DRIVERS)].assign(temp_module=module + random)
    loop = closed(record)
    (found,) = (f for f in loop.finding_objects if f.added)
    assert name in found.candidates
    (own,) = (e for e in loop.fit.effects if e.sensor_fault)
    resets = [day_number(date) for date in own.settings["resets"]]
    apart = np.subtract.outer([day_number(date) for date in RESETS], resets)
    assert np.abs(apart).min(axis=1).max() <= 7
    (text,) = loop.statements["text"][loop.statements["cause"] == found.effect]
    assert "increasing day by day since 2023-01-01, again from zero on 20" in text
    if sensor_fault == "irradiance_sensor":
        days = (record.index - pd.Timestamp(0)) // pd.Timedelta("1D")
        true = 1.0 + values[key] * weights_of(effect, days.to_numpy())
        light = record["poa_global"] > 0.0
        corrected = loop.corrected(record, resolve=[name]).data
        fixed = corrected["poa_global"] / record["poa_global"]
        assert np.abs(fixed - true)[light].quantile(0.95) < 0.02


def test_where_nothing_changes_nothing_is_found():
    """Ten records of noise with a memory of hours: no date in any."""
    for seed in range(10):
        data = datasets.synthetic(200, 3600, seed=seed, noise=0).tz_localize(None)
        data, _ = with_change(data, seed=seed)
        loop = closed(data)
        assert not [f for f in loop.finding_objects if f.effect in CHANGES], seed


def test_the_step_at_bolzano_is_of_the_spring_of_2012(bolzano):
    """By temperatures alone: a fifth more over-temperature, an ambiguous finding."""
    loop = fem.close_loop(bolzano[list(COLUMNS)])
    first = loop.finding_objects[0]
    assert {"module_sensor_contact_step", "mounting_step"} <= {*first.candidates}
    effect = next(e for e in loop.fit.effects if e.name == first.effect)
    assert abs(day_number(effect.settings["at"]) - day_number("2012-04-01")) < 14
    (change,) = first.coefficients.values()
    # so much more over-temperature, or so much less loss; the medians of the readings
    # before and after it differ by a fifth
    less = first.effect == "mounting_step"
    share = 1.0 / (1.0 + change) - 1.0 if less else change
    assert share == pytest.approx(0.2, abs=0.02)
    assert loop.table["rmse_test"].iloc[-1] < loop.table["rmse_test"]["fem"] - 0.1


@pytest.mark.parametrize(
    "name", ["mounting_step", "module_sensor_contact_step", "irradiance_sensor_step"]
)
def test_a_change_in_the_model_explains_what_it_did_before(half_a_year, name):
    """By its tangent as by the fit: no other tangent, no misfit has a part of it."""
    data, _ = with_change(half_a_year, name, **{name: -0.3})
    no_place = fem.drivers.checked_place(None)
    how = dict(holdout=None, effects=None, fixed=None, criteria=fem.Criteria())
    search, loop = finished_search(data, "faiman", no_place, None, **how)
    assert loop.finding_objects[0].added
    steps = [*search.steps.values()][-1 - len(loop.effects) :]
    before, after = (one.error(search.case.fitting) ** 2 for one in steps[:2])
    assert search.last.choices[0].fall == pytest.approx(before - after, rel=0.2)


def test_the_ranking_is_given_what_is_reported(half_a_year):
    """Not the cause that was selected first, if another one is more probable."""
    data, _ = with_change(half_a_year, "mounting_step", mounting_step=-0.05)
    no_place = fem.drivers.checked_place(None)
    how = dict(holdout=None, effects=None, fixed=None, criteria=fem.Criteria())
    search, loop = finished_search(data, "faiman", no_place, None, **how)
    (reported,) = loop.effects
    (choice,) = search.choices.values()
    other = next(n for n in choice.members if n != reported)
    selected = replace(choice, top=choice.members[other], score=choice.scores[other])
    for choices in (search.last.choices, (selected,)):
        search.last = replace(search.last, choices=choices)
        table, *_ = rank_remaining(search, [*loop.finding_objects], [])
        pd.testing.assert_frame_equal(table, loop.ranking)
        assert reported not in table.index and other in table.index


@pytest.mark.parametrize("source", ["measured longwave", "humidity"])
@pytest.mark.parametrize("sensor_fault", ["air_offset", "air_sensor_shield"])
def test_a_fault_of_the_air_thermometer_is_undone_by_its_size(sensor_fault, source):
    """With it the model has equal temperatures by the wrong and by the true air."""
    days = simulator.record(effects=simulator.PHYSICS, days=20, step=600)
    site = simulator.RHINE
    place = Location(site.latitude, site.longitude)
    days = days.join(fem.drivers.sun(days.index, place))
    days[["surface_tilt", "surface_azimuth"]] = site.surface_tilt, site.surface_azimuth
    sky = EFFECTS["sky_radiation"].made(source=source)
    true = ThermalModel(STEADY_MODELS["faiman"], "balance", (sky,))
    values = dict(u0=25.0, u1=4.0, capacity=17e3, bias=0.0)
    values |= {"sky_radiation.share": 1.2}
    change = dated(f"{sensor_fault}_step", at="2022-12-31")
    changed = replace(true, effects=(sky, change), base=dict(values))
    (key,) = change.rows()
    drivers = {name: days[name] for name in true.drivers}
    light, air, wind = (days[name] for name in DRIVERS)
    by = -1.0 if sensor_fault == "air_offset" else light / 1000.0
    expected = true.predict(light, air, wind, values, **drivers)
    wrong = true.predict(light, air + by, wind, values, **drivers)
    found = changed.predict(light, air + by, wind, values | {key: 1.0}, **drivers)
    left, before = ((one - expected).abs().max() for one in (found, wrong))
    assert left < 0.05 * before


def test_a_fit_of_a_change_beside_a_sky_is_the_same_from_its_file(tmp_path):
    """Its base has the sky, and an offset of the air compensates a part of it."""
    data = simulator.record(effects=simulator.PHYSICS, days=60, step=1800)
    change = dated("air_offset_step", at=f"{data.index[len(data) // 2]:%Y-%m-%d}")
    data.loc[data.index[len(data) // 2] :, "temp_air"] -= 1.0
    columns = [data[name] for name in COLUMNS]
    how = dict(model="faiman", dynamics="balance", night=True)
    sky = {"longwave_down": data["longwave_down"]}
    fit = fem.fit_fem(*columns, **how, effects=["sky_radiation", change], **sky)
    assert "sky_radiation.share" in fit.base
    fit.to_json(tmp_path / "fit.json")
    again = fem.FemFit.from_json(tmp_path / "fit.json")
    usual = columns[:3]
    assert again.predict(*usual, **sky).equals(fit.predict(*usual, **sky))
    (key,) = change.rows()
    assert fit.coefficients[key] == pytest.approx(1.0, abs=4 * fit.stderr[key])
