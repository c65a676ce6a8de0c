"""Daily sums at the minimum of a fit, and the standard errors from them."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._statistics.clusters import FEWEST_DAYS, ClusterSums
from pvlib_fem._statistics.daily_memory import DailyMemory, daily_memory
from pvlib_fem._thermal.model import ThermalModel

UNKNOWN = 1e-9  # share of the largest eigenvalue below which a direction is unknown
TIED = 0.1  # component in an unknown direction above which a coefficient is unknown
SAID = 2.0  # ratio to the error of independent days above which a note reports it


@dataclass(frozen=True, eq=False)
class DailySums:
    """Daily sums of the products of a fit's tangents and its residual."""

    names: tuple  # coefficients, one for each tangent
    sums: ClusterSums
    winds: tuple  # mean and spread of the wind, weighted by irradiance squared [m/s]


def standard_errors(
    target: ThermalModel, daily: DailySums, at_bound: tuple, notes: list
) -> dict:
    """
    Standard errors of the coefficients, clustered by day.

    Parameters
    ----------
    target : ThermalModel
        The fitted model.
    daily : DailySums
        At the minimum, of the coefficients that vary.
    at_bound : tuple of str
        Coefficients at a bound of their range; the errors of the others hold them
        fixed.
    notes : list of str
        Notes on unknown and enlarged errors are appended.

    Returns
    -------
    dict
        Parameter to error in its unit; 0 if it is held, and NaN if it is at a bound or
        the error is unknown.
    """
    stderr = {
        **dict.fromkeys(target.parameters, np.nan),
        **{name: 0.0 for name in target.held if name in target.parameters},
    }
    if at_bound:
        notes.append(
            f"at the bound of its range: {', '.join(at_bound)}; the errors of the "
            "others hold it fixed"
        )
    if not daily.names:
        return stderr
    if daily.sums.days < FEWEST_DAYS:
        notes.append(
            f"errors are NaN: the spread between days needs {FEWEST_DAYS} training "
            f"days, and there are {daily.sums.days}"
        )
        return stderr
    # a coefficient without any effect on the record changes no other error
    seen = np.flatnonzero(np.diag(daily.sums.whole)[:-1] > 0.0)
    names, sums = [daily.names[place] for place in seen], daily.sums.of_columns(seen)
    if nothing := [name for name in daily.names if name not in names]:
        notes.append(f"the error is NaN: {undetermined_note(nothing)}")
    _, unknown = directions(sums.whole[:-1, :-1])
    if tied := tied_names(names, unknown):
        notes.append(f"errors are NaN: {undetermined_note(tied)}")
        return stderr
    alone, memory = np.diag(sums.by_day()), daily_memory(sums)
    error = np.sqrt(alone + memory.variance)
    notes += memory_notes(names, error / np.sqrt(alone), memory)
    return {**stderr, **dict(zip(names, error.tolist()))}


def correlation(daily: Any, stderr: dict) -> pd.DataFrame:
    """
    Correlations of the fitted coefficients by the jackknife over days.

    Parameters
    ----------
    daily : DailySums or None
        At the minimum; None if the fit has none.
    stderr : dict
        Standard errors of :func:`standard_errors`.

    Returns
    -------
    pandas.DataFrame, shape (n, n)
        Rows and columns are the coefficients that have an error; may be empty.
    """
    names = daily.names if daily is not None else ()
    known = [place for place, name in enumerate(names) if stderr.get(name, 0.0) > 0.0]
    if not known:
        return pd.DataFrame(dtype=float)
    correlations = daily.sums.of_columns(known).by_day()
    size = np.sqrt(np.diag(correlations))
    correlations = correlations / np.outer(size, size)
    np.fill_diagonal(correlations, 1.0)
    named = [names[place] for place in known]
    # symmetric to the last bit
    return pd.DataFrame((correlations + correlations.T) / 2.0, named, named)


def memory_notes(names: list, times: np.ndarray, memory: DailyMemory) -> Iterator:
    """A note on how much the autocorrelation between days enlarges the errors."""
    if not (more := [n for n, many in zip(names, times) if many >= SAID]):
        return
    note = (
        f"the residual lasts for about {memory.memory:.2g} fitted days: the error of "
        f"{' and '.join(more)} is {max(times):.1f} times that of independent days"
    )
    if not memory.known:
        note += (
            f", and may be larger, since {memory.days} days are too few to tell how "
            "long it lasts; fit a longer record"
        )
    yield note


def undetermined_note(names: list) -> str:
    hint = "" if all("." in name for name in names) else " (does wind_speed vary?)"
    return f"the record does not determine {' and '.join(names)}{hint}"


def directions(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    The pseudo-inverse of a normal matrix, and its unknown directions.

    Parameters
    ----------
    normal : numpy.ndarray, shape (n, n)
        Sums of products of n slopes.

    Returns
    -------
    inverse : numpy.ndarray, shape (n, n)
        Without a component in unknown directions.
    unknown : numpy.ndarray, shape (n, m)
        The m eigenvectors, of slopes scaled to the same square, whose eigenvalue is
        nearly 0.
    """
    size = np.sqrt(np.diag(normal))
    size = np.where(size == 0, 1.0, size)
    values, vectors = np.linalg.eigh(normal / np.outer(size, size))
    known = values > UNKNOWN * values[-1]
    part = vectors[:, known]
    inverse = part / values[known] @ part.T / np.outer(size, size)
    return inverse, vectors[:, ~known]


def tied_names(names: list, unknown: np.ndarray) -> list:
    """
    Names of coefficients that the record determines only in combination.

    Parameters
    ----------
    names : list of str
        The n coefficients.
    unknown : numpy.ndarray, shape (n, m)
        From :func:`directions`.

    Returns
    -------
    list of str
        Names with a component above 0.1 in a direction.
    """
    return [n for n, row in zip(names, np.abs(unknown)) if (row > TIED).any()]
