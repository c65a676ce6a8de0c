import os
import re
import shlex

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import settings
from pvlib.location import Location

from pvlib_fem import _cli as cli, datasets, ewm
from pvlib_fem._record.inputs import as_record
from pvlib_fem.datasets._download import FOLDER
from pvlib_fem.drivers import sun
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._screen import screened_alone

# the same few examples in every run; `make fuzz` takes many, and others each time
settings.register_profile("few", max_examples=25, deadline=None, derandomize=True)
settings.register_profile("fuzz", max_examples=10_000, deadline=None)
settings.load_profile("few")

DRIVERS = ("poa_global", "temp_air", "wind_speed")
COLUMNS = (*DRIVERS, "temp_module")

#: files, and single tests, that take longer than seconds; `make test` leaves them out
SLOW = {
    *("test_browser", "test_ceiling", "test_daylight", "test_dirty", "test_events"),
    *("test_fleet", "test_instruments", "test_measured", "test_parquet_fit"),
    *("test_parquet_loop", "test_recovery", "test_reliability", "test_report"),
    *("test_simulator", "test_standstill", "test_statements", "test_study"),
    *("test_surroundings", "test_trackers"),
    "test_a_stray_time_is_refused_by_name",
    "test_an_interrupted_fleet_says_how_to_go_on_and_goes_on",
    "test_bolzano_faces_the_south",
    "test_its_energies_are_those_of_the_script",
    "test_no_file_ends_with_a_traceback",
    "test_tau_is_recovered",
    "test_the_demo_finds_what_is_hidden_and_tells_the_truth_after",
}


def pytest_collection_modifyitems(items):
    """Mark the slow tests."""
    for item in items:
        if {item.path.stem, getattr(item, "originalname", "")} & SLOW:
            item.add_marker(pytest.mark.slow)


def measured(*columns, **drivers):
    """A record before the search for stuck sensors."""
    return screened_alone(as_record(*columns, **drivers), Limits())[0]


def call(*arguments):
    return CliRunner().invoke(cli.main, [str(a) for a in arguments])


def proposed(result):
    """The command in a message, as a shell would take it."""
    line = re.search(r"^  pvlib-fem (.*)$", result.output, re.MULTILINE)
    assert line, result.output
    return shlex.split(line[1])


@pytest.fixture(scope="session")
def month():
    """Drivers of thirty days at 1 min, without sensor noise."""
    return datasets.synthetic(days=30, seed=1, noise=0)


@pytest.fixture(scope="session")
def drivers(month):
    return tuple(month[name] for name in DRIVERS)


def power_of(data, random):
    """A plant that is off for hours, covered for hours, or whose sensor is covered."""
    module = data["temp_air"] + 0.03 * data["poa_global"]
    power = 5.0 * data["poa_global"] * (1.0 - 0.004 * (module - 25.0))
    draw, left = random.uniform(size=(2, len(data) // 12))
    shares = np.select(
        [draw < 0.04, draw < 0.12, draw < 0.16],
        [0.0, 0.1 + 0.6 * left, 1.3 + left],
        1.0,
    )
    return power * np.repeat(shares, 12)


@pytest.fixture(scope="session")
def plant():
    """Sixty days at 5 min with every column that an effect needs."""
    data = datasets.synthetic(60, 300, seed=7, noise=0).tz_localize(None)
    random = np.random.default_rng(1)
    rows = len(data)

    def wandering(memory):
        kicks = random.normal(size=rows) * np.sqrt(2 * memory)
        return ewm(kicks, 300.0 * memory, step=300)

    data["wind_direction"] = (220 + 90 * wandering(200)) % 360
    data["longwave_down"] = np.clip(330 + 30 * wandering(150), 100, 550)
    curtailed = np.repeat(random.uniform(size=rows // 12) < 0.2, 12)
    data["p_dc_per_area"] = 0.18 * data["poa_global"] * np.where(curtailed, 0.2, 1.0)
    data["precipitation"] = np.where(wandering(20) > 2.1, 3.0, 0.0)
    data["relative_humidity"] = np.clip(55 + 20 * wandering(80), 5, 100)
    falls = np.where(random.uniform(size=rows) < 0.005, 5.0, 0.0)
    data["snow_depth"] = ewm(12 * falls, 3600.0, step=300)  # it melts in an hour
    data["power_dc"] = power_of(data, random)
    place = sun(data.index, Location(35.0, -106.0))
    data[place.columns] = place
    data["surface_tilt"], data["surface_azimuth"] = 35.0, 180.0
    return data


@pytest.fixture(scope="session")
def week():
    """The measured week, where a user would find it."""
    try:
        return datasets.load("sandia_week")
    except OSError as error:
        pytest.skip(f"no measured week: set {FOLDER} or go online ({error})")


@pytest.fixture(scope="session")
def day():
    """The measured day, where a user would find it."""
    try:
        return datasets.load("sandia_day")
    except OSError as error:
        pytest.skip(f"no measured day: set {FOLDER} or go online ({error})")


@pytest.fixture(scope="session")
def years():
    """The measured records of years by name, where a user would find them."""
    try:
        names = ("eurac_bolzano", "nrel_stf")
        return {name: datasets.load(name) for name in names}
    except (OSError, ImportError) as error:
        pytest.skip(f"no measured years: {error}")


@pytest.fixture(scope="session")
def bolzano(years):
    """Eight measured years, hourly, in the file's own summer time."""
    return years["eurac_bolzano"].copy()


@pytest.fixture(scope="session")
def golden(years):
    """Eight measured years, hourly by day, with a second plane and power."""
    return years["nrel_stf"].copy()


@pytest.fixture
def noise():
    """Reproducible noise: ``noise(rows, sd)`` is white."""
    return lambda rows, sd=0.2, seed=0: np.random.default_rng(seed).normal(0, sd, rows)


os.environ.setdefault("MPLBACKEND", "Agg")
