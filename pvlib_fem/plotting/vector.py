"""A picture inside a page: vector lines, the page's letters and its colours."""

import io
import re
import warnings

from pvlib_fem.plotting.look import AFTER, BEFORE

#: colours of a picture in a page, which has others in the dark
INK = "#1c1d1f"
THEME = {INK: "ink", AFTER: "after", BEFORE: "before"}
PAGE = {
    "svg.fonttype": "none",  # the page's letters, which has those of every script
    "font.size": 10,
    "legend.fontsize": "small",
    "axes.facecolor": "none",
    **dict.fromkeys(["text.color", "axes.edgecolor", "axes.labelcolor"], INK),
    **dict.fromkeys(["xtick.color", "ytick.color"], INK),
}


def svg(draw, name, size=(4.2, 2.9), projection=None):
    """
    A picture for a page: the same text for the same input, and no style of a user's.

    Parameters
    ----------
    draw : callable
        Draws on axes.
    name : str
        One for each picture of a page, of which its identifiers are made.
    size : (float, float)
        Width and height; so small that letters are still 10 px on a phone. [inch]
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
            # the font that is measured lacks letters which the page's may have
            warnings.filterwarnings("ignore", "Glyph")
            nothing = dict.fromkeys(["Date", "Creator", "Format", "Type"])
            figure.savefig(text, format="svg", metadata=nothing)
    return themed(text.getvalue(), name)


def themed(text, name):
    """The bare element: no heading and size, numbered names, the page's colours."""
    text = text[text.index("<svg") :]
    text = re.sub(r'(<svg[^>]*?) width="[^"]*"', r"\1", text, count=1)
    text = re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", text, count=1)
    used = set(re.findall(r'(?:url\(|href=")#([^")]+)', text))
    text = re.sub(r' id="([^"]*)"', lambda m: m[0] if m[1] in used else "", text)
    # names that matplotlib makes of what lies where in memory, by their order
    order = {}
    for old in re.findall(r'(?:url\(#|href="#| id=")([^")]+)', text):
        order.setdefault(old, f"{name}-{len(order)}")
    text = re.sub(r'(url\(#|href="#| id=")([^")]+)', lambda m: m[1] + order[m[2]], text)
    for colour, place in THEME.items():
        text = re.sub(
            rf"(fill|stroke): {colour}", rf"\1: var(--{place}, {colour})", text
        )
    return text.strip()
