"""Steady and dynamic temperatures: limits, pvlib, and independent routes."""

import functools

import numpy as np
import pandas as pd
import pvlib
import pytest
from hypothesis import given, strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

import pvlib_fem as fem
from pvlib_fem._thermal.steady_models import STEADY_MODELS

COEFFICIENTS = {
    "ross": dict(k=0.03),
    "sapm": dict(a=-3.47, b=-0.0594),
    "faiman": dict(u0=25.0, u1=6.84),
    "wm1": dict(k=0.035, d=12.0),
    "wm2": dict(k=0.035, k_w=0.002),
    "pvsyst": dict(u_c=29.0, u_v=1.2, module_efficiency=0.2),
    "noct": dict(noct=46.0),
    "noct_sam": dict(noct=46.0, module_efficiency=0.2),
}
models = pytest.mark.parametrize("model", COEFFICIENTS)
dynamic = pytest.mark.parametrize(
    ("function", "memory"),
    [(fem.fem_temperature, {"tau": 378.0}), (fem.heat_balance, {"capacity": 12e3})],
)


def in_an_instant(*drivers, model):
    """The dynamic form with nothing to remember."""
    return fem.fem_temperature(*drivers, tau=1e-9, model=model, **COEFFICIENTS[model])


@pytest.mark.parametrize(
    ("model", "function"),
    [
        ("sapm", pvlib.temperature.sapm_module),
        ("faiman", pvlib.temperature.faiman),
        ("pvsyst", pvlib.temperature.pvsyst_cell),
        ("noct_sam", pvlib.temperature.noct_sam),
        ("noct", lambda poa, air, _, noct: pvlib.temperature.ross(poa, air, noct)),
        # by its NOCT: older pvlib knows no k
        (
            "ross",
            lambda poa, air, _, k: pvlib.temperature.ross(poa, air, noct=20 + 800 * k),
        ),
    ],
)
def test_steady_laws_are_pvlibs(drivers, model, function):
    expected = function(*drivers, **COEFFICIENTS[model])
    assert_allclose(in_an_instant(*drivers, model=model), expected, rtol=1e-12)


def test_wm1_and_wm2_are_the_papers_equations():
    assert fem.wm1(800, 20, 3, k=0.035, d=12) == 20 + 0.035 * 800 * np.exp(-3 / 12)
    assert fem.wm2(800, 20, 3, k=0.035, k_w=0.002) == pytest.approx(
        20 + 800 * (0.035 - 0.002 * 3), rel=1e-15
    )
    gale = fem.wm2(800, 20, np.array([8.0, 12.0]), k=0.035, k_w=0.002)
    assert gale[0] == gale[1]


@models
def test_without_wind_every_law_is_rosss(drivers, model):
    """k = e^a = 1/U0 (the paper's Eq. 12)."""
    calm_k = {
        "sapm": np.exp(-3.47),
        "faiman": 1 / 25.0,
        "ross": 0.03,
        "pvsyst": 0.9 * (1 - 0.2) / 29.0,
        "noct": (46 - 20) / 800,
        "noct_sam": (46 - 20) / 800 * (1 - 0.2 / 0.9) * 9.5 / 5.7,
    }.get(model, 0.035)
    poa, air, _ = drivers
    calm = fem.fem_temperature(poa, air, 0.0, model=model, **COEFFICIENTS[model])
    ross = fem.fem_temperature(poa, air, 0.0, model="ross", k=calm_k)
    assert_allclose(calm, ross, rtol=1e-12)


@models
def test_a_vanishing_memory_gives_the_steady_model(drivers, model):
    steady_model = STEADY_MODELS[model]
    coefficients = steady_model.complete(COEFFICIENTS[model])
    poa, air, wind = drivers
    steady = air + poa * steady_model.resistance(wind, **coefficients)
    assert_allclose(in_an_instant(*drivers, model=model), steady, rtol=1e-12)
    quick = fem.heat_balance(
        *drivers, capacity=1e-6, model=model, **COEFFICIENTS[model]
    )
    assert_allclose(quick, steady, rtol=1e-12)


@dynamic
@models
def test_constant_weather_ends_in_the_steady_temperature(function, memory, model):
    ones = np.ones(500)
    drivers = 800.0 * ones, 20.0 * ones, 3.0 * ones
    steady_model = STEADY_MODELS[model]
    coefficients = steady_model.complete(COEFFICIENTS[model])
    expected = 20.0 + 800.0 * steady_model.resistance(3.0, **coefficients) + 1.5
    answer = function(
        *drivers, **memory, bias=1.5, model=model, step=60, **COEFFICIENTS[model]
    )
    assert_allclose(answer, expected, rtol=1e-13)


@models
def test_heat_balance_solves_its_differential_equation(month, model):
    """Against an adaptive Runge-Kutta of C dT/dt = G - (T - Ta)/r_eq."""
    hours = month.iloc[600:780]
    steady_model = STEADY_MODELS[model]
    coefficients = steady_model.complete(COEFFICIENTS[model])
    capacity = 15e3
    answer = fem.heat_balance(
        hours["poa_global"],
        hours["temp_air"],
        hours["wind_speed"],
        capacity=capacity,
        model=model,
        **COEFFICIENTS[model],
    )
    rows = hours[["poa_global", "temp_air", "wind_speed"]].to_numpy()
    state = answer.iloc[0]
    for i in range(1, len(rows)):
        poa, air, wind = rows[i]
        r_eq = steady_model.resistance(wind, **coefficients)
        state = solve_ivp(
            lambda t, T, poa=poa, air=air, r=r_eq: (poa - (T - air) / r) / capacity,
            (0, 60),
            [state],
            rtol=1e-10,
            atol=1e-10,
        ).y[0, -1]
        assert answer.iloc[i] == pytest.approx(state, abs=1e-6)


def test_with_constant_wind_and_air_both_dynamics_agree(month):
    """Then smoothing the inputs is the physics, with tau = C·r_eq."""
    poa = month["poa_global"]
    r_eq = 1 / (25.0 + 6.84 * 2.0)
    ewm = fem.fem_temperature(
        poa, 20.0, 2.0, tau=378.0, model="faiman", u0=25.0, u1=6.84
    )
    balance = fem.heat_balance(poa, 20.0, 2.0, capacity=378.0 / r_eq, u0=25.0, u1=6.84)
    assert_allclose(ewm, balance, rtol=1e-12)


def test_the_time_constant_of_the_balance_follows_the_wind():
    """After one time constant C·r_eq(wind), 1 - 1/e of a step is reached."""
    for wind in (0.0, 2.0, 8.0):
        tau = 12e3 / (25.0 + 6.84 * wind)
        sun = np.r_[0.0, np.full(2000, 1000.0)]
        rise = fem.heat_balance(
            sun, 0.0, wind, capacity=12e3, u0=25.0, u1=6.84, step=tau / 100
        )
        assert rise[100] / rise[-1] == pytest.approx(1 - np.exp(-1), rel=1e-6)


@pytest.mark.parametrize(
    ("model", "coefficients"),
    [
        (pvlib.temperature.sapm_cell, dict(a=-3.47, b=-0.0594, deltaT=3)),
        (pvlib.temperature.sapm_module, dict(a=-3.47, b=-0.0594)),
        (pvlib.temperature.pvsyst_cell, dict(u_c=29.0, u_v=1.0)),
        (pvlib.temperature.faiman, {}),
        (pvlib.temperature.noct_sam, dict(noct=45, module_efficiency=0.2)),
        (
            pvlib.temperature.generic_linear,
            dict(u_const=20.0, du_wind=5.0, module_efficiency=0.2, absorptance=0.9),
        ),
    ],
)
def test_any_model_of_pvlibs_shape_becomes_dynamic(drivers, model, coefficients):
    poa, air, wind = drivers
    expected = model(fem.ewm(poa, 378.0), air, fem.ewm(wind, 378.0), **coefficients)
    answer = fem.fem_temperature(*drivers, model=model, **coefficients)
    assert_allclose(answer, expected, rtol=1e-12)
    assert answer.index.equals(poa.index)
    assert answer.name is None


def test_pvlibs_ross_takes_its_coefficient_and_not_the_wind(drivers):
    answer = fem.fem_temperature(*drivers, model=pvlib.temperature.ross, noct=44)
    own = fem.fem_temperature(*drivers, model="ross", k=0.03)
    assert_allclose(answer, own, rtol=1e-12)


def test_a_models_own_series_is_aligned_and_not_smoothed(drivers):
    poa, air, wind = drivers
    longwave = pd.Series(np.linspace(250, 400, len(poa)), poa.index)
    answer = fem.fem_temperature(
        *drivers, model=pvlib.temperature.faiman_rad, ir_down=longwave
    )
    expected = pvlib.temperature.faiman_rad(
        fem.ewm(poa, 378.0), air, fem.ewm(wind, 378.0), ir_down=longwave
    )
    assert_allclose(answer, expected, rtol=1e-12)


def test_a_function_of_the_users_own_may_name_its_arguments_as_it_likes(drivers):
    poa, air, _ = drivers
    answer = fem.fem_temperature(*drivers, model=lambda g, t, v, k: t + k * g, k=0.03)
    assert_allclose(answer, air + 0.03 * fem.ewm(poa, 378.0), rtol=1e-12)


@dynamic
def test_series_arrays_and_numbers_give_the_same(drivers, function, memory):
    poa, air, wind = (series.iloc[600:900] for series in drivers)
    coefficients = dict(model="faiman", u0=25.0, u1=6.84, **memory)
    series = function(poa, air, wind, **coefficients)
    arrays = function(
        poa.to_numpy(), air.to_numpy(), wind.to_numpy(), step=60, **coefficients
    )
    timed = function(
        poa.to_numpy(), air.to_numpy(), wind.to_numpy(), times=poa.index, **coefficients
    )
    assert isinstance(arrays, np.ndarray)
    assert_allclose(series, arrays, rtol=1e-13)
    assert_allclose(series, timed, rtol=1e-13)
    mild = function(poa, 20.0, 3.0, **coefficients)
    same = function(poa, 0 * poa + 20.0, 0 * poa + 3.0, **coefficients)
    assert_allclose(mild, same, rtol=1e-13)


def test_a_heat_balance_can_be_carried_on(drivers):
    poa, air, wind = (series.iloc[600:900] for series in drivers)
    coefficients = dict(capacity=12e3, u0=25.0, u1=6.84, bias=-2.0)
    whole = fem.heat_balance(poa, air, wind, **coefficients)
    first = fem.heat_balance(poa[:120], air[:120], wind[:120], **coefficients)
    second = fem.heat_balance(
        poa[120:], air[120:], wind[120:], initial=first, **coefficients
    )
    assert_allclose(pd.concat([first, second]), whole, rtol=1e-12)


@models
def test_the_slopes_of_a_steady_model_are_exact(model):
    steady_model = STEADY_MODELS[model]
    own = {**steady_model.complete(COEFFICIENTS[model])}
    wind = np.array([0.0, 0.3, 2.0, 7.0, 12.0])
    slopes = steady_model.slopes(wind, **own)
    assert slopes.keys() == {*steady_model.parameters, "wind_speed"}
    assert steady_model.parameters
    for name in steady_model.parameters:
        step = 1e-6 * abs(own[name])
        up, down = (
            steady_model.resistance(wind, **{**own, name: own[name] + s})
            for s in (step, -step)
        )
        assert_allclose(slopes[name], (up - down) / (2 * step), rtol=1e-7)
    up, down = (steady_model.resistance(wind + s, **own) for s in (1e-6, -1e-6))
    by_wind = slopes["wind_speed"] + 0.0 * wind
    assert_allclose(by_wind, (up - down) / 2e-6, rtol=1e-5, atol=1e-11)


def test_pvlibs_own_defaults_are_known(drivers):
    """Defaults are pvlib's: faiman's 25.0 and 6.84, pvsyst_cell's 29.0 and 0.0."""
    for model, function in (
        ("faiman", pvlib.temperature.faiman),
        ("pvsyst", pvlib.temperature.pvsyst_cell),
    ):
        answer = fem.fem_temperature(*drivers, tau=1e-9, model=model)
        assert_allclose(answer, function(*drivers), rtol=1e-12)
    by_noct = fem.fem_temperature(*drivers, tau=1e-9, model="ross", noct=46.0)
    assert_allclose(by_noct, pvlib.temperature.ross(*drivers[:2], 46.0), rtol=1e-12)
    answer = fem.heat_balance(*drivers, capacity=12e3, model="ross", noct=46.0)
    own = fem.heat_balance(*drivers, capacity=12e3, model="ross", k=26 / 800)
    assert_allclose(answer, own, rtol=1e-12)


@pytest.mark.parametrize("cut", [2, 120, 299])
def test_a_smoothed_temperature_can_be_carried_on(drivers, cut):
    data = pd.concat(drivers, axis=1).iloc[600:900]
    data.iloc[[cut - 1, 200], 0] = np.nan  # also where a piece ends
    how = dict(tau=378.0, model="faiman", bias=-2.0)
    whole, first = (
        fem.fem_temperature(*(d[name] for name in data), **how)
        for d in (data, data[:cut])
    )
    past = {n: fem.ewm(data[n][:cut], 378.0) for n in ("poa_global", "wind_speed")}
    for initial in (past, pd.DataFrame(past)):
        second = (data[name][cut:] for name in data)
        second = fem.fem_temperature(*second, initial=initial, **how)
        assert_allclose(pd.concat([first, second]), whole, rtol=1e-12)


@pytest.mark.parametrize("initial", [20.0, {"poa_global": 500.0}])
def test_a_temperature_is_no_state_of_two_inputs(drivers, initial):
    with pytest.raises(ValueError, match=r"from a temperature|has no wind_speed"):
        fem.fem_temperature(*drivers, model="faiman", initial=initial)


@pytest.mark.parametrize(
    "model",
    [
        pvlib.temperature.fuentes,
        pvlib.temperature.prilliman,
        fem.heat_balance,
        functools.partial(pvlib.temperature.fuentes, noct_installed=45),
    ],
)
def test_a_model_with_its_own_memory_is_refused(drivers, model):
    with pytest.raises(ValueError, match="has a memory of its own"):
        fem.fem_temperature(*drivers, model=model, noct_installed=45)
    with pytest.raises(ValueError, match="has a memory of its own"):
        fem.DynamicCellTemperature(model)


def test_effective_irradiance_beside_smoothed_irradiance_is_refused(drivers):
    """SAM's efficiency is their ratio: above 1 after a cloud, and 0/0 at night."""
    known = dict(model=pvlib.temperature.noct_sam, noct=45.0, module_efficiency=0.2)
    with pytest.raises(ValueError, match="effective_irradiance is that of the moment"):
        fem.fem_temperature(*drivers, effective_irradiance=drivers[0], **known)
    assert fem.fem_temperature(*drivers, **known).notna().all()


@pytest.mark.parametrize("function", [fem.fem_temperature, fem.heat_balance])
def test_coefficients_by_place_are_refused(drivers, function):
    """pvlib's habit faiman(poa, air, wind, 25.0, 6.84) would be tau and bias."""
    with pytest.raises(TypeError, match="positional"):
        function(*drivers, 25.0, 6.84, model="faiman")


@dynamic
def test_wind_below_zero_is_refused(drivers, function, memory):
    poa, air, wind = (series.iloc[:9].copy() for series in drivers)
    wind.iloc[4] = -99.0
    with pytest.raises(ValueError, match=r"wind_speed = -99 m/s at 2023-06-01 00:04"):
        function(poa, air, wind, **memory, model="sapm", a=-3.47, b=-0.0594)
    wind.iloc[4] = np.nan
    assert function(poa, air, wind, **memory, model="faiman").isna().sum() == 1


rows = st.lists(
    st.tuples(
        st.floats(1.0, 3000.0),
        st.one_of(st.just(np.nan), st.floats(0, 1200)),
        st.one_of(st.just(np.nan), st.floats(-20, 45)),
        st.one_of(st.just(np.nan), st.floats(0, 20)),
    ),
    min_size=2,
    max_size=40,
)


@given(rows, st.sampled_from(sorted(COEFFICIENTS)), st.booleans(), st.floats(30, 2000))
def test_random_weather_keeps_the_laws_of_a_dynamic_model(rows, model, balance, tau):
    steps, poa, air, wind = np.array(rows).T
    times = np.cumsum(steps)
    if balance:
        memory = {"capacity": tau / 0.03}
        answer = fem.heat_balance(
            poa, air, wind, times=times, model=model, **memory, **COEFFICIENTS[model]
        )
    else:
        answer = fem.fem_temperature(
            poa, air, wind, tau=tau, times=times, model=model, **COEFFICIENTS[model]
        )
    missing = np.isnan(poa) | np.isnan(air) | np.isnan(wind)
    assert (np.isnan(answer) == missing).all()
    if missing.all():
        return
    steady_model = STEADY_MODELS[model]
    r_eq = steady_model.resistance(wind, **steady_model.complete(COEFFICIENTS[model]))
    if balance:
        instantaneous = (air + poa * r_eq)[~missing]
        low, high = instantaneous.min(), instantaneous.max()
    else:
        # smoothed irradiance and wind stay within their ranges
        low = np.nanmin(air) + np.nanmin(poa) * np.nanmin(
            steady_model.resistance(
                np.nanmax(wind), **steady_model.complete(COEFFICIENTS[model])
            )
        )
        high = np.nanmax(air) + np.nanmax(poa) * np.nanmax(
            steady_model.resistance(
                np.nanmin(wind), **steady_model.complete(COEFFICIENTS[model])
            )
        )
    assert np.nanmin(answer) >= low - 1e-9
    assert np.nanmax(answer) <= high + 1e-9


@dynamic
def test_a_dynamic_model_says_why_it_needs_a_series(function, memory):
    with pytest.raises(ValueError, match="needs a series, not single numbers"):
        function(1000.0, 20.0, 2.0, **memory, model="ross", k=0.03)


def test_arrays_need_their_step():
    with pytest.raises(ValueError, match="give step in seconds"):
        fem.fem_temperature(np.ones(3), 20.0, 2.0, model="ross", k=0.03)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda g: fem.wm2(g, 20, 2, k=0.03, k_w=0.004), "k_w·8 must be below k"),
        (
            lambda g: fem.fem_temperature(g, 20, 2, model="noct", noct=20),
            "noct = 20 must be above 20 °C",
        ),
        (
            lambda g: fem.fem_temperature(g, 20, 2, model="noct_sam", noct=45),
            "noct_sam needs module_efficiency",
        ),
        (
            lambda g: fem.fem_temperature(g, 20, 2, model="pvsyst", alpha_absorption=9),
            "alpha_absorption = 9 must be a share, 0 to 1",
        ),
        (
            lambda g: fem.fem_temperature(
                g, 20, 2, model="noct_sam", noct=45, module_efficiency=0.95
            ),
            "module_efficiency = 0.95 must be below 0.9",
        ),
        (lambda g: fem.wm1(g, 20, 2, k=0.03, d=0), "d = 0 must be positive"),
        (lambda g: fem.wm1(g, 20, 2, k=-0.03, d=9), "k = -0.03 must be positive"),
        (
            lambda g: fem.fem_temperature(g, 20, 2, tau=0, k=0.03, d=9),
            "tau = 0.0 must be positive",
        ),
        (
            lambda g: fem.heat_balance(g, 20, 2, capacity=-5, u0=25, u1=6),
            "capacity = -5 must be a positive number",
        ),
        (lambda g: fem.heat_balance(g, 20, 2, capacity=g), "^capacity must be a posi"),
        (
            lambda g: fem.heat_balance(g.to_numpy(), 20, -1, capacity=1e4, step=60),
            "wind_speed = -1 m/s at row 0 cannot be",
        ),
        (
            lambda g: fem.fem_temperature(g, 20, 2, model="wm3", k=0.03),
            "unknown model 'wm3' .*; the models are ross, sapm, faiman, wm1, wm2",
        ),
        (
            lambda g: fem.fem_temperature(g, 20, 2, k=0.03, u0=9),
            "wm1 has no coefficient u0; it has k, d",
        ),
        (
            lambda g: fem.fem_temperature(g, 20, 2, k=0.03),
            "wm1 needs d; it has the coefficients k, d",
        ),
        (
            lambda g: fem.fem_temperature(
                g, 20, 2, model=pvlib.temperature.faiman, u2=0.03
            ),
            "faiman has no coefficient u2; it has u0, u1",
        ),
        (
            lambda g: fem.heat_balance(
                g, 20, 2, capacity=1e4, model="faiman", u0=25, u1=-20
            ),
            "no loss of heat at 2",
        ),
        (lambda g: fem.fem_temperature(g, 20, 2, step=9, k=1, d=9), "drop step"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(call, message):
    times = pd.date_range("2024-05-01", periods=3, freq="1min")
    with pytest.raises(ValueError, match=message):
        call(pd.Series([0.0, 500.0, 1000.0], times))
