"""Names of columns from labels of several levels."""

import re
from typing import Any

import pandas as pd

#: what pandas writes for a cell of a header that is empty
EMPTY = re.compile(r"Unnamed: \d+(_level_\d+)?")


def joined_labels(levels: list) -> list[str]:
    """
    One name for each column, of the levels of its label from the top.

    Parameters
    ----------
    levels : sequence of sequences of str

    Returns
    -------
    list of str
        A level that repeats the one above is dropped; a column without a
        label has a number, as pandas gives it.
    """
    names = [name_of(parts) for parts in zip(*levels)]
    return [name or f"Unnamed: {n}" for n, name in enumerate(names)]


def name_of(parts: tuple) -> str:
    words = []
    for part in map(bare, parts):
        if part and part not in words[-1:]:
            words.append(part)
    return "_".join(words)


def bare(cell: str) -> str:
    text = str(cell).strip()
    return "" if EMPTY.fullmatch(text) else text


def merged(levels: list) -> list[list[str]]:
    """
    Header lines, with empty cells filled from the left in all but the last line.

    Parameters
    ----------
    levels : list of list of str
        Lines of a header from the top, with a cell for each column.

    Returns
    -------
    list of list of str
        Cells without spaces around them; ``""`` where nothing is to the left.
    """
    *upper, last = [[bare(cell) for cell in level] for level in levels]
    return [*map(filled_level, upper), last]


def filled_level(level: Any) -> list[str]:
    cells, before = [], ""
    for cell in level:
        before = cell or before
        cells.append(before)
    return cells


def levels_of(data: Any) -> list[list]:
    """The levels of the labels of a table."""
    labels = data.columns
    return [list(labels.get_level_values(n)) for n in range(labels.nlevels)]


def with_flat_labels(data: Any) -> pd.DataFrame:
    """
    The table with labels of several levels joined to one text.

    Parameters
    ----------
    data : DataFrame

    Returns
    -------
    DataFrame
        As it is with labels of one level.
    """
    if data.columns.nlevels == 1:
        return data
    return data.set_axis(joined_labels(levels_of(data)), axis=1)


def flat_header(data: pd.DataFrame) -> pd.DataFrame:
    """
    The table with one name for each column, of a header in which cells span columns.

    Parameters
    ----------
    data : DataFrame
        As it is read, with a level of labels for each line of the header.

    Returns
    -------
    DataFrame
        Names without spaces around them.
    """
    if data.columns.nlevels == 1:
        return data.rename(columns=lambda name: str(name).strip())
    return data.set_axis(joined_labels(merged(levels_of(data))), axis=1)
