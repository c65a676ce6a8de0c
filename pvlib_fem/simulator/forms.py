"""Which of several published formulations a simulated world follows, by name."""

from collections.abc import Mapping
from dataclasses import dataclass, fields

#: rivals of each law, the default first; tests hold them against their functions
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


def made(kind, value):
    """A part of `Forms`, also from a mapping, as a record's attrs have it."""
    if isinstance(value, Mapping):
        return kind(**value)
    if not isinstance(value, kind):
        names = ", ".join(field.name for field in fields(kind))
        raise ValueError(f"{value!r} is no {kind.__name__}; give its {names}")
    return value


def within(name, value, least, most):
    if not least <= value <= most:
        raise ValueError(f"{name} = {value} must be from {least} to {most}")


@dataclass(frozen=True)
class Obstacle:
    """
    What stands on the horizon between the sun and the module.

    Parameters
    ----------
    azimuth, width : float
        Its middle, from north, clockwise, and how far it extends. [°]
    heights : tuple of float
        Elevations of its upper edge at even distances from left to right, straight
        between; one for a level edge. [°]
    covers : float
        Share of the beam that it takes: less than 1 where it covers a part of the
        module or is a tree. [-]
    blur : float
        Width of its penumbra, half of it inside each edge. [°]
    """

    azimuth: float = 121.5
    width: float = 27.0
    heights: tuple = (28.0,)
    covers: float = 0.8
    blur: float = 0.0

    def __post_init__(self):
        object.__setattr__(self, "heights", tuple(map(float, self.heights)))
        within("width", self.width, 0.0, 360.0)
        within("covers", self.covers, 0.0, 1.0)
        within("blur", self.blur, 0.0, 90.0)
        if not self.heights:
            raise ValueError("heights = () of an obstacle; give one or more [°]")


@dataclass(frozen=True)
class Days:
    """A timetable of days: one of every ``every``, between some ``hours``."""

    every: int = 2
    phase: int = 1  # days since 1970-01-01, modulo `every`
    hours: tuple = ((6.0, 7.0), (20.0, 21.0))

    def __post_init__(self):
        object.__setattr__(self, "hours", tuple(map(tuple, self.hours)))
        within("every", self.every, 1, 366)
        within("phase", self.phase, 0, self.every - 1)


@dataclass(frozen=True)
class Minutes:
    """A timetable of minutes: the first ``on`` of every ``period``."""

    on: float = 35.0
    period: float = 150.0
    phase: float = 0.0  # minutes since 1970-01-01, modulo `period`

    def __post_init__(self):
        within("period", self.period, 1.0, 1e6)
        within("on", self.on, 0.0, self.period)
        within("phase", self.phase, 0.0, self.period)


@dataclass(frozen=True)
class Forms:
    """
    The formulation of each law, and what stands or runs around a module.

    Each name is one of `RIVALS`; the functions of those names have the sources.

    Parameters
    ----------
    obstacles : tuple of Obstacle
        Before the module or the irradiance sensor, where ``shading`` or
        ``shading_sensor`` are on.
    cleaning : {"rain", "kimber", "hsu"}
        When dirt gathers and goes; ``washed_by`` is of ``"rain"``.
    washed_by : tuple of float
        Rain that cleans, and the time over which it has to fall. [mm, h]
    vapour : str
        Saturation vapour pressure over water.
    diffuse : str
        Share of diffuse in global irradiance, as in `pvlib.irradiance`.
    transposition : str
        Of diffuse light from the sky, as in `pvlib.irradiance.get_sky_diffuse`.
    emissivity : str
        Of the clear sky.
    natural, forced : str
        Convection of a face without and with wind.
    calm_excess : float
        Excess at which natural convection stands where its switch is 0. [K]
    snow : {"sliding", "coverage_nrel", "melting"}
        How it leaves the module.
    watering : Days
        Timetable of ``irrigation``.
    fan : Minutes
        Timetable of ``fan``.
    """

    obstacles: tuple = (Obstacle(),)
    cleaning: str = "rain"
    washed_by: tuple = (1.0, 3.0)
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

    def __post_init__(self):
        parts = {"watering": made(Days, self.watering), "fan": made(Minutes, self.fan)}
        parts["obstacles"] = tuple(made(Obstacle, one) for one in self.obstacles)
        parts["washed_by"] = tuple(map(float, self.washed_by))
        for name, value in parts.items():
            object.__setattr__(self, name, value)
        for name, rivals in RIVALS.items():
            if getattr(self, name) not in rivals:
                raise ValueError(
                    f"{name} = {getattr(self, name)!r}; it is one of "
                    f"{', '.join(map(repr, rivals))}"
                )
        within("calm_excess", self.calm_excess, 1.0, 60.0)
        if len(self.washed_by) != 2 or not min(self.washed_by) > 0:
            raise ValueError(f"washed_by = {self.washed_by}; give mm and hours above 0")
