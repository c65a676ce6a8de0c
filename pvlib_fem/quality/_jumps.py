"""Where the middle of each day's light jumps, and by how much."""

import numpy as np
import pandas as pd

from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._onset import HOUR


def jumps_of(
    day: np.ndarray, middle: np.ndarray, limits: Limits, apart: bool = False
) -> list[dict]:
    """
    Days at which the middle of the light moves for good, or for some days.

    Parameters
    ----------
    day : numpy.ndarray of int, shape (days,)
        Numbers of the days, in order.
    middle : numpy.ndarray, shape (days,)
        Middle of each day's light, as a deviation from the same time of every day,
        such as the sun's noon. [s]
    limits : Limits
        Thresholds of the noon: ``noon_window``, ``min_noon_error``,
        ``daylight_tolerance`` and ``min_standard_errors``.
    apart : bool, default False
        Report jumps over gaps of whole seasons, too, but only by whole hours. That is
        right for deviations from the sun's noon alone: otherwise the season moves the
        middle over such a gap.

    Returns
    -------
    list of dict
        ``day``, the first after the jump, and ``at``, its place in ``day``; ``by``, its
        size, positive to later stamps [s]; and ``within``, the first and last day that
        it may be on. Moves near to whole hours are those; others are in whole minutes,
        and need as long again on both sides.
    """
    fewest = max(limits.noon_window // 2, 1)
    tried = np.arange(fewest, len(day) - fewest + 1)
    tried = tried[
        np.abs(median_moves(middle, limits.noon_window))[tried]
        >= limits.daylight_tolerance
    ]
    candidates = filter(None, (jump_at(i, day, middle, limits, apart) for i in tried))
    # neighbours see the same jump; it is where both sides are the most even
    groups = []
    for jump in candidates:
        if groups and same_jump(groups[-1][-1], jump, limits):
            groups[-1].append(jump)
        else:
            groups.append([jump])
    jumps = [evenest(group, limits) for group in groups]
    ends = [0, *(jump["at"] for jump in jumps), len(day)]
    sized = [
        jump | {"by": jump_size(day, middle, ends[i], jump["at"], ends[i + 2], limits)}
        for i, jump in enumerate(jumps)
    ]
    return [widened(jump, day, middle, limits) for jump in sized if jump["by"]]


def median_moves(middle: np.ndarray, side: int) -> np.ndarray:
    """From the median of the days before each to that of the days after. [s]"""
    days = pd.Series(np.append(middle, np.nan))
    before = days.shift().rolling(side, min_periods=1).median()
    after = days[::-1].rolling(side, min_periods=1).median()[::-1]
    return (after - before).to_numpy()


def same_jump(one: dict, other: dict, limits: Limits) -> bool:
    """Whether two days see one jump; there and back within days are two."""
    near = other["day"] - one["day"] <= limits.noon_window
    near |= other["at"] - one["at"] == 1  # the days on either side of a gap
    return near and np.sign(one["by"]) == np.sign(other["by"])


def jump_at(
    i: int, day: np.ndarray, middle: np.ndarray, limits: Limits, apart: bool
) -> dict | None:
    """A jump before the i-th day, or None."""
    first, last = max(i - limits.noon_window, 0), i + limits.noon_window
    around = day[first:last]
    by, error, rough = median_change(middle[first:i], middle[i:last])
    far = around[-1] - around[0] > 4 * limits.noon_window
    if far and not (apart and whole_hours(by, limits)):
        return None
    if (
        abs(by) < limits.daylight_tolerance
        or abs(by) < limits.min_standard_errors * error
    ):
        return None
    return dict(day=int(day[i]), before=int(day[i - 1]), at=i, by=by, rough=rough)


def median_change(before: np.ndarray, after: np.ndarray) -> tuple[float, float, float]:
    """
    Move from one median to another.

    Parameters
    ----------
    before, after : numpy.ndarray, shape (days,)
        Times of day on both sides, each of its own number of days. [s]

    Returns
    -------
    move, error, rough : tuple of float
        Second median less the first, its standard error, and the sum of both sides'
        mean absolute deviations from their medians. [s]
    """
    sides = before, after
    centres = [np.median(side) for side in sides]
    off = [np.abs(side - centre) for side, centre in zip(sides, centres)]
    # of medians of normal deviates, by median deviations: a day may be an accident
    error = 1.25 * 1.48 * np.hypot(*(np.median(o) / np.sqrt(len(o)) for o in off))
    return centres[1] - centres[0], error, sum(o.mean() for o in off)


def evenest(group: list, limits: Limits) -> dict:
    """The jump with the most even sides, and the days that it may be on."""
    best = min(group, key=lambda jump: jump["rough"])
    # where noise has exponential tails, e times less likely for each mean deviation
    scale = max(best["rough"] / 2, limits.min_noon_error) / limits.noon_window
    near = [
        j
        for j in group
        if j["rough"] - best["rough"] <= limits.min_standard_errors * scale
    ]
    return best | dict(within=(near[0]["before"] + 1, near[-1]["day"]))


def jump_size(
    day: np.ndarray, middle: np.ndarray, first: int, at: int, end: int, limits: Limits
) -> float:
    """A jump's whole hours; else its minutes, if it holds for long; else 0. [s]"""
    side = limits.noon_window
    by, _, _ = median_change(
        middle[max(first, at - side) : at], middle[at : min(end, at + side)]
    )
    if hour := whole_hours(by, limits):
        return hour
    if day[at] - day[at - 1] > 4 * side:
        return 0.0
    sides = middle[max(first, at - 3 * side) : at], middle[at : min(end, at + 3 * side)]
    if min(map(len, sides)) < side:
        return 0.0
    by, error, _ = median_change(*sides)
    if abs(by) < max(limits.daylight_tolerance, 2 * limits.min_standard_errors * error):
        return 0.0
    return whole_hours(by, limits) or 60.0 * round(by / 60)


def widened(jump: dict, day: np.ndarray, middle: np.ndarray, limits: Limits) -> dict:
    """The jump with adjacent days by neither clock, such as the day of setting."""
    at, side, far = jump["at"], limits.noon_window, abs(jump["by"]) / 4
    before, after = (
        np.median(middle[max(at - side, 0) : at]),
        np.median(middle[at : at + side]),
    )
    first, last = np.searchsorted(day, jump["within"])
    least, most = max(first - side // 2, 1), min(last + side // 2, len(day) - 1)
    while first > least and abs(middle[first - 1] - before) > far:
        first -= 1
    while last < most and abs(middle[last] - after) > far:
        last += 1
    return jump | dict(within=(int(day[first - 1]) + 1, int(day[last])))


def whole_hours(by: float, limits: Limits) -> float:
    """
    Whole hours that a move is near to.

    Parameters
    ----------
    by : float
        The move. [s]
    limits : Limits
        ``min_standard_errors`` times ``min_noon_error`` is the deviation that is
        allowed.

    Returns
    -------
    float
        With the sign of the move; 0 where no hour is near. [s]
    """
    hours = HOUR * round(by / HOUR)
    return (
        float(hours)
        if abs(by - hours) < limits.min_standard_errors * limits.min_noon_error
        else 0.0
    )
