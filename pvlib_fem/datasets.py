"""Records to try things on: measured ones, and one that the package makes."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pooch
import pvlib
from scipy.special import ndtr

from pvlib_fem.relaxation import respond
from pvlib_fem.thermal.temperature import fem_temperature, heat_balance

__all__ = [
    "load",
    "synthetic",
]

FOLDER = "PVLIB_FEM_DATA"  # environment variable: a folder that holds the files

GITHUB = "https://raw.githubusercontent.com"
PVLIB = f"{GITHUB}/pvlib/pvlib-python/7cf4cdbfcb305db0ef2b61d7a5f06d18cc2f9d46"
PECOS = f"{GITHUB}/sandialabs/pecos/19fb849ea0635f84b1aec38bd336de63d47af5ed"

#: file: its public address and sha256
FILES = {
    "sandia_week_1min.csv": (
        f"{PVLIB}/pvlib/data/tmod_sample_data_subset.csv",
        "9687906e1f7fe6608b80b6e89bc09a511a8d359738fb3127f8018f0181f7a528",
    ),
    "MET_2015_11_11.dat": (
        f"{PECOS}/examples/pv/MET_2015_11_11.dat",
        "81fba5fc6c14ecd6d923d7c5da073293273520ed7fe257bfb9fd26fd7d8df224",
    ),
    "Baseline6kW_2015_11_11.dat": (
        f"{PECOS}/examples/pv/Baseline6kW_2015_11_11.dat",
        "724a7b426feae8d5c1718bbe2ff96125906232ebea15334535c27ae7e81acb35",
    ),
}


def load(name: str) -> pd.DataFrame:
    """
    A measured record in pvlib's names.

    The public file is downloaded once and kept (pooch), unless the environment
    variable ``PVLIB_FEM_DATA`` names a folder that holds it. Its hash is
    checked either way.

    Parameters
    ----------
    name : str
        ``"sandia_week"``: seven days of March 2020 at 1 min, Albuquerque.
        ``"sandia_day"``: one windy day of broken clouds at 1 min, Albuquerque,
        with wind direction, DC power of one string and sixteen sensors.

    Returns
    -------
    DataFrame
        ``poa_global`` [W/m²], ``temp_air`` [°C], ``wind_speed`` [m/s],
        ``temp_module`` [°C] and what else was measured; zone-naive local
        standard time. The source is in ``.attrs``.

    Raises
    ------
    ValueError
        If there is no record of that name, or a file is not the pinned one.
    OSError
        If a file is neither at hand nor to be downloaded.
    """
    readers = {"sandia_week": sandia_week, "sandia_day": sandia_day}
    if name not in readers:
        raise ValueError(f"unknown record {name!r}; there are {', '.join(readers)}")
    return readers[name]()


def sandia_week():
    data = pd.read_csv(fetch("sandia_week_1min.csv"), index_col=0, parse_dates=True)
    data = data.rename(columns={"temp_pv": "temp_module"})
    data.attrs = {
        "source": "A. Driesse, Sandia National Laboratories and DuraMAT, "
        "doi:10.5281/zenodo.10003736; subset of pvlib-python pull request 1878",
        "licence": "BSD-3-Clause repository",
        "surface_tilt": "not stated",
    }
    return data


def sandia_day():
    met, array = (
        pd.read_csv(fetch(file), skiprows=[0, 2, 3], index_col=0, parse_dates=True)
        for file in ("MET_2015_11_11.dat", "Baseline6kW_2015_11_11.dat")
    )
    raw = met.join(array.drop(columns="RECORD"), how="inner")
    sensors = {f"temp_module_{i}": raw[f"ModTemp{i}_Avg"] for i in range(1, 17)}
    first_array = [sensors[f"temp_module_{i}"] for i in range(1, 9)]
    data = pd.DataFrame(
        {
            "poa_global": raw["POAIrrad1_Avg"],
            "temp_air": raw["Temp_C_Avg"],
            "wind_speed": raw["WS_ms_Mean"],
            "temp_module": pd.concat(first_array, axis=1).mean(axis=1),
            "wind_direction": raw["WD_deg_SMM"],
            "relative_humidity": raw["RH_pct_Avg"],
            "power_string": raw["Sys1Vdc_Avg"] * raw["Sys1Str1Idc_Avg"],
            **sensors,
        }
    )
    data.attrs = {
        "source": "Sandia National Laboratories, Regional Test Center baseline "
        "systems, 2015-11-11; examples of sandialabs/pecos",
        "licence": "revised BSD",
        "temp_module": "mean of the eight sensors of the first array",
        "relative_humidity": "doubtful: read before use",
        "power_string": "DC power of one string [W]; its module area is not stated",
    }
    return data


def fetch(file):
    """Path of a file whose hash is right: in the user's folder, or downloaded."""
    url, sha256 = FILES[file]
    folder = os.environ.get(FOLDER)
    if folder and (path := Path(folder) / file).is_file():
        if pooch.file_hash(str(path)) != sha256:
            raise ValueError(
                f"{path} is not the pinned file (its sha256 differs); remove it, or "
                f"unset {FOLDER}"
            )
        return path
    cache = pooch.os_cache("pvlib_fem")
    try:
        return pooch.retrieve(url, f"sha256:{sha256}", fname=file, path=cache)
    except OSError as error:  # no network, or no folder to keep it
        raise OSError(
            f"{file} is not at hand and cannot be downloaded from {url} "
            f"({type(error).__name__}); go online once, or download it elsewhere, put "
            f"it into a folder and name that in the environment variable {FOLDER}"
        ) from None


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
    A made-up record with known coefficients: broken clouds, gusty wind.

    Sun and sky are pvlib's; clouds, wind and air temperature are
    autoregressive. It is meant to test fits and to run examples, not to stand
    for a climate.

    Parameters
    ----------
    days : float, default 30
    step : float, default 60
        [s]
    start : str, default "2023-06-01"
        First day, in local standard time.
    seed : int, default 0
        The same seed gives the same record.
    noise : float, default 0.3
        Standard deviation of the sensor's error, which keeps its memory for
        half an hour; 0 leaves it out. [K]
    model : str, default "faiman"
        Steady model of the module.
    dynamics : str, default "balance"
        ``"ewm"`` or ``"balance"``.
    latitude, longitude, surface_tilt, surface_azimuth : float
        Site and orientation. [°]
    **coefficients
        Of the model, with ``tau`` or ``capacity`` and ``bias``. Without any:
        ``u0=25``, ``u1=6.84``, ``capacity=15e3``, ``bias=-2``.

    Returns
    -------
    DataFrame
        ``ghi``, ``dni``, ``dhi``, ``poa_global`` [W/m²], ``temp_air`` [°C],
        ``wind_speed`` [m/s], ``temp_module`` [°C]; the truth is in ``.attrs``.
    """
    if not coefficients:
        coefficients = dict(u0=25.0, u1=6.84, capacity=15e3, bias=-2.0)
    random = np.random.default_rng(seed)
    hours = round(longitude / 15)
    times = pd.date_range(
        start,
        periods=int(days * 86400 / step),
        freq=pd.Timedelta(seconds=step),
        tz=f"Etc/GMT{-hours:+d}",
    )
    minutes = np.arange(len(times)) * step / 60.0

    def wandering(memory):
        """Unit Gaussian noise with a memory in minutes."""
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
    hour = (minutes / 60.0) % 24.0
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
    answers: dict[str, Callable[..., Any]] = {"balance": heat_balance}
    function = answers.get(dynamics, fem_temperature)
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


def sky(times, latitude, longitude, wandering):
    """Sun position and irradiance under clouds that come and go."""
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
