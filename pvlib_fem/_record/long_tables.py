"""Tables with a row for each reading, as historians write them, as one of columns."""

from typing import Any

import pandas as pd

from pvlib_fem._record.numbers import mostly_numbers
from pvlib_fem._spelling import did_you_mean

NAME = r"\W*[^\W\d]"  # what is read has a name that begins with a letter
FEWEST, MOST = 3, 1000  # tags that a table may have
EVEN = 0.5  # share of the most frequent tag's rows that each of the usual has, at least
FULL = 0.5  # share of the cells that have to be there, where tags share their times


def wide_table(data: Any, tag: Any, value: Any, times: Any) -> pd.DataFrame:
    """
    The table with a column for each tag.

    Parameters
    ----------
    data : DataFrame
        With a row for each reading.
    tag, value : str
        Columns of the name of what is read, and of the reading.
    times : sequence of str
        Columns of the times; of an empty one the first column of ``data`` that is
        neither the tag nor the value.

    Returns
    -------
    DataFrame
        A row for each time: the columns of the times, then the tags, both in the
        order of the file.

    Raises
    ------
    ValueError
        If a column is not there, or is one of the times, too, a tag has two readings
        at a time, or the tags have times of their own.
    """
    for name in (tag, value):
        if name not in data:
            raise ValueError(
                f"there is no column {name!r} to make columns of"
                f"{did_you_mean(name, data.columns)}; there are "
                f"{', '.join(map(str, data.columns))}"
            )
        if name in times:
            raise ValueError(
                f"column {name!r} is given for the times, and for the tags or their "
                "values, too; give --time COLUMN, --tag COLUMN and --value COLUMN"
            )
    times = list(times) or [name for name in data if name not in (tag, value)][:1]
    readings = data[[*times, tag, value]].dropna(subset=[tag])
    if (twice := readings.duplicated([*times, tag])).any():
        first = readings[twice].iloc[0]
        when = " ".join(str(first[name]) for name in times)
        raise ValueError(
            f"{first[tag]!r} has a second reading at {when}, and {twice.sum():,} are "
            "such: keep one of each, or write times with their distance from UTC if a "
            "clock shows an hour twice"
        )
    once = readings.set_index([*times, tag])[value]
    rows = readings[times].drop_duplicates().set_index(times).index
    table = once.unstack(tag).reindex(rows)[readings[tag].unique()]  # noqa: PD010
    table = table.rename_axis(columns=None)
    if len(table) and table.notna().to_numpy().mean() < FULL:
        raise ValueError(
            f"the readings of {tag!r} have times of their own: of {len(table):,} times "
            f"most have no reading of most of the {table.shape[1]} tags; write means "
            "over common steps, or a file for each tag, which are joined on their times"
        )
    return table.reset_index()


def tag_and_value(data: pd.DataFrame, times: list) -> Any:
    """
    The columns of a table with a row for each reading.

    Parameters
    ----------
    data : DataFrame
    times : list of str
        Columns of the times.

    Returns
    -------
    (str, str) or None
        Columns of the names of quantities, and of the readings; None of another table.
    """
    others = [c for c in data if c not in times]
    numeric = [c for c in others if mostly_numbers(data[c])]
    for column in others:
        if column in numeric or data[column].isna().any():
            continue
        if not data[column].astype(str).str.match(NAME).all():  # times, or codes
            continue
        rows = data[column].value_counts()
        several = FEWEST <= len(rows) <= min(MOST, len(data) // FEWEST)
        # each has about as many rows, and none comes twice at a time
        even = several and rows.median() >= EVEN * rows.iloc[0]
        if even and numeric and not data.duplicated([*times, column]).any():
            likely = [c for c in numeric if "val" in str(c).lower()]
            return column, (likely or numeric)[0]
    return None
