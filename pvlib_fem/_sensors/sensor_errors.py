"""Errors of single module sensors, compared with the other sensors."""

from typing import Any

import numpy as np

from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._loop.regression.design import Design
from pvlib_fem._loop.selection.single_effects import Selection
from pvlib_fem._record.column_names import is_scaled_copy, twin_of
from pvlib_fem._record.inputs import Record, as_record
from pvlib_fem.effects import CHANGES
from pvlib_fem.effects._time_profiles import day_number
from pvlib_fem.quality._screen import screened

SUNNY = 200.0  # W/m², above which over-temperatures are compared
PRESENT = 0.5  # least share of values, relative to the sensor with most values
FEWEST_ROWS = 100  # in sun


def is_sensor(name: str) -> bool:
    """
    Whether a column is a module temperature, by its name.

    Parameters
    ----------
    name : str
        ``temp_module``, or that with a number.

    Returns
    -------
    bool
    """
    return name == "temp_module" or twin_of(name) == "temp_module"


def plausible_values(
    usual: Any, sensors: dict, criteria: Criteria
) -> tuple[dict, dict]:
    """
    Plausible values of each sensor, and by name whether and why it is not used.

    Parameters
    ----------
    usual : tuple of Series
        ``poa_global`` [W/m²], ``temp_air`` [°C] and ``wind_speed`` [m/s], or None for
        the last.
    sensors : dict of Series
        Module temperatures by name. [°C]
    criteria : Criteria

    Returns
    -------
    cleaned : dict of array, shape (rows,)
        NaN where a value is not plausible; without sensors whose record is refused.
        [°C]
    notes : dict of (bool, str)
        For each sensor whether it is excluded, and why or which values are.
    """
    cleaned, notes = {}, {}
    for name, column in sensors.items():
        try:
            record = as_record(*[*usual, column])
            record, faults = screened(record, criteria.limits, check_units=False)
        except ValueError as error:
            notes[name] = True, str(error).replace("temp_module", name)
            continue
        cleaned[name] = record["temp_module"]
        lines = [line for line in faults.notes if "temp_module" in line]
        notes[name] = False, "; ".join(lines).replace("temp_module", name)
    most = max((np.isfinite(one).sum() for one in cleaned.values()), default=0)
    first = []
    for name, values in cleaned.items():
        there = int(np.isfinite(values).sum())
        copies = [other for other in first if is_scaled_copy(values, cleaned[other])]
        if there < PRESENT * most:
            notes[name] = True, f"{there:,} values of {most:,} are there"
        elif copies:
            notes[name] = True, f"{name} is a copy of {copies[0]}"
        else:
            first.append(name)
    return cleaned, notes


def compared_with_others(record: Record, name: str, sensors: dict, good: list) -> tuple:
    """
    Over-temperature of a sensor minus its offset, that of the others, and its line.

    The line is fitted to sunny rows and nights.

    Parameters
    ----------
    record : Record
        With ``poa_global`` [W/m²] and ``temp_air`` [°C].
    name : str
        The sensor.
    sensors : dict of array, shape (rows,)
        Module temperatures by name. [°C]
    good : list of str
        The sensors whose median it is compared with, without itself.

    Returns
    -------
    over, others : array, shape (rows,)
        NaN outside sunny rows. [K]
    line : tuple of float
        Share [-] and offset [K] of the sensor's over-temperature; NaN with less than
        100 sunny rows.
    """
    air, poa, values = record["temp_air"], record["poa_global"], sensors[name]
    # NaN where a sensor is missing, so that the median is of equal sensors at all times
    median = np.median([sensors[other] for other in good if other != name], axis=0)
    own, others = values - air, median - air
    sunny = (poa > SUNNY) & np.isfinite(own + others)
    known = sunny | (poa <= 0.0) & np.isfinite(own + others)
    share = offset = np.nan
    if sunny.sum() >= FEWEST_ROWS:
        share, offset = np.polyfit(others[known], own[known], 1).tolist()
    in_sun = (np.where(sunny, column, np.nan) for column in (own - offset, others))
    return *in_sun, (share, offset)


def steps_of(
    record: Record, sensors: dict, good: list, criteria: Criteria
) -> tuple[dict, dict]:
    """
    Steps of sensors by name, and all sensors with these steps removed.

    The largest step is removed before the next search, because it is in the median of
    the other sensors. With two sensors, both have the one step that is found.

    Parameters
    ----------
    record : Record
        With ``poa_global`` [W/m²] and ``temp_air`` [°C].
    sensors : dict of array, shape (rows,)
        Module temperatures by name. [°C]
    good : list of str
        The sensors that others are compared with.
    criteria : Criteria

    Returns
    -------
    steps : dict of dict
        ``step``, the date; ``change`` of the share, relative to it, and its ``stderr``
        [-].
    level : dict of array, shape (rows,)
        Sensors as if they had gone on as before their steps. [°C]
    """
    level, steps = dict(sensors), {}
    while True:
        new_steps = {}
        for name in (n for n in level if n not in steps):
            over, others, (share, _) = compared_with_others(record, name, level, good)
            new_steps[name] = step_of(over, others, share, record.dates, criteria)
        new_steps = {name: step for name, step in new_steps.items() if step}
        if not new_steps or (len(good) == 2 and {*good} & {*steps}):
            return of_either(steps, good), level
        first = max(
            new_steps, key=lambda name: (name in good, abs(new_steps[name]["change"]))
        )
        step = steps[first] = new_steps[first]
        later = record.dates >= day_number(step["step"])
        air = record["temp_air"]
        before = air + (level[first] - air) / (1.0 + step["change"])
        level[first] = np.where(later, before, level[first])


def of_either(steps: dict, good: list) -> dict:
    """The steps; with two sensors, the step of one is given to the other, too."""
    mine = [name for name in good if name in steps]
    if len(good) != 2 or len(mine) != 1:
        return steps
    (other,) = {*good} - {*mine}
    step = steps[mine[0]]
    times = 1.0 / (1.0 + step["change"])
    error = step["stderr"] * times**2
    return steps | {other: {**step, "change": times - 1.0, "stderr": error}}


def step_of(
    over: np.ndarray,
    others: np.ndarray,
    share: float,
    dates: np.ndarray,
    criteria: Criteria,
) -> dict:
    """Date and size of a step in a sensor's share; empty without one."""
    known = np.isfinite(over)
    if not known.any():
        return {}
    sensor_fault = CHANGES["module_sensor_contact_step"]
    design = Design.of_columns(
        over[known] - share * others[known],
        {"level": others[known]},
        others[known],
        dates[known],
        (sensor_fault,),
    )
    selection = Selection(design, criteria)
    given = [*design.base]
    candidates = selection.candidates(given)
    if not candidates:
        return {}
    (step,) = candidates
    score = selection.score(step, given)
    if (
        score.probability < criteria.min_probability
        or score.fall < criteria.min_hint_reduction**2
    ):
        return {}
    at = step.effect.settings["at"]
    rows = known & (dates < day_number(at))
    before = float(over[rows] @ others[rows] / (others[rows] @ others[rows]))
    (size,), (error,) = score.estimate / before, score.stderr / before
    return {"step": at, "change": float(size), "stderr": float(error)}
