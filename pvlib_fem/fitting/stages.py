"""The steps of a fit, one after the other."""

from dataclasses import replace

from pvlib_fem.fitting.rows import Asked
from pvlib_fem.fitting.search import searching
from pvlib_fem.statistics.leastsquares import FLAT, minima_of
from pvlib_fem.thermal.model import INSTANT

ROUGH = 1e-8  # relative fall of the cost that ends a step before the last


def needed(step, rows, parameters):
    if rows <= parameters:
        raise ValueError(
            f"{step} needs more than {parameters} rows and has {rows}: training "
            "rows with all four columns, more than 20 W/m², the module at 0 to 80 "
            "°C, air at -20 to 60 °C and wind up to 25 m/s; use a longer record"
        )


def planned(target):
    """The steps of a fit: name, model, the rows that count, and whether with a bias."""
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


def planned_effects(target):
    """Those of the steps that add an effect."""
    return [step for step in planned(target) if step[1].effects]


def stages_of(source, target):
    """
    The model with its base, the steps to it, and the last minimum.

    Parameters
    ----------
    source : Frame or InFiles
        The rows, which find the minima of some steps on them, one from another.
    target : ThermalModel
    """
    needed("least squares", source.count, len(target.free))
    plain = [step for step in planned(target) if not step[1].effects]
    starts, more = source.begun(target), bool(target.effects)
    stages, minimum, starts = source.minima(plain, starts, final=not more)
    if not more:
        return target, stages, minimum

    def fit(based):
        return source.minima(planned_effects(based), starts, final=True)

    target, (added, minimum, _) = with_effects(target, stages, fit)
    return target, stages | added, minimum


def flatness(steps, final):
    """How flat the cost is to be at the end of each step: most at the last of all."""
    last_step = steps[-1][0] if final else None
    return {name: FLAT if name == last_step else ROUGH for name, *_ in steps}


def with_effects(target, stages, fit):
    """
    The model by its base, and what ``fit`` makes of it.

    The base is the last of the steps without effects, or the model's own where an
    effect is a share of that: then it is fitted once more. The first thing that
    ``fit`` gives are the steps.
    """
    target = replace(target, base=public(*last(stages)))
    found = fit(target)
    own = target.rebased(public(target, last(found[0])[1]))
    return own, found if own is target else fit(own)


def minima(source, steps, starts, flat):
    """
    Minimum and coefficients as the search sees them, of steps that share their passes.

    Parameters
    ----------
    source : Source
    steps : sequence
        As :func:`planned` has them.
    starts, flat : dict
        By the name of a step, where its search begins and how flat it ends.
    """
    models = {name: (model, rows) for name, model, rows, _ in steps}
    searches = {
        name: searching(model, source, starts[name], biased, flat[name])
        for name, model, _, biased in steps
    }

    def sums(points):
        asked = {
            name: Asked(models[name][0], coefficients, models[name][1])
            for name, (coefficients, _) in points.items()
        }
        return source.sums(asked, {name: own for name, (_, own) in points.items()})

    return minima_of(searches, sums)


def minimise(model, source, start, biased, flat):
    """Least squares of one stage on the rows of a source."""
    steps = [("", model, "train", biased)]
    return minima(source, steps, {"": start}, {"": flat})[""]


def last(stages):
    """What the last step came to."""
    return list(stages.values())[-1]


def public(model, coefficients):
    """Coefficients that unpack into the temperature function of the dynamics."""
    constants = [name for name in model.constants if name in model.held]
    names = [*model.parameters, *constants]
    values = {name: float(coefficients[name]) for name in names}
    if model.dynamics == "steady":
        bias = values.pop("bias")
        values = {**values, "tau": INSTANT, "bias": bias}
    return values
