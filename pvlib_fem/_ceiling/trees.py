"""Boosted trees that describe what a model leaves, with no idea of a cause."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from pvlib_fem._ceiling.ceiling_result import Ceiling
from pvlib_fem._ceiling.tree_columns import features
from pvlib_fem._record.filters import counted
from pvlib_fem._statistics.clusters import calendar_weeks
from pvlib_fem.scores import rmse

MOST_ROWS = 100_000  # fitting rows of the trees; of more every second, third …
MOST_TREES = 500
EVERY = 5  # of the fitting weeks, one is left out to count the trees
FEWEST_DAYS = 10  # of fitting weeks
HOW: dict[str, Any] = dict(learning_rate=0.1, early_stopping=False, random_state=0)


def ceiling_of(loop: Any) -> Ceiling:
    """
    The ceiling of a loop that has its rows, see :meth:`pvlib_fem.Loop.ceiling`.

    Parameters
    ----------
    loop : Loop

    Returns
    -------
    Ceiling

    Raises
    ------
    ImportError
        If scikit-learn is missing.
    ValueError
        If the loop was read from a file, has no test weeks, or less than 10 fitting
        days.
    """
    record, residual = loop.fit.record, loop.fit.residual
    if record is None:
        raise ValueError(
            "a loop that was read from a file has no rows to grow trees on; close it "
            "again"
        )
    before, after = loop.residual_before.to_numpy(), residual.to_numpy()
    seen = np.asarray(counted(record.inputs.columns, with_night=True))
    seen &= np.isfinite(before) & np.isfinite(after)
    test, fitting = (
        np.flatnonzero(seen & (loop.weeks == part).to_numpy())
        for part in ("test", "fitting")
    )
    days = len(np.unique(record.dates[fitting]))
    if len(test) == 0 or days < FEWEST_DAYS:
        raise ValueError(
            f"trees need {FEWEST_DAYS} fitting days and test weeks; the record "
            f"has {days} fitting days and {len(test):,} rows of test weeks: give a "
            "longer one"
        )
    fitting = fitting[:: -(-len(fitting) // MOST_ROWS)]
    rows = np.concatenate([fitting, test])
    columns, groups = features(record, loop, rows)
    trees = Trees(before[rows], len(fitting), left_out(record.dates[fitting]))
    count = trees.best(columns)
    grown = trees.error(columns, count)
    without = {
        group: trees.error({n: columns[n] for n in columns if n not in own}, count)
        for group, own in groups.items()
    }
    errors = loop.table["rmse_test"]
    return Ceiling(
        paper=float(errors["fem"]),
        causes=float(rmse(after[test], 0.0)),
        loop=float(errors.iloc[-1]),
        trees=grown,
        rows=len(test),
        without=without,
    )


def regressor() -> type:
    """
    Class of scikit-learn's trees, imported when it is needed.

    Returns
    -------
    type

    Raises
    ------
    ImportError
        If scikit-learn is missing.
    """
    try:
        from sklearn.ensemble import HistGradientBoostingRegressor
    except ImportError as error:
        raise ImportError(
            "the ceiling needs scikit-learn: pip install 'pvlib_fem[ceiling]'"
        ) from error
    return HistGradientBoostingRegressor


@dataclass(frozen=True, eq=False)
class Trees:
    """Residual of the model without findings, the fitting rows first."""

    residual: np.ndarray  # [K]
    fitting: int  # rows
    out: np.ndarray  # fitting rows that give the number of trees

    def best(self, columns: dict) -> int:
        """The number of trees with which the rows left out are described best."""
        table, kept = column_table(columns)[: self.fitting], ~self.out
        residual = self.residual[: self.fitting]
        grown = regressor()(max_iter=MOST_TREES, **HOW).fit(table[kept], residual[kept])
        steps = grown.staged_predict(table[self.out])
        return 1 + int(np.argmin([rmse(step, residual[self.out]) for step in steps]))

    def error(self, columns: dict, count: int) -> float:
        """RMSE of so many trees on the test rows. [K]"""
        table, fitting = column_table(columns), slice(self.fitting)
        grown = regressor()(max_iter=count, **HOW)
        grown.fit(table[fitting], self.residual[fitting])
        test = slice(self.fitting, None)
        return float(rmse(grown.predict(table[test]), self.residual[test]))


def column_table(columns: dict) -> np.ndarray:
    return np.column_stack(list(columns.values()))


def left_out(dates: np.ndarray) -> np.ndarray:
    """Every fifth of the fitting weeks, or of the days where weeks are few."""
    groups = np.unique(calendar_weeks(dates), return_inverse=True)[1]
    if groups.max() + 1 < EVERY:
        groups = np.unique(dates, return_inverse=True)[1]
    return groups % EVERY == EVERY // 2
