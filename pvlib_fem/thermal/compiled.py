"""A block of rows answered by compiled loops, where numba is there."""

from functools import cache, lru_cache
from importlib.util import find_spec

import numpy as np

from pvlib_fem.effects.effect import Known, is_there
from pvlib_fem.thermal.steady import SCALES

LONG = 1 << 15  # rows of a record from which loading the loops is worth it
AT_ONCE = 1 << 18  # rows that the loops are given at a time
MEMORIES = {"ewm": "tau", "balance": "capacity"}
FAR = 8.0  # m/s, where a line in wind is taken beside its value at none


def fast(rows, effects, also=None):
    """Whether a record's rows are answered by the loops, ``also`` by further terms."""
    if rows < LONG or any(is_beyond_them(effect) for effect in effects):
        return False
    if also and any(is_there(one.capacity) for one in also.values()):
        return False
    return loops() is not None


def is_beyond_them(effect):
    """Whether a known effect adds to ``gain`` or ``capacity``, which no loop knows."""
    terms = [effect.terms] if isinstance(effect, Known) else []
    terms += effect.units.values()
    return any(is_there(one.gain) or is_there(one.capacity) for one in terms)


@cache
def loops():
    """The compiled loops, or None without numba; loaded when first asked for."""
    if find_spec("numba") is None:
        return None
    from pvlib_fem.thermal import kernels

    return kernels


def line_of(law, own):
    """A steady model as a line in wind on its scale: its ends, clip, and slopes."""
    clip = own[law.clip] if law.clip else np.inf
    winds = np.array([0.0, min(FAR, clip) or FAR])
    r_eq, slopes = law.resistance(winds, **own), law.slopes(winds, **own)
    value, slope = SCALES[law.scale](r_eq)
    ends = [value, *(slope * slopes[name] for name in law.parameters)]
    line, *by = [np.array([e[0], (e[1] - e[0]) / winds[1]]) for e in ends]
    return line, float(clip), dict(zip(law.parameters, by))


def of_terms(slopes, names, rows):
    """Which of the slopes add to heat, to loss, to offset, and these side by side."""
    more = []
    for column in ("heat", "loss", "offset"):
        values = [getattr(slopes[name], column) for name in names]
        there = [place for place, one in enumerate(values) if is_there(one)]
        table = np.empty((len(there), rows + loops().APART))
        for row, place in zip(table, there):
            row[:rows] = values[place]
        more.append((np.array(there, dtype=np.int64), table))
    return tuple(more)


def of_rows(seen, rows):
    """Which rows count, by default all, and what was measured there."""
    counts, measured = seen or (np.ones(rows, bool), np.nan)
    return counts, whole(measured)


def whole(column):
    """A column as the loops take it: all of its rows, or a number on some, as array."""
    if np.ndim(column) == 0:
        column = constant(float(column))
    column = np.ascontiguousarray(column, dtype=float).view()
    column.flags.writeable = False  # else numba compiles for what may be written, too
    return column


@lru_cache(maxsize=16)
def constant(value):
    return np.full(loops().TILE, value)


def answered(
    model, inputs, coefficients, past, seen=None, edges=None, into=None, also=None
):
    """
    Temperature of a block, and products of its slopes and of what is left.

    Parameters
    ----------
    model, inputs, coefficients, past
        As :meth:`ThermalModel.answer` has them.
    seen : tuple of array, optional
        Which rows count, by default all, and what was measured.
    edges : array of int, optional
        The first row of each part, from 0 on, and the end of the last; without it no
        products are asked for.
    into : array, optional
        Where the temperature goes; without it none is asked for. It is of all rows
        where products are asked for, else of those that count.
    also : dict of Terms, optional
        Slopes of terms to be answered along, in the place of products.

    Returns
    -------
    array or None
        Products over each part, by the model's parameters in order, and what is left.
        Or slopes by what is answered along, on all rows.
    """
    wanted, law = edges is not None, model.steady_model
    added, slopes = model.terms(inputs, coefficients, wanted, also)
    names = [name for name in slopes if name != "bias"]
    line, clip, by = line_of(law, model.own(coefficients))
    size, rows = 5 + len(names), len(inputs["temp_air"])
    if past.state is None:
        past.state = np.zeros((3, size))
    air, wind = inputs["temp_air"], inputs["wind_speed"]
    columns = inputs.steps, air, added.heat, wind, added.loss, added.offset
    kernels = loops()
    if into is None:
        into = np.empty(kernels.TILE)
    total = np.zeros((len(edges) - 1 if wanted else 0, size, size))
    told = np.empty((len(also or ()), rows))
    memory = coefficients.get(MEMORIES.get(model.dynamics), 1.0) / inputs.unit
    more = of_terms(slopes, names, rows)
    leaky = is_there(added.loss) or len(more[1][0]) > 0
    kernels.answer(
        getattr(kernels, model.dynamics.upper()),
        (law.scale, float(line[0]), float(line[1]), clip),
        (float(memory), float(inputs.unit), float(past.usual), leaky),
        (*map(whole, columns), into),
        more,
        of_rows(seen, rows),
        edges if wanted else np.array([0, rows]),
        past.state,
        total,
        told,
    )
    if not wanted:
        return told if also is not None else None
    chain = chained(model, by, names)
    return chain.T @ total @ chain


def chained(model, by, names):
    """How the columns of the loops make slopes by each parameter, and what is left."""
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
