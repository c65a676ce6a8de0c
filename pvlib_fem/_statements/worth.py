"""What each finding is worth: the yearly energy that it changes."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pvlib_fem._findings import Verdict
from pvlib_fem._record.inputs import Record, read
from pvlib_fem._record.resampling import coarse
from pvlib_fem._statements.causes import READS, SPECIAL
from pvlib_fem._statements.statement import DAYS, key_of
from pvlib_fem._thermal.model import ThermalModel, as_in_a_fit
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import YEAR
from pvlib_fem.quality._lag import retimed
from pvlib_fem.scores import GAMMA, kilowatt_hours

if TYPE_CHECKING:
    from pvlib_fem._loop.results.loop_result import Loop

STEP = 300.0  # s, over which shorter rows are averaged
REFERENCE = 25.0  # °C, of the power that a kWp is
#: findings by which the modules receive other irradiance than the sensor reads, by the
#: sensor fault or the name of the effect
LIGHT = (
    "irradiance_sensor",
    "module_irradiance",
    "soiling",
    "shading",
    "poa_misalignment",
    "modules_covered",
    "sensor_covered",
    "snow",
    "tracker_stuck",
)


def energies(loop: "Loop", gamma: float = GAMMA) -> dict[str, float]:
    r"""
    Absolute change of the expected DC energy by each cause and pattern, in a year.

    Parameters
    ----------
    loop : Loop
    gamma : float, default -0.0035
        Temperature coefficient of power. [1/K]

    Returns
    -------
    dict of float
        By the name of the effect or of the unexplained pattern, the fault of a clock,
        or :func:`.statement.key_of` of days that stand out; empty for a loop that was
        read from a file, which has no rows. Patterns that predictions do not have are
        not in it. [kWh/kWp per year]

    Notes
    -----
    With the irradiance :math:`G` of a row as the sensor reads it, and the temperature
    :math:`T` of the fitted model, of which the finding makes the part :math:`\Delta T`,

    .. math::

        \Delta E = \frac{365.2425}{\mathrm{days}} \sum_i \left|
        (G + \Delta G)\,(1 + \gamma\,(T - 25))
        - G\,(1 + \gamma\,(T - \Delta T - 25)) \right|_i \Delta t_i

    :math:`\Delta G` is the irradiance that the modules receive in addition to the
    reading, and 0 but for the findings of :data:`LIGHT`. A fault that begins within
    the record counts from its date on, and the mean is over all days of the record.
    Rows below 5 min are averaged over that.

    Of an effect that is missing from the model, :math:`\Delta T` is the part that the
    model without it would not make up by other values of its bias, its loss and the
    dependence of its loss on wind: the remainder of a least-squares fit. Of the clock
    of the module's logger, it is the error of the temperature as it was written. Of an
    unexplained pattern, it is what the pattern adds to a prediction, and of a hint,
    what its effect would add to the model. Of days that stand out, it is their mean
    residual by day.
    """
    record = loop.fit.record
    if record is None:
        return {}
    per_kelvin = kilowatt_hours(record.inputs) * gamma
    changes = clock_energy(loop, record, per_kelvin) | days(loop, record, per_kelvin)
    if not (loop.fit.effects or loop.patterns or loop.hint_effects):
        return changes
    record = coarse(record, STEP)
    light, frame = kilowatt_hours(record.inputs), record.inputs.frame()
    parts = loop.contributions(frame, correct_times=False)
    model = Modelled.from_loop(
        loop, frame, loop.fit.thermal_model, loop.fit.coefficients
    )
    for effect in loop.fit.effects:
        warmer = parts[effect.name].to_numpy()
        change = change_by(effect, warmer, model, record, light, gamma)
        changes[effect.name] = per_year(record, change)
    for name, error in loop.errors_by_pattern(frame).items():
        change = light * gamma * error.to_numpy()
        changes[str(name)] = per_year(record, change)
    for effect, other in with_hints(loop, frame):
        warmer = other.temperature - model.temperature
        change = change_by(effect, warmer, other, record, light, gamma)
        changes[effect.name] = per_year(record, change)
    return changes


@dataclass(frozen=True, eq=False)
class Modelled:
    """A model with its coefficients, and its temperature of the rows of a record."""

    model: ThermalModel
    coefficients: dict[str, float]
    columns: dict[str, pd.Series | float]  # inputs and drivers
    temperature: np.ndarray  # [°C]

    @classmethod
    def from_loop(
        cls,
        loop: "Loop",
        frame: pd.DataFrame,
        model: ThermalModel,
        coefficients: dict[str, float],
    ) -> "Modelled":
        (poa, air, wind), drivers = loop.inputs(frame, model.drivers)
        temperature = model.predict(
            poa, air, wind, coefficients=coefficients, **drivers
        )
        columns = {"poa_global": poa, "temp_air": air, **drivers}
        columns["wind_speed"] = 0.0 if wind is None else wind
        return cls(model, coefficients, columns, temperature.to_numpy())

    def received(self, effect: Effect) -> np.ndarray:
        """Irradiance that the modules receive in addition to the reading. [W/m²]"""
        inputs = as_in_a_fit(read(self.columns, purpose="the worth of a finding"))
        base = self.model.base or self.coefficients
        inputs = replace(self.model, base=base).with_drivers(inputs)
        heat = effect.at(inputs.columns, self.coefficients).heat
        return heat + np.zeros(len(inputs.index))


def with_hints(loop: "Loop", frame: pd.DataFrame) -> Iterator[tuple[Effect, Modelled]]:
    """Each effect of a hint, and the fitted model with it."""
    hints = {f.effect: f for f in loop.finding_objects if f.verdict is Verdict.HINT}
    model = loop.fit.thermal_model
    for effect in loop.hint_effects:
        if effect.name not in hints:
            continue
        with_it = replace(model, effects=(*model.effects, effect))
        own = effect.start | hints[effect.name].coefficients
        yield (
            effect,
            Modelled.from_loop(loop, frame, with_it, loop.fit.coefficients | own),
        )


def change_by(
    effect: Effect,
    warmer: np.ndarray,
    modelled: Modelled,
    record: Record,
    light: np.ndarray,
    gamma: float,
) -> np.ndarray:
    """Change of the energy of rows by an effect of a model. [kWh/kWp]"""
    kind = effect.sensor_fault or effect.name
    if kind in LIGHT:
        heat = modelled.received(effect)
        more = kilowatt_hours(record.inputs.having({"poa_global": heat}))
        cooler = modelled.temperature - warmer
        change = (light + more) * efficiency(modelled.temperature, gamma)
        return change - light * efficiency(cooler, gamma)
    if kind not in (*READS, *SPECIAL):
        warmer = beyond_others(record, modelled.temperature, warmer)
    return light * gamma * warmer


def beyond_others(
    record: Record, temperature: np.ndarray, warmer: np.ndarray
) -> np.ndarray:
    """The part of an effect that bias, loss and its dependence on wind do not make."""
    over = temperature - record["temp_air"]
    columns = [np.ones(len(over)), over]
    if "wind_speed" not in record.absent:
        columns.append(over * record["wind_speed"])
    table = np.column_stack(columns)
    known = np.isfinite(warmer) & np.isfinite(table).all(axis=1)
    size = np.linalg.lstsq(table[known], warmer[known], rcond=None)[0]
    return warmer - table @ size


def efficiency(temperature: np.ndarray, gamma: float) -> np.ndarray:
    """Power over that at 25 °C. [-]"""
    return 1.0 + gamma * (temperature - REFERENCE)


def per_year(record: Record, change: np.ndarray) -> float:
    """Sum of absolute changes of rows, for the days of a year."""
    known = np.isfinite(change)
    days = len(np.unique(record.dates[known]))
    return float(np.abs(change[known]).sum() * YEAR / days) if days else np.nan


def days(loop: "Loop", record: Record, per_kelvin: np.ndarray) -> dict[str, float]:
    """Of days that stand out, by their mean residual."""
    changes = {}
    dates = record.dates.astype("datetime64[D]")
    for row in loop.episodes.to_dict("records"):
        first, last = (row[name].to_datetime64() for name in ("start", "end"))
        within = (dates >= first) & (dates <= last)
        change = np.where(within, per_kelvin * row["day"], 0.0 * per_kelvin)
        changes[key_of(DAYS, f"{row['start']:%Y-%m-%d}")] = per_year(record, change)
    return changes


def clock_energy(
    loop: "Loop", record: Record, per_kelvin: np.ndarray
) -> dict[str, float]:
    """Of the clock of the module's logger, where it was corrected."""
    changes = {}
    if loop.times is None or not loop.times.module.fault:
        return changes
    seconds, module = record.inputs.seconds, record["temp_module"]
    written = retimed(seconds, module, -loop.times.module.late_at(seconds))
    for one in loop.corrections:
        if one.applied and one.columns == ("temp_module",):
            change = per_kelvin * (written - module)
            changes[one.fault] = per_year(record, change)
    return changes
