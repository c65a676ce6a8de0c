"""How a recovery prints."""

import numpy as np

CLEARLY = 1.5  # times the predicted size, from which nearly all should be found
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


def lines(recovery):
    """The printout, line by line."""
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
    yield from (f"not put in: {name}: {why}" for name, why in recovery.notes.items())


def by_effect(recovery, table):
    """A row for each effect."""
    half, rows = recovery.half, [HEAD]
    for name, part in table.groupby("effect", sort=False):
        clear = part[part["multiple"] >= CLEARLY - 1e-9]
        told = part[part["ratio"].notna()]
        units = {*recovery.units.get(name, {}).values()}
        unit = units.pop() if len(units) == 1 else ""
        row = (
            str(name),
            str(len(part)),
            f"{part['predicted'].median():.3g} {unit}".strip(" -"),
            middle(half.loc[name]) if name in half.index else "–",
            counted(clear["found"]),
            counted(clear["first"]),
            share(told["ratio"].median(), "{:.2f}"),
            share((told["ratio"] - told["own"] / told["size"]).median(), "{:.2f}"),
            share(part["covered"].mean(), "{:.0%}"),
            share(part["in_range"].mean(), "{:.0%}"),
        )
        rows.append(row)
    wide = [max(map(len, column)) for column in zip(*rows)]
    for row in rows:
        yield "  ".join(cell.ljust(size) for cell, size in zip(row, wide)).rstrip()


def in_all(table):
    """What all injections together say."""
    clear = table[table["multiple"] >= CLEARLY - 1e-9]
    wrong = sorted({name for names in table["wrong"] for name in names})
    words = f" ({', '.join(wrong)})" if wrong else ""
    found = counted(clear["found"])
    yield f"found from {CLEARLY:g} × the predicted size on: {found}"
    yield f"with a wrong name: {counted(table['wrong'].map(bool))}{words}"
    yield f"with a class without the truth: {counted(table['misled'].map(bool))}"
    if refused := [why for why in table["refused"] if why]:
        yield f"refused by the loop: {len(refused)}, first: {refused[0]}"


def middle(row):
    """The size of which half are found, with its interval."""
    return f"{row['multiple']:.2f} × ({row['lower']:.2f} to {row['upper']:.2f})"


def counted(flags):
    return f"{int(flags.sum())} of {len(flags)}"


def share(value, form):
    return form.format(value) if np.isfinite(value) else "–"
