"""
How often the loop's probabilities are right: the gates that it has to pass.

Of the rows that ``tests/study.py --table`` and ``tests/study_instruments.py --table``
wrote, on seeds on which nothing was set. Run as
``python tests/study_gate.py STUDY INSTRUMENTS [--out docs/gate.md]``.
"""

import argparse
import sys
from collections import defaultdict
from datetime import date
from pathlib import Path

import numpy as np
import pandas as pd
import study
import study_instruments
from study_worlds import IN_PHYSICS, UNDECLARED

from pvlib_fem.findings import OUTSIDE

BINS = ((0.5, 0.8), (0.8, 0.95), (0.95, 1.01))
WITHIN = 0.05  # of what is stated, a share has to be
INTRO = """\
# Gate

Does a cause that is stated with a probability of 90 % turn out to be the cause in nine
cases of ten? Records are simulated with known causes, on seeds on which no threshold
was set: {study} of the study, and {instruments} of instruments that change.
A finding is right if its set holds a cause that is there: one that was put in, or
physics that every module of the generator has. A cause outside the catalogue is right
where one was put in.

Made by `make gate` on {day}.

| gate | asked | measured | met |
|---|---|---|---|
"""

OUTRO = """
A miss of the rows of 0.50 to 0.95 is on the safe side: more of these causes are right
than is stated, since every set holds a cause outside the catalogue, and few worlds of
the simulator have one: five kinds.

Ranges of few records say little by themselves; `make study` and `make
study-instruments` have every coefficient. Whether measured records say the same when
other weeks are left out is in {doc}`study_measured`.
"""


def truths_of(row):
    """Causes of a study's record, and whether one is in no catalogue."""
    physics = set() if row["family"] == "exact null" else IN_PHYSICS
    known = set(row["truths"]) | physics
    if row["family"] == study.SECOND_GENERATOR:  # which has a sky of its own
        known |= {"sky_radiation"}
    undeclared = any(switch in UNDECLARED for switch in row["sizes"])
    return known, undeclared


def findings_of(table, changes):
    """Every finding with the causes that are there, and whether one is unknown."""
    for _, row in table.iterrows():
        if isinstance(row["sets"], list):
            known, undeclared = truths_of(row)
            for one in row["sets"]:
                yield one, known, undeclared
    for row in changes:
        known = study_instruments.PRESENT | set(row["truths"])
        for one in row["sets"]:
            yield one, known, False


def held(one, sure=0.95):
    """The smallest set of causes that has a probability together."""
    found, total = set(), 0.0
    for name, share in sorted(one["shares"].items(), key=lambda item: -item[1]):
        found.add(name)
        total += share
        if total >= sure:
            break
    return found


def gates(table, changes):
    """Words, what is asked, what was measured, and whether it is met."""
    found = [*findings_of(table, changes)]
    records = sum(isinstance(row, list) for row in table["sets"]) + len(changes)
    named = [(one, known) for one, known, _ in found if one["verdict"] == "named"]
    wrong = sum(one["effect"] not in known for one, known in named)
    yield at_most("records with a wrong name", wrong, records, 0.003)
    nulls = table[[not sizes for sizes in table["sizes"]]]
    some = sum(len(listed(names)) > 0 for names in nulls["named_wrong"])
    yield at_most("wrong names in records with physics alone", some, len(nulls), 0.0)
    right = [bool(held(o) & k) or (u and OUTSIDE in held(o)) for o, k, u in found]
    yield at_most("sets without the truth", len(right) - sum(right), len(right), 0.03)
    unknown = table[table["family"] == "no catalogue"]
    some = sum(len(listed(names)) > 0 for names in unknown["named_wrong"])
    words = "unknown causes that are given a name of the catalogue"
    yield at_most(words, some, len(unknown), 0.02)
    large = [row for row in changes if row["clear"]]
    some = sum(row["found"] for row in large)
    words = "changes of instruments that are clear, and in a set"
    yield at_least(words, some, len(large), 0.95)
    dates = [row["dates"][0] for row in changes if row["dates"]]
    yield at_least("dates within their interval", sum(dates), len(dates), 0.95)
    for low, high in BINS:
        stated, true = [], []
        for one, known, undeclared in found:
            for name, share in one["shares"].items():
                if low <= share < high:
                    there = undeclared if name == OUTSIDE else name in known
                    stated.append(share)
                    true.append(there)
        if stated:
            words = f"causes stated at {low:.2f} to {min(high, 1.0):.2f}"
            mean, share = np.mean(stated), np.mean(true)
            size = f"{share:.2f} of {len(true)} are right, stated {mean:.2f}"
            yield words, "within 0.05", size, abs(share - mean) <= WITHIN
    for name, rows in sorted(coverage(table, changes).items()):
        words = f"ranges of `{name}` that hold the truth"
        yield at_least(words, sum(rows), len(rows), 0.90)


def coverage(table, changes):
    """Whether each range holds the truth, by effect."""
    found = defaultdict(list)
    told = [row for row in table["told"] if isinstance(row, dict)]
    for one in (*told, *(row["told"] for row in changes)):
        for known in one.values():
            if known.get("range") is not None:
                low, high = known["range"]
                name = known["name"].split(".")[0]
                found[name].append(low <= known["truth"] <= high)
    return found


def listed(names):
    return names if isinstance(names, tuple) else ()


def at_most(words, some, count, most):
    share = some / max(count, 1)
    measured = f"{some} of {count} ({share:.1%})"
    return words, f"at most {most:.1%}", measured, share <= most


def at_least(words, some, count, least):
    share = some / max(count, 1)
    measured = f"{some} of {count} ({share:.0%})"
    return words, f"at least {least:.0%}", measured, share >= least


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("study", type=Path, help="rows of the study, pickled")
    parser.add_argument("instruments", type=Path, help="rows of instruments, pickled")
    parser.add_argument("--out", type=Path, help="Markdown; standard output if none")
    options = parser.parse_args()
    table = pd.read_pickle(options.study)
    changes = [row for _, row in pd.read_pickle(options.instruments).iterrows()]
    head = INTRO.format(
        study=len(table), instruments=len(changes), day=date.today().isoformat()
    )
    lines = [
        f"| {words} | {asked} | {measured} | {'yes' if met else '**no**'} |"
        for words, asked, measured, met in gates(table, changes)
    ]
    text = head + "\n".join(lines) + "\n" + OUTRO
    if options.out is None:
        sys.stdout.write(text)
    else:
        options.out.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
