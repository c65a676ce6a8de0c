"""The dynamics: the response of a block of rows to the columns of the equation."""

from typing import Any

import numpy as np

from pvlib_fem._record.inputs import Inputs
from pvlib_fem._thermal.response import Past, Response
from pvlib_fem._thermal.steady_models import SteadyModel
from pvlib_fem.effects._effect import Terms, is_there

#: capacity [J/(m² K)] or time constant [unit of the steps] that is as good as none
NONE = 1e-6


def resistance(
    steady_model: SteadyModel, own: dict, wind: float | np.ndarray, loss: Any
) -> tuple:
    """
    Resistance with further losses, and its ratio to that of the steady model.

    Parameters
    ----------
    steady_model : SteadyModel
    own : dict
        Coefficients of the steady model.
    wind : float or array, shape (rows,)
        [m/s]
    loss : float or array, shape (rows,)
        Added to the loss of the steady model. [W/(m² K)]

    Returns
    -------
    r_eq : float or array, shape (rows,)
        NaN where the total loss is not positive. [K m²/W]
    share : float or array, shape (rows,)
        [-]
    """
    r_steady = steady_model.resistance(wind, **own)
    if not is_there(loss):
        return r_steady, 1.0
    # 1/(1/r + loss); where the total loss would be negative, the temperature is NaN
    share = 1.0 / (1.0 + loss * r_steady)
    share = np.where(share > 0, share, np.nan)
    return r_steady * share, share


def at_least_none(memory: float | np.ndarray) -> float | np.ndarray:
    """A capacity or a time constant, of which an effect takes no more than there is."""
    return np.maximum(memory, NONE) if np.ndim(memory) else memory


def resistance_slopes(
    steady_model: SteadyModel,
    own: dict,
    wind: Any,
    r_eq: float | np.ndarray,
    share: float | np.ndarray,
) -> tuple:
    """Slopes of a resistance by the model's parameters and wind, and by the loss."""
    slopes = steady_model.slopes(wind, **own)
    if is_there(share - 1.0):
        slopes = {name: slope * share**2 for name, slope in slopes.items()}
    return slopes, -(r_eq**2)


def steady(
    steady_model: SteadyModel, own: dict, inputs: Inputs, added: Terms, slopes: dict
) -> tuple[np.ndarray, dict]:
    """
    Temperature without memory, ``T = T_air + heat·r_eq``.

    Parameters
    ----------
    steady_model : SteadyModel
    own : dict
        Coefficients of the steady model.
    inputs : Inputs
        With ``temp_air`` and ``wind_speed``.
    added : Terms
        All terms of the equation, with the irradiance in ``heat``.
    slopes : dict of Terms
        Slopes of the terms by name; empty if no slopes are needed.

    Returns
    -------
    temperature : array, shape (rows,)
        Of the module, without ``gain`` and ``offset`` of the sensor. [°C]
    slopes : dict of float or array, shape (rows,)
        By parameter of the steady model, and by name of ``slopes``. [K per unit]
    """
    wind = inputs["wind_speed"]
    r_eq, share = resistance(steady_model, own, wind, added.loss)
    temperature = inputs["temp_air"] + added.heat * r_eq
    if not slopes:
        return temperature, {}
    by_steady, by_loss = resistance_slopes(steady_model, own, wind, r_eq, share)
    partials = {name: added.heat * by_steady[name] for name in steady_model.parameters}
    for name, slope in slopes.items():
        partials[name] = 0.0
        if is_there(slope.heat):
            partials[name] = partials[name] + slope.heat * r_eq
        if is_there(slope.loss):
            partials[name] = partials[name] + added.heat * by_loss * slope.loss
    return temperature, partials


class Smooth:
    """A column and its parts, smoothed with one time constant."""

    def __init__(
        self, name: str, whole: Any, steps: Any, tau: Any, past: Past, wanted: bool
    ) -> None:
        self.value, self.whole = whole, whole
        self.source: Any = None
        self.name, self.given = name, (steps, tau, past)
        if np.ndim(whole) == 0:
            return
        self.answer = answer = Response(name, whole, steps, tau, past)
        there = answer.known_rows(whole)
        smooth = answer.mean("value", there)
        self.value = answer.on_all_rows(smooth)
        if wanted:
            # slope by the logarithm of tau: the distance that is still to decay
            source = answer.source_by_log_tau("value", smooth, there)
            source /= answer.tau
            self.source = source

    def slope(self, name: str, by: np.ndarray | float) -> np.ndarray | float:
        """Slope by what the time constant of each row has a slope by."""
        if self.source is None:
            return 0.0
        source = self.source * self.answer.known_rows(by)
        return self.answer.on_all_rows(self.answer.solve(name, source))

    def part(self, name: str, column: np.ndarray) -> np.ndarray:
        """A part of the column, smoothed; its gaps are those of the whole column."""
        if np.ndim(column) == 0:
            return column
        if np.ndim(self.whole) == 0:
            answer = Response(f"{self.name} {name}", column, *self.given)
            return answer.on_all_rows(answer.mean(name, answer.known_rows(column)))
        return self.answer.on_all_rows(
            self.answer.mean(name, self.answer.known_rows(column))
        )


def longer(seconds: np.ndarray, unit: float) -> np.ndarray:
    """What a capacity adds to a time constant, in units: nothing without wind."""
    return np.nan_to_num(seconds) / unit


def smoothed(
    steady_model: SteadyModel,
    own: dict,
    inputs: Any,
    added: Any,
    slopes: dict,
    tau: float,
    past: Past,
) -> tuple[np.ndarray, dict]:
    """
    Temperature of the paper's form: the steady model on smoothed heat and wind.

    A capacity that an effect adds is divided by the loss of the steady model and adds
    to the time constant.

    Parameters
    ----------
    steady_model : SteadyModel
    own : dict
        Coefficients of the steady model.
    inputs : Inputs
        A block of rows with ``temp_air`` and ``wind_speed``.
    added : Terms
        All terms of the equation, with the irradiance in ``heat``.
    slopes : dict of Terms
        Slopes of the terms by name; empty if no slopes are needed.
    tau : float
        Time constant. [s]
    past : Past
        State before the block; it is updated to the end of the block.

    Returns
    -------
    temperature : array, shape (rows,)
        Of the module, without ``gain`` and ``offset`` of the sensor. [°C]
    slopes : dict of float or array, shape (rows,)
        By parameter of the steady model, by ``tau``, and by name of ``slopes``. [K per
        unit]
    """
    raw = inputs["wind_speed"]
    taus: float | np.ndarray = tau / inputs.unit
    if is_there(added.capacity):
        r_steady = steady_model.resistance(raw, **own)
        taus = at_least_none(taus + longer(added.capacity * r_steady, inputs.unit))
    given = inputs.steps, taus, past, bool(slopes)
    heat = Smooth("heat", added.heat, *given)
    wind = Smooth("wind", raw, *given)
    loss = Smooth("loss", added.loss, *given)
    r_eq, share = resistance(steady_model, own, wind.value, loss.value)
    temperature = inputs["temp_air"] + heat.value * r_eq
    if not slopes:
        return temperature, {}
    by_steady, by_loss = resistance_slopes(steady_model, own, wind.value, r_eq, share)
    partials = {name: heat.value * by_steady[name] for name in steady_model.parameters}

    def slope_by_tau(name: str, by: float | np.ndarray) -> np.ndarray:
        """Slope by what the time constants have a slope by."""
        r_by_tau = by_steady["wind_speed"] * wind.slope(name, by)
        if is_there(added.loss):
            r_by_tau = r_by_tau + by_loss * loss.slope(name, by)
        return heat.slope(name, by) * r_eq + heat.value * r_by_tau

    partials["tau"] = slope_by_tau("tau", 1.0 / inputs.unit)
    if is_there(added.capacity):
        for name, slope in steady_model.slopes(raw, **own).items():
            if name in partials:
                by = longer(added.capacity * slope, inputs.unit)
                partials[name] = partials[name] + slope_by_tau(f"tau {name}", by)
    for name, slope in slopes.items():
        partials[name] = 0.0
        if is_there(slope.heat):
            partials[name] = partials[name] + heat.part(name, slope.heat) * r_eq
        if is_there(slope.loss):
            felt = loss.part(name, slope.loss)
            partials[name] = partials[name] + heat.value * by_loss * felt
        if is_there(slope.capacity):
            r_steady = steady_model.resistance(raw, **own)
            by = longer(slope.capacity * r_steady, inputs.unit)
            partials[name] = partials[name] + slope_by_tau(f"tau {name}", by)
    return temperature, partials


def balanced(
    steady_model: SteadyModel,
    own: dict,
    inputs: Any,
    added: Terms,
    slopes: dict,
    past: Any,
) -> tuple[np.ndarray, dict]:
    """
    Temperature by the exact heat balance; its time constant is capacity·r_eq.

    Parameters
    ----------
    steady_model : SteadyModel
    own : dict
        Coefficients of the steady model.
    inputs : Inputs
        A block of rows with ``temp_air`` and ``wind_speed``.
    added : Terms
        All terms of the equation, with the irradiance in ``heat`` and a positive
        ``capacity``.
    slopes : dict of Terms
        Slopes of the terms by name; empty if no slopes are needed.
    past : Past
        State before the block; it is updated to the end of the block.

    Returns
    -------
    temperature : array, shape (rows,)
        Of the module, without ``gain`` and ``offset`` of the sensor. [°C]
    slopes : dict of float or array, shape (rows,)
        By parameter of the steady model, and by name of ``slopes``. [K per unit]
    """
    wind = inputs["wind_speed"]
    r_eq, share = resistance(steady_model, own, wind, added.loss)
    target = inputs["temp_air"] + added.heat * r_eq
    capacity = at_least_none(added.capacity)
    tau = capacity / inputs.unit * r_eq
    answer = Response("balance", target, inputs.steps, tau, past)
    there = answer.known_rows
    target, r_eq = there(target), there(r_eq)
    temperature = answer.mean("temperature", target)
    if not slopes:
        return answer.on_all_rows(temperature), {}
    by_steady, by_loss = resistance_slopes(
        steady_model, own, there(wind), r_eq, there(share)
    )
    fall = answer.source_by_log_tau("temperature", temperature, target)
    by_r = answer.rise * there(added.heat) + fall / r_eq  # slope of the source by r_eq

    def solved(name: str, source: Any) -> np.ndarray:
        return answer.on_all_rows(answer.solve(name, source))

    partials: dict[str, Any] = {
        name: solved(name, by_r * by_steady[name]) for name in steady_model.parameters
    }
    for name, slope in slopes.items():
        partials[name] = 0.0
        source = 0.0
        if is_there(slope.heat):
            source = source + answer.rise * r_eq * there(slope.heat)
        if is_there(slope.loss):
            source = source + by_r * by_loss * there(slope.loss)
        if is_there(slope.capacity):
            source = source + fall * there(slope.capacity / capacity)
        if np.ndim(source):
            partials[name] = partials[name] + solved(name, source)
    return answer.on_all_rows(temperature), partials
