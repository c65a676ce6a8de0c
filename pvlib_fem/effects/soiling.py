"""Dirt that gathers between rains, on the module or on the irradiance sensor."""

from pvlib_fem.effect import Effect, Parameter, Terms


def terms(poa_global, days_since_rain, *, per_day):
    """
    Irradiance that is gained by the module beside its sensor, day by day [1]_.

    Positive where the sensor soils (it reads low, the module is warmer than
    modelled), negative where the module does. Dirt that never changes is in
    the coefficients of the law.

    References
    ----------
    .. [1] A. Kimber et al., "The Effect of Soiling on Large Grid-Connected
       Photovoltaic Systems in California", WCPEC 2006: 0.1 to 0.5 % per day,
       as in :func:`pvlib.soiling.kimber`.
    """
    return Terms(heat=per_day * days_since_rain * poa_global)


EFFECT = Effect("soiling", terms, {"per_day": Parameter(0.0, -0.01, 0.01, "1/day")})
