"""Coefficients from a shift along the tangents of a fit, also from a large one."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import root

from pvlib_fem._thermal.model import MEMORY, ThermalModel

R_EQ = "r_eq"  # resistance at the mean wind: the best known quantity of a steady model
CLOSE = 1e-9  # relative error of the resistance at which coefficients are accepted


@dataclass(frozen=True, eq=False)
class Minimum:
    """The minimum of a fit, and the coefficients that vary from there."""

    model: ThermalModel
    coefficients: dict
    daily: Any  # DailySums
    names: list
    lag: Any  # search coordinate of the time constant; None without one
    step: float  # [s]

    @property
    def steady(self) -> list:
        return [n for n in self.names if n in self.model.steady_model.parameters]

    @property
    def memory(self) -> list:
        return [n for n in self.names if n in MEMORY[self.model.dynamics]]

    def places_of(self, names: list) -> list:
        """Places of some coefficients in a solution."""
        return [self.names.index(name) for name in names]

    @property
    def units(self) -> Any:
        """Names and units of the table."""
        units = {name: self.model.parameters[name].unit for name in self.names}
        return ({R_EQ: "K m²/W"} if self.steady else {}) | units


def shifted_numbers(minimum: Minimum, shift: np.ndarray) -> Any:
    """
    Numbers of the table by shifts along the tangents, their slopes, and the gain.

    The temperature is linear in the resistance at each wind, not in the coefficients.
    The time constant is still an age, see :func:`in_age`.

    Parameters
    ----------
    minimum : Minimum
        With n coefficients that vary.
    shift : numpy.ndarray, shape (n,)
        Change of each coefficient along the tangents, in its unit.

    Returns
    -------
    value : numpy.ndarray, shape (m,)
        In the order of ``minimum.units``: ``r_eq`` first if a coefficient of the steady
        model varies. NaN if no coefficients have the resistance.
    slopes : numpy.ndarray, shape (m, n)
        Of each number by each shift.
    gain : float
        Ratio of the resistance at the mean wind to that of the minimum. [-]
    """
    own = np.array([minimum.coefficients[name] for name in minimum.names])
    value, slopes, gain = own + shift, np.eye(len(shift)), 1.0
    if minimum.steady:
        at = minimum.places_of(minimum.steady)
        value[at], slopes[np.ix_(at, at)] = in_resistance(minimum, shift[at])
        winds = minimum.daily.winds[:1]
        before, by = (part[0] for part in resistances(minimum, own[at], winds))
        gain = 1.0 + by @ shift[at] / before
        mean = np.zeros(len(shift))
        mean[at] = by
    for name, place in zip(minimum.memory, minimum.places_of(minimum.memory)):
        value[place], slopes[place, place] = in_age(minimum, name, shift[place], gain)
    if minimum.steady:
        value, slopes = np.append(before * gain, value), np.vstack([mean, slopes])
    return value, slopes, gain


def resistances(
    minimum: Minimum, values: np.ndarray, winds: np.ndarray | tuple
) -> tuple[np.ndarray, np.ndarray]:
    """Resistance of the steady model at some winds, and a row of slopes for each."""
    law, winds = minimum.model.steady_model, np.asarray(winds)
    own = {name: minimum.coefficients[name] for name in law.coefficients}
    own |= dict(zip(minimum.steady, values))
    slopes = law.slopes(winds, **own)
    columns = [slopes[name] + 0.0 * winds for name in minimum.steady]
    return law.resistance(winds, **own), np.stack(columns, axis=1)


def in_resistance(minimum: Minimum, shift: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    Coefficients of the steady model by a shift, and their slopes by it.

    The coefficients reproduce the resistance along the tangents at as many winds as
    there are coefficients. So a gain of any size is found exactly.
    """
    mean, spread = minimum.daily.winds
    size = len(shift)
    winds = mean + spread * (np.linspace(-1.0, 1.0, size) if size > 1 else np.zeros(1))
    winds = np.maximum(winds, 0.0)
    start = np.array([minimum.coefficients[name] for name in minimum.steady])
    before, by_shift = resistances(minimum, start, winds)
    wanted = before + by_shift @ shift
    if (wanted > 0.0).all():
        with np.errstate(all="ignore"):
            solution = root(
                lambda x: resistances(minimum, x, winds)[0] / wanted - 1.0,
                start,
                jac=lambda x: resistances(minimum, x, winds)[1] / wanted[:, None],
            )
        # scipy may report no success although the root is found
        if (np.abs(solution.fun) < CLOSE).all():
            slopes = resistances(minimum, solution.x, winds)[1]
            return solution.x, np.linalg.pinv(slopes) @ by_shift
    return np.full(size, np.nan), np.full((size, size), np.nan)


def in_age(
    minimum: Minimum, name: str, shift: float, gain: float
) -> tuple[float, float]:
    """
    Mean age of the past in a sample, and its slope by the shift of the time constant.

    The temperature is linear in the age if it is a small part of the step, and in its
    logarithm if it is many steps.
    """
    before = minimum.coefficients[name]
    start = minimum.lag.to_search(before)
    whole = start + minimum.lag.step
    # the time constant of a capacity scales with the resistance
    shift = shift + before * (gain_of_age(name, gain) - 1.0)
    by_shift = 1.0 / (minimum.lag.slope(start) * gain * whole)
    grown = whole * np.exp(shift * by_shift)
    return grown - minimum.lag.step, grown * by_shift


def gain_of_age(name: str, gain: float) -> float:
    return gain if name == "capacity" else 1.0


def in_time(
    minimum: Minimum, age: float, error: float, low: float, high: float, gain: float
) -> Any:
    """
    The time constant of an age, with its error and an interval from 0 on.

    Parameters
    ----------
    minimum : Minimum
        With one time constant or capacity that varies.
    age : float
        Mean age of the past in a sample, in the unit of ``minimum.lag``.
    error : float
        Standard error of the age.
    low, high : float
        Ends of its interval; below 0 they count as 0.
    gain : float
        Ratio of the resistance to that of the minimum, by which the capacity of an age
        is divided. [-]

    Returns
    -------
    tuple of float
        Value, error, and lower and upper end, in the unit of ``tau`` [s] or
        ``capacity`` [J/(m² K)]. The error is NaN if the interval includes 0; all are
        NaN if the age is unknown.
    """
    (name,), seen = minimum.memory, minimum.lag
    own = gain_of_age(name, gain)
    if np.isnan(age) or not gain > 0:
        return (np.nan,) * 4
    value, lower, upper = (
        seen.from_search(a) / own if a > 0 else 0.0 for a in (age, low, high)
    )
    error = seen.slope(age) * error / own if low > 0 else np.nan
    value = max(value, seen.lower)
    return value, error, lower, max(upper, value)
