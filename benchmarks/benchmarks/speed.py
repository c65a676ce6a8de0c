"""
Speed and memory against what users have now, for ``asv run`` in this folder.

Every class times one piece of work and the tools it is measured against; the
README gives ratios within one run (``python benchmarks/ratios.py``).
"""

import numpy as np
import pandas as pd
import pvlib
from scipy.signal import lfilter

import pvlib_fem as fem

TAU = 378.0
WM1 = dict(model="wm1", k=0.035, d=10.0, tau=TAU)


class Ewm:
    """Ten million rows, even or uneven."""

    params = ["even", "uneven"]
    timeout = 120

    def setup(self, steps, rows=10_000_000):
        random = np.random.default_rng(0)
        values = random.uniform(0, 1000, rows)
        if steps == "even":
            times = pd.date_range("2024-01-01", periods=rows, freq="s")
        else:
            milliseconds = np.cumsum(random.integers(500, 1500, rows))
            times = pd.DatetimeIndex(milliseconds.astype("datetime64[ms]"))
        self.values = pd.Series(values, times)
        self.alpha = 1 - np.exp(-1 / TAU)
        self.halflife = pd.Timedelta(seconds=TAU * np.log(2))

    def time_ewm(self, steps):
        fem.ewm(self.values, TAU)

    def time_lfilter(self, steps):
        lfilter([self.alpha], [1, self.alpha - 1], self.values.to_numpy())

    def time_pandas_times(self, steps):
        self.values.ewm(halflife=self.halflife, times=self.values.index).mean()

    def time_pandas_alpha(self, steps):
        self.values.ewm(alpha=self.alpha).mean()


def weather(days, step):
    data = fem.datasets.synthetic(days, step, noise=0)
    return tuple(data[name] for name in ("poa_global", "temp_air", "wind_speed"))


class FemTemperature:
    """A year at 1 min and a day at 1 s, against pvlib's one transient model."""

    params = ["year at 1 min", "day at 1 s"]
    timeout = 120

    def setup(self, record):
        self.drivers = weather(*{"year at 1 min": (365, 60)}.get(record, (1, 1)))

    def time_fem_temperature(self, record):
        fem.fem_temperature(*self.drivers, **WM1)

    def time_heat_balance(self, record):
        fem.heat_balance(*self.drivers, capacity=12e3, u0=25.0, u1=6.84)

    def time_prilliman(self, record):
        poa, air, wind = self.drivers
        steady = pvlib.temperature.sapm_cell(poa, air, wind, -3.47, -0.0594, 3)
        pvlib.temperature.prilliman(steady, wind)


class YearAtOneSecond:
    """31.5 million rows: time, and memory relative to that of the input."""

    timeout = 300

    def setup(self):
        day = [series.to_numpy() for series in weather(1, 1)]
        times = pd.date_range("2024-01-01", periods=365 * 86400, freq="s")
        self.drivers = tuple(pd.Series(np.tile(column, 365), times) for column in day)

    def time_fem_temperature(self):
        fem.fem_temperature(*self.drivers, **WM1)

    def peakmem_fem_temperature(self):
        fem.fem_temperature(*self.drivers, **WM1)

    def peakmem_input_alone(self):
        pass


class Fit:
    """Least squares over a year at 1 min, errors and scores included."""

    params = ["ewm", "balance"]
    timeout = 120

    def setup(self, dynamics):
        data = fem.datasets.synthetic(365)
        columns = ("poa_global", "temp_air", "wind_speed", "temp_module")
        self.record = tuple(data[name] for name in columns)

    def time_fit_fem(self, dynamics):
        fem.fit_fem(*self.record, model="faiman", dynamics=dynamics)


class Loop:
    """The closed loop over years at 1 min of the simulated world, with all columns."""

    params = [1, 2, 4]
    timeout = 300
    hidden = ("sky_radiation", "wind_direction", "electrical_output")

    def setup(self, years):
        simulator = fem.simulator
        effects = simulator.PHYSICS | dict.fromkeys(self.hidden, 1.0)
        self.record = simulator.record(effects=effects, days=365 * years)
        site = simulator.RHINE
        self.place = dict(
            location=pvlib.location.Location(site.latitude, site.longitude, site.tz),
            surface_tilt=site.surface_tilt,
            surface_azimuth=site.surface_azimuth,
        )

    def time_close_loop(self, years):
        fem.close_loop(self.record, **self.place)

    def peakmem_close_loop(self, years):
        fem.close_loop(self.record, **self.place)


class LoopOfEight(Loop):
    """A loop with eight effects to find, one after the other."""

    params = [1]
    hidden = (*Loop.hidden, "rain", "snow", "soiling", "shading", "thermal_storage")
