"""A loop's findings as statements, the most valuable first."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pvlib_fem._findings import (
    LEAST,
    OUTSIDE,
    OUTSIDE_WORDS,
    SNOW,
    CheckOutcome,
    Finding,
    Kind,
    Member,
    Verdict,
)
from pvlib_fem._report import budget_text as budget, event_text as events
from pvlib_fem._statements.causes import MODEL, MODULES, Clause, clause_of
from pvlib_fem._statements.clock_sentences import APPLIED, clock_statement
from pvlib_fem._statements.statement import DAYS, Statement, key_of
from pvlib_fem._statistics.axes import PAST, SINCE_RAIN
from pvlib_fem._thermal.steady_models import steady_model
from pvlib_fem.effects import find
from pvlib_fem.effects._effect import Effect, deciding_measurements
from pvlib_fem.effects._standstill import in_words
from pvlib_fem.effects._time_profiles import YEAR, date_text, day_number
from pvlib_fem.quality._detached_sensor import DETACHED, Detachment
from pvlib_fem.quality._tracker_standstill import Standing
from pvlib_fem.reasons import in_percent

if TYPE_CHECKING:
    from pvlib_fem._loop.results.loop_result import Loop

PATTERN = "unexplained pattern"
UNKNOWN = "An unknown cause acts much like this one, and is more probable"
MEASURE_STORE = (
    "Measure the temperature of what stores heat near the modules for hours, such as "
    "the roof, the ground or the cavity behind them"
)
MEASURE_WET = (
    "Measure the temperature of what stays wet after rain near the modules, such as "
    "the roof, the ground or the modules themselves"
)
#: what to measure, by inputs of the past hours, which no one can look up at a site
MEASURES = {**dict.fromkeys(PAST, MEASURE_STORE), SINCE_RAIN: MEASURE_WET}
RECORD_WIND = "Record wind_speed, and use a model that takes it, such as faiman"
#: what the catalogue has not, and looks as light that the irradiance sensor misses
REFLECTED = Clause(MODULES, "a surface nearby reflects light onto the modules")
#: what a change may be that is there only while snow can lie
SNOW_LAY = Clause(MODULES, "snow or ice altered the readings while it lay")
STOWED = "modules whose trackers are stowed in wind look the same"
HALF = 0.5  # what is more is most of it, such as of days or of probability
STUCK = "sensor_stuck"  # cause of a tracker's irradiance sensor that does not turn
LEFT_OUT = "left out"  # verdict of what is not used
#: what a statement has of its first clause
SIZE = ("value", "error", "low", "high", "unit", "since", "until")


def statements_of(loop: "Loop", energies: Mapping[str, float]) -> list[Statement]:
    """
    All statements of a loop.

    Parameters
    ----------
    loop : Loop
    energies : dict of float
        Energy that each cause changes, see :func:`.worth.energies`. [kWh/kWp per year]

    Returns
    -------
    list of Statement
        Clocks, a module temperature sensor that has come off and days on which the
        irradiance sensor does not turn; then causes in the model, events that power
        shows, unexplained patterns and days that stand out, by the energy that they
        change, or in this order where it is unknown; then hints.
    """
    findings = [f for f in loop.finding_objects if f.kind is not Kind.STRUCTURE]
    findings.sort(key=lambda finding: -finding.gain)
    causes, hints = (
        [finding_statement(f, loop) for f in findings if f.added == added]
        for added in (True, False)
    )
    clocks = map(clock_statement, loop.corrections)
    patterns = (pattern_statement(f, loop) for f in loop.unexplained)
    clocks, causes, patterns, days, hints = (
        [
            replace(one, energy=energies.get(key_of(one.cause, one.since), np.nan))
            for one in some
        ]
        for some in (clocks, causes, patterns, date_statements(loop), hints)
    )
    ranked = [*causes, *event_statements(loop), *patterns, *days]
    ranked.sort(key=lambda one: -np.nan_to_num(one.energy))  # equal ones keep the order
    standings = (standing_statement(one, loop.episodes) for one in loop.standings)
    detached = map(detachment_statement, loop.detachments)
    return [*clocks, *detached, *standings, *ranked, *hints]


def days_of(loop: "Loop") -> tuple[str, str]:
    """First and last day of a loop's record."""
    record = loop.fit.summary
    return f"{record.start:%Y-%m-%d}", f"{record.end:%Y-%m-%d}"


def finding_statement(finding: Finding, loop: "Loop") -> Statement:
    """
    A finding as a statement.

    Parameters
    ----------
    finding : Finding
        Finding of the loop that is not an unexplained pattern.
    loop : Loop
        Loop with the effects and the coefficients of its last fit.

    Returns
    -------
    Statement
        Without the energy that the finding changes.
    """
    own = {effect.name: effect for effect in loop.fit.effects}
    effects = [effect_of(name, finding, own) for name in finding.candidates]
    clauses = [
        clause_or_name(name, effect, finding, loop)
        for name, effect in zip(finding.candidates, effects)
    ]
    main, known = clauses[0], [effect for effect in effects if effect is not None]
    action = action_of(finding, clauses, known)
    outside = OUTSIDE_WORDS
    # light that modules have and the sensor has not may also be more of theirs
    unseen = any(effect.unseen_light for effect in known)
    unknown = finding.probabilities.get(OUTSIDE, 0.0)
    if unseen and unknown >= LEAST:
        clauses, outside = [*clauses, REFLECTED], "a reflection"
    device = " or ".join(dict.fromkeys(clause.device for clause in clauses))
    text = finding_sentence(finding, clauses)
    if unknown > HALF and not unseen and finding.verdict is Verdict.HINT:
        device = "unknown"
        text = f"{UNKNOWN}: {text[:1].lower()}{text[1:]}"
    return Statement(
        cause=finding.effect,
        device=device,
        verdict=str(finding.verdict),
        text=text,
        action=action,
        certainty=certainty_of(finding, outside),
        gain=finding.gain,
        probability=finding.probabilities.get(finding.effect, np.nan),
        alternatives=tuple(n for n in finding.candidates if n != finding.effect),
        **{name: getattr(main, name) for name in SIZE},
    )


def effect_of(name: str, finding: Finding, own: Mapping[str, Effect]) -> Effect | None:
    """The effect of a candidate with its settings; None if it is unknown."""
    if name == finding.effect and name in own:
        return own[name]
    member = finding.members.get(name)
    try:
        return find({"name": name, **(member.settings if member else {})}, own.values())
    except ValueError:
        return None


def clause_or_name(
    name: str, effect: Effect | None, finding: Finding, loop: "Loop"
) -> Clause:
    """A candidate as a clause; of an unknown effect, such as a hint of a column."""
    if name == SNOW and SNOW not in (finding.effect, *finding.members):
        return SNOW_LAY
    if effect is None:
        if finding.kind is Kind.COLUMN:
            return Clause(MODEL, f"the error follows {name}")
        return Clause(MODEL, f"the effect {name} is missing from the model")
    numbers = finding if name == finding.effect else finding.members.get(name)
    numbers = numbers or Member({}, {}, {}, {})
    clause = clause_of(effect, numbers, loop.fit.coefficients, *days_of(loop))
    if events.may_be_stowed(name, loop):
        return replace(clause, words=f"{clause.words}; {STOWED}")
    return clause


def finding_sentence(finding: Finding, clauses: list[Clause]) -> str:
    """The clauses of all causes with the dates of the first."""
    first, *others = clauses
    parts = [words_of(first, finding.place)]
    for other in others:
        same = (other.since, other.until, other.time_profile) == (
            first.since,
            first.until,
            first.time_profile,
        )
        parts.append(other.words if same else words_of(other))
    text = ", or ".join(parts)
    return f"{text[:1].upper()}{text[1:]}"


def words_of(clause: Clause, place: str = "") -> str:
    """A clause with its dates; ``place`` has the days between which it began."""
    if clause.time_profile == "step":
        return f"from {place or clause.since or 'some date'} on {clause.words}"
    if clause.time_profile == "episode":
        dates = f"from {clause.since} until {clause.until}" if clause.since else ""
        dates = f"from {place}" if place else dates or "for some time"
        return f"{dates} {clause.words}"
    if clause.time_profile == "drift" and not clause.until:
        return f"{clause.words} since {place or clause.since}"
    if clause.time_profile == "drift":
        dates = place or f"{clause.since} until {clause.until}"
        return f"from {dates} {clause.words}"
    return clause.words


def certainty_of(finding: Finding, outside: str = OUTSIDE_WORDS) -> str:
    """How sure a finding is, in words; ``outside`` are those of a cause outside."""
    checks = [
        f"{check.column} {'agrees' if agrees else 'contradicts ' + check.effect} "
        f"({check.reads})"
        for check in finding.conclusive_checks
        if (agrees := check.outcome is CheckOutcome.AGREES) or not finding.added
        if agrees or check.effect == finding.effect
    ]
    agree = f"; {', '.join(dict.fromkeys(checks))}" if checks else ""
    if finding.verdict is Verdict.IDENTIFIED:
        share = finding.probabilities.get(finding.effect)
        words = f" (probability {in_percent(share)})" if share is not None else ""
        return f"Identified{words}{agree}"
    if finding.verdict is Verdict.AMBIGUOUS:
        return f"Ambiguous{shares_of(finding, outside)}{agree}"
    return f"A hint, not in the model: {finding.why}"


def shares_of(finding: Finding, outside: str) -> str:
    """Probabilities of the causes in their order, and of a cause outside."""
    known = finding.probabilities
    parts = [in_percent(known[n]) for n in finding.candidates if n in known]
    if known.get(OUTSIDE, 0.0) >= LEAST:
        parts.append(f"{outside} {in_percent(known[OUTSIDE])}")
    return f" ({', '.join(parts)})" if parts else ""


def action_of(finding: Finding, clauses: list[Clause], effects: list[Effect]) -> str:
    """What to do about a finding."""
    if finding.verdict is Verdict.AMBIGUOUS and len(clauses) > 1:
        return f"To decide: {'; or '.join(deciding_measurements(effects))}"
    if finding.verdict is Verdict.HINT:
        return ""
    return clauses[0].action


def pattern_statement(finding: Finding, loop: "Loop") -> Statement:
    """
    An unexplained pattern as a statement.

    Parameters
    ----------
    finding : Finding
        The pattern; its coefficient ``mean`` is measured minus modelled. [K]
    loop : Loop
        That has the finding.

    Returns
    -------
    Statement
    """
    mean = finding.coefficients.get("mean", np.nan)
    way = "warmer" if mean > 0 else "colder"
    measures = [MEASURES[name] for name in finding.where if name in MEASURES]
    if not steady_model(loop.fit.model).takes_wind:
        measures.append(RECORD_WIND)
    return Statement(
        cause=finding.effect,
        device=PATTERN,
        verdict=str(finding.verdict),
        text=(
            f"Unexplained but repeatable: {finding.gain:.2f} K of the error is "
            f"{finding.place}, where the modules are {abs(mean):.2f} K {way} than "
            "modelled"
        ),
        action=(measures or [f"Record a quantity that changes {finding.place}"])[0],
        certainty="No known cause; loop.predict includes it" * bool(loop.patterns),
        gain=finding.gain,
        value=mean,
        unit="K",
    )


def event_statements(loop: "Loop") -> Iterator[Statement]:
    """Events of each kind as a statement."""
    days = loop.fit.summary.days
    for name, rows in events.by_kind(loop).items():
        kind, what = events.WORDS[name], events.happened(name, loop)
        first, last = rows["start"].min(), rows["end"].max()
        modelled = "; its effect on temperature is in the model" * (
            name in loop.effects
        )
        yield Statement(
            cause=name,
            device=kind.device,
            verdict=events.EVENT,
            text=(
                f"{what[:1].upper()}{what[1:]} "
                f"({events.all_of(rows)}), most from {events.event_words(rows.iloc[0])}"
            ),
            action=kind.action,
            certainty=f"Power shows it{modelled}",
            gain=float(np.hypot.reduce(rows["gain"])),
            energy=float(rows["energy"].sum(skipna=False) * YEAR / days),
            since=f"{first:%Y-%m-%d}",
            until=f"{last:%Y-%m-%d}",
        )


def standing_statement(standing: Standing, episodes: pd.DataFrame) -> Statement:
    """Days on which the irradiance sensor does not turn as a statement."""
    where = in_words(standing.surface_tilt, standing.surface_azimuth)
    alone = apart_on(standing, episodes) > HALF
    modules = ", while the modules went on or stood elsewhere" if alone else ""
    return Statement(
        cause=STUCK,
        device="tracker",
        verdict="corrected",
        text=(
            f"From {standing.when} the irradiance sensor was stuck {where}, and did "
            f"not follow the plane that the record describes{modules}"
        ),
        action="Check the drive of the tracker that the irradiance sensor is on",
        certainty=f"{APPLIED} ({standing.days} clear days show it)",
        since=standing.start,
        until=date_text(day_number(standing.end) - 1),
    )


def detachment_statement(one: Detachment) -> Statement:
    """
    A time in which the module's temperature sensor is off as a statement.

    Parameters
    ----------
    one : Detachment

    Returns
    -------
    Statement
        ``value`` is what it reads of the temperature rise beyond that of the module.
    """
    days = f"{one.days} sunny days show it"
    weeks = " of test weeks (the others do not show it alone)" * (not one.fitting)
    when = one.when
    return Statement(
        cause=DETACHED,
        device="module temperature sensor",
        verdict=LEFT_OUT,
        text=(
            f"{when[:1].upper()}{when[1:]} the module temperature sensor reads close "
            f"to air temperature: {1000.0 * one.rise:.1f} K above it in sun of "
            f"1000 W/m², and {1000.0 * one.attached:.0f} K while it was attached. It "
            "has come off"
        ),
        action="Fix the sensor to the back of the module",
        certainty=f"Left out: its {one.rows:,} rows{weeks}; {days}",
        value=100.0 * (one.rise / one.attached - 1.0),
        unit="%",
        since=one.start[:10],
        until=one.last[:10] if one.end else "",
    )


def apart_on(standing: Standing, episodes: pd.DataFrame) -> float:
    """Share of the days of a standstill on which the modules stand out."""
    first, last = day_number(standing.start), day_number(standing.end)
    some = (
        min(day_number(row["end"]) + 1, last) - max(day_number(row["start"]), first)
        for row in episodes.to_dict("records")
    )
    return sum(max(days, 0.0) for days in some) / (last - first)


def date_statements(loop: "Loop") -> Iterator[Statement]:
    """Days that stand out as statements."""
    for row in loop.episodes.to_dict("records")[: budget.MOST]:
        days, words = budget.episode_span(row), budget.deviation_by_day_and_night(row)
        yield Statement(
            cause=DAYS,
            device=MODULES,
            verdict="unexplained",
            text=(
                f"On {days} the modules were {words} "
                f"({100 * row['share']:.1f} % of the squared error)"
            ),
            action=f"Look up {days} in the site's log",
            since=f"{row['start']:%Y-%m-%d}",
            until=f"{row['end']:%Y-%m-%d}",
        )
