"""
Each criterion of the loop halved and doubled alone: what moves, and what does not.

Run as
``python studies/sweep.py [--out docs/sensitivity.md]``. The records are a part of
the study's worlds, simulated once each, and records with what the loop guards against.
"""

import argparse
import sys
import time
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
import pandas as pd
import study_worlds
from study_page import publish
from study_records import said, seen
from study_worlds import PHYSICS, Case, World, site

from pvlib_fem import Criteria, close_loop, simulator
from pvlib_fem._parallel import spread
from pvlib_fem._record.column_names import COLUMNS, numeric, with_aliases
from pvlib_fem._record.inputs import as_record, with_columns
from pvlib_fem.quality._check import check
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._screen import screened
from pvlib_fem.quality._unit_checks import oddities

#: worlds of each family, of one effect with the third of its sizes
PART = {
    "exact null": (0, 3),
    "one effect": (0, 1, 2, 5, 6, 7, 8, 16),
    "pairs and triples": (0, 1, 2),
    "no catalogue": (0, 2, 4, 9),
    "its driver as a column": (1,),
    "driver missing": (0, 1),
    "ties": (0, 3),
    study_worlds.LOGGERS: (4,),
    "short records": (7, 14, 15),
}
GUARDS = "what the loop guards against"
STEP = 600.0  # s
SUMS = ("found", "wrong", "misled")
TIMES = {"halved": 0.5, "doubled": 2.0}


@dataclass(frozen=True)
class Setting:
    """One criterion by another value; the usual ones without a name."""

    name: str = ""
    way: str = ""

    def applied_to(self, usual):
        """The criteria, or limits, with this one by its other value."""
        if not self.name:
            return usual
        value = getattr(usual, self.name)
        other = value * TIMES[self.way]
        if isinstance(value, int):
            other = max(1, round(other))
        other = min(other, 0.99) if 0.5 < value < 1.0 else other
        return replace(usual, **{self.name: other})


def settings(usual, names=()):
    """The usual criteria, or limits, then each, or some, of them halved and doubled."""
    yield Setting()
    for field in fields(usual):
        if names and field.name not in names:
            continue
        if isinstance(getattr(usual, field.name), int | float):
            yield from (Setting(field.name, way) for way in TIMES)


def records():
    """Worlds and cases of the sweep, and what a user's file has of each."""
    for family, wanted in PART.items():
        made = list(study_worlds.FAMILIES[family]())
        for i in wanted:
            world, cases = made[i]
            # on longer steps the same rules decide, in a third of the time
            yield replace(world, step=STEP), cases[min(2, len(cases) - 1)], None
    yield from guarded()


def instruments():
    """Records for what is checked of sensors and clocks, before any fit."""
    sound = list(study_worlds.FAMILIES["physics null"]())[3:6]
    for world, cases in [*study_worlds.FAMILIES[study_worlds.LOGGERS](), *sound]:
        if "swap" not in cases[0].on:  # the usual columns' units are no limits
            days = min(world.days, 90.0) if world.step < 300 else world.days
            yield replace(world, days=days), cases[0], None
    yield from guarded()


def guarded():
    """Records with what the loop guards against."""
    sky = Case(GUARDS, PHYSICS | {"sky_radiation": 1.0}, {"sky_radiation": 1.0})
    changes = {leaks: 100.0, gaps: 25.0, far: 365.0, frozen: 45.0, thin: 120.0}
    changes |= {foreign: 90.0, filled: 90.0, coarse: 90.0}
    for i, (change, count) in enumerate(changes.items()):
        step = 60.0 if change is thin else STEP
        yield World(site(9700 + i), 9700 + i, count, step), sky, change


def leaks(data, random):
    """Columns that are made of the module's temperature, more and less of it."""
    for size in (2.0, 6.0):
        noise = size * random.standard_normal(len(data))
        data[f"panel_{size:g}"] = data["temp_module"] + noise
    over = data["temp_module"] - data["temp_air"]
    data["over"] = over + 3.0 * random.standard_normal(len(data))
    return data


def gaps(data, random):
    """Days without the humidity, with a third of the rows of others."""
    day = (np.arange(len(data)) * data.attrs["step"] // 86400).astype(int)
    lost = random.random(day.max() + 1) < 0.15
    data.loc[lost[day], "relative_humidity"] = np.nan
    thin = random.random(day.max() + 1) < 0.2
    return data[~thin[day] | (random.random(len(data)) < 0.4)]


def far(data, random):
    """A driver that is mostly missing, a clock 5 min ahead, wandering sensors."""
    data.loc[random.random(len(data)) < 0.3, "precipitation"] = np.nan
    return data.assign(
        temp_module=data["temp_module"].shift(1),
        speed=data["wind_speed"] + 0.3 * random.standard_normal(len(data)),
    )


def frozen(data, random):
    """Sensors that keep their value for hours, and one for days."""
    for name, hours in (("wind_speed", 5), ("temp_air", 8), ("temp_module", 60)):
        rows = int(hours * 3600 / data.attrs["step"])
        begin = int(random.integers(len(data) - rows))
        data.iloc[begin : begin + rows, data.columns.get_loc(name)] = 7.0
    return data


def coarse(data, random):
    """Sensors of whole units, calms at an offset, and faults of two and four days."""
    for name in ("temp_air", "temp_module", "wind_speed", "relative_humidity"):
        data[name] = data[name].round()
    data["wind_speed"] = data["wind_speed"].clip(lower=1.0)
    for name, days in (("temp_module", 2), ("relative_humidity", 2), ("wind_speed", 4)):
        rows = int(days * 86400 / data.attrs["step"])
        begin = int(random.integers(len(data) - rows))
        value = data[name].min() if name == "wind_speed" else data[name].median()
        data.iloc[begin : begin + rows, data.columns.get_loc(name)] = value
    return data


def thin(data, random):
    """Half of all rows, at random."""
    return data[random.random(len(data)) < 0.5]


def file_of(world, case, change):
    """A user's file of one record."""
    (data,) = simulator.records(
        world.site,
        [case.on],
        world.days,
        world.step,
        world.seed,
        world.start,
        generator=world.generator,
    )
    data = seen(data, case, world.site.forms)
    if change is not None:
        data.attrs = {"step": world.step}
        data = change(data, np.random.default_rng([world.seed, 31]))
    return data


def looked_at(world, case, change):
    """What is said of sensors and clocks of one record by each limit."""
    columns, rows = with_aliases(file_of(world, case, change)), []
    usual = as_record(*(columns.pop(n) for n in COLUMNS))
    record = with_columns(usual, numeric(columns))
    for setting in settings(Limits()):
        row = {"name": setting.name, "way": setting.way, "family": case.family}
        row |= {"seed": world.seed, "truth": case.label}
        try:
            limits = setting.applied_to(Limits())
            clean, faults = screened(record, limits)
            health = check(clean, limits=limits, **world.place)
            kinds = faults.counts[["column", "kind"]].itertuples(index=False)
            said = [*health.faults, *(f"{column}: {kind}" for column, kind in kinds)]
            odd = oddities(clean.inputs, limits)
            row |= {
                "faults": sorted(said),
                "words": (*faults.notes, *odd, *health.notes),
            }
        except ValueError as error:
            row |= {"faults": ["refused"], "words": (str(error),)}
        rows.append(row)
    return rows


def swept(names, world, case, change):
    """What the loop says of one record by each criterion."""
    data, rows = file_of(world, case, change), []
    for setting in settings(Criteria(), names):
        row = {"name": setting.name, "way": setting.way, "family": case.family}
        row |= {"seed": world.seed, "truth": case.label, "truths": len(case.truths)}
        try:
            loop = close_loop(
                data, criteria=setting.applied_to(Criteria()), **world.place
            )
        except ValueError as error:
            rows.append(row | {"broken": f"{type(error).__name__}: {error}"})
            continue
        what = said(loop, case, world)
        row["found"] = len(what["found"]) + what["unexplained_ok"]
        row["asked"] = len(case.truths) or int(case.family == "no catalogue")
        row["wrong"] = len(what["named_wrong"])
        row["misled"] = len(what["class_wrong"])
        row["said"] = tuple(
            (str(f.verdict), f.candidates) for f in loop.finding_objects if f.added
        )
        row["left"] = tuple(f.candidates for f in loop.unexplained)
        row["told"] = findings_of(loop)
        row["error"] = float(loop.table["rmse_test"].iloc[-1])
        rows.append(row)
    return rows


def findings_of(loop):
    """Other reported results: hints, withdrawn findings, corrections, the rest."""
    others = tuple(
        (f.verdict, f.candidates, str(f.place))
        for f in loop.finding_objects
        if not f.added
    )
    fixed = tuple((one.fault, one.applied) for one in loop.corrections)
    order = tuple(loop.ranking.index)
    return repr((others, fixed, sorted(loop.untestable), loop.fit.notes, order))


def filled(data, random):
    """A logger's codes, spikes, broken cables and foreign numbers."""
    places = {name: data.columns.get_loc(name) for name in data}

    def some(count):
        return random.choice(len(data), count, replace=False)

    data.iloc[some(80), places["poa_global"]] = -7999.0
    data.iloc[some(40), places["relative_humidity"]] = -6999.0
    data.iloc[some(30), places["temp_air"]] += 30.0
    data.iloc[some(30), places["temp_module"]] -= 70.0
    data.iloc[some(300), places["poa_global"]] = -8.0
    return data


def foreign(data, random):
    """Drivers in other units."""
    return data.assign(
        relative_humidity=data["relative_humidity"] / 100.0,
        wind_direction=np.radians(data["wind_direction"]),
        longwave_down=data["longwave_down"] - 300.0,
        p_dc_per_area=3.0 * data["p_dc_per_area"],
        temp_sky=data["temp_air"] + 263.15,
    )


def run(look, tasks, processes=2, shared=()):
    """A row for each record and setting."""
    tasks = list(tasks)
    rows, begin = [], time.perf_counter()
    for (_, case, _), some in zip(tasks, spread(look, tasks, processes, shared)):
        rows += some
        passed = time.perf_counter() - begin
        print(f"{case.family}: {case.label}, {passed:.0f} s", file=sys.stderr)
    return pd.DataFrame(rows)


def moved(table, usual):
    """What a setting changes, and in how many records it says something else."""
    both = table.merge(usual, on=["seed", "truth"], suffixes=("", "_usual"))
    return {
        **{n: int((both[n] - both[f"{n}_usual"]).sum()) for n in SUMS},
        "said": int((both["said"] != both["said_usual"]).sum()),
        "left": int((both["left"] != both["left_usual"]).sum()),
        "told": int((both["told"] != both["told_usual"]).sum()),
        "error": float((both["error"] - both["error_usual"]).mean()),
        "broken": int(both["broken"].notna().sum()) if "broken" in both else 0,
    }


def cells(row):
    """What a setting changes, in words; a dot where it changes nothing."""
    parts = [f"{row[name]:+d} {name}" for name in SUMS if row[name]]
    if row["said"] or row["left"]:
        parts.append(f"{row['said']} say, {row['left']} leave other")
    elif row["told"]:
        parts.append(f"{row['told']} tell other")
    if abs(row["error"]) >= 0.0005:
        parts.append(f"{row['error']:+.3f} K")
    if row["broken"]:
        parts.append(f"{row['broken']} refused")
    return ", ".join(parts) or "·"


INTRO = """\
# What each criterion does

Every field of {{py:class}}`pvlib_fem.Criteria`
halved and doubled alone (a share at most 0.99, a whole number at least 1), over {count}
records of the study, seeds {low} to {high}; {minutes:.0f} min. By the usual criteria
{found} of {asked} truths are found, with {wrong} wrong names and {misled} ambiguous
findings without the true cause.

A cell has three changes: truths *found*, names *wrong* and ambiguous findings *misled*;
the number of records in which the loop *says* other causes, *leaves* another
unexplained pattern, or only *tells* other hints, notes or ranks; and the mean change of
the error on test weeks. A dot means that nothing changes in these records.
"""


def page(table, seconds):
    """The table, as Markdown."""
    if "broken" not in table:
        table["broken"] = None
    usual = table[table["name"] == ""]
    yield INTRO.format(
        count=len(usual),
        low=table["seed"].min(),
        high=table["seed"].max(),
        minutes=seconds / 60,
        found=int(usual["found"].sum()),
        asked=int(usual["asked"].sum()),
        wrong=int(usual["wrong"].sum()),
        misled=int(usual["misled"].sum()),
    )
    yield "| criterion | usual | halved | doubled |"
    yield "|---|---|---|---|"
    idle, sharp = [], []
    for field in fields(Criteria):
        part = table[table["name"] == field.name]
        if part.empty:
            continue
        rows = {w: moved(part[part["way"] == w], usual) for w in TIMES}
        words = [cells(rows[way]) for way in TIMES]
        if words == ["·", "·"]:
            idle.append(field.name)
        worse = (row["wrong"] > 0 for row in rows.values())
        fewer = (row["found"] < 0 for row in rows.values())
        if any(worse) or any(fewer):
            sharp.append(field.name)
        value = f"{field.default:g}"
        yield f"| `{field.name}` | {value} | {' | '.join(words)} |"
    yield ""
    start = "A truth is lost or a wrong name comes up by half or double of"
    yield f"{start}: {', '.join(f'`{name}`' for name in sharp) or 'none'}."
    yield ""
    names = ", ".join(f"`{name}`" for name in idle) or "none"
    yield f"Nothing moves in these records by: {names}."


HEAD = "## Sensors and clocks"
LIMITS = """
{head}

Every field of `quality.Limits` was halved and doubled for {count}
records: faults of clocks and loggers of the study, sound records, and records with
traps for the loop. The checks come before any fit. A cell has the number of records
with other faults, or, if there are none, with the same faults in other numbers.
"""


def page_of_limits(table):
    """The table of what is checked before any fit."""
    usual = table[table["name"] == ""]
    yield LIMITS.format(head=HEAD, count=len(usual))
    yield "| limit | usual | halved | doubled |"
    yield "|---|---|---|---|"
    idle = []
    for field in fields(Limits):
        words = []
        for way in TIMES:
            part = table[(table["name"] == field.name) & (table["way"] == way)]
            both = part.merge(usual, on=["seed", "truth"], suffixes=("", "_usual"))
            other = int((both["faults"] != both["faults_usual"]).sum())
            number = int((both["words"] != both["words_usual"]).sum())
            faults = f"{other} faults" if other else f"{number} numbers"
            words.append(faults if other or number else "·")
        if words == ["·", "·"]:
            idle.append(field.name)
        yield f"| `{field.name}` | {field.default:g} | {' | '.join(words)} |"
    yield ""
    names = ", ".join(f"`{name}`" for name in idle) or "none"
    yield f"Nothing moves in these records by: {names}."


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="Markdown; standard output if none")
    parser.add_argument("--table", type=Path, help="all rows, pickled")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--criteria", nargs="*", default=(), help="these alone")
    parser.add_argument("--limits", action="store_true", help="limits alone")
    options = parser.parse_args()
    begin, lines = time.perf_counter(), []
    if not options.limits:
        table = run(swept, records(), options.processes, (options.criteria,))
        if options.table:
            table.to_pickle(options.table)
        lines += page(table, time.perf_counter() - begin)
    if not options.criteria:
        limits = run(looked_at, instruments(), options.processes)
        lines += page_of_limits(limits)
    text = "\n".join(lines) + "\n"
    publish(text, options.out, "" if options.limits else "make sweep")


if __name__ == "__main__":
    main()
