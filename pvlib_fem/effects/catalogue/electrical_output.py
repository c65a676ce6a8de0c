"""Electrical power that leaves the module and does not heat it."""

from dataclasses import replace
from functools import partial

import numpy as np

from pvlib_fem.effects.effect import Effect, Parameter, Terms
from pvlib_fem.effects.plant import by_power

GAMMA = -0.0035  # 1/K, of crystalline silicon's power
MISSING = 0.15  # of the expected power, from which it is curtailed
BRIGHT = 300.0  # W/m², where power tells of efficiency
USED = ("poa_global", "temp_base", "p_dc_per_area")


def terms(p_dc_per_area, *, share):
    r"""
    Heat that leaves as electricity, and stays when it is curtailed [1]_.

    .. math:: \mathrm{heat} = -\mathrm{share} \cdot \mathrm{p\_dc\_per\_area}

    ``share`` is 1 over the absorbed share of irradiance, 1.2 to 1.5. The mean
    efficiency is in the coefficients of the steady model; what is seen is its
    change, by curtailment, clipping or outage.

    References
    ----------
    .. [1] The balance of :func:`pvlib.temperature.pvsyst_cell`, where irradiance
       heats by absorption · (1 - efficiency).
    """
    return Terms(heat=-share * p_dc_per_area)


def curtailed(
    poa_global,
    temp_base,
    p_dc_per_area,
    snow_cover=0.0,
    *,
    share,
    efficiency,
    gamma=GAMMA,
    missing=MISSING,
):
    r"""
    The same of the power that is missing only.

    .. math:: \mathrm{heat} = \mathrm{share} \cdot
       (\mathrm{expected} - \mathrm{p\_dc\_per\_area})

    where ``p_dc_per_area`` is more than ``missing`` (15 %) below ``expected``, that of
    ``efficiency`` at ``temp_base`` with ``gamma`` (-0.35 %/K), and no snow lies;
    elsewhere 0. Power is an irradiance sensor, too: what it knows of the other
    sensor's errors would be taken for heat. Under snow it is the light that is
    missing. Where the loss grows with over-temperature, which the equation does not
    know, ``share`` comes out low: by 10 to 20 % in simulated physics, most on roofs.
    """
    expected = efficiency * poa_global * (1.0 + gamma * (temp_base - 25.0))
    lacks = np.where(snow_cover > 0.0, 0.0, expected - p_dc_per_area)
    return Terms(heat=share * np.where(lacks > missing * expected, lacks, 0.0))


def unused(light_unused_dc, *, share):
    r"""
    The same of power that is missing by a plant's own relation to irradiance.

    .. math:: \mathrm{heat} = \mathrm{share} \cdot \mathrm{light\_unused\_dc}

    or with the driver ``light_unused_ac``. ``share`` is the efficiency over the share
    of irradiance that is heat. Hours without any power are those of :ref:`outage
    <effect-outage>`.
    """
    return Terms(heat=share * light_unused_dc)


def below(efficiency=None, snow=False, gamma=GAMMA, missing=MISSING):
    """
    The effect of power below that of a module of this efficiency. [-]

    Without one the loop takes that of the record. With ``snow`` it needs the depth of
    snow, too, and leaves covered rows out. ``gamma`` is how power falls with
    temperature [1/K], ``missing`` the share that counts as curtailed.
    """
    own = {"gamma": gamma, "missing": missing}
    if efficiency is None:
        return replace(EFFECT, settings=own, prepare=partial(of_record, **own))
    return replace(
        EFFECT,
        terms=partial(curtailed, efficiency=efficiency, **own),
        columns=USED + ("snow_cover",) * snow,
        settings={"efficiency": efficiency, "snow": snow, **own},
        prepare=None,
    )


def of_record(columns, rows, gamma=GAMMA, missing=MISSING):
    """The effect with the efficiency of a record's uncurtailed rows."""
    poa, module, power = (columns[name][rows] for name in USED)
    bright = (poa > BRIGHT) & np.isfinite(module + power)
    # curtailment is rarer than three hours in four, and only ever downwards
    share = power[bright] / (poa * (1.0 + gamma * (module - 25.0)))[bright]
    efficiency = 0.0
    if len(share):
        full = share > (1.0 - missing) * np.quantile(share, 0.75)
        efficiency = float(np.median(share[full]))
    return below(efficiency, "snow_depth" in columns, gamma, missing)


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
    make=below,
    prepare=of_record,
)
BY_PLANT = replace(
    EFFECT, terms=unused, parameters={"share": Parameter(0.0, 0.0, 0.5, "-")}
)
EFFECT = replace(EFFECT, variants=(EFFECT, *by_power(BY_PLANT, "light_unused")))
