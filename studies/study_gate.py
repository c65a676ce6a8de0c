"""
How often the loop's probabilities are right: the gates that it has to pass.

Of the rows that ``studies/study.py --table`` and
``studies/study_instruments.py --table``
wrote, on seeds on which nothing was set. Run as
``python studies/study_gate.py STUDY INSTRUMENTS [--oracle STUDY INSTRUMENTS]
[--out docs/gate.md]``,
where the oracle's rows are those of ``studies/study_oracle.py``.
"""

import argparse
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import study_instruments
from study_page import publish
from study_worlds import ALSO, CLOSED, CLOSED_CAUSES, IN_PHYSICS, UNDECLARED, UNKNOWN

from pvlib_fem._findings import OUTSIDE, OUTSIDE_WORDS

BINS = ((0.5, 0.8), (0.8, 0.95), (0.95, 1.01))
WITHIN = 0.05  # of what is stated, a share has to be
FEWEST = 5  # times that a cause is stated, to have a row
HARDLY = 0.005  # K by which a median error may be above that by the rules
INTRO = """\
# Gate

If the loop states a cause with a probability of 90 %, is it right in nine cases of ten?
The records are simulated with known causes, on seeds on which no threshold was set:
{study} of the study, and {instruments} with a sensor or mounting that changes.
A finding is right if its set has a true cause: one that was added, or physics that
every module of the generator has. A cause outside the catalogue is right if one was
added.

The simulator has {kinds} kinds of causes outside the catalogue.
{open} are open, and {closed} are closed: nobody sees the findings for these
before the gate is measured.

{rules}
| gate | asked | measured | met |
|---|---|---|---|
"""

RULES = """\
*The rules* decided before the loop had a statistical model. Their results are of the
same records (`make oracle`).
"""

NO_RULES = """\
Without `make oracle` the page has no rows that compare with the rules by which the loop
decided before.
"""

APART = """
The next table divides the records by block of seeds and by generator of the module
temperature: nodes in W/m², pvlib's `fuentes`, or the fitted form itself with noise.
Records of instruments are made by nodes.

| records | count | wrong names | sets without the truth |
|---|---|---|---|
"""

CAUSES = """
The last table has each cause that findings or hints state with 0.50 or more at least
{fewest} times. What every module of the generator has, such as a cold sky, is there in
each record of nodes. An obstacle, or a sensor in another plane, is in few or none. A
share far below the stated one is a cause that other causes look like: check it on site.

| cause | stated | with a mean of | right |
|---|---|---|---|
"""

OUTRO = """
Causes stated at 0.50 to 0.95 can be right more often than stated. Two true causes can
look alike, such as natural convection and the shape of the loss by wind: each gets a
part of the probability of their set, and each is right. Every set has a cause outside
the catalogue, too, and most records have none. With half of `outside_probability` some
of them would be stated with 0.95 and more, and so be names; {doc}`sensitivity` counts a
wrong name among these.

Shares of few records are uncertain. {doc}`study` and {doc}`study_instruments` have
every coefficient. {doc}`study_measured` counts how often measured records give the same
findings with other test weeks.
"""


@dataclass(frozen=True)
class Found:
    """One finding, and which causes its record has."""

    effect: str
    verdict: str
    shares: dict
    known: set
    unknown: bool  # whether a cause outside the catalogue is there

    def true(self, name):
        """Whether a cause is there."""
        return self.unknown if name == OUTSIDE else name in self.known

    def several(self, name):
        """Whether more than one cause of a set with it is there."""
        return sum(map(self.true, held(self.shares) | {name})) > 1

    @property
    def wrong(self):
        """Whether it names what is not there."""
        return self.verdict == "identified" and self.effect not in self.known

    @property
    def right(self):
        """Whether its set holds a cause that is there."""
        return any(map(self.true, held(self.shares)))


def held(shares, sure=0.95):
    """The smallest set of causes that has a probability together."""
    found, total = set(), 0.0
    for name, share in sorted(shares.items(), key=lambda item: -item[1]):
        found.add(name)
        total += share
        if total >= sure:
            break
    return found


def judged(row):
    """Findings of a record of the study."""
    known = set(row["truths"])
    known |= {ALSO[name] for name in known & {*ALSO}}
    if row["generator"] != "fitted form":
        known |= IN_PHYSICS
    if row["generator"] == "fuentes":  # whose sky follows the air
        known |= {"sky_radiation"}
    unknown = any(switch in UNKNOWN for switch in row["sizes"])
    return [Found(**one, known=known, unknown=unknown) for one in row["sets"]]


def judged_change(row):
    """Findings of a record of instruments."""
    known = study_instruments.PRESENT | set(row["truths"])
    return [Found(**one, known=known, unknown=False) for one in row["sets"]]


def records_of(table, changes):
    """Every record that came to an end: its block, its generator, its findings."""
    for _, row in table.iterrows():
        if isinstance(row["sets"], list):
            yield f"shift {row['shift']}", row["generator"], judged(row)
    for row in changes:
        yield "instruments", "nodes", judged_change(row)


def gates(table, changes):
    """Words, requirement, measurement, and whether the requirement is met."""
    records = [found for *_, found in records_of(table, changes)]
    found = [one for some in records for one in some]
    wrong = sum(any(one.wrong for one in some) for some in records)
    yield at_most("records with a wrong name", wrong, len(records), 0.003)
    nulls = table[[not sizes for sizes in table["sizes"]]]
    yield at_most("wrong names in records with physics alone", *misnamed(nulls), 0.0)
    misled = sum(not one.right for one in found)
    yield at_most("sets without the truth", misled, len(found), 0.03)
    for words, family in (("open", "no catalogue"), ("closed", CLOSED_CAUSES)):
        some = misnamed(table[table["family"] == family])
        words = f"unknown causes ({words} kinds) that are given a name"
        yield at_most(words, *some, 0.02)
    large = [row for row in changes if row["clear"]]
    some = sum(row["found"] for row in large)
    words = "changes of instruments that are clear, and in a set"
    yield at_least(words, some, len(large), 0.95)
    dates = [row["dates"][0] for row in changes if row["dates"]]
    yield at_least("dates within their interval", sum(dates), len(dates), 0.95)
    yield from calibration(found)
    for name, rows in sorted(coverage(table, changes).items()):
        words = f"ranges of `{name}` that hold the truth"
        yield at_least(words, sum(rows), len(rows), 0.90)


def misnamed(table):
    """Records with a wrong name, and all that came to an end."""
    done = table["sets"].map(lambda sets: isinstance(sets, list)).astype(bool)
    return sum(len(names) > 0 for names in table["named_wrong"][done]), sum(done)


def calibration(found):
    """How often causes are there, by the probability with which they are stated."""
    for low, high in BINS:
        some = [
            (share, one.true(name), one.unknown, one.several(name))
            for one in found
            for name, share in one.shares.items()
            if low <= share < high
        ]
        if some:
            stated, true, unknown, several = np.transpose(some)
            mean, share = stated.mean(), true.mean()
            alone = several == 0
            size = (
                f"{share:.2f} of {len(some)} are right, stated {mean:.2f}; "
                f"{right_of(true[alone], stated[alone])} in sets with one true cause "
                f"at most; {int(unknown.sum())} are of records with an unknown cause"
            )
            words = f"causes stated at {low:.2f} to {min(high, 1.0):.2f}"
            yield words, "within 0.05", size, abs(share - mean) <= WITHIN


def right_of(true, stated):
    """How many are right of how many, and with what they are stated, in words."""
    if not len(true):
        return "none is"
    return f"{true.mean():.2f} of {len(true)}, stated {stated.mean():.2f}, are"


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


def apart(table, changes):
    """Wrong names, and sets without the truth, by block and by generator."""
    groups = defaultdict(list)
    for block, generator, found in records_of(table, changes):
        groups[block].append(found)
        groups[f"by {generator}"].append(found)
    for name in sorted(groups, key=lambda name: (name.startswith("by"), name)):
        some = groups[name]
        sets = [one for found in some for one in found]
        wrong = sum(any(one.wrong for one in found) for found in some)
        misled = sum(not one.right for one in sets)
        yield name, len(some), share(wrong, len(some)), share(misled, len(sets))


def by_cause(table, changes):
    """How often each cause that is more probable than not is there."""
    stated = defaultdict(list)
    for *_, found in records_of(table, changes):
        for one in found:
            for name, probability in one.shares.items():
                if probability >= BINS[0][0]:
                    stated[name].append((probability, one.true(name)))
    for name in sorted(stated):
        if len(stated[name]) >= FEWEST:
            mean, right = np.mean(stated[name], axis=0)
            words = OUTSIDE_WORDS if name == OUTSIDE else f"`{name}`"
            yield words, len(stated[name]), f"{mean:.2f}", f"{right:.2f}"


KEY = ["family", "seed", "truth", "copy"]


def paired(table, rules):
    """The records of both that came to an end by the rules, side by side."""
    sides = []
    for one in (table, rules):
        # those of the exact null have one seed, and no truth, several times
        copy = one.groupby(KEY[:-1]).cumcount()
        sides.append(one.assign(copy=copy)[[*KEY, "first_ok", "after", "seconds"]])
    both = sides[0].merge(sides[1], on=KEY, suffixes=("", "_rules"))
    return both[both["after_rules"].notna()]


def against(table, changes, rules, rules_changes):
    """The gates against the results of the rules on the same records."""
    both = paired(table, rules)
    right = both[both["first_ok_rules"].eq(True)]  # NaN where a loop broke
    some = int(right["first_ok"].eq(True).sum())
    words = "first findings that the rules had right, and are right"
    yield at_least(words, some, len(right), 0.95)
    known = {row["seed"]: row for row in changes}
    pairs = [(known[r["seed"]], r) for r in rules_changes if r["seed"] in known]
    some = [new["found"] for new, old in pairs if old["found"]]
    words = "changes of instruments that the rules found, and are found"
    yield at_least(words, sum(some), len(some), 0.95)
    finished = both[both["after"].notna()]
    words = "median error on test weeks of the study"
    yield no_more(words, finished["after"], finished["after_rules"])
    words = "median error on test weeks of instruments"
    yield no_more(words, *([pair[i]["after"] for pair in pairs] for i in (0, 1)))


def share(some, count):
    return f"{some} of {count} ({some / max(count, 1):.1%})"


def at_most(words, some, count, most):
    met = some <= most * count
    return words, f"at most {most:.1%}", share(some, count), met


def at_least(words, some, count, least):
    met = some >= least * count
    return words, f"at least {least:.0%}", share(some, count), met


def no_more(words, ours, rules):
    ours, rules = np.median(ours), np.median(rules)
    measured = f"{ours:.3f} K, by the rules {rules:.3f} K"
    asked = f"at most {HARDLY} K above the rules"
    return words, asked, measured, ours <= rules + HARDLY


def page(table, changes, oracle=None):
    """The page, as Markdown."""
    rows = [*gates(table, changes)]
    if oracle is not None:
        rows += against(table, changes, *oracle)
    yield INTRO.format(
        study=len(table),
        instruments=len(changes),
        kinds=len(UNKNOWN),
        open=len(UNDECLARED),
        closed=len(CLOSED),
        rules=RULES if oracle else NO_RULES,
    ).rstrip("\n")
    for words, asked, measured, met in rows:
        yield f"| {words} | {asked} | {measured} | {'yes' if met else '**no**'} |"
    yield APART.rstrip("\n")
    for row in apart(table, changes):
        yield f"| {' | '.join(map(str, row))} |"
    yield CAUSES.format(fewest=FEWEST).rstrip("\n")
    for row in by_cause(table, changes):
        yield f"| {' | '.join(map(str, row))} |"
    yield OUTRO.rstrip("\n")


def loaded(study, instruments):
    """Rows of the study as a table, and those of instruments one by one."""
    rows = pd.read_pickle(instruments).to_dict("records")
    return pd.read_pickle(study), rows


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("study", type=Path, help="rows of the study, pickled")
    parser.add_argument("instruments", type=Path, help="rows of instruments, pickled")
    rules = "the same of the rules, pickled"
    parser.add_argument("--oracle", type=Path, nargs=2, help=rules)
    parser.add_argument("--out", type=Path, help="Markdown; standard output if none")
    options = parser.parse_args()
    oracle = loaded(*options.oracle) if options.oracle else None
    some = loaded(options.study, options.instruments)
    text = "\n".join(page(*some, oracle=oracle))
    publish(text, options.out, "make gate")


if __name__ == "__main__":
    main()
