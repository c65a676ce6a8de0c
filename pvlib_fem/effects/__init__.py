"""The registry of effects: one file each, one line here."""

from pvlib_fem.effect import Effect
from pvlib_fem.effects.electrical_output import EFFECT as electrical_output
from pvlib_fem.effects.rain import EFFECT as rain
from pvlib_fem.effects.sensitivity_drift import EFFECT as sensitivity_drift
from pvlib_fem.effects.sky_radiation import EFFECT as sky_radiation
from pvlib_fem.effects.soiling import EFFECT as soiling
from pvlib_fem.effects.wind_direction import EFFECT as wind_direction

EFFECTS = {
    effect.name: effect
    for effect in (
        sky_radiation,
        electrical_output,
        wind_direction,
        rain,
        soiling,
        sensitivity_drift,
    )
}


def find(name):
    """An effect by name, or one of the user's own as it is."""
    if isinstance(name, Effect):
        return name
    if name not in EFFECTS:
        raise ValueError(f"unknown effect {name!r}; there are {', '.join(EFFECTS)}")
    return EFFECTS[name]
