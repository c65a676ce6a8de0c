"""What the systems of one site share: the station's, or one module's own."""

import json
from dataclasses import dataclass, field

import pandas as pd

from pvlib_fem.effects import CHANGES, EFFECTS
from pvlib_fem.effects.instruments import STATION
from pvlib_fem.fleet.tasks import JOIN

STATIONS = {name for name, effect in CHANGES.items() if effect.channel in STATION}
MODULES = {*CHANGES} - STATIONS


@dataclass
class Shared:
    """
    Findings of one site that may be one cause.

    Attributes
    ----------
    site : str
    candidates : set of str
        Those that all of them have.
    systems : dict of float
        Gain by id, of those in which it was found. [K]
    also : set of str
        Systems that show it, too, too small to be added there.
    without : set of str
        Systems that would show it at the largest of these gains, and do not.
    first, last : str or None
        Dates between which they may have begun, of a change.
    """

    site: str
    candidates: set
    systems: dict = field(default_factory=dict)
    also: set = field(default_factory=set)
    without: set = field(default_factory=set)
    first: str | None = None
    last: str | None = None

    def fits(self, names, first, last):
        """Whether a finding may be of the same cause, at the same time."""
        if not self.candidates & names or (first is None) != (self.first is None):
            return False
        return first is None or (first <= self.last and self.first <= last)

    def take(self, identity, gain, names, first, last):
        self.candidates = self.candidates & names
        self.systems[identity] = max(gain, self.systems.get(identity, gain))
        if first is not None:
            self.first, self.last = min(first, self.first), max(last, self.last)

    def ask(self, others):
        """Ask systems in which it was not found, by what was weighed there."""
        for identity, weighed in others.items():
            known = [weighed[name] for name in self.candidates if name in weighed]
            if identity in self.systems or not (known or (self.first and weighed)):
                continue  # a date is looked for in every loop, whatever it weighs
            # a change that is dated has its date in the findings
            if self.first is None and any(0.0 < least <= gain for gain, least in known):
                self.also.add(identity)
            elif all(least <= self.largest for _, least in known):
                self.without.add(identity)

    @property
    def largest(self):
        return max(self.systems.values())

    @property
    def have(self):
        return len(self.systems) + len(self.also)

    @property
    def everywhere(self):
        return self.have > 1 and not self.without

    @property
    def alone(self):
        return self.have == 1 and bool(self.without)

    @property
    def likely(self):
        """The candidates that go with its being of all systems, or of one."""
        if not self.candidates <= {*CHANGES}:
            return []
        side = STATIONS if self.everywhere else MODULES if self.alone else set()
        return sorted(self.candidates & side)

    @property
    def words(self):
        """What to suspect."""
        some = f" ({' or '.join(self.likely)})" if self.likely else ""
        count = f"all {self.have} that can show it"
        if self.alone:
            asked = len(self.without)
            words = f"this one alone, and not {asked} beside it that would show it"
            return f"{words}: suspect its module, sensor or surroundings{some}"
        if not self.everywhere:
            asked = self.have + len(self.without)
            return f"{self.have} of {asked}" if asked > 1 else "no other can show it"
        if self.candidates & MODULES and not self.likely:
            return f"{count}: what was done to all modules at once"
        if self.candidates & ({*EFFECTS} - {*CHANGES}):
            return f"{count}: what acts on all modules there, or the station"
        return f"{count}: suspect the station{some}"


def shared(systems: pd.DataFrame, findings: pd.DataFrame) -> list[Shared]:
    """
    Causes of each site that has more systems than one.

    Findings are of one cause where they have a candidate in common and, if they have
    dates, intervals that overlap. A system counts as one without it only if its record
    would show the same gain.

    Parameters
    ----------
    systems, findings : DataFrame
        As :class:`pvlib_fem.fleet.Results` has them.

    Returns
    -------
    list of Shared
        Those of all systems of a site first, then the largest gains.
    """
    done = systems[(systems["state"] == "done") & (systems["site"] != "")]
    added = findings[findings["added"]].sort_values("id", kind="stable")
    rows = dict(list(added.groupby("site")))
    found: list[Shared] = []
    for site, members in done.groupby("site", sort=True):
        if len(members) < 2 or site not in rows:
            continue
        groups = grouped(str(site), rows[site].to_dict("records"))
        weighed = {
            row["id"]: weights(row["weighed"]) for row in members.to_dict("records")
        }
        for group in groups:
            group.ask(weighed)
        found += groups
    return sorted(found, key=order)


def grouped(site, rows):
    """Findings of a site by what may be one cause."""
    groups: list[Shared] = []
    for row in rows:
        names = {*row["candidates"].split(JOIN)}
        dated = isinstance(row["first"], str)
        dates = (row["first"], row["last"]) if dated else (None, None)
        same = [group for group in groups if group.fits(names, *dates)]
        if not same:
            same = [Shared(site, names, first=dates[0], last=dates[1])]
            groups += same
        gain = row["gain"] if row["gain"] == row["gain"] else 0.0  # of a clock
        same[0].take(row["id"], gain, names, *dates)
    return groups


def weights(text):
    """Gains and minimum detectable ones by effect; what is unknown shows nothing."""
    pairs = json.loads(text) if isinstance(text, str) else {}
    known = {}
    for name, (gain, least) in pairs.items():
        if gain is not None and least is not None:
            known[name] = float(gain), float(least)
    return known


def order(group):
    return not group.everywhere, not group.alone, -group.largest, group.site
