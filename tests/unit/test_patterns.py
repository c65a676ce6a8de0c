"""Errors that repeat without a known cause are in the predictions."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from pvlib.location import Location

import pvlib_fem as fem
from pvlib_fem import simulator
from pvlib_fem._loop.results.predicted_patterns import Pattern
from pvlib_fem._record.inputs import read
from pvlib_fem._statements.worth import energies as energies_of
from pvlib_fem._statistics.axes import Axis, axes, sorted_by
from pvlib_fem._statistics.tables import Cells
from pvlib_fem.scores import GAMMA
from pvlib_fem.simulator import PHYSICS, RHINE

PLACE = dict(
    location=Location(RHINE.latitude, RHINE.longitude, tz=RHINE.tz),
    surface_tilt=35,
    surface_azimuth=180,
)
USUAL = ["poa_global", "temp_air", "wind_speed", "temp_module"]


def record(**hidden):
    """Half a year of a simulated world."""
    how = dict(days=200, step=1800, seed=4, start="2023-04-01")
    data = simulator.record(effects=PHYSICS | hidden, **how)[USUAL]
    data.attrs = {}
    return data


@pytest.fixture(scope="module")
def closed():
    """A fan that blows warm air at the modules at weekends, which no column has."""
    data = record(weekend_exhaust=2.0)
    return data, fem.close_loop(data, **PLACE)


def test_they_take_most_of_an_unknown_cause_out_of_test_weeks(closed):
    _, loop = closed
    without = fem.close_loop(record(), **PLACE).table["rmse_test"].iloc[-1]
    table = loop.table["rmse_test"]
    assert table.index[-1] == "+patterns" and loop.last != "+patterns"
    causes, patterns = table[loop.last] ** 2, table["+patterns"] ** 2
    assert causes > 4.0 * without**2
    assert causes - patterns > 0.75 * (causes - without**2)


def test_what_rain_leaves_behind_follows_the_time_since_rain():
    """Wet ground behind the modules, for a day or two; no column has it."""
    how = dict(days=300, step=1800, seed=4, start="2023-03-01")
    site = replace(RHINE, rain_days=0.3)
    data = simulator.record(site, effects=PHYSICS | {"puddles": 3.0}, **how)
    data = data[[*USUAL, "precipitation"]]
    loop = fem.close_loop(data, **PLACE)
    assert loop.patterns[0].name == "hours_since_rain × poa_global"
    before, after = (loop.table.loc[n, "rmse_test"] for n in (loop.last, "+patterns"))
    assert after**2 < 0.5 * before**2
    (text,) = (t for t in loop.statements["text"] if "after rain" in t)
    assert "from 0 to " in text and "colder than modelled" in text
    dry = data.assign(precipitation=0.0)
    with pytest.raises(ValueError, match="precipitation"):
        loop.predict(data[USUAL[:3]])
    wet = (loop.predict(data) - loop.predict(dry))[data["poa_global"] > 500.0]
    assert wet.min() < -0.5 and wet.max() < 0.5


def test_they_are_those_that_are_reported(closed):
    _, loop = closed
    assert [one.effect for one in loop.unexplained]
    assert {one.name for one in loop.patterns} == {
        one.effect for one in loop.unexplained
    }


def test_predictions_have_the_error_of_the_table(closed):
    data, loop = closed
    rows = loop.fit.holdout
    for patterns, step in ((True, "+patterns"), (False, loop.last)):
        rest = loop.residual(data, patterns=patterns)[rows]
        found = np.sqrt(np.mean(rest**2))
        assert found == pytest.approx(loop.table.loc[step, "rmse_test"], rel=1e-3)


def test_a_pattern_is_worth_what_it_adds_to_predictions(closed):
    data, loop = closed
    hours = data["poa_global"] / 1000.0 * 0.5
    energies = loop.statements.set_index("cause")["energy"]
    for one in loop.patterns:
        alone = replace(loop, patterns=(one,))
        added = alone.predict(data) - alone.predict(data, patterns=False)
        change = np.abs(GAMMA * hours * added).sum() * 365.2425 / 200
        assert energies[one.name] == pytest.approx(change, rel=0.01) and change > 0.1
        nothing = replace(one, means=(0.0,) * len(one.means))
        assert energies_of(replace(loop, patterns=(nothing,)))[one.name] == 0.0
    added = loop.statements[loop.statements["verdict"] != "hint"]
    assert (np.diff(added["energy"]) <= 0.0).all()  # the most valuable first


def test_contributions_add_up(closed):
    data, loop = closed
    parts = loop.contributions(data)[[one.name for one in loop.patterns]]
    both = [loop.predict(data, patterns=patterns) for patterns in (True, False)]
    np.testing.assert_allclose(parts.sum(axis=1), both[0] - both[1], atol=1e-9)


def test_no_test_week_decides(closed):
    data, loop = closed
    test = (loop.weeks == "test").to_numpy()
    data = data.assign(temp_module=data["temp_module"] + 5.0 * test)
    again = fem.close_loop(data, **PLACE)
    for one, other in zip(loop.patterns, again.patterns, strict=True):
        np.testing.assert_array_equal(one.means, other.means)


def test_a_file_keeps_them(closed, tmp_path):
    data, loop = closed
    loop.to_json(tmp_path / "loop.json")
    again = fem.Loop.from_json(tmp_path / "loop.json")
    pd.testing.assert_series_equal(again.predict(data), loop.predict(data))


WRONG = [
    (lambda c: c["means"].pop(), r"\d+ means for \d+ cells"),
    (lambda c: c["axes"][0]["cuts"].pop(), r"\d+ cuts for \d+ bins"),
    (lambda c: c["axes"][0]["cuts"].reverse(), "the cuts of hour do not rise"),
    (lambda c: c["axes"][0].update(name="era"), "era is none of hour, weekend, month"),
]


@pytest.mark.parametrize(("damage", "message"), WRONG)
def test_a_table_of_a_file_that_is_not_whole_is_refused(
    closed, tmp_path, damage, message
):
    closed[1].to_json(path := tmp_path / "loop.json")
    content = json.loads(path.read_text("utf-8"))
    damage(content["patterns"][0])
    path.write_text(json.dumps(content), "utf-8")
    with pytest.raises(ValueError, match=rf"loop.json: patterns.0 .*{message}"):
        fem.Loop.from_json(path)


def test_hours_are_those_of_the_record_in_any_zone(closed):
    data, loop = closed
    elsewhere = data.tz_convert("America/Denver")
    found = loop.predict(elsewhere).to_numpy()
    np.testing.assert_allclose(found, loop.predict(data), rtol=1e-12)


def test_they_are_of_this_plant(closed):
    data, loop = closed
    given = {**PLACE, "surface_tilt": 10}
    found = loop.predict(data, **given)
    pd.testing.assert_series_equal(found, loop.predict(data, patterns=False, **given))
    assert (loop.predict(data, patterns=True, **given) - found).abs().max() > 1.0


def test_the_own_plane_in_columns_or_again_is_the_same_plane(closed):
    data, loop = closed
    whole = loop.predict(data)
    assert (loop.predict(data, **PLACE) == whole).all()
    turned = data.assign(surface_tilt=35.0, surface_azimuth=180.0)
    assert (loop.predict(turned) == whole).all()
    by_columns = fem.close_loop(turned, location=PLACE["location"])
    assert by_columns.patterns
    assert (by_columns.predict(turned) == by_columns.predict(data)).all()
    # patterns are left out in another plane, of all three alike
    other = turned.assign(surface_tilt=20.0)
    apart = [loop.predict(data, patterns=False), loop.predict(other)]
    assert (apart[0] == apart[1]).all() and (apart[0] != whole).any()
    assert list(loop.contributions(other)) == [e.name for e in loop.fit.effects]


@pytest.mark.parametrize("method", ["predict", "residual"])
def test_an_argument_that_is_none_of_a_place_is_refused(closed, method):
    data, loop = closed
    with pytest.raises(ValueError, match=r"surface_tlit is no .* 'surface_tilt'"):
        getattr(loop, method)(data, surface_tlit=20.0)


def test_a_record_of_noise_has_none():
    data = record()
    base = fem.fem_temperature(
        *(data[name] for name in USUAL[:3]), model="faiman", u0=25, u1=6, tau=300
    )
    random = np.random.default_rng(0)
    for _ in range(5):
        noise = random.normal(0.0, 1.0, len(data))
        loop = fem.close_loop(data.assign(temp_module=base + noise), **PLACE)
        assert loop.patterns == () and "+patterns" not in loop.table.index


def test_a_short_record_has_none():
    data = record(weekend_exhaust=4.0)[: 48 * 40]
    loop = fem.close_loop(data, **PLACE)
    assert loop.unexplained and loop.patterns == ()


def test_a_driver_that_is_missing_is_named():
    data = record()
    wet = np.random.default_rng(1).integers(0, 2, len(data) // 48 + 1)
    wet = np.repeat(wet, 48)[: len(data)].astype(float)
    late = np.roll(wet, 48)  # nothing that its own effect explains
    heat = 6.0 * (wet != late) * (data.index.hour < 5)
    data = data.assign(temp_module=data["temp_module"] + heat, gate=wet - late)
    loop = fem.close_loop(data.assign(gate=np.abs(data["gate"])), effects="rain")
    assert any("gate" in one.drivers for one in loop.patterns)
    without = data.drop(columns="gate")
    with pytest.raises(ValueError, match="no column gate, which unexplained patterns"):
        loop.predict(without)
    found = loop.predict(without, fallback=True)
    assert found.notna().all()


@pytest.mark.parametrize("name", ["temp_air", "wind_direction", "solar_azimuth"])
def test_an_axis_sorts_its_own_values_as_it_did(name):
    random = np.random.default_rng(3)
    values = random.uniform(0.0, 359.0, 4000)
    values[::7] = np.nan if name != "solar_azimuth" else 180.0
    axis = sorted_by(name, values)
    np.testing.assert_array_equal(axis.numbers(values), axis.bins)
    assert axis.numbers(np.array([-1e9, 1e9])).min() >= 0


def test_hours_months_and_weekends_are_axes_of_their_numbers():
    times = pd.date_range("2023-01-01", periods=24 * 365, freq="h")
    clock = {"hour": times.hour, "month": times.month, "weekend": times.day_of_week > 4}
    clock = {name: np.asarray(column) for name, column in clock.items()}
    dates = times.to_numpy().astype("datetime64[D]").astype(int)
    found = {axis.name: axis.bins for axis in axes(clock, dates)}
    np.testing.assert_array_equal(found["hour"], times.hour)
    np.testing.assert_array_equal(found["month"], times.month - 1)
    np.testing.assert_array_equal(found["weekend"], times.day_of_week > 4)


def test_a_missing_value_has_no_error():
    labels = ((0.0, 10.0), (10.0, 20.0))
    cold = Axis("temp_air", labels=labels, column="temp_air", cuts=(10.0,))
    pattern = Pattern((cold,), (1.0, -2.0))
    times = pd.date_range("2023-01-01", periods=4, freq="h")
    air = pd.Series([5.0, 15.0, np.nan, 40.0], times)
    found = pattern.at(read({"temp_air": air}))
    np.testing.assert_array_equal(found, [1.0, -2.0, 0.0, -2.0])


def test_a_mean_is_shrunk_by_its_uncertainty():
    """With few weeks a cell's mean counts less: by Var / (Var + noise / rows)."""
    random = np.random.default_rng(5)
    times = pd.date_range("2023-01-02", periods=24 * 7 * 52, freq="h")
    weeks = np.arange(len(times)) // (24 * 7)
    hours = np.asarray(times.hour)
    axis = sorted_by("x", hours + 0.5)
    truth = random.normal(0.0, 1.0, 24)[hours]
    noisy = truth + random.normal(0.0, 3.0, len(times))
    table = Cells.from_axes((axis,), np.ones(len(times)), weeks).table(noisy)
    assert (table.shares < 1.0).all() and table.shares.mean() > 0.9
    few = slice(0, 24 * 7 * 3)
    cut = replace(axis, bins=axis.bins[few])
    short = Cells.from_axes((cut,), np.ones(few.stop), weeks[few]).table(noisy[few])
    assert short.shares.mean() < table.shares.mean()


def test_a_prediction_needs_no_power():
    """Where power is missing for hours, the error follows it, and no pattern does."""
    data = record()
    hours = np.asarray(data.index.hour)
    off = (hours >= 11) & (hours < 15) & (np.asarray(data.index.day_of_week) < 3)
    power = np.where(off, 0.0, 0.18 * data["poa_global"] * 20.0)
    warm = data["temp_module"] + 4.0 * off * (data["poa_global"] > 300.0)
    data = data.assign(temp_module=warm, power_dc=power)
    loop = fem.close_loop(data, effects="rain")
    assert loop.patterns
    assert not [one for one in loop.patterns if "power_dc" in one.drivers]
    assert loop.predict(data.drop(columns="power_dc")).notna().all()
