"""
When something changed: dates from sums by the day.

What a column takes of a residual from one day to another, beside all that is fitted,
follows from sums of the days between. So every date, and every stretch, is weighed
at no further pass over the record.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import ndtr, ndtri, stdtr

from pvlib_fem.statistics.clusters import ridge, those

UNSEEN = 1e-6  # of a column's square: less of it is nothing beside the others
LEVEL = 7.35  # of a likelihood ratio, 95 % of dates, Hansen (2000), table I
MOST_MEMORY = 0.9  # between weeks, beyond which a series is no series of weeks
ALIKE = 1e-9  # of a gain, by which no other is larger
GRID = 300  # stretches of days between which an episode is first looked for


@dataclass(frozen=True)
class Change:
    """Days from which on, and until which, a column is in a residual."""

    start: int  # first day, of those that are there
    end: int  # the day after its last, or the number of days
    gain: float  # fall of the sum of squares
    statistic: float  # standard errors, of the memory between weeks
    low: int  # the day from which on the first day may be, and until
    high: int


@dataclass(frozen=True, eq=False)
class Daily:
    """
    Products by the day of a column, of what is left, and of all that is fitted.

    The residual is what all that is fitted leaves; that is orthonormal.
    """

    own: np.ndarray  # days
    rest: np.ndarray  # days
    fitted: np.ndarray  # days, columns
    left: np.ndarray  # days, columns: of what is left and each of the fitted
    left_own: np.ndarray  # days: of what is left by itself
    products: np.ndarray  # days, columns + 2 twice: before they were made orthonormal
    turn: np.ndarray  # which makes them so
    weeks: np.ndarray
    dates: np.ndarray  # of each day, from 1970-01-01
    sloped: float = 0.0  # what a step that fades takes of the squares, of any channel
    taken: float | None = None  # of the squares by a drift, if one is among the fitted

    @classmethod
    def of(cls, sums, column, given):
        """The same of sums by the day, of which one left by much is not to rule."""
        both = sums.reweighted([*given, column], known=len(given))
        return cls.turned(both.sums, sums.weeks, sums.dates)

    @classmethod
    def turned(cls, products, weeks, dates):
        """The same of products by the day: of all that is fitted, then of both."""
        size = products.shape[1] - 2
        whole = products.sum(axis=0)
        normal = whole[:size, :size] + ridge(whole[:size, :size])
        turn = np.eye(size + 2)
        turn[:size, :size] = np.linalg.inv(np.linalg.cholesky(normal))
        turn[-1, :size] = -np.linalg.solve(normal, whole[:size, -1])
        # of what is fitted and itself a few products are asked for, and by all columns
        mine, left = products[:, -2] @ turn.T, products @ turn[-1] @ turn.T
        own, rest, fitted = mine[:, -2], mine[:, -1], mine[:, :-2]
        two = left[:, :-2], left[:, -1]
        return cls(own, rest, fitted, *two, products, turn, weeks, dates)

    def of_fitted(self, sizes):
        """Products by the day of each of the fitted with so much of all of them."""
        turn = self.turn[: len(sizes)]
        return self.products @ (sizes @ turn) @ turn.T

    def beside_drift(self):
        """The same with a drift of the column among all that is fitted."""
        size = self.fitted.shape[1]
        both = [*range(size), size, size, size + 1]
        times = np.ones((self.days, len(both)))
        times[:, size] = self.dates - self.dates[0]
        times[:, size] /= max(np.ptp(self.dates), 1)
        products = those(self.products, both)
        products *= times[:, None]
        products *= times[:, :, None]
        found = self.turned(products, self.weeks, self.dates)
        return replace(found, taken=self.squares - found.squares)

    @property
    def days(self):
        return len(self.own)

    @cached_property
    def places(self):
        """Place of each day's week among those that are there."""
        return np.unique(self.weeks, return_inverse=True)[1]

    @property
    def drifts(self):
        """Whether a drift of the column is among the fitted."""
        return self.taken is not None

    @property
    def squares(self):
        """Sum of squares of what is left."""
        return float(self.left_own.sum())

    @cached_property
    def before(self):
        """Sums of the days before each, and of all."""
        columns = np.column_stack([self.rest, self.own, self.fitted])
        return np.pad(columns.cumsum(axis=0), [(1, 0), (0, 0)])

    def step(self, side):
        """The best day from which on the column is there, or None."""
        total = self.before
        gains = gained(total[-1] - total)
        gains[:side] = gains[len(gains) - side :] = 0.0
        start = int(np.argmax(gains))
        if not gains[start] > 0:
            return None
        return self.change(start, self.days, gains)

    def episode(self, shortest, side):
        """The best stretch of days in which the column is there, or None."""
        total, days = self.before, self.days
        if days < shortest + 2 * side:
            return None
        grid = np.unique(np.linspace(side, days - side, GRID + 1).astype(int))
        gain, start, end = best_pair(total, grid, grid, shortest)
        if not gain > 0:
            return None
        coarse = int(np.ceil(days / GRID))
        for _ in range(2):
            near = [
                np.arange(max(side, edge - coarse), min(days - side, edge + coarse) + 1)
                for edge in (start, end)
            ]
            gain, start, end = best_pair(total, *near, shortest)
        starts = np.arange(side, end - shortest + 1)
        gains = np.zeros(days + 1)
        gains[starts] = gained(total[end] - total[starts])
        return self.change(start, end, gains)

    def step_that_fades(self, side):
        """Largest fall of the sum of squares by a step and a drift of the column."""
        slow = (self.dates - self.dates[0]) / max(np.ptp(self.dates), 1)
        total = self.before
        late, drift = total[-1] - total, slow @ self.fitted
        rest, known, slowly = late[:, 0], late[:, 2:], slow @ self.rest
        beside = np.append((slow * self.own)[::-1].cumsum()[::-1], 0.0)
        one = late[:, 1] - np.square(known).sum(axis=1)
        both = beside - known @ drift
        other = slow**2 @ self.own - drift @ drift
        least = UNSEEN * max(np.abs(one * other).max(), np.finfo(float).tiny)
        gains = gained_by_two((rest, slowly), (one, other), both, least)
        gains[:side] = gains[len(gains) - side :] = 0.0
        return float(gains.max())

    def clearly(self, gain, found):
        """Whether a fall of the sum of squares is clearly more than a change's."""
        return gain - found.gain > LEVEL * self.spread(found.start, found.end)[0]

    def change(self, start, end, gains):
        """The change with its certainty, and the days where it may have begun."""
        spread, draws = self.spread(start, end)
        statistic = np.sqrt(gains[start] / spread) if spread > 0 else np.inf
        if self.drifts:  # of few weeks more is asked of what is looked for last
            statistic = as_normal(statistic, draws)
        near = np.flatnonzero(gains > gains[start] - LEVEL * spread)
        near = near[near < end] if end < self.days else near
        return Change(
            start, end, float(gains[start]), float(statistic), near[0], near[-1]
        )

    def sharpness(self, start):
        """
        Share of a step's size that is there at its date, and its standard error.

        Beside what changes slowly on either side of it: of a step all, and of what
        grows slowly nothing.
        """
        late = np.arange(self.days) >= start
        slow = (self.dates - self.dates[start]).astype(float)
        weights = [late, late * slow] if self.drifts else [late, slow, late * slow]
        weights = np.array(weights, dtype=float)
        known = weights @ self.fitted
        normal = (weights * self.own) @ weights.T - known @ known.T
        right = weights @ self.rest
        alone = right[0] / normal[0, 0]
        inverse = np.linalg.inv(normal + ridge(normal))
        error = np.sqrt(inverse[0, 0] * self.spread(start, self.days)[0])
        return float(inverse[0] @ right / alone), float(error / abs(alone))

    def spread(self, start, end):
        """
        Long-run variance of the column's products for each of its squares, and draws.

        Of what the change leaves, with the memory that one week has of the one
        before: of the column within the stretch, beside the fitted, and of the column
        on all days, since a short stretch cannot vouch for itself. The larger counts.
        """
        known = self.fitted[start:end].sum(axis=0)
        within = np.zeros(self.days)
        within[start:end] = 1.0
        left = self.own[start:end].sum() - known @ known
        change = self.rest[start:end].sum() / left
        # products of what is left with the fitted, and with the column
        fitted = self.left - change * (
            within[:, None] * self.fitted - self.of_fitted(known)
        )
        own = self.rest - change * (within * self.own - self.fitted @ known)
        inside = long_run(within * own - fitted @ known, self.places)[0] / left
        whole, draws = long_run(own, self.places)
        return max(inside, whole / self.own.sum()), draws


def long_run(scores, places):
    """
    Variance of the sum of scores by the day, whose weeks may remember, and its draws.

    ``places`` are those of the weeks. As many weeks that remember nothing would tell
    it as well.
    """
    scores = np.bincount(places, scores)
    square = scores @ scores
    memory = scores[1:] @ scores[:-1] / square if square > 0 else 0.0
    memory = min(max(memory, 0.0), MOST_MEMORY)
    longer = (1.0 + memory) / (1.0 - memory)
    return square * longer, max(len(scores) / longer, 1.0)


def as_normal(statistic, draws):
    """Standard errors of the normal law with the chance of Student's by few draws."""
    return float(-ndtri(stdtr(draws, -statistic)))


def gained(part):
    """Fall of the sum of squares by a column on some days, from their sums."""
    product, square, known = part[..., 0], part[..., 1], part[..., 2:]
    return fall(product, square, np.square(known).sum(axis=-1))


def fall(product, square, known):
    """The same from products, squares, and what all that is fitted has of these."""
    left = square - known
    seen = left > UNSEEN * np.abs(square).max()
    return np.divide(product**2, left, out=np.zeros_like(product), where=seen)


def gained_by_two(products, squares, both, least):
    """
    Fall of the sum of squares by two columns together.

    From the product of each with the residual, its square, and their product; 0 where
    the two are alike but for ``least`` of the product of their squares.
    """
    (first, second), (one, other) = products, squares
    apart = one * other - both**2
    top = first**2 * other + second**2 * one - 2.0 * first * second * both
    return np.divide(top, apart, out=np.zeros_like(top), where=apart > least)


def best_pair(total, starts, ends, shortest):
    """Largest gain of all stretches between two sets of days, and its edges."""
    first, last = total[starts], total[ends]
    product, square = (last[:, i] - first[:, i][:, None] for i in (0, 1))
    # the square of a difference, from the products of its ends
    one, other = first[:, 2:], last[:, 2:]
    squares = np.square(one).sum(axis=1)[:, None] + np.square(other).sum(axis=1)
    gains = fall(product, square, squares - 2.0 * one @ other.T)
    gains[ends < starts[:, None] + shortest] = 0.0
    row, place = np.unravel_index(largest(gains), gains.shape)
    return float(gains[row, place]), int(starts[row]), int(ends[place])


def largest(gains):
    """
    Place of the first gain that is as large as any but for rounding.

    Where nothing was to be seen an edge may stand anywhere, and the last bits of a sum
    are not to say where.
    """
    gains = np.ravel(gains)
    most = gains.max()
    return int(np.argmax(gains >= most - ALIKE * abs(most)))


def chance_of_step(statistic, first, last, drifts=False):
    """
    Chance that any date looks as good where there is no step [1]_.

    Beside a drift two dates have less in common: of a bridge that is free of its slope
    the variance at ``t`` is 1 - 3 t (1 - t) of the bridge's, which goes into the rate.

    Parameters
    ----------
    statistic : float
        Standard errors of the best one.
    first, last : float
        Share of the record before the first date that is tried, and the last.
    drifts : bool
        Whether a drift is fitted beside it.

    References
    ----------
    .. [1] B. James, K. L. James and D. Siegmund, "Tests for a change-point",
       Biometrika 74, 71-83, 1987: the largest of a standardised Brownian bridge.
       :doi:`10.1093/biomet/74.1.71`
    """
    b = min(statistic, 35.0)
    if b < 1.0:
        return 1.0
    odds = np.log(last * (1.0 - first) / (first * (1.0 - last)))
    if drifts:  # the integral of 3 / (1 - 3 t (1 - t)) from the first to the last
        ends = np.arctan(2.0 * np.sqrt(3.0) * (np.array([first, last]) - 0.5))
        odds += 2.0 * np.sqrt(3.0) * np.diff(ends)[0]
    density = np.exp(-0.5 * b**2) / np.sqrt(2.0 * np.pi)
    return float(min(1.0, b * density * ((1.0 - b**-2) * odds + 4.0 * b**-2)))


def chance_of_episode(statistic, places):
    """The same of any stretch between so many places, each by itself."""
    pairs = places * (places - 1) / 2.0
    return float(min(1.0, pairs * 2.0 * ndtr(-statistic)))
