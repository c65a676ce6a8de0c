"""Picture of the recovery of injected effects."""

import math
from typing import TYPE_CHECKING

from pvlib_fem.plotting._style import (
    COLOURS,
    MARKERS,
    OTHER,
    STYLES,
    Look,
    new_axes,
    outside_legend,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pvlib_fem._recovery.recovery_result import Recovery

LEGEND_COLUMNS = 4


def plot_recovery(recovery: "Recovery", ax: "Axes | None" = None) -> "Axes":
    """
    Share of injections found over multiples of the predicted size, by effect.

    Parameters
    ----------
    recovery : Recovery
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib Axes
    """
    summary = recovery.summary.reset_index().dropna(subset="multiple")
    lines_below = math.ceil(summary["effect"].nunique() / LEGEND_COLUMNS)
    ax = new_axes(ax, height=4.0 + 0.2 * lines_below)
    for i, (name, part) in enumerate(summary.groupby("effect", sort=False)):
        part = part.sort_values("multiple")
        look: Look = dict(
            color=COLOURS[i % len(COLOURS)], marker=MARKERS[i % len(MARKERS)]
        )
        look["linestyle"] = STYLES[i // len(COLOURS) % len(STYLES)]
        ax.plot(part["multiple"], part["found"], label=name, **look)
    ax.axvline(1.0, color=OTHER, linewidth=0.8, zorder=0)
    ax.axhline(0.5, color=OTHER, linewidth=0.8, zorder=0)
    ax.set_xscale("log")
    ticks = sorted(summary["multiple"].unique())
    ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    ax.minorticks_off()
    ax.set(xlabel="size / predicted size [-]", ylabel="share found [-]")
    ax.set_ylim(-0.03, 1.03)
    if len(summary):
        # all effects of the catalogue would cover the lines
        place = dict(loc="upper center", bbox_to_anchor=(0.5, -0.15))
        outside_legend(ax, LEGEND_COLUMNS, fontsize="small", **place)
    return ax
