"""False names of a loop in scrambled records, and the reliability of names."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import betaincinv, gammaincinv

from pvlib_fem._findings import Verdict
from pvlib_fem._former_names import fields_in_new_names
from pvlib_fem._loop.close import close_loop

CLEARLY = 1.5  # multiple of the predicted size from which nearly all should be found
ENDS = (0.05, 0.95)  # of intervals, as probabilities
COLUMNS = ("identified", "injections", "found", "completeness", "complete_from")
COLUMNS += ("complete_to", "trials", "false", "reliability", "reliable_from")
COLUMNS += ("reliable_to",)
COUNTS = ("injections", "found", "trials", "false")


@fields_in_new_names({"named": "identified", "classes": "ambiguous"})
@dataclass(frozen=True)
class Trial:
    """
    False findings of a loop on a record with moved drivers or scrambled dates.

    Attributes
    ----------
    kind : str
        ``"drivers"`` or ``"dates"``.
    number : int
        Number among the trials of its kind.
    what : str
        Description of the scrambling.
    lost : tuple of str
        Effects that the record has lost; their names are false.
    identified, ambiguous : tuple of str
        Lost effects that are identified; and ambiguous findings of which each
        candidate is lost.
    refused : str
        Why the loop refused the record; empty if it did not.
    """

    kind: str
    number: int
    what: str
    lost: tuple[str, ...]
    identified: tuple[str, ...] = ()
    ambiguous: tuple[str, ...] = ()
    refused: str = ""

    @property
    def key(self) -> tuple[str, int]:
        """Kind and number, which identify the trial."""
        return self.kind, self.number


def trial_of(scrambler: Any, how: dict, seed: int, kind: Any, number: Any) -> Any:
    """
    Scramble a record, close the loop, and count false names.

    Parameters
    ----------
    scrambler : Scrambler
        Of the record.
    how : dict
        Arguments of the loop; ``holdout`` is replaced by the scrambler's.
    seed : int
        Of the random numbers.
    kind : str
        ``"drivers"`` or ``"dates"``.
    number : int
        Number among the trials of its kind.

    Returns
    -------
    Trial
        ``refused`` if the loop raises a ValueError.
    """
    record, holdout, lost, what = scrambler.scrambled(kind, number, seed)
    done = (kind, number, what, tuple(sorted(lost)))
    try:
        loop = close_loop(record, **how | {"holdout": holdout})
    except ValueError as error:
        return Trial(*done, refused=str(error))
    return Trial(*done, *false_of(loop.finding_objects, lost))


def false_of(findings: Sequence, lost: Any) -> Any:
    """Identified effects that are lost, and ambiguous findings of lost ones only."""
    added = [f for f in findings if f.added and {*f.candidates} <= lost]
    names = tuple(f.effect for f in added if f.verdict is Verdict.IDENTIFIED)
    sets = [f.candidates for f in added if f.verdict is Verdict.AMBIGUOUS]
    return names, tuple(" | ".join(members) for members in sets)


def false_names(trials: Any) -> Any:
    """
    Mean number of false names per record, and its 90 % interval.

    Parameters
    ----------
    trials : sequence of Trial
        Of one record; those that the loop refused do not count.

    Returns
    -------
    mean : float
        Sum of the means of each kind of trial; NaN if a kind has no trial.
    interval : tuple of float
        Lower and upper end.
    """
    counts, rows = [], []
    for kind in dict.fromkeys(trial.kind for trial in trials):
        mine = [t for t in trials if t.kind == kind and not t.refused]
        counts.append(sum(len(trial.identified) for trial in mine))
        rows.append(len(mine))
    if not rows or not min(rows):
        return np.nan, (0.0, np.inf)
    mean = sum(count / total for count, total in zip(counts, rows))
    return mean, rate_between(sum(counts), min(rows))


def rates(outcomes: Any, trials: Any, baseline: tuple) -> Any:
    """
    Completeness and reliability by effect.

    Parameters
    ----------
    outcomes : sequence of Outcome
        Of injections; those of 1.5 times the predicted size and more count.
    trials : sequence of Trial
        Of scrambled records; those that the loop refused do not count.
    baseline : tuple of Finding
        Findings of the record itself.

    Returns
    -------
    pandas.DataFrame, shape (effects, 11)
        See :attr:`Recovery.reliability`.
    """
    sure = {f.effect for f in baseline if f.added and f.verdict is Verdict.IDENTIFIED}
    done = [trial for trial in trials if not trial.refused]
    lost = [name for trial in done for name in trial.lost]
    table = pd.DataFrame(columns=[*COLUMNS]).rename_axis("effect")
    for name in dict.fromkeys([*(o.injection.effect for o in outcomes), *lost]):
        clear = [
            one.found
            for one in outcomes
            if one.injection.effect == name and one.injection.multiple >= CLEARLY
        ]
        mine = [trial for trial in done if name in trial.lost]
        false = sum(name in trial.identified for trial in mine)
        right = len(mine) - false
        table.loc[name] = (
            name in sure,
            *share_with_ends(sum(clear), len(clear)),
            len(mine),
            false,
            *share_with_ends(right, len(mine))[2:],
        )
    kinds = dict.fromkeys(COLUMNS, float) | {"identified": bool}
    return table.astype(kinds | dict.fromkeys(COUNTS, int))


def share_with_ends(count: Any, total: Any) -> Any:
    """Number of trials, count, share, and the ends of its interval."""
    if not total:
        return 0, 0, np.nan, np.nan, np.nan
    return total, count, count / total, *share_between(count, total)


def share_between(count: int, of: int) -> tuple[float, float]:
    """
    Lower and upper end of the interval of a proportion, by Jeffreys' prior. [-]

    The lower end is 0 without a success, and the upper end is 1 without a failure
    (Brown, Cai and DasGupta, 2001, eq. 3.1.2, :doi:`10.1214/ss/1009213286`). With no
    trial the interval is 0 to 1.
    """
    rest = of - count
    ends = betaincinv(count + 0.5, rest + 0.5, ENDS)
    return float(ends[0]) if count else 0.0, float(ends[1]) if rest else 1.0


def rate_between(count: int, of: int) -> tuple[float, float]:
    """
    Lower and upper end of a mean count per record, by Jeffreys' prior. [1/record]

    The lower end is 0 for a count of 0; with no record the interval is 0 to infinity.
    """
    if not of:
        return 0.0, np.inf
    low, high = gammaincinv(count + 0.5, ENDS) / of
    return float(low) if count else 0.0, float(high)
