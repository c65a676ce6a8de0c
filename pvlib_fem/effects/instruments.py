"""
What happens to instruments and mountings: channels, each along every course.

A channel is an effect of constant size that has one parameter. Constant it would be in
the coefficients of the steady model, but for those of :data:`OF_NO_COEFFICIENT`; from a
date on, slowly or for a while it is not.
"""

import numpy as np

from pvlib_fem.effects.effect import Effect, Parameter, Terms


def sensitivity(poa_global, *, change):
    r"""
    Irradiance that the module gains beside its sensor [1]_.

    .. math::

        \mathrm{heat} = \mathrm{change} \cdot \mathrm{poa\_global}

    Positive where the sensor reads less than before: it fades, soils or is tilted
    away, or is calibrated anew.

    References
    ----------
    .. [1] ISO 9060:2018: non-stability of pyranometers, 0.8 to 3 % per year by
       class.
    """
    return Terms(heat=change * poa_global)


def mounting(loss_base, *, change):
    r"""
    Loss that a module has more than before, as a share [1]_.

    .. math::

        \mathrm{loss} = \mathrm{change} \cdot \mathrm{loss\_base}

    Negative where the module is mounted closer, its cavity is closed, or plants or
    walls shelter it; ``loss_base`` is the loss by the model's own coefficients, as
    before the change.

    References
    ----------
    .. [1] D. Faiman, "Assessing the outdoor operating temperature of photovoltaic
       modules", Prog. Photovolt. 16, 307-315, 2008, :doi:`10.1002/pip.813`: the loss
       is one of the mounting. Those that PVsyst suggests are 29 W/(m² K) free, 20
       with a duct and 15 against a wall.
    """
    return Terms(loss=change * loss_base)


def contact(temp_air, *, change):
    r"""
    Share of the over-temperature that a sensor reads more than before [1]_.

    .. math::

        \mathrm{gain} = \mathrm{change}

    Negative where the sensor comes off the back of the module and reads air in part;
    positive where it is mounted anew, or insulated.

    References
    ----------
    .. [1] IEC 61724-1, annex B: how temperature sensors at a module's back are to be
       chosen and attached.
    """
    return Terms(gain=change + 0.0 * temp_air)


def wind_gain(wind_speed, *, change):
    r"""
    Loss by each m/s of wind that is told more than before.

    .. math::

        \mathrm{loss} = \mathrm{change} \cdot \mathrm{wind\_speed}

    Positive where the anemometer reads less than before: a worn bearing, a new wall
    upwind of it. Then the loss by wind is the same, and each m/s that is read has
    more of it.
    """
    return Terms(loss=change * wind_speed)


def wind_stall(wind_speed, *, change, below=1.5):
    r"""
    Loss by wind that an anemometer no longer turns in.

    .. math::

        \mathrm{loss} = \mathrm{change}
        \cdot \max(\mathrm{below} - \mathrm{wind\_speed}, 0)

    ``below`` is the wind in which it turns again as it should. [m/s]
    """
    return Terms(loss=change * np.maximum(below - wind_speed, 0.0))


def air_offset(air_base, *, change):
    r"""
    Air that is warmer than its thermometer says, more than before.

    .. math::

        \mathrm{heat} = \mathrm{change} \cdot \mathrm{air\_base}

    ``air_base`` is the heat per K of air by the fitted model. With a sky in the model
    it is less than the loss: radiation to the sky, whose longwave is measured, does
    not depend on the air's thermometer.
    """
    return Terms(heat=change * air_base)


def air_shelter(poa_global, air_base, *, change):
    r"""
    Air temperature that is measured too warm in sun, more than before.

    .. math::

        \mathrm{heat} = -\mathrm{change} \cdot \mathrm{poa\_global} / 1000
        \cdot \mathrm{air\_base}

    ``change`` is the error at 1000 W/m²: a shield that is lost or soiled, a fan that
    stands still. ``air_base`` as of an offset of the thermometer.
    """
    return Terms(heat=-change * poa_global / 1000.0 * air_base)


def module_offset(temp_air, *, change):
    r"""
    Offset of the module's thermometer: another sensor, another logger card.

    .. math::

        \mathrm{offset} = \mathrm{change}
    """
    return Terms(offset=change + 0.0 * temp_air)


#: what happens to the weather station, and so to all modules that share it
STATION = ("sensitivity", "wind_gain", "wind_stall", "air_offset", "air_shelter")

#: whose constant part no coefficient of a steady model takes up
OF_NO_COEFFICIENT = ("wind_stall", "air_shelter")

CHANNELS = (
    Effect(
        "sensitivity",
        sensitivity,
        {"change": Parameter(0.0, -0.5, 1.0, "-")},
        decided_by="a recalibration of the irradiance sensor, or power and a clear sky "
        "beside it",
        confused_with=(
            "contact",
            "mounting",
            "season",
            "soiling",
            "a module that ages",
        ),
    ),
    Effect(
        "contact",
        contact,
        {"change": Parameter(0.0, -0.95, 1.0, "-")},
        decided_by="an inspection of the sensor at the module's back",
        confused_with=("sensitivity", "mounting", "season", "a module that ages"),
    ),
    Effect(
        "mounting",
        mounting,
        {"change": Parameter(0.0, -0.6, 1.5, "-")},
        decided_by="an inspection of the mounting, and what was built or grew around",
        confused_with=("sensitivity", "contact", "season", "a module that ages"),
    ),
    Effect(
        "wind_gain",
        wind_gain,
        {"change": Parameter(0.0, -10.0, 40.0, "W s/(m³ K)")},
        decided_by="a second anemometer",
        confused_with=("wind_direction", "wind_shape"),
    ),
    Effect(
        "wind_stall",
        wind_stall,
        {"change": Parameter(0.0, 0.0, 40.0, "W s/(m³ K)")},
        decided_by="a second anemometer",
        confused_with=("wind_shape", "natural_convection"),
    ),
    Effect(
        "air_offset",
        air_offset,
        {"change": Parameter(0.0, -10.0, 10.0, "K")},
        decided_by="a second thermometer in the air",
        confused_with=("an offset of the module's thermometer",),
    ),
    Effect(
        "air_shelter",
        air_shelter,
        {"change": Parameter(0.0, -10.0, 10.0, "K")},
        decided_by="a second, aspirated air temperature sensor",
        confused_with=("air_shield",),
    ),
    Effect(
        "module_offset",
        module_offset,
        {"change": Parameter(0.0, -10.0, 10.0, "K")},
        decided_by="a second thermometer at the module",
        confused_with=("an offset of the air's thermometer",),
    ),
)
