"""Pictures over time: measured and modelled temperature, contributions of effects."""

import math
from datetime import date
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pvlib_fem._record.file_summary import present
from pvlib_fem.plotting._style import (
    AFTER,
    BEFORE,
    COLOURS,
    FAINT,
    STYLES,
    Look,
    escaped_name,
    new_axes,
    outside_legend,
    panels,
    text_colour,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pvlib_fem._fitting.fem_fit import FemFit
    from pvlib_fem._loop.results.loop_result import Loop

TICKS = (1 / 12, 1 / 6, 0.25, 0.5, 1, 3, 6, 12, 24)  # h between ticks
MOST_TICKS = 9
FILLED = 2000  # points of the irradiance in the background
VISIBLE = 0.01  # share of the width from which a gap interrupts a line
LEAST = 0.1  # K, ends of an axis of contributions at least
LOWER = 0.28  # share of the height for the residual


def plot_fit(
    fit: "FemFit", ax: "Axes | None" = None, when: str | slice | date | None = None
) -> "Axes":
    """
    Measured and modelled temperature, and the residual below.

    Parameters
    ----------
    fit : FemFit
    ax : matplotlib Axes, optional
        Where to draw, both panels inside; a new figure without it.
    when : date, str or slice, optional
        A date, or times as ``.loc`` of a Series takes them, such as ``"2020-03"`` or
        ``slice("2020-03-18", "2020-03-20 12:00")``. By default the most variable
        held-out day, or the most variable day if no day is held out.

    Returns
    -------
    matplotlib Axes
        The upper panel. The lower one shares its x axis.

    Raises
    ------
    ValueError
        If ``when`` is no part of the record.
    """
    span = Span(fit, when)
    ax = new_axes(ax)
    ax, below = panels(ax, [1.0 - LOWER, LOWER])
    span.reading(ax)
    span.modelled(ax, fit.residual, f"{fit.model}, {fit.dynamics}", AFTER, "--")
    span.dressed(ax)
    room_for_legend(ax, ncols=2)
    ax.tick_params(axis="x", labelbottom=False)
    ax.set_xlabel("")
    below.axhline(0.0, color=text_colour(), linewidth=0.8)
    below.plot(span.hours, span.drawn_rows(fit.residual), color=AFTER, linewidth=1.0)
    below.set_ylabel("measured −\nmodelled [K]")
    span.clock(below)
    return ax


def plot_before_after(loop: "Loop", ax: "Axes | None" = None) -> "Axes":
    """
    The most variable test day: measured, and modelled before and after.

    If the loop shifted the module's timestamps, the model before that is not drawn.

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
    day = Span(loop.fit)
    day.reading(ax)
    changed = loop.last != loop.base
    if changed and "+clock_shift" not in loop.table.index:
        day.modelled(ax, loop.residual_before, "before", BEFORE, ":")
    words = "after" if changed else "modelled, no effect added"
    day.modelled(ax, loop.fit.residual, words, AFTER, "--")
    day.dressed(ax)
    room_for_legend(ax, ncols=3)
    return ax


def plot_contributions(loop: "Loop", ax: "Axes | None" = None) -> "Axes":
    """
    Contribution of each effect to the temperature on the most variable test day.

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
    record = present(loop.fit.record)
    # the record's times are corrected already
    parts = loop.contributions(record.inputs.frame(), correct_times=False)
    day = Span(loop.fit)
    ax.axhline(0.0, color=text_colour(), linewidth=0.8)
    for i, (name, values) in enumerate(parts.items()):
        look: Look = dict(color=COLOURS[i % len(COLOURS)], linewidth=1.4)
        # seven colours and four styles: 28 lines until both come together again
        look["linestyle"] = STYLES[i % len(STYLES)]
        size = np.sqrt(np.nanmean(values**2))
        words = f"{escaped_name(name)}, rms {size:.2f} K"
        ax.plot(day.hours, day.drawn_rows(values), label=words, **look)
    low, high = ax.get_ylim()
    ax.set_ylim(min(low, -LEAST), max(high, LEAST))  # no scale of what is nothing
    ax.set_ylabel("added by the effect [K]")
    day.dressed(ax)
    if len(parts.columns):
        most = 1 + (len(parts.columns) > 3)
        outside_legend(ax, most, loc="upper center", bbox_to_anchor=(0.5, -0.22))
    return ax


class Span:
    """The rows of a fit's record that are drawn: a day, or the given times."""

    def __init__(self, fit: "FemFit", when: str | slice | date | None = None) -> None:
        record = present(fit.record)
        self.rows = (
            most_variable_day(fit)
            if when is None
            else rows_at_times(record.index, when)
        )
        # hours since local midnight, continuous over a clock change
        index = record.index[self.rows]
        times = index.tz_localize(None)
        self.midnight = times[0].normalize()
        since = (index - index[0]) + (times[0] - self.midnight)
        hours = since.total_seconds().to_numpy() / 3600.0
        least = max(2.0 * record.inputs.step / 3600.0, VISIBLE * np.ptp(hours))
        self.gaps = 1 + np.flatnonzero(np.diff(hours) > least)
        self.hours = np.insert(hours, self.gaps, hours[self.gaps])
        self.measured = self.broken(record["temp_module"][self.rows])
        self.sun = self.broken(record["poa_global"][self.rows])
        self.start = index[0] - (times[0] - self.midnight)
        first, last = f"{times[0]:%Y-%m-%d}", f"{times[-1]:%Y-%m-%d}"
        self.date = first if first == last else f"{first} to {last}"
        out = present(fit.holdout).to_numpy()[self.rows] & (fit.test_days > 0)
        part = "held out" if out.all() else "fitted"
        part = "fitted and held out" if out.any() and not out.all() else part
        self.title = f"{self.date}, {part}"

    def broken(self, values: np.ndarray) -> np.ndarray:
        """Values of the drawn rows, with NaN in each gap, over which no line goes."""
        return np.insert(np.asarray(values, dtype=float), self.gaps, np.nan)

    def drawn_rows(self, column: pd.Series | None) -> np.ndarray:
        """The drawn rows of a Series."""
        return self.broken(present(column).to_numpy()[self.rows])

    def reading(self, ax: "Axes") -> None:
        """Draw the measured temperature."""
        ax.plot(
            self.hours,
            self.measured,
            color=text_colour(),
            linewidth=1.8,
            label="measured",
        )
        ax.set_ylabel("module temperature [°C]")

    def modelled(
        self,
        ax: "Axes",
        residual: pd.Series | None,
        words: str,
        colour: str,
        style: str,
    ) -> None:
        """Draw the modelled temperature with this residual."""
        modelled = self.measured - self.drawn_rows(residual)
        look: Look = dict(color=colour, linestyle=style, linewidth=1.5, label=words)
        ax.plot(self.hours, modelled, **look)

    def dressed(self, ax: "Axes") -> None:
        """Add irradiance in the background, ticks of time and a title."""
        irradiance = ax.twinx()
        behind: Look = dict(color=text_colour(), alpha=FAINT, linewidth=0)
        # a vector picture keeps every point of a filled area
        some = slice(None, None, max(1, len(self.hours) // FILLED))
        irradiance.fill_between(self.hours[some], self.sun[some], **behind)
        irradiance.set_ylabel("irradiance [W/m²]")
        irradiance.set_ylim(bottom=0)
        ax.set_zorder(irradiance.get_zorder() + 1)
        ax.patch.set_visible(False)
        self.clock(ax)
        ax.set_title(self.title)

    def clock(self, ax: "Axes") -> None:
        """Set ticks at hours of a day, or at days and hours of a longer span."""
        start, end = self.hours[0], self.hours[-1]
        ax.set_xlim(start, end if end > start + 0.5 else start + 0.5)
        length = ax.get_xlim()[1] - start
        fits = [step for step in TICKS if length / step <= MOST_TICKS]
        step = fits[0] if fits else 24 * math.ceil(length / 24 / MOST_TICKS)
        first = math.ceil((start - 1e-6) / step - 1e-6)
        ticks = [step * i for i in range(first, math.floor(length / step) + first + 1)]
        several = end > 25.5  # the day on which the clock goes back has 25 hours
        ax.set_xticks(ticks, [self.tick(hour, step, several) for hour in ticks])
        ax.set_xlim(start, start + length)
        words = "day" if step >= 24 else "day and hour"
        ax.set_xlabel(words if several else "hour of the day")

    def tick(self, hour: float, step: float, several: bool) -> str:
        """Label of one hour since midnight."""
        # after a clock change, labels show the new local time
        time = self.start + pd.Timedelta(hours=round(hour * 60) / 60)
        if several and time == time.normalize():
            return f"{time.day} {time.month_name()[:3]}"
        return f"{hour:g}" if step >= 1 and not several else f"{time:%H:%M}"


def most_variable_day(fit: "FemFit") -> np.ndarray:
    """Rows of the day with the most variable irradiance, held out if possible."""
    record = present(fit.record)
    days = record.days
    change = np.abs(np.diff(record["poa_global"], prepend=np.nan))
    seen = (
        present(fit.holdout).to_numpy() if fit.test_days else np.ones(len(days), bool)
    )
    roughness = np.bincount(days[seen], np.nan_to_num(change[seen]))
    return np.flatnonzero(days == int(np.argmax(roughness)))


def rows_at_times(index: pd.DatetimeIndex, when: str | slice | date) -> np.ndarray:
    """Places of the rows at the times that a user gives."""
    try:
        wanted = when
        if not isinstance(when, (str, slice)):
            wanted = f"{pd.Timestamp(when):%Y-%m-%d}"
        rows = np.atleast_1d(pd.Series(np.arange(len(index)), index).loc[wanted])
    except (KeyError, TypeError, ValueError):
        rows = []
    if len(rows) < 2:
        raise ValueError(
            f"when = {when!r} holds {len(rows)} rows of the record, which runs from "
            f"{index[0]} to {index[-1]}; give a date of it, or a slice of its times in "
            "its zone"
        )
    return np.asarray(rows)


def room_for_legend(ax: "Axes", ncols: int) -> None:
    """Add a legend in one line above all curves."""
    low, high = ax.get_ylim()
    ax.set_ylim(low, high + 0.16 * (high - low))
    ax.legend(loc="upper left", ncols=ncols, frameon=False)
