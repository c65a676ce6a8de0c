"""Ranges of coefficients over the other models that a record leaves possible."""

import numpy as np
import pandas as pd
import pytest
from conftest import DRIVERS
from test_effects import coefficients

import pvlib_fem as fem
from pvlib_fem import datasets
from pvlib_fem._findings import Finding, Verdict
from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._report.formatting import range_text
from pvlib_fem._stored import Stored, as_json
from pvlib_fem._thermal.model import ThermalModel
from pvlib_fem._thermal.steady_models import STEADY_MODELS
from pvlib_fem.effects import EFFECTS, find

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
    (finding,) = (f for f in loop.finding_objects if f.effect == "sky_radiation")
    return finding, finding.ranges["sky_radiation.share"]


def test_the_range_holds_the_truth_and_more_than_the_error(loop):
    sky, (low, high) = first(loop)
    value, error = (
        part["sky_radiation.share"] for part in (sky.coefficients, sky.stderr)
    )
    assert sky.added and low < SHARE < high
    assert high - value > 1.5 * error and value - low > 1.5 * error
    assert value - low == pytest.approx(high - value)


def test_what_is_not_in_the_model_has_no_range(loop):
    assert loop.finding_objects
    for finding in loop.finding_objects:
        assert bool(finding.ranges) is finding.added
        for name, (low, high) in finding.ranges.items():
            row = loop.fit.thermal_model.parameters[name]
            assert row.lower <= low <= finding.coefficients[name] <= high <= row.upper


def test_it_is_printed_and_in_the_page_and_comes_back_from_a_file(loop, tmp_path):
    ends = first(loop)[1]
    assert f"(range {range_text(*ends)})" in " ".join(loop.report().split())
    assert range_text(*ends) in loop.to_html()
    again = fem.Loop.from_json(_written(loop, tmp_path))
    assert [f.ranges for f in again.finding_objects] == [
        f.ranges for f in loop.finding_objects
    ]
    assert str(again) == str(loop)


def _written(loop, folder):
    loop.to_json(folder / "loop.json")
    return folder / "loop.json"


@pytest.mark.parametrize("ends", [[1.0], [1.0, "x"], [1.0, None], [1.0, True], 2.0])
def test_a_range_that_is_none_is_refused(loop, ends):
    content = as_json(first(loop)[0])
    assert Stored(content, "x").whole(Finding).verdict is Verdict.IDENTIFIED
    content["ranges"]["sky_radiation.share"] = ends
    with pytest.raises(ValueError, match=r"ranges\.sky_radiation\.share"):
        Stored(content, "x").whole(Finding)


@pytest.mark.parametrize(
    ("low", "high", "words"),
    [
        (0.8489, 1.3011, "0.85 … 1.30"),
        (-0.39, 0.245, "-0.39 … 0.24"),
        (0.0, 3.5, "0.0 … 3.5"),
    ],
)
def test_ends_are_told_to_two_digits_of_half_their_distance(low, high, words):
    assert range_text(low, high) == words


def series(seed, days=12, rows=20):
    random = np.random.default_rng(seed)
    dates = np.repeat(np.arange(days), rows)
    columns = list(random.normal(size=(3, len(dates))) * [[1.0], [7.0], [0.2]])
    return columns, random.normal(size=len(dates)), dates, random


#: snow that goes at once, which in these worlds does not
SLIDES = [*(n for n in EFFECTS if n != "snow"), {"name": "snow", "sliding": 1e-6}]
