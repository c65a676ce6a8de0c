"""A film of water that cools a module, in rain and while it dries."""

from pvlib_fem.effect import Effect, Parameter, Terms


def terms(wetness, *, film):
    """
    Loss by evaporation, taken as a further loss towards the air [1]_.

    ``film`` is the latent over the sensible loss of a wet face: with air of 70 %
    relative humidity the vapour pressure at a warm module makes it some 10 to
    40 W/(m² K).

    References
    ----------
    .. [1] Lewis's relation, h/(rho·c_p·Le^(2/3)) for the transfer of vapour: F. P.
       Incropera et al., "Fundamentals of Heat and Mass Transfer", section 6.7.
    """
    return Terms(loss=film * wetness)


EFFECT = Effect("rain", terms, {"film": Parameter(0.0, 0.0, 200.0, "W/(m² K)")})
