"""Fit the FEM coefficients to a measured record, with standard errors."""

import inspect
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
from pvlib.location import Location
from pvlib.pvsystem import AbstractMount

from pvlib_fem._fitting.fem_fit import FemFit
from pvlib_fem._fitting.frame_rows import as_frame
from pvlib_fem._fitting.least_squares_fit import fit_source
from pvlib_fem._fitting.parquet_fit import fit_files, in_files
from pvlib_fem._fitting.search import with_fixed
from pvlib_fem._former_names import keys_in_new_names
from pvlib_fem._loop.preparation.planes import plane_of_columns, with_given
from pvlib_fem._loop.preparation.replacements import Replacements
from pvlib_fem._record.column_names import ALWAYS, COLUMNS, by_own_names, with_aliases
from pvlib_fem._record.inputs import as_record
from pvlib_fem._record.parquet import ParquetRecord, is_data_set
from pvlib_fem._spelling import (
    LEAST_SQUARES,
    ShellText,
    argument,
    did_you_mean,
    no_columns,
    refusal,
)
from pvlib_fem._thermal.model import ThermalModel, thermal_model
from pvlib_fem.drivers import checked_place, needed_for
from pvlib_fem.drivers._mounts import axis_of
from pvlib_fem.effects import EffectLike, find, several
from pvlib_fem.effects._testable_effects import about_axis, candidates
from pvlib_fem.paper._recipe import METHODS, fit_paper, refuse_paper
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._noon import geometry_of_means
from pvlib_fem.types import FilePath

MEMORIES = ("tau", "capacity")  # a dynamic model has one of these
NAMED = ShellText(
    "name its column, and give location, surface_tilt and surface_azimuth",
    "name a column with --map, the place with --lat, --lon, --tilt and --azimuth",
)


def fit_fem(
    poa_global: pd.Series | pd.DataFrame | ParquetRecord | FilePath,
    temp_air: pd.Series | None = None,
    wind_speed: pd.Series | None = None,
    temp_module: pd.Series | None = None,
    model: str = "wm1",
    dynamics: str = "ewm",
    method: str = "least_squares",
    holdout: pd.Series | None = None,
    calm_wind: float = 0.5,
    check_units: bool = True,
    effects: EffectLike | Iterable[EffectLike] = (),
    night: bool = False,
    fixed: Mapping[str, float] | None = None,
    offset: float | str | None = "night",
    limits: Limits | None = None,
    **drivers: pd.Series,
) -> FemFit:
    """
    Fit a steady model, made dynamic, to measured module temperature.

    The FEM method: Filter, Exponential weighted mean, Mean bias [1]_. By
    default all coefficients, the time constant and the bias are fitted
    together by least squares.

    Parameters
    ----------
    poa_global : Series, DataFrame, str, path-like or ParquetRecord
        Irradiance in the plane of the array, with a DatetimeIndex. [W/m²] Or a frame
        with all columns; or a file, folder or pattern of Parquet files, a pyarrow
        Dataset, or the result of :func:`open_parquet`, which are read in blocks and
        need not fit into memory.
    temp_air : Series
        Air temperature. [°C]
    wind_speed : Series, optional
        Wind speed. The models ``"ross"`` and ``"noct"`` need none. [m/s]
    temp_module : Series
        Measured module temperature. [°C]
    model : str, default "wm1"
        ``"ross"``, ``"sapm"``, ``"faiman"``, ``"wm1"``, ``"wm2"``, ``"pvsyst"``,
        ``"noct"`` or ``"noct_sam"``.
    dynamics : str, default "ewm"
        ``"steady"``; ``"ewm"``, the paper's smoothing of irradiance and wind
        with one tau; ``"balance"``, the exact heat balance.
    method : str, default "least_squares"
        Or ``"paper"``: the paper's own recipe, with regressions of five-minute
        averages for the coefficients, step changes for tau and the mean error
        of the training days for the bias.
    holdout : Series of bool, optional
        Rows to hold out, or days of a record in files. By default these are weekend
        days, as in the paper, if the record has two weekends, else every other day.
    calm_wind : float, default 0.5
        Wind below which the air is calm for ``method="paper"``. [m/s]
    check_units : bool, default True
        Refuse columns that seem to be in another unit, or swapped.
    effects : str, dict, Effect or sequence of them, optional
        Physical effects to fit in addition to the model: by name
        (``pvlib_fem.effects.EFFECTS``), by name and settings, as ``{"name":
        "sky_radiation", "source": "humidity"}``, or your own. ``scores`` has a row
        for each, in this order.
    night : bool, default False
        Whether night rows count, too. Without nights, as in the paper, the
        coefficients are best for energy; nights show more of sky and storage.
    fixed : dict, optional
        Known coefficients that are not fitted, as ``{"tau": 378.0}`` or
        ``{"rain.film": 20.0}``; they have no error. It may also hold constants of the
        model, such as the ``module_efficiency`` of pvsyst, to replace their defaults.
    offset : str, float or None, default "night"
        Over-temperature without irradiance, which ``method="paper"`` subtracts
        before its regressions: ``"night"``, its mean at night; ``"calm"``, the
        intercept of the regression in calm air; a number [K]; or None to subtract
        nothing (k keeps its line's intercept). The docs' page on the paper compares
        them.
    limits : pvlib_fem.quality.Limits, optional
        Thresholds of the screening.
    **drivers : Series
        Further columns that the effects need, by name: ``wind_direction`` [°
        from north], ``p_dc_per_area`` [W per m² of module], ``longwave_down`` [W/m²],
        ``relative_humidity`` [%], ``precipitation`` [mm/h], ``snow_depth`` [cm],
        ``poa_rear`` [W/m²], and
        ``solar_zenith``, ``solar_azimuth``, ``surface_tilt``, ``surface_azimuth``
        [°]; ``pvlib_fem.drivers.sun`` computes the first two.

    Returns
    -------
    FemFit
        A fit of files has no ``residual``; ``write_residual(path)`` writes it.

    Raises
    ------
    ValueError
        If the record is unusable (times, columns, units, too many impossible
        values), a name is unknown, or a step has too few points. The message
        names the column or step, the value and the remedy.

    Notes
    -----
    Implausible values (:func:`pvlib_fem.screen_record`) are not used, and ``notes``
    list them.

    The residual counts on the rows of the paper's daytime filter
    (:mod:`pvlib_fem.paper`); the recursion runs over all rows, night included.
    Standard errors are from the jackknife over training days, so they are robust to
    autocorrelation within a day. The variance from correlation between days is added;
    ``notes`` report where it is large, and where the days are too few to estimate
    it. Below 5 training days errors are NaN.

    Wind that is recorded in whole m/s moves the coefficients, u0 of Faiman's model by
    some 2 %. From steps of 0.25 m/s on, the size of this shift is estimated by rounding
    the wind to steps twice as wide. It is added to the errors, and ``notes`` report it
    where it is large.

    Over missing rows the next sample counts for the whole step. With 5 % of the rows of
    a 5 min record missing, ``capacity`` or ``tau`` is some 2 % too large, which the
    error does not include; fill short gaps of the drivers on a straight line first.

    The tau of ``method="paper"`` decreases as the true time constant increases, see
    the table at :func:`pvlib_fem.paper.time_constant`. That method gives no errors.

    References
    ----------
    .. [1] B. Herteleer et al., "Investigating methods to improve photovoltaic
       thermal models at second-to-minute timescales", 2022, Eq. 28.
       :doi:`10.22541/au.166922866.68736478`
    """
    fixed = keys_in_new_names(fixed) if fixed else fixed
    target = with_fixed(
        thermal_model(model, dynamics, map(find, several(effects))), fixed or {}
    )
    drivers = by_own_names(drivers)
    refuse_coefficients(target, drivers)
    if not (is_data_set(poa_global) or isinstance(poa_global, pd.DataFrame)):
        target.check_drivers(drivers)
    if method not in METHODS:
        raise ValueError(f"unknown method {method!r}; they are {', '.join(METHODS)}")
    if method == "paper":
        refuse_paper(target, fixed, night)
    others = [temp_air, wind_speed, temp_module]
    columns = [poa_global, *others]
    how = (holdout, night, limits, check_units)
    if is_data_set(poa_global):
        refuse_columns(others, drivers, method)
        return fit_files(in_files(poa_global, target), target, *how)
    if isinstance(poa_global, pd.DataFrame):
        refuse_columns(others, drivers)
        there = with_aliases(poa_global, (*ALWAYS, *target.drivers))
        columns = [there.get(name) for name in COLUMNS]
        drivers = {name: there[name] for name in target.drivers}
    given = [name for name, column in zip(COLUMNS, columns) if column is not None]
    if missing := [name for name in ALWAYS if name not in given]:
        raise ValueError(
            f"{no_columns(missing)}; give a Series of each, or a DataFrame"
        )
    target.refuse_without_wind([*given, *drivers])
    frame, notes = as_frame(columns, drivers, target, *how)
    if method == "paper":
        if frame.record.absent:
            paper = argument("method", "paper")
            raise refusal(paper, " needs wind_speed; give it, or use ", LEAST_SQUARES)
        return fit_paper(frame, target, notes, calm_wind, offset)
    return fit_source(frame, target, notes)


def fit_frame(
    data: pd.DataFrame,
    effects: EffectLike | Iterable[EffectLike] = (),
    location: Location | None = None,
    surface_tilt: float | pd.Series | None = None,
    surface_azimuth: float | pd.Series | None = None,
    transposition: str | None = None,
    stand_ins: str | Iterable[str] = (),
    mount: AbstractMount | None = None,
    **options: Any,
) -> FemFit:
    """
    Fit a frame, with the drivers that its effects need.

    Parameters
    ----------
    data : DataFrame
        Record, see :func:`pvlib_fem.close_loop`.
    effects : str, dict, Effect or sequence of them
        See :func:`pvlib_fem.fit_fem`.
    location, surface_tilt, surface_azimuth, mount
        Site and plane, see :func:`pvlib_fem.close_loop`; none is estimated.
    transposition, stand_ins
        See :func:`pvlib_fem.close_loop`.
    **options
        Arguments of :func:`pvlib_fem.fit_fem`.

    Returns
    -------
    FemFit
    """
    place = checked_place(location, surface_tilt, surface_azimuth, mount)
    data, place = plane_of_columns(*with_given(data, place))
    instead = Replacements.of_arguments(transposition, stand_ins)
    how = (options.get("limits"), options.get("check_units", True))
    filled = instead.filled(data, ALWAYS, place, *how)
    columns, notes = filled.columns, filled.notes
    there: dict[str, Any] = columns
    sun, lines = {}, []
    if effects:
        record = as_record(*(columns.get(name) for name in COLUMNS))
        light, limits = record["poa_global"], options.get("limits")
        sun, lines = geometry_of_means(light, record.index, place, limits)
        there = {**sun, **columns}
    absent = [name for name in COLUMNS if name not in columns]
    chosen, missing = candidates(there, {}, effects, absent=absent)
    chosen = about_axis(chosen, axis_of(place))
    for name, why in missing.items():
        raise refusal(f"the effect {name} cannot be fitted: {why}; ", NAMED)
    wanted = {name for effect in chosen for name in needed_for(effect.drivers)}
    drivers = {name: there[name] for name in there if name in wanted}
    notes = (*notes, *lines) if {*drivers} & {*sun} else notes
    usual: list[Any] = [columns.get(name) for name in COLUMNS]
    fit = fit_fem(*usual, effects=chosen, **options, **drivers)
    return replace(fit, notes=(*notes, *fit.notes)) if notes else fit


def refuse_columns(
    columns: Sequence[pd.Series | None],
    drivers: Mapping[str, pd.Series],
    method: str = "",
) -> None:
    """Refuse columns in addition to a frame or files, and the paper's recipe."""
    given = [name for name, one in zip(COLUMNS[1:], columns) if one is not None]
    if given := [*given, *drivers]:
        meant = did_you_mean(list(drivers), inspect.signature(fit_fem).parameters)
        raise ValueError(
            f"{', '.join(given)} {'are' if len(given) > 1 else 'is'} given in addition "
            f"to a record{meant}; give the record alone, with all drivers in its "
            "columns (pvlib_fem.drivers.sun finds the sun), or its columns one by one"
        )
    if method == "paper":
        paper = argument("method", "paper")
        raise refusal(paper, " takes no files; give it columns, or use ", LEAST_SQUARES)


def refuse_coefficients(target: ThermalModel, drivers: Mapping[str, Any]) -> None:
    """Refuse the number of a coefficient among the columns."""
    for name, value in drivers.items():
        if name in target.parameters or (np.isscalar(value) and name in MEMORIES):
            raise ValueError(
                f"{name} is a coefficient and no column; to hold it give "
                f"fixed={{{name!r}: {value!r}}}"
            )
