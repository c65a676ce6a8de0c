"""Every effect and fault that can be switched on, by name."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from pvlib_fem.simulator._constants import ZERO

#: Every switch, with the meaning of amplitudes 1 and 0. Nominal sizes are within
#: published ranges: curtailment at spring noon (CAISO), 0.1 to 0.5 % of soiling per
#: day, 2 to 4 K of air sensors in calm sun (Hubbard and Lin 2001), 3 to 15 W/m² of
#: thermopiles at night, loggers late by 6 to 8 s a day (J. Barry's PVRAD).
SWITCHES = {
    # the physical world; PHYSICS has these at 1, LINEAR at 0
    "radiative_loss": "T⁴ exchange; 0: a constant coefficient, at 295 K",
    "natural_convection": "grows with ΔT, by default TARP's ΔT^(1/3); 0: as at 15 K",
    "wind_shape": "by default MoWiTT, in quadrature; 0: a straight line through 3 m/s",
    "incidence_angle": "Fresnel reflection; 0: as at normal incidence",
    "conversion": "efficiency follows temperature and low light; 0: constant",
    # effects with a driver of their own
    "sky_radiation": "sky as cold as the longwave says; 0: as warm as the air",
    "electrical_output": "curtailed to nothing on a calendar; 0: never",
    "wind_direction": "windward, leeward, 30 % shelter; 0: the mean of both",
    "rain": "sensible cooling and film evaporation; 0: dry glass",
    "dew": "condensation and its drying; 0: none",
    "snow": "cover, and bright ground; 0: none",
    "soiling": "module loses 0.3 % of light a day until it rains; 0: clean",
    "soiling_sensor": "the same of the irradiance sensor",
    "shading": "obstacles take their share of the beam, by default 80 % of it at "
    "azimuths of 108–135° and below 28°; 0: none",
    "shading_sensor": "the same before the irradiance sensor",
    "tracker_stuck": "the modules' row of a tracker is stuck on the days of its "
    "site; the irradiance sensor's goes on",
    "tracker_stuck_sensor": "the row of the irradiance sensor does so",
    # shapes
    "thermal_storage": "ground or roof stores heat; 0: it is at air temperature",
    "water": "8 W/(m² K) behind it to a lake that follows air and sun by weeks",
    "rear_irradiance": "light on the back of a rack; 0: dark",
    "season": "4 % more light absorbed in midwinter, 4 % less in midsummer; 0: even",
    "wind_scatter": "wind at the module differs from the mast's, sd 0.3; 0: in step",
    # undeclared heat sources
    "weekend_exhaust": "120 W/m² behind the module on weekends, 9–16 h",
    "chiller": "up to 100 W/m² behind it on warm afternoons of June to August, 13–19 h",
    "irrigation": "−150 W/m² on the glass by a timetable of days, April to "
    "September; by default every second day, 6–7 and 20–21 h",
    "fan": "100 W/m² behind it by a timetable of minutes; by default 35 of every 150",
    "shelter": "50 W/m² behind it on nights from October to April (animals)",
    # causes that are not in the catalogue of effects
    "reflection": "a façade mirrors 20 % of the beam onto the module, not its sensor",
    "plume": "50 W/m² behind it while wind comes from one direction",
    "puddles": "−10 % of irradiance behind it after rain, until the ground is dry",
    "sea_breeze": "air at it 3 K colder on sunny afternoons of the warm half year",
    "misters": "air at it cooled by 15 % of air less dew point, in heat and by hours",
    "fog": "up to −80 W/m² on the glass on mornings after humid nights",
    "inverter_hall": "up to 75 W/m² behind it, by power and in warm air only",
    "compost": "up to 60 W/m² behind it, for weeks once in 1 to 3 months",
    "lorries": "30 % of the wind is gone on workdays, by hours",
    "charger": "module sensor 1.2 K high while a battery charges, from sunrise",
    "frozen_contact": "module sensor loses 20 % of the over-temperature in frost",
    # sensors
    "poa_misalignment": "irradiance sensor turned west by 1° (an amplitude in degrees)",
    "irradiance_gain": "irradiance sensor reads 2 % high",
    "irradiance_offset": "thermopile reads 5 % of the net longwave low",
    "irradiance_sensor_drift": "irradiance sensor loses 5 % a year",
    "temperature_gain": "module sensor reads 3 % of its °C low",
    "temperature_drift": "module sensor gains 1 K a year",
    "air_shield": "air sensor is 2 K warm in full sun and calm; 0: aspirated",
    "wind_stall": "cups do not turn below 1 m/s (an amplitude in m/s)",
    # loggers
    "clock_shift": "module logger's record is 1 min late (an amplitude in minutes)",
    "clock_drift": "it gets later by 1 s a day (an amplitude in s/day)",
    "dst": "it keeps summer time, 1 h ahead from March to October",
    "file_shift": "the whole file is 1 min late (an amplitude in minutes)",
    "file_dst": "the whole file keeps summer time",
    "stuck": "module temperature freezes for 12 h once in 30 days",
    "missing": "2 % of the rows are lost, in blocks of hours",
}
#: one mass, linear heat balance
LINEAR: dict[str, float] = {}
#: physics that is always there, and no effect with a driver of its own
PHYSICS = dict.fromkeys(list(SWITCHES)[:5], 1.0)
#: an ordinary site
OUTDOORS = PHYSICS | dict.fromkeys(
    [
        "sky_radiation",
        "wind_direction",
        "rain",
        "dew",
        "snow",
        "thermal_storage",
        "rear_irradiance",
        "wind_scatter",
        "irradiance_offset",
    ],
    1.0,
)
#: conversion of a column to a wrong unit, for ``{"swap": {"wind_speed": "km/h"}}``
UNITS = {
    "degF": lambda x: 1.8 * x + 32.0,
    "K": lambda x: x + ZERO,
    "km/h": lambda x: 3.6 * x,
    "mph": lambda x: 2.23694 * x,
    "kW/m2": lambda x: x / 1000.0,
    "fraction": lambda x: x / 100.0,
}


#: amplitudes by switch; `swap` has units by column
Effects = Mapping[str, float | Mapping[str, str]]


def amplitudes(effects: Effects) -> dict[str, float]:
    """
    All switches by name.

    Parameters
    ----------
    effects : dict
        Amplitudes by switch; ``swap`` is ignored.

    Returns
    -------
    dict of float
        0 for switches that ``effects`` does not name.

    Raises
    ------
    ValueError
        If a switch is unknown, or an amplitude is not finite.
    """
    if unknown := sorted(set(effects) - {*SWITCHES, "swap"}):
        raise ValueError(
            f"unknown switch {', '.join(map(repr, unknown))}; "
            f"there are {', '.join(SWITCHES)} and swap"
        )
    given: Mapping[str, Any] = effects
    values = {name: float(given.get(name, 0.0)) for name in SWITCHES}
    if wrong := [name for name, value in values.items() if not np.isfinite(value)]:
        raise ValueError(f"amplitude of {wrong} must be a finite number")
    return values
