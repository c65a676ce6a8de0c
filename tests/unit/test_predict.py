"""Predictions for weather: the fitted temperature, and no impossible values."""

import numpy as np
import pandas as pd
import pytest
from conftest import COLUMNS, DRIVERS

import pvlib_fem as fem
from pvlib_fem._thermal.model import thermal_model
from pvlib_fem.effects import find

MEMORIES = {"steady": {}, "ewm": {"tau": 378.0}, "balance": {"capacity": 12e3}}
HOUR = pd.Timedelta("1h")
FAIMAN = {"u0": 25.0, "u1": 6.84, "bias": -1.0}
every = pytest.mark.parametrize("dynamics", MEMORIES)
EFFECTS = ("natural_convection", "sky_radiation", "radiative_loss")


@every
@pytest.mark.parametrize("effects", [(), ("sky_radiation", "temperature_gain")])
def test_the_prediction_is_the_fitted_temperature(plant, dynamics, effects):
    """Negative irradiance, gaps and fill values are taken as the fit took them."""
    data = plant[:4000].copy()
    data.loc[data["poa_global"] == 0, "poa_global"] = -3.0
    for row, (name, value) in enumerate(
        [("wind_speed", -99.0), ("temp_air", -999.0), ("poa_global", np.nan)]
    ):
        data.iloc[1000 + 40 * row, data.columns.get_loc(name)] = value
    usual = [data[n] for n in COLUMNS]
    drivers = {"longwave_down": data["longwave_down"]} if effects else {}
    how = dict(model="faiman", dynamics=dynamics, effects=effects)
    fit = fem.fit_fem(*usual, **how, **drivers)
    with pytest.warns(UserWarning, match=r"wind_speed holds 1 values .* first -99 m/s"):
        answer = fit.predict(*usual[:3], **drivers)
    fitted = data["temp_module"] - fit.residual
    seen = fitted.notna()
    assert seen.sum() == len(data) - 3
    np.testing.assert_allclose(answer[seen], fitted[seen], rtol=1e-9)
    assert answer[~seen].isna().all()


@every
@pytest.mark.parametrize("name", [None, *EFFECTS])
@pytest.mark.parametrize(
    ("column", "value"), [("wind_speed", -99.0), ("temp_air", -999.0)]
)
def test_a_fill_value_is_a_gap_and_no_more(plant, dynamics, name, column, value):
    data = plant[:600].copy()
    effects = () if name is None else (find(name),)
    coefficients = {**FAIMAN, **MEMORIES[dynamics]}
    model = thermal_model("faiman", dynamics, effects, dict(coefficients))
    for effect in effects:
        for own, row in effect.rows().items():
            coefficients[own] = row.start + 0.3 * (row.upper - row.start)

    def predicted(data):
        drivers = {n: data[n] for n in model.drivers}
        return model.predict(*(data[n] for n in DRIVERS), coefficients, **drivers)

    row = data.columns.get_loc(column)
    data.iloc[300, row] = np.nan
    gap = predicted(data)
    assert gap.isna().sum() == 1
    data.iloc[300, row] = value
    with pytest.warns(UserWarning, match=f"{column} holds 1 values that cannot be"):
        pd.testing.assert_series_equal(predicted(data), gap)


def test_a_steady_model_takes_no_time_constant(month):
    coefficients = {"k": 0.035, "d": 10.0, "tau": 300.0}
    with pytest.raises(ValueError, match="tau = 300 s is given, and dynamics='st"):
        fem.DynamicCellTemperature("wm1", "steady", coefficients)
    usual = [month[n][:500] for n in DRIVERS]
    fit = fem.fit_fem(*(month[n][:20_000] for n in COLUMNS), dynamics="steady")
    steady = fem.wm1(*usual, fit.coefficients["k"], fit.coefficients["d"])
    answer = fit.predict(*usual)
    np.testing.assert_allclose(answer, steady + fit.coefficients["bias"], rtol=1e-12)


@pytest.mark.parametrize(
    ("model", "dynamics", "coefficients", "message"),
    [
        ("wm1", "ewm", {"k": 0.03}, "wm1 needs d"),
        ("wm1", "ewm", {"k": 0.03, "d": 9.0, "capacity": 9e3}, "no coefficient capac"),
        ("wm2", "ewm", {"k": 0.03, "k_w": 0.004}, "k_w·8 must be below k"),
        ("faiman", "balance", {"u0": 25.0, "u1": 6.8}, "faiman needs capacity"),
        ("faiman", "balance", {**FAIMAN, "capacity": -1.0}, "capacity = -1.0 must be"),
        ("noct_sam", "ewm", {"noct": 45.0}, "noct_sam needs module_efficiency"),
        (
            "sapm",
            "ewm",
            {"a": -3.47, "b": -0.0594, "deltaT": 3.0},
            "give it as deltaT=3.0 in addition to coefficients",
        ),
        (
            "faiman",
            "ewm",
            {**FAIMAN, "tau": HOUR},
            "tau = 0 days 01:00:00 must be a positive",
        ),
    ],
)
def test_coefficients_that_cannot_be_are_refused_at_once(
    model, dynamics, coefficients, message
):
    with pytest.raises(ValueError, match=message):
        fem.DynamicCellTemperature(model, dynamics, coefficients)


def test_columns_that_are_not_given_are_named(month):
    light, *others = (month[name][:20_000] for name in COLUMNS)
    fit = fem.fit_fem(light, *others, model="faiman")
    with pytest.raises(ValueError, match="have no column temp_air; give"):
        fit.predict(light)
    with pytest.raises(ValueError, match="no columns temp_air, temp_module; give a S"):
        fem.fit_fem(light)


@pytest.mark.parametrize("dynamics", ["ewm", "balance"])
@pytest.mark.parametrize(
    ("model", "truth", "fixed"),
    [
        ("pvsyst", {"u_c": 25.0, "u_v": 3.0}, {}),
        ("pvsyst", {"u_c": 25.0, "u_v": 3.0}, {"module_efficiency": 0.2}),
        ("noct", {"noct": 44.0}, {}),
        ("noct_sam", {"noct": 47.0}, {"module_efficiency": 0.2}),
    ],
)
def test_pvlibs_names_are_fitted(plant, dynamics, model, truth, fixed):
    usual = [plant[n][:6000] for n in DRIVERS]
    truth = {**truth, **MEMORIES[dynamics], "bias": -1.0}
    function = fem.heat_balance if dynamics == "balance" else fem.fem_temperature
    module = function(*usual, model=model, **truth, **fixed)
    how = dict(model=model, dynamics=dynamics, fixed=fixed)
    fit = fem.fit_fem(*usual, module, **how)
    assert fit.coefficients == pytest.approx({**truth, **fixed}, rel=1e-4)
    again = function(*usual, model=model, **fit.coefficients)
    np.testing.assert_allclose(fit.predict(*usual), again, rtol=1e-9)
    assert "needs" not in str(fit)


def test_what_a_model_of_pvlib_needs_is_said(plant):
    usual = [plant[n][:2000] for n in COLUMNS]
    for options, message in (
        (
            dict(model="noct_sam"),
            "noct_sam needs module_efficiency; give it as",
        ),
        (
            dict(model="pvsyst", fixed={"alpha_absorption": 2}),
            "alpha_absorption = 2 - ",
        ),
        (dict(model="pvsyst", method="paper"), "method='paper' has no pvsyst"),
    ):
        with pytest.raises(ValueError, match=message):
            fem.fit_fem(*usual, **options)


def test_the_loop_knows_pvlibs_names():
    data = fem.simulator.record(days=12, step=900, effects=fem.simulator.LINEAR)
    loop = fem.close_loop(data, model="pvsyst", fixed={"module_efficiency": 0.2})
    coefficients = loop.fit.coefficients
    assert coefficients["module_efficiency"] == 0.2 and loop.fit.model == "pvsyst"
    same = fem.close_loop(data, model="faiman").fit.coefficients
    line = fem.translate_coefficients(coefficients, "pvsyst", "faiman", "two_winds")
    for name in ("u0", "u1", "capacity"):
        assert line[name] == pytest.approx(same[name], rel=1e-3)


@pytest.fixture(scope="module")
def short(plant):
    data = plant[: 288 * 30]
    return data, fem.close_loop(data[[*COLUMNS]])


@pytest.mark.parametrize("kind", [dict, list, np.asarray])
@pytest.mark.parametrize(
    "method", ["predict", "residual", "contributions", "corrected"]
)
def test_a_loop_refuses_what_is_no_frame(short, kind, method):
    data, loop = short
    with pytest.raises(ValueError, match=r"data is a .*; give a DataFrame"):
        getattr(loop, method)(kind(data))
    with pytest.raises(ValueError, match=r"data is a .*; give a DataFrame"):
        fem.rank_effects(loop.fit, kind(data))


@pytest.mark.parametrize("of", ["times", "spans", "complex"])
def test_times_and_complex_numbers_are_no_temperature(short, of):
    data, loop = short
    column = {
        "times": data.index,
        "spans": data.index - data.index[0],
        "complex": data["temp_air"] + 0j,
    }[of]
    with pytest.raises(ValueError, match=r"temp_air holds .* give a column of numbers"):
        loop.predict(data.assign(temp_air=column))
    with pytest.raises(ValueError, match=r"temp_air holds .* give a column of numbers"):
        fem.fit_fem(data.assign(temp_air=column))


def test_what_is_given_with_a_frame_is_named(short):
    data, _ = short
    with pytest.raises(ValueError, match=r"efects is given .*did you mean 'effects'"):
        fem.fit_fem(data, efects=["rain"])
    with pytest.raises(ValueError, match=r"temp_air, surface_tilt are given"):
        fem.fit_fem(data, data["temp_air"], surface_tilt=30.0)
