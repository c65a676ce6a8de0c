"""Changes by which a second sensor or power deviates from an instrument."""

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from pvlib_fem._loop.criteria import TINY, Criteria
from pvlib_fem._loop.references.deviations import DailyDeviation
from pvlib_fem._loop.regression.design import Design
from pvlib_fem._loop.selection.choice import ShownChange
from pvlib_fem._loop.selection.single_effects import Selection
from pvlib_fem._record.column_names import is_power, twin_of
from pvlib_fem.effects import CHANGES


def with_own(
    references: Iterable[DailyDeviation], criteria: Criteria
) -> list[tuple[DailyDeviation, dict[str, ShownChange]]]:
    """
    Each reference with the changes that it shows, given those that any of them shows.

    Parameters
    ----------
    references : iterable of DailyDeviation
    criteria : Criteria
        Of the loop.

    Returns
    -------
    list of (DailyDeviation, dict of ShownChange)
        Changes by name.
    """
    pairs = [(one, shown_by(one, criteria)) for one in references]
    all_shown = with_best_odds(shown for _, shown in pairs).values()
    effects = [change.effect for change in all_shown]
    return [
        (replace(one, own=tuple(filter(one.concerns, effects))), shown)
        for one, shown in pairs
    ]


def shown_by(reference: DailyDeviation, criteria: Criteria) -> dict[str, ShownChange]:
    """
    Changes by which a second sensor or power deviates from an instrument, with dates.

    They are selected as those of the module temperature, from the daily deviation of
    the two. The temperature decides which of the two has changed. The odds of a second
    sensor are even. A plant's power also changes by its modules and inverters, so that
    the odds are those of any effect.

    Parameters
    ----------
    reference : DailyDeviation
    criteria : Criteria
        Of the loop. A change of any size counts.

    Returns
    -------
    dict of ShownChange
        By name.
    """
    if twin_of(reference.column) is not None:
        odds = 0.0
    elif is_power(reference.column):
        odds = float(np.log(criteria.prior_odds))
    else:
        return {}
    faults, days = reference.comparison.shows, reference.days
    changing = [e for e in CHANGES.values() if e.sensor_fault in faults]
    always = np.ones(len(days))
    # in another plane, a second sensor of light differs with the season
    columns = enumerate([always, *reference.year(least=1)])
    usual = {str(i): column for i, column in columns}
    design = Design.of_columns(reference.apart, usual, always, days, changing)
    # outliers were left out, and compared with its noise a change would be one
    design = replace(design, outliers=False)
    limits = replace(criteria, min_rmse_reduction=TINY, min_error_share=TINY)
    effects = [choice.top.effect for choice in Selection(design, limits).run()]
    return {effect.name: ShownChange(effect, odds) for effect in effects}


def with_best_odds(
    shown: Iterable[Mapping[str, ShownChange]],
) -> dict[str, ShownChange]:
    """
    Changes that several references show, each with the best of its odds.

    Parameters
    ----------
    shown : iterable of dict of ShownChange
        By name, of each reference.

    Returns
    -------
    dict of ShownChange
        Of the same odds the first.
    """
    best: dict[str, ShownChange] = {}
    for some in shown:
        for name, change in some.items():
            if name not in best or change.log_odds > best[name].log_odds:
                best[name] = change
    return best
