"""Timetables against residuals that keep one, and against those that keep none."""

import numpy as np
import pandas as pd
import pytest
from scipy.signal import lfilter

from pvlib_fem.loop.criteria import Criteria
from pvlib_fem.statistics.axes import axes
from pvlib_fem.statistics.clusters import calendar_weeks
from pvlib_fem.statistics.tables import find_structure
from pvlib_fem.statistics.timetables import timetables

CRITERIA, STEP, DAY = Criteria(), 300.0, 86400.0
EVERY = pd.date_range("2023-01-02", periods=288 * 364, freq="5min", tz="Etc/GMT-1")
WEEKS = np.arange(len(EVERY)) // (288 * 7)
TIMES = EVERY[WEEKS % 5 != 2]  # as where test weeks are left out
DATES = TIMES.tz_localize(None).to_numpy().astype("datetime64[D]").astype(int)
FOLDS = np.unique(calendar_weeks(DATES), return_inverse=True)[1] % 5
SECONDS = (TIMES - TIMES[0]).total_seconds().to_numpy()
MINUTE, DAYS, HOUR = SECONDS / 60.0, DATES - DATES[0], np.asarray(TIMES.hour)
TURN = 2 * np.pi * (SECONDS / DAY % 1.0 - 0.5)
DECLINATION = -0.41 * np.cos(2 * np.pi * (DAYS + 11) / 365.25)
HEIGHT = 0.7 * np.sin(DECLINATION) + 0.7 * np.cos(DECLINATION) * np.cos(TURN)
SUN = np.maximum(HEIGHT, 0.0)  # sine of its elevation at 45°N


def remembering(seconds, seed):
    """Noise of 1 K that remembers so long."""
    kicks = np.random.default_rng(seed).normal(size=len(SECONDS) + 3000)
    keeps = np.exp(-STEP / seconds)
    return lfilter([np.sqrt(1 - keeps**2)], [1, -keeps], kicks)[3000:]


def weather(seed):
    """What sun and clouds leave: days alike, seasons, memory of hours and days."""
    clouds = np.clip(0.5 + 0.4 * remembering(2 * DAY, seed), 0.0, 1.0)
    by_day = SUN * (clouds - 0.5 * np.cos(2 * np.pi * DAYS / 365.25))
    by_night = 0.5 * clouds * (SUN == 0)
    return 2.0 * by_day - by_night + 0.3 * remembering(7200.0, seed + 1000)


NOISES = {
    "white": lambda seed: np.random.default_rng(seed).normal(size=len(SECONDS)),
    "hours": lambda seed: remembering(7200.0, seed),
    "days": lambda seed: remembering(3 * DAY, seed),
    "weeks": lambda seed: remembering(20 * DAY, seed),
    "sunny hours": lambda seed: 2.0 * SUN * remembering(7200.0, seed),
    "sunny days": lambda seed: 2.0 * SUN * remembering(3 * DAY, seed),
    "weather": weather,
    "edges": lambda seed: 2.0 * (SUN > 0.2) + 0.1 * remembering(7200.0, seed),
}


def found_in(residual):
    return timetables(residual, SECONDS, DATES, FOLDS, STEP, CRITERIA)


def strongest(residual, columns, without=()):
    sorts = [*axes(TIMES, DATES, columns, CRITERIA), *found_in(residual)]
    return find_structure(residual, SECONDS, FOLDS, sorts, STEP, CRITERIA, without)


#: where there are 1.5 K: driver, days or minutes of its period, share, words
PLANTED = {
    "1 of 3 days": (DAYS % 3 == 1, "timetable_days", 3 * 1440, 1 / 3),
    "2 of 9 days": (np.isin(DAYS % 9, (2, 6)), "timetable_days", 9 * 1440, 2 / 9),
    "Tuesdays": (DAYS % 7 == 1, "timetable_days", 7 * 1440, 1 / 7),
    "35 of 150 min": (MINUTE % 150 < 35, "timetable_minutes", 150, 35 / 150),
    "12 of 47 min": ((MINUTE + 9) % 47 < 12, "timetable_minutes", 47, 12 / 47),
    "80 of 211.7 min": (MINUTE % 211.7 < 80, "timetable_minutes", 211.7, 80 / 211.7),
}


@pytest.mark.parametrize("name", PLANTED)
def test_a_timetable_is_found(name):
    there, driver, period, share = PLANTED[name]
    residual = remembering(7200.0, 1) + 1.5 * there
    found = strongest(residual, {"poa_global": 1000 * SUN})
    assert found.name == driver
    (place,) = found.places
    assert place.period == pytest.approx(60.0 * period, rel=0.01)
    assert place.share == pytest.approx(share, abs=0.05)
    assert found.size == pytest.approx(1.5 * (1 - share), rel=0.15)
    square = 1.5**2 * share * (1 - share)
    assert found.gain**2 == pytest.approx(square, rel=0.15)


def test_it_is_told_in_words():
    residual = remembering(7200.0, 2) + 3.0 * (DAYS % 3 == 1)
    assert strongest(residual, {}).where == "on 1 of every 3 days, as on 2023-01-03"
    residual = remembering(7200.0, 2) + 3.0 * (MINUTE % 150 < 35)
    assert strongest(residual, {}).where == "in 35 of every 150 min"


@pytest.mark.parametrize("period", [47.0, 150.0, 211.7])
@pytest.mark.parametrize("noise", ["hours", "weather"])
def test_what_only_the_day_shows_is_found(period, noise):
    """Its lines have others beside them, a turn a day away."""
    there = (MINUTE % period < 0.25 * period) * np.sqrt(SUN)
    (axis,) = (
        axis
        for axis in found_in(NOISES[noise](3) + 1.5 * there)
        if axis.name == "timetable_minutes"
    )
    assert axis.period == pytest.approx(60.0 * period, rel=0.01)


@pytest.mark.parametrize(
    "there, driver, period",
    [
        (DAYS % 3 == 1, "timetable_days", 3 * 1440),
        (DAYS % 9 < 2, "timetable_days", 9 * 1440),
        (MINUTE % 150 < 35, "timetable_minutes", 150),
        (MINUTE % 47 < 12, "timetable_minutes", 47),
    ],
)
def test_it_may_keep_to_some_hours(there, driver, period):
    there = there & (HOUR >= 7) & (HOUR < 17)
    found = strongest(remembering(7200.0, 4) + 3.0 * there, {})
    assert found.drivers == ("hour", driver)
    assert found.ranges["hour"] == (7, 17)
    assert found.places[1].period == pytest.approx(60.0 * period, rel=0.01)
    square = 9.0 * there.mean() * (1 - there.mean())
    assert 0.8 * square < found.gain**2 < 1.1 * square  # cells are shrunk


@pytest.mark.parametrize("name", NOISES)
def test_noise_keeps_no_timetable(name):
    """Not one of ten; one of a hundred is let through for each of the two kinds."""
    assert [found_in(NOISES[name](seed)) for seed in range(10)] == [[]] * 10


@pytest.mark.parametrize("hours", [24, 12, 8, 6, 4, 3])
def test_what_comes_back_each_day_is_the_hours(hours):
    there = MINUTE % (60 * hours) < 20 * hours
    residual = remembering(7200.0, 5) + 2.0 * there
    assert found_in(residual) == []


def test_a_weekly_cause_is_the_weekends():
    for seed in range(6):
        residual = remembering(7200.0, seed) + 1.0 * (DAYS % 7 >= 5)
        assert found_in(residual) == []
        assert strongest(residual, {}).name == "weekend"


def test_another_timetable_is_found_beside_the_weekend():
    residual = remembering(7200.0, 6) + 2.0 * (DAYS % 7 >= 5) + 1.0 * (DAYS % 5 == 0)
    assert [axis.period for axis in found_in(residual)] == [5 * DAY]


def test_gaps_and_uneven_steps_do_not_matter():
    rows = np.random.default_rng(7).uniform(size=len(SECONDS)) < 0.6
    shaken = SECONDS + np.random.default_rng(8).uniform(-60, 60, len(SECONDS))
    residual = remembering(7200.0, 7) + 1.5 * (shaken / 60.0 % 150 < 35)
    series = (a[rows] for a in (residual, shaken, DATES, FOLDS))
    (axis,) = (
        axis
        for axis in timetables(*series, STEP, CRITERIA)
        if axis.name == "timetable_minutes"
    )
    assert axis.period == pytest.approx(9000.0, rel=1e-3)


@pytest.mark.parametrize("step", [0.5, 1, 4, 6, 24])
def test_long_steps_keep_what_they_can_show(step):
    rows = np.flatnonzero(MINUTE % (60 * step) == 0)
    series = [a[rows] for a in (SECONDS, DATES, FOLDS)]
    residual = remembering(7200.0, 9)[rows]
    assert timetables(residual, *series, 3600 * step, CRITERIA) == []
    residual = residual + 2.0 * (DAYS[rows] % 3 == 1)
    found = timetables(residual, *series, 3600 * step, CRITERIA)
    assert found[0].period == 3 * DAY


@pytest.mark.parametrize("days", [1, 3, 10, 30])
def test_few_days_keep_none(days):
    rows = days > DAYS
    series = (a[rows] for a in (NOISES["hours"](9), SECONDS, DATES, FOLDS))
    assert timetables(*series, STEP, CRITERIA) == []


@pytest.mark.parametrize(
    "name", ["hour", "weekend", "month", "timetable_days", "timetable_minutes"]
)
def test_a_column_is_never_taken_for_the_clock(name):
    quarters = (SECONDS // 900.0).astype(int)
    column = np.random.default_rng(10).uniform(size=quarters[-1] + 1)[quarters]
    residual = remembering(7200.0, 10) + 2.0 * (column > 0.7) + 2.0 * (HOUR < 6)
    found = strongest(residual, {name: column})
    assert found.drivers == ("hour", f"column {name}")
    assert found.ranges["hour"] == (0, 6)
    assert found.ranges[f"column {name}"] == pytest.approx((0.7, 1.0), abs=0.01)
    assert [place.column for place in found.places] == ["", name]
    assert strongest(residual, {name: column}, without=[name]).drivers == ("hour",)
