"""Three kinds of weeks, made once: to fit, to choose, and to test."""

from enum import IntEnum

import numpy as np
import pandas as pd

from pvlib_fem.statistics.clusters import calendar_weeks


class Part(IntEnum):
    """What a row is for."""

    FITTING = 0  # coefficients, and what every effect would explain
    CHOOSING = 1  # whether a refit is kept
    TEST = 2  # the errors that are told; nothing looks at them before


def named(parts):
    """The parts by name, as a user is told them."""
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

    Notes
    -----
    A record that is too short for a name has no choosing weeks: nothing is
    chosen on it.
    """
    found = np.full(len(seen), Part.FITTING, dtype=np.int8)
    first, days = record.inputs.times.runs
    weeks = np.unique(calendar_weeks(days), return_inverse=True)[1]
    weeks = np.repeat(weeks, np.diff(first, append=len(seen)))
    if holdout is not None:
        found[record.rows(holdout)] = Part.TEST
    elif weeks.max() + 1 >= criteria.fewest_weeks:
        found[nth(weeks, criteria.test_every)] = Part.TEST
    elif record.count_days(seen) > 1:
        found[record.days % 2 == 1] = Part.TEST
    if record.count_days(seen) >= criteria.enough_days:
        rest = np.flatnonzero(found == Part.FITTING)
        others = np.cumsum(np.bincount(weeks[rest]) > 0) - 1  # place of each week
        found[rest[nth(others[weeks[rest]], criteria.choose_every)]] = Part.CHOOSING
    return found


def nth(numbers, every):
    """One of every so many, in the middle of them."""
    return numbers % every == every // 2
