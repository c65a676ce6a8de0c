"""The screening of a record block by block, whether it is in memory or in files."""

from collections import namedtuple
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.clean import (
    CleanRecord,
    FrameRecord,
    count_rows,
    spans,
    spans_mask,
    united_spans,
)
from pvlib_fem._record.column_names import GEOMETRY, ROTATION
from pvlib_fem._record.header_units import of_any_unit
from pvlib_fem._record.inputs import Inputs, Record
from pvlib_fem._record.ranges import possible_range
from pvlib_fem.quality._all_zero import all_zero_rows
from pvlib_fem.quality._file_scan import Look
from pvlib_fem.quality._light_table import LightTable, light_by_night
from pvlib_fem.quality._limits import DRIVERS, FASTEST, POSSIBLE, Limits
from pvlib_fem.quality._outliers import (
    at_end,
    codes_apart,
    is_switch,
    range_ends,
    rows_outside,
)
from pvlib_fem.quality._repetitions import rest_of
from pvlib_fem.quality._stuck import (
    always_stuck_error,
    always_stuck_line,
    becalmed,
    may_rest,
    stuck_spans,
)
from pvlib_fem.quality._unit_checks import doubtful
from pvlib_fem.quality._values import changes, never_moves

PLACED = (*GEOMETRY, ROTATION)  # angles, which no rule checks

#: what was found of one kind in one column, as Faults.counts has it
FaultRow = namedtuple("FaultRow", "column kind rows first value")

#: faults of a value, in the order in which they are checked, and how
#: it is said after the column's name
KINDS = {
    "fill value": "holds the fill value {value:.7g}",
    "all zero": "stood at exactly {value:g} at once, as if communication failed,",
    "negative by day": "is negative by day, as {value:.4g},",
    "lone zero": "is exactly {value:g} between values that do not lead to it,",
    "out of range": "is outside {low:g} … {high:g} {unit}, as {value:.5g},",
    "light by night": "is light by night, as {value:.4g}, when other nights are dark,",
    "spike": "jumps and returns faster than it can, as to {value:.5g},",
    "end of range": "stays at {value:.5g}, the end of its range, or did just before,",
    "stuck": "is stuck at {value:g}",
}


def fault_sentences(rows: Iterable) -> tuple[str, ...]:
    """
    What was found, in one line for each column, or for columns that failed together.

    Parameters
    ----------
    rows : iterable of FaultRow
        Or rows of ``Faults.counts`` as named tuples: ``column``, ``kind``, number of
        ``rows``, time of the ``first``, and ``value`` there.

    Returns
    -------
    tuple of str
        Sentences without full stops.
    """
    groups: dict = {}
    for row in rows:
        together = (row.rows, row.first) if row.kind == "all zero" else row.column
        groups.setdefault((row.kind, together), []).append(row)
    return tuple(
        fault_sentence(some[0]._replace(column=", ".join(one.column for one in some)))
        for some in groups.values()
    )


def fault_sentence(row: Any) -> str:
    """What was found in one column, in one line."""
    low, high, unit = possible_range(row.column) or (0, 0, "")
    what = KINDS[row.kind].format(value=row.value, low=low, high=high, unit=unit)
    many = f"in {row.rows:,} rows, first at" if row.rows > 1 else "at"
    return f"{row.column} {what} {many} {row.first}: not used"


def empty_error(row: "FaultRow") -> ValueError:
    """The error of a column in which nothing but one kind of fault was found."""
    return ValueError(
        f"{row.column} holds nothing but the fill value {row.value:g}, from "
        f"{row.first} on; check the column's name and the logger"
    )


def refuse_share(
    name: str, share: float, value: float, time: pd.Timestamp, limits: Limits
) -> None:
    """Refuse a column of which too large a share cannot be, as ``value`` cannot."""
    if share > limits.max_impossible_share:
        low, high, unit = possible_range(name)
        raise ValueError(
            f"{100 * share:.0f} % of {name} is physically impossible (outside {low:g} "
            f"… {high:g} {unit}), first {value:g} at {time}; check its unit and sensor"
        )


@dataclass(eq=False)
class Screener:
    """A record less what was found in it so far."""

    clean: CleanRecord
    limits: Limits
    tested: tuple  # columns
    look: Look
    doubts: dict = field(default_factory=dict)  # columns in another unit, and why
    fault_spans: dict = field(default_factory=dict)  # kind to column to spans of rows
    first: dict = field(default_factory=dict)  # time and value of the first of them

    @classmethod
    def from_record(
        cls,
        clean: CleanRecord,
        limits: Limits,
        tested: tuple | None = None,
        known: Look | None = None,
    ) -> "Screener":
        """The screening of a record, before any rule; of some columns or of all."""
        look = Look.from_record(clean, limits, known)
        return cls(clean, limits, clean.names if tested is None else tested, look)

    def rules(self) -> int:
        """Every other rule that looks at one column; rows of offset by night."""
        sample, clipped = self.sampled(), 0
        self.doubts = doubtful(sample.columns, self.limits)
        if "poa_global" in self.tested:
            clipped = self.negative_by_day()
        self.lone_zeros()
        for kind in ("out of range", "spike"):
            for name, one in self.ruled():
                self.note(kind, name, *one.rows_of(kind))
        for name, one in self.ruled():
            if possible_range(name) is None:  # of which a lone one is a spike
                far = self.limits.min_fill_ratio**3
                self.note("spike", name, *one.beyond(self.clean, sample[name], far, 1))
        if "poa_global" in self.tested and "poa_global" not in self.doubts:
            self.light_by_night()
        return clipped

    def lone_zeros(self) -> None:
        """Take zeros out that stand for no value: those around do not lead to them."""
        sample, step, again = self.sampled(), self.look.step, False
        for name, one in self.ruled():
            rows, times, number, depth = one.zeros_within(step)
            if not len(rows) or is_switch(sample[name], self.limits):
                continue
            if name != "poa_global":
                zeros = number, depth
                found = one.improbable(zeros, self.clean, sample[name], step)
                rows, times = rows[found], times[found]
            self.note("lone zero", name, rows, times, np.zeros(len(rows)))
            again |= len(rows) > 0
        if again:  # between two of them a value looks like a spike
            self.look_again()

    def sampled(self) -> Inputs:
        """Some rows of the record, as it is screened so far."""
        return self.look.sampled(self.clean)

    def judged(self) -> Inputs:
        """Rows that identify units: without what no unit explains, and range ends."""
        sample, lost = self.sampled(), {}
        numbers = np.arange(len(sample.index)) * self.look.every
        for name in POSSIBLE:
            spikes = self.look.columns[name].rows_of("spike")[0]
            values = sample[name]
            ends = range_ends(name, values, sample.index, self.limits)
            rows = rows_outside(values, *of_any_unit(name)) | np.isin(values, ends)
            if (rows := rows | np.isin(numbers, spikes)).any():
                lost[name] = rows
        return sample.having(sample.columns.put(np.nan, lost)) if lost else sample

    def ruled(self) -> Iterator:
        """Columns that the rules check."""
        for name, one in self.look.columns.items():
            if name in self.tested and name not in self.doubts and name not in PLACED:
                yield name, one

    def note(
        self,
        kind: str,
        name: str,
        rows: np.ndarray,
        times: np.ndarray,
        values: np.ndarray,
    ) -> None:
        """Take rows of one kind out of a column, with what is said of the first."""
        if len(rows):
            at = int(np.argmin(rows))
            time = self.clean.source.time_at(times[at])
            self.take(kind, name, spans(np.sort(rows)), time, values[at])

    def note_parts(self, kind: str, name: str, parts: list) -> bool:
        """Take rows that were found in blocks out of a column, if there are any."""
        if not (some := [part for part in parts if len(part[0])]):
            return False
        self.note(kind, name, *map(np.concatenate, zip(*some)))
        return True

    def take(
        self, kind: str, name: str, rows: np.ndarray, time: pd.Timestamp, value: float
    ) -> None:
        before = self.fault_spans.setdefault(kind, {}).get(name)
        if before is None or rows[0, 0] < before[0, 0]:
            self.first[kind, name] = time, float(value)
        both = rows if before is None else united_spans(before, rows)
        self.fault_spans[kind][name] = both
        self.clean = self.clean.lacking({name: rows})

    def look_again(self) -> None:
        """The look at the remaining values, if a rule removed some that others see."""
        self.look = Look.from_record(self.clean, self.limits, self.look)

    def refuse_nothing(self, needed: tuple) -> dict[str, int]:
        """Refuse a column without a value."""
        at, rows = self.clean.source.time_at, self.look.rows
        missing = {name: one.missing for name, one in self.look.columns.items()}
        if empty := [name for name in needed if missing[name] == rows]:
            first, last = map(at, self.look.ends)
            raise ValueError(
                f"{empty[0]} holds no value from {first} to {last}; check the column's "
                "name and the logger"
            )
        return missing

    def fills(self) -> None:
        """Values that stand for none: codes, and what repeats far beyond all else."""
        limits, again = self.limits, False
        sample = self.sampled()
        for name, one in self.ruled():
            rows, times, values = one.rows_of("fill value")
            if possible_range(name) is None and len(rows):
                rounded, rest = np.round(values, 2), sample[name]
                rest = rest[np.isfinite(rest) & ~np.isin(rest, values)]
                codes = codes_apart(np.unique(rounded), rest, limits)
                kept = np.isin(rounded, codes)
                rows, times, values = rows[kept], times[kept], values[kept]
                again |= len(rows) > 0
            self.note("fill value", name, rows, times, values)
        if again:
            self.look_again()
        sample, again = self.sampled(), False
        for name, one in self.ruled():
            if one.known:
                far = limits.min_fill_ratio**2, limits.max_accident_rows
                far = one.beyond(self.clean, sample[name], *far)
                self.note("fill value", name, *far)
                again |= len(far[0]) > 0
        if again:
            self.look_again()
        self.all_zero()

    def all_zero(self) -> None:
        """Take rows out in which the logger wrote 0 into all columns."""
        temps = [self.look.columns[name] for name in FASTEST]
        if not all(one.known for one in temps):
            return
        if not any(one.low <= 0.0 <= one.high for one in temps):
            return
        limits = self.limits

        def margin(name: str) -> float:
            sample = self.sampled()[name]
            steps = changes(np.where(sample == 0, np.nan, sample))
            usual = 1.0 - limits.max_accident_share
            farthest = np.quantile(steps, usual) if len(steps) else np.inf
            return float(limits.temperature_tolerance + farthest)

        rows, times = all_zero_rows(self.clean, [*FASTEST], margin)
        if not len(rows):
            return
        for name, _ in [*self.ruled()]:
            values = np.concatenate(
                [
                    block[name][np.isin(block.times, times)]
                    for block in self.clean.blocks((name,))
                ]
            )
            zero = values == 0
            self.note("all zero", name, rows[zero], times[zero], values[zero])
        self.look_again()

    def refuse_empty(self) -> None:
        """Refuse one of the four columns without any remaining value."""
        for row in self.faults():
            if row.column in POSSIBLE and not self.look.columns[row.column].known:
                raise empty_error(row)

    def negative_by_day(self) -> int:
        """Take negative irradiance by day out; rows of it by night come back."""
        if not self.look.columns["poa_global"].least < 0:
            return 0
        light, below, parts = LightTable(self.days, self.limits), 0, []
        for block in self.clean.blocks(("poa_global",)):
            poa = block["poa_global"]
            light.add(block.index, np.where(poa < 0, np.nan, poa))
        sunny = light.sunny()
        for block in self.clean.blocks(("poa_global",)):
            poa = block["poa_global"]
            rows = np.flatnonzero(poa < 0)
            below += len(rows)
            rows = rows[sunny[light.places(block.index[rows])]]
            parts.append((rows + block.start, block.times[rows], poa[rows]))
        if self.note_parts("negative by day", "poa_global", parts):
            self.look_again()
        by_day = sum(len(rows) for rows, *_ in parts)
        beyond = self.look.columns["poa_global"].rows_of("out of range")[2]
        return below - by_day - int((beyond < 0).sum())

    def light_by_night(self) -> None:
        """Take irradiance out that is there at night, where other nights are dark."""
        parts = light_by_night(self.clean, self.days, self.look.step, self.limits)
        if self.note_parts("light by night", "poa_global", parts):
            self.look_again()

    @property
    def days(self) -> np.ndarray:
        """Sorted days with rows, since 1970-01-01."""
        return np.array(sorted(self.look.days))

    def ends(self) -> None:
        """Take out the end of a sensor's range; the offset of a night is 0."""
        again = False
        sample = self.sampled()
        for name, _ in self.ruled():
            ends = range_ends(name, sample[name], sample.index, self.limits)
            parts, since = [], -np.inf  # when it was there last
            for block in self.clean.blocks((name,)) if ends else ():
                values, since_first = block[name], block.times - self.look.ends[0]
                seconds = since_first * self.look.unit
                given = name, values, seconds, ends, self.limits, since
                rows = np.flatnonzero(at_end(*given))
                parts.append((rows + block.start, block.times[rows], values[rows]))
                there = np.isin(values, ends)
                since = max(since, seconds[there].max(initial=since))
            again |= self.note_parts("end of range", name, parts)
        if again:
            self.look_again()
        self.clean = self.clean.clipped()

    def refuse_impossible(self) -> None:
        """Refuse a record of which too much cannot be, or is negative by day."""
        for name in POSSIBLE:
            kinds = "out of range", "negative by day"
            there = [kind for kind in kinds if name in self.fault_spans.get(kind, {})]
            if not there:
                continue
            by_kind = {kind: self.fault_spans[kind][name] for kind in there}
            total = self.look.columns[name].known
            total += count_rows(by_kind.get("negative by day", spans([])))
            share = sum(map(count_rows, by_kind.values())) / max(total, 1)
            first = min(by_kind, key=lambda kind, by_kind=by_kind: by_kind[kind][0, 0])
            time, value = self.first[first, name]
            refuse_share(name, share, value, time, self.limits)

    def stuck(self, refuse: bool = True) -> None:
        """Take out stuck values, or refuse a sensor that is always stuck."""
        clean, columns = self.clean, self.look.columns
        sample = self.sampled()
        rests = {n: rest_of(n, sample[n], self.limits) for n in clean.names}
        runs = self.look.repetitions(rests)
        still = stuck_spans(clean, runs, rests, self.limits)
        wind = columns["wind_speed"]
        if refuse and wind.never_moves:  # a number that stands for all wind
            still.pop("wind_speed", None)
        whole = [n for n in still if n in POSSIBLE and columns[n].never_moves]
        if whole and refuse:
            first, last = map(clean.source.time_at, self.look.ends)
            values = {name: max(columns[name].low, 0.0) for name in whole}
            lines = [always_stuck_line(n, v, first, last) for n, v in values.items()]
            raise always_stuck_error(whole[0], lines)
        for name, rows in still.items():
            one = runs[name]
            at = int(np.flatnonzero(one.first == rows[0, 0])[0])
            time = clean.source.time_at(one.begin[at])
            self.take("stuck", name, rows, time, one.value[at])
        wind, rest = sample["wind_speed"], rests["wind_speed"]
        usual = self.look.step * self.look.every
        if not never_moves(wind) and may_rest(wind, rest, 2.0 * usual, self.limits):
            calm = becalmed(clean, self.look.step, rest, self.limits)
            self.note("stuck", "wind_speed", *calm)

    def faults(self) -> Iterator[FaultRow]:
        """The faults, in the order of kinds and columns."""
        for kind in KINDS:
            for name in self.clean.names:
                if name in self.fault_spans.get(kind, {}):
                    rows = count_rows(self.fault_spans[kind][name])
                    yield FaultRow(name, kind, rows, *self.first[kind, name])

    def masks(self) -> dict[str, dict[str, np.ndarray]]:
        """Booleans of all rows, by kind and column."""
        rows = len(self.clean)
        return {
            kind: {
                name: spans_mask(self.fault_spans[kind][name], rows)
                for name in self.clean.names
                if name in self.fault_spans[kind]
            }
            for kind in KINDS
            if kind in self.fault_spans
        }


def stuck_rows(
    record: Record, limits: Limits | None = None, known: Look | None = None
) -> dict[str, np.ndarray]:
    """
    Rows in which a sensor is stuck while its driver changes.

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
    * ``relative_humidity``, ``longwave_down``, ``p_dc_per_area`` and ``precipitation``
      after a day, ``wind_direction`` after three. Other columns may stay, as a
      timetable does.

    After three days in which the others move, the first three are stuck whatever
    they usually do.

    Parameters
    ----------
    record : Record
        With the four columns that every fit needs.
    limits : Limits, optional
        The thresholds; those above by default.
    known : Look, optional
        At some of these columns, which are not read again.

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
    columns = record.inputs.columns
    names = [*POSSIBLE, *(n for n in DRIVERS if n in columns and n not in POSSIBLE)]
    clean = CleanRecord(FrameRecord(record.inputs), tuple(names))
    screening = Screener.from_record(clean, limits or Limits(), known=known)
    screening.stuck(refuse=False)
    still = screening.masks().get("stuck", {})
    still = {name: rows for name, rows in still.items() if name not in record.absent}
    none = np.zeros(len(record.index), dtype=bool)
    return {name: still.get(name, none) & np.isfinite(record[name]) for name in names}
