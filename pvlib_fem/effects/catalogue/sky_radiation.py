"""Longwave loss to a sky that is colder than the air."""

from dataclasses import replace
from functools import partial

import numpy as np

from pvlib_fem.drivers import Driver
from pvlib_fem.effects._effect import Effect, Parameter, Terms
from pvlib_fem.effects._scans import best_setting


def terms(sky_deficit: np.ndarray, *, share: float) -> Terms:
    r"""
    Radiative heat loss to the sky, expressed as equivalent irradiance [1]_.

    .. math:: \mathrm{heat} = -\mathrm{share} \cdot \mathrm{sky\_deficit}

    ``share`` is emissivity · sky view over the absorbed share of irradiance, because
    the steady models express heat as incident irradiance. On a rack both faces together
    see one whole sky, which gives about 0.88/0.72; on a roof only the front sees its
    part of the sky. pvlib's ``faiman_rad`` has emissivity · sky view alone.

    References
    ----------
    .. [1] A. Driesse, J. S. Stein and M. Theristis, "Improving Common PV Module
       Temperature Models by Incorporating Radiative Losses to the Sky",
       SAND2022-11604, 2022, :doi:`10.2172/1884890`, as in
       :func:`pvlib.temperature.faiman_rad`.
    """
    return Terms(heat=-share * sky_deficit)


def of_clouds(cloud_base: float = 0.84, cloud_memory: float = 3.0) -> Effect:
    """
    The sky by air temperature and the clouds of the day.

    Clouds close the share ``cloud_base`` of the deficit of a clear sky: 0.84 if they
    are low [1]_, less the higher they are. They are seen by day, and forgotten with the
    time constant ``cloud_memory``. [h] The scan takes the share that the record shows.

    References
    ----------
    .. [1] M. H. Unsworth and J. L. Monteith, "Long-wave radiation at the ground. I.
       Angular distribution of incoming radiation", Q. J. R. Meteorol. Soc. 101, 13
       (1975), :doi:`10.1002/qj.49710142703`.
    """
    clouds = {"cloud_base": cloud_base, "cloud_memory": cloud_memory}
    return FROM_CLOUDS.unscanned.made(**clouds)


def all_clouds(*deficits: np.ndarray, **shares: float) -> Terms:
    """Skies with clouds of each height."""
    # a slope has one of them
    taken = sum(size * one for one, size in zip(deficits, shares.values()) if size)
    return Terms(heat=0.0 * deficits[0] - taken)


#: shares of the deficit that clouds may close, up to that of low ones
CLOSED = (0.0, 0.2, 0.4, 0.6, 0.84)
SHARE = Parameter(0.0, 0.0, 3.0, "-")
MEASURED = Effect(
    "sky_radiation",
    terms,
    {"share": SHARE},
    title="radiative heat loss to a cold sky",
    decided_by="a pyrgeometer",
    source="measured longwave",
    confused_with=(
        "season",
        "temperature_gain",
        "dew at night",
        "a thermopile pyranometer that reads below zero under a clear night sky",
        "the bias, by its mean",
        "air_elsewhere",
    ),
)
FROM_HUMIDITY = MEASURED.estimated("humidity", "sky_deficit_humid")
FROM_MOISTURE = MEASURED.estimated("humidity, without clouds", "sky_deficit_moist")
FROM_CLOUDS = replace(
    MEASURED.estimated("clouds of the day", "sky_deficit_clouds", confounder=True),
    make=of_clouds,
    scan=partial(
        best_setting,
        parameter="sky_radiation.share",
        settings=[{"cloud_base": closed} for closed in CLOSED],
        make=of_clouds,
    ),
    scanned_from=Effect(
        "sky_radiation",
        all_clouds,
        {f"share_{i}": SHARE for i in range(len(CLOSED))},
        columns=tuple(Driver("sky_deficit_clouds", cloud_base=c) for c in CLOSED),
    ),
)
FROM_AIR = MEASURED.estimated(
    "air temperature alone", "sky_deficit_air", confounder=True
)

#: by the known quantities of the sky, the best first
VARIANTS = (MEASURED, FROM_HUMIDITY, FROM_CLOUDS, FROM_MOISTURE, FROM_AIR)
EFFECT = replace(MEASURED, variants=VARIANTS)
