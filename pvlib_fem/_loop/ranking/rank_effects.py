"""Rank absent effects by how much of the residual of a fit they could explain."""

from collections.abc import Container, Iterable, Mapping

import numpy as np
import pandas as pd
from pvlib.location import Location
from pvlib.pvsystem import AbstractMount

from pvlib_fem._fitting.fem_fit import FemFit
from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._loop.preparation.planes import plane_of_columns, with_given
from pvlib_fem._loop.ranking.ranking import ranked
from pvlib_fem._loop.ranking.ranking_table import Ranking, table_of
from pvlib_fem._loop.regression.gather import Linearisation
from pvlib_fem._loop.regression.hourly_tangents import design_of_evidence
from pvlib_fem._loop.selection.single_effects import Selection
from pvlib_fem._record.column_names import (
    COLUMNS as USUAL,
    GEOMETRY,
    numeric,
    plant_power,
    usable_drivers,
    with_aliases,
)
from pvlib_fem._record.filters import counted
from pvlib_fem._record.inputs import as_record, with_columns
from pvlib_fem._statistics.clusters import FOLDS
from pvlib_fem.drivers import DERIVED, MODELLED, checked_place, needed_for
from pvlib_fem.drivers._mounts import axis_of
from pvlib_fem.effects import EffectLike
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._testable_effects import candidates, candidates_about_axis
from pvlib_fem.quality._noon import geometry_of_means
from pvlib_fem.quality._screen import screened
from pvlib_fem.reasons import Because, Reason, because


def refuse_missing(
    effects: Iterable[Effect], columns: Container[str], refused: Mapping[str, Because]
) -> None:
    """Refuse a record without a column that an effect of a fit needs."""
    for effect in effects:
        for name in needed_for(effect.drivers):
            if name in columns:
                continue
            if name in GEOMETRY:
                remedy = "give location, surface_tilt and surface_azimuth"
            else:
                remedy = "give it, or rank a fit without the effect"
            why = f" ({refused[name]})" if name in refused else ""
            raise ValueError(
                f"{effect.name} of the fit needs {name}, which is not in the "
                f"record{why}; {remedy}"
            )


def rank_effects(
    fit: FemFit,
    data: pd.DataFrame,
    effects: EffectLike | Iterable[EffectLike] | None = None,
    criteria: Criteria | None = None,
    location: Location | None = None,
    surface_tilt: float | pd.Series | None = None,
    surface_azimuth: float | pd.Series | None = None,
    mount: AbstractMount | None = None,
) -> pd.DataFrame:
    """
    Rank absent effects by what each would explain on days it has not seen.

    Every effect enters as the tangent of the fitted model, conditional on the
    tangents of all fitted coefficients and on errors of the steady model's shape
    (curvature, a slower mass, a late record), so that none is credited with
    repairing those. Gains are measured on weeks left out in turn.

    This ranks; it names no cause. Effects that follow the same columns share
    their gain, and what no effect here can explain is not looked for.

    Parameters
    ----------
    fit : FemFit
    data : DataFrame
        The record in pvlib's names (``poa_global``, ``temp_air``, ``wind_speed``,
        ``temp_module``) with what else was measured, such as ``wind_direction``
        [° from north], ``p_dc_per_area`` [W per m² of module],
        ``longwave_down`` [W/m²], ``precipitation`` [mm/h]. Every other numeric column
        that varies is a candidate of its own, ``driver:<column>``.
    effects : str, Effect, or sequence of these, optional
        Candidates; by default all, and those columns.
    criteria : Criteria, optional
        Thresholds other than the usual.
    location : pvlib.location.Location, optional
        With the two angles it adds the effects that follow the sun, as in
        :func:`close_loop`.
    surface_tilt, surface_azimuth : float or Series, optional
        Of the module, from horizontal and from north; of one that moves Series, or
        columns of ``data``. [°]
    mount : pvlib.pvsystem.SingleAxisTrackerMount, optional
        A tracker, instead of the two angles.

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
        their errors allow;
        ``minimum_detectable``: the smallest gain that this record would have
        shown in four of five cases [K];
        ``rows``: on which its drivers are there;
        ``ties``: other candidates that explain as much, given which it has
        nothing left to explain: the record cannot tell them apart;
        ``note``: what stands in the way.

        ``attrs["notes"]`` say which values were not measured and are not used.

    Raises
    ------
    ValueError
        If a column is missing or unusable, one that an effect of the fit needs among
        them, or the place is none.
    """
    place = checked_place(location, surface_tilt, surface_azimuth, mount)
    criteria = criteria or Criteria()
    data, place = plane_of_columns(*with_given(data, place))
    columns = with_aliases(data, (*fit.thermal_model.usual, "temp_module"))
    usual = as_record(*(columns.pop(name, None) for name in USUAL))
    usual = with_columns(usual, numeric(columns))
    record, faults = screened(usual, criteria.limits, check_units=False)
    taken = (*DERIVED, *MODELLED)
    drivers, refused = usable_drivers(
        columns, record, criteria.max_missing_share, taken
    )
    drivers |= plant_power(record, criteria.max_missing_share)
    there = {effect.name for effect in fit.effects}
    light, limits = record["poa_global"], criteria.limits
    sun, lines = geometry_of_means(light, record.index, place, limits)
    known = {**drivers, **sun}
    testable, notes = candidates(known, refused, effects, there, record.absent)
    testable, fixed_plane = candidates_about_axis(testable, axis_of(place))
    notes |= fixed_plane
    model = fit.thermal_model
    record = with_columns(record.only([*USUAL, *drivers]), sun)
    refuse_missing(fit.effects, record.inputs.columns, refused)
    seen = counted(record.inputs.columns, fit.night)
    seen &= record.complete_rows(model.drivers)
    rows = {name: {"note": str(why)} for name, why in notes.items()}
    days = len(np.unique(record.dates[seen]))
    if days < FOLDS:
        few = str(because(Reason.FEW_DAYS, days=days, least=FOLDS))
        rows |= {effect.name: {"note": few} for effect in testable}
    else:
        coefficients = {**model.steady_model.fixed, **fit.coefficients}
        bounds, least = fit.at_bound, criteria.min_hint_reduction
        at = Linearisation(model, coefficients, record, seen, bounds, least)
        evidence = at.evidence(testable, {})
        design = design_of_evidence(evidence, record, drivers, coefficients)
        selection = Selection(design, criteria)
        weighed, failed = ranked(selection, evidence, [*design.base], days)
        rows |= {name: {"note": str(why)} for name, why in failed.items()}
        rows |= {name: row.content() for name, row in weighed.items()}
    table = table_of(rows)
    order = pd.DataFrame({"no": table["physical"].ne(True), "loss": -table["gain"]})
    order = order.sort_values(["no", "loss"], kind="stable").index
    ranking = Ranking(table.loc[order].rename_axis("effect"))
    ranking.attrs["notes"] = [*faults.notes, *lines]
    return ranking
