"""Where a residual lives: tables of its mean over clock, calendar and drivers."""

from dataclasses import dataclass, field
from itertools import combinations, pairwise

import numpy as np

QUARTER = 900.0  # s, over which rows share a cell
BINS = 10  # of a driver, by its quantiles
HALF_DAY = 43200.0  # s of rows with which a cell's mean is shrunk towards zero
PAIR = 1.2  # times the gain of one driver from which two are worth telling
STRONG = 0.5  # of the largest mean from which a cell is where it lives
MANY = 0.8  # of the folds, in which a table has to gain
CLEARLY = 1.02  # times the gain of an earlier table from which a later one is better
MOST = 0.92  # share of the squares of these cells that a range has to hold
SECTORS = np.array(["N", "NE", "E", "SE", "S", "SW", "W", "NW"])
CYCLIC = ("hour", "month", "wind_direction")


@dataclass(frozen=True, eq=False)
class Axis:
    """One way to sort rows: a bin for each, and what the bins are called."""

    name: str
    bins: np.ndarray = field(repr=False)
    labels: tuple  # (from, to) of each bin

    def of(self, rows):
        """The same for some of the rows."""
        return self if rows.all() else Axis(self.name, self.bins[rows], self.labels)

    def range(self, first, last):
        """Words for bins first to last, which may run over the end of a cycle."""
        count = len(self.labels)
        if (last - first) % count + 1 >= count:
            return ""
        start, end = self.labels[first][0], self.labels[last][1]
        if self.name in ("weekend", "alternate_day"):
            return start
        start, end = (v if isinstance(v, str) else f"{v:g}" for v in (start, end))
        return f"{self.name} {start}" + ("" if start == end else f"–{end}")


@dataclass(frozen=True, eq=False)
class Structure:
    """A table of the residual's mean that holds on weeks it was not made of."""

    drivers: tuple
    gain: float  # what it takes off the held-out error [K]
    where: str
    ranges: dict  # driver: (from, to)
    size: float  # mean residual there [K]
    values: np.ndarray = field(repr=False)  # of each row, from other weeks [K]

    @property
    def name(self):
        return " × ".join(self.drivers)


def axes(index, dates, columns):
    """
    All ways to sort the rows.

    ``columns`` are the drivers by name; those with few values get a bin for
    each, the others bins with equal numbers of rows.
    """
    hour = np.asarray(index.hour)
    weekend = (np.asarray(dates) + 3) % 7 >= 5
    month = np.asarray(index.month) - 1
    yield Axis("hour", hour, tuple((h, h + 1) for h in range(24)))
    if len(np.unique(dates)) >= 14:
        labels = (("weekdays",) * 2, ("weekend",) * 2)
        yield Axis("weekend", weekend.astype(int), labels)
        labels = (("every second day",) * 2, ("every other day",) * 2)
        yield Axis("alternate_day", np.asarray(dates) % 2, labels)
    if len(np.unique(month)) > 1:
        yield Axis("month", month, tuple((m, m) for m in range(1, 13)))
    for name, values in columns.items():
        if (axis := sorted_by(name, values)) is not None:
            yield axis


def sorted_by(name, values):
    """Bins of one driver, or nothing where it does not vary."""
    if name == "wind_direction":
        bins = np.round(np.nan_to_num(values) / 45.0).astype(int) % len(SECTORS)
        return Axis(name, bins, tuple((s, s) for s in SECTORS))
    finite = values[np.isfinite(values)]
    if name == "poa_global":  # nights are a bin of their own
        finite = finite[finite > 1.0]
    if len(finite) == 0:
        return None
    inner = np.linspace(0.0, 1.0, BINS + 1)[1:-1]
    cuts = np.unique(np.quantile(finite[:: max(1, len(finite) // 20_000)], inner))
    if name == "poa_global":
        cuts = np.concatenate(([1.0], cuts))
    low, high = finite.min(), finite.max()
    cuts = cuts[(cuts > min(low, values.min())) & (cuts <= high)]
    if len(cuts) == 0:
        return None
    edges = [min(low, np.nanmin(values)), *cuts, high]
    labels = tuple((round_(a), round_(b)) for a, b in pairwise(edges))
    return Axis(name, np.searchsorted(cuts, values, side="right"), labels)


def round_(value):
    return float(f"{value:.3g}")


def find_structure(residual, seconds, folds, axes_, step, without=()):
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
    axes_ : sequence of Axis
    step : float
        Usual time between rows. [s]
    without : sequence of str
        Drivers that it may not use.

    Returns
    -------
    Structure or None
        None where no table gains anything.
    """
    cells = quarters(seconds, folds)
    kept = [axis for axis in axes_ if axis.name not in without]
    coarse = {axis.name: axis.bins[cells.first] for axis in kept}
    residual = residual - residual.mean()
    sums = np.add.reduceat(residual, cells.first)
    shrink = HALF_DAY / step
    fold = folds[cells.first]
    best, found = {}, {}
    for chosen in [(a,) for a in kept] + list(combinations(kept, 2)):
        bins, count = joined(chosen, coarse)
        gains, means = held_out_gain(bins, count, sums, cells.rows, fold, shrink)
        if (gains > 0).sum() < MANY * len(gains):
            continue  # an accident of some weeks
        gain = gains.sum()
        # clock and calendar come first, which other drivers only follow
        if gain > CLEARLY * best.get(len(chosen), 0.0):
            best[len(chosen)], found[len(chosen)] = gain, (chosen, means)
    if not best:
        return None
    pair = best.get(2, 0.0) > PAIR * best.get(1, 0.0)
    chosen, means = found[2 if pair else 1]
    bins, count = joined(chosen, {a.name: a.bins for a in chosen})
    values = means[folds, bins]
    size, ranges = place(chosen, residual, bins, count, shrink)
    words = [axis.range(*ranges[axis.name]) for axis in chosen]
    everywhere = f"all of {' × '.join(axis.name for axis in chosen)}"
    where = " × ".join(word for word in words if word) or everywhere
    return Structure(
        tuple(axis.name for axis in chosen),
        float(np.sqrt(best[len(chosen)])),
        where,
        {
            axis.name: (axis.labels[first][0], axis.labels[last][1])
            for axis, (first, last) in ((a, ranges[a.name]) for a in chosen)
        },
        size,
        values,
    )


@dataclass(frozen=True)
class Quarters:
    first: np.ndarray  # first row of each
    rows: np.ndarray  # number of rows in each


def quarters(seconds, folds):
    """Quarters of an hour, inside which clock, calendar and drivers are shared."""
    label = np.floor(seconds / QUARTER)
    new = np.flatnonzero((np.diff(label) != 0) | (np.diff(folds) != 0)) + 1
    first = np.concatenate(([0], new))
    return Quarters(first, np.diff(np.append(first, len(seconds))))


def joined(chosen, bins):
    """One bin for each row from one or two axes."""
    if len(chosen) == 1:
        return bins[chosen[0].name], len(chosen[0].labels)
    one, two = chosen
    wide = len(two.labels)
    return bins[one.name] * wide + bins[two.name], len(one.labels) * wide


def held_out_gain(bins, count, sums, rows, folds, shrink):
    """Fall of the mean square in each fold by means of the others, and those."""
    groups = folds.max() + 1
    place_ = folds * count + bins
    shape = (groups, count)
    held = np.bincount(place_, sums, groups * count).reshape(shape)
    size = np.bincount(place_, rows, groups * count).reshape(shape)
    others = size.sum(axis=0) - size
    means = (held.sum(axis=0) - held) / (others + shrink)
    gains = (2.0 * means * held - means**2 * size).sum(axis=1) / rows.sum()
    return gains, means


def place(chosen, residual, bins, count, shrink):
    """Mean size in the strongest cells, and their range along each axis."""
    sums = np.bincount(bins, residual, count)
    rows = np.bincount(bins, minlength=count)
    means = sums / (rows + shrink)
    strong = np.abs(means) >= STRONG * np.abs(means).max()
    squares = np.where(strong, means**2 * rows, 0.0)
    shape = [len(axis.labels) for axis in chosen]
    table = squares.reshape(shape)
    ranges = {}
    for i, axis in enumerate(chosen):
        along = table.sum(axis=tuple(j for j in range(len(shape)) if j != i))
        ranges[axis.name] = narrowest(along, axis.name in CYCLIC)
    top = strong & (np.sign(means) == np.sign(means[np.argmax(squares)]))
    return float(sums[top].sum() / max(rows[top].sum(), 1)), ranges


def narrowest(squares, cyclic):
    """Shortest run of bins that holds most of the squares, as first and last."""
    count, whole = len(squares), squares.sum()
    for length in range(1, count + 1):
        starts = range(count if cyclic else count - length + 1)
        runs = [squares.take(range(s, s + length), mode="wrap").sum() for s in starts]
        if max(runs) >= MOST * whole:
            start = int(np.argmax(runs))
            return start, (start + length - 1) % count
    return 0, count - 1
