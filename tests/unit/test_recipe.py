"""The paper's recipe: its estimates, its offset, and values that it refuses."""

import numpy as np
import pandas as pd
import pytest
from conftest import COLUMNS

import pvlib_fem as fem
from pvlib_fem import datasets, paper
from pvlib_fem.paper._recipe import MODELS, filter_coefficients, standard_coefficients

models = pytest.mark.parametrize("model", MODELS)


@pytest.fixture(scope="module")
def fortnight():
    """Faiman's module at 5 min whose own offset is zero; drivers and module."""
    data = datasets.synthetic(
        14, 300, seed=2, noise=0, u0=25.0, u1=6.84, capacity=9e3, bias=0.0
    )
    return tuple(data[name] for name in COLUMNS)


@models
def test_the_papers_recipe(month, model):
    """Its estimators, called alone, give the fit's numbers; its bias is the MBE."""
    record = tuple(month[name] for name in COLUMNS)
    fit = fem.fit_fem(*record, model=model, method="paper", calm_wind=1.0)
    kept = tuple(column[~fit.holdout] for column in record)
    train = tuple(column[paper.daytime(*kept)] for column in kept)
    offset = paper.night_bias(*kept).value
    k = paper.r_eq_max(*train, calm_wind=1.0, intercept=False, offset=offset).value
    assert fit.coefficients["tau"] == paper.time_constant(*train, k).value
    estimates = filter_coefficients(model, train, 1.0, offset)
    assert estimates
    for name, estimate in estimates.items():
        assert fit.coefficients[name] == estimate.value
    assert fit.scores.loc["fem", "mbe_train"] == pytest.approx(0, abs=1e-9)
    assert fit.coefficients["bias"] == pytest.approx(fit.scores.loc["ewm", "mbe_train"])
    assert np.isnan(list(fit.stderr.values())).all()
    assert any("decreases as the true time" in note for note in fit.notes)
    assert f"over-temperature less its mean by night, {offset:.2f} K" in fit.notes


# the measured week, every other day held out, calm air below 1 m/s. RMSE [K]
WEEK = {
    "wm1": {None: 2.68, "calm": 1.77, "night": 1.92},
    "sapm": {None: 3.74, "calm": 1.73, "night": 1.51},
    "faiman": {None: 6.24, "calm": 1.61, "night": 1.49},
    "wm2": {"calm": 1.59, "night": 1.89},
}


@pytest.mark.parametrize("model", WEEK)
def test_what_the_offset_is_worth_in_the_measured_week(week, model):
    record = tuple(week[name] for name in COLUMNS)
    for offset, expected in WEEK[model].items():
        fit = fem.fit_fem(
            *record, model=model, method="paper", calm_wind=1.0, offset=offset
        )
        assert fit.scores.loc["fem", "rmse_test"] == pytest.approx(expected, abs=0.006)


def test_wm2_that_its_own_function_would_refuse_is_no_result(week):
    record = tuple(week[name] for name in COLUMNS)
    with pytest.raises(ValueError, match=r"regressions give no model: wm2: k_w = 0.00"):
        fem.fit_fem(*record, model="wm2", method="paper", calm_wind=1.0, offset=None)


@models
@pytest.mark.parametrize("offset", [-4.0, 2.5])
def test_a_sensors_offset_changes_the_bias_and_nothing_else(fortnight, model, offset):
    """By both offsets that are found; neither k nor d takes a part of it."""
    *drivers, module = fortnight
    plain, moved = (
        tuple(c[paper.daytime(*r)] for c in r)
        for r in (fortnight, (*drivers, module + offset))
    )
    for find in (paper.night_bias, calm_intercept):
        inner, outer = (
            filter_coefficients(model, rows, 1.0, find(*record).value)
            for rows, record in (
                (plain, fortnight),
                (moved, (*drivers, module + offset)),
            )
        )
        assert inner
        for name, estimate in inner.items():
            assert outer[name].value == pytest.approx(estimate.value, rel=1e-6)


def calm_intercept(*record):
    rows = tuple(column[paper.daytime(*record)] for column in record)
    return paper.Estimate(paper.r_eq_max(*rows, calm_wind=1.0).intercept, "K", 0)


def test_an_offset_that_is_known_is_taken_off(fortnight):
    *drivers, module = fortnight
    known = fem.fit_fem(
        *drivers, module - 3.0, method="paper", calm_wind=1.0, offset=-3.0
    )
    plain = fem.fit_fem(*fortnight, method="paper", calm_wind=1.0, offset=0.0)
    for name in ("k", "d", "tau"):
        assert known.coefficients[name] == pytest.approx(plain.coefficients[name])
    assert known.coefficients["bias"] == pytest.approx(plain.coefficients["bias"] - 3)


def test_faimans_outlier_is_replaced_in_plain_words_and_counts_no_points():
    """Where wind does not cool, u1 is Faiman's; u0 stays the record's own."""
    random = np.random.default_rng(0)
    index = pd.date_range("2023-06-01", periods=2000, freq="5min")
    sun = pd.Series(random.uniform(300, 900, 2000), index)
    wind = pd.Series(random.uniform(0, 8, 2000), index)
    air = 0.0 * sun + 20.0
    found = filter_coefficients(
        "faiman", (sun, air, wind, air + sun * 0.03 * (1 + wind / 50))
    )
    assert (found["u1"].value, found["u1"].points) == (6.84, 0)
    assert found["u0"].points == 2000 and not found["u0"].note
    assert "u1 is Faiman's own 6.84" in found["u1"].note
    assert f"the regression of {found['u0'].points} points gives -" in found["u1"].note


def test_the_fit_passes_on_what_was_replaced(fortnight):
    poa, air, wind, module = fortnight
    warm = air + (module - air) * (1.0 + wind / 3.0)
    fit = fem.fit_fem(poa, air, wind, warm, model="faiman", method="paper", calm_wind=1)
    assert fit.coefficients["u1"] == 6.84
    assert any(note.startswith("filter: u1 is Faiman's own") for note in fit.notes)
    assert any("u1 0," in note for note in fit.notes)


def test_a_record_without_nights_takes_the_calm_lines_intercept(fortnight):
    day = paper.daytime(*fortnight)
    record = tuple(column[day] for column in fortnight)
    fit = fem.fit_fem(*record, method="paper", calm_wind=1.0)
    assert any("fewer than 20 night rows" in note for note in fit.notes)
    assert any("the calm line's intercept" in note for note in fit.notes)
    with pytest.raises(ValueError, match="the bias at night needs 20 rows and has 0"):
        paper.night_bias(*record)


@pytest.mark.parametrize("offset", ["dawn", np.nan])
def test_an_unknown_offset_is_refused(fortnight, offset):
    with pytest.raises(ValueError, match=r"unknown offset .* night, calm, a number"):
        fem.fit_fem(*fortnight, method="paper", calm_wind=1.0, offset=offset)


def test_the_standard_reading_makes_wm1_the_sandia_model(month):
    """Which the paper's tables contradict: 3.29 against 3.04 K."""
    record = tuple(month[name] for name in COLUMNS)
    wm1, sapm = (standard_coefficients(model, record) for model in ("wm1", "sapm"))
    assert np.log(wm1["k"].value) == pytest.approx(sapm["a"].value)
    assert -1.0 / wm1["d"].value == pytest.approx(sapm["b"].value)


def test_the_lines_through_calm_air_hang_together(fortnight):
    """A line with an intercept is the one through the origin once that is off."""
    line = paper.r_eq_max(*fortnight, calm_wind=1.0)
    through = paper.r_eq_max(
        *fortnight, calm_wind=1.0, intercept=False, offset=line.intercept
    )
    assert through.value == pytest.approx(line.value, rel=1e-9)
    assert through.intercept == pytest.approx(line.intercept)


@models
def test_what_the_recipe_returns_fem_temperature_takes(fortnight, model):
    """Of modules that wind heats, or cools below the air, too; or it is refused."""
    poa, air, wind, _ = fortnight
    random, returned = np.random.default_rng(3), 0
    for _ in range(8):
        calm, slope = random.uniform(0.015, 0.05), random.uniform(-0.006, 0.004)
        error = random.normal(0.0, 1.0, len(poa)) + random.uniform(-6, 3)
        module = air + fem.ewm(poa, 300.0) * (calm + slope * wind.clip(upper=9)) + error
        for offset in ("night", "calm", None):
            how = dict(model=model, method="paper", calm_wind=1.5, offset=offset)
            try:
                fit = fem.fit_fem(poa, air, wind, module, check_units=False, **how)
            except ValueError:
                continue
            answer = fem.fem_temperature(
                poa, air, wind, model=model, **fit.coefficients
            )
            assert np.isfinite(answer).all()
            fit.predict(poa, air, wind)
            returned += 1
    assert returned >= 6
