"""
How many outages, covers and hours of low power are found in two measured records.

Run as ``python studies/study_events.py
[--draws 40] [--size 3] [--hours 6] [--records nrel_stf]
[--out docs/study_events.md]``. Events are put into power and module temperature, or
into the irradiance, on drawn days of each record (:func:`pvlib_fem.recover_events`).
"""

import argparse
from dataclasses import replace
from pathlib import Path
from unittest import mock

import numpy as np
import pandas as pd
from pvlib.location import Location
from scipy.stats import norm
from study_page import publish

from pvlib_fem import close_loop, datasets, recover_events, simulator
from pvlib_fem._budget import covers_and_outages
from pvlib_fem._loop.references import power_events
from pvlib_fem._loop.references.power_events import EVENTS, KINDS

#: records, and seeds of days on which nothing was looked at before
RECORDS = {"eurac_bolzano": (101,), "nrel_stf": (101, 102, 103)}
NULLS = range(700, 715)  # seeds of simulated years without events
SHIFTS = (7, 14, 21, 28, -7, -14, -21, -28)  # days
FOUND = 0.9  # of the events
NOON = 10  # first of the hours whose noise is shown
YEAR = 365.25

INTRO = """\
# Outages, covers and low power that are found

{{doc}}`guide/recovery` has the method: events
of known size are put into a measured record on drawn days, and the loop looks for them.
Each has {size:g} K over {hours} h of light; `underperformance` has the power of such a
cover, and no change of the temperature. *Even covers* take as much power as light,
the others its square. No rule was made on these days.
"""
LIMITS = """\
*Noise* is the standard deviation of the mean residual over {hours} h from {noon} h on,
given the usual hours of the same day. Where power deviates by less than 15 %, an event
counts only if its temperature differs by two of these. *Can count* is the share of
covers of {size:g} K whose temperature does, with normal errors. With a smaller
difference more of them would count, and more false ones.

`underperformance` is listed if the temperature excludes a cover by two of these. The
cover is the one by the record's own model, whose `modules_covered.share` may be smaller
than 1: at Golden it takes 2 K, not {size:g}, so that most days show neither.
*False* events, in a year: with the temperature residual of other weeks, as far as power
deviates by less than 15 %. There power deviates as measured, and the temperature
follows something else. Hours whose temperature was measured while power deviated do not
count.
"""


def put_in(name, seeds, **options):
    """Events that were put in by kind and seed, and whether they were found."""
    data = datasets.load(name)
    where = site(data)
    tables = [
        recover_events(data, location=where, seed=seed, **options) for seed in seeds
    ]
    return pd.concat(tables, ignore_index=True)


def site(data):
    """Location of a record."""
    return Location(*(data.attrs[part] for part in ("latitude", "longitude", "tz")))


def decided(data, **place):
    """What decides on the events of a record."""
    seen = []

    def found_in(hours, spread, total, shares):
        seen.append((hours, spread, covers_and_outages.SHARES | shares))
        return covers_and_outages.events_in(hours, spread, total, shares)

    with mock.patch.object(power_events, "events_in", found_in):
        close_loop(data, **place)
    return seen[-1]


def faint_events(hours, spread, shares):
    """Stretches with a faint deviation of power, and those of them that are events."""
    deciding = covers_and_outages.Deciding.from_hours(hours, spread, shares)
    for start, end in covers_and_outages.runs(deciding.state, hours.days()):
        some = slice(start, end)
        if not deciding.state[start] or end - start < covers_and_outages.FEWEST:
            continue
        if deciding.far[some].mean() <= 0.5:
            yield some, bool(deciding.kind(some))


def false_per_year(hours, spread, shares):
    """Faint events a year with the temperature of other weeks."""
    usual = covers_and_outages.Deciding.from_hours(hours, spread, shares).state == 0
    place = {int(number): i for i, number in enumerate(hours.number)}
    rates = []
    for shift in SHIFTS:
        other = np.array([place.get(int(n) + 24 * shift, -1) for n in hours.number])
        known = (other >= 0) & usual[other]
        moved = replace(hours, residual=np.where(other >= 0, hours.residual[other], 0))
        found = [*faint_events(moved, spread, shares)]
        kept = [event for some, event in found if known[some].all()]
        rates.append(np.mean(kept) * len(found))
    days = len(np.unique(hours.number // 24))
    return float(np.mean(rates)) * YEAR / days


def noise_of(hours, spread, shares, length):
    """Median noise of the hours around noon, given the rest of the day. [K]"""
    deciding = covers_and_outages.Deciding.from_hours(hours, spread, shares)
    clock, day = hours.number % 24, hours.number // 24
    starts = np.flatnonzero(clock[: 1 - length] == NOON)
    whole = day[starts] == day[starts + length - 1]
    whole &= clock[starts + length - 1] == NOON + length - 1
    some = [slice(start, start + length) for start in starts[whole]]
    return float(np.median([deciding.strange.beyond(one)[1] for one in some]))


def in_nulls():
    """Events that are listed in each simulated year without any."""
    for seed in NULLS:
        data = simulator.record(effects=simulator.PHYSICS, step=1800, seed=seed)
        data["power_ac"] = 33.0 * data.pop("p_dc_per_area")
        loop = close_loop(data.drop(columns=["longwave_down", "snow_depth"]))
        yield len(loop.events)


def counted(rows):
    """How many of some events are found."""
    return f"{rows['found'].sum()} of {len(rows)} ({rows['found'].mean():.0%})"


def page(tables, noises, rates, nulls, given):
    """The page, as Markdown."""
    how = dict(size=given.size, hours=given.hours)
    yield INTRO.format(**how).rstrip("\n")
    yield ""
    *kinds, low = (f"`{kind}`" for kind in EVENTS)
    head = ("record", *kinds, "of these, even covers", "all", f"bar: {FOUND:.0%}", low)
    yield f"| {' | '.join(head)} |"
    yield "|---" * len(head) + "|"
    known = {f"`{name}`": table for name, table in tables.items()}
    for name, table in {**known, "together": pd.concat(tables.values())}.items():
        *cells, low = (counted(table[table["effect"] == kind]) for kind in EVENTS)
        covers = table[table["effect"] == "modules_covered"]
        even = covers[np.isclose(covers["light"], covers["power"])]
        warm = table[table["effect"].isin(KINDS)]  # that temperature follows
        met = "met" if warm["found"].mean() >= FOUND else "**missed**"
        cells += [counted(even), counted(warm), met, low]
        yield f"| {name} | {' | '.join(cells)} |"
    yield ""
    yield "| record | noise | can count | false in a year |"
    yield "|---|---|---|---|"
    for name, sigma in noises.items():
        ideal = norm.cdf(given.size / sigma - covers_and_outages.SEEN)
        yield f"| `{name}` | {sigma:.2f} K | {ideal:.0%} | {rates[name]:.2f} |"
    yield ""
    yield LIMITS.format(noon=NOON, **how).rstrip("\n")
    yield ""
    yield (
        f"In {len(nulls)} simulated years of physics without events {sum(nulls)} are "
        f"listed, at most {max(nulls)} in one (bar: 1)."
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=40)
    parser.add_argument("--size", type=float, default=3.0)
    parser.add_argument("--hours", type=int, default=6)
    parser.add_argument("--records", nargs="+", default=[*RECORDS], choices=RECORDS)
    parser.add_argument("--out", type=Path, help="Markdown; standard output if none")
    given = parser.parse_args()
    how = {n: getattr(given, n) for n in ("draws", "size", "hours")}
    tables, noises, rates = {}, {}, {}
    for name in given.records:
        tables[name] = put_in(name, RECORDS[name], **how)
        data = datasets.load(name)
        hours = decided(data, location=site(data))
        noises[name] = noise_of(*hours, given.hours)
        rates[name] = false_per_year(*hours)
    lines = page(tables, noises, rates, [*in_nulls()], given)
    publish("\n".join(lines), given.out, "make study-events")


if __name__ == "__main__":
    main()
