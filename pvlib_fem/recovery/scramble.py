"""
The record without what a name would need: drivers moved in time, or dates scrambled.

Days are moved as wholes, so that each value keeps its time of day. The record is taken
with the clocks that the loop corrected.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from pvlib_fem.drivers import geometry, needed_for
from pvlib_fem.effects import EFFECTS
from pvlib_fem.record.checks import usual_step
from pvlib_fem.record.columns import ALIASES, ANGLES, GEOMETRY, RENAMED, printable
from pvlib_fem.recovery.draw import course_of

YEAR = 365.2425  # days
WEEK, QUARTER = 7, 91  # days that stay together where dates are scrambled
DAY = 86_400_000_000_000  # ns
SAME = 0.5  # share of a column's variance that it describes after it was moved
DRIVERS, DATES = "drivers", "dates"  # the two kinds


@dataclass(frozen=True, eq=False)
class Scrambler:
    """A record as its loop took it, to be scrambled."""

    record: pd.DataFrame  # by corrected clocks
    plain: pd.Series  # module temperature less what changes of instruments add [°C]
    drivers: tuple  # measured columns beside the usual ones, by the package's names
    sun: tuple  # what is known of its place and of the module's
    tried: tuple  # effects
    holdout: pd.Series | None  # rows of the user's choice

    @classmethod
    def of(cls, search, loop, injector, data, holdout):
        """The scrambler of a search that is done."""
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
    def times(self):
        """Of each row the day from the first on, and the time of the day. [ns]"""
        index = self.record.index
        if index.tz is not None:  # the same clock all year
            offset = index[0].utcoffset()
            index = index.tz_convert("UTC").tz_localize(None) + offset
        since = index - index[0].normalize()
        since = since.to_numpy().astype("timedelta64[ns]").astype(np.int64)
        return since // DAY, since % DAY

    @property
    def days(self):
        """Days of the record."""
        return int(self.times[0][-1]) + 1

    @property
    def years(self):
        """Whole years of the record; a week may be missing."""
        return int((self.days + WEEK) // YEAR)

    def at(self, days):
        """Rows at the same time of these days, one for each row; -1 where none is."""
        first, within = self.times
        own, wanted = first * DAY + within, days * DAY + within
        after = np.clip(np.searchsorted(own, wanted), 1, len(own) - 1)
        near = after - (wanted - own[after - 1] < own[after] - wanted)
        late = np.abs(own[near] - wanted)
        return np.where(late <= usual_step(self.record.index) * 1e9 / 2, near, -1)

    def kinds(self):
        """The kinds of scrambling that this record allows, and why not others."""
        why = {}
        if not self.drivers:
            why[DRIVERS] = "the record has no column beside the usual ones"
        if self.years < 2:
            why[DATES] = "the record has less than two years"
        return [kind for kind in (DRIVERS, DATES) if kind not in why], why

    def scrambled(self, kind, number, seed):
        """
        A scrambled record, and the names of effects that it has lost.

        Parameters
        ----------
        kind : str
            ``"drivers"`` or ``"dates"``.
        number : int
            Of the record among those of its kind.
        seed : int

        Returns
        -------
        DataFrame, Series or None, set of str, str
            The record, its test rows where they are given, effects that are no longer
            in it, and what was done.
        """
        random = np.random.default_rng([seed, number, kind == DATES])
        if kind == DATES:
            return self.with_dates(random, QUARTER if number % 2 else WEEK)
        return self.with_drivers(number, random)

    def with_drivers(self, number, random):
        """Drivers by whole years later, or backwards from day to day."""
        first = self.times[0]
        shift = number // 2 + 1  # each second one is a mirrored one
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
            if alike(values, there, name in ANGLES) <= SAME:
                moved.append(name)
        return record, self.holdout, self.lost_without(moved), words

    def lost_without(self, moved):
        """Effects of which each form that the record allows needs a moved column."""
        lost = set()
        for effect in self.tried:
            forms = EFFECTS.get(effect.name, effect).forms
            there = [needed_for(form.drivers) for form in forms]
            there = [needs for needs in there if {*needs} <= {*self.drivers, *self.sun}]
            if there and all({*needs} & {*moved} for needs in there):
                lost.add(effect.name)
        return lost

    def with_dates(self, random, length):
        """
        The same days of the year from another year, each week or quarter by chance.

        Weeks lose all changes. Quarters keep what an error remembers for weeks, but
        also episodes, which are shorter.
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
        changes = [effect for effect in self.tried if effect.channel]
        if length == QUARTER:
            changes = [one for one in changes if course_of(one).name != "episode"]
        words = f"{'weeks' if length == WEEK else 'quarters'} exchanged between years"
        return record, holdout, {one.name for one in changes}, words


def labels_of(data):
    """The label of each column by the package's name for it."""
    labels = {printable(label): label for label in data}
    others = {**ALIASES, **RENAMED}
    return {new: labels[old] for old, new in others.items() if old in labels} | labels


def alike(one, other, angles=False):
    """Share of a column's variance that the moved one describes. [-]"""
    known = np.isfinite(one) & np.isfinite(other)
    if known.sum() < 3:
        return 0.0
    pair = np.array([one[known], other[known]])
    pair = np.exp(1j * np.radians(pair)) if angles else pair
    pair = pair - pair.mean(axis=1, keepdims=True)
    own, its = (np.abs(pair) ** 2).sum(axis=1)
    together = np.abs((pair[0] * pair[1].conj()).sum()) ** 2
    return float(together / (own * its)) if own * its > 0 else 0.0
