"""In which columns and in which form a file has its times."""

import re
from dataclasses import replace
from itertools import product
from typing import Any

import pandas as pd

from pvlib_fem._record.file_times import (
    AFTER,
    COUNTS,
    DATENUM,
    SERIAL,
    as_text,
    joined_times,
    of_numbers,
    parsed_times,
    rows_without_time,
    unevenness,
    with_time_index,
)
from pvlib_fem._record.layout import Layout
from pvlib_fem._record.time_formats import (
    HOURS as ZONES,
    ISO,
    SEVERAL,
    SUMMER,
    last_letters,
    without_letters,
    zones_of,
)

TIMES = re.compile(
    r"time|date|datum|zeit|uhr|fecha|hora|heure|hour|hhmm|stamp|^ts$|^utc|epoch|unix",
    re.IGNORECASE,
)
DATES: tuple[str, ...] = (
    "%Y-%m-%d",
    "%d/%m/%Y",
    "%m/%d/%Y",
    "%d.%m.%Y",
    "%d-%m-%Y",
    "%Y/%m/%d",
)
DATES += ("%d/%m/%y", "%m/%d/%y", "%d.%m.%y", "%Y%m%d", "%m-%d-%Y", "%Y.%m.%d")
DATES += ("%y-%m-%d", "%y/%m/%d", "%Y-%j", "%Y年%m月%d日")
#: the same with the month's name, in English
DATES += ("%b %d, %Y", "%d %b %Y", "%d-%b-%Y", "%d-%b-%y", "%d/%b/%Y", "%b %d %Y")
DATES += ("%B %d, %Y", "%d %B %Y")
SIGNS = (" ", ", ", ":", "_")  # between date and hour, as in files of PVGIS
HOURS = ("%H:%M", "%H:%M:%S", "%I:%M %p", "%I:%M:%S %p", "%H:%M:%S.%f", "%H.%M", "%H%M")
HOURS += ("%I:%M%p", "%I:%M:%S%p", "%Hh%M")  # the last as in French
#: parts of a time that have columns of their own, by their names: of a year, of a day
OF_YEAR = (
    {"%Y": r"year|yr|yyyy", "%m": r"month|mon", "%d": r"day( of month)?|dd"},
    {"%Y": r"year|yr|yyyy", "%j": r"doy|day[ _]?of[ _]?year|j(ulian)?[ _]?day"},
    {"%Y%m%d": r"yyyymmdd|date"},
)
OF_DAY = (
    {"%H%M": r"hhmm|hour[ _/]?min(ute)?|time"},
    {"%H": r"hour|hr|hh", "%M": r"min(ute)?s?", "%S": r"sec(ond)?s?"},
    {"%H": r"hour|hr|hh", "%M": r"min(ute)?s?"},
    {"%H": r"hour|hr|hh"},
)
COMPACT = {10: "%Y%m%d%H", 12: "%Y%m%d%H%M", 14: "%Y%m%d%H%M%S"}  # by their digits
TWICE = 0.05  # share of rows with the same time up to which they are dropped
LOOKED_AT = 2_000  # rows whose times tell the format, of which most fail at the first
FIRST = 5
OFFSET = re.compile(r"\d\s*[+-]\d\d:?\d\d$")


def with_times(raw: pd.DataFrame, layout: Layout, doubts: list, file: str) -> Layout:
    """
    The layout with the columns of the times and their format.

    Parameters
    ----------
    raw : DataFrame
        The file as it is read.
    layout : Layout
        What is known; columns of the times stay, and with them their format.
    doubts : list of str
        Takes what a person should look at.
    file : str
        Name of the file, for the doubts.

    Returns
    -------
    Layout
        Unchanged where no column has times of a usual format.
    """
    if isinstance(raw.index, pd.DatetimeIndex):
        return layout
    if layout.time and layout.time_format != ISO:
        return layout
    texts = [c for c in raw if not pd.api.types.is_numeric_dtype(raw[c])]
    texts += [c for c in raw if c not in texts and TIMES.search(str(c))]
    likely = sorted(texts, key=lambda c: TIMES.search(str(c)) is None)
    choices = [layout.time] if layout.time else [(c,) for c in likely]
    if not layout.time:  # a date alone needs its hours
        choices = [*choices, *((a, b) for a, b in product(likely, likely) if a != b)]
        choices += [(c,) for c in raw.columns[:1] if c not in likely]
    if not layout.time and (parts := in_parts(raw)):
        return replace(layout, time=tuple(parts), time_format=" ".join(parts.values()))
    for choice in choices:
        forms = formats(raw[list(choice)], layout.tz)
        if forms:
            if "%Z" in forms[0] and layout.tz is None:
                layout = of_letters(raw[list(choice)], layout, doubts)
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


def of_letters(columns: Any, layout: Layout, doubts: list) -> Any:
    """The layout with the zone of letters that more than one has, the most usual."""
    column = joined_times(columns)
    zones = zones_of(column)
    if len(zones) > 1:
        doubts.append(
            f"the letters behind the times are taken for those of {zones[0]}; they may "
            f"be those of {' or '.join(zones[1:])}"
        )
    return replace(layout, tz=zones[0]) if zones else layout


def in_parts(raw: pd.DataFrame) -> dict[str, str]:
    """Columns that hold the parts of the times by their names, and their formats."""
    for first, second in product(OF_YEAR, OF_DAY):
        parts = {}
        for form, pattern in (first | second).items():
            name = next((c for c in raw if re.fullmatch(pattern, plain_name(c))), None)
            parts |= {} if name is None else {name: form}
        if len(parts) < len(first | second):
            continue
        read = parsed_times(joined_times(raw[list(parts)]), " ".join(parts.values()))
        if read.notna().all() and unevenness(read)[0] == 0:
            return parts
    return {}


def plain_name(column: Any) -> str:
    """A column's name in small letters, without brackets."""
    return re.sub(r"[\[({].*?[\])}]", "", str(column)).strip().lower()


def formats(columns: pd.DataFrame, tz: str | None = None) -> list:
    """Formats in which all times can be read and tell the hour, the best first."""
    without = rows_without_time(columns)
    if without.mean() > 0.5:
        return []
    some = of_numbers(columns[~without])
    if len(some) > 10 * AFTER:  # what stands after the rows has no say
        some = some.iloc[:-AFTER].infer_objects()
    some = some.iloc[:: max(1, len(some) // LOOKED_AT)]
    if some.empty:
        return []
    column = joined_times(some)
    first = column.iloc[:FIRST].astype(str)
    marked, zone = column.astype(str).map(last_letters) == SUMMER, ""
    if {*map(last_letters, first)} <= {*ZONES, *SEVERAL}:
        zone, tz = " %Z", tz or next(iter(zones_of(column)), None)
    elif marked.any():
        zone, tz = " %Z", tz or "UTC"  # no zone changes the format
    elif first.str.contains(OFFSET).all():
        zone = " %z"
    if pd.api.types.is_datetime64_any_dtype(column):
        choices = [ISO]
    elif pd.api.types.is_numeric_dtype(column):
        for form, (_, ends) in COUNTS.items():
            days = form in (SERIAL, DATENUM)
            if column.between(*ends).all() and not (days and (column % 1 == 0).all()):
                return [form]
        column = column.map(as_text)
        digits = column.str.len().unique()
        choices = [COMPACT[n] for n in digits if n in COMPACT and len(digits) == 1]
    elif (
        pd.api.types.is_numeric_dtype(some.iloc[:, -1]) and some.iloc[:, -1].max() < 60
    ):
        return []  # an hour alone would be read as minutes
    else:
        dates = [d for d in DATES if parsed_times(first, d, exact=False).notna().all()]
        ways = product(dates, SIGNS, HOURS)
        choices = [ISO, *(f"{date}{sign}{hour}{zone}" for date, sign, hour in ways)]
    uneven, head = {}, pd.concat([column.iloc[:FIRST], column[marked].iloc[:FIRST]])
    for form in choices:
        try:
            if parsed_times(head, form, tz).isna().any():
                continue
            read = parsed_times(column, form, tz)
        except (ValueError, TypeError):
            continue
        if read.isna().any():
            continue
        if len(read) > 1 and (read.dt.normalize() == read).all():
            continue  # a date only
        uneven[form] = unevenness(read)
        if form == ISO:
            break
    if not uneven:
        return []
    best = min(uneven.values())
    ways = [form for form, way in uneven.items() if way == best]
    return [*{form.replace("%B", "%b"): form for form in ways[::-1]}.values()][::-1]


def lines_after(raw: pd.DataFrame, layout: Layout) -> int:
    """
    How many last lines hold no time, such as totals, where all others hold one.

    Parameters
    ----------
    raw : DataFrame
        The file as it is read.
    layout : Layout
        With columns and format of the times.

    Returns
    -------
    int
        At most :data:`AFTER`; 0 where other rows hold no time either.
    """
    if isinstance(raw.index, pd.DatetimeIndex):
        return 0
    for end in range(min(AFTER, len(raw) - 1) + 1):
        try:
            with_time_index(raw.iloc[: len(raw) - end], replace(layout, tz=None), "")
        except ValueError:
            continue
        return end
    return 0


def with_times_only(
    raw: Any, layout: Any, doubts: list, file: str
) -> tuple[Layout, pd.DataFrame]:
    """
    Drop rows without a time, and have the layout do so.

    Parameters
    ----------
    raw : DataFrame
        The file as it is read.
    layout : Layout
        With the columns of the times.
    doubts : list of str
        Takes how many rows are dropped.
    file : str
        Name of the file, for the doubts.

    Returns
    -------
    Layout, DataFrame
        Both unchanged where all rows have a time.
    """
    without: Any
    if isinstance(raw.index, pd.DatetimeIndex) and not layout.time:
        without = raw.index.isna()
    else:
        without = rows_without_time(raw[time_columns(raw, layout)])
    if not without.any():
        return layout, raw
    rows = "a row holds" if without.sum() == 1 else f"{without.sum():,} rows hold"
    doubts.append(f"{rows} no time in {file}, left out by --drop-untimed")
    return replace(layout, drop_untimed=True), of_numbers(raw[~without])


def in_order(raw: pd.DataFrame, layout: Layout, name: str) -> Layout:
    """
    The layout that puts rows in order, where they are not.

    Parameters
    ----------
    raw : DataFrame
        The file as it is read.
    layout : Layout
        With columns and format of the times.
    name : str
        Of the file.

    Returns
    -------
    Layout
        It drops doubled times only if fewer than 5 % of the rows have one; unchanged
        where the times cannot be read.
    """
    try:
        index = with_time_index(raw, layout, name)[0].index
    except ValueError:
        return layout
    rises = index.is_monotonic_increasing
    twice = 0.0 < index.duplicated().mean() < TWICE
    return replace(layout, sort=not rises, drop_doubled=twice)


def index_of(raw: pd.DataFrame, layout: Layout) -> Any:
    """
    Times as they are, before they are brought into a zone.

    Parameters
    ----------
    raw : DataFrame
        The file as it is read.
    layout : Layout
        With columns and format of the times.

    Returns
    -------
    DatetimeIndex or None
        None where the times cannot be read.
    """
    if isinstance(raw.index, pd.DatetimeIndex):
        index = raw.index
    else:
        try:
            index = with_time_index(raw, replace(layout, tz=None), "")[0].index
        except ValueError:
            return None
    return index


def clock_times(raw: pd.DataFrame, layout: Layout) -> pd.DatetimeIndex:
    """
    Times as a clock showed them, without their distance from UTC.

    Parameters
    ----------
    raw : DataFrame
        The file as it is read.
    layout : Layout
        With columns and format of the times.

    Returns
    -------
    DatetimeIndex, shape (rows,)
        Naive; NaT where a text holds no time.
    """
    if isinstance(raw.index, pd.DatetimeIndex):
        return raw.index.tz_localize(None)
    text = joined_times(raw[time_columns(raw, layout)]).astype(str)
    form = layout.time_format.removesuffix("%z").strip()
    if "%Z" in form:
        text, form, _ = without_letters(text, form, layout.tz)
    text = text.str.replace(r"(?<=\d)\s*([+-]\d\d:?\d\d|Z)$", "", regex=True)
    return pd.DatetimeIndex(parsed_times(text, form))


def time_columns(raw: pd.DataFrame, layout: Layout) -> list[str]:
    """
    The columns of the times: the given ones, or the first.

    Parameters
    ----------
    raw : DataFrame
        The file as it is read.
    layout : Layout

    Returns
    -------
    list of str
        Empty where the index has the times.
    """
    if layout.time or isinstance(raw.index, pd.DatetimeIndex):
        return [column for column in layout.time if column in raw]
    return [raw.columns[0]]
