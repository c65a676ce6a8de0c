"""The error of coefficients from a wind speed that is recorded in coarse steps."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from pvlib_fem._fitting.daily import directions
from pvlib_fem._fitting.row_source import EvalRequest, Source
from pvlib_fem._thermal.model import WIND, ThermalModel
from pvlib_fem.quality._values import changes

HALF = 0.5  # of an error, from which a note reports what adds to it
FINER = 0.01  # share of changes that may be finer, such as a filled gap
COARSE = 0.25  # m/s, step from which coefficients are looked at
THIRD = 1.0 / 3.0  # of the change by a step twice as wide: 1 of 2² - 1


def recorded_step(wind: np.ndarray) -> float:
    """
    Step in which a wind speed is recorded: its least change, a few left out.

    Parameters
    ----------
    wind : array, shape (rows,)
        [m/s]

    Returns
    -------
    float
        0 if the wind never changes. [m/s]
    """
    change = changes(wind)
    return float(np.quantile(change, FINER, method="lower")) if len(change) else 0.0


def rounding_errors(
    source: Source, model: ThermalModel, coefficients: dict, names: list
) -> tuple[float, dict]:
    """
    Step in which the wind is recorded, and how far it may move each coefficient.

    The shift by rounding grows with the square of the step. So rounding to steps twice
    as wide moves the coefficients by three times as much as the record's own did, the
    extrapolation of Cook and Stefanski (1994, :doi:`10.1080/01621459.1994.10476871`).

    Parameters
    ----------
    source : Source
        The rows of the fit, with the drivers of the model.
    model : ThermalModel
        The fitted model.
    coefficients : dict
        Of all its parameters, at the minimum.
    names : list of str
        Coefficients that vary.

    Returns
    -------
    step : float
        [m/s]
    errors : dict
        Size of the shift of each of the names, in its unit; empty if the step is below
        0.25 m/s or nothing depends on wind.
    """
    step = recorded_step(source.some_wind)
    if WIND not in model.usual or step < COARSE or not names:
        return step, {}
    request = {"": EvalRequest(model, coefficients)}
    sums = Coarser(source, step).sums(request, {"": names})[""]
    shift = THIRD * directions(sums.normal)[0] @ sums.gradient
    return step, dict(zip(names, np.abs(shift).tolist()))


@dataclass(frozen=True, eq=False)
class Coarser(Source):
    """A source with wind in steps twice as wide; odd steps go up or down by chance."""

    source: Source
    step: float  # [m/s]

    def uses_compiled_loops(self, model: ThermalModel) -> bool:
        """Whether the compiled loops can solve a model with known terms."""
        return self.source.uses_compiled_loops(model)

    def parts(self, requests: Any) -> Iterator:
        """Parts of the source; terms of effects keep the wind that they have."""
        random = np.random.default_rng(0)
        for part, given in self.source.parts(requests):
            for key, (model, (inputs, *others)) in given.items():
                wind = inputs[WIND]
                odd = np.rint(wind / self.step) % 2 == 1
                aside = np.where(random.random(len(wind)) < 0.5, -self.step, self.step)
                coarser = inputs.having({WIND: wind + odd * aside})
                given[key] = model, (coarser, *others)
            yield part, given


def with_rounding(
    source: Source,
    model: ThermalModel,
    coefficients: dict,
    stderr: dict,
    notes: list,
) -> dict:
    """
    Standard errors with what coarse steps of the wind add.

    Parameters
    ----------
    source, model, coefficients
        See :func:`rounding_errors`.
    stderr : dict
        Standard errors without it; coefficients that have none keep theirs.
    notes : list of str
        A note that says how much is added is appended.

    Returns
    -------
    dict
    """
    names = [name for name, error in stderr.items() if error > 0.0]
    step, errors = rounding_errors(source, model, coefficients, names)
    rows = model.parameters
    more = [
        f"{name} by {float(f'{error:.2g}'):g} {rows[name].unit.strip('-')}".rstrip()
        for name, error in errors.items()
        if error > HALF * stderr[name]
    ]
    if more:
        notes.append(
            f"wind_speed is recorded in steps of {step:.3g} m/s, which may move "
            f"{', '.join(more)}; the errors include this"
        )
    wider = {n: float(np.hypot(stderr[n], error)) for n, error in errors.items()}
    return {**stderr, **wider}
