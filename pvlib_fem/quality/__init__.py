"""Faults of sensors and loggers, found before any model is fitted."""
