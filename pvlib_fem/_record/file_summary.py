"""What a report says of a record, which can do without its rows."""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
import pandas as pd

from pvlib_fem._converter import AnyFloat
from pvlib_fem._record.checks import instants, usual_step
from pvlib_fem._record.column_names import GEOMETRY
from pvlib_fem._record.inputs import Columns, Record

Rows = TypeVar("Rows")


@dataclass(frozen=True)
class Summary:
    """
    Size, times and gaps of a record.

    Attributes
    ----------
    rows, days : int
    start, end : Timestamp
    step : float
        Median one. [s]
    columns : tuple of str
        All that it has, those of the sun's place included.
    missing, impossible : dict of int
        Values by column that are missing, or were not used.
    clipped : int
        Rows of negative irradiance, set to 0.
    sha256 : str
        Of its times and measured columns, see :func:`digest`.
    """

    rows: int
    days: int
    start: pd.Timestamp
    end: pd.Timestamp
    step: AnyFloat
    columns: tuple[str, ...]
    missing: dict[str, int]
    impossible: dict[str, int]
    clipped: int
    sha256: str

    @property
    def measured(self) -> list[str]:
        """Names of the record's own columns, in order."""
        return measured_names(self.missing, self.columns)


def present(rows: Rows | None) -> Rows:
    """
    Rows of a result: its record, residual or the like.

    Parameters
    ----------
    rows : object or None
        None in a result that was read from a file.

    Returns
    -------
    object
        ``rows``, which is not None.

    Raises
    ------
    ValueError
        If there are none, since the result was read from a file.
    """
    if rows is None:
        raise ValueError(
            "a result that was read from a file has no rows to plot; compute it again"
        )
    return rows


def summary_of(record: Any) -> Summary:
    """
    Size, times, gaps and hash of a record.

    Parameters
    ----------
    record : Record
        With at least one row.

    Returns
    -------
    Summary
    """
    return Summary(
        rows=len(record.index),
        days=len(np.unique(record.dates)),
        start=record.index[0],
        end=record.index[-1],
        step=usual_step(record.index),
        columns=tuple(n for n in record.inputs.columns if n not in record.absent),
        missing=dict(record.missing),
        impossible=dict(record.impossible),
        clipped=record.clipped,
        sha256=digest(record),
    )


def measured_names(missing: dict, columns: tuple | Columns) -> list[str]:
    return [n for n in missing if n in columns and n not in GEOMETRY]


def digest(record: Record) -> str:
    """
    Sha256 of a record's times and values, whatever the computer.

    Parameters
    ----------
    record : Record

    Returns
    -------
    str
    """
    names = measured_names(record.missing, record.inputs.columns)
    return digest_of(names, lambda names: [record.only(names)])


def digest_of(names: Sequence, blocks: Callable) -> str:
    """
    Sha256 of the times and values of a record in blocks.

    Parameters
    ----------
    names : sequence of str
        Columns, in the order in which they are hashed; those of :data:`GEOMETRY` are
        not, since they are computed.
    blocks : callable
        Of a tuple of names, the blocks of these columns from the first on: each with
        ``index``, and values by name. It is called once for the times, with no name,
        and once for each column.

    Returns
    -------
    str
        64 hexadecimal digits, independent of the size of the blocks.
    """
    sha256 = hashlib.sha256()
    for block in blocks(()):
        sha256.update(instants(block.index).astype("M8[ns]").astype("<i8").tobytes())
    for name in names:
        if name in GEOMETRY:
            continue
        sha256.update(name.encode("utf-8", "surrogatepass"))
        for block in blocks((name,)):
            values = np.asarray(block[name], dtype="<f8")
            # one NaN, and one zero
            values = np.where(np.isnan(values), np.nan, values + 0.0)
            sha256.update(values.astype("<f8").tobytes())
    return sha256.hexdigest()
