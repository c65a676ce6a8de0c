"""Two kinds of weeks, made once: to fit, and to test."""

from collections.abc import Collection, Iterator
from enum import IntEnum
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pvlib_fem._record.inputs import Record
from pvlib_fem._statistics.clusters import calendar_weeks
from pvlib_fem.effects._time_profiles import date_text

if TYPE_CHECKING:
    from pvlib_fem._loop.criteria import Criteria

FEWEST_WEEKS = 5  # below which every other day is a test day


class Part(IntEnum):
    """What a row is for."""

    FITTING = 0  # coefficients, and what every effect would explain
    TEST = 1  # the errors that are reported; nothing looks at them before


def part_names(parts: np.ndarray) -> "pd.Categorical[str]":
    """
    The parts of rows by name, as users see them: ``fitting`` or ``test``.

    Parameters
    ----------
    parts : array of Part, shape (rows,)
        What each row is for, see :func:`.weeks.parts`.

    Returns
    -------
    Categorical, length rows
        Its categories are the parts that occur.
    """
    there = [part.name.lower() for part in Part if (parts == part).any()]
    names = pd.Index([part.name.lower() for part in Part])
    return pd.Categorical.from_codes(parts, names).set_categories(there)


def parts_of_rows(
    record: Record,
    seen: np.ndarray,
    holdout: pd.Series | None,
    criteria: "Criteria",
    spared: Collection[int] = (),
) -> np.ndarray:
    """
    What each row of a record is for.

    Parameters
    ----------
    record : Record
    seen : array of bool, shape (rows,)
        Rows that count.
    holdout : Series of bool, optional
        The test rows; by default every fifth week, or every other day of a record
        of few weeks.
    criteria : Criteria
    spared : sequence of int
        Days since 1970-01-01 that are no test days by default.

    Returns
    -------
    array of Part, shape (rows,)
    """
    purposes = np.full(len(seen), Part.FITTING, dtype=np.int8)
    first, days = record.inputs.times.runs
    weeks = np.unique(calendar_weeks(days), return_inverse=True)[1]
    weeks = np.repeat(weeks, np.diff(first, append=len(seen)))
    if holdout is not None:
        purposes[record.rows(holdout)] = Part.TEST
    elif weeks.max() + 1 >= FEWEST_WEEKS:
        purposes[nth(weeks, criteria.test_every)] = Part.TEST
    elif record.count_days(seen) > 1:
        purposes[record.days % 2 == 1] = Part.TEST
    if len(spared) and holdout is None:
        purposes[np.isin(record.dates, [*spared])] = Part.FITTING
    return purposes


def fitted_weeks(spared: Collection[int]) -> Iterator[str]:
    """
    A line on each week that would be a test week without a standstill.

    Parameters
    ----------
    spared : collection of int
        Days from 1970-01-01 that are no test days.

    Yields
    ------
    str
    """
    weeks = {int(calendar_weeks(np.array(day))): day for day in sorted(spared)[::-1]}
    for first in sorted(weeks.values()):
        yield (
            f"the week from {date_text(first)} on is fitted and not a test week: "
            "modules may have been stuck on some of its days"
        )


def nth(numbers: np.ndarray, every: int) -> np.ndarray:
    """One of every so many, in the middle of them."""
    return numbers % every == every // 2
