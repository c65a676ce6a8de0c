"""
Faults of sensors and changes of mountings, each with every time profile.

A fault is an effect of constant size with one parameter. A permanent fault is part of
the coefficients of the steady model, except for :data:`OF_NO_COEFFICIENT`. A step, a
trend or a temporary fault is not.
"""

import numpy as np

from pvlib_fem.effects._effect import Effect, Parameter, Terms

TURNS_FROM = 1.5  # m/s, from which an anemometer that stalls turns as it should


def irradiance_sensor(poa_global: np.ndarray, *, change: float) -> Terms:
    r"""
    Irradiance that the module receives in addition to the sensor's reading [1]_.

    .. math::

        \mathrm{heat} = \mathrm{change} \cdot \mathrm{poa\_global}

    It is positive if the sensor reads less than before: it loses sensitivity, soils, is
    tilted away, or has a new calibration. It is also positive if the modules receive
    more than before: they were cleaned, or the ground is brighter. Temperature and
    power cannot tell these apart, and power may not show light on the rear; a clear sky
    or a second irradiance sensor can.

    References
    ----------
    .. [1] ISO 9060:2018: non-stability of pyranometers, 0.8 to 3 % per year by
       class.
    """
    return Terms(heat=change * poa_global)


def mounting(loss_base: np.ndarray, *, change: float) -> Terms:
    r"""
    Additional loss of a module, as a share of the former loss [1]_.

    .. math::

        \mathrm{loss} = \mathrm{change} \cdot \mathrm{loss\_base}

    It is negative if the module is mounted closer to the roof, its cavity is closed, or
    plants or walls shelter it. ``loss_base`` is the loss by the model's coefficients,
    as before the change.

    References
    ----------
    .. [1] D. Faiman, "Assessing the outdoor operating temperature of photovoltaic
       modules", Prog. Photovolt. 16, 307-315, 2008, :doi:`10.1002/pip.813`: the loss
       depends on the mounting. PVsyst suggests 29 W/(m² K) for free mounting, 20 with
       a duct and 15 against a wall.
    """
    return Terms(loss=change * loss_base)


def module_sensor_contact(temp_air: np.ndarray, *, change: float) -> Terms:
    r"""
    Share of the over-temperature that a sensor reads in addition [1]_.

    .. math::

        \mathrm{gain} = \mathrm{change}

    It is negative if the sensor detaches from the back of the module and partly reads
    the air. It is positive if the sensor is attached again, or insulated.

    References
    ----------
    .. [1] IEC 61724-1, annex B: selection and attachment of temperature sensors at
       the back of a module.
    """
    return Terms(gain=change + 0.0 * temp_air)


def anemometer(wind_speed: np.ndarray, *, change: float) -> Terms:
    r"""
    Additional loss per m/s of measured wind.

    .. math::

        \mathrm{loss} = \mathrm{change} \cdot \mathrm{wind\_speed}

    It is positive if the anemometer reads less than before: a worn bearing, or a new
    wall upwind of it. The loss by wind is then unchanged, so there is more of it per
    m/s of the reading.
    """
    return Terms(loss=change * wind_speed)


def anemometer_stall(
    wind_speed: np.ndarray, *, change: float, below: float = TURNS_FROM
) -> Terms:
    r"""
    Loss by wind in which an anemometer no longer turns.

    .. math::

        \mathrm{loss} = \mathrm{change}
        \cdot \max(\mathrm{below} - \mathrm{wind\_speed}, 0)

    ``below`` is the wind above which it turns as it should. [m/s]
    """
    return Terms(loss=change * np.maximum(below - wind_speed, 0.0))


def air_offset(air_base: np.ndarray, *, change: float) -> Terms:
    r"""
    Air that is warmer than its thermometer reads, compared with before.

    .. math::

        \mathrm{heat} = \mathrm{change} \cdot \mathrm{air\_base}

    ``air_base`` is the heat per K of air by the fitted model. If the model includes
    radiation to the sky, it is less than the loss: this radiation, with measured
    longwave, does not depend on the air thermometer.
    """
    return Terms(heat=change * air_base)


def air_sensor_shield(
    poa_global: np.ndarray, air_base: np.ndarray, *, change: float
) -> Terms:
    r"""
    Air temperature that is measured too warm in sun, compared with before.

    .. math::

        \mathrm{heat} = -\mathrm{change} \cdot \mathrm{poa\_global} / 1000
        \cdot \mathrm{air\_base}

    ``change`` is the error at 1000 W/m², for example of a lost or soiled shield or a
    fan that stopped. ``air_base`` is the heat per K of air by the fitted model.
    """
    return Terms(heat=-change * poa_global / 1000.0 * air_base)


def module_offset(temp_air: np.ndarray, *, change: float) -> Terms:
    r"""
    Offset of the module's thermometer, for example by a new sensor or logger card.

    .. math::

        \mathrm{offset} = \mathrm{change}
    """
    return Terms(offset=change + 0.0 * temp_air)


def time_constant(capacity_base: np.ndarray, *, change: float) -> Terms:
    r"""
    Additional heat capacity, as a share of the former one.

    .. math::

        \mathrm{capacity} = \mathrm{change} \cdot \mathrm{capacity\_base}

    It is positive if the measured module temperature follows irradiance more slowly
    than before: its sensor sits in a thicker pad, its logger averages over a longer
    time, or there is a new mass behind the module. It is negative if irradiance is
    logged later than before. ``capacity_base`` is the capacity by the model's
    coefficients, as before the change; of the EWM it is that of its time constant in
    the wind of each row.
    """
    return Terms(capacity=change * capacity_base)


#: faults of the weather station, which all modules that share it have in common
STATION = (
    "irradiance_sensor",
    "anemometer",
    "anemometer_stall",
    "air_offset",
    "air_sensor_shield",
)

#: sensor faults whose constant part no coefficient of a steady model can absorb
OF_NO_COEFFICIENT = ("anemometer_stall", "air_sensor_shield")

#: sensor faults that are the same at all hours and in any weather
OFFSETS = ("air_offset", "module_offset")

#: sensor faults of how fast the measured module temperature follows
INERTIA = ("time_constant",)

#: bounds of both faults that have the terms of more light: one of them is searched for
MORE_LIGHT = Parameter(0.0, -0.5, 1.0, "-")

SENSOR_FAULTS = (
    Effect(
        "irradiance_sensor",
        irradiance_sensor,
        {"change": MORE_LIGHT},
        decided_by="a recalibration of the irradiance sensor, or a comparison with "
        "power and a clear sky",
        confused_with=(
            "module_irradiance",
            "module_sensor_contact",
            "mounting",
            "season",
            "soiling",
            "a module that ages",
        ),
    ),
    Effect(
        "module_irradiance",
        irradiance_sensor,
        {"change": MORE_LIGHT},
        decided_by="a look at the modules and the ground, or a comparison of the "
        "irradiance sensor with a clear sky or a second sensor",
        confused_with=(
            "irradiance_sensor",
            "module_sensor_contact",
            "mounting",
            "season",
            "soiling",
        ),
    ),
    Effect(
        "module_sensor_contact",
        module_sensor_contact,
        {"change": Parameter(0.0, -0.95, 1.0, "-")},
        decided_by="an inspection of the sensor at the module's back",
        confused_with=("irradiance_sensor", "mounting", "season", "a module that ages"),
    ),
    Effect(
        "mounting",
        mounting,
        {"change": Parameter(0.0, -0.6, 1.5, "-")},
        decided_by="an inspection of the mounting, and what was built or grew around",
        confused_with=(
            "irradiance_sensor",
            "module_sensor_contact",
            "season",
            "a module that ages",
        ),
    ),
    Effect(
        "anemometer",
        anemometer,
        {"change": Parameter(0.0, -10.0, 40.0, "W s/(m³ K)")},
        decided_by="a second anemometer",
        confused_with=("wind_direction", "wind_shape"),
    ),
    Effect(
        "anemometer_stall",
        anemometer_stall,
        {"change": Parameter(0.0, 0.0, 40.0, "W s/(m³ K)")},
        decided_by="a second anemometer",
        confused_with=("wind_shape", "natural_convection"),
    ),
    Effect(
        "air_offset",
        air_offset,
        {"change": Parameter(0.0, -20.0, 20.0, "K")},
        decided_by="a second thermometer in the air",
        confused_with=("an offset of the module's thermometer",),
    ),
    Effect(
        "air_sensor_shield",
        air_sensor_shield,
        {"change": Parameter(0.0, -10.0, 10.0, "K")},
        decided_by="a second, aspirated air temperature sensor",
        confused_with=("air_shield",),
    ),
    Effect(
        "module_offset",
        module_offset,
        {"change": Parameter(0.0, -20.0, 20.0, "K")},
        decided_by="a second thermometer at the module",
        confused_with=("an offset of the air's thermometer",),
    ),
    Effect(
        "time_constant",
        time_constant,
        {"change": Parameter(0.0, -0.9, 10.0, "-")},
        decided_by="an inspection of the sensor at the module's back, and the logger's "
        "settings before and after",
        confused_with=("thermal_storage", "a clock that is late"),
    ),
)
