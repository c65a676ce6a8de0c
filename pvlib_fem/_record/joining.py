"""Several files as one: of several loggers, or the months of one."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.checks import instants, usual_step
from pvlib_fem._record.column_names import ANGLES, is_state

LEAST = 0.5  # share of the shorter file's rows that has to find a partner


def joined_tables(
    tables: list, names: list, columns: Mapping
) -> tuple[pd.DataFrame, list]:
    """
    Tables on common times, those of the one with the longest step.

    A row gets of another table the row nearest to it, up to half a step away. Of a
    table with steps less than half as long it gets the means over the step that ends
    there, but of what :func:`is_state` says the value then, since it is no flow.

    Parameters
    ----------
    tables : list of DataFrame
        With a DatetimeIndex each, sorted.
    names : list of str
        Of the files. A column that an earlier table has already is called
        ``"<column> (<name>)"``.
    columns : dict
        Package's names to those of the files.

    Returns
    -------
    DataFrame, list of str
        The table, and what was done.

    Raises
    ------
    ValueError
        If only some have a zone, times do not rise, or fewer than half of the shorter
        table's rows find a partner.
    """
    if len(tables) == 1:
        return tables[0], []
    zones = [getattr(table.index, "tz", None) for table in tables]
    if len({zone is None for zone in zones}) > 1:
        without = names[zones.index(None)]
        raise ValueError(
            f"the times of {without} have no zone and those of another file have one; "
            "give --tz once for each file, in their order"
        )
    for table, name in zip(tables, names):
        refuse_disorder(table, name)
    tables = [t.tz_convert(zones[0]) if zones[0] else t for t in tables]
    steps = [float(np.nan_to_num(usual_step(table.index))) for table in tables]
    base = int(np.argmax(steps))
    apart = distinct(tables, names)
    whole = apart[base]
    notes, own = [], {column: name for name, column in columns.items()}
    for i, table in enumerate(apart):
        if i == base:
            continue
        states = {c for c in table if is_state(str(own.get(c, c)))}
        directions = {columns.get(name, name) for name in ANGLES}
        part = onto(table, whole.index, steps[base], steps[i], states, directions)
        in_both = int(part.notna().any(axis=1).sum())
        if in_both < LEAST * min(len(table), len(whole)):
            raise ValueError(
                f"only {in_both:,} of the {len(whole):,} times of {names[base]} are in "
                f"{names[i]}: it has {span_text(table)}, the other {span_text(whole)}; "
                "give --tz once for each file if their clocks are in different zones"
            )
        how = "nearest rows" if steps[i] > steps[base] / 2.0 else "means over its steps"
        notes.append(
            f"{names[i]} joined to {names[base]}, {how}: {in_both:,} of {len(whole):,} "
            "times are in both"
        )
        whole = whole.join(part)
    return whole[[column for table in apart for column in table]], notes


def stacked_tables(
    tables: list, names: list, overlap: bool = False
) -> tuple[pd.DataFrame, str]:
    """
    Pieces of one logger, one after the other in time, and what they are called.

    Parameters
    ----------
    tables : list of DataFrame
        With a DatetimeIndex each, in any order.
    names : list of str
        Of the files.
    overlap : bool
        Whether one may begin before another ends: rows are put in order later.

    Returns
    -------
    DataFrame, str

    Raises
    ------
    ValueError
        If the pieces differ in their columns, only some have a zone, or one begins
        before another ends.
    """
    if len(tables) == 1:
        return tables[0], names[0]
    order = sorted(range(len(tables)), key=lambda i: (first_time(tables[i]), names[i]))
    tables, names = [tables[i] for i in order], [names[i] for i in order]
    first, usual = tables[0], set(tables[0].columns)
    for table, name in zip(tables, names):
        if odd := usual ^ {*table.columns}:
            raise ValueError(
                f"{name} and {names[0]} are pieces of one record, and one of them "
                f"has no column{'s' * (len(odd) > 1)} "
                f"{', '.join(sorted(map(str, odd)))}; give both the same columns"
            )
        if (table.index.tz is None) != (first.index.tz is None):
            raise ValueError(
                f"the times of one of {names[0]} and {name} have no zone; give --tz"
            )
    for before, after, *both in zip(tables, tables[1:], names, names[1:]):
        if not overlap and first_time(after) <= last_time(before):
            raise ValueError(
                f"{both[1]} begins at {after.index.min()}, before {both[0]} ends at "
                f"{before.index.max()}; give --sort and --drop-doubled to keep the "
                "first row of each time"
            )
    zone = first.index.tz
    same = [t.tz_convert(zone) if zone else t for t in tables]
    return pd.concat([t[first.columns] for t in same]), f"{names[0]} … {names[-1]}"


def first_time(table: pd.DataFrame) -> float:
    """The first time, as a number that is the same in any zone."""
    return table.index.min().timestamp() if len(table) else np.inf


def last_time(table: pd.DataFrame) -> float:
    """The last one."""
    return table.index.max().timestamp() if len(table) else -np.inf


def refuse_disorder(table: pd.DataFrame, name: str) -> None:
    back = np.diff(instants(table.index)) <= np.timedelta64(0, "s")
    if back.any():
        at = 1 + int(np.argmax(back))
        raise ValueError(
            f"the times of {name} go from {table.index[at - 1]} to {table.index[at]}; "
            "to join files they have to rise: give --sort, --drop-doubled, or --tz "
            "with a zone that has summer time"
        )


def span_text(table: pd.DataFrame) -> str:
    return f"{table.index[0]:%Y-%m-%d %H:%M} to {table.index[-1]:%Y-%m-%d %H:%M}"


def distinct(tables: list, names: list) -> list:
    """The tables, no column of which is called like one of another."""
    seen, apart = set(), []
    for table, name in zip(tables, names):
        new = {c: f"{c} ({name})" for c in table.columns if c in seen}
        apart.append(table.rename(columns=new))
        seen |= set(apart[-1].columns)
    return apart


def onto(
    table: pd.DataFrame,
    index: pd.DatetimeIndex,
    step: float,
    own: float,
    states: set,
    directions: set,
) -> pd.DataFrame:
    """
    A table on some times: the nearest rows, and of shorter steps the means.

    ``step`` is that of the times and ``own`` that of the table [s]; ``states`` are
    columns of which the value at the time is taken, not the mean before it.
    """
    reach = pd.Timedelta(seconds=own / 2.0)
    nearest = table.reindex(index, method="nearest", tolerance=reach)
    if own > step / 2.0 or index.empty:
        return nearest
    ends, at = instants(index), instants(table.index)
    place = np.searchsorted(ends, at)
    inside = place < len(ends)
    since = np.full(len(at), np.inf)
    since[inside] = (ends[place[inside]] - at[inside]) / np.timedelta64(1, "s")
    rows = since < step
    table, place = table[rows], place[rows]
    parts = {}
    for name, column in table.items():
        if not pd.api.types.is_numeric_dtype(column) or name in states:
            parts[name] = nearest[name].to_numpy()
            continue
        values = column.to_numpy(float, na_value=np.nan)
        parts[name] = means_at_places(values, place, len(index), name in directions)
    return pd.DataFrame(parts, index)


def means_at_places(values: Any, place: Any, size: int, angle: Any) -> np.ndarray:
    """Means of the rows at each of so many places, NaN where none is there."""
    if angle:
        turned = np.radians(values)
        east, north = (
            means_at_places(part, place, size, False)
            for part in (np.sin(turned), np.cos(turned))
        )
        return np.degrees(np.arctan2(east, north)) % 360.0
    there = ~np.isnan(values)
    counts = np.bincount(place[there], minlength=size)
    sums = np.bincount(place[there], values[there], size)
    return np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)
