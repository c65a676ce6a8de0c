"""Picture of monthly coefficients: changes of a module or of its sensors."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from pvlib_fem.plotting._style import (
    AFTER,
    BEFORE,
    OTHER,
    Look,
    dated_axis,
    escaped_name,
    new_axes,
    panels,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pvlib_fem._fitting.fem_fit import FemFit

WIDE = 5.0  # an interval this many times the usual may exceed the panel
ROOM = 1.5  # margin on either side of the values, in usual intervals


def plot_through_time(
    fit: "FemFit",
    ax: "Axes | None" = None,
    changes: Sequence[Any] = (),
) -> "Axes":
    r"""
    Each coefficient per month, with its 95 % interval.

    An interval much wider than the others exceeds its panel.

    Parameters
    ----------
    fit : FemFit or DataFrame
        A fit, to draw its months and a line at the value of the whole record; or the
        table of :meth:`~pvlib_fem.FemFit.through_time` for other periods.
    ax : matplotlib Axes, optional
        Where to draw, all panels inside; a new figure without it.
    changes : sequence of dates, optional
        Dates of vertical lines, such as ``["2012-04-01"]``.

    Returns
    -------
    matplotlib Axes
        The upper panel. The lower panels share its x axis.

    Raises
    ------
    ValueError
        If the fit has no daily sums, or a change is no date.

    Examples
    --------
    >>> from pvlib_fem import datasets, fit_fem
    >>> data = datasets.synthetic(days=120, step=900)
    >>> names = ["poa_global", "temp_air", "wind_speed", "temp_module"]
    >>> fit = fit_fem(*(data[name] for name in names), model="faiman")
    >>> ax = plot_through_time(fit, changes=["2023-08-01"])
    >>> [axes.get_ylabel() for axes in ax.figure.axes][:2]
    ['r_eq\n[K m²/W]', 'u0\n[W/(m² K)]']
    """
    from matplotlib.dates import date2num

    table, whole = fit, {}
    if not isinstance(fit, pd.DataFrame):
        table, whole = fit.through_time(), fit.coefficients
    dates = [date_of(change) for change in changes]
    names = list(table.index.unique("coefficient"))
    axes = panels(new_axes(ax, height=1.3 * len(names) + 0.6), [1.0] * len(names))
    for name, panel in zip(names, axes):
        rows = table.loc[name]
        draw_periods(panel, rows)
        panel.set_ylabel(f"{escaped_name(name)}\n[{rows['unit'].iloc[0]}]")
        if name in whole:
            panel.axhline(whole[name], color=OTHER, linewidth=0.8, zorder=0)
        for date in dates:
            panel.axvline(date2num(date), color=BEFORE, linestyle="--", linewidth=1.2)
        panel.tick_params(axis="x", labelbottom=panel is axes[-1])
    dated_axis(axes[-1])
    for date in dates:
        words: Look = dict(xytext=(3, -3), textcoords="offset points", va="top")
        place: Look = dict(xy=(date, 1.0), xycoords=("data", "axes fraction"))
        axes[0].annotate(f"{date:%Y-%m-%d}", **place, **words, color=BEFORE)
    return axes[0]


def date_of(change: Any) -> pd.Timestamp:
    """A date without a time zone, as on the axis."""
    try:
        return pd.Timestamp(change).tz_localize(None)
    except (TypeError, ValueError) as error:
        raise ValueError(
            f"changes hold {change!r}, which is no date ({error}); give dates such as "
            "['2012-04-01']"
        ) from error


def draw_periods(ax: "Axes", rows: pd.DataFrame) -> None:
    """Draw values in the middle of their periods, with intervals."""
    starts = pd.DatetimeIndex(rows.index).tz_localize(None)
    length = np.median(np.diff(starts)) if len(starts) > 1 else pd.Timedelta(0)
    middle = starts + pd.Timedelta(length) / 2
    value = rows["value"].to_numpy()
    below, above = value - rows["lower"], rows["upper"] - value
    reach = np.stack([below, above]).clip(min=0.0)
    look: Look = dict(color=AFTER, linewidth=1.0, elinewidth=1.0, markersize=3.5)
    ax.errorbar(middle, value, reach, marker="o", **look)
    usual = np.nanmedian(reach.max(axis=0)) if np.isfinite(value).any() else np.nan
    precise = value[reach.max(axis=0) <= WIDE * usual]
    if len(precise):
        room = ROOM * usual or 1e-3 * np.abs(precise).max()
        ax.set_ylim(precise.min() - room, precise.max() + room)
