"""Cooling that depends on wind direction."""

import numpy as np

from pvlib_fem.effects._effect import Effect, Parameter, Terms


def terms(
    wind_north: np.ndarray, wind_east: np.ndarray, *, north: float, east: float
) -> Terms:
    r"""
    Loss that depends on wind direction [1]_.

    .. math::

        \mathrm{loss} = \mathrm{north} \cdot \mathrm{wind\_north}
        + \mathrm{east} \cdot \mathrm{wind\_east}

    Here wind_north is wind_speed · cos(wind_direction) and wind_east is wind_speed ·
    sin(wind_direction), the components of the wind from the north and from the east.

    The windward face is cooled more than the leeward face, and rows or walls shelter
    some directions. The effect is one harmonic: ``north`` is the additional loss per
    m/s of wind from the north, ``east`` that from the east.

    References
    ----------
    .. [1] U.S. Department of Energy, "EnergyPlus Engineering Reference", outside
       surface heat balance: MoWiTT, windward 3.26 v^0.89 and leeward 3.55
       v^0.617 W/(m² K).
    """
    return Terms(loss=north * wind_north + east * wind_east)


EFFECT = Effect(
    "wind_direction",
    terms,
    {
        "north": Parameter(0.0, -10.0, 10.0, "W s/(m³ K)"),
        "east": Parameter(0.0, -10.0, 10.0, "W s/(m³ K)"),
    },
    title="cooling that depends on wind direction",
    decided_by="wind speed and direction measured at the module",
    confused_with=(
        "sky_radiation",
        "other weather that a wind from one side brings, such as cold, dry air",
        "the hours of a sea or valley breeze",
    ),
    imitable=True,  # a wind from one side brings air of its own
)
