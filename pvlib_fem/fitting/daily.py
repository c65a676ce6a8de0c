"""What a fit keeps of every day: sums about its minimum, of which errors are made."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from pvlib_fem.statistics.clusters import FEWEST_DAYS, ClusterSums
from pvlib_fem.statistics.lasting import lasting

UNKNOWN = 1e-9  # share of the largest eigenvalue at which a direction is unknown
TIED = 0.1  # of an unknown direction: what a coefficient has part in it
SAID = 2.0  # times the error of independent days, from which on a note says so


@dataclass(frozen=True, eq=False)
class DailySums:
    """Products of a fit's tangents and its residual, by the day of its rows."""

    names: tuple  # coefficients, one for each tangent
    sums: ClusterSums
    winds: tuple  # mean wind and its spread, where the sun is [m/s]


def errors(target, daily, at_bound, notes):
    """Standard errors by the day, NaN with a note where there are none."""
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
    # of what is nowhere to be seen, as snow that never stays, no other error depends
    seen = np.flatnonzero(np.diag(daily.sums.whole)[:-1] > 0.0)
    names, sums = [daily.names[place] for place in seen], daily.sums.of(seen)
    if nothing := [name for name in daily.names if name not in names]:
        notes.append(f"the error is NaN: {undetermined(nothing)}")
    _, unknown = directions(sums.whole[:-1, :-1])
    if tied := tied_names(names, unknown):
        notes.append(f"errors are NaN: {undetermined(tied)}")
        return stderr
    alone, lasts = np.diag(sums.by_day()), lasting(sums)
    error = np.sqrt(alone + lasts.variance)
    notes += lasting_notes(names, error / np.sqrt(alone), lasts)
    return {**stderr, **dict(zip(names, error.tolist()))}


def correlation(daily, stderr):
    """
    Correlations of the fitted coefficients, from leaving out each day in turn.

    Parameters
    ----------
    daily : DailySums or None
    stderr : dict
        Standard errors, as :func:`errors` has them.

    Returns
    -------
    DataFrame
        Rows and columns are the coefficients that have an error; may be empty.
    """
    names = daily.names if daily is not None else ()
    known = [place for place, name in enumerate(names) if stderr.get(name, 0.0) > 0.0]
    if not known:
        return pd.DataFrame(dtype=float)
    found = daily.sums.of(known).by_day()
    size = np.sqrt(np.diag(found))
    found = found / np.outer(size, size)
    np.fill_diagonal(found, 1.0)
    named = [names[place] for place in known]
    # both halves to the same bits
    return pd.DataFrame((found + found.T) / 2.0, named, named)


def lasting_notes(names, times, lasts):
    """What the residual's memory from day to day makes of the errors, in a sentence."""
    if not (more := [n for n, many in zip(names, times) if many >= SAID]):
        return
    note = (
        f"the residual lasts for about {lasts.memory:.2g} fitted days: the error of "
        f"{' and '.join(more)} is {max(times):.1f} times that of independent days"
    )
    if not lasts.known:
        note += (
            f", and may be larger, since {lasts.days} days are too few to tell how "
            "long it lasts; fit a longer record"
        )
    yield note


def undetermined(names):
    hint = "" if all("." in name for name in names) else " (does wind_speed vary?)"
    return f"the record does not determine {' and '.join(names)}{hint}"


def directions(normal):
    """The inverse of a normal matrix, and the directions in which it has none."""
    size = np.sqrt(np.diag(normal))
    size = np.where(size == 0, 1.0, size)
    values, vectors = np.linalg.eigh(normal / np.outer(size, size))
    known = values > UNKNOWN * values[-1]
    part = vectors[:, known]
    inverse = part / values[known] @ part.T / np.outer(size, size)
    return inverse, vectors[:, ~known]


def tied_names(names, unknown):
    """Those of which only a mixture is known."""
    return [n for n, row in zip(names, np.abs(unknown)) if (row > TIED).any()]
