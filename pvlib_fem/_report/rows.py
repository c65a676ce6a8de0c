"""The measured rows of a loop for pictures, and the dates of a finding in it."""

from dataclasses import dataclass, field
from functools import cached_property, partial
from numbers import Real
from typing import NamedTuple

import numpy as np
import pandas as pd

from pvlib_fem._record.column_names import twin_of
from pvlib_fem.drivers import geometry
from pvlib_fem.plotting._evidence import SEASONS, Daily, Marks, plot_by_date

ENOUGH = 0.3  # of the median number of rows of a day, which a day needs
DATES = ("at", "since", "start", "end")
DOTS = "Dots are days or medians of some days, lines are running medians"


class Picture(NamedTuple):
    """How to draw something, and what it shows."""

    draw: object
    words: str
    projection: str | None = None


@dataclass(frozen=True, eq=False)
class Rows:
    """The measured rows of a loop, and the dates of one of its findings."""

    loop: object = field(repr=False)
    settings: dict = field(default_factory=dict)

    @property
    def record(self):
        return self.loop.fit.record

    @property
    def index(self):
        return self.record.index

    def column(self, name):
        """A column; None where it is not there or holds no number."""
        record = self.record
        if name in record.absent or name not in record.inputs.columns:
            return None
        values = record[name]
        return values if np.isfinite(values).any() else None

    def columns(self, *names):
        """Several columns; None if one of them is missing."""
        found = [self.column(name) for name in names]
        return None if any(one is None for one in found) else found

    def twins(self, usual):
        """Second sensors of a column, by name."""
        names = [n for n in self.record.inputs.columns if twin_of(n) == usual]
        return {n: self.column(n) for n in names if self.column(n) is not None}

    @cached_property
    def days(self):
        """Day of each row, since 1970-01-01."""
        return self.record.dates

    @property
    def location(self):
        return self.loop.place["location"]

    @property
    def plane(self):
        """Tilt and azimuth, where both are one number."""
        angles = [self.loop.place[n] for n in ("surface_tilt", "surface_azimuth")]
        return tuple(angles) if all(isinstance(a, Real) for a in angles) else None

    @property
    def moves(self):
        """Whether the plane is that of a tracker."""
        return self.loop.place.get("mount") is not None

    @property
    def late(self):
        """By how much the times run ahead of the sun, uncorrected. [s]"""
        return 60.0 * sum(
            one.values.get("late", 0.0)
            for one in self.loop.corrections
            if one.fault.startswith("file") and not one.applied
        )

    @cached_property
    def sun(self):
        """Azimuth and elevation of the sun [°]; None where its place is unknown."""
        if self.location is None or self.late:
            return None
        places = geometry(self.index, self.location)
        azimuth, zenith = (
            places[name].to_numpy() for name in ("solar_azimuth", "solar_zenith")
        )
        return azimuth, 90.0 - zenith

    @property
    def marks(self):
        """The dates of the finding."""
        lines = tuple(self.settings[n] for n in DATES if self.settings.get(n))
        return Marks(lines, tuple(self.settings.get("between") or ()))

    def daily(self, rows, one, other=None):
        """Sums of one column over those of another, or means, by day."""
        other = np.ones(len(one)) if other is None else other
        kept = rows & np.isfinite(one) & np.isfinite(other)
        days, place, count = np.unique(
            self.days[kept], return_inverse=True, return_counts=True
        )
        if len(days) < 2:
            return None
        sums = (np.bincount(place, column[kept]) for column in (one, other))
        with np.errstate(divide="ignore", invalid="ignore"):
            values = np.divide(*sums)
        good = (count >= ENOUGH * np.median(count)) & np.isfinite(values)
        times = pd.to_datetime(days[good], unit="D")
        return Daily(times, values[good]) if good.sum() > 1 else None

    def by_date(self, series, words, caption, seasonal=False):
        """The picture of daily series; None without any."""
        series = {name: one for name, one in series.items() if one is not None}
        if not series:
            return None
        marks = self.marks
        more = "; dashed: dates of the finding" * bool(marks.lines)
        more += "; shaded: days on which it may have begun" * bool(marks.period)
        ends = [end for one in series.values() for end in (one.days[0], one.days[-1])]
        if max(ends) - min(ends) >= SEASONS * pd.Timedelta(days=365) and seasonal:
            caption += ", less the usual season"
        draw = partial(plot_by_date, series, words, marks)
        return Picture(draw, f"{caption}. {DOTS}{more}.")


def day_of(date):
    """Days of a date since 1970-01-01."""
    return (pd.Timestamp(date) - pd.Timestamp(0)) / pd.Timedelta("1D")
