"""Snow that covers the module."""

import numpy as np

from pvlib_fem.effects._effect import Effect, Parameter, Terms


def terms(
    poa_global: np.ndarray,
    snow_cover: np.ndarray,
    snow_left: np.ndarray,
    *,
    share: float,
    stays: float,
) -> Terms:
    r"""
    Irradiance that the sensor measures and a snow-covered module does not get [1]_.

    .. math::

        \mathrm{heat} = -(\mathrm{share} \cdot \mathrm{snow\_cover}
        + \mathrm{stays} \cdot \mathrm{snow\_left}) \cdot \mathrm{poa\_global}

    ``share`` is near 1 under some centimetres of snow. It is less if the sensor is
    covered, too, or only a part of the module is. It can exceed 1 because coefficients
    of winter differ from those of the year. ``stays`` is the share for snow that slides
    off gradually: near 1 on a roof, near 0 if all snow slides off at once, and slightly
    negative if bright ground reflects light.

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
    kind_of="modules_covered",
)
