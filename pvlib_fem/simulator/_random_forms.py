"""Random formulations of a site, and obstacles on the path of the sun."""

import numpy as np
import pandas as pd

from pvlib_fem.simulator._constants import random_stream
from pvlib_fem.simulator._site import RHINE, Site
from pvlib_fem.simulator._submodels import RIVALS, Days, Forms, Minutes, Obstacle
from pvlib_fem.simulator._synthetic_weather import sun_position

LOW_SUN, HIGH_SUN = 8.0, 40.0  # °, range of an obstacle's edge
DAY = 1440  # min


def drawn(seed: int, site: Site = RHINE) -> Forms:
    """
    Random formulations, each equally likely; they depend on seed and site only.

    Parameters
    ----------
    seed : int
        Of the random numbers.
    site : Site
        Site on whose sun path the obstacles are.

    Returns
    -------
    Forms

    Examples
    --------
    >>> site = Site(forms=drawn(1))
    """
    random = random_stream(seed, "forms")
    names = {law: str(random.choice(rivals)) for law, rivals in RIVALS.items()}
    return Forms(
        obstacles=draw_obstacles(random, site),
        washed_by=(random.uniform(0.5, 8.0), random.uniform(1.0, 24.0)),
        calm_excess=random.uniform(8.0, 25.0),
        watering=draw_water_days(random),
        fan=draw_minutes(random),
        **names,
    )


def draw_obstacles(random: np.random.Generator, site: Site) -> tuple[Obstacle, ...]:
    """One to three obstacles; half of the sites have hard edges and one share."""
    times = pd.date_range("2023-01-01", "2024-01-01", freq="20min", tz=site.tz)
    elevation, azimuth = sun_position(times, site)
    low = np.flatnonzero((elevation > LOW_SUN) & (elevation < HIGH_SUN))
    hard, covers = random.random() < 0.5, random.uniform(0.4, 0.8)
    made = []
    for place in random.choice(low, random.integers(1, 4)):
        height = float(elevation[place]) + random.uniform(2.0, 12.0)
        ragged = random.uniform(0.6, 1.2, random.integers(1, 6))
        made.append(
            Obstacle(
                azimuth=float(azimuth[place]),
                width=random.uniform(10.0, 45.0),
                heights=tuple((height * ragged / ragged.max()).tolist()),
                covers=covers if hard else random.uniform(0.4, 0.8),
                blur=0.0 if hard else random.uniform(1.0, 5.0),
            )
        )
    return tuple(made)


def draw_water_days(random: np.random.Generator) -> Days:
    """Water on one of every 2 to 9 days, for as many hours: 1 h per day on average."""
    every = int(random.integers(2, 10))
    begin = random.uniform(0.0, 24.0 - every)
    return Days(every, int(random.integers(every)), ((begin, begin + every),))


def draw_minutes(random: np.random.Generator) -> Minutes:
    """A fifth to half of a period between 1 and 7 h that does not divide the day."""
    period = int(random.choice([m for m in range(60, 421) if DAY % m]))
    on = round(period * random.uniform(0.2, 0.5))
    return Minutes(on, period, int(random.integers(period)))
