"""Which absent effect could explain what a fit leaves."""

from collections.abc import Iterable

import numpy as np
import pandas as pd
from pvlib.location import Location

from pvlib_fem.drivers import DERIVED, MODELLED, checked_place, geometry
from pvlib_fem.effects import EffectLike
from pvlib_fem.effects.candidates import candidates
from pvlib_fem.fitting.result import FemFit
from pvlib_fem.loop.criteria import Criteria
from pvlib_fem.loop.family import Family
from pvlib_fem.loop.gather import gather
from pvlib_fem.loop.table import Ranking, table_of
from pvlib_fem.loop.weights import as_row, ranked
from pvlib_fem.paper.filters import counted
from pvlib_fem.quality.screen import screened
from pvlib_fem.reasons import Reason, because
from pvlib_fem.record.columns import (
    COLUMNS as USUAL,
    numeric,
    usable_drivers,
    with_aliases,
)
from pvlib_fem.record.inputs import as_record, with_columns


def rank_effects(
    fit: FemFit,
    data: pd.DataFrame,
    effects: EffectLike | Iterable[EffectLike] | None = None,
    criteria: Criteria | None = None,
    location: Location | None = None,
    surface_tilt: float | None = None,
    surface_azimuth: float | None = None,
) -> pd.DataFrame:
    """
    Rank absent effects by what each would explain on days it has not seen.

    Every effect enters as the tangent of the fitted model, conditional on the
    tangents of all fitted coefficients and on the confounders that any misfit
    leaves (a year's swing, curvature, a slower mass), so that none is credited
    with repairing those. Gains are measured on weeks left out in turn.

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
    effects : str, Effect, or sequence of these, optional
        Candidates; by default all, and those columns.
    criteria : Criteria, optional
        Thresholds other than the usual.
    location : pvlib.location.Location, optional
        With the two angles it adds the effects that follow the sun, as in
        :func:`close_loop`.
    surface_tilt, surface_azimuth : float, optional
        Of the module, from horizontal and from north. [°]

    Returns
    -------
    DataFrame
        A row for each absent effect, best first, those with an impossible
        coefficient after the others:

        ``gain``: what it takes off the held-out daytime error, the root of the
        fall of its mean square, negative for a rise [K];
        ``p_value``: chance that as much of it shows where it is not, by the
        spread between weeks, for this candidate alone;
        ``coefficients``, ``stderr``: dicts of what it would take;
        ``physical``: whether those are within the effect's bounds, as far as
        their errors let say;
        ``minimum_detectable``: the smallest gain that this record would have
        shown, with the criteria's chance and power [K];
        ``rows``: on which its drivers are there;
        ``ties``: other candidates that explain as much, given which it has
        nothing left to explain: the record cannot tell them apart;
        ``note``: what stands in the way.

        ``attrs["notes"]`` say what of the record was not measured and is left out.

    Raises
    ------
    ValueError
        If a column lacks or is unusable, or the place is none.
    """
    place = checked_place(location, surface_tilt, surface_azimuth)
    criteria = criteria or Criteria()
    columns = with_aliases(data)
    usual = as_record(*(columns.pop(name) for name in USUAL))
    usual = with_columns(usual, numeric(columns))
    record, faults = screened(usual, criteria.limits, check_units=False)
    taken = (*DERIVED, *MODELLED)
    drivers, refused = usable_drivers(columns, record, criteria.most_missing, taken)
    there = {effect.name for effect in fit.effects}
    sun = geometry(record.index, **place)
    testable, notes = candidates({**drivers, **sun}, refused, effects, there)
    model = fit.thermal_model
    record = with_columns(record.only([*USUAL, *drivers]), sun)
    seen = counted(record.inputs.columns, fit.night)
    seen &= record.known(model.drivers)
    rows = {name: {"note": str(why)} for name, why in notes.items()}
    days = len(np.unique(record.dates[seen]))
    if days < criteria.folds:
        few = str(because(Reason.FEW_DAYS, days=days, least=criteria.folds))
        rows |= {effect.name: {"note": few} for effect in testable}
    else:
        coefficients = {**model.steady_model.fixed, **fit.coefficients}
        family = Family.counted(testable)
        found = gather(
            model,
            coefficients,
            record,
            seen,
            testable,
            criteria,
            family,
            fit.at_bound,
        )
        rows |= {n: as_row(*row) for n, row in ranked(found, days).items()}
    table = table_of(rows)
    order = pd.DataFrame({"no": table["physical"].ne(True), "loss": -table["gain"]})
    order = order.sort_values(["no", "loss"], kind="stable").index
    ranking = Ranking(table.loc[order].rename_axis("effect"))
    ranking.attrs["notes"] = faults.notes
    return ranking
