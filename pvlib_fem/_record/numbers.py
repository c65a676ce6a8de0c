"""Numbers as people write them: with a sign between thousands, or a decimal comma."""

import re
import shlex
from typing import Any

import numpy as np
import pandas as pd


def form_of(decimal: str) -> re.Pattern:
    """The form of a number with that decimal sign and none between its thousands."""
    sign = re.escape(decimal)
    return re.compile(rf"[+-]?(\d+({sign})?\d*|{sign}\d+)([eE][+-]?\d+)?")


#: usual decimal signs: what a number looks like, and what may stand between thousands
NUMBERS = {sign: form_of(sign) for sign in ".,"}
SIGNS = {".": (",", " ", "'"), ",": (".", " ", "'")}
WITH_UNIT = re.compile(r"[+-]?\d+(?:[.,]\d+)?(\s*[^\d\s.,:/-][^\d]{0,8}\d?)")
MOSTLY = 0.5  # share of a column's cells that are plain numbers, where some are marked
FEW_MARKS = 5
MARKED = re.compile(r"[+-]?\d+(?:[.,]\d+)?\s*[^\w\s.,:/%°-]")
SPACES = r"[ \u00a0\u202f]"  # also those at which no line breaks


def mostly_numbers(column: Any) -> bool:
    """
    Whether a column holds numbers, perhaps with text for missing ones.

    Parameters
    ----------
    column : Series

    Returns
    -------
    bool
        False of times.
    """
    kinds = pd.api.types
    if kinds.is_object_dtype(column) or kinds.is_string_dtype(column):
        there = pd.to_numeric(column, errors="coerce").notna().sum()
        return there > MOSTLY * column.notna().sum()
    return kinds.is_numeric_dtype(column)


def grouped_number(thousands: str, decimal: str) -> re.Pattern[str]:
    """The form of a number with a sign between its thousands."""
    sign = SPACES if thousands == " " else re.escape(thousands)
    return re.compile(rf"[+-]?[1-9]\d{{0,2}}({sign}\d{{3}})+({re.escape(decimal)}\d*)?")


def ungrouped(column: Any, thousands: Any, decimal: str) -> pd.Series:
    """
    Numbers of a column of text; what is none stays as it is.

    Only a sign with three digits after it stands between thousands: 1.5 is no 15.

    Parameters
    ----------
    column : Series
    thousands : str
        Sign between thousands; a space is also one at which no line breaks.
    decimal : str
        Decimal sign.

    Returns
    -------
    Series
        Of float if all cells are numbers or missing.
    """
    form, usual = grouped_number(thousands, decimal), form_of(decimal)

    def number(cell: str) -> Any:
        bare = cell.strip() if isinstance(cell, str) else ""
        if form.fullmatch(bare):
            whole, _, rest = bare.partition(decimal)
            return float(re.sub(r"[^\d+-]", "", whole) + "." + rest)
        if usual.fullmatch(bare):
            return float(bare.replace(decimal, "."))
        return cell

    return column.astype(object).map(number, na_action="ignore").infer_objects()


def unmarked(column: Any, marks: Any, decimal: str) -> pd.Series:
    """
    A column of text without the numbers that one of some marks stands behind.

    Parameters
    ----------
    column : Series
    marks : sequence of str
        Such as ``("*",)``.
    decimal : str
        Decimal sign.

    Returns
    -------
    Series
        Marked numbers are NaN, others are numbers, and further text stays.
    """
    usual = form_of(decimal)

    def number(cell: str) -> Any:
        bare = cell.strip() if isinstance(cell, str) else ""
        for mark in marks:
            if bare.endswith(mark) and usual.fullmatch(bare.removesuffix(mark).strip()):
                return np.nan
        return float(bare.replace(decimal, ".")) if usual.fullmatch(bare) else cell

    return column.astype(object).map(number, na_action="ignore").infer_objects()


def marks_of(texts: list, decimal: str) -> tuple[str, ...]:
    """
    Marks behind the numbers of columns that have others without one.

    Parameters
    ----------
    texts : list of Series
        Columns of text.
    decimal : str
        Decimal sign.

    Returns
    -------
    tuple of str
        One or two characters each; empty with none, or more than five.
    """
    usual, marks = form_of(decimal), {}
    for column in texts:
        some = strings(column).str.strip()
        plain = some.map(usual.fullmatch).notna()
        bare = some[~plain].str.extract(r"^(.*?)\s*([^\d\s.,]{1,2})$")
        numbers = bare[0].map(usual.fullmatch, na_action="ignore").notna()
        if plain.sum() > MOSTLY * len(some) and len(bare) and numbers.all():
            marks |= dict.fromkeys(bare[1].unique())
    return tuple(marks) if len(marks) <= FEW_MARKS else ()


def strings(column: pd.Series) -> pd.Series:
    """The cells of a column that are text."""
    return column[column.map(lambda cell: isinstance(cell, str))]


def thousands_of(texts: list, decimal: str) -> str:
    """
    The sign between the thousands of columns of text.

    Parameters
    ----------
    texts : list of Series
        Columns of text.
    decimal : str
        Decimal sign.

    Returns
    -------
    str
        Empty without one.
    """
    for sign in SIGNS.get(decimal, ()):
        form = grouped_number(sign, decimal)
        for column in texts:
            some = strings(column).str.strip()
            marked = some.map(form.fullmatch).notna()
            if marked.any() and some[~marked].map(NUMBERS[decimal].fullmatch).all():
                return sign
    return ""


def refuse_text(column: pd.Series, name: str) -> None:
    """
    Refuse a column with text among its numbers.

    Parameters
    ----------
    column : Series
        On its times.
    name : str
        Of the column.

    Raises
    ------
    ValueError
        With the text, its time and row, and the option that may make it a number.
    """
    if pd.api.types.is_numeric_dtype(column) or column.isna().all():
        return
    text = strings(column)
    bad = text[pd.to_numeric(text, errors="coerce").isna()]
    if bad.empty and len(text) < column.count():  # all others could be read
        bad = text
    if bad.empty:
        return
    word, at = str(bad.iloc[0]), bad.index[0]
    row = int(np.argmax(column.index == at))
    several = f", and in {len(bad) - 1:,} more rows" if len(bad) > 1 else ""
    raise ValueError(
        f"{name} holds {word!r} at {at} (row {row}){several}, which is not a number; "
        f"{remedy_for(word)}"
    )


def remedy_for(word: str) -> str:
    """The option that may make a number of a text."""
    comma = pd.to_numeric(word.replace(",", ".", 1), errors="coerce")
    commas = "," in word and pd.notna(comma)
    remedies = ["--decimal , if commas are decimal"] if commas else []
    for decimal, sign in ((d, sign) for d, signs in SIGNS.items() for sign in signs):
        if grouped_number(sign, decimal).fullmatch(word.strip()):
            option = f"--thousands {sign if sign in ',.' else repr(sign)}"
            option += " --decimal ," if decimal == "," else ""
            remedies.insert(0, f"{option} if that stands between thousands")
            break
    if MARKED.fullmatch(word.strip()):
        mark = word.strip()[-1]
        return (
            f"give --missing {shlex.quote(mark)} if {mark!r} marks values that are not "
            "to be used, or take it out of the cells"
        )
    if with_unit := WITH_UNIT.fullmatch(word):
        return f"take the unit {with_unit[1].strip()!r} out of the cells"
    missing = f"--missing '{word}' if it stands for a missing value"
    return f"give {' or '.join(remedies or [missing])}"
