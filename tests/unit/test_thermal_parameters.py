"""Thermal parameters in others' conventions: round trips, laws, limits and refusals."""

import warnings
from pathlib import Path

import numpy as np
import pandas as pd
import pvlib
import pytest
from click.testing import CliRunner
from conftest import DRIVERS
from hypothesis import given, strategies as st
from study_parameters import of_steady, page as study_page

import pvlib_fem as fem
from pvlib_fem import _cli as cli, datasets
from pvlib_fem._thermal_parameters.given_record import measured_of
from pvlib_fem._thermal_parameters.nmot import readings
from pvlib_fem._thermal_parameters.parameter_page import (
    PARTS,
    as_text,
    cells,
    conditions,
    mismatch_text,
    notes,
    page,
)
from pvlib_fem._thermal_parameters.parameter_rows import COLUMNS, Row, table_of
from pvlib_fem._thermal_parameters.steady_parameters import GIVEN, SUNS
from pvlib_fem._thermal_parameters.t98 import module_class_note, share_error
from pvlib_fem._thermal_parameters.unit_mass import prilliman_mean
from pvlib_fem._translation import USUAL_WINDS

HEIGHT = dict(wind_height=3.0, deltaT=3.0)
#: how each convention's parameters go into pvlib's function
PVLIB = {
    "faiman": pvlib.temperature.faiman,
    "sapm": pvlib.temperature.sapm_module,
    "noct_sam": pvlib.temperature.noct_sam,
    "pvsyst": pvlib.temperature.pvsyst_cell,
    "pvsyst, no wind": pvlib.temperature.pvsyst_cell,
    "sapm, 10 m": pvlib.temperature.sapm_module,
    "noct_sam, 10 m": pvlib.temperature.noct_sam,
    "pvsyst, 10 m": pvlib.temperature.pvsyst_cell,
}


@pytest.fixture(scope="module")
def fits():
    """A fit of each steady model to a made-up record of its own."""
    worlds = {
        "faiman": dict(u0=25.0, u1=6.84),
        "sapm": dict(a=-3.47, b=-0.0594),
        "wm1": dict(k=0.032, d=15.0),
        "wm2": dict(k=0.032, k_w=0.0015),
        "pvsyst": dict(u_c=20.0, u_v=4.0),
        "ross": dict(k=0.03),
    }
    found = {}
    for model, own in worlds.items():
        how = dict(capacity=15e3, bias=-2.0, model=model, dynamics="balance", **own)
        data = datasets.synthetic(12, 600, seed=3, **how)
        found[model] = fem.fit_fem(data, model=model, dynamics="balance")
    return found


@pytest.mark.parametrize("model", ["faiman", "sapm", "wm1", "wm2", "pvsyst", "ross"])
@pytest.mark.parametrize("with_bias", [True, False])
def test_pvlibs_functions_give_the_fits_temperatures(fits, model, with_bias):
    """In pvlib's own functions, within the stated mismatch, which is reached."""
    fit = fits[model]
    table = fit.thermal_parameters(fit_data(fit), with_bias=with_bias, **HEIGHT)
    winds = np.quantile(fit.record["wind_speed"], np.linspace(0.05, 0.95, 30))
    poa, wind = (grid.ravel() for grid in np.meshgrid(SUNS, winds))
    # at rest, so that the fit's own temperature is the steady one
    steady = fem.fem_temperature(
        poa, 20.0, wind, model=model, tau=1e-9, step=60.0, **steady_part(fit)
    )
    bias = fit.coefficients["bias"] if with_bias else 0.0
    for convention, function in PVLIB.items():
        rows = table.loc[convention]
        own = rows["value"].drop("deltaT", errors="ignore")
        seen = wind * (10.0 / 3.0) ** (1 / 7) if "10 m" in convention else wind
        cell = 3.0 * poa / 1000.0 if rows["of"].iloc[0] == "cell" else 0.0
        left = function(poa, 20.0, seen, **own) - (steady + bias + cell)
        assert np.abs(left).max() <= rows["mismatch"].iloc[0] * 1.0001 + 1e-6, (
            convention
        )
    noct = 20.0 + 800.0 * table.loc[("ross", "k"), "value"]  # all pvlibs take that
    left = pvlib.temperature.ross(poa, 20.0, noct) - (steady + bias)
    assert np.abs(left).max() <= table.loc[("ross", "k"), "mismatch"] + 1e-9


def fit_data(fit):
    names = (*DRIVERS, "temp_module")
    return pd.DataFrame({n: fit.record[n] for n in names}, fit.record.index)


def steady_part(fit):
    model = fit.thermal_model
    return model.steady_coefficients(model.completed(fit.coefficients))


@pytest.mark.parametrize("model", ["faiman", "sapm"])
def test_a_models_own_parameters_come_back_where_nothing_is_added(fits, model):
    """Without a bias the translation to itself is the fit, errors and all."""
    fit = fits[model]
    table = fit.thermal_parameters(with_bias=False)
    for name in fit.thermal_model.steady_model.parameters:
        row = table.loc[(model, name)]
        assert row["value"] == pytest.approx(fit.coefficients[name], rel=1e-6)
        assert row["stderr"] == pytest.approx(fit.stderr[name], rel=1e-3)
        interval = fit.confidence_interval()
        assert row["low"] == pytest.approx(interval["lower"][name], rel=1e-4)
    assert table.loc[(model, name), "mismatch"] < 1e-4


def test_pvsyst_is_faiman_by_what_is_absorbed(fits):
    """U_c = u0 · α (1 − η), to the digit, and at 10 m u_v falls by the power law."""
    how = dict(module_efficiency=0.21, absorptance=0.88, wind_height=2.0)
    table = fits["faiman"].thermal_parameters(**how, exponent=0.2)["value"]
    absorbed = 0.88 * (1 - 0.21)
    assert table["pvsyst", "u_c"] == pytest.approx(table["faiman", "u0"] * absorbed)
    assert table["pvsyst", "u_v"] == pytest.approx(table["faiman", "u1"] * absorbed)
    high = table["pvsyst", "u_v"] * (2.0 / 10.0) ** 0.2
    assert table["pvsyst, 10 m", "u_v"] == pytest.approx(high)
    assert table["pvsyst, 10 m", "u_c"] == pytest.approx(table["pvsyst", "u_c"])
    assert table["pvsyst, no wind", "u_v"] == 0.0


def test_sam_and_ross_meet_pvlibs_own_translation(fits):
    """pvlib's GenericLinearModel, an independent route, within two winds of its own."""
    fit = fits["faiman"]
    table = fit.thermal_parameters(with_bias=False)["value"]
    linear = pvlib.temperature.GenericLinearModel(0.2, 0.9)
    linear.use_faiman(table["faiman", "u0"], table["faiman", "u1"])
    theirs = linear.to_pvsyst()
    assert table["pvsyst", "u_c"] == pytest.approx(theirs["u_c"], rel=1e-6)
    assert table["pvsyst", "u_v"] == pytest.approx(theirs["u_v"], rel=1e-6)
    noct = linear.to_noct_sam()["noct"]
    assert table["noct_sam", "noct"] == pytest.approx(noct, abs=1.5)


def test_the_delta_method_is_the_scatter_of_draws(fits):
    """Errors by slopes against the spread of parameters of drawn coefficients."""
    fit = fits["wm1"]
    table = fit.thermal_parameters()
    random = np.random.default_rng(0)
    names = [*fit.covariance]
    mean = [fit.coefficients[name] for name in names]
    found = []
    for draw in random.multivariate_normal(mean, fit.covariance, 200):
        other = dict(zip(names, draw.tolist()))
        k, d, bias = (other[name] for name in ("k", "d", "bias"))
        nmot = 20.0 + 800.0 * (k * np.exp(-1.0 / d) + bias / 800.0)
        tau = other["capacity"] * k * np.exp(-3.0 / d)
        found.append((nmot, tau))
    nmot, tau = np.std(found, axis=0)
    row = table["stderr"]
    assert row["nmot", "of the fit"] == pytest.approx(nmot, rel=0.15)
    assert row["time constant", "at 3 m/s"] == pytest.approx(tau, rel=0.15)


def test_time_constants_are_those_of_the_dynamics(fits):
    """capacity · r_eq for a balance, one tau for ewm, none for a steady fit."""
    fit = fits["faiman"]
    u0, u1, capacity = (fit.coefficients[n] for n in ("u0", "u1", "capacity"))
    row = fit.thermal_parameters().loc["time constant", "value"]
    assert row["at 3 m/s"] == pytest.approx(capacity / (u0 + 3.0 * u1))
    data = fit_data(fit)
    ewm = fem.fit_fem(data, model="faiman", dynamics="ewm")
    row = ewm.thermal_parameters().loc["time constant"]
    assert row["value"].to_list() == pytest.approx([ewm.coefficients["tau"]] * 3)
    assert row["stderr"].to_list() == pytest.approx([ewm.stderr["tau"]] * 3)
    rest = fem.fit_fem(data, model="faiman", dynamics="steady")
    row = rest.thermal_parameters().loc["time constant"]
    assert row["value"].isna().all() and row["note"].str.contains("no memory").all()


def test_time_constants_of_means_follow_means():
    """Means of a fine record give the module's own, where samples' would be longer."""
    own = dict(u0=25.0, u1=6.84, capacity=14e3, bias=0.0)
    fine = datasets.synthetic(30, 60, seed=4, noise=0.05, **own)
    means = fine.resample("15min").mean()
    table = fem.fit_fem(means, model="faiman", dynamics="balance").thermal_parameters()
    true = own["capacity"] / (own["u0"] + 3.0 * own["u1"])
    found = table.loc[("time constant, means over 900 s", "at 3 m/s"), "value"]
    assert found == pytest.approx(true, rel=0.15)
    assert table.loc[("time constant", "at 3 m/s"), "value"] > 1.5 * true


def test_a_fit_from_a_file_says_what_it_lacks(fits, tmp_path):
    fit = fits["faiman"]
    fit.to_json(tmp_path / "fit.json", deltaT=2.5)
    again = fem.FemFit.from_json(tmp_path / "fit.json")
    pd.testing.assert_frame_equal(again.covariance, fit.covariance)
    table = again.thermal_parameters(wind_height=2.0)
    lacking = table[table["value"].isna()]
    assert {*lacking.index.get_level_values(0)} == {
        *("ross", "pvsyst, no wind", "nmot", "prilliman", "held-out error", "T98"),
        "time constant, means over 600 s",
    }
    needs = lacking["note"].str.contains("needs the record|needs a record")
    assert needs.all()
    assert table.loc[("sapm", "deltaT"), "value"] == 2.5
    whole = again.thermal_parameters(fit_data(fit), wind_height=2.0, deltaT=2.5)
    own = fit.thermal_parameters(wind_height=2.0, deltaT=2.5)
    pd.testing.assert_frame_equal(whole.drop(columns="note"), own.drop(columns="note"))


def test_every_row_is_whole(fits):
    """Unit, conditions, equation and source everywhere; a note where there is NaN."""
    table = fits["faiman"].thermal_parameters()
    assert [*table] == [*COLUMNS] and table.index.is_unique
    told = table[["unit", "of", "conditions", "equation", "source"]]
    assert (told != "").to_numpy().all()
    for lacks in ("value", "stderr"):
        assert (table.loc[table[lacks].isna(), "note"] != "").all()
    assert table.loc["pvsyst, 10 m", "note"].iloc[0].startswith("needs the height")
    known = table["stderr"].notna()
    assert (table["low"] <= table["value"])[known].all()
    assert (table["high"] >= table["value"])[known].all()


@pytest.mark.parametrize(
    ("how", "message"),
    [
        (dict(wind_height=0.0), "wind_height = 0.0 must be a height"),
        (dict(exponent=2.0), "exponent = 2.0"),
        (dict(module_efficiency=0.95), "must be a share below the absorptance"),
        (dict(absorptance=1.5), "absorptance = 1.5"),
        (dict(surface_tilt=200.0), "surface_tilt = 200.0"),
        (dict(deltaT=40.0), "deltaT = 40.0 K"),
        (dict(typical_year=pd.DataFrame({"ghi": [1.0]})), "no columns? poa_global"),
        (dict(data=pd.DataFrame({"poa_global": [1.0]})), "no columns? temp_air"),
    ],
)
def test_what_cannot_be_is_refused(fits, how, message):
    with pytest.raises(ValueError, match=message):
        fits["faiman"].thermal_parameters(**how)


def cooling(unit_mass, minutes=10):
    """pvlib's answer to a step from 50 to 20 °C in still air after some minutes."""
    times = pd.date_range("2024-01-01", periods=61, freq="1min")
    steady = pd.Series(np.where(np.arange(61) < 40, 50.0, 20.0), times)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = pvlib.temperature.prilliman(steady, 0.0 * steady, unit_mass)
    return float(found.iloc[40 + minutes])


def test_prilliman_is_unphysical_from_20_kg_on():
    """pvlib's own: it cools at 11.1; from 20 on the old weighs as much or more."""
    assert cooling(11.1) == pytest.approx(26.8, abs=0.05)
    assert cooling(30.0) == pytest.approx(44.0, abs=0.05)
    assert cooling(20.0) == pytest.approx(35.0, abs=0.01)  # the plain mean of 20 min


@given(st.floats(20.0, 1e3) | st.floats(-100.0, -1e-6))
def test_no_such_mass_is_taken(unit_mass):
    times = pd.date_range("2024-01-01", periods=30, freq="1min")
    flat = pd.Series(20.0, times)
    with pytest.raises(ValueError, match="Prilliman's rate is zero or negative"):
        prilliman_mean(flat, flat, unit_mass)


def under_prilliman(unit_mass, days=12, step=60, seed=0, noise=0.2):
    """A record whose module is Faiman's under Prilliman's mean."""
    data = datasets.synthetic(days, step, seed=seed, noise=0).tz_localize(None)
    steady = pvlib.temperature.faiman(*(data[name] for name in DRIVERS), 25.0, 6.84)
    random = np.random.default_rng(seed)
    error = random.normal(0.0, noise, len(data))
    return data.assign(
        temp_module=prilliman_mean(steady, data["wind_speed"], unit_mass) + error
    )


@pytest.mark.parametrize("unit_mass", [8.0, 15.0])
def test_a_unit_mass_is_recovered(unit_mass):
    data = under_prilliman(unit_mass)
    fit = fem.fit_fem(data, model="faiman", dynamics="balance")
    table = fit.thermal_parameters()
    row = table.loc[("prilliman", "unit_mass")]
    assert row["low"] <= unit_mass <= row["high"]
    assert row["stderr"] < 0.5
    left = table.loc["held-out error", "value"]
    assert left["prilliman"] < left["this fit"] < left["without memory"]
    assert left["prilliman"] == pytest.approx(0.2, rel=0.1)


@pytest.mark.parametrize(
    ("capacity", "said"), [(60e3, "slower than the model"), (2e3, "faster than")]
)
def test_a_module_beyond_the_model_has_no_unit_mass(capacity, said):
    """Never 20 kg/m² or more, with the reason."""
    own = dict(u0=25.0, u1=6.84, capacity=capacity, bias=0.0)
    data = datasets.synthetic(8, 120, seed=1, **own)
    table = fem.fit_fem(data, model="faiman", dynamics="balance").thermal_parameters()
    row = table.loc[("prilliman", "unit_mass")]
    assert np.isnan(row["value"]) and said in row["note"]
    assert np.isnan(table.loc[("held-out error", "prilliman"), "value"])
    assert table.loc[("held-out error", "this fit"), "value"] < 1.0


def test_long_steps_have_no_unit_mass(fits):
    hourly = datasets.synthetic(30, 3600, seed=2)
    fit = fem.fit_fem(hourly, model="faiman", dynamics="balance")
    table = fit.thermal_parameters()
    assert "use a finer record" in table.loc[("prilliman", "unit_mass"), "note"]
    by_iec = table.loc[("nmot", "by IEC 61853-2")]
    assert np.isnan(by_iec["value"])
    assert "filters over 5 and 10 min (steps of 3600 s" in by_iec["note"]


def steady_record(days=12, step=5.0, wind=3.0):
    """Clear days of a module at rest, in gusts that no filter minds."""
    times = pd.date_range(
        "2024-06-01", periods=int(days * 86400 / step), freq=pd.Timedelta(seconds=step)
    )
    hour = (times.hour + times.minute / 60 + times.second / 3600).to_numpy()
    poa = np.clip(1000.0 * np.sin((hour - 6.0) / 12.0 * np.pi), 0.0, None)
    ramp = wind + 2.5 * np.sin(np.arange(len(times)) * step / 40_000.0)
    air = 18.0 + 5.0 * np.sin((hour - 9.0) / 12.0 * np.pi)
    data = pd.DataFrame({"poa_global": poa, "temp_air": air, "wind_speed": ramp}, times)
    module = pvlib.temperature.faiman(poa, air, ramp, 26.0, 5.0)
    return data.assign(temp_module=module)


def test_nmot_by_the_procedure_recovers_a_module_at_rest():
    """u0, u1 and NMOT = 20 + 800 / (u0 + u1), with every countable filter met."""
    data = steady_record(step=5.0, days=11)
    fit = fem.fit_fem(data.iloc[::60], model="faiman", dynamics="steady")
    found = fit.thermal_parameters(data, surface_tilt=37.0).loc["nmot"]
    assert found.loc["u0 by IEC 61853-2", "value"] == pytest.approx(26.0, rel=2e-3)
    assert found.loc["u1 by IEC 61853-2", "value"] == pytest.approx(5.0, rel=2e-3)
    nmot = found.loc["by IEC 61853-2"]
    assert nmot["value"] == pytest.approx(20.0 + 800.0 / 31.0, abs=0.02)
    assert nmot["note"].startswith("not checked")
    assert found.loc["of the fit", "value"] == pytest.approx(nmot["value"], abs=0.05)


def test_nmot_by_the_procedure_has_a_range_that_holds_it(noise):
    """Under noise that differs from day to day, and with its unmet steps named."""
    data = steady_record(step=60.0, days=12)
    daily = np.repeat(noise(12, 0.3, seed=2), 1440)
    data["temp_module"] += daily + noise(len(data), 0.5, seed=3)
    fit = fem.fit_fem(data, model="faiman", dynamics="steady")
    row = fit.thermal_parameters(surface_tilt=30.0).loc[("nmot", "by IEC 61853-2")]
    assert row["low"] <= 20.0 + 800.0 / 31.0 <= row["high"]
    assert 0.02 < row["stderr"] < 0.3
    assert "readings every 5 s or less (here 60 s)" in row["note"]
    assert "tilt 37.5 ± 2.5° (here 30°)" in row["note"]
    assert "10 days" not in row["note"]


@pytest.mark.parametrize("zone", ["UTC", "Asia/Tokyo"])
def test_nmot_by_the_procedure_is_the_same_in_any_zone(zone):
    """In UTC a day of light in Albuquerque is on two dates."""
    data = datasets.synthetic(30, 60, noise=0.2)
    fit = fem.fit_fem(data.iloc[::10], model="faiman", dynamics="steady")
    here, there = (
        fit.thermal_parameters(one, surface_tilt=37.0).loc["nmot"]
        for one in (data, data.tz_convert(zone))
    )
    rows = ["by IEC 61853-2", "u0 by IEC 61853-2", "u1 by IEC 61853-2"]
    for name in ("value", "stderr"):
        assert list(there.loc[rows, name]) == pytest.approx(list(here.loc[rows, name]))


def filtered(change):
    """Readings of a record that pass the filters, after a change of it."""
    data = steady_record(days=1, step=60.0)
    data["wind_speed"] *= 0.4  # 2 m/s at noon
    change(data)
    fit = fem.fit_fem(steady_record(days=2, step=600.0), dynamics="steady")
    measured = measured_of(fit, data, lambda record, counts, holdout: counts & False)
    return readings(measured)[0]


def put(column, value):
    """A change of one minute at noon."""

    def change(data):
        data.loc["2024-06-01 12:00", column] = value

    return change


def test_the_filters_take_ten_minutes_after_a_gust_a_calm_and_a_cloud():
    noon = slice("2024-06-01 12:00", "2024-06-01 12:09")
    whole = filtered(lambda data: None)
    assert len(whole.loc[noon]) == 10 and (whole["wind"] >= 1.0).all()
    assert (whole["loss"] > 0.0).all()
    for column, value in (
        ("wind_speed", 14.0),
        ("wind_speed", 0.1),
        ("poa_global", 700.0),
    ):
        less = filtered(put(column, value))
        assert less.loc[noon].empty, (column, value)
        assert len(less.loc["2024-06-01 11:50":"2024-06-01 11:59"]) == 10


def test_t98_is_what_two_percent_of_the_hours_exceed():
    year = datasets.synthetic(365, 3600, seed=5)
    fit = fem.fit_fem(year, model="faiman", dynamics="balance")
    table = fit.thermal_parameters(typical_year=year).loc["T98"]
    row = table.loc["of the record"]
    above = (year["temp_module"] > row["value"]).mean()
    assert above == pytest.approx(0.02, abs=0.001)
    assert row["low"] < row["value"] < row["high"] and row["stderr"] > 0.0
    without = fit.thermal_parameters(typical_year=year, with_bias=False)
    fall = table["value"] - without.loc["T98", "value"]
    assert fall["of a typical year"] == pytest.approx(fit.coefficients["bias"])
    assert fall["of the record"] == 0.0
    typical = table.loc["of a typical year"]
    assert typical["value"] == pytest.approx(row["value"], abs=0.5)
    assert 0.0 < typical["stderr"] < row["stderr"]


def test_the_error_of_t98_is_larger_where_hours_stay_alike(noise):
    """Weeks are the draws: hours that repeat tell no more than their weeks."""
    dates = np.repeat(np.arange(364), 24)
    apart = np.random.default_rng(0).uniform(size=len(dates)) < 0.02
    alike = np.repeat(np.random.default_rng(0).uniform(size=52) < 0.02, 7 * 24)
    alike[:168] = True
    binomial = np.sqrt(0.02 * 0.98 / len(dates))
    assert share_error(apart, dates)[0] == pytest.approx(binomial, rel=0.35)
    assert share_error(alike, dates)[0] > 5.0 * binomial
    assert np.isnan(share_error(apart[:24], dates[:24])).all()


def test_levels_of_iec_ts_63126():
    assert "Level 1" in module_class_note(70.1) and "Level 2" in module_class_note(80.1)
    assert "no level" in module_class_note(70.0) and "beyond" in module_class_note(95.0)


def test_a_record_without_nights_has_no_t98():
    """Of days alone 2 % of the rows are 1 % of the hours."""
    year = datasets.synthetic(120, 1800, seed=5)
    day = year[year["poa_global"] > 0.0]
    table = fem.fit_fem(day, model="faiman", dynamics="steady").thermal_parameters()
    row = table.loc[("T98", "of the record")]
    assert np.isnan(row["value"]) and "nights included" in row["note"]


@pytest.mark.parametrize("nights", ["absent", "missing"])
def test_weather_without_nights_has_no_t98(nights):
    """T98 of 98 % of the days would be that of 99 % of the hours."""
    year = datasets.synthetic(365, 3600, seed=5)
    fit = fem.fit_fem(year, model="faiman", dynamics="steady")
    sunny = year["poa_global"] > 0.0
    day = year[sunny] if nights == "absent" else year.where(sunny)
    table = fit.thermal_parameters(typical_year=day)
    row = table.loc[("T98", "of a typical year")]
    assert np.isnan(row["value"]) and "nights included" in row["note"]


def test_months_of_a_typical_year_may_be_of_different_years():
    year = datasets.synthetic(365, 3600, start="2022-01-01", seed=5)
    fit = fem.fit_fem(year, model="faiman", dynamics="steady")
    months = [part for _, part in year.groupby(year.index.month)]
    for number, part in enumerate(months):
        part.index += pd.DateOffset(years=3 * (number % 4))
    mixed = pd.concat(months).sort_index()
    where = ("T98", "of a typical year")
    found, mixed = (
        fit.thermal_parameters(typical_year=one).loc[where] for one in (year, mixed)
    )
    assert mixed["value"] == pytest.approx(found["value"], abs=0.01)
    assert mixed["note"] == found["note"]


def test_the_mean_of_effects_is_added_with_the_record(plant, tmp_path):
    """A sky that cools: the parameters follow the temperatures of a plain fit."""
    names = [*DRIVERS, "temp_module", "longwave_down"]
    fit = fem.fit_fem(plant[names], model="faiman", effects="sky_radiation")
    fit.to_json(tmp_path / "fit.json")
    alone = fem.FemFit.from_json(tmp_path / "fit.json").thermal_parameters(
        with_bias=False
    )
    assert "; without sky_radiation" in alone["conditions"].iloc[0]
    assert alone.loc[("faiman", "u0"), "value"] == pytest.approx(fit.coefficients["u0"])
    assert "give data to add their mean" in alone.loc[("faiman", "u0"), "note"]
    table = fit.thermal_parameters()
    assert "; sky_radiation, in the mean " in table["conditions"].iloc[0]
    plain = fem.fit_fem(plant[names], model="faiman").thermal_parameters()
    nmot = table.loc[("nmot", "of the fit")]
    assert nmot["value"] == pytest.approx(plain.loc[nmot.name, "value"], abs=0.3)
    assert nmot["stderr"] > 0.0
    assert table.loc[("held-out error", "this fit"), "value"] < 0.5
    again = fit.thermal_parameters(plant[names])
    assert again.loc[("held-out error", "this fit"), "value"] == pytest.approx(
        table.loc[("held-out error", "this fit"), "value"]
    )
    with pytest.raises(ValueError, match="no column longwave_down"):
        fit.thermal_parameters(plant[names[:4]])


def test_a_short_record_says_that_its_t98_is_of_no_year(fits):
    table = fits["faiman"].thermal_parameters()
    assert "of 12 days and not of a year" in table.loc[("T98", "of the record"), "note"]


def test_fits_without_errors_say_so(week):
    """Four fitted days give no errors; values remain, and the notes say why."""
    fit = fem.fit_fem(week, model="faiman", dynamics="balance")
    table = fit.thermal_parameters()
    row = table.loc[("faiman", "u0")]
    assert np.isfinite(row["value"]) and np.isnan(row["stderr"])
    assert "the fit has none" in row["note"]


def test_the_unit_mass_of_the_measured_week(week):
    """On days that neither saw: prilliman with its mass against the fit."""
    out = pd.Series(week.index.day_of_week >= 5, week.index)
    fit = fem.fit_fem(week, model="faiman", dynamics="balance", holdout=out)
    table = fit.thermal_parameters()
    row = table.loc[("prilliman", "unit_mass")]
    assert 0.0 < row["low"] < row["value"] < row["high"] <= 20.0
    left = table.loc["held-out error", "value"]
    assert left["prilliman"] < 0.5 * left["without memory"]
    assert left["this fit"] < left["prilliman"]


GUIDE = Path(__file__).parents[2] / "docs" / "guide" / "thermal_parameters.md"


#: records for which the guide says that the height of the anemometer is unknown
HIGH = [
    *[("sapm, 10 m", name) for name in ("a", "b", "deltaT")],
    *[("pvsyst, 10 m", name) for name in ("u_c", "u_v")],
    ("noct_sam, 10 m", "noct"),
]


def guide_lines(table):
    """Rows as the guide has them in Markdown."""
    for name, row in table.iterrows():
        value, error, span = cells(row)
        value = f"{value} ± {error}" if error != "–" else value
        numbers = f"{value} | {span} | {row['unit']} | {mismatch_text(row)}"
        yield f"| {name[0]} | `{name[1]}` | {numbers} |"


def test_the_guide_has_the_tables_of_both_records(bolzano, week):
    """Each line that the guide prints is the result of the records."""
    out = pd.Series(week.index.day_of_week >= 5, week.index)
    fits = {"bolzano": (bolzano, None), "week": (week, out)}
    tables = {
        name: fem.fit_fem(
            data, model="faiman", dynamics="balance", holdout=holdout
        ).thermal_parameters(deltaT=3.0)
        for name, (data, holdout) in fits.items()
    }
    few = ["nmot", "prilliman", "held-out error", "time constant"]
    few.append("time constant, means over 60 s")
    text = GUIDE.read_text(encoding="utf-8")
    for table in (tables["bolzano"], tables["week"].loc[few]):
        rows = table[table["note"] != GIVEN]
        lines = [*guide_lines(rows[~rows.index.isin(HIGH)])]
        assert lines
        for line in lines:
            assert line in text
        for line in {*rows["note"]} - {""}:
            assert line in text or "wind_height" in line
        assert conditions(table) in text


def test_bolzano_has_its_table(bolzano):
    """Eight hourly years: NMOT, T98 and PVsyst's; hours give no unit mass."""
    fit = fem.fit_fem(bolzano, model="faiman", dynamics="balance")
    table = fit.thermal_parameters(wind_height=3.0)
    value = table["value"]
    assert 40.0 < value["nmot", "of the fit"] < 55.0
    row = table.loc[("T98", "of the record")]
    assert row["low"] < value["T98", "of a typical year"] < row["high"]
    assert np.isnan(value["prilliman", "unit_mass"])
    assert np.isnan(value["nmot", "by IEC 61853-2"])
    usual = f"wind {USUAL_WINDS[0]:.1f} to {USUAL_WINDS[-1]:.1f} m/s"
    assert usual not in table["conditions"].iloc[0]  # its own are taken


def test_ranges_hold_the_truth_of_worlds():
    """A small part of docs/study_parameters.md: 95 % ranges of a few worlds."""
    rows = [row for seed in range(7) for row in of_steady(seed, 21, 900)]
    table = pd.DataFrame(rows)
    assert table["held"].mean() >= 0.85
    assert table.groupby("convention")["held"].mean().min() > 0.6
    text = "\n".join(study_page(table, 7, 0))
    assert f"{100 * table['held'].mean():.1f} % of {len(table)} ranges" in text


def test_a_note_names_the_parameters_of_each_convention_that_have_it():
    """Time constants are shorter than the step at some winds only."""
    rough = [
        ("time constant", "at 5 m/s"),
        ("means", "at 1 m/s"),
        ("means", "at 5 m/s"),
    ]
    rows = [Row(of, name, 1.0, "s", note="rough") for of, name in rough]
    rows.insert(0, Row("time constant", "at 1 m/s", 9.0, "s"))
    said = "time constant (at 5 m/s); means (at 1 m/s, at 5 m/s)"
    assert [*notes(table_of(rows))] == [(said, "rough")]
    both = table_of(
        Row(of, "noct", 1.0, "°C", note="given") for of in ("sam", "pvsyst")
    )
    assert [*notes(both)] == [("sam; pvsyst (noct)", "given")]


def test_the_page_and_the_text_have_every_row(fits):
    """Each parameter in one part of the page, each note and source on it."""
    table = fits["faiman"].thermal_parameters(**HEIGHT)
    text, html = as_text(table), page(table, "A <plant>")
    names = table.index.get_level_values(0)
    assert len(table)
    for name in names.unique():
        assert sum(name.startswith(begins) for begins, _ in PARTS.values()) == 1
        assert f"\n{name} " in text
    assert html.count("<tr>") == len(table) + len(PARTS)
    assert "A &lt;plant&gt;" in html and "<script" not in html
    for source in table["source"].unique():
        assert source.replace("'", "&#39;") in html
    assert " ".join(table["conditions"].iloc[0].split()) in " ".join(text.split())


@pytest.fixture
def on_disk(fits, tmp_path):
    fits["faiman"].to_json(tmp_path / "fit.json")
    fit_data(fits["faiman"]).tz_localize(None).to_csv(tmp_path / "log.csv")
    return tmp_path


def call(*arguments):
    return CliRunner().invoke(cli.main, ["parameters", *map(str, arguments)])


def test_the_command_gives_the_table_of_a_file(fits, on_disk):
    out, html = on_disk / "table.csv", on_disk / "page.html"
    result = call(
        *(on_disk / "fit.json", on_disk / "log.csv"),
        *("--wind-height", 3, "--deltaT", 3, "--csv", out, "--report", html),
    )
    assert result.exit_code == 0, result.output
    table = fits["faiman"].thermal_parameters(**HEIGHT)
    written = pd.read_csv(out, index_col=[0, 1])
    np.testing.assert_allclose(written["value"], table["value"])
    # pandas 2.0 reads the last digit of some numbers otherwise, which a search enlarges
    np.testing.assert_allclose(written["stderr"], table["stderr"], rtol=1e-4)
    assert "<title>fit.json · Thermal parameters</title>" in html.read_text("utf-8")


def test_the_command_takes_the_weather_of_a_year(on_disk):
    year = datasets.synthetic(365, 3600, seed=8)[[*DRIVERS]].tz_localize(None)
    year.to_csv(on_disk / "year.csv")
    result = call(on_disk / "fit.json", "--typical-year", on_disk / "year.csv")
    assert result.exit_code == 0, result.output
    assert "by the fit, of the weather that was given" in result.output


def test_the_command_says_what_it_lacks_without_the_record(on_disk):
    result = call(on_disk / "fit.json")
    assert result.exit_code == 0, result.output
    assert "needs the record" in " ".join(result.output.split())
    assert "Holds for" not in result.output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("log.csv",), "is no JSON"),
        (("fit.json", "--report", "page.txt"), "has to end with .html"),
        (("fit.json", "--csv", "fit.json"), "would overwrite a file"),
        (("fit.json", "--efficiency", "0.95"), "below the absorptance"),
        (("fit.json", "--holdout", "2023-06-01"), "--holdout is of FILE"),
        (("fit.json", "--typical-year", "fit.json"), "fit.json"),
    ],
)
def test_the_command_refuses_in_one_line(on_disk, monkeypatch, arguments, message):
    monkeypatch.chdir(on_disk)
    result = call(*arguments)
    assert result.exit_code == 1
    assert message in result.output and "Traceback" not in result.output


def test_days_are_held_out_of_a_given_record_alone(fits):
    fit = fits["faiman"]
    data = fit_data(fit)
    with pytest.raises(ValueError, match="holdout is for data"):
        fit.thermal_parameters(holdout=pd.Series(True, data.index))
    out = pd.Series(data.index.day == 3, data.index)
    left = fit.thermal_parameters(data, holdout=out).loc["held-out error"]
    residual = fit.residual[out & (fit.record["poa_global"] > 20.0)]
    expected = np.sqrt((residual**2).mean())
    assert left.loc["this fit", "value"] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("wind", [0.0, 2.0])
def test_a_mass_needs_no_wind_that_varies(wind):
    """A constant wind leaves one coefficient to know, as the model without wind."""
    data = datasets.synthetic(days=14, step=600, seed=1).assign(wind_speed=wind)
    found = []
    for model in ("faiman", "ross"):
        fit = fem.fit_fem(data, model=model, dynamics="balance")
        mass = fit.thermal_parameters().loc[("prilliman", "unit_mass")]
        found.append([mass["value"], mass["stderr"]])
    assert found[0] == pytest.approx(found[1], rel=1e-3)
    assert np.isfinite(found).all()
