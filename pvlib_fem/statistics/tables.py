"""Where a residual lives: tables of its mean over clock, calendar and drivers."""

from dataclasses import dataclass, field, replace
from itertools import combinations, pairwise

import numpy as np

DAY = 86400.0  # s
SECTORS = np.array(["N", "NE", "E", "SE", "S", "SW", "W", "NW"])
#: names that are not a column's
CLOCK = ("hour", "weekend", "month", "timetable_days", "timetable_minutes")
OF_COLUMN = "column "  # before a column's name that could be taken for one of those


@dataclass(frozen=True, eq=False)
class Axis:
    """
    One way to sort rows: a bin for each, and what the bins are called.

    Attributes
    ----------
    name : str
        As it is told; that of a column is never that of a clock.
    bins : array of int
        Of each row.
    labels : tuple
        From and to of each bin.
    column : str
        The column that it sorts by; none where that is clock or calendar.
    cyclic : bool
        Whether the first bin follows the last.
    period : float
        Time after which a timetable comes again, 0 for anything else. [s]
    """

    name: str
    bins: np.ndarray = field(repr=False)
    labels: tuple = field(repr=False)
    column: str = ""
    cyclic: bool = False
    period: float = 0.0

    def of(self, rows):
        """The same for some of the rows."""
        return self if rows.all() else replace(self, bins=self.bins[rows])

    def strongest(self, squares, share):
        """Shortest run of bins that holds a share of the squares, in order."""
        count, whole = len(squares), squares.sum()
        for length in range(1, count):
            starts = np.arange(count if self.cyclic else count - length + 1)
            runs = (starts[:, None] + np.arange(length)) % count
            held = squares[runs].sum(axis=1)
            if held.max() >= share * whole:
                return runs[np.argmax(held)]
        return np.arange(count)

    def words(self, bins, share):
        """Words for a run of bins, with a share of the rows in it."""
        if len(bins) == len(self.labels):
            return ""
        start, end = self.labels[bins[0]][0], self.labels[bins[-1]][1]
        if not self.column and isinstance(start, str):
            return start
        start, end = (v if isinstance(v, str) else f"{v:g}" for v in (start, end))
        return f"{self.name} {start}" + ("" if start == end else f"–{end}")

    def place(self, bins, rows):
        """The place that some bins are, of as many rows in each."""
        share = float(rows[bins].sum() / rows.sum())
        ends = self.labels[bins[0]][0], self.labels[bins[-1]][1]
        told = self.words(bins, share)
        return Place(self.name, self.column, *ends, share, self.period, told)


@dataclass(frozen=True)
class Place:
    """
    Where along one axis a residual lives.

    Attributes
    ----------
    driver : str
        The axis.
    column : str
        The column that it is made of; none where that is clock or calendar.
    start, end : float or str
        Labels of the bins: hours, months, the driver's unit, compass points; of a
        timetable the dates of its first days, or its phase. [min]
    share : float
        Of all rows that lie there: the duty of a timetable. [-]
    period : float
        Time after which a timetable comes again, 0 for anything else. [s]
    words : str
        The same to be read; empty where it is everywhere along the axis.
    """

    driver: str
    column: str
    start: float | str
    end: float | str
    share: float
    period: float
    words: str


@dataclass(frozen=True, eq=False)
class Structure:
    """A table of the residual's mean that holds on weeks it was not made of."""

    places: tuple  # one for each axis
    gain: float  # what it takes off the held-out error [K]
    size: float  # mean residual there [K]
    values: np.ndarray = field(repr=False)  # of each row, from other weeks [K]

    @property
    def drivers(self):
        return tuple(place.driver for place in self.places)

    @property
    def name(self):
        return " × ".join(self.drivers)

    @property
    def ranges(self):
        """From and to, by driver."""
        return {place.driver: (place.start, place.end) for place in self.places}

    @property
    def where(self):
        """The places in words."""
        words = [place.words for place in self.places if place.words]
        return " × ".join(words) or f"all of {self.name}"


def axes(index, dates, columns, criteria):
    """
    All ways to sort the rows but by timetables, which the residual itself shows.

    ``columns`` are the drivers by name; those with few values get a bin for
    each, the others bins with equal numbers of rows.
    """
    hour = np.asarray(index.hour)
    month = np.asarray(index.month) - 1
    yield Axis("hour", hour, tuple((h, h + 1) for h in range(24)), cyclic=True)
    if len(np.unique(dates)) >= criteria.weekend_days:
        weekend = (np.asarray(dates) + 3) % 7 >= 5  # 1970-01-01 was a Thursday
        labels = (("weekdays",) * 2, ("weekend",) * 2)
        yield Axis("weekend", weekend.astype(int), labels)
    if len(np.unique(month)) > 1:
        labels = tuple((m, m) for m in range(1, 13))
        yield Axis("month", month, labels, cyclic=True)
    for name, values in columns.items():
        if (axis := sorted_by(name, values, criteria)) is not None:
            yield axis


def sorted_by(name, values, criteria):
    """Bins of one driver, or nothing where it does not vary."""
    if name == "wind_direction":
        count = len(SECTORS)
        bins = np.round(np.nan_to_num(values) * count / 360.0).astype(int) % count
        return Axis(name, bins, tuple((s, s) for s in SECTORS), name, cyclic=True)
    finite = values[np.isfinite(values)]
    if name == "poa_global":  # nights are a bin of their own
        finite = finite[finite > criteria.dark]
    if len(finite) == 0:
        return None
    inner = np.linspace(0.0, 1.0, criteria.driver_bins + 1)[1:-1]
    cuts = np.unique(np.quantile(finite[:: max(1, len(finite) // 20_000)], inner))
    if name == "poa_global":
        cuts = np.concatenate(([criteria.dark], cuts))
    low, high = finite.min(), finite.max()
    cuts = cuts[(cuts > min(low, values.min())) & (cuts <= high)]
    if len(cuts) == 0:
        return None
    edges = [min(low, np.nanmin(values)), *cuts, high]
    labels = tuple((rounded(a), rounded(b)) for a, b in pairwise(edges))
    bins = np.searchsorted(cuts, values, side="right")
    clear = name not in CLOCK and not name.startswith(OF_COLUMN)
    return Axis(name if clear else OF_COLUMN + name, bins, labels, name)


def rounded(value):
    return float(f"{value:.3g}")


def find_structure(residual, seconds, folds, axes, step, criteria, without=()):
    """
    The table that takes most off the residual of weeks that it has not seen.

    Parameters
    ----------
    residual : array
        [K]
    seconds : array
        Time of each row. [s]
    folds : array of int
        Group of weeks of each row.
    axes : sequence of Axis
        Of :func:`axes`, and the timetables if there are any.
    step : float
        Usual time between rows. [s]
    criteria : Criteria
        Thresholds of the stage *structure*.
    without : sequence of str
        Columns that it may not use.

    Returns
    -------
    Structure or None
        None where no table gains anything.
    """
    kept = [axis for axis in axes if axis.column not in without]
    # clock and calendar come first, which columns only follow
    kept.sort(key=lambda axis: bool(axis.column))
    quick = {i for i, axis in enumerate(kept) if 0 < axis.period < DAY}
    residual = residual - residual.mean()
    series = (residual, seconds, folds)
    wide = gathered(kept, (), *series, criteria.cell_time)
    narrow = gathered(kept, quick, *series, criteria.cell_time) if quick else wide
    shrink = criteria.cell_weight / step
    best, found = {}, {}
    for chosen in ways(kept):
        cells = narrow if quick & {*chosen} else wide
        bins, count = joined([cells.axes[i] for i in chosen])
        gains, means = held_out_gain(bins, count, *cells.rest, shrink)
        if (gains > 0).sum() < criteria.fold_share * len(gains):
            continue  # an accident of some weeks
        gain = gains.sum()
        if gain > criteria.better_gain * best.get(len(chosen), 0.0):
            best[len(chosen)], found[len(chosen)] = gain, (chosen, means)
    if not best:
        return None
    pair = best.get(2, 0.0) > criteria.pair_gain * best.get(1, 0.0)
    chosen, means = found[2 if pair else 1]
    chosen = [kept[i] for i in chosen]
    bins, count = joined(chosen)
    places, size = placed(chosen, residual, bins, count, shrink, criteria)
    gain = float(np.sqrt(best[len(chosen)]))
    return Structure(places, gain, size, means[folds, bins])


def ways(axes):
    """Places of each axis, and of each two that are not of a kind."""
    numbers = range(len(axes))
    pairs = combinations(numbers, 2)
    kinds = [axis.name for axis in axes]
    return [
        *((i,) for i in numbers),
        *((i, j) for i, j in pairs if kinds[i] != kinds[j]),
    ]


@dataclass(frozen=True, eq=False)
class Cells:
    """Runs of rows that share clock, calendar and drivers."""

    axes: list  # with the bin of each cell
    rest: tuple  # sum of the residual, number of rows, fold


def gathered(axes, quick, residual, seconds, folds, cell_time):
    """Cells inside which no bin of the ``quick`` axes changes."""
    marks = [np.floor(seconds / cell_time), folds, *(axes[i].bins for i in quick)]
    new = np.any([np.diff(mark) != 0 for mark in marks], axis=0)
    first = np.concatenate(([0], np.flatnonzero(new) + 1))
    size = np.diff(np.append(first, len(seconds)))
    sums = np.add.reduceat(residual, first)
    coarse = [replace(axis, bins=axis.bins[first]) for axis in axes]
    return Cells(coarse, (sums, size, folds[first]))


def joined(chosen):
    """One bin for each row from one or two axes."""
    if len(chosen) == 1:
        return chosen[0].bins, len(chosen[0].labels)
    one, two = chosen
    wide = len(two.labels)
    return one.bins * wide + two.bins, len(one.labels) * wide


def held_out_gain(bins, count, sums, rows, folds, shrink):
    """Fall of the mean square in each fold by means of the others, and those."""
    groups = folds.max() + 1
    place = folds * count + bins
    shape = (groups, count)
    held = np.bincount(place, sums, groups * count).reshape(shape)
    size = np.bincount(place, rows, groups * count).reshape(shape)
    others = size.sum(axis=0) - size
    means = (held.sum(axis=0) - held) / (others + shrink)
    gains = (2.0 * means * held - means**2 * size).sum(axis=1) / rows.sum()
    return gains, means


def placed(chosen, residual, bins, count, shrink, criteria):
    """Place of the strongest cells along each axis, and the mean residual there."""
    sums = np.bincount(bins, residual, count)
    rows = np.bincount(bins, minlength=count)
    means = sums / (rows + shrink)
    strong = np.abs(means) >= criteria.strong_cell * np.abs(means).max()
    squares = np.where(strong, means**2 * rows, 0.0)
    top = strong & (np.sign(means) == np.sign(squares @ np.sign(means)))
    if any(axis.period for axis in chosen):
        # what happens half of the time leaves as much of the other sign
        squares = np.where(top, squares, 0.0)
    shape = [len(axis.labels) for axis in chosen]
    places = []
    for i, axis in enumerate(chosen):
        other = tuple(j for j in range(len(shape)) if j != i)
        along, size = (t.reshape(shape).sum(axis=other) for t in (squares, rows))
        places.append(axis.place(axis.strongest(along, criteria.place_share), size))
    return tuple(places), float(sums[top].sum() / max(rows[top].sum(), 1))
