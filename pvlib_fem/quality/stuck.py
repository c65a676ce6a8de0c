"""A sensor that stands still while what moves it moves."""

from dataclasses import dataclass, field, replace

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
    begin: np.ndarray  # time of the first row
    time: np.ndarray  # from the first to the last row [s]
    odd: np.ndarray  # whether the column's own changes make it far too long

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
        return replace(self, first=first, last=np.maximum(first, last))

    def rows(self, kept, rows):
        """Booleans that are True in the kept runs."""
        if not kept.any():
            return np.zeros(rows, dtype=bool)
        edge = np.zeros(rows + 1, dtype=int)
        edge[self.first[kept]] += 1
        edge[self.last[kept] + 1] -= 1
        return np.cumsum(edge[:-1]) > 0


#: columns whose sensors rest at their lowest value, whatever number that is
FLOWS = ("wind_speed", "precipitation", "p_dc")


@dataclass(eq=False)
class Standing:
    """Long repetitions of a column's value, of rows that come in blocks."""

    name: str
    limits: Limits
    unit: float = 1.0  # of the times [s]
    rows: int = 0  # values that are there
    changes: int = 0  # those of them that are not as the one before
    found: list = field(default_factory=list)
    open: tuple | None = None  # the last one, which may go on

    def add(self, values, start, times):
        """Look at the next rows, the first of which is row ``start``."""
        if not len(values):
            return self
        edges = np.flatnonzero(values[1:] != values[:-1]) + 1
        edges = np.concatenate(([0], edges, [len(values)]))
        goes_on = self.open is not None and self.open[0] == values[0]
        self.rows += np.count_nonzero(np.isfinite(values))
        self.changes += np.count_nonzero(np.isfinite(values[edges[:-1]])) - goes_on
        many = np.flatnonzero(np.diff(edges) > self.limits.few_rows)
        # the first may go on from the rows before, and the last in those that follow
        many = np.union1d(many, [0, len(edges) - 2])
        first, last = edges[many], edges[many + 1] - 1
        runs = [values[first], first + start, last + start, times[first], times[last]]
        if goes_on:
            runs[1][0], runs[3][0] = self.open[1], self.open[3]
        else:
            self.close()
        self.open = tuple(part[-1] for part in runs)
        self.keep(*(part[:-1] for part in runs))
        return self

    def close(self):
        if self.open is not None:
            self.keep(*(np.array([one]) for one in self.open))

    def keep(self, value, first, last, begin, end):
        time = (end - begin) * self.unit
        long = (last - first >= self.limits.few_rows) & (time > self.limits.still_time)
        if long.any():
            self.found.append([x[long] for x in (value, first, last, begin, time)])

    def runs(self, rest):
        """All of them, after the last row, and which are odd for the column."""
        self.close()
        self.open = None
        if not self.found:
            none, rows = np.zeros(0), np.zeros(0, dtype=int)
            return Runs(none, rows, rows, none, none, none > 0)
        parts = [np.concatenate(part) for part in zip(*self.found)]
        value, first, last, *_ = parts
        resting = at_rest(self.name, value, rest)
        rows = self.rows - (last - first + 1)[resting].sum()
        changes = self.changes - np.count_nonzero(resting)
        return Runs(*parts, last - first > most_kept(rows, changes, self.limits))


def most_kept(rows, changes, limits):
    """
    Rows in which a value may repeat the one before it by chance.

    A value that is kept from row to row with a chance of p is kept n times with pⁿ.
    """
    if not 0 < changes < rows:
        return 0.0
    return np.log(limits.still_chance) / np.log1p(-changes / rows)


def whole_run(value, rows, first, last, unit=1.0):
    """The one repetition of a column that never moves, with its first and last time."""
    ends = np.array([0]), np.array([rows - 1]), np.array([first])
    time = np.array([(last - first) * unit])
    return Runs(np.array([value]), *ends, time, np.array([True]))


def runs(name, values, seconds, rest, limits):
    """Repetitions of one value; a NaN ends one, unless there is no other value."""
    if never_moves(values):
        value = values[np.isfinite(values)][0]
        return whole_run(value, len(values), seconds[0], seconds[-1])
    return Standing(name, limits).add(values, 0, seconds).runs(rest)


def rest_of(name, values, limits):
    """
    Value at which a column's sensor rests; NaN of one that does not.

    That is the dark, the lowest value of a flow, the highest humidity. An anemometer's
    calm, or a night of an inverter, need not be 0; a few values may be beyond.
    """
    if name == "poa_global":
        return limits.light
    seen = values[np.isfinite(values)]
    if name not in (*FLOWS, "relative_humidity") or not len(seen):
        return np.nan
    beyond = int(limits.few_share * (len(seen) - 1))
    at = beyond if name in FLOWS else len(seen) - 1 - beyond
    return float(np.partition(seen, at)[at])


def at_rest(name, values, rest):
    """Whether values are where the column's sensor rests."""
    return values >= rest if name == "relative_humidity" else values <= rest


def stuck(record, limits=None) -> dict[str, np.ndarray]:
    """
    Rows in which a sensor stands still while what moves it moves.

    A value repeats by nature as long as its column's resolution, averaging and own
    changes make it: a column that keeps its value from row to row with a share of *p*
    keeps it *n* times with a chance of *pⁿ*. Repetitions count that have a chance below
    1e-9, away from where the sensor rests: in the dark, at the lowest reading of an
    anemometer, of power and of rain, at the highest humidity. Of these

    * ``temp_module`` is stuck where it has felt irradiance change by 100 W/m², or the
      air by 1 K and more over 3 h; at 0 °C, where snow melts, only after a day;
    * ``temp_air`` where the module has changed by 10 K over 3 h;
    * ``poa_global`` where the module's over-temperature has changed by 10 K; in the
      dark (20 W/m²) over more than a day, or more than two hours from either end,
      above the air, and by the module's own warmth;
    * ``wind_speed`` after 6 h, and at its lowest reading after three days;
    * ``relative_humidity``, ``longwave_down``, ``p_dc`` and ``precipitation`` after a
      day, ``wind_direction`` after three. Other columns may stay, as a timetable does.

    After three days in which the others move, the first three are stuck whatever
    they usually do.

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
    A missing value ends a repetition, but in a column that has one value only, and in
    wind at rest: of a record by day alone that may be weeks. There the measured time
    counts.
    """
    limits = limits or Limits()
    seconds = record.inputs.seconds
    columns = record.inputs.columns.only(POSSIBLE)
    steps = {}
    found = dict.fromkeys(POSSIBLE, np.zeros(len(seconds), dtype=bool))
    for name, still in STILL.items():
        values = columns[name]
        rest = rest_of(name, values, limits)
        repeated = runs(name, values, seconds, rest, limits)
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
        if name not in POSSIBLE and never_moves(values):  # a number that stands for all
            continue
        rest = rest_of(name, values, limits)
        repeated = runs(name, values, seconds, rest, limits)
        kept = still_driver(name, repeated, rest, limits)
        found[name] = repeated.rows(kept, len(values)) & np.isfinite(values)
        if name == "wind_speed" and len(seconds) > 1:
            one, usual = [(values, 0, seconds, 1.0)], np.median(np.diff(seconds))
            if may_rest(values, rest, usual, limits):
                for rows, *_ in becalmed(lambda one=one: one, usual, rest, limits):
                    found[name][rows] = True
    return found


def felt(record, limits):
    """Irradiance as the module feels it, smoothed by its memory. [W/m²]"""
    poa = pd.Series(record["poa_global"], record.index)
    return ewm(poa, limits.still_time / 5).to_numpy()


def seen_by(name, columns):
    """A column, or what two of them make: over-temperature, and where it is warm."""
    if name in columns:
        return columns[name]
    over = columns["temp_module"] - columns["temp_air"]
    return over if name == "over" else np.maximum(over, 0.0)


def too_long(runs, limits):
    """Repetitions that are odd for the column, or last while others move for days."""
    return runs.odd | (runs.time > limits.calm)


def still_irradiance(runs, extent, steps, limits):
    night = (runs.value <= limits.light) & (runs.time <= limits.still_day)
    # a late clock has the sun at night; frost cools a module, and snow keeps it warm
    warm = extent("warmth", limits.farthest_clock) > limits.warmed
    warm &= extent("temp_module", limits.farthest_clock) > limits.warmed
    moved = (extent("over") > limits.warmed) & (~night | warm)
    return moved & too_long(runs, limits)


def still_air(runs, extent, steps, limits):
    moved = extent("temp_module") > limits.warmed
    return moved & (runs.time > limits.still_air) & too_long(runs, limits)


def still_module(runs, extent, steps, limits):
    of_sun = extent("felt") > limits.bright
    of_air = extent("temp_air") > limits.temp_slack + 2 * sum(steps.values())
    of_air &= runs.time > limits.still_air
    melting = (np.abs(runs.value) <= limits.temp_slack) & (
        runs.time <= limits.still_day
    )
    return (of_sun | of_air) & ~melting & too_long(runs, limits)


#: what makes a repetition of each column a fault beside others that move
STILL = {
    "temp_module": still_module,
    "poa_global": still_irradiance,
    "temp_air": still_air,
}
#: the limit of time of columns of which the others tell nothing
DRIVERS = {
    "wind_speed": "still_wind",
    "relative_humidity": "still_day",
    "longwave_down": "still_day",
    "p_dc": "still_day",
    "precipitation": "still_day",
    "wind_direction": "calm",
}


def still_driver(name, runs, rest, limits):
    """Repetitions that none of the others explains."""
    longest = limits.calm if name == "wind_speed" else np.inf
    resting = at_rest(name, runs.value, rest)
    most = np.where(resting, longest, getattr(limits, DRIVERS[name]))
    return runs.odd & (runs.time > most)


def may_rest(wind, rest, usual, limits):
    """Whether so many rows are at one value, or below, that a calm may be too long."""
    _, counts = np.unique(wind[wind <= rest], return_counts=True)
    return counts.max(initial=0) * usual > limits.calm


def becalmed(blocks, usual, rest, limits):
    """
    Rows of wind at rest for longer than a calm lasts, with their times and values.

    Gaps take no time. ``blocks()`` gives values, first row, times and their unit [s]
    of each; the usual step is in seconds.
    """
    standing, number = Standing("wind_speed", limits), 0
    elapsed, last = 0.0, None
    for values, _, times, unit in blocks():
        there = np.flatnonzero(np.isfinite(values))
        if not len(there):
            continue
        times = times[there]
        steps = np.diff(times, prepend=times[0] if last is None else last)
        lasted = elapsed + np.cumsum(np.minimum(steps * unit, usual))
        standing.add(values[there], number, lasted)
        number, elapsed, last = number + len(there), lasted[-1], times[-1]
    runs = standing.runs(rest)
    kept = (runs.value <= rest) & (runs.time > limits.calm)
    calm, number = runs.rows(kept, number), 0
    for values, start, times, _ in blocks() if kept.any() else ():
        there = np.flatnonzero(np.isfinite(values))
        rows = there[calm[number : number + len(there)]]
        yield rows + start, times[rows], values[rows]
        number += len(there)


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
