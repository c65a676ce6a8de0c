"""Axes along which rows are binned: clock, calendar and columns."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np

from pvlib_fem._record.column_names import UNITS

WEEKEND_DAYS = 14  # a record of fewer days has no weekend axis: it needs two of each
DARK = 1.0  # W/m², rows up to this irradiance have a bin of their own
DRIVER_BINS = 10  # bins of a driver, with equal numbers of rows
#: bin widths of the solar position, and the value from which one bin holds all [°]
WIDTHS = {"solar_azimuth": (12.0, 359.9), "solar_zenith": (6.0, 90.0)}
SECTORS = np.array(["N", "NE", "E", "SE", "S", "SW", "W", "NW"])
#: names of axes that are not columns
CLOCK = ("hour", "weekend", "month")
MONTHS = (
    *("January", "February", "March", "April", "May", "June"),
    *("July", "August", "September", "October", "November", "December"),
)
OF_COLUMN = "column "  # prefix of a column whose name is one of CLOCK


def month_words(name: str, start: int, end: int) -> str:
    one, other = (MONTHS[month - 1] for month in (start, end))
    return f"in {one}" if start == end else f"from {one} to {other}"


def column_words(name: str, start: float | str, end: float | str) -> str:
    """Words for a part of a column's range; missing values are in the last bin."""
    if start == "missing":
        return f"where {name} is missing"
    if name == "wind_direction":
        sectors = f"from {start}" + ("" if start == end else f" to {end}")
        return f"with wind {sectors}".replace("to missing", "on, or unknown")
    unit = f" {UNITS[name]}" if name in UNITS else ""
    if end == "missing":
        return f"with {name} from {start:g}{unit} on, or missing"
    if start == end:
        return f"with {name} at {start:g}{unit}"
    return f"with {name} between {start:g} and {end:g}{unit}"


WEEK_WORDS = {"weekdays": "on weekdays", "weekend": "at weekends"}
#: words for a part of clock or calendar
CLOCK_WORDS = {
    "hour": lambda name, start, end: f"between {start:g} and {end:g} h",
    "weekend": lambda name, start, end: WEEK_WORDS[start],
    "month": month_words,
}


@dataclass(frozen=True, eq=False)
class Axis:
    """
    An axis along which rows are binned: the bin of each row, and labels of the bins.

    Attributes
    ----------
    name : str
        Name in reports; a column never has the name of a clock axis.
    bins : array of int
        Bin of each row.
    labels : tuple
        From and to of each bin.
    column : str
        The binned column; empty for clock or calendar.
    cyclic : bool
        Whether the first bin follows the last.
    """

    name: str
    bins: np.ndarray = field(repr=False)
    labels: tuple = field(repr=False)
    column: str = ""
    cyclic: bool = False

    def of(self, rows: Any) -> Any:
        """The axis for some of the rows."""
        return self if rows.all() else replace(self, bins=self.bins[rows])

    def strongest(self, squares: np.ndarray, share: float) -> np.ndarray:
        """Shortest run of adjacent bins that holds a share of the squares."""
        count, whole = len(squares), squares.sum()
        for length in range(1, count):
            starts = np.arange(count if self.cyclic else count - length + 1)
            runs = (starts[:, None] + np.arange(length)) % count
            held = squares[runs].sum(axis=1)
            if held.max() >= share * whole:
                return runs[np.argmax(held)]
        return np.arange(count)

    def words(self, bins: list | np.ndarray, share: float) -> str:
        """Words for a run of bins, with a share of the rows in it."""
        if len(bins) == len(self.labels):
            return ""
        start, end = self.labels[bins[0]][0], self.labels[bins[-1]][1]
        words = CLOCK_WORDS.get(self.name) if not self.column else column_words
        return words(self.name, start, end)

    def place(self, bins: np.ndarray, rows: np.ndarray) -> "Place":
        """The range of some bins; ``rows`` are the numbers of rows in all bins."""
        share = float(rows[bins].sum() / rows.sum())
        ends = self.labels[bins[0]][0], self.labels[bins[-1]][1]
        words = self.words(bins, share)
        return Place(self.name, self.column, *ends, share, words)


@dataclass(frozen=True)
class Place:
    """
    The range of an axis in which a residual is large.

    Attributes
    ----------
    driver : str
        Name of the axis.
    column : str
        The binned column; empty for clock or calendar.
    start, end : float or str
        Labels of the bins: hours, months, the driver's unit, compass points.
    share : float
        Share of all rows in the range. [-]
    words : str
        The range in words; empty if it is the whole axis.
    """

    driver: str
    column: str
    start: float | str
    end: float | str
    share: float
    words: str


def axes(places: dict, dates: np.ndarray) -> Iterator:
    """
    Yield all axes of clock, calendar and columns.

    Parameters
    ----------
    places : dict of array
        ``hour``, ``month``, ``weekend``, and columns by their names. The solar position
        gets bins of equal width, other columns bins with equal numbers of values. A
        column of few values gets a bin for each.
    dates : array of int
        Day of each value, from 1970-01-01.
    """
    hours = tuple((h, h + 1) for h in range(24))
    yield Axis("hour", places["hour"], hours, cyclic=True)
    if len(np.unique(dates)) >= WEEKEND_DAYS:
        labels = (("weekdays",) * 2, ("weekend",) * 2)
        yield Axis("weekend", places["weekend"].astype(int), labels)
    month = places["month"] - 1
    if len(np.unique(month)) > 1:
        labels = tuple((m, m) for m in range(1, 13))
        yield Axis("month", month, labels, cyclic=True)
    for name, values in places.items():
        if name in CLOCK:
            continue
        if (axis := sorted_by(name, values)) is not None:
            yield axis


def sorted_by(name: str, values: np.ndarray) -> Axis | None:
    """Axis of one driver; None if it does not vary."""
    known = np.isfinite(values)
    if name == "wind_direction":
        count = len(SECTORS)
        bins = np.round(np.nan_to_num(values) * count / 360.0).astype(int) % count
        labels = tuple((s, s) for s in SECTORS)
        return Axis(name, *with_missing(bins, labels, known), name, cyclic=True)
    if name in WIDTHS:
        return of_width(name, np.minimum(values, WIDTHS[name][1]), WIDTHS[name][0])
    finite = values[known]
    if name == "poa_global":  # nights are a bin of their own
        finite = finite[finite > DARK]
    if len(finite) == 0:
        return None
    inner = np.linspace(0.0, 1.0, DRIVER_BINS + 1)[1:-1]
    cuts = np.unique(np.quantile(finite[:: max(1, len(finite) // 20_000)], inner))
    if name == "poa_global":
        cuts = np.concatenate(([DARK], cuts))
    low, high = finite.min(), finite.max()
    cuts = cuts[(cuts > min(low, np.nanmin(values))) & (cuts <= high)]
    if len(cuts) == 0:
        return None
    edges = [min(low, np.nanmin(values)), *cuts, high]
    labels = tuple((rounded(a), rounded(b)) for a, b in pairwise(edges))
    bins = np.searchsorted(cuts, values, side="right")
    clear = name not in CLOCK and not name.startswith(OF_COLUMN)
    shown = name if clear else OF_COLUMN + name
    return Axis(shown, *with_missing(bins, labels, known), name)


def of_width(name: str, values: Any, width: Any) -> Any:
    """Bins of equal width."""
    bins = np.floor(values / width).astype(int)
    low, high = bins.min(), bins.max()
    labels = tuple((n * width, (n + 1) * width) for n in range(low, high + 1))
    return Axis(name, bins - low, labels, name)


def with_missing(
    bins: np.ndarray, labels: tuple, known: np.ndarray
) -> tuple[np.ndarray, tuple]:
    """Bins and labels with one more bin for rows where the driver is missing."""
    if known.all():
        return bins, labels
    return np.where(known, bins, len(labels)), (*labels, ("missing",) * 2)


def rounded(value: float) -> float:
    return float(f"{value:.3g}")
