"""Snow, leaves or shade on the modules, detected by their power."""

from dataclasses import replace

import numpy as np

from pvlib_fem.effects._effect import Effect, Parameter, Terms
from pvlib_fem.effects._plant_power import by_power


def terms(light_lost_dc: np.ndarray, *, share: float) -> Terms:
    r"""
    Irradiance that the sensor measures and covered modules do not receive [1]_.

    .. math:: \mathrm{heat} = -\mathrm{share} \cdot \mathrm{light\_lost\_dc}

    The driver may also be ``light_lost_ac``. ``share`` is near 1 if the cover of the
    measured module is that of the plant on average, and up to 2 if all modules are
    covered evenly, as by leaves or a shadow on the whole plant.

    References
    ----------
    .. [1] B. Marion et al., "Measured and modeled photovoltaic system energy
       losses from snow for Colorado and Wisconsin locations", Solar Energy 97,
       112 (2013), :doi:`10.1016/j.solener.2013.07.029`.
    """
    return Terms(heat=-share * light_lost_dc)


EFFECT = Effect(
    "modules_covered",
    terms,
    {"share": Parameter(0.0, 0.0, 2.0, "-")},
    decided_by="a camera, or the site's log of snow and cleaning",
    confused_with=(
        "snow",
        "shading",
        "outage",
        "an irradiance sensor that sees light which the modules do not",
    ),
)
EFFECT = replace(EFFECT, variants=by_power(EFFECT, "light_lost"))
