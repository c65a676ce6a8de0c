"""The loop finds what was hidden, and says what it cannot know."""

import inspect
import json
import os
import re
import subprocess
import sys
from dataclasses import fields, replace
from functools import partial

import numpy as np
import pandas as pd
import pvlib
import pytest
from conftest import COLUMNS, measured

import pvlib_fem as fem
from pvlib_fem import datasets, simulator
from pvlib_fem._loop.preparation.prepare import prepared_case
from pvlib_fem._loop.regression.correct_clock import module_clock
from pvlib_fem._loop.regression.refits import Fits
from pvlib_fem._record.resampling import coarse
from pvlib_fem._stored import as_json
from pvlib_fem._thermal.steady_models import steady_model
from pvlib_fem.effects import PHYSICS as EFFECTS
from pvlib_fem.reasons import Reason
from pvlib_fem.simulator import PHYSICS, RHINE

RHEIN = pvlib.location.Location(RHINE.latitude, RHINE.longitude, tz=RHINE.tz)
PLACE = dict(location=RHEIN, surface_tilt=35, surface_azimuth=180)
HALF = dict(days=200, step=300, seed=4, start="2023-04-01")


def hidden(*names, file_dst=0.0, **changed):
    """Half a year of the simulated world, which the loop does not know."""
    effects = PHYSICS | dict.fromkeys(names, 1.0) | {"file_dst": file_dst}
    data = simulator.record(effects=effects, **{**HALF, **changed})
    data.attrs = {}
    return data.drop(columns="snow_depth")


@pytest.fixture(scope="module")
def two():
    """Sky and wind direction, and the loop on them."""
    data = hidden("sky_radiation", "wind_direction")
    return data, fem.close_loop(data, **PLACE)


def test_hidden_effects_are_named_with_their_size(two):
    """Absorbed share 0.92·0.97 less 0.2 of electricity; emissivity and view of 35°."""
    _, loop = two
    assert set(loop.effects[:2]) == {"sky_radiation", "wind_direction"}
    named = {f.effect: f for f in loop.finding_objects if f.added}
    assert set(named) == {"sky_radiation", "wind_direction"}
    share = named["sky_radiation"].coefficients["sky_radiation.share"]
    # both faces of a rack see all of the sky between them
    assert share == pytest.approx(0.865 / (0.92 - 0.2), rel=0.2)
    for finding in named.values():
        assert finding.gain > 0.3 and finding.candidates[0] == finding.effect
        assert finding.probabilities[finding.effect] > 0.9
        assert finding.stderr
        for key, error in finding.stderr.items():
            assert 0 < error < 0.2 * max(map(abs, finding.coefficients.values())), key


def test_every_step_is_better_on_test_days(two):
    _, loop = two
    table = loop.table
    assert list(table.index[:3]) == ["steady", "fem", "balance"]
    steps = list(table.index[3:])
    # longwave exchange is in every module, and no finding
    assert steps == ["+radiative_loss", *(f"+{name}" for name in loop.effects)]
    assert loop.last == steps[-1]
    rmse = table.loc[[loop.base, *steps], "rmse_test"]
    assert (rmse.diff().dropna() <= 0).all()
    assert rmse.iloc[-1] < 0.55 * rmse.iloc[0]
    assert table.notna().all(axis=None)


def test_the_table_is_that_of_the_predictions(two):
    data, loop = two
    test = loop.fit.holdout & loop.fit.residual.notna()
    error = (data["temp_module"] - loop.predict(data))[test]
    last = loop.table.iloc[-1]
    assert np.sqrt((error**2).mean()) == pytest.approx(last["rmse_test"], rel=1e-3)
    weeks = pd.Series(loop.fit.holdout.index.isocalendar().week)
    share = loop.fit.holdout.mean()
    assert 0.15 < share < 0.25
    assert loop.fit.holdout.groupby(weeks.to_numpy()).nunique().max() == 1


def test_contributions_are_what_leaving_one_out_changes(two):
    data, loop = two
    parts = loop.contributions(data)
    assert list(parts) == [effect.name for effect in loop.fit.effects]
    nothing = {k: 0.0 for k in loop.fit.coefficients if k.startswith("wind_direction")}
    coefficients = {**loop.fit.coefficients, **nothing}
    usual, drivers = (data[n] for n in COLUMNS[:3]), loop.inputs(data)[1]
    without = loop.fit.thermal_model.predict(*usual, coefficients, **drivers)
    want = loop.predict(data) - without
    np.testing.assert_allclose(parts["wind_direction"], want, atol=1e-9)
    assert parts["sky_radiation"].max() < 0.1  # the sky cools


def test_the_report_says_all(two):
    _, loop = two
    text = loop.report()
    head = text.splitlines()[0]
    assert head.startswith("pvlib_fem: the loop on 200 days at 5 min · 57,600 rows")
    for words in ("steady", "fem (the paper's form)", "+ sky_radiation", "ambiguous"):
        assert words in text
    assert "from measured longwave" in " ".join(text.split())  # lines are folded
    assert "not identifiable" in text
    assert loop.untestable
    for name in loop.untestable:
        assert name in text


def test_the_loop_is_json(two, tmp_path):
    _, loop = two
    path = tmp_path / "loop.json"
    content = json.loads(loop.to_json(path))
    assert json.loads(path.read_text(encoding="utf-8")) == content
    assert [f["effect"] for f in content["findings"]] == [
        f.effect for f in loop.finding_objects
    ]
    assert content["table"].keys() == set(loop.table.index)


def test_the_same_record_gives_the_same_bits(two, tmp_path):
    """Whatever the number of threads."""
    data, _ = two
    short = data.iloc[: 288 * 90]
    short.to_pickle(tmp_path / "data.pkl")
    code = (
        "import sys, pandas as pd, pvlib_fem as fem;"
        "print(fem.close_loop(pd.read_pickle(sys.argv[1])).to_json())"
    )
    answers = {
        subprocess.run(
            [sys.executable, "-c", code, str(tmp_path / "data.pkl")],
            env={**os.environ, "OPENBLAS_NUM_THREADS": threads},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for threads in ("1", "2")
    }
    assert answers == {fem.close_loop(short).to_json() + "\n"}


def test_it_runs_in_a_chain(two):
    data, loop = two
    system = pvlib.pvsystem.PVSystem(
        [
            pvlib.pvsystem.Array(
                pvlib.pvsystem.FixedMount(35, 180),
                module_parameters={"pdc0": 1000.0, "gamma_pdc": -0.0035},
            )
        ],
        inverter_parameters={"pdc0": 1000.0},
    )
    chain = pvlib.modelchain.ModelChain(
        system,
        RHEIN,
        aoi_model="no_loss",
        spectral_model="no_loss",
        temperature_model=loop.temperature_model(deltaT=0.0),
    )
    some = data.iloc[: 288 * 3]
    poa = some[["poa_global", "temp_air", "wind_speed"]].assign(
        poa_direct=0.7 * some["poa_global"], poa_diffuse=0.3 * some["poa_global"]
    )
    cells = chain.run_model_from_poa(poa).results.cell_temperature
    np.testing.assert_allclose(cells, loop.predict(some), atol=0.3)


@pytest.mark.parametrize("seed", range(3))
def test_where_nothing_is_hidden_nothing_is_named(noise, seed):
    """The fitted form and noise that remembers hours, with drivers to mislead."""
    data = hidden(seed=seed)
    base = fem.heat_balance(
        *(data[n] for n in COLUMNS[:3]), model="faiman", u0=25, u1=6, capacity=15e3
    )
    random = 0.7 * np.sqrt(2 * 36) * noise(len(data), 1.0, seed)
    data["temp_module"] = base - 1 + fem.ewm(random, 3 * 3600.0, step=300)
    loop = fem.close_loop(data, **PLACE)
    assert loop.effects == []
    assert not [
        f for f in loop.finding_objects if f.verdict in ("identified", "ambiguous")
    ]
    assert loop.table["rmse_test"]["balance"] == pytest.approx(0.7, rel=0.15)


def test_what_is_in_no_catalogue_is_said_to_be_unknown():
    data = hidden("weekend_exhaust")
    loop = fem.close_loop(data, **PLACE)
    first = loop.unexplained[0]
    assert set(first.candidates) == {"hour", "weekend"}
    assert first.gain > 0.8
    low, high = first.where["hour"]
    assert 8 <= low <= 10 and 15 <= high <= 17
    assert "at weekends; no effect and no column explains it" in first.why
    assert not [f for f in loop.finding_objects if f.verdict == "identified"]
    assert loop.table["rmse_test"].iloc[-1] <= loop.table["rmse_test"][loop.base]


def test_with_its_column_it_is_found_by_name():
    data = hidden("weekend_exhaust")
    heat = simulator._schedules.undeclared_heat(
        data.index,
        data["temp_air"].to_numpy(),
        simulator._switches.amplitudes({"weekend_exhaust": 1.0}),
        simulator.Forms(),
    )[1]
    loop = fem.close_loop(data.assign(**{"fan <W>": heat}), **PLACE)
    assert loop.finding_objects[0].effect == "driver:fan <W>"
    assert loop.finding_objects[0].probabilities["driver:fan <W>"] > 0.5
    assert not loop.unexplained or loop.unexplained[0].gain < 0.3


def test_a_column_made_from_the_answer_is_recognised():
    data = hidden("wind_direction", days=90)
    module = data["temp_module"]
    spies = data.assign(
        twin=module + np.random.default_rng(0).normal(0, 0.2, len(data)),
        excess=module - data["temp_air"],
        slow=module.rolling(3, min_periods=1).mean(),
        fahrenheit=1.8 * module + 32,
        label="text",
        nothing=np.nan,
        still=5.0,
    )
    loop = fem.close_loop(spies, **PLACE)
    assert loop.effects[0] == "wind_direction"
    for name in ("twin", "excess", "slow"):
        why = loop.untestable[f"driver:{name}"]
        assert (why.reason, why.values["column"]) == (Reason.LEAK, name)
    reasons = " ".join(loop.notes)
    for words in ("fahrenheit is a copy of temp_module", "label is not numeric"):
        assert words in reasons
    for words in ("nothing holds no value", "still is constant"):
        assert words in reasons


def test_ones_own_effect_is_found_among_the_others():
    """A vent that blows on the module, in one object."""
    data = hidden("wind_direction", days=120)
    vent = pd.Series(np.where(data.index.hour % 7 == 3, 1.0, 0.0), data.index)
    r_eq = 1 / (28 + 5 * data["wind_speed"])
    data["temp_module"] += fem.ewm(90.0 * vent * r_eq, 400.0)

    def terms(vent_open, *, warmth):
        """Heat of an open vent."""
        return fem.Terms(heat=warmth * vent_open)

    row = fem.Parameter(0.0, 0.0, 500.0, "W/m²")
    own = fem.Effect("vent", terms, {"warmth": row})
    loop = fem.close_loop(
        data.assign(vent_open=vent), effects=[own, "wind_direction", "rain"], **PLACE
    )
    assert set(loop.effects) == {"vent", "wind_direction"}
    (found,) = [f for f in loop.finding_objects if f.effect == "vent"]
    assert found.coefficients["vent.warmth"] == pytest.approx(90, rel=0.25)


def test_an_effect_that_raises_does_not_stop_the_others():
    def broken(wind_speed, *, size):
        raise RuntimeError("not today")

    row = fem.Parameter(0.0, 0.0, 1.0, "-")
    own = fem.Effect("broken", broken, {"size": row})
    data = hidden("wind_direction", days=90)
    loop = fem.close_loop(data, effects=[own, "wind_direction"], **PLACE)
    assert str(loop.untestable["broken"]) == "RuntimeError: not today"
    assert loop.effects == ["wind_direction"]


def test_what_lacks_its_driver_is_not_testable():
    data = hidden("rain", days=90).drop(
        columns=["precipitation", "p_dc_per_area", "longwave_down", "relative_humidity"]
    )
    loop = fem.close_loop(data)
    assert str(loop.untestable["rain"]) == "no precipitation"
    assert str(loop.untestable["electrical_output"]) == (
        "no p_dc_per_area or power_dc or power_ac"
    )
    need = "no location, surface_azimuth, surface_tilt"
    assert str(loop.untestable["rear_irradiance"]) == need
    sky = loop.untestable["sky_radiation"]
    assert sky.reason is Reason.STAND_IN
    assert {"relative_humidity", "longwave_down"} == {*sky.values["columns"]}
    assert not [f for f in loop.finding_objects if f.verdict == "identified"]


def test_by_name_an_effect_takes_the_best_source_that_is_there():
    data = hidden("sky_radiation", days=90).drop(columns="longwave_down")
    loop = fem.close_loop(data, effects=["sky_radiation"], **PLACE)
    assert loop.effects == ["sky_radiation"]
    assert "from humidity" in " ".join(loop.report().split())
    fixed = {"name": "sky_radiation", "source": "air temperature alone"}
    loop = fem.close_loop(data, effects=[fixed], **PLACE)
    assert "identified" not in {f.verdict for f in loop.finding_objects}


@pytest.mark.parametrize("days", [20, 45])
def test_a_short_record_suggests_at_best(days):
    data = hidden("sky_radiation", "electrical_output", days=days)
    loop = fem.close_loop(data, **PLACE)
    assert loop.effects == []
    assert {f.verdict for f in loop.finding_objects} <= {"hint", "unexplained"}
    if days > 30:
        assert any(
            "at least 60 days are needed to identify a cause" in f.why
            for f in loop.finding_objects
        )


def test_a_late_clock_is_found_and_corrected():
    late = simulator.record(effects=PHYSICS | {"clock_shift": 10.0}, **HALF)
    right = simulator.record(effects=PHYSICS, **HALF)
    found, fine = fem.close_loop(late, **PLACE), fem.close_loop(right, **PLACE)
    (clock,) = found.corrections
    assert clock.fault == "clock_shift" and clock.applied
    assert clock.values["late"] == pytest.approx(10.0, abs=0.6)
    assert clock.columns == ("temp_module",) and all(c.passed for c in clock.checks)
    assert fine.corrections == ()
    rows = ["balance", "clock corrected"]
    before, after = (found.table["rmse_test"][name] for name in rows)
    assert after < 0.7 * before
    assert clock.after < 0.7 * clock.before
    assert after == pytest.approx(fine.table["rmse_test"]["balance"], rel=0.1)


def test_a_late_clock_is_judged_at_the_end_of_the_record():
    """Its last rows have no temperature once they are brought to the right time."""
    time = dict(days=63, step=300, start="2023-05-01")
    late = simulator.record(effects=PHYSICS | {"clock_shift": 10.0}, **time)
    loop = fem.close_loop(late, **PLACE)
    (clock,) = loop.corrections
    assert clock.applied and clock.checks[0].statistic > 2.0


def test_a_file_that_keeps_summer_time_is_corrected_and_the_sun_tried():
    """Its zone explains both jumps, so that shade is found where it is."""
    data = hidden("shading", file_dst=1.0, days=365, step=600, start="2023-01-01")
    wall = data.drop(columns="p_dc_per_area").tz_localize(None)
    berlin = pvlib.location.Location(RHINE.latitude, RHINE.longitude, "Europe/Berlin")
    loop = fem.close_loop(wall, **PLACE | {"location": berlin})
    (clock,) = loop.corrections
    assert (clock.fault, clock.columns, clock.applied) == ("file_dst", ("all",), True)
    assert clock.after < 15.0 < 40.0 < clock.before and clock.unit == "min"
    assert "shading" in loop.effects
    share = loop.fit.coefficients["shading.share"]
    assert share == pytest.approx(0.8, rel=0.1)
    # where the location has a zone without summer time, the one of the place is found
    other = fem.close_loop(wall, **PLACE)
    (clock,) = other.corrections
    assert clock.applied and "keeps the clock of Europe/" in clock.why
    assert "shading" not in other.untestable


def test_a_correction_that_does_not_lower_the_error_is_a_note():
    """Of a clock that was read the wrong way round."""
    late = simulator.record(effects=PHYSICS | {"clock_shift": 10.0}, **HALF)
    case = prepared_case(
        late, fem.drivers.checked_place(**PLACE), None, None, fem.Criteria()
    )
    clock = case.clock
    wrong = replace(clock, late=-clock.late, of_means=-clock.of_means)
    fits = Fits(replace(case, clock=wrong))
    raw = fits.bases(steady_model("faiman"))["balance"]
    after, step, _, clock = module_clock(fits, raw)
    assert clock is None and step is raw and not after.case.clock.fault
    assert "not corrected, since the error is no smaller" in after.case.notes[-1]
    after, step, _, clock = module_clock(Fits(case), raw)
    assert clock.applied and clock.after < clock.before and clock.checks[0].passed


@pytest.mark.parametrize("means", [True, False])
def test_a_clock_is_right_of_means_and_of_values_at_the_end_of_a_step(means):
    """Means over 15 min, read as values at its end, are more than 10 min late."""
    late = simulator.record(
        effects=PHYSICS | {"clock_shift": 30.0}, days=70, step=300.0, seed=3
    )
    steps = late.resample("15min")
    rows = (
        steps.mean()
        if means
        else steps.mean().assign(temp_module=steps["temp_module"].last())
    )
    case = prepared_case(
        rows, fem.drivers.checked_place(**PLACE), None, None, fem.Criteria()
    )
    fits = Fits(case)
    raw = fits.bases(steady_model("faiman"))["balance"]
    found = module_clock(fits, raw)[2]
    assert found.late / 60.0 == pytest.approx(30.0, abs=5.0)
    assert f"run {found.late / 60.0:.1f} ± " in found.why


def test_a_temperature_at_the_end_of_each_mean_turns_no_module():
    """It is half an hour ahead of the mean irradiance, as east of it."""
    sky = PHYSICS | {"sky_radiation": 1.0}
    data = simulator.record(effects=sky, days=200, step=300.0, seed=11)
    hourly = data.resample("1h", label="right", closed="right")
    ends = hourly.mean().assign(temp_module=hourly["temp_module"].last())[1:-1]
    loop = fem.close_loop(ends.drop(columns="longwave_down"), **PLACE)
    assert "poa_misalignment" not in loop.effects


@pytest.mark.parametrize("snowy", [False, True])
@pytest.mark.parametrize(
    ("switch", "share"), [("shading", 0.8), ("shading_sensor", -0.8)]
)
def test_shade_is_found_in_its_window_and_on_its_side(switch, share, snowy):
    """An obstacle at 108 to 135° of azimuth and below 28° takes 80 % of the beam."""
    days = HALF | {"days": 365, "start": "2023-01-01"}
    if snowy:
        site = replace(RHINE, temp_mean=4.0, rain_days=0.35)
        effects = PHYSICS | {switch: 1.0}
        data = simulator.record(site, effects, **days)
        assert 0.2 < (data["snow_depth"] > 0).mean() < 0.5
    else:
        data = hidden(switch, **days)
    # power would show it as covered modules or a covered sensor, hour by hour
    loop = fem.close_loop(data.drop(columns="p_dc_per_area"), **PLACE)
    first = loop.finding_objects[0]
    # what follows the sun alone may be another cause that does, or a reflection
    assert (first.effect, first.verdict) == ("shading", "ambiguous")
    outside = first.probabilities["outside"]
    assert 0.05 < outside < 0.2 if switch == "shading" else 0.3 < outside < 0.6
    assert first.coefficients["shading.share"] == pytest.approx(share, rel=0.15)
    (effect,) = (e for e in loop.fit.effects if e.name == "shading")
    assert effect.settings["sensor"] == (switch == "shading_sensor")
    assert effect.settings["windows"]
    for start, end, low, high in effect.settings["windows"]:
        assert start >= 99 and end <= 144 and low >= 0 and high <= 32
    again = fem.effects.find(effect.spec)
    assert again.settings == effect.settings


def contents_of(loop):
    """All that a loop says but the errors of the test weeks."""
    findings = as_json(loop.finding_objects)
    return json.dumps([findings, loop.fit.coefficients, loop.fit.stderr, loop.base])


@pytest.mark.parametrize("step", [120, 300])
def test_no_decision_sees_the_test_weeks(step):
    """Noise instead of them changes no finding, coefficient or probability by a bit."""
    data = hidden("sky_radiation", "weekend_exhaust", days=120, step=step)
    loop = fem.close_loop(data, **PLACE)
    assert loop.effects
    test = loop.weeks == "test"
    assert 0.15 < test.mean() < 0.25
    noise = np.random.default_rng(1).uniform(-15.0, 75.0, test.sum())
    spoilt = data.copy()
    spoilt.loc[test, "temp_module"] = noise
    other = fem.close_loop(spoilt, **PLACE)
    assert contents_of(loop) == contents_of(other)
    pd.testing.assert_frame_equal(loop.ranking, other.ranking)
    assert loop.untestable == other.untestable
    # of values that are not used all are counted, those of the test weeks, too
    notes = [[n for n in one.notes if "not used" not in n] for one in (loop, other)]
    assert notes[0] == notes[1]
    assert other.table["rmse_test"].min() > 5 * loop.table["rmse_test"].max()


def test_weeks_are_divided_once_and_whole():
    data = hidden(days=200)
    weeks = fem.close_loop(data, **PLACE).weeks
    by_week = weeks.groupby([data.index.isocalendar().week.to_numpy()])
    assert by_week.nunique().max() == 1
    share = weeks.value_counts(normalize=True)
    assert share["fitting"] == pytest.approx(0.8, abs=0.06)
    own = pd.Series(data.index.month == 6, data.index)
    weeks = fem.close_loop(data, holdout=own, **PLACE).weeks
    assert ((weeks == "test") == own).all()


def test_what_is_told_is_of_the_model_that_is_returned():
    """What was found is not reported as absent."""
    data = hidden("sky_radiation", "wind_direction")
    loop = fem.close_loop(data, **PLACE)
    assert {"sky_radiation", "wind_direction"} <= {*loop.effects}
    assert not {*loop.ranking.index} & {*loop.effects}
    # nothing like their half a kelvin is left to explain
    assert loop.ranking["gain"].max() < 0.3


def test_rows_without_a_driver_do_not_count_for_its_effect(two):
    """A sixth of the humidity is gone: the same effect, from the rest, and no fill."""
    data = two[0].drop(columns="longwave_down")
    gone = pd.Series(np.arange(len(data)) // 700 % 6 == 2, data.index)
    bare = data.assign(relative_humidity=data["relative_humidity"].mask(gone))
    loop, full = (fem.close_loop(d, **PLACE) for d in (bare, data))
    assert "sky_radiation" in loop.effects
    share = "sky_radiation.share"
    for found in (loop, full):  # emissivity and view of both faces over absorptance
        coefficient = found.fit.coefficients[share]
        assert coefficient == pytest.approx(0.865 / (0.92 - 0.2), rel=0.2)
    assert loop.fit.residual[gone].isna().all()
    lacking = f"relative_humidity is missing in {gone.sum():,} rows"
    assert any(lacking in note and "sky_radiation" in note for note in loop.notes)
    predicted = loop.predict(bare)
    assert predicted[gone].isna().all() and predicted[~gone].notna().all()
    filled = loop.predict(bare, fallback=True)
    model, coefficients = loop.plain
    plain = model.predict(*(bare[n] for n in COLUMNS[:3]), coefficients)
    assert (filled[gone] == plain[gone]).all()
    pd.testing.assert_series_equal(filled[~gone], predicted[~gone])


def test_every_finding_keeps_the_rules_it_was_asked(two):
    _, loop = two
    names = {field.name for field in fields(fem.Criteria)}
    assert loop.finding_objects
    for finding in loop.finding_objects:
        assert finding.checks
        for check in finding.checks:
            assert not check.criterion or check.criterion in names
            assert check.name in str(finding)
        if finding.added:
            assert all(check.passed for check in finding.checks)
            asked = {check.criterion for check in finding.checks}
            assert {"min_probability", "min_rmse_reduction"} <= asked
    content = json.loads(loop.to_json())
    assert content["criteria"]["min_probability"] == 0.95
    assert content["findings"][0]["checks"][0]["passed"] is True


def test_a_criterion_is_a_number_above_nothing_and_is_documented():
    with pytest.raises(ValueError, match="prior_odds = 0 must be more than 0"):
        fem.Criteria(prior_odds=0)
    documented = inspect.getdoc(fem.Criteria)
    for field in fields(fem.Criteria):
        row = rf"^(\w+, )*{field.name}(, \w+)* : "
        assert re.search(row, documented, re.M), field.name
        if field.name != "limits":
            assert getattr(fem.Criteria(), field.name) > 0


def test_what_is_held_is_not_fitted(two):
    data, _ = two
    loop = fem.close_loop(data, fixed={"tau": 300.0}, **PLACE)
    assert loop.fit.dynamics == "ewm"
    assert loop.fit.coefficients["tau"] == 300.0 and loop.fit.stderr["tau"] == 0.0
    assert {"sky_radiation", "wind_direction"} <= {*loop.effects}
    heavy = fem.close_loop(data, fixed={"capacity": 2e4}, **PLACE)
    assert heavy.fit.dynamics == "balance"
    assert heavy.fit.coefficients["capacity"] == 2e4
    sky = fem.close_loop(data, fixed={"sky_radiation.share": 1.0}, **PLACE)
    assert sky.fit.coefficients["sky_radiation.share"] == 1.0
    for fixed, words in (
        ({"ghost": 1.0}, "fixed has ghost, which is no coefficient here"),
        ({"u0": -3.0}, "fixed u0 = -3 .* cannot be"),
        ({"tau": 300.0, "capacity": 2e4}, "two kinds of dynamics; hold one"),
    ):
        with pytest.raises(ValueError, match=words):
            fem.close_loop(data, fixed=fixed, **PLACE)


def test_progress_is_heard_and_one_effect_may_be_asked():
    heard = []
    data = hidden("wind_direction", days=90)
    loop = fem.close_loop(
        data, effects="wind_direction", progress=heard.append, **PLACE
    )
    assert loop.effects == ["wind_direction"]
    assert heard[0] == "checking the record"
    assert any("round 1" in words for words in heard)


@pytest.mark.parametrize("seed", [2, 5])
def test_water_below_the_modules_is_no_drift_of_a_thermometer(seed):
    """A lake of 2 to 10 m; the record has neither its temperature nor its depth."""
    effects = simulator.PHYSICS | {"sky_radiation": 1.0, "water": 1.0}
    data = simulator.record(simulator.RHINE, effects, 365, 1800.0, seed)
    loop = fem.close_loop(data.drop(columns="p_dc_per_area"), **PLACE)
    assert {*loop.effects} == {"ground_or_water", "sky_radiation"}
    water = next(f for f in loop.finding_objects if f.effect == "ground_or_water")
    assert water.probabilities["ground_or_water"] > 0.9
    low, high = water.ranges["ground_or_water.exchange"]
    assert 0.0 < low < 8.0 < high  # W/(m² K)
    errors = loop.table["rmse_test"]
    assert errors[loop.last] < 0.4 * errors[loop.base]


def test_a_hint_lacks_something_and_what_lacks_nothing_is_in_the_model():
    """The season stands for light on the rear, and until then for reflection, too."""
    data = simulator.record(days=365, step=1800.0, seed=6)
    loop = fem.close_loop(data, **PLACE)
    hints = [f for f in loop.finding_objects if f.verdict == "hint"]
    assert hints and all(f.failed is not None for f in hints)
    found = next(f for f in loop.finding_objects if f.effect == "incidence_angle")
    assert found.added and found.failed is None
    errors = loop.table["rmse_test"]
    at = [*errors.index].index("+incidence_angle")
    assert errors.iloc[at] < errors.iloc[at - 1]


def test_the_measured_week_is_too_short_to_name_anything(week):
    loop = fem.close_loop(week)
    assert loop.effects == [] and loop.notes == ()
    rmse = loop.table["rmse_test"]
    assert rmse["fem"] < 1.5 < 4.0 < rmse["steady"]
    assert str(loop.untestable["wind_direction"]) == "no wind_direction"
    assert "fitting days are needed" in str(loop.untestable["thermal_storage"])


def test_on_the_measured_day_fifteen_sensors_are_no_drivers(day):
    loop = fem.close_loop(day)
    assert loop.effects == []
    assert not any(n.startswith("driver:temp_module") for n in loop.untestable)
    (note,) = [note for note in loop.notes if "cross-check the instruments" in note]
    assert note.count("temp_module_") == 16 and "power_string" in note
    assert np.isnan(loop.table["rmse_test"]).all()
    assert "no test days" in loop.report()


def test_coarse_steps_lose_no_day_and_no_kelvin(month):
    """Means over five minutes of a month at one minute, inputs up to their time."""
    record = measured(*(month[n] for n in COLUMNS))
    short = coarse(record)
    assert len(short.index) == pytest.approx(len(month) / 5, abs=2)
    assert short.index.tz == month.index.tz
    at = short.index[1000]
    want = month["poa_global"][at - pd.Timedelta("4min") : at].mean()
    assert short["poa_global"][1000] == pytest.approx(max(want, 0), abs=1e-9)
    around = pd.Timedelta("2min")
    want = month["temp_module"][at - around : at + around].mean()
    assert short["temp_module"][1000] == pytest.approx(want, abs=0.3)
    assert coarse(short) is short


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (dict(model="ghosts"), "unknown model 'ghosts'"),
        (dict(effects=["ghosts"]), "unknown effect 'ghosts'"),
        (dict(holdout=[True]), "holdout must be a boolean Series"),
    ],
)
def test_what_cannot_be_is_refused(change, message):
    data = datasets.synthetic(3, 300)
    with pytest.raises(ValueError, match=message):
        fem.close_loop(data, **change)
    with pytest.raises(ValueError, match="the data have no column wind_speed"):
        fem.close_loop(data.drop(columns="wind_speed"))


def test_names_of_the_effects_are_those_of_the_contract():
    assert list(EFFECTS) == [
        "sky_radiation",
        "electrical_output",
        "wind_direction",
        "rain",
        "soiling",
        "snow",
        "modules_covered",
        "sensor_covered",
        "outage",
        "shading",
        "tracker_stuck",
        "air_elsewhere",
        "radiative_loss",
        "natural_convection",
        "wind_shape",
        "thermal_storage",
        "ground_or_water",
        "incidence_angle",
        "rear_irradiance",
        "poa_misalignment",
        "temperature_gain",
        "air_shield",
        "season",
    ]


@pytest.mark.parametrize("seed", [21, 22])
def test_air_of_another_station_beside_a_pyrgeometer_is_not_the_sky(seed):
    """If the sky's deficit is too large, so is that of the air that checks it."""
    data = simulator.record(effects=PHYSICS, days=365, step=600, seed=seed)
    noise = np.random.default_rng(seed).normal(size=len(data))
    away = pd.Series(noise, data.index).ewm(halflife=18).mean()  # 3 h
    data["temp_air"] += 1.5 * away / away.std()
    loop = fem.close_loop(data, **PLACE)
    assert "air_elsewhere" in loop.finding_objects[0].candidates
    named = [f.effect for f in loop.finding_objects if f.verdict == "identified"]
    assert "sky_radiation" not in named


def test_a_holdout_of_everything_is_named(two):
    data, _ = two
    with pytest.raises(
        ValueError, match=r"has 0: [\d,]+ rows that count are test rows"
    ):
        fem.close_loop(data, holdout=pd.Series(True, data.index))


@pytest.mark.parametrize("how", ["mean", "last"])
def test_a_temperature_at_the_end_of_steps_beside_mean_irradiance_is_noted(how):
    fine = simulator.record(effects=PHYSICS, days=120, step=300.0, start="2023-04-01")
    fine = fine[["poa_global", "temp_air", "wind_speed", "temp_module"]]
    hours = fine.resample("1h", label="right", closed="right")
    data = hours.mean().assign(temp_module=hours["temp_module"].agg(how))[1:-1]
    loop = fem.close_loop(data, **PLACE)
    noted = any("the end of each step" in note for note in loop.notes)
    assert noted == (how == "last")


def test_an_early_clock_is_called_early():
    """The table's row and the note say the same."""
    early = simulator.record(effects=PHYSICS | {"clock_shift": -12.0}, **HALF)
    text = fem.close_loop(early, **PLACE).report()
    (row,) = (line for line in text.splitlines() if line.startswith("clock corrected"))
    assert re.search(r" 1[12]\.\d ± \d\.\d min behind$", row)
    assert re.search(
        r"timestamps of temp_module run 1[12]\.\d ± \d\.\d min behind", text
    )


def test_each_stage_is_in_the_log_and_on_one_line(caplog, capsys):
    """A function gets the words of the log; nothing is shown by default."""
    data = simulator.record(days=6, step=1800)
    told = []
    with caplog.at_level("INFO", logger="pvlib_fem"):
        fem.close_loop(data, progress=told.append)
    assert [record.getMessage() for record in caplog.records] == told
    assert told[0] == "checking the record" and len(told) > 2
    assert capsys.readouterr() == ("", "")
    fem.close_loop(data, progress=True)
    assert "checking the record" in capsys.readouterr().err


@pytest.mark.parametrize("value", [np.nan, 3000.0])
def test_a_frost_without_irradiance_is_no_row_that_counts(value):
    """With ``snow_depth`` modules below 0 °C count, where their light is known."""
    data = simulator.record(effects=PHYSICS, days=40, step=1800, start="2023-01-01")
    cold = data.index[(data["temp_module"] < 0) & (data["poa_global"] == 0)][5]
    data.loc[cold, "poa_global"] = value
    loop = fem.close_loop(data, effects=[])
    assert np.isfinite(loop.table.loc[loop.last, "rmse_test"])
    assert np.isfinite(list(loop.fit.coefficients.values())).all()


def test_a_module_that_lies_flat_has_no_azimuth_and_is_reported():
    """A slope of the plane by its azimuth is nothing there, and no coefficient."""
    effects = PHYSICS | {"soiling": 1.0}
    data = simulator.record(effects=effects, days=400, step=3600, seed=5)
    place = PLACE | {"surface_tilt": 0}
    loop = fem.close_loop(data, effects=["poa_misalignment", "soiling"], **place)
    known = loop.ranking["coefficients"].get("poa_misalignment")
    if isinstance(known, dict):
        assert "poa_misalignment.azimuth" not in known
    assert "pvlib_fem: the loop on 400 days" in str(loop) and loop.to_html()


def test_columns_of_objects_that_are_numbers_are_taken_as_in_a_fit():
    data = hidden("wind_direction", days=70)
    objects = data.assign(
        wind_direction=data["wind_direction"].astype(object),
        words="clear",
    )
    found = fem.close_loop(objects, **PLACE)
    assert str(found.finding_objects[0]) == str(
        fem.close_loop(data, **PLACE).finding_objects[0]
    )
    assert any("words is not numeric" in note for note in found.notes)


@pytest.mark.parametrize("value", [np.nan, 20.0])
def test_whether_test_rows_have_an_answer_decides_nothing(value):
    """On 70 days, of which only 56 are fitted; 60 have to count."""
    effects = PHYSICS | {"sky_radiation": 1.0}
    data = simulator.record(
        effects=effects, days=70, step=1800, start="2023-04-01", seed=3
    )
    want = fem.close_loop(data)
    hidden = data.copy()
    hidden.loc[want.weeks == "test", "temp_module"] = value
    found = fem.close_loop(hidden)
    assert want.effects and found.effects == want.effects
    assert found.fit.coefficients == want.fit.coefficients
    columns = ["gain", "coefficients", "stderr"]
    pd.testing.assert_frame_equal(found.ranking[columns], want.ranking[columns])


@pytest.mark.parametrize(
    ("latitude", "tilt", "azimuth"),
    [(49, 0, 180), (49, 90, 0), (49, 35, 360), (90, 35, 180), (-90, 35, 0), (0, 0, 0)],
)
def test_a_place_of_any_kind_has_its_report_and_its_ranking(latitude, tilt, azimuth):
    """Where a slope by azimuth is nothing, or the sun never sets, too."""
    effects = PHYSICS | {"soiling": 1.0, "poa_misalignment": 5.0, "sky_radiation": 1.0}
    data = simulator.record(effects=effects, days=120, step=3600, seed=5)
    place = dict(
        location=pvlib.location.Location(latitude, 8.7, tz=RHINE.tz),
        surface_tilt=tilt,
        surface_azimuth=azimuth,
    )
    loop = fem.close_loop(data, **place)
    assert "the loop on 120 days" in str(loop) and loop.to_html()
    assert json.loads(loop.to_json())["place"]["surface_tilt"] == tilt
    assert len(fem.rank_effects(loop.fit, data, **place))


def test_360_degrees_is_north():
    data = simulator.record(effects=PHYSICS, days=70, step=3600, seed=5)
    north, whole = (
        fem.close_loop(data, **PLACE | {"surface_azimuth": azimuth})
        for azimuth in (0, 360)
    )
    assert whole.fit.coefficients == pytest.approx(north.fit.coefficients, rel=1e-9)
    assert whole.effects == north.effects


@pytest.mark.parametrize("dynamics", ["ewm", "balance"])
def test_the_last_row_of_errors_is_of_the_final_model(dynamics):
    """Of two forms without effects, the one that the loop takes comes last."""
    data = fem.datasets.synthetic(days=90, step=600, seed=3)
    weather = [data[name] for name in ("poa_global", "temp_air", "wind_speed")]
    form = {
        "ewm": partial(fem.fem_temperature, tau=600.0),
        "balance": partial(fem.heat_balance, capacity=22e3),
    }[dynamics](*weather, model="faiman", u0=25, u1=5)
    noise = np.random.default_rng(0).normal(0.0, 0.4, len(data))
    loop = fem.close_loop(data.assign(temp_module=form + noise), effects=[])
    assert loop.fit.dynamics == dynamics and not loop.patterns
    assert {"fem", "balance"} <= {*loop.table.index}
    assert loop.table.index[-1] == loop.last
    row = loop.table.loc[loop.last, "rmse_test"]
    assert loop.table["rmse_test"].iloc[-1] == row == loop.table["rmse_test"].min()
