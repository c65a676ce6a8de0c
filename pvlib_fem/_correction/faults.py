"""Which findings of a loop are taken out of its record."""

from collections.abc import Mapping, Sequence
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


def faults_to_correct(loop: Any, resolve: Any) -> list:
    """
    The findings in the model as faults, ambiguous ones by the member to apply.

    Parameters
    ----------
    loop : Loop
    resolve : str, sequence of str, or dict of str
        Causes of ambiguous findings; a dict has them by the finding.

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
    added = [finding for finding in loop.finding_objects if finding.added]
    causes = causes_by_finding(added, resolve)
    effects = {effect.name: effect for effect in loop.fit.effects}
    faults = []
    for finding in filter(is_of_instrument, added):
        cause = causes.get(finding.effect)
        if len(finding.candidates) > 1 and cause is None:
            words = " | ".join(finding.candidates)
            why = f"it is ambiguous: {words}; name the cause with resolve= (--resolve)"
            faults.append(Fault(finding.effect, why=why))
        elif cause in (None, finding.effect):
            faults.append(Fault.from_finding(effects[finding.effect], finding))
        else:  # snow has no numbers where no column shows it
            member = finding.members.get(cause, Member({}, {}, {}, {}))
            effect = find({"name": cause, **member.settings})
            faults.append(Fault.from_finding(effect, member))
    return faults


def causes_by_finding(added: Sequence[Finding], resolve: Any) -> dict[str, str]:
    """
    The given cause of each finding, if there is one.

    Parameters
    ----------
    added : sequence of Finding
        Findings in the model.
    resolve : str, sequence of str, or dict of str
        Causes: for all findings that have them as candidates, as ``"cause"``, or for
        one finding, as ``{"finding": "cause"}`` or ``"finding=cause"``.

    Returns
    -------
    dict of str
        By the name of the finding; none where no cause is given.

    Raises
    ------
    ValueError
        If a name is no candidate, or a finding has two causes.
    """
    if isinstance(resolve, Mapping):
        resolve = [f"{finding}={cause}" for finding, cause in resolve.items()]
    causes: dict[str, str] = {}
    for given in [resolve] if isinstance(resolve, str) else resolve:
        *one, cause = (in_new_names(name) for name in given.split("=", 1))
        meant = [f for f in added if cause in f.candidates and one in ([], [f.effect])]
        if not meant:
            several = (f for f in added if len(f.candidates) > 1)
            there = [f"{f.effect} ({' | '.join(f.candidates)})" for f in several]
            raise ValueError(
                f"resolve has {given!r}, which is no candidate of an ambiguous "
                f"finding; there are {', '.join(there) or 'none'}"
            )
        for finding in meant:
            known = causes.setdefault(finding.effect, cause)
            if known != cause:
                raise ValueError(
                    f"resolve has {known} and {cause}, which are candidates of one "
                    "finding; give one of them, or name the finding of each, as "
                    f"{finding.effect}={known}"
                )
    return causes


def is_of_instrument(finding: Finding) -> bool:
    """Whether a finding may be a fault of an instrument, or a change of a mounting."""
    known = [EFFECTS[name] for name in finding.candidates if name in EFFECTS]
    return any(repair_of(effect) or effect.sensor_fault for effect in known)
