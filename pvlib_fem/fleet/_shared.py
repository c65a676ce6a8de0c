"""Find causes that systems of one site share, or that one system has alone."""

import json
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Self

import pandas as pd

from pvlib_fem.effects import CHANGES, EFFECTS
from pvlib_fem.effects._instruments import STATION
from pvlib_fem.fleet._tasks import JOIN

STATIONS = {name for name, effect in CHANGES.items() if effect.sensor_fault in STATION}
MODULES = {*CHANGES} - STATIONS
FEW = 3  # names that are shown of a longer list


@dataclass(frozen=True)
class SystemFinding:
    """A finding of a system, from a row of the table."""

    id: str
    candidates: set[str]
    gain: float
    first: str | None
    last: str

    @classmethod
    def from_row(cls, row: Mapping[Hashable, Any]) -> Self:
        dated = isinstance(row["first"], str)
        dates = (row["first"], row["last"]) if dated else (None, "")
        gain = row["gain"] if row["gain"] == row["gain"] else 0.0  # NaN for a clock
        return cls(row["id"], {*row["candidates"].split(JOIN)}, gain, *dates)


@dataclass
class Shared:
    """
    Findings of one site that may have one cause.

    Attributes
    ----------
    site : str
    candidates : set of str
        Candidates that all findings have in common.
    systems : dict of float
        Gain by id of the systems in which it was found. [K]
    also : set of str
        Systems that show it, too, but too weakly for a finding.
    without : set of str
        Systems that would show it at the largest of these gains, and do not.
    maybe : set of str
        Systems with another finding that may have this cause: at that time, or of one
        of its sensor faults and without a date.
    first, last : str
        Dates between which a change may have begun; None and "" without a date.
    """

    site: str
    candidates: set[str]
    systems: dict[str, float] = field(default_factory=dict)
    also: set[str] = field(default_factory=set)
    without: set[str] = field(default_factory=set)
    maybe: set[str] = field(default_factory=set)
    first: str | None = None
    last: str = ""

    def fits(self, finding: SystemFinding) -> bool:
        """Whether a finding may have this cause, at the same time."""
        if not self.candidates & finding.candidates:
            return False
        return (finding.first is None) == (self.first is None) and self.meets(finding)

    def meets(self, finding: SystemFinding) -> bool:
        """Whether the dates overlap, as far as they are known."""
        if self.first is None or finding.first is None:
            return True
        return finding.first <= self.last and self.first <= finding.last

    def take(self, finding: SystemFinding) -> None:
        self.candidates = self.candidates & finding.candidates
        before = self.systems.get(finding.id, finding.gain)
        self.systems[finding.id] = max(finding.gain, before)
        if finding.first is not None and self.first is not None:
            # one cause has one date, which is in the interval of each
            self.first = max(finding.first, self.first)
            self.last = min(finding.last, self.last)

    def may_be(self, finding: SystemFinding) -> bool:
        """Whether a finding of another group may still have this cause."""
        dated = None not in (self.first, finding.first)
        same = sensor_faults(self.candidates) & sensor_faults(finding.candidates)
        return self.meets(finding) and (dated or bool(same))

    def check(
        self,
        others: Mapping[str, Mapping[str, tuple[float, float]]],
        findings: Sequence[SystemFinding],
    ) -> None:
        """Sort the other systems into ``also``, ``without`` and ``maybe``."""
        self.maybe = {one.id for one in findings if self.may_be(one)} - {*self.systems}
        for identity, weighed in others.items():
            known = [weighed[name] for name in self.candidates if name in weighed]
            if identity in self.systems or not (known or (self.first and weighed)):
                continue  # every loop searches dates, whichever effects it tests
            # a dated change of another system would be among the findings
            if self.first is None and any(0.0 < least <= gain for gain, least in known):
                self.also.add(identity)
            elif identity not in self.maybe and all(
                least <= self.largest for _, least in known
            ):
                self.without.add(identity)
        self.maybe -= self.also

    @property
    def largest(self) -> float:
        return max(self.systems.values())

    @property
    def have(self) -> int:
        return len(self.systems) + len(self.also)

    @property
    def everywhere(self) -> bool:
        return self.have > max(len(self.maybe), 1) and not self.without

    @property
    def alone(self) -> bool:
        return self.have == 1 and len(self.without) > len(self.maybe)

    @property
    def likely(self) -> list[str]:
        """Candidates that agree with its occurrence in all systems, or in one alone."""
        if not self.candidates <= {*CHANGES}:
            return []
        side = STATIONS if self.everywhere else MODULES if self.alone else set()
        return sorted(self.candidates & side)

    @property
    def words(self) -> str:
        """Number of systems with the cause, and the suspected component."""
        some = f" ({few_names(self.likely, ' or ', ' or ')})" if self.likely else ""
        more = f", and perhaps {len(self.maybe)} more" if self.maybe else ""
        tested = self.have + len(self.without) + len(self.maybe)
        if self.alone:
            one = f"this one{more}" if more else "this one alone"
            few = len(self.without)
            words = f"{one}, and not {few} other{'s' * (few > 1)} that would show it"
            return f"{words}: suspect its module, sensor or surroundings{some}"
        count = f"{self.have} of {tested}{more}"
        if not self.everywhere:
            return count if tested > 1 else "no other can show it"
        count = count if more else f"all {tested} that can show it"
        if self.candidates <= MODULES:
            return f"{count}: a change of all modules at once"
        if self.candidates & ({*EFFECTS} - {*CHANGES}):
            return f"{count}: an effect on all modules there, or the station"
        return f"{count}: suspect the station{some}"


def shared_causes(systems: pd.DataFrame, findings: pd.DataFrame) -> list[Shared]:
    """
    Causes of each site that has more systems than one.

    Findings have one cause if they share a candidate and, if they have dates, their
    intervals have a day in common. A system counts as without it only if its record
    would show an equal gain, and if it has no finding that may have this cause: at that
    time, or of one of its sensor faults and without a date.

    Parameters
    ----------
    systems, findings : DataFrame
        Tables of :class:`pvlib_fem.fleet.Results`.

    Returns
    -------
    list of Shared
        First changes of a station or of one module, then causes that all systems of a
        site have, each by decreasing gain.
    """
    done = systems[(systems["state"] == "done") & (systems["site"] != "")]
    added = findings[findings["added"]].sort_values("id", kind="stable")
    rows = dict(list(added.groupby("site")))
    causes: list[Shared] = []
    for site, members in done.groupby("site", sort=True):
        if len(members) < 2 or site not in rows:
            continue
        mine = [SystemFinding.from_row(row) for row in rows[site].to_dict("records")]
        groups = grouped_by_cause(str(site), mine)
        weighed = {
            row["id"]: gains_by_effect(row["weighed"])
            for row in members.to_dict("records")
        }
        for group in groups:
            group.check(weighed, mine)
        causes += groups
    return sorted(causes, key=order_of_group)


def grouped_by_cause(site: str, findings: Sequence[SystemFinding]) -> list[Shared]:
    """Findings of a site, grouped by cause; the largest gain begins a group."""
    groups: list[Shared] = []
    for one in sorted(findings, key=lambda one: (-one.gain, one.first or "", one.last)):
        same = [group for group in groups if group.fits(one)]
        if not same:
            same = [Shared(site, one.candidates, first=one.first, last=one.last)]
            groups += same
        same[0].take(one)
    return groups


def sensor_faults(names: Iterable[str]) -> set[str]:
    """Sensor faults of some candidates; other effects by their names."""
    return {CHANGES[name].sensor_fault if name in CHANGES else name for name in names}


def few_names(names: Iterable[str], apart: str = ", ", last: str = " and ") -> str:
    """
    The first of some names, and the number of further names.

    Parameters
    ----------
    names : iterable of str
        Names, which are sorted.
    apart : str, default ", "
        Text between two names.
    last : str, default " and "
        Text before the number of further names.

    Returns
    -------
    str
    """
    names = sorted(names)
    more = len(names) - FEW
    return apart.join(names[:FEW]) + (f"{last}{more:,} more" if more > 0 else "")


def gains_by_effect(text: str | None) -> dict[str, tuple[float, float]]:
    """Known gains and minimum detectable gains by effect."""
    pairs = json.loads(text) if isinstance(text, str) else {}
    known = {}
    for name, (gain, least) in pairs.items():
        if gain is not None and least is not None:
            known[name] = float(gain), float(least)
    return known


def order_of_group(group: Shared) -> tuple[bool, bool, bool, float, str]:
    named = bool(group.likely)
    return not named, not group.everywhere, not group.alone, -group.largest, group.site
