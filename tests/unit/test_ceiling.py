"""How much could still be explained: what trees reach that know no cause."""

import json
import sys
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from conftest import call
from threadpoolctl import threadpool_limits

import pvlib_fem as fem
from pvlib_fem import plotting, simulator
from pvlib_fem._ceiling import trees as room
from pvlib_fem._ceiling.ceiling_result import Ceiling
from pvlib_fem._ceiling.tree_columns import features, group_of, past_means, past_of
from pvlib_fem._ceiling.trees import left_out
from pvlib_fem._record.inputs import as_record
from pvlib_fem._statistics.clusters import calendar_weeks

USUAL = ["poa_global", "temp_air", "wind_speed", "temp_module"]


def simulated(days=150, **hidden):
    effects = simulator.PHYSICS | hidden
    how = dict(days=days, step=3600, seed=5, start="2023-04-01")
    return simulator.record(effects=effects, **how)[USUAL]


@pytest.fixture(scope="module")
def record():
    """A sensor of irradiance in the shade by chance, and a second one in the sun."""
    data = simulated()
    shaded = np.random.default_rng(2).uniform(size=len(data)) < 0.2
    data["poa_global_2"] = data["poa_global"]
    data["poa_global"] *= np.where(shaded, 0.7, 1.0)
    return data


@pytest.fixture(scope="module")
def loop(record):
    return fem.close_loop(record)


@pytest.fixture(scope="module")
def ceiling(loop):
    return replace(loop).ceiling()


def test_trees_follow_what_no_effect_of_the_loop_does(ceiling):
    """A second sensor is a cross-check, and drives nothing."""
    assert ceiling.trees < 0.6 * ceiling.causes
    assert ceiling.share(ceiling.causes) < 0.2 < ceiling.closed
    lost = {name: error - ceiling.trees for name, error in ceiling.without.items()}
    assert ceiling.most == max(lost, key=lost.get) == "other columns"
    assert {*lost} == {
        "other columns",
        "wind",
        "past values",
        "hour and season",
        "date",
    }


def test_they_follow_a_timetable_by_the_hour():
    """Heat at weekends by day, which is in no catalogue."""
    loop = fem.close_loop(simulated(weekend_exhaust=2.0))
    assert loop.unexplained and loop.ceiling().most == "hour and season"


def test_it_is_of_the_rows_of_the_table(loop, ceiling):
    table = loop.table["rmse_test"]
    assert ceiling.causes == pytest.approx(table[loop.last], rel=1e-12)
    assert ceiling.loop == table.iloc[-1] < ceiling.causes
    assert ceiling.paper == table["fem"]
    assert 0 < ceiling.rows <= (loop.weeks == "test").sum()


def test_the_share_is_of_squares():
    half = Ceiling(paper=3.0, loop=np.sqrt(5.0), trees=1.0, rows=9)
    assert half.closed == pytest.approx(0.5) and half.most == ""
    assert Ceiling(2.0, 1.0, 1.0, 9).closed == 1.0
    assert Ceiling(2.0, 1.0, 1.5, 9).closed > 1.0
    nothing = Ceiling(1.0, 0.9, 1.0, 9, {"date": 0.9, "wind": 1.0})
    assert np.isnan(nothing.closed) and nothing.most == ""
    assert "find nothing" in str(nothing) and "nan" not in str(nothing)


@pytest.mark.parametrize("errors", [(2.0, 1.5, 1.0), (1.0, 1.1, 0.9), (1.0, 1.2, 1.1)])
def test_the_bar_is_as_long_as_the_error_of_the_papers_form(errors):
    """A loop that makes the error larger explains nothing of it."""
    pytest.importorskip("matplotlib")
    axes = plotting.plot_ceiling(Ceiling(*errors, rows=9))
    widths = [part.get_width() for part in axes.patches]
    assert sum(widths) == pytest.approx(errors[0] ** 2) and min(widths) >= 0.0
    axes.figure.clear()


def test_what_is_made_from_the_answer_is_no_column_of_the_trees(record, ceiling):
    """A second sensor of it, and what the loop finds to be made from it."""
    noise = np.random.default_rng(0).normal(0.0, 0.05, len(record))
    second = record["temp_module"] + noise
    known = record.assign(temp_module_2=second, cell=1.02 * second + 1.0)
    loop = fem.close_loop(known)
    assert "module temperature itself" in str(loop.untestable["driver:cell"])
    names, _ = features(loop.fit.record, loop, np.arange(9))
    assert not [n for n in names if n.startswith(("cell", "temp_module"))]
    again = loop.ceiling()
    assert (again.trees, again.without) == (ceiling.trees, ceiling.without)


def test_columns_have_a_group_by_their_name():
    names = {
        "power": ["power_ac", "p_dc_per_area", "p_mp"],
        "wind": ["wind_speed", "wind_direction", "wind_speed_mast"],
        "other columns": ["relative_humidity", "temp_air_2", "fan"],
    }
    found = {group: [group_of(name) for name in own] for group, own in names.items()}
    assert found == {group: [group] * len(own) for group, own in names.items()}


def test_a_column_that_nobody_measured_is_none():
    data = simulated(days=60).drop(columns="wind_speed")
    found = fem.close_loop(data, model="ross").ceiling()
    assert {*found.without} == {"past values", "hour and season", "date"}


def test_a_loop_that_sees_all_leaves_trees_little(record):
    """The cause as a column, which a loop names."""
    data = record.drop(columns="poa_global_2")
    data["unseen"] = record["poa_global_2"] - record["poa_global"]
    loop = fem.close_loop(data)
    assert "driver:unseen" in loop.effects
    found = loop.ceiling()
    assert found.closed > 0.8 and "other columns" in found.without


def test_the_past_is_of_the_past_alone():
    index = pd.date_range("2024-01-01", periods=200, freq="30min").delete([90, 91])
    random = np.random.default_rng(1).normal(20.0, 5.0, (len(index), 4))
    columns = [pd.Series(np.abs(part), index) for part in random.T]
    first = as_record(*columns)
    changed = [part.where(index < index[100], 25.0) for part in columns]
    rows = np.arange(len(index))
    for name in ("poa_global", "wind_speed"):
        one, other = (
            pd.DataFrame(dict(past_of(name, record, rows)))
            for record in (first, as_record(*changed))
        )
        pd.testing.assert_frame_equal(one[:101], other[:101])
        assert (one[103:] != other[103:]).all(axis=None)
    before = pd.DataFrame(dict(past_of("poa_global", first, rows)))
    measured = np.asarray(first["poa_global"])
    assert before["poa_global, 2 before"][50] == measured[48]
    gaps = np.flatnonzero(before["poa_global, 1 before"].isna())
    assert gaps.tolist() == [0, 90]  # none over a gap
    hour = before["poa_global, 1h before"]
    assert hour[50] == pytest.approx(measured[48:50].mean())


def test_the_past_mean_of_winds_about_north_is_north():
    times = pd.date_range("2023-06-01", periods=600, freq="5min", tz="UTC")
    degrees = np.random.default_rng(0).normal(0.0, 15.0, 600) % 360.0
    means = past_means(pd.Series(degrees, times), "6h", circular=True).iloc[72:]
    assert (np.abs((means + 180.0) % 360.0 - 180.0) < 10.0).all()


def test_whole_weeks_are_left_out_to_count_trees():
    dates = np.repeat(np.arange(19_000, 19_070), 24)
    out, weeks = left_out(dates), calendar_weeks(dates)
    assert 0.1 < out.mean() < 0.3
    assert not {*weeks[out]} & {*weeks[~out]}
    few = dates[: 20 * 24]
    out = left_out(few)
    assert 0.1 < out.mean() < 0.3 and not {*few[out]} & {*few[~out]}


@pytest.mark.parametrize("threads", [1, 2])
def test_threads_change_nothing(loop, ceiling, threads):
    with threadpool_limits(limits=threads, user_api="openmp"):
        assert replace(loop).ceiling() == ceiling


def test_a_long_record_is_thinned(loop, ceiling, monkeypatch):
    grown = []
    monkeypatch.setattr(room, "MOST_ROWS", 1000)
    monkeypatch.setattr(
        room.Trees, "error", lambda self, *how: grown.append(self.fitting) or 1.0
    )
    found = replace(loop).ceiling()
    assert {*grown} == {grown[0]} and 500 < grown[0] <= 1000
    assert found.rows == ceiling.rows


def test_it_is_kept_in_report_and_file(record, tmp_path):
    loop = fem.close_loop(record)
    bare, page = str(loop), loop.to_html()
    assert loop.known_ceiling is None and json.loads(loop.to_json())["ceiling"] is None
    words = str(loop.ceiling())
    assert words not in page and "could be explained" not in bare
    assert " ".join(words.split()) in " ".join(str(loop).split())
    page = loop.to_html()
    assert page.count(f"<p>{words.replace(chr(39), '&#39;')}</p>") == 1
    assert page.count("How much could still be explained") == 1
    again = fem.Loop.from_json(write(loop, tmp_path / "loop.json"))
    assert again.known_ceiling == again.ceiling() == loop.ceiling()
    assert again.to_json() == loop.to_json() and "<svg" in again.to_html()


def write(loop, path):
    loop.to_json(path)
    return path


def test_what_has_no_ceiling_says_why(loop, tmp_path, monkeypatch):
    again = fem.Loop.from_json(write(loop, tmp_path / "loop.json"))
    with pytest.raises(ValueError, match="has no rows to grow trees on"):
        again.ceiling()
    short = fem.close_loop(simulated(days=12))
    with pytest.raises(ValueError, match="trees need 10 fitting days"):
        short.ceiling()
    monkeypatch.setitem(sys.modules, "sklearn.ensemble", None)
    with pytest.raises(ImportError, match=r"pip install 'pvlib_fem\[ceiling\]'"):
        loop.ceiling()


def test_the_command_adds_it(record, tmp_path, monkeypatch):
    path = tmp_path / "plant.csv"
    record.tz_localize(None).to_csv(path)
    said = call("loop", path, "--ceiling")
    assert said.exit_code == 0, said.output
    assert "boosted trees on the same columns" in " ".join(said.output.split())
    monkeypatch.setattr("pvlib_fem._cli.output_files.find_spec", lambda name: None)
    said = call("loop", path, "--ceiling")
    assert said.exit_code == 1 and "pip install 'pvlib_fem[ceiling]'" in said.output
