"""Effects: their terms, and that a fit finds known effects."""

import dataclasses
import json
import pickle

import numpy as np
import pandas as pd
import pvlib
import pytest
import study_worlds
from conftest import COLUMNS, DRIVERS
from hypothesis import given, strategies as st
from study_records import seen

import pvlib_fem as fem
from pvlib_fem import datasets
from pvlib_fem._loop.regression.evidence import Evidence
from pvlib_fem._loop.regression.scans import Places, Scanned, located_effect
from pvlib_fem._record.inputs import read
from pvlib_fem._stored import VERSION
from pvlib_fem._thermal.model import ThermalModel
from pvlib_fem._thermal.steady_models import STEADY_MODELS
from pvlib_fem.drivers import Driver, _water as water, derive_drivers, sun
from pvlib_fem.effects import PHYSICS as EFFECTS, find
from pvlib_fem.effects._effect import (
    Effect,
    LinearisedEffect,
    Parameter,
    Terms,
    linearised,
)
from pvlib_fem.effects.catalogue.soiling import (
    RAINS,
    scanned_over,
    soiling_by_rain,
)
from pvlib_fem.reasons import Reason

#: planted coefficients, of the size that is found outdoors
PLANTED = {
    "sky_radiation": {"share": 1.0},
    "electrical_output": {"share": 1.33},
    "wind_direction": {"north": -0.9, "east": 0.4},
    "rain": {"film": 25.0},
    "soiling": {"per_day": 0.003},
    "irradiance_sensor_drift": {"per_year": 0.03},
    "snow": {"share": 0.9, "stays": 0.4},
    "modules_covered": {"share": 0.8},
    "sensor_covered": {"share": 0.9},
    "outage": {"share": 0.25},
    "shading": {"share": 0.8},
    "tracker_stuck": {"share": 1.0},
    "air_elsewhere": {"share": 0.15},
    "radiative_loss": {"share": 2.4},
    "natural_convection": {"free": 5.6},
    "wind_shape": {"root": 4.0, "stall": -5.0},
    "thermal_storage": {"hour": 0.1, "three_hours": 0.15, "air": 4.0},
    "ground_or_water": {"exchange": 4.0},
    "incidence_angle": {"b0": 0.05},
    "rear_irradiance": {"share": 0.2},
    "poa_misalignment": {"tilt": 3.0, "azimuth": -8.0},
    "temperature_gain": {"gain": -0.03},
    "air_shield": {"warm": 3.0},
    "season": {"winter": 0.06, "spring": 0.06},
}
DRIVEN = [name for name, effect in EFFECTS.items() if not effect.confounder]
#: a window of the sky that the sun of June crosses before the module
SHADED = {"name": "shading", "windows": [[90.0, 150.0, 30.0, 70.0]]}
BASE = {"u0": 25.0, "u1": 6.84, "bias": -1.0}
dynamics_ = pytest.mark.parametrize("dynamics", ["steady", "ewm", "balance"])
effects_ = pytest.mark.parametrize("name", EFFECTS)


def planted_as(name):
    return find(SHADED if name == "shading" else name)


def model_with(dynamics, *names):
    return ThermalModel(
        STEADY_MODELS["faiman"], dynamics, tuple(map(planted_as, names))
    )


def coefficients(dynamics, *names, **planted):
    values = dict(BASE)
    values |= {"ewm": {"tau": 500.0}, "balance": {"capacity": 17e3}}.get(dynamics, {})
    for name in names:
        own = planted.get(name, PLANTED[name])
        values |= {f"{name}.{key}": value for key, value in own.items()}
    return values


def columns(data, model):
    return {name: data[name] for name in model.drivers}


def predicted(data, model, values):
    usual = (data[name] for name in DRIVERS)
    return model.predict(*usual, values, **columns(data, model))


@dynamics_
@effects_
def test_at_its_start_an_effect_adds_nothing(plant, name, dynamics):
    model = model_with(dynamics, name)
    start = {key: row.start for key, row in find(name).parameters.items()}
    values = coefficients(dynamics, name, **{name: start})
    without = coefficients(dynamics)
    if dynamics == "steady":
        without["tau"] = 1e-9
    np.testing.assert_allclose(
        predicted(plant, model, values),
        predicted(plant, model_with(dynamics), without),
        rtol=1e-12,
    )


@dynamics_
def test_the_jacobian_with_all_effects_is_exact(plant, dynamics):
    hours = plant.iloc[:2000].drop(plant.index[900:930]).copy()
    hours.iloc[500:505, hours.columns.get_loc("wind_direction")] = np.nan
    hours.iloc[700:703, hours.columns.get_loc("poa_global")] = np.nan
    model = model_with(dynamics, *EFFECTS)
    values = coefficients(dynamics, *EFFECTS)
    inputs = {**{n: hours[n] for n in DRIVERS}, **columns(hours, model)}
    model = dataclasses.replace(model, base=coefficients(dynamics))
    inputs = model.with_drivers(read(inputs))
    temperature, slopes = model.slopes(inputs, values)
    missing = hours[[*DRIVERS, *model.drivers]].isna().any(axis=1)
    assert (np.isnan(temperature) == missing).all()
    assert set(slopes) == set(model.parameters)
    for name, row in model.parameters.items():
        step = 1e-6 * (abs(values[name]) + 1e-3 * (row.upper - row.lower))
        up, down = (
            model.slopes(inputs, {**values, name: values[name] + change})[0]
            for change in (step, -step)
        )
        numeric = ((up - down) / (2 * step))[~missing]
        largest = np.abs(numeric).max()
        np.testing.assert_allclose(
            slopes[name][~missing], numeric, atol=2e-6 * largest, err_msg=name
        )


@pytest.mark.parametrize("dynamics", ["ewm", "balance"])
@effects_
def test_a_planted_effect_is_found(plant, noise, name, dynamics):
    """With 0.2 K of noise: within four of its errors, and better on held-out days."""
    model = model_with(dynamics, name)
    values = coefficients(dynamics, name)
    module = predicted(plant, model, values) + noise(len(plant), 0.2)
    fit = fem.fit_fem(
        *(plant[n] for n in DRIVERS),
        module,
        model="faiman",
        dynamics=dynamics,
        effects=[planted_as(name)],
        **columns(plant, model),
    )
    assert fit.converged
    assert planted_as(name).rows()
    for key in planted_as(name).rows():
        error = fit.stderr[key]
        assert abs(fit.coefficients[key] - values[key]) < 4 * error
        assert error < 0.35 * abs(values[key])
    rmse = fit.scores["rmse_test"]
    assert list(fit.scores.index)[-2:] == ["fem", f"+ {name}"]
    assert rmse[f"+ {name}"] < rmse["fem"]
    assert rmse[f"+ {name}"] == pytest.approx(0.2, abs=0.01)
    again = fit.predict(*(plant[n] for n in DRIVERS), **columns(plant, model))
    np.testing.assert_allclose(module - again, fit.residual, atol=1e-9)


@effects_
def test_an_effect_that_is_not_there_comes_out_as_nothing(plant, noise, name):
    module = predicted(plant, model_with("balance"), coefficients("balance"))
    fit = fem.fit_fem(
        *(plant[n] for n in DRIVERS),
        module + noise(len(plant), 0.2),
        model="faiman",
        dynamics="balance",
        effects=[planted_as(name)],
        **columns(plant, model_with("balance", name)),
    )
    assert planted_as(name).rows()
    for key in planted_as(name).rows():
        nothing = fit.coefficients[key] == 0.0 or key in fit.at_bound
        assert nothing or abs(fit.coefficients[key]) < 4 * fit.stderr[key]
    gain = fit.scores.loc["fem", "rmse_test"] - fit.scores["rmse_test"].iloc[-1]
    assert abs(gain) < 0.002


def test_all_driven_effects_at_once_are_told_apart(plant, noise):
    """Functions of the usual columns are not named: several have equal signatures."""
    model = model_with("balance", *DRIVEN)
    values = coefficients("balance", *DRIVEN)
    module = predicted(plant, model, values) + noise(len(plant), 0.2)
    fit = fem.fit_fem(
        *(plant[n] for n in DRIVERS),
        module,
        model="faiman",
        dynamics="balance",
        effects=[planted_as(name) for name in DRIVEN],
        **columns(plant, model),
    )
    assert values
    for key, value in values.items():
        assert abs(fit.coefficients[key] - value) < 4 * fit.stderr[key], key
    assert fit.scores["rmse_train"].is_monotonic_decreasing


def test_sky_radiation_is_pvlibs_radiative_faiman(plant):
    """With emissivity times sky view as its share (pvlib counts no absorption)."""
    values = coefficients(
        "steady", "sky_radiation", sky_radiation={"share": 0.88 * 0.9}
    )
    answer = predicted(plant, model_with("steady", "sky_radiation"), values)
    theirs = pvlib.temperature.faiman_rad(
        *(plant[n] for n in DRIVERS),
        ir_down=plant["longwave_down"],
        u0=25.0,
        u1=6.84,
        sky_view=0.9,
        emissivity=0.88,
    )
    np.testing.assert_allclose(answer, theirs - 1.0, rtol=1e-9)


def test_pvlibs_name_of_the_longwave_serves_as_well(plant):
    usual = [plant[n] for n in COLUMNS]
    sky = plant["longwave_down"]
    fits = [
        fem.fit_fem(*usual, model="faiman", effects=["sky_radiation"], **{name: sky})
        for name in ("longwave_down", "ir_down")
    ]
    assert fits[0].coefficients == fits[1].coefficients
    again = fits[1].predict(*usual[:3], ir_down=sky)
    pd.testing.assert_series_equal(
        again, fits[0].predict(*usual[:3], longwave_down=sky)
    )


def test_wind_from_one_side_is_a_law_of_its_own():
    """North wind with north = -2 is Faiman with u1 less by 2."""
    sun = pd.Series(800.0, pd.date_range("2024-06-01", periods=200, freq="1min"))
    model = model_with("balance", "wind_direction")
    values = {**BASE, "capacity": 17e3}
    values |= {"wind_direction.north": -2.0, "wind_direction.east": 5.0}
    answer = model.predict(sun, 20.0, 3.0, values, wind_direction=0 * sun)
    values = {**BASE, "capacity": 17e3, "u1": 4.84}
    want = fem.heat_balance(sun, 20.0, 3.0, **values)
    np.testing.assert_allclose(answer, want, rtol=1e-12)


def test_rain_ends_where_the_film_has_dried():
    minutes = np.arange(0, 7200, 60.0)
    rain = np.where((minutes >= 600) & (minutes < 1200), 4.0, 0.0)
    wet = water.wetness(rain, read({"rain": rain}, times=minutes))
    assert (wet[:10] == 0).all()
    assert wet[19] == 1.0
    after = minutes - 1140
    film = 5 * (1 - np.exp(-600 / 1800)) * np.exp(-after / 1800)
    np.testing.assert_allclose(wet[20:], np.minimum(1, film[20:]), atol=1e-12)


def film(wet, humidity, air, module):
    """Vapour that a film gives off, of one row."""
    one = (np.array([float(value)]) for value in (wet, humidity, air, module))
    (vapour,) = water.film_vapour(*one, None)
    return vapour


def test_a_film_gives_off_what_the_air_does_not_hold():
    """At 20 °C and 50 %: half of the 23.3 hPa at saturation (Magnus)."""
    assert film(0.0, 50, 20, 40) == 0.0
    assert film(1.0, 100, 20, 20) == 0.0
    # so little of it that the module is as warm as a dry one
    assert film(1e-6, 50, 20, 20) == pytest.approx(23.3 / 2 * 1e-6, rel=0.005)
    assert film(1e-6, 50, 20, 40) == pytest.approx((73.6 - 23.3 / 2) * 1e-6, rel=0.005)


def test_a_wet_module_is_as_cold_as_a_wet_bulb(monkeypatch):
    """Of air of 20 °C and 50 % that is 13.8 °C, by any psychrometric chart."""
    monkeypatch.setattr(water, "LATENT", 1.0 / 0.662)  # K/hPa, at 1013 hPa
    vapour = film(1.0, 50, 20, 20)
    assert vapour == pytest.approx(15.8 - 23.3 / 2, abs=0.1)  # 13.8 °C: 15.8 hPa


@given(st.floats(0.0, 1.0), st.floats(0.0, 100.0), st.floats(-5, 40), st.floats(-5, 90))
def test_what_a_film_takes_makes_it_colder(wet, humidity, air, module):
    """The balance holds, and a film takes no more heat than the air brings."""
    vapour = film(wet, humidity, air, module)
    held = humidity / 100.0 * water.saturation(air)
    dry = wet * max(water.saturation(module) - held, 0.0)
    assert 0.0 <= vapour <= dry + 1e-9
    if vapour > 0.0:
        colder = module - water.LATENT * vapour
        assert wet * (water.saturation(colder) - held) == pytest.approx(
            vapour, rel=1e-6, abs=1e-6
        )


def test_rain_is_found_by_its_vapour(plant, noise):
    effect = find({"name": "rain", "source": "humidity"})
    model = ThermalModel(STEADY_MODELS["faiman"], "balance", (effect,))
    values = {**coefficients("balance"), "rain.film": 25.0}
    module = predicted(plant, model, values) + noise(len(plant), 0.2)
    fit = fem.fit_fem(
        *(plant[n] for n in DRIVERS),
        module,
        model="faiman",
        dynamics="balance",
        effects=[{"name": "rain", "source": "humidity"}],
        **columns(plant, model),
    )
    assert fit.coefficients["rain.film"] == pytest.approx(25.0, rel=0.1)


def test_dirt_gathers_until_rain_cleans():
    hours = np.arange(0, 10 * 86400, 3600.0)
    rain = np.where((hours >= 4 * 86400) & (hours < 4 * 86400 + 7200), 5.0, 0.0)
    drizzle = np.where(hours == 7 * 86400, 0.2, 0.0)
    rain = rain + drizzle
    days = water.days_since_rain(rain, read({"rain": rain}, times=hours))
    assert days[4 * 24 - 1] == pytest.approx(4 - 1 / 24)
    assert days[4 * 24] == 0
    assert days[-1] == pytest.approx(10 - 4 - 2 / 24, abs=0.1)


def test_ones_own_effect_is_one_object(plant, noise):
    """Heat from a vent that a column follows; nothing else is needed."""
    vent = pd.Series(np.where(plant.index.hour < 8, 1.0, 0.0), plant.index)

    def terms(vent_open, *, warmth):
        """Heat of an open vent."""
        return fem.Terms(heat=warmth * vent_open)

    effect = fem.Effect(
        "vent", terms, {"warmth": fem.Parameter(0.0, 0.0, 500.0, "W/m²")}
    )
    model = ThermalModel(STEADY_MODELS["faiman"], "balance", (effect,))
    values = {**coefficients("balance"), "vent.warmth": 80.0}
    usual = [plant[n] for n in DRIVERS]
    module = model.predict(*usual, values, vent_open=vent) + noise(len(plant), 0.2)
    fit = fem.fit_fem(
        *usual,
        module,
        model="faiman",
        dynamics="balance",
        effects=[effect],
        vent_open=vent,
    )
    assert fit.coefficients["vent.warmth"] == pytest.approx(80.0, rel=0.02)
    assert "+ vent" in str(fit)


def test_ones_own_effect_can_be_read_back(plant, tmp_path):
    """The file knows it by name only, so it is given again."""
    own = fem.Effect("own", EFFECTS["rain"].terms, EFFECTS["rain"].parameters)
    fit = fem.fit_fem(
        *(plant[n] for n in COLUMNS),
        effects=[own],
        precipitation=plant["precipitation"],
    )
    path = tmp_path / "fit.json"
    fit.to_json(path)
    rain = {"precipitation": plant["precipitation"]}
    with pytest.raises(ValueError, match="unknown effect 'own'"):
        fem.DynamicCellTemperature.from_json(path, **rain)
    model = fem.DynamicCellTemperature.from_json(path, effects=[own], **rain)
    assert model.coefficients == fit.coefficients


def vent(column, **options):
    """Heat of a user's own vent, by a column of its opening."""

    def terms(opened, *, warmth):
        return fem.Terms(heat=warmth * opened)

    row = fem.Parameter(0.0, 0.0, 500.0, "W/m²")
    return fem.Effect("vent", terms, {"warmth": row}, columns=(column,), **options)


def above(level):
    """A vent that is open above a level of humidity, and more in wind."""

    def terms(relative_humidity, wind_speed, *, warmth, windy):
        heat = warmth + windy * wind_speed
        return fem.Terms(heat=heat * (relative_humidity > level))

    rows = {
        "warmth": fem.Parameter(0.0, 0.0, 500.0, "W/m²"),
        "windy": fem.Parameter(0.0, -50.0, 50.0, "W s/m³"),
    }
    return fem.Effect("vent", terms, rows, settings={"level": level}, make=above)


@pytest.fixture(scope="module")
def vented(plant):
    """Heat in humid air, which the model does not have."""
    values = {**coefficients("balance"), "vent.warmth": 60.0, "vent.windy": 20.0}
    model = ThermalModel(STEADY_MODELS["faiman"], "balance", (above(60.0),))
    usual = [plant[n] for n in DRIVERS]
    humid = plant["relative_humidity"]
    module = model.predict(*usual, values, relative_humidity=humid)
    noise = np.random.default_rng(3).normal(0, 0.2, len(plant))
    data = plant[[*DRIVERS, "relative_humidity"]]
    return data.assign(temp_module=module + noise)


def added(data, effect):
    """The one effect that the loop adds, and the coefficients."""
    loop = fem.close_loop(data, effects=effect)
    assert loop.effects == ["vent"], loop
    return loop.fit.effects[0], loop.fit.coefficients


def test_ones_own_variants_are_tried_as_those_of_the_catalogue(vented):
    """The second form, since the column of the first is not there."""
    damp = (vented["relative_humidity"] > 60) * (60 + 20 * vented["wind_speed"])
    data = vented.assign(half_open=damp / 200)
    forms = (vent("flow", source="its flow"), vent("half_open", source="its flap"))
    effect, found = added(data, vent("flow", variants=forms))
    assert effect is forms[1]
    assert found["vent.warmth"] == pytest.approx(200.0, rel=0.03)


def test_ones_own_effect_takes_settings_from_the_record(vented):
    looked_at = []

    def prepare(columns, rows):
        looked_at.append(rows.sum())
        # three levels; the record's own mean is near the true one
        return above(round(columns["relative_humidity"][rows].mean() / 20) * 20.0)

    start = dataclasses.replace(above(0.0), prepare=prepare)
    effect, found = added(vented, start)
    assert effect.settings == {"level": 60.0}
    assert found["vent.windy"] == pytest.approx(20.0, rel=0.1)
    assert 0 < max(looked_at) < len(vented)  # nothing of the weeks held out


def test_ones_own_scan_finds_settings_in_what_is_left(vented):
    """Of three levels that whose tangent follows the residual best."""
    levels = (40.0, 60.0, 80.0)

    def everywhere(relative_humidity, *, at40, at60, at80):
        return fem.Terms(
            heat=sum(
                share * (relative_humidity > level)
                for share, level in zip((at40, at60, at80), levels)
            )
        )

    def scan(rest, tangents, columns, weeks, least):
        assert set(columns) == {"relative_humidity"}
        assert len(weeks) == len(rest) and least == 0.10
        alike = [(rest @ tangent) ** 2 / (tangent @ tangent) for tangent in tangents]
        return above(levels[int(np.argmax(alike))])

    def by_value(rest, tangents, *others):
        # and then the tangents of the fitted coefficients
        assert list(tangents)[:4] == ["vent.at40", "vent.at60", "vent.at80", "u0"]
        return scan(rest, list(tangents.values())[:3], *others)

    row = fem.Parameter(0.0, 0.0, 500.0, "W/m²")
    rows = dict.fromkeys(("at40", "at60", "at80"), row)
    wide = fem.Effect("vent", everywhere, rows)
    start = dataclasses.replace(above(0.0), scan=by_value, scanned_from=wide)
    effect, found = added(vented, start)
    assert effect.settings == {"level": 60.0}
    assert found["vent.warmth"] == pytest.approx(60.0, rel=0.1)


def test_ones_own_settings_are_read_back(vented, tmp_path):
    """From a file, where the effect that makes them is given again."""
    humid = {"relative_humidity": vented["relative_humidity"]}
    usual = [vented[n] for n in COLUMNS]
    fit = fem.fit_fem(*usual, effects=above(60.0), **humid)
    fit.to_json(tmp_path / "fit.json")
    model = fem.DynamicCellTemperature.from_json(
        tmp_path / "fit.json", effects=[above(0.0)], **humid
    )
    assert model.effects[0].settings == {"level": 60.0}
    with pytest.raises(ValueError, match="unknown effect 'vent'"):
        fem.DynamicCellTemperature.from_json(tmp_path / "fit.json", **humid)


def test_a_coefficient_that_lacks_is_named(plant):
    values = {k: v for k, v in coefficients("balance", "rain").items() if k != "u1"}
    with pytest.raises(ValueError, match="faiman needs u1"):
        predicted(plant, model_with("balance", "rain"), values)


def test_a_row_without_its_driver_is_not_used(plant):
    holes = plant.copy()
    holes.iloc[3000:3400, holes.columns.get_loc("wind_direction")] = np.nan
    fit = fem.fit_fem(
        *(holes[n] for n in COLUMNS),
        model="faiman",
        effects=["wind_direction"],
        wind_direction=holes["wind_direction"],
    )
    assert fit.residual.isna().sum() == 400
    assert fit.record.missing["wind_direction"] == 400
    assert "missing: wind_direction 400" in str(fit)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            dict(effects=["wind_direction"]),
            "the data have no column wind_direction, which wind_direction needs; give",
        ),
        (
            dict(effects=["sky_radiation", "rain"]),
            "the data have no columns longwave_down, precipitation, which "
            "sky_radiation and rain need; give them as longwave_down=..., "
            "precipitation=..., or drop the effects",
        ),
        (
            dict(effects=["rear_irradiance"]),
            "the data have no column.* solar_zenith, .*; pvlib_fem.drivers.sun",
        ),
        (dict(effects=["ghosts"]), "unknown effect 'ghosts'; there are sky_radiation"),
        (dict(rain=3), "no effect uses rain; the effects use no further column"),
        (dict(effects=["rain"], method="paper"), "method='paper' has no effects"),
    ],
)
def test_what_does_not_fit_together_is_refused(plant, options, message):
    if options.get("method") == "paper":
        options = {**options, "precipitation": plant["precipitation"]}
    with pytest.raises(ValueError, match=message):
        fem.fit_fem(*(plant[n] for n in COLUMNS), **options)


def test_a_fit_with_effects_runs_in_a_chain_and_as_json(plant, tmp_path):
    fit = fem.fit_fem(
        *(plant[n] for n in COLUMNS),
        model="faiman",
        dynamics="balance",
        effects=["wind_direction"],
        wind_direction=plant["wind_direction"],
    )
    path = tmp_path / "fit.json"
    fit.to_json(path)
    assert json.loads(path.read_text())["effects"] == ["wind_direction"]
    direction = plant["wind_direction"].tz_localize("Etc/GMT+7")
    weather = plant[["ghi", "dni", "dhi", "temp_air", "wind_speed"]]
    weather = weather.tz_localize("Etc/GMT+7").iloc[:600]
    array = pvlib.pvsystem.Array(
        pvlib.pvsystem.FixedMount(30, 180),
        module_parameters={"pdc0": 1000.0, "gamma_pdc": -0.0035},
    )
    cells = []
    for model in (
        fit.temperature_model(deltaT=0.0, wind_direction=direction),
        fem.DynamicCellTemperature.from_json(path, wind_direction=direction),
    ):
        chain = pvlib.modelchain.ModelChain(
            pvlib.pvsystem.PVSystem([array], inverter_parameters={"pdc0": 1000.0}),
            pvlib.location.Location(35, -106),
            aoi_model="physical",
            spectral_model="no_loss",
            temperature_model=model,
        )
        results = chain.run_model(weather).results
        cells.append(results.cell_temperature)
    want = fit.predict(
        results.total_irrad["poa_global"],
        weather["temp_air"],
        weather["wind_speed"],
        wind_direction=direction.iloc[:600],
    )
    for cell in cells:
        np.testing.assert_allclose(cell, want, rtol=1e-12)
    with pytest.raises(ValueError, match="the data have no column wind_direction"):
        fit.temperature_model(deltaT=0.0)


def test_on_the_measured_day_the_wind_comes_from_somewhere(day):
    """One day says nothing of other days; it does fit better with a direction."""
    fit = fem.fit_fem(
        *(day[n] for n in COLUMNS),
        model="faiman",
        dynamics="balance",
        effects=["wind_direction"],
        wind_direction=day["wind_direction"],
    )
    rmse = fit.scores["rmse_train"]
    assert rmse["+ wind_direction"] < rmse["fem"]
    assert np.isnan(list(fit.stderr.values())).all()


def test_a_loss_below_nothing_has_no_temperature(plant):
    """Far outside its bounds an effect may undo all losses; that is no number."""
    model = model_with("balance", "wind_direction")
    values = coefficients("balance", wind_direction={})
    values |= {"wind_direction.north": -900.0, "wind_direction.east": 0.0}
    calm_too = predicted(plant, model, values)
    undone = 25 + plant["wind_speed"] * (
        6.84 - 900 * np.cos(np.radians(plant["wind_direction"]))
    )
    assert (calm_too.isna() == (undone <= 0)).all()


MADE = [
    SHADED,
    {"name": "sky_radiation", "source": "humidity"},
    {"name": "sky_radiation", "source": "humidity, without clouds"},
    {"name": "sky_radiation", "source": "air temperature alone"},
]


@pytest.mark.parametrize(
    "spec", MADE, ids=lambda spec: " ".join(map(str, spec.values()))
)
def test_an_effect_with_settings_is_made_again(spec):
    """By what JSON makes of its own words, and by pickle."""
    effect = find(spec)
    assert json.loads(json.dumps(effect.spec)).items() >= spec.items()
    again = find(json.loads(json.dumps(effect.spec)))
    for other in (again, pickle.loads(pickle.dumps(effect))):
        assert other.drivers == effect.drivers
        assert other.settings == effect.settings


@pytest.mark.parametrize("source", [spec["source"] for spec in MADE[1:]])
def test_a_sky_from_other_columns_is_found(plant, noise, source):
    effect = find({"name": "sky_radiation", "source": source})
    model = ThermalModel(STEADY_MODELS["faiman"], "balance", (effect,))
    values = coefficients("balance", "sky_radiation")
    module = predicted(plant, model, values) + noise(len(plant), 0.2)
    fit = fem.fit_fem(
        *(plant[n] for n in DRIVERS),
        module,
        model="faiman",
        dynamics="balance",
        effects=[effect],
        **columns(plant, model),
    )
    found, error = (d["sky_radiation.share"] for d in (fit.coefficients, fit.stderr))
    assert abs(found - 1.0) < 4 * error < 0.8
    assert json.loads(fit.to_json())["effects"] == [effect.spec]


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        (
            {"name": "snow", "windows": []},
            "snow has no setting windows; it has lying, sliding, snowfall",
        ),
        ({"name": "rain", "source": "dew"}, "unknown source 'dew' of rain"),
        ({"name": "ghosts"}, "unknown effect 'ghosts'; there are sky_radiation"),
        (
            {"name": "sky_radiation", "source": "stars"},
            "unknown source 'stars' of sky_radiation; there are measured longwave; hum",
        ),
        (
            {"name": "shading", "windows": [[90, 120, 20, 10]]},
            "is no window of the sky; give azimuth_from",
        ),
    ],
)
def test_settings_that_make_nothing_are_refused(spec, message):
    with pytest.raises(ValueError, match=message):
        find(spec)


def test_a_window_of_the_sky_may_contain_north():
    azimuth = np.array([340.0, 350.0, 0.0, 10.0, 20.0, 355.0])
    zenith = np.array([80.0, 80.0, 80.0, 80.0, 80.0, 60.0])
    around = find({"name": "shading", "windows": [[345, 15, 0, 20], [0, 360, 25, 90]]})
    heat = around.terms(np.full(6, 500.0), azimuth, zenith, share=0.5).heat
    np.testing.assert_allclose(heat, [0, -250, -250, -250, 0, -250])


@pytest.mark.parametrize("tracker", [False, True])
@pytest.mark.parametrize("way", ["weather", "effective irradiance"])
def test_a_chain_knows_where_sun_and_module_are(plant, tmp_path, tracker, way):
    """No driver of the place is given; the answer is that with pvlib's own."""
    zone, site = "Etc/GMT+7", pvlib.location.Location(35, -106)
    weather = plant[["ghi", "dni", "dhi", "temp_air", "wind_speed"]]
    weather = weather.tz_localize(zone).iloc[:600].fillna(0.0)
    mount = (
        pvlib.pvsystem.SingleAxisTrackerMount()
        if tracker
        else pvlib.pvsystem.FixedMount(30, 170)
    )
    array = pvlib.pvsystem.Array(
        mount, module_parameters={"pdc0": 1000.0, "gamma_pdc": -0.0035}
    )
    names = ("shading", "incidence_angle")
    values = coefficients("balance", *names)
    fit = {
        "model": "faiman",
        "dynamics": "balance",
        "coefficients": values,
        "effects": [SHADED, "incidence_angle"],
        "format": "pvlib_fem.FemFit",
        "version": VERSION,
        "base": None,
        "fixed": {},
        "cell": {"deltaT": 0.0},
    }
    (tmp_path / "fit.json").write_text(json.dumps(fit))
    model = fem.DynamicCellTemperature.from_json(tmp_path / "fit.json")
    chain = pvlib.modelchain.ModelChain(
        pvlib.pvsystem.PVSystem([array], inverter_parameters={"pdc0": 1000.0}),
        site,
        aoi_model="physical",
        spectral_model="no_loss",
        temperature_model=pickle.loads(pickle.dumps(model)),
    )
    total = chain.run_model(weather).results.total_irrad["poa_global"]
    sun = chain.results.solar_position
    if way == "effective irradiance":
        usual = weather[["temp_air", "wind_speed"]]
        data = usual.assign(poa_global=total, effective_irradiance=total)
        chain.results.solar_position = None
        chain.run_model_from_effective_irradiance(data)
    # by the apparent sun, as the chain has it
    place = mount.get_orientation(sun["apparent_zenith"], sun["azimuth"])
    expected = model_with("balance", *names).predict(
        total,
        weather["temp_air"],
        weather["wind_speed"],
        values,
        solar_zenith=sun["zenith"],
        solar_azimuth=sun["azimuth"],
        surface_tilt=pd.Series(place["surface_tilt"], sun.index).fillna(0.0),
        surface_azimuth=pd.Series(place["surface_azimuth"], sun.index).fillna(0.0),
    )
    found = chain.results.cell_temperature
    assert (found.isna() == total.isna()).all()  # a tracker has none at night
    np.testing.assert_allclose(found, expected, atol=0.02 if way != "weather" else 1e-9)
    plain = model_with("balance").predict(
        total, weather["temp_air"], weather["wind_speed"], coefficients("balance")
    )
    assert (plain - found).max() > 3.0


def test_natural_convection_is_tarps_in_calm_air():
    """At 35°: from 15 K, where the steady model has it, to 6 and 30 K."""

    def tarp(excess):
        tilt = np.cos(np.radians(35))
        return np.cbrt(excess) * (9.482 / (7.283 - tilt) + 1.810 / (1.382 + tilt))

    excess = np.array([6.0, 15.0, 30.0])
    terms = EFFECTS["natural_convection"].terms(20.0 + excess, 20.0, 0.0, free=5.65)
    np.testing.assert_allclose(terms.loss, tarp(excess) - tarp(15.0), atol=0.02)


def test_incidence_angle_is_pvlibs_ashrae():
    """Up to where the loss is held, 1/cos = 6."""
    angle = np.array([0.0, 40.0, 60.0, 80.0])
    effect = EFFECTS["incidence_angle"]
    heat = effect.terms(100.0, np.cos(np.radians(angle)), b0=0.05).heat
    want = 100.0 * (pvlib.iam.ashrae(angle, b=0.05) - 1.0)
    np.testing.assert_allclose(heat, want, atol=1e-9)


@effects_
def test_a_table_of_a_linear_effect_is_the_effect(plant, name):
    """All in the catalogue are linear, so their slopes on a record say all."""
    effect = find(SHADED if name == "shading" else name)
    base = coefficients("balance")
    model = ThermalModel(STEADY_MODELS["faiman"], "balance", (effect,), base)
    inputs = {n: plant[n] for n in (*DRIVERS, *model.drivers)}
    columns = model.with_drivers(read(inputs)).columns
    table = linearised(effect, columns)
    assert isinstance(table, LinearisedEffect) and linearised(table, columns) is table
    values = {
        key: row.lower + 0.8 * (row.upper - row.lower)
        for key, row in effect.rows().items()
    }
    for column in ("heat", "loss", "capacity", "offset"):
        one = getattr(effect.at(columns, values), column)
        np.testing.assert_allclose(
            getattr(table.at(columns, values), column), one, rtol=1e-6, atol=1e-9
        )


def test_what_is_not_linear_has_no_table(plant):
    def bent(wind_speed, *, power):
        return fem.Terms(loss=(1.0 + wind_speed) ** power - 1.0)

    own = fem.Effect("bent", bent, {"power": fem.Parameter(0.0, -2.0, 2.0, "-")})
    columns = {"wind_speed": plant["wind_speed"].to_numpy()}
    assert linearised(own, columns) is own


ROWS = 20_000
ONCE = np.random.default_rng(3).random(ROWS)
FORMS = {  # of terms, and whether they are linear in their parameter
    "of a row": (lambda x, *, a: Terms(heat=a * x), True),
    "of its column": (lambda x, *, a: Terms(heat=a * (x - x.mean())), True),
    "of rows before": (lambda x, *, a: Terms(loss=a * np.cumsum(x)), True),
    "of so many rows": (lambda x, *, a: Terms(offset=a * (x + ONCE)), True),
    "in a square": (lambda x, *, a: Terms(heat=a**2 * x), False),
    "with a bound": (lambda x, *, a: Terms(heat=np.maximum(a * x - 5.0, 0.0)), False),
    "of a rare row": (lambda x, *, a: Terms(heat=a * x + a**2 * (x > 9.9)), False),
}


@pytest.mark.parametrize("form", FORMS)
def test_whether_an_effect_is_linear_is_tried(form):
    """A few rows do where a row's terms are its own, and else the whole record."""
    terms, linear = FORMS[form]
    effect = Effect("own", terms, {"a": Parameter(0.0, 0.0, 2.0, "-")})
    columns = {"x": 10.0 * np.random.default_rng(1).random(ROWS)}
    found = linearised(effect, columns)
    assert isinstance(found, LinearisedEffect) == linear
    ours, theirs = (one.at(columns, {"own.a": 1.3}) for one in (found, effect))
    assert ours.is_near(theirs) and not ours.is_near(Terms())


def test_curtailed_power_is_what_lacks_of_the_usual(plant):
    """Of a record in which a fifth of the hours gives a fifth of the power."""
    rows = np.ones(len(plant), dtype=bool)
    columns = {n: plant[n].to_numpy() for n in ("poa_global", "p_dc_per_area")}
    columns["temp_base"] = plant["temp_air"].to_numpy() + 0.03 * columns["poa_global"]
    effect = EFFECTS["electrical_output"].prepare(columns, rows)
    # the fixture's modules lose nothing to warmth
    assert effect.settings["efficiency"] == pytest.approx(0.18, rel=0.15)
    heat = effect.at(columns, {"electrical_output.share": 1.0}).heat
    ratio = columns["p_dc_per_area"] / np.maximum(columns["poa_global"], 1.0)
    bright = columns["poa_global"] > 300
    held = ratio < 0.1
    assert (heat[bright & ~held] == 0).all()
    gone = 0.8 * 0.18 * columns["poa_global"]
    np.testing.assert_allclose(heat[bright & held], gone[bright & held], rtol=0.2)
    again = find(effect.spec)
    assert again.settings == effect.settings


def test_power_that_snow_takes_is_not_curtailed(plant):
    """Else its heat would be missed where there is no light to make it."""
    columns = {n: plant[n].to_numpy() for n in ("poa_global", "p_dc_per_area")}
    columns["temp_base"] = plant["temp_air"].to_numpy() + 0.03 * columns["poa_global"]
    columns["snow_depth"] = np.full(len(plant), 5.0)
    effect = EFFECTS["electrical_output"].prepare(
        columns, np.ones(len(plant), dtype=bool)
    )
    assert effect.drivers[-1] == "snow_cover"
    columns["snow_cover"] = np.ones(len(plant))
    heat = effect.at(columns, {"electrical_output.share": 1.0}).heat
    assert (heat == 0).all()


def test_after_rain_that_cleans_there_may_be_days_of_grace():
    """As pvlib has it: no dust gathers on damp ground."""
    kimber = {"name": "soiling", "cleaning": 6.0, "within": 24.0, "grace": 14.0}
    (name,) = [n for n in find(kimber).drivers if n != "poa_global"]
    index = pd.date_range("2023-06-01", periods=60 * 24, freq="1h")
    mm = pd.Series(0.0, index)
    mm["2023-06-10 03:00"], mm["2023-07-01 03:00"] = 8.0, 8.0
    inputs = read({"precipitation": mm, "poa_global": mm + 500.0})
    found = pd.Series(derive_drivers(inputs, [name])[name], index)
    theirs = pvlib.soiling.kimber(mm, soiling_loss_rate=0.01, max_soiling=1.0) / 0.01
    # theirs takes the rain of 24 h at their end
    apart = abs(found - theirs)
    assert (apart <= 1.1).all() and apart.median() <= 1.0
    assert (found["2023-06-10 04:00":"2023-06-23"] == 0).all()
    assert found["2023-06-30 03:00"] == pytest.approx(6.0)
    assert found["2023-06-05"].iloc[0] == pytest.approx(4.0)  # none before the record


def test_the_rain_that_cleans_can_be_set():
    """Kimber's 6 mm in 24 h, against 1 mm in 3 h, in pvlib's two functions."""
    kimber = find({"name": "soiling", "cleaning": 6.0, "within": 24})
    assert find(kimber.spec).drivers == kimber.drivers
    assert json.loads(json.dumps(kimber.spec))["within"] == 24
    index = pd.date_range("2023-06-01", periods=40 * 24, freq="1h")
    mm = pd.Series(0.0, index)
    mm["2023-06-10 03:00"] = 2.0  # cleans by the one and not by the other
    mm["2023-06-20 03:00"], mm["2023-06-20 14:00"] = 4.0, 4.0
    inputs = read({"precipitation": mm, "poa_global": mm + 500.0})
    # at the end of each day, of dirt that begins with the record and stays when wet
    options = dict(grace_period=0, soiling_loss_rate=0.01, max_soiling=1.0)
    theirs = pvlib.soiling.kimber(mm, **options) / 0.01
    (days,) = [n for n in kimber.drivers if n != "poa_global"]
    found = derive_drivers(inputs, kimber.drivers)[days]
    usual = derive_drivers(inputs, find("soiling").drivers)["days_since_rain"]
    at = np.flatnonzero((index.day > 21) & (index.month == 6) & (index.hour == 12))
    assert (usual[at] == found[at]).all()
    at = np.flatnonzero((index.day > 11) & (index.day < 19) & (index.month == 6))
    np.testing.assert_allclose(found[at], theirs.iloc[at], atol=1.1)
    np.testing.assert_allclose(found[at] - usual[at], 9 + 3 / 24, atol=1e-9)


@pytest.mark.parametrize("rain", [(6.0, 24.0, 0.0), (4.5, 6.0, 0.0), (8.0, 24.0, 14.0)])
def test_the_record_decides_which_rain_cleans(plant, noise, rain):
    """The rains that wash dirt away, and days of grace, are found as they are."""
    rain = dict(zip(("cleaning", "within", "grace"), rain))
    kimber = find({"name": "soiling", **rain})
    model = ThermalModel(STEADY_MODELS["faiman"], "balance", (kimber,))
    # a rain of one to twelve hours on one day in three
    random, days = np.random.default_rng(4), len(plant) // 288
    hours = random.integers(1, 13, days)[:, None]
    falls = (np.arange(24) < hours) & (random.random(days) < 0.33)[:, None]
    rate = np.where(falls, random.gamma(1.0, 6.0, days)[:, None] / hours, 0.0)
    wet = pd.Series(np.repeat(rate.ravel(), 12), plant.index)
    usual = [plant[n] for n in DRIVERS]
    values = {**coefficients("balance"), "soiling.per_day": -0.005}
    module = model.predict(*usual, values, precipitation=wet)
    data = plant[[*DRIVERS]].assign(
        temp_module=module + noise(len(plant), 0.2), precipitation=wet
    )
    loop = fem.close_loop(data, effects="soiling")
    (effect,) = loop.fit.effects
    assert effect.settings["grace"] == rain["grace"]
    # the same rains clean, though a lesser amount has fallen some hours earlier
    inputs = read(plant[["poa_global"]].assign(precipitation=wet))
    clean = [derive_drivers(inputs, e.drivers)[e.drivers[-1]] for e in (effect, kimber)]
    assert np.mean(np.abs(clean[0] - clean[1]) < 0.25) > 0.98
    found = loop.fit.coefficients["soiling.per_day"]
    assert found == pytest.approx(-0.005, rel=0.1)


@pytest.mark.parametrize("rain", [{}, {"cleaning": 6, "within": 24, "grace": 14}])
@pytest.mark.parametrize("tau", [300.0, 1200.0])
def test_a_module_answers_dirt_as_constant_dirt_times_its_amount(rain, tau):
    """The scan for the rain takes it so: dirt changes from day to day."""
    data = fem.simulator.record(effects=fem.simulator.PHYSICS, days=200, step=300)
    driver = Driver("days_since_rain", **rain)
    names = ("poa_global", "precipitation")
    days = derive_drivers(read({name: data[name] for name in names}), [driver])[driver]
    answer = fem.ewm(data["poa_global"] * days, tau)
    taken = fem.ewm(data["poa_global"], tau) * days
    assert days.max() > 10.0
    assert ((taken - answer) ** 2).sum() < 0.02**2 * (answer**2).sum()


def test_an_effect_that_ends_at_a_bound_is_said_to():
    """It is in no model, and its error is an unexplained pattern."""
    data = datasets.synthetic(365, 600, seed=7, noise=0).tz_localize(None)
    model = ThermalModel(STEADY_MODELS["faiman"], "balance", (find("wind_shape"),))
    values = {"u0": 25.0, "u1": 24.0, "capacity": 17e3, "bias": 0.0}
    values |= {"wind_shape.root": -28.4, "wind_shape.stall": 0.0}
    bound = find("wind_shape").parameters["root"].lower
    assert values["wind_shape.root"] < bound
    module = model.predict(*(data[name] for name in DRIVERS[:3]), values)
    noise = np.random.default_rng(0).normal(0.0, 0.1, len(module))
    data = data[[*DRIVERS[:3]]].assign(temp_module=module + noise)
    loop = fem.close_loop(data, effects="wind_shape")
    assert loop.effects == [] and loop.unexplained
    why = loop.untestable["wind_shape"]
    assert why.reason is Reason.AT_BOUND
    assert why.values["coefficient"] == "wind_shape.root"
    assert f"wind_shape ({why})" in " ".join(loop.report().split())


def rains_explained(seed):
    """
    A function from a law of rain to the share of its dirt that is explained.

    By the law that the first scan finds in two years of rain, and by that of both.
    """
    random, days = np.random.default_rng(seed), 730
    index = pd.date_range("2023-01-01", periods=24 * days, freq="h", tz="Etc/GMT-1")
    light = np.maximum(np.sin(2.0 * np.pi * (index.hour - 6.0) / 24.0), 0.0) * 900.0
    hours, start = (random.integers(*ends, days)[:, None] for ends in ((1, 13), (0, 9)))
    falls = (np.arange(24) >= start) & (np.arange(24) < start + hours)
    amount = random.gamma(0.7, 8.0, days) * (random.random(days) < 0.2)
    rate = (falls * (amount / falls.sum(axis=1))[:, None]).ravel()
    frame = pd.DataFrame({"precipitation": rate, "poa_global": light}, index)
    inputs = read({name: frame[name] for name in frame})
    light = inputs["poa_global"]

    def lost(effect):
        days = derive_drivers(inputs, effect.drivers)[effect.drivers[-1]]
        column = light * days
        return column - (column @ light) / (light @ light) * light

    def scanned(effect, rest):
        columns = Places(inputs, slice(None), effect.scanned_from.drivers)
        even = {"soiling.even": light}
        return effect.scan(rest, even, columns, np.zeros(len(rest)), 0.0)

    def explained(**law):
        rest = lost(soiling_by_rain(**law))
        finer = scanned(scanned(find("soiling"), rest), rest)
        assert finer.scan is None
        coarse = scanned(scanned_over(RAINS, soiling_by_rain), rest)
        columns = [lost(effect) for effect in (coarse, finer)]
        squares = [(one @ rest) ** 2 / (one @ one) for one in columns]
        return squares / (rest @ rest)

    return random, explained


def test_a_rain_between_those_of_the_grid_is_found_near_it():
    """Of dirt that any rain cleans, a second scan explains more than the first."""
    shares = []
    for seed in range(1, 6):
        random, explained = rains_explained(seed)
        for _ in range(12):
            rain = np.exp(random.uniform(np.log(0.5), np.log(12.0)))
            law = {"cleaning": rain, "within": random.uniform(1.0, 24.0)}
            shares.append(explained(**law))
    grid, near = np.transpose(shares)
    assert (near >= grid).all()
    assert near.min() > 0.79
    assert grid.mean() < 0.93 and near.mean() > 0.985


def test_each_law_of_pvlib_for_the_rain_that_cleans_is_found_as_it_is():
    _, explained = rains_explained(1)
    for rain in ((0.5, 1.0), (1.0, 1.0), (1.0, 3.0), (6.0, 24.0), (6.0, 24.0, 14.0)):
        law = dict(zip(("cleaning", "within", "grace"), rain))
        assert explained(**law).min() > 0.999


@pytest.mark.parametrize("closed", [0.0, 0.4, 0.84])
def test_the_record_decides_how_much_of_the_sky_clouds_close(noise, closed):
    """From none, as in `pvlib.temperature.fuentes`, to all that low clouds do."""
    site = fem.simulator.RHINE
    weather = fem.simulator.record(site, {}, 60, 600.0, seed=3)[[*DRIVERS]]
    location = pvlib.location.Location(site.latitude, site.longitude)
    place = {"surface_tilt": 35.0, "surface_azimuth": 180.0}
    angles = sun(weather.index, location).assign(**place)
    sky = {"name": "sky_radiation", "source": "clouds of the day", "cloud_base": closed}
    model = ThermalModel(STEADY_MODELS["faiman"], "balance", (find(sky),))
    values = {**coefficients("balance"), "sky_radiation.share": 0.9}
    module = model.predict(*(weather[n] for n in DRIVERS), values, **angles)
    data = weather.assign(temp_module=module + noise(len(weather), 0.3))
    loop = fem.close_loop(data, location=location, effects="sky_radiation", **place)
    (effect,) = loop.fit.effects
    assert effect.settings["source"] == "clouds of the day"
    assert effect.settings["cloud_base"] == closed
    found = loop.fit.coefficients["sky_radiation.share"]
    assert found == pytest.approx(0.9, rel=0.1)


def stored(noise, **sizes):
    """The loop for thermal storage, of a module with these parts of it."""
    weather = fem.simulator.record(fem.simulator.RHINE, {}, 60, 600.0, seed=3)
    model = ThermalModel(STEADY_MODELS["faiman"], "balance", (find("thermal_storage"),))
    parts = dict.fromkeys(model.effects[0].rows(), 0.0)
    parts |= {f"thermal_storage.{name}": size for name, size in sizes.items()}
    usual = [weather[n] for n in DRIVERS]
    module = model.predict(*usual, coefficients("balance") | parts)
    data = weather[[*DRIVERS]].assign(temp_module=module + noise(len(weather), 0.3))
    return fem.close_loop(data, effects="thermal_storage")


def test_a_mass_has_the_parts_that_the_record_shows(noise):
    loop = stored(noise, hour=0.2, air=6.0)
    (effect,) = loop.fit.effects
    found = {key: loop.fit.coefficients[key] for key in effect.rows()}
    assert {"hour", "air"} <= {*effect.settings["parts"]}
    assert min(found.values()) > 0.0
    assert found["thermal_storage.hour"] == pytest.approx(0.2, abs=0.03)
    assert found["thermal_storage.air"] == pytest.approx(6.0, rel=0.2)
    assert find(effect.spec).spec == effect.spec


def test_no_mass_takes_back_what_it_gave(noise):
    loop = stored(noise, hour=-0.05, three_hours=-0.05, air=-4.0)
    assert not loop.effects
    assert loop.untestable["thermal_storage"].reason is Reason.NO_STORAGE


def test_an_unknown_part_of_a_mass_is_refused():
    with pytest.raises(ValueError, match=r"no part .hours. .did you mean .hour."):
        find({"name": "thermal_storage", "parts": ("hours", "air")})
    with pytest.raises(ValueError, match="needs a part; it has hour, three_hours, air"):
        find({"name": "thermal_storage", "parts": ()})


def test_a_mass_may_have_one_part():
    alone = find({"name": "thermal_storage", "parts": "air"})
    assert [*alone.rows()] == ["thermal_storage.air"]
    assert find(alone.spec).spec == alone.spec


def test_dirt_on_the_sensor_is_no_trend_of_it(monkeypatch):
    """In a dry season of two months a trend explains as much, and comes first."""
    monkeypatch.setattr(study_worlds, "SHIFT", 19310000)
    worlds = dict(study_worlds.FAMILIES["one effect"]())
    (world,) = (one for one in worlds if one.seed == 19313206)
    (case,) = (c for c in worlds[world] if c.label == "soiling_sensor×0.5")
    span = world.days, world.step, world.seed, world.start
    (data,) = fem.simulator.records(world.site, [case.on], *span)
    loop = fem.close_loop(seen(data, case, world.site.forms), **world.place)
    first = loop.finding_objects[0]
    assert first.effect == "soiling"
    assert not any("drift" in f.effect for f in loop.finding_objects if f.added)


def test_a_scan_counts_a_shape_as_nothing_where_its_driver_is_missing():
    random, rows = np.random.default_rng(1), np.arange(200)
    base, winter, own, rest = random.normal(size=(4, len(rows)))
    winter[:20] = np.nan
    evidence = Evidence(
        {"base": base, "season.winter": winter},
        *(rest, rest, rows // 10, rows, ("base",), ()),
        own={"season": ("season.winter",)},
        effects={"season": EFFECTS["season"]},
    )
    seen = {}

    def scan(rest, tangents, *others):
        seen.update(tangents, rest=rest)

    known = np.ones(len(rows), dtype=bool)
    wide = dataclasses.replace(EFFECTS["rain"], columns=())
    scanned = Scanned(scan, wide, {"own": own}, known)
    assert located_effect(evidence, scanned, {}, 0.0) is None
    assert all(np.isfinite(column).all() for column in seen.values())
    np.testing.assert_array_equal(seen["own"], own)
    assert (seen["season.winter"][:20] == 0.0).all()


@pytest.mark.parametrize("driver, searched", [("solar_zenith", 0), ("rain", 1)])
def test_an_effect_of_a_measured_driver_is_searched_in_what_changes_explain(
    driver, searched
):
    """A trend that is in the model may be dirt since the last rain."""
    random, rows = np.random.default_rng(1), np.arange(200)
    base, own, *both = random.normal(size=(4, len(rows)))
    evidence = Evidence({"base": base}, *both, rows // 10, rows, ("base",), ())
    seen = {}

    def scan(rest, *others):
        seen["rest"] = rest

    known = np.ones(len(rows), dtype=bool)
    wide = dataclasses.replace(EFFECTS["rain"], columns=(driver,))
    located_effect(
        evidence, Scanned(scan, wide, {"own": own}, known), {driver: rows}, 0.0
    )
    rest = both[searched]
    expected = rest - base * (base @ rest) / (base @ base)
    np.testing.assert_allclose(seen["rest"], expected, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(
    ("spec", "driver"),
    [
        ({"name": "rain", "source": "humidity", "drying": 3600}, "film_vapour(dry"),
        ({"name": "sky_radiation", "source": "humidity", "cloud_base": 0.7}, "sky_def"),
        ({"name": "wind_shape", "calm": 1.5}, "wind_speed"),
        ({"name": "electrical_output", "efficiency": 0.2, "gamma": -0.004}, "poa_gl"),
    ],
)
def test_a_constant_of_an_effect_reaches_what_it_adds(plant, spec, driver):
    usual = {key: value for key, value in spec.items() if key in NAMING}
    heats = []
    for one in (spec, usual):
        effect = find(one)
        assert find(json.loads(json.dumps(effect.spec))).spec == effect.spec
        base = coefficients("balance")
        model = ThermalModel(STEADY_MODELS["faiman"], "balance", (effect,), base)
        inputs = {n: plant[n] for n in (*DRIVERS, *model.drivers)}
        most = {key: row.upper for key, row in effect.rows().items()}
        terms = effect.at(model.with_drivers(read(inputs)).columns, most)
        heats.append(terms.heat + terms.loss)
    assert find(spec).drivers[0].startswith(driver)
    assert np.abs(heats[0] - heats[1]).max() > 0.1


NAMING = ("name", "source", "efficiency")


def test_a_constant_by_name_alone_reaches_all_variants():
    sky = find({"name": "sky_radiation", "cloud_base": 0.7})
    assert [form.settings.get("cloud_base") for form in sky.variants] == [
        *(None, 0.7, 0.7, None, None)
    ]
    assert not any(form.scan for form in sky.variants)  # which would set another
    assert sky.drivers == ("sky_deficit",)  # it takes none itself


def test_an_effect_that_needs_the_modules_temperature_needs_a_base(plant):
    model = model_with("balance", "radiative_loss")
    with pytest.raises(ValueError, match="need temp_base, and the model has no base"):
        model.with_drivers(read({n: plant[n] for n in DRIVERS}))


def test_the_base_is_the_fit_without_effects(plant, noise, tmp_path):
    """On other weather, too: in a fit, in JSON and in a model of it."""
    names = ("radiative_loss", "natural_convection")
    values = coefficients("balance", *names)
    module = predicted(plant, model_with("balance", *names), values)
    module = module + noise(len(plant), 0.2)
    usual = [plant[n] for n in DRIVERS]
    options = dict(model="faiman", dynamics="balance")
    fit = fem.fit_fem(*usual, module, effects=names, **options)
    alone = fem.fit_fem(*usual, module, **options)
    assert alone.base is None and set(fit.base) == set(alone.coefficients)
    assert fit.base
    for name, value in fit.base.items():
        assert value == pytest.approx(alone.coefficients[name], rel=1e-3), name
    other = [plant[n].iloc[:2000] + shift for n, shift in zip(DRIVERS, (0, -8, 1))]
    here = fit.predict(*other)
    base = fem.heat_balance(*other, model="faiman", **fit.base)
    again = ThermalModel(STEADY_MODELS["faiman"], "balance", fit.effects)
    inputs = again.with_drivers(read({**dict(zip(DRIVERS, other)), "temp_base": base}))
    there = again.temperature(inputs, fit.coefficients)
    np.testing.assert_allclose(here, there, rtol=1e-12)
    fit.to_json(tmp_path / "fit.json")
    chain = fem.DynamicCellTemperature.from_json(tmp_path / "fit.json")
    assert chain.base == fit.base == fit.temperature_model(deltaT=0.0).base


@pytest.mark.parametrize("name", ["soiling", "rain", "snow", "sky_radiation"])
def test_where_a_driver_lacks_there_is_no_temperature(plant, name):
    """A gap is no dry hour, and no bare module."""
    (effect,) = [f for f in EFFECTS[name].forms if f.drivers][:1]
    base = {"u0": 25.0, "u1": 6.0, "capacity": 15e3, "bias": 0.0}
    model = ThermalModel(STEADY_MODELS["faiman"], "balance", (effect,), base=base)
    values = {**base, **{key: 0.3 * row.upper for key, row in effect.rows().items()}}
    usual = [plant[n] for n in DRIVERS]
    drivers = {n: plant[n] for n in model.drivers}
    whole = model.predict(*usual, values, **drivers)
    some = slice(400, 460)
    assert drivers
    for column in drivers:
        gap = drivers[column].copy()
        gap.iloc[some] = np.nan
        found = model.predict(*usual, values, **{**drivers, column: gap})
        assert found.iloc[some].isna().all()
        assert found.drop(found.index[some]).notna().all()
        assert whole.notna().all()
