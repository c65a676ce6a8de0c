"""A loop in at most 25 lines: conclusion, steps, findings and what to do."""

from collections.abc import Iterator
from textwrap import TextWrapper
from typing import TYPE_CHECKING

import numpy as np

from pvlib_fem._findings import PREDICTED
from pvlib_fem._report.ceiling_text import ceiling_sentence
from pvlib_fem._report.formatting import two_digits
from pvlib_fem._report.loop_text import number_cell, record_length
from pvlib_fem._statements.clock_sentences import PLACE
from pvlib_fem._statements.make import PATTERN, STUCK
from pvlib_fem._statements.statement import Statement
from pvlib_fem.plotting._step_plots import step_name
from pvlib_fem.quality._detached_sensor import DETACHED

if TYPE_CHECKING:
    from pvlib_fem._loop.results.loop_result import Loop

LINES, WIDTH = 25, 100
MOST_EFFECTS = 4
FIRST = 3  # statements for which there is always room: longer ones are cut
MORE = "loop.report() (--details) has every check, hint and note."


def summary(loop: "Loop") -> list[str]:
    """
    The lines of ``print(loop)``.

    Parameters
    ----------
    loop : Loop

    Returns
    -------
    list of str
        At most 25, none wider than 100 signs.
    """
    statements = loop.statement_objects
    words = [
        line for one in conclusion(loop, statements) for line in wrapped_lines(one)
    ]
    head = [*heading(loop), *words, "", *steps(loop), ""]
    room = LINES - len(head) - 2
    body = findings(statements, room)
    return [*head, *body, MORE]


def heading(loop: "Loop") -> Iterator[str]:
    fit, record = loop.fit, loop.fit.summary
    yield from wrapped_lines(
        f"pvlib_fem: the loop on {record_length(record)}, "
        f"{record.start:%Y-%m-%d} to {record.end:%Y-%m-%d}, {record.rows:,} rows; "
        f"{fit.model}, {fit.dynamics}{replacements_line(loop)}"
    )


def replacements_line(loop: "Loop") -> str:
    """What was not measured, and what stands for it."""
    calm = "wind_speed" not in loop.fit.summary.columns
    words = "; no wind_speed" * calm
    if loop.transposition:
        words += f"; poa_global transposed from ghi ({loop.transposition})"
    for one in loop.stand_ins:
        words += f"; {one.column} stands in for {one.usual}"
    return words


def error_days(loop: "Loop") -> tuple[str, str]:
    """The days that the errors are of, and the ending of their columns."""
    if days := loop.fit.test_days:
        return f"{days} test day{'s' * (days > 1)}", "test"
    return "the fitted days (there are no test days)", "train"


def conclusion(loop: "Loop", statements: list[Statement]) -> Iterator[str]:
    """
    How good the model was and is, what was found, and what remains.

    Parameters
    ----------
    loop : Loop
        Loop with or without its rows.
    statements : list of Statement
        All statements of the loop, see :func:`.statements_of`.

    Yields
    ------
    str
        A sentence on the errors, one on the findings, and one on the ceiling if it is
        known.
    """
    which, end = error_days(loop)
    error, energy = loop.table[f"rmse_{end}"], loop.table["energy_error_test"]
    before, after = error[loop.base], error[loop.last]
    if loop.last == loop.base:
        words = f"{before:.2f} K; no effect was added"
    else:
        words = f"{before:.2f} → {after:.2f} K"
    if loop.patterns:
        words += f" ({error.iloc[-1]:.2f} K with patterns)"
    if np.isfinite(energy[loop.last]):
        both = dict.fromkeys(f"{energy[n]:.2f}" for n in (loop.base, loop.last))
        words += f"; energy error: {' → '.join(both)} %"
    yield f"Error (RMSE) on {which}: {words}."
    yield counted_findings(loop, statements)
    if loop.known_ceiling is not None:
        yield ceiling_sentence(loop.known_ceiling)


def counted_findings(loop: "Loop", statements: list[Statement]) -> str:
    """What was found and what remains, by numbers."""
    if not loop.weighed:
        return "The record is too short to weigh any effect."
    stuck, detached = (
        sum(one.cause == cause for one in statements) for cause in (STUCK, DETACHED)
    )
    verdicts = [one.verdict for one in statements if one.cause != STUCK]
    corrected = sum(verdict.endswith("corrected") for verdict in verdicts)
    placed = sum(one.device == PLACE for one in statements)
    counts = {
        "clock fault": corrected - placed,
        "wrong coordinate or angle": placed,
        "module temperature sensor that came off": detached,
        "irradiance sensor that was stuck": stuck,
        "identified cause": verdicts.count("identified"),
        "ambiguous finding": verdicts.count("ambiguous"),
        PATTERN: sum(one.device == PATTERN for one in statements),
        "hint": verdicts.count("hint"),
    }
    parts = [f"{n} {words}{'s' * (n > 1)}" for words, n in counts.items() if n]
    words = f"Found: {', '.join(parts)}." if parts else "No cause was found."
    days, least = loop.fit.summary.days, loop.criteria.min_days
    if days < least:
        words += f" At least {least} days are needed to identify one (here {days})."
    return words


def steps(loop: "Loop") -> Iterator[str]:
    """The table of errors: models without effects, then the last effects."""
    _, end = error_days(loop)
    keys = (f"rmse_{end}", "rmse_test_day", "rmse_test_night", f"mbe_{end}")
    yield f"{'error [K]':<26}" + "".join(
        f"{n:>8}" for n in ("RMSE", "day", "night", "MBE")
    )
    names = [*loop.table.index]
    effects = names[names.index(loop.base) + 1 :]
    first = [n for n in ("steady", "fem") if n in names and n != loop.base]
    causes = [name for name in effects if name != PREDICTED]
    others = [name for name in effects if name == PREDICTED]
    for name in [*first, loop.base, *causes[-MOST_EFFECTS:], *others]:
        row = loop.table.loc[name]
        cells = "".join(number_cell(row[key], 8) for key in keys)
        yield f"{step_name(name):<26}{cells}"


def findings(statements: list[Statement], room: int) -> list[str]:
    """
    Numbered statements, as many as there is room for, and how many more.

    A long one is cut, its action first, so that it does not hide the next.
    """
    lines, most = [], max(room // FIRST, 1)
    for i, one in enumerate(statements):
        sizes = [f"{one.gain:.2f} K"] if np.isfinite(one.gain) else []
        if np.isfinite(one.energy):
            sizes.append(f"{two_digits(one.energy)} kWh/kWp a year")
        worth = f" [{', '.join(sizes)}]" if sizes else ""
        words = f"{one.text}{worth}. {one.certainty.rstrip('.')}".rstrip(". ")
        action = f" → {one.action}." if one.action else ""
        words = f"{i + 1:>2}. {words}."
        block = wrapped_lines(words + action, "    ")
        if len(block) > most:
            block = wrapped_lines(words, "    ", most)
        if len(block) > room - len(lines):
            rest = len(statements) - i
            more = f"{rest} more {'is' if rest == 1 else 'are'} in loop.statements."
            return [*lines, f"    {more}"]
        lines += block
    return lines


def wrapped_lines(text: str, indent: str = "", most: int | None = None) -> list[str]:
    """Lines of a text, none wider than a window; at most so many, if that is given."""
    wrapper = TextWrapper(
        WIDTH,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
        drop_whitespace=True,
        max_lines=most,
        placeholder=" ...",
    )
    return wrapper.wrap(text)
