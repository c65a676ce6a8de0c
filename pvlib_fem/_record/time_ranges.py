"""Times that are written as ranges, such as 23:45 - 00:00: the end of each counts."""

import re

import pandas as pd

FIRST = 5  # rows that tell whether a column has ranges
HOUR = r"\d{1,2}:\d{2}(?::\d{2})?"
#: date and hour of the start, and the end with or without a date
RANGE = re.compile(rf"^\s*(.*?)\s*({HOUR})\s+(?:-|–|—|to|bis)\s+(.*?)\s*({HOUR})\s*$")
MIDNIGHT = re.compile(r"0?0:00(:00)?")


def has_ranges(column: pd.Series) -> bool:
    """
    Whether the times of a column are ranges.

    Parameters
    ----------
    column : Series
        Times as the file has them.

    Returns
    -------
    bool
        False of numbers, and of a column without a value.
    """
    kinds = pd.api.types
    if not (kinds.is_object_dtype(column) or kinds.is_string_dtype(column)):
        return False
    some = column.dropna().iloc[:FIRST]
    return len(some) > 0 and all(RANGE.match(str(text)) for text in some)


def ends_of_ranges(column: pd.Series) -> pd.Series:
    """
    The end of each range, as a time of the form that its start has.

    Parameters
    ----------
    column : Series
        Times for which `has_ranges` is true.

    Returns
    -------
    Series
        A time that is no range as it is. An end without a date is of the day of the
        start; midnight is then its hour 24.
    """
    parts = column.astype("string").str.extract(RANGE)
    date, begin, end_date, end = (parts[i] for i in range(4))
    dated = end_date.fillna("") != ""
    last = end.str.fullmatch(MIDNIGHT).fillna(False) & ~dated & (begin != end)
    end = end.mask(last, end.str.replace(r"^0?0", "24", regex=True))
    ends = date.mask(dated, end_date).str.cat(end, sep=" ").str.strip()
    return ends.where(end.notna(), column.astype("string")).astype(object)
