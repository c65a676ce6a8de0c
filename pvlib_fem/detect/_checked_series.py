"""Series as detectors take them: checked, with their times in seconds."""

from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.checks import (
    as_numbers,
    check_order,
    common_index,
    datetime_steps,
    instants,
    no_datetimes,
)


def checked_series(optional: tuple[str, ...] = (), **series: pd.Series | None) -> Any:
    """
    The one index of some Series, and their values.

    Parameters
    ----------
    optional : tuple of str, optional
        Names of those that may be None.
    **series : Series or None

    Returns
    -------
    index : DatetimeIndex
    values : list of array, shape (rows,), or None
        In the order of the arguments.

    Raises
    ------
    TypeError
        If an argument is no Series, or has no DatetimeIndex.
    ValueError
        If the indexes differ, times are not sorted, or a value is infinite or text.
    """
    given = {n: s for n, s in series.items() if s is not None or n not in optional}
    for name, one in given.items():
        if not isinstance(one, pd.Series):
            raise TypeError(
                f"{name} is a {type(one).__name__}; give a pandas Series with a "
                "DatetimeIndex"
            )
        if not isinstance(one.index, pd.DatetimeIndex):
            raise TypeError(no_datetimes(name, one.index))
    index = common_index(given)
    name = f"the index of {next(iter(given))}"
    steps, _ = datetime_steps(index, name)
    if np.ndim(steps):  # else the index says itself that its steps are even
        check_order(steps, index, name)
    values = {name: as_numbers(name, one, index) for name, one in given.items()}
    return index, [values.get(name) for name in series]


def seconds_of(index: pd.DatetimeIndex) -> np.ndarray:
    """
    Times since the first. [s]

    Parameters
    ----------
    index : DatetimeIndex

    Returns
    -------
    array, shape (rows,)
    """
    times = instants(index)
    return (times - times[:1]) / np.timedelta64(1, "s")
