"""A module cannot answer before the sun asks: clocks by causality."""

import numpy as np
import pandas as pd
import pytest
from conftest import COLUMNS, measured
from pvlib.location import Location

from pvlib_fem import Loop, close_loop, datasets, ewm, fit_fem, rank_effects, simulator
from pvlib_fem._fit import fit_frame
from pvlib_fem._record.inputs import as_record
from pvlib_fem.quality._lag import coarse_lag
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._module_lag import clock_shift
from pvlib_fem.quality._onset import DAY
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


@pytest.mark.parametrize("seed", [1, 2])
def test_a_change_of_an_hour_within_a_block_is_no_drift(seed):
    """By rows of 15 min a block of days before and after it has a time in between."""
    found = clock(
        PHYSICS | {"sky_radiation": 1.0, "dst": 1.0}, 200, 900.0, seed, "2023-01-01"
    )
    assert {*found.faults} == {"dst"}
    ((day, by),) = found.jumps
    assert by == 3600 and abs(day - pd.Timestamp("2023-03-26", tz=day.tz)).days < 14


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
    assert not found.late_at(record.inputs.seconds).any()


def test_rows_that_are_lost_and_a_sensor_that_stood_still_do_no_harm():
    found = clock(OUTDOORS | {"missing": 5.0, "stuck": 3.0, "clock_shift": 3.0})
    assert found.late / 60 == pytest.approx(3.0, abs=0.35)


def test_the_zone_of_the_index_does_not_matter():
    data = simulator.record(ALBUQUERQUE, OUTDOORS, 20, 60.0, 1)
    here, there = (clock_shift(checked(d)) for d in (data, data.tz_convert("UTC")))
    assert here.late == pytest.approx(there.late, abs=1.0)


def test_a_loop_corrects_the_clock_of_the_same_instants_in_any_zone():
    """Clocks of all columns and of the module alone, and the day of a change."""
    data = simulator.record(RHINE, OUTDOORS, 120, 900.0, 3, start="2023-04-01")
    data = data[list(COLUMNS)]
    data["temp_module"] = data["temp_module"].shift(3)
    ahead = data.index + pd.to_timedelta(3600 * (np.arange(len(data)) > 6000), unit="s")
    data = data.set_axis(ahead)[~ahead.duplicated()].iloc[3:]
    place = Location(RHINE.latitude, RHINE.longitude, tz=RHINE.tz)
    loop = close_loop(data, location=place)
    assert {one.fault for one in loop.corrections if one.applied} == {
        "clock_shift",
        "file_jump",
    }
    for method in (loop.predict, loop.residual, loop.contributions):
        found = method(data)
        local = method(data.tz_localize(None))  # by the record's own clock
        assert np.array_equal(local, found, equal_nan=True)
        for zone in ("UTC", "Asia/Kathmandu", "Europe/Berlin"):
            other = method(data.tz_convert(zone))
            assert str(other.index.tz) == zone
            pd.testing.assert_index_equal(other.index, found.index.tz_convert(zone))
            assert np.array_equal(other, found, equal_nan=True)


def test_a_zone_that_the_record_has_not_leaves_its_clock_and_says_so():
    data = simulator.record(RHINE, OUTDOORS, 60, 900.0, 3, start="2023-04-01")
    data = data[list(COLUMNS)].tz_localize(None)
    data["temp_module"] = data["temp_module"].shift(3)
    loop = close_loop(data.iloc[3:])
    assert [one.fault for one in loop.corrections if one.applied] == ["clock_shift"]
    with pytest.warns(UserWarning, match=r"data are in UTC and the record .* no zone"):
        loop.residual(data.tz_localize("UTC"))
    loop.residual(data.tz_localize("UTC"), correct_times=False)  # without a warning


def test_the_measured_week_has_a_right_clock(week):
    """The prototype of this test found its onset at 0 to 1 min."""
    found = clock_shift(checked(week))
    assert not found.fault
    assert abs(found.late) < 60


@pytest.mark.parametrize(
    ("days", "step", "reason"),
    [
        (1, "1min", "the record is shorter than two days"),
        (20, "2h", "rows are 120 min apart, longer than a response"),
    ],
)
def test_what_cannot_be_told_is_not_told(days, step, reason):
    data = simulator.record(RHINE, PHYSICS, days, 60.0, 7, start="2023-05-01")
    found = clock_shift(checked(data.resample(step).mean()))
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


# hours


def late_by(data, hours):
    """The record with the module's column written so much later."""
    rows = round(hours * pd.Timedelta("1h") / (data.index[1] - data.index[0]))
    return data.assign(temp_module=data["temp_module"].shift(rows))


def rows_of(data, step, held="means"):
    """Rows as loggers hold them: means, the ends of steps, or one of each."""
    mean = data.resample(step, closed="right", label="right").mean()
    end = data.reindex(mean.index)
    if held == "means":
        return mean
    return end if held == "ends" else mean.assign(temp_module=end["temp_module"])


def lag_of(data):
    columns = (data[n].to_numpy() for n in ("poa_global", "temp_air", "temp_module"))
    seconds = (data.index - data.index[0]).total_seconds().to_numpy()
    return coarse_lag(seconds, *columns, Limits())


@pytest.fixture(scope="module")
def sites():
    """A month of each hemisphere in its summer and winter, some with a slow roof."""
    roof = OUTDOORS | {"thermal_storage": 3.0}
    south = simulator.Site(-34.0, 151.0, surface_azimuth=0.0)
    return [
        simulator.record(site, effects, 30, 300.0, seed, start=start)
        for seed, (site, effects, start) in enumerate(
            [
                (RHINE, OUTDOORS, "2023-12-01"),
                (RHINE, roof, "2023-06-01"),
                (ALBUQUERQUE, PHYSICS, "2023-03-01"),
                (south, roof, "2023-06-01"),
                (south, OUTDOORS, "2023-12-01"),
            ]
        )
    ]


@pytest.mark.parametrize("held", ["means", "ends", "one of each"])
@pytest.mark.parametrize("step", ["15min", "30min", "1h"])
def test_hours_are_found_by_coarse_rows(sites, step, held):
    for data in sites:
        rows = rows_of(data, step, held)
        assert lag_of(rows).late == 0
        for hours in (-11, -7, -2, 3, 7, 12):
            assert lag_of(late_by(rows, hours)).late / 3600 == hours


def test_a_slow_roof_of_hours_is_no_clock(sites):
    """Its time constant is as long as a row, which is all it can hide among hours."""
    for data in sites:
        over = data["temp_module"] - data["temp_air"]
        slow = data["temp_air"] + ewm(over.to_numpy(), 3600.0, step=300)
        rows = rows_of(data.assign(temp_module=slow), "1h")
        assert lag_of(rows).late == 0
        assert abs(lag_of(late_by(rows, 7)).late - 7 * 3600) <= 3600


@pytest.mark.parametrize("step", [300.0, 3600.0])
@pytest.mark.parametrize("hours", [7, -5])
def test_a_clock_that_is_off_by_hours_is_told_and_corrected(hours, step):
    data = simulator.record(RHINE, OUTDOORS, 30, step, 7, start="2023-05-01")
    record = as_record(*(late_by(data, hours)[name] for name in COLUMNS))
    found = clock_shift(record)
    assert list(found.faults) == ["clock_shift"]
    assert found.late / 3600 == pytest.approx(hours, abs=0.1)
    back = found.corrected(record.inputs.seconds, record["temp_module"])
    middle = slice(round(86400 / step), -round(86400 / step))
    error = back[middle] - data["temp_module"].to_numpy()[middle]
    assert np.std(error) < 0.5


def test_a_logger_in_summer_time_is_found_by_rows_of_an_hour():
    effects = OUTDOORS | {"dst": 1.0}
    data = simulator.record(RHINE, effects, 365, 1800.0, 4, start="2023-01-01")
    record = checked(rows_of(data, "1h"))
    found = clock_shift(record)
    assert list(found.faults) == ["dst"]
    for (day, by), (date, due) in zip(
        found.jumps, [("2023-03-26", 3600.0), ("2023-10-29", -3600.0)], strict=True
    ):
        assert abs(day.tz_localize(None) - pd.Timestamp(date)) <= pd.Timedelta("2D")
        assert by == due
    winter, summer = found.late_at(record.inputs.seconds[[500, 4500]])
    assert (winter, summer) == (0.0, 3600.0)


def test_a_module_that_does_not_follow_the_light_has_no_clock(sites):
    data = rows_of(sites[0], "1h")
    noise = np.random.default_rng(0).normal(20.0, 5.0, len(data))
    assert lag_of(data.assign(temp_module=noise)).late == 0


def test_hours_are_found_before_units_are_judged(sites):
    """7 h late looks like °F, in which over-temperature is large and negative."""
    data = late_by(rows_of(sites[4], "1h"), 7)
    columns = [data[name] for name in COLUMNS]
    with pytest.raises(
        ValueError, match="temp_module run 7 h ahead of those of poa_global"
    ):
        fit_fem(*columns)
    (clock,) = close_loop(data[list(COLUMNS)]).corrections
    assert clock.applied and clock.fault == "clock_shift"
    assert clock.values == {"late": 7 * 60.0}
    assert clock.after < 0.3 * clock.before
    hot = data.assign(temp_module=1.8 * data["temp_module"] + 32.0)
    with pytest.raises(ValueError, match="to be in °F"):
        close_loop(hot[list(COLUMNS)])


def test_a_second_irradiance_by_another_clock_is_noted(sites):
    data = rows_of(sites[4], "1h")[list(COLUMNS)]
    for hours, noted in ((0, 0), (1, 1)):
        other = data.assign(poa_global_2=0.9 * data["poa_global"].shift(hours))
        notes = close_loop(other, effects=[]).notes
        lines = [n for n in notes if n.startswith("timestamps of poa_global_2 run ")]
        assert len(lines) == noted


def test_the_measured_week_has_a_right_clock_by_any_rows(week):
    for step in ("15min", "30min", "1h"):
        rows = rows_of(week, step)
        assert lag_of(rows).late == 0
        assert lag_of(late_by(rows, 7)).late == 7 * 3600


@pytest.fixture(scope="module")
def ten_minutes():
    """Values, with a reflection at high angles that only the sun's position shows."""
    effects = PHYSICS | {"sky_radiation": 1.0, "incidence_angle": 3.0}
    return simulator.record(RHINE, effects, 120, 600.0, 0, start="2023-03-01")


@pytest.mark.parametrize("name, label", [("left", -0.5), (None, 0.0), ("right", 0.5)])
def test_the_sun_is_in_the_middle_of_a_mean_however_it_is_labelled(
    ten_minutes, name, label, tmp_path
):
    site = ten_minutes.attrs["site"]
    plane = {n: site[n] for n in ("surface_tilt", "surface_azimuth")}
    place = {"location": Location(site["latitude"], site["longitude"]), **plane}
    hours = ten_minutes.resample("1h", label=name or "left").mean()
    if name is None:
        hours = hours.set_axis(hours.index + pd.Timedelta(minutes=30))
    loop = close_loop(hours, effects=["sky_radiation", "incidence_angle"], **place)
    assert loop.label == label
    assert any("the sun is taken half a step" in n for n in loop.notes) == bool(label)
    assert loop.effects == ["sky_radiation", "incidence_angle"]
    # by the begin of each hour it is 0.635 K, by its end 0.737 K without the effect
    assert loop.table.loc[loop.last, "rmse_test"] < 0.61
    loop.to_json(tmp_path / "loop.json")
    read = Loop.from_json(tmp_path / "loop.json")
    pd.testing.assert_series_equal(read.predict(hours), loop.predict(hours))


def test_fits_and_rankings_have_the_sun_in_the_middle_of_means(ten_minutes):
    site = ten_minutes.attrs["site"]
    place = {n: site[n] for n in ("surface_tilt", "surface_azimuth")}
    place["location"] = Location(site["latitude"], site["longitude"])
    found = {}
    for name in ("begin", "middle", "end"):
        hours = ten_minutes[list(COLUMNS)].resample("1h").mean()
        half = pd.Timedelta(minutes=30) * ("begin", "middle", "end").index(name)
        hours = hours.set_axis(hours.index + half)
        fit = fit_frame(hours, "poa_misalignment", model="faiman", **place)
        plain = fit_fem(hours, model="faiman")
        ranking = rank_effects(plain, hours, **place)
        told = [*fit.notes, *ranking.attrs["notes"]]
        assert sum("the sun is taken half a step" in n for n in told) == (
            0 if name == "middle" else 2
        )
        found[name] = {**fit.coefficients, "gain": ranking["gain"]["incidence_angle"]}
    for other in ("begin", "end"):
        assert found[other] == pytest.approx(found["middle"], rel=1e-6)
    assert found["middle"]["gain"] > 0.2


def test_shorter_steps_have_the_sun_of_their_times(ten_minutes):
    site = ten_minutes.attrs["site"]
    place = Location(site["latitude"], site["longitude"])
    late = ten_minutes.set_axis(ten_minutes.index + pd.Timedelta(minutes=2))
    for data, wanted in ((late, 0.0), (late.shift(freq="3min"), 0.5)):
        loop = close_loop(data, location=place, effects=[])
        assert loop.label == wanted
