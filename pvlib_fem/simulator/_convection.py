"""Convection of the two faces, without and with wind, in several formulations.

Each function is named as in `pvlib_fem.simulator._submodels.RIVALS`.
"""

from collections.abc import Callable

import numpy as np

# dry air at 300 K, 1 atm: F. P. Incropera et al., "Fundamentals of heat and mass
# transfer", table A.4
CONDUCTIVITY, VISCOSITY, DIFFUSIVITY, PRANDTL = 0.0263, 1.589e-5, 2.25e-5, 0.707
RAYLEIGH = 9.81 / 300.0 / (VISCOSITY * DIFFUSIVITY)  # 1/(K m³), Ra/(ΔT L³)
LENGTH, WIDTH = 1.6, 1.0  # m, of a module
#: natural convection [W/(m² K)] by the over-temperature of both faces
Natural = Callable[[np.ndarray], np.ndarray]
Number = float | np.ndarray
WINDWARD, LEEWARD = (3.26, 0.89), (3.55, 0.617)  # MoWiTT a, b of a·v^b


def tarp(tilt: float | np.ndarray) -> Natural:
    """
    A multiple of |ΔT|^(1/3), larger on warm faces upwards and cold faces downwards.

    TARP: G. N. Walton, "Thermal analysis research program", NBSIR 83-2655 (1983),
    as in the EnergyPlus Engineering Reference.
    """
    cosine = np.cos(np.radians(tilt))
    freely, stably = 9.482 / (7.283 - abs(cosine)), 1.81 / (1.382 + abs(cosine))
    return lambda excess: np.cbrt(np.abs(excess)) * by_side(excess, freely, stably)


def churchill_chu(tilt: float | np.ndarray) -> Natural:
    """
    An isothermal vertical plate, with the component of gravity along an inclined one.

    S. W. Churchill and H. H. S. Chu, Int. J. Heat Mass Transf. 18, 1323 (1975),
    :doi:`10.1016/0017-9310(75)90243-4`. Tilts below 30° count as 30°, the lowest for
    which that component is valid.
    """
    along = np.sin(np.radians(np.maximum(tilt, 30.0)))
    pull = 0.387 / (1.0 + (0.492 / PRANDTL) ** (9 / 16)) ** (8 / 27)
    pull *= (RAYLEIGH * along * LENGTH**3) ** (1 / 6)
    scale = CONDUCTIVITY / LENGTH
    return lambda excess: scale * (0.825 + pull * np.abs(excess) ** (1 / 6)) ** 2


def mcadams(tilt: float | np.ndarray) -> Natural:
    """
    A horizontal plate: Nu = 0.14 Ra^(1/3) upwards, 0.27 Ra^(1/4) downwards.

    W. H. McAdams, "Heat transmission", 3rd ed. (1954).
    """
    freely = 0.14 * CONDUCTIVITY * RAYLEIGH ** (1 / 3)
    stably = 0.27 * CONDUCTIVITY * (RAYLEIGH / WIDTH) ** (1 / 4)

    def law(excess: np.ndarray) -> np.ndarray:
        size = np.abs(excess)
        return by_side(excess, freely * np.cbrt(size), stably * np.sqrt(np.sqrt(size)))

    return law


def by_side(
    excess: np.ndarray, freely: float | np.ndarray, stably: float | np.ndarray
) -> np.ndarray:
    """One value for faces that warm air can leave, and another for the other faces."""
    leaves = excess > 0
    leaves[1] = ~leaves[1]  # the back looks down
    return np.where(leaves, freely, stably)


def mowitt(speed: Number, luff: Number) -> Number:
    """
    ``a·v^b`` of windward and leeward faces, with the share ``luff`` of windward.

    M. Yazdanian and J. H. Klems, ASHRAE Trans. 100, 1087 (1994).
    """
    (a, b), (c, d) = WINDWARD, LEEWARD
    return luff * (a * speed**b) + (1 - luff) * (c * speed**d)


def flat_plate(speed: Number, luff: Number) -> Number:
    """
    Turbulent flow along a flat plate: Nu = 0.037 Re^0.8 Pr^(1/3).

    Incropera et al.: the mean over a boundary layer that the frame makes turbulent.
    """
    reynolds = speed * LENGTH / VISCOSITY
    return 0.037 * CONDUCTIVITY / LENGTH * reynolds**0.8 * PRANDTL ** (1 / 3)


def sparrow(speed: Number, luff: Number) -> Number:
    """
    An inclined plate of finite width: Nu = 0.86 Re^(1/2) Pr^(1/3).

    E. M. Sparrow, J. W. Ramsey and E. A. Mass, J. Heat Transfer 101, 199 (1979); the
    length is 4 area/perimeter.
    """
    length = 2 * LENGTH * WIDTH / (LENGTH + WIDTH)
    root = np.sqrt(speed * length / VISCOSITY)
    return 0.86 * CONDUCTIVITY / length * root * PRANDTL ** (1 / 3)


def watmuff(speed: Number, luff: Number) -> Number:
    """
    A linear law of 3 W m⁻² K⁻¹ per m/s.

    J. H. Watmuff, W. W. S. Charters and D. Proctor, COMPLES 2, 56 (1977); their
    2.8 W m⁻² K⁻¹ without wind is natural convection here.
    """
    return 3.0 * speed


NATURAL = {law.__name__: law for law in (tarp, churchill_chu, mcadams)}
FORCED = {law.__name__: law for law in (mowitt, flat_plate, sparrow, watmuff)}
