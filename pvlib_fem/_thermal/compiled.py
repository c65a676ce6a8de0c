"""Solve a block of rows with compiled loops, if numba is installed."""

from functools import cache, lru_cache
from importlib.util import find_spec
from typing import Any

import numpy as np

from pvlib_fem._record.inputs import Inputs
from pvlib_fem._thermal.response import Past
from pvlib_fem._thermal.steady_models import SCALES, SteadyModel
from pvlib_fem.effects._effect import FixedTerms, is_there

LONG = 1 << 15  # rows of a record from which the loops save more time than they load
AT_ONCE = 1 << 18  # rows that the loops get at a time
MEMORIES = {"ewm": "tau", "balance": "capacity"}
FAR = 8.0  # m/s, second point of a line in wind; the first is calm air


def uses_compiled_loops(rows: int, effects: tuple, also: Any = None) -> bool:
    """
    Whether the compiled loops can solve a record, and it is long enough to load them.

    Parameters
    ----------
    rows : int
        Number of rows.
    effects : tuple of FixedTerms or LinearisedEffect
        Effects of the model.
    also : dict of Terms, optional
        Slopes of further terms.

    Returns
    -------
    bool
        False without numba.
    """
    if rows < LONG or any(is_beyond_them(effect) for effect in effects):
        return False
    if also and any(is_there(one.capacity) for one in also.values()):
        return False
    return loops() is not None


def is_beyond_them(effect: Any) -> Any:
    """Whether a known effect adds to ``gain`` or ``capacity``, which no loop has."""
    terms = [effect.terms] if isinstance(effect, FixedTerms) else []
    terms += effect.units.values()
    return any(is_there(one.gain) or is_there(one.capacity) for one in terms)


@cache
def loops() -> Any:
    """The compiled loops, loaded at the first call; None without numba."""
    if find_spec("numba") is None:
        return None
    from pvlib_fem._thermal import kernels

    return kernels


def line_of(law: SteadyModel, own: dict) -> tuple[np.ndarray, float, dict]:
    """A steady model as a line in wind on its scale: the line, its clip, its slopes."""
    clip = own[law.clip] if law.clip else np.inf
    winds = np.array([0.0, min(FAR, clip) or FAR])
    r_eq, slopes = law.resistance(winds, **own), law.slopes(winds, **own)
    value, slope = SCALES[law.scale](r_eq)
    ends = [value, *(slope * slopes[name] for name in law.parameters)]
    line, *by = [np.array([e[0], (e[1] - e[0]) / winds[1]]) for e in ends]
    return line, float(clip), dict(zip(law.parameters, by))


def of_terms(slopes: dict, names: list, rows: int) -> tuple:
    """For heat, loss and offset: places of the slopes that add to it, and a table."""
    more = []
    for column in ("heat", "loss", "offset"):
        values = [getattr(slopes[name], column) for name in names]
        there = [place for place, one in enumerate(values) if is_there(one)]
        table = np.empty((len(there), rows + loops().APART))
        for row, place in zip(table, there):
            row[:rows] = values[place]
        more.append((np.array(there, dtype=np.int64), table))
    return tuple(more)


def of_rows(seen: tuple | None, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """The mask of rows that count, by default all, and the measured values."""
    counts, measured = seen or (np.ones(rows, bool), np.nan)
    return counts, loop_column(measured)


def loop_column(column: float | np.ndarray) -> np.ndarray:
    """A column as an array for the loops: of all rows, or of one tile if constant."""
    if np.ndim(column) == 0:
        column = constant_tile(float(column))
    column = np.ascontiguousarray(column, dtype=float).view()
    column.flags.writeable = False  # else numba compiles a version for writable arrays
    return column


@lru_cache(maxsize=16)
def constant_tile(value: float) -> np.ndarray:
    return np.full(loops().TILE, value)


def solve_compiled(
    model: Any,
    inputs: Inputs,
    coefficients: dict,
    past: Past,
    seen: tuple | None = None,
    edges: Any = None,
    into: np.ndarray | None = None,
    also: Any = None,
) -> Any:
    """
    Temperature of a block, and the products of its slopes and residuals.

    Parameters
    ----------
    model, inputs, coefficients, past
        See :meth:`ThermalModel.answer`.
    seen : tuple of array, optional
        Mask of the rows that count, by default all, and the measured temperature.
    edges : array of int, optional
        The first row of each part, from 0 on, and the end of the last. Without it the
        loops compute no products.
    into : array, optional
        Array that the temperature is written to; without it the temperature is
        dropped. It covers all rows if products are computed, else the rows that count.
    also : dict of Terms, optional
        Slopes of further terms; the loops compute the responses to them instead of
        products.

    Returns
    -------
    array or None
        Products over each part, in the order of the model's parameters, the residual
        last. Or the responses to ``also`` on all rows.
    """
    wanted, law = edges is not None, model.steady_model
    added, slopes = model.terms(inputs, coefficients, wanted, also)
    names = [name for name in slopes if name != "bias"]
    line, clip, by = line_of(law, model.steady_coefficients(coefficients))
    size, rows = 5 + len(names), len(inputs["temp_air"])
    if past.state is None:
        past.state = np.zeros((3, size))
    air, wind = inputs["temp_air"], inputs["wind_speed"]
    columns = inputs.steps, air, added.heat, wind, added.loss, added.offset
    kernels = loops()
    if into is None:
        into = np.empty(kernels.TILE)
    total = np.zeros((len(edges) - 1 if wanted else 0, size, size))
    responses = np.empty((len(also or ()), rows))
    memory = coefficients.get(MEMORIES.get(model.dynamics), 1.0) / inputs.unit
    more = of_terms(slopes, names, rows)
    leaky = is_there(added.loss) or len(more[1][0]) > 0
    kernels.solve_rows(
        getattr(kernels, model.dynamics.upper()),
        (law.scale, float(line[0]), float(line[1]), clip),
        (float(memory), float(inputs.unit), float(past.usual), leaky),
        (*map(loop_column, columns), into),
        more,
        of_rows(seen, rows),
        edges if wanted else np.array([0, rows]),
        past.state,
        total,
        responses,
    )
    if not wanted:
        return responses if also is not None else None
    chain = chain_matrix(model, by, names)
    return chain.T @ total @ chain


def chain_matrix(model: Any, by: dict, names: list) -> np.ndarray:
    """Matrix from the columns of the loops to slopes by parameter, and the residual."""
    parameters = list(model.parameters)
    chain = np.zeros((5 + len(names), len(parameters) + 1))
    chain[-1, -1] = 1.0
    for place, name in enumerate(parameters):
        if name in by:
            chain[:2, place] = by[name]
        elif name == "bias":
            chain[3, place] = 1.0
        elif name in names:
            chain[4 + names.index(name), place] = 1.0
        else:
            chain[2, place] = 1.0
    return chain
