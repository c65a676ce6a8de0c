"""Find unusual days of a residual: a cover, snow, work on site."""

import numpy as np
from scipy.ndimage import median_filter

AROUND = 28  # days on either side for the moving median
LENGTHS = (1, 2, 4, 8)  # days of the tested stretches; longer ones grow from these
FEWEST = 30  # a shorter series has no usual level
PRESENT = 0.5  # least share of the usual rows of a day
HALF = 0.5  # share of a stretch's mean above which a day at its edge belongs to it
GAP = 3  # days; two days closer than this belong to one stretch
TINY = 1e-12  # K, a residual below is zero
MOST = 50  # largest number of stretches per search, and of searches
#: exponents k of a tail exp(−x^k): 1 is exponential, 1.345 is normal between the
#: median and the 90 % quantile
TAILS = (1.0, 1.345)


def episodes(
    residual: np.ndarray, dates: np.ndarray, sunny: np.ndarray, chance: float
) -> list[tuple[int, int]]:
    """
    Stretches of days with an unusual residual.

    Daily means of daytime and of night rows are tested separately. The moving median of
    eight weeks is subtracted, so a season or a step is no stretch, and the means are
    divided by their usual size in those weeks. Sums over 1, 2, 4 and 8 days are
    compared with the distribution of such sums in this record. Its tail runs through
    the median and the 90 % quantile of single days and is exponential at most. The
    threshold accounts for the number of sums. A stretch grows as long as adjacent days
    have half of its mean. The search repeats on the other days until it finds nothing,
    because many stretches hide each other; ``chance`` holds for the first search.

    Parameters
    ----------
    residual : array
        [K]
    dates : array of int
        Calendar day of each row, from 1970-01-01.
    sunny : array of bool
        Daytime rows.
    chance : float
        Probability that noise alone shows a stretch.

    Returns
    -------
    list of (int, int)
        First and last day of each stretch, in order.
    """
    spans = []
    for rows in (sunny, ~sunny):
        days, means = daily_means(residual[rows], dates[rows])
        if len(days) >= FEWEST:
            ends = stretches(means, days, chance / 2.0)
            spans += [(int(days[i]), int(days[j - 1])) for i, j in ends]
    return merged_stretches(sorted(spans))


def daily_means(
    residual: np.ndarray, dates: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Days that have enough rows, and their means."""
    days, place, size = np.unique(dates, return_inverse=True, return_counts=True)
    means = np.bincount(place, residual, len(days)) / size
    enough = size >= PRESENT * np.median(size) if len(size) else size > 0
    return days[enough], means[enough]


def stretches(values: np.ndarray, days: np.ndarray, chance: float) -> list:
    """From and to (exclusive) of each stretch of a series."""
    spans, remaining = [], np.arange(len(values))
    for _ in range(MOST):
        if len(remaining) < FEWEST:
            break
        new = stretches_of_search(values[remaining], days[remaining], chance)
        if not new:
            break
        spans += [
            (int(remaining[start]), int(remaining[end - 1]) + 1) for start, end in new
        ]
        # the usual level changes without these days, so the others are searched again
        gone = np.concatenate([np.arange(start, end) for start, end in new])
        remaining = np.delete(remaining, gone)
    return spans


def stretches_of_search(values: np.ndarray, days: np.ndarray, chance: float) -> list:
    """Stretches that one search finds, given the usual level of all days."""
    around = {"size": 2 * AROUND + 1, "mode": "reflect"}
    apart = values - median_filter(values, **around)
    # the weather is more variable in some weeks of the year
    size = np.abs(apart)
    apart /= np.maximum(median_filter(size, **around), max(np.median(size), TINY))
    limits, spans = sum_thresholds(apart, days, chance), []
    for _ in range(MOST):
        best = strongest_stretch(apart, days, limits)
        if best is None:
            break
        start, end = grown_stretch(apart, days, *best)
        spans.append((start, end))
        apart[start:end] = 0.0
    return spans


def sums_of(values: np.ndarray, days: np.ndarray, length: int) -> np.ndarray:
    """Sums over so many days; 0 if a gap is between them."""
    total = np.concatenate(([0.0], np.cumsum(values)))
    sums = total[length:] - total[:-length]
    span = days[length - 1 :] - days[: len(days) - length + 1]
    return np.where(span < 2 * length, sums, 0.0)


def sum_thresholds(
    apart: np.ndarray, days: np.ndarray, chance: float
) -> dict[int, float]:
    """Threshold of a sum of days, by number of days, that noise exceeds by chance."""
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
        half = max(own, half * np.sqrt(length / before))  # at least as uncorrelated
        limits[length], before = half * far, length
    return limits


def strongest_stretch(
    apart: np.ndarray, days: np.ndarray, limits: dict
) -> tuple | None:
    """The stretch that exceeds its threshold most, or None."""
    best, span = 1.0, None
    for length, limit in limits.items():
        beyond = np.abs(sums_of(apart, days, length)) / limit
        start = int(np.argmax(beyond))
        if beyond[start] > best:
            best, span = beyond[start], (start, start + length)
    return span


def grown_stretch(
    apart: np.ndarray, days: np.ndarray, start: int, end: int
) -> tuple[int, int]:
    """The stretch, trimmed by usual days at its edges and extended by similar days."""
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


def merged_stretches(ends: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Merge stretches that touch or overlap."""
    merged = []
    for first, last in ends:
        if merged and first <= merged[-1][1] + 1:
            merged[-1] = (merged[-1][0], max(last, merged[-1][1]))
        else:
            merged.append((first, last))
    return merged
