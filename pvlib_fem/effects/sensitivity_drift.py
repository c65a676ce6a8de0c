"""A drift of the irradiance sensor, or of what the module absorbs."""

from pvlib_fem.effect import Effect, Parameter, Terms


def terms(poa_global, years, *, per_year):
    """
    Irradiance that the module gains beside its sensor, year by year [1]_.

    Below a year and a half it cannot be told from a season.

    References
    ----------
    .. [1] ISO 9060:2018: non-stability of pyranometers, 0.8 to 3 % per year by
       class.
    """
    return Terms(heat=per_year * years * poa_global)


EFFECT = Effect(
    "sensitivity_drift", terms, {"per_year": Parameter(0.0, -0.2, 0.2, "1/year")}
)
