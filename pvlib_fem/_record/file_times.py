"""The times of a file: of one column or of two, in a zone, in their order."""

import datetime
import numbers
import re
from typing import Any
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

import numpy as np
import pandas as pd

from pvlib_fem._record.checks import instants
from pvlib_fem._record.months import in_english
from pvlib_fem._record.time_formats import ISO, without_letters
from pvlib_fem._record.time_ranges import ends_of_ranges, has_ranges
from pvlib_fem._record.zone_candidates import standard_offset
from pvlib_fem._spelling import did_you_mean

UNIX = "unix"  # seconds since 1970 in UTC
MILLI = "unix-ms"  # milliseconds
SERIAL = "excel"  # days since the end of 1899, as spreadsheets count them
DATENUM = "matlab"  # days since the year 0
ORIGIN = "1899-12-30"  # of those, since they have a 29 February in 1900
DAYS_TO_1970 = 719529
FEW = 5  # rows that tell whether a column of text may hold times
YEARS = (1, 9999)  # that a calendar can write
AFTER = 3  # lines that a table may have after its last row, such as totals
DIGIT = re.compile(r"\d")
#: the first two numbers of a date that does not begin with the year
DAY_AND_MONTH = re.compile(r"^\D*(\d{1,2})\D+(\d{1,2})(?!\d)")
#: the end of a day, as some write it; seconds are 00 already
MIDNIGHT = re.compile(r"(?<!\d)24([:. ]?)00")
#: last parts of a format, which R and spreadsheets leave out where they are zero
LAST = (r"\.%f$", r":%S$", r"[^%\w]*%[HI](?!.*%[dYz]).*$")


def with_time_index(
    data: pd.DataFrame, layout: Any, name: str
) -> tuple[pd.DataFrame, list]:
    """
    The table on its times, and what was dropped for that, a sentence each.

    Parameters
    ----------
    data : DataFrame
    layout : Layout
    name : str
        Of the file.

    Returns
    -------
    DataFrame, list of str

    Raises
    ------
    ValueError
        If a column of the times is not there, a row holds no time, or there is no such
        zone; the message names the option that helps.
    """
    time, notes, name_of = list(layout.time), [], data.index.name
    if isinstance(data.index, pd.DatetimeIndex) and time in ([], [name_of]):
        columns = data.index.to_frame(index=False, name=name_of or "time")
    else:
        time = time or [data.columns[0]]
        if absent := [column for column in time if column not in data]:
            raise ValueError(
                f"{name} has no column {', '.join(absent)} for the times"
                f"{did_you_mean(absent, data.columns)}; it has "
                f"{', '.join(map(str, data.columns))}"
            )
        columns, data = data[time], data.drop(columns=time)
    if rows := int(
        (with_filled_dates(columns) is not columns) and rows_below_date(columns).sum()
    ):
        notes.append(f"dates that stand once a day, taken for the rows below: {rows:,}")
    if columns.shape[1] == 1 and has_ranges(first := columns.iloc[:, 0]):
        notes.append(
            f"times are ranges, as {first.iloc[0]!r}: the end of each is taken"
        )
    if layout.drop_untimed and (without := rows_without_time(columns)).any():
        notes.append(
            f"rows without a time, left out: {without.sum():,}, the first is row "
            f"{int(np.argmax(without))}"
        )
        data, columns = of_numbers(data[~without]), of_numbers(columns[~without])
    data = data.set_axis(times_of_columns(columns, layout.time_format, layout.tz))
    notes += times_of_others(data, layout.time_format)
    if layout.tz is not None:
        index, kept, lost = in_zone(data.index, layout.tz)
        data = (data if kept.all() else data[kept]).set_axis(index)
        notes += lost
    return data, notes


def times_of_others(data: pd.DataFrame, time_format: str) -> list[str]:
    """What is said of columns that hold times, too, other than those of the rows."""
    offsets = {name: off_rows(column, time_format) for name, column in data.items()}
    offsets = {name: off for name, off in offsets.items() if off}
    if not offsets:
        return []
    several = len(offsets) > 1
    return [
        f"{' and '.join(map(repr, offsets))} hold{'s' * (not several)} times, too, up "
        f"to {max(offsets.values()):,.0f} s off those of the rows: columns that belong "
        f"to {'them' if several else 'it'} are taken at the rows' times; files of "
        "their own would be joined on theirs"
    ]


def off_rows(column: pd.Series, time_format: str) -> float:
    """How far the times in a column of text are off the rows' own, or 0. [s]"""
    kinds = pd.api.types
    if not (kinds.is_object_dtype(column) or kinds.is_string_dtype(column)):
        return 0.0
    for text in (column.iloc[:FEW].dropna(), column.dropna()):
        if text.empty or not text.map(lambda cell: isinstance(cell, str)).all():
            return 0.0
        try:
            read = parsed_times(text, time_format)
        except ValueError:  # of letters that are no zone's
            return 0.0
        if read.isna().any():
            return 0.0
    own = pd.DatetimeIndex(text.index).tz_localize(None)
    off: Any = pd.DatetimeIndex(read).tz_localize(None) - own
    # by one distance for all they are the same in another zone
    return abs(off).max().total_seconds() if (off != off[0]).any() else 0.0


def rows_without_time(columns: pd.DataFrame) -> np.ndarray:
    """
    Rows that hold no time in any form: nothing, or a text without a digit.

    Parameters
    ----------
    columns : DataFrame, shape (rows, parts)
        The columns of the times, such as a date and a time of day.

    Returns
    -------
    array of bool, shape (rows,)
    """
    columns = with_filled_dates(columns)
    without = np.array(columns.isna().any(axis=1))
    for _, column in columns.items():
        kinds = pd.api.types
        if kinds.is_object_dtype(column) or kinds.is_string_dtype(column):
            text = column.astype(str)
            without |= ~text.str.contains(DIGIT).fillna(False).to_numpy(bool)
    return without


def blank(column: pd.Series) -> pd.Series:
    """Cells that hold nothing."""
    return column.isna() | (column.astype(str).str.strip() == "")


def rows_below_date(columns: pd.DataFrame) -> np.ndarray:
    """Rows that have a time of day, and their date in a row above alone."""
    first, last = columns.iloc[:, 0], columns.iloc[:, -1]
    if columns.shape[1] == 1:
        return np.zeros(len(columns), dtype=bool)
    empty = blank(first)
    return (empty & ~blank(last) & (~empty).cummax()).to_numpy(bool)


def with_filled_dates(columns: pd.DataFrame) -> Any:
    """Dates and times of day, each date in all rows of its day."""
    if not (rows := rows_below_date(columns)).any():
        return columns
    first = columns.iloc[:, 0]
    above = first.mask(blank(first)).ffill()
    return columns.assign(**{str(first.name): first.mask(rows, above)})


def of_numbers(data: Any) -> pd.DataFrame:
    """
    The table with columns as numbers where all of their cells are.

    Parameters
    ----------
    data : DataFrame

    Returns
    -------
    DataFrame
        Other columns are unchanged.
    """
    numbers = {}
    for name, column in data.items():
        if pd.api.types.is_object_dtype(column) or pd.api.types.is_string_dtype(column):
            try:
                numbers[name] = pd.to_numeric(column)
            except (TypeError, ValueError):
                continue
    return data.assign(**numbers) if numbers else data


def times_of_columns(
    columns: Any, time_format: Any = ISO, tz: str | None = None
) -> pd.DatetimeIndex:
    """
    Times of a column, or of a date and a time of day; the first bad one is named.

    Parameters
    ----------
    columns : DataFrame
        One column, or more that make the time when spaces join them.
    time_format : str
    tz : str, optional
        The zone that letters such as CST in the texts are of.

    Returns
    -------
    DatetimeIndex

    Raises
    ------
    ValueError
        If a row holds no time of the format, or day and month look exchanged, or a
        column holds dates and texts.
    """
    refuse_mixed(columns)
    name = " and ".join(f"{name!r}" for name in columns)
    column = joined_times(columns)
    parsed: Any
    if pd.api.types.is_datetime64_any_dtype(column):
        parsed = column
    elif time_format in COUNTED and pd.api.types.is_numeric_dtype(column):
        refuse_other_count(column, time_format, name)
        parsed = COUNTED[time_format](column)
        parsed = parsed.mask(~parsed.dt.year.between(*YEARS))
    else:
        if pd.api.types.is_numeric_dtype(column):
            refuse_numbers(time_format, name)
            column = column.map(as_text)
        parsed = parsed_times(column, time_format, tz)
        refuse_turned(column, time_format, parsed, name, tz)
    if parsed.isna().any():
        raise no_time(columns, column, parsed.isna().to_numpy(), time_format)
    return pd.DatetimeIndex(parsed, name="time")


#: times that are counted, not written
COUNTED = {
    UNIX: lambda column: pd.to_datetime(column, unit="s", utc=True, errors="coerce"),
    MILLI: lambda column: pd.to_datetime(column, unit="ms", utc=True, errors="coerce"),
    SERIAL: lambda column: days_since(column, ORIGIN),
    DATENUM: lambda column: days_since(column - DAYS_TO_1970, "unix"),
}
#: what is counted, and the numbers of the years from 1985 to 2105 at least
COUNTS = {
    UNIX: ("seconds since 1970 in UTC", (5e8, 5e9)),
    MILLI: ("milliseconds since 1970 in UTC", (5e11, 5e12)),
    SERIAL: ("days since 1900", (25_000.0, 75_000.0)),
    DATENUM: ("days since the year 0", (718_000.0, 770_000.0)),
}


def days_since(column: pd.Series, origin: Any) -> pd.Series:
    days = pd.to_datetime(column, unit="D", origin=origin, errors="coerce")
    return pd.Series(days, column.index).dt.round("ms")


def refuse_other_count(column: pd.Series, time_format: str, name: str) -> None:
    """Refuse numbers that are times of our years by another count alone."""
    usual = float(column.median())
    forms = [form for form, (_, (low, high)) in COUNTS.items() if low <= usual <= high]
    if not forms or time_format in forms:
        return
    number = as_text(column.dropna().iloc[0])
    raise ValueError(
        f"column {name} holds numbers such as {number}, which are "
        f"{COUNTS[forms[0]][0]} and not {COUNTS[time_format][0]}; give --time-format "
        f"{forms[0]}"
    )


def refuse_numbers(time_format: str, name: str) -> None:
    """Refuse numbers where no option says what they count."""
    if time_format == ISO:
        raise ValueError(
            f"column {name} should hold the times and holds numbers; name the right "
            "one with --time COLUMN, or give --time-format unix for seconds since "
            "1970 in UTC, unix-ms for thousandths of them, excel for days since 1900, "
            "matlab for days since the year 0, %Y%m%d%H%M for such as 202406012130"
        )


def no_time(
    columns: pd.DataFrame, column: pd.Series, lacking: np.ndarray, time_format: str
) -> ValueError:
    """The error of rows that hold no time, or one of another format."""
    name = " and ".join(f"{name!r}" for name in columns)
    several = " (joined by a space)" if columns.shape[1] > 1 else ""
    row = int(lacking.argmax())
    after = len(lacking) - row
    what = f"column {name}{several} holds no time"
    cells = with_filled_dates(columns).iloc[row]
    held = " and ".join(
        "an empty cell" if pd.isna(cell) else repr(as_text(cell)) for cell in cells
    )
    if row and after <= AFTER and lacking[row:].all():
        last = f"the last {after} rows are" if after > 1 else "the last row is"
        return ValueError(
            f"{what} in row {row}: {held}; give --skip-end {after} if {last} no "
            "measurement, such as a total"
        )
    if (without := rows_without_time(columns))[row] and not without.all():
        more = int(without.sum()) - 1
        several = f", and in {more:,} more row{'s' * (more > 1)}" if more else ""
        return ValueError(
            f"{what} in row {row}{several}: {held}; give --drop-untimed to leave such "
            "rows out, or name the column of times with --time COLUMN"
        )
    return ValueError(
        f"{what} of the format {time_format} in row {row}: {held}; give --time-format, "
        "such as '%d/%m/%Y %H:%M', or name the column of times with --time COLUMN"
    )


def parsed_times(
    column: pd.Series, time_format: str, tz: str | None = None, exact: bool = True
) -> pd.Series:
    """
    Read texts as times, NaT where they are none.

    Months and halves of a day may be in another language, and 24:00 ends a day. Where
    some texts have all of the format, others may end before seconds, or with the date:
    missing parts are zero.

    Parameters
    ----------
    column : Series of str
    time_format : str
        Of ``pandas.to_datetime``; with ``%Z`` also letters of zones.
    tz : str, optional
        Zone that such letters belong to, where they are of several.
    exact : bool, default True
        Whether the format is that of the whole text, or of a part of it.

    Returns
    -------
    Series of datetime64
        In UTC where the texts have different offsets, else as they are written.

    Raises
    ------
    ValueError
        If letters of a zone are unknown, or of several zones and ``tz`` is not given.
    """
    if "%Z" in time_format:
        return lettered_times(column, time_format, tz)
    parsed = whole_times(column, time_format, exact)
    for last in LAST:
        shorter, bad = re.sub(last, "", time_format), parsed.isna()
        if shorter not in ("", time_format) and bad.any() and not bad.all():
            time_format, parsed = shorter, parsed.copy()
            parsed[bad] = whole_times(column[bad], time_format, exact)
    return parsed


def whole_times(column: pd.Series, time_format: str, exact: bool) -> pd.Series:
    """Times of texts that have all parts of a format."""
    parsed = parsed_as(column, time_format, exact)
    worded = {"%b", "%B", "%p"} & {*re.findall("%.", time_format)}
    if worded and (bad := parsed.isna()).any():  # in other languages, perhaps
        text, whole = column.astype(object), "%B" in time_format
        text[bad] = text[bad].map(lambda cell: in_english(as_text(cell), whole))
        parsed = parsed_as(text, time_format, exact)
    if (bad := parsed.isna()).any():
        text = column[bad].astype(object).map(as_text)
        begun = text.map(lambda cell: MIDNIGHT.sub(r"00\g<1>00", cell))
        if (late := (begun != text).to_numpy()).any():
            midnight = parsed_as(begun[late], time_format, exact)
            midnight += pd.Timedelta(days=1)
            parsed = parsed.copy()
            parsed.iloc[np.flatnonzero(bad)[late]] = midnight
    return parsed


def parsed_as(column: Any, time_format: str, exact: bool = True) -> pd.Series:
    """The times of texts as they stand."""
    how: dict[str, Any] = {"format": time_format, "errors": "coerce"}
    how |= {} if exact else {"exact": False}  # which pandas refuses for ISO8601
    try:
        parsed = pd.to_datetime(column, **how)
    except ValueError:
        return pd.to_datetime(column, utc=True, **how)
    # offsets that change, as with daylight saving time, which older pandas keeps apart
    return pd.to_datetime(column, utc=True, **how) if parsed.dtype == object else parsed


def lettered_times(column: Any, time_format: str, tz: str | None) -> pd.Series:
    """The times of texts that name their zone by letters, as instants."""
    text, form, hours = without_letters(column, time_format, tz)
    local = parsed_times(text, form)
    times = (local - pd.to_timedelta(hours, unit="h")).dt.tz_localize("UTC")
    fixed = {*hours[~np.isnan(hours)]}
    if len(fixed) != 1 or (hour := fixed.pop()) % 1:
        return times
    return times.dt.tz_convert("UTC" if hour == 0 else f"Etc/GMT{-hour:+.0f}")


def refuse_turned(
    column: pd.Series,
    time_format: str,
    parsed: pd.Series,
    name: str,
    tz: str | None = None,
) -> None:
    """Refuse a month that is read as the day, where the days tell."""
    both = {"%d", "%m"} <= {*re.findall("%.", time_format)}
    if not both or parsed.isna().any() or parsed.dt.day.max() > 12:
        return
    turned = time_format.replace("%d", "%0").replace("%m", "%d").replace("%0", "%m")
    other = parsed_times(column, turned, tz)
    if other.isna().any() or unevenness(other) >= unevenness(parsed):
        return
    days = [f"{len(one.dt.normalize().unique()):,} days" for one in (parsed, other)]
    raise ValueError(
        f"column {name} read as {time_format} has {days[0]}, none after the 12th of a "
        f"month, and read as {turned} {days[1]} that follow each other; give "
        f"--time-format '{turned}', or write the times in ISO 8601 if they are right"
    )


def refuse_mixed(columns: pd.DataFrame) -> None:
    """Refuse dates with texts: a sheet makes dates of the texts that it can read."""
    for name, column in columns.items():
        if not pd.api.types.is_object_dtype(column):
            continue
        cells = column.to_numpy()
        dated = np.array([isinstance(cell, datetime.date) for cell in cells])
        dated &= column.notna().to_numpy()
        if not dated.any():
            continue
        texts = column[~dated].dropna().astype(str)
        texts = texts[texts.str.count(r"\d+") > 2]
        if texts.empty:
            continue
        turned = [i for i in np.flatnonzero(dated) if cells[i].day != cells[i].month]
        days = texts.str.extract(DAY_AND_MONTH).astype(float).max(axis=1)
        what = (
            f"column {name!r} holds dates in {dated.sum():,} rows and text in "
            f"{len(texts):,}, such as {texts.iloc[0]!r}"
        )
        if turned and (days > 12).all() and max(d.day for d in cells[dated]) <= 12:
            first = cells[turned[0]]
            right = first.replace(month=first.day, day=first.month)
            what += (
                "; day and month are exchanged in these dates, since none is after "
                f"the 12th of a month and each text is: the first is row {turned[0]}, "
                f"{as_text(first)!r}, which is {as_text(right)!r}"
            )
        raise ValueError(
            f"{what}; read the logger's own text file, or import it into the sheet "
            "anew with this column as text"
        )


def unevenness(column: pd.Series) -> tuple[int, float]:
    """
    How far times are from following each other.

    Parameters
    ----------
    column : Series of datetime64

    Returns
    -------
    back : int
        Number of steps that do not rise.
    length : float
        Sum of the absolute steps. [s]
    """
    steps = np.diff(instants(pd.DatetimeIndex(column))) / np.timedelta64(1, "s")
    return int((steps <= 0).sum()), float(np.abs(steps).sum())


def joined_times(columns: pd.DataFrame) -> pd.Series:
    """
    The times as one column, where a file has them in one or in several.

    Parameters
    ----------
    columns : DataFrame, shape (rows, parts)
        A column of times, or the parts of a time, such as a date and a time of day.

    Returns
    -------
    Series
        One column as it is, except that a date that stands once a day is in all rows of
        it, and of a range its end; parts as texts with a space between them.
    """
    first, *others = (column for _, column in with_filled_dates(columns).items())
    if not others:
        return ends_of_ranges(first) if has_ranges(first) else first
    text = [column.map(as_text) for column in others]
    if len(text) == 1 or text[-1].str.len().max() > 2:
        text[-1] = text[-1].str.zfill(4)  # 930 is 09:30
    return first.map(as_text).str.cat(text, sep=" ")


def as_text(value: float | str) -> str:
    """
    A cell of a date or of a time as text.

    Parameters
    ----------
    value : datetime, float or str

    Returns
    -------
    str
        Of midnight only the date, of a whole number only its digits.
    """
    if isinstance(value, datetime.datetime):
        bare = value.time() == datetime.time(0)
        return str(value.date()) if bare else value.isoformat(sep=" ")
    if isinstance(value, numbers.Real) and value == value and value == int(value):
        return str(int(value))
    return str(value).strip()


def zoned(index: Any, tz: str) -> pd.DatetimeIndex:
    """
    Times in a zone, of which none may be lost.

    Parameters
    ----------
    index : DatetimeIndex
        Naive times are local in the zone; others are converted.
    tz : str
        Name of a zone, such as ``"Europe/Brussels"``.

    Returns
    -------
    DatetimeIndex

    Raises
    ------
    ValueError
        If there is no such zone, or its clock skips a time or shows it twice and the
        times have it once.
    """
    index, kept, lost = in_zone(index, tz)
    if not kept.all():
        raise ValueError(
            f"--tz {tz}: {lost[0]}; loggers mostly keep standard time, for example "
            "--tz Etc/GMT-1 for one hour east of Greenwich"
        )
    return index


def in_zone(index: Any, tz: Any) -> Any:
    """
    Times in a zone, where naive ones are local.

    Of an hour that autumn has twice the order of the rows tells which is which.

    Parameters
    ----------
    index : DatetimeIndex
    tz : str

    Returns
    -------
    DatetimeIndex, array of bool, list of str
        Times, the rows that have one in that zone, and what is said of others.

    Raises
    ------
    ValueError
        If there is no such zone.
    """
    try:
        ZoneInfo(tz)
    except (ZoneInfoNotFoundError, ValueError, OSError) as error:
        raise ValueError(
            f"--tz {tz}: there is no such zone; zones are called such as "
            "Europe/Brussels, or Etc/GMT-1 for one hour east of Greenwich"
        ) from error
    if index.tz is not None:
        return index.tz_convert(tz), np.ones(len(index), dtype=bool), []
    if len(index) and index[0] > index[-1]:  # the newest row is the first
        times, there, once = (part[::-1] for part in naive_in_zone(index[::-1], tz))
    else:
        times, there, once = naive_in_zone(index, tz)
    lost = [*skipped(index, tz, there), *once_only(index, tz, once)]
    return times, there & ~once, lost


def naive_in_zone(index: Any, tz: str) -> Any:
    """
    Put naive times into a zone.

    Parameters
    ----------
    index : DatetimeIndex, shape (rows,)
        Naive, in the order of the clock.
    tz : str

    Returns
    -------
    times : DatetimeIndex, shape (kept,)
        In the zone, of rows with ``there & ~once``.
    there : array of bool, shape (rows,)
        Whether the zone's clock shows the time.
    once : array of bool, shape (rows,)
        Whether the row is of an hour that the clock shows twice and ``index`` has once.
    """
    first = ~index.duplicated()
    local = index.tz_localize(tz, ambiguous=first, nonexistent="NaT")
    there = np.asarray(local.notna())
    once = np.zeros(len(index), dtype=bool)
    try:
        return index[there].tz_localize(tz, ambiguous="infer"), there, once
    except Exception:  # of pandas' own, or of the zones' library: an hour is there once
        twice = index.tz_localize(tz, ambiguous="NaT", nonexistent="shift_forward")
        once = np.asarray(twice.isna()) & ~index.duplicated(keep=False)
    return local[there & ~once], there, once


def once_only(index: Any, tz: str, once: Any) -> list[str]:
    """
    Note on rows in an hour that a clock shows twice, and a file has once.

    Parameters
    ----------
    index : DatetimeIndex, shape (rows,)
        Naive.
    tz : str
    once : array of bool, shape (rows,)
        Such rows, which the record does not keep.

    Returns
    -------
    list of str
        One sentence, or none without such rows.
    """
    if not once.any():
        return []
    return [
        f"rows in the hour that the clock of {tz} shows twice and the file has once, "
        f"left out: {once.sum():,}, the first is {index[once][0]}"
    ]


def skipped(index: Any, tz: Any, there: Any) -> list[str]:
    """
    Note on rows at times that a clock never shows.

    Parameters
    ----------
    index : DatetimeIndex, shape (rows,)
        Naive.
    tz : str
    there : array of bool, shape (rows,)
        Rows at times that the clock shows; the record keeps only these.

    Returns
    -------
    list of str
        One sentence, or none without such rows.
    """
    if there.all():
        return []
    hours = standard_offset(tz)
    fixed = f" (Etc/GMT{-hours:+.0f})" if hours == round(hours) else ""
    return [
        f"rows at times that the clock of {tz} skips, left out: {(~there).sum():,}, "
        f"the first is {index[~there][0]}; a logger that writes such times keeps "
        f"standard time{fixed}"
    ]


def in_order(
    data: Any, sort: bool = False, drop_doubled: bool = False
) -> tuple[pd.DataFrame, list]:
    """
    Rows in the order of their times, each time once, if requested.

    Parameters
    ----------
    data : DataFrame
        With a DatetimeIndex.
    sort : bool, default False
        Sort rows by time; rows with the same time keep their order.
    drop_doubled : bool, default False
        Of rows with the same time keep the first.

    Returns
    -------
    data : DataFrame
    notes : list of str
        What was done, a sentence each.
    """
    notes = []
    if sort and not data.index.is_monotonic_increasing:
        moved = int((np.diff(data.index.asi8) < 0).sum())
        data = data.sort_index(kind="stable")
        times = "once" if moved == 1 else f"{moved:,} times"
        notes.append(f"rows sorted by time, which went back {times}")
    if drop_doubled and data.index.has_duplicates:
        twice = data.index.duplicated()
        data = data[~twice]
        notes.append(f"rows whose time was there already, left out: {twice.sum():,}")
    return data, notes
