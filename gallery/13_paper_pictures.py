"""
The paper's pictures of your record
===================================

Where do the numbers of the paper's recipe come from? Its Figs. 3, 5, 6, 7 and 10, of
:doi:`B. Herteleer et al., 2022 <10.22541/au.166922866.68736478>`, drawn of a measured
week: 61 calm averages carry the resistance, bins of 20 W/m² the wind's coefficient, and
step changes a time constant that runs backwards.
"""

import os

import matplotlib.pyplot as plt

import pvlib_fem as fem
from pvlib_fem import paper, plotting

if os.environ.get("PVLIB_FEM_DATA"):
    week = fem.datasets.load("sandia_week")
    print("a measured week:", week.attrs["source"])
else:
    week = fem.simulator.record(days=7, start="2023-05-17", seed=33)
    print("a simulated week: pvlib_fem.simulator, seed 33")
names = ["poa_global", "temp_air", "wind_speed", "temp_module"]
record = [week[name] for name in names]

# %%
# Over-temperature over irradiance (Fig. 3), where the air is calm and where it is not.
# A week has few averages below 0.5 and above 6 m/s; we take 1 and 5.

paper.plot_resistances(*record, calm_wind=1.0, high_wind=5.0)
plt.show()

# %%
# *Five-minute averages and the two lines whose slopes are r*\ :sub:`eq,max` *and
# r*\ :sub:`M`. Both lines are below zero without irradiance, by what
# :py:func:`pvlib_fem.paper.night_bias` finds by night:

bias = paper.night_bias(*record)
print(f"{bias.value:.1f} K by night, from {bias.points} rows")

# %%
# The convection coefficient of WM2 (Fig. 5) is the slope of slopes:

paper.plot_k_w(*record)
plt.show()

# %%
# *Slope of over-temperature over wind in each bin of irradiance, its size by the number
# of averages, and the line of k*\ :sub:`W`. Eq. 20 sends it through the origin.
#
# Then step changes over 20 min (Fig. 6), and the time constant of each wind bin (Fig.
# 7). A week has too few of them by wind, so these are of a simulated quarter.

quarter = fem.datasets.synthetic(days=90, seed=1)
simulated = [quarter[name] for name in names]
k = paper.r_eq_max(*simulated, offset=paper.night_bias(*simulated).value)
tau = paper.time_constant(*simulated, k.value)
figure, axes = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
paper.plot_step_changes(*simulated, ax=axes[0])
paper.plot_tau_bins(tau, ax=axes[1])
plt.show()

# %%
# *Left: changes of over-temperature over those of irradiance, 20 min apart, in some
# bins of wind. Right: the slopes as time constants by Eq. 21.* The right picture falls
# whatever the module does, and its values fall as the true time constant grows:
# :doc:`/paper` says why. :py:func:`pvlib_fem.plotting.plot_tau_by_wind` has the
# record's own by least squares.
#
# Last, what the errors do to the energy (Fig. 10), on the held-out days.

errors = {}
for words, dynamics in {
    "steady WM1": "steady",
    "FEM WM1": "ewm",
    "heat balance": "balance",
}.items():
    fit = fem.fit_fem(*record, dynamics=dynamics)
    rows = fit.holdout & paper.daytime(*record)
    modelled = fit.predict(*record[:3])
    parts = (column[rows] for column in (record[0], record[3], modelled))
    errors[words] = fem.scores.energy_error(*parts)

plotting.plot_energy_error(errors)
plt.show()

# %%
# *Error of the performance ratio to either side, and both together.* In the measured
# week the steady model's errors cancel best and are the largest: a sum near nothing is
# no sign of a good model.
