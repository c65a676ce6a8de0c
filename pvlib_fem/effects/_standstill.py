"""
Find the days on which a tracker does not turn, and the angle at which it stands.

The planes that a tracker can have are those that a record's own orientations have: of
rotations about one axis. The response to each of some planes is known; between two of
them it is linear in the angle.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pvlib_fem._statistics.extremes import as_normal, largest
from pvlib_fem.drivers._planes import angles_of, normals

STEP = 10.0  # ° between planes that are tried; the light between is within 0.4 %
LEAST_TURN = 10.0  # ° from the first to the last angle of a plane that moves
OFF_AXIS = 0.05  # root mean square of what is not perpendicular to the axis
SIZES = (0.7, 1.3)  # shares: it stands as a whole, and the light is estimated
POSSIBLE = (0.5, 1.5)  # shares beyond which it is something else
SHORTEST = 3  # days
EVERY = 60  # days, up to which each length is tried
LONGER = 1.1  # ratio of longer lengths
LONGEST = 0.2  # of the days of a record
UNSEEN = 1e-6  # of a column's square; a smaller independent part counts as zero
NOTHING = 1.0  # twice the log-likelihood below which days at an edge show nothing
AS_GOOD = 3.84  # twice the log-likelihood by which 95 % of dates are as good
MOST_SURE = 6.0  # standard errors, beyond which a date is not surer
WEEK, FEWEST = 7, 8  # days of which others are compared, and how many of these
NEAR = 3  # days by which dates move with the angle
LEVEL = 3.0  # ° of tilt, below which a plane has no direction
COMPASS = (
    *("north", "north-east", "east", "south-east"),
    *("south", "south-west", "west", "north-west"),
)
BETWEEN = (0.1, 0.2, 0.3, 0.4, 0.5)  # of the way from a plane to the next
Day = int | np.ndarray  # number of a day among those that have rows, or of several


@dataclass(frozen=True, eq=False)
class Axis:
    """An axis, and the directions that are perpendicular to it: up, and to the side."""

    up: np.ndarray
    aside: np.ndarray

    @classmethod
    def of(cls, normal: np.ndarray) -> "Axis":
        """
        The axis about which some planes are rotations.

        Parameters
        ----------
        normal : array, shape (planes, 3)
            To north, to east and up.

        Raises
        ------
        ValueError
            If they turn about no single axis, or hardly turn.
        """
        squares, ways = np.linalg.eigh(normal.T @ normal / len(normal))
        if squares[0] > OFF_AXIS**2:
            raise ValueError(
                "the plane turns about more than one axis; a tracker that is stuck "
                "is tried of single-axis trackers"
            )
        along = ways[:, 0]
        up = np.array([0.0, 0.0, 1.0]) - along[2] * along
        if not np.linalg.norm(up) > OFF_AXIS:
            raise ValueError("the axis of the plane is vertical")
        up = up / np.linalg.norm(up)
        return cls(up, np.cross(along, up))

    def angles(self, normal: np.ndarray) -> np.ndarray:
        """Rotation of each normal about the axis, 0 where it is flattest. [°]"""
        return np.degrees(np.arctan2(normal @ self.aside, normal @ self.up))

    def planes(self, angles: np.ndarray) -> np.ndarray:
        """Tilt and azimuth of some rotations, a row each. [°]"""
        turn = np.radians(angles)[:, None]
        normal = np.cos(turn) * self.up + np.sin(turn) * self.aside
        return np.column_stack(angles_of(*normal.T))


def in_words(tilt: float, azimuth: float) -> str:
    """
    Orientation of a plane in words: ``"at about 35° east"``, or ``"level"``.

    Parameters
    ----------
    tilt, azimuth : float
        Azimuth clockwise from north. [°]

    Returns
    -------
    str
    """
    if tilt < LEVEL:
        return "level"
    return f"at about {tilt:.0f}° {COMPASS[round(azimuth / 45.0) % 8]}"


def rotations(tilt: np.ndarray, azimuth: np.ndarray) -> tuple[Axis, np.ndarray]:
    """
    Axis of a plane that moves, and the angles at which it may stand.

    Parameters
    ----------
    tilt, azimuth : array, shape (rows,)
        Angles of the plane; NaN where they are unknown. [°]

    Returns
    -------
    axis : Axis
    angles : array
        Rotations about it, from the first to the last. [°]

    Raises
    ------
    ValueError
        If it is fixed, or turns about no single axis.
    """
    there = np.isfinite(tilt + azimuth)
    if not there.any():
        raise ValueError("the angles of the plane are not known")
    normal = normals(tilt[there], azimuth[there]).T
    axis = Axis.of(normal)
    angles = axis.angles(normal)
    low, high = angles.min(), angles.max()
    if not high - low > LEAST_TURN:
        raise ValueError("the plane is fixed, so that no tracker is stuck")
    return axis, np.linspace(low, high, 1 + int(np.ceil((high - low) / STEP)))


@dataclass(frozen=True, eq=False)
class Days:
    """Daily sums of products with the residual and the coefficients of a fit."""

    rest: np.ndarray
    basis: np.ndarray  # rows by orthonormal columns
    first: np.ndarray  # row of each day
    dates: np.ndarray

    @classmethod
    def of(cls, rest: np.ndarray, basis: np.ndarray, day: np.ndarray) -> "Days":
        dates = np.floor(day).astype(int)
        first = np.flatnonzero(np.diff(dates, prepend=dates[:1] - 1))
        return cls(rest, basis, first, dates[first])

    @property
    def lengths(self) -> np.ndarray:
        """Numbers of days that are tried."""
        most = int(LONGEST * len(self.dates))
        count = max(int(np.log(max(most / EVERY, 1.0)) / np.log(LONGER)), 0)
        longer = EVERY * LONGER ** np.arange(1, count + 1)
        every = np.arange(SHORTEST, min(EVERY, most) + 1)
        return np.unique(np.append(every, longer.astype(int)))

    def sums(self, tangent: np.ndarray) -> np.ndarray:
        """Sums of products of a tangent with all, before each day: columns + 2 rows."""
        products = [tangent * self.rest, tangent**2, *(self.basis.T * tangent)]
        daily = np.add.reduceat(np.array(products), self.first, axis=1)
        return np.pad(daily, [(0, 0), (1, 0)]).cumsum(axis=1)

    def beyond(
        self, total: np.ndarray, first: Day, last: Day
    ) -> tuple[np.ndarray, np.ndarray]:
        """Products with residual and itself between two days, given the fit."""
        score, square, *known = total[:, last] - total[:, first]
        remainder = square - np.sum(np.square(known), axis=0)
        independent = remainder > UNSEEN * np.maximum(square, 1e-12)
        return score, np.where(independent, remainder, 0.0)

    def falls(
        self, total: np.ndarray, first: Day, last: Day
    ) -> tuple[np.ndarray, np.ndarray]:
        """Fall of the sum of squares by a standstill between two days, and its size."""
        score, square = self.beyond(total, first, last)
        size = np.divide(score, square, out=np.zeros_like(score), where=square > 0.0)
        likely = np.clip(size, *SIZES)
        falls = 2.0 * likely * score - likely**2 * square
        return np.where((size > POSSIBLE[0]) & (size < POSSIBLE[1]), falls, 0.0), size

    def best(self, total: np.ndarray, lengths: np.ndarray) -> tuple[float, int, int]:
        """The best standstill of some lengths: its fall, first day, first day after."""
        best = (0.0, 0, 0)
        for length in lengths.tolist():
            first = np.arange(len(self.dates) - length + 1)
            falls, _ = self.falls(total, first, first + length)
            at = largest(falls)
            if falls[at] > best[0]:
                best = float(falls[at]), at, at + length
        return best

    def errors(self, total: np.ndarray, first: int, last: int) -> float:
        """
        Size in standard errors, from the size of the same plane on other days.

        The errors are of weeks, with the correlation of successive ones.
        """
        length = min(last - first, WEEK)
        before = np.arange(first - length, -1, -length)[::-1]
        others = np.append(before, np.arange(last, len(self.dates) - length, length))
        score, square = self.beyond(total, others, others + length)
        _, size = self.falls(total, first, last)
        known = (
            total[2:, ends] - total[2:, begins]
            for begins, ends in ((others, others + length), (first, last))
        )
        # without what the coefficients have taken of the standstill
        each, own = known
        score = score + size * (own @ each)
        chance = score / np.sqrt(np.maximum(square, 1e-300))
        if len(others) < FEWEST or not chance.any():
            return 0.0
        memory = max(float(np.corrcoef(chance[1:], chance[:-1])[0, 1]), 0.0)
        wider = (1.0 + memory) / max(1.0 - memory, 1e-3)
        score, square = self.beyond(total, first, last)
        noise = np.sqrt(max(float(square), 1e-300) * wider * np.mean(chance**2))
        return as_normal(score / noise, max(len(others) / wider, 1.0))

    def edges(
        self, total: np.ndarray, first: int, last: int, errors: float
    ) -> tuple[int, int, tuple[int, int], tuple[int, int]]:
        """
        The first day, the first day after it, and the intervals of both.

        Days at an edge that show nothing, as dull ones, are not in it: beyond them may
        be days without rows, as those of test weeks, of which nothing is known.
        """
        begins, ends = np.arange(last), np.arange(first + 1, len(self.dates) + 1)
        falls, _ = self.falls(total, begins, np.full(len(begins), last))
        shortfall = 1.0 - falls / falls.max()
        start = int(self.dates[begins[shortfall * errors**2 <= NOTHING][-1]])
        good = begins[shortfall * min(errors, MOST_SURE) ** 2 <= AS_GOOD]
        before = self.dates[good[0] - 1] + 1 if good[0] else self.dates[0]
        began = int(before), int(self.dates[good[-1]])
        falls, _ = self.falls(total, np.full(len(ends), first), ends)
        shortfall = 1.0 - falls / falls.max()
        end = int(self.dates[ends[shortfall * errors**2 <= NOTHING][0] - 1]) + 1
        good = ends[shortfall * min(errors, MOST_SURE) ** 2 <= AS_GOOD]
        after = np.append(self.dates, self.dates[-1] + 1)[good[-1]]
        ended = int(self.dates[good[0] - 1]) + 1, int(after)
        return start, max(end, start + 1), began, ended


def find_standstill(
    rest: np.ndarray,
    tangents: Sequence[np.ndarray],
    angles: np.ndarray,
    basis: np.ndarray,
    day: np.ndarray,
    least: float,
) -> tuple[float, int, int, tuple[int, int], tuple[int, int]] | None:
    """
    The days on which a tracker stands, and the angle.

    Parameters
    ----------
    rest : array, shape (rows,)
        Residual of a fit. [K]
    tangents : sequence of array, shape (rows,)
        Responses of the temperature to a tracker that stands at each of the angles.
        [K]
    angles : array, shape (len(tangents),)
        [°]
    basis : array, shape (rows, columns)
        Orthonormal, of the tangents of all fitted coefficients.
    day : array, shape (rows,)
        Of each row, from 1970-01-01.
    least : float
        Least gain. [K]

    Returns
    -------
    tuple or None
        Angle [°], first day, first day after it, and the days between which it began
        and ended.
    """
    days = Days.of(rest, basis, day)
    lengths = days.lengths
    if not len(lengths):
        return None
    each = [days.best(days.sums(tangent), lengths) for tangent in tangents]
    at = largest([fall for fall, *_ in each])
    fall, first, last = each[at]
    if not fall > len(rest) * least**2:
        return None
    best = fall, angles[at], tangents[at], first, last
    near = np.arange(max(SHORTEST, last - first - NEAR), last - first + NEAR + 1)
    for other in (at - 1, at + 1):
        if not 0 <= other < len(angles):
            continue
        for share in BETWEEN:
            tangent = tangents[at] + share * (tangents[other] - tangents[at])
            fall, first, last = days.best(days.sums(tangent), near)
            if fall > best[0]:
                angle = angles[at] + share * (angles[other] - angles[at])
                best = fall, angle, tangent, first, last
    _, angle, tangent, first, last = best
    total = days.sums(tangent)
    errors = days.errors(total, first, last)
    # largest of so many standard normal values by chance
    tried = len(days.dates) * len(lengths) * len(angles)
    if errors < np.sqrt(2.0 * np.log(tried)):
        return None
    start, end, *intervals = days.edges(total, first, last, errors)
    # days that show nothing are no evidence of a length that is tried
    if end - start < SHORTEST:
        return None
    began, ended = intervals
    return float(angle), start, end, began, ended
