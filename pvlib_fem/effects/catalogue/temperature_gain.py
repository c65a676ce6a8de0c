"""A gain error of the module's sensor, or a loss that grows with temperature."""

import numpy as np

from pvlib_fem.effects._effect import Effect, Parameter, Terms


def terms(temp_air: np.ndarray, *, gain: float) -> Terms:
    r"""
    Error of the reading that is proportional to air temperature [1]_.

    .. math:: \mathrm{offset} = \mathrm{gain} \cdot \mathrm{temp\_air}

    A gain error of the module's sensor, or of its converter, has this signature, and so
    has the fourth power in longwave loss: 0.2 to 0.3 % more loss per kelvin.

    References
    ----------
    .. [1] IEC 60751:2022, platinum sensors of class B: 0.3 K + 0.005·\|T\|.
    """
    return Terms(offset=gain * temp_air)


EFFECT = Effect(
    "temperature_gain",
    terms,
    {"gain": Parameter(0.0, -0.1, 0.1, "-")},
    confounder=True,
    title="a gain error of the module's temperature sensor",
    decided_by="module against air on overcast, windy nights of all seasons",
    confused_with=(
        "season",
        "poa_misalignment",
        "thermal_storage",
        "an efficiency that falls as the module warms",
    ),
)
