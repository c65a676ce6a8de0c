"""Events that power shows, in words."""

from collections.abc import Hashable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pandas as pd

from pvlib_fem._report.formatting import two_digits

if TYPE_CHECKING:
    from pvlib_fem._loop.results.loop_result import Loop


class EventKind(NamedTuple):
    """A kind of events in words: device, what happened, its energy, what to do."""

    device: str
    happened: str
    energy: str
    action: str


IN_LOG = "Look up these hours, in loop.events, in"
WORDS = {
    "modules_covered": EventKind(
        "modules", "the modules were covered", "lost", f"{IN_LOG} the site's log"
    ),
    "sensor_covered": EventKind(
        "irradiance sensor or modules",
        "the irradiance sensor was covered, or light was reflected onto the modules",
        "more than expected",
        f"{IN_LOG} the site's log",
    ),
    "outage": EventKind(
        "plant", "the plant gave no power", "lost", f"{IN_LOG} the inverter's log"
    ),
    "underperformance": EventKind(
        "plant",
        "the plant gave less power than expected, and the module with the temperature "
        "sensor was not covered",
        "lost",
        f"{IN_LOG} the inverter's log: power may have been curtailed, strings "
        "disconnected, other modules shaded or under snow, or the power meter or its "
        "clock wrong",
    ),
}
EVENT = "event"  # verdict of their statements
MOST = 3  # events of a kind that are reported one by one
FEWEST = 10  # events within a day that have usual hours
MOSTLY = 0.8  # of these


def by_kind(loop: "Loop") -> dict[str, pd.DataFrame]:
    """
    Events of each kind, the largest first; kinds by their energy.

    Parameters
    ----------
    loop : Loop
        Loop with its events.

    Returns
    -------
    dict of DataFrame
        Rows of ``loop.events`` by the name of their effect; empty without events. They
        have the wind where it says whether trackers were stowed.
    """
    if not len(loop.events):
        return {}
    kinds = loop.events.groupby("effect", sort=False)
    energy = kinds["energy"].sum().sort_values(ascending=False, kind="stable")
    groups = {name: kinds.get_group(name) for name in energy.index}
    return {
        name: rows
        if may_be_stowed(name, loop)
        else rows.drop(columns="wind_speed", errors="ignore")
        for name, rows in groups.items()
    }


def texts_by_cause(statements: pd.DataFrame) -> dict[str, str]:
    """
    Text of each cause: that of the finding, where events have the same name.

    Parameters
    ----------
    statements : DataFrame
        ``loop.statements``.

    Returns
    -------
    dict of str
        By the name of the cause.
    """
    events = statements["verdict"] == EVENT
    ordered = pd.concat([statements[events], statements[~events]])
    return dict(zip(ordered["cause"], ordered["text"]))


def all_of(events: pd.DataFrame) -> str:
    """
    Number of events of a kind, hours of light, share of the error, and energy.

    Parameters
    ----------
    events : DataFrame
        Rows of ``loop.events``.

    Returns
    -------
    str
    """
    count, hours = len(events), int(events["hours"].sum())
    words = (
        f"{count} event{'s' * (count > 1)}, {hours:,} h of light, "
        f"{100 * events['share'].sum():.1f} % of the squared error of all hours"
    )
    energy = events["energy"].sum(skipna=False)  # files of before do not have it
    if np.isfinite(energy):
        what = WORDS[events["effect"].iloc[0]].energy
        words += f", {two_digits(energy)} kWh/kWp {what}"
    return words + circumstances(events)


def circumstances(events: pd.DataFrame) -> str:
    """
    When and in which weather most events of a kind are: of shade, snow or stowing.

    Parameters
    ----------
    events : DataFrame
        Rows of ``loop.events``.

    Returns
    -------
    str
        Empty for fewer than ten events within a day.
    """
    within = events[events["start"].dt.date == events["end"].dt.date]
    if len(within) < FEWEST:
        return ""
    low, high = 0.5 * (1.0 - MOSTLY), 0.5 * (1.0 + MOSTLY)
    times = [
        (within[name] - within[name].dt.normalize()).quantile(share)
        for name, share in (("start", low), ("end", high))
    ]
    first, last = (f"{pd.Timestamp(0) + time:%H:%M}" for time in times)
    words = f"; {len(within)} within a day, mostly from {first} to {last}"
    coldest, warmest = within["temp_air"].quantile([low, high])
    if np.isfinite(warmest):
        words += f", in air of {round(coldest)} to {round(warmest)} °C"
    if "wind_speed" in within:
        calm, windy = within["wind_speed"].quantile([low, high])
        words += f" and wind of {round(calm)} to {round(windy)} m/s"
    return words


def happened(name: str, loop: "Loop") -> str:
    """
    What happened in the events of a kind.

    Parameters
    ----------
    name : str
        Of the effect.
    loop : Loop
        Loop with the plane of its modules.

    Returns
    -------
    str
    """
    stowed = ", or their trackers stowed" * may_be_stowed(name, loop)
    return f"{WORDS[name].happened}{stowed}"


def may_be_stowed(name: str, loop: "Loop") -> bool:
    """
    Whether a cover of modules may be their trackers that turn away from the sun.

    Parameters
    ----------
    name : str
        Of the effect.
    loop : Loop

    Returns
    -------
    bool
    """
    return name == "modules_covered" and loop.place.get("mount") is not None


def event_words(row: pd.Series | Mapping[Hashable, Any]) -> str:
    """
    One event: when, how much, and what else the record says.

    Parameters
    ----------
    row : Series or dict
        Row of ``loop.events``: ``start``, ``end``, ``size`` [K], positive where the
        module is warmer than modelled, ``power`` over that expected [-], and where they
        are known ``temp_air`` [°C], ``wind_speed`` [m/s] and ``snow_depth`` [cm].

    Returns
    -------
    str
    """
    way = "warmer" if row["size"] > 0 else "colder"
    parts = [f"{abs(row['size']):.1f} K {way} than modelled"]
    if np.isfinite(row["power"]):
        parts.append(f"{100 * max(row['power'], 0.0):.0f} % of the expected power")
    if np.isfinite(row.get("temp_air", np.nan)):
        parts.append(f"air at {round(row['temp_air'])} °C")
    if np.isfinite(row.get("wind_speed", np.nan)):
        parts.append(f"wind of {row['wind_speed']:.1f} m/s")
    if np.isfinite(row.get("snow_depth", np.nan)):
        parts.append(f"{row['snow_depth']:.0f} cm of snow")
    return f"{event_span(row)}: {', '.join(parts)}"


def event_span(row: pd.Series | Mapping[Hashable, Any]) -> str:
    """
    From and to of an event.

    Parameters
    ----------
    row : Series or dict
        Row of ``loop.events``, with ``start`` and ``end``.

    Returns
    -------
    str
        Times to the minute, the second without its date if it is the same.
    """
    start, end = row["start"], row["end"]
    until = f"{end:%H:%M}" if start.date() == end.date() else f"{end:%Y-%m-%d %H:%M}"
    return f"{start:%Y-%m-%d %H:%M} to {until}"


def largest_events(events: pd.DataFrame) -> str:
    """
    The largest events in words, and how many more there are.

    Parameters
    ----------
    events : DataFrame
        Rows of ``loop.events``, the largest first.

    Returns
    -------
    str
    """
    rows = events.to_dict("records")
    parts = [event_words(row) for row in rows[:MOST]]
    more = len(rows) - len(parts)
    return "; ".join([*parts, *([f"{more} more in loop.events"] if more else [])])
