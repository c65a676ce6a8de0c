"""Hours without power: the share that would be electricity heats the module."""

from dataclasses import replace

import numpy as np

from pvlib_fem.effects._effect import Effect, Parameter, Terms
from pvlib_fem.effects._plant_power import by_power


def terms(poa_global: np.ndarray, power_off_dc: np.ndarray, *, share: float) -> Terms:
    r"""
    Heat that would leave as electricity, while a plant gives no power [1]_.

    .. math::

        \mathrm{heat} = \mathrm{share} \cdot \mathrm{power\_off\_dc}
        \cdot \mathrm{poa\_global}

    The driver may also be ``power_off_ac``. ``share`` is the efficiency over the share
    of irradiance that is heat with power on: 0.2 to 0.3 for silicon.

    References
    ----------
    .. [1] The balance of :func:`pvlib.temperature.pvsyst_cell`, where irradiance
       heats by absorption · (1 - efficiency).
    """
    return Terms(heat=share * power_off_dc * poa_global)


EFFECT = Effect(
    "outage",
    terms,
    {"share": Parameter(0.0, 0.0, 0.5, "-")},
    decided_by="the inverter's log of outages",
    confused_with=(
        "modules_covered",
        "electrical_output",
        "a logger of power that is off while the plant is not",
    ),
)
EFFECT = replace(EFFECT, variants=by_power(EFFECT, "poa_global", "power_off"))
