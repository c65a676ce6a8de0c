"""Single checks on records whose faults are known: simulated, or kept on a calendar."""

import numpy as np
import pandas as pd
from pvlib.location import Location

import pvlib_fem as fem
from pvlib_fem.detect import (
    detached_module_sensor,
    irradiance_changes,
    slow_anemometer,
    time_shifts,
)
from pvlib_fem.simulator import ALBUQUERQUE, OUTDOORS, RHINE

SITES = {"Rhine valley": RHINE, "Albuquerque": ALBUQUERQUE}
SEEDS = range(5)
DAYS = 1100
FAULT = pd.Timestamp("2024-05-20")
OFF = slice("2024-05-20", "2024-07-10")
NEAR = pd.Timedelta(days=30)

SUMMER = """
*Measured*: the record `eurac_bolzano` of {{doc}}`guide/public_records` keeps the summer
time of {zone}. From its {column}, `time_shifts` finds {found} of the {dates} changes
by an hour to a week. Other changes that it finds: {others}.
"""
SENSORS = """
## Sensors

*Measured*: {number} simulated records of three years by the hour ({sites}),
with 2 % of noise in the power and 20 % in the wind of the second anemometer. A step is
found if it is the only one, of the true sign and within 30 days; a drift if it is three
standard errors from none and within three of the truth, without a step. *False* counts
sound records in which anything is found.

| check | reference | fault | found | false |
|---|---|---|---|---|
"""


def summer_time(column="power_ac"):
    """The sentence on a record that keeps summer time."""
    data = fem.datasets.load("eurac_bolzano")
    zone = data.attrs["tz"]
    place = Location(data.attrs["latitude"], data.attrs["longitude"], tz=zone)
    jumps = time_shifts(data[column], place).jumps
    days = pd.date_range(data.index[0], data.index[-1], freq="D").normalize()
    offsets = pd.Series([d.utcoffset() for d in days.tz_localize(zone)], days)
    change = offsets.diff().dt.total_seconds().fillna(0.0) / 60.0
    # a day begins by the old time on which the clock is set
    true = [(day - pd.Timedelta(days=1), by) for day, by in change[change != 0].items()]
    week = pd.Timedelta(days=7)
    found = {
        one
        for one in true
        for day, by in jumps
        if abs(day - one[0]) <= week and by == one[1]
    }
    rest = [
        f"{by:+.0f} min on {day:%Y-%m-%d}"
        for day, by in jumps
        if not any(abs(day - at) <= week and by == size for at, size in true)
    ]
    words = dict(zone=zone, column=f"`{column}`", found=len(found), dates=len(true))
    return SUMMER.format(**words, others=", ".join(rest) or "none").rstrip()


def world(site, seed):
    """A record, its place, and references that know no fault."""
    data = fem.simulator.record(site, OUTDOORS, DAYS, 3600.0, seed)
    random = np.random.default_rng(seed)
    warm = 1.0 - 0.004 * (data["temp_module"] - 25.0)
    light = data["poa_global"].clip(lower=0.0)
    power = 6.0 * light * warm * np.exp(random.normal(0.0, 0.02, len(data)))
    mast = data["wind_speed"] * np.exp(random.normal(0.0, 0.2, len(data)))
    place = {
        "location": Location(site.latitude, site.longitude, tz=site.tz),
        "surface_tilt": site.surface_tilt,
        "surface_azimuth": site.surface_azimuth,
    }
    return data, place, {"power": power, "temp_module": data["temp_module"]}, mast


def step(series, size):
    at = FAULT.tz_localize(series.index.tz)
    return series.where(series.index < at, series * (1.0 + size))


def drift(series, rate):
    years = (series.index - series.index[0]) / pd.Timedelta("365.2425D")
    return series * np.exp(rate * years)


def stepped(found, size):
    """Whether the one step that was put in is found, and no other."""
    if len(found.steps) != 1:
        return False
    ((day, by),) = found.steps
    return abs(day - FAULT) <= NEAR and by * size > 0


def drifted(found, rate):
    """Whether the drift that was put in is found, without a step."""
    sure = abs(found.drift - rate) <= 3.0 * found.drift_error
    return found.drifts and not found.steps and sure and found.drift * rate > 0


LIGHT_FAULTS = (
    (step, stepped, 0.05),
    (step, stepped, 0.1),
    (drift, drifted, 0.02),
    (drift, drifted, 0.04),
)
WIND_FAULTS = (
    (step, stepped, 0.2),
    (step, stepped, 0.5),
    (drift, drifted, 0.1),
)


def checks(data, place, by_power, mast):
    """Name of each check, its reference, and what it finds in a column."""
    poa, wind = "poa_global", "wind_speed"
    for name, given in {
        "clear sky": place,
        "power": by_power,
        "both": place | by_power,
    }.items():
        yield (
            ("irradiance_changes", name),
            lambda one, given=given: irradiance_changes(one, **given),
            data[poa],
            LIGHT_FAULTS,
        )
    for name, other in {"usual wind": None, "second anemometer": mast}.items():
        yield (
            ("slow_anemometer", name),
            lambda one, other=other: slow_anemometer(one, other),
            data[wind],
            WIND_FAULTS,
        )


def words(put, size):
    unit = "% a year" if put is drift else "%"
    return f"{'drift' if put is drift else 'step'} of ±{100 * size:.0f} {unit}"


def sensors():
    """The table of sensors, as Markdown."""
    hits, false = {}, {}
    for site in SITES.values():
        for seed in SEEDS:
            parts = world(site, seed)
            for names, find, series, faults in checks(*parts):
                sound = find(series)
                bad = bool(sound.steps) or sound.drifts
                false.setdefault(names, []).append(bad)
                for put, judge, size in faults:
                    for by in (-size, size):
                        row = (*names, words(put, size))
                        hit = judge(find(put(series, by)), by)
                        hits.setdefault(row, []).append(hit)
            detached(parts[0], hits, false)
            print(len(false), hits, flush=True)
    head = dict(number=len(SITES) * len(SEEDS), sites=", ".join(SITES))
    yield SENSORS.format(**head).rstrip()
    for (check, reference, fault), found in hits.items():
        wrong = false[check, reference]
        yield (
            f"| `{check}` | {reference} | {fault} | {sum(found)} of {len(found)} | "
            f"{sum(wrong)} of {len(wrong)} |"
        )


def detached(data, hits, false):
    """A sensor that reads the air, or a fifth of the over-temperature, for weeks."""
    columns = data["temp_air"], data["poa_global"]
    names = ("detached_module_sensor", "–")
    sound = detached_module_sensor(data["temp_module"], *columns).detached
    false.setdefault(names, []).append(bool(sound.any()))
    module = data["temp_module"].copy()
    over = module[OFF] - columns[0][OFF]
    for share in (0.0, 0.2):
        module[OFF] = columns[0][OFF] + share * over
        off = detached_module_sensor(module, *columns).detached
        edges = off.index[off.astype(int).diff().fillna(0.0) != 0.0]
        ends = pd.Timestamp(OFF.start), pd.Timestamp(OFF.stop) + pd.Timedelta(days=1)
        hit = len(edges) == 2 and all(
            abs(one - end) <= pd.Timedelta(days=7) for one, end in zip(edges, ends)
        )
        row = (*names, f"for seven weeks, {100 * share:.0f} % of its over-temperature")
        hits.setdefault(row, []).append(hit)
