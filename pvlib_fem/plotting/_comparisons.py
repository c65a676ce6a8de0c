"""Comparisons of several models: the paper's Figs. 8, 9 and 10."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pvlib_fem.plotting._step_plots import one_line_each
from pvlib_fem.plotting._style import (
    AFTER,
    BEFORE,
    COLOURS,
    MARKERS,
    STYLES,
    Look,
    escaped_name,
    new_axes,
    text_colour,
    without_frame,
)
from pvlib_fem.scores import EnergyError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pvlib_fem.paper._comparison import Comparison

STEPS = {"standard": "steady", "filter": "+ filter", "ewm": "+ EWM", "fem": "+ bias"}
LAST = "fem"  # step of the models of others
STEADY = "standard"
SPREAD = 0.12  # distance between the models of others


def plot_comparison(
    comparison: "Comparison", ax: "Axes | None" = None, score: str = "rmse"
) -> "Axes":
    """
    One score by step, with a line per model; models of others at the end (Fig. 9).

    Parameters
    ----------
    comparison : Comparison
        Result of :func:`pvlib_fem.compare_models`; its finest resolution is drawn.
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.
    score : str, default "rmse"

    Returns
    -------
    matplotlib Axes
    """
    ax = new_axes(ax)
    table = comparison.by_step(score)
    place = np.arange(len(table))
    single = table.drop(index=LAST).isna().all() & table.loc[LAST].notna()
    others = place[-1] + 0.5 + SPREAD * np.arange(np.count_nonzero(single))
    beyond = iter(others)
    for i, (name, values) in enumerate(table.items()):
        look = model_style(i)
        if single[str(name)]:
            look |= dict(linestyle="", mfc="none", mew=1.6)
            ax.plot([next(beyond)], values[[LAST]], label=escaped_name(name), **look)
        else:
            ax.plot(place, values, label=escaped_name(name), **look)
    names = [STEPS[name] for name in table.index]
    if len(others):
        place, names = [*place, others.mean()], [*names, "models\nof others"]
    ax.set_xticks(place, names)
    ax.set_ylim(bottom=min(0.0, ax.get_ylim()[0]))
    ax.set_ylabel(words_of(score))
    legend_outside(ax)
    return ax


def plot_resolutions(
    comparison: "Comparison", ax: "Axes | None" = None, score: str = "rmse"
) -> "Axes":
    """
    One score over the resolution of the data, steady and dynamic (Fig. 8).

    Full lines are the last step of each model, thin dashed ones its steady form.

    Parameters
    ----------
    comparison : Comparison
        Result of :func:`pvlib_fem.compare_models` with ``resolutions``.
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.
    score : str, default "rmse"

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    ValueError
        If there is one resolution only.
    """
    last = comparison.by_resolution(score)
    if len(last) < 2:
        raise ValueError(
            "one resolution makes no line; give several, as resolutions=(60, 300, 900)"
        )
    steady = comparison.by_resolution(score, STEADY)
    ax = new_axes(ax)
    for i, name in enumerate(last):
        look = model_style(i)
        ax.plot(last.index, last[name], label=escaped_name(name), **look)
        if name in steady:
            thin: Look = dict(color=look["color"], linestyle="--", linewidth=0.9)
            ax.plot(steady.index, steady[name], marker=look["marker"], ms=3, **thin)
    ax.plot([], [], color=text_colour(), linestyle="--", linewidth=0.9, label="steady")
    ax.set_xscale("log")
    ax.set_xticks(last.index, [step_in_words(seconds) for seconds in last.index])
    ax.minorticks_off()
    ax.set_ylim(bottom=min(0.0, ax.get_ylim()[0]))
    ax.set_xlabel("step of the data")
    ax.set_ylabel(words_of(score))
    legend_outside(ax)
    return ax


def plot_energy_error(
    errors: Mapping[str, EnergyError], ax: "Axes | None" = None
) -> "Axes":
    """
    Error of the performance ratio by temperature errors, in both signs (Fig. 10).

    Parameters
    ----------
    errors : dict of EnergyError
        Results of :func:`pvlib_fem.scores.energy_error` by name.
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib Axes
    """
    ax = new_axes(ax)
    place = np.arange(len(errors))
    over, under, net = (
        np.array([100.0 * getattr(e, side) / e.insolation for e in errors.values()])
        for side in ("over_estimate", "under_estimate", "net")
    )
    ax.barh(place, over, 0.65, color=AFTER, label="over-estimated, model too cold")
    hatched: Look = dict(
        color=BEFORE, hatch="//", edgecolor=text_colour(), linewidth=0.0
    )
    ax.barh(place, under, 0.65, label="under-estimated, model too hot", **hatched)
    ax.plot(
        net, place, "D", color=text_colour(), mfc="white", ms=6, label="both together"
    )
    ax.axvline(0.0, color=text_colour(), linewidth=0.8)
    for at, high, low in zip(place, over, under):
        ax.annotate(f" {high:.2f}", (high, at), va="center")
        ax.annotate(f"{-low:.2f} ", (low, at), va="center", ha="right")
    words = "error of the performance ratio [percentage points]"
    one_line_each(ax, list(errors), words)
    reach = 1.25 * max(over.max(), -under.min(), 1e-6)
    ax.set_xlim(-reach, reach)
    ax.legend(frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=3)
    return ax


def model_style(i: int) -> Look:
    """Colour, marker and line of one model among several."""
    again = i // len(COLOURS)
    return dict(
        color=COLOURS[i % len(COLOURS)],
        marker=MARKERS[(i + again) % len(MARKERS)],
        linestyle=STYLES[(i + again) % len(STYLES)],
        markersize=5,
    )


def words_of(score: str) -> str:
    """Label of an axis for a score."""
    name, _, part = score.partition("_")
    return f"{name.upper()} by {part or 'day'}, held-out days [K]"


def step_in_words(seconds: float) -> str:
    """A time step in words."""
    if seconds < 60:
        return f"{seconds:g} s"
    return f"{seconds / 60:g} min" if seconds < 3600 else f"{seconds / 3600:g} h"


def legend_outside(ax: "Axes") -> None:
    """Add a legend to the right of the axes."""
    without_frame(ax, "top", "right")
    ax.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
