"""Faults of sensors and loggers, found before any model is fitted."""

from pvlib_fem.quality._limits import Limits

__all__ = ["Limits"]
