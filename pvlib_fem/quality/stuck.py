"""A sensor that stands still while what moves it moves."""

import numpy as np
import pandas as pd

from pvlib_fem.quality.clock import HOUR
from pvlib_fem.quality.noon import LIGHT
from pvlib_fem.quality.onset import DAY
from pvlib_fem.record.checks import POSSIBLE
from pvlib_fem.relaxation import ewm

TAU = 378.0  # s, a module's memory: what irradiance it has felt
LEAST = 5  # rows that are the same
HALF_HOUR, NIGHT, CALM = 1800.0, 3 * HOUR, 3 * DAY  # s
FELT = 100.0  # W/m², 2 to 6 K of a module
FINE = 0.1  # K; a coarser sensor may stand still for that much longer
WARMED = 10.0  # K of over-temperature, which takes some 300 W/m²


def stuck(record) -> dict[str, np.ndarray]:
    """
    Rows in which a sensor stands still while what moves it moves.

    A value that repeats for more than 30 min and 5 rows is no sign by itself: a
    night is still, a calm is long. It counts where

    * ``temp_module`` has felt irradiance change by 100 W/m², or the air by 1 K and
      more over 3 h; at 0 °C, where snow melts, only after a day, and at a resolution
      coarser than 0.1 K after that much longer than 30 min;
    * ``temp_air`` has seen irradiance change by 300 W/m² and the module by 10 K
      for 3 h;
    * ``poa_global`` stays while the module's over-temperature changes by 10 K, in the
      dark (20 W/m²) for more than a day;
    * ``wind_speed`` is not 0 for 6 h, or 0 for three days.

    Parameters
    ----------
    record : Record
        From ``records.measured``.

    Returns
    -------
    dict
        Column to an array of booleans.

    Notes
    -----
    Only the resolution of the columns enters; a smooth column cannot repeat.
    """
    seconds = record.inputs.seconds
    poa, air, wind, module = (record[name] for name in POSSIBLE)
    felt = ewm(pd.Series(poa, record.index), TAU).to_numpy()

    def rows(values, judge):
        first, count = runs(values)
        last = first + count - 1
        lasts = seconds[last] - seconds[first]
        some = (count > LEAST) & (lasts > HALF_HOUR) & np.isfinite(values[first])
        first, last, lasts = first[some], last[some], lasts[some]
        spread = lambda other: extent(other, first, last)  # noqa: E731
        return between(first, last, judge(values[first], lasts, spread), len(values))

    step = resolution(air) + resolution(module)
    return {
        "poa_global": rows(
            poa,
            lambda v, t, of: (of(module - air) > WARMED) & ((v > LIGHT) | (t > DAY)),
        ),
        "temp_air": rows(
            air, lambda v, t, of: (t > NIGHT) & (of(poa) > 300) & (of(module) > WARMED)
        ),
        "wind_speed": rows(wind, lambda v, t, of: t > np.where(v > 0, 2 * NIGHT, CALM)),
        "temp_module": rows(
            module,
            lambda v, t, of: (
                ((of(felt) > FELT) | ((t > NIGHT) & (of(air) > 1.0 + 2 * step)))
                & ((np.abs(v) > 0.5) | (t > DAY))
                & (t > HALF_HOUR * resolution(module) / FINE)
            ),
        ),
    }


def runs(values):
    """First row and length of each run of one value; a NaN is a run of its own."""
    first = np.flatnonzero(np.concatenate(([True], values[1:] != values[:-1])))
    return first, np.diff(first, append=len(values))


def extent(values, first, last):
    """Largest less smallest value from each first to its last row; 0 without one."""
    if not len(first):
        return np.zeros(0)
    # reduceat takes pairs of rows and what is between the pairs, which is left out
    pairs = np.column_stack((first, last)).ravel()
    low = np.fmin.reduceat(values, pairs)[::2]
    return np.nan_to_num(np.fmax.reduceat(values, pairs)[::2] - low)


def between(first, last, kept, rows):
    """Booleans that are True in the kept runs."""
    edge = np.zeros(rows + 1, dtype=int)
    edge[first[kept]] += 1
    edge[last[kept] + 1] -= 1
    return np.cumsum(edge[:-1]) > 0


def resolution(values):
    """Smallest change of a column; 0 of one that never changes."""
    change = np.abs(np.diff(values))
    return float(change[change > 1e-9].min(initial=np.inf)) % np.inf


def stuck_line(record, frozen):
    lines = []
    for name, rows in frozen.items():
        if rows.any():
            at = int(np.argmax(rows))
            lines.append(
                f"{name} stands still at {record[name][at]:g} from {record.index[at]} "
                f"on, {rows.sum()} rows in all"
            )
    return "; ".join(lines) + ": they are not used; look at sensor and logger"
