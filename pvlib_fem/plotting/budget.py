"""Where the error went: what each step took, and what is left in time."""

from typing import Any

from pvlib_fem.plotting.look import AFTER, BEFORE, OTHER, ink, new_axes
from pvlib_fem.plotting.steps import one_line_each, signed, spaced

#: colours of the kinds of rows; what rises is told by its hatching, too
LOOKS = {
    "start": OTHER,
    "taken": AFTER,
    "left": OTHER,
    "episodes": BEFORE,
    "scale": BEFORE,
}


def plot_budget(loop: Any, ax: Any = None) -> Any:
    """
    The budget of a loop's mean square, which adds up.

    From the steady model down by what each step took, and from what is left down by
    time scale to what changes from row to row. Hatched is what a step made worse.

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
    told = loop.budget["kind"].isin(LOOKS)
    # no record of hours has what is within the hour
    told &= (loop.budget["kind"] != "scale") | (loop.budget["mean_square"] > 0.0)
    budget = loop.budget[told]
    level = 0.0
    for place, (kind, square) in enumerate(zip(budget["kind"], budget["mean_square"])):
        whole = kind in ("start", "left")
        level = square if whole else level - square
        left = 0.0 if whole else min(level, level + square)
        rises = dict(hatch="//", edgecolor=ink()) if square < 0.0 else {}
        bar = ax.barh(place, abs(square), 0.7, left=left, color=LOOKS[kind], **rises)
        fall = kind == "taken"
        ax.bar_label(bar, [signed(-square) if fall else f"{square:.2f}"], padding=3)
    names = [spaced(name) for name in budget.index]
    weeks = "test" if loop.fit.test_days else "fitted"
    one_line_each(ax, names, f"mean square of the {weeks} days [K²]")
    return ax
