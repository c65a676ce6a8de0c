"""What was not measured is found, named and left out; what was measured stays."""

import numpy as np
import pandas as pd
import pvlib
import pytest
from conftest import COLUMNS
from hypothesis import given, settings, strategies as st

import pvlib_fem as fem
from pvlib_fem import datasets, simulator
from pvlib_fem._record.inputs import as_record
from pvlib_fem._record.ranges import CODES, possible_range
from pvlib_fem.effects._effect import Effect, Parameter, Terms
from pvlib_fem.quality._file_scan import Column
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._screen import screened_alone
from pvlib_fem.quality._screening import stuck_rows
from pvlib_fem.simulator import ALBUQUERQUE, PHYSICS, RHINE


@pytest.fixture(scope="module")
def record():
    """Ten days of June with all that a site measures, and a column of its own."""
    data = simulator.record(effects=PHYSICS, days=10, step=600, start="2023-06-01")
    data.attrs = {}
    fan = 40.0 + 5.0 * np.sin(np.arange(len(data)) / 7.0)
    return data.assign(fan=fan + np.random.default_rng(0).normal(size=len(data)))


def fit(data, **options):
    return fem.fit_fem(*(data[name] for name in COLUMNS), **options)


def with_values(data, column, rows, value):
    data = data.copy()
    data.iloc[rows, data.columns.get_loc(column)] = value
    return data


def kinds(found):
    return list(map(tuple, found.counts[["column", "kind", "rows"]].to_numpy()))


# fill values


@settings(max_examples=60, deadline=None)
@given(
    column=st.sampled_from([*COLUMNS, "relative_humidity", "longwave_down", "fan"]),
    code=st.sampled_from([-999, -6999, -7999, -327.67, 9999, 7999, -9999.9, 65535]),
    rows=st.sets(st.integers(0, 1439), min_size=1, max_size=60),
)
def test_any_code_is_found_in_any_column_and_nothing_else(record, column, code, rows):
    found = fem.screen_record(with_values(record, column, sorted(rows), float(code)))
    assert kinds(found) == [(column, "fill value", len(rows))]
    mask = found.mask
    assert set(np.flatnonzero(mask[column])) == rows
    assert mask.to_numpy().sum() == len(rows)
    assert found.cleaned[column].isna().sum() == len(rows)
    assert found.notes[0].startswith(f"{column} holds the fill value {code:.7g} ")
    assert str(record.index[min(rows)]) in found.notes[0]


def test_two_codes_and_a_float_of_32_bits_are_found(record):
    data = with_values(record, "relative_humidity", [5, 6], -6999.0)
    data = with_values(data, "relative_humidity", [9], -7999.0)
    data["fan"] = with_values(data, "fan", [3], -327.67)["fan"].astype("float32")
    assert kinds(fem.screen_record(data)) == [
        ("relative_humidity", "fill value", 3),
        ("fan", "fill value", 1),
    ]


def test_a_value_that_repeats_far_outside_is_no_value(record):
    """One that no list of codes has."""
    assert 4.2e4 not in CODES
    found = fem.screen_record(with_values(record, "fan", range(100, 120), 4.2e4))
    assert kinds(found) == [("fan", "fill value", 20)]
    found = fem.screen_record(with_values(record, "fan", [100], 4.2e5))
    assert kinds(found) == [("fan", "spike", 1)]


def test_a_code_does_not_hide_a_value_that_no_list_has(record):
    data = with_values(record, "fan", range(100, 120), 4.2e4)
    data = with_values(data, "fan", [7, 9], -99999.0)
    found = fem.screen_record(data)
    assert kinds(found) == [("fan", "fill value", 22)]
    assert set(np.flatnonzero(found.mask["fan"])) == {7, 9, *range(100, 120)}


def test_a_code_of_a_column_that_goes_far_is_one_too(record):
    """Its distance from the column's values is small against the column's span."""
    counter = record.assign(fan=np.arange(1440.0) ** 2)
    assert fem.screen_record(counter).counts.empty
    found = fem.screen_record(with_values(counter, "fan", [50, 51], -999.0))
    assert kinds(found) == [("fan", "fill value", 2)]


@pytest.mark.parametrize(
    "own",
    {
        "a counter that passes the codes": np.arange(1440.0) * 10,
        "a switch": np.where(np.arange(1440) % 7 == 0, 999.0, 0.0),
        "a fan that is off at times": np.where(
            np.arange(1440) % 20 == 0, 0.0, 900 + np.arange(1440) % 97
        ),
        "pressure about 999 hPa": 999.0 + np.round(np.arange(1440) % 41 - 20.0),
        "a skewed quantity": np.random.default_rng(0).lognormal(0, 2, 1440),
        "a temperature about 0": np.random.default_rng(0).normal(size=1440),
        "rain of a bucket": np.random.default_rng(0).poisson(0.01, 1440) * 1.2,
    }.values(),
)
def test_a_column_of_ones_own_keeps_what_it_may_mean(record, own):
    assert fem.screen_record(record.assign(own=own)).counts.empty


def test_a_code_within_what_a_column_holds_is_a_value(record):
    found = fem.screen_record(with_values(record, "poa_global", [70, 71], 999.0))
    assert found.counts.empty


@pytest.mark.parametrize("column", COLUMNS)
def test_a_fill_value_costs_its_rows_and_no_more(record, column):
    rows = np.random.default_rng(0).choice(len(record), 70, replace=False)
    spoilt, holes = (with_values(record, column, rows, v) for v in (-7999.0, np.nan))
    found, want = fit(spoilt), fit(holes)
    assert found.coefficients == want.coefficients
    assert found.stderr == want.stderr
    note = f"{column} holds the fill value -7999 in 70 rows, first at "
    assert any(line.startswith(note) for line in found.notes)
    assert found.record.impossible[column] == 70


def test_a_fill_value_in_a_driver_costs_its_rows_too(plant):
    effect = dict(effects=["sky_radiation"])
    rows = [50, 51, 4000, 9000]

    def fitted(value):
        data = with_values(plant, "longwave_down", rows, value)
        return fit(data, longwave_down=data["longwave_down"], **effect)

    assert fitted(7999.0).coefficients == fitted(np.nan).coefficients
    assert "longwave_down holds the fill value 7999 in 4 rows" in str(fitted(7999.0))


def test_a_doubted_driver_may_stand_still_too():
    data = simulator.record(effects=PHYSICS, days=8, step=1800, start="2023-06-01")
    data["relative_humidity"] /= 100.0
    data = with_values(data, "relative_humidity", range(96, 192), 0.5)
    data = with_values(data, "temp_module", range(210, 214), -999.0)
    data = with_values(data, "temp_module", range(250, 254), -999.0)
    loop = fem.close_loop(data)
    assert any("a fraction; multiply it by 100" in note for note in loop.notes)
    # of either kind of days
    assert loop.fit.record.impossible["temp_module"] == 8
    assert len(set(loop.weeks.iloc[[210, 253]])) == 2


def test_a_column_of_fill_values_is_refused_by_name(record):
    with pytest.raises(ValueError, match="wind_speed holds nothing but the fill value"):
        fit(record.assign(wind_speed=-999.0))


def test_the_loop_and_the_ranking_screen_their_drivers():
    data = simulator.record(effects=PHYSICS, days=25, step=1800, start="2023-06-01")
    data = data.drop(columns="snow_depth")
    fan = pd.Series(np.random.default_rng(1).normal(40, 5, len(data)), data.index)
    data = data.assign(fan=fan)
    told = []
    for value in (-9999.0, np.nan):
        spoilt = with_values(data, "fan", range(30, 40), value)
        spoilt = with_values(spoilt, "longwave_down", [500], abs(value))
        loop = fem.close_loop(spoilt)
        ranking = fem.rank_effects(loop.fit, spoilt)
        told.append((loop, ranking))
    (found, ranks), (want, wanted) = told
    pd.testing.assert_frame_equal(found.table, want.table)
    pd.testing.assert_frame_equal(found.ranking, want.ranking)
    pd.testing.assert_frame_equal(ranks, wanted, check_flags=False)
    for notes in (found.notes, ranks.attrs["notes"]):
        assert any("fan holds the fill value -9999 in 10 rows" in n for n in notes)
        assert any("longwave_down holds the fill value 9999 at" in n for n in notes)


# what cannot be


@pytest.mark.parametrize(
    "column", [*COLUMNS, "relative_humidity", "p_dc_per_area", "snow_depth"]
)
def test_what_no_sensor_can_measure_is_out_of_range(record, column):
    low, high, _ = possible_range(column)
    for value in (low - 1.0, high + 1.0):
        found = fem.screen_record(with_values(record, column, [3, 10], value))
        assert kinds(found) == [(column, "out of range", 2)]
    for value in (low, high):
        found = fem.screen_record(with_values(record, column, [3, 4, 5, 6], value))
        assert not found.masks["out of range"].to_numpy().any()


def test_irradiance_below_zero_is_an_offset_by_night_and_a_fault_by_day(record):
    data = record.copy()
    night = data["poa_global"] == 0
    data.loc[night, "poa_global"] = -4.0
    found = fem.screen_record(data)
    assert found.counts.empty and found.clipped == night.sum()
    assert (found.cleaned.loc[night, "poa_global"] == 0).all()
    noon = slice("2023-06-04 11:00", "2023-06-04 13:50")
    data.loc[noon, "poa_global"] = -4.0
    found = fem.screen_record(data)
    assert kinds(found) == [("poa_global", "negative by day", 18)]
    assert found.cleaned.loc[noon, "poa_global"].isna().all()
    assert found.clipped == night.sum()
    assert any("poa_global is negative by day, as -4," in n for n in fit(data).notes)
    # far below what an offset can be is no night either
    data.loc["2023-06-05 01:00", "poa_global"] = -80.0
    assert ("poa_global", "out of range", 1) in kinds(fem.screen_record(data))


def test_a_winter_morning_before_a_gap_is_no_day_by_the_summer_after_it():
    """Times of day are compared with those of the days around, by date."""
    data = simulator.record(days=200, step=600, start="2023-01-10", seed=27)
    data = data[list(COLUMNS)]
    parts = data[:"2023-01-31"], data["2023-06-01":]
    assert (parts[0]["poa_global"] < 0.0).any()
    whole = fem.screen_record(pd.concat(parts))
    assert whole.counts.empty
    assert whole.clipped == sum(fem.screen_record(part).clipped for part in parts)


def test_a_sensor_with_its_sign_turned_is_refused(record):
    with pytest.raises(ValueError, match="of poa_global is physically impossible"):
        fit(record.assign(poa_global=-record["poa_global"]))


@pytest.mark.parametrize("column", ["temp_air", "temp_module"])
@pytest.mark.parametrize("rows", [1, 2, 3])
def test_a_jump_there_and_back_is_a_spike(column, rows):
    data = datasets.synthetic(2, 60.0)
    at = data.index[800 : 800 + rows]
    for jump in (40.0, -40.0):
        spoilt = data.copy()
        spoilt.loc[at, column] += jump
        found = fem.screen_record(spoilt)
        assert kinds(found) == [(column, "spike", rows)]
        assert (found.mask[column].loc[at]).all()


def test_a_jump_that_stays_is_no_spike():
    data = datasets.synthetic(2, 60.0)
    data.loc[data.index[800:860], "temp_module"] += 30.0
    assert fem.screen_record(data).counts.empty


@pytest.mark.parametrize(("step", "found"), [(900.0, 1), (3600.0, 1), (21600.0, 0)])
def test_air_may_come_and_go_in_a_day_and_not_in_an_hour(step, found):
    air = pd.Series(15.0, pd.date_range("2023-06-01", periods=40, freq=f"{step:g}s"))
    air += np.random.default_rng(0).normal(size=40)
    air.iloc[20] += 32.0
    assert len(fem.screen_record(air.to_frame("temp_air")).counts) == found


@pytest.mark.parametrize("site", [RHINE, ALBUQUERQUE])
@pytest.mark.parametrize("start", ["2023-01-05", "2023-06-20"])
@pytest.mark.parametrize("step", [60.0, 900.0])
def test_what_was_measured_stays(site, start, step):
    days = 5 if step == 60.0 else 40
    effects = PHYSICS | {"snow": 1.0, "electrical_output": 1.0}
    data = simulator.record(site, effects, days, step, 3, start=start)
    found = fem.screen_record(data)
    assert found.counts.empty and found.notes == ()
    assert str(found) == f"{len(data):,} rows: nothing at fault was found"
    assert not found.mask.to_numpy().any()


def test_measured_records_keep_all_rows(week, day):
    assert fem.screen_record(week).counts.empty
    assert fem.screen_record(day).counts.empty


# zeros that stand for no value


def site_record(step, start="2023-06-01", days=30, **options):
    """What a logger stores with one digit, with nights of exactly 0 W/m²."""
    data = simulator.record(effects=PHYSICS, days=days, step=step, start=start)
    data.attrs = {}
    return data[list(COLUMNS)].round(1) + 0.0


@pytest.mark.parametrize("column", ["poa_global", "temp_air", "temp_module"])
@pytest.mark.parametrize("step", [60.0, 300.0, 900.0, 3600.0])
@pytest.mark.parametrize("share", [None, 0.01, 0.03])
def test_a_zero_to_which_nothing_leads_is_no_value(column, step, share):
    """One of the brightest or warmest hour alone, and some at any time."""
    data = site_record(step, days=5 if step == 60.0 else 30)
    chance = np.random.default_rng(1).random(len(data))
    best = int(data[column].argmax())
    rows = np.array([best]) if share is None else np.flatnonzero(chance < share)
    before = data[column].to_numpy()
    found = fem.screen_record(with_values(data, column, rows, 0.0))
    ((name, kind, many),) = kinds(found)
    assert (name, kind) == (column, "lone zero")
    mask = found.masks[kind][column].to_numpy()
    assert set(np.flatnonzero(mask)) <= set(rows) and mask.sum() == many
    light = column == "poa_global"
    far = rows[before[rows] > (250.0 if light else 5.0)]
    # those that follow each other too often, or have a dim row next to them, stay
    assert mask[far].mean() > (0.8 if light else 0.97)
    assert f"{column} is exactly 0 between values that do not lead" in found.notes[0]


def test_a_fit_uses_no_such_zero():
    data = site_record(600.0)
    rows = np.flatnonzero(np.random.default_rng(1).random(len(data)) < 0.02)
    rows = rows[(data["temp_module"].to_numpy()[rows] > 5.0)]
    spoilt = with_values(data, "temp_module", rows, 0.0)
    found, empty = fit(spoilt), fit(with_values(data, "temp_module", rows, np.nan))
    assert found.coefficients == empty.coefficients
    assert any(f"lead to it, in {len(rows):,} rows" in note for note in found.notes)


@pytest.mark.parametrize("step", [60.0, 300.0, 900.0, 3600.0])
@pytest.mark.parametrize("places", [1, 0])
@pytest.mark.parametrize("start", ["2023-01-05", "2023-03-20"])
def test_what_is_measured_at_zero_stays(step, places, start):
    """Nights, and temperatures around 0 °C, however coarse they are stored."""
    data = site_record(step, start, days=5 if step == 60.0 else 60)
    near = 0
    for warmer in np.arange(-6.0, 6.5, 1.5):
        parts = {n: data[n] + warmer for n in ("temp_air", "temp_module")}
        shifted = data.assign(**parts).round(places) + 0.0
        near += (shifted[list(parts)] == 0).sum().sum()
        assert (shifted["poa_global"] == 0).mean() > 0.3
        assert fem.screen_record(shifted).counts.empty
    assert near > 50


def test_a_zero_that_values_lead_to_stays():
    data = site_record(300.0)
    noon = int(data["poa_global"].argmax())
    # four rows, a calm, light that is dim on one side, rows by the hour in between
    assert not kinds(fem.screen_record(with_values(data, "wind_speed", [noon], 0.0)))
    for column in ("poa_global", "temp_module"):
        rows = list(range(noon, noon + 4))
        assert not kinds(fem.screen_record(with_values(data, column, rows, 0.0)))
        assert kinds(fem.screen_record(with_values(data, column, rows[:3], 0.0)))
        gap = with_values(data, column, [noon], 0.0)
        gap = gap.drop(gap.index[noon + 1 : noon + 4])
        assert not kinds(fem.screen_record(gap))
    dim = with_values(data, "poa_global", [noon + 1], 90.0)
    assert not kinds(fem.screen_record(with_values(dim, "poa_global", [noon], 0.0)))
    lamp = data.assign(poa_global=np.where(np.arange(len(data)) % 2, 0.0, 800.0))
    assert "lone zero" not in {*fem.screen_record(lamp).counts["kind"]}


@pytest.mark.parametrize("step", [60.0, 600.0, 3600.0])
@pytest.mark.parametrize("hours", [1, 30])
def test_rows_of_zeros_in_all_columns_are_no_measurement(step, hours):
    """A logger writes them where communication fails, at any hour and for days."""
    data = site_record(step, days=10).assign(relative_humidity=60.0, fan=1.0)
    data["relative_humidity"] += np.arange(len(data)) % 30
    failed = np.zeros(len(data), dtype=bool)
    for day in (2, 5, 8):
        first = int((day * 86400 + day * 3600) / step)
        failed[first : first + int(hours * 3600 / step)] = True
    zeros = [*COLUMNS, "relative_humidity"]
    spoilt = data.copy()
    spoilt.loc[failed, zeros] = 0.0
    found = fem.screen_record(spoilt)
    assert kinds(found) == [(name, "all zero", failed.sum()) for name in zeros]
    line = f"{', '.join(zeros)} stood at exactly 0 at once"
    assert [line in note for note in found.notes] == [True]
    holes = data.copy()
    holes.loc[failed, list(COLUMNS)] = np.nan
    assert fit(spoilt).coefficients == fit(holes).coefficients


@pytest.mark.parametrize("step", [600.0, 3600.0])
@pytest.mark.parametrize("places", [1, 0])
def test_a_calm_night_at_zero_is_measured(step, places):
    data = site_record(step, "2023-01-05", days=60)
    near = 0
    for warmer in np.arange(-6.0, 6.5, 1.0):
        dark = data["poa_global"] == 0
        calm = data.assign(wind_speed=data["wind_speed"].mask(dark, 0.0))
        parts = {n: data[n] + warmer for n in ("temp_air", "temp_module")}
        parts["temp_module"] = parts["temp_module"].mask(dark, parts["temp_air"])
        calm = calm.assign(**parts).round(places) + 0.0
        near += (calm[list(COLUMNS)] == 0).all(axis=1).sum()
        assert "all zero" not in {*fem.screen_record(calm).counts["kind"]}
    assert near > 50


@pytest.mark.parametrize("late", [-1, 1, 2])
@pytest.mark.parametrize("step", [300, 1800])
def test_a_fit_says_that_the_clock_of_the_module_is_hours_off(tmp_path, late, step):
    """It takes an hour for a capacity of ten times the module's own."""
    data = datasets.synthetic(12, step, seed=2)
    data["temp_module"] = data["temp_module"].shift(late * 3600 // step)
    data.to_parquet(tmp_path / "record.parquet")
    notes = fit(data).notes
    (note,) = [n for n in notes if "timestamps of temp_module run" in n]
    assert f"run {abs(late)} h" in note and "give the record to close_loop" in note
    assert f"{'Subtract' if late > 0 else 'Add'} {abs(late)} h" in note
    assert note in fem.fit_fem(tmp_path, model="faiman").notes
    assert note in fem.screen_record(data).notes


# sensors that are stuck


def test_a_fit_leaves_out_sensors_that_stand_still():
    data = datasets.synthetic(15, 300.0, seed=3)
    spoilt, holes = data.copy(), data.copy()
    spoilt.iloc[1000:1500, 3 + list(data).index("poa_global")] = 31.4
    assert list(data)[3 + list(data).index("poa_global")] == "temp_module"
    spoilt.iloc[2200:3100, list(data).index("wind_speed")] = 0.0
    holes.iloc[1000:1500, list(data).index("temp_module")] = np.nan
    holes.iloc[2200:3100, list(data).index("wind_speed")] = np.nan
    found = fit(spoilt)
    for column, rows in (("temp_module", 500), ("wind_speed", 900)):
        assert any(
            f"{column} is stuck at" in note and f"in {rows} rows" in note
            for note in found.notes
        )
    assert found.coefficients == fit(holes).coefficients


@pytest.mark.parametrize(
    ("column", "value", "days"),
    [
        ("relative_humidity", 43.0, 2),
        ("longwave_down", 333.0, 2),
        ("wind_direction", 222.0, 4),
        ("p_dc_per_area", 12.0, 2),
    ],
)
def test_a_driver_can_stand_still_too(record, column, value, days):
    rows = range(300, 300 + 144 * days)
    found = fem.screen_record(with_values(record, column, rows, value))
    assert kinds(found) == [(column, "stuck", len(rows))]
    quiet = fem.screen_record(with_values(record, "relative_humidity", rows, 100.0))
    assert quiet.counts.empty  # fog


def test_a_sensor_that_never_moves_is_refused_by_a_fit_too(record):
    with pytest.raises(ValueError, match=r"temp_module is stuck at 12\.5 for"):
        fit(record.assign(temp_module=12.5))
    calm = fit(record.assign(wind_speed=0.0), model="ross")
    assert any("wind_speed is 0 m/s in all rows" in note for note in calm.notes)


# swapped, or in another unit


def test_air_and_module_swapped_are_recognised(record, week):
    for data in (record, week):
        names = {"temp_air": "temp_module", "temp_module": "temp_air"}
        swapped = data.rename(columns=names)
        with pytest.raises(ValueError, match="temp_air and temp_module look swapped"):
            fit(swapped)
        with pytest.raises(ValueError, match="temp_air and temp_module look swapped"):
            fem.close_loop(swapped)
        assert any("look swapped" in note for note in fem.screen_record(swapped).notes)
        found = fit(swapped, check_units=False)
        assert any("look swapped" in n and "give" not in n for n in found.notes)


def test_one_thermometer_under_two_names_is_recognised(record):
    with pytest.raises(ValueError, match="temp_module is a copy of temp_air"):
        fem.close_loop(record.assign(temp_module=record["temp_air"]))


@pytest.mark.parametrize("factor", [1 / 6, 0.06, 0.1])
def test_sums_of_a_step_are_no_fahrenheit(record, factor):
    """Wh/m² and J/cm² of ten minutes, mW/cm²."""
    with pytest.raises(ValueError, match="poa_global looks to be in another unit than"):
        fit(record.assign(poa_global=factor * record["poa_global"]))


def test_wind_in_miles_an_hour_gets_a_word(record):
    mph = record.assign(wind_speed=record["wind_speed"] * 2.237)
    assert any("is it in mph or km/h" in note for note in fit(mph).notes)
    assert not any("mph" in note for note in fit(record).notes)


@pytest.mark.parametrize(
    ("column", "change", "words"),
    [
        (
            "longwave_down",
            lambda x: 1.6 * x,
            r"is outside the 100 to 550 W/m² .* in \d",
        ),
        (
            "p_dc_per_area",
            lambda x: x / 1000,
            ".* at its best, kW; multiply it by 1000",
        ),
        ("relative_humidity", lambda x: x / 100, ".* a fraction; multiply it by 100"),
    ],
)
def test_a_driver_of_a_fit_is_doubted_as_in_the_loop(record, column, change, words):
    data = record.assign(**{column: change(record[column])})
    assert any(column in note for note in fem.screen_record(data).notes)
    effect = Effect(
        "mine",
        lambda x, *, heat: Terms(heat=heat * x),
        {"heat": Parameter(0.0, -1.0, 1.0, "-")},
        columns=(column,),
    )
    with pytest.raises(ValueError, match=f"{column} {words}"):
        fit(data, effects=effect, **{column: data[column]})
    fit(data, effects=effect, check_units=False, **{column: data[column]})


# the frame


def test_masks_join_with_those_of_others(record):
    data = with_values(record, "temp_module", [7], -999.0)
    other = pd.DataFrame(False, data.index, data.columns)
    other.iloc[9, other.columns.get_loc("temp_module")] = True
    mask = fem.screen_record(data).mask
    assert list(np.flatnonzero((mask | other)["temp_module"])) == [7, 9]
    assert not (mask & other).to_numpy().any()
    assert data.mask(mask | other)["temp_module"].isna().sum() == 2


# the end of a sensor's range


def test_light_at_the_end_of_its_range_is_left_out_with_what_is_remembered(record):
    """A logger that ends at 700 W/m², which the module is warmer than after."""
    data = record.assign(poa_global=record["poa_global"].clip(upper=700.0))
    found = fem.screen_record(data)
    ((column, kind, rows),) = kinds(found)
    assert (column, kind) == ("poa_global", "end of range")
    at = data["poa_global"] == 700.0
    after = at.astype(float).rolling(4, min_periods=1).max() > 0  # half an hour
    assert rows == after.sum() > at.sum()
    assert found.cleaned["poa_global"].isna().equals(after)
    assert found.cleaned["poa_global"].max() < 700.0
    assert found.notes[0].startswith("poa_global stays at 700, the end of its range")
    before = fem.screen_record(record)
    assert before.counts.empty


@pytest.mark.parametrize("name", ["temp_module", "temp_air"])
def test_a_logger_that_writes_zero_by_night_is_in_no_other_unit(record, name):
    """The other temperature is far from that zero, and in °C all the same."""
    data = record.copy()
    data[["temp_air", "temp_module"]] += 5.0
    dark = data["poa_global"] <= 0.0
    assert data.loc[dark, name].median() > 12.0
    data.loc[dark, name] = 0.0
    found = fem.screen_record(data)
    assert any(f"{name} stays at 0, the end" in note for note in found.notes)


@pytest.mark.parametrize(
    ("column", "low", "high"),
    [
        ("temp_module", None, 40.0),
        ("temp_module", 15.0, None),
        ("temp_air", None, 19.0),
    ],
)
def test_a_thermometer_may_end_on_either_side(record, column, low, high):
    data = record.assign(**{column: record[column].clip(low, high)})
    found = fem.screen_record(data)
    assert [one[:2] for one in kinds(found)] == [(column, "end of range")]
    at = data[column] == (high if low is None else low)
    left = found.cleaned[column].isna()
    assert (left[at]).all()
    assert left.equals(at) if column == "temp_module" else left.sum() > at.sum()


@pytest.mark.parametrize("places", [None, 1, 0])
@pytest.mark.parametrize("days", [4, 30])
def test_what_is_measured_has_no_such_end(places, days):
    """However coarse, and in a few days in which the most may come twice."""
    data = simulator.record(effects=PHYSICS, days=days, step=300, seed=3)
    data.attrs = {}
    data = data if places is None else data.round(places)
    if places == 0:  # steps of 2 K, and of half a m/s
        data = data.assign(temp_module=2.0 * (data["temp_module"] / 2.0).round())
        data["wind_speed"] = (2.0 * data["wind_speed"]).round() / 2.0
    assert "end of range" not in {*fem.screen_record(data).counts["kind"]}
    few = data[data.index < data.index[0] + pd.Timedelta("4D")]
    few = few.assign(poa_global=few["poa_global"].clip(upper=100.0))
    assert "end of range" not in {
        *fem.screen_record(few).counts["kind"]
    }  # too few days


def test_light_at_the_end_of_its_range_is_no_shade():
    """What is hotter than modelled, by day and where the sun is high."""
    data = simulator.record(effects=PHYSICS, days=365, step=600, seed=101)
    data["poa_global"] = data["poa_global"].clip(upper=750.0)
    location = pvlib.location.Location(RHINE.latitude, RHINE.longitude, RHINE.tz)
    angles = RHINE.surface_tilt, RHINE.surface_azimuth
    loop = fem.close_loop(data, "faiman", location, *angles)
    assert not [f for f in loop.finding_objects if f.verdict == "identified"]
    assert any("poa_global stays at 750" in note for note in loop.notes)


def test_the_frame_keeps_its_form(record):
    data = with_values(record, "temp_air", [7], -999.0)
    data["temp_air"] = data["temp_air"].astype("Float64")
    data = data.rename(columns={"longwave_down": "ir_down"}).assign(label="a")
    data[0] = 1.0
    before = data.copy()
    found = fem.screen_record(data)
    pd.testing.assert_frame_equal(data, before)
    assert list(found.cleaned) == list(data) == list(found.mask)
    assert found.cleaned.index.equals(data.index)
    assert set(found.masks) == {
        *("fill value", "out of range", "negative by day", "light by night", "spike"),
        *("all zero", "lone zero", "end of range", "stuck"),
    }
    with pytest.raises(ValueError, match="temp_air is there twice"):
        fem.screen_record(pd.concat([data, data[["temp_air"]]], axis=1))


def test_a_frame_need_not_have_all_columns(record):
    found = fem.screen_record(
        with_values(record[["temp_air", "fan"]], "fan", [4], -999.0)
    )
    assert kinds(found) == [("fan", "fill value", 1)]


def test_a_wind_that_nobody_measured_is_not_said_to_be_calm(record):
    for data in (record.drop(columns="wind_speed"), record.assign(wind_speed=np.nan)):
        assert fem.screen_record(data).notes == ()


def test_limits_are_an_argument(record):
    jump = record["temp_air"].where(np.arange(len(record)) != 200, 60.0)
    data = record.assign(temp_air=jump)
    assert kinds(fem.screen_record(data)) == [("temp_air", "spike", 1)]
    tolerant = Limits(min_spike=99.0)
    assert fem.screen_record(data, tolerant).counts.empty
    assert any("jumps and returns" in note for note in fit(data).notes)
    assert not any("jumps" in note for note in fit(data, limits=tolerant).notes)


@pytest.mark.parametrize("digits", [None, 2, 1])
@pytest.mark.parametrize(("step", "every"), [(60, "1h"), (300, "1h"), (900, "3h")])
def test_a_column_that_is_filled_between_its_values_is_told(step, every, digits):
    """As weather from a model, or from a station, is joined to a plant's rows."""
    data = simulator.record(effects=PHYSICS, days=25, step=step, seed=3)
    assert not any("in between" in note for note in fem.screen_record(data).notes)
    means = data.resample(every).mean()
    air = means["temp_air"].reindex(data.index).interpolate(limit_direction="both")
    wind = means["wind_speed"].reindex(data.index, method="ffill")
    filled = data.assign(temp_air=air, wind_speed=wind)
    if digits is not None:
        filled = filled.round(digits)
    minutes = pd.Timedelta(every) // pd.Timedelta("1min")
    told = " ".join(fem.screen_record(filled).notes)
    assert f"wind_speed keeps a value for {minutes} min, and rows are" in told
    line = f"temp_air is a straight line between values {minutes} min apart"
    # from minute to minute 0.1 K is no line
    assert (line in told) == ((step, digits) != (60, 1))


def test_a_known_quantity_that_is_text_is_named():
    data = fem.datasets.synthetic(days=3, step=600).assign(logger="ok")
    found = fem.screen_record(data.assign(temp_air=data["temp_air"].astype(str)))
    assert found.notes == ("temp_air is not numeric and was not screened",)
    assert fem.screen_record(data).notes == ()


# columns that were read before


def test_a_column_that_a_record_shares_with_another_is_not_read_again(
    record, monkeypatch
):
    """Nor does it make a difference: what is found is the same as of both alone."""
    spoilt = with_values(record, "temp_module", range(300, 400), 31.25)
    spoilt = with_values(spoilt, "wind_speed", [7], -999.0)
    limits, read = Limits(), []
    columns = [spoilt[name] for name in COLUMNS]
    one = as_record(*columns)
    hidden = one.lacking({"temp_module": np.arange(len(record)) < 200})
    alone = [screened_alone(each, limits) for each in (one, hidden)]
    add = Column.add

    def counted(self, values, start, times):
        read.append(self.name)
        return add(self, values, start, times)

    monkeypatch.setattr(Column, "add", counted)
    _, first = screened_alone(one, limits)
    assert sorted(read) == sorted(COLUMNS)
    clean, second = screened_alone(hidden, limits, known=first.look)
    # a column with a value for none is read by each, and so is one that differs
    assert sorted(read[4:]) == ["temp_module", "wind_speed"]
    assert second.notes == alone[1][1].notes == alone[0][1].notes
    for name in COLUMNS:
        np.testing.assert_array_equal(clean[name], alone[1][0][name])
    read.clear()
    still = stuck_rows(clean, limits, second.look)
    assert read == ["wind_speed"]
    assert still["temp_module"].sum() == 100
    for name, rows in stuck_rows(clean, limits).items():
        np.testing.assert_array_equal(still[name], rows)
