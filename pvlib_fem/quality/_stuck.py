"""A sensor that is stuck while its driver changes."""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from pvlib_fem._record.clean import CleanRecord, rows_in_spans
from pvlib_fem._record.inputs import Record
from pvlib_fem._record.parquet import Block
from pvlib_fem._relaxation import relax
from pvlib_fem._spelling import argument, refusal
from pvlib_fem.quality._limits import DRIVERS, POSSIBLE, Limits
from pvlib_fem.quality._repetitions import Repetitions, Runs, at_rest
from pvlib_fem.quality._values import changes, never_moves


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


def stuck_spans(
    clean: CleanRecord, repetitions: dict, rests: dict, limits: Limits
) -> dict[str, np.ndarray]:
    """
    Spans of rows in which a sensor is stuck, by column.

    Parameters
    ----------
    clean : CleanRecord
        As it is screened so far, with the four columns.
    repetitions : dict of Runs
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
    seen = {n: repetitions[n].some(too_long(repetitions[n], limits)) for n in STILL}
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
    for name in [name for name in DRIVERS if name in repetitions]:
        runs = repetitions[name]
        kept = still_driver(name, runs, rests[name], limits)
        if kept.any():
            spans[name] = runs.some(kept).spans
    return spans


@dataclass(eq=False)
class Extents:
    """Least and largest value of other columns in repetitions of some."""

    repetitions: dict
    limits: Limits
    steps: dict  # smallest change of both temperatures
    bounds: dict = field(default_factory=dict)  # least, largest, and the last value
    before: dict = field(default_factory=dict)
    felt: float | None = None
    since: float = 0.0

    @classmethod
    def from_record(
        cls, clean: CleanRecord, repetitions: dict, limits: Limits
    ) -> "Extents":
        """The extents over a record, from one pass."""
        steps = dict.fromkeys(("temp_air", "temp_module"), np.inf)
        extents = cls(repetitions, limits, steps)
        for name, runs in repetitions.items():
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
        for name, runs in self.repetitions.items():
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
    repetitions, number = Repetitions("wind_speed", limits), 0
    elapsed, last = 0.0, None
    for block in clean.blocks(("wind_speed",)):
        values, times = block["wind_speed"], block.times
        there = np.flatnonzero(np.isfinite(values))
        if not len(there):
            continue
        times = times[there]
        steps = np.diff(times, prepend=times[0] if last is None else last)
        lasted = elapsed + np.cumsum(np.minimum(steps * block.inputs.unit, usual))
        repetitions.add(values[there], number, lasted)
        number, elapsed, last = number + len(there), lasted[-1], times[-1]
    runs = repetitions.runs(rest)
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


def refuse_always_stuck(record: Record, frozen: dict) -> None:
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
        raise always_stuck_error(whole[0], [whole_line(record, name) for name in whole])


def always_stuck_error(name: str, lines: list) -> ValueError:
    """
    The error of sensors that never move.

    Parameters
    ----------
    name : str
        The first of their columns.
    lines : list of str
        From :func:`always_stuck_line`, one of each.

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
    return always_stuck_line(name, values[seen[0]], first, last)


def always_stuck_line(
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
