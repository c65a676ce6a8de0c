"""Drivers that are computed: the laws of sun, sky, snow and storage."""

import numpy as np
import pandas as pd
import pvlib
import pytest
from pvlib.location import Location

from pvlib_fem import datasets, simulator
from pvlib_fem._record.column_names import GEOMETRY
from pvlib_fem._record.inputs import read
from pvlib_fem._statistics.axes import DRY
from pvlib_fem.drivers import (
    DERIVED,
    Driver,
    _lagged_inputs as memory,
    _sky_deficit as sky,
    _solar as solar,
    constants,
    derive_drivers,
    needed_for,
    snow_at_most,
    sun,
)
from pvlib_fem.effects import PHYSICS as EFFECTS

SITE = Location(35.0, -106.0)
#: of plane and site: (tilt, azimuth, latitude)
PLANES = [(35.0, 180.0, 35.0), (10.0, 90.0, 35.0), (60.0, 240.0, 50.0), (90, 180, 50)]
every_minute = pd.date_range("2023-03-01", periods=3000, freq="1min", tz="Etc/GMT+7")


def derived(columns, *names):
    return derive_drivers(read(columns), names)


def placed(data, tilt, azimuth, location=SITE):
    """The columns with the place of sun and module."""
    place = sun(data.index, location).assign(surface_tilt=tilt, surface_azimuth=azimuth)
    return {**{name: data[name] for name in data}, **{n: place[n] for n in GEOMETRY}}


def unit(zenith, azimuth):
    zenith, azimuth = np.radians(zenith), np.radians(azimuth)
    return np.array(
        [
            np.sin(zenith) * np.cos(azimuth),
            np.sin(zenith) * np.sin(azimuth),
            np.cos(zenith),
        ]
    )


@pytest.mark.parametrize("latitude", [-34.0, 0.0, 20.0, 52.0, 70.0])
@pytest.mark.parametrize("start", ["2020-06-19", "2023-12-20", "2031-03-20 12:00:13"])
def test_the_sun_is_where_pvlib_has_it(latitude, start):
    location = Location(latitude, 25.0)
    index = pd.date_range(start, periods=2000, freq="97s", tz="Europe/Athens")
    ours, theirs = sun(index, location), location.get_solarposition(index)
    apart = np.linalg.norm(
        unit(ours["solar_zenith"], ours["solar_azimuth"])
        - unit(theirs["zenith"], theirs["azimuth"]),
        axis=0,
    )
    assert np.degrees(apart).max() < 0.02
    assert ours["solar_azimuth"].between(0, 360).all()
    assert ours.index is index


@pytest.mark.parametrize("latitude", [-34.0, 0.0, 52.0])
def test_the_refracted_sun_is_where_pvlib_has_it(latitude):
    """Near the horizon the refraction of pvlib's two algorithms differs."""
    location = Location(latitude, 25.0)
    index = pd.date_range("2023-12-10", periods=4000, freq="97s", tz="UTC")
    theirs = location.get_solarposition(index)
    ours = sun(index, location, refraction=True)["solar_zenith"]
    apart = (ours - theirs["apparent_zenith"]).abs()
    above = theirs["zenith"] < 90.0
    assert apart[above].max() < 0.1 and apart.max() < 0.6


def test_the_sun_is_at_times_only():
    index = pd.DatetimeIndex(["2023-06-01 12:00", None])
    with pytest.raises(ValueError, match=r"index has no time \(NaT\) at row 1; drop"):
        sun(index, SITE)
    with pytest.raises(ValueError, match="index is empty; give at least one time"):
        sun(index[:0], SITE)
    with pytest.raises(TypeError, match="index is a RangeIndex; give the times as a"):
        sun(pd.RangeIndex(3), SITE)


def test_few_rows_over_many_years_have_a_sun():
    index = pd.DatetimeIndex(["1990-01-01 12:00", "2050-06-01 12:00"], tz="Etc/GMT+7")
    theirs = SITE.get_solarposition(index)["zenith"]
    np.testing.assert_allclose(sun(index, SITE)["solar_zenith"], theirs, atol=0.02)


@pytest.mark.parametrize(
    ("zone", "standard"),
    [
        (None, "Etc/GMT+7"),  # 106° west
        ("US/Central", "Etc/GMT+6"),  # though it is summer time in June
        ("Etc/GMT+8", "Etc/GMT+8"),
        ("Australia/Sydney", "Etc/GMT-10"),  # where it is summer time in January
        ("Europe/Dublin", "UTC"),  # where the law calls summer time the standard
    ],
)
def test_times_without_a_zone_are_local_standard_time(zone, standard):
    location = Location(35.0, -106.0, **({"tz": zone} if zone else {}))
    plain = pd.date_range("2023-06-01", periods=200, freq="10min")
    want = sun(plain.tz_localize(standard), location)
    np.testing.assert_allclose(sun(plain, location), want)


@pytest.mark.parametrize(("tilt", "azimuth", "latitude"), PLANES)
def test_incidence_and_its_slopes_are_pvlibs(tilt, azimuth, latitude):
    """Slopes against finite differences of pvlib's projection."""
    place = sun(every_minute, Location(latitude, -106.0))
    sun_at = place["solar_zenith"], place["solar_azimuth"]
    columns = dict(zip(GEOMETRY, (*sun_at, tilt, azimuth)))
    found = derive_drivers(read({**columns, "beam": 700.0}), ["beam_by_tilt"])
    found = derive_drivers(found, ["beam_by_azimuth"])
    projection = pvlib.irradiance.aoi_projection
    cosine = projection(tilt, azimuth, *sun_at)
    np.testing.assert_allclose(found["aoi_projection"], cosine, atol=1e-12)
    for name, step in (("beam_by_tilt", (1e-4, 0)), ("beam_by_azimuth", (0, 1e-4))):
        up, down = (
            projection(tilt + sign * step[0], azimuth + sign * step[1], *sun_at)
            for sign in (1, -1)
        )
        want = 700.0 * (up - down) / 2e-4 / np.maximum(cosine, 0.1)
        np.testing.assert_allclose(found[name], want, atol=1e-5)


@pytest.mark.parametrize(("tilt", "azimuth", "latitude"), PLANES)
def test_beam_is_told_from_irradiance_in_the_plane(tilt, azimuth, latitude):
    """On a made-up year; the ground there reflects 0.25, and 0.2 is assumed."""
    data = datasets.synthetic(
        365,
        900,
        start="2023-01-01",
        noise=0,
        latitude=latitude,
        surface_tilt=tilt,
        surface_azimuth=azimuth,
    )
    columns = placed(data, tilt, azimuth, Location(latitude, -106.0))
    found = derived(columns, "beam", "ghi_estimated")
    day = data["poa_global"].to_numpy() > 20.0
    for name, true in (
        ("beam", data["dni"].fillna(0) * np.maximum(found["aoi_projection"], 0)),
        ("ghi_estimated", data["ghi"]),
    ):
        ours, true = found[name][day], true.to_numpy()[day]
        if name == "beam" or tilt < 50:  # a steep plane does not see all the sky
            assert np.corrcoef(ours, true)[0, 1] > 0.99
            assert ours.mean() == pytest.approx(true.mean(), rel=0.05)
    assert (found["clearness"][~(data["poa_global"] > 0)] == 0).all()
    assert (found["beam"] <= data["poa_global"] + 1e-9).all()


def test_diffuse_share_is_erbs():
    """pvlib's, at a sun overhead whose extraterrestrial irradiance is known."""
    clearness = np.array([0.05, 0.2, 0.3, 0.5, 0.7, 0.79, 0.9])
    extra = pvlib.irradiance.get_extra_radiation(100)
    theirs = pvlib.irradiance.erbs(clearness * extra, 0.0, 100)
    np.testing.assert_allclose(
        solar.diffuse_share(theirs["kt"]), theirs["dhi"] / (clearness * extra)
    )


def test_clear_skies_have_the_emissivity_of_their_sources():
    """Worked by hand: 20 °C, and for Prata a vapour pressure of 11.68 hPa."""
    assert sky.moist_emissivity(50.0, 20.0) == pytest.approx(0.788, abs=5e-4)
    assert sky.moist_emissivity(0.0, 20.0) == pytest.approx(1 - np.exp(-(1.2**0.5)))
    lacking = sky.sky_deficit_air(np.array([20.0]), None)
    # Swinbank's own form, 5.31e-13 T^6 W/m²
    assert lacking == pytest.approx(
        5.670374e-8 * 293.15**4 - 5.31e-13 * 293.15**6, 2e-3
    )


@pytest.fixture(scope="module")
def rhine():
    """Two months of a simulated module with a sky by other formulas."""
    site = simulator.RHINE
    data = simulator.record(site, days=60, step=300, start="2023-04-01", seed=4)
    place = Location(site.latitude, site.longitude)
    return data, placed(data, site.surface_tilt, site.surface_azimuth, place)


def test_the_sky_is_known_better_from_humidity_and_sun(rhine):
    """Correlation with the measured deficit, in the order of the variants."""
    data, columns = rhine
    names = [
        name for effect in EFFECTS["sky_radiation"].forms for name in effect.drivers
    ]
    found = derived(columns, *names)
    true, *others = (found[name] for name in names)
    follow = [np.corrcoef(true, other)[0, 1] for other in others]
    assert follow == sorted(follow, reverse=True)
    assert follow[0] > 0.7
    night = data["poa_global"].to_numpy() < 1.0
    assert np.corrcoef(true[night], others[0][night])[0, 1] > 0.5
    assert others[0].mean() == pytest.approx(true.mean(), rel=0.25)


def test_clouds_of_the_day_last_through_the_night():
    index = pd.date_range("2023-06-01", periods=2 * 144, freq="10min", tz="Etc/GMT+7")
    place = sun(index, SITE)
    up = np.cos(np.radians(place["solar_zenith"]))
    columns = {"clearness": 0.3 * (up > 0), "solar_zenith": place["solar_zenith"]}
    share = derived(columns, "cloud_share")["cloud_share"]
    assert share[0] == 0.5  # nothing is known yet
    night = np.arange(144 - 12, 144 + 12)
    np.testing.assert_allclose(share[night], share[night[0]], atol=2e-3)
    # the sun of evening brings 0.68 when clear; of that 0.3 is 0.44, and 0.25 is all
    assert share[night[0]] == pytest.approx((1 - 0.44) / 0.75, abs=0.03)


@pytest.mark.parametrize("celsius", [3.0, 8.0, 25.0])
def test_snow_melts_by_degree_days(celsius):
    """A depth of 60 mm lasts 15 K d at 4 mm per K and day."""
    hours = np.arange(240)
    lying = snow_at_most(np.full(240, celsius), hours)
    np.testing.assert_allclose(lying, np.maximum(60 - celsius * (hours + 1) / 6, 0))


def test_snow_of_a_night_does_not_outlast_a_mild_day():
    """Nights of eight hours at -1 °C have up to 8 mm, and days of 8 °C melt 21 mm."""
    hours = np.arange(24 * 30)
    lying = snow_at_most(np.where(hours % 24 < 8, -1.0, 8.0), hours)[240:]
    assert lying.max() == 8.0
    assert (lying.reshape(-1, 24)[:, 14:] == 0.0).all()
    assert (snow_at_most(np.full(720, -1.0), hours) == 60.0).all()


def test_snow_may_have_fallen_in_hours_without_air_temperature():
    hours, air = np.arange(240), np.full(240, 10.0)
    air[100:110] = np.nan
    gap = np.isfinite(air)
    assert snow_at_most(air, hours)[99] == 0.0
    assert snow_at_most(air, hours)[109] == 10.0
    # a row that is missing is as an hour without a value
    np.testing.assert_allclose(
        snow_at_most(air[gap], hours[gap]), snow_at_most(air, hours)[gap]
    )


def test_snow_lies_from_its_fall_until_it_slides():
    """Six centimetres at night; at noon, above freezing, the sun lets it go."""
    index = pd.date_range("2023-01-10", periods=288, freq="10min")
    hour = np.arange(288) / 6.0
    columns = {
        "snow_depth": pd.Series(np.clip(2.0 * (hour - 3.0), 0.0, 6.0), index),
        "temp_air": pd.Series(np.where(hour < 33.0, -9.0, 1.0), index),
        "poa_global": pd.Series(np.where((hour % 24 > 8) & (hour % 24 < 16), 400, 0.0)),
    }
    columns["poa_global"].index = index
    cover = derived(columns, "snow_cover")["snow_cover"]
    assert (cover[hour < 3] == 0).all()
    assert (cover[(hour > 3.6) & (hour < 34)] == 1).all()  # -9 °C is below -400/80
    assert (cover[hour > 34.7] == 0).all()


def test_snow_on_the_ground_is_no_snowfall_after_a_gap_of_its_gauge():
    index = pd.date_range("2023-01-10", periods=288, freq="10min")
    depth = pd.Series(30.0, index)
    depth.iloc[100:103], depth.iloc[200:250] = np.nan, np.nan
    columns = {"snow_depth": depth, "temp_air": pd.Series(-5.0, index)}
    columns["poa_global"] = pd.Series(100.0, index)
    lying = derived(columns, "snow_cover")["snow_cover"]
    np.testing.assert_array_equal(np.isnan(lying), depth.isna())
    assert np.nanmax(lying) == 0.0
    fell = columns | {"snow_depth": depth + 10.0 * (index >= index[102])}
    cover = derived(fell, "snow_cover")["snow_cover"]
    assert (cover[:100] == 0.0).all() and (cover[103:200] == 1.0).all()


# pvlib 0.16 asks pandas in a way that pandas 3 warns of
@pytest.mark.filterwarnings("ignore:.*BaseOffset")
def test_snow_slides_by_parts_as_in_pvlib():
    """Of 30° it takes ten hours of sun, after an hour and a half in which none goes."""
    index = pd.date_range("2023-01-10", periods=4 * 144, freq="10min")
    hour = np.arange(len(index)) / 6.0
    fell = np.where((hour >= 3.0) & (hour < 6.0), 2.0 / 6.0, 0.0)
    sun = np.where((hour % 24 > 8) & (hour % 24 < 16), 400.0, 0.0)
    columns = {
        "snow_depth": pd.Series(np.cumsum(fell), index),
        "temp_air": pd.Series(np.where(hour < 33.0, -9.0, 1.0), index),
        "poa_global": pd.Series(sun, index),
    }
    found = derived(columns, "snow_left")
    ours = found["snow_cover"] + found["snow_left"]
    theirs = pvlib.snow.coverage_nrel(
        pd.Series(fell, index), columns["poa_global"], columns["temp_air"], 30.0
    )
    later = theirs.index >= index[36]  # while it falls all is covered by either
    assert np.abs(ours - theirs)[later].max() < 1.6 * 0.197 * 0.5
    assert ours[-1] == theirs.iloc[-1] == 0.0 and ours[hour == 40.0] > 0.3
    bare = derived(columns | {"snow_depth": columns["snow_depth"] / 10.0}, "snow_left")
    assert not bare["snow_left"].any()  # half a centimetre is no snow


@pytest.mark.parametrize("name", ["poa_stored_1h", "poa_stored_3h", "air_stored"])
def test_what_is_stored_vanishes_where_nothing_changes(name):
    _, column = DERIVED[name][0]
    index = pd.date_range("2023-01-01", periods=1440, freq="1min")
    steady = pd.Series(400.0, index)
    assert np.abs(derived({column: steady}, name)[name]).max() < 1e-9
    later = steady.where(np.arange(1440) < 720, 500.0)
    tau = 60.0 if name.endswith("1h") else 180.0
    want = -100.0 * np.exp(-np.arange(1, 721) / tau)
    np.testing.assert_allclose(derived({column: later}, name)[name][720:], want)


def test_water_follows_the_air_by_its_time_constant():
    """After a step as the kernel; before a year as at the same date a year later."""
    index = pd.date_range("2023-01-01", periods=500 * 24, freq="1h")
    steady = pd.Series(7.0, index)
    water = Driver("air_of_weeks", memory=8.0)
    same = derived({"temp_air": steady}, water)[water]
    np.testing.assert_allclose(same, 7.0)
    day = np.arange(len(index)) / 24.0
    later = steady.where(day < 450.0, 17.0)
    found = derived({"temp_air": later}, water)[water][day >= 450.0]
    want = 17.0 - 10.0 * np.exp(-(np.arange(len(found)) + 1.0) / 24.0 / 8.0)
    np.testing.assert_allclose(found, want)
    year = pd.Series(np.sin(2 * np.pi * day / 365.0), index)
    found = derived({"temp_air": year}, "air_of_weeks")["air_of_weeks"]
    again = found[365 * 24 :][: 100 * 24]
    np.testing.assert_allclose(found[: 100 * 24], again, atol=1e-3)
    lag = np.arctan(2 * np.pi * 16.0 / 365.0)
    lagged = np.cos(lag) * np.sin(2 * np.pi * day / 365.0 - lag)
    np.testing.assert_allclose(found, lagged, atol=1e-3)
    gap = year.where((day > 20.0) & (day != 100.0))
    some = derived({"temp_air": gap}, "air_of_weeks")["air_of_weeks"]
    assert np.array_equal(np.isnan(some), np.isnan(gap))
    np.testing.assert_allclose(some[day > 150.0], lagged[day > 150.0], atol=2e-3)


def test_hours_count_from_the_last_rain_up_to_three_days():
    """A record begins dry, and a gap of the gauge is no rain."""
    index = pd.date_range("2023-01-01", periods=6 * 24, freq="1h")
    rain = pd.Series(0.0, index)
    rain.iloc[30:33], rain.iloc[40] = 0.2, np.nan
    hours = derived({"precipitation": rain}, "hours_since_rain")["hours_since_rain"]
    assert constants("hours_since_rain") == {"longest": DRY} and DRY == 72.0
    assert (hours[:30] == 72.0).all() and (hours[30:33] == 0.0).all()
    np.testing.assert_allclose(hours[33:], np.minimum(np.arange(1, 112), 72.0))


def test_the_year_begins_in_january():
    index = pd.DatetimeIndex(["2023-01-01 00:00", "2023-07-02 12:00"])
    inputs = read({"poa_global": pd.Series(0.0, index)})
    np.testing.assert_allclose(memory.day_angle(inputs), [0, np.pi], atol=0.02)
    with pytest.raises(ValueError, match="have no DatetimeIndex; give them as Series"):
        memory.day_angle(read({"poa_global": np.zeros(3)}, step=60.0))


def test_what_is_missing_stays_missing(plant):
    """And nothing else: a row counts where all that was measured is there."""
    names = [*needed_for(DERIVED), "poa_global", "temp_air", "wind_speed"]
    holes = plant.assign(power_ac=0.9 * plant["power_dc"])[names].iloc[:3000]
    holes = holes.assign(temp_base=holes["temp_air"] + 5.0)
    for i in range(holes.shape[1]):
        holes.iloc[1200 + 10 * i : 1205 + 10 * i, i] = np.nan
    found = derived({name: holes[name] for name in holes}, *DERIVED)
    for name in DERIVED:
        behind = [n for n in holes if n in every_column_behind(name)]
        missing = holes[behind].isna().any(axis=1).to_numpy()
        there = np.isfinite(found[name])
        assert there[~missing].all(), name
        if {*behind} & {"power_dc", "power_ac"}:  # none in the dark is no gap
            missing = missing & (holes["poa_global"] > 50.0).to_numpy()
        if name not in (
            "days_since_rain",
            "hours_since_rain",
        ):  # no rain is known of rows without a gauge
            assert not there[missing].any(), name


def every_column_behind(name):
    if name not in DERIVED:
        return {name}
    return {c for n in DERIVED[name][0] for c in every_column_behind(n)}


def test_a_driver_behind_drivers_is_asked_for_by_what_is_measured():
    assert needed_for(["beam", "beam_by_tilt"]) == [
        "solar_zenith",
        "surface_tilt",
        "solar_azimuth",
        "surface_azimuth",
    ]
    assert needed_for(["temp_base", "wind_speed"]) == []


def test_shapes_are_functions_of_the_usual_columns_and_the_sun():
    for form in (form for effect in EFFECTS.values() for form in effect.forms):
        if form.confounder:
            assert set(needed_for(form.drivers)) <= set(GEOMETRY), form.name
            assert form.decided_by
