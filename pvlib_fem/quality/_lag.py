"""How many steps a module's record is off: its warmth against the light, over a day.

Rows that are an hour apart do not show when an answer begins, but they show in which
step it does. At each lag of half a day the changes of over-temperature are regressed on
those of irradiance, as a sum of decays that begin there; the air is by the clock of the
irradiance. The lag that leaves least is the module's, if that holds day after day.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import nnls
from scipy.stats import norm, t as student

from pvlib_fem._record.column_names import is_power, twin_of
from pvlib_fem._record.inputs import Columns
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._onset import DAY, HOUR, decays, solar_midnight

ANSWER = 3 * HOUR  # s, in which a module's answer is over


@dataclass(frozen=True)
class Lag:
    """By how many whole steps a record is late, and how sure that is."""

    late: float  # [s]; 0 where no other step fits better
    step: float  # [s]
    sure: float  # standard errors between the days by which it fits better than none
    share: float  # of the changes that are explained at it
    residual: float  # as a share of that without a shift
    best: int  # rows by which it fits best, whether that is sure or not
    answer: np.ndarray  # there, change by change
    hours: tuple = ()  # (from here on [s], late by that [s]), where that changes


def coarse_lag(
    seconds: np.ndarray, poa: Any, air: np.ndarray, module: np.ndarray, limits: Limits
) -> Lag | None:
    """
    By how many steps a module is late against irradiance, up to half a day.

    Parameters
    ----------
    seconds : array, shape (rows,)
        Times since the record's first row. [s]
    poa, air, module : array, shape (rows,)
        ``poa_global`` [W/m²], ``temp_air`` and ``temp_module`` [°C].
    limits : Limits
        Thresholds of the clock.

    Returns
    -------
    Lag or None
        None where the record is too short or too dark, or its rows too far apart.
    """
    if len(seconds) < 2 or seconds[-1] < limits.min_record:
        return None
    base = float(np.median(np.diff(seconds)))
    if not 0 < base <= limits.max_noon_step:
        return None
    step = base * max(1, round(limits.max_onset_step / base))
    count = round(DAY / step)
    front = -solar_midnight(seconds, poa)
    even = daily_grid(seconds + front, (poa, air, module), step, count)
    poa, air, module = map(row_changes, even)
    sums = Products(poa, air, module, count, round(ANSWER / step))
    if not sums.informative:
        return None
    overall = weighed_lag(sums, step, limits)
    if base <= limits.max_onset_step:  # whose onset is looked for
        return overall
    day = np.unique(np.floor((seconds + front) / DAY))
    begin = [
        (day[at] * DAY - front, rows)
        for at, rows in hours_by_days(sums, overall, limits)
    ]
    hours = tuple((float(at), rows * step) for at, rows in begin)
    return replace(overall, hours=hours if len(hours) > 1 else ())


def retimed(
    seconds: np.ndarray, values: np.ndarray, late: float | np.ndarray
) -> np.ndarray:
    """
    A column by correct times.

    Parameters
    ----------
    seconds : numpy.ndarray, shape (rows,)
        Times since the record's first row. [s]
    values : numpy.ndarray, shape (rows,)
        The column as it was written.
    late : float or numpy.ndarray, shape (rows,)
        How much later than it happened a value was written. [s]

    Returns
    -------
    numpy.ndarray, shape (rows,)
        Interpolated linearly at ``seconds + late``; NaN beyond the ends.
    """
    return np.interp(seconds + late, seconds, values, left=np.nan, right=np.nan)


def following_column(poa_global: np.ndarray, *columns: np.ndarray) -> np.ndarray:
    """The column whose changes follow those of irradiance best."""
    change = np.diff(poa_global)

    def likeness(column: np.ndarray) -> float | np.ndarray:
        other = np.diff(column)
        both = np.isfinite(change) & np.isfinite(other)
        return change[both] @ other[both] / np.sqrt(other[both] @ other[both] + 1e-12)

    return max(columns, key=likeness)


def by_module_logger(columns: dict | Columns, retime: Callable) -> dict:
    """
    Columns that the module's logger wrote, by the clock of the irradiance.

    Parameters
    ----------
    columns : mapping of array
        By name; ``temp_module``, power and further module sensors are retimed.
    retime : callable
        A column of the module's logger to the same at correct times.

    Returns
    -------
    dict of array
        Power and a second sensor may have a logger of their own: only those that
        follow irradiance, or the module, better at correct times.
    """
    moved = {}
    if "temp_module" in columns:
        moved["temp_module"] = retime(columns["temp_module"])
    for name in columns:
        like = None
        if is_power(name):
            like = columns.get("poa_global")
        elif twin_of(name) == "temp_module":
            like = moved.get("temp_module")
        if like is not None:
            later = retime(columns[name])
            if following_column(like, columns[name], later) is later:
                moved[name] = later
    return moved


def daily_grid(
    seconds: np.ndarray, columns: tuple, step: float, count: int
) -> Iterator[np.ndarray]:
    """Means of columns over even steps of whole days; NaN on days without rows."""
    row = np.round(seconds / step - 1e-6).astype(np.int64)
    number = row // count
    day = np.cumsum(np.diff(number, prepend=number[:1]) > 0)
    place = day * count + row % count
    size = (day[-1] + 1) * count
    for values in columns:
        there = np.isfinite(values)
        many = np.bincount(place, there, size)
        total = np.bincount(place, np.where(there, values, 0.0), size)
        yield np.divide(total, many, out=np.full(size, np.nan), where=many > 0)


def row_changes(values: np.ndarray) -> np.ndarray:
    """Changes from row to row; 0 next to a missing value."""
    change = np.diff(values, prepend=values[:1])
    return np.where(np.isfinite(change), change, 0.0)


class Products:
    """Products of the changes of irradiance, air and module, lag by lag."""

    def __init__(
        self,
        poa: np.ndarray,
        air: np.ndarray,
        module: np.ndarray,
        count: int,
        length: int,
    ) -> None:
        self.poa, self.air, self.module = poa, air, module
        self.count, self.length, self.reach = count, length, count // 2
        self.cross = {}  # by the lag
        self.seen = self.by_day(module, module).astype(bool)
        self.own = np.array([self.lagged_product(poa, poa, j) for j in range(length)])
        self.of_air = np.array(
            [self.lagged_product(poa, air, j) for j in range(length)]
        )

    def products_of_days(self, first: int, end: int) -> "Products":
        """The products of some days."""
        rows = slice(first * self.count, end * self.count)
        columns = (self.poa[rows], self.air[rows], self.module[rows])
        return Products(*columns, self.count, self.length)

    @property
    def informative(self) -> bool:
        """Whether irradiance changes, and the module on more than one day."""
        return self.seen.sum() > 1 and self.own[0] > 0

    def lagged_product(self, one: np.ndarray, other: np.ndarray, lag: int) -> float:
        """One with the other so many rows later, in all."""
        end = len(one)
        if lag < 0:
            return other[: end + lag] @ one[-lag:]
        return one[: end - lag] @ other[lag:]

    def later(self, lag: int) -> float:
        """Irradiance with the module so many rows later, once for all its answers."""
        if lag not in self.cross:
            self.cross[lag] = self.lagged_product(self.poa, self.module, lag)
        return self.cross[lag]

    def by_day(self, one: np.ndarray, other: np.ndarray, lag: int = 0) -> np.ndarray:
        """Products for each day of the first column."""
        later = np.zeros_like(other)
        end = len(other)
        later[max(-lag, 0) : end - max(lag, 0)] = other[max(lag, 0) : end + min(lag, 0)]
        return (one * later).reshape(-1, self.count).sum(axis=1)

    def response_products(self, lag: int) -> tuple[np.ndarray, float]:
        """Products of the response after a lag: with irradiance, and with itself."""
        products = np.array([self.later(j) for j in range(lag, lag + self.length)])
        square = self.module @ self.module + self.air @ self.air
        square -= 2 * self.lagged_product(self.air, self.module, lag)
        return products - self.of_air, square

    def residual(self, lag: int, answer: np.ndarray) -> np.ndarray:
        """Daily residual of a response that begins at a lag."""
        own = np.correlate(answer, answer, "full")[len(answer) - 1 :].copy()
        own[1:] *= 2
        residual = self.by_day(self.module, self.module) + self.by_day(
            self.air, self.air
        )
        residual -= 2 * self.by_day(self.air, self.module, lag)
        for j in range(self.length):
            residual -= 2 * answer[j] * self.by_day(self.poa, self.module, lag + j)
            residual += 2 * answer[j] * self.by_day(self.poa, self.air, j)
            residual += own[j] * self.by_day(self.poa, self.poa, j)
        return residual


def weighed_lag(sums: Products, step: float, limits: Limits) -> Lag:
    """The lag with the least residual, and how surely it is less than without one."""
    lags = np.arange(sums.length)
    normal = sums.own[np.abs(lags[:, None] - lags)]
    shapes = decays(lags, step, 0.0)
    root = np.linalg.cholesky(stable(shapes.T @ normal @ shapes))

    def answer(lag: int) -> tuple[np.ndarray, float]:
        """The response that begins at a lag, and its residual."""
        target, square = sums.response_products(lag)
        right = np.linalg.solve(root, shapes.T @ target)
        weights, rest = nnls(root.T, right)
        return shapes @ weights, square + rest**2 - right @ right

    tried = {lag: answer(lag) for lag in range(-sums.reach, sums.reach + 1)}
    best = min(tried, key=lambda lag: tried[lag][1])
    # rows that hold means in one column and ends in the other are half a step apart
    near = [lag for lag in (-1, 0, 1) if abs(best) > 1 or not lag]
    none = min(near, key=lambda lag: tried[lag][1])
    there, usual = (sums.residual(lag, tried[lag][0]) for lag in (best, none))
    seen = sums.seen
    # each day alike, but those that hardly move; what a day leaves has a part of the
    # next in it, and may be below nothing
    both = (usual + there)[seen]
    least = np.maximum(both, np.median(np.abs(both)) / 2)
    fall = np.zeros(both.shape)  # of a day without a residual either way
    np.divide((usual - there)[seen], least, out=fall, where=least > 0)
    fall = np.clip(fall, -1.0, 1.0)
    error = fall.std(ddof=1) / np.sqrt(fall.size)
    sure = float(fall.mean() / error) if error > 0 else 0.0
    critical = student.ppf(norm.cdf(limits.min_standard_errors), fall.size - 1)
    ratio = tried[best][1] / tried[none][1] if tried[none][1] > 0 else 1.0
    changed = sums.module @ sums.module + sums.air @ sums.air
    share = float(1 - tried[best][1] / changed)
    most = limits.max_lag_error if abs(best) > 1 else limits.max_next_lag_error
    holds = sure > critical and ratio < most and share > limits.min_lag_share
    late = best * step if holds else 0.0
    return Lag(late, step, sure, share, float(ratio), best, tried[best][0])


def hours_by_days(
    sums: Products, overall: Lag, limits: Limits
) -> list[tuple[int, int]]:
    """From which day on the module is how many rows late; one pair if it is so always.

    Stretches are of months, since a few weeks of one sky may be an accident.
    """
    days = len(sums.seen)
    parts = np.linspace(0, days, max(2, round(days / (2 * limits.max_block_days)) + 1))
    runs = []
    for first, end in pairwise(parts.astype(int)):
        part = sums.products_of_days(first, end)
        one = weighed_lag(part, overall.step, limits) if part.informative else None
        if (
            one is None
            or one.share < limits.min_lag_share
            or (one.best and not one.late)
        ):
            continue
        if not runs or runs[-1][-1][0] != one.best:
            runs.append([])
        runs[-1].append((one.best, first, end))
    runs = [run for run in runs if len(run) > 1]
    hours = [(0, runs[0][0][0])] if runs else []
    for one, other in pairwise(runs):
        if (lag := other[0][0]) != hours[-1][1]:
            first, end = one[-1][1], other[0][2]
            part = sums.products_of_days(first, end)
            gain = part.residual(hours[-1][1], overall.answer) - part.residual(
                lag, overall.answer
            )
            at = first + int(np.argmin(np.cumsum(np.append(0.0, gain))))
            hours.append((at, lag))
    return hours


def stable(square: np.ndarray) -> np.ndarray:
    return square + 1e-10 * max(np.trace(square), 1e-30) * np.eye(len(square))
