"""Pictures that show each finding by measured columns, without the thermal model."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pvlib_fem._findings import Finding
from pvlib_fem._record.column_names import PLANT_POWER
from pvlib_fem._record.file_summary import present
from pvlib_fem._report.rows import DATES, Picture, Rows
from pvlib_fem.drivers._sky_deficit import STEFAN_BOLTZMANN, ZERO_CELSIUS
from pvlib_fem.effects import EFFECTS
from pvlib_fem.effects._effect import Effect
from pvlib_fem.effects._time_profiles import day_number
from pvlib_fem.plotting._evidence import (
    Daily,
    plot_against,
    plot_by_sun,
    plot_distribution,
    plot_event,
)
from pvlib_fem.plotting._style import label_with_unit
from pvlib_fem.power import GAMMA, expected_power
from pvlib_fem.quality._clearsky import clear_sky

if TYPE_CHECKING:
    from pvlib_fem._loop.results.loop_result import Loop

BRIGHT = 200.0  # W/m², above which light is compared
YEAR = 366  # days from which months are compared with themselves
AROUND = pd.Timedelta(days=2)  # before and after an event
DARK = 0.0  # W/m², up to which it is night
TEMPERATURE_RISE = "rise per irradiance [K m²/kW]"
#: a picture of a finding from the rows of its loop; None where they do not show it
Show = Callable[[Rows, Effect], Picture | None]


def relative_to_median(daily: Daily | None) -> Daily | None:
    """Daily values over their median, without the season of several years."""
    if daily is None:
        return None
    daily = daily.without_season()
    return Daily(daily.days, daily.values / np.median(daily.values))


def power_at_25(rows: Rows) -> tuple[np.ndarray, str] | None:
    """Power of the plant at 25 °C, and its name; None without power."""
    for name in PLANT_POWER:
        if (power := rows.column(name)) is not None:
            warm = rows.record["temp_module"] - 25.0
            return power / (1.0 + GAMMA * warm), name
    return None


def irradiance(rows: Rows, effect: Effect) -> Picture | None:
    """Irradiance over what else shows it: a clear sky, power, second sensors."""
    poa, series = rows.record["poa_global"], {}
    bright = poa > BRIGHT
    if rows.location is not None and not rows.moves:
        sky = clear_sky(poa, rows.index, rows.location, rows.plane, rows.late)
        series["clear sky"] = rows.daily(bright, poa, sky)
    if (power := power_at_25(rows)) is not None:
        series[power[1]] = rows.daily(bright & (power[0] > 0.0), poa, power[0])
    for name, twin in rows.twins("poa_global").items():
        series[name] = rows.daily(bright, poa, twin)
    series = {
        name: relative_to_median(one) for name, one in series.items() if one is not None
    }
    names = [f"{n} at 25 °C" if power and n == power[1] else n for n in series]
    caption = f"Irradiance sensor over {' and over '.join(names)}, relative to a median"
    caption += " of 1. If the sensor has changed, all change alike" * (len(names) > 1)
    return rows.by_date(series, "irradiance over reference [-]", caption, seasonal=True)


def anemometer(rows: Rows, effect: Effect) -> Picture | None:
    """Distribution of the wind before and after, or outside and within a period."""
    if (wind := rows.column("wind_speed")) is None:
        return None
    days, dates, note = rows.days, rows.settings, ""
    ends = [day_number(dates[name]) for name in ("at", "start", "end") if name in dates]
    if len(ends) == 2:
        inside = (days >= ends[0]) & (days < ends[1])
        parts = {"outside the period": ~inside, "within it": inside}
    elif ends:
        parts = {"before": days < ends[0], "after": days >= ends[0]}
    else:
        third = (days[-1] - days[0]) / 3.0
        parts = {"first third": days < days[0] + third}
        parts["last third"] = days > days[-1] - third
    months = np.asarray(rows.index.month)
    one, other = (months[part] for part in parts.values())
    shared = np.intersect1d(one, other)
    long = days[-1] - days[0] > YEAR
    if long and len(shared) and not np.isin(months, shared).all():
        parts = {name: part & np.isin(months, shared) for name, part in parts.items()}
        note = ", in the months that both have"
    parts = {name: wind[part & np.isfinite(wind)] for name, part in parts.items()}
    if not all(len(part) for part in parts.values()):
        return None
    draw = partial(plot_distribution, parts, label_with_unit("wind_speed"))
    words = " and ".join(parts)
    return Picture(draw, f"Distribution of the wind speed {words}{note}.")


def wind_by_date(rows: Rows, effect: Effect) -> Picture | None:
    """Wind over a second anemometer, or its daily mean."""
    if (wind := rows.column("wind_speed")) is None:
        return None
    every = np.ones(len(wind), dtype=bool)
    if twins := rows.twins("wind_speed"):
        series = {
            n: relative_to_median(rows.daily(every, wind, v)) for n, v in twins.items()
        }
        caption = "Anemometer over the second one, relative to the median"
        return rows.by_date(series, "wind over wind [-]", caption)
    series = {"wind": rows.daily(every, wind)}
    return rows.by_date(series, "wind_speed [m/s]", "Daily mean wind speed")


def temperature_rise(rows: Rows, effect: Effect) -> Picture | None:
    """Temperature of the module over air, per irradiance, by date."""
    record = rows.record
    poa, over = record["poa_global"], record["temp_module"] - record["temp_air"]
    series = {"rise": rows.daily(poa > BRIGHT, over, poa / 1000.0)}
    series = {n: one and one.without_season() for n, one in series.items()}
    caption = "Daily temperature rise of the module over air, per irradiance"
    return rows.by_date(series, TEMPERATURE_RISE, caption, seasonal=True)


def response_to_light(rows: Rows, effect: Effect) -> Picture | None:
    """Change of the module's temperature from row to row, per change of irradiance."""
    record = rows.record
    poa, over = record["poa_global"], record["temp_module"] - record["temp_air"]
    change, light = (np.abs(np.diff(one, prepend=np.nan)) for one in (over, poa))
    series = {"response": rows.daily(poa > BRIGHT, change, light / 1000.0)}
    caption = (
        "Change of the module's temperature rise from one row to the next, per change "
        "of irradiance: the longer the time constant, the smaller it is"
    )
    return rows.by_date(series, "response [K m²/kW]", caption, seasonal=True)


def at_night(rows: Rows, effect: Effect) -> Picture | None:
    """Temperature of the module over air at night, by date."""
    record = rows.record
    over = record["temp_module"] - record["temp_air"]
    series = {"night": rows.daily(record["poa_global"] <= DARK, over)}
    words = "module minus air [K]"
    return rows.by_date(
        series, words, "Module minus air temperature, mean of the night"
    )


def sensor_difference(usual: str, by_day: bool) -> Show:
    """The difference of two sensors by date, by day for 1000 W/m², or at night."""

    def picture(rows: Rows, effect: Effect) -> Picture | None:
        own, poa = rows.column(usual), rows.record["poa_global"]
        some, other = (poa > BRIGHT, poa / 1000.0) if by_day else (poa <= DARK, None)
        series = {
            name: rows.daily(some, own - twin, other)
            for name, twin in rows.twins(usual).items()
        }
        where = "by day, for each 1000 W/m²" if by_day else "at night"
        caption = f"{usual} minus {' or '.join(series)}, {where}"
        return rows.by_date(series, "difference [K]", caption)

    return picture


def night_by_sky(rows: Rows, effect: Effect) -> Picture | None:
    """Temperature of the module over air at night, by the sky."""
    record = rows.record
    dark = record["poa_global"] <= DARK
    over = (record["temp_module"] - record["temp_air"])[dark]
    if (down := rows.column("longwave_down")) is not None:
        air = STEFAN_BOLTZMANN * (record["temp_air"] + ZERO_CELSIUS) ** 4
        other, words = (air - down)[dark], "air minus sky, longwave [W/m²]"
    elif (humid := rows.column("relative_humidity")) is not None:
        other, words = humid[dark], label_with_unit("relative_humidity")
    else:
        return None
    if np.isfinite(over + other).sum() < 2:
        return None
    draw = partial(plot_against, over, other, ("module minus air [K]", words))
    caption = "Module minus air temperature at night: median and quartiles"
    return Picture(draw, f"{caption}.")


def rise_by(name: str) -> Show:
    """Temperature rise per irradiance, by a column."""

    def picture(rows: Rows, effect: Effect) -> Picture | None:
        record = rows.record
        if (other := rows.column(name)) is None:
            return None
        bright = record["poa_global"] > 2.0 * BRIGHT
        over = (record["temp_module"] - record["temp_air"])[bright]
        rise = over / (record["poa_global"][bright] / 1000.0)
        words = (TEMPERATURE_RISE, label_with_unit(name))
        draw = partial(plot_against, rise, other[bright], words)
        return Picture(
            draw, "Temperature rise of the module over air: median and quartiles."
        )

    return picture


def night_by_air(rows: Rows, effect: Effect) -> Picture:
    """Temperature of the module over air at night, by air temperature."""
    record = rows.record
    dark = record["poa_global"] <= DARK
    over = (record["temp_module"] - record["temp_air"])[dark]
    words = ("module minus air [K]", label_with_unit("temp_air"))
    draw = partial(plot_against, over, record["temp_air"][dark], words)
    return Picture(draw, "Module minus air temperature at night: median and quartiles.")


def by_column(rows: Rows, effect: Effect) -> Picture | None:
    """Error without the finding, by the column that it follows."""
    name = effect.column or effect.source or next(iter(effect.drivers), "")
    if (values := rows.column(name)) is None:
        return None
    error = present(rows.loop.residual_before).to_numpy()
    words = ("measured − modelled [K]", label_with_unit(name))
    draw = partial(plot_against, error, values, words)
    return Picture(
        draw, f"Error of the model without findings, by {name}: median and quartiles."
    )


def by_sun(rows: Rows, effect: Effect) -> Picture | None:
    """Error without the finding, by the position of the sun."""
    if rows.sun is None:
        return None
    residual = present(rows.loop.residual_before)
    azimuth, elevation = rows.sun
    known = residual.notna().to_numpy() & (elevation > 0.0)
    if not known.any():
        return None
    windows = tuple(rows.settings.get("windows", ()))
    args = (residual[known], azimuth[known], elevation[known], windows)
    more = "; outlined: where the finding is" * bool(windows)
    return Picture(
        partial(plot_by_sun, *args),
        "Error of the model without findings, by the position of the sun (zenith in "
        f"the middle; –: below zero){more}.",
        "polar",
    )


def power_deficit(rows: Rows, effect: Effect) -> Picture | None:
    """Power around the largest event of an effect, or by date."""
    return power_shortfall(rows, effect.name)


def power_shortfall(rows: Rows, kind: str) -> Picture | None:
    """
    Power and expected power around the largest event, or their ratio by date.

    Parameters
    ----------
    rows : Rows
        Measured rows of the loop, and dates of the finding.
    kind : str
        Effect of the events that are looked up.

    Returns
    -------
    Picture or None
        None without a column of the plant's power, or with too few rows of power.
    """
    names = [name for name in PLANT_POWER if rows.column(name) is not None]
    if not names:
        return None
    name, record, index = names[0], rows.record, rows.index
    columns = [pd.Series(record[n], index) for n in ("poa_global", "temp_module", name)]
    try:
        due = expected_power(*columns).to_numpy()
    except ValueError:  # too few rows with power
        return None
    events = rows.loop.events
    events = events[events["effect"] == kind] if len(events) else events
    if len(events):
        return power_around(rows, events.iloc[0], {name: record[name], "expected": due})
    some = (record["poa_global"] > BRIGHT) & (due > 0.0)
    series = {name: rows.daily(some, record[name], due)}
    caption = f"{name} over that expected from irradiance and module temperature"
    return rows.by_date(series, "power over expected [-]", caption)


def power_around(
    rows: Rows, event: pd.Series, columns: Mapping[str, np.ndarray]
) -> Picture:
    """Power around an event."""
    index, ends = rows.index, (event["start"], event["end"])
    near = (index >= ends[0] - AROUND) & (index <= ends[1] + AROUND)
    times = index[near].tz_localize(None)
    ends = tuple(end.tz_localize(None) for end in ends)
    parts = {name: values[near] for name, values in columns.items()}
    draw = partial(plot_event, times, parts, ends, "power, as in the record")
    caption = (
        "Measured power, and power expected from irradiance and module temperature"
    )
    return Picture(draw, f"{caption}; shaded: the largest event.")


SUN = (by_sun,)
POWER = (power_deficit,)
#: pictures of a finding, by the sensor fault or the name of its effect
SHOWN = {
    "irradiance_sensor": (irradiance,),
    "module_irradiance": (irradiance, temperature_rise),
    "soiling": (irradiance,),
    "sensor_covered": (power_deficit, irradiance),
    "anemometer": (anemometer, wind_by_date),
    "anemometer_stall": (anemometer, wind_by_date),
    "air_offset": (sensor_difference("temp_air", False), at_night),
    "air_sensor_shield": (sensor_difference("temp_air", True), temperature_rise),
    "air_shield": (sensor_difference("temp_air", True), rise_by("wind_speed")),
    "module_sensor_contact": (sensor_difference("temp_module", True), temperature_rise),
    "mounting": (temperature_rise,),
    "module_offset": (sensor_difference("temp_module", False), at_night),
    "time_constant": (response_to_light,),
    "temperature_gain": (night_by_air,),
    "season": (temperature_rise,),
    "shading": SUN,
    "poa_misalignment": SUN,
    "incidence_angle": SUN,
    "rear_irradiance": SUN,
    "outage": POWER,
    "tracker_stuck": (temperature_rise, power_deficit),
    "modules_covered": POWER,
    "snow": POWER,
    "radiative_loss": (night_by_sky,),
    "sky_radiation": (night_by_sky,),
    "wind_shape": (rise_by("wind_speed"),),
    "natural_convection": (rise_by("wind_speed"),),
    "wind_direction": (rise_by("wind_direction"),),
}


def pictures_of(finding: Finding, loop: "Loop") -> list[Picture]:
    """
    Pictures that show a finding, each once.

    Parameters
    ----------
    finding : Finding
    loop : Loop
        With its rows.

    Returns
    -------
    list of Picture
        First of its most probable cause, then of the others.
    """
    own = {effect.name: effect for effect in loop.fit.effects}
    main = own.get(finding.effect)
    settings = dict(main.settings) if main is not None else {}
    dates = {n: settings[n] for n in (*DATES, "resets", "between") if n in settings}
    drawn = {}
    for name in finding.candidates:
        if (effect := own.get(name) or EFFECTS.get(name)) is None:
            continue
        rows = Rows(loop, settings if name == finding.effect else dates)
        for picture in SHOWN.get(effect.sensor_fault or effect.name, (by_column,)):
            if (one := picture(rows, effect)) is not None:
                drawn.setdefault(one.words, one)
    return [*drawn.values()]
