"""The memory of a model: how a search varies it, and what a record tells of it."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from pvlib_fem.spelling import Spelled, refusal
from pvlib_fem.thermal.model import MEMORY

FAINT = 20.0  # time constants of a step after which nothing is left of the past
FADED = 300.0  # the same, after which what is left is next to no number
STEADY = Spelled("dynamics='steady'", "--dynamics steady")
SPREAD = 60.0 / 379.0  # of the time constants of the paper's fixed mountings


@dataclass(frozen=True)
class AsItIs:
    """A coefficient that the search varies as it is."""

    lower: float

    def seen(self, value):
        return value

    told = seen

    def slope(self, seen):
        return 1.0


@dataclass(frozen=True)
class Lag:
    """
    A memory as the search varies it: the mean age of what a sample still holds.

    The answer is flat to all orders where a time constant is a small part of the
    step, since ``exp(-step/tau)`` is: a search by ``tau`` that once came there would
    stay. By the age, ``step / (exp(step/tau) - 1)``, it is nearly linear from none
    on; where tau is many steps, the two are half a step apart.
    """

    step: float  # of the record, in the unit of the memory
    lower: float

    def seen(self, memory):
        return self.step / np.expm1(min(self.step / memory, FADED))

    def told(self, age):
        return self.step / np.log1p(self.step / age)

    def slope(self, age):
        """Slope of the memory by its age."""
        return self.told(age) ** 2 / (age * (age + self.step))


def lag(model, coefficients, step, wind):
    """How a search varies the memory of a model that has one. [s, m/s]"""
    ((name, row),) = MEMORY[model.dynamics].items()
    if name == "capacity":  # whose time constant is that times the resistance
        law = model.steady_model
        gain = float(law.resistance(wind, **model.own(coefficients)))
        if gain * row.upper * FADED <= step:
            raise refusal(
                f"temp_module does not follow poa_global: in wind of {wind:.3g} m/s "
                f"the fit is at {gain:.2g} K m²/W, at which steps of {step:g} s tell "
                "nothing of a capacity; check that temp_module is the module's own "
                "sensor, and the units of both, or give ",
                STEADY,
            )
        step = step / gain
    return Lag(step, max(row.lower, step / FAINT))


def memory_notes(source, model, coefficients, stderr, at_bound, days):
    """What the record's step leaves open of the fitted memory, in sentences."""
    known = [n for n in MEMORY[model.dynamics] if n not in model.held]
    if not known:
        return
    (name,), seen = known, lag(model, coefficients, source.step, source.wind)
    value, unit = coefficients[name], model.parameters[name].unit
    step, age = f"steps of {source.step:g} s", seen.seen(value)
    known = student.ppf(0.975, max(days - 1, 1)) * stderr[name] / seen.slope(age)
    if name in at_bound and age < seen.seen(model.parameters[name].start):
        yield (
            f"{name} is not known from {step}: {value:.3g} {unit} is the least that "
            "they can tell, and any less would fit as well; take a shorter step, or "
            f"hold it with fixed={{'{name}': ...}}"
        )
    elif known >= age:
        yield (
            f"{name} is not known from {step}: its 95 % interval reaches down to none "
            "at all; take a shorter step, or hold it with "
            f"fixed={{'{name}': ...}}"
        )
    elif value > (1.0 + SPREAD) * age:
        # means answer to means by their age, whatever the step
        yield (
            f"{name} is that of samples at the end of {step}: if the columns are means "
            "over them, as most loggers store, the module's own is about "
            f"{float(f'{age:.2g}'):,g} {unit}"
        )
