"""What each finding is worth: the yearly energy that it changes."""

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pvlib_fem._record.inputs import Record, read
from pvlib_fem._record.resampling import coarse
from pvlib_fem._statements.causes import READS, SPECIAL
from pvlib_fem._thermal.model import as_in_a_fit
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import YEAR
from pvlib_fem.quality._lag import retimed
from pvlib_fem.scores import GAMMA, kilowatt_hours

if TYPE_CHECKING:
    from pvlib_fem._loop.loop_result import Loop

STEP = 300.0  # s, over which shorter rows are averaged
REFERENCE = 25.0  # °C, of the power that a kWp is
#: findings by which the modules receive other irradiance than the sensor reads, by the
#: sensor fault or the name of the effect
LIGHT = (
    "irradiance_sensor",
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
    Absolute change of the expected DC energy by each finding, in a year.

    Parameters
    ----------
    loop : Loop
    gamma : float, default -0.0035
        Temperature coefficient of power. [1/K]

    Returns
    -------
    dict of float
        By the name of the effect, or the fault of a clock; empty for a loop that was
        read from a file, which has no rows. [kWh/kWp per year]

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
    of the module's logger, it is the error of the temperature as it was written.
    """
    record = loop.fit.record
    if record is None:
        return {}
    changes = clocks(loop, record, gamma)
    if not loop.fit.effects:
        return changes
    record = coarse(record, STEP)
    light, frame = kilowatt_hours(record.inputs), record.inputs.frame()
    parts = loop.contributions(frame, correct_times=False)
    usual, drivers = loop.inputs(frame)
    temperature = loop.fit.predict(*usual, **drivers).to_numpy()
    for effect in loop.fit.effects:
        warmer, kind = parts[effect.name].to_numpy(), effect.sensor_fault or effect.name
        if kind in LIGHT:
            heat = received(loop, usual, drivers, effect)
            more = kilowatt_hours(record.inputs.having({"poa_global": heat}))
            change = (light + more) * efficiency(temperature, gamma)
            change = change - light * efficiency(temperature - warmer, gamma)
        else:
            if kind not in (*READS, *SPECIAL):
                warmer = beyond_others(record, temperature, warmer)
            change = light * gamma * warmer
        changes[effect.name] = per_year(record, change)
    return changes


def received(
    loop: "Loop", usual: list[pd.Series], drivers: dict[str, pd.Series], effect: Effect
) -> np.ndarray:
    """Irradiance that the modules receive in addition to the reading. [W/m²]"""
    poa, air, wind = usual
    columns = {"poa_global": poa, "temp_air": air, **drivers}
    columns["wind_speed"] = 0.0 if wind is None else wind
    inputs = as_in_a_fit(read(columns, purpose="the worth of a finding"))
    inputs = loop.fit.thermal_model.with_drivers(inputs)
    heat = effect.at(inputs.columns, loop.fit.coefficients).heat
    return heat + np.zeros(len(inputs.index))


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


def clocks(loop: "Loop", record: Record, gamma: float) -> dict[str, float]:
    """Of the clock of the module's logger, where it was corrected."""
    changes = {}
    if loop.times is None or not loop.times.module.fault:
        return changes
    light = kilowatt_hours(record.inputs)
    seconds, module = record.inputs.seconds, record["temp_module"]
    written = retimed(seconds, module, -loop.times.module.at(seconds))
    for one in loop.corrections:
        if one.applied and one.columns == ("temp_module",):
            change = light * gamma * (written - module)
            changes[one.fault] = per_year(record, change)
    return changes
