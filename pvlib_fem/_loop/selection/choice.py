"""A single effect: its best candidate, all that may be it, and how well each fits."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np

from pvlib_fem.effects import EFFECTS

if TYPE_CHECKING:
    from pvlib_fem._findings import CrossCheck
    from pvlib_fem._loop.selection.dictionary import Candidate
    from pvlib_fem.effects._effect import Effect

LEAST_Z = 1e-3  # standard errors of a size that is next to nothing


@dataclass(frozen=True)
class Score:
    """What a candidate explains given others."""

    keys: tuple[str, ...]  # names of its coefficients
    fall: float  # of the mean square on weeks left out in turn [K²]
    estimate: np.ndarray  # natural units
    covariance: np.ndarray
    probability: float  # that it is there
    possible: bool  # within its bounds
    seen: np.ndarray  # estimate by whitened columns
    null: np.ndarray  # covariance that it would have by accident
    freedom: float  # of that
    acting: float  # share of the record on which it acts
    shown: float = 0.0  # log-likelihood by references of the model with it

    @property
    def stderr(self) -> np.ndarray:
        """Standard errors of the coefficients."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def z_score(self) -> float:
        """Ratio of the first coefficient to its standard error."""
        return float(np.abs(self.estimate[0]) / self.stderr[0])

    @property
    def coefficients(self) -> dict[str, float]:
        """Coefficients by name."""
        return dict(zip(self.keys, map(float, self.estimate)))

    @property
    def errors(self) -> dict[str, float]:
        """Standard errors by name."""
        return dict(zip(self.keys, map(float, self.stderr)))


class Sized(NamedTuple):
    """A change and its size, with the relative standard error of that."""

    effect: "Effect"
    size: float
    error: float

    @classmethod
    def from_errors(cls, effect: "Effect", size: float, *errors: float) -> Self:
        """With standard errors of the size, of which the first is by accident."""
        least = LEAST_Z * errors[0]
        return cls(effect, size, float(np.linalg.norm(errors)) / max(abs(size), least))


@dataclass(frozen=True)
class SizeByReference:
    """The size of a change by references, relative to that by the temperature."""

    columns: tuple[str, ...]
    ratio: float
    error: float  # standard error of the ratio
    other: float  # relative standard error of the size by the temperature
    shows_it: bool  # whether it is of this change, rather than of something else

    @classmethod
    def of_all(cls, several: Sequence[Self]) -> Self:
        """The mean of all that are of this change, else the surest of the others."""
        of_it = [one for one in several if one.shows_it]
        if not of_it:
            return min(several, key=lambda one: one.error)
        weights = np.array([one.error**-2 for one in of_it])
        return cls(
            tuple(column for one in of_it for column in one.columns),
            float(np.average([one.ratio for one in of_it], weights=weights)),
            float(weights.sum() ** -0.5),
            of_it[0].other,
            True,
        )

    @property
    def share(self) -> float:
        """Weight of the references in the mean of all, by their variances."""
        return self.other**2 / (self.other**2 + self.error**2)

    @property
    def mean(self) -> float:
        """The mean of all sizes, relative to that by the temperature."""
        return 1.0 + self.share * (self.ratio - 1.0)


@dataclass(frozen=True, eq=False)
class Choice:
    """One single effect: its best candidate, and all that may be it."""

    top: "Candidate"
    score: Score
    members: dict[str, "Candidate"] = field(default_factory=dict)
    scores: dict[str, Score] = field(default_factory=dict)
    weights: dict[str, float] = field(default_factory=dict)  # posterior among members
    #: of members that are trends: least and largest size over their dates, relative
    spreads: dict[str, tuple[float, float]] = field(default_factory=dict)
    #: of members that are changes: by how much all confounders alter the size, and the
    #: standard error that it has given these
    confounded: dict[str, tuple[float, float]] = field(default_factory=dict)
    #: the outside among them, the most probable first
    probabilities: dict[str, float] = field(default_factory=dict)
    cross_checks: tuple["CrossCheck", ...] = ()
    #: of members that are changes, by references that do not contradict
    by_reference: dict[str, SizeByReference] = field(default_factory=dict)
    taken: frozenset[str] = frozenset()  # names of other choices

    @property
    def fall(self) -> float:
        """Of the mean square on weeks left out in turn, by its best candidate. [K²]"""
        return self.score.fall

    def sized(self, name: str) -> Sized:
        """A member with its size, of which the error by confounders is included."""
        score = self.scores[name]
        errors = float(score.stderr[0]), *self.confounded.get(name, ())
        effect, size = self.members[name].effect, float(score.estimate[0])
        return Sized.from_errors(effect, size, *errors)

    def joint(self, name: str) -> SizeByReference | None:
        """The size of a member by references that show it, or None."""
        one = self.by_reference.get(name)
        return one if one is not None and one.shows_it else None

    def coefficients(self, name: str) -> dict[str, float]:
        """Coefficients of a member, with the part that references have in its size."""
        values = self.scores[name].coefficients
        return {**values, **self.joint_size(name, values)}

    def errors(self, name: str) -> dict[str, float]:
        """Their standard errors."""
        score, joint = self.scores[name], self.joint(name)
        if joint is None:
            return score.errors
        parts = (1.0 - joint.share) * self.sized(name).error, joint.share * joint.error
        size = abs(float(score.estimate[0])) * float(np.linalg.norm(parts))
        return {**score.errors, score.keys[0]: size}

    def joint_size(self, name: str, values: Mapping[str, float]) -> dict[str, float]:
        """
        The coefficient that is the size of a member, by temperature and references.

        ``values`` has it by the temperature. Without references that show it there is
        none.
        """
        score, joint = self.scores[name], self.joint(name)
        if joint is None:
            return {}
        key, row = score.keys[0], self.members[name].effect.rows()[score.keys[0]]
        shown = joint.ratio * float(score.estimate[0])
        size = values[key] + joint.share * (shown - values[key])
        return {key: min(max(size, row.lower), row.upper)}

    @property
    def untested(self) -> float:
        """Probability of all that is no member: a cause outside, and snow."""
        return sum(p for n, p in self.probabilities.items() if n not in self.members)

    def effects_of(self, names: Iterable[str]) -> list["Effect"]:
        """Effects of some names; of one that no column shows, from the catalogue."""
        return [
            self.members[n].effect if n in self.members else EFFECTS[n] for n in names
        ]

    @property
    def first(self) -> str:
        """Name of the most probable member that is no other choice."""
        free = [name for name in self.members if name not in self.taken]
        return max(free, key=self.probabilities.__getitem__)

    def credible_names(self, probability: float) -> list[str]:
        """Names of the smallest set, with the outside, that holds a probability."""
        names, total = [], 0.0
        for name, share in self.probabilities.items():
            names.append(name)
            total += share
            if total >= probability:
                break
        return names

    @property
    def as_first(self) -> "Choice":
        """The choice with its most probable member as the best candidate."""
        return replace(
            self, top=self.members[self.first], score=self.scores[self.first]
        )


class ShownChange(NamedTuple):
    """A change with its dates, by which a reference deviates from an instrument."""

    effect: "Effect"
    #: logarithm of the odds that it is the instrument that has changed
    log_odds: float
