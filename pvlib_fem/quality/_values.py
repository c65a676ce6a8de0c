"""How a column's values change, whatever they are."""

import numpy as np

FEW = 1000  # rows, which identify most columns


def changes(values: np.ndarray) -> np.ndarray:
    """
    Sizes of the changes of a column from row to row, where it changes.

    Parameters
    ----------
    values : numpy.ndarray, shape (rows,)
        Changes next to a NaN do not count.

    Returns
    -------
    numpy.ndarray
        In the unit of the column.
    """
    change = np.abs(np.diff(values))
    return change[change > 1e-9]


def never_moves(values: np.ndarray) -> bool:
    """
    Whether a column has one value only, whatever is missing.

    Parameters
    ----------
    values : numpy.ndarray, shape (rows,)
        NaN where it is missing.

    Returns
    -------
    bool
        False of a column without any value.
    """
    for some in (values[:FEW], values):  # of most columns a few rows tell
        seen = some[np.isfinite(some)]
        if len(seen) and np.ptp(seen) > 0:
            return False
    return len(seen) > 0
