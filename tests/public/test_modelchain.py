"""The temperature model in real ModelChain runs."""

import pickle
import warnings

import numpy as np
import pandas as pd
import pvlib
import pytest
from conftest import COLUMNS, DRIVERS
from pvlib.location import Location
from pvlib.modelchain import ModelChain
from pvlib.pvsystem import Array, FixedMount, PVSystem

import pvlib_fem as fem
from pvlib_fem import datasets

WM1 = dict(k=0.035, d=10.0, tau=378.0, bias=-2.0)
WEATHER = ["ghi", "dni", "dhi", "temp_air", "wind_speed"]


@pytest.fixture(scope="module")
def weather():
    return datasets.synthetic(2, seed=3, noise=0)[WEATHER]


def system(*azimuths, parameters=None):
    arrays = [
        Array(
            FixedMount(surface_tilt=30, surface_azimuth=azimuth),
            module_parameters={"pdc0": 1000.0, "gamma_pdc": -0.0035},
            temperature_model_parameters=parameters or {},
        )
        for azimuth in azimuths
    ]
    return PVSystem(arrays, inverter_parameters={"pdc0": 5000.0})


def chain(plant, model):
    return ModelChain(
        plant,
        Location(35, -106),
        aoi_model="physical",
        spectral_model="no_loss",
        dc_model="pvwatts",
        ac_model="pvwatts",
        temperature_model=model,
    )


def expected(poa_global, weather, **coefficients):
    return fem.fem_temperature(
        poa_global, weather["temp_air"], weather["wind_speed"], **coefficients
    )


def test_a_run_from_weather_has_the_dynamic_temperature(weather):
    run = chain(system(180), fem.DynamicCellTemperature("wm1", "ewm", WM1))
    results = run.run_model(weather).results
    want = expected(results.total_irrad["poa_global"], weather, **WM1)
    pd.testing.assert_series_equal(results.cell_temperature, want)
    power = pvlib.pvsystem.pvwatts_dc(
        results.effective_irradiance, want, 1000.0, -0.0035
    )
    np.testing.assert_allclose(results.dc, power)


@pytest.mark.parametrize("in_tuples", [False, True])
def test_two_arrays_have_one_temperature_each(weather, in_tuples):
    run = chain(system(90, 270), fem.DynamicCellTemperature("wm1", "ewm", WM1))
    results = run.run_model((weather, weather) if in_tuples else weather).results
    assert isinstance(results.cell_temperature, tuple)
    for cell, total in zip(results.cell_temperature, results.total_irrad, strict=True):
        want = expected(total["poa_global"], weather, **WM1)
        pd.testing.assert_series_equal(cell, want)
    east, west = results.cell_temperature
    assert (east - west).abs().max() > 5


def test_a_single_array_given_as_a_tuple_stays_a_tuple(weather):
    run = chain(system(180), fem.DynamicCellTemperature("wm1", "ewm", WM1))
    (cell,) = run.run_model((weather,)).results.cell_temperature
    total = run.results.total_irrad[0]["poa_global"]
    pd.testing.assert_series_equal(cell, expected(total, weather, **WM1))


def poa_frame(weather, azimuth):
    run = chain(system(azimuth), fem.DynamicCellTemperature("wm1", "ewm", WM1))
    total = run.run_model(weather).results.total_irrad
    return total[["poa_global", "poa_direct", "poa_diffuse"]].join(
        weather[["temp_air", "wind_speed"]]
    )


@pytest.mark.parametrize("azimuths", [(180,), (90, 270)])
def test_a_run_from_plane_of_array_irradiance(weather, azimuths):
    frames = tuple(poa_frame(weather, azimuth) for azimuth in azimuths)
    run = chain(system(*azimuths), fem.DynamicCellTemperature("wm1", "ewm", WM1))
    run.run_model_from_poa(frames if len(frames) > 1 else frames[0])
    cells = run.results.cell_temperature
    for cell, frame in zip(cells if len(frames) > 1 else (cells,), frames, strict=True):
        want = expected(frame["poa_global"], weather, **WM1)
        pd.testing.assert_series_equal(cell, want)


@pytest.mark.parametrize("azimuths", [(180,), (90, 270)])
@pytest.mark.parametrize("with_poa", [False, True])
def test_a_run_from_effective_irradiance(weather, azimuths, with_poa):
    """Without poa_global pvlib takes the effective irradiance; so is here."""
    frames = []
    for azimuth in azimuths:
        frame = poa_frame(weather, azimuth)
        frame["effective_irradiance"] = 0.96 * frame["poa_global"]
        kept = ["effective_irradiance", "temp_air", "wind_speed"]
        frames.append(frame[kept + (["poa_global"] if with_poa else [])])
    run = chain(system(*azimuths), fem.DynamicCellTemperature("wm1", "ewm", WM1))
    run.run_model_from_effective_irradiance(
        tuple(frames) if len(frames) > 1 else frames[0]
    )
    cells = run.results.cell_temperature
    for cell, frame in zip(cells if len(frames) > 1 else (cells,), frames, strict=True):
        sun = frame["poa_global" if with_poa else "effective_irradiance"]
        want = expected(sun, weather, **WM1)
        pd.testing.assert_series_equal(cell, want, check_names=False)


def test_steady_coefficients_give_pvlibs_own_cell_temperature(weather):
    """With nothing to remember, ModelChain(temperature_model="faiman")."""
    faiman = {"u0": 25.0, "u1": 6.84}
    own = chain(system(180, parameters=faiman), "faiman").run_model(weather)
    steady = fem.DynamicCellTemperature("faiman", "steady", faiman)
    ours = chain(system(180), steady).run_model(weather)
    np.testing.assert_allclose(
        ours.results.cell_temperature, own.results.cell_temperature, rtol=1e-12
    )


STEADY = {
    "faiman": {"u0": 20.0, "u1": 5.0},
    "sapm": {"a": -3.47, "b": -0.0594, "deltaT": 3.0},
    "pvsyst": {"u_c": 25.0, "u_v": 1.2},
}


@pytest.mark.parametrize("model", STEADY)
@pytest.mark.parametrize("as_callable", [False, True])
def test_parameters_of_an_array_mean_what_they_mean_in_pvlib(
    model, as_callable, weather
):
    """PVsyst's model has its efficiency and absorptance with the module."""
    plant = system(180, parameters=STEADY[model])
    module = {"module_efficiency": 0.22, "alpha_absorption": 0.88}
    plant.arrays[0].module_parameters |= module
    own = chain(plant, model).run_model(weather).results.cell_temperature
    steady = fem.DynamicCellTemperature(model, "steady")
    if as_callable:
        name = model if model == "faiman" else f"{model}_cell"
        steady = fem.DynamicCellTemperature(getattr(pvlib.temperature, name))
        plant.arrays[0].temperature_model_parameters["tau"] = 1e-9
    ours = chain(plant, steady).run_model(weather).results.cell_temperature
    np.testing.assert_allclose(ours, own, rtol=1e-12)


def test_ross_takes_a_noct_for_its_k(weather):
    noct, k = {"noct": 46.0}, {"k": 26.0 / 800.0}
    runs = [
        chain(system(180), fem.DynamicCellTemperature("ross", "steady", k)),
        chain(system(180), fem.DynamicCellTemperature("ross", "steady", noct)),
        chain(
            system(180, parameters=noct), fem.DynamicCellTemperature("ross", "steady")
        ),
    ]
    want, *others = (run.run_model(weather).results.cell_temperature for run in runs)
    for cell in others:
        np.testing.assert_allclose(cell, want, rtol=1e-12)


def test_a_parameter_of_the_temperature_model_goes_before_the_modules(weather):
    parameters = {"u_c": 25.0, "u_v": 1.2, "module_efficiency": 0.15}
    plant = system(180, parameters=parameters)
    plant.arrays[0].module_parameters["module_efficiency"] = 0.22
    steady = fem.DynamicCellTemperature("pvsyst", "steady")
    results = chain(plant, steady).run_model(weather).results
    want = pvlib.temperature.pvsyst_cell(
        results.total_irrad["poa_global"],
        weather["temp_air"],
        weather["wind_speed"],
        **parameters,
    )
    np.testing.assert_allclose(results.cell_temperature, want, rtol=1e-12)


def test_given_coefficients_keep_the_efficiency_they_were_fitted_with(weather):
    """A fit of pvsyst has u_c and u_v for its own efficiency, 0.1 by default."""
    given = {"u_c": 25.0, "u_v": 1.2}
    cells = []
    for efficiency in (0.1, 0.22):
        plant = system(180)
        plant.arrays[0].module_parameters["module_efficiency"] = efficiency
        steady = fem.DynamicCellTemperature("pvsyst", "steady", given)
        results = chain(plant, steady).run_model(weather).results
        cells.append(results.cell_temperature)
    pd.testing.assert_series_equal(*cells)


def test_a_fit_runs_in_a_chain(weather):
    record = datasets.synthetic(8, seed=2)
    fit = fem.fit_fem(*(record[name] for name in COLUMNS), dynamics="balance")
    run = chain(system(180), fit.temperature_model(deltaT=0.0)).run_model(weather)
    drivers = weather.assign(poa_global=run.results.total_irrad["poa_global"])
    want = fit.predict(*(drivers[name] for name in DRIVERS))
    pd.testing.assert_series_equal(run.results.cell_temperature, want)


def test_coefficients_may_stand_with_each_array(weather):
    plant = system(90, 270)
    plant.arrays[0].temperature_model_parameters = {**WM1, "deltaT": 3.0}
    plant.arrays[1].temperature_model_parameters = {**WM1, "k": 0.05}
    results = chain(plant, fem.DynamicCellTemperature("wm1")).run_model(weather).results
    east, west = (total["poa_global"] for total in results.total_irrad)
    np.testing.assert_allclose(
        results.cell_temperature[0],
        expected(east, weather, **WM1) + east / 1000 * 3.0,
        rtol=1e-12,
    )
    np.testing.assert_allclose(
        results.cell_temperature[1],
        expected(west, weather, **{**WM1, "k": 0.05}),
        rtol=1e-12,
    )


def test_the_reference_irradiance_of_an_array_counts(weather):
    """deltaT is at irrad_ref, by default 1000 W/m², as in pvlib's sapm_cell."""
    parameters = {**WM1, "deltaT": 3.0, "irrad_ref": 800.0}
    plant = system(180, parameters=parameters)
    results = chain(plant, fem.DynamicCellTemperature("wm1")).run_model(weather).results
    sun = results.total_irrad["poa_global"]
    want = expected(sun, weather, **WM1) + sun / 800.0 * 3.0
    np.testing.assert_allclose(results.cell_temperature, want, rtol=1e-12)


def test_an_array_without_coefficients_is_named(weather):
    with pytest.raises(ValueError, match="wm1 needs k, d"):
        chain(system(180), fem.DynamicCellTemperature("wm1")).run_model(weather)


def test_an_array_needs_the_coefficients_that_it_needs_in_pvlib(weather):
    """pvlib infers no Faiman model of an array without its u0 and u1."""
    with pytest.raises(ValueError, match="Could not infer temperature model"):
        chain(system(180), "faiman")
    plant = system(180, parameters={"u0": 25.0})
    plant.arrays[0].name = "south"
    lack = (
        r"faiman needs u1 \(in pvlib 6.84\), capacity, and temperature_model_param"
        "eters of the array south hold u0; add them there, or give coefficients"
    )
    with pytest.raises(ValueError, match=lack):
        chain(plant, fem.DynamicCellTemperature("faiman", "balance")).run_model(weather)


@pytest.mark.parametrize("where", ["model", "array"])
def test_the_way_from_the_back_to_the_cells_is_gone_once(where, weather):
    """Together they would make the cells twice as much warmer than the back."""
    parameters = {**WM1, "deltaT": 3.0} if where == "array" else WM1
    own = {} if where == "array" else {"deltaT": 3.0}
    model = fem.DynamicCellTemperature("wm1", k_bs_c=0.003, **own)
    with pytest.raises(ValueError, match=r"deltaT = 3 K and k_bs_c = 0.003 K m²/W"):
        chain(system(180, parameters=parameters), model).run_model(weather)


@pytest.mark.parametrize("dynamics", ["steady", "ewm", "balance"])
def test_from_the_back_of_the_module_to_its_cells(weather, dynamics):
    """k_bs_c follows irradiance with the time constant of the back."""
    u0, u1, capacity = 25.0, 6.84, 9e3
    memory = {"steady": {}, "ewm": {"tau": 200.0}, "balance": {"capacity": capacity}}
    coefficients = {"u0": u0, "u1": u1, **memory[dynamics]}
    gappy = weather.copy()
    gappy.loc[gappy.index[700:760], "wind_speed"] = np.nan
    runs = {
        name: chain(
            system(180),
            fem.DynamicCellTemperature("faiman", dynamics, coefficients, **options),
        )
        .run_model(gappy)
        .results
        for name, options in {
            "back": {},
            "deltaT": {"deltaT": 3.0},
            "k_bs_c": {"k_bs_c": 0.003},
        }.items()
    }
    sun = runs["back"].total_irrad["poa_global"]
    back = runs["back"].cell_temperature
    np.testing.assert_allclose(
        runs["deltaT"].cell_temperature, back + 3.0 * sun / 1000, rtol=1e-12
    )
    smoothed = sun
    if dynamics == "ewm":
        smoothed = fem.ewm(sun, 200.0)
    elif dynamics == "balance":
        windy = gappy.dropna()
        taus = capacity / (u0 + u1 * windy["wind_speed"])
        smoothed = fem.ewm(sun[windy.index], taus).reindex(sun.index)
    want = (back + 0.003 * smoothed).where(back.notna())
    np.testing.assert_allclose(runs["k_bs_c"].cell_temperature, want, rtol=1e-12)


def test_a_steady_callable_has_no_memory(weather):
    faiman = pvlib.temperature.faiman
    steady = fem.DynamicCellTemperature(faiman, "steady", k_bs_c=0.003)
    results = chain(system(180), steady).run_model(weather).results
    sun = results.total_irrad["poa_global"]
    want = faiman(sun, weather["temp_air"], weather["wind_speed"]) + 0.003 * sun
    np.testing.assert_allclose(results.cell_temperature, want, rtol=1e-12)
    with pytest.raises(ValueError, match="tau = 300 s is given, and dynamics='steady"):
        given = fem.DynamicCellTemperature(faiman, "steady", {"tau": 300.0})
        chain(system(180), given).run_model(weather)
    for unknown in ("balance", "fast"):
        with pytest.raises(
            ValueError, match=f"'{unknown}' needs a steady model by name"
        ):
            fem.DynamicCellTemperature(faiman, unknown)


@pytest.mark.parametrize(
    ("column", "value"), [("wind_speed", "0 m/s"), ("temp_air", "20 °C")]
)
def test_what_pvlib_fills_in_is_said(weather, column, value):
    model = fem.DynamicCellTemperature("wm1", "ewm", WM1)
    with pytest.warns(UserWarning, match=f"{column} is {value} throughout"):
        chain(system(180), model).run_model(weather.drop(columns=column))
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        chain(system(90, 270), model).run_model(weather)


def test_drivers_that_the_chain_drops_are_carried_in_the_model(weather):
    """More times than the run has, in another order of columns: aligned."""
    wind = pd.concat([weather["wind_speed"].shift(freq="-2D"), weather["wind_speed"]])
    model = fem.DynamicCellTemperature("wm1", "ewm", WM1, wind_speed=2 * wind)
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        run = chain(system(180), model).run_model(weather.drop(columns="wind_speed"))
    doubled = weather.assign(wind_speed=2 * weather["wind_speed"])
    want = expected(run.results.total_irrad["poa_global"], doubled, **WM1)
    pd.testing.assert_series_equal(run.results.cell_temperature, want)


def test_a_callable_model_takes_its_own_driver(weather):
    longwave = 300.0 + 10.0 * np.sin(np.arange(len(weather)) / 100)
    longwave = pd.Series(longwave, weather.index)
    model = fem.DynamicCellTemperature(
        pvlib.temperature.faiman_rad,
        coefficients={"u0": 25.0, "u1": 6.84, "tau": 378.0},
        ir_down=longwave,
    )
    run = chain(system(180), model).run_model(weather)
    want = pvlib.temperature.faiman_rad(
        fem.ewm(run.results.total_irrad["poa_global"], 378.0),
        weather["temp_air"],
        fem.ewm(weather["wind_speed"], 378.0),
        ir_down=longwave,
    )
    np.testing.assert_allclose(run.results.cell_temperature, want, rtol=1e-12)


def test_a_driver_must_cover_the_run(weather):
    wind = weather["wind_speed"]
    for series, message in (
        (
            wind.iloc[5:],
            "misses 5 of 2,880 times of the run, first 2023-06-01",
        ),
        (wind.tz_localize(None), "times in zone None, the run in"),
        (pd.concat([wind[:1], wind]), "has the time 2023-06-01 .* twice"),
    ):
        model = fem.DynamicCellTemperature("wm1", "ewm", WM1, wind_speed=series)
        with pytest.raises(ValueError, match=message):
            chain(system(180), model).run_model(weather)


def test_an_unknown_driver_or_dynamics_is_refused(weather):
    with pytest.raises(
        ValueError, match="no effect uses rain; the effects use no further"
    ):
        fem.DynamicCellTemperature("wm1", rain=weather["ghi"])
    with pytest.raises(ValueError, match="driver wind_speed must be a Series"):
        fem.DynamicCellTemperature("wm1", wind_speed=3.0)
    with pytest.raises(ValueError, match="unknown dynamics 'fast'"):
        fem.DynamicCellTemperature("wm1", "fast")


def test_it_can_be_pickled_and_written_and_read(weather, tmp_path):
    record = datasets.synthetic(8, seed=2)
    fit = fem.fit_fem(*(record[name] for name in COLUMNS))
    fit.to_json(tmp_path / "fit.json")
    read = fem.DynamicCellTemperature.from_json(tmp_path / "fit.json", deltaT=3.0)
    model = fit.temperature_model(deltaT=3.0)
    for other in (pickle.loads(pickle.dumps(model)), read):
        one = chain(system(180), model).run_model(weather).results
        two = chain(system(180), other).run_model(weather).results
        pd.testing.assert_series_equal(one.cell_temperature, two.cell_temperature)
    assert "wm1" in repr(chain(system(180), model))


def test_a_cell_temperature_in_the_weather_wins(weather):
    """As with pvlib's own models."""
    given = weather.assign(cell_temperature=33.0)
    run = chain(system(180), fem.DynamicCellTemperature("wm1", "ewm", WM1))
    assert (run.run_model(given).results.cell_temperature == 33.0).all()
