"""Air at the module that is not that of the air temperature's sensor."""

from dataclasses import replace

from pvlib_fem.effects.effect import Effect, Parameter, Terms


def terms(sky_deficit, *, share, per_kelvin=5.4):
    r"""
    Air that is nearer to the sky's temperature than the measured one [1]_.

    .. math::

        \mathrm{offset} = -\mathrm{share} \cdot
        \mathrm{sky\_deficit} / \mathrm{per\_kelvin}

    A pyrgeometer sees the air above the plant, whatever the thermometer says. Where
    that is elsewhere, or holds means of hours, it is warmer than the plant's air
    when the sky lacks much, and colder when it lacks little. ``share`` is what the
    plant's air takes of that difference, of which ``per_kelvin`` is the slope of
    4·σ·T³ at 15 °C. [W/(m² K)] Clear nights that cool a hollow more than a hill
    leave the same. Loss to the sky does, too, but for its wind: it is
    divided by what the wind makes of the loss.

    References
    ----------
    .. [1] W. C. Swinbank, "Long-wave radiation from clear skies", Q. J. R.
       Meteorol. Soc. 89, 339 (1963), :doi:`10.1002/qj.49708938105`: the sky's
       longwave follows air at the ground.
    """
    return Terms(offset=-share * sky_deficit / per_kelvin)


MEASURED = Effect(
    "air_elsewhere",
    terms,
    {"share": Parameter(0.0, 0.0, 1.0, "-")},
    title="air at the modules that differs from the measured air on clear nights",
    decided_by="air temperature beside the module",
    source="measured longwave",
    confused_with=("sky_radiation", "temperature_gain", "air_shield", "season"),
)
FROM_HUMIDITY = MEASURED.estimated("humidity", "sky_deficit_humid")
FROM_MOISTURE = MEASURED.estimated("humidity, without clouds", "sky_deficit_moist")

#: by what is known of the sky, as for loss to it
VARIANTS = (MEASURED, FROM_HUMIDITY, FROM_MOISTURE)
EFFECT = replace(MEASURED, variants=VARIANTS)
