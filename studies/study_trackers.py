"""
What the loop finds in records of single-axis trackers, with the bars of fixed planes.

One family of the study on a page of its own. Run as
``python studies/study_trackers.py [--shifts 11410000 11510000] [--processes 2]
[--table FILE] [--out docs/study_trackers.md]``.
"""

import argparse
import time
from pathlib import Path

import numpy as np
import pandas as pd
import study_ranges
from study import BARS, done, misses, run
from study_gate import judged
from study_page import publish
from study_worlds import TRACKERS

from pvlib_fem.effects._time_profiles import day_number

SHIFTS = (16610000, 16710000, 16810000, 16910000)  # of seeds, not looked at before
WRONG, MISLED = 0.003, 0.03  # most records with a wrong name, sets without the truth

INTRO = """\
# What the loop finds in records of single-axis trackers

{count} records in
{minutes:.0f} min, shifts {shifts} of all seeds.

{{doc}}`study` has the method. Here each site has a tracker: an axis within 20° of
north and south, 45 to 60° of rotation, backtracking in most, and an irradiance sensor
in the plane of the modules. Half of the records have columns of its angles. The other
half have none, and the loop gets pvlib's description of the tracker. A third of the
records has no power. The records are physics alone, one effect or fault, a cause
outside the catalogue, modules that are stuck for 5 to 35 days while the sensor moves,
the same with radiation to the sky, and a sensor that is stuck with the modules.

## Bars

| bar | kept | met |
|---|---|---|
"""


EDGES = """\
A standstill begins and ends on any day. No decision sees the module temperature of test
weeks. Where a standstill begins or ends in one, power shows its days there. Without
power that week becomes a fitting week; the fitting weeks around it decide this. It was
so in {moved} records. All errors of a record are of its remaining test weeks, that of
the refit with the truth included. A standstill that power shows, but fewer than two
fitting days, makes its test weeks fitting weeks, too. Without power it is not found.
The refit with the truth knows its days."""


SIZES = """\
*Weeks fitted*: test weeks that became fitting weeks. *Size*: what a refit with the true
days and plane takes off the error of the test weeks. *Share*: the coefficient, of which
the truth is 1."""


def line(words, kept, of, met):
    """A row of the table of bars."""
    share = f"{kept} of {of} ({kept / of:.1%})" if of else "none applies"
    return f"| {words} | {share} | {'yes' if met else '**no**'} |"


def bars(table):
    """The bars of the gate, those of the family, and those of all records."""
    found = [judged(row) for _, row in table.iterrows() if done(row)]
    wrong = sum(any(one.wrong for one in some) for some in found)
    most = f"records without a wrong name: ≥ {1 - WRONG:.1%}"
    yield line(most, len(found) - wrong, len(found), wrong <= WRONG * len(found))
    sets = [one for some in found for one in some]
    misled = sum(not one.right for one in sets)
    most = f"sets that hold the truth: ≥ {1 - MISLED:.0%}"
    yield line(most, len(sets) - misled, len(sets), misled <= MISLED * len(sets))
    for bar in BARS:
        if bar.family in (TRACKERS, "all"):
            least = "all" if bar.least == 1 else f"≥ {bar.least:.3g}"
            yield line(f"{bar.words}: {least}", *bar.met(table))


def standstills(table):
    """What was found of each row of modules that was stuck."""
    head = ("days", "power", "angle found", "days found", "weeks fitted", "size")
    head = (*head, "share", "error", "verdict")
    yield f"| {' | '.join(head)} |"
    yield "|---" * len(head) + "|"
    for _, row in table.iterrows():
        if "tracker_stuck" not in row["sizes"]:
            continue
        true, error = row["stuck"], f"{row['before']:.2f} → {row['after']:.2f} K"
        length = day_number(true["end"]) - day_number(true["start"])
        power = "no" if "p_dc_per_area" in row["truth"] else "yes"
        found = [one for one in row["standstills"] if "start" in one]
        if not found:
            lacks = "| " * 5
            yield f"| {length:.0f} | {power} {lacks}| {error} | not in the model |"
            continue
        (one,) = found
        begins, ends = (
            day_number(one[n]) - day_number(true[n]) for n in ("start", "end")
        )
        size = [f for f in row["sets"] if f["effect"] == "tracker_stuck"]
        verdict = size[0]["verdict"] if size else ""
        gain = dict(row["gains"] or {}).get("tracker_stuck", np.nan)
        share = dict(row["told"]).get("tracker_stuck")
        share = f"{share['value']:.2f}" if share else ""
        yield (
            f"| {length:.0f} | {power} | {apart(one, true):.0f}° off | starts "
            f"{begins:+.0f}, ends {ends:+.0f} d | {row['fitted_weeks']:.0f} | "
            f"{gain:.2f} K | {share} | {error} | {verdict} |"
        )


def of_standstills(table):
    """How far the coefficient of a standstill is from its truth, in its errors."""
    found = study_ranges.coefficients(table)
    own = found[found["name"] == "tracker_stuck.share"]
    if len(own):
        off = np.sqrt(np.mean(own["off"] ** 2))
        yield (
            f"The root mean square error of `tracker_stuck.share` is {off:.0%}. Its "
            "standard error has the noise of the fit alone, not the error of the "
            "estimated light in the plane in which the modules stand. Its range has "
            "the 15 % of faults with dates, too."
        )
        yield ""


def apart(one, other):
    """Angle between two planes. [°]"""
    ways = []
    for plane in (one, other):
        tilt, turn = (
            np.radians(plane[name]) for name in ("surface_tilt", "surface_azimuth")
        )
        flat = np.sin(tilt)
        ways.append([flat * np.sin(turn), flat * np.cos(turn), np.cos(tilt)])
    return float(np.degrees(np.arccos(np.clip(np.dot(*ways), -1.0, 1.0))))


def page(table, seconds, shifts):
    """The page, as Markdown."""
    yield INTRO.format(
        count=len(table),
        minutes=seconds / 60,
        shifts=" and ".join(map(str, shifts)),
    ).rstrip("\n")
    yield from bars(table)
    yield ""
    yield EDGES.format(moved=(table["fitted_weeks"] > 0).sum())
    yield ""
    yield "## Modules that are stuck"
    yield ""
    yield SIZES
    yield ""
    yield from standstills(table)
    yield ""
    yield from study_ranges.section(table)
    yield from of_standstills(table)
    yield "## Misses"
    yield ""
    lines = [
        f"* seed {row['seed']} ({row['site']}), {row['truth']}: {words}. Said: "
        f"{row['findings'] or 'nothing'}. Error {row['before']:.2f} → "
        f"{row['after']:.2f} K, with the truth {row['oracle']:.2f} K"
        for row, words in misses(table)
    ]
    yield from lines or ["None."]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--shifts", type=int, nargs="+", default=SHIFTS)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--table", type=Path, help="all rows, pickled")
    parser.add_argument(
        "--read", type=Path, nargs="+", help="rows that --table wrote, not made"
    )
    parser.add_argument("--out", type=Path, help="Markdown; standard output if none")
    given = parser.parse_args()
    begin = time.perf_counter()
    if given.read:
        parts = [pd.read_pickle(path) for path in given.read]
        table = pd.concat(parts, ignore_index=True)
        table.attrs["seconds"] = sum(part.attrs.get("seconds", 0.0) for part in parts)
    else:
        table = run([TRACKERS], False, given.processes, given.shifts)
        table.attrs["seconds"] = time.perf_counter() - begin
    if given.table:
        table.to_pickle(given.table)
    seconds = table.attrs.get("seconds", 0.0)
    text = "\n".join(page(table, seconds, given.shifts))
    publish(text, given.out, "make study-trackers")


if __name__ == "__main__":
    main()
