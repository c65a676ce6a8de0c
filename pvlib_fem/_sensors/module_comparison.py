"""The result of a comparison of module sensors."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._fitting.fem_fit import FemFit
from pvlib_fem._record.column_names import printable

HEAD = ("sensor", "share", "offset", "own step", "RMSE (fit)", "common", "own")


@dataclass(frozen=True, eq=False)
class ModuleComparison:
    """
    Errors that several module sensors have in common, and errors of each.

    ``print(comparison)`` is the table with conclusions.

    Attributes
    ----------
    table : DataFrame
        A row for each sensor:

        ``share``: its over-temperature in sun over that of the others, before its
        step if it has one [-];
        ``offset``: its excess at zero over-temperature [K];
        ``spread``: residual of share and offset, root mean square in sun [K];
        ``step``: date of a step of its share, "" without one;
        ``change``, ``stderr``: size of the step, relative to its share [-];
        ``left``: RMSE of its own fit in sun [K];
        ``common``: RMS of the median residual of the other fits, or of the mean of
        both fits with two sensors [K];
        ``own``: RMS of its residual minus that median or mean [K];
        ``rows``: number of its values;
        ``used``: whether it was compared with the others;
        ``note``: why not, or which of its values were not used.
    fits : dict of FemFit
        Fits of the sensors that are used, by name.
    common : DataFrame
        The record for :func:`close_loop`. Its ``temp_module`` is the mean of the used
        sensors without their own steps, on rows that all have. With two sensors, a step
        of one is in the mean.
    """

    table: pd.DataFrame
    fits: Mapping[str, FemFit] = field(repr=False)
    common: pd.DataFrame = field(repr=False)

    def __str__(self) -> str:
        return printable("\n".join(printout_lines(self)), "\n")

    def _repr_html_(self) -> str:
        return self.table.to_html(float_format="{:.3f}".format, na_rep="–")


def printout_lines(comparison: ModuleComparison) -> Iterator[str]:
    """Yield the lines of the printout."""
    table = comparison.table
    used = table[table["used"]]
    pair = len(used) == 2
    others = "the other" if pair else "the median of the others"
    yield f"{len(used)} module sensors, each compared with {others}; in sun [K]"
    yield ""
    rows = [HEAD, *(row_cells(row) for row in table.itertuples())]
    wide = [max(map(len, column)) for column in zip(*rows)]
    for first, *others in rows:
        words = [first.ljust(wide[0])]
        words += [cell.rjust(size) for cell, size in zip(others, wide[1:])]
        yield "  ".join(words).rstrip()
    yield ""
    row: Any
    for row in table.itertuples():
        if row.step:
            way = "more" if row.change > 0 else "less"
            size = f"{abs(100 * row.change):.1f} ± {100 * row.stderr:.2g} %"
            alone = "compared with the other" if pair else "alone"
            one = "one of both sensors" if pair else "the sensor"
            yield (
                f"{row.Index} {alone} reads {size} {way} over-temperature from "
                f"{row.step} on: {one} or its module changed"
            )
        elif row.used and row.own > row.common:
            own = f"{row.own:.2f} K"
            yield f"{row.Index}: most of the error of its fit, {own}, is its own"
    rmse, common = used["left"].median(), used["common"].median()
    if np.isfinite(common):
        yield (
            f"median RMSE of a fit: {rmse:.2f} K; of the error common to all: "
            f"{common:.2f} K (weather station, plant or model)"
        )
    for row in table.itertuples():
        if row.note:
            note = row.note.removeprefix(f"{row.Index} ")
            yield f"{row.Index}: {note}" + ("" if row.used else " (not used)")


def row_cells(row: Any) -> tuple[str, ...]:
    """Cells of a sensor's row of the printout."""
    step = f"{row.change:+.1%} from {row.step}" if row.step else "–"
    errors = (number_text(value, ".2f") for value in (row.left, row.common, row.own))
    return (
        row.Index,
        number_text(row.share, ".3f"),
        number_text(row.offset, "+.2f"),
        step,
        *errors,
    )


def number_text(value: float, form: str) -> str:
    return format(value, form) if np.isfinite(value) else "–"
