"""The printed report of a closed loop."""

from collections.abc import Iterator
from textwrap import TextWrapper
from typing import TYPE_CHECKING

import numpy as np

from pvlib_fem._findings import CORRECTED, PREDICTED, Correction, Finding, Verdict
from pvlib_fem._record.file_summary import Summary
from pvlib_fem._report import budget_text as budget, event_text as events
from pvlib_fem._report.ceiling_text import ceiling_sentence
from pvlib_fem._report.formatting import range_text, two_digits, with_error
from pvlib_fem._report.loop_page import by_reason
from pvlib_fem.plotting._step_plots import step_name

if TYPE_CHECKING:
    from pvlib_fem._fitting.fem_fit import FemFit
    from pvlib_fem._loop.results.loop_result import Loop

OF_WIND = (
    "height of the anemometer, mean shelter: both change the wind coefficient alone"
)
NEVER = (
    "absorptance, irradiance gain, mean rear irradiance: all change k alone",
    OF_WIND,
    "offsets of either thermometer, mean sky: all change the bias alone",
    "a change of irradiance gain, sensor contact or mounting: power or a second sensor "
    "distinguishes them",
)


WIDE, MOST = 26, 100  # characters of the first column of the report, and of a line
#: what the numbers of a clock are: unit, and words for either sign
LATE = {
    "late": ("min", "ahead", "behind"),
    "drift": ("s", "gained each day", "lost each day"),
    "summer": ("min", "ahead in summer", "behind in summer"),
}


#: what is in the base model, and no finding
STEPS = {
    "+radiative_loss": "longwave exchange, which every module has",
    PREDICTED: "unexplained patterns, which repeat without a known cause",
}
OPEN = (Verdict.AMBIGUOUS, Verdict.HINT)


def not_identifiable(fit: "FemFit") -> list[str]:
    """
    What no such record can show.

    Parameters
    ----------
    fit : FemFit
        Fit, whose columns decide whether wind is among them.

    Returns
    -------
    list of str
    """
    wind = "wind_speed" in fit.summary.columns
    return [words for words in NEVER if wind or words != OF_WIND]


def lines(loop: "Loop") -> Iterator[str]:
    """
    Lines of the printed report, none wider than a window.

    Parameters
    ----------
    loop : Loop
        Loop with or without its rows.

    Yields
    ------
    str
    """
    fit, record = loop.fit, loop.fit.summary
    yield (
        f"pvlib_fem: the loop on {record_length(record)} · "
        f"{record.rows:,} rows "
        f"· {fit.test_days} test day{'s' * (fit.test_days != 1)} "
        f"· {fit.model}, {fit.dynamics}"
    )
    for head, words in (*clock_lines(loop), *error_rows(loop), *remaining(loop)):
        yield from folded_line(head, words)


def record_length(record: Summary) -> str:
    """
    Days of a record, and its step.

    Parameters
    ----------
    record : Summary
        Summary of the rows.

    Returns
    -------
    str
        Such as "365 days at 5 min".
    """
    step, days = record.step, record.days
    width = f"{step / 60:g} min" if step >= 60 else f"{step:g} s"
    return f"{days} day{'s' if days > 1 else ''} at {width}"


def folded_line(head: str, words: str) -> list[str]:
    """A line, whose words go on below where they begin."""
    wide = max(WIDE, len(head))
    fold = TextWrapper(
        MOST,
        initial_indent=f"{head:<{wide}}",
        subsequent_indent=" " * wide,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return fold.wrap(words) or [head.rstrip()]


def clock_lines(loop: "Loop") -> Iterator[tuple[str, str]]:
    """Clock faults come first, since all else may be wrong by them."""
    for one in loop.corrections:
        yield "corrected" if one.applied else "NOT CORRECTED", one.why


def error_rows(loop: "Loop") -> Iterator[tuple[str, str]]:
    """The table of errors, a row for each step."""
    head = ("RMSE", "day", "night", "MBE")
    part = "test" if loop.fit.test_days else "train"
    shown = (f"rmse_{part}", "rmse_test_day", "rmse_test_night", f"mbe_{part}")
    cells = "".join(f"{name:>7}" for name in head)
    yield f"{'step':<{WIDE}}{cells}  energy error  ", "verdict"
    verdicts = {f"+{f.effect}": f for f in loop.finding_objects if f.added}
    for key, row in loop.table.iterrows():
        name = str(key)
        cells = "".join(number_cell(row[column], 7) for column in shown)
        cells += number_cell(row["energy_error_test"], 9) + " %"
        title = step_name(name)
        words = STEPS.get(name, "")
        if name in verdicts:
            words = verdict_and_sizes(verdicts[name], loop)
        if name == CORRECTED:
            own = [one for one in loop.corrections if one.unit == "K"]
            words = "; ".join(map(clock_error_words, own))
        yield f"{title:<{WIDE}}{cells}    ", words


def remaining(loop: "Loop") -> Iterator[tuple[str, str]]:
    """Remaining error, ambiguous findings, what is not testable, and the notes."""
    if words := budget.error_in_time(loop):
        yield "remaining error", words
    for days, words in budget.days_that_stand_out(loop):
        yield "check the site's log", f"{days}: {words}"
    if words := budget.more_episodes(loop):
        yield "", words
    for name, rows in events.by_kind(loop).items():
        happened = events.happened(name, loop)
        words = f"{happened}, {events.all_of(rows)}; {events.largest_events(rows)}"
        yield "power shows", words
    for finding in loop.unexplained:
        yield "unexplained pattern", finding.why
    if loop.known_ceiling is not None:
        yield "could be explained", ceiling_sentence(loop.known_ceiling)
    for finding in loop.finding_objects:
        if finding.verdict in OPEN:
            names = " | ".join(finding.candidates)
            if finding.shares and finding.verdict is Verdict.AMBIGUOUS:
                names = finding.shares
            words = f"{names} ({finding.gain:.2f} K): {finding.why}"
            criterion = failed_criterion(finding)
            rule = f" [{criterion}]" if criterion else ""
            yield finding.verdict, f"{words}{rule}"
    for finding in loop.finding_objects:
        yield from (("cross-check", str(one)) for one in finding.conclusive_checks)
    for why, names in by_reason(loop.untestable).items():
        yield "not testable", f"{', '.join(names)} ({why})"
    for i, words in enumerate(not_identifiable(loop.fit)):
        yield "" if i else "not identifiable", words
    if not loop.fit.test_days:
        yield "note", "no test days: these are errors on the fitted days"
    yield from (("note", note) for note in loop.notes)


def number_cell(value: float, width: int) -> str:
    """
    A number with two decimals, to the right of its cell; a dash for NaN.

    Parameters
    ----------
    value : float
        Any number.
    width : int
        Width of the cell. [characters]

    Returns
    -------
    str
    """
    return f"{'–':>{width}}" if np.isnan(value) else f"{value:>z{width}.2f}"


def verdict_and_sizes(finding: Finding, loop: "Loop") -> str:
    """Words behind the row of an added effect."""
    (effect,) = [e for e in loop.fit.effects if e.name == finding.effect]
    parts = []
    known = finding.coefficients  # of what a record does not show there is none
    for key, row in effect.rows().items():
        if key not in known:
            continue
        number = with_error(finding.coefficients[key], finding.stderr[key])
        name = f"{key.split('.')[-1]} " if len(effect.parameters) > 1 else ""
        unit = "" if row.unit == "-" else f" {row.unit}"
        if key in finding.ranges:
            unit += f" (range {range_text(*finding.ranges[key])})"
        parts.append(f"{name}{number}{unit}")
    words = f"{finding.verdict}  {', '.join(parts)}"
    return words + (f", from {effect.source}" if effect.source else "")


def clock_error_words(correction: Correction) -> str:
    """What a clock was out by, in words."""
    parts = []
    for key, value in correction.values.items():
        around = ""
        if key in correction.stderr:
            around = f" ± {two_digits(correction.stderr[key])}"
        unit, late, early = LATE[key]
        way = late if value > 0 else early
        parts.append(f"{abs(value):.1f}{around} {unit} {way}")
    return ", ".join(parts)


def failed_criterion(finding: Finding) -> str:
    """The criterion by which a finding was not added; "" if it has none."""
    return finding.failed.criterion if finding.failed is not None else ""
