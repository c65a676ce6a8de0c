"""What the paper's recipe leaves by what it takes off over-temperature before.

For `make offsets`; prints the table of docs/paper.md. Held-out RMSE [K], mean over
the four models that know the wind, without those that are refused.
"""

import pandas as pd

import pvlib_fem as fem
from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem.simulator import ALBUQUERQUE, LINEAR, OUTDOORS, PHYSICS, RHINE, drawn

OFFSETS = {"nothing": None, "calm": "calm", "night": "night", "0 K": 0.0}
MODELS = ("wm1", "wm2", "sapm", "faiman")
DAYS = 20
FRESH = range(301, 307)
FUENTES = PHYSICS | {"sky_radiation": 0.0}


def records():
    """Name and records of each row of the table."""
    yield "measured week", [fem.datasets.load("sandia_week")]
    for bias in (0.0, -2.0, -5.0):
        truth = dict(u0=25.0, u1=6.84, capacity=15e3, bias=bias)
        some = [fem.datasets.synthetic(DAYS, seed=s, **truth) for s in range(3)]
        yield f"one mass, offset {bias:g} K", some
    for name, effects in (("without a sky", LINEAR), ("outdoors", OUTDOORS)):
        some = [
            fem.simulator.record(site, effects, DAYS, start=start, seed=seed)
            for site, start, seed in (
                (RHINE, "2023-06-01", 1),
                (RHINE, "2023-02-01", 4),
                (ALBUQUERQUE, "2023-03-01", 2),
                (ALBUQUERQUE, "2023-10-01", 3),
            )
        ]
        yield f"first principles, {name}", some
    # of which none was seen before the default was chosen
    sites = [(RHINE, ALBUQUERQUE)[seed % 2] for seed in FRESH]
    months = [f"2022-{1 + 2 * i:02d}-05" for i in range(len(FRESH))]
    for name, effects in (("drawn laws", OUTDOORS), ("fuentes", FUENTES)):
        some = [
            fem.simulator.record(
                site,
                effects,
                DAYS,
                start=start,
                seed=seed,
                generator="nodes" if effects is OUTDOORS else "fuentes",
                forms=drawn(seed, site),
            )
            for seed, site, start in zip(FRESH, sites, months)
        ]
        yield name, some


def error(data, model, offset):
    """Held-out RMSE, NaN where the recipe refuses. [K]"""
    index = data.index
    odd = (index.normalize() - index[0].normalize()).days % 2 == 1
    try:
        fit = fem.fit_fem(
            *(data[name] for name in COLUMNS),
            model=model,
            method="paper",
            calm_wind=1.0,
            offset=offset,
            holdout=pd.Series(odd, index),
            check_units=False,
        )
    except ValueError:
        return float("nan")
    return fit.scores.loc["fem", "rmse_test"]


def main():
    rows = {}
    for name, some in records():
        for words, offset in OFFSETS.items():
            errors = pd.Series([error(d, m, offset) for d in some for m in MODELS])
            cell = f"{errors.mean():.2f}"
            if refused := int(errors.isna().sum()):
                cell += f" ({refused} of {len(errors)} refused)"
            rows.setdefault(name, {})[words] = cell
    print(pd.DataFrame(rows).T.to_string())


if __name__ == "__main__":
    main()
