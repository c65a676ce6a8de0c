"""
Scramble a record, so that some effects are lost: move drivers, or exchange dates.

Whole days are moved, so each value keeps its time of day. The record has the clocks
that the loop corrected.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._loop.results.loop_result import Loop
from pvlib_fem._loop.search import Search
from pvlib_fem._record.checks import usual_step
from pvlib_fem._record.column_names import ANGLES, GEOMETRY
from pvlib_fem.drivers import geometry, needed_for
from pvlib_fem.effects import EFFECTS
from pvlib_fem.effects._time_profiles import YEAR, time_profile_of
from pvlib_fem.quality._screen import labels_of

WEEK, QUARTER = 7, 91  # days that stay together when dates are scrambled
DAY = 86_400_000_000_000  # ns
SAME = 0.5  # largest share of its own variance that a moved column may explain
DRIVERS, DATES = "drivers", "dates"  # the two kinds


@dataclass(frozen=True, eq=False)
class Scrambler:
    """A record with the clocks of its loop, to be scrambled."""

    record: pd.DataFrame  # by corrected clocks
    plain: pd.Series  # module temperature without the record's own faults [°C]
    drivers: tuple  # measured columns except the usual ones, by the package's names
    sun: tuple  # known columns of solar position and module plane
    tried: tuple  # tested effects
    holdout: pd.Series | None  # held-out rows that the user chose

    @classmethod
    def from_loop(
        cls, search: Search, loop: Loop, injector: Any, data: pd.DataFrame, holdout: Any
    ) -> "Scrambler":
        """The scrambler of a finished search."""
        record, known = loop.timed(data)
        measured = record[labels_of(record)["temp_module"]]
        if holdout is not None:
            holdout = holdout[known].set_axis(record.index)
        return cls(
            record,
            measured - injector.own_changes(),
            tuple(name for name in search.case.drivers if name not in GEOMETRY),
            tuple(geometry(record.index[:1], **search.case.site)),
            tuple(search.case.wanted),
            holdout,
        )

    @property
    def times(self) -> Any:
        """Day of each row, from 0 on, and its time of day [ns]."""
        index: Any = self.record.index
        if index.tz is not None:  # without daylight saving time
            offset = index[0].utcoffset()
            index = index.tz_convert("UTC").tz_localize(None) + offset
        since = index - index[0].normalize()
        since = since.to_numpy().astype("timedelta64[ns]").astype(np.int64)
        return since // DAY, since % DAY

    @property
    def days(self) -> Any:
        """Number of days of the record."""
        return int(self.times[0][-1]) + 1

    @property
    def years(self) -> Any:
        """Number of whole years of the record; a week may be missing."""
        return int((self.days + WEEK) // YEAR)

    def at(self, days: np.ndarray) -> Any:
        """Places of rows at the same time of day on other days; -1 without one."""
        first, within = self.times
        own, wanted = first * DAY + within, days * DAY + within
        after = np.clip(np.searchsorted(own, wanted), 1, len(own) - 1)
        near = after - (wanted - own[after - 1] < own[after] - wanted)
        late = np.abs(own[near] - wanted)
        return np.where(late <= usual_step(self.record.index) * 1e9 / 2, near, -1)

    def kinds(self) -> Any:
        """The kinds of scrambling that this record allows, and why not others."""
        why = {}
        if not self.drivers:
            why[DRIVERS] = "the record has only the usual columns"
        if self.years < 2:
            why[DATES] = "the record has less than two years"
        return [kind for kind in (DRIVERS, DATES) if kind not in why], why

    def scrambled(self, kind: Any, number: Any, seed: int) -> Any:
        """
        A scrambled record, and the names of effects that it has lost.

        Parameters
        ----------
        kind : str
            ``"drivers"`` or ``"dates"``.
        number : int
            Number of the record among those of its kind.
        seed : int

        Returns
        -------
        DataFrame, Series or None, set of str, str
            The record, its test rows if given, the lost effects, and a description.
        """
        random = np.random.default_rng([seed, number, kind == DATES])
        if kind == DATES:
            return self.with_dates(random, QUARTER if number % 2 else WEEK)
        return self.with_drivers(number, random)

    def with_drivers(self, number: Any, random: np.random.Generator) -> Any:
        """Drivers from whole years later, or backwards from day to day."""
        first = self.times[0]
        shift = number // 2 + 1  # every second record is mirrored
        if number % 2 == 0 and shift < self.years:
            whole = round(self.years * YEAR)
            days = (first + round(shift * YEAR)) % whole
            words = f"drivers {shift} year{'s' * (shift > 1)} later"
        else:
            middle = int(random.integers(self.days))
            days = (middle - first) % self.days
            words = f"drivers mirrored about day {middle / 2:g}"
        rows, labels = self.at(days), labels_of(self.record)
        record, moved = self.record.copy(), []
        for name in self.drivers:
            values = record[labels[name]].to_numpy(dtype=float)
            there = np.where(rows < 0, np.nan, values[rows])
            record[labels[name]] = there
            if explained_share(values, there, name in ANGLES) <= SAME:
                moved.append(name)
        return record, self.holdout, self.lost_without(moved), words

    def lost_without(self, moved: Any) -> Any:
        """Effects whose every possible variant needs a moved column."""
        lost = set()
        for effect in self.tried:
            forms = EFFECTS.get(effect.name, effect).forms
            there = [needed_for(form.drivers) for form in forms]
            there = [needs for needs in there if {*needs} <= {*self.drivers, *self.sun}]
            if there and all({*needs} & {*moved} for needs in there):
                lost.add(effect.name)
        return lost

    def with_dates(self, random: np.random.Generator, length: int) -> Any:
        """
        Exchange each week or quarter with that of a random year.

        With weeks the record loses all faults. Quarters keep the autocorrelation of the
        error over weeks, and also episodes, which are shorter.
        """
        first = self.times[0]
        starts = np.round(np.arange(self.years + 1) * YEAR).astype(int)
        year = np.minimum(np.searchsorted(starts, first, "right") - 1, self.years)
        within = first - starts[year]
        parts = int(YEAR) // length
        part = np.minimum(within // length, parts - 1)
        other = np.array([random.permutation(self.years) for _ in range(parts)]).T
        complete = year < self.years
        from_year = other[np.minimum(year, self.years - 1), part]
        days = np.where(complete, starts[from_year] + within, first)
        rows = self.at(days)
        kept, labels = rows >= 0, labels_of(self.record)
        record = self.record.assign(**{labels["temp_module"]: self.plain})
        record = record.iloc[rows[kept]].set_axis(self.record.index[kept])
        holdout = None if self.holdout is None else self.holdout[kept]
        changes = [effect for effect in self.tried if effect.sensor_fault]
        if length == QUARTER:
            changes = [one for one in changes if time_profile_of(one) != "episode"]
        words = f"{'weeks' if length == WEEK else 'quarters'} exchanged between years"
        return record, holdout, {one.name for one in changes}, words


def explained_share(one: Any, other: Any, angles: bool = False) -> Any:
    """Share of a column's variance that the moved column explains. [-]"""
    known = np.isfinite(one) & np.isfinite(other)
    if known.sum() < 3:
        return 0.0
    pair = np.array([one[known], other[known]])
    pair = np.exp(1j * np.radians(pair)) if angles else pair
    pair = pair - pair.mean(axis=1, keepdims=True)
    own, its = (np.abs(pair) ** 2).sum(axis=1)
    together = np.abs((pair[0] * pair[1].conj()).sum()) ** 2
    return float(together / (own * its)) if own * its > 0 else 0.0
