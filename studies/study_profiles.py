"""
Sensors that change along no exact step, trend or temporary change.

Run as ``python studies/study_profiles.py [--records 120] [--seed 80400]``; the table is
Markdown. A sensor of a simulated record with full physics has a fault along one of
ten time profiles, of which six are in the catalogue. A finding is right if the
device is in its set.
"""

import argparse

import numpy as np
import pandas as pd
from study_instruments import SAME, SIZES, changed
from study_worlds import World, site

from pvlib_fem import close_loop, simulator
from pvlib_fem._parallel import spread
from pvlib_fem.effects import CHANGES

PROFILES = {
    "step": "a step",
    "drift": "a trend of the whole record",
    "episode": "a temporary change",
    "fade": "fades ever more slowly",
    "ramp": "changes in 40 to 120 days, and stays",
    "stairs": "changes in four steps",
    "hinge": "a trend that begins within the record",
    "slope": "a trend that begins, and ends when the sensor is cleaned",
    "cleanings": "a trend that begins again at two to four cleanings",
    "swaps": "two to four steps to any sizes",
}
FAULTS = ("irradiance_sensor", "module_sensor_contact", "anemometer", "air_offset")
ODDS = (0.5, 0.25, 0.15, 0.1)
LARGER = 1.3  # times the sizes of ``study_instruments``
MOST = 0.7  # of the wind that is lost


def weights(profile, day, days, random):
    """Share of the fault at each time."""
    first, last = np.sort(random.uniform(0.2, 0.8, 2)) * days
    if last - first < 60:
        last = min(first + 80, 0.9 * days)
    if profile == "step":
        return (day >= first) * 1.0
    if profile == "drift":
        return day / days
    if profile == "episode":
        return ((day >= first) & (day < last)) * 1.0
    if profile == "fade":
        return 1.0 - np.exp(-day / (days * random.uniform(0.2, 0.6)))
    if profile == "ramp":
        return np.clip((day - first) / random.uniform(40, 120), 0.0, 1.0)
    if profile == "stairs":
        each = np.sort(random.uniform(0.1, 0.9, 4)) * days
        return sum((day >= one) * 0.25 for one in each)
    if profile == "hinge":
        return np.clip((day - first) / (days - first), 0.0, 1.0)
    if profile == "slope":
        return np.clip((day - first) / (last - first), 0.0, 1.0) * (day < last)
    ends = np.sort(random.uniform(0.1, 0.9, random.integers(2, 5))) * days
    longest = np.diff([0.0, *ends, days]).max()
    zero, level = np.zeros_like(day), np.zeros_like(day)
    for one in ends:
        zero[day >= one] = one
        level[day >= one] = random.uniform(-1.0, 1.0)
    return (day - zero) / longest if profile == "cleanings" else level


def looked(seed):
    """What the loop says of one record."""
    random = np.random.default_rng([seed, 77])
    profile = [*PROFILES][seed % len(PROFILES)]
    fault = str(random.choice(FAULTS, p=ODDS))
    size = LARGER * random.uniform(*SIZES[fault])
    if fault == "anemometer":
        size = min(size, MOST)
    elif fault != "irradiance_sensor":
        size *= random.choice([-1.0, 1.0])
    days = int(random.choice([365, 730]))
    world = World(site(70_000 + seed), 70_000 + seed, days=days, step=900.0)
    how = (world.days, world.step, world.seed, world.start)
    (data,) = simulator.records(world.site, [simulator.OUTDOORS], *how)
    data.attrs = {}
    if random.random() < 0.5:
        data = data.drop(columns="p_dc_per_area")
    day = np.asarray((data.index - data.index[0]) / pd.Timedelta("1D"))
    data = changed(data, fault, size, weights(profile, day, days, random))
    loop = close_loop(data, check_units=False, **world.place)
    devices = SAME.get(fault, (fault,))
    added = [one for one in loop.finding_objects if one.added]
    faults = [one for one in added if one.effect in CHANGES]
    held = [any(map(is_one_of(devices), one.candidates)) for one in faults]
    right = [any(map(is_one_of(devices), one.candidates)) for one in added]
    named = [one.effect for one in faults if one.verdict == "identified"]
    return {
        "profile": profile,
        "found": any(right),
        "other": any(not is_one_of(devices)(name) for name in named),
        "misled": not all(held),
        "rmse": float(loop.table["rmse_test"].iloc[-1]),
    }


def is_one_of(devices):
    """Whether a name is a change of one of some devices."""
    return lambda name: name in CHANGES and name.rsplit("_", 1)[0] in devices


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=120)
    parser.add_argument("--seed", type=int, default=80_400)
    parser.add_argument("--processes", type=int, default=2)
    given = parser.parse_args()
    tasks = [(seed,) for seed in range(given.seed, given.seed + given.records)]
    table = pd.DataFrame([*spread(looked, tasks, given.processes)])
    print(
        "| the sensor | records | device in a set | another device identified | ",
        end="",
    )
    print("a set of faults without it | RMSE [K] |\n|---|---|---|---|---|---|")
    groups = [(words, table[table["profile"] == n]) for n, words in PROFILES.items()]
    for words, some in (*groups, ("all", table)):
        counts = [int(some[name].sum()) for name in ("found", "other", "misled")]
        cells = [words, len(some), *counts, f"{some['rmse'].mean():.3f}"]
        print(f"| {' | '.join(map(str, cells))} |")


if __name__ == "__main__":
    main()
