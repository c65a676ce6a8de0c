"""Store a thermal model and its coefficients in a file, and read them."""

from typing import Any

from pvlib_fem._converter import AnyFloat
from pvlib_fem._stored import Stored
from pvlib_fem._thermal.model import ThermalModel, thermal_model
from pvlib_fem.effects import find, several
from pvlib_fem.effects._effect import Effect


def content_of(model: ThermalModel, coefficients: dict) -> dict:
    """
    Content of a file from which :func:`model_of` makes an equal model.

    Parameters
    ----------
    model : ThermalModel
    coefficients : dict
        All coefficients by name.

    Returns
    -------
    dict
    """
    return {
        "model": model.steady_model.name,
        "dynamics": model.dynamics,
        "effects": [effect.spec for effect in model.effects],
        "coefficients": coefficients,
        "base": model.base,
        "fixed": model.held,
    }


def model_of(stored: Stored, own: Any = ()) -> Any:
    """
    The model of a file, and its coefficients.

    Parameters
    ----------
    stored : Stored
    own : Effect or sequence of these, optional
        The user's own effects, of which the file has only name and settings.

    Returns
    -------
    ThermalModel, dict

    Raises
    ------
    ValueError
        If a coefficient is missing, not finite, not one of the model's, or impossible.
    """
    own = [find(effect) for effect in several(own)]
    specs = stored.read("effects", list[Any])
    effects = [effect_of(spec, own, stored) for spec in specs]
    names = stored.read("model", str), stored.read("dynamics", str)
    base = None
    if stored["base"] is not None:
        given = {*stored.read("base", dict)}  # with effects that faults may reverse
        those = [e for e in effects if not e.sensor_fault and {*e.rows()} & given]
        base = coefficients_of(stored, "base", thermal_model(*names, those))
    fixed = stored.read("fixed", dict[str, float])
    model = thermal_model(*names, effects, base, fixed)
    coefficients = coefficients_of(stored, "coefficients", model)
    for name, value in fixed.items():
        if coefficients.get(name) != value:
            raise ValueError(
                f"{stored.file}: {stored.place}fixed.{name} is {value:g}, and "
                f"coefficients.{name} is {coefficients.get(name, 'not there')}"
            )
    if "stderr" in stored.content:  # of a fit, and not of a model alone
        errors = stored.read("stderr", dict[str, AnyFloat])
        if missing := [name for name in model.parameters if name not in errors]:
            raise ValueError(f"{stored.file} has no {stored.place}stderr.{missing[0]}")
    return model, coefficients


def effect_of(spec: str | dict, own: list, stored: Stored) -> Effect:
    """The effect that an entry of the file describes."""
    try:
        return find(spec, own)
    except (ValueError, TypeError) as error:
        raise ValueError(
            f"{stored.file}: {error}; an effect of your own has to be given again, as "
            "from_json(path, effects=[...])"
        ) from error


def coefficients_of(stored: Stored, key: str, model: ThermalModel) -> dict:
    """The coefficients of a file, checked to be the complete set of the model."""
    coefficients = stored.read(key, dict[str, float])
    least = {*model.parameters}
    most = {*least, *model.steady_model.constants}
    most |= {"tau"} if model.dynamics == "steady" else set()
    if missing := [name for name in model.parameters if name not in coefficients]:
        raise ValueError(f"{stored.file} has no {stored.place}{key}.{missing[0]}")
    if unknown := [name for name in coefficients if name not in most]:
        raise ValueError(
            f"{stored.file}: {stored.place}{key}.{unknown[0]} is no coefficient of "
            f"{model.steady_model.name}, {model.dynamics}"
        )
    for name, row in model.parameters.items():
        # the paper's regression has no bounds, but its results stay close to them
        span = row.upper - row.lower
        if not row.lower - span <= coefficients[name] <= row.upper + span:
            raise ValueError(
                f"{stored.file}: {stored.place}{key}.{name} is {coefficients[name]:g} "
                f"{row.unit}, where {row.lower:g} to {row.upper:g} belongs"
            )
    try:
        model.checked(coefficients)
    except ValueError as error:
        raise ValueError(f"{stored.file}: {stored.place}{key}: {error}") from error
    return coefficients
