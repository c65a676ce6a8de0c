"""
Sizes of sensor faults, with and without a reference that shows them.

Run as ``python studies/study_sizes.py [--records 100] [--seed 48061]``; the table is
Markdown. A sensor of a simulated record with full physics has a step, a trend or a
temporary change, as in ``study_instruments``. The loop has the record alone, and then
with power or with a second sensor, which is sound and has noise of its own.
"""

import argparse

import numpy as np
import pandas as pd
from study_instruments import SAME, coefficient_of, made

from pvlib_fem import close_loop
from pvlib_fem._parallel import spread

POWER = "p_dc_per_area"
#: second sensors of the instruments of sensor faults, and their noise [-, K]
SECOND = {
    "irradiance_sensor": ("poa_global", 0.01),
    "module_sensor_contact": ("temp_module", 0.3),
    "air_offset": ("temp_air", 0.3),
    "module_offset": ("temp_module", 0.3),
}


def second_sensor(data, channel, seed):
    """A second sensor of the instrument that has changed, by its name."""
    name, noise = SECOND[channel]
    random = np.random.default_rng(seed).normal(0.0, noise, len(data))
    times = data[name] if name == "poa_global" else 1.0
    return {f"{name}_2": data[name] + times * random}


def looked(seed):
    """The size of a change without a reference and with each, if all have it."""
    before, after, (world, channel, course, size, _, has_power) = made(seed)
    if channel not in SECOND:
        return []
    alone = after.drop(columns=POWER, errors="ignore")
    records = {
        "": alone,
        "second": alone.assign(**second_sensor(before, channel, seed)),
    }
    if channel == "irradiance_sensor" and has_power:
        records["power"] = after
    truths = {f"{name}_{course}" for name in SAME.get(channel, (channel,))}
    rows = []
    for name, data in records.items():
        loop = close_loop(data, check_units=False, **world.place)
        found = [f for f in loop.finding_objects if f.added]
        right = [f for f in found if truths & {*f.candidates}]
        told = coefficient_of(right, channel, course, size, world.days / 365.0)
        row = dict(seed=seed, channel=channel, course=course, by=name)
        row["rmse"] = float(loop.table["rmse_test"].iloc[-1])
        for one in told.values():
            low, high = one["range"] or (np.nan, np.nan)
            row["off"] = abs(one["value"] / one["truth"] - 1.0)
            row["half"] = 0.5 * (high - low) / abs(one["truth"])
            row["held"] = low <= one["truth"] <= high
        rows.append(row)
    return rows


def pairs(table, by):
    """Records whose size is known without a reference and with one, side by side."""
    known = table.dropna(subset=["off"]).set_index("seed")
    alone, others = (known[known["by"] == name] for name in ("", by))
    return alone.merge(others, "inner", on="seed", suffixes=("", "_by"))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=100)
    parser.add_argument("--seed", type=int, default=48_061)
    parser.add_argument("--processes", type=int, default=2)
    given = parser.parse_args()
    tasks = [(seed,) for seed in range(given.seed, given.seed + given.records)]
    rows = [row for some in spread(looked, tasks, given.processes) for row in some]
    table = pd.DataFrame(rows)
    heads = "error of the size", "half-width of the range", "ranges that hold it"
    print(f"| reference | records | {' | '.join(heads)} | error on test weeks |")
    print("|---|---|---|---|---|---|")
    for by, words in (("second", "a second sensor"), ("power", "power")):
        both = pairs(table, by)
        cells = [words, len(both)]
        for name, kind in (("off", "median"), ("half", "median"), ("held", "mean")):
            values = (getattr(both[one], kind)() for one in (name, f"{name}_by"))
            cells.append(" → ".join(f"{value:.1%}" for value in values))
        errors = (both[name].mean() for name in ("rmse", "rmse_by"))
        cells.append(" → ".join(f"{error:.3f} K" for error in errors))
        print(f"| {' | '.join(map(str, cells))} |")


if __name__ == "__main__":
    main()
