"""Records of plants that have fewer sensors than a laboratory."""

import numpy as np
import pandas as pd
import pvlib
import pytest
import study_transposition
from conftest import call, proposed
from pvlib.location import Location

import pvlib_fem as fem
from pvlib_fem import datasets, fleet, simulator
from pvlib_fem._record import parquet
from pvlib_fem._record.column_names import is_cross_check, twin_of
from pvlib_fem.drivers import checked_place
from pvlib_fem.drivers._transposition import TRANSPOSITIONS, in_plane
from pvlib_fem.effects import CHANGES, EFFECTS, find

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
    wind = [
        n
        for n, e in CHANGES.items()
        if e.sensor_fault in ("anemometer", "anemometer_stall")
    ]
    wind += ["natural_convection", "wind_shape", "air_shield"]
    assert {str(loop.untestable[name]) for name in wind} == {"no wind_speed"}
    assert str(loop.untestable["wind_direction"]) == "no wind_direction, wind_speed"
    tried = {*EFFECTS, *CHANGES} - {*loop.untestable} - {"radiative_loss"}
    assert {
        "thermal_storage",
        "irradiance_sensor_step",
        "module_sensor_contact_step",
    } <= tried | {*loop.ranking.index}
    assert "ross, balance; no wind_speed" in " ".join(str(loop).split())
    words = loop.report()
    assert "the wind's coefficient" not in words
    assert words.count("there is no wind_speed") == 1
    with pytest.raises(
        ValueError, match=r"the data have no column wind_speed.*model='ross'"
    ):
        fem.close_loop(calm)


def test_the_loop_finds_a_step_without_wind(calm):
    data, there = calm.copy(), calm.index >= "2023-07-05"
    data["temp_module"] += 3.0 * there
    found = fem.close_loop(data, model="ross")
    assert found.effects == ["module_offset_step"]
    (finding,) = (f for f in found.finding_objects if f.added)
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
    with pytest.raises(ValueError, match="the data have no column wind_speed"):
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
        words = " ".join(done.stdout.split())
        assert "ross" in words and "no wind_speed" in words
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
    data.iloc[5:9, data.columns.get_loc("temp_module_1")] = -999.0
    found = fem.compare_modules(data, model="ross")
    assert "\ntemp_module_1: holds the fill value -999 in 4 rows" in str(found)
    assert found.table["share"].to_list() == pytest.approx([1.04, 1.07, 0.89], abs=0.02)
    with pytest.raises(ValueError, match="the data have no column wind_speed"):
        fem.compare_modules(data)


PLACE = Location(35.0, -106.0), 35.0, 180.0
SITE = dict(zip(("location", "surface_tilt", "surface_azimuth"), PLACE))


@pytest.fixture(scope="module")
def level():
    """Eighty days with horizontal irradiance, and the same with that in the plane."""
    data = datasets.synthetic(80, 600, seed=2)
    return data.drop(columns=["poa_global", "dni", "dhi"]), data


@pytest.mark.parametrize("model", TRANSPOSITIONS)
def test_a_horizontal_plane_has_the_horizontal_irradiance(level, model):
    data, _ = level
    found = fem.transpose_record(data, PLACE[0], 0.0, 180.0, model)
    # pvlib's Perez keeps the sun 5° above the horizon
    slack = 2.0 if model == "perez" else 1e-6
    np.testing.assert_allclose(found["poa_global"], data["ghi"], atol=slack)


def test_irradiance_in_the_plane_is_that_of_pvlib(level):
    _, data = level
    found = fem.transpose_record(data.drop(columns="poa_global"), *PLACE, "haydavies")
    sun = PLACE[0].get_solarposition(data.index)
    expected = pvlib.irradiance.get_total_irradiance(
        *PLACE[1:],
        sun["zenith"],
        sun["azimuth"],
        *(data[name] for name in ("dni", "ghi", "dhi")),
        dni_extra=pvlib.irradiance.get_extra_radiation(data.index),
        albedo=0.2,
        model="haydavies",
    )["poa_global"]
    up = sun["zenith"] < 88.0
    np.testing.assert_allclose(found["poa_global"][up], expected[up], atol=0.5)
    assert "measured dni and dhi" in found.attrs["notes"][0]
    assert (found["poa_global"][sun["zenith"] > 95.0] == 0.0).all()


def test_what_was_not_measured_on_the_horizontal_is_not_transposed(level):
    data, _ = level
    data = data.assign(ghi=data["ghi"].mask(data.index.day == 5, -999.0))
    data.iloc[1000:1010, 0] = np.nan
    found = fem.transpose_record(data, *PLACE)
    lacks = (data.index.day == 5) | data["ghi"].isna()
    np.testing.assert_array_equal(found["poa_global"].isna(), lacks)
    assert any(
        note.startswith("ghi") and "-999" in note for note in found.attrs["notes"]
    )
    with pytest.raises(ValueError, match="ghi looks to be in kW/m²"):
        fem.transpose_record(data.assign(ghi=data["ghi"].clip(lower=0) / 1000), *PLACE)
    with pytest.raises(ValueError, match="data have poa_global"):
        fem.transpose_record(data.assign(poa_global=data["ghi"]), *PLACE)


@pytest.mark.parametrize("label", ["left", "right"])
def test_hourly_means_are_transposed_with_the_sun_at_their_middle(level, label):
    data, whole = level
    hours = data.resample("1h", label=label).mean()
    made = fem.transpose_record(hours, *PLACE)
    assert "with the sun at the middle" in made.attrs["notes"][-1]
    half = pd.Timedelta(minutes=30 if label == "left" else -30)
    middle = hours.set_axis(hours.index + half)
    same = fem.transpose_record(middle, *PLACE)
    assert "with the sun" not in same.attrs["notes"][-1]
    # the sun's distance is that of the day, which ends by another clock
    np.testing.assert_allclose(made["poa_global"], same["poa_global"], rtol=1e-3)
    truth = whole["poa_global"].resample("1h", label=label).mean()
    wrong = in_plane(hours, hours.index, checked_place(*PLACE), "perez")
    error, usual = ((one - truth).abs().mean() for one in (made["poa_global"], wrong))
    assert error < 0.7 * usual


def test_the_loop_transposes_and_predicts_alike(level, tmp_path):
    data, whole = level
    how = dict(SITE, effects=["sky_radiation", "wind_shape"])
    loop = fem.close_loop(data, **how, transposition="perez")
    assert loop.transposition == "perez"
    assert "poa_global transposed from ghi (perez)" in " ".join(str(loop).split())
    assert "transposed from ghi with Erbs' correlation" in loop.notes[0]
    made = fem.transpose_record(data, *PLACE)
    other = fem.close_loop(made.drop(columns="ghi"), **how)
    pd.testing.assert_frame_equal(loop.table, other.table)
    predicted = loop.predict(data)
    pd.testing.assert_series_equal(predicted, loop.predict(made))
    loop.to_json(tmp_path / "loop.json")
    again = fem.Loop.from_json(tmp_path / "loop.json")
    pd.testing.assert_series_equal(again.predict(data), predicted)
    # nothing is corrected, so that nothing else is in the record
    assert [*loop.corrected(data).data] == [*data, "corrected"]
    with pytest.raises(ValueError, match="no column poa_global, and no column ghi"):
        loop.predict(data.drop(columns="ghi"))
    measured = fem.close_loop(whole, **how, transposition="perez")
    assert not measured.transposition
    assert "poa_global was measured, and nothing is transposed" in measured.notes


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (dict(transposition="king"), "it is 'perez' or 'haydavies'"),
        (dict(surface_tilt=None), "needs the plane of the module: give location"),
        (
            dict(),
            "ghi cannot be transposed: ",
        ),  # of a file that is two hours late
    ],
)
def test_a_plane_that_is_not_known_is_not_made(level, change, words):
    data, _ = level
    data = data.set_axis(data.index + pd.Timedelta("2h"))
    with pytest.raises(ValueError, match=words):
        fem.close_loop(data, **{**SITE, "transposition": "perez", **change})


def test_the_command_proposes_a_transposition(level, tmp_path):
    file = tmp_path / "horizontal.csv"
    data = level[0][["ghi", "temp_air", "temp_module"]].tz_localize(None)
    data = data.rename(columns={"ghi": "Global horizontal (W/m2)"})
    data.to_csv(file, index_label="time")
    line = proposed(call("fit", file))
    assert line[line.index("--transposition") + 1] == "perez" and "LAT" in line
    words = ("--lat", 35, "--lon", -106, "--tilt", 35, "--azimuth", 180)
    done = call(*proposed(call("fit", file, *words)))
    assert done.exit_code == 0, done.output
    assert "note: there is no poa_global: it is transposed from ghi" in done.stdout


@pytest.fixture
def files(level, tmp_path):
    """The record in files, without light in the plane."""
    data = level[0][["ghi", "temp_air", "wind_speed", "temp_module"]]
    half = len(data) // 2
    for i, part in enumerate((data[:half], data[half:])):
        part.to_parquet(tmp_path / f"{i}.parquet", row_group_size=901)
    return data, tmp_path


def test_files_are_transposed_block_by_block(files, monkeypatch):
    data, folder = files
    monkeypatch.setattr(parquet, "ROWS", 509)
    record = fem.transpose_record(fem.open_parquet(folder), *PLACE)
    made = fem.transpose_record(data, *PLACE)
    light = np.concatenate([block["poa_global"] for block in record.blocks()])
    # pvlib takes one mean length of day for all times of a call
    np.testing.assert_allclose(light, made["poa_global"], rtol=1e-5, atol=1e-3)
    assert made.attrs["notes"][0] in record.notes
    how = dict(model="faiman", dynamics="balance")
    one, other = fem.fit_fem(record, **how), fem.fit_fem(made, **how)
    assert one.coefficients == pytest.approx(other.coefficients, rel=1e-6)
    assert record.notes[0] in one.notes
    with pytest.raises(ValueError, match="data have poa_global"):
        fem.transpose_record(record, *PLACE)


def test_a_loop_of_files_transposes_as_one_in_memory(files):
    data, folder = files
    how = dict(SITE, transposition="perez", effects=["wind_shape"])
    one, other = fem.close_loop(folder, **how), fem.close_loop(data, **how)
    assert one.transposition == other.transposition == "perez"
    pd.testing.assert_frame_equal(one.table, other.table, rtol=1e-6)
    one, other = one.predict(data), other.predict(data)
    pd.testing.assert_series_equal(one, other, rtol=1e-6)


def test_the_command_transposes_files(files):
    _, folder = files
    words = ("--lat", 35, "--lon", -106, "--tilt", 35, "--azimuth", 180)
    for command in ("fit", "loop"):
        done = call(command, folder, "--transposition", "perez", *words)
        assert done.exit_code == 0, done.output
        assert "transposed from ghi" in " ".join(done.output.split())
    refused = call("fit", folder)
    assert refused.exit_code == 1 and "--transposition perez" in refused.output


def test_files_of_a_late_clock_are_not_transposed(files):
    _, folder = files
    for file in folder.glob("*.parquet"):
        part = pd.read_parquet(file)
        part.set_axis(part.index + pd.Timedelta("2h")).to_parquet(file)
    with pytest.raises(ValueError, match="ghi cannot be transposed"):
        fem.transpose_record(fem.open_parquet(folder), *PLACE)


def test_another_wind_stands_in_for_one_that_files_lack(files, tmp_path):
    data, _ = files
    made = fem.transpose_record(data, *PLACE)
    other = made.rename(columns={"wind_speed": "wind_speed_airport"})
    other.to_parquet(tmp_path / "plant.pq")
    how = dict(effects=["wind_shape"])
    loop = fem.close_loop(tmp_path / "plant.pq", stand_ins="wind_speed_airport", **how)
    (one,) = loop.stand_ins
    assert (one.usual, one.column) == ("wind_speed", "wind_speed_airport")
    assert "wind_speed_airport stands in for it" in " ".join(loop.notes)
    want = fem.close_loop(made.drop(columns="ghi"), **how)
    pd.testing.assert_series_equal(loop.predict(other), want.predict(made), rtol=1e-6)
    both = other.assign(wind_speed=made["wind_speed"])
    both.to_parquet(tmp_path / "plant.pq")
    with pytest.raises(ValueError, match=r"fill them before with fill_record\(part"):
        fem.close_loop(tmp_path / "plant.pq", stand_ins="wind_speed_airport")


def test_a_record_without_light_in_the_plane_is_told_the_step_that_makes_it(level):
    data = level[0][["ghi", "temp_air", "wind_speed", "temp_module"]]
    step = r"to make poa_global of ghi, transpose_record\(data, location"
    for function in (fem.fit_fem, fem.close_loop, fem.recover_effects):
        with pytest.raises(ValueError, match=step):
            function(data)
    twice = data.assign(poa_global=data["ghi"]).rename(
        columns={"temp_air": "temp_air_2"}
    )
    for function in (fem.fit_fem, fem.close_loop, fem.recover_effects):
        with pytest.raises(ValueError, match=r"fill_record\(data, 'temp_air_2'\)"):
            function(twice)


def test_a_recovery_makes_missing_columns_before_anything_is_put_in(level):
    data = level[0][["ghi", "temp_air", "wind_speed", "temp_module"]]
    made = fem.transpose_record(data, *PLACE).drop(columns="ghi")
    how = dict(SITE, sizes=[3], draws=1, processes=1, progress=False)
    how |= {"tried": ["module_offset_step"]}
    want = fem.recover_effects(made, "module_offset_step", **how)
    lacks = data.rename(columns={"temp_air": "temp_air_2"})
    how |= {"transposition": "perez", "stand_ins": "temp_air_2"}
    found = fem.recover_effects(lacks, "module_offset_step", **how)
    pd.testing.assert_frame_equal(found.summary, want.summary, rtol=1e-6)
    assert len(found.outcomes) == 1


def test_what_a_transposition_costs_is_as_the_guide_says():
    """A small part of the table of docs/guide/fewer_sensors.md."""
    site = next(iter(study_transposition.worlds()))
    rows = {
        by: study_transposition.row(data, truth)
        for truth in [next(study_transposition.records(site, 0, 120))[1]]
        for by, data, _ in study_transposition.records(site, 0, 120)
    }
    for name in TRANSPOSITIONS:
        assert 0.0 < rows[name]["rms"] < 0.12 and abs(rows[name]["mean"]) < 0.07
        assert abs(rows[name]["rmse"] - rows["measured"]["rmse"]) < 0.15


@pytest.fixture(scope="module")
def airport():
    """Eighty days with hourly air and wind of a place elsewhere."""
    data = datasets.synthetic(80, 600, seed=6)[[*USUAL, "wind_speed"]]
    random, hourly = np.random.default_rng(1), data.index.minute == 0
    air = data["temp_air"] - 1.5 + random.normal(0.0, 0.5, len(data))
    wind = 1.6 * data["wind_speed"] * np.exp(random.normal(0.0, 0.3, len(data)))
    return data.assign(
        temp_air_airport=air.where(hourly), wind_speed_airport=wind.where(hourly)
    )


def test_another_source_fills_gaps_at_the_level_of_the_first(airport):
    data, gap = airport.copy(), airport.index.day == 12
    data.loc[gap, "temp_air"] = np.nan
    data.loc[gap, "wind_speed"] = -999.0
    names = ["temp_air_airport", "wind_speed_airport"]
    found = fem.fill_record(data, names)
    assert not {*names} & {*found}
    pd.testing.assert_frame_equal(found[~gap], airport.loc[~gap, [*data][:4]])
    hourly = gap & (airport.index.minute == 0)
    between = found["temp_air"].where(hourly | ~gap)
    straight = between.interpolate("time")
    last = gap & ~hourly & (airport.index.hour < 23)
    np.testing.assert_allclose(found["temp_air"][last], straight[last], atol=1e-9)
    off = (found - airport)[hourly]
    assert abs(off["temp_air"].mean()) < 0.2
    ratio = found["wind_speed"][hourly].mean() / airport["wind_speed"][hourly].mean()
    assert ratio == pytest.approx(1.0, abs=0.15)
    words = " ".join(found.attrs["notes"])
    assert "temp_air_airport stands in for temp_air in 432 rows, with 1.5 K" in words
    assert "on straight lines between values 60 min apart" in words
    assert "wind_speed holds the fill value -999 in 432 rows" in words
    assert "wind_speed_airport stands in for wind_speed in 432 rows, times 0.5" in words


def test_a_loop_with_another_source_predicts_alike(airport, tmp_path):
    hourly = airport[airport.index.minute == 0]
    data = hourly.drop(columns="wind_speed")
    with pytest.raises(
        ValueError, match=r"fill_record\(data, 'wind_speed_airport'\), or model="
    ):
        fem.close_loop(data)
    how = dict(stand_ins="wind_speed_airport", effects=["wind_shape"])
    loop = fem.close_loop(data, **how)
    assert "wind_speed_airport stands in for it" in loop.notes[0]
    assert "wind_speed_airport stands in" in " ".join(str(loop).split())
    named = data.rename(columns={"wind_speed_airport": "wind_speed"})
    other = fem.close_loop(named, effects=["wind_shape"])
    pd.testing.assert_frame_equal(loop.table, other.table)
    pd.testing.assert_series_equal(loop.predict(data), other.predict(named))
    # one more gap is filled at the level that the loop found
    gappy = hourly.copy()
    gappy.loc["2023-06-12", "temp_air"] = np.nan
    loop = fem.close_loop(gappy, stand_ins="temp_air_airport", effects=["wind_shape"])
    (one,) = loop.stand_ins
    assert one.offset == pytest.approx(1.5, abs=0.1)
    loop.to_json(tmp_path / "loop.json")
    again = fem.Loop.from_json(tmp_path / "loop.json")
    assert again.stand_ins == loop.stand_ins
    later = gappy.assign(temp_air=np.nan)
    found = again.predict(later)
    pd.testing.assert_series_equal(found, loop.predict(later))
    assert found.notna().all()
    whole = loop.predict(hourly.drop(columns="temp_air_airport"))
    assert (found - whole).std() < 0.6


@pytest.mark.parametrize(
    ("names", "words"),
    [
        ("temp_module_2", "temp_module_2 stands in for nothing"),
        ("wind_speed_3", "no column of numbers wind_speed_3"),
        (["temp_air_2", "temp_air_3"], "temp_air_2 and temp_air_3 both stand in"),
        ("temp_air_far", "have 100 rows in common, too few"),
    ],
)
def test_what_cannot_stand_in_is_refused(airport, names, words):
    data = airport.assign(temp_air_far=airport["temp_air"])
    data.iloc[100:, -1] = np.nan
    data.iloc[:50, data.columns.get_loc("temp_air_far")] = 9.0
    data.loc[data.index[:20], "temp_air"] = np.nan
    if "far" in str(names):
        data.iloc[100:120, -1] = 8.0
    with pytest.raises(ValueError, match=words):
        fem.fill_record(data, names)


@pytest.mark.parametrize(
    ("usual", "column", "effect"),
    [
        ("wind_speed", "wind_speed_airport", "anemometer_step"),
        ("temp_air", "temp_air_airport", "air_offset_step"),
    ],
)
def test_another_source_is_a_cross_check_by_itself(airport, usual, column, effect):
    data, there = airport.copy(), airport.index >= "2023-07-10"
    if usual == "temp_air":
        data[usual] -= 1.5 * there
    else:
        data[usual] *= 1.0 - 0.35 * there
    first = fem.close_loop(data[[*USUAL, "wind_speed", column]]).finding_objects[0]
    assert first.effect == effect and str(first.verdict) == "identified"
    assert {one.column for one in first.conclusive_checks} >= {column}


def test_the_command_takes_another_source(airport, tmp_path):
    file = tmp_path / "plant.csv"
    data = airport.tz_localize(None)[airport.index.minute == 0]
    data.drop(columns="wind_speed").to_csv(file, index_label="time")
    refused = call("fit", file)
    assert "or give --stand-in wind_speed_airport" in refused.output
    for command in ("fit", "loop"):
        done = call(command, file, "--stand-in", "wind_speed_airport")
        assert done.exit_code == 0, done.output
        assert "stands in" in done.stdout


REAR = {"name": "rear_irradiance", "source": "measured rear irradiance"}
HELD = "rear_irradiance.bifaciality"


def bifacial(site=simulator.RHINE, **effects):
    """A simulated year on a rack, with the irradiance on its rear side."""
    on = simulator.PHYSICS | {"sky_radiation": 1.0} | effects
    data = simulator.record(site, on, 365, 1800, seed=3)
    sky = simulator.weather(site, 365, 1800, "2023-01-01", 3)
    up = np.cos(np.radians(site.surface_tilt))
    rear = 0.7 * site.albedo * sky["ghi"] * (1 + up) / 2 + sky["dhi"] * (1 - up) / 2
    names = [*USUAL, "wind_speed", "longwave_down"]
    return data[names].assign(poa_rear=rear)


def test_a_held_bifaciality_leaves_the_coefficients_of_the_module():
    """Over dark ground, and with light on the rear of a known share."""
    effects = ["sky_radiation", REAR]
    how = dict(model="faiman", dynamics="balance", night=True)
    dark = fem.fit_fem(bifacial(rear_irradiance=0.0), effects=effects[:1], **how)
    lit = bifacial(rear_irradiance=1.0)
    without = fem.fit_fem(lit, effects=effects[:1], **how)
    # absorbed behind over absorbed in front, in the simulator
    share = 0.6 / 0.72
    held = fem.fit_fem(lit, effects=effects, fixed={HELD: share}, **how)
    own, off, known = (one.coefficients["u0"] for one in (dark, without, held))
    assert abs(known / own - 1.0) < 0.03 < abs(off / own - 1.0)
    # what keeps pace with the front is not told from it
    assert lit["poa_rear"].corr(lit["poa_global"]) > 0.95
    free = fem.fit_fem(lit, effects=effects, **how)
    assert free.coefficients[HELD] < 0.75 * share
    assert "rear_irradiance" not in fem.close_loop(lit).effects
    loop = fem.close_loop(lit, fixed={HELD: share})
    assert "+rear_irradiance" in loop.table.index
    assert loop.fit.coefficients[HELD] == share


def test_a_fit_with_rear_irradiance_is_the_same_from_a_file(tmp_path):
    data = bifacial(rear_irradiance=1.0).iloc[: 48 * 60]
    fit = fem.fit_fem(data, model="faiman", dynamics="balance", effects=REAR)
    fit.to_json(tmp_path / "fit.json")
    again = fem.FemFit.from_json(tmp_path / "fit.json")
    pd.testing.assert_series_equal(again.predict(data), fit.predict(data))
    with pytest.raises(ValueError, match="no column poa_rear"):
        fem.fit_fem(data.drop(columns="poa_rear"), effects=REAR)
    # by its name alone it is of the ground, as before
    assert find("rear_irradiance").drivers == ("ghi_estimated",)


def test_rear_irradiance_is_no_second_sensor_of_the_front(tmp_path):
    assert twin_of("poa_rear") is None and not is_cross_check("poa_rear")
    data = bifacial(rear_irradiance=0.0).iloc[: 48 * 40]
    loop = fem.close_loop(data)
    assert "driver:poa_rear" not in {*loop.ranking.index, *loop.untestable}
    assert not any("cross-check" in note for note in loop.notes)
    headers = ["POA (W/m2)", "T amb", "T mod", "Wind", "LW", "POA rear (W/m2)"]
    data.set_axis(headers, axis=1).tz_localize(None).to_csv(tmp_path / "rear.csv")
    line = proposed(call("loop", tmp_path / "rear.csv"))
    assert "poa_rear=POA rear (W/m2)" in line and "poa_global=POA (W/m2)" in line


def test_wind_that_never_moves_is_none_to_a_model_without_it(calm, loop):
    still = calm.assign(wind_speed=0.0)
    found = fem.close_loop(still, model="ross")
    assert found.notes[0] == "wind_speed never moves: it is taken as not measured"
    pd.testing.assert_frame_equal(found.table, loop.table)
    with pytest.raises(ValueError, match="model='ross', which needs no wind"):
        fem.close_loop(still)


def test_a_late_clock_is_refused_wherever_light_is_transposed(level, tmp_path):
    data = level[0].set_axis(level[0].index + pd.Timedelta("2h"))
    with pytest.raises(ValueError, match="ghi cannot be transposed"):
        fem.transpose_record(data, *PLACE)
    data.tz_localize(None).to_csv(tmp_path / "late.csv", index_label="time")
    words = ("--lat", 35, "--lon", -106, "--tilt", 35, "--azimuth", 180)
    done = call("fit", tmp_path / "late.csv", "--transposition", "perez", *words)
    assert done.exit_code == 1 and "ghi cannot be transposed" in done.output


def test_air_in_another_unit_does_not_stand_in(airport):
    data = airport.assign(temp_air_2=1.8 * airport["temp_air"] + 32.0)
    data.loc["2023-06-12", "temp_air"] = np.nan
    with pytest.raises(ValueError, match=r"temp_air_2 changes by 1\.8 for each K"):
        fem.fill_record(data, "temp_air_2")
