"""Irradiance on the rear side of the module, measured or from the ground."""

from dataclasses import replace
from typing import Any

import numpy as np

from pvlib_fem.effects._effect import Effect, Parameter, Terms


def terms(ghi_estimated: np.ndarray, *, share: float) -> Terms:
    r"""
    Heat by irradiance that the ground reflects to the rear side [1]_.

    .. math:: \mathrm{heat} = \mathrm{share} \cdot \mathrm{ghi\_estimated}

    ``share`` is albedo · view of the ground · absorbed share of the back, over
    the absorbed share of the front: 0.1 to 0.3 for an open rack. Most of it is
    in the coefficients of the steady model; the effect is its change with solar
    elevation.

    References
    ----------
    .. [1] B. Marion et al., "A Practical Irradiance Model for Bifacial PV
       Modules", IEEE PVSC 2017, :doi:`10.1109/PVSC.2017.8366263`.
    """
    return Terms(heat=share * ghi_estimated)


def from_rear(poa_rear: Any, *, bifaciality: Any) -> Any:
    r"""
    Heat by irradiance measured on the rear side [2]_.

    .. math:: \mathrm{heat} = \mathrm{bifaciality} \cdot \mathrm{poa\_rear}

    ``bifaciality`` is the ratio of heat by rear irradiance to heat by equal front
    irradiance. For a bifacial module it is near the bifaciality of power, 0.6 to 0.95;
    for other modules it is the ratio of the absorbed shares of back and front. A part
    proportional to front irradiance is in the coefficients of the steady model.

    References
    ----------
    .. [2] IEC TS 60904-1-2:2019, the equivalent irradiance front + bifaciality · rear.
    """
    return Terms(heat=bifaciality * poa_rear)


FROM_GROUND = Effect(
    "rear_irradiance",
    terms,
    {"share": Parameter(0.0, 0.0, 0.5, "-")},
    confounder=True,
    title="irradiance on the rear side",
    decided_by="an albedometer or a rear irradiance sensor",
    confused_with=(
        "natural_convection",
        "season",
        "poa_misalignment",
        "the steady model's coefficients, by its mean",
    ),
)
SOURCE = "measured rear irradiance"
MEASURED = replace(
    FROM_GROUND,
    terms=from_rear,
    parameters={"bifaciality": Parameter(0.0, 0.0, 1.0, "-")},
    confounder=False,
    settings={"source": SOURCE},
    source=SOURCE,
)

#: by the available measurements, the best first
EFFECT = replace(FROM_GROUND, variants=(MEASURED, FROM_GROUND))
