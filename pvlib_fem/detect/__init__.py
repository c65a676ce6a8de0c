"""
Single checks of single sensors.

Each function takes Series, as pvanalytics does, and returns a small result with a
Boolean Series. None needs a fitted model.
"""

from pvlib_fem.detect._changes import LevelChanges
from pvlib_fem.detect._module_sensor import DetachedSensor, detached_module_sensor
from pvlib_fem.detect._sensor_gain import irradiance_changes, slow_anemometer
from pvlib_fem.detect._shifted_clock import TimeShifts, time_shifts
from pvlib_fem.detect._shifted_level import data_shifts

__all__ = [
    "DetachedSensor",
    "LevelChanges",
    "TimeShifts",
    "data_shifts",
    "detached_module_sensor",
    "irradiance_changes",
    "slow_anemometer",
    "time_shifts",
]
