"""
How often intervals by the period hold the truth, where a coefficient changes.

Run as
``python studies/study_periods.py [--records 200]``; the table is Markdown. Each
record is a made-up weather of its own, and a module whose coefficients are drawn and
take one of several courses. Periods in which a step falls have no one truth and are
left out; of a drift it is the mean. ``--days 0.5`` adds an error of the sensor of half
a kelvin that stays for a day.
"""

import argparse

import numpy as np
import pandas as pd

from pvlib_fem import datasets, fit_fem
from pvlib_fem._parallel import spread
from pvlib_fem._relaxation import relax, respond

#: days, step [s] and periods
CASES = {
    "weeks at 1 min": (42, 60, "W-MON"),
    "months at 15 min": (360, 900, "MS"),
    "months at 1 h": (720, 3600, "MS"),
}
COURSES = ("none", "step", "drift", "episode", "u0", "bias")
NAMES = ("r_eq", "u0", "u1", "capacity", "bias")
RED, DAY = 1800.0, 86400.0  # memories of the sensor's errors [s]


def truth_of(random, course, rows):
    """Coefficients row by row; a gain is that of the over-temperature."""
    share, at = np.linspace(0.0, 1.0, rows), random.uniform(0.3, 0.7)
    drawn = {"u0": (20, 32), "u1": (3, 9), "capacity": (4e3, 18e3), "bias": (-3, 1)}
    truth = {name: np.full(rows, random.uniform(*span)) for name, span in drawn.items()}
    sizes, gain = [0.8, 0.9, 1.1, 1.2], 1.0
    late, near = share > at, np.abs(share - at) < 0.15
    if course == "step":
        gain = np.where(late, random.choice(sizes), 1.0)
    elif course == "drift":
        gain = 1.0 + share * (random.choice([0.9, 1.1]) - 1.0)
    elif course == "episode":
        gain = np.where(near, random.choice(sizes), 1.0)
    elif course == "u0":
        truth["u0"] = truth["u0"] * np.where(late, random.choice(sizes), 1.0)
    elif course == "bias":
        truth["bias"] = truth["bias"] + np.where(late, 2.0, 0.0)
    return truth | {"u0": truth["u0"] / gain, "u1": truth["u1"] / gain}


def wandering(random, rows, step, memory):
    """An error of 1 K that stays for a time."""
    decay = np.full(rows, np.exp(-step / memory))
    kicks = random.standard_normal(rows) * np.sqrt(1.0 - decay**2)
    return respond(decay, kicks, random.standard_normal())


def record(seed, days, step, course, daily):
    """A record, and its coefficients row by row."""
    data = datasets.synthetic(days, step, "2023-01-02", seed, noise=0)
    random, rows = np.random.default_rng([seed, step]), len(data)
    truth = pd.DataFrame(truth_of(random, course, rows), data.index)
    r_eq = 1.0 / (truth["u0"] + truth["u1"] * data["wind_speed"]).to_numpy()
    target = data["temp_air"].to_numpy() + data["poa_global"].to_numpy() * r_eq
    module = relax(target, 1.0, truth["capacity"].to_numpy() * r_eq / step)
    error = 0.3 * wandering(random, rows, step, RED)
    error += daily * wandering(random, rows, step, DAY)
    data["temp_module"] = module + truth["bias"].to_numpy() + error
    return data, truth


def covered(seed, daily):
    """Whether each interval holds its coefficient, and by how many errors it misses."""
    found = []
    for case, (days, step, freq) in CASES.items():
        for course in COURSES:
            data, truth = record(seed, days, step, course, daily)
            names = ["poa_global", "temp_air", "wind_speed", "temp_module"]
            columns = (data[name] for name in names)
            fit = fit_fem(*columns, model="faiman", dynamics="balance")
            wind = fit.daily.winds[0]
            truth["r_eq"] = 1.0 / (truth["u0"] + truth["u1"] * wind)
            table = fit.through_time(freq)
            starts = table.index.unique("start")
            part = truth.groupby(np.searchsorted(starts, truth.index, "right") - 1)
            mean, span = part.mean(), (part.max() - part.min()).max(axis=1)
            for (name, start), row in table.iterrows():
                at = starts.get_loc(start)
                if np.isnan(row["value"]) or (course != "drift" and span[at] > 1e-9):
                    continue
                held = row["lower"] <= mean[name][at] <= row["upper"]
                error = row["stderr"] / abs(mean[name][at])
                found.append((case, course, name, held, error))
    return found


def run(records, shift, daily, processes):
    tasks = [(seed, daily) for seed in range(shift, shift + records)]
    rows = [row for some in spread(covered, tasks, processes) for row in some]
    return pd.DataFrame(rows, columns=["case", "course", "name", "held", "error"])


def lines(table):
    """Shares of intervals that hold the truth, in per cent, and usual errors."""
    yield f"| | course | {' | '.join(NAMES)} |"
    yield "|---|---|" + "---|" * len(NAMES)
    for (case, course), rows in table.groupby(["case", "course"], sort=False):
        shares = 100.0 * rows.groupby("name")["held"].mean().reindex(NAMES)
        cells = " | ".join(f"{share:.1f}" for share in shares)
        yield f"| {case} | {course} | {cells} |"
    for case, rows in table.groupby("case", sort=False):
        errors = 100.0 * rows.groupby("name")["error"].median().reindex(NAMES)
        cells = " | ".join(f"{error:.2g} %" for error in errors)
        yield f"| {case} | usual error | {cells} |"
    yield f"\n{100 * table['held'].mean():.1f} % of {len(table):,} intervals."


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=200)
    parser.add_argument("--shift", type=int, default=0, help="the first seed")
    parser.add_argument("--days", type=float, default=0.0, help="[K]")
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    table = run(options.records, options.shift, options.days, options.processes)
    print("\n".join(lines(table)))


if __name__ == "__main__":
    main()
