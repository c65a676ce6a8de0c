"""
A fleet of simulated systems: how fast it is, and what it finds of what was done to it.

Sites of ten systems each share a weather station. In some the station changes, in
some systems the module does: made in the columns, after the simulator, or by its
switches. Run as ``python benchmarks/fleet.py [--systems 200] [--workers 2]``.
"""

import argparse
import resource
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pandas as pd
import psutil
from pvlib.location import Location

sys.path.insert(0, str(Path(__file__).parents[1] / "studies"))
from study_instruments import changed
from study_worlds import site as drawn_site

from pvlib_fem import close_loop, fleet, read_file, simulator
from pvlib_fem.fleet._shared import STATIONS, shared_causes

A_SITE = 10  # systems of one
#: of a station and of a module: channel and size, or switch and amplitude; the names
#: under which a record can tell it
OF_STATION = (
    None,
    (
        "irradiance_sensor",
        0.12,
        {"irradiance_sensor_step", "module_sensor_contact_step", "mounting_step"},
    ),
    ("anemometer", 0.5, {"anemometer_step"}),
)
OF_MODULE = (
    None,
    None,
    None,
    (
        "module_sensor_contact",
        0.25,
        {"module_sensor_contact_step", "mounting_step", "irradiance_sensor_step"},
    ),
    ("module_offset", 2.5, {"module_offset_step", "air_offset_step"}),
    ("shading", 1.0, {"shading"}),
    ("soiling", 1.5, {"soiling"}),
)
PLACE = ("latitude", "longitude", "surface_tilt", "surface_azimuth")


def made(folder, count, days, step):
    """The table of systems, whose files are written, and what was done to each."""
    rows, truth = [], {}
    for number in range(0, count, A_SITE):
        random = np.random.default_rng([number, 31])
        site = drawn_site(90_000 + number)
        station = OF_STATION[number // A_SITE % len(OF_STATION)]
        causes = [OF_MODULE[i] for i in random.integers(0, len(OF_MODULE), A_SITE)]
        switched = [
            simulator.OUTDOORS | ({c[0]: c[1]} if c and c[0] in SWITCHED else {})
            for c in causes
        ]
        data = simulator.records(site, switched, days, step, 90_000 + number)
        for i, (one, cause) in enumerate(zip(data, causes)):
            name = f"{number // A_SITE:03}-{i}"
            for what, share in ((station, 0.4), (cause, 0.65)):
                if what and what[0] not in SWITCHED:
                    late = np.arange(len(one)) >= share * len(one)
                    one = changed(one, *what[:2], late.astype(float))
            one.attrs = {}
            one.drop(columns="p_dc_per_area").to_parquet(folder / f"{name}.parquet")
            place = {key: getattr(site, key) for key in PLACE}
            row = {
                "id": name,
                "file": f"{name}.parquet",
                "site": f"site {number // 10}",
            }
            rows.append(row | place | {"mounting": site.mounting})
            truth[name] = station, cause
    table = pd.DataFrame(rows[:count])
    table.to_csv(folder / "systems.csv", index=False)
    return table, truth


SWITCHED = ("shading", "soiling")


def bare(folder, table):
    """The loops alone, in this process."""
    for row in table.to_dict("records"):
        data = read_file(folder / row["file"])
        location = Location(row["latitude"], row["longitude"], tz=str(data.index.tz))
        close_loop(
            data, "faiman", location, row["surface_tilt"], row["surface_azimuth"]
        )


def timed(work):
    """Wall and processor time, that of ended children included. [s]"""
    begin, spent = time.perf_counter(), used()
    work()
    return time.perf_counter() - begin, used() - spent


def used():
    kinds = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return sum(sum(resource.getrusage(kind)[:2]) for kind in kinds)


def killer(after):
    """Gets each answer, and ends one worker in mid-run."""
    seen = []

    def count(answer):
        seen.append(answer)
        if len(seen) == after:
            workers = psutil.Process().children(recursive=True)
            spawned = [w for w in workers if "spawn_main" in " ".join(w.cmdline())]
            spawned[0].kill()
            print(f"killed a worker after {after} systems", file=sys.stderr)

    return count


def findings_of(results, truth):
    """How often what was done was found, and what sites share."""
    findings = results.findings
    added = findings[findings["added"]]
    names = added.groupby("id")["candidates"].apply(
        lambda some: {n for text in some for n in text.split(" | ")}
    )
    for kind, which in (("station", 0), ("module", 1)):
        asked = {name: done[which] for name, done in truth.items() if done[which]}
        for channel in sorted({cause[0] for cause in asked.values()}):
            mine = {n: c for n, c in asked.items() if c[0] == channel}
            found = sum(bool(names.get(n, set()) & c[2]) for n, c in mine.items())
            yield f"{channel} of the {kind}", f"{found} of {len(mine)}"
    groups = shared_causes(results.systems, findings)
    changed_sites = {
        row["site"]: truth[row["id"]][0]
        for row in results.systems.to_dict("records")
        if truth[row["id"]][0]
    }
    blamed = {g.site for g in groups if g.everywhere and g.candidates & STATIONS}
    right = len(blamed & {*changed_sites})
    yield (
        "sites whose station changed, and is suspected",
        (f"{right} of {len(changed_sites)}"),
    )
    sites = results.systems["site"].nunique() - len(changed_sites)
    yield (
        "other sites whose station is suspected",
        (f"{len(blamed - {*changed_sites})} of {sites}"),
    )


def line(words, value, reach=""):
    print(f"{words:<58}{value:>18}   {reach}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--systems", type=int, default=200)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--stored", type=int, default=40, help="of storage alone")
    parser.add_argument("--days", type=int, default=365)
    parser.add_argument("--step", type=float, default=300.0)
    parser.add_argument("--out", type=Path, help="folder that is kept")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.out or Path(temporary)
        folder.mkdir(exist_ok=True)
        table, truth = made(folder, given.systems, given.days, given.step)
        count = len(table)
        line(f"systems of {given.days} days at {given.step / 60:g} min", f"{count}")
        systems, out = folder / "systems.csv", folder / "results"
        serial, given_some = folder / "serial", folder / "some.csv"
        how = dict(workers=given.workers)
        bare(folder, table[:1])  # imports and caches
        # the machine may change its pace: half of the bare loops before, half after
        alone = timed(lambda: bare(folder, table[::2]))
        many = timed(lambda: fleet.run(systems, out, **how))
        alone = np.add(alone, timed(lambda: bare(folder, table[1::2])))
        line("bare loops, a system", f"{alone[0] / count:.2f} s", "wall")
        line(
            f"{given.workers} workers against one process, wall",
            f"{alone[0] / many[0]:.2f} x",
            ">= 1.8 x",
        )
        over = f"{100 * (many[1] / alone[1] - 1):.1f} %"
        line("engine and storage, start included, processor time", over, "<= 10 %")
        some = table.iloc[:: max(count // given.stored, 1)]
        some.to_csv(given_some, index=False)
        anew = dict(workers=0, resume=False)
        spent = min(timed(lambda: bare(folder, some))[1] for _ in range(2))
        stored = min(
            timed(lambda: fleet.run(given_some, serial, **anew))[1] for _ in range(2)
        )
        over = f"{100 * (stored / spent - 1):.1f} %"
        line(f"storage alone, of {len(some)} systems, the same", over, "<= 10 %")
        again = timed(lambda: fleet.run(systems, out, **how))
        line("all kept, resumed, a system", f"{1e3 * again[0] / count:.0f} ms")
        how |= dict(progress=killer(max(count // 4, 1)), resume=False)
        results = fleet.run(systems, folder / "killed", **how)
        for name in ("systems", "coefficients", "findings"):
            same = (folder / "killed" / f"{name}.parquet").read_bytes()
            one = (out / f"{name}.parquet").read_bytes()
            line(f"{name} with a worker killed, and without", str(one == same))
        files = sorted((serial / "results").rglob("*.json"))
        same = sum(
            file.read_bytes() == (out / file.relative_to(serial)).read_bytes()
            for file in files
        )
        line("results of workers as in one process", f"{same} of {len(files)}")
        sizes = [p.stat().st_size for p in (out / "results").rglob("*.json")]
        line("a result", f"{max(sizes) / 1e3:.0f} kB at most", "< 1 MB")
        made_in, _ = timed(lambda: fleet.report(out, folder / "fleet.html"))
        line("the page of all", f"{made_in:.1f} s")
        for words, value in findings_of(results, truth):
            line(words, value)


if __name__ == "__main__":
    main()
