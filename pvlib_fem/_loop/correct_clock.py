"""A clock that is off: corrected before any effect is weighed, if that holds."""

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from pvlib_fem._findings import Check, Correction
from pvlib_fem._loop.refit_checks import rise_check, rise_of_error
from pvlib_fem.quality._module_lag import Clock, error_with_step
from pvlib_fem.reasons import Reason, because

if TYPE_CHECKING:
    from pvlib_fem._loop.divided_record import Case
    from pvlib_fem._loop.refits import Fits, Step


def module_clock(
    case: "Case", fits: "Fits", raw: "Step", fits_of: Callable[["Case"], "Fits"]
) -> tuple["Fits", "Step", Correction]:
    """
    The module's record re-timed, and the same model fitted to it.

    Parameters
    ----------
    case : Case
    fits : Fits
        Of the record as it came.
    raw : Step
        The model on it.
    fits_of : callable
        Case to Fits.

    Returns
    -------
    Fits, Step, Correction
        The fits and the step to go on from: of the corrected record, unless its
        error is larger.
    """
    other = fits_of(case.corrected())
    step = other.fitted(raw.model, raw).as_base()
    rows = case.fitting
    both = np.isfinite(raw.temperature + step.temperature)
    both &= np.isfinite(raw.measured + step.measured)
    before, after = (s.error(rows & both) for s in (raw, step))
    check, _ = rise_check(*rise_of_error(case, raw, step))
    correction = clock_correction(case.clock, before, after, check)
    if check.passed:
        return other, step, correction
    untouched = replace(case, clock=Clock())
    return fits_of(untouched), raw, correction


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
    why = because(Reason.CORRECTED, fault=words)
    if not check.passed:
        remedy = "the fitting weeks contradict it; look at the logger's clock"
        why = because(Reason.NOT_CORRECTED, fault=words, remedy=remedy)
    return Correction(
        fault="+".join(clock.faults),
        columns=("temp_module",),
        values=values,
        stderr=stderr,
        before=before,
        after=after,
        unit="K",
        because=why,
        checks=(check,),
        applied=check.passed,
    )
