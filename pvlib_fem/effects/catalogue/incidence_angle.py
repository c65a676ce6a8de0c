"""Beam that the glass reflects at high angles of incidence."""

import numpy as np

from pvlib_fem.effects._effect import Effect, Parameter, Terms


def terms(beam: np.ndarray, aoi_projection: np.ndarray, *, b0: float) -> Terms:
    r"""
    Beam reflected in addition to the reflection at normal incidence [1]_.

    .. math::

        \mathrm{heat} = -\mathrm{b0} \cdot \mathrm{beam} \cdot
        \min(1 / \mathrm{aoi\_projection} - 1, 5)

    The dome of a thermopile does not reflect it. A reference cell under the same glass
    does, so ``b0`` is 0 for that.

    References
    ----------
    .. [1] A. F. Souka and H. H. Safwat, "Determination of the optimum orientations
       for the double exposure flat-plate collector and its reflections", Solar
       Energy 10, 170 (1966), as in :func:`pvlib.iam.ashrae`: 1 - b0·(1/cos - 1)
       with 0.05.
    """
    excess = 1.0 / np.maximum(aoi_projection, 0.01) - 1.0
    return Terms(heat=-b0 * beam * np.minimum(excess, 5.0))


EFFECT = Effect(
    "incidence_angle",
    terms,
    {"b0": Parameter(0.0, 0.0, 0.2, "-")},
    confounder=True,
    title="reflection at high angles of incidence",
    decided_by="a reference cell next to the pyranometer",
    confused_with=(
        "natural_convection",
        "poa_misalignment",
        "season",
        "shading",
        "dew after sunrise",
        "the spectrum of a low sun",
    ),
)
