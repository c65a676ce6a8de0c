"""Pictures of the paper's estimators: its Figs. 3, 5, 6 and 7 for your own record."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pvlib_fem.paper import _estimators as paper
from pvlib_fem.paper._timeconstant import TimeConstant, step_changes
from pvlib_fem.plotting._style import (
    AFTER,
    BEFORE,
    COLOURS,
    MARKERS,
    OTHER,
    STYLES,
    Look,
    new_axes,
    text_colour,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

CLEAR = 0.35  # opacity of points that overlap


def plot_resistances(
    poa_global: pd.Series,
    temp_air: pd.Series,
    wind_speed: pd.Series,
    temp_module: pd.Series,
    calm_wind: float = 0.5,
    high_wind: float = 6.0,
    ax: "Axes | None" = None,
) -> "Axes":
    """
    Over-temperature over irradiance in calm air and in high wind (Fig. 3).

    Points are five-minute averages. The slopes of the lines are
    :func:`pvlib_fem.paper.r_eq_max` and :func:`pvlib_fem.paper.r_m`; their difference
    is the resistance of the air films.

    Parameters
    ----------
    poa_global, temp_air, wind_speed, temp_module : Series
        [W/m²], [°C], [m/s], [°C]
    calm_wind, high_wind : float
        Upper limit of calm air, and lower limit of high wind. [m/s]
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    ValueError
        If there are too few averages in either wind.
    """
    record = (poa_global, temp_air, wind_speed, temp_module)
    frame = paper.averages(*record).dropna()
    calm = paper.r_eq_max(*record, calm_wind)
    windy = paper.r_m(*record, high_wind)
    ax = new_axes(ax)
    ends = np.array([0.0, 1.05 * frame["poa_global"].max()])
    for rows, estimate, name, condition, colour, marker, style in (
        (
            frame["wind_speed"] < calm_wind,
            calm,
            "r_eq,max",
            f"below {calm_wind:g} m/s",
            BEFORE,
            "o",
            "--",
        ),
        (
            frame["wind_speed"] >= high_wind,
            windy,
            "r_M",
            f"from {high_wind:g} m/s on",
            AFTER,
            "s",
            "-",
        ),
    ):
        dots: Look = dict(color=colour, marker=marker, linestyle="", markersize=4)
        points = frame[rows]
        ax.plot(points["poa_global"], points["over"], alpha=0.6, mfc="none", **dots)
        words = f"{condition}: {name} = {1e3 * estimate.value:.1f} mK/(W/m²)"
        line = estimate.intercept + estimate.value * ends
        ax.plot(ends, line, color=colour, linestyle=style, label=words)
    ax.axhline(0.0, color=text_colour(), linewidth=0.8)
    ax.set_xlim(*ends)
    ax.set_xlabel("irradiance [W/m²]")
    ax.set_ylabel("over-temperature [K]")
    film = 1e3 * paper.r_film(calm, windy).value
    ax.set_title(f"five-minute averages; r_film = {film:.1f} mK/(W/m²)")
    ax.legend(frameon=False)
    return ax


def plot_k_w(
    poa_global: pd.Series,
    temp_air: pd.Series,
    wind_speed: pd.Series,
    temp_module: pd.Series,
    intercept: bool = False,
    ax: "Axes | None" = None,
) -> "Axes":
    """
    Slopes of over-temperature over wind by irradiance, and k_W (Fig. 5).

    Parameters
    ----------
    poa_global, temp_air, wind_speed, temp_module : Series
        [W/m²], [°C], [m/s], [°C]
    intercept : bool, default False
        See :func:`pvlib_fem.paper.k_w`; the other line is thin.
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    ValueError
        If fewer than three bins have enough averages.
    """
    record = (poa_global, temp_air, wind_speed, temp_module)
    bins = paper.k_w_bins(*record)
    k_w = {free: paper.k_w(*record, intercept=free).value for free in (False, True)}
    ax = new_axes(ax)
    x, y = bins["poa_global"], bins["slope"]
    size = 12.0 + 60.0 * bins["points"] / bins["points"].max()
    ax.scatter(x, y, size, color=AFTER, alpha=0.7, label="a bin of 20 W/m²")
    ends = np.array([0.0, 1.05 * x.max()])
    for free, words in ((False, "through the origin"), (True, "with an intercept")):
        mean = (y.mean() + k_w[free] * x.mean()) if free else 0.0
        look: Look = (
            dict(linewidth=1.8, color=text_colour()) if free == intercept else {}
        )
        look = look or dict(linewidth=0.9, color=OTHER, linestyle="--")
        label = f"{words}: k_W = {1e3 * k_w[free]:.2f} mK m s/W"
        ax.plot(ends, mean - k_w[free] * ends, label=label, **look)
    ax.axhline(0.0, color=text_colour(), linewidth=0.8)
    ax.set_xlim(*ends)
    ax.set_xlabel("irradiance [W/m²]")
    ax.set_ylabel("slope of over-temperature\nover wind speed [K s/m]")
    ax.legend(frameon=False, loc="lower left")
    return ax


def plot_step_changes(
    poa_global: pd.Series,
    temp_air: pd.Series,
    wind_speed: pd.Series,
    temp_module: pd.Series,
    interval: str = "5min",
    apart: int = 4,
    bins: Sequence[int] = (0, 1, 2, 4, 6),
    ax: "Axes | None" = None,
) -> "Axes":
    """
    Changes of over-temperature over changes of irradiance, by wind (Fig. 6).

    Parameters
    ----------
    poa_global, temp_air, wind_speed, temp_module : Series
        [W/m²], [°C], [m/s], [°C]
    interval, apart
        See :func:`pvlib_fem.paper.time_constant`.
    bins : sequence of int, default (0, 1, 2, 4, 6)
        Lower edges of the wind bins of 1 m/s; a bin with fewer than ten step changes is
        not drawn. [m/s]
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    ValueError
        If no bin has ten step changes.
    """
    steps = step_changes(poa_global, temp_air, wind_speed, temp_module, interval, apart)
    groups = [(low, steps[steps["wind_speed"] == low]) for low in bins]
    groups = [(low, rows) for low, rows in groups if len(rows) >= 10]
    if not groups:
        raise ValueError(
            f"no wind bin of {', '.join(f'{low:g}' for low in bins)} m/s has ten step "
            "changes; give a longer record, or other bins"
        )
    ax = new_axes(ax)
    ends = np.array([-1.0, 1.0]) * steps["poa_global"].abs().quantile(0.995)
    for i, (low, rows) in enumerate(groups):
        colour = COLOURS[i % len(COLOURS)]
        marker, style = MARKERS[i % len(MARKERS)], STYLES[i % len(STYLES)]
        slope, at_zero = np.polyfit(rows["poa_global"], rows["over"], 1)
        dots: Look = dict(color=colour, marker=marker, linestyle="", markersize=3)
        ax.plot(rows["poa_global"], rows["over"], alpha=CLEAR, **dots)
        words = f"{low:g}–{low + 1:g} m/s: {1e3 * slope:.1f} mK/(W/m²)"
        line = at_zero + slope * ends
        ax.plot(ends, line, color=colour, linestyle=style, label=words)
    ax.set_xlim(*ends)
    ax.set_xlabel("change of irradiance [W/m²]")
    ax.set_ylabel("change of over-temperature [K]")
    ax.set_title(f"between averages over {interval}, {apart} apart")
    ax.legend(frameon=False, loc="upper left")
    return ax


def plot_tau_bins(tau: TimeConstant, ax: "Axes | None" = None) -> "Axes":
    """
    The paper's time constants by wind bin, and the chosen one (Fig. 7).

    Parameters
    ----------
    tau : TimeConstant
        Result of :func:`pvlib_fem.paper.time_constant`, which decreases as the true
        time constant increases.
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib Axes

    See Also
    --------
    pvlib_fem.plotting.plot_tau_by_wind : time constants by least squares.
    """
    ax = new_axes(ax)
    table = tau.table.dropna(subset=["tau"])
    middle = table.index.to_numpy() + 0.5
    used = table["used"].to_numpy(bool)
    dots: Look = dict(linestyle="", markersize=7)
    ax.plot(middle[used], table["tau"][used], "o", color=AFTER, label="used", **dots)
    rest: Look = dict(
        mfc="none", color=BEFORE, label="not used: tau no longer falls", **dots
    )
    if (~used).any():
        ax.plot(middle[~used], table["tau"][~used], "s", **rest)
    if np.isfinite(tau.f):
        winds = np.linspace(middle[used][0], middle[used][-1], 100)
        fall = tau.tau_0 * np.exp(-(winds - winds[0]) / tau.f)
        ax.plot(winds, fall, color=AFTER, label=f"f = {tau.f:.1f} m/s")
    words = f"chosen: {tau.value:.0f} s"
    ax.axhline(
        tau.value, color=text_colour(), linewidth=0.9, linestyle=":", label=words
    )
    ax.set_xlim(left=0.0)
    ax.set_ylim(bottom=0.0)
    ax.set_xlabel("wind speed [m/s]")
    ax.set_ylabel("time constant by Eq. 21 [s]")
    ax.legend(frameon=False, loc="lower left")
    return ax
