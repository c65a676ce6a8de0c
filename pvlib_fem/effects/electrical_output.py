"""Electrical power that leaves the module and does not heat it."""

from pvlib_fem.effect import Effect, Parameter, Terms


def terms(p_dc, *, share):
    """
    Heat that leaves as electricity, and stays when it is curtailed [1]_.

    ``share`` is 1 over the absorbed share of irradiance, 1.2 to 1.5. The mean
    efficiency is in the coefficients of the law; what is seen is its change, by
    curtailment, clipping or outage.

    References
    ----------
    .. [1] The balance of :func:`pvlib.temperature.pvsyst_cell`, where irradiance
       heats by absorption · (1 - efficiency).
    """
    return Terms(heat=-share * p_dc)


EFFECT = Effect("electrical_output", terms, {"share": Parameter(0.0, 0.0, 4.0, "-")})
