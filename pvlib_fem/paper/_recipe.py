"""The paper's own recipe, step by step, for fits with ``method="paper"``."""

from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem import scores
from pvlib_fem._fitting.fem_fit import FemFit
from pvlib_fem._fitting.fit_stages import last_stage
from pvlib_fem._fitting.least_squares_fit import of_minimum, requests_of
from pvlib_fem._record.column_names import COLUMNS, DAYLIGHT
from pvlib_fem._record.filters import night
from pvlib_fem._record.inputs import Record
from pvlib_fem._spelling import LEAST_SQUARES, ShellText, argument, refusal
from pvlib_fem._thermal.model import ThermalModel
from pvlib_fem._thermal.steady_models import STEADY_MODELS
from pvlib_fem.paper import _estimators as paper
from pvlib_fem.paper._estimators import Estimate
from pvlib_fem.paper._timeconstant import time_constant

METHODS = ("least_squares", "paper")  # of a fit
MODELS = ("ross", "sapm", "faiman", "wm1", "wm2")  # that the paper compares
OFFSETS = ("night", "calm")  # names of offsets; others are a number [K], or None


def refuse_paper(target: ThermalModel, fixed: Any, night: bool) -> None:
    """
    Refuse models and options that the paper's recipe does not have.

    Parameters
    ----------
    target : ThermalModel
    fixed : dict or None
        Coefficients that the user holds.
    night : bool
        Whether night rows are fitted.

    Raises
    ------
    ValueError
        Naming the option that ``method="paper"`` does not have, and the remedy.
    """
    name, paper = target.steady_model.name, argument("method", "paper")
    if name not in MODELS:
        has = f" has no {name}; it has {', '.join(MODELS)}, or use "
        raise refusal(paper, has, LEAST_SQUARES)
    if target.dynamics == "balance":
        ewm = argument("dynamics", "ewm")
        raise refusal(paper, " has no heat balance; use ", ewm, ", or ", LEAST_SQUARES)
    if target.effects:
        raise refusal(paper, " has no effects; use ", LEAST_SQUARES)
    if fixed:
        raise refusal(paper, " holds nothing; use ", LEAST_SQUARES)
    if night:
        raise ValueError("method='paper' is for daytime rows; use night=False")


def fit_paper(
    frame: Any,
    target: ThermalModel,
    notes: list,
    calm_wind: float,
    offset: float | str | None,
) -> FemFit:
    """
    Fit a model to a record in memory by the paper's recipe.

    Parameters
    ----------
    frame : Frame
        The checked record, its rows that count and its held-out rows.
    target : ThermalModel
        Without effects and with ``"steady"`` or ``"ewm"`` as dynamics.
    notes : list of str
        Notes of the fit; those of the recipe are appended.
    calm_wind : float
        Wind speed below which the air counts as calm. [m/s]
    offset : float, str or None
        Over-temperature without irradiance [K], ``"night"`` or ``"calm"``; None
        subtracts nothing.

    Returns
    -------
    FemFit
        Without standard errors.

    Raises
    ------
    ValueError
        If a step has too few points, the coefficients make no model, or the offset is
        unknown.
    """
    train, kept = frame.counts, ~frame.out
    stages = paper_stages(target, frame.record, train, kept, calm_wind, offset, notes)
    coefficients, own = (
        last_stage(stages)[1],
        frame.result_parts(*requests_of(stages), ())[1],
    )
    notes.append("no errors: the paper's recipe gives none")
    return FemFit(
        **of_minimum(
            target, coefficients, dict.fromkeys(coefficients, np.nan), (), True
        ),
        **own,
        method="paper",
        notes=tuple(notes),
    )


def paper_stages(
    target: ThermalModel,
    record: Record,
    train: np.ndarray,
    not_held_out: np.ndarray,
    calm_wind: float,
    offset: float | str | None,
    notes: list,
) -> dict:
    """
    Model and coefficients after each step of the paper's recipe.

    Parameters
    ----------
    target : ThermalModel
        Without effects and with ``"steady"`` or ``"ewm"`` as dynamics.
    record : Record
    train, not_held_out : array of bool, shape (rows,)
        Fitted rows, and all rows that are not held out, nights included.
    calm_wind : float
        Wind speed below which the air counts as calm. [m/s]
    offset : float, str or None
        Over-temperature without irradiance [K], ``"night"`` or ``"calm"``; None
        subtracts nothing.
    notes : list of str
        Notes of the steps are appended.

    Returns
    -------
    dict of (ThermalModel, dict)
        Model and coefficients by step: ``standard``, ``filter``, ``ewm`` and ``fem``.

    Raises
    ------
    ValueError
        If a step has too few points, the coefficients make no model, or the offset is
        unknown.
    """
    frame = pd.DataFrame({n: record[n] for n in COLUMNS}, record.index)
    everything, rows = (
        tuple(frame.loc[part, name] for name in COLUMNS)
        for part in (not_held_out, train)
    )
    steady_model = target.steady_model
    plain = standard_coefficients(steady_model.name, everything)
    offset = over_temperature_offset(offset, everything, rows, calm_wind, notes)
    filtered = filter_coefficients(steady_model.name, rows, calm_wind, offset)
    notes += [
        f"{step}: {estimate.note}"
        for step, estimates in (("standard", plain), ("filter", filtered))
        for estimate in estimates.values()
        if estimate.note
    ]
    points = {name: estimate.points for name, estimate in filtered.items()}
    steady = ThermalModel(steady_model, "steady")
    without_filter, values = (
        {name: estimate.value for name, estimate in estimates.items()}
        | steady_model.fixed
        for estimates in (plain, filtered)
    )
    memory = {}
    if target.dynamics == "ewm":
        k = calm_line(rows, calm_wind, offset)
        tau = time_constant(*[*rows, k.value])
        memory = {"tau": tau.value}
        points["tau"] = tau.points
        notes.append(
            "tau is the paper's, from step changes; it decreases as the true time "
            "constant increases (see paper.time_constant)"
        )
    counted = ", ".join(f"{name} {count}" for name, count in points.items())
    notes.append(f"points used: {counted}")
    without = {**values, **memory, "bias": 0.0}
    bias = scores.mbe(
        record["temp_module"][train], target.temperature(record.inputs, without)[train]
    )
    return {
        "standard": (steady, {**without_filter, "bias": 0.0}),
        "filter": (steady, {**values, "bias": 0.0}),
        "ewm": (target, without),
        "fem": (target, {**without, "bias": bias}),
    }


def over_temperature_offset(
    offset: Any, everything: tuple, daytime: Any, calm_wind: Any, notes: list
) -> float | None:
    """Offset that the regressions subtract from over-temperature [K], or None."""
    if offset == "night" and np.sum(night(*everything)) < paper.CALM_POINTS:
        notes.append(
            "fewer than 20 night rows give no offset: the calm line's is taken"
        )
        offset = "calm"
    if offset == "night":
        offset = paper.night_bias(*everything).value
        notes.append(f"over-temperature less its mean by night, {offset:.2f} K")
    elif offset == "calm":
        offset = paper.r_eq_max(*[*daytime, calm_wind]).intercept
        notes.append(f"over-temperature less the calm line's intercept, {offset:.2f} K")
    elif offset is not None and (isinstance(offset, str) or not np.isfinite(offset)):
        raise ValueError(
            f"unknown offset {offset!r}; it is {', '.join(OFFSETS)}, a number of K, or "
            "None"
        )
    return offset


def calm_line(record: Any, calm_wind: Any, offset: Any) -> Any:
    """The k of calm air; the line goes through the origin if the offset is known."""
    return paper.r_eq_max(
        *[*record, calm_wind], intercept=offset is None, offset=offset or 0.0
    )


def filter_coefficients(
    model: str, record: Any, calm_wind: float = 0.5, offset: Any = 0.0
) -> dict:
    """
    Coefficients of a model by the paper's recipe, with the Filter step.

    Ross's k, Sandia's a and b and Faiman's u0 and u1 are from one regression of
    five-minute averages (above 200 W/m² for the latter two). WM1 and WM2 use the k
    of calm air and a second regression.

    Parameters
    ----------
    model : str
        ``"ross"``, ``"sapm"``, ``"faiman"``, ``"wm1"`` or ``"wm2"``.
    record : tuple of Series
        ``poa_global``, ``temp_air``, ``wind_speed``, ``temp_module``.
    calm_wind
        See :func:`pvlib_fem.paper.r_eq_max`.
    offset : float or None, default 0
        Over-temperature without irradiance, which every regression subtracts. With
        None nothing is subtracted, and lines over irradiance have an intercept. [K]

    Returns
    -------
    dict of Estimate

    Raises
    ------
    ValueError
        If a step has too few points, or the coefficients make no model.
    """
    if model in ("wm1", "wm2"):
        estimates = {"k": calm_line(record, calm_wind, offset)}
        if model == "wm1":
            k = estimates["k"].value
            estimates["d"] = paper.d(*[*record, k], offset=offset or 0.0)
        else:
            estimates["k_w"] = paper.k_w(*record, intercept=offset is None)
    else:
        frame = paper.averages(*record).dropna()
        frame["over"] -= offset or 0.0
        condition = "any wind"
        if model != "ross":
            condition = "more than 200 W/m² and T_o > 0"
            frame = frame[(frame["poa_global"] > 200) & (frame["over"] > 0)]
        remedy = "use a longer record"
        paper.require_points(model, len(frame), paper.MIN_POINTS, condition, remedy)
        estimates = one_regression(model, frame, intercept=offset is None)
    check_possible(model, estimates)
    return estimates


def check_possible(model: str, estimates: dict) -> None:
    """Refuse coefficients that are invalid for the model."""
    try:
        STEADY_MODELS[model].complete({n: e.value for n, e in estimates.items()})
    except ValueError as error:
        raise refusal(
            f"the paper's regressions give no model: {error}; use ",
            ShellText("another offset ('night', 'calm' or in K), or ", ""),
            LEAST_SQUARES,
        ) from error


def standard_coefficients(model: str, record: tuple) -> dict:
    """
    Coefficients of a model without the Filter step: one regression of all rows.

    WM1 is the Sandia model with other parameters, WM2 a regression on two columns.
    Parameters and result are those of :func:`filter_coefficients`.

    Notes
    -----
    The paper does not define its standard WM1 and WM2, and this implementation differs
    from it: the paper's Table 5 has 3.29 K for WM1 and 3.04 K for the Sandia model, and
    mean errors of -0.84 and +0.17 K; here both models are equal.
    """
    frame = pd.DataFrame(dict(zip(COLUMNS, record)))
    frame["over"] = frame["temp_module"] - frame["temp_air"]
    frame = frame[frame["poa_global"] > DAYLIGHT].dropna()
    if model not in ("ross", "wm2"):
        frame = frame[frame["over"] > 0]
    paper.require_points(
        f"standard {model}", len(frame), paper.MIN_POINTS, "no filter", "use more data"
    )
    return one_regression(model, frame, intercept=False)


def one_regression(model: str, frame: pd.DataFrame, intercept: bool) -> Any:
    poa, wind, over = (
        frame[c].to_numpy() for c in ("poa_global", "wind_speed", "over")
    )
    points = len(frame)
    if model == "ross":
        k, _ = paper.regression_line(poa, over, intercept)
        return {"k": paper.Estimate(k, "K m²/W", points)}
    if model == "faiman":
        u1, u0 = paper.regression_line(wind, poa / over)
        return {
            name: plausible_coefficient(name, v, points)
            for name, v in (("u0", u0), ("u1", u1))
        }
    if model == "wm2":
        columns = np.column_stack([poa, -poa * np.minimum(wind, 8.0)])
        (k, slope), *_ = np.linalg.lstsq(columns, over, rcond=None)
        return {
            "k": paper.Estimate(float(k), "K m²/W", points),
            "k_w": paper.Estimate(float(slope), "K m s/W", points),
        }
    b, a = paper.regression_line(wind, np.log(over / poa))
    if model == "sapm":
        return {
            "a": paper.Estimate(a, "ln(K m²/W)", points),
            "b": paper.Estimate(b, "s/m", points),
        }
    return {
        "k": paper.Estimate(float(np.exp(a)), "K m²/W", points),
        "d": paper.Estimate(-1.0 / b, "m/s", points),
    }


def plausible_coefficient(name: str, value: float, points: int) -> Estimate:
    """Faiman's coefficient, or its default instead of an outlier."""
    row = STEADY_MODELS["faiman"].parameters[name]
    if row.lower <= value <= row.upper:
        return paper.Estimate(value, row.unit, points)
    note = (
        f"{name} is Faiman's own {row.start:g} {row.unit}, as in the paper for "
        f"outliers, and not this record's: the regression of {points} points gives "
        f"{value:.3g}"
    )
    return paper.Estimate(row.start, row.unit, 0, note=note)
