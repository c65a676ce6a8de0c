"""A module's temperature sensor that has come off and reads the air."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._record.clean import spans
from pvlib_fem._statistics.changing_level import Law, most_probable
from pvlib_fem.quality._limits import GAIN

DETACHED = "module_sensor_detached"  # name of the fault
SUNNY = 200.0  # W/m², above which a module is warmer than the air
THAWED = 3.0  # °C that a module under snow does not exceed, with the sensor's error
FEWEST = 5  # sunny days
LASTS = 10  # days of a level that is the attached sensor's
LOWEST = 1e-3  # K m²/W, what stands for none
LAW = Law(
    np.arange(-4.0, 3.0, 0.1),  # logarithms; a sensor may be off on most days
    odds=1e-4,
    accident=0.1,
    least=0.1,
    fine=0.05,
    memory=2.0,
    swing=0.2,
)
#: share of the attached sensor's temperature rise below which a sensor is off; a poor
#: contact shows more
MAX_SHARE = 0.25
HALF = 0.5  # of what the attached sensor shows, or of the days with sun
MAX_APART = 0.1  # share of sunny rows in which it may all the same
EDGE = 2  # sunny days on each side of an edge, in which its time is looked for
NEAR = 30  # sunny days on each side, which it is compared with


@dataclass(frozen=True, eq=False)
class SunnyDays:
    """
    What a module's temperature sensor shows of the sun, day by day.

    Attributes
    ----------
    rows : array of int, shape (rows,)
        Sunny rows in which a module is not under snow.
    place : array of int, shape (rows,)
        Day of each of them, by its place among the days.
    days : array of int, shape (days,)
        Days since 1970-01-01 that have such rows.
    rise : array, shape (days,)
        Temperature rise over air by irradiance. [K m²/W]
    lit : array of int, shape (lit days,)
        Days with sun, with those on which the module may be under snow.
    """

    rows: np.ndarray
    place: np.ndarray
    days: np.ndarray
    rise: np.ndarray
    lit: np.ndarray

    def thawed(self, first: int, end: int) -> float:
        """Share of the days with sun, from one day to another, without snow."""
        start = self.days[first] if first else self.lit[0]
        stop = self.days[end - 1] if end < len(self.days) else self.lit[-1]
        edges = start, stop + 1
        return (end - first) / max(int(np.ptp(np.searchsorted(self.lit, edges))), 1)


def sunny_days(
    module: np.ndarray, air: np.ndarray, poa: np.ndarray, dates: np.ndarray
) -> SunnyDays:
    """
    The sunny rows of a record, and the temperature rise of each day.

    Parameters
    ----------
    module, air, poa : array, shape (rows,)
        Module and air temperature [°C], irradiance [W/m²].
    dates : array of int, shape (rows,)
        Days since 1970-01-01.

    Returns
    -------
    SunnyDays
    """
    lit = np.flatnonzero((poa > SUNNY) & np.isfinite(module + air))
    rows = lit[module[lit] > THAWED]
    days, place = np.unique(dates[rows], return_inverse=True)
    rise = np.bincount(place, (module - air)[rows]) / np.bincount(place, poa[rows])
    return SunnyDays(rows, place, days, rise, np.unique(dates[lit]))


def detached_days(
    days: np.ndarray, rise: np.ndarray, max_share: float
) -> tuple[np.ndarray, float]:
    """
    Days on which a sensor is off, by a level that changes seldom.

    Parameters
    ----------
    days : array of int, shape (days,)
        Number of each day.
    rise : array, shape (days,)
        Temperature rise over air by irradiance. [K m²/W]
    max_share : float
        Share of the attached sensor's level below which it is off.

    Returns
    -------
    off : array of bool, shape (days,)
    attached : float
        Highest level that lasts ten days; NaN if it is none of a module. [K m²/W]
    """
    logs = np.log(np.maximum(rise, LOWEST))
    middle = np.median(logs)
    path = most_probable(days, logs - middle, LAW)
    residual = logs - path.usual - path.level
    levels, lasts = np.unique(path.level, return_counts=True)
    height = {
        one: float(np.exp(np.median((residual + path.usual + one)[path.level == one])))
        for one in levels
    }
    long = [
        one for one, number in zip(levels, lasts) if number >= min(LASTS, len(days))
    ]
    possible = [height[one] for one in long if height[one] <= GAIN[1]]
    best = max(possible, default=np.nan)
    least = np.fmax(GAIN[0], max_share * best)
    off = np.array([height[one] < least for one in path.level], dtype=bool)
    return off, float(best) if best >= GAIN[0] else np.nan


@dataclass(frozen=True)
class Detachment:
    """
    A time in which a module's temperature sensor reads the air.

    Attributes
    ----------
    start, end : str
        First time at which it is off, and first at which it is on again; "" if it is
        off from the first row, or until the last.
    after, last : str
        Last sunny time at which it was on, "" if there is none, and last sunny time at
        which it is off. It came off between ``after`` and ``start``, and was fixed
        between ``last`` and ``end``.
    days : int
        Sunny days that show it.
    rise, attached : float
        Temperature rise over air by irradiance that it shows, and that of the days
        before and after. [K m²/W]
    rows : int
        Module temperatures that are left out.
    fitting : bool
        Whether the fitting weeks alone show it. Otherwise only rows of test weeks are
        left out.
    """

    start: str
    end: str
    after: str
    last: str
    days: int
    rise: float
    attached: float
    rows: int = 0
    fitting: bool = True

    @property
    def when(self) -> str:
        """Its days in words: since when, perhaps between two days, and until when."""
        if not self.start:
            return f"until {self.last[:10]}"
        after, start = self.after[:10], self.start[:10]
        words = f"from {start}" + (f" ({after} to {start})" if after < start else "")
        return f"{words} until {self.last[:10]}" if self.end else f"{words} on"

    def rows_of(self, index: pd.DatetimeIndex) -> np.ndarray:
        """Rows of some times in which it is off, or may be."""
        local = index.tz_localize(None)
        inside = np.ones(len(local), dtype=bool)
        if self.after:
            inside &= np.asarray(local > pd.Timestamp(self.after))
        if self.end:
            inside &= np.asarray(local < pd.Timestamp(self.end))
        return inside

    def __str__(self) -> str:
        weeks = (
            "" if self.fitting else " of test weeks, since the others do not show it"
        )
        return (
            f"temp_module is close to temp_air {self.when}: on {self.days} sunny days "
            f"it rises {1000 * self.rise:.1f} K over air by 1000 W/m², and "
            f"{1000 * self.attached:.1f} K before or after, so that the sensor has "
            f"come off; {self.rows:,} rows{weeks} are not used"
        )


@dataclass(frozen=True, eq=False)
class SunnyRows:
    """Sunny rows in their order, with what the module and the air show in them."""

    place: np.ndarray  # of the day of each row
    module: np.ndarray
    air: np.ndarray
    poa: np.ndarray
    power: np.ndarray | None

    @property
    def over(self) -> np.ndarray:
        """Temperature of the module over the air. [K]"""
        return self.module - self.air

    def of_days(self, days: Any) -> "SunnyRows":
        """The rows of some days, by their places."""
        return self.part(np.isin(self.place, days))

    def part(self, rows: Any) -> "SunnyRows":
        """Some of the rows."""
        power = None if self.power is None else self.power[rows]
        return SunnyRows(
            self.place[rows], self.module[rows], self.air[rows], self.poa[rows], power
        )

    def response(self, values: np.ndarray) -> float:
        """By how much a temperature follows irradiance within days. [K m²/W]"""
        days = self.place - self.place.min()
        rows = np.maximum(np.bincount(days), 1)
        mean = np.bincount(days, self.poa) / rows
        light = self.poa - mean[days]
        square = light @ light
        return float(light @ values / square) if square > 0.0 else 0.0

    def rise_in(self, others: "SunnyRows") -> float:
        """
        Temperature rise by irradiance that the sensor would show in other rows.

        A line, since heat that goes to the sky takes more of it in weak light.
        """
        slope, start = np.polyfit(self.poa, self.over, 1)
        return float(slope + start / others.poa.mean())

    def share_of_air(self) -> float:
        """By how much the module's temperature follows the air's. [K/K]"""
        columns = [np.ones(len(self.air)), self.poa, self.air]
        return float(np.linalg.lstsq(np.column_stack(columns), self.module)[0][2])

    def power_by_irradiance(self) -> float:
        """Power by irradiance; NaN where power is unknown."""
        if self.power is None or not (known := np.isfinite(self.power)).any():
            return np.nan
        return float(self.power[known].sum() / self.poa[known].sum())


def detachments_of(
    module: np.ndarray,
    air: np.ndarray,
    poa: np.ndarray,
    index: pd.DatetimeIndex,
    dates: np.ndarray,
    power: np.ndarray | None = None,
) -> list[tuple[Detachment, int, int]]:
    """
    Times in which a module's temperature sensor is off, and their rows.

    A sensor that is off shows less than a quarter of the temperature rise of the days
    before and after, on a level of its own (see :func:`detached_days`), at almost all
    times, also where the modules are in the sun. It follows the air, which a stuck one
    does not. It is the module's temperature that no longer follows irradiance within
    days; if the air follows it instead, the air thermometer is at fault. Modules under
    a cover have no power.

    Parameters
    ----------
    module, air, poa : array, shape (rows,)
        Module and air temperature [°C], irradiance [W/m²].
    index : DatetimeIndex, length rows
    dates : array of int, shape (rows,)
        Days since 1970-01-01.
    power : array, shape (rows,), optional
        In any unit.

    Returns
    -------
    list of (Detachment, int, int)
        With the first row that is left out, and the one after the last.
    """
    sunny = sunny_days(module, air, poa, dates)
    rise, days = sunny.rise, sunny.days
    if len(days) < FEWEST:
        return []
    low = rise < max(GAIN[0], MAX_SHARE * np.quantile(rise, 0.9))
    if np.count_nonzero(low) < FEWEST:  # as in almost every record
        return []
    off = detached_days(days, rise, MAX_SHARE)[0]
    rows = sunny.rows
    light = SunnyRows(
        sunny.place,
        module[rows],
        air[rows],
        poa[rows],
        None if power is None else power[rows],
    )
    on, runs = np.flatnonzero(~off), spans(np.flatnonzero(off))
    found = []
    for first, end in runs.tolist():
        sides = [on[on < first][-NEAR:], on[on >= end][:NEAR]]
        sides = [side for side in sides if len(side) >= LASTS]
        # where modules are mostly below freezing, snow may lie on other days, too
        if not sides or sunny.thawed(first, end) < HALF:
            continue
        shown = light.of_days(np.arange(first, end))
        attached = min(light.of_days(side).rise_in(shown) for side in sides)
        level = float(np.median(rise[first:end]))
        near = light.of_days(np.concatenate(sides))
        # the rise in the weak light of another season is known less well
        weak = min(shown.poa.mean() / near.poa.mean(), 1.0)
        if (
            not GAIN[0] <= attached <= GAIN[1]
            or abs(level) > MAX_SHARE * weak * attached
        ):
            continue
        since, until = rows_off(light, first, end, runs, (attached, level))
        if until <= since or not shows_air(light.part(slice(since, until)), near):
            continue
        begins, ends = since > 0, until < len(rows)
        after, start, last, back = (
            f"{index[rows[np.clip(row, 0, len(rows) - 1)]]:%Y-%m-%d %H:%M:%S}"
            for row in (since - 1, since, until - 1, until)
        )
        one = Detachment(
            start=start if begins else "",
            end=back if ends else "",
            after=after if begins else "",
            last=last,
            days=end - first,
            rise=level,
            attached=attached,
        )
        first_out = int(rows[since - 1]) + 1 if begins else 0
        found.append((one, first_out, int(rows[until]) if ends else len(module)))
    return found


def rows_off(
    light: SunnyRows,
    first: int,
    end: int,
    runs: np.ndarray,
    levels: tuple[float, float],
) -> tuple[int, int]:
    """
    First sunny row in which a sensor is off, and the one after the last.

    Parameters
    ----------
    light : SunnyRows
        Of the record.
    first, end : int
        First day of a run of days on which it is off, and the one after the last.
    runs : array of int, shape (runs, 2)
        The same of all runs.
    levels : tuple of float
        Temperature rise by irradiance, on and off. [K m²/W]

    Returns
    -------
    int, int
    """
    days = int(light.place[-1]) + 1
    # the days next to a run may be those on which it came off, or was fixed
    before = max([first - EDGE, 0, *runs[runs[:, 1] <= first, 1].tolist()])
    behind = min([end + EDGE, days, *runs[runs[:, 0] >= end, 0].tolist()])
    edges = [before, min(first + EDGE, end), max(end - EDGE, first), behind]
    start, inside, within, stop = np.searchsorted(light.place, edges).tolist()
    since, until = 0, len(light.place)
    if first > 0:
        since = start + came_off(light.part(slice(start, inside)), *levels)
    if end < days:
        rows = np.arange(within, stop)[::-1]
        until = stop - came_off(light.part(rows), *levels)
    return since, until


def came_off(rows: SunnyRows, attached: float, rise: float) -> int:
    """
    From which of some rows on a sensor is off, by least absolute deviations.

    Parameters
    ----------
    rows : SunnyRows
        On at first, then off.
    attached, rise : float
        Temperature rise by irradiance, on and off. [K m²/W]

    Returns
    -------
    int
        Up to the number of rows, if it is on in all.
    """
    over = rows.over
    on, off = (np.abs(over - level * rows.poa) for level in (attached, rise))
    cost = np.append(0.0, np.cumsum(on - off))
    return int(np.argmin(cost))


def shows_air(rows: SunnyRows, near: SunnyRows) -> bool:
    """Whether rows are of a sensor in the air, compared with those of it attached."""
    level = near.rise_in(rows)
    if np.mean(np.abs(rows.over) > HALF * level * rows.poa) > MAX_APART:
        return False
    if rows.share_of_air() < HALF:
        return False
    falls = near.response(near.module) - rows.response(rows.module)
    rises = rows.response(rows.air) - near.response(near.air)
    if falls < rises:
        return False
    return not rows.power_by_irradiance() < HALF * near.power_by_irradiance()
