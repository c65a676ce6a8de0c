"""Faults of sensors and loggers, found before any model is fitted.

What is checked needs no thermal model: a sensor that stands still while the others
move, a file whose noon is at one o'clock (`noon`), a module that answers before the
sun asks (`clock`), a driver in another unit (`doubts`).
"""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from pvlib_fem.clock import HOUR, Clock, clock_shift
from pvlib_fem.doubts import doubtful
from pvlib_fem.noon import LIGHT, SolarNoon, solar_noon_shift
from pvlib_fem.onset import DAY
from pvlib_fem.records import POSSIBLE
from pvlib_fem.relaxation import ewm

TAU = 378.0  # s, a module's memory: what irradiance it has felt
LEAST = 5  # rows that are the same
HALF_HOUR, NIGHT, CALM = 1800.0, 3 * HOUR, 3 * DAY  # s
FELT = 100.0  # W/m², 2 to 6 K of a module
FINE = 0.1  # K; a coarser sensor may stand still for that much longer
WARMED = 10.0  # K of over-temperature, which takes some 300 W/m²


@dataclass(frozen=True, eq=False)
class Health:
    """What is wrong with a record before anything is fitted, from :func:`check`."""

    mask: np.ndarray  # True: a row that must not be used
    stuck: dict[str, int]  # rows by column
    clock: Clock
    noon: SolarNoon
    doubtful: dict[str, str]  # drivers that must not be used, and why
    faults: dict[str, str] = field(default_factory=dict)  # name: one line

    @property
    def unchecked(self) -> tuple:
        """What could not be checked, one line each."""
        return () if self.clock.fault else tuple(filter(None, (self.clock.why,)))

    @property
    def notes(self) -> tuple:
        """One line each, with its remedy: the faults, and what was not checked."""
        return (*self.faults.values(), *self.unchecked)


def check(record, location=None, surface_tilt=None, surface_azimuth=None) -> Health:
    """
    Find faults of sensors and loggers in a measured record.

    Parameters
    ----------
    record : Record
        From ``records.measured``, with the drivers that are to be used.
    location : pvlib.location.Location, optional
        For :func:`solar_noon_shift`.
    surface_tilt, surface_azimuth : float, optional
        Of the irradiance sensor. [°]

    Returns
    -------
    Health
        ``faults`` by name: ``stuck``, ``clock_shift``, ``clock_drift``, ``dst``,
        ``file_shift``, ``file_dst``, ``units:<column>``. ``mask`` has the rows of
        stuck sensors; a clock is corrected by ``clock.corrected``.
    """
    frozen = stuck(record)
    mask = np.any(list(frozen.values()), axis=0)
    clock = clock_shift(record, skip=mask)
    noon = solar_noon_shift(
        record["poa_global"], record.index, location, surface_tilt, surface_azimuth
    )
    doubts = doubtful(record.inputs.columns)
    faults = {"stuck": stuck_line(record, frozen)} if mask.any() else {}
    faults |= clock.faults | noon.faults
    faults |= {f"units:{name}": line for name, line in doubts.items()}
    counts = {name: int(rows.sum()) for name, rows in frozen.items()}
    return Health(mask, counts, clock, noon, doubts, faults)


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
