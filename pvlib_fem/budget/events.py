"""Find outages and covers by power and the module's temperature."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from pvlib_fem.drivers.plant import LEAST, NONE, agree, lost

FEWEST = 2  # least hours of an event: one hour may have two states
SEEN = 2.0  # least difference of temperature, in standard deviations of means
NORMAL = 1.4826  # standard deviation over median absolute deviation
SHARES = {"modules_covered": 1.0, "sensor_covered": 1.0, "outage": 0.2}
TIMES = ("start", "end")
COLUMNS = ["effect", "start", "end", "hours", "size", "share", "power", "temp_air"]


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
    off: np.ndarray
    extra: dict

    @classmethod
    def of(cls, index, rows, columns, extra):
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

        def means(values):
            return np.add.reduceat(values, first) / size

        found = {name: means(values) for name, values in columns.items()}
        squares = np.add.reduceat(columns["residual"] ** 2, first)
        light = (found["seen"] > LEAST) | (found["shown"] > LEAST)
        found = {name: values[light] for name, values in found.items()}
        return cls(
            index[first][light],
            index[first + size - 1][light],
            number[first][light],
            squares=squares[light],
            off=found.pop("off") > 0.5,
            extra={name: means(values)[light] for name, values in extra.items()},
            **found,
        )

    def apart(self, spread):
        """Irradiance that modules lose, and that the sensor does not see. [W/m²]"""
        same = agree(self.seen, self.shown, spread)
        shown = np.where(same, self.seen, self.shown)
        return lost(self.seen, shown), np.maximum(shown - self.seen, 0.0)


def found_in(hours, spread, total, shares):
    """
    Events of some hours, as a table.

    If power deviates from its expectation for two hours or more of a day, the module's
    temperature decides: it is nearer to its value with a cover, or without one. An hour
    without power and without a cover is an outage, if a cover would be visible.

    Parameters
    ----------
    hours : Hours
    spread : float
        Spread of the relation of power to irradiance. [-]
    total : float
        Sum of squares for the shares. [K²]
    shares : dict
        Coefficients of the effects in the model.
    """
    if not len(hours.number):
        return event_table([], hours.extra)
    shares = SHARES | shares
    less, more = hours.apart(spread)
    noise = Noise(hours.residual[(less == 0.0) & (more == 0.0)])
    kinds = np.full(len(hours.number), "", dtype=object)
    state = np.where(less > 0.0, -1, np.where(more > 0.0, 1, 0))
    day, pause = hours.number // 24, np.diff(hours.number, prepend=-2) > 1
    for start, end in runs(state, pause | (np.diff(day, prepend=-1) > 0)):
        if state[start] == 0 or end - start < FEWEST:
            continue
        some = slice(start, end)
        kinds[some] = kind_of(hours, some, less, more, noise, shares)
    return event_table(rows_of(hours, joined(kinds), kinds, total), hours.extra)


def kind_of(hours, some, less, more, noise, shares):
    """The effect of a stretch of hours; "" for none."""
    size, sure = hours.residual[some].mean(), SEEN * noise.of(some.stop - some.start)

    def makes(name, light):
        return shares[name] * float((light / hours.loss)[some].mean())

    if more[some].any():
        hot = makes("sensor_covered", more)
        return "sensor_covered" if hot > sure and size > 0.5 * hot else ""
    expected, dead = (
        hours.expected[some],
        hours.power[some] < NONE * hours.expected[some],
    )
    # the first and the last hour may have power for half of the time
    none = expected[dead].sum() > 0.5 * expected.sum()
    cold = -makes("modules_covered", less)
    warm = makes("outage", hours.seen) if none else 0.0
    if warm - cold > sure:
        if size < 0.5 * (cold + warm):
            return "modules_covered"
        return "outage" if none else ""
    return "outage" if none and hours.off[some].all() else ""


@dataclass(frozen=True, eq=False)
class Noise:
    """Noise of means over usual hours."""

    residual: np.ndarray

    def of(self, hours):
        """Standard deviation of a mean over so many hours, by the median. [K]"""
        if len(self.residual) < hours:
            return np.inf
        total = np.concatenate(([0.0], np.cumsum(self.residual)))
        means = (total[hours:] - total[:-hours]) / hours
        return NORMAL * float(np.median(np.abs(means - np.median(means))))


def joined(kinds):
    """From and to (exclusive) of each event; one hour of another kind is bridged."""
    found = []
    for start, end in runs(kinds):
        if not kinds[start]:
            continue
        if found and kinds[found[-1][0]] == kinds[start] and start - found[-1][1] <= 1:
            found[-1] = (found[-1][0], end)
        else:
            found.append((start, end))
    return found


def runs(values, breaks=None):
    """From and to (exclusive) of each run of one value; a break starts a new run."""
    if not len(values):
        return
    new = np.append(True, values[1:] != values[:-1])
    first = np.flatnonzero(new if breaks is None else new | breaks)
    yield from zip(first.tolist(), [*first[1:].tolist(), len(values)])


def rows_of(hours, ends, kinds, total):
    """Events as rows, the largest share first."""
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
                "power": float(hours.power[some].sum() / hours.expected[some].sum()),
                **{name: float(v[some].mean()) for name, v in hours.extra.items()},
            }
        )
    return sorted(rows, key=lambda row: -row["share"])


def event_table(rows, extra=()):
    """Events as a table."""
    names = [*COLUMNS, *(name for name in extra if name not in COLUMNS)]
    table = pd.DataFrame(rows, columns=names)
    numbers = {name: float for name in names if name not in COLUMNS[:4]}
    return table.astype({"hours": int, **numbers})


def event_rows(table):
    """Rows of a table of events for a file, with times in UTC and the zone."""
    rows = table.to_dict(orient="records")
    for row in rows:
        row["zone"] = str(row["start"].tz or "")
        row |= {name: as_utc(row[name]).isoformat() for name in TIMES}
    return rows


def as_utc(time):
    return time if time.tz is None else time.tz_convert("UTC")


def events_from(parts):
    """Events of parts of a file."""
    extra = dict.fromkeys(name for part in parts for name in part.content)
    extra = [name for name in extra if name not in (*COLUMNS, "zone")]
    return event_table([event_from(part, extra) for part in parts], extra)


def event_from(part, extra):
    """One event of a file."""
    zone = part.text("zone")
    times = {name: pd.Timestamp(part.text(name)) for name in TIMES}
    if zone:
        times = {name: time.tz_convert(zone) for name, time in times.items()}
    numbers = {n: part.number(n, unknown=True) for n in (*COLUMNS[4:], *extra)}
    counts = {"effect": part.text("effect"), "hours": part.count("hours")}
    return {**counts, **times, **numbers}
