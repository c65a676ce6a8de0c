"""What each candidate is worth by itself, its ties, and what stands in its way."""

from pvlib_fem.loop.evidence import Weight
from pvlib_fem.reasons import Reason, because


def ranked(found, days):
    """
    Weight, ties and what stands in the way, of all candidates.

    Each is weighed conditional on the confounders that any misfit leaves.

    Returns
    -------
    dict
        Name to (Weight or None, tuple of str, Because or None).
    """
    given = found.confounders
    rows = {name: (None, (), why) for name, why in found.failed.items()}
    weights = {name: found.weigh(name, given) for name in found.effects}
    good = {name: w.gain for name, w in weights.items() if possible(w)}
    for name, weight in weights.items():
        if not isinstance(weight, Weight):
            rows[name] = (None, (), weight)
            continue
        ties = found.ties(name, good, given) if name in good else ()
        rows[name] = (weight, ties, hindrance(found, name, weight, days))
    return rows


def possible(weight):
    return isinstance(weight, Weight) and weight.possible


def hindrance(found, name, weight, days):
    """What stands in the way of a candidate, if anything does."""
    effect, least = found.effects[name], found.criteria.enough_days
    if not weight.possible and weight.gain > 0:
        there = {key.split(".")[0] for key in found.base}
        if effect.confounder or there & {*effect.confused_with}:
            return because(Reason.ANOTHER_CONFOUNDER)
        if "p_dc" in effect.drivers:  # power measures irradiance, too
            return because(Reason.SUSPECT_IRRADIANCE)
        return because(Reason.SUSPECT_SENSOR)
    if days < least:
        return because(Reason.TOO_SHORT, days=days, least=least)
    if "source" in effect.settings:
        return because(Reason.SOURCE, source=effect.settings["source"])
    return None


def as_row(weight, ties, why):
    """A row of the table."""
    note = {"note": "" if why is None else str(why)}
    if weight is None:
        return note
    return {
        "gain": weight.gain,
        "p_value": weight.p_value,
        "coefficients": weight.coefficients,
        "stderr": weight.stderr,
        "physical": weight.possible,
        "minimum_detectable": weight.minimum_detectable,
        "rows": weight.rows,
        "ties": ties,
        **note,
    }
