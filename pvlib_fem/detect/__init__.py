"""
Single checks of single sensors.

Each function takes Series, as pvanalytics does, and returns a small result with a
Boolean Series. None needs a fitted model.
"""

from pvlib_fem.detect.time_shifts import TimeShifts, time_shifts

__all__ = ["TimeShifts", "time_shifts"]
