"""An irradiance sensor that does not stand as the module does."""

from pvlib_fem.effects.effect import Effect, Parameter, Terms


def terms(beam_by_tilt, beam_by_azimuth, *, tilt, azimuth):
    r"""
    Beam that the module gets beside a sensor in another plane [1]_.

    .. math::

        \mathrm{heat} = \mathrm{tilt} \cdot \mathrm{beam\_by\_tilt}
        + \mathrm{azimuth} \cdot \mathrm{beam\_by\_azimuth}

    ``tilt`` and ``azimuth`` are those of the module beyond the stated ones, in
    which the sensor is taken to stand; to the first order in both.

    References
    ----------
    .. [1] J. A. Duffie and W. A. Beckman, "Solar Engineering of Thermal
       Processes", section 1.6, of which the slopes are taken.
    """
    return Terms(heat=tilt * beam_by_tilt + azimuth * beam_by_azimuth)


EFFECT = Effect(
    "poa_misalignment",
    terms,
    {
        "tilt": Parameter(0.0, -10.0, 10.0, "°"),
        "azimuth": Parameter(0.0, -20.0, 20.0, "°"),
    },
    confounder=True,
    title="an irradiance sensor in another plane than the modules",
    decided_by="an inclinometer, or irradiance before and after noon on clear days",
    confused_with=(
        "season",
        "rear_irradiance",
        "thermal_storage",
        "shading",
        "a clock that is late",
    ),
)
