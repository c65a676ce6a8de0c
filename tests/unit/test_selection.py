"""How the loop decides: weekly sums, single effects, and causes outside."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st
from pvlib.location import Location
from scipy.signal import lfilter
from scipy.stats import binomtest, f as fdistribution

from pvlib_fem import Criteria, close_loop, simulator
from pvlib_fem._findings import OUTSIDE, SNOW
from pvlib_fem._loop.references.comparisons import size_error
from pvlib_fem._loop.regression.design import Changed, Design
from pvlib_fem._loop.regression.hourly_tangents import filled, independent_columns
from pvlib_fem._loop.results.conclude import NINETY, range_around, range_of
from pvlib_fem._loop.search import Search
from pvlib_fem._loop.selection.change_dates import Scan
from pvlib_fem._loop.selection.choice import Choice, ShownChange, SizeByReference
from pvlib_fem._loop.selection.dictionary import Candidate, all_candidates, log_odds
from pvlib_fem._loop.selection.noise import (
    WithinCells,
    law_misfits,
    likelihoods,
    prior_of,
    random_effects,
    remaining_shares,
    tables_met,
    with_outside,
    with_special_cases,
)
from pvlib_fem._loop.selection.posterior import posterior
from pvlib_fem._loop.selection.refinement import refined, remaining
from pvlib_fem._loop.selection.rivals import OVERLAP, weighed
from pvlib_fem._loop.selection.single_effects import (
    MOST_SHOWN,
    Selection,
)
from pvlib_fem._statistics.tables import Table
from pvlib_fem._statistics.weekly_sums import (
    LeastSquares,
    common_share,
    effective_length,
    held_out,
    products,
)
from pvlib_fem.effects import CHANGES, EFFECTS, find
from pvlib_fem.effects._effect import Parameter
from pvlib_fem.effects._time_profiles import YEAR, day_number, weights_of

START = 19_358  # 2023-01-01
CRITERIA = Criteria()


def design(residual, columns, days, hours, changing=(), own=(), **places):
    """A design of some columns, of which those of ``own`` are an effect's."""
    rows = len(residual)
    made = Design.of_columns(
        residual, columns, np.ones(rows), START + days, changing or CHANGES.values()
    )
    order = {name: i for i, name in enumerate(made.names)}
    mine = {
        name: tuple(order[key] for key in EFFECTS[name].rows() if key in order)
        for name in own
    }
    taken = {place for places in mine.values() for place in places}
    usual = {name: np.zeros(rows) for name in ("poa_global", "wind_speed")}
    usual["temp_air"] = np.full(rows, 15.0)  # no frost, and so no snow
    clock = {"hour": hours, "month": 1 + days // 31 % 12, "weekend": days % 7 >= 5}
    return replace(
        made,
        base=tuple(place for place in made.base if place not in taken),
        own=mine,
        effects={name: EFFECTS[name] for name in own},
        changing=tuple(changing),
        places=usual | clock | places,
    )


def clock(days):
    """Day and hour of each cell of some days."""
    return np.repeat(np.arange(days), 24), np.tile(np.arange(24), days)


def noise(random, size, memory=0.5):
    """Noise that remembers an hour."""
    found = np.empty(size)
    found[0] = random.normal()
    for i in range(1, size):
        found[i] = memory * found[i - 1] + random.normal() * np.sqrt(1 - memory**2)
    return found


@given(st.integers(0, 2**32 - 1))
def test_products_with_a_change_are_those_of_its_column(seed):
    random, (days, hours) = np.random.default_rng(seed), clock(70)
    one, other, rest = random.normal(size=(3, len(days)))
    made = design(rest, {"one": one, "other": other}, days, hours)
    step = CHANGES["module_sensor_contact_step"].make(at="2023-02-10")
    drift = CHANGES["module_sensor_contact_drift"].make(since="2023-01-05")
    changes = [Changed.from_effect(3, effect) for effect in (step, drift)]
    found = made.by_week([1, *changes])
    columns = [made.cells[:, 0], made.cells[:, 1]]
    columns += [made.cells[:, 3] * weights_of(e, START + days) for e in (step, drift)]
    table = np.column_stack(columns)
    np.testing.assert_allclose(found.sum(axis=0), table.T @ table, rtol=1e-9)
    for change, column in zip(changes, columns[2:]):
        np.testing.assert_allclose(made.values(change), column)


@given(st.integers(0, 2**32 - 1), st.integers(1, 2))
def test_shifts_are_those_of_fits_without_each_week(seed, size):
    random = np.random.default_rng(seed)
    table = random.normal(size=(12, 9, 4))
    found = LeastSquares(np.einsum("wri,wrj->wij", table, table), size)
    rows = table.reshape(-1, 4)
    whole = np.linalg.lstsq(rows[:, 1:], rows[:, 0], rcond=None)[0][-size:]
    np.testing.assert_allclose(found.estimate, whole, rtol=1e-5, atol=1e-8)
    for week in range(12):
        rows = np.delete(table, week, axis=0).reshape(-1, 4)
        other = np.linalg.lstsq(rows[:, 1:], rows[:, 0], rcond=None)[0][-size:]
        np.testing.assert_allclose(
            found.shifts[week], other - whole, rtol=1e-4, atol=1e-6
        )


@given(st.integers(0, 2**32 - 1))
def test_the_held_out_square_is_that_of_fits_without_each_fold(seed):
    random = np.random.default_rng(seed)
    table = random.normal(size=(10, 8, 3))
    folds = (np.arange(10) % 5 == np.arange(5)[:, None]).astype(float)
    expected = 0.0
    for fold in range(5):
        out = np.arange(10) % 5 == fold
        rows = table[~out].reshape(-1, 3)
        size = np.linalg.lstsq(rows[:, 1:], rows[:, 0], rcond=None)[0]
        left = table[out].reshape(-1, 3)
        expected += np.square(left[:, 0] - left[:, 1:] @ size).sum()
    weekly = np.einsum("wri,wrj->wij", table, table)
    assert held_out(weekly, folds) == pytest.approx(expected, rel=1e-5)


def scanned(seed):
    """Sums of a column that changes, and the fall by least squares with another."""
    random, (days, hours) = np.random.default_rng(seed), clock(60)
    one, rest = random.normal(size=(2, len(days)))
    made = design(rest, {"one": one}, days, hours)
    scan = replace(Scan.from_design(made, [1], 7), trust=np.ones(60))

    def fall_by(column):
        both = np.column_stack([one, column])
        before = rest - one * (one @ rest) / (one @ one)
        after = rest - both @ np.linalg.lstsq(both, rest, rcond=None)[0]
        return before @ before - after @ after

    return days, scan.sums(2), fall_by


@given(st.integers(0, 2**32 - 1))
def test_the_best_step_is_that_of_all_fits(seed):
    """Against least squares of every date, where all days are usual ones."""
    days, sums, fall_by = scanned(seed)
    starts = np.arange(7, 54)
    falls = sums.constant(starts, np.full(len(starts), 60))
    for start, fall in zip(starts[::9], falls[::9]):
        step = np.ones(len(days)) * (days >= start)
        assert fall == pytest.approx(fall_by(step), rel=1e-4)


@pytest.mark.parametrize(
    ("time_profile", "dates"),
    [("step", ("2023-05-01",)), ("episode", ("2023-04-01", "2023-06-20"))],
)
def test_the_date_of_a_change_is_within_its_interval(time_profile, dates):
    """In thirty records; a step of one standard deviation of the noise of an hour."""
    right = 0
    for seed in range(30):
        random, (days, hours) = np.random.default_rng(seed), clock(240)
        first, *last = (day_number(day) - START for day in dates)
        there = (days >= first) & (days < (last[0] if last else np.inf))
        rest = 1.0 * there + noise(random, len(days), 0.9)
        changing = [CHANGES[f"module_offset_{time_profile}"]]
        made = design(rest, {"one": random.normal(size=len(days))}, days, hours)
        made = replace(made, changing=tuple(changing))
        (found,) = all_candidates(made, [1], 21, 0.025)
        score = Selection(made, CRITERIA).score(found, [1])
        errors = abs(score.estimate[0]) / score.stderr[0]
        scan = Scan.from_design(made, [1], 21)
        low, high = scan.first_days(found.change, errors).settings["between"]
        right += low <= dates[0] <= high
        assert day_number(high) - day_number(low) < 80
    assert right >= 27


def test_the_more_a_change_could_be_the_less_it_is_believed():
    """Odds fall with the bounds of a size and the number of dates, and rise with it."""
    effect = CHANGES["module_sensor_contact_step"].make(at="2023-02-10")
    one = Candidate(effect, (), np.log(0.025))
    (row,) = effect.rows().values()
    wide = replace(row, lower=10.0 * row.lower, upper=10.0 * row.upper)

    def odds(size, rows=(row,), **more):
        cov = np.array([[0.01**2]])
        one_more = replace(one, **more)
        return one_more.existence([*rows], np.array([size]), cov, 50.0)

    sizes = [odds(size) for size in (0.0, 0.02, 0.04, 0.08, 0.2)]
    assert sizes == sorted(sizes) and sizes[0] < 0.025 < 0.99 < sizes[-1]
    assert odds(0.04, rows=(wide,)) < odds(0.04)
    assert odds(0.04, log_dates=np.log(300.0)) < odds(0.04)


def test_noise_is_rarely_taken_for_an_effect():
    """A hundred years of noise with a memory of ten hours, and all changes."""
    found = []
    for seed in range(100):
        random, (days, hours) = np.random.default_rng(seed), clock(365)
        columns = {"one": np.cos(2 * np.pi * hours / 24)}
        columns["rain.film"] = np.maximum(random.normal(size=len(days)) - 1.5, 0.0)
        rest = noise(random, len(days), 0.9)
        made = design(rest, columns, days, hours, own=["rain"])
        made = replace(made, changing=(CHANGES["module_offset_step"],))
        selection = Selection(
            made, replace(CRITERIA, min_rmse_reduction=1e-3, min_error_share=1e-6)
        )
        found += [one.top.name for one in selection.run()]
    assert len(found) <= 2


def test_what_nothing_tells_apart_has_equal_shares():
    """Two columns that are one; and one that explains less has less."""
    random, (days, hours) = np.random.default_rng(0), clock(200)
    own = random.normal(size=len(days))
    rest = own + noise(random, len(days))
    columns = {"one": np.ones(len(days)), "rain.film": own}
    twin = {"air_elsewhere.share": own}
    for other, low, high in ((own, 0.49, 0.51), (own + 0.5 * rest[::-1], 0.0, 0.3)):
        names = columns | dict.fromkeys(twin, other)
        made = design(rest, names, days, hours, own=["rain", "air_elsewhere"])
        selection = Selection(made, CRITERIA)
        members = {
            one.name: replace(one, log_prior=0.0)
            for one in selection.candidates([*made.base])
            if one.name in made.own
        }
        base, rain = [*made.base], members["rain"]
        shares = posterior(made, CRITERIA, members, base, rain, 10.0)
        assert sum(shares.values()) == pytest.approx(1.0)
        assert low <= shares["air_elsewhere"] <= high


def test_of_laws_that_explain_the_same_one_with_fewer_coefficients_is_probable():
    """Each costs half the logarithm of the observations that a law is worth."""
    random, (days, hours) = np.random.default_rng(0), clock(400)
    own, other = random.normal(size=(2, len(days)))
    rest = own + 0.1 * noise(random, len(days))
    columns = {"one": np.ones(len(days)), "rain.film": own}
    columns |= {"wind_direction.north": own, "wind_direction.east": other}
    made = design(rest, columns, days, hours, own=["rain", "wind_direction"])
    every = Selection(made, CRITERIA).candidates([*made.base])
    members = {one.name: replace(one, log_prior=0.0) for one in every}
    rain = members["rain"]
    shares = posterior(made, CRITERIA, members, [*made.base], rain, 10.0)
    odds = shares["rain"] / shares["wind_direction"]
    assert odds == pytest.approx(np.sqrt(1.0 + 1.0 / CRITERIA.law_error**2), rel=0.02)


OFFSETS = [CHANGES[f"module_offset_{name}"] for name in ("step", "drift", "episode")]


def offsets(rest, days, hours):
    """The selection on a residual that offsets of the module's sensor may explain."""
    columns = {"one": np.ones(len(days)), "wave": np.cos(hours / 4.0)}
    made = design(rest, columns, days, hours, changing=OFFSETS)
    return Selection(replace(made, sensor_faults={"module_offset": 3}), CRITERIA)


@given(st.integers(0, 2**32 - 1))
def test_the_best_trend_is_that_of_all_fits(seed):
    """Against least squares of every pair of dates, where all days are usual ones."""
    days, sums, fall_by = scanned(seed)
    first, last = np.array([0, 0, 11, 20]), np.array([60, 31, 60, 45])
    for a, b, fall in zip(first, last, sums.linear(first, last)):
        trend = np.where((days >= a) & (days < b), days - a + 0.5, 0.0)
        assert fall == pytest.approx(fall_by(trend), rel=1e-4)


def spread_of(rest, days, hours, dates, errors):
    """Sizes over the dates of a trend that has some dates, by its own size."""
    made = offsets(rest, days, hours).design
    change = Changed.from_effect(3, CHANGES["module_offset_drift"].dates(**dates))
    scan = Scan.from_design(made, [1, 2], 21)
    low, high = scan.sizes_over_dates(change, errors)
    fit = LeastSquares(made.by_week([1, 2, change]), 1)
    size = float(fit.estimate[0] / made.scales([change])[0])
    return low * size, high * size


def test_half_a_trend_may_be_a_whole_one():
    """1.6 times as fast for half as long, unless the dates are sure."""
    random, (days, hours) = np.random.default_rng(4), clock(365)
    rest = 2.0 * days / 365.25 + noise(random, len(days))
    half = {"start": "2023-07-03"}
    low, high = spread_of(rest, days, hours, half, 4.0)
    assert low == pytest.approx(2.1, abs=0.1) and high == pytest.approx(3.4, abs=0.1)
    random = np.random.default_rng(5)
    quarter = 8.0 * np.maximum(days - 274, 0) / 365.25 + noise(random, len(days))
    start = {"start": "2023-10-03"}
    low, high = spread_of(quarter, days, hours, start, 50.0)
    assert 3.5 < low < 8.0 < high < 13.0
    low, high = spread_of(quarter, days, hours, start, 4.0)
    assert low < 2.0 and high > 8.0


def test_other_changes_have_their_own_size_over_dates():
    made = offsets(np.zeros(365 * 24), *clock(365)).design
    for name, dates in {
        "step": {"at": "2023-05-01"},
        "drift": {"since": "2023-01-01", "resets": ("2023-05-01",)},
    }.items():
        change = Changed.from_effect(3, CHANGES[f"module_offset_{name}"].dates(**dates))
        scan = Scan.from_design(made, [1, 2], 21)
        assert scan.sizes_over_dates(change, 5.0) == (1.0, 1.0)


def test_a_range_has_independent_errors_and_other_values():
    row = Parameter(0.0, -3.0, 3.0, "-")
    low, high = range_around(1.0, [0.3, -0.4, 1.2], row, [0.0, 1.5])
    assert low == pytest.approx(1.0 - np.hypot(1.3, 1.0))
    assert high == pytest.approx(1.0 + np.hypot(1.3, 0.5))
    assert range_around(-2.0, [1.5], row) == (-3.0, -0.5)


def test_a_range_is_wider_where_two_estimates_differ():
    """Of a model that is right, least squares with and without weights agree."""
    random, (days, hours) = np.random.default_rng(3), clock(365)
    rest = 2.0 * (days >= 180) + noise(random, len(days))
    selection = offsets(rest, days, hours)
    best = weighed(selection, selection.best([]), [])
    key, name = "module_offset_step.change", best.top.name
    assert name == "module_offset_step"
    score = best.scores[name]
    value, error = score.coefficients[key], score.errors[key]
    low, high = range_of(key, value, error, best, name, CRITERIA)
    assert low < 2.0 < high and high - low < 1.2
    apart = replace(best, scores={name: replace(score, seen=score.seen - 1.0)})
    low, high = range_of(key, value, error, apart, name, CRITERIA)
    assert low < value - 1.0 < value + 1.0 < high


def test_rivals_are_those_of_what_is_explained_given_the_same_others():
    """A choice that was found without the others explained more than it does now."""
    random, (days, hours) = np.random.default_rng(3), clock(365)
    rest = 2.0 * (days >= 180) + noise(random, len(days))
    selection = offsets(rest, days, hours)
    now = selection.best([])
    before = replace(now, score=replace(now.score, fall=10.0 * now.fall))
    names = [{*weighed(selection, one, []).members} for one in (now, before)]
    assert names[0] == names[1] and len(names[0]) > 1


def offset_by_reference(**shown):
    """The finding of an offset, with its size by a reference."""
    random, (days, hours) = np.random.default_rng(3), clock(365)
    rest = 2.0 * (days >= 180) + noise(random, len(days))
    selection = offsets(rest, days, hours)
    best = weighed(selection, selection.best([]), [])
    if shown:
        shown = {"other": 0.15, "shows_it": False} | shown
        by_it = SizeByReference(("temp_module_2",), **shown)
        best = replace(best, by_reference={best.top.name: by_it})
    return best, best.top.name, "module_offset_step.change"


def test_a_range_reaches_the_mean_with_a_reference_that_cannot_tell():
    """It shows half as much again, or half; an unsure one shows nothing."""

    def range_by(**shown):
        best, name, key = offset_by_reference(**shown)
        (value,), (error,) = (
            one(name).values() for one in (best.coefficients, best.errors)
        )
        return value, range_of(key, value, error, best, name, CRITERIA)

    value, alone = range_by()
    for ratio in (0.5, 1.5):
        same, sure = range_by(ratio=ratio, error=0.001)
        assert same == value
        assert sure[0] < ratio * value < sure[1]
        far, near = (1, 0) if ratio > 1.0 else (0, 1)
        assert abs(sure[far] - value) > abs(alone[far] - value)
        assert sure[near] == alone[near]
        assert range_by(ratio=ratio, error=100.0)[1] == pytest.approx(alone, rel=1e-3)


@pytest.mark.parametrize("ratio", [0.7, 1.0, 1.4])
def test_a_size_is_the_mean_of_temperature_and_reference(ratio):
    """The surer one has more weight, and the mean is surer than each of them."""
    best, name, key = offset_by_reference()
    alone, other = best.coefficients(name)[key], best.sized(name).error
    for error, times in {1e-4: ratio, other: 0.5 * (1.0 + ratio), 100.0: 1.0}.items():
        shown = dict(ratio=ratio, error=error, other=other)
        best, *_ = offset_by_reference(**shown, shows_it=True)
        size = best.coefficients(name)[key]
        assert size == pytest.approx(times * alone, rel=1e-3)
        assert best.joint_size(name, {key: alone}) == {key: size}
        stated = best.errors(name)[key] / alone
        assert stated <= 1.001 * min(error, other)
        low, high = range_of(key, size, stated * alone, best, name, CRITERIA)
        assert low < size < high


def test_a_range_has_the_errors_of_what_gives_the_size():
    """15 % by the temperature, 5 % by a reference, with 1.64 standard errors."""
    best, name, key = offset_by_reference()
    value, other = best.coefficients(name)[key], best.sized(name).error
    law = size_error(best.top.effect)
    for error, part in ((1e-4, 0.05), (100.0, law)):
        best, *_ = offset_by_reference(
            ratio=1.0, error=error, other=other, shows_it=True
        )
        low, high = range_of(key, value, 0.0, best, name, CRITERIA)
        assert high - value == pytest.approx(NINETY * part * value, rel=0.05)
        assert value - low == pytest.approx(high - value)


def test_a_size_by_temperature_and_reference_is_within_its_bounds():
    """A shield cannot hold off more than all that the sun heats the sensor."""
    best, name, key = offset_by_reference(ratio=1e3, error=1e-6, shows_it=True)
    assert best.coefficients(name)[key] == best.top.effect.rows()[key].upper


def test_a_range_holds_the_size_of_a_change_beside_a_season_that_is_not_found():
    """A season of half a kelvin is not material, and alters the size of a step."""
    days, hours = clock(365)
    angle = 2.0 * np.pi * days / 365.25
    rows = dict(zip(EFFECTS["season"].rows(), (np.cos(angle), np.sin(angle))))
    changing = [CHANGES["module_offset_step"]]
    key, held = "module_offset_step.change", []
    for seed in range(30):
        random = np.random.default_rng(seed)
        season = random.normal(0.0, 0.3, 2) @ [*rows.values()]
        rest = 1.0 * (days >= random.integers(90, 270)) + noise(random, len(days))
        columns = {"one": np.ones(len(days))} | rows
        made = design(rest + season, columns, days, hours, changing, own=["season"])
        selection, base = Selection(made, CRITERIA), [*made.base]
        found = selection.candidates(base)
        (top,) = (c for c in found if c.effect.sensor_fault)
        one = weighed(selection, Choice(top, selection.score(top, base)), [])
        score = one.scores[top.name]
        value, error = score.coefficients[key], score.errors[key]
        for choice in (one, replace(one, confounded={})):
            low, high = range_of(key, value, error, choice, top.name, CRITERIA)
            held.append(low <= 1.0 <= high)
    beside, alone = np.reshape(held, (-1, 2)).mean(axis=0)
    assert beside >= 0.9 > 0.7 > alone


@pytest.mark.parametrize(
    ("per_year", "change", "at", "again"),
    [
        (1.0, -2.0, 500, True),
        (1.0, -1.5, 350, True),
        (1.0, -2.6, 500, True),
        (1.0, -4.0, 500, False),
    ],
)
def test_a_trend_and_a_step_that_hide_each_other_are_found(per_year, change, at, again):
    """
    A sensor that drifts until it is replaced or cleaned.

    A step by no more than a trend may have reached is a trend that begins again.
    """
    random, (days, hours) = np.random.default_rng(9), clock(700)
    rest = per_year * days / 365.25 + change * (days >= at) + noise(random, len(days))
    selection = offsets(rest, days, hours)
    found = {one.top.name: one for one in refined(selection, selection.run())}
    trend = found.pop("module_offset_drift")
    assert trend.score.estimate[0] == pytest.approx(per_year, abs=0.15)
    settings = trend.top.effect.settings
    assert len(found) == (0 if again else 1)
    if not again:
        (step,) = found.values()
        assert step.top.name == "module_offset_step"
        assert step.score.estimate[0] == pytest.approx(change, abs=0.15)
        date = step.top.effect.settings["at"]
    else:
        begin, date = settings["resets"]
        age = day_number(date) - day_number(begin)
        assert per_year * age / 365.25 == pytest.approx(-change, abs=0.2)
    assert abs(day_number(date) - START - at) <= 7


def test_two_steps_that_look_like_a_trend_are_found():
    """The trend is sure alone; without its time profile, two changes explain more."""
    random, (days, hours) = np.random.default_rng(9), clock(700)
    level = (days >= 150) + (days >= 400) * 1.0
    selection = offsets(level + noise(random, len(days)), days, hours)
    before = selection.run()
    assert [one.top.name for one in before] == ["module_offset_drift"]
    after = refined(selection, before)
    assert len(after) == 2
    assert remaining(selection, after) < remaining(selection, before) - selection.least
    shown = [
        one.score.estimate[0] * weights_of(one.top.effect, START + np.arange(700))
        for one in after
    ]
    days_of, known = np.arange(700), np.array([150, 400])
    far = np.abs(np.subtract.outer(days_of, known)).min(axis=1) > 7
    true = (days_of >= 150) + (days_of >= 400) * 1.0
    assert np.abs(sum(shown) - true)[far].max() < 0.15


@given(st.integers(0, 2**32 - 1))
def test_a_trend_with_resets_is_that_of_all_fits(seed):
    """Against least squares of the whole trend, also of one that is older."""
    days, sums, fall_by = scanned(seed)
    for resets, age in (((), 0.0), ((20, 41), 0.0), ((15,), 12.0)):
        zeros = np.array([-age, *resets])
        last = zeros[np.searchsorted(zeros, days, side="right") - 1]
        fall = sums.square_falls(sums.teeth(resets, age / YEAR))
        assert fall == pytest.approx([fall_by(days - last + 0.5)], rel=1e-4)


def test_resets_are_found_and_a_trend_without_any_has_none():
    random, (days, hours) = np.random.default_rng(3), clock(1100)
    for at in ((), (380, 790), (200, 420, 880)):
        zeros = np.array([0, *at])
        last = zeros[np.searchsorted(zeros, days, side="right") - 1]
        rest = 1.5 * (days - last) / YEAR + noise(random, len(days))
        columns = {"one": np.ones(len(days)), "wave": np.cos(hours / 4.0)}
        made = design(rest, columns, days, hours, changing=OFFSETS)
        sums = Scan.from_design(made, [1, 2], 7).sums(3, -1.0, 1.0)
        whole = sums.best(sums.linear, np.array([0]), np.array([1100]))
        span = sums.simplest([whole, sums.with_resets(7)])
        assert len(span.resets) == len(at)
        assert all(abs(a - b) <= 10 for a, b in zip(span.resets, at))


def test_noise_that_remembers_weeks_is_no_pair_of_changes():
    random, (days, hours) = np.random.default_rng(10), clock(500)
    for memory in np.linspace(0.3, 0.9, 12):
        weekly = np.random.default_rng(int(1e3 * memory)).normal(size=80)
        for i in range(1, 80):
            weekly[i] *= np.sqrt(1.0 - memory**2)
            weekly[i] += memory * weekly[i - 1]
        rest = 0.5 * weekly[days // 7] + noise(random, len(days))
        selection = offsets(rest, days, hours)
        before = selection.run()
        assert len(refined(selection, before)) <= len(before)


def chosen(rest, own, days, hours, **places):
    """The choice of one effect, with the probability of a cause outside."""
    columns = {"one": np.ones(len(days)), "rain.film": own}
    made = design(rest, columns, days, hours, own=["rain"], **places)
    selection = Selection(made, CRITERIA)
    (one,) = (c for c in selection.candidates([*made.base]) if c.name == "rain")
    score = selection.score(one, [*made.base])
    choice = weighed(selection, Choice(one, score), [])
    return made, one, with_outside(made, choice, [*made.base], CRITERIA)


def test_a_true_effect_keeps_its_size_within_every_table():
    random, (days, hours) = np.random.default_rng(2), clock(300)
    own = np.maximum(random.normal(size=len(days)) + np.cos(hours / 4.0), 0.0)
    made, one, choice = chosen(2.0 * own + noise(random, len(days)), own, days, hours)
    sizes = [*remaining_shares(one, WithinCells(made, [*made.base]))]
    assert sizes
    for share, error in sizes:
        assert abs(share - 1.0) < 4.0 * error + 0.02
    assert choice.probabilities["rain"] > 0.95
    assert sum(choice.probabilities.values()) == pytest.approx(1.0)


def test_forced_convection_by_another_law_is_no_cause_outside():
    """
    Of a windy and clear site, where the loss is not proportional to wind speed.

    All of it is a function of wind and irradiance. Within the cells of these, nothing
    else differs that would tell it from a cause outside.
    """
    forms = replace(simulator.RHINE.forms, natural="mcadams", forced="sparrow")
    site = replace(simulator.RHINE, wind_mean=3.5, clear_share=0.7, forms=forms)
    data = simulator.record(site, simulator.PHYSICS, days=365, step=900.0, seed=4)
    loop = close_loop(
        data[["poa_global", "temp_air", "wind_speed", "temp_module"]],
        location=Location(site.latitude, site.longitude),
        surface_tilt=site.surface_tilt,
        surface_azimuth=site.surface_azimuth,
    )
    (shape,) = (f for f in loop.finding_objects if f.effect == "wind_shape")
    prior = CRITERIA.outside_probability
    assert shape.added and shape.probabilities[OUTSIDE] < 1.2 * prior
    table = loop.table["rmse_test"]
    assert table.iloc[-1] < table[loop.base] - 0.05


@pytest.mark.parametrize(
    "name, of_usual",
    [("wind_shape", True), ("natural_convection", True), ("rear_irradiance", False)],
)
def test_functions_of_the_usual_inputs_meet_no_table_of_these(name, of_usual):
    days, hours = clock(120)
    random = np.random.default_rng(1)
    usual = {
        key: random.uniform(1.0, 9.0, len(days))
        for key in ("poa_global", "temp_air", "wind_speed")
    }
    made = design(random.normal(size=len(days)), {}, days, hours, **usual)
    tables = [{a.name for a in kind} for kind in tables_met(made, EFFECTS[name])]
    assert ({"poa_global", "wind_speed"} not in tables) == of_usual
    assert ({"temp_air", "wind_speed"} not in tables) == of_usual
    assert {"hour", "month"} in tables and set() in tables


def test_what_stands_for_an_unknown_schedule_is_outside():
    """A pump of the mornings from May to August, and rain that falls then the most."""
    random, (days, hours) = np.random.default_rng(3), clock(300)
    pump = ((hours >= 6) & (hours < 10) & (days > 120) & (days < 240)).astype(float)
    own = pump + 0.3 * np.abs(random.normal(size=len(days)))
    rest = 3.0 * pump + noise(random, len(days))
    made, one, choice = chosen(rest, own, days, hours)
    shares = remaining_shares(one, WithinCells(made, [*made.base]))
    share, _ = shares[0]  # by hour and month
    assert share < 0.3
    assert choice.probabilities[OUTSIDE] > 0.5


def doubted(made, name):
    """Score and misfit of a candidate, and the probability of a cause outside."""
    selection, base = Selection(made, CRITERIA), [*made.base]
    (one,) = (c for c in selection.candidates(base) if c.name == name)
    score = selection.score(one, base)
    choice = weighed(selection, Choice(one, score), [])
    outside = with_outside(made, choice, base, CRITERIA).probabilities[OUTSIDE]
    return score, max(law_misfits(made, one, base, score.fall)), outside


@pytest.mark.parametrize("dust", [True, False])
def test_a_law_has_no_residual_along_what_it_derives(dust):
    """Dust gathers for as long as no rain falls; ground that is wet dries in a day."""
    random, (days, hours) = np.random.default_rng(6), clock(300)
    rains = random.random(300) < 0.15
    last = np.maximum.accumulate(np.where(rains, np.arange(300), 0))
    dry = days - last[days] + hours / 24.0
    clouds = random.uniform(0.05, 1.0, len(days))
    sun = clouds * np.maximum(np.sin((hours - 6) * np.pi / 12), 0.0)
    law = dry if dust else -12.0 * np.exp(-dry)
    own = {"soiling.per_day": 100.0 * sun * dry}  # K per share of light a day
    columns = {"one": np.ones(len(days)), "even": sun} | own
    rest = 0.5 * sun * law + noise(random, len(days))
    made = design(rest, columns, days, hours, own=["soiling"])
    made = replace(made, derived={"days_since_rain": dry})
    score, misfit, outside = doubted(made, "soiling")
    assert score.probability > 0.95
    if dust:
        assert misfit < 0.2 and outside < 0.1
    else:
        assert misfit > 0.7 and outside > 0.5


@pytest.mark.parametrize("turned", [True, False])
def test_geometry_has_no_residual_along_the_position_of_the_sun(turned):
    """A sensor that stands further east; a charger that heats until nine o'clock."""
    random, (days, hours) = np.random.default_rng(11), clock(300)
    west = (hours - 12) * np.pi / 12  # hour angle
    high = np.maximum(np.cos(west), 0.0)
    beam = np.repeat(random.uniform(0.0, 1.0, 300), 24) * high
    own = {
        "poa_misalignment.tilt": -0.01 * beam * np.cos(west),
        "poa_misalignment.azimuth": 0.01 * beam * np.sin(west),
    }
    charger = np.where((hours >= 6) & (hours < 9), 1.0, 0.0)
    rest = 4.0 * (100.0 * own["poa_misalignment.azimuth"] if turned else charger * beam)
    rest += noise(random, len(days))
    columns = {"one": np.ones(len(days)), "beam": beam} | own
    sun = {"solar_azimuth": 180.0 + np.degrees(west), "solar_zenith": 90.0 * (1 - high)}
    made = design(rest, columns, days, hours, own=["poa_misalignment"], **sun)
    _, misfit, outside = doubted(made, "poa_misalignment")
    if turned:
        assert misfit < 0.2 and outside < 0.1
    else:
        assert misfit > 0.7 and outside > 0.5


@given(st.floats(0.0, 3.0), st.floats(0.5, 1.2))
def test_a_misfit_is_evidence_against_the_law_that_has_it(misfit, share):
    """Alone the odds are those of the misfit; of a rival it says nothing."""
    law, sizes = 0.22, [(share, 0.05)]
    tested, unknown = likelihoods(sizes, [misfit], law)
    rival = likelihoods(sizes, [], law)
    assert tested <= rival[0] * (1.0 + 1e-9)
    assert unknown <= max(rival) * (1.0 + 1e-9)
    more, less = (likelihoods(sizes, [one], law) for one in (misfit + 0.1, misfit))
    assert more[1] / more[0] > less[1] / less[0]


@pytest.mark.parametrize("hours_of_day", [(0, 24), (20, 24)])
def test_a_sensor_that_has_changed_does_so_at_every_hour(hours_of_day):
    """An offset of 50 days; heat of the evenings of these days is no offset."""
    random, (days, hours) = np.random.default_rng(5), clock(300)
    first, last = hours_of_day
    there = (days >= 100) & (days < 150) & (hours >= first) & (hours < last)
    size = 24.0 / (last - first)  # as much in the mean of a day
    rest = size * there + noise(random, len(days))
    changing = [CHANGES["module_offset_episode"]]
    columns = {"one": random.normal(size=len(days))}
    made = replace(design(rest, columns, days, hours), changing=tuple(changing))
    selection = Selection(made, CRITERIA)
    (one,) = selection.candidates([1])
    score = selection.score(one, [1])
    assert score.probability > 0.95
    (misfit,) = law_misfits(made, one, [1], score.fall)
    choice = weighed(selection, Choice(one, score), [])
    outside = with_outside(made, choice, [1], CRITERIA).probabilities[OUTSIDE]
    if hours_of_day == (0, 24):
        assert misfit < 0.3 and outside < 0.1
    else:
        assert misfit > 1.0 and outside > 0.9


@pytest.mark.parametrize("unlike", [0.0, 3.0])
def test_the_days_of_a_standstill_have_no_residual_of_their_own(unlike):
    """Light that is missing on ten days, and how much more of them it leaves open."""
    random, (days, hours) = np.random.default_rng(8), clock(300)
    there = (days >= 100) & (days < 110)
    own = there * np.maximum(np.sin((hours - 6) * np.pi / 12), 0.0)
    rest = 4.0 * own + noise(random, len(days))
    rest += unlike * there * np.repeat(random.normal(size=300), 24)
    stuck = find(dict(name="tracker_stuck", start="2023-04-11", end="2023-04-21"))
    columns = {"one": np.ones(len(days)), "tracker_stuck.share": own}
    made = design(rest, columns, days, hours)
    made = replace(made, base=(1,), own={stuck.name: (2,)})
    made = replace(made, effects={stuck.name: stuck})
    selection = Selection(made, CRITERIA)
    (one,) = (c for c in selection.candidates([1]) if c.name == stuck.name)
    choice = Choice(one, selection.score(one, [1]), {one.name: one}, {}, {one.name: 1})
    (misfit,) = law_misfits(made, one, [1], choice.fall)
    outside = with_outside(made, choice, [1], CRITERIA).probabilities[OUTSIDE]
    if unlike:
        assert misfit > 0.7 and outside > 0.5
    else:
        assert misfit < 0.2 and outside < 0.05


@pytest.mark.parametrize("treated", [3, 6, 50])
def test_few_weeks_of_a_change_have_the_noise_of_all_weeks(treated):
    """A hundred weeks of noise; its variance is known, and their own is a poor one."""
    own, both = [], []
    for seed in range(200):
        random = np.random.default_rng(seed)
        weeks, rows = 100, 20
        column = np.repeat(np.arange(weeks) < treated, rows).astype(float)
        cells = np.column_stack(
            [random.normal(size=weeks * rows), np.ones(weeks * rows)]
        )
        cells = np.column_stack([cells, column])
        ends = np.arange(0, weeks * rows + 1, rows)
        found = LeastSquares(products(cells, np.ones(weeks * rows), ends), 1)
        variance, freedom = found.by_all_weeks()
        own.append(float(found.covariance[0, 0]))
        both.append(float(variance[0, 0]))
    true = 1.0 / (rows * treated * (1.0 - treated / weeks))
    assert np.mean(both) == pytest.approx(true, rel=0.15)
    assert freedom > found.freedom
    assert np.std(both) < (0.6 if treated < 10 else 1.0) * np.std(own)


def test_noise_that_lasts_for_weeks_makes_a_change_less_sure():
    random, weeks, rows = np.random.default_rng(0), 100, 20
    slow = noise(random, weeks, 0.6)
    column = np.repeat(np.arange(weeks) < 6, rows).astype(float)
    sizes = []
    for level in (slow, random.permutation(slow)):
        rest = np.repeat(level, rows) + random.normal(size=weeks * rows)
        cells = np.column_stack([rest, np.ones(weeks * rows), column])
        ends = np.arange(0, weeks * rows + 1, rows)
        found = LeastSquares(products(cells, np.ones(weeks * rows), ends), 1)
        sizes.append(float(found.by_all_weeks()[0][0, 0]))
    assert sizes[0] > 1.5 * sizes[1]


def test_the_placebo_of_white_noise_is_its_textbook_error():
    random, (days, hours) = np.random.default_rng(4), clock(400)
    own, rest = random.normal(size=(2, len(days)))
    made = design(rest, {"rain.film": own}, days, hours, own=["rain"])
    weekly = made.by_week([2, 1])
    covariance, _ = made.placebo([2], [1], LeastSquares(weekly, 1))
    assert covariance[0, 0] == pytest.approx(1.0 / len(days), rel=0.15)


@pytest.mark.parametrize("more", [0.5, 2.0])
def test_the_placebo_has_the_error_of_the_days_on_which_an_effect_acts(more):
    random, (days, hours) = np.random.default_rng(6), clock(700)
    acts = days // 10 % 5 == 0
    own, rest = random.normal(size=(2, len(days)))
    own, rest = np.where(acts, own, 0.0), np.where(acts, more, 1.0) * rest
    made = design(rest, {"rain.film": own}, days, hours, own=["rain"])
    fit = LeastSquares(made.by_week([1]), 1)
    covariance, _ = made.placebo([], [1], fit)
    # White (1980): the squares of the column times those of the error
    assert covariance[0, 0] == pytest.approx(more**2 / len(days), rel=0.15)


def of_dirt(random, hour, year):
    """Days since rain, of which more falls in winter."""
    rains = random.random(364) < 0.25 * (1.0 - 0.9 * year)
    since = np.arange(364) - np.maximum.accumulate(np.arange(364) * rains)
    return np.repeat(np.minimum(since, 60), 24)


ACTING = {
    "soiling": of_dirt,
    "the sun in the east": lambda random, hour, year: hour - 12.0,
    "the sun in the east, or in the west": lambda random, hour, year: (
        (hour - 12.0) * np.repeat(np.roll(year, 91), 24)
    ),
    "each day another": lambda random, hour, year: np.repeat(
        random.normal(size=364), 24
    ),
    "twenty days": lambda random, hour, year: np.repeat(
        np.isin(np.arange(364) // 5, [3, 9, 66, 69]), 24
    ),
}


@pytest.mark.parametrize("more", [0.5, -0.5])
@pytest.mark.parametrize("acting", ACTING)
def test_effects_are_as_sure_by_accident_as_is_stated(acting, more):
    """Noise with a memory of a day, three times as large in summer, or in winter."""
    chances = []
    for seed in range(150):
        random, (days, hours) = np.random.default_rng(seed), clock(364)
        sun, year = (
            np.sin((hours - 6) * np.pi / 12),
            np.cos(days * 2.0 * np.pi / YEAR - np.pi),
        )
        rest = lfilter(
            [1.0], [1.0, -np.exp(-1.0 / 24.0)], random.normal(size=len(days))
        )
        rest *= (1.0 + more * year) * (0.5 + sun)
        columns = {"sun": sun, "one": np.ones(len(days)), "year": year}
        columns |= {"sun of a year": year * sun}
        columns["rain.film"] = ACTING[acting](random, hours, year[::24]) * sun
        day = sun > 0
        columns = {name: column[day] for name, column in columns.items()}
        made = design(rest[day], columns, days[day], hours[day], own=["rain"])
        fit = LeastSquares(made.by_week([1, 2, 3, 4, 5]), 1)
        covariance, freedom = made.placebo([1, 2, 3, 4], [5], fit)
        ratio = fit.estimate[0] ** 2 / covariance[0, 0]
        chances.append(fdistribution.sf(ratio, 1.0, freedom))
    for level in (0.02, 0.1):
        count = int(np.sum(np.array(chances) < level))
        assert binomtest(count, len(chances), level).pvalue > 0.001, (level, count)


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.5, 0.9]))
def test_draws_that_are_alike_count_less(seed, memory):
    draws = noise(np.random.default_rng(seed), 4000, memory)
    expected = 4000.0 * (1.0 - memory**2) / (1.0 + memory**2)
    # the noise of the sample's autocorrelations halves it
    assert 0.3 * expected < effective_length(draws) < expected


def test_an_effect_acts_where_its_driver_is_missing():
    """Its size is that of the complete column, and hardly less sure."""
    random, (days, hours) = np.random.default_rng(7), clock(300)
    sun = np.maximum(np.sin((hours - 6) * np.pi / 12), 0.0)
    whole = 2.0 + sun + noise(random, len(days))
    rest = 2.0 * whole + 0.5 * noise(random, len(days))
    known = np.where(days % 50 < 20, 0.0, np.where(hours % 2, 1.0, 0.5))
    usual = np.array([np.ones(len(days)), sun])
    there = np.where(known > 0.0, whole, np.nan)
    half = filled(there, known, usual, np.ones(len(days)))
    found = {}
    for name, own in {"whole": whole, "half": half, "zero": whole * known}.items():
        columns = {"one": usual[0], "sun": sun, "rain.film": own}
        made = design(rest, columns, days, hours, own=["rain"])
        weekly = made.by_week([1, 2, 3])
        fit = LeastSquares(weekly, 1)
        (scale,) = made.scales([3])
        found[name] = fit.estimate[0] / scale, fit.covariance[0, 0] ** 0.5 / scale
    assert found["half"][0] == pytest.approx(2.0, rel=0.03)
    assert found["half"][1] < 0.3 * found["zero"][1]
    assert abs(found["zero"][0] - 2.0) > 0.5


@given(st.integers(0, 2**32 - 1), st.floats(-3.0, 3.0))
def test_more_of_a_column_is_estimated_as_so_much_more(seed, more):
    random, (days, hours) = np.random.default_rng(seed), clock(80)
    own, rest = random.normal(size=(2, len(days)))
    made = design(rest, {"rain.film": own}, days, hours, own=["rain"])
    step = Changed.from_effect(2, CHANGES["module_offset_step"].make(at="2023-02-01"))
    for column in (1, step):
        before = LeastSquares(made.by_week([column]), 1).estimate
        (scale,) = made.scales([column])
        added = made.adding(more * scale * made.values(column))
        after = LeastSquares(added.by_week([column]), 1).estimate
        assert (after - before) / scale == pytest.approx(more, abs=1e-6)


def test_every_finding_holds_a_cause_outside_and_its_shares_are_one():
    effects = simulator.PHYSICS | {"sky_radiation": 1.0, "wind_direction": 1.0}
    loop = close_loop(simulator.record(effects=effects, days=150, step=900, seed=2))
    added = [finding for finding in loop.finding_objects if finding.added]
    assert {"sky_radiation", "wind_direction"} <= {f.effect for f in added}
    for finding in added:
        shares = finding.probabilities
        assert OUTSIDE in shares and sum(shares.values()) == pytest.approx(1.0)
        assert finding.effect == max(
            (n for n in shares if n != OUTSIDE), key=shares.get
        )
        held = sum(shares[n] for n in (*finding.candidates,))
        sure = loop.criteria.min_probability
        assert (finding.verdict == "identified") == (shares[finding.effect] >= sure)
        if finding.verdict == "identified":
            assert finding.candidates == (finding.effect,)
        else:
            assert held + shares[OUTSIDE] >= sure


def grouped_design(random, groups, columns=2):
    """A design of random columns whose cells are in some groups, and those."""
    days, hours = clock(70)
    names = [f"column {i}" for i in range(columns)]
    table = dict(zip(names, random.normal(size=(columns, len(days)))))
    made = design(random.normal(size=len(days)), table, days, hours)
    return made, random.integers(0, groups, len(days))


@given(st.integers(0, 2**32 - 1), st.floats(0.01, 10.0))
def test_whitened_least_squares_is_generalised_least_squares(seed, ratio):
    """Against the inverse of the covariance of a random effect, written out."""
    random = np.random.default_rng(seed)
    made, groups = grouped_design(random, 12)
    size = np.bincount(groups, minlength=12)
    shares = ratio * size / (ratio * size + 1.0)  # variance over that of noise
    white = made.whitened([Table((), groups, ratio, 9.0, size * 0.0, shares, size)])
    there = np.eye(12)[groups]
    covariance = np.eye(len(groups)) + ratio * there @ there.T
    table = made.cells[:, :3]
    expected = table.T @ np.linalg.solve(covariance, table)
    np.testing.assert_allclose(white.by_week([1, 2]).sum(axis=0), expected, rtol=1e-8)


@given(st.integers(0, 2**32 - 1))
def test_a_change_is_whitened_as_any_column(seed):
    random = np.random.default_rng(seed)
    made, groups = grouped_design(random, 9)
    other = random.integers(0, 5, len(groups))
    tables = []
    for one, many in ((groups, 9), (other, 5)):
        size, shares = np.bincount(one, minlength=many), random.uniform(0, 1, many)
        tables.append(Table((), one, 1.0, 9.0, size * 0.0, shares, size))
    white = made.whitened(tables)
    step = Changed.from_effect(
        3, CHANGES["module_sensor_contact_step"].make(at="2023-02-10")
    )
    free = white.values(step)
    np.testing.assert_allclose(free, white.freed(made.values(step), tables))
    found = white.by_week([1, step]).sum(axis=0)
    assert found[0, 2] == pytest.approx(white.cells[:, 0] @ free)
    assert found[2, 2] == pytest.approx(free @ free)
    assert found[1, 2] == pytest.approx(white.cells[:, 1] @ free)


def test_an_effect_is_surer_beside_a_pattern_that_is_known():
    """As where an exhaust warms a module at weekends and wind cools it."""
    random, (days, hours) = np.random.default_rng(8), clock(126)
    weekend = (days % 7 >= 5) & (hours >= 9) & (hours < 16)
    sky = np.repeat(random.normal(size=126), 24)
    rest = 3.0 * weekend + 0.2 * sky + 0.3 * noise(random, len(days))
    columns = {"bias": np.ones(len(days)), "sky_radiation.share": sky}
    made = design(rest, columns, days, hours, own=["sky_radiation"])
    plain = Selection(made, CRITERIA)
    known = random_effects(made, [1], plain.least)
    assert known
    known = replace(plain, noise=tuple(known), known={}, scores={})
    one = Candidate(made.effects["sky_radiation"], (2,), np.log(CRITERIA.prior_odds))
    before, after = (s.score(one, [1]) for s in (plain, known))
    assert after.null[0, 0] < 0.5 * before.null[0, 0]
    assert after.seen[0] == pytest.approx(0.2, abs=4 * np.sqrt(after.null[0, 0]))
    assert after.probability > max(before.probability, CRITERIA.min_probability)


@pytest.mark.parametrize("fault", ["module_offset", "air_offset"])
def test_a_rival_may_have_the_name_of_another_finding(fault):
    """The most probable member is no other finding, of which the model has one."""
    random, (days, hours) = np.random.default_rng(4), clock(360)
    rest = 1.5 * (days >= 90) - 2.0 * (days >= 200) + noise(random, len(days))
    changing = [CHANGES[f"{name}_step"] for name in ("module_offset", "air_offset")]
    columns = {"one": random.normal(size=len(days))}
    made = design(rest, columns, days, hours, changing)
    # two laws, although their columns are the same
    made = replace(
        made,
        names=(*made.names, "again"),
        cells=np.column_stack([made.cells, made.cells[:, 2]]),
        scale=np.append(made.scale, 1.0),
        sensor_faults={"module_offset": 2, "air_offset": 3},
    )
    selection = Selection(made, CRITERIA)

    def found(name, given):
        return next(one for one in selection.candidates(given) if one.name == name)

    twin = {"module_offset": "air_offset", "air_offset": "module_offset"}[fault]
    other = found(f"{twin}_step", [1])
    mine = found(f"{fault}_step", [1, other.change])
    beside = [Choice(other, selection.score(other, [1]))]
    given = selection.given(beside)
    choice = weighed(selection, Choice(mine, selection.score(mine, given)), beside)
    choice = with_outside(made, choice, given, CRITERIA)
    assert choice.probabilities[f"{twin}_step"] > 0.3
    assert choice.first == f"{fault}_step"


def test_a_law_is_taken_by_whichever_of_its_faults_is_reported():
    """Two steps along one column, of which the first is given a sibling's name."""
    random, (days, hours) = np.random.default_rng(4), clock(360)
    rest = 1.5 * (days >= 90) - 2.0 * (days >= 200) + noise(random, len(days))
    changing = [CHANGES[f"{name}_step"] for name in ("module_offset", "air_offset")]
    columns = {"one": random.normal(size=len(days))}
    made = design(rest, columns, days, hours, changing)
    made = replace(made, sensor_faults={"module_offset": 2, "air_offset": 2})
    selection = Selection(made, CRITERIA)
    first = next(c for c in selection.candidates([1]) if c.name in CHANGES)
    alone = Choice(first, selection.score(first, [1]))
    others = weighed(selection, alone, []).members
    assert {*others} == {"module_offset_step", "air_offset_step"}
    for name, member in others.items():
        reported = Choice(member, selection.score(member, [1]))
        assert reported.top.name == name
        assert selection.best([reported]) is None
        # nor is it another finding at a date that a second sensor shows
        later = {
            effect.name: ShownChange(effect.dates(at="2023-07-20"), 3.0)
            for effect in changing
        }
        assert replace(selection, shown=later).best_shown([]) is not None
        assert replace(selection, shown=later).best_shown([reported]) is None


@given(st.integers(0, 2**32 - 1), st.integers(1, 2), st.integers(1, 2))
def test_what_two_explain_alike_is_what_one_of_them_loses_given_the_other(
    seed, size, rival
):
    """By fits to the columns themselves; twice the same explains all of it."""
    random = np.random.default_rng(seed)
    table = random.normal(size=(200, 3 + size + rival))
    rest, known = table[:, 0], table[:, 1:3]
    own, other = table[:, 3 : 3 + size], table[:, 3 + size :]

    def squares(*columns):
        columns = np.column_stack(columns)
        sizes = np.linalg.lstsq(columns, rest, rcond=None)[0]
        return np.square(rest - columns @ sizes).sum()

    alone = squares(known) - squares(known, own)
    given_other = squares(known, other) - squares(known, other, own)
    expected = np.clip(1.0 - given_other / alone, 0.0, 1.0)
    found = common_share(table.T @ table, size, rival)
    assert found == pytest.approx(expected, rel=1e-4, abs=1e-4)
    twice = np.column_stack([table[:, : 3 + size], own])
    assert common_share(twice.T @ twice, size, size) == pytest.approx(1.0, abs=1e-5)


def test_a_rival_that_is_the_truth_leaves_the_accident_to_the_best_candidate():
    """What a candidate has by accident is no evidence that the rival is not there."""
    columns = np.linalg.qr(np.random.default_rng(0).normal(size=(500, 4)))[0]
    known, truth, accident, further = columns.T
    rest, best = truth + 0.4 * accident + further, truth + 0.8 * accident
    table = np.column_stack([rest, known, best, truth])
    alone = (rest @ best) ** 2 / (best @ best)
    expected = 1.0 - 0.4**2 / alone
    assert common_share(table.T @ table, 1, 1) == pytest.approx(expected, rel=1e-3)
    # its part lies along the truth by less
    assert (truth @ best) ** 2 / (best @ best) < expected - 0.2


def test_an_obstacle_counts_for_what_no_function_of_the_usual_inputs_explains():
    """Some window of the sky looks much like the angle of incidence."""
    random, (days, hours) = np.random.default_rng(0), clock(200)
    angle, edge, rest = random.normal(size=(3, len(days)))
    window = 0.8 * angle + 0.6 * edge

    def gains(truth):
        """Mean square that an obstacle, and a film of rain, explain. [K²]"""
        columns = {"one": np.ones(len(days)), "incidence_angle.b0": angle}
        columns |= {"shading.share": window, "rain.film": window}
        own = "incidence_angle", "shading", "rain"
        selection = Selection(
            design(rest + truth, columns, days, hours, own=own), CRITERIA
        )
        base = [*selection.design.base]
        found = {one.name: one for one in selection.candidates(base)}
        return {name: selection.score(found[name], base).fall for name in own[1:]}

    by_angle, by_obstacle = gains(0.5 * angle), gains(0.5 * window)
    assert by_angle["rain"] == pytest.approx((0.8 * 0.5) ** 2, rel=0.2)
    assert by_angle["shading"] < 0.05 * by_angle["rain"]
    assert by_obstacle["rain"] == pytest.approx(0.5**2, rel=0.2)
    assert by_obstacle["shading"] == pytest.approx((0.6 * 0.5) ** 2, rel=0.3)


def test_a_law_that_is_not_exact_keeps_its_size_where_it_changes():
    """
    A drift, whose mean of each month is in a table, is seen within the months.

    The sensor's column follows the wind, and the truth does so by a third less: within
    hours of a month that is more than the drift, and none of it.
    """
    random, (days, hours) = np.random.default_rng(1), clock(360)
    wind = random.gamma(2.0, 1.0, len(days))
    seen, true = (1.0 / (1.0 + a * wind) for a in (0.3, 0.2))
    drift = next(e for e in CHANGES.values() if e.name == "air_offset_drift")
    drift = drift.dates(since="2023-01-01")
    rest = 3.0 * weights_of(drift, START + days) * true
    rest += 0.3 * noise(random, len(days))
    usual = {"flat": np.ones(len(days)), "windy": seen}
    made = design(rest, usual, days, hours, changing=[drift])
    made.cells[:, -1] = seen / np.sqrt(np.mean(seen**2))
    one = Candidate(drift, (Changed.from_effect(len(made.names) - 1, drift),), 0.0)
    months, *_ = remaining_shares(one, WithinCells(made, [*made.base]))
    assert months[0] == pytest.approx(1.0, abs=max(0.2, 2.0 * months[1]))


@given(st.integers(0, 2**32 - 1), st.floats(-2.0, 2.0).filter(lambda x: abs(x) > 1e-3))
def test_columns_that_are_sums_of_others_are_no_columns_of_an_effect(seed, times):
    """Of an hour of snow its cover and what stays of it are one."""
    random = np.random.default_rng(seed)
    cells = random.normal(size=(50, 4))
    cells[:, 2] = times * cells[:, 1]
    rows = random.integers(1, 12, 50).astype(float)
    assert independent_columns(cells, rows, [1, 2, 3]) == (1, 3)
    assert independent_columns(cells, rows, [0, 1, 3]) == (0, 1, 3)
    cells[1:, 1:] = 0.0
    assert independent_columns(cells, rows, [1, 2, 3]) == (1,)


def test_a_linearisation_that_chooses_the_same_effects_is_the_last(monkeypatch):
    """A model with effects has its columns at other places than one without."""
    sets, every = [], Search.round

    def noted(search, step, begin):
        last = every(search, step, begin)
        sets.append({one.top.name for one in last.choices})
        return last

    monkeypatch.setattr(Search, "round", noted)
    three = dict.fromkeys(["sky_radiation", "wind_direction", "rain"], 1.0)
    effects = simulator.PHYSICS | three
    close_loop(simulator.record(effects=effects, days=200, step=900, seed=2))
    assert sets[0] and sets.index(sets[-1]) == len(sets) - 2


def test_a_round_begins_with_the_choices_of_the_one_before(monkeypatch):
    """It makes them anew by its own columns, and keeps them if they still hold."""
    begun, every = [], Search.round

    def noted(search, step, begin):
        last = every(search, step, begin)
        own = last.selection.design.own
        begun.append([{one.top.name for one in some} for some in (begin, last.choices)])
        assert all(one.top.columns == own[one.top.name] for one in last.choices)
        return last

    monkeypatch.setattr(Search, "round", noted)
    effects = simulator.PHYSICS | dict.fromkeys(["sky_radiation", "rain"], 1.0)
    close_loop(simulator.record(effects=effects, days=200, step=900, seed=2))
    assert begun[0][0] == set() and len(begun) > 1
    assert begun[1][0] == begun[0][1] == begun[1][1] != set()


def gains_by_round(monkeypatch):
    """What each choice explains, by name, of rounds that are still to come. [K²]"""
    gains, every = [], Search.round

    def noted(search, step, begin):
        last = every(search, step, begin)
        gains.append({one.top.name: one.fall for one in last.choices})
        return last

    monkeypatch.setattr(Search, "round", noted)
    return gains


def test_an_effect_is_worth_as_much_once_it_is_in_the_model(monkeypatch):
    """Tangents that contain it in part would explain it between them."""
    gains = gains_by_round(monkeypatch)
    effects = simulator.PHYSICS | {"wind_direction": 2.0, "rain": 1.0}
    close_loop(simulator.record(effects=effects, days=200, step=900, seed=2))
    assert len(gains) == 2 and {*gains[0]} == {"wind_direction", "rain"}
    assert gains[1] == pytest.approx(gains[0], rel=0.1)


def test_an_obstacle_is_worth_as_much_once_it_is_in_the_model(monkeypatch):
    """Tangents that contain its shade in part would explain it between them."""
    gains = gains_by_round(monkeypatch)
    effects = simulator.PHYSICS | {"shading": 1.0}
    data = simulator.record(effects=effects, days=365, step=900, seed=2)
    site = simulator.RHINE
    close_loop(
        data.drop(columns=["p_dc_per_area", "snow_depth"]),
        location=Location(site.latitude, site.longitude, site.tz),
        surface_tilt=site.surface_tilt,
        surface_azimuth=site.surface_azimuth,
    )
    assert len(gains) == 2 and {*gains[0]} == {"shading"}
    assert gains[1] == pytest.approx(gains[0], rel=0.1)


def test_heat_alters_no_tangent_of_heat_alone(monkeypatch):
    """It alters those of losses, which grow with the temperature of the module."""
    heats, losses, every = [], [], Search.round

    def noted(search, step, begin):
        effects = step.model.effects
        wanted = [e for e in search.case.wanted if not e.scan and e not in effects]
        at = search.fits.linearisation(step, wanted)
        whole = at.evidence(wanted, {})
        for one in effects:
            if one.name not in whole.heat_alone or one.name in search.usual:
                continue
            rest = tuple(effect for effect in effects if effect is not one)
            less = replace(at, model=replace(at.model, effects=rest))
            less = less.evidence(wanted, {})
            for name in {*whole.columns} & {*less.columns}:
                kind = heats if name in less.heat_alone else losses
                change = np.abs(whole.columns[name] - less.columns[name])
                size = np.nanmax(np.abs(whole.columns[name]))
                kind.append(np.nanmax(change) / max(size, 1e-9))
        return every(search, step, begin)

    monkeypatch.setattr(Search, "round", noted)
    effects = simulator.PHYSICS | {"sky_radiation": 1.0, "wind_direction": 1.0}
    close_loop(simulator.record(effects=effects, days=100, step=1800, seed=2))
    assert len(heats) > 5 and max(heats) < 1e-9
    assert len(losses) > 5 and max(losses) > 0.1


@given(st.integers(0, 2**32 - 1))
def test_columns_are_those_of_the_model_with_what_is_given(seed):
    """What the other effects of the model add is in none of them."""
    random, (days, hours) = np.random.default_rng(seed), clock(70)
    rest, one, film, dew = random.normal(size=(4, len(days)))
    columns = {"one": one, "rain.film": film, "dew.share": dew}
    made = design(rest, columns, days, hours, own=["rain"])
    made = replace(made, own=made.own | {"dew": (3,)})
    by_rain, by_dew = random.normal(size=(2, *made.cells.shape))
    every = replace(made, added={(2,): by_rain, (3,): by_dew})
    parts = {(1, 2, 3): 0.0, (1, 2): by_dew, (1, 3): by_rain, (1,): by_rain + by_dew}
    for columns, less in parts.items():
        cells = made.cells - less
        table = cells[:, [0, *columns]]
        found = every.at(columns)
        np.testing.assert_allclose(found.cells, cells, atol=1e-12)
        np.testing.assert_allclose(found.whole(columns), table.T @ table, atol=1e-9)
        assert every.at(columns) is found


@pytest.mark.parametrize("order", [1, -1])
def test_of_causes_with_the_same_column_the_first_is_taken(order):
    """The sign of the last digits must not choose: it differs between machines."""
    random, (days, hours) = np.random.default_rng(7), clock(200)
    names = ["module_sensor_contact_step", "mounting_step"][::order]
    rest = 1.0 * (days >= 90) + noise(random, len(days))
    slow = np.sin(days / 30.0)
    for _ in range(5):
        twist = 1.0 + 1e-15 * random.normal(size=len(days))
        changing = [CHANGES[name] for name in names]
        made = design(rest * twist, {"slow": slow}, days, hours, changing)
        # the second is the same column once more, but for its last digits
        cells = np.column_stack([made.cells, made.cells[:, 2] * twist])
        faults = [CHANGES[name].sensor_fault for name in names]
        made = replace(
            made,
            names=(*made.names, "again"),
            cells=cells,
            scale=np.append(made.scale, 1.0),
            sensor_faults=dict(zip(faults, (2, 3))),
        )
        selection = Selection(made, CRITERIA)
        best = selection.best([])
        choice = weighed(selection, best, [])
        choice = with_outside(made, choice, [*made.base], CRITERIA)
        one, other = (choice.probabilities[name] for name in names)
        assert best.top.name == choice.first == names[0]
        assert one == other > 0.3


def test_faults_of_one_law_are_searched_once_and_share_its_prior():
    """Light of the sensor and of the modules has one column, as contact has another."""
    random, (days, hours) = np.random.default_rng(8), clock(200)
    rest = 1.0 * (days >= 90) + noise(random, len(days))
    names = "irradiance_sensor", "module_irradiance", "module_sensor_contact"
    changing = [CHANGES[f"{name}_step"] for name in names]
    made = design(rest, {"slow": np.sin(days / 30.0)}, days, hours, changing)
    made = replace(
        made,
        names=(*made.names, "again"),
        cells=np.column_stack([made.cells, made.cells[:, 2]]),
        scale=np.append(made.scale, 1.0),
        sensor_faults=dict(zip(names, (2, 2, 3))),
    )
    selection = Selection(made, CRITERIA)
    searched = {one.effect.sensor_fault for one in selection.candidates([*made.base])}
    assert searched == {"irradiance_sensor", "module_sensor_contact"}
    choice = weighed(selection, selection.best([]), [])
    sensor, light, contact = (choice.weights[f"{name}_step"] for name in names)
    assert sensor == pytest.approx(light) == pytest.approx(0.5 * contact)
    dates = {str(one.effect.settings) for one in choice.members.values()}
    assert len(dates) == 1


@given(st.integers(0, 2**32 - 1))
def test_candidates_explain_together_what_each_explains_alone(seed):
    random, (days, hours) = np.random.default_rng(seed), clock(120)
    columns = {name: random.normal(size=len(days)) for name in ("one", "other")}
    rest = random.normal(size=len(days)) + 0.5 * (days >= 60)
    made = design(rest, columns, days, hours, [*CHANGES.values()][:6])
    selection = Selection(made, CRITERIA)
    change = next(all_candidates(made, [1], 21, 0.1)).columns[0]
    for given_columns in ([1], [1, 2], [1, change]):
        some = [*all_candidates(made, given_columns, 21, 0.1)]
        falls = selection.in_sample(some, given_columns)
        for one, fall in zip(some, falls):
            if not one.beyond(given_columns):
                continue
            table = [made.values(c) for c in [*given_columns, *one.columns]]
            squares = [
                np.square(made.cells[:, 0] - fitted(part, made.cells[:, 0])).sum()
                for part in (table[:-1], table)
            ]
            expected = (squares[0] - squares[1]) / len(rest)
            assert fall == pytest.approx(expected, rel=1e-5, abs=1e-9)


def fitted(columns, values):
    """Least squares of values by columns."""
    table = np.column_stack(columns)
    return table @ np.linalg.lstsq(table, values, rcond=None)[0]


@pytest.mark.parametrize(
    "name",
    [
        "time_constant_step",
        "time_constant_episode",
        "season",
        "wind_direction",
        "soiling",
    ],
)
def test_what_an_unknown_cause_can_imitate_is_never_identified(name):
    """The cause outside keeps its prior probability as a rival."""
    outside, alike = prior_of(EFFECTS[name], 0.07)
    assert (outside, alike) == (0.07, 1.0)
    assert prior_of(EFFECTS["irradiance_sensor_step"], 0.07)[1] < 1.0


@pytest.mark.parametrize(
    ("fault", "change", "there"),
    [
        ("time_constant", 0.2, False),
        ("time_constant", 1.0, True),
        ("module_sensor_contact", 0.2, True),
    ],
)
def test_a_change_within_the_error_of_the_heat_capacity_is_no_cause(
    fault, change, there
):
    """One capacity stands for several, of which each season shows another part."""
    days, hours = clock(365)
    rest = 10.0 * change * (days >= 200) + noise(np.random.default_rng(5), len(days))
    steps = [CHANGES[f"{fault}_step"]]
    made = design(rest, {"one": np.ones(len(days))}, days, hours, steps)
    made.scale[-1] = 10.0  # K, that a change of 100 % makes
    best = Selection(made, CRITERIA).best([])
    assert (best is not None) == there
    if there:
        assert best.score.estimate[0] == pytest.approx(change, abs=0.02)


def test_a_trend_of_the_heat_capacity_is_weighed_by_what_it_has_become():
    """Of three years at 0.4 per year, in which a tenth per year says nothing."""
    days, hours = clock(3 * 365)
    rest = 10.0 * 0.4 * days / YEAR + noise(np.random.default_rng(5), len(days))
    trend = [CHANGES["time_constant_drift"]]
    made = design(rest, {"one": np.ones(len(days))}, days, hours, trend)
    made.scale[-1] = 10.0  # K, that a change of 100 % makes
    best = Selection(made, CRITERIA).best([])
    assert best.top.name == "time_constant_drift"
    assert best.score.estimate[0] == pytest.approx(0.4, abs=0.02)


@pytest.mark.parametrize(("years", "least"), [(1, -0.3), (2, -0.3), (8, -0.6 / 8)])
def test_a_trend_becomes_no_more_than_its_fault_can_be(years, least):
    """A module that loses 7.5 % less heat each year loses 60 % less after eight."""
    days, hours = clock(round(years * YEAR))
    trend = CHANGES["mounting_drift"].make(since="2023-01-01")
    made = design(np.zeros(len(days)), {"one": np.ones(len(days))}, days, hours)
    candidate = Candidate(trend, made.columns_of(trend), 0.0)
    (row,) = candidate.rows(made).values()
    assert row.lower == pytest.approx(least, rel=2e-3)
    assert row.upper == pytest.approx(-2.5 * least, rel=2e-3)
    step = CHANGES["mounting_step"].make(at="2023-02-01")
    candidate = Candidate(step, made.columns_of(step), 0.0)
    assert candidate.rows(made) == step.rows()


@pytest.mark.parametrize(
    ("change", "there"), [(0.3, set()), (1.0, {"time_constant_step"})]
)
def test_two_faults_on_one_date_are_no_change_of_the_heat_capacity(change, there):
    """
    Less loss and less gain cancel by day and leave a module that is slower.

    Within the error of the heat capacity that is no cause, however sure it is.
    """
    days, hours = clock(365)
    slow, random = np.sin(2.0 * np.pi * hours / 24.0), np.random.default_rng(3)
    rest = 4.0 * change * slow * (days >= 150) + 0.3 * noise(random, len(days))
    columns = {"one": np.ones(len(days)), "other": 2.0 * slow - 1.0, "slow": slow}
    steps = "module_offset_step", "module_sensor_contact_step", "time_constant_step"
    changing = [CHANGES[name] for name in steps]
    made = design(rest, columns, days, hours, changing)
    faults = (effect.sensor_fault for effect in changing)
    made = replace(made, sensor_faults=dict(zip(faults, (1, 2, 3))))
    made.scale[3] *= 4.0  # K, that a change of 100 % makes
    assert {one.top.name for one in Selection(made, CRITERIA).run()} == there


def probabilities_of(residual, effect, air):
    """Probabilities of the best candidate for a residual of a year, as by dates."""
    days, hours = clock(365)
    rest = residual + noise(np.random.default_rng(5), len(days))
    columns = {"one": np.ones(len(days))}
    made = design(rest, columns, days, hours, [CHANGES[effect]], temp_air=air)
    if effect.startswith("module_sensor_contact"):
        made.scale[1:] = 20.0  # K over the air, of which it is a share
    selection = Selection(made, CRITERIA)
    best = weighed(selection, selection.best([]), [])
    assert best.top.name == effect
    return with_outside(made, best, [*made.base], CRITERIA).probabilities


@pytest.mark.parametrize("coldest", [-4.0, 4.0])
@pytest.mark.parametrize(
    ("effect", "probable"),
    [("module_sensor_contact_episode", 0.5), ("module_offset_episode", 1 / 11)],
)
def test_a_change_while_snow_can_lie_is_as_probably_snow(coldest, effect, probable):
    """Snow covers modules and sensors until it melts, and is seldom an offset."""
    days, hours = clock(365)
    winter = (days >= 100) & (days < 160)
    air = np.where(winter, coldest, 15.0) + 3.0 * (hours > 9)
    found = probabilities_of(2.0 * winter, effect, air)
    if coldest < 0.0:
        assert found[SNOW] == pytest.approx(probable, abs=0.02)
        assert found[effect] < 1.0 - probable
    else:
        assert SNOW not in found
        assert found[effect] >= CRITERIA.min_probability


@pytest.mark.parametrize(("at", "snow"), [(60, True), (200, False)])
def test_a_step_is_snow_only_if_it_is_none_without_the_frosty_days(at, snow):
    """A step at the end of a frosty winter is a temporary change until then."""
    (days, hours), effect = clock(365), "module_sensor_contact_step"
    air = np.where(days < 60, -4.0, 15.0) + 3.0 * (hours > 9)
    found = probabilities_of(2.0 * (days >= at), effect, air)
    if snow:
        assert found[SNOW] == pytest.approx(0.5, abs=0.02)
    else:
        assert found[SNOW] < 0.001
        assert found[effect] >= CRITERIA.min_probability


@pytest.mark.parametrize("members", [["modules_covered"], ["modules_covered", "snow"]])
@pytest.mark.parametrize("covered, snow", [(0.6, 0.3), (0.3, 0.6)])
def test_snow_is_no_other_cause_than_the_more_probable_cover(members, covered, snow):
    """Power shows that the modules are covered, as by snow."""
    some = {name: Candidate(EFFECTS[name], (), 0.0) for name in members}
    choice = Choice(some["modules_covered"], None, some)
    stated = {"modules_covered": covered, SNOW: snow, OUTSIDE: 0.1}
    found = with_special_cases(choice, stated)
    assert sum(found.values()) == pytest.approx(1.0)
    if snow > covered:  # the more precise cause
        assert found == stated
    else:
        assert found["modules_covered"] == pytest.approx(0.9)
        assert found.get(SNOW, 0.0) == 0.0
        assert (SNOW in found) == (SNOW in members)


def test_a_step_after_a_winter_with_thaws_is_no_snow():
    """What nights of frost bring melts by day, and the change is there by day, too."""
    (days, hours), effect = clock(365), "module_sensor_contact_step"
    air = np.where(days < 60, np.where(hours < 8, -3.0, 8.0), 15.0)
    found = probabilities_of(2.0 * (days >= 60), effect, air)
    assert found[SNOW] < 0.001
    assert found[effect] >= CRITERIA.min_probability


@pytest.mark.parametrize(
    ("first", "second", "later", "there"),
    [(2.0, 0.8, 0, False), (2.0, 0.8, 120, True), (1.0, 1.0, 0, True)],
)
def test_what_the_law_of_a_change_may_leave_is_no_other_change(
    first, second, later, there
):
    """Another one has dates of its own, or is larger than that error."""
    (days, hours), random = clock(365), np.random.default_rng(3)
    shape = np.sin(2.0 * np.pi * hours / 24.0)
    rest = first * (days >= 150) + second * shape * (days >= 150 + later)
    rest += 0.3 * noise(random, len(days))
    columns = {"shape": shape, "one": np.ones(len(days))}
    changing = CHANGES["module_offset_step"], CHANGES["module_sensor_contact_step"]
    made = design(rest, columns, days, hours, changing)
    offset, contact = (effect.sensor_fault for effect in changing)
    made = replace(made, sensor_faults={offset: 3, contact: 1})
    names = {one.top.name for one in Selection(made, CRITERIA).run()}
    assert "module_offset_step" in names
    assert ("module_sensor_contact_step" in names) is there


@pytest.mark.parametrize(("shown", "taken"), [(201, 201), (100, 200)])
def test_a_date_that_a_second_sensor_shows_is_taken_unless_another_is_better(
    shown, taken
):
    """The temperature's own date costs a search, which is little for a clear step."""
    days, hours = clock(300)
    rest = 2.0 * (days >= 200) + noise(np.random.default_rng(5), len(days))
    changing = [CHANGES["module_offset_step"]]
    made = design(rest, {"one": np.ones(len(days))}, days, hours, changing)
    effect = changing[0].make(at=str(np.datetime64(START + shown, "D")))
    shown_change = ShownChange(effect, 0.0)
    selection = Selection(made, CRITERIA, shown={effect.name: shown_change})
    (top,) = selection.candidates([*made.base])
    assert top.effect.settings["at"] == str(np.datetime64(START + taken, "D"))
    assert top.dates == (shown != taken) and top.dates_known == (shown == taken)


def two_changes():
    """A step of the module's offset, and a trend that begins with it."""
    days, hours = clock(300)
    step, ramp = days >= 200, np.clip((days - 200) / 365.25, 0.0, None)
    rest = 0.2 * step + 1.5 * ramp + noise(np.random.default_rng(5), len(days), 0.5)
    names = "module_offset_step", "module_offset_drift"
    columns = {"one": np.ones(len(days)), "wave": np.cos(hours / 4.0)}
    made = design(rest, columns, days, hours, [CHANGES[name] for name in names])
    date = str(np.datetime64(START + 200, "D"))
    effects = (CHANGES[names[0]].make(at=date), CHANGES[names[1]].make(start=date))
    one, other = (
        Candidate(effect, made.columns_of(effect), float(np.log(CRITERIA.prior_odds)))
        for effect in effects
    )
    return made, one, other


@pytest.mark.parametrize("shown", [-3.0, 0.0, 3.0, 30.0])
def test_references_count_among_the_odds_of_a_change(shown):
    """By no more than a limit, and in the unit of what it explains."""
    made, one, _ = two_changes()
    given = [*made.base]
    plain = Selection(made, CRITERIA).score(one, given)
    by_all = Selection(made, CRITERIA, likelihoods=lambda sized: [shown] * len(sized))
    score, odds = by_all.score(one, given), log_odds(plain.probability)
    counts = min(shown, MOST_SHOWN)
    assert score.shown == counts
    assert log_odds(score.probability) == pytest.approx(odds + counts)
    more = by_all.worth(one, score) - by_all.worth(one, plain)
    assert more == pytest.approx(2.0 * CRITERIA.law_error**2 * counts * score.fall)


def test_a_date_by_a_reference_has_its_odds_already():
    made, one, _ = two_changes()
    known = replace(one, dates_known=True)
    plain = Selection(made, CRITERIA).score(known, [*made.base])
    by_all = Selection(made, CRITERIA, likelihoods=lambda sized: [3.0] * len(sized))
    score = by_all.score(known, [*made.base])
    assert score.probability == pytest.approx(plain.probability)
    assert score.shown == 3.0


def test_an_effect_is_less_probable_if_a_reference_refuses_what_it_makes_of_another():
    """Given a trend, the step has another size than a second sensor says."""
    made, step, trend = two_changes()
    seen = []

    def likelihoods(changes):
        # of the step it knows the size, of the trend nothing
        (of_step,) = (one for (one, *_) in changes if one.effect is step.effect)
        seen.append(of_step.size)
        off = of_step.size - first.estimate[0]
        return [
            -0.5 * (off / 0.05) ** 2 if one.effect is step.effect else 0.0
            for (one, *_) in changes
        ]

    first = Selection(made, CRITERIA).score(step, [*made.base])
    given = [*made.base, *step.columns]
    plain = Selection(made, CRITERIA).score(trend, given)
    score = Selection(made, CRITERIA, likelihoods=likelihoods).score(trend, given)
    before, after = seen
    assert before == pytest.approx(first.estimate[0]) and after < 0.7 * before
    expected = -0.5 * ((after - before) / 0.05) ** 2
    assert score.shown == pytest.approx(max(expected, -MOST_SHOWN))
    change = log_odds(score.probability) - log_odds(plain.probability)
    assert change == pytest.approx(score.shown)


def test_a_fault_is_weighed_with_all_its_time_profiles():
    """Also with a step that is less like the best candidate than a trend of it is."""
    (row,) = EFFECTS["rear_irradiance"].rows()
    random, (days, hours) = np.random.default_rng(0), clock(300)
    ramp, step = np.clip((days - 100) / 200.0, 0.0, None), days >= 20
    wave = np.sin(np.pi * (hours + 0.5) / 6.0)
    wave *= np.sqrt(2.0 * ramp.var() * (1.0 / 0.36 - 1.0))
    rest = step + 0.6 * (ramp + wave) + 0.3 * noise(random, len(days))
    changing = [CHANGES["module_offset_step"], CHANGES["module_offset_drift"]]
    columns = {"one": np.ones(len(days)), row: ramp + wave}
    made = design(rest, columns, days, hours, changing, own=["rear_irradiance"])
    selection, base = Selection(made, CRITERIA), [*made.base]
    top, *others = selection.candidates(base)
    assert top.name == "rear_irradiance"
    alike = {one.name: selection.alike(top, one, base) for one in others[:2]}
    assert alike["module_offset_step"] < OVERLAP < alike["module_offset_drift"]
    weights = weighed(selection, Choice(top, selection.score(top, base)), []).weights
    assert weights["module_offset_drift"] > weights["module_offset_step"] > 0.03
