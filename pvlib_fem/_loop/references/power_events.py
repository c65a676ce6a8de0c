"""What power and the module's temperature show together, hour by hour."""

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pvlib_fem._budget.covers_and_outages import Hours, event_table, events_in
from pvlib_fem._loop.references.comparisons import OF_MODULES, kind
from pvlib_fem._record.column_names import plant_power
from pvlib_fem._record.filters import frozen
from pvlib_fem._record.inputs import Inputs
from pvlib_fem._thermal.model import ThermalModel
from pvlib_fem.drivers import derive_drivers
from pvlib_fem.drivers._plant_irradiance import light_shown
from pvlib_fem.effects import find
from pvlib_fem.effects._effect import Effect
from pvlib_fem.power import fit_power_arrays
from pvlib_fem.scores import row_hours

if TYPE_CHECKING:
    from pvlib_fem._loop.regression.refits import Fits, Step

KINDS = ("modules_covered", "sensor_covered", "outage")
#: with the kind that no temperature follows
EVENTS = (*KINDS, "underperformance")
#: effects that follow power, and are no part of what events are looked for in
BY_POWER = (*KINDS, "electrical_output")
EXTRA = ("temp_air", "wind_speed", "snow_depth")


def events_of(fits: "Fits", step: "Step") -> pd.DataFrame:
    """
    Events that a plant's power shows, of all weeks; they decide nothing.

    Parameters
    ----------
    fits : Fits
    step : Step
        The last one.

    Returns
    -------
    DataFrame
    """
    case = fits.case
    powers = [*plant_power(case.whole, case.criteria.max_missing_share)]
    if not powers or not case.enough:
        return event_table([])
    record, model = fits.prepared(case.whole, step.model)
    (_, off) = find({"name": "outage", "source": powers[0]}).drivers
    inputs = model.with_base(record.inputs, ["temp_base", "loss_base"])
    inputs = derive_drivers(inputs, [off, "day"])
    given = [inputs[n] for n in ("poa_global", "temp_base", powers[0], "day")]
    given[0] = given[0] * true_over_read(step, model, inputs)
    try:
        relation = fit_power_arrays(*(column[case.fitting] for column in given))
    except ValueError:  # no power on the fitting weeks
        return event_table([])
    residual = step.measured - without_power(step, model, inputs)
    # no fit has the hours of frozen modules, but power shows whether they are covered
    rows = (case.seen | frozen(record.inputs.columns)) & np.isfinite(residual)
    total = float(residual[rows] @ residual[rows])
    counts = case.seen & rows  # in the error that the loop reports
    rows &= np.isfinite(given[1] + given[2])
    poa, module, power, day = given
    expected = relation.expected(poa, module, day)
    columns = {
        "residual": residual,
        "seen": poa,
        "shown": light_shown(relation, *given),
        "power": power,
        "expected": expected,
        "loss": inputs["loss_base"],
        "energy": (power - expected) / relation.nominal * row_hours(record.inputs),
        "portion": counts / max(int(counts.sum()), 1),
        "off": inputs[off],
    }
    there = {*record.inputs.columns} - {*record.absent}
    extra = {name: record[name] for name in EXTRA if name in there}
    hours = Hours.from_columns(record.index, rows, columns, extra)
    shares = {
        effect.name: step.coefficients[f"{effect.name}.share"]
        for effect in model.effects
        if effect.name in KINDS
    }
    return events_in(hours, relation.spread, total, shares)


def true_over_read(
    step: "Step", model: ThermalModel, inputs: Inputs
) -> np.ndarray | float:
    """Irradiance on the modules over what the sensor reads, by the model. [-]"""
    ratio: np.ndarray | float = 1.0
    for effect in model.effects:
        if kind(effect) in OF_MODULES:
            ratio = ratio * (1.0 + more_light(effect, inputs, step.coefficients))
    return ratio


def more_light(
    effect: Effect, inputs: Inputs, coefficients: dict[str, float]
) -> np.ndarray:
    """
    Share of light that the modules receive more than the sensor shows. [-]

    Parameters
    ----------
    effect : Effect
        Whose heat is that light.
    inputs : Inputs
        With the columns of its drivers.
    coefficients : dict
        Its own, perhaps with others.

    Returns
    -------
    array, shape (rows,)
        0 in the dark, and where a driver is missing, as in the model.
    """
    columns = derive_drivers(inputs, effect.drivers).columns
    heat, poa = effect.at(columns, coefficients).heat, inputs["poa_global"]
    share = np.divide(heat, poa, out=np.zeros(len(poa)), where=poa > 0.0)
    return np.nan_to_num(share)


def without_power(step: "Step", model: ThermalModel, inputs: Inputs) -> np.ndarray:
    """Temperature of a step without its effects that follow power. [°C]"""
    start: dict[str, float] = {}
    for effect in model.effects:
        if effect.name in BY_POWER:
            start |= effect.start
    if not start:
        return step.temperature
    temperature = model.temperature(inputs, {**step.coefficients, **start})
    return np.where(np.isnan(step.temperature), np.nan, temperature)
