"""Cooling that is not linear in wind speed."""

import numpy as np

from pvlib_fem.effects._effect import Effect, Parameter, Terms


def terms(
    wind_speed: np.ndarray, *, root: float, stall: float, calm: float = 0.7
) -> Terms:
    r"""
    Loss that is nonlinear in wind, and a loss below the anemometer's threshold [1]_.

    .. math::

        \mathrm{loss} = \mathrm{root} \cdot \sqrt{\mathrm{wind\_speed}}
        + \mathrm{stall} \cdot \exp(-\mathrm{wind\_speed} / \mathrm{calm})

    ``root`` is the loss by the square root of wind, as for a laminar boundary layer.
    At its upper bound it equals the loss by wind of Faiman's modules [2]_, 6.84 W
    s/(m³ K) times wind speed, at 8.5 m/s. ``stall`` applies only below about ``calm``
    (0.7 m/s), where the cups do not turn although the air moves.

    References
    ----------
    .. [1] F. P. Incropera et al., "Fundamentals of Heat and Mass Transfer",
       section 7.2: a flat plate, Nu of Re^(1/2) to Re^(4/5).
    .. [2] D. Faiman, "Assessing the outdoor operating temperature of photovoltaic
       modules", Prog. Photovolt. 16 (2008), :doi:`10.1002/pip.813`.
    """
    still = np.exp(-wind_speed / calm)
    return Terms(loss=root * np.sqrt(wind_speed) + stall * still)


EFFECT = Effect(
    "wind_shape",
    terms,
    {
        "root": Parameter(0.0, -20.0, 20.0, "W s^½/(m^2½ K)"),
        "stall": Parameter(0.0, -10.0, 10.0, "W/(m² K)"),
    },
    confounder=True,
    title="cooling that is not proportional to wind speed",
    decided_by="a sonic anemometer at the module",
    confused_with=(
        "air_shield",
        "natural_convection",
        "poa_misalignment",
        "season",
        "wind at the mast that is not the wind at the module",
        "a time constant that follows the wind, where the dynamics is ewm",
    ),
)
