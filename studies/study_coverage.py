"""
How often 95 % intervals of a fit hold the truth, by law, dynamics and coefficient.

Run as
``python studies/study_coverage.py [--records 300] [--out docs/coverage.md]``. Each
record is a made-up weather of its own, and a module whose coefficients are drawn.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
from study_page import publish

from pvlib_fem import datasets, fem_temperature, fit_fem, heat_balance
from pvlib_fem._parallel import spread
from pvlib_fem._relaxation import respond
from pvlib_fem._thermal.steady_models import STEADY_MODELS

DRIVERS = ("poa_global", "temp_air", "wind_speed")
#: days and step of the records [s]; the first has the table by coefficient
CASES = {"30 days at 5 min": (30, 300), "120 days at 15 min": (120, 900)}
NOISE, MEMORY = 0.3, 1800.0  # K, and the time for which a sensor's error stays [s]
#: half-lives of an error that lasts [s], and the models that are fitted under it
HALF_LIVES = {"1 day": 86400.0, "7 days": 7 * 86400.0}
UNDER_LASTING = {"faiman": "ewm", "wm1": "balance"}
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
FUNCTIONS = {"ewm": fem_temperature, "balance": heat_balance}
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


def error(random, rows, step, memory):
    """An error of the sensor that stays for a time. [K]"""
    decay = np.full(rows, np.exp(-step / memory))
    kicks = random.standard_normal(rows) * np.sqrt(1 - decay**2)
    return NOISE * respond(decay, kicks, random.standard_normal())


def held(fit, truth):
    """
    Of each coefficient whether its interval holds it, and whether there is one.

    ``alone`` is whether one by the error of independent days would hold it.
    """
    interval, sums = fit.confidence_interval(0.95), fit.daily.sums
    alone = dict(zip(fit.daily.names, np.sqrt(np.diag(sums.by_day()))))
    few = any("too few to tell how long" in note for note in fit.notes)
    for name, value in truth.items():
        low, high = interval["lower"][name], interval["upper"][name]
        known = bool(np.isfinite(fit.stderr[name]) and fit.converged)
        reach = (high - low) / 2.0 * alone.get(name, np.nan) / fit.stderr[name]
        yield {
            "name": name,
            "held": bool(low <= value <= high),
            "alone": bool(abs(value - fit.coefficients[name]) <= reach),
            "few": few,
            "known": known,
        }


def covered(seed):
    """Rows of one weather: whether each interval holds its coefficient."""
    rows = []
    for case, (days, step) in CASES.items():
        weather = datasets.synthetic(days, step, "2023-04-03", seed, noise=0)
        usual = [weather[name] for name in DRIVERS]
        random = np.random.default_rng([seed, step])
        for model in SPANS:
            for dynamics in ("ewm", "balance"):
                truth, fixed = drawn(random, model, dynamics), HELD.get(model, {})
                how = dict(model=model, **fixed)
                module = FUNCTIONS[dynamics](*usual, **truth, **how)
                noisy = module + error(random, len(module), step, MEMORY)
                how = dict(model=model, dynamics=dynamics, fixed=fixed)
                at = {"case": case, "model": model, "dynamics": dynamics}
                at |= {"lasts": "", "night": False}
                fit = fit_fem(*usual, noisy, **how)
                rows += [{**at, **row} for row in held(fit, truth)]
                if UNDER_LASTING.get(model) != dynamics:
                    continue
                # of other draws, so that those above stay as they are
                other = np.random.default_rng([seed, step, len(model)])
                for lasts, half_life in HALF_LIVES.items():
                    memory = half_life / np.log(2.0)
                    noisy = module + error(other, len(module), step, memory)
                    for night in (False, True):
                        fit = fit_fem(*usual, noisy, **how, night=night)
                        at |= {"lasts": lasts, "night": night}
                        rows += [{**at, **row} for row in held(fit, truth)]
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

{records} records from seed {low} on. Each record is a weather of its own
(`datasets.synthetic`) and, for each steady model and dynamics, a module whose
coefficients are drawn about the sites of the paper, with an error of the sensor of
{noise:g} K that stays for half an hour. `fit_fem` sees it as it sees any record. The
tables have the share of 95 % intervals (`fit.confidence_interval()`) that hold the true
coefficient. If it is 95 %,
19 of 20 shares of {records} records are from {least:.1f} to {most:.1f} %, and the
lowest of the {cells} of a table is near {tail:.1f} %.
"""


LASTING = """\
## An error that lasts for days

Half of the sensor's error of {noise:g} K remains after a day, or after a week. The
models are `faiman` with `ewm` and `wm1` with `balance`. The first column of the bias
has the intervals of `fit_fem`. The second has intervals from daily errors alone, which
take days as independent;
`_statistics/daily_memory.py` has the difference. If that at least
doubles an error, and the residual lasts for longer than a tenth of the fitted days, a
note of the fit says that the days are too few to tell how long. The last column is the
share of fits with that note. Shares are in percent, of {records} records and two
models: if one is 95 %, 19 of 20 are within {spread:.1f} points of it.
"""


def share(part, what="held"):
    return f"{100 * part[what].mean():.1f}" if len(part) else "–"


def page(table, records, shift):
    """The tables, as Markdown."""
    slow, table = table[table["lasts"] != ""], table[table["lasts"] == ""]
    known = table[table["known"]]
    keys = ["model", "dynamics", "name"]
    one, *_ = CASES
    cells = known[known["case"] == one].groupby(keys).ngroups
    spread = 100 * np.sqrt(0.95 * 0.05 / records)
    yield INTRO.format(
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
    yield from memory_page(slow[slow["known"]], records)


def memory_page(known, records):
    """The table of errors that last for days."""
    spread = 196 * np.sqrt(0.95 * 0.05 / (2 * records))
    yield LASTING.format(noise=NOISE, records=records, spread=spread)
    yield "| half-life | record | rows | bias | by day alone | law | memory | noted |"
    yield "|---|---|---|---|---|---|---|---|"
    groups = known.groupby(["lasts", "case", "night"], sort=False)
    for (lasts, case, night), rows in groups:
        memory = rows["name"].isin(["tau", "capacity"])
        bias = rows["name"] == "bias"
        cells = " | ".join(
            share(part, what)
            for part, what in (
                (rows[bias], "held"),
                (rows[bias], "alone"),
                (rows[~bias & ~memory], "held"),
                (rows[memory], "held"),
                (rows[bias], "few"),
            )
        )
        yield f"| {lasts} | {case} | {'day and night' if night else 'day'} | {cells} |"
    yield ""


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=300)
    parser.add_argument("--shift", type=int, default=0, help="the first seed")
    parser.add_argument("--out", type=Path, help="Markdown; standard output if none")
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    table = run(options.records, options.shift, options.processes)
    lines = page(table, options.records, options.shift)
    text = "\n".join(lines)
    publish(text, options.out, "make coverage")


if __name__ == "__main__":
    main()
