"""Power of the modules under a name of its own is their output, and heats nothing."""

import numpy as np
import pytest
from conftest import COLUMNS

import pvlib_fem as fem
from pvlib_fem import simulator
from pvlib_fem._loop.preparation.outputs import outputs
from pvlib_fem._record.inputs import as_record
from pvlib_fem.simulator import ALBUQUERQUE, OUTDOORS, PHYSICS, RHINE

SITES = {"rack": (RHINE, OUTDOORS), "desert": (ALBUQUERQUE, PHYSICS)}


@pytest.fixture(scope="module", params=SITES)
def data(request):
    return simulator.record(*SITES[request.param], days=90, step=1800.0, seed=3)


def found(data, **columns):
    """The package's name of each column that is taken for a power."""
    record = as_record(*(data[name] for name in COLUMNS))
    record = record.having({n: np.asarray(c, float) for n, c in columns.items()})
    return {column: name for column, name, _ in outputs(record, list(columns))}


def blocks(random, rows, share):
    return np.repeat(random.random(rows // 6 + 1) < share, 6)[:rows]


def test_a_power_of_any_name_and_unit_is_an_output(data):
    power, random = data["p_dc_per_area"], np.random.default_rng(0)
    powers = {
        "Zähler": 4.0 * power,
        "exported": -0.02 * power,
        "with_outages": power * ~blocks(random, len(data), 0.3),
        "limited": power.clip(upper=0.7 * power.max()),
        "rough": power * random.normal(1.0, 0.05, len(data)),
    }
    names = ["power_ac", *(f"power_ac_{n}" for n in range(2, 6))]
    assert found(data, **powers) == dict(zip(powers, names))


def test_light_and_heat_are_no_outputs(data):
    """Neither falls with the temperature of the modules, nor without light."""
    light, module = data["poa_global"], data["temp_module"]
    random, rows, hour = np.random.default_rng(1), len(data), data.index.hour
    others = {
        "pyranometer_east": light * random.normal(1.02, 0.03, rows),
        "reference_cell": light * (1.0 + 5e-4 * (module - 25.0)),
        "corrected": data["p_dc_per_area"] / (1.0 - 0.004 * (module - 25.0)),
        "room": data["temp_air"] + 0.02 * light,
        "fan": 50.0 * ((hour >= 9) & (hour < 16)),
        "chiller": 100.0 * blocks(random, rows, 0.3) * (module > 30.0),
        "noise": random.normal(size=rows),
    }
    assert found(data, **others) == {}


def test_a_name_of_power_is_believed_of_what_follows_light(data):
    """A cooler in kW runs by its own hours, so that it is no output."""
    cooler = 3.0 * blocks(np.random.default_rng(2), len(data), 0.3)
    flat = 0.05 * data["poa_global"]
    columns = {"Plant power (kW)": flat, "Cooler power (kW)": cooler}
    assert found(data, **columns) == {"Plant power (kW)": "power_ac"}


def test_a_loop_tries_no_output_as_heat_and_says_what_to_do(data):
    """Nor as an axis of what is unexplained: predictions would need it."""
    columns = {"Meter": 2e-3 * data["p_dc_per_area"], "fan": data.index.hour % 7 == 3}
    loop = fem.close_loop(data[list(COLUMNS)].assign(**columns).astype(float))
    (note,) = [note for note in loop.notes if note.startswith("Meter")]
    assert "looks like power_ac" in note and "--map power_ac=Meter" in note
    assert "falls with the module temperature" in note
    assert not any(
        "Meter" in name for f in loop.finding_objects for name in f.candidates
    )
