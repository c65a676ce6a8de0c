"""One row of the table, and the columns that it fills."""

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
        Whose it is, and what it is called there.
    value, stderr : float
        NaN where there is none; then ``note`` says why.
    unit : str
    freedom : float
        Degrees of freedom of the error.
    of : str
        ``"module"``, as the sensor has it, or ``"cell"``.
    mismatch : float
        Largest difference of the convention's model from the fit. [K]
    conditions, equation, source, note : str
    span : tuple of float
        Low and high, where they are not by Student's t.
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

    def cells(self):
        """What stands in the table."""
        reach = student.ppf(0.5 + LEVEL / 2, max(self.freedom, 1.0)) * self.stderr
        low, high = self.span or (self.value - reach, self.value + reach)
        own = {name: getattr(self, name) for name in COLUMNS if hasattr(self, name)}
        return own | {"low": low, "high": high}


def table_of(rows):
    """The table of some rows."""
    rows = [*rows]
    index = pd.MultiIndex.from_tuples(
        [(row.convention, row.name) for row in rows], names=["convention", "parameter"]
    )
    return pd.DataFrame([row.cells() for row in rows], index, columns=[*COLUMNS])
