"""Light from the ground on the back of the module."""

from pvlib_fem.effects.effect import Effect, Parameter, Terms


def terms(ghi_estimated, *, share):
    r"""
    Heat of light from the ground [1]_.

    .. math:: \mathrm{heat} = \mathrm{share} \cdot \mathrm{ghi\_estimated}

    ``share`` is albedo · view of the ground · absorbed share of the back, over
    the absorbed share of the front: 0.1 to 0.3 for an open rack. Most of it is
    in the coefficients of the steady model; what is seen is its change with the sun's
    height.

    References
    ----------
    .. [1] B. Marion et al., "A Practical Irradiance Model for Bifacial PV
       Modules", IEEE PVSC 2017, :doi:`10.1109/PVSC.2017.8366263`.
    """
    return Terms(heat=share * ghi_estimated)


EFFECT = Effect(
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
