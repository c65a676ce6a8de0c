"""The result of a comparison of module sensors: finished, and it prints itself."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from pvlib_fem.fitting.result import FemFit
from pvlib_fem.record.columns import printable

HEAD = ("sensor", "share", "offset", "own step", "fit leaves", "common", "own")


@dataclass(frozen=True, eq=False)
class ModuleComparison:
    """
    What several module sensors have in common, and each of its own.

    ``print(comparison)`` is the table, and what it says.

    Attributes
    ----------
    table : DataFrame
        A row for each sensor:

        ``share``: its over-temperature in sun over that of the others, before its
        step if it has one [-];
        ``offset``: what it reads more at no over-temperature [K];
        ``spread``: what is left beside both, root mean square in sun [K];
        ``step``: date from which its share is another, "" where none is found;
        ``change``, ``stderr``: by how much, as a share [-];
        ``left``: what its own fit leaves, root mean square in sun [K];
        ``common``: the part of it that the others' fits leave, too, their median, and
        of two sensors the mean of both [K];
        ``own``: the rest [K];
        ``rows``: number of its values;
        ``used``: whether it counts among the others;
        ``note``: why not, or what of it was left out.
    fits : dict of FemFit
        By sensor, of those that are used.
    common : DataFrame
        The record with what they have in common as ``temp_module``: the mean of those
        that are used, each as it was before its own step, where all are there. It is
        for :func:`close_loop`. A step of either of two sensors stays in their mean.
    """

    table: pd.DataFrame
    fits: Mapping[str, FemFit] = field(repr=False)
    common: pd.DataFrame = field(repr=False)

    def __str__(self):
        return printable("\n".join(lines(self)), "\n")

    def _repr_html_(self):
        return self.table.to_html(float_format="{:.3f}".format, na_rep="–")


def lines(comparison):
    """The printout, line by line."""
    table = comparison.table
    used = table[table["used"]]
    pair = len(used) == 2
    others = "the other" if pair else "the median of the others"
    yield f"{len(used)} module sensors, each beside {others}; in sun [K]"
    yield ""
    rows = [HEAD, *(cells(row) for row in table.itertuples())]
    wide = [max(map(len, column)) for column in zip(*rows)]
    for first, *others in rows:
        words = [first.ljust(wide[0])]
        words += [cell.rjust(size) for cell, size in zip(others, wide[1:])]
        yield "  ".join(words).rstrip()
    yield ""
    for row in table.itertuples():
        if row.step:
            way = "more" if row.change > 0 else "less"
            size = f"{abs(100 * row.change):.1f} ± {100 * row.stderr:.2g} %"
            alone = "beside the other" if pair else "alone"
            one = "one of both, or its module" if pair else "the sensor or its module"
            yield (
                f"{row.Index} {alone}: {size} {way} over the air from {row.step} on, "
                f"{one}"
            )
        elif row.used and row.own > row.common:
            yield (
                f"{row.Index}: most of what its fit leaves, {row.own:.2f} K, is its own"
            )
    left, common = used["left"].median(), used["common"].median()
    if np.isfinite(common):
        yield (
            f"{common:.2f} K of {left:.2f} K that a fit leaves (median) are common to "
            "all: weather station, plant or model"
        )
    for row in table.itertuples():
        if row.note:
            yield f"{row.Index}: {row.note}" + ("" if row.used else " (not used)")


def cells(row):
    """A sensor's row of the printout."""
    step = f"{row.change:+.1%} from {row.step}" if row.step else "–"
    left = (shown(value, ".2f") for value in (row.left, row.common, row.own))
    return row.Index, shown(row.share, ".3f"), shown(row.offset, "+.2f"), step, *left


def shown(value, form):
    return format(value, form) if np.isfinite(value) else "–"
