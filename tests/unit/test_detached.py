"""A module's temperature sensor that comes off is said, and its rows are left out."""

import json

import numpy as np
import pandas as pd
import pytest

import pvlib_fem as fem
from pvlib_fem import simulator
from pvlib_fem._record.checks import dates_of
from pvlib_fem.quality._detached_sensor import DETACHED, detachments_of
from pvlib_fem.simulator import OUTDOORS, PHYSICS, RHINE

USUAL = ["poa_global", "temp_air", "wind_speed", "temp_module"]
START, FIRST, END = "2023-03-01", "2023-05-20 14:00", "2023-06-10 09:00"


@pytest.fixture(scope="module")
def year():
    return simulator.record(RHINE, OUTDOORS, 365, 1800.0, 31)


@pytest.fixture(scope="module")
def sound():
    data = simulator.record(RHINE, PHYSICS, 140, 1800.0, 32, start=START)
    return data[USUAL]


def within(data, start, end):
    zone = data.index.tz
    return (data.index >= pd.Timestamp(start, tz=zone)) & (
        data.index < pd.Timestamp(end, tz=zone)
    )


def in_air(data, *spans, share=0.004):
    """The record with a sensor that hangs behind the module."""
    data = data.copy()
    noise = np.random.default_rng(1).normal(0.0, 0.2, len(data))
    for span in spans:
        off = within(data, *span)
        reads = data["temp_air"] + share * data["poa_global"] + noise
        data.loc[off, "temp_module"] = reads[off]
    return data


def found_in(data, power=None):
    return detachments_of(
        *(data[name].to_numpy() for name in ("temp_module", "temp_air", "poa_global")),
        data.index,
        dates_of(data.index),
        power,
    )


@pytest.mark.parametrize("share", [0.0, 0.004])
@pytest.mark.parametrize(
    "spans",
    [
        [("2023-08-05 14:00", "2023-08-26 09:00")],
        [("2023-01-01", "2023-05-10 12:00")],
        [("2023-09-03 11:00", "2024-01-01")],
        [
            ("2023-05-04 10:00", "2023-05-22 15:00"),
            ("2023-06-20 08:00", "2023-07-30 12:00"),
        ],
    ],
    ids=["weeks", "from the start", "until the end", "twice"],
)
def test_its_rows_are_found(year, spans, share):
    found = found_in(in_air(year, *spans, share=share))
    assert len(found) == len(spans)
    for (one, first, end), span in zip(found, spans):
        off = np.flatnonzero(within(year, *span))
        day = 48
        assert off[0] - day < first <= off[0]  # a night at most is left out with it
        assert off[-1] < end < off[-1] + day
        assert (one.start == "") == (off[0] == 0)
        assert (one.end == "") == (off[-1] == len(year) - 1)
        assert one.rise == pytest.approx(share, abs=3e-4)
        assert 0.02 < one.attached < 0.04
        inside = one.rows_of(year.index)
        assert (np.flatnonzero(inside) == np.arange(first, end)).all()


def test_it_is_found_where_the_sensor_is_off_on_most_days(year):
    """The usual level is then that of the air."""
    ((one, _, end),) = found_in(in_air(year, ("2023-01-01", "2023-09-10 12:00")))
    off = np.flatnonzero(within(year, "2023-01-01", "2023-09-10 12:00"))
    assert 0 <= end - off[-1] < 48 and one.start == "" and one.attached > 0.02


def change(data, name, values, span=("2023-06-01", "2023-06-22")):
    data = data.copy()
    off = within(data, *span)
    data.loc[off, name] = pd.Series(values, data.index)[off]
    return data


OTHERS = {
    "nothing": lambda d: d,
    "a poor contact": lambda d: change(
        d, "temp_module", d["temp_air"] + 0.4 * (d["temp_module"] - d["temp_air"])
    ),
    "a contact that stays poor": lambda d: change(
        d,
        "temp_module",
        d["temp_air"] + 0.4 * (d["temp_module"] - d["temp_air"]),
        ("2023-08-20", "2024-01-01"),
    ),
    "an offset": lambda d: change(d, "temp_module", d["temp_module"] - 8.0),
    "a stuck sensor": lambda d: change(d, "temp_module", 22.0),
    "air that is measured at the module": lambda d: change(
        d, "temp_air", d["temp_module"]
    ),
    "irradiance that reads too much": lambda d: change(
        d, "poa_global", 1.9 * d["poa_global"]
    ),
    "modules under snow": lambda d: change(
        d,
        "temp_module",
        np.minimum(0.5 * d["temp_air"], 0.0),
        ("2023-01-01", "2023-03-01"),
    ),
}


@pytest.mark.parametrize("name", OTHERS)
def test_it_is_no_other_fault(year, name):
    assert found_in(OTHERS[name](year)) == []


def test_modules_that_are_covered_give_no_power(year):
    """Without power both look alike."""
    data = in_air(year, ("2023-06-01", "2023-06-22"))
    covered = change(data, "p_dc_per_area", 0.05 * data["p_dc_per_area"])
    assert len(found_in(data, data["p_dc_per_area"].to_numpy())) == 1
    assert not found_in(data, covered["p_dc_per_area"].to_numpy())


# ------------------------------------------------------------------ the loop
@pytest.fixture(scope="module")
def loops(sound):
    """Of a sensor that comes off, and of the same rows without a reading."""
    data = in_air(sound, (FIRST, END))
    loop = fem.close_loop(data)
    (one,) = loop.detachments
    missing = data.copy()
    missing.loc[one.rows_of(data.index), "temp_module"] = np.nan
    return loop, fem.close_loop(missing), data


def test_the_loop_is_that_of_the_record_without_its_rows(loops):
    loop, without, data = loops
    assert without.detachments == ()
    assert loop.effects == without.effects
    assert loop.fit.coefficients == pytest.approx(without.fit.coefficients)
    pd.testing.assert_frame_equal(loop.table, without.table)
    (one,) = loop.detachments
    assert one.rows == without.fit.record.missing["temp_module"]
    assert loop.fit.residual[one.rows_of(data.index)].isna().all()


def test_it_is_said_with_its_days_and_what_to_do(loops, tmp_path):
    loop = loops[0]
    one = loop.statements.iloc[0]
    assert (one["cause"], one["verdict"]) == (DETACHED, "left out")
    assert one["device"] == "module temperature sensor"
    assert one["text"].startswith("From 2023-05-20 until 2023-06-10 the module")
    assert "close to air temperature" in one["text"] and "come off" in one["text"]
    assert one["action"].startswith("Fix the sensor")
    assert (one["since"], one["until"]) == ("2023-05-20", "2023-06-10")
    assert -95.0 < one["value"] < -75.0
    assert "1 module temperature sensor that came off" in " ".join(str(loop).split())
    assert one["text"] in " ".join(str(loop).split())
    rows = f"{loop.detachments[0].rows:,} rows"
    assert any("has come off" in note and rows in note for note in loop.notes)
    loop.to_html(tmp_path / "page.html")
    assert "close to air temperature" in (tmp_path / "page.html").read_text()


def test_a_file_holds_it_and_a_file_of_before_has_none(loops, tmp_path):
    loop, path = loops[0], tmp_path / "loop.json"
    loop.to_json(path)
    again = fem.Loop.from_json(path)
    assert again.detachments == loop.detachments
    assert again.statements["text"].iloc[0] == loop.statements["text"].iloc[0]
    content = json.loads(path.read_text())
    del content["detachments"]
    path.write_text(json.dumps(content))
    assert fem.Loop.from_json(path).detachments == ()


def test_the_corrected_record_is_without_it(loops):
    loop, _, data = loops
    corrected = loop.corrected(data)
    (one,) = loop.detachments
    off = one.rows_of(data.index)
    assert corrected.data.loc[off, "temp_module"].isna().all()
    assert (corrected.data.loc[off, "corrected"] == DETACHED).all()
    same = corrected.data.loc[~off, "temp_module"] == data.loc[~off, "temp_module"]
    assert same.all()


def test_test_weeks_decide_nothing(loops):
    """What the sensor reads in them changes their own rows alone."""
    loop, _, data = loops
    test = (loop.weeks == "test").to_numpy()
    assert (test & within(data, FIRST, END)).any()
    other = data.copy()
    other.loc[test, "temp_module"] = data["temp_air"][test] + 0.02 * data["poa_global"]
    again = fem.close_loop(other)
    assert again.fit.coefficients == pytest.approx(loop.fit.coefficients)
    assert again.effects == loop.effects
    (one,) = again.detachments
    assert one.fitting


def test_a_time_that_the_fitting_weeks_do_not_show_is_said(sound):
    """Only rows of test weeks are left out; fitting rows stay as they were."""
    holdout = pd.Series(within(sound, "2023-05-15", "2023-06-12"), sound.index)
    data = in_air(sound, ("2023-05-16", "2023-06-11"))
    loop = fem.close_loop(data, holdout=holdout)
    (one,) = loop.detachments
    assert not one.fitting
    assert "test weeks" in loop.statements["certainty"].iloc[0]
    plain = fem.close_loop(sound, holdout=holdout)
    assert loop.fit.coefficients == pytest.approx(plain.fit.coefficients)


def test_rows_of_a_logger_that_is_late_are_left_out_by_its_own_clock(sound):
    data = in_air(sound, (FIRST, END))
    late = data.copy()
    late["temp_module"] = np.roll(data["temp_module"], 4)  # 2 h
    loop = fem.close_loop(late)
    assert loop.corrections[0].applied and len(loop.detachments) == 1
    off = np.flatnonzero(within(data, FIRST, END))
    unused = np.flatnonzero(loop.fit.residual.isna())
    assert {*off} <= {*unused}
    assert len(unused) < len(off) + 60


def test_files_leave_out_the_same_rows(tmp_path):
    pytest.importorskip("pyarrow")
    data = simulator.record(RHINE, PHYSICS, 84, 120.0, 33, start=START)[USUAL]
    data = in_air(data, ("2023-04-05 14:00", "2023-04-26 09:00"))
    data.attrs = {}
    data.to_parquet(tmp_path / "record.parquet")
    one, other = map(fem.close_loop, (data, tmp_path))
    (a,), (b,) = one.detachments, other.detachments
    assert (a.start[:10], a.end[:10]) == (b.start[:10], b.end[:10])
    assert one.effects == other.effects
    for name, value in one.fit.coefficients.items():
        own = other.own_steps.coefficients[name]
        assert abs(own - value) < 0.1 * one.fit.stderr[name]
    best = one.table["rmse_test"][one.last]
    assert other.own_steps.scores["rmse_test"].iloc[-1] == pytest.approx(best, rel=0.05)
