"""Cooling that depends on where the wind comes from."""

import numpy as np

from pvlib_fem.effects.effect import Effect, Parameter, Terms


def terms(wind_speed, wind_direction, *, north, east):
    r"""
    Loss that depends on where the wind comes from [1]_.

    .. math::

        \mathrm{loss} = \mathrm{wind\_speed} \cdot (
        \mathrm{north} \cdot \cos(\mathrm{wind\_direction})
        + \mathrm{east} \cdot \sin(\mathrm{wind\_direction}))

    The air on the windward face is renewed faster than on the leeward one, and
    rows or walls shelter some directions. One harmonic: ``north`` is what wind
    from the north adds to the loss for each m/s, ``east`` from the east.

    References
    ----------
    .. [1] U.S. Department of Energy, "EnergyPlus Engineering Reference", outside
       surface heat balance: MoWiTT, windward 3.26 v^0.89 and leeward 3.55
       v^0.617 W/(m² K).
    """
    angle = np.radians(wind_direction)
    return Terms(loss=wind_speed * (north * np.cos(angle) + east * np.sin(angle)))


EFFECT = Effect(
    "wind_direction",
    terms,
    {
        "north": Parameter(0.0, -10.0, 10.0, "W s/(m³ K)"),
        "east": Parameter(0.0, -10.0, 10.0, "W s/(m³ K)"),
    },
    decided_by="wind speed and direction measured at the module",
    confused_with=(
        "sky_radiation",
        "other weather that a wind from one side brings, such as cold, dry air",
        "the hours of a sea or valley breeze",
    ),
)
