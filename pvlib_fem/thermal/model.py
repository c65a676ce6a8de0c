"""A thermal model: a steady model, effects, and the dynamics that answers them."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from pvlib_fem.drivers import MODELLED, behind, completed, needed_for
from pvlib_fem.effects.effect import Parameter, Terms, is_there
from pvlib_fem.quality.limits import possible
from pvlib_fem.quality.outliers import out_of_range
from pvlib_fem.record.checks import at_time, read
from pvlib_fem.record.columns import ALIASES
from pvlib_fem.relaxation import (
    across,
    banded,
    before,
    decays,
    relax,
    relax_slope,
    solve,
)
from pvlib_fem.thermal.steady import STEADY_MODELS, SteadyModel, steady_model
from pvlib_fem.thermal.temperature import TAU, losing

#: time constant that stands for a steady model: shorter than any logger's step
INSTANT = 1e-9  # s

#: the parameter that each dynamics adds to those of the steady model
MEMORY = {
    "steady": {},
    "ewm": {"tau": Parameter(TAU, 1.0, 7200.0, "s")},
    "balance": {"capacity": Parameter(12e3, 50.0, 1e6, "J/(m² K)")},
}
BIAS = Parameter(0.0, -30.0, 30.0, "K")


@dataclass(frozen=True, eq=False)
class ThermalModel:
    """
    A steady model, one of three dynamics, an offset of the sensor, and effects.

    Parameters
    ----------
    steady_model : SteadyModel
    dynamics : str
    effects : tuple of Effect
    base : dict, optional
        Coefficients of the model without effects, with which it gives the effects
        the temperature of the module, ``temp_base``.
    held : dict
        Coefficients that a fit leaves as they are.
    """

    steady_model: SteadyModel
    dynamics: str
    effects: tuple = ()
    base: Mapping | None = None
    held: Mapping = field(default_factory=dict)

    def __post_init__(self):
        if self.dynamics not in MEMORY:
            raise ValueError(
                f"unknown dynamics {self.dynamics!r}; they are {', '.join(MEMORY)}"
            )

    @property
    def parameters(self):
        """Rows of all fitted parameters, bias last."""
        rows = {**self.steady_model.parameters, **MEMORY[self.dynamics]}
        for effect in self.effects:
            rows |= effect.rows()
        return {**rows, "bias": BIAS}

    @property
    def constants(self):
        """Constants of the steady model, as they are held or by default."""
        names = self.steady_model.constants
        held = {name: value for name, value in self.held.items() if name in names}
        return {**self.steady_model.fixed, **held}

    @property
    def free(self):
        """Names of the parameters that a fit varies, bias last."""
        return [name for name in self.parameters if name not in self.held]

    @property
    def drivers(self):
        """Measured columns that the effects need beside the usual three."""
        return needed_for(self.effect_drivers)

    @property
    def effect_drivers(self):
        """Drivers of the effects, measured or derived."""
        return [name for effect in self.effects for name in effect.drivers]

    def with_drivers(self, inputs):
        """The inputs with what is derived from them for the effects."""
        needed = {*MODELLED} & {*behind(self.effect_drivers)}
        if not needed <= {*inputs.columns}:
            inputs = self.with_base(inputs, needed)
        return completed(inputs, self.effect_drivers)

    def with_base(self, inputs, needed=MODELLED):
        """
        The inputs with the module's temperature and loss by the base, once.

        Effects that grow with the module's own temperature take that without
        effects, at fixed coefficients: so they stay linear in their parameters.
        """
        if {*needed} <= {*inputs.columns}:
            return inputs
        if self.base is None:
            raise ValueError(
                f"the effects need {' and '.join(sorted(needed))}, and the model has "
                "no base; give it the coefficients of the model without effects as "
                "base="
            )
        plain = ThermalModel(self.steady_model, self.dynamics)
        base = self.completed(self.base)
        own = {name: base[name] for name in self.steady_model.coefficients}
        loss = 1.0 / self.steady_model.resistance(inputs["wind_speed"], **own)
        found = dict(zip(MODELLED, (plain.temperature(inputs, base), loss)))
        return replace(inputs, columns={**inputs.columns, **found})

    def completed(self, coefficients):
        """Coefficients with those that have a default."""
        tau = INSTANT if self.dynamics == "steady" else TAU
        return {**self.constants, "tau": tau, "bias": 0.0, **coefficients}

    def checked(self, coefficients):
        """The same, if they are those of this model and can be."""
        complete = self.completed(coefficients)
        steady = self.steady_model
        needed = [*self.parameters, *steady.constants]
        known = [*needed, *MEMORY["ewm"]]
        if unknown := [name for name in coefficients if name not in known]:
            raise ValueError(
                f"{steady.name}, {self.dynamics} has no coefficient "
                f"{', '.join(unknown)}; it has {', '.join(known)}"
            )
        if missing := [name for name in needed if name not in complete]:
            raise ValueError(f"{steady.name} needs {', '.join(missing)}")
        steady.complete({n: complete[n] for n in steady.coefficients})
        if self.dynamics == "steady" and complete["tau"] != INSTANT:
            raise ValueError(
                f"tau = {complete['tau']:g} s is given, and dynamics='steady' has no "
                "memory; drop it, or take dynamics='ewm'"
            )
        for name, row in MEMORY[self.dynamics].items():
            if not (np.isscalar(complete[name]) and complete[name] > 0):
                raise ValueError(
                    f"{name} = {complete[name]} must be a positive number [{row.unit}]"
                )
        return complete

    def predict(self, poa_global, temp_air, wind_speed, coefficients, **drivers):
        """
        Module temperature; without a tau the default, without a bias none. [°C]

        What no sensor can have measured is missing, and negative irradiance is none,
        as in a fit.
        """
        drivers = {ALIASES.get(name, name): column for name, column in drivers.items()}
        self.check_drivers(drivers)
        coefficients = self.checked(coefficients)
        columns = {
            "poa_global": poa_global,
            "temp_air": temp_air,
            "wind_speed": wind_speed,
            **drivers,
        }
        inputs = as_in_a_fit(read(columns, purpose="a dynamic temperature"))
        # without a base its own coefficients are those of the model without effects
        based = self if self.base else replace(self, base=coefficients)
        inputs = based.with_drivers(inputs)
        own = {n: coefficients[n] for n in self.steady_model.coefficients}
        losing(self.steady_model, inputs["wind_speed"], own)
        found = self.temperature(inputs, coefficients)
        # what follows from a gap in a driver may be a number, and is not known
        known = np.all([np.isfinite(inputs[name]) for name in columns], axis=0)
        return inputs.restore(np.where(known, found, np.nan))

    def check_drivers(self, given):
        """Refuse drivers that lack, or that nothing uses."""
        if missing := [name for name in self.drivers if name not in given]:
            using = [
                effect.name
                for effect in self.effects
                if set(missing) & set(needed_for(effect.drivers))
            ]
            place = "; pvlib_fem.drivers.sun finds the sun"
            raise ValueError(
                f"data lack {', '.join(missing)}, which {' and '.join(using)} "
                f"need{'s' * (len(using) == 1)}; give "
                f"{'it' if len(missing) == 1 else 'them'} as "
                f"{', '.join(f'{name}=...' for name in missing)}, or drop the effect"
                f"{'s' * (len(using) > 1)}"
                f"{place if 'solar_zenith' in missing else ''}"
            )
        if unused := [name for name in given if name not in self.drivers]:
            raise ValueError(
                f"no effect uses {', '.join(unused)}; the effects use "
                f"{', '.join(self.drivers) or 'no further column'}"
            )

    def temperature(self, inputs, coefficients):
        """Module temperature of checked inputs, all coefficients given. [°C]"""
        return self.slopes(inputs, coefficients, wanted=False)[0]

    def slopes(self, inputs, coefficients, wanted=True, also=None):
        """
        Module temperature and its slope by each parameter, where ``wanted``.

        ``also`` holds slopes of terms by name, of effects that add nothing yet;
        they are answered along.

        Everything that is known adds to the four columns of the equation, and
        so do the slopes of what is known: the dynamics answers both alike. The
        slopes obey the recursion of the temperature itself, with another
        right-hand side, so each costs one more solve.
        """
        added = Terms(heat=inputs["poa_global"], offset=coefficients["bias"])
        slopes = {"bias": Terms(offset=1.0)} if wanted else {}
        slopes |= also or {}
        for effect in self.effects:
            added = added.plus(effect.at(inputs.columns, coefficients))
            if wanted:
                slopes |= effect.slopes(inputs.columns, coefficients)
        own = {n: coefficients[n] for n in self.steady_model.coefficients}
        if self.dynamics == "steady":
            temperature, slopes = steady(self.steady_model, own, inputs, added, slopes)
        elif self.dynamics == "ewm":
            tau = coefficients["tau"]
            temperature, slopes = smoothed(
                self.steady_model, own, inputs, added, slopes, tau
            )
        else:
            added = added.plus(Terms(capacity=coefficients["capacity"]))
            if wanted:
                slopes["capacity"] = Terms(capacity=1.0)
            temperature, slopes = balanced(
                self.steady_model, own, inputs, added, slopes
            )
        rows = len(temperature)
        return temperature + added.offset, {
            name: np.broadcast_to(slope, rows) for name, slope in slopes.items()
        }


def as_in_a_fit(inputs):
    """Inputs as a fit takes them, with a warning of what cannot be."""
    columns, said = dict(inputs.columns), []
    for name, values in inputs.columns.items():
        outside = out_of_range(name, values)
        if outside.any():
            at, unit = int(np.argmax(outside)), possible(name)[2]
            said.append(
                f"{name} holds {outside.sum()} values that cannot be, first "
                f"{values[at]:g} {unit} at {at_time(inputs.index, at)}"
            )
            columns[name] = np.where(outside, np.nan, values)
    if said:
        warnings.warn(
            f"{'; '.join(said)}: such rows have no temperature. Replace the values "
            "with NaN",
            stacklevel=4,
        )
    columns["poa_global"] = np.maximum(columns["poa_global"], 0.0)
    return replace(inputs, columns=columns)


def thermal_model(model, dynamics, effects=(), base=None, held=None):
    """The thermal model of that name, which a fit can take."""
    if callable(model):
        raise ValueError(
            "a fit needs the slopes of the model, so it takes a name and no "
            f"callable: {', '.join(STEADY_MODELS)}; translate() gives the "
            "coefficients of other models"
        )
    return ThermalModel(steady_model(model), dynamics, tuple(effects), base, held or {})


def resistance(steady_model, own, wind, loss):
    """Resistance with further losses, and the share that they leave of the model's."""
    r_steady = steady_model.resistance(wind, **own)
    if not is_there(loss):
        return r_steady, 1.0
    # 1/(1/r + loss); where a loss would be negative there is no temperature
    share = 1.0 / (1.0 + loss * r_steady)
    share = np.where(share > 0, share, np.nan)
    return r_steady * share, share


def resistance_slopes(steady_model, own, wind, r_eq, share):
    """Slopes of a resistance: by the model's parameters and wind, by further losses."""
    slopes = steady_model.slopes(wind, **own)
    if is_there(share - 1.0):
        slopes = {name: slope * share**2 for name, slope in slopes.items()}
    return slopes, -(r_eq**2)


def steady(steady_model, own, inputs, added, slopes):
    """T = T_air + heat·r_eq."""
    wind = inputs["wind_speed"]
    r_eq, share = resistance(steady_model, own, wind, added.loss)
    temperature = inputs["temp_air"] + added.heat * r_eq
    if not slopes:
        return temperature, {}
    by_steady, by_loss = resistance_slopes(steady_model, own, wind, r_eq, share)
    found = {name: added.heat * by_steady[name] for name in steady_model.parameters}
    for name, slope in slopes.items():
        found[name] = slope.offset
        if is_there(slope.heat):
            found[name] = found[name] + slope.heat * r_eq
        if is_there(slope.loss):
            found[name] = found[name] + added.heat * by_loss * slope.loss
    return temperature, found


def smoothed(steady_model, own, inputs, added, slopes, tau):
    """The paper's form: the steady model on smoothed heat and wind."""
    tau = tau / inputs.unit

    def smooth(column, whole=0.0):
        """A column and its slope by tau; a part has the gaps of the whole."""
        if np.ndim(column) == 0:
            return column, 0.0
        if not slopes:
            return relax(column, inputs.steps, tau), 0.0
        return relax_slope(column + 0.0 * whole, inputs.steps, tau)

    heat, heat_by_tau = smooth(added.heat)
    wind, wind_by_tau = smooth(inputs["wind_speed"])
    loss, loss_by_tau = smooth(added.loss)
    r_eq, share = resistance(steady_model, own, wind, loss)
    temperature = inputs["temp_air"] + heat * r_eq
    if not slopes:
        return temperature, {}
    by_steady, by_loss = resistance_slopes(steady_model, own, wind, r_eq, share)
    found = {name: heat * by_steady[name] for name in steady_model.parameters}
    r_by_tau = by_steady["wind_speed"] * wind_by_tau
    if is_there(loss):
        r_by_tau = r_by_tau + by_loss * loss_by_tau
    found["tau"] = (heat_by_tau * r_eq + heat * r_by_tau) / inputs.unit
    for name, slope in slopes.items():
        found[name] = slope.offset
        if is_there(slope.heat):
            found[name] = found[name] + smooth(slope.heat, added.heat)[0] * r_eq
        if is_there(slope.loss):
            part = smooth(slope.loss, added.loss)[0]
            found[name] = found[name] + heat * by_loss * part
    return temperature, found


def balanced(steady_model, own, inputs, added, slopes):
    """The exact heat balance, whose time constant is capacity·r_eq."""
    wind = inputs["wind_speed"]
    r_eq, share = resistance(steady_model, own, wind, added.loss)
    target = inputs["temp_air"] + added.heat * r_eq
    tau = added.capacity / inputs.unit * r_eq
    valid = np.flatnonzero(~np.isnan(target))
    rows, steps = len(target), inputs.steps
    if len(valid) < rows:
        steps = across(steps, valid)

    def there(column):
        """The valid rows of a column, or the number that serves all."""
        return column if np.ndim(column) == 0 or len(valid) == rows else column[valid]

    def spread(column):
        if len(valid) == rows:
            return column
        result = np.full(rows, np.nan)
        result[valid] = column
        return result

    target, tau, r_eq = there(target), there(tau), there(r_eq)
    decay = decays(steps, tau, len(target))
    band, rise = banded(decay), 1.0 - decay
    temperature = solve(band, rise * target)
    if not slopes:
        return spread(temperature), {}
    if len(valid) < rows:
        wind, share = there(wind), there(share)
    by_steady, by_loss = resistance_slopes(steady_model, own, wind, r_eq, share)
    # slope of the decay by ln(tau), times what of the past is left to decay
    fading = (before(temperature) - target) * decay * (steps / tau)
    by_r = rise * there(added.heat) + fading / r_eq  # what r_eq moves, in all

    found = {
        name: spread(solve(band, by_r * by_steady[name]))
        for name in steady_model.parameters
    }
    for name, slope in slopes.items():
        found[name] = slope.offset
        source = 0.0
        if is_there(slope.heat):
            source = source + rise * r_eq * there(slope.heat)
        if is_there(slope.loss):
            source = source + by_r * by_loss * there(slope.loss)
        if is_there(slope.capacity):
            source = source + fading * there(slope.capacity / added.capacity)
        if np.ndim(source):
            found[name] = found[name] + spread(solve(band, source))
    return spread(temperature), found
