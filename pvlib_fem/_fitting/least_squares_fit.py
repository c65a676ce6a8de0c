"""Fit a model by least squares to a source of rows, in memory or in files."""

from typing import Any

import numpy as np

from pvlib_fem._fitting.daily import standard_errors
from pvlib_fem._fitting.fem_fit import FemFit, of_rows
from pvlib_fem._fitting.fit_stages import last_stage, public_coefficients, stages_of
from pvlib_fem._fitting.rounded_wind import with_rounding
from pvlib_fem._fitting.row_source import EvalRequest
from pvlib_fem._fitting.time_constant import memory_notes
from pvlib_fem._record.inputs import Record
from pvlib_fem._thermal.model import ThermalModel


def fit_source(source: Any, target: ThermalModel, notes: list) -> Any:
    """
    Fit a model to a source of rows by least squares.

    Parameters
    ----------
    source : Frame or InFiles
        Rows in memory or in files.
    target : ThermalModel
        The model with all effects.
    notes : list of str
        Notes on the rows; the notes on the fit are appended.

    Returns
    -------
    FemFit
        An object of the source's ``kind``.
    """
    target, stages, minimum = stages_of(source, target)
    at_bound = tuple(np.array(target.free)[minimum.at_bound].tolist())
    coefficients, names = (
        last_stage(stages)[1],
        [n for n in target.free if n not in at_bound],
    )
    daily, own = source.result_parts(*requests_of(stages), tuple(names))
    stderr = standard_errors(target, daily, at_bound, notes)
    searched = source.rows_for(target), target, coefficients
    stderr = with_rounding(*searched, stderr, notes)
    days = own["train_days"]
    notes += memory_notes(source, target, coefficients, stderr, at_bound, days)
    notes += source.notes(target)
    if not minimum.converged:
        notes.append("the search did not converge: do not trust the numbers")
    return source.kind(
        **of_minimum(target, coefficients, stderr, at_bound, minimum.converged),
        **own,
        method="least_squares",
        notes=tuple(notes),
        night=source.night,
        daily=daily,
    )


def requests_of(stages: dict) -> tuple[dict, str]:
    """
    Requests to a source for the models of some steps, and the last step's name.

    Parameters
    ----------
    stages : dict of tuple
        Model and coefficients by the name of the step.

    Returns
    -------
    dict of EvalRequest, str
        Slopes are requested of the last step alone.
    """
    final = list(stages)[-1]
    models = {
        name: EvalRequest(model, coefficients, wanted=name == final)
        for name, (model, coefficients) in stages.items()
    }
    return models, final


def fit_result(
    target: ThermalModel,
    record: Record,
    temperature: np.ndarray,
    parts: tuple,
    minimum: tuple,
    **how: Any,
) -> FemFit:
    """
    The result of a fit in memory, from its last temperature and minimum.

    Parameters
    ----------
    target : ThermalModel
        The fitted model.
    record : Record
        With ``temp_module``.
    temperature : numpy.ndarray, shape (rows,)
        Modelled temperature of the module. [°C]
    parts : tuple of numpy.ndarray of bool, shape (rows,)
        ``train``, ``test`` and ``out`` of :func:`of_rows`.
    minimum : tuple
        ``searched``, ``stderr``, ``at_bound`` and ``converged`` of :func:`of_minimum`.
    **how
        Further attributes of :class:`FemFit`.

    Returns
    -------
    FemFit
        The result.
    """
    own = of_rows(record, temperature, *parts)
    return FemFit(**of_minimum(target, *minimum), **own, **how)


def of_minimum(
    target: ThermalModel, searched: dict, stderr: dict, at_bound: tuple, converged: bool
) -> dict:
    """
    The attributes of a result that come from the last minimum.

    Parameters
    ----------
    target : ThermalModel
        The fitted model.
    searched : dict
        Coefficients of all its parameters.
    stderr : dict
        Their standard errors; 0 for those that it has not.
    at_bound : tuple of str
        Coefficients at a bound of their range.
    converged : bool
        Whether the search ended at a minimum.

    Returns
    -------
    dict
        Arguments of :class:`FemFit`.
    """
    coefficients = public_coefficients(target, searched)
    return dict(
        model=target.steady_model.name,
        dynamics=target.dynamics,
        effects=target.effects,
        coefficients=coefficients,
        stderr={name: stderr.get(name, 0.0) for name in coefficients},
        at_bound=at_bound,
        converged=converged,
        base=target.base if target.effects else None,
        fixed=dict(target.held),
    )
