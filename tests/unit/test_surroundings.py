"""Causes that are in no catalogue: where, when and how large each is."""

from dataclasses import replace
from inspect import getdoc

import numpy as np
import pytest
from study_worlds import CLOSED, HEATS, PLACES, UNDECLARED, site

from pvlib_fem.effects import CHANGES, EFFECTS
from pvlib_fem.simulator import GENERATORS, PHYSICS, RHINE, measure, weather
from pvlib_fem.simulator._surroundings import (
    AIR,
    BACK,
    CONTACT,
    GLASS,
    LIGHT,
    READING,
    WIND,
    angular_distance,
    sum_of_laws,
)

LAWS = GLASS | BACK | LIGHT | AIR | WIND | READING | CONTACT


@pytest.fixture(scope="module", params=(3, 4))
def sky(request):
    return weather(RHINE, step=900.0, seed=request.param)


def made(name, sky):
    """The effect of a law, and the rows in which it acts."""
    found = np.asarray(LAWS[name](sky, RHINE), dtype=float)
    there = np.abs(found) > 1e-9
    assert there.any() and not there.all()
    return found, sky[there]


def since_sunrise(some, sky):
    """Hours since the last row without sun."""
    dark = sky.index.to_series().where(sky["elevation"] <= 0).ffill()
    return (some.index - dark[some.index]).dt.total_seconds() / 3600


def test_each_kind_has_one_law_and_half_of_them_are_closed():
    assert {*LAWS} == {*UNDECLARED, *CLOSED} - {*HEATS}
    assert len({*UNDECLARED, *CLOSED}) >= 12
    assert len(CLOSED) >= 6 and not {*UNDECLARED} & {*CLOSED}
    assert not {*LAWS} & {*EFFECTS, *CHANGES}
    assert all(getdoc(law) for law in LAWS.values())


# ---------------------------------------------------------------- where and when
def test_a_facade_mirrors_a_fifth_of_the_beam_from_a_part_of_the_sky(sky):
    found, some = made("reflection", sky)
    assert found[found > 0] == pytest.approx(0.2 * some["dni"])
    assert some["elevation"].max() - some["elevation"].min() < 30.0
    assert np.ptp(some["azimuth"]) < 60.0


def test_a_facade_south_of_the_equator_mirrors_the_sun_in_the_north():
    south = replace(RHINE, latitude=-RHINE.latitude, surface_azimuth=0.0)
    middles = []
    for seed in range(6):
        sky = weather(south, days=365, step=3600.0, seed=seed)
        there = LAWS["reflection"](sky, south) > 0
        middles.append(angular_distance(sky["azimuth"][there], 0.0).mean())
    assert max(middles) < 90.0


def test_a_plume_comes_with_wind_of_one_direction(sky):
    found, some = made("plume", sky)
    assert {*found} == {0.0, 50.0}
    middle = np.radians(some["wind_direction"])
    middle = np.degrees(np.arctan2(np.sin(middle).mean(), np.cos(middle).mean()))
    assert angular_distance(some["wind_direction"], middle).max() < 70.0


def test_puddles_cool_the_sun_from_the_first_rain_on_and_dry(sky):
    found, _ = made("puddles", sky)
    rain = sky["precipitation"].to_numpy() > 0
    assert not found[: np.argmax(rain)].any()
    lit, ghi = (sky["ghi"] > 1).to_numpy(), sky["ghi"].to_numpy()
    assert -found[lit & rain] == pytest.approx(0.1 * ghi[lit & rain])
    share = -found / np.where(lit, ghi, np.nan)
    dry = lit[1:] & lit[:-1] & ~rain[1:] & (share[:-1] > 0)
    assert dry.any() and (np.diff(share)[dry] < 0).all()


def test_a_sea_breeze_comes_on_warm_afternoons(sky):
    found, some = made("sea_breeze", sky)
    assert {*found} == {0.0, -3.0}
    assert {*some.index.month} <= {*range(4, 11)}
    assert {*some.index.hour} <= {*range(10, 21)}
    assert some["elevation"].max() > 40.0


def test_misters_need_heat_and_dry_air(sky):
    found, some = made("misters", sky)
    assert some["temp_air"].min() > RHINE.temp_mean
    dry = some["temp_air"] - some["temp_dew"]
    assert found[found < 0] == pytest.approx(-0.15 * dry)


def test_fog_dries_in_the_first_hours_of_sun(sky):
    found, some = made("fog", sky)
    assert found.min() >= -80.0
    assert since_sunrise(some, sky).max() <= 4.0
    humid = (sky["relative_humidity"] > 85.0).astype(float)
    dry = (humid.rolling(96).max() == 0.0).to_numpy()
    assert np.abs(found[dry]).max() < 80.0 * np.exp(-24 / 3)
    wet = (humid.rolling(48).min() == 1.0).to_numpy() & (found < 0)
    assert wet.any() and found[wet].max() < -70.0


def test_fans_follow_power_in_warm_air(sky):
    found, some = made("inverter_hall", sky)
    assert found.max() == 75.0
    assert some["temp_air"].min() > RHINE.temp_mean
    assert some["ghi"].min() > 0.0


def test_a_heap_cools_for_weeks_between_turns(sky):
    found = np.asarray(LAWS["compost"](sky, RHINE))
    assert 30.0 < found.max() < 60.0
    turned = np.flatnonzero((np.diff(found[1:]) > 0) & (np.diff(found[:-1]) <= 0))
    days = np.diff(turned) * 900.0 / 86400.0
    assert len(days) > 2 and days.min() >= 29.0 and days.max() <= 91.0


def test_lorries_are_there_on_workdays(sky):
    found, some = made("lorries", sky)
    assert {*found} == {0.0, 0.3}
    assert {*some.index.day_of_week} == {*range(5)}
    hours = some.groupby(some.index.date).size() / 4
    assert hours.min() > 7.5 and hours.max() < 11.5


def test_a_battery_charges_from_sunrise_for_longer_after_long_nights(sky):
    found, _ = made("charger", sky)
    assert 0.9 < found.max() <= 1.2
    some = sky[found > 0.6]
    assert since_sunrise(some, sky).max() < 24 * 0.35
    hours = some.groupby(some.index.month).size() / 4
    assert hours[1] > 1.3 * hours[7]


def test_a_frozen_contact_is_one_in_frost(sky):
    found, some = made("frozen_contact", sky)
    assert {*found} == {0.0, 0.2}
    assert some["temp_air"].max() < 4.0
    assert found[(sky["temp_air"] < 0).to_numpy()].min() == 0.2


# ---------------------------------------------------------------- size and chance
@pytest.mark.parametrize("name", LAWS)
def test_an_hour_of_the_night_is_long_enough(name):
    found = LAWS[name](weather(RHINE, days=1 / 24, step=600.0, seed=1), RHINE)
    assert np.isfinite(found).all() and len(found) == 6


@pytest.mark.parametrize("name", LAWS)
def test_a_law_is_the_same_for_a_seed_and_another_for_others(name):
    skies = [weather(RHINE, days=365, step=3600.0, seed=seed) for seed in (1, 1, 2)]
    other = skies[2].copy()
    other[:] = skies[0].to_numpy()  # the same weather, and chance of its own
    first, again, apart = (
        LAWS[name](one, RHINE) for one in (skies[0], skies[1], other)
    )
    assert np.array_equal(first, again)
    assert not np.array_equal(first, apart)


def test_laws_add_by_amplitude_and_are_nothing_where_off(sky):
    on = dict.fromkeys(LAWS, 0.0)
    assert sum_of_laws(BACK, sky, RHINE, on) == 0.0
    found = sum_of_laws(BACK, sky, RHINE, on | {"plume": 2.0, "compost": 0.5})
    alone = (LAWS[name](sky, RHINE) for name in ("plume", "compost"))
    assert found == pytest.approx(2.0 * next(alone) + 0.5 * next(alone))


@pytest.mark.parametrize("generator", GENERATORS)
@pytest.mark.parametrize("name", LAWS)
def test_a_year_of_it_is_of_a_size_that_matters(name, generator):
    """0.15 to 2 K RMS in the module's temperature, and no driver's sensor sees it."""
    where = site(21, **PLACES.get(name, {}))
    sky = weather(where, step=1800.0, seed=21)
    off, half, on = (
        measure(sky, GENERATORS[generator](sky, where, effects), where, effects)
        for size in (0.0, 0.5, 1.0)
        for effects in [PHYSICS | {name: size}]
    )
    change = (on - off)["temp_module"]
    assert 0.15 < np.sqrt((change**2).mean()) < 2.0
    less = (half - off)["temp_module"]
    slope = (less @ change) / (change @ change)
    assert slope == pytest.approx(0.5, abs=0.1)
    drivers = off.columns.drop(["temp_module", "p_dc_per_area"])
    assert on[drivers].equals(off[drivers])
