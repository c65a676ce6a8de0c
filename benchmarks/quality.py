"""
Faults of sensors and clocks, as found here and by pvanalytics on the same records.

Run by hand, in an environment that has pvanalytics and ruptures, which the package
does not need: ``make quality``. The tables go into docs/quality.md.
"""

import sys
import time
import warnings
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pandas as pd
from pvanalytics.features import daytime
from pvanalytics.quality import gaps, time as shifts
from pvlib.location import Location

from pvlib_fem import datasets, simulator
from pvlib_fem._record.inputs import as_record
from pvlib_fem.quality._noon import solar_noon_shift
from pvlib_fem.quality._screening import stuck_rows
from pvlib_fem.simulator import ALBUQUERQUE, OUTDOORS, RHINE, Site

PAGE = Path(__file__).parents[1] / "docs" / "quality.md"
USUAL = ["poa_global", "temp_air", "wind_speed", "temp_module"]
ZONE = "Europe/Berlin"  # whose dates the simulator's summer time has
DATES = pd.DatetimeIndex(["2023-03-26", "2023-10-29"])
#: error, root mean square, from which a stuck sensor does harm
HARM = {"poa_global": 50.0, "temp_air": 2.0, "wind_speed": 0.5, "temp_module": 2.0}
LATITUDES = (-33.9, 19.4, 30.0, 37.5, 44.0, 49.4, 52.5, 56.0, 59.3, 64.1)


# stuck sensors


def sound_records():
    """Names and records in which no sensor is stuck."""

    def made(site, days, step, seed, start):
        return simulator.record(site, OUTDOORS, days, step, seed, start=start)[USUAL]

    yield "Rhine valley, 1 min, summer", made(RHINE, 10, 60.0, 0, "2023-06-01")
    yield "the same in snow", made(RHINE, 10, 60.0, 1, "2023-01-05")
    coarse = made(RHINE, 10, 60.0, 2, "2023-06-01").round()
    yield "the same, sensors of 1 K, 1 m/s", coarse
    stalls = OUTDOORS | {"wind_stall": 1.0}
    calm = simulator.record(RHINE, stalls, 10, 60.0, 3, start="2023-09-01")
    yield "the same, anemometer from 1 m/s", calm[USUAL]
    yield "Albuquerque, 5 min", made(ALBUQUERQUE, 40, 300.0, 4, "2023-03-01")
    yield "measured at Sandia, 1 week, 1 min", datasets.load("sandia_week")[USUAL]


def frozen(data, seed, hours=8, events=4):
    """The record with each sensor frozen some times, and which rows that are."""
    random, data = np.random.default_rng(seed), data.copy()
    length = round(pd.Timedelta(hours=hours) / (data.index[1] - data.index[0]))
    truth = {}
    for name in USUAL:
        rows = np.zeros(len(data), dtype=bool)
        part = len(data) // events
        for event in range(events):
            at = event * part + random.integers(part - length)
            rows[at : at + length] = True
            data.iloc[at : at + length, data.columns.get_loc(name)] = data[name].iloc[
                at
            ]
        truth[name] = rows
    return data, truth


def ours(data):
    return stuck_rows(as_record(*(data[name] for name in USUAL)))


def theirs(flag, minutes=None):
    """A pvanalytics function on each column, with a window of rows or of time."""

    def found(data):
        step = (data.index[1] - data.index[0]) / pd.Timedelta("1min")
        window = 6 if minutes is None else max(6, round(minutes / step) + 1)
        return {name: flag(data[name], window=window).to_numpy() for name in USUAL}

    return found


FINDERS = {
    "`pvlib_fem` `stuck`": ours,
    "`stale_values_diff`, 6 rows": theirs(gaps.stale_values_diff),
    "`stale_values_diff`, 30 min": theirs(gaps.stale_values_diff, 30),
    "`stale_values_diff`, 6 h": theirs(gaps.stale_values_diff, 360),
    "`interpolation_diff`, 6 rows": theirs(gaps.interpolation_diff),
}


def stretches(rows):
    """First and last row of each stretch."""
    edge = np.diff(np.concatenate(([0], rows.astype(int), [0])))
    return list(zip(np.flatnonzero(edge == 1), np.flatnonzero(edge == -1)))


def count_stuck():
    """Hits and false alarms of each, by finder and by world."""
    rows = []
    for seed, (world, data) in enumerate(sound_records()):
        faulty, truth = frozen(data, seed)
        for finder, find in FINDERS.items():
            start = time.perf_counter()
            plain, found = find(data), find(faulty)
            took = (time.perf_counter() - start) / 2
            for name in USUAL:
                error = (faulty[name] - data[name]).to_numpy()
                hit = [
                    found[name][a:b].mean() > 0.5
                    for a, b in stretches(truth[name])
                    if np.sqrt(np.mean(error[a:b] ** 2)) > HARM[name]
                ]
                rows.append(
                    dict(
                        finder=finder,
                        world=world,
                        column=name,
                        hit=sum(hit),
                        events=len(hit),
                        alarms=len(stretches(plain[name])),
                        alarm_rows=int(plain[name].sum()),
                        rows=len(data),
                        took=took / len(USUAL),
                    )
                )
    return pd.DataFrame(rows)


def stuck_tables(counts):
    """By finder and column; and false alarms by world."""
    lines = ["| | " + " | ".join(f"`{name}`" for name in USUAL) + " | false | time |"]
    lines.append("|---" * (len(USUAL) + 3) + "|")
    for finder, some in counts.groupby("finder", sort=False):
        by = some.groupby("column")[["hit", "events"]].sum()
        hits = [f"{by.hit[name]} of {by.events[name]}" for name in USUAL]
        share = some.alarm_rows.sum() / some.rows.sum()
        took = some.took.sum() / some.rows.sum() * 1e6 * len(USUAL)
        false = f"{some.alarms.sum()} times, {share:.2%} of rows"
        lines.append(f"| {finder} | {' | '.join(hits)} | {false} | {took:.3g} s |")
    names = list(FINDERS)
    lines += ["", "| false alarms | " + " | ".join(names) + " |"]
    lines.append("|---" * (len(names) + 1) + "|")
    for world, some in counts.groupby("world", sort=False):
        alarms = some.groupby("finder").alarms.sum()
        lines.append(f"| {world} | " + " | ".join(str(alarms[n]) for n in names) + " |")
    return lines


# files that keep summer time


def noon_of_ours(poa, location, site):
    found = solar_noon_shift(
        poa.to_numpy(), poa.index, location, site.surface_tilt, site.surface_azimuth
    )
    return [(day.tz_localize(None), by / 60) for day, by in found.jumps]


def middays(poa):
    """Minutes since midnight of the middle of the day, as pvanalytics finds it."""
    lit = daytime.power_or_irradiance(poa)
    rise, fall = daytime.get_sunrise(lit), daytime.get_sunset(lit)
    middle = rise + (fall - rise) / 2
    middle = middle.groupby(middle.index.date).first().dropna()
    middle.index = pd.DatetimeIndex(middle.index)
    return middle


def minutes(times):
    times = pd.DatetimeIndex(times)
    return (times - times.normalize()).total_seconds() / 60


def noon_of_ruptures(poa, location, site):
    middle = middays(poa)
    days = middle.index.tz_localize(poa.index.tz)
    transit = location.get_sun_rise_set_transit(days, method="spa")["transit"]
    event = pd.Series(minutes(middle), days).round().astype(int)
    expected = pd.Series(minutes(transit), days)
    shift = shifts.shifts_ruptures(event, expected, period_min=60)[1]
    change = shift.diff().fillna(0)
    return [(day.tz_localize(None), by) for day, by in change[change != 0].items()]


def noon_of_has_dst(poa, location, site):
    """It asks at the zone's dates only, and says no sign."""
    middle = middays(poa)
    seen = shifts.has_dst(middle, ZONE, missing="warn")
    return [(day, by) for day, by in zip(DATES, (60, -60)) if seen.get(day, False)]


NOONS = {
    "`pvlib_fem` `solar_noon_shift`": noon_of_ours,
    "`shifts_ruptures`": noon_of_ruptures,
    "`has_dst`, the zone given": noon_of_has_dst,
}


def right(jumps):
    """Whether both jumps are there, and no other."""
    near = [
        abs(day - date) <= pd.Timedelta("5D") and abs(by - due) <= 15
        for (day, by), date, due in zip(jumps, DATES, (60, -60))
    ]
    return len(jumps) == 2 and all(near)


def count_noons(step):
    counts = {name: dict(hit=0, alarm=0, failed=0, took=0.0) for name in NOONS}
    for seed, latitude in enumerate(LATITUDES):
        site = Site(latitude, 10.0, 30.0, 180.0 if latitude > 0 else 0.0)
        location = Location(latitude, 10.0, tz=site.tz)
        for effects in ({}, {"file_dst": 1.0}):
            poa = simulator.record(site, effects, 365, step, seed)["poa_global"]
            for name, find in NOONS.items():
                count, start = counts[name], time.perf_counter()
                try:
                    jumps = find(poa, location, site)
                except (ValueError, KeyError, IndexError):
                    jumps = []
                    count["failed"] += 1
                count["took"] += time.perf_counter() - start
                count["hit"] += bool(effects) and right(jumps)
                count["alarm"] += not effects and len(jumps) > 0
    return counts


def noon_table():
    lines = ["| rows every | | found | false alarms | stopped | time |"]
    lines.append("|---" * 6 + "|")
    sites = len(LATITUDES)
    for step in (300.0, 900.0, 3600.0):
        for name, count in count_noons(step).items():
            lines.append(
                f"| {step / 60:.0f} min | {name} | {count['hit']} of {sites} | "
                f"{count['alarm']} of {sites} | {count['failed']} of {2 * sites} | "
                f"{count['took'] / 2 / sites:.2g} s |"
            )
    return lines


def versions():
    names = ("pvanalytics", "ruptures", "pvlib", "pandas", "numpy")
    return [f"By {', '.join(f'{name} {version(name)}' for name in names)}; one run."]


TABLES = {
    "versions": versions,
    "stuck": lambda: stuck_tables(count_stuck()),
    "noon": noon_table,
}


def main(names):
    """Write tables into the page, between their marks."""
    warnings.simplefilter("ignore")  # of pandas, by calls of pvanalytics
    for name in names:
        lines = "\n".join(TABLES[name]())
        print(lines)
        page = PAGE.read_text(encoding="utf-8")
        before, rest = page.split(f"<!-- {name} -->\n")
        after = rest[rest.index("<!-- end -->") :]
        page = f"{before}<!-- {name} -->\n\n{lines}\n\n{after}"
        PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:] or TABLES)
