"""A clock that is off: corrected before any effect is weighed, if that holds."""

from dataclasses import replace

import numpy as np

from pvlib_fem._findings import Check, Correction
from pvlib_fem._loop.regression.refits import Fits, Step
from pvlib_fem._statistics.clusters import week_numbers
from pvlib_fem.quality._module_lag import Clock, error_with_step
from pvlib_fem.reasons import Reason, because

FALL = 2.0  # standard errors, by which the error has to fall


def module_clock(fits: Fits, raw: Step) -> tuple[Fits, Step, Clock, Correction | None]:
    """
    The module's record re-timed, and the same model fitted to it.

    Temperatures that are means over a step look late by more than half a step, if they
    are read as values at its end. The changes of both columns seldom show which they
    are; the error of the model does.

    Parameters
    ----------
    fits : Fits
        Of the record as it came.
    raw : Step
        The model on it.

    Returns
    -------
    Fits, Step, Clock, Correction or None
        The fits and the step to go on from: of the corrected record, if its error is
        surely smaller; else as given, with a note and no correction. The clock is that
        by which the record was corrected.
    """
    case, clocks = fits.case, [fits.case.clock]
    if "clock_shift" in case.clock.faults and np.isfinite(case.clock.of_means):
        clocks.append(case.clock.by_means)
    others = [Fits(replace(case, clock=one).corrected()) for one in clocks]
    steps = [other.fitted(raw.model, raw).as_base() for other in others]
    rows = case.fitting & np.isfinite(raw.measured + raw.temperature)
    for one in steps:  # a clock's ends have no temperature
        rows = rows & np.isfinite(one.measured + one.temperature)
    best = int(np.argmin([one.error(rows) for one in steps]))
    clock, step = clocks[best], steps[best]
    if not clock.fault:  # of means it is not late
        return Fits(replace(case, clock=clock)), raw, clock, None
    before, after = (one.error(rows) for one in (raw, step))
    squares = [(one.measured - one.temperature)[rows] ** 2 for one in (raw, step)]
    errors = mean_in_errors(squares[0] - squares[1], case.whole.dates[rows])
    check = Check("fall of the error", "", errors, FALL, unit="standard errors")
    if check.passed:
        correction = clock_correction(clock, before, after, check)
        return others[best], step, clock, correction
    note = (
        f"{'; '.join(clock.faults.values())}, by the time at which it answers "
        "irradiance; it is not corrected, since the error is no smaller with that"
    )
    case = replace(case, clock=Clock(), notes=(*case.notes, note))
    return Fits(case), raw, clock, None


def mean_in_errors(fall: np.ndarray, dates: np.ndarray) -> float:
    """A mean in standard errors, by the spread between weeks, or days if few."""
    if not len(fall):
        return np.nan
    clusters = week_numbers(dates)
    change, size = np.bincount(clusters, fall), np.bincount(clusters)
    mean, count = change.sum() / size.sum(), len(size)
    if count < 2:
        return float(np.inf * np.sign(mean))
    spread = np.sqrt(((change - mean * size) ** 2).sum() * count / (count - 1))
    errors = mean * size.sum() / spread if spread > 0 else np.sign(mean) * np.inf
    return float(errors) if mean else 0.0


def clock_correction(
    clock: Clock, before: float, after: float, check: Check
) -> Correction:
    """The correction, in the units of a clock."""
    values: dict[str, float] = {}
    stderr: dict[str, float] = {}
    if {"clock_shift", "clock_drift"} & set(clock.faults):
        values["late"] = clock.late / 60.0
        stderr["late"] = error_with_step(clock.stderr, clock.limit) / 60.0
    if "clock_drift" in clock.faults:
        values["drift"] = clock.drift
        stderr["drift"] = clock.drift_stderr
    if "dst" in clock.faults:
        values["summer"] = max((late for _, late in clock.hours), key=abs) / 60.0
    words = "; ".join(clock.faults.values())
    return Correction(
        fault="+".join(clock.faults),
        columns=("temp_module",),
        values=values,
        stderr=stderr,
        before=before,
        after=after,
        unit="K",
        because=because(Reason.CORRECTED, fault=words),
        checks=(check,),
        applied=True,
    )
