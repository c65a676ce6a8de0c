"""One fit of a source of rows by least squares, whether they are held or read."""

import numpy as np

from pvlib_fem.fitting.daily import errors
from pvlib_fem.fitting.memory import memory_notes
from pvlib_fem.fitting.result import FemFit, of_rows
from pvlib_fem.fitting.rows import Asked
from pvlib_fem.fitting.stages import last, public, stages_of


def fit_source(source, target, notes):
    """
    The fit of a model to a source of rows, by least squares.

    Parameters
    ----------
    source : Frame or InFiles
    target : ThermalModel
    notes : list of str
        What is known of the rows, to which those of the fit are added.

    Returns
    -------
    FemFit
        Of the source's own kind.
    """
    target, stages, minimum = stages_of(source, target)
    at_bound = tuple(np.array(target.free)[minimum.at_bound].tolist())
    found, names = last(stages)[1], [n for n in target.free if n not in at_bound]
    daily, own = source.ended(*asked(stages), tuple(names))
    stderr = errors(target, daily, at_bound, notes)
    days = own["train_days"]
    notes += memory_notes(source, target, found, stderr, at_bound, days)
    notes += source.notes(target)
    if not minimum.converged:
        notes.append("the search did not converge: do not trust the numbers")
    return source.kind(
        **of_minimum(target, found, stderr, at_bound, minimum.converged),
        **own,
        method="least_squares",
        notes=tuple(notes),
        night=source.night,
        daily=daily,
    )


def asked(stages):
    """The models of some steps as a source is asked for them, and the last's name."""
    final = list(stages)[-1]
    models = {
        name: Asked(model, found, wanted=name == final)
        for name, (model, found) in stages.items()
    }
    return models, final


def finished(target, record, temperature, parts, minimum, **how):
    """The result of rows that are held, from the last temperature and minimum."""
    own = of_rows(record, temperature, *parts)
    return FemFit(**of_minimum(target, *minimum), **own, **how)


def of_minimum(target, found, stderr, at_bound, converged):
    """What a result has of the last minimum."""
    coefficients = public(target, found)
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
