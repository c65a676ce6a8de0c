"""Axes along which rows are binned: clock, calendar and columns."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.column_names import UNITS

WEEKEND_DAYS = 14  # a record of fewer days has no weekend axis: it needs two of each
DARK = 1.0  # W/m², rows up to this irradiance have a bin of their own
DRIVER_BINS = 10  # bins of a driver, with equal numbers of rows
#: bin widths of the solar position, and the value from which one bin holds all [°]
WIDTHS = {"solar_azimuth": (12.0, 359.9), "solar_zenith": (6.0, 90.0)}
SECTORS = np.array(["N", "NE", "E", "SE", "S", "SW", "W", "NW"])
#: drivers that are a past mean minus the present value: quantity, span and unit
PAST = {
    "poa_stored_1h": ("the irradiance", "hour", "W/m²"),
    "poa_stored_3h": ("the irradiance", "3 h", "W/m²"),
    "air_stored": ("the air temperature", "3 h", "K"),
}
SINCE_RAIN = "hours_since_rain"  # and driver
DRY = 72.0  # h after rain, which have their bin with all later ones
#: names of axes that are not columns
CLOCK = ("hour", "weekend", "month")
MONTHS = (
    *("January", "February", "March", "April", "May", "June"),
    *("July", "August", "September", "October", "November", "December"),
)
OF_COLUMN = "column "  # prefix of a column whose name is one of CLOCK
MISSING = ("missing", "missing")  # label of the bin of missing values


def month_words(name: str, start: int, end: int) -> str:
    one, other = (MONTHS[month - 1] for month in (start, end))
    return f"in {one}" if start == end else f"from {one} to {other}"


def past_words(name: str, start: Any, end: Any) -> str:
    """Words for a part of the range of a past mean minus the present value."""
    what, span, unit = PAST[name]
    low, high = f"{abs(start):g}", f"{abs(end):g}"
    if end <= 0.0:
        than = f"{high} to {low} {unit} lower"
    elif start >= 0.0:
        than = f"{low} to {high} {unit} higher"
    else:
        than = f"from {low} {unit} lower to {high} {unit} higher"
    return f"where {what} of the past {span} was {than} than now"


def rain_words(start: Any, end: Any) -> str:
    """Words for a part of the time after rain."""
    if end >= DRY:
        return f"from {start:.2g} h after rain on"
    return f"from {start:.2g} to {end:.2g} h after rain"


def column_words(name: str, start: float | str, end: float | str) -> str:
    """Words for a part of a column's range; missing values are in the last bin."""
    if start == "missing":
        return f"where {name} is missing"
    if name in PAST and end != "missing":
        return past_words(name, start, end)
    if name == SINCE_RAIN:
        return rain_words(start, end)
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
    """An axis along which rows are binned."""

    name: str  # in reports; a column never has the name of a clock axis
    #: of each row
    bins: np.ndarray = field(repr=False, default_factory=lambda: np.zeros(0, dtype=int))
    #: from and to of each bin
    labels: tuple[tuple[Any, Any], ...] = field(repr=False, default=())
    column: str = ""  # the binned one; empty for clock or calendar
    cyclic: bool = False  # whether the first bin follows the last
    #: least value of the second bin, of the third and so on; compass points have none
    cuts: tuple[float, ...] = field(repr=False, default=())

    in_file = ("name", "labels", "column", "cyclic", "cuts")

    @classmethod
    def of_values(
        cls,
        name: str,
        values: np.ndarray,
        labels: tuple,
        cuts: tuple = (),
        column: str = "",
        cyclic: bool = False,
    ) -> "Axis":
        """The axis of some values; missing ones get a bin of their own."""
        if not np.isfinite(values).all():
            labels = (*labels, MISSING)
        axis = cls(name, labels=labels, column=column, cyclic=cyclic, cuts=cuts)
        return replace(axis, bins=axis.numbers(values))

    @property
    def known(self) -> int:
        """Number of bins without that of missing values."""
        return len(self.labels) - (self.labels[-1] == MISSING)

    def numbers(self, values: np.ndarray) -> np.ndarray:
        """Bin of each of some values; -1 for a missing one without a bin."""
        count = self.known
        if self.column == "wind_direction":
            bins = np.round(np.nan_to_num(values) * count / 360.0).astype(int) % count
        else:
            bins = np.searchsorted(self.cuts, values, side="right")
        unknown = count if count < len(self.labels) else -1
        return np.where(np.isfinite(values), bins, unknown)

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

    def ends(self, bins: list | np.ndarray) -> tuple[Any, Any]:
        """From and to of a run of bins."""
        return self.labels[bins[0]][0], self.labels[bins[-1]][1]

    def words(self, bins: list | np.ndarray) -> str:
        """Words for a run of bins."""
        words = CLOCK_WORDS.get(self.name) if not self.column else column_words
        return words(self.name, *self.ends(bins))


def axes(places: dict, dates: np.ndarray) -> Iterator:
    """
    Yield all axes of clock, calendar and columns.

    Parameters
    ----------
    places : dict of array, shape (values,)
        ``hour``, ``month``, ``weekend``, and columns by their names. The solar position
        gets bins of equal width, other columns bins with equal numbers of values. A
        column of few values gets a bin for each.
    dates : array of int, shape (values,)
        Day of each value, from 1970-01-01.

    Yields
    ------
    Axis
        No weekend for less than 14 days, no month for a single one, and no column that
        does not vary.
    """
    hours = tuple((h, h + 1) for h in range(24))
    cuts = tuple(range(1, 24))
    yield Axis.of_values("hour", places["hour"], hours, cuts, cyclic=True)
    if len(np.unique(dates)) >= WEEKEND_DAYS:
        labels = (("weekdays",) * 2, ("weekend",) * 2)
        yield Axis.of_values("weekend", places["weekend"], labels, (1,))
    if len(np.unique(places["month"])) > 1:
        labels = tuple((m, m) for m in range(1, 13))
        cuts = tuple(range(2, 13))
        yield Axis.of_values("month", places["month"], labels, cuts, cyclic=True)
    for name, values in places.items():
        if name in CLOCK:
            continue
        if (axis := sorted_by(name, values)) is not None:
            yield axis


def calendar_of(index: pd.Index) -> dict[str, np.ndarray]:
    """
    Hour, month and weekend of some times, as the axes have them.

    Parameters
    ----------
    index : DatetimeIndex, length rows
        Times; the hour is that of their zone.

    Returns
    -------
    dict of array, shape (rows,)
        ``hour`` from 0 to 23, ``month`` from 1 to 12, and ``weekend``, True on Saturday
        and Sunday.
    """
    times = pd.DatetimeIndex(index)
    calendar = {"hour": np.asarray(times.hour), "month": np.asarray(times.month)}
    return calendar | {"weekend": np.asarray(times.day_of_week) >= 5}


def sorted_by(name: str, values: np.ndarray) -> Axis | None:
    """
    Axis of one driver.

    Parameters
    ----------
    name : str
        Name of the column; the solar position, ``wind_direction`` and ``poa_global``
        have bins of their own kind.
    values : array, shape (values,)
        Values of the column, in its unit; NaN where they are missing.

    Returns
    -------
    Axis or None
        None if the column does not vary.
    """
    if name == "wind_direction":
        labels = tuple((s, s) for s in SECTORS)
        return Axis.of_values(name, values, labels, column=name, cyclic=True)
    if name in WIDTHS:
        return of_width(name, np.minimum(values, WIDTHS[name][1]), WIDTHS[name][0])
    finite = values[np.isfinite(values)]
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
    labels = tuple((rounded_cut(a), rounded_cut(b)) for a, b in pairwise(edges))
    clear = name not in CLOCK and not name.startswith(OF_COLUMN)
    shown = name if clear else OF_COLUMN + name
    return Axis.of_values(shown, values, labels, tuple(cuts.tolist()), name)


def of_width(name: str, values: np.ndarray, width: float) -> Axis:
    """Bins of equal width."""
    ends = np.floor(np.array([values.min(), values.max()]) / width).astype(int)
    places = range(ends[0], ends[1] + 1)
    labels = tuple((n * width, (n + 1) * width) for n in places)
    cuts = tuple(n * width for n in places[1:])
    return Axis.of_values(name, values, labels, cuts, name)


def rounded_cut(value: float) -> float:
    return float(f"{value:.3g}")
