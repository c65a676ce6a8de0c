"""
Find the days on which a tracker does not turn, and the angle at which it stands.

The planes that a tracker can have are those that a record's own orientations have: of
rotations about one axis. The response to each of some planes is known; between two of
them it is linear in the angle.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pvlib_fem._statistics.extremes import rounded_argmax
from pvlib_fem.drivers._planes import angles_of, normals
from pvlib_fem.effects._standstill_days import SHORTEST, Days, square_reductions

STEP = 10.0  # ° between planes that are tried; the light between is within 0.4 %
LEAST_TURN = 10.0  # ° from the first to the last angle of a plane that moves
OFF_AXIS = 0.05  # root mean square of what is not perpendicular to the axis
NEAR = 3  # days by which dates move with the angle
LEVEL = 3.0  # ° of tilt, below which a plane has no direction
COMPASS = (
    *("north", "north-east", "east", "south-east"),
    *("south", "south-west", "west", "north-west"),
)
BETWEEN = (0.1, 0.2, 0.3, 0.4, 0.5)  # of the way from a plane to the next


@dataclass(frozen=True, eq=False)
class Axis:
    """An axis, and the directions that are perpendicular to it: up, and to the side."""

    up: np.ndarray
    aside: np.ndarray

    @classmethod
    def from_normals(cls, normal: np.ndarray) -> "Axis":
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
    axis = Axis.from_normals(normal)
    angles = axis.angles(normal)
    low, high = angles.min(), angles.max()
    if not high - low > LEAST_TURN:
        raise ValueError("the plane is fixed, so that no tracker is stuck")
    return axis, np.linspace(low, high, 1 + int(np.ceil((high - low) / STEP)))


def find_standstill(
    rest: np.ndarray,
    tangents: Sequence[np.ndarray],
    even: np.ndarray,
    angles: np.ndarray,
    basis: np.ndarray,
    day: np.ndarray,
    least: float,
) -> tuple[float, int, int, tuple[int, int], tuple[int, int]] | None:
    """
    The days on which a tracker stands, and the angle.

    A standstill changes light by its direction. It is found by what it explains given
    an even loss of light on the same days, as by snow that an effect has not described.

    Parameters
    ----------
    rest : array, shape (rows,)
        Residual of a fit. [K]
    tangents : sequence of array, shape (rows,)
        Responses of the temperature to a tracker that stands at each of the angles.
        [K]
    even : array, shape (rows,)
        Response of the temperature to light that is lost evenly. [K]
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
    days = Days.from_rows(rest, even, basis, day)
    lengths = days.lengths
    if not len(lengths):
        return None
    each = [days.best(days.sums(tangent), lengths) for tangent in tangents]
    at = rounded_argmax([fall for fall, *_ in each])
    fall, first, last = each[at]
    if not fall > 0.0:
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
    gained, _ = square_reductions(*total.between(first, last).plain)
    if not gained > len(rest) * least**2:
        return None
    # largest of so many standard normal values by chance
    tried = len(days.dates) * len(lengths) * len(angles)
    if days.errors(total, first, last, "directed") < np.sqrt(2.0 * np.log(tried)):
        return None
    errors = days.errors(total, first, last, "plain")
    start, end, *intervals = days.edges(total, first, last, errors)
    # days that show nothing are no evidence of a length that is tried
    if end - start < SHORTEST:
        return None
    began, ended = intervals
    return float(angle), start, end, began, ended
