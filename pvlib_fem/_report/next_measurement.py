"""What to measure next, from what a closed loop left open."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from pvlib_fem._findings import Kind, Verdict
from pvlib_fem._record.column_names import GEOMETRY
from pvlib_fem._report import budget_text as budget
from pvlib_fem.drivers import needed_for
from pvlib_fem.drivers._mounts import is_known
from pvlib_fem.effects import EFFECTS
from pvlib_fem.reasons import Reason

if TYPE_CHECKING:
    from pvlib_fem._loop.results.loop_result import Loop

#: what to give where the position of the sun is unknown
PLACE = "location, surface_tilt and surface_azimuth (to give, not to measure)"
CLOCK = "the clock of the file, set right (to mend, not to measure)"


def to_measure(loop: "Loop") -> list[tuple[str, str]]:
    """
    What would settle what is open, the most useful first.

    First what would decide a tie or a hint or name unknown structure, by how much
    of the error that is; then days to look up in the site's log; then columns that the
    record has not, by the number of effects that each would make testable; then more
    days. Of a record in which nothing could be weighed more days come first.

    Parameters
    ----------
    loop : Loop

    Returns
    -------
    list of (str, str)
        What to measure, and what it would show.
    """
    if not loop.weighed:
        return [*longer_record(loop), *missing_columns(loop)]
    return [
        *deciding_by_gain(loop),
        *logs_of_days(loop),
        *missing_columns(loop),
        *longer_record(loop),
    ]


def deciding_by_gain(loop: "Loop") -> list[tuple[str, str]]:
    """What would decide a tie or a hint, or name unknown structure, by its gain."""
    catalogue = EFFECTS | {effect.name: effect for effect in loop.fit.effects}
    items = []
    for finding in loop.finding_objects:
        gain = f"{finding.gain:.2f} K"
        if finding.kind is Kind.STRUCTURE:
            what = f"a column that records what happens {finding.place}"
            items.append((finding.gain, what, f"would name the cause of {gain}"))
        elif finding.verdict in (Verdict.AMBIGUOUS, Verdict.HINT):
            names = [n for n in finding.candidates if n in catalogue]
            words = dict.fromkeys(catalogue[n].decided_by for n in names)
            if what := " or ".join(word for word in words if word):
                why = f"would decide on {' or '.join(finding.candidates)}, {gain}"
                items.append((finding.gain, what, why))
    items.sort(key=lambda item: -item[0])
    return [(what, why) for _, what, why in items]


def logs_of_days(loop: "Loop") -> Iterator[tuple[str, str]]:
    """What was done on the days that stand out."""
    for days, words in budget.days_that_stand_out(loop):
        yield (
            f"what the site's log has of {days} (to look up)",
            f"would explain {words}",
        )


def missing_columns(loop: "Loop") -> Iterator[tuple[str, str]]:
    """Columns that the record has not, those first that make most effects testable."""
    there = loop.fit.summary.columns
    effects, reasons = {}, {}
    for name, why in loop.untestable.items():
        for needs in column_sets(name, there):
            effects.setdefault(needs, []).append(name)
            # a column may be there and of no use
            if any(reason.values.get("column") in needs for reason in why.all):
                reasons[needs] = f"; here {why}"
    for needs in sorted(effects, key=lambda needs: -len(effects[needs])):
        what = " and ".join(needs)
        if set(needs) <= set(GEOMETRY):
            what = CLOCK if is_known(loop.place) else PLACE
        yield what, f"would test {', '.join(effects[needs])}{reasons.get(needs, '')}"


def column_sets(name: str, there: Sequence[str]) -> list[tuple[str, ...]]:
    """Sets of columns, none within another, with any of which it could be tested."""
    sets = []
    for variant in EFFECTS[name].forms if name in EFFECTS else ():
        if variant.confounder != EFFECTS[name].confounder:
            continue  # a stopgap from the usual inputs
        needs = tuple(n for n in needed_for(variant.drivers) if n not in there)
        if not needs:  # it has been tested
            return []
        if needs not in sets:
            sets.append(needs)
    return [one for one in sets if not any(set(two) < set(one) for two in sets)]


def longer_record(loop: "Loop") -> Iterator[tuple[str, str]]:
    """What more days would show."""
    if not loop.weighed:
        yield "more days", "this record has too few to leave any out"
        return
    hidden = {
        name: why.values["gain"]
        for name, why in loop.untestable.items()
        if why.reason is Reason.DETECTABLE
    }
    if hidden:
        names = ", ".join(sorted(hidden, key=lambda name: hidden[name]))
        least, most = (f"{end(hidden.values()):.2f}" for end in (min, max))
        size = least if least == most else f"{least} to {most}"
        yield "more days", f"would show {names}, here from {size} K only"
