"""A thermal model: a steady model, effects, and the dynamics that solve it."""

import warnings
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.checks import at_time, is_number
from pvlib_fem._record.column_names import (
    COLUMNS,
    by_own_names,
    filled_from,
    known_values,
    twin_of,
)
from pvlib_fem._record.inputs import Inputs, read
from pvlib_fem._record.ranges import range_of
from pvlib_fem._relaxation import usual_step
from pvlib_fem._spelling import argument, no_columns, refusal
from pvlib_fem._thermal.compiled import solve_compiled, uses_compiled_loops
from pvlib_fem._thermal.dynamics import balanced, resistance, smoothed, steady
from pvlib_fem._thermal.response import Past
from pvlib_fem._thermal.steady_models import STEADY_MODELS, SteadyModel, steady_model
from pvlib_fem._thermal.temperature import TAU, checked_resistance
from pvlib_fem.drivers import (
    MODELLED,
    derive_drivers,
    drivers_with_memory,
    needed_for,
    underived,
)
from pvlib_fem.effects._effect import (
    Effect,
    Parameter,
    Terms,
    is_there,
    with_known_terms,
)
from pvlib_fem.quality._outliers import out_of_range

# rows that are solved at a time, with slopes or without: they stay in the cache
BLOCK, ALONE = 1 << 14, 1 << 16
#: time constant that stands for a steady model: shorter than any logger's step
INSTANT = 1e-9  # s

#: the parameter that each dynamics adds to those of the steady model
MEMORY = {
    "steady": {},
    "ewm": {"tau": Parameter(TAU, 1.0, 7200.0, "s")},
    "balance": {"capacity": Parameter(12e3, 50.0, 1e6, "J/(m² K)")},
}


BIAS = Parameter(0.0, -30.0, 30.0, "K")
WIND, ROSS = "wind_speed", argument("model", "ross")


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
        Coefficients of the model without effects. From them follow the temperature of
        the module, ``temp_base``, and its loss, ``loss_base``, that effects use.
    held : dict
        Coefficients that a fit does not vary.
    """

    steady_model: SteadyModel
    dynamics: str
    effects: tuple = ()
    base: Mapping | None = None
    held: Mapping = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.dynamics not in MEMORY:
            raise ValueError(
                f"unknown dynamics {self.dynamics!r}; they are {', '.join(MEMORY)}"
            )

    @property
    def parameters(self) -> dict[str, Parameter]:
        """Rows of all fitted parameters, bias last."""
        rows = {**self.steady_model.parameters, **MEMORY[self.dynamics]}
        for effect in self.effects:
            rows |= effect.rows()
        return {**rows, "bias": BIAS}

    @property
    def constants(self) -> dict:
        """Constants of the steady model: held values, or defaults."""
        names = self.steady_model.constants
        held = {name: value for name, value in self.held.items() if name in names}
        return {**self.steady_model.fixed, **held}

    @property
    def free(self) -> list[str]:
        """Names of the parameters that a fit varies, bias last."""
        return [name for name in self.parameters if name not in self.held]

    @property
    def drivers(self) -> list[str]:
        """Measured columns that the effects need in addition to the usual three."""
        return needed_for(self.effect_drivers)

    @property
    def usual(self) -> tuple[str, ...]:
        """The usual drivers on which the model depends; wind is not always one."""
        takes = self.steady_model.takes_wind or WIND in underived(self.effect_drivers)
        return tuple(name for name in COLUMNS[:3] if takes or name != WIND)

    @property
    def effect_drivers(self) -> list[str]:
        """Drivers of the effects, measured or derived."""
        return [name for effect in self.effects for name in effect.drivers]

    def with_drivers(self, inputs: Inputs) -> Any:
        """The inputs, completed by the derived columns that the effects need."""
        needed = {*MODELLED} & {*underived(self.effect_drivers)}
        if not needed <= {*inputs.columns}:
            inputs = self.with_base(inputs, needed)
        return derive_drivers(inputs, self.effect_drivers)

    def with_base(self, inputs: Inputs, needed: Any = MODELLED) -> Any:
        """
        The inputs, completed by columns of the base model, unless they are there.

        Effects that grow with the module's own temperature use the temperature of the
        base model, whose coefficients are fixed. So they are linear in their
        parameters.
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
        temperature = plain.temperature(inputs, self.completed(self.base))
        return self.based(inputs, temperature, needed)

    def based(self, inputs: Inputs, temperature: Any, needed: Any = MODELLED) -> Any:
        """The inputs, completed by a temperature of the base model and its losses."""
        base = self.completed(self.base)
        wind, own = inputs["wind_speed"], self.steady_coefficients(base)
        loss = 1.0 / self.steady_model.resistance(wind, **own)
        inputs = inputs.having({"temp_base": temperature, "loss_base": loss})
        if "capacity_base" in needed:
            capacity = base["tau"] * loss  # of one time constant in any wind
            if self.dynamics == "balance":
                capacity = np.full(len(inputs.index), base["capacity"])
            inputs = inputs.having({"capacity_base": capacity})
        if "air_base" not in needed:
            return inputs
        return inputs.having({"air_base": self.air_base(inputs, base)})

    def air_base(self, inputs: Inputs, base: Any) -> Any:
        """
        Heat per K of warmer air, all else equal. [W/(m² K)]

        This is the loss less a part that effects of the base compensate: the longwave
        deficit of the sky grows with the air temperature.
        """
        air, over = inputs["temp_air"], inputs["temp_base"] - inputs["temp_air"]
        others = [
            name for name in inputs.columns if "temp_air" not in underived([name])
        ]
        warmer = inputs.only(others).having({"temp_air": air + 1.0})
        loss, gained = inputs["loss_base"], 0.0
        for effect in self.effects:
            # a constant offset cancels in effects of past minus present air
            past = underived(drivers_with_memory(effect.drivers))
            if (
                effect.sensor_fault
                or "temp_air" in past
                or not {*effect.rows()} <= {*base}
            ):
                continue
            if "temp_air" not in underived(effect.drivers):
                continue
            before, after = (
                effect.at(derive_drivers(these, effect.drivers).columns, base)
                for these in (inputs, warmer)
            )
            gained = gained + after.heat - before.heat
            gained = gained - (after.loss - before.loss) * over
            loss = loss + after.loss
        return loss + gained

    def rebased(self, coefficients: dict) -> "ThermalModel":
        """
        The model with these coefficients as its base, if a fault scales the base.

        A fit without effects absorbs a part of the fault, so a share of its loss would
        be too small. Physical effects need only the module's temperature, which the
        fit without effects gives best, so a model without such faults is returned
        as it is.
        """
        if not any(is_share(effect) for effect in self.effects):
            return self
        rows = [row for e in self.effects if not e.sensor_fault for row in e.rows()]
        names = dict.fromkeys([*self.base, *rows])
        return replace(self, base={name: coefficients[name] for name in names})

    def completed(self, coefficients: Any) -> Any:
        """The coefficients, completed by defaults."""
        tau = INSTANT if self.dynamics == "steady" else TAU
        return {**self.constants, "tau": tau, "bias": 0.0, **coefficients}

    def missing(self, coefficients: Mapping) -> list[str]:
        """Names of coefficients that are not given and have no default."""
        complete = self.completed(coefficients)
        needed = (*self.parameters, *self.steady_model.constants)
        return [name for name in needed if name not in complete]

    def checked(self, coefficients: Mapping) -> dict:
        """The completed coefficients; ValueError if one is unknown or impossible."""
        complete = self.completed(coefficients)
        steady = self.steady_model
        needed = [*self.parameters, *steady.constants]
        known = dict.fromkeys([*needed, *MEMORY["ewm"]])
        if unknown := [name for name in coefficients if name not in known]:
            raise ValueError(
                f"{steady.name}, {self.dynamics} has no coefficient "
                f"{', '.join(unknown)}; it has {', '.join(known)}"
            )
        if missing := self.missing(coefficients):
            raise ValueError(f"{steady.name} needs {', '.join(missing)}")
        steady.complete({n: complete[n] for n in steady.coefficients})
        if self.dynamics == "steady":
            refuse_tau(complete["tau"])
        for name, row in MEMORY[self.dynamics].items():
            if not (is_number(complete[name]) and complete[name] > 0):
                raise ValueError(
                    f"{name} = {complete[name]} must be a positive number [{row.unit}]"
                )
        return complete

    def predict(
        self,
        poa_global: pd.Series,
        temp_air: pd.Series,
        wind_speed: Any,
        coefficients: Any,
        **drivers: Any,
    ) -> pd.Series:
        """
        Module temperature; ``tau`` has its default, ``bias`` is 0 if missing. [°C]

        Impossible values count as missing and negative irradiance as zero, as in a
        fit. ``wind_speed`` may be None if nothing depends on it.
        """
        drivers = by_own_names(drivers)
        self.check_drivers(drivers)
        coefficients = self.checked(coefficients)
        if temp_air is None:
            raise ValueError(f"{no_columns(['temp_air'])}; give a Series of it")
        if wind_speed is None:
            self.refuse_without_wind(("poa_global", "temp_air", *drivers))
        columns = {
            "poa_global": poa_global,
            "temp_air": temp_air,
            "wind_speed": 0.0 if wind_speed is None else wind_speed,
            **drivers,
        }
        inputs = as_in_a_fit(read(columns, purpose="a dynamic temperature"))
        # without a base its own coefficients are those of the model without effects
        based = self if self.base else replace(self, base=coefficients)
        inputs = based.with_drivers(inputs)
        own = self.steady_coefficients(coefficients)
        checked_resistance(self.steady_model, inputs["wind_speed"], own)
        temperature = self.temperature(inputs, coefficients)
        # a response in a gap of a driver may be a number, but it is not known
        light = inputs["poa_global"]
        known = [known_values(name, inputs[name], light) for name in columns]
        known = np.all(known, axis=0)
        return inputs.restore(np.where(known, temperature, np.nan))

    def refuse_without_wind(self, columns: Collection) -> None:
        """Refuse columns without wind if something depends on it."""
        if WIND in columns or WIND not in self.usual:
            return
        there = f"they have {', '.join(columns)}"
        if self.steady_model.takes_wind:
            model = self.steady_model.name
            words = f"{no_columns([WIND])}, which the model {model} needs; {there}; "
            words += "give it, or "
            others = [name for name in columns if twin_of(name) == WIND]
            stand = [part for n in others[:1] for part in (filled_from(n), ", or ")]
            raise refusal(words, *stand, ROSS, ", which needs none")
        using = [e.name for e in self.effects if WIND in underived(e.drivers)]
        raise ValueError(
            f"{no_columns([WIND])}, which {' and '.join(using)} need"
            f"{'s' * (len(using) == 1)}; {there}; give it, or drop the effect"
            f"{'s' * (len(using) > 1)}"
        )

    def check_drivers(self, given: dict | list) -> None:
        """Refuse missing drivers, and drivers that no effect uses."""
        if missing := [name for name in self.drivers if name not in given]:
            using = [
                effect.name
                for effect in self.effects
                if set(missing) & set(needed_for(effect.drivers))
            ]
            place = "; pvlib_fem.drivers.sun finds the sun"
            raise ValueError(
                f"{no_columns(missing)}, which {' and '.join(using)} "
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

    def temperature(self, inputs: Inputs, coefficients: dict) -> np.ndarray:
        """Module temperature of checked inputs by a full set of coefficients. [°C]"""
        temperature = np.empty(len(inputs.index))
        block_temperatures = self.in_blocks(inputs, coefficients)
        for block in blocks(len(temperature), ALONE):
            temperature[block] = next(block_temperatures)
        return temperature

    def in_blocks(
        self, inputs: Inputs, coefficients: dict, counts: np.ndarray | None = None
    ) -> Iterator:
        """
        Yield the temperature block by block; each block overwrites the one before.

        The values of rows that do not count are undefined.
        """
        rows, past = len(inputs.index), self.past(inputs)
        model = self.with_known_terms(inputs, coefficients, False)
        quick = uses_compiled_loops(rows, model.effects)
        scratch = np.zeros(min(ALONE, rows))
        for block in blocks(rows, ALONE):
            given, here = (inputs.part(block), coefficients, past), model.on_rows(block)
            temperature = scratch[: len(given[0].index)]
            if quick:
                seen = None if counts is None else (counts[block], np.nan)
                solve_compiled(here, *given, seen, into=temperature)
            else:
                temperature = here.solve_block(*given, wanted=False)[0]
            yield temperature

    def slopes(
        self, inputs: Inputs, coefficients: dict, wanted: bool = True, also: Any = None
    ) -> tuple[np.ndarray, dict]:
        """
        Module temperature and its slope by each parameter, where ``wanted``.

        ``also`` holds slopes of terms by name, of effects that add nothing yet; the
        responses to them are returned, too. The record is solved in blocks of rows,
        whose temporaries stay in the cache.
        """
        rows = len(inputs.index)
        temperature, slopes = np.empty(rows), {}
        model = self.with_known_terms(inputs, coefficients, wanted)
        past, one_pass = self.past(inputs), also is not None and not wanted
        if one_pass and uses_compiled_loops(rows, model.effects, also):
            given = inputs, coefficients, past
            responses = solve_compiled(model, *given, into=temperature, also=also)
            offset = model.terms(inputs, coefficients, wanted=False)[0].offset
            over = temperature - offset - inputs["temp_air"]
            return temperature, {
                name: as_read(answer, Terms(gain=also[name].gain), 0.0, over)
                for name, answer in zip(also, responses)
            }
        for block in blocks(rows):
            part, more = inputs.part(block), also and terms_on_rows(also, block)
            here = model.on_rows(block)
            given = part, coefficients, past, wanted, more
            temperature[block], block_slopes = here.solve_block(*given)
            for name, slope in block_slopes.items():
                if name not in slopes:
                    slopes[name] = np.empty(rows)
                slopes[name][block] = slope
        return temperature, slopes

    def time_constant(self, coefficients: Mapping, wind_speed: Any) -> Any:
        """Time constant without effects, of the balance at each wind. [s]"""
        complete = self.completed(coefficients)
        if self.dynamics != "balance":
            return complete["tau"]
        own = self.steady_coefficients(complete)
        return complete["capacity"] * self.steady_model.resistance(wind_speed, **own)

    def longest_time_constant(self, inputs: Inputs, coefficients: dict) -> float:
        """Longest time constant of any row. [s]"""
        added = self.terms(inputs, coefficients, wanted=False)[0]
        wind, own = inputs["wind_speed"], self.steady_coefficients(coefficients)
        if self.dynamics == "balance":
            r_eq, _ = resistance(self.steady_model, own, wind, added.loss)
            taus = (added.capacity + coefficients["capacity"]) * r_eq
        else:
            r_steady = self.steady_model.resistance(wind, **own)
            taus = coefficients.get("tau", 0.0) + added.capacity * r_steady
        return float(np.nanmax(taus, initial=0.0))

    def with_known_terms(
        self, inputs: Inputs, coefficients: dict, wanted: bool = True
    ) -> "ThermalModel":
        """The model with the terms of its effects computed on a record's columns."""
        given = inputs.columns, coefficients, wanted
        effects = tuple(with_known_terms(effect, *given) for effect in self.effects)
        return replace(self, effects=effects) if effects else self

    def on_rows(self, rows: Any) -> "ThermalModel":
        """The model with the terms of its effects cut to a slice of the record."""
        effects = tuple(effect.on_rows(rows) for effect in self.effects)
        return replace(self, effects=effects) if effects else self

    def past(self, inputs: Any) -> Past:
        """The state before the first row of a record."""
        names = (*COLUMNS[:3], *self.drivers)
        if names not in inputs.cache:
            columns = [*inputs.columns.only(names).given.values()]
            inputs.cache[names] = usual_step(columns, inputs.steps)
        return Past(inputs.cache[names])

    def solve_block(
        self,
        inputs: Inputs,
        coefficients: dict,
        past: Past,
        wanted: bool = True,
        also: Any = None,
    ) -> tuple[np.ndarray, dict]:
        """
        Temperature and slopes of a block of rows, continued from the block before.

        Inputs and effects add to the five columns of the equation, and so do their
        slopes. The dynamics solves both alike: a slope obeys the recursion of the
        temperature with another right-hand side, so each costs one more solve.

        Parameters
        ----------
        inputs : Inputs
            Inputs of the block; its first step starts at the last row before it.
        coefficients : dict
            All coefficients of the model.
        past : Past
            State at the end of the block before; it is updated to the end of this one.
        wanted : bool
            Whether slopes by the parameters are computed.
        also : dict of Terms, optional
            Slopes of further terms; the responses to them are computed, too.
        """
        added, slopes = self.terms(inputs, coefficients, wanted, also)
        law, own = self.steady_model, self.steady_coefficients(coefficients)
        if self.dynamics == "steady":
            temperature, answers = steady(law, own, inputs, added, slopes)
        elif self.dynamics == "ewm":
            given = added, slopes, coefficients["tau"], past
            temperature, answers = smoothed(law, own, inputs, *given)
        else:
            added = added.plus(Terms(capacity=coefficients["capacity"]))
            if wanted:
                slopes["capacity"] = Terms(capacity=1.0)
            temperature, answers = balanced(law, own, inputs, added, slopes, past)
        over = temperature - inputs["temp_air"]
        return temperature + added.gain * over + added.offset, {
            name: as_read(answer, slopes.get(name), added.gain, over)
            for name, answer in answers.items()
        }

    def terms(
        self, inputs: Inputs, coefficients: dict, wanted: bool = True, also: Any = None
    ) -> tuple[Terms, dict]:
        """The columns of the equation, and their slopes where ``wanted``."""
        added = Terms(heat=inputs["poa_global"], offset=coefficients["bias"])
        slopes = {"bias": Terms(offset=1.0)} if wanted else {}
        slopes |= also or {}
        for effect in self.effects:
            added = added.plus(effect.at(inputs.columns, coefficients))
            if wanted:
                slopes |= effect.slopes(inputs.columns, coefficients)
        return added, slopes

    def steady_coefficients(self, coefficients: dict) -> dict[str, float]:
        """The coefficients of the steady model among some coefficients."""
        return {name: coefficients[name] for name in self.steady_model.coefficients}


def refuse_tau(tau: float) -> None:
    """
    Refuse a time constant of a model without memory.

    Parameters
    ----------
    tau : float
        The usual one near 0 stands for none. [s]

    Raises
    ------
    ValueError
        If it is another.
    """
    if tau != INSTANT:
        raise ValueError(
            f"tau = {tau:g} s is given, and dynamics='steady' has no memory; drop it, "
            "or take dynamics='ewm'"
        )


def blocks(rows: int, size: int = BLOCK) -> list[slice]:
    """
    Slices of so many rows, each so short that its columns stay in the cache.

    Parameters
    ----------
    rows : int
        Number of all rows.
    size : int, optional
        Most rows of a block.

    Returns
    -------
    list of slice
    """
    return [slice(start, min(start + size, rows)) for start in range(0, rows, size)]


def terms_on_rows(terms: Any, rows: slice) -> Any:
    """Terms by name on a slice of rows."""
    return {name: column.part(rows) for name, column in terms.items()}


def as_read(
    answer: float | np.ndarray,
    slope: Terms | None,
    gain: float | np.ndarray,
    over: np.ndarray,
) -> Any:
    """The reading of a sensor: the response to a slope, with gain and offset."""
    if is_there(gain):
        answer = answer + gain * answer
    if slope is not None:
        answer = answer + slope.offset
        if is_there(slope.gain):
            answer = answer + slope.gain * over
    return answer


def is_share(effect: Effect) -> bool:
    """Whether an effect scales the loss of the model without effects."""
    shares = {"loss_base", "air_base", "capacity_base"}
    return bool(effect.sensor_fault and shares & {*underived(effect.drivers)})


def as_in_a_fit(inputs: Any) -> Inputs:
    """
    Inputs as a fit takes them, with a warning of impossible values.

    Parameters
    ----------
    inputs : Inputs
        With ``poa_global``.

    Returns
    -------
    Inputs
        Impossible values are NaN, and negative irradiance is 0.

    Warns
    -----
    UserWarning
        Naming columns, number of values, and the first value and its time.
    """
    columns, said = dict(inputs.columns), []
    for name, values in inputs.columns.items():
        outside = out_of_range(name, values)
        if outside.any():
            at, unit = int(np.argmax(outside)), range_of(name).unit
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


def thermal_model(
    model: str,
    dynamics: str,
    effects: Iterable = (),
    base: Any = None,
    held: dict | None = None,
) -> ThermalModel:
    """
    The thermal model with the steady model of that name.

    Parameters
    ----------
    model : str
        Name in :data:`STEADY_MODELS`.
    dynamics : str
        ``"steady"``, ``"ewm"`` or ``"balance"``.
    effects : iterable of Effect, optional
    base : dict, optional
        Coefficients of the model without effects.
    held : dict, optional
        Coefficients that a fit does not vary.

    Returns
    -------
    ThermalModel

    Raises
    ------
    ValueError
        If the model is a callable, or the model or the dynamics are unknown.
    """
    if callable(model):
        raise ValueError(
            "a fit needs the slopes of the model, so it takes a name and no "
            f"callable: {', '.join(STEADY_MODELS)}; translate_coefficients() gives the "
            "coefficients of other models"
        )
    return ThermalModel(steady_model(model), dynamics, tuple(effects), base, held or {})
