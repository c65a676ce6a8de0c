"""A tracker whose modules are stuck while the irradiance sensor moves."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pandas as pd
import pvlib
import pytest
from conftest import COLUMNS
from pvlib.location import Location

import pvlib_fem as fem
from pvlib_fem import simulator
from pvlib_fem._findings import CheckOutcome
from pvlib_fem._loop.regression import scans
from pvlib_fem._loop.search import Search
from pvlib_fem._record.inputs import read
from pvlib_fem.drivers import derive_drivers, geometry
from pvlib_fem.drivers._solar import on_plane
from pvlib_fem.effects import find
from pvlib_fem.effects._standstill import Axis, find_standstill, rotations
from pvlib_fem.effects._standstill_days import Days, sum_inflation
from pvlib_fem.effects._time_profiles import dates_in_words, day_number
from pvlib_fem.quality._plane import Sky
from pvlib_fem.quality._tracker_standstill import nearest_by_day, standing_of
from pvlib_fem.reasons import Reason
from pvlib_fem.simulator import PHYSICS, RHINE, Stuck, Tracker

WHERE = Location(RHINE.latitude, RHINE.longitude, tz=RHINE.tz)
USUAL = [*COLUMNS, "surface_tilt", "surface_azimuth"]
ANGLES = ("zenith", "azimuth")
STUCK = {"tracker_stuck": 1.0}


def tracking(stuck, *effects, seed=3, **changes):
    """A year of a tracker that is stuck, and what is switched on."""
    site = replace(RHINE, tracker=Tracker(stuck=stuck), **changes)
    on = PHYSICS | dict.fromkeys(effects, 1.0)
    return simulator.record(site, on, days=365, step=900.0, seed=seed)


@pytest.fixture(scope="module")
def sound():
    return tracking(Stuck())


@pytest.fixture(scope="module")
def loop_of_sound(sound):
    return fem.close_loop(sound[USUAL], location=WHERE)


# ------------------------------------------------------------------ the planes
@pytest.mark.parametrize("axis_tilt, axis_azimuth", [(0.0, 180.0), (20.0, 150.0)])
def test_planes_are_those_that_the_tracker_can_have(axis_tilt, axis_azimuth):
    turns = np.linspace(-55.0, 55.0, 500)
    own = pvlib.tracking.calc_surface_orientation(turns, axis_tilt, axis_azimuth)
    axis, angles = rotations(own["surface_tilt"], own["surface_azimuth"])
    assert np.ptp(angles) == pytest.approx(110.0, abs=1e-6)
    assert np.abs(np.diff(angles)).max() <= 10.0
    tilt, azimuth = axis.planes(angles).T
    way = np.sign(angles[0] * turns[0])
    there = pvlib.tracking.calc_surface_orientation(
        way * angles, axis_tilt, axis_azimuth
    )
    np.testing.assert_allclose(tilt, there["surface_tilt"], atol=1e-6)
    apart = (azimuth - there["surface_azimuth"] + 180.0) % 360.0 - 180.0
    assert np.abs(apart[tilt > 1.0]).max() < 1e-6


@pytest.mark.parametrize(
    "tilt, azimuth, words",
    [
        (np.full(50, 35.0), np.full(50, 180.0), "fixed"),
        (np.tile([10.0, 60.0, 60.0], 20), np.tile([180.0, 90.0, 210.0], 20), "axis"),
    ],
)
def test_what_does_not_turn_about_one_axis_is_refused(tilt, azimuth, words):
    with pytest.raises(ValueError, match=words):
        rotations(tilt, azimuth)


def test_light_on_the_described_plane_is_what_was_measured(sound):
    """And on another plane it is what the simulator has there."""
    days = sound["2023-06-01":"2023-06-20"]
    inputs = read({"poa_global": days["poa_global"]})
    place = geometry(days.index, WHERE, 35.0, 180.0)
    place |= {name: days[name] for name in USUAL[-2:]}
    inputs = inputs.having({name: c.to_numpy() for name, c in place.items()})
    inputs = derive_drivers(inputs, ["clearness"])
    sky = [inputs[n] for n in ("clearness", "solar_zenith", "solar_azimuth")]
    same = on_plane(*sky, inputs["surface_tilt"], inputs["surface_azimuth"])
    clear = inputs["clearness"] < 0.99  # more light than any sky has
    np.testing.assert_allclose(same[clear], inputs["poa_global"][clear], atol=1.0)
    stands = tracking(Stuck("2023-06-01", "2023-06-21", 40.0), "tracker_stuck_sensor")
    stands = stands.loc[days.index, "poa_global"]
    west = on_plane(*sky, 40.0, 270.0)
    assert np.corrcoef(west, stands)[0, 1] > 0.98
    assert west.sum() == pytest.approx(stands.sum(), rel=0.03)


# ------------------------------------------------------------------ the effect
def test_its_heat_is_the_light_that_is_missing_on_its_days(sound):
    effect = find(
        {
            "name": "tracker_stuck",
            "start": "2023-07-03",
            "end": "2023-07-05",
            "surface_tilt": 35.0,
            "surface_azimuth": 90.0,
        }
    )
    days = np.repeat(day_number("2023-07-02") + np.arange(4.0), 2) + 0.5
    sky = np.full(8, 0.7), np.full(8, 40.0), np.tile([100.0, 260.0], 4)
    heat = effect.terms(np.full(8, 800.0), *sky, days, share=1.0).heat
    there = np.repeat([False, True, True, False], 2)
    assert (heat[~there] == 0.0).all()
    morning, afternoon = heat[there].reshape(2, 2).T
    # the sun is before the plane, and 69° from its normal
    assert (morning > 50.0).all() and (afternoon < -300.0).all()
    with pytest.raises(ValueError, match="is not before"):
        find({"name": "tracker_stuck", "start": "2023-07-05", "end": "2023-07-03"})


@pytest.mark.parametrize("days", [1, 2, 3])
def test_two_days_have_to_show_a_standstill(days):
    """Not one, and a dull one next to it that shows nothing."""
    day = np.repeat(np.arange(200), 24)
    random = np.random.default_rng(4)
    tangent = random.uniform(2.0, 4.0, len(day))
    tangent[(day == 100 + days) | (day == 99)] = 0.0
    there = (day >= 100) & (day < 100 + days)
    rest = random.normal(0.0, 0.5, len(day)) + there * tangent
    basis = np.full((len(day), 1), len(day) ** -0.5)
    even = random.uniform(2.0, 4.0, len(day))
    planes = [tangent], even, np.array([30.0])
    found = find_standstill(rest, *planes, basis, day, 0.05)
    if days < 2:
        assert found is None
    else:
        assert found[:3] == (30.0, 100, 100 + days)


def lost_light():
    """Responses to a row that stands to the west, and to light that is lost evenly."""
    random, day = np.random.default_rng(6), np.repeat(np.arange(200), 24)
    hour = np.tile(np.arange(24), 200)
    bright = np.maximum(np.sin((hour - 6) * np.pi / 12), 0.0)
    even = -6.0 * bright * np.repeat(random.uniform(0.5, 1.0, 200), 24)
    stands = even * np.clip((15 - hour) / 8, 0.0, 1.0)
    return day, hour, stands, even, random.normal(0.0, 0.5, len(day))


def found_in(rest, stands, even, time):
    basis = np.full((len(time), 1), len(time) ** -0.5)
    return find_standstill(rest, [stands], even, np.array([30.0]), basis, time, 0.05)


@pytest.mark.parametrize("days", [2, 9])
@pytest.mark.parametrize("slides", [11, 13, 24])
def test_light_that_a_cover_takes_is_no_standstill(slides, days):
    """Until it slides off snow looks like a row that stands to the west."""
    day, hour, stands, even, noise = lost_light()
    snow = (day >= 100) & (day < 100 + days) & (hour < slides)
    assert found_in(noise + snow * even, stands, even, day + hour / 24) is None
    still = (day >= 40) & (day < 46)
    rest = noise + 0.5 * snow * even + still * stands
    assert found_in(rest, stands, even, day + hour / 24)[:3] == (30.0, 40, 46)


CASES = [(-35.0, "2023-06-12", "2023-06-26"), (20.0, "2023-04-17", "2023-05-15")]


@pytest.mark.parametrize("angle, start, end", CASES)
def test_a_row_that_stands_still_is_found(angle, start, end, tmp_path):
    data = tracking(Stuck(start, end, angle), "tracker_stuck")
    loop = fem.close_loop(data[USUAL], location=WHERE)
    (effect,) = (e for e in loop.fit.effects if e.name == "tracker_stuck")
    dates = effect.settings
    low, high = map(day_number, dates["between"])
    assert low <= day_number(start) <= high
    # all fitting days but those of less than half the light, and no others
    found, true = (
        np.arange(day_number(ends["start"]), day_number(ends["end"]))
        for ends in (dates, dict(start=start, end=end))
    )
    weeks = loop.weeks.tz_localize(None)
    fitting = set(weeks.index[weeks == "fitting"].normalize().map(day_number))
    assert {*found} & fitting <= {*true}
    light = data["poa_global"].tz_localize(None).resample("D").sum()
    light.index = light.index.map(day_number)
    for day in {*true} & fitting - {*found}:
        assert light[day] < 0.5 * light[[*true]].median()
    side = 90.0 if angle < 0 else 270.0
    assert dates["surface_tilt"] == pytest.approx(abs(angle), abs=6.0)
    assert dates["surface_azimuth"] == pytest.approx(side, abs=2.0)
    assert loop.fit.coefficients["tracker_stuck.share"] == pytest.approx(1.0, abs=0.2)
    (finding,) = (f for f in loop.finding_objects if f.effect == "tracker_stuck")
    low, high = finding.ranges["tracker_stuck.share"]
    assert low < 1.0 < high and high - low < 0.6
    assert loop.table["rmse_train"].iloc[-1] < 0.7 * loop.table["rmse_train"][loop.base]
    assert loop.table["rmse_test"].iloc[-1] < loop.table["rmse_test"][loop.base]
    statement = loop.statements.iloc[0]
    way = "east" if angle < 0 else "west"
    assert "were stuck at about" in statement["text"] and way in statement["text"]
    text = statement["text"]
    assert dates["start"] in text and f"until {statement['until']} " in text
    assert day_number(statement["until"]) == day_number(dates["end"]) - 1
    assert (statement["since"], statement["device"]) == (dates["start"], "tracker")
    assert "drive of the tracker" in statement["action"] or "To decide" in str(
        statement
    )
    loop.to_json(tmp_path / "loop.json")
    again = fem.Loop.from_json(tmp_path / "loop.json")
    assert again.statements["text"].iloc[0] == statement["text"]


def test_the_days_between_which_it_ended_follow_its_last_day():
    """``end`` and its interval are the first day after it, the words the last one."""
    dates = {"start": "2022-05-01", "end": "2022-05-16"}
    dates["between"] = ["2022-04-29", "2022-05-02"]
    dates["ended"] = ["2022-05-15", "2022-05-20"]
    words = "2022-05-01 (2022-04-29 to 2022-05-02) until 2022-05-15 "
    assert dates_in_words(dates) == words + "(2022-05-14 to 2022-05-19)"
    sure = dates | {"ended": ["2022-05-16", "2022-05-16"]}
    assert dates_in_words(sure) == words.strip()


def test_power_agrees_by_the_light_that_the_modules_miss():
    data = tracking(Stuck("2023-05-22", "2023-06-26", -40.0), "tracker_stuck")
    loop = fem.close_loop(data[[*USUAL, "p_dc_per_area"]], location=WHERE)
    (finding,) = (f for f in loop.finding_objects if f.effect == "tracker_stuck")
    (check,) = (w for w in finding.conclusive_checks if w.effect == "tracker_stuck")
    assert check.outcome is CheckOutcome.AGREES
    assert check.expected < -0.05
    assert check.size == pytest.approx(check.expected, rel=0.3)
    # shade on the modules would show in power, too, and by any size
    assert {*finding.candidates} <= {"tracker_stuck", "modules_covered"}
    assert finding.probabilities["tracker_stuck"] > 0.8
    # the plant gives what the light on its modules makes
    begins = loop.events["start"]
    stuck = begins.between("2023-05-22", "2023-06-26")
    assert not (stuck & (loop.events["effect"] == "underperformance")).any()


def test_a_standstill_counts_by_its_own_days():
    """Two clear days of a year: less than 0.15 K over the year, and several on them."""
    data = tracking(Stuck("2023-09-18", "2023-09-21", 10.0), "tracker_stuck")
    loop = fem.close_loop(data[USUAL], location=WHERE)
    (finding,) = (f for f in loop.finding_objects if f.effect == "tracker_stuck")
    assert finding.added and finding.gain < fem.Criteria().min_rmse_reduction
    (gain,) = (c for c in finding.checks if c.criterion == "min_rmse_reduction")
    days = (gain.threshold / fem.Criteria().min_rmse_reduction) ** 2 * 365
    assert gain.passed and 1.0 < days < 3.0
    assert dates_of(loop)[0] >= "2023-09-18" and dates_of(loop)[1] == "2023-09-21"


@pytest.mark.parametrize("size, found", [(1.0, True), (0.55, False)])
def test_a_standstill_stands_as_a_whole(size, found):
    """Light that falls by half of what a standstill takes has another cause."""
    random, days = np.random.default_rng(2), np.arange(400)
    rows = np.repeat(days, 24)
    hours = np.tile(np.arange(24), len(days))
    light = np.maximum(np.sin((hours - 6) / 12 * np.pi), 0.0) * random.uniform(
        0.3, 1.0, len(days)
    ).repeat(24)
    tangents = [light * (hours - 12 + turn) for turn in (-3.0, 0.0, 3.0)]
    there = (rows >= 200) & (rows < 206)
    rest = random.normal(0.0, 0.3, len(rows)) + size * there * tangents[1]
    basis = np.zeros((len(rows), 0))
    day = rows + hours / 24.0
    angles = np.array([-10.0, 0.0, 10.0])
    out = find_standstill(rest, tangents, light, angles, basis, day, 0.15)
    assert (out is not None) == found


EDGE = Stuck("2023-05-31", "2023-06-14", -40.0)  # begins in a test week


@pytest.fixture(scope="module")
def at_an_edge():
    return tracking(EDGE, "tracker_stuck", clear_share=0.5)


def dates_of(loop):
    """First day, and first day after, of the standstill in a loop's model."""
    (effect,) = (e for e in loop.fit.effects if e.name == "tracker_stuck")
    return effect.settings["start"], effect.settings["end"]


@pytest.fixture(scope="module")
def without_power(at_an_edge):
    return fem.close_loop(at_an_edge[USUAL], location=WHERE)


def test_power_shows_the_days_of_test_weeks(at_an_edge):
    columns = [*USUAL, "p_dc_per_area"]
    loop = fem.close_loop(at_an_edge[columns], location=WHERE)
    weeks = loop.weeks[EDGE.start : "2023-06-13"]
    assert (weeks == "test").any() and (weeks == "fitting").any()
    assert dates_of(loop) == (EDGE.start, EDGE.end)


def test_an_effect_that_another_explains_keeps_its_place(at_an_edge, monkeypatch):
    """Else a standstill is no rival of a cover once that is in the model."""
    effects, round_of, scanned = [], Search.round, scans.located_effect

    def first_alone(search, step, begin):
        """A round, in which scans find nothing if it is not the first one."""
        search.closed |= {"tracker_stuck"}  # so that another one is in the model
        scan = scanned if not search.located else lambda *given: None
        monkeypatch.setattr(scans, "located_effect", scan)
        this = round_of(search, step, begin)
        design = this.selection.design
        assert "tracker_stuck" in design.own
        effects.append((search, design.effects["tracker_stuck"].settings))
        return this

    monkeypatch.setattr(Search, "round", first_alone)
    fem.close_loop(at_an_edge[[*USUAL, "p_dc_per_area"]], location=WHERE)
    pairs = [(a, b) for (one, a), (two, b) in pairwise(effects) if one is two]
    assert pairs and all(before == after for before, after in pairs)


def test_a_standstill_within_a_test_week_is_found_if_power_shows_it():
    """No fitting week has it, so that without power nothing says that it is there."""
    data = tracking(Stuck("2023-05-29", "2023-06-04", -40.0), "tracker_stuck", seed=5)
    week = slice("2023-05-29", "2023-06-03")
    loop = fem.close_loop(data[[*USUAL, "p_dc_per_area"]], location=WHERE)
    assert dates_of(loop) == ("2023-05-29", "2023-06-04")
    assert (loop.weeks[week] == "fitting").all()
    assert "the week from 2023-05-29 on is fitted" in "\n".join(loop.notes)
    plain = fem.close_loop(data[USUAL], location=WHERE)
    assert "tracker_stuck" not in {one.name for one in plain.fit.effects}
    assert (plain.weeks[week] == "test").all()
    hidden = data.assign(temp_module=data["temp_module"].where(plain.weeks != "test"))
    moved = fem.close_loop(hidden[[*USUAL, "p_dc_per_area"]], location=WHERE)
    assert (moved.weeks[week] == "fitting").all()


def test_a_week_in_which_a_standstill_begins_is_fitted(at_an_edge, without_power):
    """Unless the test weeks are given: then its days there are not known."""
    loop = without_power
    assert dates_of(loop)[0] == EDGE.start
    assert (loop.weeks[EDGE.start : "2023-06-13"] == "fitting").all()
    assert "the week from 2023-05-29 on is fitted" in "\n".join(loop.notes)
    usual = fem.close_loop(at_an_edge[[*COLUMNS]]).weeks == "test"
    own = loop.weeks == "test"
    assert not (own & ~usual).any()
    assert {*own.index[usual & ~own].isocalendar().week} == {22}
    given = fem.close_loop(at_an_edge[USUAL], location=WHERE, holdout=usual)
    assert (given.weeks == "test").equals(usual)
    assert dates_of(given)[0] == "2023-06-05"
    assert loop.table["rmse_test"].iloc[-1] < given.table["rmse_test"].iloc[-1]


def test_the_temperature_of_test_weeks_does_not_decide_which_are_fitted(
    at_an_edge, without_power
):
    data = at_an_edge[USUAL].copy()
    test = without_power.weeks == "test"
    data.loc[test, "temp_module"] += np.random.default_rng(1).normal(0, 2, test.sum())
    other = fem.close_loop(data, location=WHERE)
    assert other.weeks.equals(without_power.weeks)
    week = slice("2023-05-29", "2023-06-04")  # which is fitted in the end
    data.loc[week, "temp_module"] += 1.0
    other = fem.close_loop(data, location=WHERE)
    assert other.weeks.equals(without_power.weeks)


def test_a_sensor_that_reads_less_for_weeks_is_no_standstill(sound):
    data = sound.copy()
    weeks = slice("2023-05-22", "2023-07-10")
    data.loc[weeks, "poa_global"] *= 0.75
    loop = fem.close_loop(data[[*USUAL, "p_dc_per_area"]], location=WHERE)
    named = [f.effect for f in loop.finding_objects if f.verdict == "identified"]
    assert named == ["irradiance_sensor_episode"]
    assert "tracker_stuck" not in loop.effects


def test_a_tracker_that_moves_shows_no_standstill(loop_of_sound):
    why = loop_of_sound.untestable["tracker_stuck"]
    assert why.reason is Reason.NO_STANDSTILL
    assert not loop_of_sound.effects


def test_a_fixed_plane_cannot_stand_still(sound):
    data = simulator.record(RHINE, PHYSICS, days=70, step=1800.0)[[*COLUMNS]]
    place = dict(location=WHERE, surface_tilt=35.0, surface_azimuth=180.0)
    loop = fem.close_loop(data, **place)
    assert loop.untestable["tracker_stuck"].reason is Reason.NO_AXIS
    unknown = fem.close_loop(data)
    assert unknown.untestable["tracker_stuck"].reason is Reason.LACKS
    ranked = fem.rank_effects(loop.fit, data, ["tracker_stuck"], **place)
    assert "does not turn about an axis" in ranked.loc["tracker_stuck", "note"]


def test_it_can_be_fitted_at_known_days():
    stuck = Stuck("2023-07-03", "2023-07-17", -35.0)
    data = tracking(stuck, "tracker_stuck")
    settings = dict(start=stuck.start, end=stuck.end)
    settings |= dict(surface_tilt=35.0, surface_azimuth=90.0)
    place = geometry(data.index, WHERE)
    fit = fem.fit_fem(
        *(data[name] for name in COLUMNS),
        model="faiman",
        dynamics="balance",
        effects=[{"name": "tracker_stuck", **settings}],
        **{name: pd.Series(c, data.index) for name, c in place.items()},
        **{name: data[name] for name in USUAL[-2:]},
    )
    assert fit.coefficients["tracker_stuck.share"] == pytest.approx(1.0, abs=0.15)


# ------------------------------------------------------------------ the record
BOTH = ("tracker_stuck", "tracker_stuck_sensor")


@pytest.mark.parametrize("by_columns", [True, False])
def test_a_sensor_that_stands_with_the_modules_is_seen_by_its_light(
    by_columns, tmp_path
):
    """Temperature and irradiance agree; the described plane is not theirs."""
    stuck = Stuck("2023-07-03", "2023-07-17", 30.0)
    data = tracking(stuck, *BOTH, clear_share=0.6)
    how = dict(location=WHERE)
    if not by_columns:
        data = data.drop(columns=USUAL[-2:])
        how["mount"] = pvlib.pvsystem.SingleAxisTrackerMount(0, 180, 60, True, 0.35)
    loop = fem.close_loop(data[[n for n in USUAL if n in data]], **how)
    (found,) = loop.standings
    low, high = map(day_number, found.between)
    assert low <= day_number(stuck.start) <= high
    assert abs(day_number(found.end) - day_number(stuck.end)) <= 3
    assert found.surface_tilt == pytest.approx(30.0, abs=8.0)
    assert found.surface_azimuth == pytest.approx(270.0, abs=2.0)
    assert found.after < 0.25 * found.before
    assert not loop.effects
    one = loop.statements.iloc[0]
    assert (one["cause"], one["device"]) == ("sensor_stuck", "tracker")
    assert "west" in one["text"] and found.start in one["text"]
    assert one["text"].endswith("the plane that the record describes")
    assert "1 irradiance sensor that was stuck" in " ".join(str(loop).split())
    assert "was stuck" in loop.report()
    # effects of the plane have the angles at which it stood, on its days only
    tilt = pd.Series(loop.fit.record["surface_tilt"], loop.fit.record.index)
    during = found.rows(tilt.index)
    assert (tilt[during] == found.surface_tilt).all()
    assert np.ptp(tilt[~during]) > 50.0
    loop.to_json(tmp_path / "loop.json")
    again = fem.Loop.from_json(tmp_path / "loop.json")
    assert again.standings == loop.standings
    assert again.statements["text"].iloc[0] == one["text"]


def test_a_sensor_that_stands_level_differs_less_from_one_that_turns():
    """By less than 20 % of a clear day, where the tracker turns by 45° at most."""
    stuck = Stuck("2023-04-22", "2023-05-16", -3.0)
    tracker = Tracker(max_angle=45.0, gcr=0.5, stuck=stuck)
    site = replace(RHINE, latitude=36.0, clear_share=0.6, tracker=tracker)
    on = PHYSICS | {"tracker_stuck_sensor": 1.0}
    data = simulator.record(site, on, days=180, step=900.0, seed=3)
    angles = tuple(data[name].to_numpy() for name in USUAL[-2:])
    place = Location(site.latitude, site.longitude, tz=site.tz)
    (found,) = standing_of(data["poa_global"], data.index, place, angles)
    assert abs(day_number(found.start) - day_number(stuck.start)) <= 3
    assert found.surface_tilt < 8.0 and found.before < 0.2


def test_modules_that_go_on_are_said_not_to_stand_with_the_sensor():
    stuck = Stuck("2023-07-03", "2023-07-17", 30.0)
    data = tracking(stuck, "tracker_stuck_sensor", clear_share=0.6)
    loop = fem.close_loop(data[USUAL], location=WHERE)
    one = loop.statements.iloc[0]
    assert one["cause"] == "sensor_stuck"
    assert one["text"].endswith("while the modules went on or stood elsewhere")


@pytest.mark.parametrize(
    "effects", [(), ("tracker_stuck",), ("shading_sensor", "soiling_sensor")]
)
def test_light_of_the_described_plane_is_no_standstill(effects):
    """Whatever the modules do, and obstacles before the sensor."""
    data = tracking(Stuck(), *effects, seed=5, clear_share=0.6)
    loop = fem.close_loop(data[USUAL], location=WHERE)
    assert loop.standings == ()


@pytest.mark.parametrize("angle", [-40.0, -35.0, 12.0, 17.5])
@pytest.mark.parametrize("haze", [1.0, 3.0])
def test_the_plane_of_a_day_is_between_those_that_are_tried(angle, haze):
    """
    A plane that is tried is up to 5° away, and would leave 7 % of a clear day.

    Three times the diffuse light, as of dusty air, is no other plane.
    """
    times = pd.date_range("2023-06-01", periods=5 * 96, freq="15min", tz=RHINE.tz)
    place = geometry(times, WHERE)
    zenith, azimuth = (place[f"solar_{name}"].to_numpy() for name in ANGLES)
    up = zenith < 80.0
    day = times.dayofyear.to_numpy()[up]
    sky = Sky.from_rows(np.ones(up.sum()), zenith[up], azimuth[up], day, WHERE)
    planes = Axis(np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])).planes
    hazy = replace(sky, sky=haze * sky.sky)
    sky = replace(sky, poa=0.8 * hazy.on_plane(planes(np.array([angle]))[0]))
    turns = np.linspace(-60.0, 60.0, 13)
    residual, at = nearest_by_day(sky, planes(turns), turns)
    assert residual.max() < 0.02
    np.testing.assert_allclose(at, angle, atol=1.0)


def test_light_of_a_sensor_that_is_set_wrong_is_no_standstill():
    site = replace(RHINE, tracker=Tracker(), clear_share=0.6)
    on = PHYSICS | {"poa_misalignment": 12.0}
    data = simulator.record(site, on, days=365, step=900.0, seed=6)
    angles = tuple(data[name].to_numpy() for name in USUAL[-2:])
    assert standing_of(data["poa_global"], data.index, WHERE, angles) == ()


# ------------------------------------------------- errors of weeks with a memory
def weekly_noise(random, memory, weeks):
    """A stationary first-order autoregression of variance 1."""
    noise = random.normal(size=weeks)
    for i in range(1, weeks):
        noise[i] = memory * noise[i - 1] + np.sqrt(1 - memory**2) * noise[i]
    return noise


@pytest.mark.parametrize("memory", [0.0, 0.4, 0.8])
@pytest.mark.parametrize("count", [1, 3, 12])
def test_the_variance_of_sums_of_weeks_is_that_of_an_autoregression(memory, count):
    lags = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    expected = np.sum(memory**lags) / count
    assert sum_inflation(memory, count) == pytest.approx(expected, rel=1e-9)


def test_sums_of_many_weeks_have_the_variance_of_long_ones():
    assert sum_inflation(0.6, 10_000) == pytest.approx(4.0, rel=1e-3)


def test_slow_noise_widens_the_errors_of_three_weeks_as_far_as_three_weeks_vary():
    random, weeks, shown = np.random.default_rng(0), 52, []
    day = np.repeat(np.arange(7 * weeks), 3) + np.tile([0.4, 0.5, 0.6], 7 * weeks)
    tangent, basis = np.ones(len(day)), np.empty((len(day), 0))
    for _ in range(400):
        rest = np.repeat(weekly_noise(random, 0.8, weeks), 21)
        days = Days.from_rows(rest, basis, day)
        shown.append(days.errors(days.sums(tangent), 140, 161))
    # by the errors of long sums the standard deviation is 0.62
    assert 0.75 < np.std(shown) < 1.15
