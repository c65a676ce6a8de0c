"""What other columns say of an instrument that has changed."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pvlib
import pytest
import study_instruments
from pvlib.location import Location
from test_instruments import DATES, closed, dated, half_a_year, with_change  # noqa: F401

from pvlib_fem import close_loop
from pvlib_fem.effects import EFFECTS, find
from pvlib_fem.findings import NIGHT, OUTPUT, Finding, Opinion, Verdict, Witness
from pvlib_fem.loop.comparisons import (
    COMPARISONS,
    SKY,
    USUAL_WIND,
    Apart,
    apart,
    usual,
)
from pvlib_fem.loop.confirm import refit_checks
from pvlib_fem.loop.criteria import Criteria
from pvlib_fem.loop.propose import Proposals
from pvlib_fem.loop.witness import courses
from pvlib_fem.reasons import Reason, because
from pvlib_fem.record.columns import is_power, twin_of, vouches
from pvlib_fem.stored import Stored


def witnessed(data, step, **more):
    """The record with power and second sensors, which know of no change."""
    random = np.random.default_rng(5)
    share = 1.0 + random.normal(0.0, 0.02, len(data))
    warm = data["temp_module"] - 25.0
    power = 5000.0 * data["poa_global"] / 1000.0 * (1.0 - 0.004 * warm) * share
    return data.assign(power_ac=power, **more)


def after(data):
    return (data.index >= "2023-09-15").astype(float)


def test_power_names_the_irradiance_sensor(half_a_year):  # noqa: F811
    """It reads a tenth less from a date on, and power does not."""
    data, _ = with_change(half_a_year)
    data = witnessed(data, 0.1)
    data["poa_global"] /= 1.0 + 0.1 * after(data)
    first = closed(data).findings[0]
    assert first.effect == "sensitivity_step" and first.verdict is Verdict.NAMED
    (witness,) = first.witnesses
    assert witness.column == "power_ac" and witness.opinion is Opinion.AGREES
    assert witness.size == pytest.approx(np.log(1.1), abs=3 * witness.stderr + 0.005)
    assert "power_ac part from the sensor" in first.why


def test_power_speaks_for_the_irradiance_sensor_where_the_mounting_changed(
    half_a_year,  # noqa: F811
):
    data, _ = with_change(half_a_year, "mounting_step")
    loop = closed(witnessed(data, 0.0))
    first = loop.findings[0]
    assert first.verdict is Verdict.CLASS
    assert "mounting_step" in first.candidates
    assert "sensitivity_step" not in first.candidates
    opinions = {
        (o.effect, o.opinion) for o in first.witnesses if o.column == "power_ac"
    }
    assert opinions == {("sensitivity_step", Opinion.CONTRADICTS)}
    assert "power_ac contradicts" in str(loop)
    assert "driver:power_ac" not in loop.ranking.index


@pytest.mark.parametrize(
    ("usual", "column", "channel", "size"),
    [
        ("poa_global", "poa_global_2", "sensitivity", 0.1),
        ("wind_speed", "wind_speed_mast", "wind_gain", 3.0),
        ("temp_air", "temp_air_2", "air_offset", 1.5),
        ("temp_module", "temp_module_2", "contact", -0.15),
    ],
)
def test_a_second_sensor_names_the_first(
    half_a_year,  # noqa: F811
    usual,
    column,
    channel,
    size,
):
    """The twin sees what was there; the usual column what its sensor made of it."""
    data, _ = with_change(half_a_year)
    random = np.random.default_rng(2)
    twin = data[usual] * (1.0 + random.normal(0.0, 0.01, len(data)))
    there, air = after(data), data["temp_air"]
    if usual == "temp_module":
        data[usual] = air + (data[usual] - air) * (1.0 + size * there)
    elif usual == "temp_air":
        data[usual] = data[usual] - size * there
    else:
        share = size / 6.84 if usual == "wind_speed" else size  # of Faiman's u1
        data[usual] = data[usual] / (1.0 + share * there)
    first = closed(data.assign(**{column: twin})).findings[0]
    assert first.effect == f"{channel}_step" and first.verdict is Verdict.NAMED
    assert {one.opinion for one in first.witnesses} == {Opinion.AGREES}


def test_a_finding_keeps_its_witnesses_in_a_file(half_a_year):  # noqa: F811
    data, _ = with_change(half_a_year, "mounting_step")
    first = closed(witnessed(data, 0.0)).findings[0]
    content = json.loads(json.dumps(first.content()))
    assert Finding.stored(Stored(content, "loop.json")).witnesses == first.witnesses


@pytest.mark.parametrize(
    ("name", "usual", "power"),
    [
        ("poa_global_2", "poa_global", False),
        ("poa_modelled", "poa_global", False),
        ("temp_module_16", "temp_module", False),
        ("poa_global", None, False),
        ("power_ac", None, True),
        ("p_dc", None, True),
        ("power", None, True),
        ("precipitation", None, False),
        ("pressure", None, False),
    ],
)
def test_a_name_says_what_a_column_vouches_for(name, usual, power):
    assert twin_of(name) == usual and is_power(name) == power
    assert vouches(name) == (usual is not None or (power and name != "p_dc"))


PLACE = Location(40.0, -105.0, "Etc/GMT+7", 1700.0)


def under_clouds(fading=0.0, tilt=20.0, late=0, seed=0):
    """Two years by the hour below a sky of which two days in three have clouds."""
    index = pd.date_range("2021-01-01", periods=2 * 8760, freq="1h")
    sun = PLACE.get_solarposition(index.tz_localize(PLACE.tz))
    air = pvlib.atmosphere.get_relative_airmass(sun["apparent_zenith"])
    clear = pvlib.clearsky.ineichen(sun["apparent_zenith"], air, 2.5, PLACE.altitude)
    poa = pvlib.irradiance.get_total_irradiance(
        tilt,
        180.0,
        sun["apparent_zenith"],
        sun["azimuth"],
        clear["dni"],
        clear["ghi"],
        clear["dhi"],
        albedo=0.2,
    )["poa_global"].fillna(0.0)
    random = np.random.default_rng(seed)
    cloudy = random.uniform(size=731) < 0.67
    passing = (
        1.0 - random.uniform(0.1, 0.9, len(index)) * cloudy[np.arange(len(index)) // 24]
    )
    years = np.arange(len(index)) / 8766.0
    values = poa.to_numpy() * passing / (1.0 + fading * years)
    return pd.Series(np.roll(values, late), index)


def asked(poa, wind, place=PLACE, angles=(None, None), late=0.0, searched=None, **more):
    """All comparisons of a record with that irradiance and that wind."""
    dates = (poa.index.normalize() - pd.Timestamp(0)).days.to_numpy()
    columns = {"poa_global": poa.to_numpy(), "wind_speed": wind, **more}
    places = dict(
        zip(("location", "surface_tilt", "surface_azimuth"), (place, *angles))
    )

    class Record(dict):
        index, dates = poa.index, None

    record = Record(columns)
    record.dates = dates
    others = tuple(name for name in more if not name.startswith("temp"))
    case = SimpleNamespace(record=record, witnesses=others, place=places, late=late)
    case.searched = np.ones(len(poa), dtype=bool) if searched is None else searched
    return {one.column: one for one in apart(case)}


@pytest.mark.parametrize("fading", [0.0, 0.15])
@pytest.mark.parametrize(
    ("angles", "late"), [((None, None), 0), ((20.0, 180.0), 0), ((None, None), 1)]
)
def test_a_clear_sky_shows_what_a_sensor_fades(fading, angles, late):
    """With angles and without, by a clock that is right or an hour late."""
    poa = under_clouds(fading, late=late)
    found = asked(poa, np.full(len(poa), 2.0), angles=angles)[SKY]
    years = (found.days - found.days[0]) / 365.2425
    size, error, _ = found.along(years)
    assert size == pytest.approx(np.log1p(2.0 * fading) / 2.0, abs=0.015)
    assert error > 0.01  # two years: turbidity alone could do as much
    wanted = dated("sensitivity_drift", since="2021-01-01")
    opinion = found.of(wanted, 0.15, 0.005, {}).opinion
    assert opinion is (Opinion.AGREES if fading else Opinion.CONTRADICTS)
    if not fading:
        assert found.of(wanted, 0.03, 0.001, {}).opinion is Opinion.CANNOT_TELL


def test_what_needs_no_module_is_compared_on_all_weeks():
    """Its temperature on the weeks of the test is for the test alone."""
    poa = under_clouds()
    wind = np.random.default_rng(1).uniform(1.0, 4.0, len(poa))
    searched = np.arange(len(poa)) // (24 * 7) % 5 != 4
    more = {"poa_global_2": poa.to_numpy(), "power_ac": 5.0 * poa.to_numpy()}
    more["temp_module"] = np.where(searched, 25.0 + 0.03 * poa, np.nan)
    known = asked(poa, wind, searched=searched, **more)
    more["temp_module"] = 25.0 + 0.03 * poa.to_numpy()
    found = asked(poa, wind, searched=searched, **more)
    out = np.unique(np.flatnonzero(~searched) // 24) + found[USUAL_WIND].days[0]
    for name in (SKY, USUAL_WIND, "poa_global_2"):
        assert np.isin(out, found[name].days).mean() > 0.1  # clear days are few
    assert not np.isin(out, found["power_ac"].days).any()
    for name, one in found.items():
        np.testing.assert_array_equal(one.apart, known[name].apart)


def test_without_a_place_no_clear_sky_is_asked():
    poa = under_clouds()
    assert SKY not in asked(poa, np.full(len(poa), 2.0), place=None)


def test_what_changes_for_a_while_is_no_outlier_however_sharp_a_comparison():
    """A dozen standard errors for three weeks; snow, whose days differ, is one."""
    random = np.random.default_rng(0)
    values = random.normal(0.05, 0.01, 260)
    values[40:61] -= 0.12
    snow = np.arange(80, 100)
    values[snow] -= random.uniform(0.1, 2.0, len(snow))
    values[70] = np.nan
    kept = usual(values)
    assert not kept[70]
    assert kept[snow].sum() <= 2
    assert np.delete(kept, [70, *snow]).mean() > 0.98


def test_what_differs_from_year_to_year_is_in_the_error():
    """A step and a drift of a series that forgets over a year, drawn often."""
    days = np.arange(0, 4 * 365, 7) + 18_000
    comparison = next(c for c in COMPARISONS if c.serves(USUAL_WIND))
    apart_ = np.abs(np.subtract.outer(days, days))
    root = np.linalg.cholesky(np.exp(-apart_ / 365.25) + 1e-9 * np.eye(len(days)))
    random = np.random.default_rng(4)
    for weights in (days > days[100], days / 365.25):
        found = Apart(comparison, USUAL_WIND, days, np.zeros(len(days)))
        columns = [np.ones(len(days)), *found.year(), np.asarray(weights, dtype=float)]
        table = np.column_stack(columns)
        draws = comparison.wanders * root @ random.normal(size=(len(days), 2000))
        spread = (np.linalg.pinv(table)[-1] @ draws).std()
        assert np.sqrt(found.wandering(table)) == pytest.approx(spread, rel=0.1)


def by_power(course, seed=6):
    """Six years in which power parts from irradiance along a course."""
    days, random = np.arange(0, 6 * 365, 2) + 18_000, np.random.default_rng(seed)
    noise = pd.Series(random.normal(0.0, 0.03, len(days))).ewm(halflife=9).mean()
    comparison = next(c for c in COMPARISONS if c.serves("power_ac"))
    years = (days - days[0]) / 365.25
    return Apart(comparison, "power_ac", days, course(years) + noise.to_numpy())


@pytest.mark.parametrize("unit", [1.0, 1e3])
def test_what_courses_leave_a_witness_is_what_least_squares_leave(unit):
    """By as many draws as what the best of them leaves has, in whatever unit."""
    one = by_power(lambda years: 0.05 * (years > 1.5) + 0.1 * (years > 4.0))
    one = replace(one, apart=one.apart * unit)
    dates = one.days[[200, 273, 500, 730, 900]]
    steps = (one.days >= dates[:, None]).astype(float)
    slowly = (one.days - one.days[0]).astype(float)
    usual = np.column_stack(one.usual)

    def left(*columns):
        both = np.column_stack([usual, *columns])
        return one.apart - both @ np.linalg.lstsq(both, one.apart, rcond=None)[0]

    best = pd.Series(left(steps[1], steps[3]))
    means = best.groupby(one.days // 28).mean().to_numpy()
    memory = max(np.corrcoef(means[1:], means[:-1])[0, 1], 0.0)
    draws = len(means) * (1.0 - memory) / (1.0 + memory)
    courses, by_two = one.misfits([slowly, np.ones(len(slowly))], dates)
    want = [draws * np.log(np.mean(left(c) ** 2)) for c in (slowly, 0.0 * slowly)]
    np.testing.assert_allclose(courses, want, rtol=1e-6)
    for i, first in enumerate(steps):
        for j, second in enumerate(steps):
            want = draws * np.log(np.mean(left(first, second) ** 2))
            assert by_two[i, j] == pytest.approx(want, rel=1e-6)


@pytest.mark.parametrize(
    ("course", "told"),
    [
        (lambda years: 0.02 * years, ("sensitivity_drift",)),
        (
            lambda years: 0.05 * (years > 1.5) + 0.1 * (years > 4.0),
            ("sensitivity_drift", "sensitivity_step", "sensitivity_episode"),
        ),
    ],
)
def test_a_course_is_named_where_no_step_is_followed_better(course, told):
    """Of a record that shows a drift of the sensor, and no step of one date."""
    one = by_power(course)
    since = pd.Timestamp(0) + pd.Timedelta(days=int(one.days[0]))
    drift = find({"name": "sensitivity_drift", "since": f"{since:%Y-%m-%d}"})
    assert courses([one], ["sensitivity_drift"], {drift.name: drift}) == told


@pytest.mark.parametrize("size", [0.0, 0.1])
def test_a_witness_without_noise_follows_what_is_there(size):
    one = by_power(lambda years: years)
    years = (one.days - one.days[0]) / 365.25
    one = replace(one, apart=size * (years > 2.0))
    courses, by_two = one.misfits([years, years > 2.0], one.days[[300, 600]])
    assert np.isfinite(courses).all() and np.isfinite(by_two).all()
    assert (courses[1] < min(courses[0], by_two.min())) == (size > 0)


@pytest.mark.parametrize("lasts", [True, False])
def test_a_step_is_named_where_nothing_for_a_while_is_followed_better(lasts):
    """A sensor that reads otherwise for a year and a half reads as before after it."""
    one = by_power(lambda years: 0.1 * (years > 1.5) * (lasts | (years < 3.0)))
    at = pd.Timestamp(0) + pd.Timedelta(days=int(one.days[0] + (2 - lasts) * 547.5))
    step = find({"name": "sensitivity_step", "at": f"{at:%Y-%m-%d}"})
    told = courses([one], ["sensitivity_step"], {step.name: step})
    assert told[0] == "sensitivity_step"
    assert ("sensitivity_episode" in told) is not lasts


def test_the_usual_wind_names_an_anemometer_and_clears_it(half_a_year):  # noqa: F811
    """Half of the wind is lost from a date on, or the mounting changes."""
    data, _ = with_change(half_a_year)
    data["wind_speed"] /= 1.0 + 1.0 * after(data)
    first = closed(data).findings[0]
    assert first.effect == "wind_gain_step" and first.verdict is Verdict.NAMED
    said = {(one.column, one.opinion) for one in first.witnesses}
    assert said == {(USUAL_WIND, Opinion.AGREES)}
    assert "usual wind part from the sensor" in first.why


def test_an_offset_shows_by_night_as_by_day(half_a_year):  # noqa: F811
    data, _ = with_change(half_a_year, "module_offset_step")
    first = closed(data).findings[0]
    assert {*first.candidates} == {"module_offset_step", "air_offset_step"}
    assert {(o.column, o.opinion) for o in first.witnesses} == {(NIGHT, Opinion.AGREES)}
    for one in first.witnesses:
        assert abs(one.size - 1.0) < 4 * one.stderr and "by night" in str(one)


@pytest.mark.parametrize("fed", [True, False])
def test_power_says_whether_a_plant_fed_in_an_episode(half_a_year, fed):  # noqa: F811
    data, _ = with_change(half_a_year, "sensitivity_episode", sensitivity_episode=0.2)
    data = witnessed(data, 0.0)
    start, end = DATES["episode"].values()
    days = (data.index >= start) & (data.index < end)
    data.loc[days & (not fed), "power_ac"] = 0.0
    first = closed(data).findings[0]
    assert first.added and first.effect.endswith("_episode")
    (said,) = (one for one in first.witnesses if one.effect == OUTPUT)
    if fed:
        assert OUTPUT not in first.candidates and said.opinion is Opinion.CONTRADICTS
    else:
        assert OUTPUT in first.candidates and said.opinion is Opinion.AGREES
        assert said.size == pytest.approx(-1.0) and "the plant fed 100 ±" in str(said)


def test_a_class_led_by_a_season_holds_the_kin_of_its_changes():
    """What no record parts from a drift in it belongs to it, whatever leads."""
    names = ("season", "contact_drift")
    found = SimpleNamespace(effects={name: EFFECTS[name] for name in names})
    ours = Proposals(SimpleNamespace(untestable={}), found, frozenset(), {})
    weighing = SimpleNamespace(found=found, best="season", weights={}, good={})
    heard = ours.heard(weighing, ("contact_drift",))
    drifts = {f"{channel}_drift" for channel in ("contact", "sensitivity", "mounting")}
    assert {*heard.candidates} == {"season", *drifts}


def test_what_may_lie_on_a_sensor_stays_in_its_class(half_a_year):  # noqa: F811
    """Power says that it reads less for a while, and not that it is clean."""
    data, _ = with_change(half_a_year)
    data = witnessed(data, 0.0)
    start, end = DATES["episode"].values()
    data["poa_global"] /= 1.0 + 0.1 * ((data.index >= start) & (data.index < end))
    first = closed(data).findings[0]
    assert first.verdict is Verdict.CLASS
    assert first.candidates == ("sensitivity_episode", "snow", "soiling")
    assert any(one.opinion is Opinion.AGREES for one in first.witnesses)
    assert "a cleaning of the sensor" in first.why


def test_what_a_class_shares_with_the_model_is_not_fitted_twice():
    """Snow is in the model when an episode of the sensor is told beside snow."""
    data, _, (world, *_) = study_instruments.made(11001)
    loop = close_loop(data, check_units=False, **world.place)
    names = [effect.name for effect in loop.fit.effects]
    assert "snow" in names and len(names) == len({*names})


def test_a_change_that_a_witness_agrees_with_need_not_be_sure_in_a_refit():
    """Days of another cause may rule least squares; power knows nothing of them."""
    effect = dated("sensitivity_step")
    (key,) = effect.rows()
    some = np.zeros(4)
    model = SimpleNamespace(effects=(effect,), drivers=())
    step = SimpleNamespace(
        model=model, temperature=some, measured=some, at_bound=(), coefficients={key: 1}
    )
    whole = SimpleNamespace(known=lambda names: some == 0.0, dates=np.arange(4))
    case = SimpleNamespace(
        seen=some == 0.0, choosing=some > 0.0, whole=whole, criteria=Criteria()
    )
    power = Witness("p_dc", effect.name, 0.1, 0.01, 0.1, Opinion.AGREES, "-", 0.1, 0.2)
    asked = []
    for witnesses in ((), (power,), (replace(power, opinion=Opinion.CONTRADICTS),)):
        finding = Finding(
            *(effect.name, (effect.name,), Verdict.NAMED, 0.4, {key: 0.1}, {key: 0.1}),
            because(Reason.NO_DATE),
            witnesses=witnesses,
        )
        checks = refit_checks(finding, case, step, step, {key: 0.5})
        asked.append(["sure" in check.criterion for check, _ in checks])
    assert [any(one) for one in asked] == [True, False, True]
