"""The effects that can be tested on a record, and user columns as effects."""

from collections.abc import Iterable, Sequence
from typing import Any

import pandas as pd

from pvlib_fem.drivers import needed_for, underived
from pvlib_fem.effects import EFFECTS, find, several
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._user_column import of_column
from pvlib_fem.reasons import Because, Reason, because, joined_reasons

MOST_HEAT = 500.0  # W/m² for one standard deviation of a user's own column
#: arguments that a user gives instead of these columns
SUN = {"solar_zenith": "location", "solar_azimuth": "location"}


def candidates(
    drivers: dict,
    refused: dict,
    effects: Any,
    there: Iterable = (),
    absent: Sequence = (),
) -> tuple[list, dict]:
    """
    Effects whose drivers are there, and for other effects the reasons they are not.

    Parameters
    ----------
    drivers : dict of Series
        Columns of the record by name; with ``effects=None`` without the usual three.
    refused : dict of Because
        Reasons by name of columns that are there but cannot be used.
    effects : str, mapping, Effect, sequence of these, or None
        Effects to try; None for the catalogue and every column that it does not use.
    there : collection of str, optional
        Names of effects that are in the model already, and are not tried.
    absent : sequence of str, optional
        Usual columns that were not measured.

    Returns
    -------
    testable : list of Effect
        Of each effect the best variant whose columns are there.
    notes : dict of Because
        Reasons by name of the other effects.
    """
    if effects is None:
        known = {n for e in EFFECTS.values() for n in measured_for(e)}
        own = [driver(n, column) for n, column in drivers.items() if n not in known]
        wanted = [*EFFECTS, *own]
    else:
        wanted = several(effects)
    testable, notes = [], {}
    for choice in wanted:
        effect = find(choice)
        if effect.name in there:
            continue
        for variant in effect.forms:  # the best variant with all columns
            if not missing_columns(variant, drivers, absent):
                testable.append(variant)
                break
        else:
            notes[effect.name] = why_not(effect, drivers, refused, absent)
    return testable, notes


def about_axis(effects: list, axis_azimuth: Any) -> list:
    """
    Effects of a plane that turns about an axis with this azimuth.

    Parameters
    ----------
    effects : list of Effect
    axis_azimuth : float or None
        Clockwise from north; None for a plane that does not turn. [°]

    Returns
    -------
    list of Effect
        An effect that has an ``axis_azimuth`` of its own keeps it.
    """
    if axis_azimuth is None:
        return [*effects]
    return [
        effect.made(axis_azimuth=axis_azimuth)
        if "axis_azimuth" in effect.constants and "axis_azimuth" not in effect.settings
        else effect
        for effect in effects
    ]


def candidates_about_axis(effects: list, axis_azimuth: Any) -> tuple[list, dict]:
    """
    Effects about an axis, as :func:`about_axis` has them, and of others why not.

    A plane that is fixed, or turns about no single axis, has none that turn.

    Parameters
    ----------
    effects : list of Effect
    axis_azimuth : float or None
        Clockwise from north; None for a plane that turns about no single axis. [°]

    Returns
    -------
    kept : list of Effect
    notes : dict of Because
        Reasons by name of the other effects.
    """
    none = axis_azimuth is None
    notes = {e.name: because(Reason.NO_AXIS) for e in effects if none and e.turns}
    kept = [effect for effect in effects if effect.name not in notes]
    return about_axis(kept, axis_azimuth), notes


def missing_columns(effect: Effect, drivers: dict, absent: Any) -> list[str]:
    """Columns that an effect needs and a record does not have."""
    usual = [name for name in underived(effect.drivers) if name in absent]
    return usual + [n for n in needed_for(effect.drivers) if n not in drivers]


def why_not(effect: Effect, drivers: dict, refused: dict, absent: Any) -> Because:
    """Why an effect cannot be tested."""
    missing = missing_columns(effect, drivers, absent)
    why = list(dict.fromkeys(refused[name] for name in missing if name in refused))
    # one column of several is enough if each form needs one of its own
    forms = [
        [n for n in needed_for(f.drivers) if n not in drivers] for f in effect.forms
    ]
    if not why and len(forms) > 1 and all(len(form) == 1 for form in forms):
        columns = list(dict.fromkeys(name for (name,) in forms))
        return because(Reason.LACKS_ALL, columns=columns)
    if none := sorted({SUN.get(n, n) for n in missing if n not in refused}):
        why.append(because(Reason.LACKS, columns=none))
    return joined_reasons(why)


def measured_for(effect: Effect) -> list[str]:
    """Columns that any variant of an effect needs."""
    return [n for variant in effect.forms for n in needed_for(variant.drivers)]


def driver(name: str, column: pd.Series) -> Effect:
    """A user's column as an effect: heat proportional to it."""
    return of_column(name, float(column.mean()), MOST_HEAT / float(column.std()))
