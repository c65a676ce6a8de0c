"""One sentence of a report, with the numbers in it."""

from collections.abc import Iterable
from dataclasses import dataclass, fields

import numpy as np
import pandas as pd

DAYS = "days that stand out"


@dataclass(frozen=True)
class Statement:
    """
    What a loop found of one device, and what to do about it.

    Attributes
    ----------
    cause : str
        Name of the effect, of the fault of a clock, or of the unexplained pattern.
    device : str
        The instrument, or ``"modules"``, ``"mounting"``, ``"model"``.
    verdict : str
        ``"identified"``, ``"ambiguous"``, ``"hint"`` (a hint that is not in
        the model), ``"event"`` or ``"unexplained"``; of a clock ``"corrected"`` or
        ``"not corrected"``; ``"left out"`` of a sensor whose rows are not used.
    text : str
        The finding in a sentence: device, direction, size and dates.
    action : str
        What to do; "" where nothing is to be done at the plant.
    certainty : str
        How sure the finding is, in words.
    gain : float
        What it takes off the error. [K]
    energy : float
        Absolute change of the expected DC energy by it, at -0.35 %/K; NaN where it is
        unknown. [kWh/kWp per year]
    value, error, low, high : float
        What the device reads beyond the truth, relative to before, with standard error
        and 90 % range: negative where it reads less. Of a clock the minutes by which
        its timestamps are ahead; of other effects their only coefficient.
    unit : str
        Of these four.
    since, until : str
        First and last date, ``YYYY-MM-DD``; "" where it is of the whole record.
    probability : float
    alternatives : tuple of str
        Further causes that the record cannot tell from it.
    """

    cause: str
    device: str
    verdict: str
    text: str
    action: str = ""
    certainty: str = ""
    gain: float = np.nan
    value: float = np.nan
    error: float = np.nan
    low: float = np.nan
    high: float = np.nan
    unit: str = ""
    since: str = ""
    until: str = ""
    probability: float = np.nan
    alternatives: tuple = ()
    energy: float = np.nan

    def __str__(self) -> str:
        sentences = (self.text, self.certainty, self.action)
        return " ".join(f"{one.rstrip('.')}." for one in sentences if one)


def key_of(cause: str, since: str) -> str:
    """
    Key of the energy of a statement; several stretches of days have one cause.

    Parameters
    ----------
    cause : str
        Name of the effect, fault or pattern.
    since : str
        First date.

    Returns
    -------
    str
        The cause, of stretches of days with their first date.
    """
    return f"{cause} from {since}" if cause == DAYS else cause


def as_table(statements: Iterable[Statement]) -> pd.DataFrame:
    """
    A row for each statement.

    Parameters
    ----------
    statements : iterable of Statement
        Statements in order.

    Returns
    -------
    DataFrame
        A column for each field of :class:`Statement`, indexed by ``statement`` from 0.
    """
    names = [field.name for field in fields(Statement)]
    rows = [[getattr(one, name) for name in names] for one in statements]
    return pd.DataFrame(rows, columns=names).rename_axis("statement")
