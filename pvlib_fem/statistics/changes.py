"""
When something changed: dates from sums by the day.

What a column takes of a residual from one day to another, beside all that is fitted,
follows from sums of the days between. So every date, and every stretch, is weighed
at no further pass over the record.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr
from scipy.stats import norm

from pvlib_fem.statistics.clusters import ridge

UNSEEN = 1e-6  # of a column's square: less of it is nothing beside the others
LEVEL = 7.35  # of a likelihood ratio, 95 % of dates, Hansen (2000), table I
MOST_MEMORY = 0.9  # between weeks, beyond which a series is no series of weeks
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
    sums: np.ndarray  # days, columns + 2 twice: fitted, the column, the residual
    weeks: np.ndarray
    dates: np.ndarray  # of each day, from 1970-01-01
    sloped: float = 0.0  # what a step that fades takes of the squares, of any channel

    @classmethod
    def of(cls, sums, column, given):
        """The same of sums by the day."""
        normal = sums.whole[np.ix_(given, given)]
        root = np.linalg.inv(np.linalg.cholesky(normal + ridge(normal)))
        kept = [*given, column, -1]
        turn = np.eye(len(kept))
        turn[: len(given), : len(given)] = root
        turn[-1, : len(given)] = -sums.solve(given)
        daily = turn @ sums.sums[:, kept][:, :, kept] @ turn.T
        own, rest, fitted = daily[:, -2, -2], daily[:, -2, -1], daily[:, -2, :-2]
        return cls(own, rest, fitted, daily, sums.weeks, sums.dates)

    @property
    def days(self):
        return len(self.own)

    def before(self):
        """Sums of the days before each, and of all."""
        columns = np.column_stack([self.rest, self.own, self.fitted])
        return np.pad(columns.cumsum(axis=0), [(1, 0), (0, 0)])

    def step(self, side):
        """The best day from which on the column is there, or None."""
        total = self.before()
        gains = gained(total[-1] - total)
        gains[:side] = gains[len(gains) - side :] = 0.0
        start = int(np.argmax(gains))
        if not gains[start] > 0:
            return None
        return self.change(start, self.days, gains)

    def episode(self, shortest, side):
        """The best stretch of days in which the column is there, or None."""
        total, days = self.before(), self.days
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
        total = self.before()
        late, drift = total[-1] - total, slow @ self.fitted
        rest, known, slowly = late[:, 0], late[:, 2:], slow @ self.rest
        beside = np.append((slow * self.own)[::-1].cumsum()[::-1], 0.0)
        one = late[:, 1] - np.square(known).sum(axis=1)
        both = beside - known @ drift
        other = slow**2 @ self.own - drift @ drift
        apart = one * other - both**2
        top = rest**2 * other + slowly**2 * one - 2.0 * rest * slowly * both
        seen = apart > UNSEEN * max(np.abs(one * other).max(), np.finfo(float).tiny)
        gains = np.divide(top, apart, out=np.zeros_like(top), where=seen)
        gains[:side] = gains[len(gains) - side :] = 0.0
        return float(gains.max())

    def clearly(self, gain, found):
        """Whether a fall of the sum of squares is clearly more than a change's."""
        return gain - found.gain > LEVEL * self.spread(found.start, found.end)

    def change(self, start, end, gains):
        """The change with its certainty, and the days where it may have begun."""
        spread = self.spread(start, end)
        statistic = np.sqrt(gains[start] / spread) if spread > 0 else np.inf
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
        weights = np.array([late, slow, late * slow], dtype=float)
        known = weights @ self.fitted
        normal = (weights * self.own) @ weights.T - known @ known.T
        right = weights @ self.rest
        alone = right[0] / normal[0, 0]
        inverse = np.linalg.inv(normal + ridge(normal))
        error = np.sqrt(inverse[0, 0] * self.spread(start, self.days))
        return float(inverse[0] @ right / alone), float(error / abs(alone))

    def spread(self, start, end):
        """
        Long-run variance of the column's products for each of its squares.

        Of what the change leaves, with the memory that one week has of the one
        before: of the column within the stretch, beside the fitted, and of the column
        on all days, since a short stretch cannot vouch for itself. The larger counts.
        """
        size = self.sums.shape[1] - 2
        known = self.fitted[start:end].sum(axis=0)
        within = np.zeros(self.days)
        within[start:end] = 1.0
        left = self.own[start:end].sum() - known @ known
        change = self.rest[start:end].sum() / left
        # products of what is left with the fitted, and with the column
        fitted = self.sums[:, :size, -1] - change * (
            within[:, None] * self.fitted - self.sums[:, :size, :size] @ known
        )
        own = self.rest - change * (within * self.own - self.fitted @ known)
        inside = long_run(within * own - fitted @ known, self.weeks) / left
        return max(inside, long_run(own, self.weeks) / self.own.sum())


def long_run(scores, weeks):
    """Variance of the sum of scores by the day, whose weeks may remember."""
    scores = np.bincount(np.unique(weeks, return_inverse=True)[1], scores)
    square = scores @ scores
    memory = scores[1:] @ scores[:-1] / square if square > 0 else 0.0
    memory = min(max(memory, 0.0), MOST_MEMORY)
    return square * (1.0 + memory) / (1.0 - memory)


def gained(part):
    """Fall of the sum of squares by a column on some days, from their sums."""
    product, square, known = part[..., 0], part[..., 1], part[..., 2:]
    left = square - np.square(known).sum(axis=-1)
    seen = left > UNSEEN * np.abs(square).max()
    return np.divide(product**2, left, out=np.zeros_like(product), where=seen)


def best_pair(total, starts, ends, shortest):
    """Largest gain of all stretches between two sets of days, and its edges."""
    best = (0.0, 0, 0)
    for start in starts:
        later = ends[ends >= start + shortest]
        if len(later):
            gains = gained(total[later] - total[start])
            i = int(np.argmax(gains))
            best = max(best, (float(gains[i]), int(start), int(later[i])))
    return best


def chance_of_step(statistic, first, last):
    """
    Chance that any date looks as good where there is no step [1]_.

    Parameters
    ----------
    statistic : float
        Standard errors of the best one.
    first, last : float
        Share of the record before the first date that is tried, and the last.

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
    return float(min(1.0, b * norm.pdf(b) * ((1.0 - b**-2) * odds + 4.0 * b**-2)))


def chance_of_episode(statistic, places):
    """The same of any stretch between so many places, each by itself."""
    pairs = places * (places - 1) / 2.0
    return float(min(1.0, pairs * 2.0 * ndtr(-statistic)))
