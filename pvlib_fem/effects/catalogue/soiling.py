"""Dirt that gathers between rains, on the module or on the irradiance sensor."""

from pvlib_fem.effects.effect import Effect, Parameter, Terms


def terms(poa_global, days_since_rain, *, per_day):
    r"""
    Irradiance that is gained by the module beside its sensor, day by day [1]_.

    .. math::

        \mathrm{heat} = \mathrm{per\_day} \cdot \mathrm{days\_since\_rain}
        \cdot \mathrm{poa\_global}

    Positive where the sensor soils (it reads low, the module is warmer than
    modelled), negative where the module does. Dirt that never changes is in
    the coefficients of the steady model.

    References
    ----------
    .. [1] A. Kimber et al., "The Effect of Soiling on Large Grid-Connected
       Photovoltaic Systems in California and the Southwest Region of the United
       States", WCPEC 2006, :doi:`10.1109/WCPEC.2006.279690`, as in
       :func:`pvlib.soiling.kimber`, which has 0.15 % per day.
    """
    return Terms(heat=per_day * days_since_rain * poa_global)


EFFECT = Effect(
    "soiling",
    terms,
    {"per_day": Parameter(0.0, -0.01, 0.01, "1/day")},
    decided_by="a cleaning of the sensor and, on another day, of the module",
    confused_with=(
        "season",
        "sensitivity_drift",
        "natural_convection",
        "poa_misalignment",
        "the steady model's coefficients, where the dirt never changes",
    ),
)
