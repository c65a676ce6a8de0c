"""Days that stand out of what a residual usually is: a cover, snow, work on site."""

import numpy as np
from scipy.ndimage import median_filter

AROUND = 28  # days on either side, whose median is usual
LENGTHS = (1, 2, 4, 8)  # days of the stretches that are weighed; longer ones grow
FEWEST = 30  # days, below which none is usual
PRESENT = 0.5  # of the usual rows, from which a day counts
HALF = 0.5  # of a stretch's mean, from which a day at its edge is part of it
GAP = 3  # days between two that are of one stretch
TINY = 1e-12  # K, of a residual that is none
MOST = 50  # stretches of a series at once, and times that it is looked at
#: exponents of a tail that falls as exp(−x^k): exponential, and normal between the
#: median and the 90 % quantile
TAILS = (1.0, 1.345)


def episodes(residual, dates, sunny, chance):
    """
    Stretches of days on which a residual is not what it is around them.

    Means by day and means by night are each taken about their moving median of eight
    weeks, so that a season and a step at a date are none, and in units of their usual
    size in those weeks. Sums of 1, 2, 4 and 8 days in turn are held against what is
    usual for that many days in this record, whatever memory it has: against a tail
    through the median and the 90 % quantile of single days, as heavy as an exponential
    one at most, at a chance that counts all sums. A stretch then grows as far as days
    have half of its mean. The days that are left are looked at anew, until they show
    none: where there are many, they hide each other. That chance is of the first look.

    Parameters
    ----------
    residual : array
        [K]
    dates : array of int
        Calendar day of each row, from 1970-01-01.
    sunny : array of bool
        Rows by day.
    chance : float
        That noise shows any.

    Returns
    -------
    list of (int, int)
        First and last day, in order.
    """
    found = []
    for rows in (sunny, ~sunny):
        days, means = daily_means(residual[rows], dates[rows])
        if len(days) >= FEWEST:
            ends = stretches(means, days, chance / 2.0)
            found += [(int(days[i]), int(days[j - 1])) for i, j in ends]
    return joined(sorted(found))


def daily_means(residual, dates):
    """Days that have enough rows, and their means."""
    days, place, size = np.unique(dates, return_inverse=True, return_counts=True)
    means = np.bincount(place, residual, len(days)) / size
    enough = size >= PRESENT * np.median(size) if len(size) else size > 0
    return days[enough], means[enough]


def stretches(values, days, chance):
    """From and to (exclusive) of each stretch of a series."""
    found, left = [], np.arange(len(values))
    for _ in range(MOST):
        if len(left) < FEWEST:
            break
        new = at_once(values[left], days[left], chance)
        if not new:
            break
        found += [(int(left[start]), int(left[end - 1]) + 1) for start, end in new]
        # what is usual is so of the other days, which are looked at anew
        gone = np.concatenate([np.arange(start, end) for start, end in new])
        left = np.delete(left, gone)
    return found


def at_once(values, days, chance):
    """Stretches beside what is usual of all these days."""
    around = {"size": 2 * AROUND + 1, "mode": "reflect"}
    apart = values - median_filter(values, **around)
    # some weeks of the year have more weather than others
    size = np.abs(apart)
    apart /= np.maximum(median_filter(size, **around), max(np.median(size), TINY))
    limits, found = usual(apart, days, chance), []
    for _ in range(MOST):
        best = strongest(apart, days, limits)
        if best is None:
            break
        start, end = grown(apart, days, *best)
        found.append((start, end))
        apart[start:end] = 0.0
    return found


def sums_of(values, days, length):
    """Sums of so many days, 0 where a gap is between them."""
    total = np.concatenate(([0.0], np.cumsum(values)))
    sums = total[length:] - total[:-length]
    span = days[length - 1 :] - days[: len(days) - length + 1]
    return np.where(span < 2 * length, sums, 0.0)


def usual(apart, days, chance):
    """Size of the sum of so many days, by length, that noise has at that chance."""
    half, most = np.quantile(np.abs(apart), [0.5, 0.9])
    if not half > 0.0:
        return {}
    tail = np.log(np.log(10.0) / np.log(2.0)) / np.log(max(most / half, 1.0 + 1e-9))
    tail = np.clip(tail, *TAILS)
    tests = len(apart) * len(LENGTHS)
    far = (np.log(tests / chance) / np.log(2.0)) ** (1.0 / tail)
    limits, before = {}, 1
    for length in LENGTHS:
        own = np.median(np.abs(sums_of(apart, days, length)))
        half = max(own, half * np.sqrt(length / before))  # as without memory, or more
        limits[length], before = half * far, length
    return limits


def strongest(apart, days, limits):
    """The stretch that is furthest beyond its limit, or None."""
    best, found = 1.0, None
    for length, limit in limits.items():
        beyond = np.abs(sums_of(apart, days, length)) / limit
        start = int(np.argmax(beyond))
        if beyond[start] > best:
            best, found = beyond[start], (start, start + length)
    return found


def grown(apart, days, start, end):
    """The stretch without usual days at its edges, and with further ones like it."""
    mean = apart[start:end].mean()
    strong = np.flatnonzero(apart * np.sign(mean) >= HALF * abs(mean))
    inside = strong[(strong >= start) & (strong < end)]
    first = last = int(
        np.searchsorted(strong, inside[np.argmax(np.abs(apart[inside]))])
    )
    while first > 0 and days[strong[first]] - days[strong[first - 1]] < GAP:
        first -= 1
    while last + 1 < len(strong) and days[strong[last + 1]] - days[strong[last]] < GAP:
        last += 1
    return int(strong[first]), int(strong[last]) + 1


def joined(ends):
    """Stretches that touch or overlap as one."""
    found = []
    for first, last in ends:
        if found and first <= found[-1][1] + 1:
            found[-1] = (found[-1][0], max(last, found[-1][1]))
        else:
            found.append((first, last))
    return found
