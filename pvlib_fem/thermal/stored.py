"""A thermal model and its coefficients in a file."""

from pvlib_fem.effects import find, several
from pvlib_fem.thermal.model import thermal_model


def content_of(model, coefficients):
    """What :func:`model_of` makes the same of."""
    return {
        "model": model.steady_model.name,
        "dynamics": model.dynamics,
        "effects": [effect.spec for effect in model.effects],
        "coefficients": coefficients,
        "base": model.base,
        "fixed": model.held,
    }


def model_of(stored, own=()):
    """
    The model of a file, and its coefficients.

    Parameters
    ----------
    stored : Stored
    own : Effect or sequence of these, optional
        Effects of the user's own, which the file knows by name and settings only.

    Returns
    -------
    ThermalModel, dict

    Raises
    ------
    ValueError
        If a coefficient lacks, is no finite number or is of no such model.
    """
    own = [find(effect) for effect in several(own)]
    specs = stored.of("effects", list, "a list")
    effects = [effect_of(spec, own, stored) for spec in specs]
    names = stored.text("model"), stored.text("dynamics")
    plain = thermal_model(*names)
    base = None if stored["base"] is None else coefficients_of(stored, "base", plain)
    model = thermal_model(*names, effects, base, stored.numbers("fixed"))
    return model, coefficients_of(stored, "coefficients", model)


def effect_of(spec, own, stored):
    """An effect by what the file says of it."""
    try:
        return find(spec, own)
    except (ValueError, TypeError) as error:
        raise ValueError(
            f"{stored.file}: {error}; an effect of your own has to be given again, as "
            "from_json(path, effects=[...])"
        ) from error


def coefficients_of(stored, key, model):
    """Coefficients that are those of the model, one and all."""
    found = stored.numbers(key)
    least = {*model.parameters}
    most = {*least, *model.steady_model.fixed}
    most |= {"tau"} if model.dynamics == "steady" else set()
    if lacking := [name for name in model.parameters if name not in found]:
        raise ValueError(f"{stored.file} lacks {key}.{lacking[0]}")
    if unknown := [name for name in found if name not in most]:
        raise ValueError(
            f"{stored.file}: {key}.{unknown[0]} is no coefficient of "
            f"{model.steady_model.name}, {model.dynamics}"
        )
    return found
