"""The form of times, and letters of zones, each of which is one distance from UTC."""

import re
from datetime import datetime, timedelta
from typing import Any
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

import numpy as np
import pandas as pd

ISO = "ISO8601"  # the form of times, unless another is given
#: hours before UTC of letters that one zone alone has, or several that agree
HOURS = {
    **dict.fromkeys(("UTC", "GMT", "WET", "WEZ"), 0.0),
    **dict.fromkeys(("BST", "WEST", "WESZ", "CET", "MEZ"), 1.0),
    **dict.fromkeys(("CEST", "MESZ", "EET", "OEZ", "SAST", "CAT"), 2.0),
    **dict.fromkeys(("EEST", "OESZ", "IDT", "EAT", "MSK", "TRT"), 3.0),
    **{"GST": 4.0, "PKT": 5.0, "ICT": 7.0, "WIB": 7.0, "AWST": 8.0, "HKT": 8.0},
    **{"SGT": 8.0, "MYT": 8.0, "JST": 9.0, "KST": 9.0, "ACST": 9.5, "AEST": 10.0},
    **{"ACDT": 10.5, "AEDT": 11.0, "NZST": 12.0, "NZDT": 13.0},
    **{"NDT": -2.5, "ADT": -3.0, "BRT": -3.0, "ART": -3.0, "CLST": -3.0, "NST": -3.5},
    **{"AST": -4.0, "EDT": -4.0, "CLT": -4.0, "EST": -5.0, "CDT": -5.0, "MDT": -6.0},
    **{"MST": -7.0, "PDT": -7.0, "PST": -8.0, "AKDT": -8.0, "AKST": -9.0, "HST": -10.0},
}
#: letters that zones do not agree on, the most usual zone first
SEVERAL = {
    "CST": ("America/Chicago", "Asia/Shanghai"),
    "IST": ("Asia/Kolkata", "Europe/Dublin", "Asia/Jerusalem"),
}
SUMMER = "DST"  # which marks summer time of the zone that the other times are of
LETTERS = re.compile(r"\b(?!AM\b|PM\b)[A-Z]{3,5}\b")
DAYS = [datetime(2023, month, 1) for month in (1, 7)]


def names_of(tz: str | None) -> dict[str, float]:
    """The letters of a zone's clock, and their hours before UTC."""
    try:
        times = [day.replace(tzinfo=ZoneInfo(tz)) for day in DAYS] if tz else []
    except (ZoneInfoNotFoundError, ValueError, OSError):  # refused with the times
        return {}
    offsets = {time.tzname(): time.utcoffset() or timedelta() for time in times}
    return {name: offset.total_seconds() / 3600.0 for name, offset in offsets.items()}


def standard_and_summer(tz: str) -> tuple[float, float]:
    """Hours before UTC of a zone in winter, and of its summer time."""
    hours = names_of(tz).values() or [0.0]
    return min(hours), max(*hours, min(hours) + 1.0 * (len({*hours}) == 1))


def zones_of(column: Any) -> list[str]:
    """
    The zones that the letters of times may mean, where these are of several.

    Parameters
    ----------
    column : Series of str

    Returns
    -------
    list of str
        The most usual first, only those that have all letters of the column if any has;
        empty where no letters are of several zones.
    """
    # in the order of the column, so that each run has the same zones
    abbreviations = dict.fromkeys(map(last_letters, column.astype(str).unique()))
    abbreviations.pop("", None)  # of a cell without letters
    zones = [SEVERAL[letters] for letters in abbreviations if letters in SEVERAL]
    # of two in one file, such as CST and CDT, the zone that has both
    if zones and (
        fitting := [z for z in zones[0] if {*abbreviations} <= {*names_of(z)}]
    ):
        return fitting
    return list(zones[0]) if zones else []


def last_letters(text: str) -> str:
    """
    The letters of a zone at the end of a time.

    Parameters
    ----------
    text : str

    Returns
    -------
    str
        Such as ``"CET"``; empty without any, and never AM or PM.
    """
    all_letters = LETTERS.findall(text)
    return all_letters[-1] if all_letters else ""


def without_letters(
    column: Any, time_format: str, tz: str | None = None
) -> tuple[pd.Series, str, Any]:
    """
    Texts and format without the letters of a zone, and their hours before UTC.

    Parameters
    ----------
    column : Series of str
    time_format : str
        With ``%Z``.
    tz : str, optional
        The zone that the letters are of. Of times that DST alone marks, those without
        letters are its standard time.

    Returns
    -------
    text : Series of str
    time_format : str
        With a space for ``%Z``, but none at its ends.
    hours : array, shape (rows,)
        Positive east of Greenwich; NaN where a text has no letters. [h]

    Raises
    ------
    ValueError
        If they are unknown, or of several zones and none is given.
    """
    text = column.astype(str)
    letters = text.map(last_letters)
    known = HOURS | names_of(tz)
    if tz and SUMMER in {*letters}:
        known[""], known[SUMMER] = standard_and_summer(tz)
    for row, name in enumerate(letters):
        if name and name not in known:
            raise unknown_letters_error(name, row, time_format)
    bare = [
        " ".join(one.rsplit(name, 1)) if name else one
        for one, name in zip(text, letters)
    ]
    hours = letters.map(lambda name: known.get(name, np.nan)).to_numpy(float)
    text = pd.Series(bare, column.index).str.strip()
    return text, time_format.replace("%Z", " ").strip(), hours


def unknown_letters_error(name: str, row: Any, time_format: str) -> ValueError:
    """The error of letters that do not tell the distance from UTC."""
    if name in SEVERAL:
        zones = " or ".join(f"--tz {zone}" for zone in SEVERAL[name])
        return ValueError(
            f"{name} stands for more than one zone in row {row} of the times; give "
            f"{zones}"
        )
    if name == SUMMER:
        return ValueError(
            f"{name} in row {row} of the times marks the summer time of a zone that "
            "they do not name; give --tz, such as Europe/Madrid"
        )
    form = time_format.replace("%Z", name)
    return ValueError(
        f"the zone {name!r} in row {row} of the times is not known; give --time-format "
        f"{form!r} with its letters as they stand, and --tz, such as Etc/GMT-1 for one "
        "hour east of Greenwich"
    )
