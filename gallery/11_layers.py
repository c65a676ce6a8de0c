"""
RC layers: from a data sheet to the time constant
=================================================

Can the layers of a module tell its time constant before anything is measured? The
paper's first table does it for a glass-Tedlar module: 34 K at 1000 W/m², 17.3 kJ/(m² K)
and so 591 s in calm air. Spread over the module, its frame leaves 320 s. A fit to the
record of a simulated module finds 12.2 kJ/(m² K) where 11.1 are true; the rest is the
sensor's lag.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import pvlib_fem as fem
from pvlib_fem.layers import Layer, glass_tedlar, stack
from pvlib_fem.plotting import AFTER, COLOURS, OTHER

table = stack(*glass_tedlar())
shown = table.assign(r=1e3 * table["r"], c=table["c"] / 1e3)
print(shown.round(2).to_string())

# %%
# The layers are those of Table 1 of :doi:`the paper <10.22541/au.166922866.68736478>`.
# :py:func:`pvlib_fem.layers.stack` puts the layers of each side in series and both
# sides in parallel. The columns are mass [kg], resistance r [mK/(W/m²)], heat capacity
# c [kJ/(m² K)] and time constant tau = r·c [s].

layers = shown.iloc[:10]  # below them are the sums
words = {"r": "resistance [mK/(W/m²)]", "c": "heat capacity [kJ/(m² K)]"}
figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), sharey=True, layout="constrained")
for ax, column in zip(axes, words):
    ax.barh(range(10), layers[column], color=AFTER)
    ax.set_xlabel(words[column])
axes[0].set_yticks(range(10), layers.index)
axes[0].invert_yaxis()

# %%
# *Resistance (left) and heat capacity (right) by layer; first the front, then the back,
# each from the air to the cells.* Still air has nearly all of the resistance, glass and
# frame most of the capacity.
#
# The capacity of a layer is per m² of that layer. On either side there are 0.296 m² of
# frame on 1.6 m² of module, and the paper's sum does not weigh them. Here are the
# module again with its frame spread over it, and others, by options of
# :py:func:`pvlib_fem.layers.glass_tedlar` and by layers of one's own:

spread = 2e-3 * 0.296 / 1.6  # m: as thick as the frame would be over the whole module
glass = Layer("glass", 2e-3, 1.8, 3000.0, 500.0, 1.6)
double_glass = [
    [glass if layer.name in ("glass", "Tedlar") else layer for layer in side]
    for side in glass_tedlar(frame=0.0)
]
modules = {
    "glass-Tedlar, as in the paper": glass_tedlar(),
    "frame spread over the module": glass_tedlar(frame=spread),
    "no frame": glass_tedlar(frame=0.0),
    "4.2 mm of air behind: on a roof": glass_tedlar(back_film=4.2e-3),
    "glass-glass, 2 + 2 mm, no frame": double_glass,
}
totals = {name: stack(*sides).loc["total + air"] for name, sides in modules.items()}
totals = pd.DataFrame(totals).T.drop(columns="mass")
totals["1/r"] = 1 / totals["r"]
print(totals.round({"r": 4, "c": 0, "tau": 0, "1/r": 1}).to_string())

# %%
# The last column [W/(m² K)] is the u0 of Faiman's model, if all of the sun became heat:
# 29 on a rack and 20 on a roof.
#
# Now against a fit. A module of the simulator keeps 11.1 kJ/(m² K): glass 4.8, back
# sheet with a part of the frame 4.9, cells 1.4. :py:func:`pvlib_fem.fit_fem` gets
# thirty days of its record and nothing else.
#
# The fitted capacity is counted per W/m² of irradiance, as u0 and u1 are. Of that 90 %
# is absorbed, and what leaves as power is no heat; times the rest it is the module's
# own. The time constant, capacity over loss, is the same either way.

simulator = fem.simulator
PLAIN = simulator.PHYSICS
GROUND = PLAIN | {"thermal_storage": 1.0}
roof = replace(simulator.RHINE, mounting="roof")
cases = {
    "open rack": (simulator.RHINE, PLAIN, "temp_module"),
    "open rack, no sensor": (simulator.RHINE, PLAIN, "temp_back"),
    "rack, ground stores heat": (simulator.RHINE, GROUND, "temp_module"),
    "roof, which stores heat": (roof, GROUND, "temp_module"),
}
rows, fits = {}, {}
for name, (site, effects, column) in cases.items():
    data = simulator.record(site, effects, days=30, start="2023-06-01")
    if column == "temp_back":  # the truth behind the record
        weather = simulator.weather(site, days=30, start="2023-06-01")
        data[column] = simulator.simulate(weather, site, effects)[column]
    usual = (data[c] for c in ("poa_global", "temp_air", "wind_speed", column))
    fit = fits[name] = fem.fit_fem(*usual, model="faiman", dynamics="balance")
    u0, u1, capacity = (fit.coefficients[c] for c in ("u0", "u1", "capacity"))
    share = 0.9 - data["p_dc_per_area"].sum() / data["poa_global"].clip(lower=0).sum()
    rows[name] = {
        "capacity [J/(m² K)]": capacity,
        "± error": fit.stderr["capacity"],
        "of heat": capacity * share,
        "tau, 0 m/s [s]": capacity / u0,
        "tau, 3 m/s [s]": capacity / (u0 + 3 * u1),
    }
print(pd.DataFrame(rows).T.round(0).to_string())

figure, ax = plt.subplots(figsize=(9, 3.8), layout="constrained")
wind = np.linspace(0, 8, 81)
drawn = ["open rack", "rack, ground stores heat", "roof, which stores heat"]
for colour, style, name in zip(COLOURS, ("-", "--", ":"), drawn):
    u0, u1, capacity = (fits[name].coefficients[c] for c in ("u0", "u1", "capacity"))
    tau = capacity / (u0 + u1 * wind)
    ax.plot(wind, tau, style, color=colour, label=f"fit: {name}")
for name, marker in zip(totals.index[:4], "osD^"):
    tau = totals.loc[name, "tau"]
    ax.plot(0, tau, marker, color=OTHER, clip_on=False, label=f"layers: {name}")
ax.set(xlabel="wind speed [m/s]", ylabel="time constant [s]", ylim=(0, None))
figure.legend(loc="outside right upper", frameon=False)
plt.show()

# %%
# *Time constant over wind speed, by fits on three simulated mountings (lines) and by
# the layers in calm air (points).* With the true temperature of the back instead of a
# sensor the fit gives 11.3 kJ/(m² K) of heat, and the truth is 11.1. The sensor takes
# 40 s to follow, which the fit counts as 0.9 kJ/(m² K) more. A ground or roof that
# stores heat adds 6 to 8: that is not the module's, and :py:mod:`pvlib_fem.effects` has
# ``thermal_storage`` for it.
#
# The layers give a capacity, if the frame is shared out, and leave the resistance open:
# the paper makes its films as thick as 34.15 mK/(W/m²) asks, which is measured per
# irradiance. Per heat, of which there is less, the same module has a larger resistance
# and a longer time constant. So take c from the layers, and r or tau from a record.
