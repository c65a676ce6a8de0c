"""How often noise shows days that stand out: ``make episodes``."""

import argparse

import numpy as np
from scipy.signal import lfilter

import pvlib_fem as fem
from pvlib_fem import simulator
from pvlib_fem._budget.unusual_days import episodes
from pvlib_fem._record.column_names import DAYLIGHT
from pvlib_fem.simulator import PHYSICS

CHANCE = fem.Criteria().max_episode_chance
DAYS = (60, 120, 365, 2900)
#: memory from day to day and law of what is new each day
NOISES = {
    **{f"normal, memory {m}": (m, "normal") for m in (0.0, 0.3, 0.6, 0.8, 0.9, 0.95)},
    "exponential tails, memory 0.3": (0.3, "laplace"),
    "season of three times the noise, memory 0.5": (0.5, "season"),
    "t of 6, memory 0.6": (0.6, "t6"),
    "t of 4, memory 0.6": (0.6, "t4"),
}
#: causes that no column tells, in simulated worlds of a year
WORLDS = {
    "weather beside the model alone": {},
    "wind direction not recorded": {"wind_direction": 1.0},
    "sky not recorded": {"sky_radiation": 1.0},
    "both, soiling and drift": {
        "wind_direction": 1.0,
        "sky_radiation": 1.0,
        "soiling": 1.0,
        "irradiance_sensor_drift": 1.0,
    },
}


def noise(random, days, memory, law):
    """Means by day and by night, the one after the other."""
    shape = (2, days + 300)
    if law.startswith("t"):
        kicks = random.standard_t(int(law[1:]), shape)
    else:
        kicks = (
            random.laplace(size=shape)
            if law == "laplace"
            else random.normal(size=shape)
        )
    series = lfilter([1.0], [1.0, -memory], kicks)[:, -days:]
    if law == "season":
        series = series * (2.0 + np.cos(2.0 * np.pi * np.arange(days) / 365.25))
    return series.T.ravel()


def of_noise(random, days, memory, law):
    values = noise(random, days, memory, law)
    dates = np.repeat(np.arange(days), 2)
    return len(episodes(values, dates, np.tile([True, False], days), CHANCE))


def of_world(seed, effects):
    """Of a year of a simulated world, by the heat balance."""
    record = dict(effects=PHYSICS | effects, days=365, step=1800.0, seed=seed)
    data = simulator.record(**record, start="2023-01-01")
    columns = [data[n] for n in ("poa_global", "temp_air", "wind_speed", "temp_module")]
    fit = fem.fit_fem(*columns, model="faiman", dynamics="balance", night=True)
    known = fit.residual.notna().to_numpy()
    sunny = (columns[0] > DAYLIGHT).to_numpy()[known]
    return len(
        episodes(fit.residual.to_numpy()[known], fit.record.dates[known], sunny, CHANCE)
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=300, help="of each kind")
    records = parser.parse_args().records
    random = np.random.default_rng(0)
    print("records that show any [%], and episodes in 100 years")
    for name, law in NOISES.items():
        cells = []
        for days in DAYS:
            found = np.array([of_noise(random, days, *law) for _ in range(records)])
            rate = 36525.0 * found.mean() / days
            cells.append(f"{days:>5} days {100 * (found > 0).mean():5.1f} {rate:6.1f}")
        print(f"{name:<45}", *cells)
    for name, effects in WORLDS.items():
        found = np.array([of_world(seed, effects) for seed in range(records // 3)])
        rate = f"{100 * (found > 0).mean():5.1f} {100.0 * found.mean():6.1f}"
        print(f"{name:<45}   365 days {rate}")


if __name__ == "__main__":
    main()
