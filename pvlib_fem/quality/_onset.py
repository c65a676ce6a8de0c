"""When a module begins to answer the sun, lag by lag, from two columns of changes."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.ndimage import uniform_filter1d
from scipy.optimize import minimize_scalar, nnls

DAY, HOUR = 86400.0, 3600.0  # s
#: a contact sensor answers in 40 s, a thermopile in 8: the difference [s]
SENSOR = 32.0
DECAYS = np.array([150.0, 300.0, 600.0, 1200.0, 2400.0])  # s, of modules and roofs
BEFORE, AFTER = 720.0, 2700.0  # s, lags around the onset
FINEST = 60.0  # s; a module answers within minutes
FEWEST_DAYS = 2  # of a block: the error is by what days differ
FADE = 3600.0  # s; slower changes are the sun's path and the weather's, not clouds'


@dataclass(frozen=True)
class Sums:
    """Products of the two columns of changes, for each day and lag."""

    own: np.ndarray  # irradiance with itself, lags 0 … reach
    cross: np.ndarray  # temperature that many rows later, lags −reach … reach
    step: float  # [s]
    start: float  # of the calendar's first day, from the record's first row [s]
    day: float  # rows of a day are whole, so it may be off by a part of one [s]
    number: np.ndarray  # of each day that has rows, in the calendar

    def __len__(self) -> int:
        return len(self.own)

    @property
    def reach(self) -> int:
        return self.own.shape[1] - 1

    def later(self, lag: int, count: int, days: Any = slice(None)) -> np.ndarray:
        """Daily products at ``count`` lags from ``lag`` on."""
        return self.cross[days, self.reach + lag : self.reach + lag + count]

    def begin(self, day: int | np.ndarray) -> float | np.ndarray:
        """When a day begins, from the record's first row. [s]"""
        return self.start + self.number[day] * self.day


def daily_sums(
    seconds: np.ndarray, base: float, poa: np.ndarray, module: np.ndarray, limits: Any
) -> Sums:
    """
    Products of the changes of irradiance and module temperature, by day and lag.

    Days end in the dark. Rows some seconds apart are taken together to steps of about a
    minute, with the mean of the irradiance and the last temperature.

    Parameters
    ----------
    seconds : numpy.ndarray, shape (rows,)
        Times since the record's first row. [s]
    base : float
        Usual time between rows. [s]
    poa : numpy.ndarray, shape (rows,)
        Irradiance. [W/m²]
    module : numpy.ndarray, shape (rows,)
        Temperature of the module. [°C]
    limits : Limits
        ``max_onset_shift`` is the reach of the lags, with 45 min more.

    Returns
    -------
    Sums
        ``own`` has shape (days, reach + 1) [W²/m⁴], ``cross`` (days, 2 reach + 1)
        [K W/m²], of the days that have rows.
    """
    # short steps are taken together: the mean of what came in, the end of the answer
    gather = max(1, round(FINEST / base))
    step = base * gather
    count = round(DAY / step)
    front = round(-solar_midnight(seconds, poa) / step) * gather
    row = front + np.round(seconds / base).astype(int)
    # only days that have rows: a stray time may be centuries from the others
    number, place = np.unique(row // (count * gather), return_inverse=True)
    place = place * count * gather + row % (count * gather)

    def fold(values: np.ndarray) -> np.ndarray:
        table = np.full(len(number) * count * gather, np.nan)
        table[place] = values
        return table.reshape(-1, gather)

    came = fold(poa)
    came = came.mean(axis=1) if gather > 1 else came[:, 0]
    # days are apart where there is a gap between them
    apart = np.flatnonzero(np.diff(number) > 1) + 1
    x = hourly_changes(came, step, apart * count).reshape(-1, count)
    y = hourly_changes(fold(module)[:, -1], step, apart * count).reshape(-1, count)
    reach = int((limits.max_onset_shift + AFTER) / step)
    # daily transforms are small and alike on any number of cores
    length = next_fast_len(count + reach, real=True)
    fx, fy = rfft(x, length), rfft(y, length)
    own = irfft(fx.real**2 + fx.imag**2, length)[:, : reach + 1]
    cross = irfft(fy * fx.conj(), length)
    cross = np.concatenate((cross[:, -reach:], cross[:, : reach + 1]), axis=1)
    return Sums(own, cross, step, -front * base, count * step, number)


def solar_midnight(seconds: np.ndarray, poa: np.ndarray) -> float:
    """
    Midnight by the sun at or before a record's first row.

    It is half a day from the mean noon of the irradiance.

    Parameters
    ----------
    seconds : numpy.ndarray, shape (rows,)
        Times since the record's first row. [s]
    poa : numpy.ndarray, shape (rows,)
        Irradiance; NaN counts as dark. [W/m²]

    Returns
    -------
    float
        Time since the first row, from −86400 to 0, in whole ten minutes. [s]
    """
    part = (np.asarray(seconds) / 600.0).astype(int) % 144
    sun = np.bincount(part, np.where(np.isnan(poa), 0.0, poa), 144)
    turn = np.exp(2j * np.pi * np.arange(144) / 144)
    noon = np.angle((sun * turn).sum()) / (2 * np.pi) * DAY
    return round((noon - DAY / 2) % DAY / 600.0) * 600.0 - DAY


def hourly_changes(values: np.ndarray, step: float, apart: np.ndarray) -> np.ndarray:
    """Changes from row to row, less their hour's mean; 0 next to a NaN or a gap."""
    change = np.diff(values, prepend=values[:1])
    change[~np.isfinite(change)] = 0.0
    change[apart] = 0.0
    return change - uniform_filter1d(change, round(FADE / step), mode="constant")


def decays(lags: np.ndarray, step: float, onset: float) -> np.ndarray:
    """
    Change per row after a step of irradiance, of each decay of ``DECAYS``.

    Parameters
    ----------
    lags : numpy.ndarray of int, shape (lags,)
        Numbers of rows since the step, one after the other.
    step : float
        Time between rows. [s]
    onset : float
        Time after the step at which the decays begin. [s]

    Returns
    -------
    numpy.ndarray, shape (lags, decays)
        As a share of the final answer; 0 before the onset. [-]
    """
    return changes_between(np.append(lags, lags[-1] + 1) * step - onset)


def changes_between(since: np.ndarray, over: float = 0.0) -> np.ndarray:
    """
    Change of each decay from one time since a step of irradiance to the next.

    Of its values at these times, or of its means over a time before each. [s]
    """
    if over:
        whole = integrated_response(since[:, None])
        answer = (whole - integrated_response(since[:, None] - over)) / over
    else:
        answer = decay_response(since[:, None])
    return answer[1:] - answer[:-1]


def decay_response(since: np.ndarray) -> np.ndarray:
    """Of a decay, seen by the sensor, to a step at 0."""
    since = np.maximum(since, 0.0)
    own, seen = np.exp(-since / DECAYS), np.exp(-since / SENSOR)
    return 1.0 - (DECAYS * own - SENSOR * seen) / (DECAYS - SENSOR)


def integrated_response(since: np.ndarray) -> np.ndarray:
    """Integral of :func:`decay_response` from 0. [s]"""
    since = np.maximum(since, 0.0)
    own, seen = (t**2 * -np.expm1(-since / t) for t in (DECAYS, SENSOR))
    return since - (own - seen) / (DECAYS - SENSOR)


def usual_response(step: float) -> np.ndarray:
    """
    Change per row of a usual module after a step of irradiance.

    Parameters
    ----------
    step : float
        Time between rows. [s]

    Returns
    -------
    numpy.ndarray, shape (lags,)
        From the row of the step to half an hour later, as a share of the final
        answer. [-]
    """
    lags = np.arange(1 + round(1800 / step))
    return decays(lags, step, 0.0)[:, 1:3].mean(axis=1)


def measured_blocks(sums: Sums, changes: list, limits: Any) -> list[dict]:
    """
    Onset of the module's answer in blocks of some days.

    Parameters
    ----------
    sums : Sums
        From :func:`daily_sums`.
    changes : list of int
        Places of days at which the clock jumps, in order; no block is across one.
    limits : Limits
        ``onset_blocks`` and ``max_block_days`` give the length of the blocks,
        ``min_peak_ratio`` and ``onset_tolerance`` which are kept.

    Returns
    -------
    list of dict
        For each block whose clouds show the onset: ``day``, the place of its first day;
        ``seconds``, its middle since the first row; ``late``, the onset, positive if
        the module is late, and its ``stderr`` [s]; ``of_means``, a function that gives
        the onset if each temperature is a mean over its step, and not the value at its
        end [s]; ``coarse``, the onset in rows.
    """
    length = np.clip(
        len(sums) / limits.onset_blocks, FEWEST_DAYS, limits.max_block_days
    )
    blocks = []
    for first, end in pairwise([0, *changes, len(sums)]):
        parts = np.array_split(
            np.arange(first, end), max(1, round((end - first) / length))
        )
        blocks += [measured_onset(sums, days, limits) for days in parts]
    return [block for block in blocks if block is not None]


def measured_onset(sums: Sums, days: np.ndarray, limits: Any) -> dict | None:
    """Onset in some days together, or None where clouds do not show it."""
    own, cross = sums.own[days].sum(axis=0), sums.cross[days].sum(axis=0)
    shape = usual_response(sums.step)
    height = np.correlate(cross, shape, "valid")
    coarse = int(np.argmax(height)) - sums.reach
    # a clear sky's answer has no peak that stands out
    scatter = 1.4826 * np.median(np.abs(height))
    clear = height.max() > limits.min_peak_ratio * scatter > 0
    known = np.count_nonzero(sums.cross[days].any(axis=1))  # not in a gap
    if known < FEWEST_DAYS or not clear:
        return None
    first = max(coarse - round(BEFORE / sums.step) - 2, -sums.reach)
    last = min(coarse + round(AFTER / sums.step), sums.reach)
    lags = np.arange(first, last + 1)
    normal, cross = own[np.abs(lags[:, None] - lags)], cross[sums.reach + lags]
    edges = np.append(lags, lags[-1] + 1) * sums.step

    def weigh(onset: float, over: float = 0.0) -> tuple[np.ndarray, float]:
        """Weights of the decays, none below 0, and the misfit but a constant."""
        shapes = changes_between(edges - onset, over)
        square = shapes.T @ normal @ shapes
        trace = square.trace()
        if not trace > 0:  # it would begin beyond the last lag
            return np.zeros(len(DECAYS)), 0.0
        square.flat[:: len(DECAYS) + 1] += 1e-10 * trace
        root = np.linalg.cholesky(square)
        right = np.linalg.solve(root, shapes.T @ cross)
        weights, rest = nnls(root.T, right)
        return weights, rest**2 - right @ right

    def fitted(over: float = 0.0) -> float:
        """Onset of values, or of means over a time before each. [s]"""
        return least_on_grid(
            lambda onset: weigh(onset, over)[1], coarse * sums.step, sums.step
        )

    onset = fitted()
    weights = weigh(onset)[0]
    if not weights.any():
        return None
    stderr, information = onset_error(sums, days, lags, onset, weights, normal)
    if not stderr < sums.step + limits.onset_tolerance:
        return None
    middle = np.average(sums.begin(days), weights=information) + sums.day / 2
    return dict(
        day=days[0],
        seconds=middle,
        late=onset,
        stderr=stderr,
        of_means=partial(fitted, sums.step),
        coarse=coarse,
    )


def least_on_grid(misfit: Callable, near: float, step: float) -> float:
    """Where a function of time is least: on a grid, then between its neighbours."""
    width = max(step / 2, 60.0)
    grid = near + width * np.arange(-8, 9)
    best = grid[np.argmin([misfit(onset) for onset in grid])]
    bounds, options = (best - width, best + width), {"xatol": 1e-3 * step}
    return minimize_scalar(misfit, bounds=bounds, method="bounded", options=options).x


def onset_error(
    sums: Sums,
    days: np.ndarray,
    lags: np.ndarray,
    onset: float,
    weights: np.ndarray,
    normal: np.ndarray,
) -> tuple[float, np.ndarray]:
    """Standard error of the onset, from the contribution of each day."""
    step, small = sums.step, 0.01 * sums.step
    used = decays(lags, step, onset)[:, weights > 0]
    answer = used @ weights[weights > 0]
    ahead, behind = (decays(lags, step, onset + d) @ weights for d in (small, -small))
    slope = (ahead - behind) / (2 * small)
    # what a change of the weights would do as well tells nothing of the onset
    same = used.T @ normal
    slope -= used @ np.linalg.lstsq(same @ used, same @ slope, rcond=None)[0]
    own = sums.own[days][:, : len(lags)]
    measured = np.einsum("ij,j->i", sums.later(lags[0], len(lags), days), slope)
    score = measured - quadratic(own, slope, answer)
    information = np.maximum(quadratic(own, slope, slope), 0.0)
    if not information.sum() > 0:
        return np.inf, information
    spread = np.einsum("i,i->", score, score) * len(days) / (len(days) - 1)
    return np.sqrt(spread) / information.sum(), information


def quadratic(own: np.ndarray, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Daily ``one · R · other``, with R the Toeplitz matrix of its lags."""
    lags = np.correlate(one, other, "full")
    middle = len(one) - 1
    both = lags[middle:].copy()
    both[1:] += lags[:middle][::-1]
    return np.einsum("ij,j->i", own, both)
