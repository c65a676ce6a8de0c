"""A closed loop as one page that opens anywhere: a mail, a phone, in the dark."""

from collections.abc import Iterator, Mapping, Sequence
from numbers import Real
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pvlib_fem._findings import CORRECTED, PREDICTED, Finding, Verdict
from pvlib_fem._record.column_names import GEOMETRY
from pvlib_fem._report import (
    budget_text as budget,
    event_text as events,
    next_measurement as advice,
)
from pvlib_fem._report.document import (
    Block,
    Heading,
    Listing,
    Paragraph,
    Parts,
    Section,
    Table,
    document,
    figures,
    fragment,
    listed,
    section,
    table,
)
from pvlib_fem._report.formatting import two_decimals, with_error
from pvlib_fem._report.page_parts import (
    DONE,
    NO_ROWS,
    coefficients,
    done_to_data,
    heading,
    in_energy,
    made_by,
    printed_report,
)
from pvlib_fem._report.page_pictures import picture_of_ceiling, pictures
from pvlib_fem._report.shown import findings_with_pictures
from pvlib_fem._report.treatment import treatment
from pvlib_fem.effects import CHANGES
from pvlib_fem.plotting._step_plots import spaced_name
from pvlib_fem.reasons import Because, Reason
from pvlib_fem.scores import GAMMA

if TYPE_CHECKING:
    from pvlib_fem._loop.results.loop_result import Loop

MOST_EVENTS = 10  # of a kind that a page has
NOT_SHOWN = "smaller than this record can show"
WORTH = (
    "Worth in K: how much the finding reduces the error, as the root of a mean square. "
    "Worth in kWh/kWp per year: how much the finding changes the expected DC energy of "
    "the record's irradiance and the modelled temperature, as the sum of absolute "
    "changes, at a temperature coefficient of {:g} %/K. It is the mean over all days "
    "of the record, for 365 days. Of a fault of the irradiance sensor, and of what "
    "covers or shades it or the modules, it includes the irradiance. Of an effect that "
    "is missing from the model, it is the part that other coefficients of the model "
    "would not make up. Of events that power shows, it is the difference of measured "
    "and expected power, per kW that the plant gives at 1000 W/m² and 25 °C by its own "
    "record. The energy of an outage that is a cause in the model is that of its "
    "temperature alone. A dash stands for an unknown worth. Clocks come first, since a "
    "wrong clock can make all else wrong."
)
#: words of the page
TERMS = (
    ("identified", "one cause has a probability of 95 % or more"),
    (
        "ambiguous",
        "the listed causes together have a probability of 95 %; these data cannot "
        "distinguish them",
    ),
    ("hint", "seen, and not added to the model, for the stated reason"),
    (
        "unexplained pattern",
        "a part of the error that comes again, and that follows no known cause",
    ),
    (
        "cross-check",
        "what another column, a clear sky or the usual wind shows of the same sensor",
    ),
    ("test weeks", "weeks that no fit and no decision has used"),
    ("range", "holds the coefficient with a probability of 90 %"),
    ("RMSE, MBE", "root mean square error; mean of measured minus modelled"),
    ("steady, fem, balance", "no memory; the paper's form; heat balance"),
)
WITHOUT_CAUSE = "no effect and no column explains it"
STEPS = {
    "steady": "no memory",
    "fem": "the paper's form",
    "balance": "heat balance",
    "+radiative_loss": "longwave exchange of every module",
    PREDICTED: "unexplained patterns, without a known cause",
}
VERDICTS = {
    "identified": "no other tested cause explains it",
    "ambiguous": "one of several causes that this record cannot distinguish",
    "alone": "or a cause outside the catalogue that follows the same columns",
    "hint": "a hint, not added to the model",
    "unexplained": "no effect of the catalogue follows it",
}


def page(
    loop: "Loop",
    statements: pd.DataFrame,
    never: Sequence[str] = (),
    title: str | None = None,
    gamma: float = GAMMA,
) -> str:
    """
    The report of a closed loop as one HTML file.

    It has no script, no address of anything outside and no time of its making: the
    same loop gives the same text. All that may come from a user's file is escaped.

    Parameters
    ----------
    loop : Loop
    statements : DataFrame
        As ``loop.statements``, with energies at ``gamma``.
    never : sequence of str
        What no record of these columns can tell.
    title : str, optional
        Of the plant or the file; by default the name of the location.
    gamma : float, default -0.0035
        Temperature coefficient of power, for the errors of energy. [1/K]

    Returns
    -------
    str
    """
    fit = loop.fit
    title = name_of(loop) if title is None else title
    drawn = fit.record is not None
    parts: Parts = [
        heading(
            f"Module temperature: {headline(loop)}",
            title,
            loop.corrections,
            site(loop, title),
        ),
        conclusion(loop),
        section("What to do", to_do(statements, gamma)),
        section("Error by step", errors(loop, gamma), on_errors(loop)),
        section("Energy", in_energy(fit, residuals(loop), gamma)),
        *could_be(loop),
        section("Evidence", evidence(loop, statements) if drawn else NO_ROWS),
        section(DONE, done_to_data(treatment(loop), [*loop.notes, *fit.notes])),
        section("Remaining error", remaining(loop)),
        section("What could not be tested", untestable(loop, never)),
        section("What to measure next", next_measurements(loop)),
        section(
            "Annex: coefficients", coefficients(fit, loop.corrections, ranges(loop))
        ),
        section("Annex: ambiguous findings and hints", undecided(loop, statements)),
        section("Annex: remaining error by time scale", error_by_scale(loop)),
        section("Annex: checks", finding_checks(loop)),
        section("Annex: terms", listed(TERMS)),
        section("Annex: how to reproduce this report", reproduce(loop)),
    ]
    return document(" · ".join(filter(None, [title, headline(loop)])), parts)


def evidence(loop: "Loop", statements: pd.DataFrame) -> Parts:
    """Each finding with its pictures, then the error of the model in pictures."""
    items = findings_with_pictures(loop, statements)
    drawn = [(svg, words, one.text) for one in items for svg, words in one.pictures]
    return [
        figures(drawn) if drawn else [],
        [Paragraph(f"{one.text}: {one.note}") for one in items if one.note],
        Heading("The error of the model", "h3"),
        figures(pictures(loop)),
    ]


def could_be(loop: "Loop") -> Iterator[Section]:
    """How much could still be explained, where that was computed."""
    if (ceiling := loop.known_ceiling) is not None:
        words = [Paragraph(one) for one in loop.conclusion[2:]]
        bar = figures([picture_of_ceiling(ceiling)])
        yield section("How much could still be explained", words, bar)


def to_do(statements: pd.DataFrame, gamma: float) -> list[Block]:
    """What was found and what to do about it, the most valuable first."""
    hints = statements["verdict"] == Verdict.HINT
    rows = [
        (
            one["text"],
            one["action"] or "–",
            one["device"],
            one["since"] or "–",
            two_decimals(one["gain"]),
            f"{one['energy']:.1f}" if np.isfinite(one["energy"]) else "–",
            one["certainty"] or "–",
        )
        for one in statements[~hints].to_dict("records")
    ]
    body: list[Block] = [Paragraph("Nothing: no fault of an instrument was found.")]
    if rows:
        head = ("finding", "action", "device", "@since", "#worth [K]")
        head += ("#worth [kWh/kWp per year]", "how sure")
        body = [table(head, rows, WORTH.format(100 * gamma), wraps=True)]
    if count := int(hints.sum()):
        words = f"{count} hint{'s' * (count > 1)} that the model does not contain"
        body.append(Paragraph(f"{words} {'are' if count > 1 else 'is'} in the annex."))
    return body


def ranges(loop: "Loop") -> dict[str, tuple[float, float]]:
    """The ranges of all coefficients that have one."""
    return {name: ends for f in loop.finding_objects for name, ends in f.ranges.items()}


def site(loop: "Loop", title: str) -> str:
    """Location, plane, period, rows and step of a record in one line."""
    record, place = loop.fit.summary, loop.place
    where, angles = place["location"], [place[name] for name in GEOMETRY[2:]]
    parts = ["location not given"]
    if where is not None:
        north = "N" if where.latitude >= 0 else "S"
        east = "E" if where.longitude >= 0 else "W"
        parts = [
            f"{abs(where.latitude):.3f}° {north}, {abs(where.longitude):.3f}° {east}"
        ]
    if all(isinstance(angle, Real) for angle in angles):
        parts.append("tilt {:.0f}°, azimuth {:.0f}°".format(*angles))
    elif place.get("mount") is not None or None not in angles:
        parts.append("a plane that moves")
    else:
        parts.append("plane not given")
    zone = f" ({record.start.tz})" if record.start.tz is not None else ""
    parts.append(f"{record.start:%Y-%m-%d} to {record.end:%Y-%m-%d}{zone}")
    step = record.step
    every = f"{step / 60:g} min" if step >= 60 else f"{step:g} s"
    name = [name] if (name := name_of(loop)) != title and name else []
    return " · ".join([*name, *parts, f"{record.rows:,} rows", f"time step {every}"])


def name_of(loop: "Loop") -> str:
    """Name of the place, where it has one."""
    return getattr(loop.place["location"], "name", None) or ""


def brief(loop: "Loop") -> str:
    """
    The headline and the errors, for a notebook.

    Parameters
    ----------
    loop : Loop
        Loop with or without its rows.

    Returns
    -------
    str
        HTML that is no whole page.
    """
    return fragment(
        [
            heading(f"Module temperature: {headline(loop)}", name_of(loop), tag="h4"),
            [Paragraph(one.why) for one in loop.corrections],
            errors(loop),
            [Paragraph(finding.why) for finding in loop.unexplained],
        ]
    )


def residuals(loop: "Loop") -> dict[str, pd.Series | None]:
    """Residuals before and after the effects, by the name of the step."""
    last = {"after": loop.fit.residual}
    return last if loop.last == loop.base else {"before": loop.residual_before, **last}


def findings_in_model(loop: "Loop") -> list[Finding]:
    return [finding for finding in loop.finding_objects if finding.added]


def error_days(loop: "Loop") -> tuple[str, str]:
    """The days that the errors of the verdict are of, and their column's ending."""
    return ("test", "test") if loop.fit.test_days else ("fitted", "train")


def without_test_days(loop: "Loop") -> bool:
    """Whether there were too few days to leave any out."""
    return not loop.weighed


def headline(loop: "Loop") -> str:
    error = loop.table[f"rmse_{error_days(loop)[1]}"]
    before, after = error[loop.base], error[loop.last]
    if loop.last == loop.base:
        done = "weighed" if without_test_days(loop) else "added"
        return f"{before:.2f} K, no effect {done}"
    return f"{before:.2f} K before, {after:.2f} K after"


def conclusion(loop: "Loop") -> list[Paragraph]:
    """How good the model was and is, what was found, and what remains."""
    error, findings = loop.conclusion[:2]
    if loop.weighed and not findings_in_model(loop):
        findings += (
            " No effect of the catalogue and no column reduces the error by "
            f"{loop.criteria.min_rmse_reduction:.2f} K or more, beyond chance and with "
            "a possible size."
        )
    body = [Paragraph(error), Paragraph(findings)]
    if words := budget.error_in_time(loop):
        body.append(Paragraph(f"Remaining error: {words}."))
    return body


def on_errors(loop: "Loop") -> Paragraph:
    """Which days, model and fit the errors are of."""
    fit, days = loop.fit, loop.fit.summary.days
    seen = "No fit and no decision has used the test days. " * bool(fit.test_days)
    return Paragraph(
        f"{seen}{days} day{'s' * (days > 1)} with rows; model {fit.model}, "
        f"dynamics {fit.dynamics}. {first_model(loop)}",
        "soft",
    )


def first_model(loop: "Loop") -> str:
    """The model that the first number of the headline is of."""
    error = loop.table[f"rmse_{error_days(loop)[1]}"]
    which = "The first error" if loop.last != loop.base else "The error"
    form = "fem" if loop.fit.dynamics == "ewm" else loop.fit.dynamics
    names = [*loop.table.index]
    usual = [name for name in names[: names.index(loop.base) + 1] if name[0] == "+"]
    more = "".join(f" and {STEPS.get(name, name[1:])}" for name in usual)
    words = (
        f"{which} is that of the model without effects, fitted to this record with "
        f"dynamics ({STEPS[form]}){more}; without dynamics it is "
        f"{error['steady']:.2f} K."
    )
    if CORRECTED in error:
        words += f" Correcting the clock alone gives {error[CORRECTED]:.2f} K."
    return words


def names_of(finding: Finding) -> str:
    """Its name, and all others that it may be."""
    others = [name for name in finding.candidates if name != finding.effect]
    return finding.effect + (f" (or {' or '.join(others)})" if others else "")


def pattern_place(finding: Finding) -> str:
    """Where unknown structure is, and how much."""
    return f"{finding.gain:.2f} K of the error is {finding.place}"


def verdict_words(finding: Finding) -> str:
    """Its verdict in words."""
    alone = finding.verdict is Verdict.AMBIGUOUS and len(finding.candidates) == 1
    return f"{finding.verdict}: {VERDICTS['alone' if alone else finding.verdict]}"


def errors(loop: "Loop", gamma: float = GAMMA) -> Table:
    """The table of the printed report."""
    shown = loop.table.assign(
        energy_error_test=loop.table["energy_error_test"] * abs(gamma / GAMMA)
    )
    which, end = error_days(loop)
    keys = [f"rmse_{end}", "rmse_test_day", "rmse_test_night", f"mbe_{end}"]
    keys += ["energy_error_test", "rmse_train"]
    verdicts = {f"+{f.effect}": f.verdict for f in loop.finding_objects}
    rows = [
        (
            spaced_name(str(name)),
            *(two_decimals(row[key]) for key in keys),
            verdicts.get(str(name), STEPS.get(str(name), "")),
        )
        for name, row in shown.iterrows()
    ]
    head = (
        "step",
        "#RMSE [K]",
        "#day [K]",
        "#night [K]",
        "#MBE [K]",
        "#PR [points]",
        "#fitted [K]",
        "verdict",
    )
    return table(
        head,
        rows,
        f"K on the {which} days; MBE is measured − modelled; PR is the error of the "
        f"performance ratio, as absolute values, in points at {100 * gamma:g} %/K; "
        "fitted is the RMSE on the fitted days.",
    )


def undecided(loop: "Loop", statements: pd.DataFrame) -> Paragraph | Listing:
    """Ties and hints, and what would decide."""
    undecided = (Verdict.AMBIGUOUS, Verdict.HINT)
    open_ = [f for f in loop.finding_objects if f.verdict in undecided]
    if not open_:
        none = "Nothing: all that was found has one name."
        return Paragraph(none if findings_in_model(loop) else "Nothing was found.")
    texts = events.texts_by_cause(statements)
    others = statements[statements["verdict"] != events.EVENT]
    energies = dict(zip(others["cause"], others["energy"]))

    def worth(name: str) -> str:
        """Energy of a finding; empty where it is unknown."""
        energy = energies.get(name, np.nan)
        return f", {energy:.1f} kWh/kWp per year" if np.isfinite(energy) else ""

    return listed(
        (
            texts.get(f.effect, names_of(f)),
            f"{names_of(f)}; {verdict_words(f)}; {f.gain:.2f} K{worth(f.effect)}; "
            f"{f.why}; it would be {coefficient_words(f)}",
        )
        for f in open_
    )


def finding_checks(loop: "Loop") -> Paragraph | Table:
    """Every finding with its checks, the deciding one last."""
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
        for finding in loop.finding_objects
        for check in finding.checks
    ]
    if not rows:
        return Paragraph("Nothing was found that could be checked.")
    weeks = loop.week_rows
    days = ", ".join(f"{rows:,} rows of {name} weeks" for name, rows in weeks.items())
    return table(
        ("finding", "check", "", "#statistic", "required", "unit", "criterion"),
        rows,
        f"{days}. Each criterion is a field of Criteria.",
    )


def coefficient_words(finding: Finding) -> str:
    """
    Coefficients of a finding in one line.

    Parameters
    ----------
    finding : Finding
        Finding, whose coefficients are of its most probable cause.

    Returns
    -------
    str
        Each coefficient with its standard error, without the name of the effect; empty
        without coefficients.
    """
    return ", ".join(
        f"{name.removeprefix(f'{finding.effect}.')} "
        + with_error(value, finding.stderr.get(name, np.nan))
        for name, value in finding.coefficients.items()
    )


def remaining(loop: "Loop") -> Block | list[Block]:
    """Patterns without a cause, days that stand out, and what power shows."""
    items = [
        (pattern_place(f), f"{direction(f)}; {WITHOUT_CAUSE}") for f in loop.unexplained
    ]
    items += [
        (days, f"{words}; the site's log may have the cause")
        for days, words in budget.days_that_stand_out(loop)
    ]
    for name, rows in events.by_kind(loop).items():
        happened = events.happened(name, loop)
        items.append((f"Power shows that {happened}", events.all_of(rows)))
    if loop.unexplained:
        return listed(items)
    words = (
        f"No pattern of {loop.criteria.min_rmse_reduction:.2f} K and more over hours, "
        "months or the columns of the record."
    )
    if without_test_days(loop):
        words = "Not looked for: there are too few days to leave any out."
    return [Paragraph(words), *([listed(items)] if items else [])]


def error_by_scale(loop: "Loop") -> list[Block]:
    """The error budget, all days that stand out, and events."""
    body: list[Block] = []
    if len(loop.episodes) > budget.MOST:
        body.append(listed(budget.days_that_stand_out(loop, most=None)))
    for name, rows in events.by_kind(loop).items():
        happened = (
            f"Power shows that {events.happened(name, loop)}: {events.all_of(rows)}."
        )
        body += [Paragraph(happened), event_page(rows)]
    head = ("part", "#mean square [K²]", "#root [K]", "#share [%]", "weeks")
    words = (
        "The parts that the steps remove and the remaining error add up to the steady "
        "model's mean square. The days that stand out and the time scales of all other "
        "days add up to the remaining error. Unexplained patterns are parts of it, as "
        "they reduce the error of fitting weeks that are held out in turn. Days that "
        "stand out are taken from all weeks, and decide nothing."
    )
    return [table(head, budget.budget_cells(loop), words), *body]


def event_page(rows: pd.DataFrame) -> Table:
    """A table of events, the largest first."""
    head = ("@from", "@to", "#duration [h]", "#residual [K]", "#share of error [%]")
    head += ("#power of expected [%]", "#energy [kWh/kWp]", "#temp_air [°C]")
    cells = (
        (
            f"{row['start']:%Y-%m-%d %H:%M}",
            f"{row['end']:%Y-%m-%d %H:%M}",
            str(row["hours"]),
            f"{row['size']:.1f}",
            f"{100 * row['share']:.2f}",
            f"{100 * row['power']:.0f}",
            two_decimals(row["energy"]),
            f"{row['temp_air']:.1f}",
        )
        for row in rows.head(MOST_EVENTS).to_dict("records")
    )
    more = len(rows) - MOST_EVENTS
    return table(head, cells, f"{more} more are in loop.events." if more > 0 else "")


def direction(finding: Finding) -> str:
    """Whether the modules are warmer or colder than modelled."""
    mean = finding.coefficients["mean"]
    way = "warmer" if mean > 0 else "colder"
    return f"the module is {abs(mean):.2f} K {way} then than modelled, in the mean"


def next_measurements(loop: "Loop") -> Listing | Paragraph:
    """A list of what to measure, the most useful first."""
    if items := advice.to_measure(loop):
        return listed(items, ordered=True)
    return Paragraph("Nothing: all that could be weighed was, and nothing is open.")


def by_reason(reasons: Mapping[str, Because]) -> dict[str, list[str]]:
    """
    Names by the reason that they share, in the order of the first of them.

    Parameters
    ----------
    reasons : dict of Because
        Why each effect is not tested or not seen, by its name.

    Returns
    -------
    dict of list of str
        Names by the reason in words. An effect with a minimum detectable gain has it in
        its name [K], and all changes of instruments together are one name.
    """
    groups = {}
    for name, why in reasons.items():
        words = str(why)
        if why.reason is Reason.DETECTABLE:
            name, words = f"{name} below {why.values['gain']:.2g} K", NOT_SHOWN
        groups.setdefault(words, []).append(name)
    return {words: shortened_names(names) for words, names in groups.items()}


def shortened_names(names: list[str]) -> list[str]:
    """Names, those of all changes of instruments as one."""
    if not {*CHANGES} <= {*names}:
        return names
    return [*(n for n in names if n not in CHANGES), "changes of instruments"]


def untestable(loop: "Loop", never: Sequence[str]) -> list[Block]:
    """What this record, and what no such record can show."""
    body: list[Block] = []
    if loop.untestable:
        reasons = by_reason(loop.untestable).items()
        body.append(listed((", ".join(names), why) for why, names in reasons))
    else:
        body.append(Paragraph("All effects of the catalogue could be tested."))
    if never:
        body.append(
            Paragraph("Not identifiable from these columns: " + "; ".join(never) + ".")
        )
    return body


def reproduce(loop: "Loop") -> Parts:
    """Version, call, hashes, and what else was tried."""
    weighed = dict.fromkeys(
        [*(f.effect for f in findings_in_model(loop)), *loop.ranking.index]
    )
    names = ", ".join(weighed) or "none"
    return [
        made_by(loop.fit, loop_call(loop)),
        Paragraph(f"Effects that were weighed: {names}."),
        printed_report(loop.report()),
    ]


def loop_call(loop: "Loop") -> str:
    """The call that made it."""
    arguments = [f"model={loop.fit.model!r}"]
    for name, value in loop.place.items():
        if hasattr(value, "latitude"):
            where = f"{value.latitude}, {value.longitude}, {str(value.tz)!r}"
            value = f"Location({where}, {value.altitude})"
        if value is not None and value != "columns":  # which are in data
            arguments.append(f"{name}={value}")
    arguments += [f"{name}={words}" for name, words in loop.given.items() if words]
    inside = "".join(f"    {argument},\n" for argument in ["data", *arguments])
    return f"loop = pvlib_fem.close_loop(\n{inside})"
