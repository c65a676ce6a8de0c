"""The screening of a record in memory, the same for all that takes one."""

from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd

from pvlib_fem._record.clean import CleanRecord, FrameRecord
from pvlib_fem._record.column_names import ALIASES, RENAMED, printable, with_aliases
from pvlib_fem._record.inputs import Columns, Record, read
from pvlib_fem._record.ranges import range_of
from pvlib_fem.quality._file_scan import Look
from pvlib_fem.quality._limits import POSSIBLE, Limits
from pvlib_fem.quality._screening import KINDS, Screener, fault_sentences
from pvlib_fem.quality._stray_times import refuse_stray, stray_rows
from pvlib_fem.quality._unit_checks import oddities, refuse_doubtful, refuse_units


@dataclass(frozen=True, eq=False)
class Faults:
    """What was found in the columns of a record."""

    record: Record  # as it came
    masks: dict = field(default_factory=dict)  # kind to column to rows
    clipped: int = 0  # rows of a little negative irradiance by night
    look: Look | None = None  # at its columns, less what was found

    def faulty_rows(self, name: str, besides: tuple = ()) -> np.ndarray:
        """Rows in which a column is at fault."""
        rows = np.zeros(len(self.record.index), dtype=bool)
        for kind, columns in self.masks.items():
            if kind not in besides and name in columns:
                rows |= columns[name]
        return rows

    @property
    def impossible(self) -> dict[str, int]:
        """Rows of each column that were not measured, those that repeat aside."""
        masks = {
            name: self.faulty_rows(name, ("stuck",))
            for name in self.record.inputs.columns
        }
        return {name: int(np.count_nonzero(rows)) for name, rows in masks.items()}

    @property
    def counts(self) -> pd.DataFrame:
        """A row for each column and kind."""
        rows = []
        for kind, columns in self.masks.items():
            for name, at in columns.items():
                first = int(np.argmax(at))
                time, value = self.record.index[first], float(self.record[name][first])
                rows.append((name, kind, int(at.sum()), time, value))
        return pd.DataFrame(rows, columns=["column", "kind", "rows", "first", "value"])

    @property
    def notes(self) -> tuple[str, ...]:
        """The findings in sentences."""
        return fault_sentences(self.counts.itertuples())

    def and_in(self, rows: np.ndarray, other: "Faults") -> "Faults":
        """The faults with those of temp_module in some rows from another."""
        name, masks = "temp_module", {}
        for kind in KINDS:
            columns = dict(self.masks.get(kind, {}))
            there = columns.get(name, False) | (
                other.masks.get(kind, {}).get(name, False) & rows
            )
            if np.any(there):
                columns[name] = there
            if columns:
                masks[kind] = columns
        return replace(self, record=other.record, masks=masks, look=None)


def screened(
    record: Record, limits: Limits | None = None, check_units: bool = True
) -> tuple[Record, Faults]:
    """
    A record without what was not measured, and what that is.

    Parameters
    ----------
    record : Record
        As it came.
    limits : Limits, optional
        The thresholds.
    check_units : bool, default True
        Refuse columns that look to be in another unit.

    Returns
    -------
    Record, Faults
        NaN where a value is at fault; irradiance that is a little negative by night is
        0.

    Raises
    ------
    ValueError
        Beside units: if one of the four columns holds nothing but fill values, is
        impossible in more than a fifth of its rows, or never moves. Wind that never
        moves may stand for no anemometer.
    """
    limits = limits or Limits()
    refuse_stray(record.index, limits)
    screening, clipped = by_columns(record, limits, check_units)
    screening.stuck()
    if check_units:
        refuse_doubtful(screening.sampled().columns, limits)
    return less(record, screening, clipped)


def screened_alone(
    record: Record,
    limits: Limits,
    check_units: bool = True,
    names: tuple | None = None,
    late: bool = False,
    known: Look | None = None,
) -> tuple[Record, Faults]:
    """
    Screen all but stuck sensors, which need other columns.

    Parameters
    ----------
    record : Record
        As it came.
    limits : Limits
        The thresholds.
    check_units : bool, default True
        Refuse columns that look to be in another unit.
    names : tuple of str, optional
        Columns that are screened, by default all.
    late : bool, default False
        Accept a module whose clock is off by hours.
    known : Look, optional
        At some of these columns, which are not read again.

    Returns
    -------
    Record, Faults
        As of :func:`screened`.

    Raises
    ------
    ValueError
        If a column looks to be in another unit, or one of the four columns has no value
        but fill values, or too many that are impossible.
    """
    screening, clipped = by_columns(record, limits, check_units, names, late, known)
    clean, faults = less(record, screening, clipped)
    return clean, replace(faults, look=screening.look)


def by_columns(
    record: Record,
    limits: Limits,
    check_units: bool = True,
    names: tuple | None = None,
    late: bool = False,
    known: Look | None = None,
) -> tuple[Screener, int]:
    """What the rules find that look at one column, and rows of offset by night."""
    screening = screener(record, limits, names, known)
    screening.fills()
    screening.refuse_empty()
    if check_units:
        refuse_units(screening.judged(), limits, late, record.stated)
    clipped = screening.rules()
    screening.refuse_impossible()
    screening.ends()
    return screening, clipped


def screener(
    record: Record,
    limits: Limits,
    names: tuple | None = None,
    known: Look | None = None,
) -> Screener:
    """The screening of a record in memory, before any rule."""
    clean = CleanRecord(FrameRecord(record.inputs), tuple(record.inputs.columns))
    return Screener.from_record(clean, limits, names, known)


def less(record: Record, screening: Screener, clipped: int) -> tuple[Record, Faults]:
    """A record without the values at fault, and the faults."""
    faults = Faults(record, screening.masks(), clipped)
    holes = {name: faults.faulty_rows(name) for name in screening.clean.holes}
    clean = record.lacking(holes) if holes else record
    if (below := clean["poa_global"] < 0).any():
        clean = clean.put(0.0, {"poa_global": below})
    return replace(clean, impossible=faults.impossible, clipped=clipped), faults


@dataclass(frozen=True, eq=False)
class Screening:
    """
    What a record holds that was not measured; ``print(screening)`` says it.

    Attributes
    ----------
    masks : dict of DataFrame
        By kind (``"fill value"``, ``"all zero"``, ``"negative by day"``, ``"lone
        zero"``, ``"out of range"``, ``"light by night"``, ``"spike"``, ``"end of
        range"``, ``"stuck"``):
        booleans in the form of the data, True where a value is at fault. They join
        with those of pvanalytics by ``&`` and ``|``.
    counts : DataFrame
        A row for each column and kind that was found: ``column``, ``kind``, ``rows``,
        ``first`` (its time) and ``value`` (there).
    notes : tuple of str
        The findings in sentences, and what looks odd without being at fault.
    cleaned : DataFrame
        The data with NaN where a value is at fault. Irradiance that is a little
        negative by night, a pyranometer's offset, is 0.
    clipped : int
        Rows of that offset.
    """

    masks: dict = field(repr=False)
    counts: pd.DataFrame
    notes: tuple
    cleaned: pd.DataFrame = field(repr=False)
    clipped: int = 0

    @property
    def mask(self) -> pd.DataFrame:
        """True where a value is at fault for any reason."""
        at_fault = np.any([mask.to_numpy() for mask in self.masks.values()], axis=0)
        return pd.DataFrame(at_fault, self.cleaned.index, self.cleaned.columns)

    def __str__(self) -> str:
        rows = f"{len(self.cleaned):,} rows"
        if not self.notes:
            return f"{rows}: nothing at fault was found"
        return "\n".join([rows, *(f"note: {note}" for note in self.notes)])


def screen_record(data: pd.DataFrame, limits: Limits | None = None) -> Screening:
    """
    Find what a record holds that was not measured, before anything is fitted.

    :func:`pvlib_fem.fit_fem`, :func:`pvlib_fem.close_loop` and
    :func:`pvlib_fem.rank_effects` leave out the same by themselves, and their notes
    say what.

    Parameters
    ----------
    data : DataFrame
        With a DatetimeIndex and columns in pvlib's names: any of ``poa_global``
        [W/m²], ``temp_air``, ``temp_module`` [°C], ``wind_speed`` [m/s], of the
        drivers of effects, and of further ones, of which less is known. Columns that
        are not numeric stay as they are, and ``notes`` name those of known quantities.
    limits : Limits, optional
        The thresholds; by default those of :class:`pvlib_fem.quality.Limits`.

    Returns
    -------
    Screening

    Raises
    ------
    ValueError
        If the times are unusable, a column is there twice or holds an infinity.

    Notes
    -----
    *Fill values* are a logger's codes (−999, −6999, 7999, −327.67, ...) where they lie
    outside what the column can hold or, in a column that is not known, well away from
    all else; and values that repeat at ten times all else. *All zero* are rows
    of exactly 0 in all four usual columns at once, where one of both temperatures is
    well away from 0 before and after. *Out of range* is what no
    sensor can have measured. *Negative by day* is irradiance below 0 at a time of day
    that is light on the days around; *light by night* irradiance above 20 W/m² more
    than six hours from noon, at a time that is dark on four of five nights around and
    has no light within an hour and a half of it. *Lone zeros* are up to three rows
    of exactly 0, a value that some loggers write for none: irradiance between values of
    100 W/m² and more, and air or module between values from which it hardly came, by
    how often it came as far to any other. *Spikes* are changes there and back that the
    heat capacity of module or air forbids. *End of range* is where a sensor or its
    logger stops, and stays, on several days; of light, air and wind the half hour after
    it is dropped, too, which a module remembers. *Stuck* are values that repeat for far
    longer than their column's own changes make likely, while what moves them moves: but
    for wind and drivers that takes all four columns. What is usual in a column is taken
    from a million of its rows, evenly spaced. False findings are in :doc:`/quality`.

    Examples
    --------
    >>> import pvlib_fem as fem
    >>> data = fem.datasets.synthetic(days=3, step=600)
    >>> data.iloc[[60, 61], data.columns.get_loc("poa_global")] = -7999.0
    >>> screening = fem.screen_record(data)
    >>> screening.counts[["column", "kind", "rows", "value"]]
           column        kind  rows   value
    0  poa_global  fill value     2 -7999.0
    >>> int(screening.mask.to_numpy().sum())
    2
    >>> int(screening.cleaned["poa_global"].isna().sum())
    2
    """
    limits = limits or Limits()
    record, labels = of_frame(data)
    screening = screener(record, limits)
    screening.fills()
    others = [printable(label) for label in data if label not in labels.values()]
    others = [name for name in others if range_of(name) is not None]
    odd = [f"{name} is not numeric and was not screened" for name in others]
    odd += stray_rows(record.index, limits)
    odd += oddities(screening.judged(), limits)
    clipped = screening.rules()
    odd += [f"{name} {reason}" for name, reason in screening.doubts.items()]
    screening.ends()
    screening.stuck(refuse=False)
    clean, faults = less(record, screening, clipped)
    masks = {kind: pd.DataFrame(False, data.index, data.columns) for kind in KINDS}
    cleaned = data.copy()
    for kind, columns in faults.masks.items():
        for name, rows in columns.items():
            masks[kind][labels[name]] = rows
    for name, label in labels.items():
        if faults.faulty_rows(name).any() or (name == "poa_global" and faults.clipped):
            cleaned[label] = clean[name]
    counts = faults.counts.replace({"column": {n: str(c) for n, c in labels.items()}})
    return Screening(masks, counts, (*faults.notes, *odd), cleaned, faults.clipped)


def of_frame(data: pd.DataFrame) -> tuple[Record, dict]:
    """The numeric columns of a frame as a record, and what the frame calls them."""
    columns, labels = with_aliases(data, ()), labels_of(data)
    numeric = {n: c for n, c in columns.items() if pd.api.types.is_numeric_dtype(c)}
    inputs = read(numeric, purpose="a screening")
    lacking = dict.fromkeys(POSSIBLE, np.full(len(data), np.nan))
    inputs = replace(inputs, columns=Columns(lacking) | inputs.columns)
    return Record(inputs, {}, {}, 0), {name: labels[name] for name in numeric}


def labels_of(data: pd.DataFrame) -> dict:
    """
    The label of each column of a frame, by the package's name.

    Parameters
    ----------
    data : pandas.DataFrame, shape (rows, columns)
        The user's frame.

    Returns
    -------
    dict
        Labels by name; columns with an older name have both.
    """
    labels = {printable(label): label for label in data}
    others = {**ALIASES, **RENAMED}
    return {new: labels[old] for old, new in others.items() if old in labels} | labels
