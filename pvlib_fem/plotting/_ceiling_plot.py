"""Picture of the error that could still be explained."""

from typing import TYPE_CHECKING

from pvlib_fem.plotting._style import (
    AFTER,
    BEFORE,
    OTHER,
    Look,
    new_axes,
    text_colour,
    without_frame,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pvlib_fem._ceiling.ceiling_result import Ceiling


def plot_ceiling(ceiling: "Ceiling", ax: "Axes | None" = None) -> "Axes":
    """
    One bar: the mean square of the paper's form, divided by what explains it.

    The parts are explained by the loop, by trees on the same columns alone (hatched),
    and by neither.

    Parameters
    ----------
    ceiling : Ceiling
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib Axes
    """
    ax = new_axes(ax, height=2.4)
    paper, loop, trees = (e**2 for e in (ceiling.paper, ceiling.loop, ceiling.trees))
    loop = min(loop, paper)  # what makes the error larger explains nothing
    rest = min(loop, trees)
    parts: tuple[tuple[str, float, Look], ...] = (
        ("explained by the loop", paper - loop, dict(color=AFTER)),
        ("explained by trees alone", loop - rest, dict(color=BEFORE, hatch="//")),
        ("explained by neither", rest, dict(color=OTHER)),
    )
    at = 0.0
    for name, size, look in parts:
        look |= {"edgecolor": text_colour()} if "hatch" in look else {}
        words = f"{name}: {size:.2f} K²"
        ax.barh(0.0, size, 0.6, left=at, label=words, **look)
        at += size
    ax.set_yticks([])
    ax.set_xlim(0.0, at)
    ax.set_ylim(-0.4, 0.4)
    ax.set_xlabel("mean square of the test weeks [K²]")
    without_frame(ax, "top", "right", "left")
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False)
    return ax
