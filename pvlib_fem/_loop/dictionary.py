"""What may be in the remaining error: effects, and changes at the dates that show."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from scipy.special import gammaln

from pvlib_fem._loop.change_dates import Scan, number_of_dates
from pvlib_fem._loop.design import Changed, Column, Design, columns_of
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import time_profile_of

RARE = {"air_elsewhere": 0.05}  # times the odds of others


@dataclass(frozen=True)
class Candidate:
    """An effect, or a change at its dates, with its columns of the design."""

    effect: Effect
    columns: tuple[Column, ...]
    log_prior: float  # logarithm of its prior odds
    #: hypotheses of dates from which this one was taken, as a logarithm
    log_dates: float = 0.0

    @property
    def name(self) -> str:
        return self.effect.name

    @property
    def time_profile(self) -> str:
        """Its time profile, and whether a trend is of a part of the record; or ""."""
        name = time_profile_of(self.effect) if self.effect.sensor_fault else ""
        part = name == "drift" and number_of_dates(self.effect)
        return f"{name} of a part" if part else name

    @property
    def change(self) -> Changed:
        """The only column of a candidate that has a sensor fault."""
        (column,) = self.columns
        return cast(Changed, column)

    def beyond(self, given: Sequence[Column]) -> list[Column]:
        """Columns that are not given already."""
        return [column for column in self.columns if column not in given]


def without_dates(design: Design, prior: float) -> Iterator[Candidate]:
    """
    Candidates that have no date.

    Parameters
    ----------
    design : Design
        Hourly tangents of all effects.
    prior : float
        Prior odds of any one effect. [-]

    Yields
    ------
    Candidate
    """
    for name, columns in design.own.items():
        odds = np.log(prior * RARE.get(name, 1.0))
        yield Candidate(design.effects[name], columns, float(odds))


def dated_candidates(
    design: Design, given: Sequence[Column], side: int, prior: float
) -> Iterator[Candidate]:
    """
    Changes at the dates that the remaining error given some columns shows best.

    Parameters
    ----------
    design : Design
    given : sequence of int or Changed
        Columns.
    side : int
        Days with rows that there have to be on both sides of a date.
    prior : float
        Odds that any one change is there, at some date.

    Yields
    ------
    Candidate
    """
    days = len(design.dates)
    if days <= 2 * side:
        return
    scan = Scan.from_design(design, given, side)
    for sensor_fault, place in design.sensor_faults.items():
        changes = {
            time_profile_of(effect): effect
            for effect in design.changing
            if effect.sensor_fault == sensor_fault
        }
        if not changes:
            continue
        for time_profile, dates in scan.along(place, *possible_signs(changes)):
            if time_profile not in changes:
                continue
            effect = changes[time_profile].dates(**dates)
            many = number_of_dates(effect)
            log_dates = many * np.log(days) - gammaln(many + 1.0)
            yield Candidate(
                effect,
                columns_of(design, effect),
                float(np.log(prior)),
                float(log_dates),
            )


def possible_signs(changes: Mapping[str, Effect]) -> tuple[float, float]:
    """Least and largest size that a sensor fault can have, as signs."""
    (row,) = next(iter(changes.values())).parameters.values()
    return np.sign(row.lower), np.sign(row.upper)
