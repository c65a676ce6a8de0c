"""Scores in K and in energy, and the delayed sensor."""

from dataclasses import astuple

import numpy as np
import pandas as pd
import pytest
from conftest import COLUMNS

from pvlib_fem import paper, scores


def test_the_bias_is_what_has_to_be_added():
    """The paper's MBE is measured minus modelled."""
    measured, modelled = np.array([20.0, 30.0, np.nan]), np.array([22.0, 33.0, 9.0])
    assert scores.mbe(measured, modelled) == -2.5
    assert scores.mbe(measured, modelled - 2.5) == 0.0
    assert scores.mae(measured, modelled) == 2.5
    assert scores.rmse(measured, modelled) == np.sqrt((4 + 9) / 2)


def test_without_a_pair_there_is_no_score():
    assert np.isnan(scores.rmse([np.nan], [1.0]))


def test_the_papers_energy_example_adds_up():
    """KUL Ghent at 1 s: 1.96 over and -2.13 under make 4.09 kWh/kWp in all,
    -0.17 net and 0.39 points of PR; so its year had 1049 kWh/m²."""
    error = scores.EnergyError(1.96 + 2.13, 1.96, -2.13, insolation=4.09 / 0.0039)
    assert error.total == pytest.approx(4.09)
    assert error.net == pytest.approx(-0.17)
    assert error.performance_ratio == pytest.approx(0.39)
    # Eq. PR estimation: MAE x gamma, with the MAE of WM1 at that site
    assert pytest.approx(0.39, abs=0.005) == 1.12 * -scores.GAMMA * 100


def test_energy_error_takes_the_side_of_each_sample():
    """An hour at 1000 W/m², 2 K too cold: 1 kWh/m² x 0.7 % over-estimated."""
    times = pd.date_range("2024-05-01 12:00", periods=120, freq="1min")
    sun = pd.Series(1000.0, times)
    measured = pd.Series(50.0, times)
    modelled = measured + np.where(np.arange(120) < 60, -2.0, 3.0)
    error = scores.energy_error(sun, measured, modelled)
    assert error.over_estimate == pytest.approx(0.007)
    assert error.under_estimate == pytest.approx(-0.0105)
    assert error.total == pytest.approx(0.0175)
    assert error.net == pytest.approx(-0.0035)
    assert error.insolation == pytest.approx(2.0)
    assert error.performance_ratio == pytest.approx(0.875)
    arrays = [column.to_numpy() for column in (sun, measured, modelled)]
    alone = scores.energy_error(*arrays, step=60)
    assert astuple(alone) == pytest.approx(astuple(error), rel=1e-12)


def test_energy_error_leaves_out_what_was_not_measured():
    times = pd.date_range("2024-05-01 12:00", periods=60, freq="1min")
    sun = pd.Series(1000.0, times)
    measured = pd.Series(50.0, times).where(np.arange(60) < 30)
    error = scores.energy_error(sun, measured, pd.Series(52.0, times))
    assert error.insolation == pytest.approx(0.5)
    assert error.under_estimate == pytest.approx(-0.0035)


def test_arrays_need_a_step_and_series_one_index():
    with pytest.raises(ValueError, match="give step in seconds"):
        scores.energy_error(np.ones(3), np.ones(3), np.ones(3))
    one = pd.Series([1.0, 2.0], pd.date_range("2024-05-01", periods=2, freq="1min"))
    other = one.shift(freq="1min")
    with pytest.raises(ValueError, match="different indexes"):
        scores.rmse(one, other)
    with pytest.raises(ValueError, match="different indexes"):
        scores.energy_error(one, other, other)


MINUTES = pd.date_range("2024-05-01", periods=4, freq="1min")
SENSOR = pd.Series([20.0, 21.0, 23.0, 22.0], MINUTES)
ALONE = pd.Series([20.0], pd.DatetimeIndex(["2024-05-01"]))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: scores.rmse(SENSOR.to_frame(), SENSOR), "measured has 2 dimensions"),
        (lambda: scores.mae(SENSOR, SENSOR.to_frame()), "modelled has 2 dimensions"),
        (lambda: scores.mbe(np.ones(3), np.ones(1)), "the lengths differ"),
        (lambda: scores.rmse([1.0, np.inf], [1.0, 2.0]), "measured is infinite at row"),
        (lambda: scores.rmse(1.0, SENSOR * np.inf), "modelled is infinite at 2024-05"),
        (lambda: scores.energy_error(SENSOR[::-1], 1.0, SENSOR[::-1]), "not sorted"),
        (
            lambda: scores.energy_error(SENSOR.iloc[[0, 1, 1, 2]], 20.0, 21.0),
            "has the time 2024-05-01 00:01:00 twice",
        ),
        (lambda: scores.energy_error([1.0], [2.0], [3.0], step=-60), "positive number"),
        (lambda: scores.energy_error(SENSOR, 2.0, 3.0, step=60), "drop step"),
        (lambda: scores.delayed_sensor(SENSOR, [30]), "30 s are no whole steps of 60"),
        (lambda: scores.delayed_sensor(SENSOR, [60, 90]), "delays of 90 s are no"),
        (lambda: scores.delayed_sensor(SENSOR[::-1]), "not sorted"),
        (lambda: scores.delayed_sensor(ALONE), "no whole steps of"),
    ],
)
def test_what_is_no_pair_of_temperatures_is_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_a_masked_value_is_one_that_is_missing():
    masked = np.ma.masked_array([20.0, -999.0, 23.0, 22.0], [0, 1, 0, 0])
    assert scores.rmse(masked, SENSOR.to_numpy()) == 0.0
    whole = scores.energy_error([500] * 4, SENSOR, 25.0, step=None)
    error = scores.energy_error([500] * 4, masked, 25.0, step=60)
    assert error.insolation == pytest.approx(0.75 * whole.insolation)


def test_by_default_a_sensor_is_late_by_whole_steps():
    table = scores.delayed_sensor(
        SENSOR.set_axis(MINUTES[0] + 2 * (MINUTES - MINUTES[0]))
    )
    assert table.index.tolist() == [120, 240, 360, 480, 600]
    assert table["points"].tolist() == [3, 2, 1, 0, 0]


def test_a_late_sensor_on_a_ramp_is_off_by_the_slope_times_the_delay():
    times = pd.date_range("2024-05-01", periods=600, freq="10s")
    ramp = pd.Series(0.05 * 10 * np.arange(600), times)  # 0.05 K/s
    table = scores.delayed_sensor(ramp, delays=[0, 60, 600])
    assert table["rmse"].tolist() == pytest.approx([0.0, 3.0, 30.0])
    assert table["mae"].tolist() == pytest.approx([0.0, 3.0, 30.0])
    assert table["points"].tolist() == [600, 594, 540]


def test_a_delay_far_below_a_step_is_not_none():
    """At 15 min, 1 min late was an error of 0 K."""
    times = pd.date_range("2024-05-01", periods=100, freq="15min")
    ramp = pd.Series(np.arange(100.0), times)
    with pytest.raises(ValueError, match="delays of 60 s are no whole steps of 900 s"):
        scores.delayed_sensor(ramp, delays=[0, 60, 900])
    with pytest.raises(ValueError, match=r"delays of 60, 120, .* are no whole steps"):
        scores.delayed_sensor(ramp)
    five = scores.delayed_sensor(
        ramp.set_axis(times[0] + 300 * (times - times[0]) / 900)
    )
    assert five.index.tolist() == [300, 600]


def test_the_delayed_sensor_needs_times():
    with pytest.raises(ValueError, match="no DatetimeIndex"):
        scores.delayed_sensor(pd.Series([1.0, 2.0]))


def test_on_the_measured_week_a_delay_costs_kelvins(week):
    """The yardstick of the paper's last figure: it grows with the delay."""
    table = scores.delayed_sensor(week["temp_module"])
    assert table["rmse"].is_monotonic_increasing
    assert 0.3 < table.loc[60, "rmse"] < 1.0


def test_a_late_sensor_is_compared_on_the_rows_that_are_asked_for(week):
    """Five minutes late: 1.10 K on all rows of the measured week, 1.59 K by day."""
    record = [week[name] for name in COLUMNS]
    module, day = record[3], paper.daytime(*record)
    everything = scores.delayed_sensor(module, [300]).loc[300]
    by_day = scores.delayed_sensor(module, [300], day).loc[300]
    assert everything["rmse"] == pytest.approx(1.10, abs=0.005)
    assert by_day["rmse"] == pytest.approx(1.59, abs=0.005)
    late = module.shift(5)[day]
    assert by_day["mae"] == pytest.approx(scores.mae(module[day], late))
    assert by_day["points"] == (module[day].notna() & late.notna()).sum()
    with pytest.raises(ValueError, match="lengths differ"):
        scores.delayed_sensor(module, [300], day.iloc[:-1])
