"""Awkward columns, names and machines end no call, and nothing is lost in silence."""

import decimal
import pickle
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from conftest import COLUMNS
from pvlib.location import Location
from threadpoolctl import threadpool_info, threadpool_limits

import pvlib_fem as fem
from pvlib_fem import datasets, simulator
from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._loop.preparation.leaks import leaks
from pvlib_fem._loop.threads import one_blas_thread
from pvlib_fem.drivers import DERIVED, MODELLED
from pvlib_fem.effects._effect import Effect, Parameter, Terms
from pvlib_fem.quality._noon import solar_noon_shift
from pvlib_fem.simulator import PHYSICS, RHINE

RHEIN = Location(RHINE.latitude, RHINE.longitude, tz=RHINE.tz)


@pytest.fixture(scope="module")
def record():
    """Seventy days that count, with rain and humidity."""
    data = simulator.record(effects=PHYSICS, days=70, step=1800, start="2023-05-01")
    data.attrs = {}
    return data.drop(columns=["snow_depth", "longwave_down"])


@pytest.fixture(scope="module")
def usual(record):
    return record[list(COLUMNS)]


@pytest.fixture(scope="module")
def plain(usual):
    """The loop on the four columns alone."""
    return fem.close_loop(usual)


def fit(data, **options):
    return fem.fit_fem(*(data[name] for name in COLUMNS), **options)


# names of columns


@pytest.mark.parametrize("name", ["sky_deficit", "wetness", "film_vapour", "temp_base"])
def test_a_column_called_like_a_derived_driver_takes_no_place(record, name):
    noise = np.random.default_rng(0).normal(size=len(record))
    found = fem.close_loop(record.assign(**{name: noise}))
    want = fem.close_loop(record)
    assert found.effects == want.effects
    pd.testing.assert_frame_equal(found.table, want.table)
    (note,) = set(found.notes) - set(want.notes)
    assert note.startswith(f"{name} is the name of a driver that is computed here")
    ranking = fem.rank_effects(want.fit, record.assign(**{name: noise}))
    pd.testing.assert_frame_equal(
        ranking, fem.rank_effects(want.fit, record), check_flags=False
    )
    assert name in {*DERIVED, *MODELLED}


@pytest.mark.parametrize(
    "name", ["check_units", "hour", "weekend", "month", "alternate_day", "limits"]
)
def test_any_other_name_is_a_column(usual, plain, name):
    noise = np.random.default_rng(1).normal(size=len(usual))
    loop = fem.close_loop(usual.assign(**{name: noise}))
    assert loop.effects == plain.effects
    assert f"driver:{name}" in loop.ranking.index
    assert (
        f"driver:{name}"
        in fem.rank_effects(plain.fit, usual.assign(**{name: noise})).index
    )


def test_names_bring_no_control_characters(usual):
    name = "fan\x1b[31m\x07\u202e"
    load = np.where(np.arange(len(usual)) // 5 % 4 == 0, 1.0, 0.0)
    data = usual.assign(**{name: load})
    data["temp_module"] -= 4.0 * load
    loop = fem.close_loop(data)
    shown = "driver:fan�[31m��"
    assert shown in loop.effects
    for text in (
        str(loop),
        loop.report(),
        loop.to_html(),
        loop.to_json(),
        repr(loop.ranking),
    ):
        assert not {"\x1b", "\x07", "\u202e"} & set(text)
    assert loop.predict(data).notna().all()
    with pytest.raises(ValueError) as error:
        fem.close_loop(data.drop(columns="wind_speed"))
    assert "\x1b" not in str(error.value)


@pytest.mark.parametrize("name", ["poa_global", "wind_direction"])
def test_a_column_that_is_there_twice_is_named(record, name):
    twice = pd.concat([record, record[[name]]], axis=1)
    for refusing in (fem.close_loop, fem.screen_record):
        with pytest.raises(ValueError, match=f"{name} is there twice; keep one"):
            refusing(twice)


def test_a_series_is_no_frame(usual):
    for refusing in (fem.close_loop, fem.screen_record):
        with pytest.raises(ValueError, match="data is a Series; give a DataFrame"):
            refusing(usual["temp_air"])


# values


def test_decimals_are_numbers(usual):
    air = usual["temp_air"]
    decimals = pd.Series([decimal.Decimal(str(v)) for v in air], air.index)
    assert fit(usual.assign(temp_air=decimals)).coefficients == fit(usual).coefficients


@pytest.mark.parametrize("size", [1e-200, 1e200])
def test_a_column_of_no_size_is_left_out_by_name(usual, plain, size):
    own = size * np.random.default_rng(0).uniform(1, 2, len(usual))
    loop = fem.close_loop(usual.assign(own=own))
    assert loop.effects == plain.effects
    assert any(note.startswith("own ") and "not used" in note for note in loop.notes)


def test_a_fit_of_which_all_is_at_a_bound_ends(usual):
    module = usual["temp_air"] + 1e-4 * usual["poa_global"]
    found = fit(
        usual.assign(temp_module=module),
        dynamics="steady",
        fixed={"bias": 0.0},
        check_units=False,
    )
    assert found.at_bound == ("k", "d")
    assert any("mountings gain 8 to 65 K" in note for note in found.notes)


@pytest.mark.parametrize("dynamics", ["steady", "ewm", "balance"])
@pytest.mark.parametrize("model", ["ross", "wm1", "wm2", "sapm", "faiman"])
def test_a_module_as_warm_as_the_air_ends_no_fit(usual, model, dynamics):
    """Which gains nothing, so that no coefficient is determined."""
    data = usual.assign(temp_module=usual["temp_air"])
    found = fit(data, model=model, dynamics=dynamics, check_units=False)
    assert np.isfinite(list(found.coefficients.values())).all()
    assert "temp_module is a copy of temp_air, row by row" in found.notes


@pytest.mark.parametrize("entry", ["---", "812,4", "0.0"])
def test_text_in_a_column_is_named_where_it_is(usual, entry):
    """One entry makes text of a whole column, as pandas reads it."""
    poa = usual["poa_global"].astype(str)
    row = 0 if entry == "0.0" else 17
    poa.iloc[row] = entry
    with pytest.raises(ValueError) as error:
        fit(usual.assign(poa_global=poa))
    message = str(error.value)
    assert f"poa_global holds {entry!r} at {usual.index[row]} (row {row})" in message
    remedy = {"---": "errors='coerce'", "812,4": "decimal=','", "0.0": "as text"}
    assert remedy[entry] in message


# times


def test_the_same_times_in_two_zones_are_told_from_others(usual):
    parts = {name: usual[name].tz_convert("Europe/Brussels") for name in COLUMNS}
    parts["poa_global"] = usual["poa_global"].tz_convert("UTC")
    with pytest.raises(ValueError, match="poa_global are in UTC, those of temp_air in"):
        fem.fit_fem(*parts.values())


def test_plain_times_may_be_durations_and_not_nan():
    steps = pd.to_timedelta([0, 60, 120], unit="s")
    values = [0.0, 1.0, 2.0]
    want = fem.ewm(values, 378.0, times=[0, 60, 120])
    assert np.array_equal(fem.ewm(values, 378.0, times=steps), want)
    with pytest.raises(ValueError, match=r"add the time of its start, as pd\.Timest"):
        fem.ewm(pd.Series(values, steps), 378.0)
    with pytest.raises(ValueError, match=r"times has no number \(NaN\) at row 1"):
        fem.ewm(values, 378.0, times=[0, np.nan, 120])


def test_a_stray_time_is_refused_by_a_fit_too(usual):
    index = usual.index.tz_localize(None).as_unit("s").to_numpy().copy()
    index[0] = np.datetime64("0023-06-01")
    with pytest.raises(ValueError, match="2000 years before all others"):
        fit(usual.set_axis(pd.DatetimeIndex(index)))


@pytest.mark.parametrize("latitude", [-40.0, 50.0])
def test_rows_of_hours_show_no_summer_time(latitude):
    site = simulator.Site(latitude=latitude, surface_azimuth=0 if latitude < 0 else 180)
    data = simulator.record(site, days=365, step=3600.0)
    for step in ("1h", "2h", "3h"):
        poa = data["poa_global"].resample(step).mean()
        assert solar_noon_shift(poa, poa.index).jumps == ()


def test_hours_far_from_the_suns_are_said(usual, plain):
    place = dict(surface_tilt=35, surface_azimuth=180, effects=[])
    far = fem.close_loop(
        usual.shift(freq="7h").tz_convert("UTC"),
        location=Location(39.0, -105.0, tz="Etc/GMT+7"),
        **place,
    )
    (note,) = (n for n in far.notes if n.startswith("hours are those of"))
    assert "UTC; at longitude -105° the sun's are 7 h earlier" in note
    near = fem.close_loop(usual.tz_convert("UTC"), location=RHEIN, **place)
    assert not any(n.startswith("hours are those of") for n in near.notes)


# arguments


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (dict(location=(39, -105)), r"give pvlib.location.Location\(39, -105\)"),
        (dict(surface_tilt=np.nan), "surface_tilt is nan; give one number of degrees"),
        (
            dict(surface_tilt=pd.Series([1.0])),
            "surface_tilt as Series need the times of the record",
        ),
        (dict(surface_azimuth="south"), "surface_azimuth is 'south'; give one number"),
        (
            dict(min_rmse_reduction=np.nan),
            "min_rmse_reduction = nan must be more than 0",
        ),
    ],
)
def test_what_is_no_place_is_refused_with_the_remedy(usual, options, message):
    with pytest.raises(ValueError, match=message):
        fem.close_loop(usual, **options)


@pytest.mark.parametrize("dynamics", ["ewm", "balance"])
def test_a_coefficient_given_as_a_column_names_fixed(usual, dynamics):
    with pytest.raises(ValueError, match=r"hold it give fixed=\{'tau': 378\}"):
        fit(usual, dynamics=dynamics, tau=378)


@pytest.mark.parametrize("level", [2, 0, 1, np.nan])
def test_a_level_is_a_chance(usual, level):
    with pytest.raises(ValueError, match=r"must be between 0 and 1, such as 0\.95"):
        fit(usual).confidence_interval(level)


# machines


def test_loops_in_threads_give_back_the_threads_of_blas(usual):
    """Whichever begins first and ends last, BLAS has one thread until the last ends."""

    def threads():
        return {i["num_threads"] for i in threadpool_info() if i["user_api"] == "blas"}

    with threadpool_limits(limits=2, user_api="blas"):
        before = threads()
        for order in ((0, 1, 2), (2, 1, 0), (1, 2, 0)):
            running = [one_blas_thread() for _ in order]
            for one in running:
                one.__enter__()
            for place in order:
                assert threads() == {1}
                running[place].__exit__(None, None, None)
            assert threads() == before
        with pytest.raises(ValueError, match="unknown model"):
            fem.close_loop(usual, model="ghosts")
        assert threads() == before


def test_a_loop_that_names_a_column_can_be_stored(usual):
    load = np.where(np.arange(len(usual)) // 5 % 4 == 0, 1.0, 0.0)
    data = usual.assign(fan=load)
    data["temp_module"] -= 4.0 * load
    loop = fem.close_loop(data)
    assert loop.effects[0] == "driver:fan"
    again = pickle.loads(pickle.dumps(loop))
    assert str(again) == str(loop)
    pd.testing.assert_series_equal(again.predict(data), loop.predict(data))


# columns that hold the answer


@pytest.mark.parametrize("seed", range(2))
def test_what_is_made_from_the_answer_is_told_from_a_cause(usual, seed):
    random = np.random.default_rng(seed)
    rows = len(usual)
    fan = np.repeat((random.random(rows // 12 + 1) < 0.3) * 1.0, 12)[:rows]
    module = usual["temp_module"] - 3.0 * fan
    data = usual.assign(temp_module=module)
    own = {
        "noisy": module + random.normal(0, 3, rows),
        "coarse": (module / 5.0).round() * 5.0,
        "excess": module - usual["temp_air"] - 0.03 * usual["poa_global"],
        "fan": fan + random.normal(0, 0.05, rows),
        "humid": 60.0 - 2.0 * usual["temp_air"] + random.normal(0, 5, rows),
        "pure_noise": random.normal(size=rows),
    }
    own["excess"] = own["excess"] + random.normal(0, 1, rows)
    model = fit(data, model="faiman", night=True)
    inputs = model.record.inputs
    columns = inputs.columns | {name: np.asarray(c) for name, c in own.items()}
    record = replace(model.record, inputs=replace(inputs, columns=columns))
    modelled = record["temp_module"] - model.residual.to_numpy()
    every = np.ones(rows, dtype=bool)
    found = set(
        leaks(record, every, modelled, list(own), Criteria().min_leak_difference)
    )
    assert found == {"noisy", "coarse", "excess"}


def test_an_effect_of_ones_own_may_use_any_column(usual):
    effect = Effect(
        "mine",
        lambda x, *, heat: Terms(heat=heat * x),
        {"heat": Parameter(0.0, -10.0, 10.0, "-")},
        columns=("hour",),
    )
    hour = pd.Series(usual.index.hour * 1.0, usual.index)
    assert "mine.heat" in fit(usual, effects=effect, hour=hour).coefficients


def test_a_short_record_never_ends_in_a_matrix():
    """Three rows to three days, by day and by night."""
    data = datasets.synthetic(4, 600.0, seed=5)
    random = np.random.default_rng(0)
    for _ in range(12):
        rows = int(random.integers(3, 140))
        part = data.iloc[(at := int(random.integers(0, 400))) : at + rows]
        try:
            fit(part, dynamics="balance", check_units=False)
        except ValueError as error:
            assert "rows" in str(error) or "is stuck" in str(error)
