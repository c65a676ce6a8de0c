"""
What it costs to transpose horizontal irradiance, in simulated years.

Run as
``python studies/study_transposition.py [--step 600] [--loops 0]``. Each world is a
site with one of the simulator's models of the sky and of the diffuse light. Its
pyranometers, in the plane and on the horizontal, have the same error. The table is of
all worlds; ``--loops`` closes the loop on so many of them, and counts its names.
"""

import argparse
from dataclasses import replace
from itertools import product

import numpy as np
import pandas as pd
from pvlib.location import Location
from study_worlds import IN_PHYSICS

from pvlib_fem import close_loop, fit_fem, simulator, transpose_record
from pvlib_fem.drivers._transposition import TRANSPOSITIONS
from pvlib_fem.simulator._constants import wander

SITES = (simulator.RHINE, simulator.ALBUQUERQUE)
EFFECTS = simulator.PHYSICS | {"sky_radiation": 1.0}
TRUE = {"sky_radiation", *IN_PHYSICS}
ERROR, HOURS = 0.01, 1.0  # of a pyranometer, and how long it lasts [-, h]
MEASURED = "measured"


def worlds():
    """Sites whose sky and diffuse light follow each of the simulator's models."""
    forms = (simulator.RIVALS[name] for name in ("transposition", "diffuse"))
    for site, sky, diffuse in product(SITES, *forms):
        own = replace(site.forms, transposition=sky, diffuse=diffuse)
        yield replace(site, forms=own)


def records(site, seed, days=365, step=600.0):
    """The record with measured irradiance in the plane, and by each transposition."""
    data = simulator.record(site, EFFECTS, days, step, seed)
    sky = simulator.weather(site, days, step, "2023-01-01", seed)
    error = ERROR * wander(np.random.default_rng(seed), len(sky), HOURS * 3600.0 / step)
    horizontal = data.assign(ghi=sky["ghi"] * (1.0 + error))
    horizontal = horizontal.drop(columns="poa_global")
    place = (
        Location(site.latitude, site.longitude),
        site.surface_tilt,
        site.surface_azimuth,
    )
    yield MEASURED, data, place
    for name in TRANSPOSITIONS:
        made = transpose_record(horizontal, *place, name)
        yield name, made.drop(columns="ghi"), place


def row(data, truth):
    """Error of the light by day, and of a fit to it."""
    day = truth["poa_global"] > 20.0
    off = (data["poa_global"] - truth["poa_global"])[day]
    light = truth["poa_global"][day].mean()
    fit = fit_fem(data, model="faiman", dynamics="balance")
    return {
        "rms": np.sqrt((off**2).mean()) / light,
        "mean": off.mean() / light,
        "rmse": fit.scores["rmse_test"].iloc[-1],
        "u0": fit.coefficients["u0"],
        "u1": fit.coefficients["u1"],
    }


def named(data, place):
    """Names of a loop, and those of them that are not there."""
    angles = dict(zip(("location", "surface_tilt", "surface_azimuth"), place))
    found = [
        f
        for f in close_loop(data, **angles).finding_objects
        if str(f.verdict) == "identified"
    ]
    return {
        "loops": 1,
        "names": len(found),
        "wrong": sum(f.effect not in TRUE for f in found),
    }


def table_of(step=600.0, loops=0, days=365):
    """A row for each world and way to have the light, with what changes by it."""
    rows = []
    for seed, site in enumerate(worlds()):
        truth = None
        for by, data, place in records(site, seed, days, step):
            truth = data if truth is None else truth
            more = named(data, place) if seed < loops else {}
            rows.append({"world": seed, "by": by, **row(data, truth), **more})
    table = pd.DataFrame(rows).set_index(["world", "by"])
    own = table.xs(MEASURED, level="by")
    for name in ("rmse", "u0", "u1"):
        apart = table[name] - own[name].reindex(table.index, level="world")
        table[f"more {name}"] = apart
    return table


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--step", type=float, default=600.0)
    parser.add_argument("--loops", type=int, default=0)
    args = parser.parse_args()
    table = table_of(args.step, args.loops)
    many = table.index.get_level_values("world").nunique()
    print(f"{many} worlds, step {args.step:g} s; mean, least and most")
    for by, part in table.groupby("by", sort=False):
        print(f"\n{by}")
        for name, column in part.items():
            if name in ("loops", "names", "wrong"):
                if args.loops:
                    print(f"  {name:10} {column.sum():.0f}")
                continue
            numbers = (column.mean(), column.min(), column.max())
            print(f"  {name:10}", *(f"{number:8.3f}" for number in numbers))


if __name__ == "__main__":
    main()
