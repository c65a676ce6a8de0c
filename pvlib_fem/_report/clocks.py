"""Pictures of clocks by date: the file against the sun, the module against light."""

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pvlib_fem._findings import Correction
from pvlib_fem._record.inputs import Record
from pvlib_fem._report.rows import Picture, Rows
from pvlib_fem.plotting._evidence import Daily
from pvlib_fem.quality._noon import solar_noon_shift
from pvlib_fem.quality._onset import DAY, solar_midnight

if TYPE_CHECKING:
    from pvlib_fem._loop.results.corrected_times import Times
    from pvlib_fem._loop.results.loop_result import Loop

BRIGHT_DAY = 0.3  # of the light of a bright day; darker days have no clear middle
WHOLE = 0.8  # of the usual rows of a day


def picture_of_clock(correction: Correction, loop: "Loop") -> Picture | None:
    """
    The clock that a correction is of, by date.

    Parameters
    ----------
    correction : Correction
    loop : Loop
        With its rows.

    Returns
    -------
    Picture or None
        None where no day shows it.
    """
    rows = Rows(loop)
    if correction.fault.startswith("file"):
        return of_file(rows, correction)
    return of_module(rows, correction)


def of_file(rows: Rows, correction: Correction) -> Picture | None:
    """The middle of each day's light against the sun."""
    if rows.location is None:
        return None
    place = (rows.location, *(rows.plane or (None, None)))
    noon = solar_noon_shift(rows.record["poa_global"], rows.index, *place)
    days = pd.DatetimeIndex(noon.days.index).tz_localize(None)
    minutes = noon.days.to_numpy() / 60.0
    if len(days) < 2:
        return None
    added = added_minutes(rows.loop.times, days)
    series = clock_before_and_after(correction, days, minutes, added)
    caption = "Middle of each day's light minus that of the sun at the location"
    return rows.by_date(series, "ahead of the sun [min]", caption)


def of_module(rows: Rows, correction: Correction) -> Picture | None:
    """The middle of each day's warmth against that of its light."""
    record = rows.record
    days, minutes = warmth_after_light(record)
    if len(days) < 2:
        return None
    seconds = (days - record.index[0].tz_localize(None)).total_seconds()
    late = np.zeros(len(days))
    if (times := rows.loop.times) is not None:
        late = times.module.late_at(np.asarray(seconds)) / 60.0
    series = clock_before_and_after(correction, days, minutes, -late)
    caption = (
        "Middle of each day's temperature rise of the module minus that of its "
        "irradiance; a module answers some minutes late"
    )
    return rows.by_date(series, "module after irradiance [min]", caption)


def clock_before_and_after(
    correction: Correction,
    days: pd.DatetimeIndex,
    minutes: np.ndarray,
    by: np.ndarray,
) -> dict[str, Daily]:
    """A clock as the file has it and as corrected, by what was added. [min]"""
    if not correction.applied:
        return {"as in the file": Daily(days, minutes)}
    return {
        "corrected": Daily(days, minutes),
        "as in the file": Daily(days, minutes - by),
    }


def added_minutes(times: "Times | None", days: pd.DatetimeIndex) -> np.ndarray:
    """What was added to the file's times on some days. [min]"""
    if times is None or not times.offsets:
        return np.zeros(len(days))
    begins = pd.DatetimeIndex([time for time, _ in times.offsets])
    by = np.array([seconds for _, seconds in times.offsets]) / 60.0
    noon = days + pd.Timedelta(hours=12)
    return by[np.maximum(begins.searchsorted(noon, side="right") - 1, 0)]


def warmth_after_light(record: Record) -> tuple[pd.DatetimeIndex, np.ndarray]:
    """Days, and by how much the middle of their warmth is after that of light. [min]"""
    seconds, poa = record.inputs.seconds, np.asarray(record["poa_global"])
    front = solar_midnight(seconds, poa)
    over = record["temp_module"] - record["temp_air"]
    over = np.maximum(
        over - np.nanmedian(over[poa <= 0.0]) if (poa <= 0).any() else over, 0.0
    )
    kept = np.isfinite(over) & np.isfinite(poa)
    when = (seconds - front)[kept]
    day = np.floor(when / DAY).astype(int)
    numbers, place, count = np.unique(day, return_inverse=True, return_counts=True)
    clock = when - day * DAY
    light, warmth = (np.bincount(place, one[kept]) for one in (poa, over))
    with np.errstate(divide="ignore", invalid="ignore"):
        middles = [
            np.bincount(place, clock * one[kept]) / whole
            for one, whole in ((over, warmth), (poa, light))
        ]
    after = (middles[0] - middles[1]) / 60.0
    good = np.isfinite(after) & (count >= WHOLE * np.median(count))
    good &= light > BRIGHT_DAY * np.quantile(light, 0.9)
    start = record.index[0].tz_localize(None) + pd.Timedelta(seconds=float(front))
    days = start + pd.to_timedelta((numbers[good] + 0.5) * DAY, unit="s")
    return pd.DatetimeIndex(days).normalize(), after[good]
