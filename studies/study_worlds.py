"""Simulated worlds whose truth is known, and the cases of the study in them."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
import pandas as pd
import pvlib

from pvlib_fem import simulator
from pvlib_fem.simulator._deposits import PER_DAY
from pvlib_fem.simulator._forcing import (
    EFFICIENCY,
    EMISSIVITY,
    IN_CELL,
    IN_GLASS,
)
from pvlib_fem.simulator._fuentes_world import ABSORPTION

SHIFT = 0  # of all seeds, for worlds on which no rule was tried
#: what the gate is measured on: shifts, one world of how many, and instruments
GATE_SHIFTS, GATE_EVERY = (36210000, 36310000, 36410000), 12
GATE_SEED, GATE_RECORDS = 69000, 200
FLOOR = 0.15  # K, the least gain that the loop calls material
CLEARLY = 2.0  # times the smallest detectable size, from which an effect must show
NEAR = 0.20  # of a coefficient's truth
MARGIN = 0.05  # K by which the loop may stay behind a refit with the truth
PHYSICS = simulator.PHYSICS
SECOND_GENERATOR = "second generator"
CLOSED_CAUSES = "closed causes"  # the family that only the gate's shifts have
LOGGERS = "clock, logger, unit"  # the family whose records may be refused
FINE = 2.0  # ° of azimuth of the windows that trace a skyline
#: share of sunlight that is heat
ABSORBED = {"nodes": IN_GLASS + IN_CELL - EFFICIENCY, "fuentes": ABSORPTION}


def skyline(obstacles):
    """Windows of the sky in columns that trace the obstacles' upper edges."""
    for one in obstacles:
        columns = max(round(one.width / FINE), 1)
        edges = np.linspace(-one.width / 2, one.width / 2, columns + 1)
        middle = (edges[1:] + edges[:-1]) / 2
        knots = np.linspace(edges[0], edges[-1], len(one.heights))
        for left, right, at in zip(edges, edges[1:], middle):
            height = float(np.interp(at, knots, one.heights))
            yield (one.azimuth + left, one.azimuth + right, 0.0, height)


def beam_share(world, size):
    """Of hard edges and one share for all; a penumbra has no fixed share."""
    obstacles = world.site.forms.obstacles
    if len({one.covers for one in obstacles}) > 1 or any(o.blur for o in obstacles):
        return math.nan
    return size * obstacles[0].covers


def sensor_share(world, size):
    return -beam_share(world, size)


def sensor_dirt(world, size):
    """Of dirt that gathers day by day; mass that settles, or pauses, has no rate."""
    return size * PER_DAY if world.site.forms.cleaning == "rain" else math.nan


def module_dirt(world, size):
    return -sensor_dirt(world, size)


def sky_share(world, size):
    """Emissivity times view of the sky, over the share of sunlight that is heat."""
    if world.site.tracker is not None:
        return math.nan  # which sees more or less of it by the hour
    tilt = math.cos(math.radians(world.site.surface_tilt))
    front, back = EMISSIVITY[:, 0]
    rear = back * (1 - tilt) / 2 if world.site.mounting == "rack" else 0.0
    return size * (front * (1 + tilt) / 2 + rear) / ABSORBED[world.generator]


def power_share(world, size):
    """The coefficient of all power, however much of it is curtailed."""
    return 1.0 / ABSORBED[world.generator]


def emitted(world, size):
    """Emissivity of both faces, over the share of sunlight that is heat."""
    return size * EMISSIVITY.sum() / ABSORBED[world.generator]


def aged(world, size):
    """What the module gains on the sensor each year, at the middle of two."""
    return 0.05 * size / (1.0 - 0.05 * size)


@dataclass(frozen=True)
class Truth:
    """A switch's name in the catalogue, its sizes, and its coefficient at size 1."""

    effect: str
    coefficient: str = ""
    value: Callable | float = math.nan
    added: bool = False  # to what the physics has of it
    sizes: tuple = (0.25, 0.5, 1.0, 2.0)
    place: dict = field(default_factory=dict)
    days: int = 365
    step: float = 300.0

    def expected(self, world, size):
        """The coefficient that this size makes; NaN where none is the truth."""
        return self.value(world, size) if callable(self.value) else size * self.value


SHARES = (0.25, 0.5, 0.75, 1.0)  # of what cannot be more than all
SHADES = (0.25, 0.5, 0.75, 1.25)  # of obstacles that take at most 80 % of the beam
COLD = dict(latitude=52.0, temp_mean=4.0, temp_amplitude=12.0, rain_days=0.35)
RACK, ROOF = dict(mounting="rack"), dict(mounting="roof")
DRY = dict(rain_days=0.2, clear_share=0.4)  # dirt gathers, and seldom to its most

TRUTHS = {
    "sky_radiation": Truth("sky_radiation", "share", sky_share),
    "electrical_output": Truth("electrical_output", "share", power_share, sizes=SHARES),
    "wind_direction": Truth("wind_direction", place=RACK),  # ×2 stops a channel
    "rain": Truth("rain", place=dict(rain_days=0.4)),
    "snow": Truth("snow", sizes=SHARES, place=COLD),
    "soiling": Truth("soiling", "per_day", module_dirt, place=DRY),
    "soiling_sensor": Truth("soiling", "per_day", sensor_dirt, place=DRY),
    "shading": Truth("shading", "share", beam_share, sizes=SHADES),
    "shading_sensor": Truth("shading", "share", sensor_share, sizes=SHADES),
    "irradiance_sensor_drift": Truth(
        "irradiance_sensor_drift", "per_year", aged, days=730
    ),
    "clock_shift": Truth(
        "clock_shift", "minutes", 1.0, sizes=(1.0, 2.0, 4.0, 8.0), step=60.0
    ),
    "thermal_storage": Truth("thermal_storage", place=ROOF),
    "rear_irradiance": Truth("rear_irradiance", place=RACK),
    "season": Truth("season", "winter", 0.04, added=True),
    "temperature_gain": Truth("temperature_gain", "gain", -0.03, added=True),
    "air_shield": Truth("air_shield"),
    "poa_misalignment": Truth("poa_misalignment", sizes=(2.0, 4.0, 8.0, 16.0)),
    "natural_convection": Truth("natural_convection"),
    "wind_shape": Truth("wind_shape"),
    "incidence_angle": Truth("incidence_angle"),
    "radiative_loss": Truth("radiative_loss", "share", emitted, sizes=SHARES),
    "tracker_stuck": Truth("tracker_stuck", "share", 1.0, sizes=(1.0,)),
}
#: effects that power shows, whose words have these causes in one: "snow, leaves or
#: shade", on the modules or on the irradiance sensor. Power that is curtailed to
#: nothing is "hours in which the plant gives no power".
COVERS = {
    "modules_covered": ("snow", "shading"),
    "sensor_covered": ("shading_sensor",),
    "outage": ("electrical_output",),
}
OF_TRACKERS = ("tracker_stuck",)  # which a fixed plane has not

#: what a switch also has: the ground that stores heat lies on a layer that follows the
#: air of three days
ALSO = {"thermal_storage": "ground_or_water"}

#: shapes that physics leaves: T⁴ is a season and a gain of temperature
IN_PHYSICS = {
    "radiative_loss",
    "natural_convection",
    "wind_shape",
    "incidence_angle",
    "season",
    "temperature_gain",
}

#: causes that are in no catalogue: along which drivers they live, each group by one
UNDECLARED = {
    "weekend_exhaust": ({"weekend"}, {"hour", "poa_global"}),
    "chiller": ({"hour", "poa_global"}, {"month", "temp_air"}),
    "irrigation": ({"hour", "poa_global"}, {"month", "temp_air", "hour"}),
    "shelter": ({"hour", "poa_global"}, {"month", "temp_air"}),
    "fan": ({"hour", "poa_global", "wind_speed", "temp_air"},),
    "reflection": ({"hour", "poa_global"},),
    "plume": ({"wind_direction"},),
    "puddles": ({"hour", "poa_global"}, {"relative_humidity", "precipitation"}),
}
HEATS = tuple(UNDECLARED)[:5]  # by the clock, which a neighbour's column may have

#: more of them, of which nothing is looked at before the gate is measured
CLOSED = {
    "sea_breeze": ({"hour", "poa_global"}, {"month", "temp_air"}),
    "misters": ({"hour", "poa_global"}, {"month", "temp_air", "relative_humidity"}),
    "fog": ({"hour", "poa_global"}, {"month", "temp_air", "relative_humidity"}),
    "inverter_hall": ({"hour", "poa_global"}, {"month", "temp_air"}),
    "compost": ({"month", "temp_air", "hour", "poa_global"},),
    "lorries": ({"weekend"}, {"hour", "poa_global", "wind_speed"}),
    "charger": ({"hour", "poa_global"},),
    "frozen_contact": ({"month", "temp_air"}, {"hour", "poa_global"}),
}
UNKNOWN = UNDECLARED | CLOSED
#: sizes that show, where 1 does not in every climate
LARGER = {"irrigation": 1.5, "puddles": 1.5}
#: climates without which they would seldom be there
PLACES = {
    "puddles": dict(rain_days=0.3),
    "fog": dict(dew_depression=3.0),
    "frozen_contact": COLD,
}


@dataclass(frozen=True)
class World:
    """A site and its weather, which several records share."""

    site: simulator.Site
    seed: int
    days: float = 365
    step: float = 300.0
    start: str = "2023-01-01"
    generator: str = "nodes"
    described: bool = False  # whether a tracker is described, and not in columns

    @property
    def name(self):
        s = self.site
        kind = s.mounting if s.tracker is None else "tracker"
        return (
            f"{s.latitude:.0f}°N {kind}, wind {s.wind_mean:.1f}, clear "
            f"{s.clear_share:.2f}, rain {s.rain_days:.2f}, {self.days:g} d at "
            f"{self.step / 60:g} min"
        )

    @property
    def place(self):
        """What a user knows of the site."""
        s = self.site
        location = pvlib.location.Location(s.latitude, s.longitude, tz=s.tz)
        if s.tracker is not None:
            names = ("axis_tilt", "axis_azimuth", "max_angle", "gcr", "backtrack")
            own = {name: getattr(s.tracker, name) for name in names}
            mount = pvlib.pvsystem.SingleAxisTrackerMount(**own)
            return dict(location=location) | (
                {"mount": mount} if self.described else {}
            )
        return dict(
            location=location,
            surface_tilt=s.surface_tilt,
            surface_azimuth=s.surface_azimuth,
        )


@dataclass(frozen=True)
class Case:
    """What is on in one record, what the user does not have, and the truth."""

    family: str
    on: dict
    sizes: dict = field(default_factory=dict)  # switch: amplitude of what was added
    off: dict | None = None  # the same without it, where its size is asked
    drop: tuple = ()
    offset: float = 0.0  # of the module's sensor [K]
    neighbour: bool = False
    form: dict | None = None  # of an exact null

    @property
    def model(self):
        """The steady model that a user takes."""
        return "ross" if "wind_speed" in self.drop else "faiman"

    @property
    def truths(self):
        """Names in the catalogue, each once."""
        names = [TRUTHS[s].effect for s in self.sizes if s in TRUTHS]
        names += ["driver:neighbour"] * self.neighbour
        names += ["clock_shift"] * bool({"clock_drift", "dst"} & {*self.sizes})
        return tuple(dict.fromkeys(names))

    @property
    def covers(self):
        """By name of an effect that power shows, the truths that are its causes."""
        known = {
            effect: [
                TRUTHS[switch].effect for switch in switches if switch in self.sizes
            ]
            for effect, switches in COVERS.items()
        }
        return {effect: truths for effect, truths in known.items() if truths}

    @property
    def label(self):
        parts = [f"{name}×{size:g}" for name, size in self.sizes.items()]
        parts += [f"offset {self.offset:g} K"] * bool(self.offset)
        parts += [f"without {' '.join(self.drop)}"] * bool(self.drop)
        return ", ".join(parts) or "nothing"


def site(seed, **changes):
    """A site that could be, its laws and obstacles; the same for a seed."""
    random = np.random.default_rng([seed, 2023])
    latitude = random.uniform(25.0, 60.0)
    clear = random.uniform(0.2, 0.75)
    made = simulator.Site(
        latitude=latitude,
        longitude=random.uniform(-120.0, 140.0),
        surface_tilt=float(np.clip(0.8 * latitude + random.uniform(-12, 8), 10, 55)),
        surface_azimuth=180.0 + random.uniform(-40.0, 40.0),
        mounting="roof" if random.random() < 0.35 else "rack",
        temp_mean=28.0 - 0.36 * latitude + random.uniform(-3.0, 3.0),
        temp_amplitude=1.0 + 0.2 * latitude + random.uniform(-2.0, 2.0),
        wind_mean=random.uniform(1.5, 5.0),
        rain_days=float(
            np.clip(0.5 - 0.6 * clear + random.uniform(-0.1, 0.1), 0.03, 1)
        ),
        clear_share=clear,
        dew_depression=2.0 + 18.0 * clear**2 + random.uniform(0.0, 3.0),
        albedo=random.uniform(0.1, 0.35),
    )
    return lawful(replace(made, **changes), seed)


def lawful(where, seed):
    """A site with formulations and obstacles of its own."""
    return replace(where, forms=simulator.drawn(seed, where))


def exact_null(count=60, draws=5):
    """The fitted form itself, with noise that remembers minutes to days."""
    for i in range(count // draws):
        cases = []
        for j in range(draws):
            random = np.random.default_rng([SHIFT + 1000 + i, j])
            form = dict(
                seed=SHIFT + 1000 * i + j,
                dynamics=("balance", "ewm")[j % 2],
                u0=random.uniform(18, 32),
                u1=random.uniform(3, 8),
                memory=random.uniform(200, 700),
                noise=random.uniform(0.3, 1.5),
                hours=float(np.exp(random.uniform(np.log(0.05), np.log(72)))),
                by_day=bool(random.random() < 0.5),
            )
            # power is curtailed in half of them, and heats nothing
            on = PHYSICS | {"electrical_output": float(j % 2)}
            cases.append(Case("exact null", on, form=form))
        yield World(site(SHIFT + 1000 + i), SHIFT + 1000 + i), cases


def physics_null(count=30):
    """The full simulator with all that has a driver of its own off."""
    known = [simulator.RHINE, simulator.ALBUQUERQUE]
    for i in range(count):
        seed = SHIFT + 2000 + i
        where = lawful(known[i % 2], seed) if i < 6 else site(seed)
        step = 60.0 if i in (4, 5, 6) else 300.0
        yield World(where, seed, step=step), [Case("physics null", PHYSICS)]


#: switches of the second generator, each in a size that shows
SECOND = dict(
    soiling=2.0,
    soiling_sensor=2.0,
    shading=1.0,
    shading_sensor=1.0,
    electrical_output=1.0,
    snow=1.0,
    irradiance_sensor_drift=2.0,
    rear_irradiance=2.0,
    poa_misalignment=8.0,
    season=2.0,
    air_shield=2.0,
    temperature_gain=2.0,
)


def second_generator(count=44):
    """pvlib's `fuentes` in the same weather: nulls, a third of them with an effect."""
    for i in range(count):
        seed, effects = SHIFT + 9500 + i, list(SECOND.items())
        if i >= len(SECOND):
            world = World(site(seed), seed, step=600.0, generator="fuentes")
            yield world, [Case(SECOND_GENERATOR, PHYSICS)]
            continue
        switch, size = effects[i]
        truth = TRUTHS[switch]
        where = site(seed, **truth.place)
        world = World(where, seed, truth.days, 600.0, generator="fuentes")
        on = PHYSICS | {switch: size}
        yield world, [Case(SECOND_GENERATOR, on, {switch: size}, PHYSICS)]


def one_effect(weathers=3):
    for j in range(weathers):
        for i, (switch, truth) in enumerate(TRUTHS.items()):
            if switch in OF_TRACKERS:
                continue
            seed = SHIFT + 3000 + 100 * j + i
            off = PHYSICS | {switch: 0.0}
            world = World(site(seed, **truth.place), seed, truth.days, truth.step)
            cases = [
                Case("one effect", off | {switch: size}, {switch: size}, off)
                for size in truth.sizes
            ]
            yield world, cases


#: with a driver of its own each, in a size that shows
APART = dict(
    sky_radiation=1.0,
    electrical_output=1.0,
    wind_direction=2.0,
    rain=1.5,
    soiling_sensor=2.0,
    shading=1.0,
    snow=1.0,
    soiling=2.0,
    shading_sensor=1.0,
    season=2.0,
)


def several(count=30):
    for i in range(count):
        random = np.random.default_rng([SHIFT + 4000, i])
        chosen = []
        for name in random.permutation(list(APART)):
            there = [TRUTHS[other].effect for other in chosen]
            if TRUTHS[name].effect not in there and len(chosen) < 2 + i % 2:
                chosen.append(str(name))
        sizes = {name: APART[name] for name in chosen}
        place = {}
        for name in chosen:
            place |= TRUTHS[name].place
        world = World(site(SHIFT + 4000 + i, **place), SHIFT + 4000 + i)
        yield world, [Case("pairs and triples", PHYSICS | sizes, sizes, PHYSICS)]


def unknown(name, kinds, first, nodes=0, second=0, neighbour=False):
    """Each kind in some weathers of the nodes, then of the second generator."""
    generators = ["nodes"] * nodes + ["fuentes"] * second
    for i, (generator, switch) in enumerate(product(generators, kinds)):
        size = {switch: LARGER.get(switch, 1.0)}
        seed = SHIFT + first + i
        where = site(seed, **PLACES.get(switch, {}))
        step = 600.0 if generator == "fuentes" else 300.0
        case = Case(name, PHYSICS | size, size, PHYSICS, neighbour=neighbour)
        yield World(where, seed, step=step, generator=generator), [case]


def no_catalogue():
    name, others = "no catalogue", [kind for kind in UNDECLARED if kind not in HEATS]
    yield from unknown(name, HEATS, 5000, nodes=5, second=1)
    yield from unknown(name, others, 5030, nodes=3, second=2)


def with_column():
    yield from unknown("its driver as a column", HEATS, 5500, 2, neighbour=True)


def closed_causes():
    if SHIFT in GATE_SHIFTS:
        yield from unknown(CLOSED_CAUSES, CLOSED, 5600, nodes=3, second=2)


NO_SKY, NO_GAUGE = ("relative_humidity", "longwave_down"), ("precipitation",)


def no_driver(count=20):
    for i in range(count):
        switch, drop = (("sky_radiation", NO_SKY), ("rain", NO_GAUGE))[i % 2]
        size = {switch: (1.0, 1.5)[i // 2 % 2]}
        place = TRUTHS[switch].place
        case = Case("driver missing", PHYSICS | size, size, PHYSICS, drop=drop)
        yield World(site(SHIFT + 6000 + i, **place), SHIFT + 6000 + i), [case]


def ties(count=10):
    kinds = [
        # the back absorbs 0.9 of the light on it, as that of a bifacial module
        dict(sizes={"rear_irradiance": 1.5}),
        dict(sizes={"poa_misalignment": 8.0}),
        dict(sizes={"sky_radiation": 1.0}, also={"irradiance_offset": 2.0}),
        dict(sizes={"sky_radiation": 1.0}, offset=1.5),
        dict(sizes={"sky_radiation": 1.0}, offset=1.5, drop=NO_SKY),
    ]
    for i in range(count):
        kind = dict(kinds[i % len(kinds)])
        on = PHYSICS | kind["sizes"] | kind.pop("also", {})
        world = World(site(SHIFT + 7000 + i, **RACK), SHIFT + 7000 + i)
        yield world, [Case("ties", on, off=PHYSICS, **kind)]


def loggers():
    """Faults of clocks, loggers and units, with the sky on."""
    faults = [
        ({"clock_shift": 6.0}, 60.0),
        ({"clock_shift": -4.0}, 60.0),
        ({"clock_drift": 6.0}, 60.0),
        ({"dst": 1.0}, 300.0),
        ({"file_dst": 1.0}, 300.0),
        ({"stuck": 1.0}, 300.0),
        ({"swap": {"wind_speed": "km/h"}}, 300.0),
        ({"swap": {"temp_module": "degF"}}, 300.0),
        ({"swap": {"poa_global": "kW/m2"}}, 300.0),
        ({"swap": {"temp_air": "K"}}, 300.0),
    ]
    for i, (fault, step) in enumerate(faults):
        on = PHYSICS | {"sky_radiation": 1.0} | fault
        shown = {
            name: size if not isinstance(size, dict) else math.nan
            for name, size in fault.items()
        }
        case = Case(LOGGERS, on, {"sky_radiation": 1.0, **shown})
        yield World(site(SHIFT + 8000 + i), SHIFT + 8000 + i, step=step), [case]


def short(count=20):
    kinds = [
        {},
        {"sky_radiation": 1.0},
        {"wind_direction": 2.0},
        {"weekend_exhaust": 1.0},
        {"thermal_storage": 1.0},
    ]
    for i in range(count):
        days, sizes = (7, 30, 60, 90)[i % 4], kinds[i // 4 % len(kinds)]
        start = f"2023-{1 + (5 * i) % 12:02d}-01"
        world = World(
            site(SHIFT + 9000 + i, **RACK), SHIFT + 9000 + i, days, start=start
        )
        yield world, [Case("short records", PHYSICS | sizes, sizes)]


#: without an anemometer: effects that need no wind, each in a size that shows
CALM = dict(
    sky_radiation=1.0,
    electrical_output=1.0,
    rain=1.5,
    snow=1.0,
    soiling=2.0,
    soiling_sensor=2.0,
    shading=1.0,
    shading_sensor=1.0,
)
NO_WIND, NO_VANE = "no wind sensor", ("wind_speed", "wind_direction")


def no_wind(nulls=12, weathers=2):
    """Nulls, effects and unknown causes in records that the model ross is fitted to."""
    alone = dict(drop=NO_VANE)
    for i in range(nulls):
        seed = SHIFT + 9700 + i
        case = Case(NO_WIND, PHYSICS, **alone)
        yield World(site(seed), seed, step=600.0), [case]
    for i, (switch, size) in enumerate([*CALM.items()] * weathers):
        seed, truth = SHIFT + 9720 + i, TRUTHS[switch]
        world = World(site(seed, **truth.place), seed, truth.days, 600.0)
        own = {switch: size}
        off = PHYSICS | {switch: 0.0}
        yield world, [Case(NO_WIND, off | own, own, off, **alone)]
    for i, switch in enumerate(UNDECLARED):
        seed, own = SHIFT + 9750 + i, {switch: LARGER.get(switch, 1.0)}
        world = World(site(seed, **PLACES.get(switch, {})), seed, step=600.0)
        yield world, [Case(NO_WIND, PHYSICS | own, own, PHYSICS, **alone)]


TRACKERS, ANGLES = "trackers", ("surface_tilt", "surface_azimuth")
POWER = ("p_dc_per_area",)
#: effects and faults in worlds of trackers, each in a size that shows
ON_TRACKERS = dict(
    sky_radiation=1.0,
    electrical_output=1.0,
    rain=1.5,
    snow=1.0,
    soiling=2.0,
    soiling_sensor=2.0,
    shading=1.0,
    shading_sensor=1.0,
    irradiance_sensor_drift=2.0,
    clock_shift=8.0,
)
STANDS = {"tracker_stuck": 1.0}
STAND_BOTH = STANDS | {"tracker_stuck_sensor": 1.0}


def tracking(seed, days=365, **changes):
    """A site with a single-axis tracker, which is stuck for days if that is on."""
    random = np.random.default_rng([seed, 2031])
    most = random.uniform(45.0, 60.0)
    begin, length = random.uniform(20.0, days - 60.0), random.uniform(5.0, 35.0)
    start, end = (
        pd.Timestamp(World.start) + pd.Timedelta(days=int(day))
        for day in (begin, begin + length)
    )
    stuck = simulator.Stuck(
        f"{start:%Y-%m-%d}", f"{end:%Y-%m-%d}", random.uniform(-most, most)
    )
    tracker = simulator.Tracker(
        axis_azimuth=180.0 + random.uniform(-20.0, 20.0),
        max_angle=most,
        gcr=random.uniform(0.25, 0.5),
        backtrack=bool(random.random() < 0.7),
        stuck=stuck,
    )
    return site(seed, **RACK, tracker=tracker, **changes)


def trackers(nulls=12, still=12, both=6):
    """Nulls, effects, faults, unknown causes, and rows that are stuck."""
    count = iter(range(1000))

    def made(sizes=None, off=PHYSICS, on=None, power=False, **world):
        i = next(count)
        seed, place = SHIFT + 9800 + i, world.pop("place", {})
        where = tracking(seed, **place)
        # every other one is described, and has no columns of its angles; every third
        # has no power, by which the days of test weeks are known
        drop = (ANGLES if i % 2 else ()) + (POWER if i % 3 == 2 and not power else ())
        sizes = sizes or {}
        on = off | (sizes if on is None else on)
        case = Case(TRACKERS, on, sizes, off if sizes else None, drop=drop)
        step = dict(step=600.0) | world
        return World(where, seed, described=bool(i % 2), **step), [case]

    for _ in range(nulls):
        yield made()
    for switch, size in ON_TRACKERS.items():
        truth = TRUTHS[switch]
        place = {n: v for n, v in truth.place.items() if n != "mounting"}
        # an offset of minutes needs rows that are no further apart
        step = truth.step if switch == "clock_shift" else 600.0
        world = dict(days=truth.days, place=place, step=step)
        world["power"] = switch == "electrical_output"
        yield made({switch: size}, PHYSICS | {switch: 0.0}, **world)
    for switch in UNDECLARED:
        size, place = {switch: LARGER.get(switch, 1.0)}, PLACES.get(switch, {})
        yield made(size, place=place)
    for _ in range(still):
        yield made(STANDS)
    for _ in range(still // 2):
        sky = {"sky_radiation": 1.0}
        yield made(STANDS | sky)
    for _ in range(both):
        # the record is wrong, and no effect of the catalogue is there
        yield made({"tracker_stuck_sensor": 1.0}, on=STAND_BOTH)


FAMILIES = {
    "exact null": exact_null,
    "physics null": physics_null,
    SECOND_GENERATOR: second_generator,
    "one effect": one_effect,
    "pairs and triples": several,
    "no catalogue": no_catalogue,
    CLOSED_CAUSES: closed_causes,
    "its driver as a column": with_column,
    "driver missing": no_driver,
    "ties": ties,
    LOGGERS: loggers,
    "short records": short,
    NO_WIND: no_wind,
    TRACKERS: trackers,
}
#: of which every world counts, however few of the others do
WHOLE = ("no catalogue", CLOSED_CAUSES)
