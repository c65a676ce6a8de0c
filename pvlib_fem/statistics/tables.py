"""
Tables of the remaining error as random effects: what is unexplained but repeatable.

Each cell of a table, such as an hour of a month, has a mean of its own. Its variance
is estimated by the products of what different weeks have in the same cell, so that
what weeks do not share has no part in it.
"""

from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations

import numpy as np

PAIR_GAIN = 1.2  # times the variance of one axis, that a table of two has to have
SURE = 3.0  # standard errors that a variance has to be from nothing
STRONG_CELL = 0.5  # of the largest mean, from which a cell is part of the place
PLACE_SHARE = 0.92  # of those cells' squares, that the reported range holds


@dataclass(frozen=True, eq=False)
class Table:
    """
    A random effect of the remaining error.

    Attributes
    ----------
    axes : tuple of Axis
        One, or two.
    groups : array of int
        Cell of the table of each value.
    variance : float
        Between the cells of the table. [K²]
    errors : float
        By how many standard errors that differs from nothing.
    means, shares, rows : array
        Of each cell: mean [K], share of it that is its own and not noise, and number
        of rows.
    """

    axes: tuple
    groups: np.ndarray = field(repr=False)
    variance: float
    errors: float
    means: np.ndarray = field(repr=False)
    shares: np.ndarray = field(repr=False)
    rows: np.ndarray = field(repr=False)

    @classmethod
    def of(cls, axes, rest, rows, weeks):
        """
        The table of some axes.

        Parameters
        ----------
        axes : tuple of Axis
        rest : array
            Remaining error, in order of time. [K]
        rows : array
            Number of rows of which each value is the mean.
        weeks : array of int
            Week of each value, from 0 on.

        References
        ----------
        .. [1] S. R. Searle, G. Casella and C. E. McCulloch, "Variance Components",
           Wiley, 1992, chapter 3. :doi:`10.1002/9780470316856`
        """
        groups, count = joined(axes)
        rest = rest - rest @ rows / rows.sum()
        place, size = weeks * count + groups, (weeks[-1] + 1) * count
        sums = np.bincount(place, rest * rows, size).reshape(-1, count)
        held = np.bincount(place, rows, size).reshape(-1, count)
        whole, number = sums.sum(axis=0), held.sum(axis=0)
        # of each cell the mean product of two weeks, by its part of all rows
        alike = number**2 - np.square(held).sum(axis=0)
        weight = number / number.sum() / np.where(alike > 0, alike, np.inf)
        shared = (sums * weight) @ sums.T
        crossed = shared.sum() - np.trace(shared)
        spread = np.square(shared).sum() - np.square(np.diag(shared)).sum()
        variance = max(crossed, 0.0)
        errors = crossed / np.sqrt(2.0 * spread) if spread > 0 else 0.0
        noise = np.square(sums).sum() - variance * np.square(held).sum()
        noise = max(noise / number.sum(), 1e-12)
        shares = variance * number / (variance * number + noise)
        means = whole / np.maximum(number, 1.0)
        return cls(
            tuple(axes), groups, float(variance), float(errors), means, shares, number
        )

    @property
    def values(self):
        """Best linear prediction of each value. [K]"""
        return (self.shares * self.means)[self.groups]

    @property
    def free(self):
        """Share of the mean of each cell that whitening takes away."""
        return 1.0 - np.sqrt(1.0 - self.shares)

    @property
    def gain(self):
        """What it would take off the error. [K]"""
        return float(np.sqrt(self.variance))

    @cached_property
    def top(self):
        """Cells of the strongest sign."""
        means, rows = self.shares * self.means, self.rows
        strong = np.abs(means) >= STRONG_CELL * np.abs(means).max()
        squares = np.where(strong, means**2 * rows, 0.0)
        return strong & ((means > 0) == (squares @ np.sign(means) >= 0))

    @property
    def size(self):
        """Mean remaining error where it is strongest. [K]"""
        top = self.rows * self.top
        return float(top @ self.means / max(top.sum(), 1.0))

    @cached_property
    def places(self):
        """Place of the strongest cells along each axis."""
        # what happens part of the time leaves some of the other sign elsewhere
        means = self.shares * self.means
        squares = np.where(self.top, means**2 * self.rows, 0.0)
        shape, found = [len(axis.labels) for axis in self.axes], []
        for i, axis in enumerate(self.axes):
            other = tuple(j for j in range(len(shape)) if j != i)
            both = squares, self.rows
            along, size = (t.reshape(shape).sum(axis=other) for t in both)
            found.append(axis.place(axis.strongest(along, PLACE_SHARE), size))
        return tuple(found)

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


def joined(axes):
    """One number for each value's cell of one or two axes, and how many there are."""
    if len(axes) == 1:
        return axes[0].bins, len(axes[0].labels)
    one, two = axes
    wide = len(two.labels)
    return one.bins * wide + two.bins, len(one.labels) * wide


def ways(axes):
    """Each axis, and each two that are not of a kind."""
    pairs = combinations(axes, 2)
    return [*((one,) for one in axes), *(p for p in pairs if p[0].name != p[1].name)]


def largest(kinds, rest, rows, weeks, least):
    """
    The table with the largest variance that is sure and material, or None.

    One of two axes has to have more than one of one, since it has it by itself.
    """
    best = {}
    for axes in kinds:
        found = Table.of(axes, rest, rows, weeks)
        if found.errors >= SURE and found.variance >= least:
            size = len(axes)
            if size not in best or found.variance > best[size].variance:
                best[size] = found
    one, two = best.get(1), best.get(2)
    if one is None or two is None:
        return one or two
    return two if two.variance > PAIR_GAIN * one.variance else one
