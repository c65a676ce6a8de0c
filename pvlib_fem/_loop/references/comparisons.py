"""
What is compared with an instrument: power, second sensors, a clear sky, usual wind.

If the instrument has changed and not the quantity, the two deviate along the same
time profile; where the change is elsewhere, they do not.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import pandas as pd

from pvlib_fem._record.column_names import is_power, twin_of
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._instruments import MORE_LIGHT
from pvlib_fem.power import GAMMA

BRIGHT = 200.0  # W/m², above which light is compared
BREEZE = 1.0  # m/s, above which wind is
SLACK = 0.15  # of what is expected: a thermal coefficient is no better than that
#: of the heat by light, what the rear and the ground have (see ``rear_irradiance``): it
#: stays when the front receives more, so that the temperature shows less than power
NOT_OF_FRONT = 0.2
#: of a size that a reference shows: power is not quite proportional to irradiance, and
#: second sensors are not quite alike
REFERENCE_ERROR = 0.05
FEWEST_DAYS = 40  # on which both are there
FEWEST_CLEAR = 20  # clear days, since most of the noise is in the others
#: deviation of light, as a log ratio, by the largest change that a sensor can have
MOST_LIGHT = float(np.log1p(MORE_LIGHT.upper))
HAZE = 0.02  # of a clear sky's light, from year to year: aerosol and water [-]
WINDINESS = 0.1  # of the mean wind, from season to season and from year to year [-]
SKY, USUAL_WIND = "clear sky", "usual wind"  # no names of columns


class ComparedRecord(Protocol):
    """What a comparison reads of a record."""

    @property
    def index(self) -> pd.DatetimeIndex: ...

    @property
    def dates(self) -> np.ndarray: ...

    def __getitem__(self, name: str) -> np.ndarray: ...


#: a record and the column to two columns, whose daily sums are compared
Parts = Callable[[ComparedRecord, np.ndarray], tuple[np.ndarray, np.ndarray]]
#: a change of an instrument and the fit's coefficients to the deviation that it makes
Shows = Callable[[np.ndarray, Mapping[str, float]], np.ndarray]


@dataclass(frozen=True)
class Comparison:
    """How something is compared with an instrument, and what a change would show."""

    serves: Callable[[str], bool]  # whether what has that name can be so compared
    rows: Callable[[ComparedRecord], np.ndarray]  # that are compared
    parts: Parts
    #: daily sums to the deviation of the two
    differ: Callable[[np.ndarray, np.ndarray], np.ndarray]
    shows: dict[str, Shows]  # by sensor fault, or effect
    unit: str = "-"
    ages: bool = False  # whether it fades by itself
    wanders: float = 0.0  # by how much it differs from year to year by itself
    most: float = np.inf  # deviation that a change within its bounds can make
    fewest: int = FEWEST_DAYS
    module: bool = False  # whether the module's temperature is in it
    #: faults of which it may show nothing
    unseen: frozenset[str] = frozenset()


def always(record: ComparedRecord) -> np.ndarray:
    return np.ones(len(record.index), dtype=bool)


def bright(record: ComparedRecord) -> np.ndarray:
    """
    Rows on which light is compared.

    Parameters
    ----------
    record : ComparedRecord
        Record with ``poa_global``. [W/m²]

    Returns
    -------
    array of bool, shape (rows,)
        True above 200 W/m².
    """
    return record["poa_global"] > BRIGHT


def dark(record: ComparedRecord) -> np.ndarray:
    return record["poa_global"] <= 0.0


def windy(record: ComparedRecord) -> np.ndarray:
    return record["wind_speed"] > BREEZE


def called(name: str) -> Callable[[str], bool]:
    """Whether something is that one."""
    return lambda other: other == name


def twin(usual: str) -> Callable[[str], bool]:
    """Whether a column is a second sensor of that one."""
    return lambda name: twin_of(name) == usual


def paired_with(usual: str) -> Parts:
    """The column, and the usual column of the instrument."""
    return lambda record, values: (values, record[usual])


def per_irradiance(
    record: ComparedRecord, values: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Power at 25 °C, and the irradiance."""
    return values / (1.0 + GAMMA * (record["temp_module"] - 25.0)), record["poa_global"]


def difference_to(usual: str) -> Parts:
    """How much more the column reads than the usual one of the instrument."""
    return lambda record, values: (values - record[usual], np.ones(len(values)))


def air_by_irradiance(
    record: ComparedRecord, values: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The deviation for each 1000 W/m²."""
    return values - record["temp_air"], record["poa_global"] / 1000.0


def over_temperatures(
    record: ComparedRecord, values: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Over-temperatures of both sensors."""
    return values - record["temp_air"], record["temp_module"] - record["temp_air"]


def log_ratio(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.log(one / other)


def of_wind(change: np.ndarray, coefficients: Mapping[str, float]) -> np.ndarray:
    """The share that wind is read less, where each m/s of it has so much more loss."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.log1p(change / coefficients.get("u1", np.inf))


def of_light(change: np.ndarray, coefficients: Mapping[str, float]) -> np.ndarray:
    """What more light on the modules, than the sensor reads, makes a log ratio."""
    return np.log1p(change)


LOST = "light lost"  # of effects that take light, such as dirt
LIGHT: dict[str, Shows] = {
    "irradiance_sensor": of_light,
    # by the sensor; what the modules lose is negative
    LOST: lambda change, own: of_light(np.maximum(change, 0.0), own),
}
#: light that the modules have, and no sensor
OWN_LIGHT: dict[str, Shows] = {"module_irradiance": of_light, LOST: of_light}


def kind(effect: Effect) -> str:
    """
    What a comparison knows an effect by.

    Parameters
    ----------
    effect : Effect

    Returns
    -------
    str
        Its sensor fault; of an effect without one that it takes light, or its name.
    """
    return effect.sensor_fault or (LOST if effect.loses_light else effect.name)


def size_error(effect: Effect) -> float:
    """
    Relative error of the size of a change that the module temperature gives.

    Parameters
    ----------
    effect : Effect

    Returns
    -------
    float
    """
    front = kind(effect) in OWN_LIGHT
    return float(np.hypot(SLACK, NOT_OF_FRONT)) if front else SLACK


#: modules in another plane than the sensor, whose own light is as it should be
STUCK: dict[str, Shows] = {"tracker_stuck": of_light}
#: by what the light on the modules differs from what the sensor reads
OF_MODULES = LIGHT | OWN_LIGHT | STUCK
WIND: dict[str, Shows] = {"anemometer": of_wind}
AIR: dict[str, Shows] = {"air_offset": lambda change, _: change}
SHELTER: dict[str, Shows] = {"air_sensor_shield": lambda change, _: -change}
CONTACT: dict[str, Shows] = {
    "module_sensor_contact": lambda change, _: -np.log1p(change)
}
OFFSET: dict[str, Shows] = {"module_offset": lambda change, _: -change}

COMPARISONS = (
    Comparison(
        is_power,
        bright,
        per_irradiance,
        log_ratio,
        OF_MODULES,
        ages=True,
        most=MOST_LIGHT,
        module=True,
        # a brighter ground lights the rear, which most modules only take up as heat
        unseen=frozenset({"module_irradiance"}),
    ),
    Comparison(
        called(SKY),
        bright,
        paired_with("poa_global"),
        log_ratio,
        LIGHT,
        wanders=HAZE,
        fewest=FEWEST_CLEAR,
    ),
    Comparison(
        called(USUAL_WIND),
        always,
        paired_with("wind_speed"),
        log_ratio,
        WIND,
        wanders=WINDINESS,
    ),
    Comparison(twin("poa_global"), bright, paired_with("poa_global"), log_ratio, LIGHT),
    Comparison(twin("wind_speed"), windy, paired_with("wind_speed"), log_ratio, WIND),
    Comparison(twin("temp_air"), dark, difference_to("temp_air"), np.divide, AIR, "K"),
    Comparison(twin("temp_air"), bright, air_by_irradiance, np.divide, SHELTER, "K"),
    Comparison(
        twin("temp_module"), bright, over_temperatures, log_ratio, CONTACT, module=True
    ),
    Comparison(
        twin("temp_module"),
        dark,
        difference_to("temp_module"),
        np.divide,
        OFFSET,
        "K",
        module=True,
    ),
)
