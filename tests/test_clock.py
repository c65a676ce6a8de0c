"""A module cannot answer before the sun asks: clocks by causality."""

import numpy as np
import pandas as pd
import pytest
from conftest import COLUMNS, measured

from pvlib_fem import datasets, simulator
from pvlib_fem.quality.clock import clock_shift
from pvlib_fem.quality.onset import DAY
from pvlib_fem.simulator import ALBUQUERQUE, OUTDOORS, PHYSICS, RHINE


def checked(data):
    return measured(*(data[name] for name in COLUMNS))


def clock(effects, days=30, step=60.0, seed=7, start="2023-05-01", site=RHINE):
    data = simulator.record(site, effects, days, step, seed, start=start)
    return clock_shift(checked(data))


@pytest.mark.parametrize("late", [-90, -5, -2, 0, 1, 3, 10])
def test_a_shift_is_recovered_to_a_third_of_a_sample(late):
    found = clock(PHYSICS | {"clock_shift": late})
    assert found.late / 60 == pytest.approx(late, abs=0.3)
    # 1 min at 1-min samples is what averaging and the sensor may do
    assert set(found.faults) == ({"clock_shift"} if abs(late) > 1 else set())


def test_a_shift_alone_moves_the_onset_exactly():
    """What sensors and sampling add is the same in both and drops out."""
    as_is, late = (clock(PHYSICS | {"clock_shift": by}, 20) for by in (0, 4))
    assert (late.late - as_is.late) / 60 == pytest.approx(4.0, abs=0.02)


@pytest.mark.parametrize(("step", "late"), [(10.0, 3), (300.0, -8), (600.0, 15)])
def test_a_shift_is_recovered_to_a_third_of_any_sample(step, late):
    found = clock(OUTDOORS | {"clock_shift": late}, 8 if step < 60 else 60, step)
    assert found.late == pytest.approx(60.0 * late, abs=max(step, 60.0) / 3)
    assert found.fault


@pytest.mark.parametrize("step", [600.0, 900.0])
def test_coarse_rows_tell_no_false_time(step):
    assert clock(OUTDOORS, 90, step, 2, "2023-03-01").faults == {}


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("effects", [PHYSICS, OUTDOORS], ids=["physics", "outdoors"])
@pytest.mark.parametrize(("step", "days"), [(60.0, 30), (300.0, 150)])
def test_no_weather_makes_a_clock_late(effects, step, days, seed):
    """Not a second mass, dew, snow, wind, nor the sensors' noise."""
    found = clock(effects, days, step, seed, "2023-01-01")
    assert not found.fault
    assert found.why == ""
    assert abs(found.late) < 0.35 * 60 + found.stderr * 3
    assert found.stderr < 0.2 * step


@pytest.mark.parametrize("tau", [150.0, 378.0, 1500.0])
def test_a_slow_module_is_not_late(tau):
    data = datasets.synthetic(15, model="ross", dynamics="ewm", k=0.03, tau=tau)
    found = clock_shift(checked(data))
    # its sensor is instant, and clock_shift takes half a minute for a real one
    assert -60 < found.late < 0
    assert not found.fault


@pytest.mark.parametrize(("days", "step"), [(30, 60.0), (150, 300.0)])
def test_a_drift_is_recovered(days, step):
    """7 s a day: J. Barry's PVRAD loggers."""
    found = clock(OUTDOORS | {"clock_drift": 7.0}, days, step)
    assert found.drift == pytest.approx(7.0, rel=0.1)
    assert "clock_drift" in found.faults
    assert f"{found.drift:.1f} ± {found.drift_stderr:.1f} s every day" in found.why
    assert found.late == pytest.approx(7.0 * days / 2, abs=30.0)


@pytest.mark.parametrize(
    ("start", "date", "by"),
    [("2023-03-01", "2023-03-26", 3600), ("2023-10-01", "2023-10-29", -3600)],
)
@pytest.mark.parametrize(("site", "step"), [(RHINE, 60.0), (ALBUQUERQUE, 300.0)])
def test_daylight_saving_is_found_with_its_date(start, date, by, site, step):
    found = clock(OUTDOORS | {"dst": 1.0}, 50, step, 3, start, site)
    assert list(found.faults) == ["dst"]
    ((day, jump),) = found.jumps
    assert abs(day.tz_localize(None) - pd.Timestamp(date)) <= pd.Timedelta("2D")
    assert jump == by
    assert f"{by / 60:+.0f} min on" in found.why


@pytest.fixture(scope="module")
def worst():
    """A year that drifts and keeps daylight-saving time, and one that does not."""
    both = {"clock_drift": 7.0, "dst": 1.0, "clock_shift": -15.0}
    scenarios = [OUTDOORS, OUTDOORS | both]
    return list(simulator.records(RHINE, scenarios, 365, 300.0, 4))


def test_all_faults_of_a_year_are_told_apart(worst):
    found = clock_shift(checked(worst[1]))
    assert set(found.faults) == {"clock_drift", "clock_shift", "dst"}
    assert [by for _, by in found.jumps] == [3600, -3600]
    assert found.drift == pytest.approx(7.0, rel=0.02)
    assert found.blocks["late"].max() > 3600
    assert list(found.blocks) == ["start", "seconds", "late", "stderr"]


def test_a_corrected_column_is_the_one_of_a_right_clock(worst):
    right, wrong = worst
    record = checked(wrong)
    found = clock_shift(record)
    module = found.corrected(record.inputs.seconds, record["temp_module"])
    error = module - right["temp_module"].to_numpy()
    before = record["temp_module"] - right["temp_module"].to_numpy()
    # 0.3 K of sensor noise are as they were, on a grid of 5 min
    assert np.nanstd(error) < 0.2 * np.nanstd(before)
    assert clock_shift(checked(right.assign(temp_module=module))).faults == {}


def test_a_right_clock_changes_nothing(worst):
    record = checked(worst[0])
    found = clock_shift(record)
    values = found.corrected(record.inputs.seconds, record["temp_module"])
    assert np.array_equal(values, record["temp_module"], equal_nan=True)
    assert not found.at(record.inputs.seconds).any()


def test_rows_that_are_lost_and_a_sensor_that_stood_still_do_no_harm():
    found = clock(OUTDOORS | {"missing": 5.0, "stuck": 3.0, "clock_shift": 3.0})
    assert found.late / 60 == pytest.approx(3.0, abs=0.35)


def test_the_zone_of_the_index_does_not_matter():
    data = simulator.record(ALBUQUERQUE, OUTDOORS, 20, 60.0, 1)
    here, there = (clock_shift(checked(d)) for d in (data, data.tz_convert("UTC")))
    assert here.late == pytest.approx(there.late, abs=1.0)


def test_the_measured_week_has_a_right_clock(week):
    """The prototype of this test found its onset at 0 to 1 min."""
    found = clock_shift(checked(week))
    assert not found.fault
    assert abs(found.late) < 60


@pytest.mark.parametrize(
    ("days", "step", "reason"),
    [
        (1, 60.0, "the record is shorter than two days"),
        (60, 3600.0, "rows are 60 min apart, longer than a response"),
    ],
)
def test_what_cannot_be_told_is_not_told(days, step, reason):
    found = clock(PHYSICS, days, step)
    assert np.isnan(found.late)
    assert not found.fault
    assert reason in found.why


def test_a_clear_sky_tells_no_time():
    times = pd.date_range("2023-06-01", periods=5 * 1440, freq="min")
    hour = np.arange(len(times)) / 60 % 24
    poa = 1000 * np.clip(np.sin((hour - 6) / 12 * np.pi), 0, None) ** 3
    air = np.random.default_rng(0).normal(20.0, 0.1, len(times))
    columns = (poa, air, np.full(len(times), 2.0), air + 0.03 * poa)
    found = clock_shift(measured(*(pd.Series(c, times) for c in columns)))
    assert not found.fault
    assert "too little broken cloud" in found.why


def test_late_means_that_the_module_is_written_later():
    """``temp_module(t + late)`` is what happened at ``t``."""
    data = simulator.record(RHINE, PHYSICS, 10, 60.0, 7, start="2023-05-01")
    later = data.assign(temp_module=data["temp_module"].shift(20))
    found = clock_shift(checked(later))
    assert found.late / 60 == pytest.approx(20.0, abs=0.35)
    record = checked(later)
    back = found.corrected(record.inputs.seconds, record["temp_module"])
    middle = slice(1440, -1440)
    error = back[middle] - data["temp_module"].to_numpy()[middle]
    assert np.std(error) < 0.1
    assert found.middle == pytest.approx(5 * DAY, rel=1e-3)
