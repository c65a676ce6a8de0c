"""A closed loop as one page that opens anywhere: a mail, a phone, in the dark."""

import hashlib
import html

import numpy as np

from pvlib_fem import plotting
from pvlib_fem.drivers import GEOMETRY
from pvlib_fem.effects import EFFECTS
from pvlib_fem.health import stuck
from pvlib_fem.model import thermal_model
from pvlib_fem.records import instants

ADDED = ("named", "class")  # verdicts of what enters the model
STEPS = {"steady": "no memory", "fem": "the paper's form", "balance": "heat balance"}
VERDICTS = {
    "named": "no other candidate explains it",
    "class": "one of several that this record cannot tell apart",
    "suggestive": "a hint, not added to the model",
    "unknown": "no effect of the catalogue follows it",
}

STYLE = """
:root { color-scheme: light dark;
  --page: #ffffff; --ink: #1c1d1f; --soft: #5c6066; --line: #d9dce0; --card: #f5f6f8;
  --shade: #e0e0e0; --after: #0072b2; --before: #d55e00; }
@media (prefers-color-scheme: dark) { :root {
  --page: #16181b; --ink: #e8e9eb; --soft: #a0a5ac; --line: #383c42; --card: #1f2226;
  --shade: #34383d; --after: #56b4e9; --before: #f0883e; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.5rem 1rem 3rem; max-width: 66rem; color: var(--ink);
  background: var(--page); font: 16px/1.5 system-ui, sans-serif; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .5rem; }
h2 { font-size: 1.15rem; margin: 2.2rem 0 .6rem; border-bottom: 1px solid var(--line); }
p, li { overflow-wrap: anywhere; max-width: 46rem; }
.soft, figcaption { color: var(--soft); font-size: .9rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .9rem; }
th, td { padding: .3rem 1.1rem .3rem 0; text-align: left; vertical-align: top;
  border-bottom: 1px solid var(--line); }
th { font-weight: 600; }
td { white-space: nowrap; }
.n { text-align: right; font-variant-numeric: tabular-nums; }
@media (max-width: 30rem) {
  th, td { padding-right: .6rem; } ul { padding-left: 1.2rem; } }
.figures { display: grid; gap: 1rem;
  grid-template-columns: repeat(auto-fit, minmax(min(100%, 24rem), 1fr)); }
figure { margin: 0; padding: .7rem; background: var(--card); border-radius: .5rem; }
figcaption { margin-bottom: .4rem; }
svg { display: block; width: 100%; height: auto; }
svg text { font-family: system-ui, sans-serif !important; }
pre { overflow-x: auto; padding: .8rem; background: var(--card); border-radius: .5rem;
  font-size: .8rem; line-height: 1.4; }
summary { cursor: pointer; }
"""


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
        section("Pictures", pictures(loop)),
        section("Coefficients", coefficients(loop)),
        section("What the record cannot tell", undecided(loop)),
        section("What is left unexplained", unexplained(loop)),
        section("Not testable", untestable(loop, never)),
        section("The state of the data", health(loop)),
        section("How to reproduce it", reproduce(loop)),
    ]
    policy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
        f"<title>pvlib_fem: {escaped(headline(loop))}</title>\n"
        f"<style>{STYLE}</style>\n</head>\n<body>\n"
        + "\n".join(parts)
        + "\n</body>\n</html>\n"
    )


def escaped(text):
    return html.escape(str(text))


def section(title, body):
    return f"<section>\n<h2>{escaped(title)}</h2>\n{body}\n</section>"


def paragraph(text, kind=""):
    kind = f' class="{kind}"' if kind else ""
    return f"<p{kind}>{escaped(text)}</p>"


def listed(items):
    """A list of pairs: what is told apart, and what is said of it."""
    rows = (
        f"<li><strong>{escaped(name)}</strong>: {escaped(words)}</li>"
        for name, words in items
    )
    return "<ul>\n" + "\n".join(rows) + "\n</ul>"


def table(head, rows, caption=""):
    """A table whose numbers, formatted already, stand in the columns marked ``#``."""
    kinds = [' class="n"' if name.startswith("#") else "" for name in head]

    def line(cells, tag):
        cells = (f"<{tag}{k}>{escaped(c)}</{tag}>" for k, c in zip(kinds, cells))
        return f"<tr>{''.join(cells)}</tr>"

    top = line([name.removeprefix("#") for name in head], "th")
    body = "\n".join(line(row, "td") for row in rows)
    return (
        f'<div class="wide"><table>\n<thead>{top}</thead>\n'
        f"<tbody>\n{body}\n</tbody>\n</table></div>\n"
        + (paragraph(caption, "soft") if caption else "")
    )


def added(loop):
    return [finding for finding in loop.findings if finding.verdict in ADDED]


def ends(loop):
    """Rows of the table before any effect and of the last step."""
    before = "fem" if loop.fit.dynamics == "ewm" else "balance"
    last = loop.table.index[-1]
    return before, last if last.startswith("+") else before


def part(loop):
    """The days that the errors of the verdict are of, and their column's ending."""
    return ("sealed", "test") if loop.fit.test_days else ("fitted", "train")


def short(loop):
    """Whether there were too few days to leave any out."""
    return loop.ranking.empty


def headline(loop):
    error = loop.table[f"rmse_{part(loop)[1]}"]
    before, after = (error[name] for name in ends(loop))
    if len(set(ends(loop))) == 1:
        return f"{before:.2f} K, no effect {'weighed' if short(loop) else 'added'}"
    return f"{before:.2f} K before, {after:.2f} K after"


def number(value):
    """Two decimals, without a negative zero; a dash where there is none."""
    return f"{value:z.2f}" if np.isfinite(value) else "–"


def verdict(loop):
    """What was found, first of all and in plain words."""
    fit, index = loop.fit, loop.fit.record.index
    days = len(np.unique(fit.record.dates))
    count = f"{fit.test_days} sealed days, which no fit has seen"
    body = [
        f"<h1>Module temperature: {escaped(headline(loop))}</h1>",
        paragraph(
            f"Error (RMSE) on {count if fit.test_days else 'the fitted days'}. "
            f"{days} day{'s' * (days > 1)} from {index[0]:%Y-%m-%d} to "
            f"{index[-1]:%Y-%m-%d}, {len(index):,} rows; model {fit.model}, dynamics "
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
                f"Nothing in the record asks for a further effect: none gains "
                f"{loop.min_gain:.2f} K on days left out, beyond chance and within "
                "what is possible."
            )
        )
    if hints := [f for f in loop.findings if f.verdict == "suggestive"]:
        names = "; ".join(said(f) for f in hints)
        body.append(paragraph(f"Hints that were not added: {names}."))
    if left := loop.unexplained:
        body.append(paragraph(f"Of unknown cause: {'; '.join(map(place, left))}."))
    return "\n".join(body)


def said(finding):
    """Its name, and all others that it may be."""
    others = [name for name in finding.candidates if name != finding.effect]
    return finding.effect + (f" (or {' or '.join(others)})" if others else "")


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


def place(finding):
    """Where unknown structure lives, and how much."""
    sides = (span(name, *ends_) for name, ends_ in finding.where.items())
    return f"{finding.gain:.2f} K at {', '.join(sides) or finding.effect}"


def span(name, start, end):
    """Words for one side of a table."""
    if name in ("weekend", "alternate_day"):
        return start  # which says all
    start, end = (v if isinstance(v, str) else f"{v:g}" for v in (start, end))
    return f"{name} {start}" + ("" if start == end else f" to {end}")


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


def pictures(loop):
    """Figures, each with what it shows."""
    which = part(loop)[0]
    known = ~np.any(list(stuck(loop.fit.record).values()), axis=0)
    residuals = {
        "before": loop.residual_before[known],
        "after": loop.fit.residual[known],
    }
    limit = plotting.largest(*map(plotting.by_hour_and_month, residuals.values()))

    def residual_map(which):
        return lambda ax: plotting.plot_residual_map(residuals[which], ax, limit)

    day = plotting.Day(loop.fit).date
    kinds = {
        "steps": (
            lambda ax: plotting.plot_steps(loop, ax),
            f"RMSE on the {which} days, step by step",
        ),
        "day": (
            lambda ax: plotting.plot_before_after(loop, ax),
            f"The most variable of the {which} days, {day}",
        ),
        "map": (residual_map("before"), "Mean residual by month and hour, all days"),
    }
    if len(set(ends(loop))) == 2:
        draw, words = kinds.pop("map")
        kinds["before"] = draw, f"Before: m{words[1:]}"
        kinds["after"] = residual_map("after"), "After: the same on the same scale"
    if loop.fit.effects:
        kinds["contributions"] = (
            lambda ax: plotting.plot_contributions(loop, ax),
            "What each effect adds to the temperature on that day, with all others "
            "there; rms over all days",
        )
    body = (
        f"<figure>\n<figcaption>{escaped(words)}</figcaption>\n"
        f"{plotting.svg(draw, name)}\n</figure>"
        for name, (draw, words) in kinds.items()
    )
    return '<div class="figures">\n' + "\n".join(body) + "\n</div>"


def coefficients(loop):
    """Values, errors and ranges of the last step."""
    fit = loop.fit
    rows = []
    model = thermal_model(fit.model, fit.dynamics, fit.effects)
    for name, row in model.parameters.items():
        share = f" of {row.share_of}" if row.share_of else ""
        bound = "at its bound" if name in fit.at_bound else ""
        value, error = f"{fit.coefficients[name]:.5g}", rounded(fit.stderr[name])
        span = f"{row.lower:g} … {row.upper:g}{share}"
        rows.append((name, value, error, row.unit, span, bound))
    for finding in loop.findings:  # a clock has numbers and no place in the model
        for name, value in finding.coefficients.items():
            if finding.verdict in ADDED and name not in fit.coefficients:
                error = rounded(finding.stderr.get(name, np.nan))
                rows.append((name, f"{value:.5g}", error, "", "", ""))
    return table(
        ("coefficient", "#value", "#± error", "unit", "range", ""),
        rows,
        "Errors from leaving out each fitted day in turn; range is what is possible.",
    )


def rounded(error):
    """Two digits, and never 2e+03."""
    return f"{float(f'{error:.2g}'):g}" if np.isfinite(error) else "–"


def undecided(loop):
    """Ties and hints, and what would decide."""
    open_ = [f for f in loop.findings if f.verdict in ("class", "suggestive")]
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
            f"No structure of {loop.min_gain:.2f} K and more over hours, months or the "
            "columns of the record."
        )
    # the reason begins with the place once more
    whys = (f.why.partition(": ")[2] or f.why for f in left)
    return listed((place(f), f"{numbers(f)} K; {why}") for f, why in zip(left, whys))


def untestable(loop, never):
    """What this record, and what no such record can show."""
    body = []
    if loop.untestable:
        names = {}
        for name, why in loop.untestable.items():
            names.setdefault(why, []).append(name)
        body.append(listed((", ".join(group), why) for why, group in names.items()))
    else:
        body.append(paragraph("All effects of the catalogue could be tested."))
    if never:
        body.append(paragraph("Never from these columns: " + "; ".join(never) + "."))
    return "\n".join(body)


def health(loop):
    """What is missing or impossible, and what was done about it."""
    record = loop.fit.record
    rows = [
        (name, f"{count:,}", f"{record.impossible.get(name, 0):,}")
        for name, count in record.missing.items()
        if count or record.impossible.get(name, 0)
    ]
    body = []
    if rows:
        head = ("column", "#missing rows", "#impossible, not used")
        body.append(table(head, rows, f"Of {len(record.index):,} rows."))
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

    columns = measured(loop)
    weighed = dict.fromkeys([*(f.effect for f in added(loop)), *loop.ranking.index])
    sealed = np.packbits(loop.fit.holdout.to_numpy())
    text = "\n".join(
        (
            f"pvlib_fem {__version__}",
            "",
            call(loop),
            "",
            f"sha256 of the data    {digest(loop)}",
            f"sha256 of sealed rows {hashlib.sha256(sealed.tobytes()).hexdigest()}",
        )
    )
    return "\n".join(
        (
            f"<pre>{escaped(text)}</pre>",
            paragraph(
                f"The first hash is of the times (UTC, ns) and of {', '.join(columns)} "
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
    """The call that made it, as far as the loop knows; default effects and holdout."""
    arguments = [f"model={loop.fit.model!r}"]
    for name, value in loop.place.items():
        if hasattr(value, "latitude"):
            where = f"{value.latitude}, {value.longitude}, {str(value.tz)!r}"
            value = f"Location({where})"
        if value is not None:
            arguments.append(f"{name}={value}")
    arguments = ["data", *arguments, f"min_gain={loop.min_gain:g}"]
    inside = "".join(f"    {argument},\n" for argument in arguments)
    return f"loop = pvlib_fem.close_loop(\n{inside})"


def measured(loop):
    """Names of the record's own columns, in order."""
    record = loop.fit.record
    return [
        n for n in record.missing if n in record.inputs.columns and n not in GEOMETRY
    ]


def digest(loop):
    """
    Sha256 of the record's times and values, whatever the computer.

    Parameters
    ----------
    loop : Loop

    Returns
    -------
    str
    """
    record = loop.fit.record
    times = instants(record.index).astype("M8[ns]").astype("<i8")
    found = hashlib.sha256(times.tobytes())
    for name in measured(loop):
        values = np.asarray(record[name], dtype="<f8")
        # one NaN, and one zero
        values = np.where(np.isnan(values), np.nan, values + 0.0)
        found.update(name.encode("utf-8", "surrogatepass"))
        found.update(values.astype("<f8").tobytes())
    return found.hexdigest()
