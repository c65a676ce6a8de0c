"""Maps of a residual: its mean by hour and month, by wind, by any two columns."""

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pvlib_fem._statistics import axes
from pvlib_fem.plotting._style import Look, label_with_unit, new_axes, polar_axes
from pvlib_fem.types import Numeric

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SECTORS = 16  # of a wind rose
FINER = 3  # pieces of a sector, so that it is drawn round
LEAST_ROWS, LEAST_DAYS = 10, 3  # a cell with fewer stays empty
OUTER = 0.001  # share of the rows that may be beyond the first and the last bin
YEAR = 12  # months, more of which have ticks at years
MOST_YEARS = 6  # that have a tick
MOST_CELLS = 600  # of a picture of vectors; more become an image
MOST_DASHES = 24  # in a row
CLEAR = 0.2  # a mean below minus this share of the scale has a dash


def plot_residual_map(
    residual: pd.Series, ax: "Axes | None" = None, limit: float | None = None
) -> "Axes":
    """
    Mean residual by hour of day and month, each month of each year by itself.

    Cells clearly below zero have a dash, which is visible in a grey print, too.

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
    draw_cells(ax, months, np.arange(25), means, limit)
    ticks, names = month_ticks(means.columns)
    ax.set_xticks(ticks, names)
    ax.set_yticks(range(0, 25, 6))
    ax.set_ylabel("hour of the day")
    ax.set_xlabel("month" if len(means.columns) <= YEAR else "month, by year")
    ax.tick_params(axis="x", length=0 if len(means.columns) <= YEAR else 3)
    return ax


def month_ticks(months: pd.Index) -> tuple[np.ndarray, list[str]]:
    """Places and names of ticks: each month, or January of some years."""
    if len(months) <= YEAR:
        names = [
            pd.Timestamp(2000, month % YEAR + 1, 1).month_name() for month in months
        ]
        width = 1 if len(names) > 8 else 3
        return np.arange(len(months)) + 0.5, [name[:width] for name in names]
    years = np.unique(months // YEAR)
    some = years[:: -(-len(years) // MOST_YEARS)]
    places = np.array([YEAR * year - months[0] for year in some])
    there = places >= 0
    return places[there], [str(year) for year in some[there]]


def plot_residual_by(
    residual: pd.Series,
    x: pd.Series,
    y: pd.Series | None,
    ax: "Axes | None" = None,
    limit: float | None = None,
) -> "Axes":
    """
    Mean residual over two columns, such as irradiance and wind.

    A bin needs 10 rows from 3 days, or from all days of a shorter record; otherwise
    it stays empty. There are about ten even bins in each direction; a thousandth of
    the rows at either end of a column may be beyond them. Bins clearly below zero
    have a dash, which is visible in a grey print, too.

    Parameters
    ----------
    residual : Series
        Measured minus modelled temperature, with a DatetimeIndex. [K]
    x, y : Series
        The columns, on the same index. Their names label the axes, with the unit if
        the name is one of pvlib's.
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
    x, y = aligned_column(residual, x, "x"), aligned_column(residual, y, "y")
    across, up = bin_edges(x, "x"), bin_edges(y, "y")
    ax = new_axes(ax)
    means = cell_means(residual, bin_of_row(x, across), bin_of_row(y, up), across, up)
    draw_cells(ax, across, up, means, limit)
    ax.set_xlabel(label_with_unit(x.name))
    ax.set_ylabel(label_with_unit(y.name))
    return ax


def plot_residual_rose(
    residual: pd.Series,
    wind_speed: Numeric,
    wind_direction: pd.Series,
    ax: "Axes | None" = None,
    limit: float | None = None,
) -> "Axes":
    """
    Mean residual by wind direction and wind speed.

    North is up, east to the right, calm in the middle. The rose has sixteen sectors;
    bins of speed and empty bins are as in :func:`plot_residual_by`.

    Parameters
    ----------
    residual : Series
        Measured minus modelled temperature, with a DatetimeIndex. [K]
    wind_speed : Series
        [m/s]
    wind_direction : Series
        Direction that the wind comes from, clockwise from north. [°]
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
    means, speed = by_sector(residual, wind_speed, wind_direction)
    ax = polar_axes(ax)
    ax.set_theta_zero_location("N")
    ax.set_theta_direction(-1)
    ax.set_xticks(np.radians(range(0, 360, 45)), axes.SECTORS)
    width = 2 * np.pi / SECTORS
    pieces = np.linspace(0, 2 * np.pi, SECTORS * FINER + 1) - width / 2
    ax.grid(False)  # it would lie between the cells
    draw_cells(ax, pieces, speed, means, limit, FINER)
    ax.set_ylim(0.0, speed[-1])
    # no ring at or near the rim, whose line would cross its label
    rings = speed[2:-2:2] if len(speed) > 4 else speed[1:2]
    ax.set_yticks(rings, [f"{s:g} m/s" for s in rings])
    ax.set_rlabel_position(180.0 / SECTORS)
    for text in ax.get_yticklabels():  # they are on cells, in any style
        text.set(color="black", size="small")
        text.set_bbox(dict(facecolor="white", alpha=0.85, linewidth=0, pad=1))
    return ax


def draw_cells(
    ax: "Axes",
    across: np.ndarray,
    up: np.ndarray,
    means: pd.DataFrame,
    limit: float | None = None,
    pieces: int = 1,
) -> None:
    """
    Draw cells from blue (model too hot) to red, with their scale.

    Parameters
    ----------
    ax : matplotlib Axes
    across, up : array
        Edges of the cells, of ``m·pieces + 1`` and of ``n + 1`` values.
    means : DataFrame
        ``n`` rows, one for each bin of ``up``, and ``m`` columns, one for each of
        ``across``. [K]
    limit : float, optional
        End of the colour scale either way, by default the largest mean. [K]
    pieces : int, default 1
        Parts into which each column is divided.
    """
    limit = largest_mean(means) if limit is None else limit
    values = means.to_numpy(dtype=float)
    colours: Look = dict(cmap="RdBu_r", vmin=-limit, vmax=limit)
    # edges in the colour of the cell avoid seams in a vector picture
    if values.size > MOST_CELLS:
        colours |= dict(rasterized=True)
    else:
        colours |= dict(edgecolors="face", linewidth=1.0)
    cells = ax.pcolormesh(across, up, np.repeat(values, pieces, axis=1), **colours)
    # dashes, because lightness alone does not show the sign
    rows, columns = np.nonzero(values < -CLEAR * limit)
    if pieces > 1:  # the middle of a rose has room for a few
        some = columns % np.choose(np.minimum(rows, 2), (4, 2, 1)) == 0
        rows, columns = rows[some], columns[some]
    some = columns % -(-values.shape[1] // MOST_DASHES) == 0  # as many as can be seen
    rows, columns = rows[some], columns[some]
    x = (across[::pieces][:-1] + across[::pieces][1:])[columns] / 2
    y = (np.asarray(up)[:-1] + np.asarray(up)[1:])[rows] / 2
    dark = values[rows, columns] < -0.6 * limit
    shades = np.where(dark, "white", "black")
    ax.scatter(x, y, 9, shades, marker="_", linewidths=0.8, label="below zero")
    bar = ax.figure.colorbar(cells, ax=ax)
    bar.set_label("measured − modelled [K]")


def by_hour_and_month(residual: pd.Series) -> pd.DataFrame:
    """
    Mean residual, a row for each hour and a column for each month of each year.

    Parameters
    ----------
    residual : Series
        Measured minus modelled temperature, with a DatetimeIndex. [K]

    Returns
    -------
    DataFrame, shape (24, months)
        A row for each hour; columns are 12 × year + month − 1, from the first month to
        the last. NaN where there is no row. [K]
    """
    index = pd.DatetimeIndex(residual.index)
    months = YEAR * np.asarray(index.year) + np.asarray(index.month) - 1
    rows = pd.DataFrame(
        {"residual": residual.to_numpy(), "hour": index.hour, "month": months}
    )
    means = rows.pivot_table("residual", "hour", "month")
    every = range(months.min(), months.max() + 1)
    return means.reindex(index=range(24), columns=every)


def by_sector(
    residual: pd.Series, wind_speed: Numeric, wind_direction: Numeric
) -> tuple[pd.DataFrame, np.ndarray]:
    """
    Mean residual, a row for each bin of speed and a column for each sector.

    Parameters
    ----------
    residual : Series
        Measured minus modelled temperature. [K]
    wind_speed, wind_direction : Series
        On the same index. [m/s, °]

    Returns
    -------
    DataFrame
        A row for each bin of speed and a column for each sector. [K]
    array
        Edges of the bins of speed, one more than there are rows. [m/s]
    """
    speed = aligned_column(residual, wind_speed, "wind_speed")
    angle = aligned_column(residual, wind_direction, "wind_direction")
    speed = speed.clip(lower=0.0)  # a negative offset of the anemometer is calm
    up = bin_edges(speed, "wind_speed")
    up = np.concatenate(([0.0], up[up > 0.0]))
    sector = np.round(angle / (360.0 / SECTORS)) % SECTORS
    means = cell_means(
        residual, sector, bin_of_row(speed, up), np.arange(SECTORS + 1), up
    )
    # a rose ends at its last cell with a mean
    rings = max(np.flatnonzero(means.notna().any(axis=1)), default=0) + 1
    return means.iloc[:rings], up[: rings + 1]


def largest_mean(*means: pd.DataFrame) -> float:
    """
    Largest absolute mean of some maps, for a common scale.

    Parameters
    ----------
    *means : DataFrame
        Mean residuals of the cells of each map. [K]

    Returns
    -------
    float
        At least 0.1. [K]
    """
    values = np.abs(np.concatenate([m.to_numpy().ravel() for m in means]))
    return float(max(np.nanmax(values, initial=0.0), 0.1))


def aligned_column(residual: pd.Series, column: Numeric | None, name: str) -> pd.Series:
    """The column as float; ValueError if its index is not that of the residual."""
    if not isinstance(column, pd.Series) or not column.index.equals(residual.index):
        raise ValueError(
            f"{name} and the residual have different indexes; give {name} as a Series "
            "on the index of the residual, such as column.reindex(residual.index)"
        )
    return column.astype(float)


def bin_edges(column: pd.Series, name: str) -> np.ndarray:
    """About ten even bins with round edges."""
    from matplotlib.ticker import MaxNLocator

    known = column[np.isfinite(column)]
    if known.empty:
        raise ValueError(f"{name} holds no number; give a column that was measured")
    low, high = known.quantile([OUTER, 1.0 - OUTER])
    ticks = MaxNLocator(12, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
    return np.asarray(ticks)


def bin_of_row(column: pd.Series, cuts: np.ndarray) -> np.ndarray:
    """Bin of each row; NaN beyond the outer bins."""
    places = np.searchsorted(cuts, column, side="right") - 1.0
    # the last edge belongs to the last bin: a humidity of 100 % is no outlier
    places[column == cuts[-1]] = len(cuts) - 2
    return np.where((places >= 0) & (places < len(cuts) - 1), places, np.nan)


def cell_means(
    residual: pd.Series,
    across: np.ndarray | pd.Series,
    up: np.ndarray,
    columns: np.ndarray,
    rows: np.ndarray,
) -> pd.DataFrame:
    """
    Mean of each cell with enough rows and days.

    Parameters
    ----------
    residual : Series
        With a DatetimeIndex. [K]
    across, up : array
        Column and row of the cell of each value; NaN for none.
    columns, rows : array
        Edges of the cells, one more than there are columns or rows.

    Returns
    -------
    DataFrame
        A row for each bin of ``up``, a column for each of ``across``; NaN in cells with
        few rows or days.
    """
    days = pd.DatetimeIndex(residual.index).tz_localize(None).floor("D")
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
