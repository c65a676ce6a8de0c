"""Two kinds of weeks, made once: to fit, and to test."""

from enum import IntEnum

import numpy as np
import pandas as pd

from pvlib_fem._statistics.clusters import calendar_weeks

FEWEST_WEEKS = 5  # below which every other day is a test day


class Part(IntEnum):
    """What a row is for."""

    FITTING = 0  # coefficients, and what every effect would explain
    TEST = 1  # the errors that are reported; nothing looks at them before


def named(parts):
    """The parts by name, as users see them."""
    there = [part.name.lower() for part in Part if (parts == part).any()]
    names = pd.Categorical.from_codes(parts, [part.name.lower() for part in Part])
    return names.set_categories(there)


def parts(record, seen, holdout, criteria):
    """
    What each row of a record is for.

    Parameters
    ----------
    record : Record
    seen : array of bool
        Rows that count.
    holdout : Series of bool, optional
        The test rows; by default every fifth week, or every other day of a record
        of few weeks.
    criteria : Criteria

    Returns
    -------
    array of Part
    """
    found = np.full(len(seen), Part.FITTING, dtype=np.int8)
    first, days = record.inputs.times.runs
    weeks = np.unique(calendar_weeks(days), return_inverse=True)[1]
    weeks = np.repeat(weeks, np.diff(first, append=len(seen)))
    if holdout is not None:
        found[record.rows(holdout)] = Part.TEST
    elif weeks.max() + 1 >= FEWEST_WEEKS:
        found[nth(weeks, criteria.test_every)] = Part.TEST
    elif record.count_days(seen) > 1:
        found[record.days % 2 == 1] = Part.TEST
    return found


def nth(numbers, every):
    """One of every so many, in the middle of them."""
    return numbers % every == every // 2
