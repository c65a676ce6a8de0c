"""Which outages, covers and low power would be found on my plant?"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from pvlib.location import Location
from pvlib.pvsystem import AbstractMount

from pvlib_fem._loop.close import close_loop, finished_search
from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._loop.preparation.planes import with_given
from pvlib_fem._loop.references.power_events import EVENTS
from pvlib_fem._loop.results.loop_result import Loop
from pvlib_fem._loop.search import Search
from pvlib_fem._record.column_names import PLANT_POWER, plant_power
from pvlib_fem._recovery.inject import add_to_rows
from pvlib_fem._spelling import no_columns
from pvlib_fem.drivers import checked_place
from pvlib_fem.drivers._plant_irradiance import LEAST
from pvlib_fem.quality._screen import labels_of

HEATS = (0.1, 0.3)  # of irradiance, that an outage turns into heat
LOSES = (0.05, 0.98)  # of irradiance, that a cover takes
APART = 3  # days between two events, so that each is one
SAME = 0.5  # of its hours, that an event that is found has
COLUMNS = ["effect", "start", "end", "hours", "size", "light", "power", "found"]


def recover_events(
    data: pd.DataFrame,
    effects: str | Iterable[str] = EVENTS,
    size: float = 3.0,
    hours: int = 6,
    draws: int = 20,
    seed: int = 0,
    model: str = "faiman",
    location: Location | None = None,
    surface_tilt: float | pd.Series | None = None,
    surface_azimuth: float | pd.Series | None = None,
    criteria: Criteria | None = None,
    mount: AbstractMount | None = None,
) -> pd.DataFrame:
    """
    Put outages, covers and low power into a measured record, and look for them.

    The loop is closed on the record once, and its last model says what light and heat
    do to the module. Power and module temperature, or the irradiance, are then changed
    together on drawn days, and the loop runs on that and does not know.

    Parameters
    ----------
    data : DataFrame
        Record with the columns of :func:`close_loop`, ``power_dc``,
        ``p_dc_per_area`` or ``power_ac`` among them.
    effects : str or sequence of str, default all four
        ``"modules_covered"``, ``"sensor_covered"``, ``"outage"``,
        ``"underperformance"``.
    size : float, default 3
        Mean change of the temperature over the hours of an event; of the modelled one
        where the sensor is covered; and of underperformance that by a cover with the
        same power. [K]
    hours : int, default 6
        Length of each, in hours of light.
    draws : int, default 20
        Days of each effect, as far as there are so many on which the size is possible.
    seed : int, default 0
        Seed of the drawn days.
    model, location, surface_tilt, surface_azimuth, criteria, mount : optional
        As in :func:`close_loop`.

    Returns
    -------
    DataFrame
        A row for each event that was put in: ``effect``, ``start``, ``end``, ``hours``,
        ``size`` [K], ``light`` over that of the day, ``power`` over that measured, and
        whether it was ``found``: an event of that effect in at least half of its hours.
        ``attrs["others"]`` has by effect how many further events there were, of which
        ``attrs["own"]`` are the record's own.

    Raises
    ------
    ValueError
        If there is no power, no such effect, or no day with room for an event, or a
        number is out of range.

    Notes
    -----
    An outage leaves nothing of the power and turns 10 to 30 % of the irradiance into
    heat, a cover takes 5 to 98 % of it; a day on which the size needs more or less is
    not drawn. Half of the covers take as much power as light, half the square, as where
    each string is covered in part. Underperformance takes the square, and leaves the
    temperature as it is.

    Examples
    --------
    >>> import pvlib_fem as fem
    >>> data = fem.simulator.record(effects=fem.simulator.PHYSICS, days=120, step=3600)
    >>> data["power_ac"] = 33.0 * data.pop("p_dc_per_area")
    >>> events = fem.recover_events(data, "outage", draws=5)
    >>> int(events["found"].sum())
    5
    """
    names = [effects] if isinstance(effects, str) else [*effects]
    if unknown := [name for name in names if name not in EVENTS]:
        raise ValueError(
            f"{', '.join(unknown)} is no event; there are {', '.join(EVENTS)}"
        )
    if not names:
        raise ValueError(f"effects is empty; give some of {', '.join(EVENTS)}")
    for name, value in (("size", size), ("hours", hours), ("draws", draws)):
        if not value > 0:
            raise ValueError(f"{name} = {value:g}; give a number above 0")
    criteria = criteria or Criteria()
    place = checked_place(location, surface_tilt, surface_azimuth, mount)
    data, place = with_given(data, place)
    how: dict[str, Any] = dict(holdout=None, effects=None, check_units=True, fixed=None)
    search, loop = finished_search(data, model, place, None, criteria=criteria, **how)
    plant = Plant.from_loop(search, loop)
    tables, others = [], {}
    for name in names:
        random = np.random.default_rng([seed, EVENTS.index(name)])
        events = plant.drawn(name, size, hours, draws, random)
        changed = data.copy()
        for event in events:
            plant.put(changed, event)
        again = close_loop(changed, model, **place, criteria=criteria).events
        again = again[again["effect"] == name]
        tables.append(pd.DataFrame([event.row(again) for event in events]))
        others[name] = len(again) - int(tables[-1]["found"].sum())
    table = pd.concat(tables, ignore_index=True)[COLUMNS]
    own = loop.events["effect"].value_counts()
    table.attrs = {
        "others": others,
        "own": {name: int(own.get(name, 0)) for name in names},
    }
    return table


@dataclass(frozen=True, eq=False)
class Event:
    """An event on some rows of a record."""

    effect: str
    rows: np.ndarray
    times: pd.DatetimeIndex
    hours: int
    size: float
    light: float  # that remains, or of an outage, that heats as if it were
    power: float  # that remains
    change: np.ndarray  # of the module's temperature [K]

    def row(self, events: pd.DataFrame) -> dict[str, Any]:
        """What was put in, and whether it is among some events."""
        first, last = self.times[0], self.times[-1]
        shared = [
            (min(end, last) - max(start, first)) >= SAME * (last - first)
            for start, end in zip(events["start"], events["end"])
        ]
        put = (self.effect, first, last, self.hours, self.size, self.light, self.power)
        return dict(zip(COLUMNS, (*put, any(shared))))


@dataclass(frozen=True, eq=False)
class Plant:
    """A record as its loop left it, and what light does to its modules."""

    record: Any
    kept: np.ndarray  # rows of the user's frame that it has
    counts: np.ndarray  # rows that count
    light: np.ndarray  # hours of light are here
    powers: tuple
    dark: np.ndarray  # response to the loss of all light [K]
    taken: frozenset  # days with events of the record's own

    @classmethod
    def from_loop(cls, search: Search, loop: Loop) -> "Plant":
        case = search.case
        record: Any = loop.fit.record
        powers = [*plant_power(record, case.criteria.max_missing_share)]
        if not powers:
            raise ValueError(
                f"{no_columns([' or '.join(PLANT_POWER)])}, by which events are found; "
                "add the power of a module, a string or the plant"
            )
        model, coefficients = loop.fit.thermal_model, loop.fit.coefficients
        model = replace(model, base=model.base or coefficients, effects=())
        plain = {n: v for n, v in coefficients.items() if n in model.parameters}
        dim = record.inputs.having({"poa_global": 0.0 * record["poa_global"]})
        dark = model.temperature(dim, plain) - model.temperature(record.inputs, plain)
        known = np.all([np.isfinite(record[name]) for name in powers], axis=0)
        light = record["poa_global"] > 2.0 * LEAST
        taken = set()
        for start, end in zip(loop.events["start"], loop.events["end"]):
            first, last = (record.index.searchsorted(t) for t in (start, end))
            taken |= {*record.dates[first : last + 1].tolist()}
        rows = case.seen & np.isfinite(dark) & known
        return cls(
            record, case.kept, rows, light, tuple(powers), dark, frozenset(taken)
        )

    def drawn(
        self,
        name: str,
        size: float,
        hours: Any,
        draws: Any,
        random: np.random.Generator,
    ) -> list[Event]:
        """Events of an effect on days that have room for it."""
        events, used = [], set(self.taken)
        per_hour = max(round(3600.0 / self.record.inputs.step), 1)
        days = np.unique(self.record.dates[self.light & self.counts])
        for day in random.permutation(days):
            if len(events) == draws:
                break
            if any(day + i in used for i in range(-APART, APART + 1)):
                continue
            rows = np.flatnonzero((self.record.dates == day) & self.light & self.counts)
            length = hours * per_hour
            if len(rows) < length or np.ptp(rows) + 1 > len(rows):
                continue
            start = int(random.integers(0, len(rows) - length + 1))
            event = self.event(name, rows[start : start + length], size, len(events))
            if event is not None:
                events.append(event)
                used.add(int(day))
        if not events:
            raise ValueError(
                f"no day has room for {name} of {size:g} K and {hours} h of light; "
                "give a smaller size, or a longer record"
            )
        return sorted(events, key=lambda event: event.rows[0])

    def event(
        self, name: str, rows: np.ndarray, size: float, number: int
    ) -> Event | None:
        """An event of that size on some rows, or None where it is not possible."""
        share = size / abs(float(self.dark[rows].mean()))
        low, high = HEATS if name == "outage" else LOSES
        if not low <= share <= high:
            return None
        light = 1.0 - share
        even = name != "underperformance" and number % 2 == 0
        power = 0.0 if name == "outage" else light ** (1 if even else 2)
        change = share * self.dark[rows]
        times, step = self.record.index[rows], self.record.inputs.step
        hours = round(len(rows) * step / 3600.0)
        if name == "sensor_covered":
            power, change = 1.0, 0.0 * change
        elif name == "outage":
            light, change = 1.0, -change
        elif name == "underperformance":
            light, change = 1.0, 0.0 * change
        return Event(name, rows, times, hours, size, light, power, change)

    def put(self, data: pd.DataFrame, event: Event) -> None:
        """Change a frame by an event, in place."""
        labels = labels_of(data)
        rows = np.zeros(len(self.record.index), dtype=bool)
        rows[event.rows] = True
        changes = {"temp_module": np.zeros(len(rows))}
        changes["temp_module"][event.rows] = event.change
        if event.effect == "sensor_covered":
            poa = np.nan_to_num(self.record["poa_global"])
            changes["poa_global"] = np.where(rows, (event.light - 1.0) * poa, 0.0)
        for name in self.powers if event.effect != "sensor_covered" else ():
            power = np.nan_to_num(self.record[name])
            changes[name] = np.where(rows, (event.power - 1.0) * power, 0.0)
        for name, values in changes.items():
            add_to_rows(data, labels[name], self.kept, values)
