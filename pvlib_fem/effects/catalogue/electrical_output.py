"""Electrical power, which does not heat the module."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from pvlib_fem.effects._effect import Effect, Parameter, Terms
from pvlib_fem.effects._plant_power import by_power

GAMMA = -0.0035  # 1/K, of crystalline silicon's power
MISSING = 0.15  # of the expected power; if more is missing, power is curtailed
BRIGHT = 300.0  # W/m², above which power determines the efficiency
USED = ("poa_global", "temp_base", "p_dc_per_area")


def terms(p_dc_per_area: np.ndarray, *, share: float) -> Terms:
    r"""
    Heat that leaves as electricity, and remains when power is curtailed [1]_.

    .. math:: \mathrm{heat} = -\mathrm{share} \cdot \mathrm{p\_dc\_per\_area}

    ``share`` is 1 over the absorbed share of irradiance, 1.2 to 1.5. The mean
    efficiency is in the coefficients of the steady model; the effect is its change, by
    curtailment, clipping or outage.

    References
    ----------
    .. [1] The balance of :func:`pvlib.temperature.pvsyst_cell`, where irradiance
       heats by absorption · (1 - efficiency).
    """
    return Terms(heat=-share * p_dc_per_area)


def curtailed(
    poa_global: np.ndarray,
    temp_base: Any,
    p_dc_per_area: np.ndarray,
    snow_cover: float | np.ndarray = 0.0,
    *,
    share: float,
    efficiency: float,
    gamma: float = GAMMA,
    missing: float = MISSING,
) -> Terms:
    r"""
    Heat by curtailed power alone.

    .. math:: \mathrm{heat} = \mathrm{share} \cdot
       (\mathrm{expected} - \mathrm{p\_dc\_per\_area})

    This applies where ``p_dc_per_area`` is more than ``missing`` (15 %) below
    ``expected``, the power by ``efficiency`` at ``temp_base`` with ``gamma``
    (-0.35 %/K), and no snow lies; elsewhere the heat is 0. Power also measures
    irradiance, so small differences would be errors of the irradiance sensor and not
    heat. Under snow, power is missing because light is. If the loss grows with
    over-temperature, which is not in the equation, ``share`` is biased low, by 10 to
    20 % in simulated physics, most on roofs.
    """
    expected = efficiency * poa_global * (1.0 + gamma * (temp_base - 25.0))
    deficit = np.where(snow_cover > 0.0, 0.0, expected - p_dc_per_area)
    return Terms(heat=share * np.where(deficit > missing * expected, deficit, 0.0))


def unused(light_unused_dc: np.ndarray, *, share: float) -> Terms:
    r"""
    Heat by missing power, relative to a plant's own relation of power to irradiance.

    .. math:: \mathrm{heat} = \mathrm{share} \cdot \mathrm{light\_unused\_dc}

    The driver may also be ``light_unused_ac``. ``share`` is the efficiency over the
    share of irradiance that is heat. Hours without any power belong to :ref:`outage
    <effect-outage>`.
    """
    return Terms(heat=share * light_unused_dc)


def low_output_effect(
    efficiency: float | None = None,
    snow: bool = False,
    gamma: float = GAMMA,
    missing: float = MISSING,
) -> Effect:
    """
    The effect of power below the expected power of a module of this efficiency. [-]

    By default the loop estimates the efficiency from the record. With ``snow`` the
    effect needs snow depth, too, and is 0 in covered rows. ``gamma`` is the temperature
    coefficient of power [1/K]; if more than the share ``missing`` is missing, power
    counts as curtailed.
    """
    own: dict[str, Any] = {"gamma": gamma, "missing": missing}
    if efficiency is None:
        return replace(EFFECT, settings=own, prepare=partial(of_record, **own))
    return replace(
        EFFECT,
        terms=partial(curtailed, efficiency=efficiency, **own),
        columns=USED + ("snow_cover",) * snow,
        settings={"efficiency": efficiency, "snow": snow, **own},
        prepare=None,
    )


def of_record(
    columns: Any, rows: np.ndarray, gamma: float = GAMMA, missing: float = MISSING
) -> Effect:
    """The effect with the efficiency of a record's uncurtailed rows."""
    poa, module, power = (columns[name][rows] for name in USED)
    bright = (poa > BRIGHT) & np.isfinite(module + power)
    # less than three quarters of the hours are curtailed, and power only falls
    share = power[bright] / (poa * (1.0 + gamma * (module - 25.0)))[bright]
    efficiency = 0.0
    if len(share):
        full = share > (1.0 - missing) * np.quantile(share, 0.75)
        efficiency = float(np.median(share[full]))
    return low_output_effect(efficiency, "snow_depth" in columns, gamma, missing)


EFFECT = Effect(
    "electrical_output",
    terms,
    {"share": Parameter(0.0, 0.0, 4.0, "-")},
    title="heat that leaves the modules as electricity",
    decided_by="the inverter's log of limits and outages",
    confused_with=(
        "snow",
        "natural_convection",
        "an error of the irradiance sensor, which power measures, too",
    ),
    source="power per area",
    make=low_output_effect,
    prepare=of_record,
)
BY_PLANT = replace(
    EFFECT, terms=unused, parameters={"share": Parameter(0.0, 0.0, 0.5, "-")}
)
OTHERS = [e for e in by_power(BY_PLANT, "light_unused") if e.source not in USED]
EFFECT = replace(EFFECT, variants=(EFFECT, *OTHERS))
