"""A user's frame as the loop takes it: checked, and its file's clock corrected."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
from pvlib.location import Location

from pvlib_fem._findings import Correction
from pvlib_fem._fitting.horizontal import refuse_clock
from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._loop.preparation.divided_record import Case
from pvlib_fem._loop.preparation.file_clock import clock_jumps, faults_of_place
from pvlib_fem._loop.preparation.replacements import NOTHING, Replacements
from pvlib_fem._loop.preparation.screened_frame import Look, screened_frame
from pvlib_fem._record.column_names import (
    GEOMETRY,
    doubts_of_power,
    is_power,
    plant_power,
    twin_of,
)
from pvlib_fem._record.inputs import Record
from pvlib_fem._record.names import unmapped
from pvlib_fem._statistics.clusters import calendar_weeks
from pvlib_fem.drivers import geometry, needed_for
from pvlib_fem.drivers._mounts import ANGLES, PLANE, angles_at, axis_of, is_known
from pvlib_fem.drivers._planes import ByColumns
from pvlib_fem.effects import EffectLike
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._testable_effects import candidates, candidates_about_axis
from pvlib_fem.effects._time_profiles import date_text
from pvlib_fem.quality._irradiance_clock import twin_clock
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._noon import label_lines, lateness_of
from pvlib_fem.quality._plane import Plane, fixed_rather, plane_of
from pvlib_fem.quality._tracker_standstill import Standing, standing_of
from pvlib_fem.quality._unit_checks import options_of
from pvlib_fem.reasons import Reason, because

UNSEEN_CLOCK = 120.0  # s, by which the module's clock may be off unseen
FAR_ZONE = 3.0  # h between a record's clock and the sun; no zone of a place has more
#: faults with which the sun is elsewhere
OFF_THE_SUN = ("file_shift", "file_dst", "file_jump", "file_latitude")


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
    how = (site, criteria, check_units, instead, spared)
    look = screened_frame(data, holdout, *how)
    kept = np.ones(len(look.held_out), dtype=bool)
    summer, corrections = clock_jumps(look, criteria.limits)
    if summer is not None:
        holdout = None if holdout is None else summer.corrected(holdout)
        look = screened_frame(summer.corrected(data), holdout, *how)
        kept = np.asarray(summer.kept)
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
    corrections += faults_of_place(look, site, other)
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
    label = 0.0 if off else look.label
    late = lateness_of(label, whole.index)
    stood = with_standings(site, whole.index, standings, late)
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
        site=stood if sun else dict.fromkeys(site),
        place=site,
        clock=look.health.clock,
        criteria=criteria,
        fixed=dict(fixed or {}),
        kept=kept,
        notes=(
            *([] if plane is None else [f"the module's plane is estimated: {plane}"]),
            *map(str, look.detachments),
            *map(str, standings),
            *fitted_weeks(spared),
            *label_lines(label if sun else 0.0),
            *notes_of(look, corrections, wanted, site, criteria),
        ),
        corrections=tuple(corrections),
        another_plane=other,
        late=look.late,
        label=label,
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
    site: dict[str, Any],
    index: pd.DatetimeIndex,
    standings: tuple[Standing, ...],
    late: float,
) -> dict[str, Any]:
    """The site with the angles at which its sensor stood, on those days."""
    if not standings:
        return site
    columns = geometry(index, **site, late=late)
    angles = {name: columns[name].to_numpy(copy=True) for name in ANGLES}
    for one in standings:
        one.put_into(angles, index)
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


def fitted_weeks(spared: Collection[int]) -> Iterator[str]:
    """A line on each week that would be a test week without a change in it."""
    weeks = {int(calendar_weeks(np.array(day))): day for day in sorted(spared)[::-1]}
    for first in sorted(weeks.values()):
        yield (
            f"the week from {date_text(first)} on is fitted and not a test week: a "
            "change of a sensor or a standstill may begin or end in it"
        )


def used_record(look: Look, sun: Collection[str]) -> tuple[Record, np.ndarray]:
    """The record of what is used, without the sun, and the rows that may count."""
    unused, whole = look.unused, look.whole
    others = {*look.refused, *sun}  # of which the second is added where it is needed
    kept = [name for name in whole.inputs.columns if name not in others]
    blank = {name: rows for name, rows in look.health.frozen.items() if name in kept}
    blank["temp_module"] = unused | blank.get("temp_module", False)
    # what needs no gap is no copy
    blank = {name: rows for name, rows in blank.items() if rows.any()}
    columns = whole.inputs.columns.only(kept).put(np.nan, blank)
    return replace(whole, inputs=replace(whole.inputs, columns=columns)), ~unused


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
