"""A synthetic record with known coefficients under broken clouds."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
import pvlib
from scipy.special import ndtr

from pvlib_fem._record.checks import is_number
from pvlib_fem._relaxation import respond
from pvlib_fem._thermal.temperature import TAU, fem_temperature, heat_balance

ANSWERS: dict[str, Callable[..., Any]] = {
    "ewm": fem_temperature,
    "balance": heat_balance,
}


def synthetic(
    days: float = 30,
    step: float = 60.0,
    start: str = "2023-06-01",
    seed: int = 0,
    noise: float = 0.3,
    model: str = "faiman",
    dynamics: str = "balance",
    latitude: float = 35.0,
    longitude: float = -106.0,
    surface_tilt: float = 35.0,
    surface_azimuth: float = 180.0,
    **coefficients: float,
) -> pd.DataFrame:
    """
    A synthetic record with known coefficients, broken clouds and gusty wind.

    Solar position and clear sky are pvlib's; clouds, wind and air temperature are
    autoregressive. The record is for tests of fits and for examples; it does not
    represent a climate.

    Parameters
    ----------
    days : float, default 30
        Length of the record. [days]
    step : float, default 60
        [s]
    start : str, default "2023-06-01"
        First day, in local standard time.
    seed : int, default 0
        Seed of the random numbers; equal seeds give equal records.
    noise : float, default 0.3
        Standard deviation of the sensor's error, which is correlated over half an
        hour; 0 for no error. [K]
    model : str, default "faiman"
        Steady model of the module.
    dynamics : str, default "balance"
        ``"ewm"`` or ``"balance"``.
    latitude, longitude, surface_tilt, surface_azimuth : float
        Site and orientation. [°]
    **coefficients
        Coefficients of the model, with ``tau`` or ``capacity``, by default 378 s and
        15 000 J/(m² K), and ``bias``, by default 0. Without any they are ``u0=25``,
        ``u1=6.84`` and ``bias=-2``.

    Returns
    -------
    DataFrame
        ``ghi``, ``dni``, ``dhi``, ``poa_global`` [W/m²], ``temp_air`` [°C],
        ``wind_speed`` [m/s], ``temp_module`` [°C]; the truth is in ``.attrs``.

    Raises
    ------
    ValueError
        If ``days`` or ``step`` is not positive, ``days`` are shorter than a step, or
        the model, the dynamics or a coefficient is unknown.
    """
    if dynamics not in ANSWERS:
        raise ValueError(
            f"unknown dynamics {dynamics!r}; they are {' and '.join(ANSWERS)}"
        )
    for name, value, unit in (("days", days, "days"), ("step", step, "s")):
        if not (is_number(value) and 0 < value < np.inf):
            raise ValueError(f"{name} = {value} must be a positive number [{unit}]")
    if days * 86400 < step:
        raise ValueError(f"days = {days} are shorter than a step of {step} s")
    memory = {"tau": TAU} if dynamics == "ewm" else {"capacity": 15e3}
    if not coefficients:
        coefficients = {"u0": 25.0, "u1": 6.84, **memory, "bias": -2.0}
    usual = {**memory, "bias": 0.0}
    coefficients |= {n: v for n, v in usual.items() if n not in coefficients}
    random = np.random.default_rng(seed)
    hours = round(longitude / 15)
    times = pd.date_range(
        start,
        periods=int(days * 86400 / step),
        freq=pd.Timedelta(seconds=step),
        tz=f"Etc/GMT{-hours:+d}",
    )
    minutes = np.arange(len(times)) * step / 60.0

    def wandering(memory: int) -> np.ndarray:
        """Unit Gaussian noise with a correlation time in minutes."""
        decay = np.full(len(times), np.exp(-step / 60.0 / memory))
        kicks = random.standard_normal(len(times)) * np.sqrt(1 - decay**2)
        return respond(decay, kicks, random.standard_normal())

    data = sky(times, latitude, longitude, wandering)
    sun = data.pop("sun")
    total = pvlib.irradiance.get_total_irradiance(
        surface_tilt,
        surface_azimuth,
        sun["apparent_zenith"],
        sun["azimuth"],
        data["dni"],
        data["ghi"],
        data["dhi"],
    )
    data["poa_global"] = total["poa_global"].fillna(0.0).clip(lower=0.0)
    begins = (times[0] - times[0].normalize()) / pd.Timedelta(hours=1)
    hour = (begins + minutes / 60.0) % 24.0
    data["temp_air"] = (
        15.0
        - 6.0 * np.cos((hour - 3.0) / 24.0 * 2 * np.pi)
        + 3.0 * wandering(3 * 1440)
        + 0.15 * wandering(5)
    )
    gusts = 0.8 * wandering(180) + 0.6 * wandering(4)
    # a Weibull distribution of shape 2 and mean 3 m/s
    data["wind_speed"] = 3.0 / 0.8862 * np.sqrt(-np.log1p(-ndtr(gusts)))
    data = pd.DataFrame(data)
    function = ANSWERS[dynamics]
    drivers = (data[name] for name in ("poa_global", "temp_air", "wind_speed"))
    data["temp_module"] = function(*drivers, model=model, **coefficients)
    if noise:
        data["temp_module"] += noise * wandering(30)
    data.attrs = {
        "source": f"pvlib_fem.datasets.synthetic, seed {seed}",
        "model": model,
        "dynamics": dynamics,
        "coefficients": coefficients,
        "noise": noise,
    }
    return data


def sky(
    times: pd.DatetimeIndex, latitude: float, longitude: float, wandering: Callable
) -> dict:
    """Solar position, and irradiance under broken clouds."""
    location = pvlib.location.Location(latitude, longitude)
    sun = location.get_solarposition(times, method="ephemeris")
    clear = location.get_clearsky(
        times, model="haurwitz", solar_position=sun, apparent_zenith=None
    )
    thickness = 1.2 * wandering(300) + 0.9 * wandering(6)
    index = 0.25 + 0.8 / (1.0 + np.exp(4.0 * thickness))
    ghi = clear["ghi"] * index
    parts = pvlib.irradiance.erbs(ghi, sun["zenith"], times)
    return {"sun": sun, "ghi": ghi, "dni": parts["dni"], "dhi": parts["dhi"]}
