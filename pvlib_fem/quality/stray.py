"""Rows whose time is years from all others."""

import numpy as np


def refuse_stray(index, limits):
    """Refuse rows that are years from all others: their time is not theirs."""
    seconds = (index - index[0]).total_seconds().to_numpy()
    for at in np.flatnonzero(np.diff(seconds) > limits.stray_gap) + 1:
        early = at <= len(index) / 2
        rows = index[:at] if early else index[at:]
        if len(rows) > max(limits.stray_share * len(index), 1):
            continue
        years = (seconds[at] - seconds[at - 1]) / 31556952
        raise ValueError(
            f"{'the row' if len(rows) == 1 else f'{len(rows)} rows'} at {rows[0]} "
            f"{'is' if len(rows) == 1 else 'are'} {years:.0f} years "
            f"{'before' if early else 'after'} all others, which "
            f"{'begin' if early else 'end'} at {index[at] if early else index[at - 1]}:"
            " a logger that lost its clock; drop such rows, or correct their times"
        )
