"""The gate's rows of records by hand."""

import numpy as np
import pandas as pd
import pytest
from study_gate import FEWEST, against, apart, by_cause, gates, held, page
from study_worlds import CLOSED, CLOSED_CAUSES, UNDECLARED

from pvlib_fem._findings import OUTSIDE


def record(family="one effect", seed=1, sets=(), sizes=(), truths=(), **more):
    """A row of the study."""
    found = [
        dict(effect=effect, verdict=verdict, shares=shares)
        for effect, verdict, shares in sets
    ]
    row = dict(family=family, seed=seed, truth=" ".join(sizes), truths=truths)
    row |= dict(sizes=dict.fromkeys(sizes, 1.0), sets=found, generator="nodes")
    row |= dict(shift=0, named_wrong=(), told={}, first_ok=False)
    return row | dict(before=1.0, after=0.5, seconds=2.0) | more


def change(seed, **more):
    """A row of instruments."""
    row = dict(seed=seed, sets=[], truths=(), clear=True, found=True, dates=None)
    return row | dict(told={}, before=1.0, after=0.5) | more


def measured(rows, words):
    (row,) = [row for row in rows if row[0].startswith(words)]
    return row[2], row[3]


SNOW = ("snow", "identified", {"snow": 0.97, OUTSIDE: 0.03})
UNSURE = ("snow", "ambiguous", {"snow": 0.6, OUTSIDE: 0.4})


def test_a_set_has_the_least_causes_that_have_it_together():
    assert held({"snow": 0.3, "rain": 0.6, "season": 0.1}, 0.85) == {"snow", "rain"}
    assert held({"snow": 0.97, OUTSIDE: 0.03}) == {"snow"}


@pytest.mark.parametrize("kind", [*UNDECLARED, *CLOSED])
def test_a_set_with_the_outside_is_right_where_the_cause_is_unknown(kind):
    unknown = dict(sets=[UNSURE], sizes=(kind,))
    some = [record(**unknown), record(sets=[UNSURE]), record(sets=[UNSURE])]
    assert measured(gates(pd.DataFrame(some), []), "sets without") == (
        "2 of 3 (66.7%)",
        False,
    )


def test_each_cause_has_how_often_it_is_right():
    """A cause that is stated a few times has no row."""
    false = [record(sets=[UNSURE], seed=i) for i in range(FEWEST)]
    true = [record(sets=[UNSURE], truths=("snow",), seed=9)]
    rows = [*by_cause(pd.DataFrame([*false, *true]), [])]
    assert rows == [("`snow`", FEWEST + 1, "0.60", f"{1 / (FEWEST + 1):.2f}")]
    assert not [*by_cause(pd.DataFrame(true), [])]


def test_the_layer_below_the_ground_is_a_cause_of_its_own():
    """The simulator's ground that stores heat lies on one that follows the air."""
    deep = ("ground_or_water", "ambiguous", {"ground_or_water": 0.93, OUTSIDE: 0.07})
    there = dict(sizes=("thermal_storage",), truths=("thermal_storage",))
    some = [record(sets=[deep], **there), record(sets=[deep])]
    changes = [change(1, sets=[dict(zip(("effect", "verdict", "shares"), deep))])]
    rows = gates(pd.DataFrame(some), changes)
    assert measured(rows, "sets without") == ("1 of 3 (33.3%)", False)


def test_a_name_is_wrong_unless_its_cause_is_there():
    some = [
        record(sets=[SNOW], sizes=("snow",), truths=("snow",)),
        record(sets=[SNOW, SNOW]),
        record(sets=[("season", "identified", {"season": 1.0})]),  # physics has it
        record(
            sets=[("season", "identified", {"season": 1.0})], generator="fitted form"
        ),
        record() | {"sets": np.nan},  # broken
    ]
    words = "records with a wrong name"
    assert measured(gates(pd.DataFrame(some), []), words) == ("2 of 4 (50.0%)", False)


def test_open_and_closed_kinds_are_counted_apart():
    some = [record("no catalogue", sizes=("fan",)) for _ in range(49)]
    some += [record("no catalogue", sizes=("fan",), named_wrong=("snow",))]
    some += [record(CLOSED_CAUSES, sizes=("fog",), named_wrong=("rain",))]
    rows = [*gates(pd.DataFrame(some), [])]
    assert measured(rows, "unknown causes (open") == ("1 of 50 (2.0%)", True)
    assert measured(rows, "unknown causes (closed") == ("1 of 1 (100.0%)", False)


def test_a_stated_probability_is_held_against_what_is_there():
    sets = [("snow", "ambiguous", {"snow": 0.9, OUTSIDE: 0.1})]
    some = [record(sets=sets, sizes=("snow",), truths=("snow",)) for _ in range(9)]
    some += [record(sets=sets, sizes=("fan",))]
    words, met = measured(gates(pd.DataFrame(some), []), "causes stated at 0.80")
    assert met
    assert "0.90 of 10 are right, stated 0.90; 0.90 of 10, stated 0.90, are" in words
    assert words.endswith("1 are of records with an unknown cause")


def test_causes_in_sets_with_one_true_cause_are_counted_apart():
    """Two true causes that look alike have a part of one probability each."""
    shares = {"snow": 0.55, "season": 0.38, OUTSIDE: 0.07}
    there = dict(sizes=("snow",), truths=("snow",))  # physics has a season
    some = [record(sets=[("snow", "ambiguous", shares)], **there)]
    words, met = measured(gates(pd.DataFrame(some), []), "causes stated at 0.50")
    assert not met
    assert "1.00 of 1 are right, stated 0.55; none is in sets with one" in words


def test_blocks_and_generators_have_rows_of_their_own():
    some = [record(shift=7, sets=[SNOW]), record(shift=9, generator="fuentes")]
    rows = [*apart(pd.DataFrame(some), [change(1)])]
    assert [row[:2] for row in rows] == [
        ("instruments", 1),
        ("shift 7", 1),
        ("shift 9", 1),
        ("by fuentes", 1),
        ("by nodes", 2),
    ]
    assert rows[1][2:] == ("1 of 1 (100.0%)", "1 of 1 (100.0%)")


def test_records_are_paired_with_those_of_the_rules():
    ours = pd.DataFrame(
        [
            record(seed=1, sizes=("snow",), first_ok=True),
            record(seed=2, sizes=("snow",), after=0.7),
            record(seed=3, sizes=("rain",), first_ok=True),  # the rules have none
            record("exact null", seed=4, after=0.1),
            record("exact null", seed=4, after=0.2),
        ]
    )
    rules = ours.drop(index=2).assign(first_ok=True, after=0.4)
    rules.loc[[3, 4], "first_ok"] = False
    old = [change(1), change(2, found=False), change(9)]
    new = [change(1, found=False, after=0.2), change(2)]
    rows = [*against(ours, new, rules, old)]
    assert measured(rows, "first findings") == ("1 of 2 (50.0%)", False)
    assert measured(rows, "changes of instruments")[0].startswith("0 of 1")
    study, instruments = (
        measured(rows, f"median error on test weeks of {name}")
        for name in ("the study", "instruments")
    )
    assert study == ("0.350 K, by the rules 0.400 K", True)
    assert instruments == ("0.350 K, by the rules 0.500 K", True)


def test_the_page_has_a_row_for_each_gate():
    table = pd.DataFrame([record(sets=[SNOW], sizes=("snow",), truths=("snow",))])
    some = table, [change(1)]
    text = "\n".join(page(*some, oracle=some))
    rows = [*gates(*some), *against(*some, *some)]
    assert rows
    for row in rows:
        assert f"| {row[0]} | {row[1]} | {row[2]} |" in text
    assert "*The rules* decided before" in text
