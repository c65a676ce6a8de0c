"""Common parts of all pictures: colours, axes, and names with units."""

from collections.abc import Hashable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pvlib_fem._record.column_names import UNITS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.projections.polar import PolarAxes

# colours of Okabe and Ito, which colour-blind readers can distinguish
BEFORE, AFTER, OTHER = "#d55e00", "#0072b2", "#8c8c8c"
COLOURS = (AFTER, BEFORE, "#009e73", "#cc79a7", "#e69f00", "#56b4e9", OTHER)
STYLES = ("-", "--", ":", "-.")
MARKERS = "os^Dv"
FAINT = 0.14  # opacity of the background: light on white, dark on black
#: keywords of a line, a bar or a text of matplotlib
Look = dict[str, Any]
MOST_TICKS = 6  # dates on an axis; more would overlap
LONGEST = 24  # characters of a name in a picture


def new_axes(
    ax: "Axes | None", projection: str | None = None, height: float = 4.0
) -> "Axes":
    """
    The given axes, or axes of a new figure.

    Parameters
    ----------
    ax : matplotlib Axes or None
        Axes to draw on; None for a new figure.
    projection : str, optional
        Projection of new axes, such as ``"polar"``; by default they are rectangular.
    height : float, default 4.0
        Height of a new figure of 8 inches' width; ignored with a projection. [inch]

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    ImportError
        If a new figure is needed and matplotlib is not installed.
    """
    if ax is not None:
        return ax
    try:
        import matplotlib.pyplot as plt
    except ImportError as error:
        raise ImportError(
            "pictures need matplotlib: pip install 'pvlib_fem[plot]'"
        ) from error

    size = (8, height) if projection is None else (6, 5)
    kind = {"projection": projection}
    return plt.subplots(figsize=size, layout="constrained", subplot_kw=kind)[1]


def polar_axes(ax: "Axes | None") -> "PolarAxes":
    """
    The given polar axes, or those of a new figure.

    Parameters
    ----------
    ax : matplotlib PolarAxes or None
        Axes to draw on; None for a new figure.

    Returns
    -------
    matplotlib PolarAxes

    Raises
    ------
    ValueError
        If the axes are not polar.
    """
    ax = new_axes(ax, "polar")
    from matplotlib.projections.polar import PolarAxes

    if not isinstance(ax, PolarAxes):
        raise ValueError(
            f"this picture needs polar axes, and ax is {ax.name}; make them with "
            'plt.subplots(subplot_kw={"projection": "polar"})'
        )
    return ax


def panels(ax: "Axes", heights: Sequence[float], gap: float = 0.06) -> "list[Axes]":
    """
    Divide the given axes into panels, one below the other, with one x axis.

    Parameters
    ----------
    ax : matplotlib Axes
        Becomes the upper panel.
    heights : sequence of float
        Height of each panel, relative to the others.
    gap : float, default 0.06

    Returns
    -------
    list of matplotlib Axes
        From top to bottom.
    """
    count, share = len(heights), np.array(heights) / sum(heights)
    if place := ax.get_subplotspec():
        rows = place.subgridspec(count, 1, height_ratios=heights, hspace=gap)
        ax.set_subplotspec(rows[0])
        below = [ax.figure.add_subplot(rows[i], sharex=ax) for i in range(1, count)]
        return [ax, *below]
    x, y, width, height = ax.get_position().bounds
    bottom = y + height * (1.0 - np.cumsum(share))
    ax.set_position((x, bottom[0], width, share[0] * height))
    return [
        ax,
        *(
            ax.figure.add_axes((x, low, width, 0.9 * part * height), sharex=ax)
            for low, part in zip(bottom[1:], share[1:])
        ),
    ]


def check_format(path: Path) -> None:
    """
    Refuse a picture file whose suffix matplotlib does not support.

    Parameters
    ----------
    path : Path
        File to write; the case of its suffix is ignored.

    Raises
    ------
    ValueError
        With the suffixes that matplotlib supports.
    """
    from matplotlib.backend_bases import FigureCanvasBase

    known = FigureCanvasBase.get_supported_filetypes()
    if path.suffix[1:].lower() not in known:
        raise ValueError(
            f"{path.name} ends with no format of a picture; name it such as "
            f"{path.stem}.png, or with another of {', '.join(sorted(known))}"
        )


def text_colour() -> str:
    """
    The text colour of the present style.

    Returns
    -------
    str
        Colour of matplotlib.
    """
    from matplotlib import rcParams

    return rcParams["text.color"]


def without_frame(ax: "Axes", *sides: str) -> None:
    """
    Hide some sides of the frame.

    Parameters
    ----------
    ax : matplotlib Axes
        Axes to change.
    *sides : str
        ``"top"``, ``"right"``, ``"bottom"`` or ``"left"``.
    """
    for side in sides:
        ax.spines[side].set_visible(False)


def outside_legend(ax: "Axes", most: int, **place: Any) -> None:
    """
    A legend above or below axes, no wider than their figure.

    A wider one would be cut off, and a constrained layout would make the axes narrow.

    Parameters
    ----------
    ax : matplotlib Axes
        Axes with labelled artists.
    most : int
        Largest number of columns.
    **place
        ``loc`` and ``bbox_to_anchor`` of `matplotlib.axes.Axes.legend`.
    """
    for columns in range(most, 0, -1):
        legend = ax.legend(**place, ncols=columns, frameon=False)
        if legend.get_window_extent().width <= ax.figure.bbox.width:
            return


def dated_axis(ax: "Axes") -> None:
    """
    Few ticks of dates, each with what the one before it does not say.

    Parameters
    ----------
    ax : matplotlib Axes
        Axes whose x axis has dates.
    """
    from matplotlib.dates import (
        DAILY,
        HOURLY,
        MINUTELY,
        MONTHLY,
        YEARLY,
        AutoDateLocator,
        ConciseDateFormatter,
    )

    # up to three days, and up to three years, have ticks of half of them
    halves = dict.fromkeys([MONTHLY, HOURLY, MINUTELY], MOST_TICKS + 1)
    most = dict.fromkeys([YEARLY, DAILY], MOST_TICKS) | halves
    places = AutoDateLocator(minticks=3, maxticks=most)
    ax.xaxis.set_major_locator(places)
    ax.xaxis.set_major_formatter(ConciseDateFormatter(places))


def escaped_name(name: object) -> str:
    """
    A name, shortened and escaped for matplotlib.

    Parameters
    ----------
    name : object
        Name of a column, an effect or a model.

    Returns
    -------
    str
        One line of at most 24 characters before ``$`` is escaped.
    """
    text = " ".join(str(name).split())
    text = text if len(text) <= LONGEST else f"{text[: LONGEST - 1]}…"
    return text.replace("$", r"\$")


def label_with_unit(name: Hashable) -> str:
    """
    A shortened name with its unit, if it is one of pvlib's names.

    Parameters
    ----------
    name : hashable
        Name of a column.

    Returns
    -------
    str
        Such as "wind_speed [m/s]".
    """
    unit = f" [{UNITS[name]}]" if name in UNITS else ""
    return f"{escaped_name(name)}{unit}"
