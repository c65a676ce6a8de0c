"""The ranking of effects as a table that prints whole."""

from collections.abc import Iterator, Mapping
from typing import Any, TypedDict

import numpy as np
import pandas as pd

from pvlib_fem._converter import AnyFloat
from pvlib_fem._record.column_names import printable
from pvlib_fem._report.formatting import two_decimals, with_error


class RankingRow(TypedDict, total=False):
    """A row of the ranking in a file, without what is unknown."""

    gain: AnyFloat
    p_value: AnyFloat
    coefficients: dict[str, AnyFloat]
    stderr: dict[str, AnyFloat]
    physical: Any
    minimum_detectable: AnyFloat
    rows: Any
    ties: tuple[str, ...]
    note: Any


COLUMNS = [*RankingRow.__annotations__]
HEAD = ("effect", "#gain [K]", "#seen from [K]", "#chance", "what it would take", "")


class Ranking(pd.DataFrame):
    """A DataFrame of the columns above that prints all it says, whatever its width."""

    @property
    def _constructor(self) -> type[pd.DataFrame]:
        return pd.DataFrame

    def lines(self) -> Iterator[tuple[str, str, str, str, str, str]]:
        """Cells of the printed table, a row for each effect."""
        for name, row in self.iterrows():
            ties = row["ties"] if isinstance(row["ties"], tuple) else ()
            words = [f"or {' or '.join(ties)}"] if ties else []
            if isinstance(row["note"], str) and row["note"]:
                words.append(row["note"])
            chance = row["p_value"]
            yield (
                str(name),
                two_decimals(row["gain"]),
                two_decimals(row["minimum_detectable"]),
                f"{chance:.1g}" if np.isfinite(chance) else "–",
                coefficients_text(str(name), row["coefficients"], row["stderr"]),
                "; ".join(words),
            )

    def __repr__(self) -> str:
        if list(self.columns) != COLUMNS:
            return pd.DataFrame.__repr__(self)
        head = [name.removeprefix("#") for name in HEAD]
        rows = [head, *([printable(cell) for cell in row] for row in self.lines())]
        wide = [max(map(len, column)) for column in zip(*rows)]
        right = [name.startswith("#") for name in HEAD]
        return "\n".join(
            "  ".join(
                cell.rjust(size) if to_right else cell.ljust(size)
                for cell, size, to_right in zip(row, wide, right)
            ).rstrip()
            for row in rows
        )

    def _repr_html_(self) -> str:
        if list(self.columns) != COLUMNS:
            return pd.DataFrame._repr_html_(self)  # type: ignore[attr-defined]
        from pvlib_fem._report.document import fragment, table

        return fragment([table(HEAD, self.lines())])


def coefficients_text(effect: str, values: Any, errors: Any) -> str:
    """Coefficients of an effect in one line."""
    if not isinstance(values, dict):
        return ""
    return ", ".join(
        f"{name.removeprefix(f'{effect}.')} {with_error(value, errors[name])}"
        for name, value in values.items()
    )


def table_of(rows: Mapping[str, Mapping[str, Any]]) -> Ranking:
    """
    The ranking of dicts by effect, in their order.

    Parameters
    ----------
    rows : dict of dict
        By the name of the effect, the columns that are known.

    Returns
    -------
    Ranking
    """
    frame = pd.DataFrame.from_dict({**rows}, orient="index")
    return Ranking(frame.reindex(index=list(rows), columns=COLUMNS))


def ranking_rows(ranking: pd.DataFrame) -> dict[str, dict[str, Any]]:
    """
    The ranking for a file, without what is not known.

    Parameters
    ----------
    ranking : DataFrame
        Ranking, indexed by the name of the effect.

    Returns
    -------
    dict of dict
        By the name of the effect, the columns that are not NaN.
    """
    return {
        name: {
            key: value
            for key, value in row.items()
            if not (isinstance(value, float) and np.isnan(value))
        }
        for name, row in ranking.to_dict(orient="index").items()
    }
