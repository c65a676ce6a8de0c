"""
The paper's own estimators, usable alone; each says how many points it used.

All take Series with a DatetimeIndex. They average over five minutes, which
stands for a steady state, and regress over-temperature T_o = T_module - T_air.
The source of everything here is [1]_.

References
----------
.. [1] B. Herteleer, A. Kladas, G. Chowdhury, F. Catthoor and J. Cappelle,
   "Investigating methods to improve photovoltaic thermal models at
   second-to-minute timescales", 2022. :doi:`10.22541/au.166922866.68736478`
"""

from pvlib_fem.paper.estimators import (
    Estimate,
    TimeConstant,
    averages,
    cell_from_back,
    d,
    heat_capacities,
    k_bs_c,
    k_w,
    r_eq_max,
    r_film,
    r_m,
    time_constant,
)
from pvlib_fem.paper.filters import daytime, night, usable

__all__ = [
    "Estimate",
    "TimeConstant",
    "averages",
    "cell_from_back",
    "d",
    "daytime",
    "heat_capacities",
    "k_bs_c",
    "k_w",
    "night",
    "r_eq_max",
    "r_film",
    "r_m",
    "time_constant",
    "usable",
]
