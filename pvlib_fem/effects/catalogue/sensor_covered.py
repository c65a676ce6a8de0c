"""Snow, leaves or shade on the irradiance sensor, detected by the plant's power."""

from dataclasses import replace

import numpy as np

from pvlib_fem.effects._effect import Effect, Parameter, Terms
from pvlib_fem.effects._plant_power import by_power


def terms(light_unseen_dc: np.ndarray, *, share: float) -> Terms:
    r"""
    Irradiance that heats the modules and that a covered sensor does not measure [1]_.

    .. math:: \mathrm{heat} = \mathrm{share} \cdot \mathrm{light\_unseen\_dc}

    The driver may also be ``light_unseen_ac``. ``share`` is 1 if the measured module
    receives as much irradiance as the others.

    References
    ----------
    .. [1] The relation of power to irradiance of PVWatts, solved for irradiance:
       A. P. Dobos, "PVWatts Version 5 Manual", NREL/TP-6A20-62641 (2014).
    """
    return Terms(heat=share * light_unseen_dc)


EFFECT = Effect(
    "sensor_covered",
    terms,
    {"share": Parameter(0.0, 0.0, 1.5, "-")},
    unseen_light=True,
    decided_by="a second irradiance sensor, or a camera",
    confused_with=(
        "irradiance_sensor_episode",
        "soiling",
        "shading",
        "a reflection onto the modules",
        "power of a plant that has been extended",
    ),
)
EFFECT = replace(EFFECT, variants=by_power(EFFECT, "light_unseen"))
