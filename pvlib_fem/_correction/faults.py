"""Which findings of a loop are taken out of its record."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from pvlib_fem._correction.repairs import repair_of
from pvlib_fem._findings import Finding, Member
from pvlib_fem._former_names import in_new_names
from pvlib_fem.effects import EFFECTS, find
from pvlib_fem.effects._effect import Effect


@dataclass(frozen=True, eq=False)
class Fault:
    """A finding that may be taken out of the record, or why it is not."""

    name: str
    effect: Effect | None = None
    coefficients: Mapping = field(default_factory=dict)
    stderr: Mapping = field(default_factory=dict)
    ranges: Mapping = field(default_factory=dict)
    why: str = ""

    @classmethod
    def from_finding(cls, effect: Effect, numbers: Finding | Member) -> "Fault":
        """Of an effect, with the numbers of a finding or of one of its members."""
        return cls(
            effect.name, effect, numbers.coefficients, numbers.stderr, numbers.ranges
        )


def faults_to_correct(loop: Any, resolve: tuple) -> list:
    """
    The findings in the model as faults, ambiguous ones by the member to apply.

    Parameters
    ----------
    loop : Loop
    resolve : str or sequence of str
        Causes of ambiguous findings.

    Returns
    -------
    list of Fault
        Findings that may be faults of instruments; an ambiguous one without
        a cause in ``resolve`` has a reason instead of an effect.

    Raises
    ------
    ValueError
        If ``resolve`` has a name that is no candidate, or two of one finding.
    """
    names = [resolve] if isinstance(resolve, str) else [*resolve]
    names = [in_new_names(name) for name in names]
    added = [finding for finding in loop.finding_objects if finding.added]
    there = [name for finding in added for name in finding.candidates]
    if strange := [name for name in names if name not in there]:
        known = [n for f in added if len(f.candidates) > 1 for n in f.candidates]
        raise ValueError(
            f"resolve has {strange[0]!r}, which is no candidate of an ambiguous "
            f"finding; there are {', '.join(known) or 'none'}"
        )
    effects = {effect.name: effect for effect in loop.fit.effects}
    faults = []
    for finding in filter(is_of_instrument, added):
        mine = [name for name in finding.candidates if name in names]
        if len(mine) > 1:
            raise ValueError(
                f"resolve has {' and '.join(mine)}, which are candidates of one "
                "finding; give one of them"
            )
        if len(finding.candidates) > 1 and not mine:
            words = " | ".join(finding.candidates)
            why = f"it is ambiguous: {words}; name the cause with resolve= (--resolve)"
            faults.append(Fault(finding.effect, why=why))
        elif not mine or mine[0] == finding.effect:
            faults.append(Fault.from_finding(effects[finding.effect], finding))
        else:
            member = finding.members[mine[0]]
            effect = find({"name": mine[0], **member.settings})
            faults.append(Fault.from_finding(effect, member))
    return faults


def is_of_instrument(finding: Finding) -> bool:
    """Whether a finding may be a fault of an instrument, or a change of a mounting."""
    known = [EFFECTS[name] for name in finding.candidates if name in EFFECTS]
    return any(repair_of(effect) or effect.sensor_fault for effect in known)
