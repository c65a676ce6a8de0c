"""
Screen a record, with masks of pvanalytics as well
==================================================

:py:func:`pvlib_fem.screen_record` finds what was not measured in a record of module
temperature. `pvanalytics <https://pvanalytics.readthedocs.io>`_ has checks for any
plant, and its masks join with those by ``|``. Of 497 faulty values the one finds 457 at
the cost of 3 good ones, the other all at the cost of 73; a fit, which screens by
itself, is 0.07 K worse than without faults, and 0.02 K with both.
"""

import warnings

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from pvanalytics.quality import gaps, outliers, weather
from pvlib.location import Location

import pvlib_fem as fem
from pvlib_fem.plotting import AFTER, BEFORE, OTHER

warnings.simplefilter("ignore")  # of pandas 3, about calls in pvanalytics
COLUMNS = ["poa_global", "temp_air", "wind_speed", "temp_module"]

# %%
# A simulated month at 5 min, into which a logger's usual faults are written: fill
# values in irradiance, a frozen module sensor, and a loose contact in the air's.

truth = fem.simulator.record(days=30, step=300, start="2023-05-01", seed=4)[COLUMNS]
random = np.random.default_rng(4)
faulty = truth.copy()
lost = random.choice(np.flatnonzero(truth["poa_global"] > 100), 60, replace=False)
faulty.iloc[lost, 0] = -7999.0
faulty.iloc[3000:3400, 3] = truth["temp_module"].iloc[3000]
loose = random.choice(len(truth), 40, replace=False)
faulty.iloc[loose, 1] += random.choice([-15.0, 15.0], 40)
wrong = faulty != truth

# %%
# What each of the two says. Checks of pvanalytics are True where a value is good or
# where it is bad; all are turned here to True where it is bad.

found = fem.screen_record(faulty)
print(*found.notes, sep="\n")

theirs = pd.DataFrame(False, faulty.index, COLUMNS)
air, module, wind = (faulty[n] for n in ("temp_air", "temp_module", "wind_speed"))
theirs["temp_air"] = ~weather.temperature_limits(air) | outliers.hampel(air, 12)
theirs["temp_module"] = gaps.stale_values_diff(module, window=12)
theirs["wind_speed"] = ~weather.wind_limits(wind)
day = Location(49.4, 8.7).get_solarposition(faulty.index)["elevation"] > 10
theirs["poa_global"] = (faulty["poa_global"] <= 0) & day

masks = {
    "none": wrong & False,
    "pvlib_fem": found.mask,
    "pvanalytics": theirs,
    "both": found.mask | theirs,
}
counts = {
    name: {
        "faults found": int((mask & wrong).sum().sum()),
        "of": int(wrong.sum().sum()),
        "good values lost": int((mask & ~wrong).sum().sum()),
    }
    for name, mask in masks.items()
}
print(pd.DataFrame(counts).T.to_string())

# %%
# ``fit_fem`` screens by itself. What pvanalytics finds besides is taken out beforehand:
# a Hampel filter, which knows the hours around, sees the loose contact, for which a
# physical limit is too wide. It pays with some good values in each thousand.

records = {
    "without faults": truth,
    "as it came": faulty,
    "less what pvanalytics finds": faulty.mask(theirs),
}
fits = {
    name: fem.fit_fem(*(data[n] for n in COLUMNS), model="faiman", dynamics="balance")
    for name, data in records.items()
}
table = pd.DataFrame({name: fit.coefficients for name, fit in fits.items()}).T
table["RMSE, held-out days [K]"] = [
    fit.scores["rmse_test"].iloc[-1] for fit in fits.values()
]
print(table.round(2).to_string())

# %%
# The air's sensor around one of the jumps.

at = faulty.index[loose.min()]
hours = slice(at - pd.Timedelta("6h"), at + pd.Timedelta("18h"))
figure, axes = plt.subplots(layout="constrained")
axes.plot(faulty.loc[hours, "temp_air"], color=BEFORE, label="as it came")
axes.plot(truth.loc[hours, "temp_air"], color=AFTER, label="the air")
marked = faulty.loc[hours, "temp_air"][theirs.loc[hours, "temp_air"]]
axes.plot(marked, "o", color=OTHER, label="taken out by pvanalytics")
axes.set_ylabel("temp_air [°C]")
axes.legend()
figure.autofmt_xdate()
plt.show()
