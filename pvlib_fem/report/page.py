"""A closed loop as one page that opens anywhere: a mail, a phone, in the dark."""

import hashlib
from dataclasses import fields, is_dataclass

import numpy as np
import pandas as pd

from pvlib_fem.effects import EFFECTS
from pvlib_fem.findings import Verdict
from pvlib_fem.reasons import Reason
from pvlib_fem.report import advice
from pvlib_fem.report.document import (
    document,
    escaped,
    figures,
    listed,
    number,
    paragraph,
    rounded,
    section,
    table,
)
from pvlib_fem.report.pictures import pictures

NOT_SHOWN = "this record shows no less"
WITHOUT_CAUSE = "nothing in the catalogue; a column that follows it would settle it"
STEPS = {"steady": "no memory", "fem": "the paper's form", "balance": "heat balance"}
VERDICTS = {
    "named": "no other candidate explains it",
    "class": "one of several that this record cannot tell apart",
    "suggestive": "a hint, not added to the model",
    "unknown": "no effect of the catalogue follows it",
}


def page(loop, never=()):
    """
    The report of a closed loop as one HTML file.

    It has no script, no address of anything outside and no time of its making: the
    same loop gives the same text. All that may come from a user's file is escaped.

    Parameters
    ----------
    loop : Loop
    never : sequence of str
        What no record of these columns can tell.

    Returns
    -------
    str
    """
    parts = [
        verdict(loop),
        section("Errors by step", errors(loop)),
        section("Pictures", shown(loop)),
        section("Coefficients", coefficients(loop)),
        section("What the record cannot tell", undecided(loop)),
        section("What is left unexplained", unexplained(loop)),
        section("Which rules decided", rules(loop)),
        section("What to measure next", next_measurements(loop)),
        section("Not testable", untestable(loop, never)),
        section("The state of the data", health(loop)),
        section("How to reproduce it", reproduce(loop)),
    ]
    return document(f"pvlib_fem: {headline(loop)}", parts)


def shown(loop):
    """The pictures, of which only the rows of the record tell."""
    if loop.fit.record is None:
        return paragraph("A loop that was read from a file has no rows to draw.")
    return figures(pictures(loop))


def added(loop):
    return [finding for finding in loop.findings if finding.added]


def part(loop):
    """The days that the errors of the verdict are of, and their column's ending."""
    return ("test", "test") if loop.fit.test_days else ("fitted", "train")


def short(loop):
    """Whether there were too few days to leave any out."""
    return not loop.weighed


def headline(loop):
    error = loop.table[f"rmse_{part(loop)[1]}"]
    before, after = error[loop.base], error[loop.last]
    if loop.last == loop.base:
        return f"{before:.2f} K, no effect {'weighed' if short(loop) else 'added'}"
    return f"{before:.2f} K before, {after:.2f} K after"


def verdict(loop):
    """What was found, first of all and in plain words."""
    fit, record = loop.fit, loop.fit.summary
    days = record.days
    count = f"{fit.test_days} test days, which no fit and no decision has seen"
    body = [
        f"<h1>Module temperature: {escaped(headline(loop))}</h1>",
        paragraph(
            f"Error (RMSE) on {count if fit.test_days else 'the fitted days'}. "
            f"{days} day{'s' * (days > 1)} from {record.start:%Y-%m-%d} to "
            f"{record.end:%Y-%m-%d}, {record.rows:,} rows; model {fit.model}, dynamics "
            f"{fit.dynamics}.",
            "soft",
        ),
    ]
    if found := added(loop):
        some = "One effect" if len(found) == 1 else f"{len(found)} effects"
        body.append(paragraph(f"{some} that the model lacks, in the order found:"))
        body.append(listed((said(f), gained(f)) for f in found))
    elif short(loop):
        body.append(paragraph("The record is too short to weigh any effect."))
    else:
        body.append(
            paragraph(
                f"Nothing in the record asks for a further effect: none that was "
                f"weighed gains "
                f"{loop.criteria.min_gain:.2f} K on days left out, beyond chance and "
                "within what is possible."
            )
        )
    if hints := [f for f in loop.findings if f.verdict is Verdict.SUGGESTIVE]:
        names = "; ".join(said(f) for f in hints)
        body.append(paragraph(f"Hints that were not added: {names}."))
    if left := loop.unexplained:
        body.append(paragraph(f"Of unknown cause: {'; '.join(map(lives, left))}."))
    return "\n".join(body)


def said(finding):
    """Its name, and all others that it may be."""
    others = [name for name in finding.candidates if name != finding.effect]
    return finding.effect + (f" (or {' or '.join(others)})" if others else "")


def lives(finding):
    """Where unknown structure is, and how much."""
    return f"{finding.gain:.2f} K lives in {finding.place}"


def gained(finding):
    what = meaning(finding.effect) or f"{finding.why}. "
    gain = f"{finding.gain:.2f} K of the error on days left out"
    return f"{what}{gain}; {finding.verdict}, {VERDICTS[finding.verdict]}"


def meaning(name):
    """The first line of what the effect says of itself."""
    if name not in EFFECTS:
        return ""
    words = EFFECTS[name].terms.__doc__ or ""
    line = words.strip().split("\n", 1)[0].replace(" [1]_", "").rstrip(".")
    return f"{line[:1].lower()}{line[1:]}. " if line else ""


def errors(loop):
    """The table of the printed report."""
    which, end = part(loop)
    keys = [f"rmse_{end}", "rmse_test_day", "rmse_test_night", f"mbe_{end}"]
    keys += ["energy_error_test", "rmse_train"]
    verdicts = {f"+{f.effect}": f.verdict for f in loop.findings}
    rows = [
        (
            name.replace("+", "+ ", 1),
            *(number(row[key]) for key in keys),
            verdicts.get(name, STEPS.get(name, "")),
        )
        for name, row in loop.table.iterrows()
    ]
    head = ("step", "#RMSE", "#day", "#night", "#MBE", "#PR", "#fitted", "verdict")
    return table(
        head,
        rows,
        f"K on the {which} days; MBE is measured − modelled; PR is the error of the "
        "performance ratio, without signs, in points; fitted is the RMSE on the "
        "fitted days.",
    )


def coefficients(loop):
    """Values, errors and ranges of the last step."""
    fit = loop.fit
    rows = []
    for name, row in fit.thermal_model.parameters.items():
        share = f" of {row.share_of}" if row.share_of else ""
        bound = "at its bound" if name in fit.at_bound else ""
        value, error = f"{fit.coefficients[name]:.5g}", rounded(fit.stderr[name])
        span = f"{row.lower:g} … {row.upper:g}{share}"
        rows.append((name, value, error, row.unit, span, bound))
    for one in loop.corrections:  # a clock has numbers and no place in the model
        for name, value in one.values.items():
            error = rounded(one.stderr.get(name, np.nan))
            unit = "s/day" if name == "drift" else "min"
            what = "corrected" if one.applied else "not corrected"
            rows.append((f"clock: {name}", f"{value:.5g}", error, unit, "", what))
    return table(
        ("coefficient", "#value", "#± error", "unit", "range", ""),
        rows,
        "Errors from leaving out each fitted day in turn; range is what is possible.",
    )


def undecided(loop):
    """Ties and hints, and what would decide."""
    undecided = (Verdict.CLASS, Verdict.SUGGESTIVE)
    open_ = [f for f in loop.findings if f.verdict in undecided]
    if not open_:
        none = "Nothing: all that was found has one name."
        return paragraph(none if added(loop) else "Nothing was found.")
    return listed(
        (
            said(f),
            f"{f.verdict}, {VERDICTS[f.verdict]}; {f.gain:.2f} K; {f.why}; it would be "
            f"{numbers(f)}",
        )
        for f in open_
    )


def rules(loop):
    """Every finding with the rules that it was asked, the one that decided last."""
    rows = [
        (
            finding.effect,
            check.name,
            "passed" if check.passed else "failed",
            f"{check.statistic:.3g}",
            f"{'at most' if check.most else 'at least'} {check.threshold:.3g}",
            check.unit,
            check.criterion,
        )
        for finding in loop.findings
        for check in finding.checks
    ]
    if not rows:
        return paragraph("Nothing was found of which a rule could be asked.")
    weeks = loop.week_rows
    days = ", ".join(f"{rows:,} rows of {name} weeks" for name, rows in weeks.items())
    return table(
        ("finding", "rule", "", "#statistic", "asked", "unit", "criterion"),
        rows,
        f"{days}. A chance is that of any of {loop.family} hypotheses. Each criterion "
        "is a field of Criteria.",
    )


def numbers(finding):
    """Coefficients of a finding in one line."""
    return ", ".join(
        f"{name.removeprefix(f'{finding.effect}.')} {value:.3g}"
        + (f" ± {rounded(finding.stderr[name])}" if name in finding.stderr else "")
        for name, value in finding.coefficients.items()
    )


def unexplained(loop):
    """Structure without a name, and where it is."""
    left = loop.unexplained
    if not left and short(loop):
        return paragraph("Not looked for: there are too few days to leave any out.")
    if not left:
        return paragraph(
            f"No structure of {loop.criteria.min_gain:.2f} K and more over hours, "
            "months or the columns of the record."
        )
    return listed((lives(f), f"{numbers(f)} K; {WITHOUT_CAUSE}") for f in left)


def next_measurements(loop):
    """A list of what to measure, the most useful first."""
    if items := advice.to_measure(loop):
        return listed(items, ordered=True)
    return paragraph("Nothing: all that could be weighed was, and nothing is open.")


def by_reason(reasons):
    """Names by the reason that they share, in the order of the first of them."""
    groups = {}
    for name, why in reasons.items():
        words = str(why)
        if why.reason is Reason.DETECTABLE:
            name, words = f"{name} below {why.values['gain']:.2g} K", NOT_SHOWN
        groups.setdefault(words, []).append(name)
    return groups


def untestable(loop, never):
    """What this record, and what no such record can show."""
    body = []
    if loop.untestable:
        reasons = by_reason(loop.untestable).items()
        body.append(listed((", ".join(names), why) for why, names in reasons))
    else:
        body.append(paragraph("All effects of the catalogue could be tested."))
    if never:
        body.append(paragraph("Never from these columns: " + "; ".join(never) + "."))
    return "\n".join(body)


def health(loop):
    """What is missing or impossible, and what was done about it."""
    record = loop.fit.summary
    rows = [
        (name, f"{count:,}", f"{record.impossible.get(name, 0):,}")
        for name, count in record.missing.items()
        if count or record.impossible.get(name, 0)
    ]
    body = []
    if rows:
        head = ("column", "#missing rows", "#impossible, not used")
        body.append(table(head, rows, f"Of {record.rows:,} rows."))
    else:
        body.append(paragraph("No value is missing or impossible."))
    if record.clipped:
        below = f"{record.clipped:,} rows of negative irradiance were set to 0."
        body.append(paragraph(below))
    if notes := [*loop.notes, *loop.fit.notes]:
        items = "\n".join(f"<li>{escaped(note)}</li>" for note in notes)
        body.append(f"<ul>\n{items}\n</ul>")
    return "\n".join(body)


def reproduce(loop):
    """Version, call, and hashes that say whether the data are the same."""
    from pvlib_fem import __version__  # the package is complete by now

    record = loop.fit.summary
    weighed = dict.fromkeys([*(f.effect for f in added(loop)), *loop.ranking.index])
    columns = ", ".join(record.measured)
    hashes = [f"sha256 of the data    {record.sha256}"]
    if loop.fit.holdout is not None:
        test = hashlib.sha256(np.packbits(loop.fit.holdout.to_numpy()).tobytes())
        hashes.append(f"sha256 of test rows   {test.hexdigest()}")
    text = "\n".join((f"pvlib_fem {__version__}", "", call(loop), "", *hashes))
    return "\n".join(
        (
            f"<pre>{escaped(text)}</pre>",
            paragraph(
                f"The first hash is of the times (UTC, ns) and of {columns} "
                "as they were used, after the checks; the second of "
                "np.packbits(loop.fit.holdout).",
                "soft",
            ),
            paragraph(f"Effects that were weighed: {', '.join(weighed) or 'none'}."),
            "<details>\n<summary>The printed report</summary>\n"
            f"<pre>{escaped(loop)}</pre>\n</details>",
        )
    )


def call(loop):
    """The call that made it."""
    arguments = [f"model={loop.fit.model!r}"]
    for name, value in loop.place.items():
        if hasattr(value, "latitude"):
            where = f"{value.latitude}, {value.longitude}, {str(value.tz)!r}"
            value = f"Location({where})"
        if value is not None:
            arguments.append(f"{name}={value}")
    arguments += [f"{name}={words}" for name, words in loop.given.items() if words]
    inside = "".join(f"    {argument},\n" for argument in ["data", *arguments])
    return f"loop = pvlib_fem.close_loop(\n{inside})"


def said_of(value):
    """An argument as it is written, nothing where it is the default."""
    if value is None or value is True:
        return ""
    if isinstance(value, pd.Series):
        return "...  # True in the rows of the second hash"
    if is_dataclass(value) and not hasattr(value, "spec"):
        usual = type(value)()
        changed = [
            f"{field.name}={getattr(value, field.name)!r}"
            for field in fields(value)
            if getattr(value, field.name) != getattr(usual, field.name)
        ]
        return f"{type(value).__name__}({', '.join(changed)})" if changed else ""
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(said_of, value))}]"
    return repr(getattr(value, "spec", value))
