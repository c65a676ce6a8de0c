"""What findings are worth: the energy that a known fault changes."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from conftest import COLUMNS, DRIVERS
from test_corrected import (  # noqa: F401 (fixtures)
    TRUTH,
    effect_of,
    faulty,
    found,
    sound,
    true,
)

import pvlib_fem as fem
from pvlib_fem import simulator
from pvlib_fem._statements import make
from pvlib_fem._statements.statement import DAYS
from pvlib_fem._statements.worth import energies
from pvlib_fem._thermal.model import ThermalModel
from pvlib_fem._thermal.steady_models import STEADY_MODELS
from pvlib_fem.drivers import needed_for
from pvlib_fem.scores import GAMMA

HOURS = 0.5  # of a row
MODEL = ThermalModel(STEADY_MODELS["faiman"], "balance")


def energy(data, temperature):
    """Expected DC energy of rows. [kWh/kWp]"""
    efficiency = 1.0 + GAMMA * (temperature - 25.0)
    return data["poa_global"] / 1000.0 * HOURS * efficiency


def modelled(data):
    return MODEL.predict(*(data[name] for name in DRIVERS), TRUTH)


def yearly(change):
    return np.abs(change).sum() * 365.2425 / 200.0


@pytest.mark.parametrize("size", [-0.1, 0.12])
def test_an_irradiance_sensor_costs_its_light_and_its_temperature(true, sound, size):  # noqa: F811
    """What is expected by the true irradiance, less that by what is read."""
    effect = effect_of("irradiance_sensor_step")
    data = faulty(true, effect, size)
    loop = found(sound, data, effect)
    (one,) = loop.statements.itertuples()
    change = energy(true, modelled(true)) - energy(data, modelled(data))
    assert one.energy == pytest.approx(yearly(change), rel=0.03)
    # most of it is the light itself
    light = (true["poa_global"] - data["poa_global"]).abs().sum() / 1000.0 * HOURS
    assert one.energy == pytest.approx(light * 365.2425 / 200.0, rel=0.1)


@pytest.mark.parametrize(
    "name, size", [("anemometer_step", 4.0), ("air_offset_step", 2)]
)
def test_another_sensor_costs_what_its_temperature_costs(true, sound, name, size):  # noqa: F811
    """The model by what is read, and by the truth, at the true irradiance."""
    effect = effect_of(name)
    data = faulty(true, effect, size / (TRUTH["u1"] if "wind" in name else 1.0))
    (one,) = found(sound, data, effect).statements.itertuples()
    change = energy(true, modelled(true)) - energy(true, modelled(data))
    assert one.energy == pytest.approx(yearly(change), rel=0.1)


def test_a_clock_costs_what_the_shifted_temperature_costs():
    data = simulator.record(days=60, step=1800.0, start="2023-05-01")[list(COLUMNS)]
    module = data["temp_module"]
    late = data.assign(temp_module=module.shift(2)).dropna()
    loop = fem.close_loop(late, effects=[])
    one = loop.statements.iloc[0]
    change = energy(late, late["temp_module"]) - energy(late, module[late.index])
    wanted = np.abs(change).sum() * 365.2425 / 60.0
    assert one.energy == pytest.approx(wanted, rel=0.03) and wanted > 10.0


def test_it_scales_with_the_temperature_coefficient(true, sound):  # noqa: F811
    effect = effect_of("air_offset_step")
    loop = found(sound, faulty(true, effect, 2.0), effect)
    (name,) = energies(loop)
    assert energies(loop, 2 * GAMMA)[name] == pytest.approx(2 * energies(loop)[name])
    page = loop.to_html(gamma=2 * GAMMA)
    assert f"{2 * loop.yearly_energy[name]:.1f}</td>" in page and "-0.7 %/K" in page


def test_the_most_valuable_comes_first_and_a_file_keeps_it(true, sound, tmp_path):  # noqa: F811
    """By energy, though another one takes more off the error."""
    effects = [
        effect_of(n) for n in ("module_sensor_contact_step", "irradiance_sensor_drift")
    ]
    data = faulty(faulty(true, effects[0], 0.15), effects[1], 0.2)
    loop = found(sound, data, *effects)
    first, second = loop.statements.itertuples()
    assert (
        first.cause == "irradiance_sensor_drift" and first.energy > second.energy > 0.0
    )
    text = loop.to_json(path := tmp_path / "loop.json")
    stored = [one["energy"] for one in json.loads(text)["statements"]]
    again = fem.Loop.from_json(path)
    assert stored == [*loop.statements["energy"]] == [*again.statements["energy"]]
    for page in (loop.to_html(), again.to_html()):
        cells = [page.index(f">{one.energy:.1f}</td>") for one in (first, second)]
        assert cells == sorted(cells) and "per year]" in page


def test_statements_are_made_once(true, sound, monkeypatch):  # noqa: F811
    effect = effect_of("module_sensor_contact_step")
    loop = found(sound, faulty(true, effect, 0.2), effect)
    made = []
    real = make.statements_of
    monkeypatch.setattr(make, "statements_of", lambda *a: made.append(1) or real(*a))
    print(loop, loop.to_html()[:1], loop.to_json()[:1], len(loop.statements))
    assert made == [1] and loop.conclusion


@pytest.fixture(scope="module")
def too_short():
    """A loop that sees an effect, and whose record is too short to add it."""
    effects = simulator.PHYSICS | {"sky_radiation": 1.0, "wind_direction": 1.0}
    data = simulator.record(effects=effects, days=45, step=1800.0, start="2023-04-01")
    drivers = ["wind_direction", "longwave_down"]
    return fem.close_loop(data[[*COLUMNS, *drivers]])


def test_a_hint_is_worth_what_its_effect_would_be_worth_in_the_model(too_short):
    """By the difference of the whole model to that without it."""
    hints = [f for f in too_short.finding_objects if f.verdict == "hint"]
    energies_of_hints = too_short.statements.set_index("cause")["energy"]
    assert hints and {f.effect for f in hints} == {
        e.name for e in too_short.hint_effects
    }
    for hint, effect in zip(hints, too_short.hint_effects, strict=True):
        fit = too_short.fit
        fit = replace(
            fit,
            effects=(*fit.effects, effect),
            coefficients=fit.coefficients | hint.coefficients,
        )
        added = replace(too_short, fit=fit, hint_effects=())
        wanted = energies(added)[effect.name]
        assert energies_of_hints[hint.effect] == pytest.approx(wanted, rel=1e-6)
        assert wanted > 0.1
        nothing = replace(hint, coefficients=dict.fromkeys(hint.coefficients, 0.0))
        without = replace(too_short, finding_objects=(nothing,))
        assert energies(without)[effect.name] == pytest.approx(0.0, abs=1e-9)


def test_a_page_and_a_file_have_the_energy_of_a_hint(too_short, tmp_path):
    too_short.to_json(path := tmp_path / "loop.json")
    again = fem.Loop.from_json(path)
    (first, *_) = (s for s in too_short.statements.itertuples() if s.verdict == "hint")
    pd.testing.assert_frame_equal(again.statements, too_short.statements)
    for loop in (too_short, again):
        assert f", {first.energy:.1f} kWh/kWp per year" in loop.to_html()
        assert f"{first.energy:.2g} kWh/kWp a year" in str(loop)


def test_days_that_stand_out_are_worth_their_mean_residual(too_short):
    days = pd.DataFrame(
        {"start": ["2023-04-10"], "end": ["2023-04-11"], "days": 2, "day": -2.0}
    ).assign(night=1.0, share=0.1)
    days = days.astype({"start": "datetime64[ns]", "end": "datetime64[ns]"})
    loop = replace(too_short, episodes=days)
    record = loop.fit.record
    light = pd.Series(record["poa_global"], record.index)["2023-04-10":"2023-04-11"]
    wanted = light.sum() / 1000.0 * HOURS * 2.0 * abs(GAMMA) * 365.2425 / 45
    (one,) = (s for s in loop.statements.itertuples() if s.cause == DAYS)
    assert one.energy == pytest.approx(wanted)


def test_means_of_five_minutes_are_worth_what_minutes_are(monkeypatch):
    effects = simulator.PHYSICS | {"wind_direction": 1.0}
    data = simulator.record(effects=effects, days=70, step=60.0, start="2023-05-01")
    loop = fem.close_loop(data[[*COLUMNS, "wind_direction"]])
    assert "wind_direction" in loop.effects
    means = energies(loop)
    monkeypatch.setattr("pvlib_fem._statements.worth.STEP", 60.0)
    minutes = energies(loop)
    assert minutes
    for name, energy_of_minutes in minutes.items():
        assert means[name] == pytest.approx(energy_of_minutes, rel=0.03)


def test_an_effect_of_the_model_is_worth_what_a_fit_without_it_misses():
    """And not the part that another bias or loss makes up, which is most of it."""
    effects = simulator.PHYSICS | {"wind_direction": 1.0, "sky_radiation": 1.0}
    data = simulator.record(effects=effects, days=100, step=900.0, start="2023-04-01")
    columns = [data[name] for name in COLUMNS]
    drivers = {n: data[n] for n in ("wind_direction", "longwave_down")}
    loop = fem.close_loop(data[[*COLUMNS, *drivers]])
    how = dict(model="faiman", dynamics="balance", night=True, holdout=loop.fit.holdout)
    checked = 0
    for name in {"wind_direction", "sky_radiation"} & {*loop.effects}:
        others = [e for e in loop.fit.effects if e.name != name]
        needed = {n for e in others for n in needed_for(e.drivers)}
        used = {n: c for n, c in drivers.items() if n in needed}
        without = fem.fit_fem(*columns, **how, effects=others, **used)
        change = loop.fit.residual - without.residual
        light = data["poa_global"] / 1000.0 * 0.25 * GAMMA
        missed = np.abs(light * change).sum() * 365.2425 / 100.0
        whole = loop.contributions(data)[name]
        full = np.abs(light * whole).sum() * 365.2425 / 100.0
        assert loop.yearly_energy[name] == pytest.approx(missed, rel=0.3)
        assert loop.yearly_energy[name] < 0.9 * full
        checked += 1
    assert checked
