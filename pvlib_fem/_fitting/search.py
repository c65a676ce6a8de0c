"""Least squares of one thermal model on some rows of a record."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from pvlib_fem._fitting.time_constant import IdentityCoordinate, Lag, lag
from pvlib_fem._record.checks import is_number
from pvlib_fem._record.inputs import Record
from pvlib_fem._spelling import FIXED, ShellText, did_you_mean, refusal
from pvlib_fem._statistics.leastsquares import descent
from pvlib_fem._thermal.model import MEMORY, ThermalModel
from pvlib_fem.effects._effect import linearised

TURNS = 3  # searches at most, if the bounds depend on the minimum


def with_fixed(model: ThermalModel, fixed: Mapping) -> ThermalModel:
    """
    The model with held coefficients.

    Parameters
    ----------
    model : ThermalModel
        The model to fit.
    fixed : dict
        Coefficients and constants to hold, by name.

    Returns
    -------
    ThermalModel
        With these as ``held``.

    Raises
    ------
    ValueError
        See :func:`checked_fixed`.
    """
    return replace(model, held=checked_fixed(model, fixed))


def checked_fixed(model: ThermalModel, fixed: Mapping) -> dict:
    """
    The coefficients to hold, checked by name and range.

    Parameters
    ----------
    model : ThermalModel
        The model to fit.
    fixed : dict
        Coefficients and constants of the steady model, by name.

    Returns
    -------
    dict
        Name to float.

    Raises
    ------
    ValueError
        If a name is unknown, a value is no number or out of its range, a constant
        without a default is missing, or no coefficient remains to be fitted.
    """
    constants = model.steady_model.constants
    rows = {**model.parameters, **constants}
    if unknown := [name for name in fixed if name not in rows]:
        raise refusal(
            FIXED,
            f" has {', '.join(unknown)}, which is no coefficient here"
            f"{did_you_mean(unknown, rows)}; there are {', '.join(rows)}",
        )
    if wrong := [name for name, value in fixed.items() if not is_number(value)]:
        raise refusal(
            FIXED,
            f" has {wrong[0]} = {fixed[wrong[0]]!r}, which must be a number "
            f"[{rows[wrong[0]].unit}]",
        )
    held = {name: float(value) for name, value in fixed.items()}
    for name, value in held.items():
        row, whole = rows[name], 1.0
        if row.share_of is not None:
            whole = held.get(row.share_of, rows[row.share_of].upper)
        if not row.lower * whole <= value <= row.upper * whole:
            raise refusal(
                ShellText(f"fixed {name} = {value:g}", f"--fix {name}={value:g}"),
                f" {row.unit} cannot be; it is from {row.lower * whole:g} to "
                f"{row.upper * whole:g}",
            )
    known = model.steady_model.fixed | held
    if missing := [name for name in constants if name not in known]:
        raise refusal(
            f"{model.steady_model.name} needs {', '.join(missing)}; give it as ",
            ShellText(f"fixed={{'{missing[0]}': ...}}", f"--fix {missing[0]}=NUMBER"),
        )
    if not set(model.parameters) - set(held):
        raise refusal(FIXED, " holds all coefficients; leave one to fit")
    return held


def search_stage(
    model: ThermalModel, source: Any, start: dict, biased: bool, flat: float
) -> Any:
    """
    Least squares of one stage, in search coordinates, as a generator.

    Parameters
    ----------
    model : ThermalModel
        Of the stage.
    source : Source
        Only its ``step`` [s] and ``wind`` [m/s] are used.
    start : dict
        Coefficients at which the search starts, as it varies them.
    biased : bool
        Whether the bias is fitted.
    flat : float
        Relative decrease of the cost that ends the search. [-]

    Returns
    -------
    Minimum, dict
        The minimum in search coordinates, and the coefficients at it as the search
        varies them, with shares of others.

    Yields
    ------
    dict, list of str
        Coefficients to evaluate, and the names of those that vary.

    Receives
    --------
    Normal
        Sums of the slopes by these names, and the residual.
    """
    names = [name for name in model.free if biased or name != "bias"]
    places = [list(model.parameters).index(name) for name in names]
    views = [search_coordinate(model, source, start, name) for name in names]

    def searched(x: np.ndarray) -> Any:
        values = (one.from_search(value) for one, value in zip(views, x.tolist()))
        return {**start, **dict(zip(names, values))}

    for _ in range(TURNS):
        search = descent(
            [one.to_search(max(start[n], one.lower)) for n, one in zip(names, views)],
            [one.to_search(one.lower) for one in views],
            [one.to_search(model.parameters[n].upper) for n, one in zip(names, views)],
            flat=flat,
            positive=[name in MEMORY[model.dynamics] for name in names],
        )
        try:
            x = next(search)
            while True:
                coefficients, chain = natural_coefficients(model, searched(x))
                chain[:, places] *= [one.slope(value) for one, value in zip(views, x)]
                sums = yield coefficients, names
                # chain rule: a share moves with its whole, a time constant with its age
                x = search.send(sums.by(chain[np.ix_(places, places)]))
        except StopIteration as end:
            minimum = end.value
        best_coefficients = searched(minimum.x)
        # the least capacity that a step resolves depends on the fitted resistance
        again = [
            search_coordinate(model, source, best_coefficients, name) for name in names
        ]
        if not any(
            stays and one.lower < best_coefficients[name]
            for stays, name, one in zip(minimum.at_bound, names, again)
        ):
            break
        start, views = best_coefficients, again
    return minimum, best_coefficients


def search_coordinate(
    model: ThermalModel, source: Any, start: dict, name: str
) -> IdentityCoordinate | Lag:
    """Search coordinate and lower bound of a coefficient."""
    lower = max(model.parameters[name].lower, lower_bound(model, name))
    if name not in MEMORY[model.dynamics]:
        return IdentityCoordinate(lower)
    return lag(model, natural_coefficients(model, start)[0], source.step, source.wind)


def lower_bound(model: ThermalModel, name: str) -> float:
    """Lower bound of a coefficient, given a held share of it."""
    return max(
        (
            model.held[part] / row.upper
            for part, row in model.parameters.items()
            if row.share_of == name and part in model.held
        ),
        default=-np.inf,
    )


def linearised_effects(effects: tuple, record: Record) -> tuple:
    """
    The effects, with linear ones replaced by their slopes on a record.

    Parameters
    ----------
    effects : tuple of Effect
        Of a model.
    record : Record
        With their drivers.

    Returns
    -------
    tuple of Effect
        In the same order.
    """
    return tuple(linearised(effect, record.inputs.columns) for effect in effects)


def with_tables(model: ThermalModel, record: Record) -> ThermalModel:
    """
    The model, with linear effects replaced by their slopes on a record.

    Parameters
    ----------
    model : ThermalModel
        The model to fit.
    record : Record
        With the drivers of its effects.

    Returns
    -------
    ThermalModel
        For the rows of this record alone.
    """
    return replace(model, effects=linearised_effects(model.effects, record))


def natural_coefficients(
    model: ThermalModel, searched: dict
) -> tuple[dict[str, float], np.ndarray]:
    """
    Coefficients from those with shares, and the Jacobian of that map.

    Parameters
    ----------
    model : ThermalModel
        With n parameters.
    searched : dict
        Values of the parameters; one that is a ``share_of`` another is divided by it.

    Returns
    -------
    values : dict
        Coefficients and constants, held ones at their held values.
    chain : numpy.ndarray, shape (n, n)
        Slope of each coefficient, by row, by each searched one, by column.
    """
    names = list(model.parameters)
    values = {**{name: searched[name] for name in names}, **held_coefficients(model)}
    chain = np.eye(len(names))
    for i, (name, row) in enumerate(model.parameters.items()):
        if row.share_of is not None and name not in model.held:
            whole = values[row.share_of]
            values[name] = searched[name] * whole
            chain[i, i] = whole
            chain[i, names.index(row.share_of)] = searched[name]
    return {**values, **model.constants}, chain


def as_searched(model: ThermalModel, coefficients: dict) -> dict:
    """
    Coefficients with shares of others as the search varies them.

    Parameters
    ----------
    model : ThermalModel
        The model.
    coefficients : dict
        Of all its parameters.

    Returns
    -------
    dict
        The inverse of :func:`natural_coefficients`.
    """
    return {
        name: coefficients[name] / (coefficients[row.share_of] if row.share_of else 1.0)
        for name, row in model.parameters.items()
    }


def held_coefficients(model: ThermalModel) -> dict:
    """Held coefficients of a model, without its constants."""
    return {n: value for n, value in model.held.items() if n in model.parameters}
