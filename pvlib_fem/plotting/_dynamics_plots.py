"""Pictures of the dynamics: response to a step, and time constant by wind."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np
import pandas as pd
from scipy.stats import t as student

from pvlib_fem._record.file_summary import present
from pvlib_fem._record.filters import counted
from pvlib_fem._relaxation import relax
from pvlib_fem._statistics.clusters import FEWEST_DAYS, cluster_sums
from pvlib_fem.plotting._style import (
    AFTER,
    COLOURS,
    MARKERS,
    STYLES,
    Look,
    new_axes,
    text_colour,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pvlib_fem._fitting.fem_fit import FemFit

STEP = 1000.0  # W/m²
SPAN = 5.0  # time constants that are drawn
ROWS = 1001
BIN = 1.0  # m/s, the paper's bins of wind
LEVEL = 0.95
Wind = TypeVar("Wind", float, np.ndarray)


def plot_step_response(
    fit: "FemFit",
    wind_speed: Sequence[float] = (0.5, 2.0, 5.0),
    ax: "Axes | None" = None,
) -> "Axes":
    """
    Over-temperature after a step of irradiance, at several winds.

    Irradiance steps from 0 to 1000 W/m². A marker shows 63 % of the new
    over-temperature, after one time constant. The response has no bias and no effects,
    whose drivers are not defined for a step.

    Parameters
    ----------
    fit : FemFit
        A fit with the dynamics ``"ewm"`` or ``"balance"``.
    wind_speed : float or sequence of float, default (0.5, 2.0, 5.0)
        [m/s]
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    ValueError
        If the fit is steady, or a wind is no speed.
    """
    winds = np.atleast_1d(np.asarray(wind_speed, dtype=float))
    if (wrong := winds[~(np.isfinite(winds) & (winds >= 0))]).size:
        raise ValueError(f"wind_speed = {wrong[0]:g} m/s is no speed; give 0 and above")
    taus = time_constant(fit, winds)
    model = replace(fit.thermal_model, effects=())
    coefficients = {name: fit.coefficients[name] for name in model.parameters}
    seconds = np.linspace(0.0, SPAN * taus.max(), ROWS)
    index = pd.Timestamp(0) + pd.to_timedelta(seconds, unit="s")
    sun = pd.Series(np.where(seconds > 0, STEP, 0.0), index)
    ax = new_axes(ax)
    for i, (wind, tau) in enumerate(zip(winds, taus)):
        air, moving = 0.0 * sun, 0.0 * sun + wind
        warm = model.predict(sun, air, moving, {**coefficients, "bias": 0.0})
        words = f"{wind:g} m/s: τ = {tau:.0f} s"
        look: Look = dict(
            color=COLOURS[i % len(COLOURS)], linestyle=STYLES[i % len(STYLES)]
        )
        ax.plot(seconds / 60.0, warm, label=words, **look)
        reached = np.interp(tau, seconds, warm)
        marker: Look = dict(marker=MARKERS[i % len(MARKERS)], zorder=3)
        ax.plot([tau / 60.0], [reached], color=look["color"], **marker)
        ax.vlines(tau / 60.0, 0.0, reached, color=look["color"], linewidth=0.7)
    ax.plot([], [], "o", color=text_colour(), label="63 % reached", markersize=5)
    ax.set_xlim(0.0, seconds[-1] / 60.0)
    ax.set_ylim(bottom=0.0)
    ax.set_xlabel("time after the step [min]")
    ax.set_ylabel("over-temperature [K]")
    ax.set_title(f"irradiance from 0 to {STEP:g} W/m²; {fit.model}, {fit.dynamics}")
    ax.legend(frameon=False, loc="lower right")
    return ax


def plot_tau_by_wind(fit: "FemFit", ax: "Axes | None" = None) -> "Axes":
    """
    The time constant over wind: of the model, and of the record in bins.

    Points and bars (95 %) are from :func:`tau_by_wind`. The curve is that of the model
    without effects on loss or capacity.

    Parameters
    ----------
    fit : FemFit
        A fit with the dynamics ``"ewm"`` or ``"balance"``.
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    ValueError
        If the fit is steady, or no bin of wind determines a time constant.
    """
    bins = tau_by_wind(fit)
    if bins.empty:
        raise ValueError(
            f"no bin of wind has {FEWEST_DAYS} days and a time constant that is "
            "known to within itself; give a longer record, or finer steps"
        )
    ax = new_axes(ax)
    winds = np.linspace(0.0, bins["wind_speed"].max() + BIN, 200)
    words = f"the model: {fit.model}, {fit.dynamics}"
    ax.plot(winds, time_constant(fit, winds), color=AFTER, label=words)
    bars = (bins["tau"] - bins["lower"], bins["upper"] - bins["tau"])
    look: Look = dict(fmt="o", color=text_colour(), capsize=3, markersize=5)
    words = "the record, by smoothed wind; 95 %, clustered by day"
    ax.errorbar(bins["wind_speed"], bins["tau"], bars, label=words, **look)
    ax.set_xlim(0.0, winds[-1])
    ax.set_ylim(0.0, 1.2 * ax.get_ylim()[1])  # room for the legend
    ax.set_xlabel("wind speed [m/s]")
    ax.set_ylabel("time constant [s]")
    ax.legend(frameon=False)
    return ax


def tau_by_wind(fit: "FemFit") -> pd.DataFrame:
    r"""
    Estimate the time constant of a record in bins of 1 m/s.

    In each bin, ``tau`` or ``capacity`` takes one Gauss–Newton step [1]_ from the fit,
    with the rows of that bin and the model's exact slopes. An offset and a factor of
    the over-temperature are estimated, too, so that a steady error at that wind does
    not change the time constant. For ``balance``, ``tau`` is the capacity of the step
    times :math:`r_{eq}` at the wind of the bin.

    Rows are binned by smoothed wind, the exponential mean over the model's own time
    constant. Held-out days count, too.

    Parameters
    ----------
    fit : FemFit
        A fit with the dynamics ``"ewm"`` or ``"balance"``.

    Returns
    -------
    DataFrame
        A row for each bin: ``wind_speed``, the mean smoothed wind [m/s]; ``tau``,
        ``stderr``, and ``lower`` and ``upper`` of its 95 % interval by Student's t
        over the days [s]; ``days``. The table omits bins below 5 days, and bins whose
        half interval exceeds the model's time constant.

    Raises
    ------
    ValueError
        If the fit is steady.

    Notes
    -----
    One step is linear, so a bin far from the model can be biased. An example is the
    single ``tau`` of ``ewm``, fitted to 30 days of
    :func:`pvlib_fem.datasets.synthetic`, whose time constant falls from 499 to 219 s
    with the wind: the bin of strongest wind gave 190 ± 19 s.

    References
    ----------
    .. [1] A. Björck, "Numerical Methods for Least Squares Problems", SIAM 1996,
       section 9.2. :doi:`10.1137/1.9781611971484`
    """
    model, record = fit.thermal_model, present(fit.record)
    name = time_constant_name(fit)
    coefficients = {**model.steady_model.fixed, **fit.coefficients}
    inputs = model.with_drivers(record.inputs)
    temperature, slopes = model.slopes(inputs, coefficients)
    residual = record["temp_module"] - temperature
    over = temperature - coefficients["bias"] - record["temp_air"]
    columns = (slopes[name], over, np.ones(len(over)))
    wind = record["wind_speed"]
    memory = time_constant(fit, wind) / record.inputs.unit
    smooth = relax(wind, record.inputs.steps, memory)
    seen = counted(record.inputs.columns, fit.night)
    seen = seen & np.isfinite(residual + slopes[name] + over + smooth)
    rows = []
    for bin_ in np.unique(smooth[seen] // BIN):
        at = np.flatnonzero(seen & (smooth // BIN == bin_))
        middle = smooth[at].mean()
        now = float(time_constant(fit, middle))
        step = newton_step([c[at] for c in columns], residual[at], record.dates[at])
        if step is None:
            continue
        change, error, days = step
        # from capacity to time constant; for ewm the factor is 1
        unit = now / coefficients[name]
        tau, error = now + change * unit, error * unit
        reach = student.ppf(0.5 + LEVEL / 2, days - 1) * error
        if reach < now:
            rows.append((middle, tau, error, tau - reach, tau + reach, days))
    names = ["wind_speed", "tau", "stderr", "lower", "upper", "days"]
    return pd.DataFrame(rows, columns=names)


def newton_step(
    columns: list[np.ndarray], residual: np.ndarray, dates: np.ndarray
) -> tuple[float, float, int] | None:
    """Step of the first column's coefficient, its error and the days; or None."""
    days = len(np.unique(dates))
    if days < FEWEST_DAYS:
        return None
    matrix = np.column_stack(columns)
    step, _, rank, _ = np.linalg.lstsq(matrix, residual, rcond=None)
    if rank < len(columns):
        return None
    try:
        remaining = residual - matrix @ step
        covariance = cluster_sums(columns, remaining, dates).by_day()
    except np.linalg.LinAlgError:  # one day alone determines a coefficient
        return None
    return step[0], np.sqrt(covariance[0, 0]), days


def time_constant_name(fit: "FemFit") -> str:
    """Name of the coefficient that sets the time constant of a fit."""
    names = {"ewm": "tau", "balance": "capacity"}
    if fit.dynamics not in names:
        raise ValueError(
            f"a {fit.dynamics} fit has no time constant; fit with dynamics='ewm' or "
            "dynamics='balance'"
        )
    return names[fit.dynamics]


def time_constant(fit: "FemFit", wind_speed: Wind) -> Wind:
    """Time constant of a fitted model at these winds, without its effects. [s]"""
    time_constant_name(fit)
    tau = fit.thermal_model.time_constant(fit.coefficients, wind_speed)
    return tau + 0.0 * wind_speed
