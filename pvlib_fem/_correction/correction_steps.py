"""A record as it is corrected: clocks, units, then instruments."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._correction.corrected_record import CorrectedRecord
from pvlib_fem._correction.repairs import (
    SOUND,
    Repair,
    ends_within,
    obstacle,
    repair_of,
    sentence,
    unit_added,
)
from pvlib_fem._record.column_names import ORIGINAL
from pvlib_fem._record.header_units import QUANTITIES, UNITS, own_unit
from pvlib_fem._record.inputs import read
from pvlib_fem.drivers import MEASURED, derive_drivers, underived
from pvlib_fem.effects._effect import Effect, Terms
from pvlib_fem.quality._clock_changes import wall_time
from pvlib_fem.quality._detached_sensor import DETACHED
from pvlib_fem.quality._lag import by_module_logger
from pvlib_fem.quality._unit_checks import unit_of_driver

FLAGS = "corrected"  # column of the causes by which a row is corrected
BEYOND = "outside the record"
TIME = f"time{ORIGINAL}"
EMPTY = {"size": np.nan, "stderr": np.nan, "low": np.nan, "high": np.nan, "unit": ""}
ACTIONS = ("cause", "column", "applied", "start", "end", *EMPTY, "rows", "words")


@dataclass(eq=False)
class Work:
    """A record as it is corrected, and what was done to it."""

    data: pd.DataFrame
    labels: dict
    columns: dict  # numeric columns by the package's names
    inside: np.ndarray  # rows within the record
    actions: list = field(default_factory=list)
    flags: dict = field(default_factory=dict)  # rows by cause
    originals: dict = field(default_factory=dict)  # columns as they were, by label
    times: pd.DatetimeIndex | None = None  # of the file, where others are corrected

    @property
    def days(self) -> tuple[str, str]:
        """First and last day of the rows within the record."""
        times = wall_time(self.data.index)[self.inside]
        return f"{times[0]:%Y-%m-%d}", f"{times[-1]:%Y-%m-%d}"

    def as_it_was(
        self,
        cause: str,
        column: str,
        words: str,
        rows: np.ndarray | None = None,
        dates: tuple | None = None,
    ) -> None:
        """Say what is not corrected, and why."""
        self.say(cause, column, words, False, rows, dates)

    def corrected(
        self,
        cause: str,
        column: str,
        words: str,
        rows: np.ndarray,
        dates: tuple | None = None,
        **size: float | str,
    ) -> None:
        """Say what is corrected, and flag its rows."""
        self.say(cause, column, words, True, rows, dates, size)
        self.flags[cause] = self.flags.get(cause, False) | rows

    def say(
        self,
        cause: str,
        column: str,
        words: str,
        applied: bool,
        rows: np.ndarray | None,
        dates: Any,
        size: dict = EMPTY,
    ) -> None:
        start, end = dates or self.days
        self.actions.append(
            {"cause": cause, "column": column, "applied": applied}
            | {"start": start, "end": end, **EMPTY, **size}
            | {"rows": 0 if rows is None else int(np.sum(rows)), "words": words}
        )

    def put(self, name: str, values: np.ndarray) -> None:
        """Replace a column by its corrected values, within the record."""
        label, was = self.labels[name], self.columns[name]
        self.originals.setdefault(label, self.data[label])
        self.columns[name] = was.where(~self.inside, values)
        self.data[label] = self.columns[name]

    def clocks(self, loop: Any) -> None:
        """Correct the times, and the readings of the module's logger."""
        for one in loop.corrections:
            if not one.applied:
                self.as_it_was(one.fault, ", ".join(one.columns), one.why)
        if loop.times is None:
            return
        self.clock_of_file(loop)
        if loop.times.module.fault:
            self.clock_of_module(loop)

    def clock_of_file(self, loop: Any) -> None:
        """Correct the times of all columns, and leave out rows of unknown time."""
        if not loop.times.offsets:
            return
        file = next(o for o in loop.corrections if o.columns == ("all",) and o.applied)
        cause = file.fault
        index, before = self.data.index, wall_time(self.data.index)
        times, known = loop.times.corrected(index)
        if not (known & self.inside).any():
            raise ValueError(
                f"no row of data, {before[0]} to {before[-1]}, has a sure time: the "
                "file's clock changes there; give a longer part of the record"
            )
        if (twice := times[known].duplicated()).any():
            raise ValueError(
                f"two rows of data have the corrected time {times[known][twice][0]}; "
                "give the record of this loop, or a part of it"
            )
        if lost := np.count_nonzero(~known):
            ends = ends_of(before[~known])
            words = (
                f"all columns: {lost:,} rows between {' and '.join(ends)} have no sure "
                "time and are dropped."
            )
            self.as_it_was(cause, "all", words, ~known, ends)
        minutes = np.asarray((times - index).total_seconds())[known] / 60.0
        before = before[known]
        self.data = self.data[known].set_axis(times[known])
        self.inside = self.inside[known]
        self.columns = {
            name: column[known].set_axis(self.data.index)
            for name, column in self.columns.items()
        }
        if minutes.any():
            self.times = index[known]
            words = f"all columns: {file.why}."
            self.corrected(cause, "all", words, minutes != 0.0)
        run = np.cumsum(np.diff(minutes, prepend=minutes[:1]) != 0.0)
        for one in np.unique(run[minutes != 0.0]):
            rows = run == one
            size, ends = minutes[rows][0], ends_of(before[rows])
            side = "behind" if size > 0 else "ahead"
            words = (
                f"all columns: the file's clock runs {abs(size):g} min {side} from "
                f"{' to '.join(ends)}. Added to the times: {size:g} min."
            )
            self.corrected(cause, "all", words, rows, ends, size=size, unit="min")

    def clock_of_module(self, loop: Any) -> None:
        """Interpolate the module's readings to the clock of the irradiance."""
        of_module = [o for o in loop.corrections if o.columns == ("temp_module",)]
        fault = next(one for one in of_module if one.applied)
        key = next(iter(fault.values))
        size = {
            "size": -fault.values[key],
            "unit": "s/day" if key == "drift" else "min",
        }
        size["stderr"] = fault.stderr.get(key, np.nan)
        columns = {name: column.to_numpy() for name, column in self.columns.items()}
        moved = by_module_logger(
            columns, lambda column: loop.times.of_module(self.data.index, column)
        )
        for name, values in moved.items():
            was = columns[name]
            self.put(name, values)
            words = f"{name}: {fault.why}. Interpolated to the clock of poa_global."
            rows = self.inside & np.isfinite(was)
            self.corrected(fault.fault, name, words, rows, **size)

    def detachments(self, loop: Any) -> None:
        """Leave out what the module's sensor reads while it is off."""
        for one in loop.detachments:
            was = self.columns["temp_module"].to_numpy()
            rows = self.inside & one.rows_of(self.data.index) & np.isfinite(was)
            if not rows.any():
                continue
            self.put("temp_module", np.where(rows, np.nan, was))
            words = f"temp_module: the sensor is off {one.when}. Left out."
            ends = ends_of(wall_time(self.data.index)[rows])
            self.corrected(DETACHED, "temp_module", words, rows, ends)

    def units(self, loop: Any) -> None:
        """Convert drivers whose numbers show another unit."""
        for name in QUANTITIES:
            if name not in self.columns or name in SOUND:
                continue
            was = self.columns[name].to_numpy()
            unit = unit_of_driver(name, was[self.inside], loop.criteria.limits)
            if not unit:
                continue
            factor, offset = UNITS[QUANTITIES[name]][unit]
            self.put(name, factor * was + offset)
            words = f"{name}: its numbers are {unit}. Converted to {own_unit(name)}."
            rows = self.inside & np.isfinite(was)
            self.corrected("unit", name, words, rows, size=factor, unit=own_unit(name))

    def instruments(self, loop: Any, faults: list) -> None:
        """Take the faults of instruments out of their columns."""
        coefficients, terms_by_column = loop.fit.coefficients, {}
        for fault in faults:
            repair = fault.effect and repair_of(fault.effect)
            why = fault.why or obstacle(fault, repair, coefficients)
            if why := why or self.missing(fault.effect, repair):
                column = repair.column if repair else ""
                self.as_it_was(fault.name, column, f"{fault.name}: {why}.")
                continue
            terms = self.terms(fault.effect, fault.coefficients)
            terms_by_column.setdefault(repair.column, []).append((fault, repair, terms))
        raw = {name: column.to_numpy() for name, column in self.columns.items()}
        for column, several in terms_by_column.items():
            # the faults of one instrument are terms of one equation
            whole = Terms()
            for fault, repair, terms in several:
                whole = whole.plus(terms)
                added = repair.added(fault, coefficients)
                alone = SOUND[column](raw, terms, coefficients)
                rows = self.inside & np.isfinite(raw[column]) & (alone != raw[column])
                self.corrected(
                    fault.name,
                    column,
                    sentence(fault.effect, repair, added),
                    rows,
                    ends_within(fault.effect, *self.days),
                    **dict(zip(("size", "stderr", "low", "high"), added)),
                    unit=unit_added(fault.effect, repair),
                )
            self.put(column, SOUND[column](raw, whole, coefficients))

    def missing(self, effect: Effect, repair: Repair) -> str:
        """Say which columns of a correction are missing; "" if none is."""
        needed = {repair.column, *underived(effect.drivers)} & {*MEASURED, *SOUND}
        if repair.column == "temp_module":
            needed.add("temp_air")
        missing = [name for name in sorted(needed) if name not in self.columns]
        return f"data have no {', '.join(missing)}" if missing else ""

    def terms(self, effect: Effect, coefficients: dict) -> Terms:
        """Terms of a fault on the rows; of the air's, by each W/m² that air brings."""
        # a change of constant size is of no column, and still has the times
        used = {*underived(effect.drivers)} & {*self.columns} or {*self.columns}
        columns = {name: self.columns[name] for name in sorted(used)}
        inputs = read(columns, purpose="a corrected record")
        inputs = inputs.having({"air_base": np.ones(len(self.data))})
        return effect.at(derive_drivers(inputs, effect.drivers).columns, coefficients)

    def done(self) -> CorrectedRecord:
        """The corrected record."""
        if outside := np.count_nonzero(~self.inside):
            words = f"all columns: {outside:,} rows are {BEYOND} and stay as they were."
            ends = ends_of(wall_time(self.data.index)[~self.inside])
            self.as_it_was(BEYOND, "all", words, ~self.inside, ends)
            self.flags[BEYOND] = ~self.inside
        parts = {}
        for label in self.data:
            parts[label] = self.data[label]
            if label in self.originals:
                parts[f"{label}{ORIGINAL}"] = self.originals[label]
        if self.times is not None:
            parts[TIME] = pd.Series(self.times, self.data.index)
        parts[FLAGS] = self.causes()
        data = pd.DataFrame(parts)
        data.attrs = self.data.attrs
        table = pd.DataFrame(self.actions, columns=list(ACTIONS))
        return CorrectedRecord(data, table)

    def causes(self) -> pd.Series:
        """Names of the causes by which each row is corrected."""
        code = np.zeros(len(self.data), dtype=int)
        for i, rows in enumerate(self.flags.values()):
            code += rows.astype(int) << i
        there, code = np.unique(code, return_inverse=True)
        words = [
            ", ".join(name for i, name in enumerate(self.flags) if one >> i & 1)
            for one in there
        ]
        labels = pd.Categorical.from_codes(code, pd.Index(words))
        return pd.Series(labels, self.data.index)


def ends_of(times: pd.DatetimeIndex) -> tuple[str, str]:
    """First and last of some times, as they are written."""
    return str(times[0]), str(times[-1])
