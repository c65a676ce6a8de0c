"""Example records: measured ones, and a synthetic one."""

from pvlib_fem.datasets.made_up import synthetic
from pvlib_fem.datasets.measured import load

__all__ = [
    "load",
    "synthetic",
]
