"""
How often the range of a thermal parameter holds the truth, in simulated worlds.

Run as
``python studies/study_parameters.py [--worlds 100] [--out
docs/study_parameters.md]``. Each world has a weather of its own and three modules: one
whose steady model, dynamics and coefficients are drawn, one under pvlib's
``prilliman``, and one that is measured hourly for a year. The truth of a parameter is
what its definition gives of the true coefficients.
"""

import argparse
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pvlib
from study_coverage import (
    DRIVERS,
    FUNCTIONS,
    HELD,
    MEMORY,
    NOISE,
    SPANS,
    drawn,
    error,
)
from study_page import publish

from pvlib_fem import datasets, fit_fem
from pvlib_fem._parallel import spread
from pvlib_fem._thermal_parameters.unit_mass import prilliman_mean

WORLDS = 100
DAYS, STEP = 30, 300  # of the first module [s]
FINE_DAYS, FINE_STEP = 16, 60  # of that under prilliman [s]
MASS = (4.0, 17.0)  # kg/m²
YEAR, HOUR = 365, 3600
POOL = 120  # years of other weather, whose T98 is the truth of a year's
HOW = dict(wind_height=3.0, deltaT=3.0)


def world(pooled_t98, seed):
    """Rows of one world: convention, parameter, and whether the range holds it."""
    return [*of_steady(seed), *of_mass(seed), *of_year(pooled_t98, seed)]


def judged(table, truth, names):
    """Whether ranges hold the truth, where there is a range."""
    for name in names:
        row, value = table.loc[name], truth[name]
        if np.isfinite(row["stderr"]) and row["stderr"] > 0.0:
            held = bool(row["low"] <= value <= row["high"])
            yield {"convention": name[0], "parameter": name[1], "held": held}


def of_steady(seed, days=DAYS, step=STEP):
    """All that follows from coefficients."""
    random = np.random.default_rng([seed, 1])
    models = [name for name in SPANS if name != "noct"]
    model, dynamics = models[seed % len(models)], ("balance", "ewm")[seed % 2]
    fixed = HELD.get(model, {})
    true = drawn(random, model, dynamics)
    weather = datasets.synthetic(days, step, "2023-04-03", seed, noise=0)
    usual = [weather[name] for name in DRIVERS]
    module = FUNCTIONS[dynamics](*usual, **true, model=model, **fixed)
    noisy = module + error(random, len(module), step, MEMORY)
    fit = fit_fem(*usual, noisy, model=model, dynamics=dynamics, fixed=fixed)
    table = fit.thermal_parameters(**HOW)
    truth = replace(fit, coefficients={**fit.coefficients, **true})
    true_table = truth.thermal_parameters(**HOW)
    own = [
        name
        for name in table.index
        if name[0].split(",")[0]
        in ("faiman", "sapm", "ross", "noct_sam", "pvsyst", "time constant")
        or name == ("nmot", "of the fit")
    ]
    yield from judged(table, true_table["value"], own)


def of_mass(seed):
    """The unit mass of a module under pvlib's ``prilliman``."""
    random = np.random.default_rng([seed, 2])
    mass, u0, u1 = random.uniform(*MASS), random.uniform(20, 32), random.uniform(3, 9)
    data = datasets.synthetic(FINE_DAYS, FINE_STEP, "2023-04-03", seed, noise=0)
    usual = [data[name] for name in DRIVERS]
    steady = pvlib.temperature.faiman(*usual, u0, u1)
    module = prilliman_mean(steady, data["wind_speed"], mass)
    noisy = module + error(random, len(module), FINE_STEP, MEMORY)
    table = fit_fem(*usual, noisy, model="faiman", dynamics="balance")
    name = ("prilliman", "unit_mass")
    yield from judged(table.thermal_parameters(), {name: mass}, [name])


def year(seed, noise=0.0):
    data = datasets.synthetic(YEAR, HOUR, "2023-01-01", seed, noise=0)
    random = np.random.default_rng([seed, 3])
    return data.assign(
        temp_module=data["temp_module"] + noise * error(random, len(data), HOUR, MEMORY)
    )


def pooled():
    """T98 of many years of such weather."""
    pool = [year(20_000 + n)["temp_module"] for n in range(POOL)]
    return float(pd.concat(pool).quantile(0.98))


def of_year(pooled_t98, seed):
    """T98 of a record of a year, and by the fit in the weather of another year."""
    data, other = year(seed, 1.0), year(seed + 10_000)
    fit = fit_fem(data, model="faiman", dynamics="balance")
    table = fit.thermal_parameters(typical_year=other)
    truth = {
        ("T98", "of the record"): pooled_t98,
        ("T98", "of a typical year"): float(other["temp_module"].quantile(0.98)),
    }
    yield from judged(table, truth, [*truth])


def run(worlds, shift, processes):
    """A row for each range of each world."""
    rows, begin = [], time.perf_counter()
    tasks = [(seed,) for seed in range(shift, shift + worlds)]
    for i, some in enumerate(spread(world, tasks, processes, (pooled(),)), 1):
        rows += some
        if i % 20 == 0:
            print(f"{i}: {time.perf_counter() - begin:.0f} s", file=sys.stderr)
    return pd.DataFrame(rows)


INTRO = """\
# How often a thermal parameter's range holds the truth

{worlds} worlds from seed {low} on. Each world has its own weather
(`datasets.synthetic`) and three modules. Their sensors have an error of {noise:g} K
that stays for half an hour.

* The first has one of seven steady models with `balance` or `ewm` and is measured for
  {days} days at {step} s. The truth of a parameter follows from the true coefficients
  and its definition.
* The second is Faiman's model under pvlib's `prilliman`, with a unit mass of
  {light:g} to {heavy:g} kg/m², and is measured for {fine_days} days at {fine_step} s.
* The third is measured hourly for a year. The true T98 of its record is that of {pool}
  other years of such weather. The true T98 of a typical year is that of the module
  without errors in the weather that is given.

The table has the share of 95 % ranges of `fit.thermal_parameters()` that hold the
truth. If the true share is 95 %, 19 of 20 shares of {worlds} are from {least:.0f} to
{most:.0f} %. Parameters without a range, such as a given efficiency, are not counted.
NMOT by IEC 61853-2 is not in the table: it is the result of a procedure, not a property
of these modules.

| convention | parameter | worlds | held [%] |
|---|---|---|---|"""


def page(table, worlds, shift):
    """The table, as Markdown."""
    reach = 196 * np.sqrt(0.95 * 0.05 / worlds)
    yield INTRO.format(
        worlds=worlds,
        noise=NOISE,
        low=shift,
        days=DAYS,
        step=STEP,
        light=MASS[0],
        heavy=MASS[1],
        fine_days=FINE_DAYS,
        fine_step=FINE_STEP,
        pool=POOL,
        least=95 - reach,
        most=min(95 + reach, 100),
    )
    names = ["convention", "parameter"]
    for (convention, name), rows in sorted_groups(table, names):
        share = 100 * rows["held"].mean()
        yield f"| {convention} | `{name}` | {len(rows)} | {share:.0f} |"
    yield ""
    yield f"{100 * table['held'].mean():.1f} % of {len(table):,} ranges hold the truth."
    yield ""


def sorted_groups(table, names):
    """Groups in the order of the table of thermal parameters."""
    order = {c: i for i, c in enumerate(table["convention"].unique())}
    groups = table.groupby(names, sort=False)
    return sorted(groups, key=lambda group: order[group[0][0]])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--worlds", type=int, default=WORLDS)
    parser.add_argument("--shift", type=int, default=0, help="the first seed")
    parser.add_argument("--out", type=Path, help="Markdown; standard output if none")
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    table = run(options.worlds, options.shift, options.processes)
    lines = page(table, options.worlds, options.shift)
    text = "\n".join(lines)
    publish(text, options.out, "make parameters")


if __name__ == "__main__":
    main()
