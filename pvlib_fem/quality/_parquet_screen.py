"""A record in files without what was not measured."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from pvlib_fem._record.clean import CleanRecord
from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem._record.parquet import ParquetRecord
from pvlib_fem.quality._file_scan import Look
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._screening import Screener, fault_sentences
from pvlib_fem.quality._unit_checks import oddities, refuse_doubtful, refuse_units


@dataclass(frozen=True, eq=False)
class Screened:
    """A record in files without what was not measured, and what that was."""

    record: CleanRecord
    look: Look
    fault_rows: tuple = ()  # of FaultRow
    odd: tuple = ()  # what looks odd without being at fault
    missing: dict = field(default_factory=dict)
    clipped: int = 0

    @property
    def notes(self) -> tuple[str, ...]:
        lines = fault_sentences(self.fault_rows)
        source: Any = self.record.source  # of files, which have notes
        return (*source.notes, *lines, *self.odd)

    @property
    def impossible(self) -> dict[str, int]:
        """Rows of each column that were not measured, those that repeat aside."""
        counts = Counter()
        for one in self.fault_rows:
            counts[one.column] += one.rows if one.kind != "stuck" else 0
        return {name: counts[name] for name in self.record.names}


def screened_blocks(
    source: ParquetRecord,
    drivers: Sequence = (),
    limits: Limits | None = None,
    check_units: bool = True,
    needed: Any = None,
) -> Screened:
    """
    A record in files without what was not measured, from few passes over them.

    Rules that need the usual values of a column (its unit, codes where its range is not
    known) are answered by a million of its rows, evenly taken.

    Parameters
    ----------
    source : ParquetRecord
        The files.
    drivers : sequence of str
        Columns in addition to the usual four.
    limits : Limits, optional
        The thresholds.
    check_units : bool, default True
        Refuse columns that look to be in another unit.
    needed : sequence of str, optional
        Columns that have to hold a value, by default all.

    Returns
    -------
    Screened

    Raises
    ------
    ValueError
        As :func:`pvlib_fem.quality._screen.screened`.
    """
    clean = CleanRecord(source, (*COLUMNS, *drivers))
    needed = clean.names if needed is None else needed
    screening = Screener.from_record(clean, limits or Limits())
    limits = screening.limits
    screening.look.refuse_gaps(limits, source)
    missing = screening.refuse_nothing(needed)
    screening.fills()
    screening.refuse_empty()
    if check_units:
        refuse_units(screening.judged(), limits, stated=source.stated)
    clipped = screening.rules()
    screening.refuse_impossible()
    screening.ends()
    screening.stuck()
    sample = screening.sampled()
    if check_units:
        refuse_doubtful(sample.columns, limits)
    faults, odd = (
        tuple(screening.faults()),
        tuple(oddities(sample, limits, source.absent)),
    )
    screening.look.forget()
    return Screened(screening.clean, screening.look, faults, odd, missing, clipped)
