"""Outages and covers by a plant's power: which effect, which hours, and none else."""

import json
import re
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import study_events

import pvlib_fem as fem
from pvlib_fem._budget.covers_and_outages import Hours, event_spans, rows_of_events
from pvlib_fem._budget.stretch_noise import DayNoise, Noise
from pvlib_fem._findings import Verdict
from pvlib_fem._loop.references.power_events import EVENTS, true_over_read
from pvlib_fem._record.inputs import as_record
from pvlib_fem._report.event_text import all_of
from pvlib_fem.drivers import derive_drivers
from pvlib_fem.effects import EFFECTS, find
from pvlib_fem.simulator import PHYSICS

SEED = 4
PLANT = 33.0  # m²


def record(seed=SEED, days=365, **effects):
    """Simulated physics by the half hour, with the power of a plant."""
    data = fem.simulator.record(
        effects=PHYSICS | effects, days=days, step=1800, seed=seed
    )
    data["power_ac"] = PLANT * data["p_dc_per_area"]
    return data.drop(columns=["p_dc_per_area", "longwave_down", "snow_depth"])


@pytest.fixture(scope="module")
def clean():
    return record()


def covered(data, rows, left):
    """Modules with that part of the light; a string has the square of it."""
    over = data["temp_module"] - data["temp_air"]
    data.loc[rows, "temp_module"] -= (1.0 - left) * over[rows]
    data.loc[rows, "power_ac"] *= left**2


def sensor_covered(data, rows, left):
    data.loc[rows, "poa_global"] *= left


def outage(data, rows, left):
    """Modules that are warmer by a fifth, without power."""
    over = data["temp_module"] - data["temp_air"]
    data.loc[rows, "temp_module"] += 0.2 * over[rows]
    data.loc[rows, "power_ac"] = -0.5


HAPPENS = {
    "modules_covered": covered,
    "sensor_covered": sensor_covered,
    "outage": outage,
}


def bright_days(data, count, seed=0, first=10, last=16):
    """Rows from 10 to 16 h of some days with light, apart from each other."""
    day = data.between_time(f"{first}:00", f"{last - 1}:59")
    means = day["poa_global"].resample("D").mean()
    bright = means.index[means > 400.0][::2]
    chosen = np.random.default_rng(seed).choice(len(bright), count, replace=False)
    for start in bright[np.sort(chosen)]:
        hours = [start + pd.Timedelta(hours=hour) for hour in (first, last)]
        yield (data.index >= hours[0]) & (data.index < hours[1])


def with_events(data, kind, count=20, left=0.6, seed=0):
    data, places = data.copy(), [*bright_days(data, count, seed)]
    for rows in places:
        HAPPENS[kind](data, rows, left)
    return data, places


@pytest.mark.parametrize("kind", HAPPENS)
def test_events_of_six_hours_are_found_as_what_they_are(clean, kind):
    data, places = with_events(clean, kind)
    events = fem.close_loop(data).events
    assert set(events["effect"]) == {kind}
    found = 0
    for rows in places:
        times = data.index[rows]
        own = events[(events["start"] <= times[-1]) & (events["end"] >= times[0])]
        found += len(own) == 1 and own["hours"].iloc[0] >= 5
    assert found >= 0.9 * len(places)
    assert len(events) <= len(places)
    way = {"modules_covered": -1.0, "sensor_covered": 1.0, "outage": 1.0}[kind]
    assert (way * events["size"] > 1.0).all()


@pytest.mark.parametrize("seed", [SEED, 5])
@pytest.mark.parametrize(
    "effects", [{}, {"soiling_sensor": 1.0}, {"sky_radiation": 1.0, "rain": 1.0}]
)
def test_a_record_without_events_has_at_most_one_a_year(seed, effects):
    loop = fem.close_loop(record(seed, **effects))
    assert len(loop.events) <= 1
    assert not {*loop.effects} & {*HAPPENS}


# ------------------------------------------------------------------ the noise
def days_of_noise(of_days, of_hours, days=400, seed=3):
    """A residual of ten hours a day with errors of whole days, and of hours. [K]"""
    random = np.random.default_rng(seed)
    number = (24 * np.arange(days)[:, None] + np.arange(7, 17)).ravel()
    values = np.repeat(random.normal(0.0, of_days, days), 10)
    return number, values + random.normal(0.0, of_hours, len(number))


def test_noise_of_a_stretch_is_what_the_rest_of_its_day_leaves():
    """By the variances of both: a conditional standard deviation of normal errors."""
    number, values = days_of_noise(of_days := 1.5, of_hours := 1.0)
    noise = DayNoise(values, number, np.ones(len(number), dtype=bool))
    own, rest = (of_days**2 + of_hours**2 / n for n in (6, 4))
    left = np.sqrt(own - of_days**4 / rest)
    found = [noise.beyond(slice(10 * day + 2, 10 * day + 8)) for day in range(50)]
    assert [sure for _, sure in found] == pytest.approx([left] * 50, rel=0.2)
    assert np.std([size for size, _ in found]) == pytest.approx(left, rel=0.3)
    assert left < 0.5 * np.sqrt(own)


def test_an_event_is_no_part_of_what_is_expected_of_its_own_day():
    number, values = days_of_noise(of_days=1.5, of_hours=0.5)
    usual = np.ones(len(number), dtype=bool)
    usual[100:110] = False  # all of one day
    values[100:110] -= 5.0
    size, noise = DayNoise(values, number, usual).beyond(slice(100, 110))
    assert size == pytest.approx(values[100:110].mean())
    assert noise == pytest.approx(np.hypot(1.5, 0.5 / np.sqrt(10)), rel=0.2)


def test_few_days_have_the_noise_of_all_hours():
    number, values = days_of_noise(1.0, 1.0, days=20)
    noise = DayNoise(values, number, np.ones(len(number), dtype=bool))
    some = slice(42, 46)
    assert noise.beyond(some) == (values[some].mean(), Noise(values).std_of_mean(4))


def test_modules_that_are_covered_evenly_are_found_on_days_that_are_off(clean):
    """A ninth of light and power; the model is off by kelvins on each day."""
    data = clean.copy()
    random = np.random.default_rng(2)
    day = (data.index - data.index[0]).days.to_numpy()
    off = random.normal(0.0, 1.2, day.max() + 1)[day]
    data["temp_module"] += np.where(data["poa_global"] > 50.0, off, 0.0)
    over, places = data["temp_module"] - data["temp_air"], [*bright_days(data, 20)]
    for rows in places:
        data.loc[rows, "temp_module"] -= 0.11 * over[rows]
        data.loc[rows, "power_ac"] *= 0.89
    events = fem.close_loop(data).events
    found = sum(
        bool(((events["start"] <= some[-1]) & (events["end"] >= some[0])).any())
        for some in (data.index[rows] for rows in places)
    )
    assert set(events["effect"]) == {"modules_covered"}
    assert found >= 0.8 * len(places) and len(events) <= len(places) + 1


def test_power_alone_is_underperformance(clean):
    """A plant that loses half of the power, with a module as warm as before."""
    data, places = clean.copy(), [*bright_days(clean, 20)]
    for rows in places:
        data.loc[rows, "power_ac"] *= 0.5
    loop = fem.close_loop(data)
    assert set(loop.events["effect"]) == {"underperformance"}
    assert 0.9 * len(places) <= len(loop.events) <= len(places)
    assert loop.events["power"].between(0.45, 0.6).all()
    assert loop.events["size"].abs().max() < 1.5
    lost = (clean["power_ac"] - data["power_ac"]).sum() * 0.5 / at_standard(clean)
    assert loop.events["energy"].sum() == pytest.approx(lost, rel=0.1)
    # the temperature has nothing to explain
    assert not {*loop.effects} & {*HAPPENS, "electrical_output"}
    (one,) = (s for s in loop.statements.itertuples() if s.verdict == "event")
    assert one.device == "plant" and "temperature sensor was not covered" in one.text
    page = loop.to_html()
    assert "strings disconnected" in page and "Measured power, and power expec" in page


@pytest.mark.parametrize("afternoon, spans", [(0, [(0, 28)]), (1, [(0, 4), (24, 28)])])
def test_an_event_ends_where_power_deviates_the_other_way(afternoon, spans):
    """A power meter whose clock is late reads too little, then too much."""
    state = np.repeat([-1, afternoon, -1], [4, 20, 4])
    kinds = np.where(state < 0, "underperformance", "").astype(object)
    assert event_spans(kinds, np.zeros(28, dtype=bool), state) == spans


def test_months_with_two_thirds_of_the_power_are_told_by_few_events(clean):
    """Dull days, on which the temperature shows nothing, are part of them."""
    data = clean.copy()
    months = (data.index >= "2023-05-01") & (data.index < "2023-08-01")
    data.loc[months, "power_ac"] *= 2.0 / 3.0
    events = fem.close_loop(data).events
    energy = events.groupby("effect")["energy"].sum()
    assert energy["underperformance"] > 0.98 * energy.sum() and len(events) < 30
    assert events["hours"].max() > 200
    lost = (clean["power_ac"] - data["power_ac"]).sum() * 0.5 / at_standard(clean)
    assert events["energy"].sum() == pytest.approx(lost, rel=0.1)


def test_an_outage_of_days_is_one_event(clean):
    data = clean.copy()
    rows = (data.index >= "2023-07-03 11:00+01:00") & (
        data.index < "2023-07-06 15:00+01:00"
    )
    outage(data, rows, 0.0)
    (row,) = fem.close_loop(data).events.to_dict("records")
    assert row["effect"] == "outage"
    assert abs(row["start"] - data.index[rows][0]) <= pd.Timedelta(hours=1)
    assert abs(row["end"] - data.index[rows][-1]) <= pd.Timedelta(hours=1)
    assert row["power"] < 0.01 and row["hours"] >= 40


# ------------------------------------------------------------------ what they are worth
YEARS = 365.2425 / 365  # in the record


def at_standard(data, name="power_ac"):
    """Power at 1000 W/m² and 25 °C, by bright rows of a plant without events."""
    warm = 1.0 - 0.004 * (data["temp_module"] - 25.0)
    bright = data["poa_global"] > 700.0
    return (data[name] / (data["poa_global"] / 1000.0 * warm))[bright].median()


@pytest.mark.parametrize("kind", HAPPENS)
def test_the_energy_of_events_is_the_power_that_the_plant_had_without_them(clean, kind):
    """Or, of a covered sensor, the power that its irradiance does not explain."""
    data, places = with_events(clean, kind)
    loop = fem.close_loop(data)
    rows = np.any(places, axis=0)
    without = clean["power_ac"] * 0.6 if kind == "sensor_covered" else data["power_ac"]
    change = (clean["power_ac"] - without)[rows].sum() * 0.5 / at_standard(clean)
    assert loop.events["energy"].sum() == pytest.approx(change, rel=0.05)
    (one,) = (s for s in loop.statements.itertuples() if s.verdict == "event")
    assert one.energy == pytest.approx(loop.events["energy"].sum() * YEARS)
    # of the modules alone it is far more than the temperature changes
    # light that the sensor does not see may also be a reflection onto the modules
    verdict = "ambiguous" if kind == "sensor_covered" else "identified"
    (effect,) = (s for s in loop.statements.itertuples() if s.verdict == verdict)
    assert (
        effect.cause.startswith(one.cause) and loop.yearly_energy[kind] == effect.energy
    )
    assert effect.energy < (0.05 if kind == "outage" else 1.0) * one.energy


def test_weeks_of_snow_on_frozen_modules_are_events():
    """No fit has these hours; those without snow between them are as usual."""
    cold = dict(temp_mean=4.0, temp_amplitude=12.0, rain_days=0.35)
    site = fem.simulator.Site(latitude=47.0, longitude=11.0, **cold)
    scenarios = [PHYSICS | {"snow": size} for size in (0.0, 1.0)]
    without, data = fem.simulator.records(site, scenarios, 365, 900.0, 77)
    lost = without["p_dc_per_area"] - data["p_dc_per_area"]
    frozen = data["temp_module"] < 0.0
    assert lost[frozen].sum() > 0.5 * lost.sum()
    loop = fem.close_loop(data.drop(columns=["snow_depth", "longwave_down"]))
    events = loop.events
    assert set(events["effect"]) == {"modules_covered"}
    within = pd.Series(False, data.index)
    for start, end in zip(events["start"], events["end"]):
        within[start:end] = True
    assert lost[within].sum() > 0.95 * lost.sum()
    change = lost.sum() * 0.25 / at_standard(without, "p_dc_per_area")
    assert events["energy"].sum() == pytest.approx(change, rel=0.1)
    # what they take off the error that is reported is less than that
    assert np.hypot.reduce(events["gain"]) < loop.table["rmse_train"]["balance"]


def test_the_gain_of_an_event_is_what_its_mean_takes_off_the_error(clean):
    data = clean.copy()
    (rows,) = bright_days(data, 1)
    outage(data, rows, 0.0)
    loop = fem.close_loop(data)
    (event,), (one,) = (
        loop.events.to_dict("records"),
        (s for s in loop.statements.itertuples() if s.verdict == "event"),
    )
    assert "outage" not in loop.effects  # so that the residual has it
    residual = loop.fit.residual.dropna()
    within = residual[event["start"] : event["end"]]
    rest = residual.copy()
    rest[within.index] -= within.mean()
    fall = (residual**2).mean() - (rest**2).mean()
    assert one.gain == event["gain"] == pytest.approx(np.sqrt(fall), rel=0.02)


def test_a_sensor_that_reads_less_does_not_change_what_outages_are_worth(clean):
    """What the plant should give is by the light that the loop finds it had."""
    data, places = with_events(clean, "outage")
    late = data.index >= "2023-08-01"
    data.loc[late, "poa_global"] *= 0.8
    loop = fem.close_loop(data)
    assert any(name.startswith("irradiance_sensor") for name in loop.effects)
    rows = np.any(places, axis=0) & late
    lost = clean["power_ac"][rows].sum() * 0.5 / at_standard(clean)
    events = loop.events[loop.events["start"] >= "2023-08-01"]
    assert set(events["effect"]) == {"outage"}
    assert events["energy"].sum() == pytest.approx(lost, rel=0.05)


def test_power_is_expected_of_the_light_that_a_soiled_sensor_does_not_read(clean):
    """With a fault of the sensor from a day on, too."""
    inputs = as_record(**dict(clean.items())).inputs
    at = str(clean.index[4800])[:10]
    effects = EFFECTS["soiling"], find({"name": "irradiance_sensor_step", "at": at})
    rows = (name for effect in effects for name in effect.rows())
    step = SimpleNamespace(coefficients=dict.fromkeys(rows, 0.005))
    ratio = true_over_read(step, SimpleNamespace(effects=effects), inputs)
    (name,) = (one for one in EFFECTS["soiling"].drivers if one != "poa_global")
    days = derive_drivers(inputs, [name])[name]
    changed = np.where(clean.index >= at, 1.005, 1.0)
    lit = clean["poa_global"].to_numpy() > 0.0
    want = (1.0 + 0.005 * days) * changed
    np.testing.assert_allclose(ratio[lit], want[lit], rtol=1e-9)
    assert np.ptp(days[lit]) > 5.0


def test_dull_light_of_which_power_is_not_known_shows_no_covered_sensor(clean):
    """Losses at 180 W/m² are taken for a consumption, which the plant has not below."""
    dim = 1.0 - 0.25 * np.exp(-(((clean["poa_global"] - 180.0) / 80.0) ** 2))
    assert fem.close_loop(clean.assign(power_ac=clean["power_ac"] * dim)).events.empty


def test_hours_as_expected_are_worth_nothing():
    """And each hour with another power is worth what it lacks or has more."""
    times = pd.date_range("2023-06-01 08:00", periods=8, freq="30min", tz="Etc/GMT-1")
    some = np.full(8, 500.0)
    change = np.array([0.0, 0.0, 0.0, 0.0, -0.1, -0.1, 0.3, 0.1])
    columns = dict.fromkeys(("seen", "shown", "power", "expected"), some)
    columns |= {"residual": 10.0 * change, "energy": change, "portion": some / 5e4}
    columns |= {"loss": some, "off": 0.0 * some}
    hours = Hours.from_columns(times, np.ones(8, dtype=bool), columns, {})
    kinds = np.array(["outage"] * 2 + ["sensor_covered"] * 2)
    rows = rows_of_events(hours, [(0, 2), (2, 4)], kinds, 1.0)
    nothing, event = sorted(rows, key=lambda row: row["energy"])
    assert nothing["energy"] == nothing["gain"] == 0.0
    assert event["energy"] == pytest.approx(0.6)
    # four rows of a hundred, with a mean of 0.5 K
    assert event["gain"] == pytest.approx(np.sqrt(0.04) * 0.5)


def test_a_file_without_their_energy_is_read(snowed, tmp_path):
    """As written before events had one."""
    content = json.loads(snowed.to_json())
    for event in content["events"]:
        del event["energy"], event["gain"]
    path = tmp_path / "loop.json"
    path.write_text(json.dumps(content))
    again = fem.Loop.from_json(path)
    assert again.events["energy"].isna().all() and "kWh/kWp lost" not in again.report()
    (one,) = (s for s in again.statements.itertuples() if s.verdict == "event")
    assert np.isnan(one.energy)
    kept = {name: snowed.yearly_energy[name] for name in again.yearly_energy}
    assert "modules_covered" in kept and again.yearly_energy == kept


@pytest.fixture(scope="module")
def snowed(clean):
    """A tenth of the days with covered modules."""
    return fem.close_loop(with_events(clean, "modules_covered", 36, 0.4)[0])


def test_power_per_area_shows_them_as_the_power_of_a_plant_does(clean, snowed):
    data = with_events(clean, "modules_covered", 36, 0.4)[0]
    data["p_dc_per_area"] = data.pop("power_ac") / PLANT
    loop = fem.close_loop(data)
    assert "modules_covered" in loop.effects
    for kind in ("start", "end", "hours", "effect"):
        assert (loop.events[kind] == snowed.events[kind]).all()
    np.testing.assert_allclose(loop.events["energy"], snowed.events["energy"], 1e-3)


def test_the_study_of_events_sees_what_decides(clean):
    hours, spread, shares = study_events.decided(clean)
    assert len(hours.number) > 3000 and 0.0 < spread < 0.1 and {*shares} == {*HAPPENS}
    assert 0.0 < study_events.noise_of(hours, spread, shares, 6) < 1.0


def test_many_events_are_an_effect_of_the_model(snowed):
    finding = next(f for f in snowed.finding_objects if f.effect == "modules_covered")
    assert finding.verdict is Verdict.IDENTIFIED
    assert finding.coefficients["modules_covered.share"] == pytest.approx(1.0, abs=0.2)
    errors = snowed.table["rmse_test"]
    assert errors[snowed.last] < 0.6 * errors["fem"]


def test_the_report_and_the_file_have_them(snowed, tmp_path):
    report = " ".join(snowed.report().split())
    assert "power shows the modules were covered, 3" in report
    assert "K colder than modelled" in report and "of the expected power" in report
    assert {"event"} <= {*snowed.statements["verdict"]}
    path = tmp_path / "loop.json"
    snowed.to_json(path)
    again = fem.Loop.from_json(path)
    pd.testing.assert_frame_equal(again.events, snowed.events)
    pd.testing.assert_frame_equal(again.statements, snowed.statements)
    assert "kWh/kWp lost" in report
    assert again.fit.effects[-1].spec == snowed.fit.effects[-1].spec
    page = snowed.to_html()
    assert "Power shows that the modules were covered" in page


def test_a_loop_from_a_file_predicts_another_year_by_the_relation(snowed, tmp_path):
    """Also one day alone, which has too few rows to say what a plant should give."""
    path = tmp_path / "loop.json"
    snowed.to_json(path)
    again = fem.Loop.from_json(path)
    other = record(seed=SEED)
    (rows,) = bright_days(other, 1, seed=9)
    covered(other, rows, 0.4)
    day = other[rows]
    left = again.residual(day)
    assert (
        left.abs().mean() < 0.35 * again.residual(day.assign(power_ac=1e9)).abs().mean()
    )
    pd.testing.assert_series_equal(left, snowed.residual(day))


def test_power_in_the_dark_may_be_missing(clean):
    data = with_events(clean, "modules_covered", 36, 0.4)[0]
    lit = fem.close_loop(
        data.assign(power_ac=data["power_ac"].where(data["poa_global"] > 5))
    )
    assert lit.effects == fem.close_loop(data).effects
    assert (
        lit.predict(data.assign(power_ac=np.nan))[data["poa_global"] < 5].notna().all()
    )


def test_curtailed_power_heats_without_an_area(clean):
    """Half of the power is not taken at noon on a third of the warm days."""
    data = clean.copy()
    over = data["temp_module"] - data["temp_air"]
    for rows in bright_days(data["2023-05":"2023-09"], 30):
        rows = data.index.isin(data["2023-05":"2023-09"].index[rows])
        data.loc[rows, "temp_module"] += 0.12 * over[rows]
        data.loc[rows, "power_ac"] *= 0.5
    loop = fem.close_loop(data)
    finding = next(f for f in loop.finding_objects if f.effect == "electrical_output")
    assert finding.added
    assert 0.15 < finding.coefficients["electrical_output.share"] < 0.35
    (effect,) = (e for e in loop.fit.effects if e.name == "electrical_output")
    assert effect.source == "power_ac"


def test_curtailment_to_nothing_in_simulated_physics_is_an_outage():
    loop = fem.close_loop(record(electrical_output=1.0))
    finding = next(f for f in loop.finding_objects if f.effect == "outage")
    assert finding.verdict is Verdict.IDENTIFIED
    assert 0.1 < finding.coefficients["outage.share"] < 0.35
    energy = loop.events.groupby("effect")["energy"].sum()
    # hours in which only a part of the time is curtailed have some power
    assert {*energy.index} <= {"outage", "underperformance"}
    assert energy["outage"] > 0.8 * energy.sum() and len(loop.events) > 10


def test_without_power_there_are_none(clean):
    loop = fem.close_loop(clean.drop(columns="power_ac"))
    assert loop.events.empty and "power shows" not in loop.report()
    why = "no power_dc or p_dc_per_area or power_ac"
    assert {str(loop.untestable[kind]) for kind in HAPPENS} == {why}


def test_events_that_are_put_into_a_record_are_found_again(clean):
    found = fem.recover_events(clean, size=2.0, draws=8)
    shares = found.groupby("effect")["found"].mean()
    assert set(shares.index) == {*EVENTS} and (shares >= 0.8).all()
    assert (found["hours"] == 6).all() and found["light"].between(0.02, 1.0).all()
    assert found.attrs["own"] == dict.fromkeys(EVENTS, 0)
    again = fem.recover_events(clean, "outage", size=2.0, draws=8, seed=0)
    assert len(again) == 8 and again["found"].all()


def test_what_cannot_be_put_in_is_refused(clean):
    with pytest.raises(ValueError, match="rain is no event; there are modules_covered"):
        fem.recover_events(clean, "rain")
    missing = "the data have no column power_dc or p_dc_per_area or power_ac"
    with pytest.raises(ValueError, match=missing):
        fem.recover_events(clean.drop(columns="power_ac"))
    with pytest.raises(ValueError, match="no day has room for outage of 30 K"):
        fem.recover_events(clean, "outage", size=30.0)
    with pytest.raises(ValueError, match="effects is empty; give some of modules"):
        fem.recover_events(clean, [])
    for name in ("size", "hours", "draws"):
        with pytest.raises(ValueError, match=f"{name} = 0; give a number above 0"):
            fem.recover_events(clean, "outage", **{name: 0})


@pytest.mark.filterwarnings("ignore:the column p_dc:FutureWarning")
def test_events_are_put_into_power_by_its_older_name(clean):
    older = clean.assign(p_dc=clean["power_ac"] / 33.0).drop(columns="power_ac")
    found = fem.recover_events(older, "outage", size=2.0, draws=3)
    assert found["found"].all()


UNFIT = {
    "power_ac is -.* by day .*: turn its sign": lambda power: -power,
    "power_ac is 0 at all hours of the day": lambda power: 0.0 * power,
    r"\d\d % of power_ac by day is missing": lambda power: power.where(
        np.arange(len(power)) % 3 == 0
    ),
}


@pytest.mark.parametrize("words", UNFIT)
def test_power_that_shows_no_event_is_named(clean, words, tmp_path):
    data = clean[: 48 * 90]
    assert not any("outage" in note for note in fem.close_loop(data).notes)
    loop = fem.close_loop(data.assign(power_ac=UNFIT[words](data["power_ac"])))
    (note,) = (note for note in loop.notes if "outage" in note)
    assert re.match(words, note)
    loop.to_json(tmp_path / "loop.json")
    again = fem.Loop.from_json(tmp_path / "loop.json")
    pd.testing.assert_frame_equal(again.events, loop.events)


def test_the_energy_of_events_has_two_digits_and_no_exponent():
    rows = dict(effect="outage", hours=[6, 4], share=[0.01, 0.02], energy=[120.0, 92.0])
    rows["start"] = rows["end"] = pd.date_range("2023-06-01", periods=2)
    assert all_of(pd.DataFrame(rows)).endswith(", 210 kWh/kWp lost")


def test_events_at_the_same_hours_are_said_to_be(clean):
    """So that a reader can tell shade from snow."""
    days = pd.date_range("2023-01-02", periods=12, freq="30D", tz=clean.index.tz)
    begin, air = pd.Timedelta("14h"), np.linspace(1.0, 23.0, 12)
    rows = dict(effect="modules_covered", hours=3, share=0.01, energy=1.0, temp_air=air)
    rows |= dict(start=days + begin, end=days + begin + pd.Timedelta("2h50min"))
    table = pd.DataFrame(rows)
    words = "; 12 within a day, mostly from 14:00 to 16:50, in air of 3 to 21 °C"
    assert all_of(table).endswith(words)
    windy = table.assign(wind_speed=np.linspace(7.0, 18.0, 12))
    assert all_of(windy).endswith(f"{words} and wind of 8 to 17 m/s")
    over_night = table.assign(end=table["end"] + pd.Timedelta("1D"))
    assert "mostly" not in all_of(over_night) and "mostly" not in all_of(table[:9])
