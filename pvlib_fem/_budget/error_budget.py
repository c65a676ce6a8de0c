"""The error budget: reductions by steps, and the remaining error in time."""

from typing import Any, TypedDict

import numpy as np
import pandas as pd

from pvlib_fem._budget.scales import by_scale
from pvlib_fem._budget.unusual_days import episodes
from pvlib_fem._converter import AnyFloat
from pvlib_fem._findings import Kind
from pvlib_fem._record.column_names import DAYLIGHT
from pvlib_fem._record.inputs import Record
from pvlib_fem.effects._time_profiles import date_text


class BudgetRow(TypedDict):
    """A row of the budget in a file, without columns that follow from others."""

    part: str
    kind: str
    mean_square: AnyFloat
    weeks: str


class EpisodeRow(TypedDict):
    """Days that stand out, in a file."""

    start: str
    end: str
    days: int
    day: AnyFloat
    night: AnyFloat
    share: AnyFloat


ENDINGS = {"test": "rmse_test", "fitting": "rmse_train"}
COLUMNS = ["kind", "mean_square", "error", "share", "weeks"]


def episodes_of(case: Any, step: Any) -> pd.DataFrame:
    """
    Stretches of days with an unusual residual of a step, as a table.

    All weeks are searched, because episodes are only reported and decide nothing.

    Parameters
    ----------
    case : Case
    step : Step

    Returns
    -------
    DataFrame
        See :func:`episode_table`, the largest share first.
    """
    residual = step.measured - step.temperature
    rows = case.seen & np.isfinite(residual)
    residual, dates = residual[rows], case.whole.dates[rows]
    sunny = case.whole["poa_global"][rows] > DAYLIGHT
    total, table_rows = residual @ residual, []
    for first, last in episodes(
        residual, dates, sunny, case.criteria.max_episode_chance
    ):
        within = (dates >= first) & (dates <= last)
        mine = residual[within]
        table_rows.append(
            {
                "start": date_text(first),
                "end": date_text(last),
                "days": last - first + 1,
                "day": mean_or_nan(residual[within & sunny]),
                "night": mean_or_nan(residual[within & ~sunny]),
                "share": float(mine @ mine / total),
            }
        )
    return episode_table(sorted(table_rows, key=lambda row: -row["share"]))


def mean_or_nan(values: np.ndarray) -> float:
    return float(values.mean()) if len(values) else np.nan


def episode_table(rows: list) -> pd.DataFrame:
    """
    Episodes as a table.

    Parameters
    ----------
    rows : list of EpisodeRow

    Returns
    -------
    DataFrame
        ``start`` and ``end``, the last day; number of ``days``; mean residual by
        ``day`` and by ``night`` [K]; ``share`` of the squared residual [-].
    """
    table = pd.DataFrame(rows, columns=[*EpisodeRow.__annotations__])
    dates = {name: pd.to_datetime(table[name]) for name in ("start", "end")}
    kinds = {"days": int, "day": float, "night": float, "share": float}
    return table.assign(**dates).astype(kinds)


def episode_rows(table: pd.DataFrame) -> list:
    """
    The table of episodes as rows of a file.

    Parameters
    ----------
    table : DataFrame
        From :func:`episode_table`.

    Returns
    -------
    list of dict
        See :class:`EpisodeRow`.
    """
    dates = {name: table[name].dt.strftime("%Y-%m-%d") for name in ("start", "end")}
    return table.assign(**dates).to_dict(orient="records")


def budget_of(
    case: Any,
    steps: dict,
    path: list,
    table: pd.DataFrame,
    findings: list,
    stretches: pd.DataFrame,
) -> pd.DataFrame:
    """
    Error budget: mean square of the steady model, reductions, and the remainder.

    The budget is of the test weeks, or of the fitting weeks without test weeks, on rows
    that all steps know. It adds up: the reductions by the steps of the path, unusual
    days, and the time scales of all other days.

    Parameters
    ----------
    case : Case
    steps : dict of Step
        All steps of the search by name.
    path : list of str
        Names of the steps of the budget in order, the steady model first.
    table : DataFrame
        ``rmse_test`` and ``rmse_train`` by name of the step. [K]
    findings : list of Finding
        Of these, unexplained patterns have rows of their own.
    stretches : DataFrame
        From :func:`episodes_of`, of the last step.

    Returns
    -------
    DataFrame
        See :func:`budget_table`.
    """
    weeks, residual, rows = budget_weeks(case, steps, steps[path[-1]])
    squares = table.loc[path, ENDINGS[weeks]] ** 2
    out = rows & rows_within(case.whole.dates, stretches)
    apart = residual[out] @ residual[out] / max(rows.sum(), 1)
    usual = (rows & ~out).sum() / max(rows.sum(), 1)
    scales = residual_by_scale(case.whole, residual, rows & ~out)
    scales = {name: usual * square for name, square in scales.items()}
    steady, remaining = squares.iloc[0], apart + sum(scales.values())
    taken = -squares.diff().iloc[1:]
    budget = [
        ("steady", "start", steady, weeks),
        *((name, "taken", square, weeks) for name, square in taken.items()),
        ("left", "left", remaining, weeks),
        *(
            [("on days that stand out", "episodes", apart, weeks)]
            * bool(len(stretches))
        ),
        *((name, "scale", square, weeks) for name, square in scales.items()),
        *(
            (f"table of {f.effect}", "of which", f.gain**2, "fitting")
            for f in findings
            if f.kind is Kind.STRUCTURE
        ),
    ]
    return budget_table(
        [
            {"part": part, "kind": kind, "mean_square": float(square), "weeks": weeks}
            for part, kind, square, weeks in budget
        ]
    )


def budget_weeks(
    case: Any, steps: dict, last: Any
) -> tuple[str, np.ndarray, np.ndarray]:
    """The weeks of the budget, the last residual, and the mask of their rows."""
    everywhere = np.all([np.isfinite(s.temperature) for s in steps.values()], axis=0)
    residual = last.measured - last.temperature
    everywhere &= np.isfinite(residual)
    weeks = "test" if (case.test & everywhere).any() else "fitting"
    return (
        weeks,
        residual,
        everywhere & (case.test if weeks == "test" else case.fitting),
    )


def residual_by_scale(
    record: Record, residual: np.ndarray, rows: np.ndarray
) -> dict[str, float]:
    """Mean square of the residual on some rows, by time scale."""
    hours = record.index[rows].hour.to_numpy()
    times = record.inputs.seconds[rows], record.inputs.step
    return by_scale(residual[rows], record.dates[rows], hours, *times)


def rows_within(dates: np.ndarray, stretches: pd.DataFrame) -> np.ndarray:
    """Mask of the rows of some stretches of days."""
    held = np.zeros(len(dates), dtype=bool)
    for start, end in zip(stretches["start"], stretches["end"]):
        first, last = (np.datetime64(day, "D").astype(int) for day in (start, end))
        held |= (dates >= first) & (dates <= last)
    return held


def budget_table(rows: list) -> pd.DataFrame:
    """
    An error budget as a table.

    Parameters
    ----------
    rows : list of BudgetRow
        The first is the steady model.

    Returns
    -------
    DataFrame
        By ``part``: ``kind``, ``mean_square`` [K²], its root with its sign ``error``
        [K], its ``share`` of the first row [-], and ``weeks``.
    """
    table = pd.DataFrame(rows).set_index("part")
    square = table["mean_square"]
    error = np.sign(square) * np.sqrt(square.abs())
    return table.assign(error=error, share=square / square.iloc[0])[COLUMNS]


def budget_rows(table: pd.DataFrame) -> list:
    """
    The budget as rows of a file, without derived columns.

    Parameters
    ----------
    table : DataFrame
        From :func:`budget_table`.

    Returns
    -------
    list of dict
        See :class:`BudgetRow`.
    """
    return table[["kind", "mean_square", "weeks"]].reset_index().to_dict("records")
