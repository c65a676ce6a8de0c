"""A drift of the irradiance sensor, or of what the module absorbs."""

from pvlib_fem.effects.effect import Effect, Parameter, Terms


def terms(poa_global, years, *, per_year):
    r"""
    Irradiance that the module gains beside its sensor, year by year [1]_.

    .. math::

        \mathrm{heat} = \mathrm{per\_year} \cdot \mathrm{years}
        \cdot \mathrm{poa\_global}

    Below a year and a half it cannot be told from a season. By day a module that
    ages and a back sensor that comes loose look the same; the loose sensor reads
    less of the night's cold, too.

    References
    ----------
    .. [1] ISO 9060:2018: non-stability of pyranometers, 0.8 to 3 % per year by
       class.
    """
    return Terms(heat=per_year * years * poa_global)


EFFECT = Effect(
    "sensitivity_drift",
    terms,
    {"per_year": Parameter(0.0, -0.2, 0.2, "1/year")},
    decided_by="a recalibration of the irradiance sensor, and the nights' cold: only "
    "a loose back sensor reads less of it",
    confused_with=(
        "season",
        "soiling",
        "poa_misalignment",
        "a module that ages",
        "a back sensor that comes loose",
    ),
)
