"""
Single checks on the benchmarks of others: the table in docs/detectors.md.

Run as ``python tests/study_detectors.py --hub FOLDER [--out docs/detectors.md]``, where
the folder is a clone of https://github.com/kperrynrel/time-shift-validation-hub
(MIT, 700 MB). Without it the page says how to get the data.
"""

import argparse
import platform
import time
import warnings
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import numpy as np
import pandas as pd
from pvlib.location import Location

import pvlib_fem as fem

#: what is tuned on, by the remainder of a file name's number; others stay closed
PARTS = {"even, tuned on": 0, "odd, scored once": 1}
NEAR = pd.Timedelta(days=30)  # between a jump and the one that is found
SIZE = 15.0  # min, by which its size may differ

INTRO = """\
# Single checks on the benchmarks of others

Written by `tests/study_detectors.py` on {day}, pvlib_fem {version}, pvlib {pvlib},
numpy {numpy}, pandas {pandas}, Python {python}; `make detectors` makes it again.
{{doc}}`guide/detectors` has the functions.
"""
LACKS = """
The data are not on this disk. Get them with

    git clone https://github.com/kperrynrel/time-shift-validation-hub

and give the folder as `make detectors HUB=time-shift-validation-hub`.
"""
SHIFTS = """
## Time shifts

The task of the [PV Validation Hub](https://github.com/kperrynrel/time-shift-validation-hub)
(MIT): irradiance and AC power of ten systems, some with another zone, summer time or a
clock that was set for a while, and the shift of each day. The score is the mean
absolute error of the shift over the days of a stream, averaged over streams. Everything
was tuned on streams whose file name's number is even, and fixed before the others
were opened. {here} of {all} streams are on this disk.

| streams | number | {function}, MAE [min] | median | worst | jumps found | \
false jumps | slowest [s] |
|---|---|---|---|---|---|---|---|
"""
QUOTED = """
*Quoted, not measured here*: pvanalytics' method has a mean of 2.97 min and a median of
0 over the streams that its authors publish, in
`results/pvanalytics-cpd-module_full_results.csv` of that repository. {same} of the
streams above are among them: there it has {theirs:.2f} min, and `time_shifts`
{ours:.2f} min, measured.

A jump is found if one of the same sign and of its size to {size:.0f} min is within
{near} days, and false if no true jump of that sign is. Where nothing was recorded, or
an inverter stood still, a clock may have been set on any of those days, and the middle
one is taken.
"""


@dataclass(frozen=True)
class Stream:
    """What is found in one stream of the hub."""

    name: str
    error: float  # min
    jumps: int
    found: int
    false: int
    took: float  # s

    @property
    def part(self):
        """Remainder of its system's number, with which its name begins."""
        return int(self.name.split("_")[0]) % 2


def jumps_of(minutes):
    """The days on which a shift changes, and by how much."""
    change = minutes.diff().fillna(0.0)
    return [(day, by) for day, by in change.items() if by]


def counted(true, found):
    """
    How many true jumps are found, and how many of those found are false.

    A true one is a day and its size, one that is found the first and the last day on
    which it may be, and its size.
    """
    hits = sum(
        any(near(one, other) and abs(one[1] - other[2]) <= SIZE for other in found)
        for one in true
    )
    return hits, sum(not any(near(one, other) for one in true) for other in found)


def near(one, other):
    (day, by), (first, last, size) = one, other
    return first - NEAR <= day <= last + NEAR and by * size > 0


def stream(file, row, site):
    """One stream, read and scored."""
    light = pd.read_csv(file, index_col=0, parse_dates=True).iloc[:, 0]
    light = light[~light.index.duplicated()]
    truth = file.parents[1] / "validation_data" / file.name
    truth = pd.read_csv(truth, index_col=0, parse_dates=True).iloc[:, 0]
    place = Location(site["latitude"], site["longitude"], altitude=site["elevation"])
    start = time.perf_counter()
    light = light.asfreq(f"{row['data_sampling_frequency']}min")
    shifts = fem.detect.time_shifts(light, place)
    took = time.perf_counter() - start
    # the hub's sign is that of what has to be added to the timestamps
    found = -shifts.minutes.reindex(truth.index)
    error = float((found - truth).abs().mean())
    jumps = [(*days, -by) for days, (_, by) in zip(shifts.within, shifts.jumps)]
    hits, false = counted(true := jumps_of(truth), jumps)
    return Stream(file.name, error, len(true), hits, false, took)


def hub(folder):
    """All streams of the hub that are there, and how many there are."""
    data = folder / "data"
    files = pd.read_csv(data / "file_metadata.csv").set_index("file_name")
    sites = pd.read_csv(data / "system_metadata.csv").set_index("system_id")
    there = [f for n in files.index if (f := data / "file_data" / n).is_file()]
    found = []
    for file in there:
        row = files.loc[file.name]
        found.append(stream(file, row, sites.loc[row["system_id"]]))
        print(found[-1], flush=True)
    return found, len(files)


def shifts_section(folder):
    """The table of time shifts, as Markdown."""
    found, number = hub(folder)
    head = dict(here=len(found), all=number, function="`time_shifts`")
    yield SHIFTS.format(**head).rstrip()
    for name, part in PARTS.items():
        yield line(name, [one for one in found if one.part == part])
    yield line("all", found)
    theirs = pd.read_csv(folder / "results" / "pvanalytics-cpd-module_full_results.csv")
    theirs = theirs.set_index("file_name")["mean_absolute_error_time_series"]
    theirs = theirs[~theirs.index.duplicated()]
    same = [one for one in found if one.name in theirs.index]
    yield QUOTED.format(
        same=len(same),
        theirs=theirs[[one.name for one in same]].mean(),
        ours=np.mean([one.error for one in same]),
        size=SIZE,
        near=NEAR.days,
    ).rstrip()


def line(name, some):
    """A row of the table."""
    if not some:
        return f"| {name} | 0 | – | – | – | – | – | – |"
    errors = [one.error for one in some]
    jumps, hits, false = (
        sum(getattr(one, what) for one in some) for what in ("jumps", "found", "false")
    )
    took = max(one.took for one in some)
    return (
        f"| {name} | {len(some)} | {np.mean(errors):.2f} | {np.median(errors):.2f} | "
        f"{max(errors):.1f} | {hits} of {jumps} | {false} | {took:.2f} |"
    )


def page(folder, day):
    """The page, as Markdown."""
    yield INTRO.format(
        day=day,
        version=fem.__version__,
        python=platform.python_version(),
        **{m: __import__(m).__version__ for m in ("pvlib", "numpy", "pandas")},
    ).rstrip()
    if folder is None or not (folder / "data" / "file_metadata.csv").is_file():
        yield LACKS.rstrip()
    else:
        yield from shifts_section(folder)
    yield ""


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hub", type=Path, help="a clone of the hub's repository")
    parser.add_argument("--out", type=Path, help="Markdown; standard output if none")
    parser.add_argument("--date", default=date.today().isoformat())
    options = parser.parse_args()
    warnings.simplefilter("ignore")  # of pandas, by dates of the hub's files
    text = "\n".join(page(options.hub, options.date))
    if options.out:
        options.out.write_text(text, encoding="utf-8", newline="\n")
    else:
        print(text)


if __name__ == "__main__":
    main()
