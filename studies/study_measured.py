"""
Whether the loop says the same of measured records when their weeks are drawn anew.

Run as
``python studies/study_measured.py [--draws 10] [--out docs/study_measured.md]``.
Each draw takes a fifth of a record's weeks, by chance, as test weeks.
"""

import argparse
import sys
import time
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
import pandas as pd
from pvlib.location import Location
from study_page import publish

from pvlib_fem import Criteria, close_loop, datasets
from pvlib_fem._findings import Verdict
from pvlib_fem._parallel import spread
from pvlib_fem.effects._time_profiles import dates_in_words

YEARS = ("eurac_bolzano", "nrel_stf")
SHORT = ("sandia_week", "sandia_day")
BAR = 0.9  # of the draws that say the same
#: what the columns say without a model
KNOWN = {
    "nrel_stf": """\
From 14 April to 20 May 2013 the plant fed next to no power (`power_ac`), which heats
modules. The outages of `loop.events` have those days. In eight years they are too
little of the error for `outage` to be in the model. That `modules_covered` is named in
one draw and ambiguous in another is one probability, of about 95 %.
"""
}
SURE = 1.96  # standard errors: of a coefficient's own interval of 95 %


@dataclass(frozen=True)
class Summary:
    """What a loop said of one division of a record."""

    draw: str
    findings: tuple  # (effect, verdict, candidates, date, between)
    sizes: dict  # (effect, coefficient) to value, error and range
    cross_checks: tuple  # as they print
    errors: dict  # on the test weeks [K]
    seconds: float

    @property
    def names(self):
        """What would have to be the same: each name, and each set of causes whole."""
        return {(verdict, candidates) for _, verdict, candidates, _, _ in self.findings}

    @property
    def first(self):
        """Verdict and candidates of the first finding in the model."""
        return [finding[1:3] for finding in self.findings[:1]]


def drawn(index, seed):
    """Test rows: a fifth of the weeks, by chance."""
    weeks = index.to_period("W")
    each = weeks.unique()
    random = np.random.default_rng(seed)
    some = random.choice(len(each), round(len(each) / Criteria().test_every), False)
    return pd.Series(weeks.isin(each[some]), index)


def summary_of(name, seed=None):
    """The loop on a record, of which the weeks are drawn with that seed."""
    data = datasets.load(name)
    place = {}
    if "latitude" in data.attrs:
        site = [data.attrs[part] for part in ("latitude", "longitude", "tz")]
        place["location"] = Location(*site)
    begin = time.perf_counter()
    holdout = None if seed is None else drawn(data.index, seed)
    loop = close_loop(data, holdout=holdout, **place)
    settings = {effect.name: effect.settings for effect in loop.fit.effects}
    found, sizes, cross_checks = [], {}, []
    for one in (f for f in loop.finding_objects if f.added):
        its = settings[one.effect]
        at, between = its.get("at", ""), its.get("between") or ()
        if "start" in its:
            at, between = dates_in_words({**its, "between": None}), ()
        candidates = frozenset(one.candidates)
        found.append((one.effect, str(one.verdict), candidates, at, tuple(between)))
        cross_checks += map(str, one.cross_checks)
        for part, value in one.coefficients.items():
            ends = one.ranges.get(part, (np.nan, np.nan))
            sizes[one.effect, part.split(".")[-1]] = value, one.stderr[part], ends
    errors = loop.table["rmse_test"]
    errors = {step: float(errors[step]) for step in ("steady", "fem", loop.last)}
    words = "every fifth" if seed is None else str(seed)
    seconds = time.perf_counter() - begin
    return Summary(words, tuple(found), sizes, tuple(cross_checks), errors, seconds)


def run(draws, processes):
    """For each record the usual division, then the drawn ones; the short ones once."""
    seeds = [None, *range(1, draws + 1)]
    tasks = [(name, seed) for name in YEARS for seed in seeds]
    tasks += [(name,) for name in SHORT]
    found = {}
    for (name, *_), one in zip(tasks, spread(summary_of, tasks, processes)):
        found.setdefault(name, []).append(one)
        print(f"{name}: {one.draw}", file=sys.stderr)
    return found


INTRO = """\
# What the loop says of measured records, drawn ten times

The records are those of {doc}`guide/public_records`, each with its location and its
zone and nothing else. No log of either plant is published, so this page cannot show
whether a finding is *right*. It shows whether the same record gives the same findings
again with other test weeks.

The loop divides a record by the calendar, with every fifth week for the test. Each draw
replaces them by a random fifth of the weeks (`holdout=`). Findings are *the same* if
the model has the same findings, each with the same verdict and candidates. The
requirement is nine of ten draws.
"""


def page(found):
    """All tables, as Markdown."""
    yield INTRO
    for name in YEARS:
        yield from record_page(name, *found[name])
    yield "## A week and a day\n"
    for name in SHORT:
        (one,) = found[name]
        said = ", ".join(effect for effect, *_ in one.findings) or "nothing"
        yield f"* `{name}`: {said} is named or added to the model."
    yield ""


def record_page(name, usual, *draws):
    """The tables of one record."""
    yield f"## {name}\n"
    yield "| draw | in the model | date | K, paper's form | K, after |"
    yield "|---|---|---|---|---|"
    for one in (usual, *draws):
        steps = [*one.errors.values()]
        words = "; ".join(map(spelled, one.findings))
        dates = "; ".join(dated(f) for f in one.findings if f[3])
        yield f"| {one.draw} | {words} | {dates} | {steps[1]:.2f} | {steps[2]:.2f} |"
    same = sum(one.names == usual.names for one in draws)
    met = "met" if same >= BAR * len(draws) else "**missed**"
    first = sum(one.first == usual.first for one in draws)
    yield (
        f"\nThe findings are the same as with every fifth week in {same} of "
        f"{len(draws)} draws: the requirement is {met}.\nThe first finding is the "
        f"same in {first}.\n"
    )
    if name in KNOWN:
        yield KNOWN[name]
    yield from by_finding(usual, draws)
    yield from by_date(usual, draws)
    yield from by_coefficient(usual, draws)
    falls = [[*one.errors.values()] for one in draws]
    before, after = np.array(falls).T[1:]
    yield (
        f"RMSE on test weeks falls by {np.min(before - after):.2f} to "
        f"{np.max(before - after):.2f} K from the paper's form, "
        f"from {before.mean():.2f} to {after.mean():.2f} K in the mean over draws. "
        f"A loop took {np.median([one.seconds for one in draws]):.0f} s (median).\n"
    )
    if usual.cross_checks:
        yield "Cross-checks, with every fifth week for the test:\n"
        yield from (f"* {words}" for words in usual.cross_checks)
        yield ""


def same_in(draws, finding):
    """
    What draws say of a finding: the same name, or the same candidates.

    Of candidates that are as probable, any may be the first.
    """
    effect, _, candidates, *_ = finding
    for one in draws:
        alike = (f for f in one.findings if f[0] == effect or f[2] == candidates)
        yield from islice(alike, 1)


def by_finding(usual, draws):
    """How often each finding comes back, with which verdict and candidates."""
    yield "| finding | in the model | same verdict | same candidates | always in it |"
    yield "|---|---|---|---|---|"
    every = [*usual.findings]
    for finding in (f for one in draws for f in one.findings):
        if not any(f[0] == finding[0] or f[2] == finding[2] for f in every):
            every.append(finding)
    for finding in sorted(every, key=lambda f: f[0]):
        theirs = [*same_in(draws, finding)]
        verdict = candidates = "–"
        if finding in usual.findings:
            verdict = sum(f[1] == finding[1] for f in theirs)
            candidates = sum(f[2] == finding[2] for f in theirs)
        common = frozenset.intersection(*(f[2] for f in theirs)) if theirs else ()
        words = ", ".join(f"`{one}`" for one in sorted(common))
        yield f"| `{finding[0]}` | {len(theirs)} | {verdict} | {candidates} | {words} |"
    yield ""


def by_date(usual, draws):
    """Whether the dates of steps are within each other's intervals."""
    for finding in (f for f in usual.findings if f[4]):
        effect, *_, date_, between = finding
        theirs = [*same_in(draws, finding)]
        dates = sorted(f[3] for f in theirs)
        held = sum(f[4][0] <= date_ <= f[4][1] for f in theirs)
        yield (
            f"The date of `{effect}` is from {dates[0]} to {dates[-1]}; the intervals "
            f"of {held} of {len(theirs)}\ndraws hold {date_}, that of every fifth "
            f"week, which has {between[0]} to {between[1]}.\n"
        )


def by_coefficient(usual, draws):
    """Whether coefficients stay within their reported ranges."""
    head = ("coefficient", "every fifth", "range", "draws", "in it", "± holds")
    yield f"| {' | '.join(head)} |"
    yield "|---" * len(head) + "|"
    for (effect, part), (value, error, (low, high)) in usual.sizes.items():
        theirs = [
            one.sizes[effect, part] for one in draws if (effect, part) in one.sizes
        ]
        if not theirs:
            continue
        values = np.array([size for size, *_ in theirs])
        off = np.abs(values - value) / np.array([wide for _, wide, _ in theirs])
        within = ((values >= low) & (values <= high)).sum()
        yield (
            f"| `{effect}.{part}` | {value:.4f} ± {error:.4f} | {low:.4f} – {high:.4f} "
            f"| {values.min():.4f} – {values.max():.4f} | {within} of {len(off)} | "
            f"{(off < SURE).sum()} of {len(off)} |"
        )
    yield (
        "\n*In it*: draws whose coefficient is in the range of every fifth week. "
        "*± holds*: draws whose own\ninterval of 95 % by the error alone holds the "
        "value of every fifth week. Draws share most of their\nweeks, so that this "
        "asks less than a second record would.\n"
    )


def spelled(finding):
    """A finding as a cell: its verdict, and its candidates, the taken one first."""
    effect, verdict, candidates, *_ = finding
    others = sorted(candidates - {effect})
    if verdict == Verdict.AMBIGUOUS and len(others) > 4:
        others = [f"{len(others)} others"]
    return f"{verdict} {' / '.join([f'`{effect}`', *others])}"


def dated(finding):
    *_, at, between = finding
    return at + (f" ({between[0]} to {between[1]})" if between else "")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=10)
    parser.add_argument("--out", type=Path, help="Markdown; standard output if none")
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    found = run(options.draws, options.processes)
    text = "\n".join(page(found))
    publish(text, options.out, "make study-measured")


if __name__ == "__main__":
    main()
