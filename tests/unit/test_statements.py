"""Statements name the device, the direction, the size, the dates and the action."""

import html
import json
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from conftest import COLUMNS
from pvlib.location import Location
from test_clock import late_by
from test_corrected import (  # noqa: F401 (fixtures)
    CASES,
    ambiguous,
    effect_of,
    faulty,
    found,
    named_one,
    sound,
    true,
)
from test_instruments import DATES

import pvlib_fem as fem
from pvlib_fem import simulator
from pvlib_fem._findings import OUTSIDE, SNOW, Finding, Kind, Member, Verdict
from pvlib_fem._statements.causes import READS, SPECIAL, clause_of, reading_of
from pvlib_fem._statements.loop_summary import LINES, WIDTH, findings
from pvlib_fem._statements.make import finding_statement, pattern_statement
from pvlib_fem._statements.statement import Statement
from pvlib_fem.effects import EFFECTS, find
from pvlib_fem.effects._time_profiles import dates_in_words
from pvlib_fem.reasons import Reason, because

DEVICES = {
    "poa_global": "irradiance sensor",
    "wind_speed": "anemometer",
    "temp_air": "air temperature sensor",
    "temp_module": "module temperature sensor",
}
LESS, MORE = ("less", "low", "loses", "little"), ("more", "high")


@pytest.mark.parametrize("name, size", CASES)
def test_each_fault_has_its_device_direction_and_size(true, sound, name, size):  # noqa: F811
    """In the table, in words, on the page and in the file."""
    effect = effect_of(name)
    data = faulty(true, effect, size)
    loop = found(sound, data, effect)
    (one,) = [s for s in loop.statements.itertuples() if s.cause == name]
    (column,) = [n for n in COLUMNS if not data[n].equals(true[n])]
    assert one.device == DEVICES[column]
    beyond = data[column] - true[column]
    if (
        effect.sensor_fault == "module_sensor_contact"
    ):  # of the over-temperature, which may be negative
        beyond *= np.sign(true[column] - true["temp_air"])
    less = beyond.sum() < 0
    assert (one.value < 0) == less
    assert any(word in one.text for word in (LESS if less else MORE))
    assert not any(f" {word}" in one.text for word in (MORE if less else LESS))
    assert one.device in one.text and one.action
    if name.endswith("_episode"):  # its last day is in the table and in words
        days = [f"{day:%Y-%m-%d}" for day in data.index[beyond.abs() > 1e-6]]
        assert [one.since, one.until] == [days[0], days[-1]]
        assert f"From {days[0]} until {days[-1]} " in one.text
    page, stored = html.unescape(loop.to_html()), json.loads(loop.to_json())
    (kept,) = [s for s in stored["statements"] if s["cause"] == name]
    assert kept["text"] == one.text and kept["value"] == pytest.approx(one.value)
    printed = " ".join(str(loop).split())
    assert one.text in page and one.text in printed
    assert one.action in page and one.action in printed


#: of a reading whose error is the same share, or the same K, at all times
STEPS = [case for case in CASES if case[0].endswith("_step") and "stall" not in case[0]]


@pytest.mark.parametrize("name, size", STEPS)
def test_the_range_of_a_step_holds_what_is_read_beyond_the_truth(
    true,  # noqa: F811
    sound,  # noqa: F811
    name,
    size,
):
    effect = effect_of(name)
    data = faulty(true, effect, size)
    (one,) = found(sound, data, effect).statements.itertuples()
    kind = effect.sensor_fault
    wanted = {
        "irradiance_sensor": 100.0 * (1.0 / (1.0 + size) - 1.0),
        "anemometer": 100.0 * (1.0 / (1.0 + size) - 1.0),
        "module_sensor_contact": 100.0 * (1.0 / (1.0 + size) - 1.0),
    }.get(kind, -size)
    assert one.unit == (
        "%"
        if kind in ("irradiance_sensor", "anemometer", "module_sensor_contact")
        else "K"
    )
    assert one.low <= wanted <= one.high
    assert one.since == DATES["step"]["at"] and one.until == ""
    assert f"From {one.since}" in one.text


def test_a_drift_has_the_slope_of_the_reading(true, sound):  # noqa: F811
    """A sensor that loses a tenth a year of what it read at first."""
    effect = effect_of("irradiance_sensor_drift")
    years = (true.index - true.index[0]).days / 365.2425
    data = true.assign(poa_global=true["poa_global"] * (1.0 - 0.1 * years))
    (one,) = found(sound, data, effect).statements.itertuples()
    assert one.unit == "%/year" and "each year since" in one.text
    assert one.value == pytest.approx(-10.0, abs=1.0)


@pytest.mark.parametrize("name", ["irradiance_sensor_drift", "mounting_drift"])
def test_a_trend_that_ends_has_the_size_that_it_reached(true, sound, name):  # noqa: F811
    """A fifth less in the end, in 77 days."""
    dates = {"start": "2023-07-20", "end": "2023-10-05"}
    effect = find({"name": name, **dates})
    data = true
    if name == "irradiance_sensor_drift":
        index = true.index.tz_localize(None) if true.index.tz else true.index
        days = (index - pd.Timestamp("2023-07-20")) / pd.Timedelta("1D")
        share = np.where((days >= 0) & (days < 77), days / 77, 0.0)
        data = true.assign(poa_global=true["poa_global"] * (1.0 - 0.2 * share))
    (one,) = found(sound, data, effect).statements.itertuples()
    assert one.unit == "%"
    assert [one.since, one.until] == ["2023-07-20", "2023-10-04"]
    assert one.text.startswith("From 2023-07-20 until 2023-10-04 ")
    assert "up to" in one.text and "increasing day by day" in one.text
    if name == "irradiance_sensor_drift":
        assert one.value == pytest.approx(-20.0, abs=2.0)
        assert one.low <= -20.0 <= one.high


@pytest.mark.parametrize(
    "end, last", [("2023-08-28", "2023-08-27"), ("2023-08-28 09:00", "2023-08-28")]
)
def test_the_days_between_which_a_fault_began_follow_its_first_day(end, last):
    dates = {"start": "2023-08-07", "between": ("2023-07-31", "2023-08-10"), "end": end}
    words = f"2023-08-07 (2023-07-31 to 2023-08-10) until {last}"
    assert dates_in_words(dates) == words


@pytest.mark.parametrize(
    "name, model, action",
    [
        ("hour", "faiman", "Record a quantity that changes between 7 and 9"),
        ("poa_stored_3h", "ross", "Measure the temperature of what stores heat"),
        ("air_stored", "faiman", "Measure the temperature of what stores heat"),
        ("hours_since_rain", "wm1", "Measure the temperature of what stays wet after"),
        ("hour", "ross", "Record wind_speed"),
    ],
)
def test_a_pattern_asks_for_what_may_explain_it(name, model, action):
    """Wind, where the model has none; no past irradiance, which one cannot look up."""
    pattern = Finding(
        *(name, (name,), Verdict.UNEXPLAINED, 0.3, {"mean": 1.0}, {}),
        because=because(Reason.UNEXPLAINED, gain=0.3, where="between 7 and 9"),
        where={name: (7.0, 9.0)},
        place="between 7 and 9",
    )
    loop = SimpleNamespace(fit=SimpleNamespace(model=model), patterns=())
    assert pattern_statement(pattern, loop).action.startswith(action)


def test_light_that_the_sensor_misses_may_be_a_reflection():
    """The catalogue has no reflection onto the modules; it looks the same."""
    on = simulator.PHYSICS | {"reflection": 1.0}
    data = simulator.record(effects=on, days=300, step=1800.0, seed=4)
    data = data[[*COLUMNS, "p_dc_per_area"]]
    site = simulator.RHINE
    where = Location(site.latitude, site.longitude, tz=site.tz)
    loop = fem.close_loop(data, location=where, surface_tilt=35, surface_azimuth=180)
    one = loop.statements.iloc[0]
    assert one["cause"] in ("shading", "sensor_covered")
    assert one["device"] == "irradiance sensor or modules"
    assert one["text"].endswith("a surface nearby reflects light onto the modules")
    assert "a reflection 4" in one["certainty"]


def test_an_ambiguous_finding_names_all_causes_and_what_would_decide(ambiguous):  # noqa: F811
    _, loop = ambiguous
    one = loop.statements.iloc[0]
    assert one["verdict"] == "ambiguous" and "Ambiguous" in one["certainty"]
    assert ", or the " in one["text"] and one["action"].startswith("To decide")
    assert set(one["alternatives"]) == {*loop.finding_objects[0].members}


def test_a_change_may_be_snow_that_has_melted(ambiguous):  # noqa: F811
    """It is no cause from the date on, and no column has to show it."""
    _, loop = ambiguous
    one = loop.finding_objects[0]
    text = finding_statement(
        replace(one, candidates=(*one.candidates, SNOW)), loop
    ).text
    assert text.endswith(", or snow or ice altered the readings while it lay")
    fitted = {**one.members, SNOW: Member({}, {}, {}, {})}
    covered = replace(one, candidates=(*one.candidates, SNOW), members=fitted)
    assert "covers the modules" in finding_statement(covered, loop).text


def test_a_hint_that_is_probably_none_of_its_causes_names_no_device(ambiguous):  # noqa: F811
    _, loop = ambiguous
    one = loop.finding_objects[0]
    named = finding_statement(replace(one, verdict=Verdict.HINT), loop)
    for outside in (0.4, 0.6):
        shares = {one.effect: 1.0 - outside, OUTSIDE: outside}
        hint = replace(one, verdict=Verdict.HINT, probabilities=shares)
        found = finding_statement(hint, loop)
        unknown = found.text.startswith("An unknown cause acts much like this one")
        assert unknown == (found.device == "unknown") == (outside > 0.5)
        assert found.text.lower().endswith(named.text.lower())


def test_a_hint_of_a_reflection_is_of_no_unknown_cause(ambiguous):  # noqa: F811
    """Of light that the sensor does not see, the reflection is the cause outside."""
    _, loop = ambiguous
    shade = replace(
        loop.finding_objects[0],
        effect="sensor_covered",
        candidates=("sensor_covered",),
        verdict=Verdict.HINT,
        probabilities={OUTSIDE: 0.6, "sensor_covered": 0.4},
        members={},
    )
    found = finding_statement(shade, loop)
    assert found.device == "irradiance sensor or modules"
    assert found.text.endswith("a surface nearby reflects light onto the modules")
    assert "unknown" not in found.text


def test_findings_are_a_table_of_the_objects(ambiguous):  # noqa: F811
    _, loop = ambiguous
    table, objects = loop.findings, loop.finding_objects
    assert [*table] == [
        *("effect", "verdict", "probability", "alternatives", "value"),
        *("standard_error", "low", "high", "unit", "from", "to", "gain"),
    ]
    assert [*table["effect"]] == [finding.effect for finding in objects]
    assert [*table["gain"]] == [finding.gain for finding in objects]
    first, (statement, *_) = table.iloc[0], loop.statements.itertuples()
    assert {*first["alternatives"]} == {*objects[0].members}
    assert first["low"] <= first["value"] == statement.value <= first["high"]
    assert f"{first['from']:%Y-%m-%d}" == statement.since and pd.isna(first["to"])
    none, kinds = replace(loop, finding_objects=()).findings, ["value", "from", "to"]
    assert none.empty and (none.dtypes[kinds] == table.dtypes[kinds]).all()


def test_a_row_by_number_says_where_the_object_is(ambiguous):  # noqa: F811
    _, loop = ambiguous
    with pytest.raises(KeyError, match=r"DataFrame.*finding_objects\[0\]"):
        loop.findings[0]
    with pytest.raises(KeyError, match=r"^'device'$"):
        loop.findings["device"]


def test_a_named_fault_says_what_agrees(named_one):  # noqa: F811
    _, loop = named_one
    one = loop.statements.iloc[0]
    assert one["device"] == "irradiance sensor" and "less" in one["text"]
    assert "power_ac agrees" in one["certainty"]
    assert "poa_global_2 agrees" in one["certainty"]
    assert one["probability"] > 0.95
    assert one["low"] <= 100.0 * (1.0 / 1.12 - 1.0) <= one["high"]


@pytest.mark.parametrize(
    "hours, way, turn", [(1, "ahead of", "back"), (-2, "behind", "forward")]
)
def test_a_clock_is_set_the_right_way(hours, way, turn):
    """Timestamps that are later than what happened run ahead."""
    data = simulator.record(days=60, step=1800.0, start="2023-05-01")
    loop = fem.close_loop(late_by(data, hours)[list(COLUMNS)], effects=[])
    one = loop.statements.iloc[0]
    assert f"run {abs(hours)} h {way} those of poa_global" in one["text"]
    assert f"{turn} by {60 * abs(hours)} min" in one["action"]
    assert one["value"] == 60.0 * hours and one["verdict"] == "corrected"
    for text in (str(loop), loop.report(), loop.to_html(), loop.to_json()):
        assert f"h {way} those of" in " ".join(text.split())


@pytest.mark.parametrize("drift, verb", [(30.0, "gains"), (-30.0, "loses")])
def test_a_drifting_clock_gains_or_loses(drift, verb):
    effects = simulator.PHYSICS | {"clock_drift": drift}
    data = simulator.record(effects=effects, days=60, step=60.0, start="2023-05-01")
    loop = fem.close_loop(data[list(COLUMNS)], effects=[])
    assert f"clock of temp_module {verb}" in loop.statements["text"].iloc[0]


@pytest.mark.parametrize("minutes, way", [(120.0, "ahead of"), (-120.0, "behind")])
def test_a_file_in_another_zone_runs_ahead_or_behind(minutes, way):
    effects = simulator.PHYSICS | {"file_shift": minutes}
    data = simulator.record(effects=effects, days=40, step=1800, start="2023-04-01")
    site = simulator.RHINE
    where = Location(site.latitude, site.longitude, tz=site.tz)
    loop = fem.close_loop(data[list(COLUMNS)], location=where, effects=[])
    one = loop.statements.iloc[0]
    assert re.search(rf"run 1(19|2[01]) min {way} the sun", one["text"])
    assert one["verdict"] == "not corrected"


@pytest.mark.parametrize("name", sorted(EFFECTS))
def test_every_effect_has_words(name):
    """Of its own title, or of its instrument's reading, in either direction."""
    effect = EFFECTS[name]
    if effect.sensor_fault:
        effect = effect_of(name)
    kind = effect.sensor_fault or effect.name
    assert kind in READS or kind in SPECIAL or effect.title
    for sign in (1, -1):
        ends = {
            key: 0.1 * (row.upper if sign > 0 else row.lower)
            for key, row in effect.rows().items()
        }
        numbers = Member({}, ends, dict.fromkeys(ends, 0.01), {})
        days = ("2023-01-01", "2024-12-31")
        clause = clause_of(effect, numbers, {"u1": 6.0}, *days)
        assert clause.device and clause.words
        assert "nan" not in clause.words and "{" not in clause.words
    # a record may not determine a coefficient
    clause = clause_of(effect, Member({}, {}, {}, {}), {"u1": 6.0}, *days)
    assert clause.device and clause.words and "{" not in clause.words


@pytest.mark.parametrize(
    ("size", "grace", "words"),
    [
        (
            0.003,
            0.0,
            "the irradiance sensor loses another 0.300 ± 0.010 % by soiling "
            "with each day since a rain of 6 mm in 24 h",
        ),
        (
            -0.003,
            14.0,
            "the modules lose another 0.300 ± 0.010 % by soiling each day, "
            "from 14 days after a rain of 6 mm in 24 h on",
        ),
    ],
)
def test_soiling_says_which_rain_cleans(size, grace, words):
    rain = {"cleaning": 6.0, "within": 24.0, "grace": grace}
    effect, key = find({"name": "soiling", **rain}), "soiling.per_day"
    numbers = Member({}, {key: size}, {key: 1e-4}, {})
    clause = clause_of(effect, numbers, {}, "2023-01-01", "2023-12-31")
    assert clause.words == words


@pytest.mark.parametrize("share", [-0.3, -0.1, 0.1, 0.5])
def test_a_trend_that_leaves_nothing_keeps_its_direction(share):
    """Eight years of -30 % a year would turn the sign of the reading."""
    value, error, low, high = reading_of(
        (share, 0.01, share - 0.02, share + 0.02), "-", 8.0
    )
    assert np.sign(value) == -np.sign(share) and error > 0.0 and low <= value <= high


def test_the_summary_is_short_and_narrow(ambiguous, named_one):  # noqa: F811
    for _, loop in (ambiguous, named_one):
        lines = str(loop).splitlines()
        assert len(lines) <= LINES and max(map(len, lines)) <= WIDTH
        assert "RMSE" in str(loop) and len(loop.report()) > len(str(loop))


@pytest.mark.parametrize(
    ("energy", "shown"),
    [(1234.0, "1200"), (123.4, "120"), (12.34, "12"), (0.123, "0.12")],
)
def test_an_energy_is_shown_with_two_digits_and_no_exponent(energy, shown):
    statement = Statement("snow", "model", "identified", "Snow", energy=energy)
    assert f"[{shown} kWh/kWp a year]" in findings([statement], 9)[0]


@pytest.mark.parametrize("room", [3, 6, 9, 12, 21])
def test_three_long_findings_are_shown_where_they_do_not_fit(room):
    """The action is omitted before the end is."""
    text, action = "The sensor reads less " * 20 + "or more", "a calibration " * 10
    one = Statement("snow", "model", "ambiguous", text, action=action)
    lines = findings([one] * 4, room)
    numbers = [line[:3] for line in lines if re.match(r" \d\. The sensor", line)]
    assert numbers == [" 1.", " 2.", " 3."]
    assert len(lines) == room + 1
    assert all(len(line) <= WIDTH for line in lines)
    assert lines[-1].strip() == "1 more is in loop.statements."
    assert any(line.endswith(" ...") for line in lines) is (room < 15)
    assert ("a calibration" in "".join(lines)) is (room == 21)


def test_a_long_list_is_cut_with_the_number_of_the_rest(ambiguous):  # noqa: F811
    _, loop = ambiguous
    many = replace(loop, finding_objects=loop.finding_objects[:1] * 20)
    lines = str(many).splitlines()
    assert len(lines) <= LINES
    shown = sum(bool(re.match(r" *\d+\. ", line)) for line in lines)
    rest = int(
        next(line for line in lines if "more are in loop.statements" in line).split()[0]
    )
    assert shown + rest == len(many.statements)


@pytest.mark.parametrize("kind", [Kind.COLUMN, Kind.OWN])
def test_a_hint_of_an_effect_that_no_registry_knows_has_a_statement(ambiguous, kind):  # noqa: F811
    """A column of the user's own that was seen and not added."""
    _, loop = ambiguous
    hint = replace(
        loop.finding_objects[0],
        effect="driver:fan",
        candidates=("driver:fan", "rain"),
        verdict=Verdict.HINT,
        kind=kind,
        members={},
    )
    seen = replace(loop, finding_objects=(hint,))
    (one,) = (s for s in seen.statements.itertuples() if s.cause == "driver:fan")
    assert "driver:fan" in one.text and "evaporating rain" in one.text
    assert one.verdict == "hint" and one.alternatives == ("rain",)
    assert "driver:fan" in str(seen) and "driver:fan" in seen.to_html()
