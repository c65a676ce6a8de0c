"""Pictures of fits. matplotlib is imported here only, and only when one is drawn."""

import io
import re
import warnings

import numpy as np
import pandas as pd

# colours of Okabe and Ito, which the colour-blind can tell apart
BEFORE, AFTER, OTHER = "#d55e00", "#0072b2", "#8c8c8c"
SHADE = "#e0e0e0"
COLOURS = (AFTER, BEFORE, "#009e73", "#cc79a7", "#e69f00", "#56b4e9", OTHER)
STYLES = ("-", "--", ":")  # once more round the colours
LONGEST = 24  # characters of a name in a picture
BASES = {"fem": "fem (the paper's form)"}


def plot_fit(fit, ax=None):
    """
    Measured and modelled temperature on the most variable held-out day.

    Parameters
    ----------
    fit : FemFit
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib Axes
    """
    ax = new_axes(ax)
    day = Day(fit)
    day.reading(ax)
    day.modelled(ax, fit.residual, f"{fit.model}, {fit.dynamics}", BEFORE)
    ax.legend(loc="upper left", frameon=False)
    return day.dressed(ax)


def plot_before_after(loop, ax=None):
    """
    The most variable sealed day: measured, and modelled before and after.

    Where the loop re-timed the module's record, that before it is left out.

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
    day = Day(loop.fit)
    day.reading(ax)
    changed = any(name.startswith("+") for name in loop.table.index)
    if changed and "+clock_shift" not in loop.table.index:
        day.modelled(ax, loop.residual_before, "before", BEFORE)
    words = "after" if changed else "modelled, no effect added"
    day.modelled(ax, loop.fit.residual, words, AFTER)
    ax.legend(loc="upper left", frameon=False)
    return day.dressed(ax)


def plot_steps(loop, ax=None):
    """
    RMSE on the sealed days by step; on the fitted days where none is sealed.

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
    part = "sealed" if loop.fit.test_days else "fitted"
    errors = loop.table["rmse_test" if loop.fit.test_days else "rmse_train"]
    names = [
        label(BASES.get(name, name.replace("+", "+ ", 1))) for name in errors.index
    ]
    added = [name.startswith("+") for name in errors.index]
    place = np.arange(len(errors))
    bars = ax.barh(place, errors, 0.7, color=[AFTER if a else OTHER for a in added])
    ax.bar_label(bars, fmt="%.2f", padding=3)
    ax.set_yticks(place, names)
    ax.tick_params(axis="y", length=0)
    ax.invert_yaxis()
    ax.margins(x=0.12)
    ax.set_xlabel(f"RMSE on {part} days [K]")
    for side in ("top", "right", "left"):
        ax.spines[side].set_visible(False)
    return ax


def plot_residual_map(residual, ax=None, limit=None):
    """
    Mean residual by hour of day and month.

    Parameters
    ----------
    residual : Series
        Measured minus modelled temperature. [K]
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.
    limit : float, optional
        End of the colour scale either way, by default the largest mean. [K]

    Returns
    -------
    matplotlib Axes
    """
    ax = new_axes(ax)
    means = by_hour_and_month(residual)
    limit = largest(means) if limit is None else limit
    hours, months = np.arange(25), np.arange(means.shape[1] + 1)
    colours = dict(cmap="RdBu_r", vmin=-limit, vmax=limit)
    # edges of its own colour leave no seams in a vector picture
    colours |= dict(edgecolors="face", linewidth=0.3)
    mesh = ax.pcolormesh(months, hours, means.to_numpy(), **colours)
    names = [pd.Timestamp(2000, month, 1).month_name() for month in means.columns]
    width = 1 if len(names) > 8 else 3
    ax.set_xticks(months[:-1] + 0.5, [name[:width] for name in names])
    ax.set_yticks(range(0, 25, 6))
    ax.set_ylabel("hour of the day")
    ax.tick_params(axis="x", length=0)
    bar = ax.figure.colorbar(mesh, ax=ax)
    bar.set_label("measured − modelled [K]")
    return ax


def plot_contributions(loop, ax=None):
    """
    What each effect adds to the temperature on the most variable sealed day.

    The legend has the root mean square over the whole record.

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
    record = loop.fit.record
    parts = loop.contributions(pd.DataFrame(record.inputs.columns, record.index))
    day = Day(loop.fit)
    ax.axhline(0.0, color=SHADE, linewidth=1)
    for i, (name, values) in enumerate(parts.items()):
        look = dict(color=COLOURS[i % len(COLOURS)], linewidth=1.2)
        look["linestyle"] = STYLES[i // len(COLOURS) % len(STYLES)]
        size = np.sqrt(np.nanmean(values**2))
        words = f"{label(name)}, rms {size:.2f} K"
        ax.plot(day.hours, values.to_numpy()[day.rows], label=words, **look)
    if len(parts.columns):
        below = dict(loc="upper center", bbox_to_anchor=(0.5, -0.22))
        ax.legend(**below, ncols=1 + (len(parts.columns) > 3), frameon=False)
    ax.set_ylabel("added by the effect [K]")
    return day.dressed(ax)


class Day:
    """The most variable held-out day of a fit, as it is drawn."""

    def __init__(self, fit):
        record = fit.record
        days = record.days
        change = np.abs(np.diff(record["poa_global"], prepend=np.nan))
        seen = fit.holdout.to_numpy() if fit.test_days else np.ones(len(days), bool)
        roughness = np.bincount(days[seen], np.nan_to_num(change[seen]))
        self.rows = days == int(np.argmax(roughness))
        self.measured = record["temp_module"][self.rows]
        self.sun = record["poa_global"][self.rows]
        # hours since the clock's midnight, so that a change of the clock is no fold
        index = record.index[self.rows]
        first = index[0].tz_localize(None)
        since = (index - index[0]) + (first - first.normalize())
        self.hours = since.total_seconds().to_numpy() / 3600.0
        self.date = f"{first:%Y-%m-%d}"
        self.title = f"{self.date}, {'held out' if fit.test_days else 'fitted'}"

    def reading(self, ax):
        """The measured temperature."""
        from matplotlib import rcParams

        ink = rcParams["text.color"]
        ax.plot(self.hours, self.measured, color=ink, linewidth=1.8, label="measured")
        ax.set_ylabel("module temperature [°C]")

    def modelled(self, ax, residual, words, colour):
        """The modelled temperature that leaves this residual."""
        modelled = self.measured - residual.to_numpy()[self.rows]
        ax.plot(self.hours, modelled, color=colour, linewidth=1.0, label=words)

    def dressed(self, ax):
        """The axes with the irradiance behind, hours below and a title."""
        irradiance = ax.twinx()
        irradiance.fill_between(self.hours, self.sun, color=SHADE, linewidth=0)
        irradiance.set_ylabel("irradiance [W/m²]", color=OTHER)
        irradiance.set_ylim(bottom=0)
        irradiance.tick_params(colors=OTHER)
        ax.set_zorder(irradiance.get_zorder() + 1)
        ax.patch.set_visible(False)
        ax.set_xlim(self.hours[0], max(self.hours[-1], self.hours[0] + 1.0))
        ax.set_xticks([h for h in range(0, 25, 3) if h >= self.hours[0] - 0.5])
        ax.set_xlabel("hour of the day")
        ax.set_title(self.title)
        return ax


def new_axes(ax):
    """The axes as given, or those of a new figure."""
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    return plt.subplots(figsize=(8, 4), layout="constrained")[1]


def by_hour_and_month(residual):
    """Mean residual, a row for each hour and a column for each month, as they come."""
    index = residual.index
    rows = pd.DataFrame(
        {"residual": residual.to_numpy(), "hour": index.hour, "month": index.month}
    )
    means = rows.pivot_table("residual", "hour", "month")
    return means.reindex(index=range(24), columns=pd.unique(index.month))


def largest(*means):
    """Largest mean of some maps either way, for a scale that they share. [K]"""
    values = np.abs(np.concatenate([m.to_numpy().ravel() for m in means]))
    return float(max(np.nanmax(values, initial=0.0), 0.1))


def label(name):
    """A name that may be a user's, short and with no signs that matplotlib reads."""
    name = " ".join(str(name).split())
    name = name if len(name) <= LONGEST else f"{name[: LONGEST - 1]}…"
    return name.replace("$", r"\$")


#: colours of a picture in a page, which has others in the dark
INK = "#1c1d1f"
THEME = {INK: "ink", SHADE: "shade", AFTER: "after", BEFORE: "before"}
PAGE = {
    "svg.fonttype": "none",  # the page's letters, which has those of every script
    "font.size": 9,
    "legend.fontsize": "small",
    "axes.facecolor": "none",
    **dict.fromkeys(["text.color", "axes.edgecolor", "axes.labelcolor"], INK),
    **dict.fromkeys(["xtick.color", "ytick.color"], INK),
}


def svg(draw, name, size=(4.8, 3.2)):
    """
    A picture for a page: the same text for the same input, and no style of a user's.

    Parameters
    ----------
    draw : callable
        Draws on axes.
    name : str
        One for each picture of a page, of which its identifiers are made.
    size : (float, float)
        Width and height. [inch]

    Returns
    -------
    str
        An ``svg`` element, with ``var(--ink)`` and others for the colours of `THEME`.
    """
    from matplotlib import style
    from matplotlib.figure import Figure

    text = io.StringIO()
    with style.context(["default", PAGE, {"svg.hashsalt": name}]):
        figure = Figure(figsize=size, layout="constrained")
        ax = figure.subplots()
        draw(ax)
        ax.set_title("")  # the page has it
        figure.patch.set_visible(False)
        with warnings.catch_warnings():
            # the font that is measured lacks letters which the page's may have
            warnings.filterwarnings("ignore", "Glyph")
            nothing = dict.fromkeys(["Date", "Creator", "Format", "Type"])
            figure.savefig(text, format="svg", metadata=nothing)
    return themed(text.getvalue())


def themed(text):
    """The bare element: no heading, size and names, and the page's colours."""
    text = text[text.index("<svg") :]
    text = re.sub(r'(<svg[^>]*?) width="[^"]*"', r"\1", text, count=1)
    text = re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", text, count=1)
    used = set(re.findall(r'(?:url\(|href=")#([^")]+)', text))
    text = re.sub(r' id="([^"]*)"', lambda m: m[0] if m[1] in used else "", text)
    for colour, name in THEME.items():
        text = re.sub(
            rf"(fill|stroke): {colour}", rf"\1: var(--{name}, {colour})", text
        )
    return text.strip()
