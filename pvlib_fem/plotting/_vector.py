"""Pictures as SVG inside an HTML page, with the page's font and colours."""

import io
import re
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING

from pvlib_fem.plotting._style import AFTER, BEFORE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: colours of a picture that the page replaces in dark mode
INK = "#1c1d1f"
SHARP = 200  # dots per inch of what is an image
THEME = {INK: "ink", AFTER: "after", BEFORE: "before"}
PAGE = {
    "svg.fonttype": "none",  # text in the page's font, which has all scripts
    "font.size": 10,
    "legend.fontsize": "small",
    "axes.facecolor": "none",
    **dict.fromkeys(["text.color", "axes.edgecolor", "axes.labelcolor"], INK),
    **dict.fromkeys(["xtick.color", "ytick.color"], INK),
}


def svg(
    draw: "Callable[[Axes], object]",
    name: str,
    size: tuple[float, float] = (4.2, 2.9),
    projection: str | None = None,
) -> str:
    """
    Draw a picture as SVG; the text depends on the input alone, not on a user's style.

    Parameters
    ----------
    draw : callable
        Function that draws on axes.
    name : str
        Prefix of the identifiers, unique within a page.
    size : (float, float)
        Width and height; so small that letters have 10 px on a phone. [inch]
    projection : str, optional
        ``"polar"`` for a wind rose.

    Returns
    -------
    str
        An ``svg`` element, with ``var(--ink)`` and others for the colours of `THEME`.
    """
    from matplotlib import style
    from matplotlib.figure import Figure

    text = io.StringIO()
    with style.context(["default", PAGE]):
        figure = Figure(figsize=size, layout="constrained")
        ax = figure.subplots(subplot_kw={"projection": projection})
        draw(ax)
        ax.set_title("")  # the page has it
        figure.patch.set_visible(False)
        with warnings.catch_warnings():
            # matplotlib's font has no glyphs for some letters of the page's font
            warnings.filterwarnings("ignore", "Glyph")
            nothing = dict.fromkeys(["Date", "Creator", "Format", "Type"])
            figure.savefig(text, format="svg", metadata=nothing, dpi=SHARP)
    return themed_svg(text.getvalue(), name)


def themed_svg(text: str, name: str) -> str:
    """The ``svg`` element without header and size, with the page's colours."""
    text = text[text.index("<svg") :]
    text = re.sub(r'(<svg[^>]*?) width="[^"]*"', r"\1", text, count=1)
    text = re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", text, count=1)
    used = set(re.findall(r'(?:url\(|href=")#([^")]+)', text))
    text = re.sub(r' id="([^"]*)"', lambda m: m[0] if m[1] in used else "", text)
    # matplotlib's identifiers depend on memory addresses; number them in order
    order = {}
    for old in re.findall(r'(?:url\(#|href="#| id=")([^")]+)', text):
        order.setdefault(old, f"{name}-{len(order)}")
    text = re.sub(r'(url\(#|href="#| id=")([^")]+)', lambda m: m[1] + order[m[2]], text)
    for colour, place in THEME.items():
        text = re.sub(
            rf"(fill|stroke): {colour}", rf"\1: var(--{place}, {colour})", text
        )
    return text.strip()
