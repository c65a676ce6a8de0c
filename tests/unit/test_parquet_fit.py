"""A fit of files is the fit of the same record in memory, and holds no rows."""

import pickle

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

import pvlib_fem as fem
from pvlib_fem._cli import main
from pvlib_fem._fitting.parquet_rows import EvalRequest, first_pass, screened_for
from pvlib_fem._fitting.row_source import Rows
from pvlib_fem._record import parquet
from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem._record.filters import counted
from pvlib_fem._record.inputs import as_record
from pvlib_fem._record.resampling import coarse
from pvlib_fem._stored import as_json
from pvlib_fem._thermal.model import thermal_model
from pvlib_fem.quality._screen import screened

pytest.importorskip("pyarrow")
CASES = {
    "wm1": dict(model="wm1", dynamics="ewm"),
    "balance": dict(model="faiman", dynamics="balance", night=True),
    "steady": dict(model="ross", dynamics="steady"),
    "held": dict(model="wm2", dynamics="ewm", fixed={"tau": 300.0}),
    "effects": dict(
        model="faiman", dynamics="balance", effects=["radiative_loss", "wind_direction"]
    ),
}


@pytest.fixture(scope="module")
def data():
    """Sixteen days with gaps, missing values and faults, and a change of the clock."""
    data = fem.datasets.synthetic(days=16, step=240, start="2023-03-20")
    data = data.set_axis(data.index.tz_convert("Europe/Brussels"))
    turns = np.random.default_rng(1).normal(0, 9, len(data)).cumsum() % 360
    data = data.assign(wind_direction=turns)
    data.iloc[700:730, data.columns.get_loc("wind_speed")] = np.nan
    data.iloc[900:905, data.columns.get_loc("temp_module")] = -999.0
    data.iloc[1500, data.columns.get_loc("poa_global")] = np.nan
    return data.drop(data.index[2000:2200])


@pytest.fixture(scope="module")
def folder(data, tmp_path_factory):
    folder = tmp_path_factory.mktemp("record")
    for i, part in enumerate(np.array_split(np.arange(len(data)), 4)):
        data.iloc[part].to_parquet(folder / f"{i}.parquet", row_group_size=701)
    return folder


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch):
    """Blocks that end anywhere."""
    monkeypatch.setattr(parquet, "ROWS", 509)


@pytest.mark.parametrize("dynamics", ["steady", "ewm", "balance"])
def test_the_sums_of_files_are_those_of_memory(data, folder, dynamics):
    model = thermal_model("wm1", dynamics)
    found = model.completed({"k": 0.03, "d": 9.0, "tau": 400.0, "capacity": 9e3})
    record, _ = screened(as_record(*(data[name] for name in COLUMNS)))
    rows = Rows(record, np.array(counted(record.inputs.columns)))
    screened_files = screened_for(fem.open_parquet(folder), model)
    files = first_pass(screened_files, model, night=False)
    asked = {"": EvalRequest(model, found, "train")}
    one = rows.sums({"": EvalRequest(model, found)}, {"": model.free})[""]
    other = files.sums(asked, {"": model.free})[""]
    assert other.squares == pytest.approx(one.squares, rel=1e-12)
    size = np.sqrt(np.outer(np.diag(one.normal), np.diag(one.normal)))
    np.testing.assert_allclose(other.normal / size, one.normal / size, atol=1e-12)
    assert files.winds == pytest.approx(rows.winds, rel=1e-12)
    columns = coarse(record, 480.0).inputs.columns
    assert len(columns)
    for name, means in columns.items():
        np.testing.assert_allclose(files.means[name], means, rtol=1e-13)


@pytest.mark.parametrize("case", CASES)
def test_a_fit_of_files_is_that_in_memory(data, folder, case):
    expected, fit = (fem.fit_fem(what, **CASES[case]) for what in (data, folder))
    assert fit.coefficients == pytest.approx(expected.coefficients, rel=1e-8)
    assert fit.stderr == pytest.approx(expected.stderr, rel=1e-6, nan_ok=True)
    pd.testing.assert_frame_equal(fit.scores, expected.scores, rtol=1e-5, atol=1e-5)
    assert fit.notes == expected.notes
    # in memory the record also has derived columns
    contents = [as_json(one.summary) | {"columns": ""} for one in (fit, expected)]
    assert contents[0] == contents[1]
    assert fit.summary.measured == expected.summary.measured
    assert (fit.train_days, fit.test_days) == (expected.train_days, expected.test_days)
    assert fit.at_bound == expected.at_bound
    assert str(fit) == str(expected)
    pd.testing.assert_frame_equal(
        fit.through_time("7D").drop(columns="why"),
        expected.through_time("7D").drop(columns="why"),
        rtol=1e-5,
    )


def test_the_residual_is_written_and_not_held(data, folder, tmp_path):
    fit, expected = fem.fit_fem(folder), fem.fit_fem(data)
    with pytest.raises(ValueError, match=r"fit\.write_residual\('residual\.parquet'\)"):
        print(fit.residual)
    fit.write_residual(tmp_path / "residual.parquet")
    found = pd.read_parquet(tmp_path / "residual.parquet")["residual"]
    assert (found.index == data.index).all()
    np.testing.assert_allclose(found, expected.residual, atol=1e-7)


def test_pages_and_pictures_are_of_means(data, folder, tmp_path):
    fit = fem.fit_fem(folder)
    page = fit.to_html(tmp_path / "fit.html")
    assert f"{len(data):,} rows" in page
    assert "<svg" in page
    again = fem.FemFit.from_json(save(fit, tmp_path / "fit.json"))
    assert again.coefficients == fit.coefficients
    assert fit.plot() is not None


def save(fit, path):
    fit.to_json(path)
    return path


def test_days_are_held_out_by_their_dates(data, folder):
    days = pd.Series(True, pd.date_range("2023-03-22", periods=5))
    rows = pd.Series(
        data.index.tz_localize(None).normalize().isin(days.index), data.index
    )
    fit, expected = fem.fit_fem(folder, holdout=days), fem.fit_fem(data, holdout=rows)
    assert fit.coefficients == pytest.approx(expected.coefficients, rel=1e-8)
    assert fit.test_days == 5
    with pytest.raises(ValueError, match="whole days"):
        fem.fit_fem(folder, holdout=rows)


REMEMBERING = {
    "rain": "precipitation",
    "soiling": "precipitation",
    "snow": "snow_depth",
    "thermal_storage": "temp_air",
}


def worlds(effect, lacking, step):
    """A record with an effect; its column has missing values in some places."""
    effects = fem.simulator.PHYSICS | {effect: 1.0}
    days = {15: 12, 60: 20, 900: 60}[step]
    how = dict(step=step, seed=4, start="2023-02-10")
    data = fem.simulator.record(effects=effects, days=days, **how)
    data.attrs = {}
    rows = np.zeros(len(data), dtype=bool)
    if lacking == "at the start":
        rows[:121] = True
    elif lacking == "here and there":
        rows = np.random.default_rng(3).random(len(data)) < 0.02
        rows[2000:2100] = True
    data.loc[rows, REMEMBERING[effect]] = np.nan
    # uneven steps, and a gap of hours
    return data.drop(data.index[[500, 900, *range(3000, 3000 + 14400 // step)]])


def in_memory_and_of_files(data, effect, folder):
    data.to_parquet(folder / "record.parquet", row_group_size=701)
    how = dict(model="faiman", dynamics="balance", effects=effect, night=True)
    expected, fit = (fem.fit_fem(what, **how) for what in (data, folder))
    fit.write_residual(folder / "residual.pq")
    left = pd.read_parquet(folder / "residual.pq")["residual"]
    return expected, fit, left


@pytest.mark.parametrize("lacking", ["nowhere", "at the start", "here and there"])
@pytest.mark.parametrize("effect", REMEMBERING)
@pytest.mark.parametrize("step", [60, 900])
def test_what_minutes_remember_is_as_in_memory(effect, lacking, step, tmp_path):
    """For any missing values and blocks, if the record determines the coefficient."""
    data = worlds(effect, lacking, step)
    expected, fit, left = in_memory_and_of_files(data, effect, tmp_path)
    names = [name for name, error in expected.stderr.items() if error > 0]
    assert names
    for name in names:
        known = pytest.approx(expected.coefficients[name], rel=1e-6)
        assert fit.coefficients[name] == known
    pd.testing.assert_frame_equal(fit.scores, expected.scores, atol=2e-5)
    np.testing.assert_allclose(left, expected.residual, atol=1e-5)
    assert not [note for note in fit.notes if "hours before" in note]


@pytest.mark.parametrize("lacking", ["nowhere", "at the start", "here and there"])
@pytest.mark.parametrize("effect", REMEMBERING)
def test_what_seconds_remember_is_of_means(effect, lacking, tmp_path):
    """Coefficients agree to a tenth of their error; rain, which dries soon, exactly."""
    data = worlds(effect, lacking, 15)
    expected, fit, left = in_memory_and_of_files(data, effect, tmp_path)
    share = 1e-3 if effect == "rain" else 0.1
    names = [name for name, error in expected.stderr.items() if error > 0]
    assert names
    for name in names:
        off = abs(fit.coefficients[name] - expected.coefficients[name])
        assert off <= share * expected.stderr[name]
    pd.testing.assert_frame_equal(fit.scores, expected.scores, atol=0.005)
    assert (left.isna() == expected.residual.isna()).all()
    assert (left - expected.residual).abs().mean() < 0.02
    told = [note for note in fit.notes if f"means over 60 s, for {effect}" in note]
    assert len(told) == (effect != "rain")


def test_readings_too_rare_for_a_mean_are_refused_by_name(tmp_path):
    data = fem.simulator.record(days=4, step=20, seed=4, start="2023-02-10")
    data.attrs = {}
    data.loc[np.arange(len(data)) % 12 > 0, "snow_depth"] = np.nan
    data.to_parquet(tmp_path / "record.parquet")
    with pytest.raises(ValueError, match=r"enough values of snow_depth.*; fill these"):
        fem.fit_fem(tmp_path, effects="snow", night=True)


def test_what_files_cannot_be_asked_is_said(data, folder):
    shade = {"name": "shading", "windows": [(90, 120, 0, 20)], "sensor": True}
    with pytest.raises(ValueError, match="shading uses the hours around each row"):
        fem.fit_fem(folder, effects=shade)
    with pytest.raises(ValueError, match="has no column p_dc_per_area"):
        fem.fit_fem(folder, effects="electrical_output")
    with pytest.raises(ValueError, match="takes no files"):
        fem.fit_fem(folder, method="paper")
    with pytest.raises(ValueError, match="give the record alone"):
        fem.fit_fem(folder, data["temp_air"])


@pytest.mark.parametrize("form", ["folder", "pattern", "files"])
def test_the_command_fits_files_that_follow_each_other(data, folder, form):
    given = {
        "folder": [folder],
        "pattern": [folder / "*.parquet"],
        "files": sorted(folder.glob("*.parquet")),
    }[form]
    days = ["--holdout", "2023-03-22..2023-03-25"]
    found = CliRunner().invoke(main, ["fit", *map(str, given), *days])
    assert found.exit_code == 0, found.output
    out = pd.Series(True, pd.date_range("2023-03-22", periods=4))
    assert found.output.strip() == str(fem.fit_fem(folder, holdout=out)).strip()
    wrong = CliRunner().invoke(main, ["fit", str(folder), "--sep", ";"])
    assert wrong.exit_code != 0
    assert "--sep does not go with Parquet files" in wrong.output


def test_a_fit_of_files_can_be_copied_and_one_row_is_refused(data, folder, tmp_path):
    fit = fem.fit_fem(folder, model="ross", dynamics="steady")
    copied = pickle.loads(pickle.dumps(fit))
    assert copied.coefficients == fit.coefficients
    assert len(pickle.dumps(fit)) < 2**20
    data.iloc[200:201].to_parquet(tmp_path / "one.parquet")
    with pytest.raises(ValueError, match=r"needs more than|still at"):
        fem.fit_fem(tmp_path / "one.parquet")
