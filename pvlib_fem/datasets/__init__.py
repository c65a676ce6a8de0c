"""Example records: measured ones, and a synthetic one."""

from pvlib_fem.datasets._measured_records import load
from pvlib_fem.datasets._synthetic import synthetic

__all__ = [
    "load",
    "synthetic",
]
