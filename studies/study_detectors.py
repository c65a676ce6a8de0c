"""
Single checks on the benchmarks of others: the table in docs/detectors.md.

Run as
``python studies/study_detectors.py --hub FOLDER --wheel FILE
[--out docs/detectors.md]``, where the folder is a clone of
https://github.com/kperrynrel/time-shift-validation-hub (MIT, 700 MB) and the file is
the wheel of pvanalytics. Without them the page says how to get the data.
"""

import argparse
import io
import time
import warnings
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import study_detectors_known as known
from pvlib.location import Location
from study_page import publish

import pvlib_fem as fem

#: what is tuned on, by the remainder of a file name's number; others stay closed
PARTS = {"even, tuned on": 0, "odd, held out": 1}
NEAR = pd.Timedelta(days=30)  # between a jump and the one that is found
SIZE = 15.0  # min, by which its size may differ

LABELLED = "pvanalytics/data/pvlib_data_shift.csv"
RECORDS = {
    "eurac_bolzano": ("poa_global", "power_dc", "power_ac"),
    "nrel_stf": ("poa_global", "poa_global_2", "power_ac"),
}
DRAWS = 20  # of a step that is put into each stream
SIZES = 0.1, 0.6  # of a step, at least and at most, of either sign
MATERIAL = 0.25  # from which a step is called large

INTRO = """\
# Single checks on the benchmarks of others

{doc}`guide/detectors` has the functions.
"""
LACKS = """
The data of time shifts are not on this disk. Get them with

    git clone https://github.com/kperrynrel/time-shift-validation-hub

and give the folder as `make detectors HUB=time-shift-validation-hub`.
"""
NO_WHEEL = """
The labelled stream is not on this disk; `make detectors` gets it with
`pip download --no-deps pvanalytics==0.2.2`.
"""
DATA = """
## Data shifts

*Quoted, not measured here*: Perry and Muller (Automated shift detection in sensor-based
PV power and irradiance time series, IEEE Photovoltaic Specialists Conference, 2022)
give an F1 score of 0.76 for shifts that are dated to 30 days, on 101 labelled streams
that could not be had. So that mark and what follows are of different streams.
"""
PUT_IN = """
*Measured*: a step of {least:.0f} to {most:.0f} % of either sign is put into each of
some streams of {{doc}}`guide/public_records`, on {draws} days in turn. Nobody has
labelled these streams: a step that is found on any other day counts as false. One is
found if its day is known to {near} days. The length of a week, of which `data_shifts`
takes the second best day, was chosen on these streams, with other steps.

| stream | steps as it is | found of {material:.0f} % and more | found of less | \
false in {draws} | slowest [s] |
|---|---|---|---|---|---|
"""
TOTAL = """
Together {found} of {put} are found and {false} are false: F1 = {score:.2f}.
"""
SHIFTS = """
## Time shifts

The task of the [PV Validation Hub](https://github.com/kperrynrel/time-shift-validation-hub)
(MIT): irradiance and AC power of ten systems, some with another zone, summer time or a
clock that was set for a while, with the shift of each day. The score is the mean
absolute error of the shift over the days of a stream, averaged over streams. Everything
was tuned on streams whose file name's number is even, and fixed before the others
were opened. The code was tidied afterwards, with the same result for each stream.
{here} of {all} streams are on this disk.

| streams | number | {function}, MAE [min] | median | worst | jumps found | \
false jumps | slowest [s] |
|---|---|---|---|---|---|---|---|
"""
QUOTED = """
*Quoted, not measured here*: pvanalytics' method has a mean of 2.97 min and a median of
0 over all streams, by `results/time-shift-public-metrics.json` of that repository.
By the stream its errors are in `results/pvanalytics-cpd-module_full_results.csv`, for
{same} of the streams above: on these it has {theirs:.2f} min, and `time_shifts`
{ours:.2f} min, measured.

A jump is found if one of the same sign and of its size to {size:.0f} min is within
{near} days, and false if no true jump of that sign is. Where nothing was recorded, or
an inverter was off, a clock may have been set on any of those days, and the middle
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


def labelled(wheel):
    """What is found in the stream that pvanalytics comes with."""
    with zipfile.ZipFile(wheel) as files:
        table = pd.read_csv(io.BytesIO(files.read(LABELLED)), index_col=0)
    table.index = pd.to_datetime(table.index, format="%m/%d/%Y")
    true = table.index[table["label"] == 1]
    found = fem.detect.data_shifts(table["value"])
    apart = ", ".join(f"{day:%Y-%m-%d} by {100 * by:+.0f} %" for day, by in found.steps)
    version = wheel.name.split("-")[1]
    yield (
        f"\n*Measured*: the stream in pvanalytics {version} "
        f"(`pvlib_data_shift.csv`, {len(table)} days) has the label\n"
        f"{', '.join(f'{day:%Y-%m-%d}' for day in true)}, and `data_shifts` finds "
        f"{apart or 'nothing'}."
    )


@dataclass
class PutIn:
    """What is found of steps put into one stream."""

    name: str
    own: int
    large: list
    small: list
    false: int = 0
    took: float = 0.0


def put_in(name, series, random):
    """One stream with steps of known size and day."""
    found = PutIn(name, len(fem.detect.data_shifts(series).steps), [], [])
    whole = series.index[-1] - series.index[0]
    for _ in range(DRAWS):
        size = random.choice([-1.0, 1.0]) * random.uniform(*SIZES)
        day = (series.index[0] + whole * random.uniform(0.15, 0.85)).normalize()
        changed = series.where(series.index < day, series * (1.0 + size))
        start = time.perf_counter()
        steps = fem.detect.data_shifts(changed).steps
        found.took = max(found.took, time.perf_counter() - start)
        hits = [abs(at - day) <= NEAR for at, _ in steps]
        (found.large if abs(size) >= MATERIAL else found.small).append(any(hits))
        found.false += len(hits) - any(hits)
    print(found, flush=True)
    return found


def steps_section(wheel):
    """The part on data shifts, as Markdown."""
    yield DATA.rstrip()
    yield from labelled(wheel) if wheel and wheel.is_file() else [NO_WHEEL.rstrip()]
    random, found = np.random.default_rng(1), []
    for record, columns in RECORDS.items():
        data = fem.datasets.load(record)
        for name in columns:
            series = data[name].clip(lower=0.0)
            found.append(put_in(f"{record}, `{name}`", series, random))
    head = dict(draws=DRAWS, near=NEAR.days, material=100 * MATERIAL)
    head |= {name: 100 * size for name, size in zip(("least", "most"), SIZES)}
    yield PUT_IN.format(**head).rstrip()
    for one in found:
        yield (
            f"| {one.name} | {one.own} | {sum(one.large)} of {len(one.large)} | "
            f"{sum(one.small)} of {len(one.small)} | {one.false} | {one.took:.2f} |"
        )
    hits, put, false = (
        sum(sum(one.large) + sum(one.small) for one in found),
        DRAWS * len(found),
        sum(one.false for one in found),
    )
    score = 2 * hits / (hits + put + false)
    yield TOTAL.format(found=hits, put=put, false=false, score=score).rstrip()


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


def page(folder, wheel):
    """The page, as Markdown."""
    yield INTRO.rstrip()
    if folder is None or not (folder / "data" / "file_metadata.csv").is_file():
        yield LACKS.rstrip()
    else:
        yield from shifts_section(folder)
    yield known.summer_time()
    yield from steps_section(wheel)
    yield from known.sensors()
    yield ""


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hub", type=Path, help="a clone of the hub's repository")
    parser.add_argument("--wheel", type=Path, help="the wheel of pvanalytics")
    parser.add_argument("--out", type=Path, help="Markdown; standard output if none")
    options = parser.parse_args()
    warnings.simplefilter("ignore")  # of pandas, by dates of the hub's files
    text = "\n".join(page(options.hub, options.wheel))
    publish(text, options.out, "make detectors")


if __name__ == "__main__":
    main()
