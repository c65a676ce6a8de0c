"""A thermal model: a steady law and the dynamics that answers the heat balance."""

from dataclasses import dataclass

import numpy as np

from pvlib_fem.laws import LAWS, Law, law
from pvlib_fem.parameter import Parameter
from pvlib_fem.relaxation import (
    across,
    before,
    decays,
    relax_slope,
    respond,
)
from pvlib_fem.temperature import TAU, fem_temperature, heat_balance

#: time constant that stands for a steady model: shorter than any logger's step
INSTANT = 1e-9  # s

#: the parameter that each dynamics adds to those of the law
MEMORY = {
    "steady": {},
    "ewm": {"tau": Parameter(TAU, 1.0, 7200.0, "s")},
    "balance": {"capacity": Parameter(12e3, 50.0, 1e6, "J/(m² K)")},
}
BIAS = Parameter(0.0, -30.0, 30.0, "K")


@dataclass(frozen=True)
class ThermalModel:
    """A steady law with one of three dynamics, and an offset of the sensor."""

    law: Law
    dynamics: str

    def __post_init__(self):
        if self.dynamics not in MEMORY:
            raise ValueError(
                f"unknown dynamics {self.dynamics!r}; they are {', '.join(MEMORY)}"
            )

    @property
    def parameters(self):
        """Rows of all fitted parameters, bias last."""
        return {**self.law.parameters, **MEMORY[self.dynamics], "bias": BIAS}

    def predict(self, poa_global, temp_air, wind_speed, coefficients):
        """Module temperature through the public functions. [°C]"""
        function = heat_balance if self.dynamics == "balance" else fem_temperature
        return function(
            poa_global, temp_air, wind_speed, model=self.law.name, **coefficients
        )

    def slopes(self, inputs, coefficients):
        """
        Module temperature and its exact slope by each parameter.

        The slopes obey the recursion of the temperature itself, with another
        right-hand side, so each costs one more solve.
        """
        coefficients = dict(coefficients)
        bias = coefficients.pop("bias")
        memory = [coefficients.pop(name) for name in MEMORY[self.dynamics]]
        answer = {"steady": steady, "ewm": smoothed, "balance": balanced}
        temperature, slopes = answer[self.dynamics](
            self.law, inputs, *memory, coefficients
        )
        return temperature + bias, {**slopes, "bias": np.ones(len(temperature))}


def thermal_model(model, dynamics):
    """The thermal model of that name, which a fit can take."""
    if callable(model):
        raise ValueError(
            "a fit needs the slopes of the model, so it takes a name and no "
            f"callable: {', '.join(LAWS)}; translate() gives the coefficients of "
            "other models"
        )
    return ThermalModel(law(model), dynamics)


def steady(law, inputs, coefficients):
    """T = T_air + G·r_eq."""
    poa, air, wind = columns(inputs)
    slopes = law.slopes(wind, **coefficients)
    by_law = {name: poa * slopes[name] for name in law.parameters}
    return air + poa * law.resistance(wind, **coefficients), by_law


def smoothed(law, inputs, tau, coefficients):
    """The paper's form: the law on smoothed irradiance and wind."""
    poa, air, wind = columns(inputs)
    tau = tau / inputs.unit
    poa, poa_by_tau = relax_slope(poa, inputs.steps, tau)
    wind, wind_by_tau = relax_slope(wind, inputs.steps, tau)
    r_eq = law.resistance(wind, **coefficients)
    slopes = law.slopes(wind, **coefficients)
    by_law = {name: poa * slopes[name] for name in law.parameters}
    by_tau = poa_by_tau * r_eq + poa * slopes["wind_speed"] * wind_by_tau
    return air + poa * r_eq, {**by_law, "tau": by_tau / inputs.unit}


def balanced(law, inputs, capacity, coefficients):
    """The exact heat balance, whose time constant is capacity·r_eq."""
    poa, air, wind = columns(inputs)
    valid = np.flatnonzero(~np.isnan(poa + air + wind))
    steps = inputs.steps
    if len(valid) < len(poa):
        steps = across(steps, valid)
        poa, air, wind = poa[valid], air[valid], wind[valid]
    capacity = capacity / inputs.unit
    r_eq = law.resistance(wind, **coefficients)
    r_slopes = law.slopes(wind, **coefficients)
    tau = capacity * r_eq
    target = air + poa * r_eq
    decay = decays(steps, tau, len(target))
    temperature = respond(decay, (1.0 - decay) * target)

    rise = (1.0 - decay) * poa
    # slope of the decay by ln(tau), times what of the past is left to decay
    fading = (before(temperature) - target) * decay * (steps / tau)
    relative = fading / r_eq
    slopes = {
        name: respond(decay, (rise + relative) * r_slopes[name])
        for name in law.parameters
    }
    slopes["capacity"] = respond(decay, fading) / (capacity * inputs.unit)
    return spread(temperature, valid, inputs), {
        name: spread(slope, valid, inputs) for name, slope in slopes.items()
    }


def columns(inputs):
    return inputs["poa_global"], inputs["temp_air"], inputs["wind_speed"]


def spread(values, valid, inputs):
    """Values of the valid rows on all rows, NaN elsewhere."""
    rows = len(inputs.index)
    if len(valid) == rows:
        return values
    result = np.full(rows, np.nan)
    result[valid] = values
    return result
