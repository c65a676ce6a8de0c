"""Records to try things on: measured ones, and one that the package makes."""

from pvlib_fem.datasets.made_up import synthetic
from pvlib_fem.datasets.measured import load

__all__ = [
    "load",
    "synthetic",
]
