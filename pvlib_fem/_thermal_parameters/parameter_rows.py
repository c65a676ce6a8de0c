"""Rows of the table of thermal parameters, and its columns."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.stats import t as student

LEVEL = 0.95  # of the ranges
#: columns of the table, in order
COLUMNS = (
    "value",
    "unit",
    "stderr",
    "low",
    "high",
    "mismatch",
    "of",
    "conditions",
    "equation",
    "source",
    "note",
)


@dataclass(frozen=True)
class Row:
    """
    One parameter in one convention.

    Attributes
    ----------
    convention, name : str
        The convention, and the name of the parameter in it.
    value, stderr : float
        Value and standard error; if NaN, ``note`` has the reason.
    unit : str
    freedom : float
        Degrees of freedom of the error.
    of : str
        ``"module"`` (the sensor's temperature) or ``"cell"``.
    mismatch : float
        Largest difference of the convention's model from the fit. [K]
    conditions, equation, source, note : str
    span : tuple of float
        Low and high, if they are not from Student's t.
    """

    convention: str
    name: str
    value: float
    unit: str
    stderr: float = np.nan
    freedom: float = np.inf
    of: str = ""
    mismatch: float = np.nan
    conditions: str = ""
    equation: str = ""
    source: str = ""
    note: str = ""
    span: tuple | None = None

    def cells(self) -> dict:
        """Cells of the table."""
        reach = student.ppf(0.5 + LEVEL / 2, max(self.freedom, 1.0)) * self.stderr
        low, high = self.span or (self.value - reach, self.value + reach)
        own = {name: getattr(self, name) for name in COLUMNS if hasattr(self, name)}
        return own | {"low": low, "high": high}


def table_of(rows: Iterable) -> pd.DataFrame:
    """
    The table of some rows.

    Parameters
    ----------
    rows : iterable of Row

    Returns
    -------
    DataFrame
        :data:`COLUMNS` by ``convention`` and ``parameter``.
    """
    rows = [*rows]
    index = pd.MultiIndex.from_tuples(
        [(row.convention, row.name) for row in rows], names=["convention", "parameter"]
    )
    return pd.DataFrame([row.cells() for row in rows], index, columns=[*COLUMNS])
