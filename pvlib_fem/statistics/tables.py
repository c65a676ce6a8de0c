"""Where a residual lives: tables of its mean over clock, calendar and drivers."""

from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

DAY = 86400.0  # s


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
    top = strong & ((means > 0) == (squares @ np.sign(means) >= 0))
    # what happens part of the time leaves some of the other sign elsewhere
    squares = np.where(top, squares, 0.0)
    shape = [len(axis.labels) for axis in chosen]
    places = []
    for i, axis in enumerate(chosen):
        other = tuple(j for j in range(len(shape)) if j != i)
        along, size = (t.reshape(shape).sum(axis=other) for t in (squares, rows))
        places.append(axis.place(axis.strongest(along, criteria.place_share), size))
    return tuple(places), float(sums[top].sum() / max(rows[top].sum(), 1))
