"""Names that have changed: the old one works, and says what to write."""

import dataclasses
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

import pvlib_fem as fem
from pvlib_fem import simulator
from pvlib_fem._cli import main
from pvlib_fem._findings import CheckOutcome, CrossCheck, Finding, Verdict
from pvlib_fem._former_names import in_new_names
from pvlib_fem._record.column_names import COLUMNS, with_aliases
from pvlib_fem._record.guess import guess
from pvlib_fem._record.layout import Layout
from pvlib_fem._record.logger_files import read_file
from pvlib_fem._record.parquet import open_parquet
from pvlib_fem._recovery.draw import Injection
from pvlib_fem._recovery.judge import Outcome
from pvlib_fem._recovery.trial import Trial
from pvlib_fem._stored import Stored, as_json
from pvlib_fem.effects import CHANGES, find
from pvlib_fem.fleet._systems_table import opened_table, systems_of
from pvlib_fem.quality import Limits
from pvlib_fem.reasons import Reason, because

NOW = "p_dc is called p_dc_per_area now.*power_dc for W of a module or a plant"


ROOT = Path(__file__).parents[2]
FUNCTIONS = {
    "compare": "compare_models",
    "recover": "recover_effects",
    "screen": "screen_record",
    "translate": "translate_coefficients",
}


@pytest.mark.parametrize(("before", "after"), FUNCTIONS.items())
def test_a_function_has_its_old_name_until_the_next_release(before, after):
    instead = f"pvlib_fem.{before} is called {after} now.*0.2.*write pvlib_fem.{after}"
    for get in (lambda: getattr(fem, before), lambda: imported(before)):
        with pytest.warns(FutureWarning, match=instead) as said:
            assert get() is getattr(fem, after)
        assert {warning.filename for warning in said} == {__file__}
    assert after in fem.__all__ and before not in fem.__all__
    page = (ROOT / "docs" / "stability.md").read_text("utf-8")
    assert f"| `pvlib_fem.{before}` | `{after}` | 0.2 |" in page


def test_what_goes_in_a_release_is_gone_in_it():
    top = (ROOT / "CHANGELOG.md").read_text("utf-8").split("\n## ")[1]
    rows = (ROOT / "docs" / "stability.md").read_text("utf-8").splitlines()
    goes = [row.split("|")[-2].strip() for row in rows if row.startswith("| `pvlib_")]
    assert goes and all(release > top.split()[0] for release in goes)


def imported(name):
    space = {}
    exec(compile(f"from pvlib_fem import {name}", __file__, "exec"), space)
    return space[name]


def test_a_name_that_never_was_has_no_warning():
    with pytest.raises(AttributeError, match="compares"):
        fem.compares  # noqa: B018


@pytest.fixture(scope="module")
def plant():
    data = simulator.record(days=10, step=1800, seed=3)
    return data[[*COLUMNS, "p_dc_per_area"]]


@pytest.fixture(scope="module")
def old(plant):
    return plant.rename(columns={"p_dc_per_area": "p_dc"})


def test_a_frame_of_the_old_name_gives_what_the_new_one_gives(plant, old):
    want = fem.fit_fem(plant, effects="electrical_output").coefficients
    with pytest.warns(FutureWarning, match=NOW):
        assert fem.fit_fem(old, effects="electrical_output").coefficients == want
    columns = [plant[name] for name in COLUMNS]
    with pytest.warns(FutureWarning, match=NOW):
        found = fem.fit_fem(*columns, effects="electrical_output", p_dc=old["p_dc"])
    assert found.coefficients == want


def test_beside_the_new_name_the_old_one_is_a_column_as_any(plant):
    """As pvlib has it: W, and not by area."""
    both = with_aliases(plant.assign(p_dc=1.0))
    assert {"p_dc", "p_dc_per_area"} <= {*both}


def test_files_of_the_old_name_are_read(old, plant, tmp_path):
    old.to_csv(tmp_path / "plant.csv", index_label="time")
    old.to_parquet(tmp_path / "plant.parquet")
    for path, read in (("plant.csv", read_file), ("plant.parquet", open_parquet)):
        with pytest.warns(FutureWarning, match=NOW):
            found = read(tmp_path / path)
        names = found.columns
        assert "p_dc_per_area" in names and "p_dc" not in names


@pytest.mark.filterwarnings("default")
def test_options_and_tables_of_the_old_name_are_understood(old, tmp_path):
    path = tmp_path / "plant.csv"
    plant = old.drop(columns="p_dc").assign(power=old["p_dc"] * 24.0 / 1000.0)
    plant.to_csv(path, index_label="time")
    words = ["fit", path, "--map", "p_dc=power", "--unit", "p_dc=kW", "--effects"]
    words += ["electrical_output", "--module-area", "24"]
    done = CliRunner().invoke(main, [*map(str, words)])
    assert done.exit_code == 0 and re.search(NOW, done.output), done.output
    assert "p_dc_per_area converted from kW to W/m²" in done.output
    table = pd.DataFrame({"id": ["a"], "file": [path], "p_dc": "power"})
    table = table.assign(p_dc_unit="kW", module_area=24.0)
    with pytest.warns(FutureWarning, match=NOW):
        (system,) = systems_of(opened_table(table))
    assert system.columns == {"p_dc_per_area": "power"}
    assert system.units == {"p_dc_per_area": "kW"}


def test_an_effect_of_ones_own_may_have_the_old_name(plant):
    def terms(p_dc, *, share):
        return fem.Terms(heat=-share * p_dc)

    rows = {"share": fem.Parameter(0.0, 0.0, 4.0, "-")}
    with pytest.warns(FutureWarning, match=NOW):
        found = fem.fit_fem(plant, effects=fem.Effect("output", terms, rows))
    want = fem.fit_fem(plant, effects="electrical_output").residual
    pd.testing.assert_series_equal(found.residual, want)
    named = replace(fem.Effect("output", terms, rows), columns=("p_dc_per_area",))
    pd.testing.assert_series_equal(fem.fit_fem(plant, effects=named).residual, want)


POWERS = {
    "P_DC (kW)": "power_dc",
    "p_dc": "power_dc",
    "DC Power [W/m²]": "power_dc",
    "System Power (kW)": "power_ac",
    "AC kW": "power_ac",
    "DC kW": "power_dc",
    "DC (kW)": "power_dc",
    "Neerslag (mm/10min)": "precipitation",
    "inverter_power": "power_ac",
}


@pytest.mark.parametrize("header", POWERS)
def test_no_guess_takes_power_for_power_by_area(header, plant, tmp_path):
    path = tmp_path / "plant.csv"
    power = plant["p_dc_per_area"]
    data = plant.drop(columns="p_dc_per_area").assign(**{header: power})
    data.to_csv(path, index_label="time")
    found = guess([path], [Layout()], {})
    assert found.columns[POWERS[header]] == header
    assert "p_dc_per_area" not in found.columns


def test_power_by_area_under_its_own_name_is_not_mapped_to_anything(plant, tmp_path):
    path = tmp_path / "plant.csv"
    plant.to_csv(path, index_label="time")
    assert "power_dc" not in guess([path], [Layout()], {}).columns


@pytest.mark.parametrize(("unit", "watt"), [("W", 1.0), ("kW", 1e3), ("MW", 1e6)])
def test_power_of_a_plant_is_converted_and_its_codes_stay(unit, watt, plant, tmp_path):
    path = tmp_path / "plant.csv"
    power = plant["p_dc_per_area"].to_numpy(copy=True)
    power[7] = -9999.0
    plant[[*COLUMNS]].assign(p=power).to_csv(path, index_label="time")
    data = read_file(path, {"power_ac": "p"}, {"power_ac": unit})["power_ac"]
    want = np.where(power == -9999.0, power, watt * power)
    np.testing.assert_allclose(data, want)


OLD_FAULTS = {
    "sensitivity_step": "irradiance_sensor_step",
    "contact_drift": "module_sensor_contact_drift",
    "wind_gain_episode": "anemometer_episode",
    "wind_stall_step": "anemometer_stall_step",
    "air_shelter_drift": "air_sensor_shield_drift",
}


@pytest.mark.parametrize(("before", "after"), OLD_FAULTS.items())
def test_a_sensor_fault_has_its_old_name_until_the_next_release(before, after):
    with pytest.warns(FutureWarning, match=f"{before} is called {after} now") as said:
        assert find(before) is find(after)
    assert {warning.filename for warning in said} == {__file__}


def test_new_names_are_no_old_ones():
    for name in CHANGES:
        assert in_new_names(name) == name == in_new_names(f"{name}.change")[: len(name)]
    for word in ("contact", "contact_sensor", "sensitivity", "my_contact_step"):
        assert in_new_names(word) == word


def test_a_file_with_old_names_is_read(tmp_path):
    effect = {"name": "irradiance_sensor_step", "at": "2023-04-20"}
    data = simulator.record(days=30, step=3600, start="2023-04-01")
    inputs = [data[name] for name in COLUMNS]
    held = {"sensitivity_step.change": 0.1}
    with pytest.warns(FutureWarning, match="irradiance_sensor_step now"):
        fit = fem.fit_fem(*inputs, effects=effect, fixed=held)
    assert fit.coefficients["irradiance_sensor_step.change"] == 0.1
    text = fit.to_json(tmp_path / "new.json")
    old = tmp_path / "old.json"
    old.write_text(text.replace("irradiance_sensor_step", "sensitivity_step"), "utf-8")
    with pytest.warns(FutureWarning, match="sensitivity_step is called"):
        again = fem.FemFit.from_json(old)
    assert again.to_json() == text


@pytest.fixture
def finding():
    """Its irradiance sensor is cross-checked twice, once with a result."""
    size, error = 0.1, 0.01
    power = ("power_dc", "irradiance_sensor_step", size, error, size)
    sky = ("clear sky", "irradiance_sensor_step", size, 1.0, size)
    return Finding(
        "irradiance_sensor_step",
        ("irradiance_sensor_step",),
        Verdict.IDENTIFIED,
        1.0,
        {},
        {},
        because(Reason.CORROBORATED, columns=["power_dc"]),
        cross_checks=(
            CrossCheck(*power, CheckOutcome.AGREES),
            CrossCheck(*sky, CheckOutcome.CANNOT_TELL),
        ),
    )


def test_cross_checks_have_their_old_names_until_the_next_release(finding):
    with pytest.warns(FutureWarning, match="witnesses is called cross_checks") as said:
        assert finding.witnesses == finding.cross_checks
    assert {warning.filename for warning in said} == {__file__}
    first, second = finding.cross_checks
    with pytest.warns(FutureWarning, match="heard is called conclusive_checks"):
        assert finding.heard == finding.conclusive_checks == (first,)
    with pytest.warns(FutureWarning, match="opinion is called outcome"):
        assert second.opinion is CheckOutcome.CANNOT_TELL


def test_cross_checks_of_an_old_file_are_read(finding):
    content = as_json(finding)
    assert Stored(content, "new.json").whole(Finding) == finding
    checks = content.pop("cross_checks")
    old = [{**one, "opinion": one["outcome"]} for one in checks]
    for one in old:
        del one["outcome"]
    with pytest.warns(FutureWarning, match=r"(witnesses|opinion) is called") as said:
        again = Stored({**content, "witnesses": old}, "old.json").whole(Finding)
    assert again == finding and len(said) == 3


def test_a_file_with_old_verdicts_is_read(tmp_path):
    effects = simulator.PHYSICS | {"sky_radiation": 1.0, "wind_direction": 1.0}
    data = simulator.record(effects=effects, days=120, step=1800, start="2023-04-01")
    loop = fem.close_loop(data)
    text = loop.to_json()
    assert '"verdict": "identified"' in text
    old = tmp_path / "old.json"
    for now, before in (("identified", "named"), ("ambiguous", "class")):
        text = text.replace(f'"verdict": "{now}"', f'"verdict": "{before}"')
    old.write_text(text, "utf-8")
    again = fem.Loop.from_json(old)
    pd.testing.assert_frame_equal(again.findings, loop.findings)


def test_outcomes_and_trials_have_their_old_names_until_the_next_release():
    injection = Injection("snow", 0, {}, {"snow.cover": 0.1}, 0.1, 0.1, 0.0)
    outcome = Outcome(injection, True, identified=True, reported=("snow",))
    trial = Trial("dates", 0, "weeks", ("snow",), ("snow",), ("snow | rain",))
    with pytest.warns(FutureWarning, match="is called"):
        assert outcome.named and outcome.told == ("snow",)
        assert (trial.named, trial.classes) == (("snow",), ("snow | rain",))
    for one, names in (
        (outcome, {"identified": "named", "reported": "told"}),
        (trial, {"identified": "named", "ambiguous": "classes"}),
    ):
        content = as_json(one)
        old = {names.get(key, key): value for key, value in content.items()}
        assert {*names.values()} <= {*old}
        with pytest.warns(FutureWarning, match="is called"):
            again = Stored(old, "old.json").whole(type(one))
        assert as_json(again) == content


@pytest.mark.parametrize(
    ("kind", "old", "new", "value"),
    [
        (fem.Criteria, "min_gain", "min_rmse_reduction", 0.3),
        (fem.Criteria, "enough_days", "min_days", 90),
        (Limits, "calm", "stale_calm_window", 3600.0),
    ],
)
def test_thresholds_have_their_old_names_until_the_next_release(kind, old, new, value):
    with pytest.warns(FutureWarning, match=rf"argument {old} is called {new} now"):
        given = kind(**{old: value})
    assert given == kind(**{new: value}) != kind()
    with pytest.warns(FutureWarning, match=rf"{kind.__name__}.{old} is called {new}"):
        assert getattr(given, old) == value
    with pytest.raises(TypeError, match="give one of them"):
        kind(**{old: value, new: value})
    content = as_json(given)
    content[old] = content.pop(new)
    with pytest.warns(FutureWarning, match=rf"{old} is called {new}"):
        assert Stored(content, "old.json").whole(kind) == given


def test_every_old_threshold_has_a_field():
    for kind in (fem.Criteria, Limits):
        fields = {one.name for one in dataclasses.fields(kind)}
        assert kind.renamed_in_file
        assert {*kind.renamed_in_file.values()} <= fields
        assert not {*kind.renamed_in_file} & fields


def test_the_loop_takes_its_old_argument():
    data = fem.datasets.synthetic(days=10, step=1800)
    with pytest.warns(FutureWarning, match="min_gain is called min_rmse_reduction now"):
        loop = fem.close_loop(data, min_gain=0.4)
    assert loop.criteria.min_rmse_reduction == 0.4
