"""What is left when all is said: hints, unknown structure, what could not be seen."""

from pvlib_fem.drivers import needed_for
from pvlib_fem.effects import EFFECTS
from pvlib_fem.effects.courses import once_more
from pvlib_fem.findings import Check, Finding, Kind, Verdict
from pvlib_fem.loop.rules import all_pass, material, rules
from pvlib_fem.loop.structure import structure
from pvlib_fem.reasons import Reason, because
from pvlib_fem.record.columns import GEOMETRY


def hints(case, found, rows, findings, aside, changes):
    """Gains worth a word that were not enough for more."""
    limits, days = case.criteria, case.days
    done = {name for finding in findings for name in finding.candidates}
    rows = sorted(rows.items(), key=lambda row: -row[1][0].gain if row[1][0] else 0.0)
    for name, (weight, ties, _) in rows:
        if name in done or weight is None or weight.gain < limits.hint_gain:
            continue
        effect = found.effects[name]
        if effect.channel and (done & {*ties} or once_more(effect, changes)):
            continue  # another course or channel says the same
        gain, *others = rules(found, name, weight, found.confounders)
        if gain.statistic < limits.hint_gain or not all_pass(others):
            continue
        why, checks = (
            because(Reason.NOT_MATERIAL, least=gain.threshold),
            (*others, gain),
        )
        if name in aside:
            why, checks = because(Reason.STRUCTURE_EXPLAINS), aside[name]
        elif gain.passed:
            why = because(Reason.LESS_GIVEN)
        if not case.enough:
            least = limits.enough_days
            why = because(Reason.TOO_SHORT, days=days, least=least)
            checks = (*checks, Check("days", "enough_days", days, least))
        done.update((name, *ties))
        yield Finding(
            name,
            (name, *ties),
            Verdict.SUGGESTIVE,
            gain.statistic,
            weight.coefficients,
            weight.stderr,
            why,
            checks,
            Kind.of(effect),
        )


def tables_left(case, found, by):
    """Tables of what no effect explains, the strongest first, and what is material."""
    limits, given = case.criteria, []
    for i in range(limits.most_structures):
        table = structure(case, found, given, by)
        floor = material(found, given)
        if table is None or table.gain**2 < floor:
            return
        yield table, floor
        found = found.with_column(f"unknown:{i}", table.values)
        given.append(f"unknown:{i}")


def unexplained(table, floor):
    """The finding of a table that no effect explains."""
    return Finding(
        table.name,
        table.drivers,
        Verdict.UNKNOWN,
        table.gain,
        {"mean": table.size},
        {},
        because(Reason.UNEXPLAINED, gain=table.gain, where=table.where),
        (Check("gain", "min_gain", table.gain, floor**0.5, unit="K"),),
        Kind.STRUCTURE,
        table.ranges,
        table.where,
    )


def not_seen(case, found, rows, findings):
    """Why this record could not see what it did not show, by name."""
    said = {name for finding in findings for name in finding.candidates}
    for name, (weight, _, why) in rows.items():
        if weight is None:
            if why.reason is not Reason.NO_DATE:  # tried, and there is no such change
                yield name, why
            continue
        effect = found.effects[name]
        if columns := better_sources(effect):
            yield name, because(Reason.STAND_IN, columns=columns)
        elif name in said:
            continue
        elif not weight.possible and weight.gain > 0:
            yield name, why
        elif weight.minimum_detectable > case.criteria.min_gain:
            yield name, because(Reason.DETECTABLE, gain=weight.minimum_detectable)


def better_sources(effect):
    """Columns with which it would have a driver, where it stands in without one."""
    forms = EFFECTS.get(effect.name, effect).forms
    driven = [form for form in forms if not form.confounder]
    if not effect.confounder or not driven:
        return []
    needed = [name for form in driven for name in needed_for(form.drivers)]
    return sorted({*needed} - {*GEOMETRY})
