"""Find outages, covers and low power by power and the module's temperature."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem._budget.stretch_noise import DayNoise, Noise
from pvlib_fem._budget.unusual_days import AROUND
from pvlib_fem._converter import AnyFloat
from pvlib_fem.drivers._plant_irradiance import (
    LEAST,
    MISSING,
    NONE,
    irradiances_agree,
    lost_irradiance,
)
from pvlib_fem.power import BRIGHT

FEWEST = 2  # least hours of an event: one hour may have two states
FAINT, DIM = 0.05, 20.0  # least difference of irradiance, as a share and in W/m²
MOST = 3.0  # largest temperature difference, over that of the cover
#: least difference of power, in standard deviations of means, if the temperature has to
#: differ, too: by chance both do so once in decades
BOTH = 3.0
WINDOW = f"{2 * AROUND + 1}D"  # of days whose median is usual
SEEN = 2.0  # least difference of temperature, in standard deviations of means
SHARES = {"modules_covered": 1.0, "sensor_covered": 1.0, "outage": 0.2}
TIMES = ("start", "end")
NUMBERS = ["size", "share", "power", "energy", "gain", "temp_air"]
COLUMNS = ["effect", *TIMES, "hours", *NUMBERS]
SUMS = ("energy", "portion")  # of the columns of rows that are no means
NEW = ("energy", "gain")  # that files of before do not have


@dataclass(frozen=True, eq=False)
class Hours:
    """
    Means over the hours of a record with light.

    Attributes
    ----------
    begin, end : DatetimeIndex
        First and last row of each hour.
    number : array of int
        Number of the hour, since 1970-01-01.
    residual : array
        Measured minus modelled temperature, without effects from power. [K]
    squares : array
        Sum of squares of the residual. [K²]
    seen, shown : array
        Irradiance by the sensor and by power. [W/m²]
    power, expected : array
        [unit of power]
    loss : array
        [W/(m² K)]
    energy : array
        Energy of the hour minus that expected. [kWh/kWp]
    portion : array
        Rows that count, over all rows of the record that do. [-]
    off : array of bool
        Hours without power, for another reason than snow.
    extra : dict of array
        Further columns of the report.
    """

    begin: pd.DatetimeIndex
    end: pd.DatetimeIndex
    number: np.ndarray
    residual: np.ndarray
    squares: np.ndarray
    seen: np.ndarray
    shown: np.ndarray
    power: np.ndarray
    expected: np.ndarray
    loss: np.ndarray
    energy: np.ndarray
    portion: np.ndarray
    off: np.ndarray
    extra: dict

    @classmethod
    def from_columns(
        cls, index: pd.DatetimeIndex, rows: np.ndarray, columns: dict, extra: dict
    ) -> "Hours":
        """The hours of some rows of columns."""
        index = index[rows]
        columns, extra = (
            {name: column[rows] for name, column in some.items()}
            for some in (columns, extra)
        )
        naive = index.tz_localize(None)
        number = naive.to_numpy().astype("datetime64[h]").astype(int)
        first = np.flatnonzero(np.diff(number, prepend=number[:1] - 1))
        size = np.diff(first, append=len(number))

        def means(values: np.ndarray) -> np.ndarray:
            return np.add.reduceat(values, first) / size

        hourly = {name: means(values) for name, values in columns.items()}
        hourly |= {name: hourly[name] * size for name in SUMS}
        squares = np.add.reduceat(columns["residual"] ** 2, first)
        # with less light, no row is in the fit of expected power
        light = (hourly["seen"] > BRIGHT) | (hourly["shown"] > BRIGHT)
        hourly = {name: values[light] for name, values in hourly.items()}
        return cls(
            index[first][light],
            index[first + size - 1][light],
            number[first][light],
            squares=squares[light],
            off=hourly.pop("off") > 0.5,
            extra={name: means(values)[light] for name, values in extra.items()},
            **hourly,
        )

    @cached_property
    def counts(self) -> np.ndarray:
        """Hours that say what is usual: no fit has those of frozen modules."""
        return self.portion > 0.0

    def beyond_usual(self, values: np.ndarray, far: np.ndarray) -> np.ndarray:
        """
        Values minus their median at the same hour of the days around.

        Where power is far from irradiance in most of these hours, as in weeks of snow,
        the median is that of the others. Hours of frozen modules are in none, since no
        fit has them.
        """
        usual, clock = np.zeros(len(values)), self.number % 24
        for hour in np.unique(clock):
            rows = np.flatnonzero(clock == hour)
            days = pd.to_timedelta(self.number[rows] // 24, unit="D")
            every = pd.Series(np.where(self.counts[rows], values[rows], np.nan), days)
            near = every.where(~far[rows]).rolling(WINDOW, center=True)
            every = every.rolling(WINDOW, center=True)
            most = near.count() > 0.5 * every.count()
            median = every.median().where(most, near.median())
            usual[rows] = median.interpolate(limit_direction="both").fillna(0.0)
        return values - usual

    def gain(self, some: slice) -> float:
        """Root of the fall of the mean square without the mean of some hours. [K]"""
        portion, residual = self.portion[some], self.residual[some]
        if not portion.any():  # hours of frozen modules alone
            return 0.0
        return float(abs(portion @ residual) / np.sqrt(portion.sum()))

    def days(self) -> np.ndarray:
        """Hours before which another day, or a gap, begins."""
        new = np.diff(self.number, prepend=-2) > 1
        return new | (np.diff(self.number // 24, prepend=-1) > 0)


def events_in(hours: Hours, spread: float, total: float, shares: dict) -> pd.DataFrame:
    """
    Events of some hours, as a table.

    If power deviates from its expectation for two hours or more of a day, the module's
    temperature decides: it is nearer to its value with a cover, or without one. If
    power deviates less, both have to differ from their usual values at the same hours.
    An hour without power and without a cover is an outage, and one with less power than
    expected is underperformance, if a cover would be visible.

    Parameters
    ----------
    hours : Hours
    spread : float
        Spread of the relation of power to irradiance. [-]
    total : float
        Sum of squares for the shares. [K²]
    shares : dict of float
        Coefficient of each effect in the model by its name; defaults for other effects.
        [-]

    Returns
    -------
    DataFrame
        See :func:`event_table`, the largest energy first.
    """
    if len(hours.number) < 2 * FEWEST:
        return event_table([], hours.extra)
    deciding = Deciding.from_hours(hours, spread, SHARES | shares)
    state = deciding.state
    kinds = np.full(len(state), "", dtype=object)
    for start, end in runs(state, hours.days()):
        if state[start] and end - start >= FEWEST:
            some = slice(start, end)
            kinds[some] = deciding.kind(some)
    spans = event_spans(kinds, deciding.shows_none, deciding.state)
    return event_table(rows_of_events(hours, spans, kinds, total), hours.extra)


@dataclass(frozen=True, eq=False)
class Deciding:
    """Data that decide which effect a stretch of hours has."""

    hours: Hours
    far: np.ndarray  # hours on which power is far from irradiance
    apart: np.ndarray  # light by power beyond usual, over that by the sensor [-]
    shown: np.ndarray  # light by power, where it is near that beyond usual [W/m²]
    state: np.ndarray  # −1 where power shows less light, 1 where more
    warmth: Noise  # of the residual [K]
    strange: DayNoise  # residual beyond usual [K]
    light: Noise  # of ``apart`` [-]
    shares: dict

    @classmethod
    def from_hours(cls, hours: Hours, spread: float, shares: dict) -> "Deciding":
        seen = hours.seen
        far = ~irradiances_agree(seen, hours.shown, spread)
        counts = hours.counts
        apart = hours.beyond_usual((hours.shown - seen) / np.fmax(seen, LEAST), far)
        shown = np.where(far, hours.shown, seen * (1.0 + apart))
        faint = np.abs(shown - seen) > np.maximum(max(FAINT, 2.0 * spread) * seen, DIM)
        faint &= seen > BRIGHT
        state = np.where(far | faint & counts, np.sign(shown - seen), 0.0).astype(int)
        usual = counts & (state == 0)
        for _ in range(2):
            state = bridged(state, hours.days())
        strange = hours.beyond_usual(hours.residual, far)
        days = DayNoise(strange, hours.number, counts & (state == 0))
        noise = Noise(hours.residual[usual]), days, Noise(apart[counts])
        return cls(hours, far, apart, shown, state, *noise, shares)

    @property
    def shows_none(self) -> np.ndarray:
        """Hours that are bright enough to show a deviation of 15 %, and have none."""
        seen = self.hours.seen
        usual = (self.state == 0) & (seen > DIM / MISSING)
        return usual | ~self.far & (seen > LEAST / MISSING)

    def kind(self, some: slice) -> str:
        """The effect of a stretch of hours; "" for none."""
        hours, length = self.hours, some.stop - some.start
        if self.far[some].mean() <= 0.5:
            return self.faint(some, length)
        if self.state[some.start] > 0:
            covered = self.follows(some, length, self.hot(some))
            return "sensor_covered" if covered else ""
        expected, cold = hours.expected[some], self.cold(some)
        dead = hours.power[some] < NONE * expected
        if (
            not expected[dead].sum() > 0.5 * expected.sum()
        ):  # at its ends it may be half
            if self.follows(some, length, cold):
                return "modules_covered"
            return "underperformance" if self.excludes(some, length, cold) else ""
        warm = self.makes("outage", hours.seen, some)
        if warm - cold > SEEN * self.warmth.std_of_mean(length):
            size = hours.residual[some].mean()
            return "modules_covered" if size < 0.5 * (cold + warm) else "outage"
        return "outage" if hours.off[some].all() else ""

    def follows(self, some: slice, length: int, made: float) -> bool:
        """
        Whether the temperature is nearer to its value with a cover than without one.

        The residual decides, or its difference from the days around and the rest of
        the day.
        """
        size = self.hours.residual[some].mean() * np.sign(made)
        beyond, noise = self.strange.beyond(some)
        beyond, made = beyond * np.sign(made), abs(made)
        within = beyond < MOST * made + SEEN * noise
        if size > max(0.5 * made, SEEN * self.warmth.std_of_mean(length)):
            return made > SEEN * self.warmth.std_of_mean(length) or within
        return max(0.5 * made, noise) < beyond and within

    def excludes(self, some: slice, length: int, made: float) -> bool:
        """Whether the temperature is far from its value with a cover, by both."""
        size = self.hours.residual[some].mean() * np.sign(made)
        beyond, noise = self.strange.beyond(some)
        least = SEEN * self.warmth.std_of_mean(length)
        away = abs(made) - beyond * np.sign(made)
        return abs(made) - size > least and away > SEEN * noise

    def faint(self, some: slice, length: int) -> str:
        """The effect if power deviates little, and so does the temperature."""
        sides = abs(self.apart[some].mean()) > BOTH * self.light.std_of_mean(length)
        size, noise = self.strange.beyond(some)
        sure = SEEN * noise
        warms = self.state[some.start] > 0
        made = self.hot(some) if warms else self.cold(some)
        along = size * np.sign(made)
        most = MOST * abs(made) + sure
        if sides and along > sure and 0.5 * abs(made) < along < most:
            return "sensor_covered" if warms else "modules_covered"
        return ""

    def hot(self, some: slice) -> float:
        """Temperature by irradiance that the sensor does not see. [K]"""
        unseen = np.maximum(self.shown - self.hours.seen, 0.0)
        return self.makes("sensor_covered", unseen, some)

    def cold(self, some: slice) -> float:
        """Temperature by irradiance that the modules lose. [K]"""
        return -self.makes(
            "modules_covered", lost_irradiance(self.hours.seen, self.shown), some
        )

    def makes(self, name: str, light: np.ndarray, some: slice) -> float:
        """What so much light does to the module, over a stretch. [K]"""
        return self.shares[name] * float((light / self.hours.loss)[some].mean())


def bridged(state: np.ndarray, breaks: np.ndarray) -> np.ndarray:
    """The state, with one hour of none between two that are alike as these."""
    state, inside = state.copy(), ~(breaks[1:-1] | breaks[2:])
    alike = inside & (state[:-2] == state[2:]) & (state[1:-1] == 0)
    state[1:-1] = np.where(alike, state[2:], state[1:-1])
    return state


def event_spans(
    kinds: np.ndarray, none: np.ndarray, state: np.ndarray
) -> list[tuple[int, int]]:
    """
    From and to (exclusive) of each event.

    It goes on over one hour of another kind, and over hours without a kind of which at
    most one shows that there is no event. Power that deviates the other way shows that,
    too, as of a power meter whose clock is late.
    """
    against = {}
    for way in (-1, 1):
        other = none | (kinds != "") | (state == -way)
        against[way] = np.concatenate(([0], np.cumsum(other)))
    spans: list[tuple[int, int]] = []
    for start, end in runs(kinds):
        if not kinds[start]:
            continue
        count = against[int(state[start])]
        if (
            spans
            and kinds[spans[-1][0]] == kinds[start]
            and count[start] - count[spans[-1][1]] <= 1
        ):
            spans[-1] = (spans[-1][0], end)
        else:
            spans.append((start, end))
    return spans


def runs(values: np.ndarray, breaks: np.ndarray | None = None) -> Iterator:
    """From and to (exclusive) of each run of one value; a break starts a new run."""
    if not len(values):
        return
    new = np.append(True, values[1:] != values[:-1])
    first = np.flatnonzero(new if breaks is None else new | breaks)
    yield from zip(first.tolist(), [*first[1:].tolist(), len(values)])


def rows_of_events(hours: Hours, ends: list, kinds: np.ndarray, total: float) -> list:
    """Events as rows, the largest energy first."""
    rows = []
    for start, end in ends:
        some = slice(start, end)
        rows.append(
            {
                "effect": kinds[start],
                "start": hours.begin[start],
                "end": hours.end[end - 1],
                "hours": end - start,
                "size": float(hours.residual[some].mean()),
                "share": float(hours.squares[some].sum() / total),
                "power": ratio(hours.power[some].sum(), hours.expected[some].sum()),
                "energy": float(np.abs(hours.energy[some]).sum()),
                "gain": hours.gain(some),
                **{name: float(v[some].mean()) for name, v in hours.extra.items()},
            }
        )
    return sorted(rows, key=lambda row: -row["energy"])


def ratio(power: float, expected: float) -> float:
    """Power over that expected; infinite where none is expected. [-]"""
    return float(power / expected) if expected > 0.0 else np.inf


def event_table(rows: list, extra: Sequence | dict = ()) -> pd.DataFrame:
    """
    Events as a table.

    Parameters
    ----------
    rows : list of dict
        An event each, with all columns of the table.
    extra : collection of str, optional
        Further columns.

    Returns
    -------
    DataFrame
        ``effect``, ``start``, ``end``, ``hours``, ``size`` (mean residual) [K],
        ``share`` of the squared residual [-], ``power`` over that expected [-],
        ``temp_air`` [°C] and ``extra``.
    """
    # a file without events has no further columns
    names = [*COLUMNS, *(name for name in extra if rows and name not in COLUMNS)]
    table = pd.DataFrame(rows, columns=names)
    numbers = {name: float for name in names if name not in COLUMNS[:4]}
    return table.astype({"hours": int, **numbers})


def event_rows(table: pd.DataFrame) -> list:
    """
    Rows of a table of events for a file, with times in UTC and the zone.

    Parameters
    ----------
    table : DataFrame
        From :func:`event_table`.

    Returns
    -------
    list of dict
    """
    rows = table.to_dict(orient="records")
    for row in rows:
        row["zone"] = str(row["start"].tz or "")
        row |= {name: as_utc(row[name]).isoformat() for name in TIMES}
    return rows


def as_utc(time: Any) -> Any:
    return time if time.tz is None else time.tz_convert("UTC")


def events_from(parts: list) -> pd.DataFrame:
    """
    Events of parts of a file.

    Parameters
    ----------
    parts : list of Stored
        From :func:`event_rows`, an event each.

    Returns
    -------
    DataFrame
        See :func:`event_table`.
    """
    extra = dict.fromkeys(name for part in parts for name in part.content)
    extra = [name for name in extra if name not in (*COLUMNS, "zone")]
    return event_table([event_from(part, extra) for part in parts], extra)


def event_from(part: Any, extra: Any) -> Any:
    """One event of a file."""
    zone = part.read("zone", str)
    times = {name: part.read(name, pd.Timestamp) for name in TIMES}
    if zone:
        times = {name: time.tz_convert(zone) for name, time in times.items()}
    needed = [name for name in (*NUMBERS, *extra) if name not in NEW]
    numbers = {name: part.read(name, AnyFloat) for name in needed}
    numbers |= {name: part.read(name, AnyFloat, np.nan) for name in NEW}
    counts = {"effect": part.read("effect", str), "hours": part.read("hours", int)}
    return {**counts, **times, **numbers}
