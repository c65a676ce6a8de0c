"""The simulator's rival laws by hand, published numbers and pvlib; its chance."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pvlib
import pytest
from scipy.special import erf

from pvlib_fem.simulator import (
    ALBUQUERQUE,
    PHYSICS,
    RHINE,
    RIVALS,
    Days,
    Forms,
    Minutes,
    Obstacle,
    Site,
    drawn,
    fuentes,
    measure,
    record,
    records,
    simulate,
    weather,
)
from pvlib_fem.simulator._air import EMISSIVITIES, VAPOUR, diffuse_share, vapour
from pvlib_fem.simulator._convection import (
    CONDUCTIVITY,
    FORCED,
    LENGTH,
    NATURAL,
    RAYLEIGH,
)
from pvlib_fem.simulator._deposits import COVER, DIRT, dirt, snow_cover
from pvlib_fem.simulator._ground import blocked_share, sky_diffuse
from pvlib_fem.simulator._schedules import undeclared_heat
from pvlib_fem.simulator._switches import amplitudes


def at(**forms):
    return replace(RHINE, forms=Forms(**forms))


def hourly(days=40, **columns):
    """An hourly sky with only the columns that are used."""
    times = pd.date_range("2023-01-01 01:00", periods=24 * days, freq="h", tz=RHINE.tz)
    usual = dict(precipitation=0.0, temp_air=10.0, ghi=0.0)
    return pd.DataFrame(usual | columns, index=times)


def suns(azimuth, elevation):
    return pd.DataFrame({"azimuth": azimuth, "elevation": elevation}, dtype=float)


# ---------------------------------------------------------------- names
def test_every_name_has_its_law():
    laws = dict(cleaning=DIRT, vapour=VAPOUR, emissivity=EMISSIVITIES)
    laws |= dict(natural=NATURAL, forced=FORCED, snow=COVER)
    for name, registry in laws.items():
        assert tuple(registry) == RIVALS[name]
    assert {*RIVALS} == {*laws, "diffuse", "transposition"}
    assert all(hasattr(pvlib.irradiance, name) for name in RIVALS["diffuse"])


@pytest.mark.parametrize(
    "wrong, message",
    [
        (dict(cleaning="wind"), "cleaning = 'wind'; it is one of 'rain', 'kimber'"),
        (dict(forced="tarp"), "forced = 'tarp'; it is one of 'mowitt'"),
        (dict(washed_by=(0.0, 3.0)), r"washed_by = \(0.0, 3.0\); give mm and hours"),
        (dict(calm_excess=0.0), "calm_excess = 0.0 must be from 1.0 to 60.0"),
        (dict(obstacles=(3,)), "3 is no Obstacle; give its azimuth, width, heights"),
        (dict(obstacles=({"covers": 2.0},)), "covers = 2.0 must be from 0.0 to 1.0"),
        (dict(obstacles=({"heights": ()},)), "heights = .. of an obstacle; give one"),
        (dict(watering={"every": 0}), "every = 0 must be from 1 to 366"),
        (dict(fan={"on": 9.0, "period": 5.0}), "on = 9.0 must be from 0.0 to 5.0"),
    ],
)
def test_what_cannot_be_is_refused_by_name(wrong, message):
    with pytest.raises(ValueError, match=message):
        Forms(**wrong)


# ---------------------------------------------------------------- air and light
@pytest.mark.parametrize("form", RIVALS["vapour"])
@pytest.mark.parametrize("celsius, pascal", [(0, 611.2), (20, 2339.3), (30, 4246.9)])
def test_saturation_is_that_of_steam_tables(form, celsius, pascal):
    # a constant latent heat is known to be some per cent off in warm air
    off = 0.03 if form == "clausius_clapeyron" else 0.004
    assert vapour(celsius, form) == pytest.approx(pascal, rel=off)


@pytest.mark.parametrize(
    "form, value",
    [
        ("berdahl_martin", 0.711 + 0.0392 + 0.003577 - 0.013),
        ("brunt", 0.52 + 0.065 * 3.16228),
        ("brutsaert", 1.24 * 0.61719),
        ("prata", 1 - 2.58622 * 0.087070),
        ("idso_jackson", 1 - 0.261 * 0.73286),
    ],
)
def test_emissivity_at_noon_by_hand(form, value):
    """20 °C, 7 °C of dew point, 10 hPa."""
    assert EMISSIVITIES[form](20.0, 7.0, 1000.0, 12.0) == pytest.approx(value, abs=1e-4)


@pytest.mark.parametrize(
    "form, share",
    [
        ("erbs", 0.65915),
        ("orgill_hollands", 1.557 - 1.84 * 0.5),
        ("boland", 1 / (1 + np.exp(8.645 * (0.5 - 0.613)))),
        ("erbs_driesse", 0.659),
    ],
)
def test_diffuse_share_at_a_clearness_of_a_half(form, share):
    ghi = np.array([0.0, 0.5 * 1361.0 * np.sin(np.radians(45))])
    found = diffuse_share(form, ghi, np.array([-5.0, 45.0]))
    assert found == pytest.approx([1.0, share], abs=2e-3)


@pytest.fixture(scope="module")
def noon():
    return pd.DataFrame(
        dict(elevation=40.0, azimuth=200.0, dni=700.0, dhi=120.0, cloud=0.0),
        index=pd.date_range("2023-04-01", periods=2, freq="h"),
    ).assign(ghi=120.0 + 700.0 * np.sin(np.radians(40.0)))


def test_the_sky_on_a_tilted_plane_by_hand(noon):
    tilt, up = np.radians(35.0), np.radians(40.0)
    aoi = np.sin(up) * np.cos(tilt)
    aoi += np.cos(up) * np.sin(tilt) * np.cos(np.radians(20.0))
    ghi, even, half = noon["ghi"].iloc[0], (1 + np.cos(tilt)) / 2, np.sin(tilt / 2) ** 3
    round_sun = 700.0 / 1361.0
    davies = 120 * (round_sun * aoi / np.sin(up) + (1 - round_sun) * even)
    brighter = np.sqrt(700 * np.sin(up) / ghi) * half
    clear = 1 - (120 / ghi) ** 2
    hand = {
        "isotropic": 120 * even,
        "haydavies": davies,
        "reindl": davies + 120 * (1 - round_sun) * even * brighter,
        "klucher": 120
        * even
        * (1 + clear * half)
        * (1 + clear * aoi**2 * np.cos(up) ** 3),
        "perez-driesse": pvlib.irradiance.perez_driesse(
            35, 180, 120, 700, 1361.0, 50, 200
        ),
    }
    assert {*hand} == {*RIVALS["transposition"]}
    for form, value in hand.items():
        assert sky_diffuse(form, noon, 35.0, 180.0)[0] == pytest.approx(value), form


@pytest.mark.parametrize("form", sorted({*RIVALS["transposition"]} - {"klucher"}))
def test_a_level_plane_gets_the_light_that_falls(form, noon):
    # Klucher's sky is brighter round the sun, and nowhere darker for it
    assert sky_diffuse(form, noon, 0.0, 180.0) == pytest.approx([120.0, 120.0])


# ---------------------------------------------------------------- convection
def test_churchill_and_chu_have_incroperas_example():
    """Ra = 1.813e9 and Pr = 0.690 give Nu = 147 (example 9.2)."""
    excess = np.full((2, 1), 1.813e9 / (RAYLEIGH * LENGTH**3))
    nusselt = NATURAL["churchill_chu"](90.0)(excess) * LENGTH / CONDUCTIVITY
    assert nusselt == pytest.approx(147.0, rel=0.01)


def test_mcadams_is_near_his_short_forms_for_air():
    """1.52 ΔT^(1/3) upwards and 0.59 (ΔT/L)^(1/4) downwards, in W/(m² K)."""
    up, down = NATURAL["mcadams"](0.0)(np.full((2, 1), 20.0))[:, 0]
    assert up == pytest.approx(1.52 * 20 ** (1 / 3), rel=0.2)
    assert down == pytest.approx(0.59 * 20**0.25, rel=0.2)


@pytest.mark.parametrize("form", RIVALS["natural"])
def test_natural_convection_knows_up_from_down_and_ends_at_no_excess(form):
    law = NATURAL[form](30.0)
    warm, cold = (law(np.full((2, 1), sign * 10.0)) for sign in (1, -1))
    assert warm[0] == pytest.approx(cold[1])  # warm above is as cold below
    assert warm[1] == pytest.approx(cold[0])
    assert warm[0] >= warm[1]
    assert (law(np.zeros((2, 1))) < 0.05).all()


@pytest.mark.parametrize(
    "form, at_five",
    [
        ("mowitt", (3.26 * 5**0.89 + 3.55 * 5**0.617) / 2),
        ("flat_plate", 0.037 * 503461**0.8 * 0.8909 * 0.0263 / 1.6),
        ("sparrow", 0.86 * np.sqrt(387278) * 0.8909 * 0.0263 / 1.23077),
        ("watmuff", 15.0),
    ],
)
def test_forced_convection_in_five_metres_a_second_by_hand(form, at_five):
    assert FORCED[form](5.0, 0.5) == pytest.approx(at_five, rel=1e-3)
    assert FORCED[form](0.0, 0.5) == 0.0


# ---------------------------------------------------------------- dirt and snow
@pytest.fixture(scope="module")
def shower():
    """Twenty dry days, 7 mm within an hour, and twenty dry days."""
    sky = hourly()
    sky.iloc[480, sky.columns.get_loc("precipitation")] = 7.0
    return sky


@pytest.mark.parametrize(
    "forms, before, after",
    [
        (dict(), 0.06, 0.0596),  # 3 h hold the shower for 3 h
        (dict(washed_by=(6.9, 1.0)), 0.06, 0.06),
        (dict(washed_by=(7.1, 24.0)), 0.06, 0.12),
        (dict(cleaning="kimber"), 0.06, 0.003 * 5),  # 14 days from when 24 h end
    ],
)
def test_dirt_of_a_day_by_day_law(forms, before, after, shower):
    lost = dirt(shower, at(**forms))
    assert lost[479] == pytest.approx(before, abs=2e-4)
    assert lost[-1] == pytest.approx(after, abs=2e-4)


def test_dirt_that_settles(shower):
    mass = (60e-6 * 0.0009 + 140e-6 * 0.004) * 86400 * 20 * np.cos(np.radians(35))
    lost = dirt(shower, at(cleaning="hsu"))
    assert lost[479] == pytest.approx(0.3437 * erf(0.17 * mass**0.8473), rel=1e-3)
    assert lost[480] == 0.0
    assert lost[-1] == pytest.approx(lost[479], rel=0.01)


def test_kimber_and_hsu_are_pvlibs(shower):
    fallen = shower["precipitation"].tz_localize(None)
    theirs = pvlib.soiling.kimber(fallen, soiling_loss_rate=0.003, max_soiling=0.15)
    assert dirt(shower, at(cleaning="kimber")) == pytest.approx(theirs.to_numpy())
    theirs = 1 - pvlib.soiling.hsu(fallen, 1.0, 35.0, 60e-6, 200e-6)
    assert dirt(shower, at(cleaning="hsu")) == pytest.approx(theirs.to_numpy())


@pytest.fixture(scope="module")
def thaw():
    """5 mm of snow in an hour, a night below zero, then 300 W/m² at 0 °C."""
    sky = hourly(2, temp_air=-5.0)
    sky.iloc[1, sky.columns.get_loc("precipitation")] = 5.0
    sky.iloc[12:24, sky.columns.get_loc("ghi")] = 300.0
    sky.iloc[12:24, sky.columns.get_loc("temp_air")] = 0.0
    return sky


def test_snow_melts_by_the_heat_that_it_takes(thaw):
    left = 5.0 - np.arange(1, 13) * 3600 * 0.35 * 300 / 3.34e5  # mm
    found = snow_cover(thaw, at(snow="melting"))
    assert (found[1:12] == 1.0).all()
    assert found[12:24] == pytest.approx(np.clip(left, 0, 1))
    assert found[24:].max() < 1e-12


def test_snow_slides_off_and_stays_in_the_dark(thaw):
    found = snow_cover(thaw, at(snow="sliding"))
    assert found[1:12].all() and not found[15:].any()


def test_snow_that_slides_by_parts_is_pvlibs(thaw):
    found = snow_cover(thaw, at(snow="coverage_nrel"))
    a_tenth_and_more = 0.197 * np.sin(np.radians(35))  # of all, in an hour
    assert found[1:12] == pytest.approx(1.0)
    assert found[12:16] == pytest.approx(1 - a_tenth_and_more * np.arange(1, 5))


# ---------------------------------------------------------------- obstacles
def test_an_obstacle_is_dark_below_its_ragged_edge():
    one = Obstacle(100.0, 20.0, (10.0, 30.0, 10.0), covers=0.7)
    sky = suns([100, 100, 95, 95, 89, 111], [29, 31, 19, 21, 5, 5])
    assert blocked_share(sky, [one]) == pytest.approx([0.7, 0.0, 0.7, 0.0, 0.0, 0.0])


def test_a_penumbra_is_half_dark_at_the_edge():
    one = Obstacle(100.0, 40.0, (20.0,), covers=0.8, blur=4.0)
    sky = suns([100] * 5, [17, 19, 20, 21, 23])
    assert blocked_share(sky, [one]) == pytest.approx([0.8, 0.6, 0.4, 0.2, 0.0])


def test_obstacles_stand_across_north_and_do_not_add():
    some = [Obstacle(0.0, 20.0, (30.0,), 0.5), Obstacle(5.0, 20.0, (30.0,), 0.7)]
    found = blocked_share(suns([352, 359, 12, 20], [5] * 4), some)
    assert found == pytest.approx([0.5, 0.7, 0.7, 0.0])


# ---------------------------------------------------------------- timetables
def test_a_timetable_of_days_is_on_one_of_every_few():
    times = pd.date_range("2024-05-01", periods=24 * 90, freq="h", tz=RHINE.tz)
    forms = Forms(watering=Days(5, 2, ((3.0, 8.0),)))
    heat, _ = undeclared_heat(
        times, np.zeros(len(times)), amplitudes({"irrigation": 1}), forms
    )
    wet = times[heat < 0].tz_localize(None)
    assert {*wet.hour} == {3, 4, 5, 6, 7}
    days = wet.normalize().unique()
    assert {*np.diff(days).astype("timedelta64[D]").astype(int)} == {5}
    assert (days[0] - pd.Timestamp("1970-01-01")).days % 5 == 2


def test_a_timetable_of_minutes_knows_no_day():
    times = pd.date_range("2023-01-01", periods=150 * 96, freq="min", tz=RHINE.tz)
    forms = Forms(fan=Minutes(35, 150, 10))
    on = amplitudes({"fan": 1.0})
    _, heat = undeclared_heat(times, np.zeros(len(times)), on, forms)
    assert heat.mean() == pytest.approx(100 * 35 / 150)
    begins = np.flatnonzero(np.diff(heat) > 0)
    assert (np.diff(begins) == 150).all()
    by_hour = pd.Series(heat).groupby(times.hour).mean()
    assert by_hour.std() < 0.25 * by_hour.mean()  # ten days hold little of it


# ---------------------------------------------------------------- chance
def test_the_draw_has_every_rival_and_is_the_same_for_a_seed():
    some = [drawn(seed) for seed in range(150)]
    for name, rivals in RIVALS.items():
        assert {getattr(forms, name) for forms in some} == {*rivals}
    assert {forms.watering.every for forms in some} == {*range(2, 10)}
    assert {len(forms.obstacles) for forms in some} == {1, 2, 3}
    assert all(1440 % forms.fan.period for forms in some)
    edges = {one.blur == 0 for forms in some for one in forms.obstacles}
    assert edges == {True, False}
    assert some[:5] == [drawn(seed) for seed in range(5)]
    assert len({*map(str, some)}) == 150


@pytest.mark.parametrize("seed", range(6))
def test_a_drawn_obstacle_stands_before_the_sun(seed):
    site = (RHINE, ALBUQUERQUE)[seed % 2]
    sky = weather(site, step=900.0, seed=1)
    obstacles = drawn(seed, site).obstacles
    assert obstacles
    for one in obstacles:
        day = sky["elevation"] > 0
        assert (blocked_share(sky, [one])[day] > 0).mean() > 0.003


def test_same_forms_same_bits_and_the_default_is_the_sites():
    made = dict(days=3, step=300.0, seed=3)
    first, again = (record(forms=drawn(4), **made) for _ in range(2))
    pd.testing.assert_frame_equal(first, again, check_exact=True)
    pd.testing.assert_frame_equal(record(forms=Forms(), **made), record(**made))
    site = replace(RHINE, forms=drawn(4))
    pd.testing.assert_frame_equal(record(site, **made), first)


def test_the_formulation_travels_with_the_record():
    data = record(forms=drawn(5), days=1, step=600.0)
    truth = json.loads(json.dumps(data.attrs["site"]))
    assert Site(**truth) == replace(RHINE, forms=drawn(5))


@pytest.mark.parametrize("name", RIVALS)
def test_each_rival_makes_a_record_of_its_own(name):
    cold = replace(RHINE, latitude=52.0, temp_mean=0.0)
    on = PHYSICS | dict.fromkeys(["sky_radiation", "dew", "snow", "soiling"], 1.0)
    made = [
        record(cold, on, 60, 600.0, 1, forms=Forms(**{name: rival}), noise=0)
        for rival in RIVALS[name]
    ]
    columns = made[0].columns.drop(["p_dc_per_area", "snow_depth"])
    for i, one in enumerate(made):
        assert one.notna().all(axis=None)
        for other in made[:i]:
            assert (one[columns] - other[columns]).abs().max().max() > 1e-3


# ---------------------------------------------------------------- second generator
ROOF = Site(mounting="roof", surface_tilt=20.0)


@pytest.fixture(scope="module")
def days():
    return weather(RHINE, days=10, step=600.0, start="2023-05-01", seed=2)


@pytest.mark.parametrize("site, noct", [(RHINE, 45.0), (ROOF, 49.0)])
def test_the_second_generator_is_pvlibs(site, noct, days):
    truth = fuentes(days, site, PHYSICS)
    theirs = pvlib.temperature.fuentes(
        truth["poa_global"],
        days["temp_air"],
        0.85 * days["wind_speed"],  # as it is at the module
        noct,
        module_height=9.144,
        surface_tilt=site.surface_tilt,
    )
    assert (truth["temp_back"] - theirs).abs().max() < 0.01
    data = measure(days, truth, site, PHYSICS, noise=0)
    apart = (truth["temp_back"] - data["temp_module"]).abs()
    assert apart.quantile(0.5) < 0.2  # but for the sensor's 40 s


def test_heats_are_irradiance_of_as_much_heat(days):
    off, on = (
        fuentes(days, RHINE, PHYSICS | effects)["poa_global"]
        for effects in ({}, {"weekend_exhaust": 1.0})
    )
    weekend = (days.index.day_of_week >= 5) & (days.index.hour >= 9)
    weekend &= days.index.hour < 16
    assert (on - off)[weekend].to_numpy() == pytest.approx(120 / 0.83)
    assert (on - off)[~weekend].abs().max() == 0.0


def test_what_is_not_taken_as_power_is_heat(days):
    sky = weather(ALBUQUERQUE, days=40, step=600.0, start="2023-04-01", seed=4)
    off, on = (
        fuentes(sky, ALBUQUERQUE, PHYSICS | {"conversion": 0.0, "electrical_output": x})
        for x in (0.0, 1.0)
    )
    taken, gained = (
        off["p_dc_per_area"] - on["p_dc_per_area"],
        on["poa_global"] - off["poa_global"],
    )
    assert taken.max() > 100
    assert 0.83 * gained.to_numpy() == pytest.approx(taken.to_numpy(), abs=1e-9)


LIGHTS = ["shading", "soiling", "season", "rear_irradiance", "fan", "incidence_angle"]


@pytest.mark.parametrize("switch", LIGHTS)
def test_what_acts_on_the_light_acts_in_the_second_generator(switch, days):
    site = at(obstacles=(Obstacle(90.0, 60.0, (30.0,)),))  # of a sun in May
    off, on = (
        fuentes(days, site, PHYSICS | {switch: x})["temp_back"] for x in (0.0, 1.0)
    )
    assert (on - off).abs().max() > 0.3


def test_sensors_see_both_generators_alike():
    faults = {"soiling_sensor": 1.0, "clock_shift": 5.0, "air_shield": 1.0}
    first, second = (
        record(effects=PHYSICS | faults, days=3, step=300.0, generator=name)
        for name in ("nodes", "fuentes")
    )
    assert second.attrs["generator"] == "fuentes"
    same = ["poa_global", "temp_air", "wind_speed"]
    pd.testing.assert_frame_equal(first[same], second[same])
    excess = (first["temp_module"] - second["temp_module"])[12:]
    assert 0.1 < excess.std() < 5.0  # two models of one module


@pytest.mark.parametrize(
    "effects, named",
    [
        (PHYSICS | {"rain": 1.0, "dew": 1.0}, "rain, dew"),
        (PHYSICS | {"sky_radiation": 1.0}, "sky_radiation"),
        (PHYSICS | {"wind_direction": 1.0}, "wind_direction"),
        (PHYSICS | {"thermal_storage": 1.0}, "thermal_storage"),
        (PHYSICS | {"wind_shape": 0.0}, "wind_shape"),
    ],
)
def test_what_it_cannot_follow_is_refused(effects, named):
    with pytest.raises(ValueError, match=f"fuentes cannot follow {named}; set"):
        next(records(RHINE, [effects], 1, 600.0, generator="fuentes"))
    with pytest.raises(ValueError, match="generator = 'x'; it is 'nodes' or 'fuentes'"):
        next(records(RHINE, [PHYSICS], 1, 600.0, generator="x"))


def test_natural_convection_off_stands_where_the_form_says():
    """Its excess is a choice, and the light that makes it is not."""
    sky = weather(RHINE, days=4, step=600.0, start="2023-06-01", seed=1)
    calm, lively = (
        simulate(sky, at(calm_excess=k), PHYSICS | {"natural_convection": 0.0})
        for k in (8.0, 25.0)
    )
    assert (lively["h_front"] > calm["h_front"]).all()
