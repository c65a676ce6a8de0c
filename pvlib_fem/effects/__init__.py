"""The registry of effects: one file each, one line here."""

from collections.abc import Iterable, Mapping
from typing import Any

from pvlib_fem._former_names import in_new_names
from pvlib_fem._spelling import did_you_mean
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._instruments import SENSOR_FAULTS
from pvlib_fem.effects._time_profiles import TIME_PROFILES, along_all
from pvlib_fem.effects._user_column import of_column
from pvlib_fem.effects.catalogue.air_elsewhere import EFFECT as air_elsewhere
from pvlib_fem.effects.catalogue.air_shield import EFFECT as air_shield
from pvlib_fem.effects.catalogue.electrical_output import EFFECT as electrical_output
from pvlib_fem.effects.catalogue.ground_or_water import EFFECT as ground_or_water
from pvlib_fem.effects.catalogue.incidence_angle import EFFECT as incidence_angle
from pvlib_fem.effects.catalogue.modules_covered import EFFECT as modules_covered
from pvlib_fem.effects.catalogue.natural_convection import EFFECT as natural_convection
from pvlib_fem.effects.catalogue.outage import EFFECT as outage
from pvlib_fem.effects.catalogue.poa_misalignment import EFFECT as poa_misalignment
from pvlib_fem.effects.catalogue.radiative_loss import EFFECT as radiative_loss
from pvlib_fem.effects.catalogue.rain import EFFECT as rain
from pvlib_fem.effects.catalogue.rear_irradiance import EFFECT as rear_irradiance
from pvlib_fem.effects.catalogue.season import EFFECT as season
from pvlib_fem.effects.catalogue.sensor_covered import EFFECT as sensor_covered
from pvlib_fem.effects.catalogue.shading import EFFECT as shading
from pvlib_fem.effects.catalogue.sky_radiation import EFFECT as sky_radiation
from pvlib_fem.effects.catalogue.snow import EFFECT as snow
from pvlib_fem.effects.catalogue.soiling import EFFECT as soiling
from pvlib_fem.effects.catalogue.temperature_gain import EFFECT as temperature_gain
from pvlib_fem.effects.catalogue.thermal_storage import EFFECT as thermal_storage
from pvlib_fem.effects.catalogue.tracker_stuck import EFFECT as tracker_stuck
from pvlib_fem.effects.catalogue.wind_direction import EFFECT as wind_direction
from pvlib_fem.effects.catalogue.wind_shape import EFFECT as wind_shape

__all__ = ["CHANGES", "EFFECTS", "PHYSICS", "SENSOR_FAULTS", "TIME_PROFILES", "find"]

#: a name, a name with its settings, or an effect
EffectLike = str | Mapping[str, Any] | Effect

#: physical effects by name; first the effects with a driver of their own
PHYSICS = {
    effect.name: effect
    for effect in (
        sky_radiation,
        electrical_output,
        wind_direction,
        rain,
        soiling,
        snow,
        modules_covered,
        sensor_covered,
        outage,
        shading,
        tracker_stuck,
        air_elsewhere,
        radiative_loss,
        natural_convection,
        wind_shape,
        thermal_storage,
        ground_or_water,
        incidence_angle,
        rear_irradiance,
        poa_misalignment,
        temperature_gain,
        air_shield,
        season,
    )
}
#: faults of sensors and mountings: each fault with each time profile
CHANGES = {
    effect.name: effect
    for sensor_fault in SENSOR_FAULTS
    for effect in along_all(sensor_fault)
}
#: every effect by its name
EFFECTS = PHYSICS | CHANGES


def find(effect: EffectLike, own: Iterable[Effect] = ()) -> Effect:
    """
    Find an effect by name; an :class:`Effect` is returned as it is.

    Parameters
    ----------
    effect : str, dict or Effect
        A name; a dict of the name and its settings, as ``{"name": "shading",
        "windows": [...]}``, ``{"name": "sky_radiation", "source": "humidity"}`` or
        ``{"name": "soiling", "cleaning": 6.0, "within": 24.0}``; or an effect.
    own : sequence of Effect, optional
        Your own effects, which are found by name, too.

    Returns
    -------
    Effect
    """
    if isinstance(effect, Effect):
        return effect
    known = EFFECTS | {effect.name: effect for effect in own}
    settings = dict(effect) if isinstance(effect, Mapping) else {"name": effect}
    name = settings.pop("name", None)
    if isinstance(name, str) and name not in known:
        name = in_new_names(name)
    if name not in known and "column" in settings:
        return of_column(**settings)
    if name not in known:
        near = did_you_mean(str(name), known)
        raise ValueError(f"unknown effect {name!r}{near}; there are {', '.join(known)}")
    if not settings or settings == known[name].settings:
        return known[name]
    return known[name].made(**settings)


def several(effects: Any) -> list[Any]:
    """
    One or more effects, or their names, as a list.

    Parameters
    ----------
    effects : str, mapping, Effect or iterable of these

    Returns
    -------
    list
    """
    one = isinstance(effects, (str, Mapping, Effect))
    return [effects] if one else list(effects)
