"""A wind speed in coarse steps: what it does to coefficients is in their errors."""

import numpy as np
import pytest
from scipy.stats import t as student

import pvlib_fem as fem
from pvlib_fem import datasets
from pvlib_fem._fitting.daily import standard_errors

HOW = {"model": "faiman", "dynamics": "balance"}
NOTE = "wind_speed is recorded in steps of 1 m/s, which may move u0 by "


def rounded(data, step):
    return data.assign(wind_speed=(data["wind_speed"] / step).round() * step)


def without(fit):
    """Standard errors by the spread between days alone."""
    return standard_errors(fit.thermal_model, fit.daily, fit.at_bound, [])


def test_intervals_hold_the_truth_though_wind_is_in_whole_metres_per_second():
    """Of 24 intervals of 90 %, fewer than 19 hold it in one case of a hundred."""
    held, narrow = 0, 0
    for seed in range(12):
        data = rounded(datasets.synthetic(30, 600, seed=seed, noise=1.0), 1.0)
        fit = fem.fit_fem(data, **HOW)
        assert sum(note.startswith(NOTE) for note in fit.notes) == 1
        reach = student.ppf(0.95, fit.train_days - 1)
        for name, truth in (("u0", 25.0), ("u1", 6.84)):
            off = abs(fit.coefficients[name] - truth)
            held += off <= reach * fit.stderr[name]
            narrow += off <= reach * without(fit)[name]
    assert held >= 19 > narrow


@pytest.mark.parametrize("step", [0.0, 0.1])
def test_fine_steps_change_no_error(step):
    data = datasets.synthetic(20, 600, seed=2)
    fit = fem.fit_fem(rounded(data, step) if step else data, **HOW)
    assert fit.stderr == without(fit)
    assert not any("recorded in steps" in note for note in fit.notes)


def test_a_few_finer_values_hide_no_step():
    data = rounded(datasets.synthetic(20, 600, seed=2), 1.0)
    plain = fem.fit_fem(data, **HOW)
    data.iloc[100, data.columns.get_loc("wind_speed")] += 0.3
    filled = fem.fit_fem(data, **HOW)
    assert any(note.startswith(NOTE) for note in filled.notes)
    assert filled.stderr == pytest.approx(plain.stderr, rel=0.02)


def test_a_model_without_wind_has_no_error_of_it():
    data = rounded(datasets.synthetic(20, 600, seed=2), 1.0)
    fit = fem.fit_fem(data, model="ross")
    assert fit.stderr == without(fit)


def test_held_coefficients_stay_without_error():
    data = rounded(datasets.synthetic(20, 600, seed=2), 1.0)
    fit = fem.fit_fem(data, **HOW, fixed={"u1": 6.84})
    assert fit.stderr["u1"] == 0.0
    assert fit.stderr["u0"] > without(fit)["u0"]


def test_files_have_the_errors_of_their_rows(tmp_path):
    data = rounded(datasets.synthetic(20, 600, seed=2), 1.0)
    data.to_parquet(tmp_path / "record.parquet")
    files = fem.fit_fem(tmp_path, **HOW)
    frame = fem.fit_fem(data, **HOW)
    assert files.stderr == pytest.approx(frame.stderr, rel=1e-5)
    assert [*files.notes] == [*frame.notes]


def test_a_loop_has_them_too():
    data = fem.simulator.record(effects=fem.simulator.PHYSICS, days=70, step=900)
    usual = ["poa_global", "temp_air", "wind_speed", "temp_module"]
    fit = fem.close_loop(rounded(data[usual], 1.0)).fit
    assert any(note.startswith(NOTE) for note in fit.notes)
    assert np.all([fit.stderr[n] > without(fit)[n] for n in ("u0", "u1")])
