"""Longwave loss to a sky that is colder than the air."""

from pvlib_fem.effect import Effect, Parameter, Terms


def terms(sky_deficit, *, share):
    """
    Heat lost to the sky, in the currency of irradiance [1]_.

    ``share`` is emissivity · sky view over the absorbed share of irradiance,
    about 0.88 · 0.87 / 0.75: the laws count heat by incident irradiance, of
    which only that share is heat. pvlib's ``faiman_rad`` has emissivity · sky
    view alone.

    References
    ----------
    .. [1] A. Driesse, J. S. Stein and M. Theristis, "Improving Common PV Module
       Temperature Models by Incorporating Radiative Losses to the Sky",
       SAND2022-11604, 2022, as in :func:`pvlib.temperature.faiman_rad`.
    """
    return Terms(heat=-share * sky_deficit)


EFFECT = Effect("sky_radiation", terms, {"share": Parameter(0.0, 0.0, 3.0, "-")})
