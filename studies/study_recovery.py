"""
What would be found at the measured plants, and from what size.

Run as
``python studies/study_recovery.py [--draws 2] [--out docs/study_recovery.md]``.
Every effect that has its columns is put into the two measured records of years, every
course of an instrument at drawn dates. What is done is kept in ``--folder``, from
where a run goes on that was interrupted.
"""

import argparse
from pathlib import Path

import pandas as pd
from pvlib.location import Location
from study_page import publish

from pvlib_fem import datasets, recover_effects
from pvlib_fem._recovery.recovery_result import middle_of
from pvlib_fem._recovery.recovery_text import CLEARLY, lines
from pvlib_fem.effects import CHANGES, find

YEARS = ("eurac_bolzano", "nrel_stf")
SIZES = (0.7, 1.0, 1.5, 2.0)  # times the predicted one
FOUND, WRONG, NEAR = 0.9, 0.01, 0.3  # the bars
COVER, WIDE = 0.9, 3.0  # and those of ranges

INTRO = """\
# What would be found at two measured plants

The records are those of {{doc}}`guide/public_records`, and {{doc}}`guide/recovery` says
how effects are put into them: {injections} in all, {sizes} times the size from which
each should be found, each sensor fault with each time profile, at {draws}.

| bar | share | met |
|---|---|---|
| found from {clearly:g} × the predicted size: ≥ {found:.0%} | {clear} | {clear_met} |
| with a wrong name: ≤ {wrong:.0%} | {names} | {names_met} |
| half of all are found within {near:.0%} of the predicted size | at {middle:.2f} × \
({low:.2f} to {high:.2f}) | {middle_met} |
| half of each effect are: all effects | {halves} | {halves_met} |
| effects whose interval is outside of that: none | {apart} | {apart_met} |
| the range of a coefficient holds what was put in: ≥ {cover:.0%} | {held} | \
{held_met} |
| it is at most {wide:g} times as wide as would hold {cover:.0%}, in the median | \
{times:.1f} times | {times_met} |

Of the {wrongs} wrong names, {again} are of a sensor whose fault the record itself
shows, with another time profile.

The size at which half are found has an interval of 90 %, which is wide with four
injections of each effect. A wrong name, or an ambiguous finding without the true cause,
is one that the record itself does not show.
Both records have small amounts of most effects themselves. With an injection these
become large enough to be found, and nobody knows their true size.
"""


def run(draws, processes, folder, effects=None):
    """What is found in each record."""
    folder.mkdir(parents=True, exist_ok=True)
    found = {}
    for name in YEARS:
        data = datasets.load(name)
        site = [data.attrs[part] for part in ("latitude", "longitude", "tz")]
        how = dict(sizes=SIZES, draws=draws, location=Location(*site))
        how |= dict(processes=processes, path=folder / f"recovery_{name}.json")
        found[name] = recover_effects(data, effects, **how)
    return found


def of_known_sensors(one):
    """Wrong names of a sensor with a fault that the record itself shows."""
    causes = [n for found in one.baseline if found.added for n in found.candidates]
    known = {find(name).sensor_fault for name in causes if name in CHANGES} - {""}
    names = [name for names in one.table["wrong"] for name in names]
    return sum(find(name).sensor_fault in known for name in names)


def share(flags):
    return f"{int(flags.sum())} of {len(flags)} ({flags.mean():.1%})"


def page(found, draws):
    """The page, as Markdown."""
    table = pd.concat([one.table for one in found.values()])
    half = pd.concat([one.half for one in found.values()])
    clear = table.loc[table["multiple"] >= CLEARLY, "found"].astype(bool)
    wrong = table["wrong"].map(bool)
    held, times = of_ranges(table)
    least, most = 1.0 - NEAR, 1.0 + NEAR
    near = half["multiple"].between(least, most)
    apart = (half["upper"] < least) | (half["lower"] > most)
    low, middle, high = middle_of(
        table["multiple"].to_numpy(float), table["found"].to_numpy(bool)
    )
    yield INTRO.format(
        injections=len(table),
        sizes=", ".join(f"{size:g}" for size in SIZES),
        draws="a drawn date" if draws == 1 else f"{draws} drawn dates each",
        clearly=CLEARLY,
        found=FOUND,
        clear=share(clear),
        clear_met=met(clear.mean() >= FOUND),
        wrong=WRONG,
        names=share(wrong),
        wrongs=sum(map(len, table["wrong"])),
        again=sum(map(of_known_sensors, found.values())),
        names_met=met(wrong.mean() <= WRONG),
        near=NEAR,
        halves=share(near),
        halves_met=met(near.all()),
        low=low,
        middle=middle,
        high=high,
        middle_met=met(least <= middle <= most),
        apart=share(apart),
        apart_met=met(not apart.any()),
        cover=COVER,
        held=share(held),
        held_met=met(held.mean() >= COVER),
        wide=WIDE,
        times=times,
        times_met=met(times <= WIDE),
    )
    for name, one in found.items():
        yield f"## {name}\n"
        yield "```text"
        yield from lines(one)
        yield "```\n"
        yield "| reported without the truth | times | in records with |"
        yield "|---|---|---|"
        yield from mistaken(one.table)
        yield ""


def of_ranges(table):
    """Whether each range holds what was put in, and how wide they are by the bar."""
    known = table[table["in_range"].notna()]
    would_do = (known["ratio"] - 1.0).abs().quantile(COVER)
    return known["in_range"] == 1.0, known["half_range"].median() / would_do


def met(kept):
    return "yes" if kept else "**no**"


def mistaken(table):
    """Reported causes that are not the truth, the most frequent first."""
    reported = []
    for effect, names, ambiguous in table[["effect", "wrong", "misled"]].to_numpy():
        reported += [(f"identified `{name}`", effect) for name in names]
        sets = [" / ".join(one.split(" | ")) for one in ambiguous]
        reported += [(f"ambiguous {words}", effect) for words in sets]
    each = pd.DataFrame(reported, columns=["words", "of"])
    each = sorted(each.groupby("words")["of"], key=lambda one: -len(one[1]))
    for words, of in each:
        yield f"| {words} | {len(of)} | {', '.join(sorted({*of}))} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=2)
    parser.add_argument("--effects", nargs="*", help="by default all")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--folder", type=Path, default=Path("docs/_build"))
    parser.add_argument("--out", type=Path, help="Markdown; standard output if none")
    options = parser.parse_args()
    how = (options.draws, options.processes, options.folder, options.effects)
    text = "\n".join(page(run(*how), options.draws))
    publish(text, options.out, "make recovery")


if __name__ == "__main__":
    main()
