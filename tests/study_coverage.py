"""
How often 95 % intervals of a fit hold the truth, by law, dynamics and coefficient.

Run as ``python tests/study_coverage.py [--records 300] [--out docs/coverage.md]``. Each
record is a made-up weather of its own, and a module whose coefficients are drawn.
"""

import argparse
import sys
import time
from datetime import date
from pathlib import Path

import numpy as np
import pandas as pd

from pvlib_fem import datasets, fem_temperature, fit_fem, heat_balance
from pvlib_fem.parallel import spread
from pvlib_fem.relaxation import respond
from pvlib_fem.thermal.steady import STEADY_MODELS

DRIVERS = ("poa_global", "temp_air", "wind_speed")
#: days and step of the records [s]; the first has the table by coefficient
CASES = {"30 days at 5 min": (30, 300), "120 days at 15 min": (120, 900)}
NOISE, MEMORY = 0.3, 1800.0  # K, and the time for which a sensor's error stays [s]
TAU, BIAS = (150.0, 700.0), (-5.0, 2.0)  # s, K
WIND = 3.0  # m/s, the mean, at which a capacity is a tau
#: about the sites of the paper's Table 3, and the same in pvlib's numbers
SPANS = {
    "ross": {"k": (0.02, 0.04)},
    "sapm": {"a": (-3.7, -3.2), "b": (-0.12, -0.03)},
    "faiman": {"u0": (20.0, 32.0), "u1": (3.0, 9.0)},
    "wm1": {"k": (0.024, 0.04), "d": (7.0, 20.0)},
    "wm2": {"k": (0.024, 0.04), "k_w": (0.0008, 0.0025)},
    "pvsyst": {"u_c": (16.0, 26.0), "u_v": (2.0, 7.0)},
    "noct": {"noct": (40.0, 52.0)},
    "noct_sam": {"noct": (40.0, 52.0)},
}
HELD = {"noct_sam": {"module_efficiency": 0.2}}


def drawn(random, model, dynamics):
    """Coefficients of a module."""
    law = STEADY_MODELS[model]
    own = {name: random.uniform(*span) for name, span in SPANS[model].items()}
    tau = random.uniform(*TAU)
    if dynamics == "balance":
        constants = {**law.fixed, **HELD.get(model, {})}
        r_eq = float(law.resistance(np.array(WIND), **own, **constants))
        memory = {"capacity": tau / r_eq}
    else:
        memory = {"tau": tau}
    return {**own, **memory, "bias": random.uniform(*BIAS)}


def covered(seed):
    """Rows of one weather: whether each interval holds its coefficient."""
    rows = []
    for case, (days, step) in CASES.items():
        weather = datasets.synthetic(days, step, "2023-04-03", seed, noise=0)
        usual = [weather[name] for name in DRIVERS]
        random = np.random.default_rng([seed, step])
        decay = np.full(len(weather), np.exp(-step / MEMORY))
        for model in SPANS:
            for dynamics in ("ewm", "balance"):
                truth, held = drawn(random, model, dynamics), HELD.get(model, {})
                function = heat_balance if dynamics == "balance" else fem_temperature
                module = function(*usual, model=model, **truth, **held)
                kicks = random.standard_normal(len(weather)) * np.sqrt(1 - decay**2)
                module += NOISE * respond(decay, kicks, random.standard_normal())
                how = dict(model=model, dynamics=dynamics, fixed=held)
                fit = fit_fem(*usual, module, **how)
                interval = fit.confidence_interval(0.95)
                at = {"case": case, "model": model, "dynamics": dynamics}
                for name, value in truth.items():
                    low, high = interval["lower"][name], interval["upper"][name]
                    there = bool(low <= value <= high)
                    known = bool(np.isfinite(fit.stderr[name]) and fit.converged)
                    rows.append({**at, "name": name, "held": there, "known": known})
    return rows


def run(records, shift, processes):
    """A row for each coefficient of each fit."""
    rows, begin = [], time.perf_counter()
    tasks = [(seed,) for seed in range(shift, shift + records)]
    for i, some in enumerate(spread(covered, tasks, processes), 1):
        rows += some
        if i % 20 == 0:
            print(f"{i}: {time.perf_counter() - begin:.0f} s", file=sys.stderr)
    return pd.DataFrame(rows)


INTRO = """\
# How often an interval holds the truth

Written by `tests/study_coverage.py --records {records}` on {day}, from seed {low} on;
`make coverage` takes 300. Each record is a weather of its own (`datasets.synthetic`)
and, for each steady model and dynamics, a module whose coefficients are drawn about the
sites of the paper, with an error of the sensor of {noise:g} K that stays for half an
hour. `fit_fem` sees it as it sees any record. The tables have the share of 95 %
intervals (`fit.confidence_interval()`) that hold the true coefficient. If it is 95 %,
19 of 20 shares of {records} records are from {least:.1f} to {most:.1f} %, and the
lowest of the {cells} of a table is near {tail:.1f} %.
"""


def share(part):
    return f"{100 * part['held'].mean():.1f}" if len(part) else "–"


def page(table, records, shift, day):
    """The tables, as Markdown."""
    known = table[table["known"]]
    keys = ["model", "dynamics", "name"]
    one, *_ = CASES
    cells = known[known["case"] == one].groupby(keys).ngroups
    spread = 100 * np.sqrt(0.95 * 0.05 / records)
    yield INTRO.format(
        day=day,
        records=records,
        low=shift,
        noise=NOISE,
        least=95 - 1.96 * spread,
        most=min(95 + 1.96 * spread, 100.0),
        cells=cells,
        tail=95 - np.sqrt(2 * np.log(cells)) * spread,
    )
    for case in CASES:
        yield f"## {case}\n"
        yield "| model | dynamics | coefficients | memory | bias | all |"
        yield "|---|---|---|---|---|---|"
        part = known[known["case"] == case]
        for (model, dynamics), rows in part.groupby(["model", "dynamics"], sort=False):
            parts = {name: share(r) for name, r in rows.groupby("name", sort=False)}
            own = ", ".join(f"{name} {parts[name]}" for name in SPANS[model])
            memory = parts["tau" if dynamics == "ewm" else "capacity"]
            both = f"{memory} | {parts['bias']} | {share(rows)}"
            yield f"| `{model}` | `{dynamics}` | {own} | {both} |"
        yield ""
        cell = 100 * part.groupby(keys)["held"].mean()
        unknown = int((~table[table["case"] == case]["known"]).sum())
        yield (
            f"{share(part)} % of {len(part):,} intervals hold the truth; single cells "
            f"have\n{cell.min():.1f} to {cell.max():.1f} %. Without an interval: "
            f"{unknown}.\n"
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=300)
    parser.add_argument("--shift", type=int, default=0, help="the first seed")
    parser.add_argument("--out", type=Path, help="Markdown; standard output if none")
    parser.add_argument("--date", default=date.today().isoformat())
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    table = run(options.records, options.shift, options.processes)
    lines = page(table, options.records, options.shift, options.date)
    text = "\n".join(lines)
    if options.out:
        options.out.write_text(text, encoding="utf-8")
    else:
        print(text)


if __name__ == "__main__":
    main()
