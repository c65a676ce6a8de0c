"""Where a residual lives: its mean by the clock, by the wind, by any two columns."""

from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem.plotting.look import label_with_unit, new_axes
from pvlib_fem.statistics import axes
from pvlib_fem.types import Numeric

SECTORS = 16  # of a wind rose
FINER = 3  # pieces in which a sector is drawn, so that it is round
LEAST_ROWS, LEAST_DAYS = 10, 3  # below which a cell is left empty
OUTER = 0.001  # share of the rows that may lie beyond the first and the last bin
CLEAR = 0.2  # of the scale, below zero, from which a cell has its dash


def plot_residual_map(
    residual: pd.Series, ax: Any = None, limit: float | None = None
) -> Any:
    """
    Mean residual by hour of day and month.

    Cells clearly below zero have a dash, which a print in grey keeps.

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
    means = by_hour_and_month(residual)
    ax = new_axes(ax)
    months = np.arange(means.shape[1] + 1)
    mesh(ax, months, np.arange(25), means, limit)
    names = [pd.Timestamp(2000, month, 1).month_name() for month in means.columns]
    width = 1 if len(names) > 8 else 3
    ax.set_xticks(months[:-1] + 0.5, [name[:width] for name in names])
    ax.set_yticks(range(0, 25, 6))
    ax.set_ylabel("hour of the day")
    ax.set_xlabel("month")
    ax.tick_params(axis="x", length=0)
    return ax


def plot_residual_by(
    residual: pd.Series,
    x: pd.Series,
    y: pd.Series | None,
    ax: Any = None,
    limit: float | None = None,
) -> Any:
    """
    Mean residual over two columns, such as irradiance and wind.

    A bin needs 10 rows from 3 days, or from all days of a shorter record; with
    fewer it is left empty. Bins are even and about ten each way; a thousandth of
    the rows at either end of a column may lie beyond them. Bins clearly below zero
    have a dash, which a print in grey keeps.

    Parameters
    ----------
    residual : Series
        Measured minus modelled temperature, with a DatetimeIndex. [K]
    x, y : Series
        The columns, on the same index. Their names are those of the axes, with the
        unit where the name is one of pvlib's.
    ax : matplotlib Axes, optional
        Where to draw; a new figure without it.
    limit : float, optional
        End of the colour scale either way, by default the largest mean. [K]

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    ValueError
        If an index differs from that of the residual, or a column holds no number.

    Examples
    --------
    >>> from pvlib_fem import datasets, fit_fem
    >>> data = datasets.synthetic(days=10, step=300)
    >>> names = ["poa_global", "temp_air", "wind_speed", "temp_module"]
    >>> fit = fit_fem(*(data[name] for name in names))
    >>> ax = plot_residual_by(fit.residual, data["poa_global"], data["wind_speed"])
    >>> ax.get_xlabel(), ax.get_ylabel()
    ('poa_global [W/m²]', 'wind_speed [m/s]')
    """
    x, y = aligned(residual, x, "x"), aligned(residual, y, "y")
    across, up = edges(x, "x"), edges(y, "y")
    ax = new_axes(ax)
    means = cell_means(residual, inside(x, across), inside(y, up), across, up)
    mesh(ax, across, up, means, limit)
    ax.set_xlabel(label_with_unit(x.name))
    ax.set_ylabel(label_with_unit(y.name))
    return ax


def plot_residual_rose(
    residual: pd.Series,
    wind_speed: Numeric,
    wind_direction: pd.Series,
    ax: Any = None,
    limit: float | None = None,
) -> Any:
    """
    Mean residual by where the wind comes from and how strong it is.

    North is up, east to the right, calm in the middle. Sixteen sectors; bins of
    speed, and which of them are left empty, as in :func:`plot_residual_by`.

    Parameters
    ----------
    residual : Series
        Measured minus modelled temperature, with a DatetimeIndex. [K]
    wind_speed : Series
        [m/s]
    wind_direction : Series
        Where the wind comes from, clockwise from north. [°]
    ax : matplotlib Axes, optional
        Polar axes; a new figure without it.
    limit : float, optional
        End of the colour scale either way, by default the largest mean. [K]

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    ValueError
        If ``ax`` is not polar, an index differs from that of the residual, or a
        column holds no number.
    """
    if ax is not None and ax.name != "polar":
        raise ValueError(
            f"a wind rose needs polar axes, and ax is {ax.name}; make them with "
            'plt.subplots(subplot_kw={"projection": "polar"})'
        )
    means, speed = by_sector(residual, wind_speed, wind_direction)
    ax = new_axes(ax, "polar")
    ax.set_theta_zero_location("N")
    ax.set_theta_direction(-1)
    ax.set_xticks(np.radians(range(0, 360, 45)), axes.SECTORS)
    width = 2 * np.pi / SECTORS
    pieces = np.linspace(0, 2 * np.pi, SECTORS * FINER + 1) - width / 2
    ax.grid(False)  # it would lie between the cells
    mesh(ax, pieces, speed, means, limit, FINER)
    ax.set_ylim(0.0, speed[-1])
    # none at or beside the rim, whose line would run through its words
    rings = speed[2:-2:2] if len(speed) > 4 else speed[1:2]
    ax.set_yticks(rings, [f"{s:g} m/s" for s in rings])
    ax.set_rlabel_position(180.0 / SECTORS)
    for text in ax.get_yticklabels():  # they lie on cells, whatever the style is
        text.set(color="black", size="small")
        text.set_bbox(dict(facecolor="white", alpha=0.85, linewidth=0, pad=1))
    return ax


def mesh(ax, across, up, means, limit=None, pieces=1):
    """
    Cells from blue, the model too hot, to red, with their scale.

    ``means`` has a row for each bin of ``up`` and a column for each bin of
    ``across``, which is drawn in that many ``pieces``.
    """
    limit = largest(means) if limit is None else limit
    values = means.to_numpy(dtype=float)
    colours = dict(cmap="RdBu_r", vmin=-limit, vmax=limit)
    # edges of its own colour leave no seams in a vector picture
    colours |= dict(edgecolors="face", linewidth=1.0)
    cells = ax.pcolormesh(across, up, np.repeat(values, pieces, axis=1), **colours)
    # where lightness alone would not tell the sign
    rows, columns = np.nonzero(values < -CLEAR * limit)
    if pieces > 1:  # in the middle of a rose there is room for some
        some = columns % np.choose(np.minimum(rows, 2), (4, 2, 1)) == 0
        rows, columns = rows[some], columns[some]
    x = (across[::pieces][:-1] + across[::pieces][1:])[columns] / 2
    y = (np.asarray(up)[:-1] + np.asarray(up)[1:])[rows] / 2
    dark = values[rows, columns] < -0.6 * limit
    shades = np.where(dark, "white", "black")
    ax.scatter(x, y, 9, shades, marker="_", linewidths=0.8, label="below zero")
    bar = ax.figure.colorbar(cells, ax=ax)
    bar.set_label("measured − modelled [K]")


def by_hour_and_month(residual):
    """Mean residual, a row for each hour and a column for each month, as they come."""
    index = residual.index
    rows = pd.DataFrame(
        {"residual": residual.to_numpy(), "hour": index.hour, "month": index.month}
    )
    means = rows.pivot_table("residual", "hour", "month")
    return means.reindex(index=range(24), columns=pd.unique(index.month))


def by_sector(residual, wind_speed, wind_direction):
    """Mean residual, a row for each bin of speed and a column for each sector."""
    speed = aligned(residual, wind_speed, "wind_speed")
    angle = aligned(residual, wind_direction, "wind_direction")
    speed = speed.clip(lower=0.0)  # an offset of the cups is calm
    up = edges(speed, "wind_speed")
    up = np.concatenate(([0.0], up[up > 0.0]))
    sector = np.round(angle / (360.0 / SECTORS)) % SECTORS
    means = cell_means(residual, sector, inside(speed, up), np.arange(SECTORS + 1), up)
    # a rose ends where its last cell does
    rings = max(np.flatnonzero(means.notna().any(axis=1)), default=0) + 1
    return means.iloc[:rings], up[: rings + 1]


def largest(*means):
    """Largest mean of some maps either way, for a scale that they share. [K]"""
    values = np.abs(np.concatenate([m.to_numpy().ravel() for m in means]))
    return float(max(np.nanmax(values, initial=0.0), 0.1))


def aligned(residual, column, name):
    """The column, if it stands beside the residual row by row."""
    if not isinstance(column, pd.Series) or not column.index.equals(residual.index):
        raise ValueError(
            f"{name} and the residual have different indexes; give {name} as a Series "
            "on the index of the residual, such as column.reindex(residual.index)"
        )
    return column.astype(float)


def edges(column, name):
    """About ten even bins with round edges."""
    from matplotlib.ticker import MaxNLocator

    known = column[np.isfinite(column)]
    if known.empty:
        raise ValueError(f"{name} holds no number; give a column that was measured")
    low, high = known.quantile([OUTER, 1.0 - OUTER])
    return MaxNLocator(12, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)


def inside(column, cuts):
    """Bin of each row; NaN beyond the outer ones."""
    places = np.searchsorted(cuts, column, side="right") - 1.0
    # the last edge belongs to the last bin: a humidity of 100 % is no outlier
    places[column == cuts[-1]] = len(cuts) - 2
    return np.where((places >= 0) & (places < len(cuts) - 1), places, np.nan)


def cell_means(residual, across, up, columns, rows):
    """Mean of each cell that enough rows of enough days are in."""
    days = residual.index.tz_localize(None).floor("D")
    table = pd.DataFrame(
        {
            "residual": residual.to_numpy(),
            "day": days,
            "across": np.asarray(across),
            "up": np.asarray(up),
        }
    ).dropna()
    cells = table.groupby(["up", "across"])
    enough = cells.size() >= LEAST_ROWS
    enough &= cells["day"].nunique() >= min(LEAST_DAYS, table["day"].nunique())
    means = cells["residual"].mean()[enough].reset_index()
    means = means.pivot_table("residual", "up", "across")
    return means.reindex(index=range(len(rows) - 1), columns=range(len(columns) - 1))
