"""A sensor that is stuck while its driver changes."""

from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.clean import CleanRecord, rows_in_spans
from pvlib_fem._record.inputs import Record
from pvlib_fem._record.parquet import Block
from pvlib_fem._relaxation import relax
from pvlib_fem._spelling import argument, refusal
from pvlib_fem.quality._limits import POSSIBLE, Limits
from pvlib_fem.quality._values import changes, never_moves


@dataclass(frozen=True, eq=False)
class Runs:
    """Stretches of one value that are too long to be an accident."""

    value: np.ndarray
    first: np.ndarray  # row
    last: np.ndarray  # row
    begin: np.ndarray  # time of the first row
    time: np.ndarray  # from the first to the last row [s]
    odd: np.ndarray  # whether the column's own changes make it far too long

    def some(self, kept: np.ndarray) -> "Runs":
        """Some of them."""
        return Runs(*(getattr(self, part.name)[kept] for part in fields(self)))

    @property
    def spans(self) -> np.ndarray:
        """First row of each, and the one after its last."""
        return np.column_stack([self.first, self.last + 1])


SOME = 1 << 17  # rows that tell where a sensor rests
#: columns whose sensors rest at their lowest value, whatever number that is
FLOWS = ("wind_speed", "precipitation", "p_dc_per_area")


@dataclass(eq=False)
class Standing:
    """Long repetitions of a column's value, of rows that come in blocks."""

    name: str
    limits: Limits
    unit: float = 1.0  # of the times [s]
    rows: int = 0  # values that are there
    changes: int = 0  # those of them that are not as the one before
    long_runs: list = field(default_factory=list)
    open: tuple | None = None  # the last one, which may go on

    def add(self, values: Any, start: int, times: np.ndarray) -> "Standing":
        """Look at the next rows, the first of which is row ``start``."""
        if not len(values):
            return self
        edges = np.flatnonzero(values[1:] != values[:-1]) + 1
        edges = np.concatenate(([0], edges, [len(values)]))
        goes_on = self.open is not None and self.open[0] == values[0]
        self.rows += int(np.count_nonzero(np.isfinite(values)))
        begun = np.isfinite(values[edges[:-1]])
        self.changes += int(np.count_nonzero(begun)) - int(goes_on)
        many = np.flatnonzero(np.diff(edges) > self.limits.max_accident_rows)
        # the first may go on from the rows before, and the last in those that follow
        many = np.union1d(many, [0, len(edges) - 2])
        first, last = edges[many], edges[many + 1] - 1
        runs = [values[first], first + start, last + start, times[first], times[last]]
        if goes_on and self.open is not None:
            runs[1][0], runs[3][0] = self.open[1], self.open[3]
        else:
            self.close()
        self.open = tuple(part[-1] for part in runs)
        self.keep(*(part[:-1] for part in runs))
        return self

    def close(self) -> None:
        if self.open is not None:
            self.keep(*(np.array([one]) for one in self.open))

    def keep(
        self,
        value: np.ndarray,
        first: np.ndarray,
        last: np.ndarray,
        begin: np.ndarray,
        end: np.ndarray,
    ) -> None:
        time = (end - begin) * self.unit
        long = (last - first >= self.limits.max_accident_rows) & (
            time > self.limits.response_time
        )
        if long.any():
            self.long_runs.append([x[long] for x in (value, first, last, begin, time)])

    def runs(self, rest: float) -> Runs:
        """All of them, after the last row, and which are odd for the column."""
        self.close()
        self.open = None
        if not self.long_runs:
            none, rows = np.zeros(0), np.zeros(0, dtype=int)
            return Runs(none, rows, rows, none, none, none > 0)
        parts = [np.concatenate(part) for part in zip(*self.long_runs)]
        value, first, last, *_ = parts
        resting = at_rest(self.name, value, rest)
        rows = self.rows - (last - first + 1)[resting].sum()
        changes = self.changes - np.count_nonzero(resting)
        long = last - first > most_kept(rows, changes, self.limits)
        return Runs(*[*parts, long])


def most_kept(rows: int, changes: Any, limits: Limits) -> float:
    """
    Rows in which a value may repeat the one before it by chance.

    A value that is kept from row to row with a chance of p is kept n times with pⁿ.
    """
    if not 0 < changes < rows:
        return 0.0
    return np.log(limits.max_stuck_chance) / np.log1p(-changes / rows)


def whole_run(
    value: float, rows: int, first: int, last: int, unit: float = 1.0
) -> Runs:
    """
    The one repetition of a column that never moves.

    Parameters
    ----------
    value : float
        Its value.
    rows : int
        Number of rows of the record.
    first, last : int
        Times of the first and last row, as counts of a unit.
    unit : float, default 1.0
        Length of one count. [s]

    Returns
    -------
    Runs
        Of one repetition, which is odd.
    """
    ends = np.array([0]), np.array([rows - 1]), np.array([first])
    time = np.array([(last - first) * unit])
    return Runs(np.array([value]), *ends, time, np.array([True]))


def rest_of(name: str, values: np.ndarray, limits: Limits) -> float:
    """
    Value at which a column's sensor rests.

    That is the dark, the lowest value of a flow, the highest humidity. An anemometer's
    calm, or a night of an inverter, need not be 0; a few values may be beyond it.

    Parameters
    ----------
    name : str
        Column.
    values : numpy.ndarray, shape (rows,)
        The column, or evenly taken rows of it.
    limits : Limits
        ``min_light``, and ``max_accident_share`` of the values that may be beyond.

    Returns
    -------
    float
        In the unit of the column; NaN if its sensor does not rest.
    """
    if name == "poa_global":
        return limits.min_light
    way = 1.0 if name in FLOWS else -1.0
    values = values[:: max(1, len(values) // SOME)]
    seen = way * values[np.isfinite(values)]
    if name not in (*FLOWS, "relative_humidity") or not len(seen):
        return np.nan
    at = int(limits.max_accident_share * (len(seen) - 1))
    rest = np.partition(seen, at)[at]
    # where it rests it is more often than anywhere beyond, and not once
    resting = seen == rest
    once = longest_run(resting)
    if 2 * (np.count_nonzero(resting) - once) < np.count_nonzero(seen <= rest) - once:
        rest = seen.min()
    return way * float(rest)


def longest_run(rows: np.ndarray) -> int:
    """How many rows follow each other at most."""
    edges = np.flatnonzero(np.diff(rows, prepend=False, append=False))
    return int(np.diff(edges)[::2].max(initial=0))


def at_rest(name: str, values: np.ndarray, rest: float) -> np.ndarray:
    """Whether values are where the column's sensor rests."""
    return values >= rest if name == "relative_humidity" else values <= rest


def too_long(runs: Runs, limits: Limits) -> np.ndarray:
    """Repetitions that are odd for the column, or last while others move for days."""
    return runs.odd | (runs.time > limits.stale_calm_window)


def still_irradiance(runs: Runs, extents: "Extents", limits: Limits) -> np.ndarray:
    night = (runs.value <= limits.min_light) & (runs.time <= limits.stale_day_window)
    over, warmth, module = (
        extents.extent("poa_global", other) > limits.min_temperature_response
        for other in ("over", "warmth", "temp_module")
    )
    # a late clock has the sun at night; frost cools a module, and snow keeps it warm
    return over & (~night | (warmth & module))


def still_air(runs: Runs, extents: "Extents", limits: Limits) -> np.ndarray:
    moved = extents.extent("temp_air", "temp_module") > limits.min_temperature_response
    return moved & (runs.time > limits.stale_air_window)


def still_module(runs: Runs, extents: "Extents", limits: Limits) -> np.ndarray:
    of_sun = extents.extent("temp_module", "felt") > limits.min_bright_irradiance
    least = limits.temperature_tolerance + 2 * sum(extents.steps.values())
    of_air = extents.extent("temp_module", "temp_air") > least
    of_air &= runs.time > limits.stale_air_window
    melting = (np.abs(runs.value) <= limits.temperature_tolerance) & (
        runs.time <= limits.stale_day_window
    )
    return (of_sun | of_air) & ~melting


#: what makes a repetition of each column a fault while others move
STILL = {
    "temp_module": still_module,
    "poa_global": still_irradiance,
    "temp_air": still_air,
}
#: the limit of time of columns of which the others tell nothing
DRIVERS = {
    "wind_speed": "stale_wind_window",
    "relative_humidity": "stale_day_window",
    "longwave_down": "stale_day_window",
    "p_dc_per_area": "stale_day_window",
    "precipitation": "stale_day_window",
    "wind_direction": "stale_calm_window",
}


def still_driver(name: str, runs: Runs, rest: float, limits: Limits) -> np.ndarray:
    """Repetitions that none of the others explains."""
    longest = limits.stale_calm_window if name == "wind_speed" else np.inf
    resting = at_rest(name, runs.value, rest)
    most = np.where(resting, longest, getattr(limits, DRIVERS[name]))
    return runs.odd & (runs.time > most)


#: by column: what moves it or is moved by it, and how far from the ends of a repetition
#: that is looked at, as a field of the limits
SEEN_BY = {
    "temp_module": {"felt": "", "temp_air": ""},
    "poa_global": {
        "over": "",
        "warmth": "max_onset_shift",
        "temp_module": "max_onset_shift",
    },
    "temp_air": {"temp_module": ""},
}


def frozen(
    clean: CleanRecord, standing: dict, rests: dict, limits: Limits
) -> dict[str, np.ndarray]:
    """
    Spans of rows in which a sensor is stuck, by column.

    Parameters
    ----------
    clean : CleanRecord
        As it is screened so far, with the four columns.
    standing : dict of Runs
        Long repetitions of each column.
    rests : dict
        Value at which each sensor rests.
    limits : Limits
        Thresholds of stuck sensors.

    Returns
    -------
    dict of numpy.ndarray, shape (spans, 2)
        First row of each span, and the one after its last; of stuck columns alone.
    """
    seen = {n: standing[n].some(too_long(standing[n], limits)) for n in STILL}
    spans, untested = {}, [name for name in STILL if len(seen[name].first)]
    while untested:
        extents = Extents.from_record(
            clean, {name: seen[name] for name in untested}, limits
        )
        for name in list(untested):
            runs = seen[name]
            kept = STILL[name](runs, extents, limits)
            untested.remove(name)
            if kept.any():
                spans[name] = runs.some(kept).spans
                # a stuck module shows nothing of its drivers
                clean = clean.lacking({name: spans[name]})
                break
    for name in [name for name in DRIVERS if name in standing]:
        runs = standing[name]
        kept = still_driver(name, runs, rests[name], limits)
        if kept.any():
            spans[name] = runs.some(kept).spans
    return spans


@dataclass(eq=False)
class Extents:
    """Least and largest value of other columns in repetitions of some."""

    standing: dict
    limits: Limits
    steps: dict  # smallest change of both temperatures
    bounds: dict = field(default_factory=dict)  # least, largest, and the last value
    before: dict = field(default_factory=dict)
    felt: float | None = None
    since: float = 0.0

    @classmethod
    def from_record(
        cls, clean: CleanRecord, standing: dict, limits: Limits
    ) -> "Extents":
        """The extents over a record, from one pass."""
        steps = dict.fromkeys(("temp_air", "temp_module"), np.inf)
        extents = cls(standing, limits, steps)
        for name, runs in standing.items():
            for other in SEEN_BY[name]:
                extents.bounds[name, other] = np.full((3, len(runs.first)), np.nan)
        if extents.bounds:
            for block in clean.blocks(tuple(POSSIBLE)):
                extents.add(block)
        extents.steps = {n: s if s < np.inf else 0.0 for n, s in extents.steps.items()}
        return extents

    def add(self, block: Block) -> None:
        columns = dict(block.inputs.columns)
        others = {other for _, other in self.bounds}
        if "felt" in others:
            columns["felt"] = self.as_felt(block)
            for name in self.steps:
                self.resolve(name, columns[name])
        columns["over"] = columns["temp_module"] - columns["temp_air"]
        columns["warmth"] = np.maximum(columns["over"], 0.0)
        for name, runs in self.standing.items():
            end = runs.last >= block.start
            near = np.flatnonzero(end & (runs.first < block.start + len(block)))
            if not len(near):
                continue
            some = runs.some(near)
            for other, margin in SEEN_BY[name].items():
                inner = getattr(self.limits, margin) if margin else 0.0
                first, end = rows_inside(block, some, inner)
                kept = end > first
                bounds = self.bounds[name, other]
                merge(bounds, near[kept], columns[other], first[kept], end[kept])

    def as_felt(self, block: Block) -> np.ndarray:
        """Irradiance as the module feels it, carried on from the blocks before."""
        poa, steps = block["poa_global"], block.inputs.steps.astype(float)
        there = np.flatnonzero(np.isfinite(poa))
        if not len(there):
            self.since += steps.sum()
            return poa
        steps[0] += self.since
        self.since = steps[there[-1] + 1 :].sum()
        memory = self.limits.response_time / 5 / block.inputs.unit
        felt = relax(poa, steps, memory, self.felt)
        self.felt = felt[there[-1]]
        return felt

    def resolve(self, name: str, values: np.ndarray) -> None:
        """Smallest change of a column so far."""
        change = changes(np.append(self.before.get(name, np.nan), values))
        self.before[name] = values[-1]
        self.steps[name] = float(change.min(initial=self.steps[name]))

    def extent(self, name: str, other: str) -> np.ndarray:
        """Largest less least value of another column in each repetition of one."""
        low, high, _ = self.bounds[name, other]
        return np.nan_to_num(high - low)


def rows_inside(
    block: Block, runs: Runs, margin: float
) -> tuple[np.ndarray, np.ndarray]:
    """
    Rows of a block that lie in each of some repetitions, within a margin.

    Parameters
    ----------
    block : Block
    runs : Runs
        Repetitions that have rows of the block.
    margin : float
        Time from either end of each. [s]

    Returns
    -------
    first, end : array of int, shape (repetitions,)
        The first of these rows, and the one after the last.
    """
    first = np.maximum(runs.first - block.start, 0)
    end = np.minimum(runs.last + 1 - block.start, len(block))
    if margin:
        inner = runs.begin + np.array([margin, -margin])[:, None] / block.inputs.unit
        inner[1] += runs.time / block.inputs.unit
        first = np.maximum(first, np.searchsorted(block.times, inner[0], "left"))
        end = np.minimum(end, np.searchsorted(block.times, inner[1], "right"))
    return first, end


def merge(
    bounds: np.ndarray,
    runs: np.ndarray,
    values: np.ndarray,
    first: np.ndarray,
    end: np.ndarray,
) -> None:
    """
    Take further values into the least and largest of some repetitions.

    The last row of each waits until another comes, as in memory.

    Parameters
    ----------
    bounds : array, shape (3, repetitions)
        Least, largest and last value of each, which are changed.
    runs : array of int
        Places of the repetitions that have rows.
    values : array, shape (rows,)
        Of a block.
    first, end : array of int
        First row of each, and the one after its last.
    """
    if not len(runs):
        return
    low, high, last = bounds[:, runs]
    low, high = np.fmin(low, last), np.fmax(high, last)
    edges = np.column_stack([first, end - 1]).ravel()
    more = end - 1 > first
    for row, extreme, known in ((0, np.fmin, low), (1, np.fmax, high)):
        found = extreme.reduceat(values, edges)[::2]
        bounds[row, runs] = np.where(more, extreme(known, found), known)
    bounds[2, runs] = values[end - 1]


def may_rest(wind: np.ndarray, rest: float, usual: float, limits: Limits) -> bool:
    """
    Whether so many rows are at one value of rest that a calm may be too long.

    Parameters
    ----------
    wind : numpy.ndarray, shape (rows,)
        Wind speed, or evenly taken rows of it. [m/s]
    rest : float
        Value at which the anemometer rests. [m/s]
    usual : float
        Time for which one of these rows counts. [s]
    limits : Limits
        ``stale_calm_window``, the time that is allowed.

    Returns
    -------
    bool
        False means that no calm is too long.
    """
    _, counts = np.unique(wind[wind <= rest], return_counts=True)
    return counts.max(initial=0) * usual > limits.stale_calm_window


def becalmed(
    clean: CleanRecord, usual: float, rest: float, limits: Limits
) -> list[np.ndarray]:
    """
    Rows of wind at rest for longer than a calm lasts.

    Gaps take no time: no row is further from the one before than a usual step.

    Parameters
    ----------
    clean : CleanRecord
        With ``wind_speed``.
    usual : float
        Usual time between rows. [s]
    rest : float
        Value at which the anemometer rests. [m/s]
    limits : Limits
        ``stale_calm_window``, the time that is allowed.

    Returns
    -------
    list of numpy.ndarray, shape (n,)
        Numbers of the rows, their times as counts of the index's unit, and wind
        speeds [m/s].
    """
    standing, number = Standing("wind_speed", limits), 0
    elapsed, last = 0.0, None
    for block in clean.blocks(("wind_speed",)):
        values, times = block["wind_speed"], block.times
        there = np.flatnonzero(np.isfinite(values))
        if not len(there):
            continue
        times = times[there]
        steps = np.diff(times, prepend=times[0] if last is None else last)
        lasted = elapsed + np.cumsum(np.minimum(steps * block.inputs.unit, usual))
        standing.add(values[there], number, lasted)
        number, elapsed, last = number + len(there), lasted[-1], times[-1]
    runs = standing.runs(rest)
    calm = runs.some(
        (runs.value <= rest) & (runs.time > limits.stale_calm_window)
    ).spans
    parts, number = [[np.empty(0, int)] * 3], 0
    for block in clean.blocks(("wind_speed",)) if len(calm) else ():
        values = block["wind_speed"]
        there = np.flatnonzero(np.isfinite(values))
        rows = there[rows_in_spans(calm, np.arange(number, number + len(there)))]
        parts.append([rows + block.start, block.times[rows], values[rows]])
        number += len(there)
    return [np.concatenate(part) for part in zip(*parts)]


def refuse_frozen(record: Record, frozen: dict) -> None:
    """
    Refuse a record in which a sensor never moves, so that no row can be used.

    Parameters
    ----------
    record : Record
        With the columns of ``frozen``.
    frozen : dict of numpy.ndarray of bool, shape (rows,)
        Rows of stuck sensors, by column.

    Raises
    ------
    ValueError
        If a stuck column has one value only.
    """
    whole = [
        name for name in frozen if frozen[name].any() and never_moves(record[name])
    ]
    if whole:
        raise frozen_error(whole[0], [whole_line(record, name) for name in whole])


def frozen_error(name: str, lines: list) -> ValueError:
    """
    The error of sensors that never move.

    Parameters
    ----------
    name : str
        The first of their columns.
    lines : list of str
        From :func:`standing_line`, one of each.

    Returns
    -------
    ValueError
        With the remedy, as Python and as a shell spell it.
    """
    words = (
        f"{'; '.join(lines)}, so no row is left; look at sensor and logger, or name "
        f"the column of a sensor that moves as {name}"
    )
    calm = (", or give ", argument("model", "ross"), ", which needs no wind")
    return refusal(words, *(calm if name == "wind_speed" else ()))


def stuck_line(record: Record, frozen: dict) -> str:
    """
    The stuck sensors, since when and at which value, in one line.

    Parameters
    ----------
    record : Record
        With the columns of ``frozen``.
    frozen : dict of numpy.ndarray of bool, shape (rows,)
        Rows of stuck sensors, by column; one of them at least has such rows.

    Returns
    -------
    str
        With the remedy.
    """
    lines = [one_line(record, name, rows) for name, rows in frozen.items()]
    lines = "; ".join(filter(None, lines))
    return f"{lines}: they are not used; look at sensor and logger"


def one_line(record: Record, name: str, rows: np.ndarray) -> str:
    """The line of one column, or nothing if it moves."""
    values = record[name]
    if not rows.any():
        return ""
    if never_moves(values):
        return whole_line(record, name)
    at = int(np.argmax(rows))
    return (
        f"{name} is stuck at {values[at]:g} from {record.index[at]} on, "
        f"{rows.sum():,} rows in all"
    )


def whole_line(record: Record, name: str) -> str:
    """The line of a column that never moves."""
    values = record[name]
    seen = np.flatnonzero(np.isfinite(values))
    first, last = record.index[seen[0]], record.index[seen[-1]]
    return standing_line(name, values[seen[0]], first, last)


def standing_line(
    name: str, value: float, first: pd.Timestamp, last: pd.Timestamp
) -> str:
    """
    One line for a sensor that is stuck for the whole record.

    Parameters
    ----------
    name : str
        Column.
    value : float
        Its only value, in its unit.
    first, last : pandas.Timestamp
        First and last time with that value.

    Returns
    -------
    str
        A clause without a full stop.
    """
    return f"{name} is stuck at {value:g} for the whole record, from {first} to {last}"
