"""Single checks of sensors find what is put in, in both signs, and no more."""

import numpy as np
import pandas as pd
import pytest
from pvlib.location import Location

from pvlib_fem import detect, simulator
from pvlib_fem.simulator import OUTDOORS, RHINE

PLACE = {
    "location": Location(RHINE.latitude, RHINE.longitude, tz=RHINE.tz),
    "surface_tilt": RHINE.surface_tilt,
    "surface_azimuth": RHINE.surface_azimuth,
}
DAY = "2024-06-15"


@pytest.fixture(scope="module")
def record():
    """Three hourly years, with power that does not depend on the sensor."""
    data = simulator.record(RHINE, OUTDOORS, 1100, 3600.0, 3)
    random = np.random.default_rng(4)
    warm = 1.0 - 0.004 * (data["temp_module"] - 25.0)
    light = data["poa_global"].clip(lower=0.0)
    data["power"] = 6.0 * light * warm * np.exp(random.normal(0.0, 0.02, len(data)))
    mast = data["wind_speed"] * np.exp(random.normal(0.0, 0.2, len(data)))
    return data.assign(mast=mast)


def by_power(record):
    return {"power": record["power"], "temp_module": record["temp_module"]}


def after(series, by, day=DAY):
    return series.where(
        series.index < pd.Timestamp(day, tz=series.index.tz), series * by
    )


def years(series):
    return (series.index - series.index[0]) / pd.Timedelta("365.2425D")


def near(day, true, days=4):
    return abs(day - pd.Timestamp(true)) <= pd.Timedelta(days=days)


@pytest.mark.parametrize("how", ["sky", "power", "both"])
def test_a_sound_irradiance_sensor_has_no_change(record, how):
    given = {"sky": PLACE, "power": by_power(record)}
    given["both"] = given["sky"] | given["power"]
    found = detect.irradiance_changes(record["poa_global"], **given[how])
    assert not found.steps and not found.drifts and not found.changed.any()
    assert not found.changepoints.any()


@pytest.mark.parametrize("by", [0.85, 0.92, 1.08, 1.15])
def test_a_step_of_the_irradiance_sensor_is_found(record, by):
    for given in (by_power(record), by_power(record) | PLACE):
        found = detect.irradiance_changes(after(record["poa_global"], by), **given)
        ((day, size),) = found.steps
        assert near(day, DAY) and size == pytest.approx(by - 1.0, abs=0.015)
        assert not found.drifts
        assert found.changepoints.sum() == 1 and found.changepoints[day]
        assert found.changed.any() and not found.changed.all()


@pytest.mark.parametrize("by", [0.85, 1.15])
def test_a_clear_sky_is_enough_for_a_large_step(record, by):
    found = detect.irradiance_changes(after(record["poa_global"], by), **PLACE)
    ((day, size),), ((first, last),) = found.steps, found.within
    assert size == pytest.approx(by - 1.0, abs=0.03)
    slack = pd.Timedelta(days=20)  # between clear days
    assert first - slack <= pd.Timestamp(DAY) <= last + slack and day == last


@pytest.mark.parametrize("rate", [-0.04, 0.04])
def test_a_drift_is_no_step(record, rate):
    sensor = record["poa_global"]
    sensor = sensor * np.exp(rate * years(sensor))
    for given in (by_power(record), by_power(record) | PLACE, PLACE):
        found = detect.irradiance_changes(sensor, **given)
        assert not found.steps
        assert abs(found.drift - rate) < 3.0 * found.drift_error
        assert found.drifts and np.sign(found.drift) == np.sign(rate)


@pytest.mark.parametrize("by", [0.85, 1.15])
def test_a_plant_that_changes_is_no_change_of_the_sensor(record, by):
    """Power alone cannot say which of the two it is; the sky can."""
    given = by_power(record) | {"power": after(record["power"], by)}
    alone = detect.irradiance_changes(record["poa_global"], **given)
    assert len(alone.steps) == 1
    both = detect.irradiance_changes(record["poa_global"], **given, **PLACE)
    assert not both.steps and not both.changed.any()


@pytest.mark.parametrize("by", [0.7, 0.85, 1.2])
def test_a_step_of_an_anemometer_is_found_by_another(record, by):
    found = detect.slow_anemometer(after(record["wind_speed"], by), record["mast"])
    ((day, size),) = found.steps
    assert near(day, DAY) and size == pytest.approx(by - 1.0, abs=0.04)


@pytest.mark.parametrize("rate", [-0.1, 0.1])
def test_a_drift_of_an_anemometer_is_found_by_another(record, rate):
    wind = record["wind_speed"]
    found = detect.slow_anemometer(wind * np.exp(rate * years(wind)), record["mast"])
    assert found.drifts and found.drift == pytest.approx(rate, abs=0.02)
    assert not found.steps


@pytest.mark.parametrize("share", [-0.2, 0.2])
def test_a_drift_is_a_share_of_the_year_before(record, share):
    wind = record["mast"] * (1.0 + share) ** years(record["mast"])
    found = detect.slow_anemometer(wind, record["mast"])
    assert found.drift == pytest.approx(share, abs=0.003)


def test_usual_wind_shows_large_steps_alone(record):
    slow = detect.slow_anemometer(after(record["wind_speed"], 0.5))
    ((day, size),) = slow.steps
    assert near(day, DAY, 10) and -0.7 < size < -0.3
    for by in (0.9, 1.0, 1.1):
        found = detect.slow_anemometer(after(record["wind_speed"], by))
        assert not found.steps and not found.drifts


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_a_detached_sensor_is_found_and_so_is_its_return(record, share):
    data = record["2023-01-01":"2023-09-30"]
    air, module = data["temp_air"], data["temp_module"].copy()
    off = slice("2023-04-01", "2023-05-31")
    module[off] = air[off] + share * (module - air)[off]
    columns = air, data["poa_global"]
    found = detect.detached_module_sensor(module, *columns)
    assert found.detached.dtype == bool
    assert found.detached["2023-04-03":"2023-05-29"].all()
    assert not found.detached[:"2023-03-29"].any()
    assert not found.detached["2023-06-03":].any()
    whole = detect.detached_module_sensor(data["temp_module"], *columns)
    assert not whole.detached.any() and 0.01 < whole.attached < 0.06
    never = detect.detached_module_sensor(
        air + 0.1 * (data["temp_module"] - air), *columns
    )
    assert never.detached.all() and np.isnan(never.attached)


@pytest.mark.parametrize("by", [0.6, 1.5])
def test_a_shift_of_a_stream_is_found_in_rows_and_in_daily_sums(record, by):
    stream = after(record["power"], by)
    for series in (stream, stream.resample("1D").sum().tz_localize(None)):
        found = detect.data_shifts(series)
        ((day, size),) = found.steps
        assert near(day, DAY, 14) and size == pytest.approx(by - 1.0, abs=0.1)
        assert np.isnan(found.drift) and not found.drifts
    assert not detect.data_shifts(record["power"]).steps


def test_what_cannot_be_compared_is_refused(record):
    poa, wind = record["poa_global"], record["wind_speed"]
    with pytest.raises(ValueError, match="give location, or power"):
        detect.irradiance_changes(poa)
    with pytest.raises(TypeError, match="power is a float; give a pandas Series"):
        detect.irradiance_changes(poa, power=3.0)
    with pytest.raises(ValueError, match=r"fewer than 20 days .* clear sky"):
        detect.irradiance_changes(poa[:480], **PLACE)
    with pytest.raises(ValueError, match="different indexes"):
        detect.slow_anemometer(wind, record["mast"][:-5])
    with pytest.raises(ValueError, match="one and a half years are needed"):
        detect.data_shifts(poa[:5000])
    with pytest.raises(ValueError, match="0 days have sun"):
        detect.detached_module_sensor(poa * 0, poa * 0, poa * 0)


@pytest.mark.parametrize("check", ["module", "irradiance", "wind", "stream", "clock"])
def test_a_series_that_is_none_is_refused_by_name(record, check):
    poa = record["poa_global"]
    place = Location(RHINE.latitude, RHINE.longitude, tz=RHINE.tz)
    calls = {
        "module": lambda: detect.detached_module_sensor(None, poa, poa),
        "irradiance": lambda: detect.irradiance_changes(None, power=poa),
        "wind": lambda: detect.slow_anemometer(None, poa),
        "stream": lambda: detect.data_shifts(None),
        "clock": lambda: detect.time_shifts(None, place),
    }
    with pytest.raises(TypeError, match=r"is a NoneType; give a pandas Series"):
        calls[check]()


def test_a_comparison_that_fails_has_the_name_of_its_argument(record):
    poa, wind = record["poa_global"], record["wind_speed"]
    with pytest.raises(ValueError, match="be compared with power; "):
        detect.irradiance_changes(poa, power=0.0 * poa)
    with pytest.raises(ValueError, match="be compared with reference; "):
        detect.slow_anemometer(wind, 0.0 * wind)
