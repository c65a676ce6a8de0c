"""Columns by their names: which are there, and which can be used."""

import numpy as np
import pandas as pd

#: what every record needs
COLUMNS = ("poa_global", "temp_air", "wind_speed", "temp_module")
DAYLIGHT = 20.0  # W/m², above which it is day
#: where the sun stands and how the module does, under pvlib's names [°]
GEOMETRY = ("solar_zenith", "solar_azimuth", "surface_tilt", "surface_azimuth")
#: other names that pvlib has for a column
ALIASES = {"ir_down": "longwave_down"}
SOME = 20_000  # rows that are enough to compare columns
LEAK = 0.05  # of a column's variance that the answer leaves, where it is a leak
MOST_MISSING = 0.2  # of a driver's rows


def with_aliases(data, needed=COLUMNS):
    """Columns of a frame by the package's names, with those that are needed."""
    columns = {str(name): data[name] for name in data}
    for alias, name in ALIASES.items():
        if alias in columns:
            columns.setdefault(name, columns.pop(alias))
    if missing := [name for name in needed if name not in columns]:
        raise ValueError(
            f"data lack {', '.join(missing)}; they have {', '.join(columns)}"
        )
    return columns


def usable_drivers(columns, usual):
    """Numeric columns that say something of their own, and why others do not."""
    used, refused = {}, {}
    seen = dict(zip(COLUMNS, usual))
    for name, column in columns.items():
        if not pd.api.types.is_numeric_dtype(column):
            refused[name] = f"{name} is not numeric"
        elif np.isinf(column).any():
            refused[name] = f"{name} is infinite at {np.isinf(column).idxmax()}"
        elif column.notna().sum() == 0:
            refused[name] = f"{name} holds no value"
        elif column.isna().mean() > MOST_MISSING:
            refused[name] = f"{column.isna().mean():.0%} of {name} is missing"
        elif column.nunique() < 2 and name not in GEOMETRY:
            refused[name] = f"{name} is constant"
        elif copies := [n for n, other in seen.items() if same(column, other)]:
            refused[name] = f"{name} is a copy of {copies[0]}"
        else:
            used[name] = seen[name] = column.astype(float)
    return used, refused


def same(one, other):
    """Whether one column is another, but for a factor and an offset."""
    some = slice(None, None, max(1, len(one) // SOME))
    return alike(one[some], other[some]) and alike(one, other)


def alike(one, other):
    both = one.notna() & other.notna()
    x, y = one[both].astype(float), other[both].astype(float)
    if both.sum() < 3 or x.std() == 0 or y.std() == 0:
        return False
    return abs(np.corrcoef(x, y)[0, 1]) > 1.0 - 1e-9


def filled(drivers):
    """Drivers without gaps: their median says least where they are missing."""
    return {name: column.fillna(column.median()) for name, column in drivers.items()}


def leaks(record, seen, modelled, names):
    """
    Columns that are the module temperature, or made from it.

    Those that the measured temperature, as it is, a little before and after and
    smoothed, foretells far better than all that a model knows.
    """
    module = pd.Series(record["temp_module"]).interpolate(limit_direction="both")
    near = [module, module.shift(1), module.shift(-1), module.rolling(5, 1).mean()]
    known = [record["poa_global"], record["temp_air"], record["wind_speed"], modelled]
    rows = np.flatnonzero(seen & np.isfinite(modelled))[1:-1]
    rows = rows[:: max(1, len(rows) // SOME)]
    without = np.column_stack([np.ones(len(rows)), *(c[rows] for c in known)])
    with_it = np.column_stack([without, *(c.to_numpy()[rows] for c in near)])
    for name in names:
        column = record[name][rows]
        before, after = (unexplained(column, x) for x in (without, with_it))
        if after < LEAK and after < 0.5 * before:
            yield name


def unexplained(column, others):
    """Share of a column's variance that others leave."""
    found = np.linalg.lstsq(others, column, rcond=None)[0]
    return np.var(column - others @ found) / max(np.var(column), 1e-300)
