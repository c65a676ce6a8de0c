"""
Instruments that change among physics, and what the loop says of them.

The change is made in the columns, after the simulator: no model of the package has a
part in it. Run as
``python studies/study_instruments.py [--records 100] [--seed 0]
[--processes 2] [--out docs/study_instruments.md]``.
"""

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
import study_ranges
from study_page import publish
from study_records import refit, root, sets, smallest
from study_worlds import (
    ALSO,
    CLEARLY,
    GATE_RECORDS,
    GATE_SEED,
    IN_PHYSICS,
    World,
    site,
)

from pvlib_fem import close_loop, simulator
from pvlib_fem._parallel import spread
from pvlib_fem.effects import CHANGES, find

COURSES = ("step", "drift", "episode")
#: sizes from which one is drawn, either way where that can be
SIZES = {
    "irradiance_sensor": (0.06, 0.15),
    "module_sensor_contact": (0.08, 0.25),
    "anemometer": (0.25, 0.6),  # of the wind that is lost
    "anemometer_stall": (1.2, 2.0),  # m/s, below which the cups stand
    "air_offset": (0.8, 2.0),  # K
    "module_offset": (0.8, 2.0),  # K
    "none": (0.0, 0.0),
}
ODDS = [0.18, 0.18, 0.1, 0.08, 0.13, 0.13, 0.2]
#: effects of the simulator's physics, of which a part of the sun's heat is power
PRESENT = {*simulator.OUTDOORS, "electrical_output", "modules_covered"} | IN_PHYSICS
PRESENT |= {ALSO[switch] for switch in PRESENT & {*ALSO}}
#: what one record cannot tell from each other is one truth
SAME = {
    "module_sensor_contact": ("module_sensor_contact", "mounting"),
    "module_offset": ("module_offset",),
}


def changed(data, channel, size, weight):
    """The record whose sensor has changed, by the weight of each row."""
    data, air = data.copy(), data["temp_air"]
    if channel == "irradiance_sensor":
        data["poa_global"] *= 1.0 - size * weight
    elif channel == "module_sensor_contact":
        over = data["temp_module"] - air
        data["temp_module"] = air + over * (1.0 - size * weight)
    elif channel == "anemometer":
        data["wind_speed"] *= 1.0 - size * weight
    elif channel == "anemometer_stall":
        stalls = data["wind_speed"] < size * weight
        data["wind_speed"] = data["wind_speed"].where(~stalls, 0.0)
    elif channel in ("air_offset", "module_offset"):
        data[f"temp_{channel.removesuffix('_offset')}"] += size * weight
    return data


def drawn(seed):
    """A world, and what happens to which instrument when."""
    random = np.random.default_rng([seed, 12])
    days = int(random.choice([365, 730]))
    world = World(site(70_000 + seed), 70_000 + seed, days=days, step=900.0)
    channel = str(random.choice(list(SIZES), p=ODDS))
    course = str(random.choice(COURSES, p=[0.5, 0.25, 0.25]))
    low, high = SIZES[channel]
    size = float(random.uniform(low, high))
    if channel != "anemometer" and channel != "anemometer_stall":
        size *= random.choice([-1.0, 1.0])
    at = np.sort(random.uniform(0.15, 0.85, 2)) * days
    if at[1] - at[0] < 40:
        at = at[0], min(at[0] + 60.0, 0.9 * days)
    if course == "drift":
        size *= 365.0 / days * 1.5
    return world, channel, course, size, at, bool(random.random() < 0.5)


def made(seed):
    """The record of a world before and after its change, and all that was drawn."""
    world, channel, course, size, at, power = drawn(seed)
    how = (world.days, world.step, world.seed, world.start)
    (data,) = simulator.records(world.site, [simulator.OUTDOORS], *how)
    data.attrs = {}
    day = (data.index - data.index[0]) / pd.Timedelta("1D")
    weight = {
        "step": day >= at[0],
        "drift": day / 365.0,
        "episode": (day >= at[0]) & (day < at[1]),
    }[course]
    if not power:
        data = data.drop(columns="p_dc_per_area")
    after = changed(data, channel, size, np.asarray(weight, dtype=float))
    return data, after, (world, channel, course, size, at, power)


def looked(seed):
    """What the loop says of one record."""
    before, data, (world, channel, course, size, at, power) = made(seed)
    off = None
    if channel != "none":
        off = close_loop(before, check_units=False, **world.place)
    loop = close_loop(data, check_units=False, **world.place)
    added = [f for f in loop.finding_objects if f.added]
    truths = {f"{name}_{course}" for name in SAME.get(channel, (channel,))}
    reported = [f for f in added if {*f.candidates} & {*CHANGES}]
    right = [f for f in added if truths & {*f.candidates}]
    wrong = [
        f.effect
        for f in reported
        if f.verdict == "identified" and f.effect not in truths
    ]
    there = PRESENT | {*CHANGES}
    other = [
        f.effect for f in added if f.verdict == "identified" and f.effect not in there
    ]
    others = [{*f.candidates} for f in reported if not truths & {*f.candidates}]
    row = dict(seed=seed, channel=channel, course=course, size=size, power=power)
    row |= dict(days=world.days, found=bool(right), wrong=wrong)
    row["misled"] = ["|".join(sorted(one)) for one in others]
    row["unfounded"] = ["|".join(sorted(one)) for one in others if not one & PRESENT]
    row["other"] = other
    row["verdict"] = str(right[0].verdict) if right else ""
    row["sets"], row["truths"] = sets(loop), () if channel == "none" else truths
    row["first"] = bool(right) and right[0] is added[0]
    row["findings"] = "; ".join(
        f"{f.verdict} {'|'.join(f.candidates)} ({f.gain:.2f})"
        for f in loop.finding_objects
    )
    row["clear"] = off is not None and clear(loop, off, own(world, channel, course, at))
    row["dates"] = dated(loop, right, world, course, at)
    row["told"] = coefficient_of(right, channel, course, size, world.days / 365.0)
    errors = loop.table["rmse_test"]
    row["before"], row["after"] = float(errors[loop.base]), float(errors.iloc[-1])
    return row


def own(world, channel, course, at):
    """The change as the catalogue has it, with its own dates."""
    first, last = (pd.Timestamp(world.start) + pd.Timedelta(days=day) for day in at)
    dates = {
        "step": {"at": f"{first.round('D'):%Y-%m-%d}"},
        "drift": {},
        "episode": {
            "start": f"{first.round('D'):%Y-%m-%d}",
            "end": f"{last.round('D'):%Y-%m-%d}",
        },
    }[course]
    return find({"name": f"{channel}_{course}", **dates})


def clear(loop, off, change):
    """
    Whether the change is large enough to have to be found, as in the study.

    What its own terms take off the error of the test weeks, beyond what they take off
    in the same record without it, is compared with what is detectable there.
    """
    without, with_it = (one.table["rmse_test"][one.base] for one in (loop, off))
    taken = without**2 - refit(loop, [change]) ** 2
    idle = max(with_it**2 - refit(off, [change]) ** 2, 0.0)
    return bool(root(taken - idle) >= CLEARLY * smallest(off, change.name))


def coefficient_of(right, channel, course, size, years):
    """The coefficient of the change with its truth, error and range, by its name."""
    if not right or len(right[0].coefficients) > 1:  # a season leads the class
        return {}
    effect = right[0].effect
    ((name, value),) = right[0].coefficients.items()
    times = years if course == "drift" else 1.0
    truth = expected(channel, effect.removesuffix(f"_{course}"), size * times) / times
    if np.isnan(truth):
        return {}
    one = dict(name=name, truth=truth, value=value, stderr=right[0].stderr[name])
    return {effect: one | {"range": right[0].ranges.get(name)}}


def expected(channel, named, size):
    """The coefficient that a change of that size makes; NaN where it has none."""
    over = {
        "irradiance_sensor": 1.0 / (1.0 - size) - 1.0,
        "module_sensor_contact": -size,
    }.get(channel)
    offset = {"module_offset": size, "air_offset": -size}.get(channel)
    if over is not None:
        gains = {"irradiance_sensor": over, "module_sensor_contact": over}
        return (gains | {"mounting": 1.0 / (1.0 + over) - 1.0}).get(named, np.nan)
    # the air's offset reaches the module by the heat that air brings: no share of both
    return offset if named == channel and offset is not None else np.nan


def dated(loop, right, world, course, at):
    """Whether the day is within its interval, and how far its date is off. [d]"""
    if not right or course == "drift":
        return None
    effects = {e.name: e for e in loop.fit.effects}
    settings = effects[right[0].effect].settings
    if "between" not in settings:
        return None
    begin = pd.Timestamp(world.start) + pd.Timedelta(days=at[0])
    low, high = map(pd.Timestamp, settings["between"])
    date = pd.Timestamp(settings.get("at", settings.get("start")))
    inside = low <= begin.ceil("D") and begin.floor("D") <= high
    return bool(inside), abs((date - begin) / pd.Timedelta("1D"))


def run(records, first, processes):
    """A row for each record, in order."""
    rows = []
    tasks = [(seed,) for seed in range(first, first + records)]
    for row in spread(looked, tasks, processes):
        rows.append(row)
        print(
            row["seed"],
            row["channel"],
            row["course"],
            f"{row['size']:.2f}",
            "power" if row["power"] else "",
            "clear" if row["clear"] else "",
            "OK" if row["found"] else "-",
            row["dates"],
            row["findings"][:400],
            flush=True,
        )
    return pd.DataFrame(rows)


def page(table, first):
    """Lines of the page."""
    there = table[table["channel"] != "none"]
    none = table[table["channel"] == "none"]
    dates = [d for d in there["dates"] if d is not None]
    yield "# Findings for sensors and mountings that change"
    yield ""
    yield (
        f"{len(table)} simulated records of one or two years at 15 min from seed "
        f"{first} on, with full physics. One sensor or mounting has a step, a trend or "
        "a temporary change, or none does. The change is made in the columns. Half "
        "have power. A change is *clear* if its own terms reduce the error of the test "
        "weeks by twice the minimum that is detectable in the same record without it, "
        "as in {doc}`study`."
    )
    yield ""
    yield "| what | share |"
    yield "|---|---|"
    seen = there[there["clear"]]
    yield f"| the change is identified, or a candidate | {share(there['found'])} |"
    yield f"| clear changes that are so | {share(seen['found'])} |"
    yield f"| changes that are the first finding | {share(there['first'])} |"
    kinds = "wrong", "misled", "unfounded"
    wrong, misled, unfounded = (table[kind].map(bool) for kind in kinds)
    yield f"| wrong names of a change | {share(wrong)} |"
    other = share(table["other"].map(bool))
    yield f"| names of another effect that is not there | {other} |"
    yield f"| a set with a change, without the true one | {share(misled)} |"
    yield f"| a set with a change, without any true cause | {share(unfounded)} |"
    alarms = share((wrong | misled)[none.index])
    yield f"| a set with a change, in a record without one | {alarms} |"
    alarms = share((wrong | unfounded)[none.index])
    yield f"| the same, without any true cause | {alarms} |"
    inside = share(pd.Series([d[0] for d in dates]))
    yield f"| true date within the interval | {inside} |"
    yield ""
    yield from study_ranges.section(table)
    if dates:
        middle = np.median([d[1] for d in dates])
        yield f"Half of the dates are within {middle:.1f} days of the true date."
        yield ""
    yield "| device | time profile | records | found | first | identified |"
    yield "|---|---|---|---|---|---|"
    for (channel, course), part in there.groupby(["channel", "course"]):
        identified = (part["verdict"] == "identified").sum()
        yield (
            f"| {channel} | {course} | {len(part)} | {part['found'].sum()} | "
            f"{part['first'].sum()} | {identified} |"
        )


def share(flags):
    return f"{int(flags.sum())} of {len(flags)}"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--table", type=Path, help="all rows, pickled")
    gate = "on what the gate is measured, instead of records and seed"
    parser.add_argument("--gate", action="store_true", help=gate)
    given = parser.parse_args()
    if given.gate:
        given.records, given.seed = GATE_RECORDS, GATE_SEED
    found = run(given.records, given.seed, given.processes)
    if given.table:
        found.to_pickle(given.table)
    text = "\n".join(page(found, given.seed))
    publish(text, given.out, "make study-instruments")
