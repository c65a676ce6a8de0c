"""
How much is found at the measured plants, and how often a name is false.

Run as
``python studies/study_reliability.py [--trials 20] [--out FILE]``. The two
measured records of years are scrambled, and every effect that has its columns is put
into them at a drawn date. What is done is kept in ``--folder``, from where a run goes
on that was interrupted. ``--sizes`` without a number puts nothing in.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import pandas as pd
from pvlib.location import Location
from study_page import publish

import pvlib_fem as fem
from pvlib_fem._recovery.recovery_text import KINDS, lines, share_with_interval
from pvlib_fem._recovery.trial import CLEARLY, false_names, share_between

YEARS = ("eurac_bolzano", "nrel_stf")
SIZES = (1.5,)  # times the predicted one

INTRO = """\
# Completeness and reliability at two measured plants

The records are those of
{{doc}}`guide/public_records`, each with its location. {{doc}}`guide/recovery` says what
both numbers are. Completeness is of effects put in at {clearly:g} times the size from
which each should be found, each sensor fault with each time profile, at a drawn date.
Reliability is of {trials} scrambled records of each kind. Intervals hold 90 %.

| record | found | false names | false sets of causes | records |
|---|---|---|---|---|
"""


def run(trials, sizes, processes, folder):
    """What is identified in scrambled records, and found in each record as it is."""
    folder.mkdir(parents=True, exist_ok=True)
    found = {}
    for name in YEARS:
        how = dict(sizes=(), reliability=True, trials=trials)
        found[name] = recovered(name, processes, folder / f"scrambled_{name}.json", how)
    for name in YEARS if sizes else ():
        path = folder / f"put_into_{name}.json"
        put_in = recovered(name, processes, path, dict(sizes=sizes, draws=1))
        parts = ("trials", "planned_trials", "not_scrambled")
        known = {part: getattr(found[name], part) for part in parts}
        found[name] = replace(put_in, **known)
    return found


def recovered(name, processes, path, how):
    """One record, with what the file has of it already."""
    data = fem.datasets.load(name)
    site = [data.attrs[part] for part in ("latitude", "longitude", "tz")]
    how = how | dict(location=Location(*site), processes=processes, path=path)
    return fem.recover_effects(data, **how)


def page(found, trials):
    """The page, as Markdown."""
    how = dict(clearly=CLEARLY, trials=trials)
    yield INTRO.format(**how).rstrip()
    for name, one in found.items():
        clear = one.table["found"][one.table["multiple"] >= CLEARLY - 1e-9]
        count, of = int(clear.sum()), len(clear)
        done = [trial for trial in one.trials if not trial.refused]
        names, sets = (
            sum(len(getattr(trial, part)) for trial in done)
            for part in ("identified", "ambiguous")
        )
        share = share_with_interval(count, of, *share_between(count, of))
        kinds = ", ".join(
            f"{sum(trial.kind == kind for trial in done)} with {words}"
            for kind, words in KINDS.items()
            if any(trial.kind == kind for trial in done)
        )
        yield f"| `{name}` | {share} | {names} | {sets} | {kinds} |"
    yield ""
    for name, one in found.items():
        mean, (low, high) = false_names(one.trials)
        yield (
            f"Expected in a record like `{name}`: {mean:.2f} false names "
            f"({low:.2f} to {high:.2f}).\n"
        )
    for name, one in found.items():
        yield f"## {name}\n"
        yield "```text"
        yield from lines(one)
        yield "```\n"
        yield from false(one)


def false(recovery):
    """What was false, the most frequent first."""
    trials = recovery.trials
    all_false = [n for one in trials for n in (*one.identified, *one.ambiguous)]
    if not all_false:
        return
    yield "| false name, or set of causes | times |"
    yield "|---|---|"
    for words, times in pd.Series(all_false).value_counts().items():
        yield f"| {' / '.join(words.split(' | '))} | {times} |"
    yield ""


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=20)
    parser.add_argument("--sizes", type=float, nargs="*", default=SIZES)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--folder", type=Path, default=Path("docs/_build"))
    parser.add_argument("--out", type=Path, help="Markdown; standard output if none")
    options = parser.parse_args()
    how = (tuple(options.sizes), options.processes, options.folder)
    found = run(options.trials, *how)
    text = "\n".join(page(found, options.trials))
    publish(text, options.out, "make reliability")


if __name__ == "__main__":
    main()
