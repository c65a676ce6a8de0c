"""What pages state of coefficients and thresholds is what the code has."""

import re
from dataclasses import fields
from pathlib import Path

import pytest

import pvlib_fem as fem
from pvlib_fem.effects import find

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
NUMBER = r"-?\d+(?:\.\d+)?"
RANGE = re.compile(
    rf"({NUMBER}) ± ({NUMBER})(?: [^\s±…]+){{0,3}}? \(range ({NUMBER}) … ({NUMBER})\)"
)
STEP = re.compile(
    rf"\+ (\w+)(?: {NUMBER}){{5}} % (?:identified|ambiguous) ({RANGE.pattern})"
)
ROW = re.compile(
    rf"^\| `(\w+)\.(\w+)` \| ({NUMBER}) ± {NUMBER} \| ({NUMBER}) – ({NUMBER}) \|", re.M
)
BLOCK = re.compile(r"^```.*?^```$", re.M | re.S)


def joined(text):
    """Text with each run of white space as one blank."""
    return " ".join(text.split())


def text_of(page):
    return page.read_text("utf-8")


def test_a_range_in_prose_is_that_of_a_tested_block():
    """The README and a page gave one coefficient two different ranges once."""
    shown = joined(" ".join(b for p in PAGES for b in BLOCK.findall(text_of(p))))
    stated = [match[0] for page in PAGES for match in RANGE.finditer(prose_of(page))]
    assert stated
    assert [range_ for range_ in stated if range_ not in shown] == []


def prose_of(page):
    return joined(BLOCK.sub(" ", text_of(page)))


def test_a_range_holds_its_value_in_order():
    found = [m for page in PAGES for m in RANGE.finditer(joined(text_of(page)))]
    assert found
    for match in found:
        value, error, low, high = map(float, match.groups())
        assert error > 0 and low <= value <= high, match[0]


@pytest.mark.parametrize("page", [p for p in PAGES if ROW.search(text_of(p))])
def test_coefficients_of_pages_are_possible(page):
    """Within the bounds of the catalogue."""
    for name, parameter, *numbers in ROW.findall(text_of(page)):
        value, low, high = map(float, numbers)
        bounds = find(name).parameters[parameter]
        assert bounds.lower <= low <= value <= high <= bounds.upper, (name, parameter)


def test_coefficients_of_printed_steps_are_possible():
    steps = [s for page in PAGES for s in STEP.finditer(joined(text_of(page)))]
    assert steps
    for step in steps:
        (bounds,) = find(step[1]).parameters.values()
        value, _, low, high = map(float, step.groups()[2:])
        assert bounds.lower <= low <= value <= high <= bounds.upper, step[0]


def test_pages_state_the_thresholds_of_the_code():
    criteria, page = fem.Criteria(), prose_of(ROOT / "docs" / "guide" / "honesty.md")
    gain, share = (
        f"`min_rmse_reduction`, {criteria.min_rmse_reduction:g} K",
        100 * criteria.min_error_share,
    )
    assert f"{gain}, and {share:g} % of the mean square (`min_error_share`)" in page
    assert f"a probability of at least {100 * criteria.min_probability:.0f} %" in page
    assert f"Below {criteria.min_days} days nothing is named" in page
    assert f"a probability of {100 * criteria.outside_probability:.0f} %" in page
    number = len(fields(criteria)) - 1  # limits are Limits
    assert f"all {number} thresholds" in joined(text_of(ROOT / "CHANGELOG.md"))
