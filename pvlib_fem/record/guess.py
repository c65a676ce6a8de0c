"""What the columns of a file may be: proposed by names and data, never acted upon."""

import re
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
import pandas as pd

from pvlib_fem.record.checks import measured
from pvlib_fem.record.columns import ALIASES, COLUMNS
from pvlib_fem.record.files import frame, table, timed
from pvlib_fem.record.layout import found_layout
from pvlib_fem.record.times import ISO, joined
from pvlib_fem.record.units import (
    QUANTITIES,
    UNITS,
    WHOLE,
    named_unit,
    own_unit,
    unit_of,
)
from pvlib_fem.record.zones import zone_of

#: column: names that loggers have for it, the surest first
NAMES = {
    "poa_global": (
        r"poa|gti|gpoa|tilt|inclin|plane|modulebene",
        r"irr|einstrahl|insol|^g$|^g_?i$|pyran|global|solar_?rad|strahlung",
    ),
    "temp_module": (
        r"(mod(ul\w*)?|panel|back(sheet)?|bom|pv|cell|zell)[\s_.-]*t|"
        r"t(emp\w*)?[\s_.-]*(mod|panel|back|bom|pv|cell|zell)",
    ),
    "temp_air": (
        r"(amb(ient)?|air|outdoor|dry_?bulb|luft|außen|umgebung\w*)[\s_.-]*t|"
        r"t(emp\w*)?[\s_.-]*(amb|air|out|dry|luft|außen|umg|2m)",
        r"^ta(\b|_)|^t_?a$",
        r"^t(emp\w*)?(\b|_)",
    ),
    "wind_direction": (r"w(ind)?[\s_.-]*d(ir|\b|_)|wind\w*richt|^wr(\b|_)",),
    "wind_speed": (
        r"w(ind)?[\s_.-]*(s(p(ee)?d)?|vel\w*)(\b|_)|wind\w*geschw|^v_?w(ind)?(\b|_)",
        r"^wind|anemom",
    ),
    "relative_humidity": (r"^rh(\b|_|\d)|rel\w*[\s_.-]*hum|humid|feucht|^hr$|^rf$",),
    "longwave_down": (r"long[\s_-]?wave|^lw|pyrgeo|^dlr|^ir_?down|infrared",),
    "precipitation": (r"rain|precip|regen|niederschl|^rr$",),
    "p_dc": (r"^p[\s_.-]?dc|dc[\s_.-]*(power|leist)|(power|leist\w*)[\s_.-]*dc",),
    "snow_depth": (r"snow|schnee",),
}
NOT = re.compile(
    r"std|stdev|(\b|_)(min|max|sd|mv|daily|cum\w*)(\b|_)|gust|ghi|dni|dhi|horiz|"
    r"diffus|direct|beam|clear|status|flag|albedo",
    re.IGNORECASE,
)
TIMES = re.compile(
    r"time|date|datum|zeit|uhr|fecha|hora|heure|stamp|^ts$|^utc", re.IGNORECASE
)
DATES = ("%Y-%m-%d", "%d/%m/%Y", "%m/%d/%Y", "%d.%m.%Y", "%d-%m-%Y", "%Y/%m/%d")
DATES += ("%d/%m/%y", "%m/%d/%y", "%d.%m.%y", "%Y%m%d", "%m-%d-%Y", "%Y.%m.%d")
HOURS = ("%H:%M", "%H:%M:%S", "%I:%M %p", "%I:%M:%S %p", "%H:%M:%S.%f", "%H.%M")
LOOKED_AT = 2_000  # rows whose times tell the format
ODD_UNIT = re.compile(r"(\w+)(?: and (\w+))? looks? to be in (\S+): (.*?)\. ")
MOSTLY = 0.5  # share of numbers from which text in a column stands for missing ones


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

    @property
    def there(self):
        """Names of the package that have a column."""
        return {*self.columns, *self.free}


def guess(files, layouts, columns, how=None, place=None):
    """
    Propose how files are to be read.

    Parameters
    ----------
    files : list of Path
    layouts : list of Layout
        As given; what is told there of times and zone is kept.
    columns : dict
        Those that are mapped already.
    how : dict, optional
        What else :func:`pvlib_fem.record.files.frame` is told.
    place : float, optional
        Longitude of the site. [°]

    Returns
    -------
    Guess
    """
    found = Guess([], dict(columns))
    data, units = {}, {}
    for file, layout in zip(files, layouts):
        layout, below = found_layout(file, layout)
        raw = table(file, layout)
        missing = texts_of_missing(raw, layout)
        if set(missing) - set(layout.missing):
            layout = replace(layout, missing=(*layout.missing, *missing))
            raw = table(file, layout)
        layout = with_times(raw, layout, found.doubts, file.name)
        left = raw.drop(columns=[c for c in layout.time if c in raw])
        index = index_of(raw, layout)
        if layout.tz is None and index is not None:
            sun = sunny(left)
            layout = replace(layout, tz=zone_of(index, place, sun, found.doubts))
        found.layouts.append(in_order(raw, layout, file.name))
        for column in left:
            name = f"{column} ({file.name})" if column in data else column
            data[name], units[name] = left[column], below.get(column, "")
    found.columns = mapped(data, found.columns, tuple(QUANTITIES), found.doubts)
    taken = found.columns.values()
    found.free = [str(column) for column in data if column not in taken]
    in_units(found, data, units)
    by_evidence(found, files, how or {})
    return found


def mapped(data, columns, names, doubts):
    """The map with the columns that look like a name that none has yet."""
    numeric = [c for c in data if pd.api.types.is_numeric_dtype(data[c])]
    there = {ALIASES.get(column, column) for column in data}
    free = [c for c in numeric if c not in (*columns.values(), *names, *ALIASES)]
    free = [c for c in free if not NOT.search(without_unit(c))]
    columns = dict(columns)
    for name in NAMES:
        if name not in names or name in columns or name in there:
            continue
        for sure, pattern in enumerate(NAMES[name]):
            matching = [c for c in free if re.search(pattern, spelled(c))]
            if matching:
                columns[name] = matching[0]
                free.remove(matching[0])
                told(name, matching, sure, doubts)
                break
    return columns


def told(name, matching, sure, doubts):
    """What a person should look at."""
    if len(matching) > 1:
        doubts.append(
            f"{name} may also be {', '.join(repr(c) for c in matching[1:4])}"
            + (f" or {len(matching) - 4} others" if len(matching) > 4 else "")
        )
    if name == "poa_global" and sure > 0:
        doubts.append(
            f"{matching[0]!r} has to be in the plane of the module, not horizontal"
        )


def spelled(column):
    """A column's name without its unit, in small letters, words apart."""
    bare = re.sub(r"([a-z])([A-Z])", r"\1_\2", without_unit(column))
    return bare.strip().lower()


def without_unit(column):
    return re.sub(r"[\[({].*?[\])}]", "", str(column))


def unmapped(data, columns=(), names=tuple(QUANTITIES)):
    """Columns that look like a usual driver and are not mapped to it."""
    found = mapped({name: data[name] for name in data}, {}, names, [])
    return {name: column for name, column in found.items() if name not in columns}


def in_units(found, data, below):
    """What headers say of units, or a line below them."""
    for name, column in found.columns.items():
        if column not in data:
            continue
        unit = named_unit(name, str(column))
        if unit is None and below.get(column):
            try:
                unit = unit_of(name, below[column])
            except ValueError:
                continue
            if unit != own_unit(name):
                found.units[name] = unit
        elif unit not in (None, own_unit(name)):
            found.headers = True
        found.area |= name == "p_dc" and unit in WHOLE
    for name in COLUMNS:
        column = found.columns.get(name, name)
        if column in data and named_unit(name, str(column)) is None:
            if below.get(column) or column == name:
                continue
            usual = ", ".join(list(UNITS[QUANTITIES[name]])[1:])
            found.doubts.append(
                f"{column!r} names no unit: it has to be in {own_unit(name)} (--unit "
                f"{name}=UNIT converts {usual})"
            )


def texts_of_missing(raw, layout):
    """Texts in columns of numbers, which stand for missing ones."""
    found = {}
    for name, column in raw.items():
        if name in layout.time or pd.api.types.is_numeric_dtype(column):
            continue
        if pd.api.types.is_datetime64_any_dtype(column):
            continue
        numbers = pd.to_numeric(column, errors="coerce")
        if numbers.notna().sum() > MOSTLY * column.notna().sum():
            bad = column[numbers.isna() & column.notna()].astype(str).unique()
            found |= dict.fromkeys(bad) if len(bad) <= 3 else {}
    return tuple(found)


def with_times(raw, layout, doubts, file):
    """The layout with the columns of the times and their format."""
    if isinstance(raw.index, pd.DatetimeIndex):
        return layout
    if layout.time and layout.time_format != ISO:
        return layout
    texts = [c for c in raw if not pd.api.types.is_numeric_dtype(raw[c])]
    likely = sorted(texts, key=lambda c: TIMES.search(str(c)) is None)
    choices = [layout.time] if layout.time else [(c,) for c in likely]
    if not layout.time:  # a date alone needs its hours
        choices = [*choices, *((a, b) for a, b in product(likely, likely) if a != b)]
    for choice in choices:
        forms = formats(raw[list(choice)])
        if forms:
            if len(forms) > 1:
                doubts.append(
                    f"the times of {file} may also be written as {forms[1]}: look at "
                    "a day after the 12th"
                )
            first = list(choice) == [raw.columns[0]]
            time = () if first and not layout.time else choice
            return replace(layout, time=tuple(time), time_format=forms[0])
    doubts.append(f"no column of {file} holds times of a usual format")
    return layout


def formats(columns):
    """Formats in which all times can be read and tell the hour, the best first."""
    column = columns.iloc[:, 0]
    if pd.api.types.is_datetime64_any_dtype(column) and columns.shape[1] == 1:
        return [ISO]
    some = columns.dropna()
    some = some.iloc[:: max(1, len(some) // LOOKED_AT)]
    if some.empty:
        return []
    column = some.iloc[:, 0] if columns.shape[1] == 1 else joined(some)
    ways = {}
    for form in (ISO, *(f"{d} {h}" for d, h in product(DATES, HOURS))):
        try:
            read = pd.to_datetime(column, format=form, utc=True)
        except (ValueError, TypeError):
            continue
        if len(read) > 1 and (read.dt.normalize() == read).all():
            continue  # a date only
        steps = np.diff(read.to_numpy()) / np.timedelta64(1, "s")
        ways[form] = (int((steps <= 0).sum()), float(np.abs(steps).sum()))
        if form == ISO:
            break
    if not ways:
        return []
    best = min(ways.values())
    return [form for form, way in ways.items() if way == best]


def in_order(raw, layout, name):
    """The layout that puts rows in order, where they are not."""
    try:
        index = timed(raw, layout, name).index
    except ValueError:
        return layout
    rises = index.is_monotonic_increasing
    return replace(layout, sort=not rises, drop_doubled=index.has_duplicates)


def by_evidence(found, files, how):
    """Units that headers do not name and the record itself shows."""
    how = {**how, "convert": True, "module_area": how.get("module_area") or 1.0}
    for _ in COLUMNS:
        told = {**how.get("units", {}), **found.units}
        try:
            data = frame(files, found.layouts, found.columns, **how | {"units": told})
            measured(*(data[name] for name in COLUMNS))
            return
        except (ValueError, KeyError) as error:
            odd = ODD_UNIT.match(str(error))
            if odd is None or (odd[1] in told and odd[2] in (None, *told)):
                return
            names = [name for name in odd.group(1, 2) if name]
            found.units |= dict.fromkeys(names, odd[3])
            found.doubts.append(f"{' and '.join(names)} may be in {odd[3]}: {odd[4]}")


def index_of(raw, layout):
    """Times without a zone, as they are written, or None."""
    if isinstance(raw.index, pd.DatetimeIndex):
        index = raw.index
    else:
        columns = raw[list(layout.time) or [raw.columns[0]]]
        column = columns.iloc[:, 0] if columns.shape[1] == 1 else joined(columns)
        try:
            read = pd.to_datetime(column, format=layout.time_format, errors="coerce")
            index = pd.DatetimeIndex(read)
        except (ValueError, TypeError):  # offsets that change
            return None
    return index if index.tz is None else None


def sunny(left):
    """The column that looks like irradiance, or None."""
    column = mapped(dict(left.items()), {}, ("poa_global",), []).get("poa_global")
    column = "poa_global" if "poa_global" in left else column
    return None if column is None else left[column].to_numpy(float)
