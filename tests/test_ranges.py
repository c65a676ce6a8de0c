"""Ranges of coefficients over the other models that a record leaves possible."""

import json

import numpy as np
import pandas as pd
import pytest
import study_worlds
from conftest import COLUMNS, DRIVERS
from hypothesis import given, strategies as st
from test_effects import coefficients

import pvlib_fem as fem
from pvlib_fem import datasets, simulator
from pvlib_fem.effects import CHANGES, EFFECTS, find
from pvlib_fem.effects.courses import is_drift
from pvlib_fem.findings import Finding, Verdict
from pvlib_fem.loop.close import Search, searched
from pvlib_fem.loop.criteria import Criteria
from pvlib_fem.loop.evidence import Evidence
from pvlib_fem.loop.ranges import everywhere, solved, within
from pvlib_fem.loop.rules import gained
from pvlib_fem.report.document import spanned
from pvlib_fem.statistics.clusters import cluster_sums
from pvlib_fem.stored import Stored
from pvlib_fem.thermal.model import ThermalModel
from pvlib_fem.thermal.steady import STEADY_MODELS

SHARE = 0.8  # of the sky
#: what a loop is given where nothing is
USUAL = dict(
    holdout=None, effects=None, check_units=False, criteria=Criteria(), fixed=None
)


@pytest.fixture(scope="module")
def under_a_sky():
    """Two hundred days at half an hour under a sky, with an error of hours."""
    data = datasets.synthetic(200, 1800, seed=3, noise=0).tz_localize(None)
    random = np.random.default_rng(1)
    clouds = pd.Series(random.normal(size=len(data))).ewm(halflife=20).mean() * 5.0
    data["longwave_down"] = 330.0 + 25.0 * clouds.to_numpy()
    effect = next(f for f in find("sky_radiation").forms if "sky_deficit" in f.drivers)
    model = ThermalModel(STEADY_MODELS["faiman"], "balance", (effect,))
    values = {**coefficients("balance"), "sky_radiation.share": SHARE}
    usual = [data[name] for name in DRIVERS]
    module = model.predict(*usual, values, longwave_down=data["longwave_down"])
    noise = pd.Series(random.normal(0.0, 0.8, len(data)), data.index)
    return data.assign(temp_module=module + noise.ewm(halflife=4).mean())


@pytest.fixture(scope="module")
def loop(under_a_sky):
    return fem.close_loop(under_a_sky, check_units=False)


def first(loop):
    (finding,) = (f for f in loop.findings if f.effect == "sky_radiation")
    return finding, finding.ranges["sky_radiation.share"]


def test_the_range_holds_the_truth_and_more_than_the_error(loop):
    sky, (low, high) = first(loop)
    value, error = (
        part["sky_radiation.share"] for part in (sky.coefficients, sky.stderr)
    )
    assert sky.added and low < SHARE < high
    assert high - value > 1.5 * error and value - low > 1.5 * error
    assert value - low == pytest.approx(high - value)


@pytest.mark.parametrize("other", ["season", "thermal_storage", "contact_drift"])
def test_a_fit_with_one_more_effect_is_within_the_range(under_a_sky, loop, other):
    """By a fit of all coefficients, which the sums know to first order only."""
    fit = fem.fit_fem(
        *(under_a_sky[name] for name in COLUMNS),
        longwave_down=under_a_sky["longwave_down"],
        model="faiman",
        dynamics="balance",
        effects=[*loop.fit.effects, other],
        holdout=loop.weeks != "fitting",
        night=True,
    )
    low, high = first(loop)[1]
    assert low < fit.coefficients["sky_radiation.share"] < high


def test_what_is_not_in_the_model_has_no_range(loop):
    for finding in loop.findings:
        assert bool(finding.ranges) is finding.added
        for name, (low, high) in finding.ranges.items():
            row = loop.fit.thermal_model.parameters[name]
            assert row.lower <= low <= finding.coefficients[name] <= high <= row.upper


def test_it_is_printed_and_in_the_page_and_comes_back_from_a_file(loop, tmp_path):
    ends = first(loop)[1]
    assert f"(range {spanned(*ends)})" in " ".join(str(loop).split())
    assert spanned(*ends) in loop.to_html()
    again = fem.Loop.from_json(_written(loop, tmp_path))
    assert [f.ranges for f in again.findings] == [f.ranges for f in loop.findings]
    assert str(again) == str(loop)


def _written(loop, folder):
    loop.to_json(folder / "loop.json")
    return folder / "loop.json"


@pytest.mark.parametrize("ends", [[1.0], [1.0, "x"], [1.0, None], [1.0, True], 2.0])
def test_a_range_that_is_none_is_refused(loop, ends):
    content = json.loads(json.dumps(first(loop)[0].content()))
    assert Finding.stored(Stored(content, "x")).verdict is Verdict.NAMED
    content["ranges"]["sky_radiation.share"] = ends
    with pytest.raises(ValueError, match=r"ranges\.sky_radiation\.share"):
        Finding.stored(Stored(content, "x"))


@pytest.mark.parametrize(
    ("low", "high", "words"),
    [
        (0.8489, 1.3011, "0.85 … 1.30"),
        (-0.39, 0.245, "-0.39 … 0.24"),
        (0.0, 3.5, "0.0 … 3.5"),
    ],
)
def test_ends_are_told_to_two_digits_of_half_their_distance(low, high, words):
    assert spanned(low, high) == words


def series(seed, days=12, rows=20):
    random = np.random.default_rng(seed)
    dates = np.repeat(np.arange(days), rows)
    columns = list(random.normal(size=(3, len(dates))) * [[1.0], [7.0], [0.2]])
    return columns, random.normal(size=len(dates)), dates, random


@given(st.integers(0, 2**32 - 1))
def test_sums_about_another_point_are_those_of_its_residual(seed):
    columns, rest, dates, random = series(seed)
    shift = random.normal(size=3)
    moved = cluster_sums(columns, rest, dates).about(shift)
    less = rest - np.dot(shift, columns)
    expected = cluster_sums(columns, less, dates)
    np.testing.assert_allclose(moved.sums, expected.sums, atol=1e-8)


@given(st.integers(0, 2**32 - 1))
def test_beside_means_of_cells_a_solution_is_that_with_a_column_of_each(seed):
    columns, rest, dates, random = series(seed)
    bins = random.integers(0, 4, len(dates))
    names = ("a", "b", "c")
    found = Evidence(
        dict(zip(names, columns)), rest, dates, np.arange(len(dates)), names, ()
    )
    shift, half = solved(within(found, bins), [0, 1, 2], [0, 2])
    wide = np.column_stack([*columns, *(bins == i for i in range(4))])
    expected = np.linalg.lstsq(wide, rest, rcond=None)[0]
    np.testing.assert_allclose(shift, expected[[0, 2]], rtol=1e-5, atol=1e-8)
    assert (half > 0).all()


@given(st.integers(0, 2**32 - 1))
def test_what_a_model_lacks_is_weighed_as_if_it_had_never_been_there(seed):
    (one, east, north), rest, dates, random = series(seed, days=80)
    effect = find("wind_direction")
    names = [*effect.rows()]
    columns = {"u0": one} | dict(zip(names, (east, north)))
    rows = np.arange(len(dates))
    fitted = dict(zip(names, random.normal(size=2)))
    whole = Evidence(columns, rest, dates, rows, ("u0", *names), ())
    before = rest + fitted[names[0]] * east + fitted[names[1]] * north
    without = Evidence(columns, before, dates, rows, ("u0",), (), {effect.name: names})
    expected = without.gain(effect.name)
    assert whole.lacking(effect, fitted).gain(effect.name) == pytest.approx(expected)
    whole.sums(())  # from sums that are there it is the same
    assert whole.lacking(effect, fitted).gain(effect.name) == pytest.approx(expected)


@pytest.mark.parametrize(("kept", "counts"), [(0.7, 1.0), (0.3, 0.3)])
def test_a_driver_is_worth_what_it_is_in_the_model(kept, counts):
    """Where a confounder that is not in it leaves half of that; else what it leaves."""
    random, rows = np.random.default_rng(0), 60_000
    (name, wind), season = find("wind_direction").rows(), find("season")
    driver, other, noise, rest = random.normal(size=(4, rows))
    alike = np.sqrt(1.0 - kept) * driver + np.sqrt(kept) * other
    own = dict.fromkeys(season.rows(), noise)
    own[next(iter(own))] = alike
    dates = np.repeat(np.arange(300), 200)
    columns = {"u0": np.ones(rows), name: driver, wind: random.normal(size=rows)} | own
    effects = {"wind_direction": find("wind_direction"), "season": season}
    mine = {"wind_direction": (name, wind), "season": tuple(own)}
    residual = 0.5 * driver + 0.1 * rest
    how = (dates, np.arange(rows), ("u0",), (), mine, effects)
    found = Evidence(columns, residual, *how)
    check = gained(found, "wind_direction", found.confounders)
    assert check.statistic == pytest.approx(0.5 * np.sqrt(counts), rel=0.02)


#: snow that goes at once, which in these worlds does not
SLIDES = [*(n for n in EFFECTS if n != "snow"), {"name": "snow", "sliding": 1e-6}]


def test_what_is_nothing_beside_another_effect_is_not_told():
    """
    A winter of snow before a step from which on all is otherwise, and a window.

    Beside power, which sees the snow, the step is nothing; the window stood on it. The
    loop named both: the error on test weeks rose from 1.05 to 1.42 K.
    """
    site = study_worlds.site(813104, **study_worlds.COLD)
    effects = simulator.PHYSICS | {"snow": 0.75}
    data = simulator.record(site, effects=effects, days=365, step=300, seed=813104)
    place = study_worlds.World(site, 813104).place
    loop = fem.close_loop(data, **place, effects=SLIDES)
    told = [f for f in loop.findings if f.added]
    (snow,) = (f for f in told if f.verdict == "named")
    # what is nowhere to be seen is not told
    assert snow.effect == "snow" and [*snow.coefficients] == ["snow.share"]
    assert loop.fit.coefficients["snow.stays"] == 0.0
    assert np.isnan(loop.fit.stderr["snow.stays"])
    assert not any(f.effect in CHANGES for f in told)
    (doubted,) = (f for f in loop.findings if "would be" in f.why)
    assert "beside electrical_output, contact_step.change would be" in doubted.why
    assert doubted.verdict == "suggestive" and not doubted.checks[-1].passed
    error = loop.table["rmse_test"]
    assert error.iloc[-1] < 1.01 * error["+snow"]


def test_a_search_that_goes_back_ends():
    """A drift that is nothing beside others has no other date, and comes no more."""
    site = study_worlds.site(1313104, **study_worlds.COLD)
    effects = simulator.PHYSICS | {"snow": 0.75}
    data = simulator.record(site, effects=effects, days=365, step=300, seed=1313104)
    place = study_worlds.World(site, 1313104).place.values()
    how = USUAL | {"effects": SLIDES}
    search, loop = searched(data, "faiman", (*place,), None, **how)
    (drift,) = (e for e in search.doubted if e.channel and is_drift(e))
    assert drift.name in search.closed
    assert not any(drift.name in f.candidates for f in loop.findings if f.added)
    names = [f.effect for f in loop.findings if f.added and f.verdict == "named"]
    assert names == ["snow"]


def test_a_confounder_that_is_no_more_tried_is_a_rival_all_the_same():
    """Else what it explains is open to an effect that has a driver."""
    data = simulator.record(effects=simulator.PHYSICS, days=365, step=3600, seed=0)
    search, loop = searched(data, "faiman", (None,) * 3, None, **USUAL)
    (first,) = loop.effects[:1]
    search.findings, search.doubted = [], (find(first),)
    found = search.evidence(search.start)
    assert first in found.confounders
    search.further(search.start, found)
    assert not any(first in finding.candidates for finding in search.findings)


def test_what_was_nothing_is_tried_once_more_at_another_date():
    step = find({"name": "contact_step", "at": "2023-03-01"})
    drift = find({"name": "contact_drift", "since": "2023-01-01"})
    search = Search.__new__(Search)
    search.doubted = (step, drift, find("wind_direction"))
    assert search.closed == {"contact_drift", "wind_direction"}
    search.doubted += (find({"name": "contact_step", "at": "2023-09-01"}),)
    assert search.closed == {"contact_drift", "wind_direction", "contact_step"}


def test_no_other_effect_makes_a_name_nothing(under_a_sky):
    search, loop = searched(under_a_sky, "faiman", (None,) * 3, None, **USUAL)
    step = search.steps[loop.last]
    added = [f for f in loop.findings if f.added]
    sky = next(f for f in added if f.effect == "sky_radiation")
    check, why = everywhere(added, search.evidence(step), step)["sky_radiation"]
    (value,), (error,) = sky.coefficients.values(), sky.stderr.values()
    assert check.passed and 1.0 < check.statistic <= value / (1.9 * error)
    assert f"sky_radiation.share would be {why.values['value']:.2g} ±" in str(why)
    low, high = sky.ranges["sky_radiation.share"]
    value, half = (why.values[name] for name in ("value", "half"))
    rounding = 1e-12  # it may be the model that sets the range
    assert low - rounding <= value - half and value + half <= high + rounding


@pytest.mark.parametrize("seed", [1815012, 1915002])
def test_water_at_set_hours_is_no_obstacle(seed):
    """
    Both are cool in the hours of some months.

    Of the first nothing is left in hours and months that are alike; the second loses
    more than half to the timetable of the pump, and is no name by what is left of it.
    """
    site = study_worlds.site(seed)
    effects = simulator.PHYSICS | {"irrigation": 1.5}
    data = simulator.record(site, effects=effects, days=365, step=300, seed=seed)
    loop = fem.close_loop(data, **study_worlds.World(site, seed).place)
    (shade,) = (f for f in loop.findings if f.effect == "shading")
    assert shade.verdict != "named"
    if shade.added:
        assert "nothing of it is there; a look at the horizon" in shade.why
    assert any("timetable" in f.effect for f in loop.unexplained)
