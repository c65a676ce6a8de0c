"""
Each criterion of the loop halved and doubled alone: what moves, and what does not.

Run as ``python tests/sweep.py [--out docs/sensitivity.md]``. The records are a part of
the study's worlds, simulated once each.
"""

import argparse
import multiprocessing
import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields, replace
from datetime import date
from pathlib import Path

import pandas as pd
import study_worlds
from study_records import said, seen

from pvlib_fem import Criteria, close_loop, simulator

#: worlds of each family, of one effect with the third of its sizes
PART = {
    "exact null": (0,),
    "one effect": (0, 1, 2, 5, 7),
    "pairs and triples": (0,),
    "no catalogue": (0, 2, 4),
    "driver missing": (0,),
    "short records": (7,),
}
TIMES = {"halved": 0.5, "doubled": 2.0}


@dataclass(frozen=True)
class Setting:
    """One criterion by another value; the usual ones without a name."""

    name: str = ""
    way: str = ""

    @property
    def value(self):
        usual = getattr(Criteria(), self.name)
        value = usual * TIMES[self.way]
        if isinstance(usual, int):
            value = max(1, round(value))
        return min(value, 0.99) if 0.5 < usual < 1.0 else value

    @property
    def criteria(self):
        usual = Criteria()
        return replace(usual, **{self.name: self.value}) if self.name else usual


def settings():
    """The usual criteria, then each of them halved and doubled."""
    yield Setting()
    for field in fields(Criteria):
        if isinstance(getattr(Criteria(), field.name), int | float):
            yield from (Setting(field.name, way) for way in TIMES)


def records():
    """Worlds and cases of the sweep."""
    for family, wanted in PART.items():
        made = list(study_worlds.FAMILIES[family]())
        for i in wanted:
            world, cases = made[i]
            yield world, cases[min(2, len(cases) - 1)]


def swept(world, case):
    """What the loop says of one record by each setting."""
    (data,) = simulator.records(
        world.site,
        [case.on],
        world.days,
        world.step,
        world.seed,
        world.start,
        generator=world.generator,
    )
    data, rows = seen(data, case, world.site.forms), []
    for setting in settings():
        row = {"name": setting.name, "way": setting.way, "family": case.family}
        row |= {"seed": world.seed, "truth": case.label, "truths": len(case.truths)}
        try:
            loop = close_loop(data, criteria=setting.criteria, **world.place)
        except ValueError as error:
            rows.append(row | {"broken": f"{type(error).__name__}: {error}"})
            continue
        what = said(loop, case)
        row["found"] = len(what["found"]) + what["unexplained_ok"]
        row["asked"] = len(case.truths) or int(case.family == "no catalogue")
        row["wrong"] = len(what["named_wrong"])
        row["misled"] = len(what["class_wrong"])
        row["said"] = tuple(
            (str(f.verdict), f.candidates) for f in loop.findings if f.added
        )
        row["left"] = tuple(f.candidates for f in loop.unexplained)
        row["error"] = float(loop.table["rmse_test"][loop.last])
        rows.append(row)
    return rows


def run(processes=2):
    """A row for each record and setting."""
    tasks = list(records())
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[name] = "1"
    context = multiprocessing.get_context("spawn")
    rows, begin = [], time.perf_counter()
    with ProcessPoolExecutor(processes, mp_context=context) as pool:
        for (_, case), some in zip(tasks, pool.map(swept, *zip(*tasks))):
            rows += some
            passed = time.perf_counter() - begin
            print(f"{case.family}: {case.label}, {passed:.0f} s", file=sys.stderr)
    return pd.DataFrame(rows)


def moved(table, usual):
    """Sums of a setting, and in how many records it says something else."""
    both = table.merge(usual, on=["seed", "truth"], suffixes=("", "_usual"))
    return {
        "found": int(both["found"].sum()),
        "wrong": int(both["wrong"].sum()),
        "misled": int(both["misled"].sum()),
        "said": int((both["said"] != both["said_usual"]).sum()),
        "left": int((both["left"] != both["left_usual"]).sum()),
        "error": float((both["error"] - both["error_usual"]).mean()),
        "broken": int(both["broken"].notna().sum()) if "broken" in both else 0,
    }


def cells(row, usual):
    """What a setting changes, in words; a dot where it changes nothing."""
    parts = []
    for key, words in (("found", "found"), ("wrong", "wrong"), ("misled", "misled")):
        if change := row[key] - usual[key]:
            parts.append(f"{change:+d} {words}")
    if row["said"] or row["left"]:
        parts.append(f"{row['said']} say, {row['left']} leave other")
    if abs(row["error"]) >= 0.0005:
        parts.append(f"{row['error']:+.3f} K")
    if row["broken"]:
        parts.append(f"{row['broken']} refused")
    return ", ".join(parts) or "·"


INTRO = """\
# What each criterion does

Written by `make sweep` on {day}: every field of {{py:class}}`pvlib_fem.Criteria`
halved and doubled alone (a share at most 0.99, a whole number at least 1), over {count}
records of the study, seeds {low} to {high}; {minutes:.0f} min. By the usual criteria
{found} of {asked} truths are found, with {wrong} wrong names and {misled} classes
without a true member.

A cell has the change in truths *found*, names *wrong* and classes *misled*; in how many
records the loop *says* other causes or *leaves* other structure; and the mean change of
the error on test weeks. A dot: nothing moves in these records.
"""


def page(table, seconds, day):
    """The table, as Markdown."""
    if "broken" not in table:
        table["broken"] = None
    usual = table[table["name"] == ""]
    sums = moved(usual, usual)
    yield INTRO.format(
        day=day,
        count=len(usual),
        low=table["seed"].min(),
        high=table["seed"].max(),
        minutes=seconds / 60,
        found=sums["found"],
        asked=int(usual["asked"].sum()),
        wrong=sums["wrong"],
        misled=sums["misled"],
    )
    yield "| criterion | stage | usual | halved | doubled |"
    yield "|---|---|---|---|---|"
    idle, sharp, stages = [], [], Criteria.stages()
    for field in fields(Criteria):
        part = table[table["name"] == field.name]
        if part.empty:
            continue
        rows = {w: moved(part[part["way"] == w], usual) for w in TIMES}
        words = [cells(rows[way], sums) for way in TIMES]
        if words == ["·", "·"]:
            idle.append(field.name)
        worse = (r["wrong"] > sums["wrong"] for r in rows.values())
        fewer = (r["found"] < sums["found"] for r in rows.values())
        if any(worse) or any(fewer):
            sharp.append(field.name)
        stage, value = stages[field.name], f"{field.default:g}"
        yield f"| `{field.name}` | {stage} | {value} | {' | '.join(words)} |"
    yield ""
    start = "A truth is lost or a wrong name comes up by half or double of"
    yield f"{start}: {', '.join(f'`{name}`' for name in sharp) or 'none'}."
    yield ""
    names = ", ".join(f"`{name}`" for name in idle) or "none"
    yield f"Nothing moves in these records by: {names}."
    yield ""
    yield (
        "Some of those guard against what is not in these records: columns made from "
        "the answer, drivers that lack, short records, clocks, periods of a timetable."
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="Markdown; standard output if none")
    parser.add_argument("--table", type=Path, help="all rows, pickled")
    parser.add_argument("--date", default=date.today().isoformat())
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    begin = time.perf_counter()
    table = run(options.processes)
    if options.table:
        table.to_pickle(options.table)
    seconds = time.perf_counter() - begin
    text = "\n".join(page(table, seconds, options.date)) + "\n"
    if options.out:
        options.out.write_text(text, encoding="utf-8")
    else:
        print(text)


if __name__ == "__main__":
    main()
