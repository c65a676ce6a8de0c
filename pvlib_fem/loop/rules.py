"""The rules that an effect passes by itself: its size, its chance, its bounds."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from pvlib_fem.findings import Check
from pvlib_fem.reasons import Because, Reason, because
from pvlib_fem.statistics.clusters import root


@dataclass(frozen=True, eq=False)
class Weighing:
    """What candidates are worth beside what is given, and which rules they pass."""

    found: Any  # evidence
    given: tuple  # names beside which they are weighed
    weights: dict  # by name
    asked: dict  # checks of each by itself
    lost: frozenset  # names that can be no more than in a class

    @classmethod
    def of(cls, found, names, given, spill=0.0, lost=()):
        """The candidates of some names."""
        weights = weighed(found, names, given)
        asked = {n: rules(found, n, w, given, spill) for n, w in weights.items()}
        return cls(found, tuple(given), weights, asked, frozenset(lost))

    @cached_property
    def standing(self):
        """Weights of those that may be told by themselves."""
        return {n: w for n, w in self.weights.items() if n not in self.lost}

    @cached_property
    def good(self):
        """Gains of those that are no accident, possible, and as large as they are."""
        names = (n for n in self.standing if all_pass(self.asked[n][1:]))
        return gaining(self.standing, names)

    @cached_property
    def best(self):
        """The one that gains most, or None."""
        return max(self.good, key=self.good.get, default=None)

    @cached_property
    def sure(self):
        """Whether the best one is material, too."""
        return self.best is not None and all_pass(self.asked[self.best])

    @cached_property
    def hidden(self):
        """
        What has a driver of its own and gains most of what may be chance, or None.

        A larger cause that nobody declared makes a gain uncertain: beside it the chance
        may be small.
        """
        others = {}
        for name in self.standing:
            if has_driver(self.found.effects[name]):
                checks = self.asked[name]
                others[name] = [c for c in checks if c.criterion != "chance"]
        gains = gaining(self.weights, (n for n in others if all_pass(others[n])))
        return max(gains, key=gains.get, default=None)


def has_driver(effect):
    """Whether an effect follows a column of its own, by which it may be named."""
    return not (effect.confounder or effect.channel)


def weighed(found, names, given):
    """Weights of those names that can be weighed."""
    weights = {name: found.weigh(name, given) for name in names}
    return {name: w for name, w in weights.items() if not isinstance(w, Because)}


def gaining(weights, names):
    """Gains of those of some names that gain anything."""
    return {name: weights[name].gain for name in names if weights[name].gain > 0}


def rules(found, name, weight, given, spill=0.0):
    """The checks of a candidate by itself: its size, its chance, its bounds."""
    limits, change = found.criteria, bool(found.effects[name].channel)
    gain = gained(found, name, given, spill)
    checks = [
        gain,
        Check(
            f"chance among {weight.family} hypotheses",
            "change_chance" if change else "chance",
            found.chance(weight),
            limits.change_chance if change else limits.chance,
            most=True,
        ),
        Check("coefficients are possible", "bound_slack", float(weight.possible), 1.0),
    ]
    if change:
        size = gain.statistic
        share = (max(weight.gain, 0.0) / size) ** 2 if size > 0 else 0.0
        share = Check("share kept beside confounders", "tied", share, limits.tied)
        checks.append(share)
    if "windows" in found.effects[name].settings:
        checks += without_snow(found, name, weight, given)
    return tuple(checks)


def without_snow(found, name, weight, given):
    """
    The check that what a window of the sky takes is there while no snow lies, too.

    Where the sun is low a window of the sky may be a winter's, and what is lost in it
    snow. It fails where it is surely less than half without snow of what it is with it.
    Before the sensor an obstacle's share is negative.
    """
    if found.snowy is None or name in found.partial:
        return []
    parted = found.parted(name, found.snowy, given)
    if parted is None:
        return []
    shares, covariance = parted
    (whole,) = weight.coefficients.values()
    ways = np.sign(whole) * np.array([-found.criteria.structure_keeps, 1.0])
    distance = float(ways @ shares / np.sqrt(ways @ covariance @ ways))
    words = "without snow it is more than half of what it is with it"
    least = -found.criteria.bound_errors
    return [Check(words, "bound_errors", distance, least, unit="standard errors")]


def gained(found, name, given, spill=0.0):
    """The check that an effect is material."""
    counted = beside(found, name, given)
    floor = material(found, counted, spill)
    criterion = "min_gain" if floor <= found.criteria.min_gain**2 else "min_share"
    size, least = root(found.gain(name, counted)), float(np.sqrt(floor))
    return Check("gain", criterion, size, least, unit="K")


def in_the_end(names, found, step):
    """
    By name, the check that a finding is material beside all others of the model.

    It was weighed beside what was found so far, and in one round with what a fit spoke
    against later. Confounders are not asked once more: their tangents at a model that
    has the effect hold some of it. The one that is worth least comes first. Of what is
    held or at a bound no tangent is there.
    """
    effects = {effect.name: effect for effect in step.model.effects}
    fitted, checks = {*found.base}, {}
    for name in names:
        if not fitted >= {*effects[name].rows()}:
            continue
        less = found.lacking(effects[name], step.coefficients)
        check = gained(less, name, [])
        size, least = check.statistic, check.threshold
        checks[name] = check, because(Reason.TAKEN_OVER, gain=size, least=least)
    return dict(sorted(checks.items(), key=lambda one: one[1][0].statistic))


def material(found, given, spill=0.0):
    """Fall of the mean square that is worth an effect. [K²]"""
    criteria = found.criteria
    return max(criteria.min_gain**2, criteria.min_share * found.left(given), spill)


def beside(found, name, given):
    """
    Beside what the gain of an effect is what it is worth.

    A confounder is the rival of whatever has no driver. What has one, or a date and a
    channel, has that to be told by: confounders part it from what comes with the
    weather and the seasons, and those that are not found are not in the model to which
    it is added. A driver has to keep more beside them than a change, to which all of
    its rivals are put.
    """
    given = [other for other in given if other != name]
    if found.effects[name].confounder:
        return given
    confounders = found.confounders
    bare = [other for other in given if other not in confounders]
    if found.effects[name].channel:
        return bare
    alone, kept = found.gain(name, bare), found.gain(name, given)
    if kept < found.criteria.structure_keeps * alone:
        return given
    # some effects show only where others are taken off
    larger = kept / material(found, given) > alone / material(found, bare)
    return given if larger else bare


def all_pass(checks):
    return all(check.passed for check in checks)
