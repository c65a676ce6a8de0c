"""
A temperature-corrected performance ratio with RdTools
======================================================

`RdTools <https://rdtools.readthedocs.io>`_ divides what a plant gave by what PVWatts
expects of it at a cell temperature of your own. Here that temperature is steady,
dynamic or measured, for a measured day of broken clouds. The scatter of the normalized
energy falls from 4.5 to 4.1 % with a steady temperature and to 4.0 % with a dynamic one
at 1 min, as far as with the measured one. At 15 min the difference vanishes.
"""

import os

import matplotlib.pyplot as plt
import pandas as pd
import rdtools
from pvlib.pvsystem import pvwatts_dc
from pvlib.temperature import faiman

import pvlib_fem as fem
from pvlib_fem.plotting import AFTER, BEFORE, OTHER

GAMMA = -0.004  # 1/K, of crystalline silicon's power
RATED = 3000.0  # W, only a scale here: the string's own is not stated

# %%
# One day in Albuquerque with the DC power of one string, where ``PVLIB_FEM_DATA`` names
# the folder of its files (:py:func:`pvlib_fem.datasets.load`); elsewhere a day of the
# simulator. The Faiman model is fitted to the modules' own temperature, as the heat
# balance with which it follows clouds. With the same coefficients pvlib's function is
# the steady one.

if os.environ.get("PVLIB_FEM_DATA"):
    day = fem.datasets.load("sandia_day").rename(columns={"power_string": "power_dc"})
else:
    day = fem.simulator.record(days=1, start="2023-06-01")
    day["power_dc"] = pvwatts_dc(day["poa_global"], day["temp_module"], RATED, GAMMA)
fit = fem.fit_fem(
    *(day[n] for n in ("poa_global", "temp_air", "wind_speed", "temp_module")),
    model="faiman",
    dynamics="balance",
)
weather = day[["poa_global", "temp_air", "wind_speed"]]
own = {name: fit.coefficients[name] for name in ("u0", "u1")}
# the offset of the sensor is none of the cells'
temperatures = {
    "none": None,
    "steady": faiman(*weather.to_numpy().T, **own),
    "dynamic": fit.predict(**weather) - fit.coefficients["bias"],
    "measured": day["temp_module"],
}

# %%
# RdTools takes energies that end at their time, as a logger's means do. Each is divided
# by that of PVWatts at the temperature.


def normalized(step, temperature):
    """Energy over that expected, where there is sun."""
    ends = dict(label="right", closed="right")
    energy = day["power_dc"].resample(step, **ends).mean()
    energy *= pd.Timedelta(step) / pd.Timedelta("1h")
    plant = dict(poa_global=day["poa_global"], power_dc_rated=RATED, gamma_pdc=GAMMA)
    if temperature is not None:
        plant["temperature_cell"] = pd.Series(temperature, day.index)
    ratio, insolation = rdtools.normalize_with_pvwatts(energy, plant)
    hours = pd.Timedelta(step) / pd.Timedelta("1h")
    return ratio[insolation / hours > 200.0]


table = pd.DataFrame(
    {
        step: {
            name: 100.0 * ratio.std() / ratio.mean()
            for name, temperature in temperatures.items()
            for ratio in [normalized(step, temperature)]
        }
        for step in ("1min", "5min", "15min")
    }
)
print("Scatter of the normalized energy in % of its mean, by cell temperature")
print(table.round(2).to_string())

# %%
# The remaining scatter does not come from the cell temperature: pyranometer and string
# do not see a cloud's edge in the same second, and one sensor does not represent all
# cells. For a trend over years the steady temperature of hourly means is enough. If
# minutes are compared, as in a search for faults, the dynamic one justifies its one
# additional coefficient.

noon = day.index[0].normalize() + pd.Timedelta("11h")
at = slice(noon, noon + pd.Timedelta("1h"))
figure, (above, below) = plt.subplots(2, 1, sharex=True, layout="constrained")
colors = {"steady": BEFORE, "dynamic": AFTER, "measured": OTHER}
for name, color in colors.items():
    curve = pd.Series(temperatures[name], day.index).loc[at]
    above.plot(curve.index, curve, color=color, label=name)
    ratio = normalized("1min", temperatures[name]).loc[at]
    below.plot(ratio.index, ratio, color=color, label=name)
above.set_ylabel("cell temperature [°C]")
above.legend()
below.set_ylabel("normalized energy [-]")
figure.autofmt_xdate()
plt.show()
