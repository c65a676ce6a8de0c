"""Pictures of measured columns that show a fault without a thermal model."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pvlib_fem._statistics import axes
from pvlib_fem.plotting._residuals import cell_means, draw_cells
from pvlib_fem.plotting._style import (
    AFTER,
    BEFORE,
    COLOURS,
    FAINT,
    MARKERS,
    OTHER,
    STYLES,
    Look,
    dated_axis,
    escaped_name,
    new_axes,
    outside_legend,
    polar_axes,
    text_colour,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_DOTS = 240  # of a series; a longer one has medians of several days
SMOOTH = 15  # dots of the running median
SEASONS = 4  # years from which the medians of months hold no trend
SPREAD = 3.0  # interquartile ranges beyond the quartiles that are drawn
SECTORS, RINGS = 24, 9  # cells of the sky: 15° of azimuth, 10° of elevation


@dataclass(frozen=True, eq=False)
class Marks:
    """Dates of a finding: vertical lines, and a shaded period."""

    lines: tuple[str, ...] = ()
    period: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Daily:
    """Values by day, in the record's own zone."""

    days: pd.DatetimeIndex
    values: np.ndarray = field(repr=False)

    def thinned(self) -> "Daily":
        """At most `MOST_DOTS` medians of successive days."""
        width = max(1, -(-len(self.days) // MOST_DOTS))
        part = np.arange(len(self.days)) // width
        table = pd.DataFrame({"day": self.days, "value": self.values})
        table = table.groupby(part).median()
        return Daily(pd.DatetimeIndex(table["day"]), table["value"].to_numpy())

    def without_season(self) -> "Daily":
        """Of a record of several years, values over the usual ones of their month."""
        if self.days[-1] - self.days[0] < SEASONS * pd.Timedelta(days=365):
            return self
        month = pd.Series(self.values).groupby(self.days.month).transform("median")
        usual = month.to_numpy() / np.median(self.values)
        return Daily(self.days, self.values / usual)


def plot_by_date(
    series: dict, words: str, marks: Marks, ax: "Axes | None" = None
) -> "Axes":
    """
    Daily values through time, with a running median and the dates of a finding.

    Parameters
    ----------
    series : dict of Daily
        By name; more than one have a legend.
    words : str
        Label of the axis, with its unit.
    marks : Marks
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib Axes
    """
    ax = new_axes(ax)
    low, high = [], []
    for i, (name, daily) in enumerate(series.items()):
        dots = daily.thinned()
        look: Look = dict(color=COLOURS[i % len(COLOURS)])
        marker = MARKERS[i % len(MARKERS)]
        ax.plot(dots.days, dots.values, marker, markersize=2.2, alpha=0.45, **look)
        line = pd.Series(dots.values).rolling(SMOOTH, center=True, min_periods=3)
        style = STYLES[i % len(STYLES)]
        ax.plot(
            dots.days,
            line.median(),
            style,
            linewidth=1.8,
            label=escaped_name(name),
            **look,
        )
        quarter, half = np.nanquantile(dots.values, [0.25, 0.75])
        reach, middle = SPREAD * max(half - quarter, 1e-9), line.median()
        low.append(min(max(np.nanmin(dots.values), quarter - reach), middle.min()))
        high.append(max(min(np.nanmax(dots.values), half + reach), middle.max()))
    room = 0.06 * max(max(high) - min(low), 1e-9)
    ax.set_ylim(min(low) - room, max(high) + room)
    draw_dates(ax, marks)
    ax.set_ylabel(words)
    dated_axis(ax)
    if len(series) > 1:
        most = 2 if len(series) in (2, 4) else 3
        outside_legend(ax, most, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    return ax


def draw_dates(ax: "Axes", marks: Marks) -> None:
    """Draw the dates of a finding."""
    from matplotlib.dates import date2num

    for date in date2num([pd.Timestamp(day) for day in marks.lines]):
        ax.axvline(date, color=BEFORE, linestyle="--", linewidth=1.2)
    if marks.period:
        start, end = date2num([pd.Timestamp(day) for day in marks.period])
        ax.axvspan(start, end, color=text_colour(), alpha=FAINT, linewidth=0)


def plot_event(
    times: pd.DatetimeIndex,
    columns: dict,
    event: tuple,
    words: str,
    ax: "Axes | None" = None,
) -> "Axes":
    """
    Columns over some days around an event, which is shaded.

    Parameters
    ----------
    times : DatetimeIndex
    columns : dict of array
        By name, on these times.
    event : (Timestamp, Timestamp)
        Its first and last time.
    words : str
        Label of the axis, with its unit.
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib Axes
    """
    ax = new_axes(ax)
    for (name, values), colour, style in zip(columns.items(), (AFTER, BEFORE), STYLES):
        look: Look = dict(color=colour, linestyle=style, linewidth=1.5)
        ax.plot(times, values, label=escaped_name(name), **look)
    ax.axvspan(*event, color=text_colour(), alpha=FAINT, linewidth=0)
    ax.set_ylabel(words)
    dated_axis(ax)
    outside_legend(ax, 2, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    return ax


def plot_distribution(parts: dict, words: str, ax: "Axes | None" = None) -> "Axes":
    """
    Distribution of a column in two periods, as shares of its rows.

    Parameters
    ----------
    parts : dict of array
        Values by the name of the period, the earlier one first.
    words : str
        Label of the axis, with its unit.
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib Axes
    """
    ax = new_axes(ax)
    top = max(np.nanquantile(values, 0.995) for values in parts.values())
    edges = np.linspace(0.0, max(top, 1e-9), 25)
    for (name, values), colour, style in zip(parts.items(), (BEFORE, AFTER), STYLES):
        counts, _ = np.histogram(values[np.isfinite(values)], edges)
        shares = 100.0 * counts / max(counts.sum(), 1)
        mean = f"{name}, mean {np.nanmean(values):.2f}"
        ax.stairs(
            shares, edges, color=colour, linestyle=style, linewidth=1.6, label=mean
        )
        ax.axvline(np.nanmean(values), color=colour, linestyle=style, linewidth=0.8)
    ax.set_xlabel(words)
    ax.set_ylabel("share of rows [%]")
    ax.legend(loc="upper right", frameon=False)
    return ax


def plot_by_sun(
    residual: pd.Series,
    azimuth: np.ndarray,
    elevation: np.ndarray,
    windows: tuple = (),
    ax: "Axes | None" = None,
    limit: float | None = None,
) -> "Axes":
    """
    Mean residual by the position of the sun, with the zenith in the middle.

    Parameters
    ----------
    residual : Series
        Measured minus modelled temperature, with a DatetimeIndex. [K]
    azimuth, elevation : array
        Of the sun. [°]
    windows : tuple of tuple
        Parts of the sky to outline: azimuth from and to, elevation from and to. [°]
    ax : matplotlib Axes, optional
        Polar axes; a new figure without it.
    limit : float, optional
        End of the colour scale either way, by default the largest mean. [K]

    Returns
    -------
    matplotlib Axes
    """
    ax = polar_axes(ax)
    ax.set_theta_zero_location("N")
    ax.set_theta_direction(-1)
    means = by_sun(residual, azimuth, elevation)
    across = np.radians(np.linspace(0.0, 360.0, SECTORS + 1))
    up = np.linspace(0.0, 90.0, RINGS + 1)
    ax.grid(False)
    draw_cells(ax, across, up, means, limit)
    for start, end, low, high in windows:
        turn = np.radians(np.linspace(start, start + ((end - start) % 360 or 360), 30))
        ring = np.concatenate([turn, turn[::-1], turn[:1]])
        zenith = np.repeat(
            [90.0 - low, 90.0 - min(high, 90.0), 90.0 - low], (30, 30, 1)
        )
        ax.plot(ring, zenith, color=text_colour(), linewidth=1.4)
    ax.set_ylim(0.0, 90.0)
    ax.set_xticks(np.radians(range(0, 360, 45)), axes.SECTORS)
    ax.set_yticks([30.0, 60.0], ["60°", "30°"])
    for text in ax.get_yticklabels():
        text.set(color="black", size="small")
        text.set_bbox(dict(facecolor="white", alpha=0.85, linewidth=0, pad=1))
    return ax


def by_sun(
    residual: pd.Series, azimuth: np.ndarray, elevation: np.ndarray
) -> pd.DataFrame:
    """Mean residual, a row for each 10° of zenith angle, a column for each 15°."""
    across = np.floor(np.asarray(azimuth) % 360.0 / (360.0 / SECTORS))
    up = np.floor((90.0 - np.asarray(elevation)) / (90.0 / RINGS))
    up = np.where((up >= 0) & (up < RINGS), up, np.nan)
    edges = np.arange(SECTORS + 1), np.arange(RINGS + 1)
    return cell_means(residual, across, up, *edges)


def plot_against(
    values: np.ndarray, other: np.ndarray, words: tuple, ax: "Axes | None" = None
) -> "Axes":
    """
    Median and quartiles of a quantity by another one.

    Parameters
    ----------
    values, other : array
        The quantity, and that by which it is sorted into bins of equal counts.
    words : (str, str)
        Labels of the axes of ``values`` and ``other``, with units.
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.

    Returns
    -------
    matplotlib Axes
    """
    ax = new_axes(ax)
    there = np.isfinite(values) & np.isfinite(other)
    values, other = values[there], other[there]
    cuts = np.unique(np.quantile(other, np.linspace(0.0, 1.0, 13)))
    place = np.clip(np.searchsorted(cuts, other, side="right") - 1, 0, len(cuts) - 2)
    table = pd.DataFrame({"place": place, "x": other, "y": values}).groupby("place")
    middle, y = table["x"].median(), table["y"]
    low, half, high = (y.quantile(share) for share in (0.25, 0.5, 0.75))
    ax.fill_between(middle, low, high, color=text_colour(), alpha=FAINT, linewidth=0)
    ax.plot(middle, half, "o-", color=AFTER, markersize=3.5, linewidth=1.4)
    ax.axhline(0.0, color=OTHER, linewidth=0.8, zorder=0)
    ax.set_ylabel(words[0])
    ax.set_xlabel(words[1])
    return ax
