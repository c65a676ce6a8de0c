"""Pictures of the error after each step of a fit or a loop."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pvlib_fem.plotting._style import (
    AFTER,
    BEFORE,
    OTHER,
    Look,
    escaped_name,
    new_axes,
    text_colour,
    without_frame,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pvlib_fem._fitting.fem_fit import FemFit
    from pvlib_fem._loop.results.loop_result import Loop

#: names of rows of a loop's table before any effect
BASES = {"fem": "fem (the paper's form)"}
#: names of rows of a fit's scores; DYNAMICS has those of the dynamics
FITTED = {"standard": "steady", "filter": "+ filter", "fem": "+ bias"}
DYNAMICS = {"ewm": "+ EWM", "balance": "+ heat balance"}
NOTHING = 0.005  # K: a change that two decimals do not show


def spaced_name(name: str) -> str:
    """
    The name of a step, with a space after its plus sign.

    Parameters
    ----------
    name : str
        Name of a row of ``loop.table``, such as ``"+soiling"``.

    Returns
    -------
    str
    """
    return name.replace("+", "+ ", 1)


def step_name(name: str) -> str:
    """
    The name of a step for a picture.

    Parameters
    ----------
    name : str
        Name of a row of ``loop.table``, such as ``"fem"`` or ``"+soiling"``.

    Returns
    -------
    str
    """
    return BASES.get(name) or spaced_name(name)


def plot_steps(loop: "Loop", ax: "Axes | None" = None) -> "Axes":
    """
    RMSE on the test days by step, or on the fitted days if there are no test days.

    Parameters
    ----------
    loop : Loop
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib Axes
    """
    ax = new_axes(ax)
    part = "test" if loop.fit.test_days else "fitted"
    errors = loop.table["rmse_test" if loop.fit.test_days else "rmse_train"]
    names = [step_name(name) for name in errors.index]
    added = [name.startswith("+") for name in errors.index]
    colours = [AFTER if a else OTHER for a in added]
    bars = ax.barh(range(len(errors)), errors, 0.7, color=colours)
    ax.bar_label(bars, fmt="%.2f", padding=3)
    one_line_each(ax, names, f"RMSE on {part} days [K]")
    return ax


def plot_waterfall(fit: "FemFit", ax: "Axes | None" = None) -> "Axes":
    """
    Change of the error from the steady model to the last step of a fit.

    The steps are the rows of ``fit.scores``: the paper's steady model, filter,
    exponential weighted mean and bias, then each effect. A decrease is blue, and an
    increase is vermilion and hatched; the last bar is the remaining error. RMSE is on
    the held-out days, or on the fitted days if none is held out.

    Parameters
    ----------
    fit : FemFit
        A fit. For the fit of a loop, the form that the loop did not use is omitted.
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib Axes
    """
    ax = new_axes(ax)
    errors = rmse_by_step(fit)
    values = errors.to_numpy()
    place = np.arange(len(values))
    change = np.diff(values)
    ends = [0, len(values)]
    bars = ax.barh(ends, values[[0, -1]], 0.7, color=OTHER)
    ax.bar_label(bars, [f"{values[i]:.2f} K" for i in (0, -1)], padding=3)
    for at, step in zip(place[1:], change):
        look: Look = dict(color=AFTER)
        if step > NOTHING:
            look = dict(color=BEFORE, hatch="//", edgecolor=text_colour())
        left, width = min(values[at - 1], values[at]), abs(step)
        bar = ax.barh(at, width, 0.7, left=left, **look)
        ax.bar_label(bar, [signed_change(step)], padding=3)
    for at, value in enumerate(values):  # from each bar down to the next
        edge: Look = dict(color=text_colour(), linewidth=0.7, linestyle=":")
        ax.plot([value, value], [at - 0.35, at + 1.35], **edge)
    part = "held-out" if fit.test_days else "fitted"
    one_line_each(ax, [*errors.index, "remaining error"], f"RMSE on {part} days [K]")
    return ax


def rmse_by_step(fit: "FemFit") -> pd.Series:
    """RMSE of the steps that lead to a fit, by name."""
    errors = fit.scores["rmse_test" if fit.test_days else "rmse_train"]
    if "standard" in errors.index:
        names = {**FITTED, "ewm": DYNAMICS.get(fit.dynamics)}
        unused = [] if fit.dynamics in DYNAMICS else ["ewm"]
    else:  # of a loop
        forms = {"ewm": "fem", "balance": "balance"}
        names = {row: DYNAMICS[form] for form, row in forms.items()}
        unused = [row for form, row in forms.items() if form != fit.dynamics]
    errors = errors.drop(unused, errors="ignore")
    return errors.rename(lambda name: names.get(name) or spaced_name(name))


def signed_change(change: float) -> str:
    """
    A change with two decimals and a typographic minus.

    Parameters
    ----------
    change : float
        Change of an error; "±0.00" if it is below 0.005. [K or K²]

    Returns
    -------
    str
    """
    if abs(change) < NOTHING:
        return "±0.00"
    return f"{change:+.2f}".replace("-", "−")


def one_line_each(ax: "Axes", names: Sequence[str], words: str) -> None:
    """
    Label horizontal bars on the left, with the first at the top.

    Parameters
    ----------
    ax : matplotlib Axes
        Axes with bars at 0, 1, 2 …
    names : sequence of str
        Name of each bar.
    words : str
        Label of the x axis, with its unit.
    """
    ax.set_yticks(range(len(names)), [escaped_name(name) for name in names])
    ax.tick_params(axis="y", length=0)
    ax.invert_yaxis()
    ax.margins(x=0.14)
    ax.set_xlim(left=0.0)
    ax.set_xlabel(words)
    without_frame(ax, "top", "right", "left")
