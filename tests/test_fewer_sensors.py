"""Records of plants that have fewer sensors than a laboratory."""

import numpy as np
import pandas as pd
import pytest
from conftest import call, proposed

import pvlib_fem as fem
from pvlib_fem import datasets, fleet
from pvlib_fem.effects import CHANGES, EFFECTS

USUAL = ["poa_global", "temp_air", "temp_module"]


@pytest.fixture(scope="module")
def calm():
    """Sixty days of a module that no wind reaches, and of no anemometer."""
    how = dict(model="ross", k=0.03, capacity=15e3, bias=0.5)
    return datasets.synthetic(60, 600, seed=4, noise=0.2, **how)[USUAL]


@pytest.fixture(scope="module")
def loop(calm):
    return fem.close_loop(calm, model="ross")


@pytest.mark.parametrize("dynamics", ["steady", "ewm", "balance"])
@pytest.mark.parametrize("model", ["ross", "noct"])
def test_a_model_without_wind_is_the_same_with_any(calm, model, dynamics):
    """Rows count by their wind, too, which is within limits here."""
    how = dict(model=model, dynamics=dynamics)
    fit = fem.fit_fem(calm, **how)
    windy = calm.assign(wind_speed=datasets.synthetic(60, 600, seed=4)["wind_speed"])
    other = fem.fit_fem(windy, **how)
    assert fit.coefficients == pytest.approx(other.coefficients, rel=1e-9)
    assert fit.stderr == pytest.approx(other.stderr, rel=1e-6, nan_ok=True)
    by_columns = fem.fit_fem(*(calm[n] for n in USUAL[:2]), None, calm[USUAL[2]], **how)
    assert by_columns.coefficients == fit.coefficients
    assert "there is no wind_speed" in fit.notes[0]
    assert not any("wind_speed" in note for note in other.notes)
    found = fit.predict(calm)
    pd.testing.assert_series_equal(found, fit.predict(windy))
    if (model, dynamics) == ("ross", "balance"):
        assert fit.coefficients["k"] == pytest.approx(0.03, rel=0.03)


def test_a_file_of_such_a_fit_predicts_the_same(calm, tmp_path):
    fit = fem.fit_fem(calm, model="ross", dynamics="balance")
    fit.to_json(tmp_path / "fit.json")
    again = fem.FemFit.from_json(tmp_path / "fit.json")
    pd.testing.assert_series_equal(again.predict(calm), fit.predict(calm))
    assert "wind_speed" not in again.summary.columns
    table = fit.thermal_parameters()
    assert table.loc["ross", "value"].item() > 0.0
    assert "wind" in table.loc[("prilliman", "unit_mass"), "note"]
    assert "nobody measured" in table.loc[("ross", "k"), "conditions"]


@pytest.mark.parametrize(
    ("how", "words"),
    [
        (dict(), "which the model wm1 needs; .*give it, or model='ross'"),
        (dict(model="faiman", dynamics="balance"), "which the model faiman needs"),
        (
            dict(model="ross", effects=["natural_convection", "rain"]),
            "which natural_convection needs; .*drop the effect",
        ),
        (dict(model="ross", method="paper"), "method='paper' needs wind_speed"),
    ],
)
def test_what_needs_wind_is_refused_with_a_remedy(calm, how, words):
    data = calm.assign(precipitation=0.0)
    with pytest.raises(ValueError, match=words):
        fem.fit_fem(data, **how)


def test_the_loop_tries_what_needs_no_wind(calm, loop):
    assert loop.fit.model == "ross" and not loop.effects
    wind = [n for n, e in CHANGES.items() if e.channel in ("wind_gain", "wind_stall")]
    wind += ["natural_convection", "wind_shape", "air_shield"]
    assert {str(loop.untestable[name]) for name in wind} == {"no wind_speed"}
    assert str(loop.untestable["wind_direction"]) == "no wind_direction, wind_speed"
    tried = {*EFFECTS, *CHANGES} - {*loop.untestable} - {"radiative_loss"}
    assert {"thermal_storage", "sensitivity_step", "contact_step"} <= tried | {
        *loop.ranking.index
    }
    words = str(loop)
    assert "the wind's coefficient" not in words
    assert words.count("there is no wind_speed") == 1
    with pytest.raises(ValueError, match=r"data lack wind_speed.*model='ross'"):
        fem.close_loop(calm)


def test_the_loop_finds_a_step_without_wind(calm):
    data, there = calm.copy(), calm.index >= "2023-07-05"
    data["temp_module"] += 3.0 * there
    found = fem.close_loop(data, model="ross")
    assert found.effects == ["module_offset_step"]
    (finding,) = (f for f in found.findings if f.added)
    (size,) = finding.coefficients.values()
    assert size == pytest.approx(3.0, abs=0.3)
    residual = found.residual(data)
    assert residual.std() < 0.6 and found.to_html()
    again = found.predict(data.assign(wind_speed=np.nan))
    pd.testing.assert_series_equal(again, found.predict(data))
    fixed = found.corrected(data, "module_offset_step")
    assert np.abs(fixed.data["temp_module"] - calm["temp_module"]).mean() < 0.4


def test_files_without_wind_are_fitted_as_frames(calm, loop, tmp_path):
    for day, part in calm.groupby(calm.index.date):
        part.to_parquet(tmp_path / f"{day}.parquet")
    fit = fem.fit_fem(tmp_path, model="ross", dynamics="balance")
    alone = fem.fit_fem(calm, model="ross", dynamics="balance")
    assert fit.coefficients == pytest.approx(alone.coefficients, rel=1e-6)
    assert fit.summary.columns == alone.summary.columns
    assert fit.summary.sha256 == alone.summary.sha256
    assert any("there is no wind_speed" in note for note in fit.notes)
    found = fem.close_loop(tmp_path, model="ross")
    assert found.fit.coefficients == pytest.approx(loop.fit.coefficients, rel=1e-6)
    with pytest.raises(ValueError, match="data lack wind_speed"):
        fem.fit_fem(tmp_path)


def test_the_command_proposes_the_model_that_a_file_allows(calm, tmp_path):
    file = tmp_path / "plant.csv"
    names = dict(
        zip(USUAL, ("Irr tilted (W/m2)", "T ambient (degC)", "T module (degC)"))
    )
    calm.tz_localize(None).rename(columns=names).to_csv(file, sep=";", decimal=",")
    for command in ("fit", "loop"):
        refused = call(command, file)
        assert refused.exit_code == 1
        done = call(*proposed(refused))
        assert done.exit_code == 0, done.output
        assert "ross" in done.stdout and "there is no wind_speed" in done.stdout
    calm.to_csv(file)
    refused = call("fit", file, "--model", "faiman")
    assert "no column wind_speed" in refused.output
    assert "or give --model ross if there is none" in refused.output


def test_a_fleet_mixes_systems_with_and_without_wind(calm, tmp_path):
    windy = datasets.synthetic(14, 900, seed=1)[[*USUAL, "wind_speed"]]
    windy.to_csv(tmp_path / "a.csv")
    for name in ("b", "c"):
        calm.to_csv(tmp_path / f"{name}.csv")
    rows = {"id": ["a", "b", "c"], "file": ["a.csv", "b.csv", "c.csv"]}
    systems = pd.DataFrame(rows).assign(steady_model=["", "ross", ""])
    systems["file"] = [str(tmp_path / name) for name in systems["file"]]
    how = dict(task="fit", workers=0, model="faiman")
    found = fleet.run(systems, tmp_path / "out", **how).systems.set_index("id")
    assert found["state"].to_list() == ["done", "done", "failed"]
    assert found["model"].to_list()[:2] == ["faiman", "ross"]
    assert "model='ross'" in found.loc["c", "message"]
    with pytest.raises(ValueError, match="system a: unknown model 'rosso'"):
        fleet.run(systems.assign(steady_model="rosso"), tmp_path / "out", **how)


def test_module_sensors_are_compared_without_wind(calm):
    over = calm["temp_module"] - calm["temp_air"]
    random = np.random.default_rng(5)
    for i, share in enumerate((1.0, 1.02, 0.9)):
        noise = random.normal(0.0, 0.2, len(calm))
        calm = calm.assign(
            **{f"temp_module_{i}": calm["temp_air"] + share * over + noise}
        )
    data = calm.drop(columns="temp_module")
    found = fem.compare_modules(data, model="ross")
    assert found.table["share"].to_list() == pytest.approx([1.04, 1.07, 0.89], abs=0.02)
    with pytest.raises(ValueError, match="data lack wind_speed"):
        fem.compare_modules(data)
