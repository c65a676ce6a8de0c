"""
Columns of a user's own that are outputs of the modules: their power, by any name.

Power follows irradiance, is none without light and falls with the temperature of the
modules. A source of heat makes them warmer. So the sign tells power from heat. As heat,
power would only stand in for the irradiance that the modules absorb.
"""

from collections.abc import Iterable, Iterator

import numpy as np

from pvlib_fem._loop.preparation.leaks import SURE, splines
from pvlib_fem._record.column_names import DAYLIGHT, is_power
from pvlib_fem._record.inputs import Record
from pvlib_fem._record.names import is_own, usual_name
from pvlib_fem._statistics.clusters import FEWEST_DAYS, calendar_weeks
from pvlib_fem._statistics.hourly_means import Hours
from pvlib_fem._statistics.weekly_sums import least_squares_coefficients
from pvlib_fem.power import BRIGHT

MOST = 95.0  # percentile that stands for the most, by day and by night
DARK = 0.05  # of the most by day: more of it without light is no power of modules
FACTOR = 2.0  # to the usual ratio of power and irradiance; beyond it is an outage
HALF = 0.5  # of the rows, that have the usual ratio; of the variance, by light
LIMIT = 0.98  # of the most, from which an inverter may limit the power
#: change of power with temperature that is taken for that of modules; data sheets
#: have -0.5 to -0.2 % [1/K]
FALL = (-0.008, -0.001)
FORTNIGHT = 2  # weeks in which the sun at one hour is in nearly one place


def outputs(record: Record, names: Iterable[str]) -> Iterator[tuple[str, str, str]]:
    """
    Columns that are a power of modules, and what shows it.

    Each follows irradiance by day and is next to nothing by night. Its name says that
    it is a power, or it falls with the module temperature as the power of modules does.

    Parameters
    ----------
    record : Record
        Screened. Rows without a module temperature are not looked at.
    names : sequence of str
        Columns of a user's own; a column with a name of the package is skipped.

    Yields
    ------
    column, name, evidence : str
        Column, the package's name that no other column has, and the evidence as part
        of a sentence.
    """
    there = {*record.inputs.columns}
    for column in names:
        if is_own(column) or not is_dark_at_night(record, column):
            continue
        rows = usual_rows(record, column)
        cells = Hours.from_record(record, rows)
        power, light, warmth = (
            cells.means(record[name][rows])
            for name in (column, "poa_global", "temp_module")
        )
        first = rows[cells.first]
        dates, hours = record.dates[first], record.index.hour[first]
        if explained(power, light) < HALF or len(np.unique(dates)) < FEWEST_DAYS:
            continue
        name = usual_name(column) or ""
        evidence = "its name is that of a power"
        if not is_power(name):
            size = np.abs(power)
            free = size < LIMIT * np.percentile(size, 99.0)
            place = np.asarray(hours) + 24 * (calendar_weeks(dates) // FORTNIGHT)
            some = (x[free] for x in (power / light, light, warmth, place, dates))
            if not falls(*some):
                continue
            name, evidence = "power_ac", "it falls with the module temperature"
        name = free_name(name, there)
        there.add(name)
        yield column, name, f"it follows irradiance, and {evidence}"


def free_name(name: str, there: set) -> str:
    """A name that no column has: itself, or with a number behind it."""
    numbered = (f"{name}_{number}" for number in range(2, len(there) + 3))
    return next(one for one in (name, *numbered) if one not in there)


def is_dark_at_night(record: Record, name: str) -> bool:
    """Whether a column is next to nothing without light, compared with the day."""
    size, lit = np.abs(record[name]), record["poa_global"] > DAYLIGHT
    day, night = (size[np.isfinite(size) & rows] for rows in (lit, ~lit))
    if not len(day):
        return False
    least = np.percentile(night, MOST) if len(night) else 0.0
    return bool(least < DARK * np.percentile(day, MOST))


def usual_rows(record: Record, name: str) -> np.ndarray:
    """Rows with light where a column has nearly its usual ratio; none if few do."""
    values, light = record[name], record["poa_global"]
    known = np.isfinite(values) & np.isfinite(record["temp_module"]) & (light > BRIGHT)
    rows = np.flatnonzero(known)
    ratio = values[rows] / light[rows]
    usual = np.median(ratio) if len(rows) else 0.0
    if not usual:
        return rows[:0]
    near = (ratio / usual > 1.0 / FACTOR) & (ratio / usual < FACTOR)
    return rows[near] if np.mean(near) > HALF else rows[:0]


def explained(column: np.ndarray, light: np.ndarray) -> float:
    """Share of a column's variance that is linear in irradiance."""
    if not len(column) or not np.std(column) > 0 or not np.std(light) > 0:
        return 0.0
    return float(np.corrcoef(column, light)[0, 1] ** 2)


def falls(
    ratio: np.ndarray,
    light: np.ndarray,
    warmth: np.ndarray,
    cells: np.ndarray,
    dates: np.ndarray,
) -> bool:
    """
    Whether power per light surely falls with temperature, as that of modules does.

    Hours of one light and one place of the sun are compared, which wind and air make
    warmer or colder. ``ratio`` is power per light [any unit], ``warmth`` the module
    temperature. Hours with one number in ``cells`` have nearly one place of the sun.
    Errors are of days.
    """
    if len(np.unique(dates)) < FEWEST_DAYS:
        return False
    table = np.column_stack([warmth, np.log(np.abs(ratio)), *splines(np.log(light))])
    cell = np.unique(cells, return_inverse=True)[1]
    means = [np.bincount(cell, column) / np.bincount(cell) for column in table.T]
    table = table - np.column_stack(means)[cell]
    both, usual = table[:, :2], table[:, 2:]
    warmth, change = (both - usual @ least_squares_coefficients(usual, both)).T
    if not (square := warmth @ warmth) > 0:
        return False
    slope = warmth @ change / square
    day = np.unique(dates, return_inverse=True)[1]
    error = (
        np.linalg.norm(np.bincount(day, warmth * (change - slope * warmth))) / square
    )
    return bool(FALL[0] < slope < FALL[1] and slope < -SURE * error)
