"""The loop of files is that of the same record in memory, on means."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from pvlib.location import Location
from pvlib.pvsystem import SingleAxisTrackerMount

import pvlib_fem as fem
from pvlib_fem._cli import main
from pvlib_fem._loop.results.parquet_loop import OwnSteps
from pvlib_fem.simulator import PHYSICS, record

pytest.importorskip("pyarrow")
NAMES = ["poa_global", "temp_air", "wind_speed", "temp_module", "wind_direction"]


@pytest.fixture(scope="module")
def data():
    effects = PHYSICS | {"wind_direction": 1.0}
    data = record(effects=effects, days=84, step=120, seed=4, start="2023-04-01")
    return data[NAMES]


@pytest.fixture(scope="module")
def folder(data, tmp_path_factory):
    folder = tmp_path_factory.mktemp("record")
    for i, part in enumerate(np.array_split(np.arange(len(data)), 3)):
        own = data.iloc[part]
        own.attrs = {}
        own.to_parquet(folder / f"{i}.parquet", row_group_size=9000)
    return folder


@pytest.fixture(scope="module")
def loops(data, folder):
    return fem.close_loop(data), fem.close_loop(folder)


def test_the_findings_are_those_in_memory(loops):
    one, other = loops
    found = [[(f.effect, f.verdict) for f in loop.finding_objects] for loop in loops]
    assert found[0] == found[1]
    assert "wind_direction" in one.effects
    assert one.untestable.keys() == other.untestable.keys()
    for a, b in zip(one.finding_objects, other.finding_objects):
        assert b.coefficients == pytest.approx(a.coefficients, rel=0.1, abs=0.1)


def test_what_the_files_lack_is_where_the_means_have_it(tmp_path):
    """The sun by its place, and with it the clouds of a day, at the record's steps."""
    site = fem.simulator.RHINE
    effects = PHYSICS | {"sky_radiation": 1.0}
    data = record(effects=effects, days=84, step=120, seed=4, start="2023-04-01")
    data = data[[*NAMES[:4], "relative_humidity"]]
    data.attrs = {}
    data.to_parquet(tmp_path / "record.parquet")
    place = dict(
        location=Location(site.latitude, site.longitude, tz=site.tz),
        surface_tilt=site.surface_tilt,
        surface_azimuth=site.surface_azimuth,
    )
    one, other = (fem.close_loop(what, **place) for what in (data, tmp_path))
    assert "sky_radiation" in one.effects and one.effects == other.effects
    (effect,) = [e for e in one.fit.effects if e.name == "sky_radiation"]
    assert effect.source == "humidity"
    own = other.own_steps
    for name, value in one.fit.coefficients.items():
        assert abs(own.coefficients[name] - value) < 0.3 * one.fit.stderr[name]
    assert own.scores["rmse_train"].iloc[-1] == pytest.approx(
        one.table["rmse_train"][one.last], abs=0.005
    )
    assert not any("for sky_radiation" in note for note in own.notes)


@pytest.mark.parametrize("described", [True, False])
def test_a_tracker_in_files_is_that_in_memory(tmp_path, described):
    """Angles are those at the end of a step, and by night of a level plane."""
    site = replace(fem.simulator.RHINE, tracker=fem.simulator.Tracker())
    effects = PHYSICS | {"poa_misalignment": 8.0}
    data = record(site, effects, days=90, step=120, seed=4, start="2023-04-01")
    place = Location(site.latitude, site.longitude, tz=site.tz)
    angles = ["surface_tilt", "surface_azimuth"]
    night = place.get_solarposition(data.index)["apparent_zenith"] > 90.0
    data.loc[night, angles] = np.nan  # as pvlib has them
    data = data[[*NAMES, *angles]]
    how = {"location": place}
    if described:
        data = data.drop(columns=angles)
        how["mount"] = SingleAxisTrackerMount(0.0, 180.0, 60.0, True, 0.35)
    data.attrs = {}
    data.to_parquet(tmp_path / "record.parquet")
    one, other = (fem.close_loop(what, **how) for what in (data, tmp_path))
    assert "poa_misalignment" in one.effects and one.effects == other.effects
    assert other.own_steps.summary.rows > 0.97 * len(one.weeks)
    for name, value in one.fit.coefficients.items():
        assert (
            abs(other.own_steps.coefficients[name] - value) < 0.1 * one.fit.stderr[name]
        )


def test_the_last_model_is_fitted_to_the_records_own_steps(loops):
    one, other = loops
    own = other.own_steps
    assert own.summary.rows == len(one.weeks)
    assert one.fit.coefficients
    for name, value in one.fit.coefficients.items():
        # the loop ends where the errors of the coefficients are a thousand times more
        assert abs(own.coefficients[name] - value) < 1e-2 * one.fit.stderr[name]
    assert own.scores["rmse_train"].iloc[-1] == pytest.approx(
        one.table["rmse_train"].iloc[-1], rel=1e-4
    )
    (line,) = (note for note in other.notes if "own_steps" in note)
    assert f"{own.scores['rmse_test'].iloc[-1]:.3g} K on the weeks" in line


def test_what_means_alone_follow_is_withdrawn(tmp_path):
    """
    Of heat behind the module a logger writes means of 5 min that are right.

    Between them it writes a beat ten times as large, of which the module knows nothing.
    """
    data = record(effects=PHYSICS, days=70, step=60, seed=4, start="2023-04-01")
    data = data[NAMES[:4]]
    data.attrs = {}
    hours = np.arange(len(data)) / 60.0
    heat = pd.Series(60.0 * (np.floor(hours / 1.7) % 2), data.index)
    data["temp_module"] += fem.ewm(0.03 * heat, 600.0)
    beat = np.resize([2.0, 1.0, -6.0, 1.0, 2.0], len(data))
    sign = np.random.default_rng(1).choice([-1.0, 1.0], len(data) // 5 + 1)
    data["fan"] = heat + 500.0 * np.roll(beat * sign.repeat(5)[: len(data)], 1)
    data.to_parquet(tmp_path / "record.parquet")
    loop = fem.close_loop(tmp_path)
    (found,) = (f for f in loop.finding_objects if f.effect == "driver:fan")
    assert found.verdict == "hint"
    assert "on the record's own steps the error falls by 0." in found.why
    assert found.checks[-1].name == "share kept on the own steps"
    assert "driver:fan" not in loop.effects
    assert loop.own_steps.thermal_model.effects == loop.fit.effects


def test_a_finding_is_weighed_by_the_step_on_which_it_was_tried(folder, monkeypatch):
    """With a tau that is held it is the paper's form; balance comes after that."""
    falls, against = [], OwnSteps.against

    def kept(self, case, step, inputs, corrected, asked):
        falls.extend(asked)
        return against(self, case, step, inputs, corrected, asked)

    monkeypatch.setattr(OwnSteps, "against", kept)
    loop = fem.close_loop(folder, fixed={"tau": 600.0})
    squares = loop.table["rmse_train"] ** 2
    path = [loop.base, *(f"+{name}" for name in loop.effects)]
    assert [f"+{finding.effect}" for finding, _ in falls] == path[1:] and falls
    for (_, fall), before, after in zip(falls, path, path[1:]):
        assert fall == pytest.approx(squares[before] - squares[after], rel=1e-2)


def test_days_are_held_out_and_the_command_goes(folder, loops):
    days = pd.Series(True, pd.date_range("2023-05-01", periods=14))
    loop = fem.close_loop(folder, holdout=days, effects="wind_direction")
    test = loop.weeks.index[loop.weeks == "test"]
    assert {str(day) for day in test.date} == {str(day.date()) for day in days.index}
    how = ["--holdout", "2023-05-01..2023-05-14", "--effects", "wind_direction"]
    found = CliRunner().invoke(main, ["loop", str(folder), *how])
    assert found.exit_code == 0, found.output
    assert str(loop).strip() in found.output
