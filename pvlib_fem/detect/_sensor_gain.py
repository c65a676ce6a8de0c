"""An irradiance sensor and an anemometer that read more or less than they did."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from pvlib.location import Location
from pvlib.pvsystem import AbstractMount

from pvlib_fem._loop.references.comparisons import COMPARISONS, SKY, USUAL_WIND
from pvlib_fem._loop.references.deviations import (
    FADES,
    DailyDeviation,
    daily_deviation,
)
from pvlib_fem._record.checks import dates_of
from pvlib_fem._statistics.changing_level import Law
from pvlib_fem.detect._changes import SURE, LevelChanges, level_changes, level_result
from pvlib_fem.detect._checked_series import checked_series
from pvlib_fem.drivers import checked_place
from pvlib_fem.drivers._mounts import angles_at
from pvlib_fem.quality._clearsky import clear_sky

POWER, TWIN = "power_ac", "wind_speed_2"  # names by which a comparison is found
ARGUMENTS = {POWER: "power", TWIN: "reference"}  # and those of its argument
STANDARD = 25.0  # °C, where no module temperature is given
LIGHT = Law(
    np.arange(-1.0, 1.0, 0.02),  # logarithms
    odds=1e-4,
    accident=0.1,
    least=0.02,
    fine=0.005,
    memory=7.0,
    swing=0.05,
    trend=0.03,
)
WIND = replace(LIGHT, least=0.1, fine=0.05, memory=4.0, swing=0.2, trend=0.1)


@dataclass(frozen=True, eq=False)
class Columns:
    """What a comparison reads of a record."""

    index: pd.DatetimeIndex
    columns: dict

    @property
    def dates(self) -> np.ndarray:
        return dates_of(self.index)

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[name]


def compared_with(
    name: str, values: np.ndarray, index: pd.DatetimeIndex, **columns: np.ndarray
) -> DailyDeviation:
    """A sensor compared with the reference of a name; refuse missing columns."""
    comparison = next(one for one in COMPARISONS if one.serves(name))
    every = np.ones(len(index), dtype=bool)
    deviation = daily_deviation(
        comparison, Columns(index, columns), every, name, values
    )
    if deviation is None:
        raise ValueError(
            f"fewer than {comparison.fewest} days can be compared with "
            f"{ARGUMENTS.get(name, name)}; give a longer record"
        )
    return deviation


def irradiance_changes(
    poa_global: pd.Series,
    location: Location | None = None,
    surface_tilt: float | pd.Series | None = None,
    surface_azimuth: float | pd.Series | None = None,
    power: pd.Series | None = None,
    temp_module: pd.Series | None = None,
    mount: AbstractMount | None = None,
) -> LevelChanges:
    """
    Steps and drift of an irradiance sensor, against a clear sky, power, or both.

    Parameters
    ----------
    poa_global : Series
        Irradiance in any plane. [W/m²]
    location : pvlib.location.Location, optional
        For the clear sky. Times without a zone are local standard time.
    surface_tilt, surface_azimuth : float or Series, optional
        Of the plane, for the clear sky; a flat one by default. [°]
    power : Series, optional
        Of a plant in the same light, in any unit.
    temp_module : Series, optional
        Temperature that power is corrected for; 25 °C by default. [°C]
    mount : pvlib.pvsystem.SingleAxisTrackerMount, optional
        Of a sensor on a tracker, instead of its angles.

    Returns
    -------
    LevelChanges

    Raises
    ------
    TypeError
        If a column is no Series with a DatetimeIndex.
    ValueError
        If neither ``location`` nor ``power`` is given, indexes differ, or fewer than 20
        clear days, or 40 days with power, can be compared.

    Notes
    -----
    The daily ratio of the sensor to the reference has a level that changes seldom
    (Viterbi's path [1]_), a season and a trend. Steps and drift have the errors of a
    jackknife over months; a clear sky differs by 2 % from year to year by itself, and a
    plant loses 0.5 ± 0.5 % a year, which is taken off. With both references a step has
    to be in both, and the drift is their mean, weighted by their errors.

    References
    ----------
    .. [1] G. D. Forney, "The Viterbi algorithm", Proc. IEEE 61, 268-278, 1973.
       :doi:`10.1109/PROC.1973.9030`

    Examples
    --------
    >>> from pvlib_fem import detect, simulator
    >>> data = simulator.record(days=400, step=3600)
    >>> power = 6 * data["poa_global"]
    >>> sensor = data["poa_global"].where(data.index < "2023-08-01", 1.1 * power / 6)
    >>> changes = detect.irradiance_changes(sensor, power=power)
    >>> [(f"{day:%Y-%m-%d}", round(by, 2)) for day, by in changes.steps]
    [('2023-08-01', 0.1)]
    """
    place = checked_place(location, surface_tilt, surface_azimuth, mount)
    if location is None and power is None:
        raise ValueError("there is nothing to compare with: give location, or power")
    given = {"poa_global": poa_global, "power": power, "temp_module": temp_module}
    index, (poa, fed, module) = checked_series(("power", "temp_module"), **given)
    if module is None:
        module = np.full(len(index), STANDARD)
    deviations = []
    if fed is not None:
        deviations.append(
            compared_with(POWER, fed, index, poa_global=poa, temp_module=module)
        )
    if location is not None:
        sky = clear_sky(poa, index, location, angles_at(index, place))
        deviations.append(compared_with(SKY, sky, index, poa_global=poa))
    changes = [aged(level_changes(one, LIGHT)) for one in deviations]
    if len(changes) == 1:
        return changes[0]
    by_power, by_sky = changes
    return agreed(by_power, by_sky, deviations[1])


def aged(changes: LevelChanges) -> LevelChanges:
    """The comparison without the plant's own losses."""
    if changes.reference != POWER:
        return changes
    fades = FADES
    error = float(np.hypot(changes.drift_error, fades))
    return replace(changes, drift=changes.drift - fades, drift_error=error)


def agreed(
    changes: LevelChanges, other: LevelChanges, sky: DailyDeviation
) -> LevelChanges:
    """The steps of the first that the other has, too, and the drift of both."""
    drifts = np.array([changes.drift, other.drift])
    weights = np.array([changes.drift_error, other.drift_error]) ** -2.0
    error = max(weights.sum() ** -0.5, np.ptp(drifts) / 2.0 / SURE)
    dates, days = changes.level.index, dates_of(changes.level.index)
    new, sizes = [], []
    for day, by in changes.steps:
        after = (sky.days >= dates_of(pd.DatetimeIndex([day]))[0]).astype(float)
        if 0.0 < after.mean() < 1.0:
            # what is apart is the sky over the sensor
            size, stderr, _ = sky.along(after)
            if -size * np.sign(by) > SURE * stderr:
                new.append(dates.get_loc(day))
                sizes.append(np.log1p(by))
    both = f"{changes.reference} and {other.reference}"
    drift = float(drifts @ weights / weights.sum())
    return level_result(days, np.array(new, dtype=int), sizes, both, drift, error)


def slow_anemometer(
    wind_speed: pd.Series, reference: pd.Series | None = None
) -> LevelChanges:
    """
    Steps and drift of an anemometer, as of a bearing that wears.

    Parameters
    ----------
    wind_speed : Series
        [m/s]
    reference : Series, optional
        Wind of another anemometer, or of a weather model; without it the usual wind
        is the reference. [m/s]

    Returns
    -------
    LevelChanges

    Raises
    ------
    TypeError
        If a column is no Series with a DatetimeIndex.
    ValueError
        If indexes differ, or fewer than 40 days can be compared.

    Notes
    -----
    As :func:`irradiance_changes`. The mean wind differs by 10 % from season to season
    and from year to year by itself, so that without a reference only a loss of
    about half is seen.

    Examples
    --------
    >>> from pvlib_fem import detect, simulator
    >>> wind = simulator.record(days=400, step=3600)["wind_speed"]
    >>> slow = wind.where(wind.index < "2023-08-01", 0.7 * wind)
    >>> changes = detect.slow_anemometer(slow, reference=wind)
    >>> [(f"{day:%Y-%m-%d}", round(by, 2)) for day, by in changes.steps]
    [('2023-08-01', -0.3)]
    """
    given = {"wind_speed": wind_speed, "reference": reference}
    index, (wind, other) = checked_series(("reference",), **given)
    if other is None:
        one = compared_with(USUAL_WIND, np.ones(len(index)), index, wind_speed=wind)
    else:
        one = compared_with(TWIN, other, index, wind_speed=wind)
    return level_changes(one, WIND)
