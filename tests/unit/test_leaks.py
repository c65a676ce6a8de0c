"""A column that is made from the module's temperature is no cause of the residual."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import COLUMNS

import pvlib_fem as fem
from pvlib_fem import simulator
from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._loop.preparation.leaks import leaks
from pvlib_fem.simulator import ALBUQUERQUE, OUTDOORS, PHYSICS, RHINE

STEP = 1800.0
HOUR = int(3600.0 / STEP)
TROPICS = replace(
    RHINE, latitude=5.0, temp_mean=27.0, temp_amplitude=2.0, surface_tilt=10.0
)
ROOF = replace(RHINE, latitude=-33.0, surface_azimuth=0.0, mounting="roof")
WORLDS = {
    "rack": (RHINE, PHYSICS),
    "desert": (ALBUQUERQUE, PHYSICS | {"sky_radiation": 1.0}),
    "tropics": (TROPICS, OUTDOORS),
    "roof": (ROOF, OUTDOORS | {"soiling": 1.0, "shading": 1.0}),
}


@pytest.fixture(scope="module", params=WORLDS)
def data(request):
    site, effects = WORLDS[request.param]
    seed = [*WORLDS].index(request.param)
    data = simulator.record(site, effects, days=120, step=STEP, seed=seed)
    return data.assign(poa_global=data["poa_global"].clip(lower=0.0))


def found(data, columns):
    """Refused columns among some, by a loop's fitting weeks."""
    fit = fem.fit_fem(
        *(data[name] for name in COLUMNS),
        model="faiman",
        dynamics="balance",
        night=True,
    )
    record = fit.record.having({n: np.asarray(c) for n, c in columns.items()})
    modelled = record["temp_module"] - fit.residual.to_numpy()
    seen = (record.dates + 3) // 7 % 5 != 2
    return set(
        leaks(record, seen, modelled, list(columns), Criteria().min_leak_difference)
    )


def smooth(values, hours):
    decay = np.exp(-1.0 / (hours * HOUR))
    out = np.array(values, dtype=float)
    for i in range(1, len(out)):
        out[i] = decay * out[i - 1] + (1.0 - decay) * out[i]
    return out


def wander(random, rows, hours):
    """Noise of unit size that forgets itself in so many hours."""
    rough = random.normal(size=rows)
    calm = smooth(rough, hours)
    return calm / calm.std()


def causes(data, random):
    """Columns that act on the module, and by how much they do. [K]"""
    rows, poa, wind = len(data), data["poa_global"], data["wind_speed"]
    on = np.repeat(random.random(rows // 6 + 1) < 0.3, 6)[:rows]
    warm = (data["temp_air"] > data["temp_air"].median()) & (data.index.hour >= 12)
    neighbour = warm * (1.0 + 0.3 * wander(random, rows, 24))
    humid = data["relative_humidity"]
    wet = data["precipitation"] > 0
    lamp = wander(random, rows, 5)
    cooled = smooth(0.02 * poa / (1.0 + 0.1 * wind), 0.5)
    elsewhere, gust = wander(random, rows, 6), wander(random, rows, 1)
    other_wind = wind * np.exp(0.4 * gust)
    by_wind = 0.025 * poa * (1.0 / (1.0 + 0.3 * other_wind) - 1.0 / (1.0 + 0.3 * wind))
    curtailed = 0.2 * poa * on
    power = data["p_dc_per_area"] * (1.0 - on) * random.normal(1.0, 0.01, rows)
    cloud = 0.06 * poa * wander(random, rows, 0.5)
    ground = smooth(data["temp_air"] + 0.02 * poa, 3)
    cabinet = wander(random, rows, 5)
    return {
        "fan": (on + random.normal(0, 0.05, rows), 3.0 * on),
        "neighbour": (50.0 * neighbour, 3.0 * smooth(neighbour, 0.3)),
        "humidity": (humid + random.normal(0, 2, rows), -0.05 * (humid - 50.0)),
        "rain": (data["precipitation"], -2.0 * smooth(wet, 0.2)),
        "second_air": (data["temp_air"] + elsewhere, 0.8 * elsewhere),
        "other_mast": (other_wind, by_wind),
        "inverter": (power, 0.02 * curtailed),
        "second_light": (poa + cloud, 0.028 * smooth(cloud, 0.1)),
        "ground": (ground, 0.05 * (ground - data["temp_air"])),
        "cabinet": (data["temp_air"] + smooth(0.015 * poa, 1) + 3 * cabinet, cabinet),
        "warm_wall": (data["temp_air"] + cooled + 8.0 * lamp, 0.8 * lamp),
    }


def bystanders(data, random):
    """Columns that follow the weather, or nothing, and do not act on the module."""
    rows, poa, air = len(data), data["poa_global"], data["temp_air"]
    cooled = smooth(0.02 * poa / (1.0 + 0.1 * data["wind_speed"]), 0.5)
    return {
        "ghi": poa * (1.0 + 0.05 * wander(random, rows, 3)),
        "shielded_badly": air + 1.5e-3 * poa / (1.0 + data["wind_speed"]),
        "inverter_temperature": air + cooled + 0.5 * wander(random, rows, 3),
        "inverter_power": 0.96 * data["p_dc_per_area"] * random.normal(1.0, 0.01, rows),
        "longwave": data["longwave_down"],
        "pressure": 1013.0 + 8.0 * wander(random, rows, 48),
        "noise": random.normal(size=rows),
        "walk": np.cumsum(random.normal(size=rows)),
    }


def made(data, random):
    """Columns that are made from the module's temperature."""
    module, poa = data["temp_module"].to_numpy(), data["poa_global"].to_numpy()
    rows, kelvin = len(module), module + 273.15
    seconds = STEP * np.arange(rows)
    voltage = 600.0 - 2.0 * (module - 25.0)
    columns = {
        "over_air": module - data["temp_air"] + random.normal(0, 1, rows),
        "light_as_a_log": voltage + 5 * np.log1p(poa) + random.normal(0, 0.2, rows),
        "the_same_noisy": voltage + 5 * np.log1p(poa) + random.normal(0, 1, rows),
        "light_as_a_root": voltage + 3 * np.sqrt(poa) + random.normal(0, 0.5, rows),
        "nothing_at_night": np.where(
            poa > 20.0, voltage + 20.0 * np.log(np.maximum(poa, 1.0) / 1000.0), 0.0
        ),
        "thermistor": 1e4 * np.exp(3500.0 / kelvin - 3500.0 / 298.0),
        "emitted": 5.67e-8 * kelvin**4 + random.normal(0, 5, rows),
        "smooth": smooth(module, 2) + random.normal(0, 0.3, rows),
        "wind": module + 0.8 * data["wind_speed"] ** 1.5 + random.normal(0, 1, rows),
        "rounded": (module / 4.0).round() * 4.0,
    }
    for minutes in (0, 15, 45, 60, 75, 105, 120):
        late = np.interp(seconds - 60.0 * minutes, seconds, module)
        noise = random.normal(0, 0.2 * module.std(), rows)
        columns |= {f"late_{minutes}": late, f"late_{minutes}_noisy": late + noise}
    return columns


def test_what_is_made_from_the_temperature_is_refused(data):
    random = np.random.default_rng(1)
    columns = made(data, random)
    assert found(data, columns | bystanders(data, random)) == {*columns}


def test_a_cause_is_not_refused(data):
    refused = set()
    for name, (column, kelvin) in causes(data, np.random.default_rng(2)).items():
        acting = data.assign(temp_module=data["temp_module"] + np.asarray(kelvin))
        refused |= found(acting, {name: column})
    assert refused == set()


@pytest.mark.parametrize(("noise", "own"), [(0.2, 0.2), (0.5, 0.2), (0.5, 0.5)])
def test_a_second_sensor_is_refused_though_each_has_noise(data, noise, own):
    """The first one's noise is in the residual, and not in the second."""
    random, rows = np.random.default_rng(3), len(data)
    over = data["temp_module"] - data["temp_air"]
    second = data["temp_air"] + 1.04 * over + 0.3 + random.normal(0, own, rows)
    noisy = data["temp_module"] + random.normal(0, noise, rows)
    assert found(data.assign(temp_module=noisy), {"second": second}) == {"second"}


def test_a_copy_between_two_steps_of_the_lags_is_refused():
    """Ten minutes apart, copies are late by any of them."""
    site, effects = WORLDS["roof"]
    data = simulator.record(site, effects, days=90, step=600, seed=19)
    module = data["temp_module"]
    late = {f"late_{10 * n}": module.shift(n).bfill() for n in range(0, 13, 2)}
    late |= {
        f"late_{m}": module.rolling(2).mean().shift(m // 10).bfill()
        for m in (45, 75, 105)
    }
    assert found(data, late) == {*late}
