"""Shifts of the level of one stream of irradiance or power."""

import numpy as np
import pandas as pd

from pvlib_fem._record.checks import dates_of
from pvlib_fem._statistics.changing_level import SEASON, YEAR, Law, most_probable
from pvlib_fem.detect._changes import LevelChanges, level_result, new_levels
from pvlib_fem.detect._checked_series import checked_series

WHOLE = 0.8  # of the rows that a day usually has
LOWEST = 1e-3  # of the usual day
WEEK = 7  # days, of which the second best is nearly clear
FEWEST = 5  # of them
LAW = Law(
    np.arange(-3.0, 3.0, 0.05),  # logarithms
    odds=1e-4,  # on a day
    accident=0.1,
    least=0.05,
    fine=0.02,
    memory=2.0,  # weeks
    swing=0.7,
)


def data_shifts(series: pd.Series) -> LevelChanges:
    """
    Days on which the level of a stream of irradiance or power changes for good.

    Parameters
    ----------
    series : Series
        Irradiance, power or energy, in any unit and at any step, daily sums too.

    Returns
    -------
    LevelChanges
        Without a drift.

    Raises
    ------
    TypeError
        If it is no Series with a DatetimeIndex.
    ValueError
        If it is shorter than one and a half years, in which a season is no shift.

    Notes
    -----
    The sum of the second best day of each week has a level that changes seldom
    (Viterbi's path [1]_ of its logarithm), two harmonics of the year, and Laplace's
    noise, that of the weather. So the day of a shift is known to the week. It is the
    task of Perry and Muller [2]_.

    References
    ----------
    .. [1] G. D. Forney, "The Viterbi algorithm", Proc. IEEE 61, 268-278, 1973.
       :doi:`10.1109/PROC.1973.9030`
    .. [2] K. Perry and M. Muller, "Automated shift detection in sensor-based PV power
       and irradiance time series", IEEE Photovoltaic Specialists Conference, 2022, as
       in ``pvanalytics.quality.data_shifts``.

    Examples
    --------
    >>> from pvlib_fem import detect, simulator
    >>> light = simulator.record(days=800, step=3600)["poa_global"]
    >>> stream = light.where(light.index < "2024-03-01", 0.5 * light)
    >>> print(detect.data_shifts(stream))
    2024-02-29  -50 %
    """
    index, (values,) = checked_series(series=series)
    days, place = np.unique(dates_of(index), return_inverse=True)
    known = np.isfinite(values)
    number = np.bincount(place, known)
    sums = np.bincount(place, np.where(known, values, 0.0))
    kept = (number >= WHOLE * np.median(number)) & (sums > 0.0)
    days, sums = days[kept], sums[kept]
    if len(days) < 2 or np.ptp(days) < SEASON * YEAR:
        raise ValueError(
            f"{len(days)} days with light are there, and one and a half years are "
            "needed, since a season is no shift; give a longer record"
        )
    weeks, best = second_best(days, sums)
    logs = np.log(np.maximum(best / np.median(best), LOWEST))
    path = most_probable(weeks, logs, LAW)
    new = new_levels(path)
    parts = np.searchsorted(new, np.arange(len(weeks)), side="right")
    residual = logs - path.usual
    level = np.array([np.median(residual[parts == i]) for i in range(len(new) + 1)])
    return level_result(weeks, new, np.diff(level), "its own season", length=WEEK)


def second_best(days: np.ndarray, sums: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The first day of each week that is there, and the sum of its second best day."""
    week = days // WEEK
    order = np.lexsort((-sums, week))
    _, first, number = np.unique(week, return_index=True, return_counts=True)
    first = first[number >= FEWEST]
    return days[first], sums[order][first + 1]
