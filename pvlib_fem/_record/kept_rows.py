"""Rows that a column marks as good, such as a historian's quality."""

import re
import shlex
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pvlib_fem._record.file_times import of_numbers
from pvlib_fem._spelling import did_you_mean

if TYPE_CHECKING:
    from pvlib_fem._record.layout import Layout

#: columns that say whether a reading counts
QUALITY = re.compile(r"qual|valid|status|flag|state|zustand|^qc|^q$", re.IGNORECASE)
#: what they say of one that does; 192 is that of OPC
GOOD = re.compile(r"good|ok|valid|gut|gültig|bon(ne)?|192", re.IGNORECASE)
MOST_WORDS = 20  # of a column that says it


def pairs_of(keep: Iterable[str]) -> dict[str, list[str]]:
    """
    Texts by column.

    Parameters
    ----------
    keep : sequence of str
        Of the form ``COLUMN=TEXT``.

    Returns
    -------
    dict of list of str

    Raises
    ------
    ValueError
        If one has another form.
    """
    pairs: dict[str, list[str]] = {}
    for one in keep:
        column, equals, text = one.partition("=")
        if not (equals and column and text):
            raise ValueError(
                f"--keep {one!r}: it has to be COLUMN=TEXT, such as Quality=Good"
            )
        pairs.setdefault(column, []).append(text)
    return pairs


def with_good_rows(
    data: pd.DataFrame, keep: Sequence[str], notes: list[str]
) -> pd.DataFrame:
    """
    The rows of a table with one of the texts in each column that it has.

    Parameters
    ----------
    data : DataFrame
        As it is in the file.
    keep : sequence of str
        See `pairs_of`.
    notes : list of str
        Takes a sentence for each column, with the number of rows that are left out.

    Returns
    -------
    DataFrame
        Without text in the other rows a column may be one of numbers.

    Raises
    ------
    ValueError
        If no row remains.
    """
    whole = data
    for column, words in pairs_of(keep).items():
        if column not in data:
            continue
        texts = texts_of(data[column])
        good = texts.isin(words)
        either = " or ".join(map(repr, words))
        if not good.any():
            there = list(texts.value_counts().index[:5])
            raise ValueError(
                f"--keep {column}: no row has {either}{did_you_mean(words, there)}; "
                f"there are {', '.join(map(repr, there))}"
            )
        notes.append(
            f"rows whose {column!r} is not {either}, left out: {(~good).sum():,}"
        )
        data = data[good]
    return data if data is whole else of_numbers(data)


def ungraded(data: pd.DataFrame, layout: "Layout") -> Iterator[str]:
    """
    A sentence for readings that their own table says not to be good.

    Parameters
    ----------
    data : DataFrame
        As it is in the file.
    layout : Layout
        Of the file.

    Yields
    ------
    str
        Of a table with a row for each reading, if nothing is said of those to keep.
    """
    if not layout.tag or layout.keep:
        return
    taken = (*layout.time, layout.tag, layout.value)
    for one in good_texts(data, [name for name in data if name not in taken]):
        column, _, text = one.partition("=")
        rows = np.count_nonzero(texts_of(data[column]) != text)
        yield (
            f"{rows:,} rows whose {column!r} is not {text!r} are used; --keep "
            f"{shlex.quote(one)} leaves them out"
        )


def refuse_unknown(keep: Sequence[str], headers: Iterable[Iterable[str]]) -> None:
    """
    Refuse a column of good rows that no file has.

    Parameters
    ----------
    keep : sequence of str
        See `pairs_of`.
    headers : iterable
        Names of the columns of each file.

    Raises
    ------
    ValueError
        With near names, and those that there are.
    """
    there = list(dict.fromkeys(str(name) for names in headers for name in names))
    for column in pairs_of(keep):
        if column not in there:
            raise ValueError(
                f"--keep: there is no column {column!r}{did_you_mean(column, there)}; "
                f"there are {', '.join(there)}"
            )


def texts_of(column: pd.Series) -> pd.Series:
    """A column as text, 192.0 as 192."""
    if pd.api.types.is_numeric_dtype(column):
        return column.map("{:.15g}".format)
    return column.astype(str).str.strip()


def good_texts(data: pd.DataFrame, others: Iterable[str]) -> list[str]:
    """
    What a table of readings itself says of those that count.

    Parameters
    ----------
    data : DataFrame
        With a row for each reading.
    others : iterable of str
        Columns that are neither times nor tags nor readings.

    Returns
    -------
    list of str
        ``COLUMN=TEXT`` of columns that have other texts, too.
    """
    texts = []
    for column in others:
        if not QUALITY.search(str(column)) or data[column].nunique() > MOST_WORDS:
            continue
        words = texts_of(data[column]).unique()
        good = [word for word in words if GOOD.fullmatch(word)]
        if good and len(words) > len(good):
            texts += [f"{column}={word}" for word in good]
    return texts
