"""Whether a refit holds: by its own coefficients, and on the choosing weeks."""

from dataclasses import replace

import numpy as np

from pvlib_fem.findings import Check, Verdict, vouched
from pvlib_fem.reasons import Reason, because
from pvlib_fem.statistics.clusters import calendar_weeks

ERRORS = "standard errors"


def confirmed(finding, case, before, after, stderr):
    """
    The finding with what the refit says, withdrawn where that speaks against it.

    Parameters
    ----------
    finding : Finding
    case : Case
    before, after : Step
        The fit without it, and with it and all others.
    stderr : dict
        Standard errors of the latter.

    Returns
    -------
    Finding
        ``suggestive`` where one of the checks fails, of which it is the last.
    """
    for check, why in refit_checks(finding, case, before, after, stderr):
        if not check.passed:
            return refused(finding, check, why)
        finding = replace(finding, checks=(*finding.checks, check))
    return finding


def refused(finding, check, why):
    """The finding where it does not pass a check after all."""
    checks, verdict = (*finding.checks, check), Verdict.SUGGESTIVE
    return replace(finding, verdict=verdict, because=why, checks=checks)


def refit_checks(finding, case, before, after, stderr):
    """Checks of a refit, each with the reason of its failure."""
    rows = case.seen & np.isfinite(before.temperature)
    # the sun is always known, where it is not in the record
    names = [n for n in after.model.drivers if n in case.whole.inputs.columns]
    rows &= case.whole.known(names)
    lost = int(np.isnan(after.temperature[rows]).sum())
    yield (
        Check("rows without a temperature", "", lost, 0, most=True),
        because(Reason.NO_TEMPERATURE, rows=lost),
    )
    effects = {effect.name: effect for effect in after.model.effects}
    # a confounder that an effect with a driver has at a bound is what has to go
    some = effects[finding.effect].confounder
    asked = [e for e in effects.values() if some or not e.confounder]
    yield bounds({key for e in asked for key in e.rows()}, after)
    if not vouched(finding):  # by what knows nothing of these models, nor of their days
        yield sureness(finding, after.coefficients, stderr, case.criteria)
    yield choosing_check(*contradiction(case, before, after), case.criteria)


def bounds(names, step):
    """The check that none of some coefficients is at a bound, and why it fails."""
    bound = sorted({*names} & {*step.at_bound})
    return (
        Check("coefficients at a bound", "", len(bound), 0, most=True),
        because(Reason.AT_BOUND, coefficient=", ".join(bound)),
    )


def sureness(finding, values, stderr, criteria):
    """The check that its surest coefficient is not nothing, and why it fails."""
    sizes = {n: distance(values[n], stderr[n]) for n in finding.coefficients}
    name = max(sizes, key=sizes.get)
    size, least = sizes[name], criteria.sure
    return (
        Check("distance from nothing", "sure", size, least, unit=ERRORS),
        because(
            Reason.UNSURE, coefficient=name, value=values[name], error=stderr[name]
        ),
    )


def distance(value, error):
    """Standard errors from nothing; without an error, or held, it is no doubt."""
    return abs(value) / error if error > 0 else np.inf


def choosing_check(errors, rise, criteria):
    """The check that no error rises on the choosing weeks, and why it fails."""
    name, most = "rise on the choosing weeks", criteria.contradiction
    return (
        Check(name, "contradiction", errors, most, most=True, unit=ERRORS),
        because(Reason.CONTRADICTED, rise=rise, errors=errors),
    )


def contradiction(case, before, after):
    """By how much the choosing weeks speak against a step: :func:`rise_of`."""
    rows = case.choosing & np.isfinite(before.temperature + after.temperature)
    rows &= np.isfinite(before.measured + after.measured)  # a clock's ends have none
    squares = (
        (step.measured[rows] - step.temperature[rows]) ** 2 for step in (before, after)
    )
    return rise_of(*squares, np.ones(rows.sum()), case.whole.dates[rows], case.criteria)


def rise_of(before, after, rows, dates, criteria):
    """
    The rise of a mean square, from sums of squares over some rows of some dates each.

    In standard errors, from the spread between weeks, or days where there are few
    weeks; and the rise of the error in K. NaN without rows.
    """
    if not len(rows):
        return np.nan, np.nan
    rise = np.sqrt(after.sum() / rows.sum()) - np.sqrt(before.sum() / rows.sum())
    clusters = np.unique(calendar_weeks(dates), return_inverse=True)[1]
    if clusters.max() + 1 < criteria.fewest_clusters:
        clusters = np.unique(dates, return_inverse=True)[1]
    change = np.bincount(clusters, after - before)
    size = np.bincount(clusters, rows)
    mean = change.sum() / size.sum()
    count = len(size)
    if count < 2:
        return np.inf * np.sign(mean), float(rise)
    spread = np.sqrt(((change - mean * size) ** 2).sum() * count / (count - 1))
    errors = mean * size.sum() / spread if spread > 0 else np.sign(mean) * np.inf
    return float(errors) if mean else 0.0, float(rise)
