"""A small part of the study, on every run of the tests; docs/study.md has it all."""

from collections import Counter

import pytest
import study_worlds
from study import (
    BARS,
    CLEARLY,
    ENOUGH_DAYS,
    FAMILIES,
    LOGGERS,
    QUICK,
    RISE,
    clear,
    found_before,
    hardly_worse,
    listed,
    page,
    run,
    worlds,
)
from study_worlds import CLOSED_CAUSES, GATE_SHIFTS, TRUTHS, UNKNOWN, WHOLE

from pvlib_fem.effects import EFFECTS
from pvlib_fem.simulator import SWITCHES


@pytest.fixture(scope="module")
def table():
    return run(quick=True)


def of(table, family):
    rows = table[table["family"] == family]
    assert len(rows), family
    return rows


def test_every_switch_is_one_and_leads_to_the_catalogue():
    assert {*TRUTHS, *UNKNOWN} <= {*SWITCHES}
    assert {truth.effect for truth in TRUTHS.values()} - {*EFFECTS} == {"clock_shift"}
    assert {*QUICK} == {*FAMILIES}


def test_closed_causes_are_in_the_gates_worlds_alone(monkeypatch):
    def families(shift):
        monkeypatch.setattr(study_worlds, "SHIFT", shift)
        return Counter(cases[0].family for _, cases in worlds(every=3))

    assert CLOSED_CAUSES not in families(0)
    for shift in GATE_SHIFTS:
        counts = families(shift)
        assert all(len(GATE_SHIFTS) * counts[name] >= 100 for name in WHOLE)


def test_every_unknown_cause_has_worlds_of_both_generators(monkeypatch):
    monkeypatch.setattr(study_worlds, "SHIFT", GATE_SHIFTS[0])
    some = [(w, *cases[0].sizes) for w, cases in worlds(WHOLE)]
    counts = Counter((switch, world.generator) for world, switch in some)
    for switch in UNKNOWN:
        assert counts[switch, "fuentes"] >= 1
        assert counts[switch, "nodes"] + counts[switch, "fuentes"] >= 4


def test_no_record_breaks_or_is_refused_for_nothing(table):
    assert table["broken"].isna().all(), table["broken"].dropna().tolist()
    assert of(table, LOGGERS)["refused"].notna().any()
    sound = table[table["family"] != LOGGERS]
    assert sound["refused"].isna().all(), sound["refused"].dropna().tolist()


def test_nothing_is_named_that_is_not_there(table):
    known = table[table["family"] != LOGGERS]
    wrong = [len(listed(names)) > 0 for names in known["named_wrong"]]
    assert not known[wrong]["findings"].tolist()


def test_a_clear_effect_comes_first(table):
    one = of(table, "one effect")
    large = one[[clear(row) for _, row in one.iterrows()]]
    assert len(large) >= len(one) / 2, f"{CLEARLY:g} times the smallest, by choice"
    missed = large[~large["first_ok"].astype(bool)]
    assert not missed[["truth", "findings"]].to_numpy().tolist()


def test_several_are_found_together(table):
    for _, row in of(table, "pairs and triples").iterrows():
        assert {*row["truths"]} <= {*row["found"]}, row["findings"]


def test_heat_of_no_known_cause_is_said_to_be_there(table):
    for _, row in of(table, "no catalogue").iterrows():
        assert row["unexplained_ok"], (row["truth"], row["findings"])


def test_the_driver_of_such_heat_is_found_when_it_is_a_column(table):
    for _, row in of(table, "its driver as a column").iterrows():
        assert "driver:neighbour" in listed(row["found"]), row["findings"]


def test_an_effect_without_its_driver_is_said_to_be_untestable(table):
    for _, row in of(table, "driver missing").iterrows():
        assert row["mentioned"], (row["truth"], row["untestable"], row["findings"])


def test_a_fault_of_clock_or_unit_is_found_first(table):
    for _, row in of(table, LOGGERS).iterrows():
        assert found_before(row), (row["truth"], row["notes"], row["findings"])


def test_a_short_record_is_never_better_than_suggestive(table):
    short = of(table, "short records")
    short = short[short["days"] < ENOUGH_DAYS]
    assert len(short) >= 2
    for verdicts in short["verdicts"]:
        assert not {"identified", "ambiguous"} & {*verdicts}


def test_the_error_of_test_weeks_hardly_ever_rises(table):
    """A measurement: nothing was chosen by them."""
    done = table[table["after"].notna()]
    assert len(done)
    for _, row in done.iterrows():
        assert hardly_worse(row), (row["truth"], row["before"], row["after"])


def test_a_refit_with_the_truth_has_the_base_of_the_loop(table):
    """Without a part of it, its error is above that of the base alone."""
    done = table[table["oracle"].notna()]
    worse = done[done["oracle"] > done["before"] + RISE]
    assert len(done) and not worse[["truth", "before", "oracle"]].to_numpy().tolist()


def test_the_page_has_every_family_and_a_verdict(table):
    text = "\n".join(page(table, 60.0))
    for family in FAMILIES:
        assert f"| {family} | " in text
    assert {bar.family for bar in BARS} == {*FAMILIES, "all"}
