"""A user's frame as its sensors and clocks show it, before any fit."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._loop.preparation.outputs import outputs
from pvlib_fem._loop.preparation.planes import plane_of_columns
from pvlib_fem._loop.preparation.replacements import Filled, Replacements
from pvlib_fem._record.column_names import (
    ALWAYS,
    COLUMNS,
    is_cross_check,
    is_power,
    numeric,
    usable_drivers,
)
from pvlib_fem._record.filters import counted
from pvlib_fem._record.inputs import Record, as_record, with_columns
from pvlib_fem._statistics.clusters import calendar_weeks
from pvlib_fem.drivers import DERIVED, MODELLED
from pvlib_fem.quality._check import Health, check
from pvlib_fem.quality._detached_sensor import Detachment, detachments_of
from pvlib_fem.quality._irradiance_clock import twin_clock
from pvlib_fem.quality._lag import by_module_logger
from pvlib_fem.quality._limits import Limits
from pvlib_fem.quality._module_lag import Clock
from pvlib_fem.quality._noon import label_by_sun
from pvlib_fem.quality._screen import Faults, screened_alone
from pvlib_fem.quality._screening import stuck_rows
from pvlib_fem.quality._stray_times import refuse_stray
from pvlib_fem.quality._stuck import stuck_line
from pvlib_fem.quality._unit_checks import oddities, options_of
from pvlib_fem.reasons import Because, Reason, because

FEWEST_WEEKS = 5  # below which every other day is a test day


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
    unused: np.ndarray  # rows of a stuck sensor, or with the module's sensor off
    detachments: tuple[Detachment, ...]  # of that sensor
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

    @property
    def label(self) -> float:
        """From the middle of its step to the time of a row, by the sun. [steps]"""
        return label_by_sun(self.late, self.whole.inputs.step)


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

    Parameters
    ----------
    data, holdout, site, criteria, check_units, instead, spared
        See :func:`pvlib_fem._loop.preparation.prepare.prepared_case`.

    Returns
    -------
    Look
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
    plane = filled.plane(site)
    health = check(hidden, limits=limits, light=light, known=faults.look, **plane)
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
    stuck = health.mask | still
    detachments, off = detached_rows(hidden, whole, test, stuck, health.clock)
    timed = in_time(hidden, health.clock).inputs
    powers = [*filter(is_power, (*drivers, *comparing))]
    untimed, lines = powers_off_time(whole, powers, health.clock, limits)
    odd = (*oddities(timed, limits, hidden.absent, timed=True), *lines)
    return Look(
        whole=whole.lacking(untimed),
        held_out=test,
        drivers=drivers,
        cross_check_columns=comparing,
        refused=refused,
        faults=faults,
        odd=odd,
        health=health,
        unused=stuck | off,
        detachments=detachments,
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


def powers_off_time(
    record: Record, powers: Sequence[str], clock: Clock, limits: Limits
) -> tuple[dict[str, np.ndarray], list[str]]:
    """
    Rows in which the clock of each power is not that of irradiance, and lines.

    A power that the module's logger wrote, whose ``clock`` is corrected, is compared as
    it is then.
    """
    off, lines, seconds = {}, [], record.inputs.seconds
    columns = record.inputs.columns.only(["poa_global", *powers])
    if clock.fault:
        columns |= by_module_logger(columns, lambda one: clock.corrected(seconds, one))
    for name in powers:
        both = columns["poa_global"], columns[name]
        found = twin_clock(*both, record.index, limits)
        if found.off.any():
            off[name] = found.off
            days = len(np.unique(record.dates[found.off]))
            lines.append(
                f"{name} is not used on {days:,} days: its timestamps {found.line}; "
                "bring them to one clock"
            )
    return off, lines


def detached_rows(
    hidden: Record,
    whole: Record,
    test: np.ndarray,
    stuck: np.ndarray,
    clock: Clock,
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
        own = record.lacking({"temp_module": stuck}) if stuck.any() else record
        some = detachments_in(own, clock)
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
    own, answer = screened_alone(
        own, limits, check_units=False, names=(name,), known=faults.look
    )
    answered, came = np.where(test, own[name], hidden[name]), usual[name]
    # as it came it needs no room of its own
    same = np.array_equal(answered, came, equal_nan=True)
    whole = hidden.having({name: came if same else answered})
    before = faults.record.having({name: came})
    faults = replace(faults.and_in(test, answer), record=before)
    still = {n: test & rows for n, rows in stuck_rows(own, limits, answer.look).items()}
    both = {n: rows | still.get(n, False) for n, rows in health.frozen.items()}
    if any(rows.any() for rows in both.values()):
        line = {"stuck": stuck_line(whole, both)}
        # the first of the faults
        health = replace(health, faults=line | health.faults | line)
    whole = replace(whole, impossible=faults.impossible)
    return whole, np.any(list(still.values()), axis=0), faults, health
