"""How files may be read: proposed by names and data, never acted upon."""

import re
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem._record.formats import (
    clock_times,
    in_order,
    index_of,
    lines_after,
    time_columns,
    with_times,
    with_times_only,
)
from pvlib_fem._record.header_units import (
    QUANTITIES,
    UNITS,
    WHOLE,
    ForeignUnit,
    SwappedTemperatures,
    named_unit,
    own_unit,
    stated_unit,
    usual_name_of,
)
from pvlib_fem._record.kept_rows import good_texts, pairs_of, with_good_rows
from pvlib_fem._record.layout import Layout, found_layout
from pvlib_fem._record.logger_files import file_table, frame, texts
from pvlib_fem._record.long_tables import tag_and_value
from pvlib_fem._record.names import (
    NAMES,
    NOT,
    is_own,
    mapped,
    spelled_name,
    unused_columns,
    usual_name,
    without_unit,
)
from pvlib_fem._record.numbers import marks_of, mostly_numbers, thousands_of
from pvlib_fem._record.zone_candidates import zone_of, zone_of_offsets


@dataclass
class Guess:
    """What a file may be; ``doubts`` are what a person should look at."""

    layouts: list
    columns: dict
    units: dict = field(default_factory=dict)  # by name, from a line below the header
    headers: bool = False  # whether a header names another unit
    area: bool = False  # whether power has to be divided by one
    doubts: list = field(default_factory=list)
    free: list = field(default_factory=list)  # columns that have no meaning yet
    unused: dict = field(default_factory=dict)  # reason to columns that are not used

    @property
    def there(self) -> set[str]:
        """Names of the package that have a column."""
        return {*self.columns, *self.free}


def guess(
    files: Sequence,
    layouts: list,
    columns: Mapping,
    how: Mapping | None = None,
    place: Any = None,
    check: Callable | None = None,
    sensors: bool = False,
) -> Guess:
    """
    Propose how files are to be read.

    Parameters
    ----------
    files : list of Path
    layouts : list of Layout
        As given; its times and zone are kept.
    columns : dict
        Names that are mapped already.
    how : dict, optional
        Other arguments of :func:`pvlib_fem._record.logger_files.frame`.
    place : float, optional
        Longitude of the site. [°]
    check : callable, optional
        Refuses a frame in the package's names whose units look wrong.
    sensors : bool
        Map all module sensors.

    Returns
    -------
    Guess
    """
    guessed = Guess([], dict(columns))
    data, units = {}, {}
    for file, layout in zip(files, layouts):
        layout, below = found_layout(file, layout, usual_name)
        raw = file_table(file, layout)
        layout, raw = with_tags(file, layout, raw, guessed.doubts)
        layout = with_times(raw, layout, guessed.doubts, file.name)
        if layout.skip_end == 0 and (end := lines_after(raw, layout)):
            layout = replace(layout, skip_end=end)
            raw = file_table(file, layout)
            last = f"each of the last {end} lines" if end > 1 else "the last line"
            guessed.doubts.append(
                f"{last} holds no time in {file.name} and is left out by --skip-end"
            )
        layout, raw = with_times_only(raw, layout, guessed.doubts, file.name)
        layout, raw = with_cells(file, layout, raw, guessed.doubts)
        index = index_of(raw, layout)
        columns = raw.drop(columns=time_columns(raw, layout))
        if layout.tz is None and index is not None:
            sun = sunny(columns)
            zone = zone_of(index, place, sun, guessed.doubts)
            if index.tz is not None:
                zone = zone_of_offsets(clock_times(raw, layout), index)
            layout = replace(layout, tz=zone)
        guessed.layouts.append(in_order(raw, layout, file.name))
        for column in columns:
            name = f"{column} ({file.name})" if column in data else column
            data[name], units[name] = columns[column], below.get(column, "")
    names = tuple(NAMES)
    guessed.columns = mapped(data, guessed.columns, names, guessed.doubts, units)
    by_the_sun(data, guessed)
    if sensors:
        all_modules(data, guessed)
    taken = guessed.columns.values()
    guessed.free = [str(column) for column in data if column not in taken]
    not_taken = {column: data[column] for column in data if column not in taken}
    guessed.unused = unused_columns(not_taken, guessed.there)
    in_units(guessed, data, units)
    if check is not None:
        by_evidence(guessed, files, how or {}, check)
    of_wind(guessed, data)
    return guessed


def with_tags(
    file: Path, layout: Layout, raw: pd.DataFrame, doubts: list
) -> tuple[Layout, pd.DataFrame]:
    """The layout and table of a file with a row for each reading."""
    if layout.tag or isinstance(raw.index, pd.DatetimeIndex):
        return layout, raw
    timed = with_times(raw, layout, [], file.name)
    times = time_columns(raw, timed)
    if (pair := tag_and_value(raw, times)) is None:
        return layout, raw
    layout = replace(timed, tag=pair[0], value=pair[1])
    doubts.append(
        f"{file.name} has a row for each reading: each {pair[0]!r} is taken for a "
        f"column, with its {pair[1]!r}"
    )
    others = raw.columns.difference([*times, *pair])
    if not layout.keep and (good := good_texts(raw, others)):
        layout = replace(layout, keep=tuple(good))
        with_good_rows(raw, layout.keep, doubts)
    for column in others.difference([*pairs_of(layout.keep)]):
        words = raw[column].value_counts()
        if not pd.api.types.is_numeric_dtype(raw[column]) and len(words) > 1:
            doubts.append(
                f"readings of any {str(column)!r} are taken, {words.index[0]!r} and "
                f"{words.index[1]!r} among them: --keep "
                f"{shlex.quote(f'{column}={words.index[0]}')} leaves out all but these"
            )
    return layout, file_table(file, layout)


def with_cells(
    file: Path, layout: Layout, raw: pd.DataFrame, doubts: list
) -> tuple[Layout, pd.DataFrame]:
    """The layout with the texts in cells of numbers, and the table."""
    columns = [raw[name] for name in texts(raw)]
    sign = "" if layout.thousands else thousands_of(columns, layout.decimal)
    if sign:
        layout = replace(layout, thousands=sign)
        doubts.append(f"{sign!r} is taken for the sign between thousands")
        raw = rows_of(file, layout)
    columns = [raw[c] for c in texts(raw) if c not in time_columns(raw, layout)]
    if marks := marks_of(columns, layout.decimal):
        signs = " and ".join(map(repr, marks))
        doubts.append(f"numbers with {signs} behind them are left out by --missing")
        layout = replace(layout, missing=(*layout.missing, *marks))
        raw = rows_of(file, layout)
    missing = (*texts_of_missing(raw, layout), *texts_of_infinity(raw))
    doubts += [
        f"{text!r} is less than the sensor reads; where it stands such rows are left "
        "out, and half of it in its place keeps them"
        for text in missing
        if text.startswith("<")
    ]
    if set(missing) - set(layout.missing):
        layout = replace(layout, missing=(*layout.missing, *missing))
        raw = rows_of(file, layout)
    return layout, raw


def rows_of(file: Path, layout: Layout) -> pd.DataFrame:
    """The table without the rows that the layout leaves out for their times."""
    raw = file_table(file, layout)
    return with_times_only(raw, layout, [], "")[1] if layout.drop_untimed else raw


def by_the_sun(data: dict, guessed: Guess) -> None:
    """Of two temperatures of no telling name the warmer by day is the module."""
    light, air = (guessed.columns.get(name) for name in ("poa_global", "temp_air"))
    if "temp_module" in {*guessed.columns, *data} or air is None or light is None:
        return
    alike = re.compile(NAMES["temp_air"][-1])
    other = [c for c in data if c != air and alike.search(spelled_name(c))]
    other = [c for c in other if not NOT.search(without_unit(c))]
    if len(other) != 1 or len({len(data[c]) for c in (light, air, *other)}) > 1:
        return
    sunny = data[light] > 0.5 * data[light].max()
    warmer = float((data[other[0]] - data[air])[sunny].median())
    module, air = (other[0], air) if warmer > 0 else (air, other[0])
    guessed.columns |= {"temp_air": air, "temp_module": module}
    guessed.doubts = [
        d for d in guessed.doubts if not d.startswith("temp_air may also")
    ]
    guessed.doubts.append(
        f"{module!r} is taken for the module, since in the sun it is "
        f"{abs(warmer):.0f} warmer than {air!r}"
    )


def all_modules(data: Any, guessed: Guess) -> None:
    """Map each further column that looks like a module's temperature."""
    taken = guessed.columns.values()
    free = {c: v for c, v in data.items() if c not in taken and not is_own(c)}
    free = [c for c, v in free.items() if pd.api.types.is_numeric_dtype(v)]
    others = [c for c in free if usual_name(c) == "temp_module"]
    guessed.columns |= {f"temp_module_{n}": c for n, c in enumerate(others, 2)}
    alike = "temp_module may also be"
    guessed.doubts = [doubt for doubt in guessed.doubts if not doubt.startswith(alike)]


def in_units(guessed: Guess, data: dict, below: dict) -> None:
    """What headers say of units, or a line below them."""
    for name, column in guessed.columns.items():
        if column not in data or usual_name_of(name) is None:
            continue
        unit = stated_unit(name, str(column), below.get(column, ""))
        if unit not in (None, own_unit(name)):
            if unit == named_unit(name, str(column)):
                guessed.headers = True
            else:
                guessed.units[name] = unit
        guessed.area |= name == "p_dc_per_area" and unit in WHOLE
    for name in COLUMNS:
        column = guessed.columns.get(name, name)
        if column in data and named_unit(name, str(column)) is None:
            if below.get(column) or column == name:
                continue
            usual = ", ".join(list(UNITS[QUANTITIES[name]])[1:])
            guessed.doubts.append(
                f"{column!r} names no unit: it has to be in {own_unit(name)} (--unit "
                f"{name}=UNIT converts {usual})"
            )


def texts_of_missing(raw: pd.DataFrame, layout: Layout) -> tuple[str, ...]:
    """Texts in columns of numbers, which stand for missing ones."""
    texts = {}
    for name, column in raw.items():
        if name in layout.time or pd.api.types.is_numeric_dtype(column):
            continue
        if mostly_numbers(column):
            numbers = pd.to_numeric(column, errors="coerce")
            bad = column[numbers.isna() & column.notna()].astype(str).unique()
            texts |= dict.fromkeys(bad) if len(bad) <= 3 else {}
    return tuple(texts)


def texts_of_infinity(raw: pd.DataFrame) -> tuple[str, ...]:
    """Texts for infinite numbers, as a logger writes what it cannot compute."""
    values = raw.select_dtypes("float").to_numpy(float, na_value=np.nan)
    return tuple(text for text in ("INF", "-INF") if (values == float(text)).any())


def by_evidence(guessed: Guess, files: Any, how: Mapping, check: Callable) -> None:
    """Units that headers do not name and the record itself shows."""
    how = {**how, "convert": True, "module_area": how.get("module_area") or 1.0}
    headers = {name: guessed.columns.get(name, name) for name in QUANTITIES}
    for _ in QUANTITIES:
        units = {**how.get("units", {}), **guessed.units}
        try:
            check(
                frame(files, guessed.layouts, guessed.columns, **how | {"units": units})
            )
            return
        except SwappedTemperatures as odd:
            exchange(guessed, odd.why)
        except ForeignUnit as odd:
            by_header = {n for n, h in headers.items() if named_unit(n, h) == odd.unit}
            if {*odd.columns} <= {*units} | by_header:
                return
            guessed.units |= dict.fromkeys(odd.columns, odd.unit)
            names = " and ".join(odd.columns)
            guessed.doubts.append(f"{names} may be in {odd.unit}: {odd.why}")
        except (ValueError, KeyError):
            return


def of_wind(guessed: Guess, data: dict) -> None:
    """Ask for mph where the temperatures are in °F and the wind says nothing."""
    wind = guessed.columns.get("wind_speed", "wind_speed")
    named = wind not in data or named_unit("wind_speed", str(wind)) is not None
    if (
        "°F" in guessed.units.values()
        and "wind_speed" not in guessed.units
        and not named
    ):
        guessed.doubts.append(
            f"where temperatures are in °F, {wind!r} is mostly in mph: then add --unit "
            "wind_speed=mph"
        )


def exchange(guessed: Guess, why: str) -> None:
    """A unit of the air holds for the module, and the other way round."""
    pair = ("temp_air", "temp_module")
    columns = [guessed.columns.get(name, name) for name in pair]
    guessed.columns |= dict(zip(pair, columns[::-1]))
    units = {
        b: guessed.units.pop(a) for a, b in zip(pair, pair[::-1]) if a in guessed.units
    }
    guessed.units |= units
    guessed.doubts.append(
        f"{columns[0]!r} is taken for the module and {columns[1]!r} for the air: the "
        f"other way round, {why}"
    )


def sunny(columns: pd.DataFrame) -> np.ndarray | None:
    """The column that looks like irradiance, or None."""
    column = mapped(dict(columns.items()), {}, ("poa_global",), []).get("poa_global")
    column = "poa_global" if "poa_global" in columns else column
    return None if column is None else columns[column].to_numpy(float)
