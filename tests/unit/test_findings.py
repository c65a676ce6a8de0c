"""What the loop can say: checks that decide, and reasons that become words once."""

import ast
import re
from pathlib import Path
from string import Formatter
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, strategies as st

import pvlib_fem
from pvlib_fem import Criteria
from pvlib_fem._findings import (
    Check,
    CheckOutcome,
    Correction,
    CrossCheck,
    Finding,
    Verdict,
)
from pvlib_fem._loop.results.conclude import member_of, why_not_in_model
from pvlib_fem._loop.selection.choice import Choice
from pvlib_fem._stored import as_json
from pvlib_fem.effects import find
from pvlib_fem.reasons import Because, Reason, because, in_percent, joined_reasons

PACKAGE = Path(pvlib_fem.__file__).parent


@pytest.mark.parametrize(
    ("statistic", "most", "passed"),
    [
        (0.2, False, True),
        (0.15, False, True),
        (0.1, False, False),
        (0.2, True, False),
        (0.15, True, True),
        (np.nan, False, False),
        (np.nan, True, True),  # where nothing can be measured nothing contradicts
    ],
)
def test_a_check_passes_at_its_threshold(statistic, most, passed):
    check = Check("gain", "min_rmse_reduction", statistic, 0.15, most, "K")
    assert check.passed is passed
    assert ("FAILED" in str(check)) is not passed
    assert "min_rmse_reduction" in str(check) and "0.15 K" in str(check)


def test_the_first_failure_is_the_rule_that_decided():
    checks = tuple(Check(n, n, s, 1.0) for n, s in (("a", 2.0), ("b", 0.5), ("c", 0.1)))
    why = because(Reason.NOT_MATERIAL, least=1.0)
    finding = Finding("x", ("x",), Verdict.HINT, 0.5, {}, {}, why, checks)
    assert finding.failed.name == "b" and not finding.added
    assert [line.split()[0] for line in str(finding).splitlines()[2:]] == [
        "passed",
        "FAILED",
        "FAILED",
    ]
    content = as_json(finding)
    assert [check["passed"] for check in content["checks"]] == [True, False, False]
    assert content["because"] == [
        {"reason": "NOT_MATERIAL", "least": 1.0, "words": finding.why}
    ]


@pytest.mark.parametrize(
    ("gain", "chance", "fitted", "name", "words"),
    [
        (0.13, 0.99, 0.14, "NOT_MATERIAL", "below the 0.15 K that are material"),
        (0.20, 0.949, 0.19, "NOT_SURE", "such an effect is 94.9 %; 95 % is required"),
        (0.155, 0.985, 0.135, "NOT_MATERIAL_FITTED", "are fitted (0.135 K)"),
    ],
)
def test_a_hint_says_what_it_lacks(gain, chance, fitted, name, words):
    """A probability that suffices is no reason against it."""
    score = SimpleNamespace(fall=gain**2, probability=chance)
    check, why = why_not_in_model(score, fitted, 0.15**2, Criteria())
    assert why.reason.name == name and str(why).endswith(words)
    assert not check.passed


def test_what_passes_every_check_is_in_the_model():
    score = SimpleNamespace(fall=0.2**2, probability=0.985)
    assert why_not_in_model(score, 0.19, 0.15**2, Criteria()) is None


def test_names_are_joined_as_their_sentence_has_it():
    some = because(Reason.WOULD_DECIDE, measurements=["a look", "a camera"])
    assert str(some) == "a look; or a camera would decide"
    lacks = because(Reason.LACKS, columns=["precipitation", "snow_depth"])
    assert str(lacks) == "no precipitation, snow_depth"
    both = joined_reasons([because(Reason.EMPTY, column="x"), lacks])
    assert str(both) == "x holds no value; no precipitation, snow_depth"
    assert [one.reason for one in both.all] == [Reason.EMPTY, Reason.LACKS]


def test_a_correction_says_error_before_and_after():
    why = because(Reason.CORRECTED, fault="the clock is 10 min late")
    clock = Correction(
        "clock_shift", ("temp_module",), {"late": 10.0}, {}, 2.0, 1.0, "K", why
    )
    assert str(clock).splitlines() == [
        "clock_shift: corrected, 2.00 → 1.00 K",
        "  the clock is 10 min late",
    ]


def reasons_given():
    """Every reason that the package gives, with the names of its values."""
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "because":
                (reason,) = node.args
                if is_reason(reason):
                    yield reason.attr, {word.arg for word in node.keywords}
            # those of an effect whose search finds nothing have no numbers
            name = getattr(node, "arg", getattr(getattr(node, "target", 0), "id", ""))
            if name == "not_found" and is_reason(node.value):
                yield node.value.attr, set()


def is_reason(node):
    owner = getattr(node, "value", None)
    return isinstance(node, ast.Attribute) and getattr(owner, "id", "") == "Reason"


def test_every_reason_is_given_with_the_numbers_of_its_sentence():
    given = list(reasons_given())
    assert {name for name, _ in given} == {reason.name for reason in Reason}
    for name, values in given:
        fields = {field for _, field, _, _ in Formatter().parse(Reason[name].value)}
        assert values == fields - {None}, name


def test_no_code_takes_a_sentence_apart():
    """Reasons are read by their type; words are for people."""
    parsing = re.compile(
        r"(why|because|note|words|sentence\(\))\)?\.(split|partition|r?partition|startswith)"
        r"|(startswith|removeprefix)\(\"driver:"
        r"|\" in (finding|f|hint)\.why"
    )
    paths = [*PACKAGE.rglob("*.py")]
    assert paths
    for path in paths:
        for line in path.read_text(encoding="utf-8").splitlines():
            # the first line of a docstring is a heading, and no reason
            assert not parsing.search(line) or "words.strip()" in line, (path, line)


def test_a_candidate_has_the_coefficients_that_the_record_determines():
    """One hour of snow determines one of its effect's coefficients."""
    effect = find("wind_direction")
    key = "wind_direction.north"
    score = SimpleNamespace(
        keys=(key,), coefficients={key: -1.0}, errors={key: 0.1}, seen=np.array([-1.1])
    )
    candidate = SimpleNamespace(effect=effect)
    choice = Choice(candidate, score, {effect.name: candidate}, {effect.name: score})
    member = member_of(choice, effect.name, Criteria())
    assert member.coefficients == {key: -1.0} and member.stderr == {key: 0.1}
    low, high = member.ranges[key]
    assert low < -1.1 and high > -0.9


@given(st.floats(0.0, 1.0))
def test_a_probability_is_written_neither_as_0_nor_as_100_percent(probability):
    text = in_percent(probability)
    assert text not in ("0 %", "100 %")
    sign, number = text.removesuffix(" %").rpartition(" ")[::2]
    stated = float(number) / 100.0
    if sign:
        assert probability < stated if sign == "<" else probability > stated
    else:
        assert abs(probability - stated) <= 0.005 + 1e-12


def test_a_reason_has_a_space_before_the_sign_of_percent():
    reason = because(Reason.MISSING, share=0.25, column="wind_speed")
    assert str(reason) == "25 % of wind_speed is missing"


@pytest.mark.parametrize("factor", [0.4, 0.9, 1.25])
@pytest.mark.parametrize("drift", [False, True])
def test_a_cross_check_says_what_the_sensor_reads_and_not_the_logarithm(factor, drift):
    """An anemometer at 0.4 of its speed reads 60 % less, by one that is right."""
    size = float(np.log(1.0 / factor))  # of the column over the sensor
    unit = "-/year" if drift else "-"
    how = ("wind_speed_2", "anemometer_step", size, 0.01, size)
    check = CrossCheck(*how, CheckOutcome.AGREES, unit)
    way = "more" if factor > 1.0 else "less"
    size = abs(100.0 * (factor - 1.0))
    year = " a year" if drift else ""
    assert check.reads == f"{size:.1f} ± {factor:.1f} % {way}{year}"
    assert str(check).endswith(f"{size:.1f} % {way}{year} is expected")


def test_a_cross_check_in_kelvin_has_the_sign_of_the_sensor():
    """A second sensor that reads 1.5 K below the first: the first reads more."""
    how = ("temp_module_2", "module_offset_step", -1.5, 0.2, -1.4)
    check = CrossCheck(*how, CheckOutcome.AGREES, "K")
    assert check.reads == "1.50 ± 0.20 K more"
    assert str(check).endswith("1.40 K more is expected")


def test_a_reason_never_states_a_probability_of_100_percent():
    why = because(Reason.OUTSIDE, chance=0.9974)
    assert str(why).endswith("is more probable (> 99 %)")
    assert str(Because.stored(why.content())) == str(why)
    assert "is 94.9 %; 95 %" in str(because(Reason.NOT_SURE, chance=0.949, least=0.95))
