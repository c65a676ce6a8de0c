"""Longwave loss to a sky that is colder than the air."""

from dataclasses import replace

import numpy as np

from pvlib_fem.effects._effect import Effect, Parameter, Terms


def terms(sky_deficit: np.ndarray, *, share: float) -> Terms:
    r"""
    Radiative heat loss to the sky, expressed as equivalent irradiance [1]_.

    .. math:: \mathrm{heat} = -\mathrm{share} \cdot \mathrm{sky\_deficit}

    ``share`` is emissivity · sky view over the absorbed share of irradiance, because
    the steady models express heat as incident irradiance. On a rack both faces together
    see one whole sky, which gives about 0.88/0.72; on a roof only the front sees its
    part of the sky. pvlib's ``faiman_rad`` has emissivity · sky view alone.

    References
    ----------
    .. [1] A. Driesse, J. S. Stein and M. Theristis, "Improving Common PV Module
       Temperature Models by Incorporating Radiative Losses to the Sky",
       SAND2022-11604, 2022, :doi:`10.2172/1884890`, as in
       :func:`pvlib.temperature.faiman_rad`.
    """
    return Terms(heat=-share * sky_deficit)


MEASURED = Effect(
    "sky_radiation",
    terms,
    {"share": Parameter(0.0, 0.0, 3.0, "-")},
    title="radiative heat loss to a cold sky",
    decided_by="a pyrgeometer",
    source="measured longwave",
    confused_with=(
        "season",
        "temperature_gain",
        "dew at night",
        "a thermopile pyranometer that reads below zero under a clear night sky",
        "the bias, by its mean",
        "air_elsewhere",
    ),
)
FROM_HUMIDITY = MEASURED.estimated("humidity", "sky_deficit_humid")
FROM_MOISTURE = MEASURED.estimated("humidity, without clouds", "sky_deficit_moist")
FROM_CLOUDS = MEASURED.estimated(
    "clouds of the day", "sky_deficit_clouds", confounder=True
)
FROM_AIR = MEASURED.estimated(
    "air temperature alone", "sky_deficit_air", confounder=True
)

#: by the known quantities of the sky, the best first
VARIANTS = (MEASURED, FROM_HUMIDITY, FROM_CLOUDS, FROM_MOISTURE, FROM_AIR)
EFFECT = replace(MEASURED, variants=VARIANTS)
