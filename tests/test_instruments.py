"""Instruments and mountings that change: from a date on, slowly, for a while."""

import json
import pickle
from dataclasses import replace
from itertools import combinations

import numpy as np
import pandas as pd
import pytest
import study_instruments
from conftest import COLUMNS, DRIVERS
from hypothesis import given, strategies as st
from test_effects import coefficients, model_with

import pvlib_fem as fem
from pvlib_fem import datasets
from pvlib_fem.effects import CHANGES, CHANNELS, find
from pvlib_fem.effects.courses import (
    find_episode,
    find_step,
    number,
    same_date,
    sudden,
    weights_of,
)
from pvlib_fem.findings import Verdict
from pvlib_fem.loop.close import searched
from pvlib_fem.loop.evidence import Evidence
from pvlib_fem.loop.propose import Proposals, slow_ones
from pvlib_fem.loop.rules import weighed
from pvlib_fem.reasons import Reason, because
from pvlib_fem.statistics.changes import Daily, chance_of_step
from pvlib_fem.statistics.clusters import cluster_sums
from pvlib_fem.thermal.model import ThermalModel
from pvlib_fem.thermal.steady import STEADY_MODELS

#: sizes that are found outdoors
SIZES = {
    "sensitivity": 0.1,
    "contact": -0.15,
    "mounting": -0.15,
    "wind_gain": 3.0,
    "wind_stall": 4.0,
    "air_offset": 1.0,
    "air_shelter": 2.0,
    "module_offset": 1.0,
}
#: dates amid the record of ``years``
DATES = {
    "step": {"at": "2023-09-15"},
    "drift": {"since": "2023-06-01"},
    "episode": {"start": "2023-08-01", "end": "2023-10-20"},
}
every = pytest.mark.parametrize("name", CHANGES)


def course(name):
    return name.rsplit("_", 1)[1]


def size(name):
    (row,) = CHANGES[name].parameters.values()
    return float(
        np.clip(SIZES[name.rsplit("_", 1)[0]], 0.8 * row.lower, 0.8 * row.upper)
    )


def dated(name, **dates):
    return find({"name": name, **(dates or DATES[course(name)])})


@pytest.fixture(scope="module")
def half_a_year():
    """Two hundred days at half an hour, whose sensor has an error of hours."""
    return datasets.synthetic(200, 1800, seed=3, noise=0).tz_localize(None)


def with_change(data, *names, seed=0, noise=0.4, **sizes):
    """The record whose module answers changes of some names."""
    effects = tuple(map(dated, names))
    model = ThermalModel(STEADY_MODELS["faiman"], "balance", effects)
    values = coefficients("balance")
    for name, effect in zip(names, effects):
        (key,) = effect.rows()
        values[key] = sizes.get(name, size(name))
        if effect.channel == "wind_gain":  # so much less is read of the same wind
            days = (data.index.normalize() - pd.Timestamp(0)).days
            less = 1.0 + values[key] * weights_of(effect, days) / values["u1"]
            data = data.assign(wind_speed=data["wind_speed"] / less)
    module = model.predict(*(data[n] for n in DRIVERS), values)
    random = np.random.default_rng(seed).normal(0.0, noise, len(data))
    rest = pd.Series(random, data.index).ewm(halflife=4).mean() * 2.0
    return data[list(DRIVERS)].assign(temp_module=module + rest), values


@every
def test_before_and_after_its_course_a_change_is_nothing_and_all(half_a_year, name):
    """An episode of all days is the channel itself; at its start nothing is added."""
    channel = next(c for c in CHANNELS if name.rsplit("_", 1)[0] == c.name)
    usual = [half_a_year[n] for n in DRIVERS]
    plain = model_with("balance").predict(*usual, coefficients("balance"))

    def answer(effect, value):
        model = ThermalModel(STEADY_MODELS["faiman"], "balance", (effect,))
        (key,) = effect.rows()
        return model.predict(*usual, {**coefficients("balance"), key: value})

    np.testing.assert_allclose(answer(dated(name), 0.0), plain, rtol=1e-12)
    found = answer(dated(name), size(name))
    if course(name) == "drift":
        year = answer(dated(name, since="2022-06-01"), size(name))
        whole = answer(channel, size(name))
        at = pd.Timestamp("2023-06-01 18:00")
        assert year[at] - plain[at] == pytest.approx(whole[at] - plain[at], rel=0.02)
        return
    first = number(next(iter(DATES[course(name)].values())))
    before = (half_a_year.index - pd.Timestamp(0)) / pd.Timedelta("1D") < first
    np.testing.assert_allclose(found[before], plain[before], rtol=1e-12)
    whole = answer(channel, size(name))
    inside = slice("2023-09-20", "2023-10-15")  # beyond the module's memory
    np.testing.assert_allclose(found[inside], whole[inside], atol=1e-6)


@every
def test_a_change_of_known_dates_is_fitted(half_a_year, name):
    data, values = with_change(half_a_year, name)
    fit = fem.fit_fem(
        *(data[n] for n in COLUMNS),
        model="faiman",
        dynamics="balance",
        night=True,
        effects=[dated(name)],
    )
    (key,) = dated(name).rows()
    assert abs(fit.coefficients[key] - values[key]) < 4 * fit.stderr[key]


@every
def test_a_change_weighs_as_much_as_its_exact_answer(half_a_year, name):
    """Beside the fit it is the channel's tangent from its date on, without a memory."""
    data, _ = with_change(half_a_year, name)
    how = dict(holdout=None, effects=[name], check_units=True, fixed=None)
    how |= dict(criteria=fem.Criteria(min_gain=9.0))  # nothing is added
    search, _ = searched(data, "faiman", (None, None, None), None, **how)
    step = search.steps["balance"]
    quick = search.fits.gathered(step, [CHANGES[name]])
    effect = quick.effects[name]
    exact = search.fits.gathered(step, [effect])
    (key,) = effect.rows()
    square = np.mean(exact.columns[key] ** 2)
    gap = np.mean((quick.columns[key] - exact.columns[key]) ** 2)
    assert gap < 1e-4 * square  # a hundredth of its root mean square
    one, other = quick.weigh(name), exact.weigh(name)
    assert one.gain == pytest.approx(other.gain, rel=2e-3)
    assert one.coefficients[key] == pytest.approx(other.coefficients[key], rel=2e-3)
    assert one.stderr[key] == pytest.approx(other.stderr[key], rel=1e-2)


@pytest.mark.parametrize("size", [-0.2, 0.2, 0.4])
@pytest.mark.parametrize("name", ["contact_step", "mounting_step"])
def test_a_share_is_one_of_what_was_there_before(half_a_year, name, size):
    """Of the model's own over-temperature or loss, by a fit and by the loop."""
    data, values = with_change(half_a_year, name, **{name: size})
    usual = [data[n] for n in COLUMNS]
    how = dict(model="faiman", dynamics="balance", night=True)
    fit = fem.fit_fem(*usual, **how, effects=[dated(name)])
    loop = closed(data, effects=[name])
    assert loop.effects == [name]
    for one in (fit, loop.fit):
        (key,) = dated(name).rows()
        assert abs(one.coefficients[key] - size) < 4 * one.stderr[key]
        assert one.coefficients["u0"] == pytest.approx(values["u0"], rel=0.01)


@every
def test_it_is_found_again_by_its_name_and_its_dates(name):
    effect = dated(name)
    again = find(json.loads(json.dumps(effect.spec)))
    assert again.settings == effect.settings and again.rows() == effect.rows()
    assert pickle.loads(pickle.dumps(effect)).spec == effect.spec


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ({"name": "contact_step", "at": "April"}, "'April' is no date"),
        ({"name": "contact_step", "on": "2012-04-01"}, "has no setting on"),
        (
            {"name": "contact_episode", "start": "2012-04-02", "end": "2012-04-01"},
            "is not before end",
        ),
    ],
)
def test_dates_that_are_none_are_refused(spec, words):
    with pytest.raises(ValueError, match=words):
        find(spec)


def test_a_step_without_its_date_says_how_to_give_it(half_a_year):
    with pytest.raises(ValueError, match="contact_step has no date; give at, as"):
        fem.fit_fem(
            *(half_a_year[n] for n in COLUMNS), model="faiman", effects="contact_step"
        )


def daily(rest, own, dates):
    """Products by the day beside a constant."""
    columns = [np.ones(len(rest)), own]
    return Daily.of(cluster_sums(columns, rest, dates), 1, [0])


def by_day_weights(rest, own, dates):
    """A constant, the column and the residual, by the root of a day's weight."""
    sums = cluster_sums([np.ones(len(rest))], rest, dates)
    root = np.sqrt(np.repeat(sums.day_weights([0]), np.bincount(dates)))
    return root, own * root, rest * root


@given(st.integers(0, 2**32 - 1), st.integers(3, 9), st.integers(2, 5))
def test_the_best_step_is_that_of_all_fits(seed, days, rows):
    """Against least squares of every date, row by row."""
    random = np.random.default_rng(seed)
    dates = np.repeat(np.arange(days), rows)
    own, rest = random.normal(size=(2, len(dates)))
    found = daily(rest, own, dates).step(1)
    ones, own, rest = by_day_weights(rest, own, dates)
    left = []
    for start in range(1, days):
        both = np.column_stack([ones, own * (dates >= start)])
        left.append((rest - both @ np.linalg.lstsq(both, rest, rcond=None)[0]) ** 2)
    squares = [one.sum() for one in left]
    best = ((rest - ones * (ones @ rest) / (ones @ ones)) ** 2).sum() - min(squares)
    assert found.gain == pytest.approx(best, rel=1e-5)
    assert found.start == 1 + int(np.argmin(squares))


@given(st.integers(0, 2**32 - 1), st.integers(5, 9), st.integers(2, 5))
def test_the_best_episode_is_that_of_all_fits(seed, days, rows):
    """Against least squares of every two dates, row by row."""
    random = np.random.default_rng(seed)
    dates = np.repeat(np.arange(days), rows)
    drawn = random.normal(size=(2, len(dates)))
    found = daily(*drawn, dates).episode(2, 1)
    ones, own, rest = by_day_weights(*drawn, dates)
    left = {}
    for start, end in combinations(range(1, days), 2):
        if end - start >= 2:
            there = (dates >= start) & (dates < end)
            both = np.column_stack([ones, own * there])
            rests = rest - both @ np.linalg.lstsq(both, rest, rcond=None)[0]
            left[start, end] = rests @ rests
    best = ((rest - ones * (ones @ rest) / (ones @ ones)) ** 2).sum()
    assert found.gain == pytest.approx(best - min(left.values()), rel=1e-5)
    assert (found.start, found.end) == min(left, key=left.get)


@given(st.integers(0, 2**32 - 1), st.integers(4, 9), st.integers(3, 5))
def test_the_best_step_that_fades_is_that_of_all_fits(seed, days, rows):
    """Against least squares of every date, row by row."""
    random = np.random.default_rng(seed)
    dates = np.repeat(np.arange(days), rows)
    drawn = random.normal(size=(2, len(dates)))
    ones, own, rest = by_day_weights(*reversed(drawn), dates)
    left = []
    for start in range(1, days):
        both = np.column_stack([ones, own * (dates >= start), own * dates])
        left.append((rest - both @ np.linalg.lstsq(both, rest, rcond=None)[0]) ** 2)
    best = ((rest - ones * (ones @ rest) / (ones @ ones)) ** 2).sum()
    best -= min(one.sum() for one in left)
    found = daily(*reversed(drawn), dates).step_that_fades(1)
    assert found == pytest.approx(best, rel=1e-5)


def test_a_step_that_fades_is_no_episode():
    """Nor is an episode one: what has come and gone is told from what wears off."""
    random, days = np.random.default_rng(2), np.arange(1500)
    own = np.ones(1500) + 0.1 * random.normal(size=1500)
    late = days >= 500
    courses = {"fades": late * (1.2 - days / 1000), "ends": late & (days < 1100)}
    for name, course in courses.items():
        rest = own * course + 0.3 * random.normal(size=1500)
        best, criteria = daily(rest, own, days), fem.Criteria()
        sloped = best.step_that_fades(criteria.change_side)
        found = find_episode(replace(best, sloped=sloped), criteria)
        assert find_episode(best, criteria) is not None
        assert (found is None) == (name == "fades")


@pytest.mark.parametrize(
    ("square", "chance"), [(7.17, 0.1), (8.85, 0.05), (12.35, 0.01)]
)
def test_the_chance_of_a_step_is_that_of_the_tables(square, chance):
    """Andrews (1993), table I, one parameter, 15 % left out at either end."""
    found = chance_of_step(np.sqrt(square), 0.15, 0.85)
    assert found == pytest.approx(chance, rel=0.12)


def test_days_of_snow_do_not_hide_a_date():
    """Half a noise from a day on, in a year of which two weeks are left by 8 of it."""
    random, days = np.random.default_rng(4), np.arange(365)
    dates = np.repeat(days, 12)
    own = np.ones(len(dates)) + 0.1 * random.normal(size=len(dates))
    noise = np.repeat(random.normal(0.0, 0.3, 365), 12) + random.normal(size=len(dates))
    snow = -8.0 * np.isin(dates, [*range(10, 17), *range(40, 47)])
    rest = own * 0.5 * (dates >= 200) + noise + snow
    criteria = fem.Criteria()
    sums = cluster_sums([np.ones(len(rest)), own], rest, dates)
    alike = Daily.turned(sums.sums, sums.weeks, sums.dates)
    assert sudden(alike, criteria) is None
    found = find_step(daily(rest, own, dates), criteria)
    low, high = map(number, found["between"])
    assert low <= 200 <= high and high - low < 15


@pytest.mark.parametrize("down", [1.5, 2.2, 3.0])
def test_a_step_that_a_drift_hides_has_its_date(down):
    """Up at once and down over years: by itself none is seen, or at another date."""
    random, days = np.random.default_rng(3), np.arange(1500)
    own = np.ones(1500) + 0.1 * random.normal(size=1500)
    rest = own * ((days >= 500) - down * days / 1500) + 0.5 * random.normal(size=1500)
    best, criteria = daily(rest, own, days), fem.Criteria()
    alone = sudden(best, criteria)
    assert alone is None or abs(alone.start - 500) > 400
    found = find_step(best, criteria)
    assert abs(number(found["at"]) - 500) <= 2
    assert number(found["between"][1]) - number(found["between"][0]) < 15
    # nor is what is there for a while a step and a drift
    stretch = own * ((days >= 300) & (days < 1100)) + 0.1 * random.normal(size=1500)
    assert find_step(daily(stretch, own, days), criteria) is None


def test_the_chance_of_a_step_beside_a_drift_is_that_of_noise():
    random, days = np.random.default_rng(0), np.arange(500)
    usual = np.linalg.qr(np.column_stack([np.ones(500), days]))[0]
    late = (days >= days[:, None])[50:450].astype(float)
    late -= (late @ usual) @ usual.T
    late /= np.sqrt(np.square(late).sum(axis=1))[:, None]
    largest = np.abs(random.normal(size=(4000, 500)) @ late.T).max(axis=1)
    for chance in (0.1, 0.05, 0.01):
        found = chance_of_step(np.quantile(largest, 1.0 - chance), 0.1, 0.9, True)
        assert chance < found < 1.6 * chance  # the approximation is on the safe side


def test_noise_that_remembers_weeks_shows_a_step_as_rarely_as_is_stated():
    """A hundred years of daily noise with a memory of five days: no step."""
    random, found = np.random.default_rng(1), 0
    for _ in range(100):
        noise = pd.Series(random.normal(size=365)).ewm(halflife=5).mean().to_numpy()
        dates = np.arange(365)
        best = daily(noise, np.ones(365) + 0.1 * random.normal(size=365), dates)
        found += find_step(best, fem.Criteria()) is not None
    assert found <= 1


def closed(data, **options):
    return fem.close_loop(data, check_units=False, **options)


@pytest.mark.parametrize("channel", SIZES)
def test_a_step_is_found_with_its_date(half_a_year, channel):
    name = f"{channel}_step"
    data, _ = with_change(half_a_year, name)
    loop = closed(data)
    first = loop.findings[0]
    assert first.added and name in first.candidates
    changes = [n for n in first.candidates if n in CHANGES]
    assert {course(n) for n in changes} == {"step"}
    effect = next(e for e in loop.fit.effects if e.name == first.effect)
    low, high = effect.settings["between"]
    assert low <= "2023-09-15" <= high
    assert number(high) - number(low) < 30


@pytest.mark.parametrize("channel, little", [("contact", -0.05), ("air_shelter", 1.0)])
def test_a_small_step_is_no_season(half_a_year, channel, little):
    """Worth 0.2 K, of which a season takes half: it is a step nevertheless."""
    name = f"{channel}_step"
    data, _ = with_change(half_a_year, name, **{name: little})
    loop = closed(data)
    first = loop.findings[0]
    assert first.added and name in first.candidates
    assert not {"season", f"{channel}_drift"} & {*first.candidates}
    (gain, _, _, share, *_), limits = first.checks, loop.criteria
    assert (gain.criterion, share.criterion) == ("min_gain", "tied")
    assert first.gain == gain.statistic >= limits.min_gain
    beside = first.gain * share.statistic**0.5  # what is left of it
    assert beside < limits.min_gain and share.statistic >= limits.tied


def test_a_stalled_anemometer_is_not_lost_in_the_shape_of_the_model():
    """
    From a day on its cups stand in winds below 1.8 m/s.

    A model that is misshapen in low wind explains as much, since before that day there
    was little such wind: beside it no date shows, and the step is in its class.
    """
    data = datasets.synthetic(400, 3600, seed=3, noise=0).tz_localize(None)
    data, _ = with_change(data)
    wind, day = data["wind_speed"], "2023-08-15"
    data["wind_speed"] = wind.where((wind >= 1.8) | (data.index < day), 0.0)
    loop = closed(data)
    first = loop.findings[0]
    assert first.added and first.verdict is Verdict.CLASS
    assert {"wind_stall_step", "wind_shape"} <= {*first.candidates}
    (effect,) = (e for e in loop.fit.effects if e.name == "wind_stall_step")
    low, high = effect.settings["between"]
    assert low <= day <= high and number(high) - number(low) < 14


def of_a_world(seed, *change):
    """The loop of a record with full physics, one of whose instruments changes."""
    _, data, (world, *drawn) = study_instruments.made(seed)
    assert drawn[:2] == [*change]
    data = data.drop(columns="p_dc", errors="ignore")
    return fem.close_loop(data, check_units=False, **world.place)


def test_whatever_channel_shows_a_date_all_are_asked():
    """
    A pyranometer reads a seventh more for two months.

    Beside all confounders only what shelters a thermometer has that date by itself.
    """
    loop = of_a_world(21037, "sensitivity", "episode")
    (found,) = (f for f in loop.findings if f.added and {*f.candidates} & {*CHANGES})
    assert "sensitivity_episode" in found.candidates
    (effect,) = (e for e in loop.fit.effects if e.name == found.effect)
    low, high = effect.settings["between"]
    assert low <= "2023-09-05" <= high


def test_snow_under_a_low_sun_is_no_obstacle():
    """
    At 56° north the sun of midwinter crosses a window of the sky that no other sees.

    What snow takes then is not there on the days of that window that have no snow.
    """
    loop = of_a_world(21036, "contact", "episode")
    named = {f.effect for f in loop.findings if f.verdict is Verdict.NAMED}
    assert "shading" not in named and "snow" in named


def test_a_step_that_the_sky_hides_is_dated_beside_what_is_found_with_it(monkeypatch):
    """
    From 22 July on a sensor reads a fifth more over-temperature, under a sky, in snow.

    Beside the steady model alone it has no date, and is one of twelve in a season.
    """
    loop = of_a_world(26005, "contact", "step")
    (found,) = (f for f in loop.findings if f.added and {*f.candidates} & {*CHANGES})
    assert {*found.candidates} == {"contact_step", "mounting_step"}
    assert found.coefficients["contact_step.change"] == pytest.approx(0.218, abs=0.03)
    (effect,) = (e for e in loop.fit.effects if e.name == found.effect)
    low, high = effect.settings["between"]
    assert low <= "2023-07-23" <= high and number(high) - number(low) < 14
    monkeypatch.setattr(Proposals, "dated_beside", lambda _, found, *__: found)
    undated = of_a_world(26005, "contact", "step")
    (first, *_) = (f for f in undated.findings if {*f.candidates} & {*CHANGES})
    assert first.effect == "season" and "contact_step" in first.candidates


def with_columns(columns, rest, dates):
    """Evidence of what a constant leaves."""
    columns = {"u0": np.ones(len(rest))} | columns
    return Evidence(columns, rest, dates, np.arange(len(rest)), ("u0",), ())


def test_what_was_a_step_beside_nothing_is_an_episode_beside_what_grows():
    """
    Seven years of a pyranometer that fades, one winter of a sensor that lies bare.

    By itself the end of that winter is a step; beside the drift both its dates show.
    """
    random, days = np.random.default_rng(0), np.arange(14_665, 17_165)
    dates = np.repeat(days, 6)
    light = random.uniform(0.0, 1.0, len(dates))
    contact = light * random.uniform(0.8, 1.2, len(dates))
    noise = np.repeat(random.normal(0.0, 1.0, len(days)), 6) * light
    noise += random.normal(0.0, 0.5, len(dates))
    bare = dated("contact_episode", start="2012-10-18", end="2013-04-12")
    fades = dated("sensitivity_drift", since="2010-02-25")
    size, per_year = (np.repeat(weights_of(one, days), 6) for one in (bare, fades))
    rest = 2.0 * per_year * light - 3.0 * size * contact + noise
    found = with_columns({"light": light, "contact": contact}, rest, dates)
    changing = [(CHANGES[f"contact_{c}"], "contact") for c in ("step", "episode")]
    ((alone, _),) = found.shown(changing, ())
    assert alone.name == "contact_step"
    larger = found.along([(fades, "light")])
    ((beside, _),) = larger.shown(changing, [fades.name])
    assert beside.settings["start"] == "2012-10-18"
    assert beside.settings["end"] == "2013-04-12"


@pytest.mark.parametrize(("until", "slow"), [("2023-10-20", []), ("2024-02-01", [1])])
def test_a_step_of_no_known_month_may_have_come_slowly(until, slow):
    """A drift that explains nearly as much stands in its class."""
    random, days = np.random.default_rng(0), np.arange(19_600, 20_000)
    dates = np.repeat(days, 6)
    one, noise = random.normal(size=(2, len(dates)))
    drift = dated("contact_drift", since="2023-08-31")
    step = dated("contact_step", at="2023-10-01", between=["2023-10-01", until])
    rest = 0.3 * (np.repeat(weights_of(drift, days), 6) * one + noise)
    found = with_columns({"one": one}, rest, dates)
    found = found.along([(step, "one"), (drift, "one")])
    names = [step.name, drift.name]
    weights = weighed(found, names, [])
    assert slow_ones(found, names[:1], weights) == [names[i] for i in slow]


@given(st.integers(0, 2**32 - 1))
def test_evidence_without_an_effect_is_what_it_was_before(seed):
    random, days = np.random.default_rng(seed), np.arange(19_600, 19_700)
    dates = np.repeat(days, 3)
    one, rest = random.normal(size=(2, len(dates)))
    found = with_columns({"one": one}, rest, dates)
    expected = found.sums(())
    step = dated("contact_step")
    drift = dated("contact_drift")
    larger = found.along([(step, "one"), (drift, "one")])
    less = larger.without([step.name, "snow"])
    assert less.weigh(drift.name) == larger.weigh(drift.name)
    again = less.without([drift.name])
    assert {*again.columns} == {*found.columns} and not again.effects
    np.testing.assert_array_equal(again.sums(()).sums, expected.sums)


def test_an_episode_is_no_step(half_a_year):
    data, _ = with_change(half_a_year, "module_offset_episode")
    first = closed(data).findings[0]
    assert first.added and "module_offset_episode" in first.candidates
    assert "module_offset_step" not in first.candidates


def test_a_drift_over_years_is_no_step():
    data = datasets.synthetic(800, 3600, seed=3, noise=0).tz_localize(None)
    data, _ = with_change(data, "sensitivity_drift", sensitivity_drift=0.08)
    first = closed(data).findings[0]
    assert first.added and "sensitivity_drift" in first.candidates
    assert "sensitivity_step" not in first.candidates


def test_where_nothing_changes_nothing_is_found():
    """Ten records of noise with a memory of hours: no date in any."""
    for seed in range(10):
        data = datasets.synthetic(200, 3600, seed=seed, noise=0).tz_localize(None)
        data, _ = with_change(data, seed=seed)
        loop = closed(data)
        assert not [f for f in loop.findings if f.effect in CHANGES], seed


def test_the_step_at_bolzano_is_of_the_spring_of_2012(bolzano):
    """By temperatures alone: 19 % more over-temperature, told as a class."""
    loop = fem.close_loop(bolzano[list(COLUMNS)])
    first = loop.findings[0]
    assert {"contact_step", "mounting_step"} <= {*first.candidates}
    effect = next(e for e in loop.fit.effects if e.name == first.effect)
    assert abs(number(effect.settings["at"]) - number("2012-04-01")) < 14
    (change,) = first.coefficients.values()
    assert change == pytest.approx(0.175, abs=0.01)
    assert loop.table["rmse_test"].iloc[-1] < loop.table["rmse_test"]["fem"] - 0.1


@pytest.mark.parametrize(
    ("one", "other", "alike"),
    [
        ({"at": "2023-09-15"}, {"at": "2023-09-15"}, True),
        ({"at": "2023-09-15"}, {"at": "2023-09-16"}, False),
        ({"at": "2023-09-15", "between": ["2023-09-01", "2023-09-20"]}, {}, True),
        ({"at": "2023-09-15"}, {"start": "2023-09-01", "end": "2023-09-20"}, False),
        ({"at": "2023-09-15"}, {"since": "2023-09-15"}, False),
    ],
)
def test_two_changes_are_of_one_date_where_their_intervals_meet(one, other, alike):
    def named(dates):
        return "episode" if "end" in dates else "drift" if "since" in dates else "step"

    other = other or {"at": "2023-09-10"}
    effects = [find({"name": f"contact_{named(d)}", **d}) for d in (one, other)]
    assert same_date(*effects) is same_date(*effects[::-1]) is alike


def test_a_change_that_another_has_taken_the_place_of_is_taken_out():
    data = datasets.synthetic(150, 1800, seed=4, noise=0.3).tz_localize(None)
    how = dict(holdout=None, effects=None, check_units=False, fixed=None)
    place = (None, None, None)
    search, loop = searched(data, "faiman", place, None, criteria=fem.Criteria(), **how)
    step, name = search.steps[loop.base], "module_offset_drift"
    model = replace(step.model, effects=(dated(name),))
    fitted = search.fits.fitted(model, step, whole=False)
    value = {f"{name}.per_year": 1.0}
    why = because(Reason.NO_DATE)
    search.findings = [fem.Finding(name, (name,), "class", 0.2, value, value, why)]
    finding, check, why = search.doubtful(fitted, search.evidence(fitted))
    assert finding.effect == name
    assert check.criterion == "min_gain" and check.statistic < 0.1
    assert "beside all that was found it takes" in str(why)
    left = search.within_bounds(replace(fitted, at_bound=(f"{name}.per_year",)))
    assert not left.model.effects
    assert not search.findings
    assert "at the bound" in search.vetoed[name].why
