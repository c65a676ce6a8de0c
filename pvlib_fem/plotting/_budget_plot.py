"""Picture of the error budget: reductions by steps, and the remainder in time."""

from typing import TYPE_CHECKING

from pvlib_fem.plotting._step_plots import one_line_each, signed_change, spaced_name
from pvlib_fem.plotting._style import AFTER, BEFORE, OTHER, Look, new_axes, text_colour

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pvlib_fem._loop.results.loop_result import Loop

#: names of rows in a picture
REMAINING = {"left": "remaining error"}
#: colours of the kinds of rows; an increase is also hatched
LOOKS = {
    "start": OTHER,
    "taken": AFTER,
    "left": OTHER,
    "episodes": BEFORE,
    "scale": BEFORE,
}


def plot_budget(loop: "Loop", ax: "Axes | None" = None) -> "Axes":
    """
    Error budget of a loop: its parts add up to the mean square of the steady model.

    The upper bars show the reduction by each step. The lower bars divide the remaining
    error by time scale. A step that increased the error is hatched.

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
    shown = loop.budget["kind"].isin(LOOKS)
    # an hourly record has no error within the hour
    shown &= (loop.budget["kind"] != "scale") | (loop.budget["mean_square"] > 0.0)
    budget = loop.budget[shown]
    level = 0.0
    for place, (kind, square) in enumerate(zip(budget["kind"], budget["mean_square"])):
        whole = kind in ("start", "left")
        level = square if whole else level - square
        left = 0.0 if whole else min(level, level + square)
        rises: Look = dict(hatch="//", edgecolor=text_colour()) if square < 0.0 else {}
        bar = ax.barh(place, abs(square), 0.7, left=left, color=LOOKS[kind], **rises)
        fall = kind == "taken"
        ax.bar_label(
            bar, [signed_change(-square) if fall else f"{square:.2f}"], padding=3
        )
    names = [REMAINING.get(name) or spaced_name(name) for name in budget.index]
    weeks = "test" if loop.fit.test_days else "fitted"
    one_line_each(ax, names, f"mean square of the {weeks} days [K²]")
    return ax
