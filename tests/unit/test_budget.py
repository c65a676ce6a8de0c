"""All of the error is accounted for: by step, by time scale, by date."""

import json

import numpy as np
import pandas as pd
import pytest
from conftest import COLUMNS
from hypothesis import given, strategies as st
from scipy.signal import lfilter

import pvlib_fem as fem
from pvlib_fem import simulator
from pvlib_fem._budget.scales import DAYS, HOURLY, SCALES, WEEKS, WHITE, by_scale
from pvlib_fem._budget.unusual_days import episodes
from pvlib_fem.simulator import PHYSICS

#: quick to search, with a cause that no column follows
WORLD = dict(effects=PHYSICS | {"sky_radiation": 1.0}, days=150, step=1800.0)
CHANCE = fem.Criteria().max_episode_chance


def world(seed=0, **changed):
    """Half a year of the usual columns."""
    given = {**WORLD, "seed": seed, "start": "2023-03-15", **changed}
    return simulator.record(**given)[list(COLUMNS)].copy()


def adds_up(budget):
    """Reductions and the remaining error; unusual days and the scales of all others."""
    by = budget.groupby("kind")["mean_square"].sum()
    assert by["taken"] + by["left"] == pytest.approx(by["start"], rel=1e-12)
    in_time = by["scale"] + by.get("episodes", 0.0)
    assert in_time == pytest.approx(by["left"], rel=1e-12)
    assert (budget["mean_square"][budget["kind"] == "scale"] >= 0.0).all()
    return True


@pytest.fixture(scope="module")
def covered():
    """A week with an unreported cover over half of the irradiance sensor."""
    data = world()
    week = (data.index >= "2023-06-05") & (data.index < "2023-06-12")
    data.loc[week, "poa_global"] *= 0.5
    return fem.close_loop(data)


def test_the_budget_adds_up(covered):
    budget, table = covered.budget, covered.table
    assert adds_up(budget)
    squares = table["rmse_test"] ** 2
    assert budget["mean_square"].iloc[0] == squares["steady"]
    left = budget["mean_square"]["left"]
    assert left == pytest.approx(squares[covered.last], rel=1e-12)
    assert list(budget.index[budget["kind"] == "scale"]) == list(SCALES)
    steps = list(budget.index[budget["kind"] == "taken"])
    dynamics = {"ewm": "fem", "balance": "balance"}[covered.fit.dynamics]
    assert steps[0] == dynamics and steps[1] == covered.base
    assert steps[2:] == [f"+{name}" for name in covered.effects]
    assert (budget["error"] ** 2).to_numpy() == pytest.approx(
        budget["mean_square"].abs().to_numpy()
    )
    assert budget["share"].iloc[0] == 1.0
    assert set(budget["weeks"][budget["kind"] != "of which"]) == {"test"}


def test_a_covered_week_is_told_by_its_dates(covered):
    (row,) = covered.episodes.to_dict("records")
    assert row["start"] == pd.Timestamp("2023-06-05")
    assert row["end"] == pd.Timestamp("2023-06-11") and row["days"] == 7
    residual = covered.fit.residual["2023-06-05":"2023-06-11"]
    sunny = pd.Series(covered.fit.record["poa_global"] > 20, covered.fit.residual.index)
    assert row["day"] == pytest.approx(residual[sunny[residual.index]].mean())
    assert row["night"] == pytest.approx(residual[~sunny[residual.index]].mean())
    share = (residual**2).sum() / (covered.fit.residual**2).sum()
    assert row["share"] == pytest.approx(share, rel=0.01) and share > 0.3
    text = " ".join(covered.report().split())
    assert f"2023-06-05 to 2023-06-11: {row['day']:.1f} K warmer by day" in text
    assert "most of it should be in the site's log" in text
    assert "2023-06-05 to 2023-06-11" in covered.to_html()
    test = covered.weeks[residual.index] == "test"
    rows = (covered.fit.holdout & covered.fit.residual.notna()).sum()
    square = (residual[test] ** 2).sum() / rows
    apart = covered.budget["mean_square"]["on days that stand out"]
    assert apart == pytest.approx(square, rel=0.01) and square > 1.0


def test_an_error_above_one_kelvin_has_a_line_on_its_time(covered):
    assert covered.table["rmse_test"][covered.last] > 1.0
    (line,) = (
        x for x in covered.report().splitlines() if x.startswith("remaining error")
    )
    left = covered.budget["mean_square"]["left"]
    assert f"{np.sqrt(left):.2f} K remain ({left:.2f} of" in line


def test_snow_on_days_nobody_logged_is_told_by_day():
    """The module stays cold under it."""
    data = world(1, start="2023-10-01")
    snowy = pd.to_datetime(["2023-12-11", "2023-12-12", "2024-01-20", "2024-02-03"])
    under = data.index.tz_localize(None).normalize().isin(snowy)
    data.loc[under, "temp_module"] = data["temp_air"] - 1.0
    told = fem.close_loop(data, effects=[]).episodes
    days = [d for r in told.itertuples() for d in pd.date_range(r.start, r.end)]
    assert set(days) <= set(snowy) and len(days) >= 2
    assert (told["day"] < -2.0).all()


def test_they_come_back_from_a_file_to_the_bit(covered, tmp_path):
    text = covered.to_json(tmp_path / "loop.json")
    again = fem.Loop.from_json(tmp_path / "loop.json")
    for name in ("budget", "episodes"):
        both = getattr(again, name), getattr(covered, name)
        pd.testing.assert_frame_equal(*both, check_exact=True)
    assert again.to_json() == text and str(again) == str(covered)
    without = {k: v for k, v in json.loads(text).items() if k != "budget"}
    (tmp_path / "old.json").write_text(json.dumps(without), encoding="utf-8")
    with pytest.raises(ValueError, match="has no budget"):
        fem.Loop.from_json(tmp_path / "old.json")


def test_a_record_of_days_without_test_weeks_has_one_too():
    loop = fem.close_loop(world(days=1), effects=[])
    assert loop.fit.test_days == 0 and loop.episodes.empty
    assert "at least 30 days are needed to find days that stand out" in " ".join(
        loop.report().split()
    )
    assert adds_up(loop.budget) and set(loop.budget["weeks"]) == {"fitting"}


def times(days, step, start=19_000):
    """Dates, hours and seconds of a record."""
    seconds = np.arange(0.0, days * 86400.0, step)
    dates = start + (seconds // 86400.0).astype(int)
    return dates, (seconds % 86400.0 // 3600.0).astype(int), seconds


@given(seed=st.integers(0, 10**6), lost=st.floats(0.0, 0.9), days=st.integers(1, 40))
def test_scales_add_up_beside_any_gaps(seed, lost, days):
    random = np.random.default_rng(seed)
    dates, hours, seconds = times(days, 900.0)
    kept = random.uniform(size=len(dates)) >= lost
    kept[random.integers(len(kept))] = True
    residual = random.normal(size=kept.sum()).cumsum() + random.normal()
    found = by_scale(residual, dates[kept], hours[kept], seconds[kept], 900.0)
    assert list(found) == list(SCALES) and min(found.values()) >= 0.0
    square = np.mean(residual**2)
    assert sum(found.values()) == pytest.approx(square, rel=1e-9, abs=1e-12)


def test_each_scale_is_where_it_was_put(noise):
    """A sine of half a year, days of their own, a sine of the day, and white noise."""
    dates, hours, seconds = times(364, 900.0, start=18_998)  # a Monday
    day = seconds / 86400.0
    parts = {
        WEEKS: 2.0 * np.sin(2 * np.pi * day / 182.0),
        DAYS: noise(365, 1.0, 1)[dates - dates[0]],
        HOURLY: 1.5 * np.sin(2 * np.pi * day),
        WHITE: noise(len(day), 0.8, 2),
    }
    found = by_scale(sum(parts.values()), dates, hours, seconds, 900.0)
    weekly = 1.0 / 7.0  # of days by chance is their week's
    squares = {name: np.mean(part**2) for name, part in parts.items()}
    assert found[WEEKS] == pytest.approx(squares[WEEKS] + weekly, rel=0.15)
    assert found[DAYS] == pytest.approx(squares[DAYS] - weekly, rel=0.15)
    assert found[HOURLY] == pytest.approx(squares[HOURLY], rel=0.1)
    assert found[WHITE] == pytest.approx(squares[WHITE], rel=0.1)


def test_white_noise_is_told_as_such(noise):
    found = by_scale(noise(60 * 96, 1.0), *times(60, 900.0), 900.0)
    assert found[WHITE] > 0.95


def red(seed, days, memory, heavy=0):
    """Residual of each day and night, which remembers the day before."""
    random = np.random.default_rng(seed)
    shape = (2, days + 200)
    kicks = random.standard_t(heavy, shape) if heavy else random.normal(size=shape)
    series = lfilter([1.0], [1.0, -memory], kicks)[:, -days:]
    return series.T.ravel()


def stretches_of(values, chance=CHANCE):
    days = len(values) // 2
    dates = np.repeat(np.arange(days), 2)
    return episodes(values, dates, np.tile([True, False], days), chance)


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.9])
def test_noise_with_memory_has_no_episodes(memory):
    """Ten years in records of four months, at a chance of 1 in 100 each."""
    assert sum(bool(stretches_of(red(seed, 120, memory))) for seed in range(30)) == 0


def test_seasons_drifts_and_steps_are_no_episodes():
    day = np.repeat(np.arange(730.0), 2)
    slow = 5.0 * np.sin(day / 58.0) + day / 100.0 + 8.0 * (day > 400)
    assert stretches_of(red(1, 730, 0.5) + slow) == []


@given(
    first=st.integers(0, 190), length=st.integers(1, 10), sign=st.sampled_from([-1, 1])
)
def test_a_planted_stretch_is_told_by_its_dates(first, length, sign):
    values = red(3, 200, 0.3)
    last = min(first + length, 200) - 1
    values[2 * first : 2 * last + 2 : 2] += sign * 15.0
    assert stretches_of(values) == [(first, last)]


def test_one_day_without_light_inside_it_does_not_part_a_stretch():
    values = red(4, 200, 0.3)
    values[2 * 100 : 2 * 109 : 2] += 12.0
    values[2 * 104] -= 12.0
    assert stretches_of(values) == [(100, 108)]


def test_few_days_and_no_residual_tell_nothing():
    values = red(5, 25, 0.0)
    values[20] = 50.0
    assert (
        stretches_of(values) == []
        and stretches_of(np.zeros(400)) == []
        and stretches_of(values[:0]) == []
    )


def test_eight_measured_years_say_where_in_time_it_lives(bolzano):
    loop = fem.close_loop(bolzano, effects=["wind_direction"])
    assert loop.table["rmse_test"][loop.last] > 1.0 and adds_up(loop.budget)
    assert "remaining error" in loop.report()


def test_days_that_stand_out_at_golden_are_of_winter(golden):
    """Snow on the modules, which the record has no column for."""
    told = fem.close_loop(golden, effects=[]).episodes
    assert len(told) >= 3 and (told["day"] < -8.0).all()
    assert set(told["start"].dt.month) <= {10, 11, 12, 1, 2, 3, 4}


def test_a_covered_week_of_a_measured_year_is_told(bolzano):
    data = bolzano["2013":"2014"].copy()
    week = (data.index >= "2013-06-04") & (data.index < "2013-06-12")
    data.loc[week, "poa_global"] *= 0.7
    told = fem.close_loop(data, effects=[]).episodes
    spans = [(str(r.start.date()), str(r.end.date())) for r in told.itertuples()]
    assert ("2013-06-04", "2013-06-11") in spans
