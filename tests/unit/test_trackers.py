"""Planes that move: single-axis trackers, described or by their angles."""

import json
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pvlib
import pytest
from conftest import COLUMNS, call
from pvlib.location import Location
from pvlib.pvsystem import FixedMount, SingleAxisTrackerMount

import pvlib_fem as fem
from pvlib_fem import detect, simulator
from pvlib_fem._record.inputs import as_record, with_columns
from pvlib_fem.drivers import checked_place, derive_drivers, geometry
from pvlib_fem.drivers._mounts import angles_at, axis_of
from pvlib_fem.drivers._planes import ByColumns
from pvlib_fem.quality._clearsky import clear_sky

SITE = replace(simulator.RHINE, tracker=simulator.Tracker())
WHERE = Location(SITE.latitude, SITE.longitude, tz=SITE.tz)
MOUNT = SingleAxisTrackerMount(0.0, 180.0, 60.0, True, 0.35)
ANGLES = ["surface_tilt", "surface_azimuth"]
GEOMETRY = ["solar_zenith", "solar_azimuth", *ANGLES]
TURNED = -6.0  # °, of the modules against the irradiance sensor


@pytest.fixture(scope="module")
def record():
    """A tracker whose irradiance sensor is turned by 6° about the vertical."""
    effects = simulator.PHYSICS | {"poa_misalignment": -TURNED}
    data = simulator.record(SITE, effects, days=150, step=900.0, start="2023-03-01")
    return data[[*COLUMNS, "relative_humidity", *ANGLES]]


@pytest.fixture(scope="module")
def plain(record):
    """The record without the angles."""
    return record.drop(columns=ANGLES)


@pytest.fixture(scope="module")
def loop(record):
    return fem.close_loop(record, location=WHERE)


@pytest.fixture(scope="module")
def described(plain):
    return fem.close_loop(plain, location=WHERE, mount=MOUNT)


# angles ------------------------------------------------------------------------


def test_a_described_tracker_has_the_angles_that_pvlib_gives(record):
    found = geometry(record.index, WHERE, mount=MOUNT)
    sun = WHERE.get_solarposition(record.index)
    angles = pvlib.tracking.singleaxis(
        sun["apparent_zenith"], sun["azimuth"], 0.0, 180.0, 60.0, True, 0.35
    )
    day = sun["apparent_zenith"] < 89.0
    apart = np.abs(found["surface_tilt"] - angles["surface_tilt"])[day]
    assert apart.max() < 0.2  # of backtracking, where the sun is interpolated
    turned = np.abs(found["surface_azimuth"] - angles["surface_azimuth"])[day]
    assert turned[angles["surface_tilt"] > 0.2].max() < 1e-6
    night = sun["zenith"] > 92.0
    assert (found["surface_tilt"][night] == 0.0).all()


def test_angle_of_incidence_and_view_of_the_sky_are_those_of_each_row(record):
    plane = geometry(record.index, WHERE, mount=MOUNT)
    made = with_columns(as_record(*(record[name] for name in COLUMNS)), plane)
    found = derive_drivers(made.inputs, ["aoi_projection", "beam_by_tilt", "beam"])
    angles = [plane[name] for name in (*ANGLES, "solar_zenith", "solar_azimuth")]
    expected = pvlib.irradiance.aoi_projection(*angles)
    np.testing.assert_array_equal(found["aoi_projection"], expected)
    # light of an isotropic sky that is all diffuse comes back by the row's own view
    up = np.cos(np.radians(plane["solar_zenith"])).to_numpy()
    view = (1.0 + np.cos(np.radians(plane["surface_tilt"].to_numpy()))) / 2.0
    overcast = 0.05 * up * 1361.0 * (view + 0.2 * (1.0 - view))
    dark = made.having({"poa_global": np.maximum(overcast, 0.0)})
    clear = derive_drivers(dark.inputs, ["clearness"])["clearness"]
    assert np.abs(clear[up > 0.1] - 0.05).max() < 0.005


def test_columns_of_constant_angles_give_those_of_numbers_to_the_last_digit(record):
    index = record.index
    fixed = geometry(index, WHERE, 35.0, 170.0)
    values = {"surface_tilt": 35.0, "surface_azimuth": 170.0}
    columns = {name: np.full(len(index), value) for name, value in values.items()}
    moving = geometry(index, WHERE, mount=ByColumns(index, columns))
    between = index[:-1] + pd.Timedelta("4min")
    halfway = geometry(between, WHERE, mount=ByColumns(index, columns))
    needed = [
        "aoi_projection",
        "clearness",
        "beam_around",
        "beam_by_tilt",
        "cloud_share",
    ]
    usual = as_record(*(record[name] for name in COLUMNS))
    for name, value in values.items():
        assert (halfway[name] == value).all()
    for name in needed:
        one, other = (
            derive_drivers(with_columns(usual, plane).inputs, [name])[name]
            for plane in (fixed, moving)
        )
        np.testing.assert_array_equal(one, other)


def test_a_tracker_that_cannot_turn_gives_the_loop_of_the_fixed_plane(plain):
    still = SingleAxisTrackerMount(0.0, 180.0, 0.0)
    one = fem.close_loop(plain, location=WHERE, mount=still)
    other = fem.close_loop(
        plain, location=WHERE, surface_tilt=0.0, surface_azimuth=180.0
    )
    pd.testing.assert_frame_equal(one.table, other.table, check_exact=True)
    assert one.effects == other.effects


def test_a_fixed_mount_is_its_two_numbers():
    found = checked_place(WHERE, mount=FixedMount(20.0, 170.0))
    assert found == checked_place(WHERE, 20.0, 170.0)


def test_angles_between_rows_turn_through_the_horizontal():
    index = pd.date_range("2023-06-01", periods=4, freq="10min")
    columns = {
        "surface_tilt": [4.0, 2.0, 2.0, 6.0],
        "surface_azimuth": [90, 90, 270, 270],
    }
    columns = {name: np.array(v, dtype=float) for name, v in columns.items()}
    at = index[:3] + pd.Timedelta("5min")
    found = ByColumns(index, columns).at(at)
    np.testing.assert_allclose(found["surface_tilt"], [3.0, 0.0, 4.0], atol=0.01)
    assert found["surface_azimuth"][0] == 90.0 and found["surface_azimuth"][2] == 270.0
    north = ByColumns(index, {"surface_azimuth": np.array([350.0, 10.0, 10.0, 350.0])})
    turned = north.at(at)["surface_azimuth"]
    np.testing.assert_allclose(
        (turned + 180.0) % 360.0, [180.0, 190.0, 180.0], atol=1e-9
    )


def test_angles_are_not_carried_over_a_gap():
    index = pd.date_range("2023-06-01", periods=20, freq="10min").delete([8, 9, 10])
    mount = ByColumns(index, {"surface_tilt": np.linspace(0.0, 16.0, 17)})
    at = pd.to_datetime(["2023-06-01 01:25", "2023-06-01 00:05", "2023-06-01 05:00"])
    found = mount.at(at)["surface_tilt"]
    assert np.isnan(found[[0, 2]]).all() and found[1] == pytest.approx(0.5)


def test_the_axis_of_columns_is_that_of_the_tracker(record):
    for axis, tilt in ((180.0, 0.0), (150.0, 0.0), (200.0, 15.0)):
        mount = SingleAxisTrackerMount(tilt, axis, 60.0)
        plane = geometry(record.index, WHERE, mount=mount)
        columns = {name: plane[name].to_numpy() for name in ANGLES}
        place = checked_place(WHERE) | {"mount": ByColumns(record.index, columns)}
        assert axis_of(place) == pytest.approx(axis, abs=0.5)
    both = checked_place(
        WHERE, record["surface_tilt"].clip(lower=10.0), plane["solar_azimuth"]
    )
    assert axis_of(both) is None  # it turns about the vertical


# the loop ----------------------------------------------------------------------


def test_columns_series_and_a_described_tracker_give_one_answer(
    loop, described, record, plain
):
    by_series = fem.close_loop(
        plain, location=WHERE, **{name: record[name] for name in ANGLES}
    )
    pd.testing.assert_frame_equal(by_series.table, loop.table, check_exact=True)
    assert described.effects == loop.effects
    # the simulator's tracker follows the sun without refraction
    np.testing.assert_allclose(
        described.table["rmse_test"], loop.table["rmse_test"], 0.01
    )


def test_a_sensor_that_is_turned_against_the_modules_is_found(loop, described):
    for found in (loop, described):
        assert "poa_misalignment" in found.effects
        size = found.fit.coefficients["poa_misalignment.azimuth"]
        assert size == pytest.approx(TURNED, abs=1.0)
        assert abs(found.fit.coefficients["poa_misalignment.tilt"]) < 1.0


def test_a_turned_sensor_is_said_by_the_axis_of_the_tracker(loop):
    line = " ".join(str(loop).split())
    assert re.search(r"by 0\.\d+ ± [\d.]+° to the (east|west) about the axis", line)
    assert re.search(r"by 5\.\d+ ± [\d.]+° anticlockwise about the vertical", line)


def test_a_sensor_that_is_ahead_of_the_modules_is_found_by_that_angle():
    data = fem.datasets.synthetic(days=120, step=900, start="2023-03-01")
    place = Location(35.0, -106.0, tz="Etc/GMT+7")
    ahead = 7.0  # ° to the west
    sun = place.get_solarposition(data.index)
    theta = pvlib.tracking.singleaxis(
        sun["apparent_zenith"], sun["azimuth"], 0.0, 180.0, 30.0
    )["tracker_theta"].fillna(0.0)
    light = [data.pop(name) for name in ("dni", "ghi", "dhi")]
    poa = []
    for angle in (theta, theta + ahead):
        plane = pvlib.tracking.calc_surface_orientation(angle, 0.0, 180.0)
        where = (plane["surface_tilt"], plane["surface_azimuth"])
        there = (sun["apparent_zenith"], sun["azimuth"])
        total = pvlib.irradiance.get_total_irradiance(*where, *there, *light)
        poa.append(total["poa_global"].fillna(0.0))
    usual = dict(u0=25.0, u1=6.84, capacity=15e3, bias=-2.0)
    rest = (data["temp_air"], data["wind_speed"])
    noise = np.random.default_rng(1).normal(0.0, 0.2, len(data))
    data["temp_module"] = (
        fem.heat_balance(poa[1], *rest, model="faiman", **usual) + noise
    )
    data["poa_global"] = poa[0]
    # where it follows the sun, a few degrees change nothing
    for axis_azimuth in (180.0, 0.0):
        mount = SingleAxisTrackerMount(0.0, axis_azimuth, 30.0)
        loop = fem.close_loop(data, location=place, mount=mount)
        size = loop.fit.coefficients["poa_misalignment.tilt"]
        # about an axis to the north a positive rotation is to the east
        size *= 1.0 if mount.axis_azimuth else -1.0
        assert size == pytest.approx(ahead, abs=1.0)


def test_a_tracker_whose_light_is_horizontal_is_noted():
    level = replace(simulator.RHINE, surface_tilt=0.0)
    data = simulator.record(level, days=120, step=900.0, start="2023-03-01")
    loop = fem.close_loop(data[[*COLUMNS]], location=WHERE, mount=MOUNT)
    said = str(loop.untestable["incidence_angle"])
    assert re.search("not of the stated plane: it has .* tilt [0-9]° and", said)


@pytest.fixture(scope="module")
def faultless():
    how = dict(days=365, step=900.0, start="2023-01-01", seed=4)
    data = simulator.record(SITE, simulator.PHYSICS, **how)
    return data[[*COLUMNS, "relative_humidity", "wind_direction"]]


@pytest.mark.parametrize(
    "wrong", [{"gcr": 0.5}, {"max_angle": 45.0}, {"backtrack": False}, {"axis": 10.0}]
)
def test_a_tracker_that_is_described_wrongly_is_no_false_effect(faultless, wrong):
    off = wrong.pop("axis", 0.0)
    mount = replace(MOUNT, axis_azimuth=180.0 + off, **wrong)
    assert fem.close_loop(faultless, location=WHERE, mount=mount).effects == []


def test_an_axis_that_is_30_degrees_off_contradicts_the_light(faultless):
    mount = replace(MOUNT, axis_azimuth=150.0)
    loop = fem.close_loop(faultless, location=WHERE, mount=mount)
    assert "not of the stated plane" in str(loop.untestable["incidence_angle"])


def test_rows_without_angles_by_day_do_not_count_for_effects_of_the_plane(record):
    lacks = record.copy()
    lacks.loc["2023-04-03":"2023-04-12", "surface_tilt"] = np.nan
    sun = WHERE.get_solarposition(record.index)
    lacks.loc[sun["zenith"] > 91.0, ANGLES] = np.nan  # as pvlib has nights
    # its gain in the whole record is 0.17 K, of which the gap takes some
    criteria = fem.Criteria(min_rmse_reduction=0.1)
    loop = fem.close_loop(lacks, location=WHERE, criteria=criteria)
    assert "poa_misalignment" in loop.effects
    predicted = loop.predict(lacks)
    by_day = (sun["zenith"] < 88.0) & lacks["surface_tilt"].isna()
    assert predicted[by_day].isna().all() and by_day.any()
    night = (sun["zenith"] > 92.0) & ~predicted.index.isin(predicted[by_day].index)
    assert predicted[night]["2023-05"].notna().all()


@pytest.fixture(scope="module")
def summer():
    """A year of a tracker whose logger keeps daylight-saving time."""
    effects = simulator.PHYSICS | {"poa_misalignment": -TURNED, "file_dst": 1.0}
    data = simulator.record(SITE, effects, days=365, step=1800.0, start="2023-01-01")
    data.attrs = {}
    return data[[*COLUMNS, *ANGLES]].tz_localize(None)


@pytest.mark.parametrize("way", ["columns", "series", "mount"])
def test_angles_go_with_the_rows_when_a_clock_is_corrected(summer, way):
    place = Location(SITE.latitude, SITE.longitude, tz="Europe/Berlin")
    plain, series = summer[[*COLUMNS]], {name: summer[name] for name in ANGLES}
    data = summer if way == "columns" else plain
    own = series if way == "series" else {}
    how = {"mount": MOUNT} if way == "mount" else own
    loop = fem.close_loop(data, location=place, **how)
    assert [(c.fault, c.applied) for c in loop.corrections] == [("file_dst", True)]
    size = loop.fit.coefficients["poa_misalignment.azimuth"]
    assert size == pytest.approx(TURNED, abs=1.0)
    apart = loop.predict(data, **own) - summer["temp_module"]
    error = np.sqrt((apart**2).mean())
    assert error == pytest.approx(loop.table["rmse_test"].iloc[-1], rel=0.1)
    left = loop.residual(data, **own)
    pd.testing.assert_series_equal(left, -apart, check_names=False)


def test_a_plane_is_not_estimated_of_light_on_a_tracker(plain):
    loop = fem.close_loop(plain, location=WHERE)
    assert loop.place["surface_tilt"] is None
    assert str(loop.untestable["incidence_angle"]).startswith("no surface_azimuth")


def test_a_recorded_rotation_takes_the_place_of_the_described_one(tmp_path):
    """A tracker that is stowed for weeks is where it was, not where it should be."""
    effects = simulator.PHYSICS | {"poa_misalignment": -TURNED}
    stowed = {"tracker_stuck": 1.0, "tracker_stuck_sensor": 1.0}
    data = simulator.record(SITE, effects | stowed, days=150, step=900.0)
    theta = np.where(data["surface_azimuth"] > 180.0, 1.0, -1.0) * data["surface_tilt"]
    stuck = SITE.tracker.stuck
    theta[stuck.during(data.index)] = stuck.angle
    by_theta = data[[*COLUMNS]].assign(tracker_theta=theta)
    plane = pvlib.tracking.calc_surface_orientation(theta, 0.0, 180.0)
    by_angles = data[[*COLUMNS]].assign(**{name: plane[name] for name in ANGLES})
    one = fem.close_loop(by_theta, location=WHERE, mount=MOUNT)
    other = fem.close_loop(by_angles, location=WHERE)
    pd.testing.assert_frame_equal(one.table, other.table)
    assert "poa_misalignment" in one.effects and not one.standings
    assert one.place["mount"] == MOUNT
    predicted = one.predict(by_theta)
    pd.testing.assert_series_equal(predicted, other.predict(by_angles))
    wrong = by_theta.assign(tracker_theta=theta.where(theta > -20.0, -999.0))
    with pytest.raises(ValueError, match=r"tracker_theta is -999°.*--missing -999"):
        fem.close_loop(wrong, location=WHERE, mount=MOUNT)
    # and from files
    pytest.importorskip("pyarrow")
    by_theta.attrs = {}
    by_theta.to_parquet(tmp_path / "theta.parquet")
    files = fem.close_loop(tmp_path, location=WHERE, mount=MOUNT)
    assert files.effects == one.effects


# other functions ---------------------------------------------------------------


def test_prediction_takes_the_angles_of_its_own_rows(loop, described, record, plain):
    found = loop.predict(record)
    assert np.abs(found - described.predict(plain)).max() < 0.5
    with pytest.raises(
        ValueError, match="the data have no columns of their angles; add"
    ):
        loop.predict(plain)
    same = loop.predict(plain, **{name: record[name] for name in ANGLES})
    pd.testing.assert_series_equal(same, found)
    fixed = loop.predict(plain, surface_tilt=0.0, surface_azimuth=180.0)
    assert np.abs(fixed - found).max() > 0.3


def test_a_stored_loop_keeps_its_plane(loop, described, record, plain, tmp_path):
    for one, data in ((loop, record), (described, plain)):
        path = tmp_path / "loop.json"
        text = one.to_json(path)
        again = fem.Loop.from_json(path)
        assert again.place["mount"] == one.place["mount"]
        assert again.to_json() == text
        pd.testing.assert_series_equal(again.predict(data), one.predict(data))
    assert loop.place["mount"] == "columns" and described.place["mount"] == MOUNT


@pytest.mark.parametrize("mount", [MOUNT, FixedMount(30.0, 180.0)])
def test_a_chain_takes_the_mounting_of_its_own_array(loop, record, mount):
    weather = pvlib_weather(record.index[:480])
    module = {"pdc0": 1.0, "gamma_pdc": -0.004}
    array = pvlib.pvsystem.Array(mount, module_parameters=module)
    system = pvlib.pvsystem.PVSystem([array], inverter_parameters={"pdc0": 1.0})
    chain = pvlib.modelchain.ModelChain(
        system,
        WHERE,
        aoi_model="no_loss",
        spectral_model="no_loss",
        temperature_model=loop.temperature_model(deltaT=0.0),
    )
    chain.run_model(weather)
    results = chain.results
    poa = results.total_irrad["poa_global"].fillna(0.0)
    angles = chain.system.arrays[0].mount.get_orientation(
        results.solar_position["apparent_zenith"], results.solar_position["azimuth"]
    )
    plane = {name: pd.Series(angles[name], poa.index).fillna(0.0) for name in ANGLES}
    data = weather.assign(poa_global=poa, **plane)
    known = loop.predict(data, correct_times=False)
    apart = np.abs(results.cell_temperature - known)
    assert apart[poa > 20.0].max() < 0.05  # of the sun, here and there


def pvlib_weather(index):
    sun = WHERE.get_solarposition(index)
    clear = WHERE.get_clearsky(index, solar_position=sun)
    return clear.assign(temp_air=15.0, wind_speed=2.0)


def test_horizontal_irradiance_is_transposed_row_by_row(record, plain):
    weather = pvlib_weather(record.index[:960])
    sun = WHERE.get_solarposition(weather.index, method="ephemeris")
    plane = geometry(weather.index, WHERE, mount=MOUNT)
    expected = pvlib.irradiance.get_total_irradiance(
        *(plane[name] for name in ANGLES),
        sun["zenith"],
        sun["azimuth"],
        *(weather[name] for name in ("dni", "ghi", "dhi")),
        dni_extra=pvlib.irradiance.get_extra_radiation(weather.index),
        albedo=0.2,
        model="haydavies",
    )["poa_global"]
    by_mount = fem.transpose_record(
        weather, WHERE, transposition="haydavies", mount=MOUNT
    )["poa_global"]
    high = sun["zenith"] < 80.0
    np.testing.assert_allclose(by_mount[high], expected[high], 1e-3)
    columns = weather.assign(**{name: plane[name] for name in ANGLES})
    by_columns = fem.transpose_record(columns, WHERE, transposition="haydavies")
    pd.testing.assert_series_equal(by_columns["poa_global"], by_mount)


def test_a_loop_of_horizontal_irradiance_predicts_on_the_tracker(tmp_path):
    data = fem.datasets.synthetic(days=60, step=900, start="2023-05-01")
    place = Location(35.0, -106.0, tz="Etc/GMT+7")
    plane = geometry(data.index, place, mount=MOUNT)
    level = data[["ghi", *COLUMNS[1:]]]
    moving = level.assign(**{name: plane[name] for name in ANGLES})
    answers = []
    for what, how in ((level, {"mount": MOUNT}), (moving, {})):
        loop = fem.close_loop(what, location=place, transposition="perez", **how)
        loop.to_json(tmp_path / "loop.json")
        again = fem.Loop.from_json(tmp_path / "loop.json")
        pd.testing.assert_series_equal(again.predict(what), loop.predict(what))
        answers.append(loop.predict(what))
    pd.testing.assert_series_equal(*answers)
    with pytest.raises(ValueError, match="transposition needs the plane"):
        fem.close_loop(level, location=place, transposition="perez")


def test_a_ranking_and_a_recovery_know_the_tracker(record, plain):
    usual = [record[name] for name in COLUMNS]
    fit = fem.fit_fem(*usual, model="faiman", dynamics="balance", night=True)
    ranks = [
        fem.rank_effects(fit, data, ["poa_misalignment"], location=WHERE, **how)
        for data, how in ((record, {}), (plain, {"mount": MOUNT}))
    ]
    for found in ranks:
        size = found["coefficients"].iloc[0]["poa_misalignment.azimuth"]
        assert size == pytest.approx(TURNED, abs=2.0)
    found = fem.recover_effects(
        plain,
        "season",
        sizes=[3],
        location=WHERE,
        mount=MOUNT,
        processes=1,
        progress=False,
    )
    assert found.summary["ratio"].iloc[0] == pytest.approx(1.0, abs=0.4)


def test_a_clear_sky_on_a_tracker_has_the_shape_of_its_clear_days(record):
    poa, index = record["poa_global"].to_numpy(), record.index
    ratios, known = [], []
    for how in ({"mount": MOUNT}, {name: record[name] for name in ANGLES}, {}):
        angles = angles_at(index, checked_place(WHERE, **how))
        sky = pd.Series(clear_sky(poa, index, WHERE, angles), index)
        ratio = (poa / sky).dropna()
        ratios.append(ratio.groupby(ratio.index.normalize()).std().median())
        known.append(ratio.index.normalize().nunique())
    assert max(ratios[:2]) < 0.05 and min(known[:2]) >= 10
    assert known[2] == 0  # no day has the shape of a level plane


def test_a_clock_is_judged_by_the_light_of_the_tracker(record):
    late = record["poa_global"].copy()
    late.index = late.index + pd.Timedelta("2h")
    found = detect.time_shifts(late, WHERE, label="right", mount=MOUNT)
    assert abs(found.minutes.median()) == pytest.approx(120.0, abs=15.0)


# errors ------------------------------------------------------------------------


def test_what_is_no_plane_is_refused_with_its_remedy(record, plain):
    def refused(words, data=record, **how):
        with pytest.raises(ValueError, match=words):
            fem.close_loop(data, location=how.pop("location", WHERE), **how)

    refused("surface_tilt is given as 30°, and the column", surface_tilt=30.0)
    refused("tilt and a mount are given", plain, surface_tilt=30.0, mount=MOUNT)
    refused("tracker is described, and data have the column", mount=MOUNT)
    refused("is given, and data have a column", surface_tilt=record["surface_tilt"])
    refused("follows the sun: give location", plain, location=None, mount=MOUNT)
    refused("mount is 3", plain, mount=3)
    wrong = replace(MOUNT, gcr=1.4)
    refused("mount.gcr is 1.4; it is from 0.01 to 1", plain, mount=wrong)
    refused("surface_tilt is 190°; it is from 0 to 180°", plain, surface_tilt=190.0)
    refused("surface_azimuth is 400°", plain, surface_tilt=1.0, surface_azimuth=400.0)
    east = np.where(record["surface_azimuth"] < 180.0, -1.0, 1.0)
    rotation = record.assign(surface_tilt=east * record["surface_tilt"])
    refused("surface_tilt is -.*rotation.*tracker_theta", rotation)
    south = record.assign(surface_azimuth=record["surface_azimuth"] - 180.0)
    refused("surface_azimuth is -90°.*from south add 180", south)
    short = record["surface_tilt"].iloc[1:]
    how = {"surface_tilt": short, "surface_azimuth": 180.0}
    refused("give Series at the times of the data", plain, **how)


def test_effects_of_a_tracker_of_which_only_the_tilt_is_known_name_what_lacks(record):
    data = record.drop(columns="surface_azimuth")
    loop = fem.close_loop(data, location=WHERE, effects=["incidence_angle"])
    assert str(loop.untestable["incidence_angle"]) == "no surface_azimuth"


# command line and fleet --------------------------------------------------------


@pytest.fixture(scope="module")
def folder(record, plain, tmp_path_factory):
    found = tmp_path_factory.mktemp("trackers")
    for name, data in (("columns", record), ("plain", plain)):
        data.tz_localize(None).to_csv(found / f"{name}.csv", index_label="time")
    names = {name.removesuffix("_column"): column for name, column in NAMED.items()}
    record.tz_localize(None).rename(columns=names).to_csv(
        found / "named.csv", index_label="time"
    )
    return found


NAMED = {"surface_tilt_column": "Trk tilt", "surface_azimuth_column": "Trk azimuth"}
LATITUDE = ("--lat", SITE.latitude, "--lon", SITE.longitude, "--tz", "Etc/GMT-1")
DESCRIBED = ("--axis-azimuth", 180, "--max-angle", 60, "--gcr", 0.35)


def size_in(path):
    return json.loads(path.read_text())["fit"]["coefficients"][
        "poa_misalignment.azimuth"
    ]


def test_the_command_takes_columns_and_a_described_tracker(loop, described, folder):
    for name, more, known in (("columns", (), loop), ("plain", DESCRIBED, described)):
        out = folder / f"{name}.json"
        said = call("loop", folder / f"{name}.csv", *LATITUDE, *more, "--out", out)
        assert said.exit_code == 0, said.output
        size = known.fit.coefficients["poa_misalignment.azimuth"]
        assert size_in(out) == pytest.approx(size, rel=1e-6)
    assert json.loads(out.read_text())["place"]["mount"]["max_angle"] == 60.0


def test_columns_of_other_names_are_mapped_to_the_angles(loop, record, folder):
    names = {name.removesuffix("_column"): column for name, column in NAMED.items()}
    maps = [word for n, c in names.items() for word in ("--map", f"{n}={c}")]
    out = folder / "named.json"
    said = call("loop", folder / "named.csv", *LATITUDE, *maps, "--out", out)
    assert said.exit_code == 0, said.output
    size = loop.fit.coefficients["poa_misalignment.azimuth"]
    assert size_in(out) == pytest.approx(size, rel=1e-6)


def test_a_column_of_rotations_is_mapped(loop, record, folder):
    east = np.where(record["surface_azimuth"] < 180.0, -1.0, 1.0)
    data = record.drop(columns=ANGLES).assign(turn=east * record["surface_tilt"])
    data.tz_localize(None).to_csv(folder / "turn.csv", index_label="time")
    out = folder / "turn.json"
    more = ("--map", "tracker_theta=turn", "--axis-azimuth", 180)
    said = call("loop", folder / "turn.csv", *LATITUDE, *more, "--out", out)
    assert said.exit_code == 0, said.output
    size = loop.fit.coefficients["poa_misalignment.azimuth"]
    assert size_in(out) == pytest.approx(size, rel=1e-6)


@pytest.mark.parametrize(
    "more, words",
    [
        ((*LATITUDE, *DESCRIBED, "--tilt", 3, "--azimuth", 180), "leave out --tilt"),
        (("--gcr", 0.3), "follows the sun: give --lat and --lon"),
        ((*LATITUDE, "--axis-tilt", 95), "0<=x<=90"),
    ],
)
def test_the_command_refuses_what_is_no_tracker(folder, more, words):
    said = call("loop", folder / "plain.csv", *more)
    assert said.exit_code != 0 and words in said.output, said.output


def test_a_fit_takes_effects_of_the_tracker(described, folder):
    out = folder / "fit.json"
    effects = ("--effects", "poa_misalignment", "--model", "faiman")
    dynamics = ("--dynamics", "balance", "--method", "least_squares")
    said = call(
        *("fit", folder / "plain.csv", *LATITUDE, *DESCRIBED, "--no-backtrack"),
        *(*effects, *dynamics, "--out", out),
    )
    assert said.exit_code == 0, said.output
    (effect,) = json.loads(out.read_text())["effects"]
    assert effect == {"name": "poa_misalignment", "axis_azimuth": 180.0}


def test_a_fleet_has_trackers_by_its_table_and_by_columns(loop, described, folder):
    place = {"latitude": SITE.latitude, "longitude": SITE.longitude, "tz": "Etc/GMT-1"}
    tracker = {"axis_azimuth": "180", "max_angle": "60", "gcr": "0.35"}
    rows = [
        {"id": "A", "file": "plain.csv", **place, **tracker, "backtrack": "yes"},
        {"id": "B", "file": "columns.csv", **place},
        {"id": "C", "file": "named.csv", **place, **NAMED},
    ]
    table = folder / "systems.csv"
    pd.DataFrame(rows).to_csv(table, index=False)
    found = fem.fleet.run(table, folder / "fleet", workers=0)
    assert (found.systems["state"] == "done").all(), found.systems["message"]
    sizes = found.coefficients.set_index(["id", "coefficient"])["value"]
    for name, known in (("A", described), ("B", loop), ("C", loop)):
        key = "poa_misalignment.azimuth"
        assert sizes[name, key] == pytest.approx(known.fit.coefficients[key], rel=1e-6)


@pytest.mark.parametrize(
    "cells, words",
    [
        ({"surface_tilt": "20", "surface_azimuth": "0"}, "surface_tilt and axis_azi"),
        ({"gcr": "1.5"}, "gcr is 1.5; it is 0.01 to 1"),
        ({"latitude": None, "longitude": None}, "axis_azimuth and no latitude"),
        ({"backtrack": "maybe"}, "backtrack is 'maybe'"),
    ],
)
def test_a_wrong_tracker_in_the_table_is_refused(tmp_path, cells, words):
    row = {"id": "A", "file": "a.csv", "latitude": 49.4, "longitude": 8.7}
    table = pd.DataFrame([row | {"axis_azimuth": "180"} | cells])
    with pytest.raises(ValueError, match=words):
        fem.fleet.run(table, tmp_path, workers=0)


@pytest.mark.parametrize(
    ("name", "text"),
    [("surface_tilt", "flat"), ("tracker_theta", "flat"), ("tracker_theta", "30.0")],
)
def test_a_text_among_angles_is_named(record, plain, name, text):
    angles = record["surface_tilt"].astype(object)
    angles.iloc[7] = text
    data = plain if name == "tracker_theta" else record
    how = {"mount": MOUNT} if name == "tracker_theta" else {}
    words = f"{name} holds '{text}' at {record.index[7]} (row 7)"
    with pytest.raises(ValueError, match=re.escape(words)):
        fem.close_loop(data.assign(**{name: angles}), location=WHERE, **how)


def test_rotations_without_a_value_leave_the_tracker_as_described(plain, described):
    data = plain.assign(tracker_theta=np.nan)
    loop = fem.close_loop(data, location=WHERE, mount=MOUNT)
    assert "tracker_theta holds no value: not used" in loop.notes
    assert loop.fit.coefficients == described.fit.coefficients
    assert loop.effects == described.effects
