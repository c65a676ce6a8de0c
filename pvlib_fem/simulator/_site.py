"""The site of the module, and its climate."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from pvlib_fem.simulator._submodels import Forms, check_range
from pvlib_fem.simulator._tracker import Tracker

MOUNTINGS = ("rack", "roof")
#: least and largest value of what has one
RANGES = {
    "latitude": (-90.0, 90.0),
    "longitude": (-180.0, 180.0),
    "surface_tilt": (0.0, 180.0),
    "rain_days": (0.0, 1.0),
    "clear_share": (0.0, 1.0),
    "albedo": (0.0, 1.0),
}


@dataclass(frozen=True)
class Site:
    """
    The site of the module, and its climate; by default the Rhine valley.

    Parameters
    ----------
    latitude, longitude : float
        North and east positive. Time is local standard, from the longitude. [°]
    surface_tilt, surface_azimuth : float
        Orientation of a fixed module; azimuth from north, clockwise. [°]
    mounting : {"rack", "roof"}
        Open at the back, or a channel over a roof.
    temp_mean, temp_amplitude : float
        Annual mean of air temperature and half its annual swing. [°C, K]
    wind_mean : float
        Mean wind speed at the mast; its distribution is Weibull of shape 2. [m/s]
    rain_days, clear_share : float
        Share of days with rain, share of hours with a clear sky. [-]
    dew_depression : float
        Median of air temperature minus dew point. [K]
    albedo : float
        Albedo of the ground. [-]
    forms : Forms
        Formulation of each law, and surroundings of the module.
    tracker : Tracker, optional
        A single-axis tracker, an open rack, instead of the fixed orientation.
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
    forms: Forms = field(default_factory=Forms)
    tracker: Tracker | None = None

    def __post_init__(self) -> None:
        if isinstance(self.forms, Mapping):  # from a record's attrs
            object.__setattr__(self, "forms", Forms(**self.forms))
        for name, ends in RANGES.items():
            check_range(name, getattr(self, name), *ends)
        if self.mounting not in MOUNTINGS:
            raise ValueError(f"mounting = {self.mounting!r}; it is 'rack' or 'roof'")
        if isinstance(self.tracker, Mapping):
            object.__setattr__(self, "tracker", Tracker(**self.tracker))
        if self.tracker is not None and self.mounting != "rack":
            raise ValueError(
                f"mounting = {self.mounting!r} of a tracker; its modules are a 'rack'"
            )

    @property
    def utc_offset(self) -> int:
        """Local standard time minus universal time. [h]"""
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
