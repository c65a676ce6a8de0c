"""
Add an effect to a measured record.

A physical effect, or a fault at the module, changes the module temperature by the
response of the record's own model; other light on the modules changes power, too. A
fault of another sensor changes the column of that sensor, so second sensors, the sky
and the weather deviate from it as they would. Dirt is on the modules or on the sensor,
by its sign.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._loop.references.power_events import more_light
from pvlib_fem._record.column_names import is_power
from pvlib_fem._record.inputs import Record
from pvlib_fem._recovery.draw import Injection
from pvlib_fem._thermal.model import ThermalModel
from pvlib_fem.drivers import derive_drivers, needed_for
from pvlib_fem.effects import EFFECTS, find
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._instruments import TURNS_FROM
from pvlib_fem.effects._time_profiles import weights_of
from pvlib_fem.quality._lag import retimed
from pvlib_fem.quality._module_lag import Clock
from pvlib_fem.quality._screen import labels_of


@dataclass(frozen=True, eq=False)
class Injector:
    """A record with the model of its loop, to which effects can be added."""

    model: ThermalModel
    coefficients: dict
    record: Record  # checked, in one standard time
    kept: np.ndarray  # rows of the user's frame that the record has
    clock: Clock  # of the module's logger
    own: dict  # the user's own effects, by name

    @classmethod
    def from_loop(cls, search: Any, loop: Any) -> "Injector":
        """The injector of a finished search."""
        case = search.case
        own = {e.name: e for e in case.wanted if e.name not in EFFECTS}
        model, coefficients = loop.fit.thermal_model, loop.fit.coefficients
        return cls(
            replace(model, base=model.base or coefficients),
            coefficients,
            loop.fit.record,
            case.kept,
            search.clock,
            own,
        )

    def effect(self, injection: Injection) -> Effect:
        """The effect of an injection, with its dates."""
        name = injection.effect
        return self.own.get(name) or find({"name": name, **injection.settings})

    def response(self, injection: Injection) -> np.ndarray:
        """Response of the module temperature to an injection. [K]"""
        effect = self.effect(injection)
        record = self.record
        if effect.prepare:
            there = replace(self.model, effects=(effect,)).with_drivers(record.inputs)
            rows = np.ones(len(record.index), dtype=bool)
            there = derive_drivers(there, ["day"])
            effect = effect.prepare(there.columns, rows)
        model = replace(self.model, effects=(*self.model.effects, effect))
        parts = (injection.coefficients, effect.start)
        return self.added(model, effect.drivers, *parts)

    def more_light(self, effect: Effect, coefficients: dict) -> np.ndarray:
        """Share of light that the modules receive more than the sensor shows. [-]"""
        if effect.sensor_fault:
            (change,) = coefficients.values()
            return change * weights_of(effect, self.record.dates)
        return more_light(effect, self.record.inputs, coefficients)

    def more_power(self, more: np.ndarray) -> dict[str, np.ndarray]:
        """What power gets of more light on the modules, by its column."""
        names = filter(is_power, self.record.inputs.columns)
        return {name: np.nan_to_num(more * self.record[name]) for name in names}

    def own_changes(self) -> Any:
        """Module temperature that the record's own faults add. [K]"""
        changes = [effect for effect in self.model.effects if effect.sensor_fault]
        drivers = [name for one in self.model.effects for name in one.drivers]
        start = {name: value for one in changes for name, value in one.start.items()}
        return self.added(self.model, drivers, {}, start)

    def added(
        self, model: ThermalModel, drivers: Sequence, there: dict, absent: dict
    ) -> np.ndarray:
        """Difference of a model's temperature between two sets of coefficients. [K]"""
        record = self.record
        # gaps of drivers take the next value, as in the test of a candidate
        filled = {
            name: pd.Series(record[name]).bfill().ffill().to_numpy()
            for name in needed_for(drivers)
            if name in record.inputs.columns
        }
        inputs = model.with_drivers(record.having(filled).inputs)
        with_it, without = (
            model.temperature(inputs, {**self.coefficients, **part})
            for part in (there, absent)
        )
        change = np.nan_to_num(with_it - without)
        if self.clock.fault:
            seconds = record.inputs.seconds
            change = np.nan_to_num(
                retimed(seconds, change, -self.clock.late_at(seconds))
            )
        return change

    def into(self, data: pd.DataFrame, injection: Injection) -> pd.DataFrame:
        """A copy of a frame with the effect added."""
        data, effect = data.copy(), self.effect(injection)
        labels = labels_of(data)
        name, sizes = READS.get(effect.sensor_fault), injection.coefficients
        if effect.loses_light and max(sizes.values()) > 0.0:  # of the sensor
            poa, more = self.record["poa_global"], self.more_light(effect, sizes)
            change = {"poa_global": np.nan_to_num(poa / (1.0 + more) - poa)}
        elif name is None:
            change = {"temp_module": self.response(injection)}
            if effect.loses_light or effect.sensor_fault == "module_irradiance":
                change |= self.more_power(self.more_light(effect, sizes))
        else:
            (size,) = sizes.values()
            read = faulty_reading(self.record, effect, size, self.coefficients)
            change = {
                name: np.nan_to_num(values - self.record[name])
                for name, values in read.items()
            }
        for name, values in change.items():
            add_to_rows(data, labels[name], self.kept, values)
        return data


MOST_LOST = 0.9  # largest share of a reading that a fault removes
#: columns of the sensors other than the module's, by sensor fault
READS = {
    "irradiance_sensor": "poa_global",
    "anemometer": "wind_speed",
    "anemometer_stall": "wind_speed",
    "air_offset": "temp_air",
    "air_sensor_shield": "temp_air",
}


def faulty_reading(
    record: Record, effect: Effect, change: float, coefficients: dict
) -> dict:
    """Readings of a sensor whose fault has this coefficient, by its column."""
    name = READS[effect.sensor_fault]
    values, size = record[name], change * weights_of(effect, record.dates)
    whole = whole_of(effect.sensor_fault, coefficients)
    if effect.sensor_fault == "anemometer_stall":
        share = size / whole
        slow = np.maximum((values - share * TURNS_FROM) / (1.0 - share), 0.0)
        values = np.where(values < TURNS_FROM, slow, values)
    elif whole is not None:
        values = values / (1.0 + size / whole)
    elif effect.sensor_fault == "air_offset":
        values = values - size
    else:
        values = values + size * np.nan_to_num(record["poa_global"]) / 1000.0
    return {name: values}


def readable(effect: Effect, way: dict, days: np.ndarray, coefficients: dict) -> float:
    """
    The largest size of a fault with which its sensor still reads.

    A sensor that reads a tenth of the true value, or ten times as much, has failed.

    Parameters
    ----------
    effect : Effect
        With its dates.
    way : dict
        Unit vector of its coefficients: of a fault that scales its reading 1 or −1.
    days : numpy.ndarray of int, shape (days,)
        Days of the fitting weeks since 1970-01-01.
    coefficients : dict
        Of the loop's model; an anemometer's fault is measured by its ``u1``.

    Returns
    -------
    float
        In the unit of the coefficient; infinite if there is no such size.
    """
    whole = whole_of(effect.sensor_fault, coefficients)
    if whole is None:
        return np.inf
    (part,) = way.values()
    if effect.sensor_fault == "anemometer_stall":  # which reads less where it is there
        part = -part
    least = (part * weights_of(effect, days)).min()
    return MOST_LOST * whole / -least if least < 0.0 else np.inf


def whole_of(sensor_fault: str, coefficients: dict) -> Any:
    """
    Reference of a fault that scales its reading; None for other faults.

    Parameters
    ----------
    sensor_fault : str
    coefficients : dict
        Of the loop's model; an anemometer's fault is measured by its ``u1``.

    Returns
    -------
    float or None
        In the unit of the fault's coefficient.
    """
    u1 = coefficients.get("u1", np.inf)  # the true loss by wind does not change
    wholes = {"irradiance_sensor": 1.0, "anemometer": u1, "anemometer_stall": u1}
    return wholes.get(sensor_fault)


def add_to_rows(
    data: pd.DataFrame, label: Any, rows: np.ndarray, values: np.ndarray
) -> None:
    """
    Add to some rows of a column, in place.

    Parameters
    ----------
    data : pandas.DataFrame, shape (all rows, columns)
        The user's frame; changed in place.
    label : hashable
        Of the column.
    rows : numpy.ndarray of bool, shape (all rows,)
        Rows that are changed.
    values : numpy.ndarray, shape (rows,)
        A summand for each of these rows, in the unit of the column.
    """
    column = data[label].to_numpy(float).copy()
    column[rows] += values
    data[label] = column
