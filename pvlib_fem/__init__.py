"""The temperature of photovoltaic modules, second by second, for pvlib users."""

from pvlib_fem import datasets
from pvlib_fem.relaxation import ewm
from pvlib_fem.temperature import fem_temperature, heat_balance, wm1, wm2

__version__ = "0.1.0"

__all__ = [
    "datasets",
    "ewm",
    "fem_temperature",
    "heat_balance",
    "wm1",
    "wm2",
]
