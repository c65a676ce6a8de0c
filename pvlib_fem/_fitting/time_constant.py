"""The time constant of a model: its search coordinate, and notes on its accuracy."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import t as student

from pvlib_fem._spelling import ShellText, refusal
from pvlib_fem._thermal.model import MEMORY, ThermalModel

FAINT = 20.0  # time constants after which the past has no visible weight
FADED = 300.0  # time constants after which the weight of the past is almost no float
STEADY = ShellText("dynamics='steady'", "--dynamics steady")
SPREAD = 60.0 / 379.0  # relative spread of tau over the paper's fixed mountings


@dataclass(frozen=True)
class IdentityCoordinate:
    """A coefficient that is its own search coordinate."""

    lower: float

    def to_search(self, value: float) -> float:
        return value

    from_search = to_search

    def slope(self, value: float) -> float:
        return 1.0


@dataclass(frozen=True)
class Lag:
    """
    Search coordinate of a time constant: the mean age of the past in a sample.

    If tau is much shorter than the step, ``exp(-step/tau)`` and all its derivatives
    vanish, so a search in ``tau`` cannot leave that region. The temperature is nearly
    linear in the age, ``step / (exp(step/tau) - 1)``, from 0 on. If tau is many steps,
    it exceeds the age by half a step.
    """

    step: float  # of the record, in the unit of the time constant or capacity
    lower: float

    def to_search(self, memory: float) -> float:
        """Mean age of a time constant or capacity."""
        return self.step / np.expm1(min(self.step / memory, FADED))

    def from_search(self, age: float) -> float:
        """Time constant or capacity of a mean age."""
        return self.step / np.log1p(self.step / age)

    def slope(self, age: float) -> float:
        """Slope of the time constant or capacity by the age."""
        return self.from_search(age) ** 2 / (age * (age + self.step))


def lag(model: ThermalModel, coefficients: dict, step: float, wind: float) -> Lag:
    """
    Search coordinate of a dynamic model's time constant.

    Parameters
    ----------
    model : ThermalModel
        With ``"ewm"`` or ``"balance"`` dynamics.
    coefficients : dict
        Of its steady model.
    step : float
        Usual time between rows. [s]
    wind : float
        Mean wind speed, at which a capacity is converted to a time constant. [m/s]

    Returns
    -------
    Lag
        Its lower bound is that of the parameter, or a twentieth of the step if this is
        larger.

    Raises
    ------
    ValueError
        If the resistance is so small that no capacity in range can be determined.
    """
    ((name, row),) = MEMORY[model.dynamics].items()
    if name == "capacity":  # its time constant is capacity times resistance
        law = model.steady_model
        gain = float(law.resistance(wind, **model.steady_coefficients(coefficients)))
        if gain * row.upper * FADED <= step:
            raise refusal(
                f"temp_module does not follow poa_global: in wind of {wind:.3g} m/s "
                f"the fit is at {gain:.2g} K m²/W, at which steps of {step:g} s do not "
                "determine a capacity; check that temp_module is the module's own "
                "sensor, and the units of both, or give ",
                STEADY,
            )
        step = step / gain
    return Lag(step, max(row.lower, step / FAINT))


def memory_notes(
    source: Any,
    model: ThermalModel,
    coefficients: dict,
    stderr: dict,
    at_bound: tuple,
    days: int,
) -> Iterator:
    """
    Notes if the record's step does not determine the fitted time constant.

    Parameters
    ----------
    source : Source
        Of the ``step`` [s] and ``wind`` [m/s] of the record.
    model : ThermalModel
        The fitted model.
    coefficients : dict
        Of all its parameters.
    stderr : dict
        Their standard errors.
    at_bound : tuple of str
        Coefficients at a bound of their range.
    days : int
        Number of fitted days, for the interval.

    Yields
    ------
    str
        At most one note.
    """
    known = [n for n in MEMORY[model.dynamics] if n not in model.held]
    if not known:
        return
    (name,), seen = known, lag(model, coefficients, source.step, source.wind)
    value, unit = coefficients[name], model.parameters[name].unit
    step, age = f"steps of {source.step:g} s", seen.to_search(value)
    known = student.ppf(0.975, max(days - 1, 1)) * stderr[name] / seen.slope(age)
    if name in at_bound and age < seen.to_search(model.parameters[name].start):
        yield (
            f"{name} is not known from {step}: {value:.3g} {unit} is the least that "
            "they can resolve, and any less would fit as well; take a shorter step, or "
            f"hold it with fixed={{'{name}': ...}}"
        )
    elif known >= age:
        yield (
            f"{name} is not known from {step}: its 95 % interval reaches down to none "
            "at all; take a shorter step, or hold it with "
            f"fixed={{'{name}': ...}}"
        )
    elif value > (1.0 + SPREAD) * age:
        # for records of means, the age is the time constant at any step; values at one
        # time lead the means before them by half a step, and by more under clouds
        yield (
            f"{name} holds if temp_module is the value at the end of {step} and other "
            "columns are means over them: if all are means, as most loggers store, the "
            f"module's own is about {float(f'{age:.2g}'):,g} {unit}, and at most that "
            "if all are instantaneous values"
        )
