"""Close the loop: from the residual to the missing effects, and their gain."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any, cast

import numpy as np
import pandas as pd
from pvlib.location import Location
from pvlib.pvsystem import AbstractMount

from pvlib_fem._fitting.parquet_fit import given_days, in_files
from pvlib_fem._fitting.stand_ins import stand_in_names
from pvlib_fem._former_names import arguments_in_new_names, keys_in_new_names
from pvlib_fem._loop.assemble import loop_of_search
from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._loop.preparation.planes import with_given
from pvlib_fem._loop.preparation.prepare import prepared_case
from pvlib_fem._loop.preparation.replacements import NOTHING, Replacements
from pvlib_fem._loop.progress import stage_reporter
from pvlib_fem._loop.references.edge_weeks import edge_weeks
from pvlib_fem._loop.regression.refits import Fits
from pvlib_fem._loop.results.corrected_times import Times
from pvlib_fem._loop.results.loop_files import Reading
from pvlib_fem._loop.results.loop_result import Loop
from pvlib_fem._loop.results.parquet_loop import OwnSteps, in_means
from pvlib_fem._loop.search import Search
from pvlib_fem._loop.threads import one_blas_thread
from pvlib_fem._record.checks import dates_of
from pvlib_fem._record.column_names import printable, with_aliases
from pvlib_fem._record.parquet import ParquetRecord, as_source, is_data_set
from pvlib_fem._spelling import written_argument
from pvlib_fem._thermal.model import ThermalModel
from pvlib_fem._thermal.steady_models import steady_model
from pvlib_fem.drivers import checked_place
from pvlib_fem.drivers._mounts import plane_of_rows
from pvlib_fem.drivers._planes import ByColumns
from pvlib_fem.drivers._transposition import check_transposition
from pvlib_fem.effects import EffectLike
from pvlib_fem.types import FilePath


@arguments_in_new_names({"min_gain": "min_rmse_reduction"})
def close_loop(
    data: pd.DataFrame | ParquetRecord | FilePath,
    model: str = "faiman",
    location: Location | None = None,
    surface_tilt: float | pd.Series | None = None,
    surface_azimuth: float | pd.Series | None = None,
    holdout: pd.Series | None = None,
    min_rmse_reduction: float | None = None,
    effects: EffectLike | Iterable[EffectLike] | None = None,
    check_units: bool = True,
    criteria: Criteria | None = None,
    fixed: Mapping[str, float] | None = None,
    progress: Callable[[str], object] | bool | None = None,
    transposition: str | None = None,
    stand_ins: str | Iterable[str] = (),
    mount: AbstractMount | None = None,
) -> Loop:
    """
    Trace the residual of a fit to the physical effects that the model misses.

    The weeks of a record are divided once. On *fitting* weeks the model is fitted and
    linearised, and the remaining error is described by single effects: each is one
    effect of the catalogue, one column of the user's own, or one fault of an
    instrument from a date on. An effect is there where its gain on weeks left out in
    turn is material, its size is possible, and its probability is at least
    ``criteria.min_probability``. Each has the probabilities of all candidates that
    would explain the same, with that of a cause outside the catalogue among them. One
    candidate with ``criteria.min_probability`` is *identified*; else the finding is
    *ambiguous*, with the smallest set of candidates that has it together. The model is
    fitted with all of them and linearised anew until nothing changes. The *test*
    weeks, of which no decision sees the module's temperature, give the errors that are
    reported.

    Parameters
    ----------
    data : DataFrame, str, path-like or ParquetRecord
        With a DatetimeIndex and the columns ``poa_global`` [W/m²], ``temp_air``
        [°C], ``wind_speed`` [m/s], without which ``model`` is ``"ross"`` or
        ``"noct"``, ``temp_module`` [°C], and any of
        ``wind_direction`` [° from north], ``relative_humidity`` [%],
        ``longwave_down`` (or ``ir_down``) [W/m²], ``precipitation`` [mm/h],
        ``power_dc`` or ``power_ac`` [W] of a module or a plant, ``p_dc_per_area`` [W
        per m² of module], ``snow_depth`` [cm], ``poa_rear`` [W/m²], irradiance on the
        rear side. Every other numeric column is a candidate driver of its own,
        ``driver:<column>``. Or Parquet files of such a record, as :func:`fit_fem` takes
        them: the loop is then of means over ``criteria.search_step``, and ``own_steps``
        its last model fitted to the record's own steps, which have to confirm each
        finding.
    model : str, default "faiman"
        A steady model by name, as in :func:`pvlib_fem.fit_fem`.
    location : pvlib.location.Location, optional
        With both angles below, effects that follow the sun can be tested.
    surface_tilt, surface_azimuth : float or Series, optional
        Of the module; azimuth from north, clockwise. If they change with time, they are
        Series, or columns of ``data`` with these names. Where a location is given and
        neither of them, they are estimated from the light of clear days. [°]
    holdout : Series of bool, optional
        The test rows, or days of a record in files. By default every fifth week, or
        every other day of a record below five weeks.
    min_rmse_reduction : float, optional
        Short for ``criteria=Criteria(min_rmse_reduction=...)``: reduction of the RMSE
        below which nothing is added to the model. [K]
    effects : str, Effect, or sequence of these, optional
        Effects to try; by default all, and the user's own columns.
    check_units : bool, default True
        Refuse columns that look to be in another unit.
    criteria : Criteria, optional
        Thresholds other than the usual.
    fixed : dict, optional
        Coefficients that are held, as ``{"tau": 378}``.
    progress : callable or True, optional
        Called with a few words at the beginning of each stage; True shows them on one
        line. The log ``pvlib_fem`` has them at its level INFO.
    transposition : str, optional
        Where there is no ``poa_global``, the model of the sky by which it is made of
        ``ghi`` [W/m²], ``"perez"`` or ``"haydavies"``, as
        :func:`pvlib_fem.transpose_record` does, also in files. ``predict`` does so,
        too.
    stand_ins : str or sequence of str, optional
        Second sources that stand in for air temperature or wind where these are
        missing, such as ``temp_air_2``, as :func:`pvlib_fem.fill_record` does.
        ``predict`` does so, too. Without it a second source is a cross-check alone. In
        files one stands in only for a column that is missing.
    mount : pvlib.pvsystem.SingleAxisTrackerMount, optional
        A tracker, instead of the two angles. By night, and wherever ``get_orientation``
        gives no angles, the modules are horizontal.

    Returns
    -------
    Loop

    Raises
    ------
    ValueError
        If the record is unusable: times, columns, units; the message names the
        column, the value and the remedy.

    Notes
    -----
    How it decides is in :doc:`/design`. Where a driver is missing, rows do not count
    for its effect; nothing is filled in.

    Below ``criteria.min_days`` no effect is added.

    If the fitting weeks show a standstill of a tracker that may begin or end in a test
    week, and there is no power, that week becomes a fitting week, except where
    ``holdout`` is given. A note says so.

    References
    ----------
    .. [1] A. C. Cameron and D. L. Miller, "A Practitioner's Guide to
       Cluster-Robust Inference", J. Human Resources 50, 317-372, 2015.
       :doi:`10.3368/jhr.50.2.317`
    .. [2] G. Wang, A. Sarkar, P. Carbonetto and M. Stephens, "A simple new approach
       to variable selection in regression, with application to genetic fine mapping",
       J. R. Stat. Soc. B 82, 1273-1300, 2020. :doi:`10.1111/rssb.12388`
    .. [3] J. Wakefield, "Bayes factors for genome-wide association studies: comparison
       with P-values", Genet. Epidemiol. 33, 79-86, 2009. :doi:`10.1002/gepi.20359`

    Examples
    --------
    >>> import pvlib_fem as fem
    >>> data = fem.simulator.record(effects=fem.simulator.PHYSICS, days=70, step=600)
    >>> loop = fem.close_loop(data[["poa_global", "temp_air", "wind_speed",
    ...                             "temp_module"]])
    >>> sorted(loop.weeks.unique())
    ['fitting', 'test']
    """
    criteria = criteria or Criteria()
    if min_rmse_reduction is not None:
        criteria = replace(criteria, min_rmse_reduction=min_rmse_reduction)
    place = checked_place(location, surface_tilt, surface_azimuth, mount)
    how: dict[str, Any] = dict(
        holdout=holdout,
        effects=effects,
        check_units=check_units,
        fixed=keys_in_new_names(fixed) if fixed else fixed,
        criteria=criteria,
    )
    if transposition:
        frame = isinstance(data, pd.DataFrame)
        check_transposition(
            transposition, plane_of_rows(data, place) if frame else place
        )
    calm = not steady_model(model).takes_wind
    instead = Replacements.of_arguments(transposition, stand_ins, calm)
    return finished_search(data, model, place, progress, instead, **how)[1]


def finished_search(
    data: pd.DataFrame | ParquetRecord | FilePath,
    model: str,
    place: dict[str, Any],
    progress: Callable[[str], object] | bool | None,
    instead: Replacements = NOTHING,
    **how: Any,
) -> tuple[Search, Loop]:
    """
    A finished search, and the loop that it gives.

    Parameters
    ----------
    data, model, progress
        See :func:`close_loop`.
    place : dict
        From :func:`pvlib_fem.drivers.checked_place`.
    instead : Replacements, optional
    **how
        Further arguments of :func:`pvlib_fem._loop.preparation.prepare.prepared_case`.

    Returns
    -------
    Search, Loop
    """
    given = {n: written_argument(v) for n, v in (how | instead.arguments).items()}
    # LAPACK's last bits depend on the number of threads, and its matrices here are
    # small
    with one_blas_thread(), stage_reporter(progress) as report:
        own: OwnSteps | None = None
        replaced: dict[str, Any] = {}
        steady = steady_model(model)
        plain = ThermalModel(steady, "balance")
        if is_data_set(data):
            if isinstance(place["mount"], ByColumns):
                raise ValueError(
                    "surface_tilt and surface_azimuth as Series do not go with files; "
                    "write them into the files as columns"
                )
            report("reading the files")
            source, criteria = as_source(data), how["criteria"]
            source, replaced = instead.of_files(source, place, criteria.limits)
            instead = Replacements(calm=instead.calm)
            frame, screened = in_means(in_files(source, plain), criteria)
            own = OwnSteps(screened)
            if how["holdout"] is not None:
                days = np.isin(dates_of(frame.index), given_days(how["holdout"]))
                how["holdout"] = pd.Series(days, frame.index)
        else:  # anything but a frame is refused below
            frame = cast(pd.DataFrame, data)
        others = stand_in_names(instead.stand_ins)
        plain.refuse_without_wind({**with_aliases(frame, ()), **others})
        frame, site = with_given(frame, place)
        spared: list[int] = []
        while True:
            report("checking the record")
            case = prepared_case(frame, site, **how, instead=instead, spared=spared)
            search = Search(Fits(case), report, own=own)
            last, base = search.run(steady)
            if how["holdout"] is not None:
                break
            more = edge_weeks(search.case, last.model.effects, len(spared))
            if not len(more):
                break
            spared = sorted({*spared, *more.tolist()})
        report("measuring the errors of the test weeks")
        loop = loop_of_search(search, last, base)
        if own is not None:
            loop = own.confirmed(loop)
    case = search.case
    index = cast(pd.DatetimeIndex, frame.index)  # else it had been refused
    times = Times.from_indices(index, case.kept, case.whole.index, search.clock)
    if own is None:
        sky = instead.transposition if case.transposed else ""
        replaced = {"transposition": sky, "stand_ins": case.standing}
    reading = Reading(rows=len(frame.index), notes=notes_of(frame))
    return search, replace(
        loop,
        given=given,
        times=times,
        reading=reading,
        standings=case.standings,
        detachments=case.detachments,
        **replaced,
    )


def notes_of(data: pd.DataFrame) -> list[str]:
    """What was done to data as they were read, where a function noted it."""
    notes = data.attrs.get("notes", ())
    return [printable(one) for one in notes] if isinstance(notes, list | tuple) else []
