"""Snow on the module, which the sun does not reach."""

from pvlib_fem.effects.effect import Effect, Parameter, Terms


def terms(poa_global, snow_cover, snow_left, *, share, stays):
    r"""
    Sunlight that the irradiance sensor sees and a covered module does not [1]_.

    .. math::

        \mathrm{heat} = -(\mathrm{share} \cdot \mathrm{snow\_cover}
        + \mathrm{stays} \cdot \mathrm{snow\_left}) \cdot \mathrm{poa\_global}

    ``share`` is near 1 under some centimetres, and less where the sensor is
    covered too or only a part of the module is. It may pass 1 by as much as the
    coefficients of winter differ from those of the year. ``stays`` is the same of snow
    that slides by parts: near 1 on a roof, near 0 where all of it goes at once, and
    a little less than that where bright ground adds light.

    References
    ----------
    .. [1] B. Marion et al., "Measured and modeled photovoltaic system energy
       losses from snow for Colorado and Wisconsin locations", Solar Energy 97,
       112 (2013), :doi:`10.1016/j.solener.2013.07.029`, as in
       :func:`pvlib.snow.coverage_nrel`.
    """
    return Terms(heat=-(share * snow_cover + stays * snow_left) * poa_global)


EFFECT = Effect(
    "snow",
    terms,
    {
        "share": Parameter(0.0, 0.0, 1.2, "-"),
        "stays": Parameter(0.0, -0.3, 1.5, "-"),
    },
    title="snow on the modules",
    decided_by="a camera, or the module's power on the days after snow",
    confused_with=(
        "electrical_output",
        "rear_irradiance",
        "an irradiance sensor that lies under snow itself",
    ),
)
