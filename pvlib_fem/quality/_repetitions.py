"""Values that a column repeats for longer than chance makes likely."""

from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from pvlib_fem.quality._limits import Limits


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
class Repetitions:
    """Long repetitions of a column's value, of rows that come in blocks."""

    name: str
    limits: Limits
    unit: float = 1.0  # of the times [s]
    rows: int = 0  # values that are there
    changes: int = 0  # those of them that are not as the one before
    long_runs: list = field(default_factory=list)
    open: tuple | None = None  # the last one, which may go on

    def add(self, values: Any, start: int, times: np.ndarray) -> "Repetitions":
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
    """
    Whether values are where the column's sensor rests.

    Parameters
    ----------
    name : str
        Column.
    values : numpy.ndarray, shape (rows,)
        In the unit of the column.
    rest : float
        From :func:`rest_of`.

    Returns
    -------
    numpy.ndarray of bool, shape (rows,)
        False for NaN, and where the sensor does not rest.
    """
    return values >= rest if name == "relative_humidity" else values <= rest
