"""
Find the days on which a tracker does not turn, and the angle at which it stands.

The planes that a tracker can have are those that a record's own orientations have: of
rotations about one axis. The response to each of some planes is known; between two of
them it is linear in the angle.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pvlib_fem._statistics.extremes import rounded_argmax
from pvlib_fem.drivers._planes import angles_of, normals
from pvlib_fem.effects._standstill_days import SHORTEST, Days, without_covers

STEP = 10.0  # ° between planes that are tried; the light between is within 0.4 %
LEAST_TURN = 10.0  # ° from the first to the last angle of a plane that moves
OFF_AXIS = 0.05  # root mean square of what is not perpendicular to the axis
LEVEL = 3.0  # ° of tilt, below which a plane has no direction
COMPASS = (
    *("north", "north-east", "east", "south-east"),
    *("south", "south-west", "west", "north-west"),
)
BETWEEN = 10  # steps from a plane to the next


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
    a cover on each day, as by snow that an effect has not described: light that is lost
    evenly until an hour of the day, and from it on.

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
        Least gain on its days. [K]

    Returns
    -------
    tuple or None
        Angle [°], first day, first day after it, and the days between which it began
        and ended.
    """
    days = Days.from_rows(rest, basis, day)
    lengths = days.lengths
    if not len(lengths):
        return None
    covers = days.covers(even)
    directed = [without_covers(tangent, even, covers) for tangent in tangents]
    parts = [days.sums(*both) for both in zip(tangents, directed)]
    each = [days.best(part, lengths) for part in parts]
    at = rounded_argmax([fall for fall, *_ in each])
    fall, first, last = each[at]
    if not fall > 0.0:
        return None
    # if they stand on these days, all of the light says at which angle
    places = at + np.linspace(-1.0, 1.0, 1 + 2 * BETWEEN)
    places = places[(places >= 0.0) & (places <= len(angles) - 1.0)]
    totals = [days.sums(at_place(tangents, place)) for place in places]
    falls = [float(total.reductions(first, last)) for total in totals]
    best = rounded_argmax(falls)
    total, place = totals[best], places[best]
    part = days.sums(*(at_place(each, place) for each in (tangents, directed)))
    begins = np.append(days.first, len(rest))  # row of each day, and of none after
    material = float(begins[last] - begins[first]) * least**2
    if not (falls[best] > material and part.reductions(first, last) > 0.0):
        return None
    # largest of so many standard normal values by chance
    tried = len(days.dates) * len(lengths) * len(angles)
    if days.errors(part, first, last) < np.sqrt(2.0 * np.log(tried)):
        return None
    errors = days.errors(total, first, last)
    start, end, *intervals = days.edges(total, first, last, errors)
    # days that show nothing are no evidence of a length that is tried
    if np.sum((days.dates >= start) & (days.dates < end)) < SHORTEST:
        return None
    began, ended = intervals
    return float(at_place(angles, place)), start, end, began, ended


def at_place(values: Any, place: float) -> Any:
    """The value at a place in a sequence, linear between two of its values."""
    low = int(place)
    share = place - low
    if not share:
        return values[low]
    return values[low] + share * (values[low + 1] - values[low])
