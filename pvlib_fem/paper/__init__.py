"""
The paper's own estimators; an estimate has the number of points behind it.

They take Series with a DatetimeIndex. Most average over five minutes, as an
approximate steady state, and regress over-temperature T_o = T_module - T_air.
The source is [1]_.

References
----------
.. [1] B. Herteleer, A. Kladas, G. Chowdhury, F. Catthoor and J. Cappelle,
   "Investigating methods to improve photovoltaic thermal models at
   second-to-minute timescales", 2022. :doi:`10.22541/au.166922866.68736478`
"""

from pvlib_fem._record.filters import daytime, night, usable
from pvlib_fem.paper import comparators
from pvlib_fem.paper._cell import cell_from_back, k_bs_c
from pvlib_fem.paper._estimators import (
    Estimate,
    averages,
    d,
    k_w,
    k_w_bins,
    night_bias,
    r_eq_max,
    r_film,
    r_m,
)
from pvlib_fem.paper._paper_plots import (
    plot_k_w,
    plot_resistances,
    plot_step_changes,
    plot_tau_bins,
)
from pvlib_fem.paper._sites import table_3, tau_by_mounting
from pvlib_fem.paper._timeconstant import (
    TimeConstant,
    heat_capacities,
    step_changes,
    time_constant,
)
from pvlib_fem.paper._wind_bins import convection, wind_max

__all__ = [
    "Estimate",
    "TimeConstant",
    "averages",
    "cell_from_back",
    "comparators",
    "convection",
    "d",
    "daytime",
    "heat_capacities",
    "k_bs_c",
    "k_w",
    "k_w_bins",
    "night",
    "night_bias",
    "plot_k_w",
    "plot_resistances",
    "plot_step_changes",
    "plot_tau_bins",
    "r_eq_max",
    "r_film",
    "r_m",
    "step_changes",
    "table_3",
    "tau_by_mounting",
    "time_constant",
    "usable",
    "wind_max",
]
