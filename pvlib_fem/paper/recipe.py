"""The paper's own recipe, step by step: what a fit by ``method="paper"`` does."""

import numpy as np
import pandas as pd

from pvlib_fem import scores
from pvlib_fem.paper import estimators as paper
from pvlib_fem.record.columns import COLUMNS, DAYLIGHT
from pvlib_fem.thermal.model import ThermalModel


def paper_stages(target, record, train, not_held_out, calm_wind, notes):
    """Model and coefficients after each step of the paper's recipe."""
    frame = pd.DataFrame({n: record[n] for n in COLUMNS}, record.index)
    everything, rows = (
        tuple(frame.loc[part, name] for name in COLUMNS)
        for part in (not_held_out, train)
    )
    plain = standard(target.steady_model.name, everything)
    filtered = recipe(target.steady_model.name, rows, calm_wind)
    points = {name: estimate.points for name, estimate in filtered.items()}
    steady = ThermalModel(target.steady_model, "steady")
    without_filter, values = (
        {name: estimate.value for name, estimate in found.items()}
        | target.steady_model.fixed
        for found in (plain, filtered)
    )
    memory = {}
    if target.dynamics == "ewm":
        k = paper.r_eq_max(*rows, calm_wind)
        tau = paper.time_constant(*rows, k.value)
        memory = {"tau": tau.value}
        points["tau"] = tau.points
        notes.append(
            "tau is the paper's, from step changes; it runs backwards (see "
            "paper.time_constant)"
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


def recipe(model, record, calm_wind=0.5, intercept=True):
    """
    Coefficients of a model the paper's way, with the Filter step.

    Ross's k, Sandia's a and b and Faiman's u0 and u1 come from one regression
    of five-minute averages (above 200 W/m² for the latter two), WM1 and WM2
    from the calm-air k and a second regression.

    Parameters
    ----------
    model : str
        ``"ross"``, ``"sapm"``, ``"faiman"``, ``"wm1"`` or ``"wm2"``.
    record : tuple of Series
        ``poa_global``, ``temp_air``, ``wind_speed``, ``temp_module``.
    calm_wind, intercept
        As in :func:`pvlib_fem.paper.r_eq_max`.

    Returns
    -------
    dict of Estimate
    """
    if model in ("wm1", "wm2"):
        k = paper.r_eq_max(*record, calm_wind, intercept)
        if model == "wm1":
            return {"k": k, "d": paper.d(*record, k.value)}
        return {"k": k, "k_w": paper.k_w(*record)}
    frame = paper.averages(*record).dropna()
    if model != "ross":
        frame = frame[(frame["poa_global"] > 200) & (frame["over"] > 0)]
    condition = "any wind" if model == "ross" else "more than 200 W/m² and T_o > 0"
    paper.enough(model, len(frame), paper.MIN_POINTS, condition, "use a longer record")
    return one_regression(model, frame, intercept)


def standard(model, record):
    """
    Coefficients of a model without the Filter step: one regression of all rows.

    WM1 is the Sandia model under other names, WM2 a regression on two columns.
    Parameters and result as in :func:`recipe`.
    """
    frame = pd.DataFrame(dict(zip(COLUMNS, record)))
    frame["over"] = frame["temp_module"] - frame["temp_air"]
    frame = frame[frame["poa_global"] > DAYLIGHT].dropna()
    if model not in ("ross", "wm2"):
        frame = frame[frame["over"] > 0]
    paper.enough(
        f"standard {model}", len(frame), paper.MIN_POINTS, "no filter", "use more data"
    )
    return one_regression(model, frame, intercept=False)


def one_regression(model, frame, intercept):
    poa, wind, over = (
        frame[c].to_numpy() for c in ("poa_global", "wind_speed", "over")
    )
    points = len(frame)
    if model == "ross":
        k, _ = paper.regression(poa, over, intercept)
        return {"k": paper.Estimate(k, "K m²/W", points)}
    if model == "faiman":
        u1, u0 = paper.regression(wind, poa / over)
        # the paper replaces outliers by the standard values
        if not (5 < u0 < 100 and 0 <= u1 < 30):
            u0, u1 = 25.0, 6.84
        return {
            "u0": paper.Estimate(u0, "W/(m² K)", points),
            "u1": paper.Estimate(u1, "W s/(m³ K)", points),
        }
    if model == "wm2":
        columns = np.column_stack([poa, -poa * np.minimum(wind, 8.0)])
        (k, slope), *_ = np.linalg.lstsq(columns, over, rcond=None)
        return {
            "k": paper.Estimate(float(k), "K m²/W", points),
            "k_w": paper.Estimate(float(slope), "K m s/W", points),
        }
    b, a = paper.regression(wind, np.log(over / poa))
    if model == "sapm":
        return {
            "a": paper.Estimate(a, "ln(K m²/W)", points),
            "b": paper.Estimate(b, "s/m", points),
        }
    return {
        "k": paper.Estimate(float(np.exp(a)), "K m²/W", points),
        "d": paper.Estimate(-1.0 / b, "m/s", points),
    }
