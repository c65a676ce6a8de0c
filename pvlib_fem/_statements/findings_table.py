"""The findings of a loop as a DataFrame."""

from numbers import Integral
from typing import TYPE_CHECKING, Any

import pandas as pd

from pvlib_fem._findings import Kind
from pvlib_fem._statements.make import finding_statement, pattern_statement

if TYPE_CHECKING:
    from pvlib_fem._loop.results.loop_result import Loop

#: column of the table, and the field of the statement that it has
FIELDS = {
    "effect": "cause",
    "verdict": "verdict",
    "probability": "probability",
    "alternatives": "alternatives",
    "value": "value",
    "standard_error": "error",
    "low": "low",
    "high": "high",
    "unit": "unit",
    "from": "since",
    "to": "until",
    "gain": "gain",
}
DATES = ("from", "to")
NUMBERS = ("probability", "value", "standard_error", "low", "high", "gain")


class Findings(pd.DataFrame):
    """A DataFrame that says where the objects are that stood in its place before."""

    @property
    def _constructor(self) -> Any:
        return pd.DataFrame

    def __getitem__(self, key: Any) -> Any:
        try:
            return super().__getitem__(key)
        except KeyError as error:
            if not isinstance(key, Integral):
                raise
            raise KeyError(
                f"loop.findings is a DataFrame: row {key} is loop.findings.iloc[{key}],"
                f" and its Finding object is loop.finding_objects[{key}]"
            ) from error


def findings_table(loop: "Loop") -> Findings:
    """
    A row for each of ``loop.finding_objects``, in their order.

    Parameters
    ----------
    loop : Loop

    Returns
    -------
    Findings
        With the columns of :data:`FIELDS`.
    """
    statements = [
        pattern_statement(one, loop)
        if one.kind is Kind.STRUCTURE
        else finding_statement(one, loop)
        for one in loop.finding_objects
    ]
    rows = [[getattr(one, name) for name in FIELDS.values()] for one in statements]
    table = pd.DataFrame(rows, columns=[*FIELDS]).rename_axis("finding")
    for name in DATES:
        dates = pd.to_datetime(table[name], format="%Y-%m-%d")
        table[name] = dates.astype("datetime64[ns]")
    return Findings(table.astype(dict.fromkeys(NUMBERS, float)))
