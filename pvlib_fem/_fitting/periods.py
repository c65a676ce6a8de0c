"""Coefficients per month or any other period, from the daily sums of a fit."""

from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import t as student

from pvlib_fem._fitting.daily import directions, tied_names
from pvlib_fem._fitting.tangent_shift import R_EQ, Minimum, in_time, shifted_numbers
from pvlib_fem._fitting.time_constant import lag
from pvlib_fem._statistics.clusters import (
    FEWEST_DAYS,
    jackknife_covariance,
    submatrices,
)
from pvlib_fem._thermal.model import MEMORY, ThermalModel
from pvlib_fem.effects import several

LEVEL = 0.95  # of the intervals
NUMBERS = ("value", "stderr", "lower", "upper")
DAY = pd.Timedelta(days=1)


def through_time(fit: Any, freq: str, coefficients: Any) -> pd.DataFrame:
    """
    The table of :meth:`FemFit.through_time`.

    Parameters
    ----------
    fit : FemFit
        With daily sums.
    freq : str
        Periods, as an offset of pandas of whole days.
    coefficients : str, sequence of str or None
        Coefficients that vary; None for those of the model without effects.

    Returns
    -------
    pandas.DataFrame
        Rows by ``coefficient`` and ``start``; columns ``value``, ``stderr``, ``lower``,
        ``upper``, ``unit``, ``days`` and ``why``.

    Raises
    ------
    ValueError
        If the fit has no daily sums, ``freq`` is no period, or a name was not fitted.
    """
    minimum = minimum_of(fit, coefficients)
    zone = fit.record.index.tz
    parts = [
        (start, in_period(minimum, days))
        for start, days in periods(minimum.daily.sums.dates, freq, zone)
    ]
    names, starts = list(minimum.units), [start for start, _ in parts]
    # in the order of the fit, not sorted by name
    index = pd.MultiIndex(
        levels=[names, starts],
        codes=[*np.indices((len(names), len(starts))).reshape(2, -1)],
        names=["coefficient", "start"],
    )
    rows = [estimates_by_name[name] for name in names for _, estimates_by_name in parts]
    return pd.DataFrame(rows, index)


def minimum_of(fit: Any, coefficients: dict | None) -> Minimum:
    """The minimum of a fit with daily sums, and the coefficients that vary."""
    if fit.daily is None:
        why = "was read from a file, which holds none"
        if fit.method == "paper":
            why = "is by the paper's recipe, which makes none"
        raise ValueError(
            "coefficients through time need the daily sums of a fit, and this fit "
            f"{why}; fit the record with method='least_squares'"
        )
    model, daily = fit.thermal_model, fit.daily
    completed = model.completed(fit.coefficients)
    return Minimum(
        model,
        completed,
        daily,
        names_of(model, daily.names, coefficients),
        lag(model, completed, fit.step, fit.wind) if MEMORY[model.dynamics] else None,
        fit.step,
    )


def names_of(model: ThermalModel, fitted: tuple, wanted: Any) -> list:
    """The coefficients that vary: by default those of the model without effects."""
    if wanted is None:
        own = [*model.steady_model.parameters, *MEMORY[model.dynamics], "bias"]
        names = [name for name in fitted if name in own]
    else:
        wanted = list(several(wanted))
        if unknown := [name for name in wanted if name not in fitted]:
            raise ValueError(
                f"{', '.join(map(str, unknown))} was not fitted and cannot vary; "
                f"there are {', '.join(fitted) or 'none'}"
            )
        names = [name for name in fitted if name in wanted]
    if not names:
        raise ValueError(
            "no coefficient varies: those of the model are held or at a bound, and "
            f"there are {', '.join(fitted) or 'no others'}"
        )
    return names


def periods(dates: np.ndarray, freq: str, zone: Any) -> Any:
    """Start of each period from the first day to the last, and places of its days."""
    first = pd.Timestamp(2001, 1, 1)
    try:
        offset = pd.tseries.frequencies.to_offset(freq)
        length = first + offset - first
    except (ValueError, TypeError) as error:
        raise ValueError(
            f"freq = {freq!r} is no period of pandas; take 'MS' for months, 'QS' for "
            "quarters, 'W-MON' for weeks or '14D'"
        ) from error
    if length % DAY or length < DAY:
        raise ValueError(
            f"freq = {freq!r} is no whole number of days; take such as '14D'"
        )
    days = pd.DatetimeIndex(dates.astype("datetime64[D]").astype("datetime64[ns]"))
    places = pd.Series(np.arange(len(days)), days)
    for start, part in places.resample(offset, closed="left", label="left"):
        # a clock change may skip or repeat midnight
        there = dict(ambiguous=True, nonexistent="shift_forward")
        begin: Any = start
        yield begin.tz_localize(zone, **there) if zone else begin, part.to_numpy()


def in_period(minimum: Minimum, days: np.ndarray) -> dict:
    """Each coefficient from the days of a period, or why it is not known."""
    units = minimum.units
    numbers, tied = np.full((4, len(units)), np.nan), []
    if len(days) >= FEWEST_DAYS:
        numbers, tied = estimates(minimum, days)
    return {
        name: {
            **dict(zip(NUMBERS, own.tolist())),
            "unit": unit,
            "days": len(days),
            "why": nan_reason(minimum, len(days), name in tied and tied, own),
        }
        for (name, unit), own in zip(units.items(), numbers.T)
    }


def nan_reason(minimum: Minimum, days: int, tied: Any, numbers: np.ndarray) -> str:
    """Why a number is NaN; empty if none is."""
    value, error, *_ = numbers
    if days < FEWEST_DAYS:
        return f"fitted days: {days}, and an error needs {FEWEST_DAYS}"
    if tied:
        return f"the period does not determine {' and '.join(tied)}"
    if np.isnan(value):
        return "so far from the whole fit that no coefficients have it"
    if np.isnan(error):
        return f"steps of {minimum.step:g} s do not tell it from 0 in this period"
    return ""


def estimates(minimum: Any, days: np.ndarray) -> tuple[np.ndarray, list]:
    """Values, errors and intervals of a period, and the undetermined names."""
    shift, covariance, clusters, tied = solution(minimum, days)
    value, slopes, gain = shifted_numbers(minimum, shift)
    error = np.sqrt(np.einsum("ij,jk,ik->i", slopes, covariance, slopes))
    reach = student.ppf(0.5 + LEVEL / 2, clusters - 1) * error
    numbers = np.stack([value, error, value - reach, value + reach])
    for name in minimum.memory:
        place = list(minimum.units).index(name)
        numbers[:, place] = in_time(*[minimum, *numbers[:, place], gain])
    lost = np.array([name in tied for name in minimum.units])
    return np.where(lost, np.nan, numbers), tied


def solution(
    minimum: Minimum, days: np.ndarray
) -> tuple[np.ndarray, np.ndarray, int, list]:
    """Shifts from the fit's minimum, their covariance (CR3), and unknown names."""
    kept = [minimum.daily.names.index(name) for name in minimum.names]
    daily = minimum.daily.sums.on(days)
    weeks, scale = daily.by_week, daily.scale[kept]
    normals = submatrices(weeks, kept)
    inverse, unknown = directions(normals.sum(axis=0))
    shift = inverse @ weeks[:, kept, -1].sum(axis=0)
    scores = weeks[:, kept, -1] - normals @ shift
    covariance = jackknife_covariance(normals, scores, inverse) / np.outer(scale, scale)
    tied = tied_names(minimum.names, unknown)
    if {*tied} & {*minimum.steady}:
        tied.append(R_EQ)
    return shift / scale, covariance, len(weeks), tied
