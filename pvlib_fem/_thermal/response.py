"""First-order responses of a block of rows, continued from the rows before it."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pvlib_fem._relaxation import (
    banded,
    gap_limit,
    median_step,
    rows_of,
    solve,
    steps_across,
)


@dataclass(eq=False)
class Past:
    """State at the end of the rows before a block; empty before the first block."""

    # median step of the whole record, in its unit; NaN takes the median of the block
    usual: float = np.nan
    since: dict = field(default_factory=dict)  # time since each recursion's last row
    last: dict = field(default_factory=dict)  # value of each column at that row
    state: np.ndarray | None = None  # state of the compiled loops


class Response:
    """
    Responses over one block that share their rows, steps and time constant.

    ``whole`` is NaN where a row is missing; the step of the next row then starts at
    the last row that is not. The state at the end of the block is stored in ``past``,
    under ``name``.
    """

    def __init__(
        self, name: str, whole: np.ndarray, steps: Any, tau: Any, past: Past
    ) -> None:
        self.name, self.past, self.rows, self.was = name, past, len(whole), {}
        self.valid = None
        if np.isnan(whole.sum()):  # one fast pass; infinities are refused before
            self.valid = np.flatnonzero(~np.isnan(whole))
        started, since = name in past.since, past.since.get(name, 0.0)
        self.count = self.rows if self.valid is None else len(self.valid)
        if not self.count:
            if started:
                past.since[name] = since + duration(steps, self.rows)
            self.tau = self.steps = self.decay = self.rise = np.empty(0)
            return
        past.since[name] = 0.0
        if self.valid is not None:
            after = self.rows - 1 - self.valid[-1]
            past.since[name] = duration(steps, after)
            steps = steps_across(steps, self.valid)
        if since:
            steps = np.array(np.broadcast_to(steps, self.count), dtype=float)
            steps[0] += since
        self.steps, self.tau = steps, self.known_rows(tau)
        self.decay = decay_weights(steps, self.tau, self.count, past)
        if not started:
            self.decay[0] = 0.0
        self.rise = 1.0 - self.decay
        self.band = banded(self.decay)

    def known_rows(self, column: float | np.ndarray) -> Any:
        """A column without the missing rows; a number is returned as it is."""
        return column if self.valid is None else rows_of(column, self.valid)

    def on_all_rows(self, column: np.ndarray) -> Any:
        """Values on all rows of the block; missing rows are NaN."""
        if self.valid is None or np.ndim(column) == 0:
            return column
        result = np.full(self.rows, np.nan)
        result[self.valid] = column
        return result

    def solve(self, column: str, source: np.ndarray) -> Any:
        """Response to a source on the rows that are not missing, computed in place."""
        key = self.name, column
        state = self.was[column] = self.past.last.get(key, 0.0)
        if self.count:
            source[0] += self.decay[0] * state
            source = solve(self.band, source)
            self.past.last[key] = source[-1]
        return source

    def mean(self, column: str, values: Any) -> Any:
        """Response to values on the rows that are not missing."""
        return self.solve(column, self.rise * values)

    def source_by_log_tau(
        self, column: str, values: np.ndarray, target: Any
    ) -> np.ndarray:
        """Source of the slope by the logarithm of the time constant."""
        fall = np.empty(self.count)
        fall[:1] = self.was[column]
        fall[1:] = values[:-1]
        fall -= target
        fall *= self.decay
        fall *= self.steps / self.tau
        return fall


def duration(steps: Any, rows: Any) -> float:
    """Duration of the last rows, by their steps or one even step."""
    if np.ndim(steps) == 0:
        return float(steps * rows)
    return float(np.sum(steps[len(steps) - rows :]))


def decay_weights(
    steps: float | np.ndarray, tau: float | np.ndarray, rows: int, past: Past
) -> np.ndarray:
    """Weight of the past at each row: ``exp(-steps/tau)``, 0 after a gap."""
    decay = np.exp(-steps / tau)
    if np.ndim(decay) == 0:
        return np.full(rows, decay)
    if np.ndim(steps):
        if np.isnan(past.usual):
            past.usual = median_step(steps)
        limit = gap_limit(steps, tau, past.usual)
        if limit is not None:
            decay[steps > limit] = 0.0
    return decay
