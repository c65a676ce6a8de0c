"""The probability that a candidate is there, by its size and the noise."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pvlib_fem._loop.design import Design, place_of
from pvlib_fem.effects._effect import Parameter

if TYPE_CHECKING:
    from pvlib_fem._loop.dictionary import Candidate

SIZES = 4.0  # standard deviations of sizes between the bounds of a coefficient
SLACK_ERRORS = 2.0  # standard errors by which a tangent may miss a bound
SLACK = 0.35  # share of a bound by which it may: a tangent is bent where it is large


def log_odds(probability: float) -> float:
    """
    Logarithm of the odds of a probability.

    Parameters
    ----------
    probability : float
        One that is rounded to 1 counts as 1 − ε.

    Returns
    -------
    float
    """
    least = np.finfo(float).eps
    probability = float(np.clip(probability, least, 1.0 - least))
    return float(np.log(probability / (1.0 - probability)))


def rows_of(one: "Candidate", design: Design) -> list[Parameter]:
    """
    Rows of the parameters of a candidate's columns.

    Parameters
    ----------
    one : Candidate
        An effect, or a change at its dates.
    design : Design
        The design that has its columns.

    Returns
    -------
    list of Parameter
        One for each column of the candidate; all of an effect with a sensor fault.
    """
    rows = one.effect.rows()
    if one.effect.sensor_fault:
        return [*rows.values()]
    return [rows[design.names[place_of(column)]] for column in one.columns]


def within_bounds(
    rows: Sequence[Parameter], estimate: np.ndarray, stderr: np.ndarray
) -> bool:
    """
    Whether coefficients are within their bounds, to first order.

    Parameters
    ----------
    rows : sequence of Parameter
        Of the coefficients.
    estimate, stderr : array, shape (coefficients,)

    Returns
    -------
    bool
    """

    def slack(bound: float, error: float) -> float:
        return max(SLACK_ERRORS * error, SLACK * abs(bound))

    return all(
        row.lower - slack(row.lower, error)
        <= value
        <= row.upper + slack(row.upper, error)
        for row, value, error in zip(rows, estimate, stderr)
    )


def probability_of_existence(
    one: "Candidate",
    rows: Sequence[Parameter],
    estimate: np.ndarray,
    covariance: np.ndarray,
    freedom: float,
) -> float:
    """
    Probability that a candidate is there, by its estimate and its error alone.

    Wakefield's approximate Bayes factor, with the tails of Student's law for so many
    weeks.

    Parameters
    ----------
    one : Candidate
    rows : sequence of Parameter
        Of its coefficients.
    estimate : array, shape (coefficients,)
    covariance : array, shape (coefficients, coefficients)
        That the estimate would have by accident.
    freedom : float
        Of the covariance.

    Returns
    -------
    float
    """
    plain, wide, volume = squared_distances(rows, estimate, covariance)
    tails = np.log1p(plain / freedom) - np.log1p(wide / freedom)
    log_factor = -0.5 * volume + 0.5 * (freedom + len(estimate)) * tails
    log_odds = log_factor + one.log_prior - one.log_dates
    return float(1.0 / (1.0 + np.exp(-np.clip(log_odds, -500.0, 500.0))))


def squared_distances(
    rows: Sequence[Parameter], estimate: np.ndarray, covariance: np.ndarray
) -> tuple[float, float, float]:
    """
    Squared distances of an estimate from nothing, and how much broader one is.

    By the covariance, and by that with the prior of its size.

    Returns
    -------
    plain, wide : float
        Squared distance by each. [-]
    volume : float
        Logarithm of the ratio of their determinants.
    """
    widths = np.array([(row.upper - row.lower) / SIZES for row in rows])
    scale = np.sqrt(np.diag(covariance))
    inner = covariance / np.outer(scale, scale) + 1e-9 * np.eye(len(scale))
    sizes, mean = np.diag(np.square(widths / scale)), estimate / scale
    plain = float(mean @ np.linalg.solve(inner, mean))
    wide = float(mean @ np.linalg.solve(inner + sizes, mean))
    _, volume = np.linalg.slogdet(np.eye(len(mean)) + np.linalg.solve(inner, sizes))
    return plain, wide, volume


def size_seen(
    one: "Candidate",
    rows: Sequence[Parameter],
    way: np.ndarray,
    covariance: np.ndarray,
    freedom: float,
    probability: float,
) -> float:
    """
    How many times an estimate has to be to be there with a probability.

    Parameters
    ----------
    one : Candidate
        Candidate with its prior odds.
    rows : sequence of Parameter
        Of its coefficients.
    way : array, shape (coefficients,)
        The estimate.
    covariance : array, shape (coefficients, coefficients)
        That the estimate would have by accident.
    freedom : float
        Of the covariance. [weeks]
    probability : float
        Least probability, see :func:`existence`.

    Returns
    -------
    float
        Factor of the estimate; infinite if no size is enough.
    """
    plain, wide, volume = squared_distances(rows, way, covariance)
    log_factor = log_odds(probability) - one.log_prior + one.log_dates + 0.5 * volume
    # existence, solved for the square of the size
    ratio = np.exp(min(2.0 * log_factor / (freedom + len(way)), 500.0))
    if plain <= wide * ratio:
        return np.inf
    return float(np.sqrt(freedom * max(ratio - 1.0, 0.0) / (plain - wide * ratio)))
