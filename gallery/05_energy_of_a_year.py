"""
What a dynamic cell temperature changes in the energy of a year
===============================================================

A ModelChain runs a made-up year at 1 min with the steady Faiman model and with the heat
balance of the same coefficients, then again on hourly means. At 1 min the steady model
loses 0.4 % of the AC energy: it is hottest in the very minute in which the sun breaks
through. On hourly means both give the same, and 0.7 % more than the dynamic year at 1
min.
"""

import matplotlib.pyplot as plt
import pandas as pd
from pvlib.location import Location
from pvlib.modelchain import ModelChain
from pvlib.pvsystem import Array, FixedMount, PVSystem

import pvlib_fem as fem
from pvlib_fem.plotting import AFTER, BEFORE, OTHER

FAIMAN = dict(u0=25.0, u1=6.84)
CAPACITY = 15e3  # J/(m² K)
MODELS = {
    "steady": fem.DynamicCellTemperature("faiman", "steady", FAIMAN),
    "dynamic": fem.DynamicCellTemperature(
        "faiman", "balance", {**FAIMAN, "capacity": CAPACITY}
    ),
}


def run(weather, temperature_model):
    """A 1 kWp plant on a fixed rack with a small inverter."""
    array = Array(
        FixedMount(surface_tilt=35, surface_azimuth=180),
        module_parameters={"pdc0": 1000.0, "gamma_pdc": -0.0035},
    )
    chain = ModelChain(
        PVSystem([array], inverter_parameters={"pdc0": 950.0}),
        Location(35, -106),
        aoi_model="physical",
        spectral_model="no_loss",
        dc_model="pvwatts",
        ac_model="pvwatts",
        temperature_model=temperature_model,
    )
    return chain.run_model(weather).results


# %%
# The weather is that of :py:func:`pvlib_fem.datasets.synthetic`: pvlib's sun under
# clouds that come and go; it stands for no climate. Only ``temperature_model`` differs
# between the two runs, a :py:class:`pvlib_fem.DynamicCellTemperature` either way.

weather = fem.datasets.synthetic(365, 60, start="2023-01-01", noise=0)
weather = weather.drop(columns=["poa_global", "temp_module"])
steady, dynamic = (run(weather, model) for model in MODELS.values())
poa = dynamic.total_irrad["poa_global"]
day = poa > 20
temperatures = dynamic.cell_temperature[day], steady.cell_temperature[day]
error = fem.scores.energy_error(poa, dynamic.cell_temperature, steady.cell_temperature)
hours = 1 / 60
table = {
    "insolation [kWh/m²]": poa.sum() * hours / 1000,
    "AC energy, steady [kWh/kWp]": steady.ac.sum() * hours / 1000,
    "AC energy, dynamic [kWh/kWp]": dynamic.ac.sum() * hours / 1000,
    "over-estimate by the steady model [kWh/kWp]": error.over_estimate,
    "under-estimate by the steady model [kWh/kWp]": error.under_estimate,
    "both, without signs [kWh/kWp]": error.total,
    "PR error without signs [points]": error.performance_ratio,
    "RMSE of the steady temperature, by day [K]": fem.scores.rmse(*temperatures),
    "largest minute of DC power that differs [W/kWp]": (dynamic.dc - steady.dc)
    .abs()
    .max(),
}
for name, value in table.items():
    print(f"{name:<50}{value:>10.2f}")

# %%
# The same year on means over longer steps. pvlib takes the sun's place at the time
# stamp, so each mean carries the middle of its interval.

years = {1: {"steady": steady, "dynamic": dynamic}}
for minutes in (5, 10, 15, 30, 60):
    means = weather.resample(f"{minutes}min").mean()
    means.index += pd.Timedelta(minutes=minutes / 2)
    years[minutes] = {name: run(means, model) for name, model in MODELS.items()}
rows = {}
for minutes, results in years.items():
    row = rows[minutes] = {}
    for name, result in results.items():
        insolation = result.total_irrad["poa_global"].sum() * minutes / 60e3  # kWh/m²
        ac, dc = (p.sum() * minutes / 60e3 for p in (result.ac, result.dc))  # kWh/kWp
        row[f"AC {name} [kWh/kWp]"] = ac
        row[f"PR {name} [%]"] = 100 * ac / insolation
        row[f"PR of DC {name} [%]"] = 100 * dc / insolation
steps = pd.DataFrame(rows).T.rename_axis("step [min]")
print("\n", steps.round(2).T.to_string(), sep="")

# %%
# The picture has the hour of the year in which the irradiance changes most, and the
# performance ratio over the step.

end = poa.diff().abs().rolling(60).mean().idxmax()
hour = slice(end - pd.Timedelta("59min"), end)
figure, axes = plt.subplot_mosaic(
    [["sun", "ratio"], ["cell", "ratio"]],
    figsize=(10, 4.5),
    height_ratios=[1, 2],
    layout="constrained",
)
sun, cell, ratio = axes["sun"], axes["cell"], axes["ratio"]
sun.step(range(60), poa[hour], where="pre", color=OTHER)
sun.set(ylabel="irradiance\n[W/m²]", xticklabels=[])
sun.set_title(f"{hour.start:%Y-%m-%d, from %H:%M}")
for name, colour, style in (("steady", BEFORE, "--"), ("dynamic", AFTER, "-")):
    modelled = years[1][name].cell_temperature[hour]
    cell.plot(range(60), modelled, style, color=colour)
    ratio.plot(steps[f"PR {name} [%]"], "o" + style, color=colour, label=name)
cell.set(xlabel="minutes", ylabel="cell temperature [°C]")
ratio.set(xlabel="step [min]", ylabel="performance ratio of AC energy [%]")
ratio.legend(frameon=False)
plt.show()

# %%
# *Left, an hour of broken clouds: irradiance, and the cell temperature by either model.
# Right, the performance ratio of the year over the step of the weather.* At 1 min the
# steady module is hot in each bright minute and cool in each dark one, so the energy,
# most of which comes in bright minutes, is 0.4 % too low. Averages cannot tell bright
# minutes from dark ones, so at an hour both models agree.
#
# They agree on too much: 92.2 % where the dynamic year at 1 min has 91.7 %. The DC
# energy is 0.2 points of that. Most of the rest is the inverter of 950 W: it cuts
# bright minutes that hourly means do not have. Up to 15 min the PR of the dynamic DC
# energy stays within 0.1 points; the steady one is as near at 10 and 15 min.
