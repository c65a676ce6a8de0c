"""A user's frame as the loop takes it: checked, corrected, and divided."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from pvlib_fem.drivers import DERIVED, MODELLED, geometry, needed_for
from pvlib_fem.effects.candidates import candidates
from pvlib_fem.findings import Check, Correction
from pvlib_fem.loop.criteria import Criteria
from pvlib_fem.loop.weeks import Part, parts
from pvlib_fem.paper.filters import counted
from pvlib_fem.quality.check import check
from pvlib_fem.quality.clock import Clock
from pvlib_fem.quality.daylight import daylight_saving
from pvlib_fem.quality.screen import alone
from pvlib_fem.quality.stray import refuse_stray
from pvlib_fem.quality.stuck import stuck
from pvlib_fem.quality.units import oddities
from pvlib_fem.reasons import Reason, because
from pvlib_fem.record.checks import Record, as_record, with_columns
from pvlib_fem.record.columns import COLUMNS, numeric, usable_drivers, with_aliases
from pvlib_fem.record.resampling import coarse, covered
from pvlib_fem.statistics.axes import axes
from pvlib_fem.statistics.clusters import calendar_weeks

FAR_ZONE = 3.0  # h between a record's clock and the sun; no zone of a place has more
OFF_THE_SUN = ("file_shift", "file_dst")  # faults with which the sun is elsewhere


@dataclass(frozen=True, eq=False)
class Case:
    """
    A record, which of its rows may be looked at when, and what may explain it.

    The search goes over coarse steps, of which five minutes lose nothing that an
    effect would show; every fit ends on the record's own.
    """

    whole: Record
    record: Record  # on coarse steps
    seen: np.ndarray  # rows of the whole that count
    parts: np.ndarray  # what each row of the whole is for
    drivers: tuple
    wanted: tuple  # effects whose drivers are there
    untestable: dict  # name: why
    site: dict  # where the sun can be told from it
    place: dict  # as it was given
    clock: Clock
    criteria: Criteria
    family: int = 1  # hypotheses, counted before the first look
    fixed: dict = field(default_factory=dict)  # coefficients that are held
    notes: tuple = ()
    corrections: tuple = ()  # of the whole file

    def rows(self, part):
        """Rows of the whole that count for a part."""
        return self.seen & (self.parts == part)

    @cached_property
    def fitting(self):
        return self.rows(Part.FITTING)

    @cached_property
    def choosing(self):
        return self.rows(Part.CHOOSING)

    @cached_property
    def test(self):
        return self.rows(Part.TEST)

    @cached_property
    def searched(self):
        """Rows of the coarse record that the search may look at."""
        seen = np.asarray(counted(self.record.inputs.columns, with_night=True))
        seen &= covered(self.seen, self.whole, self.record)
        kept = self.parts != Part.FITTING
        return seen & ~covered(kept, self.whole, self.record)

    @cached_property
    def days(self):
        """Days that count."""
        return len(np.unique(self.whole.dates[self.seen]))

    @cached_property
    def fitting_days(self):
        return len(np.unique(self.record.dates[self.searched]))

    @property
    def divisible(self):
        """Whether there are days to leave out in turn."""
        return self.fitting_days >= self.criteria.fewest_fitting_days

    @property
    def enough(self):
        """Whether the record is long enough for a name."""
        return self.days >= self.criteria.enough_days

    @cached_property
    def axes(self):
        """All ways to sort the rows that are searched."""
        # power follows the light itself, and would sort by what it should tell
        names = sorted({*self.drivers, *COLUMNS[:3]} - {"p_dc"})
        record, rows = self.record, self.searched
        columns = {name: record[name][rows] for name in names}
        return list(
            axes(record.index[rows], record.dates[rows], columns, self.criteria)
        )

    @cached_property
    def folds(self):
        """Group of weeks of each row that is searched."""
        weeks = calendar_weeks(self.record.dates[self.searched])
        return np.unique(weeks, return_inverse=True)[1] % self.criteria.folds

    def without(self, effect):
        """The case without an effect, and the column that it follows."""
        wanted = tuple(other for other in self.wanted if other.name != effect.name)
        drivers = tuple(name for name in self.drivers if name not in effect.drivers)
        return replace(self, wanted=wanted, drivers=drivers)

    def corrected(self):
        """The case with the module's record re-timed."""
        columns = dict(self.whole.inputs.columns)
        seconds = self.whole.inputs.seconds
        columns["temp_module"] = self.clock.corrected(seconds, columns["temp_module"])
        if "p_dc" in columns:
            moved = self.clock.corrected(seconds, columns["p_dc"])
            columns["p_dc"] = follows(columns["poa_global"], columns["p_dc"], moved)
        whole = replace(self.whole, inputs=replace(self.whole.inputs, columns=columns))
        return divided(whole, replace(self, clock=Clock()))


def prepared(
    data,
    site,
    holdout,
    effects,
    criteria,
    check_units=True,
    fixed=None,
    corrections=(),
):
    """Everything checked that comes in, and divided before it is looked at."""
    columns, limits = with_aliases(data), criteria.limits
    usual = as_record(*(columns.pop(name) for name in COLUMNS))
    refuse_stray(usual.index, limits)
    what = parts(usual, counting(usual), holdout, criteria)
    test = what == Part.TEST
    hidden, faults = alone(
        with_columns(without_answer(usual, test), numeric(columns)), limits, check_units
    )
    taken = (*DERIVED, *MODELLED)
    drivers, refused = usable_drivers(columns, hidden, criteria.most_missing, taken)
    hidden = hidden.only([*COLUMNS, *drivers])
    health = check(hidden, limits=limits, **site)
    whole, still = with_answer(hidden, faults, usual, test, limits)
    if "file_dst" in health.faults and site["location"] is not None and not corrections:
        place = (health.noon, *site.values(), criteria.limits)
        summer = daylight_saving(whole["poa_global"], whole.index, *place)
        how = (site, holdout, effects, criteria, check_units, fixed)
        if summer.explained:
            if holdout is not None:
                how = (site, summer.corrected(holdout), *how[2:])
            return prepared(summer.corrected(data), *how, (told_of(summer),))
        corrections = (told_of(summer, health.faults["file_dst"]),)
    if "file_shift" in health.faults:
        corrections += (shifted(health.faults["file_shift"], health.noon.late),)
    stands = health.mask | still
    # doubts are said with the refused, clocks with their correction
    said = {f"units:{name}" for name in health.doubtful} | {*health.clock.faults}
    said |= {c.fault for c in corrections}
    notes = [*faults.notes, *oddities(hidden.inputs, limits)]
    notes += [line for name, line in health.faults.items() if name not in said]
    notes += [*health.unchecked, *of_the_zone(whole.index, site["location"])]
    for name, doubt in health.doubtful.items():
        drivers.pop(name, None)
        words = doubt.removeprefix(f"{name} ")
        refused[name] = because(Reason.DOUBTFUL, column=name, doubt=words)
    sun, of_sun = geometry(whole.index, **site), {}
    if {*OFF_THE_SUN} & {*health.faults}:
        of_sun = dict.fromkeys(sun, because(Reason.OFF_THE_SUN))
        sun = {}
    known = {**drivers, **sun}
    wanted, untestable = candidates(known, {**refused, **of_sun}, effects)
    if health.clock.limit > criteria.unseen_clock and not health.clock.fault:
        minutes = health.clock.limit / 60.0
        notes.append(str(because(Reason.COARSE_CLOCK, minutes=minutes)))
    notes += [f"{reason}: not used" for reason in refused.values()]
    notes += gaps(whole, drivers, wanted)
    kept = {n: c for n, c in whole.inputs.columns.items() if n not in refused}
    kept |= {name: column.to_numpy() for name, column in sun.items()}
    frozen = {name: rows for name, rows in health.frozen.items() if name in kept}
    kept |= {name: np.where(rows, np.nan, kept[name]) for name, rows in frozen.items()}
    kept["temp_module"] = np.where(stands, np.nan, kept["temp_module"])
    whole = replace(whole, inputs=replace(whole.inputs, columns=kept))
    case = Case(
        whole=whole,
        record=whole,
        seen=~stands,
        parts=what,
        drivers=tuple(drivers),
        wanted=tuple(wanted),
        untestable=untestable,
        site=site if sun else dict.fromkeys(site),
        place=site,
        clock=health.clock,
        criteria=criteria,
        family=criteria.rounds * max(1, len(wanted)),
        fixed=dict(fixed or {}),
        notes=tuple(notes),
        corrections=corrections,
    )
    return divided(whole, case)


def of_the_zone(index, location):
    """What to know of hours that are far from those of the sun."""
    if location is None or index.tz is None:
        return
    own = index[0].utcoffset().total_seconds() / 3600.0
    sun = location.longitude / 15.0
    if abs((own - sun + 12.0) % 24.0 - 12.0) > FAR_ZONE:
        yield (
            f"hours are told in the record's zone, {index.tz}; at longitude "
            f"{location.longitude:g}° the sun's are {abs(own - sun):.0f} h "
            f"{'earlier' if own > sun else 'later'}: for local hours give "
            "data.tz_convert(zone) (--tz)"
        )


def told_of(summer, fault=""):
    """What was made of a file that keeps daylight-saving time."""
    noon = "the day's light beside the sun, root mean square"
    why = because(Reason.CORRECTED, fault=summer.line)
    if not summer.explained:
        why = because(Reason.NOT_CORRECTED, fault=fault, remedy=summer.line)
    check = Check(noon, "", summer.after, summer.before, most=True, unit="min")
    return Correction(
        fault="file_dst",
        columns=("all",),
        values={"summer": 60.0} if summer.explained else {},
        stderr={},
        before=summer.before,
        after=summer.after,
        unit="min",
        because=why,
        checks=(check,) if summer.explained else (),
        applied=summer.explained,
    )


def shifted(fault, late):
    """What was made of a file whose times do not fit the sun: nothing."""
    remedy = (
        "give the times the zone that they are in, or set the location right; until "
        "then no effect that follows the sun is tried"
    )
    return Correction(
        fault="file_shift",
        columns=("all",),
        values={"late": late / 60.0},
        stderr={},
        before=abs(late) / 60.0,
        after=abs(late) / 60.0,
        unit="min",
        because=because(Reason.NOT_CORRECTED, fault=fault, remedy=remedy),
        applied=False,
    )


def without_answer(record, rows):
    """The record without the module's temperature in some rows."""
    module = np.where(rows, np.nan, record["temp_module"])
    columns = {**record.inputs.columns, "temp_module": module}
    return replace(record, inputs=replace(record.inputs, columns=columns))


def with_answer(hidden, faults, usual, test, limits):
    """
    The record with the answer of the test rows, and which of them stand still.

    Of that answer nothing is known to any rule; what it shows of a sensor is of the
    test rows alone.
    """
    own, answer = alone(usual, limits, check_units=False)
    module = np.where(test, own["temp_module"], hidden["temp_module"])
    columns = {**hidden.inputs.columns, "temp_module": module}
    whole = replace(hidden, inputs=replace(hidden.inputs, columns=columns))
    whole = replace(whole, impossible=faults.and_in(test, answer).impossible)
    return whole, test & np.any(list(stuck(own, limits).values()), axis=0)


def counting(record):
    """Rows that can be fitted."""
    return np.asarray(counted(record.inputs.columns, with_night=True))


def divided(whole, case):
    """The case with this record and its coarse steps."""
    limits = case.criteria
    seen = case.seen & counting(whole)
    short = whole
    if whole.inputs.seconds[-1] > 0:
        hidden = without_answer(whole, case.parts == Part.TEST)
        # the sun is where it is, and nothing is averaged over a horizon
        known = geometry(whole.index[:1], **case.site)
        measured = {n: c for n, c in hidden.inputs.columns.items() if n not in known}
        hidden = replace(hidden, inputs=replace(hidden.inputs, columns=measured))
        short = coarse(hidden, limits.search_step, limits.step_present)
        short = whole if short is hidden else short
    if short is not whole:
        places = geometry(short.index, **case.site)
        places = {name: column.to_numpy() for name, column in places.items()}
        inputs = replace(short.inputs, columns={**short.inputs.columns, **places})
        short = replace(short, inputs=inputs)
    return replace(case, whole=whole, record=short, seen=seen)


def gaps(record, drivers, wanted):
    """How many rows do not count for effects whose drivers lack, one line each."""
    for name in drivers:
        lacking = int(np.isnan(record[name]).sum())
        using = [e.name for e in wanted if name in needed_for(e.drivers)]
        if lacking and using:
            yield (
                f"{name} lacks in {lacking:,} rows, which do not count for "
                f"{', '.join(using)}"
            )


def follows(poa_global, *columns):
    """The column whose changes follow those of irradiance best."""
    change = np.diff(poa_global)

    def likeness(column):
        other = np.diff(column)
        both = np.isfinite(change) & np.isfinite(other)
        return change[both] @ other[both] / np.sqrt(other[both] @ other[both] + 1e-12)

    return max(columns, key=likeness)
