"""Snow, leaves or shade on the modules, which their power shows."""

from dataclasses import replace

from pvlib_fem.effects.effect import Effect, Parameter, Terms
from pvlib_fem.effects.plant import by_power


def terms(light_lost_dc, *, share):
    r"""
    Sunlight that the irradiance sensor sees and covered modules do not [1]_.

    .. math:: \mathrm{heat} = -\mathrm{share} \cdot \mathrm{light\_lost\_dc}

    or with the driver ``light_lost_ac``. ``share`` is near 1 where the measured module
    is covered as the others of the plant, and up to 2 where all are covered alike, as
    by leaves or by a shadow of all of them.

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
