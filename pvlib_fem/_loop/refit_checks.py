"""Checks of a refit: bounds, certainty, and errors that must not rise."""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from pvlib_fem._findings import Check, Finding
from pvlib_fem._statistics.clusters import FEWEST_CLUSTERS, calendar_weeks
from pvlib_fem.reasons import Because, Reason, because

if TYPE_CHECKING:
    from pvlib_fem._fitting.fem_fit import FemFit
    from pvlib_fem._loop.divided_record import Case
    from pvlib_fem._loop.refits import Step

ERRORS = "standard errors"
SURE = 3.0  # of them, that a coefficient has to be from nothing on the own steps
RISE = 1.0  # of them, by which an error may rise


def check_of_bounds(
    names: Iterable[str], step: "Step | FemFit"
) -> tuple[Check, Because]:
    """
    The check that none of some coefficients is at a bound, and why it fails.

    Parameters
    ----------
    names : iterable of str
        Of the coefficients.
    step : Step or FemFit
        The refit.

    Returns
    -------
    Check
        It passes with no coefficient at a bound.
    Because
        The reason if it fails.
    """
    bound = sorted({*names} & {*step.at_bound})
    return (
        Check("coefficients at a bound", "", len(bound), 0, most=True),
        because(Reason.AT_BOUND, coefficient=", ".join(bound)),
    )


def check_of_certainty(
    finding: Finding, values: Mapping[str, float], stderr: Mapping[str, float]
) -> tuple[Check, Because]:
    """
    The check that its surest coefficient is not nothing, and why it fails.

    Parameters
    ----------
    finding : Finding
        Of which the coefficients are.
    values, stderr : dict
        Coefficients of a fit, and their standard errors.

    Returns
    -------
    Check
        It passes from three standard errors on.
    Because
        The reason if it fails.
    """
    sizes = {n: errors_from_zero(values[n], stderr[n]) for n in finding.coefficients}
    name = max(sizes, key=sizes.__getitem__)
    size, least = sizes[name], SURE
    return (
        Check("distance from nothing", "", size, least, unit=ERRORS),
        because(
            Reason.UNSURE, coefficient=name, value=values[name], error=stderr[name]
        ),
    )


def errors_from_zero(value: float, error: float) -> float:
    """Standard errors from nothing; without an error, or held, it is no doubt."""
    return abs(value) / error if error > 0 else np.inf


def rise_check(errors: float, rise: float) -> tuple[Check, Because]:
    """
    The check that no error rises, and why it fails.

    Parameters
    ----------
    errors : float
        Rise in standard errors, by :func:`rise_of`. [-]
    rise : float
        Rise of the root mean square. [K]

    Returns
    -------
    Check
        It passes up to one standard error.
    Because
        The reason if it fails.
    """
    name, most = "rise of the error", RISE
    return (
        Check(name, "", errors, most, most=True, unit=ERRORS),
        because(Reason.CONTRADICTED, rise=rise, errors=errors),
    )


def rise_of_error(case: "Case", before: "Step", after: "Step") -> tuple[float, float]:
    """
    By how much the error rises from one step to another, on the fitting weeks.

    Parameters
    ----------
    case : Case
        Record of both steps.
    before, after : Step
        Steps with the measured and the modelled temperature of each row.

    Returns
    -------
    (float, float)
        Rise in standard errors [-], and of the root mean square [K], as
        :func:`rise_of`; negative for a fall.
    """
    rows = case.fitting & np.isfinite(before.temperature + after.temperature)
    rows &= np.isfinite(before.measured + after.measured)  # a clock's ends have none
    one, other = (
        (step.measured[rows] - step.temperature[rows]) ** 2 for step in (before, after)
    )
    return rise_of(one, other, np.ones(rows.sum()), case.whole.dates[rows])


def rise_of(
    before: np.ndarray, after: np.ndarray, rows: np.ndarray, dates: np.ndarray
) -> tuple[float, float]:
    """
    The rise of a mean square, from sums of squares over some rows of some dates each.

    Parameters
    ----------
    before, after : array, shape (sums,)
        Sums of squared residuals. [K²]
    rows : array, shape (sums,)
        Number of rows of each.
    dates : array of int, shape (sums,)
        Date of each, from 1970-01-01.

    Returns
    -------
    errors : float
        In standard errors, from the spread between weeks, or days where there are few
        weeks. NaN without rows.
    rise : float
        Of the root mean square. NaN without rows. [K]
    """
    if not len(rows):
        return np.nan, np.nan
    rise = np.sqrt(after.sum() / rows.sum()) - np.sqrt(before.sum() / rows.sum())
    clusters = np.unique(calendar_weeks(dates), return_inverse=True)[1]
    if clusters.max() + 1 < FEWEST_CLUSTERS:
        clusters = np.unique(dates, return_inverse=True)[1]
    change = np.bincount(clusters, after - before)
    size = np.bincount(clusters, rows)
    mean = change.sum() / size.sum()
    count = len(size)
    if count < 2:
        return np.inf * np.sign(mean), float(rise)
    spread = np.sqrt(((change - mean * size) ** 2).sum() * count / (count - 1))
    errors = mean * size.sum() / spread if spread > 0 else np.sign(mean) * np.inf
    return float(errors) if mean else 0.0, float(rise)
