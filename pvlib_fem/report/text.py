"""The printed report of a closed loop."""

import numpy as np

from pvlib_fem.findings import Kind, Verdict
from pvlib_fem.plotting.steps import BASES
from pvlib_fem.report.document import rounded
from pvlib_fem.report.page import by_reason

NEVER = (
    "absorptance, irradiance gain, mean rear irradiance: all are k",
    "sensor height, mean shelter: both are the wind's coefficient",
    "offsets of either thermometer, mean sky: all are the bias",
    "drifts of sensor gain, absorptance, contact at the back: sensitivity_drift by day",
)


WIDE = 24  # characters of the first column of the report
#: what the numbers of a clock are: unit, and words for either sign
LATE = {
    "late": ("min", "late", "early"),
    "drift": ("s", "later each day", "earlier each day"),
    "summer": ("min", "late in summer", "early in summer"),
}


CORRECTED = "clock corrected"  # row of the table
TITLES = {Verdict.CLASS: "cannot tell", Verdict.SUGGESTIVE: "suggestive"}


def lines(loop):
    """Lines of the printed report."""
    fit = loop.fit
    record = fit.summary
    step, days = record.step, record.days
    width = f"{step / 60:g} min" if step >= 60 else f"{step:g} s"
    yield (
        f"pvlib_fem: the loop on {days} day{'s' if days > 1 else ''} at {width} · "
        f"{record.rows:,} rows "
        f"· {fit.test_days} test days · {fit.model}, {fit.dynamics}"
    )
    head = ("RMSE", "day", "night", "MBE")
    part = "test" if fit.test_days else "train"
    shown = (f"rmse_{part}", "rmse_test_day", "rmse_test_night", f"mbe_{part}")
    cells = "".join(f"{name:>7}" for name in head)
    yield f"{'step':<{WIDE}}{cells}  energy error  verdict"
    verdicts = {f"+{f.effect}": f for f in loop.findings if f.added}
    for name, row in loop.table.iterrows():
        cells = "".join(cell(row[key], 7) for key in shown)
        cells += cell(row["energy_error_test"], 9) + " %"
        title = BASES.get(name, name.replace("+", "+ ", 1))
        words = verdict(verdicts[name], loop) if name in verdicts else ""
        if name == CORRECTED:
            own = [one for one in loop.corrections if one.unit == "K"]
            words = "; ".join(map(corrected, own))
        yield f"{title:<{WIDE}}{cells}    {words}".rstrip()
    for finding in loop.unexplained:
        yield f"{'left':<{WIDE}}{finding.why}"
    for finding in loop.findings:
        if finding.verdict in TITLES:
            alone = finding.candidates == (finding.effect,)
            names = " | ".join(finding.candidates)
            if alone and finding.verdict is Verdict.CLASS:
                names += " or its like"  # of which the catalogue has none
            words = f"{names} ({finding.gain:.2f} K): {finding.why}"
            rule = f" [{finding.failed.criterion}]" if failed_rule(finding) else ""
            yield f"{TITLES[finding.verdict]:<{WIDE}}{words}{rule}"
    for one in loop.corrections:
        title = "corrected" if one.applied else "not corrected"
        yield f"{title:<{WIDE}}{one.why}"
    for why, names in by_reason(loop.untestable).items():
        yield f"{'not testable':<{WIDE}}{', '.join(names)} ({why})"
    for i, words in enumerate(NEVER):
        yield f"{'' if i else 'never from these columns':<{WIDE}}  {words}"
    if not fit.test_days:
        yield f"{'note':<{WIDE}}no test days: these are errors of the fitted days"
    yield from (f"{'note':<{WIDE}}{note}" for note in loop.notes)


def cell(value, width):
    return f"{'–':>{width}}" if np.isnan(value) else f"{value:>z{width}.2f}"


def verdict(finding, loop):
    """Words behind the row of an added effect."""
    (effect,) = [e for e in loop.fit.effects if e.name == finding.effect]
    parts = []
    for key, row in effect.rows().items():
        value, error = finding.coefficients[key], finding.stderr[key]
        digits = max(0, 1 - int(np.floor(np.log10(error)))) if error > 0 else 3
        name = f"{key.split('.')[-1]} " if len(effect.parameters) > 1 else ""
        unit = "" if row.unit == "-" else f" {row.unit}"
        parts.append(f"{name}{value:.{min(digits, 6)}f} ± {error:.2g}{unit}")
    words = f"{finding.verdict}  {', '.join(parts)}"
    # of a column of the user's own it says nothing but the column's unit
    if len(effect.parameters) == 1 and finding.kind is not Kind.COLUMN:
        (row,) = effect.parameters.values()
        words += f" ({row.lower:.3g} … {row.upper:.3g})"
    return words + (f", from {effect.source}" if effect.source else "")


def corrected(correction):
    """What a clock was out by, in words."""
    parts = []
    for key, value in correction.values.items():
        around = ""
        if key in correction.stderr:
            around = f" ± {rounded(correction.stderr[key])}"
        unit, late, early = LATE[key]
        way = late if value > 0 else early
        parts.append(f"{abs(value):.1f}{around} {unit} {way}")
    return ", ".join(parts)


def failed_rule(finding):
    """Whether a finding was not added by a rule that has a criterion."""
    return finding.failed is not None and finding.failed.criterion
