"""Which absent effect could explain what a fit leaves."""

import numpy as np
import pandas as pd

from pvlib_fem import paper
from pvlib_fem.dailysums import FOLDS
from pvlib_fem.drivers import ALIASES, GEOMETRY, needed_for
from pvlib_fem.effect import Effect, Parameter, Terms
from pvlib_fem.effects import EFFECTS, VARIANTS, find
from pvlib_fem.evidence import gather
from pvlib_fem.records import measured

ENOUGH_DAYS = 60  # below this even pure noise looks like an effect
MOST_HEAT = 500.0  # W/m² for one standard deviation of a user's own column
#: the same sunlight in other planes: no cause of its own
IRRADIANCES = ("ghi", "dni", "dhi", "poa_direct", "poa_diffuse")
#: what a user gives where these columns lack
SUN = {"solar_zenith": "location", "solar_azimuth": "location"}
SOME = 20_000  # rows that are enough to compare columns
LEAK = 0.05  # of a column's variance that the answer leaves, where it is a leak
MOST_MISSING = 0.2  # of a driver's rows

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
    there = {effect.name for effect in fit.effects}
    testable, notes = candidates(drivers, refused, effects, there)
    model = fit.thermal_model
    record = measured(*usual, check_units=False, **filled(drivers))
    seen = paper.counted(record.inputs.columns, fit.night)
    rows = {name: {"note": note} for name, note in notes.items()}
    if (days := len(np.unique(record.dates[seen]))) < FOLDS:
        few = f"{days} days are too few to hold any out"
        rows |= {effect.name: {"note": few} for effect in testable}
    else:
        coefficients = {**model.law.fixed, **fit.coefficients}
        fixed = fit.at_bound
        found = gather(model, coefficients, record, seen, testable, fixed)
        rows |= ranked(found, days)
    table = pd.DataFrame.from_dict(rows, orient="index")
    table = table.reindex(columns=COLUMNS).rename_axis("effect")
    order = pd.DataFrame({"no": table["physical"].ne(True), "loss": -table["gain"]})
    return table.loc[order.sort_values(["no", "loss"], kind="stable").index]


def ranked(found, days):
    """Rows of all candidates, each beside the shapes that any misfit leaves."""
    rows = {name: {"note": note} for name, note in found.failed.items()}
    beside = found.nuisances
    for name in found.effects:
        effect = found.effects[name]
        estimated = effect.settings.get("source")
        note = f"from {estimated}" if estimated else ""
        row = rows[name] = {"note": note, **found.weigh(name, beside)}
        if "gain" not in row:
            continue
        if not row["physical"] and row["gain"] > 0:
            row["note"] = impossible(effect)
        elif days < ENOUGH_DAYS:
            row["note"] = f"suggestive at best: {days} days, of {ENOUGH_DAYS}"
    gains = {name: row["gain"] for name, row in rows.items() if row.get("physical")}
    for name in gains:
        rows[name]["ties"] = found.ties(name, gains, beside)
    return rows


def impossible(effect):
    """Words for what helps with a coefficient that cannot be."""
    suspect = "suspect its sensor"
    if effect.shape:
        suspect = "another shape would be it"
    elif "p_dc" in effect.drivers:  # power measures irradiance, too
        suspect = "suspect the irradiance sensor"
    return f"informative, but not as this effect: {suspect}"


def filled(drivers):
    """Drivers without gaps: their median says least where they are missing."""
    return {name: column.fillna(column.median()) for name, column in drivers.items()}


def candidates(drivers, refused, effects, there=()):
    """Effects whose drivers are there, and for the others the reason they are not."""
    if effects is None:
        known = {n for e in EFFECTS.values() for n in measured_for(e)}
        own = [driver(n, column) for n, column in drivers.items() if n not in known]
        wanted = [*EFFECTS, *own]
    else:
        wanted = list(effects)
    testable, notes = [], {}
    for choice in wanted:
        effect = find(choice)
        if effect.name in there:
            continue
        # by its name alone it takes the best of what is there
        variants = VARIANTS.get(choice) if isinstance(choice, str) else None
        for variant in variants or (effect,):
            lacking = [n for n in needed_for(variant.drivers) if n not in drivers]
            if not lacking:
                testable.append(variant)
                break
        else:
            lacking = [n for n in needed_for(effect.drivers) if n not in drivers]
            why = [refused[name] for name in lacking if name in refused]
            none = [SUN.get(name, name) for name in lacking if name not in refused]
            if none:
                why.append(f"no {', '.join(sorted(set(none)))}")
            notes[effect.name] = "; ".join(why)
    return testable, notes


def measured_for(effect):
    """Columns that any variant of an effect needs."""
    variants = VARIANTS.get(effect.name, (effect,))
    return [n for variant in variants for n in needed_for(variant.drivers)]


def with_aliases(data, needed=paper.COLUMNS):
    """Columns of a frame by the package's names, with those that are needed."""
    columns = {str(name): data[name] for name in data}
    for alias, name in ALIASES.items():
        if alias in columns:
            columns.setdefault(name, columns.pop(alias))
    if missing := [name for name in needed if name not in columns]:
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
        elif np.isinf(column).any():
            refused[name] = f"{name} is infinite at {np.isinf(column).idxmax()}"
        elif column.notna().sum() == 0:
            refused[name] = f"{name} holds no value"
        elif column.isna().mean() > MOST_MISSING:
            refused[name] = f"{column.isna().mean():.0%} of {name} is missing"
        elif column.nunique() < 2 and name not in GEOMETRY:
            refused[name] = f"{name} is constant"
        elif copies := [n for n, other in seen.items() if same(column, other)]:
            refused[name] = f"{name} is a copy of {copies[0]}"
        else:
            used[name] = seen[name] = column.astype(float)
    return used, refused


def same(one, other):
    """Whether one column is another, but for a factor and an offset."""
    some = slice(None, None, max(1, len(one) // SOME))
    return alike(one[some], other[some]) and alike(one, other)


def alike(one, other):
    both = one.notna() & other.notna()
    x, y = one[both].astype(float), other[both].astype(float)
    if both.sum() < 3 or x.std() == 0 or y.std() == 0:
        return False
    return abs(np.corrcoef(x, y)[0, 1]) > 1.0 - 1e-9


def leaks(record, seen, modelled, names):
    """
    Columns that are the module temperature, or made from it.

    Those that the measured temperature, as it is, a little before and after and
    smoothed, foretells far better than all that a model knows.
    """
    module = pd.Series(record["temp_module"]).interpolate(limit_direction="both")
    near = [module, module.shift(1), module.shift(-1), module.rolling(5, 1).mean()]
    known = [record["poa_global"], record["temp_air"], record["wind_speed"], modelled]
    rows = np.flatnonzero(seen & np.isfinite(modelled))[1:-1]
    rows = rows[:: max(1, len(rows) // SOME)]
    without = np.column_stack([np.ones(len(rows)), *(c[rows] for c in known)])
    with_it = np.column_stack([without, *(c.to_numpy()[rows] for c in near)])
    for name in names:
        column = record[name][rows]
        before, after = (unexplained(column, x) for x in (without, with_it))
        if after < LEAK and after < 0.5 * before:
            yield name


def unexplained(column, others):
    """Share of a column's variance that others leave."""
    found = np.linalg.lstsq(others, column, rcond=None)[0]
    return np.var(column - others @ found) / max(np.var(column), 1e-300)


def driver(name, column):
    """A column of the user's own as an effect: heat that follows it."""
    mean, most = float(column.mean()), MOST_HEAT / float(column.std())

    def terms(values, *, heat):
        """Heat for each unit of the column beyond its mean."""
        return Terms(heat=heat * (values - mean))

    row = Parameter(0.0, -most, most, f"W/m² per unit of {name}")
    return Effect(
        f"driver:{name}",
        terms,
        {"heat": row},
        columns=(name,),
        shape=name in IRRADIANCES,
        decided_by=f"what {name} stands for",
    )
