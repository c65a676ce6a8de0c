"""The printout of a recovery."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._recovery.trial import CLEARLY, false_names

#: titles of scrambled records, by kind
KINDS = {"drivers": "drivers moved in time", "dates": "dates scrambled"}
HEAD = (
    "effect",
    "put in",
    "predicted",
    "half found at",
    f"found from {CLEARLY:g} ×",
    "first",
    "coefficient",
    "less own",
    "covered",
    "in range",
)


def lines(recovery: Any) -> Iterator:
    """
    Yield the lines of the printout.

    Parameters
    ----------
    recovery : Recovery
        Also an interrupted one.

    Yields
    ------
    str
        Without a line end.
    """
    done, planned = len(recovery.outcomes), recovery.planned
    head = f"{done} injections" + (f" of {planned} planned" if done < planned else "")
    added = [" | ".join(f.candidates) for f in recovery.baseline if f.added]
    yield f"{head}; the record itself shows {'; '.join(added) or 'nothing'}"
    yield ""
    if done:
        table = recovery.table
        yield from by_effect(recovery, table)
        yield ""
        yield from in_all(table)
    if recovery.trials:
        yield from in_scrambled(recovery)
        yield ""
    for kind, why in recovery.not_scrambled.items():
        yield f"no records with {KINDS[kind]}: {why}"
    yield from (f"not put in: {name}: {why}" for name, why in recovery.notes.items())


def by_effect(recovery: Any, table: pd.DataFrame) -> Iterator:
    """Yield a row for each effect."""
    half, rows = recovery.half, [HEAD]
    for name, part in table.groupby("effect", sort=False):
        clear = part[part["multiple"] >= CLEARLY - 1e-9]
        sized = part[part["ratio"].notna()]
        units = {*recovery.units.get(name, {}).values()}
        unit = units.pop() if len(units) == 1 else ""
        row = (
            str(name),
            str(len(part)),
            share_text(part["predicted"].median(), f"{{:.3g}} {unit}").strip(" -"),
            half_found(half.loc[name]) if name in half.index else "–",
            count_text(clear["found"]),
            count_text(clear["first"]),
            share_text(sized["ratio"].median(), "{:.2f}"),
            share_text(
                (sized["ratio"] - sized["own"] / sized["size"]).median(), "{:.2f}"
            ),
            share_text(100.0 * part["covered"].mean(), "{:.0f} %"),
            share_text(100.0 * part["in_range"].mean(), "{:.0f} %"),
        )
        rows.append(row)
    yield from aligned_rows(rows)


def in_scrambled(recovery: Any) -> Iterator:
    """Yield lines on false names in scrambled records, and on reliability."""
    trials, rates = recovery.trials, recovery.reliability
    if len(trials) < recovery.planned_trials:
        yield f"{len(trials)} scrambled records of {recovery.planned_trials} planned"
    for kind, title in KINDS.items():
        mine = [t for t in trials if t.kind == kind and not t.refused]
        names = [name for trial in mine for name in trial.identified]
        words = f" ({', '.join(sorted({*names}))})" if names else ""
        sets = sum(len(trial.ambiguous) for trial in mine)
        if mine:
            false = f"{len(names)} false names{words}, {sets} false sets of causes"
            yield f"in {len(mine)} records with {title}: {false}"
    if refused := [trial.refused for trial in trials if trial.refused]:
        yield f"refused by the loop: {len(refused)}, first: {refused[0]}"
    mean, (low, high) = false_names(trials)
    there = int((rates["identified"] & (rates["trials"] > 0)).sum())
    yield f"false names expected in a record: {mean:.2f} ({low:.2f} to {high:.2f})"
    if there:
        parts = (max(0.0, 100.0 * (1.0 - n / there)) for n in (mean, high, low))
        share = "{:.0f} % ({:.0f} % to {:.0f} %)".format(*parts)
        yield f"of this record's names, {there} that could be false: {share} are true"
    yield ""
    rows = [("effect", "completeness", "reliability", "identified in the record")]
    for name, row in rates.iterrows():
        complete = (row["found"], row["injections"], row["complete_from"])
        right = (row["trials"] - row["false"], row["trials"], row["reliable_from"])
        rows.append(
            (
                str(name),
                share_with_interval(*complete, row["complete_to"]),
                share_with_interval(*right, row["reliable_to"]),
                "yes" if row["identified"] else "no",
            )
        )
    yield from aligned_rows(rows)


def share_with_interval(count: Any, total: str, low: Any, high: Any) -> Any:
    """A share with its interval."""
    share = f"({100.0 * low:.0f} % to {100.0 * high:.0f} %)"
    return f"{count} of {total} {share}" if total else "–"


def aligned_rows(rows: list) -> Iterator:
    """Rows of a table, each column as wide as its widest cell."""
    wide = [max(map(len, column)) for column in zip(*rows)]
    for row in rows:
        yield "  ".join(cell.ljust(size) for cell, size in zip(row, wide)).rstrip()


def in_all(table: pd.DataFrame) -> Iterator:
    """Yield lines on all injections together."""
    clear = table[table["multiple"] >= CLEARLY - 1e-9]
    wrong = sorted({name for names in table["wrong"] for name in names})
    words = f" ({', '.join(wrong)})" if wrong else ""
    hits = count_text(clear["found"])
    yield f"found from {CLEARLY:g} × the predicted size on: {hits}"
    yield f"with a wrong name: {count_text(table['wrong'].map(bool))}{words}"
    misled = count_text(table["misled"].map(bool))
    yield f"with an ambiguous finding without the true cause: {misled}"
    if refused := [why for why in table["refused"] if why]:
        yield f"refused by the loop: {len(refused)}, first: {refused[0]}"


def half_found(row: pd.Series) -> str:
    """The size at which half are found, with its interval."""
    return f"{row['multiple']:.2f} × ({row['lower']:.2f} to {row['upper']:.2f})"


def count_text(flags: pd.Series) -> str:
    return f"{int(flags.sum())} of {len(flags)}"


def share_text(value: float, form: str) -> str:
    return form.format(value) if np.isfinite(value) else "–"
