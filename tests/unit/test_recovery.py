"""Effects added to a record, and the findings of the loop."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

import pvlib_fem as fem
from pvlib_fem._cli import main
from pvlib_fem._findings import Finding, Verdict
from pvlib_fem._loop.close import finished_search
from pvlib_fem._record.column_names import is_power
from pvlib_fem._recovery.draw import Draw, Injection, dated_draws
from pvlib_fem._recovery.inject import Injector, readable
from pvlib_fem._recovery.judge import judged
from pvlib_fem._recovery.predict import threshold
from pvlib_fem._recovery.recover import SIZES, planned_injections
from pvlib_fem._recovery.recovery_result import Recovery, middle_of
from pvlib_fem.effects import find
from pvlib_fem.effects._time_profiles import date_text, rows_reaching, weights_of
from pvlib_fem.reasons import Reason, because

USUAL = ["poa_global", "temp_air", "wind_speed", "temp_module"]
DATES = {"at": "2023-04-10"}


@pytest.fixture(scope="module")
def record():
    """A hundred days of the model's own form, with noise that stays for hours."""
    data = fem.datasets.synthetic(100, 3600, "2023-02-01", seed=3, noise=0)
    random = np.random.default_rng(0)
    data["relative_humidity"] = random.uniform(20.0, 90.0, len(data))
    data["power_dc"] = 0.18 * data["poa_global"] + random.normal(size=len(data))
    data["temp_module"] += fem.ewm(random.normal(size=len(data)), 7200.0, step=3600)
    return data


@pytest.fixture(scope="module")
def done(record):
    no_place = fem.drivers.checked_place(None)
    return finished_search(record, "faiman", no_place, None, **how(record))


def how(record):
    given = dict(holdout=None, effects=None, check_units=True, fixed=None)
    return given | {"criteria": fem.Criteria()}


def injection(name, value, **settings):
    parameter = next(iter(find(name).parameters))
    coefficients = {f"{name}.{parameter}": value}
    return Injection(name, 0, settings, coefficients, abs(value), np.nan, 0.0)


@pytest.mark.parametrize(
    ("name", "value", "settings"),
    [
        ("sky_radiation", 0.4, {"source": "humidity, without clouds"}),
        ("anemometer_step", 2.0, DATES),
        ("module_sensor_contact_drift", -0.2, {"since": "2023-02-01"}),
    ],
)
def test_the_response_is_that_of_the_model_with_the_effect(
    record, done, name, value, settings
):
    # by public functions: prediction of a fit with the effect minus one without
    search, loop = done
    put = injection(name, value, **settings)
    change = Injector.from_loop(search, loop).response(put)
    fit, effect = loop.fit, find({"name": name, **settings})
    usual = [record[column] for column in USUAL[:3]]
    larger = replace(fit.thermal_model, effects=(effect,))
    own = {name: record[name] for name in larger.drivers}
    with_it, without = (
        larger.predict(*usual, {**fit.coefficients, **part}, **own)
        for part in (put.coefficients, effect.start)
    )
    assert np.abs(change).max() > 0.3
    np.testing.assert_allclose(change, with_it - without, atol=1e-9)


def test_nothing_is_put_in_at_no_size(record, done):
    injector = Injector.from_loop(*done)
    same = injector.into(record, injection("irradiance_sensor_step", 0.0, **DATES))
    pd.testing.assert_frame_equal(same, record)


def test_an_instrument_that_changes_is_put_into_what_it_reads(record, done):
    injector = Injector.from_loop(*done)
    late = record.index.tz_localize(None) >= pd.Timestamp(DATES["at"])
    faded = injector.into(record, injection("irradiance_sensor_step", 0.1, **DATES))
    fewer = np.where(late, 1.1, 1.0) * faded["poa_global"]
    np.testing.assert_allclose(fewer, record["poa_global"], atol=1e-9)
    # power and the module receive the true irradiance
    others = record.columns.drop("poa_global")
    pd.testing.assert_frame_equal(faded[others], record[others])
    looser = injector.into(
        record, injection("module_sensor_contact_step", 0.1, **DATES)
    )
    others = record.columns.drop("temp_module")
    pd.testing.assert_frame_equal(looser[others], record[others])
    changed = looser["temp_module"] != record["temp_module"]
    assert changed[late].mean() > 0.4 and not changed[~late].any()
    washed = injector.into(record, injection("module_irradiance_step", 0.1, **DATES))
    power = [name for name in record if is_power(name)]
    more = np.where(late, 1.1, 1.0)[:, None] * record[power]
    assert power
    np.testing.assert_allclose(washed[power], more, atol=1e-9)
    assert (washed["temp_module"] > record["temp_module"])[late].mean() > 0.4
    others = record.columns.drop(["temp_module", *power])
    pd.testing.assert_frame_equal(washed[others], record[others])


def test_dirt_is_put_on_the_sensor_or_on_the_modules(record, done):
    """A positive rate is of the sensor; a negative one takes power and heat."""
    rain = (record.index.dayofyear % 30 == 0) & (record.index.hour == 3)
    wet = record.assign(precipitation=np.where(rain, 20.0, 0.0))
    search, loop = finished_search(
        wet, "faiman", fem.drivers.checked_place(None), None, **how(wet)
    )
    injector = Injector.from_loop(search, loop)
    rows = np.arange(len(wet))
    days = (rows - np.maximum.accumulate(np.where(rain, rows, 0))) / 24.0
    sensor = injector.into(wet, injection("soiling", 0.004))
    np.testing.assert_allclose(
        sensor["poa_global"] * (1.0 + 0.004 * days), wet["poa_global"], atol=1e-9
    )
    others = wet.columns.drop("poa_global")
    pd.testing.assert_frame_equal(sensor[others], wet[others])
    modules = injector.into(wet, injection("soiling", -0.004))
    power = wet["power_dc"] * (1.0 - 0.004 * days * (wet["poa_global"] > 0.0))
    np.testing.assert_allclose(modules["power_dc"], power, atol=1e-9)
    noon = wet.index.hour == 12
    assert (modules["temp_module"] < wet["temp_module"])[noon & (days > 5)].all()
    others = wet.columns.drop(["temp_module", "power_dc"])
    pd.testing.assert_frame_equal(modules[others], wet[others])


@pytest.mark.parametrize("size", [0.3, 0.9])
def test_an_anemometer_that_stalls_reads_less_of_weak_wind(record, done, size):
    """With the effect of that size the loss by the reading is that by the wind."""
    injector = Injector.from_loop(*done)
    late = record.index.tz_localize(None) >= pd.Timestamp(DATES["at"])
    u1 = done[1].fit.coefficients["u1"]
    effect = injection("anemometer_stall_step", size * u1, **DATES)
    stalled = injector.into(record, effect)
    others = record.columns.drop("wind_speed")
    pd.testing.assert_frame_equal(stalled[others], record[others])
    read, wind = stalled["wind_speed"].to_numpy(), record["wind_speed"].to_numpy()
    weak = late & (wind < 1.5)
    assert np.array_equal(read[~weak], wind[~weak]) and (read[weak] < wind[weak]).all()
    loss = u1 * read + size * u1 * np.maximum(1.5 - read, 0.0)
    turns = weak & (read > 0.0)
    np.testing.assert_allclose(loss[turns], u1 * wind[turns])
    assert (wind[weak & ~turns] <= size * 1.5).all() and (weak & ~turns).any()


@pytest.mark.parametrize("time_profile", ["step", "drift"])
def test_an_instrument_reads_something_at_any_size_that_is_put_in(
    record, done, time_profile
):
    """An anemometer whose wind would be below nothing has failed, and not changed."""
    search, loop = done
    days = np.unique(search.case.record.dates)
    middle, first = (date_text(day) for day in (days[len(days) // 2], days[0]))
    dates = {"step": {"at": middle}, "drift": {"since": first}}[time_profile]
    effect = find({"name": f"anemometer_{time_profile}", **dates})
    (name,) = effect.rows()
    u1 = loop.fit.coefficients["u1"]
    most = readable(effect, {name: -1.0}, days, {"u1": u1})
    weights = weights_of(effect, days)
    assert (1.0 - most * weights / u1).min() == pytest.approx(0.1)
    assert readable(effect, {name: 1.0}, days, {"u1": u1}) == np.inf
    draw = Draw(effect, 0, {name: -1.0}, readable=most)
    assert draw.most == min(most, -effect.rows()[name].lower)


def test_a_trend_that_is_put_in_becomes_no_more_than_its_fault_can_be():
    effect = find({"name": "mounting_drift", "since": "2016-01-01"})
    most = Draw(effect, 0, {"mounting_drift.per_year": -1.0}).most
    rows = rows_reaching(effect, 8.0)  # years
    of_record = Draw(effect, 0, {"mounting_drift.per_year": -1.0}, bounds=rows).most
    assert (most, of_record) == (0.3, 0.6 / 8.0)


def test_a_class_that_holds_what_was_put_in_is_of_it(record, done):
    """Even if it also holds a change that the record itself shows."""
    step = injection("irradiance_sensor_step", 0.1, **DATES)
    effect = find({"name": "irradiance_sensor_step", **DATES})
    told = finding(
        "irradiance_sensor_step", "irradiance_sensor_drift", place=DATES["at"]
    )
    other = finding("irradiance_sensor_drift")
    fit = SimpleNamespace(effects=(effect,), record=done[0].case.record)
    loop = SimpleNamespace(finding_objects=(told,), fit=fit)
    found = judged(step, effect, loop, baseline=(other,))
    assert found.found and found.first and not found.lost and not found.misled
    # what does not hold it is the record's own
    own = SimpleNamespace(finding_objects=(other,), fit=fit)
    found = judged(step, effect, own, baseline=(other,))
    assert not found.found and not found.reported and not found.lost


def finding(name, *others, place=""):
    verdict = Verdict.AMBIGUOUS if others else Verdict.IDENTIFIED
    (row,) = find(name).rows()
    known = ({row: 0.1}, {row: 0.01}, because(Reason.NO_DATE), ())
    return Finding(name, (name, *others), verdict, 0.5, *known, place=place)


def test_the_threshold_is_where_something_begins_to_pass():
    assert threshold(lambda size: size >= 0.7, 0.01, 10.0) == pytest.approx(0.7, 0.02)
    assert threshold(lambda size: True, 0.01, 10.0) == 0.01
    assert np.isnan(threshold(lambda size: size >= 0.7, 0.01, 0.6))


def test_half_are_found_where_a_curve_has_its_middle():
    random = np.random.default_rng(4)
    held = []
    for middle in random.uniform(0.6, 2.5, 60):
        sizes = np.repeat([0.5, 1.0, 1.5, 2.0, 3.0], 4)
        chance = 1.0 / (1.0 + (sizes / middle) ** (-1.0 / 0.2))
        found = random.uniform(size=len(sizes)) < chance
        low, _, high = middle_of(sizes, found)
        held.append(low <= middle <= high)
    assert np.mean(held) >= 0.8  # of 90 %
    low, half, high = middle_of(np.array([1.0, 2.0]), np.array([False, False]))
    assert half > 2.0 and high > 3.0 and low > 1.0


@pytest.fixture(scope="module")
def recovery(record):
    how = dict(sizes=(0.3, 2.0), draws=1, processes=1, progress=False)
    return fem.recover_effects(record, ["sky_radiation", "module_offset_step"], **how)


def test_what_is_twice_the_predicted_size_is_found_and_a_third_is_not(recovery):
    table = recovery.table.set_index(["effect", "multiple"])
    assert table["found"].loc[:, 2.0].all()
    assert not table["found"].loc[:, 0.3].any()
    assert not table["wrong"].map(bool).any()
    named = table.loc[("sky_radiation", 2.0)]
    assert named["first"] and named["ratio"] == pytest.approx(1.0, abs=0.25)
    assert named["in_range"] == 1.0
    assert abs(named["ratio"] - 1.0) <= named["half_range"] < 2.0
    assert recovery.summary["found"].tolist() == [0.0, 1.0, 0.0, 1.0]
    middle = recovery.half
    assert (middle["lower"] < middle["multiple"]).all()
    assert "found from 1.5 × the predicted size on: 2 of 2" in str(recovery)


def test_a_file_has_all_of_it_and_the_rest_is_done_another_time(record, tmp_path):
    path = tmp_path / "recovery.json"
    how = dict(effects="sky_radiation", sizes=(0.3, 0.8, 2.0), progress=False)
    whole = fem.recover_effects(record, **how, processes=1, path=path)
    text = path.read_text(encoding="utf-8")
    assert text == whole.to_json() + "\n"
    assert Recovery.from_json(path).to_json() == whole.to_json()
    # two are lost; the file has the other, and two processes make the same to the bit
    short = replace(whole, outcomes=whole.outcomes[1:2])
    short.to_json(path)
    assert "1 injections of 3 planned" in str(short)
    again = fem.recover_effects(record, **how, processes=2, path=path)
    assert again.to_json() + "\n" == text == path.read_text(encoding="utf-8")
    with pytest.raises(ValueError, match=r"call with seed=0, and this one has 1"):
        fem.recover_effects(record, **how, seed=1, path=path)
    with pytest.raises(ValueError, match=r"call with effects='sky_radiation', and"):
        fem.recover_effects(record, **how | {"effects": "rain"}, path=path)
    with pytest.raises(ValueError, match=r"call with tried=the default, and"):
        fem.recover_effects(record, **how, tried="sky_radiation", path=path)
    with pytest.raises(ValueError, match="of another record"):
        fem.recover_effects(record - 0.001, **how, path=path)


def test_what_cannot_be_put_in_is_said(record):
    how = dict(processes=1, progress=False, draws=1)
    with pytest.raises(ValueError, match=r"nothing to put into.*rain: .*precipitation"):
        fem.recover_effects(record, "rain", **how)
    with pytest.raises(ValueError, match="sizes has rain"):
        fem.recover_effects(record, "sky_radiation", sizes={"rain": [1.0]}, **how)
    with pytest.raises(ValueError, match=r"size of 9 is not possible.*at most 3"):
        fem.recover_effects(record, sizes={"sky_radiation": [9.0]}, **how)
    for sizes in (3.0, {"sky_radiation": 3.0}):
        with pytest.raises(ValueError, match=r"sizes has 3.0; give a sequence"):
            fem.recover_effects(record, sizes=sizes, **how)
    with pytest.raises(ValueError, match="draws = 0; give 1 or more"):
        fem.recover_effects(record, **how | {"draws": 0})


def test_draws_differ_by_seed_and_not_by_what_else_is_put_in(record, done):
    search, loop = done
    names = ["module_sensor_contact_step", "sky_radiation"]
    first, _ = planned_injections(search, loop, names[:1], [1.0], 1, 0)
    both, _ = planned_injections(search, loop, names, [1.0], 2, 0)
    assert [one.key for one in first] == [one.key for one in both][:1]
    assert len({one.dates for one in both if one.dates}) == 2
    # an effect without date and sign is there once
    assert [one.effect for one in both].count("sky_radiation") == 1
    days = np.unique(search.case.record.dates[search.case.searched])
    steps = [
        dated_draws(find("module_sensor_contact_step"), days, 21, 3, seed)[0]
        for seed in (0, 1)
    ]
    assert len({draw.effect.settings["at"] for some in steps for draw in some}) > 3


def test_the_command_puts_into_a_file_what_recover_puts_into_a_frame(record, tmp_path):
    path, out = tmp_path / "plant.csv", tmp_path / "recovery.json"
    data = record[[*USUAL, "relative_humidity"]].tz_localize(None)
    data.to_csv(path)
    told = ["--effects", "sky_radiation", "--processes", "1", "--out", str(out)]
    said = CliRunner().invoke(main, ["recover", str(path), *told])
    assert said.exit_code == 0, said.output
    found = Recovery.from_json(out)
    assert str(found) in said.output
    assert found.table["effect"].unique().tolist() == ["sky_radiation"]
    assert tuple(found.table["multiple"]) == SIZES
    assert found.given["draws"] == "3" and found.given["effects"] == "['sky_radiation']"


def test_the_picture_has_the_shares_by_size(recovery):
    pytest.importorskip("matplotlib")
    axes = recovery.plot()
    shares = recovery.summary["found"]
    lines = axes.get_lines()[: shares.index.unique("effect").size]
    assert lines
    for line in lines:
        part = shares[line.get_label()]
        np.testing.assert_array_equal(line.get_xdata(), part.index)
        np.testing.assert_array_equal(line.get_ydata(), part)
    axes.figure.clear()


def test_the_legend_of_many_effects_covers_no_line(recovery):
    pytest.importorskip("matplotlib")
    one = recovery.outcomes[0]
    many = [
        replace(
            one, injection=replace(one.injection, effect=f"a_long_name_{i}_episode")
        )
        for i in range(35)
    ]
    axes = replace(recovery, outcomes=tuple(many)).plot()
    axes.figure.draw_without_rendering()
    frame, legend = axes.get_window_extent(), axes.get_legend().get_window_extent()
    assert legend.y1 <= frame.y0 and frame.height > legend.height
    assert legend.x0 >= 0.0 and legend.x1 <= axes.figure.bbox.x1
    assert legend.y0 >= 0.0
    axes.figure.clear()


def test_a_size_that_none_predicted_is_a_dash(recovery):
    """Sizes may be given where no possible size should be found."""
    one = recovery.outcomes[0]
    unknown = replace(one, injection=replace(one.injection, predicted=np.nan))
    text = str(replace(recovery, outcomes=(unknown,)))
    assert "nan" not in text.lower() and "0 of 0" in text
