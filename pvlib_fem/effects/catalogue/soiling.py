"""Dirt that gathers between rains, on the module or on the irradiance sensor."""

from dataclasses import replace
from operator import mul

import numpy as np

from pvlib_fem.drivers import Driver
from pvlib_fem.effects.effect import Effect, Parameter, Terms


def terms(poa_global, days_since_rain, *, per_day):
    r"""
    Irradiance that is gained by the module beside its sensor, day by day [1]_.

    .. math::

        \mathrm{heat} = \mathrm{per\_day} \cdot \mathrm{days\_since\_rain}
        \cdot \mathrm{poa\_global}

    Positive where the sensor soils (it reads low, the module is warmer than
    modelled), negative where the module does. Dirt that never changes is in
    the coefficients of the steady model.

    References
    ----------
    .. [1] A. Kimber et al., "The Effect of Soiling on Large Grid-Connected
       Photovoltaic Systems in California and the Southwest Region of the United
       States", WCPEC 2006, :doi:`10.1109/WCPEC.2006.279690`, as in
       :func:`pvlib.soiling.kimber`, which has 0.15 % per day.
    """
    return Terms(heat=per_day * days_since_rain * poa_global)


def cleaned(cleaning=1.0, within=3.0, dirtiest=60.0):
    """
    The effect of dirt that ``cleaning`` mm of rain ``within`` hours take away.

    After ``dirtiest`` days dirt gathers no more. Kimber's are 6 mm in 24 h.
    """
    given = {"cleaning": cleaning, "within": within, "dirtiest": dirtiest}
    return replace(EFFECT, scan=None, scanned_from=None, make=None).made(**given)


def every_rain(poa_global, *days, even, **per_day):
    """Dirt that never changes, and that since each of the rains that may clean."""
    gathered = sum(map(mul, days, per_day.values()))
    return Terms(heat=poa_global * (even + gathered))


def scan(rest, tangents, columns, weeks, least):
    """The rain that cleans: that since which dirt follows what is left best."""
    even = tangents["soiling.even"]
    gathered = [tangents[f"soiling.per_day_{i}"] for i in range(len(RAINS))]
    alike = []
    for one in gathered:
        # what never changes is in the coefficients already, and in the rest no more
        one = one - (one @ even) / (even @ even) * even
        alike.append((rest @ one) ** 2 / (one @ one) if one.any() else 0.0)
    return cleaned(*RAINS[int(np.argmax(alike))])


#: rain that may clean [mm] and within how long [h]: a shower, and Kimber's day
RAINS = ((1.0, 3.0), (3.0, 24.0), (6.0, 24.0))
PER_DAY = Parameter(0.0, -0.01, 0.01, "1/day")
EFFECT = Effect(
    "soiling",
    terms,
    {"per_day": PER_DAY},
    title="soiling between rains",
    decided_by="a cleaning of the sensor and, on another day, of the module",
    confused_with=(
        "season",
        "sensitivity_drift",
        "natural_convection",
        "poa_misalignment",
        "the steady model's coefficients, where the dirt never changes",
    ),
    make=cleaned,
    scan=scan,
    scanned_from=Effect(
        "soiling",
        every_rain,
        {"even": Parameter(0.0, -1.0, 1.0, "-")}
        | {f"per_day_{i}": PER_DAY for i in range(len(RAINS))},
        columns=(
            "poa_global",
            *(Driver("days_since_rain", cleaning=c, within=h) for c, h in RAINS),
        ),
    ),
)
