"""Which absent effect could explain what a fit leaves."""

import numpy as np
import pandas as pd

from pvlib_fem.effects.candidates import candidates
from pvlib_fem.loop.evidence import gather
from pvlib_fem.paper.filters import counted
from pvlib_fem.record.checks import measured
from pvlib_fem.record.columns import COLUMNS as USUAL
from pvlib_fem.record.columns import filled, usable_drivers, with_aliases
from pvlib_fem.statistics.clusters import FOLDS

ENOUGH_DAYS = 60  # below this even pure noise looks like an effect

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
    usual = [columns.pop(name) for name in USUAL]
    drivers, refused = usable_drivers(columns, usual)
    there = {effect.name for effect in fit.effects}
    testable, notes = candidates(drivers, refused, effects, there)
    model = fit.thermal_model
    record = measured(*usual, check_units=False, **filled(drivers))
    seen = counted(record.inputs.columns, fit.night)
    rows = {name: {"note": note} for name, note in notes.items()}
    if (days := len(np.unique(record.dates[seen]))) < FOLDS:
        few = f"{days} days are too few to hold any out"
        rows |= {effect.name: {"note": few} for effect in testable}
    else:
        coefficients = {**model.steady_model.fixed, **fit.coefficients}
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
    if effect.confounder:
        suspect = "another shape would be it"
    elif "p_dc" in effect.drivers:  # power measures irradiance, too
        suspect = "suspect the irradiance sensor"
    return f"informative, but not as this effect: {suspect}"
