"""
NMOT by the procedure of IEC 61853-2, and the requirements a record fails.

The standard is not public, and this file was not compared with its text. It implements
the procedure as the literature describes it: filters, the regression of G / (T - T_air)
on wind speed, and the minimum number of days.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.column_names import DAYLIGHT
from pvlib_fem._statistics.clusters import FEWEST_DAYS, cluster_sums
from pvlib_fem._thermal_parameters.given_record import Measured
from pvlib_fem._thermal_parameters.parameter_rows import Row
from pvlib_fem._thermal_parameters.steady_parameters import AIR, BREEZE, IEC, NOMINAL

READING = 5.0  # s, the longest time between readings
BRIGHT = 400.0  # W/m², least irradiance of a reading
QUIET = "10min"  # time before a reading in which sun and wind must be steady
MEAN = "5min"  # averaging time of the wind
VARIES = 0.10  # largest relative variation of irradiance
CALM, GUST = 0.25, 3.0  # least wind [m/s], and largest ratio to the mean wind
BETWEEN = (1.0, 8.0)  # m/s, range of the mean wind
SPREAD = 4.0  # m/s, least range of the mean winds
POINTS = 10  # least number of readings before and after noon of a day
DAYS = 10
TILT = (37.5, 2.5)  # °, and its tolerance
DAY = 86400.0  # s
STEP = 300.0  # s, longest step with which the filters can be computed
NOT_SEEN = (
    "not checked, since no record shows it: open rack, load at maximum power, "
    "surrounding modules, place of the anemometer"
)
EQUATION = "G / (T - T_air) = u0 + u1 WS; NMOT = 20 °C + 800 W/m² / (u0 + u1 1 m/s)"


@dataclass(frozen=True, eq=False)
class Nmot:
    """Numbers and errors by name, number of days, and requirements not met."""

    values: dict
    errors: dict
    days: int
    unmet: tuple


def nmot_rows(measured: Any, why: str, surface_tilt: Any = None) -> Iterator:
    """
    Rows of NMOT by the standard's procedure.

    Parameters
    ----------
    measured : Measured or None
    why : str
        Why there is no record.
    surface_tilt : float or None
        [°]

    Yields
    ------
    Row
    """
    result = None if measured is None else procedure(measured, surface_tilt)
    units = {"NMOT": "°C", "u0": "W/(m² K)", "u1": "W s/(m³ K)"}
    for name, unit in units.items():
        value, error, days, note = np.nan, np.nan, np.inf, why
        if result is not None:
            value = result.values.get(name, np.nan)
            error = result.errors.get(name, np.nan)
            days, note = result.days, f"not met: {'; '.join(result.unmet)}. {NOT_SEEN}"
            if not result.unmet:
                note = NOT_SEEN
        title = "by IEC 61853-2" if name == "NMOT" else f"{name} by IEC 61853-2"
        yield Row(
            "nmot",
            title,
            value,
            unit,
            error,
            days - 1.0,
            of="module",
            equation=EQUATION,
            source=IEC,
            note=note,
        )


def procedure(measured: Measured, surface_tilt: Any = None) -> Nmot:
    """Apply the procedure to a record."""
    step, unmet = measured.step, []
    if step > READING:
        unmet.append(f"readings every {READING:g} s or less (here {step:g} s)")
    if surface_tilt is None:
        unmet.append(f"tilt {TILT[0]:g} ± {TILT[1]:g}° (here unknown)")
    elif abs(surface_tilt - TILT[0]) > TILT[1]:
        unmet.append(f"tilt {TILT[0]:g} ± {TILT[1]:g}° (here {surface_tilt:g}°)")
    if step > STEP:
        unmet.append(
            f"filters over 5 and 10 min (steps of {step:g} s cannot form them)"
        )
        return Nmot({}, {}, 0, tuple(unmet))
    table, lit = readings(measured)
    half = table.groupby("date")["after"].agg(["sum", "size"])
    enough = (half["sum"] >= POINTS) & (half["size"] - half["sum"] >= POINTS)
    table = table[table["date"].isin(half.index[enough])]
    days = int(enough.sum())
    if days < DAYS:
        unmet.append(
            f"{DAYS} days with {POINTS} readings before and after noon (here {days} of "
            f"{lit})"
        )
    spread = np.ptp(table["wind"]) if days else 0.0
    if spread < SPREAD:
        unmet.append(f"winds that cover {SPREAD:g} m/s (here {spread:.1f} m/s)")
    values, errors = regression(table, days)
    return Nmot(values, errors, days, tuple(unmet))


def readings(measured: Measured) -> tuple[pd.DataFrame, int]:
    """Readings that pass the filters, and the number of days with light."""
    columns = ("poa_global", "temp_air", "wind_speed", "temp_module")
    sun, air, wind, module = (measured.series(name) for name in columns)
    mean = wind.rolling(MEAN).mean()
    past = sun.rolling(QUIET)
    varies = past.max() - past.min() > VARIES * past.max()
    rough = ((wind < CALM) | (wind > GUST * mean)).astype(float)
    unsteady = varies | (rough.rolling(QUIET).max() > 0.0)
    over = module - air
    kept = (sun >= BRIGHT) & mean.between(*BETWEEN) & ~unsteady & (over > 0.0)
    dates = pd.Series(days_of_light(measured), sun.index)
    # noon is the middle of each day's light, so the site need not be known
    hours = pd.Series(np.arange(len(sun)), sun.index)
    light = hours[sun > DAYLIGHT].groupby(dates[sun > DAYLIGHT].to_numpy())
    noon = (light.min() + light.max()) / 2.0
    after = hours > dates.map(noon)
    table = pd.DataFrame(
        {"loss": sun / over, "wind": mean, "date": dates, "after": after}
    )
    return table[kept].dropna(), len(noon)


def days_of_light(measured: Measured) -> np.ndarray:
    """Day of each row, from midnight by the sun: in UTC light may be on two dates."""
    days = measured.record.inputs.seconds / DAY
    light = np.nan_to_num(measured.record["poa_global"])
    noon = np.angle(light @ np.exp(2j * np.pi * days)) / (2.0 * np.pi)
    return np.floor(days - noon + 0.5).astype(int)


def regression(table: pd.DataFrame, days: int) -> tuple[dict, dict]:
    """u0, u1 and NMOT by least squares, with errors clustered by day."""
    if not days or np.ptp(table["wind"]) == 0.0:
        return {}, {}
    wind, loss = table["wind"].to_numpy(), table["loss"].to_numpy()
    columns = [np.ones(len(wind)), wind]
    (u0, u1), *_ = np.linalg.lstsq(np.transpose(columns), loss, rcond=None)
    at = u0 + u1 * BREEZE
    values = {"u0": u0, "u1": u1, "NMOT": AIR + NOMINAL / at}
    if days < FEWEST_DAYS:
        return values, {}
    dates = table["date"].to_numpy()
    covariance = cluster_sums(columns, loss - u0 - u1 * wind, dates).by_day()
    slopes = -NOMINAL / at**2 * np.array([1.0, BREEZE])
    squares = [*np.diag(covariance), slopes @ covariance @ slopes]
    return values, dict(zip(values, np.sqrt(squares).tolist()))
