"""A sensor that stands still while what moves it moves."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from pvlib_fem.quality.limits import POSSIBLE, Limits
from pvlib_fem.quality.values import never_moves, resolution
from pvlib_fem.relaxation import ewm


@dataclass(frozen=True, eq=False)
class Runs:
    """Stretches of one value that are too long to be an accident."""

    value: np.ndarray
    first: np.ndarray  # row
    last: np.ndarray  # row
    time: np.ndarray  # from the first to the last row [s]

    def extent(self, other):
        """Largest less smallest value of another column in each; 0 without one."""
        if not len(self.first):
            return np.zeros(0)
        # reduceat takes pairs of rows and what is between the pairs, which is left out
        pairs = np.column_stack((self.first, self.last)).ravel()
        low = np.fmin.reduceat(other, pairs)[::2]
        return np.nan_to_num(np.fmax.reduceat(other, pairs)[::2] - low)

    def within(self, seconds, margin):
        """The same without some time at either end; none shorter than a row."""
        first = np.searchsorted(seconds, seconds[self.first] + margin)
        first = np.minimum(first, self.last)  # a run at the record's end may be shorter
        last = np.searchsorted(seconds, seconds[self.last] - margin, "right") - 1
        return Runs(self.value, first, np.maximum(first, last), self.time)

    def rows(self, kept, rows):
        """Booleans that are True in the kept runs."""
        if not kept.any():
            return np.zeros(rows, dtype=bool)
        edge = np.zeros(rows + 1, dtype=int)
        edge[self.first[kept]] += 1
        edge[self.last[kept] + 1] -= 1
        return np.cumsum(edge[:-1]) > 0


def stuck(record, limits=None) -> dict[str, np.ndarray]:
    """
    Rows in which a sensor stands still while what moves it moves.

    A value that repeats for more than 30 min and 5 rows is no sign by itself: a
    night is still, a calm is long. It counts where

    * ``temp_module`` has felt irradiance change by 100 W/m², or the air by 1 K and
      more over 3 h; at 0 °C, where snow melts, only after a day, and at a resolution
      coarser than 0.1 K after that much longer than 30 min;
    * ``temp_air`` has seen irradiance change by 300 W/m² and the module by 10 K
      for 3 h;
    * ``poa_global`` stays while the module's over-temperature changes by 10 K; in the
      dark (20 W/m²) for more than a day, or more than two hours from either end,
      above the air, and by the module's own warmth;
    * ``wind_speed`` is not 0 for 6 h, or 0 for three days;
    * further columns are ``relative_humidity`` below 98 %, ``longwave_down``, or
      ``p_dc`` and ``precipitation`` that are not 0, for a day; ``wind_direction`` for
      three. Other columns may stay, as a timetable does.

    Parameters
    ----------
    record : Record
        With the four columns that every fit needs.
    limits : Limits, optional
        The thresholds; those above by default.

    Returns
    -------
    dict
        Column to an array of booleans.

    Notes
    -----
    Only the resolution of the columns enters; a smooth column cannot repeat. A
    missing value ends a repetition, but in a column that has one value only, and in
    wind at 0: of a record by day alone that may be weeks. There the measured time
    counts.
    """
    limits = limits or Limits()
    seconds = record.inputs.seconds
    columns = record.inputs.columns.only(POSSIBLE)
    steps = {}
    found = dict.fromkeys(POSSIBLE, np.zeros(len(seconds), dtype=bool))
    for name, still in STILL.items():
        values = columns[name]
        repeated = runs(values, seconds, limits)
        if name == "wind_speed":
            found[name] = becalmed(values, seconds, limits)
        if not len(repeated.first):
            continue
        if name == "temp_module":
            columns |= {"felt": felt(record, limits)}
            steps = {n: resolution(record[n]) for n in ("temp_air", "temp_module")}

        def extent(other, margin=0.0, repeated=repeated, columns=columns):
            some = repeated.within(seconds, margin) if margin else repeated
            return some.extent(seen_by(other, columns))

        kept = still(repeated, extent, steps, limits)
        if not kept.any():
            continue
        rows = repeated.rows(kept, len(values)) & np.isfinite(values)
        found[name] = found[name] | rows
        # a module that stands still is no witness of what moves it
        columns = columns.put(np.nan, {name: found[name]})
    for name in [name for name in DRIVERS if name in record.inputs.columns]:
        values = record[name]
        if never_moves(values):  # a number that stands for all
            continue
        repeated = runs(values, seconds, limits)
        kept = DRIVERS[name](repeated, limits)
        found[name] = repeated.rows(kept, len(values)) & np.isfinite(values)
    return found


def felt(record, limits):
    """Irradiance as the module feels it, smoothed by its memory. [W/m²]"""
    poa = pd.Series(record["poa_global"], record.index)
    return ewm(poa, limits.felt_memory).to_numpy()


def seen_by(name, columns):
    """A column, or what two of them make: over-temperature, and where it is warm."""
    if name in columns:
        return columns[name]
    over = columns["temp_module"] - columns["temp_air"]
    return over if name == "over" else np.maximum(over, 0.0)


def still_irradiance(runs, extent, steps, limits):
    night = (runs.value <= limits.light) & (runs.time <= limits.still_day)
    # a late clock has the sun at night; frost cools a module, and snow keeps it warm
    warm = extent("warmth", limits.farthest_clock) > limits.warmed
    warm &= extent("temp_module", limits.farthest_clock) > limits.warmed
    return (extent("over") > limits.warmed) & (~night | warm)


def still_air(runs, extent, steps, limits):
    sunny = extent("poa_global") > limits.sunny_change
    warmed = extent("temp_module") > limits.warmed
    return sunny & warmed & (runs.time > limits.still_air)


def still_wind(runs, extent, steps, limits):
    calm = runs.value == 0
    return runs.time > np.where(calm, limits.calm, limits.still_wind)


def still_module(runs, extent, steps, limits):
    of_sun = extent("felt") > limits.felt
    of_air = extent("temp_air") > limits.felt_air + 2 * sum(steps.values())
    of_air &= runs.time > limits.still_air
    melting = (np.abs(runs.value) <= limits.melting) & (runs.time <= limits.still_day)
    coarse = limits.still_time * steps["temp_module"] / limits.fine
    return (of_sun | of_air) & ~melting & (runs.time > coarse)


def still_humidity(runs, limits):
    return (runs.value < limits.saturated) & (runs.time > limits.still_driver)


def still_flow(runs, limits):
    return (runs.value != 0) & (runs.time > limits.still_driver)


def still_vane(runs, limits):
    return runs.time > limits.still_vane


#: the same of further columns, of which the others tell nothing
DRIVERS = {
    "relative_humidity": still_humidity,
    "longwave_down": still_flow,
    "p_dc": still_flow,
    "precipitation": still_flow,
    "wind_direction": still_vane,
}
#: what makes a repetition of each column a fault
STILL = {
    "temp_module": still_module,
    "poa_global": still_irradiance,
    "temp_air": still_air,
    "wind_speed": still_wind,
}


def runs(values, seconds, limits):
    """Repetitions of one value; a NaN ends one, unless there is no other value."""
    if never_moves(values):
        values = np.full(len(values), values[np.isfinite(values)][0])
    same = np.zeros(len(values) + 1, dtype=np.int8)  # as the row before
    np.equal(values[1:], values[:-1], out=same[1:-1].view(bool))
    edge = np.diff(same)
    first, last = np.flatnonzero(edge == 1), np.flatnonzero(edge == -1)
    time = seconds[last] - seconds[first]
    long = (last - first >= limits.still_rows) & (time > limits.still_time)
    first, last = first[long], last[long]
    return Runs(values[first], first, last, time[long])


def becalmed(values, seconds, limits):
    """Rows at 0 for longer than a calm lasts, of which gaps take no time."""
    rows = np.zeros(len(values), dtype=bool)
    calm = np.count_nonzero(values == 0)
    if len(values) < 2 or not calm:
        return rows
    usual = np.median(np.diff(seconds))
    if calm * usual <= limits.calm:
        return rows
    (there,) = np.nonzero(np.isfinite(values))
    steps = np.minimum(np.diff(seconds[there]), usual)
    measured = runs(values[there], np.concatenate(([0.0], np.cumsum(steps))), limits)
    kept = (measured.value == 0) & (measured.time > limits.calm)
    rows[there] = measured.rows(kept, len(there))
    return rows


def refuse_frozen(record, frozen):
    """Refuse a record in which a sensor never moves, so that no row can be used."""
    whole = [
        name for name in frozen if frozen[name].any() and never_moves(record[name])
    ]
    if whole:
        raise frozen_error(whole[0], [whole_line(record, name) for name in whole])


def frozen_error(name, lines):
    """The error of sensors that never move, of which ``name`` is one."""
    return ValueError(
        "; ".join(lines)
        + ", so no row is left; look at sensor and logger, or name the column of a "
        f"sensor that moves as {name}"
    )


def stuck_line(record, frozen):
    """What stands still, from when on and at what, in one line."""
    lines = [one_line(record, name, rows) for name, rows in frozen.items()]
    lines = "; ".join(filter(None, lines))
    return f"{lines}: they are not used; look at sensor and logger"


def one_line(record, name, rows):
    """The same of one column, or nothing where it moves."""
    values = record[name]
    if not rows.any():
        return ""
    if never_moves(values):
        return whole_line(record, name)
    at = int(np.argmax(rows))
    return (
        f"{name} stands still at {values[at]:g} from {record.index[at]} on, "
        f"{rows.sum():,} rows in all"
    )


def whole_line(record, name):
    """The same of a column that never moves."""
    values = record[name]
    seen = np.flatnonzero(np.isfinite(values))
    first, last = record.index[seen[0]], record.index[seen[-1]]
    return standing_line(name, values[seen[0]], first, last)


def standing_line(name, value, first, last):
    return (
        f"{name} stands still at {value:g} for the whole record, from {first} to {last}"
    )
