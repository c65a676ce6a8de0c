"""False names in records without the named effect, and the reliability of names."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from conftest import call
from pvlib.location import Location
from scipy.stats import binom, poisson

import pvlib_fem as fem
from pvlib_fem import simulator
from pvlib_fem._findings import Verdict
from pvlib_fem._loop.close import close_loop, finished_search
from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._recovery.draw import Injection
from pvlib_fem._recovery.inject import Injector
from pvlib_fem._recovery.judge import Outcome
from pvlib_fem._recovery.recover import planned_injections
from pvlib_fem._recovery.recovery_result import Recovery
from pvlib_fem._recovery.scramble import Scrambler, explained_share
from pvlib_fem._recovery.trial import (
    Trial,
    false_names,
    false_of,
    rate_between,
    share_between,
)
from pvlib_fem.simulator import RHINE

USUAL = ["poa_global", "temp_air", "wind_speed", "temp_module"]
PLACE = dict(
    location=Location(RHINE.latitude, RHINE.longitude, tz=RHINE.tz),
    surface_tilt=35,
    surface_azimuth=180,
)


@pytest.fixture(scope="module")
def record():
    """Two years with wind direction, a sensor that is pressed on, and two columns."""
    effects = simulator.PHYSICS | {"wind_direction": 1.5}
    how = dict(days=735, step=3600, seed=3, start="2021-01-01")
    data = simulator.record(effects=effects, **how)
    data = data[[*USUAL, "wind_direction", "relative_humidity"]]
    late = data.index >= data.index[400 * 24]
    over = data["temp_module"] - data["temp_air"]
    data["temp_module"] += np.where(late, 0.15 * over, 0.0)
    data["lamp"] = 1.0 * ((data.index.hour >= 8) & (data.index.hour < 17))
    data["power_ac"] = 0.15 * data["poa_global"]
    return data


@pytest.fixture(scope="module")
def done(record):
    how = dict(holdout=None, effects=None, check_units=True, fixed=None)
    place = fem.drivers.checked_place(**PLACE)
    return finished_search(record, "faiman", place, None, criteria=Criteria(), **how)


@pytest.fixture(scope="module")
def scrambler(record, done):
    return Scrambler.from_loop(*done, Injector.from_loop(*done), record, None)


def changes(loop):
    return [name for name in loop.effects if name.endswith(("_step", "_drift"))]


def test_the_record_itself_shows_both(done):
    _, loop = done
    assert "wind_direction" in loop.effects and changes(loop)


def test_what_the_model_has_without_findings_is_not_put_in(done):
    search, loop = done
    assert "radiative_loss" in {effect.name for effect in loop.fit.effects}
    planned, notes = planned_injections(search, loop, ["radiative_loss"], [1.0], 1, 0)
    assert not planned
    assert notes == {"radiative_loss": "the model without findings has it"}


@pytest.mark.parametrize("number", [0, 1])
def test_drivers_are_those_of_other_days_and_nothing_else_moves(
    record, scrambler, number
):
    moved, holdout, lost, words = scrambler.scrambled("drivers", number, 0)
    assert holdout is None and ("1 year later", "mirrored")[number] in words
    kept = [*USUAL, "power_ac"]
    pd.testing.assert_frame_equal(moved[kept], record[kept])
    for name in ("wind_direction", "relative_humidity"):
        same = moved[name] == record[name]
        assert same.mean() < 0.2 and moved[name].notna().mean() > 0.95
        for hour in (3, 12):
            at = record.index.hour == hour
            assert {*moved[name][at].dropna()} <= {*record[name][at]}
    # a timetable is as it was, and radiation to the sky has forms without humidity
    assert lost == {"wind_direction", "air_elsewhere"}


def test_a_year_later_is_a_year_later(record, scrambler):
    moved = scrambler.scrambled("drivers", 0, 0)[0]["wind_direction"]
    own = record["wind_direction"]
    np.testing.assert_array_equal(moved[: 365 * 24], own[365 * 24 : 730 * 24])


def test_weeks_are_those_of_other_years_with_all_columns(record, scrambler):
    marked = replace(
        scrambler,
        record=record.assign(day=record.index.day_of_year, hour=record.index.hour),
    )
    mixed, _, lost, _ = marked.scrambled("dates", 0, 0)
    assert mixed.index.equals(record.index)
    assert (mixed["hour"] == record.index.hour).all()
    apart = np.abs(mixed["day"] - record.index.day_of_year)
    assert np.minimum(apart, 365 - apart).max() <= 1
    other = (mixed["temp_air"] != record["temp_air"]).to_numpy()
    assert 0.3 < other[: 730 * 24].mean() < 0.7 and not other[731 * 24 :].any()
    # values of a row stay together
    columns = ["poa_global", "temp_air", "wind_direction"]
    rows = {*map(tuple, record[columns].round(6).to_numpy())}
    assert {*map(tuple, mixed[columns].round(6).to_numpy())} <= rows
    assert {
        "module_sensor_contact_step",
        "anemometer_drift",
        "air_offset_episode",
    } <= lost
    assert not {"wind_direction", "sky_radiation"} & lost
    assert not mixed.equals(marked.scrambled("dates", 1, 0)[0])
    assert mixed.equals(marked.scrambled("dates", 0, 0)[0])


def test_quarters_stay_together_and_keep_episodes(record, scrambler):
    day = np.arange(len(record)) // 24
    marked = replace(scrambler, record=record.assign(day=day))
    weeks, quarters = (marked.scrambled("dates", number, 0) for number in (0, 1))
    moves = [np.count_nonzero(np.diff(m[0]["day"] - day)) for m in (weeks, quarters)]
    assert moves[0] > 20 and 2 <= moves[1] <= 9
    assert "weeks" in weeks[3] and "quarters" in quarters[3]
    steps = {"module_sensor_contact_step", "anemometer_drift"}
    assert steps <= quarters[2] and "air_offset_episode" not in quarters[2]
    assert quarters[2] < weeks[2]


def test_changes_that_the_record_shows_are_taken_off_before_dates(record, scrambler):
    off = (record["temp_module"] - scrambler.plain).to_numpy()
    sunny = (record["poa_global"] > 500).to_numpy()
    late = np.arange(len(record)) > 420 * 24
    assert off[sunny & late].mean() > 2.0
    assert np.abs(off[: 300 * 24]).max() < 0.2


def test_what_is_lost_is_not_named_and_the_rest_is(scrambler):
    """Each kind takes away the one cause and leaves the other."""
    moved = scrambler.scrambled("drivers", 0, 0)[0]
    loop = close_loop(moved, **PLACE)
    assert "wind_direction" not in loop.effects and changes(loop)
    mixed = scrambler.scrambled("dates", 0, 0)[0]
    loop = close_loop(mixed, **PLACE)
    assert "wind_direction" in loop.effects and not changes(loop)


def test_times_of_a_zone_are_taken_by_one_clock(record):
    """Where a zone moves its clock, days stay days."""
    zone = record.tz_convert("Europe/Berlin")
    both = (
        Scrambler(data, data["temp_module"], ("wind_direction",), (), (), None)
        for data in (record, zone)
    )
    one, other = (s.scrambled("dates", 0, 0)[0] for s in both)
    np.testing.assert_array_equal(one, other)


def test_likeness_is_of_angles_on_the_circle():
    random = np.random.default_rng(0)
    angle = random.uniform(0, 360, 4000)
    turned = (angle + 90.0) % 360.0
    assert explained_share(angle, turned, angles=True) == pytest.approx(1.0)
    assert explained_share(angle, random.permutation(angle), angles=True) < 0.01
    values = random.normal(size=4000)
    mixed = values + random.normal(size=4000)
    assert explained_share(values, mixed) == pytest.approx(0.5, abs=0.05)
    assert (
        explained_share(values, np.full(4000, np.nan))
        == explained_share(values, 0.0 * values)
        == 0.0
    )


def finding(verdict, *candidates, added=True):
    return SimpleNamespace(
        effect=candidates[0], candidates=candidates, verdict=verdict, added=added
    )


def test_only_what_is_lost_is_false():
    findings = [
        finding(Verdict.IDENTIFIED, "module_sensor_contact_step"),
        finding(Verdict.IDENTIFIED, "rain"),
        finding(Verdict.AMBIGUOUS, "mounting_step", "module_sensor_contact_step"),
        finding(Verdict.AMBIGUOUS, "mounting_step", "soiling"),
        finding(Verdict.HINT, "module_sensor_contact_step", added=False),
    ]
    lost = {"module_sensor_contact_step", "mounting_step"}
    assert false_of(findings, lost) == (
        ("module_sensor_contact_step",),
        ("mounting_step | module_sensor_contact_step",),
    )


def trial(kind, number, lost, *named, refused=""):
    return Trial(kind, number, "moved", lost, named, refused=refused)


def test_reliability_is_the_share_of_trials_without_a_false_name():
    trials = (
        *(trial("drivers", i, ("rain",), *["rain"] * (i == 0)) for i in range(4)),
        trial("drivers", 4, ("rain",), refused="no"),
        *(trial("dates", i, ("module_sensor_contact_step",)) for i in range(10)),
    )
    named = finding(Verdict.IDENTIFIED, "rain")
    found = Recovery({}, "0", "a", baseline=(named,), trials=trials, planned_trials=15)
    rows = found.reliability
    assert rows.loc["rain", ["trials", "false", "reliability"]].tolist() == [4, 1, 0.75]
    assert rows["identified"].tolist() == [True, False]
    assert rows.loc["module_sensor_contact_step", "reliability"] == 1.0
    assert (
        rows.loc["module_sensor_contact_step", "reliable_from"]
        == share_between(10, 10)[0]
    )
    assert np.isnan(rows["completeness"]).all()
    mean, ends = false_names(trials)
    assert mean == 0.25 and ends == rate_between(1, 4)
    text = str(found)
    assert "in 4 records with drivers moved in time: 1 false names (rain)" in text
    assert "refused by the loop: 1, first: no" in text
    low, high = ends
    share = f"75 % ({100 - 100 * high:.0f} % to {100 - 100 * low:.0f} %)"
    assert f"names, 1 that could be false: {share} are true" in text


def test_completeness_is_of_clear_sizes_as_they_are_rounded():
    sizes = [(0.7 * 0.0314157, False), (1.49999e-3, True), (2e-3, False)]
    put_in = (
        Outcome(Injection("rain", 0, {}, {}, size, predicted, 0.0), found=found)
        for (size, found), predicted in zip(sizes, (0.0314157, 1e-3, 1e-3))
    )
    found = Recovery({}, "0", "a", outcomes=tuple(put_in), planned=3).reliability
    row = found.loc["rain"]
    assert (row["found"], row["injections"], row["completeness"]) == (1, 2, 0.5)
    assert (row["complete_from"], row["complete_to"]) == share_between(1, 2)
    assert row["trials"] == 0 and np.isnan(row["reliability"])


@pytest.mark.parametrize("of", [10, 20])
def test_intervals_hold_the_truth_as_often_as_they_say(of):
    counts = np.arange(of + 1)
    low, high = np.array([share_between(count, of) for count in counts]).T
    np.testing.assert_allclose(low, 1.0 - high[::-1])
    held = [
        binom.pmf(counts, of, share)[(low <= share) & (share <= high)].sum()
        for share in np.linspace(0.01, 0.99, 99)
    ]
    assert np.mean(held) == pytest.approx(0.9, abs=0.02)
    many = np.arange(200)
    low, high = np.array([rate_between(count, of) for count in many]).T
    held = [
        poisson.pmf(many, rate * of)[(low <= rate) & (rate <= high)].sum()
        for rate in np.linspace(0.02, 3.0, 100)
    ]
    assert np.mean(held) == pytest.approx(0.9, abs=0.02)


HOW = dict(sizes=(), reliability=True, trials=1, progress=False, processes=1)


def test_a_file_has_the_trials_and_the_rest_is_done_another_time(record, tmp_path):
    path = tmp_path / "recovery.json"
    first = fem.recover_effects(record, **HOW, **PLACE, path=path)
    assert [one.key for one in first.trials] == [("drivers", 0), ("dates", 0)]
    assert Recovery.from_json(path).to_json() == first.to_json()
    assert "in 1 records with dates scrambled: 0 false names" in str(first)
    assert "reliable_from" in first._repr_html_()
    assert not {name for one in first.trials for name in one.identified}
    # the dates are lost; the file has the drivers
    replace(first, trials=first.trials[:1]).to_json(path)
    short = Recovery.from_json(path)
    assert "1 scrambled records of 2 planned" in str(short)
    again = fem.recover_effects(record, **HOW, **PLACE, path=path)
    assert again.to_json() == first.to_json()
    # a call that does not ask for them keeps them
    some = dict(effects="sky_radiation", sizes=(), progress=False, processes=1)
    with pytest.raises(ValueError, match="nothing to put into"):
        fem.recover_effects(record, **some, **PLACE)


def test_a_short_record_has_no_other_years(record, tmp_path):
    path = tmp_path / "plant.csv"
    days = record[[*USUAL, "wind_direction"]].tz_localize(None)
    days[: 100 * 24].to_csv(path)
    effects = ("--effects", "wind_direction", "--draws", 1, "--processes", 1)
    said = call("recover", path, *effects, "--reliability", "--trials", 2)
    assert said.exit_code == 0, said.output
    assert "in 2 records with drivers moved in time" in said.output
    assert "dates scrambled: the record has less than two years" in said.output
