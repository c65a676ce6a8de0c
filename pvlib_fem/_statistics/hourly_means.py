"""Cells of an hour, and means of columns in them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np

from pvlib_fem._record.column_names import ANGLES
from pvlib_fem._record.inputs import Record


@dataclass(frozen=True, eq=False)
class Hours:
    """
    Cells of an hour.

    Attributes
    ----------
    first : ndarray of int
        First of the rows of each cell.
    count : ndarray
        Number of these rows.
    """

    first: np.ndarray
    count: np.ndarray

    @classmethod
    def from_record(cls, record: Record, rows: np.ndarray) -> Self:
        """Cells of some rows of a record."""
        key = record.dates[rows] * 24 + np.asarray(record.index[rows].hour)
        first = np.flatnonzero(np.diff(key, prepend=key[:1] - 1))
        return cls(first, np.diff(first, append=len(key)).astype(float))

    def means(self, column: np.ndarray) -> np.ndarray:
        """Mean of the known values of a column in each cell; NaN where none is."""
        sums, count = np.add.reduceat(column, self.first), self.count
        if np.isnan(sums).any():
            known = ~np.isnan(column)
            sums = np.add.reduceat(np.where(known, column, 0.0), self.first)
            count = np.add.reduceat(known, self.first, dtype=float)
            sums[count == 0.0] = np.nan
        return sums / np.maximum(count, 1.0)

    def means_of_drivers(
        self, columns: Mapping[str, np.ndarray]
    ) -> dict[str, np.ndarray]:
        """Mean of each driver in each cell, of directions as that of vectors."""
        means = {}
        for name, column in columns.items():
            if name in ANGLES:
                turned = np.radians(column)
                east, north = self.means(np.sin(turned)), self.means(np.cos(turned))
                means[name] = np.degrees(np.arctan2(east, north)) % 360.0
            else:
                means[name] = self.means(column)
        return means
