"""The plane of an irradiance sensor from its clear days."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import study_worlds
from pvlib.location import Location

import pvlib_fem as fem
from pvlib_fem.quality._plane import Plane, plane_of

SITE = fem.simulator.RHINE


def apart(one, other):
    """Degrees between two directions."""
    return abs((one - other + 180.0) % 360.0 - 180.0)


@pytest.mark.parametrize(
    ("tilt", "azimuth", "latitude", "seed"),
    [(35.0, 180.0, 49.4, 1), (20.0, 215.0, 37.0, 2), (40.0, 120.0, 44.0, 3)],
)
def test_a_plane_is_found_within_its_error(tilt, azimuth, latitude, seed):
    """Of clear days of a simulated sky, which is not the one that is compared."""
    site = replace(SITE, surface_tilt=tilt, surface_azimuth=azimuth, latitude=latitude)
    data = fem.simulator.record(
        site, effects=fem.simulator.PHYSICS, days=365, step=1800, seed=seed
    )
    place = Location(latitude, site.longitude, tz=site.tz)
    found = plane_of(data["poa_global"], data.index, place)
    assert abs(found.surface_tilt - tilt) < 2.0 * found.tilt_error
    assert apart(found.surface_azimuth, azimuth) < 2.0 * found.azimuth_error
    assert 5.0 <= found.tilt_error <= 8.0


def test_south_of_the_equator_it_faces_north():
    index = pd.date_range("2023-01-01", periods=365 * 48, freq="30min", tz="Etc/GMT-10")
    place = Location(-33.0, 150.0, tz="Etc/GMT-10")
    clear = place.get_clearsky(index, model="haurwitz")["ghi"].to_numpy()
    zenith = np.radians(place.get_solarposition(index)["zenith"].to_numpy())
    turn = np.radians(place.get_solarposition(index)["azimuth"].to_numpy())
    tilt = np.radians(25.0)
    ahead = np.cos(zenith) * np.cos(tilt) + np.sin(zenith) * np.sin(tilt) * np.cos(turn)
    up = np.maximum(np.cos(zenith), 0.05)
    poa = clear * (0.85 * np.maximum(ahead, 0.0) / up + 0.15)
    found = plane_of(poa, index, place)
    assert apart(found.surface_azimuth, 0.0) < 2.0 * found.azimuth_error
    assert abs(found.surface_tilt - 25.0) < 2.0 * found.tilt_error


def test_of_a_short_or_a_grey_record_nothing_is_known():
    data = fem.simulator.record(SITE, effects=fem.simulator.PHYSICS, days=40, step=1800)
    place = Location(SITE.latitude, SITE.longitude, tz=SITE.tz)
    assert plane_of(data["poa_global"], data.index, place) is None
    year = pd.date_range("2023-01-01", periods=365 * 24, freq="1h", tz=SITE.tz)
    noise = np.random.default_rng(1).uniform(0.0, 600.0, len(year))
    assert plane_of(noise, year, place) is None


def test_the_loop_says_that_its_plane_is_estimated_and_names_no_obstacle():
    data = fem.simulator.record(
        SITE, effects=fem.simulator.PHYSICS, days=200, step=1800, start="2023-03-01"
    ).drop(columns="p_dc_per_area")
    place = Location(SITE.latitude, SITE.longitude, tz=SITE.tz)
    loop = fem.close_loop(data, location=place)
    assert any("plane is estimated: tilt" in note for note in loop.notes)
    assert "angles of the plane are estimated" in str(loop.untestable["shading"])
    assert abs(loop.place["surface_tilt"] - SITE.surface_tilt) < 10.0
    given = fem.close_loop(data, location=place, surface_tilt=35, surface_azimuth=180)
    assert not any("estimated" in note for note in given.notes)


@pytest.mark.parametrize("latitude", [49.4, 15.0])
def test_a_latitude_with_the_wrong_sign_is_told(latitude):
    """Its days are short where those of the file are long; no effect by the sun is."""
    site = replace(SITE, latitude=latitude)
    data = fem.simulator.record(
        site, effects=fem.simulator.PHYSICS, days=300, step=900, start="2023-03-01"
    )
    right, wrong = (
        fem.close_loop(
            data,
            location=Location(sign * latitude, site.longitude, tz=site.tz),
            surface_tilt=site.surface_tilt,
            surface_azimuth=site.surface_azimuth,
        )
        for sign in (1.0, -1.0)
    )
    assert not right.corrections
    (fault,) = wrong.corrections
    assert fault.fault == "file_latitude" and not fault.applied
    assert "the latitude has the wrong sign" in wrong.statements["text"].iloc[0]
    assert "does not fit the sun" in str(wrong.untestable["incidence_angle"])


def test_planes_are_two_where_they_part_by_more_than_their_errors():
    found = Plane(30.0, 355.0, 5.0, 6.0, 40)
    assert not found.is_another(30.0, 355.0)
    assert not found.is_another(44.0, 12.0)  # past north
    assert found.is_another(46.0, 355.0) and found.is_another(30.0, 14.0)
    assert "azimuth 0 ± 6°" in str(Plane(30.0, 359.7, 5.0, 6.0, 40))


@pytest.mark.parametrize("turned", [0.0, 16.0])
def test_a_sensor_in_another_plane_is_told_and_no_obstacle_is_named(turned):
    """The residual of a plane that is far off, beyond first order, looks like shade."""
    effects = fem.simulator.PHYSICS | {"poa_misalignment": turned}
    site = study_worlds.site(813116)
    how = dict(days=365, step=300, seed=813116)
    data = fem.simulator.record(site, effects=effects, **how)
    loop = fem.close_loop(data, **study_worlds.World(site, 813116).place)
    assert all(f.effect != "shading" for f in loop.finding_objects)
    why = str(loop.untestable.get("shading", ""))
    assert ("not of the stated plane: it has tilt" in why) == (turned > 0.0)
    faults = [one.fault for one in loop.corrections]
    assert faults == (["file_plane"] if turned else [])
    first = [*loop.statements["device"].head(1)]
    assert (first == ["given place"]) == bool(turned)
    others = (str(why) for name, why in loop.untestable.items() if name != "shading")
    assert not any("stated plane" in why for why in others)


@pytest.mark.parametrize(
    ("column", "tilt"), [("poa_global", 10), ("poa_global_2", 40), ("poa_modelled", 10)]
)
def test_planes_of_which_the_source_has_the_tilt_are_found(golden, column, tilt):
    """Two pyranometers, and a model of the plane of one."""
    place = Location(39.742, -105.172, altitude=1829, tz="Etc/GMT+7")
    found = plane_of(golden[column], golden.index, place)
    assert abs(found.surface_tilt - tilt) < 2.0 * found.tilt_error


def test_bolzano_faces_the_south(bolzano):
    loop = fem.close_loop(
        bolzano, location=Location(46.458, 11.329, altitude=260, tz="Europe/Rome")
    )
    assert 25.0 < loop.place["surface_tilt"] < 40.0
    assert apart(loop.place["surface_azimuth"], 185.0) < 8.0
    rmse = loop.table["rmse_test"]
    assert rmse["fem"] == pytest.approx(1.49, abs=0.03)
    assert rmse.iloc[-1] < 1.20
    (fault,) = loop.corrections
    assert fault.applied and "Europe/Rome" in fault.why
