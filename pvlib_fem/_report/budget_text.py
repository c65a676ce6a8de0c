"""The remaining error by time scale, in words."""

from collections.abc import Hashable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from pvlib_fem._budget.unusual_days import FEWEST
from pvlib_fem._report.formatting import two_decimals

if TYPE_CHECKING:
    from pvlib_fem._loop.results.loop_result import Loop

MOST = 3  # episodes that are reported one by one
SMALL = 0.005  # K or K²: nothing in two decimals
#: rows of the budget by their kind
PARTS = {
    "start": "{} model",
    "taken": "removed by {}",
    "left": "remaining error",
    "episodes": "remaining {}",
    "scale": "remaining {}",
    "of which": "of which {}",
}
#: what is known to change so
CAUSES = {
    "from week to week": "has a slow cause, such as a season, soiling, growing "
    "plants or an instrument that drifts",
    "from day to day": "has a cause with a calendar, such as rain, snow or work on the "
    "site, or comes with the weather of whole days",
    "within the day": "comes and goes with the hour, the sun, wind or clouds",
    "on days that stand out": "should be in the site's log",
    "within the hour": "is as fast as clouds and gusts",
    "from row to row": "is noise of sensors and loggers, which no model explains",
}


def budget_by_scale(loop: "Loop") -> pd.Series:
    """Mean squares of the remaining error by time scale, the largest first."""
    budget = loop.budget
    parts = budget.loc[budget["kind"].isin(["episodes", "scale"]), "mean_square"]
    return parts.sort_values(ascending=False, kind="stable")


def error_in_time(loop: "Loop") -> str:
    """
    A sentence on the time scales of the remaining error; "" if none is known.

    Parameters
    ----------
    loop : Loop
        Loop with its budget and its episodes.

    Returns
    -------
    str
        With the remaining error [K] and the mean square of each time scale [K²].
    """
    budget, parts = loop.budget, budget_by_scale(loop)
    remaining = budget["mean_square"][budget["kind"] == "left"].iloc[0]
    if not remaining > 0.0:
        return ""
    start = budget["mean_square"].iloc[0]
    sizes = (f"{square:.2f} K² {name}" for name, square in parts.items())
    known = [words for words, size in zip(sizes, parts) if size >= SMALL]
    words = (
        f"{np.sqrt(remaining):.2f} K remain ({remaining:.2f} of {start:.2f} K², "
        f"{100 * remaining / start:.0f} % of the squared error)"
    )
    if known:
        words += f": {', '.join(known)}"
    if parts.iloc[0] > 0.5 * remaining:
        words += f"; most of it {CAUSES[parts.index[0]]}"
    if loop.fit.summary.days < FEWEST:
        return f"{words}; at least {FEWEST} days are needed to find days that stand out"
    return words + ("" if len(loop.episodes) else "; no days stand out by date")


def days_that_stand_out(
    loop: "Loop", most: int | None = MOST
) -> Iterator[tuple[str, str]]:
    """
    Days that stand out and what is said of them, the largest share first.

    Parameters
    ----------
    loop : Loop
        Loop with its episodes.
    most : int or None, default 3
        Number of episodes; None for all.

    Yields
    ------
    (str, str)
        From and to, and the mean residual by day and by night with the share of the
        error.
    """
    rows = loop.episodes.to_dict("records")
    for row in rows[:most]:
        share = f"{100 * row['share']:.2g} % of the mean square of all weeks"
        yield episode_span(row), f"{deviation_by_day_and_night(row)}, {share}"


def more_episodes(loop: "Loop") -> str:
    """
    Number of episodes beyond the first three; "" if there are no more.

    Parameters
    ----------
    loop : Loop
        Loop with its episodes.

    Returns
    -------
    str
    """
    count = len(loop.episodes) - MOST
    return f"{count} more in loop.episodes" if count > 0 else ""


def episode_span(row: Mapping[Hashable, Any]) -> str:
    """
    From and to of an episode.

    Parameters
    ----------
    row : dict
        Row of ``loop.episodes``, with ``start`` and ``end``, its last day.

    Returns
    -------
    str
        One date for an episode of one day.
    """
    start, end = (f"{row[name]:%Y-%m-%d}" for name in ("start", "end"))
    return start if start == end else f"{start} to {end}"


def deviation_by_day_and_night(row: Mapping[Hashable, Any]) -> str:
    """
    How much warmer or colder the module was than modelled, by day and by night.

    Parameters
    ----------
    row : dict
        Row of ``loop.episodes``, with ``day`` and ``night``: means of measured minus
        modelled temperature, or NaN. [K]

    Returns
    -------
    str
    """
    words = []
    for when in ("day", "night"):
        if abs(row[when]) >= 0.05:  # not where it is unknown
            way = "warmer" if row[when] > 0 else "colder"
            words.append(f"{abs(row[when]):.1f} K {way} by {when}")
    return " and ".join(words) + " than modelled" if words else "now warmer, now colder"


def budget_cells(loop: "Loop") -> Iterator[tuple[str, ...]]:
    """
    Rows of the budget for a page.

    Parameters
    ----------
    loop : Loop
        Loop with its budget.

    Yields
    ------
    tuple of str
        Part, mean square [K²], its root [K], share [%] and weeks.
    """
    for name, row in loop.budget.iterrows():
        values = (row["mean_square"], row["error"], 100 * row["share"])
        words = PARTS[row["kind"]].format(str(name).removeprefix("+"))
        yield words, *map(two_decimals, values), row["weeks"]
