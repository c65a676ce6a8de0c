"""Expected power of a plant without its area, on simulated power of known truth."""

import json

import numpy as np
import pandas as pd
import pytest
from pvlib.location import Location

import pvlib_fem as fem
from pvlib_fem.power import PowerRelation, days_of, expected_power, fit_power

INDEX = pd.date_range("2021-01-01", periods=2 * 8760, freq="h", tz="Etc/GMT-1")


def weather():
    """Hourly irradiance and module temperature of two years."""
    random = np.random.default_rng(1)
    sky = Location(48.0, 11.0).get_clearsky(INDEX, model="haurwitz")["ghi"]
    light = sky * random.uniform(0.2, 1.0, len(INDEX))
    year = 2.0 * np.pi * INDEX.day_of_year / 365.25
    air = 10.0 - 10.0 * np.cos(year) + 4.0 * random.standard_normal(len(INDEX))
    return light, air + 0.03 * light


LIGHT, MODULE = weather()


def plant(scale=90.0, gamma=-0.0035, own=10.0, limit=np.inf, season=0.05, fade=0.0):
    """Power by PVWatts with a season, a fading plant and an inverter's limit."""
    year = 2.0 * np.pi * INDEX.day_of_year / 365.25
    years = np.arange(len(INDEX)) / 8766.0
    level = scale * np.exp(season * np.cos(year) - fade * years)
    whole = level * np.maximum(LIGHT - own, 0.0) * (1.0 + gamma * (MODULE - 25.0))
    return whole.clip(upper=limit)


def noisy(power, limit=np.inf, size=0.03):
    random = np.random.default_rng(2)
    loud = power * np.exp(size * random.standard_normal(len(power)))
    return loud.clip(upper=limit) * random.uniform(0.998, 1.002, len(power))


def broken(power, share, lowest=0.0, highest=0.9):
    """Power with so many days on which it is below its expectation."""
    random = np.random.default_rng(3)
    days = len(power) // 24
    bad = np.repeat(random.random(days) < share, 24)
    left = np.repeat(random.uniform(lowest, highest, days), 24)
    return power.where(~bad, left * power)


@pytest.mark.parametrize("share", [0.0, 0.3])
@pytest.mark.parametrize("unit", [1.0, 1e-3, 0.002])  # a plant in W, in kW, a module
def test_it_is_the_truth_whatever_the_unit_and_with_a_third_of_it_wrong(share, unit):
    truth = unit * plant()
    power = broken(noisy(truth), share)
    found = fit_power(LIGHT, MODULE, power)
    bright = LIGHT > 200.0
    expected = expected_power(LIGHT, MODULE, power)
    off = (expected / truth)[bright] - 1.0
    assert abs(off.mean()) < 0.005 and off.abs().quantile(0.95) < 0.015
    assert found.gamma == pytest.approx(-0.0035, abs=0.0004)
    assert found.own == pytest.approx(10.0, abs=2.0)
    assert found.spread == pytest.approx(0.03, rel=0.2)
    assert found.limit == np.inf


@pytest.mark.parametrize("gamma", [-0.0025, -0.0045])
def test_the_temperature_coefficient_is_that_of_the_modules(gamma):
    found = fit_power(LIGHT, MODULE, noisy(plant(gamma=gamma)))
    assert found.gamma == pytest.approx(gamma, abs=0.0004)


def test_outages_of_one_kind_do_not_move_it():
    """Half of a plant that is off for a third of the days is near to none of it."""
    truth = plant()
    found = expected_power(LIGHT, MODULE, broken(noisy(truth), 0.3, 0.5, 0.5))
    assert (found / truth)[LIGHT > 200.0].median() == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("limit", [45e3, 60e3])
def test_a_limit_is_found_and_the_scale_is_that_below_it(limit):
    truth = plant(limit=limit)
    power = broken(noisy(plant(), limit), 0.2)
    found = fit_power(LIGHT, MODULE, power)
    assert found.limit == pytest.approx(limit, rel=0.005)
    expected = found.expected(LIGHT, MODULE, days_of(INDEX))
    off = (expected / truth)[LIGHT > 200.0] - 1.0
    assert abs(off.mean()) < 0.01 and off.abs().quantile(0.95) < 0.03


def test_what_a_plant_never_reaches_is_no_limit():
    assert fit_power(LIGHT, MODULE, noisy(plant(limit=95e3))).limit == np.inf


def test_a_plant_that_fades_is_followed_from_year_to_year():
    found = fit_power(LIGHT, MODULE, noisy(plant(fade=0.03)))
    assert found.levels[-1] - found.levels[0] == pytest.approx(-0.06, abs=0.01)


def test_a_stretch_of_nothing_is_no_level():
    """Five weeks of outage do not change the expectation of these weeks."""
    truth = plant()
    power = noisy(truth)
    power["2021-04-14":"2021-05-20"] = 0.0
    found = expected_power(LIGHT, MODULE, power)["2021-04-14":"2021-05-20"]
    ratio = (found / truth)[LIGHT > 200.0]
    assert ratio.median() == pytest.approx(1.0, abs=0.01)


def test_rows_without_a_value_have_no_expectation_and_change_nothing():
    power = noisy(plant())
    some = power.where(LIGHT > 20.0)  # nothing is logged in the dark
    light = LIGHT.where(np.arange(len(LIGHT)) % 7 > 0)
    found = expected_power(light, MODULE, some)
    assert found.isna().equals(light.isna())
    pd.testing.assert_series_equal(
        expected_power(LIGHT, MODULE, some), expected_power(LIGHT, MODULE, power)
    )


def test_a_file_keeps_it():
    power = noisy(plant(limit=60e3), 60e3)
    for relation in (fit_power(LIGHT, MODULE, power), fit_power(LIGHT, MODULE, LIGHT)):
        content = json.loads(json.dumps(relation.content(), allow_nan=False))
        assert PowerRelation.stored(content) == relation


def test_power_without_noise_and_of_the_usual_coefficient_is_expected_as_it_is():
    """As a modelled plant has it; half of its rows are off its level by 0."""
    power = plant(gamma=-0.004, own=0.0, season=0.0)
    found = fit_power(LIGHT, MODULE, power)
    assert found.gamma == pytest.approx(-0.004) and found.nominal == pytest.approx(9e4)
    expected = expected_power(LIGHT, MODULE, power)
    np.testing.assert_allclose(expected, power, rtol=1e-6, atol=1e-6)


def test_power_that_is_stuck_is_no_plant():
    stuck = pd.Series(300.0, INDEX).where(LIGHT > 0.0, 0.0)
    with pytest.raises(ValueError, match="below 300, at which it stays, in 0 rows"):
        fit_power(LIGHT, MODULE, stuck)


def test_too_few_rows_are_refused_by_name():
    with pytest.raises(ValueError, match="power is there in 3 rows above 100 W/m²"):
        power = plant()
        power[LIGHT[LIGHT > 200.0].index[3:]] = np.nan
        power[LIGHT <= 200.0] = np.nan
        fit_power(LIGHT, MODULE, power)
    with pytest.raises(ValueError, match=r"in \d+ rows it is negative: turn its sign"):
        fit_power(LIGHT, MODULE, -plant())
    with pytest.raises(ValueError, match="power has no DatetimeIndex; give it as a"):
        expected_power(LIGHT, MODULE, plant().to_numpy())
    with pytest.raises(ValueError, match="DatetimeIndex"):
        fit_power(*(s.reset_index(drop=True) for s in (LIGHT, MODULE, plant())))


def test_dc_power_of_simulated_physics_agrees_within_its_spread():
    """Fresnel reflection, dim light and a slow cell: physics that no term has."""
    data = fem.simulator.record(effects=fem.simulator.PHYSICS, days=400, step=1800)
    columns = data["poa_global"], data["temp_module"], data["p_dc_per_area"]
    ratio = (columns[2] / expected_power(*columns))[columns[0] > 100.0]
    assert ratio.median() == pytest.approx(1.0, abs=0.01)
    assert ((ratio < 0.8) | (ratio > 1.2)).mean() < 0.02
