"""The measured rows of a loop for pictures, and the dates of a finding in it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial
from numbers import Real
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pandas as pd
from pvlib.location import Location

from pvlib_fem._record.column_names import twin_of
from pvlib_fem._record.file_summary import present
from pvlib_fem._record.inputs import Record
from pvlib_fem.drivers import geometry
from pvlib_fem.plotting._evidence import SEASONS, Daily, Marks, plot_by_date

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pvlib_fem._loop.results.loop_result import Loop

ENOUGH = 0.3  # of the median number of rows of a day, which a day needs
DATES = ("at", "since", "start", "end")
DOTS = "Dots are days or medians of some days, lines are running medians"


#: a function that draws on axes
Draw = Callable[["Axes"], object]


class Picture(NamedTuple):
    """How to draw something, and what it shows."""

    draw: Draw
    words: str
    projection: str | None = None


@dataclass(frozen=True, eq=False)
class Rows:
    """The measured rows of a loop, and the dates of one of its findings."""

    loop: "Loop" = field(repr=False)
    settings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def record(self) -> Record:
        return present(self.loop.fit.record)

    @property
    def index(self) -> pd.DatetimeIndex:
        return self.record.index

    def column(self, name: str) -> np.ndarray | None:
        """A column; None where it is not there or holds no number."""
        record = self.record
        if name in record.absent or name not in record.inputs.columns:
            return None
        values = record[name]
        return values if np.isfinite(values).any() else None

    def twins(self, usual: str) -> dict[str, np.ndarray]:
        """Second sensors of a column, by name."""
        names = [n for n in self.record.inputs.columns if twin_of(n) == usual]
        columns = {name: self.column(name) for name in names}
        return {name: one for name, one in columns.items() if one is not None}

    @cached_property
    def days(self) -> np.ndarray:
        """Day of each row, since 1970-01-01."""
        return self.record.dates

    @property
    def location(self) -> Location | None:
        return self.loop.place["location"]

    @property
    def plane(self) -> tuple[float, float] | None:
        """Tilt and azimuth, where both are one number."""
        angles = [self.loop.place[n] for n in ("surface_tilt", "surface_azimuth")]
        return tuple(angles) if all(isinstance(a, Real) for a in angles) else None

    @property
    def moves(self) -> bool:
        """Whether the plane is that of a tracker."""
        return self.loop.place.get("mount") is not None

    @property
    def late(self) -> float:
        """By how much the times run ahead of the sun, uncorrected. [s]"""
        return 60.0 * sum(
            one.values.get("late", 0.0)
            for one in self.loop.corrections
            if one.fault.startswith("file") and not one.applied
        )

    @cached_property
    def sun(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Azimuth and elevation of the sun [°]; None where its place is unknown."""
        if self.location is None or self.late:
            return None
        places = geometry(self.index, self.location)
        azimuth, zenith = (
            places[name].to_numpy() for name in ("solar_azimuth", "solar_zenith")
        )
        return azimuth, 90.0 - zenith

    @property
    def marks(self) -> Marks:
        """The dates of the finding, from the first day of the record on."""
        lines = [self.settings[n] for n in DATES if self.settings.get(n)]
        first = f"{self.index[0]:%Y-%m-%d}"
        lines += [day for day in self.settings.get("resets", ()) if day >= first]
        return Marks(tuple(lines), tuple(self.settings.get("between") or ()))

    def daily(
        self, rows: np.ndarray, one: np.ndarray, other: np.ndarray | None = None
    ) -> Daily | None:
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

    def by_date(
        self,
        series: Mapping[str, Daily | None],
        words: str,
        caption: str,
        seasonal: bool = False,
    ) -> Picture | None:
        """The picture of daily series; None without any."""
        drawn = {name: one for name, one in series.items() if one is not None}
        if not drawn:
            return None
        marks = self.marks
        more = "; dashed: dates of the finding" * bool(marks.lines)
        more += "; shaded: days on which it may have begun" * bool(marks.period)
        ends = [end for one in drawn.values() for end in (one.days[0], one.days[-1])]
        if max(ends) - min(ends) >= SEASONS * pd.Timedelta(days=365) and seasonal:
            caption += ", less the usual season"
        draw = partial(plot_by_date, drawn, words, marks)
        return Picture(draw, f"{caption}. {DOTS}{more}.")
