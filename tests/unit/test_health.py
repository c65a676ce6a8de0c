"""Faults of sensors and loggers are found, and none where there is none."""

import dataclasses
import inspect
import re

import numpy as np
import pandas as pd
import pytest
from conftest import COLUMNS, measured
from hypothesis import given, strategies as st
from pvlib.location import Location
from scipy.signal import lfilter

import pvlib_fem as fem
from pvlib_fem import close_loop, datasets, simulator
from pvlib_fem.quality._check import check, stuck_rows
from pvlib_fem.quality._light_table import packed
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._module_lag import clock_shift
from pvlib_fem.quality._noon import solar_noon_shift
from pvlib_fem.quality._repetitions import Repetitions, most_kept
from pvlib_fem.quality._unit_checks import doubtful
from pvlib_fem.simulator import ALBUQUERQUE, OUTDOORS, RHINE

DRIVERS = (
    "wind_direction",
    "relative_humidity",
    "precipitation",
    "longwave_down",
    "snow_depth",
    "p_dc_per_area",
)


def checked(data):
    drivers = {name: data[name] for name in DRIVERS if name in data}
    return measured(*(data[name] for name in COLUMNS), **drivers)


def place(site):
    location = Location(site.latitude, site.longitude, tz=site.tz)
    return location, site.surface_tilt, site.surface_azimuth


def simulated(effects=None, days=60, step=300.0, seed=1, site=RHINE, **options):
    return simulator.record(
        site, OUTDOORS | (effects or {}), days, step, seed, **options
    )


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(("days", "step"), [(150, 300.0), (30, 60.0)])
def test_a_plain_site_has_no_fault(days, step, seed):
    record = checked(simulated({}, days, step, seed))
    for where in ((), place(RHINE)):
        found = check(record, *where)
        assert found.faults == {}
        assert found.notes == ()
        assert not found.mask.any()


def test_the_measured_records_have_no_fault(week, day):
    location = Location(35.05, -106.54, tz="Etc/GMT+7")
    assert check(checked(week), location, 35.0).notes == ()
    found = check(checked(day), location)
    assert found.faults == {}
    assert len(found.notes) == 1
    assert "shorter than two days" in found.notes[0]


def test_a_made_up_record_has_no_fault():
    assert check(checked(datasets.synthetic(days=10))).faults == {}


# sensors that are stuck


@pytest.mark.parametrize("seed", range(5))
def test_a_stuck_sensor_is_found(seed):
    """12 h once in 30 days, by day or by night."""
    data = simulated({"stuck": 1.0}, 30, 60.0, seed)
    found = check(checked(data))
    assert list(found.faults) == ["stuck"]
    as_it_was = simulated({}, 30, 60.0, seed)
    frozen = (data != as_it_was)["temp_module"].to_numpy()
    assert (found.mask & frozen).sum() > 0.99 * frozen.sum()
    assert found.stuck["temp_module"] == found.mask.sum() <= frozen.sum() + 30
    at = data.index[np.argmax(found.mask)]
    assert (
        f"temp_module is stuck at {data['temp_module'][at]:g} from {at}"
        in (found.faults["stuck"])
    )


@pytest.mark.parametrize(
    ("column", "value", "start", "hours"),
    [
        ("poa_global", 512.0, "2023-06-03 09:00", 6),
        ("poa_global", 0.0, "2023-06-03 02:00", 40),
        ("poa_global", 0.0, "2023-06-03 02:00", 12),
        ("temp_air", 17.3, "2023-06-03 08:00", 8),
        ("wind_speed", 2.5, "2023-06-03 20:00", 8),
        ("wind_speed", 0.0, "2023-06-03 20:00", 100),
        ("temp_module", 0.0, "2023-06-03 02:00", 40),
    ],
)
def test_every_column_can_be_stuck(column, value, start, hours):
    data = simulated({}, 10, 60.0, 2, start="2023-06-01")
    end = pd.Timestamp(start) + pd.Timedelta(hours=hours)
    rows = slice(start, str(end - pd.Timedelta("1min")))
    data.loc[rows, column] = value
    found = stuck_rows(checked(data))
    # the nights before and after an irradiance of 0 are of the same run
    rest = 720 if (column, value) == ("poa_global", 0) else 30
    assert 60 * hours <= found.pop(column).sum() <= 60 * hours + rest
    assert not np.any(list(found.values()))


def test_a_stuck_module_does_not_accuse_the_pyranometer():
    """Its jump at the end of a night is not warmth that the night had."""
    data = simulated({}, 10, 60.0, 2, start="2023-06-01")
    data.loc["2023-06-03 22:00":"2023-06-04 09:59", "temp_module"] = 31.0
    found = stuck_rows(checked(data))
    assert found.pop("temp_module").sum() == 720
    assert not np.any(list(found.values()))


def test_stillness_alone_is_no_fault():
    """A calm night at 0.1 K, an hour of no wind, snow that melts at 0 °C."""
    data = simulated({}, 10, 60.0, 2, start="2023-06-01")
    night = slice("2023-06-03 23:00", "2023-06-04 03:00")
    data.loc[night, ["temp_air", "temp_module"]] = [8.2, 6.9]
    data.loc["2023-06-04 12:00":"2023-06-04 20:00", "wind_speed"] = 0.0
    data.loc["2023-06-05 10:00":"2023-06-05 12:00", "temp_module"] = 0.0
    assert not np.any(list(stuck_rows(checked(data)).values()))


@pytest.mark.parametrize(("days", "dead"), [(4, False), (10, True)])
def test_a_calm_goes_on_over_nights_that_nobody_recorded(days, dead):
    """By day alone: four days have 56 h at 0, ten have 140 h; a calm has 72 h."""
    data = simulated({}, 20, 3600.0, 2, start="2023-06-01")
    data[(data.index.hour < 5) | (data.index.hour >= 19)] = np.nan
    calm = slice("2023-06-05", f"2023-06-{4 + days:02d}")
    data.loc[calm, "wind_speed"] *= 0.0
    found = stuck_rows(checked(data))
    assert found.pop("wind_speed").sum() == (14 * days if dead else 0)
    assert not np.any(list(found.values()))


def test_coarse_sensors_are_not_stuck():
    data = simulated({}, 30, 60.0, 2)
    data[["temp_air", "temp_module"]] = data[["temp_air", "temp_module"]].round()
    data["wind_speed"] = data["wind_speed"].round()
    assert not np.any(list(stuck_rows(checked(data)).values()))


def tropical(amplitude, step, smooth):
    """Air of a maritime climate by a thermometer that reads whole kelvin."""
    data = datasets.synthetic(30, step, seed=2)
    hour = data.index.hour + data.index.minute / 60.0
    keep = np.exp(-step / 7200.0)
    noise = np.random.default_rng(1).normal(size=len(data)) * np.sqrt(1.0 - keep**2)
    wander = noise if smooth else lfilter([1.0], [1.0, -keep], noise)
    air = 27.0 + amplitude * np.sin((hour - 9.0) / 12.0 * np.pi)
    over = data["temp_module"] - data["temp_air"]
    air = (air + (0.0 if smooth else 0.4) * wander).round()
    return data.assign(temp_air=air, temp_module=(air + over).round(1))


@pytest.mark.parametrize("amplitude", [1.0, 2.0, 4.0])
@pytest.mark.parametrize("step", [60.0, 600.0, 3600.0])
@pytest.mark.parametrize("smooth", [True, False])
def test_air_that_hardly_moves_is_not_stuck(amplitude, step, smooth):
    data = tropical(amplitude, step, smooth)
    assert not np.any(list(stuck_rows(checked(data)).values()))
    data.iloc[-round(80 * 3600 / step) :, list(data).index("temp_air")] = 27.0
    found = stuck_rows(checked(data))
    assert found.pop("temp_air").sum() >= round(80 * 3600 / step)
    assert not np.any(list(found.values()))


@pytest.mark.parametrize("step", [60.0, 600.0, 3600.0])
@pytest.mark.parametrize("zeros", [0, 3])
def test_an_anemometer_rests_at_its_lowest_reading(step, zeros):
    """By the offset of its calibration, 0.4 m/s in calm nights; 0 as it is started."""
    data = simulated({}, 30, step, 2, start="2023-06-01")
    data["wind_speed"] = (data["wind_speed"] + 0.35).round(1)
    night = (data.index.hour >= 20) | (data.index.hour < 7)
    data["wind_speed"] = data["wind_speed"].mask(night, 0.4)
    data.iloc[:zeros, list(data).index("wind_speed")] = 0.0
    assert not np.any(list(stuck_rows(checked(data)).values()))
    for value, hours in ((0.4, 96), (3.7, 15)):
        spoilt, rows = data.copy(), slice("2023-06-10 07:00", None)
        at = spoilt.loc[rows].index[: round(hours * 3600 / step)]
        spoilt.loc[at, "wind_speed"] = value
        found = stuck_rows(checked(spoilt)).pop("wind_speed")
        assert found[spoilt.index.isin(at)].all()
        assert found.sum() <= len(at) + 12 * 3600 / step  # and the night after


@pytest.mark.parametrize("step", [60.0, 600.0])
def test_an_anemometer_that_never_rests_is_stuck_at_a_low_value_too(step):
    """A value that few are below is no rest where the sensor does not stand."""
    data = simulated({}, 30, step, 2, start="2023-06-01")
    data["wind_speed"] = data["wind_speed"].round(2)
    low = data["wind_speed"].quantile(0.01).round(2)
    assert low > data["wind_speed"].min()
    data.loc["2023-06-10 07:00":"2023-06-10 16:59", "wind_speed"] = low
    found = stuck_rows(checked(data)).pop("wind_speed")
    assert round(36000 / step) <= found.sum() <= round(36000 / step) + 2


@pytest.mark.parametrize("step", [600.0, 3600.0])
def test_means_of_days_repeat_within_them(step):
    """They are no fault, on their first day nor where two are alike."""
    data = simulated({}, 120, step, 2)
    for name in ("temp_air", "wind_speed", "relative_humidity", "longwave_down"):
        daily = data[name].groupby(data.index.date).transform("mean")
        data[name] = daily.round(0 if name == "wind_speed" else 1)
    assert not np.any(list(stuck_rows(checked(data)).values()))


@given(
    st.lists(st.sampled_from([0.0, 1.0, 2.0, np.nan]), min_size=1, max_size=80),
    st.lists(st.integers(0, 80), max_size=4),
)
def test_repetitions_are_the_same_in_blocks(values, cuts):
    values = np.repeat(values, 7)
    seconds, limits = np.arange(len(values)) * 600.0, Limits()
    parts = np.split(np.arange(len(values)), sorted(7 * cut - 3 for cut in cuts if cut))
    for name, rest in (("wind_speed", 0.0), ("poa_global", 1.0), ("temp_air", np.nan)):
        repetitions = Repetitions(name, limits)
        for rows in filter(len, parts):
            repetitions.add(values[rows], rows[0], seconds[rows])
        whole = Repetitions(name, limits).add(values, 0, seconds)
        assert (repetitions.rows, repetitions.changes) == (whole.rows, whole.changes)
        one, other = repetitions.runs(rest), whole.runs(rest)
        for field in dataclasses.fields(one):
            part, as_one = getattr(one, field.name), getattr(other, field.name)
            np.testing.assert_array_equal(part, as_one)


@pytest.mark.parametrize("kept", [0.02, 0.5, 0.9])
def test_a_chance_is_that_of_values_kept_at_random(kept):
    """A value is kept n times with a chance of pⁿ; of 200,000 rows none is odd."""
    random = np.random.default_rng(3)
    rows = 200_000
    fresh = np.where(random.random(rows) < kept, 0, np.arange(rows))
    values = np.maximum.accumulate(fresh).astype(float)
    repetitions = Repetitions("temp_air", Limits())
    found = repetitions.add(values, 0, np.arange(rows) * 3600.0).runs(np.nan)
    most = most_kept(repetitions.rows, repetitions.changes, Limits())
    assert most == pytest.approx(np.log(1e-9) / np.log(kept), rel=0.03)
    assert len(found.first) and not found.odd.any()


@pytest.mark.parametrize("name", ["temp_module", "poa_global", "temp_air"])
def test_a_sensor_that_moves_once_is_stuck_by_what_moves_it(name):
    """Of its own changes nothing is known."""
    data = simulated({}, 20, 600.0, 2, start="2023-06-01")
    data[name] = np.where(np.arange(len(data)) < 1100, 17.0, 18.5)
    assert stuck_rows(checked(data))[name].mean() > 0.99


@pytest.mark.parametrize(
    ("column", "value"),
    [
        ("poa_global", 0.0),
        ("poa_global", 437.0),
        ("temp_air", 11.0),
        ("wind_speed", 0.0),
        ("wind_speed", 2.5),
        ("temp_module", 12.5),
    ],
)
@pytest.mark.parametrize("gaps", [False, True])
def test_a_sensor_that_never_moves_is_found_and_refused(column, value, gaps):
    """No row can be fitted; the message says which sensor, and what to do."""
    data = simulated({}, 20, 600.0, 2, start="2023-06-01")
    data[column] = value
    if gaps:
        data.loc[np.random.default_rng(0).random(len(data)) < 0.3, column] = np.nan
    there = data[column].notna().to_numpy()
    found = stuck_rows(checked(data))
    assert np.array_equal(found[column], there)
    seen = data.index[there]
    line = rf"{column} is stuck at {value:g} for the whole record, from {seen[0]}"
    for refusing in (lambda: check(checked(data)), lambda: close_loop(data)):
        with pytest.raises(ValueError) as error:
            refusing()
        assert line in str(error.value)
        assert f"name the column of a sensor that moves as {column}" in str(error.value)


def test_a_polar_night_is_no_stuck_pyranometer():
    data = simulated({}, 40, 600.0, 2, start="2023-06-01")
    data["poa_global"] = 0.0
    data["temp_module"] = data["temp_air"]
    assert not stuck_rows(checked(data))["poa_global"].any()


def test_every_limit_says_what_it_is_and_its_unit():
    assert len(dataclasses.fields(Limits)) <= 40
    text = inspect.getdoc(Limits).split("Attributes")[1]
    for field in dataclasses.fields(Limits):
        assert re.search(rf"^.*\b{field.name}\b.* : (float|int)$", text, re.M)
    entries = re.split(r"\n\w.* : (?:float|int)\n", text)[1:]
    assert entries
    for entry in entries:
        unit = r"\[(-|s|K|days|W/m²)\]$"
        assert re.search(unit, entry.rstrip()), entry


def test_limits_are_an_argument_and_checked():
    data = simulated({"stuck": 1.0}, 30, 60.0, 1)
    found = check(checked(data), limits=Limits(response_time=86400.0))
    assert found.faults == {}
    with pytest.raises(ValueError, match="response_time = 0 must be more than 0"):
        Limits(response_time=0)


# times


@pytest.mark.parametrize(
    ("rows", "time", "years"),
    [
        (0, "0023-06-01", "the row at 0023-06-01 00:00:00 is 2000 years before"),
        (0, "1970-01-01", "the row at 1970-01-01 00:00:00 is 53 years before"),
        (-1, "9999-01-01", "the row at 9999-01-01 00:00:00 is 7976 years after"),
    ],
)
def test_a_stray_time_is_refused_by_name(rows, time, years):
    data = simulated({}, 10, 60.0, 2, start="2023-06-01").tz_localize(None)
    times = data.index.as_unit("s").to_numpy().copy()
    times[rows] = np.datetime64(time)
    data.index = pd.DatetimeIndex(times)
    with pytest.raises(ValueError, match=years) as error:
        close_loop(data)
    assert "a logger that lost its clock; drop such rows" in str(error.value)
    assert re.search(years, " ".join(fem.screen_record(data).notes))
    assert abs(clock_shift(checked(data)).late) < 60


@pytest.mark.parametrize("side", [1, 3, 10])
@given(days=st.sets(st.integers(0, 3_000_000), min_size=1, max_size=40))
def test_days_of_any_gap_take_few_rows_of_a_table(side, days):
    """A stray time is millennia away; within a window nothing changes."""
    days = np.array(sorted(days))
    packed_days = packed(days, side)
    assert packed_days[0] == 0 and packed_days[-1] <= (side + 1) * len(days)
    apart, kept = (np.subtract.outer(some, some) for some in (days, packed_days))
    near = np.abs(apart) <= side
    assert (kept[near] == apart[near]).all() and (np.abs(kept[~near]) > side).all()


def test_two_campaigns_years_apart_are_one_record():
    first, second = (
        simulated({}, 20, 600.0, 2, start=start).tz_localize(None)
        for start in ("2015-06-01", "2023-06-01")
    )
    assert check(checked(pd.concat((first, second)))).faults == {}


# whole files


@pytest.mark.parametrize("where", [(), place(RHINE)], ids=["nowhere", "located"])
@pytest.mark.parametrize("step", [300.0, 3600.0])
def test_a_file_in_daylight_saving_time_is_found_with_its_dates(where, step):
    data = simulated({"file_dst": 1.0}, 365, step)
    found = check(checked(data), *where)
    assert list(found.faults) == ["file_dst"]
    days, hours = zip(*found.noon.jumps)
    assert hours == (3600.0, -3600.0)
    for day, date in zip(days, ("2023-03-26", "2023-10-29")):
        assert abs(day.tz_localize(None) - pd.Timestamp(date)) < pd.Timedelta("5D")


def test_a_logger_in_daylight_saving_time_is_not_the_file():
    found = check(checked(simulated({"dst": 1.0}, 365)), *place(RHINE))
    assert list(found.faults) == ["dst"]
    assert not found.mask.any()


def test_a_file_with_its_zone_moves_by_no_hour():
    """Daylight saving is in the zone of the index, where it belongs."""
    data = simulated({}, 60, start="2023-03-01").tz_convert("Europe/Berlin")
    assert check(checked(data), *place(RHINE)).faults == {}


@pytest.mark.parametrize("site", [RHINE, ALBUQUERQUE])
@pytest.mark.parametrize("minutes", [-120, -45, 60])
def test_a_file_in_another_zone_is_found(site, minutes):
    data = simulated({"file_shift": minutes}, site=site)
    found = check(checked(data), *place(site))
    assert list(found.faults) == ["file_shift"]
    assert found.noon.late / 60 == pytest.approx(minutes, abs=6)
    way = "ahead of" if minutes > 0 else "behind"
    assert f"{abs(found.noon.late) / 60:.0f} min {way} the sun" in found.notes[0]
    assert check(checked(data)).faults == {}


def test_times_without_a_zone_are_the_locations_standard_time():
    data = simulated(start="2023-05-01").tz_localize(None)
    location = Location(RHINE.latitude, RHINE.longitude, tz="Europe/Berlin")
    assert abs(solar_noon_shift(data["poa_global"], data.index, location).late) < 360
    location = Location(RHINE.latitude, RHINE.longitude, tz="Asia/Tokyo")
    noon = solar_noon_shift(data["poa_global"], data.index, location)
    assert noon.late == pytest.approx(-8 * 3600, abs=360)
    assert "480 min behind the sun" in noon.faults["file_shift"]


@pytest.mark.parametrize(
    "effects", [{"poa_misalignment": 10.0}, {"shading_sensor": 1.0}]
)
def test_a_turned_or_shaded_sensor_is_no_clock(effects):
    data = simulated(effects, site=ALBUQUERQUE)
    found = check(checked(data), *place(ALBUQUERQUE))
    assert found.faults == {}
    assert abs(found.noon.late) < 600


@pytest.mark.parametrize("azimuth", [90.0, 270.0])
def test_a_plane_to_the_east_or_west_has_its_own_noon(azimuth):
    site = simulator.Site(surface_azimuth=azimuth, surface_tilt=60.0)
    found = check(checked(simulated(site=site)), *place(site))
    assert found.faults == {}
    assert abs(found.noon.late) < 1200


# units


@pytest.mark.parametrize(
    ("column", "change", "reason"),
    [
        ("relative_humidity", lambda x: x / 100, "a fraction; multiply it by 100"),
        ("relative_humidity", lambda x: x * 10, "it should be in %"),
        ("longwave_down", lambda x: x - 400, "net signal needs"),
        ("wind_direction", np.radians, "radians; multiply it by 57.3 for °"),
        ("wind_direction", lambda x: x - 180, "use it modulo 360"),
        ("precipitation", lambda x: x - 0.1, "a counter needs its resets taken out"),
        (
            "p_dc_per_area",
            lambda x: 1.6 * 20 * x,
            "and no module gives 0.4; divide W by",
        ),
    ],
)
def test_a_driver_in_another_unit_is_doubted(column, change, reason):
    data = simulated({}, 10)
    data[column] = change(data[column])
    found = check(checked(data))
    assert list(found.doubtful) == [column]
    assert found.faults[f"units:{column}"].startswith(column)
    assert reason in found.faults[f"units:{column}"]


@pytest.mark.parametrize("step", [60, 600, 3600])
@pytest.mark.parametrize("places", [1, 3])
def test_a_counter_of_rain_is_told_from_rain(step, places):
    """Also with a reset each night, if rows are short of an hour."""
    data = fem.simulator.record(days=150 if step > 60 else 60, step=step)
    rain = data["precipitation"].round(places)
    hourly = rain.resample("h").mean().reindex(rain.index, method="ffill")
    for sound in (rain, hourly, rain.iloc[::-1].reset_index(drop=True)):
        assert doubtful({"precipitation": sound}) == {}
    amount = rain * step / 3600.0
    counters = [amount.cumsum(), amount.groupby(amount.index.date).cumsum()]
    for counter in counters[: 1 + (step < 3600)]:
        (reason,) = doubtful({"precipitation": counter}).values()
        assert "as a counter does; write what fell in each step" in reason


def test_kelvin_is_refused_or_doubted():
    """The four columns are physically impossible in kelvin, others are doubted."""
    data = simulated({}, 10)
    for column in ("temp_air", "temp_module"):
        with pytest.raises(ValueError, match=f"{column} is physically impossible|in K"):
            checked(data.assign(**{column: data[column] + 273.15}))
    assert "subtract 273.15" in doubtful({"temp_dew": [280.0, 290.0]})["temp_dew"]


def test_drivers_without_a_value_are_not_doubted():
    assert doubtful({"relative_humidity": [np.nan], "snow_depth": [0.0]}) == {}


def test_a_snow_gauge_may_read_a_little_below_zero_at_times():
    depth = np.r_[np.zeros(500), np.full(500, 7.0)]
    assert doubtful({"snow_depth": np.r_[depth, -0.1]}) == {}
    off = doubtful({"snow_depth": depth - 0.5})["snow_depth"]
    assert off == "is -0.5 at least; set the zero of the gauge"
