"""Three faults of a plant: the report has device, direction, size, date and action."""

import json
import re

import numpy as np
import pandas as pd
import pytest
from pvlib.location import Location
from test_report import Page

import pvlib_fem as fem
from pvlib_fem import simulator
from pvlib_fem._record.column_names import COLUMNS

SITE = simulator.RHINE
SINCE = "2022-09-10"
FADES, SLOW = 0.08, 0.4  # share lost each year; share of the wind that is read
#: device, what the sentence has to say, size, date and action of each fault
FAULTS = {
    "clock_shift": (
        "clock of the module's logger",
        r"temp_module run 1 h ahead of those of poa_global",
        60.0,
        "",
        "Set the clock of the module's logger back by 60 min",
    ),
    "irradiance_sensor_drift": (
        "irradiance sensor",
        r"irradiance sensor reads [\d.]+ ± [\d.]+ % less each year since 2022-01-01",
        -100.0 * FADES,
        "2022-01-01",
        "Clean and recalibrate the irradiance sensor",
    ),
    "anemometer_step": (
        "anemometer",
        r"From 2022-09-\d\d \(.*\) on the anemometer reads [\d.]+ ± [\d.]+ % less",
        -100.0 * (1.0 - SLOW),
        SINCE,
        "Check the anemometer's bearing and surroundings, or recalibrate it",
    ),
}


@pytest.fixture(scope="module")
def record():
    """Two years: a pyranometer that fades, an anemometer that sticks, a fast clock."""
    effects, start = simulator.PHYSICS, "2022-01-01"
    data = simulator.record(effects=effects, days=730, step=1800.0, seed=1, start=start)
    power = 25.0 * data["p_dc_per_area"]  # of a plant of 25 m²
    data = data[list(COLUMNS)].assign(power_dc=power)
    years = (data.index - data.index[0]).days / 365.2425
    data["poa_global"] *= 1.0 - FADES * years
    stuck = data.index >= pd.Timestamp(SINCE, tz=data.index.tz)
    data["wind_speed"] = data["wind_speed"].where(~stuck, SLOW * data["wind_speed"])
    data["temp_module"] = data["temp_module"].shift(2)  # an hour later than it was
    return data.dropna()


@pytest.fixture(scope="module")
def loop(record):
    where = Location(SITE.latitude, SITE.longitude, tz=SITE.tz, name="Test roof")
    return fem.close_loop(
        record, location=where, surface_tilt=35.0, surface_azimuth=180.0
    )


@pytest.fixture(scope="module")
def page(loop):
    return Page(loop.to_html())


@pytest.mark.parametrize("cause", FAULTS)
def test_the_file_has_each_fault(loop, cause):
    device, words, size, since, action = FAULTS[cause]
    (one,) = [
        s for s in json.loads(loop.to_json())["statements"] if s["cause"] == cause
    ]
    assert one["device"] == device and one["action"] == action
    assert re.search(words, one["text"])
    assert one["value"] == pytest.approx(size, rel=0.1)
    if since:
        assert abs(pd.Timestamp(one["since"]) - pd.Timestamp(since)).days <= 7
        assert one["verdict"] == "identified"
    assert one["gain"] > 0.1 and one["energy"] > 1.0


@pytest.mark.parametrize("cause", FAULTS)
def test_the_page_has_each_fault_in_one_row_of_what_to_do(loop, page, cause):
    device, words, size, since, action = FAULTS[cause]
    (row,) = [r for r in page.rows if len(r) == 7 and re.search(words, r[0])]
    assert row[1] == action and row[2] == device
    if since:
        read = float(re.search(r"reads ([\d.]+) ±", row[0])[1])
        assert read == pytest.approx(abs(size), rel=0.1)
    assert (
        row[3] == "–"
        if not since
        else abs(pd.Timestamp(row[3]) - pd.Timestamp(since)) <= pd.Timedelta(days=7)
    )
    (one,) = loop.statements[loop.statements["cause"] == cause].itertuples()
    assert float(row[4]) == pytest.approx(one.gain, abs=0.005)
    assert float(row[5]) == pytest.approx(one.energy, abs=0.05)
    assert row[6] == one.certainty
    # a picture has the same sentence above it
    assert page.texts.count(one.text) >= 2


@pytest.mark.parametrize("cause", FAULTS)
def test_the_print_has_each_fault(loop, cause):
    _, words, _, _, action = FAULTS[cause]
    printed = " ".join(str(loop).split())
    assert re.search(f"{words}.*→ {re.escape(action)}", printed)


def test_nothing_else_is_reported_as_a_fault(loop):
    named = loop.statements["verdict"].isin(["identified", "ambiguous", "corrected"])
    assert {*loop.statements["cause"][named]} == {*FAULTS}


def test_what_the_sensor_of_irradiance_is_worth_is_what_it_lost(loop, record):
    """Most of it is the light that is not read, the least its temperature."""
    loss = FADES * (record.index - record.index[0]).days / 365.2425
    light = record["poa_global"] * loss / (1.0 - loss)
    lost = light.sum() / 1000.0 * 0.5 * 365.2425 / 730.0
    one = loop.statements.set_index("cause").loc["irradiance_sensor_drift"]
    assert one["energy"] == pytest.approx(lost, rel=0.12)
    energies = loop.statements["energy"].to_numpy()[1:]  # after the clock
    known = energies[np.isfinite(energies)]
    assert (np.diff(known) <= 0.0).all()
