"""A user's frame as the loop takes it: checked, and its file's clock corrected."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from pvlib.location import Location

from pvlib_fem._findings import Check, Correction
from pvlib_fem._fitting.horizontal import refuse_clock
from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._loop.divided_record import Case
from pvlib_fem._loop.outputs import outputs
from pvlib_fem._loop.planes import plane_of_columns
from pvlib_fem._loop.replacements import NOTHING, Filled, Replacements
from pvlib_fem._record.column_names import (
    ALWAYS,
    COLUMNS,
    GEOMETRY,
    doubts_of_power,
    is_cross_check,
    is_power,
    numeric,
    plant_power,
    twin_of,
    usable_drivers,
)
from pvlib_fem._record.filters import counted
from pvlib_fem._record.inputs import Record, as_record, with_columns
from pvlib_fem._record.names import unmapped
from pvlib_fem._statistics.clusters import calendar_weeks
from pvlib_fem.drivers import DERIVED, MODELLED, geometry, needed_for
from pvlib_fem.drivers._mounts import ANGLES, PLANE, angles_at, axis_of, is_known
from pvlib_fem.drivers._planes import ByColumns
from pvlib_fem.drivers._solar import standard_time
from pvlib_fem.effects import EffectLike
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._testable_effects import candidates, candidates_about_axis
from pvlib_fem.effects._time_profiles import date_text
from pvlib_fem.quality._check import Health, check
from pvlib_fem.quality._daylight import Daylight, daylight_saving
from pvlib_fem.quality._detached_sensor import Detachment, detachments_of
from pvlib_fem.quality._irradiance_clock import twin_clock
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._module_lag import Clock
from pvlib_fem.quality._plane import Plane, fixed_rather, plane_of
from pvlib_fem.quality._screen import Faults, screened_alone
from pvlib_fem.quality._screening import stuck_rows
from pvlib_fem.quality._stray_times import refuse_stray
from pvlib_fem.quality._stuck import stuck_line
from pvlib_fem.quality._tracker_standstill import Standing, standing_of
from pvlib_fem.quality._unit_checks import oddities, options_of
from pvlib_fem.reasons import Because, Reason, because

UNSEEN_CLOCK = 120.0  # s, by which the module's clock may be off unseen
FEWEST_WEEKS = 5  # below which every other day is a test day
FAR_ZONE = 3.0  # h between a record's clock and the sun; no zone of a place has more
NEAR_HOUR = 0.25  # h from a whole one, as near as a file of half hours shows it
SUNLESS = "until then no effect that follows the sun is tried"
#: faults with which the sun is elsewhere
OFF_THE_SUN = ("file_shift", "file_dst", "file_jump", "file_latitude")


@dataclass(frozen=True, eq=False)
class Look:
    """A record, and what is seen of it before any fit; of test rows no answer."""

    whole: Record  # less what was not measured
    held_out: np.ndarray  # rows of test weeks
    drivers: dict[str, pd.Series]
    cross_check_columns: tuple[str, ...]  # they cross-check others, and drive nothing
    refused: dict[str, Because]  # further columns, and why they are not used
    faults: Faults
    odd: tuple[str, ...]  # what looks odd, in sentences
    health: Health
    still: np.ndarray  # test rows of stuck sensors
    detachments: tuple[Detachment, ...]  # of the module's sensor
    off: np.ndarray  # rows in which it is off
    kept: np.ndarray  # rows of the file that have a sure time
    filled: Filled  # replacements of missing columns
    site: dict[str, Any]  # with the plane that its columns have

    @property
    def light(self) -> np.ndarray:
        """Irradiance as it was measured, which the middle of the day is found by."""
        horizontal = self.filled.horizontal
        return self.whole["poa_global"] if horizontal is None else horizontal

    @property
    def late(self) -> float:
        """By how much the file's times run ahead of the sun, if that is known. [s]"""
        late = self.health.noon.late
        return late if np.isfinite(late) else 0.0


def prepared_case(
    data: pd.DataFrame,
    site: dict[str, Any],
    holdout: pd.Series | None,
    effects: EffectLike | Iterable[EffectLike] | None,
    criteria: Criteria,
    check_units: bool = True,
    fixed: Mapping[str, float] | None = None,
    instead: Replacements = NOTHING,
    spared: Collection[int] = (),
) -> Case:
    """
    Everything checked that comes in, and divided before it is looked at.

    Parameters
    ----------
    data : DataFrame
    site : dict
        From :func:`pvlib_fem.drivers.checked_place`.
    holdout, effects, criteria, check_units, fixed
        See :func:`pvlib_fem.close_loop`.
    instead : Replacements, optional
    spared : sequence of int
        Days since 1970-01-01 that are no test days by default.

    Returns
    -------
    Case

    Raises
    ------
    ValueError
        If the record is unusable: times, columns, units.
    """
    look_at = partial(
        screened_frame,
        site=site,
        criteria=criteria,
        check_units=check_units,
        instead=instead,
        spared=spared,
    )
    look = look_at(data, holdout)
    limits = criteria.limits
    look, corrections = in_standard_time(data, holdout, look, look_at, limits)
    site, faults = look.site, look.health.faults
    off, refused = {*OFF_THE_SUN} & {*faults}, look.refused
    if look.filled.horizontal is not None:
        refuse_clock({name: faults[name] for name in off})
    if not off and (light := fixed_light(look, site)) is not None:
        shape = "more of the shape of tilt {:.0f}° and azimuth {:.0f}° all day"
        why = because(Reason.ANOTHER_PLANE, plane=shape.format(*light))
        site = site | dict.fromkeys(PLANE)
        refused = refused | dict.fromkeys(ANGLES, why)
    plane = None if off or site is not look.site else estimated_plane(look, site)
    other = None if off else another_plane(look, site)
    corrections = (*corrections, *faults_of_place(look, site, other))
    if plane is not None:
        site = site | plane.angles
    sun = geometry(look.whole.index[:1], **site)  # what of it is known
    if off:
        refused = refused | dict.fromkeys(sun, because(Reason.OFF_THE_SUN))
        sun = {}
    measured = bool(sun) and look.filled.horizontal is None
    standings = standings_in(look, site) if measured else ()
    power = plant_power(look.whole, criteria.max_missing_share)
    there, absent = {**look.drivers, **power, **sun}, look.whole.absent
    wanted, untestable = candidates(there, refused, effects, absent=absent)
    wanted, fixed_plane = candidates_about_axis(wanted, axis_of(site))
    untestable |= fixed_plane
    if plane is not None:  # an obstacle cannot be located from an unknown plane
        scans = filter(is_before_the_sun, wanted)
        untestable |= {e.name: because(Reason.ESTIMATED) for e in scans}
        wanted = [effect for effect in wanted if effect.name not in untestable]
    whole, seen = used_record(look, sun)
    case = Case(
        whole=whole,
        record=whole,
        seen=seen,
        held_out=look.held_out,
        drivers=tuple(look.drivers),
        cross_check_columns=(
            *look.cross_check_columns,
            *(name for name in look.drivers if is_power(name)),
        ),
        wanted=tuple(wanted),
        untestable=untestable,
        site=with_standings(site, look.whole.index, standings)
        if sun
        else dict.fromkeys(site),
        place=site,
        clock=look.health.clock,
        criteria=criteria,
        fixed=dict(fixed or {}),
        kept=look.kept,
        notes=(
            *([] if plane is None else [f"the module's plane is estimated: {plane}"]),
            *map(str, look.detachments),
            *map(str, standings),
            *fitted_weeks(spared),
            *notes_of(look, corrections, wanted, site, criteria),
        ),
        corrections=corrections,
        another_plane=other,
        late=look.late,
        transposed=look.filled.horizontal is not None,
        standing=look.filled.standing,
        standings=standings,
        detachments=look.detachments,
    )
    return case.divided(whole)


def fixed_light(look: Look, site: dict[str, Any]) -> tuple[float, float] | None:
    """The fixed plane that the light of clear days has, where the stated one moves."""
    if (
        site["mount"] is None
        or not is_known(site)
        or look.filled.horizontal is not None
    ):
        return None
    index, late = look.whole.index, look.late
    stated = angles_at(index, site, late)
    return fixed_rather(stated, look.whole["poa_global"], index, site["location"], late)


def estimated_plane(look: Look, site: dict[str, Any]) -> Plane | None:
    """The module's plane by the light of clear days, where neither angle is given."""
    given = [value for name, value in site.items() if name != "location"]
    if site["location"] is None or any(value is not None for value in given):
        return None
    return plane_of_light(look, site)


def plane_of_light(look: Look, site: dict[str, Any]) -> Plane | None:
    """The plane that the light of clear days has."""
    whole = look.whole
    return plane_of(whole["poa_global"], whole.index, site["location"], look.late)


def standings_in(look: Look, site: dict[str, Any]) -> tuple[Standing, ...]:
    """
    Days on which the irradiance sensor of a tracker is stuck; none of a fixed plane.

    The irradiance is then not of the plane that turns, but of one that is fixed.
    """
    index, late = look.whole.index, look.late
    angles = None if site["mount"] is None else angles_at(index, site, late)
    if angles is None:
        return ()
    poa, location = look.whole["poa_global"], site["location"]
    return standing_of(poa, index, location, angles, late)


def with_standings(
    site: dict[str, Any], index: pd.DatetimeIndex, standings: tuple[Standing, ...]
) -> dict[str, Any]:
    """The site with the angles at which its sensor stood, on those days."""
    if not standings:
        return site
    columns = geometry(index, **site)
    angles = {name: columns[name].to_numpy(copy=True) for name in ANGLES}
    for one in standings:
        rows = one.rows(index)
        for name in ANGLES:
            angles[name][rows] = getattr(one, name)
    return {**site, **dict.fromkeys(ANGLES), "mount": ByColumns(index, angles)}


def another_plane(look: Look, site: dict[str, Any]) -> Plane | None:
    """The plane by the light of clear days, if it is surely not the stated one."""
    if look.filled.horizontal is not None or site["mount"] is not None:
        return None
    stated = [site[name] for name in ANGLES]
    if not is_known(site) or any(map(np.ndim, stated)):
        return None
    plane = plane_of_light(look, site)
    return plane if plane is not None and plane.is_another(*stated) else None


def faults_of_place(
    look: Look, site: dict[str, Any], other: Plane | None
) -> Iterator[Correction]:
    """Faults of times or place by the sun, which the user alone can set right."""
    faults = look.health.faults
    if fault := faults.get("file_shift"):
        late = look.health.noon.late
        zone = zone_of_the_sun(look.whole.index, late, site["location"])
        yield uncorrected_shift(fault, late, zone)
    if fault := faults.get("file_latitude"):
        yield uncorrected("file_latitude", fault, SUNLESS)
    if other is not None:
        tilt, azimuth = (site[name] for name in ANGLES)
        fault = (
            f"the irradiance is not of the stated plane (tilt {tilt:g}°, azimuth "
            f"{azimuth:g}°): it has {other}"
        )
        remedy = "until then effects of the sun on that plane may be wrong"
        yield uncorrected("file_plane", fault, remedy)


def is_before_the_sun(effect: Effect) -> bool:
    """
    Whether an effect is searched for by the position of the sun, given the plane.

    Parameters
    ----------
    effect : Effect
        Effect of the catalogue.

    Returns
    -------
    bool
    """
    return bool(effect.scan) and bool({*GEOMETRY[:2]} & {*effect.drivers})


def screened_frame(
    data: pd.DataFrame,
    holdout: pd.Series | None,
    site: dict[str, Any],
    criteria: Criteria,
    check_units: bool,
    instead: Replacements,
    spared: Collection[int],
) -> Look:
    """
    A frame divided and screened, and what its sensors and clocks show.

    The parameters are those of :func:`prepared_case`.
    """
    limits = criteria.limits
    data, site = plane_of_columns(data, site)
    # clocks are looked at below, and may be corrected
    filled = instead.filled(data, ALWAYS, site, limits, check_units, check_clock=False)
    columns = dict(filled.columns)
    usual = as_record(*(columns.pop(name, None) for name in COLUMNS))
    refuse_stray(usual.index, limits)
    test = test_rows(usual, holdout, criteria, spared)
    hidden, faults = screened_alone(
        with_columns(usual.lacking({"temp_module": test}), numeric(columns)),
        limits,
        check_units,
        late=True,
    )
    taken = (*DERIVED, *MODELLED)
    comparing = tuple(filter(is_cross_check, numeric(columns)))
    columns = {n: column for n, column in columns.items() if n not in comparing}
    drivers, refused = usable_drivers(
        columns, hidden, criteria.max_missing_share, taken
    )
    hidden = hidden.only([*COLUMNS, *drivers, *comparing])
    light = filled.horizontal
    health = check(hidden, limits=limits, light=light, **filled.plane(site))
    for name, doubt in health.doubtful.items():
        drivers.pop(name, None)
        refused[name] = because(Reason.DOUBTFUL, column=name, doubt=doubt)
    for column, name, evidence in outputs(hidden, [*drivers]):
        options = " ".join(options_of(column, name, drivers.pop(column)))
        refused[column] = because(
            Reason.OUTPUT, column=column, name=name, evidence=evidence, options=options
        )
    whole, still, faults, health = with_answer(
        hidden, faults, health, usual, test, limits
    )
    detachments, off = detached_rows(hidden, whole, test, still, health)
    timed = in_time(hidden, health.clock).inputs
    odd = tuple(oddities(timed, limits, hidden.absent))
    return Look(
        whole=whole,
        held_out=test,
        drivers=drivers,
        cross_check_columns=comparing,
        refused=refused,
        faults=faults,
        odd=odd,
        health=health,
        still=still,
        detachments=detachments,
        off=off,
        kept=np.ones(len(test), dtype=bool),
        filled=filled,
        site=site,
    )


def test_rows(
    record: Record,
    holdout: pd.Series | None,
    criteria: Criteria,
    spared: Collection[int],
) -> np.ndarray:
    """
    Rows of the test weeks: chosen ones, or every fifth week but spared days.

    Of a record of few weeks it is every other day.
    """
    if holdout is not None:
        return record.rows(holdout)
    seen = counted(record.inputs.columns, with_night=True)
    weeks = np.unique(calendar_weeks(record.dates), return_inverse=True)[1]
    test = np.zeros(len(seen), dtype=bool)
    if weeks.max() + 1 >= FEWEST_WEEKS:
        every = criteria.test_every
        test = weeks % every == every // 2
    elif record.count_days(seen) > 1:
        test = record.days % 2 == 1
    return test & ~np.isin(record.dates, [*spared])


def fitted_weeks(spared: Collection[int]) -> Iterator[str]:
    """A line on each week that would be a test week without a standstill."""
    weeks = {int(calendar_weeks(np.array(day))): day for day in sorted(spared)[::-1]}
    for first in sorted(weeks.values()):
        yield (
            f"the week from {date_text(first)} on is fitted and not a test week: "
            "modules may have been stuck on some of its days"
        )


def detached_rows(
    hidden: Record,
    whole: Record,
    test: np.ndarray,
    still: np.ndarray,
    health: Health,
) -> tuple[tuple[Detachment, ...], np.ndarray]:
    """
    Times in which the module's sensor is off, and the rows that are not used.

    As of a stuck sensor, the temperatures of the test rows say it of test rows alone:
    which fitting rows are used does not depend on them. So the hidden record has no
    module temperature of the test rows. The times are by all rows, and those that the
    fitting rows alone show, too.
    """
    off = np.zeros(len(test), dtype=bool)
    found: dict[bool, list[tuple[Detachment, int, int]]] = {}
    for record, rows in ((hidden, ~test), (whole, test)):
        stuck = health.mask | still
        own = record.lacking({"temp_module": stuck}) if stuck.any() else record
        some = detachments_in(own, health.clock)
        for _, first, end in some:
            off[first:end] |= rows[first:end]
        found[record is whole] = some
    reported = [*found[True]]
    for one in found[False]:  # which all rows together need not show
        if not any(overlap(one, other) for other in found[True]):
            reported.append(one)
    known = np.isfinite(whole["temp_module"]) & off
    result = [
        replace(
            one,
            rows=int(np.count_nonzero(known[first:end])),
            fitting=any(overlap((one, first, end), other) for other in found[False]),
        )
        for one, first, end in sorted(reported, key=lambda some: some[1])
    ]
    return tuple(result), off


def overlap(one: tuple[Any, int, int], other: tuple[Any, int, int]) -> bool:
    """Whether two spans have rows in common."""
    return one[1] < other[2] and other[1] < one[2]


def detachments_in(record: Record, clock: Clock) -> list[tuple[Detachment, int, int]]:
    """Times in which the module's sensor is off, with rows of its logger."""
    timed = in_time(record, clock) if clock.fault else record
    some = detachments_of(
        timed["temp_module"],
        record["temp_air"],
        record["poa_global"],
        record.index,
        record.dates,
        next((timed[n] for n in timed.inputs.columns if is_power(n)), None),
    )
    if not clock.fault:
        return some
    seconds = record.inputs.seconds
    written = seconds + clock.late_at(seconds)
    edges = [*written, np.inf]
    return [
        (one, *np.searchsorted(seconds, [edges[first], edges[end]]).tolist())
        for one, first, end in some
    ]


def in_time(record: Record, clock: Clock) -> Record:
    """The record with the module's column by the clock of the irradiance."""
    module = clock.corrected(record.inputs.seconds, record["temp_module"])
    return record.having({"temp_module": module})


def in_standard_time(
    data: pd.DataFrame,
    holdout: pd.Series | None,
    look: Look,
    look_at: Callable[[pd.DataFrame, pd.Series | None], Look],
    limits: Limits,
) -> tuple[Look, tuple[Correction, ...]]:
    """The look again where a file's clock jumps, and what was made of that."""
    faults, site = look.health.faults, look.site
    jumps = [faults[name] for name in ("file_dst", "file_jump") if name in faults]
    if not jumps or site["location"] is None:
        return look, ()
    place = look.filled.plane(site) | {"limits": limits}
    summer = daylight_saving(look.light, look.whole.index, look.health.noon, **place)
    if not summer.explained:
        return look, (jumps_correction(summer, "; ".join(jumps)),)
    if holdout is not None:
        holdout = summer.corrected(holdout)
    look = look_at(summer.corrected(data), holdout)
    return replace(look, kept=np.asarray(summer.kept)), (jumps_correction(summer),)


def used_record(look: Look, sun: Collection[str]) -> tuple[Record, np.ndarray]:
    """The record of what is used, without the sun, and the rows that may count."""
    stands, whole = look.health.mask | look.still | look.off, look.whole
    others = {*look.refused, *sun}  # of which the second is added where it is needed
    kept = [name for name in whole.inputs.columns if name not in others]
    blank = {name: rows for name, rows in look.health.frozen.items() if name in kept}
    blank["temp_module"] = stands | blank.get("temp_module", False)
    # what needs no gap is no copy
    blank = {name: rows for name, rows in blank.items() if rows.any()}
    columns = whole.inputs.columns.only(kept).put(np.nan, blank)
    return replace(whole, inputs=replace(whole.inputs, columns=columns)), ~stands


def notes_of(
    look: Look,
    corrections: Iterable[Correction],
    wanted: Sequence[Effect],
    site: dict[str, Any],
    criteria: Criteria,
) -> Iterator[str]:
    """Notes on the data, one line each."""
    health = look.health
    yield from look.filled.notes
    yield from look.faults.notes
    yield from look.odd
    # doubts are reported with the refused, clocks with their correction
    reported = {f"units:{name}" for name in health.doubtful} | {*health.clock.faults}
    reported |= {fault for one in corrections for fault in one.fault.split("+")}
    yield from (line for name, line in health.faults.items() if name not in reported)
    yield from health.unchecked
    yield from twin_clock_lines(look, criteria.limits)
    yield from of_the_zone(look.whole.index, site["location"])
    if health.clock.limit > UNSEEN_CLOCK and not health.clock.fault:
        minutes = health.clock.limit / 60.0
        yield str(because(Reason.COARSE_CLOCK, minutes=minutes))
    yield from (f"{reason}: not used" for reason in look.refused.values())
    for column, name in unmapped(look.drivers).items():
        yield (
            f"{column} looks like {name}: under a name of its own it may be taken for "
            "a cause that it is not; if it is that, rename it "
            f"({' '.join(options_of(column, name, look.whole[column]))})"
        )
    if columns := look.cross_check_columns:
        alone = len(columns) == 1
        yield (
            f"{', '.join(columns)} cross-check{'s' * alone} the instruments and "
            f"drive{'s' * alone} nothing"
        )
    yield from doubts_of_power(look.whole, criteria.max_missing_share)
    yield from gap_lines(look.whole, look.drivers, wanted)


def twin_clock_lines(look: Look, limits: Limits) -> Iterator[str]:
    """Further irradiances whose clock is another than that of poa_global."""
    whole = look.whole
    for name in (*look.drivers, *look.cross_check_columns):
        if name == "ghi" or twin_of(name) == "poa_global":
            first, second = whole["poa_global"], whole[name]
            if line := twin_clock(first, second, whole.index, limits).line:
                yield f"timestamps of {name} {line}"


def with_answer(
    hidden: Record,
    faults: Faults,
    health: Health,
    usual: Record,
    test: np.ndarray,
    limits: Limits,
) -> tuple[Record, np.ndarray, Faults, Health]:
    """
    The record with the module temperature of the test rows, and the stuck ones.

    No other rule uses these temperatures; a stuck sensor that they show is masked on
    the test rows alone. ``faults`` and ``health`` are of the hidden record, ``usual``
    has its columns as they came. Reported counts are of all rows.
    """
    name = "temp_module"
    own = hidden.only(COLUMNS).having({name: usual[name]})
    own, answer = screened_alone(own, limits, check_units=False, names=(name,))
    answered, came = np.where(test, own[name], hidden[name]), usual[name]
    # as it came it needs no room of its own
    same = np.array_equal(answered, came, equal_nan=True)
    whole = hidden.having({name: came if same else answered})
    before = faults.record.having({name: came})
    faults = replace(faults.and_in(test, answer), record=before)
    still = {n: test & rows for n, rows in stuck_rows(own, limits).items()}
    both = {n: rows | still.get(n, False) for n, rows in health.frozen.items()}
    if any(rows.any() for rows in both.values()):
        line = {"stuck": stuck_line(whole, both)}
        # the first of the faults
        health = replace(health, faults=line | health.faults | line)
    whole = replace(whole, impossible=faults.impossible)
    return whole, np.any(list(still.values()), axis=0), faults, health


def gap_lines(
    record: Record, drivers: Iterable[str], wanted: Sequence[Effect]
) -> Iterator[str]:
    """Rows that do not count for effects because a driver is missing, a line each."""
    for name in drivers:
        absent = int(np.isnan(record[name]).sum())
        using = [e.name for e in wanted if name in needed_for(e.drivers)]
        if absent and using:
            yield (
                f"{name} is missing in {absent:,} rows, which do not count for "
                f"{', '.join(using)}"
            )


def of_the_zone(index: pd.DatetimeIndex, location: Location | None) -> Iterator[str]:
    """A note on hours that are far from those of the sun."""
    offset = index[0].utcoffset()
    if location is None or offset is None:
        return
    own = offset.total_seconds() / 3600.0
    sun = location.longitude / 15.0
    if abs((own - sun + 12.0) % 24.0 - 12.0) > FAR_ZONE:
        yield (
            f"hours are those of the record's zone, {index.tz}; at longitude "
            f"{location.longitude:g}° the sun's are {abs(own - sun):.0f} h "
            f"{'earlier' if own > sun else 'later'}: for local hours give "
            "data.tz_convert(zone) or --tz"
        )


def jumps_correction(summer: Daylight, fault: str = "") -> Correction:
    """The correction of a file whose clock jumps, or why there is none."""
    noon = "middle of the daily irradiance against the sun, root mean square"
    why = because(Reason.ONE_CLOCK, fault=summer.brief, evidence=summer.evidence)
    if not summer.explained:
        why = because(Reason.NOT_CORRECTED, fault=fault, remedy=summer.line)
    values = {"summer": 60.0} if summer.zone else {}
    values |= {str(day.date()): by / 60.0 for day, by in summer.jumps}
    check = Check(noon, "", summer.after, summer.before, most=True, unit="min")
    return Correction(
        fault=summer.fault,
        columns=("all",),
        values=values,
        stderr={},
        before=summer.before,
        after=summer.after,
        unit="min",
        because=why,
        checks=(check,) if summer.explained else (),
        applied=summer.explained,
    )


def zone_of_the_sun(index: pd.DatetimeIndex, late: float, location: Location) -> str:
    """The zone in which times fit the sun that is late in theirs, or none."""
    utc = index if index.tz is not None else standard_time(index, location)
    own = index.tz_localize(None) - utc.tz_convert("UTC").tz_localize(None)
    hours = own[0] / pd.Timedelta(hours=1) + late / 3600.0
    whole = round(hours)
    if own[0] != own[-1] or abs(hours - whole) > NEAR_HOUR or not -12 <= whole <= 14:
        return ""
    return f"Etc/GMT{-whole:+d}"  # this zone's sign is reversed


def uncorrected_shift(fault: str, late: float, zone: str) -> Correction:
    """The report on a file whose times do not fit the sun; it is not corrected."""
    fits = f" (the sun fits {zone})" if zone else ""
    remedy = (
        f"give the times the zone that they are in{fits}, or set the location right; "
        f"{SUNLESS}"
    )
    minutes = late / 60.0
    return uncorrected("file_shift", fault, remedy, abs(minutes), {"late": minutes})


def uncorrected(
    name: str,
    fault: str,
    remedy: str,
    error: float = np.nan,
    values: dict[str, float] | None = None,
) -> Correction:
    """The report on a fault of times or place that the user alone can set right."""
    return Correction(
        fault=name,
        columns=("all",),
        values=values or {},
        stderr={},
        before=error,
        after=error,
        unit="min",
        because=because(Reason.NOT_CORRECTED, fault=fault, remedy=remedy),
        applied=False,
    )
