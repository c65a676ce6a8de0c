"""What may be in the remaining error: effects, and changes at the dates that show."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, cast

import numpy as np
from scipy.special import gammaln

from pvlib_fem._loop.regression.design import Changed, Column, Design
from pvlib_fem._loop.selection.change_dates import DATES, Scan, signs_of
from pvlib_fem.effects._effect import Effect, Parameter
from pvlib_fem.effects._time_profiles import rows_reaching, time_profile_of

PART = *DATES, "resets"  # of a trend that is not of the whole record
OF_A_PART = "drift of a part"  # time profile of such a trend
RARE = {"air_elsewhere": 0.05}  # times the odds of others
SIZES = 4.0  # standard deviations of sizes between the bounds of a coefficient
SLACK_ERRORS = 2.0  # standard errors by which a tangent may miss a bound
SLACK = 0.35  # share of a bound by which it may: a tangent is bent where it is large


@dataclass(frozen=True)
class Candidate:
    """An effect, or a change at its dates, with its columns of the design."""

    effect: Effect
    columns: tuple[Column, ...]
    log_prior: float  # logarithm of its prior odds
    #: hypotheses of dates from which this one was taken, as a logarithm
    log_dates: float = 0.0
    dates_known: bool = False  # whether a second sensor or power shows its dates

    @property
    def name(self) -> str:
        return self.effect.name

    @property
    def dates(self) -> int:
        """Number of its dates that were searched for; none without a time profile."""
        if not self.effect.sensor_fault or self.dates_known:
            return 0
        settings = self.effect.settings
        return sum(name in settings for name in DATES) + len(settings.get("resets", ()))

    @property
    def time_profile(self) -> str:
        """Its time profile, and whether a trend is of a part of the record; or ""."""
        name = time_profile_of(self.effect) if self.effect.sensor_fault else ""
        part = name == "drift" and any(n in self.effect.settings for n in PART)
        return OF_A_PART if part else name

    @property
    def change(self) -> Changed:
        """The only column of a candidate that has a sensor fault."""
        (column,) = self.columns
        return cast(Changed, column)

    def beyond(self, given: Sequence[Column]) -> list[Column]:
        """Columns that are not given already."""
        return [column for column in self.columns if column not in given]

    def rows(self, design: Design) -> dict[str, Parameter]:
        """
        Rows of its coefficients by name, one for each column.

        Bounds of a trend are those of its fault for what it becomes in all its years.
        """
        if self.effect.sensor_fault:
            most = float(design.parts(self.change)[0].max(initial=0.0))
            return rows_reaching(self.effect, most)
        rows = self.effect.rows()
        names = [design.names[one] for one in self.columns if isinstance(one, int)]
        return {name: rows[name] for name in names}

    def existence(
        self,
        rows: Iterable[Parameter],
        estimate: np.ndarray,
        covariance: np.ndarray,
        freedom: float,
        shown: float = 0.0,
    ) -> float:
        """
        Probability that it is there, by its estimate and the error by accident alone.

        Wakefield's approximate Bayes factor, with the tails of Student's law for so
        many weeks, times the likelihood ratio of references, of which ``shown`` is the
        logarithm.
        """
        plain, wide, volume = squared_distances(rows, estimate, covariance)
        tails = np.log1p(plain / freedom) - np.log1p(wide / freedom)
        log_factor = -0.5 * volume + 0.5 * (freedom + len(estimate)) * tails
        log_odds = log_factor + shown + self.log_prior - self.log_dates
        return float(1.0 / (1.0 + np.exp(-np.clip(log_odds, -500.0, 500.0))))

    def size_seen(
        self,
        rows: Iterable[Parameter],
        way: np.ndarray,
        covariance: np.ndarray,
        freedom: float,
        probability: float,
    ) -> float:
        """How many times an estimate has to be to be there with a probability."""
        plain, wide, volume = squared_distances(rows, way, covariance)
        log_factor = log_odds(probability) - self.log_prior + self.log_dates
        log_factor += 0.5 * volume
        # existence, solved for the square of the size
        ratio = np.exp(min(2.0 * log_factor / (freedom + len(way)), 500.0))
        if plain <= wide * ratio:
            return np.inf
        return float(np.sqrt(freedom * max(ratio - 1.0, 0.0) / (plain - wide * ratio)))


def all_candidates(
    design: Design, given: Sequence[Column], side: int, prior: float
) -> Iterator[Candidate]:
    """
    Effects without a date, and changes at the dates that the remaining error shows.

    Parameters
    ----------
    design : Design
    given : sequence of int or Changed
        Columns given which the remaining error is looked at.
    side : int
        Days with rows that there have to be on both sides of a date.
    prior : float
        Prior odds of any one effect, and of any one change at some date. [-]

    Yields
    ------
    Candidate
    """
    for name, columns in design.own.items():
        odds = np.log(prior * RARE.get(name, 1.0))
        yield Candidate(design.effects[name], columns, float(odds))
    days = len(design.dates)
    if days <= 2 * side:
        return
    scan = Scan.from_design(design, given, side)
    places = design.sensor_faults
    for place in dict.fromkeys(places.values()):
        changes: dict[str, Effect] = {}
        for effect in design.changing:
            if places[effect.sensor_fault] == place:  # others of that law are the same
                changes.setdefault(time_profile_of(effect), effect)
        if not changes:
            continue
        signs = signs_of(next(iter(changes.values())))
        for time_profile, dates in scan.along(place, *signs):
            if time_profile not in changes:
                continue
            effect = dated(changes[time_profile], *dates.items())
            one = Candidate(effect, design.columns_of(effect), float(np.log(prior)))
            log_dates = one.dates * np.log(days) - gammaln(one.dates + 1.0)
            yield replace(one, log_dates=float(log_dates))


@lru_cache(maxsize=4096)  # a search comes to the same dates again and again
def dated(change: Effect, *dates: tuple[str, Any]) -> Effect:
    """A change without dates, with some."""
    return change.dates(**dict(dates))


def log_odds(probability: float) -> float:
    """
    Logarithm of the odds of a probability; 1 by rounding counts as 1 − ε.

    Parameters
    ----------
    probability : float

    Returns
    -------
    float
    """
    least = np.finfo(float).eps
    probability = float(np.clip(probability, least, 1.0 - least))
    return float(np.log(probability / (1.0 - probability)))


def within_bounds(
    rows: Iterable[Parameter], estimate: np.ndarray, stderr: np.ndarray
) -> bool:
    """
    Whether coefficients are within their bounds, to first order.

    Parameters
    ----------
    rows : iterable of Parameter
    estimate, stderr : array, shape (coefficients,)

    Returns
    -------
    bool
    """

    def slack(bound: float, error: float) -> float:
        return max(SLACK_ERRORS * error, SLACK * abs(bound))

    return all(
        row.lower - slack(row.lower, error)
        <= value
        <= row.upper + slack(row.upper, error)
        for row, value, error in zip(rows, estimate, stderr)
    )


def squared_distances(
    rows: Iterable[Parameter], estimate: np.ndarray, covariance: np.ndarray
) -> tuple[float, float, float]:
    """
    Squared distances of an estimate from nothing, and how much broader one is.

    By the covariance, by that with the prior of its size, and the logarithm of the
    ratio of their determinants.
    """
    widths = np.array([(row.upper - row.lower) / SIZES for row in rows])
    scale = np.sqrt(np.diag(covariance))
    inner = covariance / np.outer(scale, scale) + 1e-9 * np.eye(len(scale))
    sizes, mean = np.diag(np.square(widths / scale)), estimate / scale
    plain = float(mean @ np.linalg.solve(inner, mean))
    wide = float(mean @ np.linalg.solve(inner + sizes, mean))
    _, volume = np.linalg.slogdet(np.eye(len(mean)) + np.linalg.solve(inner, sizes))
    return plain, wide, volume
