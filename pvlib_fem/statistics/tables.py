"""Where a residual lives: tables of its mean over clock, calendar and drivers."""

from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

CELL_TIME = 900.0  # s, over which rows share a cell
CELL_WEIGHT = 43200.0  # s of rows, by which a cell's mean is shrunk towards zero
FOLD_SHARE = 0.8  # of the groups of weeks in which a table has to gain
BETTER_GAIN = 1.02  # times an earlier table's, that a later one has to take
PAIR_GAIN = 1.2  # times that of one driver, that a table of two has to take
STRONG_CELL = 0.5  # of the largest mean, from which a cell is part of the place
PLACE_SHARE = 0.92  # of those cells' squares, that the reported range holds


@dataclass(frozen=True, eq=False)
class Structure:
    """A table of the residual's mean that holds on weeks it was not made of."""

    places: tuple  # one for each axis
    gain: float  # what it takes off the held-out error [K]
    size: float  # mean residual there [K]
    values: np.ndarray = field(repr=False)  # of each row, from other weeks [K]
    bins: np.ndarray = field(repr=False)  # cell of each row

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
        return " ".join(words) or f"spread over {' and '.join(self.drivers)}"


def find_structure(residual, seconds, folds, axes, step, without=()):
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
        Of :func:`axes`.
    step : float
        Usual time between rows. [s]
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
    residual = residual - residual.mean()
    series = (residual, seconds, folds)
    cells = gathered(kept, *series)
    shrink = CELL_WEIGHT / step
    best, found = {}, {}
    for chosen in ways(kept):
        bins, count = joined([cells.axes[i] for i in chosen])
        gains, means = held_out_gain(bins, count, *cells.rest, shrink)
        if (gains > 0).sum() < FOLD_SHARE * len(gains):
            continue  # an accident of some weeks
        gain = gains.sum()
        if gain > BETTER_GAIN * best.get(len(chosen), 0.0):
            best[len(chosen)], found[len(chosen)] = gain, (chosen, means)
    if not best:
        return None
    pair = best.get(2, 0.0) > PAIR_GAIN * best.get(1, 0.0)
    chosen, means = found[2 if pair else 1]
    chosen = [kept[i] for i in chosen]
    bins, count = joined(chosen)
    places, size = placed(chosen, residual, bins, count, shrink)
    gain = float(np.sqrt(best[len(chosen)]))
    return Structure(places, gain, size, means[folds, bins], bins)


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


def gathered(axes, residual, seconds, folds):
    """Cells of rows that are close in time."""
    marks = [np.floor(seconds / CELL_TIME), folds]
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


def placed(chosen, residual, bins, count, shrink):
    """Place of the strongest cells along each axis, and the mean residual there."""
    sums = np.bincount(bins, residual, count)
    rows = np.bincount(bins, minlength=count)
    means = sums / (rows + shrink)
    strong = np.abs(means) >= STRONG_CELL * np.abs(means).max()
    squares = np.where(strong, means**2 * rows, 0.0)
    top = strong & ((means > 0) == (squares @ np.sign(means) >= 0))
    # what happens part of the time leaves some of the other sign elsewhere
    squares = np.where(top, squares, 0.0)
    shape = [len(axis.labels) for axis in chosen]
    places = []
    for i, axis in enumerate(chosen):
        other = tuple(j for j in range(len(shape)) if j != i)
        along, size = (t.reshape(shape).sum(axis=other) for t in (squares, rows))
        places.append(axis.place(axis.strongest(along, PLACE_SHARE), size))
    return tuple(places), float(sums[top].sum() / max(rows[top].sum(), 1))
