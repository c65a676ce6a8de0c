"""Which absent effect could explain what a fit leaves."""

from dataclasses import replace

import numpy as np
import pandas as pd
from scipy.stats import chi2

from pvlib_fem import paper
from pvlib_fem.dailysums import FOLDS, daily_sums
from pvlib_fem.drivers import ALIASES, needed_for
from pvlib_fem.effect import Effect, Parameter, Terms
from pvlib_fem.effects import EFFECTS, find
from pvlib_fem.model import thermal_model
from pvlib_fem.records import measured
from pvlib_fem.relaxation import relax

ENOUGH_DAYS = 60  # below this even pure noise looks like an effect
POWER = 2.8  # errors that a coefficient needs to be seen 4 times in 5 at 5 %
MOST_HEAT = 500.0  # W/m² for one standard deviation of a user's own column
MOST_MISSING = 0.2  # of a driver's rows
RIVAL = 0.6  # share of the best gain from which a candidate is a rival
TIED = 0.15  # share of its own gain that is left beside a rival it is tied with
YEAR = 365.25  # days


COLUMNS = [
    "gain",
    "p_value",
    "coefficients",
    "stderr",
    "physical",
    "detectable",
    "ties",
    "note",
]


def rank_effects(fit, data, effects=None) -> pd.DataFrame:
    """
    Rank absent effects by what each would explain on days it has not seen.

    Every effect enters as the tangent of the fitted model, beside the tangents
    of all fitted coefficients and beside shapes that any misfit leaves (a year's
    swing, curvature, a slower mass), so that none is credited with repairing
    those. Gains are measured on weeks left out in turn.

    This ranks; it names no cause. Effects that follow the same columns share
    their gain, and what no effect here can explain is not looked for.

    Parameters
    ----------
    fit : FemFit
    data : DataFrame
        The record in pvlib's names (``poa_global``, ``temp_air``, ``wind_speed``,
        ``temp_module``) with what else was measured, such as ``wind_direction``
        [° from north], ``p_dc`` [W per m² of module], ``longwave_down`` [W/m²],
        ``precipitation`` [mm/h]. Every other numeric column that varies is a
        candidate of its own, ``driver:<column>``.
    effects : sequence of str or Effect, optional
        Candidates; by default all, and those columns.

    Returns
    -------
    DataFrame
        A row for each absent effect, best first, those with an impossible
        coefficient after the others:

        ``gain``: what it takes off the held-out daytime error, the root of the
        fall of its mean square, negative for a rise [K];
        ``p_value``: chance that as much of it shows where it is not, by the
        spread between days, for this candidate alone;
        ``coefficients``, ``stderr``: dicts of what it would take;
        ``physical``: whether those are within two errors of the effect's bounds;
        ``detectable``: the smallest gain that this record would have shown [K];
        ``ties``: other candidates that explain as much, beside which it has
        nothing left to explain: the record cannot tell them apart;
        ``note``: what stands in the way.

    Raises
    ------
    ValueError
        If a column lacks or is unusable.
    """
    columns = with_aliases(data)
    usual = [columns.pop(name) for name in paper.COLUMNS]
    drivers, refused = usable_drivers(columns, usual)
    model = thermal_model(fit.model, fit.dynamics, fit.effects)
    rows, testable = {}, []
    for effect in absent(fit, drivers, effects):
        if lacking := [n for n in needed_for(effect.drivers) if n not in drivers]:
            why = [refused.get(name, f"no {name}") for name in lacking]
            rows[effect.name] = {"note": "; ".join(why)}
        else:
            testable.append(effect)
    record = measured(*usual, check_units=False, **drivers)
    rows |= explained(fit, model, record, testable)
    table = pd.DataFrame.from_dict(rows, orient="index")
    table = table.reindex(columns=COLUMNS).rename_axis("effect")
    order = pd.DataFrame({"no": table["physical"].ne(True), "loss": -table["gain"]})
    return table.loc[order.sort_values(["no", "loss"], kind="stable").index]


def with_aliases(data):
    """Columns of the record by the package's names."""
    columns = {str(name): data[name] for name in data}
    for alias, name in ALIASES.items():
        if alias in columns:
            columns.setdefault(name, columns.pop(alias))
    if missing := [name for name in paper.COLUMNS if name not in columns]:
        raise ValueError(
            f"data lack {', '.join(missing)}; they have {', '.join(columns)}"
        )
    return columns


def usable_drivers(columns, usual):
    """Numeric columns that say something of their own, and why others do not."""
    used, refused = {}, {}
    seen = dict(zip(paper.COLUMNS, usual))
    for name, column in columns.items():
        if not pd.api.types.is_numeric_dtype(column):
            refused[name] = f"{name} is not numeric"
        elif column.notna().sum() == 0:
            refused[name] = f"{name} holds no value"
        elif column.isna().mean() > MOST_MISSING:
            refused[name] = f"{column.isna().mean():.0%} of {name} is missing"
        elif column.nunique() < 2:
            refused[name] = f"{name} is constant"
        elif copies := [n for n, other in seen.items() if same(column, other)]:
            refused[name] = f"{name} is a copy of {copies[0]}"
        else:
            used[name] = seen[name] = column.astype(float)
    return used, refused


def same(one, other):
    """Whether one column is another, but for a factor and an offset."""
    both = one.notna() & other.notna()
    x, y = one[both].astype(float), other[both].astype(float)
    if both.sum() < 3 or x.std() == 0 or y.std() == 0:
        return False
    return abs(np.corrcoef(x, y)[0, 1]) > 1.0 - 1e-9


def absent(fit, drivers, effects):
    """Candidates that the fit does not hold yet."""
    if effects is None:
        known = {n for e in EFFECTS.values() for n in needed_for(e.drivers)}
        own = [driver(n, column) for n, column in drivers.items() if n not in known]
        candidates = [*EFFECTS.values(), *own]
    else:
        candidates = [find(name) for name in effects]
    there = {effect.name for effect in fit.effects}
    return [effect for effect in candidates if effect.name not in there]


def driver(name, column):
    """A column of the user's own as an effect: heat that follows it."""
    mean, most = float(column.mean()), MOST_HEAT / float(column.std())

    def terms(values, *, heat):
        """Heat for each unit of the column beyond its mean."""
        return Terms(heat=heat * (values - mean))

    row = Parameter(0.0, -most, most, f"W/m² per unit of {name}")
    return Effect(f"driver:{name}", terms, {"heat": row}, columns=(name,))


def explained(fit, model, record, candidates):
    """Rows of the ranking, all from one pass over the record."""
    larger = replace(model, effects=(*fit.effects, *candidates))
    inputs = larger.with_drivers(record.inputs)
    own = {e.name: list(e.rows()) for e in candidates}
    start = {n: row.start for e in candidates for n, row in e.rows().items()}
    values = {**model.law.fixed, **fit.coefficients, **start}
    temperature, slopes = larger.slopes(inputs, values)
    seen = paper.daytime(*(record[name] for name in paper.COLUMNS))
    seen &= np.isfinite(temperature)
    dates = record.dates[seen]
    if (days := len(np.unique(dates))) < FOLDS:
        return {n: {"note": f"{days} days are too few to hold any out"} for n in own}

    base = [name for name in model.parameters if name not in fit.at_bound]
    over = temperature - values["bias"] - record["temp_air"]
    slopes = {**slopes, **shapes(over, record)}
    names = [*base, *(n for n in slopes if n.startswith("shape:")), *start]
    columns = np.stack([slopes[name][seen] for name in names], axis=1)
    sums = daily_sums(columns, (record["temp_module"] - temperature)[seen], dates)
    place = {name: i for i, name in enumerate(names)}
    nuisance = [place[name] for name in names if name not in start]
    where = {name: [place[n] for n in rows] for name, rows in own.items()}
    before = sums.left(nuisance)
    table = {
        effect.name: weighed(effect, sums, nuisance, where[effect.name], before)
        for effect in candidates
    }
    rivals = {n: row for n, row in table.items() if row.get("physical")}
    for name, row in rivals.items():
        row["ties"] = ties(name, rivals, sums, nuisance, where)
    return table


def weighed(effect, sums, nuisance, own, before):
    """One row of the ranking."""
    if not all(sums.beside(column, []) > 0 for column in own):
        return {"note": "it adds nothing in this record's weather"}
    beside = np.array([sums.beside(column, nuisance) for column in own])
    if (beside < 1e-6).any():
        return {"note": "the record cannot tell it from the fitted coefficients"}
    kept = [*nuisance, *own]
    step = sums.solve(kept)[len(nuisance) :]
    covariance = sums.covariance(kept)[len(nuisance) :, len(nuisance) :]
    error = np.sqrt(np.diag(covariance))
    names, scale = list(effect.rows()), sums.scale[own]
    coefficients = dict(zip(names, (step / scale).tolist()))
    physical = all(
        row.lower - near <= coefficients[name] <= row.upper + near
        for (name, row), near in zip(effect.rows().items(), 2.0 * error / scale)
    )
    change = before - sums.left(kept)
    note = ""
    if not physical and change > 0:
        note = f"informative, but not as {effect.name}: suspect the irradiance sensor"
    elif sums.days < ENOUGH_DAYS:
        note = f"suggestive at best: {sums.days} days, of {ENOUGH_DAYS}"
    return {
        "gain": float(np.sign(change) * np.sqrt(abs(change))),
        "p_value": float(chi2.sf(step @ np.linalg.solve(covariance, step), len(own))),
        "coefficients": coefficients,
        "stderr": dict(zip(names, (error / scale).tolist())),
        "physical": physical,
        "detectable": float(POWER * (error * beside).max()),
        "ties": (),
        "note": note,
    }


def ties(name, rivals, sums, nuisance, where):
    """Rivals beside which a candidate has nothing left to explain."""
    own = max(rivals[name]["gain"], 0.0) ** 2
    tied = []
    for other, row in rivals.items():
        if other == name or max(row["gain"], 0.0) ** 2 < RIVAL * own or own == 0.0:
            continue
        without = sums.left([*nuisance, *where[other]])
        if without - sums.left([*nuisance, *where[other], *where[name]]) < TIED * own:
            tied.append(other)
    return tuple(tied)


def shapes(over, record):
    """
    What a misshapen model leaves, as columns that no effect is credited with.

    Functions of the usual inputs alone, which every cause without a driver of
    its own shares: a year's swing, curvature in the over-temperature and in the
    wind, its fall with air temperature, and a slower mass.
    """
    wind, air = record["wind_speed"], record["temp_air"]
    turn = 2.0 * np.pi * record.dates / YEAR
    hour = 3600.0 / record.inputs.unit
    columns = {
        "summer": over * np.cos(turn),
        "spring": over * np.sin(turn),
        "curved": over * np.sqrt(np.abs(over)),
        "calm": over * np.exp(-wind / 0.7),
        "gusty": over * np.sqrt(wind),
        "warm": over * (air - np.nanmean(air)),
        "slow": relax(over, record.inputs.steps, hour) - over,
        "slower": relax(over, record.inputs.steps, 3.0 * hour) - over,
    }
    return {f"shape:{name}": column for name, column in columns.items()}
