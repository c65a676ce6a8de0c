"""Air at the module that differs from the air at its temperature sensor."""

from dataclasses import replace

import numpy as np

from pvlib_fem.effects._effect import Effect, Parameter, Terms


def terms(sky_deficit: np.ndarray, *, share: float, per_kelvin: float = 5.4) -> Terms:
    r"""
    Air that is nearer to the sky's temperature than the measured air [1]_.

    .. math::

        \mathrm{offset} = -\mathrm{share} \cdot
        \mathrm{sky\_deficit} / \mathrm{per\_kelvin}

    A pyrgeometer sees the air above the plant. A thermometer at another site, or with
    means of hours, is warmer than the plant's air when the longwave deficit of the sky
    is large, and colder when it is small. ``share`` is the share of that difference
    between air and sky that the plant's air has; ``per_kelvin`` is 4·σ·T³ at 15 °C.
    [W/(m² K)] Clear nights that cool a hollow more than a hill have the same signature.
    Radiative loss to the sky differs only by its wind: its effect on temperature is
    divided by the loss.

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
    decided_by="air temperature next to the module",
    source="measured longwave",
    confused_with=("sky_radiation", "temperature_gain", "air_shield", "season"),
)
FROM_HUMIDITY = MEASURED.estimated("humidity", "sky_deficit_humid")
FROM_MOISTURE = MEASURED.estimated("humidity, without clouds", "sky_deficit_moist")

#: by the known quantities of the sky, as for radiative loss to it
VARIANTS = (MEASURED, FROM_HUMIDITY, FROM_MOISTURE)
EFFECT = replace(MEASURED, variants=VARIANTS)
