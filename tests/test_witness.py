"""What other columns say of an instrument that has changed."""

import json

import numpy as np
import pytest
from test_instruments import closed, half_a_year, with_change  # noqa: F401

from pvlib_fem.findings import Finding, Opinion, Verdict
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
    opinions = {(one.effect, one.opinion) for one in first.witnesses}
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
