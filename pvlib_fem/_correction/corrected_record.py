"""A corrected record: finished, and it prints itself."""

from dataclasses import dataclass, field

import pandas as pd

from pvlib_fem._record.column_names import printable


@dataclass(frozen=True, eq=False)
class CorrectedRecord:
    """
    A record without faults of its instruments; ``print(corrected)`` says what was done.

    Attributes
    ----------
    data : DataFrame
        The record. A corrected column keeps its name, and the measured one is
        ``<name>_original``. ``corrected`` has the causes by which a
        row is corrected, "" where by none. Where clocks are corrected, the index has
        the corrected times and ``time_original`` those of the file.
    actions : DataFrame
        A row for each cause and column:

        ``cause``: name of the effect, of the fault of a clock, or ``unit``;
        ``column``: ``all`` where it is the clock of the file;
        ``applied``: whether the column was corrected;
        ``start``, ``end``: from when to when, ``YYYY-MM-DD`` or a time of the file. A
        trend is 0 at its ``start``, unless its words have an earlier day;
        ``size``: what is added to the reading, as a share of it or in K; of a clock
        the minutes that are added to times, of a unit the factor;
        ``stderr``: its standard error;
        ``low``, ``high``: its 90 % range, with the error of the model;
        ``unit``: of these four;
        ``rows``: how many rows it changes;
        ``words``: the same in a sentence, or why it is not applied.
    """

    data: pd.DataFrame = field(repr=False)
    actions: pd.DataFrame

    def __str__(self) -> str:
        lines = [*self.actions["words"]] or ["Nothing is corrected."]
        return printable("\n".join(lines), "\n")

    def _repr_html_(self) -> str:
        return self.actions.to_html(na_rep="–", index=False)
