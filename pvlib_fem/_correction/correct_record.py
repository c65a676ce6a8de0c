"""A record and a loop of it, to the corrected record."""

from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._correction.corrected_record import CorrectedRecord
from pvlib_fem._correction.correction_steps import FLAGS, TIME, Work
from pvlib_fem._correction.faults import faults_to_correct
from pvlib_fem._correction.repairs import SOUND
from pvlib_fem._record.column_names import ORIGINAL, numeric, with_aliases
from pvlib_fem.quality._screen import labels_of


def corrected_record(
    loop: Any, data: pd.DataFrame, resolve: Any = ()
) -> CorrectedRecord:
    """
    A record without the instrument faults that a loop found in it.

    See :meth:`pvlib_fem.Loop.corrected`.

    Parameters
    ----------
    loop : Loop
    data : DataFrame
        The record of the loop, or a part of it, as it was measured.
    resolve : str, sequence of str, or dict of str, optional
        Causes of ambiguous findings.

    Returns
    -------
    CorrectedRecord

    Raises
    ------
    ValueError
        If no row is within the period of the loop's record, data are corrected already,
        a time comes twice, or ``resolve`` has no candidate of a finding.
    """
    columns, labels = with_aliases(data, ()), labels_of(data)
    own = [name for name in (FLAGS, TIME) if name in labels]
    own += [f"{n}{ORIGINAL}" for n in SOUND if f"{n}{ORIGINAL}" in labels]
    if own:
        raise ValueError(
            f"data have {own[0]}, as a record that is corrected already; give the "
            "record as it was measured"
        )
    faults = faults_to_correct(loop, resolve)
    inside = rows_inside(loop, data.index)
    work = Work(data.copy(), labels, numeric(columns), inside)
    work.clocks(loop)
    work.detachments(loop)
    work.units(loop)
    work.instruments(loop, faults)
    return work.done()


def rows_inside(loop: Any, index: pd.Index) -> np.ndarray:
    """Rows within the period of the loop's record; refuse where there is none."""
    if not isinstance(index, pd.DatetimeIndex):
        raise ValueError(
            f"the index of data is a {type(index).__name__}; give the times of the "
            "record as a DatetimeIndex"
        )
    if loop.times is None:
        return np.ones(len(index), dtype=bool)
    inside, times = loop.times.inside(index), loop.times
    if not inside.any():
        zone = times.zone or "without a zone"
        own = str(index.tz) if index.tz is not None else "without a zone"
        span = f"{index[0]} to {index[-1]}" if len(index) else "no rows"
        raise ValueError(
            f"data have no row within the record of this loop: they are {span} "
            f"({own}), and the record is {times.first} to {times.last} ({zone}); "
            "give that record or a part of it, in its zone"
        )
    return inside
