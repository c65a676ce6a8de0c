"""How often the ranges of coefficients hold the truth, and how wide they are."""

import pandas as pd

SURE = 1.96  # standard errors: half of the interval that a ± claims
COVER = 0.9  # of the coefficients
WIDE = 3.0  # times the half-width that would hold as many
FEW = 4  # records of a coefficient, below which it has no row of its own


def coefficients(table):
    """A row for each coefficient that has a range and a truth."""
    rows = []
    for _, record in table.iterrows():
        known = record["told"] if isinstance(record["told"], dict) else {}
        for one in known.values():
            if one.get("range"):
                low, high = one["range"]
                truth, size = one["truth"], abs(one["truth"])
                off = abs(one["value"] - truth)
                rows.append(
                    {
                        "name": one["name"],
                        "off": off / size,
                        "half": (high - low) / 2.0 / size,
                        "held": low <= truth <= high,
                        "error": SURE * one["stderr"] / size,
                        "within": off <= SURE * one["stderr"],
                    }
                )
    return pd.DataFrame(rows)


def would_do(part):
    """Half-width that would hold as many as the bar asks for, of the truth."""
    return part["off"].quantile(COVER)


def times(part):
    """How many times as wide as that the ranges are, in the median."""
    return part["half"].median() / would_do(part)


def in_words(part):
    """Cells of a table: cover, width and what would do."""
    return (
        f"{len(part)} | {part['held'].mean():.0%} | {part['half'].median():.0%} | "
        f"{would_do(part):.0%} | {times(part):.1f} | {part['within'].mean():.0%} | "
        f"{part['error'].median():.0%}"
    )


def section(table):
    """Lines of the page."""
    found = coefficients(table)
    if not len(found):
        return
    yield "## Ranges of coefficients"
    yield ""
    yield (
        "The coefficients have a known truth. *Held*: how often the range holds it "
        f"(required: {COVER:.0%}). *Half-width*: half of the range, relative to the "
        f"truth, in the median. *Would do*: the half-width that would hold "
        f"{COVER:.0%} of the truths. *Times*: the half-width divided by that "
        f"(at most {WIDE:g}). The last two columns are *held* and *half-width* of ± "
        f"{SURE:g} standard errors."
    )
    yield ""
    head = ("records", "held", "half-width", "would do", "times", "± held", "± is")
    yield f"| coefficient | {' | '.join(head)} |"
    yield "|---" * (len(head) + 1) + "|"
    yield f"| all | {in_words(found)} |"
    for name, part in found.groupby("name"):
        if len(part) >= FEW:
            yield f"| `{name}` | {in_words(part)} |"
    yield ""
    held, wide = found["held"].mean() >= COVER, times(found) <= WIDE
    yield f"The bar of cover is {met(held)}, that of width {met(wide)}."
    yield ""


def met(bar):
    return "met" if bar else "**missed**"
