"""Scans of the remaining error for the best of several settings of an effect."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from pvlib_fem._statistics.leastsquares import orthonormal

UNSEEN = 1e-12  # of a tangent's square: its remainder given others, by rounding


def best_setting(
    rest: np.ndarray,
    tangents: dict,
    columns: dict,
    weeks: np.ndarray,
    least: float,
    *,
    parameter: str,
    settings: Sequence[Mapping[str, Any]],
    make: Callable,
) -> Any:
    """
    The effect with that of several settings which explains most of a residual.

    Parameters
    ----------
    rest : array
        Residual of a fit. [K]
    tangents : dict of array
        Responses of the temperature to the effect with each setting, and to all fitted
        coefficients. [K]
    columns : mapping
    weeks : array of int
    least : float
    parameter : str
        Name of those of the effect, without their number.
    settings : sequence of dict
    make : callable
        From a setting, by keyword, to the effect.

    Returns
    -------
    Effect
    """
    names = [f"{parameter}_{i}" for i in range(len(settings))]
    others = [column for name, column in tangents.items() if name not in names]
    mine = (tangents[name] for name in names)
    return make(**settings[best_of(mine, others, rest)])


def best_of(
    columns: Iterable[np.ndarray],
    others: Sequence[np.ndarray],
    rest: np.ndarray,
    either_sign: bool = False,
) -> int:
    """
    Number of the column that explains most of a residual given others.

    Parameters
    ----------
    columns : iterable of array, shape (rows,)
        Of which one at a time is held.
    others : sequence of array, shape (rows,)
    rest : array, shape (rows,)
    either_sign : bool, default False
        Whether a negative coefficient is possible, too.

    Returns
    -------
    int
        The first of columns that explain the same.
    """
    basis = orthonormal([*others])
    along, explained = rest @ basis, []
    for column in columns:
        part, square = column @ basis, column @ column
        beyond = square - part @ part
        score = column @ rest - part @ along if beyond > UNSEEN * square else 0.0
        fall = score * abs(score) / (beyond or 1.0)
        explained.append(abs(fall) if either_sign else fall)
    return int(np.argmax(explained))


def beyond_others(
    tangents: Mapping[str, np.ndarray], names: Sequence[str]
) -> np.ndarray:
    """
    What of some tangents no other one explains, as in a residual without the others.

    Parameters
    ----------
    tangents : dict of array, shape (rows,)
        By name.
    names : sequence of str
        Of some of them.

    Returns
    -------
    array, shape (rows, names)
    """
    mine = np.array([tangents[name] for name in names])
    basis = orthonormal([c for name, c in tangents.items() if name not in names])
    return (mine - (mine @ basis) @ basis.T).T
