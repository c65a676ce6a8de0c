"""The memory of a fit: found at any step, and said where the step hides it."""

import numpy as np
import pytest
from conftest import COLUMNS, DRIVERS
from hypothesis import given, strategies as st

import pvlib_fem as fem
from pvlib_fem import datasets, scores
from pvlib_fem._fitting.time_constant import Lag

FAIMAN = dict(u0=24.57, u1=8.51, bias=-4.88)
MEMORIES = {"ewm": dict(tau=346.0), "balance": dict(capacity=14e3)}
R_EQ = 1.0 / (24.57 + 8.51 * 3.0)  # at the mean wind of made-up records
both = pytest.mark.parametrize("dynamics", MEMORIES)


def made(dynamics, step, seed=2, days=120, **changes):
    coefficients = {**FAIMAN, **MEMORIES[dynamics], **changes}
    return datasets.synthetic(
        days, step, "2023-04-03", seed, dynamics=dynamics, **coefficients
    )


def fitted(data, dynamics):
    return fem.fit_fem(*(data[n] for n in COLUMNS), model="faiman", dynamics=dynamics)


@both
@pytest.mark.parametrize("step", [600, 900, 1800])
@pytest.mark.parametrize("seed", range(3))
def test_no_fit_is_worse_than_the_truth_on_long_steps(dynamics, step, seed):
    """A search in tau itself gets stuck there, where the past has no weight."""
    data = made(dynamics, step, seed)
    fit = fitted(data, dynamics)
    function = fem.heat_balance if dynamics == "balance" else fem.fem_temperature
    truth = function(
        *(data[n] for n in DRIVERS), model="faiman", **data.attrs["coefficients"]
    )
    rows = ~fit.holdout & fem.paper.daytime(*(data[n] for n in COLUMNS))
    error = scores.rmse(data["temp_module"][rows], truth[rows])
    assert fit.converged
    assert fit.scores["rmse_train"].iloc[-1] <= error * (1.0 + 1e-6)


def test_a_memory_comes_back_from_fifteen_minutes():
    fit = fitted(made("ewm", 900), "ewm")
    interval = fit.confidence_interval(0.999)
    for name, value in {**FAIMAN, "tau": 346.0}.items():
        assert interval["lower"][name] < value < interval["upper"][name], name


@both
def test_a_memory_that_the_step_hides_is_said(dynamics):
    """A time constant of a twentieth of the step leaves e^-20 of the past."""
    name = {"ewm": "tau", "balance": "capacity"}[dynamics]
    hidden = {"ewm": 90.0, "balance": 90.0 / R_EQ}[dynamics]
    fit = fitted(made(dynamics, 1800, days=40, **{name: hidden}), dynamics)
    (note,) = [n for n in fit.notes if "is not known from steps of 1800 s" in n]
    assert note.startswith(name) and f"fixed={{'{name}': ...}}" in note
    held = {name: hidden}
    data = made(dynamics, 1800, days=40, **held)
    columns = [data[n] for n in COLUMNS]
    fit = fem.fit_fem(*columns, model="faiman", dynamics=dynamics, fixed=held)
    assert not any("not known" in note for note in fit.notes)


@both
@pytest.mark.parametrize("step", [300, 900])
def test_means_over_long_steps_have_the_memory_that_the_note_says(dynamics, step):
    """The mean age of the past in a mean is tau itself, at any step."""
    data = made(dynamics, 60, days=60)
    means = data.resample(f"{step}s", label="right", closed="right").mean()
    (note,) = fitted(means, dynamics).notes
    said = float(note.split("is about ")[1].split()[0].replace(",", ""))
    (truth,) = MEMORIES[dynamics].values()
    assert said == pytest.approx(truth, rel=0.15)
    assert fitted(means, dynamics).coefficients[note.split()[0]] > 1.3 * truth


@both
@pytest.mark.parametrize("step", [300, 900])
def test_instantaneous_values_have_at_most_the_memory_that_the_note_says(
    dynamics, step
):
    """They lead the means before them, which the fit makes up for by its memory."""
    data = made(dynamics, 60, days=60)
    fit = fitted(data.iloc[:: step // 60], dynamics)
    (note,) = fit.notes
    assert note.endswith("and at most that if all are instantaneous values")
    said = float(note.split("is about ")[1].split()[0].replace(",", ""))
    (truth,) = MEMORIES[dynamics].values()
    assert truth < said < fit.coefficients[note.split()[0]]


@both
def test_short_steps_have_no_note(dynamics):
    assert fitted(made(dynamics, 60, days=14), dynamics).notes == ()


@given(st.floats(1.0, 3600.0), st.floats(0.06, 100.0))
def test_a_lag_is_a_memory(step, share):
    seen = Lag(step, 0.0)
    memory = share * step
    age = seen.to_search(memory)
    assert seen.from_search(age) == pytest.approx(memory, rel=1e-9)
    change = 1e-6 * age
    above, below = seen.from_search(age + change), seen.from_search(age - change)
    slope = (above - below) / (2 * change)
    assert seen.slope(age) == pytest.approx(slope, rel=1e-5)
    # a thousand steps with that memory hold a mean age of as much
    k = np.arange(10_000)
    decay = np.exp(-1.0 / share)
    weights = (1.0 - decay) * decay**k
    assert age == pytest.approx((k * step * weights).sum(), rel=1e-9)


def test_the_step_of_a_record_is_the_usual_one():
    data = made("ewm", 900, days=20)
    data = data.drop(data.index[[5, 6, 300]])
    fit = fitted(data, "ewm")
    assert fit.record.inputs.step == 900.0


def test_the_least_memory_is_that_of_the_resistance_that_is_found():
    """A search that starts at another resistance came to rest at its bound."""
    data = fem.datasets.synthetic(10, 600, seed=5, noise=0)
    usual = [data[n] for n in ("poa_global", "temp_air", "wind_speed")]
    own = {"k": 1 / 64, "d": 3.0, "capacity": 200.0 * 64 * np.e, "bias": -3.0}
    module = fem.heat_balance(*usual, model="wm1", **own)
    fit = fem.fit_fem(
        *usual, module, model="wm1", dynamics="balance", check_units=False
    )
    assert fit.at_bound == ()
    assert fit.coefficients == pytest.approx(own, rel=1e-6)
