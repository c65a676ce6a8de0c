"""The ranking puts the truth first, and says what it cannot know."""

import numpy as np
import pandas as pd
import pytest
from conftest import COLUMNS
from pvlib.location import Location
from test_effects import coefficients, model_with, predicted

import pvlib_fem as fem
from pvlib_fem import datasets
from pvlib_fem.effects import PHYSICS as EFFECTS

EFFECTS_ = pytest.mark.parametrize("name", EFFECTS)


def base_fit(data):
    return fem.fit_fem(
        *(data[name] for name in COLUMNS), model="faiman", dynamics="balance"
    )


def correlated(rows, noise, seed=0):
    """0.3 K of noise that remembers some hours, as a sensor's does."""
    return 0.3 * np.sqrt(2 * 24) * fem.ewm(noise(rows, 1.0, seed), 7200.0, step=300)


def record_with(plant, noise, *names, seed=0, **planted):
    model = model_with("balance", *names)
    values = coefficients("balance", *names, **planted)
    module = predicted(plant, model, values) + correlated(len(plant), noise, seed)
    other_planes = [name for name in ("ghi", "dni", "dhi") if name in plant]
    return plant.drop(columns=other_planes).assign(temp_module=module)


#: effects with a driver of their own; a drift needs years
DRIVEN = [n for n, e in EFFECTS.items() if not e.confounder and not e.turns]
#: sizes that sixty days can show, where those found outdoors need a year
LARGER = {"soiling": {"per_day": 0.008}}


@pytest.mark.parametrize("name", DRIVEN)
def test_the_planted_effect_comes_first(plant, noise, name):
    larger = {name: LARGER[name]} if name in LARGER else {}
    data = record_with(plant, noise, name, **larger)
    table = fem.rank_effects(base_fit(data), data)
    assert table.index[0] == name
    best = table.iloc[0]
    assert best["gain"] > best["minimum_detectable"] > 0
    assert best["p_value"] < 1e-3 and best["physical"]
    truth = coefficients("balance", name, **larger)
    if best["note"].startswith("from "):
        return  # from another driver than it was planted with
    assert best["coefficients"]
    for key, value in best["coefficients"].items():
        assert value == pytest.approx(truth[key], rel=0.3, abs=4 * best["stderr"][key])


def test_a_trend_is_ranked_by_the_part_of_the_record_that_shows_it_best():
    """A pyranometer that loses light in the second half only."""
    data = fem.simulator.record(
        effects=fem.simulator.PHYSICS, days=200, step=900, seed=5
    )
    data = data[[*COLUMNS]]
    late = np.clip(np.linspace(-1.0, 1.0, len(data)), 0.0, None)
    data["poa_global"] *= 1.0 - 0.12 * late
    row = fem.rank_effects(fem.fit_fem(data), data).loc["irradiance_sensor_drift"]
    (per_year,) = row["coefficients"].values()
    assert per_year == pytest.approx(0.12 / (100.0 / 365.25), rel=0.2)
    assert row["p_value"] < 1e-6 and row["gain"] > 0.3


@pytest.mark.parametrize("seed", range(4))
def test_where_nothing_is_nothing_is_gained(plant, noise, seed):
    data = record_with(plant, noise, seed=seed)
    table = fem.rank_effects(base_fit(data), data)
    assert set(EFFECTS) <= set(table.index)
    assert (table["gain"].dropna() < 0.1).all()


def test_the_gain_is_what_a_refit_gains(plant, noise):
    """The tangent's held-out gain against that of fitting the effect."""
    data = record_with(plant, noise, "wind_direction")
    table = fem.rank_effects(base_fit(data), data)
    with_it = fem.fit_fem(
        *(data[name] for name in COLUMNS),
        model="faiman",
        dynamics="balance",
        effects=["wind_direction"],
        wind_direction=data["wind_direction"],
    )
    rmse = with_it.scores["rmse_test"]
    gain = np.sqrt(rmse["fem"] ** 2 - rmse["+ wind_direction"] ** 2)
    assert table.loc["wind_direction", "gain"] == pytest.approx(gain, rel=0.25)


def test_what_a_fit_holds_is_not_ranked_again(plant, noise):
    """And once the truth is in, nothing else gains."""
    data = record_with(plant, noise, "sky_radiation")
    fit = fem.fit_fem(
        *(data[name] for name in COLUMNS),
        model="faiman",
        dynamics="balance",
        effects=["sky_radiation"],
        longwave_down=data["longwave_down"],
    )
    table = fem.rank_effects(fit, data)
    assert "sky_radiation" not in table.index
    assert (table["gain"].dropna() < 0.1).all()


def test_a_column_of_the_users_own_is_found_by_its_name(plant, noise):
    """A fan that blows warm air on the module at its own hours."""
    data = record_with(plant, noise)
    fan = np.where((data.index.hour >= 9) & (data.index.day_of_week == 2), 40.0, 5.0)
    r_eq = 1 / (25 + 6.84 * data["wind_speed"])
    data["temp_module"] += fem.ewm(2.0 * (fan - fan.mean()) * r_eq, 500.0)
    table = fem.rank_effects(base_fit(data), data.assign(**{"fan speed [rpm]": fan}))
    assert table.index[0] == "driver:fan speed [rpm]"
    heat = table.iloc[0]["coefficients"]["driver:fan speed [rpm].heat"]
    assert heat == pytest.approx(2.0, rel=0.1)


def test_an_impossible_coefficient_is_said_to_be(plant, noise):
    """Power that heats: a hint at the irradiance sensor, not at electricity."""
    data = record_with(
        plant, noise, "electrical_output", electrical_output={"share": -1.0}
    )
    table = fem.rank_effects(base_fit(data), data)
    row = table.loc["electrical_output"]
    assert row["gain"] > 0.1
    assert not row["physical"]
    assert "physically impossible: check the irr" in row["note"]
    assert table["physical"].dropna().astype(bool).is_monotonic_decreasing


def test_what_lacks_its_column_is_listed_with_the_reason(plant, noise):
    lacking = ["longwave_down", "p_dc_per_area", "power_dc"]
    data = record_with(plant, noise).drop(columns=lacking)
    data["wind_direction"] = 270.0
    data["precipitation"] = np.nan
    notes = fem.rank_effects(base_fit(data), data)["note"]
    assert notes["sky_radiation"] == "from humidity"
    assert notes["electrical_output"] == ("no p_dc_per_area or power_dc or power_ac")
    assert notes["wind_direction"] == "wind_direction is constant"
    assert notes["rain"] == "precipitation holds no value"


def test_with_its_place_a_record_is_ranked_for_the_sun_too(plant, noise):
    """As where the columns of the sun's and the module's place are in the frame."""
    data = record_with(plant, noise)[[*COLUMNS]]
    fit, names = base_fit(data), ["incidence_angle", "poa_misalignment"]
    assert fem.rank_effects(fit, data, names)["note"].str.startswith("no loc").all()
    location = Location(49.4, 8.7, tz="Etc/GMT-1")
    place = {"surface_tilt": 35.0, "surface_azimuth": 180.0}
    found = fem.rank_effects(fit, data, names, location=location, **place)
    whole = data.assign(**fem.drivers.sun(data.index, location), **place)
    drawn = fem.rank_effects(fit, whole, names)
    pd.testing.assert_frame_equal(found, drawn, check_flags=False)
    assert found["rows"].gt(100).all()
    with pytest.raises(ValueError, match=r"location is .*; give pvlib\.location"):
        fem.rank_effects(fit, data, location=(49.4, 8.7), **place)


def test_a_copy_of_the_answer_is_no_driver(plant, noise):
    data = record_with(plant, noise)
    spy = data.assign(
        back_sensor_F=1.8 * data["temp_module"] + 32, label="x", sun2=data["poa_global"]
    )
    table = fem.rank_effects(base_fit(data), spy)
    assert not any("back_sensor" in name or "sun2" in name for name in table.index)
    assert not any("label" in name for name in table.index)


def test_pvlibs_older_name_of_the_longwave_is_known(plant, noise):
    data = record_with(plant, noise, "sky_radiation")
    renamed = data.rename(columns={"longwave_down": "ir_down"})
    fit = base_fit(data)
    pd.testing.assert_frame_equal(
        fem.rank_effects(fit, data), fem.rank_effects(fit, renamed)
    )


def test_a_short_record_is_suggestive_at_best(plant, noise):
    data = record_with(plant, noise, "wind_direction").iloc[: 288 * 20]
    table = fem.rank_effects(base_fit(data), data)
    assert (
        table.loc["wind_direction", "note"]
        == "at least 60 days are needed to identify a cause (here 20)"
    )


def test_a_day_holds_nothing_out(day):
    fit = fem.fit_fem(*(day[n] for n in COLUMNS), model="faiman", dynamics="balance")
    table = fem.rank_effects(fit, day[[*COLUMNS, "wind_direction"]])
    assert table.loc["wind_direction", "note"] == "at least 5 days are needed (here 1)"
    assert table["gain"].isna().all()


def test_what_is_as_large_as_detectable_is_seen(plant, noise):
    """Of a size that is the smallest detectable one, and twice as large."""
    data = record_with(plant, noise)
    row = fem.rank_effects(base_fit(data), data, ["rain"]).iloc[0]
    assert 0.0 < row["minimum_detectable"] < 0.3
    big = record_with(plant, noise, "rain")
    found = fem.rank_effects(base_fit(big), big, ["rain"]).iloc[0]
    assert found["gain"] > row["minimum_detectable"] and found["p_value"] < 1e-3


@pytest.mark.parametrize(("days", "found"), [(60, False), (900, True)])
def test_a_drift_is_told_from_a_season_after_years_only(noise, days, found):
    """Within one season it bends as the year does; over two and a half it cannot."""
    data = datasets.synthetic(days, 1800, seed=7, noise=0)
    data = record_with(data, noise, "irradiance_sensor_drift")
    row = fem.rank_effects(base_fit(data), data).loc["irradiance_sensor_drift"]
    (drift,) = row["coefficients"].values()
    assert (row["gain"] > 0.1) == found
    if found:
        assert drift == pytest.approx(0.03, rel=0.2)
    else:
        assert row["stderr"]["irradiance_sensor_drift.per_year"] > 0.03


def test_what_cannot_be_told_apart_is_tied(plant, noise):
    """Two gauges of one wind: each explains all, neither adds to the other."""
    data = record_with(plant, noise, "wind_direction")
    twin = 100 * np.cos(np.radians(data["wind_direction"])) * data["wind_speed"]
    heat = plant["poa_global"] * twin
    data["gauge a"] = heat + noise(len(data), 0.02 * heat.std(), seed=1)
    data["gauge b"] = heat + noise(len(data), 0.02 * heat.std(), seed=2)
    ties = fem.rank_effects(base_fit(data), data)["ties"]
    assert "driver:gauge b" in ties["driver:gauge a"]
    assert "driver:gauge a" in ties["driver:gauge b"]
    assert ties["wind_direction"] == ()


def test_own_effects_and_names_can_be_asked_for(plant, noise):
    data = record_with(plant, noise)
    fit = base_fit(data)
    table = fem.rank_effects(fit, data, ["rain", EFFECTS["soiling"]])
    assert set(table.index) == {"rain", "soiling"}
    with pytest.raises(ValueError, match="unknown effect 'ghosts'"):
        fem.rank_effects(fit, data, ["ghosts"])
    with pytest.raises(
        ValueError, match="the data have no column temp_module; they have"
    ):
        fem.rank_effects(fit, data.drop(columns="temp_module"))


def test_the_ranking_is_the_same_whatever_the_order_of_columns(plant, noise):
    data = record_with(plant, noise, "rain")
    fit = base_fit(data)
    one = fem.rank_effects(fit, data)
    other = fem.rank_effects(fit, data[data.columns[::-1]])
    pd.testing.assert_frame_equal(one, other.loc[one.index])


#: switches of the simulator, which shares nothing with the models, and the effect
#: that has to come first; the coefficient is what its physics gives
OUTDOORS = {
    "sky_radiation": {"sky_radiation.share": (1.0, 1.7)},
    "wind_direction": {"wind_direction.north": (-2.0, -0.5)},
    "electrical_output": {"electrical_output.share": (0.9, 1.6)},
    "rain": {"rain.film": (5.0, 60.0)},
}


@pytest.fixture(scope="module")
def outdoors():
    """150 days at 5 min of the physical world, with one effect each and without."""
    physics = fem.simulator.PHYSICS
    scenarios = {name: physics | {name: 1.0} for name in OUTDOORS}
    scenarios["nothing"] = physics
    made = fem.simulator.records(
        fem.simulator.RHINE, scenarios.values(), 150, 300, 5, start="2023-04-01"
    )
    return {
        name: data.drop(columns="snow_depth") for name, data in zip(scenarios, made)
    }


@pytest.mark.parametrize("name", OUTDOORS)
def test_in_a_world_of_other_equations_the_truth_comes_first(outdoors, name):
    table = fem.rank_effects(base_fit(outdoors[name]), outdoors[name])
    # curtailment to nothing is an outage, too
    first = {"electrical_output", "outage"} if name == "electrical_output" else {name}
    assert table.index[0] in first
    best = table.loc[name]
    assert best["gain"] > 0.15 and best["p_value"] < 1e-3
    for key, (least, most) in OUTDOORS[name].items():
        assert least < best["coefficients"][key] < most


def test_in_a_world_without_effects_nothing_is_material(outdoors):
    """Power shows errors of the irradiance sensor: informative, not physical."""
    table = fem.rank_effects(base_fit(outdoors["nothing"]), outdoors["nothing"])
    assert (table["gain"][table["physical"].eq(True)] < 0.15).all()
    power = table.loc["electrical_output"]
    assert power["gain"] > 0.15 and not power["physical"]
    assert "check the irradiance sensor" in power["note"]


def test_a_column_that_an_effect_of_the_fit_needs_is_asked_for_by_name(plant, noise):
    data = record_with(plant, noise, "wind_direction")
    fit = fem.fit_fem(
        *(data[name] for name in COLUMNS),
        model="faiman",
        dynamics="balance",
        night=True,
        effects="wind_direction",
        wind_direction=data["wind_direction"],
    )
    words = "wind_direction of the fit needs wind_direction, .* give it, or rank a fit"
    with pytest.raises(ValueError, match=words):
        fem.rank_effects(fit, data.drop(columns="wind_direction"))
    still = data.assign(wind_direction=180.0)
    with pytest.raises(ValueError, match=r"wind_direction is constant\)"):
        fem.rank_effects(fit, still)


def test_a_fit_that_follows_the_sun_is_not_ranked_without_a_place(plant, noise):
    data = record_with(plant, noise)[[*COLUMNS]]
    place = dict(location=Location(49.4, 8.7), surface_tilt=35, surface_azimuth=180)
    sun = fem.drivers.geometry(data.index, **place)
    fit = fem.fit_fem(
        *(data[name] for name in COLUMNS),
        model="faiman",
        dynamics="balance",
        effects="incidence_angle",
        **sun,
    )
    assert len(fem.rank_effects(fit, data, ["season"], **place))
    with pytest.raises(
        ValueError,
        match=r"incidence_angle of the fit needs solar_.*; "
        "give location, surface_tilt and surface_azimuth",
    ):
        fem.rank_effects(fit, data, ["season"])
