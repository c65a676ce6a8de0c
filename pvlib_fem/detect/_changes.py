"""Daily steps and drift of a sensor's reading."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from pvlib_fem._loop.references.deviations import DailyDeviation
from pvlib_fem._statistics.changing_level import YEAR, Law, Path, most_probable

SURE = 3.0  # errors from which a drift or a step is there
EPOCH = pd.Timestamp(0)


@dataclass(frozen=True, eq=False)
class LevelChanges:
    """
    Steps and drift of what a sensor reads, as shares of it.

    Attributes
    ----------
    steps : tuple
        First day of each other level, and by what share it reads more, below 0 where
        less. [-]
    within : tuple
        First and last day on which each step may be, between two days that were
        compared.
    drift, drift_error : float
        By what share it reads more from year to year, and its standard error; NaN
        where only steps are looked for. [1/year]
    level : Series
        For each compared day: its reading by the steps, 1 in the level that
        lasted longest. [-]
    reference : str
        With what it was compared.
    """

    steps: tuple
    within: tuple
    drift: float
    drift_error: float
    level: pd.Series
    reference: str

    @property
    def changed(self) -> pd.Series:
        """Whether the daily reading is another share than for the longest time."""
        return (self.level - 1.0).abs() > 1e-9

    @property
    def changepoints(self) -> pd.Series:
        """Whether another level begins on each day."""
        return pd.Series(
            self.level.index.isin([day for day, _ in self.steps]), self.level.index
        )

    @property
    def drifts(self) -> bool:
        """Whether the drift is three standard errors from none."""
        return bool(abs(self.drift) > SURE * self.drift_error)

    def __str__(self) -> str:
        lines = [f"{day:%Y-%m-%d}  {100 * by:+.0f} %" for day, by in self.steps]
        if np.isfinite(self.drift):
            error = 100 * self.drift_error
            lines.append(f"{100 * self.drift:+.2f} ± {error:.2f} % a year")
        return "\n".join(lines or ["no step"])


def dates_of(days: np.ndarray) -> pd.DatetimeIndex:
    """
    Dates of numbers of days since 1970-01-01.

    Parameters
    ----------
    days : array of int, shape (days,)

    Returns
    -------
    DatetimeIndex
        Midnights without a zone.
    """
    return EPOCH + pd.to_timedelta(np.asarray(days), unit="D")


def level_result(
    days: np.ndarray,
    new: np.ndarray,
    sizes: list | np.ndarray,
    reference: str,
    drift: float = np.nan,
    error: float = np.nan,
    length: int = 1,
) -> LevelChanges:
    """
    Changes from the first row of each new level and the logarithm of each step.

    Parameters
    ----------
    days : array of int, shape (rows,)
        First day of each row, since 1970-01-01.
    new : array of int, shape (steps,)
        First row of each level but the first.
    sizes : list or array of float, shape (steps,)
        Logarithm of each level over the one before. [-]
    reference : str
        With what the sensor was compared.
    drift, error : float, optional
        Drift and its standard error. [1/year]
    length : int, default 1
        Days that a row stands for.

    Returns
    -------
    LevelChanges
    """
    dates, day = dates_of(days), pd.Timedelta(days=1)
    parts = np.searchsorted(new, np.arange(len(days)), side="right")
    level = np.append(0.0, np.cumsum(sizes))
    level = (level - level[np.argmax(np.bincount(parts))])[parts]
    return LevelChanges(
        tuple((dates[i], float(np.expm1(by))) for i, by in zip(new, sizes)),
        tuple((dates[i - 1] + day, dates[i] + (length - 1) * day) for i in new),
        float(drift),
        float(error),
        pd.Series(np.exp(level), dates),
        reference,
    )


def new_levels(path: Path) -> np.ndarray:
    """
    The first row of each level but the first.

    Parameters
    ----------
    path : Path
        Of rows in order of time.

    Returns
    -------
    array of int, shape (steps,)
    """
    return np.flatnonzero(np.diff(path.level)) + 1


def level_changes(one: DailyDeviation, law: Law) -> LevelChanges:
    """
    Steps and drift of a sensor that is compared with something, day by day.

    Steps are those of the most probable path that are three standard errors from
    none. All sizes, the drift and the season are estimated together.

    Parameters
    ----------
    one : DailyDeviation
        By how much the logarithm of the reference is above that of the sensor.
    law : Law

    Returns
    -------
    LevelChanges
    """
    values = np.median(one.apart) - one.apart
    new = new_levels(most_probable(one.days, values, law))
    years = (one.days - one.days[0]) / YEAR
    rows = np.arange(len(values))
    while True:
        steps = [(rows >= i).astype(float) for i in new]
        estimates = [
            one.given_columns([years, *steps[:k], *steps[k + 1 :]]).along(step, values)
            for k, step in enumerate(steps)
        ]
        there = [abs(size) > SURE * error for size, error, _ in estimates]
        if all(there):
            drift, error, _ = one.given_columns(steps).along(years, values)
            sizes = [size for size, *_ in estimates]
            share = np.expm1(drift), np.exp(drift) * error
            return level_result(one.days, new, sizes, one.column, *share)
        weak = min(
            range(len(new)), key=lambda k: abs(estimates[k][0]) / estimates[k][1]
        )
        new = np.delete(new, weak)
