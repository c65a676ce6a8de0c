"""Where a residual lives, against residuals that are put somewhere."""

import re
import warnings

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays

from pvlib_fem._loop.results.repeated_patterns import axes_and_pairs
from pvlib_fem._statistics.axes import axes, sorted_by
from pvlib_fem._statistics.clusters import calendar_weeks
from pvlib_fem._statistics.hourly_means import Hours
from pvlib_fem._statistics.tables import Cells, largest_table

TIMES = pd.date_range("2023-01-02", periods=96 * 364, freq="15min", tz="Etc/GMT-1")
DATES = TIMES.tz_localize(None).to_numpy().astype("datetime64[D]").astype(int)
WEEKS = np.unique(calendar_weeks(DATES), return_inverse=True)[1]
ROWS = np.ones(len(TIMES))
RANDOM = np.random.default_rng(3)
WIND = RANDOM.weibull(2.0, len(TIMES)) * 3
CLOUDS = RANDOM.uniform(0.1, 1.0, len(TIMES))
SUN = CLOUDS * np.maximum(0, 900 * np.sin((TIMES.hour - 6) * np.pi / 12)).to_numpy()
DIRECTION = RANDOM.uniform(0, 360, len(TIMES))
DRIVERS = {"poa_global": SUN, "wind_speed": WIND, "wind_direction": DIRECTION}
HOUR, WEEKDAY = np.asarray(TIMES.hour), np.asarray(TIMES.day_of_week)
CLOCK = {"hour": HOUR, "month": np.asarray(TIMES.month), "weekend": WEEKDAY >= 5}


def strongest(residual, without=(), columns=DRIVERS):
    columns = {name: c for name, c in columns.items() if name not in without}
    sorts = list(axes(CLOCK | columns, DATES))
    cells = [Cells.from_axes(kind, ROWS, WEEKS) for kind in axes_and_pairs(sorts)]
    return largest_table(cells, residual, 0.0)


def noise(sd=0.5):
    return RANDOM.normal(0, sd, len(TIMES))


PLACES = {
    "hour × weekend": (
        (WEEKDAY >= 5) & (HOUR >= 9) & (HOUR < 16),
        {"hour": (9, 16), "weekend": ("weekend", "weekend")},
        "between 9 and 16 h at weekends",
    ),
    "hour × month": (
        (TIMES.month >= 6) & (TIMES.month <= 8) & (HOUR >= 13) & (HOUR < 19),
        {"hour": (13, 19), "month": (6, 8)},
        "between 13 and 19 h from June to August",
    ),
    "hour": (
        (HOUR >= 22) | (HOUR < 4),
        {"hour": (22, 4)},
        "between 22 and 4 h",  # over midnight
    ),
    "wind_direction": (
        (DIRECTION > 247.5) & (DIRECTION < 292.5),
        {"wind_direction": ("W", "W")},
        "with wind from W",
    ),
}


@pytest.mark.parametrize("name", PLACES)
def test_it_is_found_where_it_was_put(name):
    there, ranges, words = PLACES[name]
    residual = noise() + 3.0 * np.asarray(there)
    found = strongest(residual - residual.mean())
    assert found.name == name
    assert found.ranges == ranges and found.where == words
    share = np.mean(there)
    assert found.size == pytest.approx(3.0 * (1 - share), rel=0.2)
    variance = 9.0 * share * (1 - share)
    assert found.gain == pytest.approx(np.sqrt(variance), rel=0.12)


def test_its_values_are_of_other_weeks():
    """What one week has alone foretells nothing of it."""
    residual = np.zeros(len(TIMES))
    residual[: 96 * 7] = 5.0
    found = strongest(residual)
    assert found is None or found.gain < 0.3
    there = PLACES["hour × weekend"][0]
    residual = 3.0 * there - 3.0 * there.mean()
    found = strongest(residual)
    left = residual - found.values
    gain = np.sqrt(np.mean(residual**2) - np.mean(left**2))
    assert gain == pytest.approx(found.gain, rel=0.02)


@pytest.mark.parametrize("variance", [0.0, 0.05, 0.5])
def test_the_variance_of_a_table_is_recovered_from_noise_of_weeks(variance):
    """Weeks that are each off by themselves are none of it."""
    random, found = np.random.default_rng(3), []
    (axis,) = (one for one in axes(CLOCK, DATES) if one.name == "hour")
    for _ in range(40):
        own = np.sqrt(variance) * random.normal(size=24)
        weeks = random.normal(size=(WEEKS[-1] + 1, 24))  # another one in each hour
        rest = own[HOUR] + 0.7 * weeks[WEEKS, HOUR] + random.normal(size=len(HOUR))
        found.append(Cells.from_axes((axis,), ROWS, WEEKS).table(rest))
    variances = [one.variance for one in found]
    assert np.mean(variances) == pytest.approx(variance, rel=0.15, abs=0.01)
    sure = np.mean([one.errors > 3.0 for one in found])
    assert sure == 1.0 if variance else sure <= 0.05


def test_noise_lives_nowhere():
    """Not even noise that remembers a day."""
    steps = noise(1.0)
    slow = pd.Series(steps).ewm(alpha=0.02).mean().to_numpy()
    slow = slow / slow.std()
    for residual in (noise(1.0), slow):
        found = strongest(residual)
        assert found is None or found.gain < 0.12


def test_a_driver_can_be_left_out():
    there = PLACES["wind_direction"][0]
    found = strongest(noise() + 2.0 * there, without=("wind_direction",))
    assert found is None or found.gain < 0.1


def test_a_driver_that_does_not_vary_sorts_nothing():
    columns = {"still": np.full(len(TIMES), 3.0), "none": np.full(len(TIMES), np.nan)}
    names = {axis.name for axis in axes(CLOCK | columns, DATES)}
    assert names == {"hour", "weekend", "month"}


def test_few_days_have_no_weekend():
    rows = slice(0, 96 * 7)
    clock = {name: values[rows] for name, values in CLOCK.items()}
    names = {axis.name for axis in axes(clock, DATES[rows])}
    assert names == {"hour"}


def hourly(**columns):
    """Mean of each column in hours of four rows."""
    first = np.arange(0, len(TIMES), 4)
    return Hours(first, np.full(len(first), 4.0)).means_of_drivers(columns)


@pytest.mark.parametrize("name", ["wind_direction", "solar_azimuth"])
def test_the_mean_of_directions_about_north_is_north(name):
    degrees = RANDOM.normal(0.0, 15.0, len(TIMES)) % 360.0
    means = hourly(**{name: degrees})[name]
    assert (np.abs((means + 180.0) % 360.0 - 180.0) < 45.0).all()


@given(
    stored=arrays(float, len(TIMES) // 91, elements=st.floats(0.0, 360.0)),
    gaps=arrays(bool, len(TIMES) // 91),
)
def test_a_missing_value_of_a_driver_is_none(stored, gaps):
    """Neither a humidity nor a wind of zero; the others of the hour count."""
    gappy = np.where(gaps, np.nan, stored)
    first = np.arange(0, len(stored), 4)
    hours = Hours(first, np.full(len(first), 4.0))
    names = ("relative_humidity", "wind_direction")
    found = hours.means_of_drivers(dict.fromkeys(names, gappy))
    with warnings.catch_warnings(action="ignore"):
        want = np.nanmean(gappy.reshape(-1, 4), axis=1)
    np.testing.assert_allclose(found["relative_humidity"], want, rtol=1e-9)
    np.testing.assert_array_equal(np.isnan(found["wind_direction"]), np.isnan(want))


@pytest.mark.parametrize("name", ["wind_direction", "relative_humidity"])
def test_rows_without_a_driver_are_a_bin_of_their_own(name):
    """They are sorted to no value, and what lives there is said so."""
    values = np.linspace(0.0, 100.0, 2000)
    whole = sorted_by(name, values)
    values[::7] = np.nan
    axis = sorted_by(name, values)
    gone = np.isnan(values)
    last = len(axis.labels) - 1
    assert (axis.bins[gone] == last).all() and (axis.bins[~gone] < last).all()
    assert axis.labels[last] == ("missing", "missing")
    assert len(axis.labels) == len(whole.labels) + 1
    assert "missing" in axis.words([last])


def test_a_range_of_all_rows_is_no_condition():
    """That a pattern is in May and June says nothing of a record of these months."""
    rows = ROWS * np.isin(CLOCK["month"], (5, 6))
    there = (HOUR >= 8) & (HOUR < 12)
    wanted = ("hour", "month")
    sorts = [axis for axis in axes(CLOCK, DATES) if axis.name in wanted]
    table = Cells.from_axes(sorts, rows, WEEKS).table(3.0 * there + noise())
    assert table.ranges == {"hour": (8, 12), "month": (5, 6)}
    assert table.where == "between 8 and 12 h"


def test_a_pattern_after_rain_says_that_in_words():
    hours = RANDOM.uniform(0.0, 72.0, len(SUN))
    wet = strongest(-3.0 * (hours < 20.0) + noise(), {}, {"hours_since_rain": hours})
    assert re.fullmatch(r"from 0(\.\d+)? to (19|20|21|22) h after rain", wet.where)
    axis = sorted_by("hours_since_rain", np.minimum(2.0 * hours, 72.0))
    last = [len(axis.labels) - 1]
    assert re.fullmatch(r"from \d+ h after rain on", axis.words(last))


def test_a_pattern_of_the_past_says_that_in_words():
    now = np.maximum(SUN, 0.0)
    late = {
        "poa_stored_1h": np.roll(now, 4) - now,
        "air_stored": RANDOM.normal(size=len(now)),
    }
    both = (late["poa_stored_1h"] > 100.0) & (late["air_stored"] > 0.5)
    table = strongest(3.0 * both + noise(), DRIVERS, late)
    assert table.drivers == ("poa_stored_1h", "air_stored")
    assert re.fullmatch(
        r"where the irradiance of the past hour was [\d.]+ to [\d.]+ W/m² higher than "
        r"now, and the air temperature of the past 3 h was [\d.]+ to [\d.]+ K higher "
        r"than now",
        table.where,
    )
