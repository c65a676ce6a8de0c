"""
How much of two measured records could still be explained by their own columns.

Run as
``python studies/study_ceiling.py [--out docs/ceiling.md]``. The records are read,
and every fifth week is left out, as in ``study_measured.py``.
"""

import argparse
from pathlib import Path

import pandas as pd
from pvlib.location import Location
from study_page import LIBRARIES, publish

import pvlib_fem as fem
from pvlib_fem._parallel import spread

YEARS = ("eurac_bolzano", "nrel_stf")
EVERY = 5  # weeks, of which one is a test week

INTRO = """\
# How much could still be explained

The records are those of {doc}`guide/public_records`, each with its location and
nothing else. All errors are RMSE [K] on every fifth week, which no fit, decision or
tree used.

The trees are boosted trees on the same columns, with past values, hour and season, the
sun's position and the date; {py:meth}`loop.ceiling <pvlib_fem.Loop.ceiling>`
describes their training. The *share closed* refers to the squared error that the trees
explain.

*Causes* are the loop's findings; *the loop* also has its unexplained patterns, which
repeat from week to week and have no known cause.

| record | paper's form | causes | the loop | trees | rows | share closed | by causes |
|---|---|---|---|---|---|---|---|
"""
WITHOUT = """
## What the trees follow

Without one group of columns the trees have a larger error. The group with the largest
increase may have the cause of the rest. This is no proof: groups share information, and
the date represents all that lasts for weeks.

| record | {groups} |
|---|{rules}|
"""


def measured(name):
    """The ceiling of one record, and the errors with other test weeks."""
    data = fem.datasets.load(name)
    site = [data.attrs[part] for part in ("latitude", "longitude", "tz")]
    where = Location(*site)
    week = (data.index - data.index[0]).days // 7
    rows = []
    for first in range(EVERY):
        test = pd.Series(week % EVERY == first, data.index)
        loop = fem.close_loop(data, location=where, holdout=test)
        errors = loop.table["rmse_test"]
        rows.append((errors["fem"], errors[loop.last], errors.iloc[-1]))
    return fem.close_loop(data, location=where).ceiling(), rows


OTHERS = """
## With other test weeks

Here weeks of seven days count from the first row of a record, and every fifth is a test
week: the first, the second and so on. Errors are of the paper's form, of the causes and
of the loop.

| record | from week | paper's form | causes | the loop |
|---|---|---|---|---|
"""


def page(found, others):
    """All tables, as Markdown."""
    yield INTRO.rstrip()
    for name, one in found.items():
        errors = one.paper, one.causes, one.loop, one.trees
        cells = " | ".join(f"{error:.2f}" for error in errors)
        shares = " | ".join(
            f"{100 * one.share(error):.0f} %" for error in (one.loop, one.causes)
        )
        yield f"| `{name}` | {cells} | {one.rows:,} | {shares} |"
    groups = list(
        dict.fromkeys(group for one in found.values() for group in one.without)
    )
    head = dict(groups=" | ".join(groups), rules="|".join(["---"] * len(groups)))
    yield WITHOUT.format(**head).rstrip()
    for name, one in found.items():
        cells = [without(one, group) for group in groups]
        yield f"| `{name}` | {' | '.join(cells)} |"
    yield OTHERS.rstrip()
    for name, rows in others.items():
        for first, errors in enumerate(rows):
            cells = " | ".join(f"{error:.2f}" for error in errors)
            yield f"| `{name}` | {first + 1} | {cells} |"
    yield ""


def without(ceiling, group):
    """The error of trees without a group, in bold where it is the largest."""
    if group not in ceiling.without:
        return "–"
    words = f"{ceiling.without[group]:.2f}"
    return f"**{words}**" if group == ceiling.most else words


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="Markdown; standard output if none")
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    tasks = [(name,) for name in YEARS]
    both = list(spread(measured, tasks, options.processes))
    found = dict(zip(YEARS, (ceiling for ceiling, _ in both)))
    others = dict(zip(YEARS, (rows for _, rows in both)))
    for one in found.values():
        print(one)
    text = "\n".join(page(found, others))
    libraries = (*LIBRARIES, "scikit-learn")
    publish(text, options.out, "make ceiling", libraries)


if __name__ == "__main__":
    main()
