"""Effects by a plant's power: one form for DC power, and one for AC power."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from pvlib_fem._record.column_names import PLANT_POWER, kind_of_power
from pvlib_fem._record.inputs import Columns
from pvlib_fem.drivers import Driver, constants
from pvlib_fem.effects._effect import Effect
from pvlib_fem.power import PowerRelation, fit_power_arrays

USED = ("poa_global", "temp_base")


def by_power(effect: Any, *columns: Any) -> Any:
    """
    The forms of an effect by the available column of power, the best first.

    Parameters
    ----------
    effect : Effect
    *columns : str
        Its drivers; names of drivers by power are without the kind of power.

    Returns
    -------
    tuple of Effect
        Each takes the relation of power to irradiance from the loop's record.
    """
    return tuple(power_variant(effect, power, columns) for power in PLANT_POWER)


def power_variant(effect: Any, power: Any, columns: Any) -> Any:
    """The form of one column of power."""
    kind = kind_of_power(power)
    names = tuple(n if n in USED else f"{n}{kind}" for n in columns)
    variant = replace(
        effect, columns=names, source=power, settings={"source": power}, variants=()
    )
    return replace(
        variant,
        make=partial(of_relation, variant),
        prepare=partial(of_record, variant),
    )


def of_relation(effect: Effect, relation: PowerRelation | None = None) -> Effect:
    """The effect with a known relation of :mod:`pvlib_fem.power`."""
    if relation is None:
        return effect
    if not isinstance(relation, PowerRelation):
        relation = PowerRelation.stored(relation)
    given = {"relation": relation, "scale": relation.usual}
    drivers = []
    for name in effect.drivers:
        taken = {k: v for k, v in given.items() if k in constants(name)}
        drivers.append(Driver(name, **taken) if taken else name)
    return replace(
        effect,
        columns=tuple(drivers),
        settings={"source": effect.source, "relation": relation.content()},
        prepare=None,
        make=partial(of_relation, effect),
    )


def of_record(effect: Any, columns: Columns, rows: np.ndarray) -> Effect:
    """The effect by the relation of a record's own rows."""
    used = [columns[name][rows] for name in (*USED, effect.source, "day")]
    return of_relation(effect, fit_power_arrays(*used))
