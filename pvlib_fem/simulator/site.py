"""Where the module stands, and small pieces that all layers share."""

import zlib
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

SIGMA = 5.670374419e-8  # W m⁻² K⁻⁴
ZERO = 273.15  # 0 °C [K]
DAY = 86400.0  # s
MOUNTINGS = ("rack", "roof")


@dataclass(frozen=True)
class Site:
    """
    Where the module stands, and in which climate. Defaults: the Rhine valley.

    Parameters
    ----------
    latitude, longitude : float
        North and east positive. Time is local standard, from the longitude. [°]
    surface_tilt, surface_azimuth : float
        Of the module; azimuth from north, clockwise. [°]
    mounting : {"rack", "roof"}
        Open at the back, or a channel over a roof.
    temp_mean, temp_amplitude : float
        Annual mean of air temperature and half its annual swing. [°C, K]
    wind_mean : float
        Mean wind speed at the mast; its distribution is Weibull of shape 2. [m/s]
    rain_days, clear_share : float
        Share of days with rain, share of hours with a clear sky. [-]
    dew_depression : float
        Median of air temperature less dew point. [K]
    albedo : float
        Of the ground. [-]
    """

    latitude: float = 49.4
    longitude: float = 8.7
    surface_tilt: float = 35.0
    surface_azimuth: float = 180.0
    mounting: str = "rack"
    temp_mean: float = 11.0
    temp_amplitude: float = 9.5
    wind_mean: float = 2.8
    rain_days: float = 0.33
    clear_share: float = 0.35
    dew_depression: float = 5.0
    albedo: float = 0.2

    def __post_init__(self):
        if self.mounting not in MOUNTINGS:
            raise ValueError(f"mounting = {self.mounting!r}; it is 'rack' or 'roof'")

    @property
    def utc_offset(self) -> int:
        """Local standard time less universal time. [h]"""
        return round(self.longitude / 15.0)

    @property
    def tz(self) -> str:
        return f"Etc/GMT{-self.utc_offset:+d}"  # this zone's sign is reversed


RHINE = Site()
ALBUQUERQUE = Site(
    35.05,
    -106.54,
    temp_mean=14.5,
    temp_amplitude=11.5,
    wind_mean=3.5,
    rain_days=0.16,
    clear_share=0.65,
    dew_depression=14.0,
    albedo=0.25,
)


def stream(seed, purpose):
    """Random numbers of one purpose, so that no other use of chance moves them."""
    return np.random.default_rng([seed, zlib.crc32(purpose.encode())])


def wander(random, rows, lag):
    """Ornstein-Uhlenbeck noise of unit variance, with a memory of ``lag`` rows."""
    decay = np.exp(-1.0 / lag)
    source = random.standard_normal(rows)
    source[1:] *= np.sqrt(1.0 - decay**2)
    return lfilter([1.0], [1.0, -decay], source)


def lagged(values, lag):
    """First-order response with a memory of ``lag`` rows, settled at the start."""
    decay = np.exp(-1.0 / lag)
    return lfilter([1.0 - decay], [1.0, -decay], values, zi=[decay * values[0]])[0]


def vapour(celsius):
    """Saturation vapour pressure over water, Magnus. [Pa]"""
    return 611.2 * np.exp(17.62 * celsius / (243.12 + celsius))


def clock(times):
    """Hour of the day and day of the year, both with their fraction."""
    hour = (times - times.normalize()).total_seconds().to_numpy() / 3600.0
    return hour, times.day_of_year.to_numpy() + hour / 24.0


def winter(site, day):
    """1 in midwinter, −1 in midsummer."""
    return np.sign(site.latitude or 1.0) * np.cos(2 * np.pi * (day - 15) / 365.25)


def seconds(times):
    """The even step of a time axis. [s]"""
    steps = np.diff(times.asi8)
    if len(steps) == 0 or (steps != steps[0]).any():
        raise ValueError("weather is not on even steps; resample it first")
    return (times[1] - times[0]).total_seconds()
