"""Scans of the remaining error for the best of several settings of an effect."""

from collections.abc import Callable, Mapping, Sequence
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
    either_sign: bool = False,
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
    either_sign : bool, default False
        Whether a negative coefficient is possible, too.

    Returns
    -------
    Effect
    """
    names = [f"{parameter}_{i}" for i in range(len(settings))]
    mine, basis = mine_and_others(tangents, names)
    part = mine @ basis  # that others explain, which is not formed row by row
    along = mine @ rest - part @ (rest @ basis)
    whole = np.einsum("ij,ij->i", mine, mine)
    squares = whole - np.square(part).sum(axis=1)
    seen = squares > UNSEEN * whole
    sizes = np.where(seen, along, 0.0) / np.where(seen, squares, 1.0)
    explained = sizes * np.abs(along)
    explained = np.abs(explained) if either_sign else explained
    return make(**settings[int(np.argmax(explained))])


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
    mine, basis = mine_and_others(tangents, names)
    return (mine - (mine @ basis) @ basis.T).T


def mine_and_others(
    tangents: Mapping[str, np.ndarray], names: Sequence[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Some tangents, one in each row, and an orthonormal basis of the others."""
    mine = np.array([tangents[name] for name in names])
    return mine, orthonormal([c for n, c in tangents.items() if n not in names])
