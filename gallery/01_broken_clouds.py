"""
Why static models fail below ten minutes
========================================

A module needs minutes to warm up. A static model does not know that: when the sun
breaks through, it jumps at once. How much error is that, and at which averaging time
does it stop mattering? In a measured week at 1 min the static model is off by 3.7 K
(RMSE on days that the fit never saw), the same model with a heat store by 2.2 K.
Averaged over ten minutes, half of that difference is gone.
"""

import os

import matplotlib.pyplot as plt
import pandas as pd

import pvlib_fem as fem
from pvlib_fem.plotting import AFTER, BEFORE, OTHER

# %%
# The record is a measured week where ``PVLIB_FEM_DATA`` names the folder of its file
# (:py:func:`pvlib_fem.datasets.load`), else a simulated one. The third and the seventh
# day are held out: no fit sees them.

if os.environ.get("PVLIB_FEM_DATA"):
    week = fem.datasets.load("sandia_week")
    print("a measured week:", week.attrs["source"])
else:
    week = fem.simulator.record(days=7, start="2023-05-17", seed=33)
    print("a simulated week: pvlib_fem.simulator, seed 33")
columns = ["poa_global", "temp_air", "wind_speed", "temp_module"]
week = week[columns]


def fit(data, dynamics):
    """Faiman's model, with or without a heat store, and a bias."""
    days = (data.index - week.index[0]).days
    holdout = pd.Series((days == 2) | (days == 6), data.index)
    return fem.fit_fem(
        *(data[name] for name in columns),
        model="faiman",
        dynamics=dynamics,
        holdout=holdout,
    )


static, dynamic = fit(week, "steady"), fit(week, "balance")
print(dynamic)

# %%
# Both have the same columns, the same steady model
# (:py:func:`pvlib.temperature.faiman` and a bias) and the same fit
# (:py:func:`pvlib_fem.fit_fem`). Only ``capacity``, the heat
# that the module keeps, is new. Here is the hour of a held-out day in which the
# irradiance changes most.

change = week["poa_global"].diff().abs().where(static.holdout)
end = change.rolling(60).mean().idxmax()
hour = week.loc[end - pd.Timedelta("59min") : end]
minutes = (hour.index - hour.index[0]).total_seconds() / 60

figure, (sun, heat) = plt.subplots(
    2, 1, figsize=(8, 5), sharex=True, height_ratios=[1, 2], layout="constrained"
)
sun.step(minutes, hour["poa_global"], where="pre", color=OTHER)
sun.set_ylabel("irradiance\n[W/m²]")
sun.set_title(f"{hour.index[0]:%Y-%m-%d, from %H:%M}")
heat.plot(minutes, hour["temp_module"], color="black", lw=2, label="measured")
looks = {"static": (BEFORE, "--"), "dynamic": (AFTER, "-")}
rows = {"measured": {"largest step [K/min]": hour["temp_module"].diff().abs().max()}}
for result, (name, (colour, style)) in zip((static, dynamic), looks.items()):
    modelled = (week["temp_module"] - result.residual)[hour.index]
    heat.plot(minutes, modelled, style, color=colour, label=name)
    rows[name] = {
        "largest step [K/min]": modelled.diff().abs().max(),
        "RMSE of this hour [K]": fem.scores.rmse(hour["temp_module"], modelled),
    }
heat.set(xlabel="minutes", ylabel="module temperature [°C]")
figure.legend(loc="outside lower center", frameon=False, ncols=3)
print(pd.DataFrame(rows).T.round(1).to_string(na_rep=""))

# %%
# *An hour of broken clouds. Above the irradiance, below the module temperature as it
# was measured, by the static model and by the heat balance.* The static temperature
# copies each cloud; the module follows it over minutes, and so does the heat balance.
#
# The remedy of old is to average. We average all four columns over longer times, fit
# both models anew each time, and score them on the same days.

errors = {}
for minutes in (1, 2, 5, 10, 15, 20, 30, 60):
    # a sample stands for the time before it, so a mean carries the end of its interval
    means = week.resample(f"{minutes}min", label="right", closed="right").mean()
    errors[minutes] = {
        name: fit(means, dynamics).scores.loc["fem", "rmse_test"]
        for name, dynamics in (("static", "steady"), ("dynamic", "balance"))
    }
errors = pd.DataFrame(errors).T
errors["difference"] = errors["static"] - errors["dynamic"]
print(errors.rename_axis("averaging time [min]").round(2))

figure, ax = plt.subplots(figsize=(6, 3.2), layout="constrained")
for name, (colour, style) in looks.items():
    ax.plot(errors[name], "o" + style, color=colour, label=name)
ax.set(
    xlabel="averaging time [min]", ylabel="RMSE on held-out days [K]", ylim=(0, None)
)
ax.legend(frameon=False)
plt.show()

# %%
# *RMSE on the held-out days over the averaging time, for both models.* The static error
# falls as clouds are averaged away; the dynamic one changes little. In the measured
# week 1.4 K lie between them at 1 min, 0.9 K at 5 min, 0.6 K at 10 min and 0.4 K at an
# hour. So below ten minutes a model needs the heat store; beyond, averaging buys little
# more.
