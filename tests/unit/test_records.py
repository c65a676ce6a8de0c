"""What a record may be: every bad one is refused by name, time and remedy."""

import numpy as np
import pandas as pd
import pytest
from conftest import COLUMNS, DRIVERS, measured

import pvlib_fem as fem
from pvlib_fem import datasets
from pvlib_fem._record.checks import dates_of


@pytest.fixture(scope="module")
def good():
    return datasets.synthetic(days=8, seed=2)


def fit(data, **options):
    return fem.fit_fem(*(data[name] for name in COLUMNS), **options)


def swapped(data):
    order = np.arange(len(data))
    order[[100, 101]] = [101, 100]
    return data.iloc[order]


def column(name, change):
    """A record with one column changed, as a test that names it."""

    def changed(data):
        data = data.copy()
        data[name] = change(data[name])
        return data

    return changed


def text(series):
    series = series.astype(object)
    series.iloc[7] = "n/a"
    return series


UNUSABLE = {
    "unsorted": (
        swapped,
        r"poa_global is not sorted: 2023-06-01 01:40:00-07:00 \(row 101\) comes after "
        r"2023-06-01 01:41:00-07:00; use data.sort_index\(\)",
    ),
    "duplicate": (
        lambda d: d.iloc[[0, 1, 2, 2, *range(3, len(d))]],
        r"poa_global has the time 2023-06-01 00:02:00-07:00 twice \(row 3\); keep one",
    ),
    "no times": (
        lambda d: d.reset_index(drop=True),
        "poa_global has no DatetimeIndex but a RangeIndex; set one with pd.to_datetime",
    ),
    "a time that is none": (
        lambda d: d.set_axis(d.index.where(np.arange(len(d)) != 5)),
        r"poa_global has no time \(NaT\) at row 5; drop such rows",
    ),
    "all NaN": (
        column("wind_speed", lambda s: s * np.nan),
        "wind_speed holds no value from 2023-06-01 00:00:00-07:00 to .*; check the",
    ),
    "text": (
        column("temp_air", text),
        r"temp_air holds 'n/a' at 2023-06-01 00:07:00-07:00 \(row 7\), which is not a "
        "number; clean the column",
    ),
    "infinite": (
        column("temp_air", lambda s: s.where(np.arange(len(s)) != 3, np.inf)),
        r"temp_air is infinite at 2023-06-01 00:03:00-07:00 \(row 3\); replace it",
    ),
}


@pytest.mark.parametrize("case", UNUSABLE)
def test_an_unusable_record_is_refused(good, case):
    spoil, message = UNUSABLE[case]
    with pytest.raises(ValueError, match=message):
        fit(spoil(good))


@pytest.mark.parametrize(
    "case", [name for name in UNUSABLE if name not in ("all NaN",)]
)
@pytest.mark.parametrize(
    ("function", "memory"),
    [(fem.fem_temperature, {"tau": 378.0}), (fem.heat_balance, {"capacity": 12e3})],
)
def test_the_dynamic_functions_refuse_it_too(good, case, function, memory):
    spoil, message = UNUSABLE[case]
    spoiled = spoil(good)
    with pytest.raises(ValueError, match=message.split(";")[0]):
        function(
            *(spoiled[name] for name in DRIVERS), model="faiman", u0=25, u1=6, **memory
        )


def test_an_index_of_another_series_is_refused(good):
    other = good["temp_module"].shift(freq="1min")
    with pytest.raises(
        ValueError,
        match="temp_module and poa_global have different indexes: they part at "
        "2023-06-01 00:00:00-07:00; align them first",
    ):
        fem.fit_fem(*(good[name] for name in DRIVERS), other)
    with pytest.raises(ValueError, match=r"the lengths differ: \{'poa_global': 11520"):
        fem.fit_fem(*(good[name] for name in DRIVERS), other.iloc[:-5])


def test_naive_and_aware_times_are_never_mixed(good):
    naive = good["temp_module"].tz_localize(None)
    with pytest.raises(
        ValueError,
        match=r"poa_global have zone Etc/GMT\+7, those of temp_module None; give both",
    ):
        fem.fit_fem(*(good[name] for name in DRIVERS), naive)


def test_times_without_a_zone_are_fine_for_a_fit(good):
    aware, naive = fit(good), fit(good.tz_localize(None))
    assert naive.coefficients == aware.coefficients
    assert naive.stderr == pytest.approx(aware.stderr, nan_ok=True)


def test_a_column_must_be_a_series(good):
    with pytest.raises(ValueError, match="temp_air is a float; a fit needs Series"):
        fem.fit_fem(good["poa_global"], 20.0, good["wind_speed"], good["temp_module"])


def test_an_empty_record_is_refused(good):
    with pytest.raises(ValueError, match="poa_global is empty"):
        fit(good.iloc[:0])


def test_numbers_in_a_column_of_objects_are_numbers(good):
    with_none = column(
        "temp_air", lambda s: s.astype(object).where(np.arange(len(s)) != 5, None)
    )
    fitted = fit(with_none(good))
    assert fitted.record.missing["temp_air"] == 1


def faulty(data):
    """With gaps, values that cannot be, a night below zero and a sensor that stands."""
    data = data.copy()
    rows = {"temp_air": 300.0, "wind_speed": np.nan, "temp_module": -327.67}
    for place, (name, value) in enumerate(rows.items()):
        data.iloc[900 * place + 400, data.columns.get_loc(name)] = value
    data.loc[data["poa_global"] < 1.0, "poa_global"] = -2.0
    data.iloc[5000:5600, data.columns.get_loc("temp_module")] = 21.0
    return data


@pytest.mark.parametrize("dynamics", ["ewm", "balance"])
@pytest.mark.parametrize("days", [20, 40])  # by numpy, and by the compiled loops
def test_single_precision_is_read_as_it_is_and_summed_in_double(days, dynamics):
    narrow = faulty(datasets.synthetic(days, seed=2)[list(COLUMNS)]).astype("float32")
    own = fit(narrow, dynamics=dynamics)
    wide = fit(narrow.astype(float), dynamics=dynamics)
    assert wide.coefficients
    for name, value in wide.coefficients.items():
        assert own.coefficients[name] == pytest.approx(value, rel=1e-9)
        assert own.stderr[name] == pytest.approx(wide.stderr[name], rel=1e-6)
    assert own.summary == wide.summary
    pd.testing.assert_frame_equal(own.scores, wide.scores, rtol=1e-12)
    pd.testing.assert_series_equal(own.residual, wide.residual, rtol=0, atol=1e-9)
    # half of the memory, and none of the columns is held twice
    kept = own.record.inputs.columns.given
    assert {values.dtype for values in kept.values()} == {np.dtype("float32")}
    assert own.record["temp_module"].dtype == float


def test_a_loop_on_single_precision_says_the_same(good):
    narrow = datasets.synthetic(60, seed=3).astype("float32")
    assert str(fem.close_loop(narrow)) == str(fem.close_loop(narrow.astype(float)))


def test_nullable_numbers_are_numbers(good):
    nullable = column("temp_air", lambda s: s.astype("Float64"))(good)
    nullable.iloc[5, nullable.columns.get_loc("temp_air")] = pd.NA
    assert fit(nullable).record.missing["temp_air"] == 1


@pytest.mark.parametrize("unit", ["s", "ns"])
@pytest.mark.parametrize(
    "zone", [None, "UTC", "Etc/GMT+7", "+05:30", "Europe/Rome", "America/Caracas"]
)
def test_the_day_of_a_row_is_that_of_its_clock(zone, unit):
    """Of any zone, over changes to and from daylight-saving time, before 1970 too."""
    for start in ("1969-12-30", "2016-04-29", "2023-03-25", "2023-10-28"):
        times = pd.date_range(start, periods=400, freq="13min", tz=zone).as_unit(unit)
        clock = times.strftime("%Y-%m-%d").to_numpy().astype("datetime64[D]")
        assert dates_of(times).tolist() == clock.astype(int).tolist()


def test_nan_and_gaps_stay_where_they_are(good):
    holes = good.copy()
    holes.iloc[500:510, holes.columns.get_loc("wind_speed")] = np.nan
    holes.iloc[3000:3005, holes.columns.get_loc("poa_global")] = np.nan
    holes.iloc[5000:5005, holes.columns.get_loc("temp_module")] = np.nan
    holes = holes.drop(holes.index[7000:7100])
    for dynamics in ("steady", "ewm", "balance"):
        fitted = fit(holes, dynamics=dynamics)
        modelled = fitted.predict(*(holes[name] for name in DRIVERS))
        missing = holes[list(DRIVERS)].isna().any(axis=1)
        assert (modelled.isna() == missing).all()
        missing |= holes["temp_module"].isna()
        assert (fitted.residual.isna() == missing).all()
        pd.testing.assert_series_equal(
            fitted.residual,
            holes["temp_module"] - modelled,
            check_names=False,
            check_freq=False,
        )
    assert fitted.record.missing == {
        "poa_global": 5,
        "temp_air": 0,
        "wind_speed": 10,
        "temp_module": 5,
    }
    assert "missing: poa_global 5, wind_speed 10, temp_module 5" in str(fitted)


@pytest.mark.parametrize("dynamics", ["ewm", "balance"])
def test_jittered_times_are_fitted_as_they_are(good, dynamics):
    """Half of the rows dropped at random: uneven steps, and the truth comes back."""
    kept = good[np.random.default_rng(0).uniform(size=len(good)) < 0.5]
    drivers = tuple(kept[name] for name in DRIVERS)
    if dynamics == "ewm":
        truth = dict(k=0.035, d=10.0, tau=378.0, bias=-2.0)
        module = fem.fem_temperature(*drivers, **truth)
    else:
        truth = dict(k=0.035, d=10.0, capacity=12e3, bias=-2.0)
        module = fem.heat_balance(*drivers, model="wm1", **truth)
    fitted = fem.fit_fem(*drivers, module, dynamics=dynamics)
    assert fitted.coefficients == pytest.approx(truth, rel=1e-6)


def test_negative_night_irradiance_is_clipped_and_counted(good):
    offset = column("poa_global", lambda s: s.where(s > 0, -3.0))(good)
    clipped, plain = fit(offset), fit(good)
    assert clipped.record.clipped == (good["poa_global"] <= 0).sum()
    assert clipped.coefficients == plain.coefficients
    assert f"clipped to 0: {clipped.record.clipped:,}" in str(clipped)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("poa_global", 2001.0),
        ("temp_air", -60.1),
        ("temp_air", 100.1),
        ("temp_module", 101.0),
        ("wind_speed", -0.1),
        ("wind_speed", 61.0),
    ],
)
def test_impossible_values_are_not_used_and_counted(good, name, value):
    rows = slice(700, 712)
    spoiled, holes = good.copy(), good.copy()
    spoiled.iloc[rows, good.columns.get_loc(name)] = value
    holes.iloc[rows, good.columns.get_loc(name)] = np.nan
    fitted = fit(spoiled)
    assert fitted.coefficients == fit(holes).coefficients
    assert fitted.record.impossible[name] == 12
    assert f"impossible, not used: {name} 12" in str(fitted)


def test_a_record_that_is_mostly_impossible_is_refused(good):
    spoiled = column("wind_speed", lambda s: s.where(np.arange(len(s)) % 4 > 0, -9.0))
    with pytest.raises(
        ValueError,
        match=r"25 % of wind_speed is physically impossible \(outside 0 … 60 m/s\), "
        "first -9 at 2023-06-01 00:00:00-07:00; check its unit and sensor",
    ):
        fit(spoiled(good))


def fahrenheit(series):
    return series * 1.8 + 32


UNITS = {
    "irradiance in kW/m²": (
        {"poa_global": lambda s: s / 1000},
        r"poa_global looks to be in kW/m²: its largest values are",
    ),
    "module in °F": (
        {"temp_module": fahrenheit},
        r"temp_module looks to be in °F: at night it is \d+ above air",
    ),
    "module in K": (
        {"temp_module": lambda s: s + 273.15},
        r"temp_module looks to be in K: at night it is \d+ above air",
    ),
    "air in °F": (
        {"temp_air": fahrenheit},
        r"temp_air looks to be in °F: at night it is \d+ above module",
    ),
    "both in °F": (
        {"temp_air": fahrenheit, "temp_module": fahrenheit},
        r"temp_air and temp_module look to be in °F: the air reaches \d+",
    ),
    "wind in km/h": (
        {"wind_speed": lambda s: s * 3.6},
        r"wind_speed looks to be in km/h: 5 % of it is above \d+",
    ),
}


@pytest.mark.parametrize("case", UNITS)
@pytest.mark.parametrize("source", ["synthetic", "measured"])
def test_another_unit_is_recognised(good, request, case, source):
    data = good if source == "synthetic" else request.getfixturevalue("week")
    changes, message = UNITS[case]
    data = data.assign(**{name: change(data[name]) for name, change in changes.items()})
    with pytest.raises(ValueError, match=message + r".*give check_units=False"):
        fit(data)


@pytest.mark.parametrize("latitude", [20.0, 35.0, 55.0])
@pytest.mark.parametrize("start", ["2023-01-05", "2023-07-01"])
@pytest.mark.parametrize(
    "coefficients",
    [
        dict(model="ross", k=0.012, tau=378.0),
        dict(model="ross", k=0.056, tau=378.0),
        dict(model="sapm", a=-2.81, b=-0.0455, tau=900.0),
        dict(model="faiman", u0=25.0, u1=0.0, tau=378.0),
        dict(model="wm1", k=0.042, d=3.0, tau=200.0, bias=-6.0),
    ],
)
def test_the_right_unit_is_never_refused(latitude, start, coefficients):
    """From a tracker's k = 12 mK/(W/m²) to SAPM's insulated back at 60."""
    data = datasets.synthetic(
        7, start=start, latitude=latitude, dynamics="ewm", **coefficients
    )
    measured(*(data[name] for name in COLUMNS))


def test_the_windy_measured_day_keeps_its_units(day):
    """Its wind reaches 13 m/s."""
    measured(*(day[name] for name in COLUMNS))


def test_units_can_be_insisted_on(good):
    storm = column("wind_speed", lambda s: s * 3.6)(good)
    assert fit(storm, check_units=False).converged


def test_scalars_are_for_steady_functions_only():
    assert fem.wm1(1000.0, 20.0, 0.0, k=0.03, d=10) == 50.0
    with pytest.raises(ValueError, match="depends on what it went through before"):
        fem.ewm(5.0, 378.0, step=60)


@pytest.mark.parametrize("step", [0, -60, np.nan, np.inf, "1min"])
def test_a_step_is_a_positive_number(step):
    with pytest.raises(ValueError, match="positive number of seconds"):
        fem.ewm([0.0, 1.0], 378.0, step=step)


def test_plain_times_are_checked_too():
    with pytest.raises(ValueError, match=r"times is not sorted: 0 \(row 2\)"):
        fem.ewm([0.0, 1.0, 2.0], 378.0, times=[0, 60, 0])
    with pytest.raises(ValueError, match="times has 2 entries for 3 samples"):
        fem.ewm([0.0, 1.0, 2.0], 378.0, times=[0, 60])
    series = pd.Series([0.0, 1.0], pd.date_range("2024-05-01", periods=2, freq="h"))
    with pytest.raises(ValueError, match="brings its own times; drop the argument"):
        fem.ewm(series, 378.0, times=[0, 60])
    with pytest.raises(ValueError, match="no DatetimeIndex but a RangeIndex"):
        fem.ewm(series.reset_index(drop=True), 378.0)
    with pytest.raises(ValueError, match="values has 2 dimensions; give one column"):
        fem.ewm(series.to_frame(), 378.0)
