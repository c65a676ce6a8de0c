"""Which absent effect could explain what a fit leaves."""

from dataclasses import replace

import numpy as np
import pandas as pd
from scipy.stats import chi2

from pvlib_fem import paper
from pvlib_fem.effect import Effect, Parameter, Terms
from pvlib_fem.effects import EFFECTS, find
from pvlib_fem.leastsquares import day_errors
from pvlib_fem.model import thermal_model
from pvlib_fem.records import measured

FOLDS = 5  # of whole weeks, interleaved
WEEK = 7  # days in a block of a fold
ENOUGH_DAYS = 60  # below this even pure noise looks like an effect
POWER = 2.8  # errors that a coefficient needs to be seen 4 times in 5 at 5 %
MOST_HEAT = 500.0  # W/m² for one standard deviation of a user's own column
RIDGE = 1e-9  # of a column's square: what a record does not determine stays 0


def rank_effects(fit, data, effects=None) -> pd.DataFrame:
    """
    Rank absent effects by what each would explain on days it has not seen.

    Every effect enters as the tangent of the fitted model, beside the tangents
    of all fitted coefficients, so that none is credited with repairing those.
    Gains are measured on held-out weeks in turn.

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
        ``note``: what stands in the way.

    Raises
    ------
    ValueError
        If a column lacks or is unusable.
    """
    columns = with_aliases(data)
    usual = [columns.pop(name) for name in paper.COLUMNS]
    drivers, refused = usable_drivers(columns, usual)
    candidates = absent(fit, drivers, effects)
    record = measured(*usual, check_units=False, **drivers)
    model = thermal_model(fit.model, fit.dynamics, fit.effects)
    rows = {}
    for effect in candidates:
        larger = replace(model, effects=(*fit.effects, effect))
        lacking = [name for name in larger.drivers if name not in drivers]
        if lacking:
            why = [refused.get(name, f"no {name}") for name in lacking]
            rows[effect.name] = {"note": "; ".join(why)}
        else:
            rows[effect.name] = explained(fit, larger, record, effect)
    table = pd.DataFrame.from_dict(rows, orient="index")
    names = ["gain", "p_value", "coefficients", "stderr", "physical", "detectable"]
    table = table.reindex(columns=[*names, "note"]).rename_axis("effect")
    order = pd.DataFrame({"no": table["physical"].ne(True), "loss": -table["gain"]})
    return table.loc[order.sort_values(["no", "loss"], kind="stable").index]


def with_aliases(data):
    """Columns of the record by the package's names."""
    columns = {str(name): data[name] for name in data}
    if "ir_down" in columns:
        columns.setdefault("longwave_down", columns.pop("ir_down"))
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
        known = {name for effect in EFFECTS.values() for name in needs(effect)}
        own = [driver(n, column) for n, column in drivers.items() if n not in known]
        candidates = [*EFFECTS.values(), *own]
    else:
        candidates = [find(name) for name in effects]
    there = {effect.name for effect in fit.effects}
    return [effect for effect in candidates if effect.name not in there]


def needs(effect):
    return thermal_model("ross", "balance", (effect,)).drivers


def driver(name, column):
    """A column of the user's own as an effect: heat that follows it."""
    mean, most = float(column.mean()), MOST_HEAT / float(column.std())

    def terms(values, *, heat):
        """Heat for each unit of the column beyond its mean."""
        return Terms(heat=heat * (values - mean))

    row = Parameter(0.0, -most, most, f"W/m² per unit of {name}")
    return Effect(f"driver:{name}", terms, {"heat": row}, columns=(name,))


def explained(fit, model, record, effect):
    """One row of the ranking."""
    inputs = model.with_drivers(record.inputs)
    start = {name: row.start for name, row in effect.rows().items()}
    values = {**model.law.fixed, **fit.coefficients, **start}
    temperature, slopes = model.slopes(inputs, values)
    rows = paper.daytime(*(record[name] for name in paper.COLUMNS))
    rows &= np.isfinite(temperature)
    days = record.dates[rows]
    if len(np.unique(days)) < FOLDS:
        return {"note": f"{len(np.unique(days))} days are too few to hold any out"}
    own = list(start)
    base = [n for n in model.parameters if n not in own and n not in fit.at_bound]
    columns = np.stack([slopes[name][rows] for name in (*base, *own)], axis=1)
    scale = np.sqrt(np.einsum("ij,ij->j", columns, columns))
    if not scale[len(base) :].all():
        return {"note": "it adds nothing in this record's weather"}
    scale[scale == 0] = 1.0
    columns /= scale
    residual = record["temp_module"][rows] - temperature[rows]

    folds = fold_of(days)
    before, after = (
        held_out_square(columns[:, :width], residual, folds)
        for width in (len(base), len(base) + len(own))
    )
    found = solved(columns, residual)
    try:
        left = residual - columns @ found
        covariance = day_errors(columns, left, days)[len(base) :, len(base) :]
    except np.linalg.LinAlgError:
        return {"note": "the record cannot tell it from the fitted coefficients"}
    step = found[len(base) :]
    error = np.sqrt(np.diag(covariance))
    # what of the effect is left beside the fitted coefficients, per error
    beside = columns[:, len(base) :] - columns[:, : len(base)] @ solved(
        columns[:, : len(base)], columns[:, len(base) :]
    )
    size = np.sqrt((beside**2).mean(axis=0))
    own_scale = scale[len(base) :]
    coefficients = dict(zip(own, (step / own_scale).tolist()))
    change = before - after
    reach = 2.0 * error / own_scale
    physical = all(
        row.lower - near <= coefficients[name] <= row.upper + near
        for (name, row), near in zip(effect.rows().items(), reach)
    )
    note = ""
    if not physical and change > 0:
        note = f"informative, but not as {effect.name}: suspect the irradiance sensor"
    elif len(np.unique(days)) < ENOUGH_DAYS:
        note = f"suggestive at best: {len(np.unique(days))} days, of {ENOUGH_DAYS}"
    return {
        "gain": float(np.sign(change) * np.sqrt(abs(change))),
        "p_value": float(chi2.sf(step @ np.linalg.solve(covariance, step), len(own))),
        "coefficients": coefficients,
        "stderr": dict(zip(own, (error / own_scale).tolist())),
        "physical": physical,
        "detectable": float(POWER * (error * size).max()),
        "note": note,
    }


def fold_of(days):
    """Fold of each row: whole weeks in turn, or days where there are few weeks."""
    elapsed = days - days.min()
    length = WEEK if elapsed.max() >= FOLDS * WEEK else 1
    return elapsed // length % FOLDS


def held_out_square(columns, residual, folds):
    """Mean square of the residual on each fold, solved on the others."""
    total = 0.0
    normals = {fold: products(columns, residual, folds == fold) for fold in set(folds)}
    for fold in normals:
        normal = sum(n for other, (n, _) in normals.items() if other != fold)
        right = sum(r for other, (_, r) in normals.items() if other != fold)
        rows = folds == fold
        total += np.square(residual[rows] - columns[rows] @ ridged(normal, right)).sum()
    return total / len(residual)


def products(columns, residual, rows):
    part = columns[rows]
    return part.T @ part, part.T @ residual[rows]


def solved(columns, target):
    return ridged(columns.T @ columns, columns.T @ target)


def ridged(normal, right):
    return np.linalg.solve(normal + RIDGE * np.diag(np.diag(normal)), right)
