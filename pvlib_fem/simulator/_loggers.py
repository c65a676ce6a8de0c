"""Sensors and loggers, with their faults."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from pvlib_fem.simulator._constants import (
    DAY,
    SIGMA,
    ZERO,
    even_step,
    first_order_response,
    random_stream,
    times_of,
    wander,
)
from pvlib_fem.simulator._deposits import dirt, ground_albedo, snow_depth
from pvlib_fem.simulator._ground import beam_transmittance, plane
from pvlib_fem.simulator._site import Site
from pvlib_fem.simulator._surroundings import CONTACT, READING, sum_of_laws
from pvlib_fem.simulator._switches import UNITS, Effects, amplitudes
from pvlib_fem.simulator._tracker import orientation

#: column: white noise (sd), slow noise (sd, memory [h]), resolution, relative?
#: from data sheets of class A stations; the module's RTD is 0.4 K (k = 2) in [1]_
SENSORS = {
    "poa_global": (0.0, 0.01, 0.5, 0.1, True),
    "temp_air": (0.05, 0.15, 1.0, 0.01, False),
    "wind_speed": (0.02, 0.0, 1.0, 0.01, True),
    "temp_module": (0.05, 0.30, 1.5, 0.1, False),
    "wind_direction": (5.0, 0.0, 1.0, 1.0, False),
    "relative_humidity": (0.0, 2.0, 24.0, 0.1, False),
    "precipitation": (0.0, 0.0, 1.0, 0.1, False),  # tips are counted before
    "longwave_down": (0.0, 3.0, 2.0, 0.1, False),
    "snow_depth": (0.0, 0.0, 1.0, 1.0, False),
    "p_dc_per_area": (0.01, 0.0, 1.0, 0.01, True),
}


def measure(
    weather: pd.DataFrame,
    truth: pd.DataFrame,
    site: Site,
    effects: Effects,
    seed: int = 0,
    noise: float = 1.0,
) -> pd.DataFrame:
    """
    The record of sensors and loggers for a weather and the module in it.

    Parameters
    ----------
    weather : DataFrame
        Result of `weather`.
    truth : DataFrame
        Result of `simulate` for the same ``effects``.
    site : Site
        The site.
    effects : dict
        Switches; ``swap`` maps a column to one of `UNITS`.
    seed : int
        Seed of the sensors' noise, which does not depend on switches.
    noise : float, default 1
        Scale of all noise; with 0 the sensors also have no finite resolution.

    Returns
    -------
    DataFrame
        ``poa_global`` [W/m²], ``temp_air`` [°C], ``wind_speed`` [m/s],
        ``temp_module`` [°C], ``wind_direction`` [°], ``relative_humidity`` [%],
        ``precipitation`` [mm/h], ``longwave_down`` [W/m²], ``snow_depth`` [cm],
        ``p_dc_per_area`` [W/m²]; of a tracker also ``surface_tilt`` and
        ``surface_azimuth`` [°], at which its control has all rows. The module's logger,
        with its own clock, holds ``temp_module`` and ``p_dc_per_area``.

    Raises
    ------
    ValueError
        If a switch, or a column or unit to swap, is unknown.
    """
    on, step, rows = amplitudes(effects), even_step(times_of(weather)), len(weather)
    speed = weather["wind_speed"].to_numpy()
    sunny = 2.0 * on["air_shield"] * weather["ghi"].to_numpy() / 1000.0
    back, power = module_logger(weather, truth, site, on, step)
    tips = np.floor(np.cumsum(weather["precipitation"]) * step / 3600.0 / 0.1)
    signals = {
        "poa_global": pyranometer(weather, site, on, step),
        "temp_air": weather["temp_air"].to_numpy() + sunny / (1.0 + speed),
        "wind_speed": np.where(speed < on["wind_stall"], 0.0, speed),
        "temp_module": back,
        "precipitation": np.diff(tips, prepend=0.0) * 0.1 * 3600.0 / step,
        "snow_depth": snow_depth(weather),
        "p_dc_per_area": power,
    }
    data = {}
    for column, (white, slow, hours, resolution, relative) in SENSORS.items():
        signal = signals[column] if column in signals else weather[column].to_numpy()
        random = random_stream(seed, column)
        error = white * random.standard_normal(rows) if white else 0.0
        if slow:
            error = error + slow * wander(random, rows, hours * 3600 / step)
        signal = signal + noise * error * (signal if relative else 1.0)
        if noise:
            signal = np.round(signal / resolution) * resolution
        data[column] = signal
    data["wind_direction"] %= 360.0
    data["relative_humidity"] = np.clip(data["relative_humidity"], 0.0, 100.0)
    data = pd.DataFrame(data, index=weather.index)
    if site.tracker is not None:
        data["surface_tilt"], data["surface_azimuth"] = orientation(weather, site)
    swap: Any = effects.get("swap", {})
    return add_file_faults(data, on, swap, step, random_stream(seed, "faults"))


def pyranometer(
    weather: pd.DataFrame, site: Site, on: Mapping[str, float], step: float
) -> np.ndarray:
    """Reading of the irradiance sensor in its plane. [W/m²]"""
    tilt, azimuth = orientation(weather, site, on["tracker_stuck_sensor"])
    azimuth = azimuth + on["poa_misalignment"]
    albedo = ground_albedo(weather, site, on)
    beam, sky, ground, _ = plane(
        weather, tilt, azimuth, albedo, site.forms.transposition
    )
    beam *= beam_transmittance(weather, site, on["shading_sensor"])
    poa = first_order_response(beam + sky + ground, 8 / step)  # a thermopile takes 8 s
    poa *= 1 - on["soiling_sensor"] * dirt(weather, site)
    aged = 0.05 * on["irradiance_sensor_drift"] * years_since_start(times_of(weather))
    poa *= 1 + 0.02 * on["irradiance_gain"] - aged
    black = SIGMA * (weather["temp_air"].to_numpy() + ZERO) ** 4
    net = black - weather["longwave_down"].to_numpy()
    return poa - 0.05 * on["irradiance_offset"] * net


def module_logger(
    weather: pd.DataFrame,
    truth: pd.DataFrame,
    site: Site,
    on: Mapping[str, float],
    step: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Module temperature with a lag of 40 s, and power, by this logger's clock."""
    times = times_of(weather)
    now = np.arange(len(times)) * step
    ahead = 60.0 * on["clock_shift"] + on["clock_drift"] * now / DAY
    ahead = ahead + 3600.0 * on["dst"] * summer_time(times)
    back = first_order_response(truth["temp_back"].to_numpy(), 40 / step)
    over = back - weather["temp_air"].to_numpy()
    back = back - sum_of_laws(CONTACT, weather, site, on) * over
    back = back + sum_of_laws(READING, weather, site, on)
    back = (1 - 0.03 * on["temperature_gain"]) * np.interp(now - ahead, now, back)
    power = np.interp(now - ahead, now, truth["p_dc_per_area"].to_numpy())
    return back + on["temperature_drift"] * years_since_start(times), power


def years_since_start(times: pd.DatetimeIndex) -> np.ndarray:
    """Time since the start. [365.25 days]"""
    return (times - times[0]).total_seconds().to_numpy() / (365.25 * DAY)


def summer_time(times: pd.DatetimeIndex) -> np.ndarray:
    """Mask from the last Sunday of March to the last of October, as in Europe."""
    months, days = times.month.to_numpy(), times.day.to_numpy()
    sunday = days - (times.day_of_week.to_numpy() + 1) % 7  # last Sunday until then
    past = sunday >= 25
    return (
        ((months > 3) & (months < 10))
        | ((months == 3) & past)
        | ((months == 10) & ~past)
    )


def add_file_faults(
    data: pd.DataFrame,
    on: Mapping[str, float],
    swap: Mapping[str, str],
    step: float,
    random: np.random.Generator,
) -> pd.DataFrame:
    """Add faults of the file: shifted, stuck and missing rows, wrong units."""
    rows, hour = len(data), 3600.0 / step
    ahead = on["file_shift"] / 60.0 + on["file_dst"] * summer_time(times_of(data))
    shown = np.arange(rows) - np.round(ahead * hour).astype(int)
    data = data.iloc[np.clip(shown, 0, rows - 1)].set_axis(data.index)
    for _ in range(round(on["stuck"] * max(rows / hour / 720, 1))):
        begin, module = random.integers(rows), data.columns.get_loc("temp_module")
        data.iloc[begin : begin + round(12 * hour), module] = data.iloc[begin, module]
    lost = 0.02 * on["missing"] * rows
    while lost > 0:
        length = int(np.ceil(min(random.uniform(1, 24) * hour, lost)))
        begin = random.integers(rows)
        data.iloc[begin : begin + length] = np.nan
        lost -= length
    for column, unit in swap.items():
        if column not in data or unit not in UNITS:
            raise ValueError(
                f"cannot swap {column!r} to {unit!r}; columns: {', '.join(data)}; "
                f"units: {', '.join(UNITS)}"
            )
        data[column] = UNITS[unit](data[column])
    return data
