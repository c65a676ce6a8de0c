"""Names of the published formulations that a simulated site follows."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, TypeVar

Part = TypeVar("Part", "Obstacle", "Days", "Minutes")

#: formulations of each law, the default first; tests check them by their functions
RIVALS = {
    "cleaning": ("rain", "kimber", "hsu"),
    "vapour": ("magnus", "tetens", "buck", "clausius_clapeyron"),
    "diffuse": ("erbs", "erbs_driesse", "orgill_hollands", "boland"),
    "transposition": (
        "isotropic",
        "haydavies",
        "reindl",
        "klucher",
        "perez-driesse",
    ),
    "emissivity": ("berdahl_martin", "prata", "brunt", "brutsaert", "idso_jackson"),
    "natural": ("tarp", "churchill_chu", "mcadams"),
    "forced": ("mowitt", "flat_plate", "sparrow", "watmuff"),
    "snow": ("sliding", "coverage_nrel", "melting"),
}


def as_form(kind: type[Part], value: Part | Mapping[str, Any]) -> Part:
    """A part of `Forms`; a mapping from a record's attrs is converted."""
    if isinstance(value, Mapping):
        return kind(**value)
    if not isinstance(value, kind):
        names = ", ".join(field.name for field in fields(kind))
        raise ValueError(f"{value!r} is no {kind.__name__}; give its {names}")
    return value


def check_range(name: str, value: float, least: float, most: float) -> None:
    """
    Refuse a number out of its range.

    Parameters
    ----------
    name : str
        For the message.
    value, least, most : float
        In one unit.

    Raises
    ------
    ValueError
        If it is below the least or above the most, or NaN.
    """
    if not least <= value <= most:
        raise ValueError(f"{name} = {value} must be from {least} to {most}")


@dataclass(frozen=True)
class Obstacle:
    """
    An obstacle on the horizon between the sun and the module.

    Parameters
    ----------
    azimuth, width : float
        Azimuth of its middle, clockwise from north, and its width. [°]
    heights : tuple of float
        Elevations of its upper edge at even distances from left to right, linear
        between; one for a level edge. [°]
    covers : float
        Share of the beam that it blocks: less than 1 if it shades a part of the
        module or is a tree. [-]
    blur : float
        Width of its penumbra, half of it inside each edge. [°]
    """

    azimuth: float = 121.5
    width: float = 27.0
    heights: tuple[float, ...] = (28.0,)
    covers: float = 0.8
    blur: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "heights", tuple(map(float, self.heights)))
        check_range("width", self.width, 0.0, 360.0)
        check_range("covers", self.covers, 0.0, 1.0)
        check_range("blur", self.blur, 0.0, 90.0)
        if not self.heights:
            raise ValueError("heights = () of an obstacle; give one or more [°]")


@dataclass(frozen=True)
class Days:
    """A schedule by days: one of every ``every`` days, during some ``hours``."""

    every: int = 2
    phase: int = 1  # days since 1970-01-01, modulo `every`
    hours: tuple[tuple[float, float], ...] = ((6.0, 7.0), (20.0, 21.0))

    def __post_init__(self) -> None:
        object.__setattr__(self, "hours", tuple(map(tuple, self.hours)))
        check_range("every", self.every, 1, 366)
        check_range("phase", self.phase, 0, self.every - 1)


@dataclass(frozen=True)
class Minutes:
    """A schedule by minutes: the first ``on`` minutes of every ``period``."""

    on: float = 35.0
    period: float = 150.0
    phase: float = 0.0  # minutes since 1970-01-01, modulo `period`

    def __post_init__(self) -> None:
        check_range("period", self.period, 1.0, 1e6)
        check_range("on", self.on, 0.0, self.period)
        check_range("phase", self.phase, 0.0, self.period)


@dataclass(frozen=True)
class Forms:
    """
    The formulation of each law, and the surroundings of a module.

    Each name is one of `RIVALS`; the functions of these names have the sources.

    Parameters
    ----------
    obstacles : tuple of Obstacle
        Obstacles before the module or the irradiance sensor, if ``shading`` or
        ``shading_sensor`` are on.
    cleaning : {"rain", "kimber", "hsu"}
        Model of soiling; ``washed_by`` applies to ``"rain"``.
    washed_by : tuple of float
        Rain that cleans, and its duration. [mm, h]
    vapour : str
        Saturation vapour pressure over water.
    diffuse : str
        Diffuse fraction of global irradiance, as in `pvlib.irradiance`.
    transposition : str
        Transposition of sky diffuse irradiance, as in
        `pvlib.irradiance.get_sky_diffuse`.
    emissivity : str
        Emissivity of the clear sky.
    natural, forced : str
        Convection of a face without and with wind.
    calm_excess : float
        Over-temperature of constant natural convection, if its switch is 0. [K]
    snow : {"sliding", "coverage_nrel", "melting"}
        Removal of snow from the module.
    watering : Days
        Schedule of ``irrigation``.
    fan : Minutes
        Schedule of ``fan``.
    """

    obstacles: tuple[Obstacle, ...] = (Obstacle(),)
    cleaning: str = "rain"
    washed_by: tuple[float, ...] = (1.0, 3.0)
    vapour: str = "magnus"
    diffuse: str = "erbs"
    transposition: str = "isotropic"
    emissivity: str = "berdahl_martin"
    natural: str = "tarp"
    forced: str = "mowitt"
    calm_excess: float = 15.0
    snow: str = "sliding"
    watering: Days = Days()
    fan: Minutes = Minutes()

    def __post_init__(self) -> None:
        parts = {
            "watering": as_form(Days, self.watering),
            "fan": as_form(Minutes, self.fan),
        }
        parts["obstacles"] = tuple(as_form(Obstacle, one) for one in self.obstacles)
        parts["washed_by"] = tuple(map(float, self.washed_by))
        for name, value in parts.items():
            object.__setattr__(self, name, value)
        for name, rivals in RIVALS.items():
            if getattr(self, name) not in rivals:
                raise ValueError(
                    f"{name} = {getattr(self, name)!r}; it is one of "
                    f"{', '.join(map(repr, rivals))}"
                )
        check_range("calm_excess", self.calm_excess, 1.0, 60.0)
        if len(self.washed_by) != 2 or not min(self.washed_by) > 0:
            raise ValueError(f"washed_by = {self.washed_by}; give mm and hours above 0")
