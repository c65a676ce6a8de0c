"""Is the module's logger late? What physics allows no model to hide.

A module cannot answer before the sun asks. So the change of its temperature, seen
lag by lag after the changes of irradiance, tells where the answer begins (`onset`):
at no lag where both clocks agree. No thermal model is fitted; how much and how slowly
the module answers is free, as long as it is a sum of decays that all begin at once.
"""

from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
import pandas as pd
from scipy.stats import median_abs_deviation, norm, t as student, theilslopes

from pvlib_fem._converter import AnyFloat
from pvlib_fem._record.checks import usual_step
from pvlib_fem._record.inputs import Record
from pvlib_fem.quality._hours import day_of, hours_of, listed_jumps, offsets, side_of
from pvlib_fem.quality._lag import Lag, coarse_lag, retimed
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._onset import (
    DAY,
    HOUR,
    Sums,
    daily_sums,
    measured_blocks,
    usual_response,
)


@dataclass(frozen=True, eq=False)
class Clock:
    """
    How late the module's logger is, from :func:`clock_shift`.

    Notes
    -----
    Positive is late: what happened at ``t`` is written at ``t + late``, so that
    ``temp_module(t + late)`` belongs to ``poa_global(t)``.
    """

    late: AnyFloat = np.nan  # at the middle of the record, outside daylight saving [s]
    stderr: float = np.nan  # [s]
    drift: AnyFloat = np.nan  # [s/day]
    drift_stderr: float = np.nan  # [s/day]
    blocks: pd.DataFrame = field(default_factory=pd.DataFrame)
    jumps: tuple = ()  # (first day after it, seconds)
    faults: dict[str, str] = field(default_factory=dict)  # name: one line
    why: str = ""  # one line; "" when the clock is fine
    middle: float = 0.0  # of the record, from its start [s]
    hours: tuple[tuple[float, float], ...] = ()  # (from here on [s], late by that [s])
    limit: float = np.nan  # below which it is not at fault: a sample, and a sensor [s]
    #: ``late`` if each temperature is a mean over its step, and not the value at its
    #: end; NaN of a clock that is not late by the same all the time [s]
    of_means: float = np.nan
    in_file: ClassVar = ("late", "drift", "middle", "hours", "faults")

    @property
    def fault(self) -> bool:
        return bool(self.faults)

    @property
    def by_means(self) -> "Clock":
        """The clock if each temperature is a mean over its step."""
        faults = dict(self.faults)
        if faults.pop("clock_shift", "") and abs(self.of_means) > self.limit:
            faults["clock_shift"] = shift_line(self.of_means, self.stderr, self.limit)
        return replace(
            self, late=self.of_means, faults=faults, why="; ".join(faults.values())
        )

    def late_at(self, seconds: np.ndarray) -> np.ndarray:
        """How late the clock is, of what its faults say; 0 if it has none. [s]"""
        late = np.zeros(len(seconds))
        if {"clock_shift", "clock_drift"} & set(self.faults):
            late += self.late
        if "clock_drift" in self.faults:
            late += self.drift * (np.asarray(seconds) - self.middle) / DAY
        return late + offsets(self.hours, seconds)

    def corrected(self, seconds: np.ndarray, values: np.ndarray) -> np.ndarray:
        """
        A column of the module's logger by the clock of the irradiance.

        Parameters
        ----------
        seconds : array
            Times since the record's first row, as ``record.inputs.seconds``. [s]
        values : array
            ``temp_module``, or ``p_dc_per_area`` where the same logger wrote it.

        Returns
        -------
        array
            Interpolated to what happened at ``seconds``; NaN beyond the record's
            ends, and next to a NaN. A clock without fault changes nothing.
        """
        values = np.asarray(values, dtype=float)
        if not self.fault:
            return values.copy()
        return retimed(seconds, values, self.late_at(seconds))


def clock_shift(
    record: Record, skip: np.ndarray | None = None, limits: Limits | None = None
) -> Clock:
    """
    How late ``temp_module`` is written against ``poa_global``, by causality.

    Parameters
    ----------
    record : Record
        From ``records.measured``; its rows are an hour apart at most.
    skip : array of bool, shape (rows,), optional
        Rows that are not to be used, as those of a stuck sensor.
    limits : Limits, optional
        The thresholds.

    Returns
    -------
    Clock
        ``late`` [s] with its ``stderr``, ``drift`` [s/day], ``jumps`` of an hour,
        and ``blocks`` of some days each. ``late`` is NaN, and ``why`` says so,
        where the record is too short, too coarse or too clear to tell. By rows more
        than 15 min apart it is whole steps.

    Notes
    -----
    Changes of temperature are regressed on changes of irradiance, lag by lag,
    both less what is slower than an hour [1]_. The response is that of a sum of
    decays, each with a weight that is not negative, seen by a contact sensor
    (40 s) and held over each step; the time at which it begins is fitted. Errors
    leave days whole, since clouds of one day are not independent.

    The lag in whole steps is found first, by :func:`._lag.coarse_lag`: over
    half a day either way and on rows up to an hour apart. By rows of 15 min or less
    the onset is then looked for around that. ``late`` is that of temperatures at the
    end of each step, ``of_means`` that of means over each step; both often fit alike.

    A clock is at fault if it is out by more than one sample and half a minute:
    whether a row holds its step's mean or end moves it by half a sample, and
    contact sensors differ by half a minute. A drift must add up to that over the
    record.

    References
    ----------
    .. [1] L. Ljung, "System identification", 1999, ch. 6: impulse response by
       correlation; a delay is where it begins.
    """
    limits = limits or Limits()
    seconds = record.inputs.seconds
    if len(seconds) < 2 or seconds[-1] < limits.min_record:
        return unknown_clock("the record is shorter than two days")
    if (base := usual_step(record.index)) > limits.max_noon_step:
        return unknown_clock(
            f"rows are {base / 60:.0f} min apart, longer than a response"
        )
    poa, module = record["poa_global"], record["temp_module"]
    if skip is not None:
        module = np.where(skip, np.nan, module)
    coarse = coarse_lag(seconds, poa, record["temp_air"], module, limits)
    if base > limits.max_onset_step:
        if coarse is None:
            return unknown_clock("hardly any light moves it")
        return by_hours(record.index[0], coarse) if coarse.hours else by_rows(coarse)
    far = coarse.late if coarse and abs(coarse.late) > HOUR else 0.0
    if far:
        module = retimed(seconds, module, far)
    sums = daily_sums(seconds, base, poa, module, limits)
    blocks = measured_blocks(sums, [], limits)
    if changes := jumps_between(sums, blocks, limits):
        blocks = measured_blocks(sums, [change["day"] for change in changes], limits)
    if not blocks and far:
        return by_rows(coarse)
    if not blocks:
        return unknown_clock(
            "too little broken cloud, whose edges show where it begins"
        )
    return judge(record.index[0], seconds, sums, blocks, changes, limits, far)


def by_hours(origin: pd.Timestamp, coarse: Lag) -> Clock:
    """The clock where the step in which an answer begins changes."""
    (_, first), *rest = coarse.hours
    hours = ((-np.inf, first), *rest)
    moves = [late - before for (_, before), (_, late) in pairwise(hours)]
    jumps = tuple((day_of(origin, at), by) for (at, _), by in zip(rest, moves))
    line = f"the clock of temp_module jumps by {listed_jumps(jumps)}"
    if len(jumps) > 1 and all(abs(by) == HOUR for by in moves):
        line += ", as daylight-saving time does"
    faults = {"dst": line}
    return Clock(
        0.0, 0.0, jumps=jumps, faults=faults, why=line, hours=hours, limit=coarse.step
    )


def by_rows(coarse: Any) -> Clock:
    """The clock as far as whole steps tell."""
    if not coarse.late:
        return Clock(late=0.0, stderr=0.0, limit=coarse.step)
    line = (
        f"timestamps of temp_module run {abs(coarse.late) / HOUR:.3g} h "
        f"{side_of(coarse.late)} those of poa_global, in whole steps of "
        f"{coarse.step / 60:.0f} min"
    )
    faults = {"clock_shift": line}
    return Clock(coarse.late, 0.0, faults=faults, why=line, limit=coarse.step)


def unknown_clock(reason: str) -> Clock:
    return Clock(why=f"the module's clock was not checked: {reason}")


def jumps_between(sums: Sums, blocks: list, limits: Limits) -> list[dict]:
    """Days at which the clock moved by an hour, and by what. [s]"""
    shape, jumps = usual_response(sums.step), []
    blocks = unmixed(blocks, limits)
    for one, other, end in zip(blocks, blocks[1:], [*blocks[2:], {"day": len(sums)}]):
        moved = abs(other["late"] - one["late"])
        if abs(moved - HOUR) >= limits.min_noon_error:
            continue
        days = np.arange(one["day"], end["day"])
        fit = (sums.later(block["coarse"], len(shape), days) for block in (one, other))
        before, after = (np.einsum("ij,j->i", part, shape) for part in fit)
        gain = np.concatenate(([0.0], np.cumsum(before - after)))
        day = int(one["day"] + np.argmax(gain))
        hour = HOUR * float(np.sign(other["late"] - one["late"]))
        jumps.append({"day": day, "seconds": sums.begin(day), "by": hour})
    return jumps


def unmixed(blocks: list, limits: Limits) -> list:
    """The blocks but those with days before and after a change of an hour."""

    def is_mixed(*late: float) -> bool:
        moves = np.diff(late)
        moved = moves.sum()
        one_hour = abs(abs(moved) - HOUR) < limits.min_noon_error
        return bool(one_hour and (np.sign(moved) * moves > limits.min_noon_error).all())

    late = [block["late"] for block in blocks]
    mixed = [False, *map(is_mixed, late, late[1:], late[2:]), False]
    return [block for block, out in zip(blocks, mixed) if not out]


def judge(
    origin: pd.Timestamp,
    seconds: np.ndarray,
    sums: Sums,
    blocks: list,
    changes: list,
    limits: Limits,
    far: float = 0.0,
) -> Clock:
    """The line through the blocks, hours apart, and what is wrong with it."""
    hours = hours_of(blocks, changes)
    blocks, middle = pd.DataFrame(blocks), float(seconds[-1] / 2)
    blocks["late"] += far
    late = blocks["late"] - offsets(hours, blocks["seconds"])
    days = (blocks["seconds"] - middle) / DAY
    points = (days.to_numpy(), late.to_numpy(), blocks["stderr"].to_numpy())
    value, stderr, drift, drift_stderr, centre, rest = line_of_blocks(*points, limits)
    limit, faults, of_means = sums.step + limits.onset_tolerance, {}, np.nan
    gained = drift * seconds[-1] / DAY / 60
    if 60 * abs(gained) > limit and abs(drift) > sure(rest - 1, limits) * drift_stderr:
        value -= drift * centre
        verb = "gains" if drift > 0 else "loses"
        faults["clock_drift"] = (
            f"the clock of temp_module {verb} {abs(drift):.1f} ± {drift_stderr:.1f} s "
            f"every day, {abs(gained):.0f} min over the record"
        )
    if abs(value) > limit and abs(value) > sure(rest, limits) * stderr:
        faults["clock_shift"] = shift_line(value, stderr, limit)
        later = [one() + far for one in blocks["of_means"]] - blocks["late"]
        of_means = float(value + np.median(later))
    jumps = tuple((day_of(origin, c["seconds"]), c["by"]) for c in changes)
    if jumps:
        faults["dst"] = (
            f"the clock of temp_module jumps by {listed_jumps(jumps)}, as "
            "daylight-saving time does"
        )
    blocks["start"] = [day_of(origin, sums.begin(day)) for day in blocks["day"]]
    return Clock(
        float(value),
        float(stderr),
        float(drift),
        float(drift_stderr),
        blocks[["start", "seconds", "late", "stderr"]],
        jumps,
        faults,
        "; ".join(faults.values()),
        middle,
        hours,
        limit,
        of_means,
    )


def shift_line(late: float, stderr: float, limit: float) -> str:
    """A clock that is out by the same all the time, in words."""
    return (
        f"timestamps of temp_module run {abs(late) / 60:.1f} ± "
        f"{error_with_step(stderr, limit) / 60:.1f} min {side_of(late)} those of "
        "poa_global"
    )


def line_of_blocks(
    x: np.ndarray, y: np.ndarray, stderr: np.ndarray, limits: Limits
) -> tuple:
    """Mean and slope of blocks with their errors, their centre, and how many more."""
    if len(x) > 3:  # blocks that are out of line by an accident do not count
        off = y - theilslopes(y, x).slope * x
        usual = max(median_abs_deviation(off), limits.min_block_error)
        # twice the standard deviations that are sure, of 1.48 median deviations
        kept = (
            np.abs(off - np.median(off))
            <= 2 * 1.4826 * limits.min_standard_errors * usual
        )
        x, y, stderr = x[kept], y[kept], stderr[kept]
    stderr = np.hypot(stderr, limits.min_block_error)
    weight, rest = stderr**-2, len(x) - 1
    centre, mean = (np.average(v, weights=weight) for v in (x, y))
    x, y = x - centre, y - mean
    squares = weight @ x**2
    if rest < 2 or not squares > 0:
        spread = max(weight @ y**2 / max(rest, 1), 1.0)
        error = np.sqrt(spread / weight.sum())
        return mean, error, np.nan, np.nan, centre, rest
    slope = weight @ (x * y) / squares
    spread = max(weight @ (y - slope * x) ** 2 / (rest - 1), 1.0)
    error, slope_error = np.sqrt(spread / weight.sum()), np.sqrt(spread / squares)
    return mean, error, slope, slope_error, centre, rest


def error_with_step(stderr: float, limit: float) -> float:
    """
    Error of a clock with that of the unknown time of a row in its step.

    Parameters
    ----------
    stderr : float
        Standard error of the clock. [s]
    limit : float
        Step of the rows and slack of a contact sensor, over which the unknown time is
        distributed evenly: ``Clock.limit``. [s]

    Returns
    -------
    float
        Root of the sum of squares. [s]
    """
    return np.hypot(stderr, limit / np.sqrt(12.0))


def sure(rest: int, limits: Limits) -> float:
    """Standard errors that are three of a long record, by what was left over."""
    return student.ppf(norm.cdf(limits.min_standard_errors), max(rest, 2))
