"""What a closed loop can say: findings, corrections, and the checks behind them."""

from dataclasses import dataclass, field
from enum import Enum, StrEnum
from typing import Any, ClassVar

import numpy as np

from pvlib_fem._converter import AnyFloat
from pvlib_fem._former_names import fields_in_new_names
from pvlib_fem.effects import EFFECTS
from pvlib_fem.effects._effect import Effect
from pvlib_fem.reasons import Because, in_percent


class Verdict(StrEnum):
    """How sure a finding is, and whether it is in the model."""

    IDENTIFIED = "identified"
    AMBIGUOUS = "ambiguous"
    HINT = "hint"
    UNEXPLAINED = "unexplained"


OUTSIDE = "outside"  # among probabilities: none of the catalogue
SNOW = "snow"  # among them, if a change is there only while snow can lie
OUTSIDE_WORDS = "a cause outside the catalogue"
LEAST = 0.01  # probability that is reported
CORRECTED = "clock corrected"  # row of a table of errors
PREDICTED = "+patterns"  # row of a table of errors, with the unexplained patterns
ADDED = (Verdict.IDENTIFIED, Verdict.AMBIGUOUS)  # what enters the model


class Kind(Enum):
    """What a finding is about."""

    EFFECT = "an effect of the catalogue"
    OWN = "an effect of the user's own"
    COLUMN = "a column of the user's own"
    STRUCTURE = "an unexplained pattern"

    @classmethod
    def of(cls, effect: Effect) -> "Kind":
        """Of an effect: of the catalogue, of the user's own, or a column."""
        if effect.column:
            return cls.COLUMN
        return cls.EFFECT if effect.name in EFFECTS else cls.OWN


@dataclass(frozen=True)
class Check:
    """
    One rule, and what a finding made of it.

    Attributes
    ----------
    name : str
        What is checked, in words.
    criterion : str
        The field of :class:`pvlib_fem.Criteria` that is the threshold, "" where the
        rule has none.
    statistic, threshold : float
    most : bool
        Whether the threshold is the most that passes; else it is the least.
    unit : str
    """

    name: str
    criterion: str
    statistic: AnyFloat
    threshold: AnyFloat
    most: bool = False
    unit: str = ""
    also_in_file: ClassVar = ("passed",)

    @property
    def passed(self) -> bool:
        """Whether the rule is kept; an unknown statistic keeps a most."""
        if np.isnan(self.statistic):
            return self.most
        if self.most:
            return bool(self.statistic <= self.threshold)
        return bool(self.statistic >= self.threshold)

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        rule = f" ({self.criterion})" if self.criterion else ""
        side = "at most" if self.most else "at least"
        return (
            f"{'passed' if self.passed else 'FAILED'}  {self.name}: "
            f"{self.statistic:.3g}{unit}, {side} {self.threshold:.3g}{unit}{rule}"
        )


class CheckOutcome(StrEnum):
    """Result of a cross-check."""

    AGREES = "agrees"
    CONTRADICTS = "contradicts"
    CANNOT_TELL = "cannot tell"


VERBS = {
    CheckOutcome.AGREES: "agrees with",
    CheckOutcome.CONTRADICTS: "contradicts",
    CheckOutcome.CANNOT_TELL: "neither confirms nor rules out",
}


#: names of causes that change the light on the modules, and no reading, begin so
ON_MODULES = ("module_irradiance", "tracker_stuck")


@fields_in_new_names({"opinion": "outcome"})
@dataclass(frozen=True)
class CrossCheck:
    """
    Comparison of an instrument that has changed with a series of the same quantity.

    Attributes
    ----------
    column : str
        A column of the record, or ``"clear sky"`` for the irradiance sensor and
        ``"usual wind"`` for the anemometer.
    effect : str
        The candidate that it checks.
    size, stderr : float
        Deviation of the column from the instrument along the time profile, and its
        standard error: a difference [K], or the logarithm of the ratio of both [-].
    expected : float
        The size if that candidate is the cause. With another cause it is about 0.
    outcome : CheckOutcome
    unit : str
        ``"-"`` or ``"K"``, of a drift ``"-/year"`` or ``"K/year"``. Of dirt it is
        ``"-/day"``, and the size is positive if dirt is on the sensor. Of a standstill
        the size is that of a usual day, by the light that it takes each day.
    """

    column: str
    effect: str
    size: float
    stderr: float
    expected: float
    outcome: CheckOutcome
    unit: str = "-"

    @property
    def reads(self) -> str:
        """
        What the instrument reads by the column, such as 8.4 ± 0.2 % less a year.

        Of a cause that changes the light on the modules, it is what these receive.
        """
        value, error = self.reading(self.size), self.stderr
        if not self.in_kelvin:
            error *= 100.0 + value  # slope of the exponential
        return self.in_words(value, error)

    @property
    def in_kelvin(self) -> bool:
        """Whether sizes are temperatures, and no shares."""
        return self.unit.startswith("K")

    @property
    def of_modules(self) -> bool:
        """Whether its candidate changes the light on the modules, and no reading."""
        dirty = self.daily and self.expected < 0.0
        return dirty or self.effect.startswith(ON_MODULES)

    @property
    def daily(self) -> bool:
        """Whether sizes are rates per day, as of dirt."""
        return self.unit.endswith("/day")

    def reading(self, size: float) -> float:
        """
        What the instrument reads beyond the column, or the modules receive. [K or %]

        Parameters
        ----------
        size : float
            Deviation of the column from the instrument: a difference [K], or the
            logarithm of a ratio.

        Returns
        -------
        float
        """
        size = size if self.of_modules else -size
        return size if self.in_kelvin else 100.0 * float(np.expm1(size))

    def in_words(self, value: float, error: float = np.nan) -> str:
        """
        Write what the instrument reads beyond the truth.

        Parameters
        ----------
        value, error : float
            Reading and its standard error, which may be NaN. [K or %]

        Returns
        -------
        str
        """
        digits = 2 if self.daily or self.in_kelvin else 1
        unit = "K" if self.in_kelvin else "%"
        sign = f" ± {error:.{digits}f}" if np.isfinite(error) else ""
        way = "more" if value > 0.0 else "less"
        year = " a year" if self.unit.endswith("/year") else ""
        per = " a day" if self.daily else year
        return f"{abs(value):.{digits}f}{sign} {unit} {way}{per}"

    def __str__(self) -> str:
        expected = self.in_words(self.reading(self.expected))
        verb = VERBS[self.outcome]
        subject = "the modules receive" if self.of_modules else "the sensor reads"
        return (
            f"{self.column} {verb} {self.effect}: by it {subject} {self.reads}; "
            f"{expected} is expected"
        )


@dataclass(frozen=True)
class Member:
    """
    Another cause that an ambiguous finding may have, as the data have it.

    Attributes
    ----------
    settings : dict
        Settings of its effect, such as its dates.
    coefficients, stderr, ranges : dict
        Coefficients, standard errors and ranges of the linearised model that has it
        instead of the most probable one.
    """

    settings: dict
    coefficients: dict[str, AnyFloat]
    stderr: dict[str, AnyFloat]
    ranges: dict[str, tuple[float, float]]


@fields_in_new_names({"witnesses": "cross_checks", "heard": "conclusive_checks"})
@dataclass(frozen=True)
class Finding:
    """
    One thing that the record shows; ``print(finding)`` has all checks.

    Attributes
    ----------
    effect : str
        Name of the effect, or the drivers along which unknown structure lives.
    candidates : tuple of str
        All names that the data cannot distinguish from it, itself included.
    verdict : Verdict
        ``"identified"``; ``"ambiguous"``, one of the candidates; ``"hint"``, not
        added to the model; ``"unexplained"``, which no effect explains.
    gain : float
        What it takes off the error: root of the fall of the mean square, over
        fitting weeks left out in turn. [K]
    coefficients, stderr : dict
        From the last fit if it was added, else from the ranking. The size of a change
        is the mean of its sizes by the module temperature and by the references that
        show it, weighted by their variances.
    because : Because
        The reason for the verdict.
    checks : tuple of Check
        The rules in the order in which they were applied; of a finding that was not
        added, up to the one that failed.
    kind : Kind
    where : dict
        Of unknown structure: from and to of each driver.
    place : str
        Of unknown structure where it lives, of a change its dates, in words.
    cross_checks : tuple of CrossCheck
        Cross-checks of a change of an instrument by other columns.
    ranges : dict
        From and to of each coefficient that was fitted: its scatter, ``stderr``, with
        the error of its law and how it differs under other conditions.
    probabilities : dict
        Name to the probability that it is the cause; ``"outside"`` is a cause outside
        the catalogue that follows the same inputs. A change that only frosty days show
        can be ``"snow"``, also if no column has it.
    members : dict of Member
        Name to each other candidate of the catalogue that was fitted.
    """

    effect: str
    candidates: tuple[str, ...]
    verdict: Verdict
    gain: AnyFloat
    coefficients: dict[str, AnyFloat]
    stderr: dict[str, AnyFloat]
    because: Because
    checks: tuple[Check, ...] = ()
    kind: Kind = Kind.EFFECT
    where: dict[str, tuple[Any, ...]] = field(default_factory=dict)
    place: str = ""
    cross_checks: tuple[CrossCheck, ...] = ()
    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)
    probabilities: dict[str, float] = field(default_factory=dict)
    members: dict[str, Member] = field(default_factory=dict)
    also_in_file: ClassVar = ("why",)

    @property
    def why(self) -> str:
        """The reason for the verdict, in one line."""
        return str(self.because)

    @property
    def shares(self) -> str:
        """The probability of each cause from 1 % on, in words."""
        return ", ".join(
            f"{OUTSIDE_WORDS if name == OUTSIDE else name} {in_percent(probability)}"
            for name, probability in self.probabilities.items()
            if probability >= LEAST
        )

    @property
    def conclusive_checks(self) -> tuple[CrossCheck, ...]:
        """The cross-checks that agree or contradict."""
        return tuple(
            check
            for check in self.cross_checks
            if check.outcome is not CheckOutcome.CANNOT_TELL
        )

    @property
    def failed(self) -> Check | None:
        """The first check that it does not pass, if any."""
        return next((check for check in self.checks if not check.passed), None)

    @property
    def added(self) -> bool:
        """Whether it is in the model."""
        return self.verdict in ADDED

    def __str__(self) -> str:
        head = f"{' | '.join(self.candidates)}: {self.verdict}, {self.gain:.2f} K"
        shares = [f"probabilities: {self.shares}"] if self.shares else []
        parts = [self.why, *shares, *self.checks, *self.cross_checks]
        return "\n".join([head, *(f"  {part}" for part in parts)])


@dataclass(frozen=True)
class Correction:
    """
    A fault of a clock or place, and what was made of it before any effect was weighed.

    Attributes
    ----------
    fault : str
        ``"clock_shift"``, ``"clock_drift"`` or ``"dst"`` of the module's logger;
        ``"file_shift"``, ``"file_dst"`` or ``"file_jump"`` of the whole file; several
        of one clock are joined by ``+``. ``"file_latitude"`` and ``"file_plane"`` are
        of the place that is given for it.
    columns : tuple of str
        Columns that were re-timed; ``all`` if the whole file was.
    values, stderr : dict
        What the clock is out by: ``late`` [min], ``drift`` [s/day], ``summer``
        [min]; by a date, how far it was set then [min].
    before, after : float
        Error without and with the correction.
    unit : str
        Of those errors.
    because : Because
    checks : tuple of Check
    applied : bool
        Whether the record was corrected.
    """

    fault: str
    columns: tuple[str, ...]
    values: dict[str, AnyFloat]
    stderr: dict[str, AnyFloat]
    before: AnyFloat
    after: AnyFloat
    unit: str
    because: Because
    checks: tuple[Check, ...] = ()
    applied: bool = True

    @property
    def why(self) -> str:
        """The reason in one line."""
        return str(self.because)

    @property
    def of_place(self) -> bool:
        """Whether the given latitude or plane is at fault, and no clock."""
        return self.fault in ("file_latitude", "file_plane")

    def __str__(self) -> str:
        words = "corrected" if self.applied else "not corrected"
        head = f"{self.fault}: {words}"
        if np.isfinite(self.before):
            head += f", {self.before:.2f} → {self.after:.2f} {self.unit}"
        return "\n".join([head, f"  {self.why}", *(f"  {c}" for c in self.checks)])
