"""A record's own columns of tilt and azimuth: of fixed planes, and of trackers."""

import numpy as np
import pandas as pd
import pvlib
import pytest
from click.testing import CliRunner
from conftest import COLUMNS
from pvlib.location import Location

import pvlib_fem as fem
from pvlib_fem import _cli as cli, simulator
from pvlib_fem._loop.preparation.planes import plane_of_columns
from pvlib_fem.reasons import Reason

SITE = simulator.RHINE
WHERE = Location(SITE.latitude, SITE.longitude, tz=SITE.tz)
OF_THE_PLANE = ("incidence_angle", "poa_misalignment", "rear_irradiance", "shading")


@pytest.fixture(scope="module")
def record():
    effects = simulator.PHYSICS | {"sky_radiation": 1.0}
    data = simulator.record(effects=effects, days=90, step=1800.0, start="2023-04-01")
    return data[[*COLUMNS, "relative_humidity"]]


@pytest.fixture(scope="module")
def tracker(record):
    """Angles of a single-axis tracker by pvlib, and the record without its light."""
    sun = WHERE.get_solarposition(record.index)
    angles = pvlib.tracking.singleaxis(sun["apparent_zenith"], sun["azimuth"])
    names = ["surface_tilt", "surface_azimuth"]
    return record.assign(**{name: angles[name] for name in names})


def site(tilt=None, azimuth=None):
    return fem.drivers.checked_place(WHERE, tilt, azimuth)


def test_light_of_a_fixed_plane_is_not_taken_for_that_of_a_tracker(tracker):
    loop = fem.close_loop(tracker, location=WHERE)
    for name in OF_THE_PLANE:
        (why,) = loop.untestable[name].all
        assert why.reason is Reason.ANOTHER_PLANE and " tilt 2" in str(why)
        assert name not in loop.effects
    # neither stated nor estimated as if it stood
    assert loop.place["surface_tilt"] is None
    assert "sky_radiation" in loop.effects


def test_a_number_for_a_plane_that_moves_is_refused(tracker):
    words = "surface_tilt is given as 35°, and the column surface_tilt has 0.1"
    with pytest.raises(ValueError, match=words):
        fem.close_loop(tracker, surface_tilt=35.0, surface_azimuth=180.0)


def test_the_command_refuses_the_number_and_says_what_to_leave_out(tracker, tmp_path):
    path = tmp_path / "tracker.csv"
    tracker.tz_localize(None).to_csv(path, index_label="time")
    place = ("--lat", "49.4", "--lon", "8.7", "--tz", "Etc/GMT-1")
    call = ["loop", str(path), *place, "--tilt", "35", "--azimuth", "180"]
    said = CliRunner().invoke(cli.main, call)
    assert said.exit_code == 1 and "--tilt and --azimuth" in said.output


def test_angles_of_a_fixed_plane_are_those_of_its_columns(record):
    tilt = np.where(np.arange(len(record)) % 7, 35.0, np.nan)
    data = record.assign(surface_tilt=tilt, surface_azimuth=180.0)
    rest, by_columns = plane_of_columns(data, site())
    assert by_columns["mount"] is None and list(rest) == list(record)
    assert by_columns["surface_tilt"] == 35.0
    assert by_columns["surface_azimuth"] == 180.0
    loop = fem.close_loop(data, location=WHERE)
    given = fem.close_loop(
        record, location=WHERE, surface_tilt=35.0, surface_azimuth=180.0
    )
    pd.testing.assert_frame_equal(loop.table, given.table)


def test_angles_that_agree_with_the_columns_are_taken(record):
    data = record.assign(surface_tilt=35.0, surface_azimuth=180.0)
    assert plane_of_columns(data, site(35.4, 180.0))[1]["surface_tilt"] == 35.4
    with pytest.raises(ValueError, match="up to 10° from it"):
        plane_of_columns(data, site(25.0, 180.0))


@pytest.mark.parametrize(
    "azimuth, moves", [([359.9, 0.2], False), ([90.0, 270.0], True)]
)
def test_north_is_one_azimuth(record, azimuth, moves):
    data = record.assign(surface_tilt=20.0)
    data["surface_azimuth"] = np.resize(azimuth, len(data))
    assert (plane_of_columns(data, site())[1]["mount"] is not None) == moves


def test_a_level_plane_has_any_azimuth(record):
    data = record.assign(surface_tilt=0.0)
    data["surface_azimuth"] = np.resize([90.0, 270.0], len(data))
    assert plane_of_columns(data, site())[1]["mount"] is None
