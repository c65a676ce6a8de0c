"""The steps of a fit, from the steady model to the last effect."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from pvlib_fem._fitting.row_source import EvalRequest, Rows
from pvlib_fem._fitting.search import search_stage
from pvlib_fem._statistics.leastsquares import FLAT, Minimum, minima_of
from pvlib_fem._thermal.model import INSTANT, ThermalModel

ROUGH = 1e-8  # relative decrease of the cost at which all steps but the last end


def needed(step: str, rows: int, parameters: int) -> None:
    if rows <= parameters:
        raise ValueError(
            f"{step} needs more than {parameters} rows and has {rows}: training "
            "rows with all four columns, more than 20 W/m², the module at 0 to 80 "
            "°C, air at -20 to 60 °C and wind up to 25 m/s; use a longer record"
        )


def planned_stages(target: ThermalModel) -> list:
    """
    The steps of a fit, from the steady model to the last effect.

    Parameters
    ----------
    target : ThermalModel
        The model with all effects.

    Returns
    -------
    list of tuple
        Name, model, purpose of the rows (``"complete"`` or ``"train"``), and whether
        the bias is fitted.
    """
    plain = replace(target, effects=())
    steady = replace(plain, dynamics="steady")
    steps = [
        ("standard", steady, "complete", False),
        ("filter", steady, "train", False),
        ("ewm", plain, "train", False),
        ("fem", plain, "train", True),
    ]
    for i, added in enumerate(target.effects, start=1):
        larger = replace(plain, effects=target.effects[:i])
        steps.append((f"+ {added.name}", larger, "train", True))
    return steps


def planned_effects(target: ThermalModel) -> list:
    """The steps of a fit that add an effect."""
    return [step for step in planned_stages(target) if step[1].effects]


def stages_of(source: Any, target: ThermalModel) -> tuple[ThermalModel, dict, Minimum]:
    """
    The model with its base, the steps to it, and the last minimum.

    Parameters
    ----------
    source : Frame or InFiles
        The rows; the source finds the minima of some steps on them.
    target : ThermalModel
        The model with all effects.

    Returns
    -------
    target : ThermalModel
        With a ``base`` if it has effects.
    stages : dict of tuple
        Model and coefficients of each step, by its name.
    minimum : Minimum
        Of the last step, in the order of ``target.free``.

    Raises
    ------
    ValueError
        If there are no more rows than coefficients.
    """
    needed("least squares", source.count, len(target.free))
    plain = [step for step in planned_stages(target) if not step[1].effects]
    starts, more = source.search_start(target), bool(target.effects)
    stages, minimum, starts = source.minima(plain, starts, final=not more)
    if not more:
        return target, stages, minimum

    def fit(based: ThermalModel) -> tuple[dict, Minimum, dict]:
        return source.minima(planned_effects(based), starts, final=True)

    target, (added, minimum, _) = with_effects(target, stages, fit)
    return target, stages | added, minimum


def flatness(steps: list, final: bool) -> dict:
    """
    Relative decrease of the cost at which the search of each step ends.

    Parameters
    ----------
    steps : list of tuple
        Steps of :func:`planned_stages`.
    final : bool
        Whether the last of them is the last of the fit, which is searched to the end.

    Returns
    -------
    dict
        By the name of the step. [-]
    """
    last_step = steps[-1][0] if final else None
    return {name: FLAT if name == last_step else ROUGH for name, *_ in steps}


def with_effects(
    target: ThermalModel, stages: dict, fit: Callable
) -> tuple[ThermalModel, tuple]:
    """
    The model with its base, and the result of ``fit`` for it.

    The base is the last step without effects. If an effect scales the base, the base
    has the model's own coefficients, and the model is fitted once more. The first item
    that ``fit`` returns are the steps.
    """
    target = replace(target, base=public_coefficients(*last_stage(stages)))
    fitted = fit(target)
    own = target.rebased(public_coefficients(target, last_stage(fitted[0])[1]))
    return own, fitted if own is target else fit(own)


def minima(source: Any, steps: list, starts: dict, flat: dict) -> dict:
    """
    Minima and searched coefficients of steps that share their passes.

    Parameters
    ----------
    source : Source
        The rows.
    steps : list of tuple
        Steps of :func:`planned_stages`.
    starts : dict of dict
        Coefficients at which each step's search starts, by the name of the step.
    flat : dict
        Relative decrease of the cost that ends each search, by the name of the step.
        [-]

    Returns
    -------
    dict of tuple
        :class:`Minimum` and coefficients of each step as the search varies them, see
        :func:`natural_coefficients`, by the name of the step.
    """
    models = {name: (model, rows) for name, model, rows, _ in steps}
    searches = {
        name: search_stage(model, source, starts[name], biased, flat[name])
        for name, model, _, biased in steps
    }

    def sums(points: dict) -> Any:
        requests = {
            name: EvalRequest(models[name][0], coefficients, models[name][1])
            for name, (coefficients, _) in points.items()
        }
        return source.sums(requests, {name: own for name, (_, own) in points.items()})

    return minima_of(searches, sums)


def minimise(
    model: ThermalModel, source: Rows, start: dict, biased: bool, flat: float
) -> tuple[Minimum, dict]:
    """
    Least squares of one stage on the rows of a source.

    Parameters
    ----------
    model : ThermalModel
        Of the stage.
    source : Rows
        The rows that count.
    start : dict
        Coefficients at which the search starts, as it varies them.
    biased : bool
        Whether the bias is fitted.
    flat : float
        Relative decrease of the cost that ends the search. [-]

    Returns
    -------
    Minimum, dict
        The minimum, and the coefficients as the search varies them, see
        :func:`natural_coefficients`.
    """
    steps = [("", model, "train", biased)]
    return minima(source, steps, {"": start}, {"": flat})[""]


def last_stage(stages: dict) -> tuple[ThermalModel, dict]:
    """
    Model and coefficients of the last step.

    Parameters
    ----------
    stages : dict of tuple
        From :func:`stages_of`.

    Returns
    -------
    ThermalModel, dict
        Of this step.
    """
    return list(stages.values())[-1]


def public_coefficients(model: ThermalModel, coefficients: dict) -> dict:
    """
    Coefficients that unpack into the temperature function of the dynamics.

    Parameters
    ----------
    model : ThermalModel
        The fitted model.
    coefficients : dict
        Of all its parameters.

    Returns
    -------
    dict
        With held constants of the steady model, but without its defaults. A steady
        model has a ``tau`` near 0 [s].
    """
    constants = [name for name in model.constants if name in model.held]
    names = [*model.parameters, *constants]
    values = {name: float(coefficients[name]) for name in names}
    if model.dynamics == "steady":
        bias = values.pop("bias")
        values = {**values, "tau": INSTANT, "bias": bias}
    return values
