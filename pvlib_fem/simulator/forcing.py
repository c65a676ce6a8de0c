"""What acts on the module and does not depend on its temperature."""

import numpy as np

from pvlib_fem.simulator.ground import (
    SNOW_BELOW,
    behind_obstacle,
    bright,
    dirt,
    plane,
    snowpack,
)
from pvlib_fem.simulator.site import (
    DAY,
    SIGMA,
    ZERO,
    clock,
    lagged,
    seconds,
    stream,
    vapour,
    winter,
)

IN_GLASS, IN_CELL = 0.03, 0.89  # share of sunlight; together τα = 0.92, as [3]_
REAR_ABSORPTANCE = 0.6  # of a light back sheet with cells behind it
EFFICIENCY, GAMMA, LOW_LIGHT = 0.20, -0.0035, 0.03  # crystalline silicon; 1, 1/K, 1
EMISSIVITY = np.array([[0.88], [0.85]])  # front, back: pvlib's faiman_rad, [3]_
CALM_EXCESS = 15.0  # K, where it takes its natural convection
MEET = 3.0  # m/s, where its straight line meets MoWiTT
AT_MODULE = 0.85  # wind at the module over wind at the mast
WINDWARD, LEEWARD = (3.26, 0.89), (3.55, 0.617)  # MoWiTT a, b of a·v^b [1]_
SHELTER = 0.30  # wind from behind is slower by that, from the front faster
CHANNEL = 0.3  # speed behind a roof module, share of the wind along it [3]_

# ground of a rack and roof under a module; surface layer of some centimetres
SURFACE = {
    "rack": dict(capacity=9e4, lit=0.6, module=0.4, loss=9.0, cavity=0.0),
    "roof": dict(capacity=9e4, lit=0.0, module=1.0, loss=4.0, cavity=0.5),
}
TO_DEEP = 4.0  # W m⁻² K⁻¹, to the layer below, which follows the air of three days
GROUND_EMISSIVITY = 0.93
HEAT_OF_WATER = 4186.0  # J kg⁻¹ K⁻¹
SNOW_CONTACT = 40.0  # W m⁻² K⁻¹, of some centimetres on the glass


def curtailed(weather):
    """Hours of no output: midday, most often on weekends in spring."""
    times, seed = weather.index, weather.attrs.get("seed", 0)
    weekend = times.day_of_week.to_numpy() >= 5
    spring = (times.month.to_numpy() >= 3) & (times.month.to_numpy() <= 6)
    odds = np.where(weekend, 0.25, 0.08) + np.where(spring, 0.3, 0.0)
    days = times.day_of_year.to_numpy() - 1
    draw, first, last = stream(seed, "curtailment").random((3, 366))[:, days]
    hour, _ = clock(times)
    return (draw < odds) & (hour >= 9.5 + 2 * first) & (hour < 13.5 + 2.5 * last)


def undeclared(times, air, on):
    """Heats of schedules and neighbours, on the glass and on the back. [W/m²]"""
    hour, month = clock(times)[0], times.month.to_numpy()
    weekend = times.day_of_week.to_numpy() >= 5
    exhaust = 120.0 * (weekend & (hour >= 9) & (hour < 16))
    chiller = 100.0 * np.clip((air - 18.0) / 10.0, 0.0, 1.0)
    chiller *= (month >= 6) & (month <= 8) & (hour >= 13) & (hour < 19)
    animals = 50.0 * (((hour >= 20) | (hour < 6)) & ((month <= 4) | (month >= 10)))
    watered = ((hour >= 6) & (hour < 7)) | ((hour >= 20) & (hour < 21))
    watered &= (times.day_of_year.to_numpy() % 2 == 0) & (month >= 4) & (month <= 9)
    back = on["weekend_exhaust"] * exhaust + on["chiller"] * chiller
    return on["irrigation"] * -150.0 * watered, back + on["shelter"] * animals


def fresnel(cosine, index=1.526):
    """Transmittance of a glass face over that at normal incidence."""
    inside = np.sqrt(1.0 - (1.0 - cosine**2) / index**2)
    across = ((cosine - index * inside) / (cosine + index * inside)) ** 2
    along = ((inside - index * cosine) / (inside + index * cosine)) ** 2
    normal = 1.0 - ((index - 1.0) / (index + 1.0)) ** 2
    return (1.0 - (across + along) / 2) / normal


def light(weather, site, on, covered, albedo):
    """What passes the glass and what the back absorbs. [W/m²]"""
    beam, sky, ground, cosine = plane(
        weather, site.surface_tilt, site.surface_azimuth, albedo
    )
    beam = beam * (1 - np.minimum(0.8 * on["shading"], 1) * behind_obstacle(weather))
    sun = beam * (1 + on["incidence_angle"] * (fresnel(cosine) - 1))
    sun += (sky + ground) * (1 + on["incidence_angle"] * (0.955 - 1))
    sun *= (1 - on["soiling"] * dirt(weather)) * (1 - 0.95 * np.minimum(covered, 1))
    sun *= 1 + 0.04 * on["season"] * winter(site, clock(weather.index)[1])
    tilt = np.cos(np.radians(site.surface_tilt))
    rear = 0.7 * albedo * weather["ghi"].to_numpy() * (1 + tilt) / 2  # 0.7: own shade
    rear += weather["dhi"].to_numpy() * (1 - tilt) / 2
    open_back = site.mounting == "rack"
    return sun, REAR_ABSORPTANCE * on["rear_irradiance"] * open_back * rear


def breeze(weather, site, on, calm):
    """Forced convection of both faces: MoWiTT's, and its straight stand-in."""
    around = np.radians(weather["wind_direction"].to_numpy() - site.surface_azimuth)
    facing = on["wind_direction"] * np.cos(around)
    scatter = 0.3 * on["wind_scatter"]
    local = np.exp(scatter * weather["scatter"].to_numpy() - scatter**2 / 2)
    local *= AT_MODULE * weather["wind_speed"].to_numpy()
    local *= np.maximum(1 + SHELTER * facing, 0.0)
    speed, facing = np.array([local, local]), np.array([facing, -facing])
    luff = 0.5 + 0.5 * facing  # share of windward
    if site.mounting == "roof":
        along = np.abs(np.cos(around)) - 2 / np.pi  # less its mean over directions
        share = np.maximum(2 / np.pi + on["wind_direction"] * along, 0.0)
        speed[1] *= CHANNEL * share
        facing[1] = luff[1] = 0.0
    forced = luff * mowitt(speed, WINDWARD) + (1 - luff) * mowitt(speed, LEEWARD)
    meet = (mowitt(MEET, WINDWARD) + mowitt(MEET, LEEWARD)) / 2
    rise = (np.hypot(calm, meet) - calm) / MEET
    return forced, (1 - on["wind_shape"]) * rise * speed * (1 + 0.5 * facing)


def mowitt(speed, face):
    return face[0] * speed ** face[1]


def natural(tilt):
    """TARP's coefficient of |ΔT|^(1/3): faces × (warmer, colder than the air)."""
    freely, stably = 9.482 / (7.283 - abs(tilt)), 1.81 / (1.382 + abs(tilt))
    return np.array([[freely, stably], [stably, freely]])[:, :, None]


def wet_bulb(celsius, humidity):
    """Stull's fit [6]_. [°C]"""
    return (
        celsius * np.arctan(0.151977 * np.sqrt(humidity + 8.313659))
        + np.arctan(celsius + humidity)
        - np.arctan(humidity - 1.676331)
        + 0.00391838 * humidity**1.5 * np.arctan(0.023101 * humidity)
        - 4.686035
    )


def forcing(weather, site, on):
    """All that acts on the module and does not depend on its temperature."""
    celsius, step = weather["temp_air"].to_numpy(), seconds(weather.index)
    ghi, air = weather["ghi"].to_numpy(), celsius + ZERO
    tilt, rack = np.cos(np.radians(site.surface_tilt)), site.mounting == "rack"
    covered, albedo = on["snow"] * snowpack(weather)[1], bright(weather, site, on)
    sun, rear = light(weather, site, on, covered, albedo)

    # output is constant + slope·T_cell, with T in kelvin
    full = EFFICIENCY * sun * (1 - on["electrical_output"] * curtailed(weather))
    low = on["conversion"] * LOW_LIGHT * np.log(np.clip(sun, 10.0, None) / 1000.0)
    slope = on["conversion"] * GAMMA * full
    # longwave: all exchange is with black surroundings at air temperature; what
    # the sky is colder than that is a sink that the module does not change
    black = SIGMA * air**4
    cold = on["sky_radiation"] * (black - weather["longwave_down"].to_numpy())
    to_sky = np.array([[(1 + tilt) / 2], [(1 - tilt) / 2 if rack else 0.0]])
    to_ground = np.array([[(1 - tilt) / 2], [(1 + tilt) / 2 if rack else 1.0]])
    front, back = undeclared(weather.index, celsius, on)
    heat = np.array([IN_GLASS * sun + front, rear + back])
    # rain is at the wet-bulb temperature, snow not above 0 °C
    fluid = weather["precipitation"].to_numpy() * (celsius >= SNOW_BELOW) / 3600.0
    shed, held = on["rain"] * HEAT_OF_WATER * fluid, SNOW_CONTACT * covered
    wet = wet_bulb(celsius, weather["relative_humidity"].to_numpy()) + ZERO
    calm = natural(tilt)[:, 0] * CALM_EXCESS ** (1 / 3)
    forced, straight = breeze(weather, site, on, calm)
    ground = SURFACE[site.mounting]
    # the ground gains this, less what it would lose if its air were at 0 K
    lit = ground["lit"] * (1 - albedo) * ghi + ground["loss"] * air
    lit += TO_DEEP * lagged(air, 3 * DAY / step)
    lit += GROUND_EMISSIVITY * (1 - ground["module"]) * (black - cold)
    surfaces = dict(view=EMISSIVITY * SIGMA * to_ground, natural=natural(tilt))
    series = dict(
        air=air,
        heat=heat - EMISSIVITY * to_sky * cold,
        cell=IN_CELL * sun,
        output=full * (1 + low) - slope * (25.0 + ZERO),
        slope=slope,
        forced=forced**2,
        straight=straight,
        drain=shed + held,
        cooler=shed * wet + held * np.minimum(air, ZERO),
        vapour=vapour(weather["temp_dew"].to_numpy()),
        capture=fluid * (on["rain"] > 0),
        lit=lit,
    )
    return surfaces | ground | dict(calm=calm), series
